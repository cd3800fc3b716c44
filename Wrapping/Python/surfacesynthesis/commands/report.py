# SPDX-License-Identifier: BSD-3-Clause
"""The command ``report``."""

from ..deprecation import add_former_option
from .common import (
    add_command,
    add_reading_options,
    add_running_options,
    as_usage,
    read_input,
    require_surface,
    result_outcome,
    run_filter,
)
from .wording import with_commands

_DESCRIPTION = """\
Describes a surface and every defect of it, with the first cell or point of each kind of defect and what repairs it."""
_EPILOG = """\
exit status: 0 when the surface is valid (finite points, triangles with an area and without duplicates, manifold edges and
points, consistent winding, no intersecting triangles), 3 when it is not, 1 when the file cannot be read, 2 for wrong
usage. An open surface can be valid; tetrahedralize needs a closed one.

examples:
  %(prog)s in.stl
  %(prog)s in.vtp --csv > report.csv
  %(prog)s in.vtp --json > report.json
"""
#: Exit status for a surface that is not valid.
INVALID = 3


def add(commands):
    """Adds the command to the parser."""
    parser = add_command(commands, "report", "INPUT", "describe a surface and its defects", _DESCRIPTION, _EPILOG)
    parser.set_defaults(run=run)
    parser.add_argument("input", metavar="INPUT", help="surface to read: .stl .ply .obj .off .gii .glb .vtp .vtk .vtm")
    output = parser.add_argument_group("output")
    component_rows = output.add_argument(
        "--component-rows",
        type=int,
        default=10,
        metavar="N",
        help="number of components that are described one by one, the largest first (default: 10)",
    )
    add_running_options(output, csv="all rows")
    add_reading_options(parser)
    add_former_option(parser, "--components", component_rows)


def run(arguments):
    """The command ``report``."""
    from .. import files
    from ..report import configured_filter, report_of_table

    algorithm = as_usage(configured_filter, arguments.component_rows)
    as_usage(files.extension, arguments.input)
    mesh = read_input(arguments)
    require_surface(mesh, arguments.input)
    report = report_of_table(run_filter(algorithm, mesh, arguments), mesh)
    return result_outcome(arguments, report, with_commands(str(report)), status=0 if report.valid else INVALID)
