# SPDX-License-Identifier: BSD-3-Clause
"""DICOM: the series of slices in a folder, or one file, with GDCM (python3-gdcm) in a process of its own.

Places of samples follow from the positions and orientations of the slices, not from their order or thickness.
"""

import contextlib
import json
import os
import subprocess
import sys
import warnings
from typing import NamedTuple

import numpy as np

from ..errors import FormatError, SurfaceSynthesisError, SurfaceSynthesisWarning
from .volumes import LARGEST_RATIO, SPACES, Volume, count_samples

#: Difference of direction cosines between slices of one orientation, and of distances between slices, in distances.
_SAME_DIRECTION = 1e-3
_SAME_DISTANCE = 0.1


class _Slice(NamedTuple):
    """``position`` and ``axes`` [3, 2] (of columns and rows, with their lengths), in LPS."""

    file: str
    frame: int
    order: tuple
    position: np.ndarray
    axes: np.ndarray
    thickness: float
    scale: tuple


def read_dicom(path, series=None):
    """Reads a file, or of a folder the series whose number or UID is ``series`` (None: the only one), as a Volume in LPS.
    Folders in the folder and files that are not DICOM are left out. Raises FormatError, OSError, ValueError when there is
    no such series, and SurfaceSynthesisError without GDCM."""
    names = _names(path)
    headers = [header for header in _headers(path, names) if header["rows"] not in ("", "0")]
    if not headers:
        raise FormatError(f"{path}: no DICOM file with an image is here")
    headers = _one_series(path, headers, series)
    first = headers[0]
    kind = _kind(first)
    for header in headers[1:]:
        if any(header[key] != first[key] for key in ("rows", "columns", "bits", "signed", "channels")):
            raise FormatError(f"{header['file']}: size or type of the samples differ from those of {first['file']}")
    slices = _in_order(path, [item for header in headers for item in _slices(header)])
    dimensions = (_integer(first, "columns"), _integer(first, "rows"), len(slices))
    values = _values(path, headers, slices, dimensions, kind)
    return Volume(dimensions, _affine(slices), values, SPACES["LPS"])


def _names(path):
    if os.path.isfile(path):
        return [path]
    names = sorted(entry.path for entry in os.scandir(path) if entry.is_file())
    return [name for name in names if _is_dicom(name)]


def _is_dicom(name):
    with open(name, "rb") as file:
        return file.read(132)[128:] == b"DICM"


def _headers(path, names):
    if not names or not _is_dicom(names[0]):
        raise FormatError(f"{path}: no DICOM file is here: none has the letters DICM at byte 128")
    headers, name = [], None
    for answer in _answers("headers", names):
        name = answer.get("file", name)
        if "rows" in answer:
            headers.append({**answer, "file": name})
    return headers


def _answers(mode, names, take=None, largest=0):
    """The lines that the process writes; ``take(file, bytes)`` reads samples from its output. Raises FormatError when it
    ends early."""
    program = os.path.join(os.path.dirname(os.path.abspath(__file__)), "dicom_process.py")
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    process = subprocess.Popen(
        [sys.executable, program, mode, str(largest)], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL, env=environment,
    )  # fmt: skip
    name, finished = names[0], 0
    try:
        with contextlib.suppress(BrokenPipeError), process.stdin as stream:
            stream.write("".join(json.dumps(name) + "\n" for name in names).encode())
        for line in process.stdout:
            answer = json.loads(line) if line.endswith(b"\n") else {}
            if answer.get("error") == "missing":
                raise SurfaceSynthesisError(f"{name}: DICOM files need GDCM's Python module (Debian: python3-gdcm)")
            if "error" in answer:
                raise FormatError(f"{name}: {answer['error']}")
            name = answer.get("file", name)
            finished += "rows" in answer or "bytes" in answer
            if "bytes" in answer:
                take(name, answer["bytes"], process.stdout)
            yield answer
        if process.wait() != 0 or finished != len(names):
            raise FormatError(f"{name}: GDCM failed at this file; it is damaged")
    finally:
        process.kill()
        process.stdout.close()
        process.wait()


def _one_series(path, headers, series):
    found = {}
    for header in headers:
        found.setdefault(header["uid"], []).append(header)
    if series is not None:
        chosen = [uid for uid in found if str(series) in (uid, found[uid][0]["number"])]
    else:
        chosen = list(found)
    if len(chosen) == 1:
        return found[chosen[0]]
    listed = "; ".join(
        f"{found[uid][0]['number'] or uid} ({len(found[uid])} files, {found[uid][0]['description'][:40]})"
        for uid in list(found)[:20]
    )
    if series is not None:
        raise ValueError(f"{path}: series {series} names {len(chosen)} series; there are {listed}")
    raise FormatError(f"{path}: there are {len(found)} series; choose one by its number with series: {listed}")


def _integer(header, key, default=None):
    text = header[key] or default
    if text is None or not text.isascii() or not text.isdigit() or len(text) > 9:
        raise FormatError(f"{header['file']}: the number of {key} is '{header[key][:40]}'")
    return int(text)


def _numbers(file, words, key, count, default=None):
    text = words.get(key, "")
    if not text and default is not None:
        return default
    try:
        numbers = [float(word) for word in text.split("\\")]
    except ValueError:
        numbers = []
    if len(numbers) != count or not np.isfinite(numbers).all():
        what = f"is '{text[:60]}'; {count} numbers are needed" if text else "is missing"
        raise FormatError(f"{file}: the {key} of a slice {what}")
    return numbers


def _kind(header):
    if header["channels"] not in ("", "1") or header["photometric"] not in ("MONOCHROME1", "MONOCHROME2"):
        raise FormatError(
            f"{header['file']}: the samples are colors ({header['photometric'][:40]}); one number at each voxel is needed"
        )
    if header["bits"] not in ("8", "16", "32"):
        raise FormatError(f"{header['file']}: samples of {header['bits'][:40]} bits cannot be read; 8, 16 and 32 can")
    return np.dtype(("i" if header["signed"] == "1" else "u") + str(int(header["bits"]) // 8))


def _slices(header):
    file, frames = header["file"], _integer(header, "frames", "1")
    groups = header["groups"]
    if frames != 1 and len(groups) != frames:
        raise FormatError(f"{file}: {frames} frames have {len(groups)} places")
    for frame in range(frames):
        words = {**header, **groups[frame]} if groups else header
        position = np.array(_numbers(file, words, "position", 3))
        cosines = np.reshape(_numbers(file, words, "orientation", 6), (2, 3)).T
        rows, columns = _numbers(file, words, "spacing", 2)  # the distance of rows comes first
        thickness = _numbers(file, words, "between", 1, _numbers(file, words, "thickness", 1, [1.0]))[0]
        scale = (_numbers(file, words, "slope", 1, [1.0])[0], _numbers(file, words, "intercept", 1, [0.0])[0])
        numbers = (header[key] for key in ("acquisition", "instance"))
        order = tuple(int(text) if text.isascii() and text.isdigit() and len(text) < 19 else 0 for text in numbers)
        yield _Slice(file, frame, (*order, frame), position, cosines * [columns, rows], abs(thickness) or 1.0, scale)


def _in_order(path, slices):
    """The slices of one volume, one behind the other along their normal."""
    first = slices[0]
    for item in slices:
        if not np.allclose(item.axes, first.axes, rtol=0, atol=_SAME_DIRECTION * np.abs(first.axes).max()):
            raise FormatError(f"{path}: the slices of {first.file} and {item.file} have other orientations or spacings")
    normal = _normal(first)
    places = {}
    for item in sorted(slices, key=lambda item: (float(item.position @ normal), item.order)):
        known = next((key for key in (list(places)[-1:]) if abs(item.position @ normal - key) < 1e-4), None)
        places.setdefault(known if known is not None else float(item.position @ normal), []).append(item)
    counts = {len(items) for items in places.values()}
    if counts != {1}:
        if len(counts) > 1:
            raise FormatError(f"{path}: at some places lie {min(counts)} slices, at others {max(counts)}")
        warnings.warn(f"{path}: the first of {max(counts)} volumes is read", SurfaceSynthesisWarning, stacklevel=5)
    slices = [min(items, key=lambda item: item.order) for items in places.values()]
    distances = np.array(list(places))
    even = np.linspace(distances[0], distances[-1], len(slices))
    step = (distances[-1] - distances[0]) / max(len(slices) - 1, 1)
    if np.abs(distances - even).max() > _SAME_DISTANCE * step:
        gaps = np.diff(distances)
        raise FormatError(
            f"{path}: the distances between slices are from {gaps.min():.6g} to {gaps.max():.6g}; a slice is missing, "
            "or the slices must be resampled first"
        )
    return slices


def _normal(item):
    normal = np.cross(item.axes[:, 0], item.axes[:, 1])
    length = np.linalg.norm(normal)
    if not length > 0:
        raise FormatError(f"{item.file}: the orientation or the spacing of a slice is 0")
    return normal / length


def _affine(slices):
    first, last = slices[0], slices[-1]
    affine = np.eye(4)
    affine[:3, :2] = first.axes
    if len(slices) > 1:
        affine[:3, 2] = (last.position - first.position) / (len(slices) - 1)
    else:
        affine[:3, 2] = _normal(first) * first.thickness
    affine[:3, 3] = first.position
    return affine


def _values(path, headers, slices, dimensions, kind):
    """The values of the slices, with slope and intercept of each."""
    count_samples(path, dimensions)
    size = dimensions[0] * dimensions[1]
    headers = {header["file"]: header for header in headers}
    lengths = {name: size * _integer(header, "frames", "1") * kind.itemsize for name, header in headers.items()}
    for name, header in headers.items():
        stored = os.path.getsize(name) - header["begin"] * (not header["encapsulated"])
        if lengths[name] > stored * (LARGEST_RATIO if header["encapsulated"] else 1):
            raise FormatError(
                f"{name}: the file is cut off: its header announces {lengths[name]} bytes of samples, {stored} follow"
            )
    wanted = {}
    for place, item in enumerate(slices):
        wanted.setdefault(item.file, []).append((item.frame, place))
    values = np.empty((dimensions[2], size), dtype=kind)

    def take(name, length, stream):
        if length != lengths[name]:
            raise FormatError(f"{name}: there are {length} bytes of samples, not {lengths[name]}")
        data = stream.read(length)
        if len(data) != length:
            raise FormatError(f"{name}: the file is damaged: its samples end early")
        found = np.frombuffer(data, dtype=kind.newbyteorder("<")).reshape(-1, size)
        for frame, place in wanted[name]:
            values[place] = found[frame]

    others = []
    for name in wanted:
        unused = _unused_bits(headers[name], kind)
        if unused is None:
            others.append(name)
            continue
        with open(name, "rb") as file:
            file.seek(headers[name]["begin"])
            take(name, lengths[name], file)
        for _, place in wanted[name]:  # shifted there and back, which also extends the sign
            values[place] = values[place] << unused >> unused
    for _ in _answers("samples", others, take, max(lengths.values())) if others else ():
        pass
    return _scaled(values, [item.scale for item in slices])


def _unused_bits(header, kind):
    """The bits in front of each sample that are no part of it, for samples that lie in the file as they are; else None."""
    stored, allocated = _integer(header, "stored", header["bits"]), 8 * kind.itemsize
    plain = header["plain"] and 1 <= stored <= allocated and _integer(header, "high", str(stored - 1)) == stored - 1
    return kind.type(allocated - stored) if plain else None


def _scaled(values, scales):
    if (np.array(scales) == (1.0, 0.0)).all():
        return values.reshape(-1)
    scaled = np.empty(values.shape, dtype=np.float32 if values.dtype.itemsize <= 2 else np.float64)
    for place, (slope, intercept) in enumerate(scales):
        scaled[place] = values[place] * slope + intercept
    return scaled.reshape(-1)
