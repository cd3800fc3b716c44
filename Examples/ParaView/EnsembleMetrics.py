# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: two ensembles of poses of one figure, compared: the metrics as a bar chart. Needs no file."""

import os
import sys

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

figure = demo.figure(30)
reference = PoseEnsemble(registrationName="Reference", Input=figure, NumberOfSamples=12, Spread=0.0, Seed=1)
same = PoseEnsemble(registrationName="Same recipe", Input=figure, NumberOfSamples=12, Spread=0.0, Seed=2)
other = PoseEnsemble(registrationName="Small angles", Input=figure, NumberOfSamples=12, Spread=0.0, Seed=2, MaximumAngle=20.0)

view = demo.picture(None, "XYBarChartView")
tables = [EnsembleMetrics(registrationName=name, Input=ensemble, Reference=reference)
          for name, ensemble in (("Same recipe", same), ("Small angles", other))]
demo.bars(tables, view, ["COV", "OneNearestNeighbourAccuracy"], "Poses against poses of another seed")
