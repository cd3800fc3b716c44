# SPDX-License-Identifier: BSD-3-Clause
"""Data, training and comparison of field latents in small: ``test_compare_field_latents.py PROGRAM FOLDER``. Run by CTest.

PROGRAM is surfacesynthesis-train.
"""

import os
import shutil
import subprocess
import sys

import compare_field_latents as compare
import field_latent_images
import numpy as np
from PIL import Image
from test_training import icosphere

import surfacesynthesis

SIZES = ("--channels", "8", "--encoder-layers", "1", "--heads", "2", "--samples-per-ring", "8", "--decoder-width", "16")


def make_packages(folder):
    """Small images in place of those of the packages."""
    random = np.random.default_rng(1)
    for images in (field_latent_images.TRAINING, field_latent_images.TEST):
        for package, names in images.items():
            for name in names:
                path = os.path.join(folder, package, field_latent_images.PACKAGES[package], name)
                os.makedirs(os.path.dirname(path), exist_ok=True)
                Image.fromarray(random.integers(0, 256, (24, 32, 3), dtype=np.uint8)).save(path)


def check_images(folder):
    """The script writes the dataset and the test images; no image is in both."""
    packages = os.path.join(folder, "packages")
    make_packages(packages)
    field_latent_images.main([folder, "--meshes", "2", "--mesh-points", "64", "--tiles", "1"])
    made = surfacesynthesis.read_texture_dataset(os.path.join(folder, "textures.safetensors"))
    assert len(made.images) == sum(map(len, field_latent_images.TRAINING.values())) and len(made.meshes) == 2
    assert {image.shape for image in made.images} == {(24, 32, 3)}
    names = [field_latent_images.short_name(os.path.join("a", "b", "c", name)) + ".png"
             for names in field_latent_images.TEST.values() for name in names]  # fmt: skip
    tests = os.path.join(folder, "test_images")
    assert sorted(os.listdir(tests)) == sorted(names) and {f"{name}.png" for name in compare.PAINTED.values()} <= set(names)
    training = {image.tobytes() for image in made.images}
    pngs = [path for path in (os.path.join(tests, name) for name in names)]
    assert not training & {np.asarray(Image.open(path)).tobytes() for path in pngs}
    for package, images in field_latent_images.TEST.items():
        assert not set(images) & set(field_latent_images.TRAINING.get(package, ()))


def check_texels():
    """Places of texels, colors there, and the nearest places of another surface."""
    coordinates = np.array([[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], [[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]])
    places = compare.rasterized(coordinates, 8, 6)
    assert (places.triangles >= 0).all()
    at = np.einsum("qk,qkx->qx", places.weights, coordinates[places.triangles]).reshape(6, 8, 2)
    assert np.allclose(at[:, :, 0], (np.arange(8) + 0.5) / 8) and np.allclose(at[::-1, 0, 1], (np.arange(6) + 0.5) / 6)
    image = np.random.default_rng(2).integers(0, 256, (6, 8, 3), dtype=np.uint8)
    assert np.allclose(compare.sampled(image, at[..., 0].ravel(), at[..., 1].ravel()), image.reshape(-1, 3))
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])
    closest = compare.Closest(points, np.array([[0, 1, 2], [1, 3, 2]]))(np.array([[0.2, 0.3, 0.4], [-1, -1, 0], [0.9, 0.9, 9]]))
    assert list(closest.triangles) == [0, 0, 1]
    assert np.allclose(closest.weights, [[0.5, 0.2, 0.3], [1, 0, 0], [0.1, 0.8, 0.1]])


def check_measures():
    """The measures of images whose errors are known."""
    wanted = np.random.default_rng(3).integers(20, 200, (32, 32, 3), dtype=np.uint8)
    known = np.ones((32, 32), bool)
    known[:8] = False
    assert abs(compare.psnr(wanted + 10, wanted, known) - 10 * np.log10(255**2 / 100)) < 1e-9
    assert compare.dssim(wanted, wanted, known) < 1e-12
    far = compare.dssim(255 - wanted, wanted, known)
    assert 0.5 < far <= 1 and compare.dssim(wanted + 1, wanted, known) < 1e-3
    crops, titles = compare.crops_of({"original": wanted, "brighter": wanted + 10}, known)
    assert titles == ["original", "brighter, 28.1 dB"]
    assert (crops[1][:8] == 255).all() and (crops[1][8:] == wanted[8:] + 10).all()
    changed = wanted.copy()
    changed[:8] = 0  # outside the mask
    assert compare.dssim(changed, wanted, known) < 1e-12 and compare.psnr(changed, wanted, known) > 100


def smooth_ball():
    """A ball with a smooth texture in an atlas of its own."""
    points, triangles = icosphere(3)
    compare.ATLAS = 128
    return compare.with_atlas(points, triangles, lambda places, _: 127 + 100 * places)


def check_vertex_colors(surface):
    """Linear colors are met by interpolation; fitted ones are at least as near as those at the points."""
    texels = compare.rasterized(surface.coordinates, 128, 128)
    known = texels.triangles >= 0
    found = compare.Places(texels.triangles[known], texels.weights[known])
    there, fitted = compare.by_vertex_colors(surface, icosphere(3), found, known)
    mask = known.reshape(128, 128)
    assert compare.psnr(there, surface.image, mask) > 40
    assert compare.psnr(fitted, surface.image, mask) >= compare.psnr(there, surface.image, mask)
    carried = compare.retextured(*icosphere(2), surface)
    at = compare.Places(np.arange(len(carried.triangles)), np.full((len(carried.triangles), 3), 1 / 3))
    near = compare.Closest(surface.points, surface.triangles)(compare.positions(carried.points, carried.triangles, at))
    assert np.abs(compare.colors_at(carried, at) - compare.colors_at(surface, near)).max() < 6


def trained(program, folder, coordinates):
    """A model after two iterations."""
    path = os.path.join(folder, coordinates + ".safetensors")
    dataset = os.path.join(folder, "textures.safetensors")
    options = ("--coordinates", coordinates, "--iterations", "2", "--batch", "3", "--device", "cpu", *SIZES)
    subprocess.run([program, "field-latents", dataset, path, *options], check=True, stdout=subprocess.DEVNULL)
    return path


def check_comparison(program, folder, surface):
    """A row for each method, with numbers in their ranges; table and picture are written."""
    models = dict(zip(compare.METHODS, (trained(program, folder, name) for name in ("logarithmic", "barycentric"))))
    rows, parts = compare.compared("ball", surface, [300], models)
    assert [row["method"] for row in rows] == list(compare.METHODS)
    assert all(3 < row["psnr"] < 60 and 0 <= row["dssim"] <= 1 for row in rows)
    assert rows[2]["psnr"] > max(row["psnr"] for row in rows[:2])  # nothing is learned in two iterations
    compare.write_rows(rows, os.path.join(folder, "metrics.csv"))
    compare.print_table(rows, [300])
    compare.draw([("ball", *part) for part in parts], os.path.join(folder, "crops.png"))
    assert os.path.getsize(os.path.join(folder, "crops.png")) > 1000


def main(program, folder):
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    check_images(folder)
    check_texels()
    check_measures()
    surface = smooth_ball()
    check_vertex_colors(surface)
    check_comparison(program, folder, surface)


if __name__ == "__main__":
    main(*sys.argv[1:])
