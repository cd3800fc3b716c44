# SPDX-License-Identifier: BSD-3-Clause
"""Surfaces and helpers that the tests share."""

import os

import numpy as np
import pytest
from command_processes import CommandProcesses
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkFiltersSources import vtkPlatonicSolidSource

from surfacesynthesis.files.polygons import mesh_of_triangles, to_polydata


def icosphere(levels, radius=1.0):
    """Points [V, 3] and triangles [F, 3] of a closed sphere of nearly equal triangles."""
    source = vtkPlatonicSolidSource()
    source.SetSolidTypeToIcosahedron()
    source.SetOutputPointsPrecision(1)
    source.Update()
    output = source.GetOutput()
    points = list(vtk_to_numpy(output.GetPoints().GetData()))
    triangles = vtk_to_numpy(output.GetPolys().GetConnectivityArray()).reshape(-1, 3).tolist()
    for _ in range(levels):
        middles = {}

        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in middles:
                middles[key] = len(points)
                points.append(points[a] + points[b])
            return middles[key]

        finer = []
        for a, b, c in triangles:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        points = [point / np.linalg.norm(point) for point in points]
        triangles = finer
    points = np.array([point / np.linalg.norm(point) for point in points])
    triangles = np.array(triangles)
    a, b, c = (points[triangles[:, k]] for k in range(3))
    inwards = np.einsum("fx,fx->f", np.cross(b - a, c - a), a) < 0  # the source does not turn all faces the same way
    triangles[inwards] = triangles[inwards][:, [0, 2, 1]]
    return radius * points, triangles


def polydata_of(points, triangles):
    """The vtkPolyData of a pair."""
    return to_polydata(mesh_of_triangles(np.asarray(points), np.asarray(triangles)))


def add_array(data, name, values):
    """Adds a point or cell array."""
    array = numpy_to_vtk(np.asarray(values), deep=True)
    array.SetName(name)
    data.AddArray(array)


def points_of(mesh):
    """The points of a dataset, as an array."""
    return vtk_to_numpy(mesh.GetPoints().GetData())


def point_array(mesh, name):
    """A point array of a dataset."""
    return vtk_to_numpy(mesh.GetPointData().GetArray(name))


@pytest.fixture
def ball():
    """A sphere of 162 points."""
    return icosphere(2)


@pytest.fixture(scope="session")
def pair():
    """A sphere of 642 points: edges of about 0.15."""
    return icosphere(3)


@pytest.fixture
def sphere(pair):
    """The same sphere as a vtkPolyData with an array on the points and one on the cells."""
    mesh = polydata_of(*pair)
    add_array(mesh.GetPointData(), "height", pair[0][:, 2])
    add_array(mesh.GetCellData(), "number", np.arange(len(pair[1])))
    return mesh


_processes = CommandProcesses()


def run_command(*arguments, cwd=None):
    """Runs the command line in a process of its own."""
    return _processes.run(arguments, cwd)


def read_terminal(leader):
    """All that is written to a pseudo-terminal until its other end is closed; closes this end."""
    shown = b""
    while True:
        try:
            piece = os.read(leader, 4096)
        except OSError:  # the other end is closed
            break
        if not piece:
            break
        shown += piece
    os.close(leader)
    return shown


def files_in(folder):
    """All files below a folder, hidden ones too."""
    return sorted(os.path.relpath(os.path.join(top, name), folder) for top, _, names in os.walk(folder) for name in names)
