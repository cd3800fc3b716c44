# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: eight rocks of Matern noise, laid out in a grid. Needs no file."""

import os
import sys

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

sphere = Sphere(registrationName="Sphere", Radius=1.0, ThetaResolution=80, PhiResolution=80)
rocks = []
for seed in range(8):
    bumps = MaternNoise(Input=sphere, CorrelationRange=1.2, StandardDeviation=0.22, Seed=seed, OutputArrayName="Bumps")
    rocks.append(demo.smooth(WarpByScalar(Input=bumps, Scalars=["POINTS", "Bumps"]), f"Rock {seed}"))
ensemble = GroupDatasets(registrationName="Ensemble", Input=rocks)
layout = EnsembleLayout(registrationName="Layout", Input=ensemble)

view = demo.picture(None)
demo.show(layout, view, "Bumps", preset="Cool to Warm", limits=(-0.6, 0.6))
demo.fill(view, layout, right=0.14)
