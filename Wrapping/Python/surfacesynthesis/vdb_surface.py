# SPDX-License-Identifier: BSD-3-Clause
"""Closed surfaces of volumes and of messy surfaces: a function around vtkVDBSurfaceFilter."""

import warnings

from vtkmodules.vtkCommonDataModel import vtkDataObject, vtkDataObjectTree, vtkImageData, vtkPolyData

from .arguments import (
    array_name,
    at_least_0,
    at_most,
    choice,
    finite,
    flag,
    integer,
    positive,
    progress_callback,
)
from .datasets import as_type_of, given_dataset
from .errors import SurfaceSynthesisError, SurfaceSynthesisWarning
from .files.polygons import from_polydata
from .files.volumes import cells_as_points
from .pipeline import apply_filter

try:
    from .vtkSurfaceSynthesisMeshing import vtkVDBSurfaceFilter
except ImportError:
    vtkVDBSurfaceFilter = None  # built without OpenVDB

#: The sides of the isovalue and the kinds of smoothing, by the names that the arguments take.
INSIDE = {"above": 0, "below": 1}
SMOOTHING = {"none": 0, "gaussian": 1, "mean_curvature": 2, "median": 3, "laplacian": 4}

_INPUTS = (vtkImageData, vtkPolyData, vtkDataObjectTree)
_INPUTS_TEXT = "a vtkImageData, a vtkPolyData, a composite dataset or a pair of arrays (points, triangles)"


def vdb_surface(
    volume,
    iso_value=None,
    inside="above",
    voxel_size=None,
    closing=0.0,
    smoothing="none",
    smoothing_iterations=3,
    offset=0.0,
    adaptivity=0.0,
    fill_cavities=False,
    largest_component=False,
    maximum_voxels=200_000_000,
    array=None,
    progress=None,
):
    """Makes a closed manifold surface of a volume, or of any surface however broken, through OpenVDB's level sets.

    The result is closed, manifold in edges and points, wound outwards, without degenerate triangles, and in world
    coordinates. It has the same bits for every number of threads.

    Parameters
    ----------
    volume : vtkImageData, vtkPolyData, composite dataset (vtkDataObjectTree) or pair (points, triangles)
        An image with any origin, spacing, orthogonal direction and scalar type: solid is what lies on one side of the
        isovalue; where it reaches the border it is capped half a sample beyond the outermost samples; NaN is outside. Or
        a surface with holes, self-intersections, non-manifold edges, wrong winding: solid is what it encloses, and open
        sheets become plates two voxels thick. Never modified.
    iso_value : float, optional
        The value of the image on the surface, within its values; not for a surface. Default: Otsu's threshold of the
        histogram, with a warning for labels.
    inside : str
        The solid side of the isovalue: "above" (default) or "below".
    voxel_size : float, optional
        Side of the voxels of the level set, world units, larger than 0 and at most the longest side of the surface, or of
        the solid in an image: the size of the smallest features that stay, and of the triangles. Default: the smallest
        spacing of an image, 1/128 of the longest side of a surface.
    closing : float
        Radius of a morphological closing, world units: gaps and holes narrower than twice this are filled. Default 0.
    smoothing : str
        "none" (default), "gaussian" (standard deviation 1.6 voxels; strong), "mean_curvature", "median" (slow) or
        "laplacian".
    smoothing_iterations : int
        Number of times that smoothing is applied, from 0 to 1000. Default 3.
    offset : float
        Distance by which the surface is moved outwards, world units; negative moves it inwards. Default 0.
    adaptivity : float
        Size of the triangles in flat regions, from 0 (default: that of the voxels) to 1 (up to eight voxels).
    fill_cavities : bool
        True fills the cavities that the solid encloses. Default False.
    largest_component : bool
        True keeps only the part of the solid with the largest volume. Default False.
    maximum_voxels : int
        Number of voxels along the surface beyond which an error names a voxel size that fits; at least 1000. Moving the
        surface by ``offset`` may visit each ten times.
    array : str, optional
        Name of the point array of the image to use, or of the cell array, whose values then lie at the centers of the
        cells. Default: its active scalars, those of the points first.
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the work stops.

    Returns
    -------
    vtkPolyData, or a composite dataset of them
        The surface. Point arrays of a surface are interpolated from the nearest place on it, other point arrays of an
        image from its samples. Empty, with a warning that names the range of the data, when nothing lies inside.
    pair of numpy.ndarray, for a pair
        Points [V, 3] float64 and triangles [F, 3] int64.

    Raises
    ------
    SurfaceSynthesisError
        The surface could not be made, or the package was built without OpenVDB.
    Cancelled
        ``progress`` returned False.
    ValueError, TypeError
        An argument has a value out of its range, or is of a wrong type.
    """
    surface = configured_filter(
        iso_value=iso_value,
        inside=inside,
        voxel_size=voxel_size,
        closing=closing,
        smoothing=smoothing,
        smoothing_iterations=smoothing_iterations,
        offset=offset,
        adaptivity=adaptivity,
        fill_cavities=fill_cavities,
        largest_component=largest_component,
        maximum_voxels=maximum_voxels,
        array=array,
    )
    progress_callback(progress)
    given = given_dataset(volume, _INPUTS, _INPUTS_TEXT)
    if isinstance(given, vtkImageData):
        given = _with_values_at_points(given, array)
    elif iso_value is not None and given.IsA("vtkPolyData"):
        raise ValueError("iso_value is a value of a volume, and the input is a surface")
    output, remarks = apply_filter(surface, given, progress)
    for text in remarks:
        warnings.warn(text, SurfaceSynthesisWarning, stacklevel=2)
    if isinstance(volume, (tuple, list)):
        mesh = from_polydata(output)
        return mesh.points.astype(float), mesh.connectivity.reshape(-1, 3)
    return as_type_of(volume, output)


def _with_values_at_points(image, array):
    """The image, or its cells as points when ``array`` is one of cells, or no name is given and only the cells have any."""
    points, cells = image.GetPointData(), image.GetCellData()
    if array is None:
        return cells_as_points(image) if points.GetNumberOfArrays() == 0 and cells.GetScalars() is not None else image
    return cells_as_points(image) if not points.HasArray(str(array)) and cells.HasArray(str(array)) else image


def configured_filter(
    iso_value=None,
    inside="above",
    voxel_size=None,
    closing=0.0,
    smoothing="none",
    smoothing_iterations=3,
    offset=0.0,
    adaptivity=0.0,
    fill_cavities=False,
    largest_component=False,
    maximum_voxels=200_000_000,
    array=None,
):
    """A vtkVDBSurfaceFilter with the parameters of vdb_surface(), which raises TypeError and ValueError."""
    if vtkVDBSurfaceFilter is None:
        raise SurfaceSynthesisError("this build of surfacesynthesis has no OpenVDB, which makes surfaces of volumes")
    surface = vtkVDBSurfaceFilter()
    if iso_value is not None:
        surface.ComputeIsoValueOff()
        surface.SetIsoValue(finite("iso_value", iso_value))
    surface.SetInsideRule(choice("inside", inside, INSIDE))
    if voxel_size is not None:
        surface.SetVoxelSize(positive("voxel_size", voxel_size))
    surface.SetClosing(at_least_0("closing", closing))
    surface.SetSmoothing(choice("smoothing", smoothing, SMOOTHING))
    iterations = integer("smoothing_iterations", smoothing_iterations, 0)
    surface.SetSmoothingIterations(at_most("smoothing_iterations", iterations, 1000))
    surface.SetOffset(finite("offset", offset))
    surface.SetAdaptivity(at_most("adaptivity", at_least_0("adaptivity", adaptivity), 1))
    surface.SetFillCavities(flag("fill_cavities", fill_cavities))
    surface.SetLargestComponent(flag("largest_component", largest_component))
    surface.SetMaximumNumberOfVoxels(integer("maximum_voxels", maximum_voxels, 1000))
    if array is not None:
        surface.SetInputArrayToProcess(0, 0, 0, vtkDataObject.FIELD_ASSOCIATION_POINTS, array_name("array", array))
    return surface
