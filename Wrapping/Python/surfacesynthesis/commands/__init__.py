# SPDX-License-Identifier: BSD-3-Clause
"""The commands of the command line, one module each with a function ``add(commands)``."""

from .. import vtkSurfaceSynthesisMeshing as _meshing
from . import noise, report, tetrahedralize

#: In the order of the help text. A command whose filter was not built is absent.
COMMANDS = [report, noise]
if hasattr(_meshing, "vtkTetrahedralizeFilter"):
    COMMANDS.append(tetrahedralize)
