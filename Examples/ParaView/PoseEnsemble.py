# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: twelve random poses of a figure, side by side. Needs no file."""

import os
import sys

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

poses = PoseEnsemble(registrationName="Poses", Input=demo.figure(36))
poses.NumberOfSamples = 12
poses.Seed = 1

view = demo.picture(None)
demo.show(demo.smooth(poses), view, "Displacement", preset="Viridis (matplotlib)", title="Displacement")
demo.fill(view, poses, right=0.14)
