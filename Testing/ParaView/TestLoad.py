# SPDX-License-Identifier: BSD-3-Clause
"""The plugin loads, makes its filter and runs it: in pvpython, pvbatch and paraview."""

import surfaces
from paraview import servermanager
from paraview.simple import *  # noqa: F403: as scripts of ParaView do


def load():
    name = "SurfaceSynthesis"
    loaded = servermanager.vtkSMProxyManager.GetProxyManager().GetPluginManager()
    session = servermanager.ActiveConnection.Session
    LoadPlugin(surfaces.plugin(), remote=False, ns=globals())
    local = loaded.GetLocalInformation()
    found = [k for k in range(local.GetNumberOfPlugins()) if local.GetPluginName(k) == name]
    assert len(found) == 1 and local.GetPluginLoaded(found[0]), "the plugin is not loaded"
    assert loaded.GetRemoteInformation(session) is not None
    made = MaternNoise(Input=Sphere(ThetaResolution=64, PhiResolution=64), CorrelationRange=0.5)
    made.UpdatePipeline()
    low, high = made.PointData["MaternNoise"].GetRange(0)
    assert -10.0 < low < 0.0 < high < 10.0, (low, high)
    prototype = servermanager.ProxyManager().GetPrototypeProxy("filters", "MaternNoise")
    menu = prototype.GetHints().FindNestedElementByName("ShowInMenu")
    assert menu.GetAttribute("category") == "Surface Synthesis: Generate"


def the_filter_comes_with_the_plugin():
    assert not hasattr(servermanager.filters, "MaternNoise"), "the plugin was loaded before the test"


surfaces.run(the_filter_comes_with_the_plugin, load)
