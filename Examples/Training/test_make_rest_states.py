# SPDX-License-Identifier: BSD-3-Clause
"""Tests make_rest_states.py on an ellipsoid: ``test_make_rest_states.py FOLDER``. Run by CTest."""

import os
import shutil
import sys

import numpy as np
from vtkmodules.vtkFiltersSources import vtkSphereSource

import make_rest_states
import surfacesynthesis
from make_datasets import FIRST_TEST_SAMPLE, points_and_triangles
from surfacesynthesis.files.polygons import mesh_of_triangles, to_polydata

OPTIONS = ["--name", "egg", "--drops", "3", "--test-drops", "2", "--points", "300", "--surface-points", "50"]


def egg():
    """An ellipsoid with three different axes."""
    source = vtkSphereSource()
    source.SetThetaResolution(40)
    source.SetPhiResolution(40)
    source.SetOutputPointsPrecision(1)
    source.Update()
    points, triangles = points_and_triangles(source.GetOutput())
    return to_polydata(mesh_of_triangles(points * (1.6, 1.2, 0.8), triangles))


def times(folder):
    return {name: os.stat(os.path.join(folder, name)).st_mtime_ns for name in sorted(os.listdir(folder))}


def check_training(folder, tetrahedra):
    """Each triangulation has the states of the drops that it would have alone, of points that are near those of the others."""
    path = os.path.join(folder, "egg_rest.safetensors")
    sources = surfacesynthesis.read_signal_dataset(path).sources
    with open(path, "rb") as file:
        assert b"elastic rest states of egg.vtp" in file.read(4096)
    assert len(sources) == 1 + len(make_rest_states.TRIANGULATIONS), len(sources)
    counts = [len(source.points) for source in sources]
    assert len(set(counts)) == len(counts) and 2 * counts[3] < counts[0] < 0.6 * max(counts), counts
    alone = surfacesynthesis.rest_states(
        (sources[3].points.astype(float), sources[3].triangles), samples=3, tetrahedra=tetrahedra
    )
    for source in sources:
        assert source.signals.shape == (3, len(source.points), 3), source.signals.shape
        heights = source.signals[:, :, 2]
        assert np.ptp(heights.min(axis=1)) < 0.1, "all lie on one floor"
        assert 0.5 < np.ptp(heights, axis=1).min() < 0.9, "flat, on the two longer axes"
        moved = source.signals - source.points
        nearest = np.linalg.norm(sources[3].points[:, None] - source.points[None], axis=2).argmin(axis=1)
        assert np.abs(moved[:, nearest] - (sources[3].signals - sources[3].points)).max() < 0.5
    assert np.abs(sources[3].signals - alone).max() < 0.02, np.abs(sources[3].signals - alone).max()
    return sources[0]


def check_test(folder, first, tetrahedra):
    (source,) = surfacesynthesis.read_signal_dataset(os.path.join(folder, "egg_rest_test.safetensors")).sources
    assert np.array_equal(source.points, first.points) and source.signals.shape[0] == 2
    mesh = source.points.astype(float), source.triangles
    other = surfacesynthesis.rest_states(mesh, samples=2, first_sample=FIRST_TEST_SAMPLE, tetrahedra=tetrahedra)
    assert np.abs(source.signals - other).max() < 0.02


def main():
    folder = sys.argv[1]
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    surface = os.path.join(folder, "egg.vtp")
    surfacesynthesis.write_mesh(egg(), surface)
    make_rest_states.main([surface, folder, *OPTIONS])
    tetrahedra = surfacesynthesis.read_mesh(os.path.join(folder, "egg_tetrahedra.vtu"))
    first = check_training(folder, tetrahedra)
    check_test(folder, first, tetrahedra)
    parts = os.path.join(folder, "egg_parts")
    before = times(parts)
    assert len(before) == 2, before
    make_rest_states.main([surface, folder, *OPTIONS])
    assert times(parts) == before, "no drop is made twice"
    make_rest_states.main([surface, folder, *OPTIONS, "--surface-points", "60"])
    assert len(times(parts)) == 4, "other tetrahedra, other drops"
    print("passed")


if __name__ == "__main__":
    main()
