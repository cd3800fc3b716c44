// SPDX-License-Identifier: BSD-3-Clause
//
// vtkMaternNoiseFilter with observations on its second input, and with coherent noise.
#include "FilterChecks.h"
#include "FilterContract.h"
#include "VtkSurfaces.h"

#include "vtkMaternNoiseFilter.h"

#include "Core/Noise/MaternField.h"
#include "SurfaceBridge.h"

#include <vtkDoubleArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkUnstructuredGrid.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

using namespace surfsynthtest;
using testing::HasSubstr;

namespace
{
/// Points of the unit sphere, moved off it by @p offset, with values and standard deviations.
vtkSmartPointer<vtkPolyData> ObservationsOf(int components = 1, double offset = 0.0, int type = VTK_DOUBLE)
{
  const double directions[4][3] = { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 }, { -0.6, 0, 0.8 } };
  auto data = vtkSmartPointer<vtkPolyData>::New();
  vtkNew<vtkPoints> points;
  points->SetDataType(type);
  vtkNew<vtkDoubleArray> values;
  values->SetName("Value");
  values->SetNumberOfComponents(components);
  vtkNew<vtkDoubleArray> deviations;
  deviations->SetName("Deviation");
  for (int i = 0; i < 4; ++i)
  {
    const double scale = 1.0 + offset;
    points->InsertNextPoint(scale * directions[i][0], scale * directions[i][1], scale * directions[i][2]);
    for (int c = 0; c < components; ++c)
    {
      values->InsertNextValue(i - 1.5 + 0.25 * c);
    }
    deviations->InsertNextValue(0.3 * i);
  }
  data->SetPoints(points);
  data->GetPointData()->SetScalars(values);
  data->GetPointData()->AddArray(deviations);
  return data;
}

vtkSmartPointer<vtkMaternNoiseFilter> FilterWith(vtkDataObject* observations, vtkDataObject* input = nullptr)
{
  auto filter = vtkSmartPointer<vtkMaternNoiseFilter>::New();
  filter->SetInputDataObject(input ? input : Icosphere(3).ToPolyData().Get());
  filter->SetInputDataObject(1, observations);
  filter->SetCorrelationRange(0.8);
  return filter;
}

/// Value of an array at the point of the icosphere nearest to the observation, which has the first three as points.
double AtObservation(vtkMaternNoiseFilter* filter, const char* name, int observation, int component = 0)
{
  auto* output = vtkPolyData::SafeDownCast(filter->GetOutputDataObject(0));
  const double directions[3][3] = { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } };
  vtkIdType nearest = 0;
  double largest = -1.0;
  for (vtkIdType p = 0; p < output->GetNumberOfPoints(); ++p)
  {
    double point[3];
    output->GetPoint(p, point);
    const double cosine = point[0] * directions[observation][0] + point[1] * directions[observation][1] +
      point[2] * directions[observation][2];
    nearest = cosine > largest ? p : nearest;
    largest = std::max(largest, cosine);
  }
  EXPECT_GT(largest, 1.0 - 1e-9) << "the icosphere has points on the axes";
  vtkDataArray* array = output->GetPointData()->GetArray(name);
  return array ? array->GetComponent(nearest, component) : std::nan("");
}

std::string ErrorOf(vtkMaternNoiseFilter* filter)
{
  EventRecorder events(filter);
  filter->Update();
  EXPECT_EQ(events.Errors.size(), 1U) << events.AllErrors();
  auto* output = vtkPolyData::SafeDownCast(filter->GetOutputDataObject(0));
  EXPECT_TRUE(!output || output->GetNumberOfPoints() == 0);
  return events.AllErrors();
}
} // namespace

TEST(MaternNoiseObservations, ExactOnesAreHonoredByEverySample)
{
  for (const int type : { VTK_FLOAT, VTK_DOUBLE })
  {
    const auto filter = FilterWith(ObservationsOf(2, 0.0, type));
    filter->SetNumberOfComponents(2);
    filter->SetNumberOfSamples(20);
    filter->SetStandardDeviation(3.0);
    filter->PosteriorMeanOn();
    filter->PosteriorStandardDeviationOn();
    ASSERT_TRUE(Update(filter));
    for (int observation = 0; observation < 3; ++observation)
    {
      for (int c = 0; c < 2; ++c)
      {
        const double expected = observation - 1.5 + 0.25 * c;
        EXPECT_NEAR(AtObservation(filter, "MaternNoise_0", observation, c), expected, 3e-8);
        EXPECT_NEAR(AtObservation(filter, "MaternNoise_19", observation, c), expected, 3e-8);
        EXPECT_NEAR(AtObservation(filter, "MaternNoise_Mean", observation, c), expected, 3e-8);
      }
      EXPECT_NEAR(AtObservation(filter, "MaternNoise_StandardDeviation", observation), 0.0, 1e-5);
    }
  }
}

TEST(MaternNoiseObservations, SamplesHaveThePosteriorMeanAndDeviation)
{
  // 400 samples; bounds of 5 standard errors at each of 642 points.
  const auto filter = FilterWith(ObservationsOf());
  filter->SetObservationArray("Value");
  filter->SetObservationDeviationArray("Deviation");
  filter->SetNumberOfSamples(400);
  filter->PosteriorMeanOn();
  filter->PosteriorStandardDeviationOn();
  ASSERT_TRUE(Update(filter));
  auto* output = vtkPolyData::SafeDownCast(filter->GetOutputDataObject(0));
  vtkDataArray* mean = PointArray(output, "MaternNoise_Mean");
  vtkDataArray* deviation = PointArray(output, "MaternNoise_StandardDeviation");
  ASSERT_TRUE(mean && deviation);
  for (vtkIdType p = 0; p < output->GetNumberOfPoints(); ++p)
  {
    double sum = 0.0;
    double squares = 0.0;
    for (int k = 0; k < 400; ++k)
    {
      const double value = PointArray(output, ("MaternNoise_" + std::to_string(k)).c_str())->GetComponent(p, 0);
      sum += value - mean->GetComponent(p, 0);
      squares += (value - mean->GetComponent(p, 0)) * (value - mean->GetComponent(p, 0));
    }
    const double expected = deviation->GetComponent(p, 0);
    EXPECT_LE(std::abs(sum / 400), 5.0 * expected / 20.0 + 1e-6) << p;
    EXPECT_NEAR(squares / 400, expected * expected, 5.0 * std::sqrt(2.0 / 400) * expected * expected + 1e-9) << p;
  }
}

TEST(MaternNoiseObservations, ChangesOfThemCostNoFactorization)
{
  const auto observations = ObservationsOf();
  const auto filter = FilterWith(observations);
  ASSERT_TRUE(Update(filter));
  ASSERT_EQ(filter->GetNumberOfFactorizations(), 1);
  observations->GetPointData()->GetArray("Value")->SetComponent(1, 0, 7.0);
  observations->GetPointData()->GetArray("Value")->Modified();
  observations->Modified();
  ASSERT_TRUE(Update(filter));
  EXPECT_NEAR(AtObservation(filter, "MaternNoise", 1), 7.0, 1e-7);
  observations->GetPoints()->SetPoint(0, 0.0, -1.0, 0.0);
  observations->GetPoints()->Modified();
  observations->Modified();
  ASSERT_TRUE(Update(filter));
  filter->SetObservationDeviationArray("Deviation");
  ASSERT_TRUE(Update(filter));
  filter->SetSeed(3);
  ASSERT_TRUE(Update(filter));
  EXPECT_EQ(filter->GetNumberOfFactorizations(), 1);
  filter->RemoveObservations();
  ASSERT_TRUE(Update(filter));
  EXPECT_EQ(filter->GetNumberOfFactorizations(), 1);
  auto* output = vtkPolyData::SafeDownCast(filter->GetOutputDataObject(0));
  EXPECT_EQ(output->GetPointData()->HasArray("MaternNoise_Mean"), 0);
}

TEST(MaternNoiseObservations, SamplesAreTheSameAloneAndTogetherAndInputsStay)
{
  const auto observations = ObservationsOf();
  const auto before = HashOf(observations);
  const auto together = FilterWith(observations);
  together->SetObservationDeviationArray("Deviation");
  together->SetNumberOfSamples(5);
  ASSERT_TRUE(Update(together));
  const auto alone = FilterWith(observations);
  alone->SetObservationDeviationArray("Deviation");
  alone->SetFirstSample(4);
  ASSERT_TRUE(Update(alone));
  EXPECT_LE(LargestDifference(PointArray(together->GetOutputDataObject(0), "MaternNoise_4"),
              PointArray(alone->GetOutputDataObject(0), "MaternNoise")),
    1e-10);
  EXPECT_EQ(HashOf(observations), before);
}

TEST(MaternNoiseObservations, NoneAtAllLeaveTheNoise)
{
  vtkNew<vtkPolyData> empty;
  const auto with = FilterWith(empty);
  const auto without = FilterWith(nullptr);
  ASSERT_TRUE(Update(with));
  ASSERT_TRUE(Update(without));
  EXPECT_TRUE(SameBits(PointArray(with->GetOutputDataObject(0), "MaternNoise"),
    PointArray(without->GetOutputDataObject(0), "MaternNoise")));
}

TEST(MaternNoiseObservations, EachFaultIsOneErrorThatNamesIt)
{
  const auto far = FilterWith(ObservationsOf(1, 0.5));
  EXPECT_THAT(
    ErrorOf(far), HasSubstr("4 observations are farther from the surface than the Tolerance of 0.02: 0, 1, 2, 3"));
  far->SetTolerance(0.6);
  EXPECT_TRUE(Update(far));

  const auto missing = FilterWith(ObservationsOf());
  missing->SetObservationArray("Height");
  EXPECT_THAT(
    ErrorOf(missing), HasSubstr("no point array \"Height\", which ObservationArray names; there are \"Value\""));
  const auto components = FilterWith(ObservationsOf(3));
  EXPECT_THAT(ErrorOf(components), HasSubstr("4 tuples of 3 components; 4 of 1 are needed"));

  const auto negative = ObservationsOf();
  negative->GetPointData()->GetArray("Deviation")->SetComponent(2, 0, -1.0);
  const auto negativeFilter = FilterWith(negative);
  negativeFilter->SetObservationDeviationArray("Deviation");
  EXPECT_THAT(ErrorOf(negativeFilter), HasSubstr("Observation 2 has the standard deviation -1"));

  const auto notFinite = ObservationsOf();
  notFinite->GetPointData()->GetArray("Value")->SetComponent(1, 0, std::nan(""));
  EXPECT_THAT(ErrorOf(FilterWith(notFinite)), HasSubstr("Observation 1 has a value that is not finite"));

  const auto twice = ObservationsOf();
  twice->GetPoints()->SetPoint(3, 1.0, 0.0, 0.0);
  EXPECT_THAT(ErrorOf(FilterWith(twice)), HasSubstr("the exact observation 3 contradicts observation 0"));

  const auto white = FilterWith(ObservationsOf());
  white->SetNoiseModelToWhite();
  EXPECT_THAT(ErrorOf(white), HasSubstr("NoiseModel MATERN"));

  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, Icosphere(2).ToPolyData());
  const auto composite = FilterWith(ObservationsOf(), blocks);
  EventRecorder events(composite);
  composite->Update();
  EXPECT_THAT(events.AllErrors(), HasSubstr("Observations belong to one surface"));
}

TEST(MaternNoiseObservations, CoherentNoiseIsThatOfTheCoreAndCostsOneFactorization)
{
  const auto sphere = Icosphere(3).ToPolyData();
  const auto filter = FilterWith(nullptr, sphere);
  filter->SetSeed(7);
  ASSERT_TRUE(Update(filter));
  filter->CoherentNoiseOn();
  ASSERT_TRUE(Update(filter));
  EXPECT_EQ(filter->GetNumberOfFactorizations(), 2);
  surfsynth::MaternFieldOptions options;
  options.CorrelationRange = 0.8;
  options.CoherentNoise = true;
  const surfsynth::MaternField field(surfsynth::ToSurface(sphere, surfsynth::MeshRequirements()).Mesh, options);
  surfsynth::SampleRequest request;
  request.Seed = 7;
  const Eigen::MatrixXd expected = field.Sample(request);
  vtkDataArray* noise = PointArray(filter->GetOutputDataObject(0), "MaternNoise");
  for (vtkIdType p = 0; p < noise->GetNumberOfTuples(); ++p)
  {
    ASSERT_EQ(noise->GetComponent(p, 0), expected(p, 0));
  }
  filter->SetNoiseModelToWhite();
  EXPECT_TRUE(Update(filter)) << "ignored by other models";
}

TEST(MaternNoiseObservations, APosteriorDeviationWithoutRoomForTheFactorIsAnErrorBeforeTheWork)
{
  const auto filter = FilterWith(ObservationsOf(), Icosphere(5).ToPolyData());
  filter->SetMemoryLimit(2); // the factor takes five MiB
  filter->PosteriorStandardDeviationOn();
  EXPECT_THAT(ErrorOf(filter), testing::AllOf(HasSubstr("PosteriorStandardDeviation"), HasSubstr("MemoryLimit")));
}

TEST(MaternNoiseObservations, ExactOnesAreHonoredWhereMultigridSolves)
{
  const auto filter = FilterWith(ObservationsOf(2), Icosphere(5).ToPolyData());
  filter->SetMemoryLimit(2); // the factor takes five MiB
  filter->SetNumberOfComponents(2);
  filter->SetNumberOfSamples(3);
  filter->PosteriorMeanOn();
  ASSERT_TRUE(Update(filter));
  EXPECT_STREQ(filter->GetSolverName(), "Multigrid");
  for (int observation = 0; observation < 3; ++observation)
  {
    for (int c = 0; c < 2; ++c)
    {
      const double expected = observation - 1.5 + 0.25 * c;
      EXPECT_NEAR(AtObservation(filter, "MaternNoise_0", observation, c), expected, 1e-8);
      EXPECT_NEAR(AtObservation(filter, "MaternNoise_2", observation, c), expected, 1e-8);
      EXPECT_NEAR(AtObservation(filter, "MaternNoise_Mean", observation, c), expected, 1e-8);
    }
  }
}

TEST(MaternNoiseObservations, OtherModelsAreRefusedBeforeTheWork)
{
  const auto filter = FilterWith(ObservationsOf());
  filter->SetNoiseModelToUnscreened();
  EXPECT_THAT(ErrorOf(filter), HasSubstr("MATERN"));
  EXPECT_EQ(filter->GetNumberOfFactorizations(), 0);
}
