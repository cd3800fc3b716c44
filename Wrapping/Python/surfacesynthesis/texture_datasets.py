# SPDX-License-Identifier: BSD-3-Clause
"""Images and planar meshes in files: training data of field latents."""

import os
from typing import NamedTuple

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import VTK_UNSIGNED_CHAR, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkDelaunay2D
from vtkmodules.vtkImagingCore import vtkImageResize

from .arguments import INT_MIN, integer, progress_callback
from .errors import Cancelled, FormatError
from .files.images import read_image
from .results import html_table
from .safetensors import read_safetensors, write_safetensors

_CONTENT, _VERSION = "textures", "1"
#: Candidates of the farthest-point sampling for each point.
_CANDIDATES = 8
#: The narrowest triangle that is kept: height over longest edge. Flatter ones lie at the border of the square only.
_FLATTEST = 1e-3


class PlanarMesh(NamedTuple):
    """A triangulation of points of the unit square."""

    points: np.ndarray  #: [V, 2] float64
    triangles: np.ndarray  #: [F, 3] int64, counterclockwise


class TextureDataset(NamedTuple):
    """Content of a file: images of any sizes, and meshes that the training lays over them."""

    images: list  #: uint8 [H, W, 3] each
    meshes: list  #: PlanarMesh each

    def __repr__(self):
        return f"<TextureDataset: {len(self.images)} images, {len(self.meshes)} planar meshes>"

    def _repr_html_(self):
        rows = [(f"image {k}", f"{image.shape[1]} x {image.shape[0]} pixels") for k, image in enumerate(self.images)]
        rows += [
            (f"mesh {k}", f"{len(mesh.points):,} points, {len(mesh.triangles):,} triangles")
            for k, mesh in enumerate(self.meshes)
        ]
        return html_table(rows)


def texture_dataset(path, images, tile=512, side=1024, tiles=4, meshes=64, mesh_points=2500, seed=0, progress=None):
    """Writes a dataset to train field latents on: tiles of images, and random planar meshes [Mitchel2024], section 9.1.

    Images whose shorter side exceeds ``side`` are reduced to it. Tiles of an image do not overlap; images with a side
    shorter than 16 pixels are refused. Points of the meshes are farthest-point samples of the unit square, triangulated
    by Delaunay. The same arguments give the same bytes.

    Parameters
    ----------
    path : str or path-like
        The file to write; its ending should be .safetensors.
    images : list of path or array
        Image files (.png, .jpg, .bmp, .tga) or arrays [H, W], [H, W, 1], [H, W, 3] or [H, W, 4] of
        uint8, of uint16, or of floating-point numbers from 0 to 1. An alpha channel is dropped.
    tile : int
        Largest height and width of a tile in pixels, at least 16. Default 512.
    side : int
        Largest shorter side of an image before it is cut, in pixels. Default 1024.
    tiles : int
        Largest number of tiles of an image, drawn at random where there are more. Default 4.
    meshes : int
        Number of meshes. Default 64 (the paper: 1000).
    mesh_points : int
        Number of points of a mesh, at least 16. Default 2500 (the paper: 10000).
    seed : int
        Any integer of 32 bits. Default 0.
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, nothing is written.

    Returns
    -------
    TextureDataset
        The content of the file.

    Raises
    ------
    FormatError
        A file is no image that can be read.
    Cancelled
        ``progress`` returned False.
    ValueError, TypeError
        An argument has a value out of its range or is of a wrong type.
    OSError
        A file cannot be read or written.
    """
    seed = checked_options(tile, side, tiles, meshes, mesh_points, seed)
    progress_callback(progress)
    if isinstance(images, (str, bytes, os.PathLike, np.ndarray)):
        raise TypeError("images must be a list of files or arrays, not one of them")
    images = list(images)
    if not images:
        raise ValueError("images is empty; a dataset needs an image")
    report = _Reporter(progress, len(images) + meshes)
    cut = []
    for k, image in enumerate(images):
        cut += _tiles_of(reduced_image(image_array(image), side), tile, tiles, np.random.default_rng((seed, 0, k)))
        report.one_more()
    made = []
    for k in range(meshes):
        made.append(planar_mesh(mesh_points, np.random.default_rng((seed, 1, k))))
        report.one_more()
    write_texture_dataset(path, cut, made)
    return TextureDataset(cut, made)


def checked_options(tile=512, side=1024, tiles=4, meshes=64, mesh_points=2500, seed=0):
    """Checks the numbers that texture_dataset() takes; returns the seed as one that is not negative."""
    integer("tile", tile, 16)
    integer("side", side, 16)
    integer("tiles", tiles, 1)
    integer("meshes", meshes, 1)
    integer("mesh_points", mesh_points, 16)
    return integer("seed", seed, INT_MIN) % 2**32


def image_array(image):
    """An image file, or an array, as uint8 [H, W, 3] with its top row first; raises FormatError, OSError, TypeError and
    ValueError."""
    if isinstance(image, (str, bytes, os.PathLike)):
        return _read_image(os.fsdecode(image))
    image = np.asarray(image)
    if image.ndim == 2:
        image = image[:, :, None]
    if image.ndim != 3 or image.shape[2] not in (1, 2, 3, 4) or 0 in image.shape:
        raise ValueError(f"an image must have the shape [H, W], or [H, W, C] with C from 1 to 4, not {list(image.shape)}")
    if image.dtype == np.uint16:
        image = (image // 257).astype(np.uint8)
    elif image.dtype.kind == "f":
        if not np.isfinite(image).all() or image.min() < 0 or image.max() > 1:
            raise ValueError("an image of floating-point numbers must have values from 0 to 1")
        image = np.rint(255.0 * image).astype(np.uint8)
    elif image.dtype != np.uint8:
        raise TypeError(f"an image must be of uint8, uint16 or floating-point numbers, not {image.dtype}")
    image = image[:, :, :3] if image.shape[2] > 2 else np.repeat(image[:, :, :1], 3, axis=2)
    return np.ascontiguousarray(image)


def reduced_image(image, side):
    """An image uint8 [H, W, 3], reduced with antialiasing so that its shorter side is at most ``side`` pixels."""
    height, width = image.shape[:2]
    shorter = min(height, width)
    if shorter <= side:
        return image
    size = [max(1, round(length * side / shorter)) for length in (width, height)]
    data = vtkImageData()
    data.SetDimensions(width, height, 1)
    values = numpy_to_vtk(np.ascontiguousarray(image).reshape(-1, 3), deep=True, array_type=VTK_UNSIGNED_CHAR)
    data.GetPointData().SetScalars(values)
    resize = vtkImageResize()
    resize.SetInputData(data)
    resize.SetOutputDimensions(*size, 1)
    resize.Update()
    values = vtk_to_numpy(resize.GetOutput().GetPointData().GetScalars())
    return values.reshape(size[1], size[0], 3).copy()


def planar_mesh(points, random):
    """A PlanarMesh of farthest-point samples of the unit square, triangulated by Delaunay. ``random`` is a NumPy
    generator."""
    samples = _farthest_points(random.random((_CANDIDATES * points, 2)), points)
    given = vtkPoints()
    given.SetData(numpy_to_vtk(np.column_stack((samples, np.zeros(points))), deep=True))
    data = vtkPolyData()
    data.SetPoints(given)
    delaunay = vtkDelaunay2D()
    delaunay.SetInputData(data)
    delaunay.SetTolerance(0.0)
    delaunay.Update()
    triangles = vtk_to_numpy(delaunay.GetOutput().GetPolys().GetConnectivityArray()).reshape(-1, 3).astype(np.int64)
    doubled = _double_areas(samples, triangles)
    triangles[doubled < 0] = triangles[doubled < 0][:, ::-1]
    corners = samples[triangles]
    longest = np.max([((corners[:, k] - corners[:, k - 1]) ** 2).sum(axis=1) for k in range(3)], axis=0)
    return PlanarMesh(samples, triangles[np.abs(doubled) > _FLATTEST * longest])


def write_texture_dataset(path, images, meshes):
    """Writes images and planar meshes to a file in the safetensors format.

    Tensors: ``images.K`` (uint8 [H, W, 3]), ``meshes.K.points`` (float64 [V, 2], from 0 to 1) and ``meshes.K.triangles``
    (int64 [F, 3], counterclockwise) for K = 0, 1, ...; metadata: ``content`` ("textures"), ``format_version`` ("1") and
    ``producer``. The same content gives the same bytes.

    Parameters
    ----------
    path : str or path-like
        The file; its ending should be .safetensors. It holds the old or the new content, never half of one.
    images : list of array
        As those of texture_dataset().
    meshes : list of (points, triangles)
        Points [V, 2] and triangles [F, 3].

    Raises
    ------
    ValueError, TypeError
        There is no image or no mesh, or one of them is not as described.
    OSError
        The file cannot be written.
    """
    images = [image_array(image) for image in images]
    meshes = [_checked_mesh(k, *mesh) for k, mesh in enumerate(meshes)]
    if not images or not meshes:
        raise ValueError(f"{len(images)} images and {len(meshes)} meshes; a dataset needs one of each")
    tensors = {f"images.{k}": image for k, image in enumerate(images)}
    for k, mesh in enumerate(meshes):
        tensors.update({f"meshes.{k}.{field}": array for field, array in mesh._asdict().items()})
    metadata = {"content": _CONTENT, "format_version": _VERSION, "producer": "SurfaceSynthesis"}
    double = [name for name in tensors if name.endswith(".points")]
    write_safetensors(path, tensors, metadata, double, [f"images.{k}" for k in range(len(images))])


def read_texture_dataset(path):
    """Reads what write_texture_dataset() has written; returns a TextureDataset.

    Raises FormatError when the file does not follow the format, OSError when it cannot be read.
    """
    counts = ()

    def judge(shapes, types, metadata):
        nonlocal counts
        counts = _judge_header(path, shapes, types, metadata)

    tensors, _ = read_safetensors(path, judge)
    images = [tensors[f"images.{k}"] for k in range(counts[0])]
    try:
        meshes = [
            _checked_mesh(k, tensors[f"meshes.{k}.points"], tensors[f"meshes.{k}.triangles"]) for k in range(counts[1])
        ]
    except ValueError as error:
        raise FormatError(f"{path}: {error}") from None
    return TextureDataset(images, meshes)


class _Reporter:
    """Calls a callable with the fraction of the work that is done."""

    def __init__(self, progress, parts):
        self._progress, self._parts, self._done = progress, parts, 0

    def one_more(self):
        self._done += 1
        answer = None if self._progress is None else self._progress(self._done / self._parts)
        if answer is not None and not answer:
            raise Cancelled("cancelled by the progress callable")


def _read_image(path):
    image = read_image(path)
    width, height, _ = image.GetDimensions()
    array = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(height, width, -1)[::-1]  # VTK has the bottom row first
    try:
        return image_array(array)
    except (TypeError, ValueError) as error:
        raise FormatError(f"{path}: {error}") from None


def _tiles_of(image, tile, most, random):
    """At most ``most`` tiles of a regular partition with sides of at most ``tile``."""
    height, width = image.shape[:2]
    if min(height, width) < 16:
        raise ValueError(f"an image of {width} x {height} pixels is too small; 16 x 16 are needed")
    rows, columns = _partition(height, tile), _partition(width, tile)
    places = [(slice(*r), slice(*c)) for r in rows for c in columns]
    chosen = np.sort(random.permutation(len(places))[:most])
    return [np.ascontiguousarray(image[places[k]]) for k in chosen]


def _partition(length, tile):
    """Whole tiles of ``length``, with equal parts left out at both ends; the whole where there is none."""
    count = length // tile
    if count == 0:
        return [(0, length)]
    first = (length - count * tile) // 2
    return [(first + k * tile, first + (k + 1) * tile) for k in range(count)]


def _farthest_points(candidates, count):
    """``count`` of the candidates, each the farthest from those before it."""
    chosen = np.zeros(count, dtype=np.int64)
    x, y = np.ascontiguousarray(candidates.T)
    distances = np.full(len(candidates), np.inf)
    for k in range(1, count):
        last = chosen[k - 1]
        np.minimum(distances, (x - x[last]) ** 2 + (y - y[last]) ** 2, out=distances)
        chosen[k] = np.argmax(distances)
    return candidates[chosen]


def _double_areas(points, triangles):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]


def _checked_mesh(k, points, triangles):
    points, triangles = np.asarray(points), np.asarray(triangles)
    if points.dtype.kind not in "fiu" or triangles.dtype.kind not in "iu":
        raise TypeError(f"mesh {k} must have numbers as points and integers as triangles")
    if points.ndim != 2 or points.shape[1] != 2 or triangles.ndim != 2 or triangles.shape[1] != 3 or 0 in triangles.shape:
        raise ValueError(
            f"mesh {k} has points {list(points.shape)} and triangles {list(triangles.shape)}; [V, 2] and [F, 3] are needed"
        )
    points, triangles = points.astype(np.float64), triangles.astype(np.int64)
    if not ((points >= 0) & (points <= 1)).all():
        raise ValueError(f"mesh {k} has a point outside the unit square")
    if triangles.min() < 0 or triangles.max() >= len(points):
        raise ValueError(f"a triangle of mesh {k} names a point that does not exist")
    if (_double_areas(points, triangles) <= 0).any():
        raise ValueError(f"mesh {k} has a triangle that is not counterclockwise")
    return PlanarMesh(points, triangles)


def _judge_header(path, shapes, types, metadata):
    """Raises FormatError for a file that is no dataset, before its arrays are read; returns the numbers of images and
    meshes."""
    for key, wanted in (("content", _CONTENT), ("format_version", _VERSION)):
        if metadata.get(key) != wanted:
            raise FormatError(f"{path}: the {key} is '{metadata.get(key, '')}', not '{wanted}'")
    images = sum(name.startswith("images.") for name in shapes)
    meshes = sum(name.endswith(".points") for name in shapes)
    expected = {f"images.{k}": (np.uint8, (None, None, 3)) for k in range(max(1, images))}
    for k in range(max(1, meshes)):
        expected.update({f"meshes.{k}.points": (np.float64, (None, 2)), f"meshes.{k}.triangles": (np.int64, (None, 3))})
    if set(expected) != set(shapes):
        raise FormatError(f"{path}: the tensor {min(set(expected) ^ set(shapes))} is missing or has no meaning")
    for name, (kind, form) in expected.items():
        shape = shapes[name]
        fits = len(shape) == len(form) and all(wanted in (None, size) for wanted, size in zip(form, shape))
        if types[name] != kind or not fits or 0 in shape:
            raise FormatError(f"{path}: '{name}' is {types[name]} {list(shape)}, which does not fit its meaning")
    return images, meshes
