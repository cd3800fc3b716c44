// SPDX-License-Identifier: BSD-3-Clause
#include "FilterChecks.h"
#include "FilterContract.h"

#include "vtkLabelSurfaceFilter.h"

#include <vtkCellData.h>
#include <vtkCompositeDataSet.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkImageData.h>
#include <vtkInformation.h>
#include <vtkIntArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkStringArray.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <set>
#include <sstream>
#include <tuple>

using namespace surfsynthtest;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

namespace
{
/// Two boxes that touch, labels 4 and 9, in voxels of 1 x 2 x 0.5, mirrored in x.
vtkSmartPointer<vtkImageData> TwoBoxes(bool onCells = false)
{
  auto image = vtkSmartPointer<vtkImageData>::New();
  const int more = onCells ? 1 : 0;
  image->SetDimensions(16 + more, 10 + more, 12 + more);
  image->SetSpacing(1.0, 2.0, 0.5);
  image->SetOrigin(100.0, -20.0, 3.0);
  image->SetDirectionMatrix(-1, 0, 0, 0, 1, 0, 0, 0, 1);
  vtkNew<vtkIntArray> labels;
  labels->SetName("Labels");
  for (int z = 0; z < 12; ++z)
  {
    for (int y = 0; y < 10; ++y)
    {
      for (int x = 0; x < 16; ++x)
      {
        const bool inside = x > 1 && x < 13 && y > 1 && y < 8 && z > 2 && z < 10;
        labels->InsertNextValue(!inside ? 0 : x < 7 ? 4 : 9);
      }
    }
  }
  onCells ? image->GetCellData()->SetScalars(labels) : image->GetPointData()->SetScalars(labels);
  return image;
}

vtkSmartPointer<vtkLabelSurfaceFilter> Filter(vtkImageData* image)
{
  auto filter = vtkSmartPointer<vtkLabelSurfaceFilter>::New();
  filter->SetInputDataObject(image);
  return filter;
}

vtkMultiBlockDataSet* Made(vtkLabelSurfaceFilter* filter)
{
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter)) << events.AllErrors();
  EXPECT_THAT(events.Errors, IsEmpty());
  return filter->GetOutput();
}

vtkPolyData* BlockOf(vtkMultiBlockDataSet* blocks, unsigned int block)
{
  return vtkPolyData::SafeDownCast(blocks->GetBlock(block));
}

std::string NameOf(vtkMultiBlockDataSet* blocks, unsigned int block)
{
  return blocks->GetMetaData(block)->Get(vtkCompositeDataSet::NAME());
}

/// Signed volume: positive for a surface that is wound outwards.
double SignedVolume(vtkPolyData* surface)
{
  double volume = 0.0;
  for (vtkIdType c = 0; c < surface->GetNumberOfCells(); ++c)
  {
    vtkNew<vtkIdList> ids;
    surface->GetCellPoints(c, ids);
    double p[3][3];
    for (int k = 0; k < 3; ++k)
    {
      surface->GetPoint(ids->GetId(k), p[k]);
    }
    volume += (p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) - p[0][1] * (p[1][0] * p[2][2] - p[1][2] * p[2][0]) +
                p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0])) /
      6.0;
  }
  return volume;
}

std::string Written(const char* name, const std::string& text)
{
  std::ofstream(name, std::ios::binary) << text;
  return name;
}

std::vector<std::string> NamesIn(const std::string& text)
{
  const auto filter = Filter(TwoBoxes());
  filter->SetNamesFileName(Written("names.txt", text).c_str());
  vtkMultiBlockDataSet* blocks = Made(filter);
  return { NameOf(blocks, 0), NameOf(blocks, 1) };
}
} // namespace

TEST(LabelSurfaceFilter, MakesAClosedSurfaceOfEachLabel)
{
  const auto image = TwoBoxes();
  const std::uint64_t before = HashOf(image);
  const auto filter = Filter(image);
  vtkMultiBlockDataSet* blocks = Made(filter);
  EXPECT_EQ(HashOf(image), before) << "the input stays";
  ASSERT_EQ(blocks->GetNumberOfBlocks(), 2u);
  const double samples[2] = { 5 * 6 * 7, 6 * 6 * 7 };
  for (unsigned int k = 0; k < 2; ++k)
  {
    vtkPolyData* surface = BlockOf(blocks, k);
    EXPECT_NEAR(SignedVolume(surface), samples[k], 2e-3 * samples[k])
      << "volume of a voxel is 1, wound outwards in a mirrored image";
    EXPECT_EQ(surface->GetFieldData()->GetArray("SampleVolume")->GetTuple1(0), samples[k]);
    EXPECT_EQ(surface->GetFieldData()->GetArray("Label")->GetTuple1(0), k == 0 ? 4 : 9);
    EXPECT_EQ(surface->GetCellData()->GetScalars()->GetTuple1(3), k == 0 ? 4 : 9);
  }
  EXPECT_EQ(NameOf(blocks, 1), "Label 9");
  double bounds[6];
  BlockOf(blocks, 0)->GetBounds(bounds);
  EXPECT_NEAR(bounds[1], 98.5, 0.6) << "x from 1.5 to 6.5, mirrored at 100";
  EXPECT_NEAR(bounds[2], -17.0, 1.2);
}

TEST(LabelSurfaceFilter, BorderPointsAreInBothSurfaces)
{
  const auto filter = Filter(TwoBoxes());
  const auto pointsOf = [](vtkPolyData* surface) {
    std::set<std::tuple<double, double, double>> points;
    for (vtkIdType v = 0; v < surface->GetNumberOfPoints(); ++v)
    {
      const double* p = surface->GetPoint(v);
      points.insert({ p[0], p[1], p[2] });
    }
    return points;
  };
  const auto common = [&] {
    vtkMultiBlockDataSet* blocks = Made(filter);
    const auto first = pointsOf(BlockOf(blocks, 0)), second = pointsOf(BlockOf(blocks, 1));
    int count = 0;
    for (const auto& point : first)
    {
      count += second.count(point) > 0;
    }
    return count;
  };
  EXPECT_EQ(common(), 7 * 8) << "all points between 6 x 7 faces, bit for bit";
  filter->SharedBordersOff();
  EXPECT_LT(common(), 7 * 8);
}

TEST(LabelSurfaceFilter, CellsHoldLabelsToo)
{
  const auto filter = Filter(TwoBoxes(true));
  filter->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, "Labels");
  vtkMultiBlockDataSet* blocks = Made(filter);
  EXPECT_NEAR(SignedVolume(BlockOf(blocks, 0)), 210.0, 0.5);
  double bounds[6];
  BlockOf(blocks, 0)->GetBounds(bounds);
  EXPECT_NEAR(bounds[1], 98.0, 0.6) << "cell centers lie half a voxel further";
}

TEST(LabelSurfaceFilter, NamesComeFromTablesOfSeveralPrograms)
{
  const std::vector<std::string> expected{ "Precentral_L", "Frontal_R" };
  EXPECT_EQ(NamesIn("4 Precentral_L 2001\r\n9 Frontal_R 2002\r\n"), expected) << "MRIcron";
  EXPECT_EQ(NamesIn("0\tUnclassified\r\n4\tPrecentral_L\r\n9\tFrontal_R\r\n"), expected) << "MRIcron, tabs";
  EXPECT_EQ(NamesIn("# No. Name R G B A\n\n4  Precentral_L 70 130 180 0\n9 Frontal_R 1 2 3 0\n"), expected)
    << "FreeSurfer";
  EXPECT_EQ(NamesIn("4 255 0 0 1 1 1 \"Precentral_L\"\n9 0 255 0 1 1 1 \"Frontal_R\"\n"), expected) << "ITK-SNAP";
  EXPECT_EQ(NamesIn("index,name\n4,Precentral_L\n9,Frontal_R\n"), expected) << "CSV";
  EXPECT_EQ(NamesIn("\xef\xbb\xbf"
                    "4 Precentral_L 1\n9 Frontal_R 2\n"),
    expected)
    << "a byte order mark";
  EXPECT_EQ(NamesIn("4,Precentral_L\n,,\n-1234567890,Other\n9,Frontal_R\n"), expected)
    << "a row of a sheet without cells";
  const std::vector<std::string> areas{ "Area 17", "Area 18" };
  EXPECT_EQ(NamesIn("4 Area 17\n9 Area 18\n"), areas) << "the number is part of the name";
}

TEST(LabelSurfaceFilter, NamesCanBeSet)
{
  const auto filter = Filter(TwoBoxes());
  filter->SetNamesFileName(Written("names.txt", "4 Left\n").c_str());
  filter->SetLabelName(9, "Right");
  vtkMultiBlockDataSet* blocks = Made(filter);
  EXPECT_EQ(NameOf(blocks, 0), "Left");
  EXPECT_EQ(NameOf(blocks, 1), "Right");
  EXPECT_EQ(
    vtkStringArray::SafeDownCast(BlockOf(blocks, 1)->GetFieldData()->GetAbstractArray("LabelName"))->GetValue(0),
    "Right");
  filter->SetLabelName(9, "");
  EXPECT_EQ(NameOf(Made(filter), 1), "Label 9");
}

TEST(LabelSurfaceFilter, LabelsCanBeChosen)
{
  const auto filter = Filter(TwoBoxes());
  filter->SetNumberOfLabels(1);
  filter->SetLabel(0, 9);
  vtkMultiBlockDataSet* blocks = Made(filter);
  ASSERT_EQ(blocks->GetNumberOfBlocks(), 1u);
  EXPECT_EQ(NameOf(blocks, 0), "Label 9");
  filter->SetLabel(0, 5);
  EXPECT_THAT(ErrorOf(filter), HasSubstr("Labels has 5, which no sample"));
}

TEST(LabelSurfaceFilter, RefusesWrongInputsInWords)
{
  vtkNew<vtkImageData> gray;
  gray->SetDimensions(5, 5, 5);
  gray->AllocateScalars(VTK_DOUBLE, 1);
  gray->GetPointData()->GetScalars()->Fill(0.25);
  EXPECT_THAT(ErrorOf(Filter(gray)), HasSubstr("0.25 at sample 0, which is no label"));
  vtkNew<vtkImageData> scan;
  scan->SetDimensions(20, 20, 20);
  scan->AllocateScalars(VTK_INT, 1);
  for (vtkIdType k = 0; k < 8000; ++k)
  {
    scan->GetPointData()->GetScalars()->SetTuple1(k, k == 1 ? 0.0 : static_cast<double>(k + 1)); // 0 after a label
  }
  EXPECT_THAT(ErrorOf(Filter(scan)), HasSubstr("more than 4096 labels"));
  vtkNew<vtkImageData> bare;
  bare->SetDimensions(5, 5, 5);
  EXPECT_THAT(ErrorOf(Filter(bare)), HasSubstr("no such array"));
  const auto filter = Filter(TwoBoxes());
  filter->SetNamesFileName("missing.txt");
  EXPECT_THAT(ErrorOf(filter), HasSubstr("missing.txt: the table of names cannot be read"));
  filter->SetNamesFileName(Written("names.txt", "4 Left\nRight 9\n").c_str());
  EXPECT_THAT(ErrorOf(filter), HasSubstr("line 2 is \"Right 9\""));
  filter->SetNamesFileName(Written("twice.txt", "4 Left\n4 Right\n").c_str());
  EXPECT_THAT(ErrorOf(filter), HasSubstr("has the names \"Left\" and \"Right\""));
}

TEST(LabelSurfaceFilter, GrayValuesOfAScanAreRefusedAndSmallRegionsAreNot)
{
  const auto image = [](auto label) {
    auto made = vtkSmartPointer<vtkImageData>::New();
    made->SetDimensions(16, 16, 16);
    made->AllocateScalars(VTK_SHORT, 1);
    for (vtkIdType k = 0; k < 4096; ++k)
    {
      made->GetPointData()->GetScalars()->SetTuple1(k, label(k % 16, k / 16 % 16, k / 256));
    }
    return made;
  };
  const auto gray = [](
                      vtkIdType x, vtkIdType y, vtkIdType z) { return x < 8 ? 0 : 1 + (7 * x + 13 * y + 29 * z) % 61; };
  const auto scan = Filter(image(gray));
  EXPECT_THAT(ErrorOf(scan), HasSubstr("61 labels, and only 0 percent of adjacent samples have the same label"));
  scan->SetNumberOfLabels(2); // 1 and 1
  scan->SetLabel(1, 2);
  EXPECT_EQ(Made(scan)->GetNumberOfBlocks(), 2u) << "a choice is taken as it is";
  const auto regions = Filter(
    image([](vtkIdType x, vtkIdType y, vtkIdType z) { return 1 + x / 4 + 4 * (y / 4) + 16 * (z / 4); }));
  EXPECT_EQ(Made(regions)->GetNumberOfBlocks(), 64u) << "regions of 64 samples";
  const auto few = Filter(image([](vtkIdType x, vtkIdType y, vtkIdType z) { return (x + y + z) % 3; }));
  EXPECT_EQ(Made(few)->GetNumberOfBlocks(), 2u) << "few labels may be scattered";
}

TEST(LabelSurfaceFilter, EmptyInputGivesEmptyOutput)
{
  vtkNew<vtkImageData> empty;
  EXPECT_EQ(Made(Filter(empty))->GetNumberOfBlocks(), 0u);
  const auto image = TwoBoxes();
  image->GetPointData()->GetScalars()->Fill(0.0);
  EXPECT_EQ(Made(Filter(image))->GetNumberOfBlocks(), 0u);
}

TEST(LabelSurfaceFilter, SameBitsForAllNumbersOfThreads)
{
  const auto image = TwoBoxes();
  ExpectSameBitsForAllThreads([&] { return Filter(image); },
    [](vtkAlgorithm* filter) {
      auto* blocks = vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0));
      return BlockOf(blocks, 1)->GetPoints()->GetData();
    });
}

TEST(LabelSurfaceFilter, EachPropertyRunsItOnce)
{
  const auto filter = Filter(TwoBoxes());
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  const PropertyChanges<vtkLabelSurfaceFilter> changes = {
    { "SmoothingIterations", [](vtkLabelSurfaceFilter* f) { f->SetSmoothingIterations(3); } },
    { "PreserveVolume", [](vtkLabelSurfaceFilter* f) { f->PreserveVolumeOff(); } },
    { "SharedBorders", [](vtkLabelSurfaceFilter* f) { f->SharedBordersOff(); } },
    { "LabelName", [](vtkLabelSurfaceFilter* f) { f->SetLabelName(4, "Four"); } },
    { "Label",
      [](vtkLabelSurfaceFilter* f) {
        f->SetNumberOfLabels(1);
        f->SetLabel(0, 4);
      } },
  };
  ExpectOneExecutionEach(filter.Get(), changes, events);
  EXPECT_EQ(filter->GetLabel(0), 4);
  EXPECT_EQ(filter->GetLabel(3), 0);
  std::ostringstream text;
  filter->Print(text);
  EXPECT_THAT(text.str(), HasSubstr("SharedBorders: 0"));
}
