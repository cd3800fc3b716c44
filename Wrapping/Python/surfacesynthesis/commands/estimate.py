# SPDX-License-Identifier: BSD-3-Clause
"""The command ``estimate``."""

from .common import (
    add_command,
    add_reading_options,
    add_running_options,
    as_usage,
    read_input_surface,
    read_observations,
    require_single,
    result_outcome,
    run_filter,
)

_DESCRIPTION = """\
Estimates correlation range, standard deviation and noise of Matérn fields on a surface by maximum likelihood, from one or
many observed fields, with intervals of 95 %. The command noise makes fields with these parameters."""
_EXAMPLES = """\
examples:
  %(prog)s cortex.vtp --observation-array Thickness
  %(prog)s bone.ply --observations measured.vtp --observation-array Density --csv > parameters.csv
"""


def add(commands):
    """Adds the command to the parser."""
    parser = add_command(
        commands, "estimate", "INPUT", "estimate the parameters of Matérn noise from data", _DESCRIPTION, _EXAMPLES
    )
    parser.set_defaults(run=run)
    parser.add_argument("input", metavar="INPUT", help="surface to read: .stl .ply .obj .off .gii .glb .vtp .vtk")
    data = parser.add_argument_group("data")
    data.add_argument(
        "--observation-array",
        metavar="NAME",
        help="point array with the values, each component a field, or the first part of the names of several, NAME_0, "
        "NAME_1 (default: the active scalars)",
    )
    data.add_argument(
        "--observations",
        metavar="FILE",
        help="points near the surface with the values: .vtp .vtk .ply (default: the points of INPUT)",
    )
    data.add_argument(
        "--tolerance",
        type=float,
        metavar="D",
        help="largest distance of an observation from the surface (default: a hundredth of the longest side of its box)",
    )
    model = parser.add_argument_group("model")
    model.add_argument(
        "--operator-power",
        type=int,
        default=2,
        metavar="ALPHA",
        help="power of the operator of the field, 2 to 4, which is not estimated (default: 2)",
    )
    model.add_argument("--no-noise-estimation", action="store_true", help="take the observations as exact")
    model.add_argument("--no-mean-estimation", action="store_true", help="take the mean of each field as 0")
    output = parser.add_argument_group("output")
    add_running_options(output, csv="the parameters")
    add_reading_options(parser)


def run(arguments):
    """The command ``estimate``."""
    from ..estimation import MaternEstimate, configured_filter

    mesh = read_input_surface(arguments)
    require_single(mesh, arguments.input)
    algorithm = as_usage(
        configured_filter,
        observation_array=arguments.observation_array,
        observations=read_observations(arguments),
        tolerance=arguments.tolerance,
        noise_estimation=not arguments.no_noise_estimation,
        mean_estimation=not arguments.no_mean_estimation,
        operator_power=arguments.operator_power,
    )
    run_filter(algorithm, mesh, arguments)
    return result_outcome(arguments, MaternEstimate(algorithm))
