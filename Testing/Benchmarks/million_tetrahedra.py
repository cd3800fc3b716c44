#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Time and memory of a random field on a million tetrahedra, with multigrid and with a factor.

    PYTHONPATH=<build folder>/lib/python3 python3 million_tetrahedra.py [CELLS]

The cube has CELLS^3 cells (55 by default) of six tetrahedra each. Prints a row of a table for each solver: processor seconds
of the first sample, and the peak memory of the process in MiB, which includes Python and the mesh.
"""

import itertools
import resource
import sys

import numpy as np

import surfacesynthesis


def cube(cells):
    """The unit cube: points [V, 3] and tetrahedra [T, 4]."""
    side = cells + 1
    corners = np.stack(np.meshgrid(*3 * [np.arange(side)], indexing="ij"), axis=-1).reshape(-1, 3)
    lower = corners[(corners < cells).all(axis=1)]
    tetrahedra = []
    for path in itertools.permutations(range(3)):
        steps = np.eye(3, dtype=int)[list(path)]
        along = np.vstack((np.zeros((1, 3), int), np.cumsum(steps, axis=0)))
        ids = (lower[:, None, :] + along) @ [side * side, side, 1]
        tetrahedra.append(ids if np.linalg.det(steps) > 0.0 else ids[:, [0, 1, 3, 2]])
    return corners / cells, np.concatenate(tetrahedra)


def used():
    """Processor seconds and peak MiB of this process."""
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def main():
    mesh = cube(int(sys.argv[1]) if len(sys.argv) > 1 else 55)
    print(f"{len(mesh[0]):,} points, {len(mesh[1]):,} tetrahedra; {used()[1]:.0f} MiB before the fields")
    print("| solver | processor time of the first sample | peak memory, MiB |")
    print("|---|---:|---:|")
    for solver, limit in (("multigrid", 100), ("factor", None)):
        before = used()[0]
        surfacesynthesis.matern_noise(mesh, range=0.2, samples=1, memory_limit=limit)
        after, peak = used()
        print(f"| {solver} | {after - before:.1f} s | {peak:,.0f} |", flush=True)


if __name__ == "__main__":
    main()
