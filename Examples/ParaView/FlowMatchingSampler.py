# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: a random signal on a figure, by a shipped model of mixtures of Gaussians. Needs no other file."""

import os
import sys

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

shape = IsotropicRemesh(registrationName="Even", Input=demo.figure(60), TargetNumberOfPoints=4000)
signal = FlowMatchingSampler(registrationName="Signal", Input=shape, ModelFileName=demo.model("bunny_mixtures"))
signal.Seed = 1

view = demo.picture(((1.6, 1.0, 6.6), (0.0, -0.2, 0.0), (0.0, 1.0, 0.0)))
demo.show(demo.smooth(signal), view, "Signal", preset="Inferno (matplotlib)")
