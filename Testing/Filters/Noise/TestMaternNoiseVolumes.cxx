// SPDX-License-Identifier: BSD-3-Clause
//
// vtkMaternNoiseFilter on volumes of tetrahedra in unstructured grids.
#include "ExampleVolumes.h"
#include "FilterChecks.h"
#include "VtkSurfaces.h"
#include "VtkVolumes.h"

#include "vtkMaternNoiseFilter.h"

#include "Core/Noise/MaternField.h"

#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkDataSet.h>
#include <vtkDoubleArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

using namespace surfsynthtest;
using surfsynth::TetrahedralMesh;
using surfsynth::test::BoxOfTetrahedra;
using testing::HasSubstr;
using Grid3 = vtkSmartPointer<vtkUnstructuredGrid>;

namespace
{
TetrahedralMesh Box() { return BoxOfTetrahedra({ 8, 6, 5 }, { 1.0, 0.8, 0.6 }, 0.1); }

vtkSmartPointer<vtkMaternNoiseFilter> FilterOn(vtkDataObject* input, double range = 0.8)
{
  auto filter = vtkSmartPointer<vtkMaternNoiseFilter>::New();
  filter->SetInputDataObject(input);
  filter->SetCorrelationRange(range);
  return filter;
}

vtkUnstructuredGrid* GridFrom(vtkMaternNoiseFilter* filter)
{
  return vtkUnstructuredGrid::SafeDownCast(filter->GetOutputDataObject(0));
}

vtkDataArray* ArrayOf(vtkDataObject* data, const char* name)
{
  vtkDataArray* array = vtkDataSet::SafeDownCast(data)->GetPointData()->GetArray(name);
  EXPECT_TRUE(array) << name;
  return array;
}

/// The only error of an update, whose output is empty.
std::string ErrorOf(vtkMaternNoiseFilter* filter)
{
  EventRecorder events(filter);
  filter->Update();
  EXPECT_EQ(events.Errors.size(), 1U) << events.AllErrors();
  EXPECT_EQ(GridFrom(filter)->GetNumberOfPoints(), 0);
  return events.AllErrors();
}

/// Adds an array of one component with value(k) for each of @p count tuples.
void AddValues(vtkFieldData* data, const char* name, vtkIdType count, const std::function<double(vtkIdType)>& value)
{
  vtkNew<vtkDoubleArray> array;
  array->SetName(name);
  for (vtkIdType k = 0; k < count; ++k)
  {
    array->InsertNextValue(value(k));
  }
  data->AddArray(array);
}

/// Two observations inside the box, with values 1.5 and -2.
vtkSmartPointer<vtkPolyData> Observed(double shift = 0.0)
{
  auto data = vtkSmartPointer<vtkPolyData>::New();
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->InsertNextPoint(0.31 + shift, 0.42, 0.23);
  points->InsertNextPoint(0.77 + shift, 0.15, 0.41);
  data->SetPoints(points);
  AddValues(data->GetPointData(), "Value", 2, [](vtkIdType k) { return k == 0 ? 1.5 : -2.0; });
  return data;
}
} // namespace

TEST(MaternNoiseVolumes, AreTheInputWithTheSamplesOfTheCore)
{
  for (const int type : { VTK_DOUBLE, VTK_FLOAT })
  {
    const auto grid = GridOf(Box(), type);
    AddValues(grid->GetCellData(), "Region", grid->GetNumberOfCells(), [](vtkIdType k) { return double(k); });
    const auto hash = HashOf(grid);
    const auto filter = FilterOn(grid);
    filter->SetNumberOfSamples(3);
    filter->SetSeed(7);
    filter->SetStandardDeviation(2.5);
    vtkUnstructuredGrid* output = vtkUnstructuredGrid::SafeDownCast(OutputOf(filter));
    ASSERT_TRUE(output);
    EXPECT_EQ(HashOf(grid), hash) << "the input is not modified";
    EXPECT_EQ(output->GetNumberOfCells(), grid->GetNumberOfCells());
    EXPECT_TRUE(output->GetCellData()->GetArray("Region"));
    EXPECT_EQ(output->GetPointData()->GetNumberOfArrays(), 3);
    EXPECT_STREQ(output->GetPointData()->GetScalars()->GetName(), "MaternNoise_0");
    EXPECT_STREQ(filter->GetSolverName(), "Cholesky");
    EXPECT_DOUBLE_EQ(filter->GetEffectiveScreening(), 8.0 * 0.5 / 0.64) << "nu = 1/2";
    if (type == VTK_DOUBLE)
    {
      surfsynth::MaternFieldOptions options;
      options.CorrelationRange = 0.8;
      surfsynth::SampleRequest request;
      request.Seed = 7;
      request.FirstSample = 2;
      request.Scale = 2.5;
      const Eigen::MatrixXd expected = surfsynth::MaternField(Box(), options).Sample(request);
      for (vtkIdType p = 0; p < grid->GetNumberOfPoints(); ++p)
      {
        EXPECT_EQ(ArrayOf(output, "MaternNoise_2")->GetComponent(p, 0), expected(p, 0));
      }
    }
  }
}

TEST(MaternNoiseVolumes, AreFactoredOnceForAllSeedsAndValuesOfObservations)
{
  const auto observations = Observed();
  const auto filter = FilterOn(GridOf(Box()));
  filter->SetInputDataObject(1, observations);
  filter->SetObservationArray("Value");
  ASSERT_TRUE(Update(filter));
  filter->SetSeed(1);
  ASSERT_TRUE(Update(filter));
  vtkDoubleArray::SafeDownCast(observations->GetPointData()->GetArray("Value"))->SetValue(0, -1.0);
  observations->GetPointData()->GetArray("Value")->Modified();
  observations->Modified();
  ASSERT_TRUE(Update(filter));
  EXPECT_EQ(filter->GetNumberOfFactorizations(), 1);
  filter->SetCorrelationRange(0.9);
  ASSERT_TRUE(Update(filter));
  EXPECT_EQ(filter->GetNumberOfFactorizations(), 2);
}

TEST(MaternNoiseVolumes, TakeTheValuesOfObservationsInTetrahedra)
{
  const auto filter = FilterOn(GridOf(Box()));
  filter->SetInputDataObject(1, Observed());
  filter->SetObservationArray("Value");
  filter->PosteriorMeanOn();
  filter->PosteriorStandardDeviationOn();
  filter->SetNumberOfSamples(2);
  ASSERT_TRUE(Update(filter));
  vtkUnstructuredGrid* output = GridFrom(filter);
  const double places[2][3] = { { 0.31, 0.42, 0.23 }, { 0.77, 0.15, 0.41 } };
  for (int observation = 0; observation < 2; ++observation)
  {
    int subId = 0;
    double local[3];
    double weights[4];
    double place[3] = { places[observation][0], places[observation][1], places[observation][2] };
    const vtkIdType cell = output->FindCell(place, nullptr, 0, 1e-12, subId, local, weights);
    ASSERT_GE(cell, 0);
    for (const char* name : { "MaternNoise_0", "MaternNoise_1", "MaternNoise_Mean" })
    {
      double value = 0.0;
      for (int k = 0; k < 4; ++k)
      {
        value += weights[k] * ArrayOf(output, name)->GetComponent(output->GetCell(cell)->GetPointId(k), 0);
      }
      EXPECT_NEAR(value, observation == 0 ? 1.5 : -2.0, 1e-7) << name;
    }
  }
  double range[2];
  ArrayOf(output, "MaternNoise_StandardDeviation")->GetRange(range);
  EXPECT_GE(range[0], 0.0);
  EXPECT_LT(range[0], 0.8);
  filter->SetInputDataObject(1, Observed(5.0));
  EXPECT_THAT(ErrorOf(filter), HasSubstr("2 observations are farther from the volume than the Tolerance of 0.01"));
}

TEST(MaternNoiseVolumes, ReadArraysOfPointsAndCells)
{
  const auto grid = GridOf(Box());
  vtkNew<vtkDoubleArray> directions;
  directions->SetName("Direction");
  directions->SetNumberOfComponents(3);
  for (vtkIdType p = 0; p < grid->GetNumberOfPoints(); ++p)
  {
    directions->InsertNextTuple3(0.0, 1.0, 0.0);
  }
  grid->GetPointData()->AddArray(directions);
  AddValues(grid->GetPointData(), "Factor", grid->GetNumberOfPoints(), [](vtkIdType k) { return k % 2 ? 1.0 : 1.2; });
  AddValues(grid->GetPointData(), "Mask", grid->GetNumberOfPoints(), [](vtkIdType k) { return k == 33 ? 1.0 : 0.0; });
  AddValues(grid->GetCellData(), "Barrier", grid->GetNumberOfCells(), [](vtkIdType k) { return k < 6 ? 1.0 : 0.0; });
  const auto filter = FilterOn(grid);
  filter->SetDirectionArrayName("Direction");
  filter->SetRangeFactorArrayName("Factor");
  filter->SetBarrierArrayName("Barrier");
  filter->SetBoundaryArrayName("Mask");
  filter->SetBoundaryConditionToDirichlet();
  filter->VarianceCorrectionOn();
  ASSERT_TRUE(Update(filter));
  vtkDataArray* noise = ArrayOf(GridFrom(filter), "MaternNoise");
  EXPECT_EQ(noise->GetComponent(33, 0), 0.0) << "the masked point";
  EXPECT_EQ(noise->GetComponent(0, 0), 0.0) << "the corner that only tetrahedra of the barrier use";
  EXPECT_NE(noise->GetComponent(100, 0), 0.0);
}

TEST(MaternNoiseVolumes, IgnoreTrianglesBesideTetrahedra)
{
  const TetrahedralMesh mesh = Box();
  auto mixed = Grid3::New();
  const auto plain = GridOf(mesh);
  mixed->SetPoints(plain->GetPoints());
  const vtkIdType triangle[3] = { 0, 1, 2 };
  mixed->InsertNextCell(VTK_TRIANGLE, 3, triangle);
  for (vtkIdType t = 0; t < plain->GetNumberOfCells(); ++t)
  {
    mixed->InsertNextCell(VTK_TETRA, plain->GetCell(t)->GetPointIds());
  }
  AddValues(plain->GetCellData(), "Barrier", plain->GetNumberOfCells(), [](vtkIdType k) { return k < 30 ? 1.0 : 0.0; });
  AddValues(mixed->GetCellData(), "Barrier", mixed->GetNumberOfCells(), [](vtkIdType k) { return k < 31 ? 1.0 : 0.0; });
  const auto expected = FilterOn(plain);
  const auto filter = FilterOn(mixed);
  expected->SetBarrierArrayName("Barrier");
  filter->SetBarrierArrayName("Barrier");
  ASSERT_TRUE(Update(expected));
  ASSERT_TRUE(Update(filter));
  EXPECT_TRUE(SameBits(ArrayOf(GridFrom(filter), "MaternNoise"), ArrayOf(GridFrom(expected), "MaternNoise")));
  EXPECT_EQ(GridFrom(filter)->GetNumberOfCells(), mixed->GetNumberOfCells());
}

TEST(MaternNoiseVolumes, NameWhatTheGateRefuses)
{
  const auto hexahedra = GridOf(Box());
  const vtkIdType ids[8] = { 0, 1, 2, 3, 4, 5, 6, 7 };
  hexahedra->InsertNextCell(VTK_HEXAHEDRON, 8, ids);
  hexahedra->InsertNextCell(VTK_HEXAHEDRON, 8, ids);
  EXPECT_THAT(ErrorOf(FilterOn(hexahedra)),
    HasSubstr("cells that are no tetrahedra (1440 Tetra, 2 Hexahedron); vtkDataSetTriangleFilter divides other"));
  TetrahedralMesh flat = Box();
  flat.Points.row(0) = flat.Points.row(1);
  EXPECT_THAT(ErrorOf(FilterOn(GridOf(flat))), HasSubstr("degenerate tetrahedra, without volume, first cell 0"));
  TetrahedralMesh undefined = Box();
  undefined.Points(4, 2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(ErrorOf(FilterOn(GridOf(undefined))), HasSubstr("not finite, first point 4"));
  const auto outOfRange = GridOf(Box());
  const vtkIdType far[4] = { 0, 1, 2, 100000 };
  outOfRange->InsertNextCell(VTK_TETRA, 4, far);
  EXPECT_THAT(ErrorOf(FilterOn(outOfRange)), HasSubstr("first cell 1440"));
  const vtkIdType negative[4] = { 0, 1, 2, -5 };
  const auto below = GridOf(Box());
  below->InsertNextCell(VTK_TETRA, 4, negative);
  EXPECT_THAT(ErrorOf(FilterOn(below)), HasSubstr("name a point which does not exist"));
}

TEST(MaternNoiseVolumes, WarnOfInvertedTetrahedraBesideOthers)
{
  TetrahedralMesh mesh = Box();
  std::swap(mesh.Tetrahedra(3, 0), mesh.Tetrahedra(3, 1));
  const auto filter = FilterOn(GridOf(mesh));
  EventRecorder events(filter);
  filter->Update();
  EXPECT_TRUE(events.Errors.empty());
  ASSERT_EQ(events.Warnings.size(), 1U);
  EXPECT_THAT(events.Warnings[0], HasSubstr("1 of 1440 tetrahedra are inverted"));
  mesh.Tetrahedra.col(0).swap(mesh.Tetrahedra.col(1));
  std::swap(mesh.Tetrahedra(3, 0), mesh.Tetrahedra(3, 1));
  EXPECT_TRUE(Update(FilterOn(GridOf(mesh)))) << "all inverted: another convention, no warning";
}

TEST(MaternNoiseVolumes, RefuseWhatBelongsToSurfaces)
{
  const auto filter = FilterOn(GridOf(Box()));
  filter->CoherentNoiseOn();
  EXPECT_THAT(ErrorOf(filter), HasSubstr("coherent noise in a volume"));
  filter->CoherentNoiseOff();
  filter->SetOperatorPower(1);
  EXPECT_THAT(ErrorOf(filter), HasSubstr("in a volume alpha = 1 has the smoothness nu = -1/2, no finite variance"));
  filter->SetOperatorPower(2);
  filter->SetDisplacement(vtkMaternNoiseFilter::FREE);
  EXPECT_THAT(ErrorOf(filter), HasSubstr("Displacement moves surfaces, and the input is a volume"));
  filter->SetDisplacement(vtkMaternNoiseFilter::NO_DISPLACEMENT);
  EXPECT_TRUE(Update(filter)) << "the filter recovers";
}

TEST(MaternNoiseVolumes, WarnOfLongEdgesInWordsOfVolumes)
{
  const auto filter = FilterOn(GridOf(Box()), 0.1);
  filter->RefinementOn();
  EventRecorder events(filter);
  filter->Update();
  ASSERT_EQ(events.Warnings.size(), 1U);
  EXPECT_THAT(events.Warnings[0], HasSubstr("Fill the volume with smaller tetrahedra"));
  EXPECT_EQ(GridFrom(filter)->GetNumberOfCells(), 1440) << "Refinement divides triangles only";
}

TEST(MaternNoiseVolumes, AreSolvedByMultigridWhereTheFactorExceedsTheLimit)
{
  const auto grid = GridOf(BoxOfTetrahedra({ 14, 14, 14 }));
  const auto factored = FilterOn(grid);
  const auto iterated = FilterOn(grid);
  iterated->SetMemoryLimit(1);
  ASSERT_TRUE(Update(factored));
  ASSERT_TRUE(Update(iterated));
  EXPECT_STREQ(iterated->GetSolverName(), "Multigrid");
  EXPECT_GT(iterated->GetNumberOfIterations(), 0);
  EXPECT_LE(
    LargestDifference(ArrayOf(GridFrom(factored), "MaternNoise"), ArrayOf(GridFrom(iterated), "MaternNoise")), 1e-7);
  iterated->VarianceCorrectionOn();
  EXPECT_THAT(ErrorOf(iterated), HasSubstr("the Cholesky factor, with variance correction"));
}

TEST(MaternNoiseVolumes, AreLeftEmptyByAnAbortAndUpdatedAgain)
{
  const auto filter = FilterOn(GridOf(BoxOfTetrahedra({ 14, 14, 14 })));
  filter->SetNumberOfSamples(40);
  {
    EventRecorder events(filter);
    events.AbortAt = 0.05;
    filter->Update();
    EXPECT_TRUE(events.Errors.empty()) << events.AllErrors();
    EXPECT_EQ(GridFrom(filter)->GetNumberOfPoints(), 0);
  }
  EventRecorder events(filter);
  filter->Update();
  EXPECT_EQ(GridFrom(filter)->GetPointData()->GetNumberOfArrays(), 40);
  ASSERT_FALSE(events.Progress.empty());
  EXPECT_TRUE(std::is_sorted(events.Progress.begin(), events.Progress.end()));
}

TEST(MaternNoiseVolumes, OfNothingAreEmptyAndGridsOfTrianglesAreSurfaces)
{
  vtkNew<vtkUnstructuredGrid> nothing;
  EXPECT_TRUE(Update(FilterOn(nothing)));
  const auto surface = Icosphere(2).ToPolyData();
  auto grid = Grid3::New();
  grid->SetPoints(surface->GetPoints());
  grid->SetCells(VTK_TRIANGLE, surface->GetPolys());
  const auto filter = FilterOn(grid, 1.0);
  const auto expected = FilterOn(surface, 1.0);
  ASSERT_TRUE(Update(filter));
  ASSERT_TRUE(Update(expected));
  ASSERT_TRUE(GridFrom(filter)) << "the output has the class of the input";
  EXPECT_EQ(GridFrom(filter)->GetNumberOfCells(), grid->GetNumberOfCells());
  EXPECT_TRUE(
    SameBits(ArrayOf(GridFrom(filter), "MaternNoise"), ArrayOf(expected->GetOutputDataObject(0), "MaternNoise")));
  filter->RefinementOn();
  filter->SetCorrelationRange(0.5);
  ASSERT_TRUE(Update(filter));
  EXPECT_GT(GridFrom(filter)->GetNumberOfCells(), grid->GetNumberOfCells());
  EXPECT_EQ(ArrayOf(GridFrom(filter), "MaternNoise")->GetNumberOfTuples(), GridFrom(filter)->GetNumberOfPoints());
  filter->RefinementOff();
  filter->SetDisplacement(vtkMaternNoiseFilter::NORMAL);
  filter->MovedPointsOn();
  filter->SetStandardDeviation(0.05);
  ASSERT_TRUE(Update(filter));
  double largest = 0.0;
  for (vtkIdType p = 0; p < grid->GetNumberOfPoints(); ++p)
  {
    double moved[3];
    double old[3];
    GridFrom(filter)->GetPoint(p, moved);
    grid->GetPoint(p, old);
    const double* move = ArrayOf(GridFrom(filter), "MaternNoise")->GetTuple3(p);
    for (int c = 0; c < 3; ++c)
    {
      ASSERT_NEAR(moved[c] - old[c], move[c], 1e-6) << p;
      largest = std::max(largest, std::abs(move[c]));
    }
  }
  EXPECT_GT(largest, 0.05) << "the points of a grid move";
}
