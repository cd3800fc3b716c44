# SPDX-License-Identifier: BSD-3-Clause
"""FreeSurfer's volumes (.mgh, .mgz), surfaces (lh.pial) and values of points (lh.thickness), through nibabel behind a
check of the header."""

import io
import os
import struct
import warnings

import numpy as np

from ..errors import FormatError, SurfaceSynthesisWarning
from .optional import with_nibabel
from .polygons import mesh_of_triangles
from .volumes import SPACES, Volume, count_samples, read_head, read_samples

#: Ends of the names of surfaces, and of values of points.
SURFACES = (".inflated", ".orig", ".pial", ".smoothwm", ".sphere", ".white")
VALUES = (".area", ".curv", ".sulc", ".thickness", ".volume")

_MGH_HEADER = 284
_MGH_TYPES = {0: "u1", 1: "i4", 3: "f4", 4: "i2"}
_TRIANGLE_FILE, _VALUE_FILE = b"\xff\xff\xfe", b"\xff\xff\xff"
_LONGEST_COMMENT = 1 << 12


def read_mgh(path):
    """Reads a volume in its scanner coordinates (RAS, mm); of a series the first volume, with a warning. Raises
    FormatError or OSError, and SurfaceSynthesisError without nibabel."""
    head, compressed = read_head(path, _MGH_HEADER)
    if len(head) < _MGH_HEADER or head[:4] != b"\0\0\0\1":
        raise FormatError(f"{path}: this is no MGH file: it does not begin with the version 1 and a header")
    *dimensions, frames, kind = struct.unpack_from(">5i", head, 4)
    count = count_samples(path, dimensions)
    if kind not in _MGH_TYPES:
        raise FormatError(f"{path}: samples of the type {kind} cannot be read")
    if frames > 1:
        warnings.warn(f"{path}: the first of {frames} volumes is read", SurfaceSynthesisWarning, stacklevel=4)
    values = read_samples(path, count, ">" + _MGH_TYPES[kind], _MGH_HEADER, "gzip" if compressed else None)
    with with_nibabel(path) as nibabel:
        affine = nibabel.freesurfer.MGHImage.header_class.from_fileobj(io.BytesIO(head)).get_affine()
    native = values.astype(values.dtype.newbyteorder("="), copy=False)
    return Volume(tuple(dimensions), affine.astype(float), native, SPACES["RAS"])


def read_surface(path):
    """Reads a surface of triangles as a PolygonMesh, in the scanner coordinates (RAS, mm) of the volume that the file
    describes, or in its own where it describes none. Raises FormatError or OSError, and SurfaceSynthesisError without
    nibabel."""
    with open(path, "rb") as file:
        head = file.read(_LONGEST_COMMENT)
    begin = head.find(b"\n", head.find(b"\n") + 1) + 1
    if head[:3] != _TRIANGLE_FILE or begin < 2 or len(head) < begin + 8:
        raise FormatError(f"{path}: this is no surface of triangles as FreeSurfer writes them")
    points, triangles = struct.unpack_from(">2i", head, begin)
    size = os.path.getsize(path)
    if points < 0 or triangles < 0 or begin + 8 + 12 * (points + triangles) > size:
        raise FormatError(
            f"{path}: the file is cut off: {points} points and {triangles} triangles are announced, it has {size} bytes"
        )
    with with_nibabel(path) as nibabel:
        coordinates, corners, metadata = nibabel.freesurfer.read_geometry(path, read_metadata=True)
    if len(corners) and not 0 <= corners.min() <= corners.max() < points:
        raise FormatError(f"{path}: triangles name points that the file does not have; it has {points}")
    matrix, shift = _to_scanner(metadata)
    if np.linalg.det(matrix) < 0:
        corners = corners[:, ::-1]
    return mesh_of_triangles(coordinates @ matrix.T + shift, corners)


def _to_scanner(metadata):
    """Rotation and shift from a surface's coordinates, whose origin is the center of its volume and whose axes are those
    of a coronal volume, to the scanner's."""
    keys = ("xras", "yras", "zras", "cras")
    if not str(metadata.get("valid", "")).startswith("1") or any(np.shape(metadata.get(key)) != (3,) for key in keys):
        return np.eye(3), np.zeros(3)
    coronal = np.array([[-1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]])  # columns: the axes of such a volume
    axes = np.column_stack([metadata[key] for key in keys[:3]])
    return axes @ coronal.T, np.asarray(metadata["cras"], dtype=float)


def read_values(path, number):
    """Values of ``number`` points."""
    size = os.path.getsize(path)
    with open(path, "rb") as file:
        head = file.read(15)
    if len(head) < 15 or head[:3] != _VALUE_FILE:
        raise FormatError(f"{path}: these are no values of points as FreeSurfer writes them")
    found, _, columns = struct.unpack_from(">3i", head, 3)
    if found != number or columns != 1:
        raise FormatError(f"{path}: there are {found} values of {columns} columns for {number} points")
    if 15 + 4 * found > size:
        raise FormatError(f"{path}: the file is cut off: {found} values are announced, it has {size} bytes")
    with with_nibabel(path) as nibabel:
        return nibabel.freesurfer.read_morph_data(path)
