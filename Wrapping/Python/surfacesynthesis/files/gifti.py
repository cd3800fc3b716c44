# SPDX-License-Identifier: BSD-3-Clause
"""GIFTI (.surf.gii, .func.gii, .shape.gii, .label.gii), through nibabel behind a check of the file."""

import base64
import binascii
import io
import os
import zlib
from xml.parsers import expat

import numpy as np

from ..errors import FormatError
from .optional import nibabel_of, with_nibabel
from .polygons import mesh_of_triangles
from .volumes import LARGEST_RATIO

_BLOCK_SIZE = 1 << 20
_BYTES = {"NIFTI_TYPE_UINT8": 1, "NIFTI_TYPE_INT32": 4, "NIFTI_TYPE_FLOAT32": 4, "NIFTI_TYPE_FLOAT64": 8}
_POINTS, _TRIANGLES, _TIMES = "NIFTI_INTENT_POINTSET", "NIFTI_INTENT_TRIANGLE", "NIFTI_INTENT_TIME_SERIES"
_LABELS = "NIFTI_INTENT_LABEL"


def read_gifti(path):
    """The PolygonMesh in a file. Raises FormatError or OSError, and SurfaceSynthesisError without nibabel."""
    arrays = _arrays(path)
    points = [values for intent, _, values in arrays if intent == _POINTS]
    triangles = [values for intent, _, values in arrays if intent == _TRIANGLES]
    if len(points) != 1 or len(triangles) > 1:
        raise FormatError(
            f"{path}: the file has {len(points)} sets of points and {len(triangles)} of triangles; one is needed. Values "
            "alone are read with their surface: read_mesh(surface, point_data=[...])"
        )
    corners = triangles[0] if triangles else np.zeros((0, 3), dtype=np.int32)
    if points[0].ndim != 2 or points[0].shape[1] != 3 or corners.ndim != 2 or corners.shape[1] != 3:
        raise FormatError(f"{path}: points have three coordinates and triangles three corners")
    if corners.dtype.kind not in "iu" or (len(corners) and not 0 <= corners.min() <= corners.max() < len(points[0])):
        raise FormatError(f"{path}: triangles name points that the file does not have; it has {len(points[0])}")
    mesh = mesh_of_triangles(points[0], corners)
    mesh.arrays.update(_values(path, arrays, len(points[0])))
    return mesh


def read_gifti_values(path, number):
    """The arrays of values of ``number`` points in a file, by their names; and the names of labels by their values, for
    each array of labels."""
    arrays, table = _arrays_and_labels(path)
    labels = []
    found = _values(path, arrays, number, labels)
    if not found:
        raise FormatError(f"{path}: the file has no values of points")
    return found, dict.fromkeys(labels, table)


def _values(path, arrays, number, labels=None):
    """Values of points by their names; the times of a series are the components of one array. The names of arrays of
    labels are appended to ``labels``."""
    found, times = {}, []
    base = os.path.basename(path).removesuffix(".gii")
    for intent, name, values in arrays:
        if intent in (_POINTS, _TRIANGLES):
            continue
        if len(values) != number:
            raise FormatError(f"{path}: there are {len(values)} values '{name[:40]}' for {number} points")
        if intent == _TIMES:
            times.append(values)
            continue
        name = name or base
        key, count = name, 1
        while key in found:
            key, count = f"{name}_{count}", count + 1
        found[key] = values
        if intent == _LABELS and labels is not None:
            labels.append(key)
    if times:
        found["TimeSeries"] = np.column_stack(times)
    return found


def _arrays(path):
    """The arrays in a file: intent, name and values."""
    return _arrays_and_labels(path)[0]


def _arrays_and_labels(path):
    """The arrays in a file, and the names of labels by their values."""
    _Check(path).run()
    with with_nibabel(path) as nibabel:
        image = nibabel.gifti.GiftiImage.from_filename(path)
        codes = nibabel.nifti1.intent_codes.niistring
        found = []
        for array in image.darrays:
            values = np.reshape(array.data, [int(size) for size in array.dims])  # text of one row loses a dimension
            found.append((codes[array.intent], str(array.meta.get("Name", "")), values))
        return found, {int(label.key): str(label.label or "") for label in image.labeltable.labels}


class _Check:
    """Compares the sizes that a file announces with its length, and with what its data inflate to."""

    def __init__(self, path):
        self._path = path
        self._size = os.path.getsize(path)
        self._depth = self._needed = self._found = 0
        self._text, self._inflater, self._in_data = "", None, False

    def run(self):
        parser = expat.ParserCreate()
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.CharacterDataHandler = self._characters
        parser.EntityDeclHandler = self._entity
        with open(self._path, "rb") as file:
            try:
                while block := file.read(_BLOCK_SIZE):
                    parser.Parse(block, False)
                parser.Parse(b"", True)
            except expat.ExpatError as error:
                raise FormatError(f"{self._path}: the file is cut off, or no GIFTI file: {error}") from None

    def _entity(self, *_):
        raise FormatError(f"{self._path}: GIFTI files have no entities")

    def _start(self, name, attributes):
        if self._depth == 0 and name != "GIFTI":
            raise FormatError(f"{self._path}: this is no GIFTI file: it is of the kind {name[:40]}")
        self._depth += 1
        if name == "DataArray":
            self._array(attributes)
        self._in_data = name == "Data"

    def _array(self, attributes):
        kind, encoding = attributes.get("DataType"), attributes.get("Encoding")
        if attributes.get("ExternalFileName") or encoding == "ExternalFileBinary":
            raise FormatError(f"{self._path}: values in another file cannot be read")
        count = 1
        for k in range(self._number(attributes.get("Dimensionality", ""), 6)):
            count *= self._number(attributes.get(f"Dim{k}", ""), 2**31)
        if kind not in _BYTES or encoding not in ("ASCII", "Base64Binary", "GZipBase64Binary"):
            raise FormatError(f"{self._path}: values of the type {str(kind)[:40]}, {str(encoding)[:40]}, cannot be read")
        if count > self._size * (LARGEST_RATIO if encoding == "GZipBase64Binary" else 1):
            raise FormatError(f"{self._path}: {count} values are announced, which a file of {self._size} bytes cannot hold")
        self._needed, self._found, self._text = count * _BYTES[kind], 0, ""
        self._inflater = zlib.decompressobj() if encoding == "GZipBase64Binary" else None

    def _number(self, text, limit):
        if not text.isascii() or not text.isdigit() or len(text) > 18 or int(text) >= limit:
            raise FormatError(f"{self._path}: '{text[:40]}' is no size of values")
        return int(text)

    def _characters(self, text):
        """Inflates data without keeping it."""
        if not self._in_data or self._inflater is None:
            return
        self._text += "".join(text.split())
        whole = len(self._text) // 4 * 4
        try:
            packed, self._text = base64.b64decode(self._text[:whole]), self._text[whole:]
            while packed and not self._inflater.eof and self._found <= self._needed:
                self._found += len(self._inflater.decompress(packed, _BLOCK_SIZE))
                packed = self._inflater.unconsumed_tail
        except (binascii.Error, zlib.error) as error:
            raise FormatError(f"{self._path}: the compressed data is damaged: {error}") from None

    def _end(self, name):
        self._depth -= 1
        if name == "Data" and self._inflater is not None and self._found != self._needed:
            more = "more than " if self._found > self._needed else ""
            raise FormatError(
                f"{self._path}: {self._needed} bytes of values are announced; the data has {more}"
                f"{min(self._found, self._needed)}"
            )
        self._in_data = False


def write_gifti(mesh, file):
    """Writes a PolygonMesh of triangles to a binary file object, with its point arrays, in single precision."""
    nibabel = nibabel_of("GIFTI files")
    code = nibabel.nifti1.intent_codes.code
    image = nibabel.gifti.GiftiImage()

    def add(values, intent, name):
        kind = {"f": np.float32, "i": np.int32, "u": np.int32}[values.dtype.kind]
        kind = np.uint8 if values.dtype == np.uint8 else kind
        array = nibabel.gifti.GiftiDataArray(np.ascontiguousarray(values, dtype=kind), code[intent], kind)
        array.meta = nibabel.gifti.GiftiMetaData(name)
        image.add_gifti_data_array(array)

    add(mesh.points, _POINTS, {})
    add(mesh.connectivity.reshape(-1, 3), _TRIANGLES, {})
    for name, values in mesh.arrays.items():
        intent = "NIFTI_INTENT_SHAPE" if values.ndim == 1 else "NIFTI_INTENT_VECTOR"
        add(values, intent, {"Name": name})
    with io.BytesIO(image.to_xml()) as text:
        file.write(text.getbuffer())
