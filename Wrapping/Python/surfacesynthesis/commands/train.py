# SPDX-License-Identifier: BSD-3-Clause
"""The command ``train``."""

import argparse

from ..deprecation import add_former_option
from . import train_field_latents, train_geometric_texture, train_latent_diffusion
from .common import PROGRAM, Outcome, UsageError, as_usage, read_surface
from .training import add_training_options, checkpoint_of, train_filter, training_outcome, training_parameters

_DESCRIPTION = """\
Trains a flow matching model on deformations of a surface, or on another signal on it. Everything random follows from
the seed. A training that was interrupted goes on from its checkpoint when the same command is given again."""
_EXAMPLES = """\
files:
  DATASET.safetensors     a dataset file, which holds surfaces and samples
  SOURCE                  the surface that the samples are on: .stl .ply .obj .off .gii .glb .vtp .vtk .vtm; or
                          several, the surfaces of a .vtm
  SAMPLES                 one file for each sample, or one with a composite dataset, whose surfaces are the samples;
                          with several sources a .vtm with a block of samples for each
  MODEL                   the model file that is written; MODEL.checkpoint and MODEL.csv are written beside it

examples:
  %(prog)s poses.safetensors poses-model.safetensors --width 48 --blocks 3
  %(prog)s neutral.ply faces_*.ply faces.safetensors --width 128 --blocks 5
  %(prog)s heart.vtp heart.vtp heat.safetensors --signal Heat
  %(prog)s bodies.safetensors model.safetensors --encoder-iterations 20000
"""
#: Options with a number: name, type, default, metavariable, help.
_NUMBERS = {
    "training": (
        ("iterations", int, 3000, "N", "iterations in all, those of a checkpoint included"),
        ("batch", int, 32, "N", "samples in an iteration"),
        ("learning-rate", float, 0.02, "R", "of the optimizer"),
        ("sources-per-batch", int, 1, "N", "surfaces that they come from"),
        ("source-memory", float, 8192.0, "MIB", "limit of the factorisations of surfaces that are kept"),
        ("learning-rate-factor", float, 0.2, "F", "factor of the learning rate at each milestone"),
        ("clip", float, 1.0, "G", "largest norm of the gradient, 0: none"),
        ("vertex-weight", float, 1.0, "W", "of the loss in velocities"),
        ("jacobian-weight", float, 1.0, "W", "of the loss in their gradients"),
        ("averaging", float, 0.99, "A", "of the weights, below 1; 0: none"),
    ),
    "network": (
        ("width", int, 64, "N", "hidden channels"),
        ("blocks", int, 4, "N", "blocks of the network"),
        ("layers", int, 3, "N", "layers of the maps between gradients"),
    ),
    "encoder": (
        ("encoder-iterations", int, 0, "N", "iterations in which it is trained before the model, 0: none"),
        ("eigenfunctions", int, 64, "N", "of the first source, which the encoder that is trained predicts"),
        ("encoder-edge-splits", float, 0.0, "F", "largest part of the edges that its training splits at random"),
    ),
    "noise": (
        ("screening", float, 100.0, "TAU", "tau of the noise on the surface scaled to area 1"),
        ("noise-smoothing", float, -1.0, "S", "in squared mean edge lengths; negative: 0 for positions, 1 for other signals"),
        ("noise-scale", float, 0.0, "S", "what the noise is multiplied by, 0: such that it varies as the samples do"),
        ("eigenpairs", int, 256, "K", "of spectral noise"),
    ),
}


def add(commands):
    """Adds the command to the parser."""
    parser = commands.add_parser(
        "train",
        help="train a generative model on examples",
        usage=f"python3 -m {PROGRAM} train WHAT ...",
        description="Trains a generative model on examples.",
    )
    kinds = parser.add_subparsers(title="models", metavar="WHAT", required=True, prog=f"python3 -m {PROGRAM} train")
    training = kinds.add_parser(
        "flow-matching",
        help="deformations of a surface, or other signals on it, from noise",
        usage=f"python3 -m {PROGRAM} train flow-matching (DATASET.safetensors | SOURCE SAMPLES...) MODEL [options]",
        description=_DESCRIPTION,
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    training.set_defaults(run=run)
    training.add_argument("files", metavar="FILE", nargs="+", help="what is trained on, and the model that is written")
    training.add_argument("--signal", metavar="NAME", help="point array that is learnt (default: the positions)")
    groups, _ = add_training_options(training, _NUMBERS)
    add_former_option(training, "--noise", _add_choices(groups))
    train_geometric_texture.add(kinds)
    train_field_latents.add(kinds)
    train_latent_diffusion.add(kinds)


def _add_choices(groups):
    """Adds the options that are no numbers; returns that of the noise model, which has a former name."""
    groups["training"].add_argument(
        "--milestone",
        type=int,
        action="append",
        default=[],
        metavar="N",
        dest="milestones",
        help="iteration after which the learning rate falls with the schedule milestones; may be given several times "
        "(default: a quarter of all)",
    )
    groups["training"].add_argument(
        "--optimizer",
        default="muon",
        choices=["adam", "muon"],
        metavar="NAME",
        help="muon (default) at learning rates of 0.01 to 0.02, or adam, as published, at 0.0005, which takes several times "
        "as many iterations",
    )
    groups["training"].add_argument(
        "--schedule",
        default="cosine",
        choices=["milestones", "cosine"],
        metavar="COURSE",
        help="of the learning rate: cosine (default), which rises over the first hundredth of all iterations and falls to 0 "
        "along half a cosine, or milestones, as published",
    )
    groups["training"].add_argument(
        "--initial-model",
        metavar="FILE",
        help="model whose weights the training begins with; noise, prediction and network are then its own, and so is the "
        "encoder without --encoder",
    )
    groups["network"].add_argument(
        "--prediction",
        default="automatic",
        choices=["automatic", "velocity", "data", "preconditioned"],
        metavar="WHAT",
        help="what it predicts: data, the end of the flow relative to the source, preconditioned, a mixture of data and noise, "
        "or velocity, as published; automatic (default) is data for positions, preconditioned for other signals",
    )
    groups["network"].add_argument(
        "--inner-products", action="store_true", help="features of inner products of gradients as well"
    )
    groups["encoder"].add_argument(
        "--encoder",
        metavar="FILE",
        help="PoissonNet that predicts a positional encoding, for sources of different shape; written with "
        "--encoder-iterations (default then: MODEL.encoder), else read",
    )
    groups["encoder"].add_argument(
        "--without-encoder", action="store_true", help="sources of different shape without an encoder, for comparison"
    )
    noise_model = groups["noise"].add_argument(
        "--noise-model",
        default="matern",
        choices=["matern", "per_vertex", "white", "unscreened", "spectral"],
        metavar="NOISE",
        help="matern (default) or, for comparison, per_vertex, white, unscreened, spectral",
    )
    return noise_model


def run(arguments):
    """The command ``train flow-matching``."""
    from ..flow_matching_training import COLUMNS
    from ..training import losses_of

    algorithm = _filter_of(arguments)
    train_filter(algorithm, arguments, _checkpoints(algorithm))
    losses = losses_of(algorithm, COLUMNS)["loss"]
    encoder_loss = algorithm.GetEncoderLoss() if algorithm.GetEncoderLoss() >= 0 else None
    if len(losses) == 0:
        text = "nothing to train on" if encoder_loss is None else f"encoder loss {encoder_loss:.4g}, no model yet"
        return Outcome(text, {"iterations": 0, "encoder_loss": encoder_loss})
    encoder = f"encoder loss {algorithm.GetEncoderLoss():.4g}, " if algorithm.GetEncoderIterations() > 0 else ""
    return training_outcome(algorithm, losses, "loss", encoder, encoder_loss=encoder_loss)


def _filter_of(arguments):
    """The filter with its options and inputs."""
    from ..flow_matching_training import configured_filter, connect

    *given, model = arguments.files
    from_dataset = len(given) == 1 and given[0].endswith(".safetensors")
    if not from_dataset and len(given) < 2:
        raise UsageError("train flow-matching needs DATASET.safetensors MODEL, or SOURCE SAMPLES... MODEL")
    algorithm = as_usage(
        configured_filter,
        model,
        dataset=given[0] if from_dataset else None,
        signal=arguments.signal,
        encoder=arguments.encoder,
        initial_model=arguments.initial_model,
        inner_products=arguments.inner_products,
        prediction=arguments.prediction,
        optimizer=arguments.optimizer,
        schedule=arguments.schedule,
        noise_model=arguments.noise_model,
        milestones=arguments.milestones,
        **training_parameters(arguments, _NUMBERS, model),
    )
    if not from_dataset:
        source, *samples = [read_surface(path) for path in given]
        as_usage(connect, algorithm, source, samples[0] if len(samples) == 1 else samples)
    return algorithm


def _checkpoints(algorithm):
    """The paths of two checkpoints: of the model, and of an encoder that is trained before it."""
    checkpoints = [checkpoint_of(algorithm)]
    if algorithm.GetEncoderIterations() > 0:
        encoder = algorithm.GetEncoderFileName() or algorithm.GetModelFileName() + ".encoder"
        checkpoints.append(encoder + ".checkpoint")
    return checkpoints
