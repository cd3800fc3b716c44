# SPDX-License-Identifier: BSD-3-Clause
"""Many samples of a filter, a few at a time."""

import warnings

from .arguments import INT_MAX, integer
from .errors import SurfaceSynthesisWarning
from .pipeline import apply_filter

#: Samples that are made together, so that VTK's datasets, with all their arrays, are there for a part only.
TOGETHER = 500


def checked_range(samples, first_sample):
    """The two, which are integers of which the last sample's index is one, too; raises ValueError and TypeError."""
    samples = integer("samples", samples, 1)
    first_sample = integer("first_sample", first_sample, 0)
    if first_sample > INT_MAX - samples + 1:
        raise ValueError(f"first_sample + samples must be at most {INT_MAX + 1}, not {first_sample + samples}")
    return samples, first_sample


def in_parts(algorithm, dataset, samples, first_sample, progress=None):
    """The outputs of a filter with NumberOfSamples and FirstSample, one after the other, which together hold so many
    samples. Raises what apply_filter() raises, ValueError and TypeError."""
    samples, first_sample = checked_range(samples, first_sample)
    for begin in range(0, samples, TOGETHER):
        count = min(TOGETHER, samples - begin)
        algorithm.SetFirstSample(first_sample + begin)
        algorithm.SetNumberOfSamples(count)
        part = progress and (lambda fraction: progress((begin + fraction * count) / samples))
        output, remarks = apply_filter(algorithm, dataset, part)
        for text in remarks:
            warnings.warn(text, SurfaceSynthesisWarning, stacklevel=3)
        yield output
