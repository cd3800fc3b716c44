# SPDX-License-Identifier: BSD-3-Clause
"""Statistics of ensembles and statistical shape models: functions around vtkEnsembleStatistics and vtkShapeModelSampler."""

import math
import warnings

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkPolyData

from .arguments import INT_MIN, array_name, finite, in_range, integer, progress_callback
from .datasets import given_dataset
from .errors import SurfaceSynthesisWarning
from .metrics import ensemble_of
from .pipeline import apply_filter
from .results import Result, html_table
from .vtkSurfaceSynthesisStatistics import vtkEnsembleStatistics, vtkShapeModelSampler


def ensemble_statistics(ensemble, array=None, quantiles=(), modes=0, progress=None):
    """Mean, standard deviation, quantiles and principal modes of an ensemble of shapes or signals on one triangulation.

    The modes make a statistical shape model (Cootes et al. 1995), of which shape_model() makes random, given and fitted
    shapes. Shapes are compared as they lie: vtkProcrustesAlignmentFilter aligns them before.

    Parameters
    ----------
    ensemble : ensemble
        A composite dataset of surfaces (vtkDataObjectTree), whose leaves in order are the samples; a list of surfaces, each a
        vtkPolyData or a pair (points, triangles); or a vtkPolyData with arrays of samples. All surfaces must have the same
        points and polygons; at least 2 samples. None of them is modified.
    array : str, optional
        The point array, with any number of components. A surface without an array of this name has a sample in each of the
        arrays called array_0, array_1 and so on, as matern_noise() names its samples. Default: the points.
    quantiles : sequence of float
        Probabilities of the quantiles, from 0 to 1: 0.5 is the median. Linear between order statistics, as numpy.quantile().
        Default none.
    modes : int
        Number of principal modes, at least 0; -1 stands for all. Default 0.
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the work stops.

    Returns
    -------
    EnsembleStatistics
        ``surface`` is the vtkPolyData with the mean and all arrays: a file of it (.vtp) is a shape model.

    Raises
    ------
    SurfaceSynthesisError
        The text names the first sample that is not on the triangulation of the others, lacks the array or has values that are
        not finite, or says that there are fewer than 2.
    Cancelled
        ``progress`` returned False.
    ValueError, TypeError
        An argument has a value out of its range or is of a wrong type.
    """
    progress_callback(progress)
    algorithm = configured_filter(array, quantiles, modes)
    given = ensemble_of("ensemble", ensemble)
    _, remarks = apply_filter(algorithm, given, progress)
    for text in remarks:
        warnings.warn(text, SurfaceSynthesisWarning, stacklevel=2)
    return statistics_of(algorithm)


def configured_filter(array=None, quantiles=(), modes=0):
    """A vtkEnsembleStatistics with the parameters of ensemble_statistics(), which raises TypeError and ValueError."""
    algorithm = vtkEnsembleStatistics()
    algorithm.SetArrayName("" if array is None else array_name("array", array))
    probabilities = [in_range("quantiles", value, 0, 1) for value in quantiles]
    algorithm.SetNumberOfQuantiles(len(probabilities))
    for k, probability in enumerate(probabilities):
        algorithm.SetQuantile(k, probability)
    algorithm.SetNumberOfModes(integer("modes", modes, -1))
    return algorithm


def statistics_of(algorithm):
    """The result of ensemble_statistics(), from a filter that has run."""
    surface = vtkPolyData()
    surface.ShallowCopy(algorithm.GetOutputDataObject(0))
    tables = [algorithm.GetOutputDataObject(port) for port in (1, 2)]
    return EnsembleStatistics(surface, *tables)


class EnsembleStatistics(Result):
    """Statistics of an ensemble of N samples on V points, of C components, as ensemble_statistics() finds them.

    - ``surface``: vtkPolyData with the mean positions, or of an array with the positions of the first sample, and all results
      as point arrays: Mean (of an array), StandardDeviation, StandardDistance, Quantile_0.5, Mode_0 and so on.
    - ``mean``, ``standard_deviation``: float64 [V, C]; divisor N - 1.
    - ``quantiles``: dictionary from a probability to float64 [V, C].
    - ``modes``: float64 [K, V, C], principal modes in descending order of variance, each times its standard deviation.
    - ``variances``, ``fractions``: float64 [K], variance of each mode and its part of the whole.
    - ``coefficients``: float64 [N, K], coefficients of the samples in standard deviations.
    - ``names``: names of the samples: "Block 3", the name of an array.
    """

    def __init__(self, surface, modes, samples):
        self.surface = surface
        data = surface.GetPointData()
        rows = samples.GetNumberOfRows()
        of_array = data.HasArray("Mean")
        mean = data.GetArray("Mean") if of_array else surface.GetPoints().GetData() if rows else None
        self.mean = _rows(mean) if rows else np.zeros((0, 3))
        self.standard_deviation = _rows(data.GetArray("StandardDeviation")) if rows else np.zeros((0, 3))
        names = [data.GetArrayName(k) for k in range(data.GetNumberOfArrays())]
        self.quantiles = {
            float(name[9:]): _rows(data.GetArray(name)) for name in names if name and name.startswith("Quantile_")
        }
        count = modes.GetNumberOfRows()
        self.modes = np.array([_rows(data.GetArray(f"Mode_{k}")) for k in range(count)]).reshape(count, *self.mean.shape)
        self.variances = _column(modes, "Variance")
        self.fractions = _column(modes, "Fraction")
        columns = [_column(samples, f"Coefficient_{k}") for k in range(count)]
        self.coefficients = np.array(columns).reshape(count, rows).T.copy()
        self.names = [samples.GetColumnByName("SampleName").GetValue(k) for k in range(rows)]

    def modes_to_csv(self):
        """Variances of the modes as comma-separated values, with a line of column names."""
        lines = ["mode,variance,standard_deviation,fraction,cumulative_fraction"]
        lines += [",".join(map(repr, row.values())) for row in self._mode_rows()]
        return "\n".join(lines) + "\n"

    def to_csv(self):
        """The text of modes_to_csv()."""
        return self.modes_to_csv()

    def to_dict(self):
        """Counts, extremes of the standard deviation and the variances of the modes, as to_json() writes them."""
        return {**self._summary(), "modes": self._mode_rows()}

    def _mode_rows(self):
        cumulative = np.cumsum(self.fractions).tolist()
        return [
            {
                "mode": k,
                "variance": variance,
                "standard_deviation": math.sqrt(variance),
                "fraction": fraction,
                "cumulative_fraction": cumulative[k],
            }
            for k, (variance, fraction) in enumerate(zip(self.variances.tolist(), self.fractions.tolist()))
        ]

    def _summary(self):
        distance = np.linalg.norm(self.standard_deviation, axis=1)
        return {
            "samples": len(self.names),
            "points": len(self.mean),
            "components": self.mean.shape[1],
            "mean_standard_deviation": float(distance.mean()) if len(distance) else 0.0,
            "largest_standard_deviation": float(distance.max()) if len(distance) else 0.0,
        }

    def __str__(self):
        shown = {name: f"{v:,}" if isinstance(v, int) else f"{v:.6g}" for name, v in self._summary().items()}
        lines = [f"{name.replace('_', ' '):<32} {value:>14}" for name, value in shown.items()]
        for row in self._mode_rows():
            part = f"{100 * row['fraction']:6.2f} %, {100 * row['cumulative_fraction']:6.2f} % with those before"
            lines.append(f"{'mode ' + str(row['mode']):<32} {row['standard_deviation']:>14.6g}  {part}")
        return "\n".join(lines)

    def __repr__(self):
        return f"<EnsembleStatistics: {len(self.names)} samples of {len(self.mean)} points, {len(self.variances)} modes>"

    def _repr_html_(self):
        summary = html_table((name.replace("_", " "), value) for name, value in self._summary().items())
        modes = [
            (row["mode"], row["standard_deviation"], f"{100 * row['fraction']:.2f} %", f"{100 * row['cumulative_fraction']:.2f} %")
            for row in self._mode_rows()
        ]
        return summary + (html_table(modes, ("mode", "standard deviation", "fraction", "cumulative")) if modes else "")


def shape_model(
    model, samples=1, seed=0, first_sample=0, coefficients=None, shapes=None, modes=-1, progress=None
):
    """Random, given or fitted shapes or signals of a statistical shape model.

    Parameters
    ----------
    model : vtkPolyData or EnsembleStatistics
        The ``surface`` of ensemble_statistics() with modes, or a file of it.
    samples : int
        Number of random samples, at least 1. Default 1.
    seed : int
        Seed of the random numbers, any integer of 32 bits: the same seed always gives the same shapes. Default 0.
    first_sample : int
        Index of the first sample, at least 0; an ensemble can be generated in parts. Default 0.
    coefficients : sequence of float, optional
        Coefficients of one shape in standard deviations of the modes, in place of random ones; those of other modes are 0.
    shapes : ensemble, optional
        Shapes that are projected on the model, in place of random ones: each gives the nearest shape of the model. As
        ensemble_statistics() takes them.
    modes : int
        Number of modes that are used, the first ones; -1 (default) stands for all.
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the work stops.

    Returns
    -------
    vtkMultiBlockDataSet
        A vtkPolyData for each sample, "Sample 0", "Sample 1" and so on, with the field array Coefficients [K]; projections
        also have the point array Residual, the distance from the shape, and the field array RMSResidual.

    Raises
    ------
    SurfaceSynthesisError
        The surface is no model, or a shape is not on its triangulation.
    Cancelled
        ``progress`` returned False.
    ValueError, TypeError
        An argument has a value out of its range or is of a wrong type.
    """
    progress_callback(progress)
    sampler = configured_sampler(samples, seed, first_sample, coefficients, shapes is not None, modes)
    surface = model.surface if isinstance(model, EnsembleStatistics) else model
    given = given_dataset(surface, (vtkPolyData,), "a vtkPolyData or the result of ensemble_statistics()")
    if shapes is not None:
        sampler.SetInputDataObject(1, ensemble_of("shapes", shapes))
    output, remarks = apply_filter(sampler, given, progress)
    for text in remarks:
        warnings.warn(text, SurfaceSynthesisWarning, stacklevel=2)
    return output


def configured_sampler(samples=1, seed=0, first_sample=0, coefficients=None, projected=False, modes=-1):
    """A vtkShapeModelSampler with the parameters of shape_model(), which raises TypeError and ValueError."""
    if coefficients is not None and projected:
        raise ValueError("coefficients and shapes exclude each other: shapes are projected")
    sampler = vtkShapeModelSampler()
    sampler.SetNumberOfSamples(integer("samples", samples, 1))
    sampler.SetSeed(integer("seed", seed, INT_MIN))
    sampler.SetFirstSample(integer("first_sample", first_sample, 0))
    sampler.SetNumberOfModes(integer("modes", modes, -1))
    if coefficients is not None:
        values = [finite("coefficients", value) for value in coefficients]
        sampler.SetCoefficientSourceToGiven()
        sampler.SetNumberOfCoefficients(len(values))
        for k, value in enumerate(values):
            sampler.SetCoefficient(k, value)
    elif projected:
        sampler.SetCoefficientSourceToProjected()
    return sampler


def _rows(array):
    values = vtk_to_numpy(array)
    return values.reshape(len(values), -1).copy()


def _column(table, name):
    column = table.GetColumnByName(name)
    return np.zeros(0) if column is None else vtk_to_numpy(column).copy()
