# SPDX-License-Identifier: BSD-3-Clause
"""surfacesynthesis.poisson_net() and the command ``poisson-net``."""

import numpy as np
import pytest
import surfacesynthesis
from conftest import add_array, icosphere, polydata_of
from surfacesynthesis import SurfaceSynthesisError, SurfaceSynthesisWarning, poisson_net, read_mesh, write_mesh
from surfacesynthesis.command_line import main
from surfacesynthesis.conversion import describe, expected_tensors
from surfacesynthesis.safetensors import write_safetensors
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet, vtkPolyData

SMALL = {"n_blocks": 1, "C_width": 8, "cmlp_nlayers": 1}
RADIUS = 0.28  # of a sphere of unit area


def write_model(path, **config):
    """A model file with random weights."""
    metadata, network = describe({**SMALL, **config})
    random = np.random.default_rng(5)
    tensors = {name: random.uniform(-0.3, 0.3, shape) for name, shape in expected_tensors(network).items()}
    write_safetensors(path, tensors, metadata)
    return path


@pytest.fixture
def classifier(tmp_path):
    return write_model(tmp_path / "classes.safetensors", head="linear", last_activation="log_softmax",
                       classes=["head", "arm", "leg"])  # fmt: skip


@pytest.fixture
def positions(tmp_path):
    return write_model(tmp_path / "positions.safetensors", head="njf", extra_features=2)


@pytest.fixture
def ball():
    return icosphere(2, RADIUS)


def point_array(mesh, name):
    return vtk_to_numpy(mesh.GetPointData().GetArray(name))


# -- datasets and pairs ----------------------------------------------------------------------------------------------


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        surfacesynthesis.nonsense


def test_a_classifier_on_a_dataset_and_on_a_pair(ball, classifier):
    mesh = polydata_of(*ball)
    output = poisson_net(mesh, classifier)
    assert mesh.GetPointData().GetNumberOfArrays() == 0
    values, labels, names = poisson_net(ball, classifier)
    assert names == ["head", "arm", "leg"]
    assert values.shape == (162, 3) and values.dtype == np.float32
    assert np.allclose(np.exp(values).sum(axis=1), 1.0, atol=1e-5)
    assert np.array_equal(labels, values.argmax(axis=1))
    assert np.array_equal(point_array(output, "Prediction"), values)
    assert np.array_equal(point_array(output, "Label"), labels)
    stored = output.GetFieldData().GetAbstractArray("ClassNames")
    assert [stored.GetValue(k) for k in range(3)] == names


def test_heads_at_faces_and_for_the_whole(ball, tmp_path):
    faces = write_model(tmp_path / "faces.safetensors", head="linear", C_out=4, outputs_at="faces")
    values, labels, names = poisson_net(ball, faces)
    assert (values.shape, labels, names) == ((320, 4), None, [])
    whole = write_model(tmp_path / "whole.safetensors", head="linear", outputs_at="global_mean",
                        last_activation="log_softmax", C_out=4)  # fmt: skip
    values, labels, names = poisson_net(ball, whole)
    assert values.shape == (4,) and labels == values.argmax() and isinstance(labels, int)


def test_conditions_of_all_points_alike_or_of_each(ball, positions):
    everywhere = poisson_net(ball, positions, conditions=[0.25, -1.0]).values
    assert everywhere.shape == (162, 3) and everywhere.dtype == np.float64
    each = np.tile([0.25, -1.0], (162, 1))
    assert np.allclose(poisson_net(ball, positions, conditions=each).values, everywhere, atol=1e-6)
    mesh = polydata_of(*ball)
    add_array(mesh.GetPointData(), "time", each)
    named = poisson_net(mesh, positions, conditions="time", name="Shape", displacement_name="Way")
    assert np.allclose(point_array(named, "Shape"), everywhere, atol=1e-6)
    way = point_array(named, "Way")
    assert np.allclose(ball[0] + way - (ball[0] + way).mean(axis=0), everywhere - everywhere.mean(axis=0), atol=1e-6)
    assert not np.allclose(poisson_net(ball, positions, conditions=np.array([1.0, 1.0])).values, everywhere)


def test_a_signal_in_place_of_the_positions(ball, tmp_path):
    model = write_model(tmp_path / "signal.safetensors", head="linear", C_in=2, C_out=1)
    first = poisson_net(ball, model, signal=ball[0][:, :2]).values
    mesh = polydata_of(*ball)
    add_array(mesh.GetPointData(), "xy", ball[0][:, :2])
    assert np.array_equal(point_array(poisson_net(mesh, model, signal="xy"), "Prediction"), first[:, 0])


def test_normalization_makes_size_and_place_irrelevant(ball, positions):
    moved = (40.0 * ball[0] + 3.0, ball[1])
    with pytest.warns(SurfaceSynthesisWarning, match="area of"):
        poisson_net(moved, positions, conditions=[0, 0])
    small = poisson_net(ball, positions, conditions=[0, 0], normalization="surface_area").values
    large = poisson_net(moved, positions, conditions=[0, 0], normalization="surface_area").values
    with pytest.warns(DeprecationWarning, match="keyword normalisation of poisson_net.*: use normalization"):
        former = poisson_net(moved, positions, conditions=[0, 0], normalisation="surface_area").values
    assert np.array_equal(former, large)
    assert np.allclose(large, 40.0 * small + 3.0, atol=1e-3)


def test_composite_and_empty(ball, classifier):
    blocks = vtkMultiBlockDataSet()
    blocks.SetBlock(0, polydata_of(*ball))
    output = poisson_net(blocks, classifier)
    assert np.array_equal(point_array(output.GetBlock(0), "Label"), poisson_net(ball, classifier).labels)
    assert poisson_net(vtkPolyData(), classifier).GetNumberOfPoints() == 0
    values, labels, names = poisson_net((np.zeros((0, 3)), np.zeros((0, 3), dtype=int)), classifier)
    assert (values.size, labels, names) == (0, None, [])


def test_progress_and_stop(ball, classifier):
    seen = []
    poisson_net(ball, classifier, progress=seen.append)
    assert seen == sorted(seen) and seen[-1] == 1.0
    with pytest.raises(surfacesynthesis.Cancelled):
        poisson_net(ball, classifier, progress=lambda fraction: False)


# -- what is wrong ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "parameters, kind, words",
    [
        ({"normalization": "unit"}, ValueError, "unknown normalization 'unit'"),
        ({"conditions": [1.0, "x"]}, TypeError, "conditions must be a number"),
        ({"conditions": float("nan")}, ValueError, "conditions must be finite"),
        ({"conditions": np.zeros((7, 2))}, ValueError, "a row for each of the 162 points"),
        ({"conditions": ""}, ValueError, "conditions must be the name"),
        ({"signal": 3}, TypeError, "signal must be a string"),
        ({"name": ""}, ValueError, "name must be the name"),
        ({"progress": 1}, TypeError, "progress must be callable"),
    ],
)
def test_arguments_out_of_range(parameters, kind, words, ball, positions):
    with pytest.raises(kind, match=words):
        poisson_net(ball, positions, **parameters)


def test_arrays_of_points_go_with_pairs(ball, positions):
    with pytest.raises(TypeError, match="with a pair of arrays only"):
        poisson_net(polydata_of(*ball), positions, conditions=np.zeros((162, 2)))


def test_errors_carry_the_text_of_the_library(ball, positions, tmp_path):
    with pytest.raises(SurfaceSynthesisError, match="takes 2 conditions; Conditions holds none"):
        poisson_net(ball, positions)
    with pytest.raises(SurfaceSynthesisError, match="No such file"):
        poisson_net(ball, tmp_path / "none.safetensors")
    (tmp_path / "broken.safetensors").write_bytes(positions.read_bytes()[:-8])
    with pytest.raises(SurfaceSynthesisError, match="safetensors rule 7"):
        poisson_net(ball, tmp_path / "broken.safetensors", conditions=[0, 0])


# -- the command -----------------------------------------------------------------------------------------------------


def test_the_command_writes_labels(ball, classifier, tmp_path, capsys):
    write_mesh(polydata_of(*ball), tmp_path / "in.ply")
    assert main(["poisson-net", str(tmp_path / "in.ply"), str(tmp_path / "out.vtp"), "--model", str(classifier),
                 "--label-name", "Part"]) == 0  # fmt: skip
    assert "classifier at the points, 3 channels" in capsys.readouterr().out
    written = point_array(read_mesh(tmp_path / "out.vtp"), "Part")
    assert np.array_equal(written, poisson_net(ball, classifier).labels)


def test_the_command_moves_points_to_predicted_positions(ball, positions, tmp_path):
    write_mesh(polydata_of(*ball), tmp_path / "in.vtp")
    common = ["poisson-net", str(tmp_path / "in.vtp"), str(tmp_path / "out.off"), "--model", str(positions)]
    assert main([*common, "--conditions", "0.5", "0", "--warp", "1"]) == 0
    moved = vtk_to_numpy(read_mesh(tmp_path / "out.off").GetPoints().GetData())
    expected = poisson_net(ball, positions, conditions=[0.5, 0.0]).values
    assert np.allclose(moved - moved.mean(axis=0), expected - expected.mean(axis=0), atol=1e-5)


@pytest.mark.parametrize(
    "options, output, status, words",
    [
        ([], "out.stl", 2, "cannot hold the prediction"),
        (["--warp", "inf"], "out.stl", 2, "--warp must be a finite number"),
        (["--warp", "1"], "out.stl", 1, "predicts no positions"),
        (["--conditions", "1"], "out.vtp", 1, "takes no conditions"),
        (["--conditions", "1", "--condition-array", "t"], "out.vtp", 2, "exclude each other"),
        (["--model", "none.safetensors"], "out.vtp", 1, "none.safetensors"),
    ],
)
def test_the_command_reports_in_one_line(options, output, status, words, ball, classifier, tmp_path, capsys):
    write_mesh(polydata_of(*ball), tmp_path / "in.vtp")
    arguments = ["poisson-net", str(tmp_path / "in.vtp"), str(tmp_path / output), "--model", str(classifier), *options]
    assert main(arguments) == status
    errors = capsys.readouterr().err
    assert words in errors and errors.count("\n") == 1
    assert not (tmp_path / output).exists()


def test_coupled_components_are_one_for_the_network(positions):
    points, triangles = icosphere(2, RADIUS)
    both = np.concatenate([points, 1.02 * points]), np.concatenate([triangles, triangles + len(points)])
    with pytest.raises(SurfaceSynthesisError, match="2 connected components"):
        poisson_net(both, positions, conditions=[0.5, 0.5], normalization="surface_area")
    coupled = {"conditions": [0.5, 0.5], "normalization": "surface_area", "component_coupling": True}
    inner, outer = np.split(poisson_net(both, positions, **coupled).values, 2)
    assert np.abs((outer - inner) - 0.02 * points).max() < 0.05 * RADIUS
