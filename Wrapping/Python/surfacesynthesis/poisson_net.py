# SPDX-License-Identifier: BSD-3-Clause
"""Trained networks on surfaces: a function around vtkPoissonNetFilter for datasets and for NumPy arrays."""

import collections
import os
import warnings

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy

from .arguments import array_name, choice, progress_callback, real, set_coupling
from .datasets import array_by_name, as_type_of, given_dataset
from .deprecation import renamed_keywords
from .errors import SurfaceSynthesisWarning
from .pipeline import apply_filter
from .vtkSurfaceSynthesisPoissonNet import vtkPoissonNetFilter

#: Normalisations of a mesh before the network takes it, by the name that ``normalization`` takes.
NORMALIZATIONS = {
    "model": vtkPoissonNetFilter.MODEL,
    "none": vtkPoissonNetFilter.NONE,
    "surface_area": vtkPoissonNetFilter.SURFACE_AREA,
    "unit_sphere": vtkPoissonNetFilter.UNIT_SPHERE,
}

#: The result of poisson_net() for a pair of arrays: the values [V, C], [F, C] or [C]; the most probable classes, of the
#: same shape without the last axis, or None when the model is no classifier; the names of the classes, maybe none.
NetworkOutput = collections.namedtuple("NetworkOutput", "values labels class_names")

_GIVEN_CONDITIONS, _GIVEN_SIGNAL = "_GivenConditions", "_GivenSignal"


@renamed_keywords(normalisation="normalization")
def poisson_net(
    mesh,
    model,
    conditions=None,
    signal=None,
    normalization="model",
    name="Prediction",
    label_name="Label",
    class_names_name="ClassNames",
    displacement_name="Displacement",
    progress=None,
    component_coupling=False,
    coupling_weight=1e6,
    coupling_distance=None,
):
    """Evaluates a trained PoissonNet on a surface: segmentation, classification, features or predicted shapes, whatever
    the model file describes.

    Parameters
    ----------
    mesh : vtkPolyData, composite dataset (vtkDataObjectTree) or pair (points, triangles)
        Triangles, polygons or strips, float or double points, open or closed. The mesh must have finite points, no
        degenerate triangle, no edge with more than two triangles, consistent winding and one component, or
        ``component_coupling``. A warning is
        given where good answers are unlikely: for a closed surface whose faces point inwards, and for an area below
        0.1 or above 10 that is not normalised. A composite dataset is processed block by block. A pair is an array of
        points [V, 3] and an integer array of triangles [F, 3]. The mesh is never modified.
    model : path
        The model file, safetensors; ``python3 -m surfacesynthesis convert`` makes one of a PyTorch checkpoint.
    conditions : float, sequence of floats, str or array [V, k], optional
        The conditions (extra features) of the model: finite numbers that are the same for all points; the name of a
        point array with as many components; or, with a pair, an array with a row for each point. Default none.
    signal : str or array [V, C], optional
        The input of the network at each point in place of the positions: the name of a point array or, with a pair, an
        array. Default: the positions.
    normalization : str
        The normalisation of the mesh before the network takes it: "model", that of the model file, which is none in
        published ones; "none"; "surface_area", moved to the area-weighted centroid and scaled to area 1;
        "unit_sphere", moved there and scaled to the largest distance 1 from it. It should be that of the
        training. Default "model".
    name, label_name, class_names_name, displacement_name : str
        Names of the arrays. Default "Prediction", "Label", "ClassNames" and "Displacement".
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the work stops.
    component_coupling : bool
        True couples the connected components of the surface, so that parts move together, such as eyes in a body: each
        point within ``coupling_distance`` of another component is tied to the nearest place there. Predicted positions
        keep the offsets of the parts in the signal of the network. Off, several components raise. Results do not depend
        on the order of the components, and one component gives the same bits as without. A component without a pair
        raises. Default False.
    coupling_weight : float
        Weight of the squared differences of coupled points against the Dirichlet energy, without unit, above 0; larger
        ties parts more tightly. Default 1e6.
    coupling_distance : float, optional
        Largest distance of two coupled points, in world units, at least 0. Default: 0.03 times the square root of the
        area of the surface.

    Returns
    -------
    dataset of the type of ``mesh``
        The mesh with ``name`` as point, cell or field data, as the model's head says. A classifier adds
        ``label_name`` and, where the file names the classes, the field data ``class_names_name``; a head that
        predicts positions adds the point array ``displacement_name``, which leads there with the centroid left in
        place. Points and cells that the network has not seen get 0 and the label -1.
    NetworkOutput (values, labels, class_names), for a pair
        NumPy arrays and a list of names.

    Raises
    ------
    SurfaceSynthesisError
        The text names the defect of the model file or of the mesh, the first cell or point, and the filter that repairs
        it; for a composite dataset it holds a line for each bad block.
    Cancelled
        ``progress`` returned False.
    ValueError, TypeError
        An argument has a value out of its range or is of a wrong type.
    """
    is_pair = isinstance(mesh, (tuple, list))
    dataset = given_dataset(mesh)
    conditions = array_by_name(dataset, "conditions", conditions, _GIVEN_CONDITIONS, is_pair, 2)
    signal = array_by_name(dataset, "signal", signal, _GIVEN_SIGNAL, is_pair, 1)
    algorithm = configured_filter(
        model,
        conditions,
        signal,
        normalization,
        name,
        label_name,
        class_names_name,
        displacement_name,
        component_coupling,
        coupling_weight,
        coupling_distance,
    )
    progress_callback(progress)
    output, remarks = apply_filter(algorithm, dataset, progress)
    for text in remarks:
        warnings.warn(text, SurfaceSynthesisWarning, stacklevel=3)
    return _arrays(output, algorithm) if is_pair else as_type_of(mesh, output)


def configured_filter(
    model,
    conditions=None,
    signal=None,
    normalization="model",
    name="Prediction",
    label_name="Label",
    class_names_name="ClassNames",
    displacement_name="Displacement",
    component_coupling=False,
    coupling_weight=1e6,
    coupling_distance=None,
):
    """A vtkPoissonNetFilter with the parameters of poisson_net(), which raises TypeError and ValueError."""
    algorithm = vtkPoissonNetFilter()
    model = os.fspath(model)
    algorithm.SetModelFileName(model.decode() if isinstance(model, bytes) else model)
    algorithm.SetInputNormalization(choice("normalization", normalization, NORMALIZATIONS))
    if isinstance(conditions, str):
        algorithm.SetConditionArrayName(array_name("conditions", conditions))
    elif conditions is not None:
        values = _numbers(conditions)
        algorithm.SetNumberOfConditions(len(values))
        for k, value in enumerate(values):
            algorithm.SetCondition(k, value)
    if signal is not None:
        algorithm.SetSignalArrayName(array_name("signal", signal))
    algorithm.SetPredictionArrayName(array_name("name", name))
    algorithm.SetLabelArrayName(array_name("label_name", label_name))
    algorithm.SetClassNamesArrayName(array_name("class_names_name", class_names_name))
    algorithm.SetDisplacementArrayName(array_name("displacement_name", displacement_name))
    set_coupling(algorithm, component_coupling, coupling_weight, coupling_distance)
    return algorithm


def _numbers(conditions):
    """Finite numbers, of one or of a sequence."""
    if isinstance(conditions, np.ndarray) and conditions.ndim == 1:
        conditions = conditions.tolist()
    if not isinstance(conditions, (tuple, list)):
        conditions = [conditions]
    values = [real("conditions", value) for value in conditions]
    if not np.all(np.isfinite(values)):
        raise ValueError("conditions must be finite numbers")
    return values


def _arrays(output, algorithm):
    """The arrays that a filter has added to an output, as a NetworkOutput."""
    for data in (output.GetPointData(), output.GetCellData(), output.GetFieldData()):
        values = data.GetArray(algorithm.GetPredictionArrayName())
        if values is not None:
            break
    else:
        return NetworkOutput(np.zeros((0, 0), dtype=np.float32), None, [])  # of an empty mesh
    names = output.GetFieldData().GetAbstractArray(algorithm.GetClassNamesArrayName())
    names = [names.GetValue(k) for k in range(names.GetNumberOfValues())] if names is not None else []
    labels = data.GetArray(algorithm.GetLabelArrayName())
    labels = None if labels is None else vtk_to_numpy(labels).copy()
    tuples, components = values.GetNumberOfTuples(), values.GetNumberOfComponents()
    values = vtk_to_numpy(values).reshape(tuples, components).copy()
    if data is output.GetFieldData():
        values, labels = values[0], None if labels is None else int(labels[0])
    return NetworkOutput(values, labels, names)
