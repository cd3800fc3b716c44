# SPDX-License-Identifier: BSD-3-Clause
"""texture_dataset(), its files, and the command ``dataset textures``."""

import json
import struct

import numpy as np
import pytest
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkIOImage import vtkJPEGWriter, vtkPNGWriter

from surfacesynthesis import Cancelled, FormatError, read_texture_dataset, texture_dataset, write_texture_dataset
from surfacesynthesis.command_line import main
from surfacesynthesis.texture_datasets import image_array, planar_mesh, reduced_image

SMALL = {"meshes": 2, "mesh_points": 40}
TRIANGLE = (np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]), np.array([[0, 1, 2]]))


def noise(height, width, channels=3, seed=1):
    return np.random.default_rng(seed).integers(0, 256, (height, width, channels), dtype=np.uint8)


def write_image(path, values):
    """Writes [H, W, C], top row first."""
    data = vtkImageData()
    data.SetDimensions(values.shape[1], values.shape[0], 1)
    data.GetPointData().SetScalars(numpy_to_vtk(values[::-1].reshape(-1, values.shape[2]), deep=True))
    writer = vtkJPEGWriter() if str(path).endswith(".jpg") else vtkPNGWriter()
    writer.SetInputData(data)
    writer.SetFileName(str(path))
    writer.Write()


def header_of(path):
    content = path.read_bytes()
    size = int.from_bytes(content[:8], "little")
    return json.loads(content[8 : 8 + size])


def test_the_file_has_the_agreed_layout_and_gives_back_what_was_made(tmp_path):
    path = tmp_path / "textures.safetensors"
    made = texture_dataset(path, [noise(20, 30), noise(40, 16)], **SMALL)
    header = header_of(path)
    assert header["__metadata__"] == {"content": "textures", "format_version": "1", "producer": "SurfaceSynthesis"}
    described = {name: (entry["dtype"], entry["shape"]) for name, entry in header.items() if name != "__metadata__"}
    assert described["images.0"] == ("U8", [20, 30, 3]) and described["images.1"] == ("U8", [40, 16, 3])
    assert described["meshes.1.points"] == ("F64", [40, 2])
    assert described["meshes.1.triangles"] == ("I64", [len(made.meshes[1].triangles), 3])
    assert len(described) == 2 + 2 * 2
    read = read_texture_dataset(path)
    assert all(np.array_equal(a, b) and a.dtype == b.dtype == np.uint8 for a, b in zip(read.images, made.images))
    assert all(np.array_equal(a, b) for one, other in zip(read.meshes, made.meshes) for a, b in zip(one, other))
    assert np.array_equal(made.images[0], noise(20, 30))


def test_the_seed_decides_everything(tmp_path):
    files = [tmp_path / f"{k}.safetensors" for k in range(3)]
    for path, seed in zip(files, (5, 5, -6)):
        texture_dataset(path, [noise(64, 64)], tile=16, tiles=3, seed=seed, **SMALL)
    first, second, third = (path.read_bytes() for path in files)
    assert first == second and first != third


def test_tiles_are_different_parts_of_the_image(tmp_path):
    image = noise(40, 70)
    made = texture_dataset(tmp_path / "t.safetensors", [image], tile=32, tiles=5, **SMALL)
    assert [tile.shape for tile in made.images] == [(32, 32, 3)] * 2
    assert np.array_equal(made.images[0], image[4:36, 3:35]) and np.array_equal(made.images[1], image[4:36, 35:67])
    assert len(texture_dataset(tmp_path / "t.safetensors", [image], tile=16, tiles=3, **SMALL).images) == 3


def test_images_are_reduced_without_aliasing():
    stripes = np.zeros((64, 96, 3), np.uint8)
    stripes[:, ::2] = 255
    small = reduced_image(stripes, 16)
    assert small.shape == (16, 24, 3) and small.dtype == np.uint8
    assert np.abs(small[2:-2, 2:-2].astype(int) - 127).max() < 12
    assert reduced_image(stripes, 64) is stripes


def test_arrays_of_all_kinds_become_rgb():
    gray = noise(17, 18, 1)
    rgb = np.repeat(gray, 3, axis=2)
    for image in (gray, gray[:, :, 0], np.concatenate([gray, noise(17, 18, 1, 2)], axis=2), gray / 255.0):
        assert np.array_equal(image_array(image), rgb) and image_array(image).dtype == np.uint8
    assert np.array_equal(image_array(gray.astype(np.uint16) * 257), rgb)
    assert np.array_equal(image_array(noise(17, 18, 4)), noise(17, 18, 4)[:, :, :3])


def test_files_of_images_have_their_top_row_first(tmp_path):
    image = noise(20, 24)
    write_image(tmp_path / "image.png", image)
    assert np.array_equal(image_array(tmp_path / "image.png"), image)
    write_image(tmp_path / "gray.png", image[:, :, :1])
    assert np.array_equal(image_array(tmp_path / "gray.png"), np.repeat(image[:, :, :1], 3, axis=2))
    smooth = np.broadcast_to(np.linspace(0, 255, 20)[:, None, None], (20, 24, 3)).astype(np.uint8)
    write_image(tmp_path / "image.jpg", smooth)
    assert np.abs(image_array(tmp_path / "image.jpg").astype(int) - smooth).max() < 8


def test_meshes_cover_the_square_with_even_counterclockwise_triangles():
    points, triangles = planar_mesh(400, np.random.default_rng(3))
    assert points.shape == (400, 2) and points.min() >= 0 and points.max() <= 1
    assert np.array_equal(np.unique(triangles), np.arange(400))
    a, b, c = (points[triangles[:, k]] for k in range(3))
    areas = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    assert areas.min() > 0 and 0.9 < areas.sum() <= 1
    edges = np.concatenate([np.linalg.norm(b - a, axis=1), np.linalg.norm(c - b, axis=1), np.linalg.norm(a - c, axis=1)])
    assert edges.min() > 0.5 * np.median(edges)  # of farthest points; of uniform random ones it is a hundredth
    _, counts = np.unique(np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)), axis=0, return_counts=True)
    assert counts.max() == 2 and (counts == 1).sum() < 90  # one outline


def test_progress_is_reported_and_cancels(tmp_path):
    fractions = []
    texture_dataset(tmp_path / "t.safetensors", [noise(16, 16)], **SMALL, progress=fractions.append)
    assert fractions == sorted(fractions) and fractions[-1] == 1.0 and len(fractions) == 3
    with pytest.raises(Cancelled):
        texture_dataset(tmp_path / "u.safetensors", [noise(16, 16)], **SMALL, progress=lambda fraction: False)
    assert not (tmp_path / "u.safetensors").exists()


@pytest.mark.parametrize(
    "images, options, error, text",
    [
        ([], {}, ValueError, "images is empty"),
        ("brick.png", {}, TypeError, "list of files or arrays"),
        ([np.zeros((20, 20, 5), np.uint8)], {}, ValueError, "C from 1 to 4"),
        ([np.zeros((20, 20, 3), np.int32)], {}, TypeError, "not int32"),
        ([np.full((20, 20), 1.5)], {}, ValueError, "from 0 to 1"),
        ([np.full((20, 20), np.nan)], {}, ValueError, "from 0 to 1"),
        ([np.zeros((8, 20, 3), np.uint8)], {}, ValueError, "20 x 8 pixels is too small"),
        ([np.zeros((20, 20, 3), np.uint8)], {"tile": 15}, ValueError, "tile must be from 16"),
        ([np.zeros((20, 20, 3), np.uint8)], {"meshes": 0}, ValueError, "meshes must be from 1"),
        ([np.zeros((20, 20, 3), np.uint8)], {"mesh_points": 3}, ValueError, "mesh_points must be from 16"),
        ([np.zeros((20, 20, 3), np.uint8)], {"seed": 0.5}, TypeError, "seed must be an integer"),
    ],
)
def test_wrong_arguments_are_refused(tmp_path, images, options, error, text):
    with pytest.raises(error, match=text):
        texture_dataset(tmp_path / "t.safetensors", images, **{**SMALL, **options})
    assert not (tmp_path / "t.safetensors").exists()


def test_files_that_are_no_images_are_refused(tmp_path):
    (tmp_path / "text.png").write_text("no image")
    write_image(tmp_path / "cut.png", noise(64, 64))
    (tmp_path / "cut.png").write_bytes((tmp_path / "cut.png").read_bytes()[:100])
    for name in ("text.png", "cut.png"):
        with pytest.raises(FormatError, match=name):
            image_array(tmp_path / name)
    with pytest.raises(FileNotFoundError):
        image_array(tmp_path / "missing.png")


@pytest.mark.parametrize(
    "mesh, text",
    [
        ((TRIANGLE[0], TRIANGLE[1][:, ::-1]), "not counterclockwise"),
        ((TRIANGLE[0] + 0.5, TRIANGLE[1]), "outside the unit square"),
        ((TRIANGLE[0], TRIANGLE[1] + 1), "does not exist"),
        ((np.zeros((3, 3)), TRIANGLE[1]), r"\[V, 2\] and \[F, 3\]"),
    ],
)
def test_wrong_meshes_are_refused(tmp_path, mesh, text):
    with pytest.raises(ValueError, match=text):
        write_texture_dataset(tmp_path / "t.safetensors", [noise(16, 16)], [mesh])
    with pytest.raises(ValueError, match="0 images and 1 meshes"):
        write_texture_dataset(tmp_path / "t.safetensors", [], [TRIANGLE])


def _changed(path, change):
    """Edits the header of a file."""
    content = path.read_bytes()
    size = int.from_bytes(content[:8], "little")
    header = json.loads(content[8 : 8 + size])
    change(header)
    text = json.dumps(header).encode()
    path.write_bytes(len(text).to_bytes(8, "little") + text + content[8 + size :])


@pytest.mark.parametrize(
    "change, text",
    [
        (lambda header: header["__metadata__"].update(content="other"), "the content is 'other'"),
        (lambda header: header["__metadata__"].update(format_version="2"), "the format_version is '2'"),
        (lambda header: header["images.0"].update(shape=[16, 48]), "does not fit its meaning"),
        (lambda header: header.__setitem__("images.1", header.pop("images.0")), "images.0 is missing"),
        (lambda header: header.__setitem__("other", header.pop("meshes.0.points")), "missing or has no meaning"),
    ],
)
def test_broken_files_are_refused(tmp_path, change, text):
    path = tmp_path / "t.safetensors"
    write_texture_dataset(path, [noise(16, 16)], [TRIANGLE])
    _changed(path, change)
    with pytest.raises(FormatError, match=text):
        read_texture_dataset(path)


def test_numbers_of_a_file_are_checked(tmp_path):
    path = tmp_path / "t.safetensors"
    write_texture_dataset(path, [noise(16, 16)], [TRIANGLE])
    triangles = np.array([0, 1, 2], dtype="<i8").tobytes()
    path.write_bytes(path.read_bytes().replace(triangles, np.array([0, 2, 1], dtype="<i8").tobytes()))
    with pytest.raises(FormatError, match="not counterclockwise"):
        read_texture_dataset(path)


def test_the_command_writes_a_dataset(tmp_path, capsys):
    images = [str(tmp_path / name) for name in ("a.png", "b.png")]
    for k, path in enumerate(images):
        write_image(path, noise(32, 48, seed=k))
    output = tmp_path / "t.safetensors"
    options = ["--tile", "16", "--tiles", "2", "--meshes", "2", "--mesh-points", "30", "--seed", "3", "--side", "24"]
    assert main(["dataset", "textures", *images, str(output), *options]) == 0
    assert "4 tiles, 2 meshes" in capsys.readouterr().out
    same = tmp_path / "same.safetensors"
    texture_dataset(same, images, tile=16, tiles=2, meshes=2, mesh_points=30, seed=3, side=24)
    assert output.read_bytes() == same.read_bytes()


def test_the_command_says_what_is_wrong(tmp_path, capsys):
    path = str(tmp_path / "a.png")
    write_image(path, noise(32, 48))
    assert main(["dataset", "textures", path, str(tmp_path / "t.safetensors"), "--meshes", "0"]) == 2
    assert "meshes must be from 1" in capsys.readouterr().err
    assert main(["dataset", "textures", path, str(tmp_path / "t.csv")]) == 2
    (tmp_path / "b.png").write_text("no image")
    assert main(["dataset", "textures", str(tmp_path / "b.png"), str(tmp_path / "t.safetensors")]) == 1
    assert "b.png" in capsys.readouterr().err


def test_an_image_of_an_absurd_size_is_refused_by_its_header(tmp_path):
    header = b"BM" + struct.pack("<IHHI", 84, 0, 0, 54) + struct.pack("<IiiHHIIiiII", 40, 40000, 40000, 1, 24, 0, 0, 0, 0, 0, 0)
    (tmp_path / "huge.bmp").write_bytes(header + bytes(30))
    with pytest.raises(FormatError, match="the BMP image is cut off"):
        texture_dataset(str(tmp_path / "out.safetensors"), [str(tmp_path / "huge.bmp")], **SMALL)
