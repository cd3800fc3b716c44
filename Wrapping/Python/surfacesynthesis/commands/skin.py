# SPDX-License-Identifier: BSD-3-Clause
"""The command ``skin``."""

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
Poses a body by the bones of a skeleton: moves each point with the bones that influence it, by linear blend or dual quaternion
skinning. The output is the input with its points moved."""
_EXAMPLES = """\
files: the format follows from the extension.
  .vtp .vtk               bodies with the weights of their bones as point arrays
  .vtm (.vtk)             composite datasets, posed block by block
  .csv                    bones with the columns Head:0 Head:1 Head:2 Parent and maybe Name; poses with Rotation:0 ...
                          Rotation:3, a quaternion w, x, y, z, and maybe Translation:0 Translation:1 Translation:2 and Name

examples:
  %(prog)s body.vtp run.vtp --bones bones.csv --pose run.csv
  %(prog)s body.vtp run.vtp --bones bones.csv --pose run.csv --skinning-method linear_blend
"""


def add(commands):
    """Adds the command to the parser."""
    parser = add_command(
        commands, "skin", "INPUT OUTPUT --bones FILE --pose FILE", "pose a body by its bones", _DESCRIPTION, _EXAMPLES
    )
    parser.set_defaults(run=run)
    parser.add_argument("input", metavar="INPUT", help="body to read: .vtp .vtk .vtm")
    parser.add_argument("output", metavar="OUTPUT", help="file to write: the same formats, .ply .stl .obj .off")
    skeleton = parser.add_argument_group("skeleton")
    skeleton.add_argument("--bones", required=True, metavar="FILE", help="table of bones (.csv)")
    skeleton.add_argument("--pose", required=True, metavar="FILE", help="table of the pose (.csv)")
    skeleton.add_argument(
        "--skinning-method",
        default="dual_quaternion",
        choices=["linear_blend", "dual_quaternion"],
        metavar="HOW",
        help="blending of the motions of bones: linear_blend or dual_quaternion (default)",
    )
    skeleton.add_argument(
        "--bone-index-array", default="BoneIndices", metavar="NAME",
        help='point array with the numbers of bones; "" where the weights have a component for each (default: %(default)s)',
    )  # fmt: skip
    skeleton.add_argument(
        "--bone-weight-array", default="BoneWeights", metavar="NAME", help="point array with weights (default: %(default)s)"
    )
    add_running_options(parser.add_argument_group("output"))
    add_reading_options(parser)


def run(arguments):
    """The command ``skin``."""
    from .. import files
    from ..skinning import configured_filter

    algorithm = as_usage(
        configured_filter,
        arguments.bones,
        arguments.pose,
        skinning_method=arguments.skinning_method,
        bone_index_array=arguments.bone_index_array or None,
        bone_weight_array=arguments.bone_weight_array,
    )
    for path in (arguments.input, arguments.output):
        as_usage(files.extension, path)
    mesh = read_input_surface(arguments)
    as_usage(files.check_writable, mesh, arguments.output)
    output = run_filter(algorithm, mesh, arguments)
    files.write_mesh(output, arguments.output)
    return written_outcome(output, [arguments.output], "posed: ")
