# SPDX-License-Identifier: BSD-3-Clause
"""The surface of the gallery and its triangulations."""

import os
import tarfile

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
from vtkmodules.vtkCommonCore import reference, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData, vtkStaticCellLocator
from vtkmodules.vtkFiltersCore import vtkCleanPolyData, vtkFeatureEdges, vtkQuadricDecimation, vtkTriangleFilter

import surfacesynthesis

ARCHIVE = "/usr/share/doc/libcgal-demo/data.tar.gz"  # Debian's package libcgal-demo
MEMBER = "data/meshes/armadillo.off"


def load(path, folder):
    """Reads the surface at ``path``, or takes the armadillo out of the archive into ``folder`` when it is None."""
    if path is None:
        path = os.path.join(folder, os.path.basename(MEMBER))
        with tarfile.open(ARCHIVE) as archive, open(path, "wb") as file:
            file.write(archive.extractfile(MEMBER).read())
    triangles = vtkTriangleFilter()
    triangles.SetInputData(surfacesynthesis.read_mesh(path))
    triangles.PassVertsOff()
    triangles.PassLinesOff()
    clean = vtkCleanPolyData()
    clean.SetInputConnection(triangles.GetOutputPort())
    clean.PointMergingOff()  # only points without triangles go
    clean.Update()
    return clean.GetOutput()


def arrays_of(mesh):
    """Points [V, 3] float64 and triangles [F, 3] int64."""
    points = vtk_to_numpy(mesh.GetPoints().GetData()).astype(np.float64)
    return points, vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3).astype(np.int64)


def mesh_of(points, triangles):
    """The vtkPolyData of points [V, 3] and triangles [F, 3]."""
    mesh = vtkPolyData()
    mesh.SetPoints(vtkPoints())
    mesh.GetPoints().SetData(numpy_to_vtk(np.ascontiguousarray(points, dtype=np.float64), deep=True))
    offsets = np.arange(0, 3 * len(triangles) + 1, 3)
    cells = vtkCellArray()
    cells.SetData(*(numpy_to_vtkIdTypeArray(ids, deep=True) for ids in (offsets, np.ravel(triangles).astype(np.int64))))
    mesh.SetPolys(cells)
    return mesh


def longest_side(mesh):
    """The longest side of the bounding box."""
    bounds = mesh.GetBounds()
    return max(bounds[2 * axis + 1] - bounds[2 * axis] for axis in range(3))


def decimated(mesh, vertices):
    """The surface with about so many vertices. Decimation may make an edge with three triangles; then it is done again
    with a few more or fewer vertices."""
    for more in (1.0, 1.04, 0.96, 1.1, 0.9, 1.2, 0.8, 1.4, 0.7):
        decimate = vtkQuadricDecimation()
        decimate.SetInputData(mesh)
        decimate.SetTargetReduction(min(max(1.0 - more * vertices / mesh.GetNumberOfPoints(), 0.0), 0.99))
        clean = vtkCleanPolyData()
        clean.SetInputConnection(decimate.GetOutputPort())
        clean.PointMergingOff()
        edges = vtkFeatureEdges()
        edges.SetInputConnection(clean.GetOutputPort())
        edges.BoundaryEdgesOff()
        edges.FeatureEdgesOff()
        edges.ManifoldEdgesOff()
        edges.NonManifoldEdgesOn()
        edges.Update()
        if edges.GetOutput().GetNumberOfCells() == 0:
            return clean.GetOutput()
    raise RuntimeError(f"no decimation to about {vertices} vertices is manifold")


def refined(mesh, selected, levels):
    """The surface with the triangles that ``selected`` (a function of centroids [F, 3]) chooses divided into four,
    ``levels`` times; their neighbours are divided so that no gap opens."""
    points, triangles = arrays_of(mesh)
    for _ in range(levels):
        points, triangles = _refined_once(points, triangles, selected(points[triangles].mean(axis=1)))
    return mesh_of(points, triangles)


def _refined_once(points, triangles, chosen):
    ends = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
    edges, edge_of = np.unique(ends, axis=0, return_inverse=True)
    edge_of = edge_of.reshape(-1, 3)  # edge k of a triangle is the one from corner k to corner k + 1
    split = np.zeros(len(edges), dtype=bool)
    split[edge_of[chosen]] = True
    middle = np.full(len(edges), -1)
    middle[split] = len(points) + np.arange(split.sum())
    points = np.concatenate((points, points[edges[split]].mean(axis=1)))

    corners, middles = triangles, middle[edge_of]
    parts = [corners[(middles < 0).all(axis=1)]]
    full = (middles >= 0).all(axis=1)
    c, m = corners[full], middles[full]
    parts += [np.stack(t, axis=1) for t in ((c[:, 0], m[:, 0], m[:, 2]), (c[:, 1], m[:, 1], m[:, 0]),
                                            (c[:, 2], m[:, 2], m[:, 1]), (m[:, 0], m[:, 1], m[:, 2]))]  # fmt: skip
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        one = (middles[:, k] >= 0) & (middles[:, i] < 0) & (middles[:, j] < 0)
        c, m = corners[one], middles[one][:, k]
        parts += [np.stack(t, axis=1) for t in ((c[:, k], m, c[:, j]), (m, c[:, i], c[:, j]))]
        two = (middles[:, k] >= 0) & (middles[:, i] >= 0) & (middles[:, j] < 0)
        c, m, n = corners[two], middles[two][:, k], middles[two][:, i]
        parts += [np.stack(t, axis=1) for t in ((m, c[:, i], n), (c[:, k], m, n), (c[:, k], n, c[:, j]))]
    return points, np.concatenate(parts)


def projected(mesh, first, surface):
    """``mesh`` with its points from index ``first`` on moved towards the nearest point of ``surface``; not all the way,
    where two of them could meet."""
    locator = vtkStaticCellLocator()
    locator.SetDataSet(surface)
    locator.BuildLocator()
    points, triangles = arrays_of(mesh)
    nearest, cell, sub, distance = [0.0, 0.0, 0.0], reference(0), reference(0), reference(0.0)
    for index in range(first, len(points)):
        locator.FindClosestPoint(points[index], nearest, cell, sub, distance)
        points[index] += 0.9 * (np.array(nearest) - points[index])
    return mesh_of(points, triangles)
