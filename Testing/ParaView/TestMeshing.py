# SPDX-License-Identifier: BSD-3-Clause
"""The topology report and the tetrahedra through their proxies, in pvpython."""

import numpy as np
import surfaces
from paraview.simple import *  # noqa: F403: as scripts of ParaView do
from proxies import check_properties, errors_of, made_by, output_of, source_of
from surfacesynthesis import vtkTetrahedralizeFilter, vtkTopologyReport
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet

LoadPlugin(surfaces.plugin(), remote=False, ns=globals())

# property: (default, another value, what GetX() of the VTK class then returns)
TETRAHEDRALIZE = {
    "QualityRatio": (2.0, 1.5, 1.5),
    "MinimumDihedralAngle": (0.0, 5.0, 5.0),
    "MaximumVolume": (0.0, 0.5, 0.5),
    "TargetEdgeLength": (0.0, 0.25, 0.25),
    "MaximumNumberOfTetrahedra": (10000000, 1000, 1000),
    "PreserveSurface": (1, 0, False),
    "InnerSurfaces": ("Regions", "Holes", 1),
    "SurfaceTriangles": (0, 1, True),
    "TimeLimit": (300.0, 20.0, 20.0),
    "MemoryLimit": (0, 2000, 2000),
    "RegionArrayName": ("Region", "Part", "Part"),
    "SurfaceArrayName": ("OnSurface", "Skin", "Skin"),
}
REPORT = {"NumberOfComponentRows": (10, 3, 3)}


def properties_have_the_defaults_of_the_class_and_reach_it():
    check_properties(TetrahedralizeSurface(Input=source_of(surfaces.ball())), TETRAHEDRALIZE)
    check_properties(TopologyReport(Input=source_of(surfaces.ball())), REPORT)


def tetrahedra_are_those_of_the_class():
    ball = surfaces.ball(size=8)
    found = output_of(TetrahedralizeSurface(Input=source_of(ball), TargetEdgeLength=0.4))
    expected = made_by(vtkTetrahedralizeFilter(), ball, TargetEdgeLength=0.4)
    assert found.IsA("vtkUnstructuredGrid") and found.GetNumberOfCells() > 100
    for get in (lambda grid: grid.GetPoints().GetData(), lambda grid: grid.GetCells().GetConnectivityArray()):
        assert np.array_equal(vtk_to_numpy(get(found)), vtk_to_numpy(get(expected)))
    assert vtk_to_numpy(found.GetPointData().GetArray("OnSurface")).sum() == ball.GetNumberOfPoints()


def report_is_that_of_the_class():
    found = output_of(TopologyReport(Input=source_of(surfaces.fin())))
    expected = made_by(vtkTopologyReport(), surfaces.fin())
    assert found.IsA("vtkTable") and found.GetNumberOfRows() == expected.GetNumberOfRows() > 30
    for name in ("Block", "Component", "Property", "Value", "First", "Remark"):
        for row in range(found.GetNumberOfRows()):
            assert found.GetValueByName(row, name) == expected.GetValueByName(row, name), (name, row)


def report_tells_whether_the_surface_is_valid():
    for mesh, valid in ((surfaces.ball(), 1), (surfaces.fin(), 0)):
        made = TopologyReport(Input=source_of(mesh))
        made.UpdatePipeline()
        made.UpdatePropertyInformation()
        assert made.GetProperty("Valid").GetData() == valid


def blocks_are_filled_one_by_one():
    blocks = vtkMultiBlockDataSet()
    blocks.SetBlock(0, surfaces.ball(size=4))
    blocks.SetBlock(2, surfaces.ball(size=4, center=3.0))
    found = output_of(TetrahedralizeSurface(Input=source_of(blocks)))
    assert found.GetBlock(0).GetNumberOfCells() > 0 and found.GetBlock(2).GetNumberOfCells() > 0
    report = output_of(TopologyReport(Input=source_of(blocks)))
    assert {report.GetValueByName(row, "Block").ToInt() for row in range(report.GetNumberOfRows())} == {1, 3}


def errors_are_reported_once():
    made = TetrahedralizeSurface(Input=source_of(surfaces.fin()))
    errors = errors_of(made)
    assert len(errors) == 1 and "boundary edge" in errors[0], errors


surfaces.run(
    properties_have_the_defaults_of_the_class_and_reach_it,
    tetrahedra_are_those_of_the_class,
    report_is_that_of_the_class,
    report_tells_whether_the_surface_is_valid,
    blocks_are_filled_one_by_one,
    errors_are_reported_once,
)
