// SPDX-License-Identifier: BSD-3-Clause
// Meshes of one surface at several scales.
#include "ExampleMeshes.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/MeshCheck.h"
#include "Core/Mesh/MeshStatistics.h"
#include "Learning/Training/FitTemplates.h"
#include "Learning/Training/MultiscaleMeshFitter.h"
#include "Learning/Training/NearestPoints.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include <cmath>

using namespace surfsynth;

namespace
{

MultiscaleFitOptions QuickFit()
{
  MultiscaleFitOptions options;
  options.Levels = 2;
  options.IcosphereLevel = 1;
  options.Iterations = 40;
  options.LearningRate = 1e-2;
  options.Samples = 300;
  return options;
}

/// Half axes 2, 3 and 2.5, away from the origin.
TriangleMesh Egg()
{
  TriangleMesh mesh = test::Icosphere(3);
  mesh.Points.col(0) *= 2.0;
  mesh.Points.col(1) *= 3.0;
  mesh.Points.col(2) *= 2.5;
  return test::Translated(mesh, { 10.0, -4.0, 1.0 });
}

} // namespace

TEST(NearestPoints, DistancesToAPatchAreExact)
{
  const TriangleMesh patch = test::PlanePatch(4, 3, 2.0, 1.0);
  PointMatrix queries(4, 3);
  queries << 0.7, 0.4, 0.25, -3.0, 0.5, 4.0, 2.0, 1.0, 0.0, 5.0, 5.0, 0.0;
  EXPECT_NEAR(DistanceToSurface(queries.row(0), patch).Mean, 0.25, 1e-14);
  EXPECT_NEAR(DistanceToSurface(queries.row(1), patch).Mean, 5.0, 1e-14);
  EXPECT_NEAR(DistanceToSurface(queries.row(3), patch).Mean, 5.0, 1e-14);
  const PointDistances all = DistanceToSurface(queries, patch);
  EXPECT_NEAR(all.Mean, 10.25 / 4.0, 1e-14);
  EXPECT_NEAR(all.Largest, 5.0, 1e-14);
}

TEST(MultiscaleMeshFitter, TemplatesAreClosedAndWoundOutwards)
{
  for (const TriangleMesh& mesh : { MakeIcosphere(2), MakeTorus(12) })
  {
    MeshRequirements closed;
    closed.Closed = closed.ConsistentWinding = closed.ManifoldVertices = closed.SingleComponent = true;
    EXPECT_TRUE(CheckMesh(mesh, closed).empty());
    double volume = 0.0;
    for (Eigen::Index f = 0; f < mesh.Triangles.rows(); ++f)
    {
      Eigen::Matrix3d corners;
      for (int k = 0; k < 3; ++k)
      {
        corners.row(k) = mesh.Points.row(mesh.Triangles(f, k));
      }
      volume += corners.determinant() / 6.0;
    }
    EXPECT_GT(volume, 0.0);
  }
  EXPECT_EQ(MakeIcosphere(2).NumberOfTriangles(), 320);
  EXPECT_EQ(MakeTorus(12).NumberOfTriangles(), 96);
}

TEST(MultiscaleMeshFitter, ApproachesTheReferenceLevelByLevel)
{
  const TriangleMesh egg = Egg();
  const MultiscaleFit fit = FitMultiscaleMesh(egg, QuickFit());
  ASSERT_EQ(fit.Distances.size(), 2U);
  CheckDataset(fit.Dataset);
  const double before = DistanceToSurface(fit.Dataset.Template.Points, egg).Mean;
  EXPECT_LT(fit.Distances[0].Mean, 0.5 * before);
  EXPECT_LT(fit.Distances[1].Mean, 0.5 * before);
  EXPECT_GE(fit.Distances[0].Largest, fit.Distances[0].Mean);
  const BoundingBox box = ComputeBoundingBox(fit.Dataset.Levels[1]);
  EXPECT_NEAR(box.Upper[1], -1.0, 0.5);
  EXPECT_NEAR(box.Lower[0], 8.0, 0.5);
}

TEST(MultiscaleMeshFitter, SmallStepsAtTheEndBringItCloser)
{
  MultiscaleFitOptions options = QuickFit();
  options.LearningRate = 3e-2;
  const MultiscaleFit falling = FitMultiscaleMesh(Egg(), options);
  options.LearningRateDecay = 1.0;
  const MultiscaleFit constant = FitMultiscaleMesh(Egg(), options);
  EXPECT_LT(falling.Distances[1].Mean, constant.Distances[1].Mean);
}

TEST(MultiscaleMeshFitter, IsAFunctionOfTheSeed)
{
  MultiscaleFitOptions options = QuickFit();
  options.Iterations = 3;
  const MultiscaleFit first = FitMultiscaleMesh(Egg(), options);
  EXPECT_EQ(FitMultiscaleMesh(Egg(), options).Dataset.Levels[1].Points, first.Dataset.Levels[1].Points);
  options.Seed = 1;
  EXPECT_NE(FitMultiscaleMesh(Egg(), options).Dataset.Levels[1].Points, first.Dataset.Levels[1].Points);
}

TEST(MultiscaleMeshFitter, TakesAGivenTemplateAndATorus)
{
  MultiscaleFitOptions options = QuickFit();
  options.Iterations = 1;
  options.Template = FitTemplate::Given;
  options.GivenTemplate = test::Icosphere(1, 7.0);
  EXPECT_EQ(FitMultiscaleMesh(Egg(), options).Dataset.Levels[1].NumberOfTriangles(), 320);
  options.Template = FitTemplate::Torus;
  options.TorusSegments = 12;
  EXPECT_EQ(FitMultiscaleMesh(test::Torus(20, 10), options).Dataset.Levels[0].NumberOfTriangles(), 96);
}

TEST(MultiscaleMeshFitter, ATemplateOfTheSurfaceFitsAnyTopology)
{
  MultiscaleFitOptions options;
  options.Template = FitTemplate::Surface;
  options.TemplateTriangles = 40;
  options.Levels = 3;
  options.Iterations = 30;
  for (const TriangleMesh& mesh : { Egg(), test::Torus(40, 20), test::OpenCylinder(40, 20), test::PlanePatch(20, 20) })
  {
    const MultiscaleFit fit = FitMultiscaleMesh(mesh, options);
    CheckDataset(fit.Dataset);
    const BoundingBox box = ComputeBoundingBox(mesh);
    const double diagonal = (box.Upper - box.Lower).norm();
    const TriangleMesh& finest = fit.Dataset.Levels.back();
    const MeshStatistics expected = ComputeMeshStatistics(mesh);
    const MeshStatistics found = ComputeMeshStatistics(finest);
    EXPECT_EQ(found.EulerCharacteristic(), expected.EulerCharacteristic());
    EXPECT_EQ(found.BoundaryLoops, expected.BoundaryLoops);
    EXPECT_LT(fit.Distances.back().SymmetricMean, 0.005 * diagonal);
    EXPECT_LT(fit.Distances.back().SymmetricPercentile95, 0.01 * diagonal);
    EXPECT_LT(fit.Distances.back().NormalAngle, 10.0);
    EXPECT_LT(fit.Distances.back().Largest, 1e-3 * diagonal);
    EXPECT_EQ(fit.Dataset.Levels[0].Points, finest.Points.topRows(fit.Dataset.Levels[0].NumberOfPoints()));
  }
}

TEST(MultiscaleMeshFitter, ATemplateOfTheSurfaceIsSmooth)
{
  TriangleMesh rough = test::PlanePatch(40, 40);
  for (Index v = 0; v < rough.NumberOfPoints(); ++v)
  {
    rough.Points(v, 2) = 0.02 * std::sin(40.0 * rough.Points(v, 0)) * std::sin(40.0 * rough.Points(v, 1));
  }
  MultiscaleFitOptions options;
  options.Template = FitTemplate::Surface;
  options.TemplateTriangles = 80;
  options.Levels = 1;
  options.Iterations = 0;
  const auto spread = [&](double length) {
    options.SmoothingLength = length;
    const Eigen::VectorXd height = FitMultiscaleMesh(rough, options).Dataset.Template.Points.col(2);
    return height.maxCoeff() - height.minCoeff();
  };
  EXPECT_GT(spread(1e-3), 0.02);
  EXPECT_LT(spread(0.2), 0.1 * spread(1e-3)); // waves of a length of 0.11
}

TEST(MultiscaleMeshFitter, ATimeBudgetEndsTheRelaxationOfATemplateOfTheSurface)
{
  MultiscaleFitOptions options;
  options.Template = FitTemplate::Surface;
  options.TemplateTriangles = 40;
  options.Levels = 2;
  options.Iterations = 1000000;
  options.TimeBudget = 0.5 / 60.0;
  const MultiscaleFit fit = FitMultiscaleMesh(Egg(), options);
  ASSERT_EQ(fit.Iterations.size(), 2U);
  EXPECT_LT(fit.Iterations[0], options.Iterations);
  EXPECT_GT(fit.SecondsForAll, 0.5);
  EXPECT_EQ(fit.Dataset.Levels.size(), 2U);
}

TEST(MultiscaleMeshFitter, ATemplateOfTheSurfaceNeedsAManifold)
{
  MultiscaleFitOptions options;
  options.Template = FitTemplate::Surface;
  TriangleMesh turned = test::Icosphere(2);
  turned.Triangles.row(0).reverseInPlace();
  EXPECT_THROW(FitMultiscaleMesh(turned, options), InvalidInput);
  options.TemplateTriangles = 3;
  EXPECT_THROW(FitMultiscaleMesh(Egg(), options), InvalidInput);
  options.TemplateTriangles = 40;
  options.SmoothingLength = -1.0;
  EXPECT_THROW(FitMultiscaleMesh(Egg(), options), InvalidInput);
  options.SmoothingLength = 0.0;
  EXPECT_THROW(FitMultiscaleMesh(Egg(), options, [](double) { return false; }), Cancelled);
}

TEST(MultiscaleMeshFitter, RefusesWhatItCannotFitAndStopsWhenTold)
{
  MultiscaleFitOptions options = QuickFit();
  EXPECT_THROW(FitMultiscaleMesh(TriangleMesh(), options), InvalidInput);
  TriangleMesh broken = Egg();
  broken.Points(0, 0) = std::nan("");
  EXPECT_THROW(FitMultiscaleMesh(broken, options), InvalidInput);
  options.Levels = 0;
  EXPECT_THROW(FitMultiscaleMesh(Egg(), options), InvalidInput);
  options = QuickFit();
  options.LearningRate = -1.0;
  EXPECT_THROW(FitMultiscaleMesh(Egg(), options), InvalidInput);
  options = QuickFit();
  options.LearningRateDecay = 1.5;
  EXPECT_THROW(FitMultiscaleMesh(Egg(), options), InvalidInput);
  options = QuickFit();
  options.Template = FitTemplate::Given;
  EXPECT_THROW(FitMultiscaleMesh(Egg(), options), InvalidInput);
  double last = -1.0;
  const auto stop = [&](double fraction) {
    EXPECT_GE(fraction, last);
    last = fraction;
    return fraction < 0.1;
  };
  EXPECT_THROW(FitMultiscaleMesh(Egg(), QuickFit(), stop), Cancelled);
}
