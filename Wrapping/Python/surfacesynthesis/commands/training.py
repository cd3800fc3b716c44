# SPDX-License-Identifier: BSD-3-Clause
"""The options and the run that all commands ``train`` share."""

import os
import sys
import warnings

from .common import Outcome, TrainingBar, add_running_options, printed_message, set_threads

#: Options with a number that all trainings have: name, type, default, metavariable, help.
_SHARED_NUMBERS = (
    ("learning-rate", float, 5e-4, "R", "of the optimizer"),
    ("seed", int, 0, "N", "any integer of 32 bits"),
    ("time-budget", float, 0.0, "M", "minutes, after which the files are written; the same command then goes on; 0: no limit"),
    ("checkpoint-interval", int, 500, "N", "iterations from one checkpoint to the next"),
)


def add_training_options(parser, numbers):
    """Adds the options of a training to its parser: ``numbers``, rows as above by the title of their group, and the
    options of all trainings, but for those that ``numbers`` has with another default.

    Returns the groups by title, and the options with a number by name.
    """
    groups, options = {}, {}
    own = {name for rows in numbers.values() for name, *_ in rows}
    shared = [row for row in _SHARED_NUMBERS if row[0] not in own]
    for title, rows in numbers.items():
        groups[title] = parser.add_argument_group(title)
        for name, kind, default, metavar, text in [*rows, *(shared if title == "training" else ())]:
            options[name] = groups[title].add_argument(
                f"--{name}", type=kind, default=default, metavar=metavar, help=f"{text} (default: %(default)s)"
            )
    groups["training"].add_argument(
        "--device",
        default="auto",
        choices=["auto", "cpu", "cuda"],
        metavar="DEVICE",
        help="auto (default: cuda where LibTorch finds a device), cpu, cuda",
    )
    files = parser.add_argument_group("files")
    files.add_argument(
        "--checkpoint", metavar="FILE", help="file to go on from, and to write (default: MODEL.checkpoint)"
    )
    files.add_argument("--losses", metavar="FILE", help="table of the losses, CSV (default: MODEL.csv)")
    files.add_argument("--no-resume", action="store_true", help="begin anew, and replace the checkpoint")
    add_running_options(parser.add_argument_group("running"))
    return groups, options


def training_parameters(arguments, numbers, model):
    """The keywords of a function of the package for the options that add_training_options() has added."""
    names = [name for rows in [*numbers.values(), _SHARED_NUMBERS] for name, *_ in rows]
    return {
        "checkpoint": arguments.checkpoint,
        "losses": arguments.losses or f"{model}.csv",
        "resume": not arguments.no_resume,
        "device": arguments.device,
        **{name.replace("-", "_"): getattr(arguments, name.replace("-", "_")) for name in names},
    }


def train_filter(algorithm, arguments, checkpoints=()):
    """Runs a training filter with a progress bar; its warnings are issued. Ctrl-C names the checkpoint that is kept:
    the first of ``checkpoints``, by default that of the model, that is there."""
    from ..errors import SurfaceSynthesisWarning
    from ..pipeline import run_algorithm

    set_threads(arguments.threads)
    bar = TrainingBar(sys.stderr, not (arguments.no_progress or arguments.quiet), algorithm)
    try:
        remarks = run_algorithm(algorithm, bar, message=printed_message(arguments, bar))
    except KeyboardInterrupt:
        places = checkpoints or [checkpoint_of(algorithm)]
        kept = [f"; the same command goes on from {path}" for path in places if os.path.exists(path)]
        raise KeyboardInterrupt("".join(["interrupted", *kept[:1]])) from None
    finally:
        bar.clear()
    for text in remarks:
        warnings.warn(text, SurfaceSynthesisWarning, stacklevel=2)


def checkpoint_of(algorithm):
    """The path of the checkpoint of a model."""
    return algorithm.GetCheckpointFileName() or algorithm.GetModelFileName() + ".checkpoint"


def training_outcome(algorithm, losses, name, before="", **values):
    """The outcome of a training: iterations, the mean of the last twentieth of ``losses``, the device and the files."""
    last, device = losses[-max(1, len(losses) // 20) :].mean(), algorithm.GetDeviceInUse()
    values.update({"iterations": len(losses), name.replace(" ", "_"): last, "device": device})
    text = f"{len(losses):,} iterations, {before}{name} {last:.4g}, {device}"
    return Outcome(text, {**values, **_files_of(algorithm)}, [algorithm.GetModelFileName()])


def _files_of(algorithm):
    """The files beside the model that were written, by name."""
    files = {"checkpoint": checkpoint_of(algorithm), "losses": algorithm.GetLossTableFileName()}
    return {name: path if path and os.path.exists(path) else None for name, path in files.items()}
