# SPDX-License-Identifier: BSD-3-Clause
"""geometric_texture_from_example() and its command: arguments, arrays, units and files."""

import json

import numpy as np
import pytest
import surfacesynthesis
from conftest import add_array, icosphere, point_array, points_of, polydata_of
from surfacesynthesis import Cancelled, SurfaceSynthesisError, geometric_texture_from_example, read_mesh, write_mesh
from surfacesynthesis.command_line import main
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkSMPTools
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet, vtkPolyData

FIELDS = ("TextureScale", "Subdivisions", "NumberOfScales", "Mismatch")
#: One subdivision and one scale, which take about a second.
FEW = {"subdivisions": 1, "scales": 1}


def grid(cells, side, height=None):
    """Points and triangles of a square, cells x cells, at heights of a function of x and y."""
    x, y = (values.ravel() for values in np.meshgrid(*2 * [np.linspace(0.0, side, cells + 1)]))
    first = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    triangles = np.concatenate([first[:, None] + np.array(way) for way in ((0, 1, cells + 2), (0, cells + 2, cells + 1))])
    heights = np.zeros_like(x) if height is None else height(x, y)
    return np.stack([x, y, heights], axis=1), triangles


def bumps(x, y):
    """Round bumps, one in a unit of length."""
    return 0.2 * np.sin(2 * np.pi * x) * np.sin(2 * np.pi * y)


def ridges(x, y):
    """Ridges along x, two in a unit of length."""
    return 0.08 * np.sin(4 * np.pi * y) * (1.0 + 0.05 * np.sin(3.0 * x))


def torus(around, across):
    """A torus of 2 around * across triangles."""
    i, j = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    u, v = i * 2 * np.pi / around, j * 2 * np.pi / across
    points = np.stack([(3 + np.cos(v)) * np.cos(u), (3 + np.cos(v)) * np.sin(u), np.sin(v)], axis=-1).reshape(-1, 3)
    a, b, c, d = (across * ((i + k) % around) + (j + m) % across for k, m in ((0, 0), (1, 0), (1, 1), (0, 1)))
    return points, np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)


def mean_edge(points, triangles):
    """Mean length of the edges, each counted once."""
    sides = np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    sides = np.unique(np.sort(sides, axis=1), axis=0)
    return np.linalg.norm(points[sides[:, 0]] - points[sides[:, 1]], axis=1).mean()


def with_arrays(pair, **arrays):
    mesh = polydata_of(*pair)
    for name, values in arrays.items():
        add_array(mesh.GetPointData(), name, values)
    return mesh


def fields_of(mesh, names=FIELDS):
    return {name: vtk_to_numpy(mesh.GetFieldData().GetArray(name))[0] for name in names}


def roughness(values, axis, side):
    """Mean square difference of a grid of values [N, N] over the grid's spacing along an axis."""
    return np.mean((np.diff(values, axis=axis) * (values.shape[axis] - 1) / side) ** 2)


@pytest.fixture(scope="module")
def target():
    return torus(12, 5)


@pytest.fixture(scope="module")
def example():
    """800 triangles with bumps and hollows, four edges apart."""
    return grid(20, 2.5, bumps)


@pytest.fixture(scope="module")
def flat(example):
    """The example without its bumps."""
    return example[0] * [1.0, 1.0, 0.0], example[1]


@pytest.fixture(scope="module")
def textured(target, example, flat):
    """The target with the texture of the example, as a dataset."""
    return geometric_texture_from_example(polydata_of(*target), polydata_of(*example), polydata_of(*flat), seed=4, **FEW)


# -- datasets and pairs ------------------------------------------------------------------------------------------------


def test_a_dataset_and_pairs_get_the_same_texture(target, example, flat, textured):
    points, triangles = geometric_texture_from_example(target, example, flat, seed=4, **FEW)
    assert isinstance(textured, vtkPolyData) and textured.GetNumberOfPolys() == 4 * len(target[1])
    assert np.array_equal(points, points_of(textured)) and points.dtype == np.float64
    assert triangles.shape == (4 * len(target[1]), 3) and triangles.max() == len(points) - 1
    displacement = point_array(textured, "Displacement")
    assert displacement.shape == points.shape and displacement.dtype == np.float64


def test_inputs_are_not_modified_and_arrays_are_kept(target, example):
    mesh, given = with_arrays(target, Height=target[0][:, 2]), polydata_of(*example)
    before = points_of(mesh).copy(), points_of(given).copy(), mesh.GetMTime(), given.GetMTime()
    output = geometric_texture_from_example(mesh, given, displacement_name="Relief", **FEW)
    assert np.array_equal(points_of(mesh), before[0]) and np.array_equal(points_of(given), before[1])
    assert (mesh.GetMTime(), given.GetMTime()) == before[2:]
    assert mesh.GetPointData().GetNumberOfArrays() == 1 and mesh.GetFieldData().GetNumberOfArrays() == 0
    bare = points_of(output) - point_array(output, "Relief")
    assert np.abs(point_array(output, "Height") - bare[:, 2]).max() < 1e-12
    assert not output.GetPointData().HasArray("Displacement")


def test_fields_hold_what_was_used(target, example, flat, textured):
    found = fields_of(textured)
    assert (found["Subdivisions"], found["NumberOfScales"]) == (1, 1)
    bare = points_of(textured) - point_array(textured, "Displacement")
    triangles = vtk_to_numpy(textured.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    assert found["TextureScale"] == pytest.approx(mean_edge(bare, triangles) / mean_edge(*flat), rel=1e-6)
    assert 0.0 < found["Mismatch"] < 1.0
    given = geometric_texture_from_example(polydata_of(*target), example, flat, texture_scale=2.5 * found["TextureScale"])
    assert fields_of(given)["TextureScale"] == 2.5 * found["TextureScale"] and fields_of(given)["Subdivisions"] == 0
    assert 1 <= fields_of(given)["NumberOfScales"] <= 8


def test_displacements_are_as_large_as_those_of_the_example(example, flat):
    output = geometric_texture_from_example(polydata_of(*torus(16, 6)), example, flat, seed=4, **FEW)
    scale, heights = fields_of(output)["TextureScale"], example[0][:, 2]
    lengths = np.linalg.norm(point_array(output, "Displacement"), axis=1) / scale
    assert np.sqrt(np.mean(lengths**2)) == pytest.approx(np.sqrt(np.mean(heights**2)), rel=0.3)
    assert lengths.max() < 1.5 * heights.max()


def test_a_plain_example_says_what_is_texture(target, example, flat, textured):
    """The displacement of the example from the plain one: also where that lies below all of it."""
    bare = points_of(textured) - point_array(textured, "Displacement")
    normals = bare - [3.0, 3.0, 0.0] * bare / np.maximum(np.linalg.norm(bare[:, :2], axis=1, keepdims=True), 1.0)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    lower = flat[0] - [0.0, 0.0, 0.3], flat[1]
    lifted = geometric_texture_from_example(polydata_of(*target), example, lower, seed=4, **FEW)
    means = []
    for output in (textured, lifted):
        heights = np.sum(point_array(output, "Displacement") * normals, axis=1)
        means.append(heights.mean() / fields_of(output)["TextureScale"])
    assert abs(means[0]) < 0.05 and means[1] - means[0] == pytest.approx(0.3, abs=0.06)
    with pytest.raises(SurfaceSynthesisError, match="same triangles"):
        geometric_texture_from_example(target, example, grid(19, 2.5), **FEW)


def test_blocks_get_textures_of_their_own(target, example, flat):
    blocks = vtkMultiBlockDataSet()
    for number in range(2):
        blocks.SetBlock(number, polydata_of(*target))
    output = geometric_texture_from_example(blocks, example, flat, **FEW)
    first, second = (points_of(output.GetBlock(number)) for number in range(2))
    assert first.shape == second.shape and not np.array_equal(first, second)
    assert fields_of(output)["Subdivisions"] == 1


# -- seeds, masks, strengths and directions ----------------------------------------------------------------------------


def test_the_same_seed_gives_the_same_bits(target, example, flat, textured):
    for threads in (1, 2):
        vtkSMPTools.Initialize(threads)
        try:
            again = geometric_texture_from_example(target, example, flat, seed=4, **FEW)[0]
        finally:
            vtkSMPTools.Initialize(0)
        assert np.array_equal(again, points_of(textured)), threads
    other = geometric_texture_from_example(target, example, flat, seed=5, **FEW)[0]
    assert np.abs(other - points_of(textured)).max() > 0.1 * np.abs(point_array(textured, "Displacement")).max()


def test_a_mask_of_0_leaves_points(target, example, flat, textured):
    mesh = with_arrays(target, Mask=(target[0][:, 0] > 0.0).astype(float))
    output = geometric_texture_from_example(mesh, example, flat, seed=4, mask="Mask", **FEW)
    mask, moved = point_array(output, "Mask"), np.linalg.norm(point_array(output, "Displacement"), axis=1)
    bare = points_of(textured) - point_array(textured, "Displacement")
    outside = mask == 0.0
    assert 0.2 < outside.mean() < 0.8 and not moved[outside].any()
    assert np.abs(points_of(output) - bare)[outside].max() < 1e-12
    assert (moved[mask == 1.0] > 0.0).mean() > 0.9 and moved.max() > 0.3 * example[0][:, 2].max()


def test_strength_multiplies_displacements(target, example, flat, textured):
    displacement = point_array(textured, "Displacement")
    bare = points_of(textured) - displacement
    for strength in (0.0, 2.0):
        points = geometric_texture_from_example(target, example, flat, seed=4, strength=strength, **FEW)[0]
        assert np.abs(points - bare - strength * displacement).max() < 1e-12, strength


@pytest.mark.skipif(not hasattr(surfacesynthesis, "vtkIsotropicRemeshFilter"), reason="the package was built without CGAL")
def test_printable_textures_do_not_intersect(target, example, flat, tmp_path, monkeypatch, capsys):
    def intersections(mesh):
        return surfacesynthesis.geometric_texture_features(mesh)["number_of_self_intersections"]

    high = {"seed": 4, **FEW}
    assert intersections(geometric_texture_from_example(target, example, flat, **high)) > 0
    mesh = polydata_of(*target)
    output = geometric_texture_from_example(mesh, example, flat, printable=True, **high)
    assert intersections(output) == 0
    found = fields_of(output, ("NumberOfSelfIntersections", "HeightKept"))
    assert found["NumberOfSelfIntersections"] == 0 and 0.9 < found["HeightKept"] < 1.0, found
    low = geometric_texture_from_example(mesh, example, flat, printable=True, seed=4, strength=0.25, **FEW)
    same = geometric_texture_from_example(mesh, example, flat, seed=4, strength=0.25, **FEW)
    assert np.array_equal(points_of(low), points_of(same)), "nothing intersects, and the points keep their bits"
    monkeypatch.chdir(tmp_path)
    for name, surface in (("target", target), ("example", example), ("flat", flat)):
        write_mesh(polydata_of(*surface), name + ".vtp")
    words = ["geometric-texture-from-example", "target.vtp", "example.vtp", "out.stl", "--plain-example", "flat.vtp"]
    words += ["--seed", "4", "--subdivisions", "1", "--scales", "1", "--printable"]
    assert main([*words, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["height_kept"] == found["HeightKept"]
    assert intersections(read_mesh("out.stl")) == 0, "in single precision, and after rounding to a file"
    assert main(words) == 0 and "% of the height kept, 0 self-intersections, " in capsys.readouterr().out


def test_directions_turn_the_texture():
    """Ridges along the direction of the example come to lie along that of the target."""
    side, cells = 2.0, 12
    lined = grid(24, 2.0, ridges)
    example = with_arrays(lined, Along=np.tile([1.0, 0.0, 0.0], (len(lined[0]), 1)))
    given = grid(cells, side)
    for way, axis in (((1.0, 0.0, 0.0), 0), ((0.0, 1.0, 0.0), 1)):
        mesh = with_arrays(given, Way=np.tile(way, (len(given[0]), 1)))
        output = geometric_texture_from_example(
            mesh, example, grid(24, 2.0), orientation="Way", example_orientation="Along", texture_scale=1.0, **FEW
        )
        displacement = point_array(output, "Displacement")
        places = points_of(output) - displacement
        heights = displacement[np.lexsort((places[:, 0].round(6), places[:, 1].round(6))), 2].reshape(2 * cells + 1, -1)
        along, across = roughness(heights, 1 - axis, side), roughness(heights, axis, side)
        assert across > 4.0 * along > 0.0, (way, across, along)


def test_a_blend_has_the_features_of_each_example_where_its_share_is_all(tmp_path, monkeypatch, example, flat):
    given = grid(24, 2.0)
    mesh = with_arrays(given, Share=(given[0][:, 0] > 1.0).astype(float))
    low = example[0] * [1.0, 1.0, 0.25], example[1]
    output = geometric_texture_from_example(mesh, example, second_example=low, blend="Share", subdivisions=0, scales=1, seed=4)
    displacement = point_array(output, "Displacement")
    share = point_array(output, "Share")
    heights = [np.sqrt(np.mean(displacement[share == side] ** 2)) for side in (0.0, 1.0)]
    assert 0.1 < heights[1] / heights[0] < 0.5, heights
    monkeypatch.chdir(tmp_path)
    for name, surface in (("mesh", mesh), ("example", polydata_of(*example)), ("low", polydata_of(*low))):
        write_mesh(surface, name + ".vtp")
    words = ["geometric-texture-from-example", "mesh.vtp", "example.vtp", "out.vtp", "--subdivisions", "0", "--scales", "1"]
    assert main([*words, "--seed", "4", "--second-example", "low.vtp", "--blend", "Share"]) == 0
    assert np.array_equal(points_of(read_mesh("out.vtp")), points_of(output))
    both = ["--second-example", "low.vtp", "--blend", "Share", "--second-plain-example", "low.vtp"]
    for wrong in (["--blend", "Share"], ["--second-example", "low.vtp"], ["--second-smoothing-length", "0.3"],
                  ["--second-plain-example", "low.vtp"], [*both, "--second-smoothing-length", "0.3"]):  # fmt: skip
        assert main([*words, *wrong]) == 2
    flat_one = {"second_example": low, "second_plain_example": low, "blend": "Share"}
    output = geometric_texture_from_example(mesh, example, flat, subdivisions=0, scales=1, seed=4, **flat_one)
    lengths = np.linalg.norm(point_array(output, "Displacement"), axis=1)
    assert lengths[given[0][:, 0] > 1.7].max() < 0.05 * lengths.max(), "an example that is flat"


# -- installed examples ------------------------------------------------------------------------------------------------


def test_installed_examples_are_known_by_their_names(tmp_path, monkeypatch, capsys, target):
    mesh = with_arrays(target, Way=np.tile([0.0, 0.0, 1.0], (len(target[0]), 1)), Share=(target[0][:, 0] > 0.0).astype(float))
    mane = geometric_texture_from_example(mesh, "mane", seed=4, **FEW)
    mountains = geometric_texture_from_example(mesh, "mountains", seed=4, **FEW)
    turned = geometric_texture_from_example(mesh, "mane", seed=4, orientation="Way", **FEW)
    blended = geometric_texture_from_example(mesh, "mane", second_example="mountains", blend="Share", seed=4, **FEW)
    found = [point_array(output, "Displacement") for output in (mane, mountains, turned, blended)]
    for k, first in enumerate(found):
        assert np.abs(first).max() > 0.01
        for second in found[k + 1 :]:
            assert not np.array_equal(first, second)
    monkeypatch.chdir(tmp_path)
    write_mesh(mesh, "mesh.vtp")
    words = ["--subdivisions", "1", "--scales", "1", "--seed", "4"]
    assert main(["geometric-texture-from-example", "mesh.vtp", "mane", "out.vtp", *words, "--orientation", "Way"]) == 0
    assert np.array_equal(points_of(read_mesh("out.vtp")), points_of(turned))
    blend = ["--second-example", "mountains", "--blend", "Share"]
    assert main(["geometric-texture-from-example", "mesh.vtp", "mane", "out.vtp", *words, *blend]) == 0
    assert np.array_equal(points_of(read_mesh("out.vtp")), points_of(blended))
    capsys.readouterr()
    assert main(["geometric-texture-from-example", "mesh.vtp", "maine", "none.vtp"]) == 1
    assert "maine" in capsys.readouterr().err and not (tmp_path / "none.vtp").exists()


def test_examples_in_files_have_what_they_need(target, example, flat):
    with pytest.raises(ValueError, match="plain_example goes with a surface"):
        geometric_texture_from_example(target, "mane", flat)
    with pytest.raises(ValueError, match="second_plain_example goes with a surface"):
        geometric_texture_from_example(
            target, example, second_example="mane", second_plain_example=flat, blend="Share"
        )
    with pytest.raises(SurfaceSynthesisError, match='"mountains" has no direction'):
        mesh = with_arrays(target, Way=np.tile([0.0, 0.0, 1.0], (len(target[0]), 1)))
        geometric_texture_from_example(mesh, "mountains", orientation="Way", **FEW)
    with pytest.raises(ValueError, match="orientation and example_orientation go together"):
        geometric_texture_from_example(target, example, second_example="mane", blend="Share", orientation="Way")
    with pytest.raises(ValueError, match="second_example is the path of a surface; read it with read_mesh"):
        geometric_texture_from_example(target, example, second_example="scan.ply", blend="Share")
    with pytest.raises(SurfaceSynthesisError, match="an example of a geometric texture"):
        geometric_texture_from_example(target, "flow_spikes")


# -- units -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("unit", [2.0**-20, 2.0**20])
def test_units_do_not_matter(target, example, flat, textured, unit):
    mesh, *given = ((unit * points, triangles) for points, triangles in (target, example, flat))
    output = geometric_texture_from_example(polydata_of(*mesh), *given, seed=4, **FEW)
    assert np.abs(points_of(output) / unit - points_of(textured)).max() < 1e-9
    assert fields_of(output) == pytest.approx(fields_of(textured), rel=1e-6)


def test_a_larger_target_gets_a_larger_texture(target, example, flat, textured):
    output = geometric_texture_from_example(polydata_of(8.0 * target[0], target[1]), example, flat, seed=4, **FEW)
    assert np.abs(points_of(output) / 8.0 - points_of(textured)).max() < 1e-9
    assert fields_of(output)["TextureScale"] == pytest.approx(8.0 * fields_of(textured)["TextureScale"])


# -- arguments ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "parameters, error, text",
    [
        ({"seed": 1.5}, TypeError, "seed must be an integer"),
        ({"seed": 2**31}, ValueError, "seed must be from"),
        ({"texture_scale": 0.0}, ValueError, "texture_scale must be a finite number larger than 0"),
        ({"texture_scale": 2e12}, ValueError, "texture_scale must be at most"),
        ({"subdivisions": -1}, ValueError, "subdivisions must be from 0"),
        ({"subdivisions": 9}, ValueError, "subdivisions must be at most 8"),
        ({"scales": 0}, ValueError, "scales must be from 1"),
        ({"scales": 9}, ValueError, "scales must be at most 8"),
        ({"smoothing_length": 0.0}, ValueError, "smoothing_length must be a finite number larger than 0"),
        ({"smoothing_length": 1.0, "plain_example": icosphere(1)}, ValueError, "of no use with plain_example"),
        ({"orientation": "Way"}, ValueError, "orientation and example_orientation go together"),
        ({"example_orientation": "Way"}, ValueError, "orientation and example_orientation go together"),
        ({"blend": "Share"}, ValueError, "second_example and blend go together"),
        ({"second_example": icosphere(1)}, ValueError, "second_example and blend go together"),
        ({"second_smoothing_length": 1.0}, ValueError, "of no use without second_example"),
        ({"second_plain_example": icosphere(1)}, ValueError, "of no use without second_example"),
        ({"second_smoothing_length": -1.0}, ValueError, "second_smoothing_length must be a finite number larger than 0"),
        ({"size": ""}, ValueError, "size must be the name of an array"),
        ({"mask": np.ones(3)}, TypeError, "mask must be a string"),
        ({"strength": -1.0}, ValueError, "strength must be from 0"),
        ({"displacement_name": ""}, ValueError, "displacement_name must be the name"),
        ({"plain_example": "flat.ply"}, TypeError, "plain_example must be a vtkPolyData or a pair"),
        ({"progress": 3}, TypeError, "progress must be callable"),
    ],
)
def test_wrong_arguments_raise(target, example, parameters, error, text):
    with pytest.raises(error, match=text):
        geometric_texture_from_example(target, example, **parameters)


def test_wrong_surfaces_raise(target, example):
    with pytest.raises(TypeError, match="mesh must be"):
        geometric_texture_from_example("bunny.ply", example)
    with pytest.raises(TypeError, match="example must be a vtkPolyData or a pair"):
        geometric_texture_from_example(target, vtkMultiBlockDataSet())
    with pytest.raises(ValueError, match="points must have the shape"):
        geometric_texture_from_example(target, (example[0][:, :2], example[1]))
    with pytest.raises(SurfaceSynthesisError):
        geometric_texture_from_example(target, vtkPolyData())
    fan = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, -1, 0]]), np.array([[0, 1, 2], [0, 1, 3], [0, 1, 4]])
    for surfaces in ((fan, example), (target, fan)):
        with pytest.raises(SurfaceSynthesisError, match="more than two triangles|non-manifold"):
            geometric_texture_from_example(*surfaces)
    with pytest.raises(SurfaceSynthesisError, match="Wetness"):
        geometric_texture_from_example(target, example, mask="Wetness")


def test_empty_targets_give_empty_results(example):
    points, triangles = geometric_texture_from_example((np.zeros((0, 3)), np.zeros((0, 3), dtype=int)), example)
    assert points.shape == (0, 3) and triangles.shape == (0, 3)


def test_progress_rises_and_cancels(target, example):
    fractions = []
    geometric_texture_from_example(target, example, progress=fractions.append, **FEW)
    assert len(fractions) > 3 and fractions == sorted(fractions) and fractions[-1] == 1.0 and 0.0 <= fractions[0]
    with pytest.raises(Cancelled):
        geometric_texture_from_example(target, example, progress=lambda fraction: fraction < 0.5, **FEW)


# -- command -----------------------------------------------------------------------------------------------------------


def test_the_command_writes_the_texture(target, example, flat, textured, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_mesh(polydata_of(*target), "target.vtp")
    write_mesh(polydata_of(*example), "example.vtp")
    words = ["geometric-texture-from-example", "target.vtp", "example.vtp", "out.vtp"]
    words += ["--seed", "4", "--subdivisions", "1", "--scales", "1"]
    write_mesh(polydata_of(*flat), "flat.vtp")
    assert main([*words, "--plain-example", "flat.vtp", "--json"]) == 0
    found, output = json.loads(capsys.readouterr().out), read_mesh("out.vtp")
    assert np.array_equal(points_of(output), points_of(textured)) and fields_of(output) == fields_of(textured)
    names = ("texture_scale", "subdivisions", "scales", "mismatch")
    assert [found[name] for name in names] == list(fields_of(textured).values())
    assert found["outputs"] == ["out.vtp"] and found["points"] == textured.GetNumberOfPoints()
    assert main([*words, "--smoothing-length", "0.4"]) == 0
    text = capsys.readouterr().out
    assert text.startswith("texture scale ") and "1 subdivisions, 1 scales, mismatch " in text and "-> out.vtp" in text
    assert not np.array_equal(points_of(read_mesh("out.vtp")), points_of(textured))


def test_wrong_commands_write_nothing(target, example, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_mesh(polydata_of(*target), "target.ply")
    write_mesh(polydata_of(*example), "example.ply")
    blocks = vtkMultiBlockDataSet()
    blocks.SetBlock(0, polydata_of(*example))
    write_mesh(blocks, "blocks.vtm")
    for words, status, text in (
        (["example.ply", "out.xyz"], 2, "out.xyz"),
        (["example.ply", "out.ply", "--strength", "-1"], 2, "strength"),
        (["example.ply", "out.ply", "--smoothing-length", "1", "--plain-example", "example.ply"], 2, "--plain-example"),
        (["example.ply", "out.ply", "--orientation", "Way"], 2, "go together"),
        (["mane", "out.ply", "--plain-example", "example.ply"], 2, "--plain-example goes with a surface"),
        (["example.ply", "out.ply", "--plain-example", "smooth"], 2, "smooth"),
        (["none.ply", "out.ply"], 1, "none.ply"),
        (["blocks.vtm", "out.ply"], 1, "one surface is needed"),
        (["example.ply", "out.ply", "--mask", "Wetness"], 1, "Wetness"),
    ):
        assert main(["geometric-texture-from-example", "target.ply", *words]) == status, words
        assert text in capsys.readouterr().err, words
        assert not list(tmp_path.glob("out*")), words
