# SPDX-License-Identifier: BSD-3-Clause
"""The command ``tetrahedralize``."""

import os
import time

from .common import UsageError, add_command, add_running_options, as_usage, read_surface, run_filter, surface_summary

_DESCRIPTION = """\
Fills a closed surface with tetrahedra of bounded shape and size, by TetGen in a process of its own."""
_EPILOG = """\
files: the output is .vtu or .vtk, or .vtm for a composite dataset.

examples:
  %(prog)s in.stl out.vtu
  %(prog)s in.ply out.vtu --edge-length 2 --holes
  %(prog)s in.vtp out.vtu --ratio 1.4 --split-surface
"""
_KINDS = (".vtu", ".vtk", ".vtm")


def add(commands):
    """Adds the command to the parser."""
    parser = add_command(
        commands, "tetrahedralize", "INPUT OUTPUT", "fill a closed surface with tetrahedra", _DESCRIPTION, _EPILOG
    )
    parser.set_defaults(run=run)
    parser.add_argument("input", metavar="INPUT", help="surface to read: .stl .ply .obj .off .vtp .vtk .vtm")
    parser.add_argument("output", metavar="OUTPUT", help="file to write: .vtu .vtk .vtm")

    bounds = parser.add_argument_group("bounds")
    bounds.add_argument(
        "--ratio",
        type=float,
        default=2.0,
        metavar="R",
        help="largest ratio of circumradius to shortest edge, at least 1, or 0 for no bound (default: 2)",
    )
    bounds.add_argument("--dihedral", type=float, default=0.0, metavar="A", help="smallest dihedral angle, degrees")
    bounds.add_argument("--volume", type=float, metavar="V", help="largest volume of a tetrahedron")
    bounds.add_argument("--edge-length", type=float, metavar="L", help="the same bound, by the edge of a regular one")
    bounds.add_argument("--time-limit", type=float, default=300.0, metavar="S", help="seconds (default: 300)")
    bounds.add_argument("--memory-limit", type=int, metavar="MIB", help="MiB (default: 3/4 of the machine's)")

    shape = parser.add_argument_group("surface")
    shape.add_argument("--split-surface", action="store_true", help="allow new points on the surface")
    shape.add_argument("--holes", action="store_true", help="leave the inside of inner surfaces empty")
    shape.add_argument("--surface-triangles", action="store_true", help="write the triangles of the surface as well")
    add_running_options(parser.add_argument_group("output"))


def run(arguments):
    """The command ``tetrahedralize``; returns the line to print."""
    from .. import files

    started = time.monotonic()
    algorithm = _filter_of(arguments)
    as_usage(files.extension, arguments.input)
    kind = os.path.splitext(arguments.output)[1].lower()
    if kind not in _KINDS:
        raise UsageError(f"{arguments.output}: tetrahedra can be written to {', '.join(_KINDS)}, not to '{kind}'")
    mesh = read_surface(arguments.input)
    composite = hasattr(mesh, "NewTreeIterator")
    if composite != (kind == ".vtm"):
        wanted = ".vtm" if composite else ".vtu or .vtk"
        raise UsageError(f"{arguments.output}: the tetrahedra of this input are written to {wanted}")
    output = run_filter(algorithm, mesh, arguments)
    files.write_mesh(output, arguments.output)
    return surface_summary(output, arguments.output, time.monotonic() - started)


def _filter_of(arguments):
    from ..tetrahedra import configured_filter

    return as_usage(
        configured_filter,
        quality_ratio=arguments.ratio if arguments.ratio != 0.0 else None,
        minimum_dihedral_angle=arguments.dihedral,
        maximum_volume=arguments.volume,
        target_edge_length=arguments.edge_length,
        preserve_surface=not arguments.split_surface,
        inner_surfaces="holes" if arguments.holes else "regions",
        surface_triangles=arguments.surface_triangles,
        time_limit=arguments.time_limit if arguments.time_limit != 0.0 else None,
        memory_limit=arguments.memory_limit,
    )
