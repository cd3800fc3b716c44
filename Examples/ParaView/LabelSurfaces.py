# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: the surfaces of three labels of an image, which share their borders. Needs no file."""

import os
import sys

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

LABELS = """
import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
image = self.GetInputDataObject(0, 0)
output.CopyStructure(image)
line = (np.arange({size}) - 0.5 * ({size} - 1)) / (0.5 * ({size} - 1))
z, y, x = np.meshgrid(line, line, line, indexing="ij")
inside = x**2 + 1.4 * y**2 + 1.2 * z**2 < 0.75
parts = np.where(y > 0.15 + 0.12 * np.sin(5 * x), 1, np.where(x > 0.1 * np.sin(4 * y), 2, 3))
array = numpy_to_vtk((inside * parts).astype(np.int32).ravel(), deep=True)
array.SetName("Label")
output.GetPointData().SetScalars(array)
"""
size = 24 if demo.QUICK else 60
extent = [0, size - 1] * 3
wavelet = Wavelet(registrationName="Grid", WholeExtent=extent)
image = ProgrammableFilter(registrationName="Labels", Input=wavelet, Script=LABELS.format(size=size))
surfaces = LabelSurfaces(registrationName="Surfaces", Input=image, Scalars=["POINTS", "Label"])
apart = EnsembleLayout(registrationName="Apart", Input=surfaces, Arrangement="Row")

view = demo.picture(None)
demo.show(demo.smooth(apart), view, "Label", association="CELLS", preset="Viridis (matplotlib)", bar=False, limits=(0.5, 3.5))
demo.fill(view, apart, top=0.1)
demo.write("three labels, three surfaces", view, (0.04, 0.9))
