# SPDX-License-Identifier: BSD-3-Clause
"""ensemble_statistics(), shape_model() and the commands ``statistics`` and ``shape-model``."""

import json

import numpy as np
import pytest
from conftest import add_array, icosphere, polydata_of, run_command
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet

from surfacesynthesis import Cancelled, SurfaceSynthesisError, ensemble_statistics, read_mesh, shape_model, write_mesh

POINTS, TRIANGLES = icosphere(2)


def shapes(count=12):
    """Points [count, V, 3] of spheres with random stretches and bumps."""
    numbers = np.random.default_rng(1).normal(size=(count, 4))
    bumps = np.sin(3 * POINTS[:, :1])
    return np.array([POINTS * (1 + 0.1 * row[:3]) + 0.05 * row[3] * bumps * POINTS for row in numbers])


def ensemble(points):
    return [(sample, TRIANGLES) for sample in points]


def points_of(surface):
    return vtk_to_numpy(surface.GetPoints().GetData())


def test_moments_and_quantiles_are_those_of_numpy():
    points = shapes()
    found = ensemble_statistics(ensemble(points), quantiles=(0.0, 0.1, 1 / 3, 0.5, 1.0))
    assert np.abs(found.mean - points.mean(0)).max() < 1e-12
    assert np.abs(found.standard_deviation - points.std(0, ddof=1)).max() < 1e-12
    assert list(found.quantiles) == [0.0, 0.1, 1 / 3, 0.5, 1.0]
    for probability, values in found.quantiles.items():
        assert np.abs(values - np.quantile(points, probability, axis=0)).max() < 1e-12
    assert found.surface.GetNumberOfPoints() == len(POINTS) and len(found.modes) == 0
    distance = vtk_to_numpy(found.surface.GetPointData().GetArray("StandardDistance"))
    assert np.abs(distance - np.linalg.norm(points.std(0, ddof=1), axis=1)).max() < 1e-12


def test_modes_are_those_of_numpys_singular_values():
    points = shapes()
    found = ensemble_statistics(ensemble(points), modes=-1)
    deviations = (points - points.mean(0)).reshape(len(points), -1)
    _, sigma, vectors = np.linalg.svd(deviations, full_matrices=False)
    variances = sigma**2 / (len(points) - 1)
    assert len(found.variances) == 4  # three stretches and the bumps
    assert np.abs(found.variances - variances[:4]).max() < 1e-10 * variances[0]
    assert abs(found.fractions.sum() - 1) < 1e-10
    for mode, vector, variance in zip(found.modes, vectors, variances):
        cosine = mode.ravel() @ vector / np.linalg.norm(mode)
        assert abs(abs(cosine) - 1) < 1e-10 and abs(np.linalg.norm(mode) ** 2 / variance - 1) < 1e-9
    rebuilt = found.mean + np.tensordot(found.coefficients, found.modes, 1)
    assert np.abs(rebuilt - points).max() < 1e-10


def test_arrays_are_signals():
    mesh = polydata_of(POINTS, TRIANGLES)
    signals = np.random.default_rng(2).normal(size=(7, len(POINTS)))
    for number, signal in enumerate(signals):
        add_array(mesh.GetPointData(), f"heat_{number}", signal)
    found = ensemble_statistics(mesh, "heat", modes=3)
    assert np.abs(found.mean[:, 0] - signals.mean(0)).max() < 1e-12
    assert found.names[2] == "heat_2" and found.modes.shape == (3, len(POINTS), 1)
    made = shape_model(found, samples=2)
    assert vtk_to_numpy(made.GetBlock(1).GetPointData().GetArray("heat")).shape == (len(POINTS),)


def test_shapes_of_the_model():
    points = shapes()
    found = ensemble_statistics(ensemble(points), modes=-1)
    given = points_of(shape_model(found, coefficients=[2.0, -1.0]).GetBlock(0))
    assert np.abs(given - (found.mean + 2 * found.modes[0] - found.modes[1])).max() < 1e-12
    nearest = shape_model(found.surface, shapes=ensemble(points))
    for number in range(len(points)):
        block = nearest.GetBlock(number)
        assert np.abs(points_of(block) - points[number]).max() < 1e-10
        coefficients = vtk_to_numpy(block.GetFieldData().GetArray("Coefficients"))
        assert np.abs(coefficients - found.coefficients[number]).max() < 1e-9
    first, again = (points_of(shape_model(found, samples=3, seed=4).GetBlock(2)) for _ in range(2))
    alone = points_of(shape_model(found, seed=4, first_sample=2).GetBlock(0))
    assert (first == again).all() and (first == alone).all()
    assert not (first == points_of(shape_model(found, samples=3, seed=5).GetBlock(2))).all()


def test_results_show_themselves():
    found = ensemble_statistics(ensemble(shapes()), modes=2)
    assert "mode 1" in str(found) and repr(found) == "<EnsembleStatistics: 12 samples of 162 points, 2 modes>"
    assert found._repr_html_().count("<tr>") == 5 + 3
    assert json.loads(found.to_json())["modes"][1]["mode"] == 1
    assert found.modes_to_csv().splitlines()[0].startswith("mode,variance")
    empty = ensemble_statistics(vtkMultiBlockDataSet())
    assert len(empty.names) == 0 and str(empty)


def test_wrong_arguments_have_words():
    points = shapes(3)
    with pytest.raises(SurfaceSynthesisError, match="1 sample; expected at least 2"):
        ensemble_statistics(ensemble(points[:1]))
    with pytest.raises(SurfaceSynthesisError, match="all samples must lie on one triangulation"):
        ensemble_statistics([*ensemble(points), icosphere(1)])
    points[1, 7, 0] = np.nan
    with pytest.raises(SurfaceSynthesisError, match="sample 1 has a value that is not finite at point 7"):
        ensemble_statistics(ensemble(points))
    with pytest.raises(ValueError, match="quantiles must be from 0 to 1"):
        ensemble_statistics(ensemble(shapes(3)), quantiles=[2])
    with pytest.raises(ValueError, match="exclude each other"):
        shape_model(polydata_of(POINTS, TRIANGLES), coefficients=[1], shapes=ensemble(points))
    with pytest.raises(SurfaceSynthesisError, match="Mode_0"):
        shape_model(polydata_of(POINTS, TRIANGLES))
    with pytest.raises(Cancelled):
        ensemble_statistics(ensemble(shapes(3)), progress=lambda fraction: False)


def test_commands(tmp_path):
    points = shapes(5)
    for number, sample in enumerate(points):
        write_mesh(polydata_of(sample, TRIANGLES), str(tmp_path / f"shape_{number}.vtp"))
    files = [str(tmp_path / f"shape_{number}.vtp") for number in range(5)]
    model = str(tmp_path / "model.vtp")
    done = run_command("statistics", *files, model, "--modes", "3", "--quantiles", "0.5", "--json")
    assert done.returncode == 0, done.stderr
    summary = json.loads(done.stdout)
    assert summary["samples"] == 5 and len(summary["modes"]) == 3
    expected = ensemble_statistics(ensemble(points), modes=3)
    assert abs(summary["modes"][0]["variance"] - expected.variances[0]) < 1e-6 * expected.variances[0]
    stored = read_mesh(model)
    assert stored.GetPointData().HasArray("Mode_2") and stored.GetPointData().HasArray("Quantile_0.5")
    made = str(tmp_path / "made.vtm")
    done = run_command("shape-model", model, made, "--samples", "4", "--seed", "3")
    assert done.returncode == 0 and done.stdout.startswith("4 shapes"), done.stderr
    wanted = shape_model(stored, samples=4, seed=3).GetBlock(3)
    assert np.abs(points_of(read_mesh(made).GetBlock(3)) - points_of(wanted)).max() < 1e-12
    wide = str(tmp_path / "wide.ply")
    assert run_command("shape-model", model, wide, "--coefficients", "-2", "1").returncode == 0
    assert read_mesh(wide).GetNumberOfPoints() == len(POINTS)
    done = run_command("shape-model", files[0], made)
    assert done.returncode == 1 and "the command statistics with --modes" in done.stderr
