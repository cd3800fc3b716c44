#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of the example geometric textures, on surfaces that they were not learnt from.

    xvfb-run -a python3 geometric_textures.py --output DIR

The models (Examples/Models) were learnt from balls with a displacement (Examples/Training/make_references.py): spikes, a
labyrinth, and knobs that are wider above than at the neck. Each was learned twice: flow_NAME by flow matching, which the pictures show,
and NAME as published, which the tables are of without --flows. Writes

    textures.png          rows: the textures, of flows where there are; columns: the reference, and targets of genus 0, 1 and 2
    texture_samples.png   what grows on the template of the model: other samples of the reference itself
    texture_scales.png    above: one texture on one surface in four sizes (TextureScale); below: as it grows, level
                          by level
    texture_features.png  what geometric_texture_features() counts: peaks, merged ones in red, and walls
    texture_uses.png      above: strengths, and one that an array gives; below: a blend of two textures and a size, both
                          by an array, and knobs on a saddle before and after they are made printable, with intersecting
                          triangles in red
    texture_*.vtp         the surfaces, with arrays

and prints how long each took, and, as a table, how far the shapes of its triangles are from those of the reference
(geometric_texture_distance()). --only neighborhoods prints another table, in half an hour: the distances of
neighborhoods of 1, 3 and 6 rings, of five samples, as (distance - floor) / (distance of the bare target - floor), where the
floor is the distance of a second ball with other random places. --only features prints what is counted on a sphere, a plane, a
torus and a saddle, over what is counted on the reference. Surfaces come from Debian's package libcgal-demo.
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
from vtkmodules.vtkFiltersCore import vtkAppendPolyData, vtkContourFilter, vtkPolyDataNormals, vtkStripper, vtkTubeFilter
from vtkmodules.vtkFiltersSources import vtkSphereSource

EXAMPLES = os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir)
sys.path.insert(0, os.path.join(EXAMPLES, "Training"))

from make_datasets import surface  # noqa: E402
from make_references import LEVELS, balls, bare_levels, directions, grid, reference_levels, torus  # noqa: E402

MODELS = os.path.join(EXAMPLES, "Models")
SIZE = (460, 440)
TEXTURES = ("spikes", "labyrinth", "knobs")
#: Where a texture grows, of which genus, of how many points, and the direction that it is seen from.
TARGETS = {
    "bear": (0, 2500, (0.3, 0.2, 1.0)),
    "knot1": (1, 2500, (0.1, 0.2, 1.0)),
    "eight": (2, 1500, (0.2, 0.9, 0.6)),
}
BALL = (0.3, 0.2, 1.0)
#: The first level of the models makes a ball a ball; those from here on make the texture.
START = 1
#: Sizes of the neighborhoods that are compared.
RINGS = (1, 3, 6)


def remeshed(mesh, points):
    """A surface with even triangles."""
    return surfacesynthesis.remesh(mesh, points=points, feature_angle=None)


def synthesized(mesh, model, **parameters):
    """A surface with a texture, and the seconds it took."""
    started = time.monotonic()
    output = surfacesynthesis.geometric_texture(mesh, model, **parameters)
    return output, time.monotonic() - started


def model_of(options, texture, flow=None):
    """The model of a texture; ``flow`` None: as --flows says."""
    flow = options.flows if flow is None else flow
    return os.path.join(options.models, f"{'flow_' if flow else ''}{texture}.safetensors")


def shown_model_of(options, texture):
    """A flow where there is one, else the model that was learned as published."""
    flow = model_of(options, texture, flow=True)
    return flow if os.path.exists(flow) else model_of(options, texture, flow=False)


def faces(mesh):
    return f"{mesh.GetNumberOfCells():,} faces"


def textures(options):
    targets = {name: remeshed(surface(None, name + ".off"), TARGETS[name][1]) for name in TARGETS}
    sheet = rendering.Sheet(len(TEXTURES), 1 + len(targets), SIZE)
    aspect = SIZE[0] / SIZE[1]
    for row, texture in enumerate(TEXTURES):
        reference = reference_levels(texture)[-1]
        view = rendering.view_of(reference, aspect, BALL)
        sheet.add(row, 0, f"{texture}: the reference\n{faces(reference)}", reference, view)
        for column, (name, target) in enumerate(targets.items(), 1):
            genus, _, direction = TARGETS[name]
            output, seconds = synthesized(target, shown_model_of(options, texture), start_level=START, seed=options.seed)
            print(f"{texture} on {name}, {faces(target)} to {faces(output)}: {seconds:.1f} s", flush=True)
            title = f"{name}, genus {genus}\n{faces(output)}"
            sheet.add(row, column, title, output, rendering.view_of(target, aspect, direction, margin=1.2))
            surfacesynthesis.write_mesh(output, os.path.join(options.output, f"texture_{texture}_{name}.vtp"))
    sheet.write(os.path.join(options.output, "textures.png"), options.colors)


def samples(options):
    seeds = range(1, 5)
    sheet = rendering.Sheet(len(TEXTURES), len(seeds), SIZE)
    for row, texture in enumerate(TEXTURES):
        for column, seed in enumerate(seeds):
            output, _ = synthesized(None, shown_model_of(options, texture), seed=seed)
            view = rendering.view_of(output, SIZE[0] / SIZE[1], BALL)
            sheet.add(row, column, f"{texture}, seed {seed}", output, view)
    sheet.write(os.path.join(options.output, "texture_samples.png"), options.colors)


def scales(options):
    """Figures 9 and 6 of the paper in kind."""
    model = shown_model_of(options, "spikes")
    knot = surface(None, "knot1.off")
    view = rendering.view_of(knot, SIZE[0] / SIZE[1], TARGETS["knot1"][2], margin=1.25)
    sheet = rendering.Sheet(2, 4, SIZE)
    for column, scale in enumerate((2.0, 1.4, 1.0, 0.7)):
        how = {"prepare": "remesh", "scale": scale, "start_level": START, "seed": options.seed}
        output, _ = synthesized(knot, model, **how)
        sheet.add(0, column, f"texture scale {scale}\n{faces(output)}", output, view)
    target = remeshed(knot, 2000)
    levels, _ = synthesized(target, model, start_level=START, seed=options.seed, output_levels=True)
    sheet.add(1, 0, f"the target\n{faces(target)}", target, view)
    for column in range(1, 4):
        level = levels[column - 1]
        sheet.add(1, column, f"level {START + column - 1}\n{faces(level)}", level, view)
    sheet.write(os.path.join(options.output, "texture_scales.png"), options.colors)


def mean_edge(mesh):
    return surfacesynthesis.topology_report(mesh)["edge_length_mean"]


def distances_on(target, reference, model, seed):
    """Distances of each level of a synthesized texture, and of the bare target, from that level of the reference."""
    edge = mean_edge(reference[0])
    levels, _ = synthesized(target, model, start_level=START, seed=seed, output_levels=True)
    found = []
    for k, pair in enumerate(zip(levels, bare_levels(target, len(levels)))):
        units = {"unit_length": mean_edge(target) / 2**k, "reference_unit_length": edge / 2 ** (START + k)}
        distance = surfacesynthesis.geometric_texture_distance
        found.append([distance(mesh, reference[START + k], **units) for mesh in pair])
    return found


def distances(options):
    numbers = range(START, LEVELS)
    print("| texture | target |" + "".join(f" level {k} | bare |" for k in numbers))
    print("|---|---|" + "---:|" * 2 * len(numbers))
    for texture in TEXTURES:
        reference = reference_levels(texture)
        for name in TARGETS:
            target = remeshed(surface(None, name + ".off"), TARGETS[name][1])
            pairs = distances_on(target, reference, model_of(options, texture), options.seed)
            values = " | ".join(f"{value:.3f}" for pair in pairs for value in pair)
            print(f"| {texture} | {name} | {values} |", flush=True)


def shares(distances, floor, bare):
    """Distances [N] between that of a perfect texture, 0, and that of none, 1."""
    return (np.asarray(distances) - floor) / (bare - floor)


def neighborhoods_on(target, pair, model, seeds, norm_statistics="target"):
    """For each of RINGS the shares of the samples of these seeds; ``pair`` are two references at their last levels with their
    units, the first of which the texture was learnt from."""
    (reference, unit), (other, other_unit) = pair
    bare = bare_levels(target, LEVELS - START)[-1]
    how = {"start_level": START, "norm_statistics": norm_statistics}
    found = [synthesized(target, model, seed=seed, **how)[0] for seed in seeds]
    own_unit = mean_edge(target) / 2 ** (LEVELS - START - 1)

    def distance(mesh, mesh_unit, rings):
        units = {"unit_length": mesh_unit, "reference_unit_length": unit}
        return surfacesynthesis.geometric_texture_distance(mesh, reference, rings=rings, **units)

    return [
        shares(
            [distance(mesh, own_unit, rings) for mesh in found],
            distance(other, other_unit, rings),
            distance(bare, own_unit, rings),
        )
        for rings in RINGS
    ]


def neighborhoods(options):
    print("| texture | target |" + "".join(f" {rings} ring{'s'[: rings > 1]} |" for rings in RINGS))
    print("|---|---|" + "---:|" * len(RINGS))
    for texture in options.textures:
        balls = [reference_levels(texture, seed=seed) for seed in (1, 2)]
        pair = [(levels[-1], mean_edge(levels[0]) / 2 ** (LEVELS - 1)) for levels in balls]
        for name in TARGETS:
            target = remeshed(surface(None, name + ".off"), TARGETS[name][1])
            seeds = range(options.seed, options.seed + 5)
            found = neighborhoods_on(target, pair, model_of(options, texture), seeds, options.norm_statistics)
            values = " | ".join(f"{one.mean():.3f} ({one.min():.3f} to {one.max():.3f})" for one in found)
            print(f"| {texture} | {name} | {values} |", flush=True)


#: Shapes as functions of two coordinates from -1 to 1, and whether they close in both.
SHAPES = {
    "plane": (lambda u, v: (u, v, 0.0 * u), False),
    "saddle": (lambda u, v: (u, v, 0.5 * (u * u - v * v)), False),
    "torus": (torus(1.0, 0.4), True),
}


def unit_ball(level=LEVELS - 1):
    """A level of the balls that textures are learnt from, without the texture."""
    ball = balls(LEVELS)[level]
    ball.GetPoints().SetData(numpy_to_vtk(directions(ball), deep=True))
    return ball


def shape(name, points):
    """One of SHAPES, or a sphere, with so many points and even triangles."""
    if name == "sphere":
        return remeshed(unit_ball(), points)
    return remeshed(grid(*SHAPES[name]), points)


def reference_features(texture, seed=1, reference=None, level=LEVELS - 1):
    """Features of a ball that the texture was learnt from (seed 1), or of another with other random places."""
    ball = reference_levels(texture, seed=seed)[level]
    return surfacesynthesis.geometric_texture_features(ball, unit_ball(level), reference)


def piece_features(texture, reference, level=LEVELS - 1):
    """Features of the part of the reference above a fifth of the radius, which ends in the middle of features."""
    plain, textured = unit_ball(level), reference_levels(texture)[level]
    points, triangles = directions(plain), vtk_to_numpy(plain.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    used, corners = np.unique(triangles[(points[triangles][:, :, 2] > 0.2).all(axis=1)], return_inverse=True)
    heights = vtk_to_numpy(textured.GetPoints().GetData()).astype(float)
    piece, bare = (given_dataset((rows[used], corners.reshape(-1, 3))) for rows in (heights, points))
    return surfacesynthesis.geometric_texture_features(piece, bare, reference)


def features_on(target, model, seed, reference=None, norm_statistics="target", level=LEVELS - 1, restarts=None):
    """Features of a level of a synthesized texture. In place of a model: the surface that it was learned from, an example."""
    bare = bare_levels(target, level - START + 1)[-1]
    if isinstance(model, str):
        how = {"start_level": START, "end_level": level, "seed": seed, "norm_statistics": norm_statistics}
        output, _ = synthesized(target, model, restarts=restarts, **how)
    else:
        how = {"plain_example": unit_ball(level), "subdivisions": level - START, "seed": seed}
        output = surfacesynthesis.geometric_texture_from_example(target, model, **how)
    return surfacesynthesis.geometric_texture_features(output, bare, reference)


def features(options):
    """A row for the reference, for five other balls, and for each shape, with means over five seeds."""
    names = "peaks in an area", "variation of heights", "of whole ones", "merged", "of whole ones", "walls in an area", "intersections"
    print(f"| texture | surface | {' | '.join(names)} |")
    print("|---|---|" + "---:|" * len(names))
    level = options.level
    for texture in options.textures:
        reference = reference_features(texture, level=level)
        rows = {
            "reference": [reference_features(texture, reference=reference, level=level)],
            "other balls": [reference_features(texture, seed, reference, level) for seed in range(2, 7)],
            "piece of the reference": [piece_features(texture, reference, level)],
        }
        source = reference_levels(texture)[level] if options.from_example else model_of(options, texture)
        for name in ("sphere", *SHAPES):
            target = shape(name, 2500)
            seeds = range(options.seed, options.seed + 5)
            how = {"reference": reference, "norm_statistics": options.norm_statistics, "level": level}
            how["restarts"] = options.restarts
            rows[name] = [features_on(target, source, seed, **how) for seed in seeds]
        for name, found in rows.items():
            print(f"| {texture} | {name} | {row_of(found)} |", flush=True)


def peaks_of(found):
    """Height over the ground, whether it has merged, and whether it is whole, of each peak: no boundary ends in its region."""
    surface, points = found.surface, found.surface.GetPointData()
    corners = vtk_to_numpy(surface.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    edges, counts = np.unique(np.sort(corners[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0, return_counts=True)
    height, kind, region = (vtk_to_numpy(points.GetArray(name)) for name in ("Height", "Peak", "Region"))
    peaks = np.flatnonzero(kind)
    cut = np.unique(region[edges[counts == 1]])
    return height[peaks] - found["base_level"], kind[peaks] == 2, ~np.isin(region[peaks], cut)


def whole_features(found):
    """Variation of heights, and share of merged ones, of the features that no boundary cuts."""
    heights, merged, whole = peaks_of(found)
    return (heights[whole].std() / heights[whole].mean(), merged[whole].mean()) if whole.any() else (0.0, 0.0)


def row_of(found):
    """Means of some samples as cells of a table; intersections in a thousand triangles."""

    def mean(values):
        return np.mean(list(values))

    peaks, walls = (mean(one.ratios[key] for one in found) for key in ("peak_density", "wall_density"))
    variation, merged = (100 * mean(one[key] for one in found) for key in ("peak_height_variation", "merged_share"))
    whole = 100 * np.mean([whole_features(one) for one in found], axis=0)
    crossings = mean(1000 * one["number_of_self_intersections"] / one.surface.GetNumberOfCells() for one in found)
    shares = f"{variation:.1f} % | {whole[0]:.1f} % | {merged:.1f} % | {whole[1]:.1f} %"
    return f"{peaks:.2f} | {shares} | {walls:.2f} | {crossings:.2f}"


CLAY, SEPARATE, MERGED, WALL = (205, 198, 186), (40, 90, 200), (215, 40, 30), (20, 110, 90)


def painted(mesh, color):
    """A surface in one color, with normals."""
    normals = vtkPolyDataNormals()
    normals.SetInputData(mesh)
    normals.SplittingOff()
    normals.Update()
    colors = numpy_to_vtk(np.tile(np.array(color, np.uint8), (mesh.GetNumberOfPoints(), 1)), deep=True)
    colors.SetName("Color")
    output = normals.GetOutput()
    output.GetPointData().AddArray(colors)
    return output


def marked(found):
    """The surface with a ball on each peak, red on merged ones; a labyrinth with its walls."""
    surface = found.surface
    peaks = vtk_to_numpy(surface.GetPointData().GetArray("Peak"))
    append = vtkAppendPolyData()
    append.AddInputData(painted(surface, CLAY))
    if found["merged_share"] > 0.5:  # ridges, whose highest places say little
        surface.GetPointData().SetActiveScalars("Height")
        contour = vtkContourFilter()
        contour.SetInputData(surface)
        contour.SetValue(0, found["wall_height"])
        lines = vtkStripper()
        lines.SetInputConnection(contour.GetOutputPort())
        lines.JoinContiguousSegmentsOn()
        tube = vtkTubeFilter()
        tube.SetInputConnection(lines.GetOutputPort())
        tube.SetRadius(0.5 * found["unit_length"])
        tube.SetNumberOfSides(10)
        tube.Update()
        append.AddInputData(painted(tube.GetOutput(), WALL))
    else:
        for point in np.flatnonzero(peaks):
            ball = vtkSphereSource()
            ball.SetCenter(surface.GetPoint(point))
            ball.SetRadius(max(0.11 / np.sqrt(found["peak_density"]), 0.007 * surface.GetLength()))
            ball.SetThetaResolution(16)
            ball.SetPhiResolution(12)
            ball.Update()
            append.AddInputData(painted(ball.GetOutput(), MERGED if peaks[point] == 2 else SEPARATE))
    append.Update()
    return append.GetOutput()


def feature_pictures(options):
    """Features of each reference, and of the texture on another surface."""
    sheet = rendering.Sheet(2, len(TEXTURES), SIZE)
    aspect = SIZE[0] / SIZE[1]
    for column, (texture, name) in enumerate(zip(TEXTURES, TARGETS)):
        reference = reference_features(texture)
        target = remeshed(surface(None, name + ".off"), TARGETS[name][1])
        found = features_on(target, shown_model_of(options, texture), options.seed, reference)
        for row, (one, direction) in enumerate(((reference, BALL), (found, TARGETS[name][2]))):
            view = rendering.view_of(one.surface, aspect, direction)
            sheet.add(row, column, title_of(one, texture, name if row else "the reference"), marked(one), view, array="Color")
    sheet.write(os.path.join(options.output, "texture_features.png"), options.colors)


def title_of(found, texture, where):
    """Two lines about the marks."""
    if found["merged_share"] > 0.5:
        return f"{texture}: {where}\nlength of walls over area: {found['relative_wall_density']:.3f} / edge"
    peaks = f"{found['number_of_peaks']} peaks, {100 * found['merged_share']:.0f} % merged"
    return f"{texture}: {where}\n{peaks}, heights \u00b1 {100 * found['peak_height_variation']:.1f} %"


def with_array(mesh, name, values):
    """A copy of a surface with another point array."""
    copy = mesh.NewInstance()
    copy.ShallowCopy(mesh)
    array = numpy_to_vtk(np.asarray(values, float), deep=True)
    array.SetName(name)
    copy.GetPointData().AddArray(array)
    return copy


def along(mesh, axis):
    """Coordinates of the points along an axis, from 0 to 1."""
    values = vtk_to_numpy(mesh.GetPoints().GetData())[:, axis].astype(float)
    return (values - values.min()) / np.ptp(values)


def intersections_marked(mesh, counts):
    """The surface with the triangles that intersect others in red."""
    corners = vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    marked = painted(mesh, CLAY)
    colors = vtk_to_numpy(marked.GetPointData().GetArray("Color"))
    colors[corners[counts > 0].ravel()] = MERGED
    return marked


def strengths(options, sheet):
    """A row with three strengths, and one that rises from the feet of a bear to its head."""
    bear = remeshed(surface(None, "bear.off"), TARGETS["bear"][1])
    view = rendering.view_of(bear, SIZE[0] / SIZE[1], TARGETS["bear"][2], margin=1.25)
    model, how = shown_model_of(options, "spikes"), {"start_level": START, "seed": options.seed}
    for column, strength in enumerate((0.5, 1.0, 1.75)):
        output, _ = synthesized(bear, model, strength=strength, **how)
        sheet.add(0, column, f"spikes, strength {strength:g}\n{faces(output)}", output, view)
    rising = with_array(bear, "Rise", 1.75 * along(bear, 1))
    output, _ = synthesized(rising, model, strength_array="Rise", **how)
    sheet.add(0, 3, "spikes, a strength array\n0 at the feet to 1.75 at the ears", output, view)


def blend(options, sheet):
    """Two textures on one surface, with a share that an array gives."""
    target = remeshed(surface(None, "knot1.off"), TARGETS["knot1"][1])
    mixed, _ = synthesized(
        with_array(target, "Share", np.clip(2.0 * along(target, 0) - 0.5, 0.0, 1.0)),
        shown_model_of(options, "labyrinth"),
        second_model=shown_model_of(options, "knobs"),
        blend="Share",
        start_level=START,
        seed=options.seed,
    )
    view = rendering.view_of(target, SIZE[0] / SIZE[1], TARGETS["knot1"][2], margin=1.2)
    sheet.add(1, 0, f"a blend of labyrinth and knobs\n{faces(mixed)}", mixed, view)


def sizes(options, sheet):
    """One texture whose size an array gives."""
    target = remeshed(surface(None, "eight.off"), TARGETS["eight"][1])
    output, _ = synthesized(
        with_array(target, "Size", 0.5 + 1.4 * along(target, 0)),
        shown_model_of(options, "spikes"),
        size="Size",
        prepare="remesh",
        scale=1.0,
        start_level=START,
        seed=options.seed,
    )
    view = rendering.view_of(target, SIZE[0] / SIZE[1], TARGETS["eight"][2], margin=1.3)
    sheet.add(1, 1, f"spikes, sizes of 0.5 to 1.9\n{faces(output)}", output, view)


def printable_knobs(options, sheet):
    """A part of a saddle with knobs where triangles intersect, and the same part when it is printable."""
    saddle = given_dataset(shape("saddle", 2500))
    view = None
    for column, printable in ((2, False), (3, True)):
        how = {"start_level": START, "seed": options.seed, "printable": printable}
        output, _ = synthesized(saddle, shown_model_of(options, "knobs"), **how)
        found = surfacesynthesis.geometric_texture_features(output)
        counts = vtk_to_numpy(found.surface.GetCellData().GetArray("SelfIntersections"))
        if view is None:
            points = vtk_to_numpy(output.GetPoints().GetData())
            corners = vtk_to_numpy(output.GetPolys().GetConnectivityArray()).reshape(-1, 3)
            places = points[corners[counts > 0]].mean(axis=1)
            near = (np.linalg.norm(places[:, None] - places, axis=2) < 0.1).sum(axis=1)
            view = rendering.View(places[near.argmax()], 0.4, (0.45, -0.6, 0.65), (0.0, 0.0, 1.0))
        kind = "the same, printable" if printable else "a part of knobs on a saddle"
        image = rendering.render(intersections_marked(output, counts), view, SIZE, array="Color")
        rendering.outline(image, 0, 0, *SIZE, rendering.BACKGROUND, thickness=8)
        sheet.add_image(1, column, f"{kind}\n{found['number_of_self_intersections']} self-intersections", image)


def uses(options):
    """Strengths, a blend, sizes, and printable surfaces."""
    sheet = rendering.Sheet(2, 4, SIZE)
    strengths(options, sheet)
    blend(options, sheet)
    sizes(options, sheet)
    printable_knobs(options, sheet)
    sheet.write(os.path.join(options.output, "texture_uses.png"), options.colors)


#: What makes a picture, or a table.
PICTURES = {
    "textures": textures,
    "samples": samples,
    "scales": scales,
    "distances": distances,
    "feature_pictures": feature_pictures,
    "uses": uses,
    "neighborhoods": neighborhoods,
    "features": features,
}
#: Tables that take half an hour.
LONG = ("neighborhoods", "features")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--models", default=MODELS, metavar="DIR", help="where the model files are")
    parser.add_argument("--output", required=True, metavar="DIR")
    quick = [name for name in PICTURES if name not in LONG]
    parser.add_argument("--only", nargs="+", choices=PICTURES, default=quick, help="make some of it only")
    parser.add_argument("--seed", type=int, default=1, help="default: 1")
    parser.add_argument("--norm-statistics", choices=["target", "reference"], default="target", help="of the two tables")
    levels = range(START, LEVELS)
    parser.add_argument("--restarts", type=int, metavar="N", help="of flows, in the features (default: 3)")
    parser.add_argument("--flows", action="store_true", help="models that have learned by flow matching, flow_NAME")
    parser.add_argument("--from-example", action="store_true", help="features without a model, from the reference itself")
    parser.add_argument("--level", type=int, choices=levels, default=LEVELS - 1, help="of the features (default: the finest)")
    parser.add_argument("--textures", nargs="+", choices=TEXTURES, default=TEXTURES, help="of the features (default: all)")
    parser.add_argument("--colors", type=int, metavar="N", help="write PNGs with a palette of so few colours (needs PIL)")
    options = parser.parse_args()
    os.makedirs(options.output, exist_ok=True)
    for name in options.only:
        PICTURES[name](options)


if __name__ == "__main__":
    main()
