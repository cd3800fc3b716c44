# SPDX-License-Identifier: BSD-3-Clause
"""The plugin of the package is listed, as in Tools, Manage Plugins, and is loaded by its name: run by Build.PluginPackage."""

import os

import surfaces
from paraview import servermanager
from paraview.simple import *  # noqa: F403: as scripts of ParaView do

NAME = "SurfaceSynthesis"


def plugins():
    """The files of the plugins that ParaView lists, by name, and the names of those that are loaded."""
    manager = servermanager.vtkSMProxyManager.GetProxyManager().GetPluginManager()
    local = manager.GetLocalInformation()
    numbers = range(local.GetNumberOfPlugins())
    return ({local.GetPluginName(k): local.GetPluginFileName(k) for k in numbers},
            {local.GetPluginName(k) for k in numbers if local.GetPluginLoaded(k)})  # fmt: skip


def is_listed_and_not_loaded():
    listed, loaded = plugins()
    assert NAME in listed and NAME not in loaded, (listed, loaded)
    assert os.path.samefile(listed[NAME], surfaces.plugin()), listed[NAME]
    assert not hasattr(servermanager.filters, "MaternNoise")


def is_loaded_by_its_name():
    LoadDistributedPlugin(NAME, ns=globals())
    assert NAME in plugins()[1]
    made = MaternNoise(Input=Sphere(ThetaResolution=64, PhiResolution=64), CorrelationRange=0.5)
    made.UpdatePipeline()
    low, high = made.PointData["MaternNoise"].GetRange(0)
    assert -10.0 < low < 0.0 < high < 10.0, (low, high)


surfaces.run(is_listed_and_not_loaded, is_loaded_by_its_name)
