# SPDX-License-Identifier: BSD-3-Clause
"""Times vtkTetrahedralizeFilter against TetGen's own program in the same run, and vtkTopologyReport.

usage: meshing_reference.py MESH.off [repetitions]

TetGen's program (Debian: tetgen) prints the processor time it has worked, without reading and writing files: what the
filter adds is the process, the transfer of the mesh both ways, the checks and the arrays. So all seconds are of processor
time, of this process and of those it has started.
"""

import re
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile

from surfacesynthesis import read_mesh, vtkTetrahedralizeFilter, vtkTopologyReport, write_mesh


def used():
    """Seconds of processor time so far."""
    usages = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(usage.ru_utime + usage.ru_stime for usage in usages)


def seconds_of(make, mesh):
    """Of one update of a new filter, and the filter."""
    algorithm = make()
    algorithm.SetInputDataObject(mesh)
    started = used()
    algorithm.Update()
    return used() - started, algorithm


def bare_tetgen(path):
    """Seconds and the number of tetrahedra, with the switches that are the defaults of the filter."""
    done = subprocess.run(["tetgen", "-pYqJMNEFBI", path], capture_output=True, text=True, check=True)
    seconds = re.search(r"Total running seconds:\s*([\d.]+)", done.stdout)
    tetrahedra = re.search(r"Mesh tetrahedra:\s*(\d+)", done.stdout)
    return float(seconds[1]), int(tetrahedra[1])


def main():
    mesh = read_mesh(sys.argv[1])
    repetitions = int(sys.argv[2]) if len(sys.argv) > 2 else 3
    triangles = mesh.GetNumberOfCells()
    report = [seconds_of(vtkTopologyReport, mesh)[0] for _ in range(repetitions)]
    print(f"{triangles:,} triangles: report {statistics.median(report):.3f} s")
    if shutil.which("tetgen") is None:
        raise SystemExit("TetGen's program (Debian: tetgen) was not found")
    filled, bare = [], []
    with tempfile.TemporaryDirectory() as folder:
        write_mesh(mesh, f"{folder}/mesh.off")
        for _ in range(repetitions):
            seconds, algorithm = seconds_of(vtkTetrahedralizeFilter, mesh)
            filled.append(seconds)
            seconds, tetrahedra = bare_tetgen(f"{folder}/mesh.off")
            bare.append(seconds)
    found = algorithm.GetOutputDataObject(0).GetNumberOfCells()
    ratio = statistics.median(f / b for f, b in zip(filled, bare))
    print(f"filter {statistics.median(filled):.2f} s ({found:,} tetrahedra), "
          f"TetGen {statistics.median(bare):.2f} s ({tetrahedra:,}), ratio {ratio:.2f}")  # fmt: skip


if __name__ == "__main__":
    main()
