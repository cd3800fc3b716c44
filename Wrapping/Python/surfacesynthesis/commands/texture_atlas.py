# SPDX-License-Identifier: BSD-3-Clause
"""The command ``texture-atlas``."""

from .common import (
    UsageError,
    add_command,
    add_reading_options,
    add_running_options,
    as_usage,
    read_input_surface,
    run_filter,
    written_outcome,
)

_DESCRIPTION = """\
Gives a surface texture coordinates: charts of little stretch, packed into one image without overlaps. Points at which
charts meet are doubled."""
_EXAMPLES = """\
files: .stl .ply .obj .off .gii .glb .vtp .vtk, and .vtm (.vtk) for composite datasets; STL and OFF have no room for the
coordinates

examples:
  %(prog)s scan.stl scan.obj
  %(prog)s scan.ply scan.vtp --resolution 2048 1024 --margin 8
  %(prog)s scan.off scan.glb --maximum-stretch 1.3
"""


def add(commands):
    """Adds the command to the parser."""
    parser = add_command(
        commands, "texture-atlas", "INPUT OUTPUT", "give a surface texture coordinates", _DESCRIPTION, _EXAMPLES
    )
    parser.set_defaults(run=run)
    parser.add_argument("input", metavar="INPUT", help="surface to read")
    parser.add_argument("output", metavar="OUTPUT", help="file to write")
    add_reading_options(parser)
    atlas = parser.add_argument_group("atlas")
    add_resolution(atlas, "image that the charts are packed for")
    atlas.add_argument(
        "--margin", type=int, default=4, metavar="N", help="least distance of two charts in texels (default: 4)"
    )
    atlas.add_argument(
        "--maximum-stretch", type=float, default=2.0, metavar="S", help="largest stretch of a triangle (default: 2)"
    )
    running = parser.add_argument_group("running")
    add_running_options(running)


def add_resolution(group, what):
    """The option of the size of an image."""
    group.add_argument(
        "--resolution",
        type=int,
        nargs="+",
        default=[1024],
        metavar="N",
        help=f"width, or width and height, of the {what}, in texels (default: 1024)",
    )


def resolution_of(arguments):
    """The pair of the option of add_resolution()."""
    if len(arguments.resolution) > 2:
        raise UsageError("--resolution takes one number, or width and height")
    return arguments.resolution[0], arguments.resolution[-1]


def run(arguments):
    """The command ``texture-atlas``."""
    from .. import files
    from ..atlases import configured_atlas

    algorithm = as_usage(configured_atlas, resolution_of(arguments), arguments.margin, arguments.maximum_stretch)
    as_usage(files.extension, arguments.input)
    if as_usage(files.extension, arguments.output) in (".stl", ".off"):
        raise UsageError(f"{arguments.output}: this format has no texture coordinates; use .obj, .ply, .glb or .vtp")
    mesh = read_input_surface(arguments)
    as_usage(files.check_writable, mesh, arguments.output)
    output = run_filter(algorithm, mesh, arguments)
    files.write_mesh(output, arguments.output)
    charts, coverage, stretch = algorithm.GetNumberOfCharts(), algorithm.GetCoverage(), algorithm.GetRootMeanStretch()
    text = f"{charts:,} charts, {100 * coverage:.0f} % of the image covered, mean stretch {stretch:.3f}\n"
    values = {"charts": charts, "coverage": coverage, "root_mean_stretch": stretch}
    return written_outcome(output, [arguments.output], text, **values)
