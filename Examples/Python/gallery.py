#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of Matérn noise on a scanned surface.

    xvfb-run -a python3 gallery.py [surface] --output DIR

Without a surface, the armadillo of Debian's package libcgal-demo is used. Writes

    matern_seeds.png     four seeds
    triangulations.png   Matérn noise, and one random number per vertex, on three triangulations of the surface
    displacement.png     noise as displacement, along the normals and in all directions
    spectrum.png         distributions of spectral coefficients on three triangulations (needs SciPy and Matplotlib)

and the surfaces with their noise as .vtp files.
"""

import argparse
import os
import sys
import time
import warnings

import numpy as np

import gallery_meshes as meshes
import gallery_rendering as rendering
import surfacesynthesis
from surfacesynthesis.warp import warped

DIRECTION = (0.16, 0.08, -1.0)  # from the surface to the viewer
LIMIT = 2.5  # standard deviations that the colour map spans


def say(text):
    print(text, flush=True)


def noise(mesh, **parameters):
    """matern_noise() without the warning about single long edges, which decimated surfaces have."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", surfacesynthesis.SurfaceSynthesisWarning)
        return surfacesynthesis.matern_noise(mesh, **parameters)


def seeds(surface, folder, direction):
    """Four seeds side by side."""
    size, title = (500, 560), 64
    image = rendering.blank((4 * size[0], size[1] + title))
    view = rendering.view_of(surface, size[0] / size[1], direction)
    for k in range(1, 5):
        field = noise(surface, range=0.2 * meshes.longest_side(surface), seed=k)
        surfacesynthesis.write_mesh(field, os.path.join(folder, f"seed_{k}.vtp"))
        rendering.paste(image, rendering.render(field, view, size, "MaternNoise", LIMIT), (k - 1) * size[0], 0)
        rendering.paste(image, rendering.label(f"seed {k}", (size[0], title), 26), (k - 1) * size[0], size[1])
    return image


def triangulations(surface, folder, direction):
    """Three triangulations: Matérn noise above, one number per vertex below, and edges in close-ups."""
    body, pitch, detail = (530, 590), 640, 216  # a body and its close-up share a column as wide as the pitch
    left, top, row_height = 80, 112, 600
    view = rendering.view_of(surface, body[0] / body[1], direction)
    right, up = view.axes()
    close = view.zoomed(view.center + 0.125 * view.height * up, 0.12 * view.height)
    coarse = meshes.decimated(surface, 2600)
    half = meshes.refined(coarse, lambda centroids: (centroids - view.center) @ right < 0, 3)
    half = meshes.projected(half, coarse.GetNumberOfPoints(), surface)
    columns = (("original", surface), ("decimated", coarse), ("left half refined", half))
    rows = (("Matérn noise", "matern"), ("one number per vertex", "per_vertex"))

    image = rendering.blank((left + 3 * pitch, top + 2 * row_height))
    for column, (title, mesh) in enumerate(columns):
        x = left + column * pitch
        rendering.paste(image, rendering.label(title, (body[0], 50), 30, bold=True), x, 12)
        vertices = f"{mesh.GetNumberOfPoints():,} vertices"
        rendering.paste(image, rendering.label(vertices, (body[0], 40), 24), x, 60)
        for row, (_, model) in enumerate(rows):
            y = top + row * row_height
            scale = {"range": 0.16 * meshes.longest_side(surface)} if model == "matern" else {}
            field = noise(mesh, seed=3, model=model, **scale)
            surfacesynthesis.write_mesh(field, os.path.join(folder, f"{model}_{title.replace(' ', '_')}.vtp"))
            rendering.paste(image, rendering.render(field, view, body, "MaternNoise", LIMIT), x, y)
            part = rendering.render(field, close, (detail, detail), "MaternNoise", LIMIT, edges=True)
            rendering.paste(image, part, x + pitch - detail - 14, y + 236, frame=rendering.INK)
            side = close.height * body[1] / view.height
            center = view.pixel(close.center, body)
            rendering.outline(image, x + center[0] - side / 2, y + center[1] - side / 2, side, side, rendering.INK, 2)
    for row, (title, _) in enumerate(rows):
        text = rendering.label(title, (left, row_height), 30, bold=True, upright=True)
        rendering.paste(image, text, 0, top + row * row_height)
    return image


def displacement(surface, folder, direction):
    """Noise as displacement: along the normals, and in space."""
    size, title = (500, 580), 100
    longest = meshes.longest_side(surface)
    fine = meshes.refined(surface, lambda centroids: np.ones(len(centroids), dtype=bool), 1)
    view = rendering.view_of(surface, size[0] / size[1], direction, margin=1.12)
    image = rendering.blank((4 * size[0], size[1] + title))
    panels = (  # label, and range and deviation relative to the longest side, components, seed
        ("original", None),
        ("along the normals\nrange 2.5 % of the size", (0.025, 0.0022, 1, 6)),
        ("along the normals\nrange 7 % of the size", (0.07, 0.005, 1, 7)),
        ("in all directions\nrange 80 % of the size", (0.8, 0.03, 3, 9)),
    )
    for k, (text, parameters) in enumerate(panels):
        mesh = fine
        if parameters:
            correlation, deviation, components, seed = parameters
            scale = {"range": correlation * longest, "standard_deviation": deviation * longest}
            mesh = warped(noise(fine, components=components, seed=seed, **scale), "MaternNoise", 1.0)
            surfacesynthesis.write_mesh(mesh, os.path.join(folder, f"displacement_{k}.vtp"))
        own = rendering.view_of(mesh, size[0] / size[1], direction)  # its centre, at the scale of all
        rendering.paste(image, rendering.render(mesh, view.zoomed(own.center, view.height), size), k * size[0], 0)
        rendering.paste(image, rendering.label(text, (size[0], title), 26), k * size[0], size[1])
    return image


def spectrum(surface, folder, samples):
    """Distributions of spectral coefficients on three triangulations, as a table and a plot."""
    try:
        import gallery_spectrum
        import matplotlib  # noqa: F401
    except ImportError as error:
        say(f"spectrum.png is left out: {error}")
        return
    count = surface.GetNumberOfPoints()
    triangulations = [meshes.decimated(surface, 2000), meshes.decimated(surface, min(7000, count // 2)), surface]
    labels = [f"{mesh.GetNumberOfPoints():,} vertices" for mesh in triangulations]
    screening = 8 / (0.2 * meshes.longest_side(surface)) ** 2
    spectra = [gallery_spectrum.coefficients(mesh, screening, samples, lambda *_: None) for mesh in triangulations]
    text = gallery_spectrum.table(labels, spectra, screening)
    say(f"Standard deviation of spectral coefficients over {samples} samples, tau = {screening:.4g}\n{text}")
    gallery_spectrum.plot(labels, spectra, os.path.join(folder, "spectrum.png"))


PICTURES = {
    "seeds": ("matern_seeds.png", seeds),
    "triangulations": ("triangulations.png", triangulations),
    "displacement": ("displacement.png", displacement),
    "spectrum": ("spectrum.png", spectrum),
}


def main(arguments=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, usage="%(prog)s [surface] --output DIR"
    )
    parser.add_argument("surface", nargs="?", help="any format that surfacesynthesis.read_mesh() reads")
    parser.add_argument("--output", required=True, metavar="DIR", help="folder to write to; made when it is missing")
    parser.add_argument("--only", choices=PICTURES, action="append", help="make this picture only; may be repeated")
    parser.add_argument(
        "--view", type=float, nargs=3, default=DIRECTION, metavar=("X", "Y", "Z"),
        help="direction from the surface to the viewer; y points up (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--spectrum-samples", type=int, default=4000, metavar="N",
        help="samples for spectrum.png (default 4000; the paper's Figure 4 has 100000, which takes several minutes)",
    )  # fmt: skip
    parser.add_argument(
        "--colors", type=int, metavar="N", help="reduce the pictures to N colours, for small files (needs Pillow)"
    )
    options = parser.parse_args(arguments)
    os.makedirs(options.output, exist_ok=True)
    try:
        surface = meshes.load(options.surface, options.output)
        for picture in options.only or PICTURES:
            started = time.monotonic()
            if picture == "spectrum":
                spectrum(surface, options.output, options.spectrum_samples)
            else:
                name, make = PICTURES[picture]
                image = make(surface, options.output, options.view)
                rendering.write_png(image, os.path.join(options.output, name), options.colors)
            say(f"{picture}: {time.monotonic() - started:.1f} s")
    except (surfacesynthesis.SurfaceSynthesisError, OSError, ValueError, RuntimeError) as error:
        return f"gallery: {error}"
    return 0


if __name__ == "__main__":
    sys.exit(main())
