# SPDX-License-Identifier: BSD-3-Clause
"""Comparison of a generated with a reference ensemble: a function around vtkEnsembleMetrics."""

import warnings

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet, vtkPolyData

from .arguments import array_name, choice, flag, progress_callback
from .datasets import given_dataset
from .errors import SurfaceSynthesisWarning
from .pipeline import apply_filter
from .results import MappingResult, csv_text, html_table, shown
from .vtkSurfaceSynthesisStatistics import vtkEnsembleMetrics

#: The distances of two samples, by the name that ``distance`` takes.
DISTANCES = {"mean_l2": vtkEnsembleMetrics.MEAN_L2, "rms": vtkEnsembleMetrics.RMS}

#: The metrics by their names in Python, and the columns of the filter's table that they come from.
METRICS = {
    "mmd": "MMD",
    "reverse_mmd": "ReverseMMD",
    "cov": "COV",
    "one_nearest_neighbour_accuracy": "OneNearestNeighbourAccuracy",
    "mean_error": "MeanError",
    "generated_spacing": "GeneratedSpacing",
    "reference_spacing": "ReferenceSpacing",
    "number_of_generated": "NumberOfGenerated",
    "number_of_references": "NumberOfReferences",
    "number_of_points": "NumberOfPoints",
    "number_of_components": "NumberOfComponents",
}
_GIVEN_VALUES = "_GivenValues"
_NEAREST = ("sample", "sample_name", "nearest_reference", "nearest_reference_name", "distance")


def ensemble_metrics(
    generated, reference, array=None, source=None, distance="mean_l2", remove_centroid=False, progress=None
):
    """Compares a generated with a reference ensemble of shapes or signals on one triangulation: a measure of how well a
    generative model has learned a distribution.

    Parameters
    ----------
    generated, reference : ensembles
        Each one of: a composite dataset of surfaces (vtkDataObjectTree), whose leaves in order are the samples; a list
        of surfaces, each a vtkPolyData or a pair (points, triangles); a vtkPolyData; or, with a ``source``, an array of
        numbers [N, V] or [N, V, C] with the values of N samples. All surfaces must have the same points and polygons.
        None of them is modified.
    array : str, optional
        The point array that is compared, with any number of components. A surface without an array of this name has a
        sample in each of the arrays called array_0, array_1 and so on, as matern_noise() names its samples. Default:
        the points. Arrays of numbers are compared as they are, and ``array`` must not be given.
    source : vtkPolyData or pair (points, triangles), optional
        The surface that gives the points their mass, for instance the shape before it was deformed. Default: that of
        the first reference sample.
    distance : str
        The distance of two samples, in world units or those of the array: "mean_l2", the mean distance of corresponding
        points weighted by mass, the one of the paper; "rms", the root of the mean squared one, which weighs outliers
        more. Default "mean_l2".
    remove_centroid : bool
        True subtracts the mean value of each sample, weighted by mass, so that shapes are compared up to translation.
        Default False.
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the work stops.

    Returns
    -------
    EnsembleMetrics
        A mapping from the name of a metric to its value, with the nearest reference of each generated sample as
        attributes. Empty when both ensembles are.

    Raises
    ------
    SurfaceSynthesisError
        The text names the first sample that is not on the triangulation of the others, lacks the array or has values
        that are not finite, or says that an ensemble is empty.
    Cancelled
        ``progress`` returned False.
    ValueError, TypeError
        An argument has a value out of its range or is of a wrong type.
    """
    progress_callback(progress)
    algorithm = configured_filter(array, distance, remove_centroid)
    surface = None if source is None else given_dataset(source, (vtkPolyData,), "a vtkPolyData or a pair of arrays")
    ensembles = ensemble_of("generated", generated, surface), ensemble_of("reference", reference, surface)
    _choose_given_values(algorithm, array, generated, reference)
    remarks = compare(algorithm, *ensembles, surface, lambda dataset: apply_filter(algorithm, dataset, progress)[1])
    for text in remarks:
        warnings.warn(text, SurfaceSynthesisWarning, stacklevel=2)
    return metrics_of(algorithm)


def configured_filter(array=None, distance="mean_l2", remove_centroid=False):
    """A vtkEnsembleMetrics with the parameters of ensemble_metrics(), which raises TypeError and ValueError."""
    algorithm = vtkEnsembleMetrics()
    algorithm.SetArrayName("" if array is None else array_name("array", array))
    algorithm.SetDistance(choice("distance", distance, DISTANCES))
    algorithm.SetRemoveCentroid(flag("remove_centroid", remove_centroid))
    return algorithm


def compare(algorithm, generated, reference, source, run):
    """Gives a vtkEnsembleMetrics its inputs and returns what ``run``, called with the first one, does."""
    for port, dataset in ((1, reference), (2, source)):
        if dataset is not None:
            algorithm.SetInputDataObject(port, _shallow_copy(dataset))
    return run(generated)


def metrics_of(algorithm):
    """The result of ensemble_metrics(), from a filter that has run."""
    return EnsembleMetrics(algorithm.GetOutputDataObject(0), algorithm.GetOutputDataObject(1))


def ensemble_of(name, samples, source=None):
    """The dataset of an ensemble, which raises TypeError and ValueError with the argument's name."""
    if isinstance(samples, np.ndarray):
        return _surface_with(name, samples, source)
    if not isinstance(samples, (tuple, list)):
        text = "a composite dataset, a list of surfaces, a vtkPolyData or an array [N, V, C]"
        return given_dataset(samples, text=f"{text} as {name} ensemble")
    blocks = vtkMultiBlockDataSet()
    for number, sample in enumerate(samples):
        blocks.SetBlock(number, _shallow_copy(given_dataset(sample)))
    return blocks


def _shallow_copy(dataset):
    """Copy to which pipelines may attach what they leave on their inputs."""
    copy = dataset.NewInstance()
    copy.ShallowCopy(dataset)
    return copy


def _surface_with(name, values, source):
    """The source with an array for each sample."""
    if source is None:
        raise TypeError(f"{name} is an array of numbers, which needs the surface that they are on as source")
    if values.dtype.kind not in "fiub":
        raise TypeError(f"{name} must be an array of real numbers, not of {values.dtype}")
    if values.ndim not in (2, 3) or values.shape[1] != source.GetNumberOfPoints():
        raise ValueError(
            f"{name} must have the shape [N, V] or [N, V, C] with V = {source.GetNumberOfPoints()} points of the "
            f"source, not {list(values.shape)}"
        )
    surface = vtkPolyData()
    surface.CopyStructure(source)
    stored = np.float32 if values.dtype == np.float32 else np.float64
    for number, sample in enumerate(values):
        array = numpy_to_vtk(np.ascontiguousarray(sample, dtype=stored), deep=True)
        array.SetName(f"{_GIVEN_VALUES}_{number}")
        surface.GetPointData().AddArray(array)
    if len(values) == 0:
        return vtkPolyData()
    return surface


def _choose_given_values(algorithm, array, generated, reference):
    given = [isinstance(ensemble, np.ndarray) for ensemble in (generated, reference)]
    if not any(given):
        return
    if not all(given):
        raise TypeError("generated and reference must both be arrays of numbers, or neither")
    if array is not None:
        raise ValueError("array names an array of surfaces; generated and reference are arrays of numbers")
    algorithm.SetArrayName(_GIVEN_VALUES)


class EnsembleMetrics(MappingResult):
    """The metrics by name, as ensemble_metrics() finds them:

    - ``mmd``: minimum matching distance in the words of the paper, the mean over the generated samples of the distance
      to the nearest reference: fidelity, low is good;
    - ``reverse_mmd``: minimum matching distance in the words of Achlioptas et al. (2018), the mean over the references
      of the distance to the nearest generated sample: low is good;
    - ``cov``: coverage, the fraction of the references that are nearest to at least one generated sample, in (0, 1]:
      diversity, high is good;
    - ``one_nearest_neighbour_accuracy``: how often the nearest other sample of both ensembles together is of the same
      ensemble, in [0, 1]: about 0.5 is ideal, 1 means that the ensembles are apart, 0 that every reference has a copy;
    - ``mean_error``: the distance of the pointwise means of the two ensembles;
    - ``generated_spacing``, ``reference_spacing``: the mean distance of a sample to the nearest other one of its own
      ensemble, 0 where there is only one: what ``mmd`` is to be seen beside;
    - ``number_of_generated``, ``number_of_references``, ``number_of_points``, ``number_of_components``.

    ``nearest_reference`` [N] int64 and ``distances`` [N] float64 are NumPy arrays with the nearest reference of each
    generated sample, a number from 0 on, and its distance; ``names`` and ``nearest_names`` are lists with the names of
    the samples: "Block 3", an array's name.
    """

    def __init__(self, metrics, nearest):
        rows = metrics.GetNumberOfRows()
        columns = {name: metrics.GetColumnByName(column) for name, column in METRICS.items()} if rows else {}
        self._values = {name: column.GetValue(0) for name, column in columns.items()}
        column = nearest.GetColumnByName
        self.nearest_reference = vtk_to_numpy(column("NearestReference")).copy() if rows else np.zeros(0, np.int64)
        self.distances = vtk_to_numpy(column("Distance")).copy() if rows else np.zeros(0)
        samples = range(len(self.distances))
        self.names = [column("SampleName").GetValue(k) for k in samples]
        self.nearest_names = [column("NearestReferenceName").GetValue(k) for k in samples]

    def to_csv(self):
        """The metrics as comma-separated values: a line of names and a line of numbers."""
        return csv_text([list(self), [repr(value) for value in self.values()]])

    def to_dict(self):
        """The metrics by name, and "nearest", a row for each generated sample, as to_json() writes them."""
        return {**self._values, "nearest": self.nearest()}

    def nearest(self):
        """A list with a dictionary for each generated sample: sample, sample_name, nearest_reference,
        nearest_reference_name, distance."""
        columns = self.names, self.nearest_reference.tolist(), self.nearest_names, self.distances.tolist()
        return [dict(zip(_NEAREST, (number, *row))) for number, row in enumerate(zip(*columns))]

    def nearest_to_csv(self):
        """The nearest references as comma-separated values, with a line of column names."""
        return csv_text([_NEAREST, *([*list(row.values())[:-1], repr(row["distance"])] for row in self.nearest())])

    def __str__(self):
        lines = [f"{name.replace('_', ' '):<32} {shown(value):>14}" for name, value in self.items()]
        return "\n".join(lines) if lines else "empty"

    def _repr_html_(self):
        return html_table((name.replace("_", " "), value) for name, value in self.items())

    def __repr__(self):
        values = ", ".join(f"{name} {self[name]:.6g}" for name in ("mmd", "cov") if name in self)
        return f"<EnsembleMetrics: {values or 'empty'}>"
