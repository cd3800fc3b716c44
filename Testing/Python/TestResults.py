# SPDX-License-Identifier: BSD-3-Clause
"""JSON texts of results and commands, and tables of results in notebooks."""

import json

import numpy as np
import pytest
from conftest import add_array, polydata_of, run_command

from surfacesynthesis import ensemble_metrics, estimate_matern, matern_noise, topology_report
from surfacesynthesis.files import write_mesh
from surfacesynthesis.report import BlockReports
from surfacesynthesis.results import html_table, json_text
from surfacesynthesis.signal_datasets import SignalDataset, SignalSource
from surfacesynthesis.texture_datasets import PlanarMesh, TextureDataset

NAN = float("nan")


def two_balls(pair):
    """Two separate spheres, one of them with a triangle less."""
    points, triangles = pair
    return np.vstack([points, points + [5, 0, 0]]), np.vstack([triangles, triangles[1:] + len(points)])


def test_json_texts_have_plain_values():
    text = json_text({"a": np.arange(2), "b": [np.float32(0.5), NAN, float("inf")], 3: (True, None), "c": np.array([[NAN]])})
    assert json.loads(text) == {"a": [0, 1], "b": [0.5, None, None], "3": [True, None], "c": [[None]]}


def test_html_tables_escape_texts():
    assert html_table([("<b>", 1234, True, 0.5)], ["&"]) == (
        "<table><tr><th>&amp;</th></tr><tr><td>&lt;b&gt;</td><td>1,234</td><td>yes</td><td>0.5</td></tr></table>"
    )


def test_report_has_the_same_values_in_json_and_in_a_table(pair):
    report = topology_report(two_balls(pair))
    stored = json.loads(report.to_json())
    assert stored["properties"] == dict(report) and len(stored["components"]) == 2
    assert stored["defects"]["boundary_edges"]["count"] == 3 and stored["defects"]["boundary_edges"]["first"] is not None
    shown = report._repr_html_()
    assert "<td>boundary edges</td><td>3</td>" in shown and "<td>component 1</td>" in shown
    blocks = BlockReports({2: report})
    assert json.loads(blocks.to_json())["blocks"]["2"] == stored and "block 2" in blocks._repr_html_()


def test_metrics_have_the_same_values_in_json_and_in_a_table(ball):
    made, real = ([(ball[0] + [0, 0, height], ball[1]) for height in heights] for heights in ((0, 4), (1, 10, 0.5)))
    metrics = ensemble_metrics(made, real)
    stored = json.loads(metrics.to_json())
    assert {name: stored[name] for name in metrics} == dict(metrics)
    assert [row["nearest_reference"] for row in stored["nearest"]] == metrics.nearest_reference.tolist() == [2, 0]
    assert metrics._repr_html_().count("<tr>") == len(metrics)


def test_estimates_have_the_same_values_in_json_and_in_a_table(pair):
    points, values = pair[0], matern_noise(pair, range=1.0, samples=1, seed=3)
    field = np.asarray(values, dtype=float).reshape(len(points))
    estimate = estimate_matern(pair, field, noise_estimation=False)
    stored = json.loads(estimate.to_json())
    assert stored["number_of_observations"] == len(points)
    assert stored["parameters"]["correlation_range"]["estimate"] == estimate["correlation_range"].estimate
    assert estimate._repr_html_().count("<tr>") == 1 + len(estimate)


def test_datasets_show_their_content(ball):
    source = SignalSource(*ball, np.zeros((5, 162, 3), np.float32))
    dataset = SignalDataset("Position <1>", [source, source])
    assert repr(dataset) == "<SignalDataset 'Position <1>': 2 surfaces, 10 samples>"
    assert "Position &lt;1&gt;" in dataset._repr_html_() and dataset._repr_html_().count("<td>5</td><td>3</td>") == 2
    mesh = PlanarMesh(np.zeros((3, 2)), np.array([[0, 1, 2]]))
    textures = TextureDataset([np.zeros((16, 32, 3), np.uint8)], [mesh])
    assert repr(textures) == "<TextureDataset: 1 images, 1 planar meshes>"
    assert "32 x 16 pixels" in textures._repr_html_() and "3 points, 1 triangles" in textures._repr_html_()


@pytest.fixture
def folder(tmp_path, pair):
    write_mesh(polydata_of(*pair), tmp_path / "ball.vtp")
    write_mesh(polydata_of(1.1 * pair[0], pair[1]), tmp_path / "larger.vtp")
    points, triangles = two_balls(pair)
    write_mesh(polydata_of(points, np.vstack([triangles, [[3, 3, 4]]])), tmp_path / "broken.vtp")
    field = polydata_of(*pair)
    add_array(field.GetPointData(), "Field", np.asarray(matern_noise(pair, range=1.0, seed=3), float).reshape(-1))
    write_mesh(field, tmp_path / "field.vtp")
    return tmp_path


@pytest.mark.parametrize(
    "command, status, name, value",
    [
        (["report", "broken.vtp"], 3, "properties.boundary_edges", 3),
        (["metrics", "--generated", "ball.vtp", "larger.vtp", "--reference", "larger.vtp", "ball.vtp"], 0, "mmd", 0.0),
        (["estimate", "field.vtp", "--observation-array", "Field"], 0, "number_of_fields", 1),
        (["geometric-texture-distance", "ball.vtp", "ball.vtp"], 0, "distance", 0.0),
        (["geometric-texture-features", "ball.vtp", "--bare", "ball.vtp"], 0, "number_of_peaks", 0),
        (["distance", "ball.vtp", "ball.vtp"], 0, "second_to_first.maximum", 0.0),
        (["statistics", "ball.vtp", "larger.vtp", "out.vtp", "--modes", "1"], 0, "samples", 2),
        (["repair", "broken.vtp", "out.vtp"], 0, "open_holes", 0),
        (["texture-atlas", "ball.vtp", "out.vtp"], 0, "outputs", ["out.vtp"]),
        (["remesh", "ball.vtp", "out.vtp", "--points", "300"], 0, "outputs", ["out.vtp"]),
        (["surface", "ball.vtp", "out.vtp"], 0, "outputs", ["out.vtp"]),
    ],
    ids=lambda value: value[0] if isinstance(value, list) else None,
)
def test_commands_print_json(folder, command, status, name, value):
    done = run_command(*command, "--json", cwd=folder)
    assert done.returncode == status, done.stderr
    found = json.loads(done.stdout)
    for part in name.split("."):
        found = found[part]
    assert found == pytest.approx(value, abs=1e-12) if isinstance(value, float) else found == value


def test_csv_and_json_exclude_each_other(folder):
    done = run_command("report", "ball.vtp", "--csv", "--json", cwd=folder)
    assert done.returncode == 2 and "not allowed with" in done.stderr
