# SPDX-License-Identifier: BSD-3-Clause
"""The command ``metrics``."""

import collections

from .common import UsageError, add_command, add_running_options, as_usage, read_surface, result_outcome, run_filter

_DESCRIPTION = """\
Compares a generated with a reference ensemble of shapes or signals on one triangulation: minimum matching
distance (MMD), coverage (COV), 1-nearest-neighbour accuracy, the error of the pointwise mean."""
_EXAMPLES = """\
ensembles: one file with a composite dataset (.vtm .vtk), whose surfaces are the samples; one file for each sample; or one
surface with an array for each sample, called NAME_0, NAME_1 and so on; or a dataset file of trainings (.safetensors).

examples:
  %(prog)s --generated generated.vtm --reference reference.vtm --source neutral.ply
  %(prog)s --generated made_*.vtp --reference real_*.vtp --array Height --csv > metrics.csv
  %(prog)s --generated generated.vtm --reference reference.vtm --json
"""


def add(commands):
    """Adds the command to the parser."""
    parser = add_command(
        commands,
        "metrics",
        "--generated FILE... --reference FILE...",
        "compare generated shapes or signals with real ones",
        _DESCRIPTION,
        _EXAMPLES,
    )
    parser.set_defaults(run=run)
    ensembles = parser.add_argument_group("ensembles")
    formats = ".stl .ply .obj .off .gii .glb .vtp .vtk .vtm .safetensors"
    ensembles.add_argument(
        "--generated", required=True, nargs="+", metavar="FILE", help=f"the generated ensemble: {formats}"
    )
    ensembles.add_argument("--reference", required=True, nargs="+", metavar="FILE", help="the reference ensemble")
    ensembles.add_argument(
        "--source", metavar="FILE", help="surface that gives the points their mass (default: the first reference, of a dataset file its surface)"
    )
    ensembles.add_argument("--array", metavar="NAME", help="point array that is compared (default: the points; of dataset files their signal)")
    comparison = parser.add_argument_group("comparison")
    comparison.add_argument(
        "--distance",
        default="mean_l2",
        choices=["mean_l2", "rms"],
        metavar="HOW",
        help="distance of two samples, weighted by mass: mean_l2 (default: the mean distance of corresponding points), "
        "rms (the root of the mean squared one)",
    )
    comparison.add_argument(
        "--remove-centroid", action="store_true", help="compare samples less their mean value: up to translation"
    )
    output = parser.add_argument_group("output")
    forms = add_running_options(output, csv="the metrics")
    forms.add_argument(
        "--nearest", action="store_true", help="as comma-separated values, the nearest reference of each generated sample"
    )


def run(arguments):
    """The command ``metrics``."""
    from .. import files
    from ..metrics import compare, configured_filter, metrics_of

    algorithm = as_usage(configured_filter, arguments.array, arguments.distance, arguments.remove_centroid)
    check_ensemble_names([*arguments.generated, *arguments.reference])
    if arguments.source:
        as_usage(files.extension, arguments.source)
    generated, reference = (read_ensemble(paths, arguments.array) for paths in (arguments.generated, arguments.reference))
    choose_array(algorithm, arguments.array, (generated, reference))
    source = read_source(arguments.source) if arguments.source else reference.source
    compare(algorithm, generated.dataset, reference.dataset, source, lambda dataset: run_filter(algorithm, dataset, arguments))
    metrics = metrics_of(algorithm)
    outcome = result_outcome(arguments, metrics)
    return outcome._replace(table=metrics.nearest_to_csv().rstrip("\n")) if arguments.nearest else outcome


#: An ensemble in files: its dataset; of a dataset file, the name of the array with the signal, or None for positions, and the
#: surface of the first source.
Ensemble = collections.namedtuple("Ensemble", "dataset array source")


def is_dataset_file(path):
    """True for a dataset file of trainings, by its name."""
    return str(path).endswith(".safetensors")


def check_ensemble_names(paths):
    """Raises UsageError for a file of an ensemble that cannot be read, by its name."""
    from .. import files

    for path in paths:
        if not is_dataset_file(path):
            as_usage(files.extension, path)


def read_ensemble(paths, array=None):
    """The Ensemble of the only file, or of several files as blocks. Surfaces with the polygons of the first one share them,
    and keep the points and ``array`` only."""
    from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet, vtkPolyData

    if len(paths) == 1 and is_dataset_file(paths[0]):
        return _read_dataset_file(paths[0])
    if len(paths) == 1:
        return Ensemble(_read(paths[0]), None, None)
    blocks, first = vtkMultiBlockDataSet(), None
    for number, path in enumerate(paths):
        mesh = _read(path)
        if isinstance(mesh, vtkPolyData):
            mesh = mesh if first is None else _sharing(mesh, first, array)
            first = first or mesh
        blocks.SetBlock(number, mesh)
    return Ensemble(blocks, None, None)


def choose_array(algorithm, array, ensembles):
    """Gives a filter the array of the dataset files, where the option --array names none."""
    named = [ensemble.array for ensemble in ensembles if ensemble.array is not None]
    if array is None and named:
        algorithm.SetArrayName(named[0])


def _read_dataset_file(path):
    from ..dataset_surfaces import POSITION, surfaces_of_dataset
    from ..datasets import dataset_of_pair
    from ..signal_datasets import read_signal_dataset

    dataset = read_signal_dataset(path)
    source = dataset_of_pair(dataset.sources[0][:2])
    return Ensemble(surfaces_of_dataset(dataset), None if dataset.name == POSITION else dataset.name, source)


def _sharing(mesh, first, array):
    """The mesh with the polygons of the first one, where they are equal, and with the arrays of samples only."""
    from vtkmodules.vtkCommonDataModel import vtkPolyData

    if mesh.GetNumberOfCells() != mesh.GetNumberOfPolys() or not _has_polygons_of(mesh, first):
        return mesh
    lean, data = vtkPolyData(), mesh.GetPointData()
    lean.SetPoints(mesh.GetPoints())
    lean.SetPolys(first.GetPolys())
    for k in range(data.GetNumberOfArrays()):
        name = data.GetArrayName(k) or ""
        if array is not None and (name == array or name.startswith(f"{array}_")):
            lean.GetPointData().AddArray(data.GetAbstractArray(k))
    return lean


def _has_polygons_of(mesh, first):
    import numpy as np
    from vtkmodules.util.numpy_support import vtk_to_numpy

    pairs = [(one.GetOffsetsArray(), one.GetConnectivityArray()) for one in (mesh.GetPolys(), first.GetPolys())]
    return all(np.array_equal(vtk_to_numpy(a), vtk_to_numpy(b)) for a, b in zip(*pairs))


def _read(path):
    """A surface, or a composite dataset."""
    from ..datasets import SURFACES
    from ..errors import FormatError

    if is_dataset_file(path):
        raise UsageError(f"{path}: a dataset file is an ensemble by itself; it cannot be given with other files")
    mesh = read_surface(path)
    if not isinstance(mesh, SURFACES):
        raise FormatError(f"{path}: surfaces are compared, not a {mesh.GetClassName()}")
    return mesh


def read_source(path):
    """The one surface in a file."""
    from vtkmodules.vtkCommonDataModel import vtkPolyData

    from ..errors import FormatError

    mesh = read_surface(path)
    if not isinstance(mesh, vtkPolyData):
        raise FormatError(f"{path}: the source must be one surface, not a {mesh.GetClassName()}")
    return mesh
