# SPDX-License-Identifier: BSD-3-Clause
"""SurfaceSynthesis: generative filters on surfaces for VTK.

The VTK filters themselves are here under their own names, to be used beside the modules of ``vtk``::

    from surfacesynthesis import vtkMaternNoiseFilter

Around them are functions that take and return datasets or NumPy arrays and raise exceptions::

    import surfacesynthesis
    mesh = surfacesynthesis.read_mesh("surface.stl")
    mesh = surfacesynthesis.matern_noise(mesh, range=5.0, seed=1)
    surfacesynthesis.write_mesh(mesh, "noise.vtp")

    head = surfacesynthesis.read_volume("head.nii.gz")
    skin = surfacesynthesis.vdb_surface(head, largest_component=True, fill_cavities=True)

    parts = surfacesynthesis.poisson_net(mesh, "segmentation.safetensors", normalisation="surface_area")
    poses = surfacesynthesis.deform(mesh, "poses.safetensors", samples=8)

and a command line, ``python3 -m surfacesynthesis --help``. With PyVista 0.48 or later, its meshes have
``mesh.synthesis.matern(...)``.
"""

import importlib
import importlib.util

from . import accessor as _accessor
from . import vtkSurfaceSynthesisMeshing as _meshing
from ._version import __version__
from .conversion import convert_checkpoint
from .errors import Cancelled, FormatError, SurfaceSynthesisError, SurfaceSynthesisWarning
from .files import read_mesh, read_volume, write_mesh
from .meshing_volumes import vdb_surface
from .mixtures import gaussian_mixtures
from .noise import MODELS, matern_noise
from .poses import poses
from .remeshing import HOLES, remesh, repair, repair_report
from .report import topology_report
from .signal_datasets import read_signal_dataset, write_signal_dataset
from .vtkSurfaceSynthesisMeshing import vtkTopologyReport
from .vtkSurfaceSynthesisNoise import vtkGaussianMixtureFilter, vtkMaternNoiseFilter

__all__ = [
    "Cancelled",
    "FormatError",
    "HOLES",
    "MODELS",
    "SurfaceSynthesisError",
    "SurfaceSynthesisWarning",
    "__version__",
    "convert_checkpoint",
    "gaussian_mixtures",
    "matern_noise",
    "poses",
    "read_mesh",
    "read_signal_dataset",
    "remesh",
    "repair",
    "repair_report",
    "read_volume",
    "vdb_surface",
    "topology_report",
    "vtkGaussianMixtureFilter",
    "vtkMaternNoiseFilter",
    "vtkTopologyReport",
    "write_mesh",
    "write_signal_dataset",
]

# A filter whose library was not there when the package was built is absent; poses(), remesh(), repair() and vdb_surface()
# say so.
for _name in (
    "vtkIsotropicRemeshFilter",
    "vtkPoseEnsembleFilter",
    "vtkSurfaceRepairFilter",
    "vtkTetrahedralizeFilter",
    "vtkVDBSurfaceFilter",
):
    if hasattr(_meshing, _name):
        globals()[_name] = getattr(_meshing, _name)
        __all__.append(_name)
if hasattr(_meshing, "vtkTetrahedralizeFilter"):
    from .tetrahedra import tetrahedralize

    __all__.append("tetrahedralize")

#: What needs LibTorch, which takes a second to load, or shares a module with what does: found on first use, and absent where
#: it was not built.
_LEARNING = {
    "DISTANCES": "metrics",
    "EnsembleMetrics": "metrics",
    "INTEGRATORS": "deformation",
    "deform": "deformation",
    "ensemble_metrics": "metrics",
    "sample_signal": "deformation",
    "train_flow_matching": "training",
    "vtkEnsembleMetrics": "vtkSurfaceSynthesisDeformation",
    "vtkFlowMatchingDeformer": "vtkSurfaceSynthesisDeformation",
    "vtkFlowMatchingSampler": "vtkSurfaceSynthesisDeformation",
    "vtkFlowMatchingTrainer": "vtkSurfaceSynthesisDeformation",
    "FittedLevels": "texture_training",
    "PREPARATIONS": "textures",
    "fit_levels": "texture_training",
    "geometric_texture": "textures",
    "texture_distance": "textures",
    "train_geometric_texture": "texture_training",
    "vtkGeometricTextureDistance": "vtkSurfaceSynthesisGeometry",
    "vtkGeometricTextureSynthesizer": "vtkSurfaceSynthesisGeometry",
    "vtkGeometricTextureTrainer": "vtkSurfaceSynthesisGeometry",
    "vtkMultiscaleMeshFitter": "vtkSurfaceSynthesisGeometry",
    "NORMALISATIONS": "prediction",
    "NetworkOutput": "prediction",
    "poisson_net": "prediction",
    "vtkPoissonNetFilter": "vtkSurfaceSynthesisPrediction",
}
if importlib.util.find_spec(".vtkSurfaceSynthesisPrediction", __package__):
    __all__ += _LEARNING


def __getattr__(name):
    if name in _LEARNING and name in __all__:
        value = getattr(importlib.import_module("." + _LEARNING[name], __name__), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__():
    return sorted({*globals(), *__all__})


_accessor.register()
