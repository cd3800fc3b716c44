# SPDX-License-Identifier: BSD-3-Clause
"""State files (.pvsm and .py) bring back the pipeline, in another process, bit for bit."""

import contextlib
import os
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

import numpy as np
import surfaces
from paraview import servermanager, smstate
from paraview.simple import *  # noqa: F403: as scripts of ParaView do

WITH_NETWORKS = os.environ["SURFACE_SYNTHESIS_LEARNING"] == "1"
NOISE = {
    "NoiseModel": "Spectral",
    "ScaleMode": "Screening",
    "CorrelationRange": 1.25,
    "StandardDeviation": 2.5,
    "Screening": 12.0,
    "NormalizedScreening": 1e-3,
    "NumberOfEigenpairs": 20,
    "Seed": -7,
    "NumberOfSamples": 2,
    "FirstSample": 5,
    "NumberOfComponents": 3,
    "OutputArrayName": "Bumps",
}


MIXTURE = {
    "NumberOfCenters": 2,
    "Width": 0.1,
    "Separation": 2.5,
    "Seed": 9,
    "NumberOfSamples": 2,
    "FirstSample": 3,
    "OutputArrayName": "Gaussians",
}
FLOW = {
    "ModelFileName": os.path.abspath("state_model.safetensors"),
    "Seed": -2,
    "FirstSample": 1,
    "NumberOfSamples": 2,
    "NumberOfSteps": 3,
    "Integrator": "Euler",
    "NumberOfCorrections": 1,
    "Temperature": 1.25,
    "OutputTrajectory": 1,
    "InitialNoiseArrayName": "Start",
}
DEFORMER = {**FLOW, "MovePoints": 0, "DisplacementArrayName": "Way", "AreaRatioArrayName": "Stretch"}
METRICS = {"ArrayName": "Gaussians", "Distance": "RMS", "RemoveCentroid": 1}
TRAINER = {
    "ModelFileName": os.path.abspath("state_trained.safetensors"),
    "LossTableFileName": os.path.abspath("state_losses.csv"),
    "CheckpointInterval": 2,
    "SignalArrayName": "Gaussians",
    "EncoderIterations": 0,
    "NumberOfEigenfunctions": 5,
    "Width": 8,
    "Blocks": 1,
    "ComplexLayers": 2,
    "Iterations": 3,
    "BatchSize": 2,
    "Milestones": [1, 2],
    "Seed": 4,
    "Device": "CPU",
}
#: Properties by the name that the pipeline gives a filter.
PROPERTIES = {"noise": NOISE, "mixture": MIXTURE}
if WITH_NETWORKS:
    PROPERTIES.update({"deformer": DEFORMER, "metrics": METRICS, "trainer": TRAINER})


def write_states():
    LoadPlugin(surfaces.plugin(), remote=False, ns=globals())
    surfaces.write(surfaces.ball(), "state_ball.vtp")
    reader = XMLPolyDataReader(registrationName="surface", FileName=[os.path.abspath("state_ball.vtp")])
    made = MaternNoise(registrationName="noise", Input=reader, **NOISE)
    mixture = GaussianMixture(registrationName="mixture", Input=reader, **MIXTURE)
    surfaces.write(servermanager.Fetch(updated(mixture)), "state_mixture.vtp")
    if WITH_NETWORKS:
        make_networks(reader, mixture)
    warped = WarpByVector(registrationName="warped", Input=made, Vectors=["POINTS", "Bumps_6"], ScaleFactor=0.01)
    warped.UpdatePipeline()
    surfaces.write(servermanager.Fetch(warped), "state_expected.vtp")
    SaveState("state.pvsm")
    with open("state.py", "w", encoding="utf-8") as file:  # SaveState() of this ParaView writes XML whatever the name
        file.write(smstate.get_state())


def make_networks(reader, mixture):
    """Filters with several inputs, and one whose times are of its own making."""
    from flow_models import model

    model(FLOW["ModelFileName"])
    deformer = FlowMatchingDeformer(registrationName="deformer", Input=reader, **DEFORMER)
    deformer.UpdatePipeline(0.5)
    np.save("state_way.npy", surfaces.array(servermanager.Fetch(deformer).GetBlock(0), "Way"))
    EnsembleMetrics(registrationName="metrics", Input=mixture, Reference=mixture, **METRICS)
    with contextlib.suppress(FileNotFoundError):
        os.remove(TRAINER["ModelFileName"] + ".checkpoint")  # of an earlier run
    updated(FlowMatchingTrainer(registrationName="trainer", Input=reader, Samples=mixture, **TRAINER))
    os.rename(TRAINER["ModelFileName"], "state_trained_first.safetensors")


def updated(proxy):
    proxy.UpdatePipeline()
    return proxy


def compare_with_written():
    for source, properties in PROPERTIES.items():
        made = FindSource(source)
        assert made is not None, [name for name, _ in GetSources()]
        for name, expected in properties.items():
            found = getattr(made, name)
            assert (list(found) if isinstance(expected, list) else found) == expected, f"{source}: {name} is {found}"
    mixture, expected = servermanager.Fetch(updated(FindSource("mixture"))), surfaces.read("state_mixture.vtp")
    for name in ("Gaussians_3", "Gaussians_4"):
        surfaces.assert_same(surfaces.array(mixture, name), surfaces.array(expected, name), name)
    if WITH_NETWORKS:
        compare_networks()
    warped = updated(FindSource("warped"))
    found, expected = servermanager.Fetch(warped), surfaces.read("state_expected.vtp")
    for name in ("Bumps_5", "Bumps_6"):
        surfaces.assert_same(surfaces.array(found, name), surfaces.array(expected, name), name)
    surfaces.assert_same(
        surfaces.vtk_to_numpy(found.GetPoints().GetData()),
        surfaces.vtk_to_numpy(expected.GetPoints().GetData()), "points")


def compare_networks():
    deformer = FindSource("deformer")
    deformer.UpdatePipeline(0.5)
    way = surfaces.array(servermanager.Fetch(deformer).GetBlock(0), "Way")
    surfaces.assert_same(way, np.load("state_way.npy"), "Way")
    table = servermanager.Fetch(updated(FindSource("metrics")))
    assert table.GetNumberOfRows() == 1 and table.GetValueByName(0, "MMD").ToDouble() == 0.0, "of an ensemble and itself"
    updated(FindSource("trainer"))  # from its checkpoint
    with open(TRAINER["ModelFileName"], "rb") as found, open("state_trained_first.safetensors", "rb") as expected:
        assert found.read() == expected.read()
    os.remove(TRAINER["ModelFileName"])


def xml_state():
    LoadPlugin(surfaces.plugin(), remote=False, ns=globals())
    LoadState("state.pvsm")
    compare_with_written()


def python_state():
    LoadPlugin(surfaces.plugin(), remote=False, ns=globals())
    with open("state.py", encoding="utf-8") as file:
        text = file.read()
    assert "MaternNoise(" in text and "GaussianMixture(" in text
    exec(compile(text, "state.py", "exec"), dict(globals()))
    compare_with_written()


#: Former names of properties, by filter, with their successors and values that are no defaults.
FORMER_NAMES = {
    "GaussianMixture": {"NumberOfCentres": ("NumberOfCenters", 7)},
    "PoissonNet": {"InputNormalisation": ("InputNormalization", "Unit Sphere")},
    "FlowMatchingDeformer": {"InputNoiseArray": ("InputNoiseArrayName", "Start")},
    "GeometricTextureTrainer": {"LeastChannels": ("MinimumChannels", 8), "MostChannels": ("MaximumChannels", 48)},
    "IsotropicRemesh": {"SizingArray": ("SizingArrayName", "size")},
}


def filters_with_former_names():
    return {name: names for name, names in FORMER_NAMES.items() if name in globals()}


def write_former_state():
    """A state as it was written before the names changed: former names in place of their successors."""
    LoadPlugin(surfaces.plugin(), remote=False, ns=globals())
    ball = Sphere(registrationName="ball")
    for name, names in filters_with_former_names().items():
        made = globals()[name](registrationName=name, Input=ball)
        for successor, value in names.values():
            setattr(made, successor, value)
    SaveState("former.pvsm")
    state = ElementTree.parse("former.pvsm")
    for name, names in filters_with_former_names().items():
        (proxy,) = [element for element in state.iter("Proxy") if element.get("type") == name]
        for former, (successor, _) in names.items():
            rows = {element.get("name"): element for element in proxy.findall("Property")}
            proxy.remove(rows[former])
            rows[successor].set("name", former)
            rows[successor].set("id", rows[successor].get("id").replace(successor, former))
    state.write("former.pvsm")


def former_state():
    LoadPlugin(surfaces.plugin(), remote=False, ns=globals())
    LoadState("former.pvsm")
    assert len(filters_with_former_names()) >= 3
    for name, names in filters_with_former_names().items():
        made = FindSource(name)
        for former, (successor, value) in names.items():
            assert getattr(made, successor) == value, f"{name}: {successor} is {getattr(made, successor)}"
            assert len(made.GetProperty(former)) == 0, f"{name}: {former} is still set"
    import surfacesynthesis  # makes the getters of the class known

    assert surfacesynthesis.vtkPoissonNetFilter.UNIT_SPHERE == FindSource(
        "PoissonNet").GetClientSideObject().GetInputNormalization(), "the value has not reached the class"


def scripts_use_former_names():
    """Attributes of former names reach the class."""
    LoadPlugin(surfaces.plugin(), remote=False, ns=globals())
    ball = Sphere()
    for name, names in filters_with_former_names().items():
        made = globals()[name](Input=ball)
        for former, (_, value) in names.items():
            setattr(made, former, value)
            made.UpdateVTKObjects()
            assert str(list(made.GetProperty(former))[0]) in (str(value), "3"), (name, former)


def former_names_round_trip():
    in_another_process("write_former_state")
    in_another_process("former_state")


def in_another_process(name):
    result = subprocess.run(
        [os.environ["SURFACE_SYNTHESIS_PVPYTHON"], os.path.abspath(__file__), name],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=100)
    assert result.returncode == 0 and "1 of 1 tests passed" in result.stdout, result.stdout


def xml_state_round_trip():
    in_another_process("xml_state")


def python_state_round_trip():
    in_another_process("python_state")


if len(sys.argv) > 1:
    tests = {"xml_state": xml_state, "python_state": python_state, "former_state": former_state,
             "write_former_state": write_former_state}
    surfaces.run(tests[sys.argv[1]])
else:
    surfaces.run(write_states, xml_state_round_trip, python_state_round_trip, former_names_round_trip,
                 scripts_use_former_names)
