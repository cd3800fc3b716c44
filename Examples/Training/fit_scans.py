#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Fits levels to scans, whole and cropped, and prints how close they come.

    python3 fit_scans.py [--archive FILE] [--only NAME ...] [--templates NAME ...] [--iterations N] [--output FOLDER]

The scans are meshes of Debian's package libcgal-demo. Each is fitted whole and as the piece that vtkClipPolyData leaves of it.
The rows of the table: mean and 95th percentile of the distance of samples of both surfaces from the other one, over the
diagonal of the box of the scan; mean angle of the normals there; pairs of triangles that intersect (builds with CGAL);
seconds of processor time.
"""

import argparse
import math
import os
import tarfile
import tempfile
import time

from vtkmodules.vtkCommonDataModel import vtkPlane
from vtkmodules.vtkFiltersCore import vtkCleanPolyData, vtkClipPolyData, vtkPolyDataConnectivityFilter, vtkTriangleFilter

import surfacesynthesis

ARCHIVE = "/usr/share/doc/libcgal-demo/data.tar.gz"
#: Origin and normal of the plane in front of which the piece lies, as fractions of the box.
CROPS = {
    "armadillo": ((0.5, 0.45, 0.5), (0.0, 1.0, 0.0)),  # chest, head and arms
    "bunny00": ((0.5, 0.6, 0.5), (0.0, -1.0, 0.0)),  # the body without the ears
    "lion-head": ((0.5, 0.5, 0.4), (0.0, 0.0, 1.0)),
    "elephant": ((0.5, 0.5, 0.5), (0.0, 1.0, 0.0)),  # genus 3 in the whole
}


def load(archive, name, folder):
    """The scan ``name`` of the archive."""
    path = os.path.join(folder, f"{name}.off")
    with tarfile.open(archive) as files, open(path, "wb") as file:
        file.write(files.extractfile(f"data/meshes/{name}.off").read())
    return surfacesynthesis.read_mesh(path)


def cropped(mesh, origin, normal):
    """The largest piece of the mesh in front of a plane."""
    low, high = mesh.GetBounds()[::2], mesh.GetBounds()[1::2]
    plane = vtkPlane()
    plane.SetOrigin([a + f * (b - a) for a, b, f in zip(low, high, origin)])
    plane.SetNormal(normal)
    clip = vtkClipPolyData()
    clip.SetClipFunction(plane)
    clip.SetInputData(mesh)
    clean = vtkCleanPolyData()
    clean.SetTolerance(1e-3)  # of the diagonal: needles at the cut become edges
    clean.SetInputConnection(clip.GetOutputPort())
    largest = vtkPolyDataConnectivityFilter()
    largest.SetExtractionModeToLargestRegion()
    largest.SetInputConnection(clean.GetOutputPort())
    triangles = vtkTriangleFilter()
    triangles.PassVertsOff()
    triangles.PassLinesOff()
    triangles.SetInputConnection(largest.GetOutputPort())
    points = vtkCleanPolyData()
    points.PointMergingOff()  # only points without triangles go
    points.SetInputConnection(triangles.GetOutputPort())
    points.Update()
    return points.GetOutput()


def row(name, mesh, template, iterations, output):
    """Fits the levels and prints the row of the table."""
    start = time.process_time()
    fit = surfacesynthesis.fit_levels(mesh, template=template, iterations=iterations)
    seconds = time.process_time() - start
    bounds = mesh.GetBounds()
    percent = 100.0 / math.dist(bounds[::2], bounds[1::2])
    print(
        f"| {name} | {mesh.GetNumberOfPolys():,} | {template} | {fit.levels[-1].GetNumberOfPolys():,} | "
        f"{percent * fit.symmetric_mean_distances[-1]:.3f} % | {percent * fit.symmetric_percentiles_95[-1]:.3f} % | "
        f"{fit.mean_normal_angles[-1]:.1f} | {fit.self_intersections[-1]} | {seconds:.0f} |",
        flush=True,
    )
    if output:
        surfacesynthesis.write_mesh(fit.levels[-1], os.path.join(output, f"{name.replace(', ', '-')}-{template}.vtp"))


def main(arguments=None):
    """The example."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--archive", default=ARCHIVE)
    parser.add_argument("--only", nargs="+", default=list(CROPS), choices=list(CROPS))
    parser.add_argument("--templates", nargs="+", default=["surface"], help="surface, icosphere")
    parser.add_argument("--iterations", type=int, default=300)
    parser.add_argument("--output", help="folder for the finest levels")
    arguments = parser.parse_args(arguments)
    print("| scan | triangles | template | fitted | mean distance | 95th percentile | angle | intersections | seconds |")
    print("|---|---:|---|---:|---:|---:|---:|---:|---:|")
    with tempfile.TemporaryDirectory() as folder:
        for name in arguments.only:
            scan = load(arguments.archive, name, folder)
            for template in arguments.templates:
                row(name, scan, template, arguments.iterations, arguments.output)
                if template == "surface":  # balls have no boundary
                    row(f"{name}, cropped", cropped(scan, *CROPS[name]), template, arguments.iterations, arguments.output)


if __name__ == "__main__":
    main()
