// SPDX-License-Identifier: BSD-3-Clause
// Coupling of the components of a mesh, and random fields with it.
#include "ExampleMeshes.h"
#include "ThrownText.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/SurfacePlace.h"
#include "Core/Noise/MaternField.h"
#include "Core/Operators/ComponentCoupling.h"

#include <Eigen/Dense>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

using namespace surfsynth;
using surfsynthtest::MessageOf;
using testing::AllOf;
using testing::HasSubstr;

namespace
{
constexpr double Gap = 0.02;
const Eigen::Vector3d EyeCenter(1.0 - 0.25 - Gap, 0.1, 0.05);

/// A ball of unit radius with a ball of radius 1/4 inside, a gap below the surface.
TriangleMesh BodyWithEye()
{
  return test::Join(test::Icosphere(4), test::Translated(test::Icosphere(3, 0.25), EyeCenter));
}

TriangleMesh EyeWithBody()
{
  return test::Join(test::Translated(test::Icosphere(3, 0.25), EyeCenter), test::Icosphere(4));
}

/// Row of each vertex of BodyWithEye() in EyeWithBody().
Index InOtherOrder(Index v)
{
  const Index body = test::Icosphere(4).NumberOfPoints(), eye = test::Icosphere(3).NumberOfPoints();
  return v < body ? v + eye : v - body;
}

ComponentCoupling Coupled()
{
  ComponentCoupling coupling;
  coupling.IsOn = true;
  return coupling;
}

std::vector<CoupledPair> PairsOf(const TriangleMesh& mesh, const ComponentCoupling& coupling)
{
  const MeshTopology topology(mesh);
  return FindCoupledPairs(mesh, ComputeComponents(topology, LumpedMass(mesh, topology)), coupling);
}

Eigen::Vector3d OtherEnd(const TriangleMesh& mesh, const CoupledPair& pair)
{
  Eigen::RowVector3d end = Eigen::RowVector3d::Zero();
  for (int k = 0; k < 3; ++k)
  {
    end += pair.Weights[k] * mesh.Points.row(pair.Corners[k]);
  }
  return end.transpose();
}

MaternFieldOptions FieldOptionsWith(const ComponentCoupling& coupling)
{
  MaternFieldOptions options;
  options.CorrelationRange = 0.8;
  options.Coupling = coupling;
  return options;
}

/// Root mean square over samples of the mean difference of the pairs, of the eye in the body.
double OffsetOfEye(const ComponentCoupling& coupling)
{
  const TriangleMesh mesh = BodyWithEye();
  const std::vector<CoupledPair> pairs = PairsOf(mesh, Coupled());
  const MaternField field(mesh, FieldOptionsWith(coupling));
  SampleRequest request;
  request.NumberOfSamples = 32;
  double sum = 0.0;
  field.Sample(request, [&](std::uint32_t, const Eigen::Ref<const Eigen::MatrixXd>& values) {
    double difference = 0.0;
    for (const CoupledPair& pair : pairs)
    {
      difference += values(pair.Vertex, 0);
      for (int k = 0; k < 3; ++k)
      {
        difference -= pair.Weights[k] * values(pair.Corners[k], 0);
      }
    }
    difference /= static_cast<double>(pairs.size());
    sum += difference * difference;
  });
  return std::sqrt(sum / request.NumberOfSamples);
}
} // namespace

TEST(ComponentCoupling, PairsVerticesWithTheNearestPlaceAcrossTheGap)
{
  // Two parallel squares of side 1 at a distance of 0.01.
  const TriangleMesh lower = test::PlanePatch(4, 4);
  const TriangleMesh mesh = test::Join(lower, test::Translated(test::PlanePatch(3, 3), { 0.0, 0.0, 0.01 }));
  const std::vector<CoupledPair> pairs = PairsOf(mesh, Coupled());
  ASSERT_EQ(static_cast<Index>(pairs.size()), mesh.NumberOfPoints());
  for (const CoupledPair& pair : pairs)
  {
    const Eigen::Vector3d vertex = mesh.Points.row(pair.Vertex).transpose();
    const double height = vertex.z() > 0.005 ? 0.0 : 0.01;
    EXPECT_LT((OtherEnd(mesh, pair) - Eigen::Vector3d(vertex.x(), vertex.y(), height)).norm(), 1e-14);
  }
}

TEST(ComponentCoupling, PairsOnlyPartsThatFaceEachOther)
{
  ComponentCoupling coupling = Coupled();
  coupling.Distance = 0.2; // as far as the flank of the body from the eye
  const TriangleMesh mesh = BodyWithEye();
  double farthest = 0.0;
  for (const CoupledPair& pair : PairsOf(mesh, coupling))
  {
    farthest = std::max(farthest, (mesh.Points.row(pair.Vertex).transpose() - OtherEnd(mesh, pair)).norm());
    // The way back is at least half as long: the distance of a place on the body from the eye is known.
    if (pair.Vertex >= test::Icosphere(4).NumberOfPoints())
    {
      const Eigen::Vector3d end = OtherEnd(mesh, pair);
      const double back = (end - EyeCenter).norm() - 0.25;
      EXPECT_GE(2.1 * back, (mesh.Points.row(pair.Vertex).transpose() - end).norm());
    }
  }
  EXPECT_LE(farthest, 0.2);
  EXPECT_GT(farthest, Gap);
}

TEST(ComponentCoupling, FindsAmongManyComponentsWhatASearchInEachFinds)
{
  // Beads of a string around a ball, each of which touches nothing.
  TriangleMesh mesh = test::Icosphere(2);
  constexpr int Beads = 30;
  for (int k = 0; k < Beads; ++k)
  {
    const double angle = 2.0 * 3.14159265358979 * k / Beads;
    const double radius = 1.05 + 0.015 * (k % 3);
    const Eigen::Vector3d center(radius * std::cos(angle), radius * std::sin(angle), 0.02 * (k % 2));
    mesh = test::Join(mesh, test::Translated(test::Icosphere(1, 0.04), center));
  }
  const MeshTopology topology(mesh);
  const MeshComponents components = ComputeComponents(topology, LumpedMass(mesh, topology));
  ASSERT_EQ(components.Count, 1 + Beads);
  const double limit = 0.03 * std::sqrt(LumpedMass(mesh).sum());
  const auto nearest = [&](const Eigen::Vector3d& point, Index component, bool inside) {
    double least = std::numeric_limits<double>::infinity();
    Eigen::Vector3d found = Eigen::Vector3d::Zero();
    for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
    {
      if ((components.OfVertex[mesh.Triangles(f, 0)] == component) != inside)
      {
        continue;
      }
      const Eigen::Vector3d place = PositionOf(mesh, NearestOnTriangle(mesh, f, point));
      if ((place - point).norm() < least)
      {
        least = (place - point).norm();
        found = place;
      }
    }
    return std::make_pair(least, found);
  };
  const std::vector<CoupledPair> pairs = FindCoupledPairs(mesh, components, Coupled());
  std::size_t next = 0;
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    const Eigen::Vector3d vertex = mesh.Points.row(v).transpose();
    const auto [distance, place] = nearest(vertex, components.OfVertex[v], false);
    const double back = nearest(place, components.OfVertex[v], true).first;
    const bool isCoupled = next < pairs.size() && pairs[next].Vertex == v;
    if (std::abs(distance - limit) > 1e-9 && std::abs(distance - 2.0 * back) > 1e-9)
    {
      ASSERT_EQ(isCoupled, distance < limit && distance < 2.0 * back) << "point " << v;
    }
    if (isCoupled)
    {
      ASSERT_NEAR((OtherEnd(mesh, pairs[next++]) - vertex).norm(), distance, 1e-12);
    }
  }
  EXPECT_EQ(next, pairs.size());
  EXPECT_GT(next, 0u);
}

TEST(ComponentCoupling, ReportsProgressAndCanBeCancelled)
{
  const TriangleMesh mesh = BodyWithEye();
  const MeshTopology topology(mesh);
  std::vector<double> reports;
  const auto record = [&reports](double fraction) {
    reports.push_back(fraction);
    return true;
  };
  CouplingMatrix(mesh, topology, Coupled(), record);
  EXPECT_TRUE(std::is_sorted(reports.begin(), reports.end()));
  ASSERT_FALSE(reports.empty());
  EXPECT_EQ(reports.back(), 1.0);
  EXPECT_THROW(CouplingMatrix(mesh, topology, Coupled(), [](double) { return false; }), Cancelled);
}

TEST(ComponentCoupling, DoesNotDependOnTheOrderOfComponents)
{
  const TriangleMesh first = BodyWithEye(), second = EyeWithBody();
  const SparseMatrix a = CouplingMatrix(first, MeshTopology(first), Coupled());
  const SparseMatrix b = CouplingMatrix(second, MeshTopology(second), Coupled());
  ASSERT_EQ(a.nonZeros(), b.nonZeros());
  const double largest = Eigen::Map<const Eigen::VectorXd>(a.valuePtr(), a.nonZeros()).cwiseAbs().maxCoeff();
  for (Index column = 0; column < a.cols(); ++column)
  {
    for (SparseMatrix::InnerIterator entry(a, column); entry; ++entry)
    {
      ASSERT_NEAR(
        entry.value(), b.coeff(InOtherOrder(static_cast<Index>(entry.row())), InOtherOrder(column)), 1e-12 * largest);
    }
  }
}

TEST(ComponentCoupling, IsSymmetricAndLeavesConstantsAlone)
{
  const TriangleMesh mesh = BodyWithEye();
  const SparseMatrix matrix = CouplingMatrix(mesh, MeshTopology(mesh), Coupled());
  EXPECT_LT((matrix - SparseMatrix(matrix.transpose())).norm(), 1e-12 * matrix.norm());
  EXPECT_LT((matrix * Eigen::VectorXd::Ones(matrix.cols())).norm(), 1e-12 * matrix.norm());
  // A step of 1 between body and eye has the energy w times the part of the area that is coupled.
  Eigen::VectorXd step = Eigen::VectorXd::Zero(matrix.cols());
  step.tail(test::Icosphere(3).NumberOfPoints()).setOnes();
  const Eigen::VectorXd mass = LumpedMass(mesh);
  double coupled = 0.0;
  for (const CoupledPair& pair : PairsOf(mesh, Coupled()))
  {
    coupled += mass[pair.Vertex];
  }
  EXPECT_NEAR(step.dot(matrix * step) / (1e6 * coupled / mass.sum()), 1.0, 1e-9);
}

TEST(ComponentCoupling, OfOneComponentIsNone)
{
  const TriangleMesh mesh = test::Icosphere(2);
  EXPECT_EQ(CouplingMatrix(mesh, MeshTopology(mesh), Coupled()).rows(), 0);
  EXPECT_EQ(CouplingMatrix(BodyWithEye(), MeshTopology(BodyWithEye()), {}).rows(), 0);
}

TEST(ComponentCoupling, RefusesFarComponentsAndOptionsOutOfRange)
{
  const TriangleMesh far = test::Join(test::Icosphere(2), test::Translated(test::Icosphere(2), { 5.0, 0.0, 0.0 }));
  EXPECT_THAT(MessageOf([&] { PairsOf(far, Coupled()); }),
    AllOf(HasSubstr("1 of 2 connected components"), HasSubstr("at point 162"), HasSubstr("coupling distance")));
  ComponentCoupling wide = Coupled();
  wide.Distance = 3.5;
  EXPECT_FALSE(PairsOf(far, wide).empty());
  for (const double weight : { 0.0, -1.0, std::nan("") })
  {
    ComponentCoupling bad = Coupled();
    bad.Weight = weight;
    EXPECT_THAT(MessageOf([&] { PairsOf(far, bad); }), HasSubstr("weight of the coupling"));
  }
  ComponentCoupling bad = Coupled();
  bad.Distance = -1.0;
  EXPECT_THAT(MessageOf([&] { PairsOf(far, bad); }), HasSubstr("distance of the coupling"));
}

TEST(CoupledNoise, MovesPartsTogether)
{
  EXPECT_GT(OffsetOfEye({}), 0.3); // independent fields of unit deviation
  EXPECT_LT(OffsetOfEye(Coupled()), 0.005);
}

TEST(CoupledNoise, OfOneComponentHasTheSameBits)
{
  const TriangleMesh mesh = test::BumpySurface(2);
  for (const NoiseModel model : { NoiseModel::Matern, NoiseModel::Unscreened, NoiseModel::Spectral })
  {
    MaternFieldOptions options = FieldOptionsWith({});
    options.Model = model;
    options.NumberOfEigenpairs = 20;
    const Eigen::MatrixXd without = MaternField(mesh, options).Sample();
    options.Coupling = Coupled();
    EXPECT_TRUE(without == MaternField(mesh, options).Sample());
  }
}

TEST(CoupledNoise, HasACovarianceThatDoesNotDependOnTheOrderOfComponents)
{
  const MaternField first(BodyWithEye(), FieldOptionsWith(Coupled()));
  const MaternField second(EyeWithBody(), FieldOptionsWith(Coupled()));
  const Eigen::VectorXd a = first.MarginalVariances(), b = second.MarginalVariances();
  for (Index v = 0; v < a.size(); ++v)
  {
    ASSERT_NEAR(b[InOtherOrder(v)] / a[v], 1.0, 1e-8);
  }
}

TEST(CoupledNoise, RefusesVolumesAndBarriers)
{
  MaternFieldOptions options = FieldOptionsWith(Coupled());
  TetrahedralMesh volume;
  volume.Points.resize(4, 3);
  volume.Points << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  volume.Tetrahedra.resize(1, 4);
  volume.Tetrahedra << 0, 1, 2, 3;
  EXPECT_THAT(MessageOf([&] { MaternField(volume, options); }), HasSubstr("coupled components in a volume"));
  const TriangleMesh mesh = BodyWithEye();
  options.Arrays.Barrier.assign(static_cast<std::size_t>(mesh.NumberOfTriangles()), false);
  options.Arrays.Barrier[0] = true;
  EXPECT_THAT(MessageOf([&] { MaternField(mesh, options); }), HasSubstr("barriers"));
}
