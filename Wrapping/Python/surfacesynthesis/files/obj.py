# SPDX-License-Identifier: BSD-3-Clause
"""Wavefront OBJ: the points and faces; texture coordinates, normals, groups and materials are not kept."""

import re

import numpy as np

from ..errors import FormatError
from . import text
from .off import write_rows
from .polygons import PolygonMesh

_AFTER_SLASH = re.compile(rb"/\S*")


def read_obj(path):
    """Reads an OBJ file. Raises FormatError with file and line, or OSError."""
    points, point_lines, faces, face_lines, seen = [], [], [], [], []
    with open(path, "rb") as file:
        data = file.read()
    if b"\0" in data:
        raise FormatError(f"{path}: this is not an OBJ file: it holds binary data")
    for number, row in _rows(data):
        keyword, _, rest = row.partition(b" ")
        if keyword == b"v":
            points.append(rest)
            point_lines.append(number)
        elif keyword == b"f":
            faces.append(_AFTER_SLASH.sub(b"", rest))
            face_lines.append(number)
            seen.append(len(points))
    if not points:
        raise FormatError(f"{path}: no vertex found; this is not an OBJ file, or an empty one")
    coordinates = text.table(path, points, point_lines, 3, "a vertex")
    values, counts = text.numbers(path, faces, face_lines)
    zero = np.flatnonzero(values == 0)
    if len(zero):
        line = face_lines[int(np.searchsorted(np.cumsum(counts), zero[0], side="right"))]
        raise FormatError(f"{path}:{line}: a face names point 0; OBJ counts from 1")
    # positive numbers count from 1, negative ones backwards from the vertex last read
    ids = np.where(values > 0, values - 1, values + np.repeat(np.array(seen, dtype=np.float64), counts))
    offsets, connectivity = text.polygons(path, ids, counts, face_lines, counts, 0, len(points), values, 1)
    return PolygonMesh(coordinates, offsets, connectivity, {})


def _rows(data):
    """Line numbers and lines, without comments, with continued lines joined."""
    held, first = b"", 0
    for number, row in enumerate(data.splitlines(), start=1):
        row = row.split(b"#", 1)[0].strip()
        if row.endswith(b"\\"):
            held, first = held + row[:-1] + b" ", first or number
            continue
        if held:
            row, held = held + row, b""
        if row:
            yield first or number, row.replace(b"\t", b" ")
        first = 0
    if held:
        yield first, held


def write_obj(mesh, file):
    """Writes the points and polygons of a PolygonMesh to a binary file object."""
    write_rows(file, mesh.points, b"v ")
    polygons = len(mesh.offsets) - 1
    ids = mesh.connectivity + 1
    if polygons and (np.diff(mesh.offsets) == 3).all():
        np.savetxt(file, ids.reshape(-1, 3), fmt="f %d %d %d")
    else:
        for polygon in np.split(ids, mesh.offsets[1:-1]) if polygons else ():
            file.write(b"f %s\n" % " ".join(map(str, polygon.tolist())).encode())
