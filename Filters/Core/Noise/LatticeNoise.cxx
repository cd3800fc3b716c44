// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Noise/LatticeNoise.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Random/PlaceHash.h"

#include <Eigen/Geometry>
#include <Eigen/IterativeLinearSolvers>

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>
#include <utility>

namespace surfsynth
{

namespace
{
/// Lattice points of a brick along each axis. With 8 numbers for each point, of which 6 are used, a brick has the
/// 256 numbers that FillNormals() makes at a time.
constexpr std::array<int, 3> BrickShape = { 4, 4, 2 };
constexpr int NumbersOfPoint = 8;
constexpr int NumbersOfBrick = 256;
constexpr std::size_t MostBricks = std::size_t(1) << 20;

/// Longest edge, in sides of the lattice, of triangles whose corners carry the integrals.
constexpr double LongestCornerEdge = 1.0;
/// Most parts along an edge of larger triangles, and length of a part in sides of the lattice.
constexpr int MostParts = 16;
constexpr double LengthOfPart = 1.0;

/// Place of the integrals: a point of the surface with its share of the area.
struct Node
{
  Eigen::Vector3d Point;
  Eigen::Vector3d Direction; ///< unit
};

/// Number (c, d) with the weight w_c v_d at a node.
struct Member
{
  Index Number;
  double Weight;
};

/// Unit normals of the vertices, smoothed by one implicit step of diffusion over @p side: (M + side^2 L) n = M normal.
/// Any directions give noise of the same distribution, so that the accuracy of the solve does not matter much.
PointMatrix SmoothNormals(const TriangleMesh& mesh, const MeshTopology& topology, const Eigen::VectorXd& mass,
  const SparseMatrix& stiffness, double side)
{
  constexpr double Tolerance = 1e-4;
  constexpr int MostIterations = 300;
  const PointMatrix normals = TangentFrames(mesh, topology).Normal;
  SparseMatrix matrix = side * side * stiffness;
  matrix.diagonal() += (mass.array() > 0.0).select(mass, Eigen::VectorXd::Ones(mass.size()));
  Eigen::ConjugateGradient<SparseMatrix, Eigen::Lower | Eigen::Upper> solver;
  solver.setTolerance(Tolerance);
  solver.setMaxIterations(MostIterations);
  solver.compute(matrix);
  PointMatrix smooth(normals.rows(), 3);
  for (int axis = 0; axis < 3; ++axis)
  {
    smooth.col(axis) = solver.solveWithGuess(mass.cwiseProduct(normals.col(axis)), normals.col(axis));
  }
  for (Eigen::Index v = 0; v < smooth.rows(); ++v)
  {
    const double length = smooth.row(v).norm();
    if (length > 0.0 && std::isfinite(length))
    {
      smooth.row(v) /= length;
    }
    else
    {
      smooth.row(v) = normals.row(v);
    }
  }
  return smooth;
}

/// Collects the numbers at nodes, brick by brick.
class NumberFinder
{
public:
  explicit NumberFinder(double side)
    : Side(side)
  {}

  /// Finds the numbers at a node: at most 8 lattice points with 3 directions each.
  const std::vector<Member>& Find(const Node& node)
  {
    this->Members.clear();
    const Eigen::Vector3d place = node.Point / this->Side;
    const Eigen::Vector3d lower = place.array().floor();
    const Eigen::Vector3d fraction = place - lower;
    for (int corner = 0; corner < 8; ++corner)
    {
      std::array<std::int64_t, 3> point{};
      double weight = 1.0;
      for (int axis = 0; axis < 3; ++axis)
      {
        const bool upper = (corner >> axis & 1) != 0;
        point[static_cast<std::size_t>(axis)] = static_cast<std::int64_t>(lower[axis]) + upper;
        weight *= upper ? fraction[axis] : 1.0 - fraction[axis];
      }
      this->Add(point, weight, node.Direction);
    }
    return this->Members;
  }

  std::vector<std::uint64_t> Hashes; ///< by brick

private:
  void Add(const std::array<std::int64_t, 3>& point, double weight, const Eigen::Vector3d& direction)
  {
    if (!(weight > 0.0))
    {
      return;
    }
    std::array<std::uint64_t, 3> brick{};
    int slot = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const std::int64_t shape = BrickShape[axis];
      const std::int64_t remainder = (point[axis] % shape + shape) % shape;
      brick[axis] = static_cast<std::uint64_t>((point[axis] - remainder) / shape);
      slot = slot * BrickShape[axis] + static_cast<int>(remainder);
    }
    const Index first = this->BrickAt(HashOfPlace(brick)) * NumbersOfBrick + slot * NumbersOfPoint;
    for (int axis = 0; axis < 3; ++axis)
    {
      const double square = direction[axis] * direction[axis];
      if (weight * square > 0.0)
      {
        this->Members.push_back({ first + 2 * axis + (direction[axis] > 0.0), weight * square });
      }
    }
  }

  Index BrickAt(std::uint64_t hash)
  {
    const auto [found, isNew] = this->Bricks.emplace(hash, static_cast<Index>(this->Hashes.size()));
    if (isNew)
    {
      if (this->Hashes.size() >= MostBricks)
      {
        throw InvalidInput("LatticeNoise: the surface crosses more than " + std::to_string(MostBricks) +
          " blocks of the lattice of side " + FormatNumber(this->Side) + "; expected a longer correlation range.");
      }
      this->Hashes.push_back(hash);
    }
    return found->second;
  }

  double Side;
  std::unordered_map<std::uint64_t, Index> Bricks;
  std::vector<Member> Members;
};

/// Calls visit(barycentric coordinates, share of the area) for the centroids of @p parts * parts equal parts of a
/// triangle.
template <typename Visit>
void EachPart(int parts, const Visit& visit)
{
  const double share = 1.0 / (static_cast<double>(parts) * parts);
  for (int i = 0; i < parts; ++i)
  {
    for (int j = 0; i + j < parts; ++j)
    {
      for (int flipped = 0; flipped < (i + j + 1 < parts ? 2 : 1); ++flipped)
      {
        const double offset = flipped != 0 ? 2.0 / 3.0 : 1.0 / 3.0;
        const double s = (i + offset) / parts;
        const double t = (j + offset) / parts;
        visit(Eigen::Vector3d(1.0 - s - t, s, t), share);
      }
    }
  }
}

/// Corners of a triangle and the length of its longest edge.
struct Corners
{
  Corners(const TriangleMesh& mesh, Index f)
  {
    for (int k = 0; k < 3; ++k)
    {
      this->Points.row(k) = mesh.Points.row(mesh.Triangles(f, k));
    }
    for (int k = 0; k < 3; ++k)
    {
      this->LongestEdge = std::max(this->LongestEdge, (this->Points.row(k) - this->Points.row((k + 1) % 3)).norm());
    }
  }
  Eigen::Matrix3d Points;
  double LongestEdge = 0.0;
};

/// True for a triangle whose corners carry the integrals.
bool IsSmall(const Corners& corners, double side) { return corners.LongestEdge <= LongestCornerEdge * side; }

/// Unit direction at a place of a triangle.
Eigen::Vector3d DirectionAt(
  const TriangleMesh& mesh, Index f, const PointMatrix& directions, const Eigen::Vector3d& weights)
{
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k)
  {
    direction += weights[k] * directions.row(mesh.Triangles(f, k)).transpose();
  }
  const double length = direction.norm();
  return length > 0.0 ? Eigen::Vector3d(direction / length) : Eigen::Vector3d::UnitX();
}

/// Rows of shares, one vertex after the other, as compressed rows whose columns are slots: places in bricks.
class RowBuilder
{
public:
  explicit RowBuilder(NumberFinder& finder)
    : Finder(finder)
  {}

  /// Adds the numbers at a node to the row.
  void Add(const Node& node, double mass)
  {
    for (const Member& member : this->Finder.Find(node))
    {
      const auto slot = static_cast<std::size_t>(member.Number);
      if (slot >= this->Sums.size())
      {
        this->Sums.resize(this->Finder.Hashes.size() * NumbersOfBrick, 0.0);
        this->Areas.resize(this->Sums.size(), 0.0);
      }
      if (this->Sums[slot] == 0.0)
      {
        this->Touched.push_back(member.Number);
      }
      this->Sums[slot] += mass * member.Weight;
    }
  }

  /// Ends the row of a vertex.
  void EndRow()
  {
    std::sort(this->Touched.begin(), this->Touched.end());
    for (const Index slot : this->Touched)
    {
      double& sum = this->Sums[static_cast<std::size_t>(slot)];
      if (sum > 0.0)
      {
        this->Slots.push_back(slot);
        this->Values.push_back(sum);
        this->Areas[static_cast<std::size_t>(slot)] += sum;
      }
      sum = 0.0;
    }
    this->Touched.clear();
    this->Start.push_back(static_cast<Index>(this->Slots.size()));
  }

  std::vector<Index> Start = { 0 };
  std::vector<Index> Slots;
  std::vector<double> Values;
  std::vector<double> Areas; ///< by slot, sums over all rows

private:
  NumberFinder& Finder;
  std::vector<double> Sums; ///< by slot, of the row
  std::vector<Index> Touched;
};

/// Lumped mass without the consistent mass of the triangles that are not small: [V, V].
SparseMatrix MassDeficit(const TriangleMesh& mesh, double side)
{
  std::vector<Eigen::Triplet<double, Index>> entries;
  const Eigen::VectorXd areas = FaceAreas(mesh);
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    for (int k = 0; k < 9 && !IsSmall(Corners(mesh, f), side); ++k)
    {
      entries.emplace_back(
        mesh.Triangles(f, k / 3), mesh.Triangles(f, k % 3), areas[f] / (k / 3 == k % 3 ? 6.0 : -12.0));
    }
  }
  SparseMatrix deficit(mesh.NumberOfPoints(), mesh.NumberOfPoints());
  deficit.setFromTriplets(entries.begin(), entries.end());
  return deficit;
}
} // namespace

LatticeNoise::LatticeNoise(
  const TriangleMesh& mesh, const MeshTopology& topology, double side, const Progress& progress)
  : LatticeSide(side)
{
  if (!(side > 0.0) || !std::isfinite(side))
  {
    throw InvalidInput(
      "LatticeNoise: the side of the lattice is " + FormatNumber(side) + "; expected a finite number above 0.");
  }
  this->Mass = LumpedMass(mesh, topology);
  this->Stiffness = CotangentStiffness(mesh, topology);
  const PointMatrix directions = SmoothNormals(mesh, topology, this->Mass, this->Stiffness, side);
  this->Deficit = MassDeficit(mesh, side);
  Report(progress, 0.4);
  this->FindShares(mesh, topology, directions, SubProgress(progress, 0.4, 1.0));
}

void LatticeNoise::FindShares(
  const TriangleMesh& mesh, const MeshTopology& topology, const PointMatrix& directions, const Progress& progress)
{
  NumberFinder finder(this->LatticeSide);
  RowBuilder rows(finder);
  const Eigen::VectorXd areas = FaceAreas(mesh);
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    double cornerMass = 0.0;
    for (Index k = topology.VertexTriangleStart[v]; k < topology.VertexTriangleStart[v + 1]; ++k)
    {
      const Index f = topology.VertexTriangles[k];
      const Corners corners(mesh, f);
      if (IsSmall(corners, this->LatticeSide))
      {
        cornerMass += areas[f] / 3.0;
        continue;
      }
      const int corner = mesh.Triangles(f, 0) == v ? 0 : mesh.Triangles(f, 1) == v ? 1 : 2;
      const double parts = std::ceil(corners.LongestEdge / (LengthOfPart * this->LatticeSide));
      EachPart(static_cast<int>(std::min<double>(parts, MostParts)), [&](const Eigen::Vector3d& weights, double share) {
        rows.Add({ corners.Points.transpose() * weights, DirectionAt(mesh, f, directions, weights) },
          share * areas[f] * weights[corner]);
      });
    }
    if (cornerMass > 0.0)
    {
      rows.Add({ mesh.Points.row(v), directions.row(v) }, cornerMass);
    }
    rows.EndRow();
    if (v % 4096 == 0)
    {
      Report(progress, static_cast<double>(v) / mesh.NumberOfPoints());
    }
  }
  // Numbers with a share of the surface, in the order of bricks.
  std::vector<Index> numberOfSlot(rows.Areas.size(), -1);
  Index numbers = 0;
  for (std::size_t slot = 0; slot < rows.Areas.size(); ++slot)
  {
    if (slot % NumbersOfBrick == 0)
    {
      this->Bricks.push_back({ finder.Hashes[slot / NumbersOfBrick], {} });
    }
    if (rows.Areas[slot] > 0.0)
    {
      numberOfSlot[slot] = numbers++;
      this->Bricks.back().Slots.push_back(static_cast<std::uint8_t>(slot % NumbersOfBrick));
    }
  }
  for (std::size_t k = 0; k < rows.Slots.size(); ++k)
  {
    const auto slot = static_cast<std::size_t>(rows.Slots[k]);
    rows.Values[k] /= std::sqrt(rows.Areas[slot]);
    rows.Slots[k] = numberOfSlot[slot];
  }
  this->Shares = Eigen::Map<const SparseRowMatrix>(mesh.NumberOfPoints(), numbers,
    static_cast<Eigen::Index>(rows.Slots.size()), rows.Start.data(), rows.Slots.data(), rows.Values.data());
  Report(progress, 1.0);
}

LatticeNoise::Rows LatticeNoise::Numbers(const std::vector<NormalKey>& keys) const
{
  Rows numbers(this->Shares.cols(), static_cast<Eigen::Index>(keys.size()));
  std::array<double, NumbersOfBrick> normals{};
  Eigen::Index first = 0;
  for (const Brick& brick : this->Bricks)
  {
    // Points are below 2^34: 26 bits of the hash choose them, 32 others change the stream.
    const auto place = static_cast<std::int64_t>(brick.Hash >> 38) * NumbersOfBrick;
    for (std::size_t k = 0; k < keys.size(); ++k)
    {
      NormalKey key = keys[k];
      key.Stream ^= static_cast<std::uint32_t>(brick.Hash);
      FillNormals(key, place, NumbersOfBrick, normals.data());
      for (std::size_t s = 0; s < brick.Slots.size(); ++s)
      {
        numbers(first + static_cast<Eigen::Index>(s), static_cast<Eigen::Index>(k)) = normals[brick.Slots[s]];
      }
    }
    first += static_cast<Eigen::Index>(brick.Slots.size());
  }
  return numbers;
}

LatticeNoise::Rows LatticeNoise::Draw(const std::vector<NormalKey>& keys) const
{
  const Rows numbers = this->Numbers(keys);
  Rows loads = Rows::Zero(this->Shares.rows(), numbers.cols());
  for (Eigen::Index v = 0; v < loads.rows(); ++v)
  {
    for (SparseRowMatrix::InnerIterator share(this->Shares, v); share; ++share)
    {
      loads.row(v) += share.value() * numbers.row(share.col());
    }
  }
  this->FillDeficit(loads);
  this->Sharpen(loads);
  return loads;
}

void LatticeNoise::FillDeficit(Rows& loads) const
{
  if (this->Deficit.nonZeros() == 0)
  {
    return;
  }
  // The series of (1 - X)^-1/2 with X = D M^-1, whose eigenvalues are between 0 and 3 / 4, by Horner's rule.
  constexpr std::array<double, 4> Coefficients = { 5.0 / 16.0, 3.0 / 8.0, 1.0 / 2.0, 1.0 };
  Rows sum = 35.0 / 128.0 * loads;
  for (const double coefficient : Coefficients)
  {
    const Rows last = std::move(sum);
    sum = coefficient * loads;
    this->AddProduct(this->Deficit, 1.0, last, sum);
  }
  loads = std::move(sum);
}

void LatticeNoise::Sharpen(Rows& loads) const
{
  const Rows last = loads;
  this->AddProduct(this->Stiffness, this->LatticeSide * this->LatticeSide / 12.0, last, loads);
}

void LatticeNoise::AddProduct(const SparseMatrix& matrix, double factor, const Rows& loads, Rows& sum) const
{
  for (Eigen::Index j = 0; j < loads.rows(); ++j)
  {
    const double scale = this->Mass[j] > 0.0 ? factor / this->Mass[j] : 0.0;
    for (SparseMatrix::InnerIterator entry(matrix, j); entry; ++entry)
    {
      sum.row(entry.row()) += scale * entry.value() * loads.row(j);
    }
  }
}

LatticeNoise::Rows LatticeNoise::Covariates(const Eigen::Ref<const Eigen::MatrixXd>& functions) const
{
  // The transposes of the corrections are M^-1 times the corrections times M.
  Rows weighted = this->Mass.asDiagonal() * functions;
  this->Sharpen(weighted);
  this->FillDeficit(weighted);
  for (Eigen::Index v = 0; v < weighted.rows(); ++v)
  {
    weighted.row(v) *= this->Mass[v] > 0.0 ? 1.0 / this->Mass[v] : 0.0;
  }
  return this->Shares.transpose() * weighted;
}

} // namespace surfsynth
