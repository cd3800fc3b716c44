# SPDX-License-Identifier: BSD-3-Clause
"""Trains for a few steps, as a test: ``test_training.py PROGRAM FOLDER``. Run by CTest."""

import os
import subprocess
import sys

import numpy as np

import surfacesynthesis
from smoothed_curvature import TIME, smoothed_curvature
from surfacesynthesis.files.polygons import mesh_of_triangles, to_polydata

HERE = os.path.dirname(os.path.abspath(__file__))


def icosphere(levels):
    """Points and triangles of a sphere of radius 1."""
    golden = 0.5 * (1.0 + np.sqrt(5.0))
    points = [(a, b * golden, 0.0) for a in (-1, 1) for b in (1, -1)]
    points += [(0.0, a, b * golden) for a in (-1, 1) for b in (1, -1)]
    points += [(a * golden, 0.0, b) for a in (1, -1) for b in (-1, 1)]
    points = [np.array(point) for point in points]
    triangles = [(i, j, k) for i in range(12) for j in range(i) for k in range(j)
                 if all(abs(np.linalg.norm(points[a] - points[b]) - 2.0) < 1e-9 for a, b in ((i, j), (j, k), (k, i)))]
    triangles = [t if np.linalg.det([points[v] for v in t]) > 0 else t[::-1] for t in triangles]
    for _ in range(levels):
        middles, finer = {}, []
        for triangle in triangles:
            m = []
            for a, b in zip(triangle, triangle[1:] + triangle[:1]):
                key = (min(a, b), max(a, b))
                if key not in middles:
                    middles[key] = len(points)
                    points.append(points[a] + points[b])
                m.append(middles[key])
            (a, b, c), (ab, bc, ca) = triangle, m
            finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        triangles = finer
        points = [point / np.linalg.norm(point) for point in points]
    return np.array(points) / np.linalg.norm(points[0]), np.array(triangles)


def check_values():
    """On a sphere of area 1, one step of heat flow scales the points by 1 / (1 + 2 t / R^2)."""
    points, triangles = icosphere(3)
    radius = 1.0 / np.sqrt(4.0 * np.pi)
    expected = np.sqrt(TIME) / radius / (1.0 + 2.0 * TIME / radius**2)
    found = smoothed_curvature(7.0 * points + 3.0, triangles)
    assert abs(found.mean() / expected - 1.0) < 0.005, (found.mean(), expected)
    # the lumped mass of a point with five triangles is a little small
    assert np.allclose(found, expected, rtol=0.05), (found.min(), found.max(), expected)
    assert np.allclose(smoothed_curvature(points, triangles[:, ::-1]), -found), "turned inside out"


def check_training(program, folder):
    points, triangles = icosphere(3)
    points = points * np.array([1.0, 0.6, 0.4]) * (1.0 + 0.15 * np.sin(5.0 * points[:, :1]))
    os.makedirs(folder, exist_ok=True)
    names = ("surface.off", "data.safetensors", "model.safetensors", "loss.csv")
    surface, data, model, losses = (os.path.join(folder, name) for name in names)
    surfacesynthesis.write_mesh(to_polydata(mesh_of_triangles(points, triangles)), surface)
    subprocess.run([sys.executable, os.path.join(HERE, "smoothed_curvature.py"), surface, data], check=True)
    subprocess.run([program, model, losses, "80", data, data], check=True)
    errors = np.loadtxt(losses, delimiter=",", skiprows=1)[:, 1]
    assert len(errors) == 80 and np.all(np.isfinite(errors))
    assert errors[-10:].mean() < 0.7 * errors[:10].mean(), (errors[:10], errors[-10:])
    predicted = surfacesynthesis.poisson_net((points, triangles), model).values[:, 0]
    truth = smoothed_curvature(points, triangles)
    assert np.corrcoef(predicted, truth)[0, 1] > 0.4
    failed = subprocess.run([program, model, losses, "1", surface], capture_output=True, text=True, check=False)
    assert failed.returncode == 1 and "safetensors rule" in failed.stderr, failed


if __name__ == "__main__":
    check_values()
    check_training(sys.argv[1], sys.argv[2])
    print("passed")
