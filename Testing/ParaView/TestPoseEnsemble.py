# SPDX-License-Identifier: BSD-3-Clause
"""Random poses through their proxy, in pvpython."""

import surfaces
from paraview.simple import *  # noqa: F403: as scripts of ParaView do
from proxies import check_properties, made_by, output_of, source_of
from surfacesynthesis import vtkPoseEnsembleFilter

LoadPlugin(surfaces.plugin(), remote=False, ns=globals())

# property: (default, another value, what GetX() of the VTK class then returns)
PROPERTIES = {
    "Seed": (0, 7, 7),
    "NumberOfSamples": (12, 3, 3),
    "FirstSample": (0, 2, 2),
    "Spread": (1.25, 0.5, 0.5),
    "MemoryLimit": (0, 500, 500),
    "NumberOfHandles": (6, 4, 4),
    "MaximumAngle": (60.0, 30.0, 30.0),
    "MaximumTwist": (20.0, 5.0, 5.0),
    "HandleRadius": (0.08, 0.1, 0.1),
    "AnchorRadius": (0.12, 0.2, 0.2),
    "PivotPosition": (0.8, 0.5, 0.5),
    "NumberOfIterations": (40, 10, 10),
    "Stiffness": (2e-4, 1e-3, 1e-3),
    "DisplacementArrayName": ("Displacement", "Way", "Way"),
    "RegionArrayName": ("PoseRegion", "Limb", "Limb"),
}
QUICK = {"NumberOfSamples": 2, "NumberOfHandles": 2, "NumberOfIterations": 5, "MaximumAngle": 30.0}


def poses_of_the_class(mesh, template=None):
    algorithm = vtkPoseEnsembleFilter()
    algorithm.SetTemplateData(template)
    return made_by(algorithm, mesh, **QUICK)


def assert_same_poses(found, expected):
    assert found.GetNumberOfBlocks() == expected.GetNumberOfBlocks() == 2
    for k in range(2):
        points = [surfaces.vtk_to_numpy(blocks.GetBlock(k).GetPoints().GetData()) for blocks in (found, expected)]
        surfaces.assert_same(*points, f"points of sample {k}")
        for name in ("Displacement", "PoseRegion"):
            arrays = [surfaces.array(blocks.GetBlock(k), name) for blocks in (found, expected)]
            surfaces.assert_same(*arrays, f"{name} of sample {k}")


def properties_have_the_defaults_of_the_class_and_reach_it():
    check_properties(PoseEnsemble(Input=source_of(surfaces.long_ball())), PROPERTIES)


def poses_are_those_of_the_class():
    proxy = PoseEnsemble(Input=source_of(surfaces.long_ball()), Spread=0.0, **QUICK)
    found = output_of(proxy)
    assert_same_poses(found, poses_of_the_class(surfaces.long_ball()))
    moved = surfaces.array(found.GetBlock(0), "Displacement")
    assert abs(moved).max() > 0.1, "an extremity swings"
    proxy.UpdatePropertyInformation()
    assert proxy.GetProperty("NumberOfFactorizations").GetData() == 1


def a_template_can_be_given_and_taken_away():
    proxy = PoseEnsemble(Input=source_of(surfaces.long_ball()), Template=source_of(surfaces.long_ball(14)), Spread=0.0,
                         **QUICK)  # fmt: skip
    assert_same_poses(output_of(proxy), poses_of_the_class(surfaces.long_ball(), surfaces.long_ball(14)))
    proxy.Template = None
    assert_same_poses(output_of(proxy), poses_of_the_class(surfaces.long_ball()))


surfaces.run(
    properties_have_the_defaults_of_the_class_and_reach_it,
    poses_are_those_of_the_class,
    a_template_can_be_given_and_taken_away,
)
