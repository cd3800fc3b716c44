# SPDX-License-Identifier: BSD-3-Clause
"""Random poses of a shape: a function around vtkPoseEnsembleFilter."""

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkPolyData

from .arguments import INT_MIN, in_range, integer, progress_callback
from .datasets import given_dataset
from .errors import SurfaceSynthesisError
from .sampling import in_parts, positions_of_blocks

try:
    from .vtkSurfaceSynthesisEnsembles import vtkPoseEnsembleFilter
except ImportError:  # built without CGAL
    vtkPoseEnsembleFilter = None

SURFACE_TEXT = "a vtkPolyData or a pair of arrays (points, triangles)"


def poses(
    mesh,
    samples,
    seed=0,
    first_sample=0,
    template=None,
    handles=6,
    maximum_angle=60.0,
    maximum_twist=20.0,
    handle_radius=0.08,
    anchor_radius=0.12,
    pivot_position=0.8,
    iterations=40,
    stiffness=2e-4,
    progress=None,
    memory_limit=None,
):
    """Random poses of a shape: its limbs swing, the rest follows as rigidly as possible.

    The extremities of the shape turn about their joints by random angles, the part near its centroid stays, and the rest
    is deformed as rigidly as possible, with rotations that vary smoothly (CGAL's Surface_mesh_deformation). The same seed
    gives the same bits for every number of threads, and sample k is the same alone or in a batch.

    Parameters
    ----------
    mesh : vtkPolyData or pair (points, triangles)
        A connected surface with finite points, no degenerate triangle, manifold edges and points, and consistent winding;
        repair() makes such a surface. The mesh is never modified.
    samples : int
        Number of poses, at least 1.
    seed : int
        Any integer of 32 bits with sign; each gives other poses. Default 0.
    first_sample : int
        Index of the first sample, at least 0: an ensemble may be made in parts. Default 0.
    template : vtkPolyData or pair (points, triangles), optional
        Another triangulation of the same shape in the same place, on which extremities, joints and regions are found.
        With the same template, seed and sample, every triangulation of the shape gets the same pose, to about one per
        cent of the square root of its area. Default: the mesh itself.
    handles : int
        Number of extremities that are turned, from 1 to 100. Default 6.
    maximum_angle : float
        The largest angle by which an extremity turns about its joint, in degrees, from 0 to 180; on average it is 3/4 of
        it. Default 60.
    maximum_twist : float
        The largest angle by which it turns about its own centre besides, in degrees, from 0 to 180. Default 20.
    handle_radius : float
        The distance along the surface, as a fraction of the square root of the area, within which an extremity moves as
        one piece; from 0.001 to 1. Default 0.08.
    anchor_radius : float
        Radius of the part that stays, as a fraction of the square root of the area, from 0.001 to 1. Default 0.12.
    pivot_position : float
        Position of the joint on the way from the extremity (0) to the part that stays (1). Default 0.8.
    iterations : int
        Number of iterations for each pose, from 1 to 10000; more bring different triangulations closer together.
        Default 40.
    stiffness : float
        Resistance to bending, from 0 to 1; larger makes limbs bend over a longer way. Default 0.0002.
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the work stops.
    memory_limit : int, optional
        Memory that the samples may take, MiB. More samples than fit raise an error before the work begins, whose text
        names a number that fits. Default: three quarters of the memory of the machine.

    Returns
    -------
    numpy.ndarray
        The positions of the points in each pose, [N, V, 3] float64, or float32 where the points of a vtkPolyData are.

    Raises
    ------
    SurfaceSynthesisError
        The mesh or the template cannot be posed, or a pose would destroy the shape: then the text names the sample. Also
        when the package was built without CGAL.
    Cancelled
        ``progress`` returned False.
    ValueError, TypeError
        An argument has a value out of its range, or is of a wrong type.
    """
    algorithm = configured_poses(
        seed,
        template,
        handles,
        maximum_angle,
        maximum_twist,
        handle_radius,
        anchor_radius,
        pivot_position,
        iterations,
        stiffness,
    )
    dataset = given_dataset(mesh, (vtkPolyData,), SURFACE_TEXT)
    parts = in_parts(algorithm, dataset, samples, first_sample, progress_callback(progress), 24, memory_limit)
    return np.concatenate([positions_of_blocks(output, "a surface") for output in parts])


def configured_poses(
    seed=0,
    template=None,
    handles=6,
    maximum_angle=60.0,
    maximum_twist=20.0,
    handle_radius=0.08,
    anchor_radius=0.12,
    pivot_position=0.8,
    iterations=40,
    stiffness=2e-4,
):
    """A vtkPoseEnsembleFilter with the parameters of poses(), which raises TypeError and ValueError."""
    if vtkPoseEnsembleFilter is None:
        raise SurfaceSynthesisError("poses() needs CGAL, which this package was built without")
    algorithm = vtkPoseEnsembleFilter()
    algorithm.SetSeed(integer("seed", seed, INT_MIN))
    algorithm.SetNumberOfHandles(integer("handles", handles, 1, 100))
    algorithm.SetMaximumAngle(in_range("maximum_angle", maximum_angle, 0.0, 180.0))
    algorithm.SetMaximumTwist(in_range("maximum_twist", maximum_twist, 0.0, 180.0))
    algorithm.SetHandleRadius(in_range("handle_radius", handle_radius, 0.001, 1.0))
    algorithm.SetAnchorRadius(in_range("anchor_radius", anchor_radius, 0.001, 1.0))
    algorithm.SetPivotPosition(in_range("pivot_position", pivot_position, 0.0, 1.0))
    algorithm.SetNumberOfIterations(integer("iterations", iterations, 1, 10000))
    algorithm.SetStiffness(in_range("stiffness", stiffness, 0.0, 1.0))
    if template is not None:
        shape = vtkPolyData()  # what pipelines leave on their inputs goes to this copy
        shape.ShallowCopy(given_dataset(template, (vtkPolyData,), SURFACE_TEXT))
        algorithm.SetTemplateData(shape)
    return algorithm
