// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// One surface at several scales, for the training of geometric textures [Hertz2020]. Neither VTK nor torch.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

#include <cstdint>
#include <string>
#include <vector>

namespace surfsynth
{

/// Meshes of one surface, coarse to fine: the triangles of each level are those of SubdivideAtMidpoints() of the level
/// before, the points lie on the surface.
struct MultiscaleDataset
{
  std::vector<TriangleMesh> Levels; ///< level 0 first
  /// Template: the mesh that level 0 was fitted from and that a texture is synthesized on without a target. It has the
  /// triangles of level 0. Without points: level 0 itself.
  TriangleMesh Template;

  /// True when the dataset has a template of its own.
  bool HasTemplate() const { return this->Template.NumberOfPoints() > 0; }
};

/// Checks a dataset.
/// @throws InvalidInput naming the first level that has no triangle, a point that is not finite, or other triangles
/// than those of the level before subdivided at midpoints; or when the template has other triangles than level 0; or
/// when there is no level.
void CheckDataset(const MultiscaleDataset& dataset);

/// Mean length of the edges, each counted once, in units of the points; 0 without triangles.
double MeanEdgeLength(const TriangleMesh& mesh);

/// 64-bit hash of all levels and the template.
std::uint64_t ContentHash(const MultiscaleDataset& dataset);

/// Reads a dataset file: safetensors with the metadata `content` ("multiscale_surface") and `format_version` ("1"), and
/// for each level k = 0, 1, ... the tensors `levels.<k>.points` [V, 3] of a floating-point type and
/// `levels.<k>.triangles` [F, 3] integers; `template.points` [V, 3] may be absent, its triangles are those of level 0.
/// @throws InvalidInput when the file cannot be opened; FormatError when it breaks a rule of its format; ModelMismatch
/// when it is no such dataset.
MultiscaleDataset ReadMultiscaleDataset(const std::string& path);

/// Writes a dataset file: points in float64.
/// @throws InvalidInput as CheckDataset(), and when the file cannot be written.
void WriteMultiscaleDataset(const std::string& path, const MultiscaleDataset& dataset);

} // namespace surfsynth
