// SPDX-License-Identifier: BSD-3-Clause
//
// Output of vtkElasticRestFilter: rest states of small bodies.
#include "ExampleVolumes.h"
#include "FilterChecks.h"
#include "FilterContract.h"
#include "VtkSurfaces.h"
#include "VtkVolumes.h"

#include "vtkElasticRestFilter.h"

#include <vtkCompositeDataSet.h>
#include <vtkDataArray.h>
#include <vtkFieldData.h>
#include <vtkFloatArray.h>
#include <vtkInformation.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPointSet.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkTable.h>
#include <vtkUnstructuredGrid.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

using namespace surfsynthtest;
using surfsynth::test::BoxOfTetrahedra;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

namespace
{
vtkSmartPointer<vtkUnstructuredGrid> Plank(int type = VTK_DOUBLE)
{
  return GridOf(BoxOfTetrahedra({ 5, 3, 2 }, { 1.0, 0.6, 0.3 }), type);
}

/// Samples of half a second, so that tests are quick.
vtkSmartPointer<vtkElasticRestFilter> Quick(vtkDataObject* input, int samples = 1)
{
  auto filter = vtkSmartPointer<vtkElasticRestFilter>::New();
  filter->SetInputDataObject(input);
  filter->SetNumberOfSamples(samples);
  filter->SetMaximumTime(0.4);
  return filter;
}

vtkPointSet* Sample(vtkElasticRestFilter* filter, unsigned int k)
{
  auto* output = vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0));
  return output && k < output->GetNumberOfBlocks() ? vtkPointSet::SafeDownCast(output->GetBlock(k)) : nullptr;
}

vtkDataArray* PointsOfFirst(vtkAlgorithm* filter)
{
  return Sample(vtkElasticRestFilter::SafeDownCast(filter), 0)->GetPoints()->GetData();
}

double Number(vtkPointSet* sample, const char* name) { return sample->GetFieldData()->GetArray(name)->GetTuple1(0); }
} // namespace

TEST(ElasticRest, StatesKeepWhatIsPromised)
{
  const auto plank = Plank();
  const auto filter = Quick(plank, 2);
  filter->SetMaximumTime(10.0);
  ASSERT_TRUE(Update(filter));
  double box[6];
  plank->GetBounds(box);
  for (unsigned int k = 0; k < 2; ++k)
  {
    vtkPointSet* state = Sample(filter, k);
    ASSERT_NE(state, nullptr);
    EXPECT_LE(Number(state, "ForceImbalance"), 1e-3);
    EXPECT_GT(Number(state, "SmallestVolumeRatio"), 0.0);
    EXPECT_LE(Number(state, "EnergyRise"), 1e-12);
    EXPECT_LT(Number(state, "SettlingTime"), 10.0);
    EXPECT_EQ(Number(state, "FloorHeight"), box[4]);
    double bounds[6];
    state->GetBounds(bounds);
    EXPECT_GE(bounds[4], box[4]);
    EXPECT_LT(bounds[4], box[4] + 5e-3) << "it lies on the floor";
    EXPECT_GT(bounds[1] - bounds[0], 0.9) << "its long axis is that of the input";
  }
}

TEST(ElasticRest, KeepsArraysAndPrecisionAndDropsNormals)
{
  for (const int type : { VTK_FLOAT, VTK_DOUBLE })
  {
    const auto plank = Plank(type);
    vtkNew<vtkFloatArray> normals;
    normals->SetNumberOfComponents(3);
    normals->SetNumberOfTuples(plank->GetNumberOfPoints());
    normals->Fill(1.0);
    plank->GetPointData()->SetNormals(normals);
    vtkNew<vtkFloatArray> others; // not active, but known by their name
    others->DeepCopy(normals);
    others->SetName("Normals");
    plank->GetPointData()->AddArray(others);
    vtkNew<vtkFloatArray> heat;
    heat->SetName("heat");
    heat->SetNumberOfTuples(plank->GetNumberOfPoints());
    heat->Fill(2.0);
    plank->GetPointData()->AddArray(heat);
    const auto filter = Quick(plank);
    filter->SetDisplacementArrayName("moved");
    ASSERT_TRUE(Update(filter));
    vtkPointSet* state = Sample(filter, 0);
    ASSERT_NE(state, nullptr);
    EXPECT_TRUE(state->IsA("vtkUnstructuredGrid"));
    EXPECT_EQ(state->GetPoints()->GetDataType(), type);
    EXPECT_FALSE(state->GetPointData()->GetNormals());
    EXPECT_FALSE(state->GetPointData()->HasArray("Normals"));
    EXPECT_TRUE(state->GetPointData()->GetArray("heat"));
    EXPECT_TRUE(plank->GetPointData()->GetNormals()) << "the input is not changed";
    EXPECT_FALSE(plank->GetFieldData()->GetArray("FloorHeight"));
    vtkDataArray* moved = state->GetPointData()->GetArray("moved");
    ASSERT_TRUE(moved);
    for (vtkIdType p = 0; p < state->GetNumberOfPoints(); ++p)
    {
      for (int c = 0; c < 3; ++c)
      {
        EXPECT_NEAR(plank->GetPoint(p)[c] + moved->GetComponent(p, c), state->GetPoint(p)[c], 1e-6);
      }
    }
  }
}

TEST(ElasticRest, HasTheSameBitsForEveryNumberOfThreadsAndAloneOrInABatch)
{
  const auto plank = Plank();
  const FilterMaker make = [&plank]() -> vtkSmartPointer<vtkAlgorithm> { return Quick(plank, 2); };
  ExpectSameBitsForAllThreads(make, PointsOfFirst);
  const auto both = Quick(plank, 2);
  const auto second = Quick(plank);
  second->SetFirstSample(1);
  ASSERT_TRUE(Update(both) && Update(second));
  EXPECT_TRUE(SameBits(Sample(both, 1)->GetPoints()->GetData(), Sample(second, 0)->GetPoints()->GetData()));
  EXPECT_FALSE(SameBits(Sample(both, 0)->GetPoints()->GetData(), Sample(second, 0)->GetPoints()->GetData()));
}

TEST(ElasticRest, PreparesABodyOnce)
{
  const auto filter = Quick(Plank());
  ASSERT_TRUE(Update(filter));
  filter->SetSeed(4);
  filter->SetYoungsModulus(2e4);
  ASSERT_TRUE(Update(filter));
  EXPECT_EQ(filter->GetNumberOfPreparations(), 1);
  filter->SetInputDataObject(GridOf(BoxOfTetrahedra({ 4, 3, 2 })));
  ASSERT_TRUE(Update(filter));
  EXPECT_EQ(filter->GetNumberOfPreparations(), 2);
}

TEST(ElasticRest, SurfacesFollowGivenTetrahedra)
{
  // A ball inside a box: its points lie in tetrahedra, and a point that no polygon uses stays if it is not finite.
  Soup ball = Icosphere(2);
  for (double& x : ball.Points)
  {
    x = 0.5 + 0.4 * x;
  }
  ball.AddPoint(0.0, 0.0, std::numeric_limits<double>::quiet_NaN());
  const auto surface = ball.ToPolyData();
  const auto filter = Quick(surface);
  filter->SetTetrahedraData(GridOf(BoxOfTetrahedra({ 3, 3, 3 })));
  ASSERT_TRUE(Update(filter));
  vtkPointSet* state = Sample(filter, 0);
  ASSERT_NE(state, nullptr);
  EXPECT_TRUE(state->IsA("vtkPolyData"));
  EXPECT_GT(state->GetPoint(0)[2], -1e-9);
  EXPECT_NE(state->GetPoint(0)[2], surface->GetPoint(0)[2]);
  filter->SetTetrahedraData(Plank());
  EXPECT_TRUE(Update(filter));
  EXPECT_EQ(filter->GetNumberOfPreparations(), 2);
}

TEST(ElasticRest, FallsAgainstTheDirectionUpwards)
{
  const auto plank = Plank();
  const auto filter = Quick(plank);
  double box[6];
  plank->GetBounds(box);
  for (const double length : { 2.0, 1e200, 1e-200 })
  {
    filter->SetUpDirection(-length, 0.0, 0.0);
    ASSERT_TRUE(Update(filter));
    double bounds[6];
    Sample(filter, 0)->GetBounds(bounds);
    EXPECT_NEAR(bounds[1], box[1], 5e-3) << "the floor is at the largest x; length " << length;
  }
}

TEST(ElasticRest, BlocksFallEachByItself)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, Plank());
  blocks->SetBlock(1, Plank());
  const auto filter = Quick(blocks);
  ASSERT_TRUE(Update(filter));
  auto* output = vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0));
  ASSERT_EQ(output->GetNumberOfBlocks(), 2u);
  vtkPointSet* states[2];
  for (unsigned int k = 0; k < 2; ++k)
  {
    auto* samples = vtkMultiBlockDataSet::SafeDownCast(output->GetBlock(k));
    ASSERT_TRUE(samples);
    states[k] = vtkPointSet::SafeDownCast(samples->GetBlock(0));
    ASSERT_TRUE(states[k]);
  }
  EXPECT_FALSE(SameBits(states[0]->GetPoints()->GetData(), states[1]->GetPoints()->GetData()));
}

TEST(ElasticRest, ShapesComeToTheRestStatesNextToThem)
{
  const auto plank = Plank();
  const auto drop = Quick(plank, 2);
  drop->SetMaximumTime(10.0);
  drop->SetSpread(1.5); // translations do not matter
  ASSERT_TRUE(Update(drop));
  for (const int port : { 0, 1 })
  {
    const auto settle = Quick(plank, 5);
    settle->SetFirstSample(3);
    port == 0 ? settle->SetShapesConnection(drop->GetOutputPort()) : settle->SetShapesData(Sample(drop, 0));
    ASSERT_TRUE(Update(settle));
    auto* output = vtkMultiBlockDataSet::SafeDownCast(settle->GetOutputDataObject(0));
    ASSERT_EQ(output->GetNumberOfBlocks(), port == 0 ? 2u : 1u);
    EXPECT_STREQ(output->GetMetaData(0u)->Get(vtkCompositeDataSet::NAME()), "Sample 3");
    vtkPointSet* state = Sample(settle, 0);
    EXPECT_LE(Number(state, "ForceImbalance"), 1e-3);
    EXPECT_EQ(Number(state, "SettlingTime"), 0.0);
    for (vtkIdType p = 0; p < plank->GetNumberOfPoints(); ++p)
    {
      for (int c = 0; c < 3; ++c)
      {
        const double offset = Sample(drop, 0)->GetFieldData()->GetArray("Translation")->GetComponent(0, c);
        EXPECT_NEAR(state->GetPoint(p)[c], Sample(drop, 0)->GetPoint(p)[c] - offset, 5e-3) << p;
      }
    }
  }
}

TEST(ElasticRest, ShapesStandInThePlacesOfTheirBlocks)
{
  const auto plank = Plank();
  vtkNew<vtkMultiBlockDataSet> inner, bodies;
  inner->SetBlock(0, plank);
  bodies->SetBlock(0, plank);
  bodies->SetBlock(1, nullptr);
  bodies->SetBlock(2, inner);
  const auto drop = Quick(bodies, 2);
  ASSERT_TRUE(Update(drop));
  const auto settle = Quick(bodies);
  settle->SetShapesConnection(drop->GetOutputPort());
  ASSERT_TRUE(Update(settle));
  const auto at = [](vtkAlgorithm* filter, unsigned int block) {
    auto* output = vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0))->GetBlock(block);
    auto* tree = vtkMultiBlockDataSet::SafeDownCast(output);
    return block == 0 ? tree : vtkMultiBlockDataSet::SafeDownCast(tree->GetBlock(0));
  };
  for (const unsigned int block : { 0U, 2U })
  {
    const auto alone = Quick(plank);
    alone->SetShapesData(at(drop, block));
    ASSERT_TRUE(Update(alone));
    ASSERT_EQ(at(settle, block)->GetNumberOfBlocks(), 2U);
    auto* state = vtkPointSet::SafeDownCast(at(settle, block)->GetBlock(1));
    EXPECT_TRUE(SameBits(state->GetPoints()->GetData(), Sample(alone, 1)->GetPoints()->GetData())) << block;
  }
  settle->SetMemoryLimit(1);
  vtkNew<vtkMultiBlockDataSet> many, shapes;
  for (unsigned int k = 0; k < 1000; ++k)
  {
    many->SetBlock(k, plank);
  }
  shapes->SetBlock(0, many);
  settle->SetShapesData(shapes);
  EXPECT_THAT(ErrorOf(settle), HasSubstr("A number of shapes of "));
}

TEST(ElasticRest, PointsThatNothingUsesDoNotMatterToShapes)
{
  const auto plank = Plank();
  const vtkIdType lost = plank->GetPoints()->InsertNextPoint(0.0, std::numeric_limits<double>::quiet_NaN(), 0.0);
  const auto filter = Quick(plank);
  filter->SetShapesData(plank);
  filter->SetDamping(1e4); // there is no momentum that it takes
  ASSERT_TRUE(Update(filter));
  EXPECT_TRUE(std::isnan(Sample(filter, 0)->GetPoint(lost)[1]));
  const auto whole = Quick(Plank());
  whole->SetShapesData(Plank());
  ASSERT_TRUE(Update(whole));
  for (vtkIdType p = 0; p < lost; ++p)
  {
    EXPECT_NEAR(Sample(filter, 0)->GetPoint(p)[2], Sample(whole, 0)->GetPoint(p)[2], 1e-9) << p;
  }
}

TEST(ElasticRest, SaysWhichShapeIsWrong)
{
  const auto plank = Plank();
  const auto filter = Quick(plank);
  const auto errorWith = [&filter](vtkDataObject* shapes) {
    filter->SetShapesData(shapes);
    return ErrorOf(filter);
  };
  EXPECT_THAT(errorWith(GridOf(BoxOfTetrahedra({ 1, 1, 1 }))), HasSubstr("8 points and the input has "));
  vtkNew<vtkMultiBlockDataSet> blocks;
  EXPECT_THAT(errorWith(blocks), HasSubstr("The shapes are empty"));
  vtkNew<vtkUnstructuredGrid> nothing;
  blocks->SetBlock(0, nothing);
  EXPECT_THAT(errorWith(blocks), HasSubstr("Block 1 of the shapes has 0 points"));
  const auto lost = Plank();
  lost->GetPoints()->SetPoint(4, 0.0, std::numeric_limits<double>::quiet_NaN(), 0.0);
  blocks->SetBlock(0, plank);
  blocks->SetBlock(1, lost);
  EXPECT_THAT(
    errorWith(blocks), AllOf(HasSubstr("Block 2 of the shapes"), HasSubstr("not finite"), HasSubstr("point 4")));
  const auto huge = Plank();
  for (vtkIdType p = 0; p < huge->GetNumberOfPoints(); ++p)
  {
    const double* x = plank->GetPoint(p);
    huge->GetPoints()->SetPoint(p, 1e30 * x[0], 1e30 * x[1], 1e30 * x[2]);
  }
  blocks->SetBlock(1, huge);
  EXPECT_THAT(errorWith(blocks), AllOf(HasSubstr("Sample 1: "), HasSubstr("no rest state next to this shape")));
  vtkNew<vtkTable> table;
  blocks->SetBlock(1, table);
  EXPECT_THAT(errorWith(blocks), HasSubstr("Block 2 of the shapes is a vtkTable"));
  vtkNew<vtkMultiBlockDataSet> bodies;
  bodies->SetBlock(0, plank);
  filter->SetInputDataObject(bodies);
  EXPECT_THAT(
    errorWith(plank), HasSubstr("1 of the shapes stand in no place of a block of the input; expected a comp"));
  blocks->SetBlock(1, plank);
  EXPECT_THAT(errorWith(blocks), HasSubstr("1 of the shapes stand in no place of a block of the input")) << "one body";
  bodies->SetBlock(1, plank);
  blocks->SetBlock(1, nullptr);
  filter->SetShapesData(blocks);
  EventRecorder events(filter);
  Update(filter); // blocks that fail are left empty
  EXPECT_THAT(
    events.AllErrors(), HasSubstr("Block 2: There are no shapes in the place of this block; expected a comp"));
  filter->SetInputDataObject(plank);
  filter->SetMemoryLimit(1);
  vtkNew<vtkMultiBlockDataSet> many;
  for (unsigned int k = 0; k < 1000; ++k)
  {
    many->SetBlock(k, plank);
  }
  EXPECT_THAT(errorWith(many), HasSubstr("A number of shapes of "));
  filter->SetMemoryLimit(0);
  filter->RemoveShapes();
  EXPECT_TRUE(Update(filter));
}

TEST(ElasticRest, StopsAndHasTheSameBitsWithShapes)
{
  const auto plank = Plank();
  vtkNew<vtkMultiBlockDataSet> shapes;
  for (unsigned int k = 0; k < 8; ++k)
  {
    const auto shape = Plank();
    for (vtkIdType p = 0; p < shape->GetNumberOfPoints(); ++p)
    {
      const double* x = plank->GetPoint(p);
      shape->GetPoints()->SetPoint(p, x[0], x[1], x[2] + 0.05 * (k + 1) * x[0] * x[0]);
    }
    shapes->SetBlock(k, shape);
  }
  const FilterMaker make = [&]() -> vtkSmartPointer<vtkAlgorithm> {
    const auto filter = Quick(plank);
    filter->SetShapesData(shapes);
    return filter;
  };
  ExpectSameBitsForAllThreads(make, PointsOfFirst);
  const auto filter = make();
  ExpectAbort(filter, 0.3);
  ASSERT_TRUE(Update(filter));
  EXPECT_NE(Sample(vtkElasticRestFilter::SafeDownCast(filter), 7), nullptr);
}

TEST(ElasticRest, SaysWhatIsWrong)
{
#ifdef SURFACE_SYNTHESIS_ELASTIC_FILLING
  EXPECT_THAT(ErrorOf(Quick(Grid(3).ToPolyData())), HasSubstr("boundary"));
#else
  EXPECT_THAT(ErrorOf(Quick(Grid(3).ToPolyData())), HasSubstr("built without CGAL or TetGen"));
#endif
  auto flat = BoxOfTetrahedra({ 2, 2, 2 });
  flat.Points.col(2).setZero();
  EXPECT_THAT(ErrorOf(Quick(GridOf(flat))), HasSubstr("volume"));
  const auto filter = Quick(Plank());
  filter->SetMinimumSpin(5.0);
  filter->SetMaximumSpin(1.0);
  EXPECT_THAT(ErrorOf(filter), HasSubstr("MinimumSpin is above MaximumSpin"));
  filter->SetMinimumSpin(1.0);
  constexpr double Infinity = std::numeric_limits<double>::infinity();
  for (const double z : { 0.0, Infinity, -Infinity, std::numeric_limits<double>::quiet_NaN() })
  {
    filter->SetUpDirection(0.0, 0.0, z);
    EXPECT_THAT(ErrorOf(filter), HasSubstr("UpDirection is not finite, or has no length")) << z;
  }
  filter->SetUpDirection(0.0, 0.0, 1.0);
  filter->SetDisplacementArrayName("");
  EXPECT_THAT(ErrorOf(filter), HasSubstr("DisplacementArrayName is empty"));
  const auto ball = Quick(Icosphere(1).ToPolyData());
  ball->SetTetrahedraData(GridOf(flat));
  EXPECT_THAT(ErrorOf(ball), HasSubstr("The tetrahedra: "));
}

#ifdef SURFACE_SYNTHESIS_ELASTIC_FILLING
TEST(ElasticRest, SaysWhichSurfaceCannotBeFilled)
{
  // A shell whose two sides are nearer to each other than the chords of coarse triangles.
  Soup shell = Icosphere(3);
  const Soup outer = shell;
  for (const double x : outer.Points)
  {
    shell.Points.push_back(0.99 * x);
  }
  for (std::vector<vtkIdType> triangle : outer.Polys)
  {
    for (vtkIdType& p : triangle)
    {
      p += outer.NumberOfPoints();
    }
    shell.Polys.push_back(triangle);
  }
  const auto filter = Quick(shell.ToPolyData());
  filter->SetNumberOfSurfacePoints(40);
  EXPECT_THAT(ErrorOf(filter),
    AllOf(HasSubstr("remeshed to 40 points (NumberOfSurfacePoints) and"), HasSubstr("cannot be filled"),
      Not(HasSubstr("triangle")), Not(HasSubstr("TargetEdgeLength"))));
}
#endif

TEST(ElasticRest, EmptyInputGivesEmptyOutput)
{
  vtkNew<vtkUnstructuredGrid> nothing;
  const auto filter = Quick(nothing);
  ASSERT_TRUE(Update(filter));
  EXPECT_EQ(Sample(filter, 0), nullptr);
}

TEST(ElasticRest, ReportsAndStopsWhileManyPointsFollow)
{
  // Many points around few tetrahedra: most of the time goes into what follows the simulation.
  const auto filter = Quick(RingSphere(300, 300), 4);
  filter->SetMaximumTime(0.0);
  filter->SetTetrahedraData(GridOf(BoxOfTetrahedra({ 2, 2, 2 })));
  EventRecorder events(filter);
  ASSERT_TRUE(Update(filter));
  ExpectMonotone(events.Progress);
  // Four samples follow, and four are copied, the last of them to the end.
  const auto isLate = [](double fraction) { return fraction > 0.941 && fraction < 1.0; };
  EXPECT_EQ(std::count_if(events.Progress.begin(), events.Progress.end(), isLate), 7);
  EXPECT_EQ(events.Progress.back(), 1.0);
  for (const double fraction : { 0.95, 0.98 })
  {
    filter->SetSeed(filter->GetSeed() + 1);
    ExpectAbort(filter, fraction);
  }
}

TEST(ElasticRest, AnAbortLeavesNothingAndTheNextUpdateIsComplete)
{
  const auto filter = Quick(Plank(), 12);
  ExpectAbort(filter, 0.3);
  filter->SetNumberOfSamples(1);
  ASSERT_TRUE(Update(filter));
  EXPECT_NE(Sample(filter, 0), nullptr);
}

TEST(ElasticRest, PrintsItsProperties)
{
  vtkNew<vtkElasticRestFilter> filter;
  std::ostringstream text;
  filter->Print(text);
  for (const char* name : { "Seed: 0", "NumberOfSamples: 6", "NumberOfSurfacePoints: 500", "LengthUnit: 0",
         "YoungsModulus: 10000", "PoissonsRatio: 0.4", "Density: 1000", "Friction: 0.5", "Gravity: 9.81",
         "Damping: 0.5", "DropHeight: 0.1", "MinimumSpin: 3.14159", "MaximumSpin: 9.42478", "UpDirection: (0, 0, 1)",
         "TimeStep: 0.04", "MaximumTime: 10", "DisplacementArrayName: Displacement", "NumberOfPreparations: 0" })
  {
    EXPECT_THAT(text.str(), HasSubstr(name));
  }
}
