# SPDX-License-Identifier: BSD-3-Clause
"""Textures as latent vector fields: functions around vtkFieldLatentEncoder and vtkFieldLatentDecoder."""

import collections
import os
import warnings

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPolyData

from .arguments import array_name, choice, integer, progress_callback
from .datasets import SURFACES, as_type_of
from .errors import SurfaceSynthesisWarning
from .pipeline import apply_filter
from .vtkSurfaceSynthesisFieldLatents import vtkFieldLatentDecoder, vtkFieldLatentEncoder

#: Continuations of a texture image outside [0, 1] x [0, 1], by the name that ``texture_wrap`` takes.
TEXTURE_WRAPS = {
    "automatic": vtkFieldLatentEncoder.AUTOMATIC,
    "repeat": vtkFieldLatentEncoder.REPEAT,
    "clamp": vtkFieldLatentEncoder.CLAMP,
}

#: The result of decode_texture(): a surface with colors at its points, and its texture image.
DecodedTexture = collections.namedtuple("DecodedTexture", "mesh image")

_LEAST_RESOLUTION, _MOST_RESOLUTION = 16, 16384


def encode_texture(
    mesh,
    image=None,
    model="field_latents",
    color=None,
    texture_wrap="automatic",
    samples_per_ring=None,
    latent_name="FieldLatent",
    progress=None,
):
    """Encodes the texture of a surface as field latents: tangent vectors at its points.

    Parameters
    ----------
    mesh : vtkPolyData or composite dataset (vtkDataObjectTree)
        Triangles, polygons or strips, float or double points, open or closed. Points with the same coordinates are one
        vertex: latents have no seam. The mesh must have finite points, no degenerate triangle and, once points are joined,
        manifold edges and points and consistent winding. A composite dataset is processed block by block. With an image,
        it needs active texture coordinates at its points. The mesh is never modified.
    image : vtkImageData or array [H, W] or [H, W, C], optional
        The texture: 1 component (gray), 2 (gray and alpha), 3 (RGB) or 4 (RGBA); integers from 0 to the largest number of
        their type, floating-point numbers from 0 to 1. Alpha is left out. Row 0 of a vtkImageData is at v = 0; row 0 of an
        array is the top row, as programs and libraries for images have it, at v = 1. Default: the colors of the points.
    model : path or str
        The model file, or the name of an installed model. Default "field_latents", the installed one.
    color : str, optional
        Name of the point array of colors that is encoded when there is no image. Default: the active point scalars.
    texture_wrap : str
        The continuation of the image outside [0, 1] x [0, 1]: "automatic", "repeat" for texture coordinates outside
        [0, 1] and else "clamp"; "repeat", periodic; "clamp", the outermost texels. Default "automatic".
    samples_per_ring : int, optional
        Number of samples in the one-ring of each vertex, 1 to 4096. Default: the number of the training.
    latent_name : str
        The first part of the names of the arrays. Default "FieldLatent".
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the work stops.

    Returns
    -------
    dataset of the type of ``mesh``
        The mesh with float32 point arrays: for each of the d tangent vectors of the model "FieldLatent_0", ..., 3
        components, in world axes; "FieldLatentDeviation", d components, the standard deviations; "FieldLatentRadius", the
        radius of the one-ring, world units. All are 0 at points that no polygon or strip uses.

    Raises
    ------
    SurfaceSynthesisError
        The text names the defect of the model file, the texture or the mesh, the first cell or point, and the filter that
        repairs it; for a composite dataset it holds a line for each bad block.
    Cancelled
        ``progress`` returned False.
    ValueError, TypeError
        An argument has a value out of its range or is of a wrong type.
    """
    require_surface("mesh", mesh, SURFACES, "a vtkPolyData or a composite dataset")
    algorithm = configured_encoder(model, color, texture_wrap, samples_per_ring, latent_name)
    if image is not None:
        give_second(algorithm, image_of(image))
    output, remarks = apply_filter(algorithm, mesh, progress_callback(progress))
    _warn(remarks)
    return as_type_of(mesh, output)


def decode_texture(
    mesh,
    model="field_latents",
    target=None,
    resolution=1024,
    gutter_width=8,
    latent_name="FieldLatent",
    name="Texture",
    memory_limit=None,
    progress=None,
):
    """Decodes field latents of a surface to a texture image and to colors of points.

    Parameters
    ----------
    mesh : vtkPolyData or composite dataset (vtkDataObjectTree)
        The surface with the arrays of encode_texture(), which may have been interpolated from another triangulation. A
        composite dataset is processed block by block. The mesh is never modified.
    model : path or str
        The model file, or the name of an installed model; the one that has made the latents. Default "field_latents", the
        installed one.
    target : vtkPolyData, optional
        The surface on which the texture is laid, each place with the color of the nearest place of ``mesh``. It needs
        active texture coordinates at its points, within [0, 1]. Default: ``mesh`` itself.
    resolution : int or pair of ints
        Width and height of the image, texels, 16 to 16384 each. Default 1024.
    gutter_width : int
        Distance from the charts up to which texels outside are filled, texels, 0 to 16384, or -1 for the whole image.
        Default 8.
    latent_name : str
        The first part of the names of the arrays with the latents. Default "FieldLatent".
    name : str
        Name of the colors of points and of the scalars of the image. Default "Texture".
    memory_limit : int, optional
        Memory limit of the image, MiB, at least 1. Default: three quarters of the memory of the machine.
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the work stops.

    Returns
    -------
    DecodedTexture (mesh, image)
        The target, or the mesh, with the point array ``name``, unsigned char RGB, as active scalars; and a
        vtkImageData with scalars of that name, row 0 at v = 0. For a composite dataset two composite datasets.

    Raises
    ------
    SurfaceSynthesisError
        The text names the defect of the model file, the latents, the texture coordinates or the mesh; for a composite
        dataset it holds a line for each bad block.
    Cancelled
        ``progress`` returned False.
    ValueError, TypeError
        An argument has a value out of its range or is of a wrong type.
    """
    require_surface("mesh", mesh, SURFACES, "a vtkPolyData or a composite dataset")
    algorithm = configured_decoder(model, resolution, gutter_width, latent_name, name, memory_limit)
    if target is not None:
        require_surface("target", target, (vtkPolyData,), "a vtkPolyData")
        give_second(algorithm, target)
    output, remarks = apply_filter(algorithm, mesh, progress_callback(progress))
    _warn(remarks)
    images = algorithm.GetOutputDataObject(1)
    image = images.NewInstance()
    image.ShallowCopy(images)
    return DecodedTexture(as_type_of(mesh if target is None else target, output), image)


def configured_encoder(
    model="field_latents", color=None, texture_wrap="automatic", samples_per_ring=None, latent_name="FieldLatent"
):
    """A vtkFieldLatentEncoder with the parameters of encode_texture(), which raises TypeError and ValueError."""
    algorithm = vtkFieldLatentEncoder()
    algorithm.SetModelFileName(_path(model))
    if color is not None:
        algorithm.SetColorArrayName(array_name("color", color))
    algorithm.SetTextureWrap(choice("texture_wrap", texture_wrap, TEXTURE_WRAPS))
    if samples_per_ring is not None:
        algorithm.SetSamplesPerRing(integer("samples_per_ring", samples_per_ring, 1, 4096))
    algorithm.SetLatentArrayName(array_name("latent_name", latent_name))
    return algorithm


def configured_decoder(
    model="field_latents",
    resolution=1024,
    gutter_width=8,
    latent_name="FieldLatent",
    name="Texture",
    memory_limit=None,
):
    """A vtkFieldLatentDecoder with the parameters of decode_texture(), which raises TypeError and ValueError."""
    algorithm = vtkFieldLatentDecoder()
    algorithm.SetModelFileName(_path(model))
    sizes = tuple(resolution) if isinstance(resolution, (tuple, list, np.ndarray)) else (resolution, resolution)
    if len(sizes) != 2:
        raise ValueError(f"resolution must be one number or two, not {len(sizes)}")
    sizes = [integer("resolution", size, _LEAST_RESOLUTION, _MOST_RESOLUTION) for size in sizes]
    algorithm.SetResolution(*sizes)
    algorithm.SetGutterWidth(integer("gutter_width", gutter_width, -1, _MOST_RESOLUTION))
    algorithm.SetLatentArrayName(array_name("latent_name", latent_name))
    algorithm.SetTextureArrayName(array_name("name", name))
    if memory_limit is not None:
        algorithm.SetMemoryLimit(integer("memory_limit", memory_limit, 1))
    return algorithm


def _path(model):
    model = os.fspath(model)
    return model.decode() if isinstance(model, bytes) else model


def require_surface(name, given, accepted, text):
    if not isinstance(given, accepted):
        raise TypeError(f"{name} must be {text}, not {type(given).__name__}")


def image_of(given):
    """A texture as vtkImageData."""
    if isinstance(given, vtkImageData):
        return given
    if not isinstance(given, np.ndarray):
        raise TypeError(f"image must be a vtkImageData or an array, not {type(given).__name__}")
    if given.dtype.kind not in "fiub" or given.ndim not in (2, 3) or given.size == 0:
        raise ValueError(
            f"image must be an array of numbers of the shape [H, W] or [H, W, C], not of {given.dtype} {list(given.shape)}"
        )
    values = given.astype(np.uint8) * 255 if given.dtype.kind == "b" else given
    native = np.float32 if values.dtype == np.float16 else values.dtype.newbyteorder("=")
    return image_of_array(values.astype(native))


def image_of_array(values):
    """A vtkImageData of an array [H, W] or [H, W, C], whose row 0, the top row, becomes the last one."""
    height, width = values.shape[:2]
    image = vtkImageData()
    image.SetDimensions(width, height, 1)
    scalars = numpy_to_vtk(np.ascontiguousarray(values[::-1]).reshape(height * width, -1), deep=True)
    scalars.SetName("Texture")
    image.GetPointData().SetScalars(scalars)
    return image


def give_second(algorithm, dataset):
    """Makes a dataset, which stays untouched, the second input."""
    given = dataset.NewInstance()  # what pipelines leave on their inputs goes to this copy
    given.ShallowCopy(dataset)
    algorithm.SetInputDataObject(1, given)


def _warn(remarks):
    for text in remarks:
        warnings.warn(text, SurfaceSynthesisWarning, stacklevel=3)
