#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A texture on several triangulations and atlases of one surface: encoded as field latents, interpolated, and decoded.

    xvfb-run -a python3 texture_transfer.py PHOTOGRAPH --output DIR

PHOTOGRAPH, a PNG or JPEG file, is laid on an even triangulation of a scanned surface of Debian's package libcgal-demo, along
the axes of the surface and blended by its normals. Its texture is encoded there and decoded on the triangulation of the
scan, and on a third one, each with an atlas of its own. Writes

    texture_transfer.png   above: the surface with its texture, the triangles whose vertices carry the latents, and the
                           decoded textures; middle: parts of them, and the colors that the vertices alone would carry;
                           below: the atlases, and the first latents
    texture_NAME.obj       the surfaces with their textures (.mtl, .png), for other programs

and prints how long each step took, and the PSNR of the decoded textures against the photograph laid on these surfaces.
"""

import argparse
import os
import sys
import time

import gallery_rendering as rendering
import numpy as np
import surfacesynthesis
from surfacesynthesis.files.images import read_image
from surfacesynthesis.files.polygons import point_normals
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData

EXAMPLES = os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir)
sys.path.insert(0, os.path.join(EXAMPLES, "Training"))

from make_datasets import surface  # noqa: E402

SIZE = (460, 440)
#: Surface, the direction that it is seen from, and the part of its height that the lower row shows.
MESH, DIRECTION, PART = "bear.off", (0.35, 0.25, 1.0), 0.30
#: Height of the middle of that part over (or below, where negative) the middle of the surface, in heights of the view.
FOCUS = -0.22
#: The photograph is as wide as this part of the longest side of the surface.
EXTENT = 0.8


def texels_of(image):
    """The RGB colors of an image, [H, W, 3] from 0 to 1, row 0 at v = 0."""
    width, height, _ = image.GetDimensions()
    texels = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(height, width, -1) / 255.0
    return texels[..., :3] if texels.shape[2] >= 3 else np.repeat(texels[..., :1], 3, axis=2)


def sampled(texels, places):
    """The colors of an image at ``places`` [Q, 2] from 0 to 1, mirrored beyond, bilinear."""
    height, width = texels.shape[:2]
    folded = 1.0 - np.abs(np.mod(places, 2.0) - 1.0)
    x, y = (folded * [width - 1, height - 1]).T
    i, j = np.minimum(x.astype(int), width - 2), np.minimum(y.astype(int), height - 2)
    s, t = (x - i)[:, None], (y - j)[:, None]
    low = (1 - s) * texels[j, i] + s * texels[j, i + 1]
    return (1 - t) * low + t * ((1 - s) * texels[j + 1, i] + s * texels[j + 1, i + 1])


def painted(mesh, photograph, resolution, bounds):
    """The image of a surface with an atlas on which a photograph is laid along the axes, and the texels that show it.
    ``bounds`` are the lowest coordinates and the longest side of the surface."""
    points = vtk_to_numpy(mesh.GetPoints().GetData()).astype(float)
    corners = vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    coordinates = vtk_to_numpy(mesh.GetPointData().GetTCoords())
    places, normals, known = baked(points, corners, coordinates, resolution)
    places = (places - bounds[0]) / (bounds[1] * EXTENT)
    ratio = photograph.shape[1] / photograph.shape[0]
    weights = np.abs(normals) ** 6 + 1e-12
    weights /= weights.sum(axis=1, keepdims=True)
    colors = np.zeros((len(places), 3))
    for axis, (u, v) in enumerate(((2, 1), (0, 2), (0, 1))):
        colors += weights[:, axis, None] * sampled(photograph, places[:, [u, v]] * [1.0, ratio])
    image = np.zeros((resolution, resolution, 3))
    image[known] = colors
    return image_of(filled(image, known)), known


def baked(points, corners, coordinates, resolution):
    """Places and normals on the surface of the texels that show it, and which texels do."""
    normals = np.cross(points[corners[:, 1]] - points[corners[:, 0]], points[corners[:, 2]] - points[corners[:, 0]])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    triangles = np.full((resolution, resolution), -1)
    place = np.zeros((resolution, resolution, 3))
    flat = coordinates[corners] * resolution
    for number, (a, b, c) in enumerate(flat):
        lower = np.maximum(np.floor(np.minimum(np.minimum(a, b), c) - 1), 0).astype(int)
        upper = np.minimum(np.ceil(np.maximum(np.maximum(a, b), c) + 1), resolution).astype(int)
        x, y = np.meshgrid(np.arange(lower[0], upper[0]) + 0.5, np.arange(lower[1], upper[1]) + 0.5)
        matrix = np.array([b - a, c - a]).T
        if abs(np.linalg.det(matrix)) < 1e-12:
            continue
        s, t = np.linalg.solve(matrix, np.stack([x.ravel() - a[0], y.ravel() - a[1]]))
        inside = (s > -1e-9) & (t > -1e-9) & (s + t < 1 + 1e-9)
        rows, columns = y.ravel()[inside].astype(int), x.ravel()[inside].astype(int)
        own = points[corners[number]]
        weights = np.stack([1 - s - t, s, t], axis=1)[inside]
        triangles[rows, columns] = number
        place[rows, columns] = weights @ own
    known = triangles >= 0
    return place[known], normals[triangles[known]], known


def filled(image, known, width=4):
    """The image with the colors of known texels carried outwards."""
    for _ in range(width):
        total, count = np.zeros_like(image), np.zeros(known.shape)
        for shift in ((0, 1), (0, -1), (1, 0), (-1, 0)):
            total += np.roll(np.where(known[..., None], image, 0.0), shift, axis=(0, 1))
            count += np.roll(known, shift, axis=(0, 1))
        new = ~known & (count > 0)
        image[new] = total[new] / count[new][:, None]
        known = known | new
    return image


def image_of(texels):
    """The vtkImageData of texels [H, W, 3] from 0 to 1."""
    image = vtkImageData()
    image.SetDimensions(texels.shape[1], texels.shape[0], 1)
    scalars = np.round(255 * np.clip(texels, 0, 1)).astype(np.uint8).reshape(-1, 3)
    image.GetPointData().SetScalars(numpy_to_vtk(scalars, deep=True))
    image.GetPointData().GetScalars().SetName("Texture")
    return image


def with_vertex_colors(mesh, image):
    """The surface with the colors of its image at the points, as the array "Color"."""
    colored = mesh.NewInstance()
    colored.ShallowCopy(mesh)
    coordinates = vtk_to_numpy(mesh.GetPointData().GetTCoords())
    array = numpy_to_vtk(np.round(255 * sampled(texels_of(image), coordinates)).astype(np.uint8), deep=True)
    array.SetName("Color")
    colored.GetPointData().AddArray(array)
    return colored


def shaded(mesh):
    """The surface with normals that have no seams where its atlas has some."""
    points = vtk_to_numpy(mesh.GetPoints().GetData())
    _, inverse = np.unique(points, axis=0, return_inverse=True)
    own = point_normals(mesh)  # weighted by area, made unit: near enough at a seam
    sums = np.zeros((inverse.max() + 1, 3))
    np.add.at(sums, inverse.reshape(-1), own)
    normals = sums / np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), 1e-30)
    array = numpy_to_vtk(normals[inverse.reshape(-1)].astype(np.float32), deep=True)
    array.SetName("Normals")
    mesh.GetPointData().SetNormals(array)
    return mesh


def timed(text, work):
    started = time.monotonic()
    result = work()
    print(f"{text}: {time.monotonic() - started:.1f} s", flush=True)
    return result


def psnr(image, truth, known):
    """Peak signal-to-noise ratio over the texels that show the surface, dB."""
    return -10 * np.log10(((texels_of(image) - texels_of(truth))[known] ** 2).mean())


def transfer(options):
    """The surfaces and images of the picture: (title, mesh, image)."""
    photograph = texels_of(read_image(options.photograph))
    scan = surface(options.mesh, MESH)
    points = vtk_to_numpy(scan.GetPoints().GetData()).astype(float)
    bounds = points.min(axis=0), np.ptp(points, axis=0).max()
    even = {count: surfacesynthesis.remesh(scan, points=count, feature_angle=None) for count in (options.points, 4000)}
    original, onto, third = (
        surfacesynthesis.texture_atlas(mesh, resolution=options.resolution, maximum_stretch=stretch)
        for mesh, stretch in ((even[options.points], 2.0), (scan, 3.0), (even[4000], 1.3))
    )
    image, _ = timed("photograph on the surface", lambda: painted(original, photograph, options.resolution, bounds))
    latents = timed("encoding", lambda: surfacesynthesis.encode_texture(original, image, options.model))
    surfaces = [(f"the original: {vertices(even[options.points])}", latents, image)]
    for title, mesh, bare in (("on the scan", onto, scan), ("on a third triangulation", third, even[4000])):
        decoded = timed(
            f"decoding {title}",
            lambda mesh=mesh: surfacesynthesis.decode_texture(
                latents, options.model, target=mesh, resolution=options.resolution
            ),
        )
        truth, known = painted(mesh, photograph, options.resolution, bounds)
        print(f"{title}: PSNR {psnr(decoded.image, truth, known):.1f} dB", flush=True)
        surfaces.append((f"decoded {title}:\n{vertices(bare)}", decoded.mesh, decoded.image))
    return surfaces


def vertices(mesh):
    return f"{mesh.GetNumberOfPoints():,} vertices"


def picture(surfaces, path, colors=None):
    """Writes the picture."""
    aspect = SIZE[0] / SIZE[1]
    shown = [(title, shaded(mesh), image) for title, mesh, image in surfaces]
    (title, original, image), *decoded = shown
    view = rendering.view_of(original, aspect, DIRECTION)
    close = view.zoomed(view.center + FOCUS * view.height * np.array(view.axes()[1]), PART * view.height)
    sheet = rendering.Sheet(3, 4, SIZE)
    carried = with_vertex_colors(original, image)
    columns = [(title, original, {"texture": image}), ("the triangles that carry it", original, {"edges": True})]
    columns += [(text, mesh, {"texture": texture}) for text, mesh, texture in decoded]
    for column, (text, mesh, how) in enumerate(columns):
        sheet.add(0, column, text, mesh, view, **how)
        if column == 1:
            sheet.add(1, column, "colors of its vertices alone", carried, close, array="Color")
        else:
            sheet.add(1, column, "", mesh, close, **how)
    lengths = np.linalg.norm(vtk_to_numpy(original.GetPointData().GetArray("FieldLatent_0")), axis=1)
    array = numpy_to_vtk(lengths, deep=True)
    array.SetName("Length")
    original.GetPointData().AddArray(array)
    by_length = rendering.sequential(0.0, np.quantile(lengths, 0.98))
    sheet.add(2, 1, "lengths of the first tangent vectors", original, view, array="Length", colors=by_length)
    for column, texture in ((0, image), (2, decoded[0][2]), (3, decoded[1][2])):
        sheet.add_image(2, column, "atlas", reduced(texels_of(texture), SIZE))
    sheet.write(path, colors)


def reduced(texels, size):
    """An image [height, width, 3] of bytes of a square texture, its first row on top."""
    side = min(size)
    steps = (np.arange(side) + 0.5) / side * texels.shape[0]
    rows = texels[::-1][steps.astype(int)][:, steps.astype(int)]
    image = rendering.blank(size)
    rendering.paste(image, np.round(255 * rows).astype(np.uint8), (size[0] - side) // 2, (size[1] - side) // 2)
    return image


def main(arguments=None):
    """Returns the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("photograph", metavar="PHOTOGRAPH", help="PNG or JPEG file")
    parser.add_argument("--output", default="gallery", metavar="DIR", help="folder to write to (default: gallery)")
    parser.add_argument("--mesh", metavar="FILE", help=f"surface (default: {MESH} of libcgal-demo)")
    parser.add_argument("--model", default="field_latents", metavar="FILE", help="model of field latents, or its name")
    parser.add_argument("--points", type=int, default=20000, metavar="N", help="vertices that carry latents (default: 20000)")
    parser.add_argument("--resolution", type=int, default=1024, metavar="N", help="texels along an atlas (default: 1024)")
    parser.add_argument("--colors", type=int, metavar="N", help="dither the picture to N colors, for a smaller file")
    options = parser.parse_args(arguments)
    os.makedirs(options.output, exist_ok=True)
    surfaces = transfer(options)
    for name, (_, mesh, image) in zip(("original", "scan", "third"), surfaces):
        path = os.path.join(options.output, f"texture_{name}.obj")
        surfacesynthesis.write_textured_mesh(mesh, image, path)
        print(f"wrote {path}", flush=True)
    picture(surfaces, os.path.join(options.output, "texture_transfer.png"), options.colors)
    return 0


if __name__ == "__main__":
    sys.exit(main())
