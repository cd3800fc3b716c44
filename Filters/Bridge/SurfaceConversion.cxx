// SPDX-License-Identifier: BSD-3-Clause
#include "SurfaceBridge.h"

#include "CellReading.h"
#include "PolygonTriangulation.h"

#include "Core/Common/Errors.h"
#include "Core/Common/LoopGrain.h"
#include "Core/Common/Parallel.h"

#include <vtkAOSDataArrayTemplate.h>
#include <vtkCellArray.h>
#include <vtkDataArray.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

#include <algorithm>
#include <limits>
#include <mutex>

namespace surfsynth
{

namespace
{
/// Number of ids of a range with a property, and the lowest of them.
struct Finding
{
  std::int64_t Count = 0;
  std::int64_t First = std::numeric_limits<std::int64_t>::max();

  void Add(const Finding& other)
  {
    this->Count += other.Count;
    this->First = std::min(this->First, other.First);
  }
  void AddId(std::int64_t id) { this->Add({ 1, id }); }
  std::string Text() const { return std::to_string(this->Count); }
};

/// Calls look(id, finding) for every id in [0, @p count), in parallel, and adds up the findings.
template <typename Look>
Finding Collect(std::int64_t count, const Look& look)
{
  Finding total;
  std::mutex mutex;
  ParallelFor(count, CoarseGrain, [&](std::int64_t begin, std::int64_t end) {
    Finding part;
    for (std::int64_t id = begin; id < end; ++id)
    {
      look(id, part);
    }
    std::lock_guard<std::mutex> lock(mutex);
    total.Add(part);
  });
  return total;
}

/// The same where a yes or no is enough for each id.
template <typename Predicate>
Finding CollectIf(std::int64_t count, const Predicate& hasProperty)
{
  return Collect(count, [&](std::int64_t id, Finding& part) {
    if (hasProperty(id))
    {
      part.AddId(id);
    }
  });
}

[[noreturn]] void Fail(MeshDefect defect, const Finding& finding, std::int64_t firstCell)
{
  throw InvalidInput("The mesh has " + DescribeFindings({ { defect, finding.Count, finding.First + firstCell } }));
}

/// The arrays of a vtkCellArray, with the id of its first cell in the polydata.
template <typename Id>
struct Cells
{
  const Id* Offsets = nullptr; ///< [Count + 1]
  const Id* Ids = nullptr;
  std::int64_t Count = 0;
  std::int64_t FirstCell = 0;

  const Id* Begin(std::int64_t cell) const { return this->Ids + this->Offsets[cell]; }
  std::int64_t Size(std::int64_t cell) const { return this->Offsets[cell + 1] - this->Offsets[cell]; }
};

/// The cells of a storage whose offsets and ids have been checked: everything below may follow them blindly.
/// @throws InvalidInput
template <typename Id>
Cells<Id> CheckedCells(
  vtkAOSDataArrayTemplate<Id>* offsets, vtkAOSDataArrayTemplate<Id>* ids, std::int64_t points, std::int64_t firstCell)
{
  Cells<Id> cells;
  cells.FirstCell = firstCell;
  cells.Count = std::max<std::int64_t>(offsets->GetNumberOfValues() - 1, 0);
  if (cells.Count == 0)
  {
    return cells;
  }
  cells.Offsets = offsets->GetPointer(0);
  cells.Ids = ids->GetPointer(0);
  const std::int64_t size = ids->GetNumberOfValues();
  const Finding broken = CollectIf(cells.Count, [&](std::int64_t c) {
    return cells.Offsets[c] < 0 || cells.Offsets[c + 1] < cells.Offsets[c] || cells.Offsets[c + 1] > size;
  });
  if (broken.Count > 0)
  {
    throw InvalidInput("The mesh has " + broken.Text() + " cell(s) whose offsets do not fit the " +
      std::to_string(size) + " entries of the connectivity, first cell " + std::to_string(broken.First + firstCell) +
      "; offsets must ascend from 0 to the number of entries. Write the dataset again with the program that made it.");
  }
  const Finding outOfRange = CollectIf(cells.Count, [&](std::int64_t c) {
    return std::any_of(cells.Begin(c), cells.Begin(c) + cells.Size(c),
      [points](Id id) { return id < 0 || static_cast<std::int64_t>(id) >= points; });
  });
  if (outOfRange.Count > 0)
  {
    Fail(MeshDefect::IndexOutOfRange, outOfRange, firstCell);
  }
  const Finding small = CollectIf(cells.Count, [&](std::int64_t c) { return cells.Size(c) < 3; });
  if (small.Count > 0)
  {
    throw InvalidInput("The mesh has " + small.Text() +
      " polygon(s) or strip(s) with fewer than three points, first cell " + std::to_string(small.First + firstCell) +
      "; vtkSurfaceRepairFilter leaves them out, vtkCleanPolyData turns them into lines and vertices.");
  }
  return cells;
}

/// Calls work(Cells<Id>) for the id type that @p array stores.
template <typename Work>
void WithCells(vtkCellArray* array, std::int64_t points, std::int64_t firstCell, const Work& work)
{
  if (CountCells(array) == 0)
  {
    return;
  }
  if (array->IsStorage64Bit())
  {
    work(CheckedCells<vtkTypeInt64>(array->GetOffsetsArray64(), array->GetConnectivityArray64(), points, firstCell));
  }
  else
  {
    work(CheckedCells<vtkTypeInt32>(array->GetOffsetsArray32(), array->GetConnectivityArray32(), points, firstCell));
  }
}

template <typename Id>
bool AllTriangles(const Cells<Id>& cells)
{
  return CollectIf(cells.Count, [&](std::int64_t c) { return cells.Size(c) != 3; }).Count == 0;
}

/// Makes room for @p more triangles and returns how many there were.
std::int64_t Grow(Surface& surface, std::int64_t more)
{
  const std::int64_t before = surface.Mesh.Triangles.rows();
  if (before + more > std::numeric_limits<Index>::max())
  {
    throw InvalidInput("The mesh has " + std::to_string(before + more) + " triangles; at most 2147483647 are allowed.");
  }
  surface.Mesh.Triangles.conservativeResize(before + more, 3);
  return before;
}

template <typename Id>
void CopyTriangles(const Cells<Id>& cells, Surface& surface)
{
  const std::int64_t before = Grow(surface, cells.Count);
  const Id* source = cells.Begin(0);
  Index* target = surface.Mesh.Triangles.data() + 3 * before;
  ParallelFor(3 * cells.Count, 3 * CoarseGrain, [&](std::int64_t begin, std::int64_t end) {
    std::transform(source + begin, source + end, target + begin, [](Id id) { return static_cast<Index>(id); });
  });
}

/// Records that the triangles of cell c are those from start[c] on.
void MapToCells(const std::vector<std::int64_t>& start, std::int64_t before, std::int64_t firstCell, Surface& surface)
{
  surface.CellOfTriangle.resize(static_cast<std::size_t>(surface.Mesh.Triangles.rows()));
  ParallelFor(static_cast<std::int64_t>(start.size()) - 1, CoarseGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t c = begin; c < end; ++c)
    {
      std::fill(surface.CellOfTriangle.begin() + before + start[c],
        surface.CellOfTriangle.begin() + before + start[c + 1], firstCell + c);
    }
  });
}

/// Running sums of count(cell): where the triangles of each cell start, and at the end how many there are.
template <typename CountOf>
std::vector<std::int64_t> TriangleStarts(std::int64_t cells, const CountOf& countOf)
{
  std::vector<std::int64_t> start(static_cast<std::size_t>(cells) + 1, 0);
  for (std::int64_t c = 0; c < cells; ++c)
  {
    start[c + 1] = start[c] + countOf(c);
  }
  return start;
}

template <typename Id>
bool RepeatsVertex(const Id* ids, std::int64_t count, std::vector<Id>& scratch)
{
  if (count == 3)
  {
    return ids[0] == ids[1] || ids[1] == ids[2] || ids[2] == ids[0];
  }
  scratch.assign(ids, ids + count);
  std::sort(scratch.begin(), scratch.end());
  return std::adjacent_find(scratch.begin(), scratch.end()) != scratch.end();
}

template <typename Id>
void RequireDistinctVertices(const Cells<Id>& cells)
{
  Finding repeated;
  std::mutex mutex;
  ParallelFor(cells.Count, CoarseGrain, [&](std::int64_t begin, std::int64_t end) {
    Finding part;
    std::vector<Id> scratch;
    for (std::int64_t c = begin; c < end; ++c)
    {
      if (RepeatsVertex(cells.Begin(c), cells.Size(c), scratch))
      {
        part.AddId(c);
      }
    }
    std::lock_guard<std::mutex> lock(mutex);
    repeated.Add(part);
  });
  if (repeated.Count > 0)
  {
    Fail(MeshDefect::RepeatedVertex, repeated, cells.FirstCell);
  }
}

template <typename Id>
void AddPolygons(const Cells<Id>& cells, Surface& surface)
{
  RequireDistinctVertices(cells);
  const auto start = TriangleStarts(cells.Count, [&](std::int64_t c) { return cells.Size(c) - 2; });
  const std::int64_t before = Grow(surface, start.back());
  Finding uncut;
  std::mutex mutex;
  ParallelFor(cells.Count, CoarseGrain, [&](std::int64_t begin, std::int64_t end) {
    Finding part;
    PolygonTriangulator triangulator;
    std::vector<Index> ids;
    for (std::int64_t c = begin; c < end; ++c)
    {
      ids.assign(cells.Begin(c), cells.Begin(c) + cells.Size(c));
      Index* target = surface.Mesh.Triangles.data() + 3 * (before + start[c]);
      if (!triangulator.Triangulate(surface.Mesh.Points, ids.data(), static_cast<Index>(ids.size()), target))
      {
        part.AddId(c);
      }
    }
    std::lock_guard<std::mutex> lock(mutex);
    uncut.Add(part);
  });
  if (uncut.Count > 0)
  {
    throw InvalidInput("The mesh has " + uncut.Text() +
      " polygon(s) that cannot be triangulated (without area, or with an outline that crosses itself), first cell " +
      std::to_string(uncut.First + cells.FirstCell) +
      "; vtkSurfaceRepairFilter, or vtkCleanPolyData followed by vtkTriangleFilter, replaces or drops them.");
  }
  MapToCells(start, before, cells.FirstCell, surface);
}

/// Unrolls strips. Triangles that use a vertex twice only join the parts of a strip and are left out.
template <typename Id>
void AddStrips(const Cells<Id>& cells, Surface& surface)
{
  const auto unroll = [&](std::int64_t c, Index* target) {
    const Id* ids = cells.Begin(c);
    std::int64_t written = 0;
    for (std::int64_t k = 0; k + 2 < cells.Size(c); ++k)
    {
      if (ids[k] == ids[k + 1] || ids[k + 1] == ids[k + 2] || ids[k + 2] == ids[k])
      {
        continue;
      }
      if (target)
      {
        target[3 * written] = static_cast<Index>(ids[k % 2 == 0 ? k : k + 1]);
        target[3 * written + 1] = static_cast<Index>(ids[k % 2 == 0 ? k + 1 : k]);
        target[3 * written + 2] = static_cast<Index>(ids[k + 2]);
      }
      ++written;
    }
    return written;
  };
  const auto start = TriangleStarts(cells.Count, [&](std::int64_t c) { return unroll(c, nullptr); });
  const std::int64_t before = Grow(surface, start.back());
  ParallelFor(cells.Count, CoarseGrain / 8, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t c = begin; c < end; ++c)
    {
      unroll(c, surface.Mesh.Triangles.data() + 3 * (before + start[c]));
    }
  });
  MapToCells(start, before, cells.FirstCell, surface);
}

template <typename Value>
bool CopyPoints(vtkDataArray* array, PointMatrix& points)
{
  auto* typed = vtkAOSDataArrayTemplate<Value>::FastDownCast(array);
  if (!typed)
  {
    return false;
  }
  const Value* source = typed->GetPointer(0);
  double* target = points.data();
  ParallelFor(points.size(), 3 * CoarseGrain,
    [&](std::int64_t begin, std::int64_t end) { std::copy(source + begin, source + end, target + begin); });
  return true;
}

void ConvertCells(vtkPolyData* input, Surface& surface)
{
  const std::int64_t points = surface.Mesh.NumberOfPoints();
  const std::int64_t polygons = CountCells(input->GetPolys());
  const std::int64_t strips = CountCells(input->GetStrips());
  const std::int64_t firstPolygon = CountCells(input->GetVerts()) + CountCells(input->GetLines());
  if (polygons + strips == 0)
  {
    throw InvalidInput("The input has " + std::to_string(points) + " points and " + std::to_string(firstPolygon) +
      " vertices and lines but no polygon; vtkDelaunay2D or vtkSurfaceReconstructionFilter builds a surface.");
  }
  WithCells(input->GetPolys(), points, firstPolygon, [&](const auto& cells) {
    const bool triangles = AllTriangles(cells);
    if (triangles && firstPolygon == 0 && strips == 0)
    {
      CopyTriangles(cells, surface); // triangle f is cell f
    }
    else
    {
      AddPolygons(cells, surface);
    }
  });
  WithCells(input->GetStrips(), points, firstPolygon + polygons, [&](const auto& cells) { AddStrips(cells, surface); });
  if (surface.Mesh.NumberOfTriangles() == 0)
  {
    throw InvalidInput("The input has " + std::to_string(strips) +
      " strip(s) but none with a triangle of three different points; vtkCleanPolyData removes them.");
  }
}
} // namespace

PointMatrix ConvertPoints(vtkPolyData* input)
{
  vtkDataArray* array = input->GetPoints() ? input->GetPoints()->GetData() : nullptr;
  const std::int64_t count = array ? array->GetNumberOfTuples() : 0;
  if (array && array->GetNumberOfComponents() != 3)
  {
    throw InvalidInput("The points have " + std::to_string(array->GetNumberOfComponents()) +
      " coordinates each; 3 are needed. Write the dataset again with the program that made it.");
  }
  if (count > std::numeric_limits<Index>::max())
  {
    throw InvalidInput("The mesh has " + std::to_string(count) + " points; at most 2147483647 are allowed.");
  }
  PointMatrix points(count, 3);
  if (count > 0 && !CopyPoints<double>(array, points) && !CopyPoints<float>(array, points))
  {
    for (std::int64_t p = 0; p < count; ++p)
    {
      array->GetTuple(p, points.row(p).data());
    }
  }
  return points;
}

Surface ConvertSurface(vtkPolyData* input)
{
  if (!input)
  {
    throw InvalidInput("There is no input; a vtkPolyData is needed.");
  }
  Surface surface;
  surface.Mesh.Points = ConvertPoints(input);
  ConvertCells(input, surface);
  return surface;
}

void CheckSurface(Surface& surface, const MeshRequirements& requirements)
{
  surface.Topology.emplace(
    RequireValidMesh(surface.Mesh, requirements, [&](std::int64_t f) { return surface.Cell(f); }));
}

Surface ToSurface(vtkPolyData* input, const MeshRequirements& requirements)
{
  Surface surface = ConvertSurface(input);
  CheckSurface(surface, requirements);
  return surface;
}

} // namespace surfsynth
