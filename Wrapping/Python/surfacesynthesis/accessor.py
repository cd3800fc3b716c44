# SPDX-License-Identifier: BSD-3-Clause
"""``mesh.synthesis`` on PyVista's meshes, where PyVista (0.48 or later) is installed."""

import functools

from .atlases import texture_atlas
from .flow_matching import deform, sample_signal
from .geometric_texture import geometric_texture
from .geometric_texture_from_example import geometric_texture_from_example
from .noise import matern_noise
from .poisson_net import poisson_net
from .remeshing import remesh, repair
from .vdb_surface import vdb_surface


class SynthesisAccessor:
    """The functions of the package as methods of PyVista's PolyData, MultiBlock and ImageData."""

    def __init__(self, mesh):
        self._mesh = mesh

    @functools.wraps(matern_noise, assigned=("__doc__",))
    def matern(self, *arguments, **parameters):
        return matern_noise(self._mesh, *arguments, **parameters)

    @functools.wraps(remesh, assigned=("__doc__",))
    def remesh(self, *arguments, **parameters):
        return remesh(self._mesh, *arguments, **parameters)

    @functools.wraps(repair, assigned=("__doc__",))
    def repair(self, *arguments, **parameters):
        return repair(self._mesh, *arguments, **parameters)

    @functools.wraps(texture_atlas, assigned=("__doc__",))
    def texture_atlas(self, *arguments, **parameters):
        return texture_atlas(self._mesh, *arguments, **parameters)

    @functools.wraps(poisson_net, assigned=("__doc__",))
    def poisson_net(self, *arguments, **parameters):
        return poisson_net(self._mesh, *arguments, **parameters)

    @functools.wraps(deform, assigned=("__doc__",))
    def deform(self, *arguments, **parameters):
        return _wrapped(deform(self._mesh, *arguments, **parameters))

    @functools.wraps(sample_signal, assigned=("__doc__",))
    def sample_signal(self, *arguments, **parameters):
        return _wrapped(sample_signal(self._mesh, *arguments, **parameters))

    @functools.wraps(geometric_texture, assigned=("__doc__",))
    def geometric_texture(self, *arguments, **parameters):
        return _wrapped(geometric_texture(self._mesh, *arguments, **parameters))

    @functools.wraps(geometric_texture_from_example, assigned=("__doc__",))
    def geometric_texture_from_example(self, *arguments, **parameters):
        return _wrapped(geometric_texture_from_example(self._mesh, *arguments, **parameters))

    @functools.wraps(vdb_surface, assigned=("__doc__",))
    def vdb_surface(self, *arguments, **parameters):
        return _wrapped(vdb_surface(self._mesh, *arguments, **parameters))


def _wrapped(dataset):
    """A dataset of VTK's own class, made of one of another class, as PyVista's; or a list of them."""
    import pyvista

    if isinstance(dataset, list):
        return [_wrapped(one) for one in dataset]

    return pyvista.wrap(dataset) if hasattr(pyvista, "wrap") else dataset


def register():
    """Registers the accessor as ``synthesis``; returns whether PyVista is there and has a registry."""
    try:
        import pyvista

        images = getattr(pyvista, "ImageData", None) or getattr(pyvista, "UniformGrid", None)
        for target in filter(None, (pyvista.PolyData, pyvista.MultiBlock, images)):
            pyvista.register_dataset_accessor("synthesis", target)(SynthesisAccessor)
    except Exception:  # absent, too old, or broken: none of which concerns users of plain VTK
        return False
    return True
