# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: the mean of forty poses of a figure, and how far each point is scattered. Needs no file."""

import os
import sys

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

poses = PoseEnsemble(registrationName="Poses", Input=demo.figure(36), NumberOfSamples=6 if demo.QUICK else 40, Spread=0.0)
statistics = EnsembleStatistics(registrationName="Statistics", Input=poses)

view = demo.picture(None)
shown = demo.smooth(statistics)
demo.show(shown, view, "StandardDistance", preset="Viridis (matplotlib)", title="Standard distance")
demo.fill(view, shown, right=0.14)
