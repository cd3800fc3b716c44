# SPDX-License-Identifier: BSD-3-Clause
"""A small model of field latents with random weights, for tests in Python and in ParaView."""

import json

import numpy as np
from surfacesynthesis.safetensors import write_safetensors


def tensor_shapes(d, c, width):
    """Shapes of the tensors of a model of d vectors, c channels, a layer and a decoder of 2 x width."""
    found = {
        "encoder.lift.weight": (2 * c, 3), "encoder.lift.bias": (2 * c,),
        "encoder.gather.weight": (2 * c, 3), "encoder.gather.bias": (2 * c,),
        "encoder.filter.0.weight": (c, 1), "encoder.filter.0.bias": (c,),
        "encoder.filter.2.weight": (2 * c, c), "encoder.filter.2.bias": (2 * c,),
        "encoder.mean.neuron.key.weight": (2, c, c), "encoder.mean.neuron.query.weight": (2, c, c),
        "encoder.mean.out.weight": (2, d, c), "encoder.deviation.product.weight": (2, c, c),
        "encoder.deviation.0.weight": (c, 2 * c), "encoder.deviation.0.bias": (c,),
        "encoder.deviation.2.weight": (d, c), "encoder.deviation.2.bias": (d,),
        "decoder.layers.0.weight": (width, 2 * d + d * (d + 1)), "decoder.layers.0.bias": (width,),
        "decoder.layers.1.weight": (width, width), "decoder.layers.1.bias": (width,),
        "decoder.layers.2.weight": (3, width), "decoder.layers.2.bias": (3,),
    }  # fmt: skip
    for norm in ("norm1", "norm2"):
        found[f"encoder.layers.0.{norm}.scale"] = (2, c)
        found[f"encoder.layers.0.{norm}.log_delta"] = (c,)
    for name in ("attention.query", "attention.key", "attention.value", "attention.out", "neuron1.key", "neuron1.query",
                 "neuron2.key", "neuron2.query"):  # fmt: skip
        found[f"encoder.layers.0.{name}.weight"] = (2, c, c)
    return found


def write_random_latents(path, d=2, c=4, width=8):
    """Writes a model of d vectors, c channels, a layer and a decoder of 2 x width; returns its path."""
    random = np.random.default_rng(3)
    sizes = {"latent_dimension": d, "channels": c, "encoder_layers": 1, "heads": 2, "samples_per_ring": 12}
    sizes |= {"decoder_layers": 2, "decoder_width": width, "iterations": 0, "coordinates": "logarithmic"}
    shapes = tensor_shapes(d, c, width)
    tensors = {name: random.uniform(-1, 1, shape).astype(np.float32) for name, shape in shapes.items()}
    metadata = {"architecture": "field_latents", "format_version": "1", "field_latents": json.dumps(sizes)}
    write_safetensors(str(path), tensors, metadata)
    return path
