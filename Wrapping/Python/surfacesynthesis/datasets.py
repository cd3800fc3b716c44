# SPDX-License-Identifier: BSD-3-Clause
"""Arguments and results of the package's functions: VTK's datasets, subclasses of them, and pairs of NumPy arrays."""

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import VTK_TETRA, vtkCellArray, vtkDataObjectTree, vtkPolyData, vtkUnstructuredGrid

from .files.polygons import mesh_of_triangles, to_polydata

#: The datasets that a function on surfaces takes, and their description in messages.
SURFACES = (vtkPolyData, vtkDataObjectTree)
SURFACES_TEXT = "a vtkPolyData, a composite dataset or a pair of arrays (points, triangles)"
#: Those that a function on surfaces and volumes takes.
DOMAINS = (*SURFACES, vtkUnstructuredGrid)
DOMAINS_TEXT = (
    "a vtkPolyData, a vtkUnstructuredGrid, a composite dataset or a pair of arrays (points, triangles or tetrahedra)"
)


def given_dataset(mesh, accepted=SURFACES, text=SURFACES_TEXT):
    """The dataset that ``mesh``, a dataset or a pair (points, triangles), stands for; raises TypeError. Where grids are
    accepted, a pair may have tetrahedra, [T, 4], in place of triangles."""
    if isinstance(mesh, (tuple, list)) and vtkUnstructuredGrid in accepted and _has_tetrahedra(mesh):
        return volume_of_pair(mesh)
    if isinstance(mesh, (tuple, list)) and vtkPolyData in accepted:
        return dataset_of_pair(mesh)
    if not isinstance(mesh, accepted):
        raise TypeError(f"mesh must be {text}, not {type(mesh).__name__}")
    return mesh


def as_type_of(mesh, output):
    """``output`` as an instance of the class of ``mesh``, where that is a Python subclass which allows it."""
    wanted = type(mesh)
    if type(output) is wanted:
        return output
    for arguments in ((output,), ()):
        try:
            result = wanted(*arguments)
            if not arguments:
                result.ShallowCopy(output)
        except Exception:  # the constructor is the caller's; whatever it raises, the plain dataset is right
            continue
        if isinstance(result, type(output)) and result.GetNumberOfPoints() == output.GetNumberOfPoints():
            return result
    return output


def dataset_of_pair(pair):
    """The surface of an array of points [V, 3] and an integer array of triangles [F, 3]."""
    points, triangles = _arrays_of_pair(pair, "triangles", "F", 3)
    return to_polydata(mesh_of_triangles(points, triangles))


def volume_of_pair(pair):
    """The grid of an array of points [V, 3] and an integer array of tetrahedra [T, 4]."""
    points, tetrahedra = _arrays_of_pair(pair, "tetrahedra", "T", 4)
    grid, places, cells = vtkUnstructuredGrid(), vtkPoints(), vtkCellArray()
    places.SetData(numpy_to_vtk(np.ascontiguousarray(points), deep=True))
    grid.SetPoints(places)
    cells.SetData(4, numpy_to_vtkIdTypeArray(np.ascontiguousarray(tetrahedra, dtype=np.int64).reshape(-1), deep=True))
    grid.SetCells(VTK_TETRA, cells)
    return grid


def _has_tetrahedra(pair):
    cells = np.asarray(pair[1]) if len(pair) == 2 else np.zeros(0)
    return cells.ndim == 2 and cells.shape[1] == 4


def _arrays_of_pair(pair, name, count, corners):
    """Points [V, 3] and ids [count, corners] of a pair."""
    if len(pair) != 2:
        raise TypeError(f"mesh must be a pair (points, {name}), not a {type(pair).__name__} of length {len(pair)}")
    points, cells = np.asarray(pair[0]), np.asarray(pair[1])
    if points.dtype.kind not in "fiu":
        raise TypeError(f"points must be an array of real numbers, not of {points.dtype}")
    if cells.dtype.kind not in "iu" and cells.size > 0:
        raise TypeError(f"{name} must be an array of integers, not of {cells.dtype}")
    for array, what, rows, columns in ((points, "points", "V", 3), (cells, name, count, corners)):
        if array.size > 0 and (array.ndim != 2 or array.shape[1] != columns):
            raise ValueError(f"{what} must have the shape [{rows}, {columns}], not {list(array.shape)}")
    if points.dtype not in (np.float32, np.float64):
        points = points.astype(np.float64)
    if cells.dtype.kind == "u":  # so that ids too large for VTK do not become small ones
        cells = np.minimum(cells, np.iinfo(np.int64).max)
    return points.reshape(-1, 3), cells.reshape(-1, corners)


def array_by_name(dataset, argument, value, name, is_pair, smallest_rank):
    """``value``; or, for an array of point values, the name that it gets in ``dataset``, which is ours for a pair."""
    if not isinstance(value, np.ndarray) or value.ndim < smallest_rank:
        return value
    if not is_pair:
        raise TypeError(f"{argument} may be an array with a pair of arrays only; name a point array of the mesh")
    if value.dtype.kind not in "fiub" or value.ndim > 2 or len(value) != dataset.GetNumberOfPoints():
        raise ValueError(
            f"{argument} must be an array of numbers with a row for each of the {dataset.GetNumberOfPoints()} points, "
            f"not of {value.dtype} {list(value.shape)}"
        )
    array = numpy_to_vtk(np.ascontiguousarray(value, dtype=np.float64), deep=True)
    array.SetName(name)
    dataset.GetPointData().AddArray(array)
    return name
