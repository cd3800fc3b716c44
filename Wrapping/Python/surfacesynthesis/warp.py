# SPDX-License-Identifier: BSD-3-Clause
"""Moves the points of a surface by an array of noise."""

from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkPolyData

from .files.polygons import point_normals


def warped(mesh, name, scale):
    """A copy of ``mesh`` whose points p are moved to p + ``scale`` * noise.

    ``name`` is a point array: with one component, noise is its value times the unit normal of the point; with three,
    the vector. Normals are dropped, because they are no longer right. Works on a vtkPolyData and on each block of a
    composite dataset.
    """
    if isinstance(mesh, vtkPolyData):
        return _warped_surface(mesh, name, scale)
    result = mesh.NewInstance()
    result.CopyStructure(mesh)
    blocks = mesh.NewIterator()
    blocks.InitTraversal()
    while not blocks.IsDoneWithTraversal():
        result.SetDataSet(blocks, _warped_surface(blocks.GetCurrentDataObject(), name, scale))
        blocks.GoToNextItem()
    return result


def _warped_surface(surface, name, scale):
    result = vtkPolyData()
    result.ShallowCopy(surface)
    if surface.GetNumberOfPoints() == 0:
        return result
    noise = vtk_to_numpy(surface.GetPointData().GetArray(name))
    direction = point_normals(surface) * noise[:, None] if noise.ndim == 1 else noise
    old = vtk_to_numpy(surface.GetPoints().GetData())
    points = vtkPoints()
    points.SetData(numpy_to_vtk((old + scale * direction).astype(old.dtype), deep=True))
    result.SetPoints(points)
    for data in (result.GetPointData(), result.GetCellData()):
        normals = data.GetNormals()
        if normals is not None:
            data.RemoveArray(normals.GetName())
            data.SetNormals(None)
        data.RemoveArray("Normals")
    return result
