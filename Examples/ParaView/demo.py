# SPDX-License-Identifier: BSD-3-Clause
"""Surfaces that need no file, the shipped models, and the look of the pictures: shared by the demo states."""

import math
import os

from figure import EXTENT, VOLUME
from paraview.simple import (  # pylint: disable=import-error
    ColorBy,
    Contour,
    CreateLayout,
    CreateView,
    GenerateSurfaceNormals,
    GetColorTransferFunction,
    ProgrammableFilter,
    ProgrammableSource,
    SetActiveView,
    Show,
    Text,
)

#: Small meshes and short trainings, for tests.
QUICK = bool(os.environ.get("SURFACE_SYNTHESIS_QUICK"))
#: Color of surfaces without an array.
CLAY = [0.86, 0.80, 0.72]


def figure(resolution=70):
    """A closed surface with six limbs, about 3 units high; ``resolution`` samples across."""
    resolution = min(resolution, 28) if QUICK else resolution
    volume = ProgrammableSource(registrationName="Volume", OutputDataSetType="vtkImageData")
    volume.Script = VOLUME.format(resolution=resolution)
    volume.ScriptRequestInformation = EXTENT.format(resolution=resolution)
    surface = Contour(registrationName="Figure", Input=volume, ContourBy=["POINTS", "Figure"], Isosurfaces=[0.0])
    surface.ComputeScalars = 0
    surface.ComputeNormals = 0
    return surface


# The coat of a giraffe: patches around random points, darker towards their middle, with light lines between, and hairs.
_COAT = """
import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk
n, random = {size}, np.random.default_rng(4)
grid = (np.arange(14) + 0.5) / 14
seeds = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2) + random.uniform(-0.028, 0.028, (196, 2))
x = (np.arange(n) + 0.5) / n
places = np.stack(np.meshgrid(x, x), axis=-1).reshape(-1, 2)
places = places + 0.006 * np.sin(70 * places[:, ::-1] + 3 * np.sin(31 * places))
distances = np.full((n * n, 2), np.inf)
nearest = np.zeros(n * n, dtype=int)
for k, seed in enumerate(seeds):
    d = np.hypot(*(places - seed).T)
    closer = d < distances[:, 0]
    distances[:, 1] = np.where(closer, distances[:, 0], np.minimum(distances[:, 1], d))
    distances[:, 0] = np.where(closer, d, distances[:, 0])
    nearest[closer] = k
inside = np.clip((distances[:, 1] - distances[:, 0] - 0.010) / 0.006, 0, 1)[:, None]
shade = random.uniform(0.8, 1.15, 196)[nearest] * (0.75 + 4.5 * np.minimum(distances[:, 0], 0.05))
hairs = np.repeat(random.normal(0, 1, (n // 4, n)), 4, axis=0).ravel()
colors = inside * np.outer(shade, [150, 84, 42]) + (1 - inside) * [236, 214, 170] + 7 * hairs[:, None]
output.SetDimensions(n, n, 1)
array = numpy_to_vtk(np.clip(colors, 0, 255).astype(np.uint8), deep=True)
array.SetName("Coat")
output.GetPointData().SetScalars(array)
"""
_COAT_EXTENT = """
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline as pipeline
self.GetOutputInformation(0).Set(pipeline.WHOLE_EXTENT(), 0, {size} - 1, 0, {size} - 1, 0, 0)
"""


def coat(size=512):
    """An image of the coat of a giraffe, ``size`` x ``size`` texels."""
    size = min(size, 128) if QUICK else size
    image = ProgrammableSource(registrationName="Coat", OutputDataSetType="vtkImageData")
    image.Script = _COAT.format(size=size)
    image.ScriptRequestInformation = _COAT_EXTENT.format(size=size)
    return image


_LAID_OUT = """
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
surface = self.GetInputDataObject(0, 0)
output.ShallowCopy(surface)
places = vtk_to_numpy(surface.GetPoints().GetData())[:, :2]
coordinates = numpy_to_vtk((places + 1.75) / 3.5, deep=True)
coordinates.SetName("TCoords")
output.GetPointData().SetTCoords(coordinates)
"""


def laid_out(surface):
    """The surface with texture coordinates by position: x and y, from -1.75 to 1.75, become 0 to 1."""
    return ProgrammableFilter(registrationName="Laid out", Input=surface, Script=_LAID_OUT)


def model(name):
    """The path of a shipped model."""
    folder = os.environ.get("SURFACE_SYNTHESIS_MODELS") or os.path.join(
        os.path.dirname(os.path.abspath(__file__)), os.pardir, "Models"
    )
    return os.path.normpath(os.path.join(folder, name + ".safetensors"))


def minutes(budget):
    """A time budget in minutes."""
    return min(budget, 0.01) if QUICK else budget


def smooth(surface, name="Normals"):
    """The surface with normals, for shading."""
    return GenerateSurfaceNormals(registrationName=name, Input=surface, FeatureAngle=180.0)


def picture(camera, kind="RenderView"):
    """An active view on white; ``camera``: position, focal point and view up, or None for the whole scene."""
    view = CreateView(kind)
    CreateLayout(name="Layout #1").AssignView(0, view)
    SetActiveView(view)
    if kind == "RenderView":
        view.UseColorPaletteForBackground = 0
        view.Background = [1.0, 1.0, 1.0]
        view.OrientationAxesVisibility = 0
        if camera is not None:
            view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = camera
            view.CameraViewAngle = 30.0
    return view


def show(source, view, array=None, association="POINTS", bar=True, preset=None, limits=None, title=None):
    """Shows a surface in clay, or colored by an array."""
    display = Show(source, view)
    display.SetRepresentationType("Surface")
    if array is None:
        display.ColorArrayName = ["POINTS", ""]
        display.AmbientColor = display.DiffuseColor = CLAY
    else:
        ColorBy(display, (association, array))
        colors = GetColorTransferFunction(array)
        if preset is not None:
            colors.ApplyPreset(preset, True)
        if limits is not None:
            colors.RescaleTransferFunction(*limits)
        display.SetScalarBarVisibility(view, bar)
        if bar:
            _dress_bar(colors, view, title or array)
    display.Specular = 0.25
    display.SpecularPower = 30.0
    return display


def edges(display, color=(0.45, 0.42, 0.4)):
    """Draws the edges of the cells."""
    display.SetRepresentationType("Surface With Edges")
    display.EdgeColor = list(color)
    display.LineWidth = 0.6


def _dress_bar(colors, view, title):
    """Black text, which is seen on white."""
    from paraview.simple import GetScalarBar

    scale = GetScalarBar(colors, view)
    scale.Title = title
    scale.ComponentTitle = ""
    scale.TitleColor = scale.LabelColor = [0.0, 0.0, 0.0]
    scale.TitleFontSize = scale.LabelFontSize = 18


def rows_of(source, port=0):
    """The columns of a table by name, fetched to the client; ``port``: the output that has the table."""
    from paraview import servermanager

    source.UpdatePipeline()
    data = servermanager.Fetch(source, idx=port)
    names = [data.GetColumnName(k) for k in range(data.GetNumberOfColumns())]
    return {name: [data.GetValueByName(row, name) for row in range(data.GetNumberOfRows())] for name in names}


def write(text, view, place, size=20):
    """Writes text at a place of the view, (0, 0) at the lower left and (1, 1) at the upper right."""
    display = Show(Text(registrationName=text.splitlines()[0], Text=text), view)
    display.WindowLocation = "Any Location"
    display.Position = list(place)
    display.Color = [0.0, 0.0, 0.0]
    display.FontSize = size
    display.Justification = "Left"
    return display


def fill(view, source, right=0.0, top=0.0, aspect=900 / 700):
    """Moves the camera so that a source fills the view from the front, but for parts of it at the right and the top."""
    source.UpdatePipeline()
    x0, x1, y0, y1, z0, z1 = source.GetDataInformation().GetBounds()
    width, height = (x1 - x0) / (1.0 - right), (y1 - y0) / (1.0 - top)
    distance = 0.54 * max(height, width / aspect) / math.tan(math.radians(15.0)) + z1 - 0.5 * (z0 + z1)
    center = [x0 + 0.5 * width, y0 + 0.5 * height, 0.5 * (z0 + z1)]
    from paraview.simple import _DisableFirstRenderCameraReset

    _DisableFirstRenderCameraReset()  # which would fit the whole scene, texts included
    view.CameraViewAngle = 30.0
    view.CameraFocalPoint, view.CameraViewUp = center, [0.0, 1.0, 0.0]
    view.CameraPosition = [center[0], center[1], center[2] + distance]


_SMOOTHED = """
import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
table = self.GetInputDataObject(0, 0)
output.ShallowCopy(table)
values = vtk_to_numpy(table.GetColumnByName("{column}")) if table.GetNumberOfRows() else np.zeros(0)
window = np.ones(len(values) // 10 + 1)
smoothed = values
if len(values):
    smoothed = np.convolve(values, window, "same") / np.convolve(np.ones(len(values)), window, "same")
array = numpy_to_vtk(smoothed, deep=True)
array.SetName("{column}, smoothed")
output.AddColumn(array)
"""


def losses(training, view, column):
    """Draws a loss over the iterations, as it is and smoothed, on a logarithmic axis."""
    smoothed = ProgrammableFilter(registrationName="Smoothed", Input=training, OutputDataSetType="vtkTable")
    smoothed.Script = _SMOOTHED.format(column=column)
    display = Show(smoothed, view)
    display.UseIndexForXAxis = 0
    display.XArrayName = "iteration"
    names = [column, f"{column}, smoothed"]
    display.SeriesVisibility = names
    display.SeriesColor = [names[0], "0.75", "0.8", "0.88", names[1], "0.12", "0.35", "0.65"]
    display.SeriesLineThickness = [names[0], "1", names[1], "4"]
    view.ChartTitle = "Loss of the training"
    view.LeftAxisTitle, view.BottomAxisTitle = column, "iteration"
    view.LeftAxisLogScale = 1
    for axis in ("Left", "Bottom"):
        setattr(view, f"{axis}AxisTitleFontSize", 18)
        setattr(view, f"{axis}AxisLabelFontSize", 16)
    view.LegendFontSize = 16
    return display
