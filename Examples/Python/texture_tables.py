# SPDX-License-Identifier: BSD-3-Clause
"""Tables about geometric textures on surfaces that they were not learnt from; geometric_textures.py prints them."""

import os
import sys
import time

import numpy as np
import surfacesynthesis
from surfacesynthesis.datasets import given_dataset
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, "Training"))

from make_datasets import normals_of, surface  # noqa: E402
from make_references import (  # noqa: E402
    FINER,
    LEVELS,
    SMOOTHING,
    Neighbors,
    balls,
    bare_levels,
    directions,
    displaced,
    grid,
    reference_levels,
    torus,
)

TEXTURES = ("spikes", "labyrinth", "knobs")
#: Where a texture grows, of which genus, of how many points, and the direction that it is seen from.
TARGETS = {
    "bear": (0, 2500, (0.3, 0.2, 1.0)),
    "knot1": (1, 2500, (0.1, 0.2, 1.0)),
    "eight": (2, 1500, (0.2, 0.9, 0.6)),
}
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


def by_formula(target, texture, seed):
    """A target with a texture by its formula, with triangles as small as those of a synthesized one."""
    levels = bare_levels(target, LEVELS - START + FINER)
    fine, output = levels[-1], levels[LEVELS - START - 1]
    unit = mean_edge(unit_ball(START)) / mean_edge(target)
    points = unit * vtk_to_numpy(fine.GetPoints().GetData()).astype(float)
    area = unit**2 * surfacesynthesis.topology_report(fine)["area"]
    moved = displaced(texture, points, normals_of(fine), area, np.random.default_rng(seed))
    moved = Neighbors(fine).smoothed(moved, round(SMOOTHING * (4**FINER - 1)))[: output.GetNumberOfPoints()] / unit
    output.GetPoints().SetData(numpy_to_vtk(np.ascontiguousarray(moved), deep=True))
    return output


def formula_features(target, texture, seed, reference):
    """Features of a target with a texture by its formula: what a perfect model could reach."""
    bare = bare_levels(target, LEVELS - START)[-1]
    return surfacesynthesis.geometric_texture_features(by_formula(target, texture, seed), bare, reference)


def census_target(name):
    """One of SHAPES, a sphere, or one of TARGETS."""
    return remeshed(surface(None, name + ".off"), TARGETS[name][1]) if name in TARGETS else shape(name, 2500)


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
        seeds = range(options.seed, options.seed + 5)
        how = {"reference": reference, "norm_statistics": options.norm_statistics, "level": level}
        for name in options.shapes:
            target = census_target(name)
            if options.by_formula:
                rows[name] = [formula_features(target, texture, seed, reference) for seed in seeds]
            else:
                rows[name] = [features_on(target, source, seed, restarts=options.restarts, **how) for seed in seeds]
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


