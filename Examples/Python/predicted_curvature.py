#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A picture of what the small example network predicts, beside the truth.

    xvfb-run -a python3 predicted_curvature.py [--model FILE] --output DIR

The network (Examples/Models/smoothed_curvature.safetensors) has learnt the mean curvature, smoothed over a scale, of
one surface: the armadillo of Debian's package libcgal-demo with 1,500, 2,500 and 6,000 vertices. The columns are that
surface, another triangulation of it, and surfaces that it has never seen. Writes predicted_curvature.png, and the
surfaces with both arrays as .vtp files.
"""

import argparse
import os
import sys
import tarfile

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy

import gallery_meshes as meshes
import gallery_rendering as rendering
import surfacesynthesis

EXAMPLES = os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir)
sys.path.insert(0, os.path.join(EXAMPLES, "Training"))

from smoothed_curvature import smoothed_curvature  # noqa: E402

MODEL = os.path.join(EXAMPLES, "Models", "smoothed_curvature.safetensors")
#: Title, file in the archive, vertices that are kept (None: all), direction from the surface to the viewer.
COLUMNS = (
    ("training surface", "armadillo", 2500, (0.16, 0.08, -1.0)),
    ("same, other triangles", "armadillo", 9000, (0.16, 0.08, -1.0)),
    ("bunny, not seen", "bunny00", 5000, (0.1, 0.2, 1.0)),
    ("camel, not seen", "camel", 5000, (1.0, 0.1, 0.3)),
    ("hand, not seen", "hand", 5000, (0.1, 0.1, 1.0)),
    ("femur, not seen", "femur", 5000, (0.2, -1.0, 0.2)),
)


def surface_of(name, vertices, folder):
    path = os.path.join(folder, name + ".off")
    with tarfile.open(meshes.ARCHIVE) as archive, open(path, "wb") as file:
        file.write(archive.extractfile(f"data/meshes/{name}.off").read())
    mesh = meshes.load(path, folder)
    return meshes.decimated(mesh, vertices) if vertices < mesh.GetNumberOfPoints() else mesh


def with_truth(mesh, model):
    """The surface with the prediction and the truth, and the correlation of the two, weighted by area."""
    output = surfacesynthesis.poisson_net(mesh, model)
    points, triangles = meshes.arrays_of(mesh)
    truth = smoothed_curvature(points, triangles)
    array = numpy_to_vtk(truth, deep=True)
    array.SetName("Truth")
    output.GetPointData().AddArray(array)
    predicted = vtk_to_numpy(output.GetPointData().GetArray("Prediction"))
    corners = points[triangles]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    weights = np.bincount(triangles.ravel(), np.repeat(areas, 3), len(points))
    covariance = np.cov(predicted, truth, aweights=weights)
    return output, covariance[0, 1] / np.sqrt(covariance[0, 0] * covariance[1, 1])


def picture(model, folder):
    size, left, top, limit = (330, 430), 70, 96, 0.3
    image = rendering.blank((left + len(COLUMNS) * size[0], top + 2 * size[1]))
    for row, title in enumerate(("truth", "prediction")):
        text = rendering.label(title, (left, size[1]), 28, bold=True, upright=True)
        rendering.paste(image, text, 0, top + row * size[1])
    for column, (title, name, vertices, direction) in enumerate(COLUMNS):
        mesh, correlation = with_truth(surface_of(name, vertices, folder), model)
        print(f"{title}: {mesh.GetNumberOfPoints()} points, correlation {correlation:.3f}", flush=True)
        surfacesynthesis.write_mesh(mesh, os.path.join(folder, f"predicted_{column}_{name}.vtp"))
        x = left + column * size[0]
        text = f"{title}\n{mesh.GetNumberOfPoints():,} vertices, correlation {correlation:.2f}"
        rendering.paste(image, rendering.label(text, (size[0], top), 19), x, 0)
        view = rendering.view_of(mesh, size[0] / size[1], direction)
        for row, array in enumerate(("Truth", "Prediction")):
            rendering.paste(image, rendering.render(mesh, view, size, array, limit), x, top + row * size[1])
    return image


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--model", default=MODEL)
    parser.add_argument("--output", required=True, metavar="DIR")
    parser.add_argument("--colors", type=int, metavar="N", help="write a PNG with a palette of so few colours (needs PIL)")
    arguments = parser.parse_args()
    os.makedirs(arguments.output, exist_ok=True)
    image = picture(arguments.model, arguments.output)
    rendering.write_png(image, os.path.join(arguments.output, "predicted_curvature.png"), arguments.colors)


if __name__ == "__main__":
    main()
