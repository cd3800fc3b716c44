#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Measures what a damaged source surface costs a model of poses: table 3 and figures 16 and 17 of "Matérn Noise for
Triangulation-Agnostic Flow Matching on Meshes" in kind.

    python3 damage.py [--model armadillo_poses] [--samples 100] [--vertices 2500] [--csv FILE]
    python3 damage.py --bodies FOLDER [--model body_poses] [--samples 100] [--vertices 2500] [--csv FILE]

Takes the armadillo, simplified, or the body in the folder of make_bodies.py, and damages it: small, medium and large holes; half
of the surface; mild and severe flips of edges, which turn good triangles into bad ones; and random thinning, which leaves three
quarters and half of the points. Points that are left stay where they are. A model that has seen good surfaces only is sampled on
each, twice: with area and centroid of the damaged surface, and with those of the undamaged one (``normalization_area`` and
``normalization_center`` of deform()). The samples are compared with poses of the undamaged surface, at the points that are left
(PoseSpace of sample_spaces.py, RigSpace of body_space.py): the root mean square distance in units of the root of the area, and
the mean of its square over that of the undamaged surface, as the table of the paper has it. Samples that grow without bound,
which deform() refuses, are left out and counted. With --repair holes are closed first, by repair(), which keeps the largest
component, and samples are drawn on the closed surface; distances are still those at the points of the damaged one. The column
"of poses" is the distance that poses themselves have at these points: where a limb is gone, its pull on the rest is not known.
"""

import argparse
import os
import sys
import warnings

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

import surfacesynthesis
from body_space import RigSpace, Skeleton, fitted_poses, moved_joints
from compare_noise import UNBOUNDED, write_csv
from linear_velocity import point_masses
from make_bodies import remeshed
from make_datasets import points_and_triangles, simplified, surface
from sample_spaces import PoseSpace

#: Numbers of holes, and their radius over the root of the area.
HOLES = {"small holes": (12, 0.02), "medium holes": (24, 0.045), "large holes": (4, 0.09)}
HALF = "half of the surface"
#: Flipped edges over the number of triangles: those of the paper, 1,000 and 3,000 of 13,776.
FLIPS = {"mild edge flips": 0.0726, "severe edge flips": 0.2178}
#: Parts of the points that are left.
THINNING = {"three quarters of the points": 0.75, "half of the points": 0.5}
#: Poses whose own distance is measured.
POSES_SEEN = 10
#: Smallest area of a flipped triangle over the mean: slivers, but no degenerate triangles.
SMALLEST = 1e-3


def largest_part(triangles, count):
    """The triangles of the largest connected part."""
    pairs = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]]])
    _, parts = connected_components(coo_matrix((np.ones(len(pairs)), pairs.T), shape=(count, count)), directed=False)
    of_triangle = parts[triangles[:, 0]]
    return triangles[of_triangle == np.bincount(of_triangle).argmax()]


def with_holes(points, triangles, random, number, radius):
    centers = points[random.choice(len(points), number, replace=False)]
    radius *= np.sqrt(point_masses(points, triangles).sum())
    centroids = points[triangles].mean(axis=1)
    inside = (np.linalg.norm(centroids[:, None] - centers, axis=2) < radius).any(axis=1)
    return largest_part(triangles[~inside], len(points))


def half_of(points, triangles):
    """The triangles on the left of the plane that halves the area."""
    x = points[triangles].mean(axis=1)[:, 0]
    order = np.argsort(x)
    areas = np.linalg.norm(normals_of(points, triangles), axis=1)[order].cumsum()
    return largest_part(triangles[x <= x[order[np.searchsorted(areas, 0.5 * areas[-1])]]], len(points))


def normals_of(points, triangles):
    a, b, c = (points[triangles[..., k]] for k in range(3))
    return np.cross(b - a, c - a)


def flipped(points, triangles, random, number):
    """The triangles after flips of random edges; none makes an edge that there is or a triangle without area."""
    triangles = [tuple(triangle) for triangle in triangles.tolist()]
    smallest = SMALLEST * np.linalg.norm(normals_of(points, np.array(triangles)), axis=1).mean()
    of_edge = {}
    for k, triangle in enumerate(triangles):
        for i in range(3):
            of_edge[triangle[i], triangle[(i + 1) % 3]] = k
    done = 0
    while done < number:
        first = random.integers(len(triangles))
        i = random.integers(3)
        a, b, c = (triangles[first][(i + j) % 3] for j in range(3))
        second = of_edge.get((b, a))
        if second is None:
            continue
        d = next(v for v in triangles[second] if v not in (a, b))
        new = np.array([(c, d, b), (d, c, a)])
        if (c, d) in of_edge or (d, c) in of_edge or np.linalg.norm(normals_of(points, new), axis=1).min() < smallest:
            continue
        for old in (triangles[first], triangles[second]):
            for j in range(3):
                of_edge.pop((old[j], old[(j + 1) % 3]))
        for k, triangle in zip((first, second), new.tolist()):
            triangles[k] = tuple(triangle)
            for j in range(3):
                of_edge[triangle[j], triangle[(j + 1) % 3]] = k
        done += 1
    return np.array(triangles)


def thinned(points, triangles, random, share):
    """The triangles after random points have been merged into neighbors until ``share`` of the points is left."""
    around = [set() for _ in points]
    triangles = {k: tuple(triangle) for k, triangle in enumerate(triangles.tolist())}
    for k, triangle in triangles.items():
        for v in triangle:
            around[v].add(k)

    def neighbors(v):
        return {w for k in around[v] for w in triangles[k]} - {v}

    left, wanted = sum(bool(faces) for faces in around), share * len(points)
    while left > wanted:
        v = int(random.integers(len(points)))
        near = sorted(neighbors(v))
        if not near:
            continue
        u = near[random.integers(len(near))]
        shared = around[v] & around[u]
        if len(shared) != 2 or len(neighbors(v) & neighbors(u)) != 2:
            continue  # it would pinch the surface
        old = [triangles[k] for k in sorted(around[v] - shared)]
        new = [tuple(u if w == v else w for w in triangle) for triangle in old]
        before, after = normals_of(points, np.array(old)), normals_of(points, np.array(new))
        if (np.einsum("fx,fx->f", before, after) <= 0.2 * np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)).any():
            continue  # it would fold the surface
        for k, triangle in zip(sorted(around[v] - shared), new):
            triangles[k] = triangle
            around[u].add(k)
        for k in shared:
            for w in triangles.pop(k):
                around[w].discard(k)
        around[v] = set()
        left -= 1
    return np.array(list(triangles.values()))


def damages(points, triangles, seed):
    """Name and triangles of each damaged surface, the undamaged one first."""
    yield "none", triangles
    for k, (name, (number, radius)) in enumerate(HOLES.items()):
        yield name, with_holes(points, triangles, np.random.default_rng([seed, k]), number, radius)
    yield HALF, half_of(points, triangles)
    for k, (name, share) in enumerate(FLIPS.items()):
        yield name, flipped(points, triangles, np.random.default_rng([seed, 10 + k]), int(share * len(triangles)))
    for k, (name, share) in enumerate(THINNING.items()):
        yield name, thinned(points, triangles, np.random.default_rng([seed, 20 + k]), share)


def measured(options, space, points, triangles):
    """Row of a damaged surface: its points, faces, and for each normalization what residuals_of() gives."""
    used, corners = np.unique(triangles, return_inverse=True)
    mesh = points[used], corners.reshape(-1, 3)
    row = {"points": len(used), "faces": len(triangles), "area": point_masses(*mesh).sum() / space.area}
    kept = places = np.arange(len(used))
    if options.repair:
        mesh, kept, places = repaired(mesh)
    used = used[kept]
    seen = space.seen_at(used)
    row["of_poses"] = seen.residuals(space.poses[:, used]).mean()
    whole = {"normalization_area": space.area, "normalization_center": space.center}
    for name, normalization in (("own", {}), ("whole", whole)):
        found = residuals_of(options, seen, mesh, places, normalization)
        row.update({f"{key}_{name}": value for key, value in found.items()})
    return row


def repaired(mesh):
    """The largest component with its holes closed, numbers of the points of ``mesh`` that it keeps, and where they are there."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", surfacesynthesis.SurfaceSynthesisWarning)  # no hole is too large here
        whole = surfacesynthesis.repair(mesh, holes="all", largest_component=True)
    distances, places = cKDTree(whole[0]).query(mesh[0])
    kept = np.flatnonzero(distances == 0.0)  # all but a few at non-manifold points
    return whole, kept, places[kept]


def finite_samples(options, mesh, normalization):
    """Samples [N, V, 3] of the model, and the errors of those that grow without bound, which are found by halves."""

    def drawn(first, count):
        flow = {"seed": options.seed, "steps": options.steps, "corrections": options.corrections}
        return surfacesynthesis.deform(mesh, options.model, first_sample=first, samples=count, **flow, **normalization)

    found, errors = [], []
    numbers = [(0, options.samples)]
    while numbers:
        first, count = numbers.pop()
        try:
            found.extend(np.reshape(drawn(first, count), (count, -1, 3)))
        except surfacesynthesis.SurfaceSynthesisError as error:
            if UNBOUNDED not in str(error):
                raise
            if count == 1:
                errors.append(str(error))
            else:
                half = count // 2
                numbers.extend(((first + half, count - half), (first, half)))
    return found, errors


def residuals_of(options, seen, mesh, places, normalization):
    """Of the finite samples mean and deviation of the residuals, and mean of their squares, all at the points ``places`` of
    the mesh; and the errors of the others."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", surfacesynthesis.SurfaceSynthesisWarning)  # half of a body is unlike the training
        samples, errors = finite_samples(options, mesh, normalization)
    found = {"unbounded": len(errors), "error": errors[0] if errors else ""}
    if not samples:
        return {"residual": np.nan, "deviation": np.nan, "square": np.nan, **found}
    residuals = seen.residuals(np.asarray(samples)[:, places])
    return {"residual": residuals.mean(), "deviation": residuals.std(), "square": (residuals**2).mean(), **found}


def shown(row, undamaged, name):
    """Cells of a normalization: distance, and its square over that of the undamaged surface; of how many samples if not of all."""
    if np.isnan(row["residual_" + name]):
        return "not finite | "
    ratio = row["square_" + name] / undamaged["square_own"]
    rest = f" without {row['unbounded_' + name]}" if row["unbounded_" + name] else ""
    return f"{row['residual_' + name]:.4f} ± {row['deviation_' + name]:.4f}{rest} | {ratio:.1f}"


def parsed(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--model", metavar="FILE", help="default: armadillo_poses, of bodies body_poses")
    parser.add_argument("--bodies", metavar="FOLDER", help="that of make_bodies.py: the body in place of the armadillo")
    parser.add_argument("--armadillo", metavar="FILE", help="a surface in place of the armadillo")
    parser.add_argument("--vertices", type=int, default=2500, metavar="V", help="default: 2500")
    parser.add_argument("--samples", type=int, default=100, metavar="N", help="of each surface (default: 100)")
    parser.add_argument("--steps", type=int, default=10, metavar="N", help="of the flow (default: 10)")
    parser.add_argument("--corrections", type=int, metavar="N", help="of each sample (default: what suits the model)")
    parser.add_argument("--seed", type=int, default=0, help="default: 0")
    parser.add_argument("--repair", action="store_true", help="close all holes first: repair()")
    parser.add_argument("--only", nargs="+", metavar="NAME", help='damages beside "none" (default: all)')
    parser.add_argument("--csv", metavar="FILE", help="write the table")
    options = parser.parse_args(arguments)
    unknown = set(options.only or ()) - {*HOLES, *FLIPS, *THINNING, HALF}
    if unknown:
        parser.error(f"there is no damage {', '.join(sorted(unknown))}; there are {', '.join([*HOLES, HALF, *FLIPS, *THINNING])}")
    if options.bodies and options.armadillo:
        parser.error("--bodies and --armadillo name two surfaces: one is damaged")
    options.model = options.model or ("body_poses" if options.bodies else "armadillo_poses")
    return options


def armadillo(options):
    """The surface and the space of its poses, of which it holds some."""
    whole = surface(options.armadillo, "armadillo.off")
    mesh = simplified(whole, options.vertices)
    points, triangles = points_and_triangles(mesh)
    poses = surfacesynthesis.poses(mesh, 20 + POSES_SEEN, template=whole)
    space = PoseSpace((points, triangles), poses[:20])
    space.poses = poses[20:]
    return points, triangles, space


def body(options):
    """The body and the space of its poses, of which it holds those kept for tests."""
    skeleton = Skeleton.read(os.path.join(options.bodies, "bones.csv"))
    joints = moved_joints(options.bodies, skeleton)
    rest, poses, _ = fitted_poses(options.bodies, skeleton, joints, POSES_SEEN)
    space = RigSpace(remeshed(rest, skeleton, options.vertices), skeleton, joints)
    space.poses = np.array([space.posed(pose) for pose in poses])
    return *space.mesh, space


def main(arguments=None):
    options = parsed(arguments)
    points, triangles, space = (body if options.bodies else armadillo)(options)
    masses = point_masses(points, triangles)
    space.area, space.center = masses.sum(), masses @ points / masses.sum()
    rows = []
    print("| damage | points | faces | area | own normalization: distance to the space of poses | squared, over undamaged | "
          "that of the whole: distance | squared, over undamaged | of poses |\n|---|---:|---:|---:|---:|---:|---:|---:|---:|")
    for name, damaged in damages(points, triangles, options.seed):
        if options.only and name not in ("none", *options.only):
            continue
        row = {"damage": name, **measured(options, space, points, damaged)}
        rows.append(row)
        print(f"| {name} | {row['points']:,} | {row['faces']:,} | {row['area']:.2f} | {shown(row, rows[0], 'own')} | "
              f"{shown(row, rows[0], 'whole')} | {row['of_poses']:.4f} |", flush=True)  # fmt: skip
        for error in filter(None, (row["error_own"], row["error_whole"])):
            print(error, file=sys.stderr)
    if options.csv:
        write_csv(rows, options.csv)
    return rows


if __name__ == "__main__":
    main()
