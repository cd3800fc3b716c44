# SPDX-License-Identifier: BSD-3-Clause
"""Former names of functions, keywords and options, which go on working with a warning."""

import argparse
import functools
import warnings


def renamed_keywords(**successors):
    """A decorator for a function whose keywords have new names, as in ``renamed_keywords(std="standard_deviation")``.

    A call with a former keyword gives a DeprecationWarning; one with the former and the new keyword raises TypeError.
    """

    def decorate(function):
        @functools.wraps(function)
        def with_former_keywords(*arguments, **parameters):
            for former, successor in successors.items():
                if former not in parameters:
                    continue
                if successor in parameters:
                    raise TypeError(f"{function.__name__}() got {successor} and {former}, which is its former name")
                text = f"the keyword {former} of {function.__name__}() is deprecated: use {successor}"
                warnings.warn(text, DeprecationWarning, stacklevel=2)
                parameters[successor] = parameters.pop(former)
            return function(*arguments, **parameters)

        with_former_keywords.former_keywords = dict(successors)
        return with_former_keywords

    return decorate


def warn_renamed(former, successor, stacklevel=3):
    """Gives the DeprecationWarning of a former name to the caller's caller."""
    warnings.warn(f"{former} is deprecated: use {successor}", DeprecationWarning, stacklevel=stacklevel)


class _FormerOption(argparse.Action):
    """Does what its successor does, and notes the remark that main() prints."""

    def __init__(self, option_strings, dest, successor, value, **given):
        nargs = 0 if value is not None else successor.nargs
        super().__init__(option_strings, dest, nargs=nargs, type=successor.type, choices=successor.choices, **given)
        self._successor = successor
        self._value = value

    def __call__(self, parser, namespace, values, option_string=None):
        taken = values if self._value is None else self._value
        self._successor(parser, namespace, taken, option_string)
        successor = " ".join([self._successor.option_strings[0], *([] if self._value is None else [self._value])])
        note_renamed(namespace, option_string, successor)


def add_former_option(parser, former, successor, value=None):
    """Adds a hidden option, the former name of ``successor`` (an option of the parser); with a ``value`` a flag that
    stands for the successor with this value."""
    parser.add_argument(
        former,
        action=_FormerOption,
        dest=successor.dest,
        successor=successor,
        value=value,
        default=argparse.SUPPRESS,
        metavar=successor.metavar,
        help=argparse.SUPPRESS,
    )


def note_renamed(namespace, former, successor):
    """Notes a remark in a namespace of parsed arguments."""
    remark = f"{former} is deprecated: use {successor}"
    namespace.remarks = [*getattr(namespace, "remarks", ()), remark]
