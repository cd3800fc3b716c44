#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Two sheets for a test by eye: which synthesized texture belongs to which example?

    xvfb-run -a python3 pair_textures.py --output DIR

Ten textures of geometric_texture_from_example(): spikes, knobs and the labyrinth, which the shipped models were learned from;
the shell of the armadillo; bark and dunes, random fields; and the four scans of scan_textures.py. Writes

    examples.png       the examples, A to J
    synthesized.png    the textures on a bear, a knot and an eight, 1 to 10, in another order
    key.csv            which number belongs to which letter

Give the two pictures to someone who has not seen the key. Surfaces come from Debian's packages libcgal-demo and mricron-data.
"""

import argparse
import csv
import functools
import os
import string
import sys

import numpy as np

EXAMPLES = os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir)
sys.path.insert(0, os.path.join(EXAMPLES, "Python"))

import gallery_rendering as rendering  # noqa: E402
import scan_textures  # noqa: E402
import surfacesynthesis  # noqa: E402
import textures_from_example as examples  # noqa: E402
from make_datasets import surface  # noqa: E402
from surfacesynthesis.datasets import given_dataset  # noqa: E402
from textures_from_example import points_of  # noqa: E402
from vtkmodules.util.numpy_support import vtk_to_numpy  # noqa: E402

SIZE = (420, 400)
COLUMNS = 5


def dunes():
    """A square with a random field as its heights, alike in every direction."""
    plain = examples.bark()[1]["plain_example"]
    mesh = points_of(plain), triangles_of(plain)
    heights = 0.05 * surfacesynthesis.matern_noise(mesh, range=0.4, operator_power=4, seed=2)
    example = given_dataset((mesh[0] + heights[:, None] * [0.0, 0.0, 1.0], mesh[1]))
    return example, {"plain_example": plain}


def triangles_of(mesh):
    return vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3)


def scan(name):
    crop = scan_textures.CROPS[name]
    return scan_textures.example_of(crop, scan_textures.scan_of(crop))


#: The textures: what makes an example and the parameters of geometric_texture_from_example().
TEXTURES = {
    "spikes": examples.spikes,
    "knobs": examples.knobs,
    "labyrinth": lambda: examples.ball("labyrinth"),
    "shell": examples.shell,
    "bark": examples.bark,
    "dunes": dunes,
    **{name: functools.partial(scan, name) for name in ("cortex", "mane", "scales", "fur")},
}


def direction_of(example):
    """The direction that a piece faces; that of the pictures of balls."""
    is_piece = surfacesynthesis.topology_report(example)["boundary_edges"] > 0
    return scan_textures.mean_normal(example) if is_piece else (0.3, 0.2, 1.0)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", required=True, metavar="DIR")
    parser.add_argument("--seed", type=int, default=1, help="of the order and of the textures (default: 1)")
    parser.add_argument("--points", type=int, default=2500, help="points of targets before subdivisions (default: 2500)")
    parser.add_argument("--only", nargs="+", choices=TEXTURES, default=list(TEXTURES), help="of the textures (default: all)")
    options = parser.parse_args()
    os.makedirs(options.output, exist_ok=True)
    order = np.random.default_rng(options.seed)
    names = [options.only[k] for k in order.permutation(len(options.only))]
    places = order.permutation(len(names))
    rows = -(-len(names) // COLUMNS)
    sheets = [rendering.Sheet(rows, min(COLUMNS, len(names)), SIZE) for _ in range(2)]
    aspect = SIZE[0] / SIZE[1]
    key = []
    for k, (name, place) in enumerate(zip(names, places)):
        example, parameters = TEXTURES[name]()
        letter, number = string.ascii_uppercase[k], int(place) + 1
        view = rendering.view_of(example, aspect, direction_of(example))
        sheets[0].add(k // COLUMNS, k % COLUMNS, letter, example, view)
        target_name = list(examples.TARGETS)[order.integers(len(examples.TARGETS))]
        _, direction, growth = examples.TARGETS[target_name]
        bare = surface(None, target_name + ".off")
        target = surfacesynthesis.remesh(bare, points=options.points, feature_angle=None)
        examples.add_vectors(target, "Growth", growth)
        output, _ = examples.synthesized(target, example, seed=options.seed, **parameters)
        view = rendering.view_of(target, aspect, direction, margin=1.15)
        sheets[1].add(place // COLUMNS, place % COLUMNS, str(number), output, view)
        key.append((letter, number, name, target_name))
        print(f"{k + 1} of {len(names)}", flush=True)
    sheets[0].write(os.path.join(options.output, "examples.png"))
    sheets[1].write(os.path.join(options.output, "synthesized.png"))
    with open(os.path.join(options.output, "key.csv"), "w", encoding="utf-8", newline="") as file:
        csv.writer(file).writerows([("example", "synthesized", "texture", "target"), *key])


if __name__ == "__main__":
    main()
