# SPDX-License-Identifier: BSD-3-Clause
"""The command ``geometric-texture-from-example``."""

import os

from .common import (
    UsageError,
    add_command,
    add_reading_options,
    add_running_options,
    as_usage,
    printability_text,
    read_input_surface,
    read_single_surface,
    run_filter,
    written_outcome,
)

_DESCRIPTION = """\
Synthesizes the geometric texture of an example surface, such as a piece of a scan, on another of any shape and genus, without a
training. Triangles of TARGET stand for triangles of EXAMPLE, unless --texture-scale says how large the texture is. Three pieces of
scans come with the library, under the names cortex, mane (curls in rows, with a direction) and mountains."""
_EPILOG = """\
files: the format follows from the extension.
  .vtp .vtk               keep displacement and the arrays of TARGET
  .ply                    keeps the arrays of the points
  .stl .obj .off          keep the shape only
  .vtm (.vtk)             composite datasets as TARGET, processed block by block

  .safetensors            example files, as EXAMPLE

examples:
  %(prog)s bunny.ply cortex folded.ply
  %(prog)s bunny.ply scan.ply scaly.ply
  %(prog)s bunny.ply scan.ply scaly.ply --plain-example smooth.ply --seed 3 --strength 0.5
  %(prog)s bunny.ply scan.ply printed.stl --printable
  %(prog)s bunny.ply scan.ply large.vtp --texture-scale 2 --subdivisions 1
  %(prog)s horn.vtp bark.vtp grown.vtp --orientation Growth --example-orientation Growth --mask Grown
  %(prog)s horn.vtp bark.vtp mixed.vtp --second-example scan.ply --blend Grown
"""


def add(commands):
    """Adds the command to the parser."""
    parser = add_command(
        commands,
        "geometric-texture-from-example",
        "TARGET EXAMPLE OUTPUT",
        "synthesize the geometric texture of an example",
        _DESCRIPTION,
        _EPILOG,
    )
    parser.set_defaults(run=run)
    formats = ".stl .ply .obj .off .gii .glb .vtp .vtk .vtm"
    parser.add_argument("input", metavar="TARGET", help=f"surface that gets the texture: {formats}")
    parser.add_argument(
        "example", metavar="EXAMPLE",
        help="surface with the texture: the same formats, an example file, or the name of an installed example: cortex, mane, "
        "mountains",
    )  # fmt: skip
    parser.add_argument("output", metavar="OUTPUT", help="file to write: the same formats")
    _add_texture_options(parser.add_argument_group("texture"))
    add_running_options(parser.add_argument_group("output"))
    add_reading_options(parser)


def _add_texture_options(texture):
    texture.add_argument(
        "--plain-example", metavar="FILE",
        help="EXAMPLE without its texture, with the same triangles (default: EXAMPLE, smoothed)",
    )  # fmt: skip
    texture.add_argument("--seed", type=int, default=0, metavar="N", help="any integer of 32 bits (default: 0)")
    texture.add_argument(
        "--texture-scale", type=float, metavar="S",
        help="size of the texture on TARGET over that on EXAMPLE, both in the units of the files (default: the ratio of their "
        "mean edge lengths)",
    )  # fmt: skip
    texture.add_argument(
        "--subdivisions", type=int, metavar="N",
        help="number of times that triangles of TARGET are divided into four, 0 to 8 (default: 2; with --texture-scale as "
        "many as make edges as long as those of EXAMPLE at that scale)",
    )  # fmt: skip
    texture.add_argument(
        "--scales", type=int, metavar="N",
        help="number of scales, 1 to 8 (default: as many as make the widest patches about three features wide; of two examples "
        "the larger of both numbers, as far as patches fit on both)",
    )  # fmt: skip
    texture.add_argument(
        "--smoothing-length", type=float, metavar="LENGTH",
        help="length over which EXAMPLE is smoothed without --plain-example, in the units of the file (default: a tenth of the "
        "root of the area; that of an example file)",
    )  # fmt: skip
    texture.add_argument(
        "--orientation", metavar="NAME", help="point array of TARGET with the direction of the texture, 3 components"
    )
    texture.add_argument(
        "--example-orientation", metavar="NAME",
        help="point array of EXAMPLE with the direction of its texture; example files hold it",
    )
    texture.add_argument("--size", metavar="NAME", help="point array of TARGET, 0.1 to 10, that multiplies the size")
    texture.add_argument("--mask", metavar="NAME", help="point array of TARGET, 0 to 1, that multiplies displacements")
    texture.add_argument(
        "--second-example", metavar="FILE",
        help="surface with a second texture, as EXAMPLE, for a blend; goes with --blend",
    )
    texture.add_argument(
        "--second-plain-example", metavar="FILE",
        help="second example without its texture, with the same triangles (default: the second example, smoothed)",
    )  # fmt: skip
    texture.add_argument(
        "--second-smoothing-length", type=float, metavar="LENGTH",
        help="--smoothing-length of the second example, in the units of its file",
    )  # fmt: skip
    texture.add_argument(
        "--blend", metavar="NAME", help="point array of TARGET, 0 to 1, share of the area with features of the second example"
    )
    texture.add_argument("--strength", type=float, default=1.0, metavar="S", help="factor of displacements (default: 1)")
    texture.add_argument(
        "--printable", action="store_true", help="reduce displacements until no triangles intersect, for 3D printers"
    )


def run(arguments):
    """The command ``geometric-texture-from-example``."""
    from .. import files
    from ..geometric_texture_from_example import add_field_arrays, configured_filter, give_examples

    algorithm = as_usage(
        configured_filter,
        seed=arguments.seed,
        texture_scale=arguments.texture_scale,
        subdivisions=arguments.subdivisions,
        scales=arguments.scales,
        smoothing_length=arguments.smoothing_length,
        orientation=arguments.orientation,
        example_orientation=arguments.example_orientation,
        size=arguments.size,
        mask=arguments.mask,
        strength=arguments.strength,
        printable=arguments.printable,
        second_smoothing_length=arguments.second_smoothing_length,
        blend=arguments.blend,
    )
    if arguments.smoothing_length is not None and arguments.plain_example is not None:
        raise UsageError("--smoothing-length is of no use with --plain-example")
    if (arguments.second_example is None) != (arguments.blend is None):
        raise UsageError("--second-example and --blend go together")
    of_second = (arguments.second_plain_example, arguments.second_smoothing_length)
    if arguments.second_example is None and of_second != (None, None):
        raise UsageError("--second-plain-example and --second-smoothing-length are of no use without --second-example")
    if None not in of_second:
        raise UsageError("--second-smoothing-length is of no use with --second-plain-example")
    if _is_example_file(arguments.example) and arguments.plain_example is not None:
        raise UsageError("--plain-example goes with a surface as EXAMPLE, not with an example file")
    if _is_example_file(arguments.second_example) and arguments.second_plain_example is not None:
        raise UsageError("--second-plain-example goes with a surface as --second-example, not with an example file")
    examples = (arguments.example, arguments.plain_example, arguments.second_example, arguments.second_plain_example)
    surfaces = [path for path in (arguments.example, arguments.second_example) if not _is_example_file(path)]
    for path in (arguments.input, *surfaces, arguments.plain_example, arguments.second_plain_example, arguments.output):
        if path is not None:
            as_usage(files.extension, path)
    mesh = read_input_surface(arguments)
    as_usage(give_examples, algorithm, *(_example(path) for path in examples))
    as_usage(files.check_writable, mesh, arguments.output)
    output = run_filter(algorithm, mesh, arguments)
    add_field_arrays(algorithm, output)
    files.write_mesh(output, arguments.output)
    return _outcome(algorithm, output, arguments.output)


def _is_example_file(path):
    """True for an example file, and for a name without a folder and an extension."""
    if path is None:
        return False
    return os.path.splitext(path)[1] == ".safetensors" or os.path.basename(path) == path and "." not in path


def _example(path):
    """What geometric_texture_from_example() takes for the path of an example, or None."""
    return path if path is None or _is_example_file(path) else read_single_surface(path)


def _outcome(algorithm, output, path):
    """The Outcome of the values that the filter used and reached, and of the file that was written."""
    from ..geometric_texture_from_example import results_of
    from ..vocabulary import snake

    values = {snake(name.replace("NumberOfScales", "Scales")): value for name, value in results_of(algorithm).items()}
    text = "texture scale {texture_scale:.4g}, {subdivisions} subdivisions, {scales} scales, mismatch {mismatch:.3g}, "
    return written_outcome(output, [path], text.format(**values) + printability_text(algorithm), **values)
