# SPDX-License-Identifier: BSD-3-Clause
"""surfacesynthesis.read_mesh() and write_mesh()."""

import base64
import contextlib
import errno
import json
import os
import re
import struct
import subprocess
import sys
import warnings

import numpy as np
import pytest
from conftest import add_array, files_in, polydata_of
from surfacesynthesis import FormatError, SurfaceSynthesisError, SurfaceSynthesisWarning, read_mesh, write_mesh
from surfacesynthesis.files.polygons import PolygonMesh, from_polydata, to_polydata
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import (
    vtkCellArray,
    vtkImageData,
    vtkMultiBlockDataSet,
    vtkPolyData,
    vtkUnstructuredGrid,
)
from vtkmodules.vtkFiltersCore import vtkStripper
from vtkmodules.vtkIOGeometry import vtkGLTFReader, vtkOBJReader, vtkSTLWriter
from vtkmodules.vtkIOPLY import vtkPLYReader, vtkPLYWriter

SURFACE_FORMATS = (".stl", ".ply", ".obj", ".off", ".vtp", ".vtk", ".glb", ".gltf")
TRIANGLES_ONLY = (".stl", ".glb", ".gltf")  # in single precision


def points_of(mesh):
    return vtk_to_numpy(mesh.GetPoints().GetData())


def polygons_of(mesh):
    """The polygons as tuples of points, so that the numbering of the points does not matter."""
    arrays = from_polydata(mesh)
    points = np.round(arrays.points.astype(float), 5) + 0.0
    parts = np.split(arrays.connectivity, arrays.offsets[1:-1])
    return sorted(tuple(map(tuple, points[part])) for part in map(rotated(points), parts))


def rotated(points):
    """Starts a polygon at its first point in the order of coordinates."""

    def rotate(part):
        start = min(range(len(part)), key=lambda k: tuple(points[part[k]]))
        return np.roll(part, -start)

    return rotate


@pytest.fixture
def quads():
    """A cube of six squares and a triangle beside it."""
    points = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)] + [[3, 0, 0], [4, 0, 0], [3, 1, 0]])
    faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5], [8, 9, 10]]
    offsets = np.concatenate(([0], np.cumsum([len(face) for face in faces])))
    return to_polydata(PolygonMesh(points / 7.0, offsets, np.concatenate(faces), {}))


# -- what is written is read again -------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", SURFACE_FORMATS)
def test_shape_survives_every_format(kind, sphere, tmp_path):
    path = tmp_path / f"surface{kind}"
    write_mesh(sphere, path)
    result = read_mesh(path)
    assert type(result) is vtkPolyData
    assert result.GetNumberOfPoints() == sphere.GetNumberOfPoints(), "vertices are not shared"
    assert result.GetNumberOfPolys() == sphere.GetNumberOfPolys()
    if kind not in TRIANGLES_ONLY:
        assert np.array_equal(points_of(result), points_of(sphere))
    assert polygons_of(result) == polygons_of(sphere)
    assert files_in(tmp_path) == [path.name]


@pytest.mark.parametrize("kind", [".ply", ".vtp", ".vtk", ".glb", ".gltf"])
def test_point_arrays_survive(kind, sphere, tmp_path):
    add_array(sphere.GetPointData(), "vectors", np.arange(3.0 * sphere.GetNumberOfPoints()).reshape(-1, 3) / 7)
    write_mesh(sphere, tmp_path / f"surface{kind}")
    data = read_mesh(tmp_path / f"surface{kind}").GetPointData()
    single = (lambda values: values.astype(np.float32)) if kind in TRIANGLES_ONLY else np.asarray
    expected = vtk_to_numpy(sphere.GetPointData().GetArray("height"))
    assert np.array_equal(vtk_to_numpy(data.GetArray("height")), single(expected))
    vectors = single(vtk_to_numpy(sphere.GetPointData().GetArray("vectors")))
    if kind == ".ply":  # components are properties of their own
        found = np.stack([vtk_to_numpy(data.GetArray(f"vectors_{k}")) for k in range(3)], axis=1)
    else:
        found = vtk_to_numpy(data.GetArray("vectors"))
    assert np.array_equal(found, vectors)


@pytest.mark.parametrize("data", ["pair", None, vtkImageData()])
def test_other_data_than_meshes_are_a_type_error(data, pair, tmp_path):
    given = pair if data == "pair" else data
    with pytest.raises(TypeError, match="mesh must be a vtkPolyData.* not (tuple|NoneType|vtkImageData)"):
        write_mesh(given, tmp_path / "surface.ply")
    assert files_in(tmp_path) == []


@pytest.mark.parametrize("kind", SURFACE_FORMATS)
def test_polygons_survive_or_are_triangulated(kind, quads, tmp_path):
    write_mesh(quads, tmp_path / f"cube{kind}")
    result = read_mesh(tmp_path / f"cube{kind}")
    assert result.GetNumberOfPoints() == 11
    assert result.GetNumberOfPolys() == (13 if kind in TRIANGLES_ONLY else 7)
    if kind not in TRIANGLES_ONLY:
        assert polygons_of(result) == polygons_of(quads)


@pytest.mark.parametrize("kind", SURFACE_FORMATS)
def test_strips_are_written_as_triangles(kind, sphere, tmp_path):
    stripper = vtkStripper()
    stripper.SetInputData(sphere)
    stripper.Update()
    strips = stripper.GetOutput()
    assert strips.GetNumberOfStrips() > 0
    write_mesh(strips, tmp_path / f"strips{kind}")
    result = read_mesh(tmp_path / f"strips{kind}")
    assert polygons_of(result) == polygons_of(sphere)


@pytest.mark.parametrize("kind", [".ply", ".obj", ".off", ".vtp", ".vtk"])
def test_single_precision_stays_exact(kind, pair, tmp_path):
    mesh = polydata_of((1000 + pair[0]).astype(np.float32), pair[1])
    write_mesh(mesh, tmp_path / f"single{kind}")
    read = points_of(read_mesh(tmp_path / f"single{kind}"))
    assert np.array_equal(read.astype(np.float32), points_of(mesh))


@pytest.mark.parametrize("kind", SURFACE_FORMATS)
def test_mesh_without_polygons_can_be_written(kind, tmp_path):
    write_mesh(vtkPolyData(), tmp_path / f"empty{kind}")
    assert files_in(tmp_path) == [f"empty{kind}"]


def test_vtks_own_readers_read_ply_and_obj(quads, tmp_path):
    for kind, reader in ((".ply", vtkPLYReader()), (".obj", vtkOBJReader())):
        write_mesh(quads, tmp_path / f"cube{kind}")
        reader.SetFileName(str(tmp_path / f"cube{kind}"))
        reader.Update()
        assert polygons_of(reader.GetOutput()) == polygons_of(quads)


@pytest.mark.parametrize("kind", [".glb", ".gltf"])
def test_vtks_own_reader_reads_gltf(kind, sphere, tmp_path):
    write_mesh(sphere, tmp_path / f"s{kind}")
    reader = vtkGLTFReader()
    reader.SetFileName(str(tmp_path / f"s{kind}"))
    reader.Update()
    iterator = reader.GetOutput().NewIterator()
    found = iterator.GetCurrentDataObject()
    assert polygons_of(found) == polygons_of(sphere)
    assert found.GetPointData().HasArray("_height")


@pytest.mark.parametrize("binary", [True, False])
def test_files_of_vtks_own_writers_are_read(binary, sphere, tmp_path):
    for kind, writer in ((".ply", vtkPLYWriter()), (".stl", vtkSTLWriter())):
        writer.SetFileName(str(tmp_path / f"s{kind}"))
        writer.SetFileType(2 if binary else 1)
        writer.SetInputData(sphere)
        writer.Write()
        result = read_mesh(tmp_path / f"s{kind}")
        assert result.GetNumberOfPoints() == sphere.GetNumberOfPoints()
        assert np.allclose(points_of(result).sum(axis=0), points_of(sphere).sum(axis=0), atol=1e-3)


@pytest.mark.parametrize("kind", [".vtm", ".vtk"])
def test_composite_datasets(kind, sphere, tmp_path):
    blocks = vtkMultiBlockDataSet()
    blocks.SetBlock(0, sphere)
    blocks.SetBlock(2, sphere)
    for _ in range(2):  # the second time over the first
        write_mesh(blocks, tmp_path / f"blocks{kind}")
    result = read_mesh(tmp_path / f"blocks{kind}")
    assert type(result) is vtkMultiBlockDataSet and result.GetNumberOfBlocks() == 3
    assert polygons_of(result.GetBlock(2)) == polygons_of(sphere)
    assert not [name for name in files_in(tmp_path) if "surfacesynthesis" in name]


# -- reading by hand ---------------------------------------------------------------------------------------------------


def read_text(folder, name, text):
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_mesh(path)


TETRAHEDRON = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n"


@pytest.mark.parametrize(
    "text",
    [
        "OFF\n4 4 6\n" + TETRAHEDRON + "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n",
        "OFF 4 4 0\n" + TETRAHEDRON + "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2",
        "4 4 0\n" + TETRAHEDRON + "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n",
        "# a\nOFF # b\n\n4 4\n#c\n 0 0 0 # d\n1e0 0 0\n0 +1.0 0\n0 0 1\n\n3 0 2 1 # e\n3 0 1 3\n3 1 2 3\n3 0 3 2\n#f\n",
        "COFF\r\n4 4 0\r\n0 0 0 255 0 0 255\r\n1 0 0 0 0 0 1\r\n0 1 0 1 1 1 1\r\n0 0 1 9 9 9 9\r\n"
        "3 0 2 1\r\n3 0 1 3\r\n3 1 2 3\r\n3 0 3 2\r\n",
        "NOFF\n4 4 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n0 0 1 0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n",
        "OFF\n4 4 0\n" + TETRAHEDRON + "3 0 2 1 255 0 0\n3 0 1 3 0.5 0.5 0.5 1\n3 1 2 3\n3 0 3 2 7\n",
    ],
)
def test_off_dialects(text, tmp_path):
    mesh = read_text(tmp_path, "t.off", text)
    assert points_of(mesh).tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    ids = vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    assert ids.tolist() == [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]


@pytest.mark.parametrize(
    "text, words",
    [
        ("", "this one is empty"),
        ("# only a comment\n", "this one is empty"),
        ("solid x\n", "t.off:1: an OFF file starts with the word OFF"),
        ("OFF BINARY\n\0\0", "t.off:1: binary OFF cannot be read"),
        ("4OFF\n1 0 0\n0 0 0 0\n", "t.off:1: points of another dimension"),
        ("nOFF\n3\n1 0 0\n0 0 0\n", "t.off:1: points of another dimension"),
        ("OFF\n", "ends before the numbers"),
        ("OFF\n# counts\n3 x 0\n", "t.off:3: expected the numbers of vertices, faces and edges"),
        ("OFF\n-3 1 0\n", "t.off:2: expected the numbers"),
        ("OFF\n3\n", "t.off:2: expected the numbers"),
        ("OFF\n4 1 0\n0 0 0\n1 0 0\n", "ends after 2 of 4 vertices"),
        ("OFF\n99999999999999 1 0\n0 0 0\n", "ends after 1 of 99999999999999 vertices"),
        ("OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "ends after 1 of 2 faces"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 2\n", "t.off:7: text after the 3 vertices and 1 faces"),
        ("OFF\n3 1 0\n0 0 0\n1 0\n0 1 0\n3 0 1 2\n", "t.off:4: a vertex has 2 numbers instead of 3"),
        ("NOFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "t.off:3: a vertex has 3 numbers instead of 6"),
        ("OFF\n3 1 0\n0 0 0\n1 zero 0\n0 1 0\n3 0 1 2\n", "t.off:4: 'zero' is not a number"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", "t.off:6: a face names point 3; the file has points 0 to 2"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", "t.off:6: a face names point -1"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1.5 2\n", "t.off:6: a face names point 1.5"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n4 0 1 2\n", "t.off:6: a face of 4 points has 3 point numbers"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n", "t.off:6: a face has 2 points, fewer than 3"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\nx 0 1 2\n", "t.off:6: 'x' is not a number"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n-3 0 1 2\n", "t.off:6: '-3' is not a number of points"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\nnan 0 1 2\n", "t.off:6: 'nan' is not a number of points"),
    ],
)
def test_malformed_off(text, words, tmp_path):
    with pytest.raises(FormatError) as caught:
        read_text(tmp_path, "t.off", text)
    assert words in str(caught.value) and str(caught.value).startswith(str(tmp_path))


def test_obj_dialects(tmp_path):
    text = (
        "# a comment\nmtllib x.mtl\no thing\nv 0 0 0\nv 1 0 0 1.0\nv\t0 1 0 0.5 0.5 0.5\nv 0 0 1\nvt 0 0\nvn 0 0 1\n"
        "g one\ns off\nf 1/1/1 3/1 2//1\nf -4 -3 -1\nf 2 3 \\\n4\nl 1 2\nf 1 4 3 # end\n"
    )
    mesh = read_text(tmp_path, "t.obj", text)
    assert points_of(mesh).tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    ids = vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    assert ids.tolist() == [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]


TEXTURED = (
    "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nv 0 1 0 1 1 1\n"
    "vt 0 0\nvt 1 0\nvt 1 1\nvt 0.5\nvt 0 1\nvn 0 0 2\nvn 0 1 0\n"
    "f 1/1/1 2/2/1 3/3/1\nf 1/4/1 3/-3/2 4/5/1\n"
)


def test_textures_normals_and_colors_of_obj_files_are_kept(tmp_path):
    with pytest.warns(SurfaceSynthesisWarning, match="1 of 4 points lie on seams of the texture; .* seams='split'"):
        mesh = read_text(tmp_path, "t.obj", TEXTURED)
    data = mesh.GetPointData()
    assert mesh.GetNumberOfPoints() == 4
    assert vtk_to_numpy(data.GetTCoords()).tolist() == [[0, 0], [1, 0], [1, 1], [0, 1]]
    assert vtk_to_numpy(data.GetArray("RGB")).tolist() == [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 255]]
    slanted = np.array([0, 1, 2]) / np.sqrt(5)  # the mean of both
    assert np.allclose(vtk_to_numpy(data.GetNormals()), [[0, 0, 1], [0, 0, 1], slanted, [0, 0, 1]])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        split = read_mesh(tmp_path / "t.obj", seams="split")
    assert points_of(split).tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 0]]
    assert vtk_to_numpy(split.GetPointData().GetTCoords()).tolist() == [[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0]]
    assert vtk_to_numpy(split.GetPointData().GetArray("RGB"))[4].tolist() == [255, 0, 0]
    assert vtk_to_numpy(split.GetPolys().GetConnectivityArray()).tolist() == [0, 1, 2, 4, 2, 3]
    with pytest.raises(ValueError, match="seams is 'both'; one of join, split"):
        read_mesh(tmp_path / "t.obj", seams="both")


@pytest.mark.parametrize("kind", [".obj", ".ply", ".glb", ".gltf"])
def test_textures_normals_and_colors_survive(kind, tmp_path):
    (tmp_path / "t.obj").write_text(TEXTURED)
    mesh = read_mesh(tmp_path / "t.obj", seams="split")
    write_mesh(mesh, tmp_path / f"again{kind}")
    again = read_mesh(tmp_path / f"again{kind}")
    assert polygons_of(again) == polygons_of(mesh)
    for name in ("TCoords", "Normals", "RGB"):
        expected, found = (vtk_to_numpy(item.GetPointData().GetArray(name)) for item in (mesh, again))
        assert np.allclose(found, expected, atol=1e-6), name
    reader = vtkOBJReader()
    if kind == ".obj":
        reader.SetFileName(str(tmp_path / "again.obj"))
        reader.Update()
        assert polygons_of(reader.GetOutput()) == polygons_of(mesh)
        assert reader.GetOutput().GetPointData().GetTCoords() and reader.GetOutput().GetPointData().GetNormals()


@pytest.mark.parametrize(
    "form", ["1 2 3", "1/1 2/1 3/2", "1//1 2//1 3//1", "1/1/1 2/1/1 3/2/1", "1/1 2//1 3", "-3/-2 -2/1 -1/2"]
)
def test_forms_of_obj_faces(form, tmp_path):
    mesh = read_text(tmp_path, "t.obj", VERTICES + "vt 0 0\nvt 1 0\nvn 0 0 1\nf " + form + "\n")
    assert vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).tolist() == [0, 1, 2]
    assert (mesh.GetPointData().GetTCoords() is not None) == bool(re.search(r"\d/-?\d", form))
    assert (mesh.GetPointData().GetNormals() is not None) == bool(re.search(r"/\d?/", form))


VERTICES = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"


@pytest.mark.parametrize(
    "text, words",
    [
        ("", "no vertex found"),
        (b"\0\1\2v 1 2 3\n", "binary data"),
        ("hello world\n", "no vertex found"),
        ("v 0 0\n", "t.obj:1: a vertex has 2 numbers instead of 3"),
        ("v 0 0 a\n", "t.obj:1: 'a' is not a number"),
        (VERTICES + "f 1 2 4\n", "t.obj:4: a face names point 4; the file has points 1 to 3"),
        (VERTICES + "f 1 2 0\n", "t.obj:4: a face names point 0; OBJ counts from 1"),
        (VERTICES + "f 1 2 -4\n", "t.obj:4: a face names point -4"),
        (VERTICES + "f 1 2\n", "t.obj:4: a face has 2 points"),
        (VERTICES + "f 1 2 x\n", "t.obj:4: 'x' is not a number"),
        (VERTICES + "f 1 2 2.5\n", "t.obj:4: a face names point 2.5"),
        (VERTICES + "f 1 2 nan\n", "t.obj:4: a face names point nan"),
        (VERTICES + "f 1 2 3\nf 1/1 2/1 3/1\n", "t.obj:5: a face names texture coordinate 1; the file has 0"),
        (VERTICES + "vt 0 0\nf 1/1 2/1 3/-2\n", "t.obj:5: a face names texture coordinate -2; the file has 1"),
        (VERTICES + "vn 0 0 1\nf 1//1 2//1 3//1.5\n", "t.obj:5: a face names normal 1.5; the file has 1"),
        (VERTICES + "vn 0 0\nf 1//1 2//1 3//1\n", "t.obj:4: a normal has 2 numbers instead of 3"),
        (VERTICES + "f 1/x 2/1 3/1\n", "t.obj:4: 'x' is not a number"),
    ],
)
def test_malformed_obj(text, words, tmp_path):
    with pytest.raises(FormatError) as caught:
        read_text(tmp_path, "t.obj", text)
    assert words in str(caught.value)


def ply(form="ascii", vertices=4, faces=4, more=""):
    return (
        f"ply\nformat {form} 1.0\ncomment made by hand\nelement vertex {vertices}\nproperty float x\nproperty float y\n"
        f"property double z\n{more}element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )


def test_ply_text_with_further_properties_and_elements(tmp_path):
    text = (
        "ply\nformat ascii 1.0\nobj_info x\nelement note 1\nproperty list int int a\nelement vertex 4\n"
        "property uchar red\nproperty float x\nproperty float y\nproperty float z\nproperty uchar green\n"
        "property uchar blue\nproperty float quality\nelement face 2\nproperty float area\n"
        "property list uchar float texcoord\nproperty list uchar uint vertex_index\nproperty int flags\n"
        "element edge 1\nproperty int a\nproperty int b\nend_header\n2 8 9\n"
        "1 0 0 0 2 3 0.5\n4 1 0 0 5 6 1.5\n7 0 1 0 8 9 2.5\n10 0 0 1 11 12 3.5\n"
        "0.5 2 0.1 0.2 3 0 2 1 7\n0.5 0 4 0 1 2 3 7\n0 1\n"
    )
    mesh = read_text(tmp_path, "t.ply", text)
    assert points_of(mesh).tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    cells = mesh.GetPolys()
    assert vtk_to_numpy(cells.GetConnectivityArray()).tolist() == [0, 2, 1, 0, 1, 2, 3]
    assert vtk_to_numpy(mesh.GetPointData().GetArray("RGB")).tolist()[1] == [4, 5, 6]
    assert vtk_to_numpy(mesh.GetPointData().GetArray("quality")).tolist() == [0.5, 1.5, 2.5, 3.5]
    assert vtk_to_numpy(mesh.GetCellData().GetArray("area")).tolist() == [0.5, 0.5]
    assert vtk_to_numpy(mesh.GetCellData().GetArray("flags")).tolist() == [7, 7]


PLY_OF_VTK = {
    "a list of vertices": (
        ply(faces=1, more="property list uchar int near\n"), "0 0 0 2 5 6\n1 0 0 0\n0 1 0 0\n0 0 1 1 9\n3 0 1 2\n",
    ),
    "a word that is not known": (ply(faces=1).replace("comment", "author"), TETRAHEDRON + "3 0 1 2\n"),
    "uint": (ply(faces=1).replace("uchar int", "uint uint"), TETRAHEDRON + "3 0 1 2\n"),
    "int32": (ply(faces=1).replace("uchar int", "uint8 int32"), TETRAHEDRON + "3 0 1 2\n"),
    "ids as float": (ply(faces=1).replace("uchar int", "uchar float"), TETRAHEDRON + "3 0 1 2\n"),
    "obj_info": (ply(faces=1).replace("comment", "obj_info"), TETRAHEDRON + "3 0 1 2\n"),
    "colors of faces": (
        ply(faces=1).replace("end_header", "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header"),
        TETRAHEDRON + "3 0 1 2 10 20 30\n",
    ),
    "other elements": (
        ply(faces=1).replace("end_header", "element edge 1\nproperty int a\nend_header"), TETRAHEDRON + "3 0 1 2\n7\n",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", PLY_OF_VTK)
@pytest.mark.parametrize("line_end", ["\n", "\r\n"])
def test_ply_files_that_vtk_reads_are_read(name, line_end, tmp_path):
    text = "".join(PLY_OF_VTK[name]).replace("\n", line_end)
    mesh = read_text(tmp_path, "t.ply", text)
    reader = vtkPLYReader()
    reader.SetFileName(str(tmp_path / "t.ply"))
    reader.Update()
    expected = reader.GetOutput()
    assert polygons_of(mesh) == polygons_of(expected)
    assert (mesh.GetNumberOfPoints(), mesh.GetNumberOfPolys()) == (4, 1)
    for data, wanted in ((mesh.GetCellData(), expected.GetCellData()), (mesh.GetPointData(), expected.GetPointData())):
        for k in range(wanted.GetNumberOfArrays()):
            values = vtk_to_numpy(wanted.GetArray(k))
            assert (vtk_to_numpy(data.GetArray(wanted.GetArrayName(k))) == values).all(), wanted.GetArrayName(k)


def test_binary_ply_with_a_list_of_vertices(tmp_path):
    header = ply("binary_little_endian", 3, 1, "property list uchar int near\nproperty uchar level\n")
    rows = [
        struct.pack("<ffdB2iB", 0, 0, 0, 2, 7, 8, 1),
        struct.pack("<ffdBB", 1, 0, 0, 0, 2),
        struct.pack("<ffdBiB", 0, 1, 0, 1, 9, 3),
    ]
    mesh = read_text(tmp_path, "t.ply", header.encode() + b"".join(rows) + struct.pack("<B3i", 3, 0, 1, 2))
    assert points_of(mesh).tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    assert vtk_to_numpy(mesh.GetPointData().GetArray("level")).tolist() == [1, 2, 3]
    with pytest.raises(FormatError, match="ends within the 100000000000000000 elements 'vertex'|no size"):
        read_text(tmp_path, "t.ply", ply("binary_little_endian", 10**17, 1, "property list uchar int near\n").encode())


def test_texture_coordinates_of_ply_files(tmp_path):
    header = ply(faces=2).replace("vertex_indices\n", "vertex_indices\nproperty list uchar float texcoord\n")
    text = header + TETRAHEDRON + "3 0 1 2 6 0 0 1 0 0 1\n3 0 2 3 6 0 0 0.5 1 1 1\n"
    with pytest.warns(SurfaceSynthesisWarning, match="1 of 4 points lie on seams"):
        mesh = read_text(tmp_path, "t.ply", text)
    assert vtk_to_numpy(mesh.GetPointData().GetTCoords()).tolist() == [[0, 0], [1, 0], [0, 1], [1, 1]]
    assert read_mesh(tmp_path / "t.ply", seams="split").GetNumberOfPoints() == 5
    text = ply(faces=0, more="property float s\nproperty float t\n") + TETRAHEDRON.replace("\n", " 0.25 0.75\n")
    assert vtk_to_numpy(read_text(tmp_path, "t.ply", text).GetPointData().GetTCoords()).tolist() == 4 * [[0.25, 0.75]]


@pytest.mark.parametrize("order, form", [("<", "binary_little_endian"), (">", "binary_big_endian")])
def test_ply_binary_of_both_byte_orders_with_mixed_faces(order, form, tmp_path):
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    faces = [[0, 2, 1]] * 100 + [[0, 1, 2, 3], [0, 3, 1]] * 3 + [[1, 2, 3, 0, 1]] + [[1, 2, 3]] * 200
    data = ply(form, 4, len(faces)).encode()
    data += b"".join(struct.pack(order + "ffd", *point) for point in points)
    data += b"".join(struct.pack(f"{order}B{len(face)}i", len(face), *face) for face in faces)
    mesh = read_text(tmp_path, "t.ply", data)
    arrays = from_polydata(mesh)
    assert points_of(mesh).tolist() == points
    assert [part.tolist() for part in np.split(arrays.connectivity, arrays.offsets[1:-1])] == faces


@pytest.mark.parametrize(
    "text, words",
    [
        ("", "t.ply:1: a PLY file starts with the word ply"),
        ("ply\nformat ascii 1.0\n", "no end_header"),
        ("ply\nend_header\n", "no valid format"),
        ("ply\nformat ascii 1.0\nelement vertex -1\nend_header\n", "t.ply:3:"),
        ("ply\nformat ascii 1.0\nproperty float x\nend_header\n", "t.ply:3:"),
        ("ply\nformat ascii 1.0\nelement vertex 1\nproperty quad x\nend_header\n0\n", "t.ply:4:"),
        ("ply\nformat ascii 1.0\nend_header\n", "no element 'vertex'"),
        ("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n", "no property 'y'"),
        (ply() + "0 0 0\n1 0 0\n", "ends after 2 of 4 elements 'vertex'"),
        (ply() + "0 0 0\n1 0\n0 1 0\n0 0 1\n" + 4 * "3 0 1 2\n", "has 2 numbers instead of 3"),
        (ply() + "0 0 0\n1 0 x\n0 1 0\n0 0 1\n" + 4 * "3 0 1 2\n", "t.ply:12: 'x' is not a number"),
        (ply(faces=1) + TETRAHEDRON + "3 0 1 4\n", "face 0 names point 4; the file has points 0 to 3"),
        (ply(faces=1) + TETRAHEDRON + "3 0 1 -1\n", "face 0 names point -1"),
        (ply(faces=1) + TETRAHEDRON + "4 0 1 2\n", "t.ply:15: a face has fewer numbers"),
        (ply(faces=1) + TETRAHEDRON + "2 0 1\n", "t.ply:15: a face has 2 points, fewer than 3"),
        (ply(faces=1) + TETRAHEDRON + "3 0 1 2\nextra\n", "t.ply:16: text after"),
        (ply(faces=2) + TETRAHEDRON + "3 0 1 2\n3 0 1.5 2\n", "t.ply:16: '1.5' is not the number of a point"),
        (ply(faces=1) + TETRAHEDRON + "3.5 0 1 2\n", "t.ply:15: '3.5' is not a number of points"),
        (ply("binary_little_endian").encode() + b"\0" * 20, "ends within the 4 elements 'vertex'"),
        (ply("binary_little_endian", 1, 1).encode() + b"\0" * 16 + b"\3\0\0", "ends within the 1 elements 'face'"),
        (ply("binary_little_endian", 1, 1).encode() + b"\0" * 16 + b"\3" + struct.pack("<3i", 0, 0, 9), "names point 9"),
        (ply("binary_little_endian", 1, 10**17).encode() + b"\0" * 16, "ends within"),
        (ply("binary_little_endian", 10**17, 1).encode() + b"\0" * 16, "ends within"),
    ],
)
def test_malformed_ply(text, words, tmp_path):
    with pytest.raises(FormatError) as caught:
        read_text(tmp_path, "t.ply", text)
    assert words in str(caught.value)


def gltf(**changes):
    """A glTF document of one triangle, twice in the scene; changes: {"accessors.0.count": 4} and the like."""
    points, ids = np.eye(3, dtype=np.float32), np.array([0, 1, 2, 0], dtype=np.uint16)
    data = points.tobytes() + ids.tobytes()
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 2]}],
        "nodes": [
            {"children": [1], "translation": [10, 0, 0]},
            {"mesh": 0, "rotation": [0, 0, 0.5**0.5, 0.5**0.5], "scale": [2, 1, 1]},
            {"mesh": 0, "matrix": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1]},
        ],
        "meshes": [{"name": "corner", "primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"},
        ],
        "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 8}],
        "buffers": [{"byteLength": 44, "uri": "data:;base64," + base64.b64encode(data).decode()}],
    }  # fmt: skip
    for path, value in changes.items():
        *keys, last = [int(key) if key.isdigit() else key for key in path.split(".")]
        item = document
        for key in keys:
            item = item[key]
        item[last] = value
    return json.dumps(document)


def test_gltf_scenes(tmp_path):
    blocks = read_text(tmp_path, "t.gltf", gltf())
    assert type(blocks) is vtkMultiBlockDataSet and blocks.GetNumberOfBlocks() == 2
    assert blocks.GetMetaData(1).Get(vtkMultiBlockDataSet.NAME()) == "corner"
    # twice as long along x, a quarter turn about z, moved by 10
    assert np.allclose(points_of(blocks.GetBlock(0)), [[10, 2, 0], [9, 0, 0], [10, 0, 1]], atol=1e-6)
    # mirrored: triangles keep their outer side
    assert np.allclose(points_of(blocks.GetBlock(1)), [[-1, 0, 5], [0, 1, 5], [0, 0, 6]])
    assert vtk_to_numpy(blocks.GetBlock(1).GetPolys().GetConnectivityArray()).tolist() == [2, 1, 0]
    reader = vtkGLTFReader()
    reader.SetFileName(str(tmp_path / "t.gltf"))
    reader.Update()
    bounds = [0.0] * 6
    reader.GetOutput().GetBounds(bounds)
    expected = [0.0] * 6
    blocks.GetBounds(expected)
    assert np.allclose(bounds, expected, atol=1e-6)
    for mode, ids in ((5, [[0, 1, 2], [1, 2, 0][::-1]]), (6, [[0, 1, 2], [0, 2, 0]])):
        changes = {"scene": 0, "scenes.0.nodes": [2], "nodes.2": {"mesh": 0}, "accessors.1.count": 4}
        mesh = read_text(tmp_path, "t.gltf", gltf(**changes, **{"meshes.0.primitives.0.mode": mode}))
        found = vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3)
        assert sorted(map(set, found.tolist()), key=len) == sorted(map(set, ids), key=len)
        assert found[0].tolist() == [0, 1, 2]


def test_composite_datasets_become_scenes(tmp_path, sphere, quads):
    blocks = vtkMultiBlockDataSet()
    blocks.SetBlock(0, sphere)
    blocks.SetBlock(2, quads)
    write_mesh(blocks, tmp_path / "s.glb")
    result = read_mesh(tmp_path / "s.glb")
    assert [result.GetBlock(k).GetNumberOfPolys() for k in range(2)] == [sphere.GetNumberOfPolys(), 13]
    assert result.GetBlock(0).GetPointData().HasArray("height")
    blocks.SetBlock(1, vtkUnstructuredGrid())
    with pytest.raises(ValueError, match="only those of vtkPolyData can be written to .glb"):
        write_mesh(blocks, tmp_path / "s.glb")


def test_gltf_with_its_buffer_in_a_file(tmp_path):
    (tmp_path / "b.bin").write_bytes(np.eye(3, dtype=np.float32).tobytes() + np.arange(4, dtype=np.uint16).tobytes())
    mesh = read_text(tmp_path, "t.gltf", gltf(**{"buffers.0.uri": "b.bin", "scenes.0.nodes": [2]}))
    assert mesh.GetNumberOfPoints() == 3
    os.remove(tmp_path / "b.bin")
    os.mkfifo(tmp_path / "b.bin")
    with pytest.raises(FormatError, match="b.bin with a buffer is missing, or no regular file"):
        read_mesh(tmp_path / "t.gltf")


BAD_GLTF = [
    ({"accessors.0.count": 10**9}, "1000000000 values do not lie within their buffer"),
    ({"accessors.1.count": 10**6}, "1000000 values do not lie"),
    ({"accessors.0.count": 0}, "0 values do not lie"),
    ({"accessors.0.count": -3}, "the count '-3' is no size"),
    ({"accessors.0.count": 1e300}, "the count '1e.300' is no size"),
    ({"accessors.0.count": True}, "the count 'True' is no size"),
    ({"accessors.0.type": "MAT4"}, "values that are sparse, compressed, matrices"),
    ({"accessors.0.sparse": {}}, "values that are sparse"),
    ({"accessors.1.bufferView": 0}, "the indices of a part of a mesh are none of its 3 points"),
    ({"accessors.1.componentType": 5126, "accessors.1.bufferView": 0}, "the indices of a part"),
    ({"accessors.0.type": "VEC2"}, "points have three coordinates"),
    ({"bufferViews.0.byteOffset": 10**6}, "do not lie within"),
    ({"bufferViews.0.byteStride": 4}, "do not lie within"),
    ({"bufferViews.0.byteLength": "36"}, "the byteLength '36' is no size"),
    ({"buffers.0.uri": "data:;base64,AAAA"}, "do not lie within"),
    ({"buffers.0.uri": "data:;base64,*"}, "the buffer 0 is damaged"),
    ({"buffers.0.uri": "../b.bin"}, "a file in the same folder is needed"),
    ({"buffers.0.uri": "gone.bin"}, "gone.bin with a buffer is missing"),
    ({"buffers.0.uri": None}, "the buffer 0 is missing"),
    ({"nodes.1.children": [0]}, "the nodes are no tree"),
    ({"nodes.0.children": [7]}, "'7' is none of its 3 nodes"),
    ({"nodes.1.mesh": 5}, "'5' is none of its 1 meshes"),
    ({"nodes.2.matrix": [1]}, "the matrix is not 16 finite numbers"),
    ({"nodes.1.scale": ["a", 1, 1]}, "the scale is not 3 finite numbers"),
    ({"nodes.1.rotation": [10**400, 1, 1, 1]}, "the rotation is not 4 finite numbers"),
    ({"meshes.0.primitives.0.attributes": []}, "has no attributes"),
    ({"meshes.0.primitives.0.attributes": {}}, "'None' is none of its 2 accessors"),
    ({"scene": 3}, "'3' is none of its 1 scenes"),
    ({"scenes": 3}, "the scenes are no list"),
    ({"asset.version": "1.0"}, "no glTF file of version 2"),
    ({"extensionsRequired": ["KHR_draco_mesh_compression"]}, "the file requires extensions: .'KHR_draco_mesh_compression'"),
    ({"meshes.0.primitives.0.mode": 0}, "the scene has no triangles"),
]


@pytest.mark.parametrize("changes, words", BAD_GLTF, ids=lambda value: str(value)[:50])
def test_malformed_gltf(changes, words, tmp_path, capfd):
    """At several of them vtkGLTFReader ends the process."""
    (tmp_path / "t.gltf").write_text(gltf(**changes))
    with pytest.raises(FormatError, match=words):
        read_mesh(tmp_path / "t.gltf")
    assert capfd.readouterr() == ("", "")


def test_gltf_that_repeats_its_meshes_too_often(tmp_path, monkeypatch):
    text = gltf(**{"scenes.0.nodes": list(range(1000)), "nodes": 1000 * [{"mesh": 0}]})
    assert read_text(tmp_path, "t.gltf", text).GetNumberOfBlocks() == 1000
    monkeypatch.setattr("surfacesynthesis.files.gltf._MOST_POINTS", -len(text) + 2000)
    with pytest.raises(FormatError, match="repeats its meshes so often"):
        read_text(tmp_path, "t.gltf", text)


def test_malformed_glb(sphere, tmp_path):
    write_mesh(sphere, tmp_path / "s.glb")
    data = (tmp_path / "s.glb").read_bytes()
    long = data[:12] + b"\xff\xff\xff\x7f" + data[16:]
    for bad in (data[:-1], data[:20], data[:4], long, data[:20] + b"[" * 10**5, b"[" * 10**5):
        with pytest.raises(FormatError, match="t.glb: .*(cut off|no glTF file)"):
            read_text(tmp_path, "t.glb", bad)
    generator = np.random.default_rng(5)
    for _ in range(200):
        changed = bytearray(data)
        for place in generator.integers(0, 1500, 3):
            changed[place] = generator.integers(256)
        with contextlib.suppress(FormatError):
            read_text(tmp_path, "t.glb", bytes(changed))


def test_every_truncation_of_every_format_is_an_error_or_a_smaller_mesh(quads, tmp_path, capfd):
    """Cuts files at every few bytes: never a crash, never another exception, never points that are not in the file."""
    known = {tuple(point) for point in np.round(points_of(quads), 5)}
    for kind in (".stl", ".ply", ".off", ".obj"):
        write_mesh(quads, tmp_path / f"whole{kind}")
        data = (tmp_path / f"whole{kind}").read_bytes()
        failed = 0
        for size in range(0, len(data) - 1, 3):
            try:
                mesh = read_text(tmp_path, f"part{kind}", data[:size])
            except FormatError:
                failed += 1
                continue
            assert mesh.GetNumberOfPolys() <= quads.GetNumberOfPolys() + 6
            if kind != ".obj":  # the last number of a cut OBJ file may be shorter
                assert {tuple(point) for point in np.round(points_of(mesh), 5)} <= known
        assert failed > 0.4 * len(data) / 3 or kind == ".obj", (kind, failed)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("kind", SURFACE_FORMATS + (".vtm",))
def test_random_bytes_are_an_error(kind, tmp_path, capfd):
    data = np.random.default_rng(0).integers(0, 256, 3000, dtype=np.uint8).tobytes()
    with pytest.raises(FormatError, match=f"r{kind}"):
        read_text(tmp_path, f"r{kind}", data)
    assert capfd.readouterr() == ("", "")


def test_vtk_files_that_end_too_early_are_an_error(sphere, tmp_path, capfd):
    for kind in (".vtp", ".vtk"):
        write_mesh(sphere, tmp_path / f"whole{kind}")
        data = (tmp_path / f"whole{kind}").read_bytes()
        for share in (0.2, 0.5, 0.9):
            with pytest.raises(FormatError, match=f"part{kind}"):
                read_text(tmp_path, f"part{kind}", data[: int(share * len(data))])
    assert capfd.readouterr() == ("", "")


POLYDATA = (
    '<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian"><PolyData><Piece NumberOfPoints="{points}" '
    'NumberOfPolys="{polys}"><PointData><DataArray type="Float32" Name="a" NumberOfComponents="{components}" '
    'format="ascii">0</DataArray></PointData><Points><DataArray type="Float32" NumberOfComponents="3" format="ascii">'
    "0 0 0</DataArray></Points></Piece></PolyData></VTKFile>"
)


def blocks_of(inner):
    return (
        '<VTKFile type="vtkMultiBlockDataSet" version="1.0" byte_order="LittleEndian">'
        f"<vtkMultiBlockDataSet>{inner}</vtkMultiBlockDataSet></VTKFile>"
    )


@pytest.mark.parametrize(
    "name, text, words",
    [
        ("t.vtp", POLYDATA.format(points=10**12, polys=0, components=1), "NumberOfPoints is 1000000000000"),
        ("t.vtp", POLYDATA.format(points=1, polys=10**12, components=1), "NumberOfPolys is 1000000000000"),
        ("t.vtp", POLYDATA.format(points=-1, polys=0, components=1), "NumberOfPoints is -1"),
        ("t.vtp", POLYDATA.format(points="1e3", polys=0, components=1), "'1e3', which is no integer"),
        ("t.vtp", POLYDATA.format(points="9" * 400, polys=0, components=1), "which is no integer"),
        ("t.vtp", POLYDATA.format(points=10**6, polys=0, components=10**6), "NumberOfComponents is 1000000"),
        ("t.vtp", '<!DOCTYPE x [<!ENTITY a "b">]>' + POLYDATA.format(points=1, polys=0, components=1), "document type"),
        ("t.vtm", blocks_of('<DataSet index="-1" file="a.vtp"/>'), "index of a block is -1"),
        ("t.vtm", blocks_of('<DataSet index="2000000000" file="a.vtp"/>'), "index of a block is 2000000000"),
        ("t.vtm", blocks_of(20000 * '<Block index="0">' + 20000 * "</Block>"), "more than 100 blocks"),
    ],
    ids=lambda value: value if len(value) < 60 else "file",
)
def test_vtk_files_that_announce_what_they_cannot_hold_are_an_error(name, text, words, tmp_path):
    """VTK's own readers end the process, or take minutes."""
    with pytest.raises(FormatError) as caught:
        read_text(tmp_path, name, text)
    assert words in str(caught.value) and name in str(caught.value)


def test_pieces_of_a_composite_dataset_are_checked_too(tmp_path):
    (tmp_path / "piece.vtp").write_text(POLYDATA.format(points=10**12, polys=0, components=1))
    with pytest.raises(FormatError, match="piece.vtp: NumberOfPoints is 1000000000000"):
        read_text(tmp_path, "t.vtm", blocks_of('<DataSet index="0" file="piece.vtp"/>'))


def test_pipes_and_devices_are_not_waited_for(tmp_path):
    for kind in (".ply", ".vtp", ".stl"):
        os.mkfifo(tmp_path / f"pipe{kind}")
        with pytest.raises(FormatError, match="no regular file"):
            read_mesh(tmp_path / f"pipe{kind}")
    os.symlink("/dev/zero", tmp_path / "zero.off")
    with pytest.raises(FormatError, match="no regular file"):
        read_mesh(tmp_path / "zero.off")


def test_a_dataset_that_is_no_surface_is_an_error(tmp_path):
    text = "# vtk DataFile Version 3.0\nx\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 2\nORIGIN 0 0 0\nSPACING 1 1 1\n"
    with pytest.raises(FormatError, match="expected vtkPolyData"):
        read_text(tmp_path, "image.vtk", text)


def test_missing_and_unknown_files(tmp_path, sphere):
    with pytest.raises(FileNotFoundError):
        read_mesh(tmp_path / "none.stl")
    with pytest.raises(IsADirectoryError):
        (tmp_path / "folder.stl").mkdir()
        read_mesh(tmp_path / "folder.stl")
    with pytest.raises(ValueError, match="'.xyz' is not known; use one of .gii, .glb, .gltf"):
        read_mesh(tmp_path / "points.xyz")
    with pytest.raises(ValueError, match="'' is not known"):
        write_mesh(sphere, tmp_path / "noextension")


# -- writing that fails ------------------------------------------------------------------------------------------------


def test_unwritable_places(sphere, tmp_path):
    with pytest.raises(FileNotFoundError, match="does not exist"):
        write_mesh(sphere, tmp_path / "no folder" / "s.vtp")
    (tmp_path / "a.vtp").mkdir()
    with pytest.raises(IsADirectoryError, match="is not a file"):
        write_mesh(sphere, tmp_path / "a.vtp")
    with pytest.raises(OSError):
        write_mesh(sphere, "/proc/s.vtp")
    blocks = vtkMultiBlockDataSet()
    with pytest.raises(ValueError, match="composite dataset can be written to .vtm, .vtk, .glb or .gltf only"):
        write_mesh(blocks, tmp_path / "s.stl")
    with pytest.raises(ValueError, match="use .vtp"):
        write_mesh(sphere, tmp_path / "s.vtm")
    assert files_in(tmp_path) == []


@pytest.mark.parametrize("kind", SURFACE_FORMATS + (".vtm",))
def test_full_disk_leaves_the_old_file_and_nothing_else(kind, tmp_path):
    """Files may grow to 4 kB only, in a process of its own."""
    code = (
        "import sys, resource; sys.path.insert(0, sys.argv[2]); from conftest import *\n"
        "from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet\n"
        "import surfacesynthesis as s; mesh = polydata_of(*icosphere(4))\n"
        "if sys.argv[1].endswith('.vtm'):\n    b = vtkMultiBlockDataSet(); b.SetBlock(0, mesh); mesh = b\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))\n"
        "try:\n    s.write_mesh(mesh, sys.argv[1])\nexcept (OSError, s.SurfaceSynthesisError) as e:\n    print('failed:', e)"
    )
    path = tmp_path / f"s{kind}"
    path.write_text("old")
    done = subprocess.run(
        [sys.executable, "-c", code, str(path), os.path.dirname(__file__)], capture_output=True, text=True, check=False,
        timeout=120,
    )  # fmt: skip
    assert done.returncode == 0
    assert done.stdout == f"failed: [Errno {errno.EFBIG}] {os.strerror(errno.EFBIG)}: {str(path)!r}\n"
    assert done.stderr == ""
    assert files_in(tmp_path) == [path.name]
    assert path.read_text() == "old"


def test_new_files_follow_the_umask(sphere, tmp_path):
    previous = os.umask(0o027)
    try:
        write_mesh(sphere, tmp_path / "s.ply")
    finally:
        os.umask(previous)
    assert (tmp_path / "s.ply").stat().st_mode & 0o777 == 0o640


def test_a_link_stays_a_link(sphere, tmp_path):
    (tmp_path / "real").mkdir()
    (tmp_path / "s.off").symlink_to(tmp_path / "real" / "s.off")
    write_mesh(sphere, tmp_path / "s.off")
    assert (tmp_path / "s.off").is_symlink() and (tmp_path / "real" / "s.off").is_file()


def test_vertices_and_lines_are_left_out_of_surface_formats(sphere, tmp_path):
    mesh = vtkPolyData()
    mesh.ShallowCopy(sphere)
    lines = vtkCellArray()
    lines.InsertNextCell(2)
    lines.InsertCellPoint(0)
    lines.InsertCellPoint(1)
    mesh.SetLines(lines)
    write_mesh(mesh, tmp_path / "s.off")
    assert read_mesh(tmp_path / "s.off").GetNumberOfCells() == sphere.GetNumberOfCells()


def test_errors_carry_one_text_per_message():
    error = SurfaceSynthesisError("first", "second")
    assert error.messages == ["first", "second"] and str(error) == "first\nsecond"
