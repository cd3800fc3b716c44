# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: random signals on a pebble, by a shipped model of mixtures of Gaussians. Needs no other file."""

import os
import sys

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

# proportions of the shape that the model was trained on, the bunny
sphere = Sphere(registrationName="Sphere", Radius=1.0, ThetaResolution=60, PhiResolution=60)
pebble = Transform(registrationName="Pebble", Input=sphere)
pebble.Transform.Scale = [1.0, 0.7, 0.55]
pebble.Transform.Rotate = [-10.0, -10.0, -45.0]
shape = IsotropicRemesh(registrationName="Even", Input=pebble, TargetNumberOfPoints=2500)
samples = [
    FlowMatchingSampler(
        registrationName=f"Signal {seed}", Input=shape, ModelFileName=demo.model("bunny_mixtures"), Seed=seed
    )
    for seed in range(6)
]
layout = EnsembleLayout(registrationName="Side by side", Input=GroupDatasets(Input=samples))

view = demo.picture(None)
demo.show(demo.smooth(layout), view, "Mixture", preset="Inferno (matplotlib)", limits=(0.0, 1.0))
demo.fill(view, layout, right=0.14)
