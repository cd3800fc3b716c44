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
                          by an array, and tall knobs on a saddle before and after they are made printable, with intersecting
                          triangles in red
    texture_*.vtp         the surfaces, with arrays

and prints how long each took, and, as a table, how far the shapes of its triangles are from those of the reference
(geometric_texture_distance()). --only neighborhoods prints another table, in half an hour: the distances of
neighborhoods of 1, 3 and 6 rings, of five samples, as (distance - floor) / (distance of the bare target - floor), where the
floor is the distance of a second ball with other random places. --only features prints what is counted on a sphere, a plane, a
torus and a saddle, or on other --shapes, over what is counted on the reference; with --by-formula of the texture as its formula
makes it there, which a perfect model would reach. Surfaces come from Debian's package libcgal-demo.
"""

import argparse
import os

import gallery_rendering as rendering
import numpy as np
import surfacesynthesis
from surfacesynthesis.datasets import given_dataset
from texture_tables import (
    LEVELS,
    SHAPES,
    START,
    TARGETS,
    TEXTURES,
    distances,
    features,
    features_on,
    model_of,
    neighborhoods,
    reference_features,
    reference_levels,
    remeshed,
    shape,
    surface,
    synthesized,
)
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkFiltersCore import vtkAppendPolyData, vtkContourFilter, vtkPolyDataNormals, vtkStripper, vtkTubeFilter
from vtkmodules.vtkFiltersSources import vtkSphereSource

MODELS = os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, "Models")
SIZE = (460, 440)
BALL = (0.3, 0.2, 1.0)


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


#: Strength at which knobs lean into one another.
TALL = 1.6
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
    """A part of a saddle with tall knobs where triangles intersect, and the same part when it is printable."""
    saddle = given_dataset(shape("saddle", 2500))
    view = None
    for column, printable in ((2, False), (3, True)):
        how = {"start_level": START, "seed": options.seed, "strength": TALL, "printable": printable}
        output, _ = synthesized(saddle, shown_model_of(options, "knobs"), **how)
        found = surfacesynthesis.geometric_texture_features(output)
        counts = vtk_to_numpy(found.surface.GetCellData().GetArray("SelfIntersections"))
        if view is None:
            points = vtk_to_numpy(output.GetPoints().GetData())
            corners = vtk_to_numpy(output.GetPolys().GetConnectivityArray()).reshape(-1, 3)
            places = points[corners[counts > 0]].mean(axis=1)
            near = (np.linalg.norm(places[:, None] - places, axis=2) < 0.1).sum(axis=1) * (np.abs(places[:, :2]).max(axis=1) < 0.85)
            view = rendering.View(places[near.argmax()], 0.4, (0.25, -0.35, 1.0), (0.0, 1.0, 0.0))
        kind = "the same, printable" if printable else f"a part of knobs on a saddle, strength {TALL}"
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
    parser.add_argument("--by-formula", action="store_true", help="features of the formula of spikes or knobs on each shape")
    shapes = ("sphere", *SHAPES)
    parser.add_argument("--shapes", nargs="+", choices=(*shapes, *TARGETS), default=shapes,
                        help=f"of the features (default: {' '.join(shapes)})")  # fmt: skip
    parser.add_argument("--level", type=int, choices=levels, default=LEVELS - 1, help="of the features (default: the finest)")
    parser.add_argument("--textures", nargs="+", choices=TEXTURES, default=TEXTURES, help="of the features (default: all)")
    parser.add_argument("--colors", type=int, metavar="N", help="write PNGs with a palette of so few colours (needs PIL)")
    options = parser.parse_args()
    if options.by_formula and "labyrinth" in options.textures:
        parser.error("the labyrinth is a harmonic of the ball: --by-formula needs --textures spikes, knobs or both")
    if options.by_formula and (options.from_example or options.level != LEVELS - 1):
        parser.error("--by-formula is of the finest level, and has no example")
    os.makedirs(options.output, exist_ok=True)
    for name in options.only:
        PICTURES[name](options)


if __name__ == "__main__":
    main()
