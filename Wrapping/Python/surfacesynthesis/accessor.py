# SPDX-License-Identifier: BSD-3-Clause
"""``mesh.synthesis`` on PyVista's meshes, where PyVista (0.48 or later) is installed."""

import functools

from .noise import matern_noise
from .remeshing import remesh, repair


class SynthesisAccessor:
    """The functions of the package as methods of PyVista's PolyData and MultiBlock."""

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


def register():
    """Registers the accessor as ``synthesis``; returns whether PyVista is there and has a registry."""
    try:
        import pyvista

        for target in (pyvista.PolyData, pyvista.MultiBlock):
            pyvista.register_dataset_accessor("synthesis", target)(SynthesisAccessor)
    except Exception:  # absent, too old, or broken: none of which concerns users of plain VTK
        return False
    return True
