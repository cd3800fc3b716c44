# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: charts of a figure in colors, and beside it the image into which they are packed. Needs no file."""

import os
import sys

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

# Moves the points to their texture coordinates, in an image three units high.
_FLATTEN = """
import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
output.ShallowCopy(self.GetInputDataObject(0, 0))
coordinates = vtk_to_numpy(output.GetPointData().GetTCoords())
flat = np.column_stack([3.0 * coordinates - 1.5, np.zeros(len(coordinates))])
points = vtkPoints()
points.SetData(numpy_to_vtk(flat, deep=True))
output.SetPoints(points)
"""

even = IsotropicRemesh(registrationName="Even", Input=demo.figure(50), TargetNumberOfPoints=3000)
atlas = TextureAtlas(registrationName="Atlas", Input=even, Margin=8)
image = ProgrammableFilter(registrationName="Image", Input=atlas, Script=_FLATTEN)
pair = EnsembleLayout(
    registrationName="Surface and image", Input=GroupDatasets(Input=[atlas, image]), Arrangement="Row", Spacing=0.05
)

view = demo.picture(None)
display = demo.show(pair, view, "Chart", "CELLS", bar=False, preset="Rainbow Uniform")
demo.edges(display)
demo.fill(view, pair)
