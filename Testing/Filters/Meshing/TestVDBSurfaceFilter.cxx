// SPDX-License-Identifier: BSD-3-Clause
//
// vtkVDBSurfaceFilter as a filter: messages, executions, bits, interruption, memory limit.
#include "ExampleImages.h"
#include "FilterContract.h"
#include "VtkSurfaces.h"

#include "vtkVDBSurfaceFilter.h"

#include <vtkCellArray.h>
#include <vtkDataArray.h>
#include <vtkFloatArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkSMPTools.h>
#include <vtkStructuredGrid.h>
#include <vtkTrivialProducer.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <tbb/global_control.h>

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <limits>
#include <sstream>
#include <utility>

using namespace surfsynthtest;
using Filter = vtkVDBSurfaceFilter;
using ::testing::HasSubstr;

namespace
{
const PropertyChanges<Filter>& Changes()
{
  static const PropertyChanges<Filter> changes = {
    { "ComputeIsoValue", [](Filter* f) { f->ComputeIsoValueOff(); } },
    { "IsoValue", [](Filter* f) { f->SetIsoValue(0.5); } },
    { "InsideRule", [](Filter* f) { f->SetInsideRuleToBelow(); } },
    { "VoxelSize", [](Filter* f) { f->SetVoxelSize(1.5); } },
    { "Closing", [](Filter* f) { f->SetClosing(2.0); } },
    { "Smoothing", [](Filter* f) { f->SetSmoothingToMeanCurvature(); } },
    { "SmoothingIterations", [](Filter* f) { f->SetSmoothingIterations(2); } },
    { "Offset", [](Filter* f) { f->SetOffset(-0.5); } },
    { "Adaptivity", [](Filter* f) { f->SetAdaptivity(0.2); } },
    { "FillCavities", [](Filter* f) { f->FillCavitiesOn(); } },
    { "LargestComponent", [](Filter* f) { f->LargestComponentOn(); } },
    { "MaximumNumberOfVoxels", [](Filter* f) { f->SetMaximumNumberOfVoxels(1000000); } },
  };
  return changes;
}

vtkSmartPointer<vtkImageData> BallImage(int side)
{
  ImageGeometry geometry;
  geometry.Dimensions = { { side, side, side } };
  return MakeImage(geometry, Ball(geometry.Center(), 0.4 * side));
}

std::string ErrorFor(
  vtkDataObject* input, const std::function<void(Filter*)>& change = [](Filter*) {})
{
  vtkNew<Filter> filter;
  filter->SetInputDataObject(input);
  change(filter);
  return ErrorOf(filter);
}
} // namespace

TEST(VDBSurfaceMessages, EachNamesWhatWasFoundAndWhatToDo)
{
  vtkNew<Filter> alone;
  EXPECT_THAT(ErrorOf(alone), HasSubstr("a vtkImageData or a vtkPolyData, or a composite dataset, is needed"));

  vtkNew<vtkImageData> bare;
  bare->SetDimensions(4, 4, 4);
  EXPECT_THAT(ErrorFor(bare), HasSubstr("no such array of numbers"));
  const auto vectors = BallImage(8);
  vtkNew<vtkFloatArray> three;
  three->SetName("Velocity");
  three->SetNumberOfComponents(3);
  three->SetNumberOfTuples(512);
  three->Fill(1.0);
  vectors->GetPointData()->SetScalars(three);
  EXPECT_THAT(ErrorFor(vectors), HasSubstr("'Velocity' has 512 values of 3 component(s)"));
  const auto sheared = BallImage(8);
  sheared->SetDirectionMatrix(1, 0.5, 0, 0, 1, 0, 0, 0, 1);
  EXPECT_THAT(ErrorFor(sheared), HasSubstr("sheared or scaled; resample it on orthogonal axes with vtkImageReslice"));
  const auto flat = BallImage(8);
  flat->SetSpacing(1.0, 0.0, 1.0);
  EXPECT_THAT(ErrorFor(flat), HasSubstr("has the spacing 1, 0, 1"));

  Soup lost = Icosphere(2);
  lost.Points[3 * 5 + 1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(ErrorFor(lost.ToPolyData()), HasSubstr("1 point(s) with a NaN or infinite coordinate, first point 5"));
  Soup outside = Icosphere(2);
  outside.Polys[3][1] = 5000;
  EXPECT_THAT(ErrorFor(outside.ToPolyData()), HasSubstr("name a point that does not exist, first cell 3"));
  Soup point = Icosphere(1);
  std::fill(point.Points.begin(), point.Points.end(), 2.0);
  EXPECT_THAT(
    ErrorFor(point.ToPolyData()), HasSubstr("span a box of longest side 0, to be divided into voxels of size 0"));
  const auto sphere = Icosphere(2).ToPolyData();
  EXPECT_THAT(ErrorFor(sphere, [](Filter* f) { f->SetOffset(std::numeric_limits<double>::infinity()); }),
    HasSubstr("Offset is inf; a finite number is needed"));
}

TEST(VDBSurfaceMessages, TooManyVoxelsAreRefusedAndTheSizeThatIsNamedFits)
{
  const auto sphere = Icosphere(3).ToPolyData();
  const double before = static_cast<double>(ResidentMemory());
  const auto tiny = [](Filter* f) {
    f->SetVoxelSize(1e-5);
    f->SetMaximumNumberOfVoxels(500000);
  };
  const std::string error = ErrorFor(sphere, tiny);
  EXPECT_THAT(error, HasSubstr("voxels of size 1e-05 would be needed"));
  EXPECT_LT(static_cast<double>(ResidentMemory()) - before, 1e8) << "before memory is taken";
  const std::string mark = "A VoxelSize of ";
  const double fitting = std::strtod(error.c_str() + error.find(mark) + mark.size(), nullptr);
  vtkNew<Filter> filter;
  filter->SetInputDataObject(sphere);
  filter->SetMaximumNumberOfVoxels(500000);
  filter->SetVoxelSize(fitting);
  EXPECT_TRUE(Update(filter));
  EXPECT_GT(filter->GetPolyDataOutput()->GetNumberOfPolys(), 10000) << "and is not far too large";
  EXPECT_THAT(ErrorFor(BallImage(20), [](Filter* f) { f->SetVoxelSize(1e-4); }), HasSubstr("A VoxelSize of "));
}

TEST(VDBSurfaceMessages, AnOffsetThatCostsTooMuchIsRefusedAndTheSizeThatIsNamedFits)
{
  const auto sphere = Icosphere(3).ToPolyData();
  const auto offset = [](double length, double voxelSize) {
    return [=](Filter* f) {
      f->SetOffset(length);
      f->SetVoxelSize(voxelSize);
      f->SetMaximumNumberOfVoxels(50000);
    };
  };
  for (const double length : { 5.0, 1e6 })
  {
    const std::string error = ErrorFor(sphere, offset(length, 0.1));
    EXPECT_THAT(error, HasSubstr("to move the surface by"));
    const std::string mark = "A VoxelSize of ";
    const double fitting = std::strtod(error.c_str() + error.find(mark) + mark.size(), nullptr);
    vtkNew<Filter> filter;
    filter->SetInputDataObject(sphere);
    offset(length, fitting)(filter);
    EXPECT_TRUE(Update(filter)) << length;
  }
  EXPECT_THAT(ErrorFor(BallImage(20), offset(1e6, 0.5)), HasSubstr("to move the surface by"));
  vtkNew<Filter> inwards; // nothing is left, and soon
  inwards->SetInputDataObject(sphere);
  offset(-1e9, 0.1)(inwards);
  EXPECT_TRUE(Update(inwards));
  EXPECT_EQ(inwards->GetPolyDataOutput()->GetNumberOfPolys(), 0);
}

TEST(VDBSurfaceMessages, ABlockOfAnotherTypeIsNamedAndTheOthersStay)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, Icosphere(2).ToPolyData());
  vtkNew<vtkStructuredGrid> grid;
  grid->SetPoints(Icosphere(1).ToPolyData()->GetPoints());
  blocks->SetBlock(1, grid);
  vtkNew<Filter> filter;
  filter->SetInputDataObject(blocks);
  filter->SetVoxelSize(0.2);
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  ASSERT_EQ(events.Errors.size(), 1u);
  EXPECT_THAT(
    events.Errors[0], HasSubstr("Block 2: A vtkStructuredGrid was found where a vtkImageData or a vtkPolyData"));
  auto* output = vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0));
  EXPECT_GT(vtkPolyData::SafeDownCast(output->GetBlock(0))->GetNumberOfPolys(), 0);
}

TEST(VDBSurfaceFilter, EmptyInputGivesEmptyOutputWithoutARemark)
{
  vtkNew<vtkImageData> image;
  vtkNew<vtkPolyData> surface;
  for (vtkDataObject* input : { static_cast<vtkDataObject*>(image.Get()), static_cast<vtkDataObject*>(surface.Get()) })
  {
    vtkNew<Filter> filter;
    filter->SetInputDataObject(input);
    EventRecorder events(filter);
    EXPECT_TRUE(Update(filter));
    EXPECT_TRUE(events.Errors.empty() && events.Warnings.empty());
    EXPECT_EQ(filter->GetPolyDataOutput()->GetNumberOfPoints(), 0);
  }
}

TEST(VDBSurfaceFilter, UnchangedParametersCostNoExecutionAndEachChangeExactlyOne)
{
  vtkNew<Filter> filter;
  filter->SetInputDataObject(BallImage(9));
  EXPECT_TRUE(Update(filter));
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  EXPECT_EQ(events.Executions, 0) << "nothing has changed";
  ExpectOneExecutionEach(filter.Get(), Changes(), events);
}

TEST(VDBSurfaceFilter, RangesAreKept)
{
  vtkNew<Filter> filter;
  filter->SetVoxelSize(-1.0);
  filter->SetClosing(-2.0);
  filter->SetAdaptivity(3.0);
  filter->SetSmoothing(17);
  filter->SetSmoothingIterations(-3);
  filter->SetInsideRule(-1);
  filter->SetMaximumNumberOfVoxels(5);
  EXPECT_EQ(filter->GetVoxelSize(), 0.0);
  EXPECT_EQ(filter->GetClosing(), 0.0);
  EXPECT_EQ(filter->GetAdaptivity(), 1.0);
  EXPECT_EQ(filter->GetSmoothing(), Filter::LAPLACIAN);
  EXPECT_EQ(filter->GetSmoothingIterations(), 0);
  EXPECT_EQ(filter->GetInsideRule(), Filter::ABOVE);
  EXPECT_EQ(filter->GetMaximumNumberOfVoxels(), 1000);
}

TEST(VDBSurfaceFilter, PrintsEveryProperty)
{
  vtkNew<Filter> filter;
  std::ostringstream text;
  filter->Print(text);
  for (const auto& change : Changes())
  {
    EXPECT_THAT(text.str(), HasSubstr(std::string(change.first) + ": "));
  }
  EXPECT_THAT(text.str(), HasSubstr("EffectiveIsoValue: "));
}

TEST(VDBSurfaceFilter, TheWholeExtentOfASourceIsAskedFor)
{
  vtkNew<vtkTrivialProducer> source;
  source->SetOutput(BallImage(20));
  vtkNew<Filter> filter;
  filter->SetInputConnection(source->GetOutputPort());
  EXPECT_TRUE(Update(filter));
  EXPECT_EQ(DefectsOf(filter->GetPolyDataOutput()), "");
}

TEST(VDBSurfaceFilter, TheInputIsNotModified)
{
  const auto image = BallImage(16);
  const auto sphere = Icosphere(3).ToPolyData();
  for (vtkDataSet* input : { static_cast<vtkDataSet*>(image.Get()), static_cast<vtkDataSet*>(sphere.Get()) })
  {
    vtkNew<Filter> filter;
    filter->SetInputDataObject(input);
    filter->SetVoxelSize(input->GetLength() / 40.0);
    const std::uint64_t before = HashOf(input);
    const vtkMTimeType time = input->GetMTime();
    EXPECT_TRUE(Update(filter));
    EXPECT_EQ(HashOf(input), before);
    EXPECT_EQ(input->GetMTime(), time);
  }
}

TEST(VDBSurfaceReproducibility, AnyNumberOfThreadsGivesTheSameBits)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, NoiseImage({ { 20, 14, 17 } }, 11));
  blocks->SetBlock(1, BallImage(28));
  Soup sphere = Icosphere(3);
  std::transform(sphere.Points.begin(), sphere.Points.end(), sphere.Points.begin(), [](double x) { return 9.0 * x; });
  blocks->SetBlock(2, sphere.ToPolyData());
  sphere.Polys.resize(sphere.Polys.size() * 3 / 4);
  blocks->SetBlock(3, sphere.ToPolyData());
  const std::vector<std::function<void(Filter*)>> settings = { [](Filter* f) { f->SetVoxelSize(1.3); },
    [](Filter* f) {
      f->SetVoxelSize(1.0);
      f->SetClosing(2.0);
      f->SetSmoothingToMeanCurvature();
      f->SetSmoothingIterations(1);
      f->SetAdaptivity(0.3);
      f->FillCavitiesOn();
      f->LargestComponentOn();
    } };
  for (const auto& set : settings)
  {
    std::vector<vtkSmartPointer<vtkDataArray>> expected;
    const std::vector<int> numbers = IsSanitized() ? std::vector<int>{ 3, 1 } : std::vector<int>{ 5, 2, 1 };
    for (const int threads : numbers)
    {
      // More threads than processors, which TBB has only when asked.
      const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism, threads);
      vtkSMPTools::Initialize(threads);
      vtkNew<Filter> filter;
      filter->SetInputDataObject(blocks);
      set(filter);
      EXPECT_TRUE(Update(filter));
      auto* output = vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0));
      std::vector<vtkSmartPointer<vtkDataArray>> found;
      for (unsigned int k = 0; k < 4; ++k)
      {
        auto* block = vtkPolyData::SafeDownCast(output->GetBlock(k));
        ASSERT_GT(block->GetNumberOfPolys(), 0);
        found.emplace_back(block->GetPoints()->GetData());
        found.emplace_back(block->GetPolys()->GetConnectivityArray());
      }
      expected = expected.empty() ? found : expected;
      for (std::size_t k = 0; k < found.size(); ++k)
      {
        EXPECT_TRUE(SameBits(found[k], expected[k])) << threads << " threads, array " << k;
      }
    }
  }
  vtkSMPTools::Initialize(0);
}

namespace
{
/// Seconds within which an abort must end the run; a sanitizer slows everything down.
const double AbortLimit = IsSanitized() ? 15.0 : 1.0;
} // namespace

TEST(VDBSurfaceInterruption, AbortWithinASecondAtEightMillionVoxels)
{
  vtkNew<Filter> filter;
  filter->SetInputDataObject(BallImage(IsSanitized() ? 50 : 200));
  filter->SetVoxelSize(1.0);
  ExpectAbortAndRecovery(filter, 0.3, AbortLimit);
}

TEST(VDBSurfaceInterruption, AbortWhileASurfaceBecomesALevelSet)
{
  vtkNew<Filter> filter;
  filter->SetInputDataObject(IsSanitized() ? RingSphere(40, 40) : RingSphere(200, 200));
  filter->SetVoxelSize(IsSanitized() ? 0.05 : 0.02);
  ExpectAbortAndRecovery(filter, 0.2, AbortLimit);
}

TEST(VDBSurfaceInterruption, ProgressIsMonotoneFrequentAndOnTheCallingThread)
{
  vtkNew<Filter> filter;
  filter->SetInputDataObject(BallImage(IsSanitized() ? 24 : 100));
  filter->SetSmoothingToMeanCurvature();
  filter->SetSmoothingIterations(8);
  EventRecorder events(filter);
  const double start = Now();
  ASSERT_TRUE(Update(filter));
  const double seconds = Now() - start;
  EXPECT_TRUE(std::is_sorted(events.Progress.begin(), events.Progress.end()));
  EXPECT_TRUE(seconds < 2.0 || events.Progress.size() >= 20u) << events.Progress.size() << " reports in " << seconds;
  EXPECT_GE(events.Progress.size(), 5u);
  EXPECT_EQ(events.Progress.back(), 1.0);
  EXPECT_FALSE(events.ForeignThread);
  EXPECT_LT(events.LongestSilence, AbortLimit);
}
