// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/FlowMatching/CoupledOffsets.h"

#include "Core/Operators/SurfaceOperators.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

namespace surfsynth
{

namespace
{
/// Radius of the vertices around a group of pairs over the distance of the coupling.
constexpr double SurroundingRadius = 2.0;
/// Least weight of such a vertex over its mass.
constexpr double LeastShare = 0.01;
/// Least weight of a corner in a place: on edges and corners rounding does not tell which triangle the place is in.
constexpr double OnCorner = 1e-9;
/// Corner of the cubes, in their sides: planes of symmetry, which are at 0, are no faces of cubes.
constexpr double CubeCorner = 0.37;
/// Part of the identity in the form that a rotation is found from: vertices on a line leave the turn about it open.
constexpr double TowardsRest = 1e-6;

/// Numbers of a cube, which may be larger than integers are.
using Cube = std::array<double, 3>;
/// Larger and smaller component of a pair, and the cube of its place.
using GroupKey = std::pair<std::pair<Index, Index>, Cube>;

/// Numbers of the components in the order of their areas; equal ones by their first points.
std::vector<Index> RanksOf(const MeshComponents& components, const PointMatrix& points)
{
  std::vector<std::array<double, 4>> keys(static_cast<std::size_t>(components.Count));
  for (Index v = static_cast<Index>(points.rows()) - 1; v >= 0; --v)
  {
    const Index c = components.OfVertex[v];
    if (c >= 0)
    {
      keys[c] = { components.Area[c], points(v, 0), points(v, 1), points(v, 2) };
    }
  }
  std::vector<Index> order(keys.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&keys](Index a, Index b) { return keys[a] < keys[b]; });
  std::vector<Index> ranks(order.size());
  for (std::size_t k = 0; k < order.size(); ++k)
  {
    ranks[order[k]] = static_cast<Index>(k);
  }
  return ranks;
}

/// The value at the far end of @p pair.
Eigen::RowVector3d FarEnd(const CoupledPair& pair, const PointMatrix& values)
{
  Eigen::RowVector3d value = Eigen::RowVector3d::Zero();
  for (int k = 0; k < 3; ++k)
  {
    value += pair.Weights[k] * values.row(pair.Corners[k]);
  }
  return value;
}

/// The difference between the ends of @p pair, a row of B f.
Eigen::RowVector3d Difference(const CoupledPair& pair, const PointMatrix& values)
{
  return values.row(pair.Vertex) - FarEnd(pair, values);
}

/// The rotation R with the largest trace of R' A.
Eigen::Matrix3d NearestRotation(const Eigen::Matrix3d& matrix)
{
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  signs[2] = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

/// The end of a pair on the larger one of its components.
struct LargerEnd
{
  std::pair<Index, Index> Components; ///< larger and smaller
  Eigen::RowVector3d Place;
  std::vector<Index> Corners; ///< vertices that the place is a mean of
};

/// @param of component of each vertex
LargerEnd LargerEndOf(
  const CoupledPair& pair, const std::vector<Index>& of, const std::vector<Index>& ranks, const PointMatrix& points)
{
  const Index near = of[pair.Vertex];
  const Index far = of[pair.Corners[0]];
  if (ranks[near] > ranks[far])
  {
    return { { near, far }, points.row(pair.Vertex), { pair.Vertex } };
  }
  LargerEnd end{ { far, near }, FarEnd(pair, points), {} };
  for (int k = 0; k < 3; ++k)
  {
    if (pair.Weights[k] > OnCorner)
    {
      end.Corners.push_back(pair.Corners[k]);
    }
  }
  return end;
}

/// Vertices that are joined to some by edges within a ball, and the first ones beyond.
class JoinedVertices
{
public:
  explicit JoinedVertices(const MeshTopology& topology)
    : Topology(topology)
    , IsFound(static_cast<std::size_t>(topology.NumberOfPoints()), 0)
  {}

  /// @param vertices those to begin with; each may be there several times
  std::vector<Index> Find(
    const std::vector<Index>& vertices, const PointMatrix& points, const Eigen::RowVector3d& center, double radius)
  {
    std::vector<Index> found;
    const auto add = [&](Index v) {
      if (!this->IsFound[v])
      {
        this->IsFound[v] = 1;
        found.push_back(v);
      }
    };
    std::for_each(vertices.begin(), vertices.end(), add);
    for (std::size_t next = 0; next < found.size(); ++next)
    {
      const Index v = found[next];
      if ((points.row(v) - center).squaredNorm() < radius * radius)
      {
        const auto neighbors = this->Topology.Neighbors.begin();
        std::for_each(
          neighbors + this->Topology.NeighborStart[v], neighbors + this->Topology.NeighborStart[v + 1], add);
      }
    }
    for (const Index v : found)
    {
      this->IsFound[v] = 0;
    }
    std::sort(found.begin(), found.end());
    return found;
  }

private:
  const MeshTopology& Topology;
  std::vector<char> IsFound;
};
} // namespace

CoupledOffsets::CoupledOffsets(const TriangleMesh& mesh, const MeshTopology& topology,
  const ComponentCoupling& coupling, std::shared_ptr<const CholeskySolver> solver, const Progress& progress)
  : Source(mesh.Points)
  , Mass(LumpedMass(mesh, topology))
  , Weight(coupling.Weight / this->Mass.sum())
  , Solver(std::move(solver))
{
  const MeshComponents components = ComputeComponents(topology, this->Mass);
  this->Pairs = FindCoupledPairs(mesh, components, coupling, SubProgress(progress, 0.0, 0.8));
  const double distance = LargestDistance(coupling, this->Mass.sum());
  this->MakeGroups(topology, components, distance, SubProgress(progress, 0.8, 1.0));
}

void CoupledOffsets::MakeGroups(
  const MeshTopology& topology, const MeshComponents& components, double distance, const Progress& progress)
{
  const std::vector<Index> ranks = RanksOf(components, this->Source);
  std::map<GroupKey, std::vector<std::size_t>> cubes;
  std::vector<LargerEnd> ends;
  for (const CoupledPair& pair : this->Pairs)
  {
    ends.push_back(LargerEndOf(pair, components.OfVertex, ranks, this->Source));
    const Eigen::RowVector3d place = (ends.back().Place / distance).array() + CubeCorner;
    const Cube cube{ std::floor(place[0]), std::floor(place[1]), std::floor(place[2]) };
    cubes[{ ends.back().Components, cube }].push_back(ends.size() - 1);
  }
  JoinedVertices joined(topology);
  for (const auto& [key, members] : cubes)
  {
    Eigen::RowVector3d center = Eigen::RowVector3d::Zero();
    std::vector<Index> corners;
    for (const std::size_t k : members)
    {
      center += ends[k].Place / static_cast<double>(members.size());
      corners.insert(corners.end(), ends[k].Corners.begin(), ends[k].Corners.end());
    }
    const double radius = SurroundingRadius * distance;
    Group group{ members, joined.Find(corners, this->Source, center, radius), {} };
    this->Weigh(group, center, radius);
    this->Groups.push_back(std::move(group));
    Report(progress, static_cast<double>(this->Groups.size()) / static_cast<double>(cubes.size()));
  }
}

void CoupledOffsets::Weigh(Group& group, const Eigen::RowVector3d& center, double radius) const
{
  group.Weights.resize(static_cast<Eigen::Index>(group.Vertices.size()));
  for (Eigen::Index k = 0; k < group.Weights.size(); ++k)
  {
    const Index v = group.Vertices[static_cast<std::size_t>(k)];
    const double share = std::max(1.0 - (this->Source.row(v) - center).squaredNorm() / (radius * radius), 0.0);
    group.Weights[k] = this->Mass[v] * std::max(share * share, LeastShare);
  }
}

Eigen::Matrix3d CoupledOffsets::RotationOf(const Group& group, const PointMatrix& positions) const
{
  const double total = group.Weights.sum();
  if (!(total > 0.0))
  {
    return Eigen::Matrix3d::Identity();
  }
  PointMatrix before(group.Weights.size(), 3), after(group.Weights.size(), 3);
  for (Eigen::Index k = 0; k < group.Weights.size(); ++k)
  {
    before.row(k) = this->Source.row(group.Vertices[static_cast<std::size_t>(k)]);
    after.row(k) = positions.row(group.Vertices[static_cast<std::size_t>(k)]);
  }
  const Eigen::RowVector3d meanBefore = group.Weights.transpose() * before / total;
  const Eigen::RowVector3d meanAfter = group.Weights.transpose() * after / total;
  before.rowwise() -= meanBefore;
  after.rowwise() -= meanAfter;
  Eigen::Matrix3d form = after.transpose() * group.Weights.asDiagonal() * before;
  form.diagonal().array() += TowardsRest * form.norm();
  return NearestRotation(form);
}

void CoupledOffsets::Restore(PointMatrix& positions) const
{
  RowMatrix moves = RowMatrix::Zero(positions.rows(), 3);
  for (const Group& group : this->Groups)
  {
    const Eigen::Matrix3d rotation = this->RotationOf(group, positions);
    for (const std::size_t k : group.Pairs)
    {
      const CoupledPair& pair = this->Pairs[k];
      const Eigen::RowVector3d missing = Difference(pair, this->Source) * rotation.transpose() -
        Difference(pair, positions);
      const Eigen::RowVector3d pull = this->Weight * this->Mass[pair.Vertex] * missing;
      moves.row(pair.Vertex) += pull;
      for (int corner = 0; corner < 3; ++corner)
      {
        moves.row(pair.Corners[corner]) -= pair.Weights[corner] * pull;
      }
    }
  }
  this->Solver->SolveInPlace(moves);
  const Eigen::RowVector3d mean = this->Mass.transpose() * moves / this->Mass.sum();
  moves.rowwise() -= mean;
  positions += moves;
}

} // namespace surfsynth
