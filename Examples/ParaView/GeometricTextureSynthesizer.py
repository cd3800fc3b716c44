# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: spikes on a figure, by a shipped model. Needs no other file."""

import os
import sys

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

texture = GeometricTextureSynthesizer(registrationName="Spikes", Input=demo.figure(60))
texture.ModelFileName = demo.model("spikes")

view = demo.picture(((1.6, 1.0, 7.0), (0.0, -0.2, 0.0), (0.0, 1.0, 0.0)))
demo.show(texture, view, "Displacement", preset="Viridis (matplotlib)", title="Displacement")
