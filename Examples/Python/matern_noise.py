#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Matérn noise in a VTK pipeline: reader -> filter -> warp -> writer.

    python3 matern_noise.py [surface.stl] bumpy.vtp

Without an input, a sphere of radius 1 is used. The bumps are 0.15 times the longest side wide and 0.01 times high.
"""

import sys

from vtkmodules.vtkFiltersCore import vtkPolyDataNormals
from vtkmodules.vtkFiltersGeneral import vtkWarpScalar
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkIOGeometry import vtkSTLReader
from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

from surfacesynthesis import vtkMaternNoiseFilter


def main(arguments):
    if len(arguments) not in (1, 2):
        return __doc__
    if len(arguments) == 2:
        source = vtkSTLReader()
        source.SetFileName(arguments[0])
    else:
        source = vtkSphereSource()
        source.SetRadius(1.0)
        source.SetThetaResolution(200)
        source.SetPhiResolution(200)
    source.Update()
    if source.GetOutput().GetNumberOfPoints() == 0:
        return f"{arguments[0]} holds no surface"  # VTK has said why
    bounds = source.GetOutput().GetBounds()
    longest = max(bounds[2 * axis + 1] - bounds[2 * axis] for axis in range(3))

    normals = vtkPolyDataNormals()  # vtkWarpScalar moves points along them
    normals.SetInputConnection(source.GetOutputPort())
    normals.SplittingOff()

    noise = vtkMaternNoiseFilter()
    noise.SetInputConnection(normals.GetOutputPort())
    noise.SetCorrelationRange(0.15 * longest)
    noise.SetStandardDeviation(0.01 * longest)
    noise.SetSeed(1)

    warp = vtkWarpScalar()
    warp.SetInputConnection(noise.GetOutputPort())
    warp.SetInputArrayToProcess(0, 0, 0, 0, noise.GetOutputArrayName())  # a point array
    warp.SetScaleFactor(1.0)

    shading = vtkPolyDataNormals()  # the old normals do not fit the moved points
    shading.SetInputConnection(warp.GetOutputPort())
    shading.SplittingOff()

    writer = vtkXMLPolyDataWriter()
    writer.SetInputConnection(shading.GetOutputPort())
    writer.SetFileName(arguments[-1])
    if not writer.Write():
        return f"{arguments[-1]} could not be written"
    print(f"{warp.GetOutput().GetNumberOfPoints()} points, residual {noise.GetRelativeResidual():.1e}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
