# SPDX-License-Identifier: BSD-3-Clause
"""Textures that OBJ and PLY files name: MTL files with map_Kd, and comments "TextureFile"."""

import os
import warnings
from typing import NamedTuple, Optional

import numpy as np

from ..errors import FormatError, SurfaceSynthesisWarning

#: Options of map_Kd, with the largest number of values after each.
_OPTIONS = {
    "-blendu": 1, "-blendv": 1, "-boost": 1, "-mm": 2, "-o": 3, "-s": 3, "-t": 3, "-texres": 1, "-clamp": 1, "-bm": 1,
    "-imfchan": 1, "-type": 1, "-cc": 1,
}  # fmt: skip
#: Options with an optional second and third number, and those that would move the texture.
_NUMBERS = ("-o", "-s", "-t")
_MOVING = {"-o": 0.0, "-s": 1.0}
#: Color of faces without a material, and of materials that name none.
_WHITE = (1.0, 1.0, 1.0)


class _Material(NamedTuple):
    """``library``, path of the MTL file; ``texture``, name of an image or None; ``color``, three numbers from 0 to 1."""

    library: Optional[str]
    texture: Optional[str]
    color: tuple


def textures_of_obj(path, any_folder=False):
    """The texture of each face in an OBJ file: numbers [F], and a list of paths of images, and colors (three numbers from 0
    to 1) of materials without one. None when no material has an image."""
    libraries, names, faces, current = [], {}, [], None
    bare = []
    for row in _lines(path):
        keyword, _, rest = row.partition(" ")
        if keyword == "mtllib":
            libraries.append(rest.strip())
        elif keyword == "usemtl":
            current = rest.strip()
        elif keyword == "f":
            faces.append(names.setdefault(current, len(names)))
            bare.append("/" not in rest or "//" in rest)
    materials = _materials(path, libraries, any_folder)
    found = [materials.get(name, _Material(None, None, _WHITE)) for name in names]
    paths = [None if one.texture is None else beside(one.library, one.texture, any_folder, path) for one in found]
    if not any(paths):
        return None
    faces = np.array(faces, dtype=np.int64)
    missing = np.count_nonzero(np.array(bare) & np.array([one is not None for one in paths])[faces])
    if 0 < missing and not all(bare):
        raise FormatError(f"{path}: {missing} of {len(faces)} faces have no texture coordinates, and the material has a texture")
    textures = [one.color if image is None else image for one, image in zip(found, paths)]
    numbers = [textures.index(texture) for texture in textures]  # materials with the same texture share it
    return np.array(numbers)[faces], textures


def _materials(path, libraries, any_folder):
    """The _Material of each name in the MTL files that an OBJ file names; a line may name several."""
    materials = {}
    for line in libraries:
        whole = os.path.isfile(os.path.join(os.path.dirname(os.path.abspath(path)), line.strip('"')))
        for library in [line] if whole or '"' in line else line.split() or [line]:
            try:
                materials.update(_materials_of_mtl(beside(path, library, any_folder)))
            except FileNotFoundError:
                text = f"{path}: the material file {library[:80]} is missing; the surface is read without its texture"
                warnings.warn(text, SurfaceSynthesisWarning, stacklevel=5)
    return materials


def texture_of_ply(path, any_folder=False):
    """The path of the only texture that the header of a PLY file names; None without one."""
    names = []
    with open(path, "rb") as file:
        for row in file.read(1 << 20).partition(b"end_header")[0].splitlines():
            words = row.decode("utf-8", "replace").strip().split(None, 2)
            if len(words) == 3 and words[0] == "comment" and words[1].lower() == "texturefile":
                names.append(words[2])
    if len(set(names)) > 1:
        raise FormatError(f"{path}: the surface has {len(set(names))} textures; one texture for all is needed")
    return beside(path, names[0], any_folder) if names else None


def _lines(path):
    with open(path, "rb") as file:
        data = file.read()
    if b"\0" in data:
        raise FormatError(f"{path}: this is a binary file, and no text")
    for row in data.decode("utf-8", "replace").replace("\t", " ").splitlines():
        row = row.strip()
        if row and not row.startswith("#"):
            yield row


def _materials_of_mtl(path):
    """The _Material of each name in an MTL file."""
    materials, current = {}, None
    for row in _lines(path):
        keyword, _, rest = row.partition(" ")
        if keyword == "newmtl":
            current = rest.strip()
            materials[current] = _Material(path, None, _WHITE)
        elif keyword.lower() == "map_kd" and current is not None:
            materials[current] = materials[current]._replace(texture=_without_options(path, rest.split()))
        elif keyword == "Kd" and current is not None:
            materials[current] = materials[current]._replace(color=_color(rest.split()))
    return materials


def _color(words):
    """Three numbers from 0 to 1; white for a color in another form."""
    if not words or not all(_is_number(word) for word in words[:3]):
        return _WHITE
    color = tuple(min(max(float(word), 0.0), 1.0) for word in (words[:3] if len(words) >= 3 else 3 * words[:1]))
    return color if all(part == part for part in color) else _WHITE


def _without_options(path, words):
    """The file name behind the options of a map; None without one."""
    place = 0
    while place < len(words) and words[place] in _OPTIONS:
        option, place = words[place], place + 1
        for number in range(_OPTIONS[option]):
            if option in _NUMBERS and number and not (place < len(words) and _is_number(words[place])):
                break
            value = words[place] if place < len(words) else ""
            if option in _MOVING and _is_number(value) and float(value) != _MOVING[option]:
                raise FormatError(f"{path}: the option {option} of map_Kd moves the texture; this is not known")
            place += 1
    return " ".join(words[place:]) or None


def _is_number(word):
    try:
        float(word)
    except ValueError:
        return False
    return True


def beside(path, name, any_folder=False, origin=None):
    """The path of the file ``name`` that a file names: one beside it or below its folder, unless ``any_folder``. Raises
    FormatError, FileNotFoundError."""
    origin = path if origin is None else origin
    folder = os.path.realpath(os.path.dirname(os.path.abspath(origin)))
    name = name.strip('"').replace("\\", "/")
    if not name or "\0" in name:
        raise FormatError(f"{path}: the name of a file is empty or holds a zero byte")
    wanted = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(path)), name))
    if not any_folder and os.path.commonpath([folder, wanted]) != folder:
        raise FormatError(
            f"{path}: the file {name[:80]} lies outside of the folder of {os.path.basename(origin)}; move it there, or read "
            "with any_folder=True"
        )
    if not os.path.exists(wanted):
        raise FileNotFoundError(f"{path}: the file {name[:80]} is missing")
    if not os.path.isfile(wanted):
        raise FormatError(f"{path}: {name[:80]} is no regular file")
    return wanted
