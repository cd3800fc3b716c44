# SPDX-License-Identifier: BSD-3-Clause
"""surfacesynthesis.skin() and the command ``skin``."""

import numpy as np
import pytest
from conftest import add_array, icosphere, points_of, polydata_of
from surfacesynthesis import SurfaceSynthesisError, read_mesh, skin, write_mesh
from surfacesynthesis.command_line import main

BONES = {"Head": [[-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]], "Parent": [-1, 0], "Name": ["upper", "lower"]}
HALF = np.sqrt(0.5)
POSE = {"Rotation": [[1.0, 0.0, 0.0, 0.0], [HALF, 0.0, 0.0, HALF]]}  # the second bone by a right angle about z


def weights_of(points):
    """Bones and weights: the second bone where x > 0."""
    second = (points[:, 0] > 1e-9).astype(float)
    return np.tile([0, 1], (len(points), 1)), np.stack([1 - second, second], axis=1)


def expected(points):
    turned = points @ [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]
    return np.where(points[:, :1] > 1e-9, turned, points)


@pytest.fixture
def body():
    points, triangles = icosphere(2)
    mesh = polydata_of(points, triangles)
    indices, weights = weights_of(points)
    add_array(mesh.GetPointData(), "BoneIndices", indices.astype(np.int32))
    add_array(mesh.GetPointData(), "BoneWeights", weights)
    return mesh


@pytest.mark.parametrize("method", ["linear_blend", "dual_quaternion"])
def test_a_dataset_and_a_pair_are_posed_alike(body, method):
    points, triangles = icosphere(2)
    indices, weights = weights_of(points)
    posed = skin(body, BONES, POSE, skinning_method=method)
    assert np.allclose(points_of(posed), expected(points), atol=1e-15)
    assert np.array_equal(points_of(body), points)
    assert posed.GetPointData().HasArray("BoneWeights")
    pair = skin((points, triangles), BONES, np.array(POSE["Rotation"]), method, indices, weights)
    assert np.array_equal(pair, points_of(posed))
    assert np.array_equal(skin((points, triangles), BONES, POSE, method, None, weights), pair)


def test_names_choose_the_bones(body):
    points, _ = icosphere(2)
    pose = {"Rotation": [POSE["Rotation"][1]], "Translation": [[0.0, 0.0, 1.0]], "Name": ["lower"]}
    moved = points_of(skin(body, BONES, pose)) - expected(points)
    assert np.allclose(moved[:, 2], points[:, 0] > 1e-9, atol=1e-15) and np.allclose(moved[:, :2], 0.0, atol=1e-15)
    with pytest.raises(SurfaceSynthesisError, match='"tail", which the skeleton does not have'):
        skin(body, BONES, {**pose, "Name": ["tail"]})


def test_bad_input_is_named(body):
    points, triangles = icosphere(2)
    indices, weights = weights_of(points)
    for change, text in ((-1.0, "negative weight"), (0.5, "sum is not 1"), (np.nan, "not finite")):
        bad = weights.copy()
        bad[7] *= change
        with pytest.raises(SurfaceSynthesisError, match=f"1 point.*{text}.*point 7"):
            skin((points, triangles), BONES, POSE, bone_index_array=indices, bone_weight_array=bad)
    with pytest.raises(SurfaceSynthesisError, match="loop"):
        skin(body, {**BONES, "Parent": [1, 0]}, POSE)
    with pytest.raises(ValueError, match="skinning_method"):
        skin(body, BONES, POSE, skinning_method="cubic")
    with pytest.raises(TypeError, match="bones must be a vtkTable, a mapping"):
        skin(body, [[0, 0, 0]], POSE)
    with pytest.raises(ValueError, match='columns of bones .* not 2 of "Head", 3 of "Parent", 2 of "Name"'):
        skin(body, {**BONES, "Parent": [-1, 0, 0]}, POSE)
    with pytest.raises(ValueError, match='columns of pose .* not 2 of "Rotation", 1 of "Translation"'):
        skin(body, BONES, {**POSE, "Translation": [[0.0, 0.0, 1.0]]})
    with pytest.raises(SurfaceSynthesisError, match='"Translation:2" of the pose is missing'):
        skin(body, BONES, {**POSE, "Translation:0": [1.0, 0.0], "Translation:1": [0.0, 0.0]})


def test_the_command_reads_tables_of_files(body, tmp_path):
    source, target = str(tmp_path / "body.vtp"), str(tmp_path / "posed.vtp")
    bones, pose = tmp_path / "bones.csv", tmp_path / "pose.csv"
    write_mesh(body, source)
    bones.write_text("Name,Head:0,Head:1,Head:2,Parent\nupper,-1,0,0,-1\nlower,0,0,0,0\n")
    pose.write_text(f"Name,Rotation:0,Rotation:1,Rotation:2,Rotation:3\nlower,{float(HALF)},0,0,{float(HALF)}\n")
    options = ["--bones", str(bones), "--pose", str(pose)]
    assert main(["skin", source, target, *options]) == 0
    assert np.allclose(points_of(read_mesh(target)), expected(points_of(body)), atol=1e-15)
    assert main(["skin", source, target, *options, "--skinning-method", "linear_blend"]) == 0
    bones.write_bytes(b"\xef\xbb\xbf" + bones.read_bytes())  # spreadsheets begin files with a byte order mark
    assert main(["skin", source, target, *options]) == 0
    assert np.allclose(points_of(read_mesh(target)), expected(points_of(body)), atol=1e-15)
    pose.write_text("Name,Rotation:0\nlower,half\n")
    assert main(["skin", source, target, *options]) != 0
