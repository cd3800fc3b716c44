# SPDX-License-Identifier: BSD-3-Clause
"""The command ``tetrahedralize``."""

import os

from ..deprecation import add_former_option
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
Fills a closed surface with tetrahedra of bounded shape and size, by TetGen in a process of its own."""
_EPILOG = """\
files: the output is .vtu or .vtk, or .vtm for a composite dataset.

examples:
  %(prog)s in.stl out.vtu
  %(prog)s in.ply out.vtu --edge-length 2 --inner-surfaces holes
  %(prog)s in.vtp out.vtu --quality-ratio 1.4 --no-preserve-surface
"""
_KINDS = (".vtu", ".vtk", ".vtm")


def add(commands):
    """Adds the command to the parser."""
    parser = add_command(
        commands, "tetrahedralize", "INPUT OUTPUT", "fill a closed surface with tetrahedra", _DESCRIPTION, _EPILOG
    )
    parser.set_defaults(run=run)
    parser.add_argument("input", metavar="INPUT", help="surface to read: .stl .ply .obj .off .gii .glb .vtp .vtk .vtm")
    parser.add_argument("output", metavar="OUTPUT", help="file to write: .vtu .vtk .vtm")

    bounds = parser.add_argument_group("bounds")
    ratio = bounds.add_argument(
        "--quality-ratio",
        type=float,
        default=2.0,
        metavar="R",
        help="largest ratio of circumradius to shortest edge, at least 1, or 0 for no bound (default: 2)",
    )
    angle = bounds.add_argument(
        "--minimum-dihedral-angle", type=float, default=0.0, metavar="A", help="smallest dihedral angle, degrees"
    )
    volume = bounds.add_argument("--maximum-volume", type=float, metavar="V", help="largest volume of a tetrahedron")
    bounds.add_argument(
        "--edge-length", type=float, metavar="L", help="edge of the regular tetrahedron of the largest volume"
    )
    bounds.add_argument(
        "--maximum-tetrahedra", type=int, default=10_000_000, metavar="N", help="limit of the output (default: 10000000)"
    )
    bounds.add_argument("--time-limit", type=float, default=300.0, metavar="S", help="seconds (default: 300)")
    bounds.add_argument("--memory-limit", type=int, metavar="MIB", help="MiB (default: 3/4 of the machine's)")

    shape = parser.add_argument_group("surface")
    split = shape.add_argument("--no-preserve-surface", action="store_true", help="allow new points on the surface")
    inner = shape.add_argument(
        "--inner-surfaces",
        default="regions",
        choices=["regions", "holes"],
        metavar="KIND",
        help="regions (default: fill the inside of inner surfaces) or holes (leave it empty)",
    )
    shape.add_argument("--surface-triangles", action="store_true", help="write the triangles of the surface as well")
    group = parser.add_argument_group("output")
    add_running_options(group)
    add_reading_options(parser)
    add_former_option(parser, "--ratio", ratio)
    add_former_option(parser, "--dihedral", angle)
    add_former_option(parser, "--volume", volume)
    add_former_option(parser, "--split-surface", split)
    add_former_option(parser, "--holes", inner, "holes")


def run(arguments):
    """The command ``tetrahedralize``."""
    from .. import files

    algorithm = _filter_of(arguments)
    as_usage(files.extension, arguments.input)
    kind = os.path.splitext(arguments.output)[1].lower()
    if kind not in _KINDS:
        raise UsageError(f"{arguments.output}: tetrahedra can be written to {', '.join(_KINDS)}, not to '{kind}'")
    mesh = read_input_surface(arguments)
    composite = hasattr(mesh, "NewTreeIterator")
    if composite != (kind == ".vtm"):
        wanted = ".vtm" if composite else ".vtu or .vtk"
        raise UsageError(f"{arguments.output}: the tetrahedra of this input are written to {wanted}")
    output = run_filter(algorithm, mesh, arguments)
    files.write_mesh(output, arguments.output)
    return written_outcome(output, [arguments.output])


def _filter_of(arguments):
    from ..tetrahedra import configured_filter

    return as_usage(
        configured_filter,
        quality_ratio=arguments.quality_ratio if arguments.quality_ratio != 0.0 else None,
        minimum_dihedral_angle=arguments.minimum_dihedral_angle,
        maximum_volume=arguments.maximum_volume,
        edge_length=arguments.edge_length,
        maximum_tetrahedra=arguments.maximum_tetrahedra,
        preserve_surface=not arguments.no_preserve_surface,
        inner_surfaces=arguments.inner_surfaces,
        surface_triangles=arguments.surface_triangles,
        time_limit=arguments.time_limit if arguments.time_limit != 0.0 else None,
        memory_limit=arguments.memory_limit,
    )
