# SPDX-License-Identifier: BSD-3-Clause
"""The filter on volumes through its proxy, in pvpython: results, properties, defaults, states."""

import os
import subprocess
import sys

import numpy as np
import proxies
import surfaces
from paraview import smstate
from paraview.simple import *  # noqa: F403: as scripts of ParaView do
from proxies import check_properties, made_by, output_of
from surfacesynthesis import vtkVDBSurfaceFilter  # before the first object of it: else Python knows it as its base class
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkMultiBlockDataSet

# property: (default, another value, what GetX() of the VTK class then returns)
PROPERTIES = {
    "ComputeIsoValue": (1, 0, False),
    "IsoValue": (None, 0.75, 0.75),
    "InsideRule": ("Above", "Below", 1),
    "VoxelSize": (0.0, 1.5, 1.5),
    "Closing": (0.0, 2.0, 2.0),
    "Smoothing": ("None", "Mean Curvature", 2),
    "SmoothingIterations": (3, 1, 1),
    "Offset": (0.0, -0.5, -0.5),
    "Adaptivity": (0.0, 0.25, 0.25),
    "FillCavities": (0, 1, True),
    "LargestComponent": (0, 1, True),
    "MaximumNumberOfVoxels": (200000000, 1000000, 1000000),
}


def image():
    """Two fields on a lattice that is neither isotropic nor at the origin: a ball, and a ramp."""
    made = vtkImageData()
    made.SetDimensions(20, 24, 28)
    made.SetSpacing(1.0, 0.8, 0.7)
    made.SetOrigin(-3.0, 5.0, 7.0)
    z, y, x = np.meshgrid(np.arange(28) * 0.7 - 9.45, np.arange(24) * 0.8 - 9.2, np.arange(20) - 9.5, indexing="ij")
    for name, values in (("Ball", 7.0 - np.sqrt(x**2 + y**2 + z**2)), ("Ramp", x - 2.0 * y)):
        array = surfaces.numpy_to_vtk(values.ravel(), deep=True)
        array.SetName(name)
        made.GetPointData().AddArray(array)
    made.GetPointData().SetActiveScalars("Ramp")
    return made


def expected_surface(data, array=None, **properties):
    """The output of vtkVDBSurfaceFilter used from VTK's Python, without ParaView."""
    made = vtkVDBSurfaceFilter()
    if array:
        made.SetInputArrayToProcess(0, 0, 0, 0, array)
    return made_by(made, data, **properties)


def source_of(data):
    source = proxies.source_of(data)
    source.UpdatePipeline()
    return source


def assert_same_surface(found, expected, what):
    assert found.GetNumberOfPolys() > 100, what
    for of in (lambda s: s.GetPoints().GetData(), lambda s: s.GetPolys().GetConnectivityArray()):
        a, b = (surfaces.vtk_to_numpy(of(surface)) for surface in (found, expected))
        assert a.shape == b.shape and (a == b).all(), what


def proxy_gives_what_the_class_gives():
    made = VDBSurface(Input=source_of(image()), Scalars=["POINTS", "Ball"], ComputeIsoValue=0, IsoValue=0.5)
    for settings in ({}, {"VoxelSize": 1.1, "Smoothing": 2, "Offset": 0.3}, {"Adaptivity": 0.4}):
        for name, value in settings.items():
            setattr(made, name, value)
        now = {"VoxelSize": made.VoxelSize, "Offset": made.Offset, "Adaptivity": made.Adaptivity,
               "Smoothing": made.GetClientSideObject().GetSmoothing()}
        expected = expected_surface(image(), "Ball", ComputeIsoValue=False, IsoValue=0.5, **{**now, **settings})
        found = output_of(made)
        assert_same_surface(found, expected, settings)
        surfaces.assert_same(surfaces.array(found, "Ramp"), surfaces.array(expected, "Ramp"), "Ramp")


def surfaces_and_blocks_give_what_the_class_gives():
    assert_same_surface(
        output_of(VDBSurface(Input=source_of(surfaces.fin()), VoxelSize=0.1)),
        expected_surface(surfaces.fin(), VoxelSize=0.1), "three triangles on an edge")
    blocks = vtkMultiBlockDataSet()
    blocks.SetBlock(0, surfaces.ball())
    blocks.SetBlock(2, image())
    found, expected = output_of(VDBSurface(Input=source_of(blocks))), expected_surface(blocks)
    for block in (0, 2):
        assert_same_surface(found.GetBlock(block), expected.GetBlock(block), f"block {block}")


def properties_have_the_defaults_of_the_class_and_reach_it():
    made = VDBSurface(Input=source_of(image()))
    assert "Scalars" in made.ListProperties()
    check_properties(made, PROPERTIES)


def the_isovalue_comes_from_the_range_and_is_shown():
    made = VDBSurface(Input=source_of(image()), Scalars=["POINTS", "Ball"])
    made.UpdatePipeline()
    made.UpdatePropertyInformation()
    found = made.GetProperty("EffectiveIsoValue").GetData()
    held = vtkVDBSurfaceFilter()
    held.SetInputDataObject(image())
    held.SetInputArrayToProcess(0, 0, 0, 0, "Ball")
    held.Update()
    assert found == held.GetEffectiveIsoValue() != 0.0, found


def write_state():
    writer = surfaces.write(surfaces.ball(), "state_ball.vtp")
    reader = XMLPolyDataReader(registrationName="surface", FileName=[os.path.abspath(writer)])
    values = {name: other for name, (_, other, _) in PROPERTIES.items() if name not in ("VoxelSize", "Closing", "Offset")}
    made = VDBSurface(registrationName="closed", Input=reader, VoxelSize=0.1, Closing=0.2, Offset=0.05, **values)
    surfaces.write(output_of(made), "state_expected.vtp")
    SaveState("state.pvsm")
    with open("state.py", "w", encoding="utf-8") as file:
        file.write(smstate.get_state())
    assert "VDBSurface(" in open("state.py", encoding="utf-8").read()


def compare_with_written():
    made = FindSource("closed")
    for name, (_, other, _) in PROPERTIES.items():
        expected = {"VoxelSize": 0.1, "Closing": 0.2, "Offset": 0.05}.get(name, other)
        assert getattr(made, name) == expected, f"{name} is {getattr(made, name)}"
    assert_same_surface(output_of(made), surfaces.read("state_expected.vtp"), "after the state was loaded")


def xml_state():
    LoadState("state.pvsm")
    compare_with_written()


def python_state():
    with open("state.py", encoding="utf-8") as file:
        exec(compile(file.read(), "state.py", "exec"), dict(globals()))
    compare_with_written()


def states_round_trip_in_another_process():
    for name in ("xml_state", "python_state"):
        result = subprocess.run(
            [os.environ["SURFACE_SYNTHESIS_PVPYTHON"], os.path.abspath(__file__), name],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=100)
        assert result.returncode == 0 and "1 of 1 tests passed" in result.stdout, result.stdout


LoadPlugin(surfaces.plugin(), remote=False, ns=globals())
if len(sys.argv) > 1:
    surfaces.run({"xml_state": xml_state, "python_state": python_state}[sys.argv[1]])
else:
    surfaces.run(
        proxy_gives_what_the_class_gives,
        surfaces_and_blocks_give_what_the_class_gives,
        properties_have_the_defaults_of_the_class_and_reach_it,
        the_isovalue_comes_from_the_range_and_is_shown,
        write_state,
        states_round_trip_in_another_process,
    )
