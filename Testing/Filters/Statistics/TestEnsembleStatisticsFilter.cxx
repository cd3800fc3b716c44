// SPDX-License-Identifier: BSD-3-Clause
#include "FilterChecks.h"
#include "FilterContract.h"
#include "VtkSurfaces.h"

#include "vtkEnsembleStatistics.h"
#include "vtkMaternNoiseFilter.h"
#include "vtkShapeModelSampler.h"

#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPartitionedDataSet.h>
#include <vtkPointData.h>
#include <vtkPolyDataAlgorithm.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#include <vtkStringArray.h>
#include <vtkTable.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sstream>

using namespace surfsynthtest;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

namespace
{
/// The sphere stretched by (1 + a, 1 + b, 1): two modes.
vtkSmartPointer<vtkPolyData> Stretched(double a, double b)
{
  Soup soup = Icosphere(1);
  for (std::size_t k = 0; k < soup.Points.size(); k += 3)
  {
    soup.Points[k] *= 1.0 + a;
    soup.Points[k + 1] *= 1.0 + b;
  }
  return soup.ToPolyData();
}

/// Three stretched spheres in x.
vtkSmartPointer<vtkMultiBlockDataSet> ThreeShapes()
{
  auto blocks = vtkSmartPointer<vtkMultiBlockDataSet>::New();
  blocks->SetBlock(0, Stretched(-0.2, 0.0));
  blocks->SetBlock(2, Stretched(0.0, 0.0));
  blocks->SetBlock(3, Stretched(0.2, 0.0));
  return blocks;
}

vtkSmartPointer<vtkEnsembleStatistics> Filter(vtkDataObject* input, int modes = 0, const char* array = "")
{
  auto filter = vtkSmartPointer<vtkEnsembleStatistics>::New();
  filter->SetInputDataObject(input);
  filter->SetArrayName(array);
  filter->SetNumberOfModes(modes);
  return filter;
}

vtkSmartPointer<vtkEnsembleStatistics> Computed(vtkDataObject* input, int modes = 0, const char* array = "")
{
  const auto filter = Filter(input, modes, array);
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter)) << events.AllErrors();
  EXPECT_THAT(events.Errors, IsEmpty());
  return filter;
}

vtkTable* TableOf(vtkAlgorithm* filter, int port) { return vtkTable::SafeDownCast(filter->GetOutputDataObject(port)); }

vtkPolyData* BlockOf(vtkAlgorithm* sampler, unsigned int block)
{
  auto* blocks = vtkMultiBlockDataSet::SafeDownCast(sampler->GetOutputDataObject(0));
  return vtkPolyData::SafeDownCast(blocks->GetBlock(block));
}

/// Sphere whose array Height is at time t the value t at each point.
class TimedHeights : public vtkPolyDataAlgorithm
{
public:
  static TimedHeights* New();
  vtkTypeMacro(TimedHeights, vtkPolyDataAlgorithm);

protected:
  TimedHeights() { this->SetNumberOfInputPorts(0); }
  int RequestInformation(vtkInformation*, vtkInformationVector**, vtkInformationVector* outputVector) override
  {
    const double times[4] = { 1.0, 2.0, 4.0, 9.0 };
    vtkInformation* info = outputVector->GetInformationObject(0);
    info->Set(vtkStreamingDemandDrivenPipeline::TIME_STEPS(), times, 4);
    const double range[2] = { 1.0, 9.0 };
    info->Set(vtkStreamingDemandDrivenPipeline::TIME_RANGE(), range, 2);
    return 1;
  }
  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector* outputVector) override
  {
    vtkInformation* info = outputVector->GetInformationObject(0);
    const double time = info->Get(vtkStreamingDemandDrivenPipeline::UPDATE_TIME_STEP());
    if (!this->Surface)
    {
      this->Surface = Stretched(0.0, 0.0);
      this->Values->SetName("Height");
      this->Values->SetNumberOfTuples(this->Surface->GetNumberOfPoints());
      this->Surface->GetPointData()->AddArray(this->Values);
    }
    this->Values->FillValue(time); // in place: a filter that keeps the array has other values later
    vtkPolyData::GetData(outputVector)->ShallowCopy(this->Surface);
    return 1;
  }

private:
  vtkSmartPointer<vtkPolyData> Surface;
  vtkNew<vtkDoubleArray> Values;
};
vtkStandardNewMacro(TimedHeights);

/// A model of spheres that are stretched along x and y.
vtkSmartPointer<vtkEnsembleStatistics> TwoModes()
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  const double stretches[5][2] = { { -0.2, 0.1 }, { 0.3, 0.0 }, { 0.0, -0.1 }, { 0.1, 0.2 }, { -0.2, -0.2 } };
  for (unsigned int k = 0; k < 5; ++k)
  {
    blocks->SetBlock(k, Stretched(stretches[k][0], stretches[k][1]));
  }
  return Computed(blocks, -1);
}
} // namespace

TEST(EnsembleStatisticsFilter, ShapesByHand)
{
  const auto filter = Filter(ThreeShapes(), 5);
  filter->SetNumberOfQuantiles(2);
  filter->SetQuantile(0, 0.25);
  const std::uint64_t before = HashOf(filter->GetInputDataObject(0, 0));
  const auto mean = SurfaceOf(filter);
  EXPECT_EQ(HashOf(filter->GetInputDataObject(0, 0)), before) << "the input stays";
  const auto sphere = Stretched(0.0, 0.0);
  ASSERT_EQ(mean->GetNumberOfPoints(), sphere->GetNumberOfPoints());
  EXPECT_EQ(mean->GetNumberOfPolys(), sphere->GetNumberOfPolys());
  const double norm = 0.2; // standard deviation of -0.2, 0, 0.2
  double sum = 0.0;
  for (vtkIdType v = 0; v < mean->GetNumberOfPoints(); ++v)
  {
    const double* p = sphere->GetPoint(v);
    const double x = p[0];
    const double expected[3] = { p[0], p[1], p[2] };
    for (int c = 0; c < 3; ++c)
    {
      EXPECT_NEAR(mean->GetPoints()->GetData()->GetComponent(v, c), expected[c], 1e-14);
    }
    EXPECT_NEAR(PointArray(mean, "StandardDeviation")->GetComponent(v, 0), std::abs(x) * norm, 1e-14);
    EXPECT_NEAR(PointArray(mean, "StandardDistance")->GetComponent(v, 0), std::abs(x) * norm, 1e-14);
    EXPECT_NEAR(PointArray(mean, "Quantile_0.25")->GetComponent(v, 0), x - 0.1 * std::abs(x), 1e-14);
    EXPECT_NEAR(PointArray(mean, "Quantile_0.5")->GetComponent(v, 0), x, 1e-14);
    EXPECT_NEAR(std::abs(PointArray(mean, "Mode_0")->GetComponent(v, 0)), std::abs(x) * norm, 1e-12);
    sum += x * x * norm * norm;
  }
  EXPECT_FALSE(mean->GetPointData()->HasArray("Mode_1")) << "one direction only";
  EXPECT_NEAR(mean->GetFieldData()->GetArray("ModeStandardDeviations")->GetTuple1(0), std::sqrt(sum), 1e-12);
  EXPECT_NEAR(mean->GetFieldData()->GetArray("TotalVariance")->GetTuple1(0), sum, 1e-12);
  EXPECT_EQ(mean->GetFieldData()->GetArray("NumberOfSamples")->GetTuple1(0), 3);
  vtkTable* modes = TableOf(filter, 1);
  ASSERT_EQ(modes->GetNumberOfRows(), 1);
  EXPECT_NEAR(modes->GetValueByName(0, "Variance").ToDouble(), sum, 1e-12);
  EXPECT_NEAR(modes->GetValueByName(0, "CumulativeFraction").ToDouble(), 1.0, 1e-12);
  vtkTable* samples = TableOf(filter, 2);
  ASSERT_EQ(samples->GetNumberOfRows(), 3);
  EXPECT_EQ(samples->GetValueByName(1, "SampleName").ToString(), "Block 3") << "flat index beside a null block";
  EXPECT_NEAR(std::abs(samples->GetValueByName(2, "Coefficient_0").ToDouble()), 1.0, 1e-12);
}

TEST(EnsembleStatisticsFilter, ArraysOfOneSurfaceAreSamples)
{
  vtkNew<vtkMaternNoiseFilter> noise;
  noise->SetInputData(Stretched(0.0, 0.0));
  noise->SetNumberOfSamples(20);
  noise->SetOutputArrayName("Noise");
  noise->SetCorrelationRange(2.0);
  const auto filter = vtkSmartPointer<vtkEnsembleStatistics>::New();
  filter->SetInputConnection(noise->GetOutputPort());
  filter->SetArrayName("Noise");
  const auto mean = SurfaceOf(filter);
  double sum = 0.0;
  for (int k = 0; k < 20; ++k)
  {
    sum += PointArray(noise->GetOutputDataObject(0), ("Noise_" + std::to_string(k)).c_str())->GetTuple1(11);
  }
  EXPECT_NEAR(PointArray(mean, "Mean")->GetTuple1(11), sum / 20.0, 1e-12);
  EXPECT_FALSE(mean->GetPointData()->HasArray("StandardDistance")) << "one component";
  EXPECT_FALSE(mean->GetPointData()->HasArray("Noise_0"));
  EXPECT_EQ(TableOf(filter, 1)->GetNumberOfRows(), 0);
}

TEST(EnsembleStatisticsFilter, ConnectionsAndPartitionsAreSamplesToo)
{
  const auto blocks = ThreeShapes();
  const auto together = Computed(blocks);
  vtkNew<vtkPartitionedDataSet> parts;
  parts->SetPartition(0, Stretched(0.0, 0.0));
  parts->SetPartition(1, Stretched(0.2, 0.0));
  vtkNew<vtkEnsembleStatistics> several;
  several->AddInputDataObject(Stretched(-0.2, 0.0));
  several->AddInputDataObject(parts);
  const auto mean = SurfaceOf(several);
  EXPECT_TRUE(
    SameBits(PointArray(mean, "StandardDeviation"), PointArray(together->GetOutputDataObject(0), "StandardDeviation")));
  EXPECT_THAT(TableOf(several, 2)->GetValueByName(2, "SampleName").ToString(), HasSubstr("Input 1: Block"));
}

TEST(EnsembleStatisticsFilter, TimeStepsAreSamples)
{
  vtkNew<TimedHeights> source;
  vtkNew<vtkEnsembleStatistics> filter;
  filter->SetInputConnection(source->GetOutputPort());
  filter->SetArrayName("Height");
  filter->UseTimeStepsOn();
  const auto expect = [&] {
    const auto mean = SurfaceOf(filter);
    EXPECT_NEAR(PointArray(mean, "Mean")->GetTuple1(3), 4.0, 1e-14);
    EXPECT_NEAR(PointArray(mean, "StandardDeviation")->GetTuple1(3), std::sqrt(38.0 / 3.0), 1e-14);
    EXPECT_EQ(TableOf(filter, 2)->GetNumberOfRows(), 4);
  };
  expect();
  filter->SetNumberOfModes(1); // keeps the values of all steps
  filter->SetNumberOfQuantiles(1);
  expect();
  EXPECT_NEAR(PointArray(filter->GetOutputDataObject(0), "Quantile_0.5")->GetTuple1(3), 3.0, 1e-14);
  EXPECT_EQ(TableOf(filter, 1)->GetNumberOfRows(), 1);
  vtkInformation* info = filter->GetOutputInformation(0);
  EXPECT_FALSE(info->Has(vtkStreamingDemandDrivenPipeline::TIME_STEPS())) << "the result has no time";
}

TEST(EnsembleStatisticsFilter, RefusesWrongInputsInWords)
{
  EXPECT_THAT(ErrorOf(Filter(Stretched(0.0, 0.0))), HasSubstr("1 sample; expected at least 2"));
  EXPECT_THAT(ErrorOf(Filter(ThreeShapes(), 0, "Height")), HasSubstr("no numeric point array called \"Height\""));
  auto blocks = ThreeShapes();
  blocks->SetBlock(3, Grid(3).ToPolyData());
  EXPECT_THAT(ErrorOf(Filter(blocks)), HasSubstr("all samples must lie on one triangulation"));
  Soup turned = Icosphere(1);
  std::swap(turned.Polys[7][0], turned.Polys[7][1]);
  blocks->SetBlock(3, turned.ToPolyData());
  EXPECT_THAT(ErrorOf(Filter(blocks)), HasSubstr("other polygons or strips"));
  const auto broken = Stretched(0.1, 0.0);
  broken->GetPoints()->SetPoint(5, 0.0, std::numeric_limits<double>::quiet_NaN(), 0.0);
  blocks->SetBlock(3, broken);
  EXPECT_THAT(ErrorOf(Filter(blocks)), HasSubstr("not finite at point 5"));
  const auto quantile = Filter(ThreeShapes());
  quantile->SetNumberOfQuantiles(1);
  quantile->SetQuantile(0, -0.5);
  EXPECT_THAT(ErrorOf(quantile), HasSubstr("probability of a quantile"));
}

TEST(EnsembleStatisticsFilter, EmptyInputGivesEmptyOutput)
{
  vtkNew<vtkPolyData> empty;
  const auto filter = Computed(empty, 3);
  EXPECT_EQ(vtkPolyData::SafeDownCast(filter->GetOutputDataObject(0))->GetNumberOfPoints(), 0);
  EXPECT_EQ(TableOf(filter, 1)->GetNumberOfColumns(), 0);
}

TEST(EnsembleStatisticsFilter, SameBitsForAllNumbersOfThreads)
{
  const auto blocks = ThreeShapes();
  ExpectSameBitsForAllThreads([&] { return Filter(blocks, 1); },
    [](vtkAlgorithm* filter) { return PointArray(filter->GetOutputDataObject(0), "Mode_0"); });
}

TEST(EnsembleStatisticsFilter, EachPropertyRunsItOnce)
{
  const auto filter = Filter(ThreeShapes());
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  const PropertyChanges<vtkEnsembleStatistics> changes = {
    { "NumberOfModes", [](vtkEnsembleStatistics* f) { f->SetNumberOfModes(1); } },
    { "NumberOfQuantiles", [](vtkEnsembleStatistics* f) { f->SetNumberOfQuantiles(1); } },
    { "Quantile", [](vtkEnsembleStatistics* f) { f->SetQuantile(0, 0.1); } },
    { "UseTimeSteps", [](vtkEnsembleStatistics* f) { f->UseTimeStepsOn(); } },
  };
  ExpectOneExecutionEach(filter.Get(), changes, events);
  filter->SetQuantile(3, 0.1);
  EXPECT_EQ(filter->GetQuantile(0), 0.1);
  EXPECT_EQ(filter->GetQuantile(3), 0.0);
  std::ostringstream text;
  filter->Print(text);
  EXPECT_THAT(text.str(), HasSubstr("Quantiles: 0.1"));
}

TEST(ShapeModelSampler, GivenCoefficientsMoveTheMean)
{
  const auto statistics = TwoModes();
  const auto* mean = vtkPolyData::SafeDownCast(statistics->GetOutputDataObject(0));
  vtkNew<vtkShapeModelSampler> sampler;
  sampler->SetInputConnection(statistics->GetOutputPort());
  sampler->SetCoefficientSourceToGiven();
  sampler->SetNumberOfCoefficients(2);
  sampler->SetCoefficient(1, -2.0);
  OutputOf(sampler);
  vtkPolyData* shape = BlockOf(sampler, 0);
  vtkDataArray* mode = PointArray(statistics->GetOutputDataObject(0), "Mode_1");
  for (vtkIdType v = 0; v < shape->GetNumberOfPoints(); ++v)
  {
    for (int c = 0; c < 3; ++c)
    {
      EXPECT_NEAR(shape->GetPoints()->GetData()->GetComponent(v, c),
        const_cast<vtkPolyData*>(mean)->GetPoints()->GetData()->GetComponent(v, c) - 2.0 * mode->GetComponent(v, c),
        1e-13);
    }
  }
  EXPECT_EQ(shape->GetNumberOfPolys(), Stretched(0, 0)->GetNumberOfPolys());
  EXPECT_EQ(shape->GetFieldData()->GetArray("Coefficients")->GetTuple1(1), -2.0);
  sampler->SetNumberOfCoefficients(4);
  EXPECT_THAT(ErrorOf(sampler), HasSubstr("4 coefficients; expected at most 2"));
}

TEST(ShapeModelSampler, SampleKIsTheSameAloneAndInABatch)
{
  const auto statistics = TwoModes();
  vtkNew<vtkShapeModelSampler> batch;
  batch->SetInputConnection(statistics->GetOutputPort());
  batch->SetNumberOfSamples(4);
  batch->SetSeed(5);
  OutputOf(batch);
  vtkNew<vtkShapeModelSampler> alone;
  alone->SetInputConnection(statistics->GetOutputPort());
  alone->SetFirstSample(3);
  alone->SetSeed(5);
  OutputOf(alone);
  EXPECT_TRUE(SameBits(BlockOf(batch, 3)->GetPoints()->GetData(), BlockOf(alone, 0)->GetPoints()->GetData()));
  EXPECT_FALSE(SameBits(BlockOf(batch, 2)->GetPoints()->GetData(), BlockOf(alone, 0)->GetPoints()->GetData()));
  alone->SetSeed(6);
  OutputOf(alone);
  EXPECT_FALSE(SameBits(BlockOf(batch, 3)->GetPoints()->GetData(), BlockOf(alone, 0)->GetPoints()->GetData()));
}

TEST(ShapeModelSampler, ProjectionFindsTheCoefficientsOfTheSamples)
{
  const auto statistics = TwoModes();
  vtkNew<vtkShapeModelSampler> sampler;
  sampler->SetInputConnection(0, statistics->GetOutputPort());
  sampler->SetInputDataObject(1, statistics->GetInputDataObject(0, 0));
  sampler->SetCoefficientSourceToProjected();
  OutputOf(sampler);
  for (unsigned int k = 0; k < 5; ++k)
  {
    vtkPolyData* shape = BlockOf(sampler, k);
    EXPECT_NEAR(shape->GetFieldData()->GetArray("Coefficients")->GetTuple1(1),
      TableOf(statistics, 2)->GetValueByName(k, "Coefficient_1").ToDouble(), 1e-10);
    EXPECT_LT(shape->GetFieldData()->GetArray("RMSResidual")->GetTuple1(0), 1e-12) << "both modes hold all samples";
  }
  sampler->SetNumberOfModes(1);
  OutputOf(sampler);
  vtkPolyData* shape = BlockOf(sampler, 0);
  EXPECT_GT(shape->GetFieldData()->GetArray("RMSResidual")->GetTuple1(0), 0.01);
  EXPECT_EQ(shape->GetFieldData()->GetArray("Coefficients")->GetNumberOfTuples(), 1);
  EXPECT_EQ(PointArray(shape, "Residual")->GetNumberOfComponents(), 1);
}

TEST(ShapeModelSampler, ModelsOfAnArrayMakeThatArray)
{
  vtkNew<vtkMaternNoiseFilter> noise;
  noise->SetInputData(Stretched(0.0, 0.0));
  noise->SetNumberOfSamples(6);
  noise->SetOutputArrayName("Noise");
  noise->SetCorrelationRange(2.0);
  vtkNew<vtkEnsembleStatistics> statistics;
  statistics->SetInputConnection(noise->GetOutputPort());
  statistics->SetArrayName("Noise");
  statistics->SetNumberOfModes(-1);
  vtkNew<vtkShapeModelSampler> sampler;
  sampler->SetInputConnection(0, statistics->GetOutputPort());
  sampler->SetInputConnection(1, noise->GetOutputPort());
  sampler->SetCoefficientSourceToProjected();
  OutputOf(sampler);
  vtkDataObject* sampled = noise->GetOutputDataObject(0);
  EXPECT_LT(LargestDifference(PointArray(BlockOf(sampler, 4), "Noise"), PointArray(sampled, "Noise_4")), 1e-10);
}

TEST(ShapeModelSampler, RefusesWhatIsNoModelInWords)
{
  vtkNew<vtkShapeModelSampler> sampler;
  sampler->SetInputDataObject(0, Stretched(0.0, 0.0));
  EXPECT_THAT(ErrorOf(sampler), HasSubstr("no point array \"Mode_0\""));
  const auto statistics = TwoModes();
  sampler->SetInputConnection(0, statistics->GetOutputPort());
  sampler->SetCoefficientSourceToProjected();
  EXPECT_THAT(ErrorOf(sampler), HasSubstr("no projected ensemble"));
  sampler->SetInputDataObject(1, Grid(3).ToPolyData());
  EXPECT_THAT(ErrorOf(sampler), HasSubstr("the model has 42"));
  std::ostringstream text;
  sampler->Print(text);
  EXPECT_THAT(text.str(), HasSubstr("CoefficientSource: 2"));
}
