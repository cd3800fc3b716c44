# SPDX-License-Identifier: BSD-3-Clause
"""SurfaceSynthesis: generative filters on surfaces for VTK.

The VTK filters themselves are here under their own names, to be used beside the modules of ``vtk``::

    from surfacesynthesis import vtkMaternNoiseFilter

Around them are functions that take and return datasets or NumPy arrays and raise exceptions::

    import surfacesynthesis
    mesh = surfacesynthesis.read_mesh("surface.stl")
    mesh = surfacesynthesis.matern_noise(mesh, range=5.0, seed=1)
    surfacesynthesis.write_mesh(mesh, "noise.vtp")

and a command line, ``python3 -m surfacesynthesis --help``. With PyVista 0.48 or later, its meshes have
``mesh.synthesis.matern(...)``.
"""

from . import accessor as _accessor
from ._version import __version__
from .errors import Cancelled, FormatError, SurfaceSynthesisError, SurfaceSynthesisWarning
from .files import read_mesh, write_mesh
from .noise import MODELS, matern_noise
from .remeshing import HOLES, remesh, repair, repair_report
from .vtkSurfaceSynthesisNoise import vtkMaternNoiseFilter

try:  # CGAL is optional
    from .vtkSurfaceSynthesisMeshing import vtkIsotropicRemeshFilter, vtkSurfaceRepairFilter
except ImportError:
    pass

__all__ = [
    "Cancelled",
    "FormatError",
    "HOLES",
    "MODELS",
    "SurfaceSynthesisError",
    "SurfaceSynthesisWarning",
    "__version__",
    "matern_noise",
    "read_mesh",
    "remesh",
    "repair",
    "repair_report",
    "vtkMaternNoiseFilter",
    "write_mesh",
]

_accessor.register()
