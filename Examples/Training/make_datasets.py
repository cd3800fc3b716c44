# SPDX-License-Identifier: BSD-3-Clause
"""Makes data for flow matching on surfaces: poses of the armadillo, and Gaussian mixtures on the bunny.

    python3 make_datasets.py FOLDER [options]

writes eight files, each with one surface and many samples of a signal on it (see surfacesynthesis.read_signal_dataset):

    armadillo_poses.safetensors      poses of the armadillo, simplified to 5,000 triangles that are small where it is
                                     curved: to end a training with
    armadillo_medium.safetensors     the same poses and more, on 1,280 triangles
    armadillo_coarse.safetensors     these, carried to 260 triangles: to begin a training with
    armadillo_test.safetensors       other poses, on a triangulation that is dense on one side and coarse on the other
    armadillo_full_test.safetensors  some of the same poses as in the test file, on the original triangulation
    bunny_mixtures.safetensors       mixtures on the bunny, remeshed evenly: to end a training with
    bunny_coarse.safetensors         the same mixtures and more, on 1,000 triangles: to begin a training with
    bunny_test.safetensors           other mixtures, on a triangulation that is coarse on one side

Training samples begin at number 0 and test samples at number 100,000 of the same seed, so that all are different. The
extremities of the armadillo and their joints are found on its original triangulation: sample k is the same pose on all
all. Numbers of samples and points are options; with the defaults the files are about 170 MB together, and it takes a
quarter of an hour on two processors, most of it for the original triangulation. The surfaces come from Debian's package
libcgal-demo, or from files.
"""

import argparse
import os
import sys
import tarfile
import tempfile
import time

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkFiltersCore import vtkQuadricDecimation

import surfacesynthesis
from carrying import carried

ARCHIVE = "/usr/share/doc/libcgal-demo/data.tar.gz"
FIRST_TEST_SAMPLE = 100000


def surface(path, name):
    """The surface at ``path``, or the one of this name in the archive when it is None, repaired and in one piece."""
    if path is not None:
        mesh = surfacesynthesis.read_mesh(path)
    else:
        with tarfile.open(ARCHIVE) as archive, tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, name)
            with open(path, "wb") as file:
                file.write(archive.extractfile("data/meshes/" + name).read())
            mesh = surfacesynthesis.read_mesh(path)
    return in_one_piece(mesh)


def in_one_piece(mesh):
    return surfacesynthesis.repair(mesh, holes="all", largest_component=True)


def simplified(mesh, vertices):
    """The surface with about so many points, more of them where it is curved."""
    decimation = vtkQuadricDecimation()
    decimation.SetInputData(mesh)
    decimation.VolumePreservationOn()
    decimation.SetTargetReduction(1.0 - vertices / mesh.GetNumberOfPoints())
    decimation.Update()
    return decimation.GetOutput()


def evenly(mesh, vertices):
    """The surface with about so many points, evenly spread."""
    return surfacesynthesis.remesh(mesh, points=vertices, feature_angle=None)


def unevenly(mesh, vertices, ratio):
    """The surface with about so many points and edges that are ``ratio`` times as long where x is above the middle."""
    x = vtk_to_numpy(mesh.GetPoints().GetData())[:, 0]
    sized = vtkPolyData()
    sized.ShallowCopy(mesh)
    lengths = numpy_to_vtk(np.where(x > 0.5 * (x.min() + x.max()), ratio, 1.0), deep=True)
    lengths.SetName("EdgeLength")
    sized.GetPointData().AddArray(lengths)
    result = surfacesynthesis.remesh(sized, points=vertices, sizing="EdgeLength", feature_angle=None)
    result.GetPointData().RemoveArray("EdgeLength")
    return result


def carried_poses(mesh, samples, source, poses, **_):
    """Poses of one triangulation on another, which follows the nearest places."""
    points, rest = points_and_triangles(mesh)[0], points_and_triangles(source)
    return points + carried(poses[:samples] - rest[0], rest, points)


def points_and_triangles(mesh):
    points = vtk_to_numpy(mesh.GetPoints().GetData()).astype(float)
    return points, vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3)


class Maker:
    """Writes files into a folder and says what it does."""

    def __init__(self, folder, seed, progress):
        self._folder = folder
        self._seed = seed
        self._progress = progress

    def poses(self, name, mesh, template, samples, first_sample):
        """Returns the poses, [N, V, 3]."""
        made = surfacesynthesis.poses
        return self._write(name, "Position", made, mesh, samples, first_sample, template=template)

    def carried_poses(self, name, mesh, source, poses):
        """Poses of another triangulation, ``source``."""
        self._write(name, "Position", carried_poses, mesh, len(poses), 0, source=source, poses=poses)

    def mixtures(self, name, mesh, samples, first_sample):
        self._write(name, "Mixture", surfacesynthesis.gaussian_mixtures, mesh, samples, first_sample)

    def _write(self, name, signal, make, mesh, samples, first_sample, **options):
        started = time.monotonic()
        values = make(mesh, samples, seed=self._seed, first_sample=first_sample, progress=self._show, **options)
        path = os.path.join(self._folder, name)
        surfacesynthesis.write_signal_dataset(path, [(mesh, values)], signal)
        seconds = time.monotonic() - started
        print(f"\r{samples:,} samples on {mesh.GetNumberOfPoints():,} points, {seconds:.0f} s -> {path}", flush=True)
        return values

    def _show(self, fraction):
        if self._progress:
            print(f"\r{100 * fraction:3.0f} %", end="", flush=True)


def parsed(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", help="where to write; made when it is not there")
    parser.add_argument("--seed", type=int, default=0, help="default: 0")
    parser.add_argument("--armadillo", metavar="FILE", help="a surface to pose instead")
    parser.add_argument("--bunny", metavar="FILE", help="a surface for mixtures instead")
    parser.add_argument("--poses", type=int, default=2500, metavar="N", help="poses to train with (default: 2500)")
    parser.add_argument("--coarse-poses", type=int, default=6000, metavar="N", help="on few triangles (default: 6000)")
    parser.add_argument("--test-poses", type=int, default=300, metavar="N", help="poses to test with (default: 300)")
    parser.add_argument("--full-poses", type=int, default=100, metavar="N", help="on the original (default: 100)")
    parser.add_argument("--mixtures", type=int, default=3000, metavar="N", help="mixtures to train with (default: 3000)")
    parser.add_argument("--coarse-mixtures", type=int, default=6000, metavar="N", help="on few triangles (default: 6000)")
    parser.add_argument("--test-mixtures", type=int, default=500, metavar="N", help="to test with (default: 500)")
    parser.add_argument("--pose-vertices", type=int, default=2500, metavar="V", help="to train with (default: 2500)")
    parser.add_argument("--coarse-pose-vertices", type=int, nargs=2, default=[642, 130], metavar="V",
                        help="of medium and coarse poses (default: 642 130)")  # fmt: skip
    parser.add_argument("--mixture-vertices", type=int, default=2000, metavar="V", help="to train with (default: 2000)")
    parser.add_argument("--coarse-mixture-vertices", type=int, default=500, metavar="V", help="default: 500")
    parser.add_argument("--test-vertices", type=int, default=5000, metavar="V", help="to test with (default: 5000)")
    parser.add_argument("--ratio", type=float, default=2.0, help="of edge lengths in the test files (default: 2)")
    return parser.parse_args(arguments)


def main(arguments=None):
    options = parsed(arguments)
    os.makedirs(options.folder, exist_ok=True)
    make = Maker(options.folder, options.seed, sys.stdout.isatty())
    bunny = surface(options.bunny, "bunny00.off")
    make.mixtures("bunny_mixtures.safetensors", evenly(bunny, options.mixture_vertices), options.mixtures, 0)
    coarse = evenly(bunny, options.coarse_mixture_vertices)
    make.mixtures("bunny_coarse.safetensors", coarse, options.coarse_mixtures, 0)
    uneven = unevenly(bunny, options.test_vertices, options.ratio)
    make.mixtures("bunny_test.safetensors", uneven, options.test_mixtures, FIRST_TEST_SAMPLE)

    armadillo = surface(options.armadillo, "armadillo.off")
    simple = simplified(armadillo, options.pose_vertices)
    make.poses("armadillo_poses.safetensors", simple, armadillo, options.poses, 0)
    medium, coarse = (in_one_piece(simplified(armadillo, count)) for count in options.coarse_pose_vertices)
    poses = make.poses("armadillo_medium.safetensors", medium, armadillo, options.coarse_poses, 0)
    make.carried_poses("armadillo_coarse.safetensors", coarse, medium, poses)
    uneven = unevenly(armadillo, options.test_vertices, options.ratio)
    make.poses("armadillo_test.safetensors", uneven, armadillo, options.test_poses, FIRST_TEST_SAMPLE)
    make.poses("armadillo_full_test.safetensors", armadillo, armadillo, options.full_poses, FIRST_TEST_SAMPLE)


if __name__ == "__main__":
    main()
