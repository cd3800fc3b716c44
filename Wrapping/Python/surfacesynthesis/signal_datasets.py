# SPDX-License-Identifier: BSD-3-Clause
"""Signals on surfaces in files: what flow matching trains on and is tested with."""

import html
import warnings
from typing import NamedTuple

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkPolyData

from .arguments import array_name
from .datasets import given_dataset
from .errors import FormatError, SurfaceSynthesisWarning
from .files.polygons import from_polydata
from .results import html_table
from .safetensors import read_safetensors, write_safetensors

_CONTENT, _VERSION = "surface_signals", "1"


class SignalSource(NamedTuple):
    """A surface, and the samples of a signal on it."""

    points: np.ndarray  #: [V, 3] float64
    triangles: np.ndarray  #: [F, 3] int64
    signals: np.ndarray  #: [N, V, C] float32


class SignalDataset(NamedTuple):
    """Content of a file: the name of the signal, and a list of SignalSource."""

    name: str
    sources: list

    def __repr__(self):
        samples = sum(len(source.signals) for source in self.sources)
        return f"<SignalDataset {self.name!r}: {len(self.sources)} surfaces, {samples:,} samples>"

    def _repr_html_(self):
        rows = [
            (k, len(source.points), len(source.triangles), *source.signals.shape[::2])
            for k, source in enumerate(self.sources)
        ]
        head = ("surface", "points", "triangles", "samples", "components")
        return f"<p>{html.escape(self.name)}</p>{html_table(rows, head)}"


def write_signal_dataset(path, sources, name, origin="", license=""):
    """Writes samples of a signal on one or several surfaces.

    The file is in the safetensors format, with the tensors ``sources.K.points`` (float64 [V, 3]),
    ``sources.K.triangles`` (int64 [F, 3]) and ``sources.K.signals`` (float32 [N, V, C]) for K = 0, 1, ... and the
    texts ``content`` ("surface_signals"), ``format_version`` ("1"), ``signal_name`` and ``producer`` in its metadata.
    The same content gives the same bytes. Samples that lose digits in float32, because they are large and vary little, such as
    positions far from the origin, give a warning.

    Parameters
    ----------
    path : str or path-like
        The file; its ending should be .safetensors. It holds the old or the new content, never half of one.
    sources : list of (mesh, samples)
        ``mesh`` is a vtkPolyData or a pair (points, triangles); its polygons are written as triangles. ``samples`` are
        real numbers [N, V, C], or [N, V] for C = 1, for the V points of the mesh; N at least 1, C the same for all.
    name : str
        Name of the signal: "Position" for positions, else the name of the array.
    origin, license : str
        Where the data come from, and their license as its owner states it: texts in the metadata of the file, which models that
        are trained on it take over. Default "": unknown, not written.

    Raises
    ------
    ValueError, TypeError
        There is no source, or the samples do not fit the mesh or are not finite numbers.
    OSError
        The file cannot be written.
    """
    array_name("name", name)
    sources = [_checked_source(k, *source) for k, source in enumerate(sources)]
    if not sources:
        raise ValueError("sources is empty; a dataset needs a surface")
    components = {source.signals.shape[2] for source in sources}
    if len(components) > 1:
        raise ValueError(f"the samples must have the same number of components on all surfaces, not {components}")
    tensors = {
        f"sources.{k}.{field}": array for k, source in enumerate(sources) for field, array in source._asdict().items()
    }
    metadata = {
        "content": _CONTENT,
        "format_version": _VERSION,
        "signal_name": name,
        "producer": "SurfaceSynthesis",
        **{key: text for key, text in (("origin", origin), ("license", license)) if text},
    }
    write_safetensors(path, tensors, metadata, double=[key for key in tensors if key.endswith(".points")])


def read_signal_dataset(path):
    """Reads what write_signal_dataset() has written; returns a SignalDataset.

    Raises FormatError when the file does not follow the format, OSError when it cannot be read.
    """
    count = 0

    def judge(shapes, types, metadata):
        nonlocal count
        count = _judge_header(path, shapes, types, metadata)

    tensors, metadata = read_safetensors(path, judge)
    sources = []
    for k in range(count):
        source = SignalSource(*(tensors[f"sources.{k}.{field}"] for field in SignalSource._fields))
        _check_read(path, k, source)
        sources.append(source)
    return SignalDataset(metadata["signal_name"], sources)


def _judge_header(path, shapes, types, metadata):
    """Raises FormatError for a file that is no dataset, before its arrays are read; returns the number of sources."""
    for key, wanted in (("content", _CONTENT), ("format_version", _VERSION)):
        if metadata.get(key) != wanted:
            raise FormatError(f"{path}: the {key} is '{metadata.get(key, '')}', not '{wanted}'")
    if "signal_name" not in metadata:
        raise FormatError(f"{path}: there is no signal_name")
    count = len({name.split(".")[1] for name in shapes if name.count(".") == 2})
    expected = {f"sources.{k}.{field}" for k in range(count) for field in SignalSource._fields}
    if not expected or expected != set(shapes):
        odd = sorted(expected ^ set(shapes)) or ["sources.0.points"]
        raise FormatError(f"{path}: the tensor {odd[0]} is missing or has no meaning")
    for k in range(count):
        names = [f"sources.{k}.{field}" for field in SignalSource._fields]
        _check_shapes(path, k, [shapes[name] for name in names], [types[name] for name in names])
    return count


def _checked_source(k, mesh, samples):
    polygons = from_polydata(given_dataset(mesh, (vtkPolyData,), "a vtkPolyData or a pair (points, triangles)"), True)
    points = np.asarray(polygons.points, dtype=np.float64)
    triangles = polygons.connectivity.reshape(-1, 3)
    samples = np.asarray(samples)
    if samples.dtype.kind not in "fiu":
        raise TypeError(f"the samples of source {k} must be real numbers, not {samples.dtype}")
    if samples.ndim not in (2, 3) or 0 in samples.shape or samples.shape[1] != len(points):
        raise ValueError(
            f"the samples of source {k} have the shape {list(samples.shape)}; [N, {len(points)}, C], or [N, "
            f"{len(points)}], is needed"
        )
    if len(triangles) == 0:
        raise ValueError(f"the mesh of source {k} has no triangle")
    with np.errstate(over="ignore"):  # reported below
        signals = samples.reshape(*samples.shape[:2], -1).astype(np.float32)
    if not np.isfinite(points).all() or not np.isfinite(signals).all():
        raise ValueError(f"source {k} has a number that is not finite, or too large for float32")
    _warn_of_lost_digits(k, samples.reshape(signals.shape), signals)
    return SignalSource(points, triangles, signals)


def _warn_of_lost_digits(k, samples, signals):
    """Warns when float32 changes the samples by more than a thousandth of what they vary over the surface."""
    variation = float((samples.max(axis=1) - samples.min(axis=1)).max())
    change = float(np.abs(signals - samples).max())
    if 0.0 < 1e-3 * variation < change:
        warnings.warn(
            f"The samples of source {k} vary by {variation:g} over the surface, and float32 changes them by {change:g}, because "
            "they are far from 0. Positions keep their digits on a surface near the origin (vtkTransformFilter).",
            SurfaceSynthesisWarning,
            stacklevel=4,
        )


def _check_shapes(path, k, shapes, types):
    """Raises FormatError when the tensors of a source do not fit together."""
    points, triangles, signals = shapes
    if types != [np.float64, np.int64, np.float32]:
        raise FormatError(f"{path}: source {k} has the types {', '.join(map(str, types))}")
    tables = len(points) == len(triangles) == 2 and points[1] == triangles[1] == 3
    if not tables or len(signals) != 3 or signals[1] != points[0] or 0 in signals or not triangles[0]:
        raise FormatError(
            f"{path}: source {k} has points {points}, triangles {triangles} and signals {signals}; [V, 3], [F, 3] and "
            "[N, V, C] are needed"
        )


def _check_read(path, k, source):
    """Raises FormatError when the numbers of a source make no sense."""
    points, triangles, signals = source
    if triangles.min() < 0 or triangles.max() >= len(points):
        raise FormatError(f"{path}: a triangle of source {k} names a point that does not exist")
    if not np.isfinite(points).all() or not np.isfinite(signals).all():
        raise FormatError(f"{path}: source {k} has a number that is not finite")
