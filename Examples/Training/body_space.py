#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Measures how far samples of a model of bodies are from the poses of the body, by fitting its skeleton.

    python3 body_space.py FOLDER --model FILE [--samples 100] [--faces 5000 200000] [--csv FILE]

FOLDER is that of make_bodies.py. RigSpace fits a pose to a shape: the rotations of all joints that poses of the package move,
of the root and its translation, by Gauss-Newton steps with Levenberg's damping on the squared distances of corresponding
points, through the dual quaternion skinning of surfacesynthesis.skin(). It begins with the best rotation of the points of
each bone. Joints may turn in any way: there are no joint limits, so that these poses are more than those of the dataset. The
distance of a shape is that from the fitted pose: root mean square over the area, in units of the root of the area.

Rows: poses kept for tests; the same seen through noise, a displacement of each point at random, normally distributed with the
root mean square length 0.01 in these units; and samples of the model, on triangulations with so many faces each: less than
those of the body are remeshed, more are made by splitting edges. COV and 1-NNA of samples and, beside them, of other poses of
the same number are those of ensemble_metrics() against the test poses. Stretch of the hands is the root mean square of the
logarithm of how much longer their edges are than those at rest, which is not 0 for poses, whose skin folds at the joints;
beside it stand that of the poses that are fitted to the shapes, and that of the shapes over these poses.
"""

import argparse
import copy
import csv
import functools
import glob
import os
import sys
import time

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse import bsr_matrix, csr_matrix
from scipy.spatial import cKDTree
from vtkmodules.util.numpy_support import vtk_to_numpy

import surfacesynthesis
from compare_noise import stretch, write_csv
from linear_velocity import point_masses
from make_bodies import arrays_of, quaternions_of, remeshed, with_weights_of
from sample_spaces import closest_rotations
from surfacesynthesis.files.polygons import mesh_of_triangles, to_polydata

#: Root mean square length of the noise, in units of the root of the area.
NOISE = 0.01
#: Most points that a skeleton is fitted to; the distance is that of all points.
FITTED_POINTS = 3000
#: Bones whose parts are the hands, with all that hangs on them.
WRISTS = ("wrist.L", "wrist.R")
#: Weight of a point that belongs to a bone, for the first rotations.
OWN = 0.5
#: Part of the parent's rotation in the first rotation of a bone.
TOWARDS_PARENT = 1e-3
#: Sine of half of the angle by which poses turn a joint at least.
LEAST_TURN = 1e-4
#: First damping, in units of the mean of the diagonal; least part by which a step must lower the squares; most steps.
DAMPING, LEAST_GAIN, MOST_STEPS = 1e-6, 1e-3, 30


class Skeleton:
    """Bones of a body: names, heads [B, 3] and parents [B], -1 for none."""

    def __init__(self, names, heads, parents):
        self.names, self.heads, self.parents = list(names), np.asarray(heads), np.asarray(parents)

    @classmethod
    def read(cls, path):
        """The bones of a file bones.csv."""
        with open(path, newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        heads = [[float(row[f"Head:{k}"]) for k in range(3)] for row in rows]
        return cls([row["Name"] for row in rows], heads, [int(row["Parent"]) for row in rows])

    def chains(self):
        """For each bone its number and those of all above it."""
        found = []
        for bone in range(len(self.names)):
            chain = [bone]
            while self.parents[chain[-1]] >= 0:
                chain.append(self.parents[chain[-1]])
            found.append(chain)
        return found


def product(a, b):
    """Products of quaternions w, x, y, z."""
    (s, t, u, v), (w, x, y, z) = (np.moveaxis(one, -1, 0) for one in (a, b))
    i, j, k = s * x + t * w + u * z - v * y, s * y - t * z + u * w + v * x, s * z + t * y - u * x + v * w
    return np.stack([s * w - t * x - u * y - v * z, i, j, k], axis=-1)


def conjugate(a):
    return a * np.array([1.0, -1.0, -1.0, -1.0])


def pure(vectors):
    return np.concatenate([np.zeros_like(vectors[..., :1]), vectors], axis=-1)


def turned(quaternions, vectors):
    return product(product(quaternions, pure(vectors)), conjugate(quaternions))[..., 1:]


def quaternion_of(matrix):
    """Quaternion of a rotation matrix, by the largest eigenvector of its form."""
    m = matrix
    form = np.array([
        [m[0, 0] + m[1, 1] + m[2, 2], m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]],
        [m[2, 1] - m[1, 2], m[0, 0] - m[1, 1] - m[2, 2], m[0, 1] + m[1, 0], m[0, 2] + m[2, 0]],
        [m[0, 2] - m[2, 0], m[0, 1] + m[1, 0], m[1, 1] - m[0, 0] - m[2, 2], m[1, 2] + m[2, 1]],
        [m[1, 0] - m[0, 1], m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], m[2, 2] - m[0, 0] - m[1, 1]],
    ])  # fmt: skip
    return np.linalg.eigh(form)[1][:, -1]


def crosses(vectors):
    """Matrices of cross products, [N, 3, 3]."""
    x, y, z = vectors.T
    zero = np.zeros_like(x)
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(-1, 3, 3)


class Pose:
    """Rotations of all bones relative to their parents, quaternions [B, 4], and the translation of the whole, [3]."""

    def __init__(self, rotations, translation):
        self.rotations, self.translation = rotations, translation


class Skin:
    """Points of a body at rest, with the bones that move them."""

    def __init__(self, points, indices, weights, skeleton, joints):
        self.points, self._skeleton, self.joints = points, skeleton, joints
        self._indices, self._weights = indices, weights / weights.sum(axis=1, keepdims=True)
        self._count = len(points)
        self._pivot = np.take_along_axis(indices, np.argmax(weights, axis=1)[:, None], axis=1)[:, 0]
        depths = np.array([len(chain) for chain in skeleton.chains()])
        self._levels = [np.flatnonzero(depths == depth) for depth in range(1, depths.max() + 1)]

    @functools.cached_property
    def _pairs(self):
        """Points and joints of the pairs of both of which one moves the other, by points; the first pair of each point; and the
        matrix that sums up the bones of each pair."""
        chains = self._skeleton.chains()
        numbers = np.full(len(chains), -1)
        numbers[self.joints] = np.arange(len(self.joints))
        above = [numbers[chain][numbers[chain] >= 0] for chain in chains]
        lengths = np.array([len(chain) for chain in above])[self._indices] * (self._weights > 0.0)
        entries = np.repeat(np.arange(self._indices.size), lengths.ravel())
        joints = np.concatenate([above[bone] for bone in self._indices.ravel()[lengths.ravel() > 0]])
        keys, pairs = np.unique(entries // self._indices.shape[1] * len(self.joints) + joints, return_inverse=True)
        shape = len(keys), self._indices.size
        sum_up = csr_matrix((np.ones(len(entries)), (pairs, entries)), shape=shape)
        points = keys // len(self.joints)
        return points, keys % len(self.joints), np.searchsorted(points, np.arange(self._count + 1)), sum_up

    @functools.cached_property
    def _own(self):
        """Points that belong to each joint."""
        return {joint: np.flatnonzero((self._weights * (self._indices == joint)).sum(axis=1) > OWN) for joint in self.joints}

    def motions(self, pose):
        """Rotations [B, 4] and translations [B, 3] of the bones."""
        heads, parents = self._skeleton.heads, self._skeleton.parents
        rotations, translations = np.tile(np.eye(4)[0], (len(heads) + 1, 1)), np.tile(pose.translation, (len(heads) + 1, 1))
        for bones in self._levels:  # the parent -1 of a root is the last row, which does not turn
            above, head = parents[bones], heads[bones]
            rotations[bones] = product(rotations[above], pose.rotations[bones])
            translations[bones] = translations[above] + turned(rotations[above], head) - turned(rotations[bones], head)
        return rotations[:-1], translations[:-1]

    def _blended(self, pose):
        """Real and dual parts of the weighted motions of each point and bone, [V, K, 4], and their sums."""
        rotations, translations = self.motions(pose)
        dual = 0.5 * product(pure(translations), rotations)
        signs = np.where(np.einsum("vkc,vc->vk", rotations[self._indices], rotations[self._pivot]) < 0.0, -1.0, 1.0)
        parts = [(signs * self._weights)[..., None] * values[self._indices] for values in (rotations, dual)]
        return rotations, translations, parts, [part.sum(axis=1) for part in parts]

    def posed(self, pose):
        """Points of a pose, [V, 3]."""
        _, _, _, (real, dual) = self._blended(pose)
        squares = np.sum(real**2, axis=1, keepdims=True)
        return turned(real, self.points) / squares + 2.0 * product(dual, conjugate(real))[:, 1:] / squares

    def derivatives(self, pose):
        """Points of a pose and their derivatives by small turns of the joints in world axes: blocks [P, 3, 3] of the pairs.

        With quaternions R and D, the weighted means of the real and dual parts of a point p, the posed point is
        q = (R p R* + 2 vec(D R*)) / |R|^2. A turn t about the head h changes the parts of the bones below, of which R' and D'
        are the weighted sums, by t R' / 2 and (t D' + (h x t) R') / 2.
        """
        v, joints, _, sum_up = self._pairs
        rotations, translations, parts, (real, dual) = self._blended(pose)
        squares = np.sum(real**2, axis=1)
        moved = (turned(real, self.points) + 2.0 * product(dual, conjugate(real))[:, 1:]) / squares[:, None]
        of_pair = [sum_up @ part.reshape(-1, 4) for part in parts]
        heads = self._skeleton.heads[self.joints]
        heads = (turned(rotations[self.joints], heads) + translations[self.joints])[joints]
        right = product(pure(self.points), conjugate(real)) - conjugate(dual)
        sum_of = product(of_pair[0], right[v]) + product(of_pair[1], conjugate(real)[v])
        own = product(of_pair[0], conjugate(real)[v])
        identity = np.eye(3)
        blocks = sum_of[:, :1, None] * identity - crosses(sum_of[:, 1:])
        blocks += (own[:, :1, None] * identity - crosses(own[:, 1:])) @ crosses(heads)
        blocks += moved[v][:, :, None] * own[:, None, 1:]
        return moved, blocks / squares[v][:, None, None]

    def jacobian(self, pose):
        """Points of a pose and the sparse matrix of their derivatives, [3 V, 3 J]."""
        moved, blocks = self.derivatives(pose)
        _, joints, starts, _ = self._pairs
        return moved, bsr_matrix((blocks, joints, starts), shape=(3 * self._count, 3 * len(self.joints))).tocsr()

    def stepped(self, pose, turns, shift):
        """The pose after turns [J, 3] of the joints in world axes and a shift."""
        above, parents = self.motions(pose)[0], self._skeleton.parents[self.joints]
        of_parent = np.where((parents >= 0)[:, None], above[parents], np.eye(4)[0])
        local = turned(conjugate(of_parent), turns)
        rotations = pose.rotations.copy()
        rotations[self.joints] = product(quaternions_of(local), rotations[self.joints])
        return Pose(rotations / np.linalg.norm(rotations, axis=1, keepdims=True), pose.translation + shift)

    def first(self, shape, masses):
        """The pose by the best rotation of the points of each bone, and of its parent where it has none."""
        turns = np.tile(np.eye(3), (len(self._skeleton.parents) + 1, 1, 1))
        rotations = np.tile(np.eye(4)[0], (len(self._skeleton.parents), 1))
        for bone in np.concatenate(self._levels):
            above = turns[bone] = turns[self._skeleton.parents[bone]]
            own = self._own.get(bone, ())
            if len(own) > 3:
                rest, seen, mass = self.points[own], shape[own], masses[own]
                rest, seen = (values - mass @ values / mass.sum() for values in (rest, seen))
                matrix = (seen * mass[:, None]).T @ rest
                turns[bone] = closest_rotations(matrix + TOWARDS_PARENT * np.linalg.norm(matrix) * above)
                rotations[bone] = quaternion_of(above.T @ turns[bone])
        pose = Pose(rotations, np.zeros(3))
        pose.translation = masses @ (shape - self.posed(pose)) / masses.sum()
        return pose


def weights_of(body):
    """Numbers and weights of the bones of each point of a vtkPolyData, [V, K] each."""
    return tuple(vtk_to_numpy(body.GetPointData().GetArray(name)) for name in ("BoneIndices", "BoneWeights"))


class RigSpace:
    """Poses of a body, a vtkPolyData with the arrays BoneIndices and BoneWeights, of a Skeleton whose ``joints``, numbers of
    bones, turn. Points with few neighbors of their bone are more often among those that a pose is fitted to."""

    def __init__(self, body, skeleton, joints, fitted_points=FITTED_POINTS):
        points, triangles = arrays_of(body)
        indices, weights = weights_of(body)
        self.mesh = points, triangles
        self.masses = point_masses(points, triangles)
        self.size = np.sqrt(self.masses.sum())
        self._rest, self._bones, self._fitted_points = (points, indices, weights), (skeleton, np.asarray(joints)), fitted_points
        self._see()

    def _see(self):
        """Chooses the points that poses are fitted to, of those that are known."""
        points, indices, weights = self._rest
        self.dominant = np.take_along_axis(indices, np.argmax(weights, axis=1)[:, None], axis=1)[:, 0]
        self._skin = Skin(points, indices, weights, *self._bones)
        self._fitted, self._fitted_masses, self._fitted_skin = np.arange(len(points)), self.masses, self._skin
        if len(points) > self._fitted_points:
            self._fitted = self._some_points(self._fitted_points)
            nearest = cKDTree(points[self._fitted]).query(points)[1]
            self._fitted_masses = np.bincount(nearest, self.masses, len(self._fitted))
            self._fitted_skin = Skin(points[self._fitted], indices[self._fitted], weights[self._fitted], *self._bones)

    def seen_at(self, points):
        """The same space for shapes of which only these points are known, such as those of a damaged triangulation. Distances are
        means over their part of the area, in units of the root of the whole."""
        seen = copy.copy(self)
        seen.mesh = None
        seen._rest = tuple(values[points] for values in self._rest)
        seen.masses = self.masses[points]
        seen._see()
        return seen

    def _some_points(self, count):
        of_bone = np.bincount(self.dominant, self.masses)
        chances = self.masses / np.sqrt(of_bone[self.dominant])
        random = np.random.default_rng(0)
        return np.sort(random.choice(len(chances), count, replace=False, p=chances / chances.sum()))

    def fit(self, shape):
        """The Pose that is nearest to a shape [V, 3], at the chosen points."""
        shape = np.asarray(shape, dtype=float)[self._fitted]
        skin, masses = self._fitted_skin, np.repeat(self._fitted_masses / self._fitted_masses.sum(), 3)
        pose, damping = skin.first(shape, self._fitted_masses), DAMPING
        moved, jacobian = skin.jacobian(pose)
        squares = masses @ (shape - moved).ravel() ** 2
        for _ in range(MOST_STEPS):
            step = self._step(jacobian, masses, (shape - moved).ravel(), damping)
            tried = skin.stepped(pose, step[:-3].reshape(-1, 3), step[-3:])
            gain = 1.0 - masses @ (shape - skin.posed(tried)).ravel() ** 2 / max(squares, 1e-300)
            if gain <= 0.0:
                damping *= 30.0
                if damping > 1e3:
                    break
                continue
            pose, damping = tried, max(0.1 * damping, 1e-9)
            moved, jacobian = skin.jacobian(pose)
            squares = masses @ (shape - moved).ravel() ** 2
            if gain < LEAST_GAIN or np.sqrt(squares) < 1e-6 * self.size:
                break
        return pose

    @staticmethod
    def _step(jacobian, masses, away, damping):
        """Turns and shift of a damped Gauss-Newton step."""
        count = jacobian.shape[1]
        weighted = jacobian.multiply(masses[:, None]).tocsr()
        form, right = np.empty((count + 3, count + 3)), np.empty(count + 3)
        shifts = np.tile(np.eye(3), (len(masses) // 3, 1))
        form[:count, :count] = (jacobian.T @ weighted).toarray()
        form[:count, count:] = weighted.T @ shifts
        form[count:, :count] = form[:count, count:].T
        form[count:, count:] = np.eye(3) * masses[::3].sum()
        right[:count] = weighted.T @ away
        right[count:] = (shifts * masses[:, None]).T @ away
        form[np.diag_indices(count + 3)] += damping * np.trace(form) / (count + 3)
        return cho_solve(cho_factor(form), right)

    def posed(self, pose):
        """Points of a pose, [V, 3]."""
        return self._skin.posed(pose)

    def distance(self, first, second):
        """Root mean square distance of two shapes over the area, in units of its root."""
        return np.sqrt(self.masses @ np.sum((first - second) ** 2, axis=1) / self.masses.sum()) / self.size

    def residuals(self, shapes):
        """The distances of shapes [N, V, 3] from the poses that are fitted to them."""
        return np.array([self.distance(self.posed(self.fit(shape)), shape) for shape in shapes])

    def noisy(self, shapes, seed):
        """Shapes [N, V, 3] with noise."""
        random = np.random.default_rng(seed)
        return shapes + NOISE * self.size / np.sqrt(3.0) * random.standard_normal(np.shape(shapes))


def moved_joints(folder, skeleton):
    """Numbers of the bones that a pose of the folder turns, and of the roots."""
    moved = set(np.flatnonzero(skeleton.parents < 0))
    numbers = {name: k for k, name in enumerate(skeleton.names)}

    def turns(row):
        return any(abs(float(row[f"Rotation:{k}"])) > LEAST_TURN for k in (1, 2, 3))

    for path in sorted(glob.glob(os.path.join(folder, "*.csv"))):
        with open(path, newline="", encoding="utf-8") as file:
            table = csv.DictReader(file)
            if "Rotation:0" in (table.fieldnames or []):
                moved.update(numbers[row["Name"]] for row in table if turns(row))
    return np.array(sorted(moved))


def hands_of(space, skeleton):
    """The triangles of the hands."""
    wrists = [skeleton.names.index(name) for name in WRISTS if name in skeleton.names]
    inside = np.array([any(wrist in chain for wrist in wrists) for chain in skeleton.chains()])
    return space.mesh[1][inside[space.dominant][space.mesh[1]].all(axis=1)]


def triangulated(body, skeleton, faces):
    """The body, remeshed to about so many faces; the weights are those of the nearest places."""
    return remeshed(body, skeleton, faces // 2 + 2)


class Evaluation:
    """Distances, coverage and stretch of ensembles of shapes on one triangulation of the body."""

    def __init__(self, body, skeleton, joints, poses):
        self.space = RigSpace(body, skeleton, joints)
        self._hands = hands_of(self.space, skeleton)
        self._references = np.array([self.space.posed(pose) for pose in poses])

    def row(self, name, shapes, references):
        """Numbers of an ensemble; COV and 1-NNA against other poses [N, V, 3] of the same number."""
        count = min(len(shapes), len(references))
        fitted = [self.space.posed(self.space.fit(shape)) for shape in shapes]
        distances = np.array([self.space.distance(*pair) for pair in zip(fitted, shapes)])
        metrics = surfacesynthesis.ensemble_metrics(
            shapes[:count], references[:count], source=self.space.mesh, remove_centroid=True
        )
        return {
            "ensemble": name,
            "points": len(self.space.mesh[0]),
            "faces": len(self.space.mesh[1]),
            "samples": len(shapes),
            "distance": distances.mean(),
            "deviation": distances.std(),
            "largest": distances.max(),
            "cov": metrics["cov"],
            "nna": metrics["one_nearest_neighbour_accuracy"],
            "hands": self._stretch_of_hands([self.space.mesh[0]] * len(shapes), shapes),
            "hands_of_poses": self._stretch_of_hands([self.space.mesh[0]] * len(shapes), fitted),
            "hands_of_fit": self._stretch_of_hands(fitted, shapes),
        }

    def _stretch_of_hands(self, before, after):
        """Per cent; nan where there are no hands."""
        if not len(self._hands):
            return np.nan
        squares = [stretch((first, self._hands), [second]) ** 2 for first, second in zip(before, after)]
        return 100.0 * np.sqrt(np.mean(squares))

    def rows(self, options, count):
        """Rows of test poses, of the same seen through noise and of samples of the model."""
        first, second = self._references[:count], self._references[count : 2 * count]
        yield self.row("test poses", first, second)
        noisy = self.space.noisy(first, options.seed)
        yield self.row("test poses seen through noise", noisy, second)
        if options.model:
            samples = generated(options, self.space.mesh, count)
            yield self.row("samples", samples, second)


def generated(options, mesh, count, **parameters):
    """Samples of the model, [N, V, 3], with these parameters of deform(), and their seconds on the standard error stream."""
    started = time.monotonic()
    flow = {"steps": options.steps, "corrections": options.corrections, "temperature": options.temperature}
    samples = surfacesynthesis.deform(mesh, options.model, seed=options.seed, samples=count, **flow, **parameters)
    print(f"{count} samples on {len(mesh[0]):,} points: {time.monotonic() - started:.0f} s", file=sys.stderr, flush=True)
    return np.asarray(samples, dtype=float).reshape(count, -1, 3)


def fitted_poses(folder, skeleton, joints, count):
    """The body, ``count`` poses that are fitted to those of the test file, and their distances there."""
    dataset = surfacesynthesis.read_signal_dataset(os.path.join(folder, "body_test.safetensors"))
    (source,) = dataset.sources
    body = surfacesynthesis.read_mesh(os.path.join(folder, "body.vtp"))
    mesh = with_weights_of(to_polydata(mesh_of_triangles(source.points, source.triangles)), body, skeleton)
    space = RigSpace(mesh, skeleton, joints)
    shapes = source.signals[:count].astype(float)
    if len(shapes) < count:
        raise SystemExit(f"body_test.safetensors has {len(shapes)} poses; {count} are needed")
    poses = [space.fit(shape) for shape in shapes]
    distances = np.array([space.distance(space.posed(pose), shape) for pose, shape in zip(poses, shapes)])
    return body, poses, distances


def print_rows(rows):
    heads = ("ensemble", "points", "faces", "samples", "distance to the space of poses", "largest", "COV", "1-NNA",
             "stretch of the hands", "of the fitted poses", "over these")  # fmt: skip
    print(f"| {' | '.join(heads)} |\n|---|{'---:|' * (len(heads) - 1)}")
    for row in rows:
        numbers = (f"{row['points']:,}", f"{row['faces']:,}", f"{row['samples']}",
                   f"{row['distance']:.4f} ± {row['deviation']:.4f}", f"{row['largest']:.4f}", f"{row['cov']:.3f}",
                   f"{row['nna']:.3f}", f"{row['hands']:.1f} %", f"{row['hands_of_poses']:.1f} %", f"{row['hands_of_fit']:.1f} %")  # fmt: skip
        print(f"| {row['ensemble']} | {' | '.join(numbers)} |", flush=True)
        yield row


def parsed(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", metavar="FOLDER", help="the folder of make_bodies.py")
    parser.add_argument("--model", metavar="FILE", help="a model of bodies (default: none, poses only)")
    parser.add_argument("--faces", type=int, nargs="+", default=[5000, 200000], metavar="F", help="default: 5000 200000")
    parser.add_argument("--samples", type=int, nargs="+", default=[100], metavar="N", help="for each of --faces (default: 100)")
    parser.add_argument("--steps", type=int, default=10, metavar="N", help="of the flow (default: 10)")
    parser.add_argument("--corrections", type=int, metavar="N", help="of each sample (default: what suits the model)")
    parser.add_argument("--temperature", type=float, default=1.0, metavar="X", help="factor of the noise (default: 1)")
    parser.add_argument("--seed", type=int, default=1, help="default: 1")
    parser.add_argument("--csv", metavar="FILE", help="write the table")
    options = parser.parse_args(arguments)
    if len(options.samples) not in (1, len(options.faces)):
        parser.error("--samples takes one number, or one for each of --faces")
    options.samples = options.samples * (len(options.faces) if len(options.samples) == 1 else 1)
    return options


def main(arguments=None):
    options = parsed(arguments)
    skeleton = Skeleton.read(os.path.join(options.folder, "bones.csv"))
    joints = moved_joints(options.folder, skeleton)
    body, poses, distances = fitted_poses(options.folder, skeleton, joints, 2 * max(options.samples))
    print(f"{len(poses)} test poses of the file: distance {distances.mean():.1e}, at most {distances.max():.1e}; "
          f"{len(joints)} of {len(skeleton.names)} bones turn\n", flush=True)  # fmt: skip
    every = (
        row
        for faces, count in zip(options.faces, options.samples)
        for row in Evaluation(triangulated(body, skeleton, faces), skeleton, joints, poses[: 2 * count]).rows(options, count)
    )
    rows = list(print_rows(every))
    if options.csv:
        write_csv(rows, options.csv)
    return rows


if __name__ == "__main__":
    main()
