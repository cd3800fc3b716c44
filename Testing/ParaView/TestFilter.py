# SPDX-License-Identifier: BSD-3-Clause
"""The noise filter through its proxy, in pvpython: results, properties, defaults, second updates."""

import os
import sys

import numpy as np
import surfaces
from paraview.simple import *  # noqa: F403: as scripts of ParaView do
from proxies import check_properties, output_of, source_of
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet

LoadPlugin(surfaces.plugin(), remote=False, ns=globals())

ARMADILLO = surfaces.armadillo()
# property: (default, another value, what GetX() of the VTK class then returns)
PROPERTIES = {
    "NoiseModel": ("Matern", "Spectral", 4),
    "ScaleMode": ("Correlation Range", "Screening", 1),
    "CorrelationRange": (None, 0.75, 0.75),
    "StandardDeviation": (1.0, 2.5, 2.5),
    "Screening": (100.0, 12.0, 12.0),
    "NormalizedScreening": (1e-4, 1e-3, 1e-3),
    "NumberOfEigenpairs": (256, 20, 20),
    "Seed": (0, -7, -7),
    "NumberOfSamples": (1, 3, 3),
    "FirstSample": (0, 5, 5),
    "Refinement": (1, 0, False),
    "ActiveResult": (1, 0, False),
    "MemoryLimit": (0, 500, 500),
    "NumberOfComponents": (1, 3, 3),
    "OutputArrayName": ("MaternNoise", "Bumps", "Bumps"),
    "OperatorPower": (2, 2.5, 2.5),
    "VarianceCorrection": (0, 1, True),
    "BoundaryCondition": ("Neumann", "Robin", 2),
    "RobinCoefficient": (0.55, 2.0, 2.0),
    "BoundaryArrayName": ("", "Mask", "Mask"),
    "RangeFactorArrayName": ("", "Factor", "Factor"),
    "DirectionArrayName": ("", "Fibers", "Fibers"),
    "AnisotropyRatio": (4.0, 2.5, 2.5),
    "BarrierArrayName": ("", "Barrier", "Barrier"),
    "GatherPieces": (1, 0, False),
    "CoherentNoise": (0, 1, True),
    "Displacement": ("No Displacement", "Normal", 2),
    "MovedPoints": (0, 1, True),
    "ObservedTargets": (0, 1, True),
    "ObservationArray": ("", "Value", "Value"),
    "ObservationDeviationArray": ("", "Error", "Error"),
    "Tolerance": (0.0, 0.5, 0.5),
    "PosteriorMean": (0, 1, True),
    "PosteriorStandardDeviation": (0, 1, True),
}


def proxy_gives_what_the_class_gives():
    """On the armadillo, bit for bit, for two seeds and with every other array kept."""
    path = surfaces.write(ARMADILLO, "armadillo.vtp")
    reader = XMLPolyDataReader(FileName=[path])
    made = MaternNoise(Input=reader, CorrelationRange=30.0, StandardDeviation=2.0, NumberOfComponents=3)
    for seed in (1, 2):
        made.Seed = seed
        expected = surfaces.noise(
            surfaces.read(path), CorrelationRange=30.0, StandardDeviation=2.0, NumberOfComponents=3, Seed=seed)
        surfaces.assert_same(surfaces.array(output_of(made)), surfaces.array(expected), f"seed {seed}")
    assert made.GetClientSideObject().GetNumberOfFactorizations() == 1


def every_model_and_mode_gives_what_the_class_gives():
    mesh = surfaces.ball()
    made = MaternNoise(Input=source_of(mesh), CorrelationRange=1.2, NumberOfEigenpairs=20, Screening=9.0)
    found = set()
    for model in range(5):
        for mode in range(3):
            made.NoiseModel, made.ScaleMode = model, mode
            expected = surfaces.noise(
                mesh, NoiseModel=model, ScaleMode=mode, CorrelationRange=1.2, NumberOfEigenpairs=20, Screening=9.0)
            values = surfaces.array(output_of(made))
            surfaces.assert_same(values, surfaces.array(expected), f"model {model}, mode {mode}")
            found.add(values.tobytes())
    assert len(found) == 9, "three modes of two models, and one of the three others"


def properties_have_the_defaults_of_the_class_and_reach_it():
    check_properties(MaternNoise(Input=source_of(surfaces.ball())), PROPERTIES)


def range_comes_from_the_bounds():
    """A fifth of the longest side, as CorrelationRange = 0 in the class."""
    source = source_of(ARMADILLO)
    source.UpdatePipeline()
    made = MaternNoise(Input=source)
    bounds = np.array(ARMADILLO.GetBounds())
    expected = 0.2 * max(bounds[1::2] - bounds[::2])
    assert abs(made.CorrelationRange - expected) <= 1e-12 * expected, (made.CorrelationRange, expected)
    made.UpdatePipeline()
    found = made.GetClientSideObject().GetEffectiveCorrelationRange()
    assert abs(found - expected) <= 1e-12 * expected, (found, expected)


def range_without_bounds_is_taken_from_the_input_later():
    """A filter made before its input has data: the same range, found by the class."""
    source = source_of(ARMADILLO)
    made = MaternNoise(Input=source)
    values = surfaces.array(output_of(made))
    surfaces.assert_same(values, surfaces.array(surfaces.noise(ARMADILLO)), "range found by the class")


def information_is_shown():
    made = MaternNoise(Input=source_of(surfaces.ball()), CorrelationRange=1.0)
    made.UpdatePipeline()
    made.UpdatePropertyInformation()
    value = {name: made.GetProperty(name).GetData() for name in
             ("EffectiveScreening", "EffectiveCorrelationRange", "Gamma", "RelativeResidual", "NumberOfFactorizations")}
    assert abs(value["EffectiveScreening"] - 8.0) < 1e-12, value
    assert abs(value["EffectiveCorrelationRange"] - 1.0) < 1e-12, value
    assert value["Gamma"] > 0.0 and 0.0 < value["RelativeResidual"] < 1e-10, value
    assert value["NumberOfFactorizations"] == 1, value
    assert str(made.GetProperty("SolverName")[0]) == "Cholesky" and made.GetProperty("NumberOfIterations").GetData() == 0


def execute_runs_again():
    made = MaternNoise(Input=source_of(surfaces.ball()))
    made.UpdatePipeline()
    count = []
    made.GetClientSideObject().AddObserver("StartEvent", lambda *_: count.append(1))
    made.UpdatePipeline()
    assert count == [], "an update without a change ran the filter"
    made.SMProxy.InvokeCommand("Execute")
    made.UpdatePipeline()
    assert count == [1], count


def blocks_get_noise_of_their_own():
    blocks = vtkMultiBlockDataSet()
    blocks.SetBlock(0, surfaces.ball())
    blocks.SetBlock(2, surfaces.ball())
    found = output_of(MaternNoise(Input=source_of(blocks), CorrelationRange=1.0, Seed=4))
    expected = surfaces.noise(blocks, CorrelationRange=1.0, Seed=4)
    for block in (0, 2):
        surfaces.assert_same(
            surfaces.array(found.GetBlock(block)), surfaces.array(expected.GetBlock(block)), f"block {block}")
    assert (surfaces.array(found.GetBlock(0)) != surfaces.array(found.GetBlock(2))).all()


def samples_are_arrays():
    mesh = surfaces.ball()
    found = output_of(MaternNoise(Input=source_of(mesh), NumberOfSamples=3, FirstSample=2, OutputArrayName="f"))
    assert surfaces.names(found) == ["f_2", "f_3", "f_4"], surfaces.names(found)
    for sample in (2, 3, 4):
        expected = surfaces.noise(mesh, FirstSample=sample)
        surfaces.assert_same(surfaces.array(found, f"f_{sample}"), surfaces.array(expected), f"sample {sample}")


def progress_is_reported_and_abort_stops():
    """As the progress bar and a stop button do it: through events and the flag of the object. The next update is whole."""
    made = MaternNoise(Input=source_of(ARMADILLO), CorrelationRange=30.0, NumberOfSamples=20)
    made.UpdateVTKObjects()
    held = made.GetClientSideObject()
    seen, stop_at = [], [0.3]

    def note(caller, _):
        seen.append(caller.GetProgress())
        if seen[-1] >= stop_at[0]:
            caller.SetAbortExecute(1)

    held.AddObserver("ProgressEvent", note)
    made.UpdatePipeline()
    past = [progress for progress in seen if progress >= 0.3]
    assert past[0] < 1.0 and past[1:] in ([], [1.0]), f"went on after the stop: {seen}"  # VTK itself ends with 1
    assert held.GetOutputDataObject(0).GetNumberOfPoints() == 0
    seen.clear()
    stop_at[0] = 2.0
    held.SetAbortExecute(0)
    made.Seed = 1
    made.UpdatePipeline()
    found = held.GetOutputDataObject(0)
    assert seen == sorted(seen) and len(seen) >= 5 and seen[-1] == 1.0, seen
    expected = surfaces.noise(ARMADILLO, CorrelationRange=30.0, NumberOfSamples=20, Seed=1)
    surfaces.assert_same(surfaces.array(found, "MaternNoise_19"), surfaces.array(expected, "MaternNoise_19"), "after")


def numbers_are_those_of_the_baseline():
    """The same numbers as in the build against VTK, whose tests keep the file."""
    with open(os.environ["SURFACE_SYNTHESIS_BASELINE"], encoding="ascii") as file:
        baseline = {name: float(value) for name, value in (line.split() for line in file)}
    steps = np.arange(17) / 16.0
    y, x = (axis.ravel() for axis in np.meshgrid(steps, steps, indexing="ij"))
    i, j = (axis.ravel() for axis in np.meshgrid(np.arange(16), np.arange(16)))
    corner = 17 * j + i
    lower = np.stack([corner, corner + 1, corner + 18], axis=-1)
    upper = np.stack([corner, corner + 18, corner + 17], axis=-1)
    mesh = surfaces.mesh_of(
        np.stack([x, y, 0.5 * x * x - 0.25 * y], axis=-1), np.stack([lower, upper], axis=1).reshape(-1, 3))
    made = MaternNoise(Input=source_of(mesh), Seed=42, CorrelationRange=0.4, NumberOfEigenpairs=20)
    compared = 0
    for name, (model, mode) in {
            "range": (0, 0), "screening": (0, 1), "normalized": (0, 2), "pervertex": (1, 2), "white": (2, 2),
            "unscreened": (3, 2), "spectral": (4, 0)}.items():
        made.NoiseModel, made.ScaleMode = model, mode
        values = surfaces.array(output_of(made))
        numbers = {"mean": values.mean(), "rms": np.sqrt(np.mean(values**2)), "minimum": values.min(),
                   "maximum": values.max(), **{f"point{p}": values[p] for p in (0, 100, 200, 288)}}
        for number, value in numbers.items():
            expected = baseline[f"{name}.{number}"]
            assert abs(value - expected) <= 1e-9 * max(1.0, abs(expected)), (name, number, value, expected)
            compared += 1
    assert compared == len(baseline) == 56


surfaces.run(
    proxy_gives_what_the_class_gives,
    every_model_and_mode_gives_what_the_class_gives,
    properties_have_the_defaults_of_the_class_and_reach_it,
    range_comes_from_the_bounds,
    range_without_bounds_is_taken_from_the_input_later,
    information_is_shown,
    execute_runs_again,
    blocks_get_noise_of_their_own,
    samples_are_arrays,
    progress_is_reported_and_abort_stops,
    numbers_are_those_of_the_baseline,
)
