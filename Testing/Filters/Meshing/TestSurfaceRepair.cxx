// SPDX-License-Identifier: BSD-3-Clause
//
// Repairs of vtkSurfaceRepairFilter, and its report of them.
#include "SurfaceChecks.h"

#include "MalformedCorpus.h"

#include "vtkIsotropicRemeshFilter.h"
#include "vtkSurfaceRepairFilter.h"
#include "vtkTopologyReport.h"

#include <vtkCellData.h>
#include <vtkDataObjectTree.h>
#include <vtkFieldData.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkStringArray.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

using namespace surfsynthtest;
using Repair = vtkSurfaceRepairFilter;
using surfsynth::MeshDefect;

namespace
{
const double Infinity = std::numeric_limits<double>::infinity();

/// Two unit cubes that share the edge x = y = 1.
Soup TwoCubesOnAnEdge()
{
  Soup soup = Cube(2);
  const Soup second = Cube(2);
  std::vector<vtkIdType> ids;
  for (vtkIdType p = 0; p < second.NumberOfPoints(); ++p)
  {
    const double x = second.Points[3 * p] + 1.0;
    const double y = second.Points[3 * p + 1] + 1.0;
    const double z = second.Points[3 * p + 2];
    vtkIdType id = -1;
    for (vtkIdType q = 0; q < Cube(2).NumberOfPoints() && x == 1.0 && y == 1.0; ++q)
    {
      id = soup.Points[3 * q] == x && soup.Points[3 * q + 1] == y && soup.Points[3 * q + 2] == z ? q : id;
    }
    ids.push_back(id >= 0 ? id : soup.AddPoint(x, y, z));
  }
  for (auto cell : second.Polys)
  {
    std::transform(cell.begin(), cell.end(), cell.begin(), [&](vtkIdType id) { return ids[id]; });
    soup.Polys.push_back(cell);
  }
  return soup;
}

/// A surface with one kind of defect, and the phrase by which the report says that it was mended.
struct DefectCase
{
  MeshDefect Defect;
  std::function<Soup()> Make;
  std::string Phrase;
  std::string Name;
};

std::vector<DefectCase> DefectCases()
{
  const auto change = [](const std::function<void(Soup&)>& edit) {
    return [edit] {
      Soup soup = Icosphere(2);
      edit(soup);
      return soup;
    };
  };
  return {
    { MeshDefect::IndexOutOfRange, change([](Soup& s) {
       s.Polys.push_back({ 0, 1, 1000000 });
     }),
      "name a point which does not exist", "IndexOutOfRange" },
    { MeshDefect::NonFinitePoint, change([](Soup& s) { s.Points[30] = Infinity; }), "NaN or infinite",
      "NonFinitePoint" },
    { MeshDefect::RepeatedVertex, change([](Soup& s) {
       s.Polys.push_back({ 4, 4, 5 });
     }),
      "without three different points", "RepeatedVertex" },
    { MeshDefect::DegenerateTriangle, change([](Soup& s) {
       // The middle of an edge as a corner of its own.
       const auto cell = s.Polys[0];
       const double* a = &s.Points[3 * cell[0]];
       const double* b = &s.Points[3 * cell[1]];
       const vtkIdType middle = s.AddPoint(0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.5 * (a[2] + b[2]));
       s.Polys[0] = { cell[0], middle, cell[2] };
       s.Polys.push_back({ middle, cell[1], cell[2] });
       s.Polys.push_back({ cell[0], cell[1], middle });
     }),
      "triangles without area removed", "DegenerateTriangle" },
    { MeshDefect::NonManifoldEdge, change([](Soup& s) {
       const auto cell = s.Polys[0];
       s.Polys.push_back({ cell[0], cell[1], s.AddPoint(0, 0, 0) });
     }),
      "sheets met there", "NonManifoldEdge" },
    { MeshDefect::NonManifoldVertex, change([](Soup& s) {
       const vtkIdType a = s.AddPoint(3, 0, 0);
       s.Polys.push_back({ 0, a, s.AddPoint(3, 1, 0) });
     }),
      "points copied", "NonManifoldVertex" },
    { MeshDefect::InconsistentWinding, change([](Soup& s) { std::reverse(s.Polys[7].begin(), s.Polys[7].end()); }),
      "triangles turned around", "InconsistentWinding" },
    { MeshDefect::BoundaryEdge, change([](Soup& s) { s.Polys.resize(s.Polys.size() - 3); }), "holes closed",
      "BoundaryEdge" },
    { MeshDefect::SeveralComponents, change([](Soup& s) {
       const vtkIdType a = s.AddPoint(3, 0, 0);
       const vtkIdType b = s.AddPoint(4, 0, 0);
       s.Polys.push_back({ a, b, s.AddPoint(3, 1, 0) });
     }),
      "components removed", "SeveralComponents" },
  };
}

surfsynth::MeshRequirements Everything()
{
  surfsynth::MeshRequirements all = ValidSurface(true);
  all.SingleComponent = true;
  return all;
}

class RepairOfDefect : public ::testing::TestWithParam<DefectCase>
{};

class RepairOfCorpus : public ::testing::TestWithParam<MalformedCase>
{};
} // namespace

TEST_P(RepairOfDefect, LeavesASphereThatTheGateAccepts)
{
  const auto input = GetParam().Make().ToPolyData();
  vtkNew<Repair> filter;
  filter->SetHoleFillingToAll();
  filter->KeepLargestComponentOn();
  const auto output = OutputOf(filter, input);
  ASSERT_TRUE(output);
  const auto findings = surfsynth::CheckMesh(MeshOf(output), Everything());
  EXPECT_TRUE(findings.empty()) << surfsynth::DescribeFindings(findings);
  EXPECT_EQ(EulerCharacteristic(output), 2);
  EXPECT_NEAR(VolumeOf(output), VolumeOf(Icosphere(2).ToPolyData()), 0.05);
  EXPECT_NE(std::string(filter->GetReport()).find(GetParam().Phrase), std::string::npos) << filter->GetReport();
}

TEST_P(RepairOfDefect, IsWhatTheGateRecommends)
{
  const std::string text = surfsynth::DescribeFindings({ { GetParam().Defect, 1, 0 } });
  EXPECT_NE(text.find("vtkSurfaceRepairFilter"), std::string::npos) << text;
}

INSTANTIATE_TEST_SUITE_P(
  EveryDefect, RepairOfDefect, ::testing::ValuesIn(DefectCases()), [](const auto& info) { return info.param.Name; });

/// Surfaces that can be repaired are valid afterwards, and closed when asked; others are refused.
TEST_P(RepairOfCorpus, GivesAValidSurfaceOrAnError)
{
  const vtkSmartPointer<vtkDataObject> input = GetParam().Make();
  for (const int holes : { Repair::NO_HOLES, Repair::ALL_HOLES })
  {
    vtkNew<Repair> filter;
    filter->SetHoleFilling(holes);
    EventRecorder events(filter);
    filter->SetInputDataObject(input);
    const bool succeeded = Update(filter);
    auto* output = vtkPolyData::SafeDownCast(filter->GetOutputDataObject(0));
    if (succeeded && output && output->GetNumberOfCells() > 0)
    {
      ExpectValid(output, holes == Repair::ALL_HOLES && filter->GetNumberOfOpenHoles() == 0);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
  Corpus, RepairOfCorpus, ::testing::ValuesIn(MalformedCorpus()), [](const auto& info) { return info.param.Name; });

TEST(SurfaceRepair, ValidSurfacesStayBitForBit)
{
  const auto sphere = Icosphere(3).ToPolyData();
  AddPointArray(sphere, "x", [](const double* p) { return p[0]; });
  vtkNew<Repair> filter;
  const auto output = OutputOf(filter, sphere);
  EXPECT_STREQ(filter->GetReport(), "");
  EXPECT_TRUE(SameBits(output->GetPoints()->GetData(), sphere->GetPoints()->GetData()));
  EXPECT_TRUE(SameBits(output->GetPointData()->GetArray("x"), sphere->GetPointData()->GetArray("x")));
  EXPECT_EQ(MeshOf(output).Triangles.rows(), MeshOf(sphere).Triangles.rows());
  EXPECT_EQ(output->GetFieldData()->GetAbstractArray("RepairAction")->GetNumberOfTuples(), 0);
}

TEST(SurfaceRepair, CubesThatShareAnEdgeBecomeTwoClosedCubes)
{
  vtkNew<Repair> filter;
  filter->SetHoleFillingToNone();
  const auto output = OutputOf(filter, TwoCubesOnAnEdge().ToPolyData());
  ExpectValid(output, true);
  EXPECT_EQ(EulerCharacteristic(output), 4) << "two spheres";
  EXPECT_NEAR(VolumeOf(output), 2.0, 0.03) << "moved apart a little";
  vtkNew<Repair> again; // as a file without connectivity would be read
  EXPECT_EQ(OutputOf(again, output)->GetNumberOfPoints(), output->GetNumberOfPoints());
  EXPECT_STREQ(again->GetReport(), "");
}

TEST(SurfaceRepair, SheetsTakenApartStayApartWithinTheMergeTolerance)
{
  for (const double tolerance : { 0.001, 0.01, 0.02, 0.1 }) // of edges of length 1
  {
    vtkNew<Repair> filter;
    filter->SetMergeTolerance(tolerance);
    const auto output = OutputOf(filter, TwoCubesOnAnEdge().ToPolyData());
    ExpectValid(output, true);
    vtkNew<Repair> again;
    again->SetMergeTolerance(tolerance);
    const auto second = OutputOf(again, output);
    EXPECT_STREQ(again->GetReport(), "") << tolerance;
    EXPECT_TRUE(SameBits(second->GetPoints()->GetData(), output->GetPoints()->GetData())) << tolerance;
  }
}

TEST(SurfaceRepair, HolesUpToTheLimitAreClosedAndMarked)
{
  Soup soup = Icosphere(3);
  soup.Polys.pop_back(); // a hole of one triangle
  soup.Polys.erase(std::remove_if(soup.Polys.begin(), soup.Polys.end(),
                     [&](const auto& cell) { return soup.Points[3 * cell[0] + 2] > 0.8; }),
    soup.Polys.end()); // and a cap
  const auto sphere = soup.ToPolyData();
  vtkNew<Repair> filter;
  const auto small = OutputOf(filter, sphere);
  ExpectValid(small, false);
  EXPECT_NE(std::string(filter->GetReport()).find("1: holes closed"), std::string::npos) << filter->GetReport();
  EXPECT_NE(std::string(filter->GetReport()).find("1: boundaries left open"), std::string::npos);

  filter->SetMaximumHoleSize(2.0);
  const auto all = OutputOf(filter, sphere);
  ExpectValid(all, true);
  EXPECT_NEAR(VolumeOf(all), VolumeOf(Icosphere(3).ToPolyData()), 0.1) << "the cap continues the curvature";
  vtkDataArray* filled = all->GetCellData()->GetArray("FilledHole");
  double marked = 0.0;
  for (vtkIdType c = 0; c < filled->GetNumberOfTuples(); ++c)
  {
    marked += filled->GetTuple1(c);
  }
  EXPECT_EQ(marked, static_cast<double>(all->GetNumberOfCells() - sphere->GetNumberOfCells()));
}

TEST(SurfaceRepair, TheActiveResultIsTheMarkOfFilledHoles)
{
  Soup soup = Icosphere(3);
  const auto whole = soup.ToPolyData();
  soup.Polys.pop_back();
  const auto open = soup.ToPolyData();
  for (vtkPolyData* surface : { whole.Get(), open.Get() })
  {
    vtkNew<vtkDoubleArray> pressure;
    pressure->SetName("Pressure");
    pressure->SetNumberOfTuples(surface->GetNumberOfPoints());
    pressure->Fill(1.0);
    surface->GetPointData()->SetScalars(pressure);
    for (const bool active : { false, true })
    {
      vtkNew<Repair> filter;
      filter->SetActiveResult(active);
      const auto output = OutputOf(filter, surface);
      const bool isMarked = active && surface == open.Get();
      vtkDataArray* scalars = output->GetPointData()->GetScalars();
      EXPECT_STREQ(scalars ? scalars->GetName() : "none", isMarked ? "none" : "Pressure");
      EXPECT_EQ(output->GetCellData()->GetScalars() != nullptr, isMarked);
    }
  }
}

TEST(SurfaceRepair, SmallComponentsGoWhenAsked)
{
  Soup soup = Icosphere(2);
  const vtkIdType first = soup.AddPoint(5, 0, 0);
  soup.AddPoint(5.01, 0, 0);
  soup.AddPoint(5, 0.01, 0);
  soup.Polys.push_back({ first, first + 1, first + 2 });
  vtkNew<Repair> filter;
  filter->SetHoleFillingToNone();
  EXPECT_EQ(OutputOf(filter, soup.ToPolyData())->GetNumberOfCells(), 321);
  filter->SetMinimumComponentFraction(0.01);
  EXPECT_EQ(OutputOf(filter, soup.ToPolyData())->GetNumberOfCells(), 320);
}

TEST(SurfaceRepair, ClosedSurfacesFaceOutwardAndOpenOnesStay)
{
  Soup inward = Icosphere(2);
  for (auto& cell : inward.Polys)
  {
    std::reverse(cell.begin(), cell.end());
  }
  vtkNew<Repair> filter;
  EXPECT_GT(VolumeOf(OutputOf(filter, inward.ToPolyData())), 4.0);
  filter->OrientOutwardOff();
  EXPECT_LT(VolumeOf(OutputOf(filter, inward.ToPolyData())), -4.0);

  Soup open = Grid(6);
  std::reverse(open.Polys[0].begin(), open.Polys[0].end()); // the first decides nothing, the majority does
  const auto output = OutputOf(filter, open.ToPolyData());
  const auto mesh = MeshOf(output);
  const Eigen::Vector3d a = (mesh.Points.row(mesh.Triangles(0, 1)) - mesh.Points.row(mesh.Triangles(0, 0))).transpose();
  const Eigen::Vector3d b = (mesh.Points.row(mesh.Triangles(0, 2)) - mesh.Points.row(mesh.Triangles(0, 0))).transpose();
  EXPECT_GT(a[0] * b[1] - a[1] * b[0], 0.0);
}

TEST(SurfaceRepair, CavitiesFaceInward)
{
  Soup soup = Icosphere(2);
  const Soup inner = Icosphere(2);
  for (const auto& cell : inner.Polys)
  {
    std::vector<vtkIdType> moved;
    for (const vtkIdType id : cell)
    {
      moved.push_back(id + inner.NumberOfPoints());
    }
    soup.Polys.push_back(moved);
  }
  for (vtkIdType p = 0; p < inner.NumberOfPoints(); ++p)
  {
    soup.AddPoint(0.5 * inner.Points[3 * p], 0.5 * inner.Points[3 * p + 1], 0.5 * inner.Points[3 * p + 2]);
  }
  vtkNew<Repair> filter;
  const double sphere = VolumeOf(Icosphere(2).ToPolyData());
  EXPECT_NEAR(VolumeOf(OutputOf(filter, soup.ToPolyData())), sphere * (1.0 - 0.125), 1e-9);
}

TEST(SurfaceRepair, MergeToleranceClosesGaps)
{
  Soup soup;
  for (const double gap : { 0.0, 1e-4 })
  {
    const vtkIdType first = soup.NumberOfPoints();
    for (const double y : { 0.0, 1.0 })
    {
      soup.AddPoint(gap > 0.0 ? 1.0 + gap : 0.0, y, 0.0);
      soup.AddPoint(gap > 0.0 ? 2.0 : 1.0, y, 0.0);
    }
    soup.Polys.push_back({ first, first + 1, first + 3, first + 2 });
  }
  vtkNew<Repair> filter;
  filter->SetHoleFillingToNone();
  EXPECT_EQ(OutputOf(filter, soup.ToPolyData())->GetNumberOfPoints(), 8);
  filter->SetMergeTolerance(1e-3);
  EXPECT_EQ(OutputOf(filter, soup.ToPolyData())->GetNumberOfPoints(), 6);
  filter->MergePointsOff();
  EXPECT_EQ(OutputOf(filter, soup.ToPolyData())->GetNumberOfPoints(), 8);
}

TEST(SurfaceRepair, SelfIntersectionsGoWhenAsked)
{
  Soup soup = Icosphere(3);
  // One point pulled through the other side.
  const double p[3] = { soup.Points[300], soup.Points[301], soup.Points[302] };
  for (int k = 0; k < 3; ++k)
  {
    soup.Points[300 + k] = -1.2 * p[k];
  }
  vtkNew<Repair> filter;
  filter->RemoveSelfIntersectionsOn();
  const auto output = OutputOf(filter, soup.ToPolyData());
  ExpectValid(output, true);
  EXPECT_NE(std::string(filter->GetReport()).find("intersecting triangles removed"), std::string::npos)
    << filter->GetReport();
  EXPECT_EQ(std::string(filter->GetReport()).find("could not be removed"), std::string::npos) << filter->GetReport();
  EXPECT_LT(LargestDistance(output, Icosphere(3).ToPolyData()), 0.5) << "the spike is gone";
}

/// Points and triangles of a dataset are those of another one, bit for bit.
void ExpectSame(vtkPolyData* a, vtkPolyData* b)
{
  EXPECT_TRUE(SameBits(a->GetPoints()->GetData(), b->GetPoints()->GetData()));
  ASSERT_EQ(a->GetNumberOfCells(), b->GetNumberOfCells());
  EXPECT_EQ(MeshOf(a).Triangles, MeshOf(b).Triangles);
}

/// A sphere without its cap, and with a spike through the other side.
Soup SphereWithDefects()
{
  Soup soup = Icosphere(3);
  soup.Polys.erase(std::remove_if(soup.Polys.begin(), soup.Polys.end(),
                     [&](const auto& cell) { return soup.Points[3 * cell[0] + 2] > 0.6; }),
    soup.Polys.end());
  for (int k = 0; k < 3; ++k)
  {
    soup.Points[300 + k] *= -1.2;
  }
  return soup;
}

TEST(SurfaceRepair, ASecondRepairChangesNothing)
{
  for (const int type : { VTK_FLOAT, VTK_DOUBLE })
  {
    vtkNew<Repair> filter;
    filter->SetHoleFillingToAll();
    filter->RemoveSelfIntersectionsOn();
    EventRecorder events(filter);
    const vtkSmartPointer<vtkPolyData> first = OutputOf(filter, SphereWithDefects().ToPolyData(type));
    ExpectValid(first, true);
    EXPECT_EQ(filter->GetNumberOfIntersectingTriangles(), 0);
    EXPECT_EQ(filter->GetNumberOfOpenHoles(), 0);
    vtkNew<vtkPolyData> kept;
    kept->DeepCopy(first);
    const auto second = OutputOf(filter, kept);
    ExpectSame(second, kept);
    EXPECT_STREQ(filter->GetReport(), "");
    EXPECT_TRUE(filter->GetComplete());
  }
}

TEST(SurfaceRepair, AreaLostBeyondTheBoundIsSaid)
{
  vtkNew<Repair> filter;
  filter->RemoveSelfIntersectionsOn();
  EventRecorder events(filter);
  filter->SetInputData(SphereWithDefects().ToPolyData());
  ASSERT_TRUE(Update(filter));
  EXPECT_GT(filter->GetAreaLoss(), 0.05) << "the spike";
  EXPECT_FALSE(filter->GetComplete());
  ASSERT_EQ(events.Warnings.size(), 1u);
  EXPECT_NE(events.Warnings[0].find("of the area, from "), std::string::npos) << events.Warnings[0];
  filter->SetMaximumLoss(0.2);
  ASSERT_TRUE(Update(filter));
  EXPECT_TRUE(filter->GetComplete());
  EXPECT_EQ(events.Warnings.size(), 1u);
  filter->SetMaximumLoss(0.05);
  filter->StrictOn();
  ExpectRefusal(filter, SphereWithDefects().ToPolyData(), { "of the area, from ", "more than MaximumLoss (5 %)" });
}

/// Two spheres that overlap: CGAL's local removal cuts their common part away.
Soup OverlappingSpheres()
{
  Soup soup = Icosphere(1);
  const Soup other = Icosphere(1);
  const vtkIdType shift = soup.NumberOfPoints();
  for (vtkIdType p = 0; p < other.NumberOfPoints(); ++p)
  {
    soup.AddPoint(other.Points[3 * p] + 1.3, other.Points[3 * p + 1] + 0.01, other.Points[3 * p + 2] + 0.02);
  }
  for (auto cell : other.Polys)
  {
    std::transform(cell.begin(), cell.end(), cell.begin(), [&](vtkIdType id) { return id + shift; });
    soup.Polys.push_back(cell);
  }
  return soup;
}

TEST(SurfaceRepair, RemovalsBeyondTheBoundAreRefusedAndSaid)
{
  const auto input = OverlappingSpheres().ToPolyData();
  vtkNew<Repair> filter;
  filter->RemoveSelfIntersectionsOn();
  filter->SetMaximumLoss(0.0);
  EventRecorder events(filter);
  filter->SetInputData(input);
  ASSERT_TRUE(Update(filter));
  ASSERT_EQ(events.Warnings.size(), 1u);
  EXPECT_NE(events.Warnings[0].find("still intersect others: their removal would change"), std::string::npos)
    << events.Warnings[0];
  EXPECT_FALSE(filter->GetComplete());
  EXPECT_GT(filter->GetNumberOfIntersectingTriangles(), 0);
  EXPECT_EQ(filter->GetAreaLoss(), 0.0) << "nothing was removed";
  EXPECT_EQ(filter->GetVolumeLoss(), 0.0);
  EXPECT_EQ(filter->GetComponentChange(), 0.0);
  filter->StrictOn();
  ExpectRefusal(filter, input, { "still intersect others" });
  EXPECT_FALSE(filter->GetComplete());
}

TEST(SurfaceRepair, RemovedComponentsAreNoLoss)
{
  Soup soup = Icosphere(2);
  const Soup other = Icosphere(1);
  for (vtkIdType p = 0; p < other.NumberOfPoints(); ++p)
  {
    soup.AddPoint(other.Points[3 * p] + 5.0, other.Points[3 * p + 1], other.Points[3 * p + 2]);
  }
  const vtkIdType shift = soup.NumberOfPoints() - other.NumberOfPoints();
  for (const auto& cell : other.Polys)
  {
    soup.Polys.push_back({ cell[0] + shift, cell[1] + shift, cell[2] + shift });
  }
  vtkNew<Repair> filter;
  filter->KeepLargestComponentOn();
  EXPECT_EQ(OutputOf(filter, soup.ToPolyData())->GetNumberOfCells(), 320);
  EXPECT_TRUE(filter->GetComplete());
  EXPECT_NEAR(filter->GetAreaLoss(), 0.0, 1e-12);
  EXPECT_NEAR(filter->GetVolumeLoss(), 0.0, 1e-12);
  EXPECT_EQ(filter->GetComponentChange(), 0.0);
}

TEST(SurfaceRepair, MeasuresAreFieldData)
{
  vtkNew<Repair> filter;
  filter->RemoveSelfIntersectionsOn();
  const auto output = OutputOf(filter, Icosphere(2).ToPolyData());
  auto* names = vtkStringArray::SafeDownCast(output->GetFieldData()->GetAbstractArray("RepairMeasure"));
  vtkDataArray* before = output->GetFieldData()->GetArray("RepairBefore");
  vtkDataArray* after = output->GetFieldData()->GetArray("RepairAfter");
  ASSERT_TRUE(names && before && after);
  const char* const expected[] = { "Area", "Volume", "Components", "IntersectingTriangles" };
  ASSERT_EQ(names->GetNumberOfValues(), 4);
  for (vtkIdType k = 0; k < 4; ++k)
  {
    EXPECT_EQ(names->GetValue(k), expected[k]);
    EXPECT_EQ(before->GetTuple1(k), after->GetTuple1(k));
  }
  EXPECT_NEAR(after->GetTuple1(1), VolumeOf(output), 1e-9);
}

TEST(SurfaceRepair, ReportRepairAndRemeshAgreeOnOneTriangleAndOnTwoOppositeOnes)
{
  Soup one;
  one.AddPoint(0, 0, 0);
  one.AddPoint(1, 0, 0);
  one.AddPoint(0, 1, 0);
  one.Polys.push_back({ 0, 1, 2 });
  Soup two = one;
  two.Polys.push_back({ 0, 2, 1 });
  vtkNew<vtkTopologyReport> report;
  vtkNew<vtkIsotropicRemeshFilter> remesh;
  for (const bool isDouble : { false, true })
  {
    const auto input = (isDouble ? two : one).ToPolyData();
    report->SetInputData(input);
    report->Update();
    EXPECT_EQ(report->GetValid(), !isDouble);
    isDouble ? ExpectRefusal(remesh, input, { "the same three points" }) : static_cast<void>(OutputOf(remesh, input));
    for (const int holes : { Repair::NO_HOLES, Repair::SMALL_HOLES, Repair::ALL_HOLES })
    {
      vtkNew<Repair> filter;
      filter->SetHoleFilling(holes);
      const auto output = OutputOf(filter, input);
      EXPECT_EQ(output->GetNumberOfCells(), 1);
      EXPECT_EQ(filter->GetNumberOfOpenHoles(), holes == Repair::ALL_HOLES ? 1 : 0);
      report->SetInputData(output);
      report->Update();
      EXPECT_TRUE(report->GetValid());
      OutputOf(remesh, output);
    }
  }
}

TEST(SurfaceRepair, ReportIsFieldDataAndText)
{
  Soup soup = Icosphere(1);
  soup.Polys.push_back(soup.Polys[0]);
  soup.Polys.push_back(soup.Polys[1]);
  vtkNew<Repair> filter;
  const auto output = OutputOf(filter, soup.ToPolyData());
  auto* actions = vtkStringArray::SafeDownCast(output->GetFieldData()->GetAbstractArray("RepairAction"));
  vtkDataArray* counts = output->GetFieldData()->GetArray("RepairCount");
  ASSERT_TRUE(actions && counts);
  ASSERT_EQ(actions->GetNumberOfValues(), 1);
  EXPECT_EQ(actions->GetValue(0), "duplicate triangles removed");
  EXPECT_EQ(counts->GetTuple1(0), 2.0);
  EXPECT_STREQ(filter->GetReport(), "2: duplicate triangles removed\n");

  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, soup.ToPolyData());
  filter->SetInputDataObject(blocks);
  EXPECT_TRUE(Update(filter));
  EXPECT_STREQ(filter->GetReport(), "Block 1: 2: duplicate triangles removed\n");
}

TEST(SurfaceRepair, ArraysComeAlong)
{
  Soup soup = Icosphere(3);
  soup.Polys.erase(soup.Polys.begin(), soup.Polys.begin() + 4);
  const auto sphere = soup.ToPolyData();
  AddPointArray(sphere, "z", [](const double* p) { return p[2]; });
  AddPointArray(
    sphere, "side", [](const double* p) { return p[2] > 0.0; }, VTK_INT);
  vtkNew<Repair> filter;
  filter->SetHoleFillingToAll();
  const auto output = OutputOf(filter, sphere);
  ExpectValid(output, true);
  for (vtkIdType p = 0; p < output->GetNumberOfPoints(); ++p)
  {
    EXPECT_NEAR(output->GetPointData()->GetArray("z")->GetTuple1(p), output->GetPoint(p)[2], 0.05);
  }
  EXPECT_TRUE(output->GetPointData()->GetArray("side"));
}

TEST(SurfaceRepair, NothingLeftIsAnError)
{
  Soup soup;
  soup.AddPoint(0, 0, 0);
  soup.AddPoint(1, 0, 0);
  soup.AddPoint(2, 0, 0);
  soup.Polys.push_back({ 0, 1, 2 });
  vtkNew<Repair> filter;
  ExpectRefusal(filter, soup.ToPolyData(), { "No valid triangle is left" });
}

TEST(SurfaceRepair, ParametersAreClampedAndPrinted)
{
  vtkNew<Repair> filter;
  filter->SetHoleFilling(17);
  filter->SetMergeTolerance(-2.0);
  filter->SetMinimumComponentFraction(3.0);
  EXPECT_EQ(filter->GetHoleFilling(), Repair::ALL_HOLES);
  EXPECT_EQ(filter->GetMergeTolerance(), 0.0);
  EXPECT_EQ(filter->GetMinimumComponentFraction(), 1.0);
  std::ostringstream text;
  filter->Print(text);
  for (const char* name : { "MergePoints: 1", "MergeTolerance: 0", "HoleFilling: 2", "MaximumHoleSize: 0",
         "KeepLargestComponent: 0", "MinimumComponentFraction: 1", "RemoveSelfIntersections: 0", "OrientOutward: 1",
         "MaximumLoss: 0.05", "Strict: 0", "ActiveResult: 0", "Complete: 0" })
  {
    EXPECT_NE(text.str().find(name), std::string::npos) << name;
  }
}
