// SPDX-License-Identifier: BSD-3-Clause
//
// R1 to R6 on the corpus of malformed inputs, ranges and Print.
#include "FilterContract.h"
#include "MalformedCorpus.h"
#include "VtkSurfaces.h"

#include "vtkTetrahedralizeFilter.h"

#include <vtkCellData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkUnstructuredGrid.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

using namespace surfsynthtest;
using ::testing::HasSubstr;
using Tetrahedralize = vtkTetrahedralizeFilter;

namespace
{
vtkSmartPointer<vtkAlgorithm> MakeTetrahedralize() { return vtkSmartPointer<Tetrahedralize>::New(); }

class MalformedInput : public ::testing::TestWithParam<MalformedCase>
{};

FilterTraits Traits()
{
  FilterTraits traits;
  traits.AcceptsEveryValidSurface = false;
  traits.NeedsClosedSurfaces = true;
  return traits;
}

INSTANTIATE_TEST_SUITE_P(Corpus, MalformedInput, ::testing::ValuesIn(MalformedCorpus()),
  [](const ::testing::TestParamInfo<MalformedCase>& info) { return info.param.Name; });
} // namespace

TEST_P(MalformedInput, ToTetrahedra) { CheckAlone(GetParam(), MakeTetrahedralize, Traits()); }

TEST_P(MalformedInput, BetweenGoodBlocksToTetrahedra) { CheckAsBlock(GetParam(), MakeTetrahedralize, Traits()); }

TEST(Tetrahedralize, UnchangedParametersCostNoExecutionAndEachChangeExactlyOne)
{
  vtkNew<Tetrahedralize> filter;
  filter->SetInputDataObject(Icosphere(1).ToPolyData());
  ASSERT_TRUE(Update(filter));
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  EXPECT_EQ(events.Executions, 0) << "nothing has changed";
  const PropertyChanges<Tetrahedralize> changes = {
    { "QualityRatio", [](Tetrahedralize* f) { f->SetQualityRatio(1.8); } },
    { "MinimumDihedralAngle", [](Tetrahedralize* f) { f->SetMinimumDihedralAngle(5.0); } },
    { "MaximumVolume", [](Tetrahedralize* f) { f->SetMaximumVolume(0.1); } },
    { "TargetEdgeLength", [](Tetrahedralize* f) { f->SetTargetEdgeLength(1.0); } },
    { "MaximumNumberOfTetrahedra", [](Tetrahedralize* f) { f->SetMaximumNumberOfTetrahedra(100000); } },
    { "PreserveSurface", [](Tetrahedralize* f) { f->PreserveSurfaceOff(); } },
    { "InnerSurfaces", [](Tetrahedralize* f) { f->SetInnerSurfacesToHoles(); } },
    { "SurfaceTriangles", [](Tetrahedralize* f) { f->SurfaceTrianglesOn(); } },
    { "TimeLimit", [](Tetrahedralize* f) { f->SetTimeLimit(60.0); } },
    { "MemoryLimit", [](Tetrahedralize* f) { f->SetMemoryLimit(4000); } },
    { "RegionArrayName", [](Tetrahedralize* f) { f->SetRegionArrayName("Part"); } },
    { "SurfaceArrayName", [](Tetrahedralize* f) { f->SetSurfaceArrayName("Skin"); } },
  };
  ExpectOneExecutionEach(filter.Get(), changes, events);
  auto* grid = vtkUnstructuredGrid::SafeDownCast(filter->GetOutputDataObject(0));
  EXPECT_TRUE(grid->GetCellData()->GetArray("Part"));
  EXPECT_TRUE(grid->GetPointData()->GetArray("Skin"));
}

TEST(Tetrahedralize, BoundsThatAskForTooManyAreRefusedAndTheOneThatIsNamedFits)
{
  vtkNew<Tetrahedralize> filter;
  filter->SetInputDataObject(Icosphere(2).ToPolyData());
  filter->SetMaximumNumberOfTetrahedra(20000);
  const auto refused = [&](const std::string& mark) {
    EventRecorder events(filter);
    EXPECT_FALSE(Update(filter));
    const std::string error = events.AllErrors();
    EXPECT_THAT(error, HasSubstr("at most 20000 (MaximumNumberOfTetrahedra) are allowed"));
    const std::size_t place = error.find(mark);
    EXPECT_NE(place, std::string::npos) << error;
    return place == std::string::npos ? 1.0 : std::stod(error.substr(place + mark.size()));
  };
  const auto made = [&] {
    EXPECT_TRUE(Update(filter));
    return filter->GetOutputDataObject(0)->GetNumberOfElements(vtkDataObject::CELL);
  };
  for (const bool preserve : { true, false })
  {
    filter->SetPreserveSurface(preserve);
    filter->SetTargetEdgeLength(1e-4);
    filter->SetTargetEdgeLength(refused("A TargetEdgeLength of "));
    EXPECT_GT(made(), 5000) << "and is not far too large";
    EXPECT_LT(made(), 40000);
    filter->SetTargetEdgeLength(0.0);
    filter->SetMaximumVolume(1e-12);
    filter->SetMaximumVolume(refused("A MaximumVolume of "));
    EXPECT_GT(made(), 5000);
    filter->SetMaximumVolume(0.0);
  }
}

TEST(Tetrahedralize, RangesAndPrint)
{
  vtkNew<Tetrahedralize> filter;
  filter->SetQualityRatio(-1.0);
  EXPECT_EQ(filter->GetQualityRatio(), 0.0);
  filter->SetMinimumDihedralAngle(80.0);
  EXPECT_EQ(filter->GetMinimumDihedralAngle(), 60.0);
  filter->SetInnerSurfaces(9);
  EXPECT_EQ(filter->GetInnerSurfaces(), Tetrahedralize::HOLES);
  filter->SetMemoryLimit(-1);
  EXPECT_EQ(filter->GetMemoryLimit(), 0);
  std::ostringstream text;
  filter->Print(text);
  for (const char* property : { "QualityRatio", "MinimumDihedralAngle", "MaximumVolume", "TargetEdgeLength",
         "MaximumNumberOfTetrahedra", "PreserveSurface", "InnerSurfaces", "SurfaceTriangles", "TimeLimit",
         "MemoryLimit", "RegionArrayName: Region", "SurfaceArrayName: OnSurface" })
  {
    EXPECT_THAT(text.str(), HasSubstr(property));
  }
}
