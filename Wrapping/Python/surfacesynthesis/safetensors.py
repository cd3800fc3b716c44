# SPDX-License-Identifier: BSD-3-Clause
"""Writes model files (safetensors)."""

import json
import os
import tempfile

import numpy as np


def write_safetensors(path, tensors, metadata):
    """Writes arrays of float32 by name, and texts by name, to a file: the same bytes for the same content.

    The file is written beside ``path``, flushed and renamed, so that ``path`` holds the old or the new content and never
    half of one. Raises OSError.
    """
    header, end = {"__metadata__": dict(sorted(metadata.items()))}, 0
    arrays = {name: np.ascontiguousarray(tensors[name], dtype="<f4") for name in sorted(tensors)}
    for name, array in arrays.items():
        header[name] = {"dtype": "F32", "shape": list(tensors[name].shape), "data_offsets": [end, end + array.nbytes]}
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
