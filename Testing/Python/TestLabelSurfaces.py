# SPDX-License-Identifier: BSD-3-Clause
"""label_surfaces() and the command ``label-surfaces``."""

import gzip
import json
import struct

import numpy as np
import pytest
from conftest import run_command
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkCompositeDataSet
from vtkmodules.vtkFiltersCore import vtkMassProperties

from surfacesynthesis import Cancelled, SurfaceSynthesisError, label_surfaces, read_mesh, volume_from_numpy

NAMES = "3 Left_Part 2001\r\n8 Right_Part 2002\r\n"


def labels():
    """A ball in two parts, labels 3 and 8, as [x, y, z]."""
    x, y, z = np.mgrid[:26, :24, :22]
    ball = (x - 12.5) ** 2 + (y - 11.5) ** 2 + (z - 10.5) ** 2 < 81
    return np.where(ball, np.where(x < 11, 3, 8), 0).astype(np.int16)


def affine():
    return np.array([[-2.0, 0, 0, 40], [0, 1.0, 0, -10], [0, 0, 1.5, 5], [0, 0, 0, 1]])


def volume():
    return volume_from_numpy(labels(), affine())


def names_of(surfaces):
    return [surfaces.GetMetaData(k).Get(vtkCompositeDataSet.NAME()) for k in range(surfaces.GetNumberOfBlocks())]


def volume_of(surface):
    mass = vtkMassProperties()
    mass.SetInputData(surface)
    mass.Update()
    return mass.GetVolume()


def write_nifti(path):
    """A NIfTI-1 file of the labels."""
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, *labels().shape, 1, 1, 1, 1)
    struct.pack_into("<2h", header, 70, 4, 16)
    struct.pack_into("<8f", header, 76, 1, 2, 1, 1.5, 1, 1, 1, 1)
    struct.pack_into("<3f", header, 108, 352, 1, 0)
    struct.pack_into("<2h", header, 252, 0, 1)
    struct.pack_into("<12f", header, 280, *affine()[:3].ravel())
    header[344:348] = b"n+1\0"
    with gzip.open(path, "wb") as file:
        file.write(bytes(header) + labels().tobytes(order="F"))


@pytest.mark.parametrize("shared", [True, False])
def test_each_label_keeps_its_volume(shared):
    surfaces = label_surfaces(volume(), {3: "left", 8: "right"}, shared_borders=shared)
    assert names_of(surfaces) == ["left", "right"]
    for number, label in enumerate((3, 8)):
        expected = 3.0 * (labels() == label).sum()
        surface = surfaces.GetBlock(number)
        assert abs(surface.GetFieldData().GetArray("SampleVolume").GetValue(0) / expected - 1) < 1e-12
        assert abs(volume_of(surface) / expected - 1) < 2e-3


def test_touching_labels_share_points():
    first, second = (
        {tuple(point) for point in vtk_to_numpy(surface.GetPoints().GetData())}
        for surface in (label_surfaces(volume()).GetBlock(k) for k in (0, 1))
    )
    faces = (labels()[10] > 0).sum()  # between x = 10 and 11
    assert len(first & second) > faces


def test_positions_are_those_of_the_scanner():
    surface = label_surfaces(volume(), labels=[3]).GetBlock(0)
    center = vtk_to_numpy(surface.GetPoints().GetData()).mean(0)
    inside = np.argwhere(labels() == 3).mean(0)
    assert np.abs(center - (affine()[:3, :3] @ inside + affine()[:3, 3])).max() < 1.5


def test_wrong_arguments_have_words(tmp_path):
    with pytest.raises(SurfaceSynthesisError, match="no sample of the image has"):
        label_surfaces(volume(), labels=[4])
    with pytest.raises(SurfaceSynthesisError, match="which is no label"):
        label_surfaces(volume_from_numpy(labels() + 0.5, affine()))
    gray = np.random.default_rng(1).integers(1, 250, size=(20, 20, 20))
    with pytest.raises(SurfaceSynthesisError, match="249 labels, and only 0 percent .* gray values of a scan"):
        label_surfaces(volume_from_numpy(gray, affine()))
    with pytest.raises(SurfaceSynthesisError, match="table of names cannot be read"):
        label_surfaces(volume(), names=str(tmp_path / "none.txt"))
    with pytest.raises(TypeError, match="vtkImageData"):
        label_surfaces(5)
    with pytest.raises(ValueError, match="smoothing_iterations"):
        label_surfaces(volume(), smoothing_iterations=-1)
    with pytest.raises(Cancelled):
        label_surfaces(volume(), progress=lambda fraction: False)


def test_command(tmp_path):
    atlas, names, output = (str(tmp_path / name) for name in ("atlas.nii.gz", "atlas.txt", "atlas.vtm"))
    write_nifti(atlas)
    with open(names, "w", newline="") as file:
        file.write(NAMES)
    done = run_command("label-surfaces", atlas, output, "--names", names, "--json")
    assert done.returncode == 0, done.stderr
    rows = json.loads(done.stdout)["labels"]
    assert [row["name"] for row in rows] == ["Left_Part", "Right_Part"]
    assert rows[0]["volume"] == pytest.approx(3.0 * (labels() == 3).sum())
    assert names_of(read_mesh(output)) == ["Left_Part", "Right_Part"]
    one = str(tmp_path / "one.ply")
    done = run_command("label-surfaces", atlas, one, "--labels", "8", "--csv")
    assert done.returncode == 0 and done.stdout.splitlines()[1].startswith('8,"Label 8",')
    assert read_mesh(one).GetNumberOfPoints() > 100
    done = run_command("label-surfaces", one, output)
    assert done.returncode == 2 and "a volume is needed" in done.stderr
