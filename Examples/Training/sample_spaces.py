# SPDX-License-Identifier: BSD-3-Clause
"""Distances of generated samples from the two families that the examples train on: poses and mixtures of Gaussians.

PoseSpace fits a pose to a shape in the manner of surfacesynthesis.poses(): the best rigid motion of each limb's end, found
from the points there, moves that end, the middle of the body stays, and the rest follows as rigidly as possible with the
same energy. The residual is the distance of the shape from that pose. The ends may move rigidly in any way, also off their
joints: these poses are a few more than those of the dataset.

MixtureSpace fits a sum of Gaussians to a signal: one after the other, then each again while the others stay, out of many
Gaussians at random places.
"""

import copy

import numpy as np
from scipy.sparse import coo_matrix, diags
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu
from scipy.spatial import cKDTree

import surfacesynthesis
from linear_velocity import cotangent_weights, point_masses, triangle_areas

#: Changes of lengths below this, in units of the root of the area, are those of single precision.
RIGID = 2e-6
#: Points of an end that fix its motion.
FEWEST_OF_END = 6
#: Poses of a dataset in which the rigid parts are looked for.
POSES_LOOKED_AT = 20


def rigid_motions(rest, moved):
    """Rotations [N, 3, 3] and shifts [N, 3] that bring points [P, 3] closest to each of [N, P, 3]."""
    center, centers = rest.mean(axis=0), moved.mean(axis=1)
    rotations = closest_rotations(np.einsum("npa,pb->nab", moved - centers[:, None], rest - center))
    return rotations, centers - rotations @ center


def closest_rotations(matrices):
    """The rotations R with the largest trace of R^T A."""
    u, _, vt = np.linalg.svd(matrices)
    u[..., 2] *= np.sign(np.linalg.det(u @ vt))[..., None]
    return u @ vt


def moved_by(motions, points):
    """Points [P, 3] after each of N motions."""
    rotations, shifts = motions
    return np.einsum("nab,pb->npa", rotations, points) + shifts[:, None]


class PoseSpace:
    """Poses of a surface, a pair (points, triangles). ``poses`` [N, V, 3] are some of the family, in the place of the
    surface: what stays in all of them is the middle, and what moves rigidly in all of them are the ends, of which ``middle``
    and ``ends`` hold the numbers of their points.

    Raises ValueError where nothing stays, or nothing else moves rigidly.
    """

    def __init__(self, mesh, poses, iterations=40, stiffness=2e-4):
        points, triangles = mesh
        self._rest = points.astype(float)
        self._points = np.arange(len(points))  # those that shapes are known at
        self._masses = point_masses(points, triangles)
        self._size = np.sqrt(self._masses.sum())
        self._iterations = iterations
        poses = np.asarray(poses[:POSES_LOOKED_AT], dtype=float)
        self._find_parts(triangles, poses)
        self._prepare(triangles, stiffness)

    def _find_parts(self, triangles, poses):
        """Points of the middle and of each end: connected triangles whose edges keep their lengths."""
        stays = np.linalg.norm(poses - self._rest, axis=2).max(axis=0) <= RIGID * self._size
        kept = np.ones(len(triangles), dtype=bool)
        for i, j in ((0, 1), (1, 2), (2, 0)):
            first, second = triangles[:, i], triangles[:, j]
            lengths = np.linalg.norm(self._rest[first] - self._rest[second], axis=1)
            for pose in poses:
                changes = np.abs(np.linalg.norm(pose[first] - pose[second], axis=1) - lengths)
                kept &= changes <= RIGID * self._size
        moved = triangles[kept & ~stays[triangles].any(axis=1)]
        pairs = np.concatenate([moved[:, [0, 1]], moved[:, [1, 2]]])
        count = len(self._rest)
        _, parts = connected_components(coo_matrix((np.ones(len(pairs)), pairs.T), shape=(count, count)), directed=False)
        self.middle = np.flatnonzero(stays)
        self.ends = [np.flatnonzero(parts == part) for part in np.unique(parts[moved.ravel()])]
        if not len(self.middle) or not self.ends:
            raise ValueError("these poses have no middle that stays, or no ends that move rigidly")
        self._known_middle, self._known_ends = self.middle, self.ends

    def _prepare(self, triangles, smoothness):
        """Matrices of the deformation [Levi2015]: means of the rotations of neighbors, and the Laplacian of free points."""
        count = len(self._rest)
        edges, weights = cotangent_weights(self._rest, triangles)
        weights = np.maximum(weights, 0.0)
        both = np.concatenate([edges, edges[:, ::-1]])
        matrix = coo_matrix((np.tile(weights, 2), both.T), shape=(count, count)).tocsr()
        ones = matrix.copy()
        ones.data[:] = 1.0
        self._mean = (smoothness * triangle_areas(self._rest, triangles).sum()) * (
            diags(1.0 / np.maximum(ones.sum(axis=1).A1, 1.0)) @ ones
        )
        self._adjacency = matrix
        self._laplacian = (diags(matrix.sum(axis=1).A1) - matrix).tocsr()
        self._hold(np.concatenate([self.middle, *self.ends]))

    def _hold(self, held):
        self._held = held
        self._free = np.setdiff1d(np.arange(len(self._rest)), held)
        self._to_held = self._laplacian[self._free][:, held]
        self._solver = splu(self._laplacian[self._free][:, self._free].tocsc())

    def seen_at(self, points):
        """The same space for shapes of which only these points are known, such as those of a damaged triangulation: the motion
        of an end is found from those of them that are its own; ends with fewer than FEWEST_OF_END follow the rest, so that
        poses themselves have a residual, too. Unknown points of a shape are placed like the nearest known ones at rest."""
        seen = copy.copy(self)
        seen._points = np.asarray(points)
        seen.ends = [end for end in self.ends if len(np.intersect1d(end, points)) >= FEWEST_OF_END]
        seen._known_ends = [np.intersect1d(end, points) for end in seen.ends]
        seen._known_middle = np.intersect1d(self.middle, points)
        if not len(seen._known_middle):
            raise ValueError("the points have none of the middle, which poses are placed by")
        seen._hold(np.concatenate([seen.middle, *seen.ends]))
        return seen

    def fitted(self, shape):
        """The pose that is fitted to a shape [V, 3], in the place of the surface."""
        known = self._known_middle
        shape = shape - (shape[known] - self._rest[known]).mean(axis=0)
        pose = shape.copy()
        for end, part in zip(self.ends, self._known_ends):
            motions = rigid_motions(self._rest[part], shape[None, part])
            pose[end] = moved_by(motions, self._rest[end])[0]
        pose[self.middle] = self._rest[self.middle]
        rotations = np.tile(np.eye(3), (len(pose), 1, 1))
        for _ in range(self._iterations):
            near = (self._mean @ rotations.reshape(-1, 9)).reshape(-1, 3, 3)
            rotations = closest_rotations(self._covariances(pose) + near)
            right = self._right_hand_side(rotations)[self._free] - self._to_held @ pose[self._held]
            pose[self._free] = self._solver.solve(right)
        return pose

    def _covariances(self, pose):
        """sum_j w_ij (q_i - q_j) (p_i - p_j)^T, with p the surface and q the pose."""
        products = np.einsum("va,vb->vab", pose, self._rest).reshape(-1, 9)
        total = self._adjacency.sum(axis=1).A1
        near_rest, near_pose = self._adjacency @ self._rest, self._adjacency @ pose
        cross = np.einsum("va,vb->vab", pose, near_rest) + np.einsum("va,vb->vab", near_pose, self._rest)
        return (total[:, None] * products + self._adjacency @ products).reshape(-1, 3, 3) - cross

    def _right_hand_side(self, rotations):
        """sum_j w_ij (R_i + R_j) / 2 (p_i - p_j)."""
        own = np.einsum("vab,vb->va", rotations, self._laplacian @ self._rest)
        near = (self._adjacency @ rotations.reshape(-1, 9)).reshape(-1, 3, 3)
        moved = np.einsum("vab,vb->va", rotations, self._rest)
        return 0.5 * (own + np.einsum("vab,vb->va", near, self._rest) - self._adjacency @ moved)

    def residuals(self, shapes):
        """The root mean square distances of shapes [N, V, 3], or [N, P, 3] of the points of seen_at(), from their poses, up
        to translation, in units of the root of the area of the surface."""
        nearest = cKDTree(self._rest[self._points]).query(self._rest)[1]
        masses = self._masses[self._points] / self._masses[self._points].sum()
        found = []
        for shape in np.asarray(shapes, dtype=float):
            whole = self._rest + (shape - self._rest[self._points])[nearest]
            away = self.fitted(whole)[self._points] - shape
            away -= masses @ away
            found.append(np.sqrt(masses @ (away**2).sum(axis=1)) / self._size)
        return np.array(found)


class MixtureSpace:
    """Sums of three Gaussians on a surface, a pair (points, triangles), as surfacesynthesis.gaussian_mixtures() makes them.
    Candidates are ``atoms`` Gaussians at random points."""

    def __init__(self, mesh, atoms, gaussians=3):
        masses = point_masses(*mesh)
        self._root = np.sqrt(masses / masses.sum())
        self._gaussians = gaussians
        self._atoms = (surfacesynthesis.gaussian_mixtures(mesh, atoms, centers=1) * self._root).astype(np.float32)
        self._squares = (self._atoms**2).sum(axis=1)

    def residuals(self, signals):
        """The root mean square differences of signals [N, V] or [N, V, 1] from the fitted sums."""
        signals = (np.asarray(signals).reshape(len(signals), -1) * self._root).astype(np.float32)
        chosen = np.zeros((self._gaussians, *signals.shape), dtype=np.float32)
        for turn in range(3 * self._gaussians):
            chosen[turn % self._gaussians] = 0.0
            rest = signals - chosen.sum(axis=0)
            chosen[turn % self._gaussians] = self._atoms[np.argmin(self._squares - 2.0 * rest @ self._atoms.T, axis=1)]
        return np.sqrt(((signals - chosen.sum(axis=0)) ** 2).sum(axis=1))
