// SPDX-License-Identifier: BSD-3-Clause
#include "TopologyRows.h"

#include "SurfaceInspection.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace surfsynth
{

namespace
{
const char* const WriteAgain = "the dataset is inconsistent: write it again with the program that made it.";

/// Collects the rows of one surface.
class RowWriter
{
public:
  RowWriter(unsigned int block, const InspectedSurface& surface, const MeshStatistics& statistics,
    const IntersectingTriangles& intersecting)
    : Block(block)
    , Surface(surface)
    , Statistics(statistics)
    , Intersecting(intersecting)
  {}

  void Defects();
  void Validity();
  void Intersections();
  void Counts();
  void Topology();
  void Sizes();
  void Shapes();
  void Components(int count);

  std::vector<ReportRow> Rows;

private:
  void Add(const std::string& property, double value, const std::string& remark = {}, std::int64_t first = -1)
  {
    if (std::isfinite(value)) // an area of coordinates beyond 1e154 is no number
    {
      this->Rows.push_back({ this->Block, this->Component, property, value, first, remark });
    }
  }
  void Add(const std::string& property, std::int64_t value, const std::string& remark = {}, std::int64_t first = -1)
  {
    this->Add(property, static_cast<double>(value), remark, first);
  }
  void AddYesOrNo(const std::string& property, bool value, const std::string& remark = {})
  {
    this->Add(property, value ? 1.0 : 0.0, remark.empty() ? (value ? "yes" : "no") : remark);
  }

  /// Adds a count of defects; without remark and first id when it is 0.
  void AddDefect(const std::string& property, std::int64_t count, std::int64_t first, const std::string& remark)
  {
    this->Add(property, static_cast<double>(count), count > 0 ? remark : "", count > 0 ? first : -1);
  }
  void AddFault(const std::string& property, const CellFault& fault, const std::string& remark)
  {
    this->AddDefect(property, fault.Count, fault.First, remark);
  }
  void AddFinding(const std::string& property, MeshDefect defect, CellFault fault = {});

  std::int64_t CellOf(std::int64_t triangle) const { return this->Surface.CellOfTriangle[triangle]; }

  unsigned int Block;
  int Component = -1;
  const InspectedSurface& Surface;
  const MeshStatistics& Statistics;
  const IntersectingTriangles& Intersecting;
};

/// Adds a kind of defect of the triangles, with the cells that already had it as polygons.
void RowWriter::AddFinding(const std::string& property, MeshDefect defect, CellFault fault)
{
  for (const MeshFinding& finding : this->Statistics.Findings)
  {
    if (finding.Defect == defect)
    {
      const std::int64_t first = HasTriangleIds(defect) ? this->CellOf(finding.First) : finding.First;
      fault.First = fault.Count > 0 ? std::min(fault.First, first) : first;
      fault.Count += finding.Count;
    }
  }
  this->AddFault(property, fault, RepairOf(defect));
}

void RowWriter::Validity()
{
  if (!IsValid(this->Surface, this->Statistics, this->Intersecting))
  {
    this->AddYesOrNo("Valid", false, "no: the rows below with a remark name the defects");
    return;
  }
  this->AddYesOrNo(
    "Valid", true, this->Statistics.Closed() ? "" : "yes, as an open surface: tetrahedra need a closed one");
}

void RowWriter::Intersections()
{
  const MeshFinding& needles = this->Statistics.NeedleTriangles;
  this->AddDefect("NeedleTriangles", needles.Count, needles.Count > 0 ? this->CellOf(needles.First) : -1,
    "an angle below 1 degree; vtkIsotropicRemeshFilter makes triangles of even shape.");
  if (this->Intersecting)
  {
    const auto count = static_cast<std::int64_t>(this->Intersecting->size());
    this->AddDefect("IntersectingTriangles", count, count > 0 ? this->CellOf(this->Intersecting->front()) : -1,
      "vtkSurfaceRepairFilter with RemoveSelfIntersectionsOn() replaces them, vtkVDBSurfaceFilter makes a closed "
      "surface without them.");
  }
}

void RowWriter::Defects()
{
  this->Validity();
  if (this->Surface.PointComponents != 3)
  {
    this->Add("PointComponents", static_cast<std::int64_t>(this->Surface.PointComponents),
      std::string("points have three coordinates; ") + WriteAgain);
  }
  this->AddFault("UnreadableCells", this->Surface.Unreadable, WriteAgain);
  this->AddFault("CellsWithMissingPoints", this->Surface.OutOfRange, RepairOf(MeshDefect::IndexOutOfRange));
  this->AddFault("CellsWithTooFewPoints", this->Surface.TooFewPoints,
    "vtkSurfaceRepairFilter leaves them out, vtkCleanPolyData turns them into lines and vertices.");
  this->AddFault("BrokenVerticesAndLines", this->Surface.IgnoredCells,
    std::string("filters on surfaces ignore them; ") + WriteAgain);
  this->AddFinding("NonFinitePoints", MeshDefect::NonFinitePoint);
  this->AddFinding("CellsWithRepeatedPoints", MeshDefect::RepeatedVertex, this->Surface.RepeatedPoint);
  this->AddFault("UncuttablePolygons", this->Surface.Uncut,
    "without area, or with an outline that crosses itself; vtkCleanPolyData followed by vtkTriangleFilter replaces or "
    "drops them.");
  this->AddFinding("DegenerateTriangles", MeshDefect::DegenerateTriangle);
  const MeshFinding& duplicates = this->Statistics.DuplicateTriangles;
  this->AddDefect("DuplicateTriangles", duplicates.Count, duplicates.Count > 0 ? this->CellOf(duplicates.First) : -1,
    "vtkSurfaceRepairFilter or vtkCleanPolyData removes duplicate cells.");
  this->Intersections();
  this->AddFinding("NonManifoldEdges", MeshDefect::NonManifoldEdge);
  this->AddFinding("NonManifoldPoints", MeshDefect::NonManifoldVertex);
  this->AddFinding("InconsistentWindingEdges", MeshDefect::InconsistentWinding);
  this->AddFinding("BoundaryEdges", MeshDefect::BoundaryEdge);
  this->AddDefect("CoincidentPoints", this->Statistics.CoincidentPoints.Count, this->Statistics.CoincidentPoints.First,
    "vtkSurfaceRepairFilter or vtkCleanPolyData merges points in one place.");
  this->AddDefect("UnreferencedPoints", this->Statistics.UnreferencedPoints.Count,
    this->Statistics.UnreferencedPoints.First,
    "no triangle uses them; vtkSurfaceRepairFilter or vtkCleanPolyData removes them.");
  this->AddDefect("SmallComponents", this->Statistics.SmallComponents.Count, this->Statistics.SmallComponents.First,
    "fewer than 1 % of the triangles of the largest one; vtkSurfaceRepairFilter with a MinimumComponentFraction "
    "removes them.");
}

void RowWriter::Counts()
{
  this->Add("Points", this->Surface.Points);
  this->Add("UsedPoints", this->Statistics.UsedPoints);
  this->Add("VertexCells", this->Surface.Vertices);
  this->Add("LineCells", this->Surface.Lines);
  this->Add("TriangleCells", this->Surface.Triangles);
  this->Add("QuadCells", this->Surface.Quads);
  this->Add("PolygonCells", this->Surface.Polygons);
  this->Add("StripCells", this->Surface.Strips);
  const bool partial = this->Statistics.ProperTriangles < this->Statistics.Triangles;
  const bool leftOut = this->Surface.Unreadable.Count + this->Surface.OutOfRange.Count +
      this->Surface.TooFewPoints.Count + this->Surface.RepeatedPoint.Count + this->Surface.Uncut.Count >
    0;
  this->Add("Triangles", this->Statistics.ProperTriangles,
    partial || leftOut ? "the valid part, to which all rows below refer: broken cells are left out" : "");
  this->Add("Edges", this->Statistics.Edges);
}

void RowWriter::Topology()
{
  this->AddFinding("Components", MeshDefect::SeveralComponents);
  this->Rows.back().Value = static_cast<double>(this->Statistics.Components.size());
  if (this->Statistics.Components.empty())
  {
    return;
  }
  this->Add("EulerCharacteristic", this->Statistics.EulerCharacteristic());
  if (const auto genus = this->Statistics.Genus())
  {
    this->Add("Genus", *genus, this->Statistics.Components.size() > 1 ? "the sum over the components" : "");
  }
  this->Add("BoundaryLoops", this->Statistics.BoundaryLoops);
  this->AddDefect("LongestBoundaryLoop", 0, -1, "");
  if (this->Statistics.BoundaryLoops > 0)
  {
    this->Rows.back().Value = this->Statistics.LongestBoundaryLoop;
    this->Rows.back().First = this->Statistics.LongestBoundaryLoopPoint;
  }
  this->AddYesOrNo("Closed", this->Statistics.Closed());
  this->AddYesOrNo("Manifold", this->Statistics.Manifold());
  this->AddYesOrNo("Orientable", this->Statistics.Orientable());
  this->AddYesOrNo("ConsistentWinding", this->Statistics.ConsistentWinding());
}

void RowWriter::Sizes()
{
  if (this->Statistics.Components.empty())
  {
    return;
  }
  this->Add("Area", this->Statistics.Area);
  if (const auto volume = this->Statistics.Volume())
  {
    this->Add("Volume", *volume, *volume < 0.0 ? "wound inwards; vtkReverseSense turns all cells" : "");
  }
  const char* const axes = "XYZ";
  for (int axis = 0; axis < 3; ++axis)
  {
    this->Add(std::string(1, axes[axis]) + "Minimum", this->Statistics.Box.Lower[axis]);
    this->Add(std::string(1, axes[axis]) + "Maximum", this->Statistics.Box.Upper[axis]);
  }
}

void RowWriter::Shapes()
{
  const Distribution& edges = this->Statistics.EdgeLength;
  if (edges.Count > 0)
  {
    this->Add("EdgeLengthMinimum", edges.Minimum, "", edges.AtMinimum);
    this->Add("EdgeLengthMean", edges.Mean);
    this->Add("EdgeLengthMedian", edges.Median);
    this->Add("EdgeLengthMaximum", edges.Maximum, "", edges.AtMaximum);
  }
  const Distribution& smallest = this->Statistics.SmallestAngle;
  if (smallest.Count > 0)
  {
    const Distribution& largest = this->Statistics.LargestAngle;
    const Distribution& aspect = this->Statistics.AspectRatio;
    this->Add("AngleMinimum", smallest.Minimum, "degrees", this->CellOf(smallest.AtMinimum));
    this->Add("AngleMaximum", largest.Maximum, "degrees", this->CellOf(largest.AtMaximum));
    this->Add("AngleMeanMinimum", smallest.Mean, "degrees; the mean of each triangle's smallest angle");
    this->Add("AspectRatioMean", aspect.Mean, "1 for an equilateral triangle");
    this->Add("AspectRatioMaximum", aspect.Maximum, "", this->CellOf(aspect.AtMaximum));
  }
}

void RowWriter::Components(int count)
{
  const auto& components = this->Statistics.Components;
  if (components.size() < 2)
  {
    return;
  }
  std::vector<int> order(components.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(
    order.begin(), order.end(), [&](int a, int b) { return components[a].Triangles > components[b].Triangles; });
  order.resize(std::min<std::size_t>(order.size(), static_cast<std::size_t>(count)));
  for (const int c : order)
  {
    const ComponentStatistics& component = components[c];
    this->Component = c;
    this->Add("Points", component.Points, "", component.FirstPoint);
    this->Add("Triangles", component.Triangles);
    this->Add("EulerCharacteristic", component.EulerCharacteristic);
    if (component.Genus)
    {
      this->Add("Genus", *component.Genus);
    }
    this->Add("BoundaryLoops", component.BoundaryLoops);
    this->AddYesOrNo("Closed", component.Closed);
    this->AddYesOrNo("ConsistentWinding", component.ConsistentWinding);
    this->Add("Area", component.Area);
    if (component.Volume)
    {
      this->Add("Volume", *component.Volume, *component.Volume < 0.0 ? "wound inwards" : "");
    }
  }
  this->Component = -1;
}
} // namespace

bool IsValid(
  const InspectedSurface& surface, const MeshStatistics& statistics, const IntersectingTriangles& intersecting)
{
  const std::int64_t faults = surface.Unreadable.Count + surface.OutOfRange.Count + surface.TooFewPoints.Count +
    surface.RepeatedPoint.Count + surface.Uncut.Count;
  const auto breaks = [](const MeshFinding& finding) { return finding.Defect < MeshDefect::BoundaryEdge; };
  return faults == 0 && statistics.DuplicateTriangles.Count == 0 && !(intersecting && !intersecting->empty()) &&
    surface.PointComponents == 3 && statistics.ProperTriangles > 0 &&
    std::none_of(statistics.Findings.begin(), statistics.Findings.end(), breaks);
}

std::vector<ReportRow> ReportRows(unsigned int block, const InspectedSurface& surface, const MeshStatistics& statistics,
  const IntersectingTriangles& intersecting, int components)
{
  RowWriter writer(block, surface, statistics, intersecting);
  writer.Defects();
  writer.Counts();
  writer.Topology();
  writer.Sizes();
  writer.Shapes();
  writer.Components(components);
  return writer.Rows;
}

} // namespace surfsynth
