# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: an isosurface of the source Wavelet, open at the box, and the closed surface of the same values.
Needs no file."""

import os
import sys

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

wavelet = Wavelet(registrationName="Wavelet", WholeExtent=[-20, 20, -20, 20, -20, 20])
open_surface = Contour(registrationName="Open", Input=wavelet, ContourBy=["POINTS", "RTData"], Isosurfaces=[150.0])
closed = VDBSurface(registrationName="Closed", Input=wavelet, Scalars=["POINTS", "RTData"])
closed.ComputeIsoValue = 0
closed.IsoValue = 150.0
pair = EnsembleLayout(registrationName="Both", Input=GroupDatasets(Input=[open_surface, closed]), Arrangement="Row")

view = demo.picture(((22.0, 55.0, 150.0), (22.0, 0.0, 0.0), (0.0, 1.0, 0.0)))
demo.show(demo.smooth(pair), view)
