// SPDX-License-Identifier: BSD-3-Clause
//
// Closed manifolds of surfaces that are none.
#include "ExampleImages.h"
#include "FilterChecks.h"
#include "VtkSurfaces.h"

#include "vtkVDBSurfaceFilter.h"

#include <vtkDataArray.h>
#include <vtkDoubleArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkStringArray.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace surfsynthtest;
using Filter = vtkVDBSurfaceFilter;

namespace
{
const double Pi = std::acos(-1.0);
const double Ball1 = 4.0 / 3.0 * Pi; ///< volume of the unit ball

vtkSmartPointer<Filter> FilterOn(vtkDataObject* input, double voxelSize = 0.05)
{
  auto filter = vtkSmartPointer<Filter>::New();
  filter->SetInputDataObject(input);
  filter->SetVoxelSize(voxelSize);
  return filter;
}

/// @p other behind @p soup, moved along x and scaled; turned inside out when @p reversed.
void Append(Soup& soup, Soup other, double dx, double scale = 1.0, bool reversed = false)
{
  const vtkIdType first = soup.NumberOfPoints();
  for (std::size_t k = 0; k < other.Points.size(); k += 3)
  {
    soup.AddPoint(scale * other.Points[k] + dx, scale * other.Points[k + 1], scale * other.Points[k + 2]);
  }
  for (auto& cell : other.Polys)
  {
    std::for_each(cell.begin(), cell.end(), [first](vtkIdType& id) { id += first; });
    if (reversed)
    {
      std::reverse(cell.begin(), cell.end());
    }
    soup.Polys.push_back(cell);
  }
}

/// A sphere without its triangles above @p z.
Soup Bowl(double z)
{
  Soup soup = Icosphere(4);
  soup.Polys.erase(std::remove_if(soup.Polys.begin(), soup.Polys.end(),
                     [&](const std::vector<vtkIdType>& t) { return soup.Points[3 * t[0] + 2] > z; }),
    soup.Polys.end());
  return soup;
}
} // namespace

TEST(VDBSurfaceMeshes, ASphereStaysWhereItIs)
{
  const auto surface = ClosedSurfaceOf(FilterOn(Icosphere(4).ToPolyData()));
  const Eigen::VectorXd radii = MeshOf(surface).Points.rowwise().norm();
  EXPECT_GT(radii.minCoeff(), 1.0 - 0.01);
  EXPECT_LT(radii.maxCoeff(), 1.0 + 0.002);
  EXPECT_NEAR(VolumeOf(surface), Ball1, 0.015 * Ball1);
}

TEST(VDBSurfaceMeshes, TheVoxelSizeIsAPartOfTheLongestSideUnlessGiven)
{
  const auto sphere = Icosphere(3).ToPolyData();
  double bounds[6];
  sphere->GetBounds(bounds);
  const double side = std::max({ bounds[1] - bounds[0], bounds[3] - bounds[2], bounds[5] - bounds[4] });
  const auto automatic = ClosedSurfaceOf(FilterOn(sphere, 0.0));
  const auto given = ClosedSurfaceOf(FilterOn(sphere, side / 128.0));
  EXPECT_TRUE(SameBits(automatic->GetPoints()->GetData(), given->GetPoints()->GetData()));
}

TEST(VDBSurfaceMeshes, PointsKeepTheirPrecision)
{
  for (const int type : { VTK_FLOAT, VTK_DOUBLE })
  {
    Soup soup = Icosphere(3);
    std::transform(soup.Points.begin(), soup.Points.end(), soup.Points.begin(), [](double x) { return x + 1000.0; });
    const auto surface = ClosedSurfaceOf(FilterOn(soup.ToPolyData(type)));
    EXPECT_EQ(surface->GetPoints()->GetDataType(), type);
    EXPECT_NEAR(VolumeOf(surface), Ball1, 0.03 * Ball1);
  }
}

TEST(VDBSurfaceMeshes, OverlappingPartsAreUnited)
{
  Soup soup = Icosphere(3);
  Append(soup, Icosphere(3), 1.0);
  const auto surface = ClosedSurfaceOf(FilterOn(soup.ToPolyData()));
  EXPECT_EQ(ComponentsOf(surface), 1);
  const double lens = Pi * (4.0 + 1.0) * 1.0 / 12.0; // two unit spheres at distance 1
  EXPECT_NEAR(VolumeOf(surface), 2.0 * Ball1 - lens, 0.04 * Ball1);
}

TEST(VDBSurfaceMeshes, WindingDoesNotMatterWhereItIsWrong)
{
  Soup mixed = Icosphere(3);
  for (std::size_t f = 0; f < mixed.Polys.size(); f += 3)
  {
    std::swap(mixed.Polys[f][0], mixed.Polys[f][1]);
  }
  EXPECT_NEAR(VolumeOf(ClosedSurfaceOf(FilterOn(mixed.ToPolyData()))), Ball1, 0.03 * Ball1);
  Soup inwards;
  Append(inwards, Icosphere(3), 0.0, 1.0, true);
  EXPECT_NEAR(VolumeOf(ClosedSurfaceOf(FilterOn(inwards.ToPolyData()))), Ball1, 0.03 * Ball1);
  Soup beside = Icosphere(3);
  Append(beside, Icosphere(3), 3.0, 1.0, true);
  const auto surface = ClosedSurfaceOf(FilterOn(beside.ToPolyData()));
  EXPECT_EQ(ComponentsOf(surface), 2);
  EXPECT_NEAR(VolumeOf(surface), 2.0 * Ball1, 0.06 * Ball1);
}

TEST(VDBSurfaceMeshes, CavitiesStayWhereTheWindingTellsThemAndAreFilledElsewhere)
{
  Soup hollow = Icosphere(3);
  Append(hollow, Icosphere(3), 0.0, 0.5, true);
  const auto filter = FilterOn(hollow.ToPolyData());
  auto surface = ClosedSurfaceOf(filter);
  EXPECT_EQ(ComponentsOf(surface), 2);
  EXPECT_NEAR(VolumeOf(surface), 0.875 * Ball1, 0.03 * Ball1);
  filter->FillCavitiesOn();
  surface = ClosedSurfaceOf(filter);
  EXPECT_EQ(ComponentsOf(surface), 1);
  EXPECT_NEAR(VolumeOf(surface), Ball1, 0.03 * Ball1);
  Soup nested = Icosphere(3);
  Append(nested, Icosphere(3), 0.0, 0.5);
  surface = ClosedSurfaceOf(FilterOn(nested.ToPolyData()));
  EXPECT_EQ(ComponentsOf(surface), 1);
  EXPECT_NEAR(VolumeOf(surface), Ball1, 0.03 * Ball1);
}

TEST(VDBSurfaceMeshes, HolesNarrowerThanTwiceTheClosingAreBridged)
{
  const auto bowl = Bowl(0.9).ToPolyData(); // a hole of diameter 0.87
  const auto filter = FilterOn(bowl, 0.08);
  filter->SetClosing(0.5);
  const auto closed = ClosedSurfaceOf(filter);
  EXPECT_EQ(ComponentsOf(closed), 1);
  EXPECT_NEAR(VolumeOf(closed), Ball1, 0.06 * Ball1);
  EXPECT_NEAR(closed->GetBounds()[0], -1.0, 0.04) << "the rest stays where it is";
  filter->SetClosing(0.2);
  const auto open = ClosedSurfaceOf(filter);
  EXPECT_LT(VolumeOf(open), 0.5 * Ball1) << "the hole stays, and what is left is a bowl with a thick wall";
}

TEST(VDBSurfaceMeshes, AHoleOfAMissingTriangleIsBridgedAnyway)
{
  Soup soup = Icosphere(4);
  soup.Polys.erase(soup.Polys.begin() + 100);
  EXPECT_NEAR(VolumeOf(ClosedSurfaceOf(FilterOn(soup.ToPolyData(), 0.1))), Ball1, 0.05 * Ball1);
}

TEST(VDBSurfaceMeshes, OpenSheetsBecomePlatesTwoVoxelsThick)
{
  const auto plate = ClosedSurfaceOf(FilterOn(Grid(8).ToPolyData(), 0.02));
  double bounds[6];
  plate->GetBounds(bounds);
  EXPECT_NEAR(bounds[4], -0.02, 0.004);
  EXPECT_NEAR(bounds[5], 0.02, 0.004);
  Soup both = Icosphere(3);
  Append(both, Grid(8), 2.0);
  const auto surface = ClosedSurfaceOf(FilterOn(both.ToPolyData()));
  EXPECT_EQ(ComponentsOf(surface), 2) << "beside a solid too";
  Soup fin = Icosphere(3);
  Append(fin, Grid(8), 0.5);
  EXPECT_EQ(ComponentsOf(ClosedSurfaceOf(FilterOn(fin.ToPolyData()))), 1) << "and grown together with it";
}

TEST(VDBSurfaceMeshes, DefectsThatTheGateRefusesAreWelcome)
{
  Soup soup = Icosphere(3);
  soup.Polys.push_back(soup.Polys[0]);                                                        // duplicate
  soup.Polys.push_back({ soup.Polys[7][0], soup.Polys[7][1], soup.AddPoint(2.0, 0.0, 0.0) }); // fin
  soup.Polys.push_back({ soup.Polys[9][0], soup.Polys[9][1], soup.Polys[9][1] });             // a point twice
  const vtkIdType twin = soup.AddPoint(soup.Points[0], soup.Points[1], soup.Points[2]);
  soup.Polys.push_back({ 0, twin, soup.Polys[3][0] }); // no area
  const auto surface = ClosedSurfaceOf(FilterOn(soup.ToPolyData()));
  EXPECT_NEAR(VolumeOf(surface), Ball1, 0.05 * Ball1);
}

TEST(VDBSurfaceMeshes, OffsetMovesTheSurfaceOutwards)
{
  const auto filter = FilterOn(Icosphere(4).ToPolyData());
  for (const double offset : { -0.4, 0.3 })
  {
    filter->SetOffset(offset);
    const Eigen::VectorXd radii = MeshOf(ClosedSurfaceOf(filter)).Points.rowwise().norm();
    EXPECT_NEAR(radii.minCoeff(), 1.0 + offset, 0.015);
    EXPECT_NEAR(radii.maxCoeff(), 1.0 + offset, 0.015);
  }
  filter->SetOffset(-1.2);
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  EXPECT_TRUE(events.Errors.empty());
  ASSERT_EQ(events.Warnings.size(), 1u);
  EXPECT_THAT(events.Warnings[0], ::testing::HasSubstr("Nothing of the solid is left"));
  EXPECT_EQ(filter->GetPolyDataOutput()->GetNumberOfPoints(), 0);
}

TEST(VDBSurfaceMeshes, PointArraysAreInterpolatedFromTheSurface)
{
  const auto sphere = Icosphere(4).ToPolyData();
  vtkNew<vtkDoubleArray> height;
  height->SetName("Height");
  vtkNew<vtkStringArray> half;
  half->SetName("Half");
  for (vtkIdType p = 0; p < sphere->GetNumberOfPoints(); ++p)
  {
    height->InsertNextValue(sphere->GetPoint(p)[2]);
    half->InsertNextValue(sphere->GetPoint(p)[2] > 0.0 ? "north" : "south");
  }
  sphere->GetPointData()->SetScalars(height);
  sphere->GetPointData()->AddArray(half);
  const auto surface = ClosedSurfaceOf(FilterOn(sphere));
  vtkDataArray* values = surface->GetPointData()->GetScalars();
  auto* labels = vtkStringArray::SafeDownCast(surface->GetPointData()->GetAbstractArray("Half"));
  ASSERT_TRUE(values && labels);
  for (vtkIdType p = 0; p < surface->GetNumberOfPoints(); ++p)
  {
    const double z = surface->GetPoint(p)[2];
    EXPECT_NEAR(values->GetComponent(p, 0), z, 0.02);
    if (std::abs(z) > 0.1)
    {
      EXPECT_EQ(labels->GetValue(p), z > 0.0 ? "north" : "south");
    }
  }
}

TEST(VDBSurfaceMeshes, ScaleAndPlaceDoNotMatter)
{
  for (const double scale : { 1e-9, 1e9 })
  {
    Soup soup = Icosphere(3);
    std::transform(
      soup.Points.begin(), soup.Points.end(), soup.Points.begin(), [scale](double x) { return scale * (x + 100.0); });
    const auto surface = ClosedSurfaceOf(FilterOn(soup.ToPolyData(), 0.05 * scale));
    EXPECT_NEAR(VolumeOf(surface) / std::pow(scale, 3), Ball1, 0.03 * Ball1);
  }
}

TEST(VDBSurfaceMeshes, BlocksAreProcessedByThemselves)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  ImageGeometry geometry;
  blocks->SetBlock(0, Icosphere(3).ToPolyData());
  blocks->SetBlock(2, MakeImage(geometry, Ball(geometry.Center(), 9.0)));
  const auto filter = FilterOn(blocks, 0.0);
  ASSERT_TRUE(Update(filter));
  EXPECT_FALSE(filter->GetPolyDataOutput());
  auto* output = vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0));
  ASSERT_TRUE(output);
  ASSERT_EQ(output->GetNumberOfBlocks(), 3u);
  EXPECT_FALSE(output->GetBlock(1));
  for (const unsigned int k : { 0u, 2u })
  {
    auto* block = vtkPolyData::SafeDownCast(output->GetBlock(k));
    ASSERT_TRUE(block);
    const auto alone = FilterOn(blocks->GetBlock(k), 0.0);
    EXPECT_TRUE(SameBits(block->GetPoints()->GetData(), ClosedSurfaceOf(alone)->GetPoints()->GetData()));
  }
}
