#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Measures how far eyes, teeth and tongue leave their places in samples of a model of bodies.

    python3 component_offsets.py FOLDER [--model body_poses] [--samples 100] [--csv FILE]

FOLDER is that of make_bodies.py; body_with_eyes.vtp there has components of its own for these parts. They share no point with the
body, and follow it by the coupling of components (``component_coupling`` of deform()). The place of a component is the part of
the body within 0.01 times the square root of the area of it, and at least the nearest 30 points. The offset of a component in a shape
is the distance of its center from where the best rigid motion of its place takes it; its distortion is the root mean square
distance of its points from where that motion and the offset take them. Both are in per cent of the square root of the area of the
whole surface.

A row each for samples of the model and for the poses of the package, which skin() makes by dual quaternions.
"""

import argparse
import csv
import glob
import os

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

import surfacesynthesis
from body_space import Pose, Skeleton, Skin, generated, weights_of
from compare_noise import print_table, write_csv
from linear_velocity import point_masses
from make_bodies import arrays_of
from sample_spaces import closest_rotations

#: Largest distance of the place of a component from it over the square root of the area, and the least number of its points.
PLACE, PLACE_POINTS = 0.01, 30


def components(points, triangles):
    """Numbers of the points of each component, the largest one first; points that no triangle uses are in none."""
    pairs = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]]])
    _, parts = connected_components(coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(points),) * 2), directed=False)
    used = np.unique(parts[triangles])
    return sorted((np.flatnonzero(parts == part) for part in used), key=len, reverse=True)


class Place:
    """A component of a surface and the part of the largest one that it lies in. Of both the numbers of their points."""

    def __init__(self, points, component, body, size):
        self._component, self._rest = component, points[component]
        distances = cKDTree(self._rest).query(points[body])[0]
        inside = max(np.count_nonzero(distances < PLACE * size), PLACE_POINTS)
        self._around = body[np.argsort(distances)[:inside]]
        self._place = points[self._around]

    def offsets(self, shapes):
        """Offset and distortion of the component in shapes [N, V, 3], each [N]."""
        places = shapes[:, self._around]
        middle, middles = self._place.mean(axis=0), places.mean(axis=1, keepdims=True)
        turns = closest_rotations(np.einsum("npa,pb->nab", places - middles, self._place - middle))
        expected = np.einsum("nab,pb->npa", turns, self._rest - middle) + middles
        seen = shapes[:, self._component]
        shifts = (seen - expected).mean(axis=1, keepdims=True)
        distortions = np.sqrt(np.sum((seen - expected - shifts) ** 2, axis=2).mean(axis=1))
        return np.linalg.norm(shifts[:, 0], axis=1), distortions


def package_poses(folder, skeleton):
    """The poses that make_bodies.py has written as tables."""
    numbers = {name: k for k, name in enumerate(skeleton.names)}
    for path in sorted(glob.glob(os.path.join(folder, "*.csv"))):
        with open(path, newline="", encoding="utf-8") as file:
            table = csv.DictReader(file)
            if "Rotation:0" not in (table.fieldnames or []):
                continue
            rotations = np.tile(np.eye(4)[0], (len(numbers), 1))
            for row in table:
                rotations[numbers[row["Name"]]] = [float(row[f"Rotation:{k}"]) for k in range(4)]
            yield Pose(rotations, np.zeros(3))


def row_of(name, places, shapes, size):
    offsets, distortions = (100.0 * np.array(values) / size for values in zip(*(place.offsets(shapes) for place in places)))
    return {
        "shapes": name,
        "number": len(shapes),
        "components": len(places),
        "offset": offsets.mean(),
        "percentile_99": np.percentile(offsets, 99),
        "largest": offsets.max(),
        "distortion": distortions.mean(),
        "largest_distortion": distortions.max(),
    }


def parsed(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", metavar="FOLDER", help="the folder of make_bodies.py")
    parser.add_argument("--model", default="body_poses", metavar="FILE", help="a model of bodies (default: body_poses)")
    parser.add_argument("--surface", metavar="FILE", help="with components and weights of bones (default: body_with_eyes.vtp)")
    parser.add_argument("--samples", type=int, default=100, metavar="N", help="of the model (default: 100)")
    parser.add_argument("--steps", type=int, default=10, metavar="N", help="of the flow (default: 10)")
    parser.add_argument("--corrections", type=int, metavar="N", help="of each sample (default: what suits the model)")
    parser.add_argument("--temperature", type=float, default=1.0, metavar="X", help="factor of the noise (default: 1)")
    parser.add_argument("--coupling-distance", type=float, metavar="X", help="of deform() (default: its own)")
    parser.add_argument("--seed", type=int, default=1, help="default: 1")
    parser.add_argument("--csv", metavar="FILE", help="write the table")
    return parser.parse_args(arguments)


def main(arguments=None):
    options = parsed(arguments)
    skeleton = Skeleton.read(os.path.join(options.folder, "bones.csv"))
    surface = surfacesynthesis.read_mesh(options.surface or os.path.join(options.folder, "body_with_eyes.vtp"))
    points, triangles = arrays_of(surface)
    body, *others = components(points, triangles)
    if not others:
        raise SystemExit("the surface has one component: there is nothing in a place")
    size = np.sqrt(point_masses(points, triangles).sum())
    places = [Place(points, component, body, size) for component in others]
    skin = Skin(points, *weights_of(surface), skeleton, np.arange(len(skeleton.names)))
    poses = np.array([skin.posed(pose) for pose in package_poses(options.folder, skeleton)])
    if not len(poses):
        raise SystemExit(f"{options.folder} has no table of a pose, as make_bodies.py writes them")
    coupling = {"component_coupling": True, "coupling_distance": options.coupling_distance}
    samples = generated(options, (points, triangles), options.samples, **coupling)
    rows = [row_of("poses of the package", places, poses, size), row_of("samples", places, samples, size)]
    heads = ("shapes", "number", "components", "offset, %", "99th percentile", "largest", "distortion, %", "largest")
    keys = ("offset", "percentile_99", "largest", "distortion", "largest_distortion")
    print_table(heads, [[row["shapes"], str(row["number"]), str(row["components"]), *(f"{row[key]:.2f}" for key in keys)] for row in rows])
    if options.csv:
        write_csv(rows, options.csv)
    return rows


if __name__ == "__main__":
    main()
