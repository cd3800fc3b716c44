#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Compares field latents with the barycentric ablation and with colors of vertices: PSNR and DSSIM in texture atlases.

    python3 compare_field_latents.py FOLDER OUTPUT --model logarithmic.safetensors --ablation barycentric.safetensors

FOLDER is that of field_latent_images.py: no image and no mesh here has been trained on. Textured models come from Debian's
package assimp-testmodels, which is downloaded and unpacked there; the program assimp (package assimp-utils) converts
them. Surfaces of libcgal-demo get a photograph of FOLDER/test_images. Each surface is remeshed evenly to 30,000 and to
5,000 points. Its texture is encoded there, decoded on the original surface, and compared with the original in its atlas.
Colors of vertices are interpolated linearly: those of the texture at the vertices, and fitted ones, the best of all in the
sense of least squares, which no encoder of one-rings finds. Atlases that overlap are replaced.

OUTPUT gets metrics.csv and crops-POINTS.png, and the table of means and standard deviations over the surfaces is printed. Needs
SciPy, matplotlib and Pillow (Debian: python3-scipy python3-matplotlib).
"""

import argparse
import csv
import os
import subprocess
import sys
import tarfile
from typing import NamedTuple

import numpy as np
from field_latent_images import unpack
from PIL import Image
from scipy.ndimage import distance_transform_edt, gaussian_filter
from scipy.sparse import coo_matrix, identity
from scipy.sparse.linalg import splu
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import reference
from vtkmodules.vtkCommonDataModel import vtkGenericCell, vtkStaticCellLocator

import surfacesynthesis
from surfacesynthesis.datasets import dataset_of_pair
from surfacesynthesis.texture_datasets import reduced_image

ARCHIVE = "/usr/share/doc/libcgal-demo/data.tar.gz"
MODELS = "usr/share/assimp/models"
#: Textured models: file, material or None for all, and image.
TEXTURED = {
    "duck": ("Collada/duck.dae", None, "Collada/duckCM.tga"),
    "body": ("IQM/mrfixit.iqm", "Body.jpg", "IQM/Body.jpg"),
    "head": ("IQM/mrfixit.iqm", "Head.jpg", "IQM/Head.jpg"),
    "wrinkles": ("Ogre/TheThing/Mesh.mesh.xml", None, "Ogre/TheThing/Wrinkles.jpg"),
    "jeep": ("MS3D/jeep1.ms3d", None, "MS3D/jeep1.jpg"),
    "globe": ("LWO/LWO2/MappingModes/earth_uv_cylindrical_y.lwo", None, "LWO/LWO2/MappingModes/earthCylindric.jpg"),
}
#: Surfaces of libcgal-demo, and the photographs that they get.
PAINTED = {"bear": "dragonfly", "bunny00": "onestandsout", "elephant": "picture_1a", "nefertiti": "ihc"}
METHODS = ("field latents", "barycentric", "vertex colors", "fitted colors")
ATLAS = 1024  # largest height and width of an atlas in pixels
COLUMNS = ("surface", "points", "texels_per_point", "method", "psnr", "dssim")


class Textured(NamedTuple):
    """A surface with an atlas."""

    points: np.ndarray  #: [V, 3]
    triangles: np.ndarray  #: [F, 3]
    coordinates: np.ndarray  #: [F, 3, 2], texture coordinates of the corners, from 0 to 1
    image: np.ndarray  #: uint8 [H, W, 3], row 0 at v = 1


class Places(NamedTuple):
    """Places on a surface."""

    triangles: np.ndarray  #: [Q]
    weights: np.ndarray  #: [Q, 3], barycentric coordinates


# -- textured surfaces -------------------------------------------------------------------------------------------------


def converted(path, material):
    """The faces with a material of a file that assimp reads: points, triangles, texture coordinates of the corners."""
    output = os.path.join(os.path.dirname(path), "converted.obj")
    subprocess.run(["assimp", "export", path, output, "-tri"], check=True, stdout=subprocess.DEVNULL)
    rows, faces, used = {"v": [], "vt": []}, [], None
    with open(output, encoding="utf-8", errors="replace") as file:
        for line in file:
            words = line.split()
            if words and words[0] in rows:
                rows[words[0]].append([float(word) for word in words[1:4]])
            elif words and words[0] == "usemtl":
                used = words[1]
            elif words and words[0] == "f" and len(words) == 4 and material in (None, used):
                faces.append([[int(number or 0) for number in word.split("/")[:2]] for word in words[1:]])
    corners = np.array([face for face in faces if all(corner[1] for corner in face)]) - 1
    points = np.array(rows["v"])[:, :3]
    used, triangles = np.unique(corners[:, :, 0], return_inverse=True)
    return points[used], triangles.reshape(-1, 3), np.array(rows["vt"])[corners[:, :, 1], :2]


def textured_model(name, folder):
    """A textured model of assimp-testmodels."""
    file, material, picture = TEXTURED[name]
    models = os.path.join(folder, MODELS)
    image = np.asarray(Image.open(os.path.join(models, picture)).convert("RGB"))
    points, triangles, coordinates = converted(os.path.join(models, file), material)
    return Textured(points, triangles, np.clip(coordinates, 0.0, 1.0), reduced_image(image, ATLAS))


def painted_surface(name, picture, extent=0.7):
    """A surface of libcgal-demo with a photograph, projected along the axes and blended by the normals. The photograph
    is as wide as ``extent`` of the longest side of the surface."""
    with tarfile.open(ARCHIVE) as archive:
        text = archive.extractfile(f"data/meshes/{name}.off").read().split()
    count, faces = int(text[1]), int(text[2])
    points = np.array(text[4 : 4 + 3 * count], dtype=float).reshape(-1, 3)
    triangles = np.array(text[4 + 3 * count : 4 + 3 * count + 4 * faces], dtype=int).reshape(-1, 4)[:, 1:]
    points, triangles = surfacesynthesis.repair((points, triangles), holes="none", largest_component=True)[:2]
    scale = np.ptp(points, axis=0).max() * extent
    photograph = np.asarray(Image.open(picture).convert("RGB"))
    height, width = photograph.shape[:2]

    def color(places, corners):
        weights = np.abs(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])) ** 4 + 1e-30
        at = (places - points.min(axis=0)) / scale
        total = 0.0
        for axis in range(3):
            u, v = (at[:, k] for k in range(3) if k != axis)
            total += weights[:, axis, None] * sampled(photograph, mirrored(u), mirrored(v * width / height))
        return total / weights.sum(axis=1)[:, None]

    return with_atlas(points, triangles, color)


def mirrored(t):
    """Coordinates folded to 0 to 1."""
    return 1.0 - np.abs(np.mod(t, 2.0) - 1.0)


def with_atlas(points, triangles, color):
    """A surface with an atlas of its own, whose texels have the colors color(places [Q, 3], corners [Q, 3, 3])."""
    points, triangles, coordinates = atlas_of(points, triangles)
    places = rasterized(coordinates, ATLAS, ATLAS)
    known = places.triangles >= 0
    corners = points[triangles[places.triangles[known]]]
    image = np.zeros((ATLAS * ATLAS, 3))
    image[known] = color(np.einsum("qk,qkx->qx", places.weights[known], corners), corners)
    image = np.rint(np.clip(image, 0, 255)).astype(np.uint8).reshape(ATLAS, ATLAS, 3)
    nearest = distance_transform_edt(~known.reshape(ATLAS, ATLAS), return_distances=False, return_indices=True)
    return Textured(points, triangles, coordinates, image[tuple(nearest)])  # charts have gutters of their colors


def atlas_of(points, triangles):
    """Points, triangles and texture coordinates [F, 3, 2] of an atlas made by texture_atlas()."""
    points, triangles, coordinates = surfacesynthesis.texture_atlas((points, triangles), resolution=ATLAS)
    return points, triangles, coordinates[triangles]


def without_overlaps(surface):
    """The surface; with an atlas of its own where more than 2 per cent of the texels have several triangles."""
    height, width = surface.image.shape[:2]
    counts = np.zeros(height * width, dtype=int)
    for _, texels, _ in covered_texels(surface.coordinates, width, height):
        counts[texels] += 1
    if (counts > 1).sum() <= 0.02 * (counts > 0).sum():
        return surface
    closest = Closest(surface.points, surface.triangles)
    points, triangles = surfacesynthesis.repair((surface.points, surface.triangles), holes="none")[:2]
    return with_atlas(points, triangles, lambda places, _: colors_at(surface, closest(places)))


# -- texels and places -------------------------------------------------------------------------------------------------


def covered_texels(coordinates, width, height):
    """For each triangle: its number, the texels whose centers it holds (row 0 at v = 1), barycentric coordinates."""
    for number, corner in enumerate(coordinates * [width, height]):
        low = np.maximum(np.ceil(corner.min(axis=0) - 0.5), 0).astype(int)
        high = np.minimum(np.floor(corner.max(axis=0) - 0.5), [width - 1, height - 1]).astype(int)
        if (high < low).any():
            continue
        x, y = (axis.ravel() for axis in np.meshgrid(np.arange(low[0], high[0] + 1), np.arange(low[1], high[1] + 1)))
        (ux, uy), (vx, vy) = corner[1] - corner[0], corner[2] - corner[0]
        determinant = ux * vy - uy * vx
        if determinant == 0:
            continue
        px, py = x + 0.5 - corner[0, 0], y + 0.5 - corner[0, 1]
        b, c = (px * vy - py * vx) / determinant, (ux * py - uy * px) / determinant
        inside = (b >= 0) & (c >= 0) & (b + c <= 1)
        weights = np.stack([1 - b - c, b, c], axis=1)[inside]
        yield number, (height - 1 - y[inside]) * width + x[inside], weights


def rasterized(coordinates, width, height):
    """The Places of all texels, row by row; the triangle is -1 where there is none."""
    triangles, weights = np.full(height * width, -1), np.zeros((height * width, 3))
    for number, texels, inside in covered_texels(coordinates, width, height):
        triangles[texels], weights[texels] = number, inside
    return Places(triangles, weights)


def sampled(image, u, v):
    """Bilinear colors [Q, 3] of an image at coordinates from 0 to 1, with v = 0 in the last row."""
    height, width = image.shape[:2]
    x, y = np.clip(u * width - 0.5, 0, width - 1), np.clip((1 - v) * height - 0.5, 0, height - 1)
    i, j = np.minimum(x.astype(int), width - 2), np.minimum(y.astype(int), height - 2)
    s, t = (x - i)[:, None], (y - j)[:, None]
    top = (1 - s) * image[j, i] + s * image[j, i + 1]
    return (1 - t) * top + t * ((1 - s) * image[j + 1, i] + s * image[j + 1, i + 1])


def colors_at(surface, places):
    """Colors [Q, 3] of a textured surface at places."""
    at = np.einsum("qk,qkx->qx", places.weights, surface.coordinates[places.triangles])
    return sampled(surface.image, at[:, 0], at[:, 1])


def positions(points, triangles, places):
    """[Q, 3] the positions of places."""
    return np.einsum("qk,qkx->qx", places.weights, points[triangles[places.triangles]])


class Closest:
    """Closest Places on a surface."""

    def __init__(self, points, triangles):
        self._points, self._triangles = points, triangles
        self._locator = vtkStaticCellLocator()
        self._locator.SetDataSet(dataset_of_pair((points, triangles)))
        self._locator.BuildLocator()

    def __call__(self, wanted):
        found, on = np.zeros(len(wanted), dtype=int), np.zeros((len(wanted), 3))
        cell, number, part, distance, place = vtkGenericCell(), reference(0), reference(0), reference(0.0), [0.0] * 3
        for k, point in enumerate(np.asarray(wanted, dtype=float).tolist()):
            self._locator.FindClosestPoint(point, place, cell, number, part, distance)
            found[k], on[k] = number, place
        return Places(found, barycentric(on, self._points[self._triangles[found]]))


def barycentric(places, corners):
    """Barycentric coordinates [Q, 3], from 0 to 1, of places in the planes of triangles [Q, 3, 3]."""
    u, v, w = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], places - corners[:, 0]
    uu, uv, vv, uw, vw = (np.einsum("qx,qx->q", a, b) for a, b in ((u, u), (u, v), (v, v), (u, w), (v, w)))
    determinant = np.maximum(uu * vv - uv * uv, 1e-300)
    b, c = (vv * uw - uv * vw) / determinant, (uu * vw - uv * uw) / determinant
    weights = np.clip(np.stack([1 - b - c, b, c], axis=1), 0, 1)
    return weights / weights.sum(axis=1)[:, None]


# -- methods -----------------------------------------------------------------------------------------------------------


def retextured(points, triangles, surface):
    """A surface with the texture of another at the closest places: each triangle has a square of texels of its own, in
    which it reaches from the center of the first texel to those of the last ones."""
    side = max(7, int(np.sqrt(1.5 * surface.image.shape[0] * surface.image.shape[1] / len(triangles))))
    columns = int(np.ceil(np.sqrt(len(triangles))))
    size = columns * side
    place = np.stack(np.divmod(np.arange(len(triangles)), columns), axis=1)[:, ::-1] * side + 0.5
    coordinates = (place[:, None] + np.array([[0, 0], [side - 1, 0], [0, side - 1]])) / size
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(side), np.arange(side)))
    x, y = x[x + y <= side], y[x + y <= side]
    weights = np.stack([side - 1 - x - y, x, y], axis=1) / (side - 1)
    wanted = np.einsum("ik,fkx->fix", weights, points[triangles]).reshape(-1, 3)
    colors = colors_at(surface, Closest(surface.points, surface.triangles)(wanted))
    image = np.zeros((size, size, 3), np.uint8)
    start = (place - 0.5).astype(int)
    rows, texels = size - 1 - (start[:, None, 1] + y), start[:, None, 0] + x
    image[rows.ravel(), texels.ravel()] = np.rint(colors).astype(np.uint8)
    return Textured(points, triangles, coordinates, image)


def vtk_of(surface):
    """The vtkPolyData of a textured surface, with points of its own for each triangle where seams part them."""
    corners = np.concatenate([surface.triangles[:, :, None], surface.coordinates], axis=2).reshape(-1, 3)
    rows, ids = np.unique(corners, axis=0, return_inverse=True)
    mesh = dataset_of_pair((surface.points[rows[:, 0].astype(int)], ids.reshape(-1, 3)))
    coordinates = numpy_to_vtk(np.ascontiguousarray(rows[:, 1:], dtype=np.float64), deep=True)
    coordinates.SetName("TCoords")
    mesh.GetPointData().SetTCoords(coordinates)
    return mesh


def by_field_latents(surface, carried, model, samples=None):
    """The atlas [H, W, 3] that is encoded on another triangulation with the texture and decoded on the surface."""
    encoded = surfacesynthesis.encode_texture(vtk_of(carried), carried.image, model=model, samples_per_ring=samples)
    height, width = surface.image.shape[:2]
    decoded = surfacesynthesis.decode_texture(encoded, model=model, target=vtk_of(surface), resolution=(width, height))
    values = vtk_to_numpy(decoded.image.GetPointData().GetScalars())
    return values.reshape(height, width, 3)[::-1]  # VTK has the bottom row first


def by_vertex_colors(surface, coarse, texels, known):
    """The atlases [H, W, 3] of colors at the points of a triangulation: those of the texture there, and fitted ones."""
    points, triangles = coarse
    closest = Closest(points, triangles)(positions(surface.points, surface.triangles, texels))
    wanted = surface.image.reshape(-1, 3)[known].astype(float)
    rows = np.repeat(np.arange(len(wanted)), 3)
    entries = (closest.weights.ravel(), (rows, triangles[closest.triangles].ravel()))
    blend = coo_matrix(entries, (len(wanted), len(points))).tocsr()
    there = colors_at(surface, Closest(surface.points, surface.triangles)(points))
    weight = 1e-3  # of the colors at the points, for those without texels
    solver = splu((blend.T @ blend + weight * identity(len(points))).tocsc())
    images = []
    for colors in (there, solver.solve(blend.T @ wanted + weight * there)):
        image = surface.image.reshape(-1, 3).copy()
        image[known] = np.rint(np.clip(blend @ colors, 0, 255)).astype(np.uint8)
        images.append(image.reshape(surface.image.shape))
    return images


# -- measures ----------------------------------------------------------------------------------------------------------


def psnr(image, wanted, known):
    """Peak signal-to-noise ratio in decibels over the texels of a mask [H, W]."""
    errors = (image[known].astype(float) - wanted[known]) ** 2
    return 10 * np.log10(255**2 / max(errors.mean(), 1e-10))


def dssim(image, wanted, known):
    """(1 - SSIM) / 2 over the texels of a mask: windows of a Gaussian of 1.5 texels [Wang2004]."""
    a, b = np.where(known[:, :, None], image, wanted).astype(float), wanted.astype(float)

    def mean(x):
        return gaussian_filter(x, (1.5, 1.5, 0), truncate=3.5)

    ma, mb = mean(a), mean(b)
    aa, bb, ab = mean(a * a) - ma * ma, mean(b * b) - mb * mb, mean(a * b) - ma * mb
    c1, c2 = (0.01 * 255) ** 2, (0.03 * 255) ** 2
    ssim = (2 * ma * mb + c1) * (2 * ab + c2) / ((ma * ma + mb * mb + c1) * (aa + bb + c2))
    return (1 - ssim[known].mean()) / 2


# -- comparison --------------------------------------------------------------------------------------------------------


def compared(name, surface, sizes, models, samples=None):
    """Rows of the table, and crops (size, [original, *methods], titles) of one surface."""
    height, width = surface.image.shape[:2]
    texels = rasterized(surface.coordinates, width, height)
    known = texels.triangles >= 0
    texels, mask = Places(texels.triangles[known], texels.weights[known]), known.reshape(height, width)
    whole = surfacesynthesis.repair((surface.points, surface.triangles), holes="none")[:2]
    rows, crops = [], []
    for size in sizes:
        coarse = surfacesynthesis.remesh(whole, points=size, feature_angle=None)[:2]
        carried = retextured(*coarse, surface)
        images = {method: by_field_latents(surface, carried, model, samples) for method, model in models.items() if model}
        images.update(zip(METHODS[2:], by_vertex_colors(surface, coarse, texels, known)))
        for method, image in images.items():
            rows.append(
                dict(zip(COLUMNS, (name, len(coarse[0]), len(texels.triangles) / len(coarse[0]), method,
                                   psnr(image, surface.image, mask), dssim(image, surface.image, mask))))
            )  # fmt: skip
            print("{surface}, {points} points, {method}: {psnr:.2f} dB, DSSIM {dssim:.4f}".format(**rows[-1]), flush=True)
        crops.append((size, *crops_of({"original": surface.image, **images}, mask)))
    return rows, crops


def crops_of(images, mask, side=160):
    """The same square of all images, white outside the atlas, and titles: the square with the most variance among those
    that the atlas fills. The first image is the original."""
    titles, images = list(images), list(images.values())
    side = min(side, *mask.shape)
    best = (-1.0, 0, 0)
    for y in range(0, mask.shape[0] - side + 1, side // 2):
        for x in range(0, mask.shape[1] - side + 1, side // 2):
            filled = mask[y : y + side, x : x + side].mean()
            spread = images[0][y : y + side, x : x + side].std(axis=(0, 1)).mean()
            best = max(best, (float(spread * filled**4), y, x))
    _, y, x = best
    square = np.s_[y : y + side, x : x + side]
    for k in range(1, len(images)):
        titles[k] += f", {psnr(images[k][square], images[0][square], mask[square]):.1f} dB"
    return [np.where(mask[square][:, :, None], image[square], np.uint8(255)) for image in images], titles


def draw(crops, path):
    """A picture with a row of crops for each surface, and their peak signal-to-noise ratios."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    columns = max(len(titles) for _, _, _, titles in crops)
    shape = {"figsize": (2.2 * columns, 2.4 * len(crops)), "layout": "constrained"}
    figure, axes = pyplot.subplots(len(crops), columns, squeeze=False, **shape)
    for line, (name, size, images, titles) in zip(axes, crops):
        for axis, image, title in zip(line, images, titles):
            axis.imshow(image, interpolation="nearest")
            axis.set_title(title if title != "original" else f"{name}, {size:,} points", fontsize=8)
        for axis in line:
            axis.axis("off")
    figure.savefig(path, dpi=80)
    pyplot.close(figure)


def write_rows(rows, path):
    """Writes all rows as comma-separated values."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(rows)


def print_table(rows, sizes):
    """Prints means and standard deviations over the surfaces."""
    print("| points | method | PSNR, dB | DSSIM | field latents before it, dB |\n|---:|---|---:|---:|---:|")
    for size in sizes:
        of_size = [row for row in rows if abs(row["points"] - size) < 0.1 * size]
        best = {row["surface"]: row["psnr"] for row in of_size if row["method"] == METHODS[0]}
        for method in METHODS:
            found = [row for row in of_size if row["method"] == method]
            if not found:
                continue
            values = np.array([[row["psnr"], row["dssim"], best.get(row["surface"], np.nan) - row["psnr"]] for row in found])
            cells = [f"{mean:.3f} ± {deviation:.3f}" for mean, deviation in zip(values.mean(axis=0), values.std(axis=0))]
            print(f"| {size:,} | {method} | {' | '.join(cells)} |")


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", help="folder of field_latent_images.py")
    parser.add_argument("output", help="folder; made when it is not there")
    parser.add_argument("--model", help="model of field latents")
    parser.add_argument("--ablation", help="model with barycentric coordinates")
    names = [*TEXTURED, *PAINTED]
    parser.add_argument("--surfaces", nargs="+", choices=names, default=names)
    parser.add_argument("--points", nargs="+", type=int, default=[30000, 5000], help="default: 30000 5000")
    parser.add_argument(
        "--samples-per-ring", type=int, metavar="N",
        help="samples of colors in a one-ring; another number draws others (default: as in the training)",
    )  # fmt: skip
    options = parser.parse_args(arguments)
    os.makedirs(options.output, exist_ok=True)
    packages = os.path.join(os.path.abspath(options.folder), "packages")
    os.makedirs(packages, exist_ok=True)
    rows, crops = [], []
    for name in options.surfaces:
        if name in TEXTURED:
            surface = without_overlaps(textured_model(name, unpack("assimp-testmodels", packages)))
        else:
            picture = os.path.join(options.folder, "test_images", PAINTED[name] + ".png")
            surface = painted_surface(name, picture)
        models = dict(zip(METHODS, (options.model, options.ablation)))
        found, parts = compared(name, surface, options.points, models, options.samples_per_ring)
        rows += found
        crops += [(name, size, images, titles) for size, images, titles in parts]
        write_rows(rows, os.path.join(options.output, "metrics.csv"))  # what there is, should a surface fail
        for size in options.points:
            draw([row for row in crops if row[1] == size], os.path.join(options.output, f"crops-{size}.png"))
    print_table(rows, options.points)
    print(f"wrote {options.output}/metrics.csv and crops-POINTS.png", file=sys.stderr)


if __name__ == "__main__":
    main()
