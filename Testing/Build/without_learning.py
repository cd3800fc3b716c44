# SPDX-License-Identifier: BSD-3-Clause
"""Applies the shipped models with a package that was built without LibTorch; run by WithoutLearning.cmake."""

import pathlib
import sys

import surfacesynthesis
from vtkmodules.vtkFiltersSources import vtkPlatonicSolidSource
from vtkmodules.vtkFiltersModeling import vtkLinearSubdivisionFilter

models = pathlib.Path(sys.argv[1])
solid = vtkPlatonicSolidSource()
solid.SetSolidTypeToIcosahedron()
fine = vtkLinearSubdivisionFilter()
fine.SetInputConnection(solid.GetOutputPort())
fine.SetNumberOfSubdivisions(3)
fine.Update()
ball = fine.GetOutput()

signal = surfacesynthesis.sample_signal(ball, str(models / "bunny_mixtures.safetensors"), steps=2)
assert signal.GetNumberOfPoints() == ball.GetNumberOfPoints()
textured = surfacesynthesis.geometric_texture(ball, str(models / "spikes.safetensors"), start_level=1)
assert textured.GetNumberOfPoints() > ball.GetNumberOfPoints()

names = dir(surfacesynthesis)
assert "vtkFlowMatchingSampler" in names and "vtkFlowMatchingTrainer" not in names, names
with open("/proc/self/maps", encoding="utf8") as maps:
    loaded = maps.read()
assert "libtorch" not in loaded and "libvtkSurfaceSynthesisFlowMatching" in loaded
print("The package applies models without LibTorch")
