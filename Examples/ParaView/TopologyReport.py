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
borders = FeatureEdges(registrationName="Open edges", Input=surface)
borders.FeatureEdges = borders.NonManifoldEdges = borders.ManifoldEdges = 0

view = demo.picture(((-1.0, 0.5, 8.6), (-1.0, -0.1, 0.0), (0.0, 1.0, 0.0)))
demo.show(surface, view)
edges = demo.show(borders, view)
edges.AmbientColor = edges.DiffuseColor = [0.85, 0.15, 0.1]
edges.LineWidth = 5.0
columns = demo.rows_of(report)
found = dict(zip((value.ToString() for value in columns["Property"]), columns["Value"]))
lines = [f"{name}: {found[name].ToDouble():.6g}" for name in ("Points", "Triangles", "Components", "Genus",
         "BoundaryLoops", "BoundaryEdges", "NonManifoldEdges", "DegenerateTriangles", "Area")]
demo.write("\n".join(lines), view, (0.02, 0.55))
