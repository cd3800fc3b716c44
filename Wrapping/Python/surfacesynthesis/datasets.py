# SPDX-License-Identifier: BSD-3-Clause
"""Arguments and results of the package's functions: VTK's datasets, subclasses of them, and pairs of NumPy arrays."""

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonDataModel import vtkDataObjectTree, vtkPolyData

from .files.polygons import mesh_of_triangles, to_polydata

#: The datasets that a function on surfaces takes, and their description in messages.
SURFACES = (vtkPolyData, vtkDataObjectTree)
SURFACES_TEXT = "a vtkPolyData, a composite dataset or a pair of arrays (points, triangles)"


def given_dataset(mesh, accepted=SURFACES, text=SURFACES_TEXT):
    """The dataset that ``mesh``, a dataset or a pair (points, triangles), stands for; raises TypeError."""
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
    if len(pair) != 2:
        raise TypeError(f"mesh must be a pair (points, triangles), not a {type(pair).__name__} of length {len(pair)}")
    points, triangles = np.asarray(pair[0]), np.asarray(pair[1])
    if points.dtype.kind not in "fiu":
        raise TypeError(f"points must be an array of real numbers, not of {points.dtype}")
    if triangles.dtype.kind not in "iu" and triangles.size > 0:
        raise TypeError(f"triangles must be an array of integers, not of {triangles.dtype}")
    for array, what in ((points, "points"), (triangles, "triangles")):
        if array.size > 0 and (array.ndim != 2 or array.shape[1] != 3):
            shape = "[V, 3]" if what == "points" else "[F, 3]"
            raise ValueError(f"{what} must have the shape {shape}, not {list(array.shape)}")
    if points.dtype not in (np.float32, np.float64):
        points = points.astype(np.float64)
    if triangles.dtype.kind == "u":  # so that ids too large for VTK do not become small ones
        triangles = np.minimum(triangles, np.iinfo(np.int64).max)
    return to_polydata(mesh_of_triangles(points.reshape(-1, 3), triangles.reshape(-1, 3)))


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
