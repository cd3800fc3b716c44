# SPDX-License-Identifier: BSD-3-Clause
"""The command ``label-surfaces``."""

from .common import Outcome, UsageError, add_command, add_running_options, as_usage, run_filter

_DESCRIPTION = """\
Makes a named surface of each label of a label map: the regions of an atlas or a segmentation. Touching labels share the
points and triangles of their border, and each keeps the volume of its samples. The output is in the world coordinates of
the scanner (--space)."""
_EXAMPLES = """\
files: volumes .nii .nii.gz .mgh .mgz .mha .mhd .nrrd .vti; tables of names are text files with a number and a name in each
line, as those of MRIcron, FreeSurfer and ITK-SNAP.

examples:
  %(prog)s aal.nii.gz aal.vtm --names aal.nii.txt
  %(prog)s aseg.nii.gz hippocampi.vtm --names FreeSurferColorLUT.txt --labels 17 53
"""


def add(commands):
    """Adds the command to the parser."""
    parser = add_command(
        commands, "label-surfaces", "INPUT OUTPUT", "make a named surface of each label of a volume", _DESCRIPTION, _EXAMPLES
    )
    parser.set_defaults(run=run)
    parser.add_argument("input", metavar="INPUT", help="label map to read")
    parser.add_argument("output", metavar="OUTPUT", help="surfaces to write: .vtm .vtk .glb .gltf; of one label others too")
    labels = parser.add_argument_group("labels")
    labels.add_argument("--names", metavar="FILE", help='text file with the names of the labels (default: "Label 5")')
    labels.add_argument(
        "--labels", nargs="+", type=int, default=[], metavar="L", help="labels of which surfaces are made (default: all)"
    )
    labels.add_argument(
        "--space",
        default="RAS",
        choices=["RAS", "LPS", "file"],
        metavar="SPACE",
        help="coordinates of the output: RAS (default), LPS or file (as the file has them)",
    )
    labels.add_argument("--array", metavar="NAME", help="array of points or cells to use, of .vti files")
    surfaces = parser.add_argument_group("surfaces")
    surfaces.add_argument(
        "--smoothing-iterations", type=int, default=30, metavar="N", help="number of smoothing steps (default: 30)"
    )
    surfaces.add_argument(
        "--no-preserve-volume", action="store_false", dest="preserve_volume", help="leave the volume that smoothing gives"
    )
    surfaces.add_argument(
        "--no-shared-borders", action="store_false", dest="shared_borders", help="smooth each label by itself"
    )
    add_running_options(parser.add_argument_group("output"), csv="labels, names and volumes")


def run(arguments):
    """The command ``label-surfaces``."""
    from .. import files
    from ..label_surfaces import configured_filter, labels_at_points, measures_of

    algorithm = as_usage(
        configured_filter,
        arguments.names,
        arguments.labels,
        arguments.smoothing_iterations,
        arguments.preserve_volume,
        arguments.shared_borders,
        arguments.array,
    )
    as_usage(files.extension, arguments.output)
    kind = files.volume_extension(arguments.input)
    if kind is None:
        raise UsageError(f"{arguments.input}: a volume is needed: {', '.join(files.VOLUME_FORMATS)}")
    array = arguments.array if kind == ".vti" else None
    volume = as_usage(files.read_volume, arguments.input, arguments.space, array)
    surfaces = run_filter(algorithm, labels_at_points(volume, array), arguments)
    rows = measures_of(surfaces)
    written = surfaces.GetBlock(0) if len(rows) == 1 and files.extension(arguments.output) != ".vtm" else surfaces
    as_usage(files.check_writable, written, arguments.output)
    files.write_mesh(written, arguments.output)
    points = sum(row["points"] for row in rows)
    table = _table(rows) if arguments.csv else None
    text = f"{len(rows)} labels, {points:,} points"
    return Outcome(text, {"labels": rows, "points": points}, [arguments.output], table=table)


def _table(rows):
    """The measures of the labels as comma-separated values."""
    lines = [f'{row["label"]},"{row["name"]}",{row["points"]},{row["triangles"]},{row["volume"]!r}' for row in rows]
    return "\n".join(["label,name,points,triangles,volume", *lines])
