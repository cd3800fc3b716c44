# SPDX-License-Identifier: BSD-3-Clause
"""The command ``train geometric-texture``."""

import argparse
import time

from ..deprecation import add_former_option
from .common import PROGRAM, add_running_options, add_training_files, as_usage, train_filter

_DESCRIPTION = """\
Learns a geometric texture from one surface at several scales. Everything random follows from the seed. A training that
was interrupted goes on from its checkpoint when the same command is given again."""
_EXAMPLES = """\
files:
  DATASET                 a dataset file (.safetensors), as the command levels writes it
  MODEL                   the model file that is written; MODEL.checkpoint and MODEL.csv are written beside it

examples:
  python3 -m surfacesynthesis levels bark.ply bark-levels.safetensors --iterations 500 --learning-rate 1e-2
  %(prog)s bark-levels.safetensors bark.safetensors --texture-name bark
"""
#: Options with a number: name, type, default, metavariable, help.
_NUMBERS = {
    "training": (
        ("iterations", int, 2000, "N", "iterations of each level"),
        ("discriminator-steps", int, 2, "N", "steps of the discriminator in an iteration"),
        ("generator-steps", int, 3, "N", "steps of the generator in an iteration"),
        ("learning-rate", float, 5e-4, "R", "of Adam"),
        ("learning-rate-interval", int, 500, "N", "iterations of a level after which it is multiplied, each time"),
        ("learning-rate-factor", float, 0.5, "F", "by this"),
        ("penalty-weight", float, 0.1, "W", "of the gradient penalty"),
        ("reconstruction-weight", float, 5.0, "W", "of the squared distance from the reference"),
        ("seed", int, 0, "N", "any integer of 32 bits"),
        ("checkpoint-interval", int, 500, "N", "iterations from one checkpoint to the next"),
    ),
    "network": (
        ("layers", int, 7, "N", "layers, input and output included"),
        ("start-channels", int, 32, "N", "channels of the first hidden layer at level 0"),
        ("minimum-channels", int, 32, "N", "channels of a hidden layer at least"),
        ("maximum-channels", int, 128, "N", "channels of a hidden layer at most"),
        ("noise-amplitude", float, 0.1, "A", "standard deviation of the noise, in mean edge lengths"),
    ),
}
#: Former names of options.
_FORMER = {"minimum-channels": "--least-channels", "maximum-channels": "--most-channels"}


def add(kinds):
    """Adds the kind of training to the parser of ``train``."""
    parser = kinds.add_parser(
        "geometric-texture",
        help="the geometric texture of a surface",
        usage=f"python3 -m {PROGRAM} train geometric-texture DATASET MODEL [options]",
        description=_DESCRIPTION,
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.set_defaults(run=run)
    parser.add_argument("dataset", metavar="DATASET", help="what is trained on")
    parser.add_argument("model", metavar="MODEL", help="the model that is written")
    texture_name = parser.add_argument(
        "--texture-name", default="texture", metavar="NAME", help="name of the texture (default: texture)"
    )
    for title, options in _NUMBERS.items():
        group = parser.add_argument_group(title)
        for name, kind, default, metavar, text in options:
            option = group.add_argument(
                f"--{name}", type=kind, default=default, metavar=metavar, help=f"{text} (default: %(default)s)"
            )
            if name in _FORMER:
                add_former_option(parser, _FORMER[name], option)
    parser.add_argument(
        "--device", default="auto", choices=["auto", "cpu", "cuda"], metavar="DEVICE", help="auto (default), cpu, cuda"
    )
    add_training_files(parser)
    add_former_option(parser, "--name", texture_name)
    add_running_options(parser.add_argument_group("running"))


def run(arguments):
    """The command ``train geometric-texture``; returns the line to print."""
    from ..geometric_texture_training import configured_trainer, texture_losses

    started = time.monotonic()
    numbers = {name.replace("-", "_") for options in _NUMBERS.values() for name, *_ in options}
    algorithm = as_usage(
        configured_trainer,
        arguments.model,
        dataset=arguments.dataset,
        texture_name=arguments.texture_name,
        checkpoint=arguments.checkpoint,
        losses=arguments.losses or f"{arguments.model}.csv",
        resume=not arguments.no_resume,
        device=arguments.device,
        **{name: getattr(arguments, name) for name in numbers},
    )
    train_filter(algorithm, arguments)
    losses = texture_losses(algorithm)["reconstruction_loss"]
    last = losses[-max(1, len(losses) // 20):].mean()
    seconds = time.monotonic() - started
    return (
        f"{len(losses):,} iterations, reconstruction loss {last:.4g}, {algorithm.GetDeviceInUse()}, {seconds:.1f} s"
        f" -> {algorithm.GetModelFileName()}"
    )
