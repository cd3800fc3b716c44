# SPDX-License-Identifier: BSD-3-Clause
"""Runs one VTK algorithm the Python way: VTK's error events become exceptions, nothing is printed."""

import contextlib
import logging
import re
import signal
import sys
import threading

from vtkmodules.vtkCommonCore import vtkLogger, vtkOutputWindow, vtkStringOutputWindow

from .errors import Cancelled, SurfaceSynthesisError

_log = logging.getLogger(__package__)

# "ERROR: In /path/file.cxx, line 12\nvtkClass (0x1234): "
_PREFIX = re.compile(r"^(?:ERROR|Warning|Generic Warning|Debug): In [^\n]*, line \d+\n(?:\w+ \(0x[0-9a-f]+\): )?")
_EXECUTIVE = "returned failure for request"


def plain_message(text):
    """VTK's message without the source file, the line and the address of the object, on one line."""
    text = "".join(c if c.isprintable() else " " for c in _PREFIX.sub("", text))
    return " ".join(text.split())


class _Messages:
    """The error and warning events of some objects, for the time of a ``with`` block."""

    def __init__(self, *objects):
        self.errors = []
        self.warnings = []
        self._objects = objects
        self._observers = []

    def __enter__(self):
        for event, texts in (("ErrorEvent", self.errors), ("WarningEvent", self.warnings)):
            for sender in self._objects:
                self._observers.append((sender, sender.AddObserver(event, self._collector(texts))))
        return self

    def __exit__(self, *_):
        for sender, observer in self._observers:
            sender.RemoveObserver(observer)

    @staticmethod
    def _collector(texts):
        def collect(_sender, _event, text):
            texts.append(text if isinstance(text, str) else repr(text))

        collect.CallDataType = "string0"
        return collect

    def what_failed(self):
        """The errors in plain text; what the executive adds to every failure is left out."""
        plain = [plain_message(text) for text in self.errors]
        return [text for text in plain if _EXECUTIVE not in text] or plain[:1]


class HeldSignals:
    """Holds Ctrl-C and termination back during a ``with`` block, because VTK ends the process in the middle of its work
    when a handler raises inside an observer. deliver(), after the block, hands over what came."""

    def __init__(self):
        self.pending = None
        self._previous = {}

    def __enter__(self):
        if threading.current_thread() is threading.main_thread():
            for number in (signal.SIGINT, signal.SIGTERM):
                handler = signal.getsignal(number)
                if callable(handler):
                    self._previous[number] = signal.signal(number, self._remember)
        return self

    def __exit__(self, *_):
        for number, handler in self._previous.items():
            signal.signal(number, handler)

    def _remember(self, number, _frame):
        self.pending = number

    def deliver(self):
        if self.pending is not None:
            self._previous[self.pending](self.pending, None)


def run_algorithm(algorithm, progress=None, time=None, message=_log.warning):
    """Updates ``algorithm``, at ``time`` where one is given, and returns the texts of its warnings.

    ``progress`` is called with a fraction in [0, 1], never decreasing; when it returns False, the algorithm is aborted.
    ``message`` is called with the text of each message of the algorithm, as it comes: the time that a training will take.
    Default: the log "surfacesynthesis" of the module logging.
    Raises SurfaceSynthesisError with the texts of the error events, Cancelled, KeyboardInterrupt after Ctrl-C, or
    whatever ``progress`` raised.
    """
    cancelled = False
    raised = []

    def on_progress(sender, _event):
        nonlocal cancelled
        if cancelled or raised or signals.pending is not None:
            sender.SetAbortExecute(1)
            return
        try:
            answer = None if progress is None else progress(sender.GetProgress())
            cancelled = answer is not None and not answer
        except BaseException:  # an observer must not let any exception through: VTK would print it and go on
            raised.append(sys.exc_info()[1])
        if cancelled or raised:
            sender.SetAbortExecute(1)

    def on_message(_sender, _event, text):
        try:
            message(text)
        except BaseException:
            raised.append(sys.exc_info()[1])

    on_message.CallDataType = "string0"
    with HeldSignals() as signals, _Messages(algorithm, algorithm.GetExecutive()) as messages:
        observers = [
            algorithm.AddObserver("ProgressEvent", on_progress), algorithm.AddObserver("MessageEvent", on_message)
        ]
        try:
            algorithm.Update() if time is None else algorithm.UpdateTimeStep(time)
        finally:
            for observer in observers:
                algorithm.RemoveObserver(observer)
            algorithm.SetAbortExecute(0)
    if raised:
        raise raised[0]
    signals.deliver()
    if cancelled:
        raise Cancelled("cancelled by the progress callable")
    if messages.errors:
        raise SurfaceSynthesisError(*messages.what_failed())
    return [plain_message(text) for text in messages.warnings]


def call_method(algorithm, method, *arguments):
    """Calls ``method`` of ``algorithm``, which reports errors by events. Raises SurfaceSynthesisError with their texts."""
    with _Messages(algorithm) as messages:
        getattr(algorithm, method)(*arguments)
    if messages.errors:
        raise SurfaceSynthesisError(*messages.what_failed())


def apply_filter(algorithm, dataset, progress=None, message=_log.warning):
    """The output of a filter for a dataset that stays untouched, or None for a filter that needs none, and the texts of
    the filter's warnings. ``progress`` and ``message`` as those of run_algorithm().

    Raises what run_algorithm() raises.
    """
    _give(algorithm, dataset)
    remarks = run_algorithm(algorithm, progress, message=message)
    return _taken(algorithm), remarks


def outputs_at_times(algorithm, dataset, times, progress=None, take=None):
    """The outputs of a filter at several times, and the texts of its warnings. Progress is that of the first update: the
    filter keeps what it needs for the others. ``take`` copies what is wanted of the filter (default: its first output).

    Raises what run_algorithm() raises.
    """
    _give(algorithm, dataset)
    outputs, remarks = [], []
    for time in times:
        remarks += run_algorithm(algorithm, None if outputs else progress, time)
        outputs.append((take or _taken)(algorithm))
    return outputs, remarks


def _give(algorithm, dataset):
    if dataset is None:
        return
    given = dataset.NewInstance()  # what pipelines leave on their inputs goes to this copy
    given.ShallowCopy(dataset)
    algorithm.SetInputDataObject(0, given)


def _taken(algorithm):
    output = algorithm.GetOutputDataObject(0)
    result = output.NewInstance()
    result.ShallowCopy(output)
    return result


@contextlib.contextmanager
def silent_console():
    """Collects everything VTK would print; for readers and writers, whose inner objects cannot be observed.

    Yields a function that returns ``(errors, warnings)`` in plain text so far. VTK's output window and log level are
    global, so this is not for use from two threads at a time.
    """
    window = vtkStringOutputWindow()
    previous = vtkOutputWindow.GetInstance()
    verbosity = vtkLogger.GetCurrentVerbosityCutoff()
    vtkOutputWindow.SetInstance(window)
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)

    def collected():
        output = window.GetOutput()
        if isinstance(output, bytes):  # what VTK quotes from a file need not be text
            output = output.decode("utf-8", "replace")
        texts = re.split(r"(?m)^(?=(?:ERROR|Warning|Generic Warning): In )", output)
        errors = [plain_message(text) for text in texts if text.startswith("ERROR")]
        warnings = [plain_message(text) for text in texts if text.startswith(("Warning", "Generic Warning"))]
        return [text for text in errors if _EXECUTIVE not in text] or errors[:1], warnings

    try:
        yield collected
    finally:
        vtkLogger.SetStderrVerbosity(verbosity)
        vtkOutputWindow.SetInstance(previous)
