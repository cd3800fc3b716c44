# SPDX-License-Identifier: BSD-3-Clause
"""Dataset files as surfaces and back, and dataset files as ensembles of commands."""

import json

import numpy as np
import pytest
from conftest import add_array, point_array, points_of, polydata_of, run_command

from surfacesynthesis import (
    FormatError,
    dataset_of_surfaces,
    ensemble_metrics,
    read_mesh,
    read_signal_dataset,
    surfaces_of_dataset,
    write_mesh,
    write_signal_dataset,
)


def positions(pair, number=4, seed=0):
    random = np.random.default_rng(seed)
    return (pair[0] + 0.1 * random.standard_normal((number, *pair[0].shape))).astype(np.float32)


@pytest.fixture
def folder(tmp_path, ball):
    write_signal_dataset(tmp_path / "poses.safetensors", [(ball, positions(ball))], "Position")
    write_signal_dataset(tmp_path / "others.safetensors", [(ball, positions(ball, 3, 1))], "Position")
    values = np.random.default_rng(2).standard_normal((11, len(ball[0]), 2))
    second = (ball[0] * [1, 2, 1], ball[1][:-3])
    write_signal_dataset(tmp_path / "heights.safetensors", [(ball, values), (second, values[:5])], "Height")
    write_signal_dataset(tmp_path / "one.safetensors", [(ball, values)], "Height")
    return tmp_path


@pytest.mark.parametrize("name, options", [("poses", []), ("heights", ["--array", "Height"])])
def test_files_come_back_with_the_same_bytes(folder, name, options):
    done = run_command("dataset", "export", f"{name}.safetensors", "made.vtm", cwd=folder)
    assert done.returncode == 0, done.stderr
    done = run_command("dataset", "import", "made.vtm", "again.safetensors", *options, cwd=folder)
    assert done.returncode == 0, done.stderr
    assert (folder / "again.safetensors").read_bytes() == (folder / f"{name}.safetensors").read_bytes()


def test_positions_are_blocks_of_samples(folder, ball):
    dataset = read_signal_dataset(folder / "poses.safetensors")
    blocks = surfaces_of_dataset(dataset, samples=2, first_sample=1)
    samples = blocks.GetBlock(0)
    assert blocks.GetNumberOfBlocks() == 1 and samples.GetNumberOfBlocks() == 2
    assert np.array_equal(points_of(samples.GetBlock(1)), dataset.sources[0].signals[2])
    assert np.array_equal(point_array(samples.GetBlock(0), "SourcePosition"), ball[0])
    assert not samples.GetBlock(1).GetPointData().HasArray("SourcePosition")
    with pytest.raises(ValueError, match="first_sample must be less than 4"):
        surfaces_of_dataset(dataset, first_sample=4)


def test_arrays_are_in_the_order_of_their_numbers(folder):
    done = run_command("dataset", "export", "one.safetensors", "made.vtp", "--json", cwd=folder)
    assert done.returncode == 0, done.stderr
    summary = json.loads(done.stdout)
    assert (summary["signal"], summary["samples"], summary["points"]) == ("Height", 11, 162)
    made, stored = read_mesh(folder / "made.vtp"), read_signal_dataset(folder / "one.safetensors")
    assert np.array_equal(point_array(made, "Height_10"), stored.sources[0].signals[10])
    assert np.array_equal(dataset_of_surfaces(made, "Height").sources[0].signals, stored.sources[0].signals)


def test_surfaces_of_files_become_a_dataset_on_a_source(folder, ball):
    samples = positions(ball)
    for number, sample in enumerate(samples):
        write_mesh(polydata_of(sample, ball[1]), folder / f"shape_{number}.vtp")
    write_mesh(polydata_of(*ball), folder / "source.vtp")
    shapes = [f"shape_{number}.vtp" for number in range(4)]
    done = run_command("dataset", "import", *shapes, "made.safetensors", "--source", "source.vtp", cwd=folder)
    assert done.returncode == 0, done.stderr
    assert (folder / "made.safetensors").read_bytes() == (folder / "poses.safetensors").read_bytes()
    done = run_command("dataset", "import", *shapes, "made.safetensors", cwd=folder)
    assert np.array_equal(read_signal_dataset(folder / "made.safetensors").sources[0].points, samples[0])
    for options, status, text in (
        (["shape_0.vtp", "made.ply"], 2, "datasets are .safetensors"),
        (["poses.safetensors", "made.safetensors"], 2, "surfaces are needed"),
        (["shape_0.vtp", "made.safetensors", "--array", "Height"], 1, "no numeric point array 'Height'"),
    ):
        done = run_command("dataset", "import", *options, cwd=folder)
        assert done.returncode == status and text in done.stderr, done.stderr


def test_a_source_on_another_triangulation_is_refused(ball):
    other = polydata_of(ball[0], ball[1][::-1])
    with pytest.raises(FormatError, match="surface 0 has other points or polygons than the source"):
        dataset_of_surfaces([ball], source=other)


def test_metrics_take_dataset_files(folder, ball):
    made, real = (read_signal_dataset(folder / name).sources[0].signals for name in ("poses.safetensors", "others.safetensors"))
    expected = ensemble_metrics(made, real, source=ball)
    done = run_command("metrics", "--generated", "poses.safetensors", "--reference", "others.safetensors", "--json", cwd=folder)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert {name: found[name] for name in expected} == pytest.approx(dict(expected), rel=1e-12)
    generated = [polydata_of(sample, ball[1]) for sample in made]
    for number, sample in enumerate(generated):
        write_mesh(sample, folder / f"made_{number}.vtp")
    files = [f"made_{number}.vtp" for number in range(4)]
    done = run_command("metrics", "--generated", *files, "--reference", "others.safetensors", "--json", cwd=folder)
    assert json.loads(done.stdout)["mmd"] == pytest.approx(expected["mmd"], rel=1e-12)
    done = run_command("metrics", "--generated", "one.safetensors", "--reference", "one.safetensors", "--json", cwd=folder)
    assert done.returncode == 0 and json.loads(done.stdout)["number_of_components"] == 2, done.stderr
    done = run_command("metrics", "--generated", "poses.safetensors", files[0], "--reference", files[0], cwd=folder)
    assert done.returncode == 2 and "an ensemble by itself" in done.stderr


def test_statistics_and_shape_models_take_dataset_files(folder):
    done = run_command("statistics", "one.safetensors", "out.vtp", "--modes", "2", "--json", cwd=folder)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["samples"] == 11
    done = run_command("statistics", "poses.safetensors", "model.vtp", "--modes", "3", cwd=folder)
    assert done.returncode == 0, done.stderr
    done = run_command("shape-model", "model.vtp", "near.vtm", "--shapes", "poses.safetensors", cwd=folder)
    assert done.returncode == 0, done.stderr
    shapes = read_signal_dataset(folder / "poses.safetensors").sources[0].signals
    assert np.abs(points_of(read_mesh(folder / "near.vtm").GetBlock(3)) - shapes[3]).max() < 1e-5


def test_files_with_arrays_are_an_ensemble_of_shared_polygons(folder, ball):
    for number in range(3):
        mesh = polydata_of(ball[0], ball[1])
        add_array(mesh.GetPointData(), "Height", np.full(len(ball[0]), float(number)))
        add_array(mesh.GetPointData(), "Other", np.zeros(len(ball[0])))
        write_mesh(mesh, folder / f"field_{number}.vtp")
    from surfacesynthesis.commands.metrics import read_ensemble

    blocks = read_ensemble([str(folder / f"field_{number}.vtp") for number in range(3)], "Height").dataset
    first, last = blocks.GetBlock(0), blocks.GetBlock(2)
    assert first.GetPolys() is last.GetPolys() and first.GetPointData().HasArray("Other")
    assert point_array(last, "Height")[0] == 2.0 and not last.GetPointData().HasArray("Other")
