# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: the losses of a short training of new textures on one textured surface. Needs a model of field latents
and no other file; writes its model into the folder for temporary files."""

import os
import sys
import tempfile

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

coated = demo.laid_out(Plane(registrationName="Sheet", Origin=[-1.75, -1.75, 0.0], Point1=[1.75, -1.75, 0.0],
                             Point2=[-1.75, 1.75, 0.0], XResolution=60, YResolution=60))  # fmt: skip
training = LatentDiffusionTrainer(registrationName="Training", Input=coated, TextureImage=demo.coat())
training.ModelFileName = os.path.join(tempfile.gettempdir(), "coat_diffusion.safetensors")
training.AutoencoderFileName = demo.model("field_latents")
training.Resume = 0
training.NumberOfTriangulations = 2
training.NumberOfPoints = 400
training.Channels = training.CoarseChannels = 16
training.OutputBlocks = 1
training.Target = "Velocity"
training.BatchSize = 1
training.Iterations = 1500
training.TimeBudget = demo.minutes(0.5)

view = demo.picture(None, "XYChartView")
demo.losses(training, view, "loss")
