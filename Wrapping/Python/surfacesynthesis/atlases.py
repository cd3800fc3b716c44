# SPDX-License-Identifier: BSD-3-Clause
"""Texture atlases: a function around vtkTextureAtlasFilter."""

import numbers

from vtkmodules.util.numpy_support import vtk_to_numpy

from .arguments import in_range, integer, progress_callback
from .datasets import as_type_of, given_dataset
from .errors import SurfaceSynthesisError
from .files.polygons import from_polydata
from .pipeline import apply_filter

try:
    from .vtkSurfaceSynthesisMeshing import vtkTextureAtlasFilter
except ImportError:  # built without CGAL
    vtkTextureAtlasFilter = None


def texture_atlas(mesh, resolution=1024, margin=4, maximum_stretch=2.0, progress=None):
    """Gives a surface texture coordinates: charts of little stretch, packed into one image without overlaps.

    Charts by variational shape approximation (Cohen-Steiner et al., "Variational shape approximation", 2004), flattened by
    least squares conformal maps (Lévy et al., "Least squares conformal maps for automatic texture atlas generation", 2002).

    Parameters
    ----------
    mesh : vtkPolyData, composite dataset (vtkDataObjectTree) or pair (points, triangles)
        Triangles, polygons or strips with finite points, no degenerate triangle, manifold edges and points, and
        consistent winding; repair() makes such a surface. The mesh is never modified.
    resolution : int or pair of int
        Width and height of the image that the charts are packed for, in texels, each from 16 to 32768; one number for
        both. Default 1024.
    margin : int
        Least distance of two charts, in texels, from 1 to 256. Default 4.
    maximum_stretch : float
        Largest stretch of a triangle, from 1.01 to 100; a smaller number makes more charts. Default 2.
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the work stops.

    Returns
    -------
    dataset of the type of ``mesh``
        The surface with the active texture coordinates ``TCoords`` (u, v from 0 to 1), the point array ``OriginalPoint``
        and the cell array ``Chart``. Its points are those of the mesh, followed by copies of points at which charts meet.
        Polygons that the border of a chart crosses become triangles, as do strips. The field arrays ``NumberOfCharts``,
        ``Coverage``, ``RootMeanStretch``, ``LargestStretch`` and ``TexelsPerLength`` describe the atlas.
    triple of numpy.ndarray, for a pair
        points [V', 3], triangles [F, 3] int64, texture coordinates [V', 2] float64.

    Raises
    ------
    SurfaceSynthesisError
        The mesh has a defect: the text names it, the first cell or point, and the filter that repairs it. The charts do
        not fit into the image with their margins. Also when the package was built without CGAL.
    Cancelled
        ``progress`` returned False.
    ValueError, TypeError
        An argument has a value out of its range, or is of a wrong type.
    """
    algorithm = configured_atlas(resolution, margin, maximum_stretch)
    progress_callback(progress)
    output, _ = apply_filter(algorithm, given_dataset(mesh), progress)
    if isinstance(mesh, (tuple, list)):
        polygons = from_polydata(output)
        coordinates = vtk_to_numpy(output.GetPointData().GetTCoords())
        return polygons.points, polygons.connectivity.reshape(-1, 3), coordinates
    return as_type_of(mesh, output)


def configured_atlas(resolution=1024, margin=4, maximum_stretch=2.0):
    """A vtkTextureAtlasFilter with the parameters of texture_atlas(), which raises TypeError and ValueError."""
    if vtkTextureAtlasFilter is None:
        raise SurfaceSynthesisError("texture_atlas() needs CGAL, which this package was built without")
    algorithm = vtkTextureAtlasFilter()
    algorithm.SetResolution(*image_size(resolution, 16))
    algorithm.SetMargin(integer("margin", margin, 1, 256))
    algorithm.SetMaximumStretch(in_range("maximum_stretch", maximum_stretch, 1.01, 100.0))
    return algorithm


def image_size(resolution, smallest):
    """Width and height of an image, from ``smallest`` to 32768: a pair of integers, or one for both."""
    sizes = [resolution, resolution] if isinstance(resolution, numbers.Integral) else resolution
    if not isinstance(sizes, (tuple, list)) or len(sizes) != 2:
        raise TypeError("resolution must be an integer, or a pair of them: width and height")
    width, height = (integer("resolution", size, smallest, 32768) for size in sizes)
    return width, height
