# SPDX-License-Identifier: BSD-3-Clause
"""The command ``train latent-diffusion``, and the options of surfaces that ``dataset latents`` shares with it."""

import argparse
import os

from .common import PROGRAM, UsageError, as_usage
from .training import add_training_options, train_filter, training_outcome, training_parameters

_DESCRIPTION = """\
Trains a diffusion model of field latents, with which sample-texture makes new textures, on one textured surface. Everything
random follows from the seed. A training that was interrupted goes on from its checkpoint when the same command is given
again."""
_EXAMPLES = """\
files:
  DATASET.safetensors     a dataset file, as the command dataset latents writes it
  SURFACE                 a textured surface: .obj (with .mtl and an image) .gltf .glb .ply, any surface with texture
                          coordinates and --image, or any surface with colors at its points
  MODEL                   the model file that is written; MODEL.checkpoint and MODEL.csv are written beside it

examples:
  %(prog)s duck.obj bark.safetensors --autoencoder latents.safetensors --triangulations 64 --points 5000
  %(prog)s bark-latents.safetensors bark-model.safetensors --iterations 300000 --batch 16
"""
_AS_SIZES = "0: as sizes"
#: Options with a number: name, type, default, metavariable, help.
_NUMBERS = {
    "training": (
        ("iterations", int, 20000, "N", "iterations in all, those of a checkpoint included"),
        ("batch", int, 4, "N", "surfaces in an iteration"),
        ("learning-rate", float, 1e-3, "R", "of the optimizer"),
        ("final-learning-rate", float, 1e-5, "R", "at the end, along half a cosine"),
        ("clip", float, 1.0, "G", "largest norm of the gradient, 0: none"),
        ("averaging", float, 0.999, "A", "of the weights, below 1; 0: none"),
        ("snr-limit", float, 0.0, "G", "of the weights of the loss, 0: plain mean square"),
        ("condition-dropout", float, 0.1, "P", "part of the surfaces without labels and directions"),
    ),
    "network": (
        ("channels", int, 0, "N", f"on the surface, {_AS_SIZES}"),
        ("coarse-channels", int, 0, "N", f"on the coarser level, {_AS_SIZES}"),
        ("input-blocks", int, 0, "N", f"before the pooling, {_AS_SIZES}"),
        ("coarse-blocks", int, 0, "N", f"on the coarser level, {_AS_SIZES}"),
        ("output-blocks", int, 0, "N", f"after the unpooling, {_AS_SIZES}"),
        ("embedding-dimension", int, 64, "N", "numbers of the embedding of time and labels, even"),
        ("time-steps", int, 1000, "N", "of the forward process"),
        ("first-variance", float, 1e-4, "V", "of its first step"),
        ("last-variance", float, 0.02, "V", "of its last step"),
    ),
}


def add(kinds):
    """Adds the kind of training to the parser of ``train``."""
    parser = kinds.add_parser(
        "latent-diffusion",
        help="new textures, from one textured surface",
        usage=f"python3 -m {PROGRAM} train latent-diffusion (DATASET.safetensors | SURFACE) MODEL [options]",
        description=_DESCRIPTION,
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.set_defaults(run=run)
    parser.add_argument("input", metavar="SURFACE", help="what is trained on")
    parser.add_argument("model", metavar="MODEL", help="the model that is written")
    groups, _ = add_training_options(parser, _NUMBERS)
    groups["training"].add_argument(
        "--no-sample-latents", action="store_true", help="train on the means of latents, not on draws from their Gaussians"
    )
    groups["training"].add_argument(
        "--sample", metavar="FILE", help="PNG image, written with each checkpoint: a texture of SURFACE, sampled with the model so far"
    )
    groups["training"].add_argument(
        "--optimizer",
        default="adam",
        choices=["adam", "muon"],
        metavar="NAME",
        help="adam (default), as published, or muon for the complex matrices inside the network and adam for the rest",
    )
    add_surface_options(parser.add_argument_group("surface"))
    for name, choices, text in (
        ("--sizes", ["small", "paper"], "sizes that are not given: small (default) or paper"),
        ("--target", ["noise", "data", "velocity"], "what the network predicts: noise (default), data or velocity"),
    ):
        groups["network"].add_argument(name, default=choices[0], choices=choices, metavar=name[2:].upper(), help=text)


def add_surface_options(group):
    """Adds the options of a textured surface and its triangulations."""
    group.add_argument("--image", metavar="FILE", help="texture, in place of the one that the file names")
    group.add_argument(
        "--autoencoder",
        default="field_latents",
        metavar="FILE",
        help="model file of field latents, or the name of an installed model (default: field_latents)",
    )
    group.add_argument("--triangulations", type=int, default=16, metavar="N", help="of the surface (default: 16)")
    group.add_argument("--points", type=int, default=3000, metavar="N", help="vertices of each, about (default: 3000)")
    group.add_argument("--label", metavar="NAME", help="point array with labels that guide samples")
    group.add_argument("--direction", metavar="NAME", help="point array with vectors that guide samples")


def surface_parameters(arguments):
    """The keywords for the options that add_surface_options() has added, without the image."""
    names = ("autoencoder", "triangulations", "points", "label", "direction")
    return {name: getattr(arguments, name) for name in names}


def run(arguments):
    """The command ``train latent-diffusion``."""
    from ..latent_diffusion_training import COLUMNS
    from ..training import losses_of

    algorithm = _filter_of(arguments)
    train_filter(algorithm, arguments)
    losses = losses_of(algorithm, COLUMNS)["loss"]
    return training_outcome(algorithm, losses, "loss")


def _is_one_of(path, others):
    """True when a path is that of a file among ``others``, which may be None."""
    return any(other is not None and os.path.realpath(path) == os.path.realpath(other) for other in others)


def _filter_of(arguments):
    """The filter with its options and inputs."""
    from ..latent_diffusion_training import configured_filter, connect
    from .field_latents import color_of, textured_input

    from_dataset = arguments.input.endswith(".safetensors")
    if from_dataset and arguments.sample is not None:
        raise UsageError("--sample is a texture of SURFACE, which a dataset does not have")
    if arguments.sample is not None and _is_one_of(arguments.sample, (arguments.input, arguments.image)):
        raise UsageError("--sample would be written over an input; name another file")
    if from_dataset and arguments.image is not None:
        raise UsageError("a dataset has its latents; --image belongs to a surface")
    mesh, image = (None, None) if from_dataset else textured_input(arguments)
    algorithm = as_usage(
        configured_filter,
        arguments.model,
        dataset=arguments.input if from_dataset else None,
        color=None if from_dataset or image is not None else color_of(mesh),
        sizes=arguments.sizes,
        target=arguments.target,
        optimizer=arguments.optimizer,
        sample_latents=not arguments.no_sample_latents,
        sample=arguments.sample,
        **surface_parameters(arguments),
        **training_parameters(arguments, _NUMBERS, arguments.model),
    )
    if not from_dataset:
        connect(algorithm, mesh, image)
    return algorithm
