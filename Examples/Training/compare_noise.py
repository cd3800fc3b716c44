#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Compares kinds of noise for flow matching on surfaces that no training has seen: tables 1 and 2 of "Matérn Noise for
Triangulation-Agnostic Flow Matching on Meshes" in kind.

    python3 compare_noise.py DATA OUTPUT [options]

DATA is the folder that make_datasets.py has written. For each kind of noise a model is trained with the same budget on the
even triangulation; then it is sampled on the same triangulation and on those kept for testing, and the samples are compared
with the reference samples there (vtkEnsembleMetrics), also by how widely they scatter and, of shapes, how far their edges
are stretched; where a flow grows without bound, all numbers are nan. Two rows without a model say what the numbers are
worth: other samples of the dataset, which are what a perfect model would make, and unscreened noise on the mean of the
samples, which knows nothing about any of them. Models, checkpoints and tables of losses are left in OUTPUT; trainings go on
from their checkpoints when the script is run again. Prints a table in Markdown and writes it as metrics.csv.
"""

import argparse
import csv
import os
import sys
import time

import numpy as np

import surfacesynthesis

#: By the name of an option: the name in the table, the noise of the training and its smoothing.
NOISES = {
    "smoothed": ("Matérn, smoothed", "matern", 1.0),
    "matern": ("Matérn", "matern", 0.0),
    "white": ("white", "white", 0.0),
    "unscreened": ("unscreened", "unscreened", 0.0),
    "per_vertex": ("per vertex", "per_vertex", 0.0),
}
#: What is trained on, and what it is tested on, by the name of the task.
TASKS = {
    "armadillo": ("armadillo_poses", ("armadillo_poses", "armadillo_test", "armadillo_full_test")),
    "bunny": ("bunny_mixtures", ("bunny_mixtures", "bunny_test")),
}
COLUMNS = ("task", "noise", "test", "points", "mmd", "spacing", "cov", "nna", "error", "spread", "stretch")
OTHERS = "none: other samples"
NOISE_ON_MEAN = "none: the mean with noise"
#: How widely the noise on the mean spreads, as a multiple of the samples' own spread.
SPREAD_OF_NOISE = 1.5


def dataset(folder, name):
    """Surface (points, triangles), its samples [N, V, C] and whether they are positions."""
    found = surfacesynthesis.read_signal_dataset(os.path.join(folder, name + ".safetensors"))
    (source,) = found.sources
    return (source.points, source.triangles), source.signals, found.name == "Position"


def trained(options, task, noise):
    """The model file of a task and a noise, which is trained as far as it is not yet."""
    model = os.path.join(options.output, f"{task}_{noise}.safetensors")
    started = time.monotonic()
    surfacesynthesis.train_flow_matching(
        dataset=os.path.join(options.data, TASKS[task][0] + ".safetensors"),
        model=model,
        checkpoint=model + ".checkpoint",
        losses=os.path.join(options.output, f"{task}_{noise}.csv"),
        iterations=options.iterations,
        width=options.width,
        blocks=options.blocks,
        batch=options.batch,
        learning_rate=options.learning_rate,
        milestones=[2 * options.iterations // 3],
        averaging=max(0.0, 1.0 - 10.0 / options.iterations),  # over the last tenth
        noise_model=NOISES[noise][1],
        noise_smoothing=NOISES[noise][2],
        seed=options.seed,
    )
    print(f"{model}: {time.monotonic() - started:.0f} s", file=sys.stderr, flush=True)
    return model


def generated(options, model, mesh, position):
    """Samples of a model [N, V, C]; none where its flow grows without bound."""
    generate = surfacesynthesis.deform if position else surfacesynthesis.sample_signal
    try:
        return generate(mesh, model, seed=options.seed + 1, samples=options.samples, steps=options.steps)
    except surfacesynthesis.SurfaceSynthesisError as error:
        if "not finite" not in str(error):
            raise
        return None


def noise_on_mean(options, mesh, samples, weights):
    """Unscreened noise on the mean of the samples."""
    mean = samples.mean(axis=0, keepdims=True)
    noise = surfacesynthesis.matern_noise(
        mesh, noise_model="unscreened", components=mean.shape[2], samples=options.samples, seed=options.seed
    )
    noise = noise.reshape(options.samples, *mean.shape[1:])
    return mean + SPREAD_OF_NOISE * spread(samples, weights) / spread(noise, weights) * noise


def compared(mesh, samples, references, position):
    """The numbers of a row; distances of shapes are in units of the root of the surface's area."""
    weights = point_weights(mesh)
    scale = np.sqrt(weights.sum()) if position else 1.0
    metrics = surfacesynthesis.ensemble_metrics(samples, references, source=mesh, remove_centroid=position)
    stretches = np.nan
    if position:
        stretches = stretch(mesh, samples)
        samples, references = (values - centroids(values, weights) for values in (samples, references))
    return {
        "mmd": metrics["mmd"] / scale,
        "spacing": metrics["reference_spacing"] / scale,
        "cov": metrics["cov"],
        "nna": metrics["one_nearest_neighbour_accuracy"],
        "error": metrics["mean_error"] / scale,
        "spread": spread(samples, weights) / spread(references, weights),
        "stretch": stretches,
    }


def measured(options, task, candidates):
    """The rows of a task."""
    for test in TASKS[task][1]:
        if not os.path.exists(os.path.join(options.data, test + ".safetensors")):
            continue
        mesh, samples, position = dataset(options.data, test)
        ensembles = {NOISE_ON_MEAN: noise_on_mean(options, mesh, samples, point_weights(mesh))}
        if len(samples) >= 2 * options.samples:
            ensembles = {OTHERS: samples[options.samples : 2 * options.samples], **ensembles}
        ensembles.update((label, generated(options, model, mesh, position)) for label, model in candidates)
        for label, ensemble in ensembles.items():
            row = {"task": task, "noise": label, "test": test, "points": len(mesh[0]), **dict.fromkeys(COLUMNS[4:], np.nan)}
            if ensemble is not None:
                row.update(compared(mesh, ensemble, samples[: options.samples], position))
            yield row


def point_weights(mesh):
    """The areas of the points, a third of those of their triangles."""
    points, triangles = mesh
    a, b, c = (points[triangles[:, k]].astype(float) for k in range(3))
    areas = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return np.bincount(triangles.ravel(), np.repeat(areas / 3.0, 3), len(points))


def centroids(samples, weights):
    return np.einsum("v,nvc->nc", weights / weights.sum(), samples)[:, None]


def spread(samples, weights):
    """The root of the mean square distance of the samples from their mean."""
    away = samples - samples.mean(axis=0)
    return np.sqrt(np.einsum("v,nvc->n", weights / weights.sum(), away**2).mean())


def stretch(mesh, shapes):
    """The root mean square of the logarithm of how much longer the edges of shapes are than those of the surface."""
    points, triangles = mesh
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    first, second = np.unique(np.sort(edges, axis=1), axis=0).T
    lengths = np.linalg.norm(points[first].astype(float) - points[second], axis=1)
    squares = [
        (np.log(np.linalg.norm(shape[first].astype(float) - shape[second], axis=1) / lengths) ** 2).mean() for shape in shapes
    ]
    return np.sqrt(np.mean(squares))


def write_tables(rows, path):
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(rows)
    heads = ("task", "tested on", "points", "noise", "MMD", "reference spacing", "COV", "1-NNA", "error of the mean", "spread")
    print("| {} |".format(" | ".join((*heads, "stretch"))))
    print("|---|---|---:|---|---:|---:|---:|---:|---:|---:|---:|")
    for row in rows:
        print(
            "| {task} | {test} | {points:,} | {noise} | {mmd:.4f} | {spacing:.4f} | {cov:.3f} | {nna:.3f} | {error:.4f} "
            "| {spread:.2f} | {stretch:.3f} |".format(**row).replace("nan", "-")
        )


def parsed(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", help="folder with the datasets")
    parser.add_argument("output", help="folder for models and tables; made when it is not there")
    parser.add_argument("--tasks", nargs="+", choices=sorted(TASKS), default=sorted(TASKS))
    parser.add_argument("--noises", nargs="+", choices=list(NOISES), default=list(NOISES))
    parser.add_argument("--iterations", type=int, default=6000, help="of each training (default: 6000)")
    parser.add_argument("--width", type=int, default=48, help="of the networks (default: 48)")
    parser.add_argument("--blocks", type=int, default=3, help="of the networks (default: 3)")
    parser.add_argument("--batch", type=int, default=4, help="samples in an iteration (default: 4)")
    parser.add_argument("--learning-rate", type=float, default=1e-3, help="default: 0.001")
    parser.add_argument("--model", metavar="FILE", help="measure this model, of one task, and train none")
    parser.add_argument("--samples", type=int, default=100, help="generated and reference samples (default: 100)")
    parser.add_argument("--steps", type=int, default=20, help="of the flow (default: 20)")
    parser.add_argument("--seed", type=int, default=0, help="default: 0")
    return parser.parse_args(arguments)


def models(options, task):
    """Pairs of a name in the table and a model file; all are trained then."""
    if options.model:
        return [(os.path.basename(options.model), options.model)]
    return [(NOISES[noise][0], trained(options, task, noise)) for noise in options.noises]


def main(arguments=None):
    options = parsed(arguments)
    os.makedirs(options.output, exist_ok=True)
    rows = [row for task in options.tasks for row in measured(options, task, models(options, task))]
    write_tables(rows, os.path.join(options.output, "metrics.csv"))


if __name__ == "__main__":
    main()
