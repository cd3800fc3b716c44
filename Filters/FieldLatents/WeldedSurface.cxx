// SPDX-License-Identifier: BSD-3-Clause
#include "WeldedSurface.h"

#include "Core/Mesh/MeshCheck.h"
#include "Core/Mesh/WeldedPoints.h"

#include <cstddef>

namespace surfsynth
{

namespace
{
TriangleMesh MeshBetween(const TriangleMesh& mesh, const std::vector<Index>& vertices)
{
  TriangleMesh welded = mesh;
  for (Eigen::Index k = 0; k < welded.Triangles.size(); ++k)
  {
    Index& id = welded.Triangles.data()[k];
    id = vertices[static_cast<std::size_t>(id)];
  }
  return welded;
}

/// Unfolds the rings of a welded mesh after its check.
OneRings Unfold(const Surface& surface, const TriangleMesh& welded)
{
  MeshRequirements requirements;
  requirements.ManifoldVertices = true;
  requirements.ConsistentWinding = true;
  const MeshTopology topology = RequireValidMesh(
    welded, requirements, [&surface](std::int64_t f) { return surface.Cell(f); });
  return OneRings(welded, topology, TangentFrames(welded, topology));
}
} // namespace

WeldedSurface::WeldedSurface(const Surface& surface)
  : VertexOfPoint(WeldPoints(surface.Mesh))
  , Mesh(MeshBetween(surface.Mesh, this->VertexOfPoint))
  , Rings(Unfold(surface, this->Mesh))
{}

} // namespace surfsynth
