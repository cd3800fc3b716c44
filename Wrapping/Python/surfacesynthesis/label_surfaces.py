# SPDX-License-Identifier: BSD-3-Clause
"""Surfaces of the labels of a volume: a function around vtkLabelSurfaceFilter."""

import collections.abc
import warnings

from vtkmodules.vtkCommonDataModel import vtkCompositeDataSet, vtkDataObject, vtkImageData

from .arguments import INT_MAX, INT_MIN, array_name, at_most, flag, integer, optional_path, progress_callback
from .datasets import given_dataset
from .errors import SurfaceSynthesisWarning
from .files.volumes import cells_as_points
from .pipeline import apply_filter
from .vtkSurfaceSynthesisMeshing import vtkLabelSurfaceFilter


def label_surfaces(
    volume,
    names=None,
    labels=(),
    smoothing_iterations=30,
    preserve_volume=True,
    shared_borders=True,
    array=None,
    progress=None,
):
    """Makes a named surface of each label of a label map: the regions of an atlas or a segmentation.

    Touching labels share the points and triangles of their border, and each keeps the volume of its samples to 0.01 percent.

    Parameters
    ----------
    volume : vtkImageData
        Labels, integers of 32 bits of any type, at points or cells; 0 is the background. read_volume() reads NIfTI and
        others. Never modified.
    names : path or dictionary, optional
        A text file with a line for each label, its number and its name, as in the tables of MRIcron, FreeSurfer and ITK-SNAP;
        or a dictionary from labels to names. Default: "Label 5".
    labels : sequence of int
        Labels of which surfaces are made; the others become background. Default: all, which may be 4096 at most.
    smoothing_iterations : int
        Number of steps of smoothing, from 0 to 1000; 0 leaves the steps of the samples. Default 30.
    preserve_volume : bool
        True (default) moves the borders along their normals after smoothing until the volume of each label is that of its
        samples.
    shared_borders : bool
        True (default) gives touching labels the same points and triangles in their border. False smooths each label by itself.
    array : str, optional
        Name of the point array of the image to use, or of the cell array. Default: its active scalars, those of the points
        first.
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the work stops.

    Returns
    -------
    vtkMultiBlockDataSet
        A vtkPolyData for each label in ascending order, closed and manifold, in a block of its name, with the cell array Label
        and the field arrays Label, LabelName and SampleVolume.

    Raises
    ------
    SurfaceSynthesisError
        Values are no labels, as the gray values of a scan, a label is not there, or the table of names cannot be read.
    Cancelled
        ``progress`` returned False.
    ValueError, TypeError
        An argument has a value out of its range, or is of a wrong type.
    """
    progress_callback(progress)
    algorithm = configured_filter(names, labels, smoothing_iterations, preserve_volume, shared_borders, array)
    given = labels_at_points(given_dataset(volume, (vtkImageData,), "a vtkImageData"), array)
    output, remarks = apply_filter(algorithm, given, progress)
    for text in remarks:
        warnings.warn(text, SurfaceSynthesisWarning, stacklevel=2)
    return output


def configured_filter(
    names=None, labels=(), smoothing_iterations=30, preserve_volume=True, shared_borders=True, array=None
):
    """A vtkLabelSurfaceFilter with the parameters of label_surfaces(), which raises TypeError and ValueError."""
    algorithm = vtkLabelSurfaceFilter()
    if isinstance(names, collections.abc.Mapping):
        for label, name in names.items():
            algorithm.SetLabelName(integer("names", label, INT_MIN), array_name("names", name))
    else:
        algorithm.SetNamesFileName(optional_path("names", names))
    chosen = [integer("labels", label, INT_MIN, INT_MAX) for label in labels]
    algorithm.SetNumberOfLabels(len(chosen))
    for k, label in enumerate(chosen):
        algorithm.SetLabel(k, label)
    iterations = integer("smoothing_iterations", smoothing_iterations, 0)
    algorithm.SetSmoothingIterations(at_most("smoothing_iterations", iterations, 1000))
    algorithm.SetPreserveVolume(flag("preserve_volume", preserve_volume))
    algorithm.SetSharedBorders(flag("shared_borders", shared_borders))
    if array is not None:
        name = array_name("array", array)
        algorithm.SetInputArrayToProcess(0, 0, 0, vtkDataObject.FIELD_ASSOCIATION_POINTS, name)
    return algorithm


def labels_at_points(image, array=None):
    """The image, or its cells as points when ``array`` is one of cells, or no name is given and only the cells have any."""
    points, cells = image.GetPointData(), image.GetCellData()
    if array is None:
        return cells_as_points(image) if points.GetNumberOfArrays() == 0 and cells.GetScalars() is not None else image
    return cells_as_points(image) if not points.HasArray(str(array)) and cells.HasArray(str(array)) else image


def measures_of(surfaces):
    """A list with a dictionary for each block of label_surfaces(): label, name, points, triangles, volume."""
    rows = []
    for k in range(surfaces.GetNumberOfBlocks()):
        surface = surfaces.GetBlock(k)
        fields = surface.GetFieldData()
        rows.append(
            {
                "label": int(fields.GetArray("Label").GetValue(0)),
                "name": surfaces.GetMetaData(k).Get(vtkCompositeDataSet.NAME()),
                "points": surface.GetNumberOfPoints(),
                "triangles": surface.GetNumberOfCells(),
                "volume": fields.GetArray("SampleVolume").GetValue(0),
            }
        )
    return rows
