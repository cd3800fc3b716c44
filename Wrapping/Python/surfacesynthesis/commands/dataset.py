# SPDX-License-Identifier: BSD-3-Clause
"""The command ``dataset``: many samples of a signal on a surface, or images and planar meshes, in a file to train with."""

import importlib.util
import math
import sys

from .. import vtkSurfaceSynthesisEnsembles as _ensembles
from .. import vtkSurfaceSynthesisMeshing as _meshing
from ..deprecation import add_former_option
from . import dataset_surfaces
from .common import (
    PROGRAM,
    Outcome,
    ProgressBar,
    UsageError,
    add_command,
    add_running_options,
    as_usage,
    read_single_surface,
    set_threads,
)
from .elastic_options import add_body_options, add_numbers, body_of, tetrahedra_of
from .field_latents import color_of, textured_input
from .train_latent_diffusion import add_surface_options, surface_parameters

_DESCRIPTION = """\
Makes data to train and to test flow matching with: a file (.safetensors) with a surface and many samples of a signal on
it. Sample K depends on the seed and on K only, so parts of an ensemble can be made one by one. textures makes the data
that field latents are trained on, latents that of new textures. export makes surfaces of a file, which ParaView and other
commands read, and import a file of surfaces."""
_EXAMPLES = """\
examples:
  %(prog)s poses armadillo.off poses.safetensors --samples 3000 --points 1500 --template armadillo.off
  %(prog)s mixtures bunny.off mixtures.safetensors --samples 3000 --points 2000
  %(prog)s rest-states bunny.off rest.safetensors --samples 2000 --candidates 3000 --points 2000
  %(prog)s mixtures bunny.off test.safetensors --samples 500 --first-sample 100000
  %(prog)s export poses.safetensors poses.vtm --samples 20
  %(prog)s import patient_*.vtp patients.safetensors
  %(prog)s textures brick.png grass.png textures.safetensors --meshes 8
  %(prog)s latents duck.obj bark-latents.safetensors --autoencoder latents.safetensors --points 5000 --triangulations 64
"""
_LATENTS = """\
A textured surface, remeshed many times, and the field latents of its texture on each triangulation, for train
latent-diffusion and surfacesynthesis-train."""
_POSES = """\
Random poses of a connected surface: its extremities turn about their joints, the part near its centroid stays and the rest
follows as rigidly as possible. Lengths are fractions of the square root of the area."""
_REST_STATES = """\
Shapes in which a soft body comes to rest after random drops on a floor. The surface is closed; it is remeshed and filled
with tetrahedra for the simulation, and its own points follow. Quantities are in SI units."""
_MIXTURES = """\
Random mixtures of Gaussians of the distance along the surface from a few centres. Lengths are fractions of the square
root of the area."""
_TEXTURES = """\
Tiles of images, and random planar meshes to lay over them: farthest-point samples of the unit square and their Delaunay
triangulation."""


def add(commands):
    """Adds the command to the parser."""
    parser = add_command(
        commands, "dataset", "SIGNAL INPUT OUTPUT", "make data for trainings", _DESCRIPTION, _EXAMPLES
    )
    signals = parser.add_subparsers(
        title="signals", metavar="SIGNAL", required=True, prog=f"python3 -m {PROGRAM} dataset"
    )
    if hasattr(_ensembles, "vtkPoseEnsembleFilter"):
        _add_poses(signals)
    _add_mixtures(signals)
    _add_rest_states(signals)
    _add_textures(signals)
    if importlib.util.find_spec("..vtkSurfaceSynthesisTraining", __package__):  # found without loading LibTorch
        _add_latents(signals)
    dataset_surfaces.add(signals)


def _add_signal(signals, name, help, description):
    parser = add_command(signals, name, "INPUT OUTPUT", help, description, parent="dataset")
    parser.add_argument("input", metavar="INPUT", help="surface to read: .stl .ply .obj .off .gii .glb .vtp .vtk")
    parser.add_argument("output", metavar="OUTPUT", help="file to write: .safetensors")
    samples = parser.add_argument_group("samples")
    samples.add_argument("--samples", type=int, default=1000, metavar="N", help="number of samples (default: 1000)")
    samples.add_argument("--seed", type=int, default=0, metavar="N", help="any integer of 32 bits (default: 0)")
    samples.add_argument("--first-sample", type=int, default=0, metavar="K", help="index of the first (default: 0)")
    samples.add_argument(
        "--memory-limit", type=int, metavar="MIB", help="memory of the samples, MiB (default: 3/4 of the machine's)"
    )
    if hasattr(_meshing, "vtkIsotropicRemeshFilter"):
        points = samples.add_argument("--points", type=int, metavar="V", help="remesh evenly to about V points first")
        add_former_option(parser, "--vertices", points)
    return parser


def _add_poses(signals):
    parser = _add_signal(signals, "poses", "random poses of a shape", _POSES)
    parser.set_defaults(run=run_poses)
    shape = parser.add_argument_group("shape")
    shape.add_argument("--template", metavar="FILE", help="find the extremities on this triangulation of the shape")
    shape.add_argument("--handles", type=int, default=6, metavar="N", help="number of extremities (default: 6)")
    shape.add_argument(
        "--handle-radius", type=float, default=0.08, metavar="R", help="radius of the rigid extremities (default: 0.08)"
    )
    shape.add_argument(
        "--anchor-radius", type=float, default=0.12, metavar="R", help="radius of the fixed part (default: 0.12)"
    )
    shape.add_argument(
        "--pivot-position", type=float, default=0.8, metavar="P", help="joint: 0 extremity, 1 fixed part (default: 0.8)"
    )
    motion = parser.add_argument_group("motion")
    angle = motion.add_argument(
        "--maximum-angle", type=float, default=60.0, metavar="A", help="largest angle at a joint, degrees (default: 60)"
    )
    twist = motion.add_argument(
        "--maximum-twist", type=float, default=20.0, metavar="A", help="largest twist of a limb, degrees (default: 20)"
    )
    motion.add_argument(
        "--stiffness", type=float, default=2e-4, metavar="S", help="resistance to bending (default: 0.0002)"
    )
    motion.add_argument("--iterations", type=int, default=40, metavar="N", help="iterations of each pose (default: 40)")
    add_running_options(motion)
    add_former_option(parser, "--angle", angle)
    add_former_option(parser, "--twist", twist)


def _add_mixtures(signals):
    parser = _add_signal(signals, "mixtures", "random mixtures of Gaussians", _MIXTURES)
    parser.set_defaults(run=run_mixtures)
    mixture = parser.add_argument_group("mixtures")
    centers = mixture.add_argument(
        "--centers", type=int, default=3, metavar="N", help="Gaussians in each mixture (default: 3)"
    )
    width = mixture.add_argument(
        "--gaussian-width", type=float, default=0.08, metavar="W", help="standard deviation of each (default: 0.08)"
    )
    mixture.add_argument(
        "--separation",
        type=float,
        default=4.0,
        metavar="D",
        help="least distance of centres, in standard deviations (default: 4)",
    )
    add_running_options(mixture)
    add_former_option(parser, "--centres", centers)
    add_former_option(parser, "--width", width)


#: Options of drops: name, default, metavar, text.
_DROP_OPTIONS = (
    ("damping", 0.5, "C", "loss of momentum by the air, per second"),
    ("drop-height", 0.1, "H", "height above the floor at the beginning, meters"),
    ("minimum-spin", math.pi, "W", "least angular speed at the beginning, radians per second"),
    ("maximum-spin", 3.0 * math.pi, "W", "largest angular speed at the beginning, radians per second"),
    ("time-step", 0.04, "S", "largest time step, seconds"),
    ("maximum-time", 10.0, "S", "simulated time after which a body creeps to its equilibrium, seconds"),
)


def _add_rest_states(signals):
    parser = _add_signal(signals, "rest-states", "rest states of a soft body", _REST_STATES)
    parser.set_defaults(run=run_rest_states)
    add_body_options(parser)
    drop = parser.add_argument_group("drop")
    add_numbers(drop, _DROP_OPTIONS)
    drop.add_argument("--no-random-orientation", action="store_true", help="begin with the orientation of the file")
    drop.add_argument(
        "--candidates", type=int, metavar="N", help="drop N times, and keep the samples farthest from each other"
    )
    add_running_options(drop)


def _add_textures(signals):
    parser = add_command(
        signals,
        "textures",
        "IMAGE [IMAGE ...] OUTPUT",
        "images and planar meshes for field latents",
        _TEXTURES,
        parent="dataset",
    )
    parser.add_argument("images", metavar="IMAGE", nargs="+", help="image to read: .png .jpg .tif .bmp")
    parser.add_argument("output", metavar="OUTPUT", help="file to write: .safetensors")
    data = parser.add_argument_group("data")
    for name, default, metavar, text in (
        ("tile", 512, "PIXELS", "largest height and width of a tile"),
        ("side", 1024, "PIXELS", "largest shorter side of an image, which is reduced to it"),
        ("tiles", 4, "N", "largest number of tiles of an image"),
        ("meshes", 64, "N", "number of planar meshes"),
        ("mesh-points", 2500, "V", "number of points of a mesh"),
        ("seed", 0, "N", "any integer of 32 bits"),
    ):
        data.add_argument(f"--{name}", type=int, default=default, metavar=metavar, help=f"{text} (default: {default})")
    add_running_options(data)
    parser.set_defaults(run=run_textures)


def _add_latents(signals):
    parser = add_command(
        signals,
        "latents",
        "SURFACE OUTPUT",
        "a textured surface, remeshed and encoded, for latent diffusion",
        _LATENTS,
        parent="dataset",
    )
    parser.add_argument("input", metavar="SURFACE", help="textured surface to read: .obj .gltf .glb .ply .vtp")
    parser.add_argument("output", metavar="OUTPUT", help="file to write: .safetensors")
    data = parser.add_argument_group("data")
    add_surface_options(data)
    data.add_argument("--seed", type=int, default=0, metavar="N", help="any integer of 32 bits (default: 0)")
    add_running_options(data)
    parser.set_defaults(run=run_latents)


def run_poses(arguments):
    """The command ``dataset poses``."""
    from ..poses import configured_poses, poses

    options = {
        "handles": arguments.handles,
        "maximum_angle": arguments.maximum_angle,
        "maximum_twist": arguments.maximum_twist,
        "handle_radius": arguments.handle_radius,
        "anchor_radius": arguments.anchor_radius,
        "pivot_position": arguments.pivot_position,
        "iterations": arguments.iterations,
        "stiffness": arguments.stiffness,
    }
    as_usage(configured_poses, seed=arguments.seed, **options)

    def make(mesh, **running):
        template = None if arguments.template is None else read_single_surface(arguments.template)
        return poses(mesh, template=template, **options, **running)

    return _run(arguments, "Position", make)


def run_mixtures(arguments):
    """The command ``dataset mixtures``."""
    from ..gaussian_mixtures import configured_mixtures, gaussian_mixtures

    options = {name: getattr(arguments, name) for name in ("centers", "gaussian_width", "separation")}
    as_usage(configured_mixtures, seed=arguments.seed, **options)
    return _run(arguments, "Mixture", lambda mesh, **running: gaussian_mixtures(mesh, **options, **running))


def run_rest_states(arguments):
    """The command ``dataset rest-states``."""
    from ..arguments import integer
    from ..rest_states import configured_rest_states, rest_states
    from ..sampling import farthest_samples

    options = {name.replace("-", "_"): getattr(arguments, name.replace("-", "_")) for name, *_ in _DROP_OPTIONS}
    options.update(body_of(arguments), random_orientation=not arguments.no_random_orientation)
    as_usage(configured_rest_states, seed=arguments.seed, **options)
    candidates = arguments.candidates
    if candidates is not None:
        as_usage(integer, "candidates", candidates, arguments.samples)

    def make(mesh, samples, **running):
        states = rest_states(mesh, candidates or samples, tetrahedra=tetrahedra_of(arguments), **options, **running)
        return states if candidates is None else states[farthest_samples(states, samples)]

    return _run(arguments, "Position", make)


def run_textures(arguments):
    """The command ``dataset textures``."""
    from ..texture_datasets import checked_options, texture_dataset

    options = {name: getattr(arguments, name) for name in ("tile", "side", "tiles", "meshes", "mesh_points", "seed")}
    as_usage(checked_options, **options)
    _require_dataset_name(arguments.output)
    set_threads(arguments.threads)
    bar = ProgressBar(sys.stderr, not (arguments.no_progress or arguments.quiet))
    try:
        made = texture_dataset(arguments.output, arguments.images, **options, progress=bar)
    finally:
        bar.clear()
    counts = {"tiles": len(made.images), "meshes": len(made.meshes)}
    return Outcome(f"{len(made.images):,} tiles, {len(made.meshes):,} meshes", counts, [arguments.output])


def run_latents(arguments):
    """The command ``dataset latents``."""
    from ..latent_diffusion_training import latent_dataset

    _require_dataset_name(arguments.output)
    mesh, image = textured_input(arguments)
    set_threads(arguments.threads)
    bar = ProgressBar(sys.stderr, not (arguments.no_progress or arguments.quiet))
    options = {"color": color_of(mesh) if image is None else None, **surface_parameters(arguments)}
    try:
        as_usage(latent_dataset, arguments.output, mesh, image, seed=arguments.seed, progress=bar, **options)
    finally:
        bar.clear()
    counts = {"triangulations": arguments.triangulations}
    return Outcome(f"{arguments.triangulations:,} triangulations", counts, [arguments.output])


def _require_dataset_name(path):
    if not path.endswith(".safetensors"):
        raise UsageError(f"{path}: datasets are .safetensors files")


def _run(arguments, signal, make):
    """Reads the surface, makes the samples and writes the file."""
    from .. import files, remeshing, sampling
    from ..signal_datasets import write_signal_dataset

    as_usage(files.extension, arguments.input)
    as_usage(sampling.checked_range, arguments.samples, arguments.first_sample)
    _require_dataset_name(arguments.output)
    number_of_points = getattr(arguments, "points", None)
    if number_of_points is not None:
        as_usage(remeshing.configured_remesh, points=number_of_points)
    set_threads(arguments.threads)
    mesh = read_single_surface(arguments.input)
    if number_of_points is not None:
        mesh = remeshing.remesh(mesh, points=number_of_points, feature_angle=None)
    bar = ProgressBar(sys.stderr, not (arguments.no_progress or arguments.quiet))
    try:
        samples = make(
            mesh,
            samples=arguments.samples,
            seed=arguments.seed,
            first_sample=arguments.first_sample,
            progress=bar,
            memory_limit=arguments.memory_limit,
        )
    finally:
        bar.clear()
    write_signal_dataset(arguments.output, [(mesh, samples)], signal)
    counts = {"signal": signal, "samples": len(samples), "points": samples.shape[1]}
    return Outcome(f"{len(samples):,} samples on {samples.shape[1]:,} points", counts, [arguments.output])
