# SPDX-License-Identifier: BSD-3-Clause
"""Tests damage.py: ``test_damage.py FOLDER``. Run by CTest."""

import argparse
import csv
import os
import sys

import numpy as np

import damage
import surfacesynthesis
from compare_noise import UNBOUNDED
from linear_velocity import point_masses
from sample_spaces import PoseSpace
from test_compare_noise import jack, poses_of_jack


def is_valid(points, triangles):
    """True for what the networks take: one component of manifold edges, wound alike. Holes may touch at a point."""
    used, corners = np.unique(triangles, return_inverse=True)
    report = surfacesynthesis.topology_report((points[used], corners.reshape(-1, 3)))
    defects = report["non_manifold_edges"] + report["degenerate_triangles"] + report["duplicate_triangles"]
    return defects == 0 and report["components"] == 1 and report["consistent_winding"], report


def check_damages():
    """Each damaged surface is one valid surface of points of the original, damaged as much as its name says."""
    points, triangles = jack(3)
    found = dict(damage.damages(points, triangles, 1))
    assert len(found) == 9 and found["none"] is triangles
    for name, damaged in found.items():
        valid, report = is_valid(points, damaged)
        assert valid, (name, dict(report))
        loops = report.get("boundary_loops", 0)
        assert (loops > 0) == ("holes" in name or name.startswith("half of the surface")), (name, loops)
    again = dict(damage.damages(points, triangles, 1))
    assert all(np.array_equal(again[name], damaged) for name, damaged in found.items())
    area = point_masses(points, triangles).sum()
    assert abs(point_masses(points, found["half of the surface"]).sum() / area - 0.5) < 0.02
    faces = {name: {tuple(sorted(face)) for face in damaged.tolist()} for name, damaged in found.items()}
    for name, share in damage.FLIPS.items():
        assert len(faces[name]) == len(triangles)
        changed = len(faces[name] - faces["none"])
        assert 1.2 * share * len(triangles) < changed <= 2 * share * len(triangles), (name, changed)
    for name, share in damage.THINNING.items():
        assert abs(len(np.unique(found[name])) - share * len(points)) <= 1, name


def check_points_that_are_left():
    """With all points the residuals are those of the whole; with holes poses still have the least."""
    mesh = jack(3)
    poses = poses_of_jack(mesh, 16, 0)
    space = PoseSpace(mesh, poses[:10])
    everything = np.arange(len(mesh[0]))
    assert np.allclose(space.seen_at(everything).residuals(poses[10:12]), space.residuals(poses[10:12]), atol=1e-9)
    some = np.unique(damage.with_holes(*mesh, np.random.default_rng(2), *damage.HOLES["medium holes"]))
    assert len(some) < 0.95 * len(everything)
    seen = space.seen_at(some)
    own = seen.residuals(poses[10:, some])
    middles = seen.residuals(0.5 * (poses[4:10, some] + poses[10:, some]))
    assert own.mean() < 0.5 * middles.mean(), (own, middles)
    lost = np.setdiff1d(everything, space.middle)
    try:
        space.seen_at(lost)
    except ValueError as error:
        assert "none of the middle" in str(error)
    else:
        raise AssertionError("poses cannot be placed without a middle")


def check_table(folder):
    """The table of a shipped model on few samples of a surface of another shape, on which its flow stays bounded."""
    os.makedirs(folder, exist_ok=True)
    surface, table = (os.path.join(folder, name) for name in ("jack.vtp", "damage.csv"))
    from surfacesynthesis.files.polygons import mesh_of_triangles, to_polydata

    surfacesynthesis.write_mesh(to_polydata(mesh_of_triangles(*jack(3))), surface)
    options = ["--armadillo", surface, "--vertices", "300", "--samples", "1", "--steps", "1", "--csv", table]
    rows = damage.main([*options, "--model", sys.argv[2]])
    with open(table, newline="", encoding="utf-8") as file:
        written = list(csv.DictReader(file))
    assert [row["damage"] for row in written] == [row["damage"] for row in rows] and len(rows) == 9
    for name in ("own", "whole"):
        assert all((row[f"unbounded_{name}"] == 1) == (row[f"error_{name}"] != "") for row in rows)
        assert all(np.isfinite(row[f"residual_{name}"]) == (row[f"error_{name}"] == "") for row in rows)
        assert np.isfinite(rows[0][f"residual_{name}"])
    few = damage.main([*options, "--model", sys.argv[2], "--only", damage.HALF])
    assert [row["damage"] for row in few] == ["none", damage.HALF] and few[0] == rows[0]
    assert np.isclose(rows[0]["residual_own"], rows[0]["residual_whole"], rtol=1e-3)
    assert np.isfinite(rows[4]["residual_whole"]), rows[4]
    assert np.isfinite(rows[4]["residual_own"]) or UNBOUNDED in rows[4]["error_own"], rows[4]
    assert not np.isclose(rows[4]["residual_own"], rows[4]["residual_whole"], rtol=1e-3), rows[4]
    closed = damage.main([*options, "--model", sys.argv[2], "--only", damage.HALF, "--repair"])
    assert closed[0] == rows[0], "a closed surface is as it was"
    assert closed[1]["points"] == rows[4]["points"] and closed[1]["residual_whole"] != rows[4]["residual_whole"], closed[1]


def check_samples_without_bound():
    """Those that deform() refuses are left out and counted, whichever they are."""
    refused = {2, 3, 9}

    def deform(mesh, model, first_sample, samples, **_):
        numbers = range(first_sample, first_sample + samples)
        if refused.intersection(numbers):
            raise surfacesynthesis.SurfaceSynthesisError(UNBOUNDED)
        return np.array([np.full((4, 3), number) for number in numbers]).squeeze()

    options = argparse.Namespace(samples=10, seed=0, steps=1, corrections=None, model="")
    whole, surfacesynthesis.deform = surfacesynthesis.deform, deform
    try:
        found, errors = damage.finite_samples(options, None, {})
    finally:
        surfacesynthesis.deform = whole
    assert [int(sample[0, 0]) for sample in found] == [0, 1, 4, 5, 6, 7, 8] and len(errors) == 3


def check_repair():
    """Half of a surface is closed, and its points are found in the result."""
    points, triangles = jack(3)
    used, corners = np.unique(damage.half_of(points, triangles), return_inverse=True)
    mesh = points[used], corners.reshape(-1, 3)
    whole, kept, places = damage.repaired(mesh)
    assert surfacesynthesis.topology_report(mesh)["boundary_edges"] > 0
    assert surfacesynthesis.topology_report(whole)["boundary_edges"] == 0
    assert np.array_equal(kept, np.arange(len(used))) and np.array_equal(whole[0][places], mesh[0])
    assert len(set(places)) == len(used)
    # A point of no triangle goes in the repair, and is not kept.
    _, kept, places = damage.repaired((np.concatenate([[[9.0, 9.0, 9.0]], mesh[0]]), mesh[1] + 1))
    assert np.array_equal(kept, 1 + np.arange(len(used))) and len(places) == len(kept)


def check_arguments():
    """Two surfaces, and a damage that there is none of, end the program."""
    for wrong in (["--bodies", "a", "--armadillo", "b"], ["--only", "tiny holes"]):
        try:
            damage.parsed(wrong)
        except SystemExit as error:
            assert error.code == 2
        else:
            raise AssertionError(wrong)
    assert damage.parsed(["--bodies", "a"]).model == "body_poses" and damage.parsed([]).model == "armadillo_poses"


if __name__ == "__main__":
    check_arguments()
    check_samples_without_bound()
    check_damages()
    check_points_that_are_left()
    check_repair()
    check_table(sys.argv[1])
    print("passed")
