# SPDX-License-Identifier: BSD-3-Clause
"""Flow matching: functions around vtkFlowMatchingSampler and vtkFlowMatchingDeformer for datasets and NumPy arrays."""

import os
import warnings

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy

from .arguments import INT_MIN, array_name, choice, flag, in_range, integer, progress_callback, set_coupling, set_normalization
from .datasets import array_by_name, as_type_of, given_dataset
from .deprecation import renamed_keywords
from .errors import SurfaceSynthesisWarning
from .pipeline import apply_filter, outputs_at_times
from .vtkSurfaceSynthesisFlowMatching import vtkFlowMatchingDeformer, vtkFlowMatchingSampler

#: The methods of a step, by the name that ``integrator`` takes.
INTEGRATORS = {
    "euler": vtkFlowMatchingSampler.EULER,
    "midpoint": vtkFlowMatchingSampler.MIDPOINT,
    "runge_kutta_4": vtkFlowMatchingSampler.RUNGE_KUTTA_4,
}

_GIVEN_NOISE = "_GivenNoise"

_PARAMETERS = """
    mesh : vtkPolyData, composite dataset (vtkDataObjectTree) or pair (points, triangles)
        The surface, any triangulation of the shape of the training, turned as that was: triangles, polygons or strips,
        float or double points, open or closed, of any size and in any place. The mesh must have finite points, no
        degenerate triangle, no edge with more than two triangles, consistent winding and one component, or
        ``component_coupling``. A warning is
        given where good samples are unlikely: for a surface that is shaped or turned unlike those of the training, and
        for a closed one whose faces point inwards. A composite dataset is processed block by block, with noise that
        differs between blocks. A pair is an array of points [V, 3] and an integer array of triangles [F, 3]. The mesh
        is never modified.
    model : path
        The model file, safetensors, as vtkFlowMatchingTrainer writes it.
    seed : int
        Any integer of 32 bits with sign; each gives other noise, and so other samples. The same seed gives other samples
        on another triangulation; ``input_noise`` carries one over. Default 0.
    input_noise : str or array, optional
        The noise to begin with, in place of that of ``seed``: the name of a point array of the mesh, such as the
        "InitialNoise" of a sample that has come here from another triangulation; for a pair, an array [V, C]. In the
        units of the signal and about 0. ``samples`` must then be 1 or None. Default: the noise of ``seed``.
    samples : int, optional
        Number of samples, at least 1. Default: one sample.
    first_sample : int
        Index of the first sample, at least 0: an ensemble may be drawn in parts. Sample k is the same alone or in a
        batch. Default 0.
    steps : int
        Number of steps from noise to signal, from 1 to 10000, of equal length; more are more accurate and cost more.
        Default 20.
    integrator : str
        The method of a step: "euler", one evaluation of the network, first order; "midpoint", two, second order;
        "runge_kutta_4", four, fourth order. Default "midpoint".
    corrections : int, optional
        Number of corrections of a sample at the end of its flow, from 0 (none, as published) to 20: with n of them the
        signal f is replaced for k = 1, ..., n with the data that the model expects from t f at flow time t = 1/2 + k /
        (2 (n + 1)). Errors of the flow are removed as if they were noise; too many corrections remove detail of the data
        as well. Each costs one evaluation of the network. Default: 2 where the model predicts the data (``prediction`` of
        train_flow_matching(), by default for positions), else 0.
    temperature : float
        Factor of the noise of ``seed``, from 0 to 10. Above 1 samples vary more than the data of the training, below less; at
        0 all are the same. A little above 1 makes up for models that vary less than their data; far above, samples are unlike
        the data. It multiplies the temperature of the model file, which is 1 unless Examples/Training/temperature.py has found
        another. Not used with ``input_noise``. Default 1.
    trajectory : bool
        True returns the states at all flow times 0, 1 / steps, ..., 1, from noise to signal, instead of that at 1; the
        last one is corrected.
        Default False.
    initial_noise_name : str
        Name of the point array with the noise that a sample was made of. Default "InitialNoise"."""

_COUPLING = """    component_coupling : bool
        True couples the connected components of the surface, so that parts move together, such as eyes in a body: each
        point within ``coupling_distance`` of another component is tied to the nearest place there. Parts keep
        their offsets, which turn with the surface around them. Off, several components raise. Results do not depend
        on the order of the components, and one component gives the same bits as without. A component without a pair
        raises. Default False.
    coupling_weight : float
        Weight of the squared differences of coupled points against the Dirichlet energy, without unit, above 0; larger
        ties parts more tightly. Default 1e6.
    coupling_distance : float, optional
        Largest distance of two coupled points, in world units, at least 0. Default: 0.03 times the square root of the
        area of the surface.
    normalization_area : float, optional
        Area of the surface of which ``mesh`` is a part or a damaged copy, square world units, above 0. Models see surfaces
        moved to their centroid and scaled to area 1; with an area they see the mesh as the whole surface would be.
        vtkIntegrateAttributes on the whole surface gives area and center. Default: area and centroid of ``mesh``, of each
        block on its own.
    normalization_center : three floats, optional
        Centroid, weighted by area, of that surface, world units. Goes with ``normalization_area``.
"""

_RAISES = """
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


@renamed_keywords(noise="input_noise", noise_name="initial_noise_name")
def deform(
    mesh,
    model,
    seed=0,
    input_noise=None,
    samples=None,
    first_sample=0,
    steps=20,
    integrator="midpoint",
    corrections=None,
    trajectory=False,
    move_points=True,
    displacement_name="Displacement",
    initial_noise_name="InitialNoise",
    area_ratio_name="AreaRatio",
    progress=None,
    memory_limit=None,
    component_coupling=False,
    coupling_weight=1e6,
    coupling_distance=None,
    normalization_area=None,
    normalization_center=None,
    temperature=1.0,
):
    return _generated(configured_deformer, _positions, **locals())


deform.__doc__ = f"""Deforms a surface at random, as a flow matching model has learned it: poses, shapes, deformations.

    Parameters
    ----------{_PARAMETERS}
    move_points : bool
        True moves the points; False leaves the deformation in the arrays only. Default True.
    displacement_name, area_ratio_name : str
        Names of the point array with the displacement of each point, and of the cell array with the area of each polygon
        over that of the input. Default "Displacement" and "AreaRatio".
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the work stops.
    memory_limit : int, optional
        Memory that the output may take, MiB. More samples than fit raise an error before the work begins, whose text
        names a number that fits. Default: three quarters of the memory of the machine.
{_COUPLING}
    Returns
    -------
    dataset of the type of ``mesh``
        The deformed mesh with its own cells and arrays, and the arrays above; without normals, which are those of the old
        surface. With ``samples`` larger than 1 a vtkMultiBlockDataSet with a block for each. With ``trajectory`` a list
        of such datasets, one for each flow time.
    numpy.ndarray, for a pair
        The deformed points [V, 3], float64. ``samples``, when given (even 1), adds an axis in front, and ``trajectory``
        one before that: [V, 3], [N, V, 3], [steps + 1, V, 3] or [steps + 1, N, V, 3].
{_RAISES}"""


@renamed_keywords(noise="input_noise", noise_name="initial_noise_name")
def sample_signal(
    mesh,
    model,
    seed=0,
    input_noise=None,
    samples=None,
    first_sample=0,
    steps=20,
    integrator="midpoint",
    corrections=None,
    trajectory=False,
    name=None,
    initial_noise_name="InitialNoise",
    progress=None,
    memory_limit=None,
    component_coupling=False,
    coupling_weight=1e6,
    coupling_distance=None,
    normalization_area=None,
    normalization_center=None,
    temperature=1.0,
):
    return _generated(configured_sampler, _signal, **locals())


sample_signal.__doc__ = f"""Generates a signal on a surface, as a flow matching model has learned it.

    Parameters
    ----------{_PARAMETERS}
    name : str, optional
        Name of the point array with the signal. Default: that in the model file, "Position" for positions.
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the work stops.
    memory_limit : int, optional
        Memory that the output may take, MiB. More samples than fit raise an error before the work begins, whose text
        names a number that fits. Default: three quarters of the memory of the machine.
{_COUPLING}
    Returns
    -------
    dataset of the type of ``mesh``
        The mesh with two point arrays, float64: the signal, and the noise it was made of. Points that no polygon or strip
        uses get 0. With ``samples`` larger than 1 a vtkMultiBlockDataSet with a block for each. With ``trajectory`` a
        list of such datasets, one for each flow time.
    numpy.ndarray, for a pair
        The signal [V, C], float64. ``samples``, when given (even 1), adds an axis in front, and ``trajectory`` one before
        that: [V, C], [N, V, C], [steps + 1, V, C] or [steps + 1, N, V, C].
{_RAISES}"""


def configured_sampler(model, name=None, **parameters):
    """A vtkFlowMatchingSampler with the parameters of sample_signal(), which raises TypeError and ValueError."""
    algorithm = _configured(vtkFlowMatchingSampler(), model, **parameters)
    if name is not None:
        algorithm.SetSignalArrayName(array_name("name", name))
    return algorithm


def configured_deformer(
    model, move_points=True, displacement_name="Displacement", area_ratio_name="AreaRatio", **parameters
):
    """A vtkFlowMatchingDeformer with the parameters of deform(), which raises TypeError and ValueError."""
    algorithm = _configured(vtkFlowMatchingDeformer(), model, **parameters)
    algorithm.SetMovePoints(flag("move_points", move_points))
    algorithm.SetDisplacementArrayName(array_name("displacement_name", displacement_name))
    algorithm.SetAreaRatioArrayName(array_name("area_ratio_name", area_ratio_name))
    return algorithm


def _configured(
    algorithm,
    model,
    seed=0,
    input_noise=None,
    samples=None,
    first_sample=0,
    steps=20,
    integrator="midpoint",
    corrections=None,
    trajectory=False,
    initial_noise_name="InitialNoise",
    memory_limit=None,
    component_coupling=False,
    coupling_weight=1e6,
    coupling_distance=None,
    normalization_area=None,
    normalization_center=None,
    temperature=1.0,
):
    model = os.fspath(model)
    algorithm.SetModelFileName(model.decode() if isinstance(model, bytes) else model)
    algorithm.SetSeed(integer("seed", seed, INT_MIN))
    if input_noise is not None:
        algorithm.SetInputNoiseArrayName(array_name("input_noise", input_noise))
    algorithm.SetNumberOfSamples(1 if samples is None else integer("samples", samples, 1))
    algorithm.SetFirstSample(integer("first_sample", first_sample, 0))
    algorithm.SetMemoryLimit(0 if memory_limit is None else integer("memory_limit", memory_limit, 1))
    algorithm.SetNumberOfSteps(integer("steps", steps, 1, 10000))
    algorithm.SetIntegrator(choice("integrator", integrator, INTEGRATORS))
    algorithm.SetNumberOfCorrections(-1 if corrections is None else integer("corrections", corrections, 0, 20))
    algorithm.SetTemperature(in_range("temperature", temperature, 0.0, 10.0))
    algorithm.SetOutputTrajectory(flag("trajectory", trajectory))
    algorithm.SetInitialNoiseArrayName(array_name("initial_noise_name", initial_noise_name))
    set_coupling(algorithm, component_coupling, coupling_weight, coupling_distance)
    set_normalization(algorithm, normalization_area, normalization_center)
    return algorithm


def flow_times(algorithm):
    """The flow times of the outputs: all steps of a trajectory, or the end."""
    steps = algorithm.GetNumberOfSteps()
    return [k / steps for k in range(steps + 1)] if algorithm.GetOutputTrajectory() else [1.0]


def _generated(configure, result, mesh, input_noise, samples, progress, **parameters):
    """The result of deform() and of sample_signal(), whose arguments these are.

    ``configure`` makes the filter of ``parameters``; ``result`` prepares it for a pair, and returns a function that finds
    the array of an output, and the number of components of that of an empty one.
    """
    is_pair = isinstance(mesh, (tuple, list))
    dataset = given_dataset(mesh)
    input_noise = array_by_name(dataset, "input_noise", input_noise, _GIVEN_NOISE, is_pair, 1)
    algorithm = configure(input_noise=input_noise, samples=samples, **parameters)
    if not is_pair:
        return _outputs(algorithm, mesh, progress)
    return _stacked(algorithm, dataset, samples, progress, *result(algorithm))


def _positions(algorithm):
    """The moved points as the result of a vtkFlowMatchingDeformer."""
    algorithm.MovePointsOn()
    return lambda block: block.GetPoints().GetData(), 3


def _signal(algorithm):
    """The signal as the result of a vtkFlowMatchingSampler."""
    name = "Signal" if algorithm.GetInitialNoiseArrayName() != "Signal" else "_Signal"
    algorithm.SetSignalArrayName(name)
    return lambda block: block.GetPointData().GetArray(name), None


def _run(algorithm, dataset, progress):
    """The output at each flow time."""
    progress_callback(progress)
    if algorithm.GetOutputTrajectory():
        outputs, remarks = outputs_at_times(algorithm, dataset, flow_times(algorithm), progress)
    else:
        output, remarks = apply_filter(algorithm, dataset, progress)
        outputs = [output]
    for text in remarks:
        warnings.warn(text, SurfaceSynthesisWarning, stacklevel=6)
    return outputs


def _outputs(algorithm, mesh, progress):
    outputs = _run(algorithm, mesh, progress)
    if algorithm.GetNumberOfSamples() == 1:
        outputs = [as_type_of(mesh, output) for output in outputs]
    return outputs if algorithm.GetOutputTrajectory() else outputs[0]


def _stacked(algorithm, dataset, samples, progress, array_of, components):
    """The arrays of all flow times and samples as one."""
    values = []
    for output in _run(algorithm, dataset, progress):
        several = algorithm.GetNumberOfSamples() > 1
        blocks = [output.GetBlock(k) for k in range(output.GetNumberOfBlocks())] if several else [output]
        values.append([_values(block, array_of, components) for block in blocks])
    stacked = np.array(values, dtype=np.float64)
    if samples is None:
        stacked = stacked[:, 0]
    return stacked if algorithm.GetOutputTrajectory() else stacked[0]


def _values(block, array_of, components):
    if block.GetNumberOfPoints() == 0:
        return np.zeros((0, components or 0))
    array = array_of(block)
    return vtk_to_numpy(array).reshape(block.GetNumberOfPoints(), array.GetNumberOfComponents()).copy()
