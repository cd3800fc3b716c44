# SPDX-License-Identifier: BSD-3-Clause
"""Remeshing, repair and texture atlases through their proxies, in pvpython."""

import numpy as np
import surfaces
from paraview.simple import *  # noqa: F403: as scripts of ParaView do
from proxies import check_properties, made_by, output_of, source_of
from surfacesynthesis import vtkIsotropicRemeshFilter, vtkSurfaceRepairFilter, vtkTextureAtlasFilter
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy

LoadPlugin(surfaces.plugin(), remote=False, ns=globals())

# property: (default, another value, what GetX() of the VTK class then returns)
REMESH = {
    "TargetEdgeLength": (0.0, 0.25, 0.25),
    "TargetNumberOfPoints": (0, 500, 500),
    "SizingArrayName": ("", "size", "size"),
    "KeepFeatureEdges": (1, 0, False),
    "FeatureAngle": (60.0, 30.0, 30.0),
    "KeepBoundaryPoints": (0, 1, True),
    "NumberOfIterations": (3, 5, 5),
    "NumberOfRelaxationSteps": (1, 2, 2),
    "MaximumNumberOfPoints": (10000000, 1000, 1000),
}
REPAIR = {
    "MergePoints": (1, 0, False),
    "MergeTolerance": (0.0, 0.125, 0.125),
    "HoleFilling": ("Small", "All", 2),
    "MaximumHoleSize": (0.0, 0.5, 0.5),
    "KeepLargestComponent": (0, 1, True),
    "MinimumComponentFraction": (0.0, 0.25, 0.25),
    "RemoveSelfIntersections": (0, 1, True),
    "OrientOutward": (1, 0, False),
    "MaximumLoss": (0.05, 0.25, 0.25),
    "Strict": (0, 1, True),
    "ActiveResult": (1, 0, False),
}
ATLAS = {"Margin": (4, 8, 8), "MaximumStretch": (2.0, 1.5, 1.5)}


def sized_ball():
    """A sphere with a point array of wanted edge lengths."""
    mesh = surfaces.ball(size=20)
    z = vtk_to_numpy(mesh.GetPoints().GetData())[:, 2].astype(float)
    size = numpy_to_vtk(0.15 + 0.08 * z, deep=True)
    size.SetName("size")
    mesh.GetPointData().AddArray(size)
    return mesh


def expect_same(a, b):
    for x, y in ((a.GetPoints().GetData(), b.GetPoints().GetData()),
                 (a.GetPolys().GetConnectivityArray(), b.GetPolys().GetConnectivityArray())):
        assert np.array_equal(vtk_to_numpy(x), vtk_to_numpy(y)), "the proxy's output is not the class's, bit for bit"


def remesh_proxy_is_the_class():
    proxy = IsotropicRemesh(Input=source_of(sized_ball()), TargetEdgeLength=0.2)
    expect_same(output_of(proxy), made_by(vtkIsotropicRemeshFilter(), sized_ball(), TargetEdgeLength=0.2))
    proxy.SizingArrayName = "size"
    expect_same(output_of(proxy), made_by(vtkIsotropicRemeshFilter(), sized_ball(), TargetEdgeLength=0.2,
                                          SizingArrayName="size"))
    assert output_of(proxy).GetPointData().HasArray("size")


def repair_proxy_is_the_class():
    def broken():
        mesh = sized_ball()
        cells = vtk_to_numpy(mesh.GetPolys().GetConnectivityArray())
        cells[3:6] = cells[0:3]
        return mesh

    proxy = SurfaceRepair(Input=source_of(broken()))
    expect_same(output_of(proxy), made_by(vtkSurfaceRepairFilter(), broken()))
    report = proxy.GetClientSideObject().GetReport()
    assert "duplicate triangles removed" in report and "holes closed" in report, report
    proxy.UpdatePropertyInformation()
    assert "holes closed" in str(proxy.GetProperty("Report")), proxy.GetProperty("Report")


def atlas_proxy_is_the_class():
    proxy = TextureAtlas(Input=source_of(sized_ball()), MaximumStretch=1.5)
    made = made_by(vtkTextureAtlasFilter(), sized_ball(), MaximumStretch=1.5)
    expect_same(output_of(proxy), made)
    coordinates = [vtk_to_numpy(one.GetPointData().GetTCoords()) for one in (output_of(proxy), made)]
    assert np.array_equal(*coordinates)
    proxy.Resolution = [256, 128]
    proxy.UpdatePipeline()
    assert proxy.GetClientSideObject().GetResolution() == (256, 128)
    proxy.UpdatePropertyInformation()
    assert proxy.GetProperty("NumberOfCharts")[0] == proxy.GetClientSideObject().GetNumberOfCharts() > 1


def every_property_reaches_the_class():
    source = source_of(sized_ball())
    source.UpdatePipeline()
    check_properties(SurfaceRepair(Input=source), REPAIR)
    check_properties(TextureAtlas(Input=source), ATLAS)
    remesh = IsotropicRemesh(Input=source)
    check_properties(remesh, {name: values for name, values in REMESH.items() if name != "SizingArrayName"})
    assert remesh.SizingArrayName in ("", "None", None) or not remesh.SizingArrayName, remesh.SizingArrayName
    remesh.SizingArrayName = "size"
    remesh.UpdateVTKObjects()
    assert remesh.GetClientSideObject().GetSizingArrayName() == "size"


surfaces.run(remesh_proxy_is_the_class, repair_proxy_is_the_class, atlas_proxy_is_the_class, every_property_reaches_the_class)
