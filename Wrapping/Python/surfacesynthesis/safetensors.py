# SPDX-License-Identifier: BSD-3-Clause
"""Files of named arrays: models and datasets (safetensors)."""

import errno
import json
import math
import os

import numpy as np

from .errors import FormatError
from .supervision import unfinished_name

#: The types that are read and written, by the name that the format gives them.
_TYPES = {"F64": "<f8", "I64": "<i8", "F32": "<f4", "U8": "|u1"}
_LARGEST_HEADER = 16 * 2**20


def write_safetensors(path, tensors, metadata, double=(), octets=()):
    """Writes arrays by name, those named in ``octets`` as uint8, other integers as int64, those named in ``double`` as
    float64 and all others as float32, and texts by name; the same bytes for the same content.

    The file is written beside ``path``, flushed and renamed, so that ``path`` holds the old or the new content and
    never half of one. Raises OSError.
    """
    arrays = {}
    for name, values in tensors.items():
        values = np.asarray(values)
        kind = "F64" if name in double else "I64" if values.dtype.kind in "iu" else "F32"
        kind = "U8" if name in octets else kind
        arrays[name] = np.ascontiguousarray(values, _TYPES[kind]).reshape(values.shape)
    # large elements first, so that all are aligned
    arrays = dict(sorted(arrays.items(), key=lambda item: (-item[1].itemsize, item[0])))
    header, end = {"__metadata__": dict(sorted(metadata.items()))}, 0
    for name, array in arrays.items():
        kind = next(key for key, value in _TYPES.items() if np.dtype(value) == array.dtype)
        header[name] = {"dtype": kind, "shape": list(array.shape), "data_offsets": [end, end + array.nbytes]}
        end += array.nbytes
    text = json.dumps(header, separators=(",", ":"), ensure_ascii=False).encode("utf-8")
    text += b" " * (-len(text) % 8)
    path = os.path.realpath(os.fspath(path))
    if os.path.exists(path) and not os.path.isfile(path):  # which the file would replace
        raise IsADirectoryError(errno.EISDIR, "it is a folder or a device", path)
    temporary = unfinished_name(os.path.dirname(path), ".safetensors")
    handle = os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(len(text).to_bytes(8, "little") + text)
            for array in arrays.values():
                file.write(array.tobytes())
            file.flush()
            os.fsync(file.fileno())
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(temporary, 0o666 & ~mask)
        os.replace(temporary, path)
    except BaseException as error:
        os.unlink(temporary)
        if isinstance(error, OSError) and error.filename is None:  # of a full disk
            raise OSError(error.errno, error.strerror, path) from None
        raise


def read_safetensors(path, judge=None):
    """The arrays and the texts of a file, two dictionaries by name. The types are those that write_safetensors() writes.

    ``judge(shapes, types, metadata)`` is called with dictionaries by name (shapes as lists, NumPy types) once the header
    has been read and before an array is; it raises an exception to refuse the file.

    Raises FormatError when the file does not follow the format or its arrays exceed the available memory, OSError when
    it cannot be read.
    """
    path = os.fspath(path)
    with open(path, "rb") as file:
        header, begin = _read_header(path, file)
        metadata = header.pop("__metadata__", {})
        if not isinstance(metadata, dict) or not all(isinstance(text, str) for text in metadata.values()):
            raise FormatError(f"{path}: the metadata is not a list of texts by name")
        size, end = os.fstat(file.fileno()).st_size - begin, 0
        for name, entry in sorted(header.items(), key=lambda item: _offset(path, item)):
            end = _check_tensor(path, name, entry, size, end)
        if end != size:
            raise FormatError(f"{path}: the file has {begin + size} bytes, not {begin + end}")
        if judge is not None:
            types = {name: np.dtype(_TYPES[entry["dtype"]]) for name, entry in header.items()}
            judge({name: entry["shape"] for name, entry in header.items()}, types, metadata)
        _require_memory(path, size)
        return {name: _read_tensor(path, name, entry, file, begin) for name, entry in header.items()}, metadata


def _require_memory(path, size):
    try:
        with open("/proc/meminfo", encoding="ascii") as file:
            available = next(int(line.split()[1]) * 1024 for line in file if line.startswith("MemAvailable:"))
    except (OSError, StopIteration):
        return
    if size > available:
        raise FormatError(
            f"{path}: reading the file takes {size / 1e9:.1f} GB of memory; at most the {available / 1e9:.1f} GB that are "
            "available can be used"
        )


def _read_header(path, file):
    """The header and the place where it ends."""
    size = int.from_bytes(file.read(8), "little")
    if not 2 <= size <= _LARGEST_HEADER or size > os.fstat(file.fileno()).st_size - 8:
        raise FormatError(f"{path}: this is no safetensors file, or a truncated one")
    try:
        header = json.loads(file.read(size).decode("utf-8"), object_pairs_hook=_unique)
    except (ValueError, RecursionError) as error:
        raise FormatError(f"{path}: the header is no JSON object with unique names ({error})") from None
    if not isinstance(header, dict):
        raise FormatError(f"{path}: the header is no JSON object")
    return header, 8 + size


def _unique(pairs):
    result = dict(pairs)
    if len(result) < len(pairs):
        raise ValueError("a name occurs twice")
    return result


def _is_size(value):
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 2**63


def _offset(path, item):
    """Offset of a tensor; checks the form of its entry."""
    name, entry = item
    if not isinstance(entry, dict) or set(entry) != {"dtype", "shape", "data_offsets"}:
        raise FormatError(f"{path}: the entry of tensor '{name}' is not dtype, shape and data_offsets")
    for key in ("shape", "data_offsets"):
        if not isinstance(entry[key], list) or len(entry[key]) > 8 or not all(map(_is_size, entry[key])):
            raise FormatError(f"{path}: the {key} of tensor '{name}' is no list of up to 8 sizes")
    if len(entry["data_offsets"]) != 2:
        raise FormatError(f"{path}: tensor '{name}' has not two data_offsets")
    return entry["data_offsets"]


def _check_tensor(path, name, entry, size, begin):
    """Checks a tensor that must begin at ``begin`` of ``size`` bytes; returns where it ends."""
    if not isinstance(entry["dtype"], str) or entry["dtype"] not in _TYPES:
        raise FormatError(f"{path}: tensor '{name}' has the type {entry['dtype']}; one of {', '.join(_TYPES)} is needed")
    kind, (first, end) = np.dtype(_TYPES[entry["dtype"]]), entry["data_offsets"]
    if first != begin or end - first != math.prod(entry["shape"]) * kind.itemsize or end > size:
        raise FormatError(f"{path}: the data_offsets of tensor '{name}' do not fit its shape, its neighbours or the file")
    return end


def _read_tensor(path, name, entry, file, begin):
    """The array of a tensor; the data begin at ``begin`` of the file."""
    file.seek(begin + entry["data_offsets"][0])
    count = math.prod(entry["shape"])
    values = np.fromfile(file, _TYPES[entry["dtype"]], count)
    if len(values) != count:
        raise FormatError(f"{path}: the file ended while tensor '{name}' was read")
    return values.reshape(entry["shape"])
