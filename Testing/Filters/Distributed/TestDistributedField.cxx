// SPDX-License-Identifier: BSD-3-Clause
// Fields on surfaces in pieces on ranks: what MaternField makes of the whole.
#include "ExampleMeshes.h"

#include "Core/Common/Errors.h"
#include "Core/Noise/MaternField.h"
#include "Distributed/DistributedMaternField.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <vector>

using namespace surfsynth;

namespace
{

const RankGroup& Ranks()
{
  static const RankGroup group = RankGroup::World();
  return group;
}

/// A closed surface, an open patch away from it, and points that no triangle uses.
TriangleMesh Whole()
{
  return test::WithUnreferencedPoints(
    test::Join(test::BumpySurface(3), test::Translated(test::PlanePatch(15, 10, 1.0, 1.0, 0.2), { 4.0, 0.0, 0.0 })));
}

/// Rank that holds triangle @p f: sectors around an axis through both parts of the mesh.
int OwnerOf(const TriangleMesh& mesh, Index f, int count)
{
  const Eigen::RowVector3d center = (mesh.Points.row(mesh.Triangles(f, 0)) + mesh.Points.row(mesh.Triangles(f, 1)) +
                                      mesh.Points.row(mesh.Triangles(f, 2))) /
    3.0;
  const double x = center[0] > 2.5 ? center[0] - 4.4 : center[0];
  const double angle = std::atan2(center[1] - (center[0] > 2.5 ? 0.4 : 0.0), x) + std::acos(-1.0);
  return std::min(static_cast<int>(angle / (2.0 * std::acos(-1.0)) * count), count - 1);
}

/// The triangles that @p isTaken takes, with the points that they use, and unused ones on rank 0.
MeshPiece PieceOf(const TriangleMesh& mesh, const std::function<bool(Index)>& isTaken, bool withUnused)
{
  std::vector<Index> triangles;
  std::vector<bool> used(static_cast<std::size_t>(mesh.NumberOfPoints()), false);
  std::vector<bool> usedByAny(used);
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    for (int k = 0; k < 3; ++k)
    {
      usedByAny[mesh.Triangles(f, k)] = true;
      used[mesh.Triangles(f, k)] = used[mesh.Triangles(f, k)] || isTaken(f);
    }
    if (isTaken(f))
    {
      triangles.push_back(f);
    }
  }
  MeshPiece piece;
  std::vector<Index> local(used.size(), -1);
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    if (used[v] || (withUnused && !usedByAny[v]))
    {
      local[v] = static_cast<Index>(piece.GlobalIds.size());
      piece.GlobalIds.push_back(v);
    }
  }
  piece.Mesh.Points.resize(static_cast<Eigen::Index>(piece.GlobalIds.size()), 3);
  for (std::size_t k = 0; k < piece.GlobalIds.size(); ++k)
  {
    piece.Mesh.Points.row(static_cast<Eigen::Index>(k)) = mesh.Points.row(piece.GlobalIds[k]);
  }
  piece.Mesh.Triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t k = 0; k < triangles.size(); ++k)
  {
    for (int corner = 0; corner < 3; ++corner)
    {
      piece.Mesh.Triangles(static_cast<Eigen::Index>(k), corner) = local[mesh.Triangles(triangles[k], corner)];
    }
  }
  return piece;
}

MeshPiece PieceOfRank(const TriangleMesh& mesh, int rank)
{
  return PieceOf(
    mesh, [&](Index f) { return OwnerOf(mesh, f, Ranks().Count()) == rank; }, rank == 0);
}

SampleRequest Request(std::uint32_t components = 1)
{
  SampleRequest request;
  request.Seed = 5;
  request.FirstSample = 3;
  request.NumberOfComponents = components;
  return request;
}

Eigen::MatrixXd Sample(DistributedMaternField& field, const MeshPiece& piece, const SampleRequest& request)
{
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> values(
    piece.Mesh.Points.rows(), request.NumberOfComponents);
  field.SampleInto(request, [&](std::uint32_t) { return values.data(); });
  return values;
}

/// Rows of @p whole that belong to the points with the ids of the piece.
Eigen::MatrixXd RowsOf(const Eigen::MatrixXd& whole, const std::vector<std::int64_t>& ids)
{
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(ids.size()), whole.cols());
  for (std::size_t k = 0; k < ids.size(); ++k)
  {
    rows.row(static_cast<Eigen::Index>(k)) = whole.row(ids[k]);
  }
  return rows;
}

std::string TextOf(const std::function<void()>& call)
{
  try
  {
    call();
  }
  catch (const Error& error)
  {
    return error.what();
  }
  return "nothing thrown";
}

std::vector<MaternFieldOptions> Cases()
{
  std::vector<MaternFieldOptions> cases(3);
  cases[1].OperatorPower = 4;
  cases[1].CorrelationRange = 0.5;
  cases[2].Mode = ScaleMode::NormalizedScreening;
  return cases;
}

TEST(DistributedField, SamplesAreThoseOfTheWholeTo1em8)
{
  const TriangleMesh mesh = Whole();
  const MeshPiece piece = PieceOfRank(mesh, Ranks().Rank());
  for (const MaternFieldOptions& options : Cases())
  {
    const MaternField whole(mesh, options);
    DistributedMaternField field(Ranks(), piece, options);
    const Eigen::MatrixXd expected = whole.Sample(Request(2));
    const Eigen::MatrixXd values = Sample(field, piece, Request(2));
    EXPECT_LE(
      (values - RowsOf(expected, piece.GlobalIds)).cwiseAbs().maxCoeff(), 1e-8 * expected.cwiseAbs().maxCoeff());
    EXPECT_EQ(field.NumberOfPoints(), mesh.NumberOfPoints());
    EXPECT_NEAR(field.EffectiveScreening(), whole.EffectiveScreening(), 1e-12 * whole.EffectiveScreening());
    EXPECT_NEAR(field.EffectiveCorrelationRange(), whole.EffectiveCorrelationRange(), 1e-12);
    EXPECT_NEAR(field.Gamma(), whole.Gamma(), 1e-12 * whole.Gamma());
    EXPECT_DOUBLE_EQ(field.LongestEdge(), whole.LongestEdge());
    EXPECT_GT(field.Iterations(), 3);
    EXPECT_LE(field.Iterations(), 60);
    EXPECT_LE(field.RelativeResidual(), 1e-10);
  }
}

TEST(DistributedField, TheSamePiecesGiveTheSameBits)
{
  const MeshPiece piece = PieceOfRank(Whole(), Ranks().Rank());
  DistributedMaternField first(Ranks(), piece, {});
  DistributedMaternField second(Ranks(), piece, {});
  const Eigen::MatrixXd values = Sample(first, piece, Request());
  EXPECT_EQ(values, Sample(second, piece, Request()));
  EXPECT_EQ(values, Sample(first, piece, Request()));
}

TEST(DistributedField, PointsWithoutIdsAreThoseOfTheSameCoordinatesInTheOrderOfRanks)
{
  const TriangleMesh mesh = Whole();
  TriangleMesh gathered;
  std::map<std::int64_t, std::int64_t> places; // in the gathered mesh, of points of the mesh
  std::vector<std::int64_t> order;
  std::vector<Index> triangles;
  for (int rank = 0; rank < Ranks().Count(); ++rank)
  {
    const MeshPiece piece = PieceOfRank(mesh, rank);
    for (const std::int64_t id : piece.GlobalIds)
    {
      if (places.emplace(id, static_cast<std::int64_t>(order.size())).second)
      {
        order.push_back(id);
      }
    }
    for (Eigen::Index k = 0; k < piece.Mesh.Triangles.size(); ++k)
    {
      triangles.push_back(static_cast<Index>(places.at(piece.GlobalIds[piece.Mesh.Triangles.data()[k]])));
    }
  }
  gathered.Points = RowsOf(mesh.Points, order);
  gathered.Triangles = Eigen::Map<TriangleMatrix>(triangles.data(), static_cast<Eigen::Index>(triangles.size() / 3), 3);
  const Eigen::MatrixXd expected = MaternField(gathered, {}).Sample(Request());

  MeshPiece piece = PieceOfRank(mesh, Ranks().Rank());
  std::vector<std::int64_t> ids;
  for (const std::int64_t id : piece.GlobalIds)
  {
    ids.push_back(places.at(id));
  }
  piece.GlobalIds.clear();
  DistributedMaternField field(Ranks(), piece, {});
  const Eigen::MatrixXd values = Sample(field, piece, Request());
  EXPECT_LE((values - RowsOf(expected, ids)).cwiseAbs().maxCoeff(), 1e-8 * expected.cwiseAbs().maxCoeff());
}

TEST(DistributedField, CellsOfSeveralRanksCountOnceAndPointsOfOtherRanksGetTheirValues)
{
  const TriangleMesh mesh = Whole();
  const int rank = Ranks().Rank();
  const int count = Ranks().Count();
  // Also the triangles of the next rank, and all points of the mesh, as ghost points.
  const auto isTaken = [&](Index f) {
    const int owner = OwnerOf(mesh, f, count);
    return owner == rank || owner == (rank + 1) % count;
  };
  MeshPiece piece = PieceOf(mesh, isTaken, true);
  for (Eigen::Index k = 0; k < piece.Mesh.Triangles.size(); ++k)
  {
    Index& corner = piece.Mesh.Triangles.data()[k];
    corner = static_cast<Index>(piece.GlobalIds[static_cast<std::size_t>(corner)]);
  }
  piece.Mesh.Points = mesh.Points;
  piece.GlobalIds.resize(static_cast<std::size_t>(mesh.NumberOfPoints()));
  for (std::size_t k = 0; k < piece.GlobalIds.size(); ++k)
  {
    piece.GlobalIds[k] = static_cast<std::int64_t>(k);
  }
  const Eigen::MatrixXd expected = MaternField(mesh, {}).Sample(Request());
  for (const bool withIds : { true, false })
  {
    if (!withIds)
    {
      piece.GlobalIds.clear();
    }
    DistributedMaternField field(Ranks(), piece, {});
    const Eigen::MatrixXd values = Sample(field, piece, Request());
    EXPECT_LE((values - expected).cwiseAbs().maxCoeff(), 1e-8 * expected.cwiseAbs().maxCoeff()) << withIds;
  }
}

TEST(DistributedField, SeamsHaveOneValueAndARankMayHoldNothing)
{
  const TriangleMesh mesh = Whole();
  const int last = Ranks().Count() - 1;
  const int rank = Ranks().Rank();
  const bool single = last == 0;
  const MeshPiece piece = PieceOf(
    mesh, [&](Index f) { return single || (rank < last && OwnerOf(mesh, f, last) == rank); }, rank == 0);
  DistributedMaternField field(Ranks(), piece, {});
  const Eigen::MatrixXd values = Sample(field, piece, Request());
  EXPECT_EQ(values.rows() > 0, single || rank < last);
  struct Value
  {
    std::int64_t Id;
    double Number;
  };
  std::vector<Value> mine;
  for (std::size_t k = 0; k < piece.GlobalIds.size(); ++k)
  {
    mine.push_back({ piece.GlobalIds[k], values(static_cast<Eigen::Index>(k), 0) });
  }
  std::map<std::int64_t, double> known;
  std::size_t shared = 0;
  for (const Value& value : Ranks().GatherAll(mine))
  {
    const auto entry = known.emplace(value.Id, value.Number);
    EXPECT_EQ(entry.first->second, value.Number); // the same bits
    shared += entry.second ? 0U : 1U;
  }
  EXPECT_EQ(known.size(), static_cast<std::size_t>(mesh.NumberOfPoints()));
  EXPECT_EQ(shared > 0, last > 1);
}

TEST(DistributedField, ErrorsOfOneRankAreThoseOfAll)
{
  const int last = Ranks().Count() - 1;
  MeshPiece flat = PieceOfRank(Whole(), Ranks().Rank());
  if (Ranks().Rank() == last)
  {
    flat.Mesh.Points.row(flat.Mesh.Triangles(0, 1)) = flat.Mesh.Points.row(flat.Mesh.Triangles(0, 0));
  }
  flat.GlobalIds.clear();
  const std::string text = TextOf([&] { DistributedMaternField(Ranks(), flat, {}); });
  EXPECT_THAT(text, testing::HasSubstr("degenerate"));
  if (last > 0)
  {
    EXPECT_THAT(text, testing::StartsWith("Rank " + std::to_string(last) + ": "));
  }
  MeshPiece wrong = PieceOfRank(Whole(), Ranks().Rank());
  if (Ranks().Rank() == last)
  {
    wrong.GlobalIds.pop_back();
  }
  EXPECT_THAT(
    TextOf([&] { DistributedMaternField(Ranks(), wrong, {}); }), testing::HasSubstr("expected as many ids as points"));
}

TEST(DistributedField, AnEdgeOfThreeTrianglesOnDifferentRanksIsRefused)
{
  TriangleMesh fin;
  fin.Points.resize(5, 3);
  fin.Points << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1;
  fin.Triangles.resize(3, 3);
  fin.Triangles << 0, 1, 2, 1, 0, 3, 0, 1, 4;
  const MeshPiece piece = PieceOf(
    fin, [](Index f) { return f % Ranks().Count() == Ranks().Rank(); }, false);
  const std::string text = TextOf([&] { DistributedMaternField(Ranks(), piece, {}); });
  EXPECT_THAT(text, testing::HasSubstr("non-manifold edge"));
  EXPECT_THAT(text, testing::HasSubstr("0"));
}

TEST(DistributedField, OptionsThatNeedTheWholeFactorAreRefused)
{
  const MeshPiece piece = PieceOfRank(Whole(), Ranks().Rank());
  const auto textFor = [&](const std::function<void(MaternFieldOptions&)>& change) {
    MaternFieldOptions options;
    change(options);
    return TextOf([&] { DistributedMaternField(Ranks(), piece, options); });
  };
  EXPECT_THAT(textFor([](auto& o) { o.Model = NoiseModel::White; }), testing::HasSubstr("noise model"));
  EXPECT_THAT(textFor([](auto& o) { o.OperatorPower = 3; }), testing::HasSubstr("operator power"));
  EXPECT_THAT(textFor([](auto& o) { o.VarianceCorrection = true; }), testing::HasSubstr("variance is corrected"));
  EXPECT_THAT(
    textFor([](auto& o) { o.Boundary = BoundaryCondition::Robin; }), testing::HasSubstr("boundary condition"));
  EXPECT_THAT(textFor([](auto& o) { o.CoherentNoise = true; }), testing::HasSubstr("coherent"));
  EXPECT_THAT(textFor([](auto& o) { o.Arrays.Barrier.push_back(true); }), testing::HasSubstr("arrays"));
  EXPECT_THAT(textFor([](auto& o) { o.CorrelationRange = -1.0; }), testing::HasSubstr("the correlation range is -1"));
}

TEST(DistributedField, StopsOnAllRanksWhenOneAsks)
{
  const MeshPiece piece = PieceOfRank(Whole(), Ranks().Rank());
  const bool asks = Ranks().Rank() == Ranks().Count() - 1;
  EXPECT_THROW(DistributedMaternField(Ranks(), piece, {}, [&](double) { return !asks; }), Cancelled);
  DistributedMaternField field(Ranks(), piece, {});
  Eigen::VectorXd values(piece.Mesh.Points.rows());
  int reports = 0;
  double before = 0.0;
  const auto stop = [&](double fraction) {
    EXPECT_GE(fraction, before);
    before = fraction;
    return ++reports < 5 || !asks;
  };
  EXPECT_THROW(field.SampleInto(
                 Request(), [&](std::uint32_t) { return values.data(); }, stop),
    Cancelled);
  EXPECT_EQ(reports, 5);
  EXPECT_GT(Sample(field, piece, Request()).cwiseAbs().maxCoeff(), 0.1); // and goes on
}

TEST(DistributedField, GroupsAreMadeOfRanksOfTheWorld)
{
  std::vector<int> backwards;
  for (int rank = Ranks().Count() - 1; rank >= 0; --rank)
  {
    backwards.push_back(rank);
  }
  const RankGroup group = RankGroup::OfWorldRanks(backwards);
  EXPECT_EQ(group.Rank(), Ranks().Count() - 1 - Ranks().Rank());
  EXPECT_EQ(RankGroup::WorldRank(), Ranks().Rank());
  EXPECT_THROW(RankGroup::OfWorldRanks({ 0, 0 }), InvalidInput);
  EXPECT_EQ(group.GatherAll(std::vector<int>{ group.Rank() }).back(), Ranks().Count() - 1);
}

} // namespace
