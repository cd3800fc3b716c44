# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: the texture of a coarse triangulation, which its points alone cannot show, decoded onto a fine one.
Needs a model of field latents and no other file."""

import os
import sys

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

figure = demo.figure(60)
coarse = IsotropicRemesh(registrationName="Coarse", Input=figure, TargetNumberOfPoints=2500)
latents = FieldLatentEncoder(registrationName="Latents", Input=demo.laid_out(coarse), TextureImage=demo.coat())
fine = TextureAtlas(registrationName="Fine", Input=demo.figure(150))
decoded = FieldLatentDecoder(registrationName="Decoded", Input=latents, Target=fine)
latents.ModelFileName = decoded.ModelFileName = demo.model("field_latents")
if demo.QUICK:
    decoded.Resolution = [128, 128]
beside = Transform(registrationName="Beside", Input=latents)
beside.Transform.Translate = [-3.3, 0.0, 0.0]
pair = GroupDatasets(registrationName="Both", Input=[beside, decoded])

view = demo.picture(None)
demo.edges(demo.show(beside, view))
Show(decoded, view).MapScalars = 0  # the client does so by itself
demo.fill(view, pair)
