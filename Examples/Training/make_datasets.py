# SPDX-License-Identifier: BSD-3-Clause
"""Makes data for flow matching on surfaces: poses of the armadillo, mild and far-reaching ones, and Gaussian mixtures on the
bunny.

    python3 make_datasets.py FOLDER [options]

writes fourteen files, each with one surface, or several, and many samples of a signal on it (see
surfacesynthesis.read_signal_dataset):

    armadillo_poses.safetensors      poses of the armadillo, simplified to 5,000 triangles that are small where it is
                                     curved: to end a training with
    armadillo_uneven.safetensors     the same poses on a triangulation that is dense on one side: so that a model does not
                                     learn one triangulation
    armadillo_many.safetensors       the same poses on six triangulations, from 1,280 to 8,000 triangles, even, dense where the
                                     surface is curved and dense on one side: so that a model learns none of them
    armadillo_medium.safetensors     the same poses and more, on 1,280 triangles
    armadillo_coarse.safetensors     these, carried to 260 triangles: to begin a training with
    armadillo_test.safetensors       other poses, on a triangulation that is dense on the other side
    armadillo_full_test.safetensors  some of the same poses as in the test file, on the original triangulation
    bent_medium.safetensors          poses of the armadillo whose limbs turn by up to 120 degrees in place of 60, on 1,280
                                     triangles
    bent_coarse.safetensors          these, carried to 260 triangles
    bent_many.safetensors            the same poses on the triangulations of armadillo_many
    bent_test.safetensors            other such poses, on the triangulation of armadillo_test
    bunny_mixtures.safetensors       mixtures on the bunny, remeshed to 4,000 triangles: to end a training with
    bunny_coarse.safetensors         these, carried to 1,000 triangles: to begin a training with
    bunny_test.safetensors           other mixtures, on a triangulation that is coarse on one side

Training samples begin at number 0 and test samples at number 100,000 of the same seed, so that all are different. The
extremities of the armadillo and their joints are found on its original triangulation: sample k is the same pose on all.
Triangulations keep ears, claws and fingers: they are decimated with the least error, or remeshed with shorter edges where the
surface is thin. Numbers of samples and points are options; with the defaults the files are about 470 MB together, and it
takes some twenty-five minutes on two processors, most of it for the original triangulation (--only makes some of it only). The
surfaces come from Debian's package libcgal-demo, or from files.
"""

import argparse
import os
import sys
import tarfile
import tempfile
import time

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import reference
from vtkmodules.vtkCommonDataModel import vtkGenericCell, vtkPolyData, vtkStaticCellLocator
from vtkmodules.vtkFiltersCore import vtkPolyDataNormals, vtkQuadricDecimation

import surfacesynthesis
from carrying import carried
from linear_velocity import triangle_areas

ARCHIVE = "/usr/share/doc/libcgal-demo/data.tar.gz"
FIRST_TEST_SAMPLE = 100000
#: Longest edges of remeshed surfaces in terms of their thickness.
THINNEST = 0.5


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


def decimated(mesh, vertices):
    """The surface with about so many points, more of them where it is curved; not repaired."""
    decimation = vtkQuadricDecimation()
    decimation.SetInputData(mesh)
    decimation.VolumePreservationOn()
    decimation.SetTargetReduction(1.0 - vertices / mesh.GetNumberOfPoints())
    decimation.Update()
    return decimation.GetOutput()


def simplified(mesh, vertices):
    """The surface with about so many points, more of them where it is curved."""
    return in_one_piece(decimated(mesh, vertices))


def remeshed(mesh, vertices, ratio=1.0):
    """The surface with about so many points, and with edges that are ``ratio`` times as long where x is above the middle, but
    nowhere longer than THINNEST times the surface is thick: longer ones tear ears and claws."""
    points, triangles = points_and_triangles(mesh)
    x = points[:, 0]
    edge = np.sqrt(triangle_areas(points, triangles).sum() / vertices)
    lengths = np.where(x > 0.5 * (x.min() + x.max()), ratio, 1.0)
    lengths = numpy_to_vtk(np.minimum(lengths, np.maximum(THINNEST * thickness(mesh) / edge, 0.25)), deep=True)
    lengths.SetName("EdgeLength")
    sized = vtkPolyData()
    sized.ShallowCopy(mesh)
    sized.GetPointData().AddArray(lengths)
    result = surfacesynthesis.remesh(sized, points=vertices, sizing="EdgeLength", feature_angle=None)
    result.GetPointData().RemoveArray("EdgeLength")
    return result


def normals_of(mesh):
    """Normals of the points [V, 3]."""
    normals = vtkPolyDataNormals()
    normals.SetInputData(mesh)
    normals.SplittingOff()
    normals.ConsistencyOff()
    normals.Update()
    return vtk_to_numpy(normals.GetOutput().GetPointData().GetNormals())


def thickness(mesh):
    """The distance of each point from the surface opposite, along its normal."""
    points, _ = points_and_triangles(mesh)
    size = np.ptp(points, axis=0).max()
    found = np.full(len(points), size)
    locator, hit, cell = vtkStaticCellLocator(), [0.0, 0.0, 0.0], vtkGenericCell()
    locator.SetDataSet(mesh)
    locator.BuildLocator()
    for k, normal in enumerate(normals_of(mesh)):
        begin, end = points[k] - 1e-3 * size * normal, points[k] - size * normal
        rest = reference(0.0), hit, [0.0, 0.0, 0.0], reference(0), reference(0), cell
        if locator.IntersectWithLine(begin, end, 0.0, *rest):
            found[k] = np.linalg.norm(hit - points[k])
    return found


def carried_signals(mesh, samples, source, values, positions, **_):
    """Signals, or displacements, of one triangulation at the nearest places on another."""
    points, rest = points_and_triangles(mesh)[0], points_and_triangles(source)
    if not positions:
        return carried(values[:samples].reshape(samples, -1, 1), rest, points)
    return points + carried(values[:samples] - rest[0], rest, points)


def points_and_triangles(mesh):
    points = vtk_to_numpy(mesh.GetPoints().GetData()).astype(float)
    return points, vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3)


class Maker:
    """Writes files into a folder and says what it does."""

    def __init__(self, folder, seed, progress):
        self._folder = folder
        self._seed = seed
        self._progress = progress

    def poses(self, name, mesh, template, samples, first_sample, **options):
        """Returns the poses, [N, V, 3]."""
        made = surfacesynthesis.poses
        return self._write(name, "Position", made, mesh, samples, first_sample, template=template, **options)

    def many_poses(self, name, meshes, template, samples, **options):
        """The same poses on several triangulations, in one file."""
        started = time.monotonic()
        options = {"seed": self._seed, "template": template, "progress": self._show, **options}
        sources = [(mesh, surfacesynthesis.poses(mesh, samples, **options)) for mesh in meshes]
        self._write_sources(name, "Position", sources, started)

    def mixtures(self, name, mesh, samples, first_sample):
        """Returns the mixtures, [N, V]."""
        return self._write(name, "Mixture", surfacesynthesis.gaussian_mixtures, mesh, samples, first_sample)

    def carried(self, name, mesh, source, values, signal="Position"):
        """Samples of another triangulation, ``source``."""
        options = {"source": source, "values": values, "positions": signal == "Position"}
        self._write(name, signal, carried_signals, mesh, len(values), 0, **options)

    def _write(self, name, signal, make, mesh, samples, first_sample, **options):
        started = time.monotonic()
        values = make(mesh, samples, seed=self._seed, first_sample=first_sample, progress=self._show, **options)
        self._write_sources(name, signal, [(mesh, values)], started)
        return values

    def _write_sources(self, name, signal, sources, started):
        path = os.path.join(self._folder, name)
        surfacesynthesis.write_signal_dataset(path, sources, signal)
        points = ", ".join(f"{mesh.GetNumberOfPoints():,}" for mesh, _ in sources)
        seconds = time.monotonic() - started
        print(f"\r{len(sources[0][1]):,} samples on {points} points, {seconds:.0f} s -> {path}", flush=True)

    def _show(self, fraction):
        if self._progress:
            print(f"\r{100 * fraction:3.0f} %", end="", flush=True)


def parsed(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", help="where to write; made when it is not there")
    parser.add_argument("--only", nargs="+", choices=DATA, default=list(DATA), help="default: all")
    parser.add_argument("--seed", type=int, default=0, help="default: 0")
    parser.add_argument("--armadillo", metavar="FILE", help="a surface to pose instead")
    parser.add_argument("--bunny", metavar="FILE", help="a surface for mixtures instead")
    parser.add_argument("--poses", type=int, default=2500, metavar="N", help="poses to train with (default: 2500)")
    parser.add_argument("--coarse-poses", type=int, default=6000, metavar="N", help="on few triangles (default: 6000)")
    parser.add_argument("--many-poses", type=int, default=600, metavar="N", help="on each of many (default: 600)")
    parser.add_argument("--test-poses", type=int, default=300, metavar="N", help="poses to test with (default: 300)")
    parser.add_argument("--full-poses", type=int, default=100, metavar="N", help="on the original (default: 100)")
    parser.add_argument("--mixtures", type=int, default=6000, metavar="N", help="mixtures to train with (default: 6000)")
    parser.add_argument("--test-mixtures", type=int, default=500, metavar="N", help="to test with (default: 500)")
    parser.add_argument("--pose-vertices", type=int, default=2500, metavar="V", help="to train with (default: 2500)")
    parser.add_argument("--uneven-pose-vertices", type=int, default=3000, metavar="V", help="default: 3000")
    parser.add_argument("--coarse-pose-vertices", type=int, nargs=2, default=[642, 130], metavar="V",
                        help="of medium and coarse poses (default: 642 130)")  # fmt: skip
    parser.add_argument("--mixture-vertices", type=int, default=2000, metavar="V", help="to train with (default: 2000)")
    parser.add_argument("--coarse-mixture-vertices", type=int, default=500, metavar="V", help="default: 500")
    parser.add_argument("--test-vertices", type=int, default=5000, metavar="V", help="to test with (default: 5000)")
    parser.add_argument("--ratio", type=float, default=2.0, help="of edge lengths in uneven triangulations (default: 2)")
    parser.add_argument("--angle", type=float, default=120.0, help="largest of bent poses, in degrees (default: 120)")
    return parser.parse_args(arguments)


def make_mixtures(options, make):
    bunny = surface(options.bunny, "bunny00.off")
    fine, coarse = remeshed(bunny, options.mixture_vertices), simplified(bunny, options.coarse_mixture_vertices)
    values = make.mixtures("bunny_mixtures.safetensors", fine, options.mixtures, 0)
    make.carried("bunny_coarse.safetensors", coarse, fine, values, "Mixture")
    uneven = remeshed(bunny, options.test_vertices, options.ratio)
    make.mixtures("bunny_test.safetensors", uneven, options.test_mixtures, FIRST_TEST_SAMPLE)


def make_poses(options, make):
    armadillo = surface(options.armadillo, "armadillo.off")
    simple = simplified(armadillo, options.pose_vertices)
    make.poses("armadillo_poses.safetensors", simple, armadillo, options.poses, 0)
    uneven = remeshed(armadillo, options.uneven_pose_vertices, 1.0 / options.ratio)
    make.poses("armadillo_uneven.safetensors", uneven, armadillo, options.poses, 0)
    make_coarse_and_uneven(options, make, armadillo, "armadillo", 60.0)
    make.many_poses("armadillo_many.safetensors", triangulations(options, armadillo), armadillo, options.many_poses)
    make.poses("armadillo_full_test.safetensors", armadillo, armadillo, options.full_poses, FIRST_TEST_SAMPLE)


def make_bent(options, make):
    armadillo = surface(options.armadillo, "armadillo.off")
    make_coarse_and_uneven(options, make, armadillo, "bent", options.angle)
    many = triangulations(options, armadillo)
    make.many_poses("bent_many.safetensors", many, armadillo, options.many_poses, maximum_angle=options.angle)


def triangulations(options, surface):
    """Six of them, none dense on the side on which those of the test files are."""
    count, dense = options.pose_vertices, 1.0 / options.ratio
    simple = [simplified(surface, vertices) for vertices in (options.coarse_pose_vertices[0], count)]
    few, more = round(0.6 * count), round(1.6 * count)
    sizes = (few, 1.0), (more, 1.0), (few, dense), (options.uneven_pose_vertices, dense)
    return simple + [remeshed(surface, *size) for size in sizes]


def make_coarse_and_uneven(options, make, surface, name, angle):
    medium, coarse = (simplified(surface, count) for count in options.coarse_pose_vertices)
    poses = make.poses(f"{name}_medium.safetensors", medium, surface, options.coarse_poses, 0, maximum_angle=angle)
    make.carried(f"{name}_coarse.safetensors", coarse, medium, poses)
    uneven = remeshed(surface, options.test_vertices, options.ratio)
    number = options.test_poses
    make.poses(f"{name}_test.safetensors", uneven, surface, number, FIRST_TEST_SAMPLE, maximum_angle=angle)


#: What makes files, by the name of --only.
DATA = {"mixtures": make_mixtures, "poses": make_poses, "bent": make_bent}


def main(arguments=None):
    options = parsed(arguments)
    os.makedirs(options.folder, exist_ok=True)
    make = Maker(options.folder, options.seed, sys.stdout.isatty())
    for name in options.only:
        DATA[name](options, make)


if __name__ == "__main__":
    main()
