// SPDX-License-Identifier: BSD-3-Clause
//
// vtkMultiscaleMeshFitter: the numbers of the plain fit, what it says of them, its ports, messages, abort.
#include "FilterChecks.h"
#include "FilterContract.h"
#include "GeometricTexturePipelines.h"

#include "vtkMultiscaleMeshFitter.h"

#include "IO/Datasets/MultiscaleDataset.h"
#include "Learning/Training/MultiscaleMeshFitter.h"
#include "SurfaceBridge.h"

#include <vtkCompositeDataSet.h>
#include <vtkDataArray.h>
#include <vtkFieldData.h>
#include <vtkInformation.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <sstream>
#include <string>
#include <thread>
#include <utility>

using namespace surfsynth;
using namespace surfsynthtest;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

namespace
{
constexpr int Levels = 2;
#ifdef SURFACE_SYNTHESIS_CGAL
constexpr int CountsIntersections = 1;
#else
constexpr int CountsIntersections = 0;
#endif

/// A stretched ball, fitted in a second.
Soup Egg()
{
  Soup soup = Icosphere(2);
  for (std::size_t k = 0; k < soup.Points.size(); k += 3)
  {
    soup.Points[k] = 3.0 * soup.Points[k] + 10.0;
  }
  return soup;
}

vtkSmartPointer<vtkMultiscaleMeshFitter> FitterOn(vtkPolyData* reference)
{
  auto filter = vtkSmartPointer<vtkMultiscaleMeshFitter>::New();
  filter->SetInputDataObject(0, reference);
  filter->SetNumberOfLevels(Levels);
  filter->SetIcosphereLevel(1);
  filter->SetIterations(40);
  filter->SetSamples(200);
  filter->SetLearningRate(0.03);
  return filter;
}

MultiscaleFitOptions SameOptions()
{
  MultiscaleFitOptions options;
  options.Levels = Levels;
  options.IcosphereLevel = 1;
  options.Iterations = 40;
  options.Samples = 200;
  options.LearningRate = 0.03;
  return options;
}

vtkPolyData* LevelOf(vtkAlgorithm* filter, unsigned int k)
{
  auto* blocks = vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0));
  EXPECT_TRUE(blocks && k < blocks->GetNumberOfBlocks());
  return blocks && k < blocks->GetNumberOfBlocks() ? vtkPolyData::SafeDownCast(blocks->GetBlock(k)) : nullptr;
}

vtkPolyData* TemplateOf(vtkAlgorithm* filter) { return vtkPolyData::SafeDownCast(filter->GetOutputDataObject(1)); }

std::string ErrorOfFit(vtkMultiscaleMeshFitter* filter)
{
  const std::string error = ErrorOf(filter);
  EXPECT_EQ(TemplateOf(filter)->GetNumberOfPoints(), 0);
  return error;
}
} // namespace

TEST(MultiscaleMeshFitterFilter, LevelsAndTemplateAreThoseOfThePlainFit)
{
  const auto reference = Egg().ToPolyData();
  const std::uint64_t before = HashOf(reference);
  const auto filter = FitterOn(reference);
  OutputOf(filter);
  EXPECT_EQ(HashOf(reference), before);
  const MultiscaleFit expected = FitMultiscaleMesh(ConvertSurface(reference).Mesh, SameOptions());
  EXPECT_EQ(vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0))->GetNumberOfBlocks(), 2u);
  for (unsigned int k = 0; k < Levels; ++k)
  {
    vtkPolyData* level = LevelOf(filter, k);
    ASSERT_TRUE(level);
    const TriangleMesh found = ConvertSurface(level).Mesh;
    EXPECT_EQ((found.Points - expected.Dataset.Levels[k].Points).cwiseAbs().maxCoeff(), 0.0);
    EXPECT_TRUE(found.Triangles == expected.Dataset.Levels[k].Triangles);
    EXPECT_EQ(level->GetFieldData()->GetArray("MeanDistance")->GetTuple1(0), expected.Distances[k].Mean);
    EXPECT_EQ(level->GetFieldData()->GetArray("LargestDistance")->GetTuple1(0), expected.Distances[k].Largest);
    EXPECT_LT(expected.Distances[k].Mean, 0.2) << "a fit, of a body of length 6";
    auto* blocks = vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0));
    EXPECT_EQ(blocks->GetMetaData(k)->Get(vtkCompositeDataSet::NAME()), "Level " + std::to_string(k));
  }
  const TriangleMesh start = ConvertSurface(TemplateOf(filter)).Mesh;
  EXPECT_EQ((start.Points - expected.Dataset.Template.Points).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_TRUE(start.Triangles == expected.Dataset.Levels[0].Triangles);
}

TEST(MultiscaleMeshFitterFilter, TheTemplateCanBeGivenOrATorus)
{
  const auto filter = FitterOn(Egg().ToPolyData());
  filter->SetIterations(3);
  filter->SetNumberOfLevels(1);
  filter->SetTemplateToTorus();
  filter->SetTorusSegments(9);
  OutputOf(filter);
  EXPECT_EQ(LevelOf(filter, 0)->GetNumberOfPolys(), 2 * 9 * 3);
  Soup given = Icosphere(0);
  given.AddPoint(7.0, 7.0, 7.0); // used by no triangle
  filter->SetTemplateToGiven();
  filter->SetInputDataObject(1, given.ToPolyData());
  OutputOf(filter);
  EXPECT_EQ(LevelOf(filter, 0)->GetNumberOfPolys(), 20);
  EXPECT_EQ(LevelOf(filter, 0)->GetNumberOfPoints(), 12);
}

TEST(MultiscaleMeshFitterFilter, TheTemplateCanBeMadeFromTheSurface)
{
  const auto filter = FitterOn(Egg().ToPolyData());
  filter->SetTemplateToSurface();
  filter->SetTemplateTriangles(40);
  filter->SetSmoothingLength(0.5);
  OutputOf(filter);
  EXPECT_EQ(TemplateOf(filter)->GetNumberOfPolys(), 40);
  vtkPolyData* finest = LevelOf(filter, 1);
  EXPECT_EQ(finest->GetNumberOfPolys(), 160);
  const auto value = [&](const char* name) { return finest->GetFieldData()->GetArray(name)->GetTuple1(0); };
  EXPECT_LT(value("SymmetricMeanDistance"), 0.1);
  EXPECT_LE(value("SymmetricMeanDistance"), value("SymmetricPercentile95"));
  EXPECT_GT(value("MeanNormalAngle"), 0.0);
  EXPECT_LT(value("MeanNormalAngle"), 30.0);
  EXPECT_EQ(finest->GetFieldData()->HasArray("NumberOfSelfIntersections"), CountsIntersections);
}

TEST(MultiscaleMeshFitterFilter, WritesADatasetForTraining)
{
  std::filesystem::remove("egg.dataset");
  const auto filter = FitterOn(Egg().ToPolyData());
  filter->SetIterations(2);
  filter->SetDatasetFileName("egg.dataset");
  OutputOf(filter);
  const MultiscaleDataset dataset = ReadMultiscaleDataset("egg.dataset");
  ASSERT_EQ(dataset.Levels.size(), 2u);
  EXPECT_TRUE(dataset.HasTemplate());
  const PointMatrix found = ConvertPoints(LevelOf(filter, 1));
  EXPECT_EQ((dataset.Levels[1].Points - found).cwiseAbs().maxCoeff(), 0.0);
  filter->SetDatasetFileName("nowhere/egg.dataset");
  EXPECT_THAT(ErrorOfFit(filter), HasSubstr("nowhere/egg.dataset"));
}

TEST(MultiscaleMeshFitterFilter, ATimeBudgetEndsEachLevelAndSaysTheTimeToExpect)
{
  const auto filter = FitterOn(Egg().ToPolyData());
  filter->SetIterations(100000);
  filter->SetTimeBudget(0.5 / 60.0);
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  ASSERT_EQ(events.Warnings.size(), 1u);
  EXPECT_THAT(
    events.Warnings[0], AllOf(HasSubstr("before their 100000 iterations"), HasSubstr("All of them take about ")));
  // Better than the template: both levels are fitted.
  const vtkSmartPointer<vtkPolyData> fitted = LevelOf(filter, 1);
  filter->SetIterations(0);
  EXPECT_TRUE(Update(filter));
  EXPECT_EQ(events.Warnings.size(), 1u);
  const auto distance = [](
                          vtkPolyData* level) { return level->GetFieldData()->GetArray("MeanDistance")->GetTuple1(0); };
  EXPECT_LT(distance(fitted), distance(LevelOf(filter, 1)));
}

TEST(MultiscaleMeshFitterFilter, ABudgetThatIsNotUsedUpLeavesTheBits)
{
  const auto filter = FitterOn(Egg().ToPolyData());
  filter->SetIterations(3);
  OutputOf(filter);
  const vtkSmartPointer<vtkPolyData> first = LevelOf(filter, 1);
  filter->SetTimeBudget(600.0);
  OutputOf(filter);
  EXPECT_TRUE(SameBits(first->GetPoints()->GetData(), LevelOf(filter, 1)->GetPoints()->GetData()));
}

TEST(MultiscaleMeshFitterFilter, TheSeedAndTheNormalsMatter)
{
  const auto filter = FitterOn(Egg().ToPolyData());
  filter->SetIterations(3);
  OutputOf(filter);
  const vtkSmartPointer<vtkPolyData> first = LevelOf(filter, 0);
  filter->SetSeed(1);
  OutputOf(filter);
  EXPECT_GT(LargestDifference(first->GetPoints()->GetData(), LevelOf(filter, 0)->GetPoints()->GetData()), 1e-6);
  filter->SetSeed(0);
  OutputOf(filter);
  EXPECT_TRUE(SameBits(first->GetPoints()->GetData(), LevelOf(filter, 0)->GetPoints()->GetData()));
  filter->PublishedNormalsOn();
  OutputOf(filter);
  EXPECT_GT(LargestDifference(first->GetPoints()->GetData(), LevelOf(filter, 0)->GetPoints()->GetData()), 1e-6);
}

TEST(MultiscaleMeshFitterFilter, Messages)
{
  vtkNew<vtkMultiscaleMeshFitter> alone;
  {
    EventRecorder events(alone);
    EXPECT_FALSE(Update(alone));
  }
  Soup needle = Egg();
  needle.Polys[5] = { 0, 0, 1 };
  EXPECT_THAT(ErrorOfFit(FitterOn(needle.ToPolyData())), HasSubstr("first cell 5"));
  Soup points;
  points.AddPoint(0, 0, 0);
  points.Verts.push_back({ 0 });
  EXPECT_THAT(ErrorOfFit(FitterOn(points.ToPolyData())), HasSubstr("no polygon"));
  const auto filter = FitterOn(Egg().ToPolyData());
  filter->SetTemplateToGiven();
  EXPECT_THAT(ErrorOfFit(filter), HasSubstr("There is no template on port 1"));
  Soup turned = Icosphere(1);
  std::swap(turned.Polys[7][0], turned.Polys[7][1]);
  filter->SetInputDataObject(1, turned.ToPolyData());
  EXPECT_THAT(ErrorOfFit(filter), AllOf(HasSubstr("The template on port 1"), HasSubstr("3 edge(s)")));
}

TEST(MultiscaleMeshFitterFilter, AReferenceNeedNotBeManifoldAndMayBeEmpty)
{
  Soup soup = Egg();
  const vtkIdType tip = soup.AddPoint(20.0, 0.0, 0.0);
  soup.Polys.push_back({ soup.Polys[0][0], soup.Polys[0][1], tip }); // a third triangle on an edge
  const auto filter = FitterOn(soup.ToPolyData());
  filter->SetIterations(2);
  OutputOf(filter);
  EXPECT_GT(LevelOf(filter, 1)->GetNumberOfPoints(), 0);
  vtkNew<vtkPolyData> empty;
  filter->SetInputDataObject(0, empty);
  OutputOf(filter);
  EXPECT_EQ(vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0))->GetNumberOfBlocks(), 0u);
  EXPECT_EQ(TemplateOf(filter)->GetNumberOfPoints(), 0);
}

TEST(MultiscaleMeshFitterFilter, ProgressIsMonotoneAndAbortIsQuick)
{
  const auto filter = FitterOn(Egg().ToPolyData());
  {
    EventRecorder events(filter);
    ASSERT_TRUE(Update(filter));
    EXPECT_TRUE(std::is_sorted(events.Progress.begin(), events.Progress.end()));
    EXPECT_GE(events.Progress.size(), 20u);
    EXPECT_EQ(events.Progress.back(), 1.0);
    EXPECT_FALSE(events.ForeignThread);
    EXPECT_TRUE(Update(filter));
    EXPECT_EQ(events.Executions, 1) << "nothing has changed";
  }
  filter->SetIterations(100000);
  {
    EventRecorder events(filter);
    events.AbortAt = 1e-5;
    EXPECT_TRUE(Update(filter)) << "an abort is no failure";
    EXPECT_THAT(events.Errors, IsEmpty());
    ASSERT_GE(events.SecondsAfterAbort, 0.0);
    EXPECT_LT(events.SecondsAfterAbort, 1.0) << "R9";
  }
  EXPECT_EQ(vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0))->GetNumberOfBlocks(), 0u);
  filter->SetIterations(1);
  OutputOf(filter);
  EXPECT_GT(LevelOf(filter, 0)->GetNumberOfPoints(), 0);
}

namespace
{
void WaitFor(vtkMultiscaleMeshFitter* filter, const std::string& end)
{
  const double limit = surfsynthtest::Now() + 100.0;
  while (std::string(filter->GetBackgroundState()).rfind("running", 0) == 0 && surfsynthtest::Now() < limit)
  {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  EXPECT_THAT(filter->GetBackgroundState(), ::testing::StartsWith(end));
}

unsigned int NumberOfBlocks(vtkMultiscaleMeshFitter* filter)
{
  return vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0))->GetNumberOfBlocks();
}
} // namespace

TEST(MultiscaleMeshFitterFilter, AFitInTheBackgroundGivesTheSameMeshes)
{
  const auto reference = Egg().ToPolyData();
  auto expected = FitterOn(reference);
  expected->Update();
  auto filter = FitterOn(reference);
  filter->BackgroundOn();
  EXPECT_STREQ(filter->GetBackgroundState(), "");
  filter->Update();
  WaitFor(filter, "finished: ");
  filter->Modified();
  filter->Update();
  ASSERT_EQ(NumberOfBlocks(filter), 2u);
  for (unsigned int k = 0; k < Levels; ++k)
  {
    EXPECT_EQ(
      LargestDifference(LevelOf(filter, k)->GetPoints()->GetData(), LevelOf(expected, k)->GetPoints()->GetData()), 0.0);
  }
  EXPECT_GT(vtkPolyData::SafeDownCast(filter->GetOutputDataObject(1))->GetNumberOfPoints(), 0);
  auto* finest = vtkPolyData::SafeDownCast(filter->GetOutputDataObject(2));
  EXPECT_EQ(finest->GetPoints(), LevelOf(filter, 1)->GetPoints());
}

TEST(MultiscaleMeshFitterFilter, AFitInTheBackgroundIsStopped)
{
  const auto reference = Egg().ToPolyData();
  auto filter = FitterOn(reference);
  filter->SetIterations(1000000);
  filter->BackgroundOn();
  filter->Update();
  EXPECT_THAT(filter->GetBackgroundState(), ::testing::StartsWith("running: "));
  filter->Modified();
  filter->Update();
  EXPECT_EQ(NumberOfBlocks(filter), 0u) << "no meshes before the end";
  const double before = surfsynthtest::Now();
  filter->StopBackground();
  EXPECT_LT(surfsynthtest::Now() - before, 10.0);
  EXPECT_THAT(filter->GetBackgroundState(), ::testing::StartsWith("stopped: "));
  filter->Update();
  EXPECT_EQ(NumberOfBlocks(filter), 0u);
  filter->SetIterations(1);
  filter->BackgroundOff();
  filter->Update();
  EXPECT_EQ(NumberOfBlocks(filter), 2u);
}

TEST(MultiscaleMeshFitterFilter, AnErrorOfTheBackgroundIsReportedByTheNextUpdate)
{
  const auto reference = Egg().ToPolyData();
  auto filter = FitterOn(reference);
  filter->SetIterations(1);
  filter->SetDatasetFileName("no/such/folder/levels.safetensors");
  filter->BackgroundOn();
  filter->Update();
  WaitFor(filter, "failed: ");
  filter->Modified();
  EXPECT_THAT(ErrorOfFit(filter), HasSubstr("no/such/folder"));
}

TEST(MultiscaleMeshFitterFilter, PropertiesAreClampedAndPrinted)
{
  vtkNew<vtkMultiscaleMeshFitter> filter;
  filter->SetNumberOfLevels(11);
  EXPECT_EQ(filter->GetNumberOfLevels(), 10);
  filter->SetTemplate(7);
  EXPECT_EQ(filter->GetTemplate(), vtkMultiscaleMeshFitter::SURFACE);
  filter->SetLearningRate(-1.0);
  EXPECT_GT(filter->GetLearningRate(), 0.0);
  filter->SetLearningRateDecay(2.0);
  EXPECT_EQ(filter->GetLearningRateDecay(), 1.0);
  filter->SetSamples(0);
  EXPECT_EQ(filter->GetSamples(), 1);
  const vtkMTimeType before = filter->GetMTime();
  filter->SetDatasetFileName(nullptr);
  EXPECT_EQ(filter->GetMTime(), before);
  std::ostringstream text;
  filter->Print(text);
  for (const char* line : { "NumberOfLevels: 10", "Template: 3", "IcosphereLevel: 2", "TorusSegments: 24",
         "Iterations: 300", "TriangulationSteps: 3", "ChamferSteps: 2", "Samples: 1", "LearningRateDecay: 1",
         "TemplateTriangles: 320", "SmoothingLength: 0", "PublishedNormals: 0", "Seed: 0", "Background: 0",
         "BackgroundState: ", "DatasetFileName: \n" })
  {
    EXPECT_THAT(text.str(), HasSubstr(line));
  }
}
