#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""New textures like that of one surface, on this surface and on others.

    xvfb-run -a python3 latent_textures.py [FOLDER] --output DIR [--mesh FILE]

Writes samples of the models wood, tissue and coat (Examples/Models) on a scanned surface of Debian's package
libcgal-demo, or on that of --mesh:

    new_textures.png      two samples of each model
    new_MODEL.obj         the first ones (.mtl, .png), for other programs

With FOLDER, which has the surfaces that the models were trained on, as Examples/Training/make_textured_surfaces.py writes
them, instead

    latent_textures.png   rows: the models; columns: the texture that the model was trained on, two samples on the same
                          surface, and two on scanned surfaces
    texture_guidance.png  first row: wood along other directions, and in three sizes; second row: a texture with a hole,
                          which two samples fill; third row: coats with other labels

and prints how long each sample took.
"""

import argparse
import os
import sys
import time

import gallery_rendering as rendering
import numpy as np
import surfacesynthesis
from texture_transfer import image_of, shaded, texels_of
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy

EXAMPLES = os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir)
sys.path.insert(0, os.path.join(EXAMPLES, "Training"))

from make_datasets import surface  # noqa: E402
from surfacesynthesis.files.images import read_image  # noqa: E402

SIZE = (400, 390)
#: Models, and the arrays that guide them.
MODELS = {"wood": {"direction": "Direction"}, "tissue": {"label": "Label"}, "coat": {"label": "Label"}}
#: The direction that the training surfaces are seen from.
SHEET = (0.15, -0.25, 1.0)
#: Scanned surfaces, vertices that carry their texture, and the direction that they are seen from.
TARGETS = {"bear": (6000, (0.3, 0.2, 1.0)), "knot1": (8000, (0.1, 0.2, 1.0))}
#: Vertices of the training surface for a texture twice as large, as it was learnt, and half as large.
SIZES = (750, 3000, 12000)
#: Vertices of the training surfaces.
TRAINED = {"wood": 3000, "tissue": 4500, "coat": 3000}
#: Angle, in radians, of the waves of labels for tissue along the longest side of a scanned surface.
GLANDS = 11.0
#: Middle and radius of the hole of the inpainted texture, in texture coordinates.
HOLE = (0.5, 0.5, 0.3)


def with_array(mesh, name, values):
    """The surface with a point array more."""
    result = mesh.NewInstance()
    result.ShallowCopy(mesh)
    array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
    array.SetName(name)
    result.GetPointData().AddArray(array)
    return result


def points_of(mesh):
    return vtk_to_numpy(mesh.GetPoints().GetData()).astype(float)


def sampled(options, text, mesh, model, points=SIZES[1], **parameters):
    """A sample: surface and image."""
    started = time.monotonic()
    points = max(16, round(options.vertices * points))
    sample = surfacesynthesis.sample_texture(
        mesh,
        os.path.join(options.models, f"{model}.safetensors"),
        autoencoder=options.autoencoder,
        steps=options.steps,
        resolution=options.resolution,
        points=points,
        **parameters,
    )
    print(f"{text}: {time.monotonic() - started:.1f} s", flush=True)
    return sample.mesh, sample.image


def guided(mesh, model):
    """The surface with a direction at each point, backwards along its longest side, and labels: 1 on that half of it, or for
    tissue in the glands of a field of blobs."""
    points = points_of(mesh)
    axis = np.argmax(np.ptp(points, axis=0))
    direction = np.zeros(3)
    direction[axis] = -1.0
    directed = with_array(mesh, "Direction", np.tile(direction, (mesh.GetNumberOfPoints(), 1)))
    if model == "tissue":
        phases = GLANDS * (points - points.mean(axis=0)) / np.ptp(points, axis=0).max() + (0.4, 1.1, 2.3)
        return labeled(directed, np.sin(phases).sum(axis=1) > 0.3)
    return labeled(directed, points[:, axis] < 0.5 * (points[:, axis].min() + points[:, axis].max()))


def labeled(mesh, labels):
    """The surface with labels: 0 for spots and stroma, 1 for stripes and glands."""
    return with_array(mesh, "Label", np.broadcast_to(labels, mesh.GetNumberOfPoints()).astype(np.int32))


def around(mesh):
    """The surface with directions that turn around its middle."""
    offset = points_of(mesh) - points_of(mesh).mean(axis=0)
    return with_array(mesh, "Direction", np.stack([-offset[:, 1], offset[:, 0], np.zeros(len(offset))], axis=1))


class Picture:
    """Rows of textured surfaces."""

    def __init__(self, rows, columns):
        self._sheet = rendering.Sheet(rows, columns, SIZE)

    def add(self, row, column, title, textured, direction=SHEET):
        mesh, image = textured
        view = rendering.view_of(mesh, SIZE[0] / SIZE[1], direction)
        self._sheet.add(row, column, title, shaded(mesh), view, texture=image)

    def write(self, options, name):
        self._sheet.write(os.path.join(options.output, name), options.colors)


def trained_on(options, name):
    """The surface and the texture that a model was trained on."""
    mesh = surfacesynthesis.read_mesh(os.path.join(options.folder, f"{name}.vtp"))
    return mesh, read_image(os.path.join(options.folder, f"{name}.png"))


def on_a_surface(options):
    """The picture of one surface."""
    picture = Picture(1, 2 * len(MODELS))
    name, (points, seen_from) = next(iter(TARGETS.items()))
    scanned = surface(options.mesh, f"{name}.off")
    for number, (model, guides) in enumerate(MODELS.items()):
        target = guided(scanned, model)
        for seed in (0, 1):
            text = f"{model}, sample {seed + 1}"
            made = sampled(options, text, target, model, seed=seed, points=points, **guides)
            if seed == 0:
                surfacesynthesis.write_textured_mesh(*made, os.path.join(options.output, f"new_{model}.obj"))
            picture.add(0, 2 * number + seed, text, made, seen_from)
    picture.write(options, "new_textures.png")


def variations(options):
    """The first picture of the training surfaces."""
    picture = Picture(len(MODELS), 3 + len(TARGETS))
    for row, (model, guides) in enumerate(MODELS.items()):
        mesh, image = trained_on(options, model)
        picture.add(row, 0, "trained on" if row == 0 else "", (mesh, image))
        for column in (1, 2):
            text = f"{model}, sample {column}"
            made = sampled(options, text, mesh, model, seed=column, points=TRAINED[model], **guides)
            picture.add(row, column, text, made)
        for column, (name, (points, seen_from)) in enumerate(TARGETS.items(), 3):
            target = guided(surface(options.mesh, f"{name}.off"), model)
            made = sampled(options, f"{model} on {name}", target, model, points=points, **guides)
            picture.add(row, column, f"on another surface,\n{points:,} vertices", made, seen_from)
    picture.write(options, "latent_textures.png")


def with_hole(mesh, image):
    """A surface whose array Kept is 0 in a disk, and its texture without that disk."""
    coordinates = vtk_to_numpy(mesh.GetPointData().GetTCoords())
    kept = np.hypot(coordinates[:, 0] - HOLE[0], coordinates[:, 1] - HOLE[1]) > HOLE[2]
    texels = texels_of(image).copy()
    v, u = (np.indices(texels.shape[:2]) + 0.5) / np.array(texels.shape[:2])[:, None, None]
    texels[np.hypot(u - HOLE[0], v - HOLE[1]) <= HOLE[2]] = 0.55
    return with_array(mesh, "Kept", kept.astype(float)), image_of(texels)


def guidance(options):
    """The second picture of the training surfaces."""
    picture = Picture(3, 4)
    mesh, _ = trained_on(options, "wood")
    picture.add(0, 0, "along directions that turn", sampled(options, "turning", around(mesh), "wood", direction="Direction"))
    for column, points in enumerate(SIZES, 1):
        made = sampled(options, f"{points} vertices", mesh, "wood", points=points, direction="Direction")
        picture.add(0, column, f"{points:,} vertices", made)
    mesh, image = trained_on(options, "tissue")
    holed, shown = with_hole(mesh, image)
    picture.add(1, 0, "a texture with a hole", (mesh, shown))
    for column in (1, 2):
        guides = {"image": image, "mask": "Kept", **MODELS["tissue"]}
        made = sampled(options, f"filling {column}", holed, "tissue", seed=column, points=TRAINED["tissue"], **guides)
        picture.add(1, column, f"filled, sample {column}", made)
    picture.add(1, 3, "the texture itself", (mesh, image))
    labels(options, picture, 2)
    picture.write(options, "texture_guidance.png")


def labels(options, picture, row):
    """A row of coats with labels unlike those of the training."""
    mesh, _ = trained_on(options, "coat")
    x, y, _ = points_of(mesh).T
    rings = np.hypot(x, y)
    drawn = {"label 0": 0, "label 1": 1, "a disk of label 1": rings < 0.6, "bands of both": np.sin(7.0 * x + 4.0 * y) > 0}
    for column, (title, values) in enumerate(drawn.items()):
        picture.add(row, column, title, sampled(options, title, labeled(mesh, values), "coat", label="Label"))


def main(arguments=None):
    """Returns the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", metavar="FOLDER", nargs="?", help="folder with the training surfaces")
    parser.add_argument("--output", default="gallery", metavar="DIR", help="folder to write to (default: gallery)")
    parser.add_argument("--mesh", metavar="FILE", help="another surface in place of all scanned ones")
    models = os.path.join(EXAMPLES, "Models")
    parser.add_argument("--models", default=models, metavar="DIR", help="folder with the diffusion models")
    parser.add_argument("--autoencoder", default="field_latents", metavar="FILE", help="model of field latents, or its name")
    parser.add_argument("--steps", type=int, default=50, metavar="N", help="evaluations of the network (default: 50)")
    parser.add_argument("--resolution", type=int, default=1024, metavar="N", help="texels along an atlas (default: 1024)")
    parser.add_argument("--vertices", default=1.0, type=float, metavar="F", help="factor of the numbers of vertices (default: 1)")
    parser.add_argument("--colors", type=int, metavar="N", help="dither the pictures to N colors, for smaller files")
    options = parser.parse_args(arguments)
    os.makedirs(options.output, exist_ok=True)
    if options.folder is None:
        on_a_surface(options)
    else:
        variations(options)
        guidance(options)
    return 0


if __name__ == "__main__":
    sys.exit(main())
