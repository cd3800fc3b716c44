# SPDX-License-Identifier: BSD-3-Clause
"""Pages that show a surface, in headless Chromium: the surface is there, its colors follow the arrays, nothing is fetched.

Needs chromium, and vtk.js: find_vtk_js() finds it, or npm brings it into the folder of the environment variable
SURFACE_SYNTHESIS_NPM_FOLDER. Pictures are kept in the folder SURFACE_SYNTHESIS_PICTURES, if that is set.
"""

import html
import os
import pathlib
import re
import shutil
import subprocess

import numpy as np
import pytest
from conftest import add_array, icosphere, points_of, polydata_of
from surfacesynthesis import SurfaceSynthesisError, find_vtk_js, write_page
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOImage import vtkPNGReader

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
SIZE = (1200, 850)
BACKGROUND = (244, 245, 247)


@pytest.fixture(scope="module")
def library():
    """vtk.js, which npm brings where it is not installed."""
    try:
        return find_vtk_js()
    except SurfaceSynthesisError:
        folder = pathlib.Path(os.environ["SURFACE_SYNTHESIS_NPM_FOLDER"])
        found = folder / "node_modules" / "vtk.js" / "vtk.js"
        if not found.is_file():
            words = ["npm", "install", "--ignore-scripts", "--no-audit", "--no-fund", "--prefix", folder, "vtk.js@37"]
            subprocess.run(words, check=True)
        return found


class Browser:
    """Chromium without a screen and without a network."""

    def __init__(self, folder):
        self._folder = folder

    def _run(self, *options):
        words = [CHROMIUM, "--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
                 "--hide-scrollbars", f"--window-size={SIZE[0]},{SIZE[1]}", "--virtual-time-budget=30000",
                 "--host-resolver-rules=MAP * ~NOTFOUND", f"--user-data-dir={self._folder / 'profile'}", *options]  # fmt: skip
        return subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=True, timeout=120).stdout

    def facts(self, page):
        """The data attributes of the body of a page."""
        body = re.search(r"<body[^>]*>", self._run("--dump-dom", page.as_uri()))[0]
        return {name: html.unescape(value) for name, value in re.findall(r'data-(\w+)="([^"]*)"', body)}

    def picture(self, page, address="", name="picture"):
        """The pixels [rows, columns, 3] of a page."""
        path = pathlib.Path(os.environ.get("SURFACE_SYNTHESIS_PICTURES", self._folder), f"{name}.png")
        self._run(f"--screenshot={path}", page.as_uri() + address)
        reader = vtkPNGReader()
        reader.SetFileName(str(path))
        reader.Update()
        pixels = vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars())
        return pixels.reshape(*reader.GetOutput().GetDimensions()[1::-1], -1)[::-1, :, :3].astype(int)


@pytest.fixture(scope="module")
def page(tmp_path_factory, library):
    """A page of a ball with several arrays."""
    points, triangles = icosphere(4, 50.0)
    mesh = polydata_of(points, triangles)
    add_array(mesh.GetPointData(), "Height", points[:, 2])
    add_array(mesh.GetPointData(), "Half", np.where(points[:, 2] > 0, np.nan, points[:, 0]))
    add_array(mesh.GetPointData(), "Direction", points / 50)
    add_array(mesh.GetPointData(), "Red", np.tile(np.array([[255, 0, 0]], dtype=np.uint8), (len(points), 1)))
    add_array(mesh.GetCellData(), "Side", (points[triangles[:, 0], 2] > 0).astype(np.int32))
    path = tmp_path_factory.mktemp("pages") / "page.html"
    write_page(mesh, path, color_by="Height", title="A ball", vtk_js=library)
    return path


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    return Browser(tmp_path_factory.mktemp("browser"))


def surface_of(pixels):
    """The pixels of the surface, a disk in the middle of the picture."""
    rows, columns = np.mgrid[: pixels.shape[0], : pixels.shape[1]]
    inside = (rows - SIZE[1] / 2) ** 2 + (columns - SIZE[0] / 2) ** 2 < 200**2
    return pixels[inside]


def test_the_browser_decodes_what_was_written(browser, page):
    points, triangles = icosphere(4, 50.0)
    facts = browser.facts(page)
    assert facts["state"] == "ready", facts
    assert facts["points"] == str(len(points)) and facts["corners"] == str(triangles.sum())
    extent = [float(value) for part in facts["extent"].split() for value in part.split(",")]
    shown = [points.min(axis=0) / 100, points.max(axis=0) / 100]  # around the origin, with a longest side of 1
    np.testing.assert_allclose(np.reshape(extent, (3, 2)).T, shown, rtol=0, atol=1e-4)
    np.testing.assert_allclose([float(value) for value in facts["range"].split()], [-50, 50], rtol=0, atol=0.01)


def test_surfaces_of_any_size_and_place_look_the_same(browser, tmp_path, library):
    points, triangles = icosphere(2)
    pictures = []
    for name, placed in (("near", points), ("far", points + 1e6), ("small", 1e-9 * points)):
        write_page(polydata_of(placed, triangles), tmp_path / f"{name}.html", title="A ball", vtk_js=library)
        pictures.append(browser.picture(tmp_path / f"{name}.html", name=name))
    assert len(np.unique(surface_of(pictures[0]) // 8, axis=0)) > 4, "it is shaded"
    for picture in pictures[1:]:
        assert (np.abs(picture - pictures[0]).max(axis=2) > 8).mean() < 1e-3


def test_the_surface_is_drawn_and_colors_follow_the_arrays(browser, page):
    heights = browser.picture(page, name="height")
    disk = surface_of(heights)
    assert (np.abs(disk - BACKGROUND).max(axis=1) > 12).all(), "the ball covers the middle"
    assert (np.abs(heights[-40:, 400:800] - BACKGROUND) < 3).all(), "and not the rim"
    assert len(np.unique(disk // 16, axis=0)) > 40, "many colors"
    top, bottom = heights[260, 600], heights[590, 600]
    assert top[0] > top[2] and bottom[2] > bottom[1], f"viridis: yellow above, blue below, not {top} and {bottom}"

    turned = browser.picture(page, "#up=-z", "turned")
    above, below = turned[260, 600], turned[590, 600]
    assert above[2] > above[1] and below[1] > below[2], f"upside down: blue above, green below, not {above} and {below}"

    red = surface_of(browser.picture(page, "#array=Red", "red"))
    assert (red[:, 0] > 80).all() and (red[:, 1:] < 12).all()

    sides = browser.picture(page, "#array=Side", "side")
    above, below = sides[300, 600], sides[600, 600]
    assert above[0] > 1.5 * above[2] and below[2] > 1.5 * below[0], f"two labels, orange and blue, not {above} and {below}"

    half = browser.picture(page, "#array=Half&map=Plasma", "half")
    assert np.ptp(half[260, 600]) < 4, "missing values are gray"
    assert np.ptp(half[600, 600]) > 30

    direction = surface_of(browser.picture(page, "#array=Direction&component=0", "direction"))
    plain = surface_of(browser.picture(page, "#array=", "plain"))
    assert np.abs(direction - disk).mean() > 20 and (np.ptp(plain, axis=1) < 25).all()


def test_a_page_of_200000_triangles_is_small_and_shown(browser, library, tmp_path):
    points, triangles = icosphere(7)
    mesh = polydata_of(points, triangles[: 200_000])
    add_array(mesh.GetPointData(), "Noise", np.random.default_rng(1).standard_normal(len(points)))
    assert points_of(mesh).shape[0] > 100_000
    write_page(mesh, tmp_path / "large.html", vtk_js=library)
    assert (tmp_path / "large.html").stat().st_size < 5 * 2**20
    assert browser.facts(tmp_path / "large.html")["state"] == "ready"


def test_a_page_that_cannot_be_shown_says_so(browser, page, tmp_path, library):
    broken = tmp_path / "broken.html"
    text = page.read_text(encoding="utf-8")
    broken.write_text(re.sub(r'(id="data">)[^<]{20}', r"\1AAAAAAAAAAAAAAAAAAAA", text), encoding="utf-8")
    assert browser.facts(broken)["state"] == "failed"
