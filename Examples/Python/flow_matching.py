#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of the data that the example models of flow matching were trained with, and of what they generate.

    xvfb-run -a python3 flow_matching.py --output DIR [--training DATASET]

The models (Examples/Models) were trained on one triangulation of each shape: poses of the armadillo, simplified to 2,500
vertices, and signals of three Gaussians on the bunny with 2,000. Writes

    poses.png           data: the same random poses on the triangulation of the training and on the original one
    mixtures.png        data: random signals of three Gaussians
    deformations.png    rows: a sample on the original triangulation, with 52,000 faces, and, from the same noise, on that
                        one subdivided, with 208,000, and on an even one with 3,000; four seeds on the original; with
                        --training, samples beside the closest pose of the training
    signals.png         samples on the original triangulation, with 75,000 faces, and, from the same noise, on an even one and
                        on one that is coarse on one side
    rest_samples.png    rows: the bunny, with 75,000 faces, and the armadillo, with 52,000: four samples of the models of rest
                        states, which were trained on 4,000 faces, lowered onto a floor; below, the rest states next to them
    humanoid.png        rows: two triangulations; four samples of the model of 200 human bodies (Examples/Training) on the armadillo
    deformation_*.vtp   the deformed surfaces, with arrays

and prints how long each took, a table of times over the number of triangles (--only times), and one of the sharpness of signals
(--only peaks). --training names the file
armadillo_poses.safetensors that Examples/Training/make_datasets.py writes. Surfaces come from Debian's package
libcgal-demo.
"""

import argparse
import os
import sys
import time

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkFiltersModeling import vtkLinearSubdivisionFilter

import gallery_rendering as rendering
import rest_states
import surfacesynthesis
from surfacesynthesis.datasets import dataset_of_pair

EXAMPLES = os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir)
sys.path.insert(0, os.path.join(EXAMPLES, "Training"))

from carrying import carried  # noqa: E402
from make_datasets import points_and_triangles, remeshed, simplified, surface  # noqa: E402

MODELS = os.path.join(EXAMPLES, "Models")
FRONT = (0.16, 0.08, -1.0)
BUNNY = (0.1, 0.2, 1.0)
SIZE = (420, 470)
SEEDS = (1, 2, 3, 4)
#: The model of many bodies, beside the folder of the shipped ones.
BODIES = os.path.join(os.pardir, "Training", "bodies")
MIXTURE = rendering.sequential(0.0, 1.0)


def subdivided(mesh):
    """Each triangle cut into four."""
    finer = vtkLinearSubdivisionFilter()
    finer.SetInputData(mesh)
    finer.Update()
    return finer.GetOutput()


def made(mesh, model, **parameters):
    """A deformed surface, and the seconds it took."""
    started = time.monotonic()
    output = surfacesynthesis.deform(mesh, model, **parameters)
    return output, time.monotonic() - started


def with_noise_of(sample, mesh):
    """A copy of a surface, or of another triangulation of it, with the noise that a sample was made of."""
    copy = vtkPolyData()
    copy.CopyStructure(mesh)
    noise = vtk_to_numpy(sample.GetPointData().GetArray("InitialNoise"))
    if mesh.GetNumberOfPoints() != len(noise):
        points, triangles = points_and_triangles(sample)
        noise = carried(noise.reshape(1, len(points), -1), (points, triangles), points_and_triangles(mesh)[0])[0]
    array = numpy_to_vtk(np.ascontiguousarray(noise), deep=True)
    array.SetName("InitialNoise")
    copy.GetPointData().AddArray(array)
    return copy


def faces(mesh):
    return f"{mesh.GetNumberOfCells():,} faces"


def surface_area(mesh):
    a, b, c = (mesh[0][mesh[1][:, k]] for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()


def closest_pose(points, source, poses):
    """The pose of the training [V, 3] that is closest to a sample on its triangulation, and the mean distance."""
    metrics = surfacesynthesis.ensemble_metrics(points[None], poses, source=source, remove_centroid=True)
    pose = poses[metrics.nearest_reference[0]].astype(float)
    return pose - pose.mean(axis=0) + points.mean(axis=0), metrics.distances[0]


def training_poses(options):
    original = surface(None, "armadillo.off")
    sheet = rendering.Sheet(2, len(SEEDS), SIZE)
    view = rendering.view_of(original, SIZE[0] / SIZE[1], FRONT, margin=1.35)
    for row, mesh in enumerate((simplified(original, 1500), original)):
        blocks = surfacesynthesis.poses(mesh, len(SEEDS), template=original)
        for column in range(len(SEEDS)):
            posed = warped_to(mesh, blocks[column])
            sheet.add(row, column, f"pose {column}, {faces(mesh)}", posed, view)
    sheet.write(os.path.join(options.output, "poses.png"), options.colors)


def training_mixtures(options):
    mesh = remeshed(surface(None, "bunny00.off"), 2000)
    values = surfacesynthesis.gaussian_mixtures(mesh, len(SEEDS))
    sheet = rendering.Sheet(1, len(SEEDS), SIZE)
    view = rendering.view_of(mesh, SIZE[0] / SIZE[1], BUNNY)
    for column in range(len(SEEDS)):
        with_array(mesh, values[column])
        sheet.add(0, column, f"mixture {column}, {faces(mesh)}", mesh, view, array="Mixture", colors=MIXTURE)
    sheet.write(os.path.join(options.output, "mixtures.png"), options.colors)


def warped_to(mesh, points):
    """A copy of a surface with other points."""
    copy = vtkPolyData()
    copy.ShallowCopy(mesh)
    moved = vtkPoints()
    moved.SetData(numpy_to_vtk(np.ascontiguousarray(points, dtype=float), deep=True))
    copy.SetPoints(moved)
    return copy


def with_array(mesh, values):
    array = numpy_to_vtk(values, deep=True)
    array.SetName("Mixture")
    mesh.GetPointData().AddArray(array)


def deformations(options):
    model = os.path.join(options.models, "armadillo_poses.safetensors")
    original = surface(None, "armadillo.off")
    view = rendering.view_of(original, SIZE[0] / SIZE[1], FRONT, margin=1.35)
    sheet = rendering.Sheet(3 if options.training else 2, 4, SIZE)
    sheet.add(0, 0, f"the source\n{faces(original)}", original, view)
    triangulations(options, model, original, sheet, view)
    for column, seed in enumerate(SEEDS):
        output, _ = made(original, model, seed=seed, steps=options.steps)
        sheet.add(1, column, f"seed {seed}", output, view)
    if options.training:
        (data,) = surfacesynthesis.read_signal_dataset(options.training).sources
        source, poses = (data.points, data.triangles), data.signals
        area = surface_area(source)
        for pair, seed in enumerate(SEEDS[:2]):
            sample, _ = made(source, model, seed=seed, steps=options.steps)
            closest, distance = closest_pose(sample, source, poses)
            text = f"closest of {len(poses):,} training poses\nmean distance {distance / np.sqrt(area):.2g} sqrt(area)"
            sheet.add(2, 2 * pair, f"seed {seed}, {len(source[1]):,} faces", dataset_of_pair((sample, source[1])), view)
            sheet.add(2, 2 * pair + 1, text, dataset_of_pair((closest, source[1])), view)
    sheet.write(os.path.join(options.output, "deformations.png"), options.colors)


def triangulations(options, model, original, sheet, view):
    """One sample on three triangulations: its noise is made on one, and carried to the others as a point array."""
    sample, seconds = made(original, model, seed=SEEDS[0], steps=options.steps)
    start = with_noise_of(sample, original)
    displacements = {}
    few = with_noise_of(sample, simplified(original, 2500))
    meshes = {"original": start, "subdivided": subdivided(start), "decimated": few}
    for column, (name, mesh) in enumerate(meshes.items(), 1):
        if name != "original":
            sample, seconds = made(mesh, model, input_noise="InitialNoise", steps=options.steps)
        print(f"{name}, {faces(mesh)}: {seconds:.1f} s", flush=True)
        what = f"seed {SEEDS[0]}" if name == "original" else "the same noise"
        sheet.add(0, column, f"{what}, {name} triangulation\n{faces(mesh)}, {seconds:.1f} s", sample, view)
        surfacesynthesis.write_mesh(sample, os.path.join(options.output, f"deformation_{name}.vtp"))
        displacements[name] = vtk_to_numpy(sample.GetPointData().GetArray("Displacement"))
    # the points of the original are the first of the subdivided one
    coarse, fine = displacements["original"], displacements["subdivided"][: len(displacements["original"])]
    difference = np.linalg.norm(fine - coarse, axis=1).mean() / np.linalg.norm(coarse, axis=1).mean()
    print(f"original and subdivided: mean difference {100 * difference:.1f} % of the mean displacement", flush=True)


def rest_samples(options):
    """Samples of models of rest states on the original triangulations, and the rest states next to them."""
    names = ("bunny", "armadillo")
    sheet = rendering.Sheet(2 * len(names), len(SEEDS) + 1, rest_states.SIZE, margin=rest_states.BAR)
    for row, (name, file) in enumerate(zip(names, rest_states.SHAPES)):
        points, triangles = points_and_triangles(surface(None, file))
        mesh = points @ rest_states.UPRIGHT.T, triangles
        model = os.path.join(options.models, f"{name}_rest.safetensors")
        shapes = surfacesynthesis.deform((points, triangles), model, samples=len(SEEDS), steps=options.steps)
        shapes = shapes @ rest_states.UPRIGHT.T
        started = time.monotonic()
        settled = surfacesynthesis.settle(mesh, shapes)
        print(f"{name}: {time.monotonic() - started:.1f} s to settle {len(shapes)} samples", flush=True)
        rest_row(sheet, 2 * row, f"{name}\n{len(triangles):,} faces", mesh, [mesh[0], *shapes], "sample")
        rest_row(sheet, 2 * row + 1, "", mesh, [None, *settled], "settled")
    sheet.write(os.path.join(options.output, "rest_samples.png"), options.colors)


def humanoid(options):
    """A model of human bodies on a body that is none of these, turned as they are; the first of each row is the source."""
    points, triangles = points_and_triangles(surface(None, "armadillo.off"))
    armadillo = dataset_of_pair((points * (-1.0, 1.0, -1.0), triangles))
    model = os.path.join(options.models, BODIES + ".safetensors")
    meshes = {"even": remeshed(armadillo, 2500), "original": armadillo}
    sheet = rendering.Sheet(len(meshes), 1 + len(SEEDS), SIZE)
    view = rendering.view_of(armadillo, SIZE[0] / SIZE[1], (0.0, 0.1, 1.0), margin=1.4)
    for row, (name, mesh) in enumerate(meshes.items()):
        sheet.add(row, 0, f"{name}, {faces(mesh)}", mesh, view)
        for column, seed in enumerate(SEEDS, 1):
            output, seconds = made(mesh, model, seed=seed, steps=options.steps)
            print(f"{name}, {faces(mesh)}, seed {seed}: {seconds:.1f} s", flush=True)
            sheet.add(row, column, f"seed {seed}", output, view)
    sheet.write(os.path.join(options.output, "humanoid.png"), options.colors)


def rest_row(sheet, row, title, mesh, shapes, what):
    """A row of shapes that lie on the floor; None leaves a place empty."""
    points, triangles = mesh
    extent = 1.12 * np.linalg.norm(np.ptp(points, axis=0)) / 1.3
    for column, shape in enumerate(shapes):
        if shape is not None:
            text = f"{what} {column}" if column else title
            rest_states.show(sheet, row, column, text, shape, points, triangles, shape[:, 2].min(), extent)
    limit = rest_states.LIMIT
    sheet.add_bar(row, rendering.cool_warm(limit), -limit, limit, "logarithm\nof area")


def signals(options):
    model = os.path.join(options.models, "bunny_mixtures.safetensors")
    bunny = surface(None, "bunny00.off")
    others = {"even": remeshed(bunny, 2000), "coarse on one side": remeshed(bunny, 5000, 2.0)}
    sheet = rendering.Sheet(3, len(SEEDS), SIZE)
    view = rendering.view_of(bunny, SIZE[0] / SIZE[1], BUNNY)
    for column, seed in enumerate(SEEDS):
        first = surfacesynthesis.sample_signal(bunny, model, seed=seed, steps=options.steps)
        for row, (name, mesh) in enumerate({"original": bunny, **others}.items()):
            mesh = with_noise_of(first, mesh)
            started = time.monotonic()
            output = surfacesynthesis.sample_signal(mesh, model, input_noise="InitialNoise", steps=options.steps)
            peak = vtk_to_numpy(output.GetPointData().GetArray("Mixture")).max()
            print(f"{name}, {faces(mesh)}: {time.monotonic() - started:.1f} s, largest value {peak:.2f}", flush=True)
            edges = mesh.GetNumberOfCells() < 20000  # more would hide the colors
            title = f"seed {seed}\n{name}, {faces(mesh)}"
            sheet.add(row, column, title, output, view, array="Mixture", colors=MIXTURE, edges=edges)
    sheet.write(os.path.join(options.output, "signals.png"), options.colors)


def peaks(options):
    """Sharpness of signals of the same noise on three triangulations: the mean of their largest value, and of the median of
    their absolute value, which is haze where there are three Gaussians only."""
    model = os.path.join(options.models, "bunny_mixtures.safetensors")
    bunny = surface(None, "bunny00.off")
    meshes = {"original": bunny, "even": remeshed(bunny, 2000), "coarse on one side": remeshed(bunny, 5000, 2.0)}
    found = {name: [] for name in meshes}
    for seed in range(1, options.samples + 1):
        first = surfacesynthesis.sample_signal(bunny, model, seed=seed, steps=options.steps)
        for name, mesh in meshes.items():
            output = first
            if name != "original":
                start = with_noise_of(first, mesh)
                output = surfacesynthesis.sample_signal(start, model, input_noise="InitialNoise", steps=options.steps)
            found[name].append(vtk_to_numpy(output.GetPointData().GetArray("Mixture")).ravel())
    print("| triangulation | faces | mean of the maximum | of mixtures | mean of the median | of mixtures |")
    print("|---|---:|---:|---:|---:|---:|")
    for name, mesh in meshes.items():
        data = surfacesynthesis.gaussian_mixtures(mesh, options.samples).reshape(options.samples, -1)
        cells = [f"{np.mean([measure(v) for v in values]):.3f}" for measure in (np.max, haze) for values in (found[name], data)]
        print(f"| {name} | {mesh.GetNumberOfCells():,} | {' | '.join(cells)} |", flush=True)


def haze(values):
    return np.median(np.abs(values))


def times(options):
    """Seconds of the first and of each further sample over the number of triangles: figure 11 of the paper in kind."""
    model = os.path.join(options.models, "armadillo_poses.safetensors")
    original = surface(None, "armadillo.off")
    print("| triangles | first sample | each further sample |")
    print("|---:|---:|---:|")
    for mesh in (simplified(original, 2500), simplified(original, 8000), original, subdivided(original)):
        (_, first), (_, three) = (made(mesh, model, samples=count, steps=options.steps) for count in (1, 3))
        print(f"| {mesh.GetNumberOfCells():,} | {first:.2f} s | {(three - first) / 2:.2f} s |", flush=True)


#: What makes a picture or a table, and the models that it needs.
PICTURES = {
    "poses": (training_poses,),
    "mixtures": (training_mixtures,),
    "deformations": (deformations, "armadillo_poses"),
    "signals": (signals, "bunny_mixtures"),
    "rest_samples": (rest_samples, "bunny_rest", "armadillo_rest"),
    "humanoid": (humanoid, BODIES),
    "times": (times, "armadillo_poses"),
    "peaks": (peaks, "bunny_mixtures"),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--models", default=MODELS, metavar="DIR", help="where the model files are")
    parser.add_argument("--output", required=True, metavar="DIR")
    parser.add_argument("--only", nargs="+", choices=PICTURES, help="make some of it only; default: the pictures")
    parser.add_argument("--training", metavar="FILE", help="dataset in which the closest poses are looked up")
    parser.add_argument("--samples", type=int, default=10, help="that peaks are measured on (default: 10)")
    parser.add_argument("--steps", type=int, default=20, help="of the flow (default: 20)")
    parser.add_argument("--colors", type=int, metavar="N", help="write PNGs with a palette of so few colours (needs PIL)")
    options = parser.parse_args()
    os.makedirs(options.output, exist_ok=True)
    for name in options.only or [name for name in PICTURES if name not in ("times", "peaks")]:
        picture, *models = PICTURES[name]
        missing = [model for model in models if not os.path.exists(os.path.join(options.models, model + ".safetensors"))]
        if not missing:
            picture(options)
        else:
            print(f"{options.models} holds no {missing[0]}.safetensors: {name} are left out", flush=True)


if __name__ == "__main__":
    main()
