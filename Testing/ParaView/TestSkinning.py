# SPDX-License-Identifier: BSD-3-Clause
"""Skinning through its proxy, in pvpython: properties, and the points that the class gives, bit for bit."""

import numpy as np
import surfaces
from paraview.simple import *  # noqa: F403: as scripts of ParaView do
from proxies import check_properties, errors_of, made_by, output_of, source_of
from surfacesynthesis import vtkSkinningFilter
from vtkmodules.vtkCommonDataModel import vtkTable

LoadPlugin(surfaces.plugin(), remote=False, ns=globals())

# property: (default, another value, what GetX() of the VTK class then returns)
PROPERTIES = {
    "SkinningMethod": ("Dual Quaternion", "Linear Blend", 0),
    "BoneIndexArrayName": ("BoneIndices", "JOINTS_0", "JOINTS_0"),
    "BoneWeightArrayName": ("BoneWeights", "WEIGHTS_0", "WEIGHTS_0"),
}


def table(**columns):
    made = vtkTable()
    for name, rows in columns.items():
        column = surfaces.numpy_to_vtk(np.array(rows, dtype=float), deep=True)
        column.SetName(name)
        made.AddColumn(column)
    return made


def body():
    """A ball with the weights of two bones, which blend along z."""
    mesh = surfaces.ball(size=8)
    second = np.clip(0.5 + surfaces.vtk_to_numpy(mesh.GetPoints().GetData())[:, 2].astype(float), 0.0, 1.0)
    weights = surfaces.numpy_to_vtk(np.stack([1 - second, second], axis=1), deep=True)
    weights.SetName("Weights")
    mesh.GetPointData().AddArray(weights)
    return mesh


BONES = table(Head=[[0, 0, -1], [0, 0, 0]], Parent=[-1, 0])
POSE = table(Rotation=[[1, 0, 0, 0], [0.8, 0.6, 0, 0]])
NAMES = {"BoneIndexArrayName": "", "BoneWeightArrayName": "Weights"}


def skinned(mesh, pose=POSE, **options):
    return Skinning(Input=source_of(mesh), Bones=source_of(BONES), Pose=source_of(pose), **options)


def properties_have_the_defaults_of_the_class_and_reach_it():
    check_properties(skinned(body()), PROPERTIES)


def points_are_those_of_the_class():
    for text, method in (("Linear Blend", 0), ("Dual Quaternion", 1)):
        found = output_of(skinned(body(), SkinningMethod=text, **NAMES))
        algorithm = vtkSkinningFilter()
        algorithm.SetBonesData(BONES)
        algorithm.SetPoseData(POSE)
        expected = made_by(algorithm, body(), SkinningMethod=method, **NAMES)
        surfaces.assert_same(surfaces.vtk_to_numpy(found.GetPoints().GetData()),
                             surfaces.vtk_to_numpy(expected.GetPoints().GetData()), text)
        rest = surfaces.vtk_to_numpy(body().GetPoints().GetData())
        assert np.abs(surfaces.vtk_to_numpy(found.GetPoints().GetData()) - rest).max() > 0.1


def a_body_without_weights_is_an_error_that_names_them():
    errors = errors_of(skinned(body()))
    assert any("BoneWeights" in error for error in errors), errors


surfaces.run(
    properties_have_the_defaults_of_the_class_and_reach_it,
    points_are_those_of_the_class,
    a_body_without_weights_is_an_error_that_names_them,
)
