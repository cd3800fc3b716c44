# SPDX-License-Identifier: BSD-3-Clause
"""Words of functions and commands for the properties of the VTK classes."""

import re

#: Short words for long properties, and for properties of one meaning that VTK names in several ways. With the reason.
SYNONYMS = {
    "array": ({"ArrayName", "InputArrayToProcess"}, "the array that the filter reads"),
    "averaging": ({"WeightAveraging"}, "only weights are averaged"),
    "batch": ({"BatchSize"}, "the usual word of trainings"),
    "clip": ({"GradientClip"}, "only gradients are clipped"),
    "edge_length": ({"TargetEdgeLength"}, "what a function is given is wanted"),
    "features": ({"KeepFeatureEdges"}, "--no-features; in Python feature_angle=None"),
    "gaussian_width": ({"Width"}, "width is that of a network"),
    "hole_size": ({"MaximumHoleSize"}, "goes with holes"),
    "holes": ({"HoleFilling"}, "the holes that are filled"),
    "inside": ({"InsideRule"}, "inside='below' reads as it is meant"),
    "iterations": ({"NumberOfIterations", "Iterations", "IterationsPerLevel"}, "those of the method, of each level if any"),
    "largest_component": ({"LargestComponent", "KeepLargestComponent"}, "the only component that stays"),
    "layers": ({"Layers", "ComplexLayers"}, "those of the network that is trained"),
    "losses": ({"LossTableFileName"}, "the file of a table of losses"),
    "minimum_component": ({"MinimumComponentFraction"}, "smaller ones go"),
    "name": ({"OutputArrayName", "PredictionArrayName", "SignalArrayName", "TextureArrayName"}, "the array of the result"),
    "normalization": ({"InputNormalization"}, "only the input is normalised"),
    "plain_example": ({"PlainExampleData"}, "the example without its texture"),
    "points": ({"TargetNumberOfPoints", "NumberOfPoints"}, "what a function is given is wanted"),
    "prepare": ({"TargetPreparation"}, "prepare='remesh' reads as it is meant"),
    "random_from": ({"RandomFromLevel"}, "counted in levels, as start_level is"),
    "range": ({"CorrelationRange"}, "the only range of noise"),
    "references": ({"ReferenceFileName"}, "as surfaces or as files"),
    "scale": ({"TextureScale"}, "the only scale of a texture"),
    "schedule": ({"LearningRateSchedule"}, "only the learning rate has one"),
    "second_example": ({"SecondExampleData"}, "a second example, for a blend"),
    "second_plain_example": ({"SecondPlainExampleData"}, "the second example without its texture"),
    "self_intersections": ({"RemoveSelfIntersections"}, "a repair removes them"),
    "surface_samples": ({"Samples"}, "samples are those of an ensemble"),
    "template": ({"Template", "TemplateData"}, "the mesh that stands for a shape"),
    "tetrahedra": ({"TetrahedraData"}, "the tetrahedra that are simulated in place of a surface"),
    "trajectory": ({"OutputTrajectory"}, "the states in place of the last one"),
}


def snake(name):
    name = re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", name)
    return name.lower()


def words_of(name):
    """The words that follow from a property: NumberOfSamples gives samples, ModelFileName model, LabelArrayName label_name
    (an output) or label (an input)."""
    words = {snake(name), snake(name.replace("NumberOf", ""))}
    if name.endswith("ArrayName"):
        words |= {snake(name[:-9]), snake(name[:-9] + "Name"), snake(name[:-4])}
    if name.endswith("FileName"):
        words.add(snake(name[:-8]))
    return words
