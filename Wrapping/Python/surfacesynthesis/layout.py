# SPDX-License-Identifier: BSD-3-Clause
"""Blocks of an ensemble side by side: a function around vtkEnsembleLayoutFilter."""

from vtkmodules.vtkCommonDataModel import vtkDataObjectTree, vtkMultiBlockDataSet

from .arguments import at_least_0, choice, flag, integer, progress_callback
from .datasets import given_dataset
from .pipeline import apply_filter
from .vtkSurfaceSynthesisEnsembles import vtkEnsembleLayoutFilter

#: The shapes of a layout, by the name that ``arrangement`` takes.
ARRANGEMENTS = {
    "grid": vtkEnsembleLayoutFilter.GRID,
    "row": vtkEnsembleLayoutFilter.ROW,
    "column": vtkEnsembleLayoutFilter.COLUMN,
}
#: The planes of a layout, by the name that ``plane`` takes.
PLANES = {"xy": vtkEnsembleLayoutFilter.XY, "xz": vtkEnsembleLayoutFilter.XZ, "yz": vtkEnsembleLayoutFilter.YZ}
#: The parts that are moved as one, by the name that ``unit`` takes.
UNITS = {"leaves": vtkEnsembleLayoutFilter.LEAVES, "children": vtkEnsembleLayoutFilter.CHILDREN}


def ensemble_layout(
    ensemble, arrangement="grid", columns=0, spacing=0.1, plane="xy", unit="leaves", centering=True, progress=None
):
    """Lays the blocks of an ensemble out side by side, for a picture of all of them.

    Parameters
    ----------
    ensemble : vtkDataObjectTree or list
        A composite dataset of blocks with points or of images; or a list of surfaces, each a vtkPolyData or a pair (points,
        triangles). Blocks without points take no place. None of them is modified.
    arrangement : str
        Shape of the layout: "grid" (default), "row" or "column".
    columns : int
        Number of blocks in a row of a grid; 0 chooses it so that the whole is near 16 : 10, with few empty
        places. Default 0.
    spacing : float
        Gap between two blocks, as a fraction of the largest block's size along the axis; at least 0. Default 0.1.
    plane : str
        Plane of the layout, "xy" (default), "xz" or "yz": columns along its first axis, rows against its second.
    unit : str
        Parts that are moved as one: "leaves" (default), single datasets; or "children", the blocks directly below the root,
        each with all that is in it.
    centering : bool
        Centering of each block in its cell. False: each block is moved by the distance of its cell from the first one, so
        that differences of position between the blocks stay. Default True.
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the work stops.

    Returns
    -------
    vtkDataObjectTree
        The ensemble with moved blocks, of the class of the input, a vtkMultiBlockDataSet for a list. Each block has the
        field array "Translation"; the first block stays where it is.

    Raises
    ------
    SurfaceSynthesisError
        A block cannot be moved, or its points are not finite.
    Cancelled
        ``progress`` returned False.
    ValueError, TypeError
        An argument has a value out of its range or is of a wrong type.
    """
    progress_callback(progress)
    algorithm = vtkEnsembleLayoutFilter()
    algorithm.SetArrangement(choice("arrangement", arrangement, ARRANGEMENTS))
    algorithm.SetNumberOfColumns(integer("columns", columns, 0))
    algorithm.SetSpacing(at_least_0("spacing", spacing))
    algorithm.SetPlane(choice("plane", plane, PLANES))
    algorithm.SetUnit(choice("unit", unit, UNITS))
    algorithm.SetCentering(flag("centering", centering))
    output, _ = apply_filter(algorithm, _tree_of(ensemble), progress)
    return output


def _tree_of(ensemble):
    if isinstance(ensemble, vtkDataObjectTree):
        return ensemble
    if not isinstance(ensemble, (tuple, list)):
        raise TypeError(f"ensemble must be a composite dataset or a list of surfaces, not {type(ensemble).__name__}")
    blocks = vtkMultiBlockDataSet()
    for number, surface in enumerate(ensemble):
        blocks.SetBlock(number, given_dataset(surface))
    return blocks
