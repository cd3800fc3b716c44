# SPDX-License-Identifier: BSD-3-Clause
"""The spectrum of noise on several triangulations of one surface: distributions of single spectral coefficients."""

import math

import numpy as np
import scipy.sparse
import scipy.sparse.linalg

import surfacesynthesis
from gallery_meshes import arrays_of, mesh_of

COEFFICIENTS = (2, 50, 500)  # counted from 1: coefficient 1 belongs to the constant
MODELS = {"matern": "Matérn noise", "per_vertex": "one number per vertex"}
BATCH = 250  # samples drawn in one go


def laplacian(points, triangles):
    """Lumped mass [V] and cotangent stiffness, sparse [V, V] and positive semi-definite."""
    count = len(points)
    rows, columns, values = [], [], []
    area = np.linalg.norm(np.cross(*(points[triangles[:, k]] - points[triangles[:, 0]] for k in (1, 2))), axis=1) / 2
    for k in range(3):
        i, j, o = (triangles[:, (k + step) % 3] for step in range(3))
        a, b = points[i] - points[o], points[j] - points[o]
        half_cotangent = np.einsum("fx,fx->f", a, b) / (4 * area)
        rows += [i, j, i, j]
        columns += [j, i, i, j]
        values += [-half_cotangent, -half_cotangent, half_cotangent, half_cotangent]
    stiffness = scipy.sparse.csc_matrix(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=(count, count)
    )
    return np.bincount(triangles.ravel(), np.repeat(area / 3, 3), minlength=count), stiffness


def eigenfunctions(mass, stiffness, area):
    """Eigenvalues and M-orthonormal eigenfunctions [V, 3] of COEFFICIENTS.

    Each is looked for near where Weyl's law expects it to be, for which all eigenvalues below are counted by the
    signs of a factorisation, so that hundreds of them need not be computed.
    """
    scale = scipy.sparse.diags(1 / np.sqrt(mass))
    symmetric = (scale @ stiffness @ scale).tocsc()
    found = []
    for number in COEFFICIENTS:
        shift = 4 * math.pi * number / area  # Weyl's law in two dimensions
        found.append(_numbered(symmetric, number, shift))
    values = np.array([value for value, _ in found])
    return values, np.stack([vector for _, vector in found], axis=1) / np.sqrt(mass)[:, None]


def _numbered(matrix, number, shift):
    """The eigenvalue with a number (from 1) of a symmetric matrix, and its eigenvector."""
    if number <= 60:
        values, vectors = scipy.sparse.linalg.eigsh(matrix, k=number + 3, sigma=-1e-3 * shift)
        order = np.argsort(values)
        return values[order[number - 1]], vectors[:, order[number - 1]]
    for _ in range(20):
        below = _count_below(matrix, shift)
        wanted = number - below  # 1 for the first eigenvalue above the shift
        if -20 <= wanted <= 20:
            values, vectors = scipy.sparse.linalg.eigsh(matrix, k=2 * abs(wanted) + 20, sigma=shift)
            order = np.argsort(values)
            first_above = np.searchsorted(values[order], shift)
            index = first_above + wanted - 1
            if 0 <= index < len(order):
                return values[order[index]], vectors[:, order[index]]
        shift *= number / max(below, 1)
    raise RuntimeError(f"eigenvalue {number} was not found")


def _count_below(matrix, shift):
    """Number of eigenvalues smaller than ``shift``: the number of negative pivots (Sylvester's law of inertia)."""
    factor = scipy.sparse.linalg.splu(
        (matrix - shift * scipy.sparse.identity(matrix.shape[0])).tocsc(),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    return int((factor.U.diagonal() < 0).sum())


def coefficients(mesh, screening, samples, progress):
    """Eigenvalues of COEFFICIENTS, and for each of MODELS the coefficients <f, phi>_M of samples, [samples, 3]."""
    points, triangles = arrays_of(mesh)
    mass, stiffness = laplacian(points, triangles)
    eigenvalues, functions = eigenfunctions(mass, stiffness, mass.sum())
    projector = mass[:, None] * functions
    noise = surfacesynthesis.vtkMaternNoiseFilter()
    noise.SetInputData(mesh_of(points, triangles))
    noise.SetScaleModeToScreening()
    noise.SetScreening(screening)
    result = {}
    for model in MODELS:
        noise.SetNoiseModel(surfacesynthesis.NOISE_MODELS[model])
        parts = []
        for first in range(0, samples, BATCH):
            noise.SetFirstSample(first)
            noise.SetNumberOfSamples(min(BATCH, samples - first))
            noise.Update()
            fields = _fields(noise)
            parts.append(fields @ projector)
            progress(model, first + len(fields))
        result[model] = np.concatenate(parts)
    return eigenvalues, result


def _fields(noise):
    from vtkmodules.util.numpy_support import vtk_to_numpy

    data, name, first = noise.GetOutput().GetPointData(), noise.GetOutputArrayName(), noise.GetFirstSample()
    count = noise.GetNumberOfSamples()
    names = [name] if count == 1 else [f"{name}_{first + k}" for k in range(count)]
    return np.stack([vtk_to_numpy(data.GetArray(name)) for name in names])


def table(labels, spectra, screening):
    """The standard deviations as text: measured, and 1 / (lambda + tau), which holds on every triangulation."""
    lines = [f"{'triangulation':24} {'coefficient':>11} {'lambda':>10} {'1/(lambda+tau)':>14} "
             + " ".join(f"{title:>22}" for title in MODELS.values())]  # fmt: skip
    for label, (eigenvalues, values) in zip(labels, spectra):
        for k, number in enumerate(COEFFICIENTS):
            expected = 1 / (eigenvalues[k] + screening)
            measured = " ".join(f"{values[model][:, k].std():22.4g}" for model in MODELS)
            lines.append(f"{label:24} {number:11d} {eigenvalues[k]:10.4g} {expected:14.4g} {measured}")
    return "\n".join(lines)


def plot(labels, spectra, path):
    """Histograms, one column for each coefficient and one row for each model, overlaid for the triangulations."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    colors = ("#1f4fb4", "#e08214", "#2a9d5c")
    figure, axes = pyplot.subplots(len(MODELS), len(COEFFICIENTS), figsize=(12, 6.2), dpi=150)
    for axis, number in zip(axes[0], COEFFICIENTS):
        axis.set_title(f"spectral coefficient {number}", fontsize=13)
    for row, (model, title) in zip(axes, MODELS.items()):
        for k, axis in enumerate(row):
            widest = max(values[model][:, k].std() for _, values in spectra)
            bins = np.linspace(-3.2 * widest, 3.2 * widest, 49)
            for label, color, (_, values) in zip(labels, colors, spectra):
                axis.hist(values[model][:, k], bins, density=True, histtype="stepfilled", color=color, alpha=0.22)
                axis.hist(values[model][:, k], bins, density=True, histtype="step", color=color, lw=1.4, label=label)
            axis.set_yticks([])
            axis.set_xlim(bins[0], bins[-1])
            axis.locator_params(axis="x", nbins=5)
            for side in ("left", "right", "top"):
                axis.spines[side].set_visible(False)
        row[0].set_ylabel(title, fontsize=13)
    handles, names = axes[0][0].get_legend_handles_labels()
    figure.legend(handles, names, loc="lower center", ncol=len(labels), frameon=False, fontsize=12)
    figure.tight_layout(rect=(0, 0.06, 1, 1))
    figure.savefig(path)
    pyplot.close(figure)
