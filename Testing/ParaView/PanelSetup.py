# SPDX-License-Identifier: BSD-3-Clause
"""Run by paraview when it starts, for TestPanel.py: loads the plugin, makes a surface, records trace, errors and state.

The record is written anew whenever the filter that is tested has been updated, or tried to be."""

import json
import os

import surfaces
import surfacesynthesis
from paraview import servermanager, smtrace
from paraview.simple import *  # noqa: F403: as scripts of ParaView do
from vtkmodules.util.vtkConstants import VTK_STRING

LoadPlugin(surfaces.plugin(), remote=False, ns=globals())
for name in ("vtkGaussianMixtureFilter", "vtkPoseEnsembleFilter", "vtkFlowMatchingDeformer",
             "vtkGeometricTextureSynthesizer", "vtkMultiscaleMeshFitter", "vtkVDBSurfaceFilter", "vtkPoissonNetFilter"):
    getattr(surfacesynthesis, name, None)  # makes the getters of the class known, where the plugin has it
errors = []
watched = set()


def note_error(caller, name, text):
    errors.append(text)


note_error.CallDataType = VTK_STRING


def record(made):
    """Writes what the object of the class holds; of a table its rows as points."""
    names = os.environ["SURFACE_SYNTHESIS_PROPERTIES"].split(",")
    output = made.GetOutputDataObject(0)
    with open(os.environ["SURFACE_SYNTHESIS_RECORD"], "w", encoding="utf-8") as file:
        json.dump({
            "properties": {name: getattr(made, "Get" + name)() for name in names},
            "points": output.GetNumberOfRows() if output.IsA("vtkTable") else output.GetNumberOfPoints(),
            "errors": errors,
            "trace": smtrace.get_current_trace_output(),
        }, file)


def watch(*_):
    """Follows the filter as soon as there is one."""
    for proxy in GetSources().values():
        made = proxy.GetClientSideObject()
        if proxy.GetXMLName() == os.environ["SURFACE_SYNTHESIS_FILTER"] and made is not None and proxy.GetGlobalID() not in watched:
            watched.add(proxy.GetGlobalID())
            made.AddObserver("ErrorEvent", note_error)
            made.AddObserver("EndEvent", lambda caller, _: record(caller))


path = surfaces.write(getattr(surfaces, os.environ["SURFACE_SYNTHESIS_SURFACE"])(), "panel_surface.vtp")
smtrace.start_trace(preamble="")
surface = XMLPolyDataReader(registrationName="surface", FileName=[path])
surface.UpdatePipeline()
Show(surface)
ResetCamera()
SetActiveSource(surface)
servermanager.ProxyManager().SMProxyManager.AddObserver("RegisterEvent", watch)
