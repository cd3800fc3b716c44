# SPDX-License-Identifier: BSD-3-Clause
"""ensemble_metrics() and the command ``metrics``."""

import csv
import io

import numpy as np
import pytest
from conftest import add_array, icosphere, polydata_of, run_command
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet, vtkPolyData, vtkUnstructuredGrid

import surfacesynthesis
from surfacesynthesis import (
    Cancelled,
    SurfaceSynthesisError,
    ensemble_metrics,
    matern_noise,
    vtkEnsembleMetrics,
    write_mesh,
)
from surfacesynthesis.metrics import METRICS

POINTS, TRIANGLES = icosphere(1)


def lifted(height):
    """The sphere moved upwards, with the array "height"."""
    mesh = polydata_of(POINTS + [0.0, 0.0, height], TRIANGLES)
    add_array(mesh.GetPointData(), "height", np.full(len(POINTS), height))
    return mesh


def blocks_of(*meshes):
    blocks = vtkMultiBlockDataSet()
    for number, mesh in enumerate(meshes):
        blocks.SetBlock(number, mesh)
    return blocks


def mass():
    """One third of the area of the triangles around each point."""
    a, b, c = (POINTS[TRIANGLES[:, k]] for k in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    return np.bincount(TRIANGLES.ravel(), np.repeat(areas / 3, 3), len(POINTS))


def expected_of(generated, reference, rms=False):
    """The definitions, with NumPy: a matrix of all distances."""
    weights = mass() / mass().sum()

    def distances(a, b):
        norms = np.linalg.norm(a[:, None] - b[None], axis=-1)
        return np.sqrt((norms**2 * weights).sum(-1)) if rms else (norms * weights).sum(-1)

    union = np.concatenate([generated, reference])
    count = len(generated)
    matrix = distances(union, union)
    np.fill_diagonal(matrix, np.inf)
    own = np.arange(len(union)) < count
    nearest = matrix[:count, count:].argmin(1)
    return {
        "mmd": matrix[:count, count:].min(1).mean(),
        "reverse_mmd": matrix[:count, count:].min(0).mean(),
        "cov": len(set(nearest)) / len(reference),
        "one_nearest_neighbour_accuracy": (own[matrix.argmin(1)] == own).mean(),
        "mean_error": distances(generated.mean(0)[None], reference.mean(0)[None])[0, 0],
        "generated_spacing": matrix[:count, :count].min(1).mean(),
        "reference_spacing": matrix[count:, count:].min(1).mean(),
    }, nearest


@pytest.mark.parametrize("rms", [False, True])
@pytest.mark.parametrize("kind", [np.float64, np.float32])
def test_arrays_of_numbers_give_what_numpy_gives(rms, kind):
    random = np.random.default_rng(1)
    generated = random.normal(size=(13, len(POINTS), 3)).astype(kind)
    reference = random.normal(0.1, size=(17, len(POINTS), 3)).astype(kind)
    metrics = ensemble_metrics(
        generated, reference, source=(POINTS, TRIANGLES), distance="rms" if rms else "mean_l2"
    )
    expected, nearest = expected_of(generated.astype(float), reference.astype(float), rms)
    for name, value in expected.items():
        assert metrics[name] == pytest.approx(value, abs=1e-12), name
    assert np.array_equal(metrics.nearest_reference, nearest)
    assert metrics.distances.mean() == pytest.approx(metrics["mmd"])
    assert list(metrics) == list(METRICS)
    assert [metrics[name] for name in list(METRICS)[-4:]] == [13, 17, len(POINTS), 3]


def test_every_way_to_give_an_ensemble():
    heights = ([0.0, 4.0], [1.0, 10.0, 0.5])
    ways = [
        [[lifted(h) for h in ensemble] for ensemble in heights],
        [blocks_of(*map(lifted, ensemble)) for ensemble in heights],
        [tuple((POINTS + [0, 0, h], TRIANGLES) for h in ensemble) for ensemble in heights],
    ]
    for generated, reference in ways:
        metrics = ensemble_metrics(generated, reference)
        assert metrics["mmd"] == pytest.approx(1.75)
        assert metrics["cov"] == pytest.approx(2 / 3)
        assert metrics.nearest_reference.tolist() == [2, 0]
        assert metrics.names == ["Block 1", "Block 2"]
        assert metrics.nearest_names == ["Block 3", "Block 1"]
    by_array = ensemble_metrics(*ways[0], array="height")
    assert by_array["mmd"] == pytest.approx(1.75) and by_array["number_of_components"] == 1
    flat = [np.array(ensemble)[:, None] * np.ones(len(POINTS)) for ensemble in heights]
    assert ensemble_metrics(*flat, source=lifted(0.0))["mmd"] == pytest.approx(1.75)
    assert ensemble_metrics(lifted(1.0), lifted(3.0))["mmd"] == pytest.approx(2.0)


def test_samples_of_the_noise_filter():
    first, second = (matern_noise(lifted(0.0), range=2.0, samples=6, seed=seed, name="n") for seed in (1, 2))
    assert ensemble_metrics(first, first, array="n")["mmd"] == 0.0
    metrics = ensemble_metrics(first, second, array="n")
    assert metrics["mmd"] > 0.1 and metrics.names[5] == "n_5"


def test_options_reach_the_filter():
    shifted = ensemble_metrics([lifted(0.0)], [lifted(5.0)], remove_centroid=True)
    assert shifted["mmd"] < 1e-14
    source = polydata_of(POINTS * [1, 1, 5], TRIANGLES)
    peak = lifted(0.0)
    vtk_to_numpy(peak.GetPointData().GetArray("height"))[np.argmax(POINTS[:, 2])] = 1.0
    plain, stretched = (ensemble_metrics([lifted(0.0)], [peak], "height", s)["mmd"] for s in (None, source))
    assert plain == pytest.approx((mass() / mass().sum())[np.argmax(POINTS[:, 2])])
    assert abs(stretched / plain - 1) > 0.05


def test_inputs_are_not_modified_and_no_pipeline_is_left():
    mesh = lifted(1.0)
    before = (mesh.GetMTime(), mesh.GetInformation().GetReferenceCount())
    ensemble_metrics(mesh, [mesh, mesh], source=mesh)
    assert (mesh.GetMTime(), mesh.GetInformation().GetReferenceCount()) == before


def test_the_result_is_a_mapping_that_shows_itself():
    metrics = ensemble_metrics([lifted(0.0)], [lifted(2.0), lifted(3.0)])
    assert "mmd" in metrics and len(metrics) == len(METRICS)
    assert "one nearest neighbour accuracy" in str(metrics)
    assert "mmd 2" in repr(metrics)
    names, values = csv.reader(io.StringIO(metrics.to_csv()))
    assert names == list(METRICS) and float(values[0]) == metrics["mmd"]
    rows = list(csv.DictReader(io.StringIO(metrics.nearest_to_csv())))
    assert rows[0]["nearest_reference"] == "0" and float(rows[0]["distance"]) == metrics.distances[0]


def test_empty_ensembles():
    nothing = ensemble_metrics([], vtkPolyData())
    assert len(nothing) == 0 and len(nothing.distances) == 0 and str(nothing) == "empty"
    assert len(nothing.nearest_to_csv().splitlines()) == 1
    with pytest.raises(SurfaceSynthesisError, match="generated ensemble is empty"):
        ensemble_metrics([], [lifted(0.0)])
    with pytest.raises(SurfaceSynthesisError, match="reference ensemble is empty"):
        ensemble_metrics(np.ones((1, 42)), np.ones((0, 42)), source=lifted(0.0))


def test_errors_of_the_filter_are_raised():
    with pytest.raises(SurfaceSynthesisError, match=r"generated sample 1 \(Block 2\) has 162 points"):
        ensemble_metrics([lifted(0.0), icosphere(2)], [lifted(0.0)])
    with pytest.raises(SurfaceSynthesisError, match='no numeric point array called "speed"'):
        ensemble_metrics([lifted(0.0)], [lifted(0.0)], array="speed")
    values = np.ones((2, len(POINTS)))
    values[1, 7] = np.nan
    with pytest.raises(SurfaceSynthesisError, match="reference sample 1 .* first point 7"):
        ensemble_metrics(np.ones((2, len(POINTS))), values, source=lifted(0.0))


@pytest.mark.parametrize(
    "error, text, options",
    [
        (ValueError, "unknown distance 'l1'", {"distance": "l1"}),
        (TypeError, "distance must be a string", {"distance": 1}),
        (TypeError, "remove_centroid must be True or False", {"remove_centroid": 1}),
        (ValueError, "array must be the name", {"array": ""}),
        (TypeError, "as reference ensemble", {"reference": 3}),
        (TypeError, "mesh must be", {"reference": [3]}),
        (TypeError, "mesh must be a vtkPolyData", {"source": vtkUnstructuredGrid()}),
        (TypeError, "needs the surface", {"generated": np.ones((2, 42))}),
        (TypeError, "both be arrays", {"generated": np.ones((2, 42)), "source": (POINTS, TRIANGLES)}),
        (ValueError, "V = 42 points", {"generated": np.ones((2, 41)), "source": (POINTS, TRIANGLES)}),
        (TypeError, "real numbers", {"generated": np.ones((2, 42), complex), "source": (POINTS, TRIANGLES)}),
        (TypeError, "progress must be callable", {"progress": 1}),
    ],
)
def test_wrong_arguments(error, text, options):
    with pytest.raises(error, match=text):
        ensemble_metrics(**{"generated": [lifted(0.0)], "reference": [lifted(0.0)], **options})


def test_an_array_name_beside_arrays_of_numbers_is_refused():
    with pytest.raises(ValueError, match="array names an array of surfaces"):
        ensemble_metrics(np.ones((1, 42)), np.ones((1, 42)), array="a", source=lifted(0.0))


def test_progress_and_cancellation():
    seen = []
    ensemble_metrics([lifted(0.0)] * 20, [lifted(1.0)] * 20, progress=seen.append)
    assert len(seen) > 5 and seen == sorted(seen) and seen[-1] == 1.0
    with pytest.raises(Cancelled):
        ensemble_metrics([lifted(0.0)] * 20, [lifted(1.0)] * 20, progress=lambda fraction: fraction < 0.5)


def test_the_module_names_what_it_has():
    assert {"ensemble_metrics", "vtkEnsembleMetrics", "EnsembleMetrics", "DISTANCES"} <= set(surfacesynthesis.__all__)
    assert isinstance(vtkEnsembleMetrics(), vtkEnsembleMetrics)


@pytest.fixture
def folder(tmp_path):
    for number, height in enumerate((0.0, 4.0)):
        write_mesh(lifted(height), tmp_path / f"made_{number}.vtp")
    for number, height in enumerate((1.0, 10.0, 0.5)):
        write_mesh(lifted(height), tmp_path / f"real_{number}.vtp")
    write_mesh(blocks_of(lifted(0.0), lifted(4.0)), tmp_path / "made.vtm")
    write_mesh(lifted(0.0), tmp_path / "source.ply")
    return tmp_path


def test_command_on_lists_of_files(folder):
    real = sorted(folder.glob("real_*.vtp"))
    for made in (sorted(folder.glob("made_*.vtp")), [folder / "made.vtm"]):
        done = run_command("metrics", "--generated", *made, "--reference", *real, "--csv")
        assert done.returncode == 0, done.stderr
        (row,) = csv.DictReader(io.StringIO(done.stdout))
        assert float(row["mmd"]) == pytest.approx(1.75)
        assert row["number_of_generated"] == "2"


def test_command_options_and_outputs(folder):
    made, real = folder / "made.vtm", sorted(folder.glob("real_*.vtp"))
    given = ["metrics", "--generated", made, "--reference", *real]
    table = run_command(*given, "--array", "height", "--distance", "rms", "--source", folder / "source.ply")
    assert table.returncode == 0 and "mmd" in table.stdout and "1.75" in table.stdout, table.stderr
    nearest = run_command(*given, "--nearest", "--threads", "1")
    rows = list(csv.DictReader(io.StringIO(nearest.stdout)))
    assert [row["nearest_reference_name"] for row in rows] == ["Block 3", "Block 1"]
    moved = run_command(*given, "--remove-centroid", "--csv")
    assert float(next(csv.DictReader(io.StringIO(moved.stdout)))["mmd"]) < 1e-13


@pytest.mark.parametrize(
    "options, status, text",
    [
        (["--generated", "made.vtm"], 2, "--reference"),
        (["--generated", "made.xyz", "--reference", "made.vtm"], 2, "extension"),
        (["--generated", "made.vtm", "--reference", "none.vtp"], 1, "none.vtp"),
        (["--generated", "made.vtm", "--reference", "made.vtm", "--array", "x"], 1, "no numeric point array"),
        (["--generated", "made.vtm", "--reference", "made.vtm", "--source", "made.vtm"], 1, "one surface"),
        (["--generated", "made.vtm", "--reference", "made.vtm", "--distance", "l1"], 2, "--distance"),
    ],
)
def test_command_says_what_is_wrong(folder, options, status, text):
    done = run_command("metrics", *options, cwd=folder)
    assert done.returncode == status and text in done.stderr and done.stdout == "", done
    assert len(done.stderr.splitlines()) == 1
