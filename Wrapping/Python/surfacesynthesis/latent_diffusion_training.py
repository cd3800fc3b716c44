# SPDX-License-Identifier: BSD-3-Clause
"""Training of new textures: functions around vtkLatentDiffusionTrainer."""

import os
import warnings

from vtkmodules.vtkCommonDataModel import vtkPolyData

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
    positive,
    progress_callback,
)
from .errors import SurfaceSynthesisWarning
from .field_latents import image_of, require_surface
from .pipeline import run_algorithm
from .training import LARGEST_LEARNING_RATE, count, shallow_copy
from .vtkSurfaceSynthesisTraining import vtkLatentDiffusionTrainer

#: Sizes of the network, by the name that ``sizes`` takes.
SIZES = {"small": vtkLatentDiffusionTrainer.SMALL, "paper": vtkLatentDiffusionTrainer.PAPER}
#: Quantities that the network predicts, by the name that ``target`` takes.
TARGETS = {
    "noise": vtkLatentDiffusionTrainer.NOISE,
    "data": vtkLatentDiffusionTrainer.DATA,
    "velocity": vtkLatentDiffusionTrainer.VELOCITY,
}
#: The optimizers of the weights, by the name that ``optimizer`` takes.
OPTIMIZERS = {"adam": vtkLatentDiffusionTrainer.ADAM, "muon": vtkLatentDiffusionTrainer.MUON}

#: The columns of the losses.
COLUMNS = ("iteration", "loss", "gradient_norm", "learning_rate", *(f"noise_loss_{k}" for k in range(1, 9)))


def latent_dataset(
    path,
    mesh,
    image=None,
    autoencoder="field_latents",
    triangulations=16,
    points=3000,
    label=None,
    direction=None,
    color=None,
    seed=0,
    progress=None,
):
    """Writes a dataset to train latent diffusion on: one textured surface, remeshed many times, and its field latents.

    Parameters
    ----------
    path : path
        The file to write, safetensors, for ``dataset`` of train_latent_diffusion() and for surfacesynthesis-train.
    mesh, image, autoencoder, triangulations, points, label, direction, color
        As for train_latent_diffusion().
    seed : int
        Any integer of 32 bits: the order of the numbers of vertices. Default 0.
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, nothing is written.

    Raises
    ------
    SurfaceSynthesisError
        The text names the defect of the surface, the texture, an array or a file.
    Cancelled
        ``progress`` returned False.
    ValueError, TypeError
        An argument has a value out of its range or is of a wrong type.
    """
    progress_callback(progress)
    algorithm = vtkLatentDiffusionTrainer()
    _configure_dataset(algorithm, autoencoder, triangulations, points, label, direction, color)
    algorithm.SetSeed(integer("seed", seed, INT_MIN))
    algorithm.SetEncodedDatasetFileName(os.fsdecode(path))
    algorithm.SetIterations(0)
    connect(algorithm, mesh, image)
    for text in run_algorithm(algorithm, progress):
        warnings.warn(text, SurfaceSynthesisWarning, stacklevel=2)


@training.documented(COLUMNS, learning_rate="1e-3")
def train_latent_diffusion(mesh=None, image=None, *, model, dataset=None, progress=None, **options):
    """Trains a diffusion model of field latents, with which sample_texture() makes new textures, on one textured surface.

    Parameters
    ----------
    mesh : vtkPolyData, optional
        The surface: triangles, polygons or strips, manifold and consistently wound once points at the same coordinates are
        joined; with texture coordinates where there is an image. It is not modified.
    image : vtkImageData or array [H, W] or [H, W, C], optional
        The texture, as for encode_texture(). Default: the colors of the points.
    model : path
        The model file that is written, safetensors.
    dataset : path, optional
        A dataset file that is trained on in place of ``mesh`` and ``image``, as latent_dataset() writes it.
    autoencoder : path or str
        The file of the autoencoder of field latents, or the name of an installed one; not used with a dataset. Default
        "field_latents", the installed one.
    triangulations, points : int
        Number of triangulations of the surface, and mean number of vertices of each; not used with a dataset. Default 16
        and 3000.
    label, direction : str, optional
        Names of point arrays that guide samples: a label for each point, a whole number from 0 to 65535, or -1 for none;
        and a vector for each point, the direction of the texture. Default: none.
    color : str, optional
        Name of the point array of colors that is learnt when there is no image. Default: the active point scalars.
    sizes : str
        Sizes of the network that are not given: "small", which two processor cores train in hours, or "paper". Default
        "small".
    channels, coarse_channels, input_blocks, coarse_blocks, output_blocks : int
        Channels on the surface and on the coarser level; blocks before the pooling, on the coarser level and after the
        unpooling. Default 0 each: as ``sizes``.
    embedding_dimension, time_steps : int
        Numbers of the embedding of time and labels, even; steps of the forward process. Default 64 and 1000.
    first_variance, last_variance : float
        Variances that the first and the last step of the forward process add; linear between. Default 1e-4 and 0.02.
    sample_latents : bool
        True draws the latents of each iteration from their Gaussians, False takes their means. Default True.
    target : str
        Quantity that the network predicts: "noise", "data" or "velocity". Default "noise".
    iterations, batch : int
        Iterations in all, those of a checkpoint included; surfaces in each. Default 20000 and 4.
    optimizer : str
        Optimizer of the weights: "adam", as published, or "muon" for the complex matrices inside the network and Adam for
        the rest. Default "adam".
    final_learning_rate : float
        Learning rate at the end, to which it falls along half a cosine. With "muon" it rises over the first hundredth of all
        iterations. Default 1e-5.
    clip : float
        Largest norm of the gradient of all weights together; 0 for no limit. Default 1.
    averaging : float
        Decay of the exponential average of the weights, which the model has; 0 for the weights themselves. Default 0.999.
    snr_limit : float
        Limit of the weights of the loss by the signal-to-noise ratio; 0 for the plain mean square. Default 0.
    condition_dropout : float
        Part of the surfaces that are seen without labels and directions. Default 0.1.
    sample : path, optional
        An image file, PNG, that is written with each checkpoint: a texture of ``mesh``, which it needs, sampled with the
        model so far. Default: none.
    (shared parameters)
    """
    progress_callback(progress)
    algorithm = configured_filter(model, dataset, **options)
    if not training.uses_dataset_file(algorithm, mesh=mesh, image=image):
        if mesh is None:
            raise TypeError("a mesh is needed, or a dataset")
        connect(algorithm, mesh, image)
    return training.run(algorithm, COLUMNS, progress)


@training.with_shared_parameters
def configured_filter(
    model,
    dataset=None,
    autoencoder="field_latents",
    triangulations=16,
    points=3000,
    label=None,
    direction=None,
    color=None,
    sizes="small",
    channels=0,
    coarse_channels=0,
    input_blocks=0,
    coarse_blocks=0,
    output_blocks=0,
    embedding_dimension=64,
    time_steps=1000,
    first_variance=1e-4,
    last_variance=0.02,
    sample_latents=True,
    target="noise",
    iterations=20000,
    batch=4,
    optimizer="adam",
    learning_rate=1e-3,
    final_learning_rate=1e-5,
    clip=1.0,
    averaging=0.999,
    snr_limit=0.0,
    condition_dropout=0.1,
    sample=None,
    **shared,
):
    """A vtkLatentDiffusionTrainer with the parameters of train_latent_diffusion(); ``shared`` are those of
    training.configure().

    Raises TypeError and ValueError.
    """
    algorithm = training.configure(vtkLatentDiffusionTrainer(), model, dataset, learning_rate=learning_rate, **shared)
    _configure_dataset(algorithm, autoencoder, triangulations, points, label, direction, color)
    algorithm.SetSizes(choice("sizes", sizes, SIZES))
    algorithm.SetChannels(count("channels", channels, 0, 4096))
    algorithm.SetCoarseChannels(count("coarse_channels", coarse_channels, 0, 4096))
    algorithm.SetInputBlocks(count("input_blocks", input_blocks, 0, 64))
    algorithm.SetCoarseBlocks(count("coarse_blocks", coarse_blocks, 0, 64))
    algorithm.SetOutputBlocks(count("output_blocks", output_blocks, 0, 64))
    algorithm.SetEmbeddingDimension(count("embedding_dimension", embedding_dimension, 2, 4096))
    algorithm.SetTimeSteps(count("time_steps", time_steps, 1, 100000))
    algorithm.SetFirstVariance(in_range("first_variance", first_variance, 1e-12, 0.999999))
    algorithm.SetLastVariance(in_range("last_variance", last_variance, 1e-12, 0.999999))
    algorithm.SetSampleLatents(flag("sample_latents", sample_latents))
    algorithm.SetTarget(choice("target", target, TARGETS))
    algorithm.SetIterations(count("iterations", iterations, 1, 100000000))
    algorithm.SetBatchSize(count("batch", batch, 1, 1000000))
    algorithm.SetOptimizer(choice("optimizer", optimizer, OPTIMIZERS))
    final_learning_rate = positive("final_learning_rate", final_learning_rate)
    algorithm.SetFinalLearningRate(at_most("final_learning_rate", final_learning_rate, LARGEST_LEARNING_RATE))
    algorithm.SetGradientClip(at_least_0("clip", clip))
    algorithm.SetWeightAveraging(in_range("averaging", averaging, 0.0, 0.999999))
    algorithm.SetSnrLimit(at_least_0("snr_limit", snr_limit))
    algorithm.SetConditionDropout(in_range("condition_dropout", condition_dropout, 0.0, 1.0))
    algorithm.SetSampleFileName("" if sample is None else os.fsdecode(sample))
    return algorithm


def connect(algorithm, mesh, image=None):
    """Gives a vtkLatentDiffusionTrainer its inputs, which are not modified."""
    require_surface("mesh", mesh, (vtkPolyData,), "a vtkPolyData")
    algorithm.SetInputDataObject(0, shallow_copy(mesh))
    if image is not None:
        algorithm.SetInputDataObject(1, shallow_copy(image_of(image)))


def _configure_dataset(algorithm, autoencoder, triangulations, points, label, direction, color):
    """Gives a vtkLatentDiffusionTrainer the parameters of its triangulations."""
    algorithm.SetAutoencoderFileName(os.fsdecode(autoencoder))
    algorithm.SetNumberOfTriangulations(count("triangulations", triangulations, 1, 100000))
    algorithm.SetNumberOfPoints(count("points", points, 16, 10000000))
    for keyword, given, setter in (
        ("label", label, algorithm.SetLabelArrayName),
        ("direction", direction, algorithm.SetDirectionArrayName),
        ("color", color, algorithm.SetColorArrayName),
    ):
        if given is not None:
            setter(array_name(keyword, given))
