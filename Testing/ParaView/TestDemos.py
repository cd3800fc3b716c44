# SPDX-License-Identifier: BSD-3-Clause
"""Each demo state of Examples opens without an error and shows something, on small meshes; each filter has one."""

import os

import numpy as np
import surfaces
from paraview.simple import *  # noqa: F403: as scripts of ParaView do
from vtkmodules.vtkCommonCore import vtkOutputWindow, vtkStringOutputWindow
from vtkmodules.vtkIOImage import vtkPNGReader

os.environ["SURFACE_SYNTHESIS_QUICK"] = "1"
LoadPlugin(surfaces.plugin(), remote=False, ns=globals())
FOLDER = os.environ["SURFACE_SYNTHESIS_EXAMPLES"]
HELPERS = {"demo.py", "figure.py", "screenshot.py", "MaternNoise.py"}  # the last one: TestExample.py
STATES = sorted(name[:-3] for name in os.listdir(FOLDER) if name.endswith(".py") and name not in HELPERS)


def pixels_of(state):
    """The colors of the picture of a state, which reports no error."""
    window = vtkStringOutputWindow()
    before = vtkOutputWindow.GetInstance()
    vtkOutputWindow.SetInstance(window)
    try:
        path = os.path.join(FOLDER, state + ".py")
        with open(path, encoding="utf-8") as file:
            exec(compile(file.read(), path, "exec"), {**globals(), "__file__": path})
        view = GetActiveView()
        view.ViewSize = [450, 350]
        Render(view)
        SaveScreenshot(state + ".png", view)
    finally:
        vtkOutputWindow.SetInstance(before)
    assert "ERROR" not in window.GetOutput(), window.GetOutput()
    reader = vtkPNGReader()
    reader.SetFileName(state + ".png")
    reader.Update()
    return surfaces.vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars())[:, :3].astype(int)


def first_views_show_what_the_filters_do():
    """Holes in color and results in color, also on data with scalars; tetrahedra with their edges."""
    mesh = surfaces.ball(size=8)
    height = surfaces.vtk_to_numpy(mesh.GetPoints().GetData())[:, 2].copy()
    heights = surfaces.numpy_to_vtk(height, deep=True)
    heights.SetName("Height")
    mesh.GetPointData().SetScalars(heights)
    view = CreateView("RenderView")
    ball = XMLPolyDataReader(FileName=[surfaces.write(mesh, "first_view.vtp")])
    ball.UpdatePipeline()
    below = Threshold(Input=ball, Scalars=["POINTS", "Height"], LowerThreshold=-2.0, UpperThreshold=0.95)
    cut = ExtractSurface(Input=below)
    repaired = Show(SurfaceRepair(Input=cut, HoleFilling="All"), view)
    assert list(repaired.ColorArrayName) == ["CELLS", "FilledHole"], repaired.ColorArrayName
    predicted = Show(PoissonNet(Input=ball, ModelFileName=os.path.join(FOLDER, os.pardir, "Models", "smoothed_curvature.safetensors")), view)
    assert list(predicted.ColorArrayName) == ["POINTS", "Prediction"], predicted.ColorArrayName
    tetrahedra = Show(TetrahedralizeSurface(Input=ball), view)
    assert tetrahedra.Representation == "Surface With Edges", tetrahedra.Representation
    ResetSession()


def test_of(state):
    def shows_something():
        pixels = pixels_of(state)
        ResetSession()
        drawn = np.count_nonzero(np.abs(pixels - pixels[0]).max(axis=1) > 30)
        assert drawn > len(pixels) // 100, f"{drawn} pixels of {len(pixels)} differ from the background"
        assert len(np.unique(pixels, axis=0)) > 20

    shows_something.__name__ = f"{state}_shows_something"
    return shows_something


def each_filter_has_a_state():
    offered = {name[:-4] for name in os.listdir(os.path.join(FOLDER, os.pardir, os.pardir, "Wrapping", "ParaView"))
               if name.endswith(".xml")} - {"ModelTrainer", "MaternNoise", "Tetrahedralize"}
    assert offered | {"TetrahedralizeSurface"} == set(STATES), offered ^ set(STATES)


STATES_SHOWN = set(STATES)
if os.environ.get("SURFACE_SYNTHESIS_LEARNING") == "0":
    STATES_SHOWN -= {"FieldLatentTrainer", "FlowMatchingTrainer", "GeometricTextureTrainer", "LatentDiffusionTrainer",
                     "MultiscaleMeshFitter"}
surfaces.run(each_filter_has_a_state, first_views_show_what_the_filters_do, *map(test_of, sorted(STATES_SHOWN)))
