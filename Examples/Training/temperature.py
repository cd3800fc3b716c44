#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Finds the temperature at which samples of a flow matching model of positions spread nearly as its data, and writes it into
the model.

    python3 temperature.py MODEL DATASET [--output FILE] [--samples 200] [--steps 10] [--seed 1] [--spread 0.97]

Models vary a little less than their data. The temperature, a factor of the noise, is raised from that of the model in steps of 5 %
until the spread of the samples, the root mean square distance from their mean, is at least --spread times that of the dataset, in the
mean of its triangulations. DATASET holds samples of the training, so that test data stay untouched. Without --output nothing is
written.
"""

import argparse
import json
import os
import struct
import sys

import numpy as np

import surfacesynthesis
from linear_velocity import point_masses

#: Step of the factors that are tried, and the last of them; and the largest temperature of a model file.
STEP, HIGHEST, LARGEST = 0.05, 1.5, 10


def spread(mesh, shapes):
    """Root mean square distance of shapes [N, V, 3] from their mean, about their centroids, by area."""
    masses = point_masses(*mesh)
    masses = (masses / masses.sum())[:, None]
    shapes = np.asarray(shapes, dtype=float).reshape(len(shapes), -1, 3)
    centered = shapes - (masses * shapes).sum(axis=1, keepdims=True)
    return np.sqrt((masses * centered.var(axis=0, ddof=1)).sum())


def relative_spread(model, source, temperature, samples, options):
    """The spread of samples on one triangulation over that of its data."""
    mesh = source.points.astype(float), source.triangles
    flow = {"steps": options.steps, "seed": options.seed, "temperature": temperature}
    shapes = surfacesynthesis.deform(mesh, model, samples=samples, **flow)
    return spread(mesh, shapes) / spread(mesh, source.signals)


def suitable(model, sources, options):
    """The lowest factor of the temperature that gives the spread, and that spread over the data's; the highest where none does."""
    samples = max(-(-options.samples // len(sources)), 2)
    for k in range(round((HIGHEST - 1.0) / STEP) + 1):
        temperature = 1.0 + STEP * k
        spreads = [relative_spread(model, source, temperature, samples, options) for source in sources]
        found = np.mean(spreads)
        listed = ", ".join(f"{x:.3f}" for x in spreads)
        print(f"temperature x {temperature:.2f}: spread {found:.3f} of the data's ({listed})", flush=True)
        if found >= options.spread:
            break
    return round(temperature, 2), found


def with_temperature(content, temperature):
    """The bytes of a model file with this temperature, beside that which it has had."""
    (size,) = struct.unpack("<Q", content[:8])
    header = json.loads(content[8 : 8 + size])
    described = json.loads(header["__metadata__"]["flow_matching"])
    described["temperature"] = round(temperature * described.get("temperature", 1.0), 4)
    if described["temperature"] > LARGEST:
        raise SystemExit(f"the temperature would be {described['temperature']:g}; models take at most {LARGEST}")
    header["__metadata__"]["flow_matching"] = json.dumps(described, separators=(",", ":"), sort_keys=True)
    text = json.dumps(header, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 8)
    return struct.pack("<Q", len(text)) + text + content[8 + size :]


def parsed(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("model", help="model file (safetensors) that generates positions")
    parser.add_argument("dataset", help="dataset file of its training")
    parser.add_argument("--output", metavar="FILE", help="model file to write, with the temperature; may be MODEL")
    parser.add_argument("--samples", type=int, default=200, metavar="N", help="at each temperature, on all triangulations together (default: 200)")
    parser.add_argument("--steps", type=int, default=10, metavar="N", help="of the flow (default: 10)")
    parser.add_argument("--seed", type=int, default=1, help="of the noise (default: 1)")
    parser.add_argument("--spread", type=float, default=0.97, metavar="X", help="to reach, over the data's (default: 0.97)")
    options = parser.parse_args(arguments)
    if options.samples < 2:
        parser.error("--samples must be at least 2")
    return options


def main(arguments=None):
    options = parsed(arguments)
    sources = surfacesynthesis.read_signal_dataset(options.dataset).sources
    temperature, found = suitable(options.model, sources, options)
    if found < options.spread:
        print(f"no factor up to {HIGHEST} reaches a spread of {options.spread}; the model needs more training", file=sys.stderr)
        return 1
    if options.output:
        with open(options.model, "rb") as file:
            content = with_temperature(file.read(), temperature)
        with open(options.output + ".part", "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(options.output + ".part", options.output)
        print(f"wrote {options.output}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
