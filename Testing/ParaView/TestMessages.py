# SPDX-License-Identifier: BSD-3-Clause
"""Messages in pvpython: one error that names the defect and the remedy for a bad surface, none for a valid one."""

import os
import re
import subprocess
import sys

import surfaces

SCRIPT = """
import surfaces
from paraview.simple import *
LoadPlugin(surfaces.plugin(), remote=False, ns=globals())
made = MaternNoise(Input=XMLPolyDataReader(FileName=["{file}"]), CorrelationRange=1.0)
made.UpdatePipeline()
assert made.GetDataInformation().GetNumberOfPoints() == {points}
{more}
print("finished")
"""


def told_by(file, points, more=""):
    """The lines of errors and warnings of a pvpython that runs the filter on a file."""
    result = subprocess.run(
        [os.environ["SURFACE_SYNTHESIS_PVPYTHON"], "-c", SCRIPT.format(file=file, points=points, more=more)],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=100)
    assert result.returncode == 0 and "finished" in result.stdout, result.stdout
    return [line for line in result.stdout.splitlines() if line.strip() not in ("finished", "")]


def a_valid_surface_gives_no_message():
    """Not even about the widget of the seed, which only the graphical interface has."""
    mesh = surfaces.ball()
    surfaces.write(mesh, "sound.vtp")
    told = told_by("sound.vtp", mesh.GetNumberOfPoints())
    assert told == [], told


def an_error_names_defect_and_remedy():
    surfaces.write(surfaces.fin(), "fin.vtp")
    told = told_by("fin.vtp", 0)
    ours = [line for line in told if re.search(r"ERR\| vtkMaternNoiseFilter", line)]
    assert len(ours) == 1, told
    for words in ("1 non-manifold edge", "more than two triangles", "Feature Edges shows them", "Surface Repair", "Clean"):
        assert words in ours[0], (words, ours)


def the_pipeline_works_again_after_an_error():
    mesh = surfaces.ball()
    surfaces.write(surfaces.fin(), "mended.vtp")
    surfaces.write(mesh, "sound.vtp")
    told = told_by("mended.vtp", 0, more=f"""
made.Input = XMLPolyDataReader(FileName=["sound.vtp"])
made.UpdatePipeline()
assert made.GetDataInformation().GetNumberOfPoints() == {mesh.GetNumberOfPoints()}
assert made.PointData["MaternNoise"] is not None
""")
    assert any("non-manifold" in line for line in told), told


def a_volume_is_not_offered():
    """The menu entry is grey for data that is no surface; a script is told so by ParaView."""
    told = subprocess.run(
        [os.environ["SURFACE_SYNTHESIS_PVPYTHON"], "-c", """
import surfaces
from paraview.simple import *
LoadPlugin(surfaces.plugin(), remote=False, ns=globals())
from paraview import servermanager
wavelet = Wavelet()
wavelet.UpdatePipeline()
prototype = servermanager.ProxyManager().GetPrototypeProxy("filters", "MaternNoise")
domain = prototype.GetProperty("Input").GetDomain("input_type")
for source, accepted in ((wavelet, 0), (Sphere(), 1), (GroupDatasets(Input=[Sphere(), Sphere()]), 1)):
    source.UpdatePipeline()
    assert domain.IsInDomain(source.SMProxy, 0) == accepted, source
print("finished")
"""], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=100)
    assert told.returncode == 0 and "finished" in told.stdout, told.stdout


if __name__ == "__main__":
    assert len(sys.argv) == 1
    surfaces.run(
        a_valid_surface_gives_no_message,
        an_error_names_defect_and_remedy,
        the_pipeline_works_again_after_an_error,
        a_volume_is_not_offered,
    )
