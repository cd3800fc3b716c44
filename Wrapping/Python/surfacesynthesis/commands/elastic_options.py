# SPDX-License-Identifier: BSD-3-Clause
"""Options of elastic bodies that ``dataset rest-states`` and ``settle`` share."""

#: Name, default, metavar, text.
_MATERIAL = (
    ("youngs-modulus", 1e4, "E", "Young's modulus, pascals"),
    ("poissons-ratio", 0.4, "NU", "Poisson's ratio, from 0 to 0.495"),
    ("density", 1e3, "D", "kilograms per cubic meter"),
    ("friction", 0.5, "F", "coefficient of friction on the floor"),
    ("gravity", 9.81, "G", "acceleration, meters per square second"),
)


def add_body_options(parser):
    """Adds a group for the body, its material and what surrounds it."""
    group = parser.add_argument_group("body")
    group.add_argument("--tetrahedra", metavar="FILE", help="simulate these tetrahedra: .vtu .vtk")
    group.add_argument(
        "--surface-points", type=int, default=500, metavar="N", help="points of the simulated surface (default: 500)"
    )
    group.add_argument(
        "--length-unit", type=float, metavar="M", help="meters in a unit of the file (default: diagonal of 0.5 m)"
    )
    group.add_argument(
        "--up-direction", type=float, nargs=3, default=[0.0, 0.0, 1.0], metavar="X", help="upwards (default: 0 0 1)"
    )
    add_numbers(group, _MATERIAL)
    group.add_argument("--no-self-contact", action="store_true", help="let the body pass through itself")
    group.add_argument("--no-align", action="store_true", help="do not turn rest states to the plan of the surface")


def add_numbers(group, options):
    """Adds options with numbers: rows of name, default, metavar and text."""
    for name, default, metavar, text in options:
        group.add_argument(
            f"--{name}", type=float, default=default, metavar=metavar, help=f"{text} (default: {default:.6g})"
        )


def body_of(arguments):
    """Keywords of the options of add_body_options(), all but the tetrahedra."""
    named = ["surface_points", "length_unit", "up_direction", *(name.replace("-", "_") for name, *_ in _MATERIAL)]
    options = {name: getattr(arguments, name) for name in named}
    return {**options, "self_contact": not arguments.no_self_contact, "align": not arguments.no_align}


def tetrahedra_of(arguments):
    """The dataset of --tetrahedra; None without the option."""
    from ..files import read_mesh

    return None if arguments.tetrahedra is None else read_mesh(arguments.tetrahedra)
