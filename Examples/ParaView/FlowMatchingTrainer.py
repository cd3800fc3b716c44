# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: the losses of a short training on poses of a figure. Needs no file; writes its model into the
folder for temporary files."""

import os
import sys
import tempfile

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

figure = demo.figure(24)
poses = PoseEnsemble(registrationName="Poses", Input=figure, NumberOfSamples=6, Spread=0.0)
training = FlowMatchingTrainer(registrationName="Training", Input=figure, Samples=poses)
training.ModelFileName = os.path.join(tempfile.gettempdir(), "figure_poses.safetensors")
training.Resume = 0
training.Width = 8
training.Blocks = 2
training.LearningRate = 3e-3
training.Iterations = 200
training.BatchSize = 4
training.TimeBudget = demo.minutes(0.25)

view = demo.picture(None, "XYChartView")
demo.losses(training, view, "loss")
