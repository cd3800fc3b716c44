# SPDX-License-Identifier: BSD-3-Clause
"""The textures of several materials as tiles of one image, with texture coordinates that lie in the tile of each polygon."""

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData

from ..errors import FormatError
from .images import LARGEST_SIDE, MOST_TEXELS
from .polygons import from_polydata, to_polydata

#: Texels around a tile that repeat its outermost ones: of bilinear interpolation and one level of a mipmap.
_MARGIN = 2
#: Side of the tile of a material without a texture, texels.
_PLAIN = 4
#: Largest distance of texture coordinates from [0, 1] that is taken for rounding.
_TOLERANCE = 1e-4


def joined_textures(path, mesh, materials, textures):
    """One surface and one image for several textures.

    Parameters
    ----------
    path : str
        Begin of messages.
    mesh : vtkPolyData
        Polygons; with texture coordinates "TCoords" where one of their materials has an image.
    materials : array [F] of int
        Number of the texture of each polygon.
    textures : list
        Images (vtkImageData), and colors (three numbers from 0 to 1) of materials without one.

    Returns
    -------
    pair of vtkPolyData and vtkImageData
        Points where polygons with different textures meet are doubled; the new ones come last.
    """
    arrays = from_polydata(mesh)
    if len(materials) != len(arrays.offsets) - 1:
        raise FormatError(f"{path}: {len(materials)} faces have materials, and {len(arrays.offsets) - 1} have corners")
    used, materials = np.unique(materials, return_inverse=True)
    tiles = _of_one_kind([textures[number] for number in used])
    atlas, places = _packed(path, tiles)
    tile_of_corner = np.repeat(materials.reshape(-1), np.diff(arrays.offsets))
    coordinates = arrays.arrays.get("TCoords")
    coordinates = np.zeros((len(arrays.points), 2)) if coordinates is None else coordinates.astype(np.float64)
    own = coordinates[arrays.connectivity]
    plain = np.array([not isinstance(textures[number], vtkImageData) for number in used])[tile_of_corner]
    own[plain] = 0.5
    _require_unit(path, own)
    sizes = np.array([tile.shape[1::-1] for tile in tiles], dtype=np.float64)
    corners = np.array(places, dtype=np.float64)
    own = (corners[tile_of_corner] + np.clip(own, 0.0, 1.0) * sizes[tile_of_corner]) / atlas.shape[1::-1]
    return _with_coordinates(arrays, tile_of_corner, own), _image_of(atlas)


def _require_unit(path, coordinates):
    outside = (~((coordinates >= -_TOLERANCE) & (coordinates <= 1 + _TOLERANCE))).any(axis=1)
    if outside.any():
        raise FormatError(
            f"{path}: the surface has several textures, and {np.count_nonzero(outside)} corners of faces have texture "
            "coordinates outside [0, 1], where a texture is repeated; textures are packed into one image, and a part of an "
            "image cannot be repeated. Save each material as a file of its own, or bake them into one texture"
        )


def _of_one_kind(textures):
    """Arrays [H, W, C] of one type and number of components; row 0 is the lowest one."""
    arrays = [_texels(one) if isinstance(one, vtkImageData) else one for one in textures]
    images = [array for array in arrays if isinstance(array, np.ndarray)]
    kind = images[0].dtype if len({array.dtype for array in images}) == 1 else np.dtype(np.uint8)
    alpha = any(array.shape[2] in (2, 4) for array in images)
    return [_converted(array, kind, alpha) for array in arrays]


def _texels(image):
    width, height, _ = image.GetDimensions()
    return vtk_to_numpy(image.GetPointData().GetScalars()).reshape(height, width, -1)


def _converted(array, kind, alpha):
    largest = np.iinfo(kind).max
    if not isinstance(array, np.ndarray):  # a color
        color = np.round(largest * np.clip(array, 0.0, 1.0)).astype(kind)
        array = np.broadcast_to(color, (_PLAIN, _PLAIN, 3))
    elif array.dtype != kind:
        array = np.round(array * (largest / np.iinfo(array.dtype).max)).astype(kind)
    components = array.shape[2]
    color = array[..., :3] if components >= 3 else np.repeat(array[..., :1], 3, axis=2)
    if not alpha:
        return color
    opaque = np.full((*array.shape[:2], 1), largest, dtype=kind)
    return np.concatenate([color, array[..., -1:] if components in (2, 4) else opaque], axis=2)


def _packed(path, tiles):
    """An array [H, W, C] with all tiles, in rows from the highest to the lowest tile, and the corner (x, y) of each."""
    sizes = [(tile.shape[1] + 2 * _MARGIN, tile.shape[0] + 2 * _MARGIN) for tile in tiles]
    area = sum(width * height for width, height in sizes)
    most = max(max(width for width, _ in sizes), int(np.ceil(np.sqrt(area))))
    places, x, y, height, widest = [None] * len(tiles), 0, 0, 0, 0
    for number in sorted(range(len(tiles)), key=lambda k: (-sizes[k][1], -sizes[k][0], k)):
        if x + sizes[number][0] > most:
            x, y, height = 0, y + height, 0
        places[number] = (x + _MARGIN, y + _MARGIN)
        x, height = x + sizes[number][0], max(height, sizes[number][1])
        widest = max(widest, x)
    if max(widest, y + height) > LARGEST_SIDE or widest * (y + height) > MOST_TEXELS:
        raise FormatError(
            f"{path}: the {len(tiles)} textures make an image of {widest} x {y + height} texels; at most {LARGEST_SIDE} along "
            f"a side and {MOST_TEXELS} in all are possible"
        )
    atlas = np.zeros((y + height, widest, tiles[0].shape[2]), dtype=tiles[0].dtype)
    for tile, (x, y) in zip(tiles, places):
        rows, columns = tile.shape[:2]
        padded = np.pad(tile, ((_MARGIN, _MARGIN), (_MARGIN, _MARGIN), (0, 0)), mode="edge")
        atlas[y - _MARGIN : y + rows + _MARGIN, x - _MARGIN : x + columns + _MARGIN] = padded
    return atlas, places


def _with_coordinates(mesh, tile_of_corner, coordinates):
    """The vtkPolyData of a PolygonMesh whose points with several tiles are doubled."""
    pairs, first, inverse = np.unique(
        np.column_stack([mesh.connectivity, tile_of_corner]), axis=0, return_index=True, return_inverse=True
    )
    inverse = inverse.reshape(-1)
    again = np.concatenate([[False], pairs[1:, 0] == pairs[:-1, 0]])
    ids = np.where(again, len(mesh.points) + np.cumsum(again) - 1, pairs[:, 0])
    sources = np.concatenate([np.arange(len(mesh.points)), pairs[again, 0]])
    arrays = {name: values[sources] for name, values in mesh.arrays.items()}
    arrays["TCoords"] = np.zeros((len(sources), 2))
    arrays["TCoords"][ids] = coordinates[first]
    return to_polydata(mesh._replace(points=mesh.points[sources], connectivity=ids[inverse], arrays=arrays))


def _image_of(texels):
    image = vtkImageData()
    image.SetDimensions(texels.shape[1], texels.shape[0], 1)
    scalars = numpy_to_vtk(np.ascontiguousarray(texels.reshape(-1, texels.shape[2])), deep=True)
    scalars.SetName("Texture")
    image.GetPointData().SetScalars(scalars)
    return image
