# SPDX-License-Identifier: BSD-3-Clause
"""Importing the package and applying models load no LibTorch; only training does, where the build has it."""

import os
import subprocess
import sys

import pytest
import surfacesynthesis
from surfacesynthesis.command_line import build_parser

MODELS = os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, os.pardir, "Examples", "Models")
TRAINING = (
    "FittedLevels",
    "fit_levels",
    "latent_dataset",
    "train_field_latents",
    "train_flow_matching",
    "train_geometric_texture",
    "train_latent_diffusion",
    "vtkFieldLatentTrainer",
    "vtkFlowMatchingTrainer",
    "vtkGeometricTextureTrainer",
    "vtkLatentDiffusionTrainer",
    "vtkMultiscaleMeshFitter",
)
#: Runs everything but training on a small sphere, then prints what is loaded.
APPLYING = """
import sys, warnings
warnings.simplefilter("ignore")
from conftest import icosphere
import surfacesynthesis as s

mesh, models = icosphere(2, 0.28), sys.argv[1] + "/"
s.matern_noise(mesh, range=0.3)
assert s.poisson_net(mesh, models + "smoothed_curvature.safetensors").values.shape == (162, 1)
assert s.deform(mesh, models + "armadillo_poses.safetensors", steps=1).shape == (162, 3)
assert s.sample_signal(mesh, models + "bunny_mixtures.safetensors", steps=1).shape == (162, 1)
synthesized = s.geometric_texture(mesh, models + "spikes.safetensors", end_level=0)
assert s.geometric_texture_distance(synthesized, mesh, projections=8) > 0
assert s.gaussian_mixtures(mesh, 2).shape == (2, 162)
assert s.ensemble_layout([mesh, mesh]).GetNumberOfBlocks() == 2
assert s.ensemble_metrics(mesh[0][None], mesh[0][None], source=mesh)["mmd"] == 0
assert s.topology_report(mesh).valid
for name in s.__all__:
    if name not in {training}:
        getattr(s, name)
from surfacesynthesis.command_line import main
assert main(["geometric-texture-distance"]) == 2
"""
LOADED = """
libraries = {line.split("/")[-1].strip() for line in open("/proc/self/maps") if "/" in line}
print(*sorted(name for name in libraries if name.startswith(("libtorch", "libc10", "vtkSurfaceSynthesis"))))
"""


def libraries_after(code):
    """Which of LibTorch's libraries and of this package's modules a program has loaded."""
    paths = [os.path.dirname(os.path.abspath(__file__)), os.environ.get("PYTHONPATH", "")]
    done = subprocess.run(
        [sys.executable, "-c", code + LOADED, MODELS],
        capture_output=True,
        encoding="utf-8",
        check=False,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
        timeout=240,
    )
    assert done.returncode == 0, done
    return done.stdout.split()


def of_torch(libraries):
    return [name for name in libraries if name.startswith(("libtorch", "libc10"))]


def test_importing_the_package_loads_no_libtorch():
    loaded = libraries_after("import surfacesynthesis\ndir(surfacesynthesis)\n")
    assert "vtkSurfaceSynthesisPoissonNet.so" in loaded and of_torch(loaded) == []


def test_applying_models_loads_no_libtorch():
    loaded = libraries_after(APPLYING.replace("{training}", repr(TRAINING)))
    assert "vtkSurfaceSynthesisFlowMatching.so" in loaded and of_torch(loaded) == []


if "train_flow_matching" in surfacesynthesis.__all__:

    def test_training_is_loaded_on_first_use():
        """So the tests above would see LibTorch if it were loaded."""
        assert set(TRAINING) <= set(surfacesynthesis.__all__) and set(TRAINING) <= set(dir(surfacesynthesis))
        loaded = libraries_after("import surfacesynthesis\nassert surfacesynthesis.fit_levels\n")
        assert "vtkSurfaceSynthesisTraining.so" in loaded and of_torch(loaded)

else:

    @pytest.mark.parametrize("name", TRAINING)
    def test_training_is_absent(name):
        assert name not in surfacesynthesis.__all__ and name not in dir(surfacesynthesis)
        with pytest.raises(AttributeError, match=name):
            getattr(surfacesynthesis, name)

    def test_commands_of_trainings_are_absent():
        commands = build_parser().format_help()
        assert "poisson-net" in commands and " train " not in commands and " levels " not in commands
