# SPDX-License-Identifier: BSD-3-Clause
"""The command ``surface``."""

from ..deprecation import add_former_option
from .common import (
    Outcome,
    UsageError,
    add_command,
    add_running_options,
    as_usage,
    require_surface,
    run_filter,
    size_of,
)

_DESCRIPTION = """\
Makes a closed manifold surface of a volume (CT, MR), or of a surface with holes, self-intersections and other defects.
The output is in the world coordinates of the input, of volumes in those of the scanner (--space)."""
_EXAMPLES = """\
files: the format follows from the extension.
  .nii .nii.gz .mgh .mgz                  volumes of NIfTI and FreeSurfer
  .dcm, or a folder                       volumes of DICOM: one file, or the series in a folder
  .mha .mhd .nrrd .vti                    volumes of ITK, NRRD and VTK
  .stl .ply .obj .off .vtp .vtk           surfaces to read, and to write
  .gii .glb .gltf                         the same, GIFTI and glTF
  .pial .white .inflated and others       FreeSurfer's surfaces to read
  .vtm (.vtk)                             composite datasets, processed block by block

examples:
  %(prog)s head.nii.gz skin.vtp --largest-component --fill-cavities
  %(prog)s series/ head.vtp --series 4 --iso-value 300
  %(prog)s ct.nrrd bone.stl --iso-value 300 --smoothing mean_curvature
  %(prog)s scan.ply closed.ply --voxel-size 0.5 --closing 2
"""


def add(commands):
    """Adds the command to the parser."""
    parser = add_command(
        commands, "surface", "INPUT OUTPUT", "make a closed surface of a volume or a broken surface", _DESCRIPTION, _EXAMPLES
    )
    parser.set_defaults(run=run)
    parser.add_argument("input", metavar="INPUT", help="volume or surface to read; a folder is a DICOM series")
    formats = ".vtp .vtk .vtm .stl .ply .obj .off .gii .glb .gltf"
    parser.add_argument("output", metavar="OUTPUT", help=f"surface to write: {formats}")
    _add_volume_options(parser)
    _add_solid_options(parser)


def _add_volume_options(parser):
    image = parser.add_argument_group("volumes")
    iso_value = image.add_argument(
        "--iso-value", type=float, metavar="V", help="value on the surface (default: from the histogram)"
    )
    inside = image.add_argument(
        "--inside",
        default="above",
        choices=["above", "below"],
        metavar="SIDE",
        help="solid side of the value: above (default) or below",
    )
    image.add_argument(
        "--space",
        default="RAS",
        choices=["RAS", "LPS", "file"],
        metavar="SPACE",
        help="coordinates of the output: RAS (default; x to the patient's right, y to the front, as NIfTI), "
        "LPS (x to the left, y to the back, as DICOM and ITK) or file (as the file has them)",
    )
    image.add_argument(
        "--array", metavar="NAME", help="array of points or cells to use, of .vti files (default: the active scalars)"
    )
    image.add_argument("--series", metavar="N", help="number or UID of the DICOM series, in folders with several")
    add_former_option(parser, "--iso", iso_value)
    add_former_option(parser, "--below", inside, "below")


def _add_solid_options(parser):
    solid = parser.add_argument_group("solid; lengths in units of the file, mm as a rule")
    solid.add_argument(
        "--voxel-size",
        type=float,
        metavar="H",
        help="side of the voxels (default: the smallest spacing, or 1/128 of a surface's longest side)",
    )
    solid.add_argument("--closing", type=float, default=0.0, metavar="R", help="fill gaps narrower than 2 R")
    solid.add_argument(
        "--smoothing",
        default="none",
        choices=["none", "gaussian", "mean_curvature", "median", "laplacian"],
        metavar="KIND",
        help="none (default), gaussian, mean_curvature, median or laplacian",
    )
    iterations = solid.add_argument(
        "--smoothing-iterations", type=int, default=3, metavar="N", help="number of smoothing steps (default: 3)"
    )
    solid.add_argument("--offset", type=float, default=0.0, metavar="D", help="move the surface outwards by D")
    solid.add_argument("--fill-cavities", action="store_true", help="fill the cavities of the solid")
    largest = solid.add_argument("--largest-component", action="store_true", help="keep the largest component only")
    solid.add_argument("--adaptivity", type=float, default=0.0, metavar="A", help="0 (default) to 1: larger triangles")
    solid.add_argument("--maximum-voxels", type=int, default=200_000_000, metavar="N", help="limit (default: 200000000)")
    add_running_options(solid)
    add_former_option(parser, "--iterations", iterations)
    add_former_option(parser, "--largest", largest)


def run(arguments):
    """The command ``surface``."""
    from .. import files

    surface = _filter_of(arguments)
    as_usage(files.extension, arguments.output)
    is_volume = files.volume_extension(arguments.input) is not None
    if not is_volume:
        as_usage(_surface_extension, files, arguments.input)
        if arguments.iso_value is not None:
            raise UsageError(f"--iso-value is a value of a volume, and {arguments.input} is read as a surface")
    given = as_usage(_read_volume, files, arguments) if is_volume else files.read_mesh(arguments.input)
    if given.GetNumberOfPoints() == 0:
        raise files.FormatError(f"{arguments.input}: the file holds no points")
    require_surface(given, arguments.input)
    output = run_filter(surface, given, arguments)
    as_usage(files.check_writable, output, arguments.output)
    files.write_mesh(output, arguments.output)
    parts = [f"{output.GetNumberOfPoints():,} points", f"{output.GetNumberOfCells():,} triangles"]
    if is_volume:
        parts.append(f"isovalue {surface.GetEffectiveIsoValue():.6g}")
    values = {"iso_value": surface.GetEffectiveIsoValue() if is_volume else None, **size_of(output)}
    return Outcome(", ".join(parts), values, [arguments.output])


def _read_volume(files, arguments):
    # names of arrays are for .vti files; elsewhere the filter says that there is none
    array = arguments.array if files.volume_extension(arguments.input) == ".vti" else None
    return files.read_volume(arguments.input, arguments.space, array, arguments.series)


def _surface_extension(files, path):
    """Raises ValueError, naming the volumes too, when ``path`` has no known extension."""
    try:
        files.extension(path)
    except ValueError as error:
        raise ValueError(f"{error}, or for volumes {', '.join(files.VOLUME_FORMATS)}") from None


def _filter_of(arguments):
    from ..vdb_surface import configured_filter

    return as_usage(
        configured_filter,
        iso_value=arguments.iso_value,
        inside=arguments.inside,
        voxel_size=arguments.voxel_size,
        closing=arguments.closing,
        smoothing=arguments.smoothing,
        smoothing_iterations=arguments.smoothing_iterations,
        offset=arguments.offset,
        adaptivity=arguments.adaptivity,
        fill_cavities=arguments.fill_cavities,
        largest_component=arguments.largest_component,
        maximum_voxels=arguments.maximum_voxels,
        array=arguments.array,
    )
