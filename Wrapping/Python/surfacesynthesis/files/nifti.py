# SPDX-License-Identifier: BSD-3-Clause
"""NIfTI-1 and NIfTI-2 in single files, compressed or not."""

import struct
import warnings

import numpy as np

from ..errors import FormatError, SurfaceSynthesisWarning
from .volumes import SPACES, Volume, count_samples, read_head, read_samples

#: NumPy types by NIfTI's datatype code.
_TYPES = {
    2: "u1", 4: "i2", 8: "i4", 16: "f4", 64: "f8", 256: "i1", 512: "u2", 768: "u4", 1024: "i8", 1280: "u8",
}  # fmt: skip
#: Millimetres of a unit, by NIfTI's code: metres, micrometres. Other codes stand for millimetres or are not known.
_MILLIMETRES = {1: 1000.0, 3: 0.001}
#: For either version: length of the header, and offset and struct format of its fields.
_LAYOUTS = {
    348: {
        "magic": (344, "4s"), "dim": (40, "8h"), "datatype": (70, "h"), "bitpix": (72, "h"), "pixdim": (76, "8f"),
        "vox_offset": (108, "f"), "scl_slope": (112, "f"), "scl_inter": (116, "f"), "qform_code": (252, "h"),
        "sform_code": (254, "h"), "quatern": (256, "6f"), "srow": (280, "12f"), "xyzt_units": (123, "B"),
    },
    540: {
        "magic": (4, "8s"), "dim": (16, "8q"), "datatype": (12, "h"), "bitpix": (14, "h"), "pixdim": (104, "8d"),
        "vox_offset": (168, "q"), "scl_slope": (176, "d"), "scl_inter": (184, "d"), "qform_code": (344, "i"),
        "sform_code": (348, "i"), "quatern": (352, "6d"), "srow": (400, "12d"), "xyzt_units": (500, "i"),
    },
}  # fmt: skip


def read_nifti(path):
    """Reads a NIfTI file as a Volume in its own world coordinates (x to the right, y to the front, z upwards, mm):
    those of the sform where the file has one, else of the qform, else voxel sizes only. Of a series the first
    volume is read, with a warning. Raises FormatError or OSError."""
    header, compressed = _header(path)
    dimensions = _dimensions(path, header)
    kind = _TYPES.get(header["datatype"])
    if kind is None:
        raise FormatError(f"{path}: samples of the type {header['datatype']} cannot be read; integers and floats can")
    if header["bitpix"] != 8 * np.dtype(kind).itemsize:
        raise FormatError(f"{path}: the header gives {header['bitpix']} bits to samples of the type {header['datatype']}")
    offset = header["vox_offset"]
    if not header["size"] + 4 <= offset < 2**62 or offset != int(offset):
        raise FormatError(f"{path}: the samples cannot begin at byte {offset:g}, within the header or nowhere")
    count = count_samples(path, dimensions)
    values = read_samples(path, count, header["order"] + kind, int(offset), "gzip" if compressed else None)
    affine = _affine(path, header)
    affine[:3] *= _MILLIMETRES.get(header["xyzt_units"] & 7, 1.0)
    return Volume(dimensions, affine, _scaled(values, header["scl_slope"], header["scl_inter"]), SPACES["RAS"])


def _header(path):
    data, compressed = read_head(path, 540)
    for size, layout in _LAYOUTS.items():
        for order in "<>":
            if len(data) >= size and struct.unpack_from(order + "i", data)[0] == size:
                header = {"size": size, "order": order}
                for name, (offset, form) in layout.items():
                    found = struct.unpack_from(order + form, data, offset)
                    header[name] = found[0] if len(found) == 1 else found
                return _with_magic(path, header), compressed
    raise FormatError(f"{path}: this is no NIfTI file: it does not begin with the length of such a header, 348 or 540")


def _with_magic(path, header):
    magic = header["magic"][:4]
    if magic in (b"ni1\0", b"ni2\0"):
        raise FormatError(f"{path}: header and samples lie in two files; convert them to one .nii file")
    if magic not in (b"n+1\0", b"n+2\0"):
        raise FormatError(f"{path}: this is no NIfTI file: its header is not marked as one")
    return header


def _dimensions(path, header):
    number, *sizes = header["dim"]
    if not 1 <= number <= 7:
        raise FormatError(f"{path}: the volume has {number} dimensions; from 1 to 7 are possible")
    sizes = [size if axis < number else 1 for axis, size in enumerate(sizes)]
    count_samples(path, sizes)
    if max(sizes[4:]) > 1:
        raise FormatError(f"{path}: there are {np.prod(sizes[4:], dtype=object)} numbers at each voxel; one is needed")
    if sizes[3] > 1:
        warnings.warn(
            f"{path}: the first of {sizes[3]} volumes is read", SurfaceSynthesisWarning, stacklevel=5
        )
    return tuple(int(size) for size in sizes[:3])


def _affine(path, header):
    affine = np.eye(4)
    if header["sform_code"] > 0:
        affine[:3] = np.reshape(header["srow"], (3, 4))
        return affine
    sizes = np.abs(np.array(header["pixdim"][1:4], dtype=float))
    sizes[sizes == 0] = 1.0  # of axes with one voxel it is often left out
    if header["qform_code"] <= 0:
        affine[:3, :3] = np.diag(sizes)
        return affine
    b, c, d = header["quatern"][:3]
    square = 1.0 - (b * b + c * c + d * d)
    if not square > -1e-5:
        raise FormatError(f"{path}: the quaternion ({b:g}, {c:g}, {d:g}) of the qform is no rotation")
    a = np.sqrt(max(square, 0.0))
    rotation = np.array([
        [a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)],
        [2 * (b * c + a * d), a * a + c * c - b * b - d * d, 2 * (c * d - a * b)],
        [2 * (b * d - a * c), 2 * (c * d + a * b), a * a + d * d - b * b - c * c],
    ])  # fmt: skip
    handed = -1.0 if header["pixdim"][0] < 0 else 1.0
    affine[:3, :3] = rotation * sizes * [1.0, 1.0, handed]
    affine[:3, 3] = header["quatern"][3:]
    return affine


def _scaled(values, slope, intercept):
    """The values that the samples stand for: samples themselves unless the header scales them."""
    native = values.astype(values.dtype.newbyteorder("="), copy=False)
    if slope == 0 or not np.isfinite([slope, intercept]).all() or (slope == 1 and intercept == 0):
        return native
    kind = np.float64 if values.dtype.itemsize > 2 and values.dtype.kind != "f" or values.dtype == "f8" else np.float32
    return (native * np.float64(slope) + intercept).astype(kind)
