# SPDX-License-Identifier: BSD-3-Clause
"""Description and defects of a surface: a function around vtkTopologyReport."""

import re
import warnings

from .arguments import integer, progress_callback
from .datasets import given_dataset
from .deprecation import warn_renamed
from .errors import SurfaceSynthesisWarning
from .pipeline import apply_filter
from .results import MappingResult, Result, csv_text, html_table, shown
from .vtkSurfaceSynthesisMeshing import vtkTopologyReport

#: Properties that count defects, or possible ones.
DEFECTS = (
    "unreadable_cells",
    "cells_with_missing_points",
    "cells_with_too_few_points",
    "broken_vertices_and_lines",
    "non_finite_points",
    "cells_with_repeated_points",
    "uncuttable_polygons",
    "degenerate_triangles",
    "duplicate_triangles",
    "needle_triangles",
    "intersecting_triangles",
    "non_manifold_edges",
    "non_manifold_points",
    "inconsistent_winding_edges",
    "boundary_edges",
    "coincident_points",
    "unreferenced_points",
    "small_components",
)
_YES_OR_NO = ("valid", "closed", "manifold", "orientable", "consistent_winding")
_REAL = re.compile(
    r"area|volume|[xyz]_(minimum|maximum)|longest_boundary_loop|(edge_length|angle|aspect_ratio)_\w+"
)


def topology_report(mesh, component_rows=10, progress=None):
    """Description and defects of a surface: the first thing to run on data of unknown quality.

    A bad mesh is never an error here: broken cells are left out and the rest is measured.

    Parameters
    ----------
    mesh : vtkPolyData, composite dataset (vtkDataObjectTree) or pair (points, triangles)
        Any surface, however broken. A pair is an array of points [V, 3] and an integer array of triangles [F, 3]. The
        mesh is never modified.
    component_rows : int
        Number of components that are described one by one in a surface of several, those with most triangles first; at
        least 0. Default 10.
    progress : callable, optional
        Called with a fraction in [0, 1] that never decreases; when it returns False, the work stops.

    Returns
    -------
    TopologyReport
        A mapping from the name of a property to its value: ``report["genus"]``, ``report.get("volume")``. Names are
        those of vtkTopologyReport in lower case with underscores. A property that the surface does not have (the volume
        of an open one) has no entry. ``print(report)`` shows a table.
    BlockReports, for a composite dataset
        A mapping from the flat index of each block that is not empty to its TopologyReport.

    Raises
    ------
    SurfaceSynthesisError
        A block is no surface.
    Cancelled
        ``progress`` returned False.
    ValueError, TypeError
        An argument has a value out of its range or is of a wrong type.
    """
    algorithm = configured_filter(component_rows)
    progress_callback(progress)
    dataset = given_dataset(mesh)
    table, remarks = apply_filter(algorithm, dataset, progress)
    for text in remarks:
        warnings.warn(text, SurfaceSynthesisWarning, stacklevel=2)
    return report_of_table(table, dataset)


def configured_filter(component_rows=10):
    """A vtkTopologyReport with the parameters of topology_report(), which raises TypeError and ValueError."""
    algorithm = vtkTopologyReport()
    algorithm.SetNumberOfComponentRows(integer("component_rows", component_rows, 0))
    return algorithm


def report_of_table(table, dataset):
    """The result of topology_report(), from the filter's output for a dataset."""
    columns = [table.GetColumnByName(name) for name in ("Block", "Component", "Property", "Value", "First", "Remark")]
    rows = [tuple(column.GetValue(k) for column in columns) for k in range(table.GetNumberOfRows())]
    if not hasattr(dataset, "NewTreeIterator"):
        return TopologyReport(rows)
    blocks = dict.fromkeys(row[0] for row in rows)
    return BlockReports({block: TopologyReport([row for row in rows if row[0] == block]) for block in blocks})


def _snake(name):
    return re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower()


def _plain(name, value):
    """The value in its type: a truth, a real number or a count."""
    if name in _YES_OR_NO:
        return value > 0
    return value if _REAL.fullmatch(name) else int(value)


class TopologyReport(MappingResult):
    """The properties of one surface by name, as topology_report() finds them.

    ``components`` is a list of dictionaries with the properties of the components of a surface that has several, those
    with most triangles first; ``defects`` a dictionary with those counts of DEFECTS that are not 0.
    """

    def __init__(self, rows):
        self._rows = list(rows)
        self._values, self._firsts, self._remarks = {}, {}, {}
        components = {}
        for _, component, name, value, first, remark in self._rows:
            name = _snake(name)
            if component < 0:
                self._values[name] = _plain(name, value)
                self._firsts[name] = None if first < 0 else int(first)
                self._remarks[name] = remark
            else:
                components.setdefault(component, {"component": component})[name] = _plain(name, value)
        self.components = list(components.values())

    def __getitem__(self, name):
        if name == "sound":
            warn_renamed('report["sound"]', 'report["valid"]')
            name = "valid"
        return self._values[name]

    @property
    def valid(self):
        """True when remesh() accepts the surface and, where it is closed, tetrahedralize(): finite points, triangles with
        an area and without duplicates, manifold edges and points, consistent winding, no intersecting triangles. False
        for an empty surface."""
        return self.get("valid", False)

    @property
    def sound(self):
        """The former name of ``valid``."""
        warn_renamed("report.sound", "report.valid")
        return self.valid

    @property
    def defects(self):
        return {name: self[name] for name in DEFECTS if self.get(name)}

    def first(self, name):
        """The first cell or point that a property is about, or None."""
        return self._firsts[name]

    def remark(self, name):
        """Repair of a defect, units, explanations; may be empty."""
        return self._remarks[name]

    def to_csv(self):
        """All rows as comma-separated values, with a line of column names."""
        return _csv(self._rows)

    def to_dict(self):
        """The properties by name, the first cell or point of those that have one, the defects with their first cell or point
        and their repair, and the components, as to_json() writes them."""
        defects = {
            name: {"count": count, "first": self.first(name), "remark": self.remark(name)}
            for name, count in self.defects.items()
        }
        firsts = {name: first for name, first in self._firsts.items() if first is not None}
        return {"properties": dict(self), "firsts": firsts, "defects": defects, "components": self.components}

    def _lines(self):
        """Name, value, first cell or point and remark of each property that the table shows."""
        for name, value in self.items():
            if not value and (name in DEFECTS or name.endswith("_cells") or name == "longest_boundary_loop"):
                continue  # what there is none of
            first = "" if self.first(name) is None else f"first {self.first(name)}"
            remark = self.remark(name) if self.remark(name) not in ("yes", "no") else ""
            yield name.replace("_", " "), shown(value), first, remark

    def _component_lines(self):
        """Number and description of each component."""
        for component in self.components:
            parts = [f"{component['points']:,} points", f"{component['triangles']:,} triangles"]
            parts += [f"genus {component['genus']}"] if "genus" in component else []
            parts += [f"volume {component['volume']:.6g}"] if "volume" in component else ["open"]
            yield f"component {component['component']}", ", ".join(parts)

    def __str__(self):
        lines = [f"{name:<28} {value:>14}  {first:<14} {remark}".rstrip() for name, value, first, remark in self._lines()]
        lines += [f"{name}: {text}" for name, text in self._component_lines()]
        return "\n".join(lines) if lines else "empty"

    def _repr_html_(self):
        rows = [*self._lines(), *((name, text, "", "") for name, text in self._component_lines())]
        return html_table(rows, ("property", "value", "first", "remark"))

    def __repr__(self):
        return f"<TopologyReport: {'valid' if self.valid else 'not valid'}, {self.get('triangles', 0)} triangles>"


class BlockReports(Result, dict):
    """The reports of the blocks of a composite dataset, by flat index."""

    @property
    def valid(self):
        """True when every block is valid; False when there is none."""
        return bool(self) and all(report.valid for report in self.values())

    @property
    def sound(self):
        """The former name of ``valid``."""
        warn_renamed("reports.sound", "reports.valid")
        return self.valid

    def to_csv(self):
        """All rows of all blocks as comma-separated values, with a line of column names."""
        return _csv(row for report in self.values() for row in report._rows)

    def to_dict(self):
        """The reports of the blocks by flat index, as to_json() writes them."""
        return {"blocks": {block: report.to_dict() for block, report in self.items()}}

    def __str__(self):
        return "\n\n".join(f"block {block}\n{report}" for block, report in self.items()) or "empty"

    def _repr_html_(self):
        return "".join(f"<p>block {block}</p>{report._repr_html_()}" for block, report in self.items()) or "<p>empty</p>"


def _csv(rows):
    head = ["block", "component", "property", "value", "first", "remark"]
    return csv_text([head] + [
        [block, component, _snake(name), repr(_plain(_snake(name), value) + 0), first, remark]
        for block, component, name, value, first, remark in rows
    ])
