# SPDX-License-Identifier: BSD-3-Clause
"""The commands ``deform`` and ``sample``."""

import os

from ..deprecation import add_former_option
from .common import (
    Outcome,
    UsageError,
    add_command,
    add_coupling_options,
    add_reading_options,
    add_running_options,
    as_usage,
    coupling_of,
    read_input_surface,
    run_filter,
    size_of,
)

_DESCRIPTION = """\
Deforms a surface at random, as a flow matching model has learned it: poses, shapes, deformations. Works on any
triangulation of the shape that the model was trained on."""
_SAMPLE_DESCRIPTION = """\
Generates a signal on a surface at random, as a flow matching model has learned it: values at its points, with any number
of components. Works on any triangulation of the shape that the model was trained on."""
_FILES = """\
files: the format follows from the extension.
  .vtp .vtk               keep displacement, noise and area ratios as arrays
  .ply                    keeps the arrays of the points
  .stl .obj .off          keep the shape only{lost}
  .vtm (.vtk)             composite datasets, processed block by block; and several samples in one file

Several samples go to one .vtm file, a block for each, or to OUTPUT_0, OUTPUT_1, ... by number. With --trajectory the
states at flow times 0, 1 / STEPS, ..., 1 go to OUTPUT_0, OUTPUT_1, ..., which ParaView opens as a series in time.
"""
_EXAMPLES = """
examples:
  %(prog)s body.ply pose.ply --model poses.safetensors --seed 3
  %(prog)s body.ply poses.vtm --model poses.safetensors --samples 8
  %(prog)s body.ply denoising.vtp --model poses.safetensors --steps 50 --trajectory
"""
_SAMPLE_EXAMPLES = """
examples:
  %(prog)s heart.vtp heat.vtp --model heat.safetensors --seed 3
  %(prog)s heart.vtp ensemble.vtm --model heat.safetensors --samples 50
"""


def add(commands):
    """Adds both commands to the parser."""
    files = _FILES.format(lost="")
    parser = _add(commands, "deform", "deform a surface by a trained model", _DESCRIPTION, files + _EXAMPLES)
    parser.set_defaults(run=run, configure="configured_deformer")
    files = _FILES.format(lost=", without the signal").replace("displacement, noise and area ratios", "signal and noise")
    parser = _add(commands, "sample", "generate a signal by a trained model", _SAMPLE_DESCRIPTION, files + _SAMPLE_EXAMPLES)
    parser.set_defaults(run=run, configure="configured_sampler")
    parser.add_argument("--name", metavar="NAME", help="name of the array (default: that in the model file)")


def _add(commands, name, text, description, epilog):
    parser = add_command(commands, name, "INPUT OUTPUT --model FILE", text, description, epilog)
    parser.add_argument("input", metavar="INPUT", help="surface to read: .stl .ply .obj .off .gii .glb .vtp .vtk .vtm")
    parser.add_argument("output", metavar="OUTPUT", help="file to write: the same formats")
    flow = parser.add_argument_group("flow")
    flow.add_argument("--model", required=True, metavar="FILE", help="model file (safetensors)")
    flow.add_argument("--seed", type=int, default=0, metavar="N", help="any integer of 32 bits (default: 0)")
    noise = flow.add_argument(
        "--input-noise", metavar="NAME", help="point array of INPUT with the initial noise (default: that of the seed)"
    )
    flow.add_argument("--samples", type=int, metavar="N", help="number of samples (default: 1)")
    flow.add_argument("--first-sample", type=int, default=0, metavar="K", help="index of the first (default: 0)")
    flow.add_argument(
        "--memory-limit", type=int, metavar="MIB", help="memory of the output, MiB (default: 3/4 of the machine's)"
    )
    flow.add_argument("--steps", type=int, default=20, metavar="N", help="steps from noise to sample (default: 20)")
    flow.add_argument(
        "--integrator",
        default="midpoint",
        choices=["euler", "midpoint", "runge_kutta_4"],
        metavar="HOW",
        help="method of a step: euler, midpoint (default) or runge_kutta_4",
    )
    flow.add_argument(
        "--corrections",
        type=int,
        metavar="N",
        help="corrections of a sample at the end of its flow (default: 2 for models that predict data, else 0)",
    )
    flow.add_argument(
        "--temperature", type=float, default=1.0, metavar="X", help="factor of the noise, 0 to 10: above 1 varies more (default: 1)"
    )
    add_coupling_options(flow)
    flow.add_argument(
        "--normalization-area",
        type=float,
        metavar="A",
        help="area of the surface that INPUT is a part or damaged copy of (default: of INPUT)",
    )
    flow.add_argument(
        "--normalization-center", type=float, nargs=3, metavar=("X", "Y", "Z"), help="centroid of that surface, by area"
    )
    output = parser.add_argument_group("output")
    output.add_argument("--trajectory", action="store_true", help="write the states at all flow times, by number")
    add_running_options(output)
    add_reading_options(parser)
    add_former_option(parser, "--noise", noise)
    return parser


def run(arguments):
    """The command ``deform`` or ``sample``."""
    from .. import files, flow_matching
    from ..flow_matching import flow_times

    named = {"name": arguments.name} if getattr(arguments, "name", None) is not None else {}
    algorithm = as_usage(
        getattr(flow_matching, arguments.configure),
        arguments.model,
        seed=arguments.seed,
        input_noise=arguments.input_noise,
        samples=arguments.samples,
        first_sample=arguments.first_sample,
        memory_limit=arguments.memory_limit,
        steps=arguments.steps,
        integrator=arguments.integrator,
        corrections=arguments.corrections,
        temperature=arguments.temperature,
        trajectory=arguments.trajectory,
        **coupling_of(arguments),
        normalization_area=arguments.normalization_area,
        normalization_center=arguments.normalization_center,
        **named,
    )
    as_usage(files.extension, arguments.input)
    kind = as_usage(files.extension, arguments.output)
    several = algorithm.GetNumberOfSamples() > 1
    if several and arguments.trajectory and kind != ".vtm":
        raise UsageError("several samples with --trajectory need a .vtm file for each flow time: name OUTPUT.vtm")
    mesh = read_input_surface(arguments)
    if not (several and kind == ".vtm"):
        as_usage(files.check_writable, mesh, arguments.output)
    outputs = run_filter(algorithm, mesh, arguments, flow_times(algorithm) if arguments.trajectory else None)
    written = _named(outputs, arguments) if arguments.trajectory else _split(outputs, arguments, several, kind)
    files.write_meshes(written)
    described = algorithm.GetModelDescription()
    values = {"model": described, "samples": algorithm.GetNumberOfSamples(), **size_of(mesh)}
    return Outcome(f"{described}: {mesh.GetNumberOfPoints():,} points", values, [path for _, path in written])


def _named(datasets, arguments, first=0):
    """Each dataset with the name of its file, by number."""
    stem, kind = os.path.splitext(arguments.output)
    return [(dataset, f"{stem}_{first + k}{kind}") for k, dataset in enumerate(datasets)]


def _split(output, arguments, several, kind):
    """One file, or one for each sample."""
    if not several or kind == ".vtm":
        return [(output, arguments.output)]
    blocks = [output.GetBlock(k) for k in range(output.GetNumberOfBlocks())]
    return _named(blocks, arguments, arguments.first_sample)
