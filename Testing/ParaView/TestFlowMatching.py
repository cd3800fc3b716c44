# SPDX-License-Identifier: BSD-3-Clause
"""Flow matching through its proxies, in pvpython: what the classes give, bit for bit, and flow time as ParaView's time."""

import numpy as np
import surfaces
from flow_models import model
from paraview.simple import *  # noqa: F403: as scripts of ParaView do
from proxies import check_properties, made_by, output_of, source_of
from surfacesynthesis import vtkFlowMatchingDeformer, vtkFlowMatchingSampler
from vtkmodules.util.numpy_support import vtk_to_numpy

LoadPlugin(surfaces.plugin(), remote=False, ns=globals())

# property: (default, another value, what GetX() of the VTK class then returns)
SAMPLER = {
    "ModelFileName": ("armadillo_poses", "net.safetensors", "net.safetensors"),
    "Seed": (0, 7, 7),
    "FirstSample": (0, 2, 2),
    "MemoryLimit": (0, 500, 500),
    "NumberOfSamples": (1, 3, 3),
    "NumberOfSteps": (20, 5, 5),
    "Integrator": ("Midpoint", "Runge-Kutta 4", vtkFlowMatchingSampler.RUNGE_KUTTA_4),
    "NumberOfCorrections": (-1, 3, 3),
    "Temperature": (1, 1.5, 1.5),
    "NormalizationArea": (0, 2.5, 2.5),
    "NormalizationCenter": ([0.0, 0.0, 0.0], [1.0, 2.0, 3.0], (1.0, 2.0, 3.0)),
    "OutputTrajectory": (0, 1, True),
    "InitialNoiseArrayName": ("InitialNoise", "Start", "Start"),
}
DEFORMER = {
    "MovePoints": (1, 0, False),
    "DisplacementArrayName": ("Displacement", "Way", "Way"),
    "AreaRatioArrayName": ("AreaRatio", "Stretch", "Stretch"),
}


def points_of(mesh):
    return vtk_to_numpy(mesh.GetPoints().GetData()).copy()


def properties_have_the_defaults_of_the_classes_and_reach_them():
    ball = source_of(surfaces.ball())
    for made, properties in (
        (FlowMatchingSampler(Input=ball),
         {**SAMPLER, "SignalArrayName": ("", "Heat", "Heat"), "ActiveResult": (1, 0, False)}),
        (FlowMatchingDeformer(Input=ball), {**SAMPLER, **DEFORMER, "ActiveResult": (0, 1, True)}),
    ):
        check_properties(made, properties)
        Delete(made)  # or its flow times would be among those of the scene


def shapes_are_those_of_the_class():
    path = model("deformer.safetensors")
    found = output_of(FlowMatchingDeformer(Input=source_of(surfaces.ball()), ModelFileName=path, Seed=3,
                                           NumberOfSteps=2))  # fmt: skip
    expected = made_by(vtkFlowMatchingDeformer(), surfaces.ball(), ModelFileName=path, Seed=3, NumberOfSteps=2)
    assert np.array_equal(points_of(found), points_of(expected))
    assert not np.allclose(points_of(found), points_of(surfaces.ball()), atol=1e-2)
    assert found.GetCellData().HasArray("AreaRatio")


def signals_and_samples_are_those_of_the_class():
    path = model("mixture.safetensors", components=2)
    found = output_of(FlowMatchingSampler(Input=source_of(surfaces.ball()), ModelFileName=path, NumberOfSamples=2,
                                          NumberOfSteps=2))  # fmt: skip
    assert found.GetNumberOfBlocks() == 2
    for k in range(2):
        expected = made_by(vtkFlowMatchingSampler(), surfaces.ball(), ModelFileName=path, FirstSample=k,
                           NumberOfSteps=2)  # fmt: skip
        for name in ("Mixture", "InitialNoise"):
            values = [vtk_to_numpy(mesh.GetPointData().GetArray(name)) for mesh in (found.GetBlock(k), expected)]
            assert np.array_equal(*values), name


def the_animation_goes_through_flow_time_without_evaluations():
    made = FlowMatchingDeformer(Input=source_of(surfaces.ball()), ModelFileName=model("animated.safetensors"),
                                NumberOfSteps=4, OutputTrajectory=1)  # fmt: skip
    made.UpdatePipeline()
    assert list(made.TimestepValues) == [0.0, 0.25, 0.5, 0.75, 1.0]
    scene = GetAnimationScene()
    scene.UpdateAnimationUsingDataTimeSteps()
    assert list(GetTimeKeeper().TimestepValues) == [0.0, 0.25, 0.5, 0.75, 1.0], "the play button knows them"
    seen = []
    for time in made.TimestepValues:
        made.UpdatePipeline(time)
        seen.append(points_of(servermanager.Fetch(made)))
    assert all(np.abs(a - b).max() > 1e-4 for a, b in zip(seen, seen[1:])), "the shape moves"
    made.UpdatePropertyInformation()
    assert made.GetProperty("NumberOfEvaluations").GetData() == 8
    assert made.GetProperty("NumberOfFactorizations").GetData() == 1


surfaces.run(
    properties_have_the_defaults_of_the_classes_and_reach_them,
    shapes_are_those_of_the_class,
    signals_and_samples_are_those_of_the_class,
    the_animation_goes_through_flow_time_without_evaluations,
)
