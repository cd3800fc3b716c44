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

and a command line, ``python3 -m surfacesynthesis --help``. With PyVista 0.48 or later, its meshes have
``mesh.synthesis.matern(...)``.
"""

from . import accessor as _accessor
from ._version import __version__
from .errors import Cancelled, FormatError, SurfaceSynthesisError, SurfaceSynthesisWarning
from .files import read_mesh, read_volume, write_mesh
from .meshing_volumes import vdb_surface
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
    "read_volume",
    "vdb_surface",
    "vtkMaternNoiseFilter",
    "write_mesh",
]

try:
    from .vtkSurfaceSynthesisMeshing import vtkVDBSurfaceFilter
except ImportError:  # built without OpenVDB: the filter is absent, and vdb_surface() says so
    pass
else:
    __all__.append("vtkVDBSurfaceFilter")

_accessor.register()
