# SPDX-License-Identifier: BSD-3-Clause
"""Published configurations of geometric textures [Hertz2020]: metadata and tensors of the model files that are made of their
checkpoints."""

import json
import math

#: Numbers of a network by their published names: that of the metadata, the published value, the range.
_NUMBERS = {
    "num_levels": ("levels", 5, 1, 16),
    "num_layers": ("layers", 7, 3, 32),
    "start_nf": ("start_channels", 32, 1, 4096),
    "min_nf": ("least_channels", 32, 1, 4096),
    "max_nf": ("most_channels", 128, 1, 4096),
}
#: Options of the machine that the network was trained on.
_OF_MACHINE = {"cp_folder", "save_path", "already_saved", "debug", "device"}
#: Options with the only value that this library computes, the published one.
_FIXED = {
    "noise_before": True,
    "update_axes": False,
    "nb_features": False,
    "fix_vs_noise": True,
    "scale_vs_factor": 2,
    "in_nf": 4,
    "out_nf": 3,
}


def is_texture(config):
    """True for the configuration of a geometric texture, which says how many levels there are."""
    return "num_levels" in config


def describe_texture(config):
    """The metadata of the model file, and the network's numbers by their names there; raises ValueError."""
    for name, value in _FIXED.items():
        found = config.get(name, value)
        if found != value:
            raise ValueError(f"config: {name} must be {json.dumps(value)}, as published, not {found!r}")
    network = {}
    for published, (name, missing, smallest, largest) in _NUMBERS.items():
        value = config.get(published, missing)
        if isinstance(value, bool) or not isinstance(value, int) or not smallest <= value <= largest:
            raise ValueError(f"config: {published} must be a whole number from {smallest} to {largest}, not {value!r}")
        network[name] = value
    network["noise_amplitude"] = _amplitude(config.get("noise_amplitude", 0.1))
    network["name"] = config.get("mesh_name", "texture")
    if not isinstance(network["name"], str) or not network["name"]:
        raise ValueError(f"config: mesh_name must be the name of the texture, not {network['name']!r}")
    known = {*_NUMBERS, *_FIXED, *_OF_MACHINE, "noise_amplitude", "mesh_name"}
    metadata = {
        "architecture": "geometric_texture",
        "format_version": "1",
        "producer": "SurfaceSynthesis",
        "geometric_texture": json.dumps(network, ensure_ascii=False),
        "config": json.dumps({name: value for name, value in config.items() if name not in known}),
    }
    return metadata, network


def _amplitude(value):
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 <= value < math.inf:
        raise ValueError(f"config: noise_amplitude must be a number of at least 0, not {value!r}")
    return float(value)


def texture_channels(network, level):
    """The channels of the generator of a level, from the input to the output."""
    widest = min(network["start_channels"] * 2**level, network["most_channels"])
    hidden = [max(widest // 2**i, network["least_channels"]) for i in range(network["layers"] - 2)]
    return [4, *hidden, 3]


def texture_tensors(network):
    """The shapes of all tensors of a generator, by their published names."""
    shapes = {}
    for level in range(network["levels"]):
        channels = texture_channels(network, level)
        last = len(channels) - 2
        for layer, (inputs, outputs) in enumerate(zip(channels, channels[1:])):
            name = f"levels.{level}.layers.{layer}{'' if layer == last else '.0'}.conv"
            shapes[name + ".weight"] = (outputs, inputs if layer == 0 else 2 * inputs, 1)
            shapes[name + ".bias"] = (outputs,)
    return shapes
