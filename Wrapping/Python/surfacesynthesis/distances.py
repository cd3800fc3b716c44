# SPDX-License-Identifier: BSD-3-Clause
"""Distance of two surfaces: a function around vtkSurfaceDistance."""

import warnings

from vtkmodules.vtkCommonDataModel import vtkPolyData

from .arguments import INT_MIN, integer, progress_callback
from .datasets import given_dataset
from .errors import SurfaceSynthesisWarning
from .pipeline import apply_filter
from .results import MappingResult, csv_text, html_table
from .vtkSurfaceSynthesisStatistics import vtkSurfaceDistance

_SURFACE_TEXT = "a vtkPolyData or a pair of arrays (points, triangles)"
_COLUMNS = {"mean": "Mean", "rms": "RMS", "percentile_95": "Percentile95", "maximum": "Maximum"}


def surface_distance(first, second, samples=100_000, seed=0, progress=None):
    """Measures the distance of two surfaces, whatever their triangulations are: mean, RMS, 95th percentile and Hausdorff
    distance, in both directions.

    Parameters
    ----------
    first, second : vtkPolyData or pair (points, triangles)
        The surfaces, with finite points and an area; open and non-manifold ones are allowed. Never modified.
    samples : int
        Number of samples on each surface, at least 1, which are spread evenly over its area. Default 100000.
    seed : int
        Seed of the places of the samples, any integer of 32 bits. Default 0.
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the work stops.

    Returns
    -------
    SurfaceDistance
        A mapping with the distances of both directions together, and those of each as attributes; ``surface`` is the first
        surface with the point array Distance. Empty when both surfaces are.

    Raises
    ------
    SurfaceSynthesisError
        A surface is empty, has no area or points that are not finite.
    Cancelled
        ``progress`` returned False.
    ValueError, TypeError
        An argument has a value out of its range or is of a wrong type.
    """
    progress_callback(progress)
    algorithm = configured_filter(samples, seed)
    given, other = (given_dataset(mesh, (vtkPolyData,), _SURFACE_TEXT) for mesh in (first, second))
    algorithm.SetInputDataObject(1, other)
    _, remarks = apply_filter(algorithm, given, progress)
    for text in remarks:
        warnings.warn(text, SurfaceSynthesisWarning, stacklevel=2)
    return distance_of(algorithm)


def configured_filter(samples=100_000, seed=0):
    """A vtkSurfaceDistance with the parameters of surface_distance(), which raises TypeError and ValueError."""
    algorithm = vtkSurfaceDistance()
    algorithm.SetNumberOfSamples(integer("samples", samples, 1))
    algorithm.SetSeed(integer("seed", seed, INT_MIN))
    return algorithm


def distance_of(algorithm):
    """The result of surface_distance(), from a filter that has run."""
    surface = vtkPolyData()
    surface.ShallowCopy(algorithm.GetOutputDataObject(0))
    return SurfaceDistance(surface, algorithm.GetOutputDataObject(1))


class SurfaceDistance(MappingResult):
    """Distances in world units, weighted by area, of both directions together: ``mean``, ``rms``, ``percentile_95`` (the
    distance that 95 percent of the area do not exceed) and ``maximum``, the Hausdorff distance, a lower bound.

    ``first_to_second`` and ``second_to_first`` are dictionaries with the same of each direction; ``surface`` is the first
    surface with the point array Distance.
    """

    def __init__(self, surface, table):
        self.surface = surface
        rows = [
            {name: table.GetColumnByName(column).GetValue(row) for name, column in _COLUMNS.items()}
            for row in range(table.GetNumberOfRows())
        ]
        self.first_to_second, self.second_to_first, self._values = rows or [{}, {}, {}]

    def _rows(self):
        return {"both": self._values, "first to second": self.first_to_second, "second to first": self.second_to_first}

    def to_csv(self):
        """The distances as comma-separated values: a line of names and one for each direction."""
        rows = ([direction, *map(repr, row.values())] for direction, row in self._rows().items() if row)
        return csv_text([["direction", *_COLUMNS], *rows])

    def to_dict(self):
        """The distances of each direction, as to_json() writes them."""
        rows = {direction.replace(" ", "_"): row for direction, row in self._rows().items()}
        return {**rows, "units": "world units of the surfaces"}

    def __str__(self):
        if not self:
            return "empty"
        head = f"{'distance, world units':<24}" + "".join(f"{name.replace('_', ' '):>15}" for name in _COLUMNS)
        lines = [f"{direction:<24}" + "".join(f"{value:>15.6g}" for value in row.values())
                 for direction, row in self._rows().items()]  # fmt: skip
        return "\n".join([head, *lines])

    def __repr__(self):
        values = ", ".join(f"{name} {value:.6g}" for name, value in self.items())
        return f"<SurfaceDistance: {values or 'empty'}>"

    def _repr_html_(self):
        head = ["distance, world units", *(name.replace("_", " ") for name in _COLUMNS)]
        return html_table([[direction, *row.values()] for direction, row in self._rows().items()], head)
