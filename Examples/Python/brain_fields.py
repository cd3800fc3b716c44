#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Random fields in the volume of a brain, cut open.

    xvfb-run -a python3 brain_fields.py [volume] --output DIR

Without a volume, the brain of Debian's package mricron-data is used. Its surface is made with OpenVDB and remeshed, and
tetrahedra fill it. Writes brain_fields.vtu and brain_fields.png:

    fields with a correlation range of 60 and of 36 mm, and one of 36 mm that is four times as long from front to back
    a field to observe at places on the cut, the mean of the field given these observations, and its standard deviation
"""

import argparse
import os
import sys

import numpy as np
import surfacesynthesis as ss
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkPlane
from vtkmodules.vtkFiltersCore import vtkAppendPolyData, vtkPolyDataNormals
from vtkmodules.vtkFiltersGeneral import vtkClipDataSet
from vtkmodules.vtkFiltersGeometry import vtkDataSetSurfaceFilter

import gallery_rendering as rendering
from medical import BRAIN, Clock, size_of, upright_view
from observed_fields import with_balls

SIZE = (600, 540)
FIELD = {"operator_power": 3, "boundary_condition": "robin", "robin_coefficient": 1.0}
OBSERVATIONS = 40
LIMIT = 2.5


def tetrahedra_of(scan, edge_length):
    """The surface of a brain, and the tetrahedra inside."""
    surface = ss.vdb_surface(
        scan, smoothing="mean_curvature", smoothing_iterations=2, closing=2.0, fill_cavities=True, largest_component=True
    )
    surface = ss.remesh(surface, edge_length=edge_length, feature_angle=None)
    return surface, ss.tetrahedralize(surface, quality_ratio=1.5, edge_length=edge_length)


def clipped(grid, origin, normal):
    """The part of the grid on the side of a plane to which the normal points."""
    plane = vtkPlane()
    plane.SetOrigin(*origin)
    plane.SetNormal(*normal)
    clip = vtkClipDataSet()
    clip.SetInputData(grid)
    clip.SetClipFunction(plane)
    clip.Update()
    return clip.GetOutput()


def cut_open(grid, corner):
    """The surface of the grid without the part to the left of and above ``corner``, with sharp edges at the cut."""
    right = clipped(grid, corner, (1, 0, 0))
    lower_left = clipped(clipped(grid, corner, (-1, 0, 0)), corner, (0, 0, -1))
    together = vtkAppendPolyData()
    for part in (right, lower_left):
        outside = vtkDataSetSurfaceFilter()
        outside.SetInputData(part)
        outside.Update()
        together.AddInputData(outside.GetOutput())
    edges = vtkPolyDataNormals()
    edges.SetInputConnection(together.GetOutputPort())
    edges.SetFeatureAngle(50.0)
    edges.Update()
    return edges.GetOutput()


def places_on_cut(grid, corner):
    """Ids of points near the two faces of the cut, spread over them."""
    points = vtk_to_numpy(grid.GetPoints().GetData()).astype(float)
    left, below = points[:, 0] - corner[0], points[:, 2] - corner[2]
    on_cut = ((np.abs(left) < 2.0) & (below > 6.0)) | ((np.abs(below) < 2.0) & (left < -6.0))
    candidates, ids = np.flatnonzero(on_cut), []
    distance = np.full(len(candidates), np.inf)
    for _ in range(min(OBSERVATIONS, len(candidates))):  # each time the place that is farthest from those before
        chosen = int(np.argmax(distance)) if ids else 0
        ids.append(candidates[chosen])
        distance = np.minimum(distance, np.linalg.norm(points[candidates] - points[ids[-1]], axis=1))
    return np.array(ids), points


def add_direction(grid):
    """The point array "Direction": from front to back everywhere."""
    array = numpy_to_vtk(np.tile((0.0, 1.0, 0.0), (grid.GetNumberOfPoints(), 1)), deep=True)
    array.SetName("Direction")
    grid.GetPointData().AddArray(array)


def fields(sheet, grid, corner, view, clock):
    """Ranges and a direction."""
    cases = (
        ("correlation range 60 mm", {"range": 60.0}),
        ("correlation range 36 mm", {"range": 36.0}),
        ("36 mm, four times as long\nfrom front to back", {"range": 36.0, "direction_array": "Direction"}),
    )
    for column, (title, arguments) in enumerate(cases):
        field = ss.matern_noise(grid, seed=4, **FIELD, **arguments)
        sheet.add(0, column, title, cut_open(field, corner), view, array="MaternNoise", limit=LIMIT)
        clock.say(title.replace("\n", " "))


def observed(sheet, grid, corner, view, clock):
    """A field, its mean given observations, and the standard deviation."""
    field = {"range": 50.0, **FIELD}
    truth = ss.matern_noise(grid, seed=21, **field)
    ids, points = places_on_cut(grid, corner)
    values = vtk_to_numpy(truth.GetPointData().GetArray("MaternNoise"))[ids]
    given = ss.matern_noise(
        grid, observations=points[ids], observation_array=values, posterior_mean=True, posterior_standard_deviation=True,
        **field,
    )
    clock.say(f"mean and standard deviation given {len(ids)} observations")
    cases = (
        ("a field of range 50 mm,\nobserved at the balls", truth, "MaternNoise", values, None),
        (f"mean given the {len(ids)} observations", given, "MaternNoise_Mean", values, None),
        ("standard deviation\n0 (light) to 1 (dark)", given, "MaternNoise_StandardDeviation", 0.0 * values,
         rendering.sequential(0.0, 1.0)),
    )
    for column, (title, data, name, balls, colors) in enumerate(cases):
        cut = cut_open(data, corner)
        shown = with_balls(cut, name, vtk_to_numpy(cut.GetPointData().GetArray(name)), points[ids], balls, 2.2)
        sheet.add(1, column, title, shown, view, array=name, limit=LIMIT, colors=colors)
    return given


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("volume", nargs="?", default=BRAIN, help="any format that surfacesynthesis.read_volume() reads")
    parser.add_argument("--output", required=True, metavar="DIR", help="folder to write to; made when it is missing")
    parser.add_argument("--edge-length", type=float, default=4.0, metavar="L", help="of the tetrahedra, mm (default: 4)")
    parser.add_argument("--colors", type=int, metavar="N", help="reduce the picture to N colours (needs Pillow)")
    options = parser.parse_args(arguments)
    os.makedirs(options.output, exist_ok=True)
    clock = Clock()
    try:
        surface, grid = tetrahedra_of(ss.read_volume(options.volume), options.edge_length)
        clock.say(f"tetrahedra: {size_of(grid)}")
        add_direction(grid)
        corner = np.array(surface.GetCenter()) + (0.05, 0.0, 0.02) * np.ptp(np.reshape(surface.GetBounds(), (3, 2)), axis=1)
        view = upright_view(surface, SIZE, (-0.75, 0.5, 0.62))
        sheet = rendering.Sheet(2, 3, SIZE)
        fields(sheet, grid, corner, view, clock)
        ss.write_mesh(observed(sheet, grid, corner, view, clock), os.path.join(options.output, "brain_fields.vtu"))
        sheet.write(os.path.join(options.output, "brain_fields.png"), options.colors)
        clock.say("wrote brain_fields.vtu and brain_fields.png")
    except (ss.SurfaceSynthesisError, OSError, ValueError, RuntimeError) as error:
        return f"brain_fields: {error}"
    return 0


if __name__ == "__main__":
    sys.exit(main())
