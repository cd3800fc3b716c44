# SPDX-License-Identifier: BSD-3-Clause
"""Numbers in lines of text, for the readers of OFF, OBJ and PLY: fast when the lines are right, and with the line
number in the error when they are not."""

import warnings

import numpy as np

from ..errors import FormatError


def count_of(text):
    """A number of elements written in decimal digits, or None when ``text`` is anything else."""
    return int(text) if text.isascii() and text.isdigit() and len(text) < 19 else None


def numbers(path, rows, lines):
    """All numbers of ``rows`` (bytes, one per line) as one float64 array, and how many each row has (int64).

    ``lines`` are the numbers of the lines in the file. Raises FormatError for a row with something that is no number.
    """
    counts = np.fromiter((len(row.split()) for row in rows), dtype=np.int64, count=len(rows))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # what fromstring cannot read is looked for below
        values = np.fromstring(b" ".join(rows), dtype=np.float64, sep=" ") if counts.sum() else np.zeros(0)
    if len(values) != counts.sum():
        values = np.array([_number(path, line, word) for row, line in zip(rows, lines) for word in row.split()])
    return values, counts


def _number(path, line, word):
    try:
        return float(word)
    except ValueError:
        raise FormatError(f"{path}:{line}: '{_printable(word)}' is not a number") from None


def _printable(word):
    text = word[:40].decode("latin-1")
    return "".join(c if c.isprintable() else "?" for c in text)


def table(path, rows, lines, columns, what):
    """The first ``columns`` numbers of each row, [rows, columns] float64; longer rows are allowed."""
    values, counts = numbers(path, rows, lines)
    short = np.flatnonzero(counts < columns)
    if len(short):
        row = short[0]
        raise FormatError(f"{path}:{lines[row]}: {what} has {counts[row]} numbers instead of {columns}")
    starts = np.cumsum(counts) - counts
    return values[starts[:, None] + np.arange(columns)]


def polygons(path, values, counts, lines, sizes, skip, points, written=None, first=0):
    """Offsets and connectivity of polygons whose point ids stand in each row after ``skip`` numbers.

    ``sizes`` is the number of corners of each row; ids must be integers from 0 to ``points`` - 1. ``written`` and
    ``first`` are the ids as the file has them, and the number it gives to the first point, for the error.
    """
    short = np.flatnonzero(counts < sizes + skip)
    if len(short):
        row = short[0]
        raise FormatError(f"{path}:{lines[row]}: a face of {sizes[row]} points has {counts[row] - skip} point numbers")
    small = np.flatnonzero(sizes < 3)
    if len(small):
        raise FormatError(f"{path}:{lines[small[0]]}: a face has {sizes[small[0]]} points, fewer than 3")
    starts = np.cumsum(counts) - counts
    offsets = np.concatenate(([0], np.cumsum(sizes)))
    where = np.repeat(starts + skip - offsets[:-1], sizes) + np.arange(offsets[-1])
    ids = values[where]
    wrong = np.flatnonzero(~((ids >= 0) & (ids < points) & (ids == np.floor(ids))))
    if len(wrong):
        row = np.searchsorted(offsets, wrong[0], side="right") - 1
        named = (values if written is None else written)[where[wrong[0]]]
        raise FormatError(
            f"{path}:{lines[row]}: a face names point {named:g}; the file has points {first} to {points - 1 + first}"
        )
    return offsets, ids.astype(np.int64)
