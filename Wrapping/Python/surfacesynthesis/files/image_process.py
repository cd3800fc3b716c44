# SPDX-License-Identifier: BSD-3-Clause
"""Reads an image with VTK, as a program of its own: VTK's readers end the process at some malformed files.

    python3 image_process.py KIND FILE TEXELS    (KIND: PNG, JPEG, BMP or TGA)

Writes the texels [height, width, components], row 0 the lowest, to the file TEXELS in NumPy's format. Errors of VTK go to
standard error, and the exit status is 1. Nothing else of the package is imported.
"""

import resource
import sys

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOImage import vtkBMPReader, vtkJPEGReader, vtkPNGReader, vtkTGAReader

READERS = {"PNG": vtkPNGReader, "JPEG": vtkJPEGReader, "BMP": vtkBMPReader, "TGA": vtkTGAReader}
#: Memory and processor time that reading may take.
_MEMORY, _SECONDS = 8 << 30, 120


def main(kind, name, texels):
    """Reads the image and writes its texels; returns the exit status."""
    for limit, most in ((resource.RLIMIT_AS, _MEMORY), (resource.RLIMIT_CPU, _SECONDS), (resource.RLIMIT_CORE, 0)):
        hard = resource.getrlimit(limit)[1]
        resource.setrlimit(limit, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))
    failed = []
    reader = READERS[kind]()
    reader.AddObserver("ErrorEvent", lambda *_: failed.append(True))
    reader.SetFileName(name)
    reader.Update()
    width, height, _ = reader.GetOutput().GetDimensions()
    scalars = reader.GetOutput().GetPointData().GetScalars()
    if failed or reader.GetErrorCode() or scalars is None or scalars.GetNumberOfTuples() != width * height:
        return 1
    np.save(texels, vtk_to_numpy(scalars).reshape(height, width, -1))
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
