# SPDX-License-Identifier: BSD-3-Clause
"""Filters as ParaView's proxies and as classes, side by side."""

from paraview import servermanager
from paraview.simple import TrivialProducer

#: Properties of all trainings, for check_properties().
TRAINING_PROPERTIES = {
    "ModelFileName": ("", "model.safetensors", "model.safetensors"),
    "CheckpointFileName": ("", "a.checkpoint", "a.checkpoint"),
    "LossTableFileName": ("", "a.csv", "a.csv"),
    "CheckpointInterval": (500, 20, 20),
    "Resume": (1, 0, False),
    "TimeBudget": (2.0, 0.0, 0.0),
    "Background": (0, 1, True),
    "DatasetFileName": ("", "data.safetensors", "data.safetensors"),
    "LearningRate": (5e-4, 1e-3, 1e-3),
    "Seed": (0, 7, 7),
}


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


def errors_of(proxy):
    """The errors of an update."""
    proxy.UpdateVTKObjects()
    errors = []

    def note(_caller, _event, text):
        errors.append(text)

    note.CallDataType = "string0"
    proxy.GetClientSideObject().AddObserver("ErrorEvent", note)
    proxy.UpdatePipeline()
    return errors


def check_properties(proxy, properties):
    """Defaults of the proxy, and values that reach the class; by name: (default, or None where it depends on the input,
    another value, what GetX() of the class then returns)."""
    assert set(properties) <= set(proxy.ListProperties())
    for name, (default, other, expected) in properties.items():
        assert default is None or getattr(proxy, name) == default, f"{name} is {getattr(proxy, name)}"
        assert other != default
        setattr(proxy, name, other)
        proxy.UpdateVTKObjects()
        found = getattr(proxy.GetClientSideObject(), "Get" + name)()
        assert found == expected, f"{name} is {found} in the class, expected {expected}"
        assert getattr(proxy, name) == other, f"{name} is {getattr(proxy, name)} in the proxy"
