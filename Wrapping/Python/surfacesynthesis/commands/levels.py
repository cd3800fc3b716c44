# SPDX-License-Identifier: BSD-3-Clause
"""The command ``levels``."""

from ..deprecation import add_former_option
from .common import Outcome, add_command, add_running_options, as_usage, read_single_surface, run_filter

_DESCRIPTION = """\
Makes meshes of one surface at several scales, which the command "train geometric-texture" learns a texture from: a
template of the same topology is fitted to the surface, subdivided, fitted again, and so on."""
_EPILOG = """\
OUTPUT is a dataset file (.safetensors).

examples:
  %(prog)s bark.ply bark-levels.safetensors
  %(prog)s ring.ply ring-levels.safetensors --template torus --levels 4
  %(prog)s hand.ply hand-levels.safetensors --template coarse-hand.ply
  %(prog)s scan.ply scan-levels.safetensors --template surface --template-triangles 320
"""
_NUMBERS = (
    ("levels", int, 5, "N", "number of levels, 1 to 10"),
    ("icosphere-level", int, 2, "N", "how often the triangles of the icosahedron are cut into four, 0 to 6"),
    ("torus-segments", int, 24, "N", "pairs of triangles around the axis of the torus, 3 to 1000"),
    ("template-triangles", int, 320, "N", "triangles of the template surface, 4 to 1000000"),
    ("iterations", int, 300, "N", "iterations at each level; for the template surface rounds of relaxation"),
    ("triangulation-steps", int, 3, "N", "steps in each that keep triangles even"),
    ("chamfer-steps", int, 2, "N", "steps in each that bring the surfaces closer"),
    ("learning-rate", float, 1e-2, "R", "of Adam, in mean edge lengths of the template, halved with each level"),
    ("learning-rate-decay", float, 0.1, "R", "that of a level's last iteration over that of its first, 1e-6 to 1"),
    ("surface-samples", int, 3000, "N", "samples on each surface at level 0"),
    ("time-budget", float, 0.0, "M", "minutes of the whole fit, 0: no limit"),
    ("seed", int, 0, "N", "any integer of 32 bits"),
)


def add(commands):
    """Adds the command to the parser."""
    parser = add_command(
        commands, "levels", "REFERENCE OUTPUT", "fit meshes at several scales to a surface", _DESCRIPTION, _EPILOG
    )
    parser.set_defaults(run=run)
    parser.add_argument("reference", metavar="REFERENCE", help="surface to read: .stl .ply .obj .off .gii .glb .vtp .vtk")
    parser.add_argument("output", metavar="OUTPUT", help="dataset file to write (safetensors)")
    parser.add_argument(
        "--template",
        default="icosphere",
        metavar="WHAT",
        help="what is fitted: icosphere (default), torus, surface (made from REFERENCE, of any topology), or a file",
    )
    fit = parser.add_argument_group("fit")
    for name, kind, default, metavar, text in _NUMBERS:
        option = fit.add_argument(
            f"--{name}", type=kind, default=default, metavar=metavar, help=f"{text} (default: %(default)s)"
        )
        if name == "surface-samples":
            add_former_option(parser, "--samples", option)
    fit.add_argument(
        "--smoothing-length",
        type=float,
        metavar="L",
        help="length that the template surface is smoothed with (default: half of its mean edge length)",
    )
    fit.add_argument("--published-normals", action="store_true", help="compare normals as in the published code")
    add_running_options(parser.add_argument_group("running"))


def run(arguments):
    """The command ``levels``."""
    from ..geometric_texture_training import TEMPLATES, configured_fitter, fitted_levels

    template = arguments.template
    if template not in TEMPLATES:
        template = read_single_surface(template)
    numbers = {name.replace("-", "_"): getattr(arguments, name.replace("-", "_")) for name, *_ in _NUMBERS}
    algorithm = as_usage(
        configured_fitter,
        template=template,
        smoothing_length=arguments.smoothing_length,
        published_normals=arguments.published_normals,
        dataset=arguments.output,
        **numbers,
    )
    reference = read_single_surface(arguments.reference)
    run_filter(algorithm, reference, arguments)
    fit = fitted_levels(algorithm)
    distances = ", ".join(f"{distance:.3g}" for distance in fit.mean_distances)
    triangles = fit.levels[-1].GetNumberOfPolys()
    values = {
        "levels": len(fit.levels),
        "triangles": triangles,
        "mean_distances": fit.mean_distances,
        "symmetric_mean_distances": fit.symmetric_mean_distances,
        "symmetric_percentiles_95": fit.symmetric_percentiles_95,
        "mean_normal_angles": fit.mean_normal_angles,
        "self_intersections": fit.self_intersections,
    }
    text = f"{len(fit.levels)} levels, {triangles:,} triangles, mean distances {distances}" + _finest(fit)
    return Outcome(text, values, [arguments.output])


def _finest(fit):
    """Text about the distance of the finest level in both directions."""
    if not fit.levels:
        return ""
    lines = [
        f"\nfinest level, both directions: mean distance {fit.symmetric_mean_distances[-1]:.3g}, "
        f"95th percentile {fit.symmetric_percentiles_95[-1]:.3g}, angle of normals {fit.mean_normal_angles[-1]:.1f} degrees"
    ]
    if fit.self_intersections[-1] is not None:
        lines.append(f"{fit.self_intersections[-1]:,} self-intersections")
    return ", ".join(lines)
