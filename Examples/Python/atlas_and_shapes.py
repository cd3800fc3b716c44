#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Regions of an atlas as surfaces that share their borders, and a statistical shape model.

    xvfb-run -a python3 atlas_and_shapes.py atlas [volume names] --output DIR
    xvfb-run -a python3 atlas_and_shapes.py shapes [surface] --output DIR

atlas: makes a surface of each region of a label map (by default the AAL atlas of Debian's package mricron-data), prints the
largest relative error of a volume, and writes atlas.vtm and atlas.png.

shapes: makes 60 shapes of a surface (by default the femur of Debian's package libcgal-demo), displaced by random fields,
computes their mean and modes, and writes the model to model.vtp, and shapes.png.
"""

import argparse
import colorsys
import os
import sys

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCompositeDataSet, vtkMultiBlockDataSet, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkAppendPolyData, vtkMassProperties, vtkPolyDataNormals
from vtkmodules.vtkFiltersHybrid import vtkProcrustesAlignmentFilter

import gallery_meshes as meshes
import gallery_rendering as rendering
import surfacesynthesis as ss
from bone_shapes import solid, upright
from medical import upright_view
from observed_fields import load_bone
from surfacesynthesis.files.polygons import point_normals
from surfacesynthesis.warp import warped

ATLAS = "/usr/share/mricron/templates/aal.nii.gz"  # Debian's package mricron-data
NAMES = "/usr/share/mricron/templates/aal.nii.txt"
SHAPES = 60
MODES = 3

#: Groups of regions: name, hue, saturation, and the begins of the regions' names.
GROUPS = (
    ("frontal", 0.60, 0.55, ("Precentral", "Frontal", "Rolandic", "Supp_Motor", "Olfactory", "Rectus")),
    ("parietal", 0.36, 0.45, ("Postcentral", "Parietal", "SupraMarginal", "Angular", "Precuneus", "Paracentral")),
    ("temporal", 0.10, 0.62, ("Temporal", "Heschl", "Fusiform")),
    ("occipital", 0.98, 0.52, ("Occipital", "Calcarine", "Cuneus", "Lingual")),
    ("insula, cingulum", 0.78, 0.35, ("Insula", "Cingulum")),
    ("cerebellum", 0.07, 0.28, ("Cerebelum", "Vermis")),
)
#: Deep regions with colors of their own.
DEEP = (
    ("Thalamus", (0.20, 0.45, 0.75)),
    ("Caudate", (0.85, 0.35, 0.25)),
    ("Putamen", (0.95, 0.75, 0.30)),
    ("Pallidum", (0.55, 0.75, 0.45)),
    ("Hippocampus", (0.55, 0.35, 0.65)),
    ("ParaHippocampal", (0.80, 0.62, 0.80)),
    ("Amygdala", (0.30, 0.65, 0.65)),
)


def without_side(name):
    return name[:-2] if name.endswith(("_L", "_R")) else name


def color_of(name, order):
    """The color of a region, the same on both sides: the hue of its group, in several lightnesses."""
    for begin, color in DEEP:
        if name.startswith(begin):
            return color
    for _, hue, saturation, begins in GROUPS:
        if name.startswith(begins):
            shade = order % 4
            return colorsys.hsv_to_rgb((hue + 0.018 * (shade - 1.5)) % 1.0, saturation, 0.97 - 0.11 * shade)
    return colorsys.hsv_to_rgb(0.618 * order % 1.0, 0.5, 0.9)


def regions_of(surfaces):
    """Names and surfaces, with the array Color and normals at the points."""
    orders, regions = {}, []
    for k in range(surfaces.GetNumberOfBlocks()):
        name = surfaces.GetMetaData(k).Get(vtkCompositeDataSet.NAME())
        order = orders.setdefault(without_side(name), len(orders))
        normals = vtkPolyDataNormals()
        normals.SetInputData(surfaces.GetBlock(k))
        normals.SplittingOff()
        normals.ConsistencyOff()
        normals.Update()
        surface = normals.GetOutput()
        rgb = np.round(255 * np.array(color_of(name, order))).astype(np.uint8)
        colors = numpy_to_vtk(np.tile(rgb, (surface.GetNumberOfPoints(), 1)), deep=True)
        colors.SetName("Color")
        surface.GetPointData().AddArray(colors)
        regions.append((name, surface))
    return regions


def together(regions, apart=0.0):
    """All regions in one surface; each moved away from the center by a part of its distance."""
    append = vtkAppendPolyData()
    centers = [np.array(surface.GetCenter()) for _, surface in regions]
    middle = np.mean(centers, axis=0)
    for (_, surface), center in zip(regions, centers):
        moved = vtkPolyData()
        moved.ShallowCopy(surface)
        points = vtkPoints()
        points.SetData(numpy_to_vtk(vtk_to_numpy(surface.GetPoints().GetData()) + apart * (center - middle), deep=True))
        moved.SetPoints(points)
        append.AddInputData(moved)
    append.Update()
    return append.GetOutput()


def legend(entries, size, height):
    """Colored squares with names, in a row."""
    image = rendering.blank(size)
    width = size[0] // max(len(entries), 1)
    for k, (name, color) in enumerate(entries):
        rgb = np.round(255 * np.array(color)).astype(np.uint8)
        top = (size[1] - height) // 2
        image[top : top + height, k * width + 12 : k * width + 12 + height] = rgb
        text = rendering.label(name, (width - height - 26, size[1]), height - 4, align="left")
        rendering.paste(image, text, k * width + height + 22, 0)
    return image


def volume_error(surfaces):
    """The largest relative error of the volume of a surface."""
    errors = []
    for k in range(surfaces.GetNumberOfBlocks()):
        mass = vtkMassProperties()
        mass.SetInputData(surfaces.GetBlock(k))
        mass.Update()
        wanted = surfaces.GetBlock(k).GetFieldData().GetArray("SampleVolume").GetValue(0)
        errors.append(abs(mass.GetVolume() / wanted - 1.0))
    return max(errors)


def atlas(volume, names, folder):
    """Label map -> named surfaces; returns the picture."""
    surfaces = ss.label_surfaces(ss.read_volume(volume), names, smoothing_iterations=100)
    points = sum(surfaces.GetBlock(k).GetNumberOfPoints() for k in range(surfaces.GetNumberOfBlocks()))
    print(f"{surfaces.GetNumberOfBlocks()} regions, {points:,} points; volumes to {100 * volume_error(surfaces):.3f} percent")
    ss.write_mesh(surfaces, os.path.join(folder, "atlas.vtm"))
    regions = regions_of(surfaces)
    deep = [(name, surface) for name, surface in regions if name.startswith(tuple(name for name, _ in DEEP))] or regions
    size, title, strip = (640, 560), 70, 64
    image = rendering.blank((3 * size[0], size[1] + title + strip))
    outer = together(regions)
    panels = (
        (outer, (-1.0, 0.12, 0.25), f"{len(regions)} regions that share their borders"),
        (together(regions, 0.55), (-0.75, 0.6, 0.45), "each a closed surface of its own"),
        (together(deep), (-0.6, 0.75, 0.35), "deep regions, volumes of the voxels kept"),
    )
    for k, (mesh, direction, text) in enumerate(panels):
        part = rendering.render(mesh, upright_view(mesh, size, direction), size, "Color")
        rendering.paste(image, part, k * size[0], title)
        rendering.paste(image, rendering.label(text, (size[0], title), 25), k * size[0], 0)
    groups = [(name, colorsys.hsv_to_rgb(hue, saturation, 0.9)) for name, hue, saturation, _ in GROUPS]
    row = size[1] + title
    rendering.paste(image, legend(groups, (2 * size[0] - 40, strip), 20), 10, row)
    for begin in (0, 4):  # below the deep regions, in two rows
        part = legend(DEEP[begin : begin + 4], (size[0], strip // 2), 20)
        rendering.paste(image, part, 2 * size[0], row + begin // 4 * strip // 2)
    return image


def shapes(path, folder, points):
    """Surface -> ensemble -> statistical shape model; returns the picture."""
    surface = solid(upright(load_bone(path, folder)), points)
    longest = meshes.longest_side(surface)
    noise = ss.matern_noise(
        surface, range=0.8 * longest, standard_deviation=0.03 * longest, samples=SHAPES, components=3, seed=2, name="Move"
    )
    ensemble = aligned([warped(noise, f"Move_{k}", 1.0) for k in range(SHAPES)])
    statistics = ss.ensemble_statistics(ensemble, modes=10, quantiles=(0.05, 0.95))
    print(statistics)
    ss.write_mesh(statistics.surface, os.path.join(folder, "model.vtp"))
    return shapes_picture(statistics, longest)


def aligned(ensemble):
    """The shapes moved and turned onto their mean, so that modes are changes of shape alone."""
    blocks = vtkMultiBlockDataSet()
    for number, shape in enumerate(ensemble):
        blocks.SetBlock(number, shape)
    alignment = vtkProcrustesAlignmentFilter()
    alignment.SetInputData(blocks)
    alignment.GetLandmarkTransform().SetModeToRigidBody()
    alignment.Update()
    return alignment.GetOutput()


def moved_outwards(shape, mean):
    """The shape with the array Outwards: how far it lies outside the mean, along the normals of the mean."""
    offsets = vtk_to_numpy(shape.GetPoints().GetData()) - vtk_to_numpy(mean.GetPoints().GetData())
    array = numpy_to_vtk((offsets * point_normals(mean)).sum(axis=1), deep=True)
    array.SetName("Outwards")
    shape.GetPointData().AddArray(array)
    return shape


def shapes_picture(statistics, longest):
    """The mean with the standard deviation, and each mode at two standard deviations to either side."""
    size, title = (290, 740), 92
    image = rendering.blank(((1 + 2 * MODES) * size[0], size[1] + title))
    mean = statistics.surface
    height = mean.GetBounds()[5] - mean.GetBounds()[4]
    view = rendering.View(mean.GetCenter(), 1.22 * height, (0.0, -1.0, 0.0), (0.0, 0.0, 1.0))
    distance = vtk_to_numpy(mean.GetPointData().GetArray("StandardDistance"))
    low, high = 0.6 * distance.mean(), 1.6 * distance.mean()
    part = rendering.render(mean, view, size, "StandardDistance", colors=rendering.sequential(low, high))
    rendering.paste(image, part, 0, title)
    text = f"mean of {SHAPES} shapes\nstandard deviation\n{100 * low / longest:.1f} to {100 * high / longest:.1f} % of length"
    rendering.paste(image, rendering.label(text, (size[0], title), 20), 0, 0)
    limit = 0.04 * longest
    for k in range(MODES):
        for side, sign in enumerate((-2.0, 2.0)):
            coefficients = np.zeros(k + 1)
            coefficients[k] = sign
            shape = moved_outwards(ss.shape_model(statistics, coefficients=coefficients).GetBlock(0), mean)
            column = (1 + 2 * k + side) * size[0]
            part = rendering.render(shape, view, size, "Outwards", limit)
            rendering.paste(image, part, column, title)
            text = f"mode {k + 1}, {100 * statistics.fractions[k]:.0f} % of variance\n{sign:+.0f} standard deviations"
            rendering.paste(image, rendering.label(text, (size[0], title), 20), column, 0)
    return image


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pipeline", choices=("atlas", "shapes"))
    parser.add_argument("input", nargs="*", help="a label map and its table of names for atlas, a surface for shapes")
    parser.add_argument("--output", required=True, metavar="DIR", help="folder to write to; made when it is missing")
    parser.add_argument("--points", type=int, default=8000, metavar="N", help="points of the remeshed surface (8000)")
    parser.add_argument("--colors", type=int, metavar="N", help="reduce the picture to N colours (needs Pillow)")
    options = parser.parse_args(arguments)
    os.makedirs(options.output, exist_ok=True)
    try:
        if options.pipeline == "atlas":
            volume, names = (*options.input, None)[:2] if options.input else (ATLAS, NAMES)
            picture = atlas(volume, names, options.output)
        else:
            picture = shapes(options.input[0] if options.input else None, options.output, options.points)
        rendering.write_png(picture, os.path.join(options.output, f"{options.pipeline}.png"), options.colors)
    except (ss.SurfaceSynthesisError, OSError, ValueError, RuntimeError) as error:
        return f"atlas_and_shapes: {error}"
    return 0


if __name__ == "__main__":
    sys.exit(main())
