# SPDX-License-Identifier: BSD-3-Clause
"""Surfaces, the filter without ParaView, and comparisons, for the tests of the plugin."""

import os
import sys
import tarfile

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLPolyDataWriter

ARCHIVE = "/usr/share/doc/libcgal-demo/data.tar.gz"  # Debian's package libcgal-demo
MEMBER = "data/meshes/armadillo.off"


def mesh_of(points, triangles):
    """The vtkPolyData of points [V, 3] and triangles [F, 3]."""
    mesh = vtkPolyData()
    mesh.SetPoints(vtkPoints())
    mesh.GetPoints().SetData(numpy_to_vtk(np.ascontiguousarray(points, dtype=np.float64).reshape(-1, 3), deep=True))
    triangles = np.asarray(triangles, dtype=np.int64).reshape(-1, 3)
    cells = vtkCellArray()
    offsets = np.arange(0, 3 * len(triangles) + 1, 3, dtype=np.int64)
    cells.SetData(*(numpy_to_vtkIdTypeArray(ids, deep=True) for ids in (offsets, np.ravel(triangles))))
    mesh.SetPolys(cells)
    return mesh


def armadillo():
    """A scanned surface: 26,002 points, 52,000 triangles, closed."""
    with tarfile.open(ARCHIVE) as archive:
        numbers = archive.extractfile(MEMBER).read().split()
    assert numbers[0] == b"OFF"
    count, faces = int(numbers[1]), int(numbers[2])
    points = np.array(numbers[4:4 + 3 * count], dtype=np.float64).reshape(-1, 3)
    polygons = np.array(numbers[4 + 3 * count:4 + 3 * count + 4 * faces], dtype=np.int64).reshape(-1, 4)
    assert (polygons[:, 0] == 3).all()
    return mesh_of(points, polygons[:, 1:])


def ball(size=24, center=0.0):
    """A closed surface without poles: the surface of a grid of cubes, pushed onto the unit sphere."""
    ids, points, triangles = {}, [], []
    for axis in range(3):
        for side in (-1.0, 1.0):
            for i in range(size):
                for j in range(size):
                    quad = []
                    for a, b in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)):
                        place = np.insert(np.array([a, b]) * 2.0 / size - 1.0, axis, side)
                        key = tuple(np.round(place * size).astype(int))
                        if key not in ids:
                            ids[key] = len(points)
                            points.append(place / np.linalg.norm(place) + center)
                        quad.append(ids[key])
                    if (side > 0.0) == (axis == 1):
                        quad.reverse()
                    triangles += [(quad[0], quad[1], quad[2]), (quad[0], quad[2], quad[3])]
    return mesh_of(points, triangles)


def long_ball(size=10):
    """A closed surface with two extremities: a ball stretched along z."""
    mesh = ball(size)
    vtk_to_numpy(mesh.GetPoints().GetData())[:, 2] *= 3.0
    return mesh


def fin():
    """Three triangles on one edge, which no surface has."""
    return mesh_of([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]], [[0, 1, 2], [1, 0, 3], [0, 1, 4]])


def write(mesh, path):
    writer = vtkXMLPolyDataWriter()
    writer.SetInputDataObject(mesh)
    writer.SetFileName(path)
    writer.SetDataModeToBinary()  # appended data cannot be read with all versions of expat
    assert writer.Write() == 1, path
    return path


def read(path):
    reader = vtkXMLPolyDataReader()
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


def array(mesh, name="MaternNoise"):
    """A point array as numpy array."""
    found = mesh.GetPointData().GetArray(name)
    assert found is not None, f"no array {name}; there are {names(mesh)}"
    return vtk_to_numpy(found)


def names(mesh):
    data = mesh.GetPointData()
    return [data.GetArrayName(k) for k in range(data.GetNumberOfArrays())]


def noise(mesh, **properties):
    """The output of vtkMaternNoiseFilter used from VTK's Python, without ParaView."""
    from surfacesynthesis import vtkMaternNoiseFilter

    made = vtkMaternNoiseFilter()
    made.SetInputDataObject(mesh)
    for name, value in properties.items():
        getattr(made, "Set" + name)(value)
    made.Update()
    return made.GetOutputDataObject(0)


def assert_same(found, expected, what):
    """Bit for bit."""
    assert found.shape == expected.shape, f"{what}: shape {found.shape}, expected {expected.shape}"
    assert found.dtype == expected.dtype, f"{what}: {found.dtype}, expected {expected.dtype}"
    differ = np.count_nonzero(found != expected)
    assert differ == 0, f"{what}: {differ} of {found.size} values differ, by up to {np.abs(found - expected).max()}"
    assert np.isfinite(found).all() and np.std(found) > 0.0, f"{what}: not a field"


def plugin():
    """The path of the plugin's library."""
    return os.environ["SURFACE_SYNTHESIS_PLUGIN"]


def run(*tests):
    """Runs the tests, which are functions without arguments, and exits with 1 when one fails."""
    failed = 0
    for test in tests:
        try:
            test()
            print(f"passed: {test.__name__}", flush=True)
        except Exception:  # every kind of failure is reported, and the next test still runs
            import traceback

            traceback.print_exc()
            print(f"FAILED: {test.__name__}", flush=True)
            failed += 1
    print(f"{len(tests) - failed} of {len(tests)} tests passed", flush=True)
    sys.stdout.flush()
    if failed or not tests:
        os._exit(1)  # sys.exit() in a script of pvbatch does not always set the exit status
