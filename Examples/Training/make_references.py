#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Makes what the example geometric textures are learnt from: balls with a displacement, as meshes at several scales.

    python3 make_references.py OUTPUT [--only NAME ...] [--surfaces SURFACE ...]

Writes NAME_0.ply to NAME_3.ply, of 320, 1280, 5120 and 20480 triangles, for each of

    spikes      cones on a bare ground
    labyrinth   walls and trenches that wind: a random spherical harmonic, cut off above and below
    knobs       mushrooms, wider above than at the neck: points are moved along the surface as well as off it

With --surfaces torus or saddle, spikes and knobs on those, as NAME_SURFACE_0.ply and so on: triangles and features are as
large as those of the ball, and areas about the same.

Here the shape is known, and each level is that shape, smoothed over the length of the level's edges. For a surface that
is only given as a mesh, vtkMultiscaleMeshFitter makes the levels.
"""

import argparse
import functools
import os
import sys

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkFiltersSources import vtkPlatonicSolidSource

import surfacesynthesis

LEVELS = 4
#: The displacement is made on this many levels more, so that also the finest level is smoothed.
FINER = 2
#: Steps of smoothing for each level, times the square of the length of its edges over that of the finest ones.
SMOOTHING = 0.25
#: A meridian of a mushroom, from the ground to the top: distance from its axis and height, in radii of the ball.
MUSHROOM = (
    (0.21, 0.0),
    (0.16, 0.02),
    (0.11, 0.07),
    (0.10, 0.13),
    (0.145, 0.18),
    (0.14, 0.235),
    (0.08, 0.27),
    (0.0, 0.28),
)


def balls(levels):
    """The unit sphere as meshes of 320, 1280, 5120, ... triangles, each with the points of the one before and others."""
    copies = [vtkPolyData() for _ in range(levels)]
    for copy, ball in zip(copies, _balls(levels)):
        copy.DeepCopy(ball)
    return copies


@functools.lru_cache(maxsize=2)
def _balls(levels):
    solid = vtkPlatonicSolidSource()
    solid.SetSolidTypeToIcosahedron()
    solid.Update()
    return surfacesynthesis.fit_levels(solid.GetOutput(), levels=levels, icosphere_level=2, iterations=0).levels


def directions(mesh):
    """The points of a ball [V, 3], of length 1."""
    points = vtk_to_numpy(mesh.GetPoints().GetData()).astype(float)
    return points / np.linalg.norm(points, axis=1, keepdims=True)


def random_directions(count, generator):
    found = generator.normal(size=(count, 3))
    return found / np.linalg.norm(found, axis=1, keepdims=True)


def scattered(count, generator):
    """Directions [N, 3] that keep a distance from each other: random ones, moved to the middle of what is closest to each."""
    found = random_directions(count, generator)
    samples = random_directions(200 * count, generator)
    for _ in range(8):
        nearest = (samples @ found.T).argmax(axis=1)
        found = np.stack([samples[nearest == k].sum(axis=0) for k in range(count)])
        found /= np.linalg.norm(found, axis=1, keepdims=True)
    return found


def closest(points, centers):
    """The closest centre of each point [V, 3] and the angle to it [V]."""
    cosines = points @ centers.T
    return centers[cosines.argmax(axis=1)], np.arccos(np.clip(cosines.max(axis=1), -1.0, 1.0))


#: Radii of the torus and half the width of the saddle, in radii of the ball.
TORUS = (0.9, 0.4)
SADDLE = 1.75
#: Points of level 0, as many in an area as on the ball.
COARSE_POINTS = {"torus": 181, "saddle": 178}


def on_torus(points):
    """The closest points of the torus, and their normals, [V, 3] each."""
    ring = points * (1.0, 1.0, 0.0)
    ring *= TORUS[0] / np.linalg.norm(ring, axis=1, keepdims=True)
    normals = (points - ring) / np.linalg.norm(points - ring, axis=1, keepdims=True)
    return ring + TORUS[1] * normals, normals


def on_saddle(points):
    """The points of the saddle above or below, and their normals, [V, 3] each."""
    x, y = points[:, 0], points[:, 1]
    normals = np.stack([-x / SADDLE, y / SADDLE, np.ones(len(points))], axis=1)
    moved = np.stack([x, y, 0.5 * (x * x - y * y) / SADDLE], axis=1)
    return moved, normals / np.linalg.norm(normals, axis=1, keepdims=True)


#: The surfaces beside the ball, as functions of points near them.
SURFACES = {"torus": on_torus, "saddle": on_saddle}


def torus(radius, tube):
    """A torus around the z axis as a function of two coordinates from -1 to 1, around the axis and around the tube."""

    def place(u, v):
        away = radius + tube * np.cos(np.pi * v)
        return away * np.cos(np.pi * u), away * np.sin(np.pi * u), tube * np.sin(np.pi * v)

    return place


#: The same as functions of two coordinates from -1 to 1, and whether they close in both.
GRIDS = {
    "torus": (torus(*TORUS), True),
    "saddle": (lambda u, v: (SADDLE * u, SADDLE * v, 0.5 * SADDLE * (u * u - v * v)), False),
}


def grid(place, closed, count=121):
    """The corners [N, 3] and triangles [F, 3] of a fine mesh of a surface, a function of two coordinates from -1 to 1; a
    closed one closes in both of them."""
    steps = np.linspace(-1.0, 1.0, count)[: count - closed]
    corners = np.stack(place(*np.meshgrid(steps, steps, indexing="ij")), axis=-1).reshape(-1, 3)
    numbers = np.arange(len(corners)).reshape(len(steps), -1)
    if closed:
        numbers = np.pad(numbers, (0, 1), mode="wrap")
    a, b, c, d = (part.ravel() for part in (numbers[:-1, :-1], numbers[1:, :-1], numbers[1:, 1:], numbers[:-1, 1:]))
    return corners, np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


def scattered_on(points, count, generator):
    """Ids [N] of points that keep a distance from each other, as scattered()."""
    found = points[generator.choice(len(points), count, replace=False)]
    for _ in range(8):
        nearest = closest_of(points, found)
        found = np.stack([points[nearest == k].mean(axis=0) if (nearest == k).any() else found[k] for k in range(count)])
    return closest_of(found, points)


def closest_of(points, centers):
    """The number of the closest center of each point [V]."""
    squares = (centers**2).sum(axis=1)
    parts = np.array_split(points, max(1, len(points) * len(centers) // 10**7))
    return np.concatenate([(squares - 2.0 * part @ centers.T).argmin(axis=1) for part in parts])


def displaced(name, points, normals, area, generator):
    """Points [V, 3] of a surface of that area with spikes or knobs, as the displacements of the ball below."""
    count = round({"spikes": 90, "knobs": 60}[name] * area / (4.0 * np.pi))
    centers = points[scattered_on(points, count, generator)]
    away = points - centers[closest_of(points, centers)]
    distance = np.linalg.norm(away, axis=1, keepdims=True)
    if name == "spikes":
        return points + 0.26 * np.clip(1.0 - distance / 0.17, 0.0, None) ** 1.3 * normals
    width = MUSHROOM[0][0]
    radius, height = meridian(np.clip(distance[:, 0] / width, 0.0, 1.0))
    outwards = away - (away * normals).sum(axis=1, keepdims=True) * normals
    outwards /= np.maximum(np.linalg.norm(outwards, axis=1, keepdims=True), 1e-12)
    inwards = np.where(distance < width, radius[:, None] - distance, 0.0)
    return points + inwards * outwards + height[:, None] * normals


def spikes(points, generator):
    _, angle = closest(points, scattered(90, generator))
    return points * (1.0 + 0.26 * np.clip(1.0 - angle / 0.17, 0.0, None) ** 1.3)[:, None]


def labyrinth(points, generator, degree=17, poles=300):
    """A random combination of spherical harmonics of one degree is a sum of Legendre polynomials around random poles."""
    legendre = np.zeros(degree + 1)
    legendre[degree] = 1.0
    field = np.zeros(len(points))
    for pole, weight in zip(random_directions(poles, generator), generator.normal(size=poles)):
        field += weight * np.polynomial.legendre.legval(points @ pole, legendre)
    return points * (1.0 + 0.07 * np.tanh(2.0 * field / field.std()))[:, None]


def knobs(points, generator):
    axis, angle = closest(points, scattered(60, generator))
    width = MUSHROOM[0][0]
    radius, height = meridian(np.clip(angle / width, 0.0, 1.0))
    outwards = points - (points * axis).sum(axis=1, keepdims=True) * axis
    outwards /= np.maximum(np.linalg.norm(outwards, axis=1, keepdims=True), 1e-12)
    turned = np.where(angle < width, radius, angle)[:, None]
    return (np.cos(turned) * axis + np.sin(turned) * outwards) * (1.0 + height)[:, None]


def meridian(fraction):
    """Distance from the axis and height where a fraction of a mushroom's meridian is left to its top."""
    corners = np.array(MUSHROOM)
    for _ in range(3):  # rounds the corners
        cut = np.stack([0.75 * corners[:-1] + 0.25 * corners[1:], 0.25 * corners[:-1] + 0.75 * corners[1:]], axis=1)
        corners = np.concatenate([corners[:1], cut.reshape(-1, 2), corners[-1:]])
    corners = corners[::-1]
    left = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))])
    return (np.interp(fraction, left / left[-1], column) for column in corners.T)


#: Displacements as functions of the points of a ball [V, 3] and a generator of random numbers.
DISPLACEMENTS = {"spikes": spikes, "labyrinth": labyrinth, "knobs": knobs}


class Neighbors:
    """The edges of a closed mesh, to smooth values on its points."""

    def __init__(self, mesh):
        triangles = vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3)
        self._of, self._at = triangles.ravel(), np.roll(triangles, 1, axis=1).ravel()  # each edge once in each direction
        self._count = np.bincount(self._of)

    def smoothed(self, values, times):
        """Values [V, C] of which each has moved half of the way to the mean of its neighbours, as often as asked."""
        for _ in range(times):
            sums = [np.bincount(self._of, weights=column) for column in values[self._at].T]
            values = 0.5 * values + 0.5 * np.stack(sums, axis=1) / self._count[:, None]
        return values


def bare_levels(mesh, count):
    """A surface as it is without a texture, its triangles cut into four from level to level."""
    return surfacesynthesis.fit_levels(mesh, template=mesh, levels=count, iterations=0).levels


def surface_levels(surface, levels):
    """One of SURFACES as meshes, each with the points of the one before and others."""
    points = COARSE_POINTS[surface]
    return bare_levels(surfacesynthesis.remesh(grid(*GRIDS[surface]), points=points, feature_angle=None), levels)


def reference_levels(name, levels=LEVELS, seed=1, surface="ball"):
    """A displaced ball, or one of SURFACES, as meshes of 320, 1280, ... triangles, each smoothed over the length of its
    edges; the shipped texture was learnt from seed 1 of the ball."""
    generator = np.random.default_rng(seed)
    if surface == "ball":
        meshes = balls(levels + FINER)
        displacement = DISPLACEMENTS[name](directions(meshes[-1]), generator)
    else:
        meshes = surface_levels(surface, levels + FINER)
        points, normals = SURFACES[surface](vtk_to_numpy(meshes[-1].GetPoints().GetData()).astype(float))
        area = surfacesynthesis.topology_report(meshes[-1])["area"]
        displacement = displaced(name, points, normals, area, generator)
    fine = meshes[-1]
    neighbors = Neighbors(fine)
    done = 0
    for number in reversed(range(levels)):
        wanted = round(SMOOTHING * (4 ** (levels + FINER - 1 - number) - 1))
        displacement = neighbors.smoothed(displacement, wanted - done)
        done = wanted
        moved = np.ascontiguousarray(displacement[: meshes[number].GetNumberOfPoints()])
        meshes[number].GetPoints().SetData(numpy_to_vtk(moved, deep=True))
    return meshes[:levels]


def require_surfaces(parser, options):
    """Ends the program where a texture of ``options.only`` is not known on one of ``options.surfaces``."""
    if "labyrinth" in options.only and set(options.surfaces) != {"ball"}:
        parser.error("the labyrinth is a harmonic of the ball: --only spikes knobs, or --surfaces ball")


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("output", help="folder; made when it is not there")
    parser.add_argument("--only", nargs="+", choices=sorted(DISPLACEMENTS), default=sorted(DISPLACEMENTS))
    parser.add_argument("--surfaces", nargs="+", choices=["ball", *SURFACES], default=["ball"])
    options = parser.parse_args(arguments)
    require_surfaces(parser, options)
    os.makedirs(options.output, exist_ok=True)
    for name in options.only:
        for surface in options.surfaces:
            stem = name if surface == "ball" else f"{name}_{surface}"
            for number, mesh in enumerate(reference_levels(name, surface=surface)):
                surfacesynthesis.write_mesh(mesh, os.path.join(options.output, f"{stem}_{number}.ply"))
            print(f"wrote {options.output}/{stem}_*.ply", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
