// SPDX-License-Identifier: BSD-3-Clause
//
// vtkMaternParameterEstimator.
#include "FilterChecks.h"
#include "VtkSurfaces.h"

#include "vtkMaternNoiseFilter.h"
#include "vtkMaternParameterEstimator.h"

#include <vtkDoubleArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkStringArray.h>
#include <vtkTable.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

using namespace surfsynthtest;
using testing::HasSubstr;

namespace
{
/// A sphere with four samples of noise of range 0.7 and deviation 2.
vtkSmartPointer<vtkPolyData> NoisySphere()
{
  vtkNew<vtkMaternNoiseFilter> noise;
  noise->SetInputDataObject(Icosphere(3).ToPolyData());
  noise->SetCorrelationRange(0.7);
  noise->SetStandardDeviation(2.0);
  noise->SetNumberOfSamples(4);
  noise->SetSeed(5);
  EXPECT_TRUE(Update(noise));
  return vtkPolyData::SafeDownCast(noise->GetOutputDataObject(0));
}

vtkSmartPointer<vtkMaternParameterEstimator> EstimatorOn(vtkPolyData* surface)
{
  auto filter = vtkSmartPointer<vtkMaternParameterEstimator>::New();
  filter->SetInputDataObject(surface);
  filter->SetObservationArray("MaternNoise");
  return filter;
}

double Cell(vtkMaternParameterEstimator* filter, int row, const char* column)
{
  vtkTable* table = filter->GetOutput();
  auto* values = vtkDoubleArray::SafeDownCast(table->GetColumnByName(column));
  return values && row < values->GetNumberOfValues() ? values->GetValue(row) : std::nan("");
}

std::string ErrorOf(vtkMaternParameterEstimator* filter)
{
  EventRecorder events(filter);
  filter->Update();
  EXPECT_EQ(events.Errors.size(), 1U) << events.AllErrors();
  EXPECT_EQ(filter->GetOutput()->GetNumberOfRows(), 0);
  return events.AllErrors();
}
} // namespace

TEST(MaternParameterEstimator, FindsTheParametersOfTheNoiseFilter)
{
  const auto sphere = NoisySphere();
  const auto filter = EstimatorOn(sphere);
  filter->NoiseEstimationOff();
  filter->MeanEstimationOff();
  ASSERT_TRUE(Update(filter));
  ASSERT_EQ(filter->GetOutput()->GetNumberOfRows(), 3);
  auto* names = vtkStringArray::SafeDownCast(filter->GetOutput()->GetColumnByName("Parameter"));
  ASSERT_TRUE(names);
  EXPECT_EQ(names->GetValue(0), "CorrelationRange");
  EXPECT_EQ(names->GetValue(1), "StandardDeviation");
  EXPECT_EQ(names->GetValue(2), "NoiseDeviation");
  EXPECT_LT(Cell(filter, 0, "Lower"), 0.7);
  EXPECT_GT(Cell(filter, 0, "Upper"), 0.7);
  EXPECT_LT(Cell(filter, 1, "Lower"), 2.0);
  EXPECT_GT(Cell(filter, 1, "Upper"), 2.0);
  EXPECT_LT(Cell(filter, 0, "StandardError"), 0.1) << "2,568 numbers";
  EXPECT_EQ(Cell(filter, 2, "Estimate"), 0.0);
  EXPECT_EQ(filter->GetCorrelationRange(), Cell(filter, 0, "Estimate"));
  EXPECT_EQ(filter->GetStandardDeviation(), Cell(filter, 1, "Estimate"));
  EXPECT_EQ(filter->GetNumberOfObservations(), 642);
  EXPECT_EQ(filter->GetNumberOfFields(), 4);
  EXPECT_TRUE(std::isfinite(filter->GetLogLikelihood()));
}

TEST(MaternParameterEstimator, TakesObservationsAtOtherPoints)
{
  const auto sphere = NoisySphere();
  vtkNew<vtkPolyData> points; // every second point, without cells
  vtkNew<vtkPoints> places;
  vtkNew<vtkDoubleArray> values;
  values->SetName("Some");
  for (vtkIdType p = 0; p < sphere->GetNumberOfPoints(); p += 2)
  {
    places->InsertNextPoint(sphere->GetPoint(p));
    values->InsertNextValue(sphere->GetPointData()->GetArray("MaternNoise_2")->GetComponent(p, 0) + 10.0);
  }
  points->SetPoints(places);
  points->GetPointData()->SetScalars(values);
  const auto filter = EstimatorOn(sphere);
  filter->SetInputDataObject(1, points);
  filter->SetObservationArray("");
  ASSERT_TRUE(Update(filter));
  EXPECT_EQ(filter->GetNumberOfObservations(), 321);
  EXPECT_EQ(filter->GetNumberOfFields(), 1);
  EXPECT_LT(Cell(filter, 0, "Lower"), 0.7);
  EXPECT_GT(Cell(filter, 0, "Upper"), 0.7);

  places->SetPoint(3, 3.0, 0.0, 0.0);
  places->Modified();
  points->Modified();
  EXPECT_THAT(ErrorOf(filter), HasSubstr("1 observation is farther from the surface than the Tolerance of 0.02: 3."));
  filter->RemoveObservations();
  filter->SetObservationArray("MaternNoise_1");
  EXPECT_TRUE(Update(filter));
}

TEST(MaternParameterEstimator, FaultsAreErrorsAndEmptyInputIsNone)
{
  const auto sphere = NoisySphere();
  const auto missing = EstimatorOn(sphere);
  missing->SetObservationArray("Thickness");
  EXPECT_THAT(ErrorOf(missing), HasSubstr("no point array \"Thickness\""));
  const auto constant = EstimatorOn(sphere);
  vtkNew<vtkDoubleArray> ones;
  ones->SetName("Ones");
  ones->SetNumberOfTuples(642);
  ones->Fill(1.0);
  sphere->GetPointData()->AddArray(ones);
  constant->SetObservationArray("Ones");
  EXPECT_THAT(ErrorOf(constant), HasSubstr("all values are 1"));
  ones->SetValue(9, std::nan(""));
  sphere->Modified();
  constant->Modified();
  EXPECT_THAT(ErrorOf(constant), HasSubstr("Point 9 has a value of ObservationArray that is not finite"));

  Soup fan = Grid(3);
  fan.Polys.push_back({ fan.Polys[0][0], fan.Polys[0][1], fan.AddPoint(0.1, 0.2, 5.0) });
  fan.Polys.push_back({ fan.Polys[0][0], fan.Polys[0][1], fan.AddPoint(0.1, 0.2, -5.0) });
  EXPECT_THAT(ErrorOf(EstimatorOn(fan.ToPolyData())), HasSubstr("edge"));

  vtkNew<vtkPolyData> empty;
  const auto nothing = EstimatorOn(empty);
  EXPECT_TRUE(Update(nothing));
  EXPECT_EQ(nothing->GetOutput()->GetNumberOfRows(), 0);
}

TEST(MaternParameterEstimator, PrintsItsProperties)
{
  vtkNew<vtkMaternParameterEstimator> filter;
  std::ostringstream text;
  filter->Print(text);
  for (const char* name : { "ObservationArray", "Tolerance", "NoiseEstimation", "MeanEstimation", "CorrelationRange",
         "StandardDeviation", "NoiseDeviation", "LogLikelihood", "NumberOfObservations", "NumberOfFields" })
  {
    EXPECT_THAT(text.str(), HasSubstr(std::string(name) + ": "));
  }
}
