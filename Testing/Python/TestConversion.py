# SPDX-License-Identifier: BSD-3-Clause
"""surfacesynthesis.convert_checkpoint() and the command ``convert``, with a stand-in for PyTorch."""

import builtins
import json
import os
import pathlib
import pickle
import struct
import sys
import types

import numpy as np
import pytest
from surfacesynthesis import FormatError, SurfaceSynthesisError, convert_checkpoint
from surfacesynthesis.command_line import main
from surfacesynthesis.conversion import describe, expected_tensors
from surfacesynthesis.safetensors import write_safetensors
from surfacesynthesis.texture_conversion import describe_texture, texture_channels

#: As the published configurations are written, with keys about training.
CONFIG = {"nblocks": 2, "width": 8, "head_type": "njf", "cmlp_nlayers": 2, "inner_prod_features": True,
          "cmlp_modulate": True, "mlp_norm": False, "lr": 0.0005, "extra_features": 1}  # fmt: skip
CLASSIFIER = {"head": "linear", "n_blocks": 1, "C_width": 8, "classes": ["ant", "bee, wild", "çat"],
              "outputs_at": "faces", "last_activation": "log_softmax", "input_normalisation": "surface_area",
              "config": {"cmlp_nlayers": 1, "mlp_norm": True}}  # fmt: skip


class FakeTensor:
    """As much of torch.Tensor as is needed."""

    def __init__(self, values):
        self._values = np.asarray(values)
        self.shape = self._values.shape

    def detach(self):
        return self

    cpu = double = detach

    def numpy(self):
        return self._values.astype(np.float64)


def state_of(config, seed=3):
    random = np.random.default_rng(seed)
    shapes = expected_tensors(describe(config)[1])
    return {name: FakeTensor(random.uniform(-0.3, 0.3, shape)) for name, shape in shapes.items()}


@pytest.fixture
def checkpoint(tmp_path, monkeypatch):
    """A function that makes a checkpoint of an object, which a stand-in for torch.load() finds."""
    loaded = {}

    def load(path, map_location=None, weights_only=False):
        assert map_location == "cpu"
        assert weights_only is True, "code in a checkpoint must not run"
        return loaded[path]

    monkeypatch.setitem(sys.modules, "torch", types.SimpleNamespace(load=load, __version__="0"))

    def make(content, name="net.pt"):
        path = tmp_path / name
        path.write_bytes(b"a checkpoint")
        loaded[str(path)] = content
        return path

    return make


DTYPES = {"F32": "<f4", "F64": "<f8", "I64": "<i8"}


def contents(path):
    data = path.read_bytes()
    (length,) = struct.unpack("<Q", data[:8])
    header = json.loads(data[8 : 8 + length])
    metadata = header.pop("__metadata__")
    tensors = {}
    for name, entry in header.items():
        begin, end = entry["data_offsets"]
        raw = data[8 + length + begin : 8 + length + end]
        tensors[name] = np.frombuffer(raw, dtype=DTYPES[entry["dtype"]]).reshape(entry["shape"])
    return metadata, tensors


# -- what is written -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("place", [None, "model"])
def test_a_state_dictionary_becomes_a_model_file(place, checkpoint, tmp_path):
    state = state_of(CONFIG)
    source = checkpoint(state if place is None else {"model": state, "step": 17, "optimiser": {"lr": 1}})
    metadata = convert_checkpoint(source, tmp_path / "net.safetensors", CONFIG)
    written, tensors = contents(tmp_path / "net.safetensors")
    assert written == metadata
    assert set(tensors) == set(state)
    for name, values in tensors.items():
        assert np.array_equal(values, state[name].numpy().astype(np.float32))
    for key, value in {"head": "njf", "C_in": "3", "C_out": "3", "C_width": "8", "n_blocks": "2", "extra_features": "1",
                       "outputs_at": "vertices", "last_activation": "identity", "input_normalisation": "none",
                       "architecture": "poissonnet", "format_version": "1",
                       "producer": "SurfaceSynthesis"}.items():  # fmt: skip
        assert written[key] == value
    inner = json.loads(written["config"])
    assert inner["cmlp_nlayers"] == 2 and inner["lr"] == 0.0005 and "width" not in inner
    assert "classes" not in written


def test_classes_and_normalization_go_to_the_metadata(checkpoint, tmp_path):
    convert_checkpoint(checkpoint(state_of(CLASSIFIER)), tmp_path / "net.safetensors", CLASSIFIER)
    written, tensors = contents(tmp_path / "net.safetensors")
    assert json.loads(written["classes"]) == ["ant", "bee, wild", "çat"]
    assert (written["C_out"], written["input_normalisation"]) == ("3", "surface_area")
    assert tensors["head.weight"].shape == (3, 8)


def test_the_same_content_gives_the_same_bytes(checkpoint, tmp_path):
    source = checkpoint(state_of(CONFIG))
    for name in ("a", "b"):
        convert_checkpoint(source, tmp_path / name, CONFIG)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()
    assert len((tmp_path / "a").read_bytes()) % 4 == 0


def test_an_interrupted_write_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "net.safetensors"
    path.write_bytes(b"old")

    def fail(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", fail)
    with pytest.raises(OSError, match="No space.*net.safetensors"):
        write_safetensors(path, {"a": np.zeros(3)}, {})
    assert path.read_bytes() == b"old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["net.safetensors"]


def test_what_is_no_file_is_not_replaced(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", tmp_path):
        with pytest.raises(OSError, match="a folder or a device"):
            write_safetensors(path, {"a": np.zeros(3)}, {})
    assert [entry.name for entry in tmp_path.iterdir()] == ["pipe"]


@pytest.mark.parametrize("config", [CONFIG, CLASSIFIER, {**CLASSIFIER, "outputs_at": "global_mean"}])
def test_the_library_reads_what_is_written(config, checkpoint, tmp_path, pair):
    from surfacesynthesis import poisson_net

    path = tmp_path / "net.safetensors"
    convert_checkpoint(checkpoint(state_of(config)), path, config)
    conditions = 0.5 if config is CONFIG else None
    output = poisson_net(pair, path, conditions=conditions, normalization="surface_area")
    assert np.all(np.isfinite(output.values))
    assert output.class_names == config.get("classes", [])


# -- geometric textures ----------------------------------------------------------------------------------------------

ROOT = pathlib.Path(__file__).resolve().parents[2]
MODELS = ROOT / "Examples" / "Models"
#: As options.json of the published code, where it differs from its defaults or is about something else.
TEXTURE = {"mesh_name": "virus_ball", "num_levels": 4, "max_nf": 64, "noise_before": True, "in_nf": 4, "scale_vs_factor": 2,
           "fix_vs_noise": True, "tag": "demo", "lr": 0.0005, "save_path": "checkpoints/virus", "debug": False}  # fmt: skip


def generator_of(path):
    """The state dictionary of the generator in a model file."""
    _, tensors = contents(path)
    return {name: FakeTensor(values) for name, values in tensors.items() if name.startswith("levels.")}


def test_a_published_generator_becomes_a_geometric_texture(checkpoint, tmp_path, pair):
    """The generator of a model, converted from its tensors alone, grows the same texture to the last bit."""
    from surfacesynthesis import geometric_texture

    source = checkpoint(generator_of(MODELS / "spikes.safetensors"), "SingleMeshGenerator.pth")
    path = tmp_path / "virus.safetensors"
    metadata = convert_checkpoint(source, path, TEXTURE)
    assert contents(path)[0] == metadata
    assert json.loads(metadata["config"]) == {"tag": "demo", "lr": 0.0005}
    how = {"start_level": 1, "seed": 3}
    converted, own = (geometric_texture(pair, model, **how) for model in (path, MODELS / "spikes.safetensors"))
    assert np.array_equal(converted[0], own[0]) and np.array_equal(converted[1], own[1])
    quiet = {**TEXTURE, "noise_amplitude": 0}
    convert_checkpoint(source, path, quiet)
    still = [geometric_texture(pair, path, start_level=1, seed=seed)[0] for seed in (1, 2)]
    assert np.array_equal(*still) and not np.array_equal(still[0], own[0])
    with pytest.raises(SurfaceSynthesisError, match="no template"):
        geometric_texture(None, path)


def test_a_state_dictionary_of_the_published_code_is_taken(checkpoint, tmp_path, pair):
    """Names and shapes are those of a generator that the published code made, of whose five levels three are kept."""
    from surfacesynthesis import geometric_texture

    fixture = ROOT / "Testing" / "Data" / "Parity" / "dgts" / "generator_random.safetensors"
    published = contents(fixture)[0]
    numbers = ("num_levels", "num_layers", "start_nf", "min_nf", "max_nf", "in_nf")
    config = {name: int(published[name]) for name in numbers}
    network = describe_texture(config)[1]
    channels = [texture_channels(network, level) for level in range(5)]
    assert channels == json.loads(published["fe_lists_generator"])
    path = tmp_path / "random.safetensors"
    convert_checkpoint(checkpoint(generator_of(fixture)), path, {**config, "num_levels": 3})
    points, triangles = geometric_texture(pair, path)
    assert len(triangles) == 16 * len(pair[1]) and np.all(np.isfinite(points))


@pytest.mark.parametrize(
    "change, words",
    [
        ({"num_levels": 0}, "num_levels must be a whole number from 1 to 16"),
        ({"num_layers": 2}, "num_layers must be a whole number from 3 to 32"),
        ({"start_nf": 32.5}, "start_nf must be a whole number"),
        ({"noise_before": False}, "noise_before must be true, as published, not False"),
        ({"nb_features": True}, "nb_features must be false"),
        ({"scale_vs_factor": 3}, "scale_vs_factor must be 2"),
        ({"noise_amplitude": -0.1}, "noise_amplitude must be a number of at least 0"),
        ({"noise_amplitude": float("nan")}, "noise_amplitude must be a number"),
        ({"mesh_name": ""}, "mesh_name must be the name"),
    ],
)
def test_configurations_that_describe_no_texture(change, words, checkpoint, tmp_path):
    with pytest.raises(ValueError, match=words):
        convert_checkpoint(checkpoint({}), tmp_path / "virus.safetensors", {**TEXTURE, **change})
    assert not (tmp_path / "virus.safetensors").exists()


def test_generators_that_are_not_those_of_the_configuration(checkpoint, tmp_path):
    source = checkpoint(generator_of(MODELS / "spikes.safetensors"))
    wrong = {"num_levels": 3, "max_nf": 128, "num_layers": 6, "min_nf": 16, "start_nf": 16}
    for name, value in wrong.items():
        with pytest.raises(SurfaceSynthesisError, match="the tensors are not those of the network"):
            convert_checkpoint(source, tmp_path / "virus.safetensors", {**TEXTURE, name: value})


# -- what is refused -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "change, words",
    [
        ({"head": "mlp"}, "head must be one of linear, njf"),
        ({"head": None}, "head must be one of linear, njf"),
        ({"C_width": None}, "C_width is missing"),
        ({"C_width": 0}, "C_width must be a whole number from 1"),
        ({"n_blocks": 2.5}, "n_blocks must be a whole number"),
        ({"n_blocks": True}, "n_blocks must be a whole number"),
        ({"config": {}}, "cmlp_nlayers is missing"),
        ({"config": [3]}, "must be an object"),
        ({"classes": "ant"}, "classes must be a list of names"),
        ({"C_out": 5}, "3 classes for 5 output channels"),
        ({"outputs_at": "edges"}, "outputs_at must be one of"),
        ({"input_normalisation": "unit"}, "input_normalisation must be one of"),
    ],
)
def test_configurations_that_describe_no_network(change, words, checkpoint, tmp_path):
    with pytest.raises(ValueError, match=words):
        convert_checkpoint(checkpoint({}), tmp_path / "net.safetensors", {**CLASSIFIER, **change})
    assert not (tmp_path / "net.safetensors").exists()


def test_tensors_that_are_not_those_of_the_configuration(checkpoint, tmp_path):
    state = state_of(CONFIG)
    del state["proj_in.bias"]
    state["proj_in.weight"] = FakeTensor(np.zeros((8, 4)))
    state["extra"] = FakeTensor(np.zeros(2))
    with pytest.raises(SurfaceSynthesisError) as caught:
        convert_checkpoint(checkpoint(state), tmp_path / "net.safetensors", CONFIG)
    for words in ("net.pt", "proj_in.bias [8] is missing", "proj_in.weight is [8, 4] instead of [8, 3]",
                  "extra does not belong to it"):  # fmt: skip
        assert words in str(caught.value)
    with pytest.raises(SurfaceSynthesisError, match="and [0-9]+ more"):
        convert_checkpoint(checkpoint(state), tmp_path / "net.safetensors", {**CONFIG, "nblocks": 3})


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e300])
def test_weights_that_are_not_finite(value, checkpoint, tmp_path):
    state = state_of(CONFIG)
    state["proj_in.bias"] = FakeTensor(np.full(8, value))
    with pytest.raises(FormatError, match="proj_in.bias holds a number"), np.errstate(over="ignore"):
        convert_checkpoint(checkpoint(state), tmp_path / "net.safetensors", CONFIG)


@pytest.mark.parametrize(
    "content, key, words",
    [
        ([1, 2], None, "the checkpoint is a list"),
        ({"step": 3}, None, "must be named by its key; the keys are step"),
        ({"a": {"x": FakeTensor([1])}, "b": {"x": FakeTensor([1])}}, None, "those of dictionaries of tensors a, b"),
        ({"step": 3}, "model", "there is no key 'model'"),
        ({"model": 3}, "model", "no dictionary of tensors"),
    ],
)
def test_checkpoints_without_a_state_dictionary(content, key, words, checkpoint, tmp_path):
    with pytest.raises(FormatError, match=words):
        convert_checkpoint(checkpoint(content), tmp_path / "net.safetensors", CONFIG, key=key)


def test_a_checkpoint_that_cannot_be_loaded(tmp_path, monkeypatch):
    def load(*_, **__):
        raise pickle.UnpicklingError(
            "Weights only load failed. (1) Re-running `torch.load` with `weights_only` set to `False` will likely succeed.\n"
            "(2) WeightsUnpickler error: Unsupported global: GLOBAL evil.function was not an allowed global by default."
        )

    monkeypatch.setitem(sys.modules, "torch", types.SimpleNamespace(load=load, __version__="0"))
    path = tmp_path / "evil.pt"
    path.write_bytes(b"x")
    with pytest.raises(FormatError, match="no checkpoint of tensors alone: evil.function in it would run code") as error:
        convert_checkpoint(path, tmp_path / "net.safetensors", CONFIG)
    assert "state_dict()" in str(error.value) and "weights_only" not in str(error.value)
    with pytest.raises(FileNotFoundError):
        convert_checkpoint(tmp_path / "none.pt", tmp_path / "net.safetensors", CONFIG)


def test_an_old_pytorch(checkpoint, tmp_path, monkeypatch):
    path = checkpoint({})

    def load(path, map_location=None):
        raise AssertionError("must not be called")

    monkeypatch.setitem(sys.modules, "torch", types.SimpleNamespace(load=load, __version__="1.9"))
    with pytest.raises(SurfaceSynthesisError, match="PyTorch 1.9 .* 1.13 or later is needed"):
        convert_checkpoint(path, tmp_path / "net.safetensors", CONFIG)


def test_without_pytorch(tmp_path, monkeypatch):
    original = builtins.__import__

    def no_torch(name, *arguments, **parameters):
        if name == "torch":
            raise ImportError("No module named 'torch'")
        return original(name, *arguments, **parameters)

    monkeypatch.setattr(builtins, "__import__", no_torch)
    with pytest.raises(SurfaceSynthesisError, match="PyTorch is needed to read .*net.pt"):
        convert_checkpoint(tmp_path / "net.pt", tmp_path / "net.safetensors", CONFIG)


# -- the command -----------------------------------------------------------------------------------------------------


def test_the_command_takes_a_file_or_text_and_further_values(checkpoint, tmp_path, capsys):
    source = checkpoint({"model": state_of(CONFIG)})
    config = {name: value for name, value in CONFIG.items() if name != "extra_features"}
    (tmp_path / "config.json").write_text(json.dumps(config), encoding="utf-8")
    for number, given in enumerate([str(tmp_path / "config.json"), json.dumps(config)]):
        target = tmp_path / f"{number}.safetensors"
        arguments = ["convert", str(source), str(target), "--config", given, "--key", "model"]
        assert main([*arguments, "--set", "extra_features=1", "--set", "input_normalisation=unit_sphere"]) == 0
        assert contents(target)[0]["input_normalisation"] == "unit_sphere"
        printed = capsys.readouterr().out
        assert printed.startswith("2 blocks, width 8, head njf, ") and printed.rstrip().endswith(str(target))


def test_the_command_converts_a_geometric_texture(checkpoint, tmp_path, capsys):
    source = checkpoint(generator_of(MODELS / "spikes.safetensors"))
    (tmp_path / "options.json").write_text(json.dumps(TEXTURE), encoding="utf-8")
    target = tmp_path / "virus.safetensors"
    assert main(["convert", str(source), str(target), "--config", str(tmp_path / "options.json")]) == 0
    printed = capsys.readouterr().out
    assert printed.startswith('geometric texture "virus_ball", 4 levels, 7 layers, ')
    assert printed.rstrip().endswith(str(target))


@pytest.mark.parametrize(
    "config, status, words",
    [
        ("{", 2, "no JSON"),
        ('{"num_levels": 0}', 2, "num_levels must be a whole number"),
        ("none.json", 1, "none.json: No such file"),
        ('{"head": "njf"}', 2, "C_width is missing"),
    ],
)
def test_the_command_reports_in_one_line(config, status, words, checkpoint, tmp_path, capsys):
    source = checkpoint(state_of(CONFIG))
    assert main(["convert", str(source), str(tmp_path / "net.safetensors"), "--config", config]) == status
    errors = capsys.readouterr().err
    assert words in errors and errors.count("\n") == 1
