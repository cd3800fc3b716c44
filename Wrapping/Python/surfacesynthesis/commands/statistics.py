# SPDX-License-Identifier: BSD-3-Clause
"""The command ``statistics``."""

from .common import add_command, add_running_options, as_usage, result_and_written_outcome, run_filter
from .metrics import check_ensemble_names, choose_array, read_ensemble

_DESCRIPTION = """\
Computes the mean, standard deviation, quantiles and principal modes of an ensemble of shapes or signals on one
triangulation. With --modes the output is a statistical shape model, which the command shape-model reads."""
_EXAMPLES = """\
ensembles: one file with a composite dataset (.vtm .vtk), whose surfaces are the samples; one file for each sample; or one
surface with an array for each sample, called NAME_0, NAME_1 and so on; or a dataset file of trainings (.safetensors).

output: the mean surface with the arrays StandardDeviation, StandardDistance, Quantile_0.5, Mode_0 and so on; each mode times
its standard deviation.

examples:
  %(prog)s shapes_*.vtp model.vtp --modes 5
  %(prog)s noise.vtp statistics.vtp --array MaternNoise --quantiles 0.05 0.5 0.95
"""


def add(commands):
    """Adds the command to the parser."""
    parser = add_command(
        commands,
        "statistics",
        "ENSEMBLE... OUTPUT",
        "compute mean, deviation, quantiles and modes of an ensemble",
        _DESCRIPTION,
        _EXAMPLES,
    )
    parser.set_defaults(run=run)
    formats = ".stl .ply .obj .off .gii .glb .vtp .vtk .vtm .safetensors"
    parser.add_argument("ensemble", nargs="+", metavar="ENSEMBLE", help=f"the samples: {formats}")
    parser.add_argument("output", metavar="OUTPUT", help="surface to write, with all arrays: .vtp .vtk .ply")
    group = parser.add_argument_group("statistics")
    group.add_argument("--array", metavar="NAME", help="point array of the samples (default: the points; of dataset files their signal)")
    group.add_argument(
        "--quantiles", nargs="+", type=float, default=[], metavar="P", help="probabilities of quantiles, from 0 to 1"
    )
    group.add_argument("--modes", type=int, default=0, metavar="K", help="number of modes; -1 for all (default: 0)")
    add_running_options(parser.add_argument_group("output"), csv="the modes")


def run(arguments):
    """The command ``statistics``."""
    from .. import files
    from ..shape_statistics import configured_filter, statistics_of

    algorithm = as_usage(configured_filter, arguments.array, arguments.quantiles, arguments.modes)
    check_ensemble_names(arguments.ensemble)
    as_usage(files.extension, arguments.output)
    ensemble = read_ensemble(arguments.ensemble, arguments.array)
    choose_array(algorithm, arguments.array, [ensemble])
    run_filter(algorithm, ensemble.dataset, arguments)
    statistics = statistics_of(algorithm)
    as_usage(files.check_writable, statistics.surface, arguments.output)
    files.write_mesh(statistics.surface, arguments.output)
    return result_and_written_outcome(arguments, statistics, statistics.surface, arguments.output)
