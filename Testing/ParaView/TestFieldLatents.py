# SPDX-License-Identifier: BSD-3-Clause
"""Field latents and atlases through their proxies, in pvpython: what the classes give, from an atlas to a texture."""

import os

import numpy as np
import surfaces
from latent_models import write_random_latents
from paraview.simple import *  # noqa: F403: as scripts of ParaView do
from proxies import TRAINING_PROPERTIES, check_properties, made_by, output_of, source_of
from surfacesynthesis import vtkFieldLatentDecoder, vtkFieldLatentEncoder
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData

LoadPlugin(surfaces.plugin(), remote=False, ns=globals())

# property: (default, another value, what GetX() of the VTK class then returns)
ENCODER = {
    "ModelFileName": (None, "net.safetensors", "net.safetensors"),
    "ColorArrayName": ("", "Paint", "Paint"),
    "TextureWrap": ("Automatic", "Clamp", vtkFieldLatentEncoder.CLAMP),
    "SamplesPerRing": (0, 20, 20),
    "LatentArrayName": ("FieldLatent", "Code", "Code"),
}
DECODER = {
    "ModelFileName": (None, "net.safetensors", "net.safetensors"),
    "Resolution": ([1024, 1024], [64, 32], (64, 32)),
    "GutterWidth": (8, -1, -1),
    "LatentArrayName": ("FieldLatent", "Code", "Code"),
    "TextureArrayName": ("Texture", "Paint", "Paint"),
    "MemoryLimit": (0, 100, 100),
}
ATLAS = {"Resolution": ([1024, 1024], [64, 32], (64, 32)), "Margin": (4, 2, 2), "MaximumStretch": (2.0, 1.5, 1.5)}
TRAINER = {
    **TRAINING_PROPERTIES,
    "LearningRate": (1e-3, 2e-3, 2e-3),
    "NumberOfMeshes": (64, 2, 2),
    "MeshPoints": (2500, 50, 50),
    "Iterations": (100000, 3, 3),
    "BatchSize": (48, 6, 6),
    "Sizes": ("Small", "Paper", 1),
    "LatentDimension": (0, 2, 2),
    "Channels": (0, 4, 4),
    "EncoderLayers": (0, 1, 1),
    "Heads": (0, 2, 2),
    "SamplesPerRing": (0, 8, 8),
    "DecoderLayers": (0, 2, 2),
    "DecoderWidth": (0, 8, 8),
    "Coordinates": ("Logarithmic", "Barycentric", 1),
    "FinalLearningRate": (1e-5, 1e-4, 1e-4),
    "DivergenceWeight": (0.01, 0.1, 0.1),
    "MinimumTexels": (10.0, 5.0, 5.0),
    "MaximumTexels": (150.0, 50.0, 50.0),
    "GradientClip": (1.0, 0.0, 0.0),
}
WITH_ATLAS = os.environ.get("SURFACE_SYNTHESIS_CGAL") != "0"
WITH_TRAINER = os.environ.get("SURFACE_SYNTHESIS_LEARNING") != "0"
if WITH_TRAINER:
    from surfacesynthesis import vtkFieldLatentTrainer  # noqa: F401: so that Python knows the class behind the proxy


def textured_ball():
    """A ball with texture coordinates by position, in two halves of the image that share few texels."""
    ball = surfaces.ball(size=6)
    points = vtk_to_numpy(ball.GetPoints().GetData())
    coordinates = np.column_stack([np.where(points[:, 2] > 0, 0.75, 0.25) + 0.2 * points[:, 0], 0.5 + 0.45 * points[:, 1]])
    array = numpy_to_vtk(coordinates, deep=True)
    array.SetName("TCoords")
    ball.GetPointData().SetTCoords(array)
    return ball


def pattern():
    y, x = np.mgrid[0:32, 0:48]
    values = np.stack([5 * x, 7 * y, 255 * ((x // 6 + y // 6) % 2)], axis=-1).astype(np.uint8)
    image = vtkImageData()
    image.SetDimensions(48, 32, 1)
    image.GetPointData().SetScalars(numpy_to_vtk(values.reshape(-1, 3), deep=True))
    image.GetPointData().GetScalars().SetName("Pattern")
    return image


def coded_ball(path):
    """The ball with latents, by the class."""
    encoder = vtkFieldLatentEncoder()
    encoder.SetInputDataObject(1, pattern())
    return made_by(encoder, textured_ball(), ModelFileName=path)


def properties_have_the_defaults_of_the_classes_and_reach_them():
    ball, image = source_of(textured_ball()), source_of(pattern())
    made = [(FieldLatentEncoder(Input=ball), ENCODER), (FieldLatentDecoder(Input=ball), DECODER)]
    if WITH_ATLAS:
        made.append((TextureAtlas(Input=ball), ATLAS))
    if WITH_TRAINER:
        made.append((FieldLatentTrainer(Input=image), TRAINER))
    for proxy, properties in made:
        check_properties(proxy, properties)
        Delete(proxy)


def latents_are_those_of_the_class():
    path = write_random_latents("encoded.safetensors")
    made = FieldLatentEncoder(Input=source_of(textured_ball()), TextureImage=source_of(pattern()), ModelFileName=path)
    found, expected = output_of(made), coded_ball(path)
    for name in ("FieldLatent_0", "FieldLatent_1", "FieldLatentDeviation", "FieldLatentRadius"):
        surfaces.assert_same(surfaces.array(found, name), surfaces.array(expected, name), name)
    made.UpdatePropertyInformation()
    assert made.GetProperty("NumberOfModelLoads").GetData() == 1
    assert made.GetProperty("NumberOfRingComputations").GetData() == 1


def textures_are_those_of_the_class():
    path = write_random_latents("decoded.safetensors")
    coded, target = coded_ball(path), textured_ball()
    for onto in (None, target):
        algorithm = vtkFieldLatentDecoder()
        options = {"ModelFileName": path, "Resolution": [64, 32]}
        proxy = FieldLatentDecoder(Input=source_of(coded), **options)
        if onto is not None:
            proxy.Target = source_of(onto)
            algorithm.SetInputDataObject(1, onto)
        expected = made_by(algorithm, coded, **options)
        surfaces.assert_same(surfaces.array(output_of(proxy), "Texture"), surfaces.array(expected, "Texture"), "colors")
        image = proxy.GetClientSideObject().GetOutputDataObject(1)
        assert image.GetDimensions() == (64, 32, 1)
        texels, by_class = (one.GetPointData().GetScalars() for one in (image, algorithm.GetOutputDataObject(1)))
        surfaces.assert_same(vtk_to_numpy(texels), vtk_to_numpy(by_class), "texels")


def an_atlas_serves_the_encoder():
    path = write_random_latents("atlas.safetensors")
    atlas = TextureAtlas(Input=source_of(surfaces.ball(size=6)), Resolution=[64, 64])
    atlas.UpdatePipeline()
    atlas.UpdatePropertyInformation()
    assert atlas.GetProperty("NumberOfCharts").GetData() > 0 and 0 < atlas.GetProperty("Coverage").GetData() < 1
    encoder = FieldLatentEncoder(Input=atlas, TextureImage=source_of(pattern()), ModelFileName=path)
    decoder = FieldLatentDecoder(Input=encoder, ModelFileName=path, Resolution=[64, 64])
    found = output_of(decoder)
    assert found.GetNumberOfPoints() == output_of(atlas).GetNumberOfPoints()
    assert np.ptp(surfaces.array(found, "Texture").astype(int), axis=0).max() > 5


def a_trained_model_encodes():
    sizes = {name: TRAINER[name][1] for name in ("NumberOfMeshes", "MeshPoints", "Iterations", "BatchSize", "LatentDimension",
             "Channels", "EncoderLayers", "Heads", "SamplesPerRing", "DecoderLayers", "DecoderWidth")}  # fmt: skip
    trainer = FieldLatentTrainer(Input=source_of(pattern()), ModelFileName="learnt.safetensors", Device="CPU", **sizes)
    table = output_of(trainer)
    assert table.GetNumberOfRows() == 3
    made = FieldLatentEncoder(Input=source_of(textured_ball()), TextureImage=source_of(pattern()))
    made.ModelFileName = "learnt.safetensors"
    assert surfaces.array(output_of(made), "FieldLatent_1").any()


TESTS = [
    properties_have_the_defaults_of_the_classes_and_reach_them,
    latents_are_those_of_the_class,
    textures_are_those_of_the_class,
]
if WITH_ATLAS:
    TESTS.append(an_atlas_serves_the_encoder)
if WITH_TRAINER:
    TESTS.append(a_trained_model_encodes)
surfaces.run(*TESTS)
