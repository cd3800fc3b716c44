# SPDX-License-Identifier: BSD-3-Clause
"""Training of flow matching models: a function around vtkFlowMatchingTrainer."""

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet, vtkPolyData

from . import training
from .arguments import (
    array_name,
    at_least_0,
    choice,
    finite,
    flag,
    in_range,
    integer,
    optional_path,
    positive,
    progress_callback,
)
from .datasets import given_dataset
from .deprecation import renamed_keywords
from .training import DEVICES  # noqa: F401, a part of this module's interface
from .training import count, factor, shallow_copy
from .vtkSurfaceSynthesisTraining import vtkFlowMatchingTrainer

#: The models of the initial noise, by the name that ``noise_model`` takes.
NOISES = {
    "matern": vtkFlowMatchingTrainer.MATERN,
    "per_vertex": vtkFlowMatchingTrainer.PER_VERTEX,
    "white": vtkFlowMatchingTrainer.WHITE,
    "unscreened": vtkFlowMatchingTrainer.UNSCREENED,
    "spectral": vtkFlowMatchingTrainer.SPECTRAL,
}

#: What the network predicts, by the name that ``prediction`` takes.
PREDICTIONS = {
    "automatic": vtkFlowMatchingTrainer.AUTOMATIC,
    "velocity": vtkFlowMatchingTrainer.VELOCITY,
    "data": vtkFlowMatchingTrainer.DATA,
    "preconditioned": vtkFlowMatchingTrainer.PRECONDITIONED,
}
#: The optimizers of the weights, by the name that ``optimizer`` takes.
OPTIMIZERS = {"adam": vtkFlowMatchingTrainer.ADAM, "muon": vtkFlowMatchingTrainer.MUON}
#: The courses of the learning rate, by the name that ``schedule`` takes.
SCHEDULES = {"milestones": vtkFlowMatchingTrainer.MILESTONES, "cosine": vtkFlowMatchingTrainer.COSINE}

#: The columns of the losses.
COLUMNS = (
    *("iteration", "loss", "vertex_loss", "jacobian_loss", "gradient_norm", "learning_rate"),
    *(f"loss_{k}" for k in range(1, 9)),
)

_POSITION = "Position"  # the name of signals that are deformed positions
_LARGEST_AVERAGING = 0.9999999


@renamed_keywords(noise="noise_model")
@training.documented(COLUMNS, "0.02")
def train_flow_matching(source=None, samples=None, *, model, dataset=None, progress=None, **options):
    """Trains a flow matching model on deformations of a surface, or on another signal on it.

    Parameters
    ----------
    source : vtkPolyData, pair (points, triangles) or composite dataset, optional
        The surface that the samples are on; the leaves of a composite dataset are several sources. The mesh must have
        finite points, no degenerate triangle, no edge with more than two triangles, consistent winding and one
        component. Several sources of different shape need an encoder.
    samples : ensemble, optional
        One of: a composite dataset of surfaces (vtkDataObjectTree), whose leaves in order are the samples, or with
        several sources whose blocks hold the samples of one source each; a list of surfaces, each a vtkPolyData or a
        pair (points, triangles); a vtkPolyData; or an array of numbers [N, V, 3] with the positions of N samples, or,
        with ``signal``, [N, V] or [N, V, C] with its values. Surfaces have the points and polygons of the source.
    model : path
        The model file that is written, safetensors.
    dataset : path, optional
        A dataset file that is trained on in place of ``source`` and ``samples``.
    signal : str, optional
        The point array that is learnt. A surface without an array of this name has a sample in each of the arrays
        called signal_0, signal_1 and so on. For an array of numbers: what the signal is called. Default: the positions.
    encoder : path, optional
        A PoissonNet model file that predicts a positional encoding; needed for sources of different shape only. Read
        when ``encoder_iterations`` is 0, else written. Default: none, or ``model`` with .encoder after it.
    initial_model : path, optional
        A flow matching model file whose weights the training begins with, to go on from few triangles to many or with other
        samples. Noise, prediction and the sizes of the network are then those of that model, whatever the parameters for them
        say, and so is the encoder, unless ``encoder`` names another one with as many channels. Default: random weights.
    encoder_iterations : int
        Number of iterations in which an encoder is trained before the model, on sources with the same polygons and, of
        positions, their samples. Its checkpoint is ``encoder`` with .checkpoint after it, and with ``losses`` its own
        go to ``encoder`` with .csv after it. Default 0: none is trained.
    eigenfunctions : int
        Number of eigenfunctions of the first source that this encoder predicts. Default 64.
    encoder_edge_splits : float
        Largest part of the edges of each surface that the training of this encoder splits at random, from 0 to 1. Above 0 it
        predicts better on triangulations other than that of the sources, and takes up to four times as long to train.
        Default 0.
    without_encoder : bool
        Trains on sources of different shape without an encoder, for comparison: the network is told positions alone, which
        mean something else on each shape. Such sources are an error otherwise. Default False.
    width, blocks, layers : int
        Hidden channels, blocks of the network, layers of the maps between gradients. Default 64, 4 and 3.
    inner_products : bool
        Inner products of gradients as further inputs of the maps at the points, with which a model serves triangulations
        other than that of its training less well. Default False.
    prediction : str
        What the network predicts: "data", the end of the flow relative to the source, so that what it leaves alone, such as
        relief, is that of the source; "preconditioned", a mixture of data and noise of the same size at all times, with which
        the data are less and less of the network's prediction and more of the state toward the end of the flow, so that
        signals are sharp; "velocity", as published; or "automatic": "data" for positions, "preconditioned" for other
        signals. Default "automatic".
    noise_model : str
        "matern" or, for comparison, "per_vertex", "white", "unscreened", "spectral". Default "matern".
    screening : float
        Screening term tau of "matern" and "spectral", on the surface scaled to area 1. Default 100.
    noise_smoothing : float
        Smoothing of the noise, in squared mean edge lengths (the mean over the sources, scaled to area 1), so that its
        gradients do not grow with the number of vertices. Negative: 0, the noise of the paper, for positions, and 1 for other
        signals. Default -1.
    noise_scale : float
        Factor of the noise; 0 lets it vary as much as the samples do about their mean, in the mean over the sources. Default 0.
    eigenpairs : int
        Number of eigenpairs of "spectral". Default 256.
    iterations, batch, sources_per_batch : int
        Iterations in all, those of a checkpoint included; samples in each; sources that they come from. Default 3000,
        32 and 1.
    source_memory : float
        Limit in MiB of the memory that operators and factorisations of the sources take, at least 0: about 1.6 KiB for each
        point on the processor, and 4 bytes for each pair of points of a source on CUDA. Those that do not fit are built again
        when an iteration draws their source; the result is the same with every limit. Default 8192.
    optimizer : str
        "muon", which moves the matrices inside the network along the orthogonalized momentum of their gradients, at
        learning rates of 0.01 to 0.02; or "adam", as published, at 5e-4, which takes several times as many iterations.
        Default "muon".
    schedule : str
        Course of the learning rate: "cosine", which rises over the first hundredth of all iterations and falls to 0 along
        half a cosine, or "milestones", as published. Default "cosine".
    learning_rate_factor : float
        Factor of the learning rate at each milestone. Default 0.2.
    milestones : sequence of int
        Iterations after which the learning rate falls with "milestones". Default (): after a quarter of all.
    clip : float
        Largest norm of the gradient of all weights together; 0 for no limit. Default 1.
    vertex_weight, jacobian_weight : float
        Weights of the loss in velocities and of the loss in their gradients. Default 1.
    averaging : float
        Decay of the exponential moving average of the weights, which becomes the model, below 1. Default 0.99.
    (shared parameters)
    """
    progress_callback(progress)
    signal = options.get("signal")
    algorithm = configured_filter(model, dataset, **options)
    connect(algorithm, source, samples, signal)
    return training.run(algorithm, COLUMNS, progress)


@training.with_shared_parameters
def configured_filter(
    model,
    dataset=None,
    signal=None,
    encoder=None,
    initial_model=None,
    encoder_iterations=0,
    eigenfunctions=64,
    encoder_edge_splits=0.0,
    without_encoder=False,
    width=64,
    blocks=4,
    layers=3,
    inner_products=False,
    prediction="automatic",
    noise_model="matern",
    screening=100.0,
    noise_smoothing=-1.0,
    noise_scale=0.0,
    eigenpairs=256,
    iterations=3000,
    batch=32,
    sources_per_batch=1,
    source_memory=8192.0,
    learning_rate=0.02,
    optimizer="muon",
    schedule="cosine",
    milestones=(),
    learning_rate_factor=0.2,
    clip=1.0,
    vertex_weight=1.0,
    jacobian_weight=1.0,
    averaging=0.99,
    **shared,
):
    """A vtkFlowMatchingTrainer with the parameters of train_flow_matching(); ``shared`` are those of
    training.configure().

    Raises TypeError and ValueError.
    """
    algorithm = training.configure(vtkFlowMatchingTrainer(), model, dataset, learning_rate=learning_rate, **shared)
    algorithm.SetEncoderFileName(optional_path("encoder", encoder))
    algorithm.SetInitialModelFileName(optional_path("initial_model", initial_model))
    algorithm.SetEncoderIterations(count("encoder_iterations", encoder_iterations, 0, 100000000))
    algorithm.SetNumberOfEigenfunctions(count("eigenfunctions", eigenfunctions, 1, 10000))
    algorithm.SetEncoderEdgeSplits(in_range("encoder_edge_splits", encoder_edge_splits, 0.0, 1.0))
    algorithm.SetWithoutEncoder(flag("without_encoder", without_encoder))
    algorithm.SetSignalArrayName("" if signal is None else array_name("signal", signal))
    algorithm.SetWidth(count("width", width, 1, 100000))
    algorithm.SetBlocks(count("blocks", blocks, 1, 1000))
    algorithm.SetComplexLayers(count("layers", layers, 1, 100))
    algorithm.SetInnerProducts(flag("inner_products", inner_products))
    algorithm.SetPrediction(choice("prediction", prediction, PREDICTIONS))
    algorithm.SetNoiseModel(choice("noise_model", noise_model, NOISES))
    algorithm.SetScreening(positive("screening", screening))
    algorithm.SetNoiseSmoothing(max(-1.0, finite("noise_smoothing", noise_smoothing)))
    algorithm.SetNoiseScale(at_least_0("noise_scale", noise_scale))
    algorithm.SetNumberOfEigenpairs(count("eigenpairs", eigenpairs, 1, 1000000))
    algorithm.SetIterations(count("iterations", iterations, 1, 100000000))
    algorithm.SetBatchSize(count("batch", batch, 1, 100000))
    algorithm.SetSourcesPerBatch(count("sources_per_batch", sources_per_batch, 1, 100000))
    algorithm.SetSourceMemory(at_least_0("source_memory", source_memory))
    algorithm.SetOptimizer(choice("optimizer", optimizer, OPTIMIZERS))
    algorithm.SetLearningRateSchedule(choice("schedule", schedule, SCHEDULES))
    algorithm.SetLearningRateFactor(factor("learning_rate_factor", learning_rate_factor))
    algorithm.SetGradientClip(at_least_0("clip", clip))
    algorithm.SetVertexWeight(at_least_0("vertex_weight", vertex_weight))
    algorithm.SetJacobianWeight(at_least_0("jacobian_weight", jacobian_weight))
    algorithm.SetWeightAveraging(in_range("averaging", averaging, 0.0, _LARGEST_AVERAGING))
    milestones = [integer("milestones", milestone, 0) for milestone in milestones]
    algorithm.SetNumberOfMilestones(len(milestones))
    for number, milestone in enumerate(milestones):
        algorithm.SetMilestone(number, milestone)
    return algorithm


def connect(algorithm, source, samples, signal=None):
    """Gives a vtkFlowMatchingTrainer its inputs, which are not modified."""
    if training.uses_dataset_file(algorithm, source=source, samples=samples):
        return
    if source is None or samples is None:
        raise TypeError("source and samples are needed, or a dataset")
    source = given_dataset(source)
    if isinstance(samples, np.ndarray):
        samples = _surface_with(algorithm, source, samples, signal)
    elif isinstance(samples, (tuple, list)):
        blocks = vtkMultiBlockDataSet()
        for number, sample in enumerate(samples):
            blocks.SetBlock(number, shallow_copy(given_dataset(sample)))
        samples = blocks
    else:
        text = "a composite dataset, a list of surfaces, a vtkPolyData or an array as samples"
        samples = given_dataset(samples, text=text)
    algorithm.SetInputDataObject(0, shallow_copy(source))
    algorithm.SetInputDataObject(1, shallow_copy(samples))


def _surface_with(algorithm, source, values, signal):
    """The source with an array for each sample."""
    if not isinstance(source, vtkPolyData):
        raise TypeError("samples may be an array of numbers with one source only")
    vertices = source.GetNumberOfPoints()
    shapes = "[N, V, 3]" if signal is None else "[N, V] or [N, V, C]"
    ranks = (3,) if signal is None else (2, 3)
    wrong = values.ndim not in ranks or values.shape[1] != vertices or (signal is None and values.shape[2] != 3)
    if values.dtype.kind not in "fiu" or wrong:
        raise ValueError(
            f"samples must be an array of numbers {shapes} with V = {vertices} points of the source, not of "
            f"{values.dtype} {list(values.shape)}"
        )
    surface = vtkPolyData()
    surface.CopyStructure(source)
    name = _POSITION if signal is None else signal
    algorithm.SetSignalArrayName(name)
    for number, sample in enumerate(values):
        array = numpy_to_vtk(np.ascontiguousarray(sample, dtype=np.float64), deep=True)
        array.SetName(f"{name}_{number}")
        surface.GetPointData().AddArray(array)
    return surface
