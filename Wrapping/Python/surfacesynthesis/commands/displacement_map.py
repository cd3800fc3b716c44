# SPDX-License-Identifier: BSD-3-Clause
"""The command ``displacement-map``."""

from .common import Outcome, add_command, add_running_options, as_usage, run_filter
from .texture_atlas import add_resolution, resolution_of

_DESCRIPTION = """\
Bakes the difference of a plain and a detailed surface into images in the texture atlas of the plain one: heights along its
normals and displacement vectors, which make the detailed surface of it in a renderer."""
_EXAMPLES = """\
files: PLAIN any surface with texture coordinates, as texture-atlas writes them: .obj .ply .glb .vtp .vtk; DETAILED any surface;
OUTPUT one or several of
  .png        heights in 16 bits; midlevel and scale are printed, and height = (value - midlevel) scale
  .tif .tiff  displacement vectors in 32-bit floating-point numbers
  .vti        both, and the coverage, for VTK and ParaView

examples:
  %(prog)s plain.obj detailed.ply height.png
  %(prog)s plain.obj detailed.ply height.png vectors.tif --resolution 2048 --vector-space tangent
  %(prog)s plain.vtp detailed.vtp maps.vti --json
"""


def add(commands):
    """Adds the command to the parser."""
    parser = add_command(
        commands,
        "displacement-map",
        "PLAIN DETAILED OUTPUT ...",
        "bake a displacement map and a height map",
        _DESCRIPTION,
        _EXAMPLES,
    )
    parser.set_defaults(run=run)
    parser.add_argument("input", metavar="PLAIN", help="plain surface with texture coordinates")
    parser.add_argument("detailed", metavar="DETAILED", help="detailed surface near the plain one")
    parser.add_argument("outputs", metavar="OUTPUT", nargs="+", help="file to write: .png .tif .tiff .vti")
    maps = parser.add_argument_group("maps")
    add_resolution(maps, "images")
    maps.add_argument(
        "--gutter-width", type=int, default=8, metavar="N",
        help="distance from the charts up to which texels outside are filled, in texels; -1 for all (default: 8)",
    )  # fmt: skip
    maps.add_argument(
        "--vector-space", default="object", choices=["object", "tangent"], metavar="SPACE",
        help="axes of the vectors: object (default), or tangent, with the components tangent, normal, bitangent",
    )  # fmt: skip
    maps.add_argument(
        "--correspondence", default="automatic", choices=["automatic", "normals"], metavar="HOW",
        help="places to which the vectors go: automatic (default), the same ones of a subdivision, else normals",
    )  # fmt: skip
    maps.add_argument(
        "--maximum-distance", type=float, metavar="D",
        help="largest distance along the normal, in the units of the files (default: a tenth of the diagonal of PLAIN)",
    )  # fmt: skip
    add_running_options(parser.add_argument_group("running"))


def run(arguments):
    """The command ``displacement-map``."""
    from .. import files
    from ..displacement_maps import configured_filter, map_extension, map_of

    algorithm = as_usage(
        configured_filter,
        resolution_of(arguments),
        arguments.gutter_width,
        arguments.vector_space,
        arguments.correspondence,
        arguments.maximum_distance,
    )
    for path in arguments.outputs:
        as_usage(map_extension, path)
    for path in (arguments.input, arguments.detailed):
        as_usage(files.extension, path)
    plain, detailed = (_surface(path) for path in (arguments.input, arguments.detailed))
    algorithm.SetInputDataObject(1, detailed)
    maps = map_of(algorithm, run_filter(algorithm, plain, arguments))
    as_usage(maps.write, *arguments.outputs)
    return Outcome(str(maps), maps.to_dict(), arguments.outputs)


def _surface(path):
    """The surface in a file, with a point for each texture coordinate; any surface may have several at a point."""
    from .. import files
    from .common import require_single, require_surface

    mesh = as_usage(files.read_mesh, path, seams="split")
    if mesh.GetNumberOfPoints() == 0:
        raise files.FormatError(f"{path}: the file holds no points")
    require_single(mesh, path)
    require_surface(mesh, path)
    return mesh
