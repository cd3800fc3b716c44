#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""From scans to meshes with random fields, in the scans' own coordinates.

    xvfb-run -a python3 medical.py brain [volume] --output DIR
    xvfb-run -a python3 medical.py femur [surface] --output DIR

brain: reads a volume (by default the brain of Debian's package mricron-data), makes its surface with OpenVDB, remeshes
it, adds random fields whose range is in millimetres, fills it with tetrahedra, and writes brain.vtp, brain.vtu and
brain.png.

femur: repairs and remeshes a surface (by default the femur of Debian's package libcgal-demo), displaces it by 50 random
fields along its normals, and writes the standard deviation of each point over these shapes to femur.vtp, and femur.png.
"""

import argparse
import os
import sys
import tarfile
import time

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkPlane
from vtkmodules.vtkFiltersExtraction import vtkExtractGeometry
from vtkmodules.vtkFiltersGeometry import vtkDataSetSurfaceFilter

import gallery_meshes as meshes
import gallery_rendering as rendering
import surfacesynthesis as ss
from surfacesynthesis.warp import warped

BRAIN = "/usr/share/mricron/templates/ch2bet.nii.gz"  # Debian's package mricron-data
FEMUR = "data/meshes/femur.off"  # in the archive of Debian's package libcgal-demo
SHAPES = 50


class Clock:
    """Says what was made and how long it took."""

    def __init__(self):
        self._last = time.monotonic()

    def say(self, text):
        now = time.monotonic()
        print(f"{text} ({now - self._last:.1f} s)", flush=True)
        self._last = now


def size_of(mesh):
    return f"{mesh.GetNumberOfPoints():,} points, {mesh.GetNumberOfCells():,} cells"


def brain(volume, folder, points):
    """Volume -> surface -> even triangles -> random fields -> tetrahedra; returns the picture."""
    clock = Clock()
    scan = ss.read_volume(volume)
    clock.say(f"read {volume}: {' x '.join(map(str, scan.GetDimensions()))} voxels of {scan.GetSpacing()} mm")
    surface = ss.vdb_surface(
        scan, smoothing="mean_curvature", smoothing_iterations=2, closing=2.0, fill_cavities=True, largest_component=True
    )
    clock.say(f"surface: {size_of(surface)}")
    surface = ss.remesh(surface, points=points, feature_angle=None)
    clock.say(f"remeshed: {size_of(surface)}")
    surface = ss.matern_noise(surface, range=25.0, standard_deviation=1.0, seed=4, samples=3, name="Field")
    clock.say("random fields with a range of 25 mm")
    grid = ss.tetrahedralize(surface, quality_ratio=1.5, edge_length=8.0)
    clock.say(f"tetrahedra: {size_of(grid)}")
    ss.write_mesh(surface, os.path.join(folder, "brain.vtp"))
    ss.write_mesh(grid, os.path.join(folder, "brain.vtu"))
    clock.say("wrote brain.vtp and brain.vtu")
    picture = brain_picture(surface, grid)
    clock.say("picture")
    return picture


def brain_picture(surface, grid):
    """The field on the surface, the triangles, and the tetrahedra behind a cut."""
    size, title = (620, 560), 76
    image = rendering.blank((3 * size[0], size[1] + title))
    view = upright_view(surface, size, (-0.8, 0.45, 0.35))
    close = view.zoomed(view.center, 0.22 * view.height)
    center = np.array(surface.GetCenter())
    cut = cut_open(grid, center, (-0.9, 0.3, 0.2))
    panels = (
        (surface, view, "Field_0", False, "random field, range 25 mm"),
        (surface, close, "Field_0", True, f"{surface.GetNumberOfCells():,} triangles"),
        (cut, view, None, True, f"{grid.GetNumberOfCells():,} tetrahedra, cut open"),
    )
    for k, (mesh, seen, array, edges, text) in enumerate(panels):
        part = rendering.render(mesh, seen, size, array, 2.5, edges=edges)
        rendering.paste(image, part, k * size[0], 0)
        rendering.paste(image, rendering.label(text, (size[0], title), 26), k * size[0], size[1])
    return image


def upright_view(surface, size, direction):
    """The view from ``direction`` with z upwards that shows all of the surface."""
    view = rendering.View((0, 0, 0), 1.0, direction, (0.0, 0.0, 1.0))
    points = vtk_to_numpy(surface.GetPoints().GetData()).astype(float)
    right, up = view.axes()
    across, along = points @ right, points @ up
    center = (across.min() + across.max()) / 2 * right + (along.min() + along.max()) / 2 * up
    center += (points @ view.direction).mean() * view.direction
    height = 1.06 * max(np.ptp(along), np.ptp(across) * size[1] / size[0])
    return rendering.View(center, height, direction, (0.0, 0.0, 1.0))


def cut_open(grid, center, normal):
    """The surface of the tetrahedra behind a plane, whole tetrahedra only."""
    plane = vtkPlane()
    plane.SetOrigin(*center)
    plane.SetNormal(*normal)
    behind = vtkExtractGeometry()
    behind.SetInputData(grid)
    behind.SetImplicitFunction(plane)
    outside = vtkDataSetSurfaceFilter()
    outside.SetInputConnection(behind.GetOutputPort())
    outside.Update()
    return outside.GetOutput()


def femur(path, folder, points):
    """Repair -> even triangles -> an ensemble of displaced shapes -> their standard deviation; returns the picture."""
    clock = Clock()
    if path is None:
        path = os.path.join(folder, "femur.off")
        with tarfile.open(meshes.ARCHIVE) as archive, open(path, "wb") as file:
            file.write(archive.extractfile(FEMUR).read())
    scan = ss.read_mesh(path)
    valid = ss.repair(scan, holes="all", largest_component=True)
    clock.say(f"repaired {size_of(scan)}: {ss.repair_report(valid) or 'the surface was valid'}")
    surface = ss.remesh(valid, points=points, feature_angle=None)
    clock.say(f"remeshed: {size_of(surface)}")
    longest = meshes.longest_side(surface)
    noise = ss.matern_noise(surface, range=0.3 * longest, standard_deviation=0.006 * longest, samples=SHAPES, seed=1)
    shapes = [warped(noise, f"MaternNoise_{k}", 1.0) for k in range(SHAPES)]
    clock.say(f"{SHAPES} shapes, displaced by 0.6 % of the length with a range of 30 %")
    positions = np.stack([vtk_to_numpy(shape.GetPoints().GetData()) for shape in shapes]).astype(np.float64)
    deviation = np.sqrt(positions.var(axis=0, ddof=1).sum(axis=1))
    array = numpy_to_vtk(deviation, deep=True)
    array.SetName("StandardDeviation")
    surface.GetPointData().AddArray(array)
    ss.write_mesh(surface, os.path.join(folder, "femur.vtp"))
    print(f"standard deviation of the points: mean {deviation.mean():.4g}, asked {0.006 * longest:.4g}")
    picture = femur_picture(scan, surface, shapes, deviation)
    clock.say("picture")
    return picture


def femur_picture(scan, surface, shapes, deviation):
    """The scan, even triangles, two of the shapes, and the map."""
    size, title = (380, 700), 76
    image = rendering.blank((5 * size[0], size[1] + title))
    center = np.array(surface.GetCenter())
    points = vtk_to_numpy(surface.GetPoints().GetData()).astype(float) - center
    _, axes = np.linalg.eigh(points.T @ points)  # the long axis is the last
    view = rendering.View(center, 1.12 * np.ptp(points @ axes[:, 2]), axes[:, 0], axes[:, 2])
    low, high = 0.6 * deviation.mean(), 1.6 * deviation.mean()
    panels = (
        (scan, None, True, f"scan\n{scan.GetNumberOfCells():,} triangles"),
        (surface, None, True, f"remeshed\n{surface.GetNumberOfCells():,} triangles"),
        (shapes[0], None, False, "shape 1 of 50"),
        (shapes[1], None, False, "shape 2 of 50"),
        (surface, "StandardDeviation", False, f"standard deviation\n{low:.2g} (light) to {high:.2g} (dark)"),
    )
    for k, (mesh, array, edges, text) in enumerate(panels):
        colors = rendering.sequential(low, high) if array else None
        part = rendering.render(mesh, view, size, array, edges=edges, colors=colors)
        rendering.paste(image, part, k * size[0], 0)
        rendering.paste(image, rendering.label(text, (size[0], title), 24), k * size[0], size[1])
    return image


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pipeline", choices=("brain", "femur"))
    parser.add_argument("input", nargs="?", help="a volume for brain, a surface for femur")
    parser.add_argument("--output", required=True, metavar="DIR", help="folder to write to; made when it is missing")
    parser.add_argument("--points", type=int, metavar="N", help="points of the remeshed surface (30000 and 6000)")
    parser.add_argument("--colors", type=int, metavar="N", help="reduce the picture to N colours (needs Pillow)")
    options = parser.parse_args(arguments)
    os.makedirs(options.output, exist_ok=True)
    try:
        if options.pipeline == "brain":
            picture = brain(options.input or BRAIN, options.output, options.points or 30000)
        else:
            picture = femur(options.input, options.output, options.points or 6000)
        rendering.write_png(picture, os.path.join(options.output, f"{options.pipeline}.png"), options.colors)
    except (ss.SurfaceSynthesisError, OSError, ValueError, RuntimeError) as error:
        return f"medical: {error}"
    return 0


if __name__ == "__main__":
    sys.exit(main())
