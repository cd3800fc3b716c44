# SPDX-License-Identifier: BSD-3-Clause
"""Examples of help texts and of README files run as they are printed.

bash reads the lines of an example, with functions in place of the programs that note their arguments: variables, loops,
wildcards and quotes are bash's own. What was noted then runs in order: ``python3 -m surfacesynthesis`` by main() in this
process, surfacesynthesis-train by itself; scripts of Examples, which have tests of their own, up to the end of
their parse_args(); of cmake, ctest, bash and tar the presets, scripts and archives are looked up.

Files that an example reads are small ones of the same names and kinds (INPUTS). REDUCED lists all texts that are replaced
because what they ask for takes long; a text that no example contains any more fails the test.
"""

import argparse
import gzip
import importlib.util
import json
import os
import pathlib
import re
import runpy
import shlex
import shutil
import subprocess
import sys
import tarfile
import types

import numpy as np
import pytest
import surfacesynthesis
from conftest import add_array, files_in, icosphere, polydata_of
from latent_models import write_random_latents
from surfacesynthesis import encode_texture, texture_atlas, texture_dataset, write_mesh, write_signal_dataset
from surfacesynthesis.command_line import build_parser, main
from surfacesynthesis.commands.common import Outcome
from surfacesynthesis.conversion import describe, expected_tensors
from surfacesynthesis.safetensors import write_safetensors
from surfacesynthesis.textured_files import write_image
from TestConversion import CONFIG, TEXTURE, generator_of, state_of
from TestScannerFiles import series
from TestTextureCommands import pattern, write_textured_ball
from TestVolumes import nifti
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import VTK_TETRA, vtkImageData, vtkMultiBlockDataSet, vtkUnstructuredGrid
from vtkmodules.vtkIOImage import vtkPNGWriter

ROOT = pathlib.Path(__file__).resolve().parents[2]
MODELS = ROOT / "Examples" / "Models"
TRAIN_PROGRAM = os.environ.get("SURFACE_SYNTHESIS_TRAIN_PROGRAM", "")
READMES = ["README.md", "Examples/README.md", "Examples/Documentation/README.md", "Examples/Models/README.md",
           "Examples/Training/README.md", "Testing/README.md", "Wrapping/ParaView/README.md", "CONTRIBUTING.md"]  # fmt: skip
#: README files whose examples run elsewhere: ParaView's own Python is needed (the preset paraview), or minutes (each
#: benchmark runs once, in the tests with the label benchmark).
ELSEWHERE = ["Examples/ParaView/README.md", "Testing/Benchmarks/README.md"]

#: Printed text, and the text that runs. Where a number is left to its default, an option is added.
REDUCED = {
    "--samples 2000 --candidates 3000 --points 2000": "--samples 1 --candidates 2 --points 300 --surface-points 80 --maximum-time 0",
    "--samples 100 --first-sample 100000 --points 2000":
        "--samples 1 --first-sample 100000 --points 300 --surface-points 80 --maximum-time 0",
    "rest.safetensors resting.safetensors":
        "rest.safetensors resting.safetensors --width 16 --blocks 2 --iterations 1",
    "--model bunny_rest --samples 8": "--model bunny_rest --samples 2 --steps 2",
    "--shapes samples.vtm": "--shapes samples.vtm --surface-points 80",
    "rest.safetensors --samples 100": "rest.safetensors --samples 1 --surface-points 80 --maximum-time 0",
    "--samples 3000 --points 1500": "--samples 2 --points 300",
    "--samples 3000 --points 2000": "--samples 2 --points 300",
    "--samples 500 --first": "--samples 2 --first",
    "--width 48 --blocks 3": "--width 16 --blocks 2 --iterations 1",
    "--width 128 --blocks 5": "--width 16 --blocks 2 --iterations 1",
    "--signal Heat": "--signal Heat --width 16 --blocks 2 --iterations 1",
    "--encoder-iterations 20000": "--encoder-iterations 1 --iterations 1 --width 16 --blocks 2",
    "bark-levels.safetensors --iterations 500": "bark-levels.safetensors --iterations 1 --levels 2",
    "levels bark.ply bark-levels.safetensors\n": "levels bark.ply bark-levels.safetensors --iterations 1 --levels 3\n",
    "--template torus --levels 4": "--template torus --levels 2 --iterations 1",
    "--template coarse-hand.ply": "--template coarse-hand.ply --levels 2 --iterations 1",
    "--template surface": "--template surface --levels 2 --iterations 1",
    "--texture-name bark": "--texture-name bark --iterations 1",
    "--points 30000": "--points 300",
    "--points 20000": "--points 300",
    "--points 2500": "--points 300",
    "--meshes 8": "--meshes 1 --mesh-points 64",
    "--iterations 100000": "--iterations 1 --batch 3",
    "--triangulations 64 --points 5000":
        "--triangulations 1 --points 60 --iterations 1 --batch 1 --channels 4 --coarse-channels 4",
    "--points 5000 --triangulations 64": "--points 60 --triangulations 1",
    "--iterations 300000 --batch 16": "--iterations 1 --batch 1 --channels 4 --coarse-channels 4",
    "--time-budget 60": "--iterations 1 --batch 3 --meshes 1 --mesh-points 64",
    "--iterations 40000": "--iterations 1 --batch 3",
    "points=2500": "points=300",
    "--iterations 900 --batch 16": "--iterations 1 --batch 2",
    "--iterations 1000 --batch 16": "--iterations 1 --batch 2",
    "--width 32 --blocks 3 --iterations 1000": "--width 16 --blocks 2 --iterations 1",
    "--iterations 500 --batch 16": "--iterations 1 --batch 2",
    "--iterations 500 --batch 8": "--iterations 1 --batch 2",
    "--iterations 1200 --batch 16": "--iterations 1 --batch 2",
    "--iterations 800 --batch 8": "--iterations 1 --batch 2",
    "--iterations 2000 --batch 8": "--iterations 1 --batch 2",
    "--iterations 2200 --batch 12": "--iterations 1 --batch 4",
    "--iterations 2600 --batch 12": "--iterations 1 --batch 4",
    "--iterations 1400 --batch 12": "--iterations 1 --batch 4",
    "--steps 50 --trajectory": "--steps 3 --trajectory",
    "--model heat.safetensors --samples 50": "--model heat.safetensors --samples 3",
    "surfacesynthesis-train encoding bodies.safetensors encoder.safetensors":
        "surfacesynthesis-train encoding bodies.safetensors encoder.safetensors --iterations 1",
    "--encoder encoder.safetensors": "--encoder encoder.safetensors --iterations 1",
    "trainer.SetEncoderIterations(20000)": "trainer.SetEncoderIterations(1); trainer.SetIterations(1)",
    "mountains rocky.ply --seed 1": "mountains rocky.ply --seed 1 --subdivisions 0 --scales 1",
    "cortex folded.ply": "cortex folded.ply --subdivisions 0 --scales 1",
    "/usr/share/mricron/templates/ch2bet.nii.gz": "ch2bet.nii.gz",
    "/usr/share/mricron/templates/aal": "aal",
    "<build or install folder>": "BUILD",
    "<build folder>": "BUILD",
}  # fmt: skip
_used = set()

#: Programs in place of which bash calls a function, with the number of leading words that only start another program.
PROGRAMS = ("python3", "cmake", "ctest", "bash", "tar", "surfacesynthesis-train", "BUILD/bin/TrainRegression",
            "build/dev/bin/TestMaternNoiseFilter")  # fmt: skip


def reduced(text):
    """The text with the replacements of REDUCED."""
    for printed, run in REDUCED.items():
        if printed in text:
            _used.add(printed)
            text = text.replace(printed, run)
    return text


def recorded(lines, folder):
    """The commands that bash runs for these lines, as lists of words."""
    record = folder / "commands.txt"
    functions = "".join(f'function {name} () {{ record {name} "$@"; }}\n' for name in PROGRAMS)
    script = f"""set -eu
record () {{ printf '%q ' "$@" >> {shlex.quote(str(record))}; echo >> {shlex.quote(str(record))}; }}
{functions}
function xvfb-run () {{ shift; "$@"; }}
{lines}
"""
    done = subprocess.run(["bash", "-c", script], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"bash cannot run\n{lines}\n{done.stderr}"
    commands = [shlex.split(line) for line in record.read_text().splitlines()] if record.exists() else []
    record.unlink(missing_ok=True)
    return commands


# -- small files for examples ------------------------------------------------------------------------------------------


def ball(path, levels=2):
    points, triangles = icosphere(levels, 50.0)
    write_mesh(polydata_of(points * [1.0, 0.9, 0.8], triangles), path)


def small_ball(path):
    write_mesh(polydata_of(*icosphere(1, 5.0)), path)


def wide_ball(path):
    points, triangles = icosphere(2, 50.0)
    write_mesh(polydata_of(points * [1.1, 1.0, 0.7], triangles), path)


def bumpy(path):
    """A surface with a texture: waves on a ball, and their direction."""
    points, triangles = icosphere(2, 50.0)
    mesh = polydata_of(points * (1.0 + 0.02 * np.sin(points / 8.0).prod(axis=1, keepdims=True)), triangles)
    add_array(mesh.GetPointData(), "Growth", np.tile([0.0, 0.0, 1.0], (len(points), 1)))
    write_mesh(mesh, path)


def smooth_ball(path):
    """The surface of bumpy() without its texture."""
    write_mesh(polydata_of(*icosphere(2, 50.0)), path)


def growing(path):
    """A surface with directions and a mask at its points."""
    points, triangles = icosphere(1, 50.0)
    mesh = polydata_of(points * [1.0, 0.9, 0.8], triangles)
    add_array(mesh.GetPointData(), "Growth", np.tile([0.0, 1.0, 0.0], (len(points), 1)))
    add_array(mesh.GetPointData(), "Grown", (points[:, 1] > 0.0).astype(float))
    write_mesh(mesh, path)


def plain_ball(path):
    """A surface with texture coordinates."""
    write_mesh(surfacesynthesis.texture_atlas(polydata_of(*icosphere(2, 50.0)), resolution=256), path)


def observed(name):
    """A maker of the surface of ball() with a field, which has a correlation, as a point array."""

    def make(path):
        points, triangles = icosphere(2, 50.0)
        mesh = polydata_of(points * [1.0, 0.9, 0.8], triangles)
        add_array(mesh.GetPointData(), name, surfacesynthesis.matern_noise((points, triangles), range=60.0, seed=1))
        write_mesh(mesh, path)

    return make


def landmarks(path):
    """A few points of the surface of with_arrays() with a displacement."""
    points = icosphere(2, 50.0)[0][::40]
    mesh = polydata_of(points, np.zeros((0, 3), dtype=np.int64))
    add_array(mesh.GetPointData(), "Displacement", 2e-4 * points)
    add_array(mesh.GetPointData(), "Target", 1.0002 * points)
    write_mesh(mesh, path)


def tetrahedron(path):
    grid = vtkUnstructuredGrid()
    points = vtkPoints()
    for point in ((0, 0, 0), (5, 0, 0), (0, 5, 0), (0, 0, 5)):
        points.InsertNextPoint(*point)
    grid.SetPoints(points)
    grid.InsertNextCell(VTK_TETRA, 4, (0, 1, 2, 3))
    write_mesh(grid, path)


def with_arrays(path):
    """A surface with the arrays that examples name."""
    mesh = polydata_of(*icosphere(2, 50.0))
    for name, values in (("Height", None), ("Heat", None), ("EdgeLength", 20.0)):
        heights = np.arange(mesh.GetNumberOfPoints(), dtype=float) % 7 + len(str(path)) % 5
        add_array(mesh.GetPointData(), name, heights if values is None else np.full(mesh.GetNumberOfPoints(), values))
    write_mesh(mesh, path)


def skinned(path):
    """A ball with the weights of two bones."""
    points, triangles = icosphere(2, 50.0)
    mesh = polydata_of(points, triangles)
    add_array(mesh.GetPointData(), "BoneIndices", np.tile(np.array([0, 1], dtype=np.int32), (len(points), 1)))
    second = (points[:, 0] > 0.0).astype(float)
    add_array(mesh.GetPointData(), "BoneWeights", np.stack([1 - second, second], axis=1))
    write_mesh(mesh, path)


def bones(path):
    path.write_text("Name,Head:0,Head:1,Head:2,Parent\nroot,-50,0,0,-1\narm,0,0,0,0\n")


def pose(path):
    path.write_text("Name,Rotation:0,Rotation:1,Rotation:2,Rotation:3\narm,0.8,0,0,0.6\n")


def blocks(path):
    """Three samples of a surface."""
    samples = vtkMultiBlockDataSet()
    for k in range(3):
        points, triangles = icosphere(1, 50.0)
        samples.SetBlock(k, polydata_of(points * (1.0 + 0.1 * k + 0.01 * (len(path.name) % 3)), triangles))
    write_mesh(samples, path)


def picture(path):
    write_image(pattern(), path)


def encoded_ball(path):
    """A ball with field latents."""
    write_random_latents(path.with_suffix(".safetensors"))
    mesh = texture_atlas(polydata_of(*icosphere(1, 50.0)), resolution=64)
    write_mesh(encode_texture(mesh, pattern(), model=path.with_suffix(".safetensors")), path)


def latents(path):
    """A dataset of field latents on a triangulation."""
    autoencoder = path.with_name("latents.safetensors")
    write_random_latents(autoencoder)
    mesh = texture_atlas(polydata_of(*icosphere(1, 50.0)), resolution=64)
    surfacesynthesis.latent_dataset(path, mesh, pattern(), autoencoder=autoencoder, triangulations=1, points=60)


def diffusion(path):
    """A diffusion model of field latents."""
    dataset = path.with_name("made-latents.safetensors")
    latents(dataset)
    sizes = {"channels": 4, "coarse_channels": 4, "iterations": 1, "batch": 1}
    surfacesynthesis.train_latent_diffusion(model=path, dataset=dataset, **sizes)


def painted_ball(path):
    """A ball with colors and a mask at its points."""
    mesh = polydata_of(*icosphere(1, 50.0))
    colors = np.random.default_rng(1).integers(0, 256, (mesh.GetNumberOfPoints(), 3)).astype(np.uint8)
    add_array(mesh.GetPointData(), "RGB", colors)
    add_array(mesh.GetPointData(), "Kept", np.arange(mesh.GetNumberOfPoints()) % 2.0)
    write_mesh(mesh, path)


def torus(path):
    i, j = np.meshgrid(np.arange(20), np.arange(10), indexing="ij")
    u, v = i * 2 * np.pi / 20, j * 2 * np.pi / 10
    points = np.stack([(3 + np.cos(v)) * np.cos(u), (3 + np.cos(v)) * np.sin(u), np.sin(v)], axis=-1).reshape(-1, 3)
    a, b, c, d = (10 * ((i + k) % 20) + (j + m) % 10 for k, m in ((0, 0), (1, 0), (1, 1), (0, 1)))
    write_mesh(polydata_of(points, np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)), path)


def volume(path):
    """A ball of high samples: NIfTI, or NRRD."""
    grid = np.indices((20, 20, 20)) - 9.5
    values = (1000 - 100 * np.sqrt((grid**2).sum(axis=0))).astype(np.int16)
    if path.name.endswith(".nrrd"):
        header = "NRRD0004\ntype: short\ndimension: 3\nsizes: 20 20 20\nencoding: raw\nendian: little\n\n"
        path.write_bytes(header.encode() + values.tobytes(order="F"))
    else:
        path.write_bytes(nifti(values, pixdim=(1, 5, 5, 5)))


def dicom_series(path):
    """The same ball as slices in a folder."""
    volume(path.with_suffix(".nii"))
    values = np.frombuffer(path.with_suffix(".nii").read_bytes()[352:], dtype="<i2").reshape((20, 20, 20), order="F")
    series(path, np.diag([5.0, 5.0, 5.0, 1.0]), values, range(20))


def zipped_volume(path):
    volume(path)
    path.write_bytes(gzip.compress(path.read_bytes()))


def zipped_labels(path):
    """Boxes with the labels that examples name, one beside the other."""
    values = np.zeros((32, 8, 8), dtype=np.int16)
    for number, label in enumerate((1, 2, 17, 37, 53)):
        values[1 + 6 * number : 7 + 6 * number, 1:7, 1:7] = label
    path.write_bytes(gzip.compress(nifti(values, pixdim=(1, 5, 5, 5))))


def label_names(path):
    path.write_text("1 Precentral_L 2001\n2 Precentral_R 2002\n17 Left-Hippocampus 1\n53 Right-Hippocampus 2\n")


def observed_twice(path):
    """A surface with two samples of a field."""
    points, triangles = icosphere(1, 50.0)
    mesh = polydata_of(points, triangles)
    for number in range(2):
        add_array(mesh.GetPointData(), f"MaternNoise_{number}", points[:, number])
    write_mesh(mesh, path)


def shape_model_file(path):
    """A model of the surfaces of ball(), with three modes."""
    points, triangles = icosphere(2, 50.0)
    scales = np.array([[1.0, 0.9, 0.8], [1.1, 1.0, 0.7], [0.9, 1.0, 0.8], [1.0, 1.0, 1.0], [0.9, 0.9, 0.9]])
    ensemble = [(points * scale, triangles) for scale in scales]
    write_mesh(surfacesynthesis.ensemble_statistics(ensemble, modes=3).surface, path)


def photograph(path):
    """A small image."""
    values = np.random.default_rng(4).integers(0, 256, (24, 20, 3), dtype=np.uint8)
    data = vtkImageData()
    data.SetDimensions(20, 24, 1)
    data.GetPointData().SetScalars(numpy_to_vtk(values.reshape(-1, 3), deep=True))
    writer = vtkPNGWriter()
    writer.SetInputData(data)
    writer.SetFileName(str(path))
    writer.Write()


def textures(path):
    """A dataset of field latents."""
    path.parent.mkdir(exist_ok=True)
    texture_dataset(path, [np.random.default_rng(4).random((32, 32, 3))], meshes=1, mesh_points=64)


def configuration(path):
    """The configuration of a network, less the number of its conditions."""
    path.write_text(json.dumps({name: value for name, value in CONFIG.items() if name != "extra_features"}))


def model(name):
    return lambda path: shutil.copyfile(MODELS / f"{name}.safetensors", path)


def network(**config):
    def make(path):
        metadata, options = describe({"head": "linear", "n_blocks": 1, "C_width": 4, "cmlp_nlayers": 1, **config})
        random = np.random.default_rng(5)
        tensors = {name: random.uniform(-0.3, 0.3, shape) for name, shape in expected_tensors(options).items()}
        write_safetensors(path, tensors, metadata)

    return make


def signals(name, sources=1, components=3):
    """A dataset of two samples on each source."""

    def make(path):
        surfaces = [icosphere(2, 50.0 + k) for k in range(sources)]
        random = np.random.default_rng(2)
        samples = [random.uniform(-1, 1, (2, len(points), components)) for points, _ in surfaces]
        if name == "Position":
            samples = [points + sample for (points, _), sample in zip(surfaces, samples)]
        write_signal_dataset(path, list(zip(surfaces, samples)), name)

    return make


#: For each command (or README file) its input files, by pattern: the first that fits. Others are made by examples before.
SURFACES = {"*.ply": ball, "*.stl": ball, "*.off": ball, "*.obj": ball, "*.vtp": with_arrays}
INPUTS = {
    "convert": {
        "crumpling.json": configuration,
        "options.json": lambda path: path.write_text(json.dumps(TEXTURE)),
        "crumpling.pt": lambda path: path.write_bytes(b"a checkpoint"),
        "SingleMeshGenerator.pth": lambda path: path.write_bytes(b"a checkpoint"),
    },
    "displacement-map": {"plain.obj": plain_ball, "plain.vtp": plain_ball, "detailed.ply": wide_ball,
                         "detailed.vtp": wide_ball},
    "distance": {"segmented.stl": ball, "reference.ply": wide_ball, "scan.ply": ball, "repaired.ply": ball},
    "estimate": {"cortex.vtp": observed("Thickness"), "bone.ply": ball, "measured.vtp": observed("Density")},
    "dataset": {"armadillo.off": lambda path: ball(path, 3), "bunny.off": lambda path: ball(path, 3),
                "brick.png": photograph, "grass.png": photograph, "duck.obj": write_textured_ball,
                "latents.safetensors": write_random_latents,
                "patient_1.vtp": wide_ball, "patient_2.vtp": ball},
    "deform": {"body.ply": ball, "poses.safetensors": model("armadillo_poses")},
    "settle": {"bunny.ply": lambda path: ball(path, 1), "samples.vtm": blocks, "femur.vtu": tetrahedron, "guess.vtu": tetrahedron,
               "bodies.vtm": blocks, "deformed.vtm": blocks},
    "skin": {"body.vtp": skinned, "bones.csv": bones, "run.csv": pose},
    "sample": {"heart.vtp": with_arrays, "heat.safetensors": model("bunny_mixtures")},
    "geometric-texture": {"bunny.ply": ball, "scales.safetensors": model("knobs")},
    "texture-statistics": {"old-scales.safetensors": model("knobs")},
    "geometric-texture-distance": {"synthesized_2.ply": ball, "levels_2.ply": ball},
    "geometric-texture-from-example": {"bunny.ply": lambda path: ball(path, 1), "scan.ply": bumpy, "smooth.ply": smooth_ball,
                                       "horn.vtp": growing, "bark.vtp": bumpy},
    "geometric-texture-features": {"synthesized_2.ply": ball, "target_2.ply": ball, "levels_2.ply": ball, "ball_2.ply": ball},
    "levels": {"bark.ply": ball, "ring.ply": torus, "hand.ply": ball, "scan.ply": ball,
               "coarse-hand.ply": lambda path: ball(path, 1)},
    "metrics": {"generated.vtm": blocks, "reference.vtm": blocks, "neutral.ply": lambda path: ball(path, 1),
                **{f"{kind}_{k}.vtp": with_arrays for kind in ("made", "real") for k in (1, 2, 3)}},
    "noise": {"in.stl": ball, "in.ply": ball, "in.off": ball, "bone.vtp": with_arrays, "landmarks.vtp": landmarks,
              "in.vtu": tetrahedron},
    "poisson-net": {"body.ply": ball, "flat.obj": ball, "segmentation.safetensors": network(classes=["a", "b"]),
                    "crumpling.safetensors": network(head="njf", extra_features=1)},
    "remesh": {"scan.stl": ball, "scan.ply": ball, "scan.vtp": with_arrays},
    "encode-texture": {"duck.obj": write_textured_ball, "duck.glb": write_textured_ball,
                       "bark.png": picture, "latents.safetensors": write_random_latents},
    "decode-texture": {"duck.vtp": encoded_ball, "fine.off": ball, "latents.safetensors": write_random_latents},
    "transfer-texture": {"duck.obj": write_textured_ball, "fine.off": small_ball,
                         "latents.safetensors": write_random_latents},
    "sample-texture": {"duck.off": small_ball, "painted.vtp": painted_ball, "bark.safetensors": diffusion,
                       "latents.safetensors": write_random_latents},
    "texture-atlas": {"scan.stl": small_ball, "scan.ply": small_ball, "scan.off": small_ball},
    "repair": {"scan.stl": ball, "scan.ply": ball, "scan.obj": ball, "scan.off": ball},
    "report": {"in.stl": ball, "in.vtp": with_arrays},
    "label-surfaces": {"aal.nii.gz": zipped_labels, "aal.nii.txt": label_names, "aseg.nii.gz": zipped_labels,
                       "FreeSurferColorLUT.txt": label_names},
    "shape-model": {"model.vtp": shape_model_file, "patient_1.vtp": wide_ball, "patient_2.vtp": ball},
    "statistics": {"shapes_1.vtp": ball, "shapes_2.vtp": wide_ball, "shapes_3.vtp": ball, "noise.vtp": observed_twice},
    "surface": {"head.nii.gz": zipped_volume, "series": dicom_series, "ct.nrrd": volume, "scan.ply": small_ball},
    "tetrahedralize": {"in.stl": ball, "in.ply": small_ball, "in.vtp": with_arrays},
    "train field-latents": {"brick.png": picture, "grass.png": picture},
    "train latent-diffusion": {"duck.obj": write_textured_ball, "latents.safetensors": write_random_latents,
                               "bark-latents.safetensors": latents},
    "train flow-matching": {"poses.safetensors": signals("Position"), "neutral.ply": ball,
                            "faces_1.ply": ball, "faces_2.ply": wide_ball, "heart.vtp": with_arrays,
                            "bodies.safetensors": signals("Position", 2)},
    "train geometric-texture": {"bark.ply": ball},
    "view": {"result.vtp": observed("MaternNoise")},
    "README.md": {"bear.off": lambda path: ball(path, 3), "ch2bet.nii.gz": zipped_volume},
    "Examples/README.md": {"armadillo.off": lambda path: ball(path, 3), "bear.off": ball, "bunny00.off": ball, "bunny.ply": ball,
                           "surface.stl": ball, "scan.stl": ball, "ch2bet.nii.gz": zipped_volume,
                           "aal.nii.gz": zipped_labels, "aal.nii.txt": label_names,
                           "painted.obj": write_textured_ball, "other.off": small_ball, "shell.ply": bumpy,
                           "horn.vtp": growing, "spikes.ply": bumpy, "knobs.ply": bumpy,
                           "bone.vtp": with_arrays, "landmarks.vtp": landmarks, "cortex.vtp": observed("Thickness")},
    "Examples/Training/README.md": {"armadillo.off": ball, "bunny.off": ball, "bunny.ply": ball, "bark.ply": ball,
                                    "scan.ply": ball,
                                    "data/armadillo_coarse.safetensors": signals("Position"),
                                    "data/armadillo_medium.safetensors": signals("Position"),
                                    "data/armadillo_poses.safetensors": signals("Position"),
                                    "data/armadillo_many.safetensors": signals("Position", 4),
                                    "rest/armadillo_rest.safetensors": signals("Position", 4),
                                    "figures/armadillo_coarse.safetensors": signals("Position"),
                                    "figures/armadillo_medium.safetensors": signals("Position"),
                                    "data/bent_coarse.safetensors": signals("Position"),
                                    "data/bent_medium.safetensors": signals("Position"),
                                    "data/bunny_coarse.safetensors": signals("Heat", 1, 1),
                                    "data/bunny_mixtures.safetensors": signals("Heat", 1, 1),
                                    "bodies.safetensors": signals("Position", 2),
                                    "field-latents/textures.safetensors": textures},
    "Wrapping/ParaView/README.md": {"poses.safetensors": signals("Position")},
}  # fmt: skip
#: Classes that a command needs, which a build may lack.
NEEDS = {
    "convert": None, "dataset poses": "vtkPoseEnsembleFilter", "dataset rest-states": "vtkTetrahedralizeFilter",
    "settle": "vtkTetrahedralizeFilter",
    "dataset": "vtkPoseEnsembleFilter",
    "levels": "vtkMultiscaleMeshFitter", "remesh": "vtkIsotropicRemeshFilter", "repair": "vtkSurfaceRepairFilter",
    "surface": "vtkVDBSurfaceFilter", "tetrahedralize": "vtkTetrahedralizeFilter",
    "texture-atlas": "vtkTextureAtlasFilter", "displacement-map": "vtkTextureAtlasFilter",
    "encode-texture": "vtkTextureAtlasFilter", "decode-texture": "vtkTextureAtlasFilter",
    "transfer-texture": "vtkTextureAtlasFilter", "sample-texture": "vtkLatentDiffusionTrainer",
    "train": "vtkFlowMatchingTrainer", "geometric-texture": "vtkIsotropicRemeshFilter",
}  # fmt: skip
#: Commands whose examples need what tests do not have.
ELSEWHERE_COMMANDS = {"convert": "PyTorch reads the checkpoints: TestConversion.py has a stand-in for it"}


def prepare(folder, name):
    """Makes the input files of a command or README file in the folder where it runs."""
    (folder / "data").mkdir()
    (folder / "node_modules" / "vtk.js").mkdir(parents=True)
    (folder / "node_modules" / "vtk.js" / "vtk.js").write_text("// a stand-in")
    (folder / "Examples").symlink_to(ROOT / "Examples")
    for pattern, make in INPUTS.get(name, {}).items():
        (folder / pattern).parent.mkdir(exist_ok=True)
        make(folder / pattern)


def skip_without(command):
    needed = NEEDS.get(command.split()[0])
    if needed is not None and not hasattr(surfacesynthesis, needed):
        pytest.skip(f"built without {needed}")
    if command == "surface" and importlib.util.find_spec("gdcm") is None:
        pytest.skip("python3-gdcm, which reads DICOM, is not installed")


# -- running -----------------------------------------------------------------------------------------------------------


class _Parsed(Exception):
    """The arguments of a script are parsed."""


def check_script(words, monkeypatch):
    """Parses the arguments of a script; its own test runs it."""
    script = ROOT / words[0]
    assert script.is_file(), f"{words[0]} does not exist"
    original = argparse.ArgumentParser.parse_args

    def parse(self, *arguments, **options):
        original(self, *arguments, **options)
        raise _Parsed

    if "argparse" in script.read_text():
        monkeypatch.setattr(argparse.ArgumentParser, "parse_args", parse)
        monkeypatch.setattr(sys, "argv", [str(script), *words[1:]])
        monkeypatch.syspath_prepend(str(script.parent))
        with pytest.raises(_Parsed):
            runpy.run_path(str(script), run_name="__main__")
        monkeypatch.setattr(argparse.ArgumentParser, "parse_args", original)


def require_few_iterations(words):
    counts = [int(count) for name, count in zip(words, words[1:]) if name.endswith("iterations") and count.isdigit()]
    assert max(counts, default=0) <= 20, f"{shlex.join(words)} takes long: a shorter text belongs in REDUCED"


def run(words, monkeypatch):
    """Runs or checks a command."""
    program, *rest = words
    print("$", *words)
    if program == "python3" and rest[:2] == ["-m", "surfacesynthesis"]:
        require_few_iterations(words)
        status = main(rest[2:])
        assert status == 0, f"{shlex.join(words)} ended with {status}"
    elif program == "python3":
        check_script(rest, monkeypatch)
    elif program == "surfacesynthesis-train":
        require_few_iterations(words)
        if TRAIN_PROGRAM:
            environment = {**os.environ, "OMP_NUM_THREADS": "1"}
            done = subprocess.run([TRAIN_PROGRAM, *rest], env=environment, capture_output=True, text=True, check=False)
            assert done.returncode == 0, done.stderr
    elif program in ("cmake", "ctest"):
        if "--preset" in rest:
            presets = json.loads((ROOT / "CMakePresets.json").read_text())
            kind = "testPresets" if program == "ctest" else "buildPresets" if "--build" in rest else "configurePresets"
            names = {preset["name"] for preset in presets[kind]}
            assert rest[rest.index("--preset") + 1] in names, f"{shlex.join(words)}: {kind} has no such preset"
    elif program == "bash":
        assert subprocess.run(["bash", "-n", ROOT / rest[0]], check=False).returncode == 0, f"{rest[0]} is no script"
    elif program == "tar":
        archive = next(word for word in rest if word.startswith("/"))
        if os.path.exists(archive):  # which install-dependencies.sh brings
            with tarfile.open(archive) as file:
                missing = {word for word in rest if word.startswith("data/")} - set(file.getnames())
            assert not missing, f"{archive} has no {missing}"
    elif program.startswith(("BUILD/bin/", "build/dev/bin/")):  # run by the tests of Examples, or a test itself
        assert list(ROOT.glob(f"**/{pathlib.Path(program).name}.cxx")), f"{program} is not built from a source"
    else:
        pytest.fail(f"nothing is known of the program {program}")


# -- help texts --------------------------------------------------------------------------------------------------------


def examples_of_help():
    """Pairs (command, line) of all help texts."""
    pairs, parsers = [], [("", build_parser())]
    while parsers:
        name, parser = parsers.pop()
        for action in parser._actions:
            if isinstance(action, argparse._SubParsersAction):
                parsers += [(f"{name} {key}".strip(), child) for key, child in action.choices.items()]
        text = parser.format_help()
        for block in re.findall(r"^examples:\n((?:  .*\n?)+)", text, flags=re.MULTILINE):
            pairs += [(name, line.strip()) for line in block.splitlines()]
    return sorted(set(pairs))


COMMANDS = sorted({name for name, _ in examples_of_help()})


def test_each_command_has_examples():
    commands = {shlex.split(line)[3] for _, line in examples_of_help()}
    listed = next(action for action in build_parser()._actions if isinstance(action, argparse._SubParsersAction))
    assert commands == {action.dest for action in listed._choices_actions}


@pytest.mark.parametrize("command", COMMANDS)
def test_examples_of_help_texts_run(command, tmp_path, monkeypatch):
    lines = [line for name, line in examples_of_help() if name == command]
    if command in ELSEWHERE_COMMANDS:
        for words in recorded("\n".join(lines), tmp_path):
            build_parser().parse_args(words[3:])  # the arguments, at least
        return
    skip_without(command)
    monkeypatch.chdir(tmp_path)
    prepare(tmp_path, command)
    for line in sorted(lines, key=lambda line: (" levels " not in line, " export " in line)):  # makers of inputs first
        for words in recorded(reduced(line + "\n"), tmp_path):
            run(words, monkeypatch)


# -- JSON --------------------------------------------------------------------------------------------------------------

#: Commands whose examples make the inputs of others.
MAKERS = {"dataset export": "dataset poses", "train field-latents": "dataset textures", "train geometric-texture": "levels"}


def commands_of(parser, name=""):
    """Names of all commands that run, those of other commands included, with their parsers."""
    nested = [action for action in parser._actions if isinstance(action, argparse._SubParsersAction)]
    if not nested:
        return {name: parser}
    return {
        key: found
        for action in nested
        for child in action._choices_actions
        for key, found in commands_of(action.choices[child.dest], f"{name} {child.dest}".strip()).items()
    }


def example_of(command):
    """The command whose help has an example of another, or the same, command without comma-separated values, and the line."""
    words = command.split()
    lines = [(name, line) for name, line in examples_of_help() if shlex.split(line)[3 : 3 + len(words)] == words]
    plain = [(name, line) for name, line in lines if not {"--csv", "--json", "--nearest"} & set(shlex.split(line))]
    assert plain, f"the help of {command} has no example that prints no comma-separated values"
    return plain[0]


_NUMBER = re.compile(r"\d[\d,]*\d(?:\.\d+)?(?:e[+-]?\d+)?|\d(?:\.\d+)?(?:e[+-]?\d+)?")


def numbers_of(value):
    """All numbers in a JSON value, those in names and texts and the lengths of lists too."""
    if isinstance(value, dict):
        return [number for name, one in value.items() for number in numbers_of(name) + numbers_of(one)]
    if isinstance(value, list):
        return [float(len(value)), *(number for one in value for number in numbers_of(one))]
    if isinstance(value, str):
        return [float(number.replace(",", "")) for number in _NUMBER.findall(value)]
    return [] if value is None or isinstance(value, bool) else [float(value)]


def rounds_to(value, printed):
    """True when ``printed`` is a number, its share in per cent or its bytes in MiB, to the digits of the text."""
    digits, _, exponent = printed.replace(",", "").partition("e")
    unit = 10.0 ** (int(exponent or 0) - len(digits.partition(".")[2]))
    return any(abs(float(printed.replace(",", "")) - value * scale) <= 0.51 * unit for scale in (1, 100, 2**-20))


@pytest.mark.parametrize("command", commands_of(build_parser()))
def test_commands_print_one_json_object(command, tmp_path, monkeypatch, capfd):
    """All numbers of the text and all files that were written, and nothing else on standard output."""
    owner, line = example_of(command)
    skip_without(command)
    monkeypatch.chdir(tmp_path)
    prepare(tmp_path, owner)
    states = {".pt": lambda: state_of(CONFIG), ".pth": lambda: generator_of(MODELS / "spikes.safetensors")}
    loaded = types.SimpleNamespace(load=lambda path, **_: states[os.path.splitext(path)[1]](), __version__="0")
    monkeypatch.setitem(sys.modules, "torch", loaded)  # a stand-in for convert
    if command in MAKERS:
        made = next(text for name, text in examples_of_help() if f" {MAKERS[command]} " in text and name == owner)
        for words in recorded(reduced(made + "\n"), tmp_path):
            run(words, monkeypatch)
    before, texts = set(files_in(tmp_path)), []
    printed = Outcome.printed
    monkeypatch.setattr(Outcome, "printed", lambda self, *rest: texts.append(self.text) or printed(self, *rest))
    (words,) = recorded(reduced(line + "\n"), tmp_path)
    capfd.readouterr()
    assert main([*words[3:], "--json"]) == 0
    found = json.loads(capfd.readouterr().out)
    assert isinstance(found, dict) and found.pop("seconds") >= 0
    written = set(found.pop("outputs"))
    made = set(files_in(tmp_path)) - before
    assert written <= made and bool(written) == bool(made), (written, made)
    known = numbers_of(found)
    assert known, "no numbers at all"
    (text,) = texts
    for number in _NUMBER.findall(text):
        assert any(rounds_to(value, number) for value in known), f"{number} of {text!r} is not in {found}"


# -- README files ------------------------------------------------------------------------------------------------------


def blocks_of(path, kind):
    text = (ROOT / path).read_text(encoding="utf-8")
    return re.findall(rf"^```{kind}\n(.*?)^```$", text, flags=re.MULTILINE | re.DOTALL)


def test_no_readme_is_forgotten():
    files = {str(path.relative_to(ROOT)) for folder in ("Examples", "Testing", "Wrapping", "Filters", "IO")
             for path in ROOT.glob(f"{folder}/**/*.md")} | {path.name for path in ROOT.glob("*.md")}  # fmt: skip
    with_examples = {path for path in files if re.search(r"^```(bash|python)", (ROOT / path).read_text(), re.MULTILINE)}
    assert with_examples == {*READMES, *ELSEWHERE}


@pytest.mark.parametrize("path", READMES)
def test_examples_of_readme_files_run(path, tmp_path, monkeypatch):
    missing = {name for name in NEEDS.values() if name and not hasattr(surfacesynthesis, name)}
    if missing:
        pytest.skip(f"built without {', '.join(sorted(missing))}")
    monkeypatch.chdir(tmp_path)
    prepare(tmp_path, path)
    for block in blocks_of(path, "bash"):
        for words in recorded(reduced(block), tmp_path):
            run(words, monkeypatch)
    for block in blocks_of(path, "python"):
        if "LoadDistributedPlugin" in block:  # ParaView's own Python, in which TestListed.py runs this
            continue
        code = reduced(block)
        exec(compile(code, path, "exec"), dict(vars(surfacesynthesis), **trainer_inputs()) if "bodies" in code else {})


def trainer_inputs():
    """The names that the Python example of trainings takes as given."""
    bodies, poses = vtkMultiBlockDataSet(), vtkMultiBlockDataSet()
    for k in range(2):
        points, triangles = icosphere(2, 50.0 + k)
        bodies.SetBlock(k, polydata_of(points, triangles))
        samples = vtkMultiBlockDataSet()
        for m in range(2):
            samples.SetBlock(m, polydata_of(points * (1.0 + 0.1 * m), triangles))
        poses.SetBlock(k, samples)
    return {"bodies": bodies, "poses": poses, "vtkFlowMatchingTrainer": surfacesynthesis.vtkFlowMatchingTrainer}


def test_all_replacements_are_of_use():
    """After the tests above, in one run of this file."""
    if not _used:
        pytest.skip("the examples have not run")
    assert _used == set(REDUCED)
