# SPDX-License-Identifier: BSD-3-Clause
"""remesh() and repair(), as functions and as commands."""

import numpy as np
import pytest
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkFiltersSources import vtkSphereSource

import surfacesynthesis
from surfacesynthesis import remesh, repair, repair_measures, repair_report
from surfacesynthesis.command_line import main

pytestmark = pytest.mark.skipif(
    not hasattr(surfacesynthesis, "vtkIsotropicRemeshFilter"), reason="built without CGAL"
)


@pytest.fixture
def ball():
    source = vtkSphereSource()
    source.SetThetaResolution(40)
    source.SetPhiResolution(40)
    source.Update()
    return source.GetOutput()


def edges_of(mesh):
    triangles = vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    points = vtk_to_numpy(mesh.GetPoints().GetData())
    return np.linalg.norm(points[triangles] - points[np.roll(triangles, -1, axis=1)], axis=2)


def test_remesh_gives_the_wanted_edge_length_and_leaves_the_input(ball):
    before = vtk_to_numpy(ball.GetPoints().GetData()).copy()
    result = remesh(ball, edge_length=0.05)
    assert 0.8 * 0.05 < np.median(edges_of(result)) < 4 / 3 * 0.05
    assert edges_of(result).max() < 0.08
    assert np.array_equal(before, vtk_to_numpy(ball.GetPoints().GetData()))


def test_remesh_takes_and_returns_pairs(ball):
    points = vtk_to_numpy(ball.GetPoints().GetData()).astype(np.float64)
    triangles = vtk_to_numpy(ball.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    new_points, new_triangles = remesh((points, triangles), points=800)
    assert new_points.dtype == np.float64 and new_points.shape[1] == 3
    assert len(new_points) == pytest.approx(800, rel=0.02)
    assert new_triangles.shape == (2 * len(new_points) - 4, 3)


@pytest.mark.parametrize(
    "parameters, text",
    [
        ({"edge_length": 0.0}, "edge_length must be a finite number larger than 0"),
        ({"edge_length": 1.0, "points": 10}, "edge_length and points exclude each other"),
        ({"points": 0}, "points must be from 1"),
        ({"feature_angle": 200.0}, "feature_angle must be from 0 to 180"),
        ({"iterations": 101}, "iterations must be at most 100"),
        ({"sizing": ""}, "sizing must be the name of an array"),
    ],
)
def test_remesh_refuses_wrong_values(ball, parameters, text):
    with pytest.raises(ValueError, match=text):
        remesh(ball, **parameters)


def test_remesh_names_the_defect_and_its_repair(ball):
    points = vtk_to_numpy(ball.GetPoints().GetData()).astype(np.float64)
    triangles = vtk_to_numpy(ball.GetPolys().GetConnectivityArray()).reshape(-1, 3).copy()
    triangles[5] = triangles[5, ::-1]
    with pytest.raises(surfacesynthesis.SurfaceSynthesisError, match="opposite senses.*vtkSurfaceRepairFilter"):
        remesh((points, triangles))
    new_points, new_triangles = repair((points, triangles))
    assert len(new_triangles) == len(triangles)
    remesh((new_points, new_triangles))


def test_repair_reports_what_it_did(ball):
    triangles = vtk_to_numpy(ball.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    points = vtk_to_numpy(ball.GetPoints().GetData()).astype(np.float64)
    broken = np.vstack([triangles[3:], triangles[10:12]])
    mesh = repair(surfacesynthesis.datasets.dataset_of_pair((points, broken)))
    assert repair_report(mesh) == {"duplicate triangles removed": 2, "holes closed": 1}
    assert repair_report(repair(mesh)) == {}
    with pytest.raises(ValueError, match="was not made by repair"):
        repair_report(ball)
    with pytest.raises(ValueError, match="was not made by repair"):
        repair_measures(ball)


def overlapping_balls():
    """Points and triangles of two coarse balls that intersect."""
    source = vtkSphereSource()
    source.SetThetaResolution(12)
    source.SetPhiResolution(12)
    source.Update()
    ball = source.GetOutput()
    points = vtk_to_numpy(ball.GetPoints().GetData()).astype(np.float64)
    triangles = vtk_to_numpy(ball.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    return np.vstack([points, points + [0.6, 0.01, 0.02]]), np.vstack([triangles, triangles + len(points)])


def test_repair_says_what_it_leaves_and_measures():
    mesh = surfacesynthesis.datasets.dataset_of_pair(overlapping_balls())
    with pytest.warns(surfacesynthesis.SurfaceSynthesisWarning, match="triangle.s. still intersect others"):
        result = repair(mesh, self_intersections=True, maximum_loss=0.0)
    measures = repair_measures(result)
    assert list(measures) == ["area", "volume", "components", "intersecting_triangles"]
    assert measures["area"][0] == measures["area"][1] and measures["components"] == (2, 2)
    assert measures["intersecting_triangles"][1] == surfacesynthesis.topology_report(result)["intersecting_triangles"] > 0
    with pytest.raises(surfacesynthesis.SurfaceSynthesisError, match="still intersect others"):
        repair(mesh, self_intersections=True, maximum_loss=0.0, strict=True)


def test_repair_command_says_what_is_left_in_its_own_words(tmp_path, capsys):
    source, result = str(tmp_path / "balls.off"), str(tmp_path / "result.off")
    surfacesynthesis.write_mesh(surfacesynthesis.datasets.dataset_of_pair(overlapping_balls()), source)
    assert main(["repair", source, result, "--self-intersections", "--maximum-loss", "0"]) == 0
    printed = capsys.readouterr()
    assert "lost: 0 % of the area, 0 % of the volume; left: " in printed.out and "intersecting triangles" in printed.out
    assert "still intersect others" in printed.err and "more than --maximum-loss" in printed.err
    assert main(["repair", source, str(tmp_path / "x.off"), "--self-intersections", "--maximum-loss", "0", "--strict"]) == 1
    assert "still intersect others" in capsys.readouterr().err and not (tmp_path / "x.off").exists()


@pytest.mark.parametrize(
    "parameters, error, text",
    [
        ({"holes": "some"}, ValueError, "unknown holes 'some'; choose one of none, small, all"),
        ({"holes": "all", "hole_size": 1.0}, ValueError, "hole_size goes with holes='small'"),
        ({"minimum_component": 2.0}, ValueError, "minimum_component must be from 0 to 1"),
        ({"maximum_loss": 1.5}, ValueError, "maximum_loss must be from 0 to 1"),
        ({"strict": 1}, TypeError, "strict must be True or False"),
        ({"merge_tolerance": -1.0}, ValueError, "merge_tolerance must be at least 0"),
        ({"merge_points": 1}, TypeError, "merge_points must be True or False"),
    ],
)
def test_repair_refuses_wrong_values(ball, parameters, error, text):
    with pytest.raises(error, match=text):
        repair(ball, **parameters)


def test_progress_can_stop_the_work(ball):
    with pytest.raises(surfacesynthesis.Cancelled):
        remesh(ball, progress=lambda _: False)


def test_commands_go_from_file_to_file(ball, tmp_path, capsys):
    source, valid, even = (str(tmp_path / name) for name in ("ball.stl", "valid.ply", "even.vtp"))
    surfacesynthesis.write_mesh(ball, source)
    assert main(["repair", source, valid]) == 0
    assert "the surface was valid" in capsys.readouterr().out
    assert main(["remesh", valid, even, "--points", "500"]) == 0
    assert "points" in capsys.readouterr().out
    assert surfacesynthesis.read_mesh(even).GetNumberOfPoints() == pytest.approx(500, rel=0.02)
    assert main(["remesh", valid, even, "--points", "500", "--edge-length", "1"]) == 2
    assert "exclude each other" in capsys.readouterr().err
