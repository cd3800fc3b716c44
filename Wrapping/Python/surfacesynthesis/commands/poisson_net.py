# SPDX-License-Identifier: BSD-3-Clause
"""The command ``poisson-net``."""

from ..deprecation import add_former_option
from .common import (
    UsageError,
    add_command,
    add_coupling_options,
    add_reading_options,
    add_running_options,
    as_usage,
    coupling_of,
    read_input,
    run_filter,
    written_outcome,
)

_DESCRIPTION = """\
Evaluates a trained PoissonNet on a surface: segmentation, classification, features or predicted shapes, whatever the
model file describes. The output is the input with the prediction as an array."""
_EXAMPLES = """\
files: the format follows from the extension.
  .vtp .vtk               keep all arrays
  .ply                    keeps arrays of the points
  .stl .obj .off          keep the shape only: use --warp with a model that predicts positions
  .vtm (.vtk)             composite datasets, processed block by block

examples:
  %(prog)s body.ply parts.vtp --model segmentation.safetensors --normalization surface_area
  %(prog)s flat.obj crumpled.obj --model crumpling.safetensors --conditions 0.5 --warp 1
"""


def add(commands):
    """Adds the command to the parser."""
    parser = add_command(
        commands, "poisson-net", "INPUT OUTPUT --model FILE", "evaluate a trained network", _DESCRIPTION, _EXAMPLES
    )
    parser.set_defaults(run=run)
    parser.add_argument("input", metavar="INPUT", help="surface to read: .stl .ply .obj .off .gii .glb .vtp .vtk .vtm")
    parser.add_argument("output", metavar="OUTPUT", help="file to write: the same formats")
    network = parser.add_argument_group("network")
    network.add_argument("--model", required=True, metavar="FILE", help="model file (safetensors)")
    network.add_argument(
        "--conditions", type=float, nargs="+", metavar="X", help="conditions of the model, the same for all points"
    )
    network.add_argument("--condition-array", metavar="NAME", help="point array with the conditions of each point")
    network.add_argument("--signal", metavar="NAME", help="point array that the network takes, not the positions")
    normalization = network.add_argument(
        "--normalization",
        default="model",
        choices=["model", "none", "surface_area", "unit_sphere"],
        metavar="HOW",
        help="normalisation of the mesh: model (default: as the file says), none, surface_area, unit_sphere",
    )
    add_coupling_options(network)
    output = parser.add_argument_group("output")
    output.add_argument("--name", default="Prediction", metavar="NAME", help="name of the array (default: %(default)s)")
    output.add_argument("--label-name", default="Label", metavar="NAME", help="name of the labels (default: Label)")
    output.add_argument(
        "--warp", type=float, metavar="SCALE", help="move the points by SCALE times the way to the predicted positions"
    )
    add_running_options(output)
    add_reading_options(parser)
    add_former_option(parser, "--normalisation", normalization)


def run(arguments):
    """The command ``poisson-net``."""
    from .. import files
    from ..poisson_net import configured_filter

    if arguments.conditions is not None and arguments.condition_array is not None:
        raise UsageError("--conditions and --condition-array exclude each other")
    algorithm = as_usage(
        configured_filter,
        arguments.model,
        conditions=arguments.condition_array or arguments.conditions,
        signal=arguments.signal,
        normalization=arguments.normalization,
        name=arguments.name,
        label_name=arguments.label_name,
        **coupling_of(arguments),
    )
    as_usage(files.extension, arguments.input)
    kind = as_usage(files.extension, arguments.output)
    if arguments.warp is None and kind in files.GEOMETRY_ONLY:
        raise UsageError(f"{kind} files cannot hold the prediction: write .vtp or .vtk, or move points with --warp SCALE")
    if arguments.warp is not None and not abs(arguments.warp) < float("inf"):
        raise UsageError(f"--warp must be a finite number, not {arguments.warp:g}")
    mesh = read_input(arguments)
    if mesh.GetNumberOfPoints() == 0:
        raise files.FormatError(f"{arguments.input}: the file holds no points")
    as_usage(files.check_writable, mesh, arguments.output)
    output = run_filter(algorithm, mesh, arguments)
    if arguments.warp is not None:
        output = _moved(output, arguments, algorithm)
    files.write_mesh(output, arguments.output)
    described = algorithm.GetModelDescription()
    return written_outcome(output, [arguments.output], f"{described}: ", model=described)


def _moved(output, arguments, algorithm):
    from ..errors import SurfaceSynthesisError
    from ..warp import warped

    if not algorithm.GetModelDescription().startswith("positions"):
        raise SurfaceSynthesisError(f"{arguments.model}: the model predicts no positions, which --warp needs")
    return warped(output, algorithm.GetDisplacementArrayName(), arguments.warp)
