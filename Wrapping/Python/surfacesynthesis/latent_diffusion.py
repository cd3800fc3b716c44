# SPDX-License-Identifier: BSD-3-Clause
"""New textures of surfaces: a function around vtkFieldLatentTextureFilter."""

import collections
import os
import warnings

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet

from .arguments import INT_MIN, array_name, at_most, choice, flag, integer, progress_callback
from .datasets import SURFACES, as_type_of
from .errors import SurfaceSynthesisWarning
from .field_latents import give_second, image_of, require_surface
from .pipeline import outputs_at_times
from .sampling import checked_range
from .vtkSurfaceSynthesisFieldLatents import vtkFieldLatentTextureFilter

#: Methods of the reverse process, by the name that ``sampler`` takes.
SAMPLERS = {"ddim": vtkFieldLatentTextureFilter.DDIM, "ddpm": vtkFieldLatentTextureFilter.DDPM}
#: Triangulations on which latents are sampled, by the name that ``triangulation`` takes.
TRIANGULATIONS = {"remesh": vtkFieldLatentTextureFilter.REMESH, "as_is": vtkFieldLatentTextureFilter.AS_IS}

#: A result of sample_texture(): a surface with colors at its points, its texture image, and the triangulation with the
#: sampled latents.
SampledTexture = collections.namedtuple("SampledTexture", "mesh image latents")

_LEAST_RESOLUTION, _MOST_RESOLUTION = 16, 16384
_MOST_SAMPLES = 10000


def sample_texture(
    mesh,
    model,
    image=None,
    autoencoder="field_latents",
    seed=0,
    samples=None,
    first_sample=0,
    label=None,
    direction=None,
    mask=None,
    color=None,
    triangulation="remesh",
    points=None,
    sampler="ddim",
    steps=50,
    trajectory=False,
    resolution=1024,
    gutter_width=8,
    latent_name="FieldLatent",
    name="Texture",
    memory_limit=None,
    progress=None,
):
    """Samples new textures for a surface with a diffusion model of field latents.

    Parameters
    ----------
    mesh : vtkPolyData or composite dataset (vtkDataObjectTree)
        Triangles, polygons or strips, float or double points, open or closed. The mesh must have finite points, no
        degenerate triangle and, once points at the same coordinates are joined, manifold edges and points and consistent
        winding. One without texture coordinates gets the atlas of texture_atlas(). A composite dataset is processed block
        by block, with noise that differs between blocks. The mesh is never modified.
    model : path or str
        The file of the diffusion model, or the name of an installed model.
    image : vtkImageData or array [H, W] or [H, W, C], optional
        The texture that the mesh has, as for encode_texture(); read with ``mask`` only. Default: the colors of the points.
    autoencoder : path or str
        The file of the autoencoder of the model's latents, or the name of an installed one. Default "field_latents", the
        installed one.
    seed : int
        Any integer of 32 bits with sign; each gives another texture. Default 0.
    samples : int, optional
        Number of samples, 1 to 10000. Default: one sample, which is returned by itself.
    first_sample : int
        Index of the first sample, at least 0. Sample k is the same alone or in a batch. Default 0.
    label : str, optional
        Name of a point array with the label of each point: whole numbers from 0, or -1 for no label. Needs a model with
        labels. Default: no labels.
    direction : str, optional
        Name of a point array with a vector for each point, of any length: the direction of the texture. Needs a directed
        model. Default: no directions.
    mask : str, optional
        Name of a point array with numbers from 0 to 1: 1 where the texture of the mesh is kept, 0 where a new one is
        sampled. Default: a new texture everywhere.
    color : str, optional
        Name of the point array of colors that ``mask`` keeps when there is no image. Default: the active point scalars.
    triangulation : str
        Triangles on which latents are sampled: "remesh", even ones with ``points`` vertices, which needs CGAL; "as_is", those
        of the mesh, on which colors are lost where they are those of a regular grid. Default "remesh".
    points : int, optional
        Number of vertices of the remeshed triangulation, 16 to 10000000: four times as many halve the size of the texture.
        Default: the mean number of the training surfaces, or that of the mesh when the model does not know it.
    sampler : str
        The method of the reverse process: "ddim", deterministic after the first noise; "ddpm", which adds noise in each step
        and is made for all steps of the training. Default "ddim".
    steps : int
        Number of evaluations of the network, from 1 to the time steps of the model. Default 50.
    trajectory : bool
        Return the states of the reverse process, decoded, in place of the last one. Default False.
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
        Memory limit of images, samples and network, MiB, at least 1. Default: three quarters of the memory of the machine.
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the work stops.

    Returns
    -------
    SampledTexture (mesh, image, latents)
        The mesh with the point array ``name``, unsigned char RGB, as active scalars; a vtkImageData with scalars of that
        name, row 0 at v = 0; and the triangulation with the arrays of encode_texture(), which decode_texture() takes. For
        a composite dataset three composite datasets. With ``samples`` a list of these. With ``trajectory`` a list of what
        is returned otherwise, ``steps`` + 1 states from noise to the texture, all in memory.

    Raises
    ------
    SurfaceSynthesisError
        The text names the defect of a model file, models that do not belong together, or the defect of the texture, an array
        or the mesh; for a composite dataset it holds a line for each bad block.
    Cancelled
        ``progress`` returned False.
    ValueError, TypeError
        An argument has a value out of its range or is of a wrong type.
    """
    require_surface("mesh", mesh, SURFACES, "a vtkPolyData or a composite dataset")
    algorithm = configured_texture_sampler(
        model,
        autoencoder=autoencoder,
        seed=seed,
        samples=samples,
        first_sample=first_sample,
        label=label,
        direction=direction,
        mask=mask,
        color=color,
        triangulation=triangulation,
        points=points,
        sampler=sampler,
        steps=steps,
        trajectory=trajectory,
        resolution=resolution,
        gutter_width=gutter_width,
        latent_name=latent_name,
        name=name,
        memory_limit=memory_limit,
    )
    if image is not None:
        give_second(algorithm, image_of(image))
    times = [k / steps for k in range(steps + 1)] if trajectory else [None]
    states, remarks = outputs_at_times(algorithm, mesh, times, progress_callback(progress), _ports)
    for text in remarks:
        warnings.warn(text, SurfaceSynthesisWarning, stacklevel=2)
    textures = [_textures(mesh, samples, ports) for ports in states]
    return textures if trajectory else textures[0]


def _ports(algorithm):
    """Copies of the three outputs."""
    copies = []
    for port in range(3):
        output = algorithm.GetOutputDataObject(port)
        copies.append(output.NewInstance())
        copies[-1].ShallowCopy(output)
    return copies


def _textures(mesh, samples, ports):
    """The result of one state: a sample, or a list of samples."""
    if samples is None:
        return _sample(mesh, ports)
    if samples == 1:
        return [_sample(mesh, ports)]
    return [_sample(mesh, [port.GetBlock(k) for port in ports]) for k in range(samples)]


def configured_texture_sampler(
    model,
    autoencoder="field_latents",
    seed=0,
    samples=None,
    first_sample=0,
    label=None,
    direction=None,
    mask=None,
    color=None,
    triangulation="remesh",
    points=None,
    sampler="ddim",
    steps=50,
    trajectory=False,
    resolution=1024,
    gutter_width=8,
    latent_name="FieldLatent",
    name="Texture",
    memory_limit=None,
):
    """A vtkFieldLatentTextureFilter with the parameters of sample_texture(), which raises TypeError and ValueError."""
    algorithm = vtkFieldLatentTextureFilter()
    algorithm.SetModelFileName(os.fsdecode(model))
    algorithm.SetAutoencoderFileName(os.fsdecode(autoencoder))
    algorithm.SetSeed(integer("seed", seed, INT_MIN))
    count, first = checked_range(1 if samples is None else samples, first_sample)
    algorithm.SetNumberOfSamples(at_most("samples", count, _MOST_SAMPLES))
    algorithm.SetFirstSample(first)
    for keyword, given, setter in (
        ("label", label, algorithm.SetLabelArrayName),
        ("direction", direction, algorithm.SetDirectionArrayName),
        ("mask", mask, algorithm.SetMaskArrayName),
        ("color", color, algorithm.SetColorArrayName),
    ):
        if given is not None:
            setter(array_name(keyword, given))
    algorithm.SetTriangulation(choice("triangulation", triangulation, TRIANGULATIONS))
    if points is not None:
        algorithm.SetNumberOfPoints(integer("points", points, 16, 10000000))
    algorithm.SetSampler(choice("sampler", sampler, SAMPLERS))
    algorithm.SetNumberOfSteps(integer("steps", steps, 1, 100000))
    algorithm.SetOutputTrajectory(flag("trajectory", trajectory))
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


def _sample(mesh, ports):
    surface, image, latents = ports
    if isinstance(mesh, vtkMultiBlockDataSet) or not hasattr(mesh, "NewIterator"):
        surface = as_type_of(mesh, surface)
    return SampledTexture(surface, image, latents)
