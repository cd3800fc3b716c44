# SPDX-License-Identifier: BSD-3-Clause
"""The command line: ``python3 -m surfacesynthesis COMMAND INPUT OUTPUT [options]``, one command for each filter."""

import argparse
import os
import re
import signal
import sys
import time
import warnings

from .commands import COMMANDS, FORMER_COMMANDS, TRAININGS
from .commands.common import PROGRAM, UsageError
from .commands.wording import in_words_of_commands
from .deprecation import note_renamed
from .supervision import is_supervised, raise_on_interruption, run_supervised

_DESCRIPTION = "Generative filters on surfaces, from file to file."


class _Parser(argparse.ArgumentParser):
    def __init__(self, *arguments, **options):
        super().__init__(*arguments, **options)
        # argparse takes -1 and -0.5 for numbers, and -1e-3 for an option
        self._negative_number_matcher = re.compile(r"-(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?$|-(inf|nan)$")

    def error(self, message):
        raise UsageError(f"{message} (see {self.prog} --help)")


def build_parser():
    """The parser of all commands."""
    from ._version import __version__

    prog = f"python3 -m {PROGRAM}"
    epilog = f"'{prog} COMMAND --help' describes a command. With --json each prints one JSON object in place of its text."
    parser = _Parser(prog=prog, description=_DESCRIPTION, epilog=epilog)
    parser.add_argument("--version", action="version", version=f"{PROGRAM} {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for command in COMMANDS:
        command.add(commands)
    _remember_parsers(parser)
    return parser


def _remember_parsers(parser):
    """Lets the parsed arguments know the parser of their command."""
    nested = [action for action in parser._actions if isinstance(action, argparse._SubParsersAction)]
    for child in {id(child): child for action in nested for child in action.choices.values()}.values():
        _remember_parsers(child)
    if not nested:
        parser.set_defaults(parser=parser)


def _parse(arguments):
    """The parsed arguments; a former name of a command is replaced by the new one."""
    arguments = list(arguments)
    former = arguments[0] if arguments else None
    if former in FORMER_COMMANDS:
        arguments[0] = FORMER_COMMANDS[former]
    parsed = build_parser().parse_args(arguments)
    if former in FORMER_COMMANDS:
        note_renamed(parsed, f"the command {former}", FORMER_COMMANDS[former])
    return parsed


def _one_line(text):
    return "; ".join(line.strip() for line in text.splitlines() if line.strip())


def _report(text):
    print(f"{PROGRAM}: {_one_line(text)}", file=sys.stderr)


def _terminate(number, _frame):
    raise SystemExit(128 + number)  # unwinds, so that temporary files go


def main(arguments=None):
    """Runs a command line (default: the process's own) and returns the exit status: 0 or that of the command, 1 after an
    error, 2 for wrong usage, 130 after Ctrl-C.

    The process's own command runs in another process, so that it ends within a second of Ctrl-C; but for trainings, which
    keep what they have reached.
    """
    if arguments is not None:
        return _run(arguments)
    signal.signal(signal.SIGTERM, _terminate)
    arguments = sys.argv[1:]
    if not arguments or arguments[0] in TRAININGS:
        return _run(arguments)
    return run_supervised(lambda: _run(arguments), _report)


def _run(arguments):
    """Runs a command line in this process; returns the exit status."""
    parsed = None

    def worded(message):
        return str(message) if parsed is None else in_words_of_commands(str(message), parsed.parser)

    try:
        raise_on_interruption()
        with warnings.catch_warnings():
            warnings.simplefilter("always")
            warnings.showwarning = lambda message, *_ignored, **_also_ignored: _report(f"warning: {worded(message)}")
            parsed = _parse(arguments)
            if parsed.quiet:
                warnings.simplefilter("ignore")
            for remark in getattr(parsed, "remarks", ()):
                warnings.warn(remark, DeprecationWarning, stacklevel=1)
            started = time.monotonic()
            outcome = parsed.run(parsed)
        if not parsed.quiet:
            print(outcome.printed(parsed, time.monotonic() - started), flush=True)
        return outcome.status
    except UsageError as error:
        _report(str(error))
        return 2
    except KeyboardInterrupt as interruption:
        if not is_supervised():
            _report(str(interruption) or "interrupted")
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
        _report(worded(error))
        return 1
