# SPDX-License-Identifier: BSD-3-Clause
"""geometric_texture_features() and the command ``geometric-texture-features``."""

import json

import numpy as np
import pytest
from conftest import icosphere, point_array, polydata_of, run_command
from vtkmodules.vtkCommonDataModel import vtkPolyData

from surfacesynthesis import (
    Cancelled,
    SurfaceSynthesisError,
    geometric_texture_features,
    matern_noise,
    read_mesh,
    write_mesh,
)

POINTS, TRIANGLES = icosphere(5)
BARE = (POINTS, TRIANGLES)


def spiral(count, turn=0.0):
    """Directions that keep a distance from each other."""
    steps = np.arange(count)
    z = 1.0 - (2.0 * steps + 1.0) / count
    radius, angle = np.sqrt(1.0 - z * z), 2.399963229728653 * steps + turn
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), z], axis=1)


def with_bumps(centers, height=0.2, radius=0.17):
    """The unit sphere with cones at these places, and the heights of its points."""
    distances = np.linalg.norm(POINTS[:, None, :] - centers[None, :, :], axis=2)
    heights = (np.asarray(height) * np.clip(1.0 - distances / radius, 0.0, None)).max(axis=1)
    return (POINTS * (1.0 + heights)[:, None], TRIANGLES), heights


def varied(seed, count=80):
    """Heights that differ by up to a tenth."""
    return 0.2 * (1.0 + np.random.default_rng(seed).uniform(-0.1, 0.1, count))


def faults_of(features):
    """The limits of a texture against its reference that it does not keep."""
    ratios = features.ratios
    faults = {"count"} if abs(ratios["peak_density"] - 1.0) > 0.15 else set()
    faults |= {"variation"} if ratios["peak_height_variation"] > 1.3 else set()
    return faults | ({"merged"} if features["merged_share"] > 0.03 else set())


def test_bumps_are_counted_and_shown():
    mesh, heights = with_bumps(spiral(80))
    found = geometric_texture_features(polydata_of(*mesh), polydata_of(*BARE))
    assert found["number_of_peaks"] == 80 and found["number_of_merged_peaks"] == 0
    assert found["peak_density"] == pytest.approx(80 / (4 * np.pi), rel=0.01)
    assert found["relative_peak_density"] == pytest.approx(found["peak_density"] * found["unit_length"] ** 2)
    assert np.allclose(point_array(found.surface, "Height"), heights, atol=1e-3 * heights.max())
    peaks = np.flatnonzero(point_array(found.surface, "Peak"))
    assert len(peaks) == 80 and (point_array(found.surface, "Prominence")[peaks] > 0.1).all()
    assert (np.bincount(point_array(found.surface, "Region")) > 50).all(), "each point belongs to a peak"
    assert found["number_of_self_intersections"] in (0, -1)


def test_the_bare_surface_may_be_left_out():
    mesh, _ = with_bumps(spiral(80))
    over, alone = geometric_texture_features(mesh, BARE), geometric_texture_features(mesh)
    assert alone["number_of_peaks"] == 80
    assert alone["relative_peak_density"] == pytest.approx(over["relative_peak_density"], rel=0.05)


def test_other_places_of_one_texture_agree_and_wrong_textures_do_not():
    reference = geometric_texture_features(with_bumps(spiral(80), varied(1))[0], BARE)
    assert faults_of(geometric_texture_features(with_bumps(spiral(80, 1.0), varied(2))[0], BARE, reference)) == set()
    centers = spiral(80)
    distances = np.linalg.norm(centers[:, None] - centers[None], axis=2) + 9.0 * np.eye(80)
    merged = centers.copy()
    merged[1::2] = (centers + 3.0 * centers[distances.argmin(axis=1)])[1::2]
    merged /= np.linalg.norm(merged, axis=1, keepdims=True)
    assert "merged" in faults_of(geometric_texture_features(with_bumps(merged, varied(1))[0], BARE, reference))
    sparse = with_bumps(centers[:60], varied(1)[:60])[0]
    assert "count" in faults_of(geometric_texture_features(sparse, BARE, reference))
    _, heights = with_bumps(centers, varied(1))
    shuffled = (POINTS * (1.0 + np.random.default_rng(3).permutation(heights))[:, None], TRIANGLES)
    assert {"count", "merged"} <= faults_of(geometric_texture_features(shuffled, BARE, reference))
    uneven = with_bumps(centers, 0.2 * (1.0 + np.random.default_rng(3).uniform(-0.4, 0.4, 80)))[0]
    assert faults_of(geometric_texture_features(uneven, BARE, reference)) == {"variation"}


def test_prominence_is_that_of_the_reference_in_its_units():
    reference = geometric_texture_features(with_bumps(spiral(80))[0], BARE)
    flat, _ = with_bumps(spiral(80), 0.01)
    larger = geometric_texture_features((100 * flat[0], TRIANGLES), (100 * POINTS, TRIANGLES), reference)
    assert larger["minimum_prominence"] == pytest.approx(100 * reference["minimum_prominence"])
    assert larger["number_of_peaks"] == 0 and larger.ratios["peak_density"] == 0
    own = geometric_texture_features(flat, BARE, reference, minimum_prominence=0.005)
    assert own["number_of_peaks"] == 80
    assert own.ratios["mean_peak_height"] == pytest.approx(0.05, rel=1e-6)
    assert own.ratios["wall_density"] == pytest.approx(1.0, rel=0.01)


def test_walls_are_half_of_an_isoline():
    # Where noise is above its mean on a sphere, the isoline is the boundary; doubling the scale doubles its length.
    heights = 0.05 * np.asarray(matern_noise(BARE, range=0.6, seed=3), float).reshape(-1)
    rough = (POINTS * (1.0 + heights)[:, None], TRIANGLES)
    one = geometric_texture_features(rough, BARE)
    two = geometric_texture_features((2 * rough[0], TRIANGLES), (2 * POINTS, TRIANGLES))
    assert two["wall_length"] == pytest.approx(2 * one["wall_length"], rel=1e-6)
    assert two["relative_wall_density"] == pytest.approx(one["relative_wall_density"], rel=1e-6)
    high = geometric_texture_features(rough, BARE, wall_level=0.9)
    assert high["wall_length"] < one["wall_length"] and high["wall_height"] > one["wall_height"]


def test_results_show_themselves():
    mesh, _ = with_bumps(spiral(80))
    reference = geometric_texture_features(mesh, BARE)
    found = geometric_texture_features(mesh, BARE, reference)
    assert repr(found).startswith("<GeometricTextureFeatures: 80 peaks of height 0.1")
    assert "merged share" in str(found) and "peak density ratio" in str(found)
    stored = json.loads(found.to_json())
    assert stored["number_of_peaks"] == 80 and stored["ratios"]["peak_density"] == 1.0
    assert "ratios" not in json.loads(reference.to_json())
    assert found._repr_html_().count("<tr>") == 1 + len(found) + len(found.ratios)
    names, values = (line.split(",") for line in found.to_csv().splitlines())
    assert dict(zip(names, map(float, values)))["wall_density_ratio"] == 1.0
    assert str(geometric_texture_features(vtkPolyData())) == "empty"


def test_wrong_arguments_have_words():
    with pytest.raises(SurfaceSynthesisError, match="expected those of the surface, 10242 points"):
        geometric_texture_features(BARE, icosphere(2))
    with pytest.raises(SurfaceSynthesisError, match="bare surface on port 1 is empty"):
        geometric_texture_features(BARE, vtkPolyData())
    with pytest.raises(TypeError, match="vtkPolyData or a pair"):
        geometric_texture_features(3)
    with pytest.raises(TypeError, match="reference must be the result"):
        geometric_texture_features(BARE, reference=BARE)
    for name in ("unit_length", "minimum_prominence", "smoothing_length", "wall_level"):
        with pytest.raises(ValueError, match=name):
            geometric_texture_features(BARE, **{name: 0.0})
    for name in ("merged_saddle", "wall_level"):
        with pytest.raises(ValueError, match=name):
            geometric_texture_features(BARE, **{name: 1.5})
    with pytest.raises(Cancelled):
        geometric_texture_features(BARE, progress=lambda fraction: False)


def test_command(tmp_path):
    mesh, bare, output = (str(tmp_path / name) for name in ("mesh.vtp", "bare.ply", "out.vtp"))
    write_mesh(polydata_of(*with_bumps(spiral(80))[0]), mesh)
    write_mesh(polydata_of(*BARE), bare)
    options = ["--merged-saddle", "0.6", "--wall-level", "0.5", "--minimum-prominence", "0.05", "--unit-length", "0.1"]
    done = run_command("geometric-texture-features", mesh, "--bare", bare, *options, "--json", "--output", output)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    expected = geometric_texture_features(
        read_mesh(mesh), read_mesh(bare), merged_saddle=0.6, wall_level=0.5, minimum_prominence=0.05, unit_length=0.1
    )
    assert {name: found[name] for name in expected} == pytest.approx(dict(expected))
    assert read_mesh(output).GetPointData().HasArray("Prominence")
    done = run_command("geometric-texture-features", mesh, "--bare", bare, "--reference", mesh, "--reference-bare", bare, "--csv")
    assert done.returncode == 0 and done.stdout.splitlines()[0].endswith("wall_density_ratio")
    assert "number of peaks" in run_command("geometric-texture-features", mesh, "--smoothing-length", "0.3").stdout
    done = run_command("geometric-texture-features", mesh, "--reference-bare", bare)
    assert done.returncode == 2 and "without --reference" in done.stderr
    assert run_command("geometric-texture-features", mesh, "--bare", "missing.ply").returncode == 1
