// SPDX-License-Identifier: BSD-3-Clause
//
// Geometry and attributes between VTK's datasets and new meshes.
#include "FilterChecks.h"
#include "VtkSurfaces.h"

#include "NewArray.h"
#include "SurfaceArrays.h"
#include "SurfaceBridge.h"

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkIdTypeArray.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkStringArray.h>
#include <vtkUnsignedCharArray.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

using namespace surfsynthtest;
using surfsynth::AttributeClasses;
using surfsynth::InterpolateArrays;
using surfsynth::NewArray;
using surfsynth::PickArrays;
using surfsynth::SurfacePlace;
using surfsynth::TriangleMesh;
using ::testing::ElementsAre;

namespace
{
TriangleMesh MeshOf(vtkPolyData* surface) { return surfsynth::ConvertSurface(surface).Mesh; }

/// One triangle with corners at (0, 0, 0), (1, 0, 0), (0, 1, 0).
vtkSmartPointer<vtkPolyData> Triangle()
{
  Soup soup;
  soup.Points = { 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0 };
  soup.Polys = { { 0, 1, 2 } };
  return soup.ToPolyData();
}

std::vector<SurfacePlace> PlaceAt(double a, double b, double c)
{
  SurfacePlace place;
  place.Triangle = 0;
  place.Weights << a, b, c;
  return { place };
}

template <typename Array>
vtkSmartPointer<Array> Column(const char* name, const std::vector<typename Array::ValueType>& values)
{
  const auto array = NewArray<Array>(name, static_cast<vtkIdType>(values.size()), 1);
  std::copy(values.begin(), values.end(), array->GetPointer(0));
  return array;
}
} // namespace

TEST(SetGeometry, KeepsPointsAndTrianglesInEitherPrecision)
{
  const auto sphere = Icosphere(2).ToPolyData();
  sphere->GetPointData()->AddArray(NewArray<vtkDoubleArray>("Old", 162, 1));
  const TriangleMesh mesh = MeshOf(sphere);
  for (const bool isDouble : { true, false })
  {
    vtkNew<vtkPolyData> output;
    output->ShallowCopy(sphere);
    surfsynth::SetGeometry(output, mesh, isDouble);
    EXPECT_EQ(surfsynth::HasDoublePoints(output), isDouble);
    EXPECT_EQ(output->GetPointData()->GetNumberOfArrays(), 0) << "the arrays go";
    const TriangleMesh found = MeshOf(output);
    EXPECT_EQ(found.Triangles, mesh.Triangles);
    const surfsynth::PointMatrix rounded = mesh.Points.cast<float>().cast<double>();
    EXPECT_EQ(found.Points, isDouble ? mesh.Points : rounded);
  }
}

TEST(HasDoublePoints, SaysSoOfPointsOnly)
{
  EXPECT_TRUE(surfsynth::HasDoublePoints(Icosphere(1).ToPolyData(VTK_DOUBLE)));
  EXPECT_FALSE(surfsynth::HasDoublePoints(Icosphere(1).ToPolyData(VTK_FLOAT)));
  EXPECT_FALSE(surfsynth::HasDoublePoints(vtkSmartPointer<vtkPolyData>::New()));
}

TEST(DropNormals, RemovesActiveAndNamedNormals)
{
  const auto triangle = Triangle();
  triangle->GetPointData()->SetNormals(NewArray<vtkDoubleArray>("Pointing", 3, 3));
  triangle->GetPointData()->AddArray(NewArray<vtkDoubleArray>("Normals", 3, 3));
  triangle->GetPointData()->AddArray(NewArray<vtkDoubleArray>("Kept", 3, 3));
  triangle->GetCellData()->SetNormals(NewArray<vtkFloatArray>("Normals", 1, 3));
  surfsynth::DropNormals(triangle);
  EXPECT_EQ(triangle->GetPointData()->GetNumberOfArrays(), 1);
  EXPECT_TRUE(triangle->GetPointData()->HasArray("Kept"));
  EXPECT_EQ(triangle->GetCellData()->GetNumberOfArrays(), 0);
}

TEST(NearestPlaces, AreNearest)
{
  const TriangleMesh mesh = MeshOf(Triangle());
  surfsynth::PointMatrix points(3, 3);
  points << 0.25, 0.25, 7.0, /* above */ 2.0, -1.0, 0.0, /* beyond a corner */ 0.5, -3.0, 0.0; // beside an edge
  const auto places = surfsynth::FindNearestPlaces(mesh, points);
  ASSERT_EQ(places.size(), 3u);
  EXPECT_LT((places[0].Weights - Eigen::Vector3d(0.5, 0.25, 0.25)).norm(), 1e-14);
  EXPECT_LT((places[1].Weights - Eigen::Vector3d(0.0, 1.0, 0.0)).norm(), 1e-14);
  EXPECT_LT((places[2].Weights - Eigen::Vector3d(0.5, 0.5, 0.0)).norm(), 1e-14);
  EXPECT_EQ(places[0].Triangle, 0);
}

TEST(NearestPlaces, FindTheTriangleOfEachCentroid)
{
  const TriangleMesh mesh = MeshOf(Icosphere(2).ToPolyData());
  surfsynth::PointMatrix centroids(mesh.NumberOfTriangles(), 3);
  for (surfsynth::Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    centroids.row(f) = (mesh.Points.row(mesh.Triangles(f, 0)) + mesh.Points.row(mesh.Triangles(f, 1)) +
                         mesh.Points.row(mesh.Triangles(f, 2))) /
      3.0;
  }
  const surfsynth::NearestPlaces finder(mesh);
  const auto places = finder.Find(centroids);
  for (surfsynth::Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    EXPECT_EQ(places[static_cast<std::size_t>(f)].Triangle, f);
    EXPECT_NEAR(places[static_cast<std::size_t>(f)].Weights.minCoeff(), 1.0 / 3.0, 1e-12);
  }
}

TEST(InterpolateArrays, NumbersAreLinearAndLabelsOfTheNearestCorner)
{
  const auto triangle = Triangle();
  vtkPointData* source = triangle->GetPointData();
  source->AddArray(Column<vtkDoubleArray>("Linear", { 1.0, 3.0, 5.0 }));
  source->AddArray(Column<vtkIntArray>("Label", { 10, 20, 30 }));
  vtkNew<vtkStringArray> words;
  words->SetName("Word");
  for (const char* word : { "a", "b", "c" })
  {
    words->InsertNextValue(word);
  }
  source->AddArray(words);
  vtkNew<vtkPointData> target;
  InterpolateArrays(source, MeshOf(triangle), PlaceAt(0.25, 0.25, 0.5), target);
  EXPECT_EQ(target->GetNumberOfArrays(), 3);
  EXPECT_EQ(target->GetArray("Linear")->GetTuple1(0), 3.5);
  EXPECT_EQ(target->GetArray("Label")->GetTuple1(0), 30.0);
  EXPECT_EQ(vtkStringArray::SafeDownCast(target->GetAbstractArray("Word"))->GetValue(0), "c");
}

TEST(InterpolateArrays, ACornerThatDoesNotCountSpreadsNoNaN)
{
  const auto triangle = Triangle();
  triangle->GetPointData()->AddArray(Column<vtkDoubleArray>("Values", { 1.0, 3.0, std::nan("") }));
  vtkNew<vtkPointData> target;
  InterpolateArrays(triangle->GetPointData(), MeshOf(triangle), PlaceAt(0.5, 0.5, 0.0), target);
  EXPECT_EQ(target->GetArray("Values")->GetTuple1(0), 2.0);
}

TEST(InterpolateArrays, RolesStayAndNormalsHaveUnitLength)
{
  const auto triangle = Triangle();
  const auto normals = NewArray<vtkFloatArray>("Pointing", 3, 3);
  normals->SetTuple3(0, 1.0, 0.0, 0.0);
  normals->SetTuple3(1, 0.0, 1.0, 0.0);
  normals->SetTuple3(2, 0.0, 0.0, 1.0);
  triangle->GetPointData()->SetNormals(normals);
  triangle->GetPointData()->SetScalars(Column<vtkDoubleArray>("Heat", { 0.0, 1.0, 2.0 }));
  vtkNew<vtkPointData> target;
  InterpolateArrays(triangle->GetPointData(), MeshOf(triangle), PlaceAt(0.5, 0.5, 0.0), target);
  ASSERT_TRUE(target->GetNormals());
  EXPECT_NEAR(target->GetNormals()->GetComponent(0, 0), std::sqrt(0.5), 1e-7);
  EXPECT_EQ(target->GetNormals()->GetComponent(0, 2), 0.0);
  ASSERT_TRUE(target->GetScalars());
  EXPECT_STREQ(target->GetScalars()->GetName(), "Heat");
}

TEST(InterpolateArrays, WhatOnlyMeansSomethingOnTheOldMeshIsLeftOut)
{
  const auto triangle = Triangle();
  vtkPointData* source = triangle->GetPointData();
  source->SetGlobalIds(Column<vtkIdTypeArray>("Ids", { 7, 8, 9 }));
  source->SetPedigreeIds(Column<vtkIdTypeArray>("Pedigree", { 7, 8, 9 }));
  source->AddArray(Column<vtkUnsignedCharArray>(vtkDataSetAttributes::GhostArrayName(), { 0, 0, 0 }));
  source->AddArray(Column<vtkDoubleArray>("Short", { 1.0, 2.0 }));
  source->AddArray(Column<vtkDoubleArray>("Whole", { 1.0, 2.0, 3.0 }));
  vtkNew<vtkPointData> target;
  InterpolateArrays(source, MeshOf(triangle), PlaceAt(1.0, 0.0, 0.0), target);
  EXPECT_EQ(target->GetNumberOfArrays(), 1);
  EXPECT_TRUE(target->HasArray("Whole"));
}

TEST(PickArrays, TakesTuplesInOrder)
{
  vtkNew<vtkCellData> source;
  source->AddArray(Column<vtkIntArray>("Region", { 5, 6, 7, 8 }));
  source->AddArray(Column<vtkIntArray>("Short", { 5, 6 }));
  source->SetGlobalIds(Column<vtkIdTypeArray>("Ids", { 0, 1, 2, 3 }));
  vtkNew<vtkCellData> target;
  PickArrays(source, { 3, 0, 3 }, target);
  EXPECT_EQ(target->GetNumberOfArrays(), 1);
  auto* region = vtkIntArray::SafeDownCast(target->GetArray("Region"));
  ASSERT_TRUE(region);
  EXPECT_THAT(std::vector<int>(region->GetPointer(0), region->GetPointer(0) + 3), ElementsAre(8, 5, 8));
}

TEST(AttributeClasses, SplitPointsOfOnePlaceAtSeams)
{
  Soup soup = Grid(1, 4);
  for (const vtkIdType p : { 0, 0, 1 }) // copies of the points 0, 0 and 1
  {
    soup.AddPoint(soup.Points[3 * p], soup.Points[3 * p + 1], soup.Points[3 * p + 2]);
  }
  const auto surface = soup.ToPolyData();
  const auto points = surfsynth::ConvertPoints(surface);
  EXPECT_THAT(AttributeClasses(surface, points), ElementsAre(0, 1, 2, 3, 0, 0, 1)) << "without arrays";
  surface->GetPointData()->AddArray(Column<vtkDoubleArray>("Chart", { 0.0, 1.0, 0.0, 0.0, 1.0, 1e-9, 1.0 }));
  EXPECT_THAT(AttributeClasses(surface, points), ElementsAre(0, 1, 2, 3, 4, 0, 1)) << "up to a millionth of the range";
}

TEST(SetActiveWhereNone, ChoosesScalarsAndVectorsThatTheInputHasNot)
{
  const auto surface = Grid(1, 4).ToPolyData();
  vtkPointData* data = surface->GetPointData();
  data->AddArray(surfsynth::NewArray<vtkDoubleArray>("One", 4, 1));
  data->AddArray(surfsynth::NewArray<vtkDoubleArray>("Three", 4, 3));
  data->AddArray(surfsynth::NewArray<vtkDoubleArray>("Other", 4, 3));
  surfsynth::SetActiveWhereNone(data, "One");
  EXPECT_STREQ(data->GetScalars()->GetName(), "One");
  EXPECT_EQ(data->GetVectors(), nullptr) << "one component makes no vectors";
  surfsynth::SetActiveWhereNone(data, "Three");
  EXPECT_STREQ(data->GetScalars()->GetName(), "One");
  EXPECT_STREQ(data->GetVectors()->GetName(), "Three");
  surfsynth::SetActiveWhereNone(data, "Other");
  EXPECT_STREQ(data->GetVectors()->GetName(), "Three");
}
