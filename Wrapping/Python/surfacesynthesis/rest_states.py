# SPDX-License-Identifier: BSD-3-Clause
"""Rest states of a soft body: functions around vtkElasticRestFilter."""

import math
import warnings

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import (
    vtkDataObjectTree,
    vtkMultiBlockDataSet,
    vtkPointSet,
    vtkPolyData,
    vtkUnstructuredGrid,
)

from .arguments import INT_MAX, INT_MIN, flag, in_range, integer, progress_callback
from .datasets import given_dataset
from .errors import SurfaceSynthesisError, SurfaceSynthesisWarning
from .pipeline import apply_filter
from .sampling import checked_range, in_parts, positions_of_blocks
from .vtkSurfaceSynthesisEnsembles import vtkElasticRestFilter

BODIES = (vtkPolyData, vtkUnstructuredGrid, vtkDataObjectTree)
BODY_TEXT = (
    "a closed vtkPolyData, a vtkUnstructuredGrid of tetrahedra, a composite dataset of them, or a pair of arrays (points, triangles)"
)


def rest_states(
    mesh,
    samples,
    seed=0,
    first_sample=0,
    tetrahedra=None,
    surface_points=500,
    length_unit=None,
    youngs_modulus=1e4,
    poissons_ratio=0.4,
    density=1e3,
    friction=0.5,
    gravity=9.81,
    damping=0.5,
    drop_height=0.1,
    minimum_spin=math.pi,
    maximum_spin=3.0 * math.pi,
    random_orientation=True,
    align=True,
    self_contact=True,
    up_direction=(0.0, 0.0, 1.0),
    time_step=0.04,
    maximum_time=10.0,
    progress=None,
    memory_limit=None,
):
    """Shapes in which a soft body comes to rest after random drops on a floor.

    The body is of linear tetrahedra with a stable neo-Hookean material; contact with the floor is a logarithmic barrier with
    friction. In a rest state forces are in balance to half a thousandth of the weight, no tetrahedron is turned over and no
    node is below the floor, which is at the lowest point of the mesh. The same seed gives the same bits for every number of
    threads, and sample k is the same alone or in a batch.

    Parameters
    ----------
    mesh : vtkPolyData, vtkUnstructuredGrid, composite dataset of them, or pair (points, triangles)
        A closed surface, manifold, with consistent winding and without self-intersections; or tetrahedra. Each block of a
        composite dataset is dropped by itself, in ways of its own. Never modified.
    samples : int
        Number of drops, at least 1.
    seed : int
        Any integer of 32 bits with sign; each gives other drops. Default 0.
    first_sample : int
        Index of the first sample, at least 0: an ensemble may be made in parts. Default 0.
    tetrahedra : vtkUnstructuredGrid, optional
        Tetrahedra around the surface, which are simulated in place of those made here; tetrahedralize() makes some.
    surface_points : int
        Number of points to which the surface is remeshed before it is filled, at least 0; 0 fills it as it is. Default 500.
    length_unit : float, optional
        Length of a unit of the mesh in meters, larger than 0: 0.001 for millimeters. Default: the diagonal of the box is
        half a meter.
    youngs_modulus : float
        Young's modulus, pascals, from 0.001 to 1e15. Default 10000.
    poissons_ratio : float
        Poisson's ratio, from 0 to 0.495. Default 0.4.
    density : float
        Density, kilograms per cubic meter, from 1e-6 to 1e9. Default 1000.
    friction : float
        Coefficient of friction on the floor, from 0 to 100. Default 0.5.
    gravity : float
        Acceleration of gravity, meters per square second, from 0.001 to 1e6. Default 9.81.
    damping : float
        Loss of momentum by the air, per second, from 0 to 1e6. Default 0.5.
    drop_height : float
        Height above the floor at the beginning, meters, from 0 to 1e6. Default 0.1.
    minimum_spin, maximum_spin : float
        Bounds of the angular speed at the beginning, radians per second, from 0 to 1e4. Defaults pi and 3 pi.
    random_orientation : bool
        Whether the orientation at the beginning is random; else it is that of the mesh. Default True.
    align : bool
        Whether rest states are turned about the vertical so that their long axis is that of the mesh. Default True.
    self_contact : bool
        Whether points of the body are kept from passing through its triangles. Default True.
    up_direction : sequence of three floats
        Direction upwards, of any length but 0. Default (0, 0, 1).
    time_step : float
        Largest time step, seconds, from 0.0001 to 1. Default 0.04.
    maximum_time : float
        Simulated time after which a body that still moves creeps to its equilibrium, seconds, from 0 to 1e6. Default 10.
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the work stops.
    memory_limit : int, optional
        Memory that the samples may take, MiB. More samples than fit raise an error before the work begins, whose text
        names a number that fits. Default: three quarters of the memory of the machine.

    Returns
    -------
    numpy.ndarray or composite dataset
        The positions of the points in each rest state, [N, V, 3] float64, or float32 where the points of the mesh are.
        For a composite dataset, one of its class instead, with a vtkMultiBlockDataSet of rest states in the place of each
        block, which GetPartitionAsDataObject() of a vtkPartitionedDataSet gives.

    Raises
    ------
    SurfaceSynthesisError
        The mesh cannot be filled with tetrahedra, or a drop does not come to rest: then the text names the sample.
    Cancelled
        ``progress`` returned False.
    ValueError, TypeError
        An argument has a value out of its range, or is of a wrong type.
    """
    algorithm = configured_rest_states(
        seed=seed,
        tetrahedra=tetrahedra,
        surface_points=surface_points,
        length_unit=length_unit,
        youngs_modulus=youngs_modulus,
        poissons_ratio=poissons_ratio,
        density=density,
        friction=friction,
        gravity=gravity,
        damping=damping,
        drop_height=drop_height,
        minimum_spin=minimum_spin,
        maximum_spin=maximum_spin,
        random_orientation=random_orientation,
        align=align,
        self_contact=self_contact,
        up_direction=up_direction,
        time_step=time_step,
        maximum_time=maximum_time,
    )
    dataset = given_dataset(mesh, BODIES, BODY_TEXT)
    if isinstance(dataset, vtkDataObjectTree):
        samples, first_sample = checked_range(samples, first_sample)
        algorithm.SetNumberOfSamples(samples)
        algorithm.SetFirstSample(first_sample)
        _limit_memory(algorithm, memory_limit)
        return _output_of(algorithm, dataset, progress)
    parts = in_parts(algorithm, dataset, samples, first_sample, progress_callback(progress), 24, memory_limit)
    return np.concatenate([positions_of_blocks(output, "a body") for output in parts])


def settle(
    mesh,
    shapes,
    tetrahedra=None,
    surface_points=500,
    length_unit=None,
    youngs_modulus=1e4,
    poissons_ratio=0.4,
    density=1e3,
    friction=0.5,
    gravity=9.81,
    align=True,
    self_contact=True,
    up_direction=(0.0, 0.0, 1.0),
    progress=None,
    memory_limit=None,
):
    """Rest states of a soft body next to given shapes, such as samples of a model.

    The body is laid next to each shape, drawn into it by springs, which end where the floor or the body itself is in the
    way, and let go: it creeps to the next equilibrium. What rest_states() promises holds. Unless ``align`` is False, the result
    is turned about the vertical as the mesh lies, and centered on it.

    Parameters
    ----------
    mesh : vtkPolyData, vtkUnstructuredGrid, composite dataset of them, or pair (points, triangles)
        A closed surface, manifold, with consistent winding and without self-intersections; or tetrahedra. Never modified.
    shapes : array [N, V, 3] or [V, 3], composite dataset, dataset, or list of arrays [V, 3] or datasets
        Positions of the points of ``mesh``, or copies of it with moved points, as deform() makes them, of about its size.
        Their height does not matter. For a composite ``mesh``, a composite dataset with the shapes of each block in its place.
    tetrahedra : vtkUnstructuredGrid, optional
        Tetrahedra around the surface, which are simulated in place of those made here.
    surface_points : int
        Number of points to which a surface is remeshed for the simulation; 0 for the surface as it is. Default 500.
    length_unit : float, optional
        Meters in a unit of the mesh. Default: that with which the diagonal of its box is half a meter.
    youngs_modulus : float
        Young's modulus, pascals, from 0.001 to 1e15. Default 10000.
    poissons_ratio : float
        Poisson's ratio, from 0 to 0.495. Default 0.4.
    density : float
        Density, kilograms per cubic meter, from 1e-6 to 1e9. Default 1000.
    friction : float
        Coefficient of friction on the floor, from 0 to 100. Default 0.5.
    gravity : float
        Acceleration of gravity, meters per square second, from 0.001 to 1e6. Default 9.81.
    align : bool
        Whether rest states are turned about the vertical so that their long axis is that of the mesh. Default True.
    self_contact : bool
        Whether points of the body are kept from passing through its triangles. Default True.
    up_direction : sequence of three floats
        Direction upwards, of any length but 0. Default (0, 0, 1).
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the work stops.
    memory_limit : int, optional
        Memory that the rest states may take, MiB. Default: three quarters of the memory of the machine.

    Returns
    -------
    numpy.ndarray or composite dataset
        The positions of the points in each rest state, [N, V, 3] float64, or float32 where the points of the mesh are.
        For a composite dataset, one of its class instead, with a vtkMultiBlockDataSet of rest states in the place of each
        block, which GetPartitionAsDataObject() of a vtkPartitionedDataSet gives.

    Raises
    ------
    SurfaceSynthesisError
        The mesh cannot be filled with tetrahedra, a shape has other points, or a rest state is not found: then the text
        names the sample.
    Cancelled
        ``progress`` returned False.
    ValueError, TypeError
        An argument has a value out of its range, or is of a wrong type.
    """
    algorithm = configured_rest_states(
        tetrahedra=tetrahedra,
        surface_points=surface_points,
        length_unit=length_unit,
        youngs_modulus=youngs_modulus,
        poissons_ratio=poissons_ratio,
        density=density,
        friction=friction,
        gravity=gravity,
        align=align,
        self_contact=self_contact,
        up_direction=up_direction,
    )
    _limit_memory(algorithm, memory_limit)
    dataset = given_dataset(mesh, BODIES, BODY_TEXT)
    algorithm.SetShapesData(shapes_of(shapes, dataset))
    output = _output_of(algorithm, dataset, progress)
    return output if isinstance(dataset, vtkDataObjectTree) else positions_of_blocks(output, "a body")


def _limit_memory(algorithm, memory_limit):
    """Sets the MemoryLimit of a filter where there is one; raises TypeError and ValueError."""
    if memory_limit is not None:
        algorithm.SetMemoryLimit(integer("memory_limit", memory_limit, 1, INT_MAX))


def _output_of(algorithm, dataset, progress):
    """The output of the filter of rest_states() and settle(), whose caller gets its warnings."""
    if dataset.GetNumberOfPoints() == 0:
        raise SurfaceSynthesisError("the mesh is empty; a body is needed")
    output, remarks = apply_filter(algorithm, dataset, progress_callback(progress))
    for text in remarks:
        warnings.warn(text, SurfaceSynthesisWarning, stacklevel=3)
    return output


def shapes_of(shapes, mesh):
    """The dataset of the argument ``shapes`` of settle(); raises TypeError and ValueError."""
    if isinstance(mesh, vtkDataObjectTree) and not isinstance(shapes, vtkDataObjectTree):
        raise TypeError(f"shapes of a composite mesh must be a composite dataset, not {type(shapes).__name__}")
    if isinstance(shapes, (vtkPointSet, vtkDataObjectTree)):
        return _copy_of(shapes)
    if isinstance(shapes, np.ndarray) and shapes.ndim == 2:
        shapes = shapes[None]
    if not isinstance(shapes, (np.ndarray, tuple, list)):
        raise TypeError(f"shapes must be {_SHAPES}, not {type(shapes).__name__}")
    if len(shapes) == 0:
        raise ValueError(f"shapes must be {_SHAPES}, with one shape at least")
    blocks = vtkMultiBlockDataSet()
    for number, shape in enumerate(shapes):
        blocks.SetBlock(number, _copy_of(shape) if isinstance(shape, vtkPointSet) else _moved(mesh, shape))
    return blocks


_SHAPES = "positions [N, V, 3] of the points of mesh, copies of mesh with moved points, or a list of them"


def _moved(mesh, positions):
    """A dataset with these points."""
    expected = [mesh.GetNumberOfPoints(), 3]
    if not isinstance(positions, np.ndarray) or positions.dtype.kind not in "fiu":
        raise TypeError(f"shapes must be {_SHAPES}, not a list of {type(positions).__name__}")
    if list(positions.shape) != expected:
        raise ValueError(f"shapes must be positions of {expected[0]} points, {expected}, not {list(positions.shape)}")
    points = vtkPoints()
    points.SetData(numpy_to_vtk(np.ascontiguousarray(positions, dtype=np.float64), deep=True))
    moved = mesh.NewInstance()
    moved.SetPoints(points)
    return moved


def _copy_of(shape):
    """Copy to which pipelines may attach what they leave on their inputs."""
    copy = shape.NewInstance()
    copy.ShallowCopy(shape)
    return copy


def configured_rest_states(
    seed=0,
    tetrahedra=None,
    surface_points=500,
    length_unit=None,
    youngs_modulus=1e4,
    poissons_ratio=0.4,
    density=1e3,
    friction=0.5,
    gravity=9.81,
    damping=0.5,
    drop_height=0.1,
    minimum_spin=math.pi,
    maximum_spin=3.0 * math.pi,
    random_orientation=True,
    align=True,
    self_contact=True,
    up_direction=(0.0, 0.0, 1.0),
    time_step=0.04,
    maximum_time=10.0,
):
    """A vtkElasticRestFilter with the parameters of rest_states(), which raises TypeError and ValueError."""
    algorithm = vtkElasticRestFilter()
    algorithm.SetSeed(integer("seed", seed, INT_MIN))
    algorithm.SetNumberOfSurfacePoints(integer("surface_points", surface_points, 0, INT_MAX))
    if length_unit is not None:
        algorithm.SetLengthUnit(in_range("length_unit", length_unit, 1e-30, 1e30))
    algorithm.SetYoungsModulus(in_range("youngs_modulus", youngs_modulus, 1e-3, 1e15))
    algorithm.SetPoissonsRatio(in_range("poissons_ratio", poissons_ratio, 0.0, 0.495))
    algorithm.SetDensity(in_range("density", density, 1e-6, 1e9))
    algorithm.SetFriction(in_range("friction", friction, 0.0, 100.0))
    algorithm.SetGravity(in_range("gravity", gravity, 1e-3, 1e6))
    algorithm.SetDamping(in_range("damping", damping, 0.0, 1e6))
    algorithm.SetDropHeight(in_range("drop_height", drop_height, 0.0, 1e6))
    algorithm.SetMinimumSpin(in_range("minimum_spin", minimum_spin, 0.0, 1e4))
    algorithm.SetMaximumSpin(in_range("maximum_spin", maximum_spin, minimum_spin, 1e4))
    algorithm.SetRandomOrientation(flag("random_orientation", random_orientation))
    algorithm.SetAlign(flag("align", align))
    algorithm.SetSelfContact(flag("self_contact", self_contact))
    algorithm.SetUpDirection(*_direction(up_direction))
    algorithm.SetTimeStep(in_range("time_step", time_step, 1e-4, 1.0))
    algorithm.SetMaximumTime(in_range("maximum_time", maximum_time, 0.0, 1e6))
    if tetrahedra is not None:
        grid = vtkUnstructuredGrid()  # what pipelines leave on their inputs goes to this copy
        grid.ShallowCopy(given_dataset(tetrahedra, (vtkUnstructuredGrid,), "a vtkUnstructuredGrid of tetrahedra"))
        algorithm.SetTetrahedraData(grid)
    return algorithm


def _direction(value):
    direction = [float(x) for x in value]
    if len(direction) != 3 or not all(map(math.isfinite, direction)) or not any(direction):
        raise ValueError(f"up_direction must be three finite numbers that are not all 0, not {value!r}")
    return direction
