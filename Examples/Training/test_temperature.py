# SPDX-License-Identifier: BSD-3-Clause
"""Tests temperature.py on a model that has hardly learnt anything: ``test_temperature.py FOLDER``. Run by CTest."""

import json
import os
import shutil
import struct
import sys

import numpy as np

import surfacesynthesis
import temperature
from test_compare_noise import icosphere


def shapes(points, count):
    """Spheres that are longer or shorter along three directions."""
    random = np.random.default_rng(0)
    return (points * (1.0 + 0.2 * random.standard_normal((count, 1, 3)))).astype(np.float32)


def check_spread(mesh):
    """Shapes twice as far from their mean have twice the spread, wherever they lie."""
    points = np.tile(mesh[0], (2, 1, 1)) * np.array([0.9, 1.1])[:, None, None]
    middle = points.mean(axis=0)
    assert np.isclose(temperature.spread(mesh, middle + 2.0 * (points - middle) + 5.0), 2.0 * temperature.spread(mesh, points))
    assert np.isclose(temperature.spread(mesh, points), 0.1 * np.sqrt(2.0), atol=1e-6), temperature.spread(mesh, points)
    many = shapes(mesh[0], 600).astype(float)
    few = np.mean([temperature.spread(mesh, many[k : k + 4]) ** 2 for k in range(0, 600, 4)])
    assert np.isclose(few, temperature.spread(mesh, many) ** 2, rtol=0.02), "few shapes spread as many, in the mean"


def check_model(folder, mesh):
    data, model, output = (os.path.join(folder, name) for name in ("data.safetensors", "m.safetensors", "warm.safetensors"))
    sources = [(ball, shapes(ball[0], 24)) for ball in (mesh, icosphere(1))]
    surfacesynthesis.write_signal_dataset(data, sources, "Position")
    surfacesynthesis.train_flow_matching(dataset=data, model=model, iterations=3, width=8, blocks=1, batch=4, without_encoder=True)
    options = ["--samples", "12", "--steps", "2"]
    assert temperature.main([model, data, *options, "--spread", "1e6", "--output", output]) == 1
    assert not os.path.exists(output), "nothing is written where no temperature suffices"
    sources = surfacesynthesis.read_signal_dataset(data).sources
    found = temperature.suitable(model, sources, temperature.parsed([model, data, *options, "--spread", "0"]))
    assert found[0] == 1.0 and found[1] > 0.0, "one that varies enough stays as it is"
    more = temperature.parsed([model, data, *options, "--spread", str(1.02 * found[1])])
    expected = temperature.suitable(model, sources, more)
    spreads = [temperature.relative_spread(model, source, expected[0], 6, more) for source in sources]
    assert np.isclose(np.mean(spreads), expected[1]) and not np.isclose(*spreads, rtol=1e-3), (spreads, expected)
    assert expected[0] > 1.0 and expected[1] >= 1.02 * found[1], (expected, found)
    assert temperature.main([model, data, *options, "--spread", str(1.02 * found[1]), "--output", output]) == 0
    flow = {"seed": 3, "steps": 2}
    warm = surfacesynthesis.deform(mesh, output, **flow)
    assert np.array_equal(warm, surfacesynthesis.deform(mesh, model, temperature=expected[0], **flow))
    assert not np.allclose(warm, surfacesynthesis.deform(mesh, model, **flow), atol=1e-4)
    further = os.path.join(folder, "further.safetensors")
    surfacesynthesis.train_flow_matching(
        dataset=data, model=further, initial_model=output, iterations=1, batch=4, without_encoder=True
    )
    assert described(output)["temperature"] == expected[0] and "temperature" not in described(further), "of other weights"
    with open(output, "rb") as file:
        again = temperature.with_temperature(file.read(), 2.0)
    with open(output, "wb") as file:
        file.write(again)
    twice = surfacesynthesis.deform(mesh, model, temperature=2.0 * expected[0], **flow)
    assert np.allclose(surfacesynthesis.deform(mesh, output, **flow), twice, atol=1e-6)


def described(path):
    """The description of the model in its file."""
    with open(path, "rb") as file:
        (size,) = struct.unpack("<Q", file.read(8))
        return json.loads(json.loads(file.read(size))["__metadata__"]["flow_matching"])


def main():
    folder = sys.argv[1]
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    mesh = icosphere(2)
    check_spread(mesh)
    check_model(folder, mesh)
    print("passed")


if __name__ == "__main__":
    main()
