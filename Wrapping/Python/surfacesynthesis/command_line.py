# SPDX-License-Identifier: BSD-3-Clause
"""The command line: ``python3 -m surfacesynthesis COMMAND INPUT OUTPUT [options]``, one command for each filter."""

import argparse
import os
import signal
import sys
import time
import warnings

PROGRAM = "surfacesynthesis"

_DESCRIPTION = "Generative filters on surfaces, from file to file."
_NOISE = """\
Adds Matérn noise to the points of a surface: a Gaussian random field whose statistics do not depend on the
triangulation. The output is the input with one array for each sample."""
_FORMATS = """\
files: the format follows from the extension.
  .vtp .vtk .ply          keep the noise as point arrays
  .stl .obj .off          keep the shape only: use --warp
  .vtm (.vtk)             composite datasets, processed block by block
"""
_NOISE_EXAMPLES = (
    _FORMATS
    + """
examples:
  %(prog)s in.stl out.vtp --range 5 --samples 8
  %(prog)s in.ply bumpy.stl --range 5 --warp 0.3
  %(prog)s in.off out.vtp --components 3 --std 0.2 --seed 7
"""
)


class _UsageError(Exception):
    """What the user asked for makes no sense; exit status 2."""


class _Parser(argparse.ArgumentParser):
    def error(self, message):
        raise _UsageError(f"{message} (see {self.prog} --help)")


def build_parser():
    """The parser of all commands."""
    from ._version import __version__

    prog = f"python3 -m {PROGRAM}"
    parser = _Parser(prog=prog, description=_DESCRIPTION, epilog=f"'{prog} COMMAND --help' describes a command.")
    parser.add_argument("--version", action="version", version=f"{PROGRAM} {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    _add_noise(commands)
    return parser


def _add_noise(commands):
    parser = commands.add_parser(
        "noise",
        help="add Matérn noise to a surface",
        usage=f"python3 -m {PROGRAM} noise INPUT OUTPUT [options]",
        description=_NOISE,
        epilog=_NOISE_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.set_defaults(run=run_noise)
    parser.add_argument("input", metavar="INPUT", help="surface to read: .stl .ply .obj .off .vtp .vtk .vtm")
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
        "--screening", type=float, metavar="TAU", help="screening term tau = 8 / R^2, in 1 / square units of the mesh"
    )
    scale.add_argument(
        "--normalized-screening",
        type=float,
        metavar="C",
        help="tau relative to the spectrum of the triangulation: the same for a mesh of any size",
    )

    noise = parser.add_argument_group("noise")
    noise.add_argument("--std", type=float, default=1.0, metavar="S", help="standard deviation (default: 1)")
    noise.add_argument(
        "--model",
        default="matern",
        choices=["matern", "per_vertex", "white", "unscreened", "spectral"],
        metavar="MODEL",
        help="matern (default) or, for comparison, per_vertex, white, unscreened, spectral",
    )
    noise.add_argument("--seed", type=int, default=0, metavar="N", help="any integer of 32 bits (default: 0)")
    noise.add_argument("--samples", type=int, metavar="N", help="number of samples (default: 1)")
    noise.add_argument("--first-sample", type=int, default=0, metavar="K", help="index of the first (default: 0)")
    noise.add_argument("--components", type=int, default=1, metavar="C", help="components per sample (default: 1)")
    noise.add_argument(
        "--eigenpairs", type=int, default=256, metavar="K", help="eigenpairs of the model spectral (default: 256)"
    )

    output = parser.add_argument_group("output")
    output.add_argument("--name", default="MaternNoise", metavar="NAME", help="name of the array (default: %(default)s)")
    output.add_argument(
        "--warp",
        type=float,
        metavar="SCALE",
        help="move the points by SCALE times the noise, along the normals or, with --components 3, along the noise "
        "itself; with several samples, OUTPUT_0, OUTPUT_1, ... are written",
    )
    output.add_argument("--threads", type=int, metavar="N", help="number of threads (default: VTK's)")
    output.add_argument("--no-progress", action="store_true", help="show no progress bar")
    output.add_argument("--quiet", action="store_true", help="print errors only")


class ProgressBar:
    """A bar on a terminal; nothing anywhere else."""

    WIDTH = 40

    def __init__(self, stream, wanted):
        self._stream = stream if wanted and stream.isatty() else None
        self._shown = None

    def __call__(self, fraction):
        percent = int(100 * min(max(fraction, 0.0), 1.0))
        if self._stream is None or percent == self._shown:
            return
        self._shown = percent
        done = self.WIDTH * percent // 100
        self._stream.write(f"\r[{'#' * done}{' ' * (self.WIDTH - done)}] {percent:3d} %")
        self._stream.flush()

    def clear(self):
        """Takes the bar off the terminal."""
        if self._shown is not None:
            self._stream.write("\r" + " " * (self.WIDTH + 8) + "\r")
            self._stream.flush()
            self._shown = None


def run_noise(arguments):
    """The command ``noise``; returns the line to print."""
    from . import files
    from .noise import apply_filter, array_names

    started = time.monotonic()
    noise = _filter_of(arguments)
    _check_output(arguments, files)
    mesh = files.read_mesh(arguments.input)
    if mesh.GetNumberOfPoints() == 0:
        raise files.FormatError(f"{arguments.input}: the file holds no points")
    _as_usage(files.check_writable, mesh, arguments.output)
    _set_threads(arguments.threads)

    bar = ProgressBar(sys.stderr, not (arguments.no_progress or arguments.quiet))
    try:
        output, remarks = apply_filter(noise, mesh, bar)
    finally:
        bar.clear()
    for text in remarks:
        warnings.warn(text, files.SurfaceSynthesisWarning, stacklevel=2)
    written = _outputs(output, arguments, array_names(noise))
    files.write_meshes(written)
    return _summary(noise, output, [path for _, path in written], time.monotonic() - started)


def _as_usage(function, *arguments, **parameters):
    """Calls a function whose TypeError and ValueError say what is wrong with the user's options."""
    try:
        return function(*arguments, **parameters)
    except (TypeError, ValueError) as error:
        raise _UsageError(str(error)) from None


def _filter_of(arguments):
    from .noise import configured_filter

    return _as_usage(
        configured_filter,
        range=arguments.range,
        standard_deviation=arguments.std,
        seed=arguments.seed,
        samples=arguments.samples,
        first_sample=arguments.first_sample,
        components=arguments.components,
        screening=arguments.screening,
        normalized_screening=arguments.normalized_screening,
        model=arguments.model,
        eigenpairs=arguments.eigenpairs,
        name=arguments.name,
    )


def _check_output(arguments, files):
    """What can be said about the output before anything is read."""
    _as_usage(files.extension, arguments.input)
    kind = _as_usage(files.extension, arguments.output)
    if arguments.warp is None and kind in files.GEOMETRY_ONLY:
        raise _UsageError(
            f"{kind} files cannot hold the noise: write .vtp, .vtk or .ply, or move the points with --warp SCALE"
        )
    if arguments.warp is not None and not abs(arguments.warp) < float("inf"):
        raise _UsageError(f"--warp must be a finite number, not {arguments.warp:g}")
    if arguments.warp is not None and arguments.components not in (1, 3):
        raise _UsageError(f"--warp needs 1 or 3 components, not {arguments.components}")


def _set_threads(threads):
    if threads is None:
        return
    if not 1 <= threads <= 4096:
        raise _UsageError(f"--threads must be from 1 to 4096, not {threads}")
    from vtkmodules.vtkCommonCore import vtkSMPTools

    vtkSMPTools.Initialize(threads)


def _outputs(output, arguments, names):
    """What to write where: one file or, for several samples of a displacement, one for each."""
    from .warp import warped

    if arguments.warp is None:
        return [(output, arguments.output)]
    if len(names) == 1:
        return [(warped(output, names[0], arguments.warp), arguments.output)]
    stem, kind = os.path.splitext(arguments.output)
    numbers = range(arguments.first_sample, arguments.first_sample + len(names))
    return [(warped(output, name, arguments.warp), f"{stem}_{k}{kind}") for name, k in zip(names, numbers)]


def _summary(noise, output, paths, seconds):
    parts = [f"{output.GetNumberOfPoints():,} points", f"{output.GetNumberOfCells():,} cells"]
    if noise.GetEffectiveScreening() > 0:
        parts.append(f"tau {noise.GetEffectiveScreening():.4g}")
        parts.append(f"range {noise.GetEffectiveCorrelationRange():.4g}")
    if noise.GetRelativeResidual() > 0:
        parts.append(f"residual {noise.GetRelativeResidual():.1e}")
    parts.append(f"{seconds:.1f} s")
    shown = paths[0] if len(paths) == 1 else f"{paths[0]} ... {paths[-1]}"
    return f"{', '.join(parts)} -> {shown}"


def _one_line(text):
    return "; ".join(line.strip() for line in text.splitlines() if line.strip())


def _report(text):
    print(f"{PROGRAM}: {_one_line(text)}", file=sys.stderr)


def _show_warning(message, category, *_ignored, **_also_ignored):
    _report(f"warning: {message}")


def _terminate(number, _frame):
    raise SystemExit(128 + number)  # unwinds, so that temporary files go


def main(arguments=None):
    """Runs a command line (default: the process's own) and returns the exit status: 0, 1 after an error, 2 for wrong
    usage, 130 after Ctrl-C."""
    if arguments is None:
        signal.signal(signal.SIGTERM, _terminate)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("always")
            warnings.showwarning = _show_warning
            parsed = build_parser().parse_args(arguments)
            if parsed.quiet:
                warnings.simplefilter("ignore")
            line = parsed.run(parsed)
        if not parsed.quiet:
            print(line, flush=True)
        return 0
    except _UsageError as error:
        _report(str(error))
        return 2
    except KeyboardInterrupt:
        _report("interrupted")
        return 130
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # the reader of our output has gone
        return 1
    except MemoryError:
        _report("not enough memory")
        return 1
    except OSError as error:
        _report(f"{error.filename}: {error.strerror}" if error.filename and error.strerror else str(error))
        return 1
    except (RuntimeError, ValueError) as error:  # SurfaceSynthesisError and its kin; VTK's own
        _report(str(error))
        return 1
