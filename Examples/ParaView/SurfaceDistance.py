# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: the distance of a surface with few triangles from the surface that it was made of. Needs no file."""

import os
import sys

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

figure = demo.figure(60)
coarse = IsotropicRemesh(registrationName="Few triangles", Input=figure, TargetNumberOfPoints=250 if demo.QUICK else 500)
distance = SurfaceDistance(registrationName="Distance", Input=figure, Second=coarse)

view = demo.picture(None)
demo.show(demo.smooth(distance), view, "Distance", preset="Viridis (matplotlib)")
demo.fill(view, figure, top=0.2, right=0.14)
rows = demo.rows_of(distance, 1)
mean, farthest = (rows[column][2].ToDouble() for column in ("Mean", "Maximum"))
demo.write(f"mean {mean:.3f}, at most {farthest:.3f}", view, (0.04, 0.9))
