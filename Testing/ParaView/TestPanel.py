# SPDX-License-Identifier: BSD-3-Clause
"""The graphical interface, played by ParaView's own test machinery: menu, panel, Apply, trace, messages.

    python3 TestPanel.py <name of one of TESTS>

It starts paraview, in which PanelSetup.py makes the surface and records what happens, and which then
plays the events below. A widget that is missing, hidden or holds another value ends the play with an error.
"""

import json
import os
import subprocess
import sys
from xml.sax.saxutils import quoteattr

HERE = os.path.dirname(os.path.abspath(__file__))
PANEL = "pqClientMainWindow/propertiesDock/propertiesPanel"
PROPERTIES = PANEL + "/scrollArea/qt_scrollarea_viewport/scrollAreaWidgetContents/PropertiesFrame/ProxyPanel/"
EVERY_ROW = {"NoiseModel", "ScaleMode", "CorrelationRange", "StandardDeviation", "Screening", "NormalizedScreening",
             "NumberOfEigenpairs", "Seed", "NumberOfSamples", "FirstSample", "NumberOfComponents", "OutputArrayName",
             "MemoryLimit", "Execute"}
ALWAYS = {"NoiseModel", "Seed", "NumberOfSamples", "FirstSample", "NumberOfComponents", "OutputArrayName",
          "MemoryLimit", "Execute"}

#: Groups of the menu, but for Generate.
GROUPS = {"MultiscaleMeshFitter": "Train", "GeometricTextureTrainer": "Train", "FlowMatchingTrainer": "Train",
          "FieldLatentTrainer": "Train",
          "SurfaceRepair": "Prepare", "IsotropicRemesh": "Prepare", "TextureAtlas": "Prepare", "Tetrahedralize": "Prepare", "VDBSurface": "Prepare", "LabelSurfaces": "Prepare",
          "TopologyReport": "Measure", "EnsembleMetrics": "Measure", "EnsembleStatistics": "Measure", "SurfaceDistance": "Measure",
          "GeometricTextureDistance": "Measure", "GeometricTextureFeatures": "Measure"}
NOISE_PROPERTIES = ("CorrelationRange", "StandardDeviation", "Seed", "NumberOfSamples", "NoiseModel", "ScaleMode")


def event(widget, command, arguments=""):
    return f"  <pqevent object={quoteattr(widget)} command={quoteattr(command)} arguments={quoteattr(arguments)} />"


def check(widget, name, value):
    return f"  <pqcheck object={quoteattr(widget)} property={quoteattr(name)} arguments={quoteattr(value)} />"


def apply():
    return event(PANEL + "/Accept", "activate")


def choose(name, text):
    return event(PROPERTIES + name + "/ComboBox", "set_string", text)


def rows(*shown):
    """The rows that only some modes use: exactly those named are shown, beside those that every mode has."""
    return [check(PROPERTIES + name, "visible", "true" if name in ALWAYS or name in shown else "false")
            for name in sorted(EVERY_ROW)]


def add_filter(name="MaternNoise"):
    menu, group = "pqClientMainWindow/menubar", "Surface Synthesis: " + GROUPS.get(name, "Generate")
    return [
        event(menu, "activate", "menuFilters"),
        event(menu + "/menuFilters", "activate", group),
        event(menu + "/menuFilters/" + group, "activate", name),
    ]


def own_model(path):
    """Chooses a file in place of the installed models."""
    return [event(PROPERTIES + "ModelFileName/Models", "set_string", "File ..."),
            event(PROPERTIES + "ModelFileName/File", "set_string", path)]


def play(name, events, surface, tested="MaternNoise", properties=NOISE_PROPERTIES):
    """Plays events in paraview on a surface; returns what it wrote, and what PanelSetup.py recorded of the filter that
    is tested and of its properties."""
    script, record = os.path.abspath(name + ".xml"), os.path.abspath(name + ".json")
    with open(script, "w", encoding="utf-8") as file:
        file.write("\n".join(('<?xml version="1.0" ?>', "<pqevents>", *events, "</pqevents>", "")))
    if os.path.exists(record):
        os.remove(record)
    os.makedirs("panel", exist_ok=True)
    environment = dict(os.environ, SURFACE_SYNTHESIS_RECORD=record, SURFACE_SYNTHESIS_SURFACE=surface,
                       SURFACE_SYNTHESIS_FILTER=tested, SURFACE_SYNTHESIS_PROPERTIES=",".join(properties))
    result = subprocess.run(
        [os.environ["SURFACE_SYNTHESIS_PARAVIEW"], "--dr", "--script=" + os.path.join(HERE, "PanelSetup.py"),
         "--test-directory=" + os.path.abspath("panel"), "--test-script=" + script, "--exit"],
        env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=200)
    if not os.path.exists(record):
        raise AssertionError("the filter was not run:\n" + result.stdout)
    with open(record, encoding="utf-8") as file:
        return result, json.load(file)


def succeed(result):
    assert result.returncode == 0 and "Success =  true" in result.stdout, result.stdout


def panel_shows_what_the_mode_uses():
    events = [
        *add_filter(),
        # 0.2 times the longest side of the ball, shown before Apply
        check(PROPERTIES + "CorrelationRange/DoubleRangeWidget/DoubleLineEdit", "text", "0.4"),
        check(PROPERTIES + "Seed/Seed", "value", "0"),
        check(PROPERTIES + "NoiseModel", "visible", "false"),  # advanced
        event(PANEL + "/SearchBox/AdvancedButton", "set_boolean", "true"),
        *rows("ScaleMode", "CorrelationRange", "StandardDeviation"),
        choose("ScaleMode", "Screening"), *rows("ScaleMode", "Screening"),
        choose("ScaleMode", "Normalized Screening"), *rows("ScaleMode", "NormalizedScreening"),
        choose("NoiseModel", "Spectral"), *rows("ScaleMode", "NormalizedScreening", "NumberOfEigenpairs"),
        choose("NoiseModel", "Per Vertex"), *rows("StandardDeviation"),
        choose("NoiseModel", "White"), *rows(),
        choose("NoiseModel", "Unscreened"), *rows(),
        choose("NoiseModel", "Matern"), choose("ScaleMode", "Correlation Range"),
        *rows("ScaleMode", "CorrelationRange", "StandardDeviation"),
        apply(),
    ]
    result, recorded = play("shows", events, "ball")
    succeed(result)
    assert recorded["properties"]["CorrelationRange"] == 0.4, recorded
    assert recorded["points"] > 0 and recorded["errors"] == [], recorded


def panel_applies_and_trace_replays():
    events = [
        *add_filter(),
        event(PROPERTIES + "CorrelationRange/DoubleRangeWidget/DoubleLineEdit", "set_string", "0.7"),
        event(PROPERTIES + "Seed/Seed", "set_int", "17"),
        event(PROPERTIES + "NumberOfSamples/LineEdit0", "set_string", "2"),
        apply(),
        event(PROPERTIES + "Seed/NewSeed", "activate"),
        event(PROPERTIES + "StandardDeviation/DoubleLineEdit0", "set_string", "3"),
        apply(),
    ]
    result, recorded = play("applies", events, "ball")
    succeed(result)
    found = recorded["properties"]
    assert (found["CorrelationRange"], found["NumberOfSamples"], found["StandardDeviation"]) == (0.7, 2, 3.0), found
    assert found["Seed"] not in (0, 17) and 0 <= found["Seed"] < 1000000, "New seed made no other seed"
    assert recorded["errors"] == [], recorded
    with open("trace.py", "w", encoding="utf-8") as file:
        file.write(recorded["trace"])
    replay = subprocess.run([os.environ["SURFACE_SYNTHESIS_PVPYTHON"], "-c", f"""
import numpy, surfaces
from paraview import servermanager
from paraview.simple import *
LoadPlugin(surfaces.plugin(), remote=False, ns=globals())
exec(open("trace.py", encoding="utf-8").read())
made = next(proxy for proxy in GetSources().values() if proxy.GetXMLName() == "MaternNoise")
made.UpdatePipeline()
found = servermanager.Fetch(made)
expected = surfaces.noise(
    surfaces.ball(), CorrelationRange=0.7, NumberOfSamples=2, StandardDeviation=3.0, Seed={found["Seed"]})
for name in ("MaternNoise_0", "MaternNoise_1"):
    surfaces.assert_same(surfaces.array(found, name), surfaces.array(expected, name), name)
print("replayed")
"""], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=100)
    assert replay.returncode == 0 and "replayed" in replay.stdout, replay.stdout + recorded["trace"]


def error_reaches_the_message_window():
    """The test machinery takes every error for a failure, so the play ends with one; the text is what counts."""
    result, recorded = play("fails", [*add_filter(), apply()], "fin")
    assert recorded["points"] == 0, recorded
    assert any("non-manifold edge" in text and "Surface Repair" in text and "Feature Edges" in text for text in recorded["errors"]), recorded


def ensembles_are_made_from_the_panel():
    """Samples of mixtures, and of poses where the plugin has them, with the seed of the widget."""
    drawn = [event(PROPERTIES + "Seed/Seed", "set_int", "17"),
             event(PROPERTIES + "NumberOfSamples/LineEdit0", "set_string", "2"), apply()]
    for name, surface, points in (("GaussianMixture", "ball", 3458), ("PoseEnsemble", "long_ball", 2 * 602)):
        if name == "PoseEnsemble" and os.environ["SURFACE_SYNTHESIS_CGAL"] != "1":
            continue
        result, recorded = play(name, [*add_filter(name), *drawn], surface, name, ("Seed", "NumberOfSamples"))
        succeed(result)
        assert recorded["properties"] == {"Seed": 17, "NumberOfSamples": 2}, recorded
        assert recorded["points"] == points and recorded["errors"] == [], recorded
        assert f"{name}(" in recorded["trace"] and "NumberOfSamples = 2" in recorded["trace"], recorded["trace"]


def a_model_is_chosen_in_the_panel():
    """An installed one is there before; without any, the message window says what is needed."""
    events = [*add_filter("FlowMatchingDeformer"), *own_model(""), apply()]
    result, recorded = play("unchosen", events, "ball", "FlowMatchingDeformer", ("ModelFileName",))
    assert recorded["points"] == 0, recorded
    assert any("Model File Name is empty" in text for text in recorded["errors"]), recorded

    subprocess.run([os.environ["SURFACE_SYNTHESIS_PVPYTHON"], "-c",
                    "from flow_models import model; model('panel.safetensors')"], check=True, timeout=100)
    path = os.path.abspath("panel.safetensors")
    events = [
        *add_filter("FlowMatchingDeformer"),
        check(PROPERTIES + "ModelFileName/Models", "currentText", "armadillo_poses"),
        check(PROPERTIES + "ModelFileName/File", "visible", "false"),
        *own_model(path),
        event(PROPERTIES + "NumberOfSteps/IntRangeWidget/LineEdit", "set_string", "2"),
        apply(),
    ]
    result, recorded = play("chosen", events, "ball", "FlowMatchingDeformer", ("ModelFileName", "NumberOfSteps"))
    succeed(result)
    assert recorded["properties"] == {"ModelFileName": path, "NumberOfSteps": 2}, recorded
    assert recorded["points"] == 3458 and recorded["errors"] == [], recorded


def textures_are_fitted_learned_and_synthesized_from_the_panel():
    """The scale is shown where it is used."""
    name = "GeometricTextureSynthesizer"
    events = [
        *add_filter("MultiscaleMeshFitter"),
        event(PROPERTIES + "NumberOfLevels/IntRangeWidget/LineEdit", "set_string", "2"),
        event(PROPERTIES + "IcosphereLevel/IntRangeWidget/LineEdit", "set_string", "1"),
        event(PROPERTIES + "Iterations/IntRangeWidget/LineEdit", "set_string", "2"),
        event(PANEL + "/SearchBox/AdvancedButton", "set_boolean", "true"),
        event(PROPERTIES + "Samples/IntRangeWidget/LineEdit", "set_string", "50"),
        apply(),
    ]
    result, recorded = play("fitted", events, "ball", "MultiscaleMeshFitter", ("NumberOfLevels", "Iterations"))
    succeed(result)
    assert recorded["properties"] == {"NumberOfLevels": 2, "Iterations": 2}, recorded
    assert recorded["points"] == 42 + 162 and recorded["errors"] == [], recorded

    path = os.path.abspath("learnt.safetensors")
    events = [
        *add_filter("GeometricTextureTrainer"),
        event(PROPERTIES + "ModelFileName/FileChooser/FileLineEdit", "set_string", path),
        event(PROPERTIES + "IterationsPerLevel/IntRangeWidget/LineEdit", "set_string", "2"),
        event(PANEL + "/SearchBox/AdvancedButton", "set_boolean", "true"),
        event(PROPERTIES + "Resume/CheckBox", "set_boolean", "false"),
        apply(),
    ]
    names = ("ModelFileName", "IterationsPerLevel", "Resume")
    result, recorded = play("learnt", events, "ball", "GeometricTextureTrainer", names)
    succeed(result)
    assert recorded["properties"] == {"ModelFileName": path, "IterationsPerLevel": 2, "Resume": False}, recorded
    assert recorded["points"] == 2 and recorded["errors"] == [], recorded

    scale = PROPERTIES + "TextureScale"
    events = [
        *add_filter(name),
        *own_model(path),
        check(scale, "visible", "true"),
        choose("TargetPreparation", "As Is"), check(scale, "visible", "false"),
        choose("TargetPreparation", "Subdivide"), check(scale, "visible", "true"),
        event(scale + "/DoubleRangeWidget/DoubleLineEdit", "set_string", "0.5"),
        event(PROPERTIES + "Seed/Seed", "set_int", "17"),
        apply(),
    ]
    names = ("ModelFileName", "TargetPreparation", "TextureScale", "Seed")
    result, recorded = play("synthesized", events, "ball", name, names)
    succeed(result)
    expected = {"ModelFileName": path, "TargetPreparation": 1, "TextureScale": 0.5, "Seed": 17}
    assert recorded["properties"] == expected, recorded
    assert recorded["points"] == 2 + 4 * 3456 and recorded["errors"] == [], recorded
    assert f"{name}(" in recorded["trace"] and "TextureScale = 0.5" in recorded["trace"], recorded["trace"]


def automatic_values_are_boxes_and_rows_of_images_are_hidden():
    """VDB Surface has no isovalue for a surface; its voxel size is automatic until the box is cleared."""
    size = PROPERTIES + "VoxelSize/"
    events = [
        *add_filter("VDBSurface"),
        *(check(PROPERTIES + name, "visible", "false")
          for name in ("SelectInputScalars", "ComputeIsoValue", "IsoValue", "InsideRule")),
        check(PROPERTIES + "Closing", "visible", "true"),
        check(size + "Automatic", "checked", "true"), check(size + "Automatic", "text", "automatic"),
        check(size + "Field", "enabled", "false"),
        event(size + "Automatic", "set_boolean", "false"),
        event(size + "Field", "set_string", "0.125"),
        apply(),
    ]
    result, recorded = play("sized", events, "ball", "VDBSurface", ("VoxelSize",))
    succeed(result)
    assert recorded["properties"] == {"VoxelSize": 0.125} and recorded["points"] > 500, recorded
    events = [*events, event(size + "Automatic", "set_boolean", "true"), check(size + "Field", "text", ""), apply()]
    result, recorded = play("unsized", events, "ball", "VDBSurface", ("VoxelSize",))
    succeed(result)
    assert recorded["properties"] == {"VoxelSize": 0.0} and recorded["points"] > 5000, recorded


def a_late_result_is_colored():
    """After a first update that failed, as soon as there is an array."""
    events = [
        *add_filter("PoissonNet"), *own_model(""), apply(),
        event(PROPERTIES + "ModelFileName/Models", "set_string", "smoothed_curvature"), apply(),
        check("pqClientMainWindow/variableToolbar/displayColor/Variables", "currentText", "Prediction"),
    ]
    result, recorded = play("late", events, "ball", "PoissonNet", ("ModelFileName",))
    assert recorded["points"] == 3458 and recorded["properties"] == {"ModelFileName": "smoothed_curvature"}, recorded
    # The first update is an error, which the test machinery takes for a failure; a failed check would say so.
    assert "ERROR" not in "".join(line for line in result.stdout.splitlines() if "Variables" in line), result.stdout


def an_installed_example_is_chosen_in_the_panel():
    """From a surface alone: no dialog asks for an example. Its picture is in the list."""
    name = "GeometricTextureFromExample"
    events = [
        *add_filter(name),
        check(PROPERTIES + "ExampleFileName/Models", "currentText", "cortex"),
        check(PROPERTIES + "ExampleFileName/File", "visible", "false"),
        event(PROPERTIES + "ExampleFileName/Models", "set_string", "mountains"),
        event(PANEL + "/SearchBox/AdvancedButton", "set_boolean", "true"),
        event(PROPERTIES + "NumberOfScales/Automatic", "set_boolean", "false"),
        event(PROPERTIES + "NumberOfScales/Field", "set_string", "1"),
        event(PROPERTIES + "Subdivisions/Automatic", "set_boolean", "false"),
        event(PROPERTIES + "Subdivisions/Field", "set_string", "0"),
        event(PROPERTIES + "Seed/Seed", "set_int", "5"),
        apply(),
    ]
    names = ("ExampleFileName", "Seed", "NumberOfScales", "Subdivisions")
    result, recorded = play("example", events, "ball", name, names)
    succeed(result)
    expected = {"ExampleFileName": "mountains", "Seed": 5, "NumberOfScales": 1, "Subdivisions": 0}
    assert recorded["properties"] == expected, recorded
    assert recorded["points"] > 0 and recorded["errors"] == [], recorded


TESTS = {
    "Rows": panel_shows_what_the_mode_uses,
    "Trace": panel_applies_and_trace_replays,
    "Errors": error_reaches_the_message_window,
    "Ensembles": ensembles_are_made_from_the_panel,
    "Automatic": automatic_values_are_boxes_and_rows_of_images_are_hidden,
    "Late": a_late_result_is_colored,
    "Examples": an_installed_example_is_chosen_in_the_panel,
    "Models": a_model_is_chosen_in_the_panel,
    "Textures": textures_are_fitted_learned_and_synthesized_from_the_panel,
}

if __name__ == "__main__":
    TESTS[sys.argv[1]]()
