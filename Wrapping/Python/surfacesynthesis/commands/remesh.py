# SPDX-License-Identifier: BSD-3-Clause
"""The command ``remesh``."""

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
Remeshes a surface with triangles of even size and shape. Boundaries, creases and seams of arrays are kept, arrays are
interpolated."""
_EXAMPLES = """\
files: .stl .ply .obj .off .gii .glb .vtp .vtk, and .vtm (.vtk) for composite datasets

examples:
  %(prog)s scan.stl even.vtp --edge-length 2
  %(prog)s scan.ply even.ply --points 20000
  %(prog)s scan.vtp even.vtp --sizing EdgeLength
"""


def add(commands):
    """Adds the command to the parser."""
    parser = add_command(
        commands, "remesh", "INPUT OUTPUT", "remesh a surface with even triangles", _DESCRIPTION, _EXAMPLES
    )
    parser.set_defaults(run=run)
    parser.add_argument("input", metavar="INPUT", help="surface to read")
    parser.add_argument("output", metavar="OUTPUT", help="file to write")
    size = parser.add_argument_group("size")
    size.add_argument(
        "--edge-length", type=float, metavar="L", help="edge length, in units of the mesh (default: the mean now)"
    )
    size.add_argument("--points", type=int, metavar="N", help="number of points instead")
    size.add_argument("--sizing", metavar="NAME", help="point array with the wanted edge length at each point")
    curves = parser.add_argument_group("curves")
    curves.add_argument(
        "--feature-angle", type=float, default=60.0, metavar="A", help="creases above A degrees are kept (default: 60)"
    )
    curves.add_argument("--no-features", action="store_true", help="keep no creases")
    curves.add_argument("--keep-boundary-points", action="store_true", help="boundary points stay where they are")
    running = parser.add_argument_group("running")
    running.add_argument("--iterations", type=int, default=3, metavar="N", help="number of rounds (default: 3)")
    running.add_argument(
        "--relaxation-steps", type=int, default=1, metavar="N", help="relaxation steps in each round (default: 1)"
    )
    running.add_argument(
        "--maximum-points", type=int, default=10_000_000, metavar="N", help="limit of the output (default: 10000000)"
    )
    add_running_options(running)
    add_reading_options(parser)


def run(arguments):
    """The command ``remesh``."""
    from .. import files
    from ..remeshing import configured_remesh

    algorithm = as_usage(
        configured_remesh,
        edge_length=arguments.edge_length,
        points=arguments.points,
        sizing=arguments.sizing,
        feature_angle=None if arguments.no_features else arguments.feature_angle,
        keep_boundary_points=arguments.keep_boundary_points,
        iterations=arguments.iterations,
        relaxation_steps=arguments.relaxation_steps,
        maximum_points=arguments.maximum_points,
    )
    as_usage(files.extension, arguments.input)
    as_usage(files.extension, arguments.output)
    mesh = read_input_surface(arguments)
    as_usage(files.check_writable, mesh, arguments.output)
    output = run_filter(algorithm, mesh, arguments)
    files.write_mesh(output, arguments.output)
    return written_outcome(output, [arguments.output])
