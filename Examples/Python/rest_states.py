#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Soft bodies that lie on a floor: rest states after random drops, and a brain under its weight.

    xvfb-run -a python3 rest_states.py [surface ...] [--brain FILE] --output DIR

Without surfaces, the bunny and the armadillo of Debian's package libcgal-demo are dropped, and the brain of mricron-data is laid
down. Writes rest_states.png, and rest_states_K.vtm with the rest states of surface K:

    a row for each surface: the shape, and four rest states of half a meter of soft tissue (10 kPa) after drops with random
    orientations and spins
    the brain, of tetrahedra in its own millimeters, without weight and with Young's moduli of 30, 10, 3 and 1 kPa

Colors are the logarithm of how much larger the area has become.
"""

import argparse
import os
import sys
import tarfile

import numpy as np
import surfacesynthesis as ss
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkFiltersCore import vtkAppendPolyData
from vtkmodules.vtkFiltersGeometry import vtkDataSetSurfaceFilter
from vtkmodules.vtkFiltersSources import vtkPlaneSource

import gallery_meshes as meshes
import gallery_rendering as rendering
from medical import BRAIN, Clock

SIZE = (400, 330)
BAR = 130
SHAPES = ("bunny00.off", "armadillo.off")
LIMIT = 0.4
MODULI = (3e4, 1e4, 3e3, 1e3)
VIEW = (0.25, -1.0, 0.32)
#: Turns of the shapes of libcgal-demo to z upwards.
UPRIGHT = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


def shape_of_debian(name, folder):
    """A shape of libcgal-demo with z upwards, closed, without what intersects itself."""
    with tarfile.open(meshes.ARCHIVE) as archive, open(os.path.join(folder, name), "wb") as file:
        file.write(archive.extractfile(f"data/meshes/{name}").read())
    points, triangles = meshes.arrays_of(meshes.load(os.path.join(folder, name), folder))
    return ss.repair(meshes.mesh_of(points @ UPRIGHT.T, triangles), holes="all", self_intersections=True)


def areas_of(points, triangles):
    """A third of the area of the triangles at each point."""
    corners = points[triangles]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 6.0
    return np.bincount(triangles.ravel(), np.repeat(areas, 3), len(points))


def on_floor(points, rest, triangles, floor, extent):
    """The surface with the array Stretch, and a square of the floor with 0."""
    ratio = areas_of(points, triangles) / np.maximum(areas_of(rest, triangles), 1e-30)
    plane = vtkPlaneSource()
    center = points.mean(axis=0)
    corner = np.array([center[0] - 0.75 * extent, center[1] - 0.6 * extent, floor])
    plane.SetOrigin(*corner)
    plane.SetPoint1(*(corner + (1.5 * extent, 0.0, 0.0)))
    plane.SetPoint2(*(corner + (0.0, 1.2 * extent, 0.0)))
    plane.Update()
    together = vtkAppendPolyData()
    square = plane.GetOutput()
    for mesh, values in ((meshes.mesh_of(points, triangles), np.log(ratio)), (square, np.zeros(4))):
        part = vtkPolyData()
        part.CopyStructure(mesh)
        array = numpy_to_vtk(np.ascontiguousarray(values, dtype=np.float64), deep=True)
        array.SetName("Stretch")
        part.GetPointData().AddArray(array)
        together.AddInputData(part)
    together.Update()
    return together.GetOutput()


def show(sheet, row, column, title, points, rest, triangles, floor, extent):
    shown = on_floor(points, rest, triangles, floor, extent)
    center = points.mean(axis=0)
    center[2] = floor + 0.36 * extent
    view = rendering.View(center, 1.02 * extent, VIEW, (0.0, 0.0, 1.0))
    sheet.add(row, column, title, shown, view, array="Stretch", colors=rendering.cool_warm(LIMIT))


def drops(sheet, row, mesh, name, surface_points, path):
    """A shape and four of its rest states."""
    rest, triangles = meshes.arrays_of(mesh)
    algorithm = ss.vtkElasticRestFilter()
    algorithm.SetInputDataObject(mesh)
    algorithm.SetNumberOfSamples(4)
    algorithm.SetNumberOfSurfacePoints(surface_points)
    algorithm.SetSeed(3)
    algorithm.Update()
    states = algorithm.GetOutputDataObject(0)
    if states.GetNumberOfBlocks() != 4:
        raise RuntimeError(f"{name} has not come to rest")
    floor = rest[:, 2].min()
    extent = 1.12 * np.linalg.norm(np.ptp(rest, axis=0)) / 1.3
    show(sheet, row, 0, f"{name}\n{len(rest):,} points", rest, rest, triangles, floor, extent)
    for k in range(4):
        points = vtk_to_numpy(states.GetBlock(k).GetPoints().GetData()).astype(float)
        seconds = states.GetBlock(k).GetFieldData().GetArray("SettlingTime").GetTuple1(0)
        show(sheet, row, 1 + k, f"rest state {k + 1}\nafter {seconds:.1f} s", points, rest, triangles, floor, extent)
    ss.write_mesh(states, path)


def tetrahedra_of(scan, edge_length):
    """Tetrahedra in a brain whose folds are closed."""
    surface = ss.vdb_surface(scan, smoothing="mean_curvature", smoothing_iterations=4, closing=3.0, fill_cavities=True,
                             largest_component=True)
    surface = ss.remesh(surface, edge_length=edge_length, feature_angle=None)
    return ss.tetrahedralize(surface, edge_length=1.5 * edge_length)


def tissue(sheet, row, grid):
    """A volume under its weight, for several stiffnesses."""
    surface = vtkDataSetSurfaceFilter()
    surface.SetInputData(grid)
    surface.PassThroughPointIdsOn()
    surface.Update()
    rest, triangles = meshes.arrays_of(surface.GetOutput())
    ids = vtk_to_numpy(surface.GetOutput().GetPointData().GetArray("vtkOriginalPointIds"))
    floor = rest[:, 2].min()
    extent = 1.12 * np.linalg.norm(np.ptp(rest, axis=0)) / 1.3
    show(sheet, row, 0, f"brain, {grid.GetNumberOfCells():,}\ntetrahedra", rest, rest, triangles, floor, extent)
    for k, modulus in enumerate(MODULI):
        (points,) = ss.rest_states(
            grid, 1, length_unit=1e-3, youngs_modulus=modulus, poissons_ratio=0.45, density=1040.0, drop_height=0.0,
            minimum_spin=0.0, maximum_spin=0.0, random_orientation=False, align=False, maximum_time=0.0,
        )  # fmt: skip
        sunk = np.ptp(rest[:, 2]) - np.ptp(points[ids, 2])
        title = f"Young's modulus {modulus / 1000:g} kPa\n{sunk:.1f} mm lower"
        show(sheet, row, 1 + k, title, points[ids].astype(float), rest, triangles, floor, extent)
        print(f"{modulus:g} Pa: {sunk:.2f} mm lower")


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("surfaces", nargs="*", help="closed surfaces that surfacesynthesis.read_mesh() reads, z upwards")
    parser.add_argument("--brain", default=BRAIN, metavar="FILE", help="a volume that surfacesynthesis.read_volume() reads")
    parser.add_argument("--edge-length", type=float, default=8.0, metavar="L", help="of its surface, mm (default: 8)")
    parser.add_argument("--surface-points", type=int, default=500, metavar="N", help="of simulated surfaces (default: 500)")
    parser.add_argument("--output", required=True, metavar="DIR", help="folder to write to; made when it is missing")
    parser.add_argument("--colors", type=int, metavar="N", help="reduce the picture to N colours (needs Pillow)")
    options = parser.parse_args(arguments)
    os.makedirs(options.output, exist_ok=True)
    clock = Clock()
    try:
        bodies = []
        for path in options.surfaces or SHAPES:
            mesh = meshes.load(path, options.output) if options.surfaces else shape_of_debian(path, options.output)
            bodies.append((mesh, os.path.splitext(os.path.basename(path))[0].rstrip("0")))
        sheet = rendering.Sheet(len(bodies) + 1, 5, SIZE, margin=BAR)
        for row, (mesh, name) in enumerate(bodies):
            path = os.path.join(options.output, f"rest_states_{row}.vtm")
            drops(sheet, row, mesh, name, options.surface_points, path)
            clock.say(f"four rest states of {name}")
            sheet.add_bar(row, rendering.cool_warm(LIMIT), -LIMIT, LIMIT, "logarithm\nof area")
        grid = tetrahedra_of(ss.read_volume(options.brain), options.edge_length)
        tissue(sheet, len(bodies), grid)
        sheet.add_bar(len(bodies), rendering.cool_warm(LIMIT), -LIMIT, LIMIT, "logarithm\nof area")
        sheet.write(os.path.join(options.output, "rest_states.png"), options.colors)
        clock.say("wrote rest_states.png")
    except (ss.SurfaceSynthesisError, OSError, ValueError, RuntimeError) as error:
        return f"rest_states: {error}"
    return 0


if __name__ == "__main__":
    sys.exit(main())
