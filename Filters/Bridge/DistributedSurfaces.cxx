// SPDX-License-Identifier: BSD-3-Clause
#include "DistributedSurfaces.h"

#include <vtkCellArray.h>
#include <vtkCellArrayIterator.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDataSetAttributes.h>
#include <vtkIdTypeArray.h>
#include <vtkMultiProcessController.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>

namespace surfsynth
{

vtkMultiProcessController* Ranks::Several()
{
  vtkMultiProcessController* controller = vtkMultiProcessController::GetGlobalController();
  return controller && controller->GetNumberOfProcesses() > 1 ? controller : nullptr;
}

int Ranks::Rank() const { return this->Controller ? this->Controller->GetLocalProcessId() : 0; }

int Ranks::Count() const { return this->Controller ? this->Controller->GetNumberOfProcesses() : 1; }

std::vector<std::vector<std::int64_t>> Ranks::Gather(const std::vector<std::int64_t>& values) const
{
  if (!this->Controller)
  {
    return { values };
  }
  const std::size_t length = values.size();
  const std::vector<long long> mine(values.begin(), values.end());
  std::vector<long long> all(length * static_cast<std::size_t>(this->Count()));
  if (length > 0)
  {
    this->Controller->AllGather(mine.data(), all.data(), static_cast<vtkIdType>(length));
  }
  std::vector<std::vector<std::int64_t>> ofRank;
  for (int rank = 0; rank < this->Count(); ++rank)
  {
    const auto begin = all.begin() + static_cast<std::ptrdiff_t>(length) * rank;
    ofRank.emplace_back(begin, begin + static_cast<std::ptrdiff_t>(length));
  }
  return ofRank;
}

std::string Ranks::FirstText(const std::string& text) const
{
  if (!this->Controller)
  {
    return text;
  }
  const auto lengths = this->Gather({ static_cast<std::int64_t>(text.size()) });
  for (int rank = 0; rank < this->Count(); ++rank)
  {
    if (lengths[rank][0] > 0)
    {
      std::string first = text;
      first.resize(static_cast<std::size_t>(lengths[rank][0]));
      this->Controller->Broadcast(&first[0], lengths[rank][0], rank);
      return first;
    }
  }
  return {};
}

vtkSmartPointer<vtkDataArray> Ranks::Share(vtkDataArray* array, int source) const
{
  if (!this->Controller)
  {
    return array;
  }
  const bool isSource = this->Rank() == source;
  std::string name = isSource && array->GetName() ? array->GetName() : "";
  const std::int64_t type = isSource ? array->GetDataType() : 0;
  const std::vector<std::int64_t> facts = this->Gather({ static_cast<std::int64_t>(name.size()), type })[source];
  name.resize(static_cast<std::size_t>(facts[0]));
  if (!name.empty())
  {
    this->Controller->Broadcast(&name[0], facts[0], source);
  }
  vtkSmartPointer<vtkDataArray> shared = array;
  if (!isSource)
  {
    shared = vtk::TakeSmartPointer(vtkDataArray::CreateDataArray(static_cast<int>(facts[1])));
  }
  this->Controller->Broadcast(shared, source);
  shared->SetName(name.c_str());
  return shared;
}

void Ranks::Broadcast(vtkPolyData* polydata, int source) const
{
  if (this->Controller)
  {
    this->Controller->Broadcast(polydata, source);
  }
}

namespace
{
/// Appends the cells of @p source to @p target that are not ghosts, and their global ids to @p targetIds where there
/// are any. @p firstCell is the id of the first cell in the polydata.
void CopyCells(vtkCellArray* source, vtkIdType firstCell, vtkUnsignedCharArray* ghosts, vtkDataArray* sourceIds,
  vtkCellArray* target, vtkIdTypeArray* targetIds)
{
  const auto cells = vtk::TakeSmartPointer(source->NewIterator());
  for (cells->GoToFirstCell(); !cells->IsDoneWithTraversal(); cells->GoToNextCell())
  {
    const vtkIdType cell = firstCell + cells->GetCurrentCellId();
    if (ghosts && (ghosts->GetValue(cell) & vtkDataSetAttributes::DUPLICATECELL) != 0)
    {
      continue;
    }
    target->InsertNextCell(cells->GetCurrentCell());
    if (sourceIds)
    {
      targetIds->InsertNextValue(static_cast<vtkIdType>(sourceIds->GetTuple1(cell)));
    }
  }
}

bool Fits(vtkDataArray* array, vtkIdType tuples)
{
  return array && array->GetNumberOfTuples() == tuples && array->GetNumberOfComponents() == 1;
}

std::int64_t Surfaces(vtkPolyData* piece) { return piece->GetNumberOfPolys() + piece->GetNumberOfStrips(); }

using PieceList = std::vector<vtkSmartPointer<vtkPolyData>>;

/// For each piece, the id in the whole of each of its points; and where in the pieces each point of the whole comes
/// from.
struct PointMerge
{
  std::vector<std::vector<std::int64_t>> WholeOfPiece;
  std::vector<std::pair<std::size_t, vtkIdType>> Source;
};

PointMerge MergeByGlobalId(const PieceList& pieces)
{
  std::map<vtkIdType, std::pair<std::size_t, vtkIdType>> sourceOfId;
  for (std::size_t p = 0; p < pieces.size(); ++p)
  {
    vtkDataArray* ids = pieces[p]->GetPointData()->GetGlobalIds();
    for (vtkIdType k = 0; k < pieces[p]->GetNumberOfPoints(); ++k)
    {
      sourceOfId.emplace(static_cast<vtkIdType>(ids->GetTuple1(k)), std::make_pair(p, k));
    }
  }
  PointMerge merge;
  std::map<vtkIdType, std::int64_t> wholeOfId;
  for (const auto& entry : sourceOfId)
  {
    wholeOfId.emplace_hint(wholeOfId.end(), entry.first, static_cast<std::int64_t>(merge.Source.size()));
    merge.Source.push_back(entry.second);
  }
  for (const auto& piece : pieces)
  {
    std::vector<std::int64_t> whole;
    for (vtkIdType k = 0; k < piece->GetNumberOfPoints(); ++k)
    {
      whole.push_back(wholeOfId.at(static_cast<vtkIdType>(piece->GetPointData()->GetGlobalIds()->GetTuple1(k))));
    }
    merge.WholeOfPiece.push_back(std::move(whole));
  }
  return merge;
}

PointMerge MergeByCoordinates(const PieceList& pieces)
{
  PointMerge merge;
  std::map<std::array<double, 3>, std::int64_t> earlier;
  for (std::size_t p = 0; p < pieces.size(); ++p)
  {
    std::vector<std::int64_t> whole;
    std::map<std::array<double, 3>, std::int64_t> own;
    for (vtkIdType k = 0; k < pieces[p]->GetNumberOfPoints(); ++k)
    {
      std::array<double, 3> x;
      pieces[p]->GetPoint(k, x.data());
      const bool comparable = std::none_of(x.begin(), x.end(), [](double value) { return value != value; });
      const auto found = comparable ? earlier.find(x) : earlier.end();
      if (found != earlier.end())
      {
        whole.push_back(found->second);
        continue;
      }
      whole.push_back(static_cast<std::int64_t>(merge.Source.size()));
      merge.Source.emplace_back(p, k);
      if (comparable)
      {
        own.emplace(x, whole.back());
      }
    }
    earlier.insert(own.begin(), own.end());
    merge.WholeOfPiece.push_back(std::move(whole));
  }
  return merge;
}

/// A cell of a piece in the ids of the whole.
struct MergedCell
{
  std::int64_t GlobalId;
  std::vector<vtkIdType> Points;
};

/// Appends the cells of @p source, leaving out those that @p known holds from other pieces.
void MergeCells(vtkCellArray* source, vtkDataArray* globalIds, vtkIdType firstCell,
  const std::vector<std::int64_t>& wholeOfPiece, const std::set<std::vector<vtkIdType>>& known,
  std::set<std::vector<vtkIdType>>& added, std::vector<MergedCell>& cells)
{
  const auto iterator = vtk::TakeSmartPointer(source->NewIterator());
  const auto points = static_cast<vtkIdType>(wholeOfPiece.size());
  for (iterator->GoToFirstCell(); !iterator->IsDoneWithTraversal(); iterator->GoToNextCell())
  {
    vtkIdList* ids = iterator->GetCurrentCell();
    MergedCell cell;
    for (vtkIdType k = 0; k < ids->GetNumberOfIds(); ++k)
    {
      // An id that does not exist stays one, for the check of the whole to find.
      const vtkIdType id = ids->GetId(k);
      cell.Points.push_back(id >= 0 && id < points ? wholeOfPiece[id] : -1);
    }
    std::vector<vtkIdType> key = cell.Points;
    std::sort(key.begin(), key.end());
    if (known.count(key) > 0)
    {
      continue;
    }
    added.insert(std::move(key));
    cell.GlobalId = globalIds
      ? static_cast<std::int64_t>(globalIds->GetTuple1(firstCell + iterator->GetCurrentCellId()))
      : 0;
    cells.push_back(std::move(cell));
  }
}

vtkSmartPointer<vtkCellArray> ToCellArray(std::vector<MergedCell>& cells, bool sort)
{
  if (sort)
  {
    std::stable_sort(
      cells.begin(), cells.end(), [](const MergedCell& a, const MergedCell& b) { return a.GlobalId < b.GlobalId; });
  }
  auto array = vtkSmartPointer<vtkCellArray>::New();
  for (const MergedCell& cell : cells)
  {
    array->InsertNextCell(static_cast<vtkIdType>(cell.Points.size()), cell.Points.data());
  }
  return array;
}

vtkSmartPointer<vtkPolyData> Merge(const PieceList& pieces, const PointMerge& merge, bool byGlobalCellId)
{
  auto whole = vtkSmartPointer<vtkPolyData>::New();
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(static_cast<vtkIdType>(merge.Source.size()));
  for (std::size_t k = 0; k < merge.Source.size(); ++k)
  {
    double x[3];
    pieces[merge.Source[k].first]->GetPoint(merge.Source[k].second, x);
    points->SetPoint(static_cast<vtkIdType>(k), x);
  }
  std::set<std::vector<vtkIdType>> known;
  std::vector<MergedCell> polys;
  std::vector<MergedCell> strips;
  for (std::size_t p = 0; p < pieces.size(); ++p)
  {
    std::set<std::vector<vtkIdType>> added;
    vtkDataArray* globalIds = pieces[p]->GetCellData()->GetGlobalIds();
    MergeCells(pieces[p]->GetPolys(), globalIds, 0, merge.WholeOfPiece[p], known, added, polys);
    MergeCells(
      pieces[p]->GetStrips(), globalIds, pieces[p]->GetNumberOfPolys(), merge.WholeOfPiece[p], known, added, strips);
    known.merge(added);
  }
  whole->SetPoints(points);
  whole->SetPolys(ToCellArray(polys, byGlobalCellId));
  whole->SetStrips(ToCellArray(strips, byGlobalCellId));
  return whole;
}

/// The pieces of all ranks, on every rank.
PieceList GatherAll(const Ranks& ranks, vtkPolyData* geometry)
{
  PieceList pieces;
  for (int rank = 0; rank < ranks.Count(); ++rank)
  {
    auto piece = rank == ranks.Rank() ? vtkSmartPointer<vtkPolyData>(geometry) : vtkSmartPointer<vtkPolyData>::New();
    ranks.Broadcast(piece, rank);
    pieces.push_back(piece);
  }
  return pieces;
}
} // namespace

vtkSmartPointer<vtkPolyData> GeometryOf(vtkPolyData* piece)
{
  auto geometry = vtkSmartPointer<vtkPolyData>::New();
  vtkNew<vtkCellArray> polys;
  vtkNew<vtkCellArray> strips;
  geometry->SetPolys(polys);
  geometry->SetStrips(strips);
  if (!piece || !piece->GetPoints())
  {
    return geometry;
  }
  geometry->SetPoints(piece->GetPoints());
  vtkUnsignedCharArray* ghosts = piece->GetCellGhostArray();
  ghosts = Fits(ghosts, piece->GetNumberOfCells()) ? ghosts : nullptr;
  vtkDataArray* cellIds = piece->GetCellData()->GetGlobalIds();
  cellIds = Fits(cellIds, piece->GetNumberOfCells()) ? cellIds : nullptr;
  vtkNew<vtkIdTypeArray> keptIds;
  keptIds->SetName("GlobalCellIds");
  const vtkIdType firstPoly = piece->GetNumberOfVerts() + piece->GetNumberOfLines();
  CopyCells(piece->GetPolys(), firstPoly, ghosts, cellIds, polys, keptIds);
  CopyCells(piece->GetStrips(), firstPoly + piece->GetNumberOfPolys(), ghosts, cellIds, strips, keptIds);
  if (cellIds)
  {
    geometry->GetCellData()->SetGlobalIds(keptIds);
  }
  vtkDataArray* pointIds = piece->GetPointData()->GetGlobalIds();
  if (Fits(pointIds, piece->GetNumberOfPoints()))
  {
    vtkNew<vtkIdTypeArray> ids;
    ids->DeepCopy(pointIds);
    ids->SetName("GlobalPointIds");
    geometry->GetPointData()->SetGlobalIds(ids);
  }
  return geometry;
}

int CountOwners(const Ranks& ranks, vtkPolyData* geometry)
{
  const auto owns = ranks.Gather({ Surfaces(geometry) > 0 });
  return static_cast<int>(std::count_if(owns.begin(), owns.end(), [](const auto& of) { return of[0] != 0; }));
}

bool RepeatsGlobalIds(vtkPolyData* piece)
{
  vtkDataArray* ids = piece->GetPointData()->GetGlobalIds();
  if (!Fits(ids, piece->GetNumberOfPoints()))
  {
    return false;
  }
  std::vector<vtkIdType> sorted;
  for (vtkIdType k = 0; k < ids->GetNumberOfTuples(); ++k)
  {
    sorted.push_back(static_cast<vtkIdType>(ids->GetTuple1(k)));
  }
  std::sort(sorted.begin(), sorted.end());
  return std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end();
}

GatheredSurface GatherPieces(const Ranks& ranks, vtkPolyData* piece)
{
  const vtkSmartPointer<vtkPolyData> geometry = GeometryOf(piece);
  const bool hasPoints = geometry->GetNumberOfPoints() > 0;
  const auto facts = ranks.Gather({ Surfaces(geometry), hasPoints && !geometry->GetPointData()->GetGlobalIds(),
    Surfaces(geometry) > 0 && !geometry->GetCellData()->GetGlobalIds(), RepeatsGlobalIds(geometry) });
  bool repeats = false;
  bool byPointId = true;
  bool byCellId = true;
  GatheredSurface gathered;
  int lastOwner = 0;
  for (int rank = 0; rank < ranks.Count(); ++rank)
  {
    gathered.Owners += facts[rank][0] > 0 ? 1 : 0;
    lastOwner = facts[rank][0] > 0 ? rank : lastOwner;
    byPointId = byPointId && !facts[rank][1];
    byCellId = byCellId && !facts[rank][2];
    repeats = repeats || facts[rank][3];
  }
  if (gathered.Owners <= 1 && !repeats)
  {
    gathered.TakenFrom = gathered.Owners == 1 ? lastOwner : -1;
    gathered.Whole = lastOwner == ranks.Rank() ? geometry : vtkSmartPointer<vtkPolyData>::New();
    ranks.Broadcast(gathered.Whole, lastOwner);
    if (lastOwner == ranks.Rank())
    {
      gathered.WholeOfLocal.resize(static_cast<std::size_t>(geometry->GetNumberOfPoints()));
      std::generate(
        gathered.WholeOfLocal.begin(), gathered.WholeOfLocal.end(), [id = std::int64_t(0)]() mutable { return id++; });
    }
    return gathered;
  }
  const PieceList pieces = GatherAll(ranks, geometry);
  const PointMerge merge = byPointId ? MergeByGlobalId(pieces) : MergeByCoordinates(pieces);
  gathered.Whole = Merge(pieces, merge, byCellId);
  gathered.WholeOfLocal = merge.WholeOfPiece[ranks.Rank()];
  return gathered;
}

vtkSmartPointer<vtkDataArray> TakeLocal(const GatheredSurface& surface, vtkDataArray* whole)
{
  const auto count = static_cast<vtkIdType>(surface.WholeOfLocal.size());
  const auto local = vtk::TakeSmartPointer(whole->NewInstance());
  local->SetName(whole->GetName());
  local->SetNumberOfComponents(whole->GetNumberOfComponents());
  local->SetNumberOfTuples(count);
  for (vtkIdType k = 0; k < count; ++k)
  {
    local->SetTuple(k, surface.WholeOfLocal[k], whole);
  }
  return local;
}

} // namespace surfsynth
