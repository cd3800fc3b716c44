// SPDX-License-Identifier: BSD-3-Clause
#include "MeshProcessing/Repair/DisplacementReduction.h"

#include "MeshProcessing/Repair/SelfIntersections.h"

#include "Core/Mesh/EdgeDistances.h"
#include "Core/Mesh/MeshTopology.h"
#include "Core/Operators/SurfaceOperators.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace surfsynth
{

namespace
{
using TrianglePairs = std::vector<std::array<Index, 2>>;

constexpr double RoundFactor = 0.75;          ///< of the displacement at an intersection in one round
constexpr double MinimumFactor = 0.02;        ///< below it nothing is left
constexpr double RelativeFadeLength = 2.0;    ///< of a reduction, in lengths of the displacement
constexpr int MinimumRings = 3;               ///< of that length
constexpr int MaximumRings = 64;              ///< of that length
constexpr double NegligibleTangential = 0.02; ///< share of a displacement

/// Displaced mesh whose displacements are reduced round by round.
class Reduction
{
public:
  Reduction(const TriangleMesh& base, const PointMatrix& displacement, const std::atomic<bool>* stop)
    : Base(base)
    , Topology(base)
    , EdgeLength(MeanEdgeLength(base, this->Topology))
    , Normals(TangentFrames(base, this->Topology).Normal)
    , Area(LumpedMass(base, this->Topology))
    , Full(displacement)
    , Reduced(displacement)
    , Mesh(base)
    , Stop(stop)
    , TangentialFactor(Eigen::VectorXd::Ones(displacement.rows()))
    , NormalFactor(Eigen::VectorXd::Ones(displacement.rows()))
    , Ring(static_cast<std::size_t>(displacement.rows()), -1)
  {}

  ReducedDisplacement Run()
  {
    ReducedDisplacement result;
    result.HeightBefore = this->Height();
    std::array<bool, 2> isDone = { false, false };
    std::array<std::size_t, 2> left = { 0, 0 };
    for (std::size_t rounded = 1; !isDone[rounded]; rounded = 1 - rounded)
    {
      this->SetPoints(rounded == 1);
      TrianglePairs pairs = FindIntersectingPairs(this->Mesh, this->Stop);
      if (result.NumberOfPairsBefore == 0)
      {
        result.NumberOfPairsBefore = static_cast<std::int64_t>(pairs.size());
      }
      for (auto moved = this->Reduce(pairs); !moved.empty(); moved = this->Reduce(pairs))
      {
        isDone = { false, false };
        ++result.NumberOfRounds;
        this->SetPoints(rounded == 1);
        pairs = this->PairsAfter(pairs, moved);
      }
      isDone[rounded] = true;
      left[rounded] = pairs.size();
    }
    result.NumberOfPairsLeft = static_cast<std::int64_t>(std::max(left[0], left[1]));
    result.Height = this->Height();
    result.Displacement = std::move(this->Reduced);
    return result;
  }

private:
  double Height() const { return this->Reduced.cwiseProduct(this->Normals).rowwise().sum().cwiseAbs().dot(this->Area); }

  void SetPoints(bool isRounded)
  {
    this->Mesh.Points = this->Base.Points + this->Reduced;
    if (isRounded)
    {
      this->Mesh.Points = this->Mesh.Points.cast<float>().cast<double>().eval();
    }
  }

  std::array<Index, 6> Corners(const std::array<Index, 2>& pair) const
  {
    std::array<Index, 6> corners;
    for (std::size_t k = 0; k < corners.size(); ++k)
    {
      corners[k] = this->Base.Triangles(pair[k / 3], static_cast<Eigen::Index>(k % 3));
    }
    return corners;
  }

  double NormalPart(Index v) const { return this->Full.row(v).dot(this->Normals.row(v)); }

  /// True when more than a negligible part of the displacement is tangential.
  bool IsTangential(Index v) const
  {
    const Eigen::RowVector3d tangential = this->Full.row(v) - this->NormalPart(v) * this->Normals.row(v);
    return this->TangentialFactor[v] * tangential.norm() > NegligibleTangential * this->Full.row(v).norm();
  }

  /// Reduces the displacements at the corners of @p pairs and around them. Returns the points that have moved.
  std::vector<Index> Reduce(const TrianglePairs& pairs)
  {
    std::vector<Index> tangential, both;
    for (const auto& pair : pairs)
    {
      const std::array<Index, 6> corners = this->Corners(pair);
      const auto moves = [&](Index v) { return !this->Reduced.row(v).isZero(0.0); };
      if (std::any_of(corners.begin(), corners.end(), moves))
      {
        const bool any = std::any_of(corners.begin(), corners.end(), [&](Index v) { return this->IsTangential(v); });
        std::vector<Index>& marked = any ? tangential : both;
        marked.insert(marked.end(), corners.begin(), corners.end());
      }
    }
    std::vector<Index> moved;
    this->Fade(tangential, [&](Index v, double factor) { this->Scale(this->TangentialFactor[v], factor, v, moved); });
    this->Fade(both, [&](Index v, double factor) {
      this->Scale(this->TangentialFactor[v], factor, v, moved);
      this->Scale(this->NormalFactor[v], factor, v, moved);
    });
    std::sort(moved.begin(), moved.end());
    moved.erase(std::unique(moved.begin(), moved.end()), moved.end());
    for (const Index v : moved)
    {
      const Eigen::RowVector3d normal = this->NormalPart(v) * this->Normals.row(v);
      this->Reduced.row(v) = this->TangentialFactor[v] * (this->Full.row(v) - normal) + this->NormalFactor[v] * normal;
    }
    return moved;
  }

  void Scale(double& value, double factor, Index v, std::vector<Index>& moved) const
  {
    if (value > 0.0 && !this->Full.row(v).isZero(0.0))
    {
      value = value * factor < MinimumFactor ? 0.0 : value * factor;
      moved.push_back(v);
    }
  }

  /// Calls @p scale with the factor of each point of @p marked and of the rings of edges around them.
  template <typename ScaleFunction>
  void Fade(std::vector<Index> marked, const ScaleFunction& scale)
  {
    double longest = 0.0;
    for (const Index v : marked)
    {
      longest = std::max(longest, this->Full.row(v).norm());
      this->Ring[v] = 0;
    }
    std::sort(marked.begin(), marked.end());
    marked.erase(std::unique(marked.begin(), marked.end()), marked.end());
    const double wanted = std::ceil(RelativeFadeLength * longest / this->EdgeLength);
    const int rings = static_cast<int>(std::clamp<double>(wanted, MinimumRings, MaximumRings));
    for (std::size_t k = 0; k < marked.size(); ++k) // grows
    {
      const Index v = marked[k];
      const int ring = this->Ring[v];
      const double fading = 0.5 * (1.0 + std::cos(M_PI * ring / (rings + 1.0)));
      scale(v, 1.0 - (1.0 - RoundFactor) * fading);
      for (Index n = this->Topology.NeighborStart[v]; ring < rings && n < this->Topology.NeighborStart[v + 1]; ++n)
      {
        const Index neighbor = this->Topology.Neighbors[n];
        if (this->Ring[neighbor] < 0)
        {
          this->Ring[neighbor] = ring + 1;
          marked.push_back(neighbor);
        }
      }
    }
    for (const Index v : marked)
    {
      this->Ring[v] = -1;
    }
  }

  /// Returns the pairs that intersect after the points @p moved have moved.
  TrianglePairs PairsAfter(const TrianglePairs& before, const std::vector<Index>& moved) const
  {
    std::vector<bool> hasMoved(static_cast<std::size_t>(this->Base.NumberOfTriangles()), false);
    for (const Index v : moved)
    {
      const Index end = this->Topology.VertexTriangleStart[v + 1];
      for (Index k = this->Topology.VertexTriangleStart[v]; k < end; ++k)
      {
        hasMoved[this->Topology.VertexTriangles[k]] = true;
      }
    }
    std::vector<Index> triangles;
    for (Index f = 0; f < this->Base.NumberOfTriangles(); ++f)
    {
      if (hasMoved[f])
      {
        triangles.push_back(f);
      }
    }
    TrianglePairs pairs = FindIntersectingPairsOf(this->Mesh, triangles, this->Stop);
    for (const auto& pair : before)
    {
      if (!hasMoved[pair[0]] && !hasMoved[pair[1]])
      {
        pairs.push_back(pair);
      }
    }
    std::sort(pairs.begin(), pairs.end());
    return pairs;
  }

  const TriangleMesh& Base;
  MeshTopology Topology;
  double EdgeLength;
  PointMatrix Normals;
  Eigen::VectorXd Area;
  const PointMatrix& Full;
  PointMatrix Reduced;
  TriangleMesh Mesh;
  const std::atomic<bool>* Stop;
  Eigen::VectorXd TangentialFactor;
  Eigen::VectorXd NormalFactor;
  std::vector<int> Ring; ///< of each point during Fade(), else -1
};
} // namespace

ReducedDisplacement ReduceDisplacement(
  const TriangleMesh& base, const PointMatrix& displacement, const std::atomic<bool>* stop)
{
  return Reduction(base, displacement, stop).Run();
}

} // namespace surfsynth
