#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Measures whether relief survives a model of poses: the angles between neighboring normals of samples, over those of the
source, away from joints.

    python3 relief.py [--model FILE] [--faces 5000 52000 832000] [--samples 3]

The armadillo of Debian's package libcgal-demo is deformed on triangulations of several sizes: simplified, its own, and cut
finer. Normals are smoothed over one length on all of them, 0.01 of the root of the area, by one step of heat flow on the
source. Away from joints is the half of the surface that bends least in poses of the data (surfacesynthesis.poses()). Prints
the quantiles of the angles of all samples, over those of the source, in a table in Markdown; 1 is best.
"""

import argparse
import os
import sys

import numpy as np
from scipy.sparse import coo_matrix, diags
from scipy.sparse.linalg import cg
from vtkmodules.vtkFiltersModeling import vtkLinearSubdivisionFilter

import surfacesynthesis
from carrying import carried
from linear_velocity import cotangent_weights, point_masses
from make_datasets import points_and_triangles, simplified, surface
from sample_spaces import closest_rotations

MODEL = os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, "Models", "armadillo_poses.safetensors")
#: Length over which normals are smoothed, in units of the root of the area.
LENGTH = 0.01
QUANTILES = (0.1, 0.25, 0.5, 0.75, 0.9)
#: Points of the surface on which bending is measured, and the number of poses.
BENDING = (642, 20)


def with_faces(original, faces):
    """The surface with about so many triangles: simplified, or each triangle cut into four, once or more."""
    if faces < 0.9 * original.GetNumberOfCells():
        return simplified(original, faces // 2)
    divisions = max(0, round(np.log(faces / original.GetNumberOfCells()) / np.log(4.0)))
    if not divisions:
        return original
    finer = vtkLinearSubdivisionFilter()
    finer.SetInputData(original)
    finer.SetNumberOfSubdivisions(divisions)
    finer.Update()
    return finer.GetOutput()


def unique_edges(triangles):
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    return np.unique(np.sort(edges, axis=1), axis=0).T


def bending(original):
    """Triangulation with few points, and how fast poses turn there: the root mean square, over poses and edges of a point, of
    the difference of rotations at the ends of an edge over its length, [V]."""
    mesh = simplified(original, BENDING[0])
    poses = surfacesynthesis.poses(mesh, BENDING[1], template=original).astype(float)
    points, triangles = points_and_triangles(mesh)
    first, second = unique_edges(triangles)
    both = np.concatenate([first, second]), np.concatenate([second, first])
    sums = np.zeros(len(points))
    lengths = np.linalg.norm(points[first] - points[second], axis=1)
    for pose in poses:
        products = np.einsum("ea,eb->eab", pose[both[1]] - pose[both[0]], points[both[1]] - points[both[0]])
        covariances = np.zeros((len(points), 3, 3))
        np.add.at(covariances, both[0], products)
        rotations = closest_rotations(covariances)
        turns = ((rotations[first] - rotations[second]) ** 2).sum(axis=(1, 2)) / lengths**2
        sums += np.bincount(first, turns, len(points)) + np.bincount(second, turns, len(points))
    degrees = np.bincount(np.concatenate(both), minlength=len(points)) / 2.0
    return (points, triangles), np.sqrt(sums / degrees / len(poses))


class Relief:
    """Angles between smoothed normals at the ends of the edges of a surface that are away from joints."""

    def __init__(self, mesh, bent):
        self._points, self._triangles = points_and_triangles(mesh)
        masses = point_masses(self._points, self._triangles)
        edges, weights = cotangent_weights(self._points, self._triangles)
        count = len(self._points)
        matrix = coo_matrix((weights, edges.T), shape=(count, count)).tocsr()
        matrix = matrix + matrix.T
        stiffness = diags(np.asarray(matrix.sum(axis=1)).ravel()) - matrix
        self._masses = masses
        self._system = (diags(masses) + LENGTH**2 * masses.sum() * stiffness).tocsr()
        self._jacobi = diags(1.0 / self._system.diagonal())
        (coarse, values) = bent
        found = carried(values[None, :, None], coarse, self._points)[0, :, 0]
        order = np.argsort(found)
        half = np.searchsorted(np.cumsum(masses[order]), 0.5 * masses.sum())
        near = np.zeros(count, dtype=bool)
        near[order[:half]] = True
        first, second = unique_edges(self._triangles)
        self._edges = np.stack([first, second])[:, near[first] & near[second]]

    def angles(self, points):
        a, b, c = (points[self._triangles[:, k]].astype(float) for k in range(3))
        areas, normals = np.cross(b - a, c - a), np.zeros((len(points), 3))
        for k in range(3):
            for axis in range(3):
                normals[:, axis] += np.bincount(self._triangles[:, k], areas[:, axis], len(points))
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        for axis in range(3):
            right = self._masses * normals[:, axis]
            normals[:, axis], failed = cg(self._system, right, x0=normals[:, axis], M=self._jacobi, tol=1e-6)
            if failed:
                raise RuntimeError("the smoothing of the normals did not converge")
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        first, second = normals[self._edges[0]], normals[self._edges[1]]
        return 2.0 * np.arcsin(np.minimum(0.5 * np.linalg.norm(first - second, axis=1), 1.0))


def parsed(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--model", default=MODEL, metavar="FILE", help="a model of poses (default: the one of the examples)")
    parser.add_argument("--surface", metavar="FILE", help="a surface in place of the armadillo")
    parser.add_argument("--faces", type=int, nargs="+", default=[5000, 52000, 832000], metavar="N",
                        help="sizes of triangulations (default: 5000 52000 832000)")  # fmt: skip
    parser.add_argument("--samples", type=int, default=3, help="default: 3")
    parser.add_argument("--steps", type=int, default=20, help="of the flow (default: 20)")
    parser.add_argument("--corrections", type=int, metavar="N", help="of each sample (default: what suits the model)")
    parser.add_argument("--seed", type=int, default=1, help="default: 1")
    return parser.parse_args(arguments)


def main(arguments=None):
    options = parsed(arguments)
    original = surface(options.surface, "armadillo.off")
    bent = bending(original)
    print("| faces | {} |".format(" | ".join(f"{100 * q:.0f} %" for q in QUANTILES)))
    print("|{}".format("---:|" * (1 + len(QUANTILES))), flush=True)
    for faces in options.faces:
        mesh = with_faces(original, faces)
        relief, pair = Relief(mesh, bent), points_and_triangles(mesh)
        samples = surfacesynthesis.deform(
            pair, options.model, seed=options.seed, samples=options.samples, steps=options.steps, corrections=options.corrections
        )
        found = np.quantile(np.concatenate([relief.angles(sample) for sample in samples]), QUANTILES)
        ratios = found / np.quantile(relief.angles(pair[0]), QUANTILES)
        print("| {:,} | {} |".format(len(pair[1]), " | ".join(f"{ratio:.3f}" for ratio in ratios)), flush=True)


if __name__ == "__main__":
    sys.exit(main())
