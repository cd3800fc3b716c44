# SPDX-License-Identifier: BSD-3-Clause
"""The command ``geometric-texture``."""

import os

from ..deprecation import add_former_option
from .common import (
    UsageError,
    add_command,
    add_reading_options,
    add_running_options,
    as_usage,
    printability_text,
    read_input_surface,
    run_filter,
    written_outcome,
)

_DESCRIPTION = """\
Synthesizes the geometric texture that a model has learned from one mesh on another, of any shape and genus. Without
INPUT on the template in the model file: samples of the mesh that the model was trained on."""
_EPILOG = """\
files: the format follows from the extension.
  .vtp .vtk               keep displacement, level and the arrays of the input
  .ply                    keeps the arrays of the points
  .stl .obj .off          keep the shape only
  .vtm (.vtk)             composite datasets, processed block by block

With --output-levels the surfaces after each level go to OUTPUT_0, OUTPUT_1, ..., numbered as the levels are, which
ParaView opens as a series in time.

examples:
  %(prog)s bunny.ply scaly.ply --model scales.safetensors --start-level 2 --seed 3
  %(prog)s bunny.ply large.ply --model scales.safetensors --prepare remesh --scale 2
  %(prog)s bunny.ply synthesis.vtp --model scales.safetensors --output-levels
  %(prog)s bunny.ply printed.stl --model scales.safetensors --start-level 2 --printable
  %(prog)s sample.ply --model scales.safetensors --random-from 1
"""


def add(commands):
    """Adds the command to the parser."""
    parser = add_command(
        commands,
        "geometric-texture",
        "[INPUT] OUTPUT --model FILE",
        "synthesize a learned geometric texture",
        _DESCRIPTION,
        _EPILOG,
    )
    parser.set_defaults(run=run)
    formats = ".stl .ply .obj .off .gii .glb .vtp .vtk .vtm"
    parser.add_argument("input", metavar="INPUT", nargs="?", help=f"surface to read: {formats}")
    parser.add_argument("output", metavar="OUTPUT", help="file to write: the same formats")
    texture = parser.add_argument_group("texture")
    texture.add_argument("--model", required=True, metavar="FILE", help="model file (safetensors)")
    texture.add_argument("--seed", type=int, default=0, metavar="N", help="any integer of 32 bits (default: 0)")
    texture.add_argument("--start-level", type=int, default=0, metavar="L", help="first generator level (default: 0)")
    texture.add_argument("--end-level", type=int, metavar="L", help="last generator level (default: the model's last)")
    texture.add_argument(
        "--noise-amplitude", type=float, metavar="A", help="in mean edge lengths (default: that of the training)"
    )
    texture.add_argument(
        "--restarts", type=int, metavar="N", help="of a model that is a flow at each level, 0 to 20 (default: 3)"
    )
    texture.add_argument(
        "--norm-statistics",
        choices=["target", "reference"],
        default="target",
        metavar="OF",
        help="statistics that normalize the networks: target (default), those on the whole input, as published; "
        "reference, those of the training, in the model file: the texture depends on what is nearby alone",
    )
    texture.add_argument(
        "--levels-without-noise", type=int, nargs="+", default=[], metavar="L", help="levels that get no noise"
    )
    texture.add_argument(
        "--second-seed", type=int, default=1, metavar="N", help="seed that --interpolation leads to (default: 1)"
    )
    texture.add_argument(
        "--interpolation", type=float, default=0.0, metavar="T", help="from seed to second seed, 0 to 1 (default: 0)"
    )
    texture.add_argument(
        "--scale", type=float, metavar="S", help="size of the texture over that on the input as it is (default: 1)"
    )
    texture.add_argument(
        "--prepare",
        choices=["as_is", "subdivide", "remesh"],
        metavar="HOW",
        help="preparation of the input, so that the texture gets the size --scale: subdivide (default with "
        "--scale; halves it as often as comes nearest), remesh (even triangles, for any size), as_is (default)",
    )
    texture.add_argument("--mask", metavar="NAME", help="point array, 0 to 1, that multiplies displacements")
    texture.add_argument(
        "--mask-falloff", type=float, default=0.0, metavar="D", help="distance over which it rises from where it is 0"
    )
    texture.add_argument(
        "--random-from", type=int, default=0, metavar="L", help="without INPUT: the first level with noise of the seed"
    )
    texture.add_argument(
        "--size", metavar="NAME", help="with --prepare remesh: point array that multiplies the size of the texture"
    )
    texture.add_argument("--second-model", metavar="FILE", help="another model, which --blend mixes with the first")
    texture.add_argument("--blend", metavar="NAME", help="point array, 0 for the first model to 1 for the second")
    texture.add_argument(
        "--strength", type=float, default=1.0, metavar="S", help="factor of the finished displacements (default: 1)"
    )
    texture.add_argument("--strength-array", metavar="NAME", help="point array, at least 0, that multiplies --strength")
    texture.add_argument(
        "--printable", action="store_true", help="reduce displacements until no triangles intersect, for 3D printers"
    )
    output = parser.add_argument_group("output")
    levels = output.add_argument(
        "--output-levels", action="store_true", help="write the surfaces after each level, by number"
    )
    add_running_options(output)
    add_reading_options(parser)
    add_former_option(parser, "--levels", levels)


def run(arguments):
    """The command ``geometric-texture``."""
    from .. import files
    from ..geometric_texture import configured_synthesizer

    algorithm = as_usage(
        configured_synthesizer,
        arguments.model,
        seed=arguments.seed,
        start_level=arguments.start_level,
        end_level=arguments.end_level,
        noise_amplitude=arguments.noise_amplitude,
        restarts=arguments.restarts,
        norm_statistics=arguments.norm_statistics,
        levels_without_noise=arguments.levels_without_noise,
        second_seed=arguments.second_seed,
        interpolation=arguments.interpolation,
        scale=arguments.scale,
        prepare=arguments.prepare,
        mask=arguments.mask,
        mask_falloff=arguments.mask_falloff,
        random_from=arguments.random_from,
        printable=arguments.printable,
        strength=arguments.strength,
        strength_array=arguments.strength_array,
        second_model=arguments.second_model,
        blend=arguments.blend,
        size=arguments.size,
        output_levels=arguments.output_levels,
    )
    for option in ("mask", "strength_array", "blend", "size"):
        if arguments.input is None and getattr(arguments, option) is not None:
            raise UsageError(f"--{option.replace('_', '-')} needs INPUT: the template has no arrays")
    mesh = None
    as_usage(files.extension, arguments.output)
    if arguments.input is not None:
        as_usage(files.extension, arguments.input)
        mesh = read_input_surface(arguments)
        as_usage(files.check_writable, mesh, arguments.output)
    output = run_filter(algorithm, mesh, arguments)
    written = _by_level(output, arguments.output) if arguments.output_levels else [(output, arguments.output)]
    files.write_meshes(written)
    described = algorithm.GetModelDescription()
    text, values = f"{described}: {printability_text(algorithm)}", {"model": described}
    if arguments.printable:
        values["height_kept"] = algorithm.GetHeightKept()
        values["number_of_self_intersections"] = algorithm.GetNumberOfSelfIntersections()
    return written_outcome(written[-1][0], [path for _, path in written], text, **values)


def _by_level(output, path):
    """Each block with the name of its file, numbered as its level is."""
    stem, kind = os.path.splitext(path)
    named = []
    for k in range(output.GetNumberOfBlocks()):
        level = output.GetMetaData(k).Get(output.NAME()).split()[-1]
        named.append((output.GetBlock(k), f"{stem}_{level}{kind}"))
    return named
