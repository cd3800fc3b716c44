# SPDX-License-Identifier: BSD-3-Clause
"""Files of a surface with its texture: OBJ with MTL and an image, glTF, PLY with a comment; and images by themselves."""

import contextlib
import os
import re
import shutil

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkFiltersCore import vtkAppendPolyData

from . import files
from .errors import FormatError
from .files.gltf import read_textured_gltf, write_gltf
from .files.images import image_of, png_of, read_image
from .files.materials import texture_of_ply, textures_of_obj
from .files.obj import write_obj
from .files.ply import write_ply
from .files.polygons import from_polydata, named_by_role, to_polydata
from .files.tiles import joined_textures

#: Formats of a surface with its texture.
TEXTURED = (".obj", ".gltf", ".glb", ".ply")


def read_textured_mesh(path, any_folder=False):
    """Reads a surface and its texture.

    Points with several texture coordinates are doubled. The texture is that of the MTL file of an OBJ file (``map_Kd``), the
    base color texture of glTF, or the file in the comment ``TextureFile`` of PLY: PNG, JPEG, BMP or TGA (the latter two
    uncompressed). The parts of a glTF scene become one surface, with the arrays
    that all have. Textures of several materials become tiles of one image, and their texture coordinates are mapped to
    them; a material without a texture becomes a tile of its color. Otherwise colors of materials are not applied.

    Parameters
    ----------
    path : path
        .obj, .gltf, .glb or .ply; other formats of read_mesh() hold no texture, but may hold texture coordinates.
    any_folder : bool
        Lets OBJ, MTL and PLY files name files anywhere. Default False: beside the file or below its folder only.

    Returns
    -------
    pair of vtkPolyData, and vtkImageData or None
        The surface, with the active texture coordinates "TCoords" if the file has any; the texture with the scalars
        "Texture", as they are in the file, row 0 at v = 0.

    Raises
    ------
    FormatError
        The surface or the image does not follow its format; several textures of which one is repeated (texture coordinates
        outside [0, 1]), or of a PLY file; a texture without texture coordinates; a file elsewhere; no surface.
    ValueError, OSError
        The extension is not known, a file is missing or cannot be read.

    Warns
    -----
    SurfaceSynthesisWarning
        An MTL file is missing.
    """
    path = os.fspath(path)
    kind = files.extension(path)
    image = None
    if kind in (".gltf", ".glb"):
        files.require_file(path)
        meshes, textures = read_textured_gltf(path)
        _require_coordinates(path, meshes, textures)
        mesh = _joined(path, meshes, textures is not None)
        if textures is not None:
            counts = [len(part.offsets) - 1 for _, part in meshes]
            different = list(dict.fromkeys(textures))
            numbers = np.repeat([different.index(texture) for texture in textures], counts)
            mesh, image = _with_textures(path, mesh, numbers, different, lambda data: image_of(path, data))
    else:
        mesh = files.read_mesh(path, seams="split")
        textures = textures_of_obj(path, any_folder) if kind == ".obj" else None
        if textures is not None and mesh.GetPointData().GetTCoords() is not None:
            mesh, image = _with_textures(path, mesh, *textures, read_image)
        elif textures is not None:
            raise _no_coordinates(path)
        elif kind == ".ply":
            name = texture_of_ply(path, any_folder)
            image = None if name is None else read_image(name)
    if not isinstance(mesh, vtkPolyData):
        raise FormatError(f"{path}: a surface is needed, and not a {mesh.GetClassName()}")
    if image is not None and mesh.GetPointData().GetTCoords() is None:
        raise _no_coordinates(path)
    return mesh, image


def _no_coordinates(path):
    return FormatError(f"{path}: the surface has a texture but no texture coordinates")


def _require_coordinates(path, meshes, textures):
    """Raises FormatError for a part of a scene with a picture and without texture coordinates."""
    for (_, mesh), texture in zip(meshes, textures or ()):
        if isinstance(texture, bytes) and "TCoords" not in mesh.arrays:
            raise _no_coordinates(path)


def _with_textures(path, mesh, numbers, textures, read):
    """A surface and its only texture; of several, tiles of one image. ``numbers`` [F] are those of the polygons."""
    textures = [texture if isinstance(texture, tuple) else read(texture) for texture in textures]
    used = np.unique(numbers)
    if len(used) == 1:
        image = textures[used[0]]
        return mesh, None if isinstance(image, tuple) else image
    return joined_textures(path, mesh, numbers, textures)


def _joined(path, meshes, textured):
    """One vtkPolyData of pairs of a name and a PolygonMesh, with the arrays that all have. ``textured`` surfaces keep
    texture coordinates that only some parts have; those of others are 0."""
    if not meshes:
        raise FormatError(f"{path}: the scene has no triangles")
    if textured:
        parts = [(name, {"TCoords": np.zeros((len(mesh.points), 2), dtype=np.float32), **mesh.arrays}) for name, mesh in meshes]
        meshes = [(name, mesh._replace(arrays=arrays)) for (_, mesh), (name, arrays) in zip(meshes, parts)]
    if len(meshes) == 1:
        return to_polydata(meshes[0][1])
    append = vtkAppendPolyData()
    for _, mesh in meshes:
        append.AddInputData(to_polydata(mesh))
    append.Update()
    result = vtkPolyData()
    result.ShallowCopy(append.GetOutput())
    data = result.GetPointData()
    if data.HasArray("TCoords"):
        data.SetActiveTCoords("TCoords")
    if data.HasArray("Normals"):
        data.SetActiveNormals("Normals")
    return result


def write_textured_mesh(mesh, image, path):
    """Writes a surface and its texture.

    OBJ gets an MTL file and a PNG file of the same name beside it, PLY a PNG file; glTF holds the image. The files appear
    under their names when all are complete; the surface comes last. Files of these names are replaced.

    Parameters
    ----------
    mesh : vtkPolyData
        A surface with active texture coordinates, which are kept as they are; its points are doubled at seams, as
        texture_atlas() makes them.
    image : vtkImageData or None
        The texture: 1 to 4 components, of which 8 bits are kept; integers are scaled by their range, floating-point
        numbers from 0 to 1. Row 0 is at v = 0. None writes the texture coordinates only.
    path : path
        .obj, .gltf, .glb or .ply. Point arrays are kept as by write_mesh().

    Raises
    ------
    TypeError, ValueError
        The mesh is no vtkPolyData or has no texture coordinates, the image is no picture, the extension has no room for a
        texture.
    OSError
        A file cannot be written.
    """
    path = os.path.realpath(path)
    check_textured(mesh, path)
    png = None if image is None else png_of(image)
    stem, kind = os.path.splitext(os.path.basename(path))
    name = re.sub(r"[^\w.-]", "_", stem)  # readers divide the lines that name files at spaces
    arrays = from_polydata(named_by_role(mesh), triangles=kind.lower() in (".gltf", ".glb"))
    picture = None if png is None else f"{name}.png"
    contents = {} if png is None else {picture: lambda file: file.write(png)}
    if kind.lower() == ".obj" and png is not None:
        material = f"newmtl texture\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd {picture}\n"
        contents[f"{name}.mtl"] = lambda file: file.write(material.encode())
        contents[stem + kind] = lambda file: write_obj(arrays, file, f"{name}.mtl")
    elif kind.lower() == ".obj":
        contents[stem + kind] = lambda file: write_obj(arrays, file)
    elif kind.lower() == ".ply":
        contents[stem + kind] = lambda file: write_ply(arrays, file, picture)
    else:
        contents = {stem + kind: lambda file: write_gltf([("Mesh 0", arrays)], file, kind.lower() == ".glb", png)}
    _write_together(os.path.dirname(path), contents)


def check_textured(mesh, path):
    """Raises TypeError, ValueError or OSError when ``mesh`` cannot be written to ``path`` with a texture."""
    if files.extension(path) not in TEXTURED:
        raise ValueError(f"{os.fspath(path)}: textures are written to {', '.join(TEXTURED)}")
    if not isinstance(mesh, vtkPolyData):
        raise TypeError(f"mesh must be a vtkPolyData, not {type(mesh).__name__}")
    coordinates = mesh.GetPointData().GetTCoords()
    if coordinates is None or coordinates.GetNumberOfComponents() != 2:
        raise ValueError("mesh has no active texture coordinates of two components; texture_atlas() makes some")
    files.check_writable(mesh, path)


def write_image(image, path):
    """Writes a vtkImageData as a PNG file of 8 bits: see write_textured_mesh(). Raises TypeError, ValueError, OSError."""
    path = os.path.realpath(path)
    if os.path.splitext(path)[1].lower() != ".png":
        raise ValueError(f"{path}: images are written to .png")
    png = png_of(image)
    _write_together(os.path.dirname(path), {os.path.basename(path): lambda file: file.write(png)})


def _write_together(folder, contents):
    """Writes files into ``folder``, which maps names to functions that write to a binary file object; none appears unless
    all could be written."""
    temporary = None
    try:
        temporary = files.temporary_folder(folder)
        for name, write in contents.items():
            with open(os.path.join(temporary, name), "wb") as file:
                write(file)
                file.flush()
                os.fsync(file.fileno())
        for name in contents:
            os.replace(os.path.join(temporary, name), os.path.join(folder, name))
    except OSError as error:  # which knows no file, or the temporary one
        raise OSError(error.errno, error.strerror, os.path.join(folder, list(contents)[-1])) from None
    finally:
        if temporary is not None:
            with contextlib.suppress(OSError):
                shutil.rmtree(temporary)
