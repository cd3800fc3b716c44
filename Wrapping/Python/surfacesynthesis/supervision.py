# SPDX-License-Identifier: BSD-3-Clause
"""Commands in a process of their own, which ends soon after Ctrl-C whatever it does, and leaves no unfinished file."""

import contextlib
import ctypes
import os
import secrets
import select
import shutil
import signal
import sys
import time

#: Seconds from Ctrl-C or termination until a command that has not ended by itself is ended.
PATIENCE = 0.3

_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_SET_PARENT_DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG of <sys/prctl.h>
_announcements = None  # of a supervised process: the pipe to the one that waits for it


def end_on_interruption():
    """Lets Ctrl-C end ``python3 -m surfacesynthesis`` with one line and the status 130 while its modules are loaded, which
    takes half a second. Does nothing where the package is imported by another program."""
    words = getattr(sys, "orig_argv", ())
    is_program = sys.argv[:1] == ["-m"] and any(
        option.startswith("-") and option.endswith("m") and module == __package__
        for option, module in zip(words, words[1:])
    )
    if is_program and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _end)


def raise_on_interruption():
    """Lets Ctrl-C raise KeyboardInterrupt again, after end_on_interruption()."""
    if signal.getsignal(signal.SIGINT) is _end:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _end(number, _frame):
    os.write(2, f"{__package__}: interrupted\n".encode())
    os._exit(128 + number)


def unfinished_name(folder, suffix=""):
    """A new name in ``folder`` for a file or folder that goes when the command is ended before it is complete."""
    path = os.path.join(folder, f".surfacesynthesis-{secrets.token_hex(8)}{suffix}")
    if _announcements is not None:
        os.write(_announcements, os.fsencode(os.path.abspath(path)) + b"\0")
    return path


def is_supervised():
    """True in a process that run_supervised() has started, which itself reports interruptions."""
    return _announcements is not None


def run_supervised(work, report):
    """The exit status of ``work()``, a function that returns it, run in a process of its own.

    SIGINT and SIGTERM go to that process, which may end by itself; after PATIENCE it is ended, its unfinished files are
    removed and ``report`` is called with a text. The status is then 128 plus the number of the signal.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    reading, writing = os.pipe()
    signal.pthread_sigmask(signal.SIG_BLOCK, _SIGNALS)  # until both processes have their handlers
    child = os.fork()
    if child == 0:
        os.close(reading)
        _work_as_child(work, writing)
    os.close(writing)
    return _waited_for(child, reading, report)


def _work_as_child(work, writing):
    """Runs ``work`` and ends this process."""
    global _announcements
    _announcements = writing
    status = 1
    try:
        ctypes.CDLL(None).prctl(_SET_PARENT_DEATH_SIGNAL, signal.SIGTERM, 0, 0, 0)
        raise_on_interruption()
        for number in _SIGNALS:
            signal.signal(number, _once(signal.getsignal(number)))
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _SIGNALS)
        status = work()
    except SystemExit as end:  # of --help, --version and of termination
        status = end.code if isinstance(end.code, int) else 0 if end.code is None else 1
    except BaseException:
        sys.excepthook(*sys.exc_info())
    finally:
        for stream in (sys.stdout, sys.stderr):
            with contextlib.suppress(OSError, ValueError):  # the reader has gone
                stream.flush()
        os._exit(status)


def _once(handler):
    """A handler that is called for one signal only: Ctrl-C comes from the terminal and from the process that waits."""

    def handle(number, frame):
        for other in _SIGNALS:
            signal.signal(other, signal.SIG_IGN)
        handler(number, frame)

    return handle if callable(handler) else handler


def _waited_for(child, reading, report):
    asked = []

    def ask(number, _frame):
        asked.append((number, time.monotonic()))
        with contextlib.suppress(ProcessLookupError):
            os.kill(child, number)

    previous = {number: signal.signal(number, ask) for number in _SIGNALS}
    signal.pthread_sigmask(signal.SIG_UNBLOCK, _SIGNALS)
    try:
        unfinished = _announced_until_the_end(child, reading, asked)
        ended = -os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    finally:
        os.close(reading)
        for number, handler in previous.items():
            signal.signal(number, handler)
    killed = ended > 0
    for path in unfinished if killed else ():
        _remove(path)
    if asked and (killed or -ended == 128 + asked[0][0]):
        report("interrupted" if asked[0][0] == signal.SIGINT else "terminated")
        return 128 + asked[0][0]
    if not killed:
        return -ended
    hint = ", as a rule because the memory of the machine is used up" if ended == signal.SIGKILL else ""
    report(f"ended by the signal {signal.Signals(ended).name}{hint}")
    return 128 + ended


def _announced_until_the_end(child, reading, asked):
    """The names that ``child`` has announced, at its end, to which it is brought once the patience is over."""
    text = b""
    while True:
        if select.select([reading], [], [], 0.05)[0]:
            data = os.read(reading, 1 << 16)
            if not data:
                return [os.fsdecode(path) for path in text.split(b"\0") if path]
            text += data
        elif asked and time.monotonic() - asked[0][1] > PATIENCE:
            os.kill(child, signal.SIGKILL)


def _remove(path):
    if os.path.isdir(path):
        shutil.rmtree(path, ignore_errors=True)
    else:
        with contextlib.suppress(OSError):
            os.unlink(path)
