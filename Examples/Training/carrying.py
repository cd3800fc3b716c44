# SPDX-License-Identifier: BSD-3-Clause
"""Signals of one triangulation of a shape at the points of another."""

import numpy as np
from vtkmodules.vtkCommonCore import reference
from vtkmodules.vtkCommonDataModel import vtkCellLocator, vtkGenericCell

from surfacesynthesis.files.polygons import mesh_of_triangles, to_polydata


def carried(signals, mesh, points):
    """Signals [N, V, C] of a surface at the places that are nearest to points."""
    if np.array_equal(mesh[0], points):
        return signals
    locator, cell, closest = vtkCellLocator(), vtkGenericCell(), [0.0, 0.0, 0.0]
    locator.SetDataSet(to_polydata(mesh_of_triangles(*mesh)))
    locator.BuildLocator()
    corners, shares = np.empty((len(points), 3), dtype=int), np.empty((len(points), 3))
    for number, point in enumerate(points):
        triangle = reference(0)
        locator.FindClosestPoint(point, closest, cell, triangle, reference(0), reference(0.0))
        corners[number] = mesh[1][int(triangle)]
        a, b, c = (mesh[0][corner] for corner in corners[number])
        parts = np.linalg.lstsq(np.stack([b - a, c - a], axis=1), np.array(closest) - a, rcond=None)[0]
        shares[number] = 1.0 - parts.sum(), *parts
    return sum(shares[:, k, None] * signals[:, corners[:, k]] for k in range(3))
