# SPDX-License-Identifier: BSD-3-Clause
"""Peak memory of a whole process in which vtkGeometricTextureSynthesizer makes a million triangles.

Three levels of the published network with random weights, on a sphere of about 64,000 triangles with a point and a cell
array. Usage: PYTHONPATH=<build folder>/lib/python3 python3 geometric_texture_memory.py [triangles of the sphere]
"""

import json
import os
import resource
import sys
import tempfile
import time

import numpy as np
import surfacesynthesis
from surfacesynthesis.safetensors import write_safetensors
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkFiltersSources import vtkSphereSource

LEVELS = 3


def published_texture(path):
    """Random weights of the published sizes: min(32 * 2^level, 128) channels, halved down to 32."""
    random = np.random.default_rng(1)
    tensors = {}
    for level in range(LEVELS):
        most = min(32 * 2**level, 128)
        channels = [4, *(max(most // 2**k, 32) for k in range(5)), 3]
        for k in range(6):
            inputs = channels[k] if k == 0 else 2 * channels[k]
            scale = (0.02 if k == 5 else 1.0) / np.sqrt(inputs)
            name = f"levels.{level}.layers.{k}." + ("conv" if k == 5 else "0.conv")
            tensors[name + ".weight"] = random.uniform(-scale, scale, (channels[k + 1], inputs, 1))
            tensors[name + ".bias"] = random.uniform(-scale, scale, channels[k + 1])
    description = {
        "levels": LEVELS,
        "layers": 7,
        "start_channels": 32,
        "least_channels": 32,
        "most_channels": 128,
        "noise_amplitude": 0.1,
        "name": "random",
    }
    described = {
        "architecture": "geometric_texture",
        "format_version": "1",
        "geometric_texture": json.dumps(description),
    }
    write_safetensors(path, tensors, described)
    return path


def sphere(triangles):
    source = vtkSphereSource()
    rings = round(np.sqrt(triangles / 4))
    source.SetThetaResolution(2 * rings)
    source.SetPhiResolution(rings + 1)
    source.Update()
    mesh = source.GetOutput()
    for data, count in (
        (mesh.GetPointData(), mesh.GetNumberOfPoints()),
        (mesh.GetCellData(), mesh.GetNumberOfCells()),
    ):
        array = numpy_to_vtk(np.arange(count, dtype=np.float64), deep=True)
        array.SetName("Number")
        data.AddArray(array)
    return mesh


def peak_mib():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def main(triangles):
    mesh = sphere(triangles)
    with tempfile.TemporaryDirectory() as folder:
        model = published_texture(os.path.join(folder, "random.safetensors"))
        surfacesynthesis.geometric_texture(sphere(100), model)  # LibTorch and the model's own memory
        before, started, worked = peak_mib(), time.perf_counter(), time.process_time()
        output = surfacesynthesis.geometric_texture(mesh, model)
    seconds, processor = time.perf_counter() - started, time.process_time() - worked
    print(f"{mesh.GetNumberOfPolys():,} triangles to {output.GetNumberOfPolys():,}")
    print(f"{seconds:.2f} s, {processor:.2f} s of processor time")
    print(f"peak of the process {peak_mib():,.0f} MiB, {before:,.0f} MiB before")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 64000)
