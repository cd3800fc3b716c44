# SPDX-License-Identifier: BSD-3-Clause
"""The command ``repair``."""

from ..deprecation import add_former_option
from .common import (
    add_command,
    add_reading_options,
    add_running_options,
    as_usage,
    read_input_surface,
    run_filter,
    written_outcome,
)

_DESCRIPTION = """\
Makes a valid, manifold surface of a broken one: merges points, removes duplicate and flat triangles, takes sheets that
meet apart, winds triangles alike, closes holes, removes components; and lists its actions."""
_EXAMPLES = """\
files: .stl .ply .obj .off .gii .glb .vtp .vtk, and .vtm (.vtk) for composite datasets

examples:
  %(prog)s scan.stl valid.stl
  %(prog)s scan.ply closed.ply --holes all --largest-component
  %(prog)s scan.obj valid.vtp --merge-tolerance 0.01
  %(prog)s scan.off solid.off --holes all --self-intersections --strict

exit status: 0 when a surface was written, with warnings about defects that are left and losses beyond --maximum-loss; 1
for an error, also with --strict and such a warning; 2 for wrong usage.
"""


def add(commands):
    """Adds the command to the parser."""
    parser = add_command(
        commands, "repair", "INPUT OUTPUT", "make a valid surface of a broken one", _DESCRIPTION, _EXAMPLES
    )
    parser.set_defaults(run=run)
    parser.add_argument("input", metavar="INPUT", help="surface to read")
    parser.add_argument("output", metavar="OUTPUT", help="file to write")
    points = parser.add_argument_group("points")
    merge = points.add_argument("--no-merge-points", action="store_true", help="keep points of equal coordinates apart")
    points.add_argument(
        "--merge-tolerance", type=float, default=0.0, metavar="D", help="merge points up to this distance (default: 0)"
    )
    holes = parser.add_argument_group("holes and components")
    holes.add_argument(
        "--holes", default="small", choices=["none", "small", "all"], help="holes that are closed (default: small)"
    )
    holes.add_argument(
        "--hole-size", type=float, metavar="D", help="extent of the largest small hole (default: a tenth of the surface)"
    )
    holes.add_argument("--largest-component", action="store_true", help="keep the largest component only")
    holes.add_argument(
        "--minimum-component", type=float, default=0.0, metavar="F", help="drop components below this share of the area"
    )
    losses = parser.add_argument_group("losses")
    losses.add_argument(
        "--maximum-loss",
        type=float,
        default=0.05,
        metavar="F",
        help="fraction of area, volume or components that may be lost without a warning (default: 0.05)",
    )
    losses.add_argument("--strict", action="store_true", help="an error in place of a warning about defects and losses")
    running = parser.add_argument_group("running")
    running.add_argument("--self-intersections", action="store_true", help="remove self-intersections")
    orient = running.add_argument(
        "--no-orient-outward", action="store_true", help="leave the side to which closed surfaces are turned"
    )
    add_running_options(running)
    add_reading_options(parser)
    add_former_option(parser, "--no-merge", merge)
    add_former_option(parser, "--no-orient", orient)


def run(arguments):
    """The command ``repair``."""
    from .. import files
    from ..remeshing import configured_repair

    algorithm = as_usage(
        configured_repair,
        merge_points=not arguments.no_merge_points,
        merge_tolerance=arguments.merge_tolerance,
        holes=arguments.holes,
        hole_size=arguments.hole_size,
        largest_component=arguments.largest_component,
        minimum_component=arguments.minimum_component,
        self_intersections=arguments.self_intersections,
        orient_outward=not arguments.no_orient_outward,
        maximum_loss=arguments.maximum_loss,
        strict=arguments.strict,
    )
    as_usage(files.extension, arguments.input)
    as_usage(files.extension, arguments.output)
    mesh = read_input_surface(arguments)
    as_usage(files.check_writable, mesh, arguments.output)
    output = run_filter(algorithm, mesh, arguments)
    files.write_mesh(output, arguments.output)
    done = algorithm.GetReport() + _losses(algorithm) if algorithm.GetReport() else "the surface was valid\n"
    return written_outcome(output, [arguments.output], done, **_measures(algorithm))


def _measures(algorithm):
    """Actions, losses and defects that are left, by name."""
    return {
        "actions": algorithm.GetReport().splitlines(),
        "area_loss": algorithm.GetAreaLoss(),
        "volume_loss": algorithm.GetVolumeLoss(),
        "intersecting_triangles": algorithm.GetNumberOfIntersectingTriangles(),
        "open_holes": algorithm.GetNumberOfOpenHoles(),
    }


def _losses(algorithm):
    """The line about what was lost and what is left."""
    return (
        f"lost: {100 * algorithm.GetAreaLoss():.3g} % of the area, {100 * algorithm.GetVolumeLoss():.3g} % of the volume; "
        f"left: {algorithm.GetNumberOfIntersectingTriangles():,} intersecting triangles, "
        f"{algorithm.GetNumberOfOpenHoles():,} open holes\n"
    )
