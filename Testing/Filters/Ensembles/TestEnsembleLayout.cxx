// SPDX-License-Identifier: BSD-3-Clause
//
// vtkEnsembleLayoutFilter: places of blocks, what else they hold, messages.
#include "FilterChecks.h"
#include "VtkSurfaces.h"

#include "vtkEnsembleLayoutFilter.h"

#include <vtkBoundingBox.h>
#include <vtkDataArray.h>
#include <vtkFieldData.h>
#include <vtkImageData.h>
#include <vtkInformation.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkTable.h>
#include <vtkUnsignedCharArray.h>

#include <gmock/gmock.h>

#include <array>
#include <limits>
#include <sstream>
#include <vector>

using namespace surfsynthtest;
using ::testing::HasSubstr;
using Layout = vtkEnsembleLayoutFilter;

namespace
{
/// A block of these sides around @p center, with points of @p type.
vtkSmartPointer<vtkPolyData> Block(double x, double y, double z, double center = 0.0, int type = VTK_FLOAT)
{
  auto block = Grid(2).ToPolyData(type);
  vtkNew<vtkPoints> points;
  points->SetDataType(type);
  for (vtkIdType k = 0; k < block->GetNumberOfPoints(); ++k)
  {
    const double s = static_cast<double>(k % 2) - 0.5;
    points->InsertNextPoint(center + s * x, center + (k < 4 ? s : -s) * y, center + s * z);
  }
  block->SetPoints(points);
  return block;
}

vtkSmartPointer<vtkMultiBlockDataSet> Blocks(const std::vector<vtkSmartPointer<vtkDataObject>>& leaves)
{
  auto blocks = vtkSmartPointer<vtkMultiBlockDataSet>::New();
  for (const auto& leaf : leaves)
  {
    blocks->SetBlock(blocks->GetNumberOfBlocks(), leaf);
  }
  return blocks;
}

vtkBoundingBox BoxOf(vtkDataObject* tree, unsigned int k)
{
  vtkBoundingBox box;
  box.SetBounds(vtkDataSet::SafeDownCast(vtkMultiBlockDataSet::SafeDownCast(tree)->GetBlock(k))->GetBounds());
  return box;
}

std::array<double, 3> CenterOf(vtkDataObject* tree, unsigned int k)
{
  std::array<double, 3> center{};
  BoxOf(tree, k).GetCenter(center.data());
  return center;
}

void ExpectCenter(vtkDataObject* tree, unsigned int k, double x, double y, double z)
{
  const auto center = CenterOf(tree, k);
  EXPECT_NEAR(center[0], x, 1e-5) << k;
  EXPECT_NEAR(center[1], y, 1e-5) << k;
  EXPECT_NEAR(center[2], z, 1e-5) << k;
}

void ExpectRefusal(Layout* filter, vtkDataObject* input, const std::string& part)
{
  EventRecorder events(filter);
  filter->SetInputDataObject(input);
  EXPECT_FALSE(Update(filter));
  ASSERT_EQ(events.Errors.size(), 1u) << events.AllErrors();
  EXPECT_THAT(events.Errors[0], HasSubstr(part));
  auto* output = vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0)); // null without input
  EXPECT_EQ(output ? output->GetNumberOfBlocks() : 0u, 0u);
}
} // namespace

TEST(EnsembleLayout, RowsFollowEachOtherDownwardsAndTheFirstBlockStays)
{
  vtkNew<Layout> filter;
  const auto input = Blocks({ Block(1, 2, 3, 5), Block(1, 2, 3), Block(1, 2, 3, -7), Block(1, 2, 3), Block(1, 2, 3) });
  const std::uint64_t before = HashOf(input);
  filter->SetInputDataObject(input);
  filter->SetNumberOfColumns(3);
  filter->SetSpacing(0.5);
  const auto output = OutputOf(filter);
  const double places[5][2] = { { 0, 0 }, { 1.5, 0 }, { 3, 0 }, { 0, -3 }, { 1.5, -3 } };
  for (unsigned int k = 0; k < 5; ++k)
  {
    ExpectCenter(output, k, 5 + places[k][0], 5 + places[k][1], 5);
  }
  EXPECT_EQ(HashOf(input), before);
}

TEST(EnsembleLayout, ColumnsAreAsWideAsTheirWidestBlockAndNoBlocksOverlap)
{
  vtkNew<Layout> filter;
  filter->SetInputDataObject(Blocks({ Block(1, 1, 1), Block(4, 2, 1), Block(2, 1, 1), Block(1, 3, 1) }));
  filter->SetArrangementToRow();
  auto output = OutputOf(filter);
  for (unsigned int k = 1; k < 4; ++k)
  {
    EXPECT_NEAR(BoxOf(output, k).GetMinPoint()[0] - BoxOf(output, k - 1).GetMaxPoint()[0], 0.4, 1e-5);
    EXPECT_NEAR(CenterOf(output, k)[1], 0.0, 1e-6);
  }
  filter->SetArrangementToColumn();
  output = OutputOf(filter);
  for (unsigned int k = 1; k < 4; ++k)
  {
    EXPECT_NEAR(BoxOf(output, k - 1).GetMinPoint()[1] - BoxOf(output, k).GetMaxPoint()[1], 0.3, 1e-5);
  }
}

TEST(EnsembleLayout, TheAutomaticNumberOfColumnsMakesAWideGrid)
{
  vtkNew<Layout> filter;
  std::vector<vtkSmartPointer<vtkDataObject>> cubes(12, Block(1, 1, 1));
  filter->SetInputDataObject(Blocks(cubes));
  auto output = OutputOf(filter);
  ExpectCenter(output, 3, 3.3, 0, 0);
  ExpectCenter(output, 4, 0, -1.1, 0); // 4 x 3
  filter->SetInputDataObject(Blocks({ cubes.begin(), cubes.begin() + 1 }));
  ExpectCenter(OutputOf(filter), 0, 0, 0, 0);
  filter->SetInputDataObject(Blocks({ Block(0, 0, 0), Block(0, 0, 0) })); // single points
  OutputOf(filter);
}

TEST(EnsembleLayout, PlanesChooseTheAxes)
{
  vtkNew<Layout> filter;
  const std::vector<vtkSmartPointer<vtkDataObject>> cubes(4, Block(1, 1, 1));
  filter->SetInputDataObject(Blocks(cubes));
  filter->SetNumberOfColumns(2);
  filter->SetSpacing(0.0);
  filter->SetPlaneToXZ();
  ExpectCenter(OutputOf(filter), 3, 1, 0, -1);
  filter->SetPlaneToYZ();
  ExpectCenter(OutputOf(filter), 3, 0, 1, -1);
}

TEST(EnsembleLayout, WithoutCenteringDifferencesOfPositionStay)
{
  vtkNew<Layout> filter;
  filter->SetInputDataObject(Blocks({ Block(1, 1, 1), Block(2, 1, 1, 0.25), Block(1, 1, 1) }));
  filter->SetArrangementToRow();
  filter->SetSpacing(0.5);
  filter->CenteringOff();
  const auto output = OutputOf(filter);
  ExpectCenter(output, 1, 3.25, 0.25, 0.25);
  ExpectCenter(output, 2, 6, 0, 0);
}

TEST(EnsembleLayout, ChildrenOfTheRootAreMovedAsOne)
{
  vtkNew<Layout> filter;
  const auto pair = [] { return Blocks({ Block(1, 1, 1), Block(1, 1, 1, 1) }); };
  filter->SetInputDataObject(Blocks({ pair(), Block(2, 2, 2, 0.5), pair() }));
  filter->SetArrangementToRow();
  filter->SetSpacing(0.0);
  filter->SetUnitToChildren();
  const auto output = OutputOf(filter);
  auto* last = vtkMultiBlockDataSet::SafeDownCast(output)->GetBlock(2);
  ExpectCenter(vtkMultiBlockDataSet::SafeDownCast(output)->GetBlock(0), 1, 1, 1, 1);
  ExpectCenter(output, 1, 2.5, 0.5, 0.5);
  ExpectCenter(last, 0, 4, 0, 0);
  ExpectCenter(last, 1, 5, 1, 1);
  filter->SetUnitToLeaves();
  ExpectCenter(vtkMultiBlockDataSet::SafeDownCast(OutputOf(filter))->GetBlock(2), 0, 4.5 - 0.5, 0, 0);
}

TEST(EnsembleLayout, BlocksKeepTheirArraysPrecisionAndNames)
{
  for (const int type : { VTK_FLOAT, VTK_DOUBLE })
  {
    auto sphere = Icosphere(1).ToPolyData(type);
    vtkNew<vtkUnsignedCharArray> marks;
    marks->SetName("Marks");
    marks->SetNumberOfTuples(sphere->GetNumberOfPoints());
    marks->FillValue(7);
    sphere->GetPointData()->AddArray(marks);
    const auto input = Blocks({ sphere, nullptr, sphere, vtkSmartPointer<vtkPolyData>::New() });
    input->GetMetaData(2u)->Set(vtkCompositeDataSet::NAME(), "Sample 2");
    vtkNew<Layout> filter;
    filter->SetInputDataObject(input);
    const vtkSmartPointer<vtkDataObject> output = OutputOf(filter);
    auto* blocks = vtkMultiBlockDataSet::SafeDownCast(output);
    ASSERT_EQ(blocks->GetNumberOfBlocks(), 4u);
    EXPECT_STREQ(blocks->GetMetaData(2u)->Get(vtkCompositeDataSet::NAME()), "Sample 2");
    EXPECT_EQ(blocks->GetBlock(1), nullptr);
    auto* moved = vtkPolyData::SafeDownCast(blocks->GetBlock(2));
    EXPECT_EQ(moved->GetPoints()->GetDataType(), type);
    EXPECT_TRUE(SameBits(moved->GetPointData()->GetArray("Marks"), marks));
    vtkDataArray* translation = moved->GetFieldData()->GetArray("Translation");
    ASSERT_NE(translation, nullptr);
    ASSERT_EQ(translation->GetNumberOfTuples(), 1);
    ASSERT_EQ(translation->GetNumberOfComponents(), 3);
    EXPECT_NEAR(translation->GetComponent(0, 0), CenterOf(output, 2)[0] - CenterOf(output, 0)[0], 1e-5);
    EXPECT_EQ(sphere->GetFieldData()->GetArray("Translation"), nullptr);
  }
}

TEST(EnsembleLayout, ImagesMoveByTheirOrigin)
{
  vtkNew<vtkImageData> image;
  image->SetDimensions(3, 3, 3);
  vtkNew<Layout> filter;
  filter->SetInputDataObject(Blocks({ image, image }));
  filter->SetSpacing(0.0);
  ExpectCenter(OutputOf(filter), 1, 3, 1, 1);
}

TEST(EnsembleLayout, EmptyInputGivesEmptyOutput)
{
  vtkNew<Layout> filter;
  filter->SetInputDataObject(vtkSmartPointer<vtkMultiBlockDataSet>::New());
  OutputOf(filter);
}

TEST(EnsembleLayout, Messages)
{
  vtkNew<Layout> filter;
  ExpectRefusal(filter, nullptr, "no input");
  vtkNew<vtkTable> table;
  vtkNew<vtkUnsignedCharArray> column;
  column->SetName("Column");
  column->SetNumberOfTuples(1);
  table->AddColumn(column);
  OutputOf([&] { // a table has no points and takes no place
    filter->SetInputDataObject(Blocks({ table }));
    return filter.Get();
  }());
  const auto broken = Block(1, 1, 1);
  broken->GetPoints()->SetPoint(1, std::numeric_limits<double>::infinity(), 0, 0);
  ExpectRefusal(filter, Blocks({ Block(1, 1, 1), broken }), "box 1 is not finite");
}

TEST(EnsembleLayout, PrintsAllProperties)
{
  vtkNew<Layout> filter;
  std::ostringstream stream;
  filter->Print(stream);
  for (const char* text :
    { "Arrangement: 0", "NumberOfColumns: 0", "Spacing: 0.1", "Plane: 0", "Unit: 0", "Centering: 1" })
  {
    EXPECT_THAT(stream.str(), HasSubstr(text));
  }
}
