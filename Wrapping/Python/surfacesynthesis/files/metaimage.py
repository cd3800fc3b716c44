# SPDX-License-Identifier: BSD-3-Clause
"""MetaImage (.mha, .mhd): a header of lines ``key = value``, the samples behind it or in a file of their own."""

import os

import numpy as np

from ..errors import FormatError
from .volumes import SPACES, Volume, count_samples, read_samples

_TYPES = {
    "MET_CHAR": "i1", "MET_UCHAR": "u1", "MET_SHORT": "i2", "MET_USHORT": "u2", "MET_INT": "i4", "MET_UINT": "u4",
    "MET_LONG": "i8", "MET_ULONG": "u8", "MET_LONG_LONG": "i8", "MET_ULONG_LONG": "u8", "MET_FLOAT": "f4",
    "MET_DOUBLE": "f8",
}  # fmt: skip
_LONGEST_HEADER = 1 << 16


def read_metaimage(path):
    """Reads a MetaImage as a Volume in the file's own world coordinates, which are LPS as ITK writes them. Raises FormatError or OSError."""
    fields, length = _fields(path)
    dimensions = _numbers(path, fields, "DimSize", (None,), int)
    if len(dimensions) not in (2, 3) or fields.get("NDims", str(len(dimensions))) != str(len(dimensions)):
        raise FormatError(f"{path}: the volume has {len(dimensions)} dimensions; 2 or 3 are needed")
    if fields.get("ElementNumberOfChannels", "1") != "1":
        raise FormatError(f"{path}: there are {fields['ElementNumberOfChannels']} numbers at each voxel; one is needed")
    kind = _TYPES.get(fields.get("ElementType", ""))
    if kind is None:
        raise FormatError(f"{path}: samples of the type '{fields.get('ElementType', '')}' cannot be read")
    if not _flag(fields, "BinaryData", "True"):
        raise FormatError(f"{path}: BinaryData = {fields['BinaryData'][:40]}; samples as text cannot be read")
    source, offset = _source(path, fields["ElementDataFile"], length)
    swapped = _flag(fields, "BinaryDataByteOrderMSB") or _flag(fields, "ElementByteOrderMSB")
    compressed = "raw" if _flag(fields, "CompressedData") else None
    count = count_samples(path, dimensions)
    offset += _skipped(path, fields, source, offset, count * np.dtype(kind).itemsize, compressed)
    values = read_samples(source, count, (">" if swapped else "<") + kind, offset, compressed)
    native = values.astype(values.dtype.newbyteorder("="), copy=False)
    affine = _affine(path, fields, len(dimensions))
    return Volume(tuple(dimensions) + (1,) * (3 - len(dimensions)), affine, native, SPACES["LPS"])


def _fields(path):
    """The header's fields and its length in bytes: the field ElementDataFile ends it."""
    with open(path, "rb") as file:
        data = file.read(_LONGEST_HEADER)
    fields, position = {}, 0
    while "ElementDataFile" not in fields:
        end = data.find(b"\n", position)
        key, equals, value = data[position : end if end >= 0 else len(data)].partition(b"=")
        if not equals or not key.strip().isascii() or not value.isascii():
            raise FormatError(f"{path}: this is no MetaImage: its header has no field ElementDataFile")
        fields[key.strip().decode()] = value.strip().decode()
        position = end + 1 if end >= 0 else len(data)
    return fields, position


def _flag(fields, name, default="False"):
    return fields.get(name, default).lower() in ("true", "1")


def _skipped(path, fields, source, offset, needed, compressed):
    """The bytes between the header and the samples that HeaderSize announces; -1: the samples end the file."""
    (size,) = _numbers(path, fields, "HeaderSize", (1,), int) or [0]
    if size == -1 and compressed is None:
        return max(os.path.getsize(source) - offset - needed, 0)
    if not 0 <= size < 2**62:
        raise FormatError(f"{path}: HeaderSize = {fields['HeaderSize'][:40]} is no place in the file")
    return size


def _numbers(path, fields, names, counts, kind=float):
    """The numbers of the first field of ``names`` that is there; () when none is."""
    names = (names,) if isinstance(names, str) else names
    for name in names:
        if name in fields:
            words = fields[name].split()
            longest = max(map(len, words), default=0)
            if kind is int and longest > 19:  # which Python may not even read
                raise FormatError(f"{path}: {name} has a number of {longest} digits; numbers below 2^31 are needed")
            try:
                numbers = [kind(word) for word in words]
            except ValueError:
                raise FormatError(f"{path}: {name} = '{fields[name][:60]}' are no numbers") from None
            if counts != (None,) and len(numbers) not in counts:
                raise FormatError(f"{path}: {name} has {len(numbers)} numbers; {counts[0]} are needed")
            return numbers
    if counts == (None,):
        raise FormatError(f"{path}: the header has no field {names[0]}")
    return []


def _affine(path, fields, number):
    affine = np.eye(4)
    spacing = _numbers(path, fields, ("ElementSpacing", "ElementSize"), (number,)) or [1.0] * number
    origin = _numbers(path, fields, ("Offset", "Position", "Origin"), (number,)) or [0.0] * number
    axes = _numbers(path, fields, ("TransformMatrix", "Rotation", "Orientation"), (number * number,))
    if axes:
        affine[:number, :number] = np.reshape(axes, (number, number)).T  # one axis after the other
    affine[:number, :number] *= spacing
    affine[:number, 3] = origin
    return affine


def _source(path, name, length):
    """File and offset of the samples. Only files beside the header are read."""
    if name == "LOCAL":
        return path, length
    if not name or name in ("LIST", ".", "..") or "%" in name or os.path.basename(name) != name:
        raise FormatError(f"{path}: ElementDataFile = '{name[:60]}'; LOCAL or a file in the same folder is needed")
    source = os.path.join(os.path.dirname(path), name)
    if not os.path.isfile(source):
        raise FormatError(f"{path}: the file {name} with the samples is missing")
    return source, 0
