# SPDX-License-Identifier: BSD-3-Clause
"""The loss of the best linear velocity of flow matching, in closed form.

Let x1 be a training sample with covariance C1, x0 noise with covariance C0, f = (1 - t) x0 + t x1 the state at time t and
v = x1 - x0 the velocity that a network learns. Of all affine functions of f, the conditional mean of v in the Gaussian
with these covariances has the least error. As v = (x1 - f) / (1 - t), its error is the covariance of x1 given f, over
(1 - t)^2. With C1 = D D^T for N samples that is, by the identity of Woodbury,

    D ((1 - t)^2 I + t^2 G)^-1 D^T,    G = D^T C0^-1 D = Q diag(g) Q^T,

so that the loss, a quadratic form W of the error, is the sum of h_k / ((1 - t)^2 + t^2 g_k) with h = diag(Q^T D^T W D Q).
It is exact for the samples that are given: mean and covariance are theirs. W is that of the training: the mass for
velocities and half the stiffness for their gradients. A network whose loss is not below this one has learnt nothing that
is not linear.
"""

import json
from typing import NamedTuple

import numpy as np

from surfacesynthesis.safetensors import read_safetensors

#: Variances of the noise below this part of the largest one are raised to it: single precision does not resolve them.
LEAST_VARIANCE = 1e-10


class Noise(NamedTuple):
    """Noise of a flow matching model, on the surface scaled to area 1."""

    model: str  #: as ``noise_model`` of train_flow_matching()
    screening: float = 100.0
    eigenpairs: int = 256
    smoothing: float = 0.0  #: s of (M + s L) g = M f
    scale: float = 1.0


class Frame(NamedTuple):
    """Signal and noise of a flow matching model."""

    signal: str  #: "Position" for deformations
    mean: np.ndarray  #: [C], of signals that are no positions
    scale: np.ndarray  #: [C]
    noise: Noise
    prediction: str = "velocity"  #: or "data", "preconditioned"


def frame_of(model):
    """The frame of a model file."""
    content = json.loads(read_safetensors(model)[1]["flow_matching"])
    name = content["noise"]
    noise = Noise(
        name,
        content["noise_screening"],
        content["noise_eigenpairs"],
        content.get("noise_smoothing" if name == "matern" else "smoothing", 0.0),
        content["noise_scale"],
    )
    units = np.array(content["signal_mean"]), np.array(content["signal_scale"])
    return Frame(content["signal_name"], *units, noise, content.get("prediction", "velocity"))


def triangle_areas(points, triangles):
    a, b, c = (points[triangles[:, k]].astype(float) for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def point_masses(points, triangles):
    """A third of the areas of the triangles of each point."""
    areas = triangle_areas(points, triangles)
    return np.bincount(triangles.ravel(), np.repeat(areas / 3.0, 3), len(points))


def cotangent_weights(points, triangles):
    """Edges [3 F, 2] and their weights, half the cotangent of the angle opposite: an edge of two triangles is there
    twice."""
    edges, weights = [], []
    for k in range(3):
        i, j, opposite = (triangles[:, (k + m) % 3] for m in range(3))
        u, v = (points[n].astype(float) - points[opposite] for n in (i, j))
        edges.append(np.stack([i, j], axis=1))
        weights.append(0.5 * np.einsum("fc,fc->f", u, v) / np.linalg.norm(np.cross(u, v), axis=1))
    return np.concatenate(edges), np.concatenate(weights)


class Modes:
    """All eigenpairs of the Laplacian of a surface scaled to area 1: L phi = lambda M phi, phi^T M phi = 1. Each point
    belongs to a triangle."""

    def __init__(self, points, triangles):
        points = points / np.sqrt(triangle_areas(points, triangles).sum())
        self.mass = point_masses(points, triangles)
        stiffness = np.zeros((len(points), len(points)))
        (first, second), weights = cotangent_weights(points, triangles)[0].T, cotangent_weights(points, triangles)[1]
        for i, j, sign in ((first, second, -1.0), (second, first, -1.0), (first, first, 1.0), (second, second, 1.0)):
            np.add.at(stiffness, (i, j), sign * weights)
        root = np.sqrt(self.mass)
        values, vectors = np.linalg.eigh(stiffness / np.outer(root, root))
        self.values = np.maximum(values, 0.0)
        self.vectors = vectors / root[:, None]

    def coordinates(self, signals):
        """Coefficients [N, V, C] of signals [N, V, C]."""
        return np.matmul((self.vectors * self.mass[:, None]).T, signals)

    def noise_covariance(self, noise):
        """The covariance of the coefficients of one component of noise with scale 1: [V] where it is diagonal, else
        [V, V]."""
        smoothing = 1.0 / (1.0 + noise.smoothing * self.values)
        if noise.model == "per_vertex":
            values = smoothing[:, None] * (self.vectors.T * self.mass)
            return values @ values.T
        if noise.model == "white":
            amplitudes = np.ones_like(self.values)
        elif noise.model == "unscreened":
            amplitudes = np.concatenate([[0.0], 1.0 / self.values[1:]])
        else:
            amplitudes = 1.0 / (self.values + noise.screening)
            if noise.model == "spectral":
                amplitudes[noise.eigenpairs :] = 0.0
        return (smoothing * amplitudes) ** 2


class LinearVelocity:
    """The best linear velocity for samples [N, V, C] in the units of the network and one kind of noise. ``centered``
    removes the mean over the surface from the noise and the samples, as the training does with positions."""

    def __init__(self, modes, samples, noise, centered, vertex_weight=1.0, jacobian_weight=1.0):
        first = 1 if centered else 0
        coordinates = modes.coordinates(samples)[:, first:]
        covariance = modes.noise_covariance(noise)[(slice(first, None),) * (2 if noise.model == "per_vertex" else 1)]
        count, _, components = coordinates.shape
        weights = (vertex_weight + 0.5 * jacobian_weight * modes.values[first:]) / components
        deviations = (coordinates - coordinates.mean(axis=0)) / np.sqrt(count)
        weighted = deviations * np.sqrt(weights)[:, None]
        if covariance.ndim == 1:
            whitened = deviations / np.maximum(covariance, LEAST_VARIANCE * covariance.max())[:, None]
            variances = covariance
        else:
            whitened = np.linalg.solve(covariance, deviations)
            variances = np.diag(covariance)
        gram = deviations.reshape(count, -1) @ whitened.reshape(count, -1).T
        values, vectors = np.linalg.eigh(0.5 * (gram + gram.T))
        self._g = np.maximum(values, np.finfo(float).eps * values.max())
        self._h = ((vectors.T @ weighted.reshape(count, -1)) ** 2).sum(axis=1)
        self._noise = components * (weights * variances).sum()
        self._mean = (weights[:, None] * coordinates.mean(axis=0) ** 2).sum()

    def loss(self, time, scale=1.0):
        """The loss at a time in [0, 1), of noise with this scale."""
        return (self._h / ((1.0 - time) ** 2 + time**2 * self._g / scale**2)).sum()

    def mean_losses(self, scale=1.0, parts=8):
        """The means of the loss over equal parts of [0, 1]."""
        g = self._g / scale**2
        ends = np.linspace(0.0, 1.0, parts + 1)
        # The integral of 1 / ((1 + g) t^2 - 2 t + 1) is atan(((1 + g) t - 1) / sqrt(g)) / sqrt(g).
        begin, end = ((1.0 + g) * t - 1.0 for t in (ends[:-1, None], ends[1:, None]))
        integrals = np.arctan2((end - begin) * np.sqrt(g), g + begin * end) / np.sqrt(g)
        return parts * (self._h * integrals).sum(axis=1)

    def constant_loss(self, scale=1.0):
        """The loss of the best velocity that is the same for all states, at any time."""
        return self._h.sum() + scale**2 * self._noise

    def zero_loss(self, scale=1.0):
        """The loss of no velocity at all, at any time."""
        return self.constant_loss(scale) + self._mean


def loss_weights(frame, modes, mesh, samples):
    """The weights of the two terms of the loss that a training logs, for samples in the units of the network: unless models
    predict velocities, they are in units of the mean squares of the data, relative to the surface, and of their gradients."""
    if frame.prediction == "velocity":
        return 1.0, 1.0
    relative = samples - network_units(frame, mesh, mesh[0][None]) if frame.signal == "Position" else samples
    squares = (modes.coordinates(relative) ** 2).sum(axis=2).mean(axis=0) / samples.shape[2]
    return 1.0 / squares.sum(), 2.0 / (squares * modes.values).sum()


def network_units(frame, mesh, samples):
    """Samples [N, V, C] as the network of a model sees them."""
    if frame.signal != "Position":
        return (samples - frame.mean) / frame.scale
    masses = point_masses(*mesh)
    centers = np.einsum("v,nvc->nc", masses / masses.sum(), samples)
    return (samples - centers[:, None]) / np.sqrt(masses.sum())
