# SPDX-License-Identifier: BSD-3-Clause
"""displacement_map() and its command: arrays, files, and surfaces that maps give back."""

import json
import os
import struct
import sys

import numpy as np
import pytest
import surfacesynthesis
from conftest import icosphere, polydata_of
from surfacesynthesis import SurfaceSynthesisError, displacement_map, texture_atlas, write_mesh
from surfacesynthesis.command_line import main
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkIOImage import vtkPNGReader
from vtkmodules.vtkIOXML import vtkXMLImageDataReader

EXAMPLES = os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, os.pardir, "Examples")
sys.path.insert(0, os.path.join(EXAMPLES, "Python"))
MODELS = os.path.join(EXAMPLES, "Models")
needs_atlas = pytest.mark.skipif(not hasattr(surfacesynthesis, "vtkTextureAtlasFilter"), reason="built without CGAL")


def square(height, cells=4):
    """A square with texture coordinates x and y, at heights of a function of x and y."""
    x, y = (values.ravel() for values in np.meshgrid(np.linspace(0, 1, cells + 1), np.linspace(0, 1, cells + 1)))
    first = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    ways = [(0, 1, cells + 2), (0, cells + 2, cells + 1)]
    triangles = np.concatenate([first[:, None] + np.array(way) for way in ways])
    mesh = polydata_of(np.stack([x, y, height(x, y)], axis=1), triangles)
    coordinates = numpy_to_vtk(np.stack([x, y], axis=1), deep=True)
    coordinates.SetName("TCoords")
    mesh.GetPointData().SetTCoords(coordinates)
    return mesh


def plane(x, y):
    return 0 * x * y


def slope(x, y):
    return 0.06 * x - 0.03 * y


def tags_of(data):
    """Type, count and value of the entries of a TIFF file."""
    start = struct.unpack_from("<I", data, 4)[0]
    count = struct.unpack_from("<H", data, start)[0]
    entries = [struct.unpack_from("<HHII", data, start + 2 + 12 * k) for k in range(count)]
    return {tag: (kind, number, value) for tag, kind, number, value in entries}


def test_arrays_have_the_top_row_first():
    maps = displacement_map(square(plane), square(slope, 30), resolution=(64, 32))
    x, y = np.meshgrid((np.arange(64) + 0.5) / 64, 1 - (np.arange(32) + 0.5) / 32)
    assert maps.height.shape == (32, 64) and maps.displacement.shape == (32, 64, 3) and maps.coverage.all()
    assert np.abs(maps.height - slope(x, y)).max() < 1e-7
    assert np.abs(maps.displacement[..., 2] - slope(x, y)).max() < 1e-7 and not maps.displacement[..., :2].any()
    assert maps["subdivision_levels"] == -1 and maps["misses"] == 0 and maps["covered_texels"] == 64 * 32
    assert maps["height_scale"] == pytest.approx(np.ptp(slope(x, y)), rel=1e-5)
    assert maps["height_midlevel"] == pytest.approx(-slope(x, y).min() / np.ptp(slope(x, y)), rel=1e-5)
    assert json.loads(maps.to_json())["misses"] == 0 and "height = (value" in str(maps)


def test_files_hold_the_maps(tmp_path):
    maps = displacement_map(square(plane), square(slope, 30), resolution=(64, 48))
    names = [str(tmp_path / name) for name in ("height.png", "vectors.tif", "all.vti")]
    maps.write(*names)
    reader = vtkPNGReader()
    reader.SetFileName(names[0])
    reader.Update()
    scalars = reader.GetOutput().GetPointData().GetScalars()
    assert scalars.GetDataTypeAsString() == "unsigned short" and scalars.GetNumberOfComponents() == 1
    values = vtk_to_numpy(scalars).reshape(48, 64)[::-1] / 65535
    heights = (values - maps["height_midlevel"]) * maps["height_scale"]
    assert np.abs(heights - maps.height).max() <= 0.51 / 65535 * maps["height_scale"]
    with open(names[1], "rb") as file:
        tags = tags_of(file.read())
    assert (tags[256][2], tags[257][2], tags[277][2]) == (64, 48, 3), "width, height, samples of a pixel"
    assert tags[339][2] == 3 or tags[339][1] == 3, "floating-point samples"
    assert tags[259][2] == 1 and tags[274][2] == 1, "no compression, top row first"
    import displacement_maps

    assert np.array_equal(displacement_maps.read_vectors(names[1]), maps.displacement)
    reader = vtkXMLImageDataReader()
    reader.SetFileName(names[2])
    reader.Update()
    assert [reader.GetOutput().GetPointData().HasArray(name) for name in ("Height", "Displacement", "Coverage")] == [1] * 3


def test_wrong_files_leave_none(tmp_path):
    maps = displacement_map(square(plane), square(slope), resolution=16)
    with pytest.raises(ValueError, match="written to .png"):
        maps.write(tmp_path / "height.png", tmp_path / "height.exr")
    with pytest.raises(OSError):
        maps.write(tmp_path / "height.png", tmp_path / "none" / "height.png")
    assert list(tmp_path.iterdir()) == []


def test_constant_heights_are_stored(tmp_path):
    same = displacement_map(square(plane), square(plane), resolution=16)
    assert (same["height_midlevel"], same["height_scale"]) == (0.0, 1.0)
    same.write(tmp_path / "height.png")
    lifted = displacement_map(square(plane), square(lambda x, y: 0 * x - 0.05), resolution=16)
    assert (lifted["height_midlevel"], lifted["height_scale"]) == pytest.approx((1.0, 0.05))


def test_arguments_are_checked():
    given, other = square(plane), square(slope)
    with pytest.raises(ValueError, match="resolution"):
        displacement_map(given, other, resolution=8)
    with pytest.raises(ValueError, match="vector_space"):
        displacement_map(given, other, vector_space="world")
    with pytest.raises(ValueError, match="maximum_distance"):
        displacement_map(given, other, maximum_distance=-1)
    with pytest.raises(SurfaceSynthesisError, match="no texture coordinates"):
        displacement_map(polydata_of(*icosphere(1)), other)


def test_the_command_prints_what_images_mean(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_mesh(square(plane), "plain.obj")
    write_mesh(square(slope, 20), "detailed.ply")
    command = ["displacement-map", "plain.obj", "detailed.ply", "height.png", "vectors.tif", "--resolution", "64", "--json"]
    assert main(command) == 0
    values = json.loads(capsys.readouterr().out)
    assert values["outputs"] == ["height.png", "vectors.tif"] and values["covered_texels"] == 64 * 64
    assert 0.3 < values["height_midlevel"] < 0.4 and values["height_scale"] == pytest.approx(0.09, rel=0.05)
    assert main(["displacement-map", "plain.obj", "detailed.ply", "height.jpg"]) == 2
    assert "displacement maps are written to" in capsys.readouterr().err
    assert main(["displacement-map", "detailed.ply", "plain.obj", "h.png", "--resolution", "8"]) == 2
    write_mesh(polydata_of(*icosphere(1)), "bare.ply")
    assert main(["displacement-map", "bare.ply", "detailed.ply", "h.png"]) != 0
    assert "texture-atlas" in capsys.readouterr().err


@needs_atlas
@pytest.mark.parametrize("texture", ["spikes", "knobs"])
def test_maps_give_the_texture_back(texture, tmp_path):
    """Vectors at the same points, and heights of spikes to the nearest place; of knobs, which lean over, heights are not
    enough."""
    import displacement_maps

    class Options:
        models, seed, output = MODELS, 1, str(tmp_path)

    plain = surfacesynthesis.remesh(polydata_of(*icosphere(3)), points=600, feature_angle=None)
    baked = displacement_maps.Baked(Options, texture, 512, plain)
    heights, vectors = displacement_maps.read_back(Options, baked, texture)
    assert baked.maps["subdivision_levels"] == 2
    errors = np.linalg.norm(baked.by_vectors(vectors) - baked.truth, axis=2) / baked.height
    seams = errors[baked.at_seam]
    print(f"{texture}: {displacement_maps.row_of(errors)}, at seams {displacement_maps.row_of(seams)} percent")
    assert errors.mean() < 0.01 and np.quantile(errors, 0.95) < 0.04
    assert seams.mean() < 0.04 and np.quantile(seams, 0.95) < 0.12 and 0.01 < baked.at_seam.mean() < 0.5
    found = surfacesynthesis.surface_distance(baked.surface_of(baked.by_heights(heights)), baked.detailed)
    shares = found["mean"] / baked.height, found["percentile_95"] / baked.height
    print(f"{texture}: heights {100 * shares[0]:.2f} {100 * shares[1]:.2f} percent")
    if texture == "spikes":
        assert shares[0] < 0.02 and shares[1] < 0.06
