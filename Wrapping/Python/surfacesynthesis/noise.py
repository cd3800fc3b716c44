# SPDX-License-Identifier: BSD-3-Clause
"""Matérn noise: a function around vtkMaternNoiseFilter that takes and returns datasets or NumPy arrays."""

import math
import warnings

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy

from .arguments import (
    INT_MIN,
    array_name,
    at_least_0,
    choice,
    flag,
    in_range,
    integer,
    positive,
    progress_callback,
    real,
    set_coupling,
)
from .datasets import DOMAINS, DOMAINS_TEXT, as_type_of, given_dataset
from .deprecation import renamed_keywords
from .errors import SurfaceSynthesisWarning
from .observations import observe
from .pipeline import apply_filter
from .vtkSurfaceSynthesisNoise import vtkMaternNoiseFilter

#: The distributions that can be sampled, by the name that ``noise_model`` takes.
NOISE_MODELS = {
    "matern": vtkMaternNoiseFilter.MATERN,
    "per_vertex": vtkMaternNoiseFilter.PER_VERTEX,
    "white": vtkMaternNoiseFilter.WHITE,
    "unscreened": vtkMaternNoiseFilter.UNSCREENED,
    "spectral": vtkMaternNoiseFilter.SPECTRAL,
}

#: The directions of displacements, by the name that ``displacement`` takes.
DISPLACEMENTS = {
    "no_displacement": vtkMaternNoiseFilter.NO_DISPLACEMENT,
    "free": vtkMaternNoiseFilter.FREE,
    "normal": vtkMaternNoiseFilter.NORMAL,
    "tangential": vtkMaternNoiseFilter.TANGENTIAL,
}

#: The conditions at the boundary, by the name that ``boundary_condition`` takes.
BOUNDARY_CONDITIONS = {
    "neumann": vtkMaternNoiseFilter.NEUMANN,
    "dirichlet": vtkMaternNoiseFilter.DIRICHLET,
    "robin": vtkMaternNoiseFilter.ROBIN,
}


@renamed_keywords(model="noise_model")
def matern_noise(
    mesh,
    range=None,
    standard_deviation=1.0,
    seed=0,
    samples=None,
    first_sample=0,
    components=1,
    screening=None,
    normalized_screening=None,
    noise_model="matern",
    eigenpairs=256,
    name="MaternNoise",
    progress=None,
    memory_limit=None,
    operator_power=2,
    variance_correction=False,
    boundary_condition="neumann",
    robin_coefficient=None,
    boundary_array=None,
    range_factor_array=None,
    direction_array=None,
    anisotropy_ratio=None,
    barrier_array=None,
    gather_pieces=True,
    coherent_noise=False,
    observations=None,
    observation_array=None,
    observation_deviation_array=None,
    tolerance=None,
    posterior_mean=False,
    posterior_standard_deviation=False,
    displacement="no_displacement",
    moved_points=False,
    observed_targets=False,
    component_coupling=False,
    coupling_weight=1e6,
    coupling_distance=None,
):
    """Gaussian random fields on a surface or in a volume, whose statistics do not depend on its mesh.

    The field f solves the screened Poisson equation (L + tau M) f = sqrt(M) n, with L the cotangent stiffness, M the
    lumped mass and n independent normal numbers: its variance at spatial frequency lambda is 1 / (lambda + tau)^2,
    whatever the mesh. In a volume of tetrahedra L and M are those of linear finite elements. The same seed gives the
    same bits for every number of threads, and sample k is the same alone or in a batch.

    Parameters
    ----------
    mesh : vtkPolyData, vtkUnstructuredGrid, composite dataset (vtkDataObjectTree) or pair (points, cells)
        Triangles, polygons or strips, float or double points, open or closed. The mesh must have finite points, no
        degenerate triangle and no edge with more than two triangles. A composite dataset is processed block by block,
        with noise that differs between blocks. A volume is a vtkUnstructuredGrid of vtkTetra cells, each with a volume,
        and of at most two at a face; vertices, lines and polygons in it are ignored. A pair is an array of points
        [V, 3] and an integer array of triangles [F, 3] or tetrahedra [T, 4]. The mesh is never modified.
    range : float, optional
        The distance at which the correlation of two points has fallen to about 0.14, in world units, measured along
        the surface; larger is smoother. Larger than 0; tau = 8 nu / range^2, nu = operator_power - 1 on surfaces
        and operator_power - 3/2 in volumes. Default: 0.2
        times the longest side of the bounding box of the mesh, or of the block. A warning is given where edges are
        longer than a third of the range.
    standard_deviation : float
        The standard deviation of the noise, in the units wanted for the output; at least 0. Exact on closed surfaces
        that are wide and finely divided for the range; parts narrower than the range (fingers, a tail) have a larger
        one, and so has the neighbourhood of an open boundary, by a factor sqrt(2) on a straight one.
        Goes with ``range``, with ``variance_correction``, which makes it exact everywhere, and with the noise model
        "per_vertex". Default 1.
    seed : int
        Any integer of 32 bits with sign; each gives other noise. Default 0.
    samples : int, optional
        Number of samples, at least 1. Default: one sample.
    first_sample : int
        Index of the first sample, at least 0: an ensemble may be drawn in parts. Default 0.
    components : int
        Number of components, independent of each other; at least 1. Three make a random displacement. Default 1.
    screening : float, optional
        Instead of ``range``: the screening term tau, in 1 / square world units, larger than 0; larger is rougher and
        weaker (the correlation range is sqrt(8 / tau)). 100 is the value for shapes of unit size in "Matérn Noise for
        Triangulation-Agnostic Flow Matching on Meshes" (Algorithm 1).
    normalized_screening : float, optional
        Instead of ``range``: the factor c in tau = c Gamma, without unit, larger than 0, where Gamma is the Frobenius
        norm of M^-1 L; the noise is multiplied by sqrt(Gamma) (Algorithm 2). It does not change when the mesh is
        scaled. Gamma grows with the number of points, so c that suits one resolution is too large for a finer one.
    noise_model : str
        "matern" (the default) or, for comparison, "per_vertex": one independent normal number per point, depends on
        the triangulation; "white": discrete white noise N(0, M^-1); "unscreened": tau = 0, orthogonal to constants;
        "spectral": Matérn noise truncated to the lowest eigenpairs. The scale goes with "matern" and "spectral" only.
    eigenpairs : int
        Number of eigenpairs of the noise model "spectral", the constant one included; at least 1 and below the number
        of points. The cost grows with its square. Default 256.
    name : str
        Name of the point array. Default "MaternNoise".
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the work stops.
    memory_limit : int, optional
        Memory that the output may take, MiB. More samples than fit raise an error before the work begins, whose text
        names a number that fits. Where the factor would exceed the limit by estimate, conjugate gradients with a
        multigrid preconditioner solve in its place. Default: three quarters of the memory of the machine.
    operator_power : float
        The power alpha of the operator, 1 to 4: the variance at the eigenvalue lambda is 1 / (lambda + tau)^alpha, and
        the smoothness nu = alpha - 1, in volumes alpha - 3/2; larger is smoother. Integers are exact; numbers between
        them are approximated by rational functions, the standard deviation at every eigenvalue to 1e-4, with 3 to 12
        factorisations and solves in place of one. 1, in volumes up to 1.5, has no finite variance in the limit of fine
        meshes and no range: it goes with ``screening`` and ``normalized_screening`` only.
        Goes with the noise models "matern" and "spectral". Default 2, that of the paper.
    variance_correction : bool
        Makes the standard deviation exact at every point, with ``range`` and with the other scales, also at
        boundaries, on thin parts and on coarse meshes, in about 1 (alpha = 1), 3 (2), 6 (3) or 9 (4) times the time
        of the factorisation (other alpha: 3 times that of each). Points at which the boundary condition sets the noise to 0 stay 0. This and all
        arguments below go with the noise model "matern". Default False.
    boundary_condition : str
        The condition at the boundary of the surface, and of barriers: "neumann" (the default): the normal derivative
        is 0, which raises the deviation there; "dirichlet": the noise is 0; "robin": between both.
    robin_coefficient : float, optional
        Coefficient c of "robin", df/dn + c sqrt(tau) f = 0 with the outward normal n and the tau of the
        place, without unit, at least 0.
        Default 0.55, with which the deviation at a straight boundary is that of the interior for ``operator_power`` 2;
        at a plane boundary of a volume it is with 1.
    boundary_array : str, optional
        Name of a point array, 1 component, that chooses the points of the boundary condition: those with a number
        other than 0. "dirichlet": the noise is 0 at these points, on the boundary or inside; "robin": on boundary
        edges between two such points, in volumes on boundary faces of three. Default: the whole boundary.
    range_factor_array : str, optional
        Name of a point array, 1 component, numbers above 0 without unit: factors of the correlation range at each
        point, with tau divided by the factor squared.
    direction_array : str, optional
        Name of a point array with a vector for each point, the direction in which the noise is stretched: 3 components
        of any length and sign, on surfaces projected to them; 0 for no direction.
    anisotropy_ratio : float, optional
        Ratio of the correlation range along the directions of ``direction_array`` to that across, without unit, from
        1e-6 to 1e6; ``range`` is their geometric mean, in volumes that along one direction and across in two.
        Default 4.
    barrier_array : str, optional
        Name of a cell array, 1 component, of barriers: cells with a number other than 0, which the correlation does
        not cross but goes around. The boundary condition holds at their edges; points inside get 0.
    gather_pieces : bool
        True: a surface whose pieces lie on several MPI ranks is gathered on each of them. False: it is solved where the
        pieces lie, by PETSc and hypre, in a memory for each rank that decreases with the number of ranks; the noise is that
        of the gathered surface to 1e-8. Goes with the noise model "matern", an ``operator_power`` of 2 or 4 and the boundary
        condition "neumann", without coherent noise, displacement, observations and arrays. Changes nothing for a surface
        on one rank. Default True.
    coherent_noise : bool
        True for noise that belongs to places in space instead of to points of the mesh: the same seed gives the same
        noise, up to discretization, on all triangulations of one surface at the same place, with correlations above
        0.95 where ``range`` is ten edges or more. A surface that is moved, or scaled by no power of 2, gets other noise. Goes
        with surfaces, the noise model "matern" and an ``operator_power`` other than 1 and 3. Default False.
    observations : vtkPointSet or numpy.ndarray, optional
        Points near the surface, or in the volume, at which the noise is known, or an array of points [n, 3]. The
        samples are then samples of the noise given the observations (its posterior). Goes with the noise model
        "matern" and a single surface or volume.
    observation_array : str or numpy.ndarray, optional
        The point array of the observations with the values, of ``components`` components, or 3 with ``displacement``; or an
        array [n] or [n, C]. Default: the active scalars, or vectors where only these have three components that are needed.
    observation_deviation_array : str or numpy.ndarray, optional
        The point array of the observations with the standard deviations of the values, at least 0; or an array [n].
        Where it is 0, the samples take the value to 1e-8. Default: 0 everywhere.
    tolerance : float, optional
        The largest distance of an observation from the surface or volume, in world units; one farther away is an error.
        Default: a hundredth of the longest side of the bounding box of the surface.
    posterior_mean : bool
        True adds the mean of the noise given the observations, as array ``name_Mean``. Default False.
    posterior_standard_deviation : bool
        True adds its standard deviation, as array ``name_StandardDeviation``; for "tangential" the root mean square over the
        tangent directions. Default False. Both go with ``observations``.
    displacement : str
        "free", "normal" or "tangential" for noise that is a displacement of the surface, in world units, of three components:
        three independent ones; one field times the unit vertex normal; or three fields without their part along that normal.
        The standard deviation is ``standard_deviation`` along every one of the directions, exactly with
        ``variance_correction``, and 0 along the others. "normal" and "tangential" need triangles that are wound alike.
        Samples that invert triangles cause a warning; an ``operator_power`` above 2 gives smoother shapes. With
        ``observations`` the samples are shapes through landmarks. Default "no_displacement".
    moved_points : bool
        True moves the points of the result by the displacement, which stays as an array; normals are dropped. Goes with
        ``displacement`` and one sample. Default False.
    observed_targets : bool
        True when the values of the observations are the positions that the points of the surface nearest to them are to
        take; False when they are the displacements of these points. Parts that the directions exclude cause a warning that
        names the observations. Goes with ``displacement`` and ``observations``. Default False.
    component_coupling : bool
        True couples the connected components of the surface, so that parts move together, such as eyes in a body: each
        point within ``coupling_distance`` of another component is tied to the nearest place there. Goes with surfaces;
        off, components are independent. Results do not depend on the order of the components, and one component gives
        the same bits as without. A component without a pair raises. Default False.
    coupling_weight : float
        Weight of the squared differences of coupled points against the Dirichlet energy, without unit, above 0; larger
        ties parts more tightly. Default 1e6.
    coupling_distance : float, optional
        Largest distance of two coupled points, in world units, at least 0. Default: 0.03 times the square root of the
        area of the surface.

    Returns
    -------
    dataset of the type of ``mesh``
        The mesh with one float64 point array ``name`` or, when ``samples`` is larger than 1, the arrays ``name_k`` for
        k = first_sample, first_sample + 1, ..., the first of them active: as scalars and, with three components, as
        vectors, where ``mesh`` has none. Points that no polygon, strip or tetrahedron uses get 0. An instance of a
        Python subclass is returned when its constructor takes a VTK dataset, or none.
    numpy.ndarray, for a pair
        The noise, float64, of shape [V]. ``samples``, when given (even 1), adds an axis in front, and ``components``
        larger than 1, or a ``displacement``, an axis at the end: [V], [V, C], [N, V] or [N, V, C].

    Raises
    ------
    SurfaceSynthesisError
        The noise could not be computed. The text names the defect of the mesh, the first cell or point, and the
        filter that repairs it; for a composite dataset it holds a line for each bad block.
    Cancelled
        ``progress`` returned False.
    ValueError, TypeError
        An argument has a value out of its range, contradicts another, or is of a wrong type.
    """
    noise = configured_filter(
        range=range,
        standard_deviation=standard_deviation,
        seed=seed,
        samples=samples,
        first_sample=first_sample,
        components=components,
        screening=screening,
        normalized_screening=normalized_screening,
        noise_model=noise_model,
        eigenpairs=eigenpairs,
        name=name,
        memory_limit=memory_limit,
        operator_power=operator_power,
        variance_correction=variance_correction,
        boundary_condition=boundary_condition,
        robin_coefficient=robin_coefficient,
        boundary_array=boundary_array,
        range_factor_array=range_factor_array,
        direction_array=direction_array,
        anisotropy_ratio=anisotropy_ratio,
        barrier_array=barrier_array,
        gather_pieces=gather_pieces,
        coherent_noise=coherent_noise,
        component_coupling=component_coupling,
        coupling_weight=coupling_weight,
        coupling_distance=coupling_distance,
        observations=observations,
        observation_array=observation_array,
        observation_deviation_array=observation_deviation_array,
        tolerance=tolerance,
        posterior_mean=posterior_mean,
        posterior_standard_deviation=posterior_standard_deviation,
        displacement=displacement,
        moved_points=moved_points,
        observed_targets=observed_targets,
    )
    if isinstance(mesh, (tuple, list)) and moved_points:
        raise ValueError("moved_points moves those of a dataset: give mesh as a vtkPolyData, not as a pair of arrays")
    if isinstance(mesh, (tuple, list)) and (posterior_mean or posterior_standard_deviation):
        raise ValueError("posterior arrays are added to a dataset: give mesh as a dataset, not as a pair of arrays")
    progress_callback(progress)
    output, remarks = apply_filter(noise, given_dataset(mesh, DOMAINS, DOMAINS_TEXT), progress)
    for text in remarks:
        warnings.warn(text, SurfaceSynthesisWarning, stacklevel=3)
    if isinstance(mesh, (tuple, list)):
        return _array(output, noise, samples is not None)
    return as_type_of(mesh, output)


def configured_filter(
    range=None,
    standard_deviation=1.0,
    seed=0,
    samples=None,
    first_sample=0,
    components=1,
    screening=None,
    normalized_screening=None,
    noise_model="matern",
    eigenpairs=256,
    name="MaternNoise",
    memory_limit=None,
    operator_power=2,
    variance_correction=False,
    boundary_condition="neumann",
    robin_coefficient=None,
    boundary_array=None,
    range_factor_array=None,
    direction_array=None,
    anisotropy_ratio=None,
    barrier_array=None,
    gather_pieces=True,
    coherent_noise=False,
    observations=None,
    observation_array=None,
    observation_deviation_array=None,
    tolerance=None,
    posterior_mean=False,
    posterior_standard_deviation=False,
    displacement="no_displacement",
    moved_points=False,
    observed_targets=False,
    component_coupling=False,
    coupling_weight=1e6,
    coupling_distance=None,
):
    """A vtkMaternNoiseFilter with the parameters of matern_noise(), which raises TypeError and ValueError."""
    model_id = choice("noise_model", noise_model, NOISE_MODELS)
    array_name("name", name)

    scales = {"range": range, "screening": screening, "normalized_screening": normalized_screening}
    scales = {key: positive(key, value) for key, value in scales.items() if value is not None}
    deviation = real("standard_deviation", standard_deviation)
    if not 0.0 <= deviation < math.inf:
        raise ValueError(f"standard_deviation must be a finite number, at least 0, not {deviation:g}")
    _check_combination(noise_model, scales, deviation, variance_correction)

    noise = vtkMaternNoiseFilter()
    noise.SetNoiseModel(model_id)
    noise.SetStandardDeviation(deviation)
    if "range" in scales:
        noise.SetCorrelationRange(scales["range"])
    elif "screening" in scales:
        noise.SetScaleModeToScreening()
        noise.SetScreening(scales["screening"])
    elif "normalized_screening" in scales:
        noise.SetScaleModeToNormalizedScreening()
        noise.SetNormalizedScreening(scales["normalized_screening"])
    noise.SetSeed(integer("seed", seed, INT_MIN))
    noise.SetNumberOfSamples(1 if samples is None else integer("samples", samples, 1))
    noise.SetFirstSample(integer("first_sample", first_sample, 0))
    noise.SetMemoryLimit(0 if memory_limit is None else integer("memory_limit", memory_limit, 1))
    noise.SetNumberOfComponents(integer("components", components, 1))
    noise.SetNumberOfEigenpairs(integer("eigenpairs", eigenpairs, 1))
    noise.SetOutputArrayName(name)
    noise.SetOperatorPower(in_range("operator_power", operator_power, 1, 4))
    noise.SetVarianceCorrection(flag("variance_correction", variance_correction))
    noise.SetBoundaryCondition(choice("boundary_condition", boundary_condition, BOUNDARY_CONDITIONS))
    if robin_coefficient is not None:
        noise.SetRobinCoefficient(at_least_0("robin_coefficient", robin_coefficient))
    if anisotropy_ratio is not None:
        noise.SetAnisotropyRatio(in_range("anisotropy_ratio", anisotropy_ratio, 1e-6, 1e6))
    arrays = {
        "boundary_array": (boundary_array, noise.SetBoundaryArrayName),
        "range_factor_array": (range_factor_array, noise.SetRangeFactorArrayName),
        "direction_array": (direction_array, noise.SetDirectionArrayName),
        "barrier_array": (barrier_array, noise.SetBarrierArrayName),
    }
    arrays = {key: pair for key, pair in arrays.items() if pair[0] is not None}
    for key, (value, set_name) in arrays.items():
        array_name(key, value)
        set_name(value)
    _check_variations(noise, noise_model, arrays, robin_coefficient, anisotropy_ratio)
    noise.SetGatherPieces(flag("gather_pieces", gather_pieces))
    noise.SetCoherentNoise(flag("coherent_noise", coherent_noise))
    set_coupling(noise, component_coupling, coupling_weight, coupling_distance)
    if coherent_noise and operator_power in (1, 3):
        raise ValueError(f"coherent_noise goes with an operator_power other than 1 and 3, not {operator_power:g}")
    noise.SetPosteriorMean(flag("posterior_mean", posterior_mean))
    noise.SetPosteriorStandardDeviation(flag("posterior_standard_deviation", posterior_standard_deviation))
    observe(noise, observations, observation_array, observation_deviation_array, tolerance)
    noise.SetDisplacement(choice("displacement", displacement, DISPLACEMENTS))
    noise.SetMovedPoints(flag("moved_points", moved_points))
    noise.SetObservedTargets(flag("observed_targets", observed_targets))
    given = {"observation_array": observation_array, "observation_deviation_array": observation_deviation_array,
             "tolerance": tolerance, "posterior_mean": posterior_mean or None,
             "posterior_standard_deviation": posterior_standard_deviation or None,
             "observed_targets": observed_targets or None}
    _check_observations(noise, observations, [key for key, value in given.items() if value is not None], components)
    if noise_model != "matern" and (coherent_noise or observations is not None):
        argument = "coherent_noise" if coherent_noise else "observations"
        raise ValueError(f"{argument} has no meaning for the model '{noise_model}'")
    return noise


def _check_variations(noise, model, arrays, robin_coefficient, anisotropy_ratio):
    """Raises ValueError for arguments of operator, boundary and arrays that would have no effect."""
    given = list(arrays)
    given += ["variance_correction"] * noise.GetVarianceCorrection()
    given += ["boundary_condition"] * (noise.GetBoundaryCondition() != vtkMaternNoiseFilter.NEUMANN)
    if given and model != "matern":
        raise ValueError(f"{given[0]} has no meaning for the model '{model}'")
    if noise.GetOperatorPower() != 2 and model not in ("matern", "spectral"):
        raise ValueError(f"operator_power has no meaning for the model '{model}'")
    if noise.GetOperatorPower() == 1 and noise.GetScaleMode() == vtkMaternNoiseFilter.CORRELATION_RANGE:
        raise ValueError("operator_power 1 has no finite variance and no range: it goes with screening")
    if robin_coefficient is not None and noise.GetBoundaryCondition() != vtkMaternNoiseFilter.ROBIN:
        raise ValueError("robin_coefficient goes with boundary_condition 'robin'")
    if "boundary_array" in arrays and noise.GetBoundaryCondition() == vtkMaternNoiseFilter.NEUMANN:
        raise ValueError("boundary_array goes with boundary_condition 'dirichlet' or 'robin'")
    if anisotropy_ratio is not None and "direction_array" not in arrays:
        raise ValueError("anisotropy_ratio goes with direction_array")


def _check_observations(noise, observations, given, components):
    """Raises ValueError for arguments of observations and displacements that would have no effect."""
    if observations is None and given:
        raise ValueError(f"{given[0]} goes with observations")
    displaced = noise.GetDisplacement() != vtkMaternNoiseFilter.NO_DISPLACEMENT
    for key, value in (("moved_points", noise.GetMovedPoints()), ("observed_targets", noise.GetObservedTargets())):
        if value and not displaced:
            raise ValueError(f"{key} goes with displacement")
    if displaced and components not in (1, 3):
        raise ValueError(f"a displacement has 3 components, not {components}")
    if noise.GetMovedPoints() and noise.GetNumberOfSamples() > 1:
        raise ValueError(f"moved_points goes with one sample, not {noise.GetNumberOfSamples()}")


def _check_combination(model, scales, deviation, corrected):
    """Raises ValueError for arguments that exclude each other or would have no effect."""
    if len(scales) > 1:
        raise ValueError(f"{' and '.join(scales)} exclude each other: each says how smooth the noise is")
    if scales and model not in ("matern", "spectral"):
        raise ValueError(f"{next(iter(scales))} has no meaning for the model '{model}'")
    if deviation != 1.0:
        if "range" not in scales and scales and not corrected:
            raise ValueError(f"standard_deviation goes with range, not with {next(iter(scales))}")
        if model in ("white", "unscreened"):
            raise ValueError(f"standard_deviation has no meaning for the model '{model}'")


def array_names(noise):
    """The names of the arrays that a filter adds."""
    name, first, samples = noise.GetOutputArrayName(), noise.GetFirstSample(), noise.GetNumberOfSamples()
    return [name] if samples == 1 else [f"{name}_{first + k}" for k in np.arange(samples)]


def _array(output, noise, samples_axis):
    """The arrays that a filter added, as one NumPy array."""
    displaced = noise.GetDisplacement() != vtkMaternNoiseFilter.NO_DISPLACEMENT
    points, components = output.GetNumberOfPoints(), 3 if displaced else noise.GetNumberOfComponents()
    values = np.zeros((noise.GetNumberOfSamples(), points, components))
    if points > 0:
        for sample, name in enumerate(array_names(noise)):
            array = output.GetPointData().GetArray(name)
            values[sample] = vtk_to_numpy(array).reshape(points, components)
    if components == 1:
        values = values[:, :, 0]
    return values if samples_axis else values[0]
