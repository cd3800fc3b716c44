# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: the losses of a short training of field latents on an image. Needs no file; writes its model into the
folder for temporary files."""

import os
import sys
import tempfile

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

training = FieldLatentTrainer(registrationName="Training", Input=demo.coat())
training.ModelFileName = os.path.join(tempfile.gettempdir(), "coat_latents.safetensors")
training.Resume = 0
training.NumberOfMeshes = 4
training.MeshPoints = 300
training.Channels = 16
training.EncoderLayers = 1
training.DecoderWidth = 64
training.BatchSize = 16
training.Iterations = 600
training.TimeBudget = demo.minutes(0.5)

view = demo.picture(None, "XYChartView")
demo.losses(training, view, "reconstruction_loss")
