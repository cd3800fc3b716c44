# SPDX-License-Identifier: BSD-3-Clause
"""Tests of train_textures.py and make_references.py on few triangles: ``test_train_textures.py FOLDER``. Run by CTest."""

import contextlib
import io
import os
import re
import shlex
import shutil
import sys

import numpy as np

import make_references
import surfacesynthesis
import train_textures

HERE = os.path.dirname(os.path.abspath(__file__))


def refusal_of(main, *arguments):
    """The text that a script prints before it ends with 2."""
    text = io.StringIO()
    with contextlib.redirect_stderr(text):
        try:
            main(list(arguments))
        except SystemExit as ended:
            assert ended.code == 2, ended.code
            return text.getvalue()
    raise AssertionError(f"{arguments} were accepted")


def check_refusals(folder):
    """The labyrinth is known on the ball alone."""
    output = os.path.join(folder, "refused")
    for main in (train_textures.main, make_references.main):
        for only in ([], ["--only", "labyrinth"], ["--only", "spikes", "labyrinth"]):
            message = refusal_of(main, output, *only, "--surfaces", "ball", "torus")
            assert "the labyrinth is a harmonic of the ball: --only spikes knobs, or --surfaces ball" in message, message
    assert not os.path.exists(output)


def check_documented_commands():
    """Each command of the README is one that the script takes."""
    with open(os.path.join(HERE, "README.md"), encoding="utf-8") as file:
        text = file.read().replace("\\\n", " ")
    commands = re.findall(r"^python3 Examples/Training/train_textures\.py (.*)$", text, re.MULTILINE)
    assert len(commands) == 8, commands
    options = [train_textures.parsed(shlex.split(command, comments=True)) for command in commands]
    several = options[[len(one.surfaces or []) for one in options].index(3)]
    assert several.only == ["spikes", "knobs"] and several.iterations == [2000, 2000, 600, 300], several
    assert len(several.iterations) == several.levels
    flows = [one for one in options if one.objective == "flow_matching"]
    assert [train_textures.recipe_of(one)["layers"] for one in flows] == [7, 12, 12], flows
    assert [train_textures.recipe_of(one)["base_samples"] for one in flows] == [0, 8, 0], flows
    surfaces = [[train_textures.surfaces_of(one, name) for name in ("knobs", "labyrinth")] for one in flows]
    assert surfaces == [[["ball"]] * 2, *[[["ball", "torus"], ["ball"]]] * 2], surfaces
    assert all(len(train_textures.recipe_of(one)["iterations"]) == one.levels for one in flows)


def check_training(folder):
    """A texture is learned from all surfaces that are named."""
    model = os.path.join(folder, "spikes.safetensors")
    arguments = [folder, "--only", "spikes", "--iterations", "2,1", "--levels", "2"]
    train_textures.main([*arguments, "--surfaces", "ball", "torus", "--objective", "adversarial"])
    with open(os.path.join(folder, "spikes.csv"), encoding="utf-8") as file:
        assert len(file.readlines()) == 4
    train_textures.main(arguments)  # a flow, of a ball and a torus
    flow = os.path.join(folder, "flow_spikes.safetensors")
    assert surfacesynthesis.geometric_texture(None, flow, seed=1).GetNumberOfCells() == 4 * 320
    output = surfacesynthesis.geometric_texture(None, model, seed=1)
    assert output.GetNumberOfCells() == 4 * 320
    assert np.isfinite(surfacesynthesis.topology_report(output)["area"])


if __name__ == "__main__":
    work = sys.argv[1]
    shutil.rmtree(work, ignore_errors=True)
    check_refusals(work)
    check_documented_commands()
    check_training(work)
    print("passed")
