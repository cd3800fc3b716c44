#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Displacement maps and height maps of synthesized textures, and the surfaces that they give back.

    xvfb-run -a python3 displacement_maps.py --output DIR

A plain surface gets a texture (geometric_texture()) and an atlas (texture_atlas()); displacement_map() bakes their difference.
The files height.png and vectors.tif are read back, and the points of a subdivision of the plain surface move by them, as in a
renderer. Writes

    displacement_maps.png   rows: spikes on a bear, knobs on a knot; columns: the synthesized surface, the height map, the plain
                            surface displaced by it, the vector map, the plain surface displaced by it

and prints a table of the differences from the synthesized surface, as shares of the height of the texture: of vectors at the
same points, of heights to the nearest place; and along seams of the atlas. Surfaces come from Debian's package libcgal-demo.
"""

import argparse
import os
import struct
import sys
import time

import gallery_rendering as rendering
import numpy as np
import surfacesynthesis
from surfacesynthesis.datasets import given_dataset
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOImage import vtkPNGReader

EXAMPLES = os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir)
sys.path.insert(0, os.path.join(EXAMPLES, "Training"))

SIZE = (430, 430)
#: Texture, surface, points of the plain surface, direction that it is seen from.
CASES = {"spikes": ("bear", 2500, (0.3, 0.2, 1.0)), "knobs": ("knot1", 2500, (0.1, 0.2, 1.0))}


def points_of(mesh):
    return vtk_to_numpy(mesh.GetPoints().GetData()).astype(float)


def corners_of(mesh):
    return vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3)


def subdivided(corners, levels):
    """Values [F, 3, C] at the corners of triangles, subdivided at midpoints in the order of geometric_texture()."""
    for _ in range(levels):
        middles = (corners + np.roll(corners, -1, axis=1)) / 2
        children = [np.stack([corners[:, k], middles[:, k], middles[:, k - 1]], axis=1) for k in range(3)]
        corners = np.concatenate([*children, middles])
    return corners


def smooth_normals(mesh):
    """Area-weighted normals of vertices at the corners of triangles, [F, 3, 3]; points at one place are one vertex."""
    triangles = points_of(mesh)[corners_of(mesh)]
    areas = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    _, vertices = np.unique(points_of(mesh), axis=0, return_inverse=True)
    vertices = vertices.reshape(-1)[corners_of(mesh)]
    normals = np.zeros((vertices.max() + 1, 3))
    for k in range(3):
        np.add.at(normals, vertices[:, k], areas)
    return (normals / np.linalg.norm(normals, axis=1, keepdims=True))[vertices]


def looked_up(image, coordinates):
    """Bilinear look-up of an image [H, W, C], top row first, at texture coordinates [..., 2]."""
    height, width = image.shape[:2]
    x = np.clip(coordinates[..., 0] * width - 0.5, 0, width - 1)
    y = np.clip((1 - coordinates[..., 1]) * height - 0.5, 0, height - 1)
    i, j = np.minimum(x.astype(int), width - 2), np.minimum(y.astype(int), height - 2)
    u, v = (x - i)[..., None], (y - j)[..., None]
    upper = (1 - u) * image[j, i] + u * image[j, i + 1]
    return (1 - v) * upper + v * ((1 - u) * image[j + 1, i] + u * image[j + 1, i + 1])


def read_heights(path, maps):
    """Heights [H, W, 1] of a PNG file of 16 bits, by its midlevel and scale."""
    reader = vtkPNGReader()
    reader.SetFileName(path)
    reader.Update()
    width, height, _ = reader.GetOutput().GetDimensions()
    values = vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars()).reshape(height, width, 1)[::-1] / 65535
    return (values - maps["height_midlevel"]) * maps["height_scale"]


def read_vectors(path):
    """Vectors [H, W, 3] of a TIFF file of 32-bit floating-point numbers without compression. (vtkTIFFReader of VTK 9.1 mixes up
    three such components.)"""
    with open(path, "rb") as file:
        data = file.read()
    start = struct.unpack_from("<I", data, 4)[0]
    entries = [struct.unpack_from("<HHII", data, start + 2 + 12 * k) for k in range(struct.unpack_from("<H", data, start)[0])]
    tags = {tag: (count, value) for tag, _, count, value in entries}
    count, offset = tags[273]
    offsets = struct.unpack_from(f"<{count}I", data, offset) if count > 1 else (offset,)
    width, height, rows = tags[256][1], tags[257][1], tags[278][1]
    sizes = [12 * width * min(rows, height - rows * k) for k in range(count)]
    joined = b"".join(data[begin : begin + size] for begin, size in zip(offsets, sizes))
    return np.frombuffer(joined, dtype="<f4").reshape(height, width, 3)


class Baked:
    """A plain surface, its texture, and what its maps make of a subdivision of it."""

    def __init__(self, options, texture, resolution, plain):
        self.plain = plain
        model = os.path.join(options.models, f"{texture}.safetensors")
        self.detailed = surfacesynthesis.geometric_texture(self.plain, model, start_level=1, seed=options.seed)
        atlas = surfacesynthesis.texture_atlas(self.plain, resolution=resolution)
        started = time.monotonic()
        self.maps = surfacesynthesis.displacement_map(atlas, self.detailed, resolution=resolution)
        self.seconds = time.monotonic() - started
        levels = self.maps["subdivision_levels"]
        self.base = subdivided(points_of(atlas)[corners_of(atlas)], levels)
        self.normals = subdivided(smooth_normals(atlas), levels)
        coordinates = vtk_to_numpy(atlas.GetPointData().GetTCoords())
        self.coordinates = subdivided(coordinates[corners_of(atlas)], levels)
        self.truth = points_of(self.detailed)[corners_of(self.detailed)]
        self.height = np.quantile(np.linalg.norm(self.truth - self.base, axis=2), 0.95)
        self.at_seam = self._corners_at_seams()

    def _corners_at_seams(self):
        """True for corners of triangles at points with several texture coordinates."""
        ids = corners_of(self.detailed)
        low, high = (np.full((self.detailed.GetNumberOfPoints(), 2), bound) for bound in (np.inf, -np.inf))
        np.minimum.at(low, ids, self.coordinates)
        np.maximum.at(high, ids, self.coordinates)
        return (np.abs(high - low).max(axis=1) > 1e-9)[ids]

    def by_vectors(self, vectors):
        return self.base + looked_up(vectors, self.coordinates)

    def by_heights(self, heights):
        normals = self.normals / np.linalg.norm(self.normals, axis=2, keepdims=True)
        return self.base + looked_up(heights, self.coordinates) * normals

    def surface_of(self, corners):
        """A surface of corners of triangles: a point is where the last of its corners is, as in renderers."""
        points = np.empty((self.detailed.GetNumberOfPoints(), 3))
        points[corners_of(self.detailed)] = corners
        return given_dataset((points, corners_of(self.detailed)))


def plain_surface(texture):
    """The surface of a texture, with even triangles."""
    from make_datasets import surface

    name, points, _ = CASES[texture]
    return surfacesynthesis.remesh(surface(None, name + ".off"), points=points, feature_angle=None)


def row_of(errors):
    return f"{100 * errors.mean():8.2f} {100 * np.quantile(errors, 0.95):8.2f}"


def report(texture, resolution, baked, vectors, heights):
    """Prints the differences in percent of the height of the texture; returns those of the picture."""
    errors = np.linalg.norm(baked.by_vectors(vectors) - baked.truth, axis=2) / baked.height
    found = surfacesynthesis.surface_distance(baked.surface_of(baked.by_heights(heights)), baked.detailed)
    height = (found["mean"] / baked.height, found["percentile_95"] / baked.height)
    columns = f"{texture:8} {resolution:6} {row_of(errors)} {row_of(errors[baked.at_seam])}"
    print(f"{columns} {100 * height[0]:8.2f} {100 * height[1]:8.2f} {baked.seconds:6.1f}", flush=True)
    return errors, height


def table_head():
    print("percent of the height of the texture: vectors, vectors at seams, heights to the nearest place")
    print("texture  texels " + "    mean     95 %" * 3 + "      s")


def read_back(options, baked, texture):
    """The maps from their files."""
    names = [os.path.join(options.output, f"{texture}_{kind}") for kind in ("height.png", "vectors.tif")]
    baked.maps.write(*names)
    return read_heights(names[0], baked.maps), read_vectors(names[1])


def picture_of(image, low, high):
    """An image [H, W, 1 or 3] as one of SIZE, with a frame."""
    values = np.clip((image - low) / (high - low), 0, 1)
    rows = np.arange(SIZE[1] - 20) * image.shape[0] // (SIZE[1] - 20)
    columns = np.arange(SIZE[0] - 20) * image.shape[1] // (SIZE[0] - 20)
    part = np.round(255 * values[rows][:, columns]).astype(np.uint8)
    whole = rendering.blank(SIZE)
    rendering.paste(whole, np.broadcast_to(part, (*part.shape[:2], 3)), 10, 10, rendering.INK)
    return whole


def add_row(sheet, row, texture, baked, heights, vectors, errors, height):
    name, _, direction = CASES[texture]
    view = rendering.view_of(baked.detailed, SIZE[0] / SIZE[1], direction, margin=1.04)
    faces = f"{baked.plain.GetNumberOfCells():,} to {baked.detailed.GetNumberOfCells():,} faces"
    sheet.add(row, 0, f"{texture} on {name}\n{faces}", baked.detailed, view)
    low, high = heights.min(), heights.max()
    sheet.add_image(row, 1, f"height map, 16 bits\n{heights.shape[1]} x {heights.shape[0]}", picture_of(heights, low, high))
    text = f"mean {100 * height[0]:.1f} %, 95th percentile {100 * height[1]:.1f} %"
    sheet.add(row, 2, f"displaced by heights\n{text}", baked.surface_of(baked.by_heights(heights)), view)
    reach = np.quantile(np.abs(vectors[baked.maps.coverage]), 0.995)
    sheet.add_image(row, 3, "displacement vectors, 32 bits\nx, y, z in red, green, blue", picture_of(vectors, -reach, reach))
    text = f"mean {100 * errors.mean():.1f} %, 95th percentile {100 * np.quantile(errors, 0.95):.1f} %"
    sheet.add(row, 4, f"displaced by vectors\n{text}", baked.surface_of(baked.by_vectors(vectors)), view)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--models", default=os.path.join(EXAMPLES, "Models"), metavar="DIR", help="where the model files are")
    parser.add_argument("--output", required=True, metavar="DIR")
    parser.add_argument("--seed", type=int, default=1, help="default: 1")
    resolutions = parser.add_argument("--resolutions", type=int, nargs="+", default=[512, 1024, 2048])
    resolutions.help = "of the table; 1024 in the picture"
    parser.add_argument("--colors", type=int, metavar="N", help="write PNGs with a palette of so few colours (needs PIL)")
    options = parser.parse_args()
    os.makedirs(options.output, exist_ok=True)
    sheet = rendering.Sheet(len(CASES), 5, SIZE)
    shown = 1024 if 1024 in options.resolutions else options.resolutions[0]
    table_head()
    for row, texture in enumerate(CASES):
        plain = plain_surface(texture)
        for resolution in options.resolutions:
            baked = Baked(options, texture, resolution, plain)
            heights, vectors = read_back(options, baked, texture)
            errors, height = report(texture, resolution, baked, vectors, heights)
            if resolution == shown:
                add_row(sheet, row, texture, baked, heights, vectors, errors, height)
    sheet.write(os.path.join(options.output, "displacement_maps.png"), options.colors)


if __name__ == "__main__":
    main()
