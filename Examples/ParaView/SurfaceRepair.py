# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: a figure with holes, which the repair closes with triangles in color. Needs no file."""

import os
import sys

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

damaged = demo.figure(44)
for name, center, radius in (
    ("Belly", (0.1, 0.1, 0.4), 0.26),
    ("Hand", (1.4, 1.2, 0.3), 0.25),
    ("Leg", (-0.6, -0.9, 0.3), 0.17),
):
    damaged = Clip(registrationName=name, Input=damaged, ClipType="Sphere", Invert=0)
    damaged.ClipType.Center = center
    damaged.ClipType.Radius = radius
surface = ExtractSurface(registrationName="Damaged", Input=damaged)
repaired = SurfaceRepair(registrationName="Repaired", Input=surface, HoleFilling="All")
pair = EnsembleLayout(
    registrationName="Before and after", Input=GroupDatasets(Input=[surface, repaired]), Arrangement="Row", Spacing=0.05
)

view = demo.picture(None)
display = demo.show(pair, view, "FilledHole", "CELLS", bar=False, limits=(0.0, 1.0))
colors = GetColorTransferFunction("FilledHole")
colors.RGBPoints = [0.0, *demo.CLAY, 1.0, 0.85, 0.25, 0.15]
display.AmbientColor = display.DiffuseColor = demo.CLAY
demo.edges(display)
demo.fill(view, pair)
