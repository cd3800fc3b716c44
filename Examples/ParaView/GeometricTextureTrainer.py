# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: the losses of a short training of a geometric texture. Needs no file; writes its model into the
folder for temporary files."""

import os
import sys
import tempfile

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

sphere = Sphere(registrationName="Sphere", Radius=1.0, ThetaResolution=60, PhiResolution=60)
bumps = MaternNoise(registrationName="Bumps", Input=sphere, CorrelationRange=0.6, StandardDeviation=0.12, Seed=3)
rock = WarpByScalar(registrationName="Rock", Input=bumps, Scalars=["POINTS", "MaternNoise"])
levels = MultiscaleMeshFitter(registrationName="Levels", Input=rock, NumberOfLevels=1, Iterations=20, Samples=1000)
levels.IcosphereLevel = 1
levels.TimeBudget = demo.minutes(0.25)
training = GeometricTextureTrainer(
    registrationName="Training", Input=OutputPort(levels, 0), TemplateMesh=OutputPort(levels, 1)
)
training.ModelFileName = os.path.join(tempfile.gettempdir(), "rock_texture.safetensors")
training.Resume = 0
training.StartChannels = training.MinimumChannels = 8
training.MaximumChannels = 16
training.IterationsPerLevel = 150
training.TimeBudget = demo.minutes(0.25)

view = demo.picture(None, "XYChartView")
demo.losses(training, view, "reconstruction_loss")
