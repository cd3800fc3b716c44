#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Makes the textured surfaces that diffusion models of field latents are trained on.

    python3 make_textured_surfaces.py FOLDER IMAGES

IMAGES is a folder with the image ihc.png of python3-skimage (a package of Debian 12, in
usr/lib/python3/dist-packages/skimage/data). Writes FOLDER/NAME.vtp, a surface with texture coordinates and arrays, and
FOLDER/NAME.png, its texture, for each NAME of

    tissue    a stained section of tissue (ihc) on a surface with the folds of an organ, with the point array Label: 0 for
              stroma, 1 for the gland
    coat      spots and stripes on hills, with the point array Label: 0 for spots, 1 for stripes
    wood      grain of wood on a bent sheet, with the point array Direction along the fibers

Each is trained by

    python3 -m surfacesynthesis train latent-diffusion FOLDER/NAME.vtp NAME.safetensors --image FOLDER/NAME.png

with --label Label for coat and tissue and --direction Direction for wood. Spots, stripes and rings are so large that the
3,000 vertices of a triangulation lie about six to one of them: with half as many, short trainings found colors, but no
shapes. Nuclei of tissue are three vertices wide and eight long where a triangulation has 4,500.
"""

import argparse
import os

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk

import surfacesynthesis
from surfacesynthesis.field_latents import image_of_array
from surfacesynthesis.files.polygons import mesh_of_triangles, to_polydata
from surfacesynthesis.texture_datasets import image_array
from surfacesynthesis.textured_files import write_image

#: Cells along a side of a surface.
CELLS = 120
#: Texels along a side of a drawn texture.
TEXELS = 512
#: Parts of photographs that become textures: first row, first column, and pixels along a side.
PARTS = {"ihc.png": (296, 196, 212)}


def sheet(height):
    """A square sheet of triangles over [-1, 1]^2 with heights, and texture coordinates (x + 1) / 2, (y + 1) / 2."""
    along = np.linspace(-1.0, 1.0, CELLS + 1)
    x, y = (axis.ravel() for axis in np.meshgrid(along, along))
    # Inner points are moved: remeshing leaves parts of a regular grid, whose rings show no direction to the network.
    inner = (abs(x) < 1) & (abs(y) < 1)
    moves = np.random.default_rng(1).uniform(-0.6, 0.6, (2, len(x))) / CELLS
    x, y = x + inner * moves[0], y + inner * moves[1]
    points = np.stack([x, y, height(x, y)], axis=1)
    corner = (np.arange(CELLS)[:, None] * (CELLS + 1) + np.arange(CELLS)).ravel()
    lower = np.stack([corner, corner + 1, corner + CELLS + 2], axis=1)
    upper = np.stack([corner, corner + CELLS + 2, corner + CELLS + 1], axis=1)
    mesh = to_polydata(mesh_of_triangles(points, np.concatenate([lower, upper])))
    coordinates = numpy_to_vtk(np.stack([(x + 1) / 2, (y + 1) / 2], axis=1), deep=True)
    coordinates.SetName("TCoords")
    mesh.GetPointData().SetTCoords(coordinates)
    return mesh, points


def add_array(mesh, name, values):
    array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
    array.SetName(name)
    mesh.GetPointData().AddArray(array)


def part(images, name):
    """The part of a photograph that becomes a texture."""
    row, column, side = PARTS[name]
    return image_array(os.path.join(images, name))[row : row + side, column : column + side]


def bilinear(image, row, column):
    """Values of an image at fractional rows and columns; those outside are moved to the border."""
    row, column = (np.clip(value, 0, side - 1.001) for value, side in zip((row, column), image.shape))
    i, j = row.astype(int), column.astype(int)
    a, b = row - i, column - j
    return (1 - a) * ((1 - b) * image[i, j] + b * image[i, j + 1]) + a * ((1 - b) * image[i + 1, j] + b * image[i + 1, j + 1])


def blurred(image, deviation):
    """Image [rows, columns] after a Gaussian of a deviation in pixels; mirrored at its borders."""
    mirrored = np.block([[image, image[:, ::-1]], [image[::-1], image[::-1, ::-1]]])
    squares = np.add.outer(*(np.fft.fftfreq(side) ** 2 for side in mirrored.shape))
    smooth = np.fft.ifft2(np.fft.fft2(mirrored) * np.exp(-2 * (np.pi * deviation) ** 2 * squares)).real
    return smooth[: image.shape[0], : image.shape[1]]


def tissue(images):
    """Stained tissue on folds. The gland is where the stain is brown on average: there is more red than blue."""
    mesh, points = sheet(lambda x, y: 0.35 * np.cos(1.3 * x) * np.cos(1.1 * y) + 0.05 * np.sin(7 * x + 2 * np.sin(3 * y)))
    texture = part(images, "ihc.png")
    brown = blurred(texture[:, :, 0].astype(float) - texture[:, :, 2], 7)
    column, row = (np.array([[1], [-1]]) * points[:, :2].T + 1) / 2 * len(texture) - 0.5  # row 0 is the top
    add_array(mesh, "Label", (bilinear(brown, row, column) > 18).astype(np.int32))
    return mesh, texture


def waves(seed, width):
    """Random waves [TEXELS, TEXELS] with eight of them along a side, of variance 1. width: of their band of lengths."""
    frequencies = np.hypot(*np.meshgrid(np.fft.fftfreq(TEXELS), np.fft.fftfreq(TEXELS))) * TEXELS / 8
    noise = np.random.default_rng(seed).normal(size=(TEXELS, TEXELS))
    filtered = np.fft.ifft2(np.fft.fft2(noise) * np.exp(-0.5 * ((frequencies - 1) / width) ** 2)).real
    return filtered / filtered.std()


def coat(_):
    """Spots and stripes of two animals, divided by a winding line."""
    mesh, points = sheet(lambda x, y: 0.15 * np.sin(2.5 * x) * np.cos(2 * y))

    def is_striped(x, y):
        return y > 0.25 * np.sin(4 * x)

    def colored(values, dark, light):
        share = 0.5 * (1 + np.tanh(values / 0.12))[..., None]
        return share * np.array(dark) + (1 - share) * np.array(light)

    add_array(mesh, "Label", is_striped(points[:, 0], points[:, 1]).astype(np.int32))
    spots = colored(waves(3, 0.25) - 0.55, (62.0, 36.0, 20.0), (214.0, 164.0, 92.0))
    stripes = colored(waves(5, 0.12), (40.0, 38.0, 42.0), (236.0, 230.0, 220.0))
    along = (np.arange(TEXELS) + 0.5) / TEXELS * 2 - 1
    x, y = np.meshgrid(along, along[::-1])  # row 0 is the top
    return mesh, np.rint(np.where(is_striped(x, y)[:, :, None], stripes, spots)).astype(np.uint8)


def wood(_):
    """Grain of wood: growth rings that darken slowly and end in a sharp line, along winding fibers."""

    def position(x, y):
        return x + 0.16 * np.sin(2.1 * y + 0.6) + 0.05 * np.sin(4.3 * y - 0.8 + 1.3 * x)

    mesh, points = sheet(lambda x, y: 0.3 * np.cos(1.4 * x + 0.5 * y))
    step = 1e-5
    x, y, z = points.T
    slopes = np.stack([position(x + step, y) - position(x, y), position(x, y + step) - position(x, y)], axis=1) / step
    along = np.stack([slopes[:, 1], -slopes[:, 0]], axis=1)  # down a line of equal position
    rise = -0.3 * np.sin(1.4 * x + 0.5 * y) * (along @ np.array([1.4, 0.5]))
    add_array(mesh, "Direction", np.column_stack([along, rise]))

    u, v = np.meshgrid((np.arange(TEXELS) + 0.5) / TEXELS * 2 - 1, 1 - (np.arange(TEXELS) + 0.5) / TEXELS * 2)
    across = position(u, v)

    def variation(seed, width, length):
        """Noise along the fibers, of variance 1, with correlations over parts of a side."""
        frequencies = np.fft.fftfreq(TEXELS) * TEXELS
        noise = np.random.default_rng(seed).normal(size=(TEXELS, TEXELS))
        exponent = (frequencies * width) ** 2 + (frequencies[:, None] * length) ** 2
        smooth = np.fft.ifft2(np.fft.fft2(noise) * np.exp(-np.pi**2 * exponent)).real
        return bilinear(smooth / smooth.std(), (v + 1) / 2 * TEXELS, (across + 1.3) / 2.6 * TEXELS)

    ring = (4.8 * across + 0.32 * variation(1, 0.08, 0.45)) % 1
    end = np.clip((ring - 0.86) / 0.14, 0, 1)
    dark = 1.4 * ring**2.2 * (1 - end**2 * (3 - 2 * end))
    dark += 0.09 * variation(2, 0.012, 0.12) + 0.08 * variation(3, 0.12, 0.5)
    light_color, dark_color = np.array([196.0, 120.0, 70.0]), np.array([80.0, 36.0, 20.0])
    color = light_color + np.clip(dark, 0, 1)[..., None] * (dark_color - light_color)
    return mesh, np.rint(color).astype(np.uint8)


SURFACES = {"tissue": tissue, "coat": coat, "wood": wood}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", metavar="FOLDER", help="folder that is written to")
    parser.add_argument("images", metavar="IMAGES", help="folder with the images of python3-skimage")
    arguments = parser.parse_args()
    os.makedirs(arguments.folder, exist_ok=True)
    for name, make in SURFACES.items():
        mesh, texture = make(arguments.images)
        surfacesynthesis.write_mesh(mesh, os.path.join(arguments.folder, f"{name}.vtp"))
        write_image(image_of_array(texture), os.path.join(arguments.folder, f"{name}.png"))


if __name__ == "__main__":
    main()
