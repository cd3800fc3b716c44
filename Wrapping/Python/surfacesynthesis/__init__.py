# SPDX-License-Identifier: BSD-3-Clause
"""SurfaceSynthesis: generative filters on surfaces for VTK.

The VTK filters themselves are here under their own names, to be used beside the modules of ``vtk``::

    from surfacesynthesis import vtkMaternNoiseFilter, vtkMaternParameterEstimator

Around them are functions that take and return datasets or NumPy arrays and raise exceptions::

    import surfacesynthesis
    mesh = surfacesynthesis.read_mesh("surface.stl")
    mesh = surfacesynthesis.matern_noise(mesh, range=5.0, seed=1)
    surfacesynthesis.write_mesh(mesh, "noise.vtp")

    head = surfacesynthesis.read_volume("head.nii.gz")
    skin = surfacesynthesis.vdb_surface(head, largest_component=True, fill_cavities=True)

    parts = surfacesynthesis.poisson_net(mesh, "segmentation.safetensors", normalization="surface_area")
    poses = surfacesynthesis.deform(mesh, "poses.safetensors", samples=8)
    bark = surfacesynthesis.sample_texture(mesh, "bark.safetensors", seed=3)

and a command line, ``python3 -m surfacesynthesis --help``. With PyVista 0.48 or later, its meshes have
``mesh.synthesis.matern(...)``.
"""

import importlib
import importlib.util

from .supervision import end_on_interruption as _end_on_interruption

_end_on_interruption()  # of the program, while the modules below are loaded

from . import accessor as _accessor
from . import vtkSurfaceSynthesisEnsembles as _ensembles
from . import vtkSurfaceSynthesisMeshing as _meshing
from ._version import __version__
from .atlases import texture_atlas
from .conversion import convert_checkpoint
from .deprecation import warn_renamed as _warn_renamed
from .displacement_maps import CORRESPONDENCES, VECTOR_SPACES, DisplacementMap, displacement_map
from .distances import SurfaceDistance, surface_distance
from .errors import Cancelled, FormatError, SurfaceSynthesisError, SurfaceSynthesisWarning
from .estimation import MaternEstimate, ParameterEstimate, estimate_matern
from .field_latents import TEXTURE_WRAPS, DecodedTexture, decode_texture, encode_texture
from .files import read_mesh, read_volume, write_mesh
from .files.volumes import volume_from_numpy
from .flow_matching import INTEGRATORS, deform, sample_signal
from .gaussian_mixtures import gaussian_mixtures
from .geometric_texture import (
    NORM_STATISTICS,
    PREPARATIONS,
    add_texture_statistics,
    geometric_texture,
    geometric_texture_distance,
)
from .geometric_texture_features import GeometricTextureFeatures, geometric_texture_features
from .geometric_texture_from_example import geometric_texture_from_example
from .label_surfaces import label_surfaces
from .latent_diffusion import SAMPLERS, TRIANGULATIONS, SampledTexture, sample_texture
from .layout import ensemble_layout
from .metrics import DISTANCES, EnsembleMetrics, ensemble_metrics
from .noise import BOUNDARY_CONDITIONS, NOISE_MODELS, matern_noise
from .pages import find_vtk_js, write_page
from .poisson_net import NORMALIZATIONS, NetworkOutput, poisson_net
from .poses import poses
from .remeshing import HOLES, remesh, repair, repair_measures, repair_report
from .report import topology_report
from .rest_states import rest_states, settle
from .shape_statistics import EnsembleStatistics, ensemble_statistics, shape_model
from .skinning import skin
from .dataset_surfaces import dataset_of_surfaces, surfaces_of_dataset
from .signal_datasets import read_signal_dataset, write_signal_dataset
from .textured_files import read_textured_mesh, write_textured_mesh
from .texture_datasets import TextureDataset, read_texture_dataset, texture_dataset, write_texture_dataset
from .vdb_surface import vdb_surface
from .vtkSurfaceSynthesisEnsembles import (
    vtkElasticRestFilter,
    vtkEnsembleLayoutFilter,
    vtkGaussianMixtureFilter,
    vtkSkinningFilter,
)
from .vtkSurfaceSynthesisFieldLatents import (
    vtkFieldLatentDecoder,
    vtkFieldLatentEncoder,
    vtkFieldLatentTextureFilter,
)
from .vtkSurfaceSynthesisFlowMatching import vtkFlowMatchingDeformer, vtkFlowMatchingSampler
from .vtkSurfaceSynthesisGeometricTexture import vtkGeometricTextureFromExample, vtkGeometricTextureSynthesizer
from .vtkSurfaceSynthesisMeshing import vtkDisplacementMapFilter, vtkLabelSurfaceFilter, vtkTopologyReport
from .vtkSurfaceSynthesisNoise import vtkMaternNoiseFilter, vtkMaternParameterEstimator
from .vtkSurfaceSynthesisPoissonNet import vtkPoissonNetFilter
from .vtkSurfaceSynthesisStatistics import (
    vtkEnsembleMetrics,
    vtkEnsembleStatistics,
    vtkGeometricTextureDistance,
    vtkGeometricTextureFeatures,
    vtkShapeModelSampler,
    vtkSurfaceDistance,
)

__all__ = [
    "BOUNDARY_CONDITIONS",
    "CORRESPONDENCES",
    "Cancelled",
    "DISTANCES",
    "DecodedTexture",
    "DisplacementMap",
    "EnsembleMetrics",
    "EnsembleStatistics",
    "FormatError",
    "GeometricTextureFeatures",
    "HOLES",
    "INTEGRATORS",
    "MaternEstimate",
    "NOISE_MODELS",
    "NORMALIZATIONS",
    "NORM_STATISTICS",
    "NetworkOutput",
    "PREPARATIONS",
    "ParameterEstimate",
    "SAMPLERS",
    "SampledTexture",
    "SurfaceDistance",
    "SurfaceSynthesisError",
    "SurfaceSynthesisWarning",
    "TEXTURE_WRAPS",
    "TRIANGULATIONS",
    "TextureDataset",
    "VECTOR_SPACES",
    "__version__",
    "add_texture_statistics",
    "convert_checkpoint",
    "decode_texture",
    "deform",
    "displacement_map",
    "encode_texture",
    "ensemble_layout",
    "ensemble_metrics",
    "ensemble_statistics",
    "estimate_matern",
    "find_vtk_js",
    "gaussian_mixtures",
    "geometric_texture",
    "geometric_texture_distance",
    "geometric_texture_features",
    "geometric_texture_from_example",
    "label_surfaces",
    "matern_noise",
    "poisson_net",
    "poses",
    "read_mesh",
    "dataset_of_surfaces",
    "surfaces_of_dataset",
    "read_signal_dataset",
    "read_textured_mesh",
    "read_texture_dataset",
    "read_volume",
    "remesh",
    "repair",
    "repair_measures",
    "repair_report",
    "rest_states",
    "sample_signal",
    "sample_texture",
    "settle",
    "shape_model",
    "skin",
    "surface_distance",
    "texture_atlas",
    "texture_dataset",
    "topology_report",
    "vdb_surface",
    "volume_from_numpy",
    "vtkDisplacementMapFilter",
    "vtkElasticRestFilter",
    "vtkEnsembleLayoutFilter",
    "vtkEnsembleMetrics",
    "vtkEnsembleStatistics",
    "vtkFieldLatentDecoder",
    "vtkFieldLatentEncoder",
    "vtkFieldLatentTextureFilter",
    "vtkFlowMatchingDeformer",
    "vtkFlowMatchingSampler",
    "vtkGaussianMixtureFilter",
    "vtkGeometricTextureDistance",
    "vtkGeometricTextureFeatures",
    "vtkGeometricTextureFromExample",
    "vtkGeometricTextureSynthesizer",
    "vtkLabelSurfaceFilter",
    "vtkMaternNoiseFilter",
    "vtkMaternParameterEstimator",
    "vtkPoissonNetFilter",
    "vtkShapeModelSampler",
    "vtkSkinningFilter",
    "vtkSurfaceDistance",
    "vtkTopologyReport",
    "write_mesh",
    "write_page",
    "write_signal_dataset",
    "write_textured_mesh",
    "write_texture_dataset",
]

# A filter whose library was not there when the package was built is absent; poses(), remesh(), repair(), texture_atlas()
# and vdb_surface() say so.
for _module, _name in (
    (_ensembles, "vtkPoseEnsembleFilter"),
    (_meshing, "vtkIsotropicRemeshFilter"),
    (_meshing, "vtkSurfaceRepairFilter"),
    (_meshing, "vtkTetrahedralizeFilter"),
    (_meshing, "vtkTextureAtlasFilter"),
    (_meshing, "vtkVDBSurfaceFilter"),
):
    if hasattr(_module, _name):
        globals()[_name] = getattr(_module, _name)
        __all__.append(_name)
if hasattr(_meshing, "vtkTetrahedralizeFilter"):
    from .tetrahedra import tetrahedralize

    __all__.append("tetrahedralize")

#: Training needs LibTorch, which takes a second to load: found on first use, and absent where it was not built.
_TRAINING = {
    "FittedLevels": "geometric_texture_training",
    "fit_levels": "geometric_texture_training",
    "latent_dataset": "latent_diffusion_training",
    "train_field_latents": "field_latent_training",
    "train_flow_matching": "flow_matching_training",
    "train_geometric_texture": "geometric_texture_training",
    "train_latent_diffusion": "latent_diffusion_training",
    "vtkFieldLatentTrainer": "vtkSurfaceSynthesisTraining",
    "vtkFlowMatchingTrainer": "vtkSurfaceSynthesisTraining",
    "vtkGeometricTextureTrainer": "vtkSurfaceSynthesisTraining",
    "vtkLatentDiffusionTrainer": "vtkSurfaceSynthesisTraining",
    "vtkMultiscaleMeshFitter": "vtkSurfaceSynthesisTraining",
}
if importlib.util.find_spec(".vtkSurfaceSynthesisTraining", __package__):
    __all__ += _TRAINING


#: Former names, which go on working with a warning: the module and the name that they stand for.
_FORMER = {
    "MODELS": ("noise", "NOISE_MODELS"),
    "NORMALISATIONS": ("poisson_net", "NORMALIZATIONS"),
    "texture_distance": ("geometric_texture", "geometric_texture_distance"),
}


def __getattr__(name):
    if name in _FORMER:
        module, successor = _FORMER[name]
        _warn_renamed(f"surfacesynthesis.{name}", f"surfacesynthesis.{successor}")
        return getattr(importlib.import_module("." + module, __name__), successor)
    if name in _TRAINING and name in __all__:
        value = getattr(importlib.import_module("." + _TRAINING[name], __name__), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__():
    return sorted({*globals(), *__all__})


_accessor.register()
