# SPDX-License-Identifier: BSD-3-Clause
"""Geometric textures from an example, without a training: a function around vtkGeometricTextureFromExample."""

import os
import warnings

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonDataModel import vtkPolyData

from .arguments import INT_MIN, array_name, at_most, flag, in_range, integer, positive, progress_callback
from .datasets import as_type_of, given_dataset
from .errors import SurfaceSynthesisWarning
from .files.polygons import from_polydata
from .pipeline import apply_filter
from .vtkSurfaceSynthesisGeometricTexture import vtkGeometricTextureFromExample

_LARGEST_SCALE, _LARGEST_LENGTH = 1e12, 1e300
_MOST_SUBDIVISIONS = _MOST_SCALES = 8


def geometric_texture_from_example(
    mesh,
    example,
    plain_example=None,
    seed=0,
    texture_scale=None,
    subdivisions=None,
    scales=None,
    smoothing_length=None,
    orientation=None,
    example_orientation=None,
    size=None,
    mask=None,
    strength=1.0,
    printable=False,
    displacement_name="Displacement",
    progress=None,
    second_example=None,
    second_plain_example=None,
    second_smoothing_length=None,
    blend=None,
):
    """Synthesizes the geometric texture of an example surface on another, without a training.

    From coarse scales to fine ones the distribution of the patches of the target, pieces of the surface a few features wide, is
    matched to that of the example by sliced Wasserstein distances (Heitz et al., "A Sliced Wasserstein Loss for Neural Texture
    Synthesis", 2021; Elnekave and Weiss, "Generating Natural Images with Direct Patch Distributions Matching", 2022). Then the
    nearest patch of the example replaces each one, and their mean overlapping ones (Kwatra et al., "Texture Optimization for
    Example-based Synthesis", 2005; Granot et al., "Drop the GAN", 2022), in which patches count less the less they agree, and
    which is stretched until patches vary as widely as those of the example. The same seed gives the same bits for every number
    of threads.

    Parameters
    ----------
    mesh : vtkPolyData, composite dataset (vtkDataObjectTree) or pair (points, triangles)
        The target, of any genus: triangles, polygons or strips, float or double points, open or closed. The mesh must have
        finite points, no degenerate triangle, no edge with more than two triangles and consistent winding. A composite dataset
        is processed block by block, with random numbers that differ between blocks. A pair is an array of points [V, 3] and an
        integer array of triangles [F, 3]. Never modified.
    example : vtkPolyData, pair (points, triangles), str or path
        The example, a surface as ``mesh``, such as a piece of a scan, never modified; or the path of an example file or the name
        of an installed example, a piece of a scan: "cortex", the folds of a brain; "mane", curls in rows, with a direction;
        "mountains", ridges and valleys of a landscape.
    plain_example : vtkPolyData or pair (points, triangles), optional
        The example without its texture: the same triangles, other points; not with a file or a name. Never modified. Default:
        the smooth form of the example, see ``smoothing_length``.
    seed : int
        Any integer of 32 bits with sign; each gives another sample of the texture. Default 0.
    texture_scale : float, optional
        Size of the texture on the target over its size on the example, both in world units, above 0 to 1e12. Default: the mean
        edge length of the target, once subdivided, over that of the plain example; triangles stand for triangles, whatever the
        units are. Of two examples each has its own scale then; a given one is that of both, so that their units must be the same.
    subdivisions : int, optional
        Number of times that each triangle of the target is divided into four, 0 to 8. Default: 2 without ``texture_scale``, and
        else as many as make edges nearly as long as those of the example at that scale.
    scales : int, optional
        Number of scales, 1 to 8: patches of the finest one are 8 mean edges of the example wide, and those of each coarser one
        twice as wide. Default: as many as make the widest patches about three features wide; of two examples the larger of both
        numbers, as far as patches fit on both.
    smoothing_length : float, optional
        Length of the smoothing that takes the texture off the example, world units of the example, above 0 to 1e300; not with
        ``plain_example``. Waves of this length or shorter are texture: 5 % of them stay in the form, and 94 % of waves ten
        times as long. Patches within this length of a boundary are left out, because the smooth form draws back there. Default:
        a tenth of the root of the area; of a file or a name that of the file.
    orientation : str, optional
        Name of a point array of the target with three components, the direction of the texture: patches are turned so that
        the direction of ``example_orientation`` comes to lie along it. Default: patches are turned as it happens, for textures
        that look alike in every direction.
    example_orientation : str, optional
        Name of a point array of the examples with three components, the direction of their texture; goes with
        ``orientation``. Example files hold their direction, so that it is not needed for them.
    size : str, optional
        Name of a point array of the target with one component, from 0.1 to 10, that multiplies the size of the texture from
        place to place. Default: one size.
    mask : str, optional
        Name of a point array of the target with one component, from 0 to 1, that displacements are multiplied with. Default:
        displacements everywhere.
    strength : float
        Factor of the displacements, from 0 to 1e6; ``printable`` reduces the result. Default 1.
    printable : bool
        True reduces displacements until no triangles of the output intersect, for slicers of 3D printers; needs CGAL. Where
        triangles intersect, first the tangential part of the displacements falls, then the part along the normals of the
        target. Where triangles of the target itself intersect they remain, with a warning. Default False.
    displacement_name : str
        Name of the point array with the displacement of each point. Default "Displacement".
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the work stops.
    second_example : vtkPolyData, pair (points, triangles), str or path, optional
        A second example, as ``example``, for a blend of two textures; goes with ``blend``. Default: one example.
    second_plain_example : vtkPolyData or pair (points, triangles), optional
        The second example without its texture: the same triangles, other points. Never modified. Default: its smooth form.
    second_smoothing_length : float, optional
        The ``smoothing_length`` of the second example, world units of that example; not with ``second_plain_example``. Default:
        a tenth of the root of its area.
    blend : str, optional
        Name of a point array of the target with one component, from 0 to 1, the share of the second example: features of the
        first at 0, of the second at 1, and between them islands of both, about as wide as a feature of mean size, that cover such
        a share of the area. Features are mixed and agree where they meet; their heights are not.

    Returns
    -------
    dataset of the type of ``mesh``
        Triangles, four times as many for each subdivision, with the target's arrays interpolated and that of displacements;
        without normals. The field arrays ``TextureScale``, ``Subdivisions`` and ``NumberOfScales`` hold the values that were
        used, and ``Mismatch`` the root of the mean square distance of the patches from the nearest ones of the example, at the
        finest scale, over the root of the mean square displacement of the example: 0 where each piece is one of the example.
        With ``printable``, ``NumberOfSelfIntersections`` holds the number of pairs of triangles that still intersect, and
        ``HeightKept`` the share of the height that was kept.
    pair of numpy.ndarray, for a pair
        Points [V, 3], float64, and triangles [F, 3], int64.

    Raises
    ------
    SurfaceSynthesisError
        The text names the defect of the target, the example or an array, the first cell or point, and the filter that repairs
        it; for a composite dataset it holds a line for each bad block.
    Cancelled
        ``progress`` returned False.
    ValueError, TypeError
        An argument has a value out of its range, contradicts another or is of a wrong type.
    """
    algorithm = configured_filter(
        seed=seed,
        texture_scale=texture_scale,
        subdivisions=subdivisions,
        scales=scales,
        smoothing_length=smoothing_length,
        orientation=orientation,
        example_orientation=example_orientation,
        size=size,
        mask=mask,
        strength=strength,
        printable=printable,
        displacement_name=displacement_name,
        second_smoothing_length=second_smoothing_length,
        blend=blend,
    )
    progress_callback(progress)
    dataset = given_dataset(mesh)
    give_examples(algorithm, example, plain_example, second_example, second_plain_example)
    output, remarks = apply_filter(algorithm, dataset, progress)
    for text in remarks:
        warnings.warn(text, SurfaceSynthesisWarning, stacklevel=2)
    if isinstance(mesh, (tuple, list)):
        polygons = from_polydata(output)
        return polygons.points.astype(np.float64), polygons.connectivity.reshape(-1, 3)
    add_field_arrays(algorithm, output)
    return as_type_of(mesh, output)


def configured_filter(
    seed=0,
    texture_scale=None,
    subdivisions=None,
    scales=None,
    smoothing_length=None,
    orientation=None,
    example_orientation=None,
    size=None,
    mask=None,
    strength=1.0,
    printable=False,
    displacement_name="Displacement",
    second_smoothing_length=None,
    blend=None,
):
    """A vtkGeometricTextureFromExample with the parameters of geometric_texture_from_example(), which raises TypeError and
    ValueError."""
    algorithm = vtkGeometricTextureFromExample()
    algorithm.SetSeed(integer("seed", seed, INT_MIN))
    if texture_scale is not None:
        algorithm.SetTextureScale(at_most("texture_scale", positive("texture_scale", texture_scale), _LARGEST_SCALE))
    if subdivisions is not None:
        algorithm.SetSubdivisions(integer("subdivisions", subdivisions, 0, _MOST_SUBDIVISIONS))
    if scales is not None:
        algorithm.SetNumberOfScales(integer("scales", scales, 1, _MOST_SCALES))
    for keyword, length, setter in (
        ("smoothing_length", smoothing_length, algorithm.SetSmoothingLength),
        ("second_smoothing_length", second_smoothing_length, algorithm.SetSecondSmoothingLength),
    ):
        if length is not None:
            setter(at_most(keyword, positive(keyword, length), _LARGEST_LENGTH))
    if orientation is None and example_orientation is not None:
        raise ValueError("orientation and example_orientation go together: point arrays of the target and of the example")
    for keyword, given, setter in (
        ("orientation", orientation, algorithm.SetOrientationArrayName),
        ("example_orientation", example_orientation, algorithm.SetExampleOrientationArrayName),
        ("size", size, algorithm.SetSizeArrayName),
        ("mask", mask, algorithm.SetMaskArrayName),
        ("blend", blend, algorithm.SetBlendArrayName),
    ):
        if given is not None:
            setter(array_name(keyword, given))
    algorithm.SetStrength(in_range("strength", strength, 0.0, 1e6))
    algorithm.SetPrintable(flag("printable", printable))
    algorithm.SetDisplacementArrayName(array_name("displacement_name", displacement_name))
    return algorithm


def give_examples(algorithm, example, plain_example=None, second_example=None, second_plain_example=None):
    """Makes surfaces, which stay untouched, and files the examples of a vtkGeometricTextureFromExample."""
    for keyword, given, plain in (("", example, plain_example), ("second_", second_example, second_plain_example)):
        if _is_file(given) and plain is not None:
            raise ValueError(f"{keyword}plain_example goes with a surface, not with the file or the name of an example")
    for keyword, given in (("example", example), ("second_example", second_example)):
        if _is_file(given) and os.path.splitext(given)[1] not in ("", ".safetensors"):
            raise ValueError(f"{keyword} is the path of a surface; read it with read_mesh() first")
    surfaces = [given for given in (example, second_example) if given is not None and not _is_file(given)]
    if surfaces and algorithm.GetOrientationArrayName() and not algorithm.GetExampleOrientationArrayName():
        raise ValueError("orientation and example_orientation go together: point arrays of the target and of the example")
    if plain_example is not None and algorithm.GetSmoothingLength() > 0:
        raise ValueError("smoothing_length is of no use with plain_example, which is the example without its texture")
    if (second_example is None) != (not algorithm.GetBlendArrayName()):
        raise ValueError("second_example and blend go together: an example and the point array of the target with its share")
    if second_plain_example is not None and algorithm.GetSecondSmoothingLength() > 0:
        raise ValueError("second_smoothing_length is of no use with second_plain_example")
    if second_example is None and (second_plain_example is not None or algorithm.GetSecondSmoothingLength() > 0):
        raise ValueError("second_plain_example and second_smoothing_length are of no use without second_example")
    given = {
        "example": example,
        "plain_example": plain_example,
        "second_example": second_example,
        "second_plain_example": second_plain_example,
    }
    for port, (keyword, surface) in enumerate(given.items(), 1):
        if surface is None and keyword != "example":
            continue
        if _is_file(surface) and "plain" not in keyword:
            setter = algorithm.SetExampleFileName if keyword == "example" else algorithm.SetSecondExampleFileName
            setter(os.fspath(surface))
            continue
        copy = vtkPolyData()  # what pipelines leave on their inputs goes to this copy
        copy.ShallowCopy(_surface(keyword, surface))
        algorithm.SetInputDataObject(port, copy)


def results_of(algorithm):
    """Values that a filter used and reached in its update, by the names of properties."""
    results = {
        "TextureScale": algorithm.GetTextureScaleUsed(),
        "Subdivisions": algorithm.GetSubdivisionsUsed(),
        "NumberOfScales": algorithm.GetNumberOfScalesUsed(),
        "Mismatch": algorithm.GetMismatch(),
    }
    if algorithm.GetPrintable():
        results["NumberOfSelfIntersections"] = algorithm.GetNumberOfSelfIntersections()
        results["HeightKept"] = algorithm.GetHeightKept()
    return results


def add_field_arrays(algorithm, output):
    """Adds the numbers of a filter that has run to its output, a field array of one value each."""
    for name, value in results_of(algorithm).items():
        array = numpy_to_vtk(np.array([value]), deep=True)
        array.SetName(name)
        output.GetFieldData().AddArray(array)


def _is_file(given):
    """True for the path or the name of an example file."""
    return isinstance(given, (str, os.PathLike))


def _surface(keyword, given):
    """A surface of an argument, a vtkPolyData or a pair."""
    if not isinstance(given, (vtkPolyData, tuple, list)):
        other = "" if "plain" in keyword else " or the name of an example"
        raise TypeError(
            f"{keyword} must be a vtkPolyData or a pair of arrays (points, triangles){other}, not {type(given).__name__}"
        )
    return given_dataset(given)
