# SPDX-License-Identifier: BSD-3-Clause
"""NRRD with the samples in the same file, raw or compressed by gzip."""

import re

import numpy as np

from ..errors import FormatError
from .volumes import SPACES, Volume, count_samples, read_samples

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
#: Directions of x, y and z, against "RAS", of the spaces that name the patient's sides.
_DIRECTIONS = {
    "ras": SPACES["RAS"], "right-anterior-superior": SPACES["RAS"],
    "las": (-1.0, 1.0, 1.0), "left-anterior-superior": (-1.0, 1.0, 1.0),
    "lps": SPACES["LPS"], "left-posterior-superior": SPACES["LPS"],
}  # fmt: skip


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
    affine = _affine(path, fields, dimensions)
    return Volume(tuple(dimensions) + (1,) * (3 - len(dimensions)), affine, native, _DIRECTIONS.get(fields.get("space", "").lower()))


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
    if any(word.isascii() and word.isdigit() and len(word) > 18 for word in words):
        longest = max(map(len, words))
        raise FormatError(f"{path}: the field '{name}' has a number of {longest} digits; numbers below 2^31 are needed")
    if not words or not all(word.isascii() and word.isdigit() for word in words):
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


def _affine(path, fields, dimensions):
    affine, number = np.eye(4), len(dimensions)
    if "space directions" in fields:
        directions = _vectors(path, fields["space directions"], number)
        if len(directions) != number:
            raise FormatError(f"{path}: there are {len(directions)} space directions; {number} are needed")
        affine[:number, :number] = directions.T
    else:
        spacings, origin = _axes(path, fields, dimensions)
        affine[:number, :number] = np.diag(spacings)
        affine[:number, 3] = origin
    if "space origin" in fields:
        origin = _vectors(path, fields["space origin"], number)
        if len(origin) != 1:
            raise FormatError(f"{path}: there are {len(origin)} origins; one is needed")
        affine[:number, 3] = origin[0]
    return affine


def _axes(path, fields, dimensions):
    """Spacings and the place of the first sample, from the fields of each axis: spacings, or the ends of the axis, where
    samples are nodes or the centers of cells (as which samples of unknown centering count)."""
    number = len(dimensions)
    spacings = np.abs(_numbers(path, fields, "spacings", number))
    lower = _numbers(path, fields, "axis mins", number, "axismins")
    upper = _numbers(path, fields, "axis maxs", number, "axismaxs")
    words = fields.get("centers", fields.get("centerings", "")).split()
    nodes = np.array([word == "node" for word in words] if len(words) == number else [False] * number)
    if np.isnan(spacings).any():
        parts = np.maximum(np.array(dimensions) - nodes, 1)
        spacings = np.where(np.isnan(spacings), (upper - lower) / parts, spacings)  # an axis may fall
    spacings = np.where(np.isnan(spacings), 1.0, spacings)
    origin = lower + np.where(nodes, 0.0, 0.5 * spacings)
    return spacings, np.where(np.isnan(origin), 0.0, origin)


def _numbers(path, fields, name, number, other=None):
    """The numbers of a field, NaN where the file does not have them."""
    text = fields.get(name, fields.get(other, ""))
    try:
        found = np.array([float(word) for word in text.split()])
    except ValueError:
        found = np.zeros(0)
    if text and len(found) != number:
        raise FormatError(f"{path}: the {name} '{text[:60]}' are not {number} numbers")
    return found if text else np.full(number, np.nan)
