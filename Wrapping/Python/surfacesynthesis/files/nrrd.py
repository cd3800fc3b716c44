# SPDX-License-Identifier: BSD-3-Clause
"""NRRD with the samples in the same file, raw or compressed by gzip."""

import re

import numpy as np

from ..errors import FormatError
from .volumes import Volume, count_samples, read_samples

_TYPES = {
    "i1": ("signed char", "int8", "int8_t"), "u1": ("uchar", "unsigned char", "uint8", "uint8_t"),
    "i2": ("short", "short int", "signed short", "signed short int", "int16", "int16_t"),
    "u2": ("ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t"),
    "i4": ("int", "signed int", "int32", "int32_t"), "u4": ("uint", "unsigned int", "uint32", "uint32_t"),
    "i8": ("longlong", "long long", "long long int", "signed long long", "int64", "int64_t"),
    "u8": ("ulonglong", "unsigned long long", "unsigned long long int", "uint64", "uint64_t"),
    "f4": ("float",), "f8": ("double",),
}  # fmt: skip
_LONGEST_HEADER = 1 << 20


def read_nrrd(path):
    """Reads an NRRD file as a Volume in the file's own space. Raises FormatError or OSError."""
    fields, length = _fields(path)
    if "data file" in fields or "datafile" in fields:
        raise FormatError(f"{path}: the samples lie in another file; only samples in the same file can be read")
    dimensions = _integers(path, fields, "sizes")
    if fields.get("dimension") != str(len(dimensions)) or len(dimensions) not in (2, 3):
        raise FormatError(f"{path}: the volume has {len(dimensions)} dimensions; 2 or 3 are needed")
    kind = next((kind for kind, names in _TYPES.items() if fields.get("type") in names), None)
    if kind is None:
        raise FormatError(f"{path}: samples of the type '{fields.get('type', '')[:40]}' cannot be read")
    encodings = {"raw": None, "gzip": "raw", "gz": "raw"}
    encoding = fields.get("encoding")
    if encoding not in encodings:
        raise FormatError(f"{path}: samples in the encoding '{(encoding or '')[:40]}' cannot be read; raw and gzip can")
    if any(fields.get(skip, "0") != "0" for skip in ("line skip", "lineskip", "byte skip", "byteskip")):
        raise FormatError(f"{path}: lines or bytes before the samples cannot be skipped")
    order = ">" if fields.get("endian") == "big" else "<"
    values = read_samples(path, count_samples(path, dimensions), order + kind, length, encodings[encoding])
    native = values.astype(values.dtype.newbyteorder("="), copy=False)
    return Volume(tuple(dimensions) + (1,) * (3 - len(dimensions)), _affine(path, fields, len(dimensions)), native)


def _fields(path):
    """The header's fields and its length in bytes, which an empty line ends."""
    with open(path, "rb") as file:
        data = file.read(_LONGEST_HEADER)
    end = re.search(rb"\r?\n\r?\n", data)
    if not re.match(rb"NRRD000[1-5]\r?\n", data) or not end:
        raise FormatError(f"{path}: this is no NRRD file: it does not begin with NRRD0001 to NRRD0005 and a header")
    fields = {}
    for line in data[: end.start()].decode("latin-1").splitlines()[1:]:
        key, colon, value = line.partition(":")
        if colon and not line.startswith("#") and not value.startswith("="):
            fields[key.strip().lower()] = value.strip()
    return fields, end.end()


def _integers(path, fields, name):
    words = fields.get(name, "").split()
    if not words or not all(word.isascii() and word.isdigit() and len(word) < 19 for word in words):
        raise FormatError(f"{path}: the field '{name}' has no numbers: '{fields.get(name, '')[:60]}'")
    return [int(word) for word in words]


def _vectors(path, text, size):
    """The vectors of "(1,0,0) (0,1,0)"; "none" stands for an axis without direction."""
    vectors = []
    for words in re.findall(r"\(([^()]*)\)|none", text):
        try:
            vectors.append([float(word) for word in words.split(",")] if words else None)
        except ValueError:
            raise FormatError(f"{path}: '({words[:60]})' is no vector") from None
    if any(vector is None or len(vector) != size for vector in vectors):
        raise FormatError(f"{path}: vectors of {size} numbers are needed, not '{text[:80]}'")
    return np.array(vectors)


def _affine(path, fields, number):
    affine = np.eye(4)
    if "space directions" in fields:
        directions = _vectors(path, fields["space directions"], number)
        if len(directions) != number:
            raise FormatError(f"{path}: there are {len(directions)} space directions; {number} are needed")
        affine[:number, :number] = directions.T
    elif "spacings" in fields:
        try:
            spacings = [abs(float(word)) for word in fields["spacings"].split()]
            affine[:number, :number] = np.diag(spacings)
        except ValueError:
            raise FormatError(f"{path}: the spacings '{fields['spacings'][:60]}' are not {number} numbers") from None
    if "space origin" in fields:
        origin = _vectors(path, fields["space origin"], number)
        if len(origin) != 1:
            raise FormatError(f"{path}: there are {len(origin)} origins; one is needed")
        affine[:number, 3] = origin[0]
    return affine
