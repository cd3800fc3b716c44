#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Random fields of several smoothnesses, deviations, boundaries and directions on a surface.

    xvfb-run -a python3 random_fields.py [surface] --output DIR

Without a surface, the armadillo of Debian's package libcgal-demo is used. Writes random_fields.png:

    operator power 1 to 4, with the same standard deviation at every point
    the standard deviation over samples, without and with the variance correction, on the surface and on a part of it with
    an open boundary
    a Dirichlet condition at that boundary, a direction, a range that varies, and a barrier
"""

import argparse
import os

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkPolyData

import gallery_meshes as meshes
import gallery_rendering as rendering
from gallery import DIRECTION, LIMIT, noise

SIZE = (470, 540)
SAMPLES = 400


def add_array(data, name, values):
    array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
    array.SetName(name)
    data.AddArray(array)


def with_deviation(mesh, longest, corrected):
    """The surface with the standard deviation of fields at each point, over SAMPLES samples, as the array "Deviation"."""
    fields = noise(mesh, range=0.2 * longest, variance_correction=corrected, samples=SAMPLES).GetPointData()
    squares = np.zeros(mesh.GetNumberOfPoints())
    for k in range(SAMPLES):
        squares += vtk_to_numpy(fields.GetArray(f"MaternNoise_{k}")) ** 2
    result = vtkPolyData()
    result.ShallowCopy(mesh)
    deviation = np.sqrt(squares / SAMPLES)
    add_array(result.GetPointData(), "Deviation", deviation)
    return result, deviation


def part_of(surface, view):
    """The surface below the middle of the picture, with its open boundary."""
    points, triangles = meshes.arrays_of(surface)
    height = points @ view.axes()[1]
    limit = (height.min() + height.max()) / 2
    kept = triangles[(height[triangles] < limit).all(axis=1)]
    used, renumbered = np.unique(kept, return_inverse=True)
    return meshes.mesh_of(points[used], renumbered.reshape(-1, 3))


def add_variations(mesh, view):
    """Arrays of a surface that vary its fields: "direction", "factor" and "barrier"."""
    points, triangles = meshes.arrays_of(mesh)
    right, up = view.axes()
    height = points @ up
    height = (height - height.min()) / np.ptp(height)
    side = points @ right - view.center @ right
    add_array(mesh.GetPointData(), "direction", np.tile(up, (len(points), 1)))
    add_array(mesh.GetPointData(), "factor", 0.25 + 1.5 * height)
    middle = side[triangles].mean(axis=1)
    add_array(mesh.GetCellData(), "barrier", (np.abs(middle) < 0.015 * view.height).astype(np.uint8))


def powers(sheet, surface, view, longest):
    """Operator powers from 1 to 4, the first at the screening of the power 2."""
    for column, power in enumerate((1, 1.5, 2.5, 4)):
        scale = {"screening": 8 / (0.2 * longest) ** 2} if power == 1 else {"range": 0.2 * longest}
        field = noise(surface, operator_power=power, variance_correction=True, seed=2, **scale)
        smoothness = f"smoothness nu = {power - 1:g}"
        sheet.add(0, column, f"operator power {power:g}\n{smoothness}", field, view, array="MaternNoise", limit=LIMIT)


def deviations(sheet, surface, part, view, longest):
    """Standard deviations without and with the correction, of the surface and of its part."""
    colors = rendering.sequential(0.9, 1.8)
    for column, (mesh, corrected) in enumerate(((surface, False), (surface, True), (part, False), (part, True))):
        shown, deviation = with_deviation(mesh, longest, corrected)
        low, high = np.percentile(deviation, (0.5, 99.5))
        what = "with variance correction" if corrected else "standard deviation, 1 asked for"
        seen = view if mesh is surface else rendering.view_of(part, SIZE[0] / SIZE[1], DIRECTION)
        sheet.add(1, column, f"{what}\n{low:.2f} to {high:.2f}", shown, seen, array="Deviation", colors=colors)


def variations(sheet, surface, part, view, longest):
    """Boundary, direction, range and barrier."""
    add_variations(surface, view)
    cases = (
        (
            "Dirichlet condition: 0\nat the open boundary",
            part,
            {"boundary_condition": "dirichlet", "variance_correction": False},
        ),
        ("direction upwards\nratio 8", surface, {"direction_array": "direction", "anisotropy_ratio": 8.0}),
        ("range factor\n0.25 to 1.75, upwards", surface, {"range_factor_array": "factor"}),
        ("barrier, grey\nrange of half the size", surface, {"barrier_array": "barrier", "range": 0.5 * longest}),
    )
    for column, (title, mesh, arguments) in enumerate(cases):
        arguments = {"range": 0.16 * longest, "seed": 5, "variance_correction": True, **arguments}
        seen = view if mesh is surface else rendering.view_of(part, SIZE[0] / SIZE[1], DIRECTION)
        sheet.add(2, column, title, noise(mesh, **arguments), seen, array="MaternNoise", limit=LIMIT)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("surface", nargs="?", help="any format that surfacesynthesis.read_mesh() reads")
    parser.add_argument("--output", required=True, metavar="DIR", help="folder to write to; made when it is missing")
    parser.add_argument("--colors", type=int, metavar="N", help="write a PNG with a palette of so few colours (needs PIL)")
    given = parser.parse_args(arguments)
    os.makedirs(given.output, exist_ok=True)
    surface = meshes.load(given.surface, given.output)
    longest = meshes.longest_side(surface)
    view = rendering.view_of(surface, SIZE[0] / SIZE[1], DIRECTION)
    part = part_of(surface, view)
    sheet = rendering.Sheet(3, 4, SIZE)
    powers(sheet, surface, view, longest)
    deviations(sheet, surface, part, view, longest)
    variations(sheet, surface, part, view, longest)
    sheet.write(os.path.join(given.output, "random_fields.png"), given.colors)


if __name__ == "__main__":
    main()
