# SPDX-License-Identifier: BSD-3-Clause
"""Observations of fields: the arguments ``observations``, ``observation_array`` and ``observation_deviation_array``."""

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkPointSet, vtkPolyData

from .arguments import array_name, at_least_0

_VALUES = "_ObservedValues"
_DEVIATIONS = "_ObservedDeviations"


def observe(algorithm, observations, observation_array, observation_deviation_array, tolerance):
    """Gives a filter its observations, if there are any, by properties and the second input."""
    algorithm.SetTolerance(0.0 if tolerance is None else at_least_0("tolerance", tolerance))
    arrays = [("observation_array", observation_array, _VALUES)]
    if observation_deviation_array is not None:
        arrays.append(("observation_deviation_array", observation_deviation_array, _DEVIATIONS))
    if observations is None and any(isinstance(value, np.ndarray) for _, value, _ in arrays):
        raise ValueError("arrays of observed values go with observations, which says where they were observed")
    dataset = None if observations is None else _dataset_of(observations)
    names = [_name_in(dataset, argument, value, name) for argument, value, name in arrays]
    algorithm.SetObservationArray(names[0])
    if len(names) > 1:
        algorithm.SetObservationDeviationArray(names[1])
    if dataset is not None:
        algorithm.SetInputDataObject(1, dataset)


def _dataset_of(observations):
    """A copy of a vtkPointSet, or a vtkPolyData with the points of an array [n, 3]."""
    if isinstance(observations, vtkPointSet):
        dataset = observations.NewInstance()
        dataset.ShallowCopy(observations)
        return dataset
    points = np.asarray(observations)
    if points.dtype.kind not in "fiu" or points.ndim != 2 or points.shape[1] != 3:
        raise TypeError(
            f"observations must be a vtkPointSet or an array of points [n, 3], not {type(observations).__name__} "
            f"{points.dtype} {list(points.shape)}"
        )
    dataset, made = vtkPolyData(), vtkPoints()
    made.SetData(numpy_to_vtk(np.ascontiguousarray(points, dtype=np.float64), deep=True))
    dataset.SetPoints(made)
    return dataset


def _name_in(dataset, argument, value, name):
    """The name of an array of the dataset; an array of numbers [n] or [n, C] becomes one."""
    if value is None:
        return ""
    if not isinstance(value, np.ndarray):
        return array_name(argument, value)
    if value.dtype.kind not in "fiub" or value.ndim not in (1, 2) or len(value) != dataset.GetNumberOfPoints():
        raise ValueError(
            f"{argument} must be an array of numbers with a row for each of the {dataset.GetNumberOfPoints()} "
            f"observations, not of {value.dtype} {list(value.shape)}"
        )
    array = numpy_to_vtk(np.ascontiguousarray(value, dtype=np.float64), deep=True)
    array.SetName(name)
    dataset.GetPointData().AddArray(array)
    return name
