# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: the report on a damaged figure, beside it. Needs no file."""

import os
import sys

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

hole = Clip(registrationName="Hole", Input=demo.figure(60), ClipType="Sphere", Invert=0)
hole.ClipType.Center = [0.1, 0.1, 0.4]
hole.ClipType.Radius = 0.26
surface = ExtractSurface(registrationName="Damaged", Input=hole)
report = TopologyReport(registrationName="Report", Input=surface)
borders = FeatureEdges(registrationName="Open edges", Input=surface, FeatureEdges=0, NonManifoldEdges=0, ManifoldEdges=0)

view = demo.picture(((-1.3, 0.5, 7.6), (-1.3, -0.2, 0.0), (0.0, 1.0, 0.0)))
demo.show(surface, view)
edges = demo.show(borders, view)
edges.AmbientColor = edges.DiffuseColor = [0.85, 0.15, 0.1]
edges.LineWidth = 5.0
text = Text(registrationName="Text", Text=demo.lines_of(report))
display = Show(text, view)
display.Color = [0.0, 0.0, 0.0]
display.FontSize = 20
display.Justification = "Left"
display.WindowLocation = "Upper Left Corner"
