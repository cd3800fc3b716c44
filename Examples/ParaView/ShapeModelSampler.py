# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: new shapes of a model that statistics of forty poses of a figure make. Needs no file."""

import os
import sys

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

poses = PoseEnsemble(registrationName="Poses", Input=demo.figure(36), NumberOfSamples=6 if demo.QUICK else 40, Spread=0.0)
poses.MaximumAngle = 25.0  # linear modes do not turn limbs
statistics = EnsembleStatistics(registrationName="Statistics", Input=poses, NumberOfModes=4 if demo.QUICK else 12)
shapes = ShapeModelSampler(registrationName="Shapes", Input=statistics, Shapes=None, NumberOfSamples=6)
layout = EnsembleLayout(registrationName="Side by side", Input=shapes, NumberOfColumns=3)

view = demo.picture(None)
demo.show(demo.smooth(layout), view)
demo.fill(view, layout)
