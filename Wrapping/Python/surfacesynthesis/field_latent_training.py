# SPDX-License-Identifier: BSD-3-Clause
"""Training of field latents: a function around vtkFieldLatentTrainer."""

from vtkmodules.vtkCommonDataModel import vtkDataObjectTree, vtkImageData, vtkMultiBlockDataSet

from . import training
from .arguments import at_least_0, at_most, choice, positive, progress_callback
from .field_latents import image_of_array
from .texture_datasets import image_array
from .training import LARGEST_LEARNING_RATE, count, shallow_copy
from .vtkSurfaceSynthesisTraining import vtkFieldLatentTrainer

#: Sizes of the networks, by the name that ``sizes`` takes.
SIZES = {"small": vtkFieldLatentTrainer.SMALL, "paper": vtkFieldLatentTrainer.PAPER}
#: Coordinates that the decoder sees, by the name that ``coordinates`` takes.
COORDINATES = {"logarithmic": vtkFieldLatentTrainer.LOGARITHMIC, "barycentric": vtkFieldLatentTrainer.BARYCENTRIC}

#: The columns of the losses.
COLUMNS = ("iteration", "loss", "reconstruction_loss", "divergence_loss", "gradient_norm", "learning_rate")


@training.documented(COLUMNS, learning_rate="1e-3")
def train_field_latents(images=None, *, model, dataset=None, progress=None, **options):
    """Trains the autoencoder of field latents, which encode_texture() and decode_texture() apply, on images.

    Parameters
    ----------
    images : list of images, image or composite dataset, optional
        Each a vtkImageData of one slice with colors as active point scalars, an array [H, W] or [H, W, C] with C from 1
        to 4 of uint8, uint16 or of floating-point numbers from 0 to 1, or an image file that VTK reads (.png, .jpg, .tif,
        ...); of at least 16 x 16 pixels. Alpha is left out. Images are not reduced: texture_dataset() reduces and cuts
        them. They are not modified.
    model : path
        The model file that is written, safetensors.
    dataset : path, optional
        A dataset file that is trained on in place of ``images``, as texture_dataset() writes it.
    meshes, mesh_points : int
        Number of planar meshes that are laid over the images, and of points of each; not used with a dataset. Default 64
        and 2500.
    sizes : str
        Sizes of the networks that are not given: "small", which two processor cores train in hours, or "paper". Default
        "small".
    latent_dimension, channels, encoder_layers, heads, samples_per_ring, decoder_layers, decoder_width : int
        Tangent vectors of a latent code; channels, layers and heads of the encoder, and samples in a ring; hidden layers of
        the decoder and their channels. Default 0 each: as ``sizes``.
    coordinates : str
        Coordinates of a texel that the decoder sees: "logarithmic" or, for comparison, "barycentric". Default
        "logarithmic".
    iterations, batch : int
        Iterations in all, those of a checkpoint included; rings in each, a multiple of 3 with "barycentric". Default
        100000 and 48.
    final_learning_rate : float
        Learning rate at the end, to which it falls along half a cosine. Default 1e-5.
    divergence_weight : float
        Weight of the Kullback-Leibler divergence in the loss. Default 0.01.
    minimum_texels, maximum_texels : float
        Range of the number of pixels for a vertex. Default 10 and 150.
    target_power : float
        Power k of the density of the loss's points in a ring: b^k, where b is the barycentric coordinate of its vertex.
        With 2 the loss measures errors as they enter texels. Default 0: uniform, as in the paper.
    color_augmentation : float
        Part of the rings whose colors are changed, from 0 to 1: the channels are permuted, and the range of each becomes
        a random one. Photographs have few saturated colors, and textures of models many. Default 0.
    clip : float
        Largest norm of the gradient of all weights together; 0 for no limit. Default 1.
    (shared parameters)
    """
    progress_callback(progress)
    algorithm = configured_filter(model, dataset, **options)
    connect(algorithm, images)
    return training.run(algorithm, COLUMNS, progress)


@training.with_shared_parameters
def configured_filter(
    model,
    dataset=None,
    meshes=64,
    mesh_points=2500,
    sizes="small",
    latent_dimension=0,
    channels=0,
    encoder_layers=0,
    heads=0,
    samples_per_ring=0,
    decoder_layers=0,
    decoder_width=0,
    coordinates="logarithmic",
    iterations=100000,
    batch=48,
    learning_rate=1e-3,
    final_learning_rate=1e-5,
    divergence_weight=0.01,
    minimum_texels=10.0,
    maximum_texels=150.0,
    target_power=0.0,
    color_augmentation=0.0,
    clip=1.0,
    **shared,
):
    """A vtkFieldLatentTrainer with the parameters of train_field_latents(); ``shared`` are those of training.configure().

    Raises TypeError and ValueError.
    """
    algorithm = training.configure(vtkFieldLatentTrainer(), model, dataset, learning_rate=learning_rate, **shared)
    algorithm.SetNumberOfMeshes(count("meshes", meshes, 1, 100000))
    algorithm.SetMeshPoints(count("mesh_points", mesh_points, 16, 1000000))
    algorithm.SetSizes(choice("sizes", sizes, SIZES))
    algorithm.SetLatentDimension(count("latent_dimension", latent_dimension, 0, 256))
    algorithm.SetChannels(count("channels", channels, 0, 4096))
    algorithm.SetEncoderLayers(count("encoder_layers", encoder_layers, 0, 256))
    algorithm.SetHeads(count("heads", heads, 0, 4096))
    algorithm.SetSamplesPerRing(count("samples_per_ring", samples_per_ring, 0, 65536))
    algorithm.SetDecoderLayers(count("decoder_layers", decoder_layers, 0, 256))
    algorithm.SetDecoderWidth(count("decoder_width", decoder_width, 0, 65536))
    algorithm.SetCoordinates(choice("coordinates", coordinates, COORDINATES))
    algorithm.SetIterations(count("iterations", iterations, 1, 100000000))
    algorithm.SetBatchSize(count("batch", batch, 1, 1000000))
    final_learning_rate = positive("final_learning_rate", final_learning_rate)
    algorithm.SetFinalLearningRate(at_most("final_learning_rate", final_learning_rate, LARGEST_LEARNING_RATE))
    algorithm.SetDivergenceWeight(at_least_0("divergence_weight", divergence_weight))
    algorithm.SetMinimumTexels(positive("minimum_texels", minimum_texels))
    algorithm.SetMaximumTexels(positive("maximum_texels", maximum_texels))
    algorithm.SetTargetPower(at_least_0("target_power", target_power))
    part = at_most("color_augmentation", at_least_0("color_augmentation", color_augmentation), 1.0)
    algorithm.SetColorAugmentation(part)
    algorithm.SetGradientClip(at_least_0("clip", clip))
    return algorithm


def connect(algorithm, images):
    """Gives a vtkFieldLatentTrainer its images, which are not modified."""
    if training.uses_dataset_file(algorithm, images=images):
        return
    if images is None:
        raise TypeError("images are needed, or a dataset")
    if isinstance(images, vtkDataObjectTree):
        algorithm.SetInputDataObject(0, shallow_copy(images))
        return
    blocks = vtkMultiBlockDataSet()
    for number, image in enumerate(images if isinstance(images, (tuple, list)) else [images]):
        blocks.SetBlock(number, _image(image))
    algorithm.SetInputDataObject(0, blocks)


def _image(image):
    """A vtkImageData of an image, a copy that shares its arrays; raises FormatError, OSError, TypeError and ValueError."""
    return shallow_copy(image) if isinstance(image, vtkImageData) else image_of_array(image_array(image))
