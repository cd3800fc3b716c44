# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: triangles of an isosurface, and even ones of the same surface. Needs no file."""

import os
import sys

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

scan = demo.figure(34)
even = IsotropicRemesh(registrationName="Even", Input=scan, TargetNumberOfPoints=1200)
pair = EnsembleLayout(
    registrationName="Before and after", Input=GroupDatasets(Input=[scan, even]), Arrangement="Row", Spacing=0.05
)

view = demo.picture(None)
demo.edges(demo.show(pair, view))
demo.fill(view, pair)
