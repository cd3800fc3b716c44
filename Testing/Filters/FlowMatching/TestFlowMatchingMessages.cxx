// SPDX-License-Identifier: BSD-3-Clause
//
// Each thing that can be wrong with a model file, a mesh or a property, and the text that the user reads.
#include "FlowMatchingPipelines.h"

#include "FileBytes.h"
#include "FilterContract.h"
#include "RandomPoissonNet.h"

#include "IO/Weights/SafetensorsWriter.h"
#include "Inference/PoissonNet/PoissonNetModel.h"

#include <vtkDoubleArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkStructuredGrid.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

using namespace surfsynth;
using namespace surfsynthtest;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

namespace
{
std::string ErrorOfModel(const std::string& path) { return ErrorOf(DeformerOn(Icosphere(2).ToPolyData(), path)); }

std::string ErrorOfMesh(const Soup& soup)
{
  return ErrorOf(DeformerOn(soup.ToPolyData(), WriteDeformer("mesh.model")));
}

Soup TwoSpheres()
{
  Soup two = Icosphere(1);
  const Soup one = Icosphere(1);
  const vtkIdType first = two.NumberOfPoints();
  for (const auto& polygon : one.Polys)
  {
    two.Polys.push_back({ polygon[0] + first, polygon[1] + first, polygon[2] + first });
  }
  for (const double coordinate : one.Points)
  {
    two.Points.push_back(coordinate + 3.0);
  }
  return two;
}
} // namespace

// --- Model files -----------------------------------------------------------------------------------------------------

TEST(FlowMatchingMessages, NoFileName)
{
  EXPECT_THAT(ErrorOfModel(""), AllOf(HasSubstr("ModelFileName is empty"), HasSubstr("flow matching model")));
}

TEST(FlowMatchingMessages, MissingFile)
{
  EXPECT_THAT(ErrorOfModel("nowhere/none.safetensors"),
    AllOf(HasSubstr("\"nowhere/none.safetensors\""), HasSubstr("No such file"), HasSubstr("vtkFlowMatchingTrainer")));
}

TEST(FlowMatchingMessages, AFolder) { EXPECT_THAT(ErrorOfModel("."), HasSubstr(". is not a file")); }

TEST(FlowMatchingMessages, EmptyFile)
{
  WriteBytes("empty.model", "");
  EXPECT_THAT(ErrorOfModel("empty.model"), AllOf(HasSubstr("empty.model"), HasSubstr("safetensors rule 1")));
}

TEST(FlowMatchingMessages, TruncatedFile)
{
  WriteDeformer("truncated.model");
  std::string bytes = BytesOf("truncated.model");
  bytes.resize(bytes.size() - 100);
  WriteBytes("truncated.model", bytes);
  EXPECT_THAT(ErrorOfModel("truncated.model"), AllOf(HasSubstr("truncated.model"), HasSubstr("safetensors rule 7")));
}

TEST(FlowMatchingMessages, AModelOfAnotherKind)
{
  WritePoissonNet("poissonnet.model", surfsynth::test::RandomModel({}));
  EXPECT_THAT(ErrorOfModel("poissonnet.model"),
    AllOf(HasSubstr("\"poissonnet\""), HasSubstr("flow_matching"), HasSubstr("vtkFlowMatchingTrainer")));
}

TEST(FlowMatchingMessages, AModelOfAnotherSignalCannotDeform)
{
  const std::string model = WriteSignalModel("heat.model");
  EXPECT_THAT(ErrorOfModel(model),
    AllOf(
      HasSubstr("generates \"Mixture\", 2 component(s)"), HasSubstr("positions"), HasSubstr("vtkFlowMatchingSampler")));
  EXPECT_THAT(WarningsOf(SamplerOn(Icosphere(2).ToPolyData(), model)), IsEmpty());
}

// A broken file is one error, not one for each block or sample.
TEST(FlowMatchingMessages, OneErrorForACompositeInput)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, Icosphere(1).ToPolyData());
  blocks->SetBlock(1, Icosphere(1).ToPolyData());
  const auto filter = DeformerOn(blocks, "nowhere.model");
  filter->SetNumberOfSamples(3);
  EXPECT_THAT(ErrorOf(filter), HasSubstr("nowhere.model"));
}

TEST(FlowMatchingMessages, AGoodFileAfterABadOne)
{
  const auto filter = DeformerOn(Icosphere(2).ToPolyData(), "nowhere.model");
  EXPECT_THAT(ErrorOf(filter), HasSubstr("nowhere.model"));
  EXPECT_EQ(filter->GetModelDescription(), "");
  filter->SetModelFileName(WriteDeformer("good.model").c_str());
  EXPECT_THAT(WarningsOf(filter), IsEmpty());
  EXPECT_THAT(filter->GetModelDescription(), HasSubstr("2 blocks"));
}

TEST(FlowMatchingMessages, AFlowThatGrowsWithoutBound)
{
  const std::string model = WriteSignalModel(
    "wild.model", 1, 1, [](FlowMatchingModel& wild) { wild.Velocity.Tensors["head.bias"].Values = { 1e7F }; });
  EXPECT_THAT(ErrorOf(SamplerOn(Icosphere(2).ToPolyData(), model)), HasSubstr("grows without bound"));
}

// --- Meshes ----------------------------------------------------------------------------------------------------------

TEST(FlowMatchingMessages, NoInput)
{
  vtkNew<vtkFlowMatchingDeformer> filter;
  EXPECT_THAT(ErrorOf(filter), AllOf(HasSubstr("There is no input"), HasSubstr("vtkPolyData")));
}

TEST(FlowMatchingMessages, EmptyInputIsNoError)
{
  vtkNew<vtkPolyData> empty;
  const auto filter = DeformerOn(empty, WriteDeformer("onempty.model"));
  EXPECT_THAT(WarningsOf(filter), IsEmpty());
  filter->SetNumberOfSamples(2);
  EXPECT_THAT(WarningsOf(filter), IsEmpty());
  auto* output = vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0));
  ASSERT_TRUE(output && output->GetNumberOfBlocks() == 2);
  EXPECT_EQ(output->GetNumberOfPoints(), 0);
}

TEST(FlowMatchingMessages, AnotherTypeOfInput)
{
  vtkNew<vtkStructuredGrid> grid;
  EXPECT_THAT(ErrorOf(DeformerOn(grid, "any.model")), AllOf(HasSubstr("vtkStructuredGrid"), HasSubstr("vtkPolyData")));
}

TEST(FlowMatchingMessages, SeveralComponents)
{
  EXPECT_THAT(
    ErrorOfMesh(TwoSpheres()), AllOf(HasSubstr("2 connected components"), HasSubstr("vtkPolyDataConnectivityFilter")));
}

TEST(FlowMatchingMessages, ANormalizationThatIsNotFinite)
{
  const auto filter = DeformerOn(Icosphere(2).ToPolyData(), WriteDeformer("normalization.model"));
  filter->SetNormalizationCenter(0.0, std::nan(""), 0.0);
  ASSERT_TRUE(Update(filter)) << "without an area, no center is used";
  filter->SetNormalizationArea(12.0);
  EXPECT_THAT(ErrorOf(filter), AllOf(HasSubstr("the center (0, nan, 0)"), HasSubstr("finite")));
}

TEST(FlowMatchingMessages, SeveralComponentsAreTakenWhenTheyAreCoupled)
{
  const auto filter = DeformerOn(TwoSpheres().ToPolyData(), WriteDeformer("coupled.model"));
  filter->ComponentCouplingOn();
  filter->SetCouplingDistance(1e-3);
  EXPECT_THAT(ErrorOf(filter), AllOf(HasSubstr("farther than the coupling distance, 0.0002"), HasSubstr("at point")));
  filter->SetCouplingDistance(10.0);
  ASSERT_TRUE(Update(filter));
  EXPECT_EQ(filter->GetNumberOfFactorizations(), 1);
  filter->SetCouplingWeight(1e5);
  ASSERT_TRUE(Update(filter));
  EXPECT_EQ(filter->GetNumberOfFactorizations(), 2);
  filter->ComponentCouplingOff();
  EXPECT_THAT(ErrorOf(filter), HasSubstr("2 connected components"));
}

TEST(FlowMatchingMessages, InconsistentWinding)
{
  Soup sphere = Icosphere(2);
  std::swap(sphere.Polys[7][0], sphere.Polys[7][1]);
  EXPECT_THAT(ErrorOfMesh(sphere), AllOf(HasSubstr("3 edge(s)"), HasSubstr("vtkPolyDataNormals")));
}

TEST(FlowMatchingMessages, AMeshUnlikeTheTrainingShapeIsAWarningOnceForEachMesh)
{
  const auto flat = Grid(6).ToPolyData();
  const auto filter = DeformerOn(flat, WriteDeformer("unlike.model")); // trained on a sphere
  EXPECT_THAT(
    WarningsOf(filter), ElementsAre(AllOf(HasSubstr("shaped or turned unlike"), HasSubstr("second moments"))));
  filter->SetSeed(2);
  EXPECT_THAT(WarningsOf(filter), IsEmpty()) << "it has been said";
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, Icosphere(1).ToPolyData());
  blocks->SetBlock(1, flat);
  filter->SetInputDataObject(blocks);
  EXPECT_THAT(WarningsOf(filter), ElementsAre(HasSubstr("Block 2: ")));
}

TEST(FlowMatchingMessages, FacesThatPointInwardsAreAWarning)
{
  Soup sphere = Icosphere(2);
  for (auto& polygon : sphere.Polys)
  {
    std::swap(polygon[0], polygon[1]);
  }
  EXPECT_THAT(WarningsOf(DeformerOn(sphere.ToPolyData(), WriteDeformer("inwards.model"))),
    ElementsAre(AllOf(HasSubstr("point inwards"), HasSubstr("vtkPolyDataNormals"))));
}

// --- Names -----------------------------------------------------------------------------------------------------------

TEST(FlowMatchingMessages, GivenNoiseThatDoesNotFit)
{
  const auto surface = Icosphere(1).ToPolyData();
  const auto filter = DeformerOn(surface, WriteDeformer("noise.model"));
  filter->SetInputNoiseArrayName("Missing");
  EXPECT_THAT(ErrorOf(filter), AllOf(HasSubstr("no point array \"Missing\""), HasSubstr("InputNoiseArrayName")));
  vtkNew<vtkDoubleArray> scalars;
  scalars->SetName("Scalars");
  scalars->SetNumberOfTuples(surface->GetNumberOfPoints());
  scalars->Fill(0.0);
  surface->GetPointData()->AddArray(scalars);
  filter->SetInputNoiseArrayName("Scalars");
  EXPECT_THAT(ErrorOf(filter), AllOf(HasSubstr("has 1 component"), HasSubstr("needs one with 3 components")));
  vtkNew<vtkDoubleArray> broken;
  broken->SetName("Broken");
  broken->SetNumberOfComponents(3);
  broken->SetNumberOfTuples(surface->GetNumberOfPoints());
  broken->Fill(0.0);
  broken->SetComponent(7, 1, std::nan(""));
  surface->GetPointData()->AddArray(broken);
  filter->SetInputNoiseArrayName("Broken");
  EXPECT_THAT(ErrorOf(filter), HasSubstr("not finite in single precision at point 7"));
  broken->Fill(0.0);
  filter->SetNumberOfSamples(2);
  EXPECT_THAT(ErrorOf(filter), HasSubstr("NumberOfSamples must be 1"));
}

TEST(FlowMatchingMessages, NamesThatAreEmptyOrTheSame)
{
  const auto filter = DeformerOn(Icosphere(1).ToPolyData(), WriteDeformer("name.model"));
  filter->SetDisplacementArrayName("");
  EXPECT_THAT(ErrorOf(filter), HasSubstr("DisplacementArrayName is empty"));
  filter->SetDisplacementArrayName("InitialNoise");
  EXPECT_THAT(ErrorOf(filter), AllOf(HasSubstr("\"InitialNoise\""), HasSubstr("different names")));
  filter->SetDisplacementArrayName("Displacement");
  filter->SetAreaRatioArrayName("");
  EXPECT_THAT(ErrorOf(filter), HasSubstr("AreaRatioArrayName is empty"));
  const auto sampler = SamplerOn(Icosphere(1).ToPolyData(), WriteSignalModel("name2.model"));
  sampler->SetInitialNoiseArrayName("");
  EXPECT_THAT(ErrorOf(sampler), HasSubstr("InitialNoiseArrayName is empty"));
  sampler->SetInitialNoiseArrayName("Mixture"); // the name in the model file
  EXPECT_THAT(ErrorOf(sampler), AllOf(HasSubstr("\"Mixture\""), HasSubstr("different names")));
}
