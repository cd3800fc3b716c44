// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// What the library and the program that runs TetGen say to each other, on one stream each way, in the byte order of the
/// machine. Both are built from this file. Private to the module.
///
/// Request: RequestHeader, points double[3 Points], triangles int32[3 Triangles], Seed[Seeds], and the end of the stream.
/// Reply: ReplyHeader and, when its Status is Done, new points double[3 Points], tetrahedra int32[4 Tetrahedra], regions
/// int32[Tetrahedra], neighbours int32[4 Tetrahedra] when they were asked for, faces int32[3 Faces], triangles
/// int32[Faces], and the end of the stream.
#pragma once

#include <cstdint>

namespace surfsynth
{
namespace tetgen
{

constexpr char RequestMagic[8] = { 'S', 'S', 'T', 'E', 'T', 'R', 'Q', '1' };
constexpr char ReplyMagic[8] = { 'S', 'S', 'T', 'E', 'T', 'R', 'P', '1' };

enum Task : std::int32_t
{
  Mesh = 0,             ///< make tetrahedra
  FindIntersections = 1 ///< only tell, as the Faces of the reply, which triangles intersect others
};

struct RequestHeader
{
  char Magic[8];
  std::int32_t Task;
  std::int32_t PreserveSurface; ///< no new points on the surface
  std::int32_t WantNeighbours;
  std::int32_t Unused;
  std::int64_t Points;
  std::int64_t Triangles;
  std::int64_t Seeds;
  double QualityRatio;         ///< largest ratio of circumradius to shortest edge, 0 for none
  double MinimumDihedralAngle; ///< degrees, 0 for none
  double MaximumVolume;        ///< 0 for none
  std::int64_t MemoryLimit;    ///< bytes of address space, 0 for none
};

/// A place inside a region.
struct Seed
{
  double Place[3];
  std::int64_t Region; ///< at least 0, or -1 where no tetrahedra are wanted
};

enum Status : std::int32_t
{
  Done = 0,
  Terminated = 1, ///< TetGen gave up with ReplyHeader::Code
  OutOfMemory = 2,
  BadRequest = 3
};

struct ReplyHeader
{
  char Magic[8];
  std::int32_t Status;
  std::int32_t Code;       ///< of Terminated, as TetGen's program would exit with
  std::int64_t Points;     ///< beyond those of the request
  std::int64_t Tetrahedra; ///< wound as VTK_TETRA
  std::int64_t Faces;      ///< the surface in the mesh, each with the triangle of the request that it is a part of
};

} // namespace tetgen
} // namespace surfsynth
