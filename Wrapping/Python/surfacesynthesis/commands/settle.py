# SPDX-License-Identifier: BSD-3-Clause
"""The command ``settle``."""

from .common import (
    Outcome,
    UsageError,
    add_command,
    add_running_options,
    as_usage,
    is_volume,
    run_filter,
    size_of,
)
from .elastic_options import add_body_options, body_of, tetrahedra_of
from .metrics import check_ensemble_names, is_dataset_file, read_ensemble

_DESCRIPTION = """\
Lays a soft body down in given shapes, such as samples of a model, and lets it go: finds the rest state next to each, in which
it lies on the floor under its weight, turned as INPUT lies (--no-align: as the shape does). Quantities are in SI units."""
_EXAMPLES = """\
files: the format follows from the extension.
  INPUT                   closed surfaces: .stl .ply .obj .off .gii .glb .vtp .vtk; tetrahedra: .vtu .vtk; several bodies: .vtm
  --shapes                files of copies of INPUT with moved points, .vtm for several; of a surface also a dataset file of
                          positions (.safetensors); of several bodies one .vtm, as deform writes, with the shapes of each in
                          its place
  OUTPUT                  .vtm; for one shape also .vtp .vtk .ply .stl .obj .off, of tetrahedra .vtu .vtk

examples:
  %(prog)s bunny.ply resting.vtm --shapes samples.vtm --up-direction 0 1 0
  %(prog)s femur.vtu bent.vtu --shapes guess.vtu --no-align --youngs-modulus 1e6 --length-unit 0.001
  %(prog)s bodies.vtm resting.vtm --shapes deformed.vtm
"""


def add(commands):
    """Adds the command to the parser."""
    parser = add_command(
        commands, "settle", "INPUT OUTPUT --shapes FILE [FILE ...]", "lay a soft body down in given shapes", _DESCRIPTION,
        _EXAMPLES,
    )  # fmt: skip
    parser.set_defaults(run=run)
    parser.add_argument("input", metavar="INPUT", help="body to read, undeformed")
    parser.add_argument("output", metavar="OUTPUT", help="rest states to write")
    parser.add_argument("--shapes", nargs="+", required=True, metavar="FILE", help="shapes to begin with")
    add_body_options(parser)
    output = parser.add_argument_group("output")
    output.add_argument(
        "--memory-limit", type=int, metavar="MIB", help="memory of the rest states, MiB (default: 3/4 of the machine's)"
    )
    add_running_options(output)


def run(arguments):
    """The command ``settle``."""
    from .. import files
    from ..arguments import INT_MAX, integer
    from ..rest_states import configured_rest_states

    options = body_of(arguments)
    as_usage(configured_rest_states, **options)
    if arguments.memory_limit is not None:
        as_usage(integer, "memory_limit", arguments.memory_limit, 1, INT_MAX)
    as_usage(files.extension, arguments.input)
    kind = as_usage(files.extension, arguments.output)
    check_ensemble_names(arguments.shapes)
    body = _body(arguments.input)
    shapes = _shapes(arguments.shapes, body)
    leaves = _leaves(shapes)
    is_single = len(leaves) == 1 and kind != ".vtm" and not _is_composite(body)
    written = leaves[0] if is_single else body if _is_composite(body) else _as_blocks(leaves)
    as_usage(files.check_writable, written, arguments.output)
    algorithm = as_usage(configured_rest_states, tetrahedra=tetrahedra_of(arguments), **options)
    algorithm.SetMemoryLimit(arguments.memory_limit or 0)
    algorithm.SetShapesData(shapes)
    output = run_filter(algorithm, body, arguments)
    states = len(_leaves(output))
    output = output.GetBlock(0) if is_single else output
    files.write_mesh(output, arguments.output)
    return Outcome(f"{states:,} rest states", {"samples": states, **size_of(output)}, [arguments.output])


def _body(path):
    """A surface, tetrahedra, or a composite dataset of such bodies in a file."""
    from vtkmodules.vtkCommonDataModel import vtkPolyData, vtkUnstructuredGrid

    from ..errors import FormatError
    from ..files import read_mesh

    mesh = read_mesh(path)
    if not _is_composite(mesh) and not isinstance(mesh, (vtkPolyData, vtkUnstructuredGrid)):
        raise FormatError(f"{path}: the body must be a surface or a grid of tetrahedra, not a {mesh.GetClassName()}")
    if mesh.GetNumberOfPoints() == 0:
        raise FormatError(f"{path}: the file holds no points")
    return mesh


def _shapes(paths, body):
    """The shapes in files, of a surface, of tetrahedra or of several bodies: a dataset, or a composite one."""
    from ..errors import FormatError
    from ..files import read_mesh

    if _is_composite(body):
        shapes = None if len(paths) > 1 or is_dataset_file(paths[0]) else read_mesh(paths[0])
        if shapes is None or not _is_composite(shapes):
            raise UsageError("shapes of several bodies are read from one .vtm, which has those of each body in its place")
        return shapes
    if not is_volume(body):
        shapes, signal, _ = read_ensemble(paths)
        if signal is not None:
            raise FormatError(f"{paths[0]}: the file holds the signal {signal!r} where positions are needed")
        return shapes
    if any(is_dataset_file(path) for path in paths):
        raise UsageError("shapes of tetrahedra are not read from dataset files, but from .vtu, .vtk and .vtm")
    return read_mesh(paths[0]) if len(paths) == 1 else _as_blocks([read_mesh(path) for path in paths])


def _is_composite(mesh):
    return hasattr(mesh, "NewTreeIterator")


def _leaves(shapes):
    """The datasets of the shapes, in order."""
    if not _is_composite(shapes):
        return [shapes]
    leaves, iterator = [], shapes.NewTreeIterator()
    iterator.InitTraversal()
    while not iterator.IsDoneWithTraversal():
        leaves.append(iterator.GetCurrentDataObject())
        iterator.GoToNextItem()
    return leaves


def _as_blocks(leaves):
    """A composite dataset of datasets."""
    from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet

    blocks = vtkMultiBlockDataSet()
    for number, leaf in enumerate(leaves):
        blocks.SetBlock(number, leaf)
    return blocks
