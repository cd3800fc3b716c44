# SPDX-License-Identifier: BSD-3-Clause
"""The demo state of Examples: it opens, shows the noise, and the play button shows another sample in each frame."""

import os

import numpy as np
import surfaces
import surfacesynthesis  # noqa: F401: makes the getters of the class known
from paraview import servermanager
from paraview.simple import *  # noqa: F403: as scripts of ParaView do
from vtkmodules.vtkIOImage import vtkPNGReader

LoadPlugin(surfaces.plugin(), remote=False, ns=globals())
STATE = os.path.join(os.environ["SURFACE_SYNTHESIS_EXAMPLES"], "MaternNoise.py")


def state_shows_the_noise():
    with open(STATE, encoding="utf-8") as file:
        exec(compile(file.read(), STATE, "exec"), dict(globals()))
    view = GetActiveView()
    view.ViewSize = [450, 350]
    Render(view)
    SaveScreenshot("example.png", view)
    reader = vtkPNGReader()
    reader.SetFileName("example.png")
    reader.Update()
    pixels = surfaces.vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars()).astype(int)
    red = np.count_nonzero(pixels[:, 0] > pixels[:, 2] + 40)
    blue = np.count_nonzero(pixels[:, 2] > pixels[:, 0] + 60)
    assert red > 1000 and blue > 1000, f"{red} red and {blue} blue pixels of {len(pixels)}"


def play_button_shows_samples():
    noise = FindSource("Colours")
    scene = GetAnimationScene()
    shown = []
    for frame in range(10):
        scene.AnimationTime = frame / 9.0
        noise.UpdatePipeline()
        made = noise.GetClientSideObject()
        assert made.GetFirstSample() == frame, (made.GetFirstSample(), frame)
        shown.append(surfaces.array(servermanager.Fetch(noise)).copy())
    scene.GoToFirst()
    scene.Play()
    assert noise.FirstSample == 9, noise.FirstSample
    assert noise.GetClientSideObject().GetNumberOfFactorizations() == 1
    expected = surfaces.noise(servermanager.Fetch(FindSource("Normals")), CorrelationRange=0.4, Seed=1, FirstSample=7)
    surfaces.assert_same(shown[7], surfaces.array(expected), "sample 7")
    correlation = np.corrcoef(shown) - np.eye(10)
    assert np.abs(correlation).max() < 0.5, correlation


surfaces.run(state_shows_the_noise, play_button_shows_samples)
