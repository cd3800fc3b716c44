#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Times the plain SciPy assembly of mass and cotangent stiffness, as the reference for the library.

usage: OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python3 scipy_reference.py mesh.off [repetitions]

The mesh is an OFF file of triangles; SurfaceSynthesisBenchmarks --write-mesh=603000:mesh.off writes those of the
benchmarks. Prints medians in seconds. SciPy has no sparse Cholesky: the references of factorization and solves are those
of CHOLMOD, in SurfaceSynthesisBenchmarks.
"""
import statistics
import sys
import time

import numpy as np
import scipy.sparse


def read_off(path):
    """Points [V, 3] and triangles [F, 3] of an OFF file whose faces are all triangles."""
    with open(path, encoding="ascii") as file:
        if file.readline().strip() != "OFF":
            raise ValueError(f"{path} is not an OFF file")
        points, triangles, _ = map(int, file.readline().split())
        numbers = np.fromfile(file, dtype=float, sep=" ")
    faces = numbers[3 * points :].reshape(triangles, 4)
    return numbers[: 3 * points].reshape(points, 3), faces[:, 1:].astype(np.int32)


def assemble(points, triangles):
    """Lumped mass [V] and cotangent stiffness [V, V] in compressed columns."""
    size = len(points)
    corners = points[triangles]
    rows, columns, values = [], [], []
    double_area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    for c in range(3):
        i, j = triangles[:, (c + 1) % 3], triangles[:, (c + 2) % 3]
        a = corners[:, (c + 1) % 3] - corners[:, c]
        b = corners[:, (c + 2) % 3] - corners[:, c]
        weight = 0.5 * np.einsum("ij,ij->i", a, b) / double_area
        rows += [i, j, i, j]
        columns += [j, i, i, j]
        values += [-weight, -weight, weight, weight]
    stiffness = scipy.sparse.coo_matrix(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=(size, size)
    ).tocsc()
    mass = np.bincount(triangles.ravel(), np.repeat(double_area / 6.0, 3), minlength=size)
    return mass, stiffness


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    points, triangles = read_off(sys.argv[1])
    times, cpu_times = [], []
    for _ in range(int(sys.argv[2]) if len(sys.argv) > 2 else 5):
        start, cpu_start = time.perf_counter(), time.process_time()
        mass, stiffness = assemble(points, triangles)
        times.append(time.perf_counter() - start)
        cpu_times.append(time.process_time() - cpu_start)
    # The result must be the operator, not just any matrix.
    assert abs(stiffness @ np.ones(len(points))).max() < 1e-9 * abs(stiffness).max()
    assert mass.min() >= 0.0
    print(
        f"{len(points)} vertices: SciPy assembly {statistics.median(times):.4f} s, "
        f"CPU {statistics.median(cpu_times):.4f} s (medians of {len(times)})"
    )


if __name__ == "__main__":
    main()
