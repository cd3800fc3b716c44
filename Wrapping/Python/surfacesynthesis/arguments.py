# SPDX-License-Identifier: BSD-3-Clause
"""Checks of the arguments of the package's functions: each returns the value, or raises TypeError or ValueError with the
argument's name."""

import math
import numbers
import operator
import os

import numpy as np

INT_MIN, INT_MAX = -(2**31), 2**31 - 1


def real(name, value):
    """A number, of any kind but bool."""
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, numbers.Real):
        raise TypeError(f"{name} must be a number, not {type(value).__name__}")
    return float(value)


def _shown(value):
    """A number with six digits, or all of them where it is another one."""
    return f"{value:g}" if float(f"{value:g}") == value else repr(value)


def positive(name, value):
    """A finite number larger than 0."""
    value = real(name, value)
    if not 0.0 < value < math.inf:
        raise ValueError(f"{name} must be a finite number larger than 0, not {_shown(value)}")
    return value


def finite(name, value):
    """A finite number."""
    value = real(name, value)
    if not math.isfinite(value):
        raise ValueError(f"{name} must be a finite number, not {_shown(value)}")
    return value


def at_least_0(name, value):
    """A finite number, at least 0."""
    value = finite(name, value)
    if value < 0:
        raise ValueError(f"{name} must be at least 0, not {_shown(value)}")
    return value


def in_range(name, value, smallest, largest):
    """A number from ``smallest`` to ``largest``."""
    value = real(name, value)
    if not smallest <= value <= largest:
        raise ValueError(f"{name} must be from {smallest:g} to {largest:g}, not {_shown(value)}")
    return value


def at_most(name, value, largest):
    """``value``, which has been checked otherwise, when it is not larger than ``largest``."""
    if value > largest:
        raise ValueError(f"{name} must be at most {largest}, not {_shown(value)}")
    return value


def integer(name, value, smallest, largest=INT_MAX):
    """An integer of 32 bits from ``smallest`` to ``largest``."""
    try:
        if isinstance(value, (bool, np.bool_)):
            raise TypeError
        value = operator.index(value)
    except TypeError:
        raise TypeError(f"{name} must be an integer, not {type(value).__name__}") from None
    if value < smallest or largest == INT_MAX < value:
        raise ValueError(f"{name} must be from {smallest} to {largest}, not {value}")
    return at_most(name, value, largest)


def choice(name, value, choices):
    """One of the keys of ``choices``; returns its value."""
    if not isinstance(value, str):
        raise TypeError(f"{name} must be a string, not {type(value).__name__}")
    if value not in choices:
        raise ValueError(f"unknown {name} '{value}'; choose one of {', '.join(choices)}")
    return choices[value]


def array_name(name, value):
    """The name of an array."""
    if not isinstance(value, str):
        raise TypeError(f"{name} must be a string, not {type(value).__name__}")
    if not value or "\0" in value:
        raise ValueError(f"{name} must be the name of an array; it is empty or holds a zero byte")
    return value


def flag(name, value):
    """True or False."""
    if not isinstance(value, (bool, np.bool_)):
        raise TypeError(f"{name} must be True or False, not {type(value).__name__}")
    return bool(value)


def progress_callback(value):
    """A callable, or None."""
    if value is not None and not callable(value):
        raise TypeError(f"progress must be callable, not {type(value).__name__}")
    return value


def optional_path(name, value):
    """A path as a string; "" for None."""
    if value is None:
        return ""
    try:
        value = os.fspath(value)
    except TypeError:
        raise TypeError(f"{name} must be a path, not {type(value).__name__}") from None
    value = value.decode() if isinstance(value, bytes) else value
    if not value or "\0" in value:
        raise ValueError(f"{name} must be a path; it is empty or holds a zero byte")
    return value


def set_normalization(algorithm, normalization_area, normalization_center):
    """Sets the area and center of the whole surface of a filter that takes parts; both or none are given."""
    if (normalization_area is None) != (normalization_center is None):
        raise ValueError("normalization_area and normalization_center go together: give both or none")
    if normalization_area is None:
        return
    center = np.asarray(normalization_center)
    if center.shape != (3,):
        raise ValueError(f"normalization_center must be 3 numbers, not an array of shape {center.shape}")
    algorithm.SetNormalizationArea(positive("normalization_area", normalization_area))
    algorithm.SetNormalizationCenter([finite("normalization_center", value) for value in center.tolist()])


def set_coupling(algorithm, component_coupling, coupling_weight, coupling_distance):
    """Sets the coupling of components of a filter."""
    algorithm.SetComponentCoupling(flag("component_coupling", component_coupling))
    algorithm.SetCouplingWeight(positive("coupling_weight", coupling_weight))
    algorithm.SetCouplingDistance(0.0 if coupling_distance is None else at_least_0("coupling_distance", coupling_distance))
