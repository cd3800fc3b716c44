# SPDX-License-Identifier: BSD-3-Clause
"""Conventions of all filters of the plugin, in pvpython: inputs, models, first views, words of messages."""

import os
import re
import subprocess

import surfaces
from paraview import servermanager
from paraview.simple import *  # noqa: F403: as scripts of ParaView do
from proxies import output_of, source_of

LoadPlugin(surfaces.plugin(), remote=False, ns=globals())
ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, os.pardir)
DEFORMERS = ["armadillo_poses", "armadillo_rest", "body_poses", "bunny_rest", "figure_poses"]
MODELS = {"FieldLatentDecoder": ["field_latents"], "FieldLatentEncoder": ["field_latents"],
          "FieldLatentTexture": ["coat", "tissue", "wood"],
          "FlowMatchingDeformer": DEFORMERS,
          "FlowMatchingSampler": sorted([*DEFORMERS, "bunny_mixtures"]),
          "GeometricTextureSynthesizer": ["flow_knobs", "flow_labyrinth", "flow_spikes", "knobs", "labyrinth", "spikes"],
          "PoissonNet": ["smoothed_curvature"]}


def definitions():
    """Name, label and XML of all filters of ParaView and of the plugin."""
    filters = servermanager.ActiveConnection.Session.GetProxyDefinitionManager().NewSingleGroupIterator("filters")
    filters.InitTraversal()
    while not filters.IsDoneWithTraversal():
        element = filters.GetProxyDefinition()
        yield filters.GetProxyName(), element.GetAttribute("label") or filters.GetProxyName(), element
        filters.GoToNextItem()


def prototypes():
    """The proxies of the plugin, by name."""
    found = {name: servermanager.ProxyManager().GetPrototypeProxy("filters", name) for name, _, element in definitions()
             if os.path.exists(os.path.join(ROOT, "Wrapping", "ParaView", name + ".xml"))}
    assert len(found) >= 10, sorted(found)
    return found


def inputs_of(prototype):
    return [prototype.GetProperty(name) for name in ("Input", "Reference", "Source", "Samples", "Template", "TemplateMesh",
                                                     "GivenTemplate", "Target", "Example", "PlainExample", "SecondExample",
                                                     "SecondPlainExample")
            if prototype.GetProperty(name)
            and prototype.GetProperty(name).IsA("vtkSMInputProperty")]


#: Inputs that are images, and no surfaces.
IMAGES = {("FieldLatentEncoder", "TextureImage"), ("FieldLatentTrainer", "Input"), ("LabelSurfaces", "Input"),
          ("LatentDiffusionTrainer", "TextureImage")}


def clipped_surfaces_are_taken_by_every_filter():
    """Clip makes an unstructured grid of triangles of a surface."""
    clip = Clip(Input=source_of(surfaces.ball()), ClipType="Plane")
    clip.ClipType.Origin = [0.013, 0.0, 0.0]  # through no point, which would leave triangles without area
    clip.ClipType.Normal = [0.9, 0.3, 0.1]
    clip.UpdatePipeline()
    for name, prototype in prototypes().items():
        for port in inputs_of(prototype) if name != "EnsembleLayout" else ():  # which takes ensembles
            expected = 0 if (name, port.GetXMLName()) in IMAGES else 1
            assert port.GetDomain("input_type").IsInDomain(clip.SMProxy, 0) == expected, (name, port.GetXMLName())
    of_grid = output_of(MaternNoise(Input=clip, CorrelationRange=0.5))
    of_surface = output_of(MaternNoise(Input=ExtractSurface(Input=clip), CorrelationRange=0.5))
    assert of_grid.IsA("vtkUnstructuredGrid") and of_grid.GetNumberOfCells() == output_of(clip).GetNumberOfCells() > 0
    assert of_surface.GetNumberOfPoints() == of_grid.GetNumberOfPoints()
    surfaces.assert_same(surfaces.array(of_grid), surfaces.array(of_surface), "noise")
    report = output_of(TopologyReport(Input=clip))
    assert report.GetNumberOfRows() > 20


def a_model_is_installed_for_every_filter_that_needs_one():
    for name, expected in MODELS.items():
        made = globals()[name](Input=source_of(surfaces.ball(6)))
        assert list(made.GetProperty("InstalledModels")) == expected, (name, made.GetProperty("InstalledModels"))
        assert made.ModelFileName == expected[0], (name, made.ModelFileName)
    predicted = output_of(PoissonNet(Input=source_of(surfaces.ball(6))))
    assert predicted.GetPointData().GetArray("Prediction") is not None, surfaces.names(predicted)
    folder = str(made.GetProperty("InstalledModelsFolder").GetElement(0))
    own = output_of(PoissonNet(Input=source_of(surfaces.ball(6)),
                               ModelFileName=os.path.join(folder, "smoothed_curvature.safetensors")))
    surfaces.assert_same(surfaces.array(own, "Prediction"), surfaces.array(predicted, "Prediction"), "by path and by name")
    for names in MODELS.values():
        for name in names:
            assert os.path.exists(os.path.join(folder, name + ".png")), f"{name} has no picture"


def an_example_is_installed_for_textures_without_a_training():
    """A surface is all that a first texture needs."""
    made = GeometricTextureFromExample(Input=source_of(surfaces.ball(6)))
    names = list(made.GetProperty("InstalledExamples"))
    assert names == ["cortex", "mane", "mountains"], names
    assert made.ExampleFileName == "cortex", made.ExampleFileName
    made.Subdivisions, made.NumberOfScales = 0, 1
    assert output_of(made).GetPointData().GetArray("Displacement") is not None
    folder = str(made.GetProperty("InstalledExamplesFolder").GetElement(0))
    for name in names:
        assert os.path.exists(os.path.join(folder, name + ".png")), f"{name} has no picture"


def the_first_view_shows_the_fit():
    """Not all levels, which lie in one place, nor the template, which has not been fitted."""
    if "MultiscaleMeshFitter" not in globals():
        return
    fitter = MultiscaleMeshFitter(Input=source_of(surfaces.ball(6)), NumberOfLevels=2, IcosphereLevel=1, Iterations=1,
                                  Samples=20)
    fitter.UpdatePipeline()
    controller = servermanager.vtkSMParaViewPipelineControllerWithRendering()
    assert [controller.GetPreferredViewType(fitter.SMProxy, port) for port in range(3)] == ["None", "None", None]
    finest = servermanager.Fetch(fitter, idx=2)
    assert finest.GetNumberOfPoints() == 162, finest.GetNumberOfPoints()


def both_inputs_of_the_trainer_are_asked_for():
    """The client asks for the inputs of filters with several that are not optional."""
    trainer = prototypes().get("FlowMatchingTrainer")
    for port in inputs_of(trainer) if trainer else ():
        assert not port.GetHints() or not port.GetHints().FindNestedElementByName("Optional"), port.GetXMLName()


def the_menu_has_groups():
    groups = {prototype.GetHints().FindNestedElementByName("ShowInMenu").GetAttribute("category")
              for prototype in prototypes().values()}
    assert groups <= {"Surface Synthesis: " + group for group in ("Prepare", "Generate", "Train", "Measure")}, groups
    assert len(groups) >= 3, groups


def lists_have_labels():
    """The panel shows a label for a list of numbers only where a group around it has one."""
    for name, _, element in definitions():
        if name not in prototypes():
            continue
        grouped = {element.GetNestedElement(k).GetNestedElement(0).GetAttribute("name")
                   for k in range(element.GetNumberOfNestedElements())
                   if element.GetNestedElement(k).GetName() == "PropertyGroup" and element.GetNestedElement(k).GetAttribute("label")}
        for k in range(element.GetNumberOfNestedElements()):
            row = element.GetNestedElement(k)
            if row.GetAttribute("repeat_command") and row.GetAttribute("panel_visibility") != "never":
                assert row.GetAttribute("name") in grouped, (name, row.GetAttribute("name"))


def messages_name_filters_that_there_are():
    """The table of labels has every filter of the plugin under its label, and no label that ParaView lacks."""
    with open(os.path.join(ROOT, "Filters", "Bridge", "Reporting.cxx"), encoding="utf-8") as file:
        table = file.read().split("// types of data")[0]
    named = dict(re.findall(r'\{ "(vtk\w+)", "([^"]+)" \}', table))
    labels = {label for _, label, _ in definitions()}
    optional = {"Isotropic Remesh", "Surface Repair", "Pose Ensemble", "VDB Surface", "Tetrahedralize Surface",
                "Flow Matching Trainer", "Geometric Texture Trainer", "Multiscale Mesh Fitter"}
    for label in named.values():
        for part in label.split(" with "):
            assert part in labels | optional, f"ParaView has no filter {part}"
    for name, label, element in definitions():
        if name in prototypes():
            assert named.get(element.GetAttribute("class")) == label, (element.GetAttribute("class"), label)
    sources = subprocess.run(["grep", "-rhoE", r'"[^"]*\bvtk[A-Z][^"]* [^"]*"', os.path.join(ROOT, "Filters"), "--include=*.cxx"],
                             stdout=subprocess.PIPE, text=True, check=True).stdout
    classes = set(re.findall(r"\bvtk[A-Z]\w+", sources))
    with open(os.path.join(ROOT, "Filters", "Bridge", "Reporting.cxx"), encoding="utf-8") as file:
        known = set(re.findall(r'"(vtk\w+)"', file.read()))
    assert len(classes) > 20 and classes <= known, sorted(classes - known)


surfaces.run(
    clipped_surfaces_are_taken_by_every_filter,
    a_model_is_installed_for_every_filter_that_needs_one,
    an_example_is_installed_for_textures_without_a_training,
    the_first_view_shows_the_fit,
    both_inputs_of_the_trainer_are_asked_for,
    the_menu_has_groups,
    lists_have_labels,
    messages_name_filters_that_there_are,
)
