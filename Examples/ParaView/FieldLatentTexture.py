# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: grain of wood on a figure, by a shipped model, along directions from head to tail. Needs no
other file."""

import os
import sys

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

directed = Calculator(registrationName="Directed", Input=demo.figure(140), Function="-jHat", ResultArrayName="Direction")
texture = FieldLatentTexture(registrationName="Wood", Input=directed)
texture.ModelFileName = demo.model("wood")
texture.AutoencoderFileName = demo.model("field_latents")
texture.DirectionArrayName = "Direction"
texture.NumberOfPoints = 9000
if demo.QUICK:
    texture.NumberOfPoints = 300
    texture.NumberOfSteps = 2
    texture.Resolution = [128, 128]

view = demo.picture(((1.2, 0.8, 6.2), (0.0, -0.2, 0.0), (0.0, 1.0, 0.0)))
display = Show(demo.smooth(texture), view)
ColorBy(display, ("POINTS", "Texture"))
display.MapScalars = 0  # the client does so by itself
display.Ambient, display.Diffuse = 0.25, 1.0
