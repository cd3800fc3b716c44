# SPDX-License-Identifier: BSD-3-Clause
"""Repair of all meshes of Debian's package libcgal-demo: a table of the surfaces before and after.

As a program it repairs all of them, prints the table, and compares it with Testing/Data/repair_of_meshes.csv:

    python3 Testing/Python/TestRepairOfMeshes.py [--write]

pytest repairs those in QUICK. Each mesh is repaired with all holes closed and self-intersections removed. Of each result is
required:

- a second repair returns the same points and triangles;
- the measures are those that topology_report() finds, and what is left is named by a warning;
- remesh() accepts it, and tetrahedralize() does when it is valid and closed;
- no more is left and lost than in the table.
"""

import csv
import os
import sys
import tarfile
import tempfile
import time
import warnings

import numpy as np
import pytest
import surfacesynthesis
from surfacesynthesis import read_mesh, remesh, repair, repair_measures, topology_report
from vtkmodules.util.numpy_support import vtk_to_numpy

ARCHIVE = "/usr/share/doc/libcgal-demo/data.tar.gz"
TABLE = os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, "Data", "repair_of_meshes.csv")
#: Meshes with every kind of defect, a few hundred to thousand triangles each.
QUICK = (
    "degtri_sliding", "double-torus-3-holes", "elk", "fold", "mask_cone", "mpi", "negative", "oblong-shuffled", "patch-13",
    "patch-23", "pig", "quads_to_stitch", "tetra_intersected_by_triangle", "triangle",
)  # fmt: skip
#: No mesh: text after the faces that its header announces.
UNREADABLE = ("prim",)
PARAMETERS = {"holes": "all", "self_intersections": True}
COLUMNS = (
    "mesh", "triangles", "area", "volume", "components", "intersecting", "boundaries", "valid", "triangles_after",
    "area_after", "volume_after", "components_after", "intersecting_after", "boundaries_after", "valid_after", "warnings",
    "seconds",
)  # fmt: skip

pytestmark = [
    pytest.mark.skipif(not hasattr(surfacesynthesis, "vtkSurfaceRepairFilter"), reason="built without CGAL"),
    pytest.mark.skipif(not os.path.exists(ARCHIVE), reason=f"{ARCHIVE} of Debian's package libcgal-demo is missing"),
]


def names_of_meshes():
    with tarfile.open(ARCHIVE) as archive:
        members = [member for member in archive.getmembers() if member.name.endswith(".off") and "/meshes/" in member.name]
        members.sort(key=lambda member: member.size)
        return [os.path.splitext(os.path.basename(member.name))[0] for member in members]


def read(names, folder):
    """(name, mesh) of each name; the archive is read once."""
    wanted = {f"data/meshes/{name}.off": name for name in names}
    with tarfile.open(ARCHIVE) as archive:
        for member in archive:
            if member.name in wanted:
                path = os.path.join(folder, os.path.basename(member.name))
                with open(path, "wb") as file:
                    file.write(archive.extractfile(member).read())
                yield wanted[member.name], read_mesh(path)


def bits_of(mesh):
    points, triangles = mesh.GetPoints().GetData(), mesh.GetPolys().GetConnectivityArray()
    return vtk_to_numpy(points).tobytes(), vtk_to_numpy(triangles).astype(np.int64).tobytes()


def measures_of(mesh):
    report = topology_report(mesh, component_rows=0)
    return {
        "triangles": report["triangles"],
        "area": report["area"],
        "volume": report.get("volume", ""),
        "components": report["components"],
        "intersecting": report["intersecting_triangles"],
        "boundaries": report["boundary_loops"],
        "valid": int(report.valid),
    }


def repaired(mesh):
    """The result, its texts of warnings and the seconds it took."""
    started = time.monotonic()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        result = repair(mesh, **PARAMETERS)
    return result, [str(warning.message) for warning in caught], time.monotonic() - started


def row_of(name, mesh):
    """The row of a mesh in the table, and the faults of its repair."""
    before = measures_of(mesh)
    result, texts, seconds = repaired(mesh)
    after = measures_of(result)
    row = {"mesh": name, **before, **{f"{key}_after": value for key, value in after.items()}}
    row.update(warnings=len(texts), seconds=round(seconds, 2))
    faults = []
    if bits_of(repaired(result)[0]) != bits_of(result):
        faults.append("a second repair changes the surface")
    if repair_measures(result)["intersecting_triangles"][1] != after["intersecting"]:
        faults.append("report and repair count other intersecting triangles")
    if after["intersecting"] and not any(f"{after['intersecting']} triangle(s) still" in text for text in texts):
        faults.append("no warning counts the triangles that still intersect")
    if after["boundaries"] and not any("left open" in text for text in texts):
        faults.append("no warning counts the holes that are left open")
    if not texts and not after["valid"]:
        faults.append("a repair without a warning leaves a surface that is not valid")
    return row, faults + faults_of_users(result, after)


def faults_of_users(result, after):
    """Refusals of a surface by remesh(), and by tetrahedralize() when it is valid and closed."""
    faults = []
    users = [remesh] if after["triangles"] < 20000 else []
    if after["valid"] and not after["boundaries"] and users and hasattr(surfacesynthesis, "vtkTetrahedralizeFilter"):
        users.append(surfacesynthesis.tetrahedralize)
    for user in users:
        try:
            user(result)
        except surfacesynthesis.SurfaceSynthesisError as error:
            faults.append(f"{user.__name__}() refuses the result: {error}")
    return faults


def expected_rows():
    with open(TABLE, newline="", encoding="utf-8") as file:
        return {row["mesh"]: row for row in csv.DictReader(file)}


def faults_of_row(row, expected):
    """Defects and losses beyond those in the table."""
    faults = []
    for column in ("intersecting_after", "boundaries_after", "warnings"):
        if row[column] > int(expected[column]):
            faults.append(f"{column}: {row[column]}, in the table {expected[column]}")
    if abs(row["components_after"] - row["components"]) > abs(int(expected["components_after"]) - row["components"]):
        faults.append(f"components_after: {row['components_after']}, in the table {expected['components_after']}")
    for column in ("area_after", "volume_after"):
        if expected[column] and not (row[column] != "" and row[column] >= float(expected[column]) * (1 - 1e-3)):
            faults.append(f"{column}: {row[column]}, in the table {expected[column]}")
    return faults


@pytest.mark.parametrize("name", QUICK)
def test_repair_of_a_mesh_is_that_of_the_table(name, meshes):
    row, faults = row_of(name, meshes[name])
    assert faults + faults_of_row(row, expected_rows()[name]) == []


@pytest.fixture(scope="module")
def meshes(tmp_path_factory):
    return dict(read(QUICK, tmp_path_factory.mktemp("meshes")))


def test_table_has_all_meshes():
    assert set(expected_rows()) == set(names_of_meshes()) - set(UNREADABLE)
    assert set(QUICK) <= set(expected_rows())


def shown(value):
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def main(arguments):
    """Prints the table of all meshes; returns 1 when a repair has a fault."""
    names = [name for name in names_of_meshes() if name not in UNREADABLE]
    rows, failed = [], False
    expected = {} if "--write" in arguments else expected_rows()
    print(" ".join(COLUMNS), flush=True)
    with tempfile.TemporaryDirectory() as folder:
        for name, mesh in read(names, folder):
            row, faults = row_of(name, mesh)
            faults += faults_of_row(row, expected[name]) if name in expected else []
            rows.append(row)
            texts = [shown(row[column]) or "-" for column in COLUMNS] + [f"FAULT {fault}" for fault in faults]
            print(" ".join(texts), flush=True)
            failed = failed or bool(faults)
    if "--write" in arguments:
        with open(TABLE, "w", newline="", encoding="utf-8") as file:
            columns = [column for column in COLUMNS if column != "seconds"]
            writer = csv.DictWriter(file, columns, extrasaction="ignore", lineterminator="\n")
            writer.writeheader()
            for row in sorted(rows, key=lambda row: names.index(row["mesh"])):
                writer.writerow({column: shown(row[column]) for column in columns})
    return int(failed)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
