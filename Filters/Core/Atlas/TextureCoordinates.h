// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Texture coordinates of triangle corners, and their defects.
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace surfsynth
{

/// Texture coordinates (u, v) of the corners of triangles, [3 F, 2] float64: corner k of triangle f in row 3 f + k. u points
/// to the right and v upwards; the image covers [0, 1] x [0, 1], and its row 0 is at v = 0, as in VTK images.
using TextureCoordinates = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>;

/// Defects of texture coordinates. Ids are triangles.
enum class AtlasDefect
{
  NonFiniteCoordinate, ///< a corner has a NaN or infinite coordinate
  OutsideUnitSquare,   ///< a corner lies outside [0, 1] x [0, 1] by more than 1e-4: a repeated texture
  DegenerateTriangle,  ///< the area in the texture is zero (below 1e-12 of the longest side squared)
  FlippedTriangle,     ///< wound the other way in the texture than the triangles with the larger part of its area
  OverlappingTriangles ///< texels whose centers lie inside several triangles; found by RasterizeAtlas()
};

/// One kind of defect found in texture coordinates.
struct AtlasFinding
{
  AtlasDefect Defect;       ///< kind
  std::int64_t Count = 0;   ///< number of triangles with it; texels for OverlappingTriangles
  std::int64_t First = 0;   ///< the lowest triangle with it
  std::int64_t Second = -1; ///< OverlappingTriangles: the lowest other triangle that overlaps it; else -1
};

/// Finds the defects of texture coordinates but for overlaps, in the order of AtlasDefect. Triangles with a coordinate
/// that is not finite have no other defect. O(F).
/// @param numberOfTriangles F of the mesh
/// @throws InvalidInput when the coordinates are missing: when they are not 3 F.
std::vector<AtlasFinding> CheckTextureCoordinates(
  const TextureCoordinates& coordinates, std::int64_t numberOfTriangles);

/// Sentences about the findings, one for each: the defect, its number, the first ids and a remedy.
/// @param cellOfTriangle turns triangle ids into the caller's cell ids; empty when they are the same
std::string DescribeAtlasFindings(
  const std::vector<AtlasFinding>& findings, const std::function<std::int64_t(std::int64_t)>& cellOfTriangle = {});

} // namespace surfsynth
