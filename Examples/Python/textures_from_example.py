#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of geometric textures from an example, without a training: geometric_texture_from_example().

    xvfb-run -a python3 textures_from_example.py --output DIR

The examples: spikes and knobs, the balls that the shipped models were learned from; the shell of the armadillo, a piece of a
scan; and bark, a random field whose ridges have a direction. The last row is a blend of two. Writes

    textures_from_example.png  rows: the examples; columns: the example, and targets of genus 0, 1 and 2
    from_example_*.vtp         the surfaces, with displacements

and prints how long each took and how far its patches are from those of the example (Mismatch). Bark grows along the longest
axis of targets, and along it spikes give way to knobs. Surfaces come from Debian's package libcgal-demo.
"""

import argparse
import os
import sys
import time

import gallery_rendering as rendering
import numpy as np
import surfacesynthesis
from surfacesynthesis.datasets import given_dataset
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkFiltersCore import vtkPolyDataConnectivityFilter

EXAMPLES = os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir)
sys.path.insert(0, os.path.join(EXAMPLES, "Training"))

from make_datasets import surface  # noqa: E402
from make_references import LEVELS, balls, directions, reference_levels  # noqa: E402

SIZE = (460, 440)
#: Where a texture grows, of which genus, the direction that it is seen from, and that in which bark grows.
TARGETS = {
    "bear": (0, (0.3, 0.2, 1.0), (0.0, 1.0, 0.0)),
    "knot1": (1, (0.1, 0.2, 1.0), (0.0, 1.0, 0.0)),
    "eight": (2, (0.2, 0.9, 0.6), (0.0, 0.0, 1.0)),
}
#: Center and radius of the piece of the armadillo with plates, units of the scan.
SHELL = (np.array([0.0, 65.0, 35.0]), 36.0)
#: Points of that piece, once remeshed, and the length of the smoothing that takes the plates off, about that of a plate.
SHELL_POINTS, PLATE = 4000, 16.0


def points_of(mesh):
    return vtk_to_numpy(mesh.GetPoints().GetData()).astype(float)


def add_vectors(mesh, name, vector):
    """Adds the same vector at each point."""
    array = numpy_to_vtk(np.tile(np.asarray(vector, dtype=float), (mesh.GetNumberOfPoints(), 1)), deep=True)
    array.SetName(name)
    mesh.GetPointData().AddArray(array)


def piece_of(mesh, center, radius):
    """The part of a surface in a ball, in one piece."""
    inside = np.linalg.norm(points_of(mesh) - center, axis=1) < radius
    triangles = vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    used, corners = np.unique(triangles[inside[triangles].all(axis=1)], return_inverse=True)
    largest = vtkPolyDataConnectivityFilter()
    largest.SetInputData(given_dataset((points_of(mesh)[used], corners.reshape(-1, 3))))
    largest.SetExtractionModeToLargestRegion()
    largest.Update()
    part = largest.GetOutput()
    return surfacesynthesis.repair(part, holes="none")


def shell():
    """The shell of the armadillo, about half of its back."""
    piece = piece_of(surface(None, "armadillo.off"), *SHELL)
    return surfacesynthesis.remesh(piece, points=SHELL_POINTS, feature_angle=None), {"smoothing_length": PLATE, "strength": 1.2}


def ball(texture):
    """A ball with a texture, and the ball without it."""
    plain = balls(LEVELS)[-1]
    plain.GetPoints().SetData(numpy_to_vtk(directions(plain), deep=True))
    return reference_levels(texture)[-1], {"plain_example": plain}


def spikes():
    return ball("spikes")


def knobs():
    return ball("knobs")


def bark(cells=96, side=3.0, stretch=4.0):
    """A square with ridges along x: the absolute value of a random field, negative."""
    x, y = (values.ravel() for values in np.meshgrid(*2 * [np.linspace(0.0, side, cells + 1)]))
    first = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    triangles = np.concatenate([first[:, None] + np.array(way) for way in ((0, 1, cells + 2), (0, cells + 2, cells + 1))])
    compressed = np.stack([x / stretch, y, 0 * x], axis=1)
    field = surfacesynthesis.matern_noise((compressed, triangles), range=0.35, operator_power=3, seed=4)
    example = given_dataset((np.stack([x, y, -0.09 * np.abs(field)], axis=1), triangles))
    add_vectors(example, "Growth", (1.0, 0.0, 0.0))
    directions = {"orientation": "Growth", "example_orientation": "Growth"}
    return example, {**directions, "plain_example": given_dataset((np.stack([x, y, 0 * x], axis=1), triangles))}


def blend():
    """Spikes, and knobs as the second example."""
    example, parameters = spikes()
    second, of_second = knobs()
    second_plain = of_second["plain_example"]
    return example, {**parameters, "second_example": second, "second_plain_example": second_plain, "blend": "Share"}


def add_share(mesh, direction):
    """Adds the share of a second example, which rises from 0 to 1 along a direction, and smoothly."""
    heights = points_of(mesh) @ np.asarray(direction, dtype=float)
    passed = np.clip((heights - heights.min()) / np.ptp(heights) * 1.5 - 0.25, 0.0, 1.0)
    array = numpy_to_vtk(passed**2 * (3.0 - 2.0 * passed), deep=True)
    array.SetName("Share")
    mesh.GetPointData().AddArray(array)


#: The examples, and the directions that they are seen from.
CASES = {
    "spikes": (spikes, (0.3, 0.2, 1.0)),
    "knobs": (knobs, (0.3, 0.2, 1.0)),
    "shell": (shell, (0.0, 0.3, 1.0)),
    "bark": (bark, (0.0, -0.5, 1.0)),
    "blend": (blend, (0.3, 0.2, 1.0)),
}


def synthesized(target, example, **parameters):
    """A surface with a texture, and the seconds it took."""
    started = time.monotonic()
    output = surfacesynthesis.geometric_texture_from_example(target, example, **parameters)
    return output, time.monotonic() - started


def add_row(sheet, row, name, targets, options):
    make, direction = CASES[name]
    example, parameters = make()
    aspect = SIZE[0] / SIZE[1]
    shown, title = example, f"{name}: the example"
    if "second_example" in parameters:
        shown, title = parameters["second_example"], f"{name}: the second example"
    sheet.add(row, 0, f"{title}\n{shown.GetNumberOfCells():,} faces", shown,
              rendering.view_of(shown, aspect, direction))  # fmt: skip
    for column, (target_name, target) in enumerate(targets.items(), 1):
        genus, direction, _ = TARGETS[target_name]
        output, seconds = synthesized(target, example, seed=options.seed, **parameters)
        mismatch = vtk_to_numpy(output.GetFieldData().GetArray("Mismatch"))[0]
        faces = f"{output.GetNumberOfCells():,} faces"
        print(f"{name} on {target_name}, {faces}: {seconds:.1f} s, mismatch {mismatch:.3f}", flush=True)
        view = rendering.view_of(target, aspect, direction, margin=1.15)
        sheet.add(row, column, f"{target_name}, genus {genus}\n{faces}, {seconds:.1f} s", output, view)
        surfacesynthesis.write_mesh(output, os.path.join(options.output, f"from_example_{name}_{target_name}.vtp"))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", required=True, metavar="DIR")
    parser.add_argument("--seed", type=int, default=1, help="default: 1")
    parser.add_argument("--points", type=int, default=2500, help="points of targets before subdivisions (default: 2500)")
    parser.add_argument("--only", nargs="+", choices=CASES, default=list(CASES), help="of the examples (default: all)")
    parser.add_argument("--colors", type=int, metavar="N", help="write PNGs with a palette of so few colours (needs PIL)")
    options = parser.parse_args()
    os.makedirs(options.output, exist_ok=True)
    targets = {}
    for name in TARGETS:
        targets[name] = surfacesynthesis.remesh(surface(None, name + ".off"), points=options.points, feature_angle=None)
        add_vectors(targets[name], "Growth", TARGETS[name][2])
        add_share(targets[name], TARGETS[name][2])
    sheet = rendering.Sheet(len(options.only), 1 + len(TARGETS), SIZE)
    for row, name in enumerate(options.only):
        add_row(sheet, row, name, targets, options)
    sheet.write(os.path.join(options.output, "textures_from_example.png"), options.colors)


if __name__ == "__main__":
    main()
