# SPDX-License-Identifier: BSD-3-Clause
"""State of ParaView: an arm of two bones, twisted by 150 degrees, by linear blend and dual quaternion skinning. Needs no file."""

import os
import sys

from paraview.simple import *  # noqa: F403: as state files of ParaView do

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import demo  # noqa: E402

WEIGHTS = """
import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
body = self.GetInputDataObject(0, 0)
output.ShallowCopy(body)
points = vtk_to_numpy(body.GetPoints().GetData())
second = np.clip(points[:, 1] / 1.6 + 0.5, 0, 1)
stripes = np.floor(4 * np.arctan2(points[:, 0], points[:, 2]) / np.pi) % 2
for name, values in (("BoneWeights", np.stack([1 - second, second], axis=1)), ("Stripes", stripes)):
    array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
    array.SetName(name)
    output.GetPointData().AddArray(array)
"""
TABLE = """
from vtkmodules.vtkCommonCore import vtkDoubleArray
for name, rows in {columns}.items():
    column = vtkDoubleArray()
    column.SetName(name)
    column.SetNumberOfComponents(len(rows[0]))
    for row in rows:
        column.InsertNextTuple(row)
    output.AddColumn(column)
"""


def table(name, **columns):
    source = ProgrammableSource(registrationName=name, OutputDataSetType="vtkTable")
    source.Script = TABLE.format(columns=repr(columns))
    return source


size = (24, 40) if demo.QUICK else (64, 160)
body = Tube(registrationName="Arm", Input=Line(Point1=[0, -3, 0], Point2=[0, 3, 0], Resolution=size[1]), Radius=0.55)
body.NumberofSides = size[0]
body.Capping = 0
weighted = ProgrammableFilter(registrationName="Weights", Input=ExtractSurface(Input=Triangulate(Input=body)), Script=WEIGHTS)
bones = table("Bones", Head=[[0, -3, 0], [0, 0, 0]], Parent=[[-1], [0]])
pose = table("Pose", Rotation=[[1, 0, 0, 0], [0.2588, 0, 0.9659, 0]])  # 150 degrees about y

view, both = demo.picture(None), []
for method, place in (("Linear Blend", -1.4), ("Dual Quaternion", 1.4)):
    posed = Skinning(registrationName=method, Input=weighted, Bones=bones, Pose=pose, SkinningMethod=method,
                     BoneIndexArrayName="")
    moved = Transform(registrationName=method + ", moved", Input=posed)
    moved.Transform.Translate = [place, 0, 0]
    both.append(moved)
    demo.show(demo.smooth(moved), view, "Stripes", preset="Cool to Warm", bar=False)
demo.fill(view, GroupDatasets(Input=both), top=0.16)
demo.write("linear blend", view, (0.29, 0.9))
demo.write("dual quaternion", view, (0.55, 0.9))
