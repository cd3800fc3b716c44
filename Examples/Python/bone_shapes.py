#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A shape model of one bone without training: random shapes, and shapes through the landmarks of a patient.

    xvfb-run -a python3 bone_shapes.py [surface] --output DIR

Without a surface, the upper half of a femur in Debian's package libcgal-demo is used, scaled to 160 mm. Writes bone_shapes.png and
bone_shapes.vtp, the bone with six samples of shapes, their mean and standard deviation:

    above, the reference with six landmarks, and three shapes of the prior, a random displacement with a standard deviation of
    3 mm in every direction; below, a patient's bone of which only the landmarks are known, the mean of the shapes through
    them, and two samples, with the standard deviation that is left
"""

import argparse
import os

import numpy as np
import surfacesynthesis as ss
from surfacesynthesis.files.polygons import point_normals
from vtkmodules.util.numpy_support import vtk_to_numpy

import gallery_meshes as meshes
import gallery_rendering as rendering
from observed_fields import load_bone, with_balls

SIZE = (380, 780)
BAR = 150
LENGTH = 160.0  # mm
PRIOR = {"range": 80.0, "standard_deviation": 3.0, "operator_power": 3, "variance_correction": True}
PATIENT = 12  # seed of the bone that is to be found


def upright(bone):
    """The bone of LENGTH mm with its long axis upwards, its upper end, the wider one of the view, above."""
    points, triangles = meshes.arrays_of(bone)
    points = points - points.mean(axis=0)
    _, axes = np.linalg.eigh(points.T @ points)
    points = points @ axes[:, [1, 0, 2]]  # to the right, to the viewer, upwards
    if np.linalg.det(axes[:, [1, 0, 2]]) < 0:
        points[:, 1] *= -1
    height = points[:, 2]
    tenth = 0.1 * np.ptp(height)
    above, below = (np.ptp(points[np.abs(height - end) < tenth, 0]) for end in (height.max(), height.min()))
    if above < below:
        points[:, [1, 2]] *= -1
    return meshes.mesh_of(points * (LENGTH / np.ptp(points[:, 2])), triangles)


def solid(bone, points):
    """The bone without cavities, holes and what hangs on a neck of a few triangles, which moves nearly by itself."""
    voxel = LENGTH / 200
    closed = ss.vdb_surface(bone, voxel_size=voxel, closing=2.5 * voxel, smoothing="mean_curvature", smoothing_iterations=2,
                            fill_cavities=True, largest_component=True)
    for offset in (-2 * voxel, 2 * voxel):
        closed = ss.vdb_surface(closed, voxel_size=voxel, offset=offset, largest_component=True)
    return ss.remesh(closed, points=points, feature_angle=None)


def landmarks_of(points):
    """Ids of six points: top and both sides of the upper end, both sides of the lower end, and one on the shaft."""
    side, height = points[:, 0], points[:, 2] - points[:, 2].min()
    ids = [int(np.argmax(height))]
    for low, high in ((0.75, 1.0), (0.02, 0.1)):
        at_end = (height > low * LENGTH) & (height < high * LENGTH)
        ids += [int(np.argmax(np.where(at_end, direction * side, -np.inf))) for direction in (1, -1)]
    near = np.abs(height - 0.4 * LENGTH) < 0.02 * LENGTH
    ids.append(int(np.argmin(np.where(near, points[:, 1], np.inf))))
    return np.array(ids)


def array_of(mesh, name):
    return vtk_to_numpy(mesh.GetPointData().GetArray(name))


def show(bone, folder, colors):
    """Draws the shapes, prints their figures, and writes the picture and the surface."""
    points, triangles = meshes.arrays_of(bone)
    ids = landmarks_of(points)
    sheet = rendering.Sheet(2, 4, SIZE, margin=BAR)
    center = (points.min(axis=0) + points.max(axis=0)) / 2
    view = rendering.View(center, 1.14 * LENGTH, (0.0, -1.0, 0.0), (0.0, 0.0, 1.0))
    radius = 0.016 * LENGTH

    prior = ss.matern_noise(bone, samples=4, first_sample=PATIENT - 3, displacement="free", seed=3, **PRIOR)
    moves = [array_of(prior, f"MaternNoise_{PATIENT - 3 + k}") for k in range(4)]
    limit = 6.0
    diverging = rendering.cool_warm(limit)
    normals = point_normals(bone)  # outwards, as those of a closed surface from a level set
    shown = with_balls(bone, "Landmark", np.zeros(len(points)), points[ids], np.ones(len(ids)), radius)
    sheet.add(0, 0, f"reference\nand {len(ids)} landmarks", shown, view, array="Landmark", limit=1.0)
    for k in range(3):
        outwards = (moves[k] * normals).sum(axis=1)
        shape = with_balls(meshes.mesh_of(points + moves[k], triangles), "Outwards", outwards, [], [], radius)
        sheet.add(0, 1 + k, f"random shape {k + 1}\nof the prior", shape, view, array="Outwards", colors=diverging)
    sheet.add_bar(0, diverging, -limit, limit, "displacement\noutwards, mm")
    posterior(sheet, bone, ids, points + moves[3], view, radius, folder)
    sheet.write(os.path.join(folder, "bone_shapes.png"), colors)


def posterior(sheet, bone, ids, patient, view, radius, folder):
    """The lower row: shapes given the landmarks of the patient."""
    points, triangles = meshes.arrays_of(bone)
    given = ss.matern_noise(bone, samples=6, seed=7, displacement="free", observations=points[ids],
                            observation_array=patient[ids], observed_targets=True, posterior_mean=True,
                            posterior_standard_deviation=True, name="Shape", **PRIOR)
    mean, deviation = array_of(given, "Shape_Mean"), array_of(given, "Shape_StandardDeviation")
    high = 3.0
    colors = rendering.sequential(0.0, high)
    shapes = [("the patient's bone,\nunknown but for the landmarks", patient, None)]
    shapes.append(("mean of the shapes\nthrough the landmarks", points + mean, deviation))
    shapes += [(f"shape {k + 1}\nthrough the landmarks", points + array_of(given, f"Shape_{k}"), deviation) for k in (0, 1)]
    for column, (title, positions, values) in enumerate(shapes):
        moved = meshes.mesh_of(positions, triangles)
        plain = values is None
        shown = with_balls(moved, "Value", np.zeros(len(points)) if plain else values, positions[ids],
                           np.full(len(ids), 1.0 if plain else 0.0), radius)
        how = {"limit": 1.0} if plain else {"colors": colors}
        sheet.add(1, column, title, shown, view, array="Value", **how)
    sheet.add_bar(1, colors, 0.0, high, "standard\ndeviation, mm")
    errors = np.linalg.norm(points + mean - patient, axis=1)
    missed = max(np.abs(points[ids] + array_of(given, f"Shape_{k}")[ids] - patient[ids]).max() for k in range(6))
    print(f"landmarks are met within {missed:.1g} mm")
    print(f"root mean square of the distance to the patient's bone: reference "
          f"{np.sqrt(((points - patient) ** 2).sum(axis=1).mean()):.1f} mm, mean shape {np.sqrt((errors**2).mean()):.1f} mm, "
          f"expected {np.sqrt(3 * (deviation**2).mean()):.1f} mm")
    within = np.abs(points + mean - patient)[deviation > 1e-6] <= 1.96 * deviation[deviation > 1e-6, None]
    print(f"coordinates of the patient's bone within 1.96 standard deviations of the mean shape: {100 * within.mean():.0f} %")
    ss.write_mesh(given, os.path.join(folder, "bone_shapes.vtp"))


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("surface", nargs="?", help="a long surface in any format that surfacesynthesis.read_mesh() reads")
    parser.add_argument("--output", required=True, metavar="DIR", help="folder to write to; made when it is missing")
    parser.add_argument("--colors", type=int, metavar="N", help="reduce the picture to N colours (needs Pillow)")
    given = parser.parse_args(arguments)
    os.makedirs(given.output, exist_ok=True)
    show(solid(upright(load_bone(given.surface, given.output)), 8000), given.output, given.colors)


if __name__ == "__main__":
    main()
