# SPDX-License-Identifier: BSD-3-Clause
"""Textured surfaces, trainings and the comparison of samples in small: ``test_compare_texture_samples.py FOLDER``. Run by
CTest."""

import csv
import os
import shutil
import sys

import compare_texture_samples as compare
import make_textured_surfaces as make
import numpy as np

import surfacesynthesis
from surfacesynthesis.field_latents import image_of_array
from surfacesynthesis.textured_files import write_image

LATENTS = {"channels": 8, "encoder_layers": 1, "heads": 2, "samples_per_ring": 8, "decoder_width": 16, "latent_dimension": 2}
NETWORK = {"channels": 4, "coarse_channels": 4, "coarse_blocks": 1, "output_blocks": 1}


def check_statistics():
    """Distances of equal sets are 0, and those of moved sets the mean projection of the shift."""
    random = np.random.default_rng(0)
    first = random.normal(size=(400, 12))
    assert compare.sliced_wasserstein(first, first[::-1]) < 1e-12
    shift = np.zeros(12)
    shift[3] = 2.0
    found = compare.sliced_wasserstein(first, first + shift, projections=4000)
    assert abs(found - 2.0 * np.sqrt(2.0 / (12.0 * np.pi))) < 0.03, found  # mean of |u_3| over the sphere, times 2
    assert compare.closest(first, first) < 1e-6
    assert abs(compare.closest(first + 0.01, first) - 0.01) < 1e-6
    views = np.full((1, 40, 40, 3), np.nan)
    views[0, 10:30, 10:30] = 0.5
    assert (compare.patches(views, 8, 20, 0) == 0.5).all()
    views = random.uniform(size=(1, 120, 120, 3))
    assert abs(compare.layout(views, 2.0 * views + 1.0) - 1.0) < 1e-9
    assert abs(compare.layout(views, 1.0 - views) + 1.0) < 1e-9
    assert abs(compare.layout(views, random.uniform(size=views.shape))) < 0.5


def check_comparison(folder):
    """All scripts run, and the floor is the lowest distance."""
    make.CELLS, make.TEXELS = 12, 64
    make.PARTS = dict.fromkeys(make.PARTS, (0, 0, 64))
    random = np.random.default_rng(1)
    image = np.kron(random.integers(0, 256, (16, 16, 3)), np.ones((4, 4, 1))).astype(np.uint8)
    write_image(image_of_array(image), os.path.join(folder, "ihc.png"))
    sys.argv = ["make_textured_surfaces.py", folder, folder]
    make.main()
    paths = {name: os.path.join(folder, f"{name}.safetensors") for name in ("latents", "model")}
    images = [os.path.join(folder, "coat.png")]
    surfacesynthesis.train_field_latents(images, model=paths["latents"], iterations=2, batch=6, meshes=1, mesh_points=64, **LATENTS)
    mesh = surfacesynthesis.read_mesh(os.path.join(folder, "coat.vtp"))
    options = {"label": "Label", "points": 100, "triangulations": 1, "iterations": 1, "batch": 1, **NETWORK}
    surfacesynthesis.train_latent_diffusion(
        mesh, compare.image_array(images[0]), model=paths["model"], autoencoder=paths["latents"], **options
    )
    output = os.path.join(folder, "comparison")
    compare.main([os.path.join(folder, "coat.vtp"), images[0], output, "--model", paths["model"], "--autoencoder",
                  paths["latents"], "--label", "Label", "--samples", "2", "--steps", "2", "--resolution", "64",
                  "--patches", "200"])  # fmt: skip
    with open(f"{output}.csv", encoding="utf-8") as file:
        rows = {row["texture"]: row for row in csv.DictReader(file)}
    assert list(rows) == ["original", "triangulations", "reconstruction", "sample", "shuffled", "noise"]
    for column in ("swd_8", "swd_16", "swd_32"):
        assert float(rows["triangulations"][column]) < float(rows["reconstruction"][column])
        assert float(rows["original"][column]) < min(float(rows[name][column]) for name in ("shuffled", "noise", "sample"))
    assert float(rows["sample"]["difference"]) > 0.0 and os.path.exists(f"{output}.png")


if __name__ == "__main__":
    shutil.rmtree(sys.argv[1], ignore_errors=True)
    os.makedirs(sys.argv[1])
    check_statistics()
    check_comparison(sys.argv[1])
