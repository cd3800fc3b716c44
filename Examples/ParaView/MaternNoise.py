# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: a rock made of two Matérn noises, one that moves the points of a sphere and one that colours them.

Open it with File > Load State when the plugin is loaded (Tools > Manage Plugins), or run Examples/ParaView/run.sh.
Needs no file. The play button shows ten samples of the colours.
"""

import paraview

paraview.compatibility.major = 5
paraview.compatibility.minor = 11

from paraview.simple import *  # noqa: E402, F403: as state files of ParaView do

paraview.simple._DisableFirstRenderCameraReset()

sphere = Sphere(registrationName="Sphere", Radius=1.0, ThetaResolution=300, PhiResolution=300)

# the shape: smooth bumps, a fifth of the radius high
bumps = MaternNoise(registrationName="Bumps", Input=sphere)
bumps.CorrelationRange = 1.2
bumps.StandardDeviation = 0.2
bumps.Seed = 3
bumps.OutputArrayName = "Bumps"

rock = WarpByScalar(registrationName="Rock", Input=bumps)
rock.Scalars = ["POINTS", "Bumps"]

normals = GenerateSurfaceNormals(registrationName="Normals", Input=rock)
normals.FeatureAngle = 180.0

# the colours: a correlation range measured along the rock
noise = MaternNoise(registrationName="Colours", Input=normals)
noise.CorrelationRange = 0.4
noise.Seed = 1

view = CreateView("RenderView")
layout = CreateLayout(name="Layout #1")
layout.AssignView(0, view)
SetActiveView(view)
display = Show(noise, view)
ColorBy(display, ("POINTS", "MaternNoise"))
colors = GetColorTransferFunction("MaternNoise")
colors.RescaleTransferFunction(-3.0, 3.0)
display.SetScalarBarVisibility(view, True)
view.CameraPosition = [4.9, -4.9, 2.9]
view.CameraFocalPoint = [0.0, 0.0, 0.0]
view.CameraViewUp = [0.0, 0.0, 1.0]
view.CameraViewAngle = 30.0

# the play button: FirstSample from 0 to 9, with one factorisation; fractions are cut off
scene = GetAnimationScene()
scene.PlayMode = "Sequence"
scene.NumberOfFrames = 10
track = GetAnimationTrack("FirstSample", proxy=noise)
track.KeyFrames = [
    CompositeKeyFrame(KeyTime=0.0, KeyValues=[0.5]),
    CompositeKeyFrame(KeyTime=1.0, KeyValues=[9.5]),
]

SetActiveSource(noise)
