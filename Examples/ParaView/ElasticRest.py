# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: six rest states of a soft figure, side by side. Needs no file."""

import os
import sys

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

states = ElasticRest(registrationName="Rest States", Input=demo.figure(36))
states.UpDirection = [0.0, 1.0, 0.0]
states.Seed = 1

view = demo.picture(None)
demo.show(demo.smooth(states), view, "Displacement", preset="Viridis (matplotlib)", title="Displacement")
demo.fill(view, states, right=0.14)
