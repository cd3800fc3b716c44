# SPDX-License-Identifier: BSD-3-Clause
"""``mesh.synthesis`` on PyVista's meshes, with a stand-in that has the part of PyVista that is used."""

import os
import subprocess
import sys
import textwrap

STAND_IN = """
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet, vtkPolyData

class PolyData(vtkPolyData):
    def __init__(self, dataset=None):
        if dataset is not None:
            self.ShallowCopy(dataset)

class MultiBlock(vtkMultiBlockDataSet):
    def __init__(self, dataset=None):
        if dataset is not None:
            self.ShallowCopy(dataset)
"""
REGISTRY = """
def register_dataset_accessor(name, target):
    def decorate(accessor):
        setattr(target, name, property(lambda mesh: accessor(mesh)))
        return accessor
    return decorate
"""
USE = """
import sys; sys.path.insert(0, sys.argv[1])
import numpy as np, pyvista, surfacesynthesis
from conftest import icosphere, polydata_of
from vtkmodules.util.numpy_support import vtk_to_numpy
plain = polydata_of(*icosphere(3))
"""


def run(folder, stand_in, code):
    if stand_in is not None:
        (folder / "pyvista.py").write_text(stand_in)
    environment = dict(os.environ, PYTHONPATH=f"{folder}{os.pathsep}{os.environ['PYTHONPATH']}")
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(code), os.path.dirname(__file__)],
        capture_output=True, text=True, check=False, timeout=120, env=environment,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, ""), done


def test_accessor_gives_meshes_of_pyvistas_own_classes(tmp_path):
    code = """
    mesh = pyvista.PolyData(plain)
    result = mesh.synthesis.matern(range=1.0, seed=3)
    assert type(result) is pyvista.PolyData
    values = vtk_to_numpy(result.GetPointData().GetArray("MaternNoise"))
    assert np.array_equal(values, surfacesynthesis.matern_noise(icosphere(3), range=1.0, seed=3))
    assert mesh.GetPointData().GetNumberOfArrays() == 0
    assert "correlation of two points" in mesh.synthesis.matern.__doc__
    blocks = pyvista.MultiBlock()
    blocks.SetBlock(0, mesh)
    result = blocks.synthesis.matern(range=1.0)
    assert type(result) is pyvista.MultiBlock
    assert result.GetBlock(0).GetPointData().GetArray("MaternNoise").GetNumberOfTuples() == 642
    try:
        mesh.synthesis.matern(range=-1.0)
    except ValueError:
        sys.exit(0)
    sys.exit("a negative range was accepted")
    """
    run(tmp_path, STAND_IN + REGISTRY, USE + textwrap.dedent(code))


def test_pyvista_without_a_registry_is_no_error_and_keeps_its_class(tmp_path):
    code = """
    mesh = pyvista.PolyData(plain)
    assert not hasattr(mesh, "synthesis")
    assert type(surfacesynthesis.matern_noise(mesh, range=1.0)) is pyvista.PolyData
    """
    run(tmp_path, STAND_IN, USE + textwrap.dedent(code))


def test_broken_pyvista_is_no_error(tmp_path):
    run(tmp_path, "raise OSError('a library is missing')", "import surfacesynthesis")
    run(tmp_path, STAND_IN + "def register_dataset_accessor(name, target):\n    raise ValueError(name)\n",
        "import surfacesynthesis")  # fmt: skip


def test_absent_pyvista_is_no_error(tmp_path):
    code = """
    import sys
    sys.modules["pyvista"] = None  # importing it raises ImportError
    import surfacesynthesis
    assert surfacesynthesis.accessor.register() is False
    """
    run(tmp_path, None, code)
