# SPDX-License-Identifier: BSD-3-Clause
"""Values at the corners of polygons, as OBJ and PLY have texture coordinates and normals, as values of points."""

import warnings

import numpy as np

from ..errors import SurfaceSynthesisWarning

#: What becomes of points with several texture coordinates: one point with the first of them, or one point for each.
SEAMS = ("join", "split")


def with_texture(path, mesh, values, present, seams):
    """The PolygonMesh with the point array "TCoords" [V, 2], from ``values`` [C, 2] of the corners where ``present`` [C]
    is true; 0 at points without. Points with several values are one point with the first (seams="join"), with a warning; or
    one point for each, the new ones last (seams="split")."""
    values = np.where(present[:, None], values, 0.0)
    first = first_corners(mesh, present)
    at_points = np.where((first >= 0)[:, None], values[first] if len(values) else 0.0, 0.0)
    other = np.flatnonzero(present & (values != at_points[mesh.connectivity]).any(axis=1))
    ids = mesh.connectivity[other]
    if seams == "join" or len(other) == 0:
        if len(other):
            warnings.warn(
                f"{path}: {len(np.unique(ids)):,} of {len(mesh.points):,} points lie on seams of the texture; of their "
                "texture coordinates the first is kept (read_mesh(path, seams='split') makes a point for each)",
                SurfaceSynthesisWarning,
                stacklevel=5,
            )
        return mesh._replace(arrays={**mesh.arrays, "TCoords": at_points})
    pairs, inverse = np.unique(np.column_stack([ids, values[other]]), axis=0, return_inverse=True)
    sources = pairs[:, 0].astype(np.int64)
    connectivity = mesh.connectivity.copy()
    connectivity[other] = len(mesh.points) + inverse.reshape(-1)
    arrays = {name: np.concatenate([array, array[sources]]) for name, array in mesh.arrays.items()}
    arrays["TCoords"] = np.concatenate([at_points, pairs[:, 1:]])
    points = np.concatenate([mesh.points, mesh.points[sources]])
    return mesh._replace(points=points, connectivity=connectivity, arrays=arrays)


def with_normals(mesh, values, present):
    """The PolygonMesh with the point array "Normals" [V, 3]: the mean of the normals at the corners of a point, made
    unit; 0 at points without."""
    sums = np.zeros((len(mesh.points), 3))
    for axis in range(3):
        weights = np.where(present, values[:, axis], 0.0)
        sums[:, axis] = np.bincount(mesh.connectivity, weights, minlength=len(sums))
    length = np.linalg.norm(sums, axis=1, keepdims=True)
    normals = np.divide(sums, length, out=np.zeros_like(sums), where=length > 0)
    return mesh._replace(arrays={**mesh.arrays, "Normals": normals})


def first_corners(mesh, present):
    """The first corner of each point where ``present`` is true; -1 without."""
    first = np.full(len(mesh.points), -1, dtype=np.int64)
    corners = np.flatnonzero(present)[::-1]
    first[mesh.connectivity[corners]] = corners
    return first
