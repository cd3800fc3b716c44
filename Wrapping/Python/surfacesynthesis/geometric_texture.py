# SPDX-License-Identifier: BSD-3-Clause
"""Geometric textures: functions around vtkGeometricTextureSynthesizer and vtkGeometricTextureDistance."""

import math
import os
import warnings

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkPolyData

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
)
from .datasets import as_type_of, given_dataset
from .deprecation import renamed_keywords
from .errors import SurfaceSynthesisWarning
from .pipeline import apply_filter, call_method
from .vtkSurfaceSynthesisGeometricTexture import vtkGeometricTextureSynthesizer
from .vtkSurfaceSynthesisStatistics import vtkGeometricTextureDistance

#: The preparations of a target, by the name that ``prepare`` takes.
PREPARATIONS = {
    "as_is": vtkGeometricTextureSynthesizer.AS_IS,
    "subdivide": vtkGeometricTextureSynthesizer.SUBDIVIDE,
    "remesh": vtkGeometricTextureSynthesizer.REMESH,
}

#: The statistics that normalize the channels of the networks, by the name that ``norm_statistics`` takes.
NORM_STATISTICS = {
    "target": vtkGeometricTextureSynthesizer.TARGET,
    "reference": vtkGeometricTextureSynthesizer.REFERENCE,
}


@renamed_keywords(mask_name="mask", levels="output_levels")
def geometric_texture(
    mesh,
    model,
    seed=0,
    start_level=0,
    end_level=None,
    noise_amplitude=None,
    levels_without_noise=(),
    second_seed=1,
    interpolation=0.0,
    scale=None,
    prepare=None,
    mask=None,
    mask_falloff=0.0,
    random_from=0,
    output_levels=False,
    displacement_name="Displacement",
    level_name="Level",
    progress=None,
    norm_statistics="target",
    printable=False,
    strength=1.0,
    strength_array=None,
    second_model=None,
    blend=None,
    size=None,
    restarts=None,
):
    """Synthesizes the geometric texture that a model has learned from one mesh on another.

    Parameters
    ----------
    mesh : vtkPolyData, composite dataset (vtkDataObjectTree), pair (points, triangles) or None
        The target, of any genus: triangles, polygons or strips, float or double points, open or closed, any number of
        components. The mesh must have finite points, no degenerate triangle, no edge with more than two triangles and
        consistent winding; triangles should be of even size and shape, and the texture is as large as they are. A
        composite dataset is processed block by block, with noise that differs between blocks. A pair is an array of
        points [V, 3] and an integer array of triangles [F, 3]. The mesh is never modified. None: the template in the
        model file.
    model : path
        The model file, safetensors, as the training of geometric textures writes it.
    seed : int
        Any integer of 32 bits with sign; each gives another sample of the texture. Default 0.
    start_level : int
        The generator level that works on the target as it is, from 0 to the last. Default 0.
    end_level : int, optional
        The last generator level, at least 0; above the model's last: that one. Default: the model's last.
    noise_amplitude : float, optional
        Standard deviation of the noise on each coordinate, in mean edge lengths of a level, from 0, no noise, to 1e6.
        Default: that of the training.
    levels_without_noise : iterable of int
        The generator levels that get no noise. Default ().
    second_seed : int
        The seed of the noise that ``interpolation`` leads to. Default 1.
    interpolation : float
        From the noise of ``seed`` at 0 to that of ``second_seed`` at 1. Default 0.
    scale : float, optional
        Size of the texture over that on the target as it is, from 0.001 to 1000. Default: 1.
    prepare : str, optional
        The preparation of the target: "as_is", nothing, and ``scale`` must not be given;
        "subdivide", triangles are cut into four, each time of which halves the texture, as often as comes nearest to
        ``scale``; "remesh", even triangles with ``scale`` times the mean edge length of the target take their place, as
        remesh() makes them, and above 1 the texture gets larger, which needs CGAL. Default: "subdivide" when ``scale``
        is given, else "as_is".
    mask : str, optional
        Name of a point array of the target with one component, from 0 to 1, that displacements are multiplied with.
        Default: displacements everywhere.
    mask_falloff : float
        Distance from points whose mask is 0 over which the texture rises to its full strength, along edges, in world
        units, at least 0. Default 0.
    random_from : int
        For ``mesh`` None: the first generator level with noise of the seed; below it the noise is what reconstructs the
        reference of the training. Must be 0 with a flow, which does not reconstruct. Default 0.
    output_levels : bool
        True returns the surfaces after each level, coarse to fine, instead of the last one. Default False.
    displacement_name, level_name : str
        Names of the point arrays with the displacement of each point and the level with which it came. Default
        "Displacement" and "Level".
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the work stops.
    norm_statistics : str
        The statistics that normalize the channels of the networks: "target", those over the whole target, as published,
        which suit targets that are curved otherwise than the reference; "reference", those on samples of the reference,
        which the training writes into the model file (add_texture_statistics() for others): the texture at a point depends
        on the target nearby alone: another component changes nothing, and the mask fades the result, nothing else. Default
        "target".
    restarts : int, optional
        For a model that is a flow (``objective`` of train_geometric_texture()): restarts at each level, from 0 to 20. At the
        end of the flow the displacements are mixed with fresh noise as at half of its time, and go on from there again, which
        mends features that are too close to each other. Each takes half of the time of the flow itself. Default: 3.
    printable : bool
        True reduces displacements until no triangles of the output intersect, for slicers of 3D printers; needs CGAL. Where
        triangles intersect, first the tangential part of the displacements falls, then the part along the normals of the
        target. Where triangles of the target itself intersect they remain, with a warning. Takes two to five times as long as
        the synthesis with one thread, and longer where many intersect. Default False.
    strength : float
        Factor of the displacements of the synthesized texture, from 0 to 1e6. The networks see the texture without it, so that
        its pattern stays, above 1 too; ``printable`` reduces the result. Default 1.
    strength_array : str, optional
        Name of a point array of the target with one component, from 0 to 1e6, that ``strength`` is multiplied with.
        Default: 1 everywhere.
    second_model : path, optional
        A second model file with as many levels. At each level both networks take the same mesh and the same noise, and their
        displacements are added with the weights 1 - w and w, where w is the array ``blend``. Default: one model.
    blend : str, optional
        Name of a point array of the target with one component, from 0, the texture of ``model``, to 1, that of
        ``second_model``; goes with it.
    size : str, optional
        Name of a point array of the target with one component, from 0.01 to 100, that multiplies the size of the texture from
        place to place, with ``prepare`` "remesh". Default: one size.

    Returns
    -------
    dataset of the type of ``mesh``
        Triangles, four times as many for each level after the first, with the target's arrays interpolated and those
        above; without normals. A vtkPolyData for None. With ``output_levels`` a list of such datasets.
    pair of numpy.ndarray, for a pair
        Points [V, 3], float64, and triangles [F, 3], int64. With ``output_levels`` a list of such pairs.

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
    algorithm = configured_synthesizer(
        model,
        seed=seed,
        start_level=start_level,
        end_level=end_level,
        noise_amplitude=noise_amplitude,
        levels_without_noise=levels_without_noise,
        second_seed=second_seed,
        interpolation=interpolation,
        scale=scale,
        prepare=prepare,
        mask=mask,
        mask_falloff=mask_falloff,
        random_from=random_from,
        output_levels=output_levels,
        displacement_name=displacement_name,
        level_name=level_name,
        norm_statistics=norm_statistics,
        printable=printable,
        strength=strength,
        strength_array=strength_array,
        second_model=second_model,
        blend=blend,
        size=size,
        restarts=restarts,
    )
    dataset = None if mesh is None else given_dataset(mesh)
    output, remarks = apply_filter(algorithm, dataset, progress_callback(progress))
    for text in remarks:
        warnings.warn(text, SurfaceSynthesisWarning, stacklevel=3)
    if not output_levels:
        return _returned(mesh, output)
    return [_returned(mesh, output.GetBlock(k)) for k in range(output.GetNumberOfBlocks())]


def configured_synthesizer(
    model,
    seed=0,
    start_level=0,
    end_level=None,
    noise_amplitude=None,
    levels_without_noise=(),
    second_seed=1,
    interpolation=0.0,
    scale=None,
    prepare=None,
    mask=None,
    mask_falloff=0.0,
    random_from=0,
    output_levels=False,
    displacement_name="Displacement",
    level_name="Level",
    norm_statistics="target",
    printable=False,
    strength=1.0,
    strength_array=None,
    second_model=None,
    blend=None,
    size=None,
    restarts=None,
):
    """A vtkGeometricTextureSynthesizer with the parameters of geometric_texture(); raises TypeError and ValueError."""
    algorithm = vtkGeometricTextureSynthesizer()
    model = os.fspath(model)
    algorithm.SetModelFileName(model.decode() if isinstance(model, bytes) else model)
    algorithm.SetSeed(integer("seed", seed, INT_MIN))
    algorithm.SetStartLevel(integer("start_level", start_level, 0))
    algorithm.SetEndLevel(-1 if end_level is None else integer("end_level", end_level, 0))
    amplitude = -1.0 if noise_amplitude is None else in_range("noise_amplitude", noise_amplitude, 0.0, 1e6)
    algorithm.SetNoiseAmplitude(amplitude)
    algorithm.SetNumberOfRestarts(-1 if restarts is None else integer("restarts", restarts, 0, 20))
    algorithm.SetNormStatistics(choice("norm_statistics", norm_statistics, NORM_STATISTICS))
    without_noise = [integer("levels_without_noise", level, 0) for level in levels_without_noise]
    algorithm.SetLevelsWithoutNoise(" ".join(map(str, without_noise)))
    algorithm.SetSecondSeed(integer("second_seed", second_seed, INT_MIN))
    algorithm.SetInterpolation(in_range("interpolation", interpolation, 0.0, 1.0))
    if prepare is None:
        prepare = "as_is" if scale is None else "subdivide"
    algorithm.SetTargetPreparation(choice("prepare", prepare, PREPARATIONS))
    if scale is not None:
        if prepare == "as_is":
            raise ValueError('scale is of no use with prepare "as_is"; "subdivide" or "remesh" changes the size')
        algorithm.SetTextureScale(in_range("scale", scale, 0.001, 1000.0))
    if size is not None:
        if prepare != "remesh":
            raise ValueError('size is of use with prepare "remesh" only, which makes triangles of that size')
        algorithm.SetSizeArrayName(array_name("size", size))
    if mask is not None:
        algorithm.SetMaskArrayName(array_name("mask", mask))
    algorithm.SetMaskFalloff(at_least_0("mask_falloff", mask_falloff))
    if (second_model is None) != (blend is None):
        raise ValueError("second_model and blend go together: a model and the point array with its share")
    if second_model is not None:
        algorithm.SetSecondModelFileName(os.fsdecode(second_model))
        algorithm.SetBlendArrayName(array_name("blend", blend))
    algorithm.SetStrength(in_range("strength", strength, 0.0, 1e6))
    if strength_array is not None:
        algorithm.SetStrengthArrayName(array_name("strength_array", strength_array))
    algorithm.SetPrintable(flag("printable", printable))
    algorithm.SetRandomFromLevel(integer("random_from", random_from, 0))
    algorithm.SetOutputLevels(flag("output_levels", output_levels))
    algorithm.SetDisplacementArrayName(array_name("displacement_name", displacement_name))
    algorithm.SetLevelArrayName(array_name("level_name", level_name))
    return algorithm


def add_texture_statistics(model, output, measured_samples=8):
    """Writes a model of a geometric texture with the statistics that normalize its channels (``norm_statistics``).

    Trainings write them; this is for models of earlier versions, and for converted ones. The same model gives the same file.

    Parameters
    ----------
    model : path
        The model file; it needs a template.
    output : path
        The file to write; ``model`` itself is possible.
    measured_samples : int
        Number of random samples of the template that are measured, from 1 to 1000. Default 8.

    Raises
    ------
    SurfaceSynthesisError
        The model cannot be read or has no template, or the file cannot be written.
    ValueError, TypeError
        An argument has a value out of its range or is of a wrong type.
    """
    algorithm = configured_synthesizer(model)
    count = integer("measured_samples", measured_samples, 1, 1000)
    call_method(algorithm, "WriteModelWithStatistics", os.fsdecode(output), count)


def geometric_texture_distance(
    mesh, reference, unit_length=None, reference_unit_length=None, projections=128, seed=0, rings=1, progress=None
):
    """Distance of the geometric textures of two surfaces, whatever their shape.

    The sliced Wasserstein-1 distance of the 12 features of each triangle that the networks of geometric textures take;
    triangles on a boundary do not count, unless all lie there. It is 0 for the same triangulated surface moved, turned
    and, without unit lengths, scaled. It depends on the triangulation: compare surfaces whose triangles were made in the same way, for instance level k of a synthesized
    texture with level k of the reference, beside the bare target subdivided as often.

    Parameters
    ----------
    mesh, reference : vtkPolyData or pair (points, triangles)
        Surfaces with finite points, no degenerate triangle, no edge with more than two triangles and consistent
        winding. A pair is an array of points [V, 3] and an integer array of triangles [F, 3]. None of them is modified.
    unit_length, reference_unit_length : float, optional
        The divisors of the lengths of ``mesh`` and of ``reference``, world units, larger than 0. A synthesized texture
        has longer edges than the bare target: to compare it in the units of the network, give the mean edge length of the
        target at the first level, over 2^k for a mesh that is subdivided k times; and for level k of the meshes that the
        texture was trained on the mean edge length of level 0 over 2^k
        (``topology_report(mesh)["edge_length_mean"]``). Default: the own mean edge length.
    projections : int
        Number of random directions, from 1 to 1,000,000. The standard error falls with its square root. Default 128.
    seed : int
        The seed of the directions: any integer of 32 bits with sign. Distances with the same seed share their
        directions. Default 0.
    rings : int
        Number of rings of the neighborhoods, from 1 to 16. 1 compares the 12 features of triangles; 2 and more compare, for
        each vertex, the heights and distances of the rings of vertices around it, which see the size and spacing of larger
        features. Default 1.
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the work stops.

    Returns
    -------
    float
        The distance in unit lengths, at least 0; low is alike. NaN for two empty surfaces.

    Raises
    ------
    SurfaceSynthesisError
        The text says which of both is empty or not valid, the first cell or point, and the filter that repairs it.
    Cancelled
        ``progress`` returned False.
    ValueError, TypeError
        An argument has a value out of its range or is of a wrong type.
    """
    algorithm = configured_distance(unit_length, reference_unit_length, projections, seed, rings)
    surface, other = (
        given_dataset(given, (vtkPolyData,), "a vtkPolyData or a pair of arrays") for given in (mesh, reference)
    )
    give_reference(algorithm, other)
    table, remarks = apply_filter(algorithm, surface, progress_callback(progress))
    for text in remarks:
        warnings.warn(text, SurfaceSynthesisWarning, stacklevel=2)
    return table.GetColumnByName("Distance").GetValue(0) if table.GetNumberOfRows() > 0 else math.nan


def configured_distance(unit_length=None, reference_unit_length=None, projections=128, seed=0, rings=1):
    """A vtkGeometricTextureDistance of geometric_texture_distance()'s parameters; raises TypeError and ValueError."""
    algorithm = vtkGeometricTextureDistance()
    if unit_length is not None:
        algorithm.SetUnitLength(positive("unit_length", unit_length))
    if reference_unit_length is not None:
        algorithm.SetReferenceUnitLength(positive("reference_unit_length", reference_unit_length))
    algorithm.SetNumberOfProjections(integer("projections", projections, 1, 1000000))
    algorithm.SetNumberOfRings(integer("rings", rings, 1, 16))
    algorithm.SetSeed(integer("seed", seed, INT_MIN))
    return algorithm


def give_reference(algorithm, reference):
    """Makes a vtkPolyData, which stays untouched, the reference of a vtkGeometricTextureDistance."""
    given = vtkPolyData()  # what pipelines leave on their inputs goes to this copy
    given.ShallowCopy(reference)
    algorithm.SetInputDataObject(1, given)


def _returned(mesh, output):
    """``output`` in the form of ``mesh``."""
    if not isinstance(mesh, (tuple, list)):
        return output if mesh is None else as_type_of(mesh, output)
    if output.GetNumberOfPoints() == 0:
        return np.zeros((0, 3)), np.zeros((0, 3), np.int64)
    triangles = vtk_to_numpy(output.GetPolys().GetConnectivityArray()).astype(np.int64).reshape(-1, 3)
    return vtk_to_numpy(output.GetPoints().GetData()).astype(np.float64), triangles
