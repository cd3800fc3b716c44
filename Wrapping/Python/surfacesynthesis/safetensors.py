# SPDX-License-Identifier: BSD-3-Clause
"""Writes model files (safetensors)."""

import json
import os
import tempfile

import numpy as np


def write_safetensors(path, tensors, metadata):
    """Writes arrays by name, integers as int64 and all others as float32, and texts by name; the same bytes for
    the same content.

    The file is written beside ``path``, flushed and renamed, so that ``path`` holds the old or the new content and
    never half of one. Raises OSError.
    """
    arrays = {}
    for name, values in tensors.items():
        values = np.asarray(values)
        arrays[name] = np.ascontiguousarray(values, "<i8" if values.dtype.kind in "iu" else "<f4").reshape(values.shape)
    # large elements first, so that all are aligned
    arrays = dict(sorted(arrays.items(), key=lambda item: (-item[1].itemsize, item[0])))
    header, end = {"__metadata__": dict(sorted(metadata.items()))}, 0
    for name, array in arrays.items():
        kind = "I64" if array.dtype.kind == "i" else "F32"
        header[name] = {"dtype": kind, "shape": list(array.shape), "data_offsets": [end, end + array.nbytes]}
        end += array.nbytes
    text = json.dumps(header, separators=(",", ":"), ensure_ascii=False).encode("utf-8")
    text += b" " * (-len(text) % 8)
    path = os.path.realpath(os.fspath(path))
    handle, temporary = tempfile.mkstemp(dir=os.path.dirname(path), prefix=".", suffix=".safetensors")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(len(text).to_bytes(8, "little") + text)
            for array in arrays.values():
                file.write(array.tobytes())
            file.flush()
            os.fsync(file.fileno())
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(temporary, 0o666 & ~mask)  # mkstemp() makes a private file
        os.replace(temporary, path)
    except BaseException:
        os.unlink(temporary)
        raise
