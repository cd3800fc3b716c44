// SPDX-License-Identifier: BSD-3-Clause
#include "FilterChecks.h"
#include "MalformedCorpus.h"
#include "VtkSurfaces.h"

#include "vtkEnsembleMetrics.h"
#include "vtkMaternNoiseFilter.h"

#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkIntArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPartitionedDataSet.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkSMPTools.h>
#include <vtkStringArray.h>
#include <vtkStructuredGrid.h>
#include <vtkTable.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <thread>

using namespace surfsynthtest;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

namespace
{
using Surfaces = std::vector<vtkSmartPointer<vtkPolyData>>;

/// The sphere moved by (0, 0, height), without an array or with one of that value at every point.
vtkSmartPointer<vtkPolyData> Moved(double height, const char* array = nullptr, int pointType = VTK_DOUBLE)
{
  Soup soup = Icosphere(1);
  for (std::size_t k = 2; k < soup.Points.size(); k += 3)
  {
    soup.Points[k] += height;
  }
  auto surface = soup.ToPolyData(pointType);
  if (array)
  {
    vtkNew<vtkDoubleArray> values;
    values->SetName(array);
    values->SetNumberOfTuples(surface->GetNumberOfPoints());
    values->FillValue(height);
    surface->GetPointData()->AddArray(values);
  }
  return surface;
}

vtkSmartPointer<vtkMultiBlockDataSet> Blocks(const Surfaces& surfaces)
{
  auto blocks = vtkSmartPointer<vtkMultiBlockDataSet>::New();
  for (const auto& surface : surfaces)
  {
    blocks->SetBlock(blocks->GetNumberOfBlocks(), surface);
  }
  return blocks;
}

/// Shapes at heights: all metrics are known by hand.
vtkSmartPointer<vtkMultiBlockDataSet> AtHeights(const std::vector<double>& heights, const char* array = nullptr)
{
  Surfaces surfaces;
  for (const double height : heights)
  {
    surfaces.push_back(Moved(height, array));
  }
  return Blocks(surfaces);
}

/// The sphere with arrays Noise_<first>, Noise_<first + 1> and so on.
vtkSmartPointer<vtkPolyData> WithNoise(int samples, int seed, int first = 0)
{
  vtkNew<vtkMaternNoiseFilter> noise;
  noise->SetInputData(Moved(0.0));
  noise->SetNumberOfSamples(samples);
  noise->SetFirstSample(first);
  noise->SetSeed(seed);
  noise->SetOutputArrayName("Noise");
  noise->SetCorrelationRange(2.0);
  EXPECT_TRUE(Update(noise));
  auto surface = vtkSmartPointer<vtkPolyData>::New();
  surface->ShallowCopy(noise->GetOutputDataObject(0));
  return surface;
}

vtkSmartPointer<vtkEnsembleMetrics> Filter(vtkDataObject* generated, vtkDataObject* reference, const char* array = "")
{
  auto filter = vtkSmartPointer<vtkEnsembleMetrics>::New();
  filter->SetInputDataObject(0, generated);
  filter->SetInputDataObject(1, reference);
  filter->SetArrayName(array);
  return filter;
}

vtkSmartPointer<vtkEnsembleMetrics> Compared(vtkDataObject* generated, vtkDataObject* reference, const char* array = "")
{
  const auto filter = Filter(generated, reference, array);
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  EXPECT_THAT(events.Errors, IsEmpty());
  return filter;
}

vtkTable* TableOf(vtkAlgorithm* filter, int port) { return vtkTable::SafeDownCast(filter->GetOutputDataObject(port)); }

double ValueOf(vtkAlgorithm* filter, const char* column)
{
  vtkTable* table = TableOf(filter, 0);
  EXPECT_EQ(table->GetNumberOfRows(), 1);
  EXPECT_TRUE(table->GetColumnByName(column)) << column;
  return table->GetNumberOfRows() == 1 ? table->GetValueByName(0, column).ToDouble() : std::nan("");
}

void ExpectEmpty(vtkAlgorithm* filter)
{
  EXPECT_EQ(TableOf(filter, 0)->GetNumberOfColumns(), 0);
  EXPECT_EQ(TableOf(filter, 1)->GetNumberOfColumns(), 0);
}

void ExpectRefusal(const vtkSmartPointer<vtkEnsembleMetrics>& filter, const std::vector<std::string>& parts)
{
  EventRecorder events(filter);
  EXPECT_FALSE(Update(filter));
  ASSERT_EQ(events.Errors.size(), 1u) << events.AllErrors();
  for (const std::string& part : parts)
  {
    EXPECT_THAT(events.Errors[0], HasSubstr(part));
  }
  ExpectEmpty(filter);
  EXPECT_EQ(filter->GetMMD(), 0.0);
}

class MetricsOfMalformedInput : public ::testing::TestWithParam<MalformedCase>
{};

INSTANTIATE_TEST_SUITE_P(Corpus, MetricsOfMalformedInput, ::testing::ValuesIn(MalformedCorpus()),
  [](const ::testing::TestParamInfo<MalformedCase>& info) { return info.param.Name; });

/// R1, R2, R3 and R6 for one malformed case as the given inputs.
void CheckMalformed(const MalformedCase& malformed, vtkDataObject* generated, vtkDataObject* reference)
{
  const auto filter = Filter(generated, reference);
  const std::uint64_t before = HashOf(generated) ^ HashOf(reference);
  EventRecorder events(filter);
  const double start = Now();
  const bool updated = Update(filter);
  EXPECT_LT(Now() - start, CaseTimeLimit()) << "R1";
  EXPECT_EQ(HashOf(generated) ^ HashOf(reference), before) << "R6";
  EXPECT_EQ(updated, events.Errors.empty()) << events.AllErrors();
  if (!updated)
  {
    ExpectEmpty(filter);
    EXPECT_NE(malformed.Expected == Expectation::Empty && generated == reference, true) << "R3";
    return;
  }
  vtkTable* table = TableOf(filter, 0);
  for (vtkIdType column = 0; column < table->GetNumberOfColumns(); ++column)
  {
    EXPECT_TRUE(std::isfinite(table->GetValue(0, column).ToDouble())) << table->GetColumnName(column);
  }
}
} // namespace

TEST_P(MetricsOfMalformedInput, AreFiniteOrAnError)
{
  const auto malformed = GetParam().Make();
  CheckMalformed(GetParam(), malformed, malformed);
  const auto good = AtHeights({ 0.0, 1.0 });
  CheckMalformed(GetParam(), malformed, good);
  CheckMalformed(GetParam(), good, malformed);
}

TEST(EnsembleMetricsFilter, ShapesByHand)
{
  const auto filter = Compared(AtHeights({ 0.0, 4.0 }), AtHeights({ 1.0, 10.0, 0.5 }));
  EXPECT_NEAR(ValueOf(filter, "MMD"), (0.5 + 3.0) / 2.0, 1e-12);
  EXPECT_NEAR(ValueOf(filter, "ReverseMMD"), (1.0 + 6.0 + 0.5) / 3.0, 1e-12);
  EXPECT_NEAR(ValueOf(filter, "COV"), 2.0 / 3.0, 1e-15);
  EXPECT_NEAR(ValueOf(filter, "OneNearestNeighbourAccuracy"), 0.2, 1e-15) << "only 1 is nearest to one of its kind";
  EXPECT_NEAR(ValueOf(filter, "MeanError"), 11.5 / 3.0 - 2.0, 1e-12);
  EXPECT_NEAR(ValueOf(filter, "GeneratedSpacing"), 4.0, 1e-12);
  EXPECT_NEAR(ValueOf(filter, "ReferenceSpacing"), (0.5 + 9.0 + 0.5) / 3.0, 1e-12);
  EXPECT_EQ(ValueOf(filter, "NumberOfGenerated"), 2);
  EXPECT_EQ(ValueOf(filter, "NumberOfReferences"), 3);
  EXPECT_EQ(ValueOf(filter, "NumberOfPoints"), 42);
  EXPECT_EQ(ValueOf(filter, "NumberOfComponents"), 3);
  EXPECT_EQ(TableOf(filter, 0)->GetNumberOfColumns(), 11);
  EXPECT_EQ(filter->GetMMD(), ValueOf(filter, "MMD"));
  EXPECT_EQ(filter->GetReverseMMD(), ValueOf(filter, "ReverseMMD"));
  EXPECT_EQ(filter->GetCOV(), ValueOf(filter, "COV"));
  EXPECT_EQ(filter->GetOneNearestNeighbourAccuracy(), ValueOf(filter, "OneNearestNeighbourAccuracy"));
  EXPECT_EQ(filter->GetMeanError(), ValueOf(filter, "MeanError"));
}

TEST(EnsembleMetricsFilter, TheSecondTableNamesTheNearestReferences)
{
  auto reference = AtHeights({ 1.0, 10.0, 0.5 });
  reference->SetBlock(1, nullptr); // numbers of samples and of blocks part
  const auto filter = Compared(AtHeights({ 0.0, 4.0 }), reference);
  vtkTable* table = TableOf(filter, 1);
  ASSERT_EQ(table->GetNumberOfRows(), 2);
  EXPECT_EQ(table->GetNumberOfColumns(), 5);
  EXPECT_EQ(table->GetValueByName(1, "Sample").ToInt(), 1);
  EXPECT_EQ(table->GetValueByName(0, "NearestReference").ToInt(), 1);
  EXPECT_EQ(table->GetValueByName(1, "NearestReference").ToInt(), 0);
  EXPECT_EQ(table->GetValueByName(1, "SampleName").ToString(), "Block 2");
  EXPECT_EQ(table->GetValueByName(0, "NearestReferenceName").ToString(), "Block 3");
  EXPECT_NEAR(table->GetValueByName(1, "Distance").ToDouble(), 3.0, 1e-12);
}

TEST(EnsembleMetricsFilter, ArraysOfBlocksAndOfOneSurface)
{
  const auto blocks = Compared(AtHeights({ 0.0, 4.0 }, "Height"), AtHeights({ 1.0, 10.0 }, "Height"), "Height");
  EXPECT_NEAR(blocks->GetMMD(), 2.0, 1e-12);
  EXPECT_EQ(ValueOf(blocks, "NumberOfComponents"), 1);
  const auto generated = WithNoise(12, 1);
  const auto noise = Compared(generated, WithNoise(12, 1), "Noise");
  EXPECT_EQ(ValueOf(noise, "NumberOfGenerated"), 12);
  EXPECT_EQ(noise->GetMMD(), 0.0);
  EXPECT_EQ(noise->GetCOV(), 1.0);
  EXPECT_EQ(TableOf(noise, 1)->GetValueByName(10, "SampleName").ToString(), "Noise_10") << "by number, not by letter";
  EXPECT_EQ(TableOf(noise, 1)->GetValueByName(10, "NearestReference").ToInt(), 10);
}

TEST(EnsembleMetricsFilter, ShiftedSamplesOfOneSeedAreFoundAgain)
{
  const auto filter = Compared(WithNoise(3, 1, 5), WithNoise(8, 1), "Noise");
  EXPECT_EQ(filter->GetMMD(), 0.0);
  EXPECT_EQ(filter->GetCOV(), 3.0 / 8.0);
  EXPECT_EQ(TableOf(filter, 1)->GetValueByName(2, "NearestReferenceName").ToString(), "Noise_7");
}

TEST(EnsembleMetricsFilter, AnArrayOfTheVeryNameIsTheOnlySample)
{
  const auto surface = WithNoise(3, 1);
  const auto only = Compared(surface, surface, "Noise_1");
  EXPECT_EQ(ValueOf(only, "NumberOfGenerated"), 1);
  vtkNew<vtkDoubleArray> exact;
  exact->DeepCopy(surface->GetPointData()->GetArray("Noise_2"));
  exact->SetName("Noise");
  surface->GetPointData()->AddArray(exact);
  const auto both = Compared(surface, surface, "Noise");
  EXPECT_EQ(ValueOf(both, "NumberOfGenerated"), 1);
}

TEST(EnsembleMetricsFilter, OtherCompositeTypesAndSingleSurfaces)
{
  vtkNew<vtkPartitionedDataSet> parts;
  parts->SetPartition(0, Moved(1.0));
  parts->SetPartition(1, Moved(2.0));
  vtkNew<vtkMultiBlockDataSet> nested;
  nested->SetBlock(0, AtHeights({ 1.0 }));
  nested->SetBlock(1, AtHeights({ 2.0 }));
  const auto filter = Compared(parts, nested);
  EXPECT_NEAR(filter->GetMMD(), 0.0, 1e-15);
  EXPECT_EQ(filter->GetCOV(), 1.0);
  const auto single = Compared(Moved(1.0), Moved(3.0));
  EXPECT_NEAR(single->GetMMD(), 2.0, 1e-12);
  EXPECT_EQ(TableOf(single, 1)->GetValueByName(0, "SampleName").ToString(), "Points");
}

TEST(EnsembleMetricsFilter, FloatDoubleAndIntegerValuesMix)
{
  const auto filter = Compared(Moved(1.0, nullptr, VTK_FLOAT), Blocks({ Moved(3.0), Moved(9.0, nullptr, VTK_FLOAT) }));
  EXPECT_NEAR(filter->GetMMD(), 2.0, 1e-6);
  const auto withIntegers = Moved(0.0);
  vtkNew<vtkIntArray> integers;
  integers->SetName("Height");
  integers->SetNumberOfTuples(42);
  integers->FillValue(5);
  withIntegers->GetPointData()->AddArray(integers);
  EXPECT_NEAR(Compared(withIntegers, Moved(2.0, "Height"), "Height")->GetMMD(), 3.0, 1e-12);
}

TEST(EnsembleMetricsFilter, DistanceAndCentroid)
{
  const auto filter = Compared(AtHeights({ 0.0, 4.0 }), AtHeights({ 1.0, 10.0 }));
  filter->RemoveCentroidOn();
  ASSERT_TRUE(Update(filter));
  EXPECT_NEAR(filter->GetMMD(), 0.0, 1e-14);
  filter->RemoveCentroidOff();
  const auto half = Moved(0.0, "Height");
  auto* values = vtkDoubleArray::SafeDownCast(half->GetPointData()->GetArray("Height"));
  values->SetValue(3, 6.0);
  const auto linear = Compared(Moved(0.0, "Height"), half, "Height");
  const double weight = linear->GetMMD() / 6.0;
  EXPECT_GT(weight, 0.0);
  EXPECT_LT(weight, 0.1);
  linear->SetDistanceToRMS();
  ASSERT_TRUE(Update(linear));
  EXPECT_NEAR(linear->GetMMD(), 6.0 * std::sqrt(weight), 1e-12);
}

TEST(EnsembleMetricsFilter, TheSourceGivesTheMass)
{
  const auto generated = Moved(0.0, "Value");
  const auto reference = Moved(0.0, "Value");
  vtkDoubleArray::SafeDownCast(reference->GetPointData()->GetArray("Value"))->SetValue(0, 1.0);
  const auto filter = Compared(generated, reference, "Value");
  const double before = filter->GetMMD();
  const auto source = Moved(0.0);
  double point[3];
  source->GetPoints()->GetPoint(0, point);
  source->GetPoints()->SetPoint(0, 9.0 * point[0], 9.0 * point[1], 9.0 * point[2]); // larger triangles around point 0
  filter->SetInputDataObject(2, source);
  ASSERT_TRUE(Update(filter));
  EXPECT_GT(filter->GetMMD(), 2.0 * before);
  filter->RemoveSource();
  ASSERT_TRUE(Update(filter));
  EXPECT_EQ(filter->GetMMD(), before);
  filter->SetInputDataObject(2, Icosphere(2).ToPolyData());
  ExpectRefusal(filter, { "reference sample 0 (Value) has 42 points and the source has 162", "one triangulation" });
}

TEST(EnsembleMetricsFilter, ASourceStandsInForAFoldedReference)
{
  const auto folded = Moved(0.0);
  double point[3];
  folded->GetPoints()->GetPoint(folded->GetCell(0)->GetPointId(1), point);
  folded->GetPoints()->SetPoint(folded->GetCell(0)->GetPointId(0), point);
  const auto filter = Filter(Moved(1.0), folded);
  ExpectRefusal(filter, { "mass of the points cannot be computed from the reference sample 0", "first cell" });
  filter->SetInputDataObject(2, Moved(0.0));
  EXPECT_TRUE(Update(filter));
  EXPECT_GT(filter->GetMMD(), 0.5);
}

TEST(EnsembleMetricsFilter, QuadsDeformedSoThatTheyAreCutOtherwiseAreTheSame)
{
  const auto flat = Grid(4, 4).ToPolyData();
  const auto bent = Grid(4, 4).ToPolyData();
  bent->GetPoints()->SetPoint(6, 0.45, 0.45, 0.0);
  EXPECT_GT(Compared(bent, flat)->GetMMD(), 0.0);
}

TEST(EnsembleMetricsFilter, EachMismatchIsOneErrorThatNamesTheSample)
{
  const auto good = AtHeights({ 0.0, 1.0 }, "Height");
  ExpectRefusal(Filter(Blocks({ Moved(0.0), Icosphere(2).ToPolyData() }), good),
    { "generated sample 1 (Block 2) has 162 points", "reference sample 0 (Block 1) has 42" });
  Soup turned = Icosphere(1);
  std::swap(turned.Polys[5][0], turned.Polys[5][1]);
  ExpectRefusal(Filter(good, Blocks({ Moved(0.0), turned.ToPolyData() })),
    { "reference sample 1 (Block 2) has other polygons", "same cells in the same order" });
  ExpectRefusal(Filter(AtHeights({ 0.0 }), good, "Height"),
    { "Block 1 of the generated ensemble has no numeric point array called \"Height\"",
      "name an array that all surfaces have" });
  ExpectRefusal(Filter(Moved(0.0), good, "Height"), { "The generated surface has no numeric point array" });
  const auto vectors = Moved(0.0);
  vtkNew<vtkFloatArray> array;
  array->SetName("Height");
  array->SetNumberOfComponents(2);
  array->SetNumberOfTuples(42);
  array->FillValue(0.0f);
  vectors->GetPointData()->AddArray(array);
  ExpectRefusal(
    Filter(vectors, good, "Height"), { "generated sample 0 (Height) has 2 components", "where 1 are needed" });
  array->SetNumberOfTuples(40);
  ExpectRefusal(Filter(vectors, good, "Height"), { "generated sample 0 (Height) has 40 values for 42 points" });
}

TEST(EnsembleMetricsFilter, ValuesThatAreNotFiniteAreAnError)
{
  const auto broken = Moved(0.0, "Height");
  auto* values = vtkDoubleArray::SafeDownCast(broken->GetPointData()->GetArray("Height"));
  values->SetValue(7, std::numeric_limits<double>::infinity());
  ExpectRefusal(Filter(Moved(0.0, "Height"), broken, "Height"), { "reference sample 0", "not finite, first point 7" });
  values->SetValue(7, 1e200);
  const auto filter = Filter(Moved(0.0, "Height"), broken, "Height");
  filter->SetDistanceToRMS();
  ExpectRefusal(filter, { "distance of generated sample 0 and reference sample 0 is not finite" });
}

TEST(EnsembleMetricsFilter, EmptyAndAbsentInput)
{
  vtkNew<vtkPolyData> empty;
  vtkNew<vtkMultiBlockDataSet> noBlocks;
  noBlocks->SetBlock(0, nullptr);
  noBlocks->SetBlock(1, empty);
  ExpectEmpty(Compared(empty, noBlocks));
  ExpectRefusal(Filter(empty, Moved(0.0)), { "generated ensemble is empty" });
  ExpectRefusal(Filter(Moved(0.0), noBlocks), { "reference ensemble is empty" });
  const auto partly = Blocks({ Moved(0.0), vtkSmartPointer<vtkPolyData>(empty), Moved(1.0) });
  EXPECT_EQ(ValueOf(Compared(partly, Moved(0.0)), "NumberOfGenerated"), 2);
  vtkNew<vtkEnsembleMetrics> absent;
  EventRecorder events(absent);
  EXPECT_FALSE(Update(absent));
  EXPECT_FALSE(events.Errors.empty());
}

TEST(EnsembleMetricsFilter, ALeafThatIsNoSurfaceIsAnError)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  vtkNew<vtkStructuredGrid> grid;
  blocks->SetBlock(0, Moved(0.0));
  blocks->SetBlock(1, grid);
  ExpectRefusal(Filter(Moved(0.0), blocks),
    { "Block 2 of the reference ensemble is a vtkStructuredGrid", "vtkDataSetSurfaceFilter" });
}

TEST(EnsembleMetricsFilter, InputsStayAsTheyAreAndEachChangeCostsOneExecution)
{
  const auto generated = WithNoise(3, 1);
  const auto reference = WithNoise(4, 2);
  const std::uint64_t before = HashOf(generated) ^ HashOf(reference);
  const auto filter = Compared(generated, reference, "Noise");
  EXPECT_EQ(HashOf(generated) ^ HashOf(reference), before);
  EventRecorder events(filter);
  const auto executionsAfter = [&](const std::function<void()>& change) {
    const int sofar = events.Executions;
    change();
    EXPECT_TRUE(Update(filter));
    return events.Executions - sofar;
  };
  EXPECT_EQ(executionsAfter([] {}), 0);
  EXPECT_EQ(executionsAfter([&] { filter->SetDistanceToRMS(); }), 1);
  EXPECT_EQ(executionsAfter([&] { filter->SetDistance(7); }), 0) << "clamped to what it is";
  EXPECT_EQ(executionsAfter([&] { filter->RemoveCentroidOn(); }), 1);
  EXPECT_EQ(executionsAfter([&] { filter->RemoveCentroidOn(); }), 0);
  EXPECT_EQ(executionsAfter([&] { filter->SetArrayName("Noise_1"); }), 1);
  EXPECT_EQ(executionsAfter([&] { filter->SetArrayName("Noise_1"); }), 0);
  EXPECT_EQ(executionsAfter([&] { filter->SetArrayName(nullptr); }), 1);
  EXPECT_STREQ(filter->GetArrayName(), "");
}

TEST(EnsembleMetricsFilter, AnAbortLeavesEmptyTablesAndTheNextUpdateIsComplete)
{
  Surfaces surfaces;
  const auto base = RingSphere(120, 120);
  for (int k = 0; k < 40; ++k)
  {
    surfaces.push_back(vtkSmartPointer<vtkPolyData>::New());
    surfaces.back()->DeepCopy(base);
    surfaces.back()->GetPoints()->SetPoint(k, 2.0, 0.0, 0.0);
  }
  const auto blocks = Blocks(surfaces);
  const auto filter = Filter(blocks, blocks);
  filter->SetInputDataObject(2, base);
  {
    EventRecorder events(filter);
    events.AbortAt = 0.3;
    EXPECT_TRUE(Update(filter)) << "an abort is no failure";
    EXPECT_THAT(events.Errors, IsEmpty());
    ASSERT_GE(events.SecondsAfterAbort, 0.0);
    EXPECT_LT(events.SecondsAfterAbort, 1.0) << "R9";
  }
  ExpectEmpty(filter);
  EXPECT_EQ(filter->GetCOV(), 0.0);
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  EXPECT_EQ(events.Executions, 1);
  EXPECT_TRUE(std::is_sorted(events.Progress.begin(), events.Progress.end())) << "R10";
  EXPECT_GE(events.Progress.size(), 20u);
  EXPECT_FALSE(events.ForeignThread);
  EXPECT_EQ(filter->GetCOV(), 1.0);
  EXPECT_EQ(TableOf(filter, 1)->GetNumberOfRows(), 40);
}

TEST(EnsembleMetricsFilter, TheSameBitsForEveryNumberOfThreads)
{
  const auto generated = WithNoise(23, 1);
  const auto reference = WithNoise(31, 2);
  std::vector<std::vector<double>> tables;
  for (const int threads : { 1, 2, 7 })
  {
    vtkSMPTools::LocalScope(vtkSMPTools::Config(threads), [&] {
      const auto filter = Compared(generated, reference, "Noise");
      tables.push_back({ filter->GetMMD(), filter->GetReverseMMD(), filter->GetCOV(), filter->GetMeanError(),
        filter->GetOneNearestNeighbourAccuracy() });
    });
  }
  EXPECT_EQ(tables[1], tables[0]);
  EXPECT_EQ(tables[2], tables[0]);
  EXPECT_GT(tables[0][0], 0.0);
}

TEST(EnsembleMetricsFilter, TwoFiltersOnTwoThreads)
{
  const auto generated = AtHeights({ 0.0, 4.0 });
  const auto work = [&] {
    vtkNew<vtkMultiBlockDataSet> mine;
    mine->DeepCopy(generated);
    EXPECT_NEAR(Compared(mine, AtHeights({ 1.0, 10.0 }))->GetMMD(), 2.0, 1e-12);
  };
  std::thread other(work);
  work();
  other.join();
}

TEST(EnsembleMetricsFilter, PrintsItsProperties)
{
  std::ostringstream text;
  Compared(AtHeights({ 0.0 }, "Height"), AtHeights({ 2.0 }, "Height"), "Height")->Print(text);
  for (const char* part : { "ArrayName: Height", "Distance: 0", "RemoveCentroid: 0", "MMD: 2", "COV: 1",
         "OneNearestNeighbourAccuracy: 0", "MeanError: 2" })
  {
    EXPECT_THAT(text.str(), HasSubstr(part));
  }
}
