# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: the tetrahedra inside a figure, cut open. Needs no file."""

import os
import sys

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

even = IsotropicRemesh(registrationName="Even", Input=demo.figure(50), TargetNumberOfPoints=2500)
tetrahedra = TetrahedralizeSurface(registrationName="Tetrahedra", Input=even, TargetEdgeLength=0.12)
quality = MeshQuality(registrationName="Quality", Input=tetrahedra, TetQualityMeasure="Radius Ratio")
cut = Clip(registrationName="Cut", Input=quality, ClipType="Plane", Crinkleclip=1)
cut.ClipType.Origin = [0.0, 0.0, 0.06]
cut.ClipType.Normal = [0.0, 0.0, 1.0]

view = demo.picture(((2.0, 1.4, 6.4), (0.0, -0.2, 0.0), (0.0, 1.0, 0.0)))
demo.edges(
    demo.show(cut, view, "Quality", "CELLS", preset="Viridis (matplotlib)", limits=(1.0, 3.0), title="Radius ratio")
)
