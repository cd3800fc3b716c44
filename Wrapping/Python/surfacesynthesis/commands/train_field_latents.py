# SPDX-License-Identifier: BSD-3-Clause
"""The command ``train field-latents``."""

import argparse

from .common import PROGRAM, UsageError, as_usage
from .training import add_training_options, train_filter, training_outcome, training_parameters

_DESCRIPTION = """\
Trains the autoencoder of field latents, which encode-texture and decode-texture apply, on images. Everything random
follows from the seed. A training that was interrupted goes on from its checkpoint when the same command is given again."""
_EXAMPLES = """\
files:
  DATASET.safetensors     a dataset file, as the command dataset textures writes it
  IMAGE                   an image file: .png .jpg .tif .bmp ..., at least 16 x 16 pixels
  MODEL                   the model file that is written; MODEL.checkpoint and MODEL.csv are written beside it

examples:
  python3 -m surfacesynthesis dataset textures brick.png grass.png textures.safetensors --meshes 8
  %(prog)s textures.safetensors textures-model.safetensors --iterations 100000
  %(prog)s brick.png grass.png model.safetensors --time-budget 60
"""
_AS_SIZES = "0: as sizes"
#: Options with a number: name, type, default, metavariable, help.
_NUMBERS = {
    "training": (
        ("iterations", int, 100000, "N", "iterations in all, those of a checkpoint included"),
        ("batch", int, 48, "N", "rings in an iteration, with barycentric coordinates a multiple of 3"),
        ("learning-rate", float, 1e-3, "R", "of Adam"),
        ("final-learning-rate", float, 1e-5, "R", "at the end, along half a cosine"),
        ("divergence-weight", float, 0.01, "W", "of the Kullback-Leibler divergence"),
        ("minimum-texels", float, 10.0, "N", "pixels for a vertex at least"),
        ("maximum-texels", float, 150.0, "N", "pixels for a vertex at most"),
        ("target-power", float, 0.0, "K", "density of the loss's points in a ring: the vertex' coordinate to this power"),
        ("color-augmentation", float, 0.0, "P", "part of the rings whose colors are changed, 0 to 1"),
        ("clip", float, 1.0, "G", "largest norm of the gradient, 0: none"),
    ),
    "planar meshes": (
        ("meshes", int, 64, "N", "meshes that are laid over images; a dataset has its own"),
        ("mesh-points", int, 2500, "N", "points of each"),
    ),
    "network": (
        ("latent-dimension", int, 0, "N", f"tangent vectors of a latent code, {_AS_SIZES}"),
        ("channels", int, 0, "N", f"channels of the encoder, {_AS_SIZES}"),
        ("encoder-layers", int, 0, "N", f"layers of the encoder, {_AS_SIZES}"),
        ("heads", int, 0, "N", f"heads of its attention, divide the channels, {_AS_SIZES}"),
        ("samples-per-ring", int, 0, "N", f"points of a ring that it sees, {_AS_SIZES}"),
        ("decoder-layers", int, 0, "N", f"hidden layers of the decoder, {_AS_SIZES}"),
        ("decoder-width", int, 0, "N", f"their channels, {_AS_SIZES}"),
    ),
}


def add(kinds):
    """Adds the kind of training to the parser of ``train``."""
    parser = kinds.add_parser(
        "field-latents",
        help="textures as tangent vectors, from images",
        usage=f"python3 -m {PROGRAM} train field-latents (DATASET.safetensors | IMAGE...) MODEL [options]",
        description=_DESCRIPTION,
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.set_defaults(run=run)
    parser.add_argument("files", metavar="FILE", nargs="+", help="what is trained on, and the model that is written")
    groups, _ = add_training_options(parser, _NUMBERS)
    for name, choices, text in (
        ("--sizes", ["small", "paper"], "sizes that are not given: small (default) or paper"),
        ("--coordinates", ["logarithmic", "barycentric"], "of a texel: logarithmic (default) or, for comparison, barycentric"),
    ):
        groups["network"].add_argument(name, default=choices[0], choices=choices, metavar=name[2:].upper(), help=text)


def run(arguments):
    """The command ``train field-latents``."""
    from ..field_latent_training import COLUMNS
    from ..training import losses_of

    algorithm = _filter_of(arguments)
    train_filter(algorithm, arguments)
    losses = losses_of(algorithm, COLUMNS)["reconstruction_loss"]
    return training_outcome(algorithm, losses, "reconstruction loss")


def _filter_of(arguments):
    """The filter with its options and inputs."""
    from ..field_latent_training import configured_filter, connect

    *given, model = arguments.files
    if not given:
        raise UsageError("train field-latents needs DATASET.safetensors MODEL, or IMAGE... MODEL")
    from_dataset = len(given) == 1 and given[0].endswith(".safetensors")
    algorithm = as_usage(
        configured_filter,
        model,
        dataset=given[0] if from_dataset else None,
        sizes=arguments.sizes,
        coordinates=arguments.coordinates,
        **training_parameters(arguments, _NUMBERS, model),
    )
    if not from_dataset:
        connect(algorithm, given)
    return algorithm
