// SPDX-License-Identifier: BSD-3-Clause
//
// Properties of the tetrahedra: volumes, arrays, regions, bounds.
#include "FilterChecks.h"
#include "TetrahedraChecks.h"
#include "VtkSurfaces.h"

#include "vtkTetrahedralizeFilter.h"

#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkFloatArray.h>
#include <vtkIdTypeArray.h>
#include <vtkIntArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkStringArray.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <thread>

using namespace surfsynthtest;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Tetrahedralize = vtkTetrahedralizeFilter;

namespace
{
const double Pi = std::acos(-1.0);

/// By how much tetrahedra may exceed a bound, as the header says.
constexpr double BoundSlack = 1.25;

vtkDataArray* CellArray(vtkUnstructuredGrid* grid, const char* name) { return grid->GetCellData()->GetArray(name); }

vtkDataArray* PointArray(vtkUnstructuredGrid* grid, const char* name) { return grid->GetPointData()->GetArray(name); }

/// x + 2 y + 3 z at each point, in double and in single precision, and the point's own number.
void AddPointArrays(vtkPolyData* surface)
{
  vtkNew<vtkDoubleArray> linear;
  linear->SetName("Linear");
  vtkNew<vtkFloatArray> single;
  single->SetName("Single");
  vtkNew<vtkIntArray> number;
  number->SetName("Number");
  for (vtkIdType p = 0; p < surface->GetNumberOfPoints(); ++p)
  {
    const double* x = surface->GetPoint(p);
    linear->InsertNextValue(x[0] + 2.0 * x[1] + 3.0 * x[2]);
    single->InsertNextValue(static_cast<float>(0.1 * p));
    number->InsertNextValue(static_cast<int>(p));
  }
  surface->GetPointData()->SetScalars(linear);
  surface->GetPointData()->AddArray(single);
  surface->GetPointData()->AddArray(number);
}
} // namespace

TEST(Tetrahedralize, CubeHasVolumeOneAndKeepsItsPoints)
{
  const Soup cube = Box({ 0, 0, 0 }, { 1, 1, 1 });
  const auto grid = TetrahedraOf(cube.ToPolyData());
  EXPECT_NEAR(VolumeOf(grid), 1.0, 1e-14);
  ExpectPositiveTetrahedra(grid);
  ExpectFirstPoints(grid, cube.ToPolyData());
  EXPECT_EQ(grid->GetPoints()->GetDataType(), VTK_DOUBLE);
}

TEST(Tetrahedralize, PolyhedronOfTheSphereIsFilledExactly)
{
  const auto sphere = Icosphere(3).ToPolyData();
  const auto grid = TetrahedraOf(sphere);
  EXPECT_NEAR(VolumeOf(grid), 4.15274, 1e-4) << "that of the polyhedron";
  EXPECT_NEAR(VolumeOf(grid), 4.0 / 3.0 * Pi, 0.05);
  ExpectPositiveTetrahedra(grid);
  ExpectFirstPoints(grid, sphere);
  EXPECT_GT(grid->GetNumberOfPoints(), sphere->GetNumberOfPoints());
}

TEST(Tetrahedralize, OnSurfaceTellsThePointsOfTheSurface)
{
  const auto sphere = Icosphere(3).ToPolyData();
  const auto grid = TetrahedraOf(sphere);
  auto* onSurface = vtkUnsignedCharArray::SafeDownCast(PointArray(grid, "OnSurface"));
  ASSERT_TRUE(onSurface);
  for (vtkIdType p = 0; p < grid->GetNumberOfPoints(); ++p)
  {
    EXPECT_EQ(onSurface->GetValue(p), p < sphere->GetNumberOfPoints() ? 1 : 0) << p;
  }
}

TEST(Tetrahedralize, BoundsHoldWhereTheSurfaceMayBeSplit)
{
  const auto sphere = Icosphere(2).ToPolyData();
  const auto bounded = [&](const std::function<void(Tetrahedralize*)>& change) {
    return TetrahedraOf(sphere, [&](Tetrahedralize* f) {
      f->PreserveSurfaceOff();
      change(f);
    });
  };
  const auto finer = bounded([](Tetrahedralize* f) { f->SetMaximumVolume(0.002); });
  EXPECT_LE(ShapesOf(finer).LargestVolume, BoundSlack * 0.002);
  EXPECT_LE(VolumeOf(finer) / finer->GetNumberOfCells(), 0.002);
  const double length = 0.25;
  const auto byLength = bounded([&](Tetrahedralize* f) { f->SetTargetEdgeLength(length); });
  EXPECT_LE(ShapesOf(byLength).LargestVolume, BoundSlack * std::pow(length, 3) / (6.0 * std::sqrt(2.0)));
  const auto both = bounded([&](Tetrahedralize* f) {
    f->SetTargetEdgeLength(length);
    f->SetMaximumVolume(1.0);
  });
  EXPECT_EQ(both->GetNumberOfCells(), byLength->GetNumberOfCells()) << "the stricter bound holds";
  const auto better = bounded([](Tetrahedralize* f) { f->SetQualityRatio(1.3); });
  EXPECT_LE(ShapesOf(better).LargestRadiusEdgeRatio, BoundSlack * 1.3);
  const auto unbounded = bounded([](Tetrahedralize* f) { f->SetQualityRatio(0.0); });
  EXPECT_LT(unbounded->GetNumberOfCells(), better->GetNumberOfCells());
}

TEST(Tetrahedralize, WithThePreservedSurfaceBoundsHoldAwayFromIt)
{
  const auto sphere = Icosphere(3).ToPolyData();
  const auto grid = TetrahedraOf(sphere, [](Tetrahedralize* f) { f->SetMaximumVolume(0.0005); });
  EXPECT_LE(ShapesOf(grid, true).LargestVolume, BoundSlack * 0.0005);
  EXPECT_GT(grid->GetNumberOfCells(), 8000);
}

TEST(Tetrahedralize, BoundsScaleWithTheWorld)
{
  for (const double scale : { 1e-6, 1e6 })
  {
    Soup sphere = Icosphere(2);
    for (double& x : sphere.Points)
    {
      x *= scale;
    }
    const double volume = 0.005 * scale * scale * scale;
    const auto grid = TetrahedraOf(sphere.ToPolyData(), [&](Tetrahedralize* f) {
      f->PreserveSurfaceOff();
      f->SetMaximumVolume(volume);
    });
    EXPECT_LE(ShapesOf(grid).LargestVolume, BoundSlack * volume) << scale;
    EXPECT_GT(grid->GetNumberOfCells(), 500) << scale;
  }
}

TEST(Tetrahedralize, ArraysAreExactOnTheSurfaceAndInterpolatedElsewhere)
{
  const auto sphere = Icosphere(3).ToPolyData();
  AddPointArrays(sphere);
  const auto grid = TetrahedraOf(sphere, [](Tetrahedralize* f) { f->SetMaximumVolume(0.01); });
  const vtkIdType given = sphere->GetNumberOfPoints();
  ASSERT_GT(grid->GetNumberOfPoints(), given);
  for (const char* name : { "Linear", "Single", "Number" })
  {
    vtkDataArray* old = sphere->GetPointData()->GetArray(name);
    vtkDataArray* made = PointArray(grid, name);
    ASSERT_TRUE(made) << name;
    EXPECT_EQ(made->GetDataType(), old->GetDataType());
    for (vtkIdType p = 0; p < given; ++p)
    {
      EXPECT_EQ(made->GetComponent(p, 0), old->GetComponent(p, 0)) << name << " at " << p;
    }
  }
  EXPECT_STREQ(grid->GetPointData()->GetScalars()->GetName(), "Linear");
  // The polyhedron is about the unit sphere: the nearest place of a point inside is about in its direction.
  for (vtkIdType p = given; p < grid->GetNumberOfPoints(); ++p)
  {
    const double* x = grid->GetPoint(p);
    const double r = std::sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
    if (r > 0.3)
    {
      EXPECT_NEAR(PointArray(grid, "Linear")->GetComponent(p, 0), (x[0] + 2.0 * x[1] + 3.0 * x[2]) / r, 0.6) << r;
    }
  }
}

TEST(Tetrahedralize, NewPointsOnTheSurfaceLieOnTheirTrianglesWithTheirValues)
{
  const auto box = Box({ 0, 0, 0 }, { 1, 1, 1 }).ToPolyData();
  AddPointArrays(box);
  const auto grid = TetrahedraOf(box, [](Tetrahedralize* f) {
    f->PreserveSurfaceOff();
    f->SetMaximumVolume(0.01);
  });
  ExpectPositiveTetrahedra(grid);
  EXPECT_NEAR(VolumeOf(grid), 1.0, 1e-12);
  int onSurface = 0;
  for (vtkIdType p = box->GetNumberOfPoints(); p < grid->GetNumberOfPoints(); ++p)
  {
    const double* x = grid->GetPoint(p);
    const bool onBox = std::any_of(x, x + 3, [](double c) { return c == 0.0 || c == 1.0; });
    EXPECT_EQ(PointArray(grid, "OnSurface")->GetComponent(p, 0), onBox ? 1.0 : 0.0);
    onSurface += onBox ? 1 : 0;
    if (onBox)
    {
      EXPECT_NEAR(PointArray(grid, "Linear")->GetComponent(p, 0), x[0] + 2.0 * x[1] + 3.0 * x[2], 1e-12)
        << "linear on each face";
    }
  }
  EXPECT_GT(onSurface, 0) << "the bound cannot be met without points on the surface";
}

TEST(Tetrahedralize, SurfaceTrianglesCarryTheCellArrays)
{
  const auto sphere = Icosphere(2).ToPolyData();
  vtkNew<vtkIntArray> material;
  material->SetName("Material");
  vtkNew<vtkStringArray> label;
  label->SetName("Label");
  for (vtkIdType c = 0; c < sphere->GetNumberOfCells(); ++c)
  {
    material->InsertNextValue(static_cast<int>(c + 1));
    label->InsertNextValue(std::to_string(c));
  }
  sphere->GetCellData()->AddArray(material);
  sphere->GetCellData()->AddArray(label);
  const auto plain = TetrahedraOf(sphere);
  EXPECT_FALSE(CellArray(plain, "Material"));
  const auto grid = TetrahedraOf(sphere, [](Tetrahedralize* f) { f->SurfaceTrianglesOn(); });
  const vtkIdType tetrahedra = plain->GetNumberOfCells();
  ASSERT_EQ(grid->GetNumberOfCells(), tetrahedra + sphere->GetNumberOfCells());
  EXPECT_EQ(grid->GetCellType(tetrahedra - 1), VTK_TETRA);
  EXPECT_EQ(CellArray(grid, "Material")->GetComponent(0, 0), 0.0);
  std::set<int> seen;
  for (vtkIdType c = tetrahedra; c < grid->GetNumberOfCells(); ++c)
  {
    ASSERT_EQ(grid->GetCellType(c), VTK_TRIANGLE);
    const int cell = static_cast<int>(CellArray(grid, "Material")->GetComponent(c, 0)) - 1;
    seen.insert(cell);
    EXPECT_EQ(
      vtkStringArray::SafeDownCast(grid->GetCellData()->GetAbstractArray("Label"))->GetValue(c), std::to_string(cell));
    vtkNew<vtkIdList> made, old;
    grid->GetCellPoints(c, made);
    sphere->GetCellPoints(cell, old);
    std::set<vtkIdType> a(made->begin(), made->end()), b(old->begin(), old->end());
    EXPECT_EQ(a, b) << "the triangle is the cell whose arrays it has";
  }
  EXPECT_EQ(seen.size(), static_cast<std::size_t>(sphere->GetNumberOfCells()));
}

TEST(Tetrahedralize, NestedSpheresAreRegions)
{
  const auto nested = Joined({ Shell(2, 1.0), Shell(2, 0.5) }).ToPolyData();
  const auto grid = TetrahedraOf(nested);
  const auto volumes = RegionVolumes(grid);
  const double unit = VolumeOf(TetrahedraOf(Icosphere(2).ToPolyData()));
  ASSERT_EQ(volumes.size(), 2u);
  EXPECT_NEAR(volumes.at(0), unit * (1.0 - 0.125), 1e-12) << "between the two";
  EXPECT_NEAR(volumes.at(1), unit * 0.125, 1e-12) << "inside the inner one";
  EXPECT_TRUE(vtkIntArray::SafeDownCast(CellArray(grid, "Region")));
}

TEST(Tetrahedralize, InnerSurfacesCanBeHolesAndIslandsInThemAreFilled)
{
  const auto nested = Joined({ Shell(2, 0.25), Shell(2, 1.0), Shell(2, 0.5) }).ToPolyData();
  const auto grid = TetrahedraOf(nested, [](Tetrahedralize* f) { f->SetInnerSurfacesToHoles(); });
  const auto volumes = RegionVolumes(grid);
  const double unit = VolumeOf(TetrahedraOf(Icosphere(2).ToPolyData()));
  ASSERT_EQ(volumes.size(), 2u);
  EXPECT_NEAR(volumes.at(0), unit / 64.0, 1e-12) << "the island is the first part";
  EXPECT_NEAR(volumes.at(1), unit * 0.875, 1e-12);
  EXPECT_EQ(RegionVolumes(TetrahedraOf(nested)).size(), 3u) << "as regions, all is filled";
}

TEST(Tetrahedralize, PartsBesideEachOtherAndTouchingPartsAreRegions)
{
  const auto two = Joined({ Shell(1, 1.0), Shell(1, 1.0, 3.0) }).ToPolyData();
  const auto volumes = RegionVolumes(TetrahedraOf(two, [](Tetrahedralize* f) { f->SetInnerSurfacesToHoles(); }));
  ASSERT_EQ(volumes.size(), 2u);
  EXPECT_NEAR(volumes.at(0), volumes.at(1), 1e-12);
  // Two tetrahedra that share a point.
  Soup touching;
  touching.Points = { 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, -1, 0, 0, 0, -1, 0, 0, 0, -1 };
  touching.Polys = { { 0, 2, 1 }, { 0, 1, 3 }, { 1, 2, 3 }, { 2, 0, 3 }, { 0, 5, 4 }, { 0, 4, 6 }, { 4, 5, 6 },
    { 5, 0, 6 } };
  const auto pair = RegionVolumes(TetrahedraOf(touching.ToPolyData()));
  ASSERT_EQ(pair.size(), 2u);
  EXPECT_NEAR(pair.at(0), 1.0 / 6.0, 1e-14);
  EXPECT_NEAR(pair.at(1), 1.0 / 6.0, 1e-14);
}

TEST(Tetrahedralize, WindingDoesNotMatter)
{
  Soup inwards = Icosphere(2);
  for (std::size_t c = 0; c < inwards.Polys.size(); c += 2)
  {
    std::swap(inwards.Polys[c][0], inwards.Polys[c][1]);
  }
  const auto grid = TetrahedraOf(inwards.ToPolyData());
  ExpectPositiveTetrahedra(grid);
  EXPECT_NEAR(VolumeOf(grid), VolumeOf(TetrahedraOf(Icosphere(2).ToPolyData())), 1e-12);
}

TEST(Tetrahedralize, QuadsUnusedPointsAndSinglePrecisionAreFine)
{
  Soup box = Box({ 0, 0, 0 }, { 1, 2, 3 }, 4);
  box.Points.insert(box.Points.begin(), { 9, 9, std::nan("") });
  for (auto& cell : box.Polys)
  {
    for (vtkIdType& id : cell)
    {
      ++id;
    }
  }
  box.Lines = { { 1, 2 } };
  for (const int type : { VTK_DOUBLE, VTK_FLOAT })
  {
    const auto surface = box.ToPolyData(type);
    AddPointArrays(surface);
    const auto grid = TetrahedraOf(surface);
    EXPECT_NEAR(VolumeOf(grid), 6.0, 1e-12);
    EXPECT_EQ(PointArray(grid, "Number")->GetComponent(0, 0), 1.0) << "the unused point is left out";
    EXPECT_EQ(grid->GetPoints()->GetDataType(), VTK_DOUBLE);
  }
}

TEST(Tetrahedralize, FarFromTheOriginItIsTheSameMesh)
{
  Soup sphere = Icosphere(2);
  for (double& x : sphere.Points)
  {
    x = std::round(1024.0 * x) / 1024.0; // so that adding the offset is exact
  }
  Soup far = sphere;
  for (double& x : far.Points)
  {
    x += 1048576.0;
  }
  const auto here = TetrahedraOf(sphere.ToPolyData());
  const auto there = TetrahedraOf(far.ToPolyData());
  ASSERT_EQ(here->GetNumberOfCells(), there->GetNumberOfCells());
  EXPECT_NEAR(VolumeOf(there), VolumeOf(here), 1e-6);
  ExpectPositiveTetrahedra(there);
}

TEST(Tetrahedralize, TheSameBitsEachTimeAndOnTwoThreads)
{
  const auto sphere = Icosphere(3).ToPolyData();
  AddPointArrays(sphere);
  const auto reference = TetrahedraOf(sphere);
  const auto repeat = [&] {
    vtkNew<vtkPolyData> mine;
    mine->DeepCopy(sphere);
    for (int k = 0; k < 3; ++k)
    {
      ExpectSameGrid(TetrahedraOf(mine), reference);
    }
  };
  std::thread other(repeat);
  repeat();
  other.join();
}

TEST(Tetrahedralize, BlocksAreFilledOneByOneAndTheirFieldDataStays)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  const auto sphere = Icosphere(1).ToPolyData();
  vtkNew<vtkDoubleArray> time;
  time->SetName("Time");
  time->InsertNextValue(3.0);
  sphere->GetFieldData()->AddArray(time);
  blocks->SetBlock(0, sphere);
  blocks->SetBlock(2, Box({ 0, 0, 0 }, { 1, 1, 1 }).ToPolyData());
  vtkNew<Tetrahedralize> filter;
  filter->SetInputDataObject(blocks);
  EventRecorder events(filter);
  ASSERT_TRUE(Update(filter));
  EXPECT_THAT(events.Errors, IsEmpty());
  auto* output = vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0));
  ASSERT_TRUE(output);
  auto* first = vtkUnstructuredGrid::SafeDownCast(output->GetBlock(0));
  auto* last = vtkUnstructuredGrid::SafeDownCast(output->GetBlock(2));
  ASSERT_TRUE(first && last);
  EXPECT_TRUE(first->GetFieldData()->GetArray("Time"));
  EXPECT_NEAR(VolumeOf(last), 1.0, 1e-14);
  EXPECT_FALSE(output->GetBlock(1));
}
