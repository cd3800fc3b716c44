# SPDX-License-Identifier: BSD-3-Clause
"""Messages of the filters in the words of the command line: commands in place of classes, options in place of properties."""

import re

from ..vocabulary import SYNONYMS, words_of

#: The command that runs a class.
COMMANDS_OF_CLASSES = {
    "vtkDisplacementMapFilter": "displacement-map",
    "vtkElasticRestFilter": "dataset rest-states",
    "vtkEnsembleMetrics": "metrics",
    "vtkEnsembleStatistics": "statistics",
    "vtkFieldLatentDecoder": "decode-texture",
    "vtkFieldLatentEncoder": "encode-texture",
    "vtkFieldLatentTextureFilter": "sample-texture",
    "vtkFieldLatentTrainer": "train field-latents",
    "vtkFlowMatchingDeformer": "deform",
    "vtkFlowMatchingTrainer": "train flow-matching",
    "vtkGaussianMixtureFilter": "dataset mixtures",
    "vtkGeometricTextureDistance": "geometric-texture-distance",
    "vtkGeometricTextureFeatures": "geometric-texture-features",
    "vtkGeometricTextureFromExample": "geometric-texture-from-example",
    "vtkGeometricTextureSynthesizer": "geometric-texture",
    "vtkGeometricTextureTrainer": "train geometric-texture",
    "vtkIsotropicRemeshFilter": "remesh",
    "vtkLabelSurfaceFilter": "label-surfaces",
    "vtkLatentDiffusionTrainer": "train latent-diffusion",
    "vtkMaternNoiseFilter": "noise",
    "vtkMaternParameterEstimator": "estimate",
    "vtkMultiscaleMeshFitter": "levels",
    "vtkPoissonNetFilter": "poisson-net",
    "vtkPoseEnsembleFilter": "dataset poses",
    "vtkShapeModelSampler": "shape-model",
    "vtkSkinningFilter": "skin",
    "vtkSurfaceDistance": "distance",
    "vtkSurfaceRepairFilter": "repair",
    "vtkTetrahedralizeFilter": "tetrahedralize",
    "vtkTextureAtlasFilter": "texture-atlas",
    "vtkTopologyReport": "report",
    "vtkVDBSurfaceFilter": "surface",
}
#: Options for what the messages say of a class, where they do not follow from the name of a property.
PHRASES = {
    "HoleFilling ALL_HOLES": "--holes all",
    "KeepLargestComponentOn()": "--largest-component",
    "RemoveSelfIntersectionsOn()": "--self-intersections",
    "a MinimumComponentFraction": "--minimum-component",
    "EncoderIterations": "--encoder-iterations",
}
#: Options for what the messages of readers say of read_mesh().
_READING = {
    "read_mesh(path, seams='split')": "--seams split",
    "read_mesh(surface, point_data=[...])": "the surface as INPUT, and --point-data FILE",
}
# Names in quotes and in paths are the user's own.
_BEFORE, _AFTER = r"(?<![\w/\"'.-])", r"(?![\w/\"']|\.\w)"
_PROPERTY = re.compile(_BEFORE + r"(?:[A-Z][a-z]+){2,}" + _AFTER)
_ASIDE = re.compile(r" \((?!LibTorch|ParaView|PoissonNet|PyTorch|TetGen)((?:[A-Z][a-z]+){2,})\)" + _AFTER)
_CLASS = re.compile(_BEFORE + r"(vtk[A-Z]\w+)" + _AFTER + r"(?: with ([A-Z]\w+(?: [A-Z_]{2,}|\(\))?|a [A-Z]\w+))?")


def in_words_of_commands(text, parser):
    """``text`` with the options of the command that ``parser`` reads, and the commands for other classes. A property in
    parentheses goes where the command has no option for it, as for the limits of a filter that the command runs first."""
    texts = [text for action in parser._actions for text in action.option_strings]
    for function, option in _READING.items() if "--seams" in texts else ():
        text = text.replace(function, option)
    offered = {text.lstrip("-").replace("-", "_"): text for text in texts}
    text = _ASIDE.sub(lambda match: match[0] if _option(match[1], offered) in texts else "", text)
    return _PROPERTY.sub(lambda match: _option(match[0], offered), with_commands(text))


def with_commands(text):
    """``text`` with commands for classes, and the options of those commands."""
    return _CLASS.sub(_command, text)


def _command(match):
    name, phrase = match[1], match[2]
    if name not in COMMANDS_OF_CLASSES:
        return match[0]
    begins = match.start() == 0 or match.string[: match.start()].endswith(". ")
    command = f"{'The' if begins else 'the'} command {COMMANDS_OF_CLASSES[name]}"
    return command if phrase is None else f"{command} with {PHRASES.get(phrase, phrase)}"


def _option(name, offered):
    """The option for a property; the name itself when the command has none."""
    words = words_of(name) | {word for word, (properties, _) in SYNONYMS.items() if name in properties}
    return next((offered[word] for word in sorted(words) if word in offered), name)
