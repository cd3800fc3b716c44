# SPDX-License-Identifier: BSD-3-Clause
"""Volumes: NIfTI, MetaImage, NRRD and VTK's XML images, as vtkImageData that lies where the file says.

The headers are read here and not by VTK's readers, which turn rows round, leave directions out, or crash on files that
are cut off. The size in a header is compared with that of the file before memory is taken.
"""

import gzip
import os
import warnings
import zlib
from typing import NamedTuple, Optional

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonDataModel import vtkImageData

from ..errors import FormatError, SurfaceSynthesisWarning

#: Bytes that a compressed byte can stand for at most (a property of the deflate format).
LARGEST_RATIO = 1032
#: Tolerance of the orthogonality of axes: headers store them in single precision.
_ORTHOGONAL = 1e-3


#: Spaces of world coordinates that read_volume() knows, with the directions of x, y and z where "RAS" has 1, 1, 1.
SPACES = {"RAS": (1.0, 1.0, 1.0), "LPS": (-1.0, -1.0, 1.0), "file": None}


class Volume(NamedTuple):
    """Samples on a lattice. Sample (i, j, k) lies at ``affine @ (i, j, k, 1)``; ``values`` are flat, i runs fastest.
    ``directions`` of x, y and z are 1 where the file has them as "RAS" has, -1 where opposite; None: it does not say."""

    dimensions: tuple
    affine: np.ndarray
    values: np.ndarray
    directions: Optional[tuple]


def to_image(path, volume, space):
    """The vtkImageData of a Volume, with the array "Scalars", in one of SPACES. Raises FormatError when its axes are
    sheared."""
    affine = volume.affine
    if SPACES[space] is not None and volume.directions is not None:
        affine = np.diag([*np.multiply(SPACES[space], volume.directions), 1.0]) @ affine
    axes = affine[:3, :3]
    spacing = np.linalg.norm(axes, axis=0)
    if not np.isfinite(affine).all() or not (spacing > 0).all():
        raise FormatError(f"{path}: the axes of the volume have the lengths {_listed(spacing)}; larger than 0 is needed")
    directions = axes / spacing
    cosines = directions.T @ directions - np.eye(3)
    if np.abs(cosines).max() > _ORTHOGONAL:
        raise FormatError(
            f"{path}: the axes of the volume are sheared: the cosine between two of them is "
            f"{np.abs(cosines).max():.3g}, where 0 is needed. Resample the volume on orthogonal axes first."
        )
    left, _, right = np.linalg.svd(directions)  # the nearest orthogonal axes: rounding in the header goes
    image = vtkImageData()
    image.SetDimensions(*volume.dimensions)
    image.SetSpacing(*spacing)
    image.SetOrigin(*affine[:3, 3])
    image.SetDirectionMatrix(*(left @ right).ravel())
    _warn_of_values_that_are_not_finite(path, volume.values)
    scalars = numpy_to_vtk(np.ascontiguousarray(volume.values), deep=True)
    scalars.SetName("Scalars")
    image.GetPointData().SetScalars(scalars)
    return image


def volume_from_numpy(array, affine, space="RAS", name="Scalars"):
    """A vtkImageData of samples in memory, in "RAS" as read_volume() returns them by default.

    ``array`` [I, J, K] or [I, J] of numbers: sample (i, j, k) lies at ``affine @ (i, j, k, 1)``, as in nibabel; arrays of
    SimpleITK and pydicom, which have the slices first, are transposed first (``array.transpose(2, 1, 0)``). ``affine``
    [4, 4] or [3, 4] maps to the world coordinates ``space``: "RAS" (default; NIfTI, nibabel) or "LPS" (DICOM, ITK). Its
    axes are orthogonal. ``name`` is that of the scalars. The samples are copied. Raises ValueError.
    """
    array, affine = np.asarray(array), np.asarray(affine, dtype=np.float64)
    if SPACES.get(space) is None:
        raise ValueError(f"space is {space!r}; RAS or LPS is needed")
    if array.ndim not in (2, 3) or array.size == 0 or array.dtype.kind not in "iufb" or array.dtype.itemsize > 8:
        raise ValueError(f"array has the shape {array.shape} and the type {array.dtype}; [I, J, K] real numbers are needed")
    if affine.shape not in ((4, 4), (3, 4)) or (len(affine) == 4 and (affine[3] != (0, 0, 0, 1)).any()):
        raise ValueError("affine is no matrix [4, 4] with the last row 0, 0, 0, 1, and none [3, 4]")
    kind = {np.dtype(bool): np.uint8, np.dtype(np.float16): np.float32}.get(array.dtype, array.dtype.newbyteorder("="))
    values = array.astype(kind).reshape(-1, order="F")
    affine = np.vstack([affine[:3], [0, 0, 0, 1]])
    try:
        image = to_image("array", Volume((array.shape + (1,))[:3], affine, values, SPACES[space]), "RAS")
    except FormatError as error:
        raise ValueError(str(error)) from None
    image.GetPointData().GetScalars().SetName(name)
    return image


def with_array(path, image, name):
    """The image with the point array or cell array ``name`` as its scalars, cells as points; None: the image, or its cells
    when its points have no values. Raises ValueError when there is no such array."""
    points, cells = image.GetPointData(), image.GetCellData()
    if name is None:
        has_cells_only = points.GetNumberOfArrays() == 0 and cells.GetNumberOfArrays() > 0
        return cells_as_points(image) if has_cells_only else image
    if points.GetArray(name) is not None:
        points.SetActiveScalars(name)
        return image
    if cells.GetArray(name) is None:
        names = [data.GetArrayName(k) for data in (points, cells) for k in range(data.GetNumberOfArrays())]
        raise ValueError(f"{path}: there is no array '{name}'; there are {', '.join(map(str, names)) or 'none'}")
    image = cells_as_points(image)
    image.GetPointData().SetActiveScalars(name)
    return image


def cells_as_points(image):
    """A vtkImageData with a point at the center of each cell and the cell arrays as point arrays."""
    extent, flat = list(image.GetExtent()), image.GetDimensions()
    center = [0.0, 0.0, 0.0]
    first = [extent[2 * axis] + (0.5 if flat[axis] > 1 else 0.0) for axis in range(3)]
    image.TransformContinuousIndexToPhysicalPoint(first, center)
    result = vtkImageData()
    result.SetDimensions(*(max(size - 1, 1) for size in flat))
    result.SetSpacing(image.GetSpacing())
    result.SetDirectionMatrix(image.GetDirectionMatrix())
    result.SetOrigin(center)
    result.GetPointData().ShallowCopy(image.GetCellData())
    return result


def _warn_of_values_that_are_not_finite(path, values):
    if values.dtype.kind == "f" and not np.isfinite(values.sum(dtype=np.float64)):  # quick; a sum may also overflow
        count = int(np.count_nonzero(~np.isfinite(values)))
        if count:
            warnings.warn(
                f"{path}: {count:,} of {len(values):,} samples are NaN or infinite", SurfaceSynthesisWarning, stacklevel=4
            )


def _listed(numbers):
    return ", ".join(f"{number:.6g}" for number in numbers)


def count_samples(path, dimensions):
    """The number of samples; raises FormatError when a dimension is not from 1 to 2^31 - 1."""
    total = 1
    for size in dimensions:
        if not 1 <= size < 2**31:
            raise FormatError(f"{path}: the volume has the dimensions {_listed(dimensions)}; from 1 to 2147483647 are needed")
        total *= int(size)
    return total


def read_samples(path, count, kind, offset, compressed):
    """``count`` values of the NumPy type ``kind`` that begin ``offset`` bytes into a file, or into what is compressed
    in it ("gzip"; "raw": the bytes behind ``offset`` are compressed by themselves; None)."""
    kind = np.dtype(kind)
    needed = count * kind.itemsize
    begin = offset if compressed != "gzip" else 0
    stored = os.path.getsize(path) - begin
    available = stored if compressed is None else stored * LARGEST_RATIO - (offset if compressed == "gzip" else 0)
    if needed > available:
        raise _too_short(path, needed, max(stored, 0), compressed)
    with open(path, "rb") as file:
        file.seek(begin)
        data = file.read(needed) if compressed is None else _inflate(path, file, offset - begin, needed)
    if len(data) < needed:
        raise _too_short(path, needed, len(data), None)
    return np.frombuffer(data, dtype=kind, count=count)


def _too_short(path, needed, found, compressed):
    what = "compressed bytes follow" if compressed else "follow"
    return FormatError(f"{path}: the file is cut off: its header announces {needed} bytes of samples, {found} {what}")


def _inflate(path, file, skip, needed):
    """``needed`` bytes, behind ``skip``, of the gzip or zlib stream that begins where ``file`` stands; fewer when it ends."""
    inflater = zlib.decompressobj(wbits=47)  # gzip or zlib, whichever it is
    target, filled, rest = bytearray(needed), 0, b""
    try:
        while filled < needed and not inflater.eof:
            block = rest or file.read(1 << 20)
            if not block:
                break
            part = inflater.decompress(block, 1 << 24)
            rest = inflater.unconsumed_tail
            used = min(max(len(part) - skip, 0), needed - filled)
            target[filled : filled + used] = memoryview(part)[skip : skip + used]
            skip, filled = max(skip - len(part), 0), filled + used
    except zlib.error as error:
        raise FormatError(f"{path}: the compressed data is damaged: {error}") from None
    return memoryview(target)[:filled]


def read_head(path, size):
    """The first ``size`` bytes, of the uncompressed file when it is compressed; and whether it is."""
    with open(path, "rb") as file:
        compressed = file.read(2) == b"\x1f\x8b"
    try:
        with (gzip.open(path, "rb") if compressed else open(path, "rb")) as file:
            return file.read(size), compressed
    except (EOFError, zlib.error, gzip.BadGzipFile) as error:
        raise FormatError(f"{path}: the compressed data is damaged: {error}") from None
