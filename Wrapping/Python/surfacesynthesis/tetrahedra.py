# SPDX-License-Identifier: BSD-3-Clause
"""Tetrahedra that fill closed surfaces: a function around vtkTetrahedralizeFilter."""

import math
import warnings

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy

from .arguments import array_name, choice, flag, integer, positive, progress_callback, real
from .datasets import given_dataset
from .deprecation import renamed_keywords
from .errors import SurfaceSynthesisWarning
from .pipeline import apply_filter
from .vtkSurfaceSynthesisMeshing import vtkTetrahedralizeFilter

#: The values of ``inner_surfaces``.
INNER_SURFACES = {"regions": vtkTetrahedralizeFilter.REGIONS, "holes": vtkTetrahedralizeFilter.HOLES}


@renamed_keywords(target_edge_length="edge_length")
def tetrahedralize(
    mesh,
    quality_ratio=2.0,
    minimum_dihedral_angle=0.0,
    maximum_volume=None,
    edge_length=None,
    preserve_surface=True,
    inner_surfaces="regions",
    surface_triangles=False,
    time_limit=300.0,
    memory_limit=None,
    region_name="Region",
    surface_name="OnSurface",
    progress=None,
    maximum_tetrahedra=10_000_000,
):
    """Fills closed surfaces with tetrahedra of bounded shape and size, by TetGen in a process of its own.

    Parameters
    ----------
    mesh : vtkPolyData, composite dataset (vtkDataObjectTree) or pair (points, triangles)
        A closed surface with two triangles at every edge and without self-intersection, of any number of parts beside
        and inside each other. A pair is an array of points [V, 3] and an integer array of triangles [F, 3]. The mesh is
        never modified.
    quality_ratio : float, optional
        Largest ratio of a tetrahedron's circumradius to its shortest edge, at least 1; smaller is better shaped and
        more. None for no bound. Default 2. Bounds may be exceeded at the surface, and elsewhere by about a quarter.
    minimum_dihedral_angle : float
        Smallest angle between two faces that is aimed at, degrees from 0 (no bound, the default) to 60; more than about
        18 may never be reached.
    maximum_volume : float, optional
        Largest volume of a tetrahedron, cubic world units. Default: no bound.
    edge_length : float, optional
        The same bound as a length in world units: no tetrahedron is larger than the regular one with such edges.
    preserve_surface : bool
        True keeps the surface as it is as boundary of the tetrahedra, without new points. Default True.
    inner_surfaces : str
        "regions" (the default) fills everything that is enclosed; "holes" leaves the inside of a surface inside another
        one empty, and fills that of one inside that again.
    surface_triangles : bool
        True adds the triangles of the surface as cells of the output, with its cell arrays. Default False.
    time_limit : float, optional
        Seconds that TetGen may take for one surface before it is stopped; None for no limit. Default 300.
    memory_limit : int, optional
        Memory that TetGen may use, MiB. Default: three quarters of that of the machine.
    region_name, surface_name : str
        Names of the cell array that tells by which part of the surface a tetrahedron is enclosed, and of the point array
        that is 1 on the surface. Default "Region" and "OnSurface".
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the work stops.
    maximum_tetrahedra : int
        Limit of the tetrahedra, at least 4. A bound by which more are expected raises an error before the work begins,
        whose text names a bound that fits. Default 10,000,000.

    Returns
    -------
    vtkUnstructuredGrid, or a composite dataset of the type of ``mesh``
        The points of the surface come first, with their arrays unchanged; new points have interpolated values.
    pair (points, tetrahedra) of numpy.ndarray, for a pair
        Points [P, 3] float64, those that triangles use first and in their order, and tetrahedra [T, 4] int64 of positive
        volume.

    Raises
    ------
    SurfaceSynthesisError
        There are no tetrahedra. The text names the defect of the surface, or the failure of TetGen, and a remedy; for
        a composite dataset it holds a line for each bad block.
    Cancelled
        ``progress`` returned False.
    ValueError, TypeError
        An argument has a value out of its range or is of a wrong type.
    """
    algorithm = configured_filter(
        quality_ratio=quality_ratio,
        minimum_dihedral_angle=minimum_dihedral_angle,
        maximum_volume=maximum_volume,
        edge_length=edge_length,
        preserve_surface=preserve_surface,
        inner_surfaces=inner_surfaces,
        surface_triangles=surface_triangles,
        time_limit=time_limit,
        memory_limit=memory_limit,
        region_name=region_name,
        surface_name=surface_name,
        maximum_tetrahedra=maximum_tetrahedra,
    )
    progress_callback(progress)
    is_pair = isinstance(mesh, (tuple, list))
    if is_pair and surface_triangles:
        raise ValueError("surface_triangles has no meaning for a pair of arrays, which returns tetrahedra only")
    output, remarks = apply_filter(algorithm, given_dataset(mesh), progress)
    for text in remarks:
        warnings.warn(text, SurfaceSynthesisWarning, stacklevel=3)
    return _pair(output) if is_pair else output


def configured_filter(
    quality_ratio=2.0,
    minimum_dihedral_angle=0.0,
    maximum_volume=None,
    edge_length=None,
    preserve_surface=True,
    inner_surfaces="regions",
    surface_triangles=False,
    time_limit=300.0,
    memory_limit=None,
    region_name="Region",
    surface_name="OnSurface",
    maximum_tetrahedra=10_000_000,
):
    """A vtkTetrahedralizeFilter with the parameters of tetrahedralize(), which raises TypeError and ValueError."""
    algorithm = vtkTetrahedralizeFilter()
    algorithm.SetQualityRatio(0.0 if quality_ratio is None else _at_least_one("quality_ratio", quality_ratio))
    angle = real("minimum_dihedral_angle", minimum_dihedral_angle)
    if not 0.0 <= angle <= 60.0:
        raise ValueError(f"minimum_dihedral_angle must be from 0 to 60 degrees, not {angle:g}")
    algorithm.SetMinimumDihedralAngle(angle)
    if maximum_volume is not None:
        algorithm.SetMaximumVolume(positive("maximum_volume", maximum_volume))
    if edge_length is not None:
        algorithm.SetTargetEdgeLength(positive("edge_length", edge_length))
    algorithm.SetMaximumNumberOfTetrahedra(integer("maximum_tetrahedra", maximum_tetrahedra, 4))
    algorithm.SetPreserveSurface(flag("preserve_surface", preserve_surface))
    algorithm.SetInnerSurfaces(choice("inner_surfaces", inner_surfaces, INNER_SURFACES))
    algorithm.SetSurfaceTriangles(flag("surface_triangles", surface_triangles))
    algorithm.SetTimeLimit(0.0 if time_limit is None else positive("time_limit", time_limit))
    algorithm.SetMemoryLimit(0 if memory_limit is None else integer("memory_limit", memory_limit, 1))
    algorithm.SetRegionArrayName(array_name("region_name", region_name))
    algorithm.SetSurfaceArrayName(array_name("surface_name", surface_name))
    return algorithm


def _at_least_one(name, value):
    value = real(name, value)
    if not 1.0 <= value < math.inf:
        raise ValueError(f"{name} must be None or a finite number of at least 1, not {value:g}")
    return value


def _pair(grid):
    """Points and tetrahedra of an output, as arrays of their own."""
    if grid.GetNumberOfPoints() == 0:
        return np.zeros((0, 3)), np.zeros((0, 4), dtype=np.int64)
    points = vtk_to_numpy(grid.GetPoints().GetData()).copy()
    tetrahedra = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).astype(np.int64).reshape(-1, 4)
    return points, tetrahedra
