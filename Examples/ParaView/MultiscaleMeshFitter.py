# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: meshes of one rock at three scales. Needs no file; takes a quarter of a minute."""

import os
import sys

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

sphere = Sphere(registrationName="Sphere", Radius=1.0, ThetaResolution=60, PhiResolution=60)
bumps = MaternNoise(registrationName="Bumps", Input=sphere, CorrelationRange=1.0, StandardDeviation=0.15, Seed=3)
rock = WarpByScalar(registrationName="Rock", Input=bumps, Scalars=["POINTS", "MaternNoise"])
levels = MultiscaleMeshFitter(registrationName="Levels", Input=rock, NumberOfLevels=3, Iterations=40, Samples=1000)
levels.TimeBudget = demo.minutes(0.5)
row = EnsembleLayout(registrationName="Side by side", Input=OutputPort(levels, 0), Arrangement="Row")

view = demo.picture(None)
demo.edges(demo.show(row, view))
demo.fill(view, row)
