# SPDX-License-Identifier: BSD-3-Clause
"""Geometric textures through their proxies, in pvpython: what the classes give, from a fit to a texture."""

import numpy as np
import surfaces
from paraview import servermanager
from paraview.simple import *  # noqa: F403: as scripts of ParaView do
from proxies import TRAINING_PROPERTIES, check_properties, made_by, output_of, source_of
from surfacesynthesis import (
    vtkGeometricTextureDistance,
    vtkGeometricTextureFeatures,
    vtkGeometricTextureFromExample,
    vtkGeometricTextureSynthesizer,
    vtkGeometricTextureTrainer,
    vtkMultiscaleMeshFitter,
)
from texture_models import model
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy

LoadPlugin(surfaces.plugin(), remote=False, ns=globals())

# property: (default, another value, what GetX() of the VTK class then returns)
SYNTHESIZER = {
    "ModelFileName": ("flow_knobs", "net.safetensors", "net.safetensors"),
    "StartLevel": (-1, 1, 1),
    "EndLevel": (-1, 2, 2),
    "Seed": (0, 7, 7),
    "SecondSeed": (1, 8, 8),
    "Interpolation": (0.0, 0.5, 0.5),
    "NoiseAmplitude": (-1.0, 0.2, 0.2),
    "NumberOfRestarts": (-1, 1, 1),
    "NormStatistics": ("Target", "Reference", vtkGeometricTextureSynthesizer.REFERENCE),
    "LevelsWithoutNoise": ("", "0 2", "0 2"),
    "TargetPreparation": ("Remesh", "Subdivide", vtkGeometricTextureSynthesizer.SUBDIVIDE),
    "TextureScale": (0.0, 0.5, 0.5),
    "MaskArrayName": ("", "Mask", "Mask"),
    "MaskFalloff": (0.0, 0.3, 0.3),
    "SizeArrayName": ("", "Mask", "Mask"),
    "SecondModelFileName": ("", "second.safetensors", "second.safetensors"),
    "BlendArrayName": ("", "Mask", "Mask"),
    "Strength": (1.0, 1.5, 1.5),
    "StrengthArrayName": ("", "Mask", "Mask"),
    "Printable": (0, 1, True),
    "RandomFromLevel": (0, 1, 1),
    "OutputLevels": (0, 1, True),
    "Animation": ("No Animation", "Seeds", vtkGeometricTextureSynthesizer.SEEDS),
    "DisplacementArrayName": ("Displacement", "Way", "Way"),
    "LevelArrayName": ("Level", "Born", "Born"),
}
FROM_EXAMPLE = {
    "ExampleFileName": ("cortex", "example.safetensors", "example.safetensors"),
    "SecondExampleFileName": ("", "second.safetensors", "second.safetensors"),
    "Seed": (0, 7, 7),
    "TextureScale": (0.0, 0.5, 0.5),
    "Subdivisions": (-1, 1, 1),
    "NumberOfScales": (0, 2, 2),
    "SmoothingLength": (0.0, 0.3, 0.3),
    "SecondSmoothingLength": (0.0, 0.4, 0.4),
    "BlendArrayName": ("", "Mask", "Mask"),
    "OrientationArrayName": ("", "Grain", "Grain"),
    "ExampleOrientationArrayName": ("", "Grain", "Grain"),
    "SizeArrayName": ("", "Mask", "Mask"),
    "MaskArrayName": ("", "Mask", "Mask"),
    "Strength": (1.0, 1.5, 1.5),
    "Printable": (0, 1, True),
    "DisplacementArrayName": ("Displacement", "Way", "Way"),
}
DISTANCE = {
    "UnitLength": (0.0, 0.5, 0.5),
    "ReferenceUnitLength": (0.0, 0.25, 0.25),
    "NumberOfProjections": (128, 16, 16),
    "NumberOfRings": (1, 3, 3),
    "Seed": (0, 7, 7),
}
FEATURES = {
    "UnitLength": (0.0, 0.5, 0.5),
    "MinimumProminence": (0.0, 0.25, 0.25),
    "MergedSaddle": (0.5, 0.75, 0.75),
    "WallLevel": (0.0, 0.5, 0.5),
    "SmoothingLength": (0.0, 2.0, 2.0),
}
FITTER = {
    "NumberOfLevels": (5, 2, 2),
    "Template": ("Icosphere", "Given", vtkMultiscaleMeshFitter.GIVEN),
    "IcosphereLevel": (2, 1, 1),
    "TorusSegments": (24, 9, 9),
    "TemplateTriangles": (320, 80, 80),
    "SmoothingLength": (0.0, 0.5, 0.5),
    "Iterations": (300, 10, 10),
    "TriangulationSteps": (3, 1, 1),
    "ChamferSteps": (2, 1, 1),
    "LearningRate": (1e-2, 2e-2, 2e-2),
    "LearningRateDecay": (0.1, 0.5, 0.5),
    "Samples": (3000, 100, 100),
    "PublishedNormals": (0, 1, True),
    "Seed": (0, 7, 7),
    "DatasetFileName": ("", "data.safetensors", "data.safetensors"),
    "TimeBudget": (2.0, 5.0, 5.0),
}
TRAINER = {
    **TRAINING_PROPERTIES,
    "TextureName": ("texture", "bark", "bark"),
    "IterationsPerLevel": (2000, 2, 2),
    "Objective": ("Flow Matching", "Adversarial", vtkGeometricTextureTrainer.ADVERSARIAL),
    "FlowSteps": (10, 3, 3),
    "BaseNoiseAmplitude": (0.1, 0.2, 0.2),
    "NumberOfBaseSamples": (8, 2, 2),
    "NumberOfProjections": (64, 7, 7),
    "PenaltyInterval": (1, 4, 4),
    "DiscriminatorSteps": (2, 1, 1),
    "GeneratorSteps": (3, 1, 1),
    "LearningRateInterval": (500, 5, 5),
    "LearningRateFactor": (0.5, 0.25, 0.25),
    "PenaltyWeight": (0.1, 0.0, 0.0),
    "ReconstructionWeight": (5.0, 1.0, 1.0),
    "Layers": (7, 4, 4),
    "StartChannels": (32, 8, 8),
    "MinimumChannels": (32, 4, 4),
    "MaximumChannels": (128, 8, 8),
    "NoiseAmplitude": (0.1, 0.2, 0.2),
    "Device": ("Auto", "CUDA", vtkGeometricTextureTrainer.CUDA),
}
#: The defaults of the class where those of ParaView differ.
OF_THE_CLASS = {"StartLevel": 0, "TargetPreparation": "As Is"}
FIT = {"NumberOfLevels": 2, "IcosphereLevel": 1, "Iterations": 3, "Samples": 100}
TRAINING = {"IterationsPerLevel": 2, "Layers": 3, "StartChannels": 4, "MinimumChannels": 4, "MaximumChannels": 4}


def points_of(mesh):
    return vtk_to_numpy(mesh.GetPoints().GetData()).copy()


def masked_ball(size=24):
    ball = surfaces.ball(size)
    mask = numpy_to_vtk((points_of(ball)[:, 2] > points_of(ball)[:, 2].mean()).astype(float), deep=True)
    mask.SetName("Mask")
    ball.GetPointData().AddArray(mask)
    grain = numpy_to_vtk(np.tile([0.0, 0.0, 1.0], (ball.GetNumberOfPoints(), 1)), deep=True)
    grain.SetName("Grain")
    ball.GetPointData().AddArray(grain)
    return ball


def properties_have_the_defaults_of_the_classes_and_reach_them():
    ball = source_of(masked_ball())
    for made, properties in (
        (GeometricTextureSynthesizer(Input=ball), SYNTHESIZER),
        (GeometricTextureFromExample(Input=ball, Example=ball), FROM_EXAMPLE),
        (GeometricTextureDistance(Input=ball, Reference=ball), DISTANCE),
        (GeometricTextureFeatures(Input=ball), FEATURES),
        (MultiscaleMeshFitter(Input=ball), FITTER),
        (GeometricTextureTrainer(Input=ball), TRAINER),
    ):
        check_properties(made, properties)
        Delete(made)


def textures_are_those_of_the_class():
    path = model("texture.safetensors")
    options = dict(ModelFileName=path, Seed=3, MaskArrayName="Mask", MaskFalloff=0.2)
    found = output_of(GeometricTextureSynthesizer(Input=source_of(masked_ball()), **OF_THE_CLASS, **options))
    expected = made_by(vtkGeometricTextureSynthesizer(), masked_ball(), **options)
    assert np.array_equal(points_of(found), points_of(expected))
    displacement = vtk_to_numpy(found.GetPointData().GetArray("Displacement"))
    assert np.abs(displacement).max() > 1e-3
    assert np.all(displacement[vtk_to_numpy(found.GetPointData().GetArray("Mask")) == 0] == 0)


def textures_from_an_example_are_those_of_the_class():
    plain, example = surfaces.ball(size=8), surfaces.ball(size=8)  # the larger, the longer each takes to cut
    target = masked_ball(size=8)
    points = points_of(plain)
    heights = 0.03 * np.prod(np.sin(9.0 * points), axis=1)
    example.GetPoints().SetData(numpy_to_vtk(points * (1.0 + heights)[:, None], deep=True))
    options = dict(Seed=3, Subdivisions=1, NumberOfScales=1, MaskArrayName="Mask")
    for smooth in (None, plain):
        inputs = dict(Input=source_of(target), Example=source_of(example))
        if smooth is not None:
            inputs["PlainExample"] = source_of(smooth)
        made = GeometricTextureFromExample(**inputs, **options)
        found = output_of(made)
        algorithm = vtkGeometricTextureFromExample()
        algorithm.SetExampleData(example)
        if smooth is not None:
            algorithm.SetPlainExampleData(smooth)
        expected = made_by(algorithm, target, **options)
        assert np.array_equal(points_of(found), points_of(expected))
        displacement = vtk_to_numpy(found.GetPointData().GetArray("Displacement"))
        assert np.abs(displacement).max() > 1e-4
        assert np.all(displacement[vtk_to_numpy(found.GetPointData().GetArray("Mask")) == 0] == 0)
        made.UpdatePropertyInformation()
        assert made.GetProperty("TextureScaleUsed").GetData() == algorithm.GetTextureScaleUsed() > 0.0
        assert made.GetProperty("SubdivisionsUsed").GetData() == made.GetProperty("NumberOfScalesUsed").GetData() == 1
        assert made.GetProperty("Mismatch").GetData() == algorithm.GetMismatch() > 0.0
        Delete(made)
    options["BlendArrayName"] = options.pop("MaskArrayName")
    blend = GeometricTextureFromExample(Input=source_of(target), Example=source_of(example),
                                        SecondExample=source_of(plain), **options)  # fmt: skip
    algorithm = vtkGeometricTextureFromExample()
    algorithm.SetExampleData(example)
    algorithm.SetSecondExampleData(plain)
    assert np.array_equal(points_of(output_of(blend)), points_of(made_by(algorithm, target, **options)))
    Delete(blend)


def levels_are_blocks():
    path = model("levels.safetensors")
    ball = source_of(surfaces.ball())
    made = GeometricTextureSynthesizer(Input=ball, ModelFileName=path, OutputLevels=1, **OF_THE_CLASS)
    found = output_of(made)
    assert found.GetNumberOfBlocks() == 2
    expected = made_by(vtkGeometricTextureSynthesizer(), surfaces.ball(), ModelFileName=path)
    assert np.array_equal(points_of(found.GetBlock(1)), points_of(expected))


def the_animation_goes_through_the_levels_without_synthesizing_them_again():
    made = GeometricTextureSynthesizer(Input=source_of(surfaces.ball()), ModelFileName=model("animated.safetensors"),
                                       Animation="Levels", **OF_THE_CLASS)  # fmt: skip
    made.UpdatePipeline()
    assert list(made.TimestepValues) == [0.0, 1.0, 2.0]
    GetAnimationScene().UpdateAnimationUsingDataTimeSteps()
    sizes, seen = [], []
    for time in (0.0, 1.0, 1.5, 2.0):
        made.UpdatePipeline(time)
        seen.append(points_of(servermanager.Fetch(made)))
        sizes.append(len(seen[-1]))
    assert sizes[0] == sizes[1] < sizes[2] == sizes[3]
    assert np.abs(seen[0] - seen[1]).max() > 1e-4 and np.abs(seen[2] - seen[3]).max() > 1e-4
    made.UpdatePropertyInformation()
    assert made.GetProperty("NumberOfSyntheses").GetData() == 1
    assert made.GetProperty("NumberOfModelLoads").GetData() == 1
    Delete(made)


def distances_are_those_of_the_class():
    surface, reference = surfaces.ball(), surfaces.ball(size=5)
    made = GeometricTextureDistance(Input=source_of(surface), Reference=source_of(reference), Seed=2)
    table = output_of(made)
    algorithm = vtkGeometricTextureDistance()
    algorithm.SetInputDataObject(1, reference)
    expected = made_by(algorithm, surface, Seed=2)
    assert table.GetNumberOfRows() == 1 and table.GetNumberOfColumns() == expected.GetNumberOfColumns() == 6
    for column in range(6):
        assert table.GetValue(0, column) == expected.GetValue(0, column), column
    made.UpdatePropertyInformation()
    assert made.GetProperty("Distance").GetData() == algorithm.GetDistance() > 0.0
    assert made.GetProperty("StandardError").GetData() == algorithm.GetStandardError() > 0.0


def features_are_those_of_the_class():
    bare, surface = surfaces.ball(), surfaces.ball()
    points = points_of(surface)
    heights = 0.1 * np.sin(7.0 * points[:, 0]) * np.sin(7.0 * points[:, 1]) + 0.05 * points[:, 2]
    surface.GetPoints().SetData(numpy_to_vtk(points * (1.0 + heights)[:, None], deep=True))
    made = GeometricTextureFeatures(Input=source_of(surface), Bare=source_of(bare), WallLevel=0.4)
    found = output_of(made)
    algorithm = vtkGeometricTextureFeatures()
    algorithm.SetInputDataObject(1, bare)
    expected = made_by(algorithm, surface, WallLevel=0.4)
    for name in ("Height", "Prominence", "Peak", "Region"):
        values = [vtk_to_numpy(one.GetPointData().GetArray(name)) for one in (found, expected)]
        assert np.array_equal(*values) and values[0].any(), name
    made.UpdatePropertyInformation()
    assert made.GetProperty("NumberOfPeaks").GetData() == algorithm.GetNumberOfPeaks() > 0
    assert made.GetProperty("WallLength").GetData() == algorithm.GetWallLength() > 0.0
    Delete(made)


def a_fit_is_learned_from_and_synthesizes_without_input():
    fitter = MultiscaleMeshFitter(Input=source_of(surfaces.ball()), **FIT)
    fitter.UpdatePipeline()
    levels = servermanager.Fetch(fitter)
    assert levels.GetNumberOfBlocks() == 2 and levels.GetBlock(1).GetNumberOfPolys() == 320
    template = fitter.GetClientSideObject().GetOutputDataObject(1)
    assert template.GetNumberOfPolys() == 80
    trainer = GeometricTextureTrainer(Input=fitter, TemplateMesh=OutputPort(fitter, 1),
                                      ModelFileName="learnt.safetensors", Device="CPU", **TRAINING)  # fmt: skip
    table = output_of(trainer)
    assert table.GetNumberOfRows() == 4 and table.GetNumberOfColumns() == 7
    trainer.UpdatePropertyInformation()
    assert trainer.GetProperty("NumberOfIterationsDone").GetData() == 4
    assert trainer.GetProperty("DeviceInUse").GetData() == "CPU"
    SetActiveSource(None)
    sample = output_of(GeometricTextureSynthesizer(ModelFileName="learnt.safetensors"))
    assert sample.GetNumberOfPolys() == 320
    alone = vtkGeometricTextureSynthesizer()
    alone.SetModelFileName("learnt.safetensors")
    alone.Update()
    assert np.array_equal(points_of(sample), points_of(alone.GetOutputDataObject(0)))


surfaces.run(
    properties_have_the_defaults_of_the_classes_and_reach_them,
    textures_are_those_of_the_class,
    textures_from_an_example_are_those_of_the_class,
    levels_are_blocks,
    the_animation_goes_through_the_levels_without_synthesizing_them_again,
    distances_are_those_of_the_class,
    features_are_those_of_the_class,
    a_fit_is_learned_from_and_synthesizes_without_input,
)
