// SPDX-License-Identifier: BSD-3-Clause
// Matérn fields whose factor exceeds the limit of memory: conjugate gradients stand in for it.
#include "ExampleMeshes.h"
#include "ScreenedMatrices.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Noise/MaternField.h"
#include "Core/Solvers/CholeskySolver.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

using namespace surfsynth;

namespace
{

MaternFieldOptions WithoutFactor(MaternFieldOptions options = {})
{
  options.FactorMemoryLimit = 1;
  return options;
}

SampleRequest Request(std::uint32_t samples, std::uint32_t components = 1)
{
  SampleRequest request;
  request.Seed = 5;
  request.NumberOfSamples = samples;
  request.NumberOfComponents = components;
  return request;
}

std::vector<Eigen::MatrixXd> Samples(const MaternField& field, const SampleRequest& request)
{
  std::vector<Eigen::MatrixXd> samples;
  field.Sample(
    request, [&](std::uint32_t, const Eigen::Ref<const Eigen::MatrixXd>& values) { samples.emplace_back(values); });
  return samples;
}

TEST(MaternMultigrid, SamplesAreThoseOfTheFactorTo1em8)
{
  const TriangleMesh mesh = test::WithUnreferencedPoints(
    test::Join(test::BumpySurface(4), test::Translated(test::PlanePatch(30, 20, 1.0, 1.0, 0.2), { 4.0, 0.0, 0.0 })));
  std::vector<MaternFieldOptions> cases(5);
  cases[1].OperatorPower = 4;
  cases[2].Boundary = BoundaryCondition::Dirichlet;
  cases[3].Boundary = BoundaryCondition::Robin;
  cases[3].Arrays.Directions = PointMatrix::Ones(mesh.NumberOfPoints(), 3);
  cases[4].Model = NoiseModel::Unscreened;
  for (const MaternFieldOptions& options : cases)
  {
    const MaternField factored(mesh, options);
    const MaternField iterated(mesh, WithoutFactor(options));
    EXPECT_STREQ(factored.SolverName(), "Cholesky");
    EXPECT_EQ(factored.Iterations(), 0);
    EXPECT_STREQ(iterated.SolverName(), "Multigrid");
    const Eigen::MatrixXd expected = factored.Sample(Request(1, 3));
    const Eigen::MatrixXd values = iterated.Sample(Request(1, 3));
    EXPECT_LE((values - expected).norm(), 1e-8 * expected.norm());
    EXPECT_GT(iterated.Iterations(), 3);
    EXPECT_LE(iterated.Iterations(), 40);
    EXPECT_LE(iterated.RelativeResidual(), 1.001e-10);
  }
}

TEST(MaternMultigrid, ASampleHasTheSameBitsAloneInABatchAndForEveryNumberOfThreads)
{
  const TriangleMesh mesh = test::BumpySurface(5);
  const std::vector<Eigen::MatrixXd> batch = [&] {
    const ThreadScope scope(1);
    return Samples(MaternField(mesh, WithoutFactor()), Request(11));
  }();
  const ThreadScope scope(3);
  const MaternField field(mesh, WithoutFactor());
  for (const std::uint32_t sample : { 0U, 4U, 10U })
  {
    SampleRequest alone = Request(1);
    alone.FirstSample = sample;
    EXPECT_EQ(field.Sample(alone), batch[sample]) << sample;
  }
  EXPECT_EQ(Samples(field, Request(11)), batch);
}

TEST(MaternMultigrid, CovarianceAndPrecisionAreThoseOfTheFactor)
{
  const TriangleMesh mesh = test::BumpySurface(4);
  const MaternField factored(mesh, {});
  const MaternField iterated(mesh, WithoutFactor());
  const Eigen::MatrixXd vectors = test::NoiseSides(Eigen::VectorXd::Ones(mesh.NumberOfPoints()), 3);
  const Eigen::MatrixXd covariance = factored.SolvePrecision(vectors);
  EXPECT_LE((iterated.SolvePrecision(vectors) - covariance).norm(), 1e-8 * covariance.norm());
  const Eigen::MatrixXd precision = factored.ApplyPrecision(vectors);
  EXPECT_LE((iterated.ApplyPrecision(vectors) - precision).norm(), 1e-12 * precision.norm());
}

TEST(MaternMultigrid, WhatNeedsTheFactorIsRefusedWithTheReason)
{
  const TriangleMesh mesh = test::BumpySurface(3);
  const auto messageOf = [&](const MaternFieldOptions& options) {
    try
    {
      const MaternField field(mesh, options);
    }
    catch (const InvalidInput& error)
    {
      return std::string(error.what());
    }
    return std::string();
  };
  MaternFieldOptions odd;
  odd.OperatorPower = 3;
  EXPECT_THAT(messageOf(WithoutFactor(odd)), testing::HasSubstr("operator power 2 or 4, or one that is no integer"));
  MaternFieldOptions corrected;
  corrected.VarianceCorrection = true;
  EXPECT_THAT(messageOf(WithoutFactor(corrected)), testing::HasSubstr("without variance correction"));
  const MaternField field(mesh, WithoutFactor());
  EXPECT_THROW(field.LogDeterminantOfPrecision(), InvalidInput);
  EXPECT_THROW(field.MarginalVariances(), InvalidInput);
}

TEST(MaternMultigrid, ModelsWithoutASolveHaveNoSolver)
{
  MaternFieldOptions options;
  options.Model = NoiseModel::White;
  const MaternField field(test::Icosphere(2), WithoutFactor(options));
  EXPECT_STREQ(field.SolverName(), "None");
  EXPECT_EQ(field.Iterations(), 0);
}

#ifdef SURFACE_SYNTHESIS_CHOLMOD
TEST(MaternMultigrid, EstimatedFactorsAreAtMostThreeTimesTheFactorsAndNotBelowThem)
{
  for (const int level : { 4, 5, 6 })
  {
    const SparseMatrix matrix = test::ScreenedSurface(test::BumpySurface(level)).Matrix;
    const double factor = 8.0 * static_cast<double>(CholeskySolver(matrix).FactorEntries());
    const auto estimate = static_cast<double>(CholeskySolver::EstimateMemory(matrix.rows(), matrix.nonZeros()));
    EXPECT_GE(estimate, 0.95 * factor) << level;
    EXPECT_LE(estimate, 3.0 * factor) << level;
  }
  for (const int cells : { 12, 20, 24 })
  {
    const SparseMatrix matrix = test::ScreenedCube(cells).Matrix;
    const double factor = 8.0 * static_cast<double>(CholeskySolver(matrix).FactorEntries());
    const auto estimate = static_cast<double>(CholeskySolver::EstimateMemory(matrix.rows(), matrix.nonZeros()));
    EXPECT_GE(estimate, 0.95 * factor) << cells;
    EXPECT_LE(estimate, 3.0 * factor) << cells;
  }
}
#endif

TEST(MaternMultigrid, StopsOnRequestWhileSampling)
{
  const MaternField field(test::BumpySurface(4), WithoutFactor());
  Eigen::VectorXd values(field.Mesh().NumberOfPoints());
  int reports = 0;
  const Progress stop = [&](double) { return ++reports < 10; };
  EXPECT_THROW(field.SampleInto(
                 Request(1), [&](std::uint32_t) { return values.data(); }, stop),
    Cancelled);
  EXPECT_EQ(reports, 10);
}

} // namespace
