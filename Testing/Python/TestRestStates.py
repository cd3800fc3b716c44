# SPDX-License-Identifier: BSD-3-Clause
"""Rest states of soft bodies: rest_states() and the command ``dataset rest-states``."""

import numpy as np
import pytest
import surfacesynthesis as ss
from surfacesynthesis.command_line import main
from surfacesynthesis.datasets import given_dataset
from surfacesynthesis.sampling import farthest_samples
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import (
    VTK_TETRA,
    vtkCellArray,
    vtkMultiBlockDataSet,
    vtkPartitionedDataSet,
    vtkPartitionedDataSetCollection,
    vtkUnstructuredGrid,
)
from vtkmodules.vtkFiltersSources import vtkSphereSource

CAN_FILL = hasattr(ss, "vtkTetrahedralizeFilter") and hasattr(ss, "vtkIsotropicRemeshFilter")
needs_filling = pytest.mark.skipif(not CAN_FILL, reason="surfaces are filled with CGAL and TetGen")
QUICK = {"surface_points": 80, "maximum_time": 0.5}


def bone():
    """A ball that is twice as high as wide, as arrays."""
    source = vtkSphereSource()
    source.SetThetaResolution(16)
    source.SetPhiResolution(12)
    source.Update()
    points = vtk_to_numpy(source.GetOutput().GetPoints().GetData()).astype(float) * (1.0, 1.0, 2.0)
    return points, vtk_to_numpy(source.GetOutput().GetPolys().GetConnectivityArray()).reshape(-1, 3)


def volume(scale=1.0):
    """A cube of six tetrahedra."""
    corners = scale * np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)
    ids = np.array([[0, 1, 3, 7], [0, 5, 1, 7], [0, 4, 5, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7]])
    cells = vtkCellArray()
    cells.SetData(4, numpy_to_vtkIdTypeArray(ids.ravel(), deep=True))
    grid = vtkUnstructuredGrid()
    grid.SetPoints(vtkPoints())
    grid.GetPoints().SetData(numpy_to_vtk(corners, deep=True))
    grid.SetCells(VTK_TETRA, cells)
    return grid


@needs_filling
def test_bodies_lie_on_the_floor_and_keep_their_volume():
    points, triangles = bone()
    states = ss.rest_states((points, triangles), 2, seed=1, surface_points=0)
    assert states.shape == (2, len(points), 3) and states.dtype == np.float64
    for state in states:
        assert abs(state[:, 2].min() - points[:, 2].min()) < 0.01 * np.ptp(points)
        corners = state[triangles]
        inside = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
        before = points[triangles]
        rest = np.einsum("ij,ij->i", before[:, 0], np.cross(before[:, 1], before[:, 2])).sum() / 6
        assert 0.7 < inside / rest < 1.05
    assert np.abs(states[0] - states[1]).max() > 0.01 * np.ptp(points), "drops differ"


@needs_filling
def test_samples_do_not_depend_on_the_batch():
    together = ss.rest_states(bone(), 2, seed=4, **QUICK)
    assert np.array_equal(ss.rest_states(bone(), 1, seed=4, first_sample=1, **QUICK)[0], together[1])


def test_states_do_not_depend_on_the_unit():
    small, large = (ss.rest_states(volume(scale), 1, seed=4, maximum_time=0.5)[0] for scale in (1.0, 1024.0))
    assert np.abs(large / 1024.0 - small).max() < 1e-6
    given = ss.rest_states(volume(), 1, seed=4, maximum_time=0.5, length_unit=0.5 / np.sqrt(3.0))[0]
    assert np.abs(given - small).max() < 1e-6


def test_stiff_tetrahedra_keep_their_shape_and_soft_ones_sink():
    laid = {"drop_height": 0.0, "minimum_spin": 0.0, "maximum_spin": 0.0, "random_orientation": False, "maximum_time": 0.0}
    stiff, soft = (ss.rest_states(volume(), 1, youngs_modulus=e, **laid)[0] for e in (1e8, 1e4))
    assert abs(np.ptp(stiff[:, 2]) - 1.0) < 1e-3
    assert np.ptp(soft[:, 2]) < 0.98


@needs_filling
def test_shapes_settle_next_to_them():
    points, triangles = bone()
    (dropped,) = ss.rest_states((points, triangles), 1, seed=1, surface_points=0)
    rough = dropped + 0.01 * np.sin(37.0 * points) + (3.0, 2.0, 5.0)
    states = ss.settle((points, triangles), np.stack([dropped, rough]), surface_points=0)
    assert states.shape == (2, len(points), 3) and states.dtype == np.float64
    assert np.abs(states - dropped).max() < 0.02 * np.ptp(points)
    surface = given_dataset((rough, triangles))
    for shapes in (surface, [surface]):
        assert np.array_equal(ss.settle((points, triangles), shapes, surface_points=0), states[1:])


def test_shapes_of_tetrahedra_settle():
    grid = volume()
    state = ss.settle(grid, volume(1.2))
    assert np.ptp(state[0, :, 2]) < 1.0 and abs(state[0, :, 2].min()) < 1e-2


def test_shapes_are_checked():
    for wrong in (np.zeros((0, 8, 3)), np.zeros((2, 7, 3)), np.zeros((8, 2)), [np.zeros((7, 3))], []):
        with pytest.raises(ValueError, match="^shapes must be"):
            ss.settle(volume(), wrong)
    for wrong in ("shapes.vtm", np.zeros((2, 8, 3), dtype=complex), ["a", "b"], [[0.0, 1.0, 2.0]] * 8):
        with pytest.raises(TypeError, match="^shapes must be"):
            ss.settle(volume(), wrong)
    with pytest.raises(ss.SurfaceSynthesisError, match="not finite"):
        ss.settle(volume(), np.full((1, 8, 3), np.nan))
    with pytest.raises(ss.Cancelled):
        ss.settle(volume(), np.zeros((1, 8, 3)), progress=lambda fraction: False)


def test_shapes_may_be_one_or_a_list():
    shape = vtk_to_numpy(volume(1.1).GetPoints().GetData())
    expected = ss.settle(volume(), shape[None])
    for shapes in (shape, [shape], volume(1.1), [volume(1.1)]):
        assert np.array_equal(ss.settle(volume(), shapes), expected)


def herd(*bodies):
    """Bodies, the last of them in a block of its own."""
    tree, inner = vtkMultiBlockDataSet(), vtkMultiBlockDataSet()
    inner.SetBlock(1, bodies[-1])
    for number, body in enumerate((*bodies[:-1], inner)):
        tree.SetBlock(number, body)
    return tree


def points_of(block):
    return vtk_to_numpy(block.GetPoints().GetData())


def test_bodies_of_a_composite_dataset_rest_each_by_itself():
    bodies = volume(), volume(1.2)
    states = ss.rest_states(herd(*bodies), 2, seed=4, maximum_time=0.3)
    assert isinstance(states, vtkMultiBlockDataSet)
    last = ss.rest_states(herd(*bodies), 1, seed=4, first_sample=1, maximum_time=0.3)
    found = []
    for tree, count in ((states, 2), (last, 1)):
        places = tree.GetBlock(0), tree.GetBlock(1).GetBlock(1)
        assert [place.GetNumberOfBlocks() for place in places] == [count, count]
        found.append(np.stack([[points_of(place.GetBlock(k)) for k in range(count)] for place in places]))
    assert np.array_equal(found[0][:, 1:], found[1]), "an ensemble may be made in parts"
    heights = np.ptp(found[0][..., 2], axis=2)
    assert np.all(np.abs(heights / heights[0, 0] - [[1.0], [1.2]]) < 0.1), heights
    assert np.abs(found[0][1] / 1.2 - found[0][0]).max() > 0.01, "each block has drops of its own"
    with pytest.raises(ss.SurfaceSynthesisError, match="[Mm]emory"):
        ss.rest_states(herd(*bodies), 10**6, memory_limit=1)
    for empty in (vtkMultiBlockDataSet(), vtkUnstructuredGrid()):
        with pytest.raises(ss.SurfaceSynthesisError, match="empty"):
            ss.rest_states(empty, 1)


def test_bodies_of_a_collection_rest_in_its_class():
    bodies = vtkPartitionedDataSetCollection()
    for number in range(2):
        part = vtkPartitionedDataSet()
        part.SetPartition(0, volume(1.0 + 0.1 * number))
        bodies.SetPartitionedDataSet(number, part)
    states = ss.rest_states(bodies, 2, seed=4, maximum_time=0.1)
    assert isinstance(states, vtkPartitionedDataSetCollection)
    for number in range(2):
        place = states.GetPartitionedDataSet(number).GetPartitionAsDataObject(0)
        assert isinstance(place, vtkMultiBlockDataSet) and place.GetNumberOfBlocks() == 2


def test_shapes_of_a_composite_dataset_settle_each_in_its_place():
    bodies, shapes = (volume(), volume(1.2)), (volume(1.1), volume(1.3))
    states = ss.settle(herd(*bodies), herd(*shapes))
    for body, shape, place in zip(bodies, shapes, (states.GetBlock(0), states.GetBlock(1).GetBlock(1))):
        assert np.array_equal(points_of(place.GetBlock(0))[None], ss.settle(body, shape))
    for wrong in (points_of(bodies[0]), [points_of(shape) for shape in shapes], volume()):
        with pytest.raises(TypeError, match="composite"):
            ss.settle(herd(*bodies), wrong)


def test_arguments_are_checked():
    for wrong in ({"poissons_ratio": 0.5}, {"density": 0.0}, {"minimum_spin": 2.0, "maximum_spin": 1.0},
                  {"up_direction": (0, 0, 0)}, {"time_step": 2.0}):  # fmt: skip
        with pytest.raises(ValueError):
            ss.rest_states(volume(), 1, **wrong)
    for name in ("random_orientation", "align", "self_contact"):
        with pytest.raises(TypeError, match=name):
            ss.rest_states(volume(), 1, **{name: "no"})
    with pytest.raises(ss.SurfaceSynthesisError, match="boundary"):
        ss.rest_states((np.eye(3), np.array([[0, 1, 2]])), 1)


def test_farthest_samples_are_spread():
    line = np.array([0.0, 0.1, 0.2, 5.0, 5.1, 9.0])[:, None, None]
    assert farthest_samples(line, 3) == [0, 3, 5] or farthest_samples(line, 3) == [0, 4, 5]
    assert farthest_samples(line, 6) == list(range(6))


def by_differences(samples, count):
    """The selection of farthest_samples(), by the differences of samples themselves."""
    chosen = [0]
    while len(chosen) < count:
        differences = samples[:, None] - samples[None, chosen]
        nearest = (differences**2).sum(axis=(2, 3)).min(axis=1)
        nearest[chosen] = -1.0
        chosen.append(int(nearest.argmax()))
    return sorted(chosen)


@pytest.mark.parametrize("type_", [np.float32, np.float64])
def test_farthest_samples_are_those_of_differences(type_):
    samples = np.random.default_rng(3).normal(size=(60, 7, 3)).astype(type_) + 1000.0  # far from the origin
    samples[20:30] = samples[:10]
    for count in (1, 2, 20, 55):
        assert farthest_samples(samples, count) == by_differences(samples.astype(float), count)
    alike = np.broadcast_to(samples[:1], (5, 7, 3))
    assert farthest_samples(alike, 3) == [0, 1, 2]


@needs_filling
def test_the_command_writes_a_dataset(tmp_path):
    source, target = str(tmp_path / "a.ply"), str(tmp_path / "o.safetensors")
    ss.write_mesh(given_dataset(bone()), source)
    options = ["--samples", "2", "--candidates", "3", "--surface-points", "80", "--maximum-time", "0.3", "--quiet"]
    assert main(["dataset", "rest-states", source, target, *options]) == 0
    (entry,) = ss.read_signal_dataset(target).sources
    assert entry.signals.shape == (2, len(bone()[0]), 3)


@needs_filling
def test_the_command_settles_shapes(tmp_path):
    body, shape, states = (str(tmp_path / name) for name in ("body.ply", "shape.ply", "states.vtm"))
    points, triangles = bone()
    ss.write_mesh(given_dataset((points, triangles)), body)
    ss.write_mesh(given_dataset((points @ np.diag([1.2, 1.0, 0.9]), triangles)), shape)
    options = ["--surface-points", "80", "--quiet"]
    assert main(["settle", body, states, "--shapes", shape, shape, *options]) == 0
    written = ss.read_mesh(states)
    assert written.GetNumberOfBlocks() == 2
    single = str(tmp_path / "state.vtp")
    assert main(["settle", body, single, "--shapes", shape, *options]) == 0
    expected = vtk_to_numpy(written.GetBlock(0).GetPoints().GetData())
    assert np.array_equal(vtk_to_numpy(ss.read_mesh(single).GetPoints().GetData()), expected)
    assert main(["settle", body, single, "--shapes", shape, shape, *options]) != 0
    assert main(["settle", body, states, "--shapes", states.replace(".vtm", ".exe"), *options]) == 2
    heat = str(tmp_path / "heat.safetensors")
    ss.write_signal_dataset(heat, [((points, triangles), np.zeros((2, len(points), 1), dtype=np.float32))], "Heat")
    assert main(["settle", body, states, "--shapes", heat, *options]) != 0
    positions = str(tmp_path / "positions.safetensors")
    ss.write_signal_dataset(positions, [((points, triangles), np.stack([points, points]).astype(np.float32))], "Position")
    assert main(["settle", body, states, "--shapes", positions, *options]) == 0


def test_the_command_settles_several_bodies(tmp_path):
    body, shapes, states = (str(tmp_path / name) for name in ("herd.vtm", "shapes.vtm", "states.vtm"))
    ss.write_mesh(herd(volume(), volume(1.2)), body)
    ss.write_mesh(herd(volume(1.1), volume(1.3)), shapes)
    assert main(["settle", body, states, "--shapes", shapes, "--quiet"]) == 0
    written, expected = ss.read_mesh(states), ss.settle(ss.read_mesh(body), ss.read_mesh(shapes))
    for tree in (written, expected):
        assert [tree.GetBlock(k).GetNumberOfBlocks() for k in range(2)] == [1, 2]
    first, second = (tree.GetBlock(1).GetBlock(1).GetBlock(0) for tree in (written, expected))
    assert np.array_equal(points_of(first), points_of(second))
    one = str(tmp_path / "shape.vtu")
    ss.write_mesh(volume(1.1), one)
    for wrong in ([one], [shapes, shapes], ["shapes.safetensors"]):
        assert main(["settle", body, states, "--shapes", *wrong, "--quiet"]) == 2
    assert main(["settle", body, str(tmp_path / "state.vtu"), "--shapes", shapes, "--quiet"]) != 0


def test_the_command_settles_tetrahedra(tmp_path):
    body, shape, state = (str(tmp_path / name) for name in ("body.vtu", "shape.vtu", "state.vtu"))
    ss.write_mesh(volume(), body)
    ss.write_mesh(volume(1.2), shape)
    assert main(["settle", body, state, "--shapes", shape, "--quiet"]) == 0
    assert ss.read_mesh(state).GetNumberOfCells() == 6
    assert main(["settle", body, state, "--shapes", "shape.safetensors", "--quiet"]) == 2
    assert main(["settle", body, str(tmp_path / "no" / "state.vtu"), "--shapes", shape, "--quiet"]) != 0
