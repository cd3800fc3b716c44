# SPDX-License-Identifier: BSD-3-Clause
"""Compares all kinds of noise on tiny datasets, as a test: ``test_compare_noise.py FOLDER``. Run by CTest."""

import csv
import os
import shutil
import subprocess
import sys

import numpy as np

import surfacesynthesis
from compare_noise import COLUMNS, NOISES, TASKS
from surfacesynthesis.files.polygons import mesh_of_triangles, to_polydata
from test_training import HERE, icosphere

OPTIONS = ("--iterations", "3", "--width", "8", "--blocks", "1", "--batch", "2", "--samples", "5", "--steps", "2")


def write_dataset(path, levels, samples, seed):
    """Stretched spheres when the file is one of poses, else waves."""
    points, triangles = icosphere(levels)
    random = np.random.default_rng(seed)
    if "armadillo" in path:
        name, values = "Position", [points * random.uniform(0.7, 1.3, 3) for _ in range(samples)]
    else:
        name, values = "Mixture", [np.sin(points @ random.normal(size=(3, 1))) for _ in range(samples)]
    mesh = to_polydata(mesh_of_triangles(points, triangles))
    surfacesynthesis.write_signal_dataset(path, [(mesh, np.stack(values))], name)


def check(folder):
    """A row for each task, noise and test; its numbers are finite and within their ranges."""
    shutil.rmtree(folder, ignore_errors=True)  # trainings go on from their checkpoints
    data, output = os.path.join(folder, "data"), os.path.join(folder, "output")
    os.makedirs(data)
    expected = []
    for task, (training, tests) in sorted(TASKS.items()):
        present = tests[:2]  # a third file may be absent
        for level, name in enumerate(present, 1):
            write_dataset(os.path.join(data, name + ".safetensors"), level, 6, level)
        assert training in present
        expected += [(task, noise[0], name) for noise in NOISES.values() for name in present]
    command = [sys.executable, os.path.join(HERE, "compare_noise.py"), data, output, *OPTIONS]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    with open(os.path.join(output, "metrics.csv"), newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [(row["task"], row["noise"], row["test"]) for row in rows] == expected, rows
    for row in rows:
        assert tuple(row) == COLUMNS
        assert int(row["points"]) == len(icosphere(1 + TASKS[row["task"]][1].index(row["test"]))[0]), row
        mmd, spacing, cov, nna, error = (float(row[name]) for name in COLUMNS[4:])
        assert np.isfinite([mmd, spacing, cov, nna, error]).all(), row
        assert mmd > 0 and spacing > 0 and error > 0 and 0 < cov <= 1 and 0 <= nna <= 1, row
    printed = [line for line in done.stdout.splitlines() if line.startswith("|")]
    assert len(printed) == 2 + len(rows) and "nan" not in done.stdout, done.stdout
    for task in TASKS:
        for noise in NOISES:
            losses = np.loadtxt(os.path.join(output, f"{task}_{noise}.csv"), delimiter=",", skiprows=1)
            assert len(losses) == 3 and np.isfinite(losses).all(), (task, noise, losses)


if __name__ == "__main__":
    check(sys.argv[1])
    print("passed")
