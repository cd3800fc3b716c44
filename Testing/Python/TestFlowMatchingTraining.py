# SPDX-License-Identifier: BSD-3-Clause
"""surfacesynthesis.train_flow_matching() and the command ``train flow-matching``."""

import inspect
import os
import pty
import re
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from conftest import add_array, icosphere, polydata_of, read_terminal
from surfacesynthesis import (
    Cancelled,
    SurfaceSynthesisError,
    flow_matching_training,
    geometric_texture_training,
    train_flow_matching,
    train_geometric_texture,
    training,
    write_mesh,
    write_signal_dataset,
)
from surfacesynthesis.command_line import main
from surfacesynthesis.safetensors import read_safetensors, write_safetensors
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet, vtkPolyData

TINY = {"width": 8, "blocks": 2, "layers": 2, "batch": 2, "device": "cpu"}
TINY.update({"schedule": "milestones", "milestones": [3]})
TINY_OPTIONS = ["--width", "8", "--blocks", "2", "--layers", "2", "--batch", "2", "--device", "cpu"]
TINY_OPTIONS += ["--schedule", "milestones", "--milestone", "3"]
STRETCHES = (1.2, 1.5, 0.7)


@pytest.fixture
def ball():
    points, triangles = icosphere(1)
    return points.astype(np.float32), triangles  # as a dataset file that is written here holds them


def stretched(ball, stretch):
    return ball[0] * [1.0, 1.0, stretch], ball[1]


def samples_of(ball):
    return [polydata_of(*stretched(ball, stretch)) for stretch in STRETCHES]


def blocks_of(datasets):
    blocks = vtkMultiBlockDataSet()
    for number, dataset in enumerate(datasets):
        blocks.SetBlock(number, dataset)
    return blocks


def write_dataset(path, *sources):
    tensors = {}
    for number, (points, triangles) in enumerate(sources):
        tensors[f"sources.{number}.points"] = points
        tensors[f"sources.{number}.triangles"] = triangles.astype(np.int64)
        samples = [stretched((points, triangles), s)[0] for s in STRETCHES]
        tensors[f"sources.{number}.signals"] = np.array(samples, dtype=np.float32)
    write_safetensors(path, tensors, {"content": "surface_signals", "format_version": "1", "signal_name": "Position"})
    return path


def train(tmp_path, name, *arguments, **options):
    """The bytes of the model, and the losses."""
    losses = train_flow_matching(*arguments, model=tmp_path / name, **{"iterations": 5, **TINY, **options})
    return (tmp_path / name).read_bytes(), losses


def test_samples_of_every_kind_give_the_model_of_the_dataset_file(tmp_path, ball):
    expected, losses = train(tmp_path, "dataset", dataset=write_dataset(tmp_path / "data.safetensors", ball))
    assert losses["iteration"].tolist() == [1, 2, 3, 4, 5]
    assert np.allclose(losses["loss"], losses["vertex_loss"] + losses["jacobian_loss"])
    assert losses["learning_rate"].tolist() == pytest.approx([2e-2] * 3 + [4e-3] * 2)
    by_time = np.stack([losses[f"loss_{k}"] for k in range(1, 9)])
    assert by_time.shape == (8, 5) and (by_time >= 0).all() and 2 <= (by_time[:, -1] > 0).sum() <= 8
    samples = samples_of(ball)
    blocks = blocks_of(samples)
    arrays = np.array([stretched(ball, stretch)[0] for stretch in STRETCHES])
    for number, given in enumerate((samples, blocks, [stretched(ball, s) for s in STRETCHES], arrays)):
        source = ball if number % 2 else polydata_of(*ball)
        assert train(tmp_path, f"given{number}", source, given)[0] == expected


def test_a_model_names_where_its_data_come_from(tmp_path, ball):
    data = tmp_path / "named.safetensors"
    samples = np.array([stretched(ball, stretch)[0] for stretch in STRETCHES])
    write_signal_dataset(data, [(ball, samples)], "Position", origin="a package", license="a license")
    train(tmp_path, "named", dataset=data)
    metadata = read_safetensors(tmp_path / "named")[1]
    assert (metadata["origin"], metadata["license"]) == ("a package", "a license")
    write_signal_dataset(data, [(ball, samples)], "Position")
    train(tmp_path, "unnamed", dataset=data)
    assert not {"origin", "license"} & set(read_safetensors(tmp_path / "unnamed")[1])


def test_a_signal_is_learned_by_its_name_or_from_an_array(tmp_path, ball):
    values = np.random.default_rng(3).normal(size=(3, len(ball[0]), 2))
    surface = polydata_of(*ball)
    for number, sample in enumerate(values):
        add_array(surface.GetPointData(), f"Heat_{number}", sample)
    by_name = train(tmp_path, "name", surface, surface, signal="Heat")[0]
    assert train(tmp_path, "array", ball, values, signal="Heat")[0] == by_name


def test_a_stopped_training_goes_on(tmp_path, ball):
    whole, whole_losses = train(tmp_path, "whole", ball, samples_of(ball), iterations=12)
    with pytest.raises(Cancelled):
        train(tmp_path, "parts", ball, samples_of(ball), iterations=12, progress=lambda fraction: fraction < 0.5)
    assert (tmp_path / "parts.checkpoint").exists()
    reports = []
    parts, losses = train(tmp_path, "parts", ball, samples_of(ball), iterations=12, progress=reports.append)
    assert parts == whole
    assert np.array_equal(losses["loss"], whole_losses["loss"])
    assert reports == sorted(reports) and reports[-1] == 1.0
    with pytest.raises(SurfaceSynthesisError, match="seed = 0; expected 1"):
        train(tmp_path, "parts", ball, samples_of(ball), iterations=12, seed=1)
    train(tmp_path, "parts", ball, samples_of(ball), iterations=12, seed=1, resume=False)


def test_the_time_to_expect_is_logged_once(tmp_path, ball, caplog):
    def until_it_is(_):
        return not caplog.messages

    with pytest.raises(Cancelled):
        train(tmp_path, "long", ball, samples_of(ball), iterations=100000000, time_budget=600, progress=until_it_is)
    (text,) = caplog.messages
    assert re.fullmatch(
        r"The other \d+ of 100000000 iterations take about \d+:\d\d:\d\d\. "
        r"The TimeBudget ends this update after 600 minutes\.", text
    )
    assert caplog.records[0].name == "surfacesynthesis"


def test_many_sources_are_trained_with_an_encoder(tmp_path, ball):
    bodies = blocks_of([polydata_of(*ball), polydata_of(*stretched(ball, 2.0))])
    poses = blocks_of([blocks_of(samples_of(ball)), polydata_of(*stretched(ball, 1.8))])
    with pytest.raises(SurfaceSynthesisError, match="surfaces have different shapes.*encoder"):
        train(tmp_path, "model", bodies, poses)
    options = {"encoder_iterations": 4, "eigenfunctions": 3}
    model, losses = train(tmp_path, "model", bodies, poses, losses=tmp_path / "model.csv", **options)
    assert losses["iteration"].tolist() == [1, 2, 3, 4, 5]
    assert len((tmp_path / "model.encoder.csv").read_text().splitlines()) == 5
    assert train(tmp_path, "again", bodies, poses, encoder=tmp_path / "model.encoder")[0] == model
    assert train(tmp_path, "limited", bodies, poses, encoder=tmp_path / "model.encoder", source_memory=0.0)[0] == model

    with pytest.raises(Cancelled):
        train(tmp_path, "parts", bodies, poses, progress=lambda fraction: fraction < 0.3, **options)
    assert (tmp_path / "parts.encoder.checkpoint").exists() and not (tmp_path / "parts").exists()
    assert train(tmp_path, "parts", bodies, poses, **options)[0] == model

    with pytest.raises(SurfaceSynthesisError, match="there is one source"):
        train(tmp_path, "one", ball, samples_of(ball), **options)
    coarse = blocks_of([polydata_of(*ball), polydata_of(*icosphere(2))])
    with pytest.raises(SurfaceSynthesisError, match="source 1 has 162 vertices"):
        train(tmp_path, "coarse", coarse, coarse, **options)
    assert not (tmp_path / "one").exists() and not (tmp_path / "coarse").exists()


def test_many_sources_are_trained_without_an_encoder_where_that_is_asked_for(tmp_path, ball):
    bodies = blocks_of([polydata_of(*ball), polydata_of(*stretched(ball, 2.0))])
    poses = blocks_of([blocks_of(samples_of(ball)), polydata_of(*stretched(ball, 1.8))])
    model, _ = train(tmp_path, "model", bodies, poses, without_encoder=True)
    assert b'"encoder' not in model
    with pytest.raises(SurfaceSynthesisError, match="EncoderIterations is 4 and WithoutEncoder is on"):
        train(tmp_path, "both", bodies, poses, without_encoder=True, encoder_iterations=4, eigenfunctions=3)


@pytest.mark.parametrize(
    "options, error, text",
    [
        ({"width": 0}, ValueError, "width must be from 1"),
        ({"blocks": 1001}, ValueError, "blocks must be at most 1000"),
        ({"encoder_iterations": -1}, ValueError, "encoder_iterations must be from 0"),
        ({"eigenfunctions": 0}, ValueError, "eigenfunctions must be from 1"),
        ({"layers": 1.5}, TypeError, "layers must be an integer"),
        ({"iterations": 0}, ValueError, "iterations must be"),
        ({"noise_model": "pink"}, ValueError, "unknown noise_model 'pink'"),
        ({"device": "tpu"}, ValueError, "unknown device 'tpu'"),
        ({"learning_rate": 0.0}, ValueError, "learning_rate must be"),
        ({"learning_rate": 1e300}, ValueError, "learning_rate must be at most 1e\\+30, not 1e\\+300"),
        ({"learning_rate_factor": 1.5}, ValueError, "learning_rate_factor must be at most 1"),
        ({"averaging": 1.0}, ValueError, "averaging must be from 0"),
        ({"clip": float("nan")}, ValueError, "clip must be a finite number"),
        ({"milestones": [-1]}, ValueError, "milestones must be from 0"),
        ({"resume": 1}, TypeError, "resume must be True or False"),
        ({"signal": ""}, ValueError, "signal must be the name of an array"),
        ({"checkpoint": 3}, TypeError, "checkpoint must be a path"),
        ({"progress": 3}, TypeError, "progress must be callable"),
        ({"sources_per_batch": 3}, SurfaceSynthesisError, "divides BatchSize"),
        ({"source_memory": -1.0}, ValueError, "source_memory must be at least 0"),
        ({"without_encoder": 1}, TypeError, "without_encoder must be True or False"),
        ({"dataset": "data.safetensors"}, TypeError, "in place of source and samples"),
        ({"depth": 3}, TypeError, "depth"),
    ],
)
def test_wrong_arguments(tmp_path, ball, options, error, text):
    with pytest.raises(error, match=text):
        train(tmp_path, "model", ball, samples_of(ball), **options)
    assert not (tmp_path / "model").exists()


@pytest.mark.parametrize(
    "function, configured",
    [
        (train_flow_matching, flow_matching_training.configured_filter),
        (train_geometric_texture, geometric_texture_training.configured_trainer),
    ],
)
def test_each_training_documents_the_shared_parameters(function, configured):
    shared = set(inspect.signature(training.configure).parameters) - {"algorithm"}
    assert {"model", "checkpoint", "learning_rate", "seed", "device"} <= shared
    assert shared <= set(inspect.signature(configured).parameters)
    for name in shared - {"model", "dataset"}:
        assert function.__doc__.count(f"    {name} : ") == 1, name
    assert "(shared parameters)" not in function.__doc__ and "    Raises\n" in function.__doc__
    with pytest.raises(TypeError, match="unexpected keyword argument 'speed'"):
        configured("model", speed=1)


def test_the_class_of_all_trainers_is_abstract():
    assert issubclass(flow_matching_training.vtkFlowMatchingTrainer, training.vtkModelTrainer)
    assert issubclass(geometric_texture_training.vtkGeometricTextureTrainer, training.vtkModelTrainer)
    with pytest.raises((TypeError, NotImplementedError)):
        training.vtkModelTrainer()


def test_wrong_inputs(tmp_path, ball):
    with pytest.raises(TypeError, match="source and samples are needed, or a dataset"):
        train(tmp_path, "model", ball)
    with pytest.raises(ValueError, match=r"\[N, V, 3\] with V = 42 points"):
        train(tmp_path, "model", ball, np.zeros((2, 41, 3)))
    with pytest.raises(SurfaceSynthesisError, match="training sample 0 .Block 1. has 162 points"):
        train(tmp_path, "model", ball, [icosphere(2)])
    with pytest.raises(SurfaceSynthesisError, match="absent"):
        train(tmp_path, "model", dataset=tmp_path / "absent")


def test_empty_inputs_give_no_model(tmp_path):
    losses = train_flow_matching(vtkPolyData(), vtkMultiBlockDataSet(), model=tmp_path / "model")
    assert all(len(values) == 0 for values in losses.values())
    assert not os.listdir(tmp_path)


# -- the command -----------------------------------------------------------------------------------------------------


@pytest.fixture
def files(tmp_path, ball):
    """The arguments that name files: of a dataset, and of surfaces."""
    write_mesh(polydata_of(*ball), tmp_path / "ball.vtp")
    for number, sample in enumerate(samples_of(ball)):
        write_mesh(sample, tmp_path / f"sample{number}.vtp")
    surfaces = ["ball.vtp", *(f"sample{k}.vtp" for k in range(3))]
    return [str(write_dataset(tmp_path / "data.safetensors", ball))], [str(tmp_path / name) for name in surfaces]


def test_the_command_trains_on_a_dataset_or_on_surfaces(tmp_path, files, capsys):
    models = []
    for name, given in zip(("a", "b"), files):
        model = str(tmp_path / f"{name}.safetensors")
        assert main(["train", "flow-matching", *given, model, "--iterations", "5", *TINY_OPTIONS]) == 0
        printed = capsys.readouterr()
        assert printed.out.startswith("5 iterations, loss ") and printed.out.endswith(f"-> {model}\n")
        assert printed.err == ""
        with open(model + ".csv", encoding="ascii") as table:
            assert len(table.readlines()) == 6
        with open(model, "rb") as file:
            models.append(file.read())
    assert models[0] == models[1]


def test_wrong_usage_of_the_command(tmp_path, files, capsys):
    for arguments, text in (
        (["m"], "needs DATASET.safetensors MODEL"),
        ([files[1][0], "m"], "needs DATASET.safetensors MODEL"),
        ([*files[0], "m", "--width", "0"], "width must be from 1"),
        ([*files[0], "m", "--noise-model", "pink"], "pink"),
        ([*files[0], "m", "--depth", "3"], "--depth"),
    ):
        assert main(["train", "flow-matching", *arguments]) == 2
        assert text in capsys.readouterr().err
    assert main(["train", "flow-matching", *files[0], str(tmp_path / "absent" / "m")]) == 1
    assert "the file of the model" in capsys.readouterr().err
    with open(files[0][0], "rb") as data:
        before = data.read()
    assert main(["train", "flow-matching", *files[0], files[0][0]]) == 1
    assert "is one that the training is made from" in capsys.readouterr().err
    with open(files[0][0], "rb") as data:
        assert data.read() == before
    assert main(["train"]) == 2


def test_the_command_trains_an_encoder_for_many_sources(tmp_path, ball, capsys):
    data = str(write_dataset(tmp_path / "bodies.safetensors", ball, stretched(ball, 2.0)))
    bodies, poses, model = (str(tmp_path / name) for name in ("bodies.vtm", "poses.vtm", "m.safetensors"))
    write_mesh(blocks_of([polydata_of(*ball), polydata_of(*stretched(ball, 2.0))]), bodies)
    write_mesh(blocks_of([blocks_of(samples_of(source)) for source in (ball, stretched(ball, 2.0))]), poses)
    options = ["--iterations", "5", "--encoder-iterations", "4", "--eigenfunctions", "3", *TINY_OPTIONS]
    assert main(["train", "flow-matching", data, model, *options]) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    assert "encoder loss " in printed.out
    surfaces = str(tmp_path / "surfaces.safetensors")
    assert main(["train", "flow-matching", bodies, poses, surfaces, *options, "--encoder", str(tmp_path / "e")]) == 0
    for other, kind in ((surfaces, ""), (str(tmp_path / "e"), ".encoder")):
        with open(model + kind, "rb") as expected, open(other, "rb") as found:
            assert found.read() == expected.read(), kind
    assert os.path.exists(model + ".encoder.csv")


def start(arguments, stderr):
    command = [sys.executable, "-m", "surfacesynthesis", "train", "flow-matching", *arguments, *TINY_OPTIONS]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=stderr, text=True)


def test_ctrl_c_leaves_a_checkpoint_to_go_on_from(tmp_path, files):
    model = str(tmp_path / "m.safetensors")
    arguments = [*files[0], model, "--checkpoint-interval", "1"]
    process = start([*arguments, "--iterations", "100000000"], subprocess.PIPE)
    said = process.stderr.readline()
    assert re.match(r"surfacesynthesis: The other \d+ of 100000000 iterations take about ", said), said
    assert os.path.exists(model + ".csv")
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130
    assert errors == f"surfacesynthesis: interrupted; the same command goes on from {model}.checkpoint\n"
    with open(model + ".csv", encoding="ascii") as table:
        done = len(table.readlines()) - 1
    assert done >= 1
    again = start([*arguments, "--iterations", str(done + 2)], subprocess.PIPE)
    output, errors = again.communicate(timeout=100)
    assert (again.returncode, errors) == (0, "")
    assert output.startswith(f"{done + 2:,} iterations")


def test_a_terminal_sees_the_time_left(tmp_path, files):
    leader, follower = pty.openpty()
    process = start([*files[0], str(tmp_path / "m.safetensors"), "--iterations", "200"], follower)
    os.close(follower)
    shown = read_terminal(leader)
    assert process.wait(timeout=60) == 0
    assert b" of 200, loss " in shown and b" left" in shown and b"[###" in shown
