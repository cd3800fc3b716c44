# SPDX-License-Identifier: BSD-3-Clause
"""Repair and remeshing: functions around vtkSurfaceRepairFilter and vtkIsotropicRemeshFilter."""

import warnings

from vtkmodules.util.numpy_support import vtk_to_numpy

from .arguments import (
    array_name,
    at_least_0,
    choice,
    flag,
    in_range,
    integer,
    positive,
    progress_callback,
)
from .datasets import as_type_of, given_dataset
from .errors import SurfaceSynthesisError, SurfaceSynthesisWarning
from .files.polygons import from_polydata
from .pipeline import apply_filter
from .vocabulary import snake

try:
    from .vtkSurfaceSynthesisMeshing import vtkIsotropicRemeshFilter, vtkSurfaceRepairFilter
except ImportError:  # built without CGAL
    vtkIsotropicRemeshFilter = vtkSurfaceRepairFilter = None

#: The holes that repair() closes, by the name that ``holes`` takes.
HOLES = {"none": 0, "small": 1, "all": 2}


def remesh(
    mesh,
    edge_length=None,
    points=None,
    sizing=None,
    feature_angle=60.0,
    keep_boundary_points=False,
    iterations=3,
    relaxation_steps=1,
    maximum_points=10_000_000,
    progress=None,
):
    """Remeshes a surface with triangles of even size and shape.

    Rounds of edge splits, collapses, flips, tangential relaxation and projection to the input (Botsch and Kobbelt, "A
    Remeshing Approach to Multiresolution Modeling", 2004). Boundaries, creases and seams of point arrays are kept as
    curves; arrays are interpolated.

    Parameters
    ----------
    mesh : vtkPolyData, composite dataset (vtkDataObjectTree) or pair (points, triangles)
        Triangles, polygons or strips with finite points, no degenerate triangle, manifold edges and points, and
        consistent winding; repair() makes such a surface. The mesh is never modified.
    edge_length : float, optional
        The wanted edge length, in world units, larger than 0; most edges end up between 4/5 and 4/3 of it. Default: the
        mean edge length of the input.
    points : int, optional
        Instead of ``edge_length``: the wanted number of points, at least 1; met within about 2 per cent.
    sizing : str, optional
        Name of a point array with the wanted edge length at each point, in world units, larger than 0. With ``points``,
        only the ratios of its values count. Not for a pair.
    feature_angle : float or None
        The angle between the normals of two triangles above which their edge is kept as a crease, in degrees, from 0 to
        180; None keeps no creases. Noisy scans need a large one. Default 60.
    keep_boundary_points : bool
        True leaves every point of a boundary in its place. Default False: boundaries are resampled along themselves.
    iterations : int
        Number of rounds, from 1 to 100. Default 3.
    relaxation_steps : int
        Steps of tangential relaxation in each round, from 0 to 100. Default 1.
    maximum_points : int
        Limit of the points of the output, at least 4. What needs more is an error before the work begins. Default
        10,000,000, which take about 5 GB.
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the work stops.

    Returns
    -------
    dataset of the type of ``mesh``
        Triangles, with the arrays of the input interpolated: floating-point arrays linearly, labels from the nearest
        point, cell arrays from the nearest cell.
    pair of numpy.ndarray, for a pair
        points [V', 3] float64 and triangles [F', 3] int64.

    Raises
    ------
    SurfaceSynthesisError
        The mesh cannot be remeshed: the text names the defect, the first cell or point, and the filter that repairs
        it. The edge length is longer than the surface, or needs more than ``maximum_points``. Also when the package was built without CGAL.
    Cancelled
        ``progress`` returned False.
    ValueError, TypeError
        An argument has a value out of its range, contradicts another, or is of a wrong type.
    """
    algorithm = configured_remesh(
        edge_length,
        points,
        sizing,
        feature_angle,
        keep_boundary_points,
        iterations,
        relaxation_steps,
        maximum_points,
    )
    return _processed(algorithm, mesh, progress)


def configured_remesh(
    edge_length=None,
    points=None,
    sizing=None,
    feature_angle=60.0,
    keep_boundary_points=False,
    iterations=3,
    relaxation_steps=1,
    maximum_points=10_000_000,
):
    """A vtkIsotropicRemeshFilter with the parameters of remesh(), which raises TypeError and ValueError."""
    algorithm = _new(vtkIsotropicRemeshFilter, "remesh()")
    if edge_length is not None and (points is not None or sizing is not None):
        other = "points" if points is not None else "sizing"
        raise ValueError(f"edge_length and {other} exclude each other: each says how fine the mesh becomes")
    if edge_length is not None:
        algorithm.SetTargetEdgeLength(positive("edge_length", edge_length))
    if points is not None:
        algorithm.SetTargetNumberOfPoints(integer("points", points, 1))
    if sizing is not None:
        algorithm.SetSizingArrayName(array_name("sizing", sizing))
    algorithm.SetKeepFeatureEdges(feature_angle is not None)
    if feature_angle is not None:
        algorithm.SetFeatureAngle(in_range("feature_angle", feature_angle, 0.0, 180.0))
    algorithm.SetKeepBoundaryPoints(flag("keep_boundary_points", keep_boundary_points))
    algorithm.SetNumberOfIterations(integer("iterations", iterations, 1, 100))
    algorithm.SetNumberOfRelaxationSteps(
        integer("relaxation_steps", relaxation_steps, 0, 100)
    )
    algorithm.SetMaximumNumberOfPoints(integer("maximum_points", maximum_points, 4))
    return algorithm


def repair(
    mesh,
    merge_points=True,
    merge_tolerance=0.0,
    holes="small",
    hole_size=None,
    largest_component=False,
    minimum_component=0.0,
    self_intersections=False,
    orient_outward=True,
    maximum_loss=0.05,
    strict=False,
    progress=None,
):
    """Makes a valid, manifold surface of a broken one.

    Parameters
    ----------
    mesh : vtkPolyData, composite dataset (vtkDataObjectTree) or pair (points, triangles)
        Any polygons or strips, however broken. The mesh is never modified.
    merge_points : bool
        True merges points within ``merge_tolerance`` of each other. False keeps seams of point arrays, such as
        texture coordinates, apart. Default True.
    merge_tolerance : float
        World units, at least 0. Default 0: points of equal coordinates only.
    holes : str
        The holes that are closed: "none", "small" (the default: those up to ``hole_size``) or "all".
    hole_size : float, optional
        The largest hole that "small" closes: the diagonal of the bounding box of its edge, in world units, larger than
        0. Default: a tenth of the diagonal of the surface's own bounding box.
    largest_component : bool
        True keeps only the connected component of the largest area. Default False.
    minimum_component : float
        Components with less than this fraction of the largest one's area go; from 0 to 1. Default 0: all stay.
    self_intersections : bool
        True replaces triangles that intersect each other by patches without intersections, as far as possible, and
        closes holes only by triangles that intersect no others. Default False.
    orient_outward : bool
        True turns a closed surface so that its normals point out of the solid that it encloses. Default True.
    maximum_loss : float
        Largest fraction of the area, of the volume or of the number of components that a repair may lose (or, of
        components, gain) without a warning; from 0 to 1. A removal of intersections that would lose more, beside
        the area of the intersecting triangles, is refused. Default 0.05.
    strict : bool
        True raises an error in place of each warning about defects that are left and losses beyond ``maximum_loss``.
        Default False.
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the work stops.

    Returns
    -------
    dataset of the type of ``mesh``
        Triangles with manifold edges and points and consistent winding. The cell array ``FilledHole`` is 1 on triangles
        that close a hole. Field data arrays list the repairs and the measures before and after, which repair_report()
        and repair_measures() return. A repair of the result changes nothing.
    pair of numpy.ndarray, for a pair
        points [V', 3] float64 and triangles [F', 3] int64.

    Raises
    ------
    SurfaceSynthesisError
        No valid triangle is left, or a defect cannot be removed; with ``strict``, a defect is left or too much was lost.
        Also when the package was built without CGAL.
    Cancelled
        ``progress`` returned False.
    ValueError, TypeError
        An argument has a value out of its range, contradicts another, or is of a wrong type.

    Warns
    -----
    SurfaceSynthesisWarning
        Triangles still intersect, holes could not be closed, or more than ``maximum_loss`` was lost.
    """
    algorithm = configured_repair(
        merge_points,
        merge_tolerance,
        holes,
        hole_size,
        largest_component,
        minimum_component,
        self_intersections,
        orient_outward,
        maximum_loss,
        strict,
    )
    return _processed(algorithm, mesh, progress)


def configured_repair(
    merge_points=True,
    merge_tolerance=0.0,
    holes="small",
    hole_size=None,
    largest_component=False,
    minimum_component=0.0,
    self_intersections=False,
    orient_outward=True,
    maximum_loss=0.05,
    strict=False,
):
    """A vtkSurfaceRepairFilter with the parameters of repair(), which raises TypeError and ValueError."""
    algorithm = _new(vtkSurfaceRepairFilter, "repair()")
    algorithm.SetMergePoints(flag("merge_points", merge_points))
    algorithm.SetMergeTolerance(at_least_0("merge_tolerance", merge_tolerance))
    algorithm.SetHoleFilling(choice("holes", holes, HOLES))
    if hole_size is not None:
        if holes != "small":
            raise ValueError(f"hole_size goes with holes='small', not with '{holes}'")
        algorithm.SetMaximumHoleSize(positive("hole_size", hole_size))
    algorithm.SetKeepLargestComponent(flag("largest_component", largest_component))
    algorithm.SetMinimumComponentFraction(in_range("minimum_component", minimum_component, 0.0, 1.0))
    algorithm.SetRemoveSelfIntersections(flag("self_intersections", self_intersections))
    algorithm.SetOrientOutward(flag("orient_outward", orient_outward))
    algorithm.SetMaximumLoss(in_range("maximum_loss", maximum_loss, 0.0, 1.0))
    algorithm.SetStrict(flag("strict", strict))
    return algorithm


def repair_report(mesh):
    """Actions of repair() that made ``mesh``, a vtkPolyData: a dictionary of actions and their counts, in order."""
    data = mesh.GetFieldData()
    actions, counts = data.GetAbstractArray("RepairAction"), data.GetArray("RepairCount")
    if actions is None or counts is None:
        raise ValueError("mesh was not made by repair(): it has no field data arrays RepairAction and RepairCount")
    values = vtk_to_numpy(counts).tolist() if counts.GetNumberOfTuples() > 0 else []
    return {actions.GetValue(k): count for k, count in enumerate(values)}


def repair_measures(mesh):
    """Measures of ``mesh``, a vtkPolyData that repair() made: a dictionary of names and pairs (before, after).

    ``area`` (without triangles that close holes), ``volume`` (of surfaces closed before and after), ``components``, and
    with ``self_intersections`` ``intersecting_triangles``. Before: after duplicate triangles were removed and sheets
    separated.
    """
    data = mesh.GetFieldData()
    names, before, after = (data.GetAbstractArray("Repair" + part) for part in ("Measure", "Before", "After"))
    if names is None or before is None or after is None:
        raise ValueError("mesh was not made by repair(): it has no field data array RepairMeasure")
    rows = range(names.GetNumberOfValues())
    return {snake(names.GetValue(k)): (before.GetValue(k), after.GetValue(k)) for k in rows}


def _new(algorithm, function):
    if algorithm is None:
        raise SurfaceSynthesisError(f"{function} needs CGAL, which this package was built without")
    return algorithm()


def _processed(algorithm, mesh, progress):
    """The output of a filter that makes a surface of a surface, in the form in which the surface was given."""
    progress_callback(progress)
    output, remarks = apply_filter(algorithm, given_dataset(mesh), progress)
    for text in remarks:
        warnings.warn(text, SurfaceSynthesisWarning, stacklevel=3)
    if isinstance(mesh, (tuple, list)):
        polygons = from_polydata(output)
        return polygons.points, polygons.connectivity.reshape(-1, 3)
    return as_type_of(mesh, output)
