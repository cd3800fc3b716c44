#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Time and memory of the statistics of many shapes: vtkEnsembleStatistics.

    PYTHONPATH=<build folder>/lib/python3 python3 thousand_shapes.py [SAMPLES [POINTS]]

SAMPLES shapes (1,000 by default) of a sphere of about POINTS points (100,000 by default), float32, each moved by a mixture of 20
modes and noise. Prints a row of a table for the mean and deviation, three quantiles, ten modes, and all modes, each in a process
of its own: seconds, processor seconds, and the peak memory in MiB beside the samples and Python.
"""

import resource
import subprocess
import sys
import time

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet, vtkPolyData
from vtkmodules.vtkFiltersSources import vtkSphereSource

from surfacesynthesis import vtkEnsembleStatistics

#: Quantiles and number of modes of each row.
CASES = {
    "mean and deviation": ((), 0),
    "quantiles 0.05, 0.5, 0.95": ((0.05, 0.5, 0.95), 0),
    "10 modes": ((), 10),
    "all modes": ((), -1),
}


def shapes(samples, points):
    """A composite dataset of shapes that share their polygons."""
    side = round((points / 2) ** 0.5)
    source = vtkSphereSource()
    source.SetThetaResolution(2 * side)
    source.SetPhiResolution(side)
    source.Update()
    sphere = source.GetOutput()
    base = vtk_to_numpy(sphere.GetPoints().GetData())
    random = np.random.default_rng(1)
    modes = 0.1 * random.standard_normal((20, *base.shape), dtype=np.float32)
    blocks = vtkMultiBlockDataSet()
    for sample in range(samples):
        weights = random.standard_normal(20, dtype=np.float32) / np.arange(1, 21, dtype=np.float32)
        moved = base + np.tensordot(weights, modes, 1) + 0.01 * random.standard_normal(base.shape, dtype=np.float32)
        shape, places = vtkPolyData(), vtkPoints()
        places.SetData(numpy_to_vtk(np.ascontiguousarray(moved, np.float32), deep=True))
        shape.SetPoints(places)
        shape.SetPolys(sphere.GetPolys())
        blocks.SetBlock(sample, shape)
    return blocks


def measure(case, samples, points):
    """Prints the row of a case."""
    quantiles, modes = CASES[case]
    blocks = shapes(samples, points)
    algorithm = vtkEnsembleStatistics()
    algorithm.SetInputDataObject(blocks)
    algorithm.SetNumberOfQuantiles(len(quantiles))
    for k, quantile in enumerate(quantiles):
        algorithm.SetQuantile(k, quantile)
    algorithm.SetNumberOfModes(modes)
    before, wall, cpu = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, time.perf_counter(), time.process_time()
    algorithm.Update()
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    made = algorithm.GetOutputDataObject(1).GetNumberOfRows()
    if not algorithm.GetOutputDataObject(0).GetNumberOfPoints():
        raise SystemExit(f"{case}: the filter has failed")
    print(f"| {case}{f' ({made})' if modes < 0 else ''} | {wall:.1f} s | {cpu:.1f} s | {(peak - before) / 1024:,.0f} |", flush=True)


def main():
    samples = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    points = int(sys.argv[2]) if len(sys.argv) > 2 else 100000
    if len(sys.argv) > 3:
        measure(sys.argv[3], samples, points)
        return
    print(f"{samples:,} shapes of about {points:,} points, {samples * points * 12 / 2**20:,.0f} MiB of coordinates")
    print("| statistics | time | processor time | memory beside the samples, MiB |")
    print("|---|---:|---:|---:|", flush=True)
    for case in CASES:
        subprocess.run([sys.executable, __file__, str(samples), str(points), case], check=True)


if __name__ == "__main__":
    main()
