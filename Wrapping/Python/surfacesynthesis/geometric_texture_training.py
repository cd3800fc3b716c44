# SPDX-License-Identifier: BSD-3-Clause
"""Training of geometric textures: functions around vtkMultiscaleMeshFitter and vtkGeometricTextureTrainer."""

import collections
import os
import warnings

from vtkmodules.vtkCommonDataModel import vtkDataObject, vtkMultiBlockDataSet, vtkPolyData

from . import training
from .arguments import (
    INT_MIN,
    array_name,
    at_least_0,
    at_most,
    choice,
    flag,
    in_range,
    integer,
    optional_path,
    positive,
    progress_callback,
)
from .datasets import given_dataset
from .deprecation import renamed_keywords
from .errors import SurfaceSynthesisWarning
from .pipeline import run_algorithm
from .training import LARGEST_LEARNING_RATE, count, factor, shallow_copy
from .vtkSurfaceSynthesisTraining import vtkGeometricTextureTrainer, vtkMultiscaleMeshFitter

#: The mesh that is fitted, by the name that ``template`` takes.
TEMPLATES = {
    "icosphere": vtkMultiscaleMeshFitter.ICOSPHERE,
    "torus": vtkMultiscaleMeshFitter.TORUS,
    "surface": vtkMultiscaleMeshFitter.SURFACE,
}

#: What the generators learn by, by the name that ``objective`` takes.
OBJECTIVES = {
    "adversarial": vtkGeometricTextureTrainer.ADVERSARIAL,
    "sliced_wasserstein": vtkGeometricTextureTrainer.SLICED_WASSERSTEIN,
    "flow_matching": vtkGeometricTextureTrainer.FLOW_MATCHING,
}

#: The columns of the losses.
COLUMNS = (
    "iteration",
    "level",
    "critic_loss",
    "gradient_penalty",
    "adversarial_loss",
    "reconstruction_loss",
    "learning_rate",
)
_PATHS = (str, bytes, os.PathLike)
_SURFACE = "a vtkPolyData or a pair of arrays (points, triangles)"

#: The result of fit_levels(): the levels, coarse to fine, and the template, each a vtkPolyData; and for each level the mean
#: and the largest distance of its points from the reference, the mean and the 95th percentile of the distances of samples of
#: both surfaces from the other one, all in world units, the mean angle of the normals there in degrees, and the number of pairs
#: of triangles that intersect, None in builds without CGAL.
FittedLevels = collections.namedtuple(
    "FittedLevels",
    "levels template mean_distances largest_distances symmetric_mean_distances symmetric_percentiles_95 "
    "mean_normal_angles self_intersections",
)


@renamed_keywords(samples="surface_samples")
def fit_levels(reference, progress=None, **options):
    """Makes meshes of one surface at several scales, which a geometric texture is learnt from.

    Parameters
    ----------
    reference : vtkPolyData or pair (points, triangles)
        The surface, of finite points and no degenerate triangle. It need not be manifold, closed or of one component,
        but only surfaces with the topology of the template are fitted well. It is not modified.
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the work stops.
    levels : int
        Number of levels, from 1 to 10; each has four times the triangles of the one before. Default 5.
    template : str, vtkPolyData or pair (points, triangles)
        The mesh that is fitted, of the topology of the reference and wound as it is: "icosphere", "torus", around the z
        axis, "surface", made from the reference, which has manifold edges and points, consistent winding and any topology,
        with or without boundary, or a mesh. Default "icosphere". For "surface" steps, learning rates, samples and seed play
        no part.
    icosphere_level : int
        Number of times that the triangles of the icosahedron are cut into four, from 0 to 6. Default 2.
    torus_segments : int
        Pairs of triangles around the axis of the torus, from 3 to 1000. Default 24.
    template_triangles : int
        Number of triangles of the template "surface", from 4 to 1000000. Default 320.
    smoothing_length : float, optional
        Length that the template "surface" is smoothed with, world units, larger than 0: of waves of this length 5 percent
        are left, of waves ten times as long 94 percent. Default: half of the mean edge length of the template.
    iterations : int
        Number of iterations at each level, from 0 to 1000000; for the template "surface" number of rounds of relaxation of
        the finest level. Default 300.
    triangulation_steps, chamfer_steps : int
        Steps in each iteration that keep triangles even, and that bring the surfaces closer, from 0 to 1000. Default 3
        and 2.
    learning_rate : float
        The learning rate of Adam at the first iteration of each level, in mean edge lengths of the template, halved with
        each level as those are. Default 1e-2.
    learning_rate_decay : float
        The learning rate of a level's last iteration over that of its first, from 1e-6 to 1. Default 0.1.
    surface_samples : int
        Number of samples on each surface at level 0, from 1 to 1000000; at level l there are l + 1 times as many.
        Default 3000.
    published_normals : bool
        Comparison of normals as in the published code. Default False.
    time_budget : float
        Time budget in minutes, each level with its share; 0 for no limit. A level that it ends before its last iteration is
        coarser; a warning says the time that all iterations take. Default 0.
    seed : int
        Any integer of 32 bits with sign. Default 0.
    dataset : path, optional
        A dataset file that is written, safetensors. Default: none.

    Returns
    -------
    FittedLevels
        The named tuple (levels, template, mean_distances, largest_distances, symmetric_mean_distances,
        symmetric_percentiles_95, mean_normal_angles, self_intersections); empty lists for an empty reference.

    Raises
    ------
    SurfaceSynthesisError
        The text says what is wrong with the reference, the template or the file.
    Cancelled
        ``progress`` returned False.
    ValueError, TypeError
        An argument has a value out of its range or is of a wrong type.
    """
    progress_callback(progress)
    algorithm = configured_fitter(**options)
    algorithm.SetInputDataObject(0, _surface("reference", reference))
    for text in run_algorithm(algorithm, progress):
        warnings.warn(text, SurfaceSynthesisWarning, stacklevel=3)
    return fitted_levels(algorithm)


def configured_fitter(
    levels=5,
    template="icosphere",
    icosphere_level=2,
    torus_segments=24,
    template_triangles=320,
    smoothing_length=None,
    iterations=300,
    triangulation_steps=3,
    chamfer_steps=2,
    learning_rate=1e-2,
    learning_rate_decay=0.1,
    surface_samples=3000,
    published_normals=False,
    seed=0,
    dataset=None,
    time_budget=0.0,
):
    """A vtkMultiscaleMeshFitter with the parameters of fit_levels(), which raises TypeError and ValueError."""
    algorithm = vtkMultiscaleMeshFitter()
    algorithm.SetNumberOfLevels(count("levels", levels, 1, 10))
    if isinstance(template, str):
        algorithm.SetTemplate(choice("template", template, TEMPLATES))
    else:
        algorithm.SetTemplateToGiven()
        algorithm.SetInputDataObject(1, _surface("template", template))
    algorithm.SetIcosphereLevel(count("icosphere_level", icosphere_level, 0, 6))
    algorithm.SetTorusSegments(count("torus_segments", torus_segments, 3, 1000))
    algorithm.SetTemplateTriangles(count("template_triangles", template_triangles, 4, 1000000))
    if smoothing_length is not None:
        algorithm.SetSmoothingLength(positive("smoothing_length", smoothing_length))
    algorithm.SetIterations(count("iterations", iterations, 0, 1000000))
    steps = count("triangulation_steps", triangulation_steps, 0, 1000)
    algorithm.SetTriangulationSteps(steps)
    algorithm.SetChamferSteps(count("chamfer_steps", chamfer_steps, 0, 1000))
    algorithm.SetLearningRate(at_most("learning_rate", positive("learning_rate", learning_rate), LARGEST_LEARNING_RATE))
    algorithm.SetLearningRateDecay(in_range("learning_rate_decay", learning_rate_decay, 1e-6, 1.0))
    algorithm.SetSamples(count("surface_samples", surface_samples, 1, 1000000))
    algorithm.SetPublishedNormals(flag("published_normals", published_normals))
    algorithm.SetSeed(integer("seed", seed, INT_MIN))
    algorithm.SetDatasetFileName(optional_path("dataset", dataset))
    algorithm.SetTimeBudget(at_least_0("time_budget", time_budget))
    return algorithm


def fitted_levels(algorithm):
    """The result of fit_levels(), from a filter that has run."""
    blocks = algorithm.GetOutputDataObject(0)
    levels = [shallow_copy(blocks.GetBlock(k)) for k in range(blocks.GetNumberOfBlocks())]
    names = ("MeanDistance", "LargestDistance", "SymmetricMeanDistance", "SymmetricPercentile95", "MeanNormalAngle")
    distances = [[level.GetFieldData().GetArray(name).GetTuple1(0) for level in levels] for name in names]
    pairs = [level.GetFieldData().GetArray("NumberOfSelfIntersections") for level in levels]
    intersections = [int(array.GetTuple1(0)) if array else None for array in pairs]
    return FittedLevels(levels, shallow_copy(algorithm.GetOutputDataObject(1)), *distances, intersections)


@renamed_keywords(name="texture_name", least_channels="minimum_channels", most_channels="maximum_channels")
@training.documented(COLUMNS)
def train_geometric_texture(
    levels=None, template=None, *, model, dataset=None, references=(), progress=None, **options
):
    """Learns a geometric texture from one surface at several scales, or from several.

    Parameters
    ----------
    levels : sequence of surfaces or composite dataset, optional
        The surface at several scales, coarse to fine, each a vtkPolyData or a pair (points, triangles), with the
        triangles of the one before cut into four at the midpoints of edges: ``fit_levels(...).levels``.
    template : vtkPolyData or pair, optional
        The surface of a synthesis without a target, with the triangles of the first level. Default: the first level.
    model : path
        The model file that is written, safetensors; while the training goes on without the statistics of the reference.
    dataset : path, optional
        A dataset file that is trained on in place of ``levels`` and ``template``.
    references : iterable, path or composite dataset, optional
        Further surfaces with the same texture and as many levels, each as ``levels`` or a dataset file, or one such file or
        composite dataset: each iteration draws one of all, so that the texture is learnt on surfaces of several curvatures.
        Their triangles should be of the same size beside the features of the texture.
    texture_name : str
        Name of the texture, for people. Default "texture".
    iterations : int or sequence of int
        Number of iterations of each level, or one number for each level in turn: coarse levels, where features are placed,
        take a fraction of the time of the finest one. Default 2000.
    objective : str
        What the generators learn by: "adversarial", discriminators, as published; "sliced_wasserstein", the distance of
        geometric_texture_distance() of 1, 3 and 6 rings; "flow_matching", the velocity of a flow from noise to the
        displacements of the reference, level by level, in models that do not reconstruct the reference. Default
        "flow_matching", which makes better textures in less time.
    flow_steps : int
        Steps of the flow at each level of a synthesis, from 1 to 1000, written into the model file. Default 10.
    base_noise_amplitude : float
        Of a flow, largest standard deviation of the noise that each coordinate of the level before gets in the training, in mean
        edge lengths of that level, at least 0: in a synthesis that level is never quite the reference's. Default 0.1.
    base_samples : int
        Of a flow, number of samples of the level before that a level learns on, from 0 to 100: features are where the
        reference has them, and shaped as the level before shapes them in a synthesis. With 0 the levels of the reference take
        their place. Default 8.
    projections : int
        Random directions of the sliced Wasserstein distance in each step, from 1 to 10000. Default 64.
    discriminator_steps, generator_steps : int
        Steps of each network in an iteration, from 1 to 1000. Default 2 and 3.
    learning_rate_interval, learning_rate_factor : int, float
        Number of iterations of a level after which the learning rate is multiplied by the factor, each time; 0: a quarter
        of the iterations of the level. Default 500 and 0.5.
    penalty_weight, reconstruction_weight : float
        Weights of the gradient penalty and of the squared distance from the reference. Default 0.1 and 5.
    penalty_interval : int
        Steps of the discriminator from one gradient penalty to the next, which weighs as many times as much, from 1 to 1000.
        Default 1, as published.
    layers, start_channels, minimum_channels, maximum_channels : int
        Layers of each network, input and output included; channels of the first hidden layer at level 0, and of a hidden
        layer at least and at most. Default 7, 32, 32 and 128.
    noise_amplitude : float
        Standard deviation of the noise on each coordinate, in mean edge lengths of a level. Default 0.1.
    (shared parameters)
    """
    progress_callback(progress)
    algorithm = configured_trainer(model, dataset, **options)
    _connect(algorithm, levels, template)
    _add_references(algorithm, references)
    return training.run(algorithm, COLUMNS, progress)


@training.with_shared_parameters
def configured_trainer(
    model,
    dataset=None,
    texture_name="texture",
    iterations=2000,
    objective="flow_matching",
    flow_steps=10,
    base_noise_amplitude=0.1,
    base_samples=8,
    projections=64,
    discriminator_steps=2,
    generator_steps=3,
    learning_rate_interval=500,
    learning_rate_factor=0.5,
    penalty_weight=0.1,
    penalty_interval=1,
    reconstruction_weight=5.0,
    layers=7,
    start_channels=32,
    minimum_channels=32,
    maximum_channels=128,
    noise_amplitude=0.1,
    **shared,
):
    """A vtkGeometricTextureTrainer with the parameters of train_geometric_texture(); ``shared`` are those of
    training.configure().

    Raises TypeError and ValueError.
    """
    algorithm = training.configure(vtkGeometricTextureTrainer(), model, dataset, **shared)
    algorithm.SetTextureName(array_name("texture_name", texture_name))
    if isinstance(iterations, (tuple, list)):
        algorithm.SetNumberOfIterationsOfLevels(len(iterations))
        for level, number in enumerate(iterations):
            algorithm.SetIterationsOfLevel(level, count("iterations", number, 1, 100000000))
    else:
        algorithm.SetIterationsPerLevel(count("iterations", iterations, 1, 100000000))
    algorithm.SetObjective(choice("objective", objective, OBJECTIVES))
    algorithm.SetFlowSteps(count("flow_steps", flow_steps, 1, 1000))
    algorithm.SetBaseNoiseAmplitude(in_range("base_noise_amplitude", base_noise_amplitude, 0.0, 1e6))
    algorithm.SetNumberOfBaseSamples(count("base_samples", base_samples, 0, 100))
    algorithm.SetNumberOfProjections(count("projections", projections, 1, 10000))
    algorithm.SetDiscriminatorSteps(count("discriminator_steps", discriminator_steps, 1, 1000))
    algorithm.SetGeneratorSteps(count("generator_steps", generator_steps, 1, 1000))
    algorithm.SetLearningRateInterval(count("learning_rate_interval", learning_rate_interval, 0, 100000000))
    algorithm.SetLearningRateFactor(factor("learning_rate_factor", learning_rate_factor))
    algorithm.SetPenaltyWeight(at_least_0("penalty_weight", penalty_weight))
    algorithm.SetPenaltyInterval(count("penalty_interval", penalty_interval, 1, 1000))
    algorithm.SetReconstructionWeight(at_least_0("reconstruction_weight", reconstruction_weight))
    algorithm.SetLayers(count("layers", layers, 3, 32))
    algorithm.SetStartChannels(count("start_channels", start_channels, 1, 4096))
    algorithm.SetMinimumChannels(count("minimum_channels", minimum_channels, 1, 4096))
    algorithm.SetMaximumChannels(count("maximum_channels", maximum_channels, 1, 4096))
    algorithm.SetNoiseAmplitude(in_range("noise_amplitude", noise_amplitude, 0.0, 1e6))
    return algorithm


def add_reference_files(algorithm, paths):
    """Gives a vtkGeometricTextureTrainer dataset files of further surfaces."""
    algorithm.SetNumberOfReferenceFileNames(len(paths))
    for number, path in enumerate(paths):
        algorithm.SetReferenceFileName(number, optional_path("each of the references", path))


def _add_references(algorithm, references):
    """Gives a vtkGeometricTextureTrainer further surfaces, files and others; raises TypeError."""
    references = [references] if isinstance(references, (*_PATHS, vtkDataObject)) else list(references)
    add_reference_files(algorithm, [one for one in references if isinstance(one, _PATHS)])
    surfaces = [one for one in references if not isinstance(one, _PATHS)]
    if surfaces and algorithm.GetDatasetFileName():
        raise TypeError("beside a dataset each of the references must be a dataset file")
    for surface in surfaces:
        algorithm.AddInputDataObject(0, _levels(surface))


def _connect(algorithm, levels, template):
    """Gives a vtkGeometricTextureTrainer its inputs, which are not modified."""
    if training.uses_dataset_file(algorithm, levels=levels, template=template):
        return
    if levels is None:
        raise TypeError("levels are needed, or a dataset")
    algorithm.SetInputDataObject(0, _levels(levels))
    if template is not None:
        algorithm.SetInputDataObject(1, _surface("template", template))


def _levels(levels):
    """A composite dataset of the levels of one surface."""
    if isinstance(levels, (tuple, list)):
        blocks = vtkMultiBlockDataSet()
        for number, level in enumerate(levels):
            blocks.SetBlock(number, _surface("each level", level))
        levels = blocks
    return shallow_copy(given_dataset(levels, text="a sequence of surfaces or a composite dataset"))


def _surface(name, mesh):
    """A shallow copy of a vtkPolyData, which takes what pipelines leave on their inputs, or a pair as one."""
    if not isinstance(mesh, (vtkPolyData, tuple, list)):
        raise TypeError(f"{name} must be {_SURFACE}, not {type(mesh).__name__}")
    return shallow_copy(given_dataset(mesh))

