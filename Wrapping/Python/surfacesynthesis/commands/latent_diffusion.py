# SPDX-License-Identifier: BSD-3-Clause
"""The command ``sample-texture``."""

import os
import sys

from .common import (
    ProgressBar,
    UsageError,
    add_command,
    add_running_options,
    as_usage,
    set_threads,
    written_outcome,
)
from .field_latents import check_texture_output, color_of, textured_input, write_texture
from .texture_atlas import add_resolution, resolution_of

_DESCRIPTION = """\
Samples new textures for a surface with a diffusion model of field latents: like the texture that the model was trained on,
on any surface."""
_EXAMPLES = """\
files: INPUT any surface, which gets an atlas where it has no texture coordinates; OUTPUT .obj (with .mtl and .png), .gltf,
.glb or .ply with its texture; .png, the image only; .vtp or .vtk with colors at points. Several samples go to OUTPUT_0,
OUTPUT_1, ... by number, and so do the states of one sample with --trajectory, from noise to the texture.

examples:
  %(prog)s duck.off bark.obj --model bark.safetensors --autoencoder latents.safetensors --resolution 64
  %(prog)s painted.vtp filled.glb --model bark.safetensors --autoencoder latents.safetensors --mask Kept --resolution 64
"""


def add(commands):
    """Adds the command to the parser."""
    parser = add_command(
        commands, "sample-texture", "INPUT OUTPUT --model FILE", "sample new textures", _DESCRIPTION, _EXAMPLES
    )
    parser.set_defaults(run=run)
    parser.add_argument("input", metavar="INPUT", help="surface to read")
    parser.add_argument("output", metavar="OUTPUT", help="file to write")
    group = parser.add_argument_group("texture")
    group.add_argument("--model", required=True, metavar="FILE", help="diffusion model, or the name of an installed one")
    group.add_argument(
        "--autoencoder",
        default="field_latents",
        metavar="FILE",
        help="model file of field latents, or the name of an installed model (default: field_latents)",
    )
    group.add_argument("--seed", type=int, default=0, metavar="N", help="any integer (default: 0)")
    group.add_argument("--samples", type=int, metavar="N", help="number of samples (default: one)")
    group.add_argument("--first-sample", type=int, default=0, metavar="N", help="index of the first one (default: 0)")
    group.add_argument(
        "--points", type=int, metavar="N", help="vertices that carry the texture; four times as many halve its size"
    )
    group.add_argument(
        "--triangulation",
        default="remesh",
        choices=["remesh", "as_is"],
        metavar="TRIANGULATION",
        help="remesh (default): even triangles with --points vertices; as_is: those of INPUT",
    )
    group.add_argument("--sampler", default="ddim", choices=["ddim", "ddpm"], metavar="SAMPLER", help="ddim (default) or ddpm")
    group.add_argument("--steps", type=int, default=50, metavar="N", help="evaluations of the network (default: 50)")
    add_resolution(group, "texture")
    group.add_argument("--trajectory", action="store_true", help="write all states from noise to the texture, by number")
    guidance = parser.add_argument_group("guidance")
    guidance.add_argument("--label", metavar="NAME", help="point array with labels, for models that have some")
    guidance.add_argument("--direction", metavar="NAME", help="point array with vectors, for directed models")
    guidance.add_argument("--mask", metavar="NAME", help="point array, 1 where the texture of INPUT is kept")
    guidance.add_argument("--image", metavar="FILE", help="texture of INPUT, in place of the one that the file names")
    add_running_options(parser.add_argument_group("running"))


def run(arguments):
    """The command ``sample-texture``."""
    from ..latent_diffusion import sample_texture

    check_texture_output(arguments)
    mesh, image = _input(arguments)
    set_threads(arguments.threads)
    bar = ProgressBar(sys.stderr, not (arguments.no_progress or arguments.quiet))
    if arguments.trajectory and arguments.samples is not None:
        raise UsageError("--trajectory writes the states of one sample; leave out --samples")
    names = ("seed", "samples", "first_sample", "label", "direction", "mask", "triangulation", "points", "sampler", "steps",
             "trajectory")  # fmt: skip
    try:
        found = as_usage(
            sample_texture,
            mesh,
            arguments.model,
            image=image,
            autoencoder=arguments.autoencoder,
            color=color_of(mesh) if arguments.mask and image is None else None,
            resolution=resolution_of(arguments),
            progress=bar,
            **{name: getattr(arguments, name) for name in names},
        )
    finally:
        bar.clear()
    if arguments.samples is None and not arguments.trajectory:
        found, paths = [found], [arguments.output]
    else:
        stem, ending = os.path.splitext(arguments.output)
        first = 0 if arguments.trajectory else arguments.first_sample
        paths = [f"{stem}_{number}{ending}" for number in range(first, first + len(found))]
    for sample, path in zip(found, paths):
        write_texture(sample.mesh, sample.image, path)
    return written_outcome(found[0].mesh, paths)


def _input(arguments):
    """The surface in the file INPUT, and with --mask its texture or that of --image."""
    from ..textured_files import read_textured_mesh

    if arguments.mask is None:
        if arguments.image is not None:
            raise UsageError("--image is the texture that --mask keeps; give both")
        return as_usage(read_textured_mesh, arguments.input)[0], None
    return textured_input(arguments)
