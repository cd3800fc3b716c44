# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: the bumps of a square, and beside it a figure with bumps like them, without a training. Needs no other
file."""

import os
import sys

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

# Bumps on a lattice of triangles, about nine edges of the square's triangles apart.
BUMPS = "coords + kHat * 0.07 * (cos(13.3*coordsX) + cos(6.65*coordsX+11.5*coordsY) + cos(6.65*coordsX-11.5*coordsY))"

cells = 30 if demo.QUICK else 48
square = Plane(registrationName="Square", XResolution=cells, YResolution=cells)
square.Origin, square.Point1, square.Point2 = [-1.5, -1.5, 0.0], [1.5, -1.5, 0.0], [-1.5, 1.5, 0.0]
plain = Triangulate(registrationName="Plain", Input=square)
example = Calculator(registrationName="Example", Input=plain, CoordinateResults=1, Function=BUMPS)
even = IsotropicRemesh(registrationName="Even", Input=demo.figure(50), TargetNumberOfPoints=300 if demo.QUICK else 2500)
texture = GeometricTextureFromExample(registrationName="Bumps", Input=even, Example=example, PlainExample=plain, Seed=1)
texture.Subdivisions = 1 if demo.QUICK else 2
pair = EnsembleLayout(registrationName="Side by side", Input=GroupDatasets(Input=[example, texture]), Arrangement="Row")

view = demo.picture(None)
demo.show(demo.smooth(pair), view)
demo.fill(view, pair)
