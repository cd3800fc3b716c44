# SPDX-License-Identifier: BSD-3-Clause
"""glTF 2.0, as text (.gltf) or binary (.glb): the triangles of its scene with normals ("Normals"), texture coordinates
("TCoords"; the second one turned round, as glTF counts downwards), colors ("RGB", "RGBA") and attributes of other names.

vtkGLTFReader ends the process at counts, offsets and indices that are wrong; checking them all decodes the file. Of
materials the picture of the base color can be read and written; skins and animations are not kept.
"""

import base64
import binascii
import json
import os
import struct

import numpy as np

from ..errors import FormatError
from .polygons import mesh_of_triangles

_KINDS = {5120: "i1", 5121: "u1", 5122: "i2", 5123: "u2", 5125: "u4", 5126: "f4"}
_TYPES = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
_POINTS, _TRIANGLES, _STRIP, _FAN = 0, 4, 5, 6
_VERTICES, _INDICES = 34962, 34963
_LINEAR, _CLAMP = 9729, 33071
#: Levels of nodes, and the points that a scene may have beyond one for each byte: a mesh may stand in it many times.
_DEEPEST, _MOST_POINTS = 100, 1 << 24
_DATA = "data:"


def read_gltf(path):
    """The triangles of a file as pairs of a name and a PolygonMesh. Raises FormatError or OSError."""
    return list(_Scene(path).meshes())


def read_textured_gltf(path):
    """The pairs of read_gltf(), and for each of them its texture: the bytes of a picture, or the color (three numbers from 0
    to 1, as displays show them) of a material without one. None instead of the textures when there is no picture."""
    scene = _Scene(path)
    meshes = list(scene.meshes())
    return meshes, scene.textures()


def _loaded(path):
    """The JSON document, and the binary chunk or None."""
    with open(path, "rb") as file:
        data = file.read()
    binary = None
    if data[:4] == b"glTF":
        chunks = _chunks(path, data)
        data, binary = chunks.get(b"JSON", b""), chunks.get(b"BIN\0", b"")
    try:
        document = json.loads(data)
    except (ValueError, RecursionError):
        raise FormatError(f"{path}: this is no glTF file: it holds no JSON") from None
    asset = document.get("asset") if isinstance(document, dict) else None
    if not isinstance(asset, dict) or not str(asset.get("version")).startswith("2."):
        raise FormatError(f"{path}: this is no glTF file of version 2")
    if document.get("extensionsRequired"):
        needed = str(document["extensionsRequired"])[:80]
        raise FormatError(f"{path}: the file requires extensions: {needed}; none is known")
    return document, binary


def _chunks(path, data):
    chunks, position = {}, 12
    if len(data) < 12 or struct.unpack_from("<I", data, 8)[0] > len(data):
        raise FormatError(f"{path}: the file is cut off")
    while position + 8 <= len(data):
        length, kind = struct.unpack_from("<I4s", data, position)
        if length > len(data) - position - 8:
            raise FormatError(f"{path}: the file is cut off")
        chunks.setdefault(kind, data[position + 8 : position + 8 + length])
        position += 8 + length
    return chunks


class _Scene:
    """The scene of a document; every number in it is checked when it is used."""

    def __init__(self, path):
        self._path = path
        self._document, self._binary = _loaded(path)
        self._buffers = {}
        self._visited = set()
        self._materials = []  # of the meshes that were read
        self._points_left = _MOST_POINTS + os.path.getsize(path)

    def meshes(self):
        """Pairs of the name of a mesh and its PolygonMesh, node by node."""
        for index in self._list(self._item("scenes", self._document.get("scene", 0)), "nodes"):
            yield from self._node(index, np.eye(4), 0)

    def textures(self):
        """The bytes of the base color textures of the meshes that were read, or their colors; None without a texture."""
        known = {material: None if material is None else self._picture_of(material) for material in set(self._materials)}
        pictures = {index: self._bytes_of_picture(index) for index in set(known.values()) if index is not None}
        if not pictures:
            return None
        return [
            self._color_of(material) if known[material] is None else pictures[known[material]]
            for material in self._materials
        ]

    def _color_of(self, material):
        """The base color of a material, from linear values to those of sRGB images; white without a material."""
        if material is None:
            return (1.0, 1.0, 1.0)
        factors = self._object(self._item("materials", material), "pbrMetallicRoughness")
        linear = np.clip(self._numbers(factors, "baseColorFactor", [1.0, 1.0, 1.0, 1.0])[:3], 0.0, 1.0)
        return tuple(np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055).tolist())

    def _bytes_of_picture(self, index):
        image = self._item("images", index)
        if "bufferView" not in image:
            return self._resource(image, "image", index)
        view = self._item("bufferViews", image["bufferView"])
        data = self._buffer(self._size(view, "buffer"))
        begin, length = self._size(view, "byteOffset", 0), self._size(view, "byteLength")
        if length > len(data) - begin:
            raise self._error(f"the image {index} does not lie within its buffer; the file is cut off or damaged")
        return bytes(data[begin : begin + length])

    def _picture_of(self, index):
        """The image of the base color of a material; None without one."""
        color = self._object(self._item("materials", index), "pbrMetallicRoughness")
        if "baseColorTexture" not in color:
            return None
        texture = self._object(color, "baseColorTexture")
        if texture.get("texCoord", 0) != 0 or "KHR_texture_transform" in self._object(texture, "extensions"):
            raise self._error("a texture has other texture coordinates than the first ones; this is not known")
        return self._size(self._item("textures", texture.get("index")), "source")

    def _object(self, item, key):
        if not isinstance(item.get(key, {}), dict):
            raise self._error(f"the {key} is no object")
        return item.get(key, {})

    def _error(self, text):
        return FormatError(f"{self._path}: {text}")

    def _item(self, key, index):
        items = self._list(self._document, key)
        if type(index) is not int or not 0 <= index < len(items) or not isinstance(items[index], dict):
            raise self._error(f"'{str(index)[:20]}' is none of its {len(items)} {key}")
        return items[index]

    def _list(self, item, key):
        if not isinstance(item.get(key, []), list):
            raise self._error(f"the {key} are no list")
        return item.get(key, [])

    def _size(self, item, key, default=None):
        number = item.get(key, default)
        if type(number) is not int or not 0 <= number < 2**53:
            raise self._error(f"the {key} '{str(number)[:20]}' is no size")
        return number

    def _numbers(self, item, key, default):
        try:
            numbers = np.array(item.get(key, default), dtype=np.float64)
        except (TypeError, ValueError, OverflowError):
            numbers = np.zeros(0)
        if numbers.shape != np.shape(default) or not np.isfinite(numbers).all():
            raise self._error(f"the {key} is not {len(default)} finite numbers")
        return numbers

    def _node(self, index, above, depth):
        node = self._item("nodes", index)
        if depth > _DEEPEST or index in self._visited:
            raise self._error(f"the nodes are no tree of at most {_DEEPEST} levels")
        self._visited.add(index)
        matrix = above @ self._matrix(node)
        if "mesh" in node:
            mesh = self._item("meshes", node["mesh"])
            for primitive in self._list(mesh, "primitives"):
                if not isinstance(primitive, dict) or not isinstance(primitive.get("attributes"), dict):
                    raise self._error("a part of a mesh has no attributes")
                if primitive.get("mode", _TRIANGLES) in (_TRIANGLES, _STRIP, _FAN):  # others are points and lines
                    material = primitive.get("material")
                    self._materials.append(material if material is None or type(material) is int else -1)
                    yield str(mesh.get("name", f"Mesh {node['mesh']}")), self._primitive(primitive, matrix)
        for child in self._list(node, "children"):
            yield from self._node(child, matrix, depth + 1)

    def _matrix(self, node):
        if "matrix" in node:
            return self._numbers(node, "matrix", list(np.eye(4).ravel())).reshape(4, 4).T
        x, y, z, w = self._numbers(node, "rotation", [0.0, 0.0, 0.0, 1.0])
        matrix = np.eye(4)
        matrix[:3, :3] = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
        matrix[:3, :3] *= self._numbers(node, "scale", [1.0, 1.0, 1.0])
        matrix[:3, 3] = self._numbers(node, "translation", [0.0, 0.0, 0.0])
        return matrix

    def _primitive(self, primitive, matrix):
        attributes = primitive["attributes"]
        points = self._accessor(attributes.get("POSITION"))
        self._points_left -= len(points)
        if self._points_left < 0:
            raise self._error("the scene repeats its meshes so often that it has too many points")
        ids = np.arange(len(points))
        if "indices" in primitive:
            ids = self._accessor(primitive["indices"])
            if ids.dtype.kind != "u" or ids.ndim != 1 or ids.max(initial=0) >= len(points):
                raise self._error(f"the indices of a part of a mesh are none of its {len(points)} points")
            ids = ids.astype(np.int64)
        if points.shape[1:] != (3,):
            raise self._error("points have three coordinates")
        triangles = _triangles(ids, primitive.get("mode", _TRIANGLES))
        if np.linalg.det(matrix[:3, :3]) < 0:
            triangles = triangles[:, ::-1]
        mesh = mesh_of_triangles((points @ matrix[:3, :3].T + matrix[:3, 3]).astype(np.float32), triangles)
        for name, index in attributes.items():
            if name in ("NORMAL", "TEXCOORD_0", "COLOR_0") or name[:1] == "_":
                values = self._accessor(index)
                if len(values) != len(points):
                    raise self._error(f"{name[:40]} has {len(values)} values for {len(points)} points")
                mesh.arrays.update([_array(name, values, matrix[:3, :3])])
        return mesh

    def _accessor(self, index):
        """The values [N] or [N, C], of normalized integers as fractions."""
        accessor = self._item("accessors", index)
        kind, size = _KINDS.get(accessor.get("componentType")), _TYPES.get(str(accessor.get("type")))
        if kind is None or size is None or "bufferView" not in accessor or "sparse" in accessor:
            raise self._error("values that are sparse, compressed, matrices or of an unknown type cannot be read")
        view = self._item("bufferViews", accessor["bufferView"])
        data = self._buffer(self._size(view, "buffer"))
        count, kind = self._size(accessor, "count"), np.dtype("<" + kind)
        stride = self._size(view, "byteStride", 0) or size * kind.itemsize
        begin, offset = self._size(view, "byteOffset", 0), self._size(accessor, "byteOffset", 0)
        needed = offset + stride * (count - 1) + size * kind.itemsize
        available = min(self._size(view, "byteLength"), len(data) - begin)
        if count < 1 or stride < size * kind.itemsize or needed > available:
            raise self._error(f"{count} values do not lie within their buffer; the file is cut off or damaged")
        values = np.ndarray((count, size), kind, data, begin + offset, (stride, kind.itemsize))
        if accessor.get("normalized") is True and kind.kind != "f":
            values = np.maximum(values / np.float32(np.iinfo(kind).max), np.float32(-1))
        return values[:, 0] if size == 1 else values

    def _buffer(self, index):
        if index not in self._buffers:
            self._buffers[index] = self._loaded_buffer(index)
        return self._buffers[index]

    def _loaded_buffer(self, index):
        buffer = self._item("buffers", index)
        if buffer.get("uri") is None and index == 0 and self._binary is not None:
            return self._binary
        return self._resource(buffer, "buffer", index)

    def _resource(self, item, what, index):
        """The bytes of a buffer or image with a uri."""
        uri = item.get("uri")
        if not isinstance(uri, str):
            raise self._error(f"the {what} {index} is missing")
        if uri.startswith(_DATA):
            try:
                return base64.b64decode(uri.partition(",")[2], validate=True)
            except (binascii.Error, ValueError):
                raise self._error(f"the {what} {index} is damaged") from None
        name = os.path.join(os.path.dirname(self._path), uri)
        if not uri or uri in (".", "..") or os.path.basename(uri) != uri or "%" in uri or "\0" in uri:
            raise self._error(f"the {what} {index} is '{uri[:60]}'; a file in the same folder is needed")
        if not os.path.isfile(name):
            raise self._error(f"the file {uri[:60]} with {'a buffer' if what == 'buffer' else 'an image'} is missing, or no regular file")
        self._points_left += os.path.getsize(name)
        with open(name, "rb") as file:
            return file.read(self._size(item, "byteLength") if what == "buffer" else -1)


def _triangles(ids, mode):
    if mode == _TRIANGLES:
        return ids[: len(ids) // 3 * 3].reshape(-1, 3)
    if mode == _FAN:
        return np.column_stack([np.broadcast_to(ids[:1], len(ids[2:])), ids[1:-1], ids[2:]])
    triangles = np.column_stack([ids[:-2], ids[1:-1], ids[2:]])
    triangles[1::2] = triangles[1::2, [1, 0, 2]]
    return triangles


def _array(name, values, matrix):
    """Name and values of the point array for an attribute."""
    if name == "NORMAL" and values.shape[1:] == (3,):
        normals = values @ np.linalg.pinv(matrix)
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        return "Normals", np.divide(normals, length, out=np.zeros_like(normals), where=length > 0)
    if name == "TEXCOORD_0" and values.shape[1:] == (2,):
        return "TCoords", np.column_stack([values[:, 0], 1 - values[:, 1]])
    if name == "COLOR_0" and values.ndim == 2 and values.shape[1] in (3, 4):
        colors = np.round(255 * np.clip(np.nan_to_num(values), 0, 1)).astype(np.uint8)
        return ("RGB", colors[:, :3]) if (colors[:, 3:] == 255).all() else ("RGBA", colors)
    return name.removeprefix("_"), values


def write_gltf(meshes, file, binary, png=None):
    """Writes pairs of a name and a PolygonMesh of triangles to a binary file object: points, "Normals", "TCoords", "RGB" or
    "RGBA", and arrays of up to four components under their names behind an underscore, in single precision; ``png``, the
    bytes of a PNG file, as their base color."""
    writer = _Buffer()
    parts = [{"name": name, "primitives": [writer.add_mesh(mesh)]} for name, mesh in meshes if len(mesh.points)]
    document = {"asset": {"version": "2.0", "generator": "SurfaceSynthesis"}}
    if parts:  # empty lists are not allowed
        places = range(len(parts))
        document |= {
            "scene": 0, "scenes": [{"nodes": list(places)}], "nodes": [{"mesh": place} for place in places],
            "meshes": parts, "accessors": writer.accessors, "bufferViews": writer.views,
            "buffers": [{}],
        }  # fmt: skip
        if png is not None:
            document |= _material(writer.add_bytes(png))
            for part in parts:
                part["primitives"][0]["material"] = 0
        document["buffers"][0]["byteLength"] = len(writer.data)
    if not binary and parts:
        encoded = base64.b64encode(writer.data).decode()
        document["buffers"][0]["uri"] = f"{_DATA}application/octet-stream;base64,{encoded}"
    text = json.dumps(document).encode()
    if not binary:
        file.write(text)
        return
    text += b" " * (-len(text) % 4)
    length = 12 + 8 + len(text) + 8 + len(writer.data)
    file.write(struct.pack("<4sII", b"glTF", 2, length) + struct.pack("<I4s", len(text), b"JSON") + text)
    file.write(struct.pack("<I4s", len(writer.data), b"BIN\0") + bytes(writer.data))


def _material(view):
    """The objects of a material whose base color is the PNG picture in a buffer view: no highlights, both sides."""
    color = {"baseColorTexture": {"index": 0}, "metallicFactor": 0.0, "roughnessFactor": 1.0}
    return {
        "images": [{"bufferView": view, "mimeType": "image/png"}],
        "samplers": [{"magFilter": _LINEAR, "minFilter": _LINEAR, "wrapS": _CLAMP, "wrapT": _CLAMP}],
        "textures": [{"sampler": 0, "source": 0}],
        "materials": [{"name": "texture", "pbrMetallicRoughness": color, "doubleSided": True}],
    }


class _Buffer:
    """The bytes of a file, and the accessors to them."""

    def __init__(self):
        self.data, self.views, self.accessors = bytearray(), [], []

    def add_mesh(self, mesh):
        """Adds points, triangles and arrays; returns the primitive."""
        points = mesh.points.astype(np.float32)
        attributes = {"POSITION": self.add(points, _VERTICES)}
        self.accessors[-1].update(min=points.min(axis=0).tolist(), max=points.max(axis=0).tolist())
        for name, values in mesh.arrays.items():
            attribute = _attribute(name, values)
            if attribute is not None and attribute[0] not in attributes:
                attributes[attribute[0]] = self.add(attribute[1], _VERTICES)
        if len(mesh.connectivity) == 0:
            return {"attributes": attributes, "mode": _POINTS}
        indices = self.add(mesh.connectivity.astype(np.uint32), _INDICES)
        return {"attributes": attributes, "mode": _TRIANGLES, "indices": indices}

    def add_bytes(self, data):
        """Adds bytes and returns their buffer view."""
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)})
        self.data += data + bytes(-len(data) % 4)
        return len(self.views) - 1

    def add(self, values, target):
        kind = next(code for code, name in _KINDS.items() if name == values.dtype.str[1:])
        components = 1 if values.ndim == 1 else values.shape[1]
        shape = next(name for name, size in _TYPES.items() if size == components)
        self.views.append(
            {"buffer": 0, "byteOffset": len(self.data), "byteLength": values.nbytes, "target": target}
        )
        accessor = {"bufferView": len(self.views) - 1, "componentType": kind, "count": len(values), "type": shape}
        if kind == 5121:
            accessor["normalized"] = True
        self.accessors.append(accessor)
        self.data += np.ascontiguousarray(values).tobytes()
        self.data += bytes(-len(self.data) % 4)
        return len(self.accessors) - 1


def _attribute(name, values):
    """Name and values of the attribute for a point array, or None."""
    components = 1 if values.ndim == 1 else values.shape[1]
    if components > 4:
        return None
    if name == "Normals" and components == 3:
        return "NORMAL", values.astype(np.float32)
    if name == "TCoords" and components == 2:
        return "TEXCOORD_0", np.column_stack([values[:, 0], 1 - values[:, 1]]).astype(np.float32)
    if name in ("RGB", "RGBA") and values.dtype == np.uint8 and components == len(name):
        opaque = values if components == 4 else np.column_stack([values, np.full(len(values), 255, dtype=np.uint8)])
        return "COLOR_0", opaque
    return "_" + name, values.astype(np.float32)
