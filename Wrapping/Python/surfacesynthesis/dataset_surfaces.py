# SPDX-License-Identifier: BSD-3-Clause
"""Dataset files and composite datasets of surfaces: what trainings read, and what ParaView and other filters show."""

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCompositeDataSet, vtkMultiBlockDataSet, vtkPolyData

from .arguments import array_name, integer
from .datasets import dataset_of_pair, given_dataset
from .errors import FormatError
from .files.polygons import from_polydata
from .metrics import ensemble_of
from .signal_datasets import SignalDataset, SignalSource

#: Name of the signal whose values are positions of points, and of the array with the positions of the source.
POSITION, SOURCE_POSITION = "Position", "SourcePosition"


def surfaces_of_dataset(dataset, samples=None, first_sample=0):
    """Surfaces of the samples of a dataset of signals, which metrics, statistics and files (.vtm) take.

    Parameters
    ----------
    dataset : SignalDataset
        The result of read_signal_dataset().
    samples : int, optional
        Number of samples of each source, at least 1. Default: all that follow the first one.
    first_sample : int
        Index of the first sample, at least 0. Default 0.

    Returns
    -------
    vtkMultiBlockDataSet
        Of positions, a block for each source, "Source 0" and so on, with a vtkPolyData for each sample, "Sample 0" and so on;
        the first of each has the point array SourcePosition (float64). Of other signals, a vtkPolyData for each source, with
        the points of the source and a point array (float32) for each sample, NAME_0, NAME_1 and so on.

    Raises
    ------
    ValueError, TypeError
        An argument has a value out of its range or is of a wrong type.
    """
    first = integer("first_sample", first_sample, 0)
    end = None if samples is None else first + integer("samples", samples, 1)
    blocks = vtkMultiBlockDataSet()
    for number, source in enumerate(dataset.sources):
        chosen = list(enumerate(source.signals))[first:end]
        if not chosen:
            raise ValueError(f"first_sample must be less than {len(source.signals)}, the samples of source {number}, not {first}")
        surface = dataset_of_pair((source.points, source.triangles))
        moved = dataset.name == POSITION and source.signals.shape[2] == 3
        blocks.SetBlock(number, _moved(surface, chosen) if moved else _with_arrays(surface, dataset.name, chosen))
        blocks.GetMetaData(number).Set(vtkCompositeDataSet.NAME(), f"Source {number}")
    return blocks


def dataset_of_surfaces(surfaces, array=None, source=None):
    """Dataset of signals of an ensemble of surfaces, which write_signal_dataset() writes: the inverse of surfaces_of_dataset().

    Successive surfaces with the same polygons are samples on one source; of arrays, they must have the same points too.

    Parameters
    ----------
    surfaces : composite dataset, list of surfaces or vtkPolyData
        The samples in order. A surface without the array has a sample in each of its arrays called array_0, array_1 and so on.
        Polygons are triangulated.
    array : str, optional
        Name of the point array with the signal. Default: the positions of the points.
    source : vtkPolyData or pair (points, triangles), optional
        The surface that positions are samples of, with the points and polygons of all samples. Default: the array SourcePosition
        of the first sample, where it has one, else its points.

    Returns
    -------
    SignalDataset

    Raises
    ------
    FormatError
        A surface lacks the array or has no triangle, or the source is not on its triangulation.
    ValueError, TypeError
        An argument has a value out of its range or is of a wrong type.
    """
    name = POSITION if array is None else array_name("array", array)
    given = None if source is None else given_dataset(source, (vtkPolyData,), "a vtkPolyData or a pair of arrays")
    sources = []
    for number, surface in enumerate(leaves_of(ensemble_of("surfaces", surfaces))):
        values = _values(surface, number, array)
        mesh = from_polydata(surface, triangles=True)
        triangles = mesh.connectivity.reshape(-1, 3)
        if len(triangles) == 0:
            raise FormatError(f"surface {number} has no triangle")
        points = _source_points(surface, mesh, given, number) if array is None else np.asarray(mesh.points, np.float64)
        if not (sources and _continues(sources[-1], points, triangles, values, array, surface)):
            sources.append((points, triangles, []))
        sources[-1][2].extend(values)
    return SignalDataset(name, [SignalSource(p, t, np.stack(s).astype(np.float32)) for p, t, s in sources])


def leaves_of(dataset):
    """The surfaces of a dataset in order."""
    if isinstance(dataset, vtkPolyData):
        return [dataset]
    found, iterator = [], dataset.NewTreeIterator()
    iterator.InitTraversal()
    while not iterator.IsDoneWithTraversal():
        leaf = iterator.GetCurrentDataObject()
        if not isinstance(leaf, vtkPolyData):
            raise FormatError(f"the samples must be surfaces, not a {leaf.GetClassName()}")
        found.append(leaf)
        iterator.GoToNextItem()
    return found


def _moved(surface, samples):
    """A block for each sample, of the polygons of a surface."""
    blocks = vtkMultiBlockDataSet()
    for block, (number, positions) in enumerate(samples):
        sample, points = vtkPolyData(), vtkPoints()
        points.SetData(numpy_to_vtk(np.ascontiguousarray(positions)))
        sample.SetPoints(points)
        sample.SetPolys(surface.GetPolys())
        if block == 0:
            _add_array(sample, SOURCE_POSITION, vtk_to_numpy(surface.GetPoints().GetData()))
        blocks.SetBlock(block, sample)
        blocks.GetMetaData(block).Set(vtkCompositeDataSet.NAME(), f"Sample {number}")
    return blocks


def _with_arrays(surface, name, samples):
    for number, values in samples:
        _add_array(surface, f"{name}_{number}", values)
    return surface


def _add_array(surface, name, values):
    array = numpy_to_vtk(np.ascontiguousarray(values))
    array.SetName(name)
    surface.GetPointData().AddArray(array)


def _values(surface, number, array):
    """The samples of a surface, [V, C] each."""
    data = surface.GetPointData()
    if array is None:
        found = [surface.GetPoints().GetData()] if surface.GetNumberOfPoints() else []
    elif data.HasArray(array):
        found = [data.GetArray(array)]
    else:
        numbered = [data.GetArrayName(k) or "" for k in range(data.GetNumberOfArrays())]
        numbered = [one for one in numbered if one.startswith(f"{array}_") and one[len(array) + 1 :].isdigit()]
        found = [data.GetArray(one) for one in sorted(numbered, key=lambda one: int(one[len(array) + 1 :]))]
    if not found or None in found:
        raise FormatError(f"surface {number} has no numeric point array '{array}'" if array else f"surface {number} is empty")
    return [vtk_to_numpy(one).reshape(surface.GetNumberOfPoints(), -1) for one in found]


def _source_points(surface, mesh, given, number):
    """Positions of the source of a sample of positions, [V, 3] float64."""
    if given is None:
        stored = surface.GetPointData().GetArray(SOURCE_POSITION)
        return np.asarray(mesh.points if stored is None else vtk_to_numpy(stored), np.float64)
    source = from_polydata(given, triangles=True)
    if len(source.points) != len(mesh.points) or not np.array_equal(source.connectivity, mesh.connectivity):
        raise FormatError(f"surface {number} has other points or polygons than the source")
    return np.asarray(source.points, np.float64)


def _continues(last, points, triangles, values, array, surface):
    """True when a surface has further samples on the source of those before it."""
    if array is None and surface.GetPointData().HasArray(SOURCE_POSITION) and not np.array_equal(last[0], points):
        return False
    same = len(last[0]) == len(points) and np.array_equal(last[1], triangles) and last[2][0].shape == values[0].shape
    return same and (array is None or np.array_equal(last[0], points))
