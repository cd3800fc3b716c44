# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: distances of the textures of three surfaces from that of the first, below them. Needs no
other file."""

import os
import sys

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

figure = demo.figure(30)
surfaces = [
    GeometricTextureSynthesizer(
        registrationName=name, Input=figure, ModelFileName=demo.model(kind), Seed=seed, EndLevel=2
    )
    for name, kind, seed in (("Spikes", "spikes", 0), ("Other spikes", "spikes", 1), ("Knobs", "knobs", 0))
]
layout = EnsembleLayout(registrationName="Side by side", Input=GroupDatasets(Input=surfaces), Arrangement="Row")

view = demo.picture(None)
demo.show(layout, view)
demo.fill(view, layout)
demo.write("Reference", view, (0.13, 0.2))
for surface, name, place in zip(surfaces[1:], ("Another seed", "Another texture"), (0.42, 0.73)):
    distance = GeometricTextureDistance(registrationName=name, Input=surface, Reference=surfaces[0])
    value = demo.rows_of(distance)["Distance"][0].ToDouble()
    demo.write(f"{name}: {value:.2g}", view, (place, 0.2))
