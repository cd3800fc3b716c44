# SPDX-License-Identifier: BSD-3-Clause
"""Messages of the filters in the words of the command line: commands in place of classes, options in place of properties."""

import re

#: The command that runs a class.
COMMANDS_OF_CLASSES = {
    "vtkEnsembleMetrics": "metrics",
    "vtkFlowMatchingDeformer": "deform",
    "vtkFlowMatchingTrainer": "train flow-matching",
    "vtkGaussianMixtureFilter": "dataset mixtures",
    "vtkGeometricTextureDistance": "geometric-texture-distance",
    "vtkGeometricTextureSynthesizer": "geometric-texture",
    "vtkGeometricTextureTrainer": "train geometric-texture",
    "vtkIsotropicRemeshFilter": "remesh",
    "vtkMaternNoiseFilter": "noise",
    "vtkMultiscaleMeshFitter": "levels",
    "vtkPoissonNetFilter": "poisson-net",
    "vtkPoseEnsembleFilter": "dataset poses",
    "vtkSurfaceRepairFilter": "repair",
    "vtkTetrahedralizeFilter": "tetrahedralize",
    "vtkTopologyReport": "report",
    "vtkVDBSurfaceFilter": "surface",
}
#: Options for what the messages say of a class, where they do not follow from the name of a property.
PHRASES = {
    "HoleFilling ALL_HOLES": "--holes all",
    "KeepLargestComponentOn()": "--largest-component",
    "a MinimumComponentFraction": "--minimum-component",
    "EncoderIterations": "--encoder-iterations",
}
#: Properties whose option has another word than the property.
_OPTIONS = {
    "TargetEdgeLength": "edge-length",
    "TargetNumberOfPoints": "points",
    "HoleFilling": "holes",
    "MaximumHoleSize": "hole-size",
    "InputNormalization": "normalization",
    "TargetPreparation": "prepare",
    "TextureScale": "scale",
    "CorrelationRange": "range",
    "OutputTrajectory": "trajectory",
}
_PROPERTY = re.compile(r"\b(?:[A-Z][a-z]+){2,}\b")
_CLASS = re.compile(r"\b(vtk[A-Z]\w+)(?: with ([A-Z]\w+(?: [A-Z_]{2,}|\(\))?|a [A-Z]\w+))?")


def in_words_of_commands(text, parser):
    """``text`` with the options of the command that ``parser`` reads, and the commands for other classes."""
    offered = {option for action in parser._actions for option in action.option_strings}
    text = _CLASS.sub(_command, text)
    return _PROPERTY.sub(lambda match: _option(match[0], offered), text)


def _command(match):
    name, phrase = match[1], match[2]
    if name not in COMMANDS_OF_CLASSES:
        return match[0]
    command = f"the command {COMMANDS_OF_CLASSES[name]}"
    return command if phrase is None else f"{command} with {PHRASES.get(phrase, phrase)}"


def _option(name, offered):
    """The option for a property; the name itself when the command has none."""
    words = [_OPTIONS.get(name, _dashed(name)), _dashed(name.replace("NumberOf", ""))]
    for ending in ("ArrayName", "FileName", "Name"):
        words.append(_dashed(name.removesuffix(ending)))
    return next((f"--{word}" for word in words if f"--{word}" in offered), name)


def _dashed(name):
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "-", name).lower()


def remember_parser(parser):
    """Lets the parsed arguments know the parser of their command."""
    parser.set_defaults(parser=parser)

