// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Partition of the faces of a mesh into small compact patches, whose data stay in cache. Private to Inference and Learning.
#pragma once

#include "Core/Common/Parallel.h"
#include "Inference/PoissonNet/PoissonOperators.h"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <vector>

namespace surfsynth
{

/// Patches of faces. Every face lies in one patch. A vertex whose faces all lie in one patch is inner. Each other
/// vertex has one slot for each of its patches, for the sums over the patch's faces; slots are added up in order. So
/// patches are processed in parallel, and sums have the same bits for every number of threads.
struct FacePatches
{
  std::vector<std::int64_t> FaceStart;   ///< [P + 1], places of faces: patch p holds FaceStart[p] .. FaceStart[p + 1)
  std::vector<Index> FaceOfPlace;        ///< [F], the mesh's face at each place
  std::vector<Index> Corners;            ///< [3 F], vertices of the mesh, by place
  std::vector<Index> LocalCorners;       ///< [3 F], their numbers in the patch
  std::vector<float> BasisGradients;     ///< [6 F], PoissonOperators::Gradient by place
  std::vector<float> Areas;              ///< [F], by place
  std::vector<std::int64_t> VertexStart; ///< [P + 1], into Vertices
  std::vector<Index> Vertices;           ///< vertices of each patch, in the order of their local numbers
  std::vector<std::int64_t> Slot;        ///< as Vertices: the slot, or -1 for an inner vertex
  std::vector<Index> SharedVertices;     ///< vertices of several patches, ascending
  std::vector<std::int64_t> SlotStart;   ///< [SharedVertices + 1]: their slots, in the order of patches

  /// Number of patches, P.
  std::int64_t Count() const { return static_cast<std::int64_t>(this->FaceStart.size()) - 1; }
  /// Number of faces of patch @p p.
  std::int64_t Faces(std::int64_t p) const { return this->FaceStart[p + 1] - this->FaceStart[p]; }
  /// Number of vertices of patch @p p.
  std::int64_t Points(std::int64_t p) const { return this->VertexStart[p + 1] - this->VertexStart[p]; }
  /// Number of slots of all shared vertices.
  std::int64_t Slots() const { return this->SlotStart.back(); }
};

/// Cuts the mesh by planes across its longest extent into patches of about equal numbers of faces, at most @p largest.
/// @param points [V, 3], used for the planes only
FacePatches CutIntoPatches(const PoissonOperators& operators, const PointMatrix& points, std::int64_t largest = 1024);

/// Passes the sums of patch @p p on, [points of the patch, width]: rows of inner vertices to write(vertex, row), the others
/// to @p slots, [Slots(), width].
template <typename Write>
void DistributeSums(
  const FacePatches& patches, std::int64_t p, const float* sums, std::int64_t width, float* slots, const Write& write)
{
  for (std::int64_t k = patches.VertexStart[p]; k < patches.VertexStart[p + 1]; ++k, sums += width)
  {
    if (patches.Slot[k] < 0)
    {
      write(patches.Vertices[k], sums);
    }
    else
    {
      std::copy_n(sums, width, slots + patches.Slot[k] * width);
    }
  }
}

/// Adds up the slots of each shared vertex and passes the sums to write(vertex, row).
template <typename Write>
void CombineSlots(const FacePatches& patches, const float* slots, std::int64_t width, const Write& write)
{
  ParallelFor(
    static_cast<std::int64_t>(patches.SharedVertices.size()), 1024, [&](std::int64_t begin, std::int64_t end) {
      std::vector<float> sum(static_cast<std::size_t>(width));
      for (std::int64_t k = begin; k < end; ++k)
      {
        std::fill(sum.begin(), sum.end(), 0.0F);
        for (std::int64_t slot = patches.SlotStart[k]; slot < patches.SlotStart[k + 1]; ++slot)
        {
          std::transform(sum.begin(), sum.end(), slots + slot * width, sum.begin(), std::plus<float>());
        }
        write(patches.SharedVertices[k], sum.data());
      }
    });
}

} // namespace surfsynth
