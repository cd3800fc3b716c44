# SPDX-License-Identifier: BSD-3-Clause
"""Small flow matching models with random weights. Imported only where the plugin has LibTorch."""

import json

import numpy as np
from surfacesynthesis.conversion import describe, expected_tensors
from surfacesynthesis.safetensors import write_safetensors

SPHERE = 1 / (12 * np.pi)  # second moment of a sphere of area 1 about each axis


def model(path, components=None):
    """A flow matching model of a sphere with random weights: of positions, or of a signal."""
    head = {"head": "njf"} if components is None else {"head": "linear", "C_in": components, "C_out": components}
    metadata, network = describe({"n_blocks": 1, "C_width": 8, "cmlp_nlayers": 2, "extra_features": 4, **head})
    random = np.random.default_rng(2)
    tensors = {
        "velocity." + name: random.uniform(-0.3, 0.3, shape) for name, shape in expected_tensors(network).items()
    }
    channels = components or 3
    description = dict(
        signal_name="Position" if components is None else "Mixture", signal_mean=[0.0] * channels,
        signal_scale=[1.0] * channels, noise="matern", noise_screening=100.0, noise_eigenpairs=256, noise_scale=1.0,
        iterations=0, shape_moments=[SPHERE, 0.0, 0.0, SPHERE, 0.0, SPHERE], shape_spread=0.5,
    )  # fmt: skip
    described = dict(architecture="flow_matching", format_version="1", flow_matching=json.dumps(description),
                     velocity=json.dumps(metadata))  # fmt: skip
    write_safetensors(path, tensors, described)
    return path
