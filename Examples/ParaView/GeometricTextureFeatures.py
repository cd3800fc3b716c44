# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: the peaks of a synthesized texture, each with a ball; merged ones in red. Needs no other file."""

import os
import sys

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

#: The points with a peak alone.
PEAKS = """
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
surface = self.GetInputDataObject(0, 0)
peaks = vtk_to_numpy(surface.GetPointData().GetArray("Peak"))
points = vtk_to_numpy(surface.GetPoints().GetData())[peaks > 0]
places = vtkPoints()
places.SetData(numpy_to_vtk(points, deep=True))
output.SetPoints(places)
kinds = numpy_to_vtk(peaks[peaks > 0], deep=True)
kinds.SetName("Peak")
output.GetPointData().SetScalars(kinds)
"""

texture = GeometricTextureSynthesizer(registrationName="Spikes", Input=demo.figure(30), Seed=1)
texture.ModelFileName = demo.model("spikes")
features = GeometricTextureFeatures(registrationName="Features", Input=texture)
peaks = ProgrammableFilter(registrationName="Peaks", Input=features, Script=PEAKS)
balls = Glyph(registrationName="Balls", Input=peaks, GlyphType="Sphere", GlyphMode="All Points", ScaleFactor=0.045)
balls.ScaleArray = ["POINTS", "No scale array"]

view = demo.picture(None)
demo.show(demo.smooth(features), view)
demo.show(balls, view, "Peak", bar=False, preset="Cool to Warm", limits=(1.0, 2.0))
demo.fill(view, texture, top=0.12)
row = {name: values[0].ToDouble() for name, values in demo.rows_of(features, 1).items()}
text = f"{row['NumberOfPeaks']:.0f} peaks, {100 * row['MergedShare']:.0f} % merged"
demo.write(f"{text}, heights +- {100 * row['PeakHeightVariation']:.0f} %", view, (0.04, 0.93))
