# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: a random mixture of Gaussians on a figure. Needs no file."""

import os
import sys

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

mixture = GaussianMixture(registrationName="Mixture", Input=demo.figure(90))
mixture.NumberOfCenters = 6
mixture.Seed = 2

view = demo.picture(((1.6, 1.0, 6.6), (0.0, -0.2, 0.0), (0.0, 1.0, 0.0)))
demo.show(demo.smooth(mixture), view, "Mixture", preset="Inferno (matplotlib)", limits=(0.0, 1.0))
