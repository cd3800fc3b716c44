# SPDX-License-Identifier: BSD-3-Clause
"""Polygon meshes as NumPy arrays, the form between the text formats and vtkPolyData."""

from types import MappingProxyType
from typing import Mapping, NamedTuple

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkTriangleFilter


class PolygonMesh(NamedTuple):
    """``points`` [V, 3] float; polygon p has the points ``connectivity[offsets[p]:offsets[p + 1]]`` (int64);
    ``arrays`` maps names to point arrays [V] or [V, C], ``cell_arrays`` to those of polygons."""

    points: np.ndarray
    offsets: np.ndarray
    connectivity: np.ndarray
    arrays: dict
    cell_arrays: Mapping = MappingProxyType({})


def mesh_of_triangles(points, triangles):
    """The PolygonMesh of points [V, 3] and triangles [F, 3]."""
    offsets = np.arange(0, 3 * len(triangles) + 1, 3, dtype=np.int64)
    return PolygonMesh(points, offsets, np.ascontiguousarray(triangles, dtype=np.int64).reshape(-1), {})


def add_array(data, name, values):
    """Adds a copy of the values [N] or [N, C] to point or cell data."""
    values = np.ascontiguousarray(values, dtype=values.dtype.newbyteorder("="))
    array = numpy_to_vtk(values, deep=True)
    array.SetName(name)
    data.AddArray(array)


def to_polydata(mesh):
    """A vtkPolyData that owns copies of the arrays of a PolygonMesh."""
    points = vtkPoints()
    coordinates = np.ascontiguousarray(mesh.points, dtype=mesh.points.dtype.newbyteorder("="))
    points.SetData(numpy_to_vtk(coordinates, deep=True))
    cells = vtkCellArray()
    cells.SetData(
        numpy_to_vtkIdTypeArray(np.ascontiguousarray(mesh.offsets, dtype=np.int64), deep=True),
        numpy_to_vtkIdTypeArray(np.ascontiguousarray(mesh.connectivity, dtype=np.int64), deep=True),
    )
    polydata = vtkPolyData()
    polydata.SetPoints(points)
    polydata.SetPolys(cells)
    for data, arrays in ((polydata.GetPointData(), mesh.arrays), (polydata.GetCellData(), mesh.cell_arrays)):
        for name, values in arrays.items():
            add_array(data, name, values)
    data = polydata.GetPointData()
    if "TCoords" in mesh.arrays:
        data.SetActiveTCoords("TCoords")
    if "Normals" in mesh.arrays:
        data.SetActiveNormals("Normals")
    return polydata


def named_by_role(polydata):
    """A shallow copy whose active normals and texture coordinates are called "Normals" and "TCoords"."""
    result = polydata.NewInstance()
    result.ShallowCopy(polydata)
    data = result.GetPointData()
    for name, array in (("Normals", data.GetNormals()), ("TCoords", data.GetTCoords())):
        if array is not None and array.GetName() != name:
            renamed = array.NewInstance()
            renamed.DeepCopy(array)
            renamed.SetName(name)
            data.AddArray(renamed)
    return result


def from_polydata(polydata, triangles=False):
    """The PolygonMesh of a vtkPolyData: its polygons, and the triangles of its strips; vertices and lines are left out.

    With ``triangles``, polygons are triangulated.
    """
    if polydata.GetNumberOfStrips() > 0 or triangles:
        strips = vtkTriangleFilter()
        strips.SetInputData(polydata)
        strips.PassVertsOff()
        strips.PassLinesOff()
        strips.Update()
        polydata = strips.GetOutput()
    if polydata.GetNumberOfPoints() == 0:
        return PolygonMesh(np.zeros((0, 3)), np.zeros(1, dtype=np.int64), np.zeros(0, dtype=np.int64), {})
    cells = polydata.GetPolys()
    data = polydata.GetPointData()
    arrays = {}
    for index in range(data.GetNumberOfArrays()):
        array = data.GetArray(index)  # None for arrays of strings
        if array is not None and array.GetName():
            arrays[array.GetName()] = vtk_to_numpy(array)
    offsets = vtk_to_numpy(cells.GetOffsetsArray()).astype(np.int64)
    if len(offsets) == 0:
        offsets = np.zeros(1, dtype=np.int64)
    connectivity = vtk_to_numpy(cells.GetConnectivityArray()).astype(np.int64)
    return PolygonMesh(vtk_to_numpy(polydata.GetPoints().GetData()), offsets, connectivity, arrays)


def point_normals(polydata):
    """Unit normals [V, 3] of the points of a vtkPolyData: the area-weighted mean of the normals of the triangles at
    each point, with the winding that the cells have; 0 at points without triangles."""
    mesh = from_polydata(polydata, triangles=True)
    corners = mesh.connectivity.reshape(-1, 3)
    points = mesh.points.astype(np.float64)
    a, b, c = (points[corners[:, k]] for k in range(3))
    twice_area = np.cross(b - a, c - a)
    normals = np.zeros((polydata.GetNumberOfPoints(), 3))
    for axis in range(3):
        for k in range(3):
            normals[:, axis] += np.bincount(corners[:, k], twice_area[:, axis], minlength=len(normals))
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.divide(normals, length, out=np.zeros_like(normals), where=length > 0)
