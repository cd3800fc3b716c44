# SPDX-License-Identifier: BSD-3-Clause
"""The commands of the command line, one module each with a function ``add(commands)``."""

import importlib.util

from .. import vtkSurfaceSynthesisMeshing as _meshing
from . import (
    convert,
    dataset,
    deform,
    displacement_map,
    distance,
    estimate,
    field_latents,
    geometric_texture,
    geometric_texture_distance,
    geometric_texture_features,
    geometric_texture_from_example,
    label_surfaces,
    latent_diffusion,
    levels,
    metrics,
    noise,
    poisson_net,
    remesh,
    repair,
    report,
    settle,
    shape_model,
    skin,
    statistics,
    surface,
    tetrahedralize,
    texture_atlas,
    texture_statistics,
    train,
    view,
)

#: In the order of the help text, and of most pipelines. A command whose filter was not built is absent.
COMMANDS = [
    command
    for command, needed in (
        (report, "vtkTopologyReport"),
        (surface, "vtkVDBSurfaceFilter"),
        (label_surfaces, "vtkLabelSurfaceFilter"),
        (repair, "vtkSurfaceRepairFilter"),
        (remesh, "vtkIsotropicRemeshFilter"),
        (tetrahedralize, "vtkTetrahedralizeFilter"),
        (texture_atlas, "vtkTextureAtlasFilter"),
        (displacement_map, "vtkDisplacementMapFilter"),
    )
    if hasattr(_meshing, needed)
] + [noise, estimate, dataset, poisson_net, deform, settle, skin, metrics, distance, statistics, shape_model]
COMMANDS += [geometric_texture, geometric_texture_from_example, geometric_texture_distance, geometric_texture_features]
COMMANDS += [texture_statistics, field_latents, latent_diffusion]
if importlib.util.find_spec("..vtkSurfaceSynthesisTraining", __package__):  # found without loading LibTorch
    COMMANDS += [train, levels]
COMMANDS += [view, convert]

#: Commands that write what they have reached when they are interrupted, and need their time for it.
TRAININGS = ("train", "levels")

#: Former names of commands, and their new ones.
FORMER_COMMANDS = {
    "predict": "poisson-net",
    "texture": "geometric-texture",
    "texture-distance": "geometric-texture-distance",
}
