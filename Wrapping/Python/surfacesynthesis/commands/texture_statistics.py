# SPDX-License-Identifier: BSD-3-Clause
"""The command ``texture-statistics``."""

from .common import Outcome, add_command, add_printing_options, as_usage

_DESCRIPTION = """\
Writes a model of a geometric texture with the statistics that normalize its channels, measured on samples of its template:
for models of earlier versions, and converted ones. Trainings write them."""
_EPILOG = """\
examples:
  %(prog)s old-scales.safetensors scales.safetensors
"""


def add(commands):
    """Adds the command to the parser."""
    parser = add_command(
        commands, "texture-statistics", "MODEL OUTPUT", "measure the statistics of a geometric texture", _DESCRIPTION, _EPILOG
    )
    parser.set_defaults(run=run)
    parser.add_argument("model", metavar="MODEL", help="model file to read (safetensors)")
    parser.add_argument("output", metavar="OUTPUT", help="model file to write (safetensors)")
    parser.add_argument("--measured-samples", type=int, default=8, metavar="N", help="1 to 1000 (default: 8)")
    add_printing_options(parser.add_argument_group("output"))


def run(arguments):
    """The command ``texture-statistics``."""
    from ..geometric_texture import add_texture_statistics

    as_usage(add_texture_statistics, arguments.model, arguments.output, arguments.measured_samples)
    return Outcome(f"statistics of {arguments.measured_samples} samples", {"measured_samples": arguments.measured_samples}, [arguments.output])
