# SPDX-License-Identifier: BSD-3-Clause
"""One vocabulary: VTK's properties, the keywords of Python, the options of the command line and of surfacesynthesis-train,
and the server-manager XML of ParaView name the same things alike.

A word is a keyword of a function, or an option without its dashes: ``--first-sample`` and ``first_sample`` are one. Each word
follows from a property of the VTK class by words_of(), or stands in SYNONYMS; and it means the same property everywhere.
"""

import argparse
import glob
import inspect
import os
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

import pytest
import surfacesynthesis
from surfacesynthesis.command_line import build_parser
from surfacesynthesis.commands.wording import COMMANDS_OF_CLASSES, PHRASES, in_words_of_commands
from surfacesynthesis.displacement_maps import CORRESPONDENCES, VECTOR_SPACES
from surfacesynthesis.field_latents import TEXTURE_WRAPS
from surfacesynthesis.flow_matching import INTEGRATORS
from surfacesynthesis.geometric_texture import NORM_STATISTICS, PREPARATIONS
from surfacesynthesis.latent_diffusion import SAMPLERS, TRIANGULATIONS
from surfacesynthesis.layout import ARRANGEMENTS, PLANES, UNITS
from surfacesynthesis.metrics import DISTANCES
from surfacesynthesis.noise import BOUNDARY_CONDITIONS, DISPLACEMENTS, NOISE_MODELS
from surfacesynthesis.poisson_net import NORMALIZATIONS
from surfacesynthesis.remeshing import HOLES
from surfacesynthesis.skinning import SKINNING_METHODS
from surfacesynthesis.vdb_surface import INSIDE, SMOOTHING
from surfacesynthesis.vocabulary import SYNONYMS, snake, words_of

XML_FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, os.pardir, "Wrapping", "ParaView")
sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, "ParaView"))
from server_manager_xml import is_base, is_former, proxy_of  # noqa: E402

#: surfacesynthesis-train, where the build has it.
TRAIN_PROGRAM = os.environ.get("SURFACE_SYNTHESIS_TRAIN_PROGRAM", "")

#: Properties that share their name with another one of another meaning: no word follows from them.
HOMONYMS = {("vtkGaussianMixtureFilter", "Width"), ("vtkMultiscaleMeshFitter", "Samples")}
#: Words about what comes in, goes out and is shown: the same everywhere, and no property.
COMMON = {
    "bare": "surface without its relief",
    "bones": "table of bones",
    "candidates": "samples that are chosen from",
    "color_by": "array that is shown first",
    "config": "file of a network's configuration",
    "csv": "table as comma-separated values",
    "generated": "the ensemble that is measured",
    "help": "help text",
    "image": "picture of a texture",
    "json": "results, seconds and files written as one JSON object",
    "key": "place of the weights in a checkpoint",
    "measured_samples": "samples of a template that are measured",
    "mesh_points": "points of a planar mesh of a dataset",
    "meshes": "planar meshes of a dataset",
    "nearest": "table of nearest references",
    "output": "file of another result",
    "observations": "points at which a field is known",
    "pose": "table of a pose",
    "point_data": "files with values of points",
    "output": "the file that is written",
    "progress": "progress callable, or bar",
    "quiet": "errors only",
    "reference": "what is compared with",
    "reference_bare": "surface beneath what is compared with",
    "seams": "points with several texture coordinates",
    "series": "series of a DICOM folder",
    "set": "entry of a configuration",
    "shapes": "shapes that are projected on a model",
    "side": "shorter side of an image, in pixels",
    "source": "the surface that samples are on",
    "space": "directions of the coordinates of a volume",
    "target": "the surface that gets a texture",
    "threads": "number of threads",
    "tile": "part of an image, in pixels",
    "tiles": "parts of an image",
    "title": "title of a page",
    "vtk_js": "the file vtk.js of npm",
    "warp": "points moved by the result",
}

#: For each function the class, and its inputs, which are datasets and no properties.
FUNCTIONS = {
    "dataset_of_surfaces": ("vtkEnsembleMetrics", {"surfaces"}),  # no class, but the array and source of an ensemble
    "decode_texture": ("vtkFieldLatentDecoder", {"mesh", "target"}),
    "deform": ("vtkFlowMatchingDeformer", {"mesh"}),
    "displacement_map": ("vtkDisplacementMapFilter", {"mesh", "detailed"}),
    "encode_texture": ("vtkFieldLatentEncoder", {"mesh", "image"}),
    "ensemble_layout": ("vtkEnsembleLayoutFilter", {"ensemble"}),
    "ensemble_metrics": ("vtkEnsembleMetrics", set()),
    "ensemble_statistics": ("vtkEnsembleStatistics", {"ensemble"}),
    "estimate_matern": ("vtkMaternParameterEstimator", {"mesh"}),
    "gaussian_mixtures": ("vtkGaussianMixtureFilter", {"mesh"}),
    "geometric_texture": ("vtkGeometricTextureSynthesizer", {"mesh"}),
    "geometric_texture_distance": ("vtkGeometricTextureDistance", {"mesh"}),
    "geometric_texture_features": ("vtkGeometricTextureFeatures", {"mesh"}),
    "geometric_texture_from_example": ("vtkGeometricTextureFromExample", {"mesh", "example"}),
    "label_surfaces": ("vtkLabelSurfaceFilter", {"volume"}),
    "matern_noise": ("vtkMaternNoiseFilter", {"mesh"}),
    "poisson_net": ("vtkPoissonNetFilter", {"mesh"}),
    "rest_states": ("vtkElasticRestFilter", {"mesh"}),
    "settle": ("vtkElasticRestFilter", {"mesh", "shapes"}),
    "sample_signal": ("vtkFlowMatchingSampler", {"mesh"}),
    "sample_texture": ("vtkFieldLatentTextureFilter", {"mesh", "image"}),
    "shape_model": ("vtkShapeModelSampler", {"model", "shapes"}),
    "skin": ("vtkSkinningFilter", {"mesh", "bones", "pose"}),
    "surface_distance": ("vtkSurfaceDistance", {"first", "second"}),
    "surfaces_of_dataset": ("vtkGaussianMixtureFilter", {"dataset"}),  # no class, but samples as those of other data
    "texture_dataset": ("vtkGaussianMixtureFilter", {"images", "path"}),  # no class, but a seed as that of other data
    "topology_report": ("vtkTopologyReport", {"mesh"}),
}
if hasattr(surfacesynthesis, "vtkPoseEnsembleFilter"):
    FUNCTIONS["poses"] = ("vtkPoseEnsembleFilter", {"mesh"})
    FUNCTIONS["remesh"] = ("vtkIsotropicRemeshFilter", {"mesh"})
    FUNCTIONS["repair"] = ("vtkSurfaceRepairFilter", {"mesh"})
    FUNCTIONS["texture_atlas"] = ("vtkTextureAtlasFilter", {"mesh"})
if hasattr(surfacesynthesis, "vtkTetrahedralizeFilter"):
    FUNCTIONS["tetrahedralize"] = ("vtkTetrahedralizeFilter", {"mesh"})
if hasattr(surfacesynthesis, "vtkVDBSurfaceFilter"):
    FUNCTIONS["vdb_surface"] = ("vtkVDBSurfaceFilter", {"volume"})

#: For each command the functions whose keywords its options are.
COMMANDS = {
    "convert": (),
    "decode-texture": ("decode_texture",),
    "encode-texture": ("encode_texture",),
    "displacement-map": ("displacement_map",),
    "distance": ("surface_distance",),
    "estimate": ("estimate_matern",),
    "dataset export": ("surfaces_of_dataset",),
    "dataset import": ("dataset_of_surfaces",),
    "dataset latents": ("latent_dataset",),
    "dataset mixtures": ("gaussian_mixtures", "remesh"),
    "dataset poses": ("poses", "remesh"),
    "dataset rest-states": ("rest_states", "remesh"),
    "dataset textures": ("texture_dataset",),
    "deform": ("deform",),
    "geometric-texture": ("geometric_texture",),
    "geometric-texture-distance": ("geometric_texture_distance",),
    "geometric-texture-features": ("geometric_texture_features",),
    "geometric-texture-from-example": ("geometric_texture_from_example",),
    "label-surfaces": ("label_surfaces",),
    "levels": ("fit_levels",),
    "metrics": ("ensemble_metrics",),
    "noise": ("matern_noise",),
    "poisson-net": ("poisson_net",),
    "remesh": ("remesh",),
    "repair": ("repair",),
    "report": ("topology_report",),
    "sample": ("sample_signal",),
    "sample-texture": ("sample_texture",),
    "settle": ("settle",),
    "shape-model": ("shape_model",),
    "skin": ("skin",),
    "statistics": ("ensemble_statistics",),
    "texture-statistics": (),
    "surface": ("vdb_surface",),
    "tetrahedralize": ("tetrahedralize",),
    "texture-atlas": ("texture_atlas",),
    "transfer-texture": ("encode_texture", "decode_texture"),
    "view": (),
    "train field-latents": ("train_field_latents",),
    "train flow-matching": ("train_flow_matching",),
    "train geometric-texture": ("train_geometric_texture",),
    "train latent-diffusion": ("train_latent_diffusion",),
}
#: Options that are given another way in Python: the keyword.
OTHERWISE_IN_PYTHON = {"condition_array": "conditions", "features": "feature_angle", "milestone": "milestones"}

#: The values of enumerations in Python: the dictionary, class and property. "given" is a mesh in Python.
VALUES = [
    (CORRESPONDENCES, "vtkDisplacementMapFilter", "Correspondence"),
    (VECTOR_SPACES, "vtkDisplacementMapFilter", "VectorSpace"),
    (NORM_STATISTICS, "vtkGeometricTextureSynthesizer", "NormStatistics"),
    (NORM_STATISTICS, "vtkGeometricTextureSynthesizer", "NormStatistics"),
    (INTEGRATORS, "vtkFlowMatchingSampler", "Integrator"),
    (INTEGRATORS, "vtkFlowMatchingDeformer", "Integrator"),
    (PREPARATIONS, "vtkGeometricTextureSynthesizer", "TargetPreparation"),
    (ARRANGEMENTS, "vtkEnsembleLayoutFilter", "Arrangement"),
    (PLANES, "vtkEnsembleLayoutFilter", "Plane"),
    (UNITS, "vtkEnsembleLayoutFilter", "Unit"),
    (DISTANCES, "vtkEnsembleMetrics", "Distance"),
    (NOISE_MODELS, "vtkMaternNoiseFilter", "NoiseModel"),
    (BOUNDARY_CONDITIONS, "vtkMaternNoiseFilter", "BoundaryCondition"),
    (DISPLACEMENTS, "vtkMaternNoiseFilter", "Displacement"),
    (NORMALIZATIONS, "vtkPoissonNetFilter", "InputNormalization"),
    (SKINNING_METHODS, "vtkSkinningFilter", "SkinningMethod"),
    (HOLES, "vtkSurfaceRepairFilter", "HoleFilling"),
    (TEXTURE_WRAPS, "vtkFieldLatentEncoder", "TextureWrap"),
    (SAMPLERS, "vtkFieldLatentTextureFilter", "Sampler"),
    (TRIANGULATIONS, "vtkFieldLatentTextureFilter", "Triangulation"),
    (INSIDE, "vtkVDBSurfaceFilter", "InsideRule"),
    (SMOOTHING, "vtkVDBSurfaceFilter", "Smoothing"),
]
if hasattr(surfacesynthesis, "vtkTetrahedralizeFilter"):
    from surfacesynthesis.tetrahedra import INNER_SURFACES

    VALUES.append((INNER_SURFACES, "vtkTetrahedralizeFilter", "InnerSurfaces"))

#: Where the keywords of a function are, if not in its own signature.
SIGNATURES = {}
if "train_flow_matching" in surfacesynthesis.__all__:
    from surfacesynthesis import (
        field_latent_training,
        flow_matching_training,
        geometric_texture_training,
        latent_diffusion_training,
    )

    FUNCTIONS["fit_levels"] = ("vtkMultiscaleMeshFitter", set())
    FUNCTIONS["train_field_latents"] = ("vtkFieldLatentTrainer", {"images"})
    FUNCTIONS["latent_dataset"] = ("vtkLatentDiffusionTrainer", {"mesh", "image", "path"})
    FUNCTIONS["train_latent_diffusion"] = ("vtkLatentDiffusionTrainer", {"mesh", "image"})
    FUNCTIONS["train_flow_matching"] = ("vtkFlowMatchingTrainer", {"samples"})
    FUNCTIONS["train_geometric_texture"] = ("vtkGeometricTextureTrainer", {"levels", "template"})
    SIGNATURES = {
        "fit_levels": geometric_texture_training.configured_fitter,
        "train_field_latents": field_latent_training.configured_filter,
        "train_flow_matching": flow_matching_training.configured_filter,
        "train_geometric_texture": geometric_texture_training.configured_trainer,
        "train_latent_diffusion": latent_diffusion_training.configured_filter,
    }
    VALUES += [
        (field_latent_training.training.DEVICES, "vtkFieldLatentTrainer", "Device"),
        (field_latent_training.SIZES, "vtkFieldLatentTrainer", "Sizes"),
        (field_latent_training.COORDINATES, "vtkFieldLatentTrainer", "Coordinates"),
        (geometric_texture_training.OBJECTIVES, "vtkGeometricTextureTrainer", "Objective"),
        (latent_diffusion_training.training.DEVICES, "vtkLatentDiffusionTrainer", "Device"),
        (latent_diffusion_training.SIZES, "vtkLatentDiffusionTrainer", "Sizes"),
        (latent_diffusion_training.TARGETS, "vtkLatentDiffusionTrainer", "Target"),
        (latent_diffusion_training.OPTIMIZERS, "vtkLatentDiffusionTrainer", "Optimizer"),
        (flow_matching_training.NOISES, "vtkFlowMatchingTrainer", "NoiseModel"),
        (flow_matching_training.PREDICTIONS, "vtkFlowMatchingTrainer", "Prediction"),
        (flow_matching_training.OPTIMIZERS, "vtkFlowMatchingTrainer", "Optimizer"),
        (flow_matching_training.SCHEDULES, "vtkFlowMatchingTrainer", "LearningRateSchedule"),
        (flow_matching_training.DEVICES, "vtkFlowMatchingTrainer", "Device"),
        (geometric_texture_training.training.DEVICES, "vtkGeometricTextureTrainer", "Device"),
        ({**geometric_texture_training.TEMPLATES, "given": 2}, "vtkMultiscaleMeshFitter", "Template"),
    ]
#: The classes behind what surfacesynthesis-train trains.
PROGRAM = {
    "encoding": "vtkFlowMatchingTrainer",
    "flow-matching": "vtkFlowMatchingTrainer",
    "field-latents": "vtkFieldLatentTrainer",
    "geometric-texture": "vtkGeometricTextureTrainer",
    "latent-diffusion": "vtkLatentDiffusionTrainer",
}
#: What surfacesynthesis-train alone trains: no class of VTK and no function has words for it.
PROGRAM_ALONE = set()


def class_of(name):
    return getattr(surfacesynthesis, name)


def properties_of(cls):
    """The properties that a class of this library and its bases here can be given."""
    foreign = next(base for base in cls.__mro__ if base.__module__.startswith("vtkmodules"))
    setters = {name[3:] for name in set(dir(cls)) - set(dir(foreign)) if name.startswith("Set")}
    return {name for name in setters if not any(name.startswith(other + "To") for other in setters)}


def values_of(cls, name):
    """The values of an enumeration of a class: what SetNameToValue() sets, by the value's name."""
    prefix, instance, values = f"Set{name}To", cls(), {}
    for setter in dir(cls):
        if setter.startswith(prefix):
            getattr(instance, setter)()
            values[setter[len(prefix):]] = getattr(instance, "Get" + name)()
    return values


def spaced(name):
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", " ", name)


def plain(name):
    """A value without case and separators."""
    return re.sub(r"[^a-z0-9]", "", name.lower())


def meaning_of(word, classes):
    """The meaning of a word for some classes: a property, or a row of a table; None when it has none."""
    if word in COMMON:
        return f"common: {COMMON[word]}"
    settable = {(cls.__name__, name) for cls in classes for name in properties_of(cls)}
    settable |= {(cls.__name__, "InputArrayToProcess") for cls in classes}
    if word in SYNONYMS:
        return f"synonym: {word}" if SYNONYMS[word][0] & {name for _, name in settable} else None
    named = {name for cls, name in settable - HOMONYMS if word in words_of(name)}
    return f"property: {min(named)}" if named else None


def keywords_of(function):
    """The keywords of a public function that are no datasets."""
    signatures = [getattr(surfacesynthesis, function), *filter(None, [SIGNATURES.get(function)])]
    names = [name for signature in signatures for name in inspect.signature(signature).parameters]
    return set(names) - {"options"} - FUNCTIONS[function][1]


def parsers(parser=None, path=()):
    """All commands with their parsers."""
    parser = parser or build_parser()
    nested = [action for action in parser._actions if isinstance(action, argparse._SubParsersAction)]
    if not nested:
        yield " ".join(path), parser
    for action in nested:
        for name, child in action.choices.items():
            yield from parsers(child, (*path, name))


def options_of(parser):
    """The options of a command that its help shows."""
    return [action for action in parser._actions if action.option_strings and action.help != argparse.SUPPRESS]


def word_of(option):
    """The word of an option; that of --no-merge-points is merge_points."""
    word = option.option_strings[-1].lstrip("-").replace("-", "_")
    return word[3:] if word.startswith("no_") and option.nargs == 0 else word


def program_options(text):
    """The options and their texts by what is trained, from the help of surfacesynthesis-train."""
    found = {}
    for line in text.splitlines():
        title = re.match(r"Options of ([\w-]+)", line)
        option = re.match(r"  --([\w-]+) +(.*)", line)
        if title:
            options = found.setdefault(title[1], {})
        elif option:
            options[option[1].replace("-", "_")] = option[2]
    return found


def help_of_program():
    return subprocess.run([TRAIN_PROGRAM, "--help"], capture_output=True, encoding="utf-8", check=True).stdout


def words_in_use():
    """(place, word, classes) of all functions, commands and the program."""
    used = [(f"{name}()", word, [FUNCTIONS[name][0]]) for name in FUNCTIONS for word in keywords_of(name)]
    for command, parser in parsers():
        classes = [FUNCTIONS[name][0] for name in COMMANDS[command] if name in FUNCTIONS]
        used += [(command, word_of(option), classes) for option in options_of(parser)]
    if TRAIN_PROGRAM:
        for trained, options in program_options(help_of_program()).items():
            if trained not in PROGRAM_ALONE:
                used += [(f"surfacesynthesis-train {trained}", word, [PROGRAM[trained]]) for word in options]
    return [(place, word, [class_of(name) for name in classes]) for place, word, classes in used]


def faults_of_words(used):
    """Words without meaning, and words of two meanings."""
    faults, meanings = [], {}
    for place, word, classes in used:
        meaning = meaning_of(word, classes)
        if meaning is None:
            faults.append(f"{place}: {word} is no property, and no synonym")
        else:
            meanings.setdefault(word, {}).setdefault(meaning, []).append(place)
    return faults + [f"{word} has several meanings: {found}" for word, found in meanings.items() if len(found) > 1]


def faults_of_values(values, expected, exactly=False):
    """Values that are spelled otherwise, or have another number."""
    same = (lambda value: value) if exactly else plain
    found, wanted = ({same(text): number for text, number in some.items()} for some in (values, expected))
    return [] if found == wanted else [f"{found} is not {wanted}"]


def faults_of_proxy(proxy, cls):
    """Properties of a server-manager proxy that are spelled otherwise than those of the class."""
    faults, settable = [], properties_of(cls)
    for element in proxy:
        name, command = element.get("name"), element.get("command", "")
        if element.tag == "InputProperty" or not element.tag.endswith("Property") or command in ("", "Modified"):
            continue
        if is_former(element):
            successor = element.find("Hints/FormerName")
            commands = ("Get" + name, "Set" + name, "Set" + successor.get("of") if successor is not None else "")
            if command not in commands or not hasattr(cls, command):
                faults.append(f"{name} is no former name of {cls.__name__}")
            continue
        if element.get("panel_widget") == "command_button":
            if command != name or not hasattr(cls, command):
                faults.append(f"{name} is no method of {cls.__name__}")
            continue
        if element.get("information_only") == "1":
            if command != "Get" + name or not hasattr(cls, command):
                faults.append(f"{name} is no result of {cls.__name__}")
            continue
        if command == "SetInputArrayToProcess":  # VTK's own way to name an array, and ParaView's own words for it
            continue
        wanted = name if command == "Set" + name else name[:-1]  # a property that repeats, as Milestones, has SetMilestone
        if command != "Set" + wanted or wanted not in settable:
            faults.append(f"{name} is no property of {cls.__name__}")
        if element.get("label") != spaced(name):
            faults.append(f"the label of {name} is {element.get('label')!r}")
        entries = {entry.get("text"): int(entry.get("value")) for entry in element.findall("EnumerationDomain/Entry")}
        if entries:
            faults += [f"{name}: {fault}" for fault in faults_of_values(entries, values_of(cls, name))]
    return faults


def proxies():
    """The name of each server-manager XML, its proxy and the class, where the build has the class."""
    for path in sorted(glob.glob(os.path.join(XML_FOLDER, "*.xml"))):
        proxy = proxy_of(path)
        if not is_base(path) and hasattr(surfacesynthesis, proxy.get("class")):
            yield os.path.basename(path), proxy, class_of(proxy.get("class"))


def test_all_that_speaks_is_read():
    """Nothing is compared with an empty list."""
    used = words_in_use()
    assert len(FUNCTIONS) >= 9 and {command for command, _ in parsers()} <= set(COMMANDS)
    assert all(len(keywords_of(name)) >= 2 for name in FUNCTIONS)
    shown = {text for _, parser in parsers() for option in options_of(parser) for text in option.option_strings}
    assert {"--noise-model", "--seed"} <= shown
    assert len(used) > 150 and len(list(proxies())) >= 9
    assert {"vtkMaternNoiseFilter", "vtkPoissonNetFilter"} <= {cls.__name__ for _, _, cls in proxies()}
    if TRAIN_PROGRAM:
        options = program_options(help_of_program())
        assert set(options) == {*PROGRAM, *PROGRAM_ALONE} and all(len(words) > 10 for words in options.values())
    if "train_flow_matching" in surfacesynthesis.__all__:
        assert TRAIN_PROGRAM, "the build has trainings, so it has the program"


def test_each_word_has_one_meaning_everywhere():
    assert faults_of_words(words_in_use()) == []


def test_no_synonym_is_left_over():
    used = {word for _, word, _ in words_in_use()}
    optional = {"fit_levels", "poses", "tetrahedralize", "vdb_surface"}
    needed = set(SYNONYMS) if optional <= set(FUNCTIONS) else set()  # a build without a library has fewer
    assert needed <= used


@pytest.mark.parametrize("command, parser", parsers(), ids=lambda value: value if isinstance(value, str) else "")
def test_each_option_is_a_keyword_of_the_function(command, parser):
    keywords = {word for name in COMMANDS[command] for word in keywords_of(name)} | set(COMMON)
    words = {word_of(option) for option in options_of(parser)}
    assert {OTHERWISE_IN_PYTHON.get(word, word) for word in words} <= keywords


@pytest.mark.parametrize("values, name, enumeration", VALUES, ids=lambda value: value if isinstance(value, str) else "")
def test_values_in_python_are_those_of_the_class(values, name, enumeration):
    if hasattr(surfacesynthesis, name):
        assert faults_of_values(values, values_of(class_of(name), enumeration)) == []
        assert all(re.fullmatch(r"[a-z0-9]+(_[a-z0-9]+)*", value) for value in values)


def choices_in_use():
    """(place, choices, their values in Python) of all options with choices."""
    in_python = {(name, enumeration): list(values) for values, name, enumeration in VALUES}
    for command, parser in parsers():
        names = [FUNCTIONS[function][0] for function in COMMANDS[command] if function in FUNCTIONS]
        for option in options_of(parser):
            if option.choices is not None and word_of(option) not in COMMON:
                meaning = SYNONYMS.get(word_of(option), ({meaning_of(word_of(option), map(class_of, names))[10:]},))[0]
                (values,) = (in_python[name, value] for name in names for value in meaning if (name, value) in in_python)
                yield f"{command} {option.option_strings[0]}", list(option.choices), values


def test_choices_of_options_are_the_values_of_python():
    found = list(choices_in_use())
    assert len(found) >= 6
    for place, choices, values in found:
        assert choices == values, place


if TRAIN_PROGRAM:

    def test_values_of_the_program_are_those_of_python():
        options = program_options(help_of_program())
        for trained, word, values in (
            ("flow-matching", "noise_model", flow_matching_training.NOISES),
            ("flow-matching", "device", flow_matching_training.DEVICES),
            ("field-latents", "sizes", field_latent_training.SIZES),
            ("field-latents", "coordinates", field_latent_training.COORDINATES),
        ):
            listed = re.split(r", | or ", re.split(r" \(|: ", options[trained][word])[0])
            assert listed == list(values), (trained, word)


@pytest.mark.parametrize("file, proxy, cls", proxies(), ids=lambda value: value if isinstance(value, str) else "")
def test_properties_in_paraview_are_those_of_the_class(file, proxy, cls):
    assert faults_of_proxy(proxy, cls) == []


def test_messages_name_commands_that_there_are():
    commands = {command for command, _ in parsers()}
    for name, command in COMMANDS_OF_CLASSES.items():
        assert hasattr(surfacesynthesis, name) == (command in commands), name


def test_messages_name_options_that_there_are():
    offered = {text for _, parser in parsers() for option in options_of(parser) for text in option.option_strings}
    if "repair" in dict(parsers()):
        assert set(re.findall(r"--[\w-]+", " ".join(PHRASES.values()))) <= offered
        text = "vtkSurfaceRepairFilter with HoleFilling ALL_HOLES, or vtkFillHolesFilter, closes them; MaximumHoleSize"
        expected = "The command repair with --holes all, or vtkFillHolesFilter, closes them; --hole-size"
        assert in_words_of_commands(text, dict(parsers())["repair"]) == expected
        assert in_words_of_commands(text, dict(parsers())["noise"]).endswith("closes them; MaximumHoleSize")
        quoted = 'The sizing array "EdgeLength" of /data/EdgeLength.vtp is missing; EdgeLength.'
        expected = 'The sizing array "EdgeLength" of /data/EdgeLength.vtp is missing; --edge-length.'
        assert in_words_of_commands(quoted, dict(parsers())["remesh"]) == expected
        text = "The surface has no points. vtkSurfaceRepairFilter repairs it, and vtkTopologyReport counts them."
        expected = "The surface has no points. The command repair repairs it, and the command report counts them."
        assert in_words_of_commands(text, dict(parsers())["repair"]) == expected
        limit = "at most 1e+07 (MaximumNumberOfPoints) are allowed (PoissonNet)."
        expected = "at most 1e+07 (--maximum-points) are allowed (PoissonNet)."
        assert in_words_of_commands(limit, dict(parsers())["remesh"]) == expected
        expected = "at most 1e+07 are allowed (PoissonNet)."
        assert in_words_of_commands(limit, dict(parsers())["dataset mixtures"]) == expected


def test_former_words_are_hidden_and_end_nowhere():
    """A former option is in no help text, and does what its successor does."""
    hidden = [
        (command, action)
        for command, parser in parsers()
        for action in parser._actions
        if action.option_strings and action.help == argparse.SUPPRESS
    ]
    assert len(hidden) >= 20
    for command, action in hidden:
        shown = {option.dest for option in options_of(dict(parsers())[command])}
        assert action.dest in shown, (command, action.option_strings)
        assert action.option_strings[0] + " " not in dict(parsers())[command].format_help(), (command, action)


# -- the checks find what is wrong -------------------------------------------------------------------------------------


def test_a_wrong_word_is_found():
    filters = [class_of("vtkMaternNoiseFilter")]
    assert faults_of_words([("noise", "seed", filters)]) == []
    assert faults_of_words([("noise", "sead", filters)]) == ["noise: sead is no property, and no synonym"]
    assert faults_of_words([("noise", "holes", filters)]) == ["noise: holes is no property, and no synonym"]
    mixtures = [class_of("vtkGaussianMixtureFilter")]
    assert faults_of_words([("mixtures", "width", mixtures)]) == ["mixtures: width is no property, and no synonym"]


class _WithEigenpairs(surfacesynthesis.vtkMaternNoiseFilter):
    """A filter whose eigenpairs are not NumberOfEigenpairs."""

    def SetEigenpairs(self, values):
        pass


def test_a_word_of_two_meanings_is_found():
    noise_filter, deformer = class_of("vtkMaternNoiseFilter"), class_of("vtkFlowMatchingDeformer")
    assert faults_of_words([("noise", "samples", [noise_filter]), ("deform", "samples", [deformer])]) == []
    used = [("noise", "eigenpairs", [noise_filter]), ("another", "eigenpairs", [_WithEigenpairs])]
    assert [fault.partition(" has several meanings")[0] for fault in faults_of_words(used)] == ["eigenpairs"]


def test_a_wrong_proxy_is_found():
    right = """<Proxy><IntVectorProperty name="NoiseModel" command="SetNoiseModel" label="Noise Model"><EnumerationDomain>
      <Entry text="Matern" value="0"/><Entry text="Per Vertex" value="1"/><Entry text="White" value="2"/>
      <Entry text="Unscreened" value="3"/><Entry text="Spectral" value="4"/></EnumerationDomain></IntVectorProperty></Proxy>"""
    for old, new, fault in (
        ("", "", ""),
        ('label="Noise Model"', 'label="Model"', "the label of NoiseModel is 'Model'"),
        ("Per Vertex", "Each Vertex", "eachvertex"),
        ('"4"', '"5"', "'spectral': 5"),
        ("SetNoiseModel", "SetNoise", "NoiseModel is no property of vtkMaternNoiseFilter"),
    ):
        faults = faults_of_proxy(ElementTree.fromstring(right.replace(old, new)), class_of("vtkMaternNoiseFilter"))
        assert faults == [] if not fault else any(fault in found for found in faults), (old, faults)
