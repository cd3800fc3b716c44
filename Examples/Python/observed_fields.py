#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Random fields that two triangulations share, fields given observations, and shapes of a bone through landmarks.

    xvfb-run -a python3 observed_fields.py [surface [bone]] --output DIR

Without surfaces, the armadillo and the femur of Debian's package libcgal-demo are used. Writes observed_fields.png:

    the same seed of coherent noise on the surface and on a decimated one; mean and standard deviation of a field given 60
    observations, and the parameters that are estimated from a field and printed
    a bone with landmarks and the places that they are to take, the mean shape, and two samples of shapes through them
"""

import argparse
import os
import tarfile

import numpy as np
import surfacesynthesis as ss
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkFiltersCore import vtkAppendPolyData
from vtkmodules.vtkFiltersSources import vtkSphereSource

import gallery_meshes as meshes
import gallery_rendering as rendering
from gallery import DIRECTION, LIMIT, noise

SIZE = (470, 540)
OBSERVATIONS = 60
FEMUR = "data/meshes/femur.off"  # in the archive of Debian's package libcgal-demo


def with_balls(mesh, name, values, centers, ball_values, radius):
    """The surface with an array, and balls at places, each with a value of it."""
    together = vtkAppendPolyData()
    shown = vtkPolyData()
    shown.CopyStructure(mesh)
    parts = [(shown, values)]
    for center, value in zip(centers, ball_values):
        ball = vtkSphereSource()
        ball.SetCenter(*center)
        ball.SetRadius(radius)
        ball.SetThetaResolution(24)
        ball.SetPhiResolution(16)
        ball.Update()
        part = vtkPolyData()
        part.CopyStructure(ball.GetOutput())
        parts.append((part, np.full(part.GetNumberOfPoints(), value)))
    for part, array in parts:
        scalars = numpy_to_vtk(np.ascontiguousarray(array, dtype=np.float64), deep=True)
        scalars.SetName(name)
        part.GetPointData().AddArray(scalars)
        together.AddInputData(part)
    together.Update()
    return together.GetOutput()


def fields(sheet, surface):
    """Coherent noise on two triangulations, and a field given observations of another one."""
    longest = meshes.longest_side(surface)
    view = rendering.view_of(surface, SIZE[0] / SIZE[1], DIRECTION)
    coarse = meshes.decimated(surface, max(500, surface.GetNumberOfPoints() // 9))
    for column, mesh in enumerate((surface, coarse)):
        field = noise(mesh, range=0.25 * longest, seed=3, coherent_noise=True)
        title = f"coherent noise, seed 3\n{mesh.GetNumberOfPoints():,} points"
        sheet.add(0, column, title, field, view, array="MaternNoise", limit=LIMIT)
    few = noise(coarse, range=0.25 * longest, seed=9)
    print(f"estimated from one field of range {0.25 * longest:.4g} and deviation 1:")
    print(ss.estimate_matern(few, "MaternNoise", noise_estimation=False, mean_estimation=False))
    truth = noise(surface, range=0.25 * longest, seed=8)
    ids = np.linspace(0, surface.GetNumberOfPoints() - 1, OBSERVATIONS).astype(int)
    places = meshes.arrays_of(surface)[0][ids]
    values = vtk_to_numpy(truth.GetPointData().GetArray("MaternNoise"))[ids]
    given = noise(surface, range=0.25 * longest, observations=places, observation_array=values, posterior_mean=True,
                  posterior_standard_deviation=True)
    mean, deviation = (
        vtk_to_numpy(given.GetPointData().GetArray(f"MaternNoise_{name}")) for name in ("Mean", "StandardDeviation")
    )
    radius = 0.012 * longest
    shown = with_balls(surface, "Mean", mean, places, values, radius)
    sheet.add(0, 2, f"mean given {OBSERVATIONS}\nobservations (balls)", shown, view, array="Mean", limit=LIMIT)
    shown = with_balls(surface, "Deviation", deviation, places, 0 * values, radius)
    colors = rendering.sequential(0.0, 1.2)
    sheet.add(0, 3, "standard deviation\n0 (light) to 1.2 (dark)", shown, view, array="Deviation", colors=colors)


def load_bone(path, folder):
    """The bone, valid and of even triangles."""
    if path is None:
        path = os.path.join(folder, "femur.off")
        with tarfile.open(meshes.ARCHIVE) as archive, open(path, "wb") as file:
            file.write(archive.extractfile(FEMUR).read())
    valid = ss.repair(ss.read_mesh(path), holes="all", largest_component=True)
    return ss.remesh(valid, points=6000, feature_angle=None)


def bones(sheet, bone):
    """Shapes of a bone through landmarks: a displacement with three components, given that of the landmarks."""
    points = meshes.arrays_of(bone)[0]
    center = (points.min(axis=0) + points.max(axis=0)) / 2
    _, axes = np.linalg.eigh((points - center).T @ (points - center))
    along, across = axes[:, 2], axes[:, 1]
    length = np.ptp(points @ along)
    radii = np.linalg.norm(points - center - np.outer((points - center) @ along, along), axis=1)
    if radii[(points - center) @ along < 0].max() > radii.max() * 0.999:
        along = -along  # the wide end is above
    view = rendering.View(center, 1.2 * length, axes[:, 0], along)
    # Both sides of the ends are landmarks: the bone gets longer, and its upper end wider.
    height, side = (points - center) @ along / length, (points - center) @ across
    ids, moves = [], []
    for end, stretch in ((1, 0.035), (-1, -0.035)):
        at_end = end * height > 0.38
        for direction in (1, -1):
            ids.append(int(np.argmax(np.where(at_end, direction * side, -np.inf))))
            moves.append(length * (stretch * along + 0.03 * (end > 0) * direction * across))
    ids += [int(np.argmin(np.abs(height - h) + (side < np.median(side)))) for h in (0.15, -0.15)]
    moves += [np.zeros(3), np.zeros(3)]
    moves, radius = np.array(moves), 0.014 * length
    shape = {"range": 0.5 * length, "standard_deviation": 0.03 * length, "components": 3, "operator_power": 4,
             "variance_correction": True}
    samples = ss.matern_noise(bone, samples=2, seed=4, observations=points[ids], observation_array=moves,
                              posterior_mean=True, **shape)
    plain, ends = np.zeros(len(points)), points[ids] + moves
    balls = np.concatenate([points[ids], ends])
    shown = with_balls(bone, "Landmark", plain, balls, [-1.0] * len(ids) + [1.0] * len(ids), radius)
    sheet.add(1, 0, "bone and landmarks (blue),\nwhere they are to be (red)", shown, view, array="Landmark", limit=1.0)
    cases = (("mean shape", "MaternNoise_Mean"), ("sample 1", "MaternNoise_0"), ("sample 2", "MaternNoise_1"))
    for column, (title, name) in enumerate(cases, 1):
        displacement = vtk_to_numpy(samples.GetPointData().GetArray(name))
        error = np.abs(displacement[ids] - moves).max()
        print(f"{title}: landmarks are met within {error / length:.1g} of the length")
        moved = meshes.mesh_of(points + displacement, meshes.arrays_of(bone)[1])
        shown = with_balls(moved, "Landmark", plain, ends, np.ones(len(ids)), radius)
        sheet.add(1, column, f"{title}\nthrough the landmarks", shown, view, array="Landmark", limit=1.0)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("surface", nargs="?", help="any format that surfacesynthesis.read_mesh() reads")
    parser.add_argument("bone", nargs="?", help="a long surface, likewise")
    parser.add_argument("--output", required=True, metavar="DIR", help="folder to write to; made when it is missing")
    given = parser.parse_args(arguments)
    os.makedirs(given.output, exist_ok=True)
    sheet = rendering.Sheet(2, 4, SIZE)
    fields(sheet, meshes.load(given.surface, given.output))
    bones(sheet, load_bone(given.bone, given.output))
    sheet.write(os.path.join(given.output, "observed_fields.png"))


if __name__ == "__main__":
    main()
