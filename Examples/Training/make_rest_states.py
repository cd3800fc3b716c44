#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Makes data for flow matching on rest states of a soft body, on several triangulations at once.

    python3 make_rest_states.py SURFACE FOLDER [options], such as --name armadillo --drops 2000 --up 0 1 0

The body is filled with tetrahedra and dropped; the points of all triangulations follow in the same drops. Written are

    NAME_tetrahedra.vtu         the tetrahedra: for rest_space.py --tetrahedra
    NAME_rest.safetensors       rest states on seven triangulations, from about a third to twice --points: to train with
    NAME_rest_test.safetensors  other drops on the first of them

and parts of the drops in FOLDER/NAME_parts, from which a run that was stopped goes on. A part says what it was made of in its name,
and is made again where that has changed.
"""

import argparse
import hashlib
import os
import time

import numpy as np

import surfacesynthesis
from make_datasets import FIRST_TEST_SAMPLE, in_one_piece, points_and_triangles, remeshed, simplified

#: Drops of a part.
PART = 25
#: Points of a surface.
FEWEST = 20
#: Triangulations besides the first: points over --points, and edge lengths on one side over those on the other; 0 stands for a
#: simplified surface, which has more points where it is curved.
TRIANGULATIONS = ((1.25, 0.0), (1.5, 0.5), (0.33, 0.0), (0.75, 1.0), (2.0, 1.0), (0.75, 0.5))


class Body:
    """Tetrahedra of a surface, and triangulations of it whose points follow them."""

    def __init__(self, surface, options):
        self.tetrahedra = tetrahedra_of(surface, options.surface_points)
        sizes = [(1.0, 1.0), *TRIANGULATIONS]
        self.meshes = [points_and_triangles(triangulated(surface, share * options.points, ratio)) for share, ratio in sizes]
        self._ends = np.cumsum([0] + [len(points) for points, _ in self.meshes])

    def together(self, number):
        """The first ``number`` triangulations as one mesh."""
        triangles = [triangles + begin for (_, triangles), begin in zip(self.meshes[:number], self._ends)]
        return np.concatenate([points for points, _ in self.meshes[:number]]), np.concatenate(triangles)

    def parted(self, states, number):
        """Triangulations with their rest states, of those of together()."""
        return [(mesh, states[:, begin:end]) for mesh, begin, end in zip(self.meshes[:number], self._ends, self._ends[1:])]

    def digest(self):
        """A few characters that change with the tetrahedra or a triangulation."""
        found = hashlib.sha256(points_of(self.tetrahedra).tobytes())
        for points, triangles in self.meshes:
            found.update(points.tobytes())
            found.update(triangles.tobytes())
        return found.hexdigest()[:12]


def points_of(mesh):
    return np.array([mesh.GetPoint(k) for k in range(mesh.GetNumberOfPoints())])


def triangulated(surface, points, ratio):
    points = round(points)
    if ratio == 0.0:
        return simplified(surface, points) if points < surface.GetNumberOfPoints() else surface
    return remeshed(surface, points, ratio)


def tetrahedra_of(surface, surface_points):
    """Tetrahedra in the surface, evenly remeshed to about so many points, with edges of about the length of its own."""
    coarse = surfacesynthesis.remesh(surface, points=surface_points, feature_angle=None)
    points, triangles = points_and_triangles(coarse)
    sides = np.concatenate([points[triangles[:, k]] - points[triangles[:, k - 2]] for k in range(3)])
    return surfacesynthesis.tetrahedralize(coarse, edge_length=float(np.linalg.norm(sides, axis=1).mean()))


def dropped(body, meshes, first, count, folder, up):
    """Rest states [count, V, 3] of the first ``meshes`` triangulations, float32, by parts."""
    mesh, parts, digest = body.together(meshes), [], body.digest()
    started, made = time.monotonic(), 0
    for begin in range(first, first + count, PART):
        number = min(PART, first + count - begin)
        name = f"{digest}_{'_'.join(f'{x:g}' for x in up)}_{meshes}_{begin}_{number}.npy"
        path = os.path.join(folder, name)
        if not os.path.exists(path):
            states = surfacesynthesis.rest_states(
                mesh, samples=number, first_sample=begin, tetrahedra=body.tetrahedra, up_direction=up
            ).astype(np.float32)
            with open(path + ".part", "wb") as file:
                np.save(file, states)
            os.replace(path + ".part", path)
            made += number
            seconds = (time.monotonic() - started) / made
            print(f"{begin + number - first} of {count} drops, {seconds:.1f} s each", flush=True)
        parts.append(np.load(path))
    return np.concatenate(parts)


def parsed(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("surface", help="a closed surface")
    parser.add_argument("folder", help="where to write; made when it is not there")
    parser.add_argument("--name", default="body", help="of the files (default: body)")
    parser.add_argument("--drops", type=int, default=1500, metavar="N", help="to train with (default: 1500)")
    parser.add_argument("--test-drops", type=int, default=100, metavar="N", help="to test with (default: 100)")
    parser.add_argument("--points", type=int, default=2000, metavar="V", help="of the first triangulation (default: 2000)")
    parser.add_argument("--surface-points", type=int, default=350, metavar="V", help="of the simulated surface (default: 350)")
    parser.add_argument("--up", type=float, nargs=3, default=[0.0, 0.0, 1.0], metavar="X", help="upwards (default: 0 0 1)")
    options = parser.parse_args(arguments)
    if min(options.drops, options.test_drops) < 1:
        parser.error("--drops and --test-drops must be at least 1")
    if min(options.points, options.surface_points) < FEWEST:
        parser.error(f"--points and --surface-points must be at least {FEWEST}")
    if not any(options.up):
        parser.error("--up must be a direction")
    return options


def main(arguments=None):
    options = parsed(arguments)
    parts = os.path.join(options.folder, options.name + "_parts")
    os.makedirs(parts, exist_ok=True)
    body = Body(in_one_piece(surfacesynthesis.read_mesh(options.surface)), options)
    path = os.path.join(options.folder, options.name)
    surfacesynthesis.write_mesh(body.tetrahedra, path + "_tetrahedra.vtu")
    counts = body.tetrahedra.GetNumberOfPoints(), body.tetrahedra.GetNumberOfCells()
    print("{:,} nodes, {:,} tetrahedra; triangulations of {} points".format(
        *counts, ", ".join(f"{len(points):,}" for points, _ in body.meshes)), flush=True)  # fmt: skip
    for suffix, meshes, first, count in (
        ("_rest", len(body.meshes), 0, options.drops),
        ("_rest_test", 1, FIRST_TEST_SAMPLE, options.test_drops),
    ):
        states = dropped(body, meshes, first, count, parts, options.up)
        origin = f"elastic rest states of {os.path.basename(options.surface)}"
        surfacesynthesis.write_signal_dataset(path + suffix + ".safetensors", body.parted(states, meshes), "Position", origin)
        print(f"{count:,} drops -> {path + suffix}.safetensors", flush=True)


if __name__ == "__main__":
    main()
