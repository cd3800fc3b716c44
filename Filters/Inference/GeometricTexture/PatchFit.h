// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Least-squares fit of displacements to patches. Private to the inference.
#pragma once

#include "Core/Mesh/TriangleMesh.h"
#include "Core/Operators/EdgeFeatures.h"
#include "Inference/GeometricTexture/TexturePatches.h"

#include <Eigen/Core>

#include <cstddef>
#include <functional>
#include <vector>

namespace surfsynth
{

/// Fit of the displacements of the vertices of a mesh to the values of overlapping patches. Where no patch is, displacements are
/// smooth.
class PatchFit
{
public:
  /// Keeps references to @p mesh and to the sets of patches, which lie on it.
  PatchFit(const TriangleMesh& mesh, std::vector<const TexturePatches*> sets);

  /// Sets the weights of the patches, for the fits that follow. @param factors for each set, [count], 1 in the mean
  void Weigh(std::vector<Eigen::VectorXf> factors);

  /// Returns the values of a patch of a set, [TexturePatches::Components].
  using RowOfPatch = std::function<const float*(std::size_t set, std::int64_t patch)>;
  /// Fits displacements to patches, by conjugate gradients that begin with @p displacement, [V, 3], world units.
  void Fit(const RowOfPatch& rowOf, SinglePoints& displacement) const;

private:
  SinglePoints RightHandSide(const RowOfPatch& rowOf, const SinglePoints& displacement) const;
  SinglePoints Apply(const SinglePoints& x) const;
  SinglePoints Divide(const SinglePoints& rows) const;

  const TriangleMesh& Mesh;
  std::vector<const TexturePatches*> Sets;
  Eigen::VectorXf Weights;              ///< of the samples
  std::vector<Eigen::VectorXf> Factors; ///< of the patches
  TexturePatches::TriangleProducts Products;
  Eigen::VectorXf Diagonal;
};

} // namespace surfsynth
