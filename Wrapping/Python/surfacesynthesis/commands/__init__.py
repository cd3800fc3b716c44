# SPDX-License-Identifier: BSD-3-Clause
"""The commands of the command line, one module each with a function ``add(commands)``."""

import importlib.util

from .. import vtkSurfaceSynthesisMeshing as _meshing
from . import (
    convert,
    dataset,
    deform,
    levels,
    metrics,
    noise,
    predict,
    remesh,
    repair,
    report,
    surface,
    tetrahedralize,
    texture,
    texture_distance,
    train,
)

#: In the order of the help text, and of most pipelines. A command whose filter was not built is absent.
COMMANDS = [
    command
    for command, needed in (
        (report, "vtkTopologyReport"),
        (surface, "vtkVDBSurfaceFilter"),
        (repair, "vtkSurfaceRepairFilter"),
        (remesh, "vtkIsotropicRemeshFilter"),
        (tetrahedralize, "vtkTetrahedralizeFilter"),
    )
    if hasattr(_meshing, needed)
] + [noise, dataset]
if importlib.util.find_spec("..vtkSurfaceSynthesisPrediction", __package__):  # found without loading LibTorch
    COMMANDS.append(predict)
if importlib.util.find_spec("..vtkSurfaceSynthesisDeformation", __package__):
    COMMANDS += [train, deform, metrics]
if importlib.util.find_spec("..vtkSurfaceSynthesisGeometry", __package__):
    COMMANDS += [levels, texture, texture_distance]
COMMANDS.append(convert)
