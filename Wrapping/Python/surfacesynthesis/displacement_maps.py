# SPDX-License-Identifier: BSD-3-Clause
"""Displacement maps and height maps for renderers: a function around vtkDisplacementMapFilter, and files of its images."""

import contextlib
import os
import shutil
import warnings

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPolyData
from vtkmodules.vtkIOImage import vtkPNGWriter, vtkTIFFWriter
from vtkmodules.vtkIOXML import vtkXMLImageDataWriter

from . import files
from .arguments import choice, integer, positive, progress_callback
from .datasets import given_dataset
from .errors import SurfaceSynthesisWarning
from .pipeline import apply_filter
from .results import MappingResult, html_table, shown
from .vtkSurfaceSynthesisMeshing import vtkDisplacementMapFilter

#: Axes of the vectors of a displacement map, by the name that ``vector_space`` takes.
VECTOR_SPACES = {"object": vtkDisplacementMapFilter.OBJECT, "tangent": vtkDisplacementMapFilter.TANGENT}
#: Places of the detailed surface to which vectors go, by the name that ``correspondence`` takes.
CORRESPONDENCES = {"automatic": vtkDisplacementMapFilter.AUTOMATIC, "normals": vtkDisplacementMapFilter.NORMALS}
#: Files of displacement_map(), by extension: heights, vectors, all.
MAP_FILES = (".png", ".tif", ".tiff", ".vti")

_LEAST_RESOLUTION, _MOST_RESOLUTION = 16, 16384


def displacement_map(
    mesh,
    detailed,
    resolution=1024,
    gutter_width=8,
    vector_space="object",
    correspondence="automatic",
    maximum_distance=None,
    progress=None,
):
    """Bakes the difference of a plain and a detailed surface into a displacement map and a height map for renderers.

    Parameters
    ----------
    mesh : vtkPolyData
        The plain surface, with active texture coordinates at its points within [0, 1], as texture_atlas() makes them.
        Triangles, polygons or strips with finite points and no degenerate triangle. Never modified.
    detailed : vtkPolyData or pair (points, triangles)
        The detailed surface near the plain one, with finite points, as geometric_texture() makes it. Never modified.
    resolution : int or pair of ints
        Width and height of the images, texels, 16 to 16384 each. Default 1024.
    gutter_width : int
        Distance from the charts up to which texels outside are filled, texels, 0 to 16384, or -1 for the whole image.
        Default 8.
    vector_space : str
        Axes of the vectors: "object", x, y and z of the points; "tangent", tangent, normal and bitangent of the surface, in
        this order, that of Blender's node Vector Displacement. Default "object".
    correspondence : str
        Places of the detailed surface to which the vectors go: "automatic", the same places where it is a subdivision of the
        plain one at midpoints, else "normals", along the normals. Default "automatic".
    maximum_distance : float, optional
        Largest distance along the normal, either side, at which the detailed surface is looked for, world units. Default: a
        tenth of the diagonal of the plain surface's box.
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the work stops.

    Returns
    -------
    DisplacementMap
        The images, with methods that write them, and a mapping with what is known about them.

    Raises
    ------
    SurfaceSynthesisError
        A surface is empty or has points that are not finite; the plain one has no texture coordinates, or degenerate
        triangles.
    Cancelled
        ``progress`` returned False.
    ValueError, TypeError
        An argument has a value out of its range or is of a wrong type.
    """
    progress_callback(progress)
    algorithm = configured_filter(resolution, gutter_width, vector_space, correspondence, maximum_distance)
    given = given_dataset(mesh, (vtkPolyData,), "a vtkPolyData with texture coordinates")
    other = given_dataset(detailed, (vtkPolyData,), "a vtkPolyData or a pair of arrays (points, triangles)")
    algorithm.SetInputDataObject(1, other)
    output, remarks = apply_filter(algorithm, given, progress)
    for text in remarks:
        warnings.warn(text, SurfaceSynthesisWarning, stacklevel=2)
    return map_of(algorithm, output)


def configured_filter(
    resolution=1024, gutter_width=8, vector_space="object", correspondence="automatic", maximum_distance=None
):
    """A vtkDisplacementMapFilter with the parameters of displacement_map(), which raises TypeError and ValueError."""
    algorithm = vtkDisplacementMapFilter()
    sizes = tuple(resolution) if isinstance(resolution, (tuple, list, np.ndarray)) else (resolution, resolution)
    if len(sizes) != 2:
        raise ValueError(f"resolution must be one number or two, not {len(sizes)}")
    sizes = [integer("resolution", size, _LEAST_RESOLUTION, _MOST_RESOLUTION) for size in sizes]
    algorithm.SetResolution(*sizes)
    algorithm.SetGutterWidth(integer("gutter_width", gutter_width, -1, _MOST_RESOLUTION))
    algorithm.SetVectorSpace(choice("vector_space", vector_space, VECTOR_SPACES))
    algorithm.SetCorrespondence(choice("correspondence", correspondence, CORRESPONDENCES))
    if maximum_distance is not None:
        algorithm.SetMaximumDistance(positive("maximum_distance", maximum_distance))
    return algorithm


def map_of(algorithm, output):
    """The result of displacement_map(), from a filter that has run."""
    image = vtkImageData()
    image.ShallowCopy(output)
    names = ("SubdivisionLevels", "CoveredTexels", "Misses", "MeanMiss", "LargestMiss", "HeightMidlevel", "HeightScale")
    values = {name: getattr(algorithm, "Get" + name)() for name in names}
    return DisplacementMap(image, values)


class DisplacementMap(MappingResult):
    """Images of the difference of two surfaces, and what is known about them.

    A mapping: ``subdivision_levels``, number of subdivisions by which vectors go to the same places of the detailed surface,
    -1 where they go along normals; ``covered_texels``, texels whose centers lie in triangles; ``misses``, those of them whose
    normal meets nothing; ``mean_miss`` and ``largest_miss``, distances from the ends of their heights to the closest places,
    world units; ``height_midlevel`` and ``height_scale``: heights are (value - midlevel) scale in the PNG file, with values
    from 0 to 1.

    ``image`` is the vtkImageData of the class, row 0 at v = 0. ``height`` [H, W] float32, ``displacement`` [H, W, 3] float32
    and ``coverage`` [H, W] bool are arrays with the top row first, as programs for images have it.
    """

    _NAMES = {
        "subdivision_levels": "SubdivisionLevels",
        "covered_texels": "CoveredTexels",
        "misses": "Misses",
        "mean_miss": "MeanMiss",
        "largest_miss": "LargestMiss",
        "height_midlevel": "HeightMidlevel",
        "height_scale": "HeightScale",
    }

    def __init__(self, image, values):
        self.image = image
        self._values = {name: values[getter] for name, getter in self._NAMES.items()}

    def _rows(self, name):
        width, height, _ = self.image.GetDimensions()
        array = self.image.GetPointData().GetArray(name)
        if array is None:
            return np.zeros((0, 0))
        values = vtk_to_numpy(array)
        return values.reshape(height, width, *values.shape[1:])[::-1]

    @property
    def height(self):
        """Distances along the normals, world units."""
        return self._rows("Height")

    @property
    def displacement(self):
        """Vectors to the detailed surface, world units."""
        return self._rows("Displacement")

    @property
    def coverage(self):
        """True for texels whose centers lie in triangles."""
        return self._rows("Coverage") > 0

    def write(self, *paths):
        """Writes one or several files; none appears unless all could be written, and files of these names are replaced.

        Parameters
        ----------
        paths : path
            .png, the heights in 16 bits: (value / 65535 - height_midlevel) height_scale; .tif or .tiff, the vectors in 32-bit
            floating-point numbers, RGB; .vti, all arrays, for VTK and ParaView.

        Raises
        ------
        ValueError
            Another extension, or there are no images, as of empty surfaces.
        OSError
            A file cannot be written.
        """
        paths = [os.path.realpath(path) for path in paths]
        for path in paths:
            map_extension(path)
            if self.image.GetNumberOfPoints() == 0:
                raise ValueError(f"{path}: there are no images of empty surfaces")
        folders = []
        try:
            moves = []
            for path in paths:
                folders.append(files.temporary_folder(os.path.dirname(path)))
                moves.append((os.path.join(folders[-1], os.path.basename(path)), path))
                self._write_one(*moves[-1])
            for temporary, path in moves:
                os.replace(temporary, path)
        finally:
            for folder in folders:
                with contextlib.suppress(OSError):
                    shutil.rmtree(folder)

    def _write_one(self, temporary, path):
        kind = map_extension(path)
        if kind == ".vti":
            writer, image = vtkXMLImageDataWriter(), self.image
        elif kind == ".png":
            values = self["height_midlevel"] + vtk_to_numpy(self.image.GetPointData().GetArray("Height")) / self["height_scale"]
            heights = np.rint(65535.0 * np.clip(values.astype(np.float64), 0.0, 1.0)).astype(np.uint16)
            writer, image = vtkPNGWriter(), self._picture(numpy_to_vtk(heights, deep=True))
        else:
            writer, image = vtkTIFFWriter(), self._picture(self.image.GetPointData().GetArray("Displacement"))
            writer.SetCompressionToNoCompression()
        writer.SetInputData(image)
        writer.SetFileName(temporary)
        writer.Write()
        if writer.GetErrorCode() != 0 or not os.path.exists(temporary):
            raise OSError(f"{path}: the image cannot be written")

    def _picture(self, scalars):
        picture = vtkImageData()
        picture.SetDimensions(self.image.GetDimensions())
        picture.GetPointData().SetScalars(scalars)
        return picture

    def to_dict(self):
        """The values, as to_json() writes them."""
        return {**self._values, "units": "world units of the surfaces"}

    def __str__(self):
        places = f"same places of {self['subdivision_levels']} subdivisions"
        lines = [
            f"vectors: {places if self['subdivision_levels'] >= 0 else 'along normals'}",
            f"height = (value - {self['height_midlevel']:.9g}) * {self['height_scale']:.9g}, value from 0 to 1",
            f"{self['covered_texels']:,} texels, {self['misses']:,} of them missed by "
            f"{self['mean_miss']:.3g} on average, {self['largest_miss']:.3g} at most",
        ]
        return "\n".join(lines)

    def __repr__(self):
        return "<DisplacementMap: " + ", ".join(f"{name} {shown(value)}" for name, value in self.items()) + ">"

    def _repr_html_(self):
        return html_table([[name.replace("_", " "), value] for name, value in self.items()])


def map_extension(path):
    """The extension of a file of a displacement map; raises ValueError for another one."""
    kind = os.path.splitext(os.fspath(path))[1].lower()
    if kind not in MAP_FILES:
        raise ValueError(f"{os.fspath(path)}: displacement maps are written to {', '.join(MAP_FILES)}")
    return kind
