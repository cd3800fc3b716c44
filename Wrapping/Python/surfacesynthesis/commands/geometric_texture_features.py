# SPDX-License-Identifier: BSD-3-Clause
"""The command ``geometric-texture-features``."""

from .common import (
    UsageError,
    add_command,
    add_running_options,
    as_usage,
    read_surface,
    result_and_written_outcome,
    result_outcome,
    run_filter,
)

_DESCRIPTION = """\
Counts and measures the peaks, merged peaks, walls and self-intersections of a geometric texture: peaks in an area, the
variation of their heights, and the share of those that have merged are alike in two samples of one texture, whatever the
shapes of their surfaces are."""
_EXAMPLES = """\
examples:
  %(prog)s synthesized_2.ply
  %(prog)s synthesized_2.ply --bare target_2.ply --output features.vtp
  %(prog)s synthesized_2.ply --bare target_2.ply --reference levels_2.ply --reference-bare ball_2.ply --json
"""


def add(commands):
    """Adds the command to the parser."""
    parser = add_command(
        commands,
        "geometric-texture-features",
        "MESH",
        "count peaks, merged peaks, walls and self-intersections of a geometric texture",
        _DESCRIPTION,
        _EXAMPLES,
    )
    parser.set_defaults(run=run)
    formats = ".stl .ply .obj .off .gii .glb .vtp .vtk"
    parser.add_argument("mesh", metavar="MESH", help=f"surface to read: {formats}")
    parser.add_argument("--bare", metavar="FILE", help="surface beneath with the same triangles (default: MESH, smoothed)")
    parser.add_argument("--reference", metavar="FILE", help="surface to compare with, which is measured first")
    parser.add_argument("--reference-bare", metavar="FILE", help="surface beneath the reference")
    census = parser.add_argument_group("census")
    for option, help in {
        "--unit-length": "unit of the relative densities of MESH (default: mean edge length of the bare surface)",
        "--minimum-prominence": "smallest prominence of a peak of MESH (default: half the standard deviation of the heights; "
        "with --reference as many unit lengths as there)",
        "--smoothing-length": "length over which MESH is smoothed without --bare (default: a tenth of the root of the area)",
    }.items():
        census.add_argument(option, type=float, metavar="LENGTH", help=help)
    census.add_argument(
        "--merged-saddle",
        type=float,
        default=0.5,
        metavar="FRACTION",
        help="saddles above this fraction of the lower peak merge two, 0 to 1 (default: 0.5)",
    )
    census.add_argument(
        "--wall-level",
        type=float,
        metavar="FRACTION",
        help="level of the walls between the quantiles 0.05 and 0.95 of the heights, above 0 to 1 (default: mean height)",
    )
    output = parser.add_argument_group("output")
    output.add_argument("--output", metavar="FILE", help="write MESH with arrays that show the features: .vtp .ply")
    add_running_options(output, csv="the features")


def run(arguments):
    """The command ``geometric-texture-features``."""
    from .. import files
    from ..geometric_texture_features import configured_features

    shared = {"merged_saddle": arguments.merged_saddle, "wall_level": arguments.wall_level}
    algorithm = as_usage(
        configured_features,
        unit_length=arguments.unit_length,
        minimum_prominence=arguments.minimum_prominence,
        smoothing_length=arguments.smoothing_length,
        **shared,
    )
    paths = [arguments.mesh, arguments.bare, arguments.reference, arguments.reference_bare, arguments.output]
    for path in filter(None, paths):
        as_usage(files.extension, path)
    if arguments.reference_bare and not arguments.reference:
        raise UsageError("--reference-bare is of no use without --reference")
    reference = None
    if arguments.reference:
        reference = _measured(configured_features(**shared), arguments.reference, arguments.reference_bare, arguments)
    features = _measured(algorithm, arguments.mesh, arguments.bare, arguments, reference)
    if not arguments.output:
        return result_outcome(arguments, features)
    as_usage(files.check_writable, features.surface, arguments.output)
    files.write_mesh(features.surface, arguments.output)
    return result_and_written_outcome(arguments, features, features.surface, arguments.output)


def _measured(algorithm, path, bare, arguments, reference=None):
    """The features of the surface in a file, with another in a file beneath it."""
    from ..geometric_texture_features import features_of, give_bare

    mesh = _surface(path)
    if bare:
        give_bare(algorithm, _surface(bare))
    return features_of(algorithm, lambda: run_filter(algorithm, mesh, arguments), reference)


def _surface(path):
    from vtkmodules.vtkCommonDataModel import vtkPolyData

    from ..errors import FormatError

    mesh = read_surface(path)
    if not isinstance(mesh, vtkPolyData):
        raise FormatError(f"{path}: one surface is needed, not a {mesh.GetClassName()}")
    return mesh
