// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Frame around RequestData of filters that add samples of random fields to surfaces and volumes.
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

#include "BlockCache.h"
#include "SurfaceBridge.h"

#include <vtkAlgorithm.h>
#include <vtkSmartPointer.h>
#include <vtkType.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

class vtkDataSet;
class vtkDoubleArray;
class vtkInformationVector;
class vtkPolyData;

namespace surfsynth
{

/// Makes an uninitialised array. @throws std::bad_alloc, which vtkDoubleArray's own allocation need not.
VTKSURFACESYNTHESISBRIDGE_EXPORT vtkSmartPointer<vtkDoubleArray> NewNoiseArray(
  const std::string& name, vtkIdType tuples, int components);

/// Name of a sample's array: @p name, or name_sample where there are several samples.
VTKSURFACESYNTHESISBRIDGE_EXPORT std::string SampleName(
  const std::string& name, int numberOfSamples, std::uint32_t sample);

/// Adds the arrays to the points of @p output; the first becomes active where SetActiveWhereNone() says so.
/// @param active the first becomes the active scalars where there are others, too
VTKSURFACESYNTHESISBRIDGE_EXPORT void AddNoiseArrays(
  const std::vector<vtkSmartPointer<vtkDoubleArray>>& arrays, vtkDataSet* output, bool active = false);

/// Samples that a filter adds to each surface, from its properties.
struct SampleSeries
{
  std::string OutputArrayName;  ///< see SampleName()
  int Seed = 0;                 ///< any integer
  int FirstSample = 0;          ///< number of the first sample, at least 0
  int NumberOfSamples = 1;      ///< at least 1
  int NumberOfComponents = 1;   ///< of each array, at least 1
  std::int64_t MemoryLimit = 0; ///< MiB, see SampleMemory
  bool ActiveResult = false;    ///< see AddNoiseArrays()
};

/// Returns the samples of @p series that this rank draws on @p surface, as a request of the core: SampleRequest or
/// GaussianMixtureRequest.
template <typename Request>
Request RequestPart(const SampleSeries& series, const Surface& surface)
{
  const int samples = series.NumberOfSamples - surface.Part.Index;
  Request request;
  request.Seed = static_cast<std::uint64_t>(series.Seed);
  request.FirstSample = static_cast<std::uint32_t>(series.FirstSample) + static_cast<std::uint32_t>(surface.Part.Index);
  request.SampleStep = static_cast<std::uint32_t>(surface.Part.Count);
  request.NumberOfSamples = static_cast<std::uint32_t>((samples + surface.Part.Count - 1) / surface.Part.Count);
  request.Stream = surface.FlatIndex;
  return request;
}

/// Returns the memory for sample number @p sample: V * C doubles, the components of a point side by side.
using SampleDestination = std::function<double*(std::uint32_t sample)>;

/// Adds the arrays of @p series to the points of @p output. @p draw asks for the memory of each sample and fills it;
/// nothing is added when it throws.
VTKSURFACESYNTHESISBRIDGE_EXPORT void AddSamples(
  const SampleSeries& series, const std::function<void(const SampleDestination&)>& draw, vtkDataSet* output);

/// Random fields on the blocks of the last update, each factored once for its mesh and options.
/// @tparam IsSameFactor true for two options with the same factor.
template <typename Field, typename Options, bool (*IsSameFactor)(const Options&, const Options&)>
class RandomFieldCache
{
public:
  /// Begins an update: see BlockCache::Begin().
  void Begin() { this->Blocks.Begin(); }

  /// Ends an update: see BlockCache::DropUnused().
  void DropUnused() { this->Blocks.DropUnused(); }

  /// Finds the field of this block from an earlier update with the same mesh and options; null otherwise.
  const Field* Find(const Surface& surface, const Options& options)
  {
    const auto isCurrent = [&options](const Prepared& held) { return IsSameFactor(held.FactorOptions, options); };
    const Prepared* found = this->Blocks.Find(surface, isCurrent);
    return found ? found->Content.get() : nullptr;
  }

  /// Assembles and factors the field of this block, in place of what was held. Throws what its constructor throws.
  const Field& Build(const Surface& surface, const Options& options, const Progress& progress)
  {
    this->Blocks.Drop(surface);
    Prepared prepared{ options, MakeField(surface, options, progress) };
    ++this->Factorizations;
    return *this->Blocks.Insert(surface, std::move(prepared)).Content;
  }

  /// Number of fields built since this object was made.
  vtkTypeInt64 NumberOfFactorizations() const { return this->Factorizations; }

private:
  struct Prepared
  {
    Options FactorOptions;
    std::unique_ptr<Field> Content;
  };

  static std::unique_ptr<Field> MakeField(const Surface& surface, const Options& options, const Progress& progress)
  {
    if constexpr (std::is_constructible_v<Field, TetrahedralMesh, Options, Progress>)
    {
      if (surface.Volume)
      {
        return std::make_unique<Field>(*surface.Volume, options, progress);
      }
    }
    return std::make_unique<Field>(surface.Mesh, *surface.Topology, options, progress);
  }

  BlockCache<Prepared> Blocks;
  vtkTypeInt64 Factorizations = 0;
};

/// Returns true when @p series has a name and fits into its memory, else reports the error and empties the output.
VTKSURFACESYNTHESISBRIDGE_EXPORT bool RequireSeries(vtkAlgorithm* self, const SampleSeries& series,
  vtkInformationVector** inputVector, vtkInformationVector* outputVector);

/// RequestData of a filter that adds @p series to surfaces: see ProcessSurfaces().
/// @param internals has Begin(), AddField(surface, output, progress), Find(surface) for the field held, and Fields, a
/// RandomFieldCache.
/// @param parts things that ranks share: see ProcessSurfaces(); 0 for the samples
/// @param pieceWorker work on surfaces that stay in pieces: see ProcessSurfaces()
template <typename Internals>
int ProcessRandomFields(vtkAlgorithm* self, vtkInformationVector** inputVector, vtkInformationVector* outputVector,
  const SampleSeries& series, Internals& internals, int parts = 0, const PieceWorker& pieceWorker = {})
{
  if (!RequireSeries(self, series, inputVector, outputVector))
  {
    return 0;
  }
  internals.Begin();
  const auto addField = [&internals](const Surface& surface, vtkPolyData* output, const Progress& progress) {
    internals.AddField(surface, output, progress);
  };
  const auto isHeld = [&internals](const Surface& surface) { return internals.Find(surface) != nullptr; };
  const int success = ProcessSurfaces(self, inputVector, outputVector, MeshRequirements(), addField, isHeld,
    parts > 0 ? parts : series.NumberOfSamples, pieceWorker);
  if (success && !self->GetAbortExecute())
  {
    internals.Fields.DropUnused();
  }
  return success;
}

} // namespace surfsynth
