# SPDX-License-Identifier: BSD-3-Clause
"""surfacesynthesis.topology_report() and tetrahedralize(), and their commands."""

import csv
import io
import re

import numpy as np
import pytest
import surfacesynthesis
from conftest import add_array, files_in, icosphere, polydata_of, run_command
from surfacesynthesis import Cancelled, SurfaceSynthesisError, topology_report, write_mesh
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet, vtkPolyData, vtkUnstructuredGrid
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

tetrahedralize = getattr(surfacesynthesis, "tetrahedralize", None)
needs_tetgen = pytest.mark.skipif(tetrahedralize is None, reason="built without TetGen")


def volumes(points, tetrahedra):
    a, b, c, d = (points[tetrahedra[:, k]] for k in range(4))
    return np.einsum("tx,tx->t", np.cross(b - a, c - a), d - a) / 6.0


# -- the report --------------------------------------------------------------------------------------------------------


def test_report_of_a_sphere(pair):
    report = topology_report(pair)
    assert report.valid is True
    assert report["points"] == 642 and isinstance(report["points"], int)
    assert report["genus"] == 0
    assert report["closed"] is True
    assert report["volume"] == pytest.approx(4.15274, abs=1e-4)
    assert report.defects == {}
    assert report.components == []
    assert "nonesuch" not in report
    assert re.search(r"^genus +0$", str(report), re.MULTILINE)
    assert "boundary edges" not in str(report), "what is not wrong is not shown"
    assert "valid, 1280 triangles" in repr(report)


def test_report_names_defects_first_ids_and_repairs(pair):
    points, triangles = pair
    broken = np.vstack([triangles, [[0, 0, 1], [0, 1, 9999]], triangles[:1]])
    report = topology_report((points, broken))
    assert not report.valid
    assert report.defects["cells_with_repeated_points"] == 1
    assert report.first("cells_with_repeated_points") == len(triangles)
    assert report.first("cells_with_missing_points") == len(triangles) + 1
    assert report.first("genus" if "genus" in report else "points") is None
    assert report["duplicate_triangles"] == 1
    assert "vtkCleanPolyData" in report.remark("cells_with_repeated_points")
    assert "vtkCleanPolyData" in str(report)


def test_report_of_an_open_surface_has_no_volume(pair):
    report = topology_report((pair[0], pair[1][:-1]))
    assert report.valid and not report["closed"]
    assert report.get("volume") is None
    assert report["boundary_loops"] == 1


def test_report_of_components_and_blocks(sphere):
    points, triangles = icosphere(1)
    two = np.vstack([points, points + 5.0])
    report = topology_report((two, np.vstack([triangles, triangles + len(points)])))
    assert [component["triangles"] for component in report.components] == [80, 80]
    assert "component 1: 42 points, 80 triangles, genus 0, volume" in str(report)
    composite = vtkMultiBlockDataSet()
    composite.SetBlock(0, sphere)
    composite.SetBlock(2, polydata_of(points, triangles[:-1]))
    reports = topology_report(composite)
    assert list(reports) == [1, 3]
    assert reports.valid and reports[1]["closed"] and not reports[3]["closed"]
    assert "block 3" in str(reports)
    assert topology_report(composite, component_rows=0)[1].components == []


def test_report_of_nothing():
    report = topology_report(vtkPolyData())
    assert len(report) == 0 and not report.valid and str(report) == "empty"


def test_report_checks_its_arguments(pair):
    with pytest.raises(TypeError, match="mesh must be"):
        topology_report(vtkUnstructuredGrid())
    with pytest.raises(ValueError, match="component_rows"):
        topology_report(pair, component_rows=-1)
    with pytest.raises(TypeError, match="progress"):
        topology_report(pair, progress=3)
    with pytest.raises(Cancelled):
        topology_report(pair, progress=lambda fraction: False)


def test_report_command_prints_a_table_or_csv_and_tells_by_its_status(pair, tmp_path):
    valid, broken = tmp_path / "valid.off", tmp_path / "broken.vtp"
    write_mesh(polydata_of(*pair), valid)
    write_mesh(polydata_of(pair[0], np.vstack([pair[1], [[3, 3, 4]]])), broken)
    done = run_command("report", valid)
    assert (done.returncode, done.stderr) == (0, "")
    assert re.search(r"^triangles +1,280$", done.stdout, re.MULTILINE)
    table = run_command("report", broken).stdout
    assert "the command repair" in table and "vtkSurfaceRepairFilter" not in table
    done = run_command("report", broken, "--csv")
    assert (done.returncode, done.stderr) == (3, "")
    rows = list(csv.DictReader(io.StringIO(done.stdout)))
    found = [row for row in rows if row["property"] == "cells_with_repeated_points"]
    assert [(row["value"], row["first"]) for row in found] == [("1", "1280")]
    assert {row["property"]: row["value"] for row in rows}["valid"] == "0"
    assert run_command("report", tmp_path / "absent.stl").returncode == 1
    assert run_command("report", valid, "--component-rows", "-2").returncode == 2
    assert "exit status: 0" in run_command("report", "--help").stdout


# -- tetrahedra --------------------------------------------------------------------------------------------------------


@needs_tetgen
def test_pair_gives_a_pair(pair):
    points, tetrahedra = tetrahedralize(pair)
    assert points.dtype == np.float64 and tetrahedra.dtype == np.int64
    assert np.array_equal(points[: len(pair[0])], pair[0])
    assert volumes(points, tetrahedra).min() > 0
    assert volumes(points, tetrahedra).sum() == pytest.approx(topology_report(pair)["volume"], rel=1e-12)
    finer = tetrahedralize(pair, edge_length=0.1)[1]
    assert len(finer) > 2 * len(tetrahedra)
    assert tetrahedralize((np.zeros((0, 3)), np.zeros((0, 3), dtype=int)))[1].shape == (0, 4)


@needs_tetgen
def test_dataset_gives_a_grid_with_its_arrays(sphere):
    grid = tetrahedralize(sphere, surface_triangles=True, region_name="Part", surface_name="Skin")
    assert isinstance(grid, vtkUnstructuredGrid)
    height = vtk_to_numpy(grid.GetPointData().GetArray("height"))
    assert np.array_equal(height[:642], vtk_to_numpy(sphere.GetPointData().GetArray("height")))
    assert grid.GetCellData().GetArray("number") and grid.GetCellData().GetArray("Part")
    assert vtk_to_numpy(grid.GetPointData().GetArray("Skin")).sum() == 642


@needs_tetgen
def test_inner_surfaces_are_regions_or_holes(pair):
    points, triangles = pair
    nested = (np.vstack([points, 0.5 * points]), np.vstack([triangles, triangles + len(points)]))
    filled = volumes(*tetrahedralize(nested)).sum()
    hollow = volumes(*tetrahedralize(nested, inner_surfaces="holes")).sum()
    assert hollow / filled == pytest.approx(0.875, rel=1e-12)


@needs_tetgen
def test_errors_are_exceptions(pair):
    points, triangles = pair
    crossing = (np.vstack([points, points + [0.5, 0, 0]]), np.vstack([triangles, triangles + len(points)]))
    with pytest.raises(SurfaceSynthesisError, match="intersects or touches itself.*vtkVDBSurfaceFilter"):
        tetrahedralize(crossing)
    with pytest.raises(SurfaceSynthesisError, match="boundary edge"):
        tetrahedralize((points, triangles[:-1]))
    with pytest.raises(SurfaceSynthesisError, match="TimeLimit of 0.2 s"):
        tetrahedralize(pair, maximum_volume=1e-8, maximum_tetrahedra=2**31 - 1, time_limit=0.2)
    with pytest.raises(Cancelled):
        tetrahedralize(pair, maximum_volume=1e-8, maximum_tetrahedra=2**31 - 1, progress=lambda fraction: fraction < 0.02)


@needs_tetgen
@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        ({"quality_ratio": 0.5}, "quality_ratio"),
        ({"minimum_dihedral_angle": 70}, "minimum_dihedral_angle"),
        ({"maximum_volume": 0}, "maximum_volume"),
        ({"edge_length": -1}, "edge_length"),
        ({"time_limit": 0}, "time_limit"),
        ({"memory_limit": 0}, "memory_limit"),
        ({"inner_surfaces": "cavities"}, "inner_surfaces"),
        ({"region_name": ""}, "region_name"),
        ({"surface_triangles": True}, "surface_triangles"),
    ],
)
def test_wrong_arguments(pair, arguments, error):
    with pytest.raises(ValueError, match=error):
        tetrahedralize(pair, **arguments)


@needs_tetgen
@pytest.mark.parametrize("kind", [".vtu", ".vtk"])
def test_command_writes_a_grid(pair, tmp_path, kind):
    write_mesh(polydata_of(*pair), tmp_path / "in.off")
    output = tmp_path / f"out{kind}"
    done = run_command("tetrahedralize", tmp_path / "in.off", output, "--edge-length", "0.3")
    assert (done.returncode, done.stderr) == (0, ""), done
    found = re.fullmatch(r"([\d,]+) points, ([\d,]+) cells, \S+ s -> \S+\n", done.stdout)
    assert found, done.stdout
    assert files_in(tmp_path) == ["in.off", f"out{kind}"]
    if kind == ".vtu":
        reader = vtkXMLUnstructuredGridReader()
        reader.SetFileName(str(output))
        reader.Update()
        assert reader.GetOutput().GetNumberOfCells() == int(found[2].replace(",", ""))


@needs_tetgen
def test_command_takes_composite_datasets(pair, tmp_path):
    composite = vtkMultiBlockDataSet()
    composite.SetBlock(0, polydata_of(*pair))
    write_mesh(composite, tmp_path / "in.vtm")
    assert run_command("tetrahedralize", tmp_path / "in.vtm", tmp_path / "out.vtm").returncode == 0
    done = run_command("tetrahedralize", tmp_path / "in.vtm", tmp_path / "out.vtu")
    assert done.returncode == 2 and ".vtm" in done.stderr


@needs_tetgen
def test_command_explains_what_is_wrong(pair, tmp_path):
    write_mesh(polydata_of(pair[0], pair[1][:-1]), tmp_path / "open.off")
    done = run_command("tetrahedralize", tmp_path / "open.off", tmp_path / "out.vtu")
    assert done.returncode == 1 and "boundary edge" in done.stderr
    done = run_command("tetrahedralize", tmp_path / "open.off", tmp_path / "out.stl")
    assert done.returncode == 2 and ".vtu" in done.stderr
    assert files_in(tmp_path) == ["open.off"]
