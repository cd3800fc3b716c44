# SPDX-License-Identifier: BSD-3-Clause
"""Random mixtures of Gaussians on surfaces: a function around vtkGaussianMixtureFilter."""

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkPolyData

from .arguments import INT_MIN, at_least_0, integer, positive, progress_callback
from .datasets import given_dataset
from .deprecation import renamed_keywords
from .errors import SurfaceSynthesisError
from .poses import SURFACE_TEXT
from .sampling import in_parts
from .vtkSurfaceSynthesisEnsembles import vtkGaussianMixtureFilter


@renamed_keywords(centres="centers", width="gaussian_width")
def gaussian_mixtures(
    mesh,
    samples,
    seed=0,
    first_sample=0,
    centers=3,
    gaussian_width=0.08,
    separation=4.0,
    progress=None,
    memory_limit=None,
):
    """Random mixtures of Gaussians on a surface: the signals of appendix C.3 of "Matérn Noise for Triangulation-Agnostic
    Flow Matching on Meshes".

    g(x) = sum_c exp(-d(x, c)^2 / (2 sigma^2)), with d the distance along the surface (by the heat method, Crane,
    Weischedel and Wardetzky 2013) and random centres c, uniform on the surface, that keep a distance from each other. The
    same seed gives the same bits for every number of threads, and sample k is the same alone or in a batch.

    Parameters
    ----------
    mesh : vtkPolyData or pair (points, triangles)
        A surface with finite points, no degenerate triangle and no edge with more than two triangles. The mesh is never
        modified.
    samples : int
        Number of mixtures, at least 1.
    seed : int
        Any integer of 32 bits with sign; each gives other mixtures. Default 0.
    first_sample : int
        Index of the first sample, at least 0: an ensemble may be drawn in parts. Default 0.
    centers : int
        Number of Gaussians in each mixture, from 1 to 1000. Default 3.
    gaussian_width : float
        The standard deviation sigma, as a fraction of the square root of the area; larger than 0. Default 0.08.
    separation : float
        The least distance between two centres, in units of sigma; at least 0. Default 4.
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the work stops.
    memory_limit : int, optional
        Memory that the samples may take, MiB. More samples than fit raise an error before the work begins, whose text
        names a number that fits. Default: three quarters of the memory of the machine.

    Returns
    -------
    numpy.ndarray
        The mixtures, [N, V] float64; 0 at points that no polygon or strip uses.

    Raises
    ------
    SurfaceSynthesisError
        The mixtures could not be computed. The text names the defect of the mesh, the first cell or point, and the
        filter that repairs it; or says that there is no room for so many centres.
    Cancelled
        ``progress`` returned False.
    ValueError, TypeError
        An argument has a value out of its range, or is of a wrong type.
    """
    algorithm = configured_mixtures(seed, centers, gaussian_width, separation)
    dataset = given_dataset(mesh, (vtkPolyData,), SURFACE_TEXT)
    parts = in_parts(algorithm, dataset, samples, first_sample, progress_callback(progress), 8, memory_limit)
    return np.concatenate([_values(algorithm, output) for output in parts])


def configured_mixtures(seed=0, centers=3, gaussian_width=0.08, separation=4.0):
    """A vtkGaussianMixtureFilter with the parameters of gaussian_mixtures(), which raises TypeError and ValueError."""
    algorithm = vtkGaussianMixtureFilter()
    algorithm.SetSeed(integer("seed", seed, INT_MIN))
    algorithm.SetNumberOfCenters(integer("centers", centers, 1, 1000))
    algorithm.SetWidth(positive("gaussian_width", gaussian_width))
    algorithm.SetSeparation(at_least_0("separation", separation))
    return algorithm


def _values(algorithm, output):
    """[N, V], the arrays that the filter has added."""
    if output.GetNumberOfPoints() == 0:
        raise SurfaceSynthesisError("the mesh is empty; a surface is needed")
    name, first, samples = algorithm.GetOutputArrayName(), algorithm.GetFirstSample(), algorithm.GetNumberOfSamples()
    names = [name] if samples == 1 else [f"{name}_{first + k}" for k in range(samples)]
    return np.stack([vtk_to_numpy(output.GetPointData().GetArray(name)) for name in names])
