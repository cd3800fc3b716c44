# SPDX-License-Identifier: BSD-3-Clause
"""Renders surfaces offscreen into images, and puts images together into one picture."""

import functools
import os
import sys

import numpy as np
import vtkmodules.vtkInteractionStyle  # noqa: F401  (registers the factories of the rendering classes)
import vtkmodules.vtkRenderingFreeType  # noqa: F401
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import VTK_UNSIGNED_CHAR
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkFiltersCore import vtkPolyDataNormals
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkColorTransferFunction,
    vtkLight,
    vtkPolyDataMapper,
    vtkRenderer,
    vtkRenderWindow,
    vtkTextMapper,
    vtkTexture,
    vtkActor2D,
    vtkWindowToImageFilter,
)

BACKGROUND = (0.965, 0.965, 0.955)
INK = (0.16, 0.17, 0.19)
CLAY = (0.90, 0.85, 0.78)
SUPERSAMPLING = 2  # images are rendered this much larger and averaged


def cool_warm(limit):
    """A diverging colour map from -limit (blue) over 0 (light grey) to limit (red)."""
    colors = vtkColorTransferFunction()
    colors.SetColorSpaceToDiverging()
    colors.AddRGBPoint(-limit, 0.130, 0.300, 0.720)
    colors.AddRGBPoint(0.0, 0.930, 0.925, 0.915)
    colors.AddRGBPoint(limit, 0.730, 0.080, 0.130)
    return colors


def sequential(low, high):
    """A colour map from low (light) to high (dark red)."""
    colors = vtkColorTransferFunction()
    colors.SetColorSpaceToLab()
    for place, color in ((0.0, (0.99, 0.97, 0.88)), (0.5, (0.95, 0.60, 0.35)), (1.0, (0.45, 0.02, 0.12))):
        colors.AddRGBPoint(low + place * (high - low), *color)
    return colors


class View:
    """A camera with a parallel projection: looks along -``direction`` at ``center``; ``height`` world units are seen."""

    def __init__(self, center, height, direction=(0.0, 0.0, 1.0), up=(0.0, 1.0, 0.0)):
        self.center = np.asarray(center, dtype=float)
        self.height = height
        self.direction = np.asarray(direction, dtype=float) / np.linalg.norm(direction)
        self.up = np.asarray(up, dtype=float)

    def zoomed(self, center, height):
        """The same view of a smaller part."""
        return View(center, height, self.direction, self.up)

    def axes(self):
        """Unit vectors of the picture: to the right and upwards."""
        right = np.cross(self.up, self.direction)
        right /= np.linalg.norm(right)
        return right, np.cross(self.direction, right)

    def pixel(self, point, size):
        """Column and row of a point in an image of ``size`` (width, height)."""
        right, up = self.axes()
        offset = np.asarray(point) - self.center
        scale = size[1] / self.height
        return size[0] / 2 + scale * (offset @ right), size[1] / 2 - scale * (offset @ up)


def view_of(mesh, aspect, direction, margin=1.06):
    """The view along ``direction`` that shows all of a surface in an image of width / height = ``aspect``."""
    view = View((0, 0, 0), 1.0, direction)
    points = vtk_to_numpy(mesh.GetPoints().GetData()).astype(float)
    right, up = view.axes()
    spans = [(points @ axis).min() for axis in (right, up)], [(points @ axis).max() for axis in (right, up)]
    middle = [(low + high) / 2 for low, high in zip(*spans)]
    width, height = (high - low for low, high in zip(*spans))
    depth = points @ view.direction
    center = middle[0] * right + middle[1] * up + (depth.min() + depth.max()) / 2 * view.direction
    return View(center, margin * max(height, width / aspect), direction)


def _mapper(mesh, own_normals):
    """A mapper of a surface with its own normals, or with those of its triangles."""
    mapper = vtkPolyDataMapper()
    if own_normals:
        mapper.SetInputData(mesh)
        return mapper
    normals = vtkPolyDataNormals()
    normals.SetInputData(mesh)
    normals.SplittingOff()
    normals.ConsistencyOff()
    mapper.SetInputConnection(normals.GetOutputPort())
    return mapper


def render(mesh, view, size, array=None, limit=1.0, edges=False, color=CLAY, colors=None, texture=None):
    """The image [height, width, 3] of a surface, coloured by a point array (with a diverging map up to ``limit``, or the
    map ``colors``; RGB bytes as they are), with the image ``texture`` (and the normals of the surface), or plain."""
    shows_bytes = array is not None and mesh.GetPointData().GetArray(array).GetDataType() == VTK_UNSIGNED_CHAR
    mapper = _mapper(mesh, texture is not None or shows_bytes)
    actor = vtkActor()
    actor.SetMapper(mapper)
    if texture is not None:
        picture = vtkTexture()
        picture.SetInputData(texture)
        picture.InterpolateOn()
        actor.SetTexture(picture)
        color = (1.0, 1.0, 1.0)
    surface = actor.GetProperty()
    surface.SetInterpolationToPhong()
    if array is None:
        mapper.ScalarVisibilityOff()
        surface.SetColor(*color)
        surface.SetAmbient(0.16)
        surface.SetDiffuse(0.98)
        surface.SetSpecular(0.08)
        surface.SetSpecularPower(20)
    elif shows_bytes:
        mapper.SetScalarModeToUsePointFieldData()
        mapper.SelectColorArray(array)
        surface.SetAmbient(0.16)
        surface.SetDiffuse(0.98)
    else:
        mapper.SetScalarModeToUsePointFieldData()
        mapper.SelectColorArray(array)
        mapper.SetLookupTable(colors or cool_warm(limit))
        mapper.UseLookupTableScalarRangeOn()
        mapper.InterpolateScalarsBeforeMappingOn()
        surface.SetAmbient(0.42)  # little shading: colour, not light, tells the value
        surface.SetDiffuse(0.62)
    if edges:
        surface.EdgeVisibilityOn()
        surface.SetEdgeColor(0.18, 0.19, 0.22)
        surface.SetLineWidth(0.5 * SUPERSAMPLING)
    renderer = _renderer()
    renderer.AddActor(actor)
    _lights(renderer)
    camera = renderer.GetActiveCamera()
    camera.ParallelProjectionOn()
    camera.SetParallelScale(view.height / 2)
    camera.SetFocalPoint(*view.center)
    bounds = np.array(mesh.GetBounds()).reshape(3, 2)
    distance = 2 * np.linalg.norm(bounds[:, 1] - bounds[:, 0]) + 1e-300
    camera.SetPosition(*(view.center + distance * view.direction))
    camera.SetViewUp(*view.up)
    renderer.ResetCameraClippingRange()
    return _image(renderer, size)


def label(text, size, height, bold=False, upright=False, align="centre"):
    """An image of ``size`` with lines of text ``height`` pixels high; ``upright`` text reads from bottom to top."""
    if upright:
        return np.rot90(label(text, size[::-1], height, bold))
    mapper = vtkTextMapper()
    mapper.SetInput(text)
    style = mapper.GetTextProperty()
    style.SetFontFamilyToArial()
    style.SetFontSize(int(height * SUPERSAMPLING))
    style.SetColor(*INK)
    style.SetBold(bold)
    style.SetLineSpacing(1.2)
    style.SetVerticalJustificationToCentered()
    actor = vtkActor2D()
    actor.SetMapper(mapper)
    if align == "left":
        style.SetJustificationToLeft()
        actor.SetPosition(0, SUPERSAMPLING * size[1] // 2)
    else:
        style.SetJustificationToCentered()
        actor.SetPosition(SUPERSAMPLING * size[0] // 2, SUPERSAMPLING * size[1] // 2)
    renderer = _renderer()
    renderer.AddActor2D(actor)
    return _image(renderer, size)


def _renderer():
    renderer = vtkRenderer()
    renderer.SetBackground(*BACKGROUND)
    return renderer


def _lights(renderer):
    """A key light from the upper left of the camera and a weaker one from the right."""
    renderer.SetAutomaticLightCreation(0)
    for position, intensity in (((-0.45, 0.65, 1.0), 0.82), ((0.9, 0.1, 0.6), 0.28)):
        light = vtkLight()
        light.SetLightTypeToCameraLight()
        light.SetPosition(*position)
        light.SetFocalPoint(0, 0, 0)
        light.SetIntensity(intensity)
        renderer.AddLight(light)


@functools.lru_cache(maxsize=1)
def _window():
    """One window for all images: some X servers start anew whenever their last window is closed."""
    if sys.platform.startswith("linux") and not os.environ.get("DISPLAY"):
        raise OSError("there is no X display to render with; start with 'xvfb-run -a python3 ...'")
    window = vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    return window


def _image(renderer, size):
    window = _window()
    window.SetSize(SUPERSAMPLING * size[0], SUPERSAMPLING * size[1])
    window.AddRenderer(renderer)
    window.Render()
    grab = vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.SetInputBufferTypeToRGB()
    grab.ReadFrontBufferOff()
    grab.Update()
    image = grab.GetOutput()
    width, height, _ = image.GetDimensions()
    pixels = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(height, width, 3)[::-1]
    renderer.ReleaseGraphicsResources(window)
    window.RemoveRenderer(renderer)
    s = SUPERSAMPLING
    return np.round(pixels.reshape(height // s, s, width // s, s, 3).mean(axis=(1, 3))).astype(np.uint8)


def blank(size):
    """An empty image of ``size`` (width, height)."""
    return np.full((size[1], size[0], 3), np.round(255 * np.array(BACKGROUND)), dtype=np.uint8)


def paste(image, part, column, row, frame=None):
    """Puts an image into another one, in place, with a frame of a colour around it."""
    height, width = part.shape[:2]
    image[row : row + height, column : column + width] = part
    if frame is not None:
        outline(image, column, row, width, height, frame)


def outline(image, column, row, width, height, color, thickness=3):
    """Draws a rectangle, in place."""
    column, row, width, height = (int(round(value)) for value in (column, row, width, height))
    rgb = np.round(255 * np.array(color)).astype(np.uint8)
    image[row : row + thickness, column : column + width] = rgb
    image[row + height - thickness : row + height, column : column + width] = rgb
    image[row : row + height, column : column + thickness] = rgb
    image[row : row + height, column + width - thickness : column + width] = rgb


def write_png(image, path, colors=None):
    """Writes an image [height, width, 3] of bytes; with ``colors``, with so few colours and dithered."""
    if colors is not None:
        from PIL import Image

        picture = Image.fromarray(image)
        palette = picture.quantize(colors, kmeans=3)
        picture.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG).save(path, optimize=True)
        return
    height, width = image.shape[:2]
    data = vtkImageData()
    data.SetDimensions(width, height, 1)
    data.GetPointData().SetScalars(numpy_to_vtk(np.ascontiguousarray(image[::-1]).reshape(-1, 3), deep=True))
    writer = vtkPNGWriter()
    writer.SetFileName(path)
    writer.SetInputData(data)
    writer.SetCompressionLevel(9)
    writer.Write()
    if writer.GetErrorCode():
        raise OSError(f"{path} could not be written")


class Sheet:
    """Pictures of ``size`` (width, height) in rows, each with a title of two lines above it."""

    TITLE = 64

    def __init__(self, rows, columns, size, margin=0):
        """``margin``: width for scales of colours on the right."""
        self._size = size
        self._margin = margin
        self._image = blank((columns * size[0] + margin, rows * (size[1] + self.TITLE)))

    def add(self, row, column, title, mesh, view, **how):
        """The picture of a surface: see render()."""
        width, height = self._size
        x, y = column * width, row * (height + self.TITLE)
        paste(self._image, label(title, (width, self.TITLE), 19), x, y)
        paste(self._image, render(mesh, view, self._size, **how), x, y + self.TITLE)

    def add_image(self, row, column, title, image):
        """An image [height, width, 3] of the size of the pictures."""
        width, height = self._size
        x, y = column * width, row * (height + self.TITLE)
        paste(self._image, label(title, (width, self.TITLE), 19), x, y)
        paste(self._image, image, x, y + self.TITLE)

    def add_bar(self, row, colors, low, high, text, ticks=5):
        """The scale of ``colors`` from low (below) to high at the right of a row, with a title of lines of text."""
        width, height = self._margin, self._size[1]
        x, y = self._image.shape[1] - width, row * (height + self.TITLE) + self.TITLE
        length, thick = int(0.5 * height), int(0.2 * width)
        values = np.linspace(high, low, length)
        strip = np.array([colors.GetColor(value) for value in values])
        strip = np.repeat(np.round(255 * strip).astype(np.uint8)[:, None], thick, axis=1)
        top = y + (height - length) // 2
        paste(self._image, strip, x + 4, top)
        outline(self._image, x + 4, top, thick, length, INK, 1)
        for k in range(ticks):
            value = high + (low - high) * k / (ticks - 1)
            part = label(f"{value:g}".replace("-", "\u2212"), (width - thick - 14, 24), 17, align="left")
            paste(self._image, part, x + thick + 12, top + int(length * k / (ticks - 1)) - 12)
        paste(self._image, label(text, (width, 60), 17), x, top - 84)

    def write(self, path, colors=None):
        write_png(self._image, path, colors)
        print(f"wrote {path}", flush=True)
