# SPDX-License-Identifier: BSD-3-Clause
"""Processes of the command line without its half a second of imports: forks of one that has loaded the package.

Run as a program, this file is that process. Each request on its standard input, a socket, brings arguments, a folder, the
environment and three descriptors; the answers are the process's id and its exit status.
"""

import atexit
import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
import tempfile

_LARGEST_REQUEST = 1 << 18


class CommandProcesses:
    """Starts commands, ``python3 -m surfacesynthesis ...``, one after the other."""

    def __init__(self):
        self._channel = None

    def run(self, arguments, cwd=None, timeout=120):
        """The subprocess.CompletedProcess of a command, with its output as text."""
        if self._channel is None:
            self._start()
        with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err, open(os.devnull, "rb") as nothing:
            request = json.dumps([[str(word) for word in arguments], os.fspath(cwd or os.getcwd()), dict(os.environ)])
            descriptors = [stream.fileno() for stream in (nothing, out, err)]
            socket.send_fds(self._channel, [request.encode()], descriptors)
            process = self._answer()
            self._channel.settimeout(timeout)
            try:
                status = self._answer()
            except TimeoutError:
                os.kill(process, signal.SIGKILL)
                self._answer()
                raise subprocess.TimeoutExpired(request, timeout) from None
            finally:
                self._channel.settimeout(None)
            return subprocess.CompletedProcess(arguments, status, _text(out), _text(err))

    def _start(self):
        self._channel, theirs = socket.socketpair()
        process = subprocess.Popen([sys.executable, os.path.abspath(__file__)], stdin=theirs, cwd=os.path.dirname(__file__))
        theirs.close()
        atexit.register(process.wait)
        atexit.register(self._channel.close)

    def _answer(self):
        data = self._channel.recv(4)
        assert len(data) == 4, "the process that starts the commands has ended"
        return int.from_bytes(data, "little", signed=True)


def _text(stream):
    stream.seek(0)
    return stream.read().decode("utf-8").replace("\r\n", "\n")


def _become_command(request, descriptors, main):
    """Runs a command in this process, as ``python3 -m`` does, and ends it."""
    arguments, folder, environment = json.loads(request)
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    for number, descriptor in enumerate(descriptors):
        os.dup2(descriptor, number)
        os.close(descriptor)
    sys.argv = [os.path.join(os.path.dirname(sys.modules["surfacesynthesis"].__file__), "__main__.py"), *arguments]
    status = 1
    try:
        status = main()
    except SystemExit as end:
        status = end.code
    except BaseException:
        sys.excepthook(*sys.exc_info())
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError):
            stream.flush()
    os._exit(status)


def _serve(channel):
    from surfacesynthesis.command_line import main

    while True:
        request, descriptors, _, _ = socket.recv_fds(channel, _LARGEST_REQUEST, 3)
        if not request:
            return
        child = os.fork()
        if child == 0:
            channel.close()
            _become_command(request, descriptors, main)
        for descriptor in descriptors:
            os.close(descriptor)
        channel.sendall(child.to_bytes(4, "little"))
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        channel.sendall(status.to_bytes(4, "little", signed=True))


if __name__ == "__main__":
    _serve(socket.socket(fileno=os.dup(0)))
