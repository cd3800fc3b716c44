# SPDX-License-Identifier: BSD-3-Clause
"""State files (.pvsm and .py) bring back the pipeline, in another process, bit for bit."""

import os
import subprocess
import sys

import surfaces
from paraview import servermanager, smstate
from paraview.simple import *  # noqa: F403: as scripts of ParaView do

PROPERTIES = {
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


def write_states():
    LoadPlugin(surfaces.plugin(), remote=False, ns=globals())
    surfaces.write(surfaces.ball(), "state_ball.vtp")
    reader = XMLPolyDataReader(registrationName="surface", FileName=[os.path.abspath("state_ball.vtp")])
    made = MaternNoise(registrationName="noise", Input=reader, **PROPERTIES)
    warped = WarpByVector(registrationName="warped", Input=made, Vectors=["POINTS", "Bumps_6"], ScaleFactor=0.01)
    warped.UpdatePipeline()
    surfaces.write(servermanager.Fetch(warped), "state_expected.vtp")
    SaveState("state.pvsm")
    with open("state.py", "w", encoding="utf-8") as file:  # SaveState() of this ParaView writes XML whatever the name
        file.write(smstate.get_state())


def compare_with_written():
    made, warped = FindSource("noise"), FindSource("warped")
    assert made is not None and warped is not None, [name for name, _ in GetSources()]
    for name, expected in PROPERTIES.items():
        assert getattr(made, name) == expected, f"{name} is {getattr(made, name)}"
    warped.UpdatePipeline()
    found, expected = servermanager.Fetch(warped), surfaces.read("state_expected.vtp")
    for name in ("Bumps_5", "Bumps_6"):
        surfaces.assert_same(surfaces.array(found, name), surfaces.array(expected, name), name)
    surfaces.assert_same(
        surfaces.vtk_to_numpy(found.GetPoints().GetData()),
        surfaces.vtk_to_numpy(expected.GetPoints().GetData()), "points")


def xml_state():
    LoadPlugin(surfaces.plugin(), remote=False, ns=globals())
    LoadState("state.pvsm")
    compare_with_written()


def python_state():
    LoadPlugin(surfaces.plugin(), remote=False, ns=globals())
    with open("state.py", encoding="utf-8") as file:
        text = file.read()
    assert "MaternNoise(" in text
    exec(compile(text, "state.py", "exec"), dict(globals()))
    compare_with_written()


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
    surfaces.run({"xml_state": xml_state, "python_state": python_state}[sys.argv[1]])
else:
    surfaces.run(write_states, xml_state_round_trip, python_state_round_trip)
