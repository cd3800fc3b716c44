// SPDX-License-Identifier: BSD-3-Clause
//
// vtkMaternNoiseFilter on surfaces that stay in their pieces on MPI ranks. Runs under mpiexec.
#include "FilterChecks.h"
#include "VtkSurfaces.h"

#include "vtkMaternNoiseFilter.h"

#include <vtkCellArray.h>
#include <vtkIdTypeArray.h>
#include <vtkMPIController.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

using namespace surfsynthtest;
using testing::HasSubstr;

namespace
{
vtkMultiProcessController* Controller() { return vtkMultiProcessController::GetGlobalController(); }

int Rank() { return Controller()->GetLocalProcessId(); }

int Count() { return Controller()->GetNumberOfProcesses(); }

/// This rank's sector of a surface, with the ids of its points in the whole as global ids.
vtkSmartPointer<vtkPolyData> PieceOf(vtkPolyData* whole)
{
  auto piece = vtkSmartPointer<vtkPolyData>::New();
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  vtkNew<vtkCellArray> polys;
  vtkNew<vtkIdTypeArray> ids;
  ids->SetName("GlobalPointIds");
  std::map<vtkIdType, vtkIdType> local;
  for (vtkIdType cell = 0; cell < whole->GetNumberOfCells(); ++cell)
  {
    vtkNew<vtkIdList> corners;
    whole->GetCellPoints(cell, corners);
    double x[3];
    whole->GetPoint(corners->GetId(0), x);
    const double share = (std::atan2(x[1], x[0]) / std::acos(-1.0) + 1.0) / 2.0;
    if (std::min(static_cast<int>(share * Count()), Count() - 1) != Rank())
    {
      continue;
    }
    for (vtkIdType k = 0; k < corners->GetNumberOfIds(); ++k)
    {
      const auto entry = local.emplace(corners->GetId(k), points->GetNumberOfPoints());
      if (entry.second)
      {
        points->InsertNextPoint(whole->GetPoint(corners->GetId(k)));
        ids->InsertNextValue(corners->GetId(k));
      }
      corners->SetId(k, entry.first->second);
    }
    polys->InsertNextCell(corners);
  }
  piece->SetPoints(points);
  piece->SetPolys(polys);
  piece->GetPointData()->SetGlobalIds(ids);
  return piece;
}

vtkSmartPointer<vtkMaternNoiseFilter> FilterOn(vtkDataObject* input, bool gathered)
{
  auto filter = vtkSmartPointer<vtkMaternNoiseFilter>::New();
  filter->SetInputDataObject(input);
  filter->SetCorrelationRange(0.8);
  filter->SetStandardDeviation(2.0);
  filter->SetGatherPieces(gathered);
  return filter;
}

/// Largest difference of the noise in pieces from that of the gathered surface, over the largest value.
double DifferenceOf(vtkDataObject* a, vtkDataObject* b, const char* name = "MaternNoise")
{
  vtkDataArray* expected = PointArray(b, name);
  double range[2];
  expected->GetRange(range);
  return LargestDifference(PointArray(a, name), expected) / std::max(std::abs(range[0]), std::abs(range[1]));
}

TEST(MaternNoisePieces, AreTheGatheredSurfaceTo1em8)
{
  const auto piece = PieceOf(Icosphere(3).ToPolyData());
  const auto expected = FilterOn(piece, true);
  const auto filter = FilterOn(piece, false);
  for (const double power : { 2.0, 4.0 })
  {
    filter->SetOperatorPower(power);
    expected->SetOperatorPower(power);
    ASSERT_TRUE(Update(filter));
    ASSERT_TRUE(Update(expected));
    EXPECT_LE(DifferenceOf(filter->GetOutput(), expected->GetOutput()), 1e-8);
    EXPECT_NEAR(filter->GetEffectiveScreening(), 8.0 * (power - 1.0) / (0.8 * 0.8), 1e-9);
    EXPECT_STREQ(filter->GetSolverName(), Count() > 1 ? "BoomerAMG" : "Cholesky");
    EXPECT_EQ(filter->GetNumberOfIterations() > 0, Count() > 1);
  }
}

TEST(MaternNoisePieces, ANewSeedKeepsTheMultigridHierarchy)
{
  const auto piece = PieceOf(Icosphere(3).ToPolyData());
  const auto filter = FilterOn(piece, false);
  ASSERT_TRUE(Update(filter));
  EXPECT_EQ(filter->GetNumberOfFactorizations(), 1);
  filter->SetSeed(3);
  filter->SetNumberOfSamples(2);
  filter->SetNumberOfComponents(2);
  ASSERT_TRUE(Update(filter));
  EXPECT_EQ(filter->GetNumberOfFactorizations(), 1);
  const auto expected = FilterOn(piece, true);
  expected->SetSeed(3);
  expected->SetNumberOfSamples(2);
  expected->SetNumberOfComponents(2);
  ASSERT_TRUE(Update(expected));
  EXPECT_LE(DifferenceOf(filter->GetOutput(), expected->GetOutput(), "MaternNoise_1"), 1e-8);
  filter->SetCorrelationRange(0.5);
  ASSERT_TRUE(Update(filter));
  EXPECT_EQ(filter->GetNumberOfFactorizations(), 2);
}

TEST(MaternNoisePieces, BlocksInPiecesHaveTheirOwnNoise)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, PieceOf(Icosphere(3).ToPolyData()));
  blocks->SetBlock(1, PieceOf(Icosphere(2).ToPolyData()));
  const auto expected = FilterOn(blocks, true);
  const auto filter = FilterOn(blocks, false);
  ASSERT_TRUE(Update(filter));
  ASSERT_TRUE(Update(expected));
  for (unsigned int k = 0; k < 2; ++k)
  {
    EXPECT_LE(DifferenceOf(vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0))->GetBlock(k),
                vtkMultiBlockDataSet::SafeDownCast(expected->GetOutputDataObject(0))->GetBlock(k)),
      1e-8);
  }
}

TEST(MaternNoisePieces, ErrorsAreThoseOfAllRanks)
{
  const auto piece = PieceOf(Icosphere(2).ToPolyData());
  const auto errorFor = [](vtkMaternNoiseFilter* noise) {
    const EventRecorder events(noise);
    noise->Update();
    return events.AllErrors();
  };
  const auto filter = FilterOn(piece, false);
  filter->VarianceCorrectionOn();
  EXPECT_EQ(
    errorFor(filter).find("GatherPieces is off, and VarianceCorrection is on") != std::string::npos, Count() > 1);
  filter->VarianceCorrectionOff();
  filter->SetOperatorPower(3);
  EXPECT_EQ(errorFor(filter).find("OperatorPower is another than 2 and 4") != std::string::npos, Count() > 1);
  filter->SetOperatorPower(2);
  EXPECT_EQ(errorFor(filter), "");

  const int last = Count() - 1;
  if (Rank() == last)
  {
    vtkNew<vtkIdList> corners;
    piece->GetCellPoints(0, corners);
    piece->GetPoints()->SetPoint(corners->GetId(1), piece->GetPoints()->GetPoint(corners->GetId(0)));
    piece->GetPoints()->Modified();
  }
  piece->GetPointData()->SetGlobalIds(nullptr);
  piece->GetPointData()->RemoveArray("GlobalPointIds");
  const auto broken = FilterOn(piece, false);
  const std::string error = errorFor(broken);
  EXPECT_THAT(error, HasSubstr("degenerate triangle"));
  if (Count() > 1)
  {
    EXPECT_THAT(error, HasSubstr("Rank " + std::to_string(last)));
  }
  EXPECT_EQ(broken->GetPolyDataOutput()->GetNumberOfPoints(), 0);
}
} // namespace

int main(int argc, char** argv)
{
  vtkNew<vtkMPIController> controller;
  controller->Initialize(&argc, &argv);
  vtkMultiProcessController::SetGlobalController(controller);
  testing::InitGoogleTest(&argc, argv);
  int failed = RUN_ALL_TESTS();
  int anyFailed = 0;
  controller->AllReduce(&failed, &anyFailed, 1, vtkCommunicator::MAX_OP);
  vtkMultiProcessController::SetGlobalController(nullptr);
  controller->Finalize();
  return anyFailed;
}
