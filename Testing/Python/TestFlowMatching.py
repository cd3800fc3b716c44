# SPDX-License-Identifier: BSD-3-Clause
"""surfacesynthesis.deform(), sample_signal() and the commands ``deform`` and ``sample``."""

import json
import re
import resource
import warnings

import numpy as np
import pytest
import surfacesynthesis
from conftest import icosphere, point_array, points_of, polydata_of
from surfacesynthesis import SurfaceSynthesisError, SurfaceSynthesisWarning, deform, read_mesh, sample_signal, write_mesh
from surfacesynthesis.command_line import main
from surfacesynthesis.conversion import describe, expected_tensors
from surfacesynthesis.safetensors import write_safetensors
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet, vtkPolyData
from vtkmodules.vtkFiltersParallel import vtkIntegrateAttributes

STEPS = 3
SPHERE = 1 / (12 * np.pi)  # second moment of a sphere of area 1 about each axis


def write_model(path, components=None):
    """A flow matching model of a sphere with random weights: of positions, or of a signal."""
    head = {"head": "njf"} if components is None else {"head": "linear", "C_in": components, "C_out": components}
    metadata, network = describe({"n_blocks": 1, "C_width": 8, "cmlp_nlayers": 2, "extra_features": 4, **head})
    random = np.random.default_rng(5)
    tensors = {
        "velocity." + name: random.uniform(-0.3, 0.3, shape) for name, shape in expected_tensors(network).items()
    }
    channels = components or 3
    description = {
        "signal_name": "Position" if components is None else "Mixture",
        "signal_mean": [0.0] * channels,
        "signal_scale": [1.0] * channels,
        "noise": "matern",
        "noise_screening": 100.0,
        "noise_eigenpairs": 256,
        "noise_scale": 1.0,
        "iterations": 0,
        "shape_moments": [SPHERE, 0.0, 0.0, SPHERE, 0.0, SPHERE],
        "shape_spread": 0.0,
    }
    described = {
        "architecture": "flow_matching",
        "format_version": "1",
        "flow_matching": json.dumps(description),
        "velocity": json.dumps(metadata),
    }
    write_safetensors(path, tensors, described)
    return path


@pytest.fixture
def model(tmp_path):
    return write_model(tmp_path / "deformer.safetensors")


@pytest.fixture
def mixture(tmp_path):
    return write_model(tmp_path / "mixture.safetensors", components=2)


# -- datasets and pairs ----------------------------------------------------------------------------------------------


def test_a_dataset_and_a_pair_are_deformed_alike(ball, model):
    mesh = polydata_of(*ball)
    output = deform(mesh, model, seed=4, steps=STEPS)
    assert mesh.GetPointData().GetNumberOfArrays() == 0 and np.array_equal(points_of(mesh), ball[0])
    assert np.array_equal(points_of(output), deform(ball, model, seed=4, steps=STEPS))
    assert np.array_equal(points_of(output), ball[0] + point_array(output, "Displacement"))
    assert point_array(output, "InitialNoise").shape == (162, 3)
    assert output.GetCellData().GetArray("AreaRatio").GetNumberOfTuples() == 320
    assert not np.allclose(points_of(output), ball[0], atol=1e-2)
    assert not np.allclose(points_of(output), deform(ball, model, seed=5, steps=STEPS), atol=1e-2)
    still = deform(mesh, model, seed=4, steps=STEPS, move_points=False, displacement_name="Way",
                   initial_noise_name="Start", area_ratio_name="Stretch")  # fmt: skip
    assert np.array_equal(points_of(still), ball[0])
    assert np.array_equal(point_array(still, "Way"), point_array(output, "Displacement"))
    assert still.GetPointData().HasArray("Start") and still.GetCellData().HasArray("Stretch")


def test_the_noise_of_a_sample_gives_it_again(ball, model, mixture, tmp_path):
    sample = deform(polydata_of(*ball), model, seed=4, steps=STEPS, move_points=False)
    noise, displacement = point_array(sample, "InitialNoise"), point_array(sample, "Displacement")
    again = deform(ball, model, input_noise=noise, steps=STEPS)
    assert np.allclose(again, ball[0] + displacement, atol=1e-6) and abs(displacement).max() > 0.01
    by_name = deform(sample, model, input_noise="InitialNoise", steps=STEPS)
    assert np.array_equal(points_of(by_name), again)
    write_mesh(sample, tmp_path / "sample.vtp")
    files = [str(tmp_path / "sample.vtp"), str(tmp_path / "again.vtp")]
    options = ["--input-noise", "InitialNoise", "--steps", str(STEPS), "--quiet"]
    assert main(["deform", *files, "--model", str(model), *options]) == 0
    assert np.allclose(points_of(read_mesh(files[1])), again, atol=1e-6)
    signal = sample_signal(ball, mixture, input_noise=noise[:, :2], steps=STEPS)
    assert not np.allclose(signal, sample_signal(ball, mixture, input_noise=-noise[:, :2], steps=STEPS), atol=1e-3)
    with pytest.raises(TypeError, match="with a pair of arrays only"):
        deform(sample, model, input_noise=noise)
    with pytest.raises(SurfaceSynthesisError, match="no point array \"Start\""):
        deform(sample, model, input_noise="Start")
    with pytest.raises(SurfaceSynthesisError, match="NumberOfSamples must be 1"):
        deform(ball, model, input_noise=noise, samples=2)


def test_samples_are_blocks_or_an_axis(ball, model):
    blocks = deform(polydata_of(*ball), model, samples=3, first_sample=2, steps=STEPS)
    assert isinstance(blocks, vtkMultiBlockDataSet) and blocks.GetNumberOfBlocks() == 3
    assert blocks.GetMetaData(1).Get(vtkMultiBlockDataSet.NAME()) == "Sample 3"
    arrays = deform(ball, model, samples=3, first_sample=2, steps=STEPS)
    assert arrays.shape == (3, 162, 3)
    for k in range(3):
        assert np.array_equal(points_of(blocks.GetBlock(k)), arrays[k])
        assert np.array_equal(deform(ball, model, first_sample=2 + k, steps=STEPS), arrays[k])
    assert np.array_equal(deform(ball, model, samples=1, first_sample=2, steps=STEPS), arrays[:1])


def test_a_trajectory_leads_from_noise_to_the_sample(ball, model):
    states = deform(polydata_of(*ball), model, steps=STEPS, trajectory=True)
    assert len(states) == STEPS + 1
    assert np.allclose(points_of(states[0]), point_array(states[0], "InitialNoise"), atol=1e-9)
    assert np.array_equal(points_of(states[-1]), deform(ball, model, steps=STEPS))
    arrays = deform(ball, model, steps=STEPS, trajectory=True, samples=2)
    assert arrays.shape == (STEPS + 1, 2, 162, 3)
    assert all(np.array_equal(points_of(state), array[0]) for state, array in zip(states, arrays))


def test_integrators_differ(ball, model):
    results = [deform(ball, model, steps=STEPS, integrator=name) for name in surfacesynthesis.INTEGRATORS]
    assert len(results) == 3
    assert not np.array_equal(results[0], results[1]) and not np.array_equal(results[1], results[2])


def test_corrections_change_the_end_of_the_flow_alone(ball, model):
    plain, corrected = (deform(ball, model, steps=STEPS, trajectory=True, corrections=number) for number in (0, 2))
    assert np.array_equal(plain[:-1], corrected[:-1]) and not np.allclose(plain[-1], corrected[-1], atol=1e-6)
    assert np.array_equal(deform(ball, model, steps=STEPS), plain[-1]), "none suits a model that predicts velocities"


def test_the_temperature_scales_the_noise(ball, model):
    plain, warm, cold = (deform(ball, model, samples=1, steps=STEPS, trajectory=True, temperature=t) for t in (1, 2.5, 0))
    middle = cold[0].mean(axis=1)
    assert np.allclose(cold[0], middle, atol=1e-6), "no noise at all"
    assert np.allclose(warm[0] - middle, 2.5 * (plain[0] - middle), atol=1e-5) and np.ptp(plain[0]) > 0.1
    assert np.array_equal(plain[-1][0], deform(ball, model, steps=STEPS)) and not np.allclose(plain[-1], warm[-1], atol=1e-3)


def test_signals(ball, mixture, model):
    output = sample_signal(polydata_of(*ball), mixture, seed=1, steps=STEPS)
    values = sample_signal(ball, mixture, seed=1, steps=STEPS)
    assert values.shape == (162, 2) and np.array_equal(point_array(output, "Mixture"), values)
    assert np.array_equal(points_of(output), ball[0])
    assert sample_signal(ball, mixture, samples=2, steps=STEPS, trajectory=True).shape == (STEPS + 1, 2, 162, 2)
    named = sample_signal(polydata_of(*ball), mixture, seed=1, steps=STEPS, name="Heat")
    assert np.array_equal(point_array(named, "Heat"), values)
    assert np.allclose(sample_signal(ball, model, steps=STEPS), deform(ball, model, steps=STEPS), atol=1e-12)


def test_composite_and_empty(ball, model):
    blocks = vtkMultiBlockDataSet()
    blocks.SetBlock(0, polydata_of(*ball))
    assert isinstance(deform(blocks, model, steps=STEPS).GetBlock(0), vtkPolyData)
    assert deform(vtkPolyData(), model).GetNumberOfPoints() == 0
    assert deform((np.zeros((0, 3)), np.zeros((0, 3), dtype=int)), model).shape == (0, 3)


def test_progress_and_stop(ball, model):
    seen = []
    deform(ball, model, steps=STEPS, progress=seen.append)
    assert seen == sorted(seen) and seen[-1] == 1.0
    with pytest.raises(surfacesynthesis.Cancelled):
        deform(ball, model, progress=lambda fraction: False)
    with pytest.raises(surfacesynthesis.Cancelled):
        deform(ball, model, trajectory=True, progress=lambda fraction: fraction < 0.5)


# -- what is wrong ---------------------------------------------------------------------------------------------------


def test_errors_are_exceptions(ball, model, mixture, tmp_path):
    with pytest.raises(SurfaceSynthesisError, match='generates "Mixture"'):
        deform(ball, mixture)
    with pytest.raises(SurfaceSynthesisError, match="No such file"):
        deform(ball, tmp_path / "none.safetensors")
    with pytest.warns(SurfaceSynthesisWarning, match="shaped or turned unlike"):
        deform((ball[0] * [1, 1, 3], ball[1]), model, steps=1)
    for wrong in (
        {"seed": 0.5},
        {"samples": 0},
        {"first_sample": -1},
        {"steps": 0},
        {"steps": 10001},
        {"integrator": "leapfrog"},
        {"corrections": -1},
        {"corrections": 21},
        {"temperature": -0.1},
        {"temperature": 10.1},
        {"temperature": float("nan")},
        {"temperature": "hot"},
        {"trajectory": 1},
        {"move_points": "yes"},
        {"displacement_name": ""},
        {"progress": 3},
    ):
        with pytest.raises((TypeError, ValueError), match=next(iter(wrong))):
            deform(ball, model, **wrong)
    with pytest.raises(ValueError, match="name"):
        sample_signal(ball, mixture, name="")


def test_more_samples_than_fit_are_refused_before_memory_is_taken(ball, model, mixture):
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for generate, path in ((deform, model), (sample_signal, mixture)):
        with pytest.raises(SurfaceSynthesisError, match=r"A NumberOfSamples of \d+ fits"):
            generate(ball, path, samples=2**31 - 1)
        with pytest.raises(SurfaceSynthesisError, match="at most 0.000976562 GiB are allowed .*A NumberOfSamples of") as error:
            generate(ball, path, samples=1000, memory_limit=1)
        fitting = int(re.search(r"NumberOfSamples of (\d+)", str(error.value))[1])
        assert 10 < fitting < 1000 and len(generate(ball, path, samples=fitting, memory_limit=1, steps=1)) == fitting
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss < before + 200_000  # KiB


# -- the command -----------------------------------------------------------------------------------------------------


@pytest.fixture
def files(ball, tmp_path):
    write_mesh(polydata_of(*ball), tmp_path / "in.ply")
    return str(tmp_path / "in.ply"), tmp_path


def test_command_writes_what_the_function_gives(files, model, capsys):
    source, folder = files
    target = folder / "out.vtp"
    assert main(["deform", source, str(target), "--model", str(model), "--seed", "2", "--steps", "3"]) == 0
    assert "deformations from matern noise" in capsys.readouterr().out
    expected = deform(read_mesh(source), model, seed=2, steps=3)
    assert np.array_equal(points_of(read_mesh(target)), points_of(expected))
    assert read_mesh(target).GetPointData().HasArray("Displacement")


def test_command_writes_samples_and_trajectories_by_number(files, model):
    source, folder = files
    options = ["--model", str(model), "--steps", "2", "--quiet"]
    assert main(["deform", source, str(folder / "s.ply"), "--samples", "2", "--first-sample", "5", *options]) == 0
    assert sorted(path.name for path in folder.glob("s_*")) == ["s_5.ply", "s_6.ply"]
    assert main(["deform", source, str(folder / "s.vtm"), "--samples", "2", *options]) == 0
    assert read_mesh(folder / "s.vtm").GetNumberOfBlocks() == 2
    assert main(["deform", source, str(folder / "t.vtp"), "--trajectory", *options]) == 0
    assert sorted(path.name for path in folder.glob("t_*")) == ["t_0.vtp", "t_1.vtp", "t_2.vtp"]
    assert main(["deform", source, str(folder / "u.vtm"), "--trajectory", "--samples", "2", *options]) == 0
    assert read_mesh(folder / "u_1.vtm").GetNumberOfBlocks() == 2


def ball_with_eye():
    """A sphere with a small one under its surface, as a pair."""
    (body, faces), (eye, more) = icosphere(3), icosphere(2, 0.2)
    return np.concatenate([body, eye + [0.0, 0.0, 0.75]]), np.concatenate([faces, more + len(body)])


def test_coupled_components_move_together(model, tmp_path):
    points, triangles = ball_with_eye()
    with pytest.raises(SurfaceSynthesisError, match="2 connected components"):
        deform((points, triangles), model, steps=STEPS)
    coupled = {"component_coupling": True, "coupling_distance": 0.1, "steps": STEPS}
    moved = deform((points, triangles), model, samples=4, **coupled) - points
    top, eye = np.argmax(points[:642, 2]), 642 + np.argmax(points[642:, 2])  # 0.05 apart
    assert np.abs(moved[:, top]).max() > 0.1
    assert np.abs(moved[:, eye] - moved[:, top]).max() < 0.1 * np.abs(moved[:, top]).max()
    source, target = str(tmp_path / "eye.vtp"), str(tmp_path / "posed.vtp")
    write_mesh(polydata_of(points, triangles), source)
    options = ["--component-coupling", "--coupling-distance", "0.1", "--steps", str(STEPS), "--model", str(model)]
    assert main(["deform", source, target, *options]) == 0
    assert np.array_equal(points_of(read_mesh(target)), points_of(deform(read_mesh(source), model, **coupled)))
    with pytest.raises(ValueError, match="coupling_weight"):
        deform((points, triangles), model, coupling_weight=0.0)


def area_and_center(mesh):
    """As vtkIntegrateAttributes has them."""
    integration = vtkIntegrateAttributes()
    integration.SetInputData(mesh)
    integration.Update()
    output = integration.GetOutput()
    return output.GetCellData().GetArray("Area").GetValue(0), output.GetPoint(0)


def test_parts_take_the_normalization_of_their_whole(ball, model, tmp_path, capsys):
    points, triangles = ball[0] + [3.0, 0.0, 0.0], ball[1]
    area, center = area_and_center(polydata_of(points, triangles))
    assert np.allclose(center, [3.0, 0.0, 0.0], atol=1e-6) and 11.9 < area < 4 * np.pi
    whole = {"normalization_area": area, "normalization_center": center, "steps": STEPS}
    assert np.allclose(deform((points, triangles), model, **whole), deform((points, triangles), model, steps=STEPS), atol=1e-5)
    part = polydata_of(points, triangles[points[triangles].mean(axis=1)[:, 0] < 3.2])
    with pytest.warns(SurfaceSynthesisWarning, match="shaped or turned"):
        own = deform(part, model, steps=STEPS)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        moved = deform(part, model, **whole)
    assert np.abs(points_of(own) - points_of(moved)).max() > 1e-3
    noise = [np.abs(point_array(output, "InitialNoise")).max() for output in (own, moved)]
    assert noise[1] > noise[0]  # noise has the scale of the whole
    source, target = str(tmp_path / "part.vtp"), str(tmp_path / "posed.vtp")
    write_mesh(part, source)
    options = ["--normalization-area", repr(area), "--normalization-center", *map(repr, center), "--steps", str(STEPS)]
    assert main(["deform", source, target, "--model", str(model), *options]) == 0
    assert np.array_equal(points_of(read_mesh(target)), points_of(deform(read_mesh(source), model, **whole)))
    assert main(["deform", source, target, "--model", str(model), *options[:2]]) == 2
    assert "give both or none" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        ({"normalization_area": 1.0}, "go together"),
        ({"normalization_center": (0, 0, 0)}, "go together"),
        ({"normalization_area": 0.0, "normalization_center": (0, 0, 0)}, "normalization_area must be"),
        ({"normalization_area": 1.0, "normalization_center": (0, np.nan, 0)}, "normalization_center must be a finite"),
        ({"normalization_area": 1.0, "normalization_center": (0, 0)}, r"3 numbers, not an array of shape \(2,\)"),
    ],
)
def test_normalizations_are_checked(ball, model, mixture, wrong, text):
    with pytest.raises(ValueError, match=text):
        deform(ball, model, **wrong)
    with pytest.raises(ValueError, match=text):
        sample_signal(ball, mixture, **wrong)


def test_command_samples_signals(files, mixture, capsys):
    source, folder = files
    target = str(folder / "signal.vtp")
    flow = ["--model", str(mixture), "--seed", "2", "--steps", "3"]
    assert main(["sample", source, target, *flow, "--corrections", "1", "--temperature", "1.25"]) == 0
    corrected = sample_signal(read_mesh(source), mixture, seed=2, steps=3, corrections=1, temperature=1.25)
    found = read_mesh(target).GetPointData().GetArray("Mixture")
    assert np.array_equal(vtk_to_numpy(found), vtk_to_numpy(corrected.GetPointData().GetArray("Mixture")))
    capsys.readouterr()
    assert main(["sample", source, target, *flow, "--name", "Heat"]) == 0
    assert '"Mixture"' in capsys.readouterr().out
    found = vtk_to_numpy(read_mesh(target).GetPointData().GetArray("Heat"))
    expected = sample_signal(read_mesh(source), mixture, seed=2, steps=3)
    assert np.array_equal(found, vtk_to_numpy(expected.GetPointData().GetArray("Mixture")))
    assert main(["sample", source, str(folder / "s.vtm"), "--model", str(mixture), "--samples", "2", "--steps", "1"]) == 0
    assert read_mesh(folder / "s.vtm").GetNumberOfBlocks() == 2
    assert main(["sample", source, target, "--model", str(mixture), "--name", ""]) == 2


def test_command_says_what_is_wrong(files, model, mixture, capsys):
    source, folder = files
    out = str(folder / "o.vtp")
    assert main(["deform", source, out, "--model", str(mixture)]) == 1
    assert 'generates "Mixture"' in capsys.readouterr().err
    for options in (["--steps", "0"], ["--corrections", "21"], ["--temperature", "-1"], ["--integrator", "leapfrog"], ["--samples", "2", "--trajectory"]):
        assert main(["deform", source, out, "--model", str(model), *options]) == 2
    assert main(["deform", source, out]) == 2
    assert not (folder / "o.vtp").exists()
