# SPDX-License-Identifier: BSD-3-Clause
"""Pages that show a surface: what is in them. TestPagesInBrowser.py looks at them in a browser."""

import base64
import json
import re
import zlib

import numpy as np
import pytest
from conftest import add_array, icosphere, points_of, polydata_of
from surfacesynthesis import SurfaceSynthesisError, find_vtk_js, write_page
from surfacesynthesis.command_line import main
from surfacesynthesis.files import write_mesh
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import VTK_TETRA, vtkMultiBlockDataSet, vtkPolyData, vtkUnstructuredGrid
from vtkmodules.vtkFiltersSources import vtkCubeSource

LIBRARY = "// a stand-in for vtk.js </script> é\n"


@pytest.fixture
def library(tmp_path, monkeypatch):
    """A stand-in for vtk.js, which write_page() finds."""
    folder = tmp_path / "library"
    folder.mkdir()
    (folder / "vtk.js").write_text(LIBRARY, encoding="utf-8")
    (folder / "LICENSE").write_text("Copyright <someone>", encoding="utf-8")
    monkeypatch.setenv("SURFACE_SYNTHESIS_VTK_JS", str(folder / "vtk.js"))
    return folder / "vtk.js"


class Page:
    """A page that was written, decoded as viewer.js decodes it."""

    def __init__(self, path):
        self.text = path.read_text(encoding="utf-8")
        self.scene = json.loads(self.script("scene"))
        self._bytes = np.frombuffer(self.inflated("data"), dtype=np.uint8)

    def script(self, name):
        return re.search(rf'<script type="[^"]*" id="{name}">(.*?)</script>', self.text, re.DOTALL)[1]

    def inflated(self, name):
        return zlib.decompress(base64.b64decode(self.script(name)))

    def numbers(self, offset, shape, kind):
        size, count = np.dtype(kind).itemsize, int(np.prod(shape))
        planes = self._bytes[offset:offset + size * count].reshape(size, count)
        return np.ascontiguousarray(planes.T).view(kind).reshape(shape)

    def points(self):
        codes = self.numbers(self.scene["points"], (3, self.scene["numberOfPoints"]), "<u2")
        codes = np.cumsum(codes, axis=1) % 65536
        return (np.array(self.scene["lower"])[:, None] + codes / 65535 * np.array(self.scene["side"])[:, None]).T

    def triangles(self):
        codes = self.numbers(self.scene["triangles"], (3, self.scene["numberOfTriangles"]), "<u4").astype(np.int64)
        signed = (codes >> 1) ^ -(codes & 1)
        first = np.cumsum(signed[0])
        return np.stack([first, first + signed[1], first + signed[2]], axis=1)

    def array(self, name):
        entry = next(entry for entry in self.scene["arrays"] if entry["name"] == name)
        count = self.scene["numberOfPoints" if entry["kind"] == "point" else "numberOfTriangles"]
        kind = "u1" if entry["form"] == "colors" else "<u2"
        codes = self.numbers(entry["data"], (entry["components"], count), kind).T
        if entry["form"] == "labels":
            return np.array(entry["values"])[codes]
        if entry["form"] == "colors":
            return codes
        return np.where(codes == 65535, np.nan, entry["lower"] + codes / 65534 * (entry["upper"] - entry["lower"]))


def page_of(mesh, tmp_path, **options):
    write_page(mesh, tmp_path / "page.html", **options)
    return Page(tmp_path / "page.html")


def test_points_and_triangles_are_those_of_the_mesh(library, tmp_path, pair):
    points, triangles = pair
    page = page_of(polydata_of(points * [1, 20, 300] + 5, triangles), tmp_path)
    sides = 2 * np.array([1, 20, 300])
    np.testing.assert_allclose(page.points(), points * [1, 20, 300] + 5, rtol=0, atol=0.51 / 65535 * sides.max())
    assert (np.abs(page.points() - (points * [1, 20, 300] + 5)) <= 0.51 / 65535 * sides).all()
    np.testing.assert_array_equal(page.triangles(), triangles)


def test_values_are_within_half_a_level_and_missing_ones_stay_missing(library, tmp_path, pair):
    mesh = polydata_of(*pair)
    values = np.random.default_rng(1).standard_normal((len(pair[0]), 3))
    values[5] = [np.nan, np.inf, -np.inf]
    add_array(mesh.GetPointData(), "Values", values)
    add_array(mesh.GetPointData(), "Huge", 1.5e308 * np.linspace(-1, 1, len(values)))
    add_array(mesh.GetPointData(), "Constant", np.full(len(values), 7.5))
    add_array(mesh.GetPointData(), "Short", np.arange(3.0))  # as in a damaged file
    add_array(mesh.GetPointData(), "Empty", np.zeros(0))
    page = page_of(mesh, tmp_path)
    found, finite = page.array("Values"), np.isfinite(values)
    np.testing.assert_array_equal(np.isfinite(found), finite)
    assert np.abs(found - values)[finite].max() <= 0.51 / 65534 * np.ptp(values[finite])
    entry = next(entry for entry in page.scene["arrays"] if entry["name"] == "Huge")
    assert [entry["lower"], entry["upper"]] == [-1.5e308, 1.5e308]
    np.testing.assert_array_equal(page.array("Constant"), np.full((len(values), 1), 7.5))
    assert [entry["name"] for entry in page.scene["arrays"]] == ["Values", "Huge", "Constant"]


def test_labels_and_colors_are_exact(library, tmp_path, pair):
    mesh = polydata_of(*pair)
    random = np.random.default_rng(2)
    labels = random.choice([-7, 3, 2001], (len(pair[1]), 1)).astype(np.int32)
    colors = random.integers(0, 256, (len(pair[0]), 3)).astype(np.uint8)
    add_array(mesh.GetCellData(), "Region", labels)
    add_array(mesh.GetPointData(), "RGB", colors)
    page = page_of(mesh, tmp_path, color_by="RGB")
    np.testing.assert_array_equal(page.array("Region"), labels)
    np.testing.assert_array_equal(page.array("RGB"), colors)
    assert page.scene["arrays"][page.scene["colorBy"]]["name"] == "RGB"


def test_polygons_blocks_and_volumes_are_shown_as_triangles(library, tmp_path):
    cube = vtkCubeSource()
    cube.Update()
    box = cube.GetOutput()
    add_array(box.GetCellData(), "Side", np.arange(6))
    page = page_of(box, tmp_path)
    assert page.scene["numberOfTriangles"] == 12
    np.testing.assert_array_equal(page.array("Side").ravel(), np.repeat(np.arange(6), 2))

    blocks = vtkMultiBlockDataSet()
    blocks.SetBlock(0, box)
    blocks.SetBlock(1, polydata_of(*icosphere(0)))
    page = page_of(blocks, tmp_path)
    np.testing.assert_array_equal(page.array("Block").ravel(), [0] * 12 + [1] * 20)

    grid, points = vtkUnstructuredGrid(), vtkPoints()
    for point in ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)):
        points.InsertNextPoint(point)
    grid.SetPoints(points)
    grid.InsertNextCell(VTK_TETRA, 4, [0, 1, 2, 3])
    assert page_of(grid, tmp_path).scene["numberOfTriangles"] == 4


def test_the_page_is_self_contained_and_text_cannot_leave_its_place(library, tmp_path, ball):
    mesh = polydata_of(*ball)
    add_array(mesh.GetPointData(), "</script><b>", points_of(mesh)[:, 0])
    page = page_of(mesh, tmp_path, title="a < b </title>")
    assert page.inflated("library").decode() == LIBRARY
    assert "Copyright &lt;someone&gt;" in page.text
    assert page.scene["title"] == "a < b </title>" and "a &lt; b &lt;/title&gt;" in page.text
    assert page.scene["arrays"][0]["name"] == "</script><b>" and "</script><b>" not in page.text
    assert not re.search(r"""(src|href)=|url\(|https?://|@import""", page.text.replace(page.script("licence"), ""))
    assert page.text.count("</script>") == 5


def test_what_is_missing_is_said(library, tmp_path, ball, monkeypatch):
    mesh = polydata_of(*ball)
    target = tmp_path / "page.html"
    with pytest.raises(ValueError, match="there is no array 'B'; the arrays are none"):
        write_page(mesh, target, color_by="B")
    with pytest.raises(ValueError, match="ends with .html"):
        write_page(mesh, tmp_path / "page.txt")
    with pytest.raises(SurfaceSynthesisError, match="no triangles"):
        write_page(vtkPolyData(), target)
    with pytest.raises(TypeError, match="surface"):
        write_page("mesh", target)
    points_of(mesh)[0, 0] = np.nan
    with pytest.raises(SurfaceSynthesisError, match="not finite"):
        write_page(mesh, target)
    with pytest.raises(FileNotFoundError):
        write_page(polydata_of(*ball), target, vtk_js=tmp_path / "none.js")
    assert [path.name for path in tmp_path.iterdir()] == ["library"]  # nothing is left behind


def test_vtk_js_is_looked_for_and_the_way_to_it_is_told(tmp_path, monkeypatch):
    monkeypatch.delenv("SURFACE_SYNTHESIS_VTK_JS", raising=False)
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path / "work")
    installed = tmp_path / "data" / "surfacesynthesis" / "node_modules" / "vtk.js" / "vtk.js"
    beside = tmp_path / "node_modules" / "vtk.js" / "vtk.js"
    try:
        assert not str(find_vtk_js()).startswith(str(tmp_path))  # one of the system
    except SurfaceSynthesisError as error:
        assert f"npm install --ignore-scripts --prefix {tmp_path / 'data' / 'surfacesynthesis'} vtk.js" in str(error)
        for path in (installed, beside):
            path.parent.mkdir(parents=True)
            path.write_text("")
            assert find_vtk_js() == path


def test_command_writes_the_page(library, tmp_path, ball, capsys):
    mesh = polydata_of(*ball)
    add_array(mesh.GetPointData(), "A", points_of(mesh)[:, 0])
    add_array(mesh.GetPointData(), "B", points_of(mesh)[:, 1])
    write_mesh(mesh, tmp_path / "result.vtp")
    words = ["view", str(tmp_path / "result.vtp"), "-o", str(tmp_path / "page.html")]
    assert main([*words, "--color-by", "B"]) == 0
    page = Page(tmp_path / "page.html")
    assert page.scene["title"] == "result.vtp"
    assert page.scene["arrays"][page.scene["colorBy"]]["name"] == "B"
    assert str(tmp_path / "page.html") in capsys.readouterr().out
    assert main([*words, "--color-by", "C"]) == 2
    assert main(["view", str(tmp_path / "result.vtp"), "-o", "page.txt"]) == 2


def test_size_of_a_large_page(library, tmp_path):
    """About 10 bytes a triangle, and 3 to 5 a value of noise, beside vtk.js."""
    points, triangles = icosphere(5)
    mesh = polydata_of(points, triangles)
    page_of(mesh, tmp_path)
    bare = (tmp_path / "page.html").stat().st_size
    assert bare - 20000 < 11 * len(triangles)
    add_array(mesh.GetPointData(), "Noise", np.random.default_rng(3).standard_normal(len(points)))
    page_of(mesh, tmp_path)
    assert (tmp_path / "page.html").stat().st_size - bare < 3 * len(points)
