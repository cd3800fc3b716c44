// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/SurfaceTemplate.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/MeshCheck.h"
#include "Core/Mesh/MeshStatistics.h"
#include "Core/Mesh/MidpointSubdivision.h"
#include "Core/Statistics/GeometricTextureFeatures.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace surfsynth
{

namespace
{
MeshTopology RequireManifold(const TriangleMesh& reference)
{
  MeshRequirements requirements;
  requirements.ManifoldVertices = requirements.ConsistentWinding = true;
  return RequireValidMesh(reference, requirements);
}

/// Euler characteristics and numbers of boundary loops of the components, in ascending order.
std::vector<std::pair<std::int64_t, std::int64_t>> TopologyOf(const TriangleMesh& mesh)
{
  std::vector<std::pair<std::int64_t, std::int64_t>> components;
  for (const ComponentStatistics& component : ComputeMeshStatistics(mesh).Components)
  {
    components.emplace_back(component.EulerCharacteristic, component.BoundaryLoops);
  }
  std::sort(components.begin(), components.end());
  return components;
}

std::string Describe(const std::vector<std::pair<std::int64_t, std::int64_t>>& components)
{
  std::int64_t euler = 0;
  std::int64_t loops = 0;
  for (const auto& [characteristic, boundaries] : components)
  {
    euler += characteristic;
    loops += boundaries;
  }
  return std::to_string(components.size()) + " components, Euler characteristic " + std::to_string(euler) + " and " +
    std::to_string(loops) + " boundary loops";
}

void RequireSameTopology(const TriangleMesh& reference, const TriangleMesh& coarse)
{
  const auto expected = TopologyOf(reference);
  const auto found = TopologyOf(coarse);
  if (found != expected)
  {
    throw SolverFailure("SurfaceTemplate: the template has " + Describe(found) + "; expected those of the reference, " +
      Describe(expected) + ".");
  }
}
} // namespace

SurfaceTemplate::SurfaceTemplate(
  const TriangleMesh& reference, Index triangles, double smoothingLength, const Progress& progress)
  : Reference(reference)
{
  const MeshTopology topology = RequireManifold(reference);
  const double area = SurfaceArea(reference) / std::max<Index>(1, triangles);
  const double length = smoothingLength > 0.0 ? smoothingLength : 0.5 * std::sqrt(4.0 * area / std::sqrt(3.0));
  const TriangleMesh form = SmoothedForm(reference, topology, length);
  this->Map = std::make_unique<SurfaceSimplification>(reference, triangles, progress);
  this->Coarse = { form.Points(this->Map->PointsOnInput(), Eigen::all), this->Map->Coarse().Triangles };
  RequireSameTopology(reference, this->Coarse);
}

TriangleMesh SurfaceTemplate::OnReference(int level) const
{
  // The subdivision of triangles that share no point says where the corners of each triangle lie in that of the template.
  const Index count = this->Mesh().NumberOfTriangles();
  TriangleMesh apart{ PointMatrix(3 * count, 3), TriangleMatrix(count, 3) };
  for (Index f = 0; f < count; ++f)
  {
    for (int k = 0; k < 3; ++k)
    {
      apart.Points.row(3 * f + k) = Eigen::RowVector3d::Unit(k);
      apart.Triangles(f, k) = 3 * f + k;
    }
  }
  TriangleMesh mesh = this->Mesh();
  for (int k = 0; k < level; ++k)
  {
    apart = SubdivideAtMidpoints(apart).Mesh;
    mesh = SubdivideAtMidpoints(mesh).Mesh;
  }
  std::vector<SurfacePlace> places(static_cast<std::size_t>(mesh.NumberOfPoints()));
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    for (int k = 0; k < 3; ++k)
    {
      places[mesh.Triangles(f, k)] = { f % count, apart.Points.row(apart.Triangles(f, k)).transpose() };
    }
  }
  places = this->Map->OnInput(places);
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    mesh.Points.row(v) = PositionOf(this->Reference, places[v]).transpose();
  }
  return mesh;
}

} // namespace surfsynth
