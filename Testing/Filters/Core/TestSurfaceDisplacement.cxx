// SPDX-License-Identifier: BSD-3-Clause
#include "ExampleMeshes.h"
#include "ThrownText.h"

#include "Core/Common/Errors.h"
#include "Core/Noise/FieldConditioning.h"
#include "Core/Noise/MaternField.h"
#include "Core/Noise/SurfaceDisplacement.h"
#include "Core/Operators/SurfaceOperators.h"
#include "Core/Solvers/LinearSolver.h"

#include <Eigen/Dense>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

using namespace surfsynth;
using surfsynthtest::TextOf;
using testing::HasSubstr;

namespace
{
constexpr double Range = 0.9;
constexpr double Deviation = 0.07;
constexpr std::uint64_t Unlimited = std::uint64_t(1) << 40;
using Directions = DisplacementDirections;

double MaximumNorm(const Eigen::MatrixXd& matrix) { return matrix.cwiseAbs().maxCoeff(); }

/// Displacements of a small closed surface without symmetry, whose fields have an exact deviation.
class DisplacedSurface : public testing::Test
{
protected:
  const TriangleMesh Mesh = test::BumpySurface(2);
  const Index Points = this->Mesh.NumberOfPoints();
  const PointMatrix Normals = TangentFrames(this->Mesh, MeshTopology(this->Mesh)).Normal;
  const MaternField Field = MakeField(this->Mesh);
  const Eigen::MatrixXd Dense = this->Field.SolvePrecision(Eigen::MatrixXd::Identity(this->Points, this->Points));

  static MaternField MakeField(const TriangleMesh& mesh)
  {
    MaternFieldOptions options;
    options.CorrelationRange = Range;
    options.StandardDeviation = Deviation;
    options.VarianceCorrection = true;
    return MaternField(mesh, options);
  }

  SurfaceDisplacement Displacement(Directions directions) const { return { directions, this->Points, this->Normals }; }

  /// The linear map from the fields, those of a vertex side by side, to displacements, [3 V, fields V].
  Eigen::MatrixXd DenseMap(Directions directions) const
  {
    const int fields = directions == Directions::Normal ? 1 : 3;
    Eigen::MatrixXd map = Eigen::MatrixXd::Zero(3 * this->Points, fields * this->Points);
    for (Index v = 0; v < this->Points; ++v)
    {
      const Eigen::Vector3d n = this->Normals.row(v);
      const Eigen::Matrix3d tangent = Eigen::Matrix3d::Identity() - n * n.transpose();
      map.block(3 * v, fields * v, 3, fields) = directions == Directions::Normal ? Eigen::MatrixXd(n)
        : directions == Directions::Tangential                                   ? Eigen::MatrixXd(tangent)
                                               : Eigen::MatrixXd(Eigen::Matrix3d::Identity());
    }
    return map;
  }

  /// The same map as ToDisplacements() has it, column by column.
  Eigen::MatrixXd MapOf(const SurfaceDisplacement& displacement) const
  {
    Eigen::MatrixXd map = Eigen::MatrixXd::Zero(3 * this->Points, displacement.NumberOfFields() * this->Points);
    for (Eigen::Index k = 0; k < map.cols(); ++k)
    {
      map(k, k) = 1.0; // the fields lie in front
      displacement.ToDisplacements(map.col(k).data());
    }
    return map;
  }

  /// Covariance of the displacements, [3 V, 3 V].
  Eigen::MatrixXd DenseCovariance(Directions directions) const
  {
    return this->DenseCovariance(directions, this->DenseMap(directions));
  }
  Eigen::MatrixXd DenseCovariance(Directions directions, const Eigen::MatrixXd& map) const
  {
    const int fields = directions == Directions::Normal ? 1 : 3;
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(fields * this->Points, fields * this->Points);
    for (Index a = 0; a < this->Points; ++a)
    {
      for (Index b = 0; b < this->Points; ++b)
      {
        covariance.block(fields * a, fields * b, fields, fields).diagonal().setConstant(this->Dense(a, b));
      }
    }
    return map * covariance * map.transpose();
  }

  /// Three vertices and three places inside triangles.
  std::vector<SurfacePlace> Places() const
  {
    std::vector<SurfacePlace> places;
    for (Index k = 0; k < 6; ++k)
    {
      SurfacePlace place{ static_cast<Index>(k * this->Mesh.NumberOfTriangles() / 6) };
      place.Weights = k % 2 == 0 ? Eigen::Vector3d(1.0, 0.0, 0.0) : Eigen::Vector3d(0.2, 0.5, 0.3);
      places.push_back(place);
    }
    return places;
  }

  Eigen::RowVector3d Along(const SurfacePlace& place) const
  {
    Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
    for (int k = 0; k < 3; ++k)
    {
      sum += place.Weights[k] * this->Normals.row(this->Mesh.Triangles(place.Triangle, k));
    }
    return sum.normalized();
  }

  /// Displacements of the places, in the directions.
  Eigen::MatrixXd Observed(Directions directions) const
  {
    Eigen::MatrixXd values(6, 3);
    for (Index k = 0; k < 6; ++k)
    {
      const Eigen::RowVector3d any(0.05 * std::sin(k + 1.0), 0.08 * std::cos(2.0 * k), 0.03 * k - 0.1);
      const Eigen::RowVector3d normal = this->Along(this->Places()[static_cast<std::size_t>(k)]);
      const Eigen::RowVector3d along = normal.dot(any) * normal;
      values.row(k) = directions == Directions::Normal ? along
        : directions == Directions::Tangential         ? Eigen::RowVector3d(any - along)
                                                       : any;
    }
    return values;
  }

  static Eigen::VectorXd Deviations()
  {
    Eigen::VectorXd deviations = Eigen::VectorXd::Zero(6);
    deviations[2] = 0.02;
    deviations[3] = 0.01;
    return deviations;
  }

  FieldConditioning Conditioning(
    const SurfaceDisplacement& displacement, const DisplacementObservations& observations) const
  {
    const auto product = [this](const Eigen::Ref<const Eigen::MatrixXd>& x) { return this->Field.SolvePrecision(x); };
    return { displacement.Covariance(product), observations.Matrix, observations.Deviations, Unlimited };
  }

  /// Displacements, [V, 3], of the unknowns.
  RowMatrix ToRows(const SurfaceDisplacement& displacement, const Eigen::MatrixXd& unknowns) const
  {
    RowMatrix rows = RowMatrix::Zero(this->Points, 3);
    Eigen::Map<RowMatrix>(rows.data(), unknowns.rows(), unknowns.cols()) = unknowns;
    displacement.ToDisplacements(rows.data());
    return rows;
  }
};

/// Parts of displacements at the places that the directions know: rows of an observation matrix, [m, 3 V].
Eigen::MatrixXd DenseObservations(const TriangleMesh& mesh, const std::vector<SurfacePlace>& places,
  const std::vector<std::vector<Eigen::RowVector3d>>& axes)
{
  std::vector<Eigen::RowVectorXd> rows;
  for (std::size_t i = 0; i < places.size(); ++i)
  {
    for (const Eigen::RowVector3d& axis : axes[i])
    {
      Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(3 * mesh.NumberOfPoints());
      for (int k = 0; k < 3; ++k)
      {
        row.segment<3>(3 * mesh.Triangles(places[i].Triangle, k)) += places[i].Weights[k] * axis;
      }
      rows.push_back(row);
    }
  }
  Eigen::MatrixXd matrix(static_cast<Eigen::Index>(rows.size()), 3 * mesh.NumberOfPoints());
  for (std::size_t r = 0; r < rows.size(); ++r)
  {
    matrix.row(static_cast<Eigen::Index>(r)) = rows[r];
  }
  return matrix;
}
} // namespace

TEST_F(DisplacedSurface, CovarianceHasTheDeviationAlongTheDirectionsAndNoneAcross)
{
  for (const Directions directions : { Directions::Free, Directions::Normal, Directions::Tangential })
  {
    const SurfaceDisplacement displacement = this->Displacement(directions);
    const Eigen::MatrixXd covariance = this->DenseCovariance(directions, this->MapOf(displacement));
    if (directions == Directions::Tangential)
    {
      const auto product = [this](const Eigen::Ref<const Eigen::MatrixXd>& x) { return this->Field.SolvePrecision(x); };
      const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(3 * this->Points, 3 * this->Points);
      EXPECT_LE(MaximumNorm(displacement.Covariance(product)(identity) - covariance), 1e-12);
    }
    for (Index v = 0; v < this->Points; ++v)
    {
      const Eigen::Vector3d n = this->Normals.row(v);
      const Eigen::Matrix3d along = n * n.transpose();
      const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - along;
      const Eigen::Matrix3d expected = directions == Directions::Normal ? along
        : directions == Directions::Tangential                          ? across
                                                                        : Eigen::Matrix3d::Identity();
      EXPECT_LE(MaximumNorm(covariance.block<3, 3>(3 * v, 3 * v) - Deviation * Deviation * expected), 1e-12) << v;
    }
  }
}

TEST_F(DisplacedSurface, SampledDeviationsAreWithinTwoPercentAlongEveryDirection)
{
  // 40,000 samples: a standard error of 0.36 %, so that 2 % are 5.6 of them.
  constexpr std::uint32_t Samples = 40000;
  for (const Directions directions : { Directions::Free, Directions::Normal, Directions::Tangential })
  {
    const SurfaceDisplacement displacement = this->Displacement(directions);
    SampleRequest request;
    request.Seed = 5;
    request.NumberOfSamples = Samples;
    request.NumberOfComponents = static_cast<std::uint32_t>(displacement.NumberOfFields());
    Eigen::MatrixXd squares = Eigen::MatrixXd::Zero(this->Points, 3); // along the normal and two tangents
    const VertexFrames frames = TangentFrames(this->Mesh, MeshTopology(this->Mesh));
    this->Field.Sample(request, [&](std::uint32_t, const Eigen::Ref<const Eigen::MatrixXd>& fields) {
      const RowMatrix moves = this->ToRows(displacement, fields);
      squares.col(0) += moves.cwiseProduct(frames.Normal).rowwise().sum().cwiseAbs2();
      squares.col(1) += moves.cwiseProduct(frames.X).rowwise().sum().cwiseAbs2();
      squares.col(2) += moves.cwiseProduct(0.6 * frames.X + 0.8 * frames.Y).rowwise().sum().cwiseAbs2();
    });
    const Eigen::MatrixXd deviations = (squares / Samples).cwiseSqrt() / Deviation;
    for (int axis = 0; axis < 3; ++axis)
    {
      const bool isIn = directions == Directions::Free || (directions == Directions::Normal) == (axis == 0);
      EXPECT_LE(MaximumNorm(deviations.col(axis).array() - (isIn ? 1.0 : 0.0)), isIn ? 0.02 : 1e-12) << axis;
    }
  }
}

TEST_F(DisplacedSurface, PosteriorIsThatOfDenseKriging)
{
  const std::vector<SurfacePlace> places = this->Places();
  for (const Directions directions : { Directions::Free, Directions::Normal, Directions::Tangential })
  {
    const SurfaceDisplacement displacement = this->Displacement(directions);
    const Eigen::MatrixXd values = this->Observed(directions);
    const DisplacementObservations observations = displacement.Observe(this->Mesh, places, values, this->Deviations());
    const FieldConditioning conditioning = this->Conditioning(displacement, observations);
    std::vector<std::vector<Eigen::RowVector3d>> axes;
    std::vector<double> targets;
    std::vector<double> deviations;
    for (std::size_t i = 0; i < places.size(); ++i)
    {
      const Eigen::RowVector3d normal = this->Along(places[i]);
      const Eigen::RowVector3d x = normal.unitOrthogonal();
      axes.push_back(directions == Directions::Normal ? std::vector<Eigen::RowVector3d>{ normal }
          : directions == Directions::Tangential
          ? std::vector<Eigen::RowVector3d>{ x, normal.cross(x) }
          : std::vector<Eigen::RowVector3d>{ { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } });
      for (const Eigen::RowVector3d& axis : axes.back())
      {
        targets.push_back(axis.dot(values.row(static_cast<Eigen::Index>(i))));
        deviations.push_back(this->Deviations()[static_cast<Eigen::Index>(i)]);
      }
    }
    const Eigen::Map<const Eigen::VectorXd> y(targets.data(), static_cast<Eigen::Index>(targets.size()));
    const Eigen::Map<const Eigen::VectorXd> s(deviations.data(), y.size());
    const Eigen::MatrixXd covariance = this->DenseCovariance(directions);
    const Eigen::MatrixXd matrix = DenseObservations(this->Mesh, places, axes);
    const Eigen::MatrixXd cross = covariance * matrix.transpose();
    const Eigen::MatrixXd system = matrix * cross + Eigen::MatrixXd(s.cwiseAbs2().asDiagonal());
    const Eigen::MatrixXd gain = system.ldlt().solve(cross.transpose()).transpose();
    const Eigen::VectorXd mean = gain * y;
    const RowMatrix found = this->ToRows(displacement, conditioning.Mean(observations.Values));
    EXPECT_LE(MaximumNorm(found.transpose().reshaped() - mean), 1e-8 * MaximumNorm(mean));
    const Eigen::VectorXd variances = covariance.diagonal() - gain.cwiseProduct(cross).rowwise().sum();
    const double dimension = directions == Directions::Free ? 3.0 : directions == Directions::Normal ? 1.0 : 2.0;
    const Eigen::VectorXd expected = variances.reshaped(3, this->Points).colwise().sum().transpose() / dimension;
    const Eigen::VectorXd deviation = displacement.DeviationAlong(
      conditioning.Variance(displacement.UnknownVariances(this->Field.MarginalVariances())));
    EXPECT_LE(MaximumNorm(deviation.cwiseAbs2() - expected), 1e-8 * Deviation * Deviation);
  }
}

TEST_F(DisplacedSurface, ExactObservationsInTheDirectionsAreHonored)
{
  const std::vector<SurfacePlace> places = this->Places();
  const SparseRowMatrix interpolation = ObservationMatrix(this->Mesh, places);
  for (const Directions directions : { Directions::Free, Directions::Normal, Directions::Tangential })
  {
    const SurfaceDisplacement displacement = this->Displacement(directions);
    const Eigen::MatrixXd values = this->Observed(directions);
    const DisplacementObservations observations = displacement.Observe(
      this->Mesh, places, values, Eigen::VectorXd::Zero(6));
    EXPECT_LE(MaximumNorm(observations.Excluded), 1e-15);
    const RowMatrix mean = this->ToRows(
      displacement, this->Conditioning(displacement, observations).Mean(observations.Values));
    const Eigen::MatrixXd reached = interpolation * mean;
    for (Index k = 0; k < 6; ++k)
    {
      // Between vertices the surface is displaced along an interpolation of their normals, too.
      const Eigen::RowVector3d normal = this->Along(places[static_cast<std::size_t>(k)]);
      const Eigen::RowVector3d missed = reached.row(k) - values.row(k);
      const Eigen::RowVector3d along = normal.dot(missed) * normal;
      const Eigen::RowVector3d rest = directions == Directions::Normal && k % 2 == 1 ? along
        : directions == Directions::Tangential && k % 2 == 1 ? Eigen::RowVector3d(missed - along)
                                                             : missed;
      EXPECT_LE(rest.norm(), 1e-8 * MaximumNorm(values)) << k;
    }
  }
}

TEST_F(DisplacedSurface, ExcludedPartsOfObservationsAreMeasured)
{
  const std::vector<SurfacePlace> places = this->Places();
  const Eigen::MatrixXd values = this->Observed(Directions::Free);
  const auto excluded = [&](Directions directions) {
    return this->Displacement(directions).Observe(this->Mesh, places, values, Eigen::VectorXd::Zero(6)).Excluded;
  };
  EXPECT_EQ(MaximumNorm(excluded(Directions::Free)), 0.0);
  for (Index k = 0; k < 6; ++k)
  {
    const double along = std::abs(this->Along(places[static_cast<std::size_t>(k)]).dot(values.row(k)));
    EXPECT_NEAR(excluded(Directions::Tangential)[k], along, 1e-14);
    EXPECT_NEAR(std::hypot(excluded(Directions::Normal)[k], along), values.row(k).norm(), 1e-14);
  }
}

TEST_F(DisplacedSurface, WrongShapesAreNamed)
{
  EXPECT_THAT(TextOf<InvalidInput>([&] { SurfaceDisplacement(Directions::Normal, 5, this->Normals); }),
    HasSubstr("162 normals; expected 5"));
  EXPECT_NO_THROW(SurfaceDisplacement(Directions::Free, 5, PointMatrix()));
  EXPECT_THAT(TextOf<InvalidInput>([&] {
    this->Displacement(Directions::Normal)
      .Observe(this->Mesh, this->Places(), Eigen::MatrixXd::Zero(5, 3), Eigen::VectorXd::Zero(6));
  }),
    HasSubstr("5 displacements of 3 components and 6 deviations on 162 points; expected 6"));
}

TEST(SurfaceDisplacement, InvertedTrianglesAreCounted)
{
  const TriangleMesh patch = test::PlanePatch(4, 4);
  RowMatrix moves = RowMatrix::Zero(patch.NumberOfPoints(), 3);
  EXPECT_EQ(FindInvertedTriangles(patch, moves.data()).Count, 0);
  EXPECT_EQ(FindInvertedTriangles(patch, moves.data()).First, -1);
  moves.col(2).setConstant(3.0); // moved as a whole
  EXPECT_EQ(FindInvertedTriangles(patch, moves.data()).Count, 0);
  moves.col(0) = -2.0 * patch.Points.col(0); // mirrored as a whole
  EXPECT_EQ(FindInvertedTriangles(patch, moves.data()).Count, patch.NumberOfTriangles());
  EXPECT_EQ(FindInvertedTriangles(patch, moves.data()).First, 0);
  TriangleMesh one = test::SingleTriangle();
  moves = RowMatrix::Zero(3, 3);
  moves.row(2) = Eigen::RowVector3d(0.0, -1.0, 0.0); // without an area
  EXPECT_EQ(FindInvertedTriangles(one, moves.data()).Count, 1);
  moves(2, 1) = -0.999;
  EXPECT_EQ(FindInvertedTriangles(one, moves.data()).Count, 0);
}
