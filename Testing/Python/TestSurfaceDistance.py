# SPDX-License-Identifier: BSD-3-Clause
"""surface_distance() and the command ``distance``."""

import json

import numpy as np
import pytest
from conftest import icosphere, polydata_of, run_command
from vtkmodules.vtkCommonDataModel import vtkPolyData

from surfacesynthesis import Cancelled, SurfaceSynthesisError, read_mesh, surface_distance, write_mesh

POINTS, TRIANGLES = icosphere(3)


def square(height, length=1.0):
    points = np.array([[0, 0, height], [length, 0, height], [length, 1, height], [0, 1, height]], dtype=float)
    return points, np.array([[0, 1, 2], [0, 2, 3]])


def test_squares_by_hand():
    found = surface_distance(square(0.0), square(0.0, 2.0))
    assert found.first_to_second["maximum"] < 1e-12
    assert found.second_to_first["maximum"] == pytest.approx(1.0)
    assert found.second_to_first["mean"] == pytest.approx(0.25, abs=1e-4)
    assert found["mean"] == pytest.approx(0.125, abs=1e-4) and found["maximum"] == pytest.approx(1.0)
    assert found.surface.GetPointData().HasArray("Distance")
    parallel = surface_distance(square(0.0), square(0.5), samples=100, seed=3)
    assert all(value == pytest.approx(0.5) for value in parallel.values())


def test_results_show_themselves():
    found = surface_distance((POINTS, TRIANGLES), (1.5 * POINTS, TRIANGLES), samples=1000)
    assert "second to first" in str(found) and repr(found).startswith("<SurfaceDistance: mean 0.49")
    assert found._repr_html_().count("<tr>") == 4 and len(found.to_csv().splitlines()) == 4
    assert json.loads(found.to_json())["both"]["maximum"] == found["maximum"]
    assert str(surface_distance(vtkPolyData(), vtkPolyData())) == "empty"


def test_wrong_arguments_have_words():
    with pytest.raises(SurfaceSynthesisError, match="second surface is empty"):
        surface_distance(square(0.0), vtkPolyData())
    with pytest.raises(TypeError, match="vtkPolyData or a pair"):
        surface_distance(square(0.0), 3)
    with pytest.raises(ValueError, match="samples"):
        surface_distance(square(0.0), square(1.0), samples=0)
    with pytest.raises(Cancelled):
        surface_distance(square(0.0), square(1.0), progress=lambda fraction: False)


def test_command(tmp_path):
    first, second, output = (str(tmp_path / name) for name in ("first.stl", "second.ply", "out.vtp"))
    write_mesh(polydata_of(POINTS, TRIANGLES), first)
    write_mesh(polydata_of(POINTS + [0.0, 0.0, 0.1], TRIANGLES), second)
    done = run_command("distance", first, second, "--json", "--output", output)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["both"]["maximum"] == pytest.approx(0.1, rel=0.05)
    assert read_mesh(output).GetPointData().HasArray("Distance")
    done = run_command("distance", first, second, "--csv")
    assert done.stdout.splitlines()[0] == "direction,mean,rms,percentile_95,maximum"
    assert "world units" in run_command("distance", first, second).stdout
    assert run_command("distance", first, "missing.stl").returncode == 1
