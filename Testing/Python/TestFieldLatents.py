# SPDX-License-Identifier: BSD-3-Clause
"""encode_texture() and decode_texture(): what the filters give, as Python has it."""

import numpy as np
import pytest
from latent_models import write_random_latents
from surfacesynthesis import (
    Cancelled,
    SurfaceSynthesisError,
    SurfaceSynthesisWarning,
    decode_texture,
    encode_texture,
    vtkFieldLatentEncoder,
)
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkMultiBlockDataSet, vtkPolyData
from vtkmodules.vtkFiltersSources import vtkPlaneSource
from vtkmodules.vtkFiltersCore import vtkTriangleFilter
from vtkmodules.vtkIOImage import vtkPNGReader, vtkPNGWriter

D = 2  # tangent vectors of the model


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    """A model file with random weights."""
    return write_random_latents(tmp_path_factory.mktemp("models") / "random.safetensors", D)


def plane(cells=4):
    source, triangles = vtkPlaneSource(), vtkTriangleFilter()
    source.SetResolution(cells, cells)
    triangles.SetInputConnection(source.GetOutputPort())
    triangles.Update()
    mesh = vtkPolyData()
    mesh.ShallowCopy(triangles.GetOutput())
    return mesh


def pattern():
    """An image, top row first."""
    y, x = np.mgrid[0:24, 0:32] / 24.0
    return np.stack([0.5 + 0.5 * np.sin(9 * x), 0.5 + 0.5 * np.cos(7 * y), x / x.max()], axis=-1)


def array(mesh, name):
    return vtk_to_numpy(mesh.GetPointData().GetArray(name))


def test_codes_and_texture_have_the_shapes_that_are_described(model):
    mesh = plane()
    coded = encode_texture(mesh, pattern(), model)
    assert mesh.GetPointData().GetArray("FieldLatent_0") is None, "the mesh is not modified"
    assert array(coded, "FieldLatent_0").shape == array(coded, "FieldLatent_1").shape == (25, 3)
    assert array(coded, "FieldLatentDeviation").shape == (25, 2)
    assert (array(coded, "FieldLatentRadius") > 0).all()
    decoded = decode_texture(coded, model, resolution=(40, 20))
    assert decoded.image.GetDimensions() == (40, 20, 1)
    assert array(decoded.image, "Texture").dtype == np.uint8 and array(decoded.mesh, "Texture").shape == (25, 3)
    assert decoded.mesh.GetPointData().GetScalars().GetName() == "Texture"
    other = decode_texture(coded, model, target=plane(3), resolution=32)
    assert other.mesh.GetNumberOfPoints() == 16 and other.image.GetDimensions() == (32, 32, 1)


def test_an_array_is_the_image_with_its_top_row_first(model):
    image = pattern()
    expected = array(encode_texture(plane(), image, model), "FieldLatent_0")
    bytes_ = array(encode_texture(plane(), np.round(255 * image).astype(np.uint8), model), "FieldLatent_0")
    scale = np.abs(expected).max()
    assert np.abs(bytes_ - expected).max() < 0.02 * scale, "rounding to bytes"
    assert np.abs(array(encode_texture(plane(), image[::-1], model), "FieldLatent_0") - expected).max() > 0.1 * scale
    mesh = plane()
    colors = numpy_to_vtk(np.repeat(1.0 - array(mesh, "TextureCoordinates")[:, 1:], 3, axis=1), deep=True)
    colors.SetName("Shade")
    mesh.GetPointData().AddArray(colors)
    ramp = np.linspace(0, 1, 400, endpoint=False)[:, None] + 0.5 / 400  # dark at the top
    by_image = array(encode_texture(mesh, ramp, model), "FieldLatent_0")
    assert np.abs(array(encode_texture(mesh, None, model, color="Shade"), "FieldLatent_0") - by_image).max() < 0.02 * np.abs(by_image).max()


def test_arrays_of_the_other_byte_order_are_the_same_image(model):
    image = pattern().astype("<f4")
    expected = array(encode_texture(plane(), image, model), "FieldLatent_0")
    assert np.array_equal(array(encode_texture(plane(), image.astype(">f4"), model), "FieldLatent_0"), expected)


def test_a_piece_needs_the_whole_image(model, tmp_path):
    image = np.round(255 * pattern()).astype(np.uint8)
    data = vtkImageData()
    data.SetDimensions(image.shape[1], image.shape[0], 1)
    data.GetPointData().SetScalars(numpy_to_vtk(image[::-1].reshape(-1, 3), deep=True))
    writer, reader, encoder = vtkPNGWriter(), vtkPNGReader(), vtkFieldLatentEncoder()
    writer.SetInputData(data)
    for file in (writer, reader):
        file.SetFileName(str(tmp_path / "pattern.png"))
    writer.Write()
    encoder.SetInputData(plane())
    encoder.SetInputConnection(1, reader.GetOutputPort())
    encoder.SetModelFileName(str(model))
    encoder.UpdatePiece(0, 2, 0)
    expected = array(encode_texture(plane(), image, model), "FieldLatent_0")
    assert np.array_equal(array(encoder.GetOutput(), "FieldLatent_0"), expected)


def test_codes_of_a_model_of_more_dimensions_go(model):
    mesh = plane()
    for k in range(D + 2):
        old = numpy_to_vtk(np.ones((25, 3), dtype=np.float32), deep=True)
        old.SetName(f"FieldLatent_{k}")
        mesh.GetPointData().AddArray(old)
    coded = encode_texture(mesh, pattern(), model)
    assert coded.GetPointData().GetArray(f"FieldLatent_{D}") is None
    assert decode_texture(coded, model, resolution=32).image.GetDimensions() == (32, 32, 1)


def test_blocks_and_names(model):
    blocks = vtkMultiBlockDataSet()
    blocks.SetBlock(0, plane())
    coded = encode_texture(blocks, pattern(), model, latent_name="Code", samples_per_ring=20, texture_wrap="clamp")
    assert array(coded.GetBlock(0), "Code_1").shape == (25, 3)
    decoded = decode_texture(coded, model, resolution=16, latent_name="Code", name="Paint", gutter_width=-1)
    assert array(decoded.image.GetBlock(0), "Paint").shape == (256, 3)


def test_errors_and_warnings(model):
    bare = plane()
    bare.GetPointData().SetTCoords(None)
    with pytest.raises(SurfaceSynthesisError, match="vtkTextureAtlasFilter"):
        encode_texture(bare, pattern(), model)
    with pytest.raises(SurfaceSynthesisError, match="FieldLatent_0"):
        decode_texture(plane(), model)
    with pytest.warns(SurfaceSynthesisWarning, match="clamped"):
        encode_texture(plane(), 255.0 * pattern(), model)
    with pytest.raises(Cancelled):
        encode_texture(plane(), pattern(), model, progress=lambda fraction: False)
    for arguments in ({"texture_wrap": "mirror"}, {"samples_per_ring": 5000}, {"image": np.zeros((2, 2, 2, 2))}):
        with pytest.raises(ValueError):
            encode_texture(plane(), **{"image": pattern(), "model": model, **arguments})
    for arguments in ({"resolution": 8}, {"resolution": (16, 16, 16)}, {"gutter_width": -2}, {"memory_limit": 0}):
        with pytest.raises(ValueError):
            decode_texture(plane(), model, **arguments)
    for mesh in ((np.zeros((3, 3)), np.array([[0, 1, 2]])), vtkFieldLatentEncoder()):
        with pytest.raises(TypeError):
            encode_texture(mesh, pattern(), model)
    with pytest.raises(TypeError):
        decode_texture(plane(), model, target=vtkMultiBlockDataSet())
