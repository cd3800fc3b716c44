# SPDX-License-Identifier: BSD-3-Clause
"""The figure of the demo states: a closed surface with a head, arms, legs and a tail that needs no file.

    python3 Examples/ParaView/figure.py figure.ply

writes it, for example to make poses of it.
"""

import sys

#: A volume whose values are 0 on the figure: balls along bones. For the programmable source and for surface().
VOLUME = """
import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk
n = {resolution}
lower, upper = np.array([-1.75, -1.75, -1.1]), np.array([1.75, 1.75, 0.9])
spacing = (upper[0] - lower[0]) / (n - 1)
dimensions = [n, n, int(round((upper[2] - lower[2]) / spacing)) + 1]
x, y, z = np.meshgrid(*(lower[k] + spacing * np.arange(dimensions[k]) for k in range(3)), indexing="ij")
bones = [  # from, to, radius at both ends
    ((0, -0.35, 0), (0, 0.45, 0), 0.40, 0.42), ((0, 0.5, 0), (0, 1.05, 0.08), 0.24, 0.33),
    ((0.3, 0.5, 0), (0.95, 0.75, 0.1), 0.22, 0.15), ((0.95, 0.75, 0.1), (1.35, 1.15, 0.3), 0.15, 0.17),
    ((-0.3, 0.5, 0), (-0.95, 0.75, 0.1), 0.22, 0.15), ((-0.95, 0.75, 0.1), (-1.35, 1.15, 0.3), 0.15, 0.17),
    ((0.25, -0.4, 0), (0.55, -1.0, 0.1), 0.28, 0.2), ((0.55, -1.0, 0.1), (0.65, -1.5, 0.05), 0.2, 0.19),
    ((-0.25, -0.4, 0), (-0.55, -1.0, 0.1), 0.28, 0.2), ((-0.55, -1.0, 0.1), (-0.65, -1.5, 0.05), 0.2, 0.19),
    ((0, -0.4, -0.2), (0, -0.75, -0.8), 0.2, 0.1),
]
field = np.zeros(x.shape)
for a, b, ra, rb in bones:
    a, b = np.array(a, float), np.array(b, float)
    d = b - a
    t = np.clip(((x - a[0]) * d[0] + (y - a[1]) * d[1] + (z - a[2]) * d[2]) / d.dot(d), 0, 1)
    r2 = (x - a[0] - t * d[0]) ** 2 + (y - a[1] - t * d[1]) ** 2 + (z - a[2] - t * d[2]) ** 2
    field += np.exp(4 * (1 - r2 / (ra + t * (rb - ra)) ** 2))
output.SetDimensions(dimensions)
output.SetOrigin(*lower)
output.SetSpacing(spacing, spacing, spacing)
values = numpy_to_vtk(np.log(field + 1e-30).ravel(order="F"), deep=True)
values.SetName("Figure")
output.GetPointData().SetScalars(values)
"""

#: The extent of the volume.
EXTENT = """
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline as pipeline
n = {resolution}
depth = int(round(2.0 / (3.5 / (n - 1)))) + 1
info = self.GetOutputInformation(0)
info.Set(pipeline.WHOLE_EXTENT(), 0, n - 1, 0, n - 1, 0, depth - 1)
"""


def surface(resolution=70):
    """The figure, about 3 units high; ``resolution`` samples across."""
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkFiltersCore import vtkContourFilter

    volume = vtkImageData()
    exec(VOLUME.format(resolution=resolution), {"output": volume})
    contour = vtkContourFilter()
    contour.SetInputData(volume)
    contour.SetInputArrayToProcess(0, 0, 0, 0, "Figure")
    contour.SetValue(0, 0.0)
    contour.ComputeScalarsOff()
    contour.ComputeNormalsOff()
    contour.Update()
    return contour.GetOutput()


if __name__ == "__main__":
    import surfacesynthesis

    surfacesynthesis.write_mesh(surface(), sys.argv[1])
