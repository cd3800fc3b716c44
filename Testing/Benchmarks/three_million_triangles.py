# SPDX-License-Identifier: BSD-3-Clause
"""Time and peak memory of one function of the package on a bumpy torus of 3 million triangles.

Usage: PYTHONPATH=<build folder>/lib/python3 python3 three_million_triangles.py FUNCTION [triangles]; the address space is
limited to 14 GB. The models are those of Examples/Models.
"""

import os
import resource
import sys
import time

import numpy as np
import surfacesynthesis as ss

MODELS = os.path.join(os.path.dirname(__file__), "..", "..", "Examples", "Models")


def bumpy_torus(triangles):
    """Points and triangles of a closed surface of genus 1, of even triangles."""
    long = round(np.sqrt(triangles))
    short = round(triangles / 2 / long)
    u, v = np.meshgrid(np.arange(long), np.arange(short), indexing="ij")
    a, b = 2 * np.pi * u / long, 2 * np.pi * v / short
    radius = 40 + 2 * np.sin(9 * a) * np.cos(7 * b) + np.sin(23 * a + 5 * b)
    points = np.stack([(100 + radius * np.cos(b)) * np.cos(a), (100 + radius * np.cos(b)) * np.sin(a), radius * np.sin(b)], -1)
    corner = u * short + v
    right, up = (u + 1) % long * short + v, u * short + (v + 1) % short
    both = (u + 1) % long * short + (v + 1) % short
    cells = np.stack([corner, right, both, corner, both, up], -1).reshape(-1, 3)
    return points.reshape(-1, 3), cells


def model(name):
    return os.path.join(MODELS, name + ".safetensors")


FUNCTIONS = {
    "fit_levels": lambda mesh: ss.fit_levels(mesh),
    "geometric_texture_distance": lambda mesh: ss.geometric_texture_distance(mesh, mesh),
    "geometric_texture": lambda mesh: ss.geometric_texture(mesh, model("spikes"), end_level=0),
    "tetrahedralize": lambda mesh: ss.tetrahedralize(mesh, time_limit=900),
    "sample_signal": lambda mesh: ss.sample_signal(mesh, model("bunny_mixtures"), steps=1),
    "deform": lambda mesh: ss.deform(mesh, model("armadillo_poses"), steps=1),
    "poses": lambda mesh: ss.poses(mesh, 1),
}


def main():
    function = FUNCTIONS[sys.argv[1]]
    mesh = bumpy_torus(int(sys.argv[2]) if len(sys.argv) > 2 else 3_000_000)
    limit = 14 * 10**9
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    begin, processor = time.perf_counter(), time.process_time()
    try:
        function(mesh)
        end = "done"
    except Exception as error:  # the message is the result, with the time and memory that it took
        end = f"{type(error).__name__}: {error}"
    seconds, processor = time.perf_counter() - begin, time.process_time() - processor
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024**2
    print(f"{sys.argv[1]}, {len(mesh[1]):,} triangles: {seconds:.0f} s ({processor:.0f} s of processor), {peak:.1f} GiB; {end}")


if __name__ == "__main__":
    main()
