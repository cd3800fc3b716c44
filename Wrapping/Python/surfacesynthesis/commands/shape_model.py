# SPDX-License-Identifier: BSD-3-Clause
"""The command ``shape-model``."""

from .common import Outcome, add_command, add_running_options, as_usage, read_surface, run_filter, size_of
from .metrics import check_ensemble_names, read_ensemble

_DESCRIPTION = """\
Makes shapes of a statistical shape model of the command statistics: random ones, that of given coefficients, or the nearest
ones to other shapes."""
_EXAMPLES = """\
examples:
  %(prog)s model.vtp random.vtm --samples 12 --seed 1
  %(prog)s model.vtp wide.vtp --coefficients 2 0 -1
  %(prog)s model.vtp nearest.vtm --shapes patient_*.vtp --modes 5
"""


def add(commands):
    """Adds the command to the parser."""
    parser = add_command(
        commands,
        "shape-model",
        "MODEL OUTPUT",
        "make shapes of a statistical shape model",
        _DESCRIPTION,
        _EXAMPLES,
    )
    parser.set_defaults(run=run)
    parser.add_argument("model", metavar="MODEL", help="file of the command statistics with --modes: .vtp .vtk")
    parser.add_argument("output", metavar="OUTPUT", help="shapes to write: .vtm, and for one shape .vtp and others")
    group = parser.add_argument_group("shapes")
    group.add_argument("--samples", type=int, default=1, metavar="N", help="number of random samples (default: 1)")
    group.add_argument("--seed", type=int, default=0, metavar="S", help="seed of the random numbers (default: 0)")
    group.add_argument("--first-sample", type=int, default=0, metavar="N", help="index of the first sample (default: 0)")
    group.add_argument(
        "--coefficients",
        nargs="+",
        type=float,
        metavar="B",
        help="coefficients of one shape in standard deviations, in place of random ones",
    )
    group.add_argument("--shapes", nargs="+", metavar="FILE", help="shapes of which the nearest ones of the model are made")
    group.add_argument("--modes", type=int, default=-1, metavar="K", help="number of modes that are used (default: all)")
    add_running_options(parser.add_argument_group("output"))


def run(arguments):
    """The command ``shape-model``."""
    from .. import files
    from ..shape_statistics import configured_sampler

    sampler = as_usage(
        configured_sampler,
        arguments.samples,
        arguments.seed,
        arguments.first_sample,
        arguments.coefficients,
        arguments.shapes is not None,
        arguments.modes,
    )
    check_ensemble_names(arguments.shapes or [])
    for path in [arguments.model, arguments.output]:
        as_usage(files.extension, path)
    model = _model(arguments.model)
    if arguments.shapes is not None:
        sampler.SetInputDataObject(1, read_ensemble(arguments.shapes, _array_of(model)).dataset)
    output = run_filter(sampler, model, arguments)
    shapes = output.GetNumberOfBlocks()
    if shapes == 1 and files.extension(arguments.output) not in (".vtm",):
        output = output.GetBlock(0)
    as_usage(files.check_writable, output, arguments.output)
    files.write_mesh(output, arguments.output)
    return Outcome(f"{shapes:,} shapes", {"shapes": shapes, **size_of(output)}, [arguments.output])


def _array_of(model):
    """Name of the array that a model is of; None for positions."""
    names = model.GetFieldData().GetAbstractArray("EnsembleArrayName")
    return names.GetValue(0) or None if names is not None and names.GetNumberOfValues() else None


def _model(path):
    from vtkmodules.vtkCommonDataModel import vtkPolyData

    from ..errors import FormatError

    mesh = read_surface(path)
    if not isinstance(mesh, vtkPolyData):
        raise FormatError(f"{path}: the model must be one surface, not a {mesh.GetClassName()}")
    return mesh
