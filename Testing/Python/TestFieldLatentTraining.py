# SPDX-License-Identifier: BSD-3-Clause
"""Training of field latents: train_field_latents() and its command."""

import numpy as np
import pytest
from surfacesynthesis import Cancelled, SurfaceSynthesisError, texture_dataset, train_field_latents
from surfacesynthesis.command_line import main
from surfacesynthesis.field_latents import image_of_array
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet
from vtkmodules.vtkIOImage import vtkPNGWriter

SMALL = {
    "iterations": 3,
    "batch": 6,
    "meshes": 2,
    "mesh_points": 60,
    "channels": 4,
    "encoder_layers": 1,
    "heads": 2,
    "samples_per_ring": 6,
    "decoder_layers": 1,
    "decoder_width": 8,
    "device": "cpu",
}


@pytest.fixture
def picture():
    random = np.random.default_rng(1)
    return random.integers(0, 256, (40, 50, 3), dtype=np.uint8)


def test_images_of_each_kind_give_the_same_model(picture, tmp_path):
    data = image_of_array(picture)
    writer = vtkPNGWriter()
    writer.SetFileName(str(tmp_path / "picture.png"))
    writer.SetInputData(data)
    writer.Write()
    blocks = vtkMultiBlockDataSet()
    blocks.SetBlock(0, data)
    models = []
    for number, images in enumerate(([picture], picture, data, blocks, [tmp_path / "picture.png"], [picture / 255.0])):
        models.append(tmp_path / f"{number}.safetensors")
        losses = train_field_latents(images, model=models[-1], **SMALL)
        assert list(losses["iteration"]) == [1, 2, 3] and all(np.isfinite(column).all() for column in losses.values())
        assert losses["learning_rate"][0] == 1e-3
    assert len({model.read_bytes() for model in models}) == 1


def test_a_dataset_takes_the_place_of_images(picture, tmp_path):
    dataset = tmp_path / "textures.safetensors"
    texture_dataset(dataset, [picture], meshes=2, mesh_points=60)
    losses = train_field_latents(dataset=dataset, model=tmp_path / "m.safetensors", sizes="small", **SMALL)
    assert len(losses["loss"]) == 3


def test_nothing_is_trained_on_no_images(tmp_path):
    losses = train_field_latents([], model=tmp_path / "none.safetensors", **SMALL)
    assert all(len(column) == 0 for column in losses.values()) and not (tmp_path / "none.safetensors").exists()


@pytest.mark.parametrize(
    "parameters, error",
    [
        ({"meshes": 0}, ValueError),
        ({"mesh_points": 15}, ValueError),
        ({"sizes": "large"}, ValueError),
        ({"coordinates": "polar"}, ValueError),
        ({"latent_dimension": 257}, ValueError),
        ({"heads": -1}, ValueError),
        ({"channels": 4.5}, TypeError),
        ({"final_learning_rate": 0}, ValueError),
        ({"final_learning_rate": 1e300}, ValueError),
        ({"minimum_texels": 0}, ValueError),
        ({"divergence_weight": -1}, ValueError),
        ({"images": None}, TypeError),
        ({"images": [np.zeros(3)]}, ValueError),
        ({"images": [np.zeros((20, 20), np.int32)]}, TypeError),
        ({"dataset": "a.safetensors"}, TypeError),
    ],
)
def test_arguments_are_checked(picture, tmp_path, parameters, error):
    with pytest.raises(error):
        train_field_latents(**{"images": [picture], "model": tmp_path / "a.safetensors", **SMALL, **parameters})


def test_errors_are_exceptions(picture, tmp_path):
    with pytest.raises(SurfaceSynthesisError, match="divisor"):
        train_field_latents([picture], model=tmp_path / "a.safetensors", **{**SMALL, "heads": 3})
    with pytest.raises(SurfaceSynthesisError, match="Image 1 has 15 x 20 x 1 pixels"):
        train_field_latents([picture, picture[:20, :15]], model=tmp_path / "a.safetensors", **SMALL)
    with pytest.raises(Cancelled):
        train_field_latents([picture], model=tmp_path / "a.safetensors", progress=lambda done: False, **SMALL)


def test_the_command_trains_on_images_and_on_a_dataset(picture, tmp_path, capsys):
    writer = vtkPNGWriter()
    writer.SetFileName(str(tmp_path / "picture.png"))
    writer.SetInputData(image_of_array(picture))
    writer.Write()
    options = [f"--{name.replace('_', '-')}={value}" for name, value in SMALL.items()]
    model = str(tmp_path / "model.safetensors")
    assert main(["train", "field-latents", str(tmp_path / "picture.png"), model, *options]) == 0
    assert "3 iterations, reconstruction loss" in capsys.readouterr().out
    train_field_latents([picture], model=tmp_path / "same.safetensors", **SMALL)
    assert (tmp_path / "same.safetensors").read_bytes() == (tmp_path / "model.safetensors").read_bytes()
    dataset = str(tmp_path / "textures.safetensors")
    texture_dataset(dataset, [picture], meshes=1, mesh_points=60)
    assert main(["train", "field-latents", dataset, str(tmp_path / "b"), *options, "--coordinates", "barycentric"]) == 0
    assert main(["train", "field-latents", model]) == 2
    assert main(["train", "field-latents", str(tmp_path / "none.png"), str(tmp_path / "c"), *options]) == 1
    assert "none.png" in capsys.readouterr().err
