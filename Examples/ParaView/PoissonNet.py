# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: the smoothed mean curvature of a rock, predicted by a shipped network. Needs no other file."""

import os
import sys

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

predicted = PoissonNet(
    registrationName="Curvature", Input=demo.figure(90), ModelFileName=demo.model("smoothed_curvature")
)

view = demo.picture(((1.6, 1.0, 6.6), (0.0, -0.2, 0.0), (0.0, 1.0, 0.0)))
demo.show(demo.smooth(predicted), view, "Prediction", preset="Cool to Warm", title="Predicted curvature")
