// SPDX-License-Identifier: BSD-3-Clause
//
// Several outputs of each dataset: names, structure, and who fills what.
#include "FilterChecks.h"
#include "FunctionFilter.h"
#include "ThrownText.h"
#include "VtkSurfaces.h"

#include "BlockBridge.h"
#include "NewArray.h"
#include "OutputSeries.h"
#include "SurfaceBridge.h"

#include "Core/Common/Errors.h"

#include <vtkCellData.h>
#include <vtkCompositeDataSet.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkIdTypeArray.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkUnstructuredGrid.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

using namespace surfsynthtest;
using surfsynth::Block;
using surfsynth::BlockTypes;
using surfsynth::InvalidInput;
using surfsynth::MakeOutputs;
using surfsynth::NewArray;
using surfsynth::OutputSeries;
using surfsynth::Progress;
using surfsynth::Surface;
using surfsynth::SurfaceSeries;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

namespace
{
/// The one value of the point array "Number" of a surface; -1 when there is none.
double NumberOf(vtkDataObject* surface)
{
  auto* polyData = vtkPolyData::SafeDownCast(surface);
  vtkDataArray* array = polyData ? polyData->GetPointData()->GetArray("Number") : nullptr;
  return array && array->GetNumberOfTuples() > 0 ? array->GetTuple1(array->GetNumberOfTuples() - 1) : -1.0;
}

vtkMultiBlockDataSet* BlocksOf(vtkDataObject* data) { return vtkMultiBlockDataSet::SafeDownCast(data); }

std::string NameOfBlock(vtkDataObject* data, unsigned int k)
{
  return BlocksOf(data)->GetMetaData(k)->Get(vtkCompositeDataSet::NAME());
}

vtkSmartPointer<FunctionFilter> FilterOn(vtkDataObject* input)
{
  const auto filter = vtkSmartPointer<FunctionFilter>::New();
  filter->DataObject = [](vtkAlgorithm*, vtkInformationVector**, vtkInformationVector* output) {
    surfsynth::SetOutputClass(output, "vtkMultiBlockDataSet");
    return 1;
  };
  filter->SetInputDataObject(input);
  return filter;
}

/// Adds to output k the array "Number" with 10 (First + k) + the part's index, if it is of the part.
SurfaceSeries Numbered(int first, int count)
{
  SurfaceSeries series;
  series.Outputs = { first, count, "Sample" };
  series.Worker = [first](const Surface& surface, const std::vector<vtkPolyData*>& outputs, const Progress&) {
    for (std::size_t k = 0; k < outputs.size(); ++k)
    {
      if (static_cast<int>(k) % surface.Part.Count == surface.Part.Index)
      {
        const auto array = NewArray<vtkDoubleArray>("Number", outputs[k]->GetNumberOfPoints(), 1);
        array->FillValue(10.0 * (first + static_cast<double>(k)) + surface.FlatIndex);
        outputs[k]->GetPointData()->AddArray(array);
      }
    }
  };
  return series;
}

/// A filter that makes the series of the surfaces of @p input, which must outlive it.
vtkSmartPointer<FunctionFilter> SurfaceFilterOn(vtkDataObject* input, const SurfaceSeries& series)
{
  const auto filter = FilterOn(input);
  filter->Data = [&series](vtkAlgorithm* self, vtkInformationVector** given, vtkInformationVector* output) {
    return surfsynth::ProcessSurfaces(self, given, output, surfsynth::MeshRequirements(), series);
  };
  return filter;
}

vtkSmartPointer<vtkMultiBlockDataSet> TwoBlocksAndAHole()
{
  auto blocks = vtkSmartPointer<vtkMultiBlockDataSet>::New();
  blocks->SetBlock(0, Icosphere(1).ToPolyData());
  blocks->SetBlock(2, Grid(3).ToPolyData());
  blocks->GetMetaData(2u)->Set(vtkCompositeDataSet::NAME(), "Grid");
  blocks->GetFieldData()->AddArray(NewArray<vtkDoubleArray>("Time", 1, 1));
  return blocks;
}
} // namespace

// --- MakeOutputs -----------------------------------------------------------------------------------------------------

TEST(OutputSeries, BlocksAreNamedByNumber)
{
  EXPECT_EQ((OutputSeries{ 3, 5, "Sample" }.NameOf(2)), "Sample 5");
  EXPECT_EQ((OutputSeries{ 2147483647, 2, "Level" }.NameOf(1)), "Level 2147483648");
}

TEST(OutputSeries, WithoutABlockNameTheOutputIsTheDataset)
{
  const auto sphere = Icosphere(1).ToPolyData();
  vtkNew<vtkPolyData> output;
  const auto outputs = MakeOutputs(sphere, {}, "vtkPolyData", output);
  ASSERT_EQ(outputs.size(), 1u);
  EXPECT_EQ(outputs[0].Get(), output.Get());
  vtkNew<vtkMultiBlockDataSet> tree;
  EXPECT_EQ(MakeOutputs(TwoBlocksAndAHole(), {}, "vtkPolyData", tree).front().Get(), tree.Get());
  EXPECT_EQ(tree->GetNumberOfBlocks(), 3u);
  EXPECT_TRUE(tree->GetFieldData()->HasArray("Time"));
}

TEST(OutputSeries, WithABlockNameEachOutputIsABlock)
{
  const auto sphere = Icosphere(1).ToPolyData();
  vtkNew<vtkMultiBlockDataSet> output;
  const auto outputs = MakeOutputs(sphere, { 4, 2, "Level" }, "vtkUnstructuredGrid", output);
  ASSERT_EQ(outputs.size(), 2u);
  ASSERT_EQ(output->GetNumberOfBlocks(), 2u);
  for (const unsigned int k : { 0u, 1u })
  {
    EXPECT_EQ(output->GetBlock(k), outputs[k].Get());
    EXPECT_TRUE(vtkUnstructuredGrid::SafeDownCast(outputs[k]));
  }
  EXPECT_EQ(NameOfBlock(output, 0), "Level 4");
  EXPECT_EQ(NameOfBlock(output, 1), "Level 5");
  EXPECT_EQ(MakeOutputs(sphere, { 0, 1, "Level" }, "vtkPolyData", output).size(), 1u);
  EXPECT_EQ(output->GetNumberOfBlocks(), 1u) << "one is a block, too";
}

TEST(OutputSeries, EachOutputHasTheStructureOfACompositeInput)
{
  vtkNew<vtkMultiBlockDataSet> output;
  for (const auto& part : MakeOutputs(TwoBlocksAndAHole(), { 0, 2, "Sample" }, "vtkPolyData", output))
  {
    auto* tree = BlocksOf(part);
    ASSERT_TRUE(tree);
    EXPECT_EQ(tree->GetNumberOfBlocks(), 3u);
    EXPECT_EQ(NameOfBlock(tree, 2), "Grid");
    EXPECT_TRUE(tree->GetFieldData()->HasArray("Time"));
  }
}

TEST(OutputSeries, AWrongSeriesOrOutputIsAnError)
{
  const auto sphere = Icosphere(1).ToPolyData();
  vtkNew<vtkMultiBlockDataSet> blocks;
  vtkNew<vtkPolyData> single;
  EXPECT_THAT(TextOf<InvalidInput>([&] {
    MakeOutputs(sphere, { 0, 0, "Sample" }, "vtkPolyData", blocks);
  }),
    AllOf(HasSubstr("0 outputs"), HasSubstr("at least one")));
  EXPECT_THAT(TextOf<InvalidInput>([&] {
    MakeOutputs(sphere, { 0, 2, "" }, "vtkPolyData", blocks);
  }),
    AllOf(HasSubstr("2 outputs"), HasSubstr("a name for several")));
  EXPECT_THAT(TextOf<InvalidInput>([&] {
    MakeOutputs(sphere, { 0, 2, "Sample" }, "vtkPolyData", single);
  }),
    AllOf(HasSubstr("vtkPolyData"), HasSubstr("vtkMultiBlockDataSet is needed")));
}

TEST(OutputSeries, TheClassOfTheOutputIsSetOnce)
{
  vtkNew<vtkInformationVector> outputs;
  vtkNew<vtkInformation> info;
  outputs->Append(info);
  surfsynth::SetOutputClass(outputs, "vtkPolyData");
  const vtkSmartPointer<vtkDataObject> first = vtkDataObject::GetData(outputs);
  EXPECT_TRUE(vtkPolyData::SafeDownCast(first));
  surfsynth::SetOutputClass(outputs, "vtkPolyData");
  EXPECT_EQ(vtkDataObject::GetData(outputs), first.Get());
  surfsynth::SetOutputClass(outputs, "vtkMultiBlockDataSet");
  EXPECT_TRUE(BlocksOf(vtkDataObject::GetData(outputs)));
}

// --- ProcessSurfaces with a series -----------------------------------------------------------------------------------

TEST(SurfaceSeries, EachOutputIsACopyOfTheInputWithWhatTheWorkerAdds)
{
  const auto sphere = Icosphere(1).ToPolyData();
  sphere->GetPointData()->AddArray(NewArray<vtkDoubleArray>("Own", 42, 1));
  const SurfaceSeries series = Numbered(5, 3);
  const auto filter = SurfaceFilterOn(sphere, series);
  auto* output = BlocksOf(OutputOf(filter));
  ASSERT_EQ(output->GetNumberOfBlocks(), 3u);
  for (const unsigned int k : { 0u, 1u, 2u })
  {
    auto* made = vtkPolyData::SafeDownCast(output->GetBlock(k));
    EXPECT_EQ(NameOfBlock(output, k), "Sample " + std::to_string(5 + k));
    EXPECT_EQ(NumberOf(made), 10.0 * (5 + k));
    EXPECT_TRUE(made->GetPointData()->HasArray("Own"));
    EXPECT_EQ(made->GetPoints(), sphere->GetPoints()) << "shared";
  }
  EXPECT_FALSE(sphere->GetPointData()->HasArray("Number")) << "the input is as it was";
}

TEST(SurfaceSeries, BlocksOfACompositeInputAreLeavesOfEachOutput)
{
  const auto input = TwoBlocksAndAHole();
  const SurfaceSeries series = Numbered(1, 2);
  const auto filter = SurfaceFilterOn(input, series);
  auto* output = BlocksOf(OutputOf(filter));
  ASSERT_EQ(output->GetNumberOfBlocks(), 2u);
  for (const unsigned int k : { 0u, 1u })
  {
    auto* tree = BlocksOf(output->GetBlock(k));
    EXPECT_EQ(NumberOf(tree->GetBlock(0)), 10.0 * (1 + k) + 1) << "flat index 1";
    EXPECT_EQ(tree->GetBlock(1), nullptr);
    EXPECT_EQ(NumberOf(tree->GetBlock(2)), 10.0 * (1 + k) + 3);
  }
}

TEST(SurfaceSeries, AFailedBlockIsEmptyInAllOutputs)
{
  Soup broken = Icosphere(1);
  broken.Polys[3] = { 0, 0, 1 };
  const auto input = TwoBlocksAndAHole();
  input->SetBlock(1, broken.ToPolyData());
  const SurfaceSeries series = Numbered(0, 2);
  const auto filter = SurfaceFilterOn(input, series);
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  ASSERT_THAT(events.Errors, ::testing::SizeIs(1));
  EXPECT_THAT(events.AllErrors(), HasSubstr("Block 2"));
  for (const unsigned int k : { 0u, 1u })
  {
    auto* tree = BlocksOf(BlocksOf(filter->GetOutputDataObject(0))->GetBlock(k));
    EXPECT_EQ(vtkPolyData::SafeDownCast(tree->GetBlock(1))->GetNumberOfPoints(), 0);
    EXPECT_EQ(NumberOf(tree->GetBlock(2)), 10.0 * k + 3);
  }
}

TEST(SurfaceSeries, FinishComesAfterTheWorkAndNotForEmptySurfaces)
{
  SurfaceSeries series = Numbered(0, 2);
  std::vector<double> finished;
  series.Finish = [&finished](vtkPolyData* output) {
    finished.push_back(NumberOf(output));
    output->GetCellData()->AddArray(NewArray<vtkDoubleArray>("OnCells", output->GetNumberOfCells(), 1));
  };
  const auto input = TwoBlocksAndAHole();
  input->SetBlock(1, vtkSmartPointer<vtkPolyData>::New());
  const auto filter = SurfaceFilterOn(input, series);
  auto* output = BlocksOf(OutputOf(filter));
  EXPECT_THAT(finished, ElementsAre(1.0, 11.0, 3.0, 13.0));
  auto* first = vtkPolyData::SafeDownCast(BlocksOf(output->GetBlock(0))->GetBlock(0));
  EXPECT_TRUE(first->GetCellData()->HasArray("OnCells"));
}

TEST(SurfaceSeries, AnErrorOfTheFinisherIsThatOfTheBlock)
{
  SurfaceSeries series = Numbered(0, 2);
  series.Finish = [](vtkPolyData*) { throw InvalidInput("not to be finished"); };
  const auto sphere = Icosphere(1).ToPolyData();
  const auto filter = SurfaceFilterOn(sphere, series);
  EventRecorder events(filter);
  EXPECT_FALSE(Update(filter));
  EXPECT_THAT(events.AllErrors(), HasSubstr("not to be finished"));
  EXPECT_EQ(filter->GetOutputDataObject(0)->GetNumberOfElements(vtkDataObject::POINT), 0);
}

/// Pieces of a distributed surface that one process has read: they are put together, worked on as one and taken apart.
TEST(SurfaceSeries, PiecesOfOneSurfaceGetTheirPartOfEachOutput)
{
  Soup pieces;
  for (const double x : { 0.0, 1.0, 1.0, 2.0 }) // two squares side by side, the middle edge twice
  {
    pieces.AddPoint(x, 0.0, 0.0);
    pieces.AddPoint(x, 1.0, 0.0);
  }
  pieces.Polys = { { 0, 2, 3, 1 }, { 4, 6, 7, 5 } };
  const auto input = pieces.ToPolyData();
  const auto ids = NewArray<vtkIdTypeArray>("Ids", 8, 1);
  for (vtkIdType k = 0; k < 8; ++k)
  {
    ids->SetValue(k, k < 4 ? k : k - 2);
  }
  input->GetPointData()->SetGlobalIds(ids);
  SurfaceSeries series;
  series.Outputs = { 0, 2, "Sample" };
  vtkIdType pointsOfWhole = 0;
  series.Worker = [&](const Surface& surface, const std::vector<vtkPolyData*>& outputs, const Progress&) {
    pointsOfWhole = surface.Mesh.NumberOfPoints();
    for (std::size_t k = 0; k < outputs.size(); ++k)
    {
      const auto array = NewArray<vtkDoubleArray>("Id", pointsOfWhole, 1);
      for (vtkIdType p = 0; p < pointsOfWhole; ++p)
      {
        array->SetValue(p, 100.0 * static_cast<double>(k) + static_cast<double>(p));
      }
      outputs[k]->GetPointData()->AddArray(array);
    }
  };
  series.Finish = [](vtkPolyData* output) { output->GetPointData()->SetActiveScalars("Id"); };
  const auto filter = SurfaceFilterOn(input, series);
  auto* output = BlocksOf(OutputOf(filter));
  EXPECT_EQ(pointsOfWhole, 6) << "each point once";
  for (const unsigned int k : { 0u, 1u })
  {
    auto* made = vtkPolyData::SafeDownCast(output->GetBlock(k));
    ASSERT_EQ(made->GetNumberOfPoints(), 8);
    vtkDataArray* found = made->GetPointData()->GetScalars();
    ASSERT_TRUE(found);
    for (vtkIdType p = 0; p < 8; ++p)
    {
      EXPECT_EQ(found->GetTuple1(p), 100.0 * k + static_cast<double>(ids->GetValue(p))) << p;
    }
  }
}

// --- ProcessBlocks with a series -------------------------------------------------------------------------------------

TEST(BlockSeries, TheWorkerGetsAllOutputsOfABlock)
{
  const BlockTypes types{ { "vtkPolyData" }, "vtkPolyData" };
  const auto copy = [](const Block& block, const Progress&) {
    EXPECT_EQ(block.Outputs.size(), 3u);
    EXPECT_EQ(block.Output, block.Outputs.front());
    for (std::size_t k = 1; k < block.Outputs.size(); ++k) // the first stays empty
    {
      block.Outputs[k]->ShallowCopy(block.Input);
    }
  };
  const auto input = TwoBlocksAndAHole();
  const auto filter = FilterOn(input);
  filter->Data = [&](vtkAlgorithm* self, vtkInformationVector** given, vtkInformationVector* output) {
    return surfsynth::ProcessBlocks(self, given, output, types, copy, { 2, 3, "Level" });
  };
  auto* output = BlocksOf(OutputOf(filter));
  ASSERT_EQ(output->GetNumberOfBlocks(), 3u);
  for (const unsigned int k : { 0u, 1u, 2u })
  {
    EXPECT_EQ(NameOfBlock(output, k), "Level " + std::to_string(2 + k));
    auto* tree = BlocksOf(output->GetBlock(k));
    EXPECT_EQ(vtkPolyData::SafeDownCast(tree->GetBlock(0))->GetNumberOfPoints(), k == 0 ? 0 : 42);
    EXPECT_EQ(tree->GetBlock(1), nullptr);
  }
}

TEST(BlockSeries, AFailedDatasetLeavesNoBlock)
{
  const BlockTypes types{ { "vtkPolyData" }, "vtkPolyData" };
  const auto fail = [](const Block& block, const Progress&) {
    block.Outputs[0]->ShallowCopy(block.Input);
    throw InvalidInput("no such thing");
  };
  const auto sphere = Icosphere(1).ToPolyData();
  const auto filter = FilterOn(sphere);
  filter->Data = [&](vtkAlgorithm* self, vtkInformationVector** given, vtkInformationVector* output) {
    return surfsynth::ProcessBlocks(self, given, output, types, fail, { 0, 2, "Level" });
  };
  EventRecorder events(filter);
  EXPECT_FALSE(Update(filter));
  EXPECT_THAT(events.AllErrors(), HasSubstr("no such thing"));
  EXPECT_EQ(filter->GetOutputDataObject(0)->GetNumberOfElements(vtkDataObject::POINT), 0);
}
