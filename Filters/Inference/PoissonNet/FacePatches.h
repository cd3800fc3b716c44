// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The faces of a mesh in small compact patches, so that the work on one stays in cache. Private to the inference.
#pragma once

#include "Inference/PoissonNet/PoissonOperators.h"

#include <cstdint>
#include <vector>

namespace surfsynth
{

/// Every face lies in one patch. A vertex whose faces all lie in one patch is inner; what faces of several patches
/// add to the others goes to one slot for each of these patches, and slots are summed in order: so patches can be
/// worked on in parallel and sums have the same bits for every number of threads.
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

  std::int64_t Count() const { return static_cast<std::int64_t>(this->FaceStart.size()) - 1; }
  std::int64_t Faces(std::int64_t p) const { return this->FaceStart[p + 1] - this->FaceStart[p]; }
  std::int64_t Points(std::int64_t p) const { return this->VertexStart[p + 1] - this->VertexStart[p]; }
  std::int64_t Slots() const { return this->SlotStart.back(); }
};

/// Cuts the mesh by planes across its longest extent into patches of at most @p largest faces, which are about as many
/// each. @p points are used for nothing else.
FacePatches CutIntoPatches(const PoissonOperators& operators, const PointMatrix& points, std::int64_t largest = 1024);

} // namespace surfsynth
