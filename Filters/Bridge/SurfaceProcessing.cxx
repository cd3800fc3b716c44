// SPDX-License-Identifier: BSD-3-Clause
#include "SurfaceBridge.h"

#include "DataObjects.h"
#include "DistributedSurfaces.h"
#include "ProcessingSupport.h"
#include "SurfaceArrays.h"
#include "SurfaceInputs.h"

#include "Core/Common/Errors.h"

#include <vtkAlgorithm.h>
#include <vtkCellData.h>
#include <vtkDataObject.h>
#include <vtkDataObjectTree.h>
#include <vtkDataObjectTreeIterator.h>
#include <vtkFieldData.h>
#include <vtkInformation.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <algorithm>

namespace surfsynth
{

namespace
{
vtkIdType NumberOfCells(vtkPolyData* block) { return std::max<vtkIdType>(block->GetNumberOfCells(), 0); }

/// Results of one surface, one for each output of the series.
using PolyDataList = std::vector<vtkSmartPointer<vtkPolyData>>;

PolyDataList NewSurfaces(std::size_t count)
{
  PolyDataList surfaces;
  for (std::size_t k = 0; k < count; ++k)
  {
    surfaces.push_back(vtkSmartPointer<vtkPolyData>::New());
  }
  return surfaces;
}

/// One call of a filter's RequestData.
class Processing
{
public:
  Processing(vtkAlgorithm* self, const MeshRequirements& requirements, const SurfaceSeries& series,
    const ValidSurface& isKnownValid, int parts, const PieceWorker& pieceWorker)
    : Steps(self)
    , Self(self)
    , Requirements(requirements)
    , Series(series)
    , IsKnownValid(isKnownValid)
    , Parts(parts)
    , OfPieces(pieceWorker)
  {}

  PipelineProgress Steps;

  /// Fills @p outputs from @p input; after an error, which is reported here, they are empty.
  /// @return false after an error.
  /// @throws Cancelled
  bool Polygons(vtkPolyData* input, const PolyDataList& outputs, const BlockPlace& at, const Progress& progress) const
  {
    const std::string error = Attempt(input, [&] { this->WorkAndFinish(input, outputs, at, progress); });
    return this->Conclude(error, at, outputs);
  }

  /// The same for a surface of which each rank holds a piece, or which one rank holds for all: it is gathered, worked
  /// on by as many ranks as there are parts, and what they have made is handed back to the pieces. Collective.
  bool DistributedPolygons(const Ranks& ranks, vtkPolyData* input, const PolyDataList& outputs, const BlockPlace& at,
    const Progress& progress) const
  {
    // A piece that is broken in itself is not sent around.
    const auto convert = [&] {
      if (input->GetNumberOfPolys() + input->GetNumberOfStrips() > 0)
      {
        ConvertSurface(input);
      }
    };
    std::string error = Attempt(input, convert);
    const bool several = ranks.Count() > 1;
    error = ranks.FirstText(error.empty() || !several ? error : "Rank " + std::to_string(ranks.Rank()) + ": " + error);
    if (!error.empty())
    {
      return this->Conclude(error, at, outputs);
    }
    if (this->OfPieces && several)
    {
      const auto geometry = GeometryOf(input);
      if (CountOwners(ranks, geometry) > 1)
      {
        return this->Conclude(this->WorkInPieces(ranks, input, geometry, outputs.front(), at, progress), at, outputs);
      }
    }
    const GatheredSurface gathered = GatherPieces(ranks, input);
    if (gathered.Owners == 0)
    {
      return this->Polygons(input, outputs, at, progress);
    }
    return this->Conclude(this->WorkTogether(ranks, gathered, input, outputs, at, progress), at, outputs);
  }

  /// Fills @p outputs, trees with the structure of @p input, block by block.
  /// @throws Cancelled
  void Blocks(
    vtkDataObjectTree* input, const DataObjectList& outputs, const std::function<bool(std::size_t leaf)>& isWanted = {})
  {
    double cells = 0.0;
    EachBlock(input, [&](vtkDataObjectTreeIterator*, vtkPolyData* block) { cells += Weight(block); });
    double done = 0.0;
    std::size_t leaf = 0;
    EachBlock(input, [&](vtkDataObjectTreeIterator* place, vtkPolyData* block) {
      if ((isWanted && !isWanted(leaf++)) || !place->GetCurrentDataObject())
      {
        return;
      }
      if (!block)
      {
        this->Fail("A" + DescribeInput(place->GetCurrentDataObject()).substr(1) +
            " was found where a vtkPolyData is needed; vtkDataSetSurfaceFilter extracts a surface.",
          PlaceOf(place).Name);
        return;
      }
      const double before = done / cells;
      done += Weight(block);
      const PolyDataList results = NewSurfaces(outputs.size());
      const Progress progress = this->Steps.Within(before, done / cells);
      RepeatsGlobalIds(block) ? this->DistributedPolygons(Ranks(nullptr), block, results, PlaceOf(place), progress)
                              : this->Polygons(block, results, PlaceOf(place), progress);
      SetLeaves(place, results, outputs);
    });
  }

  /// The same when each rank holds some of the blocks, or pieces of blocks. Blocks that lie on one rank are worked on
  /// there; the others are gathered one after the other. Collective.
  void DistributedBlocks(const Ranks& ranks, vtkDataObjectTree* input, const DataObjectList& outputs)
  {
    std::vector<std::int64_t> cells;
    EachBlock(input, [&](vtkDataObjectTreeIterator*, vtkPolyData* block) {
      cells.push_back(block ? block->GetNumberOfPolys() + block->GetNumberOfStrips() : 0);
    });
    const std::vector<bool> shared = SharedLeaves(this->Self, ranks, input, cells);
    if (shared.size() != cells.size())
    {
      return;
    }
    bool cancelled = false;
    try
    {
      this->Blocks(input, outputs, [&](std::size_t leaf) { return !shared[leaf]; });
    }
    catch (const Cancelled&)
    {
      cancelled = true;
    }
    CancelTogether(ranks, cancelled);
    std::size_t leaf = 0;
    EachBlock(input, [&](vtkDataObjectTreeIterator* place, vtkPolyData* block) {
      if (shared[leaf++])
      {
        vtkNew<vtkPolyData> empty;
        const PolyDataList results = NewSurfaces(outputs.size());
        this->DistributedPolygons(
          ranks, block ? block : empty.Get(), results, PlaceOf(place), this->Steps.Within(1.0, 1.0));
        if (block)
        {
          SetLeaves(place, results, outputs);
        }
      }
    });
  }

private:
  static double Weight(vtkPolyData* block) { return block ? 1.0 + static_cast<double>(NumberOfCells(block)) : 0.0; }

  /// Calls visit(place, polydata) for every leaf; the polydata is null when the leaf is, or is something else.
  template <typename Visit>
  static void EachBlock(vtkDataObjectTree* tree, const Visit& visit)
  {
    EachLeaf(tree, [&](vtkDataObjectTreeIterator* place) {
      visit(place, vtkPolyData::SafeDownCast(place->GetCurrentDataObject()));
    });
  }

  /// Puts the results of one surface into the trees of the outputs.
  static void SetLeaves(vtkDataObjectTreeIterator* place, const PolyDataList& results, const DataObjectList& outputs)
  {
    for (std::size_t k = 0; k < outputs.size(); ++k)
    {
      vtkDataObjectTree::SafeDownCast(outputs[k])->SetDataSet(place, results[k]);
    }
  }

  /// Converts, checks and works on one surface.
  /// @return false for an empty surface, on which there is nothing to work.
  bool Work(vtkPolyData* input, const PolyDataList& outputs, const BlockPlace& at, const SurfacePart& part,
    const Progress& progress) const
  {
    Report(progress, 0.0);
    for (const auto& output : outputs)
    {
      output->ShallowCopy(input);
    }
    if (IsEmpty(input))
    {
      return false;
    }
    Surface surface = ConvertSurface(input);
    surface.FlatIndex = at.FlatIndex;
    surface.Where = at.Name;
    surface.Part = part;
    if (!this->IsKnownValid || !this->IsKnownValid(surface))
    {
      CheckSurface(surface, this->Requirements);
    }
    this->Series.Worker(surface, { outputs.begin(), outputs.end() }, progress);
    return true;
  }

  void Finish(const PolyDataList& outputs) const
  {
    if (this->Series.Finish)
    {
      std::for_each(outputs.begin(), outputs.end(), this->Series.Finish);
    }
  }

  /// All work on a surface that lies on this rank.
  void WorkAndFinish(
    vtkPolyData* input, const PolyDataList& outputs, const BlockPlace& at, const Progress& progress) const
  {
    if (this->Work(input, outputs, at, { 0, 1 }, progress))
    {
      this->Finish(outputs);
    }
  }

  /// Number of ranks that work on a gathered surface.
  int Workers(const Ranks& ranks) const { return std::max(1, std::min(this->Parts, ranks.Count())); }

  /// Work on a gathered surface, by as many ranks as there are parts; by the one that holds all of it when there is one
  /// part. Collective.
  /// @return the text of what went wrong on some rank; empty when nothing did.
  std::string WorkTogether(const Ranks& ranks, const GatheredSurface& gathered, vtkPolyData* input,
    const PolyDataList& outputs, const BlockPlace& at, const Progress& progress) const
  {
    const int workers = this->Workers(ranks);
    const bool inPlace = workers == 1 && gathered.TakenFrom >= 0;
    const bool works = inPlace ? ranks.Rank() == gathered.TakenFrom : ranks.Rank() < workers;
    const PolyDataList wholes = NewSurfaces(outputs.size());
    bool cancelled = false;
    const auto work = [&] {
      try
      {
        if (inPlace)
        {
          this->WorkAndFinish(input, outputs, at, progress);
          return;
        }
        this->Work(gathered.Whole, wholes, at, { ranks.Rank(), workers }, progress);
        std::for_each(wholes.begin(), wholes.end(), RefuseCellArrays);
      }
      catch (const Cancelled&)
      {
        cancelled = true;
      }
    };
    std::string error = works ? Attempt(inPlace ? input : gathered.Whole.Get(), work) : std::string();
    CancelTogether(ranks, cancelled);
    error = ranks.FirstText(error);
    if (!error.empty() || (inPlace && works))
    {
      return error;
    }
    for (const auto& output : outputs)
    {
      output->ShallowCopy(input);
    }
    return inPlace ? error : this->HandBackAll(ranks, gathered, wholes, outputs);
  }

  /// This rank's piece as the core sees it.
  static SurfacePiece ConvertPiece(vtkPolyData* geometry, const BlockPlace& at)
  {
    SurfacePiece piece;
    if (geometry->GetNumberOfPolys() + geometry->GetNumberOfStrips() > 0)
    {
      piece.Local = ConvertSurface(geometry);
    }
    else if (geometry->GetNumberOfPoints() > 0)
    {
      piece.Local.Mesh.Points = ConvertPoints(geometry);
    }
    piece.Local.FlatIndex = at.FlatIndex;
    piece.Local.Where = at.Name;
    vtkDataArray* ids = geometry->GetPointData()->GetGlobalIds();
    for (vtkIdType k = 0; ids && k < ids->GetNumberOfTuples(); ++k)
    {
      piece.GlobalIds.push_back(static_cast<std::int64_t>(ids->GetTuple1(k)));
    }
    return piece;
  }

  /// Work on a surface that stays in its pieces. Collective.
  /// @return the text of what went wrong on some rank; empty when nothing did.
  std::string WorkInPieces(const Ranks& ranks, vtkPolyData* input, vtkPolyData* geometry, vtkPolyData* output,
    const BlockPlace& at, const Progress& progress) const
  {
    SurfacePiece piece;
    const auto convert = [&] {
      output->ShallowCopy(input);
      piece = ConvertPiece(geometry, at);
    };
    std::string error = ranks.FirstText(Attempt(input, convert));
    if (!error.empty())
    {
      return error;
    }
    bool cancelled = false;
    const auto work = [&] {
      try
      {
        this->OfPieces(piece, output, progress);
      }
      catch (const Cancelled&)
      {
        cancelled = true;
      }
    };
    error = Attempt(input, work);
    CancelTogether(ranks, cancelled);
    return ranks.FirstText(error);
  }

  /// Gives each rank its part of what the workers have made of the whole surface, and finishes it. Collective.
  /// @return the text of what went wrong on some rank.
  std::string HandBackAll(
    const Ranks& ranks, const GatheredSurface& gathered, const PolyDataList& wholes, const PolyDataList& outputs) const
  {
    for (std::size_t k = 0; k < outputs.size(); ++k)
    {
      const int owner = static_cast<int>(k) % this->Workers(ranks);
      this->HandBack(ranks, gathered, wholes[k], owner, outputs[k]);
    }
    const bool finishes = HasPiece(gathered, outputs.front());
    return ranks.FirstText(finishes ? Attempt(outputs.front(), [&] { this->Finish(outputs); }) : std::string());
  }

  /// Reports @p error, if there is one, and then empties @p outputs.
  bool Conclude(const std::string& error, const BlockPlace& at, const PolyDataList& outputs) const
  {
    if (error.empty())
    {
      return true;
    }
    this->Fail(error, at.Name);
    for (const auto& output : outputs)
    {
      output->Initialize();
    }
    return false;
  }

  /// Arrays on cells have no way back to the pieces, whose cells may be in another order or be ghosts.
  static void RefuseCellArrays(vtkPolyData* whole)
  {
    if (whole->GetCellData()->GetNumberOfArrays() > 0)
    {
      throw InvalidInput(std::string("The array \"") + whole->GetCellData()->GetArrayName(0) +
        "\" is one value for each cell of the surface, whose pieces lie on several MPI ranks or in several blocks; "
        "values for cells need the surface on one rank and in one piece.");
    }
  }

  /// True when the points of @p output are those of this rank's piece.
  static bool HasPiece(const GatheredSurface& gathered, vtkPolyData* output)
  {
    return static_cast<vtkIdType>(gathered.WholeOfLocal.size()) == output->GetNumberOfPoints();
  }

  /// Gives each rank its part of the point arrays that the workers have added to @p whole, part by part, and the field
  /// data that @p owner has.
  void HandBack(
    const Ranks& ranks, const GatheredSurface& gathered, vtkPolyData* whole, int owner, vtkPolyData* output) const
  {
    std::vector<vtkDataArray*> made;
    for (int k = 0; k < whole->GetPointData()->GetNumberOfArrays(); ++k)
    {
      vtkDataArray* array = whole->GetPointData()->GetArray(k);
      if (array && gathered.Whole->GetPointData()->GetArray(array->GetName()) != array)
      {
        made.push_back(array);
      }
    }
    const auto counts = ranks.Gather({ static_cast<std::int64_t>(made.size()) });
    const std::int64_t most = (*std::max_element(counts.begin(), counts.end()))[0];
    const bool hasPiece = HasPiece(gathered, output);
    for (std::int64_t k = 0; k < most; ++k)
    {
      for (int rank = 0; rank < ranks.Count(); ++rank)
      {
        if (k < counts[rank][0])
        {
          const auto array = ranks.Share(rank == ranks.Rank() ? made[k] : nullptr, rank);
          AddToPiece(gathered, array, hasPiece ? output : nullptr);
        }
      }
    }
    vtkNew<vtkPolyData> fields;
    fields->GetFieldData()->ShallowCopy(whole->GetFieldData());
    ranks.Broadcast(fields, owner);
    for (int k = 0; k < fields->GetFieldData()->GetNumberOfArrays(); ++k)
    {
      output->GetFieldData()->AddArray(fields->GetFieldData()->GetAbstractArray(k));
    }
  }

  void AddToPiece(const GatheredSurface& gathered, vtkDataArray* array, vtkPolyData* piece) const
  {
    if (!piece)
    {
      return;
    }
    piece->GetPointData()->AddArray(TakeLocal(gathered, array));
    if (!this->Series.Finish) // else the active arrays are for it to choose
    {
      SetActiveWhereNone(piece->GetPointData(), array->GetName());
    }
  }

  void Fail(const std::string& text, const std::string& where) const { ReportError(this->Self, where, text); }

  vtkAlgorithm* Self;
  const MeshRequirements& Requirements;
  const SurfaceSeries& Series;
  const ValidSurface& IsKnownValid;
  int Parts;
  const PieceWorker& OfPieces;
};

/// Throws Cancelled; reports inputs of another type.
bool Process(
  Processing& processing, vtkAlgorithm* self, const OutputSeries& series, vtkDataObject* input, vtkDataObject* output)
{
  vtkMultiProcessController* several = Ranks::Several();
  if (auto* tree = vtkDataObjectTree::SafeDownCast(input))
  {
    const DataObjectList outputs = MakeOutputs(tree, series, "vtkPolyData", output);
    several ? processing.DistributedBlocks(Ranks(several), tree, outputs) : processing.Blocks(tree, outputs);
    return true;
  }
  auto* polygons = vtkPolyData::SafeDownCast(input);
  const std::string error = Ranks(several).FirstText(polygons ? ""
                                                              : "The input is " + DescribeInput(input) +
        "; a vtkPolyData or a composite dataset of them is needed, and vtkDataSetSurfaceFilter extracts a surface.");
  if (!error.empty())
  {
    ReportError(self, "", error);
    return false;
  }
  PolyDataList results;
  for (const auto& made : MakeOutputs(polygons, series, "vtkPolyData", output))
  {
    results.push_back(vtkPolyData::SafeDownCast(made));
  }
  const Progress progress = processing.Steps.Within(0.0, 1.0);
  return several || RepeatsGlobalIds(polygons)
    ? processing.DistributedPolygons(Ranks(several), polygons, results, {}, progress)
    : processing.Polygons(polygons, results, {}, progress);
}

int ProcessParts(vtkAlgorithm* self, vtkInformationVector** inputVector, vtkInformationVector* outputVector,
  const MeshRequirements& requirements, const SurfaceSeries& series, const ValidSurface& isKnownValid, int parts,
  const PieceWorker& pieceWorker = {})
{
  return RunGuarded(self, outputVector, [&] {
    Processing processing(self, requirements, series, isKnownValid, parts, pieceWorker);
    const auto input = AsSurfaces(vtkDataObject::GetData(inputVector[0]));
    return Process(processing, self, series.Outputs, input, vtkDataObject::GetData(outputVector));
  });
}
} // namespace

int AcceptSurfaces(vtkInformation* info)
{
  info->Remove(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE());
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkPolyData");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkUnstructuredGrid");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataObjectTree");
  return 1;
}

std::vector<std::int64_t> GatherFromRanks(std::int64_t number)
{
  std::vector<std::int64_t> numbers;
  for (const auto& ofRank : Ranks(Ranks::Several()).Gather({ number }))
  {
    numbers.push_back(ofRank.front());
  }
  return numbers;
}

int ProcessSurfaces(vtkAlgorithm* self, vtkInformationVector** inputVector, vtkInformationVector* outputVector,
  const MeshRequirements& requirements, const SurfaceWorker& worker, const ValidSurface& isKnownValid, int parts,
  const PieceWorker& pieceWorker)
{
  SurfaceSeries single;
  single.Worker = [&worker](const Surface& surface, const std::vector<vtkPolyData*>& outputs,
                    const Progress& progress) { worker(surface, outputs.front(), progress); };
  return ProcessParts(self, inputVector, outputVector, requirements, single, isKnownValid, parts, pieceWorker);
}

int ProcessSurfaces(vtkAlgorithm* self, vtkInformationVector** inputVector, vtkInformationVector* outputVector,
  const MeshRequirements& requirements, const SurfaceSeries& series, const ValidSurface& isKnownValid)
{
  return ProcessParts(self, inputVector, outputVector, requirements, series, isKnownValid, series.Outputs.Count);
}

} // namespace surfsynth
