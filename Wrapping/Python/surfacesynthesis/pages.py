# SPDX-License-Identifier: BSD-3-Clause
"""Self-contained HTML pages that show a surface and its arrays in a browser."""

import base64
import html
import json
import os
import pathlib
import zlib

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkDataObjectTree, vtkPointSet, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkAppendPolyData, vtkTriangleFilter
from vtkmodules.vtkFiltersGeometry import vtkDataSetSurfaceFilter

from .errors import SurfaceSynthesisError
from .files.polygons import add_array
from .supervision import unfinished_name

#: Where npm puts vtk.js for the user, below $XDG_DATA_HOME or ~/.local/share.
USER_FOLDER = "surfacesynthesis"
#: Values of quantized arrays: 0 to LEVELS are equidistant from the minimum to the maximum, MISSING is not a number.
LEVELS, MISSING = 65534, 65535
#: Integer arrays of at most this many different values are labels, which keep their values.
LABELS = 64
#: Components of the arrays that are shown.
COMPONENTS = 9

_HERE = pathlib.Path(__file__).resolve().parent


def write_page(mesh, path, color_by=None, title=None, vtk_js=None):
    """Writes one HTML page that shows a surface, to turn and to color by its arrays, in any browser and offline.

    Points and values are quantized to 16 bits: positions to 1/65535 of the sides of the bounding box, values to 1/65534 of
    the range of their array; integer arrays of at most 64 different values are exact. A page has 0.9 MB of vtk.js and
    about 10 bytes for each triangle, and 3 to 5 for each value of an array, after compression.

    Parameters
    ----------
    mesh : vtkPolyData, vtkUnstructuredGrid or vtkMultiBlockDataSet
        What is shown: its triangles, polygons and strips, or the surface of its cells. Blocks are shown together, with
        the cell array "Block" and the arrays that all of them have.
    path : str or path
        The page, which ends with .html. It appears under its name when it is complete.
    color_by : str, optional
        The array that is shown first. Default the active scalars, else the first array.
    title : str, optional
        The title of the page. Default the name of the file without its extension.
    vtk_js : str or path, optional
        The file vtk.js of npm's package of the same name. Default: find_vtk_js().

    Raises TypeError or ValueError for a wrong argument, OSError when the file cannot be written, and
    SurfaceSynthesisError when the mesh has no triangles or a point that is not finite, or vtk.js was not found.
    """
    path = os.path.realpath(path)
    if not path.lower().endswith((".html", ".htm")):
        raise ValueError(f"{path}: a page ends with .html")
    surface = _triangles_of(mesh)
    library = pathlib.Path(vtk_js) if vtk_js is not None else find_vtk_js()
    scene, data = _encoded(surface, color_by)
    scene["title"] = title if title is not None else os.path.splitext(os.path.basename(path))[0]
    temporary = unfinished_name(os.path.dirname(path), ".html")
    try:
        with open(temporary, "w", encoding="utf-8") as file:
            file.write(_page(scene, data, library))
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    finally:
        if os.path.exists(temporary):
            os.remove(temporary)


def find_vtk_js():
    """The file vtk.js that write_page() puts into pages, as a path.

    Looks at the environment variable SURFACE_SYNTHESIS_VTK_JS; share/SurfaceSynthesis/vtk.js of the installation;
    node_modules of the working folder and those above it; surfacesynthesis/node_modules below $XDG_DATA_HOME or
    ~/.local/share; the global node_modules of npm. Raises SurfaceSynthesisError, with the command that installs it.
    """
    given = os.environ.get("SURFACE_SYNTHESIS_VTK_JS")
    if given:
        return pathlib.Path(given)
    here = pathlib.Path.cwd()
    data = pathlib.Path(os.environ.get("XDG_DATA_HOME") or pathlib.Path.home() / ".local" / "share") / USER_FOLDER
    folders = [folder / "share" / "SurfaceSynthesis" for folder in (_HERE, *list(_HERE.parents)[:4])]
    folders += [folder / "node_modules" for folder in (here, *here.parents, data)]
    folders += [pathlib.Path(folder, "node_modules") for folder in ("/usr/local/lib", "/usr/lib", "/usr/share/nodejs")]
    for folder in folders:
        if (folder / "vtk.js" / "vtk.js").is_file():
            return folder / "vtk.js" / "vtk.js"
    raise SurfaceSynthesisError(
        "vtk.js was not found, which shows the surface in the browser. Install it once with "
        f"'npm install --ignore-scripts --prefix {data} vtk.js' (npm is Debian's package npm), or name the file (vtk_js, --vtk-js)"
    )


def _triangles_of(mesh):
    """The surface of a dataset as a vtkPolyData of triangles."""
    if isinstance(mesh, vtkDataObjectTree):
        surface = _merged(mesh)
    elif isinstance(mesh, vtkPointSet):
        surface = _surface_of(mesh)
    else:
        raise TypeError(f"mesh must be a surface, a grid or a composite dataset, not {type(mesh).__name__}")
    if surface.GetNumberOfPolys() == 0:
        raise SurfaceSynthesisError("the mesh has no triangles or polygons, so there is nothing to show")
    if not np.isfinite(vtk_to_numpy(surface.GetPoints().GetData())).all():
        raise SurfaceSynthesisError("the mesh has points that are not finite; the filter vtkSurfaceRepairFilter removes them")
    return surface


def _surface_of(mesh):
    if not isinstance(mesh, vtkPolyData):
        outer = vtkDataSetSurfaceFilter()
        outer.SetInputData(mesh)
        outer.Update()
        mesh = outer.GetOutput()
    triangles = vtkTriangleFilter()
    triangles.PassLinesOff()
    triangles.PassVertsOff()
    triangles.SetInputData(mesh)
    triangles.Update()
    return triangles.GetOutput()


def _merged(tree):
    together = vtkAppendPolyData()
    iterator = tree.NewTreeIterator()
    iterator.InitTraversal()
    number = 0
    while not iterator.IsDoneWithTraversal():
        block = iterator.GetCurrentDataObject()
        if isinstance(block, vtkPointSet) and block.GetNumberOfCells() > 0:
            surface = vtkPolyData()
            surface.ShallowCopy(_surface_of(block))
            add_array(surface.GetCellData(), "Block", np.full(surface.GetNumberOfCells(), number, dtype=np.int32))
            together.AddInputData(surface)
        number += 1
        iterator.GoToNextItem()
    if together.GetNumberOfInputConnections(0) > 0:
        together.Update()
    return together.GetOutput()


def _encoded(surface, color_by):
    """The description of a surface, and its numbers as bytes that compress well."""
    points = vtk_to_numpy(surface.GetPoints().GetData()).astype(float)
    triangles = vtk_to_numpy(surface.GetPolys().GetConnectivityArray()).reshape(-1, 3).astype(np.int64)
    pieces = _Pieces()
    lower, upper = points.min(axis=0), points.max(axis=0)
    side = np.where(upper > lower, upper - lower, 1.0)
    scene = {
        "points": pieces.add(_differences(np.rint((points - lower) / side * 65535).astype(np.int64).T)),
        "triangles": pieces.add(_zigzag(triangles)),
        "numberOfPoints": len(points),
        "numberOfTriangles": len(triangles),
        "lower": lower.tolist(),
        "side": side.tolist(),
        "arrays": [],
    }
    for kind, data in (("point", surface.GetPointData()), ("cell", surface.GetCellData())):
        expected = len(points) if kind == "point" else len(triangles)
        for k in range(data.GetNumberOfArrays()):
            array = data.GetArray(k)  # None for texts
            if array is None or array.GetNumberOfTuples() != expected:
                continue  # damaged files have too few values
            if array.GetName() and array.GetNumberOfComponents() <= COMPONENTS:
                scene["arrays"].append({"name": array.GetName(), "kind": kind, **_encoded_array(array, pieces)})
    scene["colorBy"] = _first_array(surface, scene["arrays"], color_by)
    return scene, pieces.compressed()


def _first_array(surface, arrays, color_by):
    """The index of the array that is shown first; -1 for none."""
    names = [array["name"] for array in arrays]
    if color_by is not None:
        if color_by not in names:
            raise ValueError(f"there is no array '{color_by}'; the arrays are {', '.join(names) or 'none'}")
        return names.index(color_by)
    active = [data.GetScalars() for data in (surface.GetPointData(), surface.GetCellData())]
    for name in [array.GetName() for array in active if array is not None]:
        if name in names:
            return names.index(name)
    usual = [k for k, array in enumerate(arrays) if array["name"] not in ("Normals", "TCoords")]
    return (usual or [-1])[0]


def _encoded_array(array, pieces):
    """The description of an array, whose numbers are added to ``pieces``."""
    values = vtk_to_numpy(array)
    values = values.reshape(len(values), -1)
    if values.dtype == np.uint8 and values.shape[1] in (3, 4):
        return {"form": "colors", "components": values.shape[1], "data": pieces.add(values.T)}
    entry = {"components": values.shape[1]}
    if values.dtype.kind in "iu":
        distinct, codes = np.unique(values, return_inverse=True)
        if len(distinct) <= LABELS:
            data = pieces.add(codes.reshape(values.shape).T.astype(np.uint16))
            return {**entry, "form": "labels", "values": distinct.tolist(), "data": data}
    values = values.astype(float)
    finite = np.isfinite(values)
    lower, upper = (float(values[finite].min()), float(values[finite].max())) if finite.any() else (0.0, 0.0)
    # half of each, because the difference of two finite numbers may be infinite
    scaled = np.rint((values / 2 - lower / 2) / (upper / 2 - lower / 2) * LEVELS) if upper > lower else np.zeros_like(values)
    codes = np.where(finite, np.nan_to_num(scaled, posinf=0, neginf=0), MISSING).astype(np.uint16)
    return {**entry, "form": "quantized", "lower": lower, "upper": upper, "data": pieces.add(codes.T)}


def _differences(rows):
    """Differences of neighbors in each row, modulo 65536: the first is the value itself."""
    return np.diff(rows, axis=1, prepend=0).astype(np.uint16)


def _zigzag(triangles):
    """Ids as differences, small ones for neighboring triangles: of the first corners of one triangle and the next, of the
    other corners and the first. Signs are the lowest bits."""
    differences = np.empty_like(triangles)
    differences[:, 0] = np.diff(triangles[:, 0], prepend=0)
    differences[:, 1:] = triangles[:, 1:] - triangles[:, :1]
    return ((differences << 1) ^ (differences >> 63)).astype(np.uint32).T


class _Pieces:
    """Arrays of numbers one behind the other: of each first the lowest bytes of all numbers, then the next ones."""

    def __init__(self):
        self._bytes = []
        self._length = 0

    def add(self, values):
        """Adds numbers and returns the offset of their first byte."""
        values = np.ascontiguousarray(values)
        values = values.astype(values.dtype.newbyteorder("<")).reshape(-1)
        planes = values.view(np.uint8).reshape(len(values), -1).T.tobytes()
        self._bytes.append(planes)
        self._length += len(planes)
        return self._length - len(planes)

    def compressed(self):
        return zlib.compress(b"".join(self._bytes), 9)


def _page(scene, data, library):
    """The text of the page."""
    try:
        code = library.read_bytes()
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(library)) from None
    licence = library.parent / "LICENSE"
    parts = {
        "title": html.escape(scene["title"]),
        "licence": html.escape(licence.read_text(encoding="utf-8", errors="replace")) if licence.is_file() else "",
        "scene": json.dumps(scene, ensure_ascii=True, allow_nan=False).replace("<", "\\u003c"),
        "data": base64.b64encode(data).decode(),
        "library": base64.b64encode(zlib.compress(code, 9)).decode(),
        "viewer": (_HERE / "viewer.js").read_text(encoding="utf-8"),
    }
    page = (_HERE / "viewer.html").read_text(encoding="utf-8")
    before, *rest = page.split("@@")  # text, name, text, name, text ...
    return before + "".join(parts[name] + text for name, text in zip(rest[::2], rest[1::2]))
