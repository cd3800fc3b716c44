# SPDX-License-Identifier: BSD-3-Clause
"""The command ``noise``."""

import os

from ..deprecation import add_former_option
from .common import (
    Outcome,
    UsageError,
    add_command,
    add_coupling_options,
    add_reading_options,
    add_running_options,
    as_usage,
    coupling_of,
    read_input_domain,
    read_observations,
    run_filter,
    size_of,
    size_text,
)

_DESCRIPTION = """\
Adds Matérn noise to the points of a surface, or of a volume of tetrahedra: a Gaussian random field whose statistics do
not depend on the mesh. The output is the input with one array for each sample."""
_FORMATS = """\
files: the format follows from the extension.
  .vtp .vtk .ply          keep the noise as point arrays
  .gii .glb .gltf         the same, in single precision, as triangles
  .stl .obj .off          keep the shape only: use --warp
  .vtu (.vtk)             unstructured grids: volumes of tetrahedra, as the command tetrahedralize makes them
  .vtm (.vtk)             composite datasets, processed block by block
"""
_EXAMPLES = (
    _FORMATS
    + """
examples:
  %(prog)s in.stl out.vtp --range 5 --samples 8
  %(prog)s in.ply bumpy.stl --range 5 --warp 0.3
  %(prog)s in.vtu out.vtu --range 25 --variance-correction
  %(prog)s in.off out.vtp --components 3 --standard-deviation 0.2 --seed 7
  %(prog)s bone.vtp out.vtp --displacement free --observations landmarks.vtp --observation-array Displacement
"""
)


def add(commands):
    """Adds the command to the parser."""
    parser = add_command(
        commands, "noise", "INPUT OUTPUT", "add Matérn noise to a surface or volume", _DESCRIPTION, _EXAMPLES
    )
    parser.set_defaults(run=run)
    parser.add_argument("input", metavar="INPUT", help="surface or volume to read: .stl .ply .obj .off .gii .glb .vtp .vtu .vtk .vtm")
    parser.add_argument("output", metavar="OUTPUT", help="file to write: the same formats")

    scale = parser.add_argument_group("scale").add_mutually_exclusive_group()
    scale.add_argument(
        "--range",
        type=float,
        metavar="R",
        help="distance, in units of the mesh, at which the correlation of two points has fallen to about 0.14; larger "
        "is smoother (default: 0.2 times the longest side of the bounding box)",
    )
    scale.add_argument(
        "--screening",
        type=float,
        metavar="TAU",
        help="screening term tau = 8 (ALPHA - 1) / R^2, in volumes 8 (ALPHA - 3/2) / R^2, in 1 / square units of the mesh",
    )
    scale.add_argument(
        "--normalized-screening",
        type=float,
        metavar="C",
        help="tau relative to the spectrum of the triangulation: the same for a mesh of any size",
    )

    noise = parser.add_argument_group("noise")
    deviation = noise.add_argument(
        "--standard-deviation", type=float, default=1.0, metavar="S", help="standard deviation (default: 1)"
    )
    model = noise.add_argument(
        "--noise-model",
        default="matern",
        choices=["matern", "per_vertex", "white", "unscreened", "spectral"],
        metavar="MODEL",
        help="matern (default) or, for comparison, per_vertex, white, unscreened, spectral",
    )
    noise.add_argument("--seed", type=int, default=0, metavar="N", help="any integer of 32 bits (default: 0)")
    noise.add_argument("--samples", type=int, metavar="N", help="number of samples (default: 1)")
    noise.add_argument("--first-sample", type=int, default=0, metavar="K", help="index of the first (default: 0)")
    noise.add_argument(
        "--memory-limit", type=int, metavar="MIB", help="memory of the output, MiB (default: 3/4 of the machine's)"
    )
    noise.add_argument("--components", type=int, default=1, metavar="C", help="components per sample (default: 1)")
    noise.add_argument(
        "--displacement",
        default="no_displacement",
        choices=["no_displacement", "free", "normal", "tangential"],
        metavar="DIRECTIONS",
        help="noise that displaces the surface, in its units: free, normal, tangential (default: no_displacement)",
    )
    noise.add_argument(
        "--eigenpairs", type=int, default=256, metavar="K", help="eigenpairs of the noise model spectral (default: 256)"
    )

    noise.add_argument(
        "--no-gather-pieces",
        action="store_false",
        dest="gather_pieces",
        help="solve on a surface in pieces on several MPI ranks where they lie",
    )
    noise.add_argument(
        "--coherent-noise",
        action="store_true",
        help="noise that belongs to places in space: the same on all triangulations of one surface",
    )
    add_coupling_options(noise)
    _add_field_options(parser)
    _add_observation_options(parser)

    output = parser.add_argument_group("output")
    output.add_argument("--name", default="MaternNoise", metavar="NAME", help="name of the array (default: %(default)s)")
    output.add_argument(
        "--warp",
        type=float,
        metavar="SCALE",
        help="move the points by SCALE times the noise, along the normals or, with --components 3 or --displacement, along the "
        "noise itself; with several samples, OUTPUT_0, OUTPUT_1, ... are written",
    )
    output.add_argument(
        "--moved-points", action="store_true", help="move the points by the displacement, and keep it as an array"
    )
    add_running_options(output)
    add_reading_options(parser)
    add_former_option(parser, "--std", deviation)
    add_former_option(parser, "--model", model)


def _add_field_options(parser):
    """Options of operator, boundary and arrays."""
    field = parser.add_argument_group("field")
    field.add_argument(
        "--operator-power",
        type=float,
        default=2.0,
        metavar="ALPHA",
        help="power of the operator, 1 to 4, such as 2.5; larger is smoother (default: 2); 1 needs --screening",
    )
    field.add_argument(
        "--variance-correction", action="store_true", help="the standard deviation is exact at every point"
    )
    field.add_argument(
        "--boundary-condition",
        default="neumann",
        choices=["neumann", "dirichlet", "robin"],
        metavar="CONDITION",
        help="condition at open boundaries: neumann (default), dirichlet, robin",
    )
    field.add_argument("--robin-coefficient", type=float, metavar="C", help="coefficient of robin (default: 0.55)")
    field.add_argument(
        "--boundary-array", metavar="NAME", help="point array, not 0 where the boundary condition holds (default: boundary)"
    )
    field.add_argument("--range-factor-array", metavar="NAME", help="point array of factors of the range")
    field.add_argument("--direction-array", metavar="NAME", help="point array of vectors along which the noise is stretched")
    field.add_argument(
        "--anisotropy-ratio", type=float, metavar="RATIO", help="range along the directions over that across (default: 4)"
    )
    field.add_argument("--barrier-array", metavar="NAME", help="cell array, not 0 in barriers")


def _add_observation_options(parser):
    """The options of observations."""
    given = parser.add_argument_group("observations")
    given.add_argument(
        "--observations",
        metavar="FILE",
        help="points near the surface, or in the volume, at which the noise is known: .vtp .vtk .ply; the samples follow them",
    )
    given.add_argument(
        "--observation-array", metavar="NAME", help="their point array with the values (default: the active scalars)"
    )
    given.add_argument(
        "--observation-deviation-array",
        metavar="NAME",
        help="their point array with the standard deviations of the values (default: 0)",
    )
    given.add_argument(
        "--tolerance",
        type=float,
        metavar="D",
        help="largest distance of an observation from the surface (default: a hundredth of the longest side of its box)",
    )
    given.add_argument("--posterior-mean", action="store_true", help="add the mean given the observations, NAME_Mean")
    given.add_argument(
        "--posterior-standard-deviation",
        action="store_true",
        help="add the standard deviation given the observations, NAME_StandardDeviation",
    )
    given.add_argument(
        "--observed-targets",
        action="store_true",
        help="with --displacement: their values are positions that the surface is to pass through, not displacements",
    )


def run(arguments):
    """The command ``noise``."""
    from .. import files
    from ..noise import array_names

    _check_output(arguments, files)
    noise = _filter_of(arguments)
    mesh = read_input_domain(arguments)
    if arguments.warp is not None and mesh.IsA("vtkUnstructuredGrid"):
        raise UsageError("--warp moves the points of a surface, not of an unstructured grid")
    as_usage(files.check_writable, mesh, arguments.output)
    output = run_filter(noise, mesh, arguments)
    written = _outputs(output, arguments, array_names(noise))
    files.write_meshes(written)
    return _outcome(noise, output, [path for _, path in written])


def _filter_of(arguments):
    from ..noise import configured_filter

    return as_usage(
        configured_filter,
        range=arguments.range,
        standard_deviation=arguments.standard_deviation,
        seed=arguments.seed,
        samples=arguments.samples,
        first_sample=arguments.first_sample,
        components=arguments.components,
        screening=arguments.screening,
        normalized_screening=arguments.normalized_screening,
        noise_model=arguments.noise_model,
        eigenpairs=arguments.eigenpairs,
        name=arguments.name,
        memory_limit=arguments.memory_limit,
        operator_power=arguments.operator_power,
        variance_correction=arguments.variance_correction,
        boundary_condition=arguments.boundary_condition,
        robin_coefficient=arguments.robin_coefficient,
        boundary_array=arguments.boundary_array,
        range_factor_array=arguments.range_factor_array,
        direction_array=arguments.direction_array,
        anisotropy_ratio=arguments.anisotropy_ratio,
        barrier_array=arguments.barrier_array,
        gather_pieces=arguments.gather_pieces,
        coherent_noise=arguments.coherent_noise,
        **coupling_of(arguments),
        observations=read_observations(arguments),
        observation_array=arguments.observation_array,
        observation_deviation_array=arguments.observation_deviation_array,
        tolerance=arguments.tolerance,
        posterior_mean=arguments.posterior_mean,
        posterior_standard_deviation=arguments.posterior_standard_deviation,
        displacement=arguments.displacement,
        moved_points=arguments.moved_points,
        observed_targets=arguments.observed_targets,
    )


def _check_output(arguments, files):
    """Refuses an output that cannot hold the noise, before anything is read."""
    as_usage(files.extension, arguments.input)
    kind = as_usage(files.extension, arguments.output)
    if arguments.warp is None and kind in files.GEOMETRY_ONLY and not arguments.moved_points:
        raise UsageError(
            f"{kind} files cannot hold the noise: write .vtp, .vtk or .ply, or move the points with --warp SCALE"
        )
    if arguments.warp is not None and arguments.moved_points:
        raise UsageError("--warp and --moved-points exclude each other: both move the points")
    if arguments.warp is not None and not abs(arguments.warp) < float("inf"):
        raise UsageError(f"--warp must be a finite number, not {arguments.warp:g}")
    if arguments.warp is not None and arguments.components not in (1, 3):
        raise UsageError(f"--warp needs 1 or 3 components, not {arguments.components}")


def _outputs(output, arguments, names):
    """Pairs of data and file to write: one or, for several samples of a displacement, one for each."""
    from ..warp import warped

    if arguments.warp is None:
        return [(output, arguments.output)]
    if len(names) == 1:
        return [(warped(output, names[0], arguments.warp), arguments.output)]
    stem, kind = os.path.splitext(arguments.output)
    numbers = range(arguments.first_sample, arguments.first_sample + len(names))
    return [(warped(output, name, arguments.warp), f"{stem}_{k}{kind}") for name, k in zip(names, numbers)]


def _outcome(noise, output, paths):
    """The outcome; what the noise model has not is no part of the text, and null in JSON."""
    screening, correlation_range = noise.GetEffectiveScreening(), noise.GetEffectiveCorrelationRange()
    residual, iterations = noise.GetRelativeResidual(), noise.GetNumberOfIterations()
    parts = [size_text(output)]
    if screening > 0:
        parts.append(f"tau {screening:.4g}")
        parts.append(f"range {correlation_range:.4g}")
    if residual > 0:
        parts.append(f"residual {residual:.1e}")
    if iterations > 0:
        parts.append(f"{iterations} iterations of multigrid")
    values = {
        "samples": noise.GetNumberOfSamples(),
        "effective_screening": screening if screening > 0 else None,
        "effective_correlation_range": correlation_range if screening > 0 else None,
        "relative_residual": residual if residual > 0 else None,
        "iterations": iterations if iterations > 0 else None,
    }
    return Outcome(", ".join(parts), {**size_of(output), **values}, paths)
