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
from . import vtkSurfaceSynthesisMeshing as _meshing
from ._version import __version__
from .errors import Cancelled, FormatError, SurfaceSynthesisError, SurfaceSynthesisWarning
from .files import read_mesh, write_mesh
from .noise import MODELS, matern_noise
from .report import topology_report
from .vtkSurfaceSynthesisMeshing import vtkTopologyReport
from .vtkSurfaceSynthesisNoise import vtkMaternNoiseFilter

__all__ = [
    "Cancelled",
    "FormatError",
    "MODELS",
    "SurfaceSynthesisError",
    "SurfaceSynthesisWarning",
    "__version__",
    "matern_noise",
    "read_mesh",
    "topology_report",
    "vtkMaternNoiseFilter",
    "vtkTopologyReport",
    "write_mesh",
]

# A filter whose library was not there when the package was built is absent.
if hasattr(_meshing, "vtkTetrahedralizeFilter"):
    from .tetrahedra import tetrahedralize
    from .vtkSurfaceSynthesisMeshing import vtkTetrahedralizeFilter

    __all__ += ["tetrahedralize", "vtkTetrahedralizeFilter"]

_accessor.register()
