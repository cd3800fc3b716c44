// SPDX-License-Identifier: BSD-3-Clause
#include "PieceNoise.h"

#include "Core/Common/Errors.h"

#ifdef SURFACE_SYNTHESIS_PETSC
#include "BlockCache.h"

#include "Distributed/DistributedMaternField.h"

#include <algorithm>
#include <utility>
#include <vector>
#endif

namespace surfsynth
{

#ifdef SURFACE_SYNTHESIS_PETSC

namespace
{
/// The ranks of the pipeline as a group. Collective.
RankGroup GroupOfPipeline()
{
  std::vector<int> ranks;
  for (const std::int64_t rank : GatherFromRanks(RankGroup::WorldRank()))
  {
    ranks.push_back(static_cast<int>(rank));
  }
  return RankGroup::OfWorldRanks(ranks);
}
} // namespace

class PieceNoise::Internals
{
public:
  struct Prepared
  {
    MaternFieldOptions Options;
    std::vector<std::int64_t> GlobalIds;
    std::unique_ptr<DistributedMaternField> Field;
  };

  /// Finds the field of an earlier update, when all ranks hold it; null otherwise. Collective.
  DistributedMaternField* Find(const SurfacePiece& piece, const MaternFieldOptions& options, const SameOperators& same)
  {
    const auto isCurrent = [&](const Prepared& held) {
      return same(held.Options, options) && held.GlobalIds == piece.GlobalIds;
    };
    Prepared* found = this->Blocks.Find(piece.Local, isCurrent);
    const auto finds = GatherFromRanks(found ? 1 : 0);
    return *std::min_element(finds.begin(), finds.end()) > 0 ? found->Field.get() : nullptr;
  }

  /// Assembles the field of this block in place of what was held. Collective.
  DistributedMaternField& Build(const SurfacePiece& piece, const MaternFieldOptions& options, const Progress& progress)
  {
    this->Blocks.Drop(piece.Local);
    const MeshPiece mesh{ piece.Local.Mesh, piece.Local.CellOfTriangle, piece.GlobalIds };
    auto field = std::make_unique<DistributedMaternField>(GroupOfPipeline(), mesh, options, progress);
    return *this->Blocks.Insert(piece.Local, { options, piece.GlobalIds, std::move(field) }).Field;
  }

  BlockCache<Prepared> Blocks;
};

void PieceNoise::Begin() { this->Impl->Blocks.Begin(); }

void PieceNoise::DropUnused() { this->Impl->Blocks.DropUnused(); }

PieceNoiseResults PieceNoise::AddSamples(const SurfacePiece& piece, const MaternFieldOptions& options,
  const SameOperators& same, const SampleRequest& request, const SampleSeries& series, vtkDataSet* output,
  const Progress& progress)
{
  DistributedMaternField* field = this->Impl->Find(piece, options, same);
  PieceNoiseResults results;
  results.IsNew = field == nullptr;
  const double built = results.IsNew ? 0.5 : 0.0; // a hierarchy costs about as much as a few solves
  if (results.IsNew)
  {
    field = &this->Impl->Build(piece, options, SubProgress(progress, 0.0, built));
  }
  const auto draw = [&](const SampleDestination& destination) {
    field->SampleInto(request, destination, SubProgress(progress, built, 1.0));
  };
  surfsynth::AddSamples(series, draw, output);
  results.EffectiveScreening = field->EffectiveScreening();
  results.EffectiveCorrelationRange = field->EffectiveCorrelationRange();
  results.Gamma = field->Gamma();
  results.RelativeResidual = field->RelativeResidual();
  results.LongestEdge = field->LongestEdge();
  results.LongestSide = field->LongestSide();
  results.Iterations = field->Iterations();
  return results;
}

#else

class PieceNoise::Internals
{};

void PieceNoise::Begin() {}

void PieceNoise::DropUnused() {}

PieceNoiseResults PieceNoise::AddSamples(const SurfacePiece&, const MaternFieldOptions&, const SameOperators&,
  const SampleRequest&, const SampleSeries&, vtkDataSet*, const Progress&)
{
  throw InvalidInput(
    "GatherPieces is off, and the library was built without PETSc (option SURFACE_SYNTHESIS_PETSC), which "
    "solves on a surface in pieces on several MPI ranks; switch GatherPieces on.");
}

#endif

PieceNoise::PieceNoise()
  : Impl(std::make_unique<Internals>())
{}

PieceNoise::~PieceNoise() = default;

} // namespace surfsynth
