# SPDX-License-Identifier: BSD-3-Clause
"""PyTorch checkpoints of PoissonNet and of geometric textures as model files. PyTorch is needed here and nowhere else in the
package."""

import json
import os
import pickle
import re

import numpy as np

from .errors import FormatError, SurfaceSynthesisError
from .safetensors import write_safetensors
from .texture_conversion import describe_texture, is_texture, texture_tensors

_HEADS = ("linear", "njf")
_PLACES = ("vertices", "faces", "global_mean")
_ACTIVATIONS = ("identity", "log_softmax")
_NORMALIZATIONS = ("none", "surface_area", "unit_sphere")
#: Keys of the published configurations, and those of the metadata of model files.
_ALIASES = {"nblocks": "n_blocks", "width": "C_width", "head_type": "head"}
#: What describes a network, with the values that stand for a missing one; None: must be given. The rest of a
#: configuration is kept as the metadata ``config``.
_DESCRIPTION = {
    "head": None,
    "C_in": 3,
    "C_out": None,
    "C_width": None,
    "n_blocks": None,
    "extra_features": 0,
    "outputs_at": "vertices",
    "last_activation": "identity",
    "input_normalisation": "none",
    "classes": None,
}


def convert_checkpoint(checkpoint, model, config, key=None):
    """Converts a PyTorch checkpoint, a dictionary of tensors by their published names, to a model file: of PoissonNet, or of
    the generator of a geometric texture [Hertz2020], whose configuration has the key ``num_levels``.

    Parameters
    ----------
    checkpoint : path
        What torch.save() wrote: a state dictionary, or a dictionary that holds one. It is loaded with
        ``weights_only``, so that no code in it runs.
    model : path
        The file to write, safetensors in float32. An existing one is replaced once the new one is complete.
    config : mapping
        The network: ``head`` ("linear" or "njf"; also ``head_type``), ``C_width`` (also ``width``), ``n_blocks``
        (also ``nblocks``), ``cmlp_nlayers``, ``C_out`` (linear heads), and what differs from the defaults: ``C_in``
        (3), ``extra_features`` (0), ``outputs_at`` ("vertices", "faces", "global_mean"), ``last_activation``
        ("identity", "log_softmax"), ``classes`` (names), ``input_normalisation`` ("none", "surface_area",
        "unit_sphere"), ``cmlp_modulate``, ``inner_prod_features``, ``mlp_norm``, ``mass_norm``, ``dropout_p``. These
        may be in an object ``config`` inside. Further keys, about training, are kept in the file.

        Of a geometric texture the published ``options.json``, or as much of it as differs from the published defaults:
        ``num_levels`` (always), ``num_layers`` (7), ``start_nf`` (32), ``min_nf`` (32), ``max_nf`` (128),
        ``noise_amplitude`` (0.1), and ``mesh_name``, the name of the texture. The checkpoint is ``SingleMeshGenerator.pth``.
        The model file has no template: synthesis needs a target, and the statistics of the target.
    key : str, optional
        Under which key of the checkpoint the state dictionary lies. Default: the checkpoint itself, or the only
        dictionary of tensors in it.

    Returns
    -------
    dict
        The metadata of the file.

    Raises
    ------
    SurfaceSynthesisError
        PyTorch is missing or too old; the checkpoint's tensors are not those of the network that ``config`` describes.
    FormatError
        The checkpoint cannot be read, or holds no state dictionary.
    ValueError
        ``config`` lacks something or has a value that makes no sense.
    OSError
        A file cannot be read or written.
    """
    metadata, expected = metadata_and_tensors(config)
    state = _state_of(_load(checkpoint), key, os.fspath(checkpoint))
    _compare(expected, {name: tuple(tensor.shape) for name, tensor in state.items()}, os.fspath(checkpoint))
    tensors = {name: _to_numpy(tensor) for name, tensor in state.items()}
    for name, values in tensors.items():
        if not np.all(np.isfinite(values)):
            raise FormatError(f"{os.fspath(checkpoint)}: {name} holds a number that is not finite in float32")
    write_safetensors(model, tensors, metadata)
    return metadata


# -- configuration -----------------------------------------------------------------------------------------------------


def metadata_and_tensors(config):
    """The metadata of the model file and the shapes of its tensors by name; raises ValueError."""
    if is_texture(config):
        metadata, network = describe_texture(config)
        return metadata, texture_tensors(network)
    metadata, network = describe(config)
    return metadata, expected_tensors(network)


def describe(config):
    """The metadata of the model file, and the network's options by their keys in the metadata and in ``config``."""
    given = {_ALIASES.get(name, name): value for name, value in config.items() if name != "config"}
    inner = config.get("config") or {}
    given.update({name: value for name, value in _aliased(inner).items() if name not in given})
    network = {name: given.pop(name, missing) for name, missing in _DESCRIPTION.items()}
    classes = network["classes"]
    if network["C_out"] is None and (network["head"] == "njf" or classes):
        network["C_out"] = 3 if network["head"] == "njf" else len(classes)
    for name, choices in (
        ("head", _HEADS),
        ("outputs_at", _PLACES),
        ("last_activation", _ACTIVATIONS),
        ("input_normalisation", _NORMALIZATIONS),
    ):
        if network[name] not in choices:
            raise ValueError(f"config: {name} must be one of {', '.join(choices)}, not {network[name]!r}")
    for name, smallest in (("C_in", 1), ("C_out", 1), ("C_width", 1), ("n_blocks", 1), ("extra_features", 0)):
        _check_count(name, network[name], smallest)
    if classes is not None and (
        not isinstance(classes, (list, tuple)) or not all(isinstance(text, str) for text in classes)
    ):
        raise ValueError("config: classes must be a list of names")
    if classes and len(classes) != network["C_out"]:
        raise ValueError(f"config: there are {len(classes)} classes for {network['C_out']} output channels")
    _check_count("cmlp_nlayers", given.get("cmlp_nlayers"), 1)
    metadata = {name: str(value) for name, value in network.items() if name != "classes"}
    if classes:
        metadata["classes"] = json.dumps(list(classes), ensure_ascii=False)
    metadata["config"] = json.dumps(given)
    metadata.update(architecture="poissonnet", format_version="1", producer="SurfaceSynthesis")
    return metadata, {**given, **network}


def _aliased(values):
    if not hasattr(values, "items"):
        raise ValueError("config: the value of config must be an object")
    return {_ALIASES.get(name, name): value for name, value in values.items()}


def _check_count(name, value, smallest):
    if value is None:
        raise ValueError(f"config: {name} is missing")
    if isinstance(value, bool) or not isinstance(value, int) or not smallest <= value <= 100000:
        raise ValueError(f"config: {name} must be a whole number from {smallest} to 100000, not {value!r}")


def expected_tensors(network):
    """The shapes of all tensors of a network, by name."""
    width, shapes = network["C_width"], {}

    def affine(name, inputs, outputs):
        shapes[name + ".weight"], shapes[name + ".bias"] = (outputs, inputs), (outputs,)

    def complex_linear(name, outputs):
        shapes[name + ".lin_real.weight"] = shapes[name + ".lin_imag.weight"] = (outputs, width)

    def complex_mlp(name, outputs, modulated):
        layers = network["cmlp_nlayers"]
        for layer in range(layers):
            complex_linear(f"{name}.layers.{layer}", outputs if layer == layers - 1 else width)
            if layer < layers - 1:
                shapes[f"{name}.layers.{layer}.mag_bias"] = (width,)
        if modulated:
            affine(name + ".modulator.modulator.0", width, width)
            affine(name + ".modulator.modulator.2", width, 2 * width)

    extra, products = network["extra_features"] > 0, bool(network.get("inner_prod_features"))
    if extra:
        affine("extra_feat_mlp.0", network["extra_features"], width)
        affine("extra_feat_mlp.2", width, width)
    affine("proj_in", network["C_in"], width)
    for block in range(network["n_blocks"]):
        name = f"blocks.{block}"
        complex_mlp(name + ".grad_mlp", width, _flag(network, "cmlp_modulate", True))
        if products:
            complex_linear(name + ".grad_features", width)
            shapes[name + ".grad_scaler"] = (width,)
        shapes[name + ".vert_mlp.ls1"] = shapes[name + ".vert_mlp.ls2"] = (width,)
        affine(name + ".vert_mlp.mlp1.layers.0", (2 + extra + products) * width, width)
        for layer in ("mlp1.layers.3", "mlp2.layers.0", "mlp2.layers.3"):
            affine(f"{name}.vert_mlp.{layer}", width, width)
        for norm in ("norm_pde", "norm_grad") if network.get("mlp_norm") else ():
            if norm == "norm_pde" or products:
                shapes[f"{name}.vert_mlp.{norm}.weight"] = shapes[f"{name}.vert_mlp.{norm}.bias"] = (width,)
    if network["head"] == "linear":
        affine("head", width, network["C_out"])
    else:
        complex_mlp("head.grad_mlp", 3, _flag(network, "cmlp_modulate", False))
    return shapes


def _flag(network, name, missing):
    value = network.get(name)
    return missing if value is None else bool(value)


# -- checkpoint ----------------------------------------------------------------------------------------------------------


def _load(path):
    try:
        import torch
    except ImportError as error:
        raise SurfaceSynthesisError(
            f"PyTorch is needed to read {os.fspath(path)}, and cannot be imported ({error}); the model file that is made "
            "of it needs no PyTorch"
        ) from None
    with open(path, "rb"):  # the operating system's own words for a missing or unreadable file
        pass
    try:
        return torch.load(os.fspath(path), map_location="cpu", weights_only=True)
    except TypeError as error:
        raise SurfaceSynthesisError(
            f"PyTorch {torch.__version__} cannot load tensors without running code ({error}); 1.13 or later is needed"
        ) from None
    except pickle.UnpicklingError as error:
        # PyTorch's advice is to load the file without weights_only, which runs the code in it.
        found = re.search(r"(?:GLOBAL|class|global:?) (\w+\.[\w.]*\w)", str(error))
        reason = f"{found[1]} in it would run code when it is loaded" if found else "it holds other objects, or is damaged"
        raise FormatError(
            f"{os.fspath(path)}: no checkpoint of tensors alone: {reason}, and is not read; where the network was trained, "
            "torch.save(network.state_dict(), ...) saves the tensors alone"
        ) from None
    except Exception as error:  # zipfile, torch: whatever a broken file provokes
        text = (str(error).splitlines() or [type(error).__name__])[0]
        raise FormatError(f"{os.fspath(path)}: no checkpoint of tensors alone: {text}") from None


def _is_tensor(value):
    return hasattr(value, "shape") and hasattr(value, "detach")


def _is_state(value):
    return hasattr(value, "items") and len(value) > 0 and all(_is_tensor(tensor) for tensor in value.values())


def _state_of(loaded, key, path):
    """The state dictionary in what was loaded."""
    if not hasattr(loaded, "items"):
        raise FormatError(f"{path}: the checkpoint is a {type(loaded).__name__}, not a dictionary of tensors")
    if key is not None:
        if key not in loaded:
            raise FormatError(f"{path}: there is no key '{key}'; the keys are {_some(loaded)}")
        if not _is_state(loaded[key]):
            raise FormatError(f"{path}: what lies under '{key}' is no dictionary of tensors")
        return dict(loaded[key])
    if _is_state(loaded):
        return dict(loaded)
    inside = [name for name, value in loaded.items() if _is_state(value)]
    if len(inside) != 1:
        found = "none" if not inside else _some(inside)
        raise FormatError(
            f"{path}: the state dictionary must be named by its key; the keys are {_some(loaded)}, those of dictionaries "
            f"of tensors {found}"
        )
    return dict(loaded[inside[0]])


def _some(names):
    names = [str(name) for name in names]
    return ", ".join(names[:8]) + (f" and {len(names) - 8} more" if len(names) > 8 else "")


def _compare(expected, found, path):
    """Raises SurfaceSynthesisError, naming the first three differences."""
    differences = []
    for name, shape in sorted(expected.items()):
        if name not in found:
            differences.append(f"{name} {list(shape)} is missing")
        elif found[name] != shape:
            differences.append(f"{name} is {list(found[name])} instead of {list(shape)}")
    differences += [f"{name} does not belong to it" for name in sorted(set(found) - set(expected))]
    if differences:
        more = f"; and {len(differences) - 3} more" if len(differences) > 3 else ""
        raise SurfaceSynthesisError(
            f"{path}: the tensors are not those of the network that the configuration describes: "
            f"{'; '.join(differences[:3])}{more}"
        )


def _to_numpy(tensor):
    return np.asarray(tensor.detach().cpu().double().numpy()).astype(np.float32)
