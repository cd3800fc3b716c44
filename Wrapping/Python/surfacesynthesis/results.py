# SPDX-License-Identifier: BSD-3-Clause
"""Shared by all results: JSON texts, and tables for notebooks."""

import collections.abc
import csv
import html
import io
import json
import math

import numpy as np


class Result:
    """A result with a method ``to_dict()``, which gives it a JSON text."""

    def to_json(self):
        """The result as a JSON text."""
        return json_text(self.to_dict())


class MappingResult(Result, collections.abc.Mapping):
    """A result that is read like a dictionary: that of its attribute ``_values``."""

    def __getitem__(self, name):
        return self._values[name]

    def __iter__(self):
        return iter(self._values)

    def __len__(self):
        return len(self._values)


def csv_text(rows):
    """Rows as comma-separated values."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def json_text(values):
    """A JSON text of dictionaries, lists, numbers, texts and NumPy arrays; numbers that are not finite become null."""
    return json.dumps(_plain(values), indent=2, allow_nan=False)


def _plain(value):
    """The value in types of JSON."""
    if isinstance(value, dict):
        return {str(name): _plain(one) for name, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(one) for one in value]
    if isinstance(value, (np.ndarray, np.generic)):
        return _plain(value.tolist())
    return None if isinstance(value, float) and not math.isfinite(value) else value


def shown(value):
    """A value as text: counts with separators, real numbers with six digits, truths as yes and no."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, (int, np.integer)):
        return f"{value:,}"
    if isinstance(value, (float, np.floating)):
        return f"{value:.6g}"
    return str(value)


def html_table(rows, head=()):
    """An HTML table of rows of values, below a row of column names; texts are escaped."""
    names = "".join(f"<th>{html.escape(str(name))}</th>" for name in head)
    body = "".join("<tr>" + "".join(f"<td>{html.escape(shown(value))}</td>" for value in row) + "</tr>" for row in rows)
    return f"<table>{f'<tr>{names}</tr>' if names else ''}{body}</table>"
