# SPDX-License-Identifier: BSD-3-Clause
"""Compares kinds of noise on tiny datasets, as a test: ``test_compare_noise.py FOLDER``. Run by CTest."""

import argparse
import csv
import os
import shutil
import subprocess
import sys

import numpy as np

import compare_noise
import surfacesynthesis
from compare_noise import COLUMNS, GAUSSIAN, KINDS, METRICS, NOISE_ON_MEAN, NOISES, OTHERS, TASKS
from linear_velocity import (
    Frame,
    LinearVelocity,
    Modes,
    Noise,
    cotangent_weights,
    loss_weights,
    network_units,
    point_masses,
    triangle_areas,
)
from relief import Relief, bending, with_faces
from sample_spaces import MixtureSpace, PoseSpace
from stretch import logarithms, parts, wavelengths
from surfacesynthesis.files.polygons import mesh_of_triangles, to_polydata
from surfacesynthesis.safetensors import read_safetensors, write_safetensors
from test_training import HERE, icosphere

OPTIONS = ("--iterations", "30", "--width", "8", "--blocks", "1", "--batch", "2", "--samples", "6", "--steps", "2", "--fits", "3")
WRITTEN = ("armadillo", "bunny")
TRAINED = ("matern_smoothed", "matern", "white_smoothed", "white", "spectral_64")


def jack(levels, turn=0.0):
    """A body with six limbs along the axes; a turn of the sphere that it is made of gives another triangulation."""
    points, triangles = icosphere(levels)
    cosine, sine = np.cos(turn), np.sin(turn)
    points = points @ np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    radius = 0.5 + 0.8 * (points**8).sum(axis=1, keepdims=True)
    return points * radius * [1.0, 1.1, 1.3], triangles


def poses_of_jack(mesh, samples, first_sample):
    return surfacesynthesis.poses(mesh, samples, first_sample=first_sample, template=jack(3), handle_radius=0.1)


def write_dataset(path, mesh, name, values):
    surfacesynthesis.write_signal_dataset(path, [(to_polydata(mesh_of_triangles(*mesh)), values)], name)


def unit_sphere(levels):
    points, triangles = icosphere(levels)
    return points / np.sqrt(triangle_areas(points, triangles).sum()), triangles


def stiffness(mesh):
    matrix = np.zeros((len(mesh[0]),) * 2)
    for (i, j), weight in zip(*cotangent_weights(*mesh)):
        matrix[[i, j, i, j], [i, j, j, i]] += weight * np.array([1.0, 1.0, -1.0, -1.0])
    return matrix


def regression_loss(mesh, data, noise, centered, time, weights):
    """The loss of the velocity that a linear regression on many states finds, on others."""
    count, random = 24000, np.random.default_rng(1)
    options = {"screening": noise.screening} if noise.model == "matern" else {}
    masses, components = np.diag(point_masses(*mesh)), data.shape[2]
    start = surfacesynthesis.matern_noise(
        mesh, noise_model=noise.model, components=components * count, seed=5, **options
    )  # components are independent, and faster than samples
    start = start.reshape(len(mesh[0]), count, components).swapaxes(0, 1)
    start = noise.scale * np.linalg.solve(masses + noise.smoothing * stiffness(mesh), masses @ start)
    if centered:
        start -= compare_noise.centroids(start, point_masses(*mesh))
    end = data[random.integers(len(data), size=count)]
    states = np.concatenate([((1.0 - time) * start + time * end).reshape(count, -1), np.ones((count, 1))], axis=1)
    targets, half = (end - start).reshape(count, -1), count // 2
    known = states[:half]
    errors = targets[half:] - states[half:] @ np.linalg.solve(known.T @ known, known.T @ targets[:half])
    errors = errors.reshape(half, -1, components)
    return np.einsum("nvc,nvc->", errors, np.matmul(weights, errors)) / (half * components)


def check_linear_velocity():
    """The closed form is what regression finds, lies between 0 and that of a constant, and is integrated exactly."""
    mesh = unit_sphere(1)
    masses, random = point_masses(*mesh), np.random.default_rng(1)
    weights = np.diag(masses) + 0.5 * stiffness(mesh)
    shapes = [mesh[0] * random.uniform(0.6, 1.4, 3) + 0.1 * np.sin(9.0 * mesh[0] @ random.normal(size=(3, 3))) for _ in range(8)]
    shapes = np.array(shapes) - compare_noise.centroids(np.array(shapes), masses)
    signals = np.array([np.sin(9.0 * mesh[0] @ random.normal(size=(3, 1))) for _ in range(8)])
    cases = (
        (shapes, Noise("matern", screening=50.0, smoothing=0.02, scale=20.0), True),
        (shapes, Noise("per_vertex", smoothing=0.02, scale=0.5), True),
        (signals, Noise("white", scale=0.3), False),
        (signals, Noise("per_vertex", scale=2.0), False),
    )
    for data, noise, centered in cases:
        best = LinearVelocity(Modes(*mesh), data, noise, centered)
        for time in (0.2, 0.8):
            expected = regression_loss(mesh, data, noise, centered, time, weights)
            assert abs(best.loss(time, noise.scale) / expected - 1.0) < 0.03, (noise, time, expected)
        times = (np.arange(8000) + 0.5) / 8000.0
        found = best.mean_losses(noise.scale)
        expected = np.reshape([best.loss(time, noise.scale) for time in times], (8, -1)).mean(axis=1)
        assert np.abs(found / expected - 1.0).max() < 1e-5, (noise, found, expected)
        assert (found > 0.0).all() and (found < best.constant_loss(noise.scale)).all(), (noise, found)
        assert best.constant_loss(noise.scale) < best.zero_loss(noise.scale), noise
    only = [LinearVelocity(Modes(*mesh), shapes, cases[0][1], True, *pair).loss(0.3, 20.0) for pair in ((1, 0), (0, 1), (2, 3))]
    assert abs(2.0 * only[0] + 3.0 * only[1] - only[2]) < 1e-9 * only[2], "the loss is linear in its weights"


def check_loss_weights():
    """In units of the data and of their gradients, data that are predicted to be the surface have losses of one."""
    mesh = unit_sphere(2)
    masses, random = point_masses(*mesh), np.random.default_rng(3)
    moved = 0.1 * np.sin(5.0 * mesh[0] @ random.normal(size=(3, 3)))[None]
    moved -= compare_noise.centroids(moved, masses)
    frame = Frame("Position", np.zeros(3), np.ones(3), Noise("matern"), "data")
    samples = network_units(frame, mesh, mesh[0] + moved)
    vertex, jacobian = loss_weights(frame, Modes(*mesh), mesh, samples)
    assert abs(vertex * np.einsum("v,vc->", masses, moved[0] ** 2) / 3.0 - 1.0) < 1e-6
    assert abs(jacobian * np.einsum("vc,vc->", moved[0], stiffness(mesh) @ moved[0]) / 6.0 - 1.0) < 1e-6
    assert loss_weights(frame._replace(prediction="velocity"), Modes(*mesh), mesh, samples) == (1.0, 1.0)


def check_pose_space():
    """Poses have the least residuals, then what is between poses, then noise; a translation changes nothing."""
    mesh = jack(3)
    poses = poses_of_jack(mesh, 24, 0)
    space = PoseSpace(mesh, poses[:12])
    own = space.residuals(poses[12:])
    assert own.max() < 1e-3, own
    assert np.allclose(space.residuals(poses[12:14] + [3.0, -2.0, 1.0]), own[:2], atol=1e-9)
    middles = space.residuals(0.5 * (poses[:12] + poses[12:]))
    options = argparse.Namespace(seeds=1, seed=0)
    dataset = argparse.Namespace(mesh=mesh, samples=poses, masses=point_masses(*mesh))
    (noisy,) = compare_noise.noise_on_mean(options, dataset, 6)
    noisy = space.residuals(noisy)
    assert 3.0 * own.mean() < middles.mean() < 0.5 * noisy.mean(), (own, middles, noisy)
    try:
        PoseSpace(mesh, [mesh[0] * 1.1, mesh[0] * [1.0, 1.2, 0.9]])
    except ValueError as error:
        assert "no middle that stays" in str(error)
    else:
        raise AssertionError("stretched shapes are no poses")


def check_mixture_space():
    """Sums of three Gaussians have small residuals, their means and halves large ones."""
    mesh = icosphere(3)
    mixtures = surfacesynthesis.gaussian_mixtures(mesh, 30, seed=7)
    space = MixtureSpace(mesh, 3000)
    own, half = space.residuals(mixtures), space.residuals(0.5 * mixtures[..., None])
    mean = space.residuals(mixtures.mean(axis=0, keepdims=True))
    assert np.median(own) < 1e-4 and own.mean() < 0.2 * half.mean() and own.mean() < 0.2 * mean.mean(), (own, half, mean)


def check_gaussian():
    """The Gaussian has mean and spread of the training samples, on another triangulation, too, and none of their detail."""
    poses = poses_of_jack(jack(3), 60, 0)
    training = argparse.Namespace(mesh=jack(3), samples=poses, masses=point_masses(*jack(3)), position=True)
    options = argparse.Namespace(seeds=2, seed=0)
    other = argparse.Namespace(mesh=jack(3, 0.3), masses=point_masses(*jack(3, 0.3)), position=True)
    other.samples = poses_of_jack(other.mesh, 60, 0)
    for dataset in (training, other):
        ensembles = list(compare_noise.gaussian(options, training, dataset, 200))
        assert not np.allclose(*ensembles)
        spread = compare_noise.spread(dataset.samples, dataset.masses)
        for samples in ensembles:
            assert samples.shape == (200, len(dataset.mesh[0]), 3)
            assert abs(compare_noise.spread(samples, dataset.masses) / spread - 1.0) < 0.1
            assert np.abs(samples.mean(axis=0) - dataset.samples.mean(axis=0)).mean() < 0.2 * spread
    linear = training.mesh[0] @ [[1.0], [2.0], [3.0]]
    assert np.allclose(compare_noise.carried(linear[None], training.mesh, training.mesh[0] + 0.0)[0], linear)
    middles = training.mesh[0][training.mesh[1]].mean(axis=1)
    assert np.allclose(compare_noise.carried(linear[None], training.mesh, middles)[0], middles @ [[1.0], [2.0], [3.0]])


def check_numbers_of_seeds(folder):
    """Means, deviations, differences and the last losses of a training."""
    rows = [dict.fromkeys(METRICS, value) for value in (1.0, 2.0, 3.0)]
    found = compare_noise.summary(rows)
    assert (found["seeds"], found["unbounded"], found["mmd"], found["cov_deviation"]) == (3, 0, 2.0, 1.0)
    assert np.isnan(compare_noise.summary(rows[:1])["mmd_deviation"])
    found = compare_noise.summary([*rows, dict.fromkeys(METRICS, np.nan)])
    assert found["unbounded"] == 1 and np.isnan(found["mmd"])
    cell = {"mmd": 1.0, "mmd_deviation": 0.3}
    assert compare_noise.difference(cell, {"mmd": 1.9, "mmd_deviation": 0.4}, "mmd") == "none"
    assert abs(compare_noise.difference(cell, {"mmd": 2.1, "mmd_deviation": 0.4}, "mmd") + 1.1) < 1e-12
    assert np.isnan(compare_noise.difference(cell, {"mmd": 2.1, "mmd_deviation": np.nan}, "mmd"))
    table = os.path.join(folder, "losses.csv")
    with open(table, "w", encoding="utf-8") as file:
        file.write("iteration,loss," + ",".join(f"loss_{k}" for k in range(1, 9)) + "\n")
        for row in range(20):
            second = 5.0 if row < 19 else 7.0  # repeated where the iteration has no sample
            file.write(f"{row + 1},1,{row},{second}" + ",0" * 6 + "\n")
    found = compare_noise.last_losses(table)
    assert found[:2].tolist() == [18.5, 7.0] and np.isnan(found[2:]).all(), found


def written_data(data):
    """Datasets of both tasks; 12 poses are 6 references and 6 others."""
    os.makedirs(data)
    shapes = (("armadillo_coarse", jack(3), 12, 0), ("armadillo_poses", jack(3), 12, 0), ("armadillo_test", jack(3, 0.3), 18, 100))
    for name, mesh, count, first in shapes:
        write_dataset(os.path.join(data, name + ".safetensors"), mesh, "Position", poses_of_jack(mesh, count, first))
    signals = (("bunny_coarse", icosphere(2), 12, 0), ("bunny_mixtures", icosphere(2), 12, 0), ("bunny_test", icosphere(3), 8, 100))
    for name, mesh, count, first in signals:
        values = surfacesynthesis.gaussian_mixtures(mesh, count, first_sample=first)[..., None]
        write_dataset(os.path.join(data, name + ".safetensors"), mesh, "Mixture", values)


def tables_of(data, output, *arguments):
    """The printed text and the three tables of a run."""
    command = [sys.executable, os.path.join(HERE, "compare_noise.py"), data, output, *OPTIONS, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    tables = []
    for name in ("metrics", "differences", "losses"):
        with open(os.path.join(output, name + ".csv"), newline="", encoding="utf-8") as file:
            tables.append(list(csv.DictReader(file)))
    return (done.stdout, *tables)


def check_row(row):
    """The numbers of a row are finite and within their ranges."""
    numbers = {name: float(row[name]) for name in METRICS}
    poses = row["task"] == "armadillo"
    assert np.isnan(numbers["stretch"]) != poses, row  # which signals do not have
    assert np.isfinite([value for name, value in numbers.items() if name != "stretch"]).all(), row
    positive = ("mmd", "reverse_mmd", "spacing", "error", "spread", "residual")
    assert all(numbers[name] > 0 for name in positive) and 0 < numbers["cov"] <= 1 and 0 <= numbers["nna"] <= 1, row
    assert row["seeds"] == "1" or all(float(row[name + "_deviation"]) >= 0 for name in positive), row
    if row["noise"] == OTHERS:
        assert 0.4 < numbers["spread"] < 2.5 and not numbers["stretch"] > 0.5, row
        assert numbers["residual"] < (0.01 if poses else 0.1), row
    if row["noise"] == NOISE_ON_MEAN:
        assert 1 < numbers["spread"] < 3, row


def check_rows(data, output):
    """A row for each task, test and noise; losses between 0 and those of a constant; equal models have equal rows."""
    stdout, rows, differences, losses = tables_of(data, output, "--noises", *TRAINED, "--seeds", "2")
    labels = [OTHERS, GAUSSIAN, NOISE_ON_MEAN, *(NOISES[name][0] for name in TRAINED)]
    expected = [(task, label, test) for task in WRITTEN for test in TASKS[task][1][:2] for label in labels]
    expected.remove(("bunny", OTHERS, "bunny_test"))  # whose 8 samples are 6 references and too few others
    assert [(row["task"], row["noise"], row["test"]) for row in rows] == expected, rows
    for row in rows:
        assert tuple(row)[: len(COLUMNS)] == COLUMNS[:2] + ("test", "points", "samples", "seeds", "unbounded"), tuple(row)
        assert row["unbounded"] == "0" and row["samples"] == "6", row
        check_row(row)
    assert {row["seeds"] for row in rows if row["noise"] != OTHERS} == {"2"}
    for task in WRITTEN:
        residuals = {row["noise"]: float(row["residual"]) for row in rows if row["test"] == TASKS[task][1][0]}
        assert residuals[OTHERS] < residuals[GAUSSIAN] and residuals[OTHERS] < 0.3 * residuals[NOISE_ON_MEAN], residuals
    pairs = [(row["noise"], row["against"]) for row in differences if row["test"] == "bunny_test"]
    assert pairs[:2] == [("Matérn, smoothed", "Matérn"), ("white, smoothed", "white")] and len(pairs) == 5, pairs
    cells = [row[name] for row in differences for name in METRICS]
    assert "none" in cells and any(cell not in ("none", "nan") for cell in cells), cells
    assert len(losses) == 2 * len(TRAINED) * 8
    for row in losses:
        linear, constant = float(row["linear"]), float(row["constant"])
        assert 0 < linear < constant and (row["trained"] == "nan" or float(row["trained"]) > 0), row
    assert any(row["trained"] != "nan" for row in losses)
    printed = [line for line in stdout.splitlines() if line.startswith("|")]
    assert len(printed) == 6 + len(rows) + len(differences) + len(losses) and "nan" not in stdout, stdout

    model = os.path.join(output, "bunny_matern_0.safetensors")
    one = ("--tasks", "bunny", "--seeds", "1")
    first = tables_of(data, output, *one, "--noises", "matern")[1]
    again = tables_of(data, os.path.join(output, "again"), *one, "--noises", "--model", "own=" + model)[1:]
    assert [row["noise"] for row in again[0]][-1] == "own" and again[1] == []
    other = tables_of(data, os.path.join(output, "other"), *one, "--noises", "--tests", "bunny_test")[1]
    assert other and {row["test"] for row in other} == {"bunny_test"}
    assert {**again[0][-1], "noise": ""} == {**first[-1], "noise": ""}


def error_of(model, generate):
    try:
        generate(icosphere(2), model, steps=2)
    except surfacesynthesis.SurfaceSynthesisError as error:
        return str(error)
    return "none"


def check_unbounded(data, output):
    """A flow that leaves all bounds gives a row of nan and no error; other errors stop the script."""
    tensors, metadata = read_safetensors(os.path.join(output, "bunny_matern_0.safetensors"))
    arguments, texts = ["--tasks", "bunny", "--noises", "--seeds", "2"], []
    for name, part in (("wild", "velocity.head."), ("wilder", "velocity.")):
        model = os.path.join(output, name + ".safetensors")
        scaled = {key: 1e8 * tensor if key.startswith(part) else tensor for key, tensor in tensors.items()}
        write_safetensors(model, scaled, metadata)
        arguments += ["--model", f"{name}={model}"]
        texts.append(error_of(model, surfacesynthesis.sample_signal))
    assert all(compare_noise.UNBOUNDED in text for text in texts), texts
    stdout, rows, _, losses = tables_of(data, os.path.join(output, "wild"), *arguments)
    found = [row for row in rows if row["noise"].startswith("wild")]
    assert len(found) == 4 and all(row["unbounded"] == "2" and row["mmd"] == "nan" for row in found), found
    assert "| wild | 162 | - | - |" in stdout and all(float(row["linear"]) > 0 for row in losses)
    dataset = argparse.Namespace(position=True, mesh=icosphere(1))
    try:
        compare_noise.generated(argparse.Namespace(steps=2, corrections=None, temperature=1.0), model, dataset, 1, 0)
    except surfacesynthesis.SurfaceSynthesisError:
        return
    raise AssertionError("a model of signals generates no shapes")


def check_relief():
    """On a sphere angles are those of its edges; turns keep them, relief adds to them; half of the surface is measured, the one
    that bends less."""
    points, triangles = icosphere(4)
    mesh, height = to_polydata(mesh_of_triangles(points, triangles)), np.abs(points[:, 2])
    relief = Relief(mesh, ((points, triangles), height))
    low = points[np.unique(relief._edges)]
    assert np.abs(low[:, 2]).max() < 0.52, "half of the area of a sphere is between heights of -1/2 and 1/2"
    lengths = np.linalg.norm(points[relief._edges[0]] - points[relief._edges[1]], axis=1)
    angles = relief.angles(points)
    assert np.allclose(angles, lengths, rtol=0.1) and abs((angles / lengths).mean() - 1.0) < 0.01, angles / lengths
    turned = points[:, [1, 2, 0]] * 3.0
    assert np.allclose(relief.angles(turned), angles, rtol=1e-3)
    rough = points * (1.0 + 0.05 * np.sin(20.0 * points[:, :1]))
    assert relief.angles(rough).mean() > 2.0 * angles.mean()
    assert [with_faces(mesh, n).GetNumberOfCells() for n in (5120, 20000, 80000)] == [5120, 20480, 81920]
    assert 900 <= with_faces(mesh, 1000).GetNumberOfCells() <= 1100
    _, bent = bending(to_polydata(mesh_of_triangles(*jack(4))))
    assert bent.min() < 1e-6 * np.median(bent) and bent.max() > 2.0 * np.median(bent), "what moves in one piece does not bend"


def check_stretch():
    """A mode is found at its wavelength; edges of shapes of twice the size are stretched by log 2; shares of parts add to 1."""
    mesh = icosphere(3)
    modes = Modes(*mesh)
    for mode, interval in ((3, 0), (40, 1), (100, 2), (250, 3)):
        wavelength = 2.0 * np.pi / np.sqrt(modes.values[mode])
        assert np.searchsorted((-0.4, -0.2, -0.15, -0.1), -wavelength) == interval, wavelength
        shares = wavelengths(mesh, modes.vectors[None, :, mode, None] * np.array([1.0, 2.0, 0.0]))
        assert np.allclose(shares, np.eye(5)[interval]), shares
    doubled, edges = logarithms(mesh, 2.0 * mesh[0][None])
    assert np.allclose(doubled, np.log(2.0)) and doubled.shape == (1, edges.shape[1]) and edges.shape[1] == len(mesh[1]) * 3 // 2
    halves = argparse.Namespace(middle=np.flatnonzero(mesh[0][:, 2] < -0.5), ends=[np.flatnonzero(mesh[0][:, 2] > 0.5)])
    wide = mesh[0] * np.where(mesh[0][:, 2:] > 0.5, 1.5, 1.0)
    found = {name: row for name, *row in parts(mesh, halves, wide[None], mesh[0][None])}
    assert abs(sum(row[0] for row in found.values()) - 1.0) < 1e-12 and abs(sum(row[3] for row in found.values()) - 1.0) < 1e-12
    assert abs(found["ends"][1] - np.log(1.5)) < 1e-12 and found["middle"][1] == 0.0 and found["joints"][3] > 0.0


def check_noises():
    """Each kind is there with and without smoothing, and all differ in the parameters of the training."""
    assert len(NOISES) == 2 * len(KINDS) and len({str(parameters) for _, parameters in NOISES.values()}) == len(NOISES)
    assert len({label for label, _ in NOISES.values()}) == len(NOISES)
    assert sum(parameters["noise_smoothing"] > 0 for _, parameters in NOISES.values()) == len(KINDS)


def check(folder):
    shutil.rmtree(folder, ignore_errors=True)  # trainings go on from their checkpoints
    data, output = os.path.join(folder, "data"), os.path.join(folder, "output")
    written_data(data)
    check_noises()
    check_relief()
    check_stretch()
    check_numbers_of_seeds(folder)
    check_linear_velocity()
    check_loss_weights()
    check_pose_space()
    check_mixture_space()
    check_gaussian()
    check_rows(data, output)
    check_unbounded(data, output)


if __name__ == "__main__":
    check(sys.argv[1])
    print("passed")
