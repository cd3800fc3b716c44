#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Measures a model of rest states of a soft body: how flat its samples lie on the floor, their volumes, and their distances
from rest states that the training has not seen.

    python3 rest_space.py MODEL TRAINING TEST [--surface FILE] [--settle] [--up 0 1 0] [--samples 100] [--seeds 3] [--csv FILE]

TRAINING and TEST are dataset files of rest states of one triangulation (dataset rest-states), the first one where a file has
several (make_rest_states.py). The rows are

    rest states            those of the training against those of the test: what a perfect model would reach
    principal components   a Gaussian on the principal components of the training: what no network can be below
    model                  samples of the model on the triangulation of the test
    settled                these samples, laid down in a simulation: the rest states next to them (--settle)
    model, settled         both on another triangulation of the body (--surface)

and the columns

    flat            the part of the samples of which nothing lies deeper than 1 % of the diagonal of the body's box below the floor
    depth           how deep all but 5 % of the samples reach at most, % of the diagonal
    volume          mean volume over that of the body; a soft body is compressed by its weight
    same volume     the part of the samples whose volume is within 5 % of the range of volumes of the rest states
    mmd, reverse    mean distance to the nearest test state, and of a test state to the nearest sample, over the root of the area
    coverage        the part of the test states that are nearest to a sample, of as many samples
    1-NNA           accuracy of the nearest neighbor: 0.5 where samples and test states cannot be told apart
    modes           half of the sum of the differences in how often the modes occur, from 0 to 1: leaders are rest states of which
                    no two are nearer than 0.1, and a mode is what has the same nearest leader

with means and deviations over seeds. A model knows shapes up to a translation: the floor of a sample is the height below which it has
as much of its area as the rest states touch their floor with, at least (all but 5 % of them). Distances are those of corresponding
points about the centroid; samples of another triangulation are compared at the nearest places of its points at rest.
"""

import argparse
import sys

import numpy as np

import surfacesynthesis
from carrying import carried
from compare_noise import principal_samples, print_table, shown, write_csv
from linear_velocity import point_masses
from make_datasets import points_and_triangles

#: Depth below the floor that counts, over the diagonal; and relative change of the volume that counts as another one.
DEPTH, VOLUME = 0.01, 0.05
#: Height above the lowest point at which a point of a rest state touches the floor, over the diagonal.
TOUCHING = 0.005
#: Headings of the columns; deviations lie beside them.
COLUMNS = {
    "flat": "flat",
    "depth": "depth, %",
    "volume": "volume",
    "same_volume": "same volume",
    "mmd": "mmd",
    "reverse": "reverse mmd",
    "coverage": "coverage",
    "nna": "1-NNA",
    "modes": "modes",
}
#: Distance of the leaders of modes, root mean square over the root of the area.
MODE_RADIUS = 0.1


class RestStates:
    """The body (points, triangles) of a dataset file, the first of several, and its rest states [N, V, 3]."""

    def __init__(self, path):
        source = surfacesynthesis.read_signal_dataset(path).sources[0]
        self.mesh = source.points, source.triangles
        self.samples = source.signals


def volumes(triangles, shapes):
    """Volumes [N] inside of closed surfaces."""
    a, b, c = (shapes[:, triangles[:, k]].astype(float) for k in range(3))
    return np.einsum("nfk,nfk->n", a, np.cross(b, c)) / 6.0


def heights(shapes, up):
    """Heights [N, V] of the points above the lowest one of each shape."""
    found = shapes @ up
    return found - found.min(axis=1, keepdims=True)


def touching_part(body, up):
    """The part of the area with which all but 5 % of the rest states touch the floor at least."""
    masses = point_masses(*body.mesh)
    touches = heights(body.samples, up) < TOUCHING * diagonal(body.mesh)
    return np.quantile(touches @ masses / masses.sum(), 0.05)


def depths(mesh, shapes, up, part):
    """Depths [N] of the lowest points below the height that has this part of the area beneath, over the diagonal."""
    masses = point_masses(*mesh)
    found = []
    for above in heights(shapes, up):
        order = np.argsort(above)
        floor = np.searchsorted(np.cumsum(masses[order]), part * masses.sum())
        found.append(above[order[min(floor, len(order) - 1)]])
    return np.array(found) / diagonal(mesh)


def diagonal(mesh):
    """Length of the diagonal of the box of the body."""
    return np.linalg.norm(np.ptp(mesh[0], axis=0))


def shape_numbers(mesh, shapes, up, part, range_of_volumes):
    """The columns that need no test states."""
    below = depths(mesh, shapes, up, part)
    ratios = volumes(mesh[1], shapes) / volumes(mesh[1], mesh[0][None])
    lowest, highest = range_of_volumes
    return {
        "flat": (below <= DEPTH).mean(),
        "depth": 100.0 * np.quantile(below, 0.95),
        "volume": ratios.mean(),
        "same_volume": ((ratios >= lowest * (1.0 - VOLUME)) & (ratios <= highest * (1.0 + VOLUME))).mean(),
    }


def distances(test, samples):
    """The columns of distances of samples on the triangulation of the test."""
    scale = np.sqrt(point_masses(*test.mesh).sum())
    count = min(len(samples), len(test.samples))
    found = surfacesynthesis.ensemble_metrics(samples[:count], test.samples[:count], source=test.mesh, remove_centroid=True)
    return {
        "mmd": found["mmd"] / scale,
        "reverse": found["reverse_mmd"] / scale,
        "coverage": found["cov"],
        "nna": found["one_nearest_neighbour_accuracy"],
    }


class Modes:
    """Modes of rest states, and how often they occur in the training and the test together."""

    def __init__(self, training, test):
        masses = point_masses(*test.mesh)
        self._weights = np.sqrt(masses / masses.sum() ** 2)[:, None]
        states = self._features(np.concatenate([training.samples, test.samples]))
        nearest, leaders = np.full(len(states), np.inf), []
        while nearest.max() > MODE_RADIUS:
            leaders.append(states[nearest.argmax()])
            nearest = np.minimum(nearest, np.linalg.norm(states - leaders[-1], axis=1))
        self._leaders = np.array(leaders)
        self._frequencies = self._count(states)

    def difference(self, shapes):
        """The column of shapes on the triangulation of the test."""
        return 0.5 * np.abs(self._count(self._features(shapes)) - self._frequencies).sum()

    def _features(self, shapes):
        shapes = shapes.astype(float)
        center = (self._weights**2 * shapes).sum(axis=1, keepdims=True) / (self._weights**2).sum()
        return ((shapes - center) * self._weights).reshape(len(shapes), -1)

    def _count(self, features):
        distances = np.stack([np.linalg.norm(features - leader, axis=1) for leader in self._leaders])
        return np.bincount(distances.argmin(axis=0), minlength=len(self._leaders)) / len(features)


def settled(mesh, shapes, options):
    """The rest states next to samples, of the body that the data are of."""
    tetrahedra = surfacesynthesis.read_mesh(options.tetrahedra) if options.tetrahedra else None
    return surfacesynthesis.settle(
        mesh, shapes, tetrahedra=tetrahedra, surface_points=options.surface_points, up_direction=options.up
    )


def summary(rows):
    """Means and deviations of the columns."""
    found = {}
    for name in COLUMNS:
        values = np.array([row[name] for row in rows])
        found[name] = values.mean()
        found[name + "_deviation"] = values.std(ddof=1) if len(values) > 1 else np.nan
    return found


def measured(options):
    """The rows of the table."""
    training, test = RestStates(options.training), RestStates(options.test)
    up = np.array(options.up) / np.linalg.norm(options.up)
    ratios = volumes(test.mesh[1], training.samples) / volumes(test.mesh[1], test.mesh[0][None])
    seen = ratios.min(), ratios.max()
    part = touching_part(training, up)
    count = min(options.samples, len(test.samples), len(training.samples))
    seeds = range(options.seed, options.seed + options.seeds)
    modes = Modes(training, test)

    def row(name, ensembles, mesh=test.mesh):
        rows = [
            {**shape_numbers(mesh, shapes, up, part, seen), **distances(test, at_test), "modes": modes.difference(at_test)}
            for shapes, at_test in ensembles
        ]  # fmt: skip
        print(name, file=sys.stderr, flush=True)
        return {"samples of": name, "triangles": len(mesh[1]), "count": count, "seeds": len(rows), **summary(rows)}

    def of_model(mesh):
        flow = {"samples": count, "steps": options.steps, "corrections": options.corrections, "temperature": options.temperature}
        return [surfacesynthesis.deform(mesh, options.model, seed=seed, **flow) for seed in seeds]

    def rows_of_model(mesh):
        ensembles = of_model(mesh)
        at_test = [(shapes, carried(shapes, mesh, test.mesh[0])) for shapes in ensembles]
        yield row("model", at_test, mesh)
        if options.settle:
            resting = [settled(mesh, shapes, options) for shapes in ensembles]
            yield row("settled", [(shapes, carried(shapes, mesh, test.mesh[0])) for shapes in resting], mesh)

    real = [training.samples[k * count : (k + 1) * count] for k in range(min(options.seeds, len(training.samples) // count))]
    yield row("rest states", [(states, states) for states in real])
    linear = [principal_samples(training.samples, count, seed) for seed in seeds]
    yield row("principal components", [(samples, samples) for samples in linear])
    yield from rows_of_model(test.mesh)
    for path in options.surface:
        yield from rows_of_model(points_and_triangles(surfacesynthesis.read_mesh(path)))


def parsed(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("model", help="name or file of a flow matching model of rest states")
    parser.add_argument("training", help="dataset file that the model was trained on")
    parser.add_argument("test", help="dataset file of other rest states on the same triangulation")
    parser.add_argument("--surface", action="append", default=[], metavar="FILE",
                        help="the body with another triangulation; may be repeated")  # fmt: skip
    parser.add_argument("--settle", action="store_true", help="rows for the rest states next to the samples, too")
    parser.add_argument("--tetrahedra", metavar="FILE", help="tetrahedra that the data were simulated with (.vtu), to settle in")
    parser.add_argument("--surface-points", type=int, default=500, metavar="N",
                        help="or points of the simulated surface, to settle in (default: 500)")  # fmt: skip
    parser.add_argument("--up", type=float, nargs=3, default=[0.0, 0.0, 1.0], metavar="X", help="upwards (default: 0 0 1)")
    parser.add_argument("--samples", type=int, default=100, help="generated and test states (default: 100)")
    parser.add_argument("--steps", type=int, default=20, help="of the flow (default: 20)")
    parser.add_argument("--corrections", type=int, metavar="N", help="of each sample (default: what suits the model)")
    parser.add_argument("--temperature", type=float, default=1.0, metavar="X", help="factor of the noise (default: 1)")
    parser.add_argument("--seeds", type=int, default=3, help="number of seeds (default: 3)")
    parser.add_argument("--seed", type=int, default=1, help="the first seed (default: 1)")
    parser.add_argument("--csv", metavar="FILE", help="write the numbers here too")
    return parser.parse_args(arguments)


def main(arguments=None):
    options = parsed(arguments)
    rows = list(measured(options))
    if options.csv:
        write_csv(rows, options.csv)
    lines = [
        [row["samples of"], f"{row['triangles']:,}", *(shown(row[name], row[name + "_deviation"]) for name in COLUMNS)]
        for row in rows
    ]
    print_table(("samples of", "triangles", *COLUMNS.values()), lines)


if __name__ == "__main__":
    main()
