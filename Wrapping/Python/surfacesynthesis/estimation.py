# SPDX-License-Identifier: BSD-3-Clause
"""Parameters of Matérn noise from observed fields: a function around vtkMaternParameterEstimator."""

import collections
import warnings

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkPolyData

from .arguments import flag, integer, progress_callback
from .datasets import array_by_name, given_dataset
from .errors import SurfaceSynthesisWarning
from .observations import observe
from .pipeline import apply_filter
from .results import MappingResult, csv_text, html_table
from .vtkSurfaceSynthesisNoise import vtkMaternParameterEstimator

#: The parameters by their names in Python, and the rows of the filter's table that they come from.
PARAMETERS = {
    "correlation_range": "CorrelationRange",
    "standard_deviation": "StandardDeviation",
    "noise_deviation": "NoiseDeviation",
}
_GIVEN_VALUES = "_GivenValues"

ParameterEstimate = collections.namedtuple("ParameterEstimate", "estimate standard_error lower upper")
ParameterEstimate.__doc__ = """An estimated parameter: ``estimate``, the ``standard_error`` of its natural logarithm (about the
relative error), and the interval of 95 % from ``lower`` to ``upper``."""


def estimate_matern(
    mesh,
    observation_array=None,
    observations=None,
    tolerance=None,
    noise_estimation=True,
    mean_estimation=True,
    progress=None,
    operator_power=2,
):
    """Correlation range, standard deviation and noise of Matérn fields by maximum likelihood, from one or many observed
    fields: the parameters with which matern_noise() makes fields like the data.

    The model is that of matern_noise() with the noise model "matern", plus independent errors of the observations. Several
    fields are independent of each other and share the parameters. Of a single field that spans few ranges the parameters are
    known poorly, and the intervals are wide.

    Parameters
    ----------
    mesh : vtkPolyData or pair (points, triangles)
        The surface. It must have finite points, no degenerate triangle and no edge with more than two triangles. It is never
        modified.
    observation_array : str or numpy.ndarray, optional
        The point array with the observed values, of the mesh or, where they are given, of the observations: each component
        is a field; or the first part of the names of several arrays, as matern_noise() names its samples: name_0, name_1.
        Or the values as an array, [V] or [V, fields] with a pair as ``mesh``, [n] or [n, fields] with observations. Default:
        the active scalars.
    observations : vtkPointSet or numpy.ndarray, optional
        Points near the surface at which the fields were observed, or an array of points [n, 3]. Default: the points of the
        mesh that its polygons use.
    tolerance : float, optional
        The largest distance of an observation from the surface, in world units; one farther away is an error. Default: a
        hundredth of the longest side of the bounding box of the surface.
    noise_estimation : bool
        True estimates the standard deviation of independent errors of the observations; False takes them as exact. Default
        True.
    mean_estimation : bool
        True estimates a constant mean of each field; False takes it as 0. Default True.
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the work stops.
    operator_power : int
        The power alpha of the operator of the field, 2 to 4, as that of matern_noise(), which is not estimated. Default 2.

    Returns
    -------
    MaternEstimate
        A mapping from the name of a parameter to its ParameterEstimate. Empty for an empty mesh.

    Raises
    ------
    SurfaceSynthesisError
        The text names the defect of the mesh, the array that is missing, or the observations that are too far from the
        surface; or says that the likelihood has no maximum.
    Cancelled
        ``progress`` returned False.
    ValueError, TypeError
        An argument has a value out of its range or is of a wrong type.
    """
    progress_callback(progress)
    dataset = given_dataset(mesh, (vtkPolyData,), "a vtkPolyData or a pair of arrays (points, triangles)")
    if observations is None and isinstance(observation_array, np.ndarray):
        is_pair = isinstance(mesh, (tuple, list))
        observation_array = array_by_name(dataset, "observation_array", observation_array, _GIVEN_VALUES, is_pair, 1)
    algorithm = configured_filter(observation_array, observations, tolerance, noise_estimation, mean_estimation, operator_power)
    for text in apply_filter(algorithm, dataset, progress)[1]:
        warnings.warn(text, SurfaceSynthesisWarning, stacklevel=2)
    return MaternEstimate(algorithm)


def configured_filter(
    observation_array=None,
    observations=None,
    tolerance=None,
    noise_estimation=True,
    mean_estimation=True,
    operator_power=2,
):
    """A vtkMaternParameterEstimator with the parameters of estimate_matern(), which raises TypeError and ValueError."""
    algorithm = vtkMaternParameterEstimator()
    algorithm.SetNoiseEstimation(flag("noise_estimation", noise_estimation))
    algorithm.SetMeanEstimation(flag("mean_estimation", mean_estimation))
    power = integer("operator_power", operator_power, 2, 4)
    algorithm.SetOperatorPower(power)
    observe(algorithm, observations, observation_array, None, tolerance)
    return algorithm


class MaternEstimate(MappingResult):
    """The estimated parameters by name, each a ParameterEstimate, as estimate_matern() finds them:

    - ``correlation_range``: that of matern_noise(), in world units;
    - ``standard_deviation``: that of the field, in the units of the observations;
    - ``noise_deviation``: the standard deviation of the errors of the observations, in the same units; 0 where it is less
      than a thousandth of that of the field, which is then ``upper``.

    Attributes are ``log_likelihood``, the natural logarithm at the estimate, ``number_of_observations``, the places, and
    ``number_of_fields``.
    """

    def __init__(self, algorithm):
        table = algorithm.GetOutputDataObject(0)
        rows = {table.GetColumnByName("Parameter").GetValue(k): k for k in range(table.GetNumberOfRows())}
        columns = ("Estimate", "StandardError", "Lower", "Upper")
        self._values = {
            name: ParameterEstimate(*(table.GetColumnByName(column).GetValue(rows[row]) for column in columns))
            for name, row in PARAMETERS.items()
            if rows
        }
        self.log_likelihood = algorithm.GetLogLikelihood()
        self.number_of_observations = algorithm.GetNumberOfObservations()
        self.number_of_fields = algorithm.GetNumberOfFields()

    def to_csv(self):
        """The parameters as comma-separated values, with a line of column names."""
        rows = ([name, *map(repr, value)] for name, value in self.items())
        return csv_text([["parameter", *ParameterEstimate._fields], *rows])

    def to_dict(self):
        """The parameters, each with its estimate, standard error and interval, the confidence of the intervals, the
        likelihood and the counts, as to_json() writes them."""
        return {
            "parameters": {name: value._asdict() for name, value in self.items()},
            "confidence": 0.95,
            "log_likelihood": self.log_likelihood,
            "number_of_observations": self.number_of_observations,
            "number_of_fields": self.number_of_fields,
        }

    def __str__(self):
        lines = [
            f"{name.replace('_', ' '):<20} {value.estimate:>12.6g}   95 %: {value.lower:.6g} to {value.upper:.6g}"
            for name, value in self.items()
        ]
        return "\n".join(lines) if lines else "empty"

    def __repr__(self):
        values = ", ".join(f"{name} {value.estimate:.6g}" for name, value in self.items())
        return f"<MaternEstimate: {values or 'empty'}>"

    def _repr_html_(self):
        rows = ([name.replace("_", " "), *value] for name, value in self.items())
        return html_table(rows, ("parameter", "estimate", "standard error", "95 %: from", "to"))
