// SPDX-License-Identifier: BSD-3-Clause
#include "UncheckedSurface.h"

#include "CellReading.h"
#include "PolygonTriangulation.h"

#include "Core/Common/Errors.h"

#include <vtkPolyData.h>

#include <algorithm>
#include <limits>
#include <vector>

namespace surfsynth
{

namespace
{
/// Collects triangles cell by cell.
class UncheckedConversion
{
public:
  explicit UncheckedConversion(UncheckedSurface& result)
    : Result(result)
    , Points(result.Usable.Mesh.Points)
    , IsFinite(static_cast<std::size_t>(this->Points.rows()), true)
  {
    for (Eigen::Index p = 0; p < this->Points.rows(); ++p)
    {
      if (!this->Points.row(p).allFinite())
      {
        this->IsFinite[p] = false;
        this->Points.row(p).setZero();
        ++result.Losses.NonFinitePoints;
      }
    }
  }

  /// Adds the polygons or strips of @p cells, of which the first has the id @p firstCell.
  void AddCells(vtkCellArray* cells, bool areStrips, std::int64_t firstCell)
  {
    EachCell(cells, [&](std::int64_t cell, const auto* ids, std::int64_t size) {
      if (size < 0 || !InRange(ids, size, this->Points.rows()))
      {
        ++this->Result.Losses.CellsOutOfRange;
        return;
      }
      this->Cell.assign(ids, ids + size);
      areStrips ? this->AddStrip(firstCell + cell) : this->AddPolygon(firstCell + cell);
    });
  }

  void Finish()
  {
    auto& triangles = this->Result.Usable.Mesh.Triangles;
    triangles = Eigen::Map<const TriangleMatrix>(this->Ids.data(), static_cast<Eigen::Index>(this->Ids.size() / 3), 3);
  }

private:
  bool CellIsFinite() const
  {
    return std::all_of(this->Cell.begin(), this->Cell.end(), [&](Index id) { return this->IsFinite[id]; });
  }

  void AddStrip(std::int64_t cell)
  {
    const std::size_t before = this->Ids.size();
    bool lost = false;
    for (std::size_t k = 0; k + 2 < this->Cell.size(); ++k)
    {
      const Index a = this->Cell[k % 2 == 0 ? k : k + 1];
      const Index b = this->Cell[k % 2 == 0 ? k + 1 : k];
      const Index c = this->Cell[k + 2];
      const bool isFinite = this->IsFinite[a] && this->IsFinite[b] && this->IsFinite[c];
      lost = lost || !isFinite;
      if (isFinite && a != b && b != c && c != a) // the others join the parts of a strip
      {
        this->AddTriangle(a, b, c, cell);
      }
    }
    this->Result.Losses.CellsNotFinite += lost ? 1 : 0;
    this->Result.Losses.CellsTooSmall += !lost && this->Ids.size() == before ? 1 : 0;
  }

  void AddPolygon(std::int64_t cell)
  {
    const std::size_t before = this->Cell.size();
    // Each point once, at its first place: what comes back to a point twice is no simple outline.
    std::size_t kept = 0;
    for (std::size_t k = 0; k < before; ++k)
    {
      if (std::find(this->Cell.begin(), this->Cell.begin() + kept, this->Cell[k]) == this->Cell.begin() + kept)
      {
        this->Cell[kept++] = this->Cell[k];
      }
    }
    this->Cell.resize(kept);
    if (kept < 3)
    {
      ++this->Result.Losses.CellsTooSmall;
      return;
    }
    if (!this->CellIsFinite())
    {
      ++this->Result.Losses.CellsNotFinite;
      return;
    }
    this->Result.Losses.RepeatedPoints += kept < before ? 1 : 0;
    this->CutPolygon(cell);
  }

  void CutPolygon(std::int64_t cell)
  {
    if (this->Cell.size() == 3)
    {
      this->AddTriangle(this->Cell[0], this->Cell[1], this->Cell[2], cell);
      return;
    }
    const std::size_t count = this->Cell.size() - 2;
    this->Cut.resize(3 * count);
    if (!this->Triangulator.Triangulate(
          this->Points, this->Cell.data(), static_cast<Index>(this->Cell.size()), this->Cut.data()))
    {
      ++this->Result.Losses.PolygonsNotSimple;
      for (std::size_t k = 0; k < count; ++k)
      {
        this->Cut[3 * k] = this->Cell[0];
        this->Cut[3 * k + 1] = this->Cell[k + 1];
        this->Cut[3 * k + 2] = this->Cell[k + 2];
      }
    }
    for (std::size_t k = 0; k < count; ++k)
    {
      this->AddTriangle(this->Cut[3 * k], this->Cut[3 * k + 1], this->Cut[3 * k + 2], cell);
    }
  }

  void AddTriangle(Index a, Index b, Index c, std::int64_t cell)
  {
    if (this->Result.Usable.CellOfTriangle.size() >= static_cast<std::size_t>(std::numeric_limits<Index>::max()))
    {
      throw InvalidInput("The mesh has more than 2147483647 triangles; at most so many are allowed.");
    }
    this->Ids.insert(this->Ids.end(), { a, b, c });
    this->Result.Usable.CellOfTriangle.push_back(cell);
  }

  UncheckedSurface& Result;
  PointMatrix& Points;
  std::vector<bool> IsFinite;
  std::vector<Index> Ids;
  std::vector<Index> Cell;
  std::vector<Index> Cut;
  PolygonTriangulator Triangulator;
};
} // namespace

UncheckedSurface ConvertUnchecked(vtkPolyData* input)
{
  UncheckedSurface result;
  result.Usable.Mesh.Points = ConvertPoints(input);
  UncheckedConversion conversion(result);
  const std::int64_t firstPolygon = CountCells(input->GetVerts()) + CountCells(input->GetLines());
  conversion.AddCells(input->GetPolys(), false, firstPolygon);
  conversion.AddCells(input->GetStrips(), true, firstPolygon + CountCells(input->GetPolys()));
  conversion.Finish();
  return result;
}

} // namespace surfsynth
