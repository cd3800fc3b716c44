# SPDX-License-Identifier: BSD-3-Clause
"""Images of textures: PNG, JPEG, BMP and TGA by VTK's readers, PNG by VTK's writer.

The size in the header is compared with the limits below, and that of uncompressed formats with the file, before VTK reads:
VTK takes the memory that a header announces. VTK's readers run in a process of their own, which damaged files may end. Row 0 of an image is the lowest one, as in VTK.
"""

import os
import struct
import subprocess
import sys
import tempfile

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkIOImage import vtkPNGWriter

from ..errors import FormatError, SurfaceSynthesisError
from ..pipeline import silent_console

#: Texels along a side, and in all.
LARGEST_SIDE, MOST_TEXELS = 32768, 1 << 28
#: Markers of JPEG with a size: frames of all kinds.
_FRAMES = set(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}


def read_image(path):
    """The vtkImageData of a PNG, JPEG, BMP or TGA file, known by its first bytes; TGA, which has none, by the extension.
    Raises OSError and FormatError."""
    with open(path, "rb") as file:
        data = file.read()
    return image_of(path, data, os.path.splitext(path)[1].lower() == ".tga")


def image_of(path, data, is_tga=False):
    """The vtkImageData of the bytes of an image; ``path`` begins messages."""
    kind, size = _kind(path, data, is_tga)
    if size is None or not all(1 <= side <= LARGEST_SIDE for side in size) or size[0] * size[1] > MOST_TEXELS:
        found = "no size" if size is None else f"{size[0]} x {size[1]} texels"
        raise FormatError(
            f"{path}: the {kind} image has {found}; at most {LARGEST_SIDE} along a side and {MOST_TEXELS} in all can be read"
        )
    texels = _texels_of(path, kind, data)
    if texels.shape[1::-1] != tuple(size):
        raise FormatError(f"{path}: the {kind} image is not of the size in its header")
    array = numpy_to_vtk(np.ascontiguousarray(texels.reshape(-1, texels.shape[2])), deep=True)
    array.SetName("Texture")
    image = vtkImageData()
    image.SetDimensions(size[0], size[1], 1)
    image.GetPointData().SetScalars(array)
    return image


def _texels_of(path, kind, data):
    """The texels [H, W, C] of an image, by VTK in another process."""
    program = os.path.join(os.path.dirname(os.path.abspath(__file__)), "image_process.py")
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    with tempfile.TemporaryDirectory() as folder:
        name, texels = os.path.join(folder, "image"), os.path.join(folder, "texels.npy")
        with open(name, "wb") as file:
            file.write(data)
        done = subprocess.run([sys.executable, program, kind, name, texels], env=environment, capture_output=True, check=False)
        if done.returncode != 0:
            raise FormatError(f"{path}: the {kind} image cannot be read: it is damaged or cut off")
        return np.load(texels)


def _kind(path, data, is_tga):
    """Name of the format, and width and height in the header, or None."""
    if data[:8] == b"\x89PNG\r\n\x1a\n":
        size = struct.unpack_from(">II", data, 16) if data[12:16] == b"IHDR" and len(data) >= 33 else None
        if size is not None and b"IEND" not in data[-12:]:
            raise FormatError(f"{path}: the PNG image is cut off")
        return "PNG", size
    if data[:2] == b"\xff\xd8":
        return "JPEG", _jpeg_size(data)
    if data[:2] == b"BM":
        return "BMP", _bmp_size(path, data)
    if is_tga:
        return "TGA", _tga_size(path, data)
    raise FormatError(f"{path}: this is no PNG, JPEG, BMP or TGA image")


def _jpeg_size(data):
    position = 2
    while position + 9 <= len(data) and data[position] == 0xFF:
        marker = data[position + 1]
        if marker in _FRAMES:
            height, width = struct.unpack_from(">HH", data, position + 5)
            return width, height
        if marker == 0xFF:  # padding
            position += 1
        elif marker == 0x01 or 0xD0 <= marker <= 0xD8:  # without a length
            position += 2
        else:
            position += 2 + struct.unpack_from(">H", data, position + 2)[0]
    return None


def _bmp_size(path, data):
    if len(data) < 54:
        return None
    offset, header, width, height, _, depth, compression = struct.unpack_from("<IIiiHHI", data, 10)
    if header < 40 or depth != 24 or compression != 0:
        raise FormatError(f"{path}: of BMP images those with 24 bits and without compression can be read; save it as PNG")
    row = (3 * max(width, 0) + 3) // 4 * 4
    if offset + row * abs(height) > len(data):
        raise FormatError(f"{path}: the BMP image is cut off")
    return width, abs(height)


def _tga_size(path, data):
    if len(data) < 18:
        return None
    kind, width, height, depth = data[2], *struct.unpack_from("<HHB", data, 12)
    if data[1] != 0 or kind != 2 or depth not in (24, 32):
        raise FormatError(
            f"{path}: of TGA images those with 24 or 32 bits and without compression can be read; save it as PNG"
        )
    if 18 + data[0] + width * height * depth // 8 > len(data):
        raise FormatError(f"{path}: the TGA image is cut off")
    return width, height


def png_of(image):
    """The bytes of a PNG file of a vtkImageData with 1 to 4 components: 8 bits each. Integers are scaled by their range,
    floating-point numbers from 0 to 1. Raises TypeError and ValueError."""
    if not isinstance(image, vtkImageData):
        raise TypeError(f"image must be a vtkImageData, not {type(image).__name__}")
    width, height, depth = image.GetDimensions()
    scalars = image.GetPointData().GetScalars()
    if depth != 1 or width < 1 or height < 1 or scalars is None or not 1 <= scalars.GetNumberOfComponents() <= 4:
        found = "without scalars" if scalars is None else f"with {scalars.GetNumberOfComponents()} components"
        raise ValueError(
            f"image must be a slice of 1 to 4 components as its active scalars, not {width} x {height} x {depth} {found}"
        )
    texels = numpy_to_vtk(_bytes_of(vtk_to_numpy(scalars)), deep=True)
    texels.SetName("Texture")
    plain = vtkImageData()
    plain.SetDimensions(width, height, 1)
    plain.GetPointData().SetScalars(texels)
    writer = vtkPNGWriter()
    writer.SetInputData(plain)
    writer.WriteToMemoryOn()
    with silent_console() as collected:
        writer.Write()
        errors, _ = collected()
    result = writer.GetResult()
    if errors or result is None or result.GetNumberOfTuples() == 0:
        raise SurfaceSynthesisError(*errors or ["the image could not be written as PNG"])
    return vtk_to_numpy(result).tobytes()


def _bytes_of(values):
    if values.dtype == np.uint8:
        return values
    if values.dtype.kind == "f":
        fractions = np.nan_to_num(values.astype(np.float64), nan=0.0, posinf=1.0, neginf=0.0)
    else:
        fractions = values.astype(np.float64) / np.iinfo(values.dtype).max
    return np.round(255 * np.clip(fractions, 0.0, 1.0)).astype(np.uint8)
