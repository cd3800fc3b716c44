# SPDX-License-Identifier: BSD-3-Clause
"""surfacesynthesis.matern_noise() and the wrapped filter."""

import os
import resource
import subprocess
import sys
import warnings

import numpy as np
import pytest
import surfacesynthesis
from conftest import add_array, icosphere, polydata_of
from surfacesynthesis import SurfaceSynthesisError, SurfaceSynthesisWarning, matern_noise
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkSMPTools
from vtkmodules.vtkCommonDataModel import (
    vtkImageData,
    vtkMultiBlockDataSet,
    vtkPartitionedDataSet,
    vtkPolyData,
)
from vtkmodules.vtkFiltersGeneral import vtkWarpVector


def values_of(mesh, name="MaternNoise"):
    return vtk_to_numpy(mesh.GetPointData().GetArray(name))


def names_of(data):
    return [data.GetArrayName(k) for k in range(data.GetNumberOfArrays())]


def blocks(*meshes):
    result = vtkMultiBlockDataSet()
    for k, mesh in enumerate(meshes):
        result.SetBlock(k, mesh)
    return result


# -- the wrapped filter ------------------------------------------------------------------------------------------------


def test_filter_works_in_a_pipeline_beside_vtk():
    code = (
        "import vtk; from surfacesynthesis import vtkMaternNoiseFilter; s = vtk.vtkSphereSource();"
        "f = vtkMaternNoiseFilter(); f.SetInputConnection(s.GetOutputPort()); f.SetCorrelationRange(5); f.Update();"
        "assert isinstance(f, vtk.vtkPassInputTypeAlgorithm);"
        "assert f.GetOutput().GetPointData().GetArray('MaternNoise').GetNumberOfTuples() == 50;"
        "assert 0 < f.GetRelativeResidual() < 1e-10 and f.GetNumberOfFactorizations() == 1"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=120)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


# -- datasets ----------------------------------------------------------------------------------------------------------


def test_dataset_keeps_its_cells_and_arrays_and_gains_one(sphere):
    result = matern_noise(sphere, range=1.0)
    assert type(result) is vtkPolyData
    assert names_of(result.GetPointData()) == ["height", "MaternNoise"]
    assert names_of(result.GetCellData()) == ["number"]
    assert result.GetNumberOfCells() == sphere.GetNumberOfCells()
    assert values_of(result).dtype == np.float64
    assert values_of(result).shape == (sphere.GetNumberOfPoints(),)
    assert np.isfinite(values_of(result)).all() and values_of(result).std() > 0.1


def test_input_is_never_modified(sphere, pair):
    time, arrays = sphere.GetMTime(), names_of(sphere.GetPointData())
    before = [vtk_to_numpy(a).copy() for a in (sphere.GetPoints().GetData(), sphere.GetPolys().GetConnectivityArray())]
    points, triangles = pair[0].copy(), pair[1].copy()
    matern_noise(sphere, range=1.0, samples=2)
    matern_noise((points, triangles), range=1.0)
    after = [vtk_to_numpy(a) for a in (sphere.GetPoints().GetData(), sphere.GetPolys().GetConnectivityArray())]
    assert sphere.GetMTime() == time and names_of(sphere.GetPointData()) == arrays
    assert all(np.array_equal(a, b) for a, b in zip(before, after))
    assert np.array_equal(points, pair[0]) and np.array_equal(triangles, pair[1])


def test_result_outlives_and_is_independent_of_the_next_call(sphere):
    first = matern_noise(sphere, range=1.0, seed=1)
    kept = values_of(first).copy()
    second = matern_noise(sphere, range=1.0, seed=2)
    assert np.array_equal(values_of(first), kept)
    assert not np.array_equal(values_of(second), kept)
    assert second.GetPointData().GetNumberOfArrays() == 2


def test_samples_are_named_by_their_index(sphere):
    result = matern_noise(sphere, range=1.0, samples=3, first_sample=4, name="f", components=3)
    assert names_of(result.GetPointData()) == ["height", "f_4", "f_5", "f_6"]
    assert values_of(result, "f_6").shape == (sphere.GetNumberOfPoints(), 3)
    alone = matern_noise(sphere, range=1.0, first_sample=6, name="g", components=3)
    assert np.array_equal(values_of(alone, "g"), values_of(result, "f_6"))


def test_composite_blocks_get_different_noise(sphere):
    other = vtkPolyData()
    other.DeepCopy(sphere)
    mesh = blocks(sphere, None, other)
    result = matern_noise(mesh, range=1.0)
    assert type(result) is vtkMultiBlockDataSet and result.GetNumberOfBlocks() == 3
    assert result.GetBlock(1) is None
    assert not np.array_equal(values_of(result.GetBlock(0)), values_of(result.GetBlock(2)))
    assert names_of(mesh.GetBlock(0).GetPointData()) == ["height"], "the input was modified"


def test_partitioned_dataset_works(sphere):
    mesh = vtkPartitionedDataSet()
    mesh.SetPartition(0, sphere)
    result = matern_noise(mesh, range=1.0)
    assert type(result) is vtkPartitionedDataSet
    assert values_of(result.GetPartition(0)).std() > 0.1


def test_python_subclass_comes_back_as_itself(sphere):
    class FromDataset(vtkPolyData):
        def __init__(self, dataset=None):
            if dataset is not None:
                self.ShallowCopy(dataset)

    class WithoutArguments(vtkPolyData):
        def __init__(self):
            self.note = "empty"

    class Stubborn(vtkPolyData):
        def __init__(self, name, size):
            self.name, self.size = name, size

    for mesh in (FromDataset(sphere), WithoutArguments(), Stubborn("a", 1)):
        mesh.ShallowCopy(sphere)
        result = matern_noise(mesh, range=1.0)
        expected = vtkPolyData if isinstance(mesh, Stubborn) else type(mesh)
        assert type(result) is expected
        assert np.array_equal(values_of(result), values_of(matern_noise(sphere, range=1.0)))


# -- NumPy pairs -------------------------------------------------------------------------------------------------------


def test_shapes_of_a_pair(pair):
    v = len(pair[0])
    assert matern_noise(pair, range=1.0).shape == (v,)
    assert matern_noise(pair, range=1.0, components=2).shape == (v, 2)
    assert matern_noise(pair, range=1.0, samples=1).shape == (1, v)
    assert matern_noise(pair, range=1.0, samples=3).shape == (3, v)
    assert matern_noise(pair, range=1.0, samples=3, components=2).shape == (3, v, 2)


def test_pair_and_dataset_agree(pair, sphere):
    batch = matern_noise(pair, range=1.0, samples=3, components=2, seed=5)
    result = matern_noise(sphere, range=1.0, samples=3, components=2, seed=5)
    for k in range(3):
        assert np.array_equal(batch[k], values_of(result, f"MaternNoise_{k}"))


def test_pair_takes_lists_single_precision_and_other_integers(pair):
    expected = matern_noise(pair, range=1.0)
    assert np.array_equal(matern_noise((pair[0].tolist(), pair[1].tolist()), range=1.0), expected)
    assert np.array_equal(matern_noise([np.asfortranarray(pair[0]), pair[1].astype(np.uint16)], range=1.0), expected)
    assert np.allclose(matern_noise((pair[0].astype(np.float32), pair[1]), range=1.0), expected, atol=1e-4)


def test_empty_pair_gives_empty_noise():
    empty = (np.zeros((0, 3)), np.zeros((0, 3), dtype=int))
    assert matern_noise(empty).shape == (0,)
    assert matern_noise(empty, samples=2, components=3).shape == (2, 0, 3)
    assert matern_noise(([], [])).shape == (0,)


def test_result_of_a_pair_may_be_written(pair):
    noise = matern_noise(pair, range=1.0)
    noise += 1
    assert np.array_equal(matern_noise(pair, range=1.0) + 1, noise)


# -- parameters reach the filter ---------------------------------------------------------------------------------------


def test_range_mode_has_the_standard_deviation_asked_for():
    noise = matern_noise(icosphere(5), range=0.7, standard_deviation=3.0, samples=400)
    assert abs(noise.var() / 9.0 - 1) < 0.05  # what the library promises where the mesh is fine enough


def test_per_vertex_noise_is_independent_and_scaled(pair):
    noise = matern_noise(pair, noise_model="per_vertex", standard_deviation=2.0, samples=400)
    assert abs(noise.std() / 2.0 - 1) < 0.02
    correlation = np.corrcoef(noise[:, :100].T) - np.eye(100)
    assert abs(correlation).max() < 6 / np.sqrt(400)


def test_screening_and_range_agree_up_to_scale(pair):
    by_range = matern_noise(pair, range=1.0)
    by_tau = matern_noise(pair, screening=8.0)
    ratio = by_range / by_tau
    assert np.allclose(ratio, ratio[0], rtol=1e-9)


def test_normalized_screening_ignores_the_size_of_the_mesh(pair):
    noise = matern_noise(pair, normalized_screening=1e-3)
    larger = matern_noise((10 * pair[0], pair[1]), normalized_screening=1e-3)
    assert np.allclose(noise, larger, rtol=0, atol=1e-9 * abs(noise).max())


@pytest.mark.parametrize("power", [1, 1.5, 2, 3, 3.5, 4])
def test_corrected_noise_has_the_deviation_at_every_point(pair, power):
    # 500 samples: at every point within 15 % (z = 4.7), all points together within 2 %.
    noise = matern_noise(
        pair, screening=20.0, operator_power=power, variance_correction=True, standard_deviation=2.0, samples=500
    )
    deviations = np.sqrt((noise**2).mean(axis=0))
    assert np.abs(deviations / 2.0 - 1.0).max() < 0.15
    assert abs(np.sqrt((deviations**2).mean()) / 2.0 - 1.0) < 0.02


def test_larger_powers_are_smoother(pair):
    points, triangles = pair
    edges = triangles[:, [0, 1]]
    roughness = []
    for power in (1, 1.5, 2, 2.5, 3, 3.5, 4):
        noise = matern_noise(pair, screening=20.0, operator_power=power, variance_correction=True, samples=50)
        roughness.append(np.abs(noise[:, edges[:, 0]] - noise[:, edges[:, 1]]).mean())
    assert roughness == sorted(roughness, reverse=True)


def test_arrays_vary_the_noise(sphere):
    points = vtk_to_numpy(sphere.GetPoints().GetData())
    mesh = vtkPolyData()
    mesh.ShallowCopy(sphere)
    for name, values in (
        ("factor", 1.0 + 0.5 * (points[:, 2] > 0)),
        ("direction", np.ascontiguousarray(np.cross([0.0, 0.0, 1.0], points))),
        ("mask", (points[:, 0] > 0.9).astype(np.uint8)),
    ):
        array = numpy_to_vtk(values, deep=True)
        array.SetName(name)
        mesh.GetPointData().AddArray(array)
    barrier = numpy_to_vtk((np.arange(mesh.GetNumberOfCells()) < 40).astype(np.uint8), deep=True)
    barrier.SetName("barrier")
    mesh.GetCellData().AddArray(barrier)
    plain = values_of(matern_noise(mesh, range=1.0))
    for arguments in (
        {"range_factor_array": "factor"},
        {"direction_array": "direction", "anisotropy_ratio": 3.0},
        {"boundary_condition": "dirichlet", "boundary_array": "mask"},
        {"barrier_array": "barrier"},
    ):
        noise = values_of(matern_noise(mesh, range=1.0, **arguments))
        assert np.isfinite(noise).all()
        assert np.abs(noise - plain).max() > 1e-3, arguments
    pinned = values_of(matern_noise(mesh, range=1.0, boundary_condition="dirichlet", boundary_array="mask"))
    assert (pinned[points[:, 0] > 0.9] == 0).all() and (pinned[points[:, 0] < 0.8] != 0).all()
    with pytest.raises(SurfaceSynthesisError, match='There is no point array "none", which RangeFactorArrayName names'):
        matern_noise(mesh, range=1.0, range_factor_array="none")


def test_unscreened_noise_has_no_mean_and_white_noise_is_rough(pair):
    unscreened = matern_noise(pair, noise_model="unscreened")
    mass = np.zeros(len(pair[0]))
    a, b, c = (pair[0][pair[1][:, k]] for k in range(3))
    np.add.at(mass, pair[1], (np.linalg.norm(np.cross(b - a, c - a), axis=1) / 6)[:, None])
    assert abs(mass @ unscreened) < 1e-9 * (mass @ abs(unscreened))
    white = matern_noise(pair, noise_model="white", samples=200)
    assert abs((white * np.sqrt(mass)).std() - 1) < 0.02


def test_spectral_model_takes_eigenpairs(pair):
    few = matern_noise(pair, noise_model="spectral", range=1.0, eigenpairs=4)
    many = matern_noise(pair, noise_model="spectral", range=1.0, eigenpairs=200)
    coordinates = np.column_stack([np.ones(len(pair[0])), pair[0]])  # what the 4 lowest eigenfunctions of a sphere span
    rest = few - coordinates @ np.linalg.lstsq(coordinates, few, rcond=None)[0]
    assert np.linalg.norm(rest) < 0.01 * np.linalg.norm(few)
    rest = many - coordinates @ np.linalg.lstsq(coordinates, many, rcond=None)[0]
    assert np.linalg.norm(rest) > 0.1 * np.linalg.norm(many)


def test_seeds_give_other_noise_and_negative_ones_work(pair):
    fields = np.stack([matern_noise(pair, range=0.5, seed=seed) for seed in (-(2**31), -1, 0, 1, 2**31 - 1)])
    assert (abs(np.corrcoef(fields) - np.eye(5)) < 0.9).all()
    assert np.array_equal(fields[2], matern_noise(pair, range=0.5))


def test_same_bits_for_every_number_of_threads(pair):
    try:
        vtkSMPTools.Initialize(1)
        one = matern_noise(pair, range=0.5, samples=5, components=3)
        vtkSMPTools.Initialize(2)
        two = matern_noise(pair, range=0.5, samples=5, components=3)
    finally:
        vtkSMPTools.Initialize(0)
    assert np.array_equal(one, two)


# -- what goes wrong ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "arguments, words",
    [
        ({"range": -1.0}, "range must be a finite number larger than 0, not -1"),
        ({"range": 0.0}, "range must be"),
        ({"range": float("nan")}, "range must be"),
        ({"range": float("inf")}, "range must be"),
        ({"screening": 0}, "screening must be"),
        ({"normalized_screening": -1e-4}, "normalized_screening must be"),
        ({"standard_deviation": -1.0}, "standard_deviation must be"),
        ({"standard_deviation": float("nan")}, "standard_deviation must be"),
        ({"seed": 2**31}, "seed must be from -2147483648 to 2147483647, not 2147483648"),
        ({"samples": 0}, "samples must be from 1"),
        ({"first_sample": -1}, "first_sample must be from 0"),
        ({"components": 0}, "components must be from 1"),
        ({"eigenpairs": 0}, "eigenpairs must be from 1"),
        ({"name": ""}, "name must be"),
        ({"noise_model": "perlin"},
         "unknown noise_model 'perlin'; choose one of matern, per_vertex, white, unscreened, spectral"),
        ({"range": 1.0, "screening": 8.0}, "range and screening exclude each other"),
        ({"range": 1.0, "noise_model": "white"}, "range has no meaning for the model 'white'"),
        ({"screening": 8.0, "standard_deviation": 2.0}, "standard_deviation goes with range, not with screening"),
        ({"standard_deviation": 2.0, "noise_model": "unscreened"}, "standard_deviation has no meaning"),
        ({"operator_power": 0}, "operator_power must be from 1"),
        ({"operator_power": 5}, "operator_power must be from 1 to 4, not 5"),
        ({"operator_power": 4.0000001}, "operator_power must be from 1 to 4, not 4.0000001"),
        ({"operator_power": 1}, "operator_power 1 has no finite variance and no range: it goes with screening"),
        ({"operator_power": 3, "noise_model": "white"}, "operator_power has no meaning for the model 'white'"),
        ({"variance_correction": True, "noise_model": "spectral"}, "variance_correction has no meaning"),
        ({"boundary_condition": "open"}, "unknown boundary_condition 'open'; choose one of neumann, dirichlet, robin"),
        ({"boundary_condition": "robin", "noise_model": "white"}, "boundary_condition has no meaning"),
        ({"boundary_condition": "robin", "robin_coefficient": -1.0}, "robin_coefficient must be"),
        ({"robin_coefficient": 2.0}, "robin_coefficient goes with boundary_condition 'robin'"),
        ({"boundary_array": "mask"}, "boundary_array goes with boundary_condition"),
        ({"anisotropy_ratio": 2.0}, "anisotropy_ratio goes with direction_array"),
        ({"anisotropy_ratio": 0.0, "direction_array": "d"}, "anisotropy_ratio must be"),
        ({"barrier_array": ""}, "barrier_array must be"),
        ({"range_factor_array": "w", "noise_model": "white"}, "range_factor_array has no meaning"),
    ],
)
def test_values_out_of_range_are_value_errors(pair, arguments, words):
    with pytest.raises(ValueError, match=words.replace("(", r"\(")):
        matern_noise(pair, **arguments)


@pytest.mark.parametrize(
    "arguments",
    [{"range": "5"}, {"range": True}, {"seed": 1.5}, {"seed": None}, {"samples": "3"}, {"noise_model": 0}, {"name": 3},
     {"progress": 1}, {"components": True}, {"operator_power": "3"}, {"variance_correction": 1},
     {"boundary_condition": 0}, {"direction_array": 1}],
)  # fmt: skip
def test_wrong_types_are_type_errors(pair, arguments):
    with pytest.raises(TypeError, match=next(iter(arguments))):
        matern_noise(pair, **arguments)


@pytest.mark.parametrize(
    "mesh, error, words",
    [
        (None, TypeError, "vtkUnstructuredGrid, a composite dataset or a pair"),
        ("surface.stl", TypeError, "not str"),
        (vtkImageData(), TypeError, "not vtkImageData"),
        ((np.zeros((3, 3)),), TypeError, "length 1"),
        ((np.zeros((3, 2)), np.zeros((1, 3), dtype=int)), ValueError, r"points must have the shape \[V, 3\]"),
        ((np.zeros((3, 3)), np.zeros((1, 5), dtype=int)), ValueError, r"triangles must have the shape \[F, 3\]"),
        ((np.zeros((3, 2)), np.zeros((1, 4), dtype=int)), ValueError, r"points must have the shape \[V, 3\]"),
        ((np.zeros((3, 3)), np.zeros((1, 4))), TypeError, "tetrahedra must be an array of integers"),
        ((np.zeros((3, 3)), np.zeros((1, 3))), TypeError, "triangles must be an array of integers"),
        ((np.zeros((3, 3), dtype=complex), np.zeros((1, 3), dtype=int)), TypeError, "points must be an array of real"),
        ((np.array([["a", "b", "c"]]), np.zeros((1, 3), dtype=int)), TypeError, "points must be an array of real"),
    ],
)
def test_wrong_meshes_are_named(mesh, error, words):
    with pytest.raises(error, match=words):
        matern_noise(mesh)


def test_defects_of_the_mesh_are_errors_with_vtks_text_and_a_silent_console(pair, capfd):
    points, triangles = pair
    broken = points.copy()
    broken[7, 1] = np.nan
    cases = [
        ((broken, triangles), "NaN or infinite"),
        ((points, np.vstack((triangles, [[0, 1, len(points)]]))), "does not exist"),
        ((points, np.vstack((triangles, [[0, 1, -1]]))), "does not exist"),
        ((points, np.vstack((triangles, [[0, 1, 2]])).astype(np.uint64) + np.uint64(2**63)), "does not exist"),
        ((points, np.vstack((triangles, triangles[:1, [1, 0, 2]]))), "non-manifold"),
        ((points, np.vstack((triangles, [[5, 5, 6]]))), "twice"),
        ((points, np.zeros((0, 3), dtype=int)), "no polygon"),
    ]
    for mesh, words in cases:
        with pytest.raises(surfacesynthesis.SurfaceSynthesisError, match=words) as caught:
            matern_noise(mesh, range=1.0)
        assert isinstance(caught.value, RuntimeError)
        assert caught.value.messages == [str(caught.value)]
        assert "\n" not in str(caught.value) and "0x" not in str(caught.value) and ".cxx" not in str(caught.value)
    assert capfd.readouterr() == ("", "")


def test_bad_blocks_of_a_composite_dataset_are_all_named(pair, sphere, capfd):
    broken = pair[0].copy()
    broken[0] = np.inf
    mesh = blocks(polydata_of(broken, pair[1]), sphere, polydata_of(pair[0], np.vstack((pair[1], [[0, 0, 1]]))))
    with pytest.raises(surfacesynthesis.SurfaceSynthesisError) as caught:
        matern_noise(mesh, range=1.0)
    assert len(caught.value.messages) == 2
    assert "NaN or infinite" in caught.value.messages[0] and "Block 1: " in caught.value.messages[0]
    assert "twice" in caught.value.messages[1] and "Block 3: " in caught.value.messages[1]
    assert str(caught.value) == "\n".join(caught.value.messages)
    assert capfd.readouterr() == ("", "")


def test_too_coarse_a_mesh_is_a_python_warning_of_the_callers_line(pair, capfd):
    with pytest.warns(surfacesynthesis.SurfaceSynthesisWarning, match="third of the correlation range") as caught:
        matern_noise(pair, range=0.05)
    assert [warning.filename for warning in caught] == [__file__]
    assert capfd.readouterr() == ("", "")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        matern_noise(pair, range=1.0)


# -- progress ----------------------------------------------------------------------------------------------------------


def test_progress_is_monotone_and_ends_at_one(pair):
    seen = []
    matern_noise(icosphere(5), range=0.5, samples=20, progress=seen.append)
    assert len(seen) > 5
    assert seen == sorted(seen) and 0 <= seen[0] and seen[-1] == 1.0


@pytest.mark.parametrize("answer", [False, np.bool_(False)])
def test_false_cancels(pair, answer):
    seen = []

    def progress(fraction):
        seen.append(fraction)
        return answer if fraction > 0.2 else None

    with pytest.raises(surfacesynthesis.Cancelled):
        matern_noise(icosphere(5), range=0.5, samples=20, progress=progress)
    assert seen[-1] < 1.0 and sum(fraction > 0.2 for fraction in seen) == 1


def test_true_and_none_go_on(pair):
    expected = matern_noise(pair, range=1.0)
    for answer in (True, None):
        assert np.array_equal(matern_noise(pair, range=1.0, progress=lambda _, a=answer: a), expected)


def test_exceptions_of_progress_come_through(pair, capfd):
    class Surprise(Exception):
        pass

    def progress(_):
        raise Surprise("from the callable")

    with pytest.raises(Surprise, match="from the callable"):
        matern_noise(pair, range=1.0, progress=progress)
    assert capfd.readouterr() == ("", "")


def test_a_cancelled_filter_can_be_used_again(sphere):
    noise = surfacesynthesis.noise.configured_filter(range=1.0)
    with pytest.raises(surfacesynthesis.Cancelled):
        surfacesynthesis.noise.apply_filter(noise, sphere, lambda _: False)
    output, _ = surfacesynthesis.noise.apply_filter(noise, sphere)
    assert np.array_equal(values_of(output), values_of(matern_noise(sphere, range=1.0)))


def test_points_without_triangles_get_zero(pair):
    points = np.vstack((pair[0], [[5.0, 5.0, 5.0]]))
    noise = matern_noise((points, pair[1]), range=1.0)
    assert noise[-1] == 0 and (noise[:-1] != 0).all()


def test_existing_array_of_that_name_is_replaced_in_the_output_only(sphere):
    add_array(sphere.GetPointData(), "MaternNoise", np.full(sphere.GetNumberOfPoints(), 7.0))
    result = matern_noise(sphere, range=1.0)
    assert names_of(result.GetPointData()).count("MaternNoise") == 1
    assert (values_of(sphere) == 7.0).all() and not (values_of(result) == 7.0).any()


def test_warp_vector_takes_noise_of_three_components_unasked(sphere):
    noise = matern_noise(sphere, range=1.0, components=3, standard_deviation=0.1)
    warp = vtkWarpVector()
    warp.SetInputData(noise)
    warp.Update()
    moved = vtk_to_numpy(warp.GetOutput().GetPoints().GetData())
    assert np.allclose(moved, vtk_to_numpy(sphere.GetPoints().GetData()) + values_of(noise), atol=1e-6)
    assert matern_noise(sphere, range=1.0).GetPointData().GetVectors() is None
    add_array(sphere.GetPointData(), "Velocity", np.ones((sphere.GetNumberOfPoints(), 3)))
    sphere.GetPointData().SetActiveVectors("Velocity")
    assert matern_noise(sphere, range=1.0, components=3).GetPointData().GetVectors().GetName() == "Velocity"


def test_more_samples_than_fit_are_refused_before_memory_is_taken(sphere):
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for make in (
        lambda **limit: matern_noise(sphere, range=1.0, samples=2**31 - 1, **limit),
        lambda **limit: surfacesynthesis.gaussian_mixtures(sphere, 2**31 - 1, **limit),
    ):
        for limit in ({}, {"memory_limit": 1}):
            with pytest.raises(SurfaceSynthesisError, match=r"A NumberOfSamples of \d+ fits"):
                make(**limit)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss < before + 100_000  # KiB


LIMITED = """
import resource, sys
import surfacesynthesis
from conftest import icosphere
mesh = icosphere(5)
taken = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (taken + int(sys.argv[1]) * 2**20,) * 2)
try:
    surfacesynthesis.matern_noise(mesh, range=1.0)
except surfacesynthesis.SurfaceSynthesisError as error:
    print(error)
"""


def test_a_limit_of_address_space_ends_in_a_message():
    # OpenBLAS would try forever to map its buffers of 128 MiB, which has no room here.
    for room in (60, 120):
        process = subprocess.run([sys.executable, "-c", LIMITED, str(room)], cwd=os.path.dirname(__file__), timeout=60,
                                 capture_output=True, encoding="utf-8", check=False)  # fmt: skip
        assert process.returncode == 0, process.stderr
        assert "not enough memory" in process.stdout


def test_a_range_of_many_surfaces_is_warned_of(sphere):
    with pytest.warns(SurfaceSynthesisWarning, match="times the longest side of the surface"):
        matern_noise(sphere, range=100.0)


def test_coupled_components_have_common_noise():
    points, triangles = icosphere(3)
    both = np.concatenate([points, 1.01 * points]), np.concatenate([triangles, triangles + len(points)])
    inner, outer = np.split(matern_noise(both, range=1.0), 2)
    assert np.abs(inner - outer).max() > 1.0
    inner, outer = np.split(matern_noise(both, range=1.0, component_coupling=True), 2)
    assert np.abs(inner - outer).max() < 0.01  # of a deviation of 1
    with pytest.raises(SurfaceSynthesisError, match="farther than the coupling distance"):
        matern_noise(both, range=1.0, component_coupling=True, coupling_distance=1e-4)
