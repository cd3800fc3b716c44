# SPDX-License-Identifier: BSD-3-Clause
"""texture_atlas(), read_textured_mesh() and write_textured_mesh(), as functions and as commands."""

import base64
import json
import os
import struct
import zlib

import numpy as np
import pytest
import surfacesynthesis
from conftest import add_array, files_in, icosphere, point_array, points_of, polydata_of
from surfacesynthesis import (
    FormatError,
    SurfaceSynthesisError,
    SurfaceSynthesisWarning,
    read_mesh,
    read_textured_mesh,
    texture_atlas,
    write_textured_mesh,
)
from surfacesynthesis.command_line import main
from surfacesynthesis.files.images import png_of, read_image
from surfacesynthesis.textured_files import write_image
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkMultiBlockDataSet, vtkPolyData
from vtkmodules.vtkIOGeometry import vtkGLTFReader
from vtkmodules.vtkIOImage import vtkBMPWriter, vtkJPEGWriter, vtkPNGReader
from vtkmodules.vtkIOImport import vtkOBJImporter

WITH_ATLAS = pytest.mark.skipif(not hasattr(surfacesynthesis, "vtkTextureAtlasFilter"), reason="built without CGAL")
TEXTURED = (".obj", ".gltf", ".glb", ".ply")


def image_of(values):
    """The vtkImageData of texels [H, W, C], row 0 at v = 0."""
    image = vtkImageData()
    image.SetDimensions(values.shape[1], values.shape[0], 1)
    array = numpy_to_vtk(np.ascontiguousarray(values.reshape(-1, values.shape[2])), deep=True)
    array.SetName("Colors")
    image.GetPointData().SetScalars(array)
    return image


def texels_of(image):
    width, height, _ = image.GetDimensions()
    return vtk_to_numpy(image.GetPointData().GetScalars()).reshape(height, width, -1)


def texels_in(path):
    """The texels of a PNG file, by VTK in this process."""
    reader = vtkPNGReader()
    reader.SetFileName(str(path))
    reader.Update()
    return texels_of(reader.GetOutput())


@pytest.fixture
def texels():
    return np.random.default_rng(3).integers(0, 256, (6, 9, 3)).astype(np.uint8)


@pytest.fixture
def square():
    """Two triangles whose texture has a seam along their common side."""
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 0], [1, 1, 0]], dtype=float)
    mesh = polydata_of(points, [[0, 1, 2], [4, 5, 3]])
    texture = np.array([[0.1, 0.1], [0.4, 0.1], [0.4, 0.9], [0.9, 0.25], [0.6, 0.1], [0.6, 0.9]])
    add_array(mesh.GetPointData(), "TCoords", texture)
    mesh.GetPointData().SetActiveTCoords("TCoords")
    return mesh


# -- atlases -----------------------------------------------------------------------------------------------------------


@WITH_ATLAS
def test_atlas_covers_the_surface_and_leaves_the_input():
    mesh = polydata_of(*icosphere(2))
    result = texture_atlas(mesh, resolution=512, margin=2, maximum_stretch=1.5)
    assert mesh.GetPointData().GetNumberOfArrays() == 0
    assert result.GetNumberOfCells() == mesh.GetNumberOfCells()
    coordinates = vtk_to_numpy(result.GetPointData().GetTCoords())
    assert coordinates.shape == (result.GetNumberOfPoints(), 2)
    assert coordinates.min() >= 1 / 512 - 1e-12 and coordinates.max() <= 511 / 512 + 1e-12, "half of the margin"
    assert np.array_equal(points_of(result), points_of(mesh)[point_array(result, "OriginalPoint")])
    field = {name: result.GetFieldData().GetArray(name).GetValue(0) for name in ("Coverage", "LargestStretch")}
    assert 0.3 < field["Coverage"] < 1 and 1 < field["LargestStretch"] <= 1.5


@WITH_ATLAS
def test_atlas_of_a_pair_and_of_blocks():
    pair = icosphere(1)
    points, triangles, coordinates = texture_atlas(pair, resolution=(256, 128))
    assert len(points) == len(coordinates) > len(pair[0]) and np.array_equal(triangles.shape, pair[1].shape)
    assert np.array_equal(points[triangles], pair[0][pair[1]])
    blocks = vtkMultiBlockDataSet()
    blocks.SetBlock(0, polydata_of(*pair))
    result = texture_atlas(blocks, resolution=(256, 128))
    assert np.array_equal(vtk_to_numpy(result.GetBlock(0).GetPointData().GetTCoords()), coordinates)


@WITH_ATLAS
@pytest.mark.parametrize(
    "parameters, kind, text",
    [
        ({"resolution": 8}, ValueError, "resolution must be from 16"),
        ({"resolution": 40000}, ValueError, "resolution must be at most 32768"),
        ({"resolution": (64, 64, 64)}, TypeError, "width and height"),
        ({"resolution": 64.0}, TypeError, "width and height"),
        ({"margin": 0}, ValueError, "margin must be from 1"),
        ({"margin": 257}, ValueError, "margin must be at most 256"),
        ({"maximum_stretch": 1.0}, ValueError, "maximum_stretch must be from 1.01 to 100"),
        ({"progress": 3}, TypeError, "progress must be callable"),
    ],
)
def test_wrong_parameters_of_an_atlas_are_named(parameters, kind, text):
    with pytest.raises(kind, match=text):
        texture_atlas(icosphere(0), **parameters)


@WITH_ATLAS
def test_defects_and_cancellation_are_exceptions():
    points, triangles = icosphere(0)
    with pytest.raises(SurfaceSynthesisError, match="non-manifold edge"):
        texture_atlas((points, np.concatenate([triangles, triangles[:1]])))
    with pytest.raises(surfacesynthesis.Cancelled):
        texture_atlas((points, triangles), progress=lambda fraction: False)


@WITH_ATLAS
def test_command_of_an_atlas(tmp_path, capsys):
    surfacesynthesis.write_mesh(polydata_of(*icosphere(1)), tmp_path / "ball.off")
    assert main(["texture-atlas", str(tmp_path / "ball.off"), str(tmp_path / "ball.obj"), "--resolution", "128", "64"]) == 0
    assert "charts, " in capsys.readouterr().out
    mesh, image = read_textured_mesh(tmp_path / "ball.obj")
    assert image is None and mesh.GetPointData().GetTCoords().GetNumberOfTuples() == mesh.GetNumberOfPoints() > 42
    for arguments, text in (
        (["ball.off", "ball.stl"], "no texture coordinates; use .obj"),
        (["ball.off", "b.obj", "--resolution", "1", "2", "3"], "one number, or width and height"),
        (["ball.off", "b.obj", "--margin", "0"], "margin must be from 1"),
    ):
        assert main(["texture-atlas", *(str(tmp_path / a) if "." in a else a for a in arguments)]) == 2
        assert text in capsys.readouterr().err


# -- what is written is read again -------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", TEXTURED)
def test_surface_and_texture_survive(kind, square, texels, tmp_path):
    path = tmp_path / f"a square{kind}"
    write_textured_mesh(square, image_of(texels), path)
    mesh, image = read_textured_mesh(path)
    assert type(mesh) is vtkPolyData and type(image) is vtkImageData
    assert np.array_equal(texels_of(image), texels)
    assert image.GetPointData().GetScalars().GetName() == "Texture"
    corners = vtk_to_numpy(mesh.GetPolys().GetConnectivityArray())
    expected = vtk_to_numpy(square.GetPolys().GetConnectivityArray())
    assert np.array_equal(points_of(mesh)[corners], points_of(square)[expected])
    found = vtk_to_numpy(mesh.GetPointData().GetTCoords())[corners]
    assert np.allclose(found, point_array(square, "TCoords")[expected], rtol=0, atol=1e-7)
    beside = {".obj": ["a_square.mtl", "a_square.png"], ".ply": ["a_square.png"]}.get(kind, [])
    assert files_in(tmp_path) == sorted([path.name, *beside])


@pytest.mark.parametrize("kind", TEXTURED)
def test_without_an_image_the_coordinates_are_written(kind, square, tmp_path):
    write_textured_mesh(square, None, tmp_path / f"t{kind}")
    mesh, image = read_textured_mesh(tmp_path / f"t{kind}")
    assert image is None and mesh.GetPointData().GetTCoords().GetNumberOfTuples() == mesh.GetNumberOfPoints() == 6
    assert files_in(tmp_path) == [f"t{kind}"]


def test_vtks_own_importer_shows_the_texture_of_obj(square, texels, tmp_path):
    write_textured_mesh(square, image_of(texels), tmp_path / "t.obj")
    importer = vtkOBJImporter()
    importer.SetFileName(str(tmp_path / "t.obj"))
    importer.SetFileNameMTL(str(tmp_path / "t.mtl"))
    importer.SetTexturePath(str(tmp_path))
    importer.Update()
    actors = importer.GetRenderer().GetActors()
    actors = [actors.GetItemAsObject(k) for k in range(actors.GetNumberOfItems())]  # the first is of no material, and empty
    (actor,) = (actor for actor in actors if actor.GetMapper().GetInput().GetNumberOfCells() > 0)
    assert actor.GetTexture() is not None
    actor.GetTexture().GetInputAlgorithm().Update()
    assert np.array_equal(texels_of(actor.GetTexture().GetInput()), texels)
    assert actor.GetMapper().GetInput().GetPointData().GetTCoords() is not None


@pytest.mark.parametrize("kind", [".gltf", ".glb"])
def test_gltf_is_as_the_specification_says(kind, square, texels, tmp_path):
    write_textured_mesh(square, image_of(texels), tmp_path / f"t{kind}")
    data = (tmp_path / f"t{kind}").read_bytes()
    if kind == ".glb":
        length = struct.unpack_from("<I", data, 12)[0]
        document, binary = json.loads(data[20 : 20 + length]), data[28 + length :]
    else:
        document = json.loads(data)
        binary = base64.b64decode(document["buffers"][0]["uri"].partition(",")[2])
    assert document["buffers"][0]["byteLength"] == len(binary)
    material = document["materials"][document["meshes"][0]["primitives"][0]["material"]]
    texture = document["textures"][material["pbrMetallicRoughness"]["baseColorTexture"]["index"]]
    image = document["images"][texture["source"]]
    view = document["bufferViews"][image["bufferView"]]
    assert image["mimeType"] == "image/png" and "target" not in view and document["samplers"][texture["sampler"]]
    (tmp_path / "t.png").write_bytes(binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]])
    assert np.array_equal(texels_in(tmp_path / "t.png"), texels)
    reader = vtkGLTFReader()
    reader.SetFileName(str(tmp_path / f"t{kind}"))
    reader.Update()
    assert reader.GetNumberOfTextures() == 1
    found = vtk_to_numpy(reader.GetOutput().NewIterator().GetCurrentDataObject().GetPointData().GetTCoords())
    expected = point_array(square, "TCoords") * [1, -1] + [0, 1]  # glTF counts rows from the highest
    assert np.allclose(found, expected, rtol=0, atol=1e-7)


def test_components_and_types_are_scaled_to_bytes(tmp_path):
    ramp = np.linspace(0, 1, 8).reshape(2, 4, 1)
    expected = np.round(255 * ramp).astype(np.uint8)
    for values in (ramp, ramp.astype(np.float32), np.round(65535 * ramp).astype(np.uint16), expected):
        write_image(image_of(values), tmp_path / "t.png")
        assert np.array_equal(texels_in(tmp_path / "t.png"), expected)
    for components in (1, 2, 3, 4):
        values = np.arange(8 * components, dtype=np.uint8).reshape(2, 4, components)
        write_image(image_of(values), tmp_path / "t.png")
        assert np.array_equal(texels_in(tmp_path / "t.png"), values)
    wild = np.array([[[np.nan], [np.inf], [-np.inf], [7.0]]])
    write_image(image_of(wild), tmp_path / "t.png")
    assert texels_in(tmp_path / "t.png").ravel().tolist() == [0, 255, 0, 255]


def test_jpeg_bmp_and_tga_are_read(texels, tmp_path):
    for name, writer in (("t.bmp", vtkBMPWriter()), ("t.jpg", vtkJPEGWriter())):
        writer.SetInputData(image_of(np.full((16, 24, 3), [200, 100, 50], dtype=np.uint8)))
        writer.SetFileName(str(tmp_path / name))
        writer.Write()
        found = texels_of(read_image(tmp_path / name))
        assert found.shape == (16, 24, 3) and np.abs(found.astype(int) - [200, 100, 50]).max() <= 4
    header = struct.pack("<BBB5xHHHHBB", 0, 0, 2, 0, 0, 9, 6, 24, 0)
    (tmp_path / "t.tga").write_bytes(header + texels[..., ::-1].tobytes())
    assert np.array_equal(texels_of(read_image(tmp_path / "t.tga")), texels)


# -- files of other programs -------------------------------------------------------------------------------------------

OBJ = """mtllib scene.mtl
v 0 0 0
v 1 0 0
v 0 1 0
v 1 1 0
vt 0 0
vt 1 0
vt 0 1
vt 1 1
usemtl first
f 1/1 2/2 3/3
usemtl second
f 2/1 4/4 3/3
"""


def scene(folder, mtl, obj=OBJ):
    (folder / "scene.obj").write_text(obj)
    (folder / "scene.mtl").write_text(mtl)
    return folder / "scene.obj"


def test_obj_of_another_program(texels, tmp_path):
    (tmp_path / "maps").mkdir()
    write_image(image_of(texels), tmp_path / "maps" / "bark of oak.png")
    line = "\tmap_Kd -blendu on -o 0 0 0 -s 1 1 -mm 0 1 maps\\bark of oak.png"
    path = scene(tmp_path, f"# comment\nnewmtl first\n{line}\nnewmtl second\nKd 1 0 0\n{line}\nnewmtl third\n")
    mesh, image = read_textured_mesh(path)
    assert np.array_equal(texels_of(image), texels)
    assert mesh.GetNumberOfPoints() == 5, "the second point has two texture coordinates"


@pytest.mark.parametrize(
    "mtl, text",
    [
        ("newmtl first\nmap_Kd -s 2 2 2 a.png\n", "-s of map_Kd moves the texture"),
        ("newmtl first\nmap_Kd ../a.png\nnewmtl second\nmap_Kd ../a.png\n", "outside of the folder of scene.obj"),
        ("newmtl first\nmap_Kd /etc/hostname\nnewmtl second\nmap_Kd /etc/hostname\n", "outside of the folder"),
        ("newmtl first\nmap_Kd link.png\nnewmtl second\nmap_Kd link.png\n", "outside of the folder"),
        ("newmtl first\nmap_Kd folder\nnewmtl second\nmap_Kd folder\n", "no regular file"),
        ("newmtl first\nmap_Kd scene.mtl\nnewmtl second\nmap_Kd scene.mtl\n", "no PNG, JPEG, BMP or TGA image"),
        ("\0", "binary file"),
    ],
)
def test_textures_that_are_refused(mtl, text, texels, tmp_path):
    inner = tmp_path / "inner"
    (inner / "folder").mkdir(parents=True)
    for name in (tmp_path / "a.png", inner / "a.png", inner / "b.png"):
        write_image(image_of(texels), name)
    (inner / "link.png").symlink_to(tmp_path / "a.png")
    with pytest.raises(FormatError, match=text):
        read_textured_mesh(scene(inner, mtl))


def test_files_elsewhere_are_read_when_asked(texels, tmp_path):
    (tmp_path / "inner").mkdir()
    write_image(image_of(texels), tmp_path / "a.png")
    path = scene(tmp_path / "inner", "newmtl first\nmap_Kd ../a.png\nnewmtl second\nmap_Kd ../a.png\n")
    assert np.array_equal(texels_of(read_textured_mesh(path, any_folder=True)[1]), texels)


def test_missing_files_of_obj(tmp_path):
    path = scene(tmp_path, "newmtl first\nmap_Kd none.png\nnewmtl second\nmap_Kd none.png\n")
    with pytest.raises(FileNotFoundError, match="none.png is missing"):
        read_textured_mesh(path)
    (tmp_path / "scene.mtl").unlink()
    with pytest.warns(SurfaceSynthesisWarning, match="scene.mtl is missing"):
        assert read_textured_mesh(path)[1] is None


def colors_at(mesh, image):
    """The texel at the center of each triangle."""
    corners = vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    width, height, _ = image.GetDimensions()
    centers = point_array(mesh, "TCoords")[corners].mean(axis=1) * [width, height]
    columns, rows = np.floor(centers).astype(int).T
    return texels_of(image)[rows, columns]


def test_textures_of_several_materials_become_tiles_of_one_image(tmp_path):
    write_image(image_of(np.full((6, 9, 3), [200, 100, 50], dtype=np.uint8)), tmp_path / "a.png")
    write_image(image_of(np.full((4, 5, 1), 70, dtype=np.uint8)), tmp_path / "b.png")
    mesh, image = read_textured_mesh(scene(tmp_path, "newmtl first\nmap_Kd a.png\nnewmtl second\nmap_Kd b.png\n"))
    assert colors_at(mesh, image).tolist() == [[200, 100, 50], [70, 70, 70]]
    assert mesh.GetNumberOfPoints() == 6 and mesh.GetNumberOfCells() == 2, "points between materials are doubled"
    coordinates = point_array(mesh, "TCoords")
    assert coordinates.min() > 0 and coordinates.max() < 1, "margins keep tiles apart"
    plain = "newmtl first\nmap_Kd a.png\nnewmtl second\nKd 1 0 0.2\n"
    assert colors_at(*read_textured_mesh(scene(tmp_path, plain))).tolist() == [[200, 100, 50], [255, 0, 51]]
    without = OBJ.replace("2/1 4/4 3/3", "2 4 3")
    assert colors_at(*read_textured_mesh(scene(tmp_path, plain, without))).tolist() == [[200, 100, 50], [255, 0, 51]]
    same = "newmtl first\nmap_Kd a.png\nnewmtl second\nmap_Kd ./a.png\n"
    assert read_textured_mesh(scene(tmp_path, same))[1].GetDimensions() == (9, 6, 1), "one texture stays as it is"


def test_tiles_hold_their_textures_texel_by_texel(tmp_path):
    random = np.random.default_rng(1)
    images = [random.integers(0, 255, shape, dtype=np.uint8) for shape in ((6, 9, 3), (4, 5, 4))]
    for name, values in zip(("a.png", "b.png"), images):
        write_image(image_of(values), tmp_path / name)
    mesh, image = read_textured_mesh(scene(tmp_path, "newmtl first\nmap_Kd a.png\nnewmtl second\nmap_Kd b.png\n"))
    corners = vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    coordinates = point_array(mesh, "TCoords")[corners]
    for values, own, unit in zip(images, coordinates, ([[0, 0], [1, 0], [0, 1]], [[0, 0], [1, 1], [0, 1]])):
        size = np.array(values.shape[1::-1])
        corner = np.round(own[0] * image.GetDimensions()[:2]).astype(int)
        assert np.allclose(own * image.GetDimensions()[:2], corner + np.array(unit) * size, rtol=0, atol=1e-9)
        found = texels_of(image)[corner[1] : corner[1] + size[1], corner[0] : corner[0] + size[0]]
        assert np.array_equal(found[..., : values.shape[2]], values)
        assert values.shape[2] == 4 or (found[..., 3] == 255).all()


def test_several_textures_of_which_one_is_repeated_are_refused(texels, tmp_path):
    for name in ("a.png", "b.png"):
        write_image(image_of(texels), tmp_path / name)
    mtl = "newmtl first\nmap_Kd a.png\nnewmtl second\nmap_Kd b.png\n"
    path = scene(tmp_path, mtl, OBJ.replace("vt 1 1\n", "vt 1 2.5\n"))
    with pytest.raises(FormatError, match=r"1 corners of faces have texture coordinates outside \[0, 1\].*repeated"):
        read_textured_mesh(path)
    write_textured_mesh(read_textured_mesh(scene(tmp_path, mtl))[0], None, tmp_path / "t.ply")


def test_a_line_may_name_several_material_files(texels, tmp_path):
    write_image(image_of(texels), tmp_path / "a.png")
    (tmp_path / "other.mtl").write_text("newmtl second\nmap_Kd a.png\n")
    path = scene(tmp_path, "newmtl first\nmap_Kd a.png\n", OBJ.replace("scene.mtl", "scene.mtl other.mtl"))
    assert np.array_equal(texels_of(read_textured_mesh(path)[1]), texels)
    (tmp_path / "scene.mtl").rename(tmp_path / "two words.mtl")
    (tmp_path / "scene.obj").write_text(OBJ.replace("scene.mtl", "two words.mtl").replace("usemtl second\n", ""))
    assert np.array_equal(texels_of(read_textured_mesh(path)[1]), texels)


def test_texture_without_coordinates_is_refused(texels, tmp_path):
    write_image(image_of(texels), tmp_path / "a.png")
    obj = "mtllib scene.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl first\nf 1 2 3\n"
    with pytest.raises(FormatError, match="a texture but no texture coordinates"):
        read_textured_mesh(scene(tmp_path, "newmtl first\nmap_Kd a.png\n", obj))


def test_faces_without_texture_coordinates_are_counted(texels, tmp_path):
    write_image(image_of(texels), tmp_path / "a.png")
    mtl = "newmtl first\nmap_Kd a.png\nnewmtl second\nmap_Kd a.png\n"
    for corners in ("2 4 3", "2//1 4//1 3//1"):
        with pytest.raises(FormatError, match="1 of 2 faces have no texture coordinates"):
            obj = OBJ.replace("2/1 4/4 3/3", corners).replace("usemtl first", "vn 0 0 1\nusemtl first")
            read_textured_mesh(scene(tmp_path, mtl, obj))


def changed_gltf(square, texels, folder, change):
    """A written file, with its document changed."""
    write_textured_mesh(square, image_of(texels), folder / "t.gltf")
    document = json.loads((folder / "t.gltf").read_text())
    change(document)
    (folder / "t.gltf").write_text(json.dumps(document))
    return folder / "t.gltf"


def test_gltf_with_the_image_in_a_file_or_a_uri(square, texels, tmp_path):
    png = png_of(image_of(texels))
    (tmp_path / "a.png").write_bytes(png)
    for uri in ("a.png", "data:image/png;base64," + base64.b64encode(png).decode()):
        path = changed_gltf(square, texels[:1], tmp_path, lambda document: document.update(images=[{"uri": uri}]))
        assert np.array_equal(texels_of(read_textured_mesh(path)[1]), texels)


def test_gltf_of_several_parts_is_one_surface(square, texels, tmp_path):
    def repeat(document):
        document["nodes"].append({"mesh": 0, "translation": [2, 0, 0]})
        document["scenes"][0]["nodes"].append(1)

    mesh, image = read_textured_mesh(changed_gltf(square, texels, tmp_path, repeat))
    assert mesh.GetNumberOfPoints() == 12 and mesh.GetPointData().GetTCoords().GetNumberOfTuples() == 12
    assert np.array_equal(texels_of(image), texels)


def test_gltf_with_several_materials_has_one_image(square, tmp_path):
    texels = np.full((4, 6, 3), [10, 200, 30], dtype=np.uint8)
    other = png_of(image_of(np.full((8, 8, 3), [90, 0, 250], dtype=np.uint8)))

    def add_materials(document):
        first = document["meshes"][0]["primitives"][0]
        document["images"].append({"uri": "data:image/png;base64," + base64.b64encode(other).decode()})
        document["textures"].append({"source": 1})
        document["materials"].append({"pbrMetallicRoughness": {"baseColorTexture": {"index": 1}}})
        document["materials"].append({"pbrMetallicRoughness": {"baseColorFactor": [1, 0.2158605, 0, 1]}})
        bare = {name: index for name, index in first["attributes"].items() if name != "TEXCOORD_0"}
        parts = [first, {**first, "material": 1}, {**first, "material": 2, "attributes": bare}]
        document["meshes"][0]["primitives"] = parts

    mesh, image = read_textured_mesh(changed_gltf(square, texels, tmp_path, add_materials))
    count = square.GetNumberOfCells()
    expected = count * [[10, 200, 30]] + count * [[90, 0, 250]] + count * [[255, 128, 0]]  # sRGB of linear values
    assert colors_at(mesh, image).tolist() == expected


GLTF_FAULTS = {
    "is none of its 1 materials": lambda d: d["meshes"][0]["primitives"][0].update(material=5),
    "is none of its 1 textures": lambda d: d["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"].update(index=-1),
    "is none of its 1 images": lambda d: d["textures"][0].update(source=2),
    "the pbrMetallicRoughness is no object": lambda d: d["materials"][0].update(pbrMetallicRoughness=3),
    "other texture coordinates": lambda d: d["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"].update(texCoord=1),
    "does not lie within its buffer": lambda d: d["bufferViews"][-1].update(byteLength=10**9),
    "the image 0 is '../a.png'": lambda d: d.update(images=[{"uri": "../a.png"}]),
    "the image 0 is missing": lambda d: d.update(images=[{}]),
    "the image 0 is damaged": lambda d: d.update(images=[{"uri": "data:image/png;base64,!"}]),
    "no PNG, JPEG, BMP or TGA": lambda d: d.update(images=[{"bufferView": 0}]),
    "no texture coordinates": lambda d: d["meshes"][0]["primitives"][0]["attributes"].pop("TEXCOORD_0"),
}


@pytest.mark.parametrize("text", GLTF_FAULTS)
def test_faults_of_gltf_are_named(text, square, texels, tmp_path):
    path = changed_gltf(square, texels, tmp_path, GLTF_FAULTS[text])
    with pytest.raises(FormatError, match=text):
        read_textured_mesh(path)


def test_materials_do_not_matter_to_read_mesh(square, texels, tmp_path):
    path = changed_gltf(square, texels, tmp_path, GLTF_FAULTS["is none of its 1 materials"])
    assert read_mesh(path).GetNumberOfPoints() == 6


def test_ply_with_several_textures_is_refused(square, texels, tmp_path):
    write_textured_mesh(square, image_of(texels), tmp_path / "t.ply")
    data = (tmp_path / "t.ply").read_bytes()
    (tmp_path / "t.ply").write_bytes(data.replace(b"element vertex", b"comment TextureFile b.png\nelement vertex"))
    with pytest.raises(FormatError, match="2 textures"):
        read_textured_mesh(tmp_path / "t.ply")


# -- damaged images ----------------------------------------------------------------------------------------------------


def png_with(width, height):
    """A PNG file that announces a size."""
    header = b"IHDR" + struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    chunk = struct.pack(">I", 13) + header + struct.pack(">I", zlib.crc32(header))
    end = struct.pack(">I", 0) + b"IEND" + struct.pack(">I", zlib.crc32(b"IEND"))
    return b"\x89PNG\r\n\x1a\n" + chunk + end


DAMAGED = {
    "large.png": (png_with(2**31 - 1, 2**31 - 1), "at most 32768 along a side"),
    "wide.png": (png_with(32768, 32768), "268435456 in all"),
    "none.png": (png_with(0, 4), "0 x 4 texels"),
    "hollow.png": (png_with(4, 4), "cannot be read"),
    "short.png": (png_with(4, 4)[:20], "no size"),
    "cut.png": (png_with(4, 4)[:-12], "cut off"),
    "cut.bmp": (b"BM" + struct.pack("<IIIIiiHHIIIIII", 0, 0, 54, 40, 90, 90, 1, 24, 0, 0, 0, 0, 0, 0), "cut off"),
    "deep.bmp": (b"BM" + struct.pack("<IIIIiiHHIIIIII", 0, 0, 54, 40, 9, 9, 1, 8, 0, 0, 0, 0, 0, 0), "24 bits"),
    "cut.tga": (struct.pack("<BBB5xHHHHBB", 0, 0, 2, 0, 0, 999, 999, 24, 0), "cut off"),
    "packed.tga": (struct.pack("<BBB5xHHHHBB", 0, 0, 10, 0, 0, 9, 9, 24, 0), "without compression"),
    "cut.jpg": (b"\xff\xd8\xff\xe0\x00\x10JFIF", "no size"),
    "hollow.jpg": (b"\xff\xd8\xff\xc0\x00\x11\x08\x00\x08\x00\x08\x03", "cannot be read"),
    "text.png": (b"hello", "no PNG, JPEG, BMP or TGA"),
    "empty.tga": (b"", "no size"),
}


@pytest.mark.parametrize("name", DAMAGED)
def test_damaged_images_are_named(name, tmp_path):
    (tmp_path / name).write_bytes(DAMAGED[name][0])
    with pytest.raises(FormatError, match=DAMAGED[name][1]) as caught:
        read_image(tmp_path / name)
    assert str(caught.value).startswith(str(tmp_path / name))


# -- refusals of writing -----------------------------------------------------------------------------------------------


def test_what_cannot_be_written_is_named_and_leaves_nothing(square, texels, tmp_path):
    image, plain = image_of(texels), polydata_of(*icosphere(0))
    for mesh, picture, name, kind, text in (
        (square, image, "t.stl", ValueError, "textures are written to .obj, .gltf, .glb, .ply"),
        (square, image, "t.vtp", ValueError, "textures are written to"),
        (plain, image, "t.obj", ValueError, "no active texture coordinates"),
        (vtkMultiBlockDataSet(), image, "t.obj", TypeError, "mesh must be a vtkPolyData"),
        (square, "t.png", "t.obj", TypeError, "image must be a vtkImageData"),
        (square, vtkImageData(), "t.obj", ValueError, "without scalars"),
        (square, image_of(np.zeros((2, 2, 5))), "t.obj", ValueError, "5 components"),
        (square, image, "none/t.obj", FileNotFoundError, "folder .* does not exist"),
    ):
        with pytest.raises(kind, match=text):
            write_textured_mesh(mesh, picture, tmp_path / name)
    with pytest.raises(ValueError, match="images are written to .png"):
        write_image(image, tmp_path / "t.jpg")
    assert files_in(tmp_path) == []


def test_a_failed_write_leaves_the_former_files(square, texels, tmp_path, monkeypatch):
    write_textured_mesh(square, image_of(texels), tmp_path / "t.obj")
    before = {name: (tmp_path / name).read_bytes() for name in files_in(tmp_path)}

    def full(_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space left on device.*t.obj"):
        write_textured_mesh(square, image_of(255 - texels), tmp_path / "t.obj")
    assert {name: (tmp_path / name).read_bytes() for name in files_in(tmp_path)} == before
