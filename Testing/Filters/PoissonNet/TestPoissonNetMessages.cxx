// SPDX-License-Identifier: BSD-3-Clause
//
// Each thing that can be wrong with a model file, a mesh or a property, and the text that the user reads.
#include "PoissonNetPipelines.h"

#include "FileBytes.h"
#include "FilterContract.h"

#include "IO/Weights/SafetensorsWriter.h"

#include <vtkFloatArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkStructuredGrid.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

using namespace surfsynth;
using namespace surfsynthtest;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

namespace
{
std::string ErrorOfModel(const std::string& path)
{
  return ErrorOf(PoissonNetOn(UnitAreaSphere(2).ToPolyData(), path));
}

std::string ErrorOfMesh(const Soup& soup)
{
  const std::string model = WriteModel(
    "mesh.model", SmallOptions(PoissonNetDomain::Vertices, LastActivation::Identity));
  return ErrorOf(PoissonNetOn(soup.ToPolyData(), model));
}

/// A good model file, damaged by @p change.
template <typename Change>
std::string Damaged(const std::string& name, const Change& change)
{
  WriteModel(name, SmallOptions(PoissonNetDomain::Vertices, LastActivation::Identity));
  std::string bytes = BytesOf(name);
  change(bytes);
  WriteBytes(name, bytes);
  return name;
}

vtkSmartPointer<vtkPolyData> SphereWithArray(const char* name, int components, vtkIdType missing = 0)
{
  auto surface = UnitAreaSphere(2).ToPolyData();
  vtkNew<vtkFloatArray> array;
  array->SetName(name);
  array->SetNumberOfComponents(components);
  array->SetNumberOfTuples(surface->GetNumberOfPoints() - missing);
  array->Fill(0.5);
  surface->GetPointData()->AddArray(array);
  return surface;
}
} // namespace

// --- Model files -----------------------------------------------------------------------------------------------------

TEST(PoissonNetMessages, NoFileName)
{
  EXPECT_THAT(ErrorOfModel(""), AllOf(HasSubstr("ModelFileName is empty"), HasSubstr("safetensors")));
}

TEST(PoissonNetMessages, MissingFile)
{
  EXPECT_THAT(ErrorOfModel("nowhere/none.safetensors"),
    AllOf(HasSubstr("\"nowhere/none.safetensors\""), HasSubstr("No such file"), HasSubstr("convert")));
}

TEST(PoissonNetMessages, AFolder) { EXPECT_THAT(ErrorOfModel("."), HasSubstr(". is not a file")); }

TEST(PoissonNetMessages, EmptyFile)
{
  WriteBytes("empty.model", "");
  EXPECT_THAT(ErrorOfModel("empty.model"), AllOf(HasSubstr("empty.model"), HasSubstr("safetensors rule 1")));
}

TEST(PoissonNetMessages, TruncatedFile)
{
  const std::string path = Damaged("truncated.model", [](std::string& bytes) { bytes.resize(bytes.size() - 100); });
  EXPECT_THAT(ErrorOfModel(path), AllOf(HasSubstr(path), HasSubstr("safetensors rule 7")));
}

TEST(PoissonNetMessages, TruncatedInTheHeader)
{
  const std::string path = Damaged("header.model", [](std::string& bytes) { bytes.resize(40); });
  EXPECT_THAT(ErrorOfModel(path), AllOf(HasSubstr(path), HasSubstr("safetensors rule 1")));
}

TEST(PoissonNetMessages, APickledCheckpoint)
{
  WriteBytes("checkpoint.pt", std::string("PK\x03\x04\x00\x00\x00\x00", 8) + std::string(200, 'x'));
  EXPECT_THAT(ErrorOfModel("checkpoint.pt"),
    AllOf(HasSubstr("checkpoint.pt"), HasSubstr("a ZIP archive, as PyTorch writes them"),
      HasSubstr("\"python3 -m surfacesynthesis convert\""), HasSubstr("safetensors rule 1")));
}

TEST(PoissonNetMessages, AWeightThatIsNaN)
{
  const std::string path = Damaged("nan.model", [](std::string& bytes) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    std::memcpy(&bytes[bytes.size() - 4], &nan, 4);
  });
  EXPECT_THAT(ErrorOfModel(path), AllOf(HasSubstr(path), HasSubstr("safetensors rule 9")));
}

TEST(PoissonNetMessages, AnotherArchitecture)
{
  WriteSafetensors("other.model", {}, { { "architecture", "unet" } });
  EXPECT_THAT(ErrorOfModel("other.model"), AllOf(HasSubstr("\"unet\""), HasSubstr("poissonnet")));
}

TEST(PoissonNetMessages, AFileWithoutConfig)
{
  WriteSafetensors("bare.model", { { "a", TensorData::FromFloat32({ 1 }, { 1.0F }) } });
  EXPECT_THAT(ErrorOfModel("bare.model"), AllOf(HasSubstr("\"config\""), HasSubstr("missing")));
}

TEST(PoissonNetMessages, TensorsThatAreNotThoseOfTheConfig)
{
  const std::string path = Damaged("mismatch.model", [](std::string& bytes) {
    const std::size_t place = bytes.find("\"n_blocks\":\"2\"");
    ASSERT_NE(place, std::string::npos);
    bytes[place + 12] = '1';
  });
  EXPECT_THAT(ErrorOfModel(path), AllOf(HasSubstr("blocks.1."), HasSubstr("does not belong")));
}

// A broken file is one error, not one for each block.
TEST(PoissonNetMessages, OneErrorForACompositeInput)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, UnitAreaSphere(1).ToPolyData());
  blocks->SetBlock(1, UnitAreaSphere(1).ToPolyData());
  const auto filter = PoissonNetOn(blocks, "nowhere.model");
  EventRecorder recorder(filter);
  EXPECT_FALSE(Update(filter));
  EXPECT_THAT(recorder.Errors, SizeIs(1));
}

TEST(PoissonNetMessages, AGoodFileAfterABadOne)
{
  const auto filter = PoissonNetOn(UnitAreaSphere(2).ToPolyData(), "nowhere.model");
  EXPECT_THAT(ErrorOf(filter), HasSubstr("nowhere.model"));
  EXPECT_EQ(filter->GetModelDescription(), "");
  filter->SetModelFileName(
    WriteModel("good.model", SmallOptions(PoissonNetDomain::Vertices, LastActivation::Identity)).c_str());
  EXPECT_THAT(WarningsOf(filter), IsEmpty());
  EXPECT_THAT(filter->GetModelDescription(), HasSubstr("2 blocks"));
}

// --- Meshes ----------------------------------------------------------------------------------------------------------

TEST(PoissonNetMessages, NoInput)
{
  vtkNew<vtkPoissonNetFilter> filter;
  EXPECT_THAT(ErrorOf(filter), AllOf(HasSubstr("There is no input"), HasSubstr("vtkPolyData")));
}

TEST(PoissonNetMessages, EmptyInputIsNoError)
{
  vtkNew<vtkPolyData> empty;
  const std::string model = WriteModel(
    "onempty.model", SmallOptions(PoissonNetDomain::Vertices, LastActivation::Identity));
  EXPECT_THAT(WarningsOf(PoissonNetOn(empty, model)), IsEmpty());
}

TEST(PoissonNetMessages, AnotherTypeOfInput)
{
  vtkNew<vtkStructuredGrid> grid;
  EXPECT_THAT(
    ErrorOf(PoissonNetOn(grid, "any.model")), AllOf(HasSubstr("vtkStructuredGrid"), HasSubstr("vtkPolyData")));
}

namespace
{
Soup TwoSpheres()
{
  Soup two = UnitAreaSphere(1);
  const vtkIdType first = two.NumberOfPoints();
  for (const auto& polygon : UnitAreaSphere(1).Polys)
  {
    two.Polys.push_back({ polygon[0] + first, polygon[1] + first, polygon[2] + first });
  }
  for (const double coordinate : UnitAreaSphere(1).Points)
  {
    two.Points.push_back(coordinate + 1.0);
  }
  return two;
}
} // namespace

TEST(PoissonNetMessages, SeveralComponents)
{
  EXPECT_THAT(
    ErrorOfMesh(TwoSpheres()), AllOf(HasSubstr("2 connected components"), HasSubstr("vtkPolyDataConnectivityFilter")));
}

TEST(PoissonNetMessages, SeveralComponentsAreTakenWhenTheyAreCoupled)
{
  const auto filter = PoissonNetOn(TwoSpheres().ToPolyData(),
    WriteModel("coupled.model", SmallOptions(PoissonNetDomain::Vertices, LastActivation::Identity)));
  filter->ComponentCouplingOn();
  EXPECT_THAT(ErrorOf(filter), HasSubstr("farther than the coupling distance"));
  filter->SetCouplingDistance(5.0);
  ASSERT_TRUE(Update(filter));
  EXPECT_EQ(filter->GetNumberOfFactorizations(), 1);
  filter->SetCouplingWeight(1e5);
  ASSERT_TRUE(Update(filter));
  EXPECT_EQ(filter->GetNumberOfFactorizations(), 2);
}

TEST(PoissonNetMessages, InconsistentWinding)
{
  Soup sphere = UnitAreaSphere(2);
  std::swap(sphere.Polys[7][0], sphere.Polys[7][1]);
  EXPECT_THAT(ErrorOfMesh(sphere), AllOf(HasSubstr("3 edge(s)"), HasSubstr("vtkPolyDataNormals")));
}

TEST(PoissonNetMessages, NonManifoldEdge)
{
  Soup fin = UnitAreaSphere(2);
  const vtkIdType tip = fin.AddPoint(1.0, 1.0, 1.0);
  fin.Polys.push_back({ fin.Polys[0][0], fin.Polys[0][1], tip });
  EXPECT_THAT(ErrorOfMesh(fin), HasSubstr("more than two"));
}

TEST(PoissonNetMessages, FacesThatPointInwardsAreAWarning)
{
  const std::string model = WriteModel(
    "inwards.model", SmallOptions(PoissonNetDomain::Vertices, LastActivation::Identity));
  Soup sphere = UnitAreaSphere(2);
  for (auto& polygon : sphere.Polys)
  {
    std::swap(polygon[0], polygon[1]);
  }
  const auto filter = PoissonNetOn(sphere.ToPolyData(), model);
  EXPECT_THAT(WarningsOf(filter),
    ElementsAre(AllOf(HasSubstr("point inwards"), HasSubstr("mirror"), HasSubstr("vtkPolyDataNormals"),
      HasSubstr("vtkSurfaceRepairFilter"))));
}

TEST(PoissonNetMessages, AnAreaFarFromOneIsAWarningUnlessNormalized)
{
  const std::string model = WriteModel(
    "area.model", SmallOptions(PoissonNetDomain::Vertices, LastActivation::Identity));
  const auto filter = PoissonNetOn(Icosphere(2).ToPolyData(), model);
  EXPECT_THAT(WarningsOf(filter), ElementsAre(AllOf(HasSubstr("area of 12.3"), HasSubstr("InputNormalization"))));
  filter->SetInputNormalizationToSurfaceArea();
  EXPECT_THAT(WarningsOf(filter), IsEmpty());
  EXPECT_THAT(WarningsOf(PoissonNetOn(UnitAreaSphere(2).ToPolyData(), model)), IsEmpty());
}

TEST(PoissonNetMessages, WarningsOfBlocksNameTheBlock)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, UnitAreaSphere(1).ToPolyData());
  blocks->SetBlock(1, Icosphere(1).ToPolyData());
  const std::string model = WriteModel(
    "where.model", SmallOptions(PoissonNetDomain::Vertices, LastActivation::Identity));
  EXPECT_THAT(WarningsOf(PoissonNetOn(blocks, model)), ElementsAre(HasSubstr("Block 2: ")));
}

// --- Conditions, signals, names --------------------------------------------------------------------------------------

TEST(PoissonNetMessages, WrongNumberOfConditions)
{
  const auto filter = PoissonNetOn(
    UnitAreaSphere(2).ToPolyData(), WriteModel("conditions.model", SmallGradientOptions(3)));
  EXPECT_THAT(
    ErrorOf(filter), AllOf(HasSubstr("takes 3 conditions"), HasSubstr("none"), HasSubstr("ConditionArrayName")));
  filter->SetNumberOfConditions(2);
  EXPECT_THAT(ErrorOf(filter), AllOf(HasSubstr("takes 3 conditions"), HasSubstr("holds 2")));
  filter->SetNumberOfConditions(3);
  EXPECT_TRUE(Update(filter));
  filter->SetModelFileName(WriteModel("unconditional.model", SmallGradientOptions(0)).c_str());
  EXPECT_THAT(ErrorOf(filter), AllOf(HasSubstr("takes no conditions"), HasSubstr("Leave Conditions empty")));
  filter->SetNumberOfConditions(0);
  filter->SetConditionArrayName("Time");
  EXPECT_THAT(ErrorOf(filter), AllOf(HasSubstr("takes no conditions"), HasSubstr("\"Time\"")));
}

TEST(PoissonNetMessages, ConditionsThatAreNotFinite)
{
  const auto filter = PoissonNetOn(UnitAreaSphere(2).ToPolyData(), WriteModel("finite.model", SmallGradientOptions(1)));
  filter->SetNumberOfConditions(1);
  for (const double value : { std::nan(""), 1e300 })
  {
    filter->SetCondition(0, value);
    EXPECT_THAT(ErrorOf(filter), AllOf(HasSubstr("Conditions"), HasSubstr("not finite")));
  }
}

TEST(PoissonNetMessages, ArraysOfConditions)
{
  const std::string model = WriteModel("arrays.model", SmallGradientOptions(2));
  const auto error = [&](vtkPolyData* surface, const char* name) {
    const auto filter = PoissonNetOn(surface, model);
    filter->SetConditionArrayName(name);
    return ErrorOf(filter);
  };
  EXPECT_THAT(
    error(SphereWithArray("Time", 2), "Tide"), AllOf(HasSubstr("no point array \"Tide\""), HasSubstr("2 components")));
  EXPECT_THAT(
    error(SphereWithArray("Time", 3), "Time"), AllOf(HasSubstr("has 3 components"), HasSubstr("2 components")));
  EXPECT_THAT(error(SphereWithArray("Time", 2, 5), "Time"), AllOf(HasSubstr("157 tuples"), HasSubstr("162 points")));
  const auto broken = SphereWithArray("Time", 2);
  broken->GetPointData()->GetArray("Time")->SetComponent(9, 1, std::nan(""));
  EXPECT_THAT(error(broken, "Time"), AllOf(HasSubstr("not finite"), HasSubstr("point 9")));
}

TEST(PoissonNetMessages, Signals)
{
  PoissonNetOptions options = SmallOptions(PoissonNetDomain::Vertices, LastActivation::Identity);
  options.InputChannels = 4;
  const auto filter = PoissonNetOn(SphereWithArray("Heat", 3), WriteModel("signal.model", options));
  EXPECT_THAT(ErrorOf(filter), AllOf(HasSubstr("takes 4 channels"), HasSubstr("SignalArrayName")));
  filter->SetSignalArrayName("Heat");
  EXPECT_THAT(ErrorOf(filter), AllOf(HasSubstr("has 3 components"), HasSubstr("4 components")));
}

TEST(PoissonNetMessages, EmptyNamesOfArrays)
{
  const auto filter = PoissonNetOn(UnitAreaSphere(1).ToPolyData(), WriteModel("name.model", SmallGradientOptions()));
  filter->SetLabelArrayName("");
  EXPECT_THAT(ErrorOf(filter), AllOf(HasSubstr("name of an output array is empty"), HasSubstr("LabelArrayName")));
}
