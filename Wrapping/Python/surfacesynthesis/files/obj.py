# SPDX-License-Identifier: BSD-3-Clause
"""Wavefront OBJ: points, faces, texture coordinates ("TCoords"), normals ("Normals"), and colors behind the coordinates
("RGB"). Groups and materials are not kept; materials.py reads their textures."""

import re

import numpy as np

from ..errors import FormatError
from . import text
from .corners import with_normals, with_texture
from .off import write_rows
from .polygons import PolygonMesh

_WORD = rb"[^\s/]+"
#: Forms of the corners of a face, v/t/n, v//n, v/t and v, and what makes three numbers of each corner.
_FORMS = [
    (re.compile(rb"%s/%s/%s(?:\s+%s/%s/%s)*" % (6 * (_WORD,))), lambda row: row.replace(b"/", b" ")),
    (re.compile(rb"%s//%s(?:\s+%s//%s)*" % (4 * (_WORD,))), lambda row: row.replace(b"//", b" 0 ")),
    (re.compile(rb"%s/%s(?:\s+%s/%s)*" % (4 * (_WORD,))), lambda row: re.sub(rb"/(\S+)", rb" \1 0", row)),
    (re.compile(rb"%s(?:\s+%s)*" % (2 * (_WORD,))), lambda row: re.sub(rb"(\S+)", rb"\1 0 0", row)),
]
_COLUMNS = {b"v": (3, "a vertex"), b"vt": (2, "a texture coordinate"), b"vn": (3, "a normal")}


def read_obj(path, seams="join"):
    """Reads an OBJ file; ``seams`` as for with_texture(). Raises FormatError with file and line, or OSError."""
    with open(path, "rb") as file:
        data = file.read()
    if b"\0" in data:
        raise FormatError(f"{path}: this is not an OBJ file: it holds binary data")
    rows = {keyword: [] for keyword in (*_COLUMNS, b"f")}
    lines = {keyword: [] for keyword in rows}
    seen = []  # the numbers of v, vt and vn before a face
    for number, row in _rows(data):
        keyword, _, rest = row.partition(b" ")
        if keyword == b"f":
            seen.append([len(rows[key]) for key in _COLUMNS])
        if keyword in rows:
            rows[keyword].append(rest if keyword != b"vt" else rest + b" 0")  # the second coordinate is optional
            lines[keyword].append(number)
    if not rows[b"v"]:
        raise FormatError(f"{path}: no vertex found; this is not an OBJ file, or an empty one")
    tables = {key: text.table(path, rows[key], lines[key], *wanted) for key, wanted in _COLUMNS.items()}
    corners = _Corners(path, rows[b"f"], lines[b"f"], np.reshape(seen, (-1, 3)))
    offsets, connectivity = corners.points(len(tables[b"v"]))
    mesh = PolygonMesh(tables[b"v"], offsets, connectivity, _colors(rows[b"v"]))
    normals, present = corners.of(2, len(tables[b"vn"]), "normal")
    if present.any():
        mesh = with_normals(mesh, tables[b"vn"][normals], present)
    texture, present = corners.of(1, len(tables[b"vt"]), "texture coordinate")
    return with_texture(path, mesh, tables[b"vt"][texture], present, seams) if present.any() else mesh


def _three_numbers(row):
    """The corners of a face with three numbers each, 0 for what is not there."""
    for form, convert in _FORMS:
        if form.fullmatch(row):
            return convert(row)
    corners = [(word.split(b"/") + [b"", b""])[:3] for word in row.split()]
    return b" ".join(part or b"0" for corner in corners for part in corner)


class _Corners:
    """Numbers of vertices, texture coordinates and normals ([C, 3], 0 where there is none) at the corners of faces."""

    def __init__(self, path, rows, lines, seen):
        self._path, self._lines = path, lines
        if any(b"/" in row for row in rows):
            values, counts = text.numbers(path, [_three_numbers(row) for row in rows], lines)
            self._values, self._counts = values.reshape(-1, 3), counts // 3
        else:
            values, self._counts = text.numbers(path, rows, lines)
            self._values = np.column_stack([values, np.zeros((len(values), 2))])
        # positive numbers count from 1, negative ones backwards from what was last read
        before = np.repeat(seen, self._counts, axis=0)
        self._ids = np.where(self._values > 0, self._values - 1, self._values + before)

    def points(self, number):
        """Offsets and connectivity."""
        written = np.ascontiguousarray(self._values[:, 0])
        zero = np.flatnonzero(written == 0)
        if len(zero):
            raise FormatError(f"{self._path}:{self._line(zero[0])}: a face names point 0; OBJ counts from 1")
        ids = np.ascontiguousarray(self._ids[:, 0])
        return text.polygons(self._path, ids, self._counts, self._lines, self._counts, 0, number, written, 1)

    def of(self, column, number, what):
        """Numbers of the values at the corners, and the corners that have one."""
        present, ids = self._values[:, column] != 0, self._ids[:, column]
        wrong = np.flatnonzero(present & ~((ids >= 0) & (ids < number) & (ids == np.floor(ids))))
        if len(wrong):
            raise FormatError(
                f"{self._path}:{self._line(wrong[0])}: a face names {what} {self._values[wrong[0], column]:g}; "
                f"the file has {number}"
            )
        return np.where(present, ids, 0).astype(np.int64) if number else np.zeros(len(ids), dtype=np.int64), present

    def _line(self, corner):
        return self._lines[int(np.searchsorted(np.cumsum(self._counts), corner, side="right"))]


def _colors(rows):
    """The point array "RGB" (uint8) of vertices with six numbers or seven, the last three from 0 to 1 or to 255."""
    counts = {len(row.split()) for row in rows}
    if len(counts) != 1 or not counts <= {6, 7}:
        return {}
    colors = np.array([row.split()[3:6] for row in rows], dtype=np.float64)
    if not ((colors >= 0) & (colors <= 255)).all():
        return {}
    return {"RGB": np.round(colors * (255 if colors.max() <= 1 else 1)).astype(np.uint8)}


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


def write_obj(mesh, file, library=None):
    """Writes a PolygonMesh to a binary file object, with its arrays "TCoords", "Normals" and "RGB"; with the material
    "texture" of the MTL file ``library`` when one is named."""
    if library is not None:
        file.write(f"mtllib {library}\n".encode())
    points, colors = mesh.points, mesh.arrays.get("RGB")
    if colors is not None and colors.dtype == np.uint8:
        points = np.column_stack([points, colors / points.dtype.type(255)])
    write_rows(file, points, b"v ")
    corner = "%d"
    for name, prefix, size, form in (("TCoords", b"vt ", 2, "%d/%d"), ("Normals", b"vn ", 3, None)):
        values = mesh.arrays.get(name)
        if values is not None and values.shape[1:] == (size,):
            write_rows(file, values, prefix)
            corner = form or {"%d": "%d//%d", "%d/%d": "%d/%d/%d"}[corner]
    if library is not None:
        file.write(b"usemtl texture\n")
    polygons, numbers = len(mesh.offsets) - 1, corner.count("%")
    ids = np.repeat(mesh.connectivity + 1, numbers)
    if polygons and (np.diff(mesh.offsets) == 3).all():
        np.savetxt(file, ids.reshape(-1, 3 * numbers), fmt="f " + " ".join(3 * [corner]))
    else:
        for polygon in np.split(ids, numbers * mesh.offsets[1:-1]) if polygons else ():
            file.write(b"f %s\n" % (" ".join(len(polygon) // numbers * [corner]) % tuple(polygon)).encode())
