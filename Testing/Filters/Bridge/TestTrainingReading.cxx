// SPDX-License-Identifier: BSD-3-Clause
//
// Datasets for training out of VTK's data objects.
#include "FilterChecks.h"
#include "ThrownText.h"
#include "VtkSurfaces.h"

#include "NewArray.h"
#include "TrainingReading.h"

#include "Core/Common/Errors.h"

#include <vtkDoubleArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkStructuredGrid.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

using namespace surfsynthtest;
using surfsynth::InvalidInput;
using surfsynth::NewArray;
using surfsynth::SignalDataset;
using surfsynth::TrainingReader;
using ::testing::AllOf;
using ::testing::HasSubstr;

namespace
{
/// A sphere with the arrays "Heat_0" ... of two components: tuple p is (k + p, -p).
vtkSmartPointer<vtkPolyData> HotSphere(int samples, int level = 1)
{
  const auto sphere = Icosphere(level).ToPolyData();
  for (int k = 0; k < samples; ++k)
  {
    const auto heat = NewArray<vtkDoubleArray>("Heat_" + std::to_string(k), sphere->GetNumberOfPoints(), 2);
    for (vtkIdType p = 0; p < sphere->GetNumberOfPoints(); ++p)
    {
      heat->SetTuple2(p, k + p, -p);
    }
    sphere->GetPointData()->AddArray(heat);
  }
  return sphere;
}

vtkSmartPointer<vtkMultiBlockDataSet> BlocksOf(const std::vector<vtkSmartPointer<vtkDataObject>>& parts)
{
  auto blocks = vtkSmartPointer<vtkMultiBlockDataSet>::New();
  for (std::size_t k = 0; k < parts.size(); ++k)
  {
    blocks->SetBlock(static_cast<unsigned int>(k), parts[k]);
  }
  return blocks;
}
} // namespace

TEST(TrainingReading, NumberedArraysAreSamplesOfTheirSurface)
{
  const auto sphere = HotSphere(3);
  TrainingReader reader(sphere, "Heat");
  EXPECT_EQ(reader.NumberOfSources(), 1);
  reader.AddSamples(sphere);
  EXPECT_EQ(reader.NumberOfSamples(), 3);
  const SignalDataset dataset = reader.Take();
  EXPECT_EQ(dataset.SignalName, "Heat");
  ASSERT_EQ(dataset.Sources.size(), 1u);
  ASSERT_EQ(dataset.Sources[0].Samples.rows(), 3);
  ASSERT_EQ(dataset.Sources[0].Samples.cols(), 84);
  EXPECT_EQ(dataset.Sources[0].Samples(2, 2 * 40), 42.0F);
  EXPECT_EQ(dataset.Sources[0].Samples(2, 2 * 40 + 1), -40.0F);
  EXPECT_EQ(dataset.Sources[0].Mesh.NumberOfTriangles(), 80);
  EXPECT_EQ(reader.NumberOfSources(), 0) << "the reader is empty";
}

TEST(TrainingReading, WithoutAnArrayTheSamplesArePositions)
{
  const auto sphere = Icosphere(1).ToPolyData();
  TrainingReader reader(sphere, "");
  reader.AddSamples(BlocksOf({ sphere, sphere }));
  const SignalDataset dataset = reader.Take();
  EXPECT_TRUE(dataset.HoldsPositions());
  EXPECT_EQ(dataset.Sources[0].NumberOfSamples(), 2);
  EXPECT_EQ(dataset.Sources[0].Samples(1, 3), static_cast<float>(sphere->GetPoint(1)[0]));
}

TEST(TrainingReading, PositionsFarFromTheOriginKeepTheirDigits)
{
  Soup far = Icosphere(1);
  for (std::size_t k = 0; k < far.Points.size(); k += 3)
  {
    far.Points[k] += 1048576.0; // 2^20: a float has steps of 0.125 there
  }
  const auto surface = far.ToPolyData();
  TrainingReader reader(surface, "");
  reader.AddSamples(surface);
  const auto samples = reader.Take().Sources[0].Samples;
  const Soup near = Icosphere(1);
  for (std::size_t k = 3; k < near.Points.size(); k += 3)
  {
    EXPECT_NEAR(samples(0, static_cast<Eigen::Index>(k)) - samples(0, 0), near.Points[k] - near.Points[0], 1e-6) << k;
  }
}

TEST(TrainingReading, PointsThatNoPolygonUsesAreLeftOut)
{
  Soup soup = Icosphere(1);
  soup.Points.insert(soup.Points.begin(), { 9.0, 9.0, 9.0 });
  for (auto& polygon : soup.Polys)
  {
    for (vtkIdType& id : polygon)
    {
      ++id;
    }
  }
  const auto surface = soup.ToPolyData();
  TrainingReader reader(surface, "");
  reader.AddSamples(surface);
  const SignalDataset dataset = reader.Take();
  EXPECT_EQ(dataset.Sources[0].Mesh.NumberOfPoints(), 42);
  EXPECT_EQ(dataset.Sources[0].Samples(0, 0), static_cast<float>(Icosphere(1).Points[0]));
}

TEST(TrainingReading, SeveralSourcesHaveTheirSamplesInBlocks)
{
  const auto sources = BlocksOf({ HotSphere(1), vtkSmartPointer<vtkPolyData>::New(), HotSphere(2, 2) });
  TrainingReader reader(sources, "Heat");
  EXPECT_EQ(reader.NumberOfSources(), 2) << "empty leaves are left out";
  reader.AddSamples(sources);
  EXPECT_EQ(reader.NumberOfSamples(), 3);
  const SignalDataset dataset = reader.Take();
  EXPECT_EQ(dataset.Sources[0].NumberOfSamples(), 1);
  EXPECT_EQ(dataset.Sources[1].NumberOfSamples(), 2);
  EXPECT_EQ(dataset.Sources[1].Mesh.NumberOfPoints(), 162);
}

TEST(TrainingReading, WhatWasReadIsItsOwn)
{
  const auto sphere = HotSphere(1);
  TrainingReader reader(sphere, "Heat");
  reader.AddSamples(sphere);
  sphere->GetPoints()->SetPoint(0, 5.0, 5.0, 5.0); // the next step of a time series
  sphere->GetPointData()->GetArray("Heat_0")->SetTuple2(0, 7.0, 7.0);
  reader.AddSamples(sphere);
  const SignalDataset dataset = reader.Take();
  EXPECT_EQ(dataset.Sources[0].Mesh.Points(0, 0), Icosphere(1).Points[0]);
  EXPECT_EQ(dataset.Sources[0].Samples(0, 0), 0.0F);
  EXPECT_EQ(dataset.Sources[0].Samples(1, 0), 7.0F);
}

TEST(TrainingReading, ErrorsNameTheSource)
{
  Soup broken = Icosphere(1);
  broken.Polys[3] = { 0, 0, 1 };
  const auto bad = broken.ToPolyData();
  EXPECT_THAT(
    TextOf<InvalidInput>([&] { TrainingReader(bad, ""); }), HasSubstr("What is wrong with the source: The mesh has 1"));
  const auto blocks = BlocksOf({ HotSphere(1), bad });
  EXPECT_THAT(
    TextOf<InvalidInput>([&] { TrainingReader(blocks, ""); }), HasSubstr("What is wrong with source 1 (Block 2): "));
  vtkNew<vtkStructuredGrid> grid;
  vtkNew<vtkPoints> points;
  points->InsertNextPoint(0.0, 0.0, 0.0);
  grid->SetPoints(points);
  EXPECT_THAT(TextOf<InvalidInput>([&] { TrainingReader(grid, ""); }),
    AllOf(HasSubstr("What should be the source is a vtkStructuredGrid"), HasSubstr("vtkDataSetSurfaceFilter")));
  TrainingReader reader(HotSphere(1), "Heat");
  EXPECT_THAT(TextOf<InvalidInput>([&] { reader.Take(); }), HasSubstr("There is no sample of the source"));
  TrainingReader two(BlocksOf({ HotSphere(1), HotSphere(1) }), "Heat");
  EXPECT_THAT(TextOf<InvalidInput>([&] { two.AddSamples(HotSphere(1)); }),
    AllOf(HasSubstr("There are 2 sources, and samples in 0 blocks"), HasSubstr("a block for each source")));
}

TEST(TrainingReading, ErrorsNameTheSample)
{
  const auto sphere = HotSphere(2);
  TrainingReader reader(sphere, "Heat");
  const auto errorOf = [&](
                         vtkDataObject* samples) { return TextOf<InvalidInput>([&] { reader.AddSamples(samples); }); };
  EXPECT_THAT(errorOf(Icosphere(1).ToPolyData()), HasSubstr("no numeric point array called \"Heat\""));
  EXPECT_THAT(errorOf(HotSphere(1, 2)), HasSubstr("training sample 0 (Heat_0) has 162 points and the source has 42"));
  const auto mixed = HotSphere(1);
  mixed->GetPointData()->AddArray(NewArray<vtkDoubleArray>("Heat_1", 42, 3));
  EXPECT_THAT(errorOf(mixed), HasSubstr("training sample 1 (Heat_1) has 3 components and the first sample has 2"));
  const auto infinite = HotSphere(1);
  infinite->GetPointData()->GetArray("Heat_0")->SetComponent(7, 1, 1e300);
  EXPECT_THAT(errorOf(infinite),
    AllOf(HasSubstr("training sample 0 (Heat_0)"), HasSubstr("not finite in single precision at point 7")));
  TrainingReader positions(sphere, "Position");
  const auto flat = Icosphere(1).ToPolyData();
  flat->GetPointData()->AddArray(NewArray<vtkDoubleArray>("Position", 42, 2));
  EXPECT_THAT(
    TextOf<InvalidInput>([&] { positions.AddSamples(flat); }), HasSubstr("has 2 components; positions must have 3"));
}
