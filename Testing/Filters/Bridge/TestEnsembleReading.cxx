// SPDX-License-Identifier: BSD-3-Clause
//
// Ensembles in VTK's data objects: what is a sample, what it is called, and what does not fit.
#include "FilterChecks.h"
#include "ThrownText.h"
#include "VtkSurfaces.h"

#include "EnsembleReading.h"
#include "NewArray.h"

#include "Core/Common/Errors.h"

#include <vtkCellArray.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkIntArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkStructuredGrid.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

using namespace surfsynthtest;
using surfsynth::Ensemble;
using surfsynth::InvalidInput;
using surfsynth::MassOf;
using surfsynth::NewArray;
using surfsynth::ReadEnsemble;
using surfsynth::RequireOneTriangulation;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

namespace
{
std::vector<std::string> NamesOf(const Ensemble& ensemble)
{
  std::vector<std::string> names;
  for (const auto& sample : ensemble.Samples)
  {
    names.push_back(sample.Name);
  }
  return names;
}

/// A sphere with the arrays of @p names, one component each, all filled with their place in the list.
vtkSmartPointer<vtkPolyData> SphereWith(const std::vector<std::string>& names)
{
  const auto sphere = Icosphere(1).ToPolyData();
  for (std::size_t k = 0; k < names.size(); ++k)
  {
    const auto array = NewArray<vtkDoubleArray>(names[k], 42, 1);
    array->FillValue(static_cast<double>(k));
    sphere->GetPointData()->AddArray(array);
  }
  return sphere;
}

std::string ErrorOfReading(vtkDataObject* input, const std::string& array)
{
  return TextOf<InvalidInput>([&] { ReadEnsemble(input, "generated", array); });
}
} // namespace

TEST(EnsembleReading, WithoutAnArrayNameTheSampleIsThePoints)
{
  const auto sphere = Icosphere(1).ToPolyData();
  const Ensemble ensemble = ReadEnsemble(sphere, "generated", "");
  ASSERT_THAT(NamesOf(ensemble), ElementsAre("Points"));
  EXPECT_EQ(ensemble.Samples[0].Surface, sphere);
  EXPECT_EQ(ensemble.Samples[0].Values, sphere->GetPoints()->GetData()) << "not copied";
  EXPECT_EQ(ensemble.NameOf(0), "generated sample 0 (Points)");
}

TEST(EnsembleReading, NumberedArraysAreSamplesInTheOrderOfNumbers)
{
  const auto sphere = SphereWith({ "Noise_10", "Noise_2", "Other", "Noise_x", "Noise_", "Noise_0", "Noises_1" });
  const Ensemble ensemble = ReadEnsemble(sphere, "reference", "Noise");
  EXPECT_THAT(NamesOf(ensemble), ElementsAre("Noise_0", "Noise_2", "Noise_10"));
  EXPECT_EQ(ensemble.Samples[0].Values->GetTuple1(0), 5.0);
  EXPECT_EQ(ensemble.Samples[2].Values->GetTuple1(0), 0.0);
  const auto both = SphereWith({ "Noise_0", "Noise" });
  EXPECT_THAT(NamesOf(ReadEnsemble(both, "reference", "Noise")), ElementsAre("Noise")) << "the array itself goes first";
}

TEST(EnsembleReading, BlocksAreSamplesAndEmptyOnesAreLeftOut)
{
  vtkNew<vtkMultiBlockDataSet> inner;
  inner->SetBlock(0, SphereWith({ "A_0", "A_1" }));
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, SphereWith({ "A" }));
  blocks->SetBlock(1, vtkSmartPointer<vtkPolyData>::New());
  blocks->SetBlock(3, inner);
  EXPECT_THAT(NamesOf(ReadEnsemble(blocks, "generated", "A")), ElementsAre("Block 1", "Block 5: A_0", "Block 5: A_1"));
  EXPECT_THAT(NamesOf(ReadEnsemble(blocks, "generated", "")), ElementsAre("Block 1", "Block 5"));
  EXPECT_THAT(NamesOf(ReadEnsemble(vtkSmartPointer<vtkPolyData>::New(), "generated", "A")), IsEmpty());
}

TEST(EnsembleReading, ValuesAreReadInTheirOwnPrecision)
{
  const auto sphere = Icosphere(1).ToPolyData(VTK_FLOAT);
  sphere->GetPointData()->AddArray(NewArray<vtkDoubleArray>("Double", 42, 2));
  const auto whole = NewArray<vtkIntArray>("Int", 42, 1);
  whole->FillValue(3);
  sphere->GetPointData()->AddArray(whole);
  const auto valueOf = [&](const char* name) { return ReadEnsemble(sphere, "generated", name); };
  const Ensemble points = valueOf("");
  EXPECT_TRUE(vtkFloatArray::SafeDownCast(points.Samples[0].Values));
  ASSERT_EQ(points.Values().size(), 1u);
  const Ensemble doubles = valueOf("Double");
  EXPECT_EQ(doubles.Samples[0].Values, sphere->GetPointData()->GetArray("Double"));
  const Ensemble ints = valueOf("Int");
  EXPECT_TRUE(vtkDoubleArray::SafeDownCast(ints.Samples[0].Values)) << "a copy of what is neither float nor double";
  EXPECT_EQ(ints.Samples[0].Values->GetTuple1(41), 3.0);
}

TEST(EnsembleReading, WhatIsNoEnsembleIsAnError)
{
  EXPECT_EQ(ErrorOfReading(nullptr, ""), "There is no generated ensemble; one is needed.");
  EXPECT_THAT(ErrorOfReading(SphereWith({ "B" }), "A"),
    AllOf(HasSubstr("The generated surface has no numeric point array called \"A\""), HasSubstr("\"A_0\"")));
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, SphereWith({ "A" }));
  blocks->SetBlock(1, SphereWith({ "B" }));
  EXPECT_THAT(ErrorOfReading(blocks, "A"), HasSubstr("Block 2 of the generated ensemble has no numeric point array"));
  blocks->SetBlock(1, vtkSmartPointer<vtkStructuredGrid>::New());
  EXPECT_THAT(ErrorOfReading(blocks, "A"),
    AllOf(HasSubstr("Block 2 of the generated ensemble is a vtkStructuredGrid"), HasSubstr("vtkPolyData is needed")));
  vtkNew<vtkPolyData> cells;
  cells->SetPolys(Icosphere(1).ToPolyData()->GetPolys());
  EXPECT_THAT(ErrorOfReading(cells, ""), HasSubstr("has cells but no points"));
}

TEST(EnsembleReading, SamplesMustLieOnOneTriangulation)
{
  const auto sphere = SphereWith({ "A" });
  const surfsynth::SharedSurface shared{ sphere, "the source" };
  const auto errorOf = [&](vtkDataObject* samples, int components) {
    return TextOf<InvalidInput>(
      [&] { RequireOneTriangulation(ReadEnsemble(samples, "generated", "A"), shared, components); });
  };
  const auto same = SphereWith({ "A" });
  same->GetPolys()->ConvertTo32BitStorage();
  EXPECT_NO_THROW(RequireOneTriangulation(ReadEnsemble(same, "generated", "A"), shared, 1)) << "in any storage";
  EXPECT_THAT(
    errorOf(same, 3), AllOf(HasSubstr("generated sample 0 (A) has 1 components"), HasSubstr("where 3 are needed")));
  Soup turned = Icosphere(1);
  std::swap(turned.Polys[7][0], turned.Polys[7][1]);
  const auto other = turned.ToPolyData();
  other->GetPointData()->AddArray(NewArray<vtkDoubleArray>("A", 42, 1));
  EXPECT_THAT(errorOf(other, 1), HasSubstr("has other polygons or strips than the source"));
  const auto fine = Icosphere(2).ToPolyData();
  fine->GetPointData()->AddArray(NewArray<vtkDoubleArray>("A", 162, 1));
  EXPECT_THAT(errorOf(fine, 1), HasSubstr("has 162 points and the source has 42"));
  const auto longer = Icosphere(1).ToPolyData();
  longer->GetPointData()->AddArray(NewArray<vtkDoubleArray>("A", 43, 1));
  EXPECT_THAT(errorOf(longer, 1), HasSubstr("has 43 values for 42 points"));
}

TEST(EnsembleReading, MassIsAThirdOfTheAreaOfTheTrianglesAround)
{
  const auto square = Grid(1, 4).ToPolyData();
  EXPECT_NEAR(MassOf({ square, "the source" }).sum(), 1.0, 1e-15);
  EXPECT_EQ(MassOf({ square, "the source" }).size(), 4);
  EXPECT_NEAR(MassOf({ square, "the source" }).minCoeff(), 1.0 / 6.0, 1e-15) << "the corners without the diagonal";
  Soup broken = Icosphere(1);
  broken.Points[3] = std::nan("");
  const auto surface = broken.ToPolyData();
  EXPECT_THAT(TextOf<InvalidInput>([&] {
    MassOf({ surface, "reference sample 0 (Block 1)" });
  }),
    HasSubstr("The mass of the points cannot be computed from reference sample 0 (Block 1): "));
}
