#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Compares kinds of noise for flow matching on surfaces that no training has seen: tables 1 and 2 of "Matérn Noise for
Triangulation-Agnostic Flow Matching on Meshes" in kind.

    python3 compare_noise.py DATA OUTPUT [options]

DATA is the folder that make_datasets.py has written. For each kind of noise, with and without smoothing, and each of
several seeds a model is trained with the same budget on the coarse triangulation; then it is sampled on that of 5,000
triangles and on those kept for testing, and the samples are compared with as many reference samples there. Models from
files are compared in the same way (--model). Three rows without a network say what the numbers are worth: other samples of
the dataset, which are what a perfect model would make; a Gaussian with mean and covariance of the training samples, which
is what a linear model would make; and unscreened noise on the mean of the samples. Each number is a mean over the seeds
with its standard deviation; for rows without a network and models from files these are seeds of samples. Where a flow grows
without bound, the numbers of the row are nan, and the column unbounded holds the number of such seeds.

Models, checkpoints and tables of losses are left in OUTPUT; trainings go on from their checkpoints when the script is run
again. Prints tables in Markdown and writes them: metrics.csv; differences.csv, the differences between rows, none where
they are within two deviations; losses.csv, the losses of the trainings by parts of the flow time beside those of the best
linear velocity (linear_velocity.py).
"""

import argparse
import csv
import os
import sys
import time

import numpy as np

import surfacesynthesis
from carrying import carried
from linear_velocity import LinearVelocity, Modes, frame_of, loss_weights, network_units, point_masses
from sample_spaces import MixtureSpace, PoseSpace

#: Kinds of noise, by the name of an option: the name in the table, and the parameters of the training.
KINDS = {
    "matern": ("Matérn", {"noise_model": "matern"}),
    "matern_10": ("Matérn, tau 10", {"noise_model": "matern", "screening": 10.0}),
    "matern_1000": ("Matérn, tau 1000", {"noise_model": "matern", "screening": 1000.0}),
    "white": ("white", {"noise_model": "white"}),
    "unscreened": ("unscreened", {"noise_model": "unscreened"}),
    "per_vertex": ("per vertex", {"noise_model": "per_vertex"}),
    "spectral_64": ("spectral, 64", {"noise_model": "spectral", "eigenpairs": 64}),
    "spectral_256": ("spectral, 256", {"noise_model": "spectral", "eigenpairs": 256}),
    "spectral_1024": ("spectral, 1024", {"noise_model": "spectral", "eigenpairs": 1024}),
}
#: The same with and without smoothing.
NOISES = {
    name + ending: (label + words, {**parameters, "noise_smoothing": smoothing})
    for name, (label, parameters) in KINDS.items()
    for ending, words, smoothing in (("_smoothed", ", smoothed", 1.0), ("", "", 0.0))
}
#: What is trained on, and what it is tested on, by the name of the task.
TASKS = {
    "armadillo": ("armadillo_coarse", ("armadillo_poses", "armadillo_test", "armadillo_full_test")),
    "bent": ("bent_coarse", ("bent_medium", "bent_test")),
    "bunny": ("bunny_coarse", ("bunny_mixtures", "bunny_test")),
}
#: The numbers of a row, by their heads in the table.
METRICS = {
    "mmd": "MMD",
    "reverse_mmd": "reverse MMD",
    "spacing": "reference spacing",
    "cov": "COV",
    "nna": "1-NNA",
    "error": "error of the mean",
    "spread": "spread",
    "stretch": "stretch",
    "residual": "residual",
}
COLUMNS = ("task", "noise", "test", "points", "samples", "seeds", "unbounded")
OTHERS = "none: other samples"
GAUSSIAN = "none: Gaussian of the training samples"
NOISE_ON_MEAN = "none: the mean with noise"
#: How widely the noise on the mean spreads, as a multiple of the samples' own spread.
SPREAD_OF_NOISE = 1.5
#: Words of the sampler's error about a flow that leaves all bounds.
UNBOUNDED = "the state grows without bound"
#: Equal parts of the flow time, whose losses a training logs.
PARTS = 8
#: Surfaces with more points have no closed form: its matrices are dense.
LARGEST_DENSE = 6000


class Dataset:
    """The surface (points, triangles) of a file, its samples [N, V, C] and whether they are positions."""

    def __init__(self, options, name):
        found = surfacesynthesis.read_signal_dataset(os.path.join(options.data, name + ".safetensors"))
        (source,) = found.sources
        self.mesh = source.points, source.triangles
        self.samples = source.signals
        self.position = found.name == "Position"
        self.masses = point_masses(*self.mesh)

    def space(self):
        """The family that the samples are of; None where they are of neither."""
        if not self.position:
            return MixtureSpace(self.mesh, 2 * len(self.mesh[0]))
        try:
            return PoseSpace(self.mesh, self.samples)
        except ValueError:
            return None


class Candidate:
    """A row with a network: its name, and the model file and the table of losses of each seed."""

    def __init__(self, label, files, tables, sampling_seeds):
        self.label, self.files, self.tables, self.sampling_seeds = label, files, tables, sampling_seeds

    def ensembles(self, options, dataset, count):
        """Samples of each seed [N, V, C]; None where the flow grows without bound."""
        for file, seed in zip(self.files, self.sampling_seeds):
            yield generated(options, file, dataset, count, seed)


def trained(options, task, noise):
    """The candidate of a task and a noise, whose models are trained as far as they are not yet."""
    label, parameters = NOISES[noise]
    seeds = [options.seed + k for k in range(options.seeds)]
    files = [os.path.join(options.output, f"{task}_{noise}_{seed}.safetensors") for seed in seeds]
    tables = [file[: -len("safetensors")] + "csv" for file in files]
    for seed, file, table in zip(seeds, files, tables):
        started = time.monotonic()
        surfacesynthesis.train_flow_matching(
            dataset=os.path.join(options.data, TASKS[task][0] + ".safetensors"),
            model=file,
            checkpoint=file + ".checkpoint",
            losses=table,
            iterations=options.iterations,
            width=options.width,
            blocks=options.blocks,
            batch=options.batch,
            learning_rate=options.learning_rate,
            prediction=options.prediction,
            averaging=max(0.0, 1.0 - 10.0 / options.iterations),  # over the last tenth
            seed=seed,
            **parameters,
        )
        print(f"{file}: {time.monotonic() - started:.0f} s", file=sys.stderr, flush=True)
    return Candidate(label, files, tables, [seed + 1 for seed in seeds])


def given(options, label, file):
    """The candidate of a model file, which is sampled with several seeds."""
    table = os.path.splitext(file)[0] + ".csv"
    tables = [table] if os.path.exists(table) else []
    return Candidate(label, [file] * options.seeds, tables, [options.seed + 1 + k for k in range(options.seeds)])


def candidates(options, task):
    """The rows with a network; models of files belong to the task with signals of their name."""
    rows = [trained(options, task, noise) for noise in options.noises]
    position = Dataset(options, TASKS[task][0]).position
    models = [(label, file) for label, file in options.model if (frame_of(file).signal == "Position") == position]
    return rows + [given(options, label, file) for label, file in models]


def generated(options, model, dataset, count, seed):
    """Samples of a model [N, V, C]; None where its flow grows without bound."""
    generate = surfacesynthesis.deform if dataset.position else surfacesynthesis.sample_signal
    try:
        flow = {"steps": options.steps, "corrections": options.corrections, "temperature": options.temperature}
        return generate(dataset.mesh, model, seed=seed, samples=count, **flow)
    except surfacesynthesis.SurfaceSynthesisError as error:
        if UNBOUNDED not in str(error):
            raise
        return None


def other_samples(options, dataset, count):
    """Samples of the dataset after the references, in parts of the same number."""
    parts = min(options.seeds, len(dataset.samples) // count - 1)
    return [dataset.samples[(k + 1) * count : (k + 2) * count] for k in range(parts)]


def noise_on_mean(options, dataset, count):
    """Unscreened noise on the mean of the samples."""
    mean = dataset.samples.mean(axis=0, keepdims=True)
    for k in range(options.seeds):
        noise = surfacesynthesis.matern_noise(
            dataset.mesh, noise_model="unscreened", components=mean.shape[2], samples=count, seed=options.seed + k
        ).reshape(count, *mean.shape[1:])
        scale = SPREAD_OF_NOISE * spread(dataset.samples, dataset.masses) / spread(noise, dataset.masses)
        yield mean + scale * noise


def gaussian(options, training, dataset, count):
    """Samples of the Gaussian with mean and covariance of the training samples, carried to the surface of the dataset from
    the nearest places of that of the training."""
    rest = training.mesh[0] if training.position else 0.0
    for k in range(options.seeds):
        samples = carried(principal_samples(training.samples - rest, count, options.seed + k), training.mesh, dataset.mesh[0])
        yield samples + dataset.mesh[0] if training.position else samples


def principal_samples(samples, count, seed):
    """Samples of the Gaussian with mean and covariance of samples [N, V, C]."""
    mean = samples.mean(axis=0)
    deviations = (samples - mean) / np.sqrt(len(samples) - 1.0)
    factors = np.random.default_rng([seed, 1]).standard_normal((count, len(deviations)))
    return mean + np.tensordot(factors, deviations, axes=1)


def compared(options, dataset, space, samples, references):
    """The numbers of an ensemble; distances of shapes are in units of the root of the surface's area."""
    mesh, masses, position = dataset.mesh, dataset.masses, dataset.position
    scale = np.sqrt(masses.sum()) if position else 1.0
    metrics = surfacesynthesis.ensemble_metrics(samples, references, source=mesh, remove_centroid=position)
    row = {
        "mmd": metrics["mmd"] / scale,
        "reverse_mmd": metrics["reverse_mmd"] / scale,
        "spacing": metrics["reference_spacing"] / scale,
        "cov": metrics["cov"],
        "nna": metrics["one_nearest_neighbour_accuracy"],
        "error": metrics["mean_error"] / scale,
        "stretch": stretch(mesh, samples) if position else np.nan,
        "residual": space.residuals(samples[: options.fits]).mean() if space else np.nan,
    }
    if position:
        samples, references = (values - centroids(values, masses) for values in (samples, references))
    row["spread"] = spread(samples, masses) / spread(references, masses)
    return row


def measured(options, task, networks):
    """The rows of a task."""
    training = Dataset(options, TASKS[task][1][0])  # for the Gaussian, which gains nothing from fewer triangles
    for test in options.tests or TASKS[task][1]:
        if not os.path.exists(os.path.join(options.data, test + ".safetensors")):
            continue
        dataset = Dataset(options, test)
        space = dataset.space()
        count = min(options.samples, len(dataset.samples))
        ensembles = {
            OTHERS: other_samples(options, dataset, count),
            GAUSSIAN: gaussian(options, training, dataset, count),
            NOISE_ON_MEAN: noise_on_mean(options, dataset, count),
        }
        ensembles.update((network.label, network.ensembles(options, dataset, count)) for network in networks)
        for label, seeds in ensembles.items():
            rows = [
                compared(options, dataset, space, ensemble, dataset.samples[:count])
                if ensemble is not None
                else dict.fromkeys(METRICS, np.nan)
                for ensemble in seeds
            ]
            if rows:
                row = {"task": task, "noise": label, "test": test, "points": len(dataset.mesh[0]), "samples": count}
                yield {**row, **summary(rows)}
                print(f"{task}, {test}: {label}", file=sys.stderr, flush=True)


def summary(rows):
    """Mean and standard deviation of the numbers of several seeds; a single one has no deviation."""
    found = {"seeds": len(rows), "unbounded": sum(np.isnan(row["mmd"]) for row in rows)}
    for name in METRICS:
        values = np.array([row[name] for row in rows])
        found[name] = values.mean()
        found[name + "_deviation"] = values.std(ddof=1) if len(values) > 1 else np.nan
    return found


def centroids(samples, masses):
    return np.einsum("v,nvc->nc", masses / masses.sum(), samples)[:, None]


def spread(samples, masses):
    """The root of the mean square distance of the samples from their mean."""
    away = samples - samples.mean(axis=0)
    return np.sqrt(np.einsum("v,nvc->n", masses / masses.sum(), away**2).mean())


def stretch(mesh, shapes):
    """The root mean square of the logarithm of how much longer the edges of shapes are than those of the surface."""
    points, triangles = mesh
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    first, second = np.unique(np.sort(edges, axis=1), axis=0).T
    lengths = np.linalg.norm(points[first].astype(float) - points[second], axis=1)
    ratios = (np.linalg.norm(shape[first].astype(float) - shape[second], axis=1) / lengths for shape in shapes)
    return np.sqrt(np.mean([(np.log(ratio) ** 2).mean() for ratio in ratios]))


def differences(rows):
    """Differences of rows of one test: each noise smoothed and not, and each against Matérn noise. None within two
    deviations of the difference of two seeds; nan where a deviation is not known."""
    pairs = [(NOISES[name + "_smoothed"][0], NOISES[name][0]) for name in KINDS]
    pairs += [(NOISES[name + end][0], NOISES["matern" + end][0]) for end in ("_smoothed", "") for name in KINDS]
    by_name = {(row["task"], row["test"], row["noise"]): row for row in rows}
    for task, test in dict.fromkeys((row["task"], row["test"]) for row in rows):
        for first, second in pairs:
            a, b = (by_name.get((task, test, noise)) for noise in (first, second))
            if a and b and a is not b:
                found = {name: difference(a, b, name) for name in METRICS}
                yield {"task": task, "test": test, "noise": first, "against": second, **found}


def difference(a, b, name):
    change = a[name] - b[name]
    deviation = np.hypot(a[name + "_deviation"], b[name + "_deviation"])
    if np.isnan(change + deviation):
        return np.nan
    return change if abs(change) > 2.0 * deviation else "none"


def last_losses(table):
    """The means of the losses by time in the last tenth of a training, over iterations with a sample at such times: others
    repeat the number of the row before. nan in tables of versions without these columns."""
    losses = np.atleast_1d(np.genfromtxt(table, delimiter=",", names=True))
    if "loss_1" not in losses.dtype.names:
        return np.full(PARTS, np.nan)
    means = []
    for part in range(PARTS):
        column = losses[f"loss_{part + 1}"]
        fresh = np.flatnonzero(np.diff(column, prepend=0.0))
        late = fresh[fresh >= 0.9 * len(column)]
        means.append(column[late].mean() if len(late) else np.nan)
    return np.array(means)


def losses_by_time(options, task, networks):
    """Rows with the losses of each candidate, and of the best linear velocity for its noise and the training samples."""
    dataset = Dataset(options, TASKS[task][0])
    modes = Modes(*dataset.mesh) if len(dataset.mesh[0]) <= LARGEST_DENSE else None
    for network in networks:
        frames = [frame_of(file) for file in dict.fromkeys(network.files)]
        found = np.array([last_losses(table) for table in network.tables] or [np.full(PARTS, np.nan)])
        linear, constant = np.full(PARTS, np.nan), np.nan
        if modes:
            samples = network_units(frames[0], dataset.mesh, dataset.samples)
            weights = loss_weights(frames[0], modes, dataset.mesh, samples)
            best = LinearVelocity(modes, samples, frames[0].noise, dataset.position, *weights)
            linear = np.mean([best.mean_losses(frame.noise.scale, PARTS) for frame in frames], axis=0)
            constant = np.mean([best.constant_loss(frame.noise.scale) for frame in frames])
        for part in range(PARTS):
            yield {
                "task": task,
                "noise": network.label,
                "begin": part / PARTS,
                "end": (part + 1) / PARTS,
                "constant": constant,
                "linear": linear[part],
                "trained": found[:, part].mean(),
                "trained_deviation": found[:, part].std(ddof=1) if len(found) > 1 else np.nan,
            }


def write_csv(rows, path):
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]) if rows else [])
        writer.writeheader()
        writer.writerows(rows)


def print_table(heads, lines):
    print("| {} |".format(" | ".join(heads)))
    print("|{}|".format("|".join("---" if number < 2 else "---:" for number in range(len(heads)))))
    for line in lines:
        print("| {} |".format(" | ".join(line)))
    print()


def shown(value, deviation=np.nan):
    """A number of the tables, with its deviation where there is one."""
    if isinstance(value, str) or np.isnan(value):
        return value if isinstance(value, str) else "-"
    return f"{value:.4f}" if np.isnan(deviation) else f"{value:.4f} ± {deviation:.4f}"


def print_tables(rows, changes, losses):
    cells = [[shown(row[name], row[name + "_deviation"]) for name in METRICS] for row in rows]
    heads = [[row["test"], row["noise"], f"{row['points']:,}"] for row in rows]
    print_table(("tested on", "noise", "points", *METRICS.values()), [head + cell for head, cell in zip(heads, cells)])
    lines = [[f"{row['noise']} against {row['against']}", row["test"], *(shown(row[m]) for m in METRICS)] for row in changes]
    if lines:
        print_table(("difference", "tested on", *METRICS.values()), lines)
    lines = [
        [
            f"{row['task']}, {row['noise']}",
            f"{row['begin']:.3f} to {row['end']:.3f}",
            shown(row["constant"]),
            shown(row["linear"]),
            shown(row["trained"], row["trained_deviation"]),
        ]
        for row in losses
    ]
    if lines:
        print_table(("noise", "flow time", "constant velocity", "best linear velocity", "trained"), lines)


def model_option(text):
    name, separator, file = text.partition("=")
    if not separator:
        raise argparse.ArgumentTypeError(f"{text!r} is not of the form NAME=FILE")
    return name, file


def parsed(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", help="folder with the datasets")
    parser.add_argument("output", help="folder for models and tables; made when it is not there")
    parser.add_argument("--tasks", nargs="+", choices=sorted(TASKS), default=["armadillo", "bunny"],
                        help="default: armadillo bunny")  # fmt: skip
    parser.add_argument("--tests", nargs="+", metavar="NAME", help="datasets to test on (default: those of the tasks)")
    parser.add_argument("--noises", nargs="*", metavar="NOISE", default=list(NOISES), choices=list(NOISES),
                        help="of " + ", ".join(NOISES) + "; default: all; without a name no model is trained")  # fmt: skip
    parser.add_argument("--iterations", type=int, default=800, help="of each training (default: 800)")
    parser.add_argument("--width", type=int, default=48, help="of the networks (default: 48)")
    parser.add_argument("--blocks", type=int, default=3, help="of the networks (default: 3)")
    parser.add_argument("--batch", type=int, default=32, help="samples in an iteration (default: 32)")
    parser.add_argument("--learning-rate", type=float, default=0.02, help="default: 0.02")
    parser.add_argument("--prediction", choices=["automatic", "velocity", "data", "preconditioned"], default="automatic",
                        help="what the networks predict (default: automatic)")  # fmt: skip
    parser.add_argument("--model", type=model_option, action="append", default=[], metavar="NAME=FILE",
                        help="a row for this model; may be repeated")  # fmt: skip
    parser.add_argument("--samples", type=int, default=300, help="generated and reference samples (default: 300)")
    parser.add_argument("--fits", type=int, default=30, help="samples that the residual is measured on (default: 30)")
    parser.add_argument("--steps", type=int, default=20, help="of the flow (default: 20)")
    parser.add_argument("--corrections", type=int, metavar="N", help="of each sample (default: what suits the model)")
    parser.add_argument("--temperature", type=float, default=1.0, metavar="X", help="factor of the noise (default: 1)")
    parser.add_argument("--seeds", type=int, default=3, help="number of seeds (default: 3)")
    parser.add_argument("--seed", type=int, default=0, help="the first seed (default: 0)")
    return parser.parse_args(arguments)


def main(arguments=None):
    options = parsed(arguments)
    os.makedirs(options.output, exist_ok=True)
    rows, losses = [], []
    for task in options.tasks:
        networks = candidates(options, task)
        rows += measured(options, task, networks)
        losses += losses_by_time(options, task, networks)
    changes = list(differences(rows))
    for name, table in (("metrics", rows), ("differences", changes), ("losses", losses)):
        write_csv(table, os.path.join(options.output, name + ".csv"))
    print_tables(rows, changes, losses)


if __name__ == "__main__":
    main()
