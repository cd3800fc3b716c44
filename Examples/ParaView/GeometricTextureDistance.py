# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: distances of the textures of three surfaces from that of the first, as a bar chart. Needs no other file."""

import os
import sys

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

figure = demo.figure(40)
surfaces = [
    GeometricTextureSynthesizer(registrationName=name, Input=figure, ModelFileName=demo.model(kind), Seed=seed)
    for name, kind, seed in (("Spikes", "spikes", 0), ("Other spikes", "spikes", 1), ("Knobs", "knobs", 0))
]
tables = [
    GeometricTextureDistance(registrationName=f"{surface} and spikes", Input=textured, Reference=surfaces[0])
    for surface, textured in (("Other spikes", surfaces[1]), ("Knobs", surfaces[2]), ("Smooth figure", figure))
]
view = demo.picture(None, "XYBarChartView")
demo.bars(tables, view, None, "Distance from the texture of spikes")
