# SPDX-License-Identifier: BSD-3-Clause
"""Census of the features of a geometric texture: a function around vtkGeometricTextureFeatures."""

import math
import warnings

from vtkmodules.vtkCommonDataModel import vtkPolyData

from .arguments import in_range, positive, progress_callback
from .datasets import given_dataset
from .errors import SurfaceSynthesisWarning
from .pipeline import apply_filter
from .results import MappingResult, csv_text, html_table, shown
from .vocabulary import snake
from .vtkSurfaceSynthesisStatistics import vtkGeometricTextureFeatures

_SURFACE_TEXT = "a vtkPolyData or a pair of arrays (points, triangles)"


def geometric_texture_features(
    mesh,
    bare=None,
    reference=None,
    unit_length=None,
    minimum_prominence=None,
    merged_saddle=0.5,
    wall_level=None,
    smoothing_length=None,
    progress=None,
):
    """Counts and measures the peaks, merged peaks, walls and self-intersections of a geometric texture.

    Parameters
    ----------
    mesh : vtkPolyData or pair (points, triangles)
        The surface, with finite points, no degenerate triangle, no edge with more than two triangles and consistent winding. A
        pair is an array of points [V, 3] and an integer array of triangles [F, 3]. Never modified.
    bare : vtkPolyData or pair (points, triangles), optional
        The surface beneath, with the same triangles and as many points; heights are displacements along its normals. Default:
        ``mesh`` without its relief, smoothed over ``smoothing_length``.
    reference : GeometricTextureFeatures, optional
        The features of another surface, that the texture was learned from for instance: ``ratios`` of the result compares with
        them.
    unit_length : float, optional
        Unit of length of the relative densities, world units, larger than 0. Default: mean edge length of the bare surface, as a
        texture is as large as the triangles of its target.
    minimum_prominence : float, optional
        Smallest prominence of a peak, its height over the highest saddle that leads to a higher peak, world units, larger than 0.
        Default: half the standard deviation of the heights; with ``reference`` as many unit lengths as there.
    merged_saddle : float
        Height of the saddle between two neighboring peaks above which both count as merged, as a fraction of the height of the
        lower one, from 0 to 1. Default 0.5.
    wall_level : float, optional
        Level of the isoline whose length is that of the walls, above 0 to 1: 0 is the height that 5 percent of the area do not
        exceed, 1 that which 95 percent do not exceed. Default: the mean height.
    smoothing_length : float, optional
        Length over which ``mesh`` is smoothed where there is no bare surface, world units, larger than 0. Default: a tenth of the
        root of the area.
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the work stops.

    Returns
    -------
    GeometricTextureFeatures
        A mapping with the numbers of the table of vtkGeometricTextureFeatures; ``surface`` is the mesh with the arrays Height,
        Prominence, Peak, Region and SelfIntersections. Empty when the mesh is.

    Raises
    ------
    SurfaceSynthesisError
        The text says which surface is not valid, the first cell or point, and the filter that repairs it; or that the triangles
        of both differ.
    Cancelled
        ``progress`` returned False.
    ValueError, TypeError
        An argument has a value out of its range or is of a wrong type.
    """
    progress_callback(progress)
    algorithm = configured_features(unit_length, minimum_prominence, merged_saddle, wall_level, smoothing_length)
    surface = given_dataset(mesh, (vtkPolyData,), _SURFACE_TEXT)
    if bare is not None:
        give_bare(algorithm, given_dataset(bare, (vtkPolyData,), _SURFACE_TEXT))
    if reference is not None and not isinstance(reference, GeometricTextureFeatures):
        raise TypeError(f"reference must be the result of geometric_texture_features(), not {type(reference).__name__}")

    def run():
        _, remarks = apply_filter(algorithm, surface, progress)
        for text in remarks:
            warnings.warn(text, SurfaceSynthesisWarning, stacklevel=3)

    return features_of(algorithm, run, reference)


def configured_features(
    unit_length=None, minimum_prominence=None, merged_saddle=0.5, wall_level=None, smoothing_length=None
):
    """A vtkGeometricTextureFeatures with the parameters of geometric_texture_features(); raises TypeError and ValueError."""
    algorithm = vtkGeometricTextureFeatures()
    if unit_length is not None:
        algorithm.SetUnitLength(positive("unit_length", unit_length))
    if minimum_prominence is not None:
        algorithm.SetMinimumProminence(positive("minimum_prominence", minimum_prominence))
    algorithm.SetMergedSaddle(in_range("merged_saddle", merged_saddle, 0.0, 1.0))
    if wall_level is not None:
        algorithm.SetWallLevel(positive("wall_level", in_range("wall_level", wall_level, 0.0, 1.0)))
    if smoothing_length is not None:
        algorithm.SetSmoothingLength(positive("smoothing_length", smoothing_length))
    return algorithm


def give_bare(algorithm, bare):
    """Makes a vtkPolyData, which stays untouched, the bare surface of a vtkGeometricTextureFeatures."""
    given = vtkPolyData()  # what pipelines leave on their inputs goes to this copy
    given.ShallowCopy(bare)
    algorithm.SetInputDataObject(1, given)


def features_of(algorithm, run, reference=None):
    """The result of a filter that ``run`` updates, compared with a reference: again, where the prominence of peaks is to be
    that of the reference in unit lengths, which the first update finds."""
    run()
    if reference and algorithm.GetMinimumProminence() == 0 and algorithm.GetOutputDataObject(1).GetNumberOfRows() > 0:
        unit = algorithm.GetOutputDataObject(1).GetColumnByName("UnitLength").GetValue(0)
        algorithm.SetMinimumProminence(reference["minimum_prominence"] / reference["unit_length"] * unit)
        run()
    surface = vtkPolyData()
    surface.ShallowCopy(algorithm.GetOutputDataObject(0))
    return GeometricTextureFeatures(surface, algorithm.GetOutputDataObject(1), reference)


class GeometricTextureFeatures(MappingResult):
    """Numbers of peaks, merged peaks and self-intersections, densities in a unit of area, heights and lengths in world units.

    ``surface`` is the surface with arrays that show them. ``ratios`` compares with the ``reference``, where one was given:
    ``peak_density`` and ``wall_density`` (in unit lengths), ``mean_peak_height`` (likewise) and ``peak_height_variation``, each
    over that of the reference; NaN where that is 0.
    """

    def __init__(self, surface, table, reference=None):
        self.surface = surface
        rows = table.GetNumberOfRows()
        columns = range(table.GetNumberOfColumns()) if rows else ()
        self._values = {snake(table.GetColumnName(k)): table.GetColumn(k).GetValue(0) for k in columns}
        self.reference = reference
        self.ratios = _ratios(self, reference) if self._values and reference else {}

    def to_csv(self):
        """The numbers as comma-separated values: a line of names and one of values."""
        row = self._all()
        return csv_text([row.keys(), map(repr, row.values())])

    def to_dict(self):
        """The numbers by name, and the ratios, as to_json() writes them."""
        return {**self._values, **({"ratios": self.ratios} if self.ratios else {})}

    def _all(self):
        return {**self._values, **{f"{name}_ratio": value for name, value in self.ratios.items()}}

    def __str__(self):
        if not self:
            return "empty"
        return "\n".join(f"{name.replace('_', ' '):<30}{shown(value):>15}" for name, value in self._all().items())

    def __repr__(self):
        if not self:
            return "<GeometricTextureFeatures: empty>"
        peaks = f"{self['number_of_peaks']} peaks of height {self['mean_peak_height']:.6g}"
        merged, walls = f"{100 * self['merged_share']:.3g} % merged", f"walls {self['wall_length']:.6g}"
        return f"<GeometricTextureFeatures: {peaks}, {merged}, {walls}>"

    def _repr_html_(self):
        return html_table([[name.replace("_", " "), value] for name, value in self._all().items()], ["feature", "value"])


def _ratios(found, reference):
    def ratio(name, power=0):
        units = found["unit_length"] ** power, reference["unit_length"] ** power
        above, below = found[name] / units[0], reference[name] / units[1]
        return above / below if below > 0 else math.nan

    return {
        "peak_density": ratio("relative_peak_density"),
        "mean_peak_height": ratio("mean_peak_height", 1),
        "peak_height_variation": ratio("peak_height_variation"),
        "wall_density": ratio("relative_wall_density"),
    }
