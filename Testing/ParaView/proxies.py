# SPDX-License-Identifier: BSD-3-Clause
"""Filters as ParaView's proxies and as classes, side by side."""

from paraview import servermanager
from paraview.simple import TrivialProducer


def source_of(mesh):
    source = TrivialProducer()
    source.GetClientSideObject().SetOutput(mesh)
    source.MarkModified(None)
    return source


def output_of(proxy):
    proxy.UpdatePipeline()
    return servermanager.Fetch(proxy)


def made_by(algorithm, mesh, **properties):
    """The output of the class without ParaView."""
    algorithm.SetInputDataObject(mesh)
    for name, value in properties.items():
        getattr(algorithm, "Set" + name)(value)
    algorithm.Update()
    return algorithm.GetOutputDataObject(0)


def check_properties(proxy, properties):
    for name, (default, other, expected) in properties.items():
        assert getattr(proxy, name) == default, f"{name} is {getattr(proxy, name)}"
        setattr(proxy, name, other)
        proxy.UpdateVTKObjects()
        found = getattr(proxy.GetClientSideObject(), "Get" + name)()
        assert found == expected, f"{name} is {found} in the class, expected {expected}"
