# SPDX-License-Identifier: BSD-3-Clause
"""sample_texture(), train_latent_diffusion() and latent_dataset(): what the filters give, as Python has it."""

import numpy as np
import pytest
import surfacesynthesis
from conftest import add_array, icosphere, polydata_of
from latent_models import write_random_latents
from surfacesynthesis import SurfaceSynthesisError, decode_texture, sample_texture
from surfacesynthesis.command_line import main
from TestTextureCommands import pattern
from vtkmodules.util.numpy_support import vtk_to_numpy

pytestmark = pytest.mark.skipif(
    not hasattr(surfacesynthesis, "vtkIsotropicRemeshFilter") or "latent_dataset" not in surfacesynthesis.__all__,
    reason="remeshing needs CGAL, and training LibTorch, which this build lacks",
)


@pytest.fixture(scope="module")
def ball():
    mesh = surfacesynthesis.texture_atlas(polydata_of(*icosphere(2, 5.0)), resolution=64)
    add_array(mesh.GetPointData(), "Part", np.arange(mesh.GetNumberOfPoints()) % 2)
    return mesh


@pytest.fixture(scope="module")
def models(tmp_path_factory, ball):
    """The files of an autoencoder and of a diffusion model with two labels."""
    folder = tmp_path_factory.mktemp("models")
    autoencoder, dataset, model = (folder / f"{name}.safetensors" for name in ("latents", "dataset", "model"))
    write_random_latents(autoencoder)
    surfacesynthesis.latent_dataset(
        dataset, ball, pattern(), autoencoder=autoencoder, triangulations=2, points=70, label="Part"
    )
    losses = surfacesynthesis.train_latent_diffusion(
        model=model, dataset=dataset, channels=4, coarse_channels=4, iterations=2, batch=1
    )
    assert len(losses["loss"]) == 2 and len(losses) == 12
    return str(autoencoder), str(model)


def texels(image):
    return vtk_to_numpy(image.GetPointData().GetScalars())


def test_a_sample_is_a_surface_an_image_and_latents(ball, models):
    autoencoder, model = models
    sample = sample_texture(ball, model, autoencoder=autoencoder, steps=2, resolution=32)
    assert sample.mesh.GetNumberOfPoints() == ball.GetNumberOfPoints()
    assert sample.image.GetDimensions() == (32, 32, 1)
    assert 55 <= sample.latents.GetNumberOfPoints() <= 85  # as the training surfaces
    decoded = decode_texture(sample.latents, autoencoder, target=ball, resolution=32)
    difference = np.abs(texels(decoded.image).astype(int) - texels(sample.image).astype(int))
    assert difference.max() <= 1


def test_samples_are_a_list_and_alike_alone(ball, models):
    autoencoder, model = models
    options = {"autoencoder": autoencoder, "steps": 2, "resolution": 16, "label": "Part", "triangulation": "as_is"}
    both = sample_texture(ball, model, samples=2, first_sample=3, **options)
    (alone,) = sample_texture(ball, model, samples=1, first_sample=4, **options)
    assert (texels(both[1].image) == texels(alone.image)).all()
    assert (texels(both[0].image) != texels(alone.image)).any()


def test_a_trajectory_ends_at_the_sample(ball, models):
    autoencoder, model = models
    options = {"autoencoder": autoencoder, "steps": 2, "resolution": 16, "triangulation": "as_is"}
    alone = sample_texture(ball, model, **options)
    states = sample_texture(ball, model, trajectory=True, **options)
    assert len(states) == 3
    assert (texels(states[2].image) == texels(alone.image)).all()
    assert (texels(states[0].image) != texels(alone.image)).any()
    several = sample_texture(ball, model, trajectory=True, samples=2, **options)
    assert len(several) == 3
    assert (texels(several[2][0].image) == texels(alone.image)).all()


def test_wrong_arguments_are_named(ball, models):
    autoencoder, model = models
    for options, text in (
        ({"steps": 0}, "steps"),
        ({"points": 3}, "points"),
        ({"sampler": "euler"}, "sampler"),
        ({"samples": 0}, "samples"),
        ({"resolution": (1, 2, 3)}, "resolution"),
    ):
        with pytest.raises(ValueError, match=text):
            sample_texture(ball, model, autoencoder=autoencoder, **options)
    with pytest.raises(TypeError, match="mesh"):
        sample_texture(None, model)
    with pytest.raises(SurfaceSynthesisError, match="not directed"):
        sample_texture(ball, model, autoencoder=autoencoder, direction="Part", resolution=16)
    with pytest.raises(TypeError, match="mesh is needed"):
        surfacesynthesis.train_latent_diffusion(model="unused.safetensors")


def test_the_command_writes_a_file_for_each_sample(tmp_path, ball, models, capsys):
    autoencoder, model = models
    surfacesynthesis.write_mesh(ball, tmp_path / "ball.vtp")
    arguments = ["sample-texture", str(tmp_path / "ball.vtp"), str(tmp_path / "new.obj"), "--model", model]
    arguments += ["--autoencoder", autoencoder, "--steps", "1", "--resolution", "16", "--samples", "2", "--no-progress"]
    assert main(arguments) == 0, capsys.readouterr().err
    assert {path.name for path in tmp_path.glob("new_*.obj")} == {"new_0.obj", "new_1.obj"}
    assert main([*(str(tmp_path / "new.glb") if part.endswith("new.obj") else part for part in arguments)]) == 0
    mesh, image = surfacesynthesis.read_textured_mesh(tmp_path / "new_1.glb")
    assert mesh.GetPointData().GetTCoords() and image.GetDimensions()[:2] == (16, 16)
    assert main([*arguments, "--image", "x.png"]) == 2
    assert "--mask" in capsys.readouterr().err
    assert main([*arguments, "--trajectory"]) == 2
    assert "--samples" in capsys.readouterr().err


def test_the_command_writes_a_file_for_each_state(tmp_path, ball, models, capsys):
    autoencoder, model = models
    surfacesynthesis.write_mesh(ball, tmp_path / "ball.vtp")
    arguments = ["sample-texture", str(tmp_path / "ball.vtp"), str(tmp_path / "state.png"), "--model", model]
    arguments += ["--autoencoder", autoencoder, "--steps", "2", "--resolution", "16", "--trajectory", "--no-progress"]
    assert main(arguments) == 0, capsys.readouterr().err
    assert {path.name for path in tmp_path.glob("state*")} == {"state_0.png", "state_1.png", "state_2.png"}
