# SPDX-License-Identifier: BSD-3-Clause
"""Training of geometric textures: fit_levels(), train_geometric_texture() and their commands."""

import numpy as np
import pytest
from conftest import icosphere, points_of, polydata_of
from surfacesynthesis import (
    SurfaceSynthesisError,
    fit_levels,
    geometric_texture,
    train_geometric_texture,
    write_mesh,
)
from surfacesynthesis.command_line import main
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet

FIT = {"levels": 2, "icosphere_level": 1, "iterations": 8, "surface_samples": 200, "learning_rate": 0.02}
SMALL = {
    "objective": "adversarial",
    "iterations": 2,
    "layers": 3,
    "start_channels": 4,
    "minimum_channels": 4,
    "maximum_channels": 4,
    "device": "cpu",
}


@pytest.fixture
def ball():
    return icosphere(2)


def test_levels_are_fitted_and_a_texture_is_learned_from_them(ball, tmp_path):
    egg = polydata_of(ball[0] * [1, 1, 2], ball[1])
    fit = fit_levels(egg, **FIT, dataset=tmp_path / "egg.safetensors")
    assert [level.GetNumberOfPolys() for level in fit.levels] == [80, 320]
    assert fit.template.GetNumberOfPolys() == 80 and len(fit.mean_distances) == len(fit.largest_distances) == 2
    start = fit_levels(egg, **{**FIT, "iterations": 0})
    for mean, largest, before in zip(fit.mean_distances, fit.largest_distances, start.mean_distances):
        assert 0 < mean <= largest and mean < before
    losses = train_geometric_texture(fit.levels, fit.template, model=tmp_path / "egg.model", texture_name="egg", **SMALL)
    assert list(losses["iteration"]) == [1, 2, 3, 4] and list(losses["level"]) == [0, 0, 1, 1]
    assert all(np.all(np.isfinite(column)) for column in losses.values())
    files = {"model": tmp_path / "same.model", "dataset": tmp_path / "egg.safetensors"}
    train_geometric_texture(**files, texture_name="egg", **SMALL)
    assert (tmp_path / "same.model").read_bytes() == (tmp_path / "egg.model").read_bytes()
    assert geometric_texture(None, tmp_path / "egg.model").GetNumberOfPolys() == 320


def test_a_template_may_be_given_to_the_fit(ball):
    fit = fit_levels(ball, template=icosphere(0), levels=1, iterations=1, surface_samples=50)
    assert fit.levels[0].GetNumberOfPolys() == 20
    torus = fit_levels(ball, template="torus", torus_segments=9, levels=1, iterations=1, surface_samples=50)
    assert torus.levels[0].GetNumberOfPolys() == 54


def test_a_template_of_the_surface_fits_any_topology_closely():
    from vtkmodules.vtkFiltersCore import vtkTriangleFilter
    from vtkmodules.vtkFiltersSources import vtkPlaneSource

    flat = vtkPlaneSource()
    flat.SetResolution(20, 20)
    triangles = vtkTriangleFilter()
    triangles.SetInputConnection(flat.GetOutputPort())
    triangles.Update()
    plane = triangles.GetOutput()
    fit = fit_levels(plane, template="surface", levels=3, template_triangles=20, smoothing_length=0.01, iterations=20)
    coarse = fit.template.GetNumberOfPolys()
    assert 16 <= coarse <= 20
    assert [level.GetNumberOfPolys() for level in fit.levels] == [coarse, 4 * coarse, 16 * coarse]
    assert fit.symmetric_mean_distances[-1] < 2e-3 and fit.mean_normal_angles[-1] < 1e-3
    assert fit.symmetric_percentiles_95[-1] < 1e-2
    assert fit.self_intersections[-1] in (0, None)
    points = points_of(fit.levels[-1])
    assert np.abs(points[:, :2]).max() <= 0.5 + 1e-6 and np.abs(points[:, :2]).max(axis=0) == pytest.approx(0.5)
    fan = (np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1.0]]), np.array([[0, 1, 2], [1, 0, 3], [0, 1, 4]]))
    with pytest.raises(SurfaceSynthesisError, match="non-manifold|three or more|manifold"):
        fit_levels(fan, template="surface", levels=1)


@pytest.mark.parametrize(
    "parameters, error",
    [
        ({"template_triangles": 3}, ValueError),
        ({"smoothing_length": 0.0}, ValueError),
        ({"template": "sphere"}, ValueError),
        ({"levels": 0}, ValueError),
        ({"levels": 11}, ValueError),
        ({"template": "cube"}, ValueError),
        ({"template": 3}, TypeError),
        ({"iterations": -1}, ValueError),
        ({"learning_rate": 0}, ValueError),
        ({"learning_rate": 1e300}, ValueError),
        ({"learning_rate_decay": 1.5}, ValueError),
        ({"surface_samples": 1.5}, TypeError),
        ({"dataset": ""}, ValueError),
    ],
)
def test_arguments_of_the_fit_are_checked(ball, parameters, error):
    with pytest.raises(error):
        fit_levels(ball, **parameters)


@pytest.mark.parametrize(
    "parameters, error",
    [
        ({"iterations": 0}, ValueError),
        ({"iterations": [3, 0]}, ValueError),
        ({"iterations": [3, 1.5]}, TypeError),
        ({"penalty_interval": 0}, ValueError),
        ({"objective": "diffusion"}, ValueError),
        ({"flow_steps": 0}, ValueError),
        ({"base_samples": -1}, ValueError),
        ({"base_noise_amplitude": -0.1}, ValueError),
        ({"projections": 0}, ValueError),
        ({"references": [3]}, TypeError),
        ({"levels": None, "dataset": "a.safetensors", "references": [[]]}, TypeError),
        ({"layers": 2}, ValueError),
        ({"learning_rate_factor": 1.5}, ValueError),
        ({"device": "tpu"}, ValueError),
        ({"texture_name": ""}, ValueError),
        ({"levels": None}, TypeError),
        ({"dataset": "a.safetensors"}, TypeError),
    ],
)
def test_arguments_of_the_training_are_checked(ball, tmp_path, parameters, error):
    with pytest.raises(error):
        train_geometric_texture(**{"levels": [ball], "model": tmp_path / "a.model", **parameters})


def test_levels_have_their_iterations_and_references_are_drawn(ball, tmp_path):
    flat = (ball[0] * [1, 1, 0.5], ball[1])
    both = train_geometric_texture(
        [ball], references=[[flat]], model=tmp_path / "both.model", **{**SMALL, "iterations": [3], "penalty_interval": 2}
    )
    assert len(both["level"]) == 3
    first, second = str(tmp_path / "ball.safetensors"), str(tmp_path / "flat.safetensors")
    for shape, path in ((ball, first), (flat, second)):
        fit_levels(shape, template=shape, levels=1, iterations=0, dataset=path)
    model = str(tmp_path / "files.model")
    options = ["--layers", "3", "--start-channels", "4", "--minimum-channels", "4", "--device", "cpu"]
    options += ["--references", second, "--penalty-interval", "2"]
    assert main(["train", "geometric-texture", first, model, *options, "--iterations", "3"]) == 0
    assert main(["train", "geometric-texture", first, model, *options, "--iterations", "3,2", "--no-resume"]) == 1


@pytest.mark.parametrize("objective", ["sliced_wasserstein", "flow_matching"])
def test_objectives_train_models_that_synthesize(ball, tmp_path, objective):
    model, same = str(tmp_path / "a.model"), str(tmp_path / "b.model")
    own = {"objective": objective, "flow_steps": 2, "projections": 5}
    losses = train_geometric_texture([ball], model=model, **{**SMALL, "iterations": [3], **own})
    assert (losses["critic_loss"] == 0).all() and (losses["reconstruction_loss"] > 0).all()
    dataset = str(tmp_path / "ball.safetensors")
    fit_levels(ball, template=ball, levels=1, iterations=0, dataset=dataset)
    options = ["--layers", "3", "--start-channels", "4", "--minimum-channels", "4", "--device", "cpu", "--flow-steps", "2"]
    options += ["--objective", objective, "--projections", "5", "--iterations", "3"]
    assert main(["train", "geometric-texture", dataset, same, *options]) == 0
    target = polydata_of(*ball)
    points = points_of(geometric_texture(target, model, seed=3))
    assert np.isfinite(points).all() and np.abs(points - ball[0]).max() > 1e-3
    assert points_of(geometric_texture(target, same, seed=3)).shape == points.shape
    by_reference = points_of(geometric_texture(target, model, seed=3, norm_statistics="reference"))
    assert np.isfinite(by_reference).all() and not np.array_equal(by_reference, points)


@pytest.mark.parametrize("text", ["", "2000,", "2000,,600", "many", "1.5"])
def test_lists_of_iterations_are_whole_numbers(text, capsys):
    assert main(["train", "geometric-texture", "a.safetensors", "b.safetensors", "--iterations", text]) == 2
    message = f'argument --iterations: "{text}" is neither a whole number nor one for each level, with commas between'
    assert message in capsys.readouterr().err


def test_references_are_given_one_by_one_or_as_any_iterable(ball, tmp_path):
    """The same references in any form give the same model; another number of them gives another one."""
    flat, long = ((ball[0] * [1, 1, height], ball[1]) for height in (0.5, 2))
    path = tmp_path / "flat.safetensors"
    fit = fit_levels(flat, template=flat, levels=1, iterations=0, dataset=path)
    blocks = vtkMultiBlockDataSet()
    blocks.SetBlock(0, fit.levels[0])

    def model_of(references):
        model = tmp_path / "some.model"
        train_geometric_texture([ball], references=references, model=model, resume=False, **{**SMALL, "iterations": 4})
        return model.read_bytes()

    one = model_of([path])
    for references in (path, str(path), str(path).encode(), blocks, (given for given in [path])):
        assert model_of(references) == one, references
    both = model_of([path, [long]])
    assert both != one
    assert model_of(given for given in [path, [long]]) == both
    with pytest.raises(ValueError, match="each of the references must be a path"):
        model_of("")


def test_errors_of_fit_and_training_are_exceptions(ball, tmp_path):
    with pytest.raises(SurfaceSynthesisError, match="first cell 3"):
        broken = ball[1].copy()
        broken[3] = [0, 0, 1]
        fit_levels((ball[0], broken), **FIT)
    with pytest.raises(SurfaceSynthesisError, match="evel 1"):
        train_geometric_texture([ball, ball], model=tmp_path / "a.model", **SMALL)


def test_the_commands_make_a_texture_of_a_file(ball, tmp_path, capsys):
    write_mesh(polydata_of(ball[0] * [1, 1, 2], ball[1]), tmp_path / "egg.ply")
    dataset, model_file = str(tmp_path / "levels.safetensors"), str(tmp_path / "egg.safetensors")
    options = ["--levels", "2", "--icosphere-level", "1", "--iterations", "3", "--surface-samples", "100"]
    assert main(["levels", str(tmp_path / "egg.ply"), dataset, *options]) == 0
    assert "2 levels, 320 triangles" in capsys.readouterr().out
    options = ["--levels", "2", "--template", "surface", "--template-triangles", "40", "--iterations", "3"]
    assert main(["levels", str(tmp_path / "egg.ply"), str(tmp_path / "other.safetensors"), *options]) == 0
    printed = capsys.readouterr().out
    assert "2 levels, 160 triangles" in printed and "both directions" in printed
    options = ["--iterations", "2", "--layers", "3", "--start-channels", "4", "--minimum-channels", "4",
               "--texture-name", "egg"]
    assert main(["train", "geometric-texture", dataset, model_file, *options, "--device", "cpu"]) == 0
    assert "4 iterations" in capsys.readouterr().out
    assert (tmp_path / "egg.safetensors.csv").exists() and (tmp_path / "egg.safetensors.checkpoint").exists()
    assert main(["geometric-texture", str(tmp_path / "sample.ply"), "--model", model_file]) == 0
    assert '"egg"' in capsys.readouterr().out
    assert main(["train", "geometric-texture", str(tmp_path / "none"), model_file]) == 1
    assert main(["levels", str(tmp_path / "egg.ply"), dataset, "--levels", "0"]) == 2
