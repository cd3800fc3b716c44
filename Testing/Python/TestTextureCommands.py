# SPDX-License-Identifier: BSD-3-Clause
"""The commands encode-texture, decode-texture and transfer-texture."""

import numpy as np
import pytest
import surfacesynthesis
from conftest import add_array, files_in, icosphere, polydata_of
from latent_models import write_random_latents
from surfacesynthesis import read_mesh, read_textured_mesh, texture_atlas, write_mesh, write_textured_mesh
from surfacesynthesis.command_line import main
from surfacesynthesis.files.images import read_image
from surfacesynthesis.textured_files import write_image
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData

pytestmark = pytest.mark.skipif(not hasattr(surfacesynthesis, "vtkTextureAtlasFilter"), reason="built without CGAL")


def pattern():
    """An image of 32 x 24 texels."""
    y, x = np.mgrid[0:24, 0:32]
    values = np.stack([8 * x, 10 * y, 255 * ((x // 4 + y // 4) % 2)], axis=-1).astype(np.uint8)
    image = vtkImageData()
    image.SetDimensions(32, 24, 1)
    image.GetPointData().SetScalars(numpy_to_vtk(np.ascontiguousarray(values.reshape(-1, 3)), deep=True))
    return image


def texels_of(image):
    return vtk_to_numpy(image.GetPointData().GetScalars())


def write_textured_ball(path, levels=1):
    """Writes a ball with an atlas and a texture."""
    write_textured_mesh(texture_atlas(polydata_of(*icosphere(levels)), resolution=64), pattern(), path)


@pytest.fixture
def folder(tmp_path):
    """A textured ball, a finer one without texture coordinates, and a model."""
    write_textured_ball(tmp_path / "ball.obj")
    write_mesh(polydata_of(*icosphere(2)), tmp_path / "fine.off")
    write_random_latents(tmp_path / "latents.safetensors")
    return tmp_path


def command(folder, name, *words):
    """Runs a command on files of the folder; words with a dot are file names."""
    return main([name, *(str(folder / word) if "." in word else word for word in words), "--model",
                 str(folder / "latents.safetensors")])  # fmt: skip


def test_encoding_and_decoding_give_what_the_functions_give(folder):
    model = folder / "latents.safetensors"
    assert command(folder, "encode-texture", "ball.obj", "codes.vtp") == 0
    coded = surfacesynthesis.encode_texture(*read_textured_mesh(folder / "ball.obj"), model=model)
    codes = read_mesh(folder / "codes.vtp")
    for name in ("FieldLatent_0", "FieldLatent_1", "FieldLatentDeviation", "FieldLatentRadius"):
        found, expected = (vtk_to_numpy(mesh.GetPointData().GetArray(name)) for mesh in (codes, coded))
        assert np.array_equal(found, expected), name
    expected = surfacesynthesis.decode_texture(coded, model, resolution=(48, 32))
    for name in ("out.obj", "out.glb", "out.ply"):
        assert command(folder, "decode-texture", "codes.vtp", name, "--resolution", "48", "32") == 0
        mesh, image = read_textured_mesh(folder / name)
        assert image.GetDimensions() == (48, 32, 1)
        assert np.array_equal(texels_of(image), texels_of(expected.image)), name
        assert mesh.GetNumberOfCells() == coded.GetNumberOfCells()
    assert command(folder, "decode-texture", "codes.vtp", "only.png", "--resolution", "48", "32") == 0
    assert np.array_equal(texels_of(read_image(folder / "only.png")), texels_of(expected.image))
    assert command(folder, "decode-texture", "codes.vtp", "colors.vtp", "--resolution", "48", "32") == 0
    colors = read_mesh(folder / "colors.vtp").GetPointData().GetArray("Texture")
    assert np.array_equal(vtk_to_numpy(colors), vtk_to_numpy(expected.mesh.GetPointData().GetArray("Texture")))


def test_transfer_is_encoding_atlas_and_decoding(folder):
    assert command(folder, "transfer-texture", "ball.obj", "fine.off", "fine.obj", "--resolution", "64") == 0
    mesh, image = read_textured_mesh(folder / "fine.obj")
    assert mesh.GetNumberOfCells() == 320 and image.GetDimensions() == (64, 64, 1)
    model = folder / "latents.safetensors"
    coded = surfacesynthesis.encode_texture(*read_textured_mesh(folder / "ball.obj"), model=model)
    target = texture_atlas(polydata_of(*icosphere(2)), resolution=64)
    expected = surfacesynthesis.decode_texture(coded, model, target=target, resolution=64)
    assert np.array_equal(texels_of(image), texels_of(expected.image))
    assert len(np.unique(texels_of(image), axis=0)) > 50
    assert command(folder, "decode-texture", "fine.obj", "no.obj") == 1, "a surface without codes"


def test_a_target_with_texture_coordinates_keeps_them(folder):
    write_textured_ball(folder / "other.glb", 2)
    assert command(folder, "transfer-texture", "ball.obj", "other.glb", "laid.glb", "--resolution", "64") == 0
    found, expected = (read_textured_mesh(folder / name)[0].GetPointData().GetTCoords() for name in ("laid.glb", "other.glb"))
    assert np.allclose(vtk_to_numpy(found), vtk_to_numpy(expected), rtol=0, atol=1e-7)


def test_an_image_may_take_the_place_of_the_texture(folder):
    image = pattern()
    texels_of(image)[:] = 255 - texels_of(image)
    write_image(image, folder / "negative.png")
    assert command(folder, "encode-texture", "ball.obj", "negative.vtp", "--image", "negative.png") == 0
    mesh, _ = read_textured_mesh(folder / "ball.obj")
    coded = surfacesynthesis.encode_texture(mesh, image, model=folder / "latents.safetensors")
    found, expected = (
        vtk_to_numpy(one.GetPointData().GetArray("FieldLatent_0")) for one in (read_mesh(folder / "negative.vtp"), coded)
    )
    assert np.array_equal(found, expected)


def test_colors_of_points_are_encoded_without_a_texture(folder):
    mesh = polydata_of(*icosphere(1))
    add_array(mesh.GetPointData(), "RGB", (np.arange(126).reshape(42, 3) * 2).astype(np.uint8))
    write_mesh(mesh, folder / "colors.ply")
    assert command(folder, "encode-texture", "colors.ply", "colors.vtp") == 0
    coded = surfacesynthesis.encode_texture(mesh, model=folder / "latents.safetensors", color="RGB")
    found, expected = (
        vtk_to_numpy(one.GetPointData().GetArray("FieldLatent_0")) for one in (read_mesh(folder / "colors.vtp"), coded)
    )
    assert np.array_equal(found, expected)


@pytest.mark.parametrize(
    "name, words, status, text",
    [
        ("encode-texture", ["ball.obj", "codes.obj"], 2, "field latents are written to .vtp or .vtk"),
        ("encode-texture", ["ball.obj", "codes.vtp", "--image", "none.png"], 1, "none.png"),
        ("encode-texture", ["fine.off", "codes.vtp"], 1, "no texture and no colors; --image names"),
        ("encode-texture", ["none.obj", "codes.vtp"], 1, "none.obj"),
        ("decode-texture", ["ball.obj", "out.stl"], 2, "a decoded texture is written to one of"),
        ("decode-texture", ["ball.obj", "out.obj"], 1, "FieldLatent"),
        ("decode-texture", ["ball.obj", "out.obj", "--resolution", "1"], 2, "resolution must be from 16"),
        ("transfer-texture", ["ball.obj", "fine.off", "out.obj", "--resolution", "1", "2", "3"], 2, "one number"),
    ],
)
def test_errors_leave_nothing(name, words, status, text, folder, capsys):
    before = files_in(folder)
    assert command(folder, name, *words) == status
    assert text in capsys.readouterr().err
    assert files_in(folder) == before
