# SPDX-License-Identifier: BSD-3-Clause
"""The command ``train geometric-texture``."""

import argparse

from ..deprecation import add_former_option
from .common import PROGRAM, as_usage
from .training import add_training_options, train_filter, training_outcome, training_parameters

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


def iterations_of_levels(text):
    """A number, or a list of as many as there are commas and one; raises ArgumentTypeError for other texts."""
    try:
        numbers = [int(number) for number in text.split(",")]
    except ValueError:
        raise argparse.ArgumentTypeError(
            f'"{text}" is neither a whole number nor one for each level, with commas between'
        ) from None
    return numbers[0] if len(numbers) == 1 else numbers


#: Options with a number: name, type, default, metavariable, help.
_NUMBERS = {
    "training": (
        ("iterations", iterations_of_levels, 2000, "N[,N...]", "iterations of each level, or one number for each"),
        ("flow-steps", int, 10, "N", "steps of a flow at each level of a synthesis"),
        ("base-noise-amplitude", float, 0.1, "A",
         "of a flow: largest noise of the level before in the training, in its mean edge lengths"),
        ("base-samples", int, 8, "N", "of a flow: samples of the level before that each level learns on; 0: the reference's own"),
        ("projections", int, 64, "N", "directions of the sliced Wasserstein distance in a step"),
        ("discriminator-steps", int, 2, "N", "steps of the discriminator in an iteration"),
        ("generator-steps", int, 3, "N", "steps of the generator in an iteration"),
        ("learning-rate-interval", int, 500, "N",
         "iterations of a level from one fall of the learning rate to the next; 0: a quarter of them"),
        ("learning-rate-factor", float, 0.5, "F", "factor of the learning rate"),
        ("penalty-weight", float, 0.1, "W", "of the gradient penalty"),
        ("penalty-interval", int, 1, "N", "steps of the discriminator from one gradient penalty to the next"),
        ("reconstruction-weight", float, 5.0, "W", "of the squared distance from the reference"),
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
    parser.add_argument(
        "--references",
        action="extend",
        nargs="+",
        default=[],
        metavar="DATASET",
        help="the same texture on other surfaces, of as many levels; each iteration draws one of all",
    )
    groups, options = add_training_options(parser, _NUMBERS)
    groups["training"].add_argument(
        "--objective",
        default="flow_matching",
        choices=["adversarial", "sliced_wasserstein", "flow_matching"],
        metavar="OBJECTIVE",
        help="what the generators learn by: flow_matching (default), adversarial, as published, or sliced_wasserstein",
    )
    for name, former in _FORMER.items():
        add_former_option(parser, former, options[name])
    add_former_option(parser, "--name", texture_name)


def run(arguments):
    """The command ``train geometric-texture``."""
    from ..geometric_texture_training import COLUMNS, add_reference_files, configured_trainer
    from ..training import losses_of

    algorithm = as_usage(
        configured_trainer,
        arguments.model,
        dataset=arguments.dataset,
        texture_name=arguments.texture_name,
        objective=arguments.objective,
        **training_parameters(arguments, _NUMBERS, arguments.model),
    )
    add_reference_files(algorithm, arguments.references)
    train_filter(algorithm, arguments)
    losses = losses_of(algorithm, COLUMNS)["reconstruction_loss"]
    is_flow = arguments.objective == "flow_matching"
    return training_outcome(algorithm, losses, "velocity loss" if is_flow else "reconstruction loss")
