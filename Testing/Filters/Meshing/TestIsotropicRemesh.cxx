// SPDX-License-Identifier: BSD-3-Clause
//
// Output of vtkIsotropicRemeshFilter: shape, curves, attributes.
#include "SurfaceChecks.h"

#include "vtkIsotropicRemeshFilter.h"

#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkIntArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <sstream>
#include <string>

using namespace surfsynthtest;
using Remesh = vtkIsotropicRemeshFilter;

namespace
{
vtkSmartPointer<vtkPolyData> Remeshed(vtkDataObject* input, double edgeLength)
{
  vtkNew<Remesh> filter;
  filter->SetTargetEdgeLength(edgeLength);
  return OutputOf(filter, input);
}

/// The unit square cut at x = 0.5 into two halves that do not share points; "u" jumps there.
vtkSmartPointer<vtkPolyData> SquareWithSeam(int n, bool jumps)
{
  Soup soup;
  for (const double left : { 0.0, 0.5 })
  {
    const vtkIdType first = soup.NumberOfPoints();
    for (int j = 0; j <= 2 * n; ++j)
    {
      for (int i = 0; i <= n; ++i)
      {
        soup.AddPoint(left + 0.5 * i / n, 0.5 * j / n, 0.0);
      }
    }
    for (int j = 0; j < 2 * n; ++j)
    {
      for (int i = 0; i < n; ++i)
      {
        const vtkIdType a = first + j * (n + 1) + i;
        soup.Polys.push_back({ a, a + 1, a + n + 2, a + n + 1 });
      }
    }
  }
  auto square = soup.ToPolyData();
  const vtkIdType half = square->GetNumberOfPoints() / 2;
  vtkNew<vtkDoubleArray> u;
  u->SetName("u");
  for (vtkIdType p = 0; p < square->GetNumberOfPoints(); ++p)
  {
    u->InsertNextValue(square->GetPoint(p)[0] + (jumps && p >= half ? 10.0 : 0.0));
  }
  square->GetPointData()->AddArray(u);
  return square;
}

bool OnSide(const double* point)
{
  const auto at = [](double x, double side) { return std::abs(x - side) < 1e-9; };
  return at(point[0], 0.0) || at(point[0], 1.0) || at(point[1], 0.0) || at(point[1], 1.0);
}
} // namespace

TEST(IsotropicRemesh, EdgesGetTheWantedLengthAndTrianglesAGoodShape)
{
  const auto sphere = RingSphere(60, 60);
  for (const double length : { 0.04, 0.1, 0.2 })
  {
    const auto output = Remeshed(sphere, length);
    ExpectValid(output, true);
    const Shapes shapes = ShapesOf(output);
    EXPECT_NEAR(shapes.MeanEdge, 0.92 * length, 0.1 * length);
    EXPECT_GT(shapes.ShortestEdge, 0.4 * length);
    EXPECT_LT(shapes.LongestEdge, 1.6 * length);
    EXPECT_GT(shapes.SmallestAngle, 20.0);
    EXPECT_EQ(EulerCharacteristic(output), 2);
    EXPECT_LT(LargestDistance(output, sphere), 1e-12) << "points lie on the input";
    EXPECT_NEAR(VolumeOf(output), VolumeOf(sphere), 0.02 * VolumeOf(sphere)) << "and are wound alike";
  }
}

TEST(IsotropicRemesh, DefaultLengthIsTheMeanOfTheInput)
{
  const auto sphere = RingSphere(60, 60);
  const double mean = ShapesOf(sphere).MeanEdge;
  vtkNew<Remesh> filter;
  const auto output = OutputOf(filter, sphere);
  EXPECT_NEAR(ShapesOf(output).MeanEdge, 0.92 * mean, 0.1 * mean);
  EXPECT_NEAR(filter->GetMeanEdgeLength(), ShapesOf(output).MeanEdge, 1e-12);
}

TEST(IsotropicRemesh, NumberOfPointsIsMetWithinTwoPerCent)
{
  const auto sphere = Icosphere(4).ToPolyData();
  for (const int points : { 500, 2000, 6000 })
  {
    vtkNew<Remesh> filter;
    filter->SetTargetNumberOfPoints(points);
    EXPECT_NEAR(OutputOf(filter, sphere)->GetNumberOfPoints(), points, 0.02 * points);
  }
}

TEST(IsotropicRemesh, SizingArrayGovernsTheLocalEdgeLength)
{
  const auto sphere = Icosphere(4).ToPolyData();
  const auto wanted = [](const double* p) { return 0.05 + 0.05 * (p[2] + 1.0); };
  AddPointArray(sphere, "size", wanted);
  AddPointArray(sphere, "half", [&](const double* p) { return 0.5 * wanted(p); });
  vtkNew<Remesh> filter;
  filter->SetSizingArrayName("size");
  const auto output = OutputOf(filter, sphere);
  ExpectValid(output, true);
  EXPECT_GT(ShapesOf(output).SmallestAngle, 20.0);
  EXPECT_LT(LargestDistance(output, sphere), 1e-12);
  const surfsynth::TriangleMesh mesh = MeshOf(output);
  for (Eigen::Index f = 0; f < mesh.Triangles.rows(); ++f)
  {
    const Eigen::Vector3d a = mesh.Points.row(mesh.Triangles(f, 0)).transpose();
    const Eigen::Vector3d b = mesh.Points.row(mesh.Triangles(f, 1)).transpose();
    const Eigen::Vector3d middle = 0.5 * (a + b);
    EXPECT_NEAR((a - b).norm() / wanted(middle.data()), 0.95, 0.5);
  }
  filter->SetSizingArrayName("half");
  EXPECT_NEAR(
    OutputOf(filter, sphere)->GetNumberOfPoints(), 4.0 * mesh.NumberOfPoints(), 0.1 * 4.0 * mesh.NumberOfPoints());
  filter->SetTargetNumberOfPoints(1500);
  EXPECT_NEAR(OutputOf(filter, sphere)->GetNumberOfPoints(), 1500, 30) << "then only ratios count";
}

TEST(IsotropicRemesh, CreasesAndCornersStay)
{
  const auto cube = Cube(6).ToPolyData();
  const auto output = Remeshed(cube, 0.11);
  ExpectValid(output, true);
  EXPECT_NEAR(VolumeOf(output), 1.0, 1e-12);
  EXPECT_NEAR(AreaOf(output), 6.0, 1e-12);
  const auto corners = PointsWhere(
    output, [](const double* p) { return p[0] * (1.0 - p[0]) + p[1] * (1.0 - p[1]) + p[2] * (1.0 - p[2]) == 0.0; });
  EXPECT_EQ(corners.size(), 8u);

  vtkNew<Remesh> smooth;
  smooth->SetTargetEdgeLength(0.11);
  smooth->KeepFeatureEdgesOff();
  EXPECT_LT(VolumeOf(OutputOf(smooth, cube)), 0.9999) << "without, corners are cut";
  vtkNew<Remesh> wide;
  wide->SetTargetEdgeLength(0.11);
  wide->SetFeatureAngle(95.0);
  EXPECT_LT(VolumeOf(OutputOf(wide, cube)), 0.9999) << "the angle decides";
}

TEST(IsotropicRemesh, BoundariesStayOnTheirCurve)
{
  const auto square = Grid(7).ToPolyData();
  for (const double length : { 0.05, 0.3 })
  {
    const auto output = Remeshed(square, length);
    ExpectValid(output, false);
    EXPECT_NEAR(AreaOf(output), 1.0, 1e-12);
    EXPECT_EQ(EulerCharacteristic(output), 1);
    EXPECT_EQ(
      PointsWhere(output, [](const double* p) { return (p[0] == 0.0 || p[0] == 1.0) && (p[1] == 0.0 || p[1] == 1.0); })
        .size(),
      4u);
  }
}

TEST(IsotropicRemesh, PointsOfABoundaryStayWhenAsked)
{
  const auto square = Grid(10).ToPolyData();
  for (const double length : { 0.04, 0.3 })
  {
    vtkNew<Remesh> filter;
    filter->SetTargetEdgeLength(length);
    filter->KeepBoundaryPointsOn();
    const auto output = OutputOf(filter, square);
    ExpectValid(output, false);
    std::set<std::pair<double, double>> kept;
    for (const vtkIdType p : PointsWhere(output, OnSide))
    {
      kept.insert(std::make_pair(output->GetPoint(p)[0], output->GetPoint(p)[1]));
    }
    for (const vtkIdType p : PointsWhere(square, OnSide))
    {
      EXPECT_EQ(kept.count(std::make_pair(square->GetPoint(p)[0], square->GetPoint(p)[1])), 1u);
    }
  }
}

TEST(IsotropicRemesh, ArraysAreInterpolated)
{
  const auto square = Grid(9).ToPolyData();
  AddPointArray(square, "linear", [](const double* p) { return 2.0 * p[0] - 3.0 * p[1] + 1.0; });
  AddPointArray(
    square, "single", [](const double* p) { return p[0]; }, VTK_FLOAT);
  AddPointArray(
    square, "label", [](const double* p) { return p[0] < 0.5 ? 3 : 8; }, VTK_INT);
  vtkNew<vtkIntArray> cellArray;
  cellArray->SetName("cell");
  for (vtkIdType c = 0; c < square->GetNumberOfCells(); ++c)
  {
    double bounds[6];
    square->GetCellBounds(c, bounds);
    cellArray->InsertNextValue(bounds[2] < 0.44 ? 1 : 2);
  }
  square->GetCellData()->SetScalars(cellArray);
  const auto output = Remeshed(square, 0.06);
  vtkPointData* data = output->GetPointData();
  ASSERT_TRUE(data->GetArray("linear") && data->GetArray("single") && data->GetArray("label"));
  EXPECT_EQ(data->GetArray("single")->GetDataType(), VTK_FLOAT);
  EXPECT_STREQ(output->GetCellData()->GetScalars()->GetName(), "cell") << "active attributes stay active";
  for (vtkIdType p = 0; p < output->GetNumberOfPoints(); ++p)
  {
    const double* x = output->GetPoint(p);
    EXPECT_NEAR(data->GetArray("linear")->GetTuple1(p), 2.0 * x[0] - 3.0 * x[1] + 1.0, 1e-12);
    EXPECT_NEAR(data->GetArray("single")->GetTuple1(p), x[0], 1e-6);
    const double label = data->GetArray("label")->GetTuple1(p);
    EXPECT_TRUE(label == 3.0 || label == 8.0) << "labels are not mixed";
  }
  for (vtkIdType c = 0; c < output->GetNumberOfCells(); ++c)
  {
    double bounds[6];
    output->GetCellBounds(c, bounds);
    const double value = output->GetCellData()->GetArray("cell")->GetTuple1(c);
    EXPECT_TRUE(bounds[3] < 0.44 ? value == 1.0 : bounds[2] > 0.45 ? value == 2.0 : value == 1.0 || value == 2.0);
  }
}

TEST(IsotropicRemesh, NormalsStayUnitVectorsAndNormals)
{
  const auto sphere = Icosphere(2).ToPolyData();
  vtkNew<vtkDoubleArray> normals;
  normals->SetName("n");
  normals->SetNumberOfComponents(3);
  for (vtkIdType p = 0; p < sphere->GetNumberOfPoints(); ++p)
  {
    normals->InsertNextTuple(sphere->GetPoint(p));
  }
  sphere->GetPointData()->SetNormals(normals);
  const auto output = Remeshed(sphere, 0.1);
  vtkDataArray* made = output->GetPointData()->GetNormals();
  ASSERT_TRUE(made);
  for (vtkIdType p = 0; p < output->GetNumberOfPoints(); ++p)
  {
    const double* n = made->GetTuple3(p);
    EXPECT_NEAR(n[0] * n[0] + n[1] * n[1] + n[2] * n[2], 1.0, 1e-12);
  }
}

TEST(IsotropicRemesh, SeamOfAnArrayStaysASeam)
{
  const auto square = SquareWithSeam(8, true);
  const auto output = Remeshed(square, 0.04);
  EXPECT_NEAR(AreaOf(output), 1.0, 1e-12);
  vtkDataArray* u = output->GetPointData()->GetArray("u");
  for (vtkIdType p = 0; p < output->GetNumberOfPoints(); ++p)
  {
    const double x = output->GetPoint(p)[0];
    const double jump = u->GetTuple1(p) - x;
    EXPECT_TRUE((std::abs(jump) < 1e-12 && x < 0.5 + 1e-12) || (std::abs(jump - 10.0) < 1e-12 && x > 0.5 - 1e-12))
      << "u = " << u->GetTuple1(p) << " at x = " << x;
  }
  const auto left = PointsWhere(output, [](const double* p) { return std::abs(p[0] - 0.5) < 1e-12; });
  ASSERT_GT(left.size(), 30u);
  EXPECT_EQ(left.size() % 2, 0u) << "a point on either side";
}

TEST(IsotropicRemesh, PointsOfEqualValuesAreSewnTogether)
{
  const auto square = SquareWithSeam(8, false);
  const auto output = Remeshed(square, 0.04);
  EXPECT_EQ(EulerCharacteristic(output), 1) << "one piece";
  EXPECT_EQ(EulerCharacteristic(square), 2) << "of two";

  Soup triangles; // as STL stores a sphere
  const Soup sphere = Icosphere(3);
  for (const auto& cell : sphere.Polys)
  {
    std::vector<vtkIdType> corners;
    for (const vtkIdType id : cell)
    {
      corners.push_back(
        triangles.AddPoint(sphere.Points[3 * id], sphere.Points[3 * id + 1], sphere.Points[3 * id + 2]));
    }
    triangles.Polys.push_back(corners);
  }
  ExpectValid(Remeshed(triangles.ToPolyData(), 0.15), true);
}

TEST(IsotropicRemesh, PrecisionOfPointsStaysAndOtherCellsAreLeftOut)
{
  Soup soup = Icosphere(2);
  soup.Verts.push_back({ 0 });
  soup.Lines.push_back({ 1, 2, 3 });
  for (const int type : { VTK_FLOAT, VTK_DOUBLE })
  {
    const auto output = Remeshed(soup.ToPolyData(type), 0.2);
    EXPECT_EQ(output->GetPoints()->GetDataType(), type);
    EXPECT_EQ(output->GetNumberOfVerts() + output->GetNumberOfLines() + output->GetNumberOfStrips(), 0);
  }
}

TEST(IsotropicRemesh, BlocksAreRemeshedByThemselves)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, Icosphere(3).ToPolyData());
  blocks->SetBlock(2, Grid(5, 4).ToPolyData());
  vtkNew<Remesh> filter;
  filter->SetTargetEdgeLength(0.15);
  filter->SetInputData(blocks);
  ASSERT_TRUE(Update(filter));
  auto* output = vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0));
  ASSERT_TRUE(output);
  ExpectValid(vtkPolyData::SafeDownCast(output->GetBlock(0)), true);
  ExpectValid(vtkPolyData::SafeDownCast(output->GetBlock(2)), false);
  const auto alone = Remeshed(blocks->GetBlock(0), 0.15);
  EXPECT_TRUE(
    SameBits(alone->GetPoints()->GetData(), vtkPolyData::SafeDownCast(output->GetBlock(0))->GetPoints()->GetData()));
}

TEST(IsotropicRemesh, DefectsAreRefusedWithTheFilterThatRepairsThem)
{
  Soup fan = Grid(2);
  fan.Polys.push_back(fan.Polys[0]);
  Soup wound = Icosphere(1);
  std::swap(wound.Polys[3][0], wound.Polys[3][1]);
  vtkNew<Remesh> filter;
  ExpectRefusal(filter, fan.ToPolyData(), { "non-manifold edge", "vtkSurfaceRepairFilter" });
  ExpectRefusal(filter, wound.ToPolyData(), { "wound in opposite senses", "vtkSurfaceRepairFilter" });
}

TEST(IsotropicRemesh, UnusableSizingArraysAreNamed)
{
  const auto sphere = Icosphere(1).ToPolyData();
  AddPointArray(sphere, "zero", [](const double* p) { return p[2] > 0.9 ? 0.0 : 1.0; });
  AddPointArray(sphere, "nan", [](const double*) { return std::numeric_limits<double>::quiet_NaN(); });
  vtkNew<vtkDoubleArray> pairs;
  pairs->SetName("pairs");
  pairs->SetNumberOfComponents(2);
  pairs->SetNumberOfTuples(sphere->GetNumberOfPoints());
  pairs->Fill(1.0);
  sphere->GetPointData()->AddArray(pairs);
  vtkNew<Remesh> filter;
  filter->SetSizingArrayName("none");
  ExpectRefusal(filter, sphere, { "\"none\" is missing" });
  filter->SetSizingArrayName("zero");
  ExpectRefusal(filter, sphere, { "\"zero\" is 0 at point", "larger than 0" });
  filter->SetSizingArrayName("nan");
  ExpectRefusal(filter, sphere, { "\"nan\" is nan at point 0" });
  filter->SetSizingArrayName("pairs");
  ExpectRefusal(filter, sphere, { "\"pairs\" has 42 tuples of 2 components" });
}

TEST(IsotropicRemesh, TooManyPointsAreRefusedBeforeTheWorkWithALengthThatFits)
{
  const auto sphere = Icosphere(2).ToPolyData();
  AddPointArray(sphere, "size", [](const double*) { return 1e-6; });
  vtkNew<Remesh> filter;
  filter->SetTargetEdgeLength(1e-6);
  ExpectRefusal(filter, sphere, { "edges of length 1e-06", "at most 1e+07 (MaximumNumberOfPoints)", "A length of" });
  filter->SetSizingArrayName("size");
  ExpectRefusal(filter, sphere, { "the edge lengths asked for", "times as large fit" });
  filter->SetSizingArrayName("");
  filter->SetTargetNumberOfPoints(VTK_INT_MAX);
  ExpectRefusal(filter, sphere, { "2147483647 points", "MaximumNumberOfPoints" });
  filter->SetTargetNumberOfPoints(0);
  filter->SetMaximumNumberOfPoints(500);
  filter->SetTargetEdgeLength(0.01);
  EventRecorder events(filter);
  ExpectRefusal(filter, sphere, { "A length of " });
  const std::string text = events.AllErrors();
  const double fitting = std::stod(text.substr(text.find("A length of ") + 12));
  filter->SetTargetEdgeLength(fitting);
  EXPECT_LE(OutputOf(filter, sphere)->GetNumberOfPoints(), 700) << "about the limit; edges end up a little shorter";
}

TEST(IsotropicRemesh, EdgesLongerThanTheSurfaceAreRefused)
{
  vtkNew<Remesh> filter;
  filter->SetTargetEdgeLength(50.0);
  ExpectRefusal(filter, Icosphere(2).ToPolyData(), { "longer than the surface, whose longest side is 2" });
  // The edges of this tetrahedron are longer than the sides of its box.
  Soup tetrahedron;
  for (const auto& p : { std::array<double, 3>{ 0, 0, 0 }, { 1, 1, 0 }, { 1, 0, 1 }, { 0, 1, 1 } })
  {
    tetrahedron.AddPoint(p[0], p[1], p[2]);
  }
  tetrahedron.Polys = { { 0, 1, 2 }, { 0, 3, 1 }, { 0, 2, 3 }, { 1, 3, 2 } };
  filter->SetTargetEdgeLength(0.0);
  EXPECT_GE(OutputOf(filter, tetrahedron.ToPolyData())->GetNumberOfPolys(), 4);
}

TEST(IsotropicRemesh, MissingInputIsOneError)
{
  vtkNew<Remesh> filter;
  EventRecorder events(filter);
  EXPECT_FALSE(Update(filter));
  EXPECT_EQ(events.Errors.size(), 1u) << events.AllErrors();
}

TEST(IsotropicRemesh, UnchangedParametersRunNothingAndChangesRunOnce)
{
  vtkNew<Remesh> filter;
  filter->SetInputData(Icosphere(2).ToPolyData());
  EventRecorder events(filter);
  const auto expectOne = [&](const char* what) {
    const int before = events.Executions;
    Update(filter);
    Update(filter);
    EXPECT_EQ(events.Executions, before + 1) << what;
  };
  expectOne("first");
  filter->SetTargetEdgeLength(0.3);
  expectOne("edge length");
  filter->SetTargetEdgeLength(0.3);
  filter->SetSizingArrayName("");
  Update(filter);
  EXPECT_EQ(events.Executions, 2) << "the same values are no change";
  filter->SetNumberOfIterations(1);
  expectOne("iterations");
  filter->KeepBoundaryPointsOn();
  expectOne("boundary");
}

TEST(IsotropicRemesh, ParametersAreClampedAndPrinted)
{
  vtkNew<Remesh> filter;
  filter->SetTargetEdgeLength(-1.0);
  filter->SetFeatureAngle(500.0);
  filter->SetNumberOfIterations(0);
  filter->SetSizingArrayName("size");
  EXPECT_EQ(filter->GetTargetEdgeLength(), 0.0);
  EXPECT_EQ(filter->GetFeatureAngle(), 180.0);
  EXPECT_EQ(filter->GetNumberOfIterations(), 1);
  std::ostringstream text;
  filter->Print(text);
  for (const char* name : { "TargetEdgeLength: 0", "TargetNumberOfPoints: 0", "SizingArrayName: size",
         "KeepFeatureEdges: 1", "FeatureAngle: 180", "KeepBoundaryPoints: 0", "NumberOfIterations: 1",
         "NumberOfRelaxationSteps: 1", "MaximumNumberOfPoints: 10000000", "MeanEdgeLength: 0" })
  {
    EXPECT_NE(text.str().find(name), std::string::npos) << name;
  }
}
