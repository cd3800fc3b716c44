# SPDX-License-Identifier: BSD-3-Clause
"""PLY, text or binary, of either byte order. Vertex properties other than x, y, z are point arrays, properties of faces
cell arrays: ``nx, ny, nz`` is "Normals", ``red, green, blue`` is "RGB", ``u, v``, ``s, t`` or ``texture_u, texture_v``
and the list ``texcoord`` of faces are "TCoords", the others keep their names. Other lists and elements are not kept."""

import re
from typing import NamedTuple, Optional

import numpy as np

from ..errors import FormatError
from . import text
from .corners import with_texture
from .polygons import PolygonMesh

_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
    "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "float32": "f4", "float64": "f8",
}  # fmt: skip
_NAMES = {"i1": "char", "u1": "uchar", "i2": "short", "u2": "ushort", "i4": "int", "u4": "uint", "f4": "float",
          "f8": "double"}  # fmt: skip
_GROUPS = [
    ("Normals", ("nx", "ny", "nz")), ("RGBA", ("red", "green", "blue", "alpha")), ("RGB", ("red", "green", "blue")),
    ("RGB", ("diffuse_red", "diffuse_green", "diffuse_blue")), ("TCoords", ("u", "v")), ("TCoords", ("s", "t")), ("TCoords", ("texture_u", "texture_v")),
]  # fmt: skip
#: Words that a line of the header begins with; other lines are left out.
_KEYWORDS = ("format", "element", "property")
#: The key of the line numbers of an element in text.
_LINES = 0


class _Property(NamedTuple):
    name: str
    kind: str  # a NumPy type such as "f4"
    count: Optional[str]  # the type of the length of a list, None for a single value


class _Element(NamedTuple):
    name: str
    count: int
    properties: list

    def lists(self):
        return [p for p in self.properties if p.count is not None]


class _Header(NamedTuple):
    form: str  # ascii, binary_little_endian or binary_big_endian
    elements: list
    size: int  # bytes
    lines: int


def read_ply(path, seams="join"):
    """Reads a PLY file; ``seams`` as for with_texture(). Raises FormatError with file (and line, in text), or OSError."""
    with open(path, "rb") as file:
        data = file.read()
    header = _header(path, data)
    body = _TextBody(path, data, header) if header.form == "ascii" else _BinaryBody(path, data, header)
    found = {element.name: (element, body.read(element)) for element in header.elements}
    body.finish()
    if "vertex" not in found:
        raise FormatError(f"{path}: the file has no element 'vertex'")
    columns = _single(*found["vertex"])
    for axis in "xyz":
        if axis not in columns:
            raise FormatError(f"{path}: the vertices have no property '{axis}'")
    points = np.stack([columns.pop(axis) for axis in "xyz"], axis=1)
    if points.dtype.kind != "f":
        points = points.astype(np.float64)
    if "face" not in found:
        return PolygonMesh(points, np.zeros(1, dtype=np.int64), np.zeros(0, dtype=np.int64), _grouped(columns))
    return _with_faces(path, *found["face"], PolygonMesh(points, None, None, _grouped(columns)), seams)


def _with_faces(path, element, read, mesh, seams):
    """The PolygonMesh with the polygons of the element, their arrays, and their texture coordinates."""
    offsets, ids = _polygons(path, element, read)
    wrong = np.flatnonzero((ids < 0) | (ids >= len(mesh.points)))
    if len(wrong):
        face = np.searchsorted(offsets, wrong[0], side="right") - 1
        raise FormatError(
            f"{path}: face {face} names point {ids[wrong[0]]}; the file has points 0 to {len(mesh.points) - 1}"
        )
    mesh = mesh._replace(offsets=offsets, connectivity=ids, cell_arrays=_grouped(_single(element, read)))
    lengths, values = next((read[p.name] for p in element.lists() if p.name == "texcoord"), (None, None))
    if lengths is None or "TCoords" in mesh.arrays or (lengths != 2 * np.diff(offsets)).any():
        return mesh
    values = values.astype(np.float64).reshape(-1, 2)
    return with_texture(path, mesh, values, np.ones(len(values), dtype=bool), seams)


def _single(element, read):
    """The properties with one value for each item."""
    return {p.name: read[p.name] for p in element.properties if p.count is None}


def _polygons(path, element, read):
    """Offsets and connectivity."""
    names = ("vertex_indices", "vertex_index")
    wanted = next((p.name for p in element.lists() if p.name in names), None)
    if wanted is None:
        raise FormatError(f"{path}: the faces have no list 'vertex_indices'")
    lengths, values = read[wanted]
    lines = read.get(_LINES)
    offsets = np.concatenate(([0], np.cumsum(lengths)))
    broken = np.flatnonzero(~(np.abs(values) < 2**53) | (values != np.floor(values)))
    if values.dtype.kind == "f" and len(broken):
        row = np.searchsorted(offsets, broken[0], side="right") - 1
        where = f"{path}:{lines[row]}" if lines else f"{path}: face {row}"
        raise FormatError(f"{where}: '{values[broken[0]]:g}' is not the number of a point")
    small = np.flatnonzero(lengths < 3)
    if len(small):
        where = f"{path}:{lines[small[0]]}: a face" if lines else f"{path}: face {small[0]}"
        raise FormatError(f"{where} has {lengths[small[0]]} points, fewer than 3")
    return offsets, values.astype(np.int64)


def _grouped(columns):
    """Arrays of properties: normals, colors and texture coordinates become arrays with several components."""
    arrays = dict(columns)
    for group, names in _GROUPS:
        if group not in arrays and all(name in arrays for name in names):
            arrays[group] = np.stack([arrays.pop(name) for name in names], axis=1)
    return arrays


def _header(path, data):
    match = re.search(rb"^end_header[ \t]*(\r\n|\n|\r)", data, re.MULTILINE) if data[:3] == b"ply" else None
    if data[:3] != b"ply":
        raise FormatError(f"{path}:1: a PLY file starts with the word ply")
    if match is None:
        match = re.search(rb"\rend_header[ \t]*\r", data)
    if match is None:
        raise FormatError(f"{path}: the PLY header has no end_header")
    form, elements = None, []
    lines = data[: match.start()].decode("latin-1").splitlines()
    for number, line in enumerate(lines[1:], start=2):
        words = line.split()
        if not words:
            continue
        if words[0] == "format" and len(words) == 3:
            form = words[1]
        elif words[0] == "element" and len(words) == 3 and text.count_of(words[2]) is not None:
            elements.append(_Element(words[1], int(words[2]), []))
        elif words[0] == "property" and elements:
            elements[-1].properties.append(_property(path, number, words))
        elif words[0] in _KEYWORDS:
            raise FormatError(f"{path}:{number}: '{line.strip()[:60]}' is not understood in a PLY header")
    if form not in ("ascii", "binary_little_endian", "binary_big_endian"):
        raise FormatError(f"{path}: the PLY header has no valid format line")
    return _Header(form, elements, match.end(), len(lines) + 1)


def _property(path, number, words):
    if len(words) == 3 and words[1] in _TYPES:
        return _Property(words[2], _TYPES[words[1]], None)
    if len(words) == 5 and words[1] == "list" and words[2] in _TYPES and words[3] in _TYPES:
        return _Property(words[4], _TYPES[words[3]], _TYPES[words[2]])
    raise FormatError(f"{path}:{number}: '{' '.join(words)[:60]}' is not a PLY property")


class _TextBody:
    """Reads elements one after the other from a text file, one row for each item."""

    def __init__(self, path, data, header):
        self._path = path
        rows = [row.strip() for row in data[header.size :].splitlines()]
        self._rows = [row for row in rows if row]
        self._lines = [header.lines + k for k, row in enumerate(rows, start=1) if row]
        self._next = 0

    def _take(self, element):
        start, self._next = self._next, self._next + element.count
        if self._next > len(self._rows):
            found = len(self._rows) - start
            raise FormatError(f"{self._path}: the file ends after {found} of {element.count} elements '{element.name}'")
        return self._rows[start : self._next], self._lines[start : self._next]

    def read(self, element):
        """By the names of properties, the values of all items, for lists with their lengths in front; and the lines."""
        rows, lines = self._take(element)
        if not element.lists():
            values = text.table(self._path, rows, lines, len(element.properties), f"an element '{element.name}'")
            return {p.name: values[:, k].astype(p.kind) for k, p in enumerate(element.properties)}
        values, counts = text.numbers(self._path, rows, lines)
        position, remaining = np.cumsum(counts) - counts, counts
        read = {_LINES: lines}
        for item in element.properties:  # each in all rows at once
            step = self._step(values, position, remaining, lines, item)
            begin = position if item.count is None else position + 1
            lengths = step - (begin - position)
            offsets = np.cumsum(lengths) - lengths
            found = values[np.repeat(begin - offsets, lengths) + np.arange(lengths.sum())]
            read[item.name] = found.astype(item.kind) if item.count is None else (lengths, found)
            position, remaining = position + step, remaining - step
        return read

    def _step(self, values, position, remaining, lines, item):
        """The number of numbers of a property in each row."""
        if item.count is None:
            needed = np.ones(len(position), dtype=np.int64)
            what = "its properties"
        else:
            needed = 1 + self._list_lengths(values, position, remaining, lines)
            what = "its list announces"
        short = np.flatnonzero(remaining < needed)
        if len(short):
            raise FormatError(f"{self._path}:{lines[short[0]]}: a face has fewer numbers than {what}")
        return needed

    def _list_lengths(self, values, position, remaining, lines):
        short = np.flatnonzero(remaining < 1)
        if len(short):
            raise FormatError(f"{self._path}:{lines[short[0]]}: a face has fewer numbers than its properties")
        lengths = values[position] if len(position) else np.zeros(0)
        bad = np.flatnonzero(~((lengths >= 0) & (lengths < 2**31) & (lengths == np.floor(lengths))))
        if len(bad):
            raise FormatError(f"{self._path}:{lines[bad[0]]}: '{lengths[bad[0]]:g}' is not a number of points")
        return lengths.astype(np.int64)

    def finish(self):
        if self._next < len(self._rows):
            raise FormatError(f"{self._path}:{self._lines[self._next]}: text after the elements that are announced")


class _BinaryBody:
    """Reads elements one after the other from the bytes of a binary file."""

    def __init__(self, path, data, header):
        self._path = path
        self._data = data
        self._next = header.size
        self._order = "<" if header.form == "binary_little_endian" else ">"

    def _take(self, kind, count, element):
        size = kind.itemsize * count
        if size > len(self._data) - self._next:
            raise FormatError(f"{self._path}: the file ends within the {element.count} elements '{element.name}'")
        values = np.frombuffer(self._data, dtype=kind, count=count, offset=self._next)
        self._next += size
        return values

    def _kind(self, properties, lengths):
        """The NumPy type of one item whose lists have the given lengths."""
        fields = []
        for k, item in enumerate(properties):
            if item.count is None:
                fields.append((f"p{k}", self._order + item.kind))
            else:
                fields.append((f"n{k}", self._order + item.count))
                fields.append((f"p{k}", self._order + item.kind, (lengths[k],)))
        return np.dtype(fields)

    def read(self, element):
        """By the names of properties, the values of all items, for lists with their lengths in front."""
        if not element.lists():
            values = self._take(self._kind(element.properties, {}), element.count, element)
            return {p.name: values[f"p{k}"].astype(p.kind) for k, p in enumerate(element.properties)}
        runs = list(self._runs(element))
        read = {}
        for k, item in enumerate(element.properties):
            empty = [np.zeros(0, dtype=item.kind)]
            values = np.concatenate([run[f"p{k}"].astype(item.kind).reshape(-1) for run in runs] or empty)
            if item.count is not None:
                lengths = [np.full(len(run), run.dtype[f"p{k}"].shape[0], dtype=np.int64) for run in runs]
                values = (np.concatenate(lengths or [np.zeros(0, dtype=np.int64)]), values)
            read[item.name] = values
        return read

    def _runs(self, element):
        """The items, in arrays of those whose lists have the same lengths (nearly always: all triangles)."""
        done, chunk = 0, 64
        while done < element.count:
            kind = self._kind(element.properties, self._lengths_of_next(element))
            if kind.itemsize == 0:
                raise FormatError(f"{self._path}: the elements '{element.name}' have no size")
            most = min(chunk, element.count - done, (len(self._data) - self._next) // kind.itemsize)
            block = np.frombuffer(self._data, dtype=kind, count=most, offset=self._next)
            same = np.ones(most, dtype=bool)
            for k, item in enumerate(element.properties):
                if item.count is not None:
                    same &= block[f"n{k}"] == kind[f"p{k}"].shape[0]
            run = most if same.all() else int(np.argmin(same))
            if run == 0:
                raise FormatError(f"{self._path}: the file ends within the {element.count} elements '{element.name}'")
            yield block[:run]
            self._next += run * kind.itemsize
            done += run
            chunk = 2 * chunk if run == most else 64

    def _lengths_of_next(self, element):
        lengths, position = {}, self._next
        for k, item in enumerate(element.properties):
            number = 1
            if item.count is not None:
                kind = np.dtype(self._order + item.count)
                if position + kind.itemsize > len(self._data):
                    break
                number = np.frombuffer(self._data, dtype=kind, count=1, offset=position)[0].item()
                if not 0 <= number < 2**53 or number % 1 != 0:
                    raise FormatError(f"{self._path}: a list in the elements '{element.name}' has {number} values")
                lengths[k] = number = int(number)
                position += kind.itemsize
            position += number * np.dtype(item.kind).itemsize
        if position > len(self._data) or len(lengths) < len(element.lists()):
            raise FormatError(f"{self._path}: the file ends within the {element.count} elements '{element.name}'")
        return lengths

    def finish(self):
        """Bytes after the last element are allowed: some programs pad their files."""


def write_ply(mesh, file, texture=None):
    """Writes a PolygonMesh to a binary file object, as binary PLY with all its point arrays as vertex properties; with a
    comment that names the file of a texture when there is one."""
    fields = [(axis, _kind_to_write(mesh.points)) for axis in "xyz"]
    columns = [mesh.points[:, k] for k in range(3)]
    for name, values in mesh.arrays.items():
        values = values.reshape(len(mesh.points), -1)
        for property_name, column in zip(_property_names(name, values.shape[1]), values.T):
            taken = {field for field, _ in fields}
            while property_name in taken:
                property_name += "_"
            fields.append((property_name, _kind_to_write(values)))
            columns.append(column)
    vertices = np.zeros(len(mesh.points), dtype=[(name, "<" + kind) for name, kind in fields])
    for (name, _), column in zip(fields, columns):
        vertices[name] = column
    header = ["ply", "format binary_little_endian 1.0"]
    header += [] if texture is None else [f"comment TextureFile {texture}"]
    header += [f"element vertex {len(vertices)}"]
    header += [f"property {_NAMES[kind]} {name}" for name, kind in fields]
    sizes = np.diff(mesh.offsets)
    length = "uchar" if len(sizes) == 0 or sizes.max() < 256 else "int"
    header += [f"element face {len(sizes)}", f"property list {length} int vertex_indices", "end_header", ""]
    file.write("\n".join(header).encode("ascii", "replace"))
    file.write(vertices.tobytes())
    count_kind = "<" + _TYPES[length]
    if len(sizes) and (sizes == sizes[0]).all():
        faces = np.zeros(len(sizes), dtype=[("n", count_kind), ("ids", "<i4", (sizes[0],))])
        faces["n"] = sizes[0]
        faces["ids"] = mesh.connectivity.reshape(-1, sizes[0])
        file.write(faces.tobytes())
    else:
        for polygon in np.split(mesh.connectivity, mesh.offsets[1:-1]) if len(sizes) else ():
            file.write(np.array([len(polygon)], dtype=count_kind).tobytes() + polygon.astype("<i4").tobytes())


def _kind_to_write(values):
    """The PLY type that holds the values: 64-bit integers, which PLY lacks, become doubles."""
    kind = values.dtype.kind + str(values.dtype.itemsize)
    return kind if kind in _NAMES else "f8"


def _property_names(name, components):
    names = next((names for group, names in _GROUPS if group == name and len(names) == components), None)
    if names is not None:
        return list(names)
    name = re.sub(r"\s+", "_", name.strip()) or "array"
    return [name] if components == 1 else [f"{name}_{k}" for k in range(components)]
