# SPDX-License-Identifier: BSD-3-Clause
"""The command ``geometric-texture-distance``."""

from ..results import Result
from ..vocabulary import snake
from .common import add_command, add_running_options, as_usage, read_surface, result_outcome, run_filter

_DESCRIPTION = """\
Compares the geometric textures of two surfaces, whatever their shape: the sliced Wasserstein distance of the features
of their triangles, in mean edge lengths. Compare surfaces whose triangles were made in the same way, for instance a
synthesized texture with a level of the meshes that it was learned from, beside the bare target subdivided as often."""
_EXAMPLES = """\
examples:
  %(prog)s synthesized_2.ply levels_2.ply
  %(prog)s synthesized_2.ply levels_2.ply --unit-length 0.01 --reference-unit-length 0.02 --csv
"""


def add(commands):
    """Adds the command to the parser."""
    parser = add_command(
        commands,
        "geometric-texture-distance",
        "MESH REFERENCE",
        "compare the geometric textures of two surfaces",
        _DESCRIPTION,
        _EXAMPLES,
    )
    parser.set_defaults(run=run)
    formats = ".stl .ply .obj .off .gii .glb .vtp .vtk"
    parser.add_argument("mesh", metavar="MESH", help=f"surface to read: {formats}")
    parser.add_argument("reference", metavar="REFERENCE", help="surface to compare it with: the same formats")
    comparison = parser.add_argument_group("comparison")
    comparison.add_argument(
        "--unit-length",
        type=float,
        metavar="LENGTH",
        help="divisor of the lengths of MESH (default: its mean edge length)",
    )
    comparison.add_argument(
        "--reference-unit-length",
        type=float,
        metavar="LENGTH",
        help="divisor of the lengths of REFERENCE (default: its mean edge length)",
    )
    comparison.add_argument(
        "--projections", type=int, default=128, metavar="N", help="number of random directions (default: 128)"
    )
    comparison.add_argument("--seed", type=int, default=0, metavar="N", help="of the directions (default: 0)")
    output = parser.add_argument_group("output")
    add_running_options(output, csv="the distance")


def run(arguments):
    """The command ``geometric-texture-distance``."""
    from .. import files
    from ..geometric_texture import configured_distance, give_reference

    algorithm = as_usage(
        configured_distance,
        arguments.unit_length,
        arguments.reference_unit_length,
        arguments.projections,
        arguments.seed,
    )
    for path in (arguments.mesh, arguments.reference):
        as_usage(files.extension, path)
    mesh, reference = (_read(path) for path in (arguments.mesh, arguments.reference))
    give_reference(algorithm, reference)
    table = run_filter(algorithm, mesh, arguments)
    return result_outcome(arguments, _Distance(table))


class _Distance(Result):
    """The row of a table of vtkGeometricTextureDistance; empty for two empty surfaces."""

    def __init__(self, table):
        rows = table.GetNumberOfRows()
        self._row = {table.GetColumnName(k): table.GetColumn(k).GetValue(0) for k in range(table.GetNumberOfColumns()) if rows}

    def to_dict(self):
        """The columns by name."""
        return {snake(name): value for name, value in self._row.items()}

    def to_csv(self):
        """A line of names and one of numbers."""
        return "\n".join(",".join(map(str, line)) for line in (self._row.keys(), map(repr, self._row.values())))

    def __str__(self):
        row = self._row
        if not row:
            return "empty"
        triangles = f"{row['NumberOfTriangles']:,} and {row['NumberOfReferenceTriangles']:,} triangles"
        return f"distance {row['Distance']:.6g}, standard error {row['StandardError']:.2g}, of {triangles}"


def _read(path):
    from vtkmodules.vtkCommonDataModel import vtkPolyData

    from ..errors import FormatError

    mesh = read_surface(path)
    if not isinstance(mesh, vtkPolyData):
        raise FormatError(f"{path}: one surface is compared with another, not a {mesh.GetClassName()}")
    return mesh
