# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: eight deformations of a figure, by a shipped model that was trained on poses of another one.
Needs no other file."""

import os
import sys

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

# proportions and stance of the shape that the model was trained on, the armadillo
turned = Transform(registrationName="Turned", Input=demo.figure(50))
turned.Transform.Scale = [0.94, 0.99, 1.41]
turned.Transform.Rotate = [-18.0, 0.0, 0.0]
shape = IsotropicRemesh(registrationName="Even", Input=turned, TargetNumberOfPoints=1500)
deformed = FlowMatchingDeformer(registrationName="Deformed", Input=shape, ModelFileName=demo.model("armadillo_poses"))
deformed.NumberOfSamples = 8
layout = EnsembleLayout(registrationName="Side by side", Input=deformed)

view = demo.picture(None)
demo.show(demo.smooth(layout), view, "Displacement", preset="Viridis (matplotlib)")
demo.fill(view, layout, right=0.14)
