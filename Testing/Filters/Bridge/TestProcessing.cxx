// SPDX-License-Identifier: BSD-3-Clause
//
// The frames around RequestData: ProcessSurfaces(), ProcessBlocks() and ProcessJointly().
#include "FilterChecks.h"
#include "FunctionFilter.h"
#include "VtkSurfaces.h"

#include "BlockBridge.h"
#include "BlockCache.h"
#include "JointProcessing.h"
#include "NewArray.h"
#include "SurfaceBridge.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Progress.h"

#include <vtkCallbackCommand.h>
#include <vtkCommand.h>
#include <vtkCompositeDataSet.h>
#include <vtkDoubleArray.h>
#include <vtkImageData.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkStructuredGrid.h>
#include <vtkUnstructuredGrid.h>
#include <vtkWeakPointer.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <new>
#include <stdexcept>

using namespace surfsynthtest;
using surfsynth::Block;
using surfsynth::BlockTypes;
using surfsynth::InvalidInput;
using surfsynth::NewArray;
using surfsynth::Progress;
using surfsynth::Report;
using surfsynth::Surface;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

namespace
{
/// The output is of the class of the input.
int SameClass(vtkAlgorithm*, vtkInformationVector** input, vtkInformationVector* output)
{
  surfsynth::SetOutputClass(output, vtkDataObject::GetData(input[0])->GetClassName());
  return 1;
}

vtkSmartPointer<FunctionFilter> SurfaceFilter(
  vtkDataObject* input, const surfsynth::SurfaceWorker& worker, const surfsynth::ValidSurface& isKnownValid = {})
{
  const auto filter = vtkSmartPointer<FunctionFilter>::New();
  filter->DataObject = SameClass;
  filter->SetInputDataObject(input);
  filter->Data = [=](vtkAlgorithm* self, vtkInformationVector** given, vtkInformationVector* output) {
    return surfsynth::ProcessSurfaces(self, given, output, surfsynth::MeshRequirements(), worker, isKnownValid);
  };
  return filter;
}

vtkSmartPointer<FunctionFilter> BlockFilter(
  vtkDataObject* input, const surfsynth::BlockWorker& worker, const BlockTypes& types)
{
  const auto filter = vtkSmartPointer<FunctionFilter>::New();
  filter->DataObject = [types](vtkAlgorithm* self, vtkInformationVector** given, vtkInformationVector* output) {
    return surfsynth::RequestBlocks(self, given, output, types);
  };
  filter->SetInputDataObject(input);
  filter->Data = [=](vtkAlgorithm* self, vtkInformationVector** given, vtkInformationVector* output) {
    return surfsynth::ProcessBlocks(self, given, output, types, worker);
  };
  return filter;
}

vtkSmartPointer<FunctionFilter> JointFilter(vtkDataObject* input, const surfsynth::JointWorker& worker)
{
  const auto filter = vtkSmartPointer<FunctionFilter>::New();
  filter->DataObject = SameClass;
  filter->SetInputDataObject(input);
  filter->Data = [=](vtkAlgorithm* self, vtkInformationVector** given, vtkInformationVector* output) {
    return surfsynth::ProcessJointly(self, given, output, worker);
  };
  return filter;
}

/// The errors of an update that fails, or with @p succeeds reports errors and goes on.
std::vector<std::string> ErrorsOf(vtkAlgorithm* filter, bool succeeds = false)
{
  EventRecorder events(filter);
  EXPECT_EQ(Update(filter), succeeds);
  return events.Errors;
}

vtkIdType PointsOf(vtkAlgorithm* filter)
{
  return filter->GetOutputDataObject(0)->GetNumberOfElements(vtkDataObject::POINT);
}

vtkSmartPointer<vtkMultiBlockDataSet> SphereAndGrid()
{
  auto blocks = vtkSmartPointer<vtkMultiBlockDataSet>::New();
  blocks->SetBlock(0, Icosphere(1).ToPolyData());
  blocks->SetBlock(1, Grid(3).ToPolyData());
  return blocks;
}

/// Work that notes whether the input of the filter lives when an observer of progress has connected another one.
class InputWatch
{
public:
  explicit InputWatch(vtkDataObject* input)
    : Input(input)
  {}
  void Work(const Progress& progress)
  {
    Report(progress, 0.5);
    ++this->Works;
    this->Alive += this->Input ? 1 : 0;
  }
  /// Returns true when the input lives until the end of each work of an update of @p filter.
  bool LivesDuring(vtkAlgorithm* filter)
  {
    const auto connect = [](vtkObject* caller, unsigned long, void*, void*) {
      auto* filter = vtkAlgorithm::SafeDownCast(caller);
      if (filter->GetProgress() > 0.0) // VTK reports 0 before the work begins
      {
        filter->SetInputDataObject(0, Grid(3).ToPolyData());
      }
    };
    vtkNew<vtkCallbackCommand> observer;
    observer->SetCallback(connect);
    filter->AddObserver(vtkCommand::ProgressEvent, observer);
    EXPECT_THAT(ErrorsOf(filter, true), IsEmpty());
    filter->RemoveObserver(observer);
    return this->Works > 0 && this->Alive == this->Works;
  }

private:
  vtkWeakPointer<vtkDataObject> Input;
  int Works = 0;
  int Alive = 0;
};

const BlockTypes Surfaces{ { "vtkPolyData" }, "vtkPolyData" };

void Copy(const Block& block, const Progress&) { block.Output->ShallowCopy(block.Input); }
} // namespace

// --- ProcessSurfaces -------------------------------------------------------------------------------------------------

TEST(ProcessSurfaces, TheWorkerFillsACopyOfTheInput)
{
  const auto sphere = Icosphere(1).ToPolyData();
  const auto filter = SurfaceFilter(sphere, [](const Surface& surface, vtkPolyData* output, const Progress&) {
    EXPECT_EQ(surface.Mesh.NumberOfPoints(), output->GetNumberOfPoints());
    EXPECT_TRUE(surface.Topology.has_value()) << "checked";
    EXPECT_EQ(surface.FlatIndex, 0u);
    EXPECT_EQ(surface.Where, "");
    output->GetPointData()->AddArray(NewArray<vtkDoubleArray>("Made", output->GetNumberOfPoints(), 1));
  });
  EXPECT_TRUE(SurfaceOf(filter)->GetPointData()->HasArray("Made"));
  EXPECT_FALSE(sphere->GetPointData()->HasArray("Made"));
}

TEST(ProcessSurfaces, BlocksAreKnownByFlatIndex)
{
  std::vector<std::string> places;
  const auto filter = SurfaceFilter(SphereAndGrid(), [&](const Surface& surface, vtkPolyData*, const Progress&) {
    places.push_back(surface.Where + "/" + std::to_string(surface.FlatIndex));
  });
  OutputOf(filter);
  EXPECT_THAT(places, ElementsAre("Block 1/1", "Block 2/2"));
}

TEST(ProcessSurfaces, WhatIsKnownToBeValidIsNotCheckedAndHashedOnce)
{
  surfsynth::BlockCache<int> cache;
  const Surface* asked = nullptr;
  bool checked = false;
  const auto filter = SurfaceFilter(
    Icosphere(1).ToPolyData(),
    [&](const Surface& surface, vtkPolyData*, const Progress&) {
      checked = surface.Topology.has_value();
      EXPECT_EQ(&surface, asked) << "one surface, whose hash is kept, goes to both";
      if (!cache.Find(surface))
      {
        cache.Insert(surface, 1);
      }
    },
    [&](const Surface& surface) {
      asked = &surface;
      return cache.Find(surface) != nullptr;
    });
  OutputOf(filter);
  EXPECT_TRUE(checked);
  filter->Modified();
  OutputOf(filter);
  EXPECT_FALSE(checked);
}

TEST(ProcessSurfaces, EmptyInputIsNoErrorAndNoWork)
{
  bool worked = false;
  vtkNew<vtkPolyData> empty;
  const auto filter = SurfaceFilter(empty, [&](const Surface&, vtkPolyData*, const Progress&) { worked = true; });
  EXPECT_EQ(SurfaceOf(filter)->GetNumberOfPoints(), 0);
  EXPECT_FALSE(worked);
}

TEST(ProcessSurfaces, ExceptionsBecomeOneErrorAndAnEmptyOutput)
{
  const auto sphere = Icosphere(1).ToPolyData();
  const auto failing = [&](const std::function<void()>& fail) {
    const auto filter = SurfaceFilter(sphere, [fail](const Surface&, vtkPolyData*, const Progress&) { fail(); });
    const auto errors = ErrorsOf(filter);
    EXPECT_THAT(errors, SizeIs(1));
    EXPECT_EQ(PointsOf(filter), 0);
    return errors.empty() ? std::string() : errors[0];
  };
  EXPECT_THAT(failing([] { throw InvalidInput("what was found"); }), HasSubstr("what was found"));
  EXPECT_THAT(failing([] { throw std::runtime_error("of a library"); }), HasSubstr("of a library"));
  EXPECT_THAT(failing([] { throw std::bad_alloc(); }),
    HasSubstr("There is not enough memory for a dataset of 42 points and 80 cells."));
  EXPECT_THAT(failing([] { throw 7; }), HasSubstr("An error of unknown type"));
}

TEST(ProcessSurfaces, ABadBlockDoesNotHarmTheOthers)
{
  const auto blocks = SphereAndGrid();
  vtkNew<vtkStructuredGrid> other;
  blocks->SetBlock(2, other);
  int worked = 0;
  const auto filter = SurfaceFilter(blocks, [&](const Surface& surface, vtkPolyData*, const Progress&) {
    ++worked;
    if (surface.FlatIndex == 1)
    {
      throw InvalidInput("the first is bad");
    }
  });
  const auto errors = ErrorsOf(filter, true);
  ASSERT_THAT(errors, SizeIs(2));
  EXPECT_THAT(errors[0], HasSubstr("Block 1: the first is bad"));
  EXPECT_THAT(errors[1], AllOf(HasSubstr("Block 3: A vtkStructuredGrid"), HasSubstr("vtkDataSetSurfaceFilter")));
  EXPECT_EQ(worked, 2);
  auto* output = vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0));
  EXPECT_EQ(vtkPolyData::SafeDownCast(output->GetBlock(0))->GetNumberOfPoints(), 0);
  EXPECT_EQ(vtkPolyData::SafeDownCast(output->GetBlock(1))->GetNumberOfPoints(), 16);
  EXPECT_EQ(output->GetBlock(2), nullptr);
}

TEST(ProcessSurfaces, AnotherTypeOfInputIsAnError)
{
  vtkNew<vtkStructuredGrid> grid;
  const auto filter = SurfaceFilter(grid, [](const Surface&, vtkPolyData*, const Progress&) {});
  EXPECT_THAT(ErrorsOf(filter), ElementsAre(AllOf(HasSubstr("a vtkStructuredGrid"), HasSubstr("vtkPolyData"))));
}

TEST(ProcessSurfaces, ProgressRisesOverBlocksAndAnAbortIsNoError)
{
  const auto filter = SurfaceFilter(SphereAndGrid(), [](const Surface&, vtkPolyData*, const Progress& progress) {
    Report(progress, 0.5);
    Report(progress, 0.25); // never backwards
    Report(progress, 1.0);
  });
  {
    EventRecorder events(filter);
    EXPECT_TRUE(Update(filter));
    EXPECT_TRUE(std::is_sorted(events.Progress.begin(), events.Progress.end()));
    EXPECT_GE(events.Progress.size(), 6u);
    EXPECT_EQ(events.Progress.back(), 1.0);
  }
  filter->Modified();
  {
    EventRecorder events(filter);
    events.AbortAt = 0.3;
    EXPECT_TRUE(Update(filter)) << "an abort is no failure";
    EXPECT_THAT(events.Errors, IsEmpty());
    EXPECT_EQ(PointsOf(filter), 0);
  }
  OutputOf(filter);
  EXPECT_EQ(PointsOf(filter), 58) << "the next update runs again";
}

TEST(ProcessSurfaces, AnInputLivesThoughAnObserverConnectsAnother)
{
  for (const bool composite : { false, true })
  {
    vtkSmartPointer<vtkDataObject> input = Icosphere(1).ToPolyData();
    if (composite)
    {
      input = SphereAndGrid();
    }
    InputWatch watch(input);
    const auto filter = SurfaceFilter(
      input, [&](const Surface&, vtkPolyData*, const Progress& progress) { watch.Work(progress); });
    input = nullptr; // the pipeline alone refers to it
    EXPECT_TRUE(watch.LivesDuring(filter)) << composite;
  }
}

TEST(ProcessSurfaces, MessagesNameABlock)
{
  const auto blocks = SphereAndGrid();
  blocks->GetMetaData(1u)->Set(vtkCompositeDataSet::NAME(), "left hand");
  const auto filter = SurfaceFilter(
    blocks, [](const Surface&, vtkPolyData*, const Progress&) { throw InvalidInput("it is bad"); });
  EXPECT_THAT(ErrorsOf(filter, true),
    ElementsAre(HasSubstr("Block 1: it is bad"), HasSubstr("Block 2 \"left hand\": it is bad")));
}

TEST(ProcessSurfaces, AcceptsSurfacesAndTrees)
{
  vtkNew<vtkInformation> info;
  EXPECT_EQ(surfsynth::AcceptSurfaces(info), 1);
  ASSERT_EQ(info->Length(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE()), 3);
  EXPECT_STREQ(info->Get(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), 0), "vtkPolyData");
  EXPECT_STREQ(info->Get(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), 1), "vtkUnstructuredGrid");
  EXPECT_STREQ(info->Get(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), 2), "vtkDataObjectTree");
}

// --- ProcessBlocks ---------------------------------------------------------------------------------------------------

TEST(ProcessBlocks, MakesADatasetOfTheOutputTypeOfEachBlock)
{
  const BlockTypes types{ { "vtkPolyData", "vtkImageData" }, "vtkUnstructuredGrid" };
  std::vector<std::string> places;
  const auto note = [&](const Block& block, const Progress&) {
    places.push_back(block.Where + "/" + std::to_string(block.FlatIndex));
    EXPECT_TRUE(vtkUnstructuredGrid::SafeDownCast(block.Output));
    EXPECT_THAT(block.Outputs, ElementsAre(block.Output));
  };
  const auto blocks = SphereAndGrid();
  const auto filter = BlockFilter(blocks, note, types);
  auto* output = vtkMultiBlockDataSet::SafeDownCast(OutputOf(filter));
  ASSERT_TRUE(output);
  EXPECT_TRUE(vtkUnstructuredGrid::SafeDownCast(output->GetBlock(1)));
  EXPECT_THAT(places, ElementsAre("Block 1/1", "Block 2/2"));
  filter->SetInputDataObject(Icosphere(1).ToPolyData());
  EXPECT_TRUE(vtkUnstructuredGrid::SafeDownCast(OutputOf(filter))) << "the class follows the input";
  EXPECT_EQ(places.back(), "/0");
}

TEST(ProcessBlocks, AnotherTypeOfDatasetIsAnErrorWithAdvice)
{
  BlockTypes types{ { "vtkPolyData", "vtkImageData" }, "vtkPolyData" };
  types.Advice = "a filter makes one of it";
  vtkNew<vtkStructuredGrid> other;
  const auto filter = BlockFilter(other, Copy, types);
  EXPECT_THAT(ErrorsOf(filter),
    ElementsAre(HasSubstr("A vtkStructuredGrid was found where a vtkPolyData or a vtkImageData is needed; a filter "
                          "makes one of it.")));
  const auto blocks = SphereAndGrid();
  blocks->SetBlock(2, other);
  filter->SetInputDataObject(blocks);
  EXPECT_THAT(ErrorsOf(filter, true), ElementsAre(HasSubstr("Block 3: A vtkStructuredGrid")));
  EXPECT_EQ(PointsOf(filter), 58);
}

TEST(ProcessBlocks, ErrorsNameTheBlockAndEmptyIt)
{
  const auto fail = [](const Block& block, const Progress&) {
    block.Output->ShallowCopy(block.Input);
    throw InvalidInput("it is bad");
  };
  const auto filter = BlockFilter(SphereAndGrid(), fail, Surfaces);
  EXPECT_THAT(ErrorsOf(filter, true), ElementsAre(HasSubstr("Block 1: it is bad"), HasSubstr("Block 2: it is bad")));
  EXPECT_EQ(PointsOf(filter), 0);
  filter->SetInputDataObject(Icosphere(1).ToPolyData());
  EXPECT_THAT(ErrorsOf(filter), ElementsAre(HasSubstr("it is bad")));
  EXPECT_EQ(PointsOf(filter), 0);
}

TEST(ProcessBlocks, NoInputIsAnErrorAndEmptyInputIsNone)
{
  const BlockTypes types{ { "vtkPolyData", "vtkImageData" }, "vtkPolyData" };
  vtkNew<vtkPolyData> empty;
  bool worked = false;
  const auto filter = BlockFilter(
    empty, [&](const Block&, const Progress&) { worked = true; }, types);
  OutputOf(filter);
  EXPECT_FALSE(worked);
  vtkNew<vtkInformationVector> none;
  vtkNew<vtkInformation> info;
  none->Append(info);
  vtkInformationVector* given[] = { none };
  EventRecorder events(filter);
  EXPECT_EQ(surfsynth::RequestBlocks(filter, given, none, types), 0);
  EXPECT_THAT(events.AllErrors(),
    HasSubstr("There is no input; a vtkPolyData or a vtkImageData, or a composite dataset, is needed."));
}

TEST(ProcessBlocks, TheOutputOfASeriesIsAMultiBlock)
{
  const auto sphere = Icosphere(1).ToPolyData();
  vtkNew<vtkInformationVector> input;
  vtkNew<vtkInformation> inputInfo;
  inputInfo->Set(vtkDataObject::DATA_OBJECT(), sphere);
  input->Append(inputInfo);
  vtkNew<vtkInformationVector> output;
  vtkNew<vtkInformation> outputInfo;
  output->Append(outputInfo);
  vtkInformationVector* given[] = { input };
  vtkNew<FunctionFilter> filter;
  EXPECT_EQ(surfsynth::RequestBlocks(filter, given, output, Surfaces, true), 1);
  EXPECT_TRUE(vtkMultiBlockDataSet::SafeDownCast(vtkDataObject::GetData(output)));
  EXPECT_EQ(surfsynth::RequestBlocks(filter, given, output, Surfaces), 1);
  EXPECT_TRUE(vtkPolyData::SafeDownCast(vtkDataObject::GetData(output)));
}

TEST(ProcessBlocks, AnInputLivesThoughAnObserverConnectsAnother)
{
  auto input = Icosphere(1).ToPolyData();
  InputWatch watch(input);
  const auto filter = BlockFilter(
    input, [&](const Block&, const Progress& progress) { watch.Work(progress); }, Surfaces);
  input = nullptr;
  EXPECT_TRUE(watch.LivesDuring(filter));
}

TEST(ProcessBlocks, MessagesNameABlock)
{
  const auto blocks = SphereAndGrid();
  blocks->GetMetaData(0u)->Set(vtkCompositeDataSet::NAME(), "left hand");
  vtkNew<vtkStructuredGrid> other;
  blocks->SetBlock(1, other);
  blocks->GetMetaData(1u)->Set(vtkCompositeDataSet::NAME(), "head");
  const auto filter = BlockFilter(
    blocks, [](const Block&, const Progress&) { throw InvalidInput("it is bad"); }, Surfaces);
  EXPECT_THAT(ErrorsOf(filter, true),
    ElementsAre(
      HasSubstr("Block 1 \"left hand\": it is bad"), HasSubstr("Block 2 \"head\": A vtkStructuredGrid was found")));
}

TEST(ProcessBlocks, AcceptsItsTypesAndTrees)
{
  vtkNew<vtkInformation> info;
  EXPECT_EQ(surfsynth::AcceptBlocks(info, { { "vtkImageData" }, "vtkPolyData" }), 1);
  ASSERT_EQ(info->Length(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE()), 2);
  EXPECT_STREQ(info->Get(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), 0), "vtkImageData");
  EXPECT_STREQ(info->Get(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), 1), "vtkDataObjectTree");
}

// --- ProcessJointly --------------------------------------------------------------------------------------------------

TEST(ProcessJointly, TheWorkerIsCalledOnceForAllBlocks)
{
  int calls = 0;
  vtkDataObject* output = nullptr;
  const auto blocks = SphereAndGrid();
  const auto filter = JointFilter(blocks, [&](const Progress& progress) {
    ++calls;
    EXPECT_EQ(output->GetNumberOfElements(vtkDataObject::POINT), 0) << "outputs are empty";
    Report(progress, 1.0);
    output->ShallowCopy(blocks);
  });
  filter->UpdateInformation();
  output = filter->GetOutputDataObject(0);
  ASSERT_TRUE(output);
  OutputOf(filter);
  EXPECT_EQ(calls, 1);
  EXPECT_EQ(PointsOf(filter), 58);
}

TEST(ProcessJointly, AnErrorEmptiesTheOutputs)
{
  const auto sphere = Icosphere(1).ToPolyData();
  vtkDataObject* output = nullptr;
  const auto filter = JointFilter(sphere, [&](const Progress&) {
    output->ShallowCopy(sphere);
    throw InvalidInput("they do not fit");
  });
  filter->UpdateInformation();
  output = filter->GetOutputDataObject(0);
  EXPECT_THAT(ErrorsOf(filter), ElementsAre(HasSubstr("they do not fit")));
  EXPECT_EQ(PointsOf(filter), 0);
}

TEST(ProcessJointly, AnInputLivesThoughAnObserverConnectsAnother)
{
  auto input = Icosphere(1).ToPolyData();
  InputWatch watch(input);
  const auto filter = JointFilter(input, [&](const Progress& progress) { watch.Work(progress); });
  input = nullptr;
  EXPECT_TRUE(watch.LivesDuring(filter));
}

TEST(ProcessJointly, EmptyInputsAreWorkedOn)
{
  vtkNew<vtkPolyData> empty;
  int calls = 0;
  const auto filter = JointFilter(empty, [&](const Progress&) { ++calls; });
  OutputOf(filter);
  EXPECT_EQ(calls, 1) << "the worker says what an empty input is";
}

TEST(ProcessJointly, AnAbortIsNoErrorAndTheNextUpdateRunsAgain)
{
  const auto sphere = Icosphere(1).ToPolyData();
  vtkDataObject* output = nullptr;
  int finished = 0;
  const auto filter = JointFilter(sphere, [&](const Progress& progress) {
    output->ShallowCopy(sphere);
    Report(progress, 0.5);
    ++finished;
  });
  filter->UpdateInformation();
  output = filter->GetOutputDataObject(0);
  {
    EventRecorder events(filter);
    events.AbortAt = 0.5;
    EXPECT_TRUE(Update(filter));
    EXPECT_THAT(events.Errors, IsEmpty());
  }
  EXPECT_EQ(PointsOf(filter), 0);
  EXPECT_EQ(finished, 0);
  OutputOf(filter);
  EXPECT_EQ(finished, 1);
  EXPECT_EQ(PointsOf(filter), 42);
}
