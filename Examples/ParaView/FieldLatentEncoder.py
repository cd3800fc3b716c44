# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: a coat encoded on a figure: lengths of the first tangent vectors, and arrows along them. Needs a model
of field latents and no other file."""

import os
import sys

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

even = IsotropicRemesh(registrationName="Even", Input=demo.figure(60), TargetNumberOfPoints=1500)
latents = FieldLatentEncoder(registrationName="Latents", Input=demo.laid_out(even), TextureImage=demo.coat())
latents.ModelFileName = demo.model("field_latents")
arrows = Glyph(registrationName="Arrows", Input=latents, GlyphType="Arrow", ScaleFactor=0.13)
arrows.OrientationArray = ["POINTS", "FieldLatent_0"]
arrows.ScaleArray = ["POINTS", "No scale array"]
arrows.GlyphMode = "All Points"

view = demo.picture(None)
demo.show(latents, view, "FieldLatent_0", preset="Viridis (matplotlib)", title="First vector, length")
demo.edges(Show(latents, view), (0.1, 0.1, 0.15))
light = demo.show(arrows, view)
light.AmbientColor = light.DiffuseColor = [1.0, 0.98, 0.9]
demo.fill(view, latents)
view.CameraPosition, view.CameraFocalPoint = [0.5, 0.9, 3.6], [0.1, 0.5, 0.0]
