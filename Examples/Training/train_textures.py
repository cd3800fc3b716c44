#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Trains the geometric textures of Examples/Models.

    python3 train_textures.py OUTPUT [--only NAME ...] [--objective OBJECTIVE] [--iterations N[,N...]] [--surfaces SURFACE ...]

Makes each reference (make_references.py) and writes NAME.safetensors and NAME.csv, a table of the losses; models that learn
by flow matching are flow_NAME. A training that was interrupted goes on from its checkpoint when the script is run again. With
several surfaces a texture is learned from all of them; the labyrinth is known on the ball alone.
"""

import argparse
import os
import sys
import time

import surfacesynthesis
from make_references import DISPLACEMENTS, SURFACES, reference_levels, require_surfaces
from surfacesynthesis.commands.train_geometric_texture import iterations_of_levels
from surfacesynthesis.geometric_texture_training import OBJECTIVES

#: Half of the paper's channels.
RECIPE = {"maximum_channels": 64, "checkpoint_interval": 50}
#: That of flows, which see more of a surface and learn faster.
FLOW_RECIPE = {**RECIPE, "learning_rate": 0.002, "learning_rate_interval": 0, "layers": 12}
#: Iterations of each level: those of flows cost a sixth of the others.
ITERATIONS, FLOW_ITERATIONS = 300, [300, 3000, 3000, 500]


def recipe_of(options):
    """The parameters of train_geometric_texture()."""
    if options.objective == "flow_matching":
        layers = {"layers": options.layers} if options.layers else {}
        base = {"base_noise_amplitude": options.base_noise_amplitude, "base_samples": options.base_samples}
        return {**FLOW_RECIPE, "iterations": options.iterations or FLOW_ITERATIONS, **base, **layers}
    iterations = options.iterations or ITERATIONS
    one = isinstance(iterations, int)
    interval = max(1, 3 * iterations // 8) if one else 0
    return {"iterations": iterations, "learning_rate_interval": interval, "layers": options.layers or 7, **RECIPE}


def name_of(options, texture):
    return f"flow_{texture}" if options.objective == "flow_matching" else texture


def parsed(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("output", help="folder; made when it is not there")
    parser.add_argument("--only", nargs="+", choices=sorted(DISPLACEMENTS), default=sorted(DISPLACEMENTS))
    parser.add_argument("--objective", choices=OBJECTIVES, default="flow_matching",
                        help="what it is learned by (default: flow_matching; the published adversarial)")  # fmt: skip
    parser.add_argument("--iterations", type=iterations_of_levels, metavar="N[,N...]",
                        help="of each level, or one number for each (default: 300,3000,3000,500, of others 300 each)")  # fmt: skip
    parser.add_argument("--layers", type=int, metavar="N", help="of the networks (default: 12, of others 7)")
    parser.add_argument("--base-noise-amplitude", type=float, default=0.1, metavar="A",
                        help="of flows, largest noise of the level before, in its mean edge lengths (default: 0.1)")  # fmt: skip
    parser.add_argument("--base-samples", type=int, default=8, metavar="N",
                        help="of flows, samples of the level before that each level learns on (default: 8)")  # fmt: skip
    parser.add_argument("--surfaces", nargs="+", choices=["ball", *SURFACES],
                        help="what the texture is learned from (default: flows of spikes and knobs ball torus, others ball)")  # fmt: skip
    parser.add_argument("--levels", type=int, default=4, help="of 320, 1280, ... triangles (default: 4)")
    options = parser.parse_args(arguments)
    if options.surfaces:
        require_surfaces(parser, options)
    return options


def surfaces_of(options, texture):
    """A torus has what a ball has not: tubes, and the insides of bends."""
    flow = options.objective == "flow_matching"
    return options.surfaces or (["ball", "torus"] if flow and texture != "labyrinth" else ["ball"])


def main(arguments=None):
    options = parsed(arguments)
    os.makedirs(options.output, exist_ok=True)
    for name in options.only:
        started = time.monotonic()
        model = os.path.join(options.output, name_of(options, name) + ".safetensors")
        losses = os.path.join(options.output, name_of(options, name) + ".csv")
        levels, *others = [reference_levels(name, options.levels, surface=surface) for surface in surfaces_of(options, name)]
        surfacesynthesis.train_geometric_texture(
            levels,
            references=others,
            model=model,
            losses=losses,
            texture_name=name,
            objective=options.objective,
            **recipe_of(options),
        )
        print(f"{model}: {time.monotonic() - started:.0f} s", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
