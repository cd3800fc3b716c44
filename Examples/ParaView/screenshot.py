# SPDX-License-Identifier: BSD-3-Clause
"""Renders a state file into a picture: pvpython screenshot.py <plugin> <state.py or state.pvsm> <picture.png>"""

import sys

from paraview.simple import *  # noqa: F403: as scripts of ParaView do

plugin, state, picture = sys.argv[1:]
LoadPlugin(plugin, remote=False, ns=globals())
if state.endswith(".py"):
    with open(state, encoding="utf-8") as file:
        exec(compile(file.read(), state, "exec"), globals())
else:
    LoadState(state)
view = GetActiveView() or CreateRenderView()
view.ViewSize = [900, 700]
Render(view)
SaveScreenshot(picture, view)
