# SPDX-License-Identifier: BSD-3-Clause
"""Training of flow matching models: a function around vtkFlowMatchingTrainer."""

import warnings

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet, vtkPolyData

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
from .vtkSurfaceSynthesisTraining import vtkFlowMatchingTrainer

#: The models of the initial noise, by the name that ``noise_model`` takes.
NOISES = {
    "matern": vtkFlowMatchingTrainer.MATERN,
    "per_vertex": vtkFlowMatchingTrainer.PER_VERTEX,
    "white": vtkFlowMatchingTrainer.WHITE,
    "unscreened": vtkFlowMatchingTrainer.UNSCREENED,
    "spectral": vtkFlowMatchingTrainer.SPECTRAL,
}

#: The devices of a training, by the name that ``device`` takes.
DEVICES = {
    "auto": vtkFlowMatchingTrainer.AUTO,
    "cpu": vtkFlowMatchingTrainer.CPU,
    "cuda": vtkFlowMatchingTrainer.CUDA,
}

_POSITION = "Position"  # the name of signals that are deformed positions
_LARGEST_AVERAGING = 0.9999999


@renamed_keywords(noise="noise_model")
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
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the training stops, and a
        checkpoint is written first.
    signal : str, optional
        The point array that is learnt. A surface without an array of this name has a sample in each of the arrays
        called signal_0, signal_1 and so on. For an array of numbers: what the signal is called. Default: the positions.
    checkpoint : path, optional
        The checkpoint. Default: ``model`` with .checkpoint after it.
    losses : path, optional
        A table of the losses in comma-separated values, written with each checkpoint. Default: none.
    checkpoint_interval : int
        Number of iterations from one checkpoint to the next. Default 500.
    resume : bool
        Whether the training goes on from the checkpoint where there is one. Default True.
    encoder : path, optional
        A PoissonNet model file that predicts a positional encoding; needed for sources of different shape only. Read
        when ``encoder_iterations`` is 0, else written. Default: none, or ``model`` with .encoder after it.
    encoder_iterations : int
        Number of iterations in which an encoder is trained before the model, on sources with the same polygons and, of
        positions, their samples. Its checkpoint is ``encoder`` with .checkpoint after it, and with ``losses`` its own
        go to ``encoder`` with .csv after it. Default 0: none is trained.
    eigenfunctions : int
        Number of eigenfunctions of the first source that this encoder predicts. Default 64.
    width, blocks, layers : int
        Hidden channels, blocks of the network, layers of the maps between gradients. Default 64, 4 and 3.
    inner_products : bool
        Whether the maps at the points see inner products of gradients, with which a model serves triangulations other than
        that of its training less well. Default False.
    noise_model : str
        "matern" or, for comparison, "per_vertex", "white", "unscreened", "spectral". Default "matern".
    screening : float
        The screening term tau of "matern" and "spectral", on the surface scaled to area 1. Default 100.
    noise_smoothing : float
        How much "matern" noise is smoothed, in squared mean edge lengths of the first source, so that its gradients do not
        grow with the number of vertices; 0 is the noise of the paper. Default 1.
    noise_scale : float
        What the noise is multiplied by; 0 lets it vary as much as the samples do about their mean. Default 0.
    eigenpairs : int
        Number of eigenpairs of "spectral". Default 256.
    iterations, batch, sources_per_batch : int
        Iterations in all, those of a checkpoint included; samples in each; sources that they come from. Default 20000,
        8 and 1.
    learning_rate, learning_rate_factor : float
        The learning rate of Adam, and what it is multiplied by at each milestone. Default 5e-4 and 0.2.
    milestones : sequence of int
        Iterations after which that happens. Default (): after a quarter of all.
    clip : float
        The largest norm of the gradient of all weights together; 0 for no limit. Default 1.
    vertex_weight, jacobian_weight : float
        Weights of the loss in velocities and of the loss in their gradients. Default 1.
    averaging : float
        How much of the average of earlier weights the model keeps in each iteration, below 1. Default 0.
    seed : int
        Any integer of 32 bits. Default 0.
    device : str
        "auto", "cpu" or "cuda". Default "auto".

    Returns
    -------
    dict of arrays
        "iteration", "loss", "vertex_loss", "jacobian_loss", "gradient_norm" and "learning_rate", with a number for each
        iteration. Empty arrays for empty inputs, of which no model is written.

    Raises
    ------
    SurfaceSynthesisError
        The text says what is wrong with the surfaces, the options together, or a file.
    Cancelled
        ``progress`` returned False.
    ValueError, TypeError
        An argument has a value out of its range or is of a wrong type.
    """
    progress_callback(progress)
    signal = options.get("signal")
    algorithm = configured_filter(model, dataset, **options)
    connect(algorithm, source, samples, signal)
    for text in run_algorithm(algorithm, progress):
        warnings.warn(text, SurfaceSynthesisWarning, stacklevel=3)
    return losses_of(algorithm)


def configured_filter(
    model,
    dataset=None,
    signal=None,
    checkpoint=None,
    losses=None,
    checkpoint_interval=500,
    resume=True,
    encoder=None,
    encoder_iterations=0,
    eigenfunctions=64,
    width=64,
    blocks=4,
    layers=3,
    inner_products=False,
    noise_model="matern",
    screening=100.0,
    noise_smoothing=1.0,
    noise_scale=0.0,
    eigenpairs=256,
    iterations=20000,
    batch=8,
    sources_per_batch=1,
    learning_rate=5e-4,
    milestones=(),
    learning_rate_factor=0.2,
    clip=1.0,
    vertex_weight=1.0,
    jacobian_weight=1.0,
    averaging=0.0,
    seed=0,
    device="auto",
):
    """A vtkFlowMatchingTrainer with the parameters of train_flow_matching(), which raises TypeError and ValueError."""
    algorithm = vtkFlowMatchingTrainer()
    algorithm.SetModelFileName(optional_path("model", model))
    algorithm.SetDatasetFileName(optional_path("dataset", dataset))
    algorithm.SetCheckpointFileName(optional_path("checkpoint", checkpoint))
    algorithm.SetLossTableFileName(optional_path("losses", losses))
    algorithm.SetEncoderFileName(optional_path("encoder", encoder))
    encoder_iterations = integer("encoder_iterations", encoder_iterations, 0)
    algorithm.SetEncoderIterations(at_most("encoder_iterations", encoder_iterations, 100000000))
    eigenfunctions = integer("eigenfunctions", eigenfunctions, 1)
    algorithm.SetNumberOfEigenfunctions(at_most("eigenfunctions", eigenfunctions, 10000))
    algorithm.SetSignalArrayName("" if signal is None else array_name("signal", signal))
    algorithm.SetCheckpointInterval(integer("checkpoint_interval", checkpoint_interval, 1))
    algorithm.SetResume(flag("resume", resume))
    algorithm.SetWidth(at_most("width", integer("width", width, 1), 100000))
    algorithm.SetBlocks(at_most("blocks", integer("blocks", blocks, 1), 1000))
    algorithm.SetComplexLayers(at_most("layers", integer("layers", layers, 1), 100))
    algorithm.SetInnerProducts(flag("inner_products", inner_products))
    algorithm.SetNoiseModel(choice("noise_model", noise_model, NOISES))
    algorithm.SetScreening(positive("screening", screening))
    algorithm.SetNoiseSmoothing(at_least_0("noise_smoothing", noise_smoothing))
    algorithm.SetNoiseScale(at_least_0("noise_scale", noise_scale))
    algorithm.SetNumberOfEigenpairs(at_most("eigenpairs", integer("eigenpairs", eigenpairs, 1), 1000000))
    algorithm.SetIterations(at_most("iterations", integer("iterations", iterations, 1), 100000000))
    algorithm.SetBatchSize(at_most("batch", integer("batch", batch, 1), 100000))
    sources_per_batch = integer("sources_per_batch", sources_per_batch, 1)
    algorithm.SetSourcesPerBatch(at_most("sources_per_batch", sources_per_batch, 100000))
    algorithm.SetLearningRate(positive("learning_rate", learning_rate))
    learning_rate_factor = positive("learning_rate_factor", learning_rate_factor)
    algorithm.SetLearningRateFactor(at_most("learning_rate_factor", learning_rate_factor, 1))
    algorithm.SetGradientClip(at_least_0("clip", clip))
    algorithm.SetVertexWeight(at_least_0("vertex_weight", vertex_weight))
    algorithm.SetJacobianWeight(at_least_0("jacobian_weight", jacobian_weight))
    algorithm.SetWeightAveraging(in_range("averaging", averaging, 0.0, _LARGEST_AVERAGING))
    algorithm.SetSeed(integer("seed", seed, INT_MIN))
    algorithm.SetDevice(choice("device", device, DEVICES))
    milestones = [integer("milestones", milestone, 0) for milestone in milestones]
    algorithm.SetNumberOfMilestones(len(milestones))
    for number, milestone in enumerate(milestones):
        algorithm.SetMilestone(number, milestone)
    return algorithm


def connect(algorithm, source, samples, signal=None):
    """Gives a vtkFlowMatchingTrainer its inputs, which are not modified."""
    if algorithm.GetDatasetFileName():
        if source is not None or samples is not None:
            raise TypeError("a dataset is trained on in place of source and samples, which must not be given with it")
        return
    if source is None or samples is None:
        raise TypeError("source and samples are needed, or a dataset")
    source = given_dataset(source)
    if isinstance(samples, np.ndarray):
        samples = _surface_with(algorithm, source, samples, signal)
    elif isinstance(samples, (tuple, list)):
        blocks = vtkMultiBlockDataSet()
        for number, sample in enumerate(samples):
            blocks.SetBlock(number, _shallow_copy(given_dataset(sample)))
        samples = blocks
    else:
        text = "a composite dataset, a list of surfaces, a vtkPolyData or an array as samples"
        samples = given_dataset(samples, text=text)
    algorithm.SetInputDataObject(0, _shallow_copy(source))
    algorithm.SetInputDataObject(1, _shallow_copy(samples))


def losses_of(algorithm):
    """What train_flow_matching() returns, from a filter that has run."""
    table = algorithm.GetOutputDataObject(0)
    columns = {name: table.GetColumnByName(name) for name in
               ("iteration", "loss", "vertex_loss", "jacobian_loss", "gradient_norm", "learning_rate")}
    return {name: np.zeros(0) if column is None else vtk_to_numpy(column).copy() for name, column in columns.items()}


def _shallow_copy(dataset):
    """What pipelines leave on their inputs goes to this copy."""
    copy = dataset.NewInstance()
    copy.ShallowCopy(dataset)
    return copy


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
