# SPDX-License-Identifier: BSD-3-Clause
"""The commands ``dataset export`` and ``dataset import``: dataset files and surfaces."""

from .common import UsageError, add_command, add_running_options, as_usage, set_threads, written_outcome
from .metrics import check_ensemble_names, is_dataset_file, read_ensemble, read_source

_EXPORT = """\
Makes surfaces of the samples in a dataset file of signals. Of positions, each source has a block with a surface for each
sample, of which the first has the array SourcePosition; of other signals, each source is a surface with the arrays NAME_0,
NAME_1 and so on. The command import makes the same file of them again."""
_IMPORT = """\
Makes a dataset file of surfaces, to train flow matching and to test it with: the points of surfaces on one triangulation,
or their arrays. Successive surfaces with the same polygons are samples on one source."""


def add(signals):
    """Adds both commands to the parser of the command ``dataset``."""
    parser = add_command(
        signals, "export", "INPUT OUTPUT", "make surfaces of a dataset file", _EXPORT, parent="dataset"
    )
    parser.set_defaults(run=run_export)
    parser.add_argument("input", metavar="INPUT", help="file to read: .safetensors")
    parser.add_argument("output", metavar="OUTPUT", help="surfaces to write: .vtm; of one source of arrays also .vtp")
    group = parser.add_argument_group("samples")
    group.add_argument("--samples", type=int, metavar="N", help="number of samples of each source (default: all)")
    group.add_argument("--first-sample", type=int, default=0, metavar="K", help="index of the first (default: 0)")
    _add_output_options(parser)
    parser = add_command(
        signals, "import", "SURFACES... OUTPUT", "make a dataset file of surfaces", _IMPORT, parent="dataset"
    )
    parser.set_defaults(run=run_import)
    formats = ".stl .ply .obj .off .gii .glb .vtp .vtk .vtm"
    parser.add_argument("surfaces", nargs="+", metavar="SURFACES", help=f"the samples: {formats}")
    parser.add_argument("output", metavar="OUTPUT", help="file to write: .safetensors")
    group = parser.add_argument_group("signal")
    group.add_argument("--array", metavar="NAME", help="point array with the signal (default: the points)")
    group.add_argument(
        "--source", metavar="FILE", help="surface that the points are moved from (default: SourcePosition, or the first sample)"
    )
    _add_output_options(parser)


def _add_output_options(parser):
    add_running_options(parser.add_argument_group("output"))


def run_export(arguments):
    """The command ``dataset export``."""
    from .. import files
    from ..dataset_surfaces import leaves_of, surfaces_of_dataset
    from ..signal_datasets import read_signal_dataset

    ending = as_usage(files.extension, arguments.output)
    _require_dataset_file(arguments.input)
    set_threads(arguments.threads)
    dataset = read_signal_dataset(arguments.input)
    surfaces = as_usage(surfaces_of_dataset, dataset, arguments.samples, arguments.first_sample)
    leaves = leaves_of(surfaces)
    written = leaves[0] if len(leaves) == 1 and ending != ".vtm" else surfaces
    as_usage(files.check_writable, written, arguments.output)
    files.write_mesh(written, arguments.output)
    return _outcome(arguments, dataset, surfaces, surfaces=len(leaves))


def run_import(arguments):
    """The command ``dataset import``."""
    from .. import files
    from ..dataset_surfaces import dataset_of_surfaces
    from ..signal_datasets import write_signal_dataset

    check_ensemble_names(arguments.surfaces)
    _require_dataset_file(arguments.output)
    if any(map(is_dataset_file, arguments.surfaces)):
        raise UsageError("surfaces are needed, not dataset files")
    set_threads(arguments.threads)
    source = None
    if arguments.source:
        as_usage(files.extension, arguments.source)
        source = read_source(arguments.source)
    surfaces = read_ensemble(arguments.surfaces, arguments.array).dataset
    dataset = dataset_of_surfaces(surfaces, arguments.array, source)
    sources = [((one.points, one.triangles), one.signals) for one in dataset.sources]
    as_usage(write_signal_dataset, arguments.output, sources, dataset.name)
    return _outcome(arguments, dataset, surfaces)


def _require_dataset_file(path):
    if not is_dataset_file(path):
        raise UsageError(f"{path}: datasets are .safetensors files")


def _outcome(arguments, dataset, written, **values):
    samples = sum(len(source.signals) for source in dataset.sources)
    counts = {"signal": dataset.name, "sources": len(dataset.sources), "samples": samples, **values}
    text = f"{dataset.name}: {len(dataset.sources)} sources, {samples:,} samples, "
    return written_outcome(written, [arguments.output], text, **counts)
