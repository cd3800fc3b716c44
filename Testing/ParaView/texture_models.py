# SPDX-License-Identifier: BSD-3-Clause
"""Small geometric textures with random weights. Imported only where the plugin has LibTorch."""

import json

import numpy as np
from surfacesynthesis.safetensors import write_safetensors


def model(path):
    """A texture of two levels with random weights, without a template."""
    random = np.random.default_rng(2)
    channels = [4, 6, 6, 3]
    tensors = {}
    for level in range(2):
        for k in range(3):
            name = f"levels.{level}.layers.{k}." + ("conv" if k == 2 else "0.conv")
            inputs = 4 if k == 0 else 2 * channels[k]
            tensors[name + ".weight"] = random.uniform(-0.3, 0.3, (channels[k + 1], inputs, 1))
            tensors[name + ".bias"] = random.uniform(-0.3, 0.3, channels[k + 1])
    description = dict(levels=2, layers=4, start_channels=6, least_channels=6, most_channels=6, noise_amplitude=0.1,
                       name="random")  # fmt: skip
    described = dict(architecture="geometric_texture", format_version="1", geometric_texture=json.dumps(description))
    write_safetensors(path, tensors, described)
    return path
