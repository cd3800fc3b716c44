# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: a random field of known range and deviation on a figure, and what is estimated of both. Needs no file."""

import os
import sys

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

even = IsotropicRemesh(registrationName="Even", Input=demo.figure(50), TargetNumberOfPoints=600 if demo.QUICK else 2500)
field = MaternNoise(registrationName="Field", Input=even, CorrelationRange=0.8, StandardDeviation=2.0, Seed=3)
field.Refinement = 0
estimate = MaternParameterEstimator(registrationName="Estimate", Input=field, ObservationArray="MaternNoise")
estimate.NoiseEstimation = 0

view = demo.picture(None)
demo.show(demo.smooth(field), view, "MaternNoise", preset="Cool to Warm")
demo.fill(view, field, top=0.2, right=0.14)
rows = demo.rows_of(estimate)
names = {"CorrelationRange": "Range 0.8", "StandardDeviation": "Deviation 2"}
for parameter, *numbers in zip(*(rows[column] for column in ("Parameter", "Estimate", "Lower", "Upper"))):
    if parameter.ToString() in names:
        value, low, high = (number.ToDouble() for number in numbers)
        text = f"{names.pop(parameter.ToString())}, estimate {value:.2f} ({low:.2f} to {high:.2f})"
        demo.write(text, view, (0.04, 0.84 + 0.06 * len(names)))
