# SPDX-License-Identifier: BSD-3-Clause
"""The command ``metrics``."""

from .common import add_command, add_result_options, add_running_options, as_usage, read_surface, result_text, run_filter

_DESCRIPTION = """\
Compares a generated with a reference ensemble of shapes or signals on one triangulation: minimum matching
distance (MMD), coverage (COV), 1-nearest-neighbour accuracy, the error of the pointwise mean."""
_EXAMPLES = """\
ensembles: one file with a composite dataset (.vtm .vtk), whose surfaces are the samples; one file for each sample; or one
surface with an array for each sample, called NAME_0, NAME_1 and so on.

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
    formats = ".stl .ply .obj .off .gii .glb .vtp .vtk .vtm"
    ensembles.add_argument(
        "--generated", required=True, nargs="+", metavar="FILE", help=f"the generated ensemble: {formats}"
    )
    ensembles.add_argument("--reference", required=True, nargs="+", metavar="FILE", help="the reference ensemble")
    ensembles.add_argument(
        "--source", metavar="FILE", help="surface that gives the points their mass (default: the first reference)"
    )
    ensembles.add_argument("--array", metavar="NAME", help="point array that is compared (default: the points)")
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
    forms = add_result_options(output, "the metrics")
    forms.add_argument(
        "--nearest", action="store_true", help="as comma-separated values, the nearest reference of each generated sample"
    )
    add_running_options(output)


def run(arguments):
    """The command ``metrics``; returns the text to print."""
    from .. import files
    from ..metrics import compare, configured_filter, metrics_of

    algorithm = as_usage(configured_filter, arguments.array, arguments.distance, arguments.remove_centroid)
    for path in [*arguments.generated, *arguments.reference, *([arguments.source] if arguments.source else [])]:
        as_usage(files.extension, path)
    generated, reference = (read_ensemble(paths) for paths in (arguments.generated, arguments.reference))
    source = _source(arguments.source) if arguments.source else None
    compare(algorithm, generated, reference, source, lambda dataset: run_filter(algorithm, dataset, arguments))
    metrics = metrics_of(algorithm)
    return metrics.nearest_to_csv().rstrip("\n") if arguments.nearest else result_text(arguments, metrics)


def read_ensemble(paths):
    """The dataset in the only file, or those of several files as blocks."""
    from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet

    meshes = [_read(path) for path in paths]
    if len(meshes) == 1:
        return meshes[0]
    blocks = vtkMultiBlockDataSet()
    for number, mesh in enumerate(meshes):
        blocks.SetBlock(number, mesh)
    return blocks


def _read(path):
    """A surface, or a composite dataset."""
    from ..datasets import SURFACES
    from ..errors import FormatError

    mesh = read_surface(path)
    if not isinstance(mesh, SURFACES):
        raise FormatError(f"{path}: surfaces are compared, not a {mesh.GetClassName()}")
    return mesh


def _source(path):
    from vtkmodules.vtkCommonDataModel import vtkPolyData

    from ..errors import FormatError

    mesh = read_surface(path)
    if not isinstance(mesh, vtkPolyData):
        raise FormatError(f"{path}: the source must be one surface, not a {mesh.GetClassName()}")
    return mesh
