# SPDX-License-Identifier: BSD-3-Clause
"""Error of the encoder of a model of many surfaces: how far the eigenfunctions that it predicts are from those of the
reference."""

import json

import numpy as np

import surfacesynthesis
from linear_velocity import Modes, point_masses
from surfacesynthesis.safetensors import read_safetensors, write_safetensors

_PREFIX = "encoder."


def write_encoder(model, path):
    """Writes the encoder of a flow matching model to a file of its own. Returns the number of its functions, 0 without one."""
    tensors, texts = read_safetensors(model)
    if "encoder" not in texts:
        return 0
    own = json.loads(texts["encoder"])
    write_safetensors(path, {name[len(_PREFIX) :]: part for name, part in tensors.items() if name.startswith(_PREFIX)}, own)
    return int(own["C_out"])


def learnt_functions(reference, encoder, count):
    """Eigenfunctions 1 to ``count`` of the Laplacian of a surface (points, triangles), [V, count], as trainings of encoders
    learn them: without the constant, of mean square 1. Their signs are free; they are those that the PoissonNet of a file
    predicts."""
    modes = Modes(*reference)
    functions = modes.vectors[:, 1 : count + 1]
    if functions.shape[1] < count:
        raise ValueError(f"{count} eigenfunctions need at least {count + 1} points, not {len(reference[0])}")
    found = surfacesynthesis.poisson_net(reference, encoder).values
    return functions * np.where(modes.mass @ (found * functions) < 0.0, -1.0, 1.0)


def relative_errors(mesh, encoder, expected):
    """Root mean square over a surface (points, triangles) of the error of each function that the PoissonNet of a file
    predicts, over that of the ``expected`` ones, [V, C]: 1 for a prediction of nothing. Means are weighted by mass."""
    found = surfacesynthesis.poisson_net(mesh, encoder).values
    mass = point_masses(*mesh)
    return np.sqrt(mass @ (found - expected) ** 2 / (mass @ expected**2))
