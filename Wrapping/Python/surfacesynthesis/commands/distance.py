# SPDX-License-Identifier: BSD-3-Clause
"""The command ``distance``."""

from .common import (
    add_command,
    add_running_options,
    as_usage,
    read_single_surface,
    result_and_written_outcome,
    result_outcome,
    run_filter,
)

_DESCRIPTION = """\
Measures the distance of two surfaces, whatever their triangulations are: mean, RMS, 95th percentile and Hausdorff
distance, in both directions, weighted by area, in the units of the files."""
_EXAMPLES = """\
examples:
  %(prog)s segmented.stl reference.ply
  %(prog)s scan.ply repaired.ply --json
  %(prog)s scan.ply repaired.ply --output distances.vtp
"""


def add(commands):
    """Adds the command to the parser."""
    parser = add_command(commands, "distance", "FIRST SECOND", "measure the distance of two surfaces", _DESCRIPTION, _EXAMPLES)
    parser.set_defaults(run=run)
    formats = ".stl .ply .obj .off .gii .glb .vtp .vtk"
    parser.add_argument("first", metavar="FIRST", help=f"first surface: {formats}")
    parser.add_argument("second", metavar="SECOND", help="second surface")
    sampling = parser.add_argument_group("sampling")
    sampling.add_argument(
        "--samples", type=int, default=100_000, metavar="N", help="number of samples on each surface (default: 100000)"
    )
    sampling.add_argument("--seed", type=int, default=0, metavar="S", help="seed of their places (default: 0)")
    output = parser.add_argument_group("output")
    output.add_argument("--output", metavar="FILE", help="write the first surface with the point array Distance: .vtp .ply")
    add_running_options(output, csv="the distances")


def run(arguments):
    """The command ``distance``."""
    from .. import files
    from ..distances import configured_filter, distance_of

    algorithm = as_usage(configured_filter, arguments.samples, arguments.seed)
    for path in [arguments.first, arguments.second, *([arguments.output] if arguments.output else [])]:
        as_usage(files.extension, path)
    first, second = (read_single_surface(path) for path in (arguments.first, arguments.second))
    algorithm.SetInputDataObject(1, second)
    run_filter(algorithm, first, arguments)
    distance = distance_of(algorithm)
    if not arguments.output:
        return result_outcome(arguments, distance)
    as_usage(files.check_writable, distance.surface, arguments.output)
    files.write_mesh(distance.surface, arguments.output)
    return result_and_written_outcome(arguments, distance, distance.surface, arguments.output)
