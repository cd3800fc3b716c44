# SPDX-License-Identifier: BSD-3-Clause
"""Many samples of a filter, a few at a time."""

import os
import resource
import warnings

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy

from .arguments import INT_MAX, integer
from .errors import SurfaceSynthesisError, SurfaceSynthesisWarning
from .pipeline import apply_filter

#: Samples that are made together, so that VTK's datasets, with all their arrays, are there for a part only.
TOGETHER = 500
#: Rounding of squared distances that are made of inner products, as a fraction of the squares.
_ROUNDING = 1e-13


def checked_range(samples, first_sample):
    """The two, which are integers of which the last sample's index is one, too; raises ValueError and TypeError."""
    samples = integer("samples", samples, 1)
    first_sample = integer("first_sample", first_sample, 0)
    if first_sample > INT_MAX - samples + 1:
        raise ValueError(f"first_sample + samples must be at most {INT_MAX + 1}, not {first_sample + samples}")
    return samples, first_sample


def default_memory_limit():
    """Three quarters of the memory of the machine, or of the limit of the process where it is smaller; MiB."""
    available = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    allowed = resource.getrlimit(resource.RLIMIT_AS)[0]
    if allowed != resource.RLIM_INFINITY:
        available = min(available, allowed)
    return available * 3 // 4 // 2**20


def require_memory(samples, sample_bytes, memory_limit):
    """Raises SurfaceSynthesisError, which names a number that fits, when the samples need more than ``memory_limit`` MiB."""
    limit = default_memory_limit() if memory_limit is None else integer("memory_limit", memory_limit, 1)
    needed, fitting = samples * sample_bytes, limit * 2**20 // max(sample_bytes, 1)
    if needed > limit * 2**20:
        raise SurfaceSynthesisError(
            f"about {needed / 2**30:.6g} GiB would be needed for {samples} samples; at most {limit / 2**10:.6g} GiB are "
            f"allowed (MemoryLimit). A NumberOfSamples of {fitting} fits."
        )


def positions_of_blocks(output, missing):
    """The points of the blocks of a filter's output, [N, V, 3]; without blocks an error that ends with ``missing``."""
    blocks = [output.GetBlock(k) for k in range(output.GetNumberOfBlocks())]
    if not blocks:
        raise SurfaceSynthesisError(f"the mesh is empty; {missing} is needed")
    return np.stack([vtk_to_numpy(block.GetPoints().GetData()) for block in blocks])


def farthest_samples(samples, count):
    """Indices of ``count`` of the samples [N, V, C], ascending, by farthest-point selection: the first one, then again and
    again the one that is farthest, in root mean square, from those chosen."""
    flat = np.reshape(samples, (len(samples), -1)).astype(np.float64)
    flat -= flat.mean(axis=0)  # so that the differences of squares below lose less to rounding
    squares = np.einsum("ij,ij->i", flat, flat)
    chosen, nearest = [0], np.full(len(flat), np.inf)
    while len(chosen) < count:
        sums = squares + squares[chosen[-1]]
        distances = sums - 2.0 * (flat @ flat[chosen[-1]])
        distances[distances < _ROUNDING * sums] = 0.0  # of samples that are alike
        nearest = np.minimum(nearest, distances)
        nearest[chosen] = -1.0
        chosen.append(int(nearest.argmax()))
    return sorted(chosen)


def in_parts(algorithm, dataset, samples, first_sample, progress=None, point_bytes=8, memory_limit=None):
    """The outputs of a filter with NumberOfSamples and FirstSample, one after the other, which together hold so many
    samples, of ``point_bytes`` bytes at each point. Raises what apply_filter() raises, ValueError and TypeError."""
    samples, first_sample = checked_range(samples, first_sample)
    # The parts, and the array that they are joined to.
    require_memory(samples, 2 * point_bytes * dataset.GetNumberOfPoints(), memory_limit)
    for begin in range(0, samples, TOGETHER):
        count = min(TOGETHER, samples - begin)
        algorithm.SetFirstSample(first_sample + begin)
        algorithm.SetNumberOfSamples(count)
        part = progress and (lambda fraction: progress((begin + fraction * count) / samples))
        output, remarks = apply_filter(algorithm, dataset, part)
        for text in remarks:
            warnings.warn(text, SurfaceSynthesisWarning, stacklevel=3)
        yield output
