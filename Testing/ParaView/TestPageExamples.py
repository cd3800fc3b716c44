# SPDX-License-Identifier: BSD-3-Clause
"""The examples in ParaView on the pages of all filters: each makes its filter with the values that it names, and those of
filters that need no model, no measured data and no minutes are run."""

import os
import sys

import surfaces
from paraview.simple import *  # noqa: F403: as scripts of ParaView do

LoadPlugin(surfaces.plugin(), remote=False, ns=globals())
sys.path.append(os.path.join(os.environ["SURFACE_SYNTHESIS_EXAMPLES"], os.pardir, "Documentation"))
import generate  # noqa: E402
from filter_examples import FILTERS  # noqa: E402

#: Filters whose input is an image.
OF_IMAGES = ("vtkLabelSurfaceFilter",)
#: Those that run on a sphere in a second.
QUICK = ("vtkTopologyReport", "vtkVDBSurfaceFilter", "vtkSurfaceRepairFilter", "vtkTextureAtlasFilter", "vtkMaternNoiseFilter",
         "vtkGaussianMixtureFilter", "vtkSurfaceDistance", "vtkTetrahedralizeFilter")


def elements_of(result, key):
    """The elements of a property, as the server manager has them."""
    found = result.SMProxy.GetProperty(key)
    return [found.GetElement(k) for k in range(found.GetNumberOfElements())]


def example_of(name, last_line):
    """The result of an example, with or without its last line, which updates it."""
    proxy = generate.proxies()[name]
    code = generate.example_in_paraview(name, proxy, FILTERS[name])
    lines = code.splitlines()
    assert lines[-1] == "result.UpdatePipeline()"
    sphere = Sphere(ThetaResolution=24, PhiResolution=24)
    given = {other.lower(): Sphere(ThetaResolution=24, PhiResolution=24, Radius=0.6) for other in FILTERS[name].inputs}
    names = {**globals(), **given, "surface": Wavelet() if name in OF_IMAGES else sphere}
    exec("\n".join(lines if last_line else lines[:-1]), names)
    return names["result"]


def each_example_makes_its_filter():
    assert len(FILTERS) > 20
    for name, example in FILTERS.items():
        result = example_of(name, False)
        for key, value in example.properties.items():
            wanted = list(value) if isinstance(value, (list, tuple)) else [value]
            assert elements_of(result, key) == wanted, (name, key, elements_of(result, key), value)


def quick_examples_run():
    for name in QUICK:
        result = example_of(name, True)
        information = result.GetDataInformation()
        rows = information.GetNumberOfRows() if name in ("vtkTopologyReport",) else information.GetNumberOfPoints()
        assert rows > 0, name


surfaces.run(each_example_makes_its_filter, quick_examples_run)
