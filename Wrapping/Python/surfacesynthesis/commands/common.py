# SPDX-License-Identifier: BSD-3-Clause
"""Shared by all commands: options, the progress bar, wrong usage."""

import argparse
import math
import sys
import time
import typing
import warnings

PROGRAM = "surfacesynthesis"


class Outcome(typing.NamedTuple):
    """Result of the function run() of a command: a text about what was done, the values that --json prints, the files
    that were written, the exit status, and with --csv a table, which is printed as it is."""

    text: str
    values: dict
    outputs: typing.Sequence[str] = ()
    status: int = 0
    table: typing.Optional[str] = None

    def printed(self, arguments, seconds):
        """Text that the command prints after so many seconds; with --json one object."""
        from ..results import json_text

        if arguments.json:
            return json_text({**self.values, "seconds": seconds, "outputs": list(self.outputs)})
        if self.table is not None:
            return self.table
        if not self.outputs:
            return self.text
        shown = self.outputs[0] if len(self.outputs) == 1 else f"{self.outputs[0]} ... {self.outputs[-1]}"
        return f"{self.text}, {seconds:.1f} s -> {shown}"


class UsageError(Exception):
    """Wrong usage of a command; exit status 2."""


class ProgressBar:
    """A bar on a terminal, with the time that is left when the work takes longer than some seconds; nothing anywhere else."""

    WIDTH = 40
    #: Seconds of work after which the time left is shown.
    PATIENCE = 3.0

    def __init__(self, stream, wanted, clock=time.monotonic):
        self._stream = stream if wanted and stream.isatty() else None
        self._clock = clock
        self._started = clock()
        self._shown = None
        self._length = 0

    def __call__(self, fraction):
        if self._stream is None:
            return
        fraction = min(max(fraction, 0.0), 1.0)
        text = f"{int(100 * fraction):3d} %{self._time_left(fraction)}"
        if text == self._shown:
            return
        self._shown = text
        done = int(self.WIDTH * fraction)
        line = f"[{'#' * done}{' ' * (self.WIDTH - done)}] {text}"
        self._stream.write("\r" + line.ljust(self._length))
        self._stream.flush()
        self._length = len(line)

    def _time_left(self, fraction):
        """", 0:42 left" at the pace so far; "" in the first seconds, and at the end."""
        elapsed = self._clock() - self._started
        if elapsed < self.PATIENCE or not 0.01 < fraction < 1.0:
            return ""
        seconds = math.ceil(elapsed * (1.0 - fraction) / fraction)
        minutes = f"{seconds // 3600}:{seconds // 60 % 60:02d}" if seconds >= 3600 else f"{seconds // 60}"
        return f", {minutes}:{seconds % 60:02d} left"

    def clear(self):
        """Takes the bar off the terminal."""
        if self._shown is not None:
            self._stream.write("\r" + " " * self._length + "\r")
            self._stream.flush()
            self._shown = None


class TrainingBar(ProgressBar):
    """A bar with the progress text of the filter beside it: the iteration, the loss, the time left."""

    def __init__(self, stream, wanted, algorithm):
        super().__init__(stream, wanted)
        self._algorithm = algorithm
        self._written = 0.0
        self._length = 0

    def __call__(self, fraction):
        now = time.monotonic()
        if self._stream is None or (now - self._written < 0.2 and fraction < 1.0):
            return
        self._written = now
        width = self.WIDTH // 2
        done = int(width * min(max(fraction, 0.0), 1.0))
        text = f"[{'#' * done}{' ' * (width - done)}] {self._algorithm.GetProgressText() or 'preparing'}"
        self._shown = fraction
        self._stream.write("\r" + text.ljust(self._length))
        self._stream.flush()
        self._length = len(text)

    def clear(self):
        if self._shown is not None:
            self._stream.write("\r" + " " * self._length + "\r")
            self._stream.flush()
            self._shown = None


def add_command(commands, name, files, help, description, epilog=None, parent=None):
    """Adds a command, or one of the command ``parent``, and returns its parser. ``files`` are the positional arguments in the
    usage line."""
    words = name if parent is None else f"{parent} {name}"
    return commands.add_parser(
        name,
        help=help,
        usage=f"python3 -m {PROGRAM} {words} {files} [options]",
        description=description,
        epilog=epilog,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )


def add_running_options(group, csv=None):
    """The options about how a command runs, which all commands but those without data have, and those of
    add_printing_options(), whose result it returns."""
    group.add_argument("--threads", type=int, metavar="N", help="number of threads (default: VTK's)")
    group.add_argument("--no-progress", action="store_true", help="show no progress bar")
    return add_printing_options(group, csv)


def add_printing_options(group, csv=None):
    """The options about what a command prints, which all commands have; --csv where ``csv`` says of what. Returns the group
    of the forms that exclude each other."""
    forms = group.add_mutually_exclusive_group()
    if csv is not None:
        forms.add_argument("--csv", action="store_true", help=f"print {csv} as comma-separated values")
    forms.add_argument("--json", action="store_true", help="print one JSON object: results, seconds, files written")
    group.add_argument("--quiet", action="store_true", help="print errors only")
    return forms


def result_outcome(arguments, result, text=None, status=0):
    """The Outcome of a command whose result is a Result; ``text`` in place of its own."""
    table = result.to_csv().rstrip("\n") if arguments.csv else None
    return Outcome(str(result) if text is None else text, result.to_dict(), status=status, table=table)


def written_outcome(dataset, outputs, text="", **values):
    """The Outcome of a command that has written a dataset, or several alike: its size after ``text`` and ``values``."""
    return Outcome(text + size_text(dataset), {**values, **size_of(dataset)}, outputs)


def printability_text(algorithm):
    """Height kept and intersections left by a filter of geometric textures; empty without Printable."""
    if not algorithm.GetPrintable():
        return ""
    kept, left = algorithm.GetHeightKept(), algorithm.GetNumberOfSelfIntersections()
    return f"{100 * kept:.4g} % of the height kept, {left} self-intersections, "


def result_and_written_outcome(arguments, result, dataset, output):
    """The Outcome of a command whose result is a Result, with a dataset that was written."""
    outcome = result_outcome(arguments, result)
    values = {**outcome.values, **size_of(dataset)}
    return outcome._replace(text=f"{outcome.text}\n{size_text(dataset)}", values=values, outputs=[output])


def size_of(dataset):
    """Numbers of points and cells by name."""
    return {"points": dataset.GetNumberOfPoints(), "cells": dataset.GetNumberOfCells()}


def size_text(dataset):
    """Numbers of points and cells as a text."""
    return f"{dataset.GetNumberOfPoints():,} points, {dataset.GetNumberOfCells():,} cells"


def add_reading_options(parser):
    """The options about how the surface INPUT is read."""
    group = parser.add_argument_group("reading")
    group.add_argument(
        "--point-data",
        action="append",
        default=[],
        metavar="FILE",
        help="file with values of the points, which become point arrays: .gii (.func .shape .label) or FreeSurfer's .area "
        ".curv .sulc .thickness .volume; repeatable",
    )
    group.add_argument(
        "--seams",
        default="join",
        choices=["join", "split"],
        metavar="HOW",
        help="points with several texture coordinates, of .obj and .ply: join (default) keeps the first, split makes a point "
        "of each",
    )


def as_usage(function, *arguments, **parameters):
    """Calls a function whose TypeError and ValueError are about the user's options."""
    try:
        return function(*arguments, **parameters)
    except (TypeError, ValueError) as error:
        raise UsageError(str(error)) from None


def read_input(arguments):
    """The mesh in the file INPUT of a command with add_reading_options()."""
    from .. import files

    as_usage(files.extension, arguments.input)
    return as_usage(files.read_mesh, arguments.input, seams=arguments.seams, point_data=arguments.point_data)


def read_input_surface(arguments):
    """read_input() of a surface, or of a composite dataset, which must hold something."""
    return _surface_in(read_input(arguments), arguments.input)


def read_input_domain(arguments):
    """read_input() of a surface, a volume of tetrahedra, or a composite dataset, which must hold something."""
    from .. import files

    mesh = read_input(arguments)
    if mesh.GetNumberOfPoints() == 0:
        raise files.FormatError(f"{arguments.input}: the file holds no points")
    return mesh


def is_volume(mesh):
    """True for a grid with cells of three dimensions."""
    from vtkmodules.vtkCommonDataModel import vtkCellTypes, vtkGenericCell

    types = vtkCellTypes()
    if mesh.IsA("vtkUnstructuredGrid"):
        mesh.GetCellTypes(types)
    kinds = [types.GetCellType(k) for k in range(types.GetNumberOfTypes())]
    return any(vtkGenericCell.InstantiateCell(kind).GetCellDimension() == 3 for kind in kinds)


def read_observations(arguments):
    """The points in the file of --observations; None without one."""
    from .. import files

    if arguments.observations is None:
        return None
    as_usage(files.extension, arguments.observations)
    points = files.read_mesh(arguments.observations)
    require_single(points, arguments.observations, "set of points")
    return points


def read_surface(path):
    """The surface, or the composite dataset, in a file, which must hold something."""
    from .. import files

    return _surface_in(files.read_mesh(path), path)


def read_single_surface(path):
    """The vtkPolyData in a file, which must hold one."""
    from ..errors import FormatError

    mesh = read_surface(path)
    if not mesh.IsA("vtkPolyData"):
        raise FormatError(f"{path}: one surface is needed, not a {mesh.GetClassName()}")
    return mesh


def require_single(mesh, path, wanted="surface"):
    """Raises FormatError when the mesh from a file is a composite dataset."""
    from ..errors import FormatError

    if mesh.IsA("vtkCompositeDataSet"):
        raise FormatError(f"{path}: one {wanted} is needed, not a {mesh.GetClassName()}")


def _surface_in(mesh, path):
    from .. import files

    if mesh.GetNumberOfPoints() == 0:
        raise files.FormatError(f"{path}: the file holds no points")
    require_surface(mesh, path)
    return mesh


def require_surface(mesh, path):
    """Raises FormatError when the mesh from a file has cells of three dimensions."""
    from ..errors import FormatError

    if is_volume(mesh):
        raise FormatError(
            f"{path}: a volume mesh was found where a surface is needed; vtkDataSetSurfaceFilter, in ParaView Extract "
            "Surface, makes a surface of it"
        )


def printed_message(arguments, bar):
    """A function that prints a message of a filter while it runs, beside its progress bar."""

    def print_message(text):
        if not arguments.quiet:
            bar.clear()
            print(f"{PROGRAM}: {text}", file=sys.stderr, flush=True)

    return print_message


def run_filter(algorithm, dataset, arguments, times=None):
    """The output of a VTK filter for ``dataset``, or a list of its outputs at ``times``, with a progress bar; the filter's
    warnings are issued."""
    from ..errors import SurfaceSynthesisWarning
    from ..pipeline import apply_filter, outputs_at_times

    set_threads(arguments.threads)
    bar = ProgressBar(sys.stderr, not (arguments.no_progress or arguments.quiet))
    try:
        if times is None:
            output, remarks = apply_filter(algorithm, dataset, bar, printed_message(arguments, bar))
        else:
            output, remarks = outputs_at_times(algorithm, dataset, times, bar)
    finally:
        bar.clear()
    for text in remarks:
        warnings.warn(text, SurfaceSynthesisWarning, stacklevel=2)
    return output


def set_threads(threads):
    if threads is None:
        return
    if not 1 <= threads <= 4096:
        raise UsageError(f"--threads must be from 1 to 4096, not {threads}")
    from vtkmodules.vtkCommonCore import vtkSMPTools

    vtkSMPTools.Initialize(threads)


def add_coupling_options(group):
    """Adds the options of the coupling of components to a group."""
    group.add_argument(
        "--component-coupling", action="store_true", help="couple the connected components, so that parts move together"
    )
    group.add_argument(
        "--coupling-weight", type=float, default=1e6, metavar="W", help="weight of coupled points (default: 1e6)"
    )
    group.add_argument(
        "--coupling-distance",
        type=float,
        metavar="D",
        help="largest distance of coupled points (default: 0.03 sqrt(area))",
    )


def coupling_of(arguments):
    """The parameters of the options of add_coupling_options()."""
    return {
        "component_coupling": arguments.component_coupling,
        "coupling_weight": arguments.coupling_weight,
        "coupling_distance": arguments.coupling_distance,
    }
