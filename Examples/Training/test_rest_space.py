# SPDX-License-Identifier: BSD-3-Clause
"""Tests rest_space.py on flattened balls: ``test_rest_space.py FOLDER``. Run by CTest."""

import csv
import os
import shutil
import sys

import numpy as np
from vtkmodules.vtkFiltersCore import vtkMassProperties
from vtkmodules.vtkFiltersSources import vtkSphereSource

import rest_space
import surfacesynthesis
from make_datasets import points_and_triangles
from surfacesynthesis.files.polygons import mesh_of_triangles, to_polydata

UP = np.array([0.0, 1.0, 0.0])
FLAT = -0.7


def ball(resolution):
    """A ball of radius 1, y upwards, as arrays."""
    source = vtkSphereSource()
    source.SetRadius(1.0)
    source.SetThetaResolution(resolution)
    source.SetPhiResolution(resolution)
    source.SetOutputPointsPrecision(1)
    source.Update()
    points, triangles = points_and_triangles(source.GetOutput())
    return points[:, [1, 2, 0]], triangles


def lying(points, count, first=0):
    """Balls with a flat bottom, turned about the vertical axis and a little longer along one direction."""
    random = np.random.default_rng(first)
    shapes = np.tile(points, (count, 1, 1))
    shapes[:, :, 0] *= 1.0 + 0.1 * random.standard_normal((count, 1))
    shapes[:, :, 1] = np.maximum(shapes[:, :, 1], FLAT)
    return shapes


def close(found, expected, tolerance):
    assert abs(found - expected) <= tolerance, (found, expected)


def check_volumes(mesh):
    points, triangles = mesh
    properties = vtkMassProperties()
    properties.SetInputData(to_polydata(mesh_of_triangles(points, triangles)))
    close(rest_space.volumes(triangles, points[None])[0], properties.GetVolume(), 1e-6)
    first, second = rest_space.volumes(triangles, np.stack([points + 5.0, 2.0 * points]))
    close(second / first, 8.0, 1e-9)


def check_depths(mesh):
    """A bump of a known depth below a flat bottom is found, whatever the height of the shape; a flat bottom has none."""
    points, _ = mesh
    shapes = lying(points, 2)
    body = rest_space.RestStates.__new__(rest_space.RestStates)
    body.mesh, body.samples = mesh, shapes
    part = rest_space.touching_part(body, UP)
    assert 0.05 < part < 0.3, part
    lowest = shapes[1, :, 1].argmin()
    shapes[1, lowest, 1] -= 0.2
    shapes[1] += 3.0
    flat, bump = rest_space.depths(mesh, shapes, UP, 0.9 * part)
    close(flat, 0.0, 1e-12)
    close(bump, 0.2 / np.linalg.norm(np.ptp(points, axis=0)), 1e-12)


def check_principal_samples(path):
    training = rest_space.RestStates(path)
    samples = rest_space.principal_samples(training.samples, 400, seed=3)
    close(np.abs(samples.mean(axis=0) - training.samples.mean(axis=0)).max(), 0.0, 0.03)
    assert np.array_equal(samples, rest_space.principal_samples(training.samples, 400, seed=3))
    assert not np.array_equal(samples, rest_space.principal_samples(training.samples, 400, seed=4))


def check_modes(mesh):
    """Two modes of which one occurs three times as often, and shapes of only one of them."""
    points, _ = mesh
    long, wide = points * (1.5, 1.0, 1.0), points * (1.0, 1.0, 1.5)
    body = rest_space.RestStates.__new__(rest_space.RestStates)
    body.mesh, body.samples = mesh, np.stack([long, long + 4.0, wide, long])
    modes = rest_space.Modes(body, body)
    close(modes.difference(body.samples + 1.0), 0.0, 1e-12)
    close(modes.difference(body.samples[:2]), 0.25, 1e-12)
    close(modes.difference(body.samples[2:3]), 0.75, 1e-12)


def check_table(folder, mesh):
    """The rows of a model that has hardly learnt anything, on two triangulations."""
    paths = [os.path.join(folder, name) for name in ("train.safetensors", "test.safetensors", "model.safetensors")]
    for path, count, first in zip(paths, (24, 8), (0, 1)):
        surfacesynthesis.write_signal_dataset(path, [(mesh, lying(mesh[0], count, first).astype(np.float32))], "Position")
    check_principal_samples(paths[0])
    surfacesynthesis.train_flow_matching(dataset=paths[0], model=paths[2], iterations=3, width=8, blocks=1, batch=4)
    other, table = os.path.join(folder, "ball.vtp"), os.path.join(folder, "table.csv")
    surfacesynthesis.write_mesh(to_polydata(mesh_of_triangles(*ball(24))), other)
    options = ["--surface", other, "--up", "0", "1", "0", "--seeds", "2", "--steps", "2", "--csv", table]
    options += ["--settle", "--surface-points", "80"]
    rest_space.main([paths[2], *paths[:2], *options])
    with open(table, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    names = ["rest states", "principal components", "model", "settled", "model", "settled"]
    assert [row["samples of"] for row in rows] == names, rows
    assert len({row["triangles"] for row in rows}) == 2, rows
    real, _, model, settled, fine, _ = ({name: float(row[name]) for name in rest_space.COLUMNS} for row in rows)
    assert real["flat"] == 1.0 and real["same_volume"] == 1.0 and real["coverage"] > 0.3, real
    assert model["mmd"] > 2.0 * real["mmd"], (model, real)
    assert np.isfinite(list(fine.values())).all(), fine
    assert settled["flat"] == 1.0 and settled["depth"] < model["depth"], (settled, model)


def main():
    folder = sys.argv[1]
    shutil.rmtree(folder, ignore_errors=True)  # no training goes on from an earlier one
    os.makedirs(folder)
    mesh = ball(16)
    check_volumes(mesh)
    check_depths(mesh)
    check_modes(mesh)
    check_table(folder, mesh)
    print("passed")


if __name__ == "__main__":
    main()
