# SPDX-License-Identifier: BSD-3-Clause
"""OFF, the Object File Format of Geomview: text, with comments and optional colours, normals and texture
coordinates, of which only the points and faces are kept."""

import re

import numpy as np

from ..errors import FormatError
from . import text
from .polygons import PolygonMesh

_KEYWORD = re.compile(rb"^(ST)?(C)?(N)?(4)?(n)?OFF$")


def read_off(path):
    """Reads an OFF file. Raises FormatError with file and line, or OSError."""
    with open(path, "rb") as file:
        rows, lines = _content(file.read())
    rows, lines, columns = _without_keyword(path, rows, lines)
    vertices, faces, rows, lines = _without_counts(path, rows, lines)
    if len(rows) < vertices:
        raise FormatError(f"{path}: the file ends after {len(rows)} of {vertices} vertices")
    if len(rows) < vertices + faces:
        raise FormatError(f"{path}: the file ends after {len(rows) - vertices} of {faces} faces")
    if len(rows) > vertices + faces:
        line = lines[vertices + faces]
        raise FormatError(f"{path}:{line}: text after the {vertices} vertices and {faces} faces that are announced")
    points = text.table(path, rows[:vertices], lines[:vertices], columns, "a vertex")[:, :3]
    values, counts = text.numbers(path, rows[vertices:], lines[vertices:])
    first = values[np.cumsum(counts) - counts] if faces else np.zeros(0)
    bad = np.flatnonzero(~((first >= 0) & (first == np.floor(first)) & (first < 2**31)))
    if len(bad):
        raise FormatError(f"{path}:{lines[vertices + bad[0]]}: '{first[bad[0]]:g}' is not a number of points")
    offsets, ids = text.polygons(path, values, counts, lines[vertices:], first.astype(np.int64), 1, vertices)
    return PolygonMesh(points, offsets, ids, {})


def _content(data):
    """The lines without comments, the empty ones left out, and their numbers."""
    rows, lines = [], []
    for number, row in enumerate(data.splitlines(), start=1):
        row = row.split(b"#", 1)[0].strip()
        if row:
            rows.append(row)
            lines.append(number)
    return rows, lines


def _without_keyword(path, rows, lines):
    """Takes the header keyword off; the third value is how many numbers a vertex must have at least."""
    if not rows:
        raise FormatError(f"{path}: an OFF file starts with the word OFF; this one is empty")
    words = rows[0].split(None, 1)
    match = _KEYWORD.match(words[0])
    if not match:
        if words[0].isdigit():  # the keyword is optional
            return rows, lines, 3
        raise FormatError(f"{path}:{lines[0]}: an OFF file starts with the word OFF, COFF, NOFF, CNOFF or STOFF")
    if match.group(4) or match.group(5):
        raise FormatError(f"{path}:{lines[0]}: points of another dimension than 3 ({words[0].decode()}) cannot be read")
    rest = words[1:]
    if rest and rest[0].upper().startswith(b"BINARY"):
        raise FormatError(f"{path}:{lines[0]}: binary OFF cannot be read; save it as text, or as PLY")
    columns = 6 if match.group(3) else 3
    return rest + rows[1:], lines[:1] * len(rest) + lines[1:], columns


def _without_counts(path, rows, lines):
    if not rows:
        raise FormatError(f"{path}: the file ends before the numbers of vertices and faces")
    words = rows[0].split()
    counts = [text.count_of(word) for word in words[:3]]
    if len(words) not in (2, 3) or None in counts:
        raise FormatError(f"{path}:{lines[0]}: expected the numbers of vertices, faces and edges")
    return counts[0], counts[1], rows[1:], lines[1:]


def write_off(mesh, file):
    """Writes the points and polygons of a PolygonMesh to a binary file object."""
    polygons = len(mesh.offsets) - 1
    file.write(b"OFF\n%d %d 0\n" % (len(mesh.points), polygons))
    write_rows(file, mesh.points, b"")
    sizes = np.diff(mesh.offsets)
    if polygons and (sizes == 3).all():
        np.savetxt(file, mesh.connectivity.reshape(-1, 3), fmt="3 %d %d %d")
    else:
        for polygon in np.split(mesh.connectivity, mesh.offsets[1:-1]) if polygons else ():
            file.write(b"%d %s\n" % (len(polygon), " ".join(map(str, polygon.tolist())).encode()))


def write_rows(file, points, prefix):
    """Writes points, or other vectors, so that reading gives the same numbers again: 9 digits for single precision, 17 for
    double."""
    digits = "%.9g" if points.dtype == np.float32 else "%.17g"
    np.savetxt(file, points, fmt=prefix.decode() + " ".join([digits] * points.shape[1]))
