#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Collects photographs from packages of Debian 12 and makes the dataset that field latents are trained on.

    python3 field_latent_images.py FOLDER [options]

writes

    FOLDER/packages/                  the packages, unpacked (apt-get download and dpkg-deb; nothing is installed)
    FOLDER/textures.safetensors       tiles of the images of TRAINING, and planar meshes: to train with
    FOLDER/test_images/NAME.png       the images of TEST, which no training sees: for compare_field_latents.py

About 190 MB are downloaded. Licences of the packages are in their files usr/share/doc/*/copyright, and listed in the
README beside this script.
"""

import argparse
import os
import subprocess
import sys

from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkIOImage import vtkPNGWriter

import surfacesynthesis
from surfacesynthesis.texture_datasets import image_array, reduced_image

#: The folder of the images in each package.
PACKAGES = {
    "lomiri-wallpapers-16.04": "usr/share/backgrounds",
    "lomiri-wallpapers-20.04": "usr/share/backgrounds",
    "mate-backgrounds": "usr/share/backgrounds/mate",
    "plasma-workspace-wallpapers": "usr/share/wallpapers",
    "python3-skimage": "usr/lib/python3/dist-packages/skimage/data",
}
_PLASMA = "contents/images"
TRAINING = {
    "lomiri-wallpapers-16.04": [
        "Bridge_by_Sander_Klootwijk.jpg",
        "Picture_0B_by_freespace.jpg",
        "Wine_by_Jakkub_Mede.jpg",
        "aitzgorri_by_Aitzol_Berasategi.jpg",
        "friends_by_Aitzol_Berasategi.jpg",
        "greentock_by_Peter_Nerlich.jpg",
        "life_by_Aitzol_Berasategi.jpg",
        "picosdeeuropa_by_Aitzol_Berasategi.jpg",
        "seeding_by_Clements_Engelhardt.jpg",
        "sunset_by_Aitzol_Berasategi.jpg",
    ],
    "lomiri-wallpapers-20.04": ["Infinite-Sea_by_Aury88.jpg", "Kleiber_by_Lukas_Baubkus.jpg"],
    "mate-backgrounds": [
        "abstract/Elephants.jpg",
        "nature/Blinds.jpg",
        "nature/Dune.jpg",
        "nature/FreshFlower.jpg",
        "nature/Garden.jpg",
        "nature/GreenMeadow.jpg",
        "nature/RainDrops.jpg",
        "nature/Storm.jpg",
        "nature/TwoWings.jpg",
        "nature/Wood.jpg",
        "nature/YellowFlower.jpg",
    ],
    "plasma-workspace-wallpapers": [
        f"Autumn/{_PLASMA}/2560x1600.jpg",
        f"BytheWater/{_PLASMA}/2560x1600.jpg",
        f"Canopee/{_PLASMA}/3840x2160.png",
        f"Cluster/{_PLASMA}/3840x2160.png",
        f"ColorfulCups/{_PLASMA}/2560x1600.jpg",
        f"EveningGlow/{_PLASMA}/2560x1600.jpg",
        f"FallenLeaf/{_PLASMA}/2560x1600.jpg",
        f"Flow/{_PLASMA}/5120x2880.jpg",
        f"Grey/{_PLASMA}/2560x1600.jpg",
        f"IceCold/{_PLASMA}/5120x2880.png",
        f"Path/{_PLASMA}/2560x1600.jpg",
        f"SafeLanding/{_PLASMA}/5120x2880.jpg",
        f"Volna/{_PLASMA}/5120x2880.jpg",
    ],
    "python3-skimage": [
        "astronaut.png",
        "brick.png",
        "camera.png",
        "coffee.png",
        "coins.png",
        "grass.png",
        "hubble_deep_field.jpg",
        "motorcycle_left.png",
        "retina.jpg",
        "rocket.jpg",
    ],
}
TEST = {
    "lomiri-wallpapers-16.04": ["Dragonfly_by_Bolly.jpg", "Picture_1A_by_freespace.jpg"],
    "mate-backgrounds": ["nature/LadyBird.jpg"],
    "plasma-workspace-wallpapers": [f"OneStandsOut/{_PLASMA}/2560x1600.jpg"],
    "python3-skimage": ["chelsea.png", "gravel.png", "ihc.png"],
}


def unpack(package, folder):
    """Downloads a package of Debian and unpacks it in a folder of its name; returns that folder."""
    content = os.path.join(folder, package)
    if not os.path.isdir(content):
        print(f"downloading {package}", file=sys.stderr, flush=True)
        before = set(os.listdir(folder))
        subprocess.run(["apt-get", "download", "-q", package], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        (file,) = set(os.listdir(folder)) - before
        subprocess.run(["dpkg-deb", "-x", file, content + ".part"], cwd=folder, check=True)
        os.remove(os.path.join(folder, file))
        os.rename(content + ".part", content)
    return content


def paths_of(images, folder):
    """The files of a table of images by package."""
    return [
        os.path.join(unpack(package, folder), PACKAGES[package], name) for package, names in images.items() for name in names
    ]


def short_name(path):
    """A name for an image: that of its file, or of its wallpaper where the file is named for its size."""
    parts = path.split(os.sep)
    name = parts[-4] if parts[-2] == "images" else parts[-1]
    return os.path.splitext(name)[0].split("_by_")[0].lower()


def write_png(path, image):
    """Writes an image uint8 [H, W, 3], top row first."""
    data = vtkImageData()
    data.SetDimensions(image.shape[1], image.shape[0], 1)
    data.GetPointData().SetScalars(numpy_to_vtk(image[::-1].reshape(-1, 3), deep=True))
    writer = vtkPNGWriter()
    writer.SetInputData(data)
    writer.SetFileName(path)
    writer.Write()


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", help="made when it is not there")
    parser.add_argument("--packages", help="folder of unpacked packages (default: packages in FOLDER)")
    parser.add_argument("--side", type=int, default=1024, help="largest shorter side of an image, pixels (default: 1024)")
    parser.add_argument("--tiles", type=int, default=6, help="largest number of tiles of an image (default: 6)")
    parser.add_argument("--meshes", type=int, default=64, help="default: 64")
    parser.add_argument("--mesh-points", type=int, default=2500, help="points of a mesh (default: 2500)")
    parser.add_argument("--seed", type=int, default=0, help="default: 0")
    options = parser.parse_args(arguments)
    packages = os.path.abspath(options.packages or os.path.join(options.folder, "packages"))
    tests = os.path.join(options.folder, "test_images")
    for folder in (options.folder, packages, tests):
        os.makedirs(folder, exist_ok=True)
    for path in paths_of(TEST, packages):
        write_png(os.path.join(tests, short_name(path) + ".png"), reduced_image(image_array(path), options.side))
    made = surfacesynthesis.texture_dataset(
        os.path.join(options.folder, "textures.safetensors"),
        paths_of(TRAINING, packages),
        side=options.side,
        tiles=options.tiles,
        meshes=options.meshes,
        mesh_points=options.mesh_points,
        seed=options.seed,
    )
    print(f"{len(made.images)} tiles of images, {len(made.meshes)} meshes, {len(os.listdir(tests))} test images")


if __name__ == "__main__":
    main()
