# SPDX-License-Identifier: BSD-3-Clause
"""The commands of the command line, one module each with a function ``add(commands)``."""

from . import noise, remesh, repair

#: In the order of the help text.
COMMANDS = [noise, remesh, repair]
