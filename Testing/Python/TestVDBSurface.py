# SPDX-License-Identifier: BSD-3-Clause
"""vdb_surface(), its accessor's methods, the command ``surface``, and .vtu files."""

import gzip
import textwrap

import numpy as np
import pytest
from conftest import add_array, files_in, icosphere, polydata_of, run_command
from TestVolumes import nifti
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import VTK_TETRA, vtkImageData, vtkMultiBlockDataSet, vtkPolyData, vtkUnstructuredGrid

import surfacesynthesis
from surfacesynthesis import Cancelled, SurfaceSynthesisError, SurfaceSynthesisWarning, vdb_surface

BALL = 4 / 3 * np.pi


def ball_image(side=24, radius=9.0):
    image = vtkImageData()
    image.SetDimensions(side, side, side)
    axis = np.arange(side) - 0.5 * (side - 1)
    z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
    scalars = numpy_to_vtk((radius - np.sqrt(x**2 + y**2 + z**2)).ravel(), deep=True)
    scalars.SetName("Distance")
    image.GetPointData().SetScalars(scalars)
    return image


def volume_of(points, triangles):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.einsum("fx,fx->", a, np.cross(b, c)) / 6


def arrays_of(surface):
    points = vtk_to_numpy(surface.GetPoints().GetData())
    return points, vtk_to_numpy(surface.GetPolys().GetConnectivityArray()).reshape(-1, 3)


def edges_of(triangles):
    """Directed edges, and the number of uses of each."""
    edges = np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    return np.unique(edges, axis=0, return_counts=True)


def assert_closed(triangles):
    edges, counts = edges_of(triangles)
    assert (counts == 1).all(), "manifold and consistently wound"
    opposite, _ = edges_of(triangles[:, ::-1])
    assert (edges == opposite).all(), "closed"


def test_images_and_pairs_give_closed_surfaces(pair):
    surface = vdb_surface(ball_image(), iso_value=0.0)
    assert type(surface) is vtkPolyData
    points, triangles = arrays_of(surface)
    assert_closed(triangles)
    assert volume_of(points, triangles) == pytest.approx(BALL * 9**3, rel=0.02)
    points, triangles = vdb_surface(pair, voxel_size=0.1)
    assert points.dtype == np.float64 and points.shape[1] == 3
    assert_closed(triangles)
    assert volume_of(points, triangles) == pytest.approx(BALL, rel=0.05)


def test_every_argument_reaches_the_filter():
    from surfacesynthesis.vdb_surface import configured_filter

    made = configured_filter(
        iso_value=2.5, inside="below", voxel_size=0.5, closing=1.5, smoothing="median", smoothing_iterations=7, offset=-2,
        adaptivity=0.25, fill_cavities=True, largest_component=True, maximum_voxels=5000, array="Distance",
    )  # fmt: skip
    found = {name: getattr(made, "Get" + name)() for name in (
        "ComputeIsoValue", "IsoValue", "InsideRule", "VoxelSize", "Closing", "Smoothing", "SmoothingIterations", "Offset",
        "Adaptivity", "FillCavities", "LargestComponent", "MaximumNumberOfVoxels")}  # fmt: skip
    assert found == {
        "ComputeIsoValue": False, "IsoValue": 2.5, "InsideRule": 1, "VoxelSize": 0.5, "Closing": 1.5, "Smoothing": 3,
        "SmoothingIterations": 7, "Offset": -2.0, "Adaptivity": 0.25, "FillCavities": True, "LargestComponent": True,
        "MaximumNumberOfVoxels": 5000,
    }  # fmt: skip


@pytest.mark.parametrize("arguments, error, text", [
    ({"iso_value": np.inf}, ValueError, "iso_value must be a finite number"),
    ({"iso_value": "bone"}, TypeError, "iso_value must be a number"),
    ({"inside": "left"}, ValueError, "unknown inside 'left'; choose one of above, below"),
    ({"voxel_size": 0}, ValueError, "voxel_size must be a finite number larger than 0"),
    ({"closing": -1}, ValueError, "closing must be at least 0"),
    ({"smoothing": "sand"}, ValueError, "unknown smoothing 'sand'"),
    ({"smoothing_iterations": 1001}, ValueError, "smoothing_iterations must be at most 1000"),
    ({"offset": np.nan}, ValueError, "offset must be a finite number"),
    ({"adaptivity": 1.5}, ValueError, "adaptivity must be at most 1"),
    ({"fill_cavities": 1}, TypeError, "fill_cavities must be True or False"),
    ({"maximum_voxels": 10}, ValueError, "maximum_voxels must be from 1000"),
    ({"array": ""}, ValueError, "array must be the name of an array"),
])  # fmt: skip
def test_wrong_arguments_are_named(arguments, error, text):
    with pytest.raises(error, match=text):
        vdb_surface(ball_image(), **arguments)


def test_errors_warnings_and_cancellation(pair):
    with pytest.raises(TypeError, match="must be a vtkImageData, a vtkPolyData"):
        vdb_surface(vtkUnstructuredGrid())
    with pytest.raises(SurfaceSynthesisError, match="no such array of numbers"):
        vdb_surface(ball_image(), array="Gone")
    with pytest.raises(SurfaceSynthesisError, match="isovalue 100 lies outside the values of the image, which go from"):
        vdb_surface(ball_image(), iso_value=100.0)
    with pytest.raises(ValueError, match="iso_value is a value of a volume, and the input is a surface"):
        vdb_surface(pair, iso_value=0.5)
    labels = ball_image()
    values = vtk_to_numpy(labels.GetPointData().GetScalars())
    add_array(labels.GetPointData(), "Labels", np.digitize(values, [0.0, 2.0]).astype(np.uint8))
    with pytest.warns(SurfaceSynthesisWarning, match="The image holds 3 distinct integers from 0 to 2, as label images"):
        vdb_surface(labels, array="Labels")
    with pytest.raises(SurfaceSynthesisError, match="A VoxelSize of .* fits"):
        vdb_surface(pair, voxel_size=1e-6)
    for size in (1e30, 2.5):
        with pytest.raises(SurfaceSynthesisError, match="larger than the surface, which spans a box of longest side"):
            vdb_surface(pair, voxel_size=size)
    with pytest.raises(SurfaceSynthesisError, match="larger than the surface, which spans a box of longest side"):
        vdb_surface(ball_image(), voxel_size=1e3)
    with pytest.raises(Cancelled):
        vdb_surface(ball_image(), progress=lambda fraction: False)


def test_composite_datasets_are_processed_block_by_block(sphere):
    blocks = vtkMultiBlockDataSet()
    blocks.SetBlock(0, sphere)
    blocks.SetBlock(1, ball_image())
    surface = vdb_surface(blocks)
    assert type(surface) is vtkMultiBlockDataSet
    assert surface.GetBlock(0).GetPointData().GetArray("height").GetNumberOfTuples() > 642
    assert surface.GetBlock(1).GetNumberOfPolys() > 0


def test_accessor_works_on_surfaces_and_images(pair, tmp_path):
    from TestAccessor import REGISTRY, STAND_IN, USE, run

    code = """
    from vtkmodules.vtkCommonDataModel import vtkPolyData
    from TestVDBSurface import ball_image
    closed = pyvista.PolyData(plain).synthesis.vdb_surface(voxel_size=0.1)
    assert isinstance(closed, pyvista.PolyData) and closed.GetNumberOfPolys() > 0
    image = pyvista.ImageData()
    image.ShallowCopy(ball_image())
    assert image.synthesis.vdb_surface(iso_value=0.0).GetNumberOfPolys() > 0
    """
    images = "from vtkmodules.vtkCommonDataModel import vtkImageData\nclass ImageData(vtkImageData):\n    pass\n"
    run(tmp_path, STAND_IN + images + REGISTRY, USE + textwrap.dedent(code))


def test_command_from_volume_to_surface(tmp_path):
    scalars = vtk_to_numpy(ball_image().GetPointData().GetScalars()).reshape(24, 24, 24)
    sform = [[2.0, 0, 0, -23], [0, 2.0, 0, -23], [0, 0, 2.0, -23]]
    (tmp_path / "ball.nii.gz").write_bytes(gzip.compress(nifti(scalars, code=64, sform=sform)))
    done = run_command("surface", tmp_path / "ball.nii.gz", tmp_path / "ball.vtp", "--iso-value", 0, "--no-progress")
    assert done.returncode == 0 and done.stderr == "", done
    assert "isovalue 0" in done.stdout
    surface = surfacesynthesis.read_mesh(tmp_path / "ball.vtp")
    radii = np.linalg.norm(vtk_to_numpy(surface.GetPoints().GetData()), axis=1)
    assert radii.max() < 18.1 and radii.min() > 17.7
    done = run_command("surface", tmp_path / "ball.vtp", tmp_path / "closed.stl", "--voxel-size", 2, "--closing", 3,
                       "--smoothing", "mean_curvature", "--smoothing-iterations", 1,
                       "--largest-component", "--fill-cavities", "--offset", 1,
                       "--adaptivity", 0.1, "--threads", 1, "--quiet")  # fmt: skip
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert files_in(tmp_path) == ["ball.nii.gz", "ball.vtp", "closed.stl"]


@pytest.mark.parametrize("arguments, status, text", [
    (["in.txt", "out.vtp"], 2, "or for volumes .nii, .nii.gz"),
    (["in.nii", "out.png"], 2, "the extension '.png' is not known"),
    (["gone.nii", "out.vtp"], 1, "No such file"),
    (["bad.nii", "out.vtp"], 1, "this is no NIfTI file"),
    (["bad.nii", "out.vtp", "--closing", "-1"], 2, "closing must be at least 0"),
    (["bad.nii", "out.vtp", "--smoothing", "sand"], 2, "invalid choice: 'sand'"),
])  # fmt: skip
def test_command_says_what_is_wrong(tmp_path, arguments, status, text):
    (tmp_path / "bad.nii").write_bytes(b"nothing")
    done = run_command("surface", *arguments, cwd=tmp_path)
    assert done.returncode == status and text in done.stderr and done.stderr.count("\n") == 1, done
    assert files_in(tmp_path) == ["bad.nii"]


def tetrahedron():
    grid = vtkUnstructuredGrid()
    points = vtkPoints()
    for point in ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)):
        points.InsertNextPoint(point)
    grid.SetPoints(points)
    grid.InsertNextCell(VTK_TETRA, 4, [0, 1, 2, 3])
    add_array(grid.GetCellData(), "region", np.array([7]))
    return grid


@pytest.mark.parametrize("suffix", [".vtu", ".vtk"])
def test_unstructured_grids_are_written_and_read(tmp_path, suffix):
    surfacesynthesis.write_mesh(tetrahedron(), tmp_path / ("mesh" + suffix))
    again = surfacesynthesis.read_mesh(tmp_path / ("mesh" + suffix))
    assert type(again) is vtkUnstructuredGrid
    assert again.GetNumberOfPoints() == 4 and again.GetCellType(0) == VTK_TETRA
    assert again.GetCellData().GetArray("region").GetValue(0) == 7
    data = (tmp_path / ("mesh" + suffix)).read_bytes()
    (tmp_path / ("cut" + suffix)).write_bytes(data[: len(data) // 2])
    with pytest.raises(surfacesynthesis.FormatError):
        surfacesynthesis.read_mesh(tmp_path / ("cut" + suffix))


def test_grids_and_surfaces_do_not_go_to_each_others_formats(tmp_path):
    with pytest.raises(ValueError, match="an unstructured grid can be written to .vtu or .vtk only"):
        surfacesynthesis.write_mesh(tetrahedron(), tmp_path / "mesh.stl")
    with pytest.raises(ValueError, match=".vtu is for unstructured grids; use .vtp"):
        surfacesynthesis.write_mesh(polydata_of(*icosphere(0)), tmp_path / "mesh.vtu")
    assert files_in(tmp_path) == []
