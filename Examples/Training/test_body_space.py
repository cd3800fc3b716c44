# SPDX-License-Identifier: BSD-3-Clause
"""Tests body_space.py, component_offsets.py and unseen_bodies.py on a limb of few bones: ``test_body_space.py FOLDER``. Run by CTest."""

import argparse
import csv
import os
import shutil
import sys

import numpy as np

import body_space
import carrying
import component_offsets
import damage
import encoder_error
import make_bodies
import surfacesynthesis
import unseen_bodies
from surfacesynthesis.files.polygons import mesh_of_triangles, to_polydata
from test_make_bodies import HEIGHT, tube, write_package
from test_training import icosphere

#: Heads along the limb; the third bone is a hand, and the fourth hangs beside it.
HEADS = np.array([[0.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 4.0, 0.0], [0.0, 5.0, 0.3]])


def limb():
    """The tube of test_make_bodies.py with weights that change over a length of 1, and its skeleton."""
    points, quads = tube()
    height = points[:, 1]
    steps = np.stack([np.clip(height - head + 0.5, 0.0, 1.0) for head in HEADS[:, 1]])
    steps[0] = 1.0
    weights = np.concatenate([steps[:-1] - steps[1:], steps[-1:]]).T
    kept = np.argsort(-weights, axis=1, kind="stable")[:, :2]
    weights = np.take_along_axis(weights, kept, axis=1)
    mesh = to_polydata(mesh_of_triangles(points, triangles_of(quads)))
    body = make_bodies.with_weights(mesh, kept, weights / weights.sum(axis=1, keepdims=True))
    return body, body_space.Skeleton(["root", "arm", "wrist.L", "finger"], HEADS, [-1, 0, 1, 2])


def triangles_of(quads):
    """Two triangles of each quad, without those that have a corner twice."""
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    sides = np.sort(triangles, axis=1)
    return triangles[(np.diff(sides, axis=1) > 0).all(axis=1)]


def random_pose(seed, angle=0.8):
    random = np.random.default_rng(seed)
    return body_space.Pose(make_bodies.quaternions_of(angle * random.uniform(-1.0, 1.0, (4, 3))), random.standard_normal(3))


def check_skinning():
    """The points of a pose are those of skin()."""
    body, skeleton = limb()
    space = body_space.RigSpace(body, skeleton, [0, 1, 2, 3])
    for seed in range(5):
        pose = random_pose(seed, 1.5)
        bones = {"Head": skeleton.heads, "Parent": skeleton.parents}
        translations = np.zeros((4, 3))
        translations[0] = pose.translation
        posed = surfacesynthesis.skin(body, bones, {"Rotation": pose.rotations, "Translation": translations})
        expected = make_bodies.arrays_of(posed)[0]
        assert np.allclose(space.posed(pose), expected, atol=1e-6), np.abs(space.posed(pose) - expected).max()


def check_derivatives():
    """The derivatives are those of differences, in every direction of turns."""
    body, skeleton = limb()
    skin = body_space.RigSpace(body, skeleton, [0, 1, 3])._skin
    pose = random_pose(7)
    _, jacobian = skin.jacobian(pose)
    for k in range(9):
        turns = np.zeros(9)
        turns[k] = 1e-5
        plus, minus = (skin.posed(skin.stepped(pose, sign * turns.reshape(3, 3), np.zeros(3))) for sign in (1.0, -1.0))
        difference = (plus - minus).ravel() / 2e-5
        assert np.allclose(jacobian[:, k].toarray().ravel(), difference, atol=1e-6), k


def check_points_that_are_left():
    """With all points the residuals are those of the whole; with half of them poses still have none."""
    body, skeleton = limb()
    space = body_space.RigSpace(body, skeleton, [0, 1, 2, 3])
    poses = np.array([space.posed(random_pose(seed)) for seed in range(3)])
    shapes = space.noisy(poses, 1)
    everything = np.arange(len(space.mesh[0]))
    assert np.allclose(space.seen_at(everything).residuals(shapes), space.residuals(shapes), rtol=1e-9)
    some = np.flatnonzero(space.mesh[0][:, 0] < 0.0)
    assert 0.3 < len(some) / len(everything) < 0.7
    seen = space.seen_at(some)
    assert seen.residuals(poses[:, some]).max() < 1e-5, seen.residuals(poses[:, some])
    assert np.allclose(seen.residuals(shapes[:, some]), body_space.NOISE, rtol=0.2), seen.residuals(shapes[:, some])


def check_fit():
    """Poses have no distance, also those that are moved and turned as a whole; other shapes have that of what is not a pose."""
    body, skeleton = limb()
    space = body_space.RigSpace(body, skeleton, [0, 1, 2, 3])
    poses = np.stack([space.posed(random_pose(seed)) for seed in range(6)])
    assert space.residuals(poses).max() < 1e-6, space.residuals(poses)
    # A bone that does not turn in the space is missing.
    fewer = body_space.RigSpace(body, skeleton, [0, 1, 3])
    assert fewer.residuals(poses).min() > 1e-3, fewer.residuals(poses)
    # Noise has its own length, less what the 15 numbers of a pose take of it.
    noisy = space.noisy(poses, 3)
    moved = np.array([space.distance(a, b) for a, b in zip(noisy, poses)])
    assert np.allclose(moved, body_space.NOISE, rtol=0.1), moved
    found, most = space.residuals(noisy), np.sqrt(1.0 - 15.0 / noisy[0].size)
    assert np.all(found < moved) and np.allclose(found, most * moved, rtol=0.03), found / moved
    # A tube that is wider by d everywhere is at the distance d of the side.
    points = space.mesh[0]
    wider = points * (1.0 + 0.05 * np.array([1.0, 0.0, 1.0]))
    away = space.distance(wider, points)
    assert 0.95 * away < space.residuals(wider[None])[0] <= 1.000001 * away, (space.residuals(wider[None]), away)


def check_chosen_points():
    """A fit to some of the points has nearly the same distance of all."""
    body, skeleton = limb()
    every, some = (body_space.RigSpace(body, skeleton, [0, 1, 2, 3], count) for count in (10000, 120))
    noisy = every.noisy(np.stack([every.posed(random_pose(seed)) for seed in range(4)]), 5)
    assert len(some._fitted) == 120 and np.isclose(some._fitted_masses.sum(), every.masses.sum())
    found, least = some.residuals(noisy), every.residuals(noisy)
    assert np.all(found > least) and np.allclose(found, least, rtol=0.1), (found, least)


def check_hands():
    """The hand is what hangs on the wrist; where it is larger by a tenth, it is stretched by as much."""
    body, skeleton = limb()
    space = body_space.RigSpace(body, skeleton, [0, 1, 2, 3])
    hand = body_space.hands_of(space, skeleton)
    points = space.mesh[0]
    assert points[hand][..., 1].min() > 4.0 - 1e-9 and len(hand) > 50
    larger = HEADS[2] + 1.1 * (points - HEADS[2])
    evaluation = body_space.Evaluation(body, skeleton, [0, 1, 2, 3], [])
    assert np.isclose(evaluation._stretch_of_hands([points, points], [points, larger]), 100.0 * np.log(1.1) / np.sqrt(2.0))
    evaluation._hands = hand[:0]
    assert np.isnan(evaluation._stretch_of_hands([points], [larger]))


def check_places():
    """A ball that moves with the limb around it has no offset; one that leaves its place, or turns in it, has what it does."""
    limb_points, limb_triangles = make_bodies.arrays_of(limb()[0])
    ball, cells = icosphere(1)
    ball = 0.2 * ball + [0.0, 2.5, 0.0]
    points = np.concatenate([limb_points, ball])
    body, component = component_offsets.components(points, np.concatenate([limb_triangles, cells + len(limb_points)]))
    assert len(body) == len(limb_points) and len(component) == len(ball)
    place = component_offsets.Place(points, component, body, 1.0)
    near = np.linalg.norm(points[place._around] - ball.mean(axis=0), axis=1)
    assert len(near) == component_offsets.PLACE_POINTS and near.max() < 1.5, (len(near), near.max())
    away = np.linalg.norm(points[body][:, None] - ball, axis=2).min(axis=1)
    wide = component_offsets.Place(points, component, body, 70.0)._around  # within 0.7
    assert len(wide) > len(near) and set(wide) == set(body[away < 0.7])
    turn = make_bodies.quaternions_of(np.array([[0.7, -1.1, 0.4]]))
    moved = body_space.turned(turn, points) + [3.0, -1.0, 2.0]
    away, larger = moved.copy(), moved.copy()
    away[component] += [0.0, 0.03, 0.04]
    away[body[points[body][:, 1] < 0.5]] += 1.0  # far from the place
    larger[component] += 0.5 * (moved[component] - moved[component].mean(axis=0))
    offsets, distortions = place.offsets(np.stack([points, moved, away, larger]))
    assert np.allclose(offsets, [0.0, 0.0, 0.05, 0.0], atol=1e-9), offsets
    assert np.allclose(distortions, [0.0, 0.0, 0.0, 0.1], atol=1e-9), distortions


def check_triangulations():
    """Bodies with other numbers of faces have the same poses."""
    body, skeleton = limb()
    space = body_space.RigSpace(body, skeleton, [0, 1, 2, 3])
    pose = random_pose(2, 0.5)
    for faces, most in ((300, 330), (4000, 6000)):
        other = body_space.triangulated(body, skeleton, faces)
        assert 0.9 * faces < other.GetNumberOfPolys() <= most, other.GetNumberOfPolys()
        found = body_space.RigSpace(other, skeleton, [0, 1, 2, 3])
        sides = np.sort(np.concatenate([found.mesh[1][:, pair] for pair in ([0, 1], [1, 2], [2, 0])]), axis=1)
        assert (np.unique(sides, axis=0, return_counts=True)[1] == 2).all(), "it is closed"
        near = make_bodies.carried(space.posed(pose)[None], space.mesh, found.mesh[0])[0]
        assert found.distance(near, found.posed(pose)) < 0.02, found.distance(near, found.posed(pose))


def check_table(folder):
    """The table of a model after two iterations on the data of a small package."""
    package = os.path.join(folder, "package")
    write_package(package)
    sizes = ["--poses", "6", "--test-poses", "8", "--full-poses", "2", "--vertices", "150", "--test-vertices", "250"]
    make_bodies.main([folder, "--package", package, *sizes])
    skeleton = body_space.Skeleton.read(os.path.join(folder, "bones.csv"))
    assert skeleton.names == ["trunk", "upperarm01.L"] and body_space.moved_joints(folder, skeleton).tolist() == [0, 1]
    model, table = (os.path.join(folder, name) for name in ("model.safetensors", "table.csv"))
    surfacesynthesis.train_flow_matching(
        dataset=os.path.join(folder, "body_poses.safetensors"), model=model, iterations=2, width=8, blocks=2, layers=2, batch=2
    )
    options = ["--faces", "400", "1000", "--samples", "4", "2", "--steps", "2", "--csv", table]
    rows = body_space.main([folder, "--model", model, *options])
    assert [row["samples"] for row in rows] == [4, 4, 4, 2, 2, 2]
    for poses, noisy, samples in (rows[:3], rows[3:]):
        assert poses["distance"] < 1e-5 and abs(noisy["distance"] - body_space.NOISE) < 1e-3
        assert np.isfinite(samples["distance"]) and samples["distance"] > poses["distance"]
        assert 0.0 <= samples["cov"] <= 1.0 and np.isnan(samples["hands"]) and np.isnan(samples["hands_of_fit"])
    with open(table, newline="", encoding="utf-8") as file:
        assert [float(row["distance"]) for row in csv.DictReader(file)] == [row["distance"] for row in rows]
    assert len(body_space.main([folder, "--faces", "400", "--samples", "2"])) == 2
    poses, samples = component_offsets.main([folder, "--model", model, "--samples", "3", "--steps", "2", "--csv", table,
                                             "--coupling-distance", "2"])  # fmt: skip
    assert (poses["number"], samples["number"]) == (len(list(component_offsets.package_poses(folder, skeleton))), 3)
    assert poses["components"] == samples["components"] == len(make_bodies.PARTS) and poses["largest"] < samples["largest"] < np.inf
    try:
        component_offsets.main([folder, "--model", model, "--surface", os.path.join(folder, "body.vtp")])
        raise AssertionError("a surface of one component was taken")
    except SystemExit as error:
        assert "one component" in str(error)
    damage.POSES_SEEN = 2
    points, triangles, space = damage.body(argparse.Namespace(bodies=folder, vertices=150))
    assert len(points) == len(space.mesh[0]) and triangles.max() == len(points) - 1 and len(space.poses) == 2
    left = np.unique(damage.half_of(points, triangles))
    assert len(left) < 0.8 * len(points) and space.seen_at(left).residuals(space.poses[:, left]).max() < 1e-3


def check_unseen_bodies(folder):
    """The table of a model of many bodies after two iterations: poses of each body are those of its own skeleton."""
    package = os.path.join(folder, "package")
    write_package(package)
    sizes = ["--vertices", "150", "--test-vertices", "250"]
    make_bodies.main([folder, "--package", package, "--bodies", "3", "--test-bodies", "1", "--poses-per-body", "3", *sizes])
    model, table = (os.path.join(folder, name) for name in ("model.safetensors", "table.csv"))
    surfacesynthesis.train_flow_matching(
        dataset=os.path.join(folder, "bodies_train.safetensors"), model=model, encoder_iterations=2, iterations=2, width=8, blocks=2,
        layers=2, batch=2,
    )  # fmt: skip
    plain = os.path.join(folder, "plain.safetensors")
    surfacesynthesis.train_flow_matching(
        dataset=os.path.join(folder, "bodies_train.safetensors"), model=plain, without_encoder=True, source_memory=0.0,
        iterations=2, width=8, blocks=2, layers=2, batch=2,
    )  # fmt: skip
    bodies = ["--package", package, "--bodies", "2", "--samples", "3", "--steps", "2", "--corrections", "0", *sizes]
    rows, errors = unseen_bodies.main(["--model", model, "--without-encoder", plain, "--csv", table, *bodies])
    assert [row["samples"] for row in rows] == [6] * 9 and os.path.exists(table)
    assert len({row["points"] for row in rows[:6]}) == 1 and rows[6]["points"] != rows[0]["points"]
    for poses, samples, others in (rows[:3], rows[3:6], rows[6:]):
        assert poses["largest"] < 1e-5 and 1e-4 < samples["distance"] < np.inf, (poses, samples)
        assert "without encoder" in others["ensemble"] and others["distance"] != samples["distance"], (samples, others)
    assert [row["points"] for row in errors] == [rows[k]["points"] for k in (0, 3, 6)]
    assert [(row["bodies"], row["functions"]) for row in errors] == [(2, 64)] * 3
    for row in errors:  # after two iterations
        assert 0.5 < row["error"] <= row["largest"] < 2.0 and row["deviation"] > 0.0, row
    written = os.path.join(folder, "errors.csv")
    found = unseen_bodies.main(["--model", model, "--encoder-only", "--encoder-csv", written, *bodies])
    assert found == ([], errors)
    with open(written, newline="", encoding="utf-8") as file:
        assert [float(row["error"]) for row in csv.DictReader(file)] == [row["error"] for row in errors]
    assert unseen_bodies.main(["--model", plain, "--encoder-only", *bodies]) == ([], [])


def blob(stretch, level=2):
    """A blob of three half axes, with a thick end; the same surface on the triangulation of each level."""
    points, cells = icosphere(level)
    return np.array([1.0, 1.3 * stretch, 1.7]) * points * (1.0 + 0.2 * points[:, 1:2] + 0.1 * points[:, :1]), cells


def check_encoder_error(folder):
    """The error falls in the training of an encoder, on a blob that it has not seen and on another triangulation as well."""
    os.makedirs(folder, exist_ok=True)
    count, sources = 4, [blob(1.0 + 0.1 * k) for k in range(4)]
    samples = [(mesh, np.stack([mesh[0], mesh[0] * [1.0, 1.0, 1.02]])) for mesh in sources]
    dataset = os.path.join(folder, "blobs.safetensors")
    surfacesynthesis.write_signal_dataset(dataset, samples, "Position")
    mass = encoder_error.point_masses(*sources[0])
    coarse, fine = blob(1.15), blob(1.15, 3)
    errors = {}
    for iterations in (1, 100):
        model, encoder = (os.path.join(folder, f"{iterations}{ending}") for ending in (".safetensors", ".encoder"))
        surfacesynthesis.train_flow_matching(
            dataset=dataset, model=model, encoder_iterations=iterations, eigenfunctions=count, iterations=1, width=12,
            blocks=2, layers=2, batch=2, averaging=0.0,
        )  # fmt: skip
        assert encoder_error.write_encoder(model, encoder) == count
        functions = encoder_error.learnt_functions(sources[0], encoder, count)
        assert np.allclose(functions.T @ (mass[:, None] * functions) / mass.sum(), np.eye(count), atol=1e-9)
        expected = [(coarse, functions), (fine, carrying.carried(functions[None], coarse, fine[0])[0])]
        errors[iterations] = [encoder_error.relative_errors(mesh, encoder, wanted) for mesh, wanted in expected]
    for before, after in zip(errors[1], errors[100]):
        assert before.min() > 0.8 and after.max() < 0.2, (before, after)


def check_summary():
    """Mean and deviation of all samples of two bodies."""
    first, second = np.array([1.0, 2.0, 6.0]), np.array([3.0, 3.0, 9.0])
    rows = [{"samples": 3, "points": 5, "faces": 6, "distance": one.mean(), "deviation": one.std(), "largest": one.max(), "cov": 0.5,
             "nna": 0.25, "hands": 3.0, "hands_of_poses": 3.0, "hands_of_fit": 4.0} for one in (first, second)]  # fmt: skip
    rows[1]["hands"] = 5.0
    found, both = unseen_bodies.summary("both", rows), np.concatenate([first, second])
    assert found["samples"] == 6 and np.allclose([found["distance"], found["deviation"]], [both.mean(), both.std()])
    assert found["largest"] == 9.0 and found["cov"] == 0.5 and np.isclose(found["hands"], np.sqrt(17.0))


if __name__ == "__main__":
    assert HEADS[-1, 1] < HEIGHT
    shutil.rmtree(sys.argv[1], ignore_errors=True)  # no training goes on from an earlier one
    check_derivatives()
    check_points_that_are_left()
    check_fit()
    check_chosen_points()
    check_hands()
    check_places()
    check_skinning()
    check_triangulations()
    check_summary()
    check_table(sys.argv[1])
    check_unseen_bodies(os.path.join(sys.argv[1], "bodies"))
    check_encoder_error(os.path.join(sys.argv[1], "blobs"))
    print("passed")
