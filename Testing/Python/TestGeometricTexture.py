# SPDX-License-Identifier: BSD-3-Clause
"""Geometric textures: geometric_texture(), geometric_texture_distance() and their commands."""

import json

import numpy as np
import pytest
import surfacesynthesis
from conftest import add_array, icosphere, point_array, points_of, polydata_of
from surfacesynthesis import (
    Cancelled,
    SurfaceSynthesisError,
    geometric_texture,
    geometric_texture_distance,
    read_mesh,
    write_mesh,
)
from surfacesynthesis.command_line import main
from surfacesynthesis.safetensors import write_safetensors
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet, vtkPolyData

LEVELS, CHANNELS = 3, [4, 6, 6, 3]


@pytest.fixture
def model(tmp_path):
    """A texture of three levels with random weights, and an icosahedron as the template."""
    random = np.random.default_rng(3)
    tensors = {}
    for level in range(LEVELS):
        for k in range(len(CHANNELS) - 1):
            last = k == len(CHANNELS) - 2
            name = f"levels.{level}.layers.{k}." + ("conv" if last else "0.conv")
            inputs = CHANNELS[0] if k == 0 else 2 * CHANNELS[k]
            scale = (0.05 if last else 0.5) / np.sqrt(inputs)
            tensors[name + ".weight"] = random.uniform(-scale, scale, (CHANNELS[k + 1], inputs, 1))
            tensors[name + ".bias"] = random.uniform(-scale, scale, CHANNELS[k + 1])
    points, triangles = icosphere(0)
    tensors["template.points"] = points
    tensors["template.triangles"] = triangles.astype(np.int64)
    tensors["reconstruction_noise"] = random.normal(0, 0.1, points.shape)
    description = {
        "levels": LEVELS,
        "layers": len(CHANNELS),
        "start_channels": 6,
        "least_channels": 6,
        "most_channels": 6,
        "noise_amplitude": 0.1,
        "name": "pebbles",
    }
    metadata = {
        "architecture": "geometric_texture",
        "format_version": "1",
        "geometric_texture": json.dumps(description),
    }
    path = tmp_path / "pebbles.safetensors"
    write_safetensors(path, tensors, metadata, double=("template.points",))
    return path


# -- datasets and pairs ----------------------------------------------------------------------------------------------


def test_a_dataset_and_a_pair_get_the_same_texture(ball, model):
    mesh = polydata_of(*ball)
    before = points_of(mesh).copy()
    output = geometric_texture(mesh, model, seed=4)
    assert isinstance(output, vtkPolyData) and output.GetNumberOfPolys() == 16 * len(ball[1])
    points, triangles = geometric_texture(ball, model, seed=4)
    assert np.array_equal(points, points_of(output)) and points.dtype == np.float64
    assert triangles.shape == (16 * len(ball[1]), 3) and triangles.max() == len(points) - 1
    assert np.array_equal(points_of(mesh), before)
    assert np.abs(point_array(output, "Displacement")).max() > 1e-3
    assert sorted(set(point_array(output, "Level"))) == [0, 1, 2]


def test_seeds_give_other_samples_and_interpolation_leads_from_one_to_the_other(ball, model):
    first, second = (geometric_texture(ball, model, seed=seed)[0] for seed in (1, 2))
    assert np.abs(first - second).max() > 1e-4
    assert np.array_equal(geometric_texture(ball, model, seed=1)[0], first)
    assert np.array_equal(geometric_texture(ball, model, seed=1, second_seed=2, interpolation=1.0)[0], second)
    between = geometric_texture(ball, model, seed=1, second_seed=2, interpolation=0.5)[0]
    assert 0 < np.abs(between - first).max() and 0 < np.abs(between - second).max()


def test_noise_can_be_left_out(ball, model):
    quiet = geometric_texture(ball, model, noise_amplitude=0.0)[0]
    assert np.array_equal(geometric_texture(ball, model, levels_without_noise=range(LEVELS))[0], quiet)
    assert not np.array_equal(geometric_texture(ball, model, levels_without_noise=[0])[0], quiet)


def test_statistics_of_the_norms_are_added_to_models(ball, model, tmp_path):
    measured = tmp_path / "measured.safetensors"
    surfacesynthesis.add_texture_statistics(model, measured, measured_samples=2)
    published = geometric_texture(ball, model, seed=1)[0]
    assert np.array_equal(geometric_texture(ball, measured, seed=1)[0], published)
    local = geometric_texture(ball, measured, seed=1, norm_statistics="reference")[0]
    assert np.abs(local - published).max() > 1e-4
    with pytest.raises(SurfaceSynthesisError, match="texture-statistics"):
        geometric_texture(ball, model, norm_statistics="reference")
    with pytest.raises(SurfaceSynthesisError, match="No such file"):
        surfacesynthesis.add_texture_statistics(tmp_path / "none.safetensors", measured)
    for samples in (0, 1001):
        with pytest.raises(ValueError, match="measured_samples must be"):
            surfacesynthesis.add_texture_statistics(model, measured, measured_samples=samples)


def test_strength_multiplies_displacements(ball, model):
    mesh = polydata_of(*ball)
    add_array(mesh.GetPointData(), "Height", np.full(len(ball[0]), 0.5))
    way = point_array(geometric_texture(mesh, model), "Displacement")
    for options, factor in (({"strength": 3.0}, 3.0), ({"strength": 3.0, "strength_array": "Height"}, 1.5)):
        assert np.allclose(point_array(geometric_texture(mesh, model, **options), "Displacement"), factor * way, atol=1e-6)
    with pytest.raises(ValueError, match="strength must be"):
        geometric_texture(mesh, model, strength=-1.0)


def test_a_blend_of_a_model_with_itself_is_that_model(ball, model):
    mesh = polydata_of(*ball)
    add_array(mesh.GetPointData(), "Share", np.linspace(0.0, 1.0, len(ball[0])))
    plain = points_of(geometric_texture(mesh, model))
    assert np.allclose(points_of(geometric_texture(mesh, model, second_model=model, blend="Share")), plain, atol=1e-6)
    for options in ({"second_model": model}, {"blend": "Share"}):
        with pytest.raises(ValueError, match="go together"):
            geometric_texture(mesh, model, **options)


def saddle(size=24):
    """Points and triangles of a small saddle; the knobs that are shipped intersect one another on it."""
    steps = np.linspace(-1.0, 1.0, size)
    u, v = (part.ravel() for part in np.meshgrid(steps, steps, indexing="ij"))
    corner = np.arange(size * size).reshape(size, size)
    a, b, c, d = (part.ravel() for part in (corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]))
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return np.stack([u, v, 0.5 * (u * u - v * v)], axis=1), triangles


@pytest.mark.skipif(not hasattr(surfacesynthesis, "vtkIsotropicRemeshFilter"), reason="the package was built without CGAL")
def test_printable_knobs_do_not_intersect_and_keep_their_height(tmp_path, capsys):
    def intersections(mesh):
        return surfacesynthesis.geometric_texture_features(mesh)["number_of_self_intersections"]

    rough = geometric_texture(saddle(), "knobs", start_level=1, seed=1)
    assert intersections(rough) > 20
    assert intersections(geometric_texture(saddle(), "knobs", start_level=1, seed=1, printable=True)) == 0
    paths = [str(tmp_path / name) for name in ("saddle.ply", "printed.stl")]
    write_mesh(polydata_of(*saddle()), paths[0])
    options = ["--model", "knobs", "--start-level", "1", "--seed", "1", "--printable"]
    assert main(["geometric-texture", *paths, *options, "--json", "--no-progress"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["height_kept"] > 0.97 and found["number_of_self_intersections"] == 0, found
    assert intersections(read_mesh(paths[1])) == 0, "in single precision, and after rounding to a file"
    assert main(["geometric-texture", *paths, *options, "--no-progress"]) == 0
    assert "% of the height kept, 0 self-intersections" in capsys.readouterr().out


def test_levels_are_a_list_coarse_to_fine(ball, model):
    levels = geometric_texture(ball, model, output_levels=True)
    assert [len(triangles) for _, triangles in levels] == [len(ball[1]) * 4**k for k in range(LEVELS)]
    assert np.array_equal(levels[-1][0], geometric_texture(ball, model)[0])
    some = geometric_texture(ball, model, start_level=1, end_level=1, output_levels=True)
    assert len(some) == 1 and len(some[0][0]) == len(ball[0])


def test_scale_subdivides_the_target(ball, model):
    assert len(geometric_texture(ball, model, end_level=0, scale=0.25)[1]) == 16 * len(ball[1])
    assert len(geometric_texture(ball, model, end_level=0, scale=2.0)[1]) == len(ball[1])


needs_cgal = pytest.mark.skipif(
    not hasattr(surfacesynthesis, "vtkIsotropicRemeshFilter"), reason="the package was built without CGAL"
)


@needs_cgal
def test_the_size_of_a_texture_can_vary(ball, model):
    mesh = polydata_of(*ball)
    add_array(mesh.GetPointData(), "Size", np.full(len(ball[0]), 0.5))
    half = geometric_texture(mesh, model, end_level=0, prepare="remesh", size="Size")
    assert half.GetNumberOfPolys() == pytest.approx(4 * len(ball[1]), rel=0.25)
    with pytest.raises(ValueError, match="size is of use with prepare"):
        geometric_texture(mesh, model, size="Size")


@needs_cgal
def test_the_target_can_be_remeshed(ball, model):
    mesh = polydata_of(*ball)
    add_array(mesh.GetPointData(), "Upper", (ball[0][:, 2] > 0).astype(float))
    edge = surfacesynthesis.topology_report(mesh)["edge_length_mean"]
    for scale in (0.5, 1.0, 1.7):
        # no noise, so that what grows is small beside the edges
        output = geometric_texture(
            mesh, model, end_level=0, scale=scale, prepare="remesh", noise_amplitude=0.0, mask="Upper"
        )
        bare = points_of(output) - point_array(output, "Displacement")
        triangles = vtk_to_numpy(output.GetPolys().GetConnectivityArray()).reshape(-1, 3)
        found = surfacesynthesis.topology_report((bare, triangles))["edge_length_mean"]
        assert found == pytest.approx(scale * edge, rel=0.04)
        assert np.all(point_array(output, "Displacement")[point_array(output, "Upper") == 0] == 0)
    of_scale_1 = geometric_texture(mesh, model, end_level=0, scale=1, prepare="remesh")
    assert np.array_equal(points_of(geometric_texture(mesh, model, end_level=0, prepare="remesh")), points_of(of_scale_1))


def test_preparations_of_the_target_are_checked(ball, model):
    subdivided = geometric_texture(ball, model, end_level=0, scale=0.5)
    assert np.array_equal(geometric_texture(ball, model, end_level=0, scale=0.5, prepare="subdivide")[0], subdivided[0])
    as_it_is = geometric_texture(ball, model, end_level=0)
    assert np.array_equal(geometric_texture(ball, model, end_level=0, prepare="as_is")[0], as_it_is[0])
    assert np.array_equal(geometric_texture(ball, model, end_level=0, prepare="subdivide")[0], as_it_is[0])
    with pytest.raises(ValueError, match='scale is of no use with prepare "as_is"'):
        geometric_texture(ball, model, scale=0.5, prepare="as_is")
    with pytest.raises(ValueError, match="unknown prepare 'smooth'"):
        geometric_texture(ball, model, prepare="smooth")


def test_a_mask_limits_the_texture_and_arrays_are_interpolated(ball, model):
    mesh = polydata_of(*ball)
    add_array(mesh.GetPointData(), "Upper", (ball[0][:, 2] > 0).astype(float))
    output = geometric_texture(mesh, model, mask="Upper", mask_falloff=0.3)
    bare = point_array(output, "Upper") == 0
    assert np.all(point_array(output, "Displacement")[bare] == 0)
    assert np.abs(point_array(output, "Displacement")[~bare]).max() > 1e-3


def test_without_a_mesh_it_synthesizes_on_the_template(model):
    output = geometric_texture(None, model, seed=3)
    assert isinstance(output, vtkPolyData) and output.GetNumberOfPolys() == 20 * 16
    reconstruction = points_of(geometric_texture(None, model, seed=3, random_from=LEVELS))
    assert np.array_equal(points_of(geometric_texture(None, model, seed=9, random_from=LEVELS)), reconstruction)
    assert not np.array_equal(points_of(output), reconstruction)


def test_blocks_are_processed_one_by_one(ball, model):
    blocks = vtkMultiBlockDataSet()
    blocks.SetBlock(0, polydata_of(*ball))
    blocks.SetBlock(1, polydata_of(*ball))
    output = geometric_texture(blocks, model)
    first, second = (points_of(output.GetBlock(k)) for k in (0, 1))
    assert first.shape == second.shape and not np.array_equal(first, second)
    trees = geometric_texture(blocks, model, output_levels=True)
    assert np.array_equal(points_of(trees[-1].GetBlock(1)), second)


# -- what is wrong ---------------------------------------------------------------------------------------------------


def test_errors_are_exceptions(ball, model, tmp_path):
    with pytest.raises(SurfaceSynthesisError, match="No such file"):
        geometric_texture(ball, tmp_path / "none.safetensors")
    with pytest.raises(SurfaceSynthesisError, match='"Nothing" is missing'):
        geometric_texture(ball, model, mask="Nothing")
    points, triangles = ball
    flipped = triangles.copy()
    flipped[5] = flipped[5, ::-1]
    with pytest.raises(SurfaceSynthesisError, match="3 edge"):
        geometric_texture((points, flipped), model)


@pytest.mark.parametrize(
    "parameters, error",
    [
        ({"seed": 0.5}, TypeError),
        ({"start_level": -1}, ValueError),
        ({"end_level": -1}, ValueError),
        ({"interpolation": 1.5}, ValueError),
        ({"noise_amplitude": -0.1}, ValueError),
        ({"norm_statistics": "model"}, ValueError),
        ({"levels_without_noise": [-1]}, ValueError),
        ({"levels_without_noise": 3}, TypeError),
        ({"scale": 0}, ValueError),
        ({"mask_falloff": -1}, ValueError),
        ({"mask": ""}, ValueError),
        ({"random_from": -1}, ValueError),
        ({"output_levels": 1}, TypeError),
        ({"displacement_name": ""}, ValueError),
        ({"progress": 3}, TypeError),
    ],
)
def test_arguments_are_checked(ball, model, parameters, error):
    with pytest.raises(error):
        geometric_texture(ball, model, **parameters)


def test_progress_can_cancel(ball, model):
    seen = []
    geometric_texture(ball, model, progress=lambda fraction: seen.append(fraction))
    assert seen == sorted(seen) and seen[-1] == 1.0
    with pytest.raises(surfacesynthesis.Cancelled):
        geometric_texture(ball, model, progress=lambda fraction: False)


# -- the command -----------------------------------------------------------------------------------------------------


def test_the_command_writes_what_the_function_returns(ball, model, tmp_path, capsys):
    write_mesh(polydata_of(*ball), tmp_path / "ball.vtp")
    arguments = ["geometric-texture", tmp_path / "ball.vtp", tmp_path / "out.vtp", "--model", model, "--seed", 7]
    assert main([str(a) for a in arguments]) == 0
    assert "pebbles" in capsys.readouterr().out
    expected = geometric_texture(polydata_of(*ball), model, seed=7)
    assert np.array_equal(points_of(read_mesh(tmp_path / "out.vtp")), points_of(expected))


def test_the_command_writes_levels_by_number(ball, model, tmp_path):
    write_mesh(polydata_of(*ball), tmp_path / "ball.ply")
    arguments = ["geometric-texture", tmp_path / "ball.ply", tmp_path / "out.ply", "--model", model, "--output-levels"]
    assert main([str(a) for a in [*arguments, "--start-level", 1]]) == 0
    sizes = [read_mesh(tmp_path / f"out_{level}.ply").GetNumberOfPolys() for level in (1, 2)]
    assert sizes == [len(ball[1]), 4 * len(ball[1])] and not (tmp_path / "out_0.ply").exists()


def test_the_command_needs_no_input(model, tmp_path):
    arguments = ["geometric-texture", tmp_path / "sample.stl", "--model", model, "--random-from", 1, "--quiet"]
    assert main([str(a) for a in arguments]) == 0
    assert read_mesh(tmp_path / "sample.stl").GetNumberOfPolys() == 320


def test_the_command_refuses_wrong_usage(ball, model, tmp_path, capsys):
    write_mesh(polydata_of(*ball), tmp_path / "ball.ply")
    out = str(tmp_path / "out.ply")
    files = [str(tmp_path / "ball.ply"), out]
    assert main(["geometric-texture", *files, "--model", str(model), "--interpolation", "2"]) == 2
    assert "interpolation" in capsys.readouterr().err
    assert main(["geometric-texture", out, "--model", str(model), "--mask", "Upper"]) == 2
    assert "INPUT" in capsys.readouterr().err
    assert main(["geometric-texture", *files, "--model", str(model), "--start-level", "99"]) == 1
    assert "--start-level is 99; expected 0 to 2, the levels of the model." in capsys.readouterr().err
    assert main(["geometric-texture", str(tmp_path / "ball.ply"), out, "--model", str(tmp_path / "none")]) == 1


def test_geometric_texture_distance_tells_texture_and_not_shape_apart(model):
    coarse = icosphere(2)
    bare = polydata_of(*icosphere(3))
    rough = geometric_texture(coarse, model, start_level=1)
    other = geometric_texture(coarse, model, start_level=1, seed=1)
    unit = surfacesynthesis.topology_report(coarse)["edge_length_mean"] / 2
    units = {"unit_length": unit, "reference_unit_length": unit}
    same_texture = geometric_texture_distance(rough, other, **units)
    assert 0 < same_texture < 0.3 * geometric_texture_distance(bare, other, **units)
    assert geometric_texture_distance(other, other) == 0
    points, triangles = rough
    turned = np.column_stack([-points[:, 1], points[:, 0], points[:, 2]]) * 3 + 100
    assert geometric_texture_distance((turned, triangles), rough) < 1e-5
    assert geometric_texture_distance((turned, triangles), rough, **units) > 0.1


def test_geometric_texture_distance_depends_on_seed_and_projections_only_a_little():
    points, triangles = icosphere(2)
    meshes = (points, triangles), (points * [3.0, 1.0, 1.0], triangles)
    few = [geometric_texture_distance(*meshes, projections=16, seed=k) for k in range(20)]
    many = geometric_texture_distance(*meshes, projections=2000)
    assert geometric_texture_distance(*meshes, projections=16, seed=3) == few[3]
    assert len(set(few)) == 20
    assert abs(np.mean(few) - many) < 4 * np.std(few) / np.sqrt(20)


def test_geometric_texture_distance_says_what_is_wrong():
    mesh = polydata_of(*icosphere(1))
    with pytest.raises(SurfaceSynthesisError, match="The reference on port 1 is empty"):
        geometric_texture_distance(mesh, vtkPolyData())
    with pytest.raises(SurfaceSynthesisError, match="The surface on port 0 is empty"):
        geometric_texture_distance(vtkPolyData(), mesh)
    assert np.isnan(geometric_texture_distance(vtkPolyData(), vtkPolyData()))
    points, triangles = icosphere(1)
    with pytest.raises(SurfaceSynthesisError, match="The surface on port 0: .*vtkSurfaceRepairFilter"):
        geometric_texture_distance((points, [*triangles, triangles[0][[0, 0, 1]]]), mesh)
    with pytest.raises(TypeError, match="a vtkPolyData or a pair of arrays"):
        geometric_texture_distance(vtkMultiBlockDataSet(), mesh)
    with pytest.raises(ValueError, match="projections must be from 1"):
        geometric_texture_distance(mesh, mesh, projections=0)
    with pytest.raises(ValueError, match="at most 1000000"):
        geometric_texture_distance(mesh, mesh, projections=1000001)
    with pytest.raises(ValueError, match="rings must be from 1 to 16, not 0"):
        geometric_texture_distance(mesh, mesh, rings=0)
    with pytest.raises(ValueError, match="at most 16"):
        geometric_texture_distance(mesh, mesh, rings=17)
    with pytest.raises(ValueError, match="unit_length must be a finite number larger than 0"):
        geometric_texture_distance(mesh, mesh, unit_length=0)
    with pytest.raises(Cancelled):
        geometric_texture_distance(mesh, mesh, progress=lambda done: False)


def test_the_command_geometric_texture_distance_prints_what_the_function_returns(tmp_path, capsys):
    points, triangles = icosphere(2)
    meshes = polydata_of(points, triangles), polydata_of(points * [3.0, 1.0, 1.0], triangles)
    paths = [str(tmp_path / name) for name in ("ball.vtp", "egg.vtp")]
    for mesh, path in zip(meshes, paths):
        write_mesh(mesh, path)
    options = ["--projections", "40", "--seed", "5", "--unit-length", "0.5", "--reference-unit-length", "2"]
    expected = geometric_texture_distance(*meshes, projections=40, seed=5, unit_length=0.5, reference_unit_length=2.0)
    assert main(["geometric-texture-distance", *paths, *options, "--csv", "--no-progress"]) == 0
    names, values = capsys.readouterr().out.splitlines()
    assert float(dict(zip(names.split(","), values.split(",")))["Distance"]) == expected
    assert main(["geometric-texture-distance", *paths, *options, "--no-progress"]) == 0
    assert f"distance {expected:.6g}, standard error" in capsys.readouterr().out
    three = geometric_texture_distance(*meshes, projections=40, seed=5, unit_length=0.5, reference_unit_length=2.0, rings=3)
    assert three != expected
    assert main(["geometric-texture-distance", *paths, *options, "--rings", "3", "--json", "--no-progress"]) == 0
    assert json.loads(capsys.readouterr().out)["distance"] == three
    assert main(["geometric-texture-distance", *paths, "--projections", "0"]) == 2
    assert "projections must be from 1" in capsys.readouterr().err
    blocks = vtkMultiBlockDataSet()
    blocks.SetBlock(0, meshes[0])
    write_mesh(blocks, str(tmp_path / "blocks.vtm"))
    assert main(["geometric-texture-distance", str(tmp_path / "blocks.vtm"), paths[0]]) == 1
    assert "one surface is compared with another" in capsys.readouterr().err


@needs_cgal
def test_the_command_geometric_texture_remeshes(ball, model, tmp_path):
    write_mesh(polydata_of(*ball), str(tmp_path / "ball.vtp"))
    paths = [str(tmp_path / "ball.vtp"), str(tmp_path / "large.vtp")]
    options = ["--prepare", "remesh", "--scale", "1.6", "--end-level", "0"]
    assert main(["geometric-texture", *paths, "--model", str(model), *options, "--quiet"]) == 0
    expected = geometric_texture(polydata_of(*ball), model, end_level=0, scale=1.6, prepare="remesh")
    assert np.array_equal(points_of(read_mesh(paths[1])), points_of(expected))
    assert main(["geometric-texture", *paths, "--model", str(model), "--prepare", "as_is", "--scale", "2"]) == 2
