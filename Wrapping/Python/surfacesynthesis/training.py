# SPDX-License-Identifier: BSD-3-Clause
"""The parameters, the run and the losses that all trainings share: functions around vtkModelTrainer."""

import inspect
import textwrap
import warnings

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy

from .arguments import INT_MIN, at_least_0, at_most, choice, flag, integer, optional_path, positive
from .errors import SurfaceSynthesisWarning
from .pipeline import run_algorithm
from .vtkSurfaceSynthesisTraining import vtkModelTrainer

#: Above it single precision has no room for a step.
LARGEST_LEARNING_RATE = 1e30
#: The devices of a training, by the name that ``device`` takes.
DEVICES = {
    "auto": vtkModelTrainer.AUTO,
    "cpu": vtkModelTrainer.CPU,
    "cuda": vtkModelTrainer.CUDA,
}

#: The line of a docstring that documented() replaces.
_PLACE = "    (shared parameters)\n"
_PARAMETERS = """\
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the training stops, and a
        checkpoint is written first. A training of a minute or more says once, after its first iterations, the time to
        expect, in the log "surfacesynthesis" of the module logging.
    checkpoint : path, optional
        The checkpoint. Default: ``model`` with .checkpoint after it.
    losses : path, optional
        A table of the losses in comma-separated values, written with each checkpoint. Default: none.
    checkpoint_interval : int
        Number of iterations from one checkpoint to the next. Default 500.
    resume : bool
        Continuation of the training from the checkpoint where there is one. Default True.
    time_budget : float
        Time budget of the call in minutes; 0 for no limit. When it is used up, the files are written as at the end, and a
        warning says the time that the other iterations take; the next call goes on from there. Default 0.
    learning_rate : float
        Learning rate of the optimizer. Default 5e-4.
    seed : int
        Any integer of 32 bits. Default 0.
    device : str
        "auto", "cpu" or "cuda". Default "auto".
"""
_RETURNS = """\

    Returns
    -------
    dict of arrays
"""
_RAISES = """\

    Raises
    ------
    SurfaceSynthesisError
        The text names the defect of the surfaces, the options together, or a file.
    Cancelled
        ``progress`` returned False.
    ValueError, TypeError
        An argument has a value out of its range or is of a wrong type.
    """


def documented(columns, learning_rate="5e-4"):
    """A decorator that ends the docstring of a training: shared parameters, losses in ``columns``, errors. The default of
    the learning rate is ``learning_rate``."""
    names = ", ".join(f'"{name}"' for name in columns[:-1]) + f' and "{columns[-1]}"'
    text = f"{names}, with a number for each iteration. Empty arrays for empty inputs, of which no model is written."
    parameters = _PARAMETERS.replace("Default 5e-4", f"Default {learning_rate}")
    lines = textwrap.fill(text, 119, initial_indent=8 * " ", subsequent_indent=8 * " ")

    def decorate(function):
        if function.__doc__:  # absent with python -OO
            before, _ = function.__doc__.split(_PLACE)
            function.__doc__ = f"{before}{parameters}{_RETURNS}{lines}\n{_RAISES}"
        return function

    return decorate


def with_shared_parameters(function):
    """A decorator that shows the parameters of configure() in the signature of a function that takes them as **shared."""
    own = [p for p in inspect.signature(function).parameters.values() if p.kind is not p.VAR_KEYWORD]
    names = {parameter.name for parameter in own} | {"algorithm"}
    shared = [p for name, p in inspect.signature(configure).parameters.items() if name not in names]
    function.__signature__ = inspect.Signature(own + shared)
    return function


def configure(
    algorithm,
    model,
    dataset=None,
    checkpoint=None,
    losses=None,
    checkpoint_interval=500,
    resume=True,
    time_budget=0.0,
    learning_rate=5e-4,
    seed=0,
    device="auto",
):
    """Gives the shared parameters to a vtkModelTrainer and returns it; raises TypeError and ValueError."""
    algorithm.SetModelFileName(optional_path("model", model))
    algorithm.SetDatasetFileName(optional_path("dataset", dataset))
    algorithm.SetCheckpointFileName(optional_path("checkpoint", checkpoint))
    algorithm.SetLossTableFileName(optional_path("losses", losses))
    algorithm.SetCheckpointInterval(integer("checkpoint_interval", checkpoint_interval, 1))
    algorithm.SetResume(flag("resume", resume))
    algorithm.SetTimeBudget(at_least_0("time_budget", time_budget))
    algorithm.SetLearningRate(at_most("learning_rate", positive("learning_rate", learning_rate), LARGEST_LEARNING_RATE))
    algorithm.SetSeed(integer("seed", seed, INT_MIN))
    algorithm.SetDevice(choice("device", device, DEVICES))
    return algorithm


def uses_dataset_file(algorithm, **inputs):
    """True for a vtkModelTrainer with a dataset file; raises TypeError when one of ``inputs`` is given beside it."""
    if not algorithm.GetDatasetFileName():
        return False
    if any(value is not None for value in inputs.values()):
        names = " and ".join(inputs)
        raise TypeError(f"a dataset is trained on in place of {names}, which must not be given with it")
    return True


def run(algorithm, columns, progress=None):
    """Trains and returns losses_of(); issues the warnings of the filter for the caller of the caller's function."""
    for text in run_algorithm(algorithm, progress):
        warnings.warn(text, SurfaceSynthesisWarning, stacklevel=4)
    return losses_of(algorithm, columns)


def losses_of(algorithm, columns):
    """The losses of a vtkModelTrainer that has run: an array for each of ``columns``, with a number for each iteration;
    empty arrays when there was nothing to train on."""
    table = algorithm.GetOutputDataObject(0)
    arrays = {name: table.GetColumnByName(name) for name in columns}
    return {name: np.zeros(0) if array is None else vtk_to_numpy(array).copy() for name, array in arrays.items()}


def count(name, value, smallest, largest):
    """An integer from ``smallest`` to ``largest``."""
    return integer(name, value, smallest, largest)


def factor(name, value):
    """A number larger than 0 and at most 1."""
    return at_most(name, positive(name, value), 1)


def shallow_copy(dataset):
    """A copy that shares the arrays: pipelines leave their information on it and not on the original."""
    copy = dataset.NewInstance()
    copy.ShallowCopy(dataset)
    return copy
