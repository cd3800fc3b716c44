# SPDX-License-Identifier: BSD-3-Clause
"""Python modules that some formats need, imported when such a file is read."""

import contextlib
import importlib
import warnings

from ..errors import FormatError, SurfaceSynthesisError


def nibabel_of(what):
    """The module nibabel; raises SurfaceSynthesisError where it is not installed."""
    try:
        nibabel = importlib.import_module("nibabel")
        importlib.import_module("nibabel.freesurfer")
    except ImportError:
        raise SurfaceSynthesisError(f"{what} need the Python module nibabel (Debian: python3-nibabel)") from None
    return nibabel


@contextlib.contextmanager
def with_nibabel(path):
    """The module nibabel; whatever it raises about the content of ``path`` becomes FormatError."""
    nibabel = nibabel_of(f"{path}: files of this kind")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield nibabel
    except (FormatError, MemoryError):
        raise
    except Exception as error:  # of many kinds, from KeyError to those of XML
        raise FormatError(f"{path}: nibabel cannot read it: {error}") from None
