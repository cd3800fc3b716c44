// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Protocol between the library and the program that runs TetGen: one stream each way, in the byte order of the
/// machine. Both are built from this file. Private to the mesh processing.
///
/// Request: RequestHeader, points double[3 Points], triangles int32[3 Triangles], Seed[Seeds], and the end of the
/// stream. Reply: ReplyHeader and, when its Status is Done, new points double[3 Points], tetrahedra int32[4
/// Tetrahedra], regions int32[Tetrahedra], neighbours int32[4 Tetrahedra] when they were asked for, faces int32[3
/// Faces], triangles int32[Faces], and the end of the stream.
#pragma once

#include <cstdint>

namespace surfsynth
{
namespace tetgen
{

/// First bytes of a request.
constexpr char RequestMagic[8] = { 'S', 'S', 'T', 'E', 'T', 'R', 'Q', '1' };
/// First bytes of a reply.
constexpr char ReplyMagic[8] = { 'S', 'S', 'T', 'E', 'T', 'R', 'P', '1' };

/// Task of a request.
enum Task : std::int32_t
{
  Mesh = 0,             ///< make tetrahedra
  FindIntersections = 1 ///< only find the triangles that intersect others: the Faces of the reply
};

/// Header of a request.
struct RequestHeader
{
  char Magic[8];                ///< RequestMagic
  std::int32_t Task;            ///< a Task
  std::int32_t PreserveSurface; ///< not 0: no new points on the surface
  std::int32_t WantNeighbors;   ///< not 0: the reply has neighbours
  std::int32_t Unused;          ///< 0
  std::int64_t Points;          ///< number of points
  std::int64_t Triangles;       ///< number of triangles
  std::int64_t Seeds;           ///< number of seeds
  double QualityRatio;          ///< largest ratio of circumradius to shortest edge, 0 for none
  double MinimumDihedralAngle;  ///< degrees, 0 for none
  double MaximumVolume;         ///< 0 for none
  std::int64_t MemoryLimit;     ///< bytes of address space, 0 for none
};

/// A place inside a region.
struct Seed
{
  double Place[3];     ///< coordinates
  std::int64_t Region; ///< number of the region, at least 0, or -1 for a region without tetrahedra
};

/// Status of a reply.
enum Status : std::int32_t
{
  Done = 0,        ///< tetrahedra follow
  Terminated = 1,  ///< TetGen gave up with ReplyHeader::Code
  OutOfMemory = 2, ///< the memory limit was reached
  BadRequest = 3   ///< the request was malformed
};

/// Header of a reply.
struct ReplyHeader
{
  char Magic[8];           ///< ReplyMagic
  std::int32_t Status;     ///< a Status
  std::int32_t Code;       ///< exit code of TetGen, of Terminated
  std::int64_t Points;     ///< number of new points
  std::int64_t Tetrahedra; ///< number of tetrahedra, wound as VTK_TETRA
  std::int64_t Faces;      ///< number of faces of the surface in the mesh, each a part of a triangle of the request
};

} // namespace tetgen
} // namespace surfsynth
