# SPDX-License-Identifier: BSD-3-Clause
"""The command ``convert``."""

import json

from .common import Outcome, UsageError, add_command, add_printing_options, as_usage

_DESCRIPTION = """\
Makes a model file (safetensors) of a PyTorch checkpoint of PoissonNet or of a geometric texture. PyTorch is needed for this
and only for this; no code in the checkpoint is run. The tensors must be exactly those of the network that the configuration
describes."""
_EXAMPLES = """\
configuration of PoissonNet: a JSON file, or JSON text, with the keys of the published configurations and of model files
  head_type (or head)     linear, njf
  width, nblocks          (or C_width, n_blocks)
  cmlp_nlayers            layers of each complex network
  cmlp_modulate, inner_prod_features, mlp_norm, mass_norm   where they differ from the defaults
  C_in, C_out             channels; 3 and, for njf, 3 where absent
  extra_features          number of conditions; 0 where absent
  outputs_at              vertices (default), faces, global_mean
  last_activation         identity (default), log_softmax
  classes                 list of names
  input_normalisation     none (default), surface_area, unit_sphere

configuration of a geometric texture: the published options.json, or its keys
  num_levels              levels of the generator
  num_layers              7 where absent
  start_nf, min_nf, max_nf   channels: 32, 32 and 128 where absent
  noise_amplitude         0.1 where absent
  mesh_name               name of the texture

examples:
  %(prog)s crumpling.pt crumpling.safetensors --config crumpling.json --set extra_features=1
  %(prog)s net.pt net.safetensors --key model --config '{"head": "njf", "width": 128, "nblocks": 5, "cmlp_nlayers": 3}'
  %(prog)s SingleMeshGenerator.pth virus.safetensors --config options.json
"""


def add(commands):
    """Adds the command to the parser."""
    parser = add_command(
        commands,
        "convert",
        "CHECKPOINT MODEL --config CONFIG",
        "make a model file of a checkpoint",
        _DESCRIPTION,
        _EXAMPLES,
    )
    parser.set_defaults(run=run)
    parser.add_argument("checkpoint", metavar="CHECKPOINT", help="PyTorch checkpoint to read")
    parser.add_argument("model", metavar="MODEL", help="model file to write: .safetensors")
    parser.add_argument("--config", required=True, metavar="CONFIG", help="JSON file, or JSON text that begins with {")
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="entry that the configuration lacks; repeatable"
    )
    parser.add_argument("--key", metavar="KEY", help="key of the state dictionary in the checkpoint")
    add_printing_options(parser)


def run(arguments):
    """The command ``convert``."""
    from ..conversion import convert_checkpoint, metadata_and_tensors

    config = _config_of(arguments)
    as_usage(metadata_and_tensors, config)
    metadata = convert_checkpoint(arguments.checkpoint, arguments.model, config, key=arguments.key)
    return Outcome(", ".join(_parts(metadata)), metadata, [arguments.model])


def _parts(metadata):
    """The kind of a model, in words."""
    if metadata["architecture"] == "poissonnet":
        return [f"{metadata['n_blocks']} blocks", f"width {metadata['C_width']}", f"head {metadata['head']}"]
    network = json.loads(metadata["geometric_texture"])
    return [f'geometric texture "{network["name"]}"', f"{network['levels']} levels", f"{network['layers']} layers"]


def _config_of(arguments):
    text = arguments.config
    source = "--config"
    if not text.lstrip().startswith("{"):
        source = text
        with open(text, encoding="utf-8") as file:
            text = file.read()
    try:
        config = json.loads(text)
    except ValueError as error:
        raise UsageError(f"{source}: no JSON: {error}") from None
    if not isinstance(config, dict):
        raise UsageError(f"{source}: a JSON object is needed")
    for assignment in arguments.set:
        name, sign, value = assignment.partition("=")
        if not sign or not name:
            raise UsageError(f"--set {assignment}: KEY=VALUE is needed")
        try:
            config[name] = json.loads(value)
        except ValueError:
            config[name] = value  # a plain word
    return config
