# SPDX-License-Identifier: BSD-3-Clause
"""Bodies posed by the bones of a skeleton: a function around vtkSkinningFilter."""

import collections.abc
import csv
import os

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkStringArray
from vtkmodules.vtkCommonDataModel import vtkDataObjectTree, vtkPointSet, vtkPolyData, vtkTable

from .arguments import array_name, choice, progress_callback
from .datasets import array_by_name, as_type_of, given_dataset
from .errors import SurfaceSynthesisError
from .pipeline import apply_filter
from .vtkSurfaceSynthesisEnsembles import vtkSkinningFilter

#: The blending of motions, by the name that ``skinning_method`` takes.
SKINNING_METHODS = {
    "linear_blend": vtkSkinningFilter.LINEAR_BLEND,
    "dual_quaternion": vtkSkinningFilter.DUAL_QUATERNION,
}
_BODY_TEXT = "a vtkPointSet, a composite dataset or a pair of arrays (points, triangles)"
_GIVEN_INDICES, _GIVEN_WEIGHTS = "_GivenBoneIndices", "_GivenBoneWeights"


def skin(
    mesh,
    bones,
    pose,
    skinning_method="dual_quaternion",
    bone_index_array="BoneIndices",
    bone_weight_array="BoneWeights",
    progress=None,
):
    """Poses a body by the bones of a skeleton: moves each point with the bones that influence it.

    Parameters
    ----------
    mesh : vtkPointSet, composite dataset (vtkDataObjectTree) or pair (points, triangles)
        The body at rest: a surface, a volume or points, float or double. The mesh is never modified.
    bones : vtkTable, mapping or path
        The bones, or a file of comma-separated values with them, with the columns "Head", [B, 3], the joint at which each
        one turns, world units; "Parent", [B], the row of the bone that carries it, -1 for none; and, optional, "Name".
    pose : vtkTable, mapping, path or array [B, 4]
        The pose, or a file with it, with the columns "Rotation", [B, 4], a quaternion w, x, y, z of any length but 0: the
        rotation of the bone about its head, relative to its parent, in the axes of the body at rest; optional
        "Translation", [B, 3], the displacement of the head from where the parent carries it, world units; and optional
        "Name". With names in both tables a row is for the bone of its name, and bones without a row keep their rotation to
        the parent. An array is that of rotations.
    skinning_method : str
        "dual_quaternion" (default): the rigid motion of the weighted mean of unit dual quaternions. "linear_blend": the
        weighted mean of the moved points, which shrinks where bones turn far against each other.
    bone_index_array : str, None or array [V, K]
        Name of the point array with the numbers of the bones of each point; with a pair, an array. None: the weights have a
        component for each bone. Default "BoneIndices".
    bone_weight_array : str or array [V, K]
        Name of the point array with the weights of the bones of each point, at least 0, whose sum is 1 to 0.01; they are
        divided by it. With a pair, an array. Default "BoneWeights".
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the work stops.

    Returns
    -------
    dataset of the type of ``mesh``
        The posed body, with its cells and arrays but without normals, which are those at rest.
    numpy.ndarray, for a pair
        The posed points [V, 3], float64.

    Raises
    ------
    SurfaceSynthesisError
        Weights that are negative, not finite or do not sum up to 1, unknown bones, parents that form a loop, and tables
        without a column that is needed; the text names the first point, bone or row.
    Cancelled
        ``progress`` returned False.
    ValueError, TypeError
        An argument has a value out of its range or is of a wrong type.
    """
    is_pair = isinstance(mesh, (tuple, list))
    dataset = given_dataset(mesh, (vtkPolyData, vtkPointSet, vtkDataObjectTree), _BODY_TEXT)
    bone_index_array = array_by_name(dataset, "bone_index_array", bone_index_array, _GIVEN_INDICES, is_pair, 1)
    bone_weight_array = array_by_name(dataset, "bone_weight_array", bone_weight_array, _GIVEN_WEIGHTS, is_pair, 1)
    algorithm = configured_filter(bones, pose, skinning_method, bone_index_array, bone_weight_array)
    progress_callback(progress)
    output, _ = apply_filter(algorithm, dataset, progress)
    if not is_pair:
        return as_type_of(mesh, output)
    return np.array(vtk_to_numpy(output.GetPoints().GetData()), dtype=np.float64)


def configured_filter(
    bones,
    pose,
    skinning_method="dual_quaternion",
    bone_index_array="BoneIndices",
    bone_weight_array="BoneWeights",
):
    """A vtkSkinningFilter with the parameters of skin(), which raises TypeError and ValueError."""
    algorithm = vtkSkinningFilter()
    algorithm.SetSkinningMethod(choice("skinning_method", skinning_method, SKINNING_METHODS))
    algorithm.SetBoneIndexArrayName("" if bone_index_array is None else array_name("bone_index_array", bone_index_array))
    algorithm.SetBoneWeightArrayName(array_name("bone_weight_array", bone_weight_array))
    algorithm.SetBonesData(_table_of("bones", bones))
    if not isinstance(pose, (vtkTable, collections.abc.Mapping, str, os.PathLike)):
        pose = {"Rotation": pose}
    algorithm.SetPoseData(_table_of("pose", pose))
    return algorithm


def _table_of(argument, given):
    """A copy of a vtkTable, or the table of a mapping of columns or of a file."""
    table = vtkTable()
    if isinstance(given, vtkTable):
        table.ShallowCopy(given)
        return table
    if isinstance(given, (str, os.PathLike)):
        given = _columns_of(given)
    if not isinstance(given, collections.abc.Mapping):
        raise TypeError(f"{argument} must be a vtkTable, a mapping of columns or a path, not {type(given).__name__}")
    columns = {
        name: _names(values) if name == "Name" else _numbers(argument, name, values) for name, values in given.items()
    }
    rows = {name: column.GetNumberOfTuples() for name, column in columns.items()}
    if len(set(rows.values())) > 1:
        found = ", ".join(f'{count} of "{name}"' for name, count in rows.items())
        raise ValueError(f"the columns of {argument} must have the same number of rows, not {found}")
    for name, column in columns.items():
        column.SetName(name)
        table.AddColumn(column)
    return table


def _names(values):
    """A column of texts."""
    column = vtkStringArray()
    for text in values:
        column.InsertNextValue(str(text))
    return column


def _numbers(argument, name, values):
    """A column of numbers."""
    values = np.asarray(values)
    if values.dtype.kind not in "fiu" or values.ndim not in (1, 2):
        raise TypeError(
            f'the column "{name}" of {argument} must be an array of numbers [B] or [B, C], not of {values.dtype} '
            f"{list(values.shape)}"
        )
    return numpy_to_vtk(np.ascontiguousarray(values, dtype=np.float64), deep=True)


def _columns_of(path):
    """The columns of a table of comma-separated values by their names: numbers, but for names."""
    with open(path, newline="", encoding="utf-8-sig") as file:
        rows = [row for row in csv.reader(file) if row]
    if not rows or any(len(row) != len(rows[0]) for row in rows):
        raise SurfaceSynthesisError(f"{path}: a row of names and rows of as many values are needed")
    columns = {name.strip(): list(values) for name, *values in zip(*rows)}
    try:
        return {name: values if name == "Name" else [float(value) for value in values] for name, values in columns.items()}
    except ValueError as error:
        raise SurfaceSynthesisError(f"{path}: a value is no number ({error})") from error
