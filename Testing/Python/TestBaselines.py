# SPDX-License-Identifier: BSD-3-Clause
"""R19: numbers and a picture of each filter, compared with Testing/Data/Baselines.

The files change only when a filter or a shipped model is meant to change. To write them again:

    SURFACE_SYNTHESIS_REGENERATE_BASELINES=1 ctest -R Python.Baselines

vtkMaternNoiseFilter and vtkVDBSurfaceFilter have tests of their own in Testing/Filters.
"""

import json
import os
import sys
import warnings

import numpy as np
import pytest
from conftest import icosphere
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPolyData
from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter
from vtkmodules.vtkImagingCore import vtkImageDifference
from vtkmodules.vtkIOImage import vtkPNGReader

import surfacesynthesis
from surfacesynthesis.datasets import dataset_of_pair

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, os.pardir)
sys.path.insert(0, os.path.join(ROOT, "Examples", "Python"))

import gallery_rendering as rendering  # noqa: E402

FOLDER = os.path.join(ROOT, "Testing", "Data", "Baselines")
MODELS = os.path.join(ROOT, "Examples", "Models")
REGENERATE = bool(os.environ.get("SURFACE_SYNTHESIS_REGENERATE_BASELINES"))
SIZE = (200, 200)
DIRECTION = (0.4, 0.3, 1.0)
#: Relative to the largest absolute value of an array: what double precision leaves, and what single precision does on
#: another processor, in a network of dozens of layers.
DOUBLE, SINGLE = 1e-9, 1e-4
#: vtkImageDifference's thresholded error; VTK's own tests use 10.
PICTURE = 10.0


def jack(levels=3):
    """A ball with six arms. Its symmetry makes ties, so that the last digits of NumPy, which differ between processors, are
    rounded away: meshers then decide the ties alike everywhere."""
    points, triangles = icosphere(levels)
    reach = (np.abs(points) ** 8).sum(axis=1, keepdims=True)
    return np.round(points * (0.5 + 1.0 * reach) * np.array([1.0, 1.2, 0.9]), 10), triangles


def torn(mesh):
    """Without some triangles, and with one of them twice."""
    points, triangles = mesh
    return points, np.concatenate([triangles[5:300], triangles[310:], triangles[20:21]])


def model(name):
    return os.path.join(MODELS, name + ".safetensors")


def points_of(mesh):
    return vtk_to_numpy(mesh.GetPoints().GetData())


def array_of(mesh, name):
    return vtk_to_numpy(mesh.GetPointData().GetArray(name))


def surface(mesh=None):
    return dataset_of_pair(mesh or jack())


def colored(mesh, values):
    copy = vtkPolyData()
    copy.CopyStructure(mesh)
    array = numpy_to_vtk(np.ascontiguousarray(values, dtype=float), deep=True)
    array.SetName("Colour")
    copy.GetPointData().AddArray(array)
    return copy


# Each gives arrays by name, a surface to look at, and the tolerance.


def remesh():
    output = surfacesynthesis.remesh(surface(), points=600)
    return {"points": points_of(output)}, output, DOUBLE


def repair():
    output = surfacesynthesis.repair(surface(torn(jack())), holes="all")
    return {"points": points_of(output)}, output, DOUBLE


def tetrahedralize():
    output = surfacesynthesis.tetrahedralize(surface())
    skin = vtkGeometryFilter()
    skin.SetInputData(output)
    skin.Update()
    return {"points": points_of(output), "cells": np.array([output.GetNumberOfCells()])}, skin.GetOutput(), DOUBLE


def topology():
    report = surfacesynthesis.topology_report(surface(torn(jack())))
    names = ("triangles", "components", "boundary_loops", "area", "edge_length_mean", "angle_minimum")
    return {name: np.array([report[name]], dtype=float) for name in names}, None, DOUBLE


def mixture():
    (values,) = surfacesynthesis.gaussian_mixtures(jack(), 1, seed=3)
    return {"mixture": values}, colored(surface(), 2.0 * values.ravel() - 1.0), DOUBLE


def poses():
    (points,) = surfacesynthesis.poses(jack(2), 1, seed=3)
    return {"points": points}, surface((points, jack(2)[1])), DOUBLE


def ensemble():
    points, triangles = jack(2)
    random = np.random.default_rng(0).normal(size=(8, len(points), 3))
    metrics = surfacesynthesis.ensemble_metrics(points + random[:4], points + random[4:], source=(points, triangles))
    return {name: np.array([metrics[name]]) for name in ("mmd", "cov", "reference_spacing")}, None, DOUBLE


def network():
    (values,) = surfacesynthesis.poisson_net(jack(), model("smoothed_curvature")).values.T
    return {"prediction": values}, colored(surface(), values / np.abs(values).max()), SINGLE


def sampler():
    output = surfacesynthesis.sample_signal(surface(), model("bunny_mixtures"), seed=1, steps=4)
    values = array_of(output, "Mixture")
    return {"signal": values}, colored(output, values / np.abs(values).max()), SINGLE


def deformer():
    output = surfacesynthesis.deform(surface(), model("armadillo_poses"), seed=1, steps=4)
    return {"points": points_of(output)}, output, SINGLE


def texture():
    output = surfacesynthesis.geometric_texture(surface(), model("spikes"), seed=1, start_level=1)
    return {"points": points_of(output)}, output, SINGLE


def fitter():
    fit = surfacesynthesis.fit_levels(surface(), levels=2, icosphere_level=2, iterations=20, surface_samples=500)
    return {"points": points_of(fit.levels[-1]), "distance": np.array(fit.mean_distances)}, fit.levels[-1], 1e-5


def flow_trainer(folder):
    points, triangles = jack(1)
    samples = points[None] + 0.1 * np.random.default_rng(0).normal(size=(4, len(points), 3))
    losses = surfacesynthesis.train_flow_matching(
        (points, triangles), samples, model=os.path.join(folder, "flow.safetensors"), iterations=2, width=8, blocks=1
    )
    return {"loss": losses["loss"]}, None, SINGLE


def texture_trainer(folder):
    levels = surfacesynthesis.fit_levels(surface(), levels=2, icosphere_level=1, iterations=0).levels
    losses = surfacesynthesis.train_geometric_texture(
        levels,
        model=os.path.join(folder, "texture.safetensors"),
        objective="adversarial",
        iterations=1,
        start_channels=8,
        minimum_channels=8,
    )
    return {name: losses[name] for name in ("critic_loss", "gradient_penalty")}, None, 1e-3


FILTERS = (
    remesh,
    repair,
    tetrahedralize,
    topology,
    mixture,
    poses,
    ensemble,
    network,
    sampler,
    deformer,
    texture,
    fitter,
    flow_trainer,
    texture_trainer,
)


def numbers(arrays):
    """Record of each array: its size, statistics, and some of its values."""
    kept = {}
    for name, array in arrays.items():
        values = np.asarray(array, dtype=float).ravel()
        picked = values[:: max(1, len(values) // 5)][:6]
        statistics = [values.mean(), np.sqrt((values**2).mean()), values.min(), values.max()]
        kept[name] = {"size": len(values), "values": [*statistics, *picked]}
    return kept


def baseline(name):
    return os.path.join(FOLDER, name)


def difference(image, path):
    """Difference of a picture [height, width, 3] from that of a file."""
    reader = vtkPNGReader()
    reader.SetFileName(path)
    reader.Update()
    found = vtkImageData()
    found.SetDimensions(image.shape[1], image.shape[0], 1)
    found.GetPointData().SetScalars(numpy_to_vtk(np.ascontiguousarray(image[::-1].reshape(-1, 3)), deep=True))
    compared = vtkImageDifference()
    compared.SetInputData(found)
    compared.SetImageData(reader.GetOutput())
    compared.Update()
    return compared.GetThresholdedError()


@pytest.mark.parametrize("made", FILTERS, ids=lambda made: made.__name__)
def test_numbers_and_picture(made, tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", surfacesynthesis.SurfaceSynthesisWarning)  # the jack is no armadillo
        arrays, shown, tolerance = made(str(tmp_path)) if made.__code__.co_argcount else made()
    found = numbers(arrays)
    picture = None
    if shown is not None:
        view = rendering.view_of(shown, 1.0, DIRECTION)
        array = "Colour" if shown.GetPointData().HasArray("Colour") else None
        picture = rendering.render(shown, view, SIZE, array=array)
    if REGENERATE:
        os.makedirs(FOLDER, exist_ok=True)
        with open(baseline(made.__name__ + ".json"), "w", encoding="utf-8") as file:
            json.dump(found, file, indent=1)
            file.write("\n")
        if picture is not None:
            rendering.write_png(picture, baseline(made.__name__ + ".png"))
        pytest.skip("wrote the baseline")
    with open(baseline(made.__name__ + ".json"), encoding="utf-8") as file:
        expected = json.load(file)
    assert found.keys() == expected.keys()
    for name, numbers_of_array in expected.items():
        assert found[name]["size"] == numbers_of_array["size"], name
        scale = np.abs(numbers_of_array["values"]).max()
        assert np.allclose(found[name]["values"], numbers_of_array["values"], rtol=0, atol=tolerance * scale), name
    if picture is not None:
        assert difference(picture, baseline(made.__name__ + ".png")) < PICTURE


def test_another_picture_is_told_apart():
    view = rendering.view_of(surface(), 1.0, DIRECTION)
    picture = rendering.render(surface(), view, SIZE)
    assert difference(picture, baseline("texture.png")) > 5 * PICTURE
    assert difference(picture, baseline("deformer.png")) > 2 * PICTURE
