#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Compares sampled textures of a surface with the texture that their model was trained on.

    python3 compare_texture_samples.py SURFACE.vtp IMAGE.png OUTPUT --model MODEL --autoencoder MODEL [options]

renders the surface without light, from three directions, and compares patches of 8, 16 and 32 pixels with those of the
original texture. Writes OUTPUT.csv with a row for each of

    original         other patches of the original
    triangulations   the reconstruction, compared with that on another triangulation: the floor
    reconstruction   the original, encoded and decoded on a triangulation like those of the training
    sample           sampled textures, the mean of --samples
    shuffled         the original with its texels in random order
    noise            random colors

and the columns swd_8, swd_16, swd_32, sliced Wasserstein distance of patches as vectors of colors from 0 to 1 (low is
alike); difference, root mean square difference of two samples (diversity; of the others from the original); layout,
correlation of the mean colors of squares of 24 pixels of two samples (near 0 when large features lie elsewhere; of the
others with the original); closest, median over patches of 16 pixels of the root mean square distance to the closest patch of
the original (a copy has that of the reconstruction or less). OUTPUT.png shows original, reconstruction and samples. Needs
a display: xvfb-run.
"""

import argparse
import csv

import numpy as np
import vtkmodules.vtkInteractionStyle  # noqa: F401  (registers the factories of the rendering classes)
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkPolyDataMapper,
    vtkRenderer,
    vtkRenderWindow,
    vtkTexture,
    vtkWindowToImageFilter,
)

import surfacesynthesis
from surfacesynthesis.field_latents import image_of_array
from surfacesynthesis.texture_datasets import image_array
from surfacesynthesis.textured_files import write_image

#: Sides of the compared patches, pixels.
SIDES = (8, 16, 32)
#: Color of the background, which no texture should have.
BACKGROUND = (1.0, 0.0, 1.0)
#: Side of a rendering, pixels.
PIXELS = 384
#: Directions of view: azimuth and elevation, degrees.
VIEWS = ((0, 0), (30, 10), (-25, -20))
#: Columns of the table.
COLUMNS = ("texture", *(f"swd_{side}" for side in SIDES), "difference", "layout", "closest")


def array_of(image):
    """A vtkImageData of RGB bytes as an array with its top row first."""
    width, height, _ = image.GetDimensions()
    return vtk_to_numpy(image.GetPointData().GetScalars()).reshape(height, width, 3)[::-1]


def off_screen_window():
    """A window for rendered(). One serves all: an X server that loses its last client may refuse the next one."""
    window = vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    window.SetSize(PIXELS, PIXELS)
    return window


def rendered(window, mesh, image):
    """Renderings of a textured surface [view, row, column, 3] from 0 to 1, NaN outside of the surface."""
    texture = vtkTexture()
    texture.SetInputData(image)
    texture.InterpolateOn()
    mapper = vtkPolyDataMapper()
    mapper.SetInputData(mesh)
    mapper.ScalarVisibilityOff()
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.SetTexture(texture)
    actor.GetProperty().LightingOff()
    renderer = vtkRenderer()
    renderer.SetBackground(*BACKGROUND)
    renderer.AddActor(actor)
    window.AddRenderer(renderer)
    views = []
    for azimuth, elevation in VIEWS:
        camera = renderer.MakeCamera()
        renderer.SetActiveCamera(camera)
        camera.ParallelProjectionOn()
        renderer.ResetCamera()
        camera.Azimuth(azimuth)
        camera.Elevation(elevation)
        camera.Zoom(1.3)
        window.Render()
        grabber = vtkWindowToImageFilter()
        grabber.SetInput(window)
        grabber.ReadFrontBufferOff()
        grabber.Update()
        view = array_of(grabber.GetOutput()).astype(np.float32) / 255.0
        view[(view == BACKGROUND).all(axis=-1)] = np.nan
        views.append(view)
    window.RemoveRenderer(renderer)
    return np.stack(views)


def patches(views, side, count, seed):
    """Random patches that lie on the surface, [N, side side 3]."""
    random = np.random.default_rng(seed)
    found = []
    for _ in range(50 * count):
        view = views[random.integers(len(views))]
        row, column = random.integers(0, view.shape[0] - side + 1), random.integers(0, view.shape[1] - side + 1)
        patch = view[row : row + side, column : column + side]
        if np.isfinite(patch).all():
            found.append(patch.ravel())
            if len(found) == count:
                break
    if len(found) < count:
        raise ValueError(f"only {len(found)} of {count} patches of {side} pixels lie on the surface")
    return np.stack(found)


def sliced_wasserstein(first, second, projections=128, seed=0):
    """Sliced Wasserstein-1 distance of two sets of as many vectors: the mean over random directions."""
    random = np.random.default_rng(seed)
    directions = random.normal(size=(first.shape[1], projections))
    directions /= np.linalg.norm(directions, axis=0)
    return float(np.abs(np.sort(first @ directions, axis=0) - np.sort(second @ directions, axis=0)).mean())


def closest(made, original):
    """Median root mean square distance of patches from the closest ones of the original."""
    squares = (made**2).sum(1)[:, None] + (original**2).sum(1)[None] - 2.0 * made @ original.T
    return float(np.median(np.sqrt(np.maximum(squares.min(axis=1), 0.0) / made.shape[1])))


def measures(views, original, count):
    """Distances of a texture from the original, by column."""
    row = {
        f"swd_{side}": sliced_wasserstein(patches(views, side, count, 1), patches(original, side, count, 2))
        for side in SIDES
    }
    row["difference"] = difference(views, original)
    row["layout"] = layout(views, original)
    row["closest"] = closest(patches(views, 16, min(count, 500), 3), patches(original, 16, 8 * count, 4))
    return row


def difference(first, second):
    """Root mean square difference of two renderings, on the surface."""
    return float(np.sqrt(np.nanmean((first - second) ** 2)))


def layout(first, second, side=24):
    """Correlation of the mean colors of squares of two renderings that lie on the surface."""

    def means(views):
        count, height, width, _ = views.shape
        rows, columns = height // side, width // side
        squares = views[:, : rows * side, : columns * side].reshape(count, rows, side, columns, side, 3).mean(axis=(2, 4))
        return squares.reshape(-1, 3)

    pairs = np.concatenate([means(first), means(second)], axis=1)
    pairs = pairs[np.isfinite(pairs).all(axis=1)]
    pairs = pairs - pairs.mean(axis=0)
    products = [(pairs[:, :3] * pairs[:, 3:]).sum(), (pairs[:, :3] ** 2).sum(), (pairs[:, 3:] ** 2).sum()]
    return float(products[0] / np.sqrt(max(products[1] * products[2], 1e-30)))


def textures_of(mesh, image, arguments):
    """Images of the compared textures by name, those of samples as a list."""
    options = {"autoencoder": arguments.autoencoder, "resolution": arguments.resolution, "points": arguments.points}
    guides = {"label": arguments.label, "direction": arguments.direction}
    sampled = surfacesynthesis.sample_texture(
        mesh, arguments.model, samples=arguments.samples, seed=arguments.seed, steps=arguments.steps, **guides, **options
    )
    kept = type(mesh)()
    kept.ShallowCopy(mesh)
    mask = numpy_to_vtk(np.ones(mesh.GetNumberOfPoints()), deep=True)
    mask.SetName("KeptTexture")
    kept.GetPointData().AddArray(mask)
    vertices = sampled[0].latents.GetNumberOfPoints()
    rebuilt, other = (
        surfacesynthesis.sample_texture(
            kept, arguments.model, image, mask="KeptTexture", steps=1, **{**options, "points": round(factor * vertices)}
        )
        for factor in (1.0, 1.15)
    )
    random = np.random.default_rng(arguments.seed)
    shuffled = random.permutation(image.reshape(-1, 3)).reshape(image.shape)
    noise = random.integers(0, 256, image.shape, dtype=np.uint8)
    return {
        "original": image_of_array(image),
        "reconstruction": rebuilt.image,
        "triangulations": other.image,
        "sample": [sample.image for sample in sampled],
        "shuffled": image_of_array(shuffled),
        "noise": image_of_array(noise),
    }


def compared(mesh, image, arguments):
    """The rows of the table, and the renderings that are shown."""
    textures = textures_of(mesh, image, arguments)
    window = off_screen_window()
    original = rendered(window, mesh, textures["original"])
    samples = [rendered(window, mesh, texture) for texture in textures.pop("sample")]
    views = {name: rendered(window, mesh, texture) for name, texture in textures.items()}
    other = views.pop("triangulations")
    rows = {name: measures(found, original, arguments.patches) for name, found in views.items()}
    rows["triangulations"] = measures(other, views["reconstruction"], arguments.patches)
    rows["original"]["closest"] = 0.0  # every patch is its own closest one
    each = [measures(found, original, arguments.patches) for found in samples]
    rows["sample"] = {column: float(np.mean([row[column] for row in each])) for column in each[0]}
    pairs = [(a, b) for k, a in enumerate(samples) for b in samples[:k]]
    if pairs:
        rows["sample"]["difference"] = float(np.mean([difference(a, b) for a, b in pairs]))
        rows["sample"]["layout"] = float(np.mean([layout(a, b) for a, b in pairs]))
    order = ("original", "triangulations", "reconstruction", "sample", "shuffled", "noise")
    return [{"texture": name, **rows[name]} for name in order], [original, views["reconstruction"], *samples]


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("surface", metavar="SURFACE", help="surface with texture coordinates within [0, 1]")
    parser.add_argument("image", metavar="IMAGE", help="its texture")
    parser.add_argument("output", metavar="OUTPUT", help="first part of the names of the files that are written")
    parser.add_argument("--model", required=True, metavar="FILE", help="diffusion model")
    parser.add_argument("--autoencoder", default="field_latents", metavar="FILE", help="autoencoder of its latents")
    parser.add_argument("--label", metavar="NAME", help="point array with labels")
    parser.add_argument("--direction", metavar="NAME", help="point array with directions")
    parser.add_argument("--points", type=int, metavar="N", help="vertices (default: those of the training)")
    parser.add_argument("--samples", type=int, default=4, metavar="N", help="number of samples (default: 4)")
    parser.add_argument("--steps", type=int, default=50, metavar="N", help="evaluations of the network (default: 50)")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="of the samples (default: 0)")
    parser.add_argument("--resolution", type=int, default=512, metavar="N", help="texels of a side (default: 512)")
    parser.add_argument("--patches", type=int, default=1000, metavar="N", help="of each size (default: 1000)")
    arguments = parser.parse_args(arguments)
    rows, shown = compared(
        surfacesynthesis.read_mesh(arguments.surface), image_array(arguments.image), arguments
    )
    with open(f"{arguments.output}.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(rows)
    sheet = np.concatenate([np.nan_to_num(views[0], nan=1.0) for views in shown], axis=1)
    write_image(image_of_array(np.rint(255.0 * sheet).astype(np.uint8)), f"{arguments.output}.png")
    for row in rows:
        print(f"{row['texture']:>15}", *(f"{name} {row[name]:.4f}" for name in COLUMNS[1:]))


if __name__ == "__main__":
    main()
