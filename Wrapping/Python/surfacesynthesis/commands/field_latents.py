# SPDX-License-Identifier: BSD-3-Clause
"""The commands ``encode-texture``, ``decode-texture`` and ``transfer-texture``."""

import sys

from .common import ProgressBar, UsageError, add_command, add_running_options, as_usage, set_threads, written_outcome
from .texture_atlas import add_resolution, resolution_of

_ENCODE = """\
Encodes the texture of a surface as field latents: tangent vectors at its points, which any triangulation of the shape can
carry. decode-texture makes a texture of them again."""
_ENCODE_EXAMPLES = """\
files: INPUT .obj (with .mtl and an image) .gltf .glb .ply with their texture, or any surface with texture coordinates and
--image, or any surface with colors at its points; OUTPUT .vtp or .vtk

examples:
  %(prog)s duck.obj duck.vtp --model latents.safetensors
  %(prog)s duck.glb duck.vtp --model latents.safetensors --image bark.png
"""
_DECODE = """\
Decodes field latents to a texture, on the surface that has them or on another one of the same shape."""
_DECODE_EXAMPLES = """\
files: INPUT .vtp or .vtk as encode-texture writes it; OUTPUT .obj (with .mtl and .png), .gltf, .glb or .ply with its texture;
.png, the image only; .vtp or .vtk with colors at points

examples:
  %(prog)s duck.vtp duck.obj --model latents.safetensors --resolution 64
  %(prog)s duck.vtp duck.png --model latents.safetensors --resolution 64 32
  %(prog)s duck.vtp fine.glb --model latents.safetensors --target fine.off
"""
_TRANSFER = """\
Lays the texture of a surface on another triangulation, or another atlas, of the same shape: encodes it on SOURCE, and
decodes it on TARGET, which gets an atlas where it has no texture coordinates."""
_TRANSFER_EXAMPLES = """\
files: SOURCE .obj (with .mtl and an image) .gltf .glb .ply with their texture; TARGET any surface; OUTPUT .obj (with .mtl and
.png), .gltf, .glb or .ply with its texture; .png, the image only; .vtp or .vtk with colors at points

examples:
  %(prog)s duck.obj fine.off fine.obj --model latents.safetensors --resolution 64
"""
_WITH_TEXTURE = (".obj", ".gltf", ".glb", ".ply")


def add(commands):
    """Adds the commands to the parser."""
    parser = add_command(
        commands, "encode-texture", "INPUT OUTPUT", "encode a texture as field latents", _ENCODE, _ENCODE_EXAMPLES
    )
    parser.set_defaults(run=run_encode)
    parser.add_argument("input", metavar="INPUT", help="textured surface to read")
    parser.add_argument("output", metavar="OUTPUT", help="file to write")
    _add_options(parser, encodes=True)
    parser = add_command(
        commands, "decode-texture", "INPUT OUTPUT", "decode field latents to a texture", _DECODE, _DECODE_EXAMPLES
    )
    parser.set_defaults(run=run_decode)
    parser.add_argument("input", metavar="INPUT", help="surface with field latents to read")
    parser.add_argument("output", metavar="OUTPUT", help="file to write")
    parser.add_argument(
        "--target",
        metavar="FILE",
        help="surface that gets the texture; without texture coordinates it gets an atlas (default: INPUT)",
    )
    _add_options(parser, decodes=True)
    parser = add_command(
        commands,
        "transfer-texture",
        "SOURCE TARGET OUTPUT",
        "lay a texture on another triangulation",
        _TRANSFER,
        _TRANSFER_EXAMPLES,
    )
    parser.set_defaults(run=run_transfer)
    parser.add_argument("input", metavar="SOURCE", help="textured surface to read")
    parser.add_argument("target", metavar="TARGET", help="surface that gets the texture, and an atlas if it has none")
    parser.add_argument("output", metavar="OUTPUT", help="file to write")
    _add_options(parser, encodes=True, decodes=True)


def _add_options(parser, encodes=False, decodes=False):
    options = parser.add_argument_group("texture")
    options.add_argument(
        "--model",
        default="field_latents",
        metavar="FILE",
        help="model file of field latents, or the name of an installed model (default: field_latents)",
    )
    if encodes:
        options.add_argument("--image", metavar="FILE", help="texture, in place of the one that the file names")
    if decodes:
        add_resolution(options, "texture")
    add_running_options(parser.add_argument_group("running"))


def run_encode(arguments):
    """The command ``encode-texture``."""
    from .. import files

    if as_usage(files.extension, arguments.output) not in (".vtp", ".vtk"):
        raise UsageError(f"{arguments.output}: field latents are written to .vtp or .vtk")
    mesh, image = textured_input(arguments)
    as_usage(files.check_writable, mesh, arguments.output)
    (output,) = _with_bar(arguments, [lambda bar: _encoded(arguments, mesh, image, bar)])
    files.write_mesh(output, arguments.output)
    return written_outcome(output, [arguments.output])


def run_decode(arguments):
    """The command ``decode-texture``."""
    from .. import files

    check_texture_output(arguments)
    as_usage(files.extension, arguments.input)
    mesh = files.read_mesh(arguments.input)
    target = None if arguments.target is None else _target(arguments)
    (decoded,) = _with_bar(arguments, [lambda bar: _decoded(arguments, mesh, target, bar)])
    write_texture(*decoded, arguments.output)
    return written_outcome(decoded[0], [arguments.output])


def run_transfer(arguments):
    """The command ``transfer-texture``."""
    check_texture_output(arguments)
    mesh, image = textured_input(arguments)
    target = _target(arguments)
    held = []
    steps = [
        lambda bar: held.append(_encoded(arguments, mesh, image, bar)),
        lambda bar: _decoded(arguments, held[0], target, bar),
    ]
    _, decoded = _with_bar(arguments, steps)
    write_texture(*decoded, arguments.output)
    return written_outcome(decoded[0], [arguments.output])


def textured_input(arguments):
    """The surface in the file INPUT, and its texture or that of --image."""
    from ..errors import FormatError
    from ..files.images import read_image
    from ..textured_files import read_textured_mesh

    mesh, image = as_usage(read_textured_mesh, arguments.input)
    if arguments.image is not None:
        image = read_image(arguments.image)
    if image is None and color_of(mesh) is None and mesh.GetPointData().GetScalars() is None:
        raise FormatError(f"{arguments.input}: the surface has no texture and no colors; --image names a texture")
    return mesh, image


def color_of(mesh):
    """The name of the colors of points that files have; None without."""
    return next((name for name in ("RGB", "RGBA") if mesh.GetPointData().HasArray(name)), None)


def _target(arguments):
    """The surface that gets the texture, with texture coordinates."""
    from ..atlases import texture_atlas
    from ..textured_files import read_textured_mesh

    target, _ = as_usage(read_textured_mesh, arguments.target)
    if target.GetPointData().GetTCoords() is None:
        target = texture_atlas(target, resolution=resolution_of(arguments))
    return target


def _encoded(arguments, mesh, image, bar):
    from ..field_latents import encode_texture

    color = color_of(mesh) if image is None else None
    return as_usage(encode_texture, mesh, image, model=arguments.model, color=color, progress=bar)


def _decoded(arguments, mesh, target, bar):
    from ..field_latents import decode_texture

    return as_usage(
        decode_texture,
        mesh,
        model=arguments.model,
        target=target,
        resolution=resolution_of(arguments),
        progress=bar,
    )


def _with_bar(arguments, steps):
    """The results of some steps, functions of a progress callable, with one bar for all."""
    set_threads(arguments.threads)
    bar = ProgressBar(sys.stderr, not (arguments.no_progress or arguments.quiet))
    try:
        return [
            step(lambda fraction, number=number: bar((number + fraction) / len(steps)))
            for number, step in enumerate(steps)
        ]
    finally:
        bar.clear()


def check_texture_output(arguments):
    """Raises UsageError when OUTPUT is nothing that a decoded texture is written to."""
    if not arguments.output.lower().endswith((*_WITH_TEXTURE, ".png", ".vtp", ".vtk")):
        known = ", ".join((*_WITH_TEXTURE, ".png", ".vtp", ".vtk"))
        raise UsageError(f"{arguments.output}: a decoded texture is written to one of {known}")
    as_usage(resolution_of, arguments)


def write_texture(mesh, image, path):
    """Writes a surface with its texture, or one of them, as the extension of the file says."""
    from .. import files
    from ..textured_files import write_image, write_textured_mesh

    kind = path.lower().rpartition(".")[2]
    if kind == "png":
        write_image(image, path)
    elif kind in ("vtp", "vtk"):
        files.write_mesh(mesh, path)
    else:
        write_textured_mesh(mesh, image, path)
