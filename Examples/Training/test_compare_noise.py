# SPDX-License-Identifier: BSD-3-Clause
"""Compares all kinds of noise on tiny datasets, as a test: ``test_compare_noise.py FOLDER``. Run by CTest."""

import csv
import os
import shutil
import subprocess
import sys

import numpy as np

import surfacesynthesis
from compare_noise import COLUMNS, NOISE_ON_MEAN, NOISES, OTHERS, TASKS
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
    """A row for each task, test and noise; its numbers are finite and within their ranges."""
    shutil.rmtree(folder, ignore_errors=True)  # trainings go on from their checkpoints
    data, output = os.path.join(folder, "data"), os.path.join(folder, "output")
    os.makedirs(data)
    expected = []
    for task, (training, tests) in sorted(TASKS.items()):
        present = tests[:2]  # a third file may be absent
        for level, name in enumerate(present, 1):
            write_dataset(os.path.join(data, name + ".safetensors"), level, 6 if level == 1 else 10, level)
        assert training in present
        labels = [NOISE_ON_MEAN, *(noise[0] for noise in NOISES.values())]
        expected += [(task, label, present[0]) for label in labels]  # whose 6 samples are 5 references and too few others
        expected += [(task, label, present[1]) for label in (OTHERS, *labels)]
    command = [sys.executable, os.path.join(HERE, "compare_noise.py"), data, output, *OPTIONS]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    with open(os.path.join(output, "metrics.csv"), newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [(row["task"], row["noise"], row["test"]) for row in rows] == expected, rows
    for row in rows:
        assert tuple(row) == COLUMNS
        assert int(row["points"]) == len(icosphere(1 + TASKS[row["task"]][1].index(row["test"]))[0]), row
        mmd, spacing, cov, nna, error, spread, stretch = (float(row[name]) for name in COLUMNS[4:])
        assert np.isfinite([mmd, spacing, cov, nna, error, spread]).all(), row
        assert mmd > 0 and spacing > 0 and error > 0 and spread > 0 and 0 < cov <= 1 and 0 <= nna <= 1, row
        assert stretch > 0 if row["task"] == "armadillo" else np.isnan(stretch), row  # which signals do not have
        assert row["noise"] != OTHERS or (0.5 < spread < 2 and not stretch > 0.5), row
        assert row["noise"] != NOISE_ON_MEAN or 1 < spread < 3, row
    printed = [line for line in done.stdout.splitlines() if line.startswith("|")]
    assert len(printed) == 2 + len(rows) and "nan" not in done.stdout, done.stdout
    for task in TASKS:
        for noise in NOISES:
            losses = np.loadtxt(os.path.join(output, f"{task}_{noise}.csv"), delimiter=",", skiprows=1)
            assert len(losses) == 3 and np.isfinite(losses).all(), (task, noise, losses)


if __name__ == "__main__":
    check(sys.argv[1])
    print("passed")
