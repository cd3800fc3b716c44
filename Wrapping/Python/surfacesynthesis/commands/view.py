# SPDX-License-Identifier: BSD-3-Clause
"""The command ``view``."""

import os

from .common import Outcome, UsageError, add_command, add_reading_options, add_running_options, as_usage, read_input, size_of

_DESCRIPTION = """\
Writes one HTML page that shows a surface and its arrays in a browser, offline, to turn and to color: for sending a result
by mail."""
_EPILOG = """\
The page holds vtk.js, which npm brings (Debian: apt install npm); where it is not found, the command says how to get it.
Points and values are quantized to 16 bits. What the page shows first may be added to its address, after a #:
page.html#array=MaternNoise&component=0&map=Plasma&up=y. The axis upwards is z, or that of up: x, y, -x, -y or -z.

examples:
  %(prog)s result.vtp -o page.html
  %(prog)s result.vtp -o page.html --color-by MaternNoise --title "Sample 1"
"""


def add(commands):
    """Adds the command to the parser."""
    parser = add_command(commands, "view", "INPUT -o PAGE", "write a page that shows a surface", _DESCRIPTION, _EPILOG)
    parser.set_defaults(run=run)
    parser.add_argument(
        "input", metavar="INPUT", help="mesh to read: .stl .ply .obj .off .gii .glb .vtp .vtu .vtk .vtm; of .vtu the surface"
    )
    page = parser.add_argument_group("page")
    page.add_argument("-o", "--output", required=True, metavar="PAGE", help="page to write: .html")
    page.add_argument("--color-by", metavar="NAME", help="array that is shown first (default: the active scalars)")
    page.add_argument("--title", metavar="TEXT", help="title of the page (default: the name of INPUT)")
    page.add_argument("--vtk-js", metavar="FILE", help="the file vtk.js of npm's package vtk.js (default: looked for)")
    add_running_options(page)
    add_reading_options(parser)


def run(arguments):
    """The command ``view``."""
    from ..pages import write_page

    if not arguments.output.lower().endswith((".html", ".htm")):
        raise UsageError(f"{arguments.output}: a page ends with .html")
    mesh = read_input(arguments)
    title = arguments.title if arguments.title is not None else os.path.basename(arguments.input)
    as_usage(write_page, mesh, arguments.output, color_by=arguments.color_by, title=title, vtk_js=arguments.vtk_js)
    size = os.path.getsize(arguments.output)
    return Outcome(f"{size / 2**20:.1f} MiB", {"bytes": size, **size_of(mesh)}, [arguments.output])
