# SPDX-License-Identifier: BSD-3-Clause
"""Observations of fields: coherent noise, posterior samples and estimated parameters, in Python and on the command line."""

import numpy as np
import pytest
from conftest import add_array, icosphere, point_array, points_of, polydata_of
from surfacesynthesis import SurfaceSynthesisError, SurfaceSynthesisWarning, estimate_matern, matern_noise, read_mesh, write_mesh
from surfacesynthesis.command_line import main
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet, vtkPolyData

PLACES = np.array([[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0], [-0.6, 0.8, 0]])
VALUES = np.array([-1.5, 0.0, 1.0, 2.0])


def nearest(pair, places):
    """Ids of the points nearest to the places."""
    return np.argmax(places @ pair[0].T, axis=1)


def points_only(places, **arrays):
    """A vtkPolyData without cells."""
    mesh = polydata_of(places, np.zeros((0, 3), dtype=np.int64))
    for name, values in arrays.items():
        add_array(mesh.GetPointData(), name, values)
    return mesh


def test_samples_take_exact_observations_of_arrays_and_datasets(pair):
    ids = nearest(pair, PLACES)
    places = pair[0][ids]
    samples = matern_noise(pair, range=0.8, samples=5, observations=places, observation_array=VALUES)
    assert np.allclose(samples[:, ids], VALUES, atol=1e-7)
    assert np.abs(samples[0] - samples[1]).max() > 0.1
    dataset = points_only(places, Value=VALUES)
    same = matern_noise(pair, range=0.8, samples=5, observations=dataset, observation_array="Value")
    assert np.array_equal(samples, same)
    displacement = np.stack([VALUES, -VALUES, 0 * VALUES], axis=1)
    vectors = matern_noise(pair, range=0.8, components=3, observations=places, observation_array=displacement)
    assert np.allclose(vectors[ids], displacement, atol=1e-7)


def test_posterior_arrays_go_with_datasets(pair):
    mesh = polydata_of(*pair)
    ids = nearest(pair, PLACES)
    result = matern_noise(mesh, range=0.8, observations=pair[0][ids], observation_array=VALUES,
                          observation_deviation_array=np.array([0.0, 0.0, 0.5, 0.5]),
                          posterior_mean=True, posterior_standard_deviation=True)
    mean, deviation = (point_array(result, f"MaternNoise_{name}") for name in ("Mean", "StandardDeviation"))
    assert np.allclose(mean[ids[:2]], VALUES[:2], atol=1e-7)
    assert np.abs(mean[ids[2:]] - VALUES[2:]).min() > 1e-3
    assert np.all(deviation[ids[:2]] < 1e-5) and np.all(deviation[ids[2:]] > 0.1) and deviation.max() < 1.2
    with pytest.raises(ValueError, match="posterior arrays are added to a dataset"):
        matern_noise(pair, observations=PLACES, observation_array=VALUES, posterior_mean=True)


def test_faults_are_named(pair):
    with pytest.raises(SurfaceSynthesisError, match="farther from the surface than the Tolerance"):
        matern_noise(pair, range=0.8, observations=1.5 * PLACES, observation_array=VALUES)
    with pytest.raises(ValueError, match="4 observations"):
        matern_noise(pair, observations=PLACES, observation_array=VALUES[:3])
    with pytest.raises(TypeError, match="observations must be a vtkPointSet"):
        matern_noise(pair, observations=PLACES[:, :2], observation_array=VALUES)
    with pytest.raises(ValueError, match="go with observations"):
        matern_noise(pair, observation_array=VALUES)
    for without in ({"posterior_mean": True}, {"posterior_standard_deviation": True}, {"tolerance": 0.1},
                    {"observation_array": "Value"}, {"observed_targets": True, "displacement": "free"}):
        with pytest.raises(ValueError, match=f"{next(iter(without))} goes with observations"):
            matern_noise(polydata_of(*pair), **without)
    with pytest.raises(ValueError, match="has no meaning for the model 'white'"):
        matern_noise(pair, noise_model="white", observations=PLACES, observation_array=VALUES)
    with pytest.raises(ValueError, match="tolerance must be at least 0"):
        matern_noise(pair, observations=PLACES, observation_array=VALUES, tolerance=-1)


def test_shapes_pass_through_landmarks(pair):
    ids = nearest(pair, PLACES[:3])
    places = pair[0][ids]
    targets = places + [[0.02, -0.03, 0.01], [0.0, 0.04, 0.01], [0.01, 0.0, -0.02]]
    known = {"range": 1.0, "standard_deviation": 0.05, "operator_power": 3, "observations": places}
    free = matern_noise(pair, samples=4, displacement="free", observation_array=targets, observed_targets=True, **known)
    assert free.shape == (4, len(pair[0]), 3)
    assert np.allclose(places + free[:, ids], targets, atol=1e-8)
    assert np.abs(free[0] - free[1]).max() > 0.02
    same = matern_noise(pair, displacement="free", observation_array=targets - places, **known)
    assert np.allclose(same, free[0], atol=1e-10)
    along = 0.04 * places * [[1], [-1], [0.5]]  # the normals of an icosphere at these points are the points
    for displacement, moves in (("normal", along), ("tangential", np.cross(along, [1, 1, 1]))):
        found = matern_noise(pair, displacement=displacement, observation_array=moves, **known)
        assert np.allclose(found[ids], moves, atol=1e-8)
    with pytest.warns(SurfaceSynthesisWarning, match="exclude parts of 3 observed displacements: 0, 1, 2"):
        matern_noise(pair, displacement="tangential", observation_array=along, **known)


def test_displacements_move_the_points_of_datasets(pair):
    mesh = polydata_of(*pair)
    moved = matern_noise(mesh, range=1.0, standard_deviation=0.02, displacement="normal", moved_points=True)
    moves = point_array(moved, "MaternNoise")
    assert np.allclose(points_of(moved), points_of(mesh) + moves, atol=1e-6)
    assert np.array_equal(moves, matern_noise(pair, range=1.0, standard_deviation=0.02, displacement="normal"))
    with pytest.warns(SurfaceSynthesisWarning, match="inverts triangles in 1 of 1 sample"):
        matern_noise(mesh, range=0.8, standard_deviation=3.0, displacement="free")
    for wrong, text in (
        ({"moved_points": True}, "moved_points goes with displacement"),
        ({"displacement": "normal", "moved_points": True, "samples": 2}, "moved_points goes with one sample, not 2"),
        ({"displacement": "normal", "components": 2}, "a displacement has 3 components, not 2"),
        ({"displacement": "sideways"}, "displacement"),
    ):
        with pytest.raises(ValueError, match=text):
            matern_noise(mesh, **wrong)
    with pytest.raises(ValueError, match="give mesh as a vtkPolyData"):
        matern_noise(pair, displacement="normal", moved_points=True)


def test_coherent_noise_is_the_same_on_another_triangulation():
    coarse, fine = icosphere(3), icosphere(4)
    ids = np.argmax(coarse[0] @ fine[0].T, axis=1)  # the points of the coarse one are among those of the fine one
    for coherent in (False, True):
        on_coarse, on_fine = (
            matern_noise(mesh, range=1.5, samples=20, seed=3, coherent_noise=coherent) for mesh in (coarse, fine)
        )
        correlation = np.corrcoef(on_coarse.ravel(), on_fine[:, ids].ravel())[0, 1]
        assert (correlation > 0.95) == coherent, correlation
    with pytest.raises(ValueError, match="has no meaning for the model 'white'"):
        matern_noise(coarse, noise_model="white", coherent_noise=True)


def test_estimates_hold_the_parameters_of_the_noise(pair):
    fields = matern_noise(pair, range=0.7, standard_deviation=2.0, samples=4, seed=5)
    found = estimate_matern(pair, fields.T, noise_estimation=False, mean_estimation=False)
    assert list(found) == ["correlation_range", "standard_deviation", "noise_deviation"]
    assert found["correlation_range"].lower < 0.7 < found["correlation_range"].upper
    assert found["standard_deviation"].lower < 2.0 < found["standard_deviation"].upper
    assert found["noise_deviation"] == (0, 0, 0, 0)
    assert (found.number_of_observations, found.number_of_fields) == (642, 4)
    assert "correlation range" in str(found) and found.to_csv().count("\n") == 4
    smooth = matern_noise(pair, range=0.7, standard_deviation=2.0, samples=4, seed=5, operator_power=3)
    found = estimate_matern(pair, smooth.T, noise_estimation=False, mean_estimation=False, operator_power=3)
    assert found["correlation_range"].lower < 0.7 < found["correlation_range"].upper
    for wrong in (1, 5):
        with pytest.raises(ValueError, match="operator_power"):
            estimate_matern(pair, smooth.T, operator_power=wrong)
    places = pair[0][::2]
    some = estimate_matern(polydata_of(*pair), 5.0 + fields[0, ::2], observations=places)
    assert some["correlation_range"].lower < 0.7 < some["correlation_range"].upper
    assert len(estimate_matern(vtkPolyData(), "Any")) == 0
    with pytest.raises(SurfaceSynthesisError, match='no point array "Height"'):
        estimate_matern(polydata_of(*pair), "Height")


def test_commands(pair, tmp_path, capsys):
    surface, known, output = (tmp_path / name for name in ("in.vtp", "known.vtp", "out.vtp"))
    write_mesh(polydata_of(*pair), surface)
    ids = nearest(pair, PLACES)
    write_mesh(points_only(pair[0][ids], Value=VALUES, Error=0 * VALUES), known)
    options = ["--observations", str(known), "--observation-array", "Value", "--observation-deviation-array", "Error",
               "--tolerance", "0.1", "--posterior-mean", "--posterior-standard-deviation", "--quiet"]
    assert main(["noise", str(surface), str(output), "--range", "0.7", "--samples", "2", *options]) == 0
    result = read_mesh(output)
    for name in ("MaternNoise_0", "MaternNoise_1", "MaternNoise_Mean"):
        assert np.allclose(point_array(result, name)[ids], VALUES, atol=1e-7)
    assert main(["noise", str(surface), str(output), "--range", "0.7", "--samples", "3", "--coherent-noise", "--quiet"]) == 0
    expected = matern_noise(pair, range=0.7, samples=3, coherent_noise=True)
    assert np.array_equal(point_array(read_mesh(output), "MaternNoise_2"), expected[2])
    write_mesh(points_only(pair[0][ids[:3]], Target=1.03 * pair[0][ids[:3]]), known)
    shape = ["--range", "1", "--standard-deviation", "0.03", "--displacement", "free", "--observations", str(known),
             "--observation-array", "Target", "--observed-targets", "--quiet"]
    assert main(["noise", str(surface), str(tmp_path / "shape.vtp"), *shape, "--moved-points"]) == 0
    assert np.allclose(points_of(read_mesh(tmp_path / "shape.vtp"))[ids[:3]], 1.03 * pair[0][ids[:3]], atol=1e-6)
    assert main(["noise", str(surface), str(tmp_path / "shape.stl"), *shape, "--samples", "2", "--warp", "1"]) == 0
    assert (tmp_path / "shape_1.stl").exists()
    assert main(["noise", str(surface), str(output), *shape, "--moved-points", "--warp", "1"]) == 2
    assert main(["noise", str(surface), str(output), "--posterior-mean", "--quiet"]) == 2
    assert main(["noise", str(surface), str(output), "--range", "0.7", "--samples", "3", "--coherent-noise", "--quiet"]) == 0
    capsys.readouterr()
    assert main(["estimate", str(output), "--observation-array", "MaternNoise", "--no-noise-estimation", "--csv", "--no-progress"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "parameter,estimate,standard_error,lower,upper"
    assert lines[1].startswith("correlation_range,0.") and len(lines) == 4


@pytest.mark.parametrize("options", [["in.vtm"], ["in.vtp", "--observations", "in.vtm"]])
def test_the_estimate_of_several_blocks_is_refused_once(pair, tmp_path, capsys, monkeypatch, options):
    monkeypatch.chdir(tmp_path)
    surface, blocks = matern_noise(polydata_of(*pair), range=0.7), vtkMultiBlockDataSet()
    for k in range(3):
        blocks.SetBlock(k, surface)
    write_mesh(surface, "in.vtp")
    write_mesh(blocks, "in.vtm")
    assert main(["estimate", *options, "--observation-array", "MaternNoise"]) == 1
    wanted = "surface" if len(options) == 1 else "set of points"
    assert capsys.readouterr().err == f"surfacesynthesis: in.vtm: one {wanted} is needed, not a vtkMultiBlockDataSet\n"
