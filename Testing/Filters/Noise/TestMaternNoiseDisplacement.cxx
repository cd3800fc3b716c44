// SPDX-License-Identifier: BSD-3-Clause
//
// vtkMaternNoiseFilter with a Displacement, and with landmarks on its second input.
#include "FilterChecks.h"
#include "FilterContract.h"
#include "VtkSurfaces.h"

#include "vtkMaternNoiseFilter.h"

#include <vtkCellArray.h>
#include <vtkDoubleArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

using namespace surfsynthtest;
using testing::HasSubstr;
using Noise = vtkMaternNoiseFilter;
using Vector = std::array<double, 3>;

namespace
{
constexpr std::array<int, 3> Modes = { Noise::FREE, Noise::NORMAL, Noise::TANGENTIAL };

/// Landmarks at points of the icosphere on the axes, where the vertex normal is the position.
const std::array<Vector, 3> Places = { { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } } };

/// Displacements of the landmarks that the mode reaches.
Vector Move(int mode, int landmark)
{
  Vector move = { 0.02 * (landmark + 1), -0.03, 0.01 * landmark };
  for (int c = 0; c < 3; ++c)
  {
    const bool isAlong = c == landmark;
    move[static_cast<std::size_t>(c)] *= mode == Noise::FREE || (mode == Noise::NORMAL) == isAlong ? 1.0 : 0.0;
  }
  return move;
}

vtkSmartPointer<vtkPolyData> Landmarks(int mode, bool targets = false)
{
  auto data = vtkSmartPointer<vtkPolyData>::New();
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  vtkNew<vtkDoubleArray> values;
  values->SetName("Move");
  values->SetNumberOfComponents(3);
  for (int landmark = 0; landmark < 3; ++landmark)
  {
    const Vector& place = Places[static_cast<std::size_t>(landmark)];
    const Vector move = Move(mode, landmark);
    points->InsertNextPoint(place.data());
    values->InsertNextTuple3(move[0] + targets * place[0], move[1] + targets * place[1], move[2] + targets * place[2]);
  }
  data->SetPoints(points);
  data->GetPointData()->SetVectors(values);
  return data;
}

vtkSmartPointer<Noise> Displacing(int mode, vtkDataObject* input = nullptr)
{
  auto filter = vtkSmartPointer<Noise>::New();
  filter->SetInputDataObject(input ? input : Icosphere(3).ToPolyData().Get());
  filter->SetCorrelationRange(1.2);
  filter->SetStandardDeviation(0.03);
  filter->SetOperatorPower(3);
  filter->SetDisplacement(mode);
  return filter;
}

vtkPolyData* OutputSurface(Noise* filter) { return vtkPolyData::SafeDownCast(filter->GetOutputDataObject(0)); }

/// Id of the point of a surface that lies at a landmark of the icosphere. The search compares all points: the locator of
/// vtkPointSet::FindPoint() sorts in threads that ThreadSanitizer cannot see.
vtkIdType PointAt(vtkPolyData* sphere, int landmark)
{
  const Vector& place = Places[static_cast<std::size_t>(landmark)];
  vtkIdType nearest = -1;
  double largest = -1.0;
  for (vtkIdType point = 0; point < sphere->GetNumberOfPoints(); ++point)
  {
    double candidate[3];
    sphere->GetPoint(point, candidate);
    const double cosine = candidate[0] * place[0] + candidate[1] * place[1] + candidate[2] * place[2];
    if (cosine > largest)
    {
      largest = cosine;
      nearest = point;
    }
  }
  EXPECT_NEAR(largest, 1.0, 1e-9);
  return nearest;
}

Vector TupleOf(vtkDataArray* array, vtkIdType point)
{
  Vector tuple{};
  array->GetTuple(point, tuple.data());
  return tuple;
}
} // namespace

TEST(MaternNoiseDisplacement, HasThreeComponentsAlongItsDirections)
{
  for (const int mode : Modes)
  {
    const auto filter = Displacing(mode);
    filter->SetNumberOfComponents(2); // of no use
    const auto output = SurfaceOf(filter);
    ASSERT_EQ(PointArray(output, "MaternNoise")->GetNumberOfComponents(), 3);
    EXPECT_EQ(output->GetPointData()->GetVectors(), PointArray(output, "MaternNoise"));
    double along = 0.0;
    double across = 0.0;
    for (vtkIdType p = 0; p < output->GetNumberOfPoints(); ++p)
    {
      const Vector move = TupleOf(PointArray(output, "MaternNoise"), p);
      double n[3];
      output->GetPoint(p, n); // normals of an icosphere of this level are within 0.05 of the positions
      const double part = move[0] * n[0] + move[1] * n[1] + move[2] * n[2];
      along += part * part;
      across += move[0] * move[0] + move[1] * move[1] + move[2] * move[2] - part * part;
    }
    EXPECT_TRUE(mode == Noise::NORMAL ? across < 0.01 * along : across > 0.1 * along) << mode;
    EXPECT_TRUE(mode == Noise::TANGENTIAL ? along < 0.01 * across : along > 0.1 * across) << mode;
  }
}

TEST(MaternNoiseDisplacement, FreeOnesAreTheNoiseOfThreeComponents)
{
  const auto field = Displacing(Noise::NO_DISPLACEMENT);
  field->SetNumberOfComponents(3);
  const auto free = Displacing(Noise::FREE);
  EXPECT_TRUE(SameBits(PointArray(SurfaceOf(field), "MaternNoise"), PointArray(SurfaceOf(free), "MaternNoise")));
  free->SetDisplacement(Noise::NORMAL);
  ASSERT_TRUE(Update(free));
  EXPECT_EQ(free->GetNumberOfFactorizations(), 1);
}

TEST(MaternNoiseDisplacement, EverySampleAndTheMeanPassThroughTheLandmarks)
{
  for (const int mode : Modes)
  {
    for (const bool targets : { false, true })
    {
      const auto filter = Displacing(mode);
      filter->SetInputDataObject(1, Landmarks(mode, targets));
      filter->SetObservedTargets(targets);
      filter->SetNumberOfSamples(4);
      filter->PosteriorMeanOn();
      filter->PosteriorStandardDeviationOn();
      const auto output = SurfaceOf(filter);
      for (int landmark = 0; landmark < 3; ++landmark)
      {
        const vtkIdType point = PointAt(output, landmark);
        const Vector expected = Move(mode, landmark);
        for (const char* name : { "MaternNoise_0", "MaternNoise_3", "MaternNoise_Mean" })
        {
          const Vector move = TupleOf(PointArray(output, name), point);
          for (std::size_t c = 0; c < 3; ++c)
          {
            EXPECT_NEAR(move[c], expected[c], 1e-8) << name << ", mode " << mode;
          }
        }
        EXPECT_LE(PointArray(output, "MaternNoise_StandardDeviation")->GetComponent(point, 0), 1e-6);
      }
      EXPECT_GT(LargestDifference(PointArray(output, "MaternNoise_0"), PointArray(output, "MaternNoise_3")), 0.005);
      EXPECT_EQ(PointArray(output, "MaternNoise_Mean")->GetNumberOfComponents(), 3);
      EXPECT_EQ(PointArray(output, "MaternNoise_StandardDeviation")->GetNumberOfComponents(), 1);
      EXPECT_EQ(filter->GetUnreachedDistance(), 0.0);
    }
  }
}

TEST(MaternNoiseDisplacement, LandmarksThatTheDirectionsDoNotReachAreNamed)
{
  const auto filter = Displacing(Noise::NORMAL);
  filter->SetInputDataObject(1, Landmarks(Noise::FREE));
  EventRecorder events(filter);
  ASSERT_TRUE(Update(filter));
  ASSERT_EQ(events.Warnings.size(), 1U);
  EXPECT_THAT(events.Warnings[0], HasSubstr("exclude parts of 3 observed displacements: 0, 1, 2."));
  EXPECT_NEAR(filter->GetUnreachedDistance(), std::hypot(0.06, 0.03), 1e-9);
  const Vector move = TupleOf(PointArray(OutputSurface(filter), "MaternNoise"), PointAt(OutputSurface(filter), 1));
  EXPECT_NEAR(move[1], -0.03, 1e-8) << "the part along the normal";
  filter->SetDisplacement(Noise::FREE);
  ASSERT_TRUE(Update(filter));
  EXPECT_EQ(events.Warnings.size(), 1U);
  EXPECT_EQ(filter->GetUnreachedDistance(), 0.0);
}

TEST(MaternNoiseDisplacement, ChangedLandmarksCostNoFactorization)
{
  const auto landmarks = Landmarks(Noise::TANGENTIAL);
  const auto filter = Displacing(Noise::TANGENTIAL);
  filter->SetInputDataObject(1, landmarks);
  ASSERT_TRUE(Update(filter));
  landmarks->GetPointData()->GetArray("Move")->SetComponent(0, 1, 0.05);
  landmarks->GetPointData()->GetArray("Move")->Modified();
  landmarks->Modified();
  ASSERT_TRUE(Update(filter));
  EXPECT_NEAR(
    TupleOf(PointArray(OutputSurface(filter), "MaternNoise"), PointAt(OutputSurface(filter), 0))[1], 0.05, 1e-8);
  EXPECT_EQ(filter->GetNumberOfFactorizations(), 1);
}

TEST(MaternNoiseDisplacement, SamplesAreTheSameForAllThreadsAndAloneOrTogether)
{
  for (const int mode : Modes)
  {
    const auto make = [mode] {
      auto filter = Displacing(mode);
      filter->SetInputDataObject(1, Landmarks(mode));
      return vtkSmartPointer<vtkAlgorithm>(filter);
    };
    ExpectSameBitsForAllThreads(
      make, [](vtkAlgorithm* filter) { return PointArray(filter->GetOutputDataObject(0), "MaternNoise"); });
    const auto together = Displacing(mode);
    together->SetNumberOfSamples(12);
    const auto alone = Displacing(mode);
    alone->SetFirstSample(11);
    EXPECT_TRUE(
      SameBits(PointArray(SurfaceOf(together), "MaternNoise_11"), PointArray(SurfaceOf(alone), "MaternNoise")));
  }
}

TEST(MaternNoiseDisplacement, PointsAreMovedInTheirPrecisionAndInputsStay)
{
  for (const int type : { VTK_FLOAT, VTK_DOUBLE })
  {
    const auto sphere = Icosphere(3).ToPolyData(type);
    vtkNew<vtkDoubleArray> normals;
    normals->SetName("Normals");
    normals->SetNumberOfComponents(3);
    normals->SetNumberOfTuples(sphere->GetNumberOfPoints());
    normals->Fill(1.0);
    sphere->GetPointData()->SetNormals(normals);
    vtkNew<vtkMultiBlockDataSet> blocks;
    blocks->SetBlock(0, sphere);
    for (vtkDataObject* input : { static_cast<vtkDataObject*>(sphere.Get()), static_cast<vtkDataObject*>(blocks) })
    {
      const auto before = HashOf(input);
      const auto filter = Displacing(Noise::NORMAL, input);
      filter->MovedPointsOn();
      ASSERT_TRUE(Update(filter));
      auto* output = OutputSurface(filter)
        ? OutputSurface(filter)
        : vtkPolyData::SafeDownCast(vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0))->GetBlock(0));
      ASSERT_TRUE(output);
      EXPECT_EQ(output->GetPoints()->GetDataType(), type);
      EXPECT_FALSE(output->GetPointData()->HasArray("Normals"));
      double largest = 0.0;
      for (vtkIdType p = 0; p < output->GetNumberOfPoints(); ++p)
      {
        const Vector move = TupleOf(PointArray(output, "MaternNoise"), p);
        double old[3];
        double moved[3];
        sphere->GetPoint(p, old);
        output->GetPoint(p, moved);
        for (int c = 0; c < 3; ++c)
        {
          largest = std::max(largest, std::abs(moved[c] - old[c]));
          ASSERT_NEAR(moved[c], old[c] + move[static_cast<std::size_t>(c)], type == VTK_FLOAT ? 1e-6 : 1e-15);
        }
      }
      EXPECT_GT(largest, 0.01);
      EXPECT_EQ(HashOf(input), before);
    }
  }
}

TEST(MaternNoiseDisplacement, FoldsAreCountedAndCauseAWarning)
{
  const auto filter = Displacing(Noise::FREE);
  EventRecorder events(filter);
  ASSERT_TRUE(Update(filter));
  EXPECT_EQ(filter->GetNumberOfInvertedTriangles(), 0);
  EXPECT_TRUE(events.Warnings.empty());
  filter->SetStandardDeviation(3.0);
  filter->SetNumberOfSamples(2);
  ASSERT_TRUE(Update(filter));
  EXPECT_GT(filter->GetNumberOfInvertedTriangles(), 10);
  ASSERT_EQ(events.Warnings.size(), 1U);
  EXPECT_THAT(events.Warnings[0], HasSubstr("inverts triangles in 2 of 2 samples"));
}

TEST(MaternNoiseDisplacement, EachFaultIsOneErrorThatNamesIt)
{
  const auto errorOf = [](Noise* filter) {
    EventRecorder events(filter);
    filter->Update();
    EXPECT_EQ(events.Errors.size(), 1U);
    EXPECT_EQ(OutputSurface(filter)->GetNumberOfPoints(), 0);
    return events.AllErrors();
  };
  const auto several = Displacing(Noise::NORMAL);
  several->SetNumberOfSamples(3);
  several->MovedPointsOn();
  EXPECT_THAT(errorOf(several), HasSubstr("NumberOfSamples is 3; points can be moved by 1 sample only"));

  Soup wound = Icosphere(2);
  std::swap(wound.Polys[7][0], wound.Polys[7][1]);
  for (const int mode : { Noise::NORMAL, Noise::TANGENTIAL })
  {
    EXPECT_THAT(errorOf(Displacing(mode, wound.ToPolyData())), HasSubstr("wound in opposite senses"));
  }
  EXPECT_TRUE(Update(Displacing(Noise::FREE, wound.ToPolyData())));

  const auto scalars = Landmarks(Noise::NORMAL);
  vtkNew<vtkDoubleArray> heights;
  heights->SetName("Height");
  heights->SetNumberOfTuples(3);
  scalars->GetPointData()->AddArray(heights);
  const auto filter = Displacing(Noise::NORMAL);
  filter->SetInputDataObject(1, scalars);
  filter->SetObservationArray("Height");
  EXPECT_THAT(errorOf(filter), HasSubstr("3 tuples of 1 components; 3 of 3 are needed"));
}
