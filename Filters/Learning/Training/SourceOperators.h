// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Operators and factorisations of the surfaces of a training, kept under a limit of memory. Private to the training.
#pragma once

#include "Inference/FlowMatching/FlowNoiseField.h"
#include "Learning/Layers/MeshTensors.h"
#include "Learning/Training/SourceMemory.h"
#include "Learning/Training/TrainingSources.h"

#include <torch/torch.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>

namespace surfsynth
{

/// Operators that a training evaluates the network on one surface with, and its noise. A pure function of the surface.
struct SourceOperators
{
  /// Copies @p factors of @p mesh to @p device; on CUDA with a dense inverse, where that is small enough.
  SourceOperators(const TriangleMesh& mesh, SourceFactors factors, const torch::Device& device);

  MeshTensors Mesh;
  std::unique_ptr<FlowNoiseField> Noise;
  /// Bytes of both, on the processor and on the device: of tables and factorisations, from their sizes.
  std::uint64_t Bytes = 0;
};

/// The operators of the sources in use last, as many as fit into a limit of memory.
///
/// Operators that do not fit are dropped, the least recently used first, and built again when needed. Room is made before a
/// source is built, so that the limit holds at each time, but for a source that is larger than the limit: it is kept as
/// long as it is in use.
class SourceCache
{
public:
  using Builder = std::function<SourceOperators(std::size_t source)>;

  /// @param limit bytes, at least 0. @param build makes the operators of a source
  SourceCache(double limit, Builder build);

  /// Keeps operators that have been built when they fit beside those that are kept, else drops them.
  void Offer(std::size_t source, SourceOperators operators);

  /// The operators of a source, built when they are not kept. Valid until the next call.
  const SourceOperators& Get(std::size_t source);

  /// Memory and builds so far.
  const SourceMemoryUse& Use() const { return this->Used; }

private:
  struct Entry
  {
    std::size_t Source;
    SourceOperators Operators;
  };

  void MakeRoom(std::uint64_t bytes);
  void Insert(std::size_t source, SourceOperators operators);

  double Limit;
  Builder Build;
  std::list<Entry> Entries; ///< most recently used first
  std::map<std::size_t, std::list<Entry>::iterator> EntryOf;
  std::map<std::size_t, std::uint64_t> Sizes; ///< bytes of the sources that were built once
  SourceMemoryUse Used;
};

} // namespace surfsynth
