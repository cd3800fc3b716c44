# SPDX-License-Identifier: BSD-3-Clause
"""The commands of the command line, one module each with a function ``add(commands)``."""

from . import noise, remesh, repair, surface

#: In the order of the help text.
COMMANDS = [repair, remesh, surface, noise]
