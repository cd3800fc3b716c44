# SPDX-License-Identifier: BSD-3-Clause
"""Test of fit_scans.py on a ball: ``test_fit_scans.py FOLDER``. Run by CTest."""

import contextlib
import io
import os
import shutil
import sys
import tarfile

from vtkmodules.vtkFiltersSources import vtkSphereSource

import fit_scans
import surfacesynthesis


def archive_of_ball(folder):
    """An archive like that of libcgal-demo, with a ball in place of the bunny."""
    ball = vtkSphereSource()
    ball.SetThetaResolution(40)
    ball.SetPhiResolution(21)
    ball.Update()
    path = os.path.join(folder, "bunny00.off")
    surfacesynthesis.write_mesh(ball.GetOutput(), path)
    archive = os.path.join(folder, "data.tar.gz")
    with tarfile.open(archive, "w:gz") as files:
        files.add(path, "data/meshes/bunny00.off")
    return archive


def rows_of(text):
    """The rows of a table without its head, as lists of cells."""
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines()[2:]]


def main(folder):
    """Fits the ball and its piece, and looks at the table and the files."""
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    text = io.StringIO()
    with contextlib.redirect_stdout(text):
        fit_scans.main(["--archive", archive_of_ball(folder), "--only", "bunny00", "--iterations", "5", "--output", folder])
    rows = rows_of(text.getvalue())
    assert [row[0] for row in rows] == ["bunny00", "bunny00, cropped"], rows
    for row in rows:
        mean, far, angle, pairs = (float(cell.rstrip(" %")) for cell in row[4:8])
        assert mean <= 0.15 and far <= 0.5 and angle <= 15.0 and pairs == 0.0, row
    piece = surfacesynthesis.read_mesh(os.path.join(folder, "bunny00-cropped-surface.vtp"))
    assert "boundary loops                            1" in str(surfacesynthesis.topology_report(piece))
    assert piece.GetBounds()[3] < 0.11  # the plane at 0.6 of the height


if __name__ == "__main__":
    main(sys.argv[1])
