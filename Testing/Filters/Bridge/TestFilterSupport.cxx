// SPDX-License-Identifier: BSD-3-Clause
//
// Parts of filters that do not depend on what they compute: FilterSupport.h, DataObjects.h, TableColumns.h, and the
// requests of RandomFields.h.
#include "DataObjects.h"
#include "FilterSupport.h"
#include "PointRows.h"
#include "RandomFields.h"
#include "TableColumns.h"
#include "VtkSurfaces.h"

#include "Core/Noise/GaussianMixtures.h"
#include "Core/Noise/MaternField.h"

#include <vtkDoubleArray.h>
#include <vtkNew.h>
#include <vtkObject.h>
#include <vtkPolyData.h>
#include <vtkStringArray.h>
#include <vtkTable.h>

#include <gtest/gtest.h>

#include <string>
#include <vector>

using namespace surfsynth;
using surfsynthtest::Icosphere;

TEST(FilterSupport, AStringPropertyIsModifiedOnChangeOnly)
{
  vtkNew<vtkObject> object;
  std::string property = "a";
  const vtkMTimeType before = object->GetMTime();
  SetString(object, property, "a");
  EXPECT_EQ(object->GetMTime(), before);
  SetString(object, property, "b");
  EXPECT_EQ(property, "b");
  const vtkMTimeType after = object->GetMTime();
  EXPECT_GT(after, before);
  SetString(object, property, nullptr);
  EXPECT_EQ(property, "");
  EXPECT_GT(object->GetMTime(), after);
}

TEST(DataObjects, SizesCountPointsAndCells)
{
  EXPECT_TRUE(IsEmpty(nullptr));
  vtkNew<vtkPolyData> surface;
  EXPECT_TRUE(IsEmpty(surface));
  EXPECT_EQ(SizeOf(Icosphere(0).ToPolyData()), 12 + 20);
  surface->SetPoints(Icosphere(0).ToPolyData()->GetPoints());
  EXPECT_FALSE(IsEmpty(surface)) << "points without cells";
}

TEST(DataObjects, NewObjectsAreOfTheNamedClass)
{
  EXPECT_STREQ(NewDataObject("vtkMultiBlockDataSet")->GetClassName(), "vtkMultiBlockDataSet");
  EXPECT_TRUE(IsEmpty(NewDataObject("vtkPolyData")));
}

TEST(TableColumns, ValuesStayInOrder)
{
  vtkNew<vtkTable> table;
  AddColumn<vtkDoubleArray>(table, "Number", std::vector<double>{ 0.5, 1.5 });
  AddColumn<vtkStringArray>(table, "Name", std::vector<std::string>{ "a", "b" });
  ASSERT_EQ(table->GetNumberOfRows(), 2);
  EXPECT_EQ(table->GetValueByName(1, "Number").ToDouble(), 1.5);
  EXPECT_EQ(table->GetValueByName(0, "Name").ToString(), "a");
}

TEST(PointRows, CountsAreFormattedForMessages)
{
  EXPECT_EQ(FormatCount(0, "tuple"), "no tuples");
  EXPECT_EQ(FormatCount(1, "tuple"), "1 tuple");
  EXPECT_EQ(FormatCount(2, "tuple"), "2 tuples");
}

TEST(RandomFields, RanksShareTheSamplesOfASurface)
{
  const SampleSeries series{ "Noise", 7, 10, 5, 1 };
  Surface surface;
  surface.FlatIndex = 3;
  const auto whole = RequestPart<SampleRequest>(series, surface);
  EXPECT_EQ(whole.Seed, 7u);
  EXPECT_EQ(whole.Stream, 3u);
  EXPECT_EQ(whole.FirstSample, 10u);
  EXPECT_EQ(whole.NumberOfSamples, 5u);
  EXPECT_EQ(whole.SampleStep, 1u);
  surface.Part = { 1, 2 };
  const auto part = RequestPart<GaussianMixtureRequest>(series, surface);
  EXPECT_EQ(part.FirstSample, 11u);
  EXPECT_EQ(part.SampleStep, 2u);
  EXPECT_EQ(part.NumberOfSamples, 2u) << "11 and 13 of 10 to 14";
}
