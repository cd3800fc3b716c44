#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Measures where samples of a model of poses are stretched: by steps of the flow, parts of the body and wavelengths.

    python3 stretch.py DATA [--model FILE] [--test armadillo_poses] [--samples 20] [--steps 5 10 20] [--corrections N]

DATA is the folder of make_datasets.py. Stretch is the root mean square of the logarithm of how much longer edges are than
those of the source. Prints it for each number of steps, beside that of poses of the data. With the last number of steps: the
stretch of the ends (hands, feet, head), of joints and of the middle, with the share of each in what samples are stretched
more than the data (in squares); and the difference of samples from their fitted poses (see compare_noise.py) by wavelength, in
roots of the area, as shares of its squared gradient and of its squared length.
"""

import argparse
import os
import sys

import numpy as np

import surfacesynthesis
from compare_noise import Dataset, stretch
from linear_velocity import Modes
from relief import MODEL, unique_edges
from sample_spaces import PoseSpace

#: Ends of the intervals of wavelengths, in roots of the area.
WAVELENGTHS = (0.4, 0.2, 0.15, 0.1)


def logarithms(mesh, shapes):
    """Logarithms of the stretch of edges [N, E], and the edges [2, E]."""
    points, triangles = mesh
    edges = unique_edges(triangles)
    lengths = [np.linalg.norm(shape[edges[0]].astype(float) - shape[edges[1]], axis=1) for shape in (points, *shapes)]
    return np.log(np.stack(lengths[1:]) / lengths[0]), edges


def parts(mesh, space, samples, data):
    """Name, fraction of the edges, stretch of samples and of the data and share in the excess of each part."""
    found, edges = logarithms(mesh, samples)
    real, _ = logarithms(mesh, data)
    kind = np.full(len(mesh[0]), 1)
    kind[space.middle] = 0
    for end in space.ends:
        kind[end] = 2
    excess = (found**2).mean(axis=0) - (real**2).mean(axis=0)
    for name, of in (("ends", 2), ("middle", 0), ("joints", None)):
        inside = kind[edges]
        chosen = (inside == of).all(axis=0)
        if of is None:
            chosen = ~(inside == 0).all(axis=0) & ~(inside == 2).all(axis=0)
        values = (np.sqrt((one[:, chosen] ** 2).mean()) if chosen.any() else 0.0 for one in (found, real))
        yield name, chosen.mean(), *values, excess[chosen].sum() / excess.sum()


def wavelengths(mesh, differences):
    """Shares of the squared gradient and of the squared length of differences [N, V, 3] between the WAVELENGTHS, [2, 5]."""
    modes = Modes(*mesh)
    squares = (modes.coordinates(differences.astype(float)) ** 2).sum(axis=(0, 2))
    squares[0] = 0.0  # what is moved as a whole
    numbers = np.searchsorted((2.0 * np.pi / np.array(WAVELENGTHS)) ** 2, modes.values)
    sums = [np.bincount(numbers, weights, len(WAVELENGTHS) + 1) for weights in (squares * modes.values, squares)]
    return np.stack([one / one.sum() for one in sums])


def print_table(names, rows):
    print("\n| {} |\n|{}".format(" | ".join(names), "---|" * len(names)))
    for row in rows:
        print("| {} |".format(" | ".join(one if isinstance(one, str) else f"{one:.4f}" for one in row)), flush=True)


def parsed(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", metavar="DATA", help="the folder of make_datasets.py")
    parser.add_argument("--model", default=MODEL, metavar="FILE", help="a model of poses (default: the one of the examples)")
    parser.add_argument("--test", default="armadillo_poses", metavar="NAME", help="dataset (default: armadillo_poses)")
    parser.add_argument("--samples", type=int, default=20, help="default: 20")
    parser.add_argument("--steps", type=int, nargs="+", default=[5, 10, 20], metavar="N", help="default: 5 10 20")
    parser.add_argument("--corrections", type=int, metavar="N", help="of each sample (default: what suits the model)")
    parser.add_argument("--seed", type=int, default=1, help="default: 1")
    return parser.parse_args(arguments)


def main(arguments=None):
    options = parsed(arguments)
    dataset = Dataset(options, options.test)
    mesh, data = dataset.mesh, dataset.samples[: options.samples]
    rows = [("of the data", stretch(mesh, data))]
    for steps in options.steps:
        samples = surfacesynthesis.deform(
            mesh, options.model, seed=options.seed, samples=options.samples, steps=steps, corrections=options.corrections
        )
        rows.append((str(steps), stretch(mesh, samples)))
    print_table(("steps", "stretch"), rows)
    space = PoseSpace(mesh, dataset.samples)
    print_table(("part", "of the edges", "stretch", "of the data", "of the excess"), parts(mesh, space, samples, data))
    names = [f"above {WAVELENGTHS[0]}", *(f"{a} to {b}" for a, b in zip(WAVELENGTHS, WAVELENGTHS[1:])), f"below {WAVELENGTHS[-1]}"]
    shares = wavelengths(mesh, np.stack([sample - space.fitted(sample) for sample in samples]))
    print_table(("share of", *names), [("squared gradient", *shares[0]), ("squared length", *shares[1])])


if __name__ == "__main__":
    sys.exit(main())
