# SPDX-License-Identifier: BSD-3-Clause
"""Small files with the names that the examples on the pages of the filters read."""

import numpy as np
import surfacesynthesis as ss
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkMultiBlockDataSet, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkQuadricDecimation
from vtkmodules.vtkIOImage import vtkMetaImageWriter

#: Surfaces of which the examples need no more than that they are closed.
SURFACES = ("scan.stl", "scan.ply", "part.stl", "body.ply", "bunny.ply", "segmented.stl", "reference.ply", "synthesized.ply",
            "original.ply", "target.ply", "detailed.ply")  # fmt: skip


def add_array(mesh, name, values):
    array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
    array.SetName(name)
    mesh.GetPointData().AddArray(array)
    return array


def moved(mesh, points):
    """A copy of the mesh with other points."""
    copy = vtkPolyData()
    copy.DeepCopy(mesh)
    copy.GetPoints().SetData(numpy_to_vtk(np.ascontiguousarray(points), deep=True))
    return copy


def image_of(values, name):
    """An image of values [H, W, C], or a volume of values [D, H, W]."""
    values = np.ascontiguousarray(values)
    image = vtkImageData()
    volume = values.ndim == 3 and values.dtype != np.uint8
    image.SetDimensions(*(values.shape[::-1] if volume else (values.shape[1], values.shape[0], 1)))
    array = numpy_to_vtk(values.reshape(-1) if volume else values.reshape(-1, values.shape[2]), deep=True)
    array.SetName(name)
    image.GetPointData().SetScalars(array)
    return image


def blocks_of(meshes):
    blocks = vtkMultiBlockDataSet()
    for number, mesh in enumerate(meshes):
        blocks.SetBlock(number, mesh)
    return blocks


def write_volumes():
    """head.mha, a smooth ball, and labels.mha, two halves of a ball, with their names."""
    z, y, x = np.mgrid[-1:1:24j, -1:1:24j, -1:1:24j]
    radius = np.sqrt(x**2 + y**2 + z**2)
    labels = np.where(radius < 0.7, np.where(x < 0, 1, 2), 0).astype(np.int16)
    for name, values in (("head.mha", (1 - radius).astype(np.float32)), ("labels.mha", labels)):
        writer = vtkMetaImageWriter()
        writer.SetInputData(image_of(values, "Values"))
        writer.SetFileName(name)
        writer.SetCompression(False)
        writer.Write()
    with open("names.txt", "w", encoding="utf-8") as file:
        file.write("1 Left\n2 Right\n")


def write_skinned(ball):
    """body.vtp with the weights of two bones, and the tables of its bones and a pose."""
    body = moved(ball, vtk_to_numpy(ball.GetPoints().GetData()))
    second = (vtk_to_numpy(ball.GetPoints().GetData())[:, 2] > 0.0).astype(float)
    add_array(body, "BoneIndices", np.tile(np.array([0, 1], dtype=np.int32), (len(second), 1)))
    add_array(body, "BoneWeights", np.stack([1 - second, second], axis=1))
    ss.write_mesh(body, "body.vtp")
    with open("bones.csv", "w", encoding="utf-8") as file:
        file.write("Name,Head:0,Head:1,Head:2,Parent\nroot,0,0,-1,-1\nneck,0,0,0,0\n")
    with open("pose.csv", "w", encoding="utf-8") as file:
        file.write("Name,Rotation:0,Rotation:1,Rotation:2,Rotation:3\nneck,0.8,0.6,0,0\n")


def write_ensembles(ball):
    """Shapes and fields of several blocks, and a shape model."""
    random = np.random.default_rng(4)
    points = vtk_to_numpy(ball.GetPoints().GetData())
    shapes = [moved(ball, points * (1 + 0.2 * random.standard_normal(3))) for _ in range(7)]
    ss.write_mesh(blocks_of(shapes), "shapes.vtm")
    ss.write_mesh(blocks_of(shapes[:3]), "poses.vtm")
    ss.write_mesh(ss.ensemble_statistics(blocks_of(shapes), modes=5).surface, "model.vtp")
    for name in ("generated.vtm", "reference.vtm"):
        fields = [moved(ball, points) for _ in range(4)]
        for field in fields:
            add_array(field, "Field", random.standard_normal(len(points)))
        ss.write_mesh(blocks_of(fields), name)


def write_textured(ball):
    """duck.obj with duck.png, plain.vtp with its texture coordinates, and latents.vtp, its latent vectors."""
    points = vtk_to_numpy(ball.GetPoints().GetData())
    textured = moved(ball, points)
    coordinates = np.column_stack([np.where(points[:, 2] > 0, 0.75, 0.25) + 0.2 * points[:, 0], 0.5 + 0.45 * points[:, 1]])
    textured.GetPointData().SetTCoords(add_array(textured, "TCoords", coordinates.astype(np.float32)))
    y, x = np.mgrid[0:64, 0:64]
    image = image_of(np.stack([4 * x, 4 * y, 255 * ((x // 8 + y // 8) % 2)], axis=-1).astype(np.uint8), "Texture")
    ss.write_textured_mesh(textured, image, "duck.obj")
    ss.write_mesh(textured, "plain.vtp")
    ss.write_mesh(ss.encode_texture(textured, image), "latents.vtp")
    return image


def write_inputs(ball, coarse, armadillo):
    """Writes all files into the working folder: of a closed surface, one of some hundred points, and the scan."""
    for name in SURFACES:
        ss.write_mesh(ball, name)
    decimation = vtkQuadricDecimation()
    decimation.SetInputData(armadillo)
    decimation.SetTargetReduction(0.95)
    decimation.Update()
    ss.write_mesh(decimation.GetOutput(), "armadillo.ply")
    ss.write_mesh(coarse, "bark.ply")
    cortex = ss.matern_noise(ball, range=0.7, seed=1)
    add_array(cortex, "Thickness", 2.5 + 0.3 * vtk_to_numpy(cortex.GetPointData().GetArray("MaternNoise")))
    ss.write_mesh(cortex, "cortex.vtp")
    write_volumes()
    write_skinned(ball)
    write_ensembles(coarse)
    image = write_textured(coarse)
    points = vtk_to_numpy(coarse.GetPoints().GetData())
    samples = np.stack([points * (1 + 0.1 * k * np.eye(3)[k % 3]) for k in range(1, 5)])
    ss.write_signal_dataset("poses.safetensors", [(coarse, samples)], "Position")
    texels = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(64, 64, 3)
    ss.texture_dataset("textures.safetensors", [texels], tile=32, side=64, tiles=1, meshes=2, mesh_points=60)
