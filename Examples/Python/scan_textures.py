#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of textures of scans on other surfaces: pieces of scans as examples of geometric_texture_from_example().

    xvfb-run -a python3 scan_textures.py --output DIR
    python3 scan_textures.py --write DIR
    python3 scan_textures.py --examples DIR
    python3 scan_textures.py --distances
    xvfb-run -a python3 scan_textures.py --output DIR --scan FILE --center X Y Z --radius R --smoothing-length L

The textures: folds of a cortex, curls of a guardian lion's mane, ridges of a landscape, twice as high as they are, scales on the
armadillo's shin and fur of the bunny. Pieces are cut on this machine, from Debian's packages libcgal-demo, mricron-data and
python3-matplotlib. CROPS is the table of them.
Writes

    scan_textures.png           rows: textures; columns: the scan, the piece of it, and that texture on a sphere, a bear and a
                                knot. The piece and the targets are drawn at one scale
    scan_texture_*_TARGET.vtp   the surfaces, with displacements

and with --write only the pieces, as scan_NAME.vtp, and a line for each: the command that grows its texture on a surface.
--examples writes those whose license is free, or that of --scan, as example files, NAME.safetensors, as in Examples/Models.
--distances prints how far syntheses, another piece of the scan and bare targets are from the piece. --scan takes the piece from
a file of one's own.
"""

import argparse
import json
import os
import sys
from typing import NamedTuple, Optional

import gallery_rendering as rendering
import numpy as np
import surfacesynthesis
from surfacesynthesis.datasets import given_dataset
from surfacesynthesis.safetensors import write_safetensors
from textures_from_example import add_vectors, piece_of, points_of, synthesized
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkRenderingCore import vtkColorTransferFunction

EXAMPLES = os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir)
sys.path.insert(0, os.path.join(EXAMPLES, "Training"))

from make_datasets import in_one_piece, surface  # noqa: E402

BRAIN = "/usr/share/mricron/templates/ch2bet.nii.gz"  # Debian's package mricron-data
#: Isovalue between cortex and what surrounds it.
CORTEX = 50
#: Heights of a landscape above the sea, meters, from Debian's package python3-matplotlib; and what they are multiplied with.
LANDSCAPE = "/usr/share/matplotlib/mpl-data/sample_data/jacksboro_fault_dem.npz"
HEIGHTS = 2.0
#: Meters for a degree of latitude.
DEGREE = 111.2e3
SIZE = (420, 420)
#: Height of a picture of a target over the height of the target.
MARGIN = 1.12
#: Rings of vertices that --distances compares: a triangle, its surroundings, and about a feature.
RINGS = (1, 3, 6)
#: Color of the border of the piece on the scan.
MARKED = (0.15, 0.35, 0.75)


class Crop(NamedTuple):
    """A piece of a scan: an example. Lengths are in the units of the scan."""

    #: "brain", "landscape", the name of a surface in libcgal-demo, or a file.
    scan: str
    #: The ball that the piece lies in: the point of the scan closest to this, and the radius.
    center: tuple
    radius: float
    #: Points of the piece, once remeshed: about 8 edges for each feature.
    points: int
    #: About the width of a feature, or the distance to the next.
    smoothing_length: Optional[float]
    #: Along the rows of the texture; None for a texture without a direction.
    direction: Optional[tuple] = None
    #: Center of another piece, which --distances compares with this one.
    other: Optional[tuple] = None
    #: Where the scan comes from, and its license as that package states it; None for one that is not free.
    origin: Optional[tuple] = None


#: Scans with a texture.
CROPS = {
    "cortex": Crop(
        "brain", (60.0, -15.0, 45.0), 50.0, 6500, 16.0, other=(-60.0, -15.0, 45.0),
        origin=("Debian's mricron-data, templates/ch2bet.nii.gz, surface of isovalue 50", "BSD-3-Clause, Copyright 2006-2010 Chris Rorden"),
    ),  # fmt: skip
    "mane": Crop(
        "ChineseDragon-10kv", (-3.0, 46.0, -978.0), 21.0, 2500, 9.0, direction=(1.0, 0.0, 0.0), other=(-2.0, 59.0, -959.0),
        origin=("Debian's libcgal-demo, data/meshes/ChineseDragon-10kv.off", "CC0-1.0"),
    ),  # fmt: skip
    "mountains": Crop(
        "landscape", (6500.0, 14000.0, 1000.0), 6000.0, 4200, 1200.0, other=(8500.0, 5200.0, 1000.0),
        origin=("Debian's python-matplotlib-data, jacksboro_fault_dem.npz, heights doubled", "Matplotlib license, Copyright 2002-2016 Matplotlib"),
    ),  # fmt: skip
    "scales": Crop("armadillo", (27.0, -28.0, 3.0), 9.0, 1800, 3.5, other=(-27.0, -28.0, 3.0)),
    "fur": Crop("bunny00", (0.1, -0.22, 0.4), 0.16, 1700, 0.08, other=(0.1, 0.02, 0.36)),
}


class Target(NamedTuple):
    """A surface that textures grow on."""

    #: The direction that it is seen from.
    view: tuple
    #: The direction that rows of a texture lie along.
    direction: tuple = (1.0, 0.0, 0.0)


TARGETS = {
    "sphere": Target((0.3, 0.3, 1.0)),
    "bear": Target((0.3, 0.2, 1.0)),
    "knot1": Target((0.1, 0.2, 1.0)),
}


def landscape():
    """Squares of the measured heights, two triangles each: x to the east, y to the north, z up, meters."""
    data = np.load(LANDSCAPE)
    heights = data["elevation"].astype(float)[::-1]
    to_east = float(data["dx"]) * DEGREE * np.cos(np.deg2rad(0.5 * float(data["ymin"] + data["ymax"])))
    rows, columns = heights.shape
    x, y = np.meshgrid(to_east * np.arange(columns), float(data["dy"]) * DEGREE * np.arange(rows))
    first = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()[:, None]
    triangles = np.concatenate([first + (0, 1, columns + 1), first + (0, columns + 1, columns)])
    return given_dataset((np.stack([x, y, HEIGHTS * heights], axis=-1).reshape(-1, 3), triangles))


def scan_of(crop):
    """The scan of a crop, in one piece."""
    if crop.scan == "landscape":
        return landscape()
    if crop.scan == "brain":
        volume = surfacesynthesis.read_volume(BRAIN)
        smooth = {"smoothing": "mean_curvature", "smoothing_iterations": 2}
        return surfacesynthesis.vdb_surface(
            volume, iso_value=CORTEX, fill_cavities=True, largest_component=True, **smooth
        )
    if os.path.isfile(crop.scan):
        return in_one_piece(surfacesynthesis.read_mesh(crop.scan))
    return surface(None, crop.scan + ".off")


def nearest_point(scan, place):
    points = points_of(scan)
    return points[np.linalg.norm(points - np.asarray(place, dtype=float), axis=1).argmin()]


def example_of(crop, scan, center=None):
    """The piece of a scan, remeshed with even triangles, and the arguments of geometric_texture_from_example()."""
    piece = piece_of(scan, nearest_point(scan, crop.center if center is None else center), crop.radius)
    example = surfacesynthesis.remesh(piece, points=crop.points, feature_angle=None)
    parameters = {} if crop.smoothing_length is None else {"smoothing_length": crop.smoothing_length}
    if crop.direction is not None:
        add_vectors(example, "Growth", crop.direction)
        parameters.update(orientation="Growth", example_orientation="Growth")
    return example, parameters


def edge_length(mesh):
    return surfacesynthesis.topology_report(mesh)["edge_length_mean"]


def bare_surface(name):
    """A target as it comes: a sphere, or a surface of libcgal-demo."""
    if name != "sphere":
        return surface(None, name + ".off")
    source = vtkSphereSource()
    source.SetRadius(1.0)
    source.SetThetaResolution(256)
    source.SetPhiResolution(128)
    source.Update()
    return source.GetOutput()


def target_of(name, resolution):
    """A target with ``resolution`` edges in the height of its picture, and the view of it.

    Triangles of targets stand for triangles of examples, so that one texture is as large in the pictures of all targets.
    """
    bare = bare_surface(name)
    view = rendering.view_of(bare, SIZE[0] / SIZE[1], TARGETS[name].view, MARGIN)
    target = surfacesynthesis.remesh(bare, edge_length=view.height / resolution, feature_angle=None)
    if name == "sphere":
        points = points_of(target)
        target.GetPoints().SetData(numpy_to_vtk(points / np.linalg.norm(points, axis=1, keepdims=True), deep=True))
    add_vectors(target, "Growth", TARGETS[name].direction)
    return target, view


def mean_normal(mesh):
    points = points_of(mesh)
    a, b, c = points[vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3)].transpose(1, 0, 2)
    normal = np.cross(b - a, c - a).sum(axis=0)
    return normal / np.linalg.norm(normal)


def add_scan(sheet, row, name, crop, scan):
    """The scan with the border of the piece marked. Returns the direction that the piece faces."""
    center = nearest_point(scan, crop.center)
    array = numpy_to_vtk(np.linalg.norm(points_of(scan) - center, axis=1) / crop.radius, deep=True)
    array.SetName("Distance")
    marked = vtkPolyData()
    marked.ShallowCopy(scan)
    marked.GetPointData().AddArray(array)
    colors = vtkColorTransferFunction()
    for distance, color in ((0.9, rendering.CLAY), (0.95, MARKED), (1.03, MARKED), (1.08, rendering.CLAY)):
        colors.AddRGBPoint(distance, *color)
    facing = mean_normal(piece_of(scan, center, crop.radius))
    view = rendering.view_of(scan, SIZE[0] / SIZE[1], facing)
    title = f"{name}\n{os.path.basename(crop.scan)}, {scan.GetNumberOfCells():,} faces"
    sheet.add(row, 0, title, marked, view, array="Distance", colors=colors)
    return facing


def add_row(sheet, row, name, crop, targets, options):
    scan = scan_of(crop)
    example, parameters = example_of(crop, scan)
    facing = add_scan(sheet, row, name, crop, scan)
    whole = rendering.view_of(example, SIZE[0] / SIZE[1], facing)
    height = options.resolution * edge_length(example)
    title = f"the piece\n{example.GetNumberOfCells():,} faces"
    sheet.add(row, 1, title, example, whole.zoomed(whole.center, height))
    for column, (target_name, (target, view)) in enumerate(targets.items(), 2):
        output, seconds = synthesized(target, example, seed=options.seed, subdivisions=0, **parameters)
        mismatch = vtk_to_numpy(output.GetFieldData().GetArray("Mismatch"))[0]
        faces = f"{output.GetNumberOfCells():,} faces"
        print(f"{name} on {target_name}, {faces}: {seconds:.1f} s, mismatch {mismatch:.3f}", flush=True)
        sheet.add(row, column, f"{target_name}\n{faces}", output, view)
        surfacesynthesis.write_mesh(output, os.path.join(options.output, f"scan_texture_{name}_{target_name}.vtp"))


def write_pictures(crops, options):
    os.makedirs(options.output, exist_ok=True)
    targets = {name: target_of(name, options.resolution) for name in options.targets}
    sheet = rendering.Sheet(len(crops), 2 + len(targets), SIZE)
    for row, (name, crop) in enumerate(crops.items()):
        add_row(sheet, row, name, crop, targets, options)
    sheet.write(os.path.join(options.output, "scan_textures.png"), options.colors)


def write_examples(crops, folder):
    """Pieces as files, for the command geometric-texture-from-example and for ParaView."""
    os.makedirs(folder, exist_ok=True)
    for name, crop in crops.items():
        example, parameters = example_of(crop, scan_of(crop))
        path = os.path.join(folder, f"scan_{name}.vtp")
        surfacesynthesis.write_mesh(example, path)
        words = [f"--{keyword.replace('_', '-')} {value}" for keyword, value in parameters.items()]
        print(" ".join(["geometric-texture-from-example", "TARGET", path, "OUTPUT", *words]), flush=True)


def free_crops(crops):
    """Those whose pieces may be given away."""
    free = {name: crop for name, crop in crops.items() if crop.origin is not None}
    if not free:
        raise SystemExit(f"none of {', '.join(crops)} may be given away; --write makes files for own use")
    return free


def write_example_files(crops, folder):
    """Pieces as files that geometric_texture_from_example() takes."""
    os.makedirs(folder, exist_ok=True)
    for name, crop in crops.items():
        example, parameters = example_of(crop, scan_of(crop))
        triangles = vtk_to_numpy(example.GetPolys().GetConnectivityArray()).reshape(-1, 3)
        tensors = {"points": points_of(example), "triangles": triangles}
        if crop.direction is not None:
            tensors["directions"] = vtk_to_numpy(example.GetPointData().GetArray(parameters["example_orientation"]))
        described = {"name": name, "smoothing_length": crop.smoothing_length}
        texts = {"architecture": "geometric_texture_example", "format_version": "1"}
        texts["geometric_texture_example"] = json.dumps(described)
        if crop.origin is not None:
            texts["origin"], texts["license"] = crop.origin
        path = os.path.join(folder, f"{name}.safetensors")
        write_safetensors(path, tensors, texts)
        print(f"wrote {path}: {example.GetNumberOfCells():,} triangles", flush=True)


def evenly_remeshed(mesh, length):
    """The surface with triangles whose mean edge is ``length`` to one per cent: distances see the size of triangles."""
    asked = length
    for _ in range(5):
        even = surfacesynthesis.remesh(mesh, edge_length=asked, feature_angle=None)
        found = edge_length(even)
        if abs(found / length - 1.0) < 0.01:
            break
        asked *= length / found
    return even


def inner_part(piece, crop, center=None):
    """The part of a piece that its patches lie in: beyond the smoothing length from the border."""
    margin = 0.0 if crop.smoothing_length is None else crop.smoothing_length
    return piece_of(piece, nearest_point(piece, crop.center if center is None else center), crop.radius - margin)


def print_distances(crops, options):
    """A table in units of edges of pieces: geometric_texture_distance() from the inner part of the piece."""
    print(f"{'texture':<10}{'target':<10}{'rings':<7}{'another piece':>14}{'synthesis':>11}{'deviation':>11}"
          f"{'bare target':>13}{'ratio':>8}")
    targets = {name: target_of(name, options.resolution)[0] for name in options.targets}
    for name, crop in crops.items():
        scan = scan_of(crop)
        example, parameters = example_of(crop, scan)
        unit = edge_length(example)
        reference = evenly_remeshed(inner_part(example, crop), unit)

        def distances(mesh, scale, reference=reference, unit=unit):
            """Distances, by rings, of a surface that is ``scale`` times as large as the scan."""
            even = evenly_remeshed(mesh, scale * unit)
            lengths = {"unit_length": scale * unit, "reference_unit_length": unit}
            return np.array(
                [surfacesynthesis.geometric_texture_distance(even, reference, rings=rings, **lengths) for rings in RINGS]
            )

        floor = np.full(len(RINGS), np.nan)
        if crop.other is not None:
            floor = distances(inner_part(example_of(crop, scan, crop.other)[0], crop, crop.other), 1.0)
        for target_name, target in targets.items():
            found = []
            for seed in range(options.seed, options.seed + options.seeds):
                output, _ = synthesized(target, example, seed=seed, subdivisions=0, **parameters)
                scale = vtk_to_numpy(output.GetFieldData().GetArray("TextureScale"))[0]
                found.append(distances(output, scale))
            mean, deviation = np.mean(found, axis=0), np.std(found, axis=0)
            bare = distances(target, scale)
            for k, rings in enumerate(RINGS):
                ratio = (mean[k] - floor[k]) / (bare[k] - floor[k])
                values = f"{floor[k]:14.3f}{mean[k]:11.3f}{deviation[k]:11.3f}{bare[k]:13.3f}{ratio:8.2f}"
                print(f"{name:<10}{target_name:<10}{rings:<7}{values}", flush=True)


def own_crop(options):
    """A piece of a file, from the command line."""
    missing = [word for word in ("center", "radius") if getattr(options, word) is None]
    if options.examples is not None and options.smoothing_length is None:
        missing.append("smoothing-length")
    if missing:
        raise SystemExit(f"--scan needs --{' and --'.join(missing)}")
    direction = None if options.direction is None else tuple(options.direction)
    return {
        os.path.splitext(os.path.basename(options.scan))[0]: Crop(
            options.scan, tuple(options.center), options.radius, options.points, options.smoothing_length, direction
        )
    }


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    work = parser.add_mutually_exclusive_group()
    work.add_argument("--write", metavar="DIR", help="write the pieces only, as files, and print commands")
    work.add_argument("--examples", metavar="DIR", help="write the free pieces, or that of --scan, as example files only")
    work.add_argument("--distances", action="store_true", help="print a table of distances only")
    parser.add_argument("--output", metavar="DIR", help="folder of the picture and the surfaces")
    parser.add_argument("--seed", type=int, default=1, help="default: 1")
    parser.add_argument("--seeds", type=int, default=1, help="number of seeds of --distances (default: 1)")
    parser.add_argument("--resolution", type=int, default=120, help="edges in the height of a picture (default: 120)")
    parser.add_argument("--only", nargs="+", choices=CROPS, default=list(CROPS), help="of the textures (default: all)")
    parser.add_argument("--targets", nargs="+", choices=TARGETS, default=list(TARGETS), help="default: all")
    parser.add_argument("--colors", type=int, metavar="N", help="write PNGs with a palette of so few colours (needs PIL)")
    own = parser.add_argument_group("a scan of one's own")
    own.add_argument("--scan", metavar="FILE", help="surface in place of those of the table")
    own.add_argument("--center", nargs=3, type=float, metavar=("X", "Y", "Z"), help="of the piece, units of the scan")
    own.add_argument("--radius", type=float, help="of the piece, units of the scan: 2 to 4 features")
    own.add_argument("--points", type=int, default=4000, help="of the piece, about 8 edges for a feature (default: 4000)")
    own.add_argument("--smoothing-length", type=float, help="about the width of a feature, units of the scan")
    own.add_argument("--direction", nargs=3, type=float, metavar=("X", "Y", "Z"), help="of the texture")
    options = parser.parse_args()
    if options.write is None and options.examples is None and not options.distances and options.output is None:
        parser.error("one of --output, --write, --examples and --distances is required")
    return options


def main():
    options = arguments()
    crops = {name: CROPS[name] for name in options.only} if options.scan is None else own_crop(options)
    if options.write is not None:
        write_examples(crops, options.write)
    elif options.examples is not None:
        write_example_files(free_crops(crops) if options.scan is None else crops, options.examples)
    elif options.distances:
        print_distances(crops, options)
    else:
        write_pictures(crops, options)


if __name__ == "__main__":
    main()
