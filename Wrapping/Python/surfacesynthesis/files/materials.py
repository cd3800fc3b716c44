# SPDX-License-Identifier: BSD-3-Clause
"""Textures that OBJ and PLY files name: MTL files with map_Kd, and comments "TextureFile"."""

import os
import warnings

from ..errors import FormatError, SurfaceSynthesisWarning

#: Options of map_Kd, with the largest number of values after each.
_OPTIONS = {
    "-blendu": 1, "-blendv": 1, "-boost": 1, "-mm": 2, "-o": 3, "-s": 3, "-t": 3, "-texres": 1, "-clamp": 1, "-bm": 1,
    "-imfchan": 1, "-type": 1, "-cc": 1,
}  # fmt: skip
#: Options with an optional second and third number, and those that would move the texture.
_NUMBERS = ("-o", "-s", "-t")
_MOVING = {"-o": 0.0, "-s": 1.0}


def texture_of_obj(path, any_folder=False):
    """The path of the only texture of the faces in an OBJ file; None without one."""
    libraries, materials, current, faces, bare = [], {}, None, 0, 0
    for row in _lines(path):
        keyword, _, rest = row.partition(" ")
        if keyword == "mtllib":
            libraries.append(rest.strip())
        elif keyword == "usemtl":
            current = rest.strip()
        elif keyword == "f":
            materials[current] = None
            faces += 1
            bare += "/" not in rest or "//" in rest
    textures = {}
    for library in libraries:
        try:
            name = beside(path, library, any_folder)
            textures.update({key: (name, texture) for key, texture in _textures_of_mtl(name).items()})
        except FileNotFoundError:
            text = f"{path}: the material file {library[:80]} is missing; the surface is read without its texture"
            warnings.warn(text, SurfaceSynthesisWarning, stacklevel=4)
    found = {textures.get(material) for material in materials}
    if len({None if one is None else one[1] for one in found}) > 1:
        raise FormatError(
            f"{path}: the faces have {len(materials)} materials with different textures; one texture for all is needed. "
            "Save each material as a file of its own, or bake them into one texture"
        )
    entry = next((one for one in found if one is not None and one[1] is not None), None)
    if entry is not None and 0 < bare < faces:
        raise FormatError(f"{path}: {bare} of {faces} faces have no texture coordinates, and the material has a texture")
    return None if entry is None else beside(entry[0], entry[1], any_folder, path)


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


def _textures_of_mtl(path):
    """The texture, or None, of each material in an MTL file."""
    textures, current = {}, None
    for row in _lines(path):
        keyword, _, rest = row.partition(" ")
        if keyword == "newmtl":
            current = rest.strip()
            textures[current] = None
        elif keyword.lower() == "map_kd" and current is not None:
            textures[current] = _without_options(path, rest.split())
    return textures


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
