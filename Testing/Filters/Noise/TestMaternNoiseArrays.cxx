// SPDX-License-Identifier: BSD-3-Clause
//
// Operator power, variance correction, boundary conditions and arrays of vtkMaternNoiseFilter.
#include "FilterContract.h"
#include "VtkSurfaces.h"

#include "vtkMaternNoiseFilter.h"

#include "Core/Noise/MaternField.h"
#include "SurfaceBridge.h"

#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkIntArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

using namespace surfsynthtest;
using ::testing::AllOf;
using ::testing::HasSubstr;

namespace
{
using Noise = vtkMaternNoiseFilter;

/// An open patch with the arrays "factor", "direction", "mask" (points) and
/// "barrier" (cells).
vtkSmartPointer<vtkPolyData> SurfaceWithArrays()
{
  auto surface = Grid(16).ToPolyData();
  const auto add = [](vtkDataSetAttributes* data, vtkDataArray* array, const char* name, int components,
                     vtkIdType count, const std::function<double(vtkIdType, int)>& value) {
    array->SetName(name);
    array->SetNumberOfComponents(components);
    array->SetNumberOfTuples(count);
    for (vtkIdType k = 0; k < count; ++k)
    {
      for (int c = 0; c < components; ++c)
      {
        array->SetComponent(k, c, value(k, c));
      }
    }
    data->AddArray(array);
  };
  const vtkIdType points = surface->GetNumberOfPoints();
  const auto x = [&surface](vtkIdType p) { return surface->GetPoint(p)[0]; };
  add(surface->GetPointData(), vtkNew<vtkFloatArray>(), "factor", 1, points,
    [&](vtkIdType p, int) { return 1.0 + 0.25 * x(p); });
  add(surface->GetPointData(), vtkNew<vtkDoubleArray>(), "direction", 3, points, [](vtkIdType, int c) {
    return c == 0 ? 2.0 : c == 1 ? -1.0 : 0.5;
  });
  add(surface->GetPointData(), vtkNew<vtkIntArray>(), "mask", 1, points, [](vtkIdType p, int) { return p % 5 == 0; });
  add(surface->GetCellData(), vtkNew<vtkIntArray>(), "barrier", 1, surface->GetNumberOfCells(),
    [](vtkIdType c, int) { return c % 7 == 0; });
  return surface;
}

vtkSmartPointer<Noise> FilterOn(vtkDataObject* input)
{
  auto filter = vtkSmartPointer<Noise>::New();
  filter->SetInputDataObject(input);
  filter->SetCorrelationRange(1.0);
  return filter;
}

void UseAllArrays(Noise* filter)
{
  filter->SetOperatorPower(3);
  filter->VarianceCorrectionOn();
  filter->SetBoundaryConditionToDirichlet();
  filter->SetBoundaryArrayName("mask");
  filter->SetRangeFactorArrayName("factor");
  filter->SetDirectionArrayName("direction");
  filter->SetAnisotropyRatio(3.0);
  filter->SetBarrierArrayName("barrier");
}

std::string ErrorWith(const std::function<void(vtkPolyData*, Noise*)>& change)
{
  const auto surface = SurfaceWithArrays();
  const auto filter = FilterOn(surface);
  change(surface, filter);
  return ErrorOf(filter);
}
} // namespace

// Refinement interpolates arrays; a mask is not to spread.
TEST(MaternNoiseArrays, ARefinedMaskHoldsBetweenItsPointsOnly)
{
  auto surface = Grid(4).ToPolyData();
  vtkNew<vtkIntArray> mask;
  mask->SetName("mask");
  double bounds[6];
  surface->GetBounds(bounds);
  for (vtkIdType p = 0; p < surface->GetNumberOfPoints(); ++p)
  {
    mask->InsertNextValue(surface->GetPoint(p)[0] == bounds[0] ? 7 : 0); // one side
  }
  surface->GetPointData()->AddArray(mask);
  const auto filter = FilterOn(surface);
  filter->RefinementOn();
  filter->SetCorrelationRange(0.3 * (bounds[1] - bounds[0]));
  filter->SetBoundaryConditionToDirichlet();
  filter->SetBoundaryArrayName("mask");
  ASSERT_TRUE(Update(filter));
  auto* output = vtkPolyData::SafeDownCast(filter->GetOutputDataObject(0));
  ASSERT_GT(output->GetNumberOfPoints(), 2 * surface->GetNumberOfPoints());
  vtkDataArray* noise = output->GetPointData()->GetArray("MaternNoise");
  for (vtkIdType p = 0; p < output->GetNumberOfPoints(); ++p)
  {
    EXPECT_EQ(noise->GetComponent(p, 0) == 0.0, output->GetPoint(p)[0] == bounds[0]) << p;
  }
}

// The sign of a direction does not matter: d and -d are one axis, whose mean is no zero.
TEST(MaternNoiseArrays, RefinedDirectionsAreAxes)
{
  auto surface = Grid(4).ToPolyData();
  vtkNew<vtkDoubleArray> directions;
  directions->SetName("direction");
  directions->SetNumberOfComponents(3);
  for (vtkIdType p = 0; p < surface->GetNumberOfPoints(); ++p)
  {
    const double sign = p % 2 == 0 ? 1.0 : -1.0;
    directions->InsertNextTuple3(sign * 0.6, sign * 0.8, 0.0);
  }
  surface->GetPointData()->AddArray(directions);
  const auto filter = FilterOn(surface);
  filter->RefinementOn();
  filter->SetCorrelationRange(0.3);
  filter->SetDirectionArrayName("direction");
  ASSERT_TRUE(Update(filter));
  auto* output = vtkPolyData::SafeDownCast(filter->GetOutputDataObject(0));
  ASSERT_GT(output->GetNumberOfPoints(), 2 * surface->GetNumberOfPoints());
  EXPECT_EQ(output->GetPointData()->GetNumberOfArrays(), 2);
  vtkDataArray* refined = output->GetPointData()->GetArray("direction");
  for (vtkIdType p = 0; p < output->GetNumberOfPoints(); ++p)
  {
    const double along = 0.6 * refined->GetComponent(p, 0) + 0.8 * refined->GetComponent(p, 1);
    EXPECT_NEAR(std::abs(along), 1.0, 1e-12) << p;
    EXPECT_NEAR(0.8 * refined->GetComponent(p, 0), 0.6 * refined->GetComponent(p, 1), 1e-12) << p;
    EXPECT_TRUE(p >= surface->GetNumberOfPoints() || refined->GetComponent(p, 0) == directions->GetComponent(p, 0));
  }
}

TEST(MaternNoiseArrays, EdgesAreLongForTheRangeAtTheirPlace)
{
  auto surface = Grid(16).ToPolyData();
  vtkNew<vtkDoubleArray> factors;
  factors->SetName("factor");
  for (vtkIdType p = 0; p < surface->GetNumberOfPoints(); ++p)
  {
    factors->InsertNextValue(surface->GetPoint(p)[0] < 0.3 ? 0.2 : 1.0);
  }
  surface->GetPointData()->AddArray(factors);
  const auto filter = FilterOn(surface);
  EventRecorder events(filter);
  ASSERT_TRUE(Update(filter));
  EXPECT_TRUE(events.Warnings.empty());
  filter->SetRangeFactorArrayName("factor");
  ASSERT_TRUE(Update(filter));
  ASSERT_EQ(events.Warnings.size(), 1U);
  EXPECT_THAT(events.Warnings[0], HasSubstr("times the correlation range there, more than a third"));
}

TEST(MaternNoiseArrays, AreThoseOfTheFieldOfTheCore)
{
  const auto surface = SurfaceWithArrays();
  const auto filter = FilterOn(surface);
  UseAllArrays(filter);
  filter->SetStandardDeviation(2.0);
  ASSERT_TRUE(Update(filter));

  surfsynth::MaternFieldOptions options;
  options.CorrelationRange = 1.0;
  options.OperatorPower = 3;
  options.VarianceCorrection = true;
  options.Boundary = surfsynth::BoundaryCondition::Dirichlet;
  options.AnisotropyRatio = 3.0;
  const surfsynth::Surface converted = surfsynth::ToSurface(surface, surfsynth::MeshRequirements());
  const vtkIdType points = surface->GetNumberOfPoints();
  options.Arrays.RangeFactors.resize(points);
  options.Arrays.Directions.resize(points, 3);
  for (vtkIdType p = 0; p < points; ++p)
  {
    options.Arrays.RangeFactors[p] = surface->GetPointData()->GetArray("factor")->GetComponent(p, 0);
    options.Arrays.Directions.row(p) << 2.0, -1.0, 0.5;
    options.Arrays.BoundaryMask.push_back(p % 5 == 0);
  }
  for (std::int64_t f = 0; f < converted.Mesh.NumberOfTriangles(); ++f)
  {
    options.Arrays.Barrier.push_back(converted.Cell(f) % 7 == 0);
  }
  const Eigen::MatrixXd expected = surfsynth::MaternField(converted.Mesh, options).Sample();
  vtkDataArray* noise = filter->GetPolyDataOutput()->GetPointData()->GetArray("MaternNoise");
  ASSERT_TRUE(noise);
  for (vtkIdType p = 0; p < points; ++p)
  {
    ASSERT_EQ(noise->GetComponent(p, 0), 2.0 * expected(p, 0)) << p;
  }
}

TEST(MaternNoiseArrays, EachHasAnEffectAndANewSeedFactorsNothing)
{
  const auto filter = FilterOn(SurfaceWithArrays());
  const auto costOf = [&](const std::function<void()>& change) {
    const vtkTypeInt64 before = filter->GetNumberOfFactorizations();
    change();
    EXPECT_TRUE(Update(filter));
    return filter->GetNumberOfFactorizations() - before;
  };
  EXPECT_EQ(costOf([] {}), 1);
  EXPECT_EQ(costOf([&] { filter->SetBoundaryArrayName("mask"); }), 0) << "no effect on a Neumann condition";
  EXPECT_EQ(costOf([&] { filter->SetRangeFactorArrayName("factor"); }), 1);
  EXPECT_EQ(costOf([&] { filter->SetDirectionArrayName("direction"); }), 1);
  EXPECT_EQ(costOf([&] { filter->SetAnisotropyRatio(2.0); }), 1);
  EXPECT_EQ(costOf([&] { filter->SetBarrierArrayName("barrier"); }), 1);
  EXPECT_EQ(costOf([&] { filter->SetBoundaryConditionToRobin(); }), 1);
  EXPECT_EQ(costOf([&] { filter->SetBoundaryConditionToDirichlet(); }), 1);
  EXPECT_EQ(costOf([&] { filter->SetSeed(4); }), 0);
  EXPECT_EQ(costOf([&] { filter->SetNumberOfSamples(3); }), 0);
  EXPECT_EQ(costOf([&] { filter->SetNoiseModelToPerVertex(); }), 1);
  EXPECT_EQ(costOf([&] { filter->SetBarrierArrayName("no such array"); }), 0) << "no effect on other models";
}

TEST(MaternNoiseArrays, OfChangedValuesCostOneFactorization)
{
  const auto surface = SurfaceWithArrays();
  const auto filter = FilterOn(surface);
  filter->SetRangeFactorArrayName("factor");
  ASSERT_TRUE(Update(filter));
  surface->GetPointData()->GetArray("factor")->SetComponent(3, 0, 1.75);
  surface->GetPointData()->GetArray("factor")->Modified();
  surface->GetPointData()->Modified();
  surface->Modified();
  ASSERT_TRUE(Update(filter));
  EXPECT_EQ(filter->GetNumberOfFactorizations(), 2);
}

TEST(MaternNoiseArrays, OfBlocksAreReadBlockByBlock)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, SurfaceWithArrays());
  blocks->SetBlock(1, Grid(12).ToPolyData());
  const auto filter = FilterOn(blocks);
  UseAllArrays(filter);
  EventRecorder events(filter);
  Update(filter);
  ASSERT_EQ(events.Errors.size(), 1U);
  EXPECT_THAT(events.Errors[0], AllOf(HasSubstr("Block 2"), HasSubstr("There is no point array \"factor\"")));
}

TEST(MaternNoiseArrays, TheDeviationIsExactInAllModesWithTheCorrection)
{
  // 600 samples on an open patch: the pooled deviation within 3 %, at every point within 12 % (z = 4.2).
  for (const int mode : { Noise::CORRELATION_RANGE, Noise::SCREENING, Noise::NORMALIZED_SCREENING })
  {
    const auto filter = FilterOn(Grid(16).ToPolyData());
    filter->SetScaleMode(mode);
    filter->SetOperatorPower(mode == Noise::CORRELATION_RANGE ? 4 : 1);
    filter->VarianceCorrectionOn();
    filter->SetStandardDeviation(0.5);
    filter->SetNumberOfSamples(600);
    ASSERT_TRUE(Update(filter));
    vtkPointData* data = filter->GetPolyDataOutput()->GetPointData();
    for (vtkIdType p = 0; p < filter->GetPolyDataOutput()->GetNumberOfPoints(); p += 16)
    {
      double sum = 0.0;
      for (int k = 0; k < 600; ++k)
      {
        const double value = data->GetArray(("MaternNoise_" + std::to_string(k)).c_str())->GetComponent(p, 0);
        sum += value * value;
      }
      EXPECT_NEAR(std::sqrt(sum / 600.0), 0.5, 0.12 * 0.5) << "mode " << mode << ", point " << p;
    }
  }
}

TEST(MaternNoiseArrays, DirichletIsZeroAtTheBoundaryOnly)
{
  const auto filter = FilterOn(Grid(16).ToPolyData());
  filter->SetBoundaryConditionToDirichlet();
  ASSERT_TRUE(Update(filter));
  vtkPolyData* output = filter->GetPolyDataOutput();
  double bounds[6];
  output->GetBounds(bounds);
  for (vtkIdType p = 0; p < output->GetNumberOfPoints(); ++p)
  {
    const double* x = output->GetPoint(p);
    const bool boundary = x[0] == bounds[0] || x[0] == bounds[1] || x[1] == bounds[2] || x[1] == bounds[3];
    EXPECT_EQ(output->GetPointData()->GetArray("MaternNoise")->GetComponent(p, 0) == 0.0, boundary) << p;
  }
}

TEST(MaternNoiseArrays, MessagesNameArrayPropertyAndPlace)
{
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(ErrorWith([](vtkPolyData*, Noise* f) { f->SetRangeFactorArrayName("none"); }),
    AllOf(HasSubstr("There is no point array \"none\""), HasSubstr("RangeFactorArrayName")));
  EXPECT_THAT(ErrorWith([](vtkPolyData*, Noise* f) { f->SetBarrierArrayName("mask"); }),
    AllOf(HasSubstr("There is no cell array \"mask\""), HasSubstr("BarrierArrayName")));
  EXPECT_THAT(ErrorWith([](vtkPolyData*, Noise* f) { f->SetDirectionArrayName("factor"); }),
    AllOf(HasSubstr("\"factor\""), HasSubstr("1 component"), HasSubstr("3 components")));
  EXPECT_THAT(ErrorWith([](vtkPolyData* s, Noise* f) {
    s->GetPointData()->GetArray("mask")->SetNumberOfTuples(3);
    f->SetBoundaryConditionToDirichlet();
    f->SetBoundaryArrayName("mask");
  }),
    AllOf(HasSubstr("BoundaryArrayName"), HasSubstr("3 tuples")));
  EXPECT_THAT(ErrorWith([nan](vtkPolyData* s, Noise* f) {
    s->GetPointData()->GetArray("direction")->SetComponent(4, 1, nan);
    f->SetDirectionArrayName("direction");
  }),
    AllOf(HasSubstr("\"direction\""), HasSubstr("not finite at point 4")));
  for (const double bad : { 0.0, -1.0 })
  {
    EXPECT_THAT(ErrorWith([bad](vtkPolyData* s, Noise* f) {
      s->GetPointData()->GetArray("factor")->SetComponent(9, 0, bad);
      f->SetRangeFactorArrayName("factor");
    }),
      AllOf(HasSubstr("\"factor\""), HasSubstr("at point 9"), HasSubstr("above 0")));
  }
  EXPECT_THAT(ErrorWith([](vtkPolyData*, Noise* f) { f->SetOperatorPower(1); }),
    AllOf(HasSubstr("no finite variance"), HasSubstr("screening")));
}

TEST(MaternNoiseArrays, NamesThatAreNullAreEmpty)
{
  vtkNew<Noise> filter;
  filter->SetRangeFactorArrayName(nullptr);
  EXPECT_STREQ(filter->GetRangeFactorArrayName(), "");
  EXPECT_STREQ(filter->GetBarrierArrayName(), "");
}
