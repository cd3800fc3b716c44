# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: two ensembles of poses of one figure, compared: the samples and the metrics. Needs no file."""

import os
import sys

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

figure = demo.figure(30)
reference = PoseEnsemble(registrationName="Reference", Input=figure, NumberOfSamples=5, Spread=0.0, Seed=1)
same = PoseEnsemble(registrationName="Same recipe", Input=figure, NumberOfSamples=5, Spread=0.0, Seed=2)
other = PoseEnsemble(registrationName="Small angles", Input=figure, NumberOfSamples=5, Spread=0.0, Seed=2)
other.MaximumAngle = 15.0

rows = GroupDatasets(registrationName="Ensembles", Input=[
    EnsembleLayout(Input=ensemble, Arrangement="Row") for ensemble in (reference, same, other)])
layout = EnsembleLayout(registrationName="Side by side", Input=rows, Arrangement="Column", Unit="Children")
layout.Spacing = 0.35

view = demo.picture(None)
demo.show(demo.smooth(layout), view, "Displacement", preset="Viridis (matplotlib)", bar=False)
demo.fill(view, layout, top=0.08)
demo.write("Reference: angles to 60 degrees", view, (0.04, 0.893))
for name, ensemble, height in (("The same recipe, another seed", same, 0.588), ("Angles to 15 degrees", other, 0.278)):
    row = demo.rows_of(EnsembleMetrics(registrationName=name, Input=ensemble, Reference=reference))
    numbers = [f"{key} {row[column][0].ToDouble():.2g}" for key, column in
               (("MMD", "MMD"), ("coverage", "COV"), ("1-NN accuracy", "OneNearestNeighbourAccuracy"))]
    demo.write(f"{name}: " + ", ".join(numbers), view, (0.04, height))
