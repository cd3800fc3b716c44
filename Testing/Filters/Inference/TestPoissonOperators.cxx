// SPDX-License-Identifier: BSD-3-Clause
// The shifts of the Poisson equation: what integrating the gradients of the lowest modes of a sphere gives back.
#include "ExampleMeshes.h"
#include "PoissonResponses.h"
#include "RandomPoissonNet.h"

#include "Core/Common/Errors.h"
#include "Inference/PoissonNet/PoissonNetEvaluator.h"

#include <gtest/gtest.h>

using namespace surfsynth;

TEST(PoissonOperators, WithAShiftByMassAnswerAlikeOnEveryTriangulation)
{
  const TriangleMesh coarse = test::Icosphere(3);
  const TriangleMesh fine = test::Icosphere(6);
  const TriangleMesh uneven = test::IrregularSphere(4);
  const Eigen::VectorXd expected = test::Responses(coarse, PoissonShift::Mass);
  EXPECT_GT(expected.minCoeff(), 0.9999);
  EXPECT_LT(expected.maxCoeff(), 1.0001);
  EXPECT_LT(test::LargestDifference(test::Responses(fine, PoissonShift::Mass), expected), 1e-5);
  EXPECT_LT(test::LargestDifference(test::Responses(uneven, PoissonShift::Mass), expected), 1e-5);
  // The published shift damps the first modes by 1e-6 V / lambda, lambda = 8 pi at unit area.
  const double lost = 1.0 - test::Responses(fine, PoissonShift::Identity).minCoeff();
  EXPECT_NEAR(lost, 1e-6 * static_cast<double>(fine.NumberOfPoints()) / (8.0 * EIGEN_PI), 0.1 * lost);
}

TEST(PoissonOperators, PointsThatNoTriangleUsesDoNotMakeTheEquationSingular)
{
  TriangleMesh mesh = test::Scaled(test::Icosphere(2), 0.28);
  const Index used = mesh.NumberOfPoints();
  mesh.Points.conservativeResize(used + 1, 3);
  mesh.Points.row(used).setConstant(3.0);
  const PoissonOperators operators = BuildPoissonOperators(mesh, MeshTopology(mesh), {}, PoissonShift::Mass);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(used + 1);
  right[0] = 1.0;
  right[1] = -1.0;
  const Eigen::VectorXd solution = operators.Solver->Solve(right);
  EXPECT_TRUE(solution.allFinite());
  EXPECT_EQ(solution[used], 0.0);
}

TEST(PoissonOperators, OfAnotherShiftThanTheModelsAreRefused)
{
  const TriangleMesh mesh = test::Scaled(test::Icosphere(1), 0.28);
  PoissonNetOptions options;
  options.Width = 4;
  options.Blocks = 1;
  const auto model = std::make_shared<const PoissonNetModel>(test::RandomModel(options, 1));
  const PoissonOperators operators = BuildPoissonOperators(mesh, MeshTopology(mesh), {}, PoissonShift::Mass);
  EXPECT_THROW(PoissonNetEvaluator(model, operators, mesh.Points), InvalidInput);
  PoissonNetModel own = *model;
  own.Options.Shift = PoissonShift::Mass;
  EXPECT_NO_THROW(PoissonNetEvaluator(std::make_shared<const PoissonNetModel>(own), operators, mesh.Points));
}

TEST(PoissonOperators, ModelFilesKeepTheShift)
{
  PoissonNetOptions options;
  EXPECT_EQ(OptionsFromMetadata("file", MetadataFromOptions(options)).Shift, PoissonShift::Identity);
  options.Shift = PoissonShift::Mass;
  EXPECT_EQ(OptionsFromMetadata("file", MetadataFromOptions(options)).Shift, PoissonShift::Mass);
  std::map<std::string, std::string> published = MetadataFromOptions(options);
  published.erase("poisson_shift");
  EXPECT_EQ(OptionsFromMetadata("file", published).Shift, PoissonShift::Identity);
  published["poisson_shift"] = "other";
  EXPECT_THROW(OptionsFromMetadata("file", published), ModelMismatch);
}
