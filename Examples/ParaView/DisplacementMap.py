# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: spikes on a figure, by a shipped model, and beside it the height map that makes them of the plain one."""

import os
import sys

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

# Puts the image, three units high, into the plane of the picture.
_LAY = """
from vtkmodules.vtkFiltersGeometry import vtkImageDataGeometryFilter
from vtkmodules.vtkCommonDataModel import vtkImageData
image = vtkImageData()
image.ShallowCopy(self.GetInputDataObject(0, 0))
image.SetSpacing(3.0 / image.GetDimensions()[0], 3.0 / image.GetDimensions()[1], 1.0)
image.SetOrigin(-1.5, -1.5, 0.0)
surface = vtkImageDataGeometryFilter()
surface.SetInputData(image)
surface.Update()
output.ShallowCopy(surface.GetOutput())
"""

size = 128 if demo.QUICK else 512
even = IsotropicRemesh(registrationName="Even", Input=demo.figure(50), TargetNumberOfPoints=600 if demo.QUICK else 2500)
spiky = GeometricTextureSynthesizer(registrationName="Spikes", Input=even, TargetPreparation="As Is", StartLevel=1)
spiky.ModelFileName = demo.model("spikes")
lengths = Calculator(registrationName="Lengths", Input=spiky, ResultArrayName="Height", Function="mag(Displacement)")
atlas = TextureAtlas(registrationName="Atlas", Input=even, Resolution=[size, size])
maps = DisplacementMap(registrationName="Maps", Input=atlas, Detailed=spiky, Resolution=[size, size])
image = ProgrammableFilter(registrationName="Image", Input=maps, OutputDataSetType="vtkPolyData", Script=_LAY)
pair = EnsembleLayout(
    registrationName="Surface and map", Input=GroupDatasets(Input=[lengths, image]), Arrangement="Row", Spacing=0.05
)

view = demo.picture(None)
demo.show(pair, view, "Height", bar=False, preset="Grayscale")
demo.fill(view, pair)
