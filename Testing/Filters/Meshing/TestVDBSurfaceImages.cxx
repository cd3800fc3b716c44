// SPDX-License-Identifier: BSD-3-Clause
//
// Surfaces of images: where they lie, that they are closed manifolds, and what the properties do.
#include "ExampleImages.h"
#include "FilterChecks.h"
#include "VtkSurfaces.h"

#include "vtkVDBSurfaceFilter.h"

#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDoubleArray.h>
#include <vtkIntArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>

#include <Eigen/Geometry>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

using namespace surfsynthtest;
using Eigen::Vector3d;
using Filter = vtkVDBSurfaceFilter;
using ::testing::HasSubstr;

namespace
{
const double Pi = std::acos(-1.0);

vtkSmartPointer<Filter> FilterOn(vtkDataObject* input, double isoValue = 0.0)
{
  auto filter = vtkSmartPointer<Filter>::New();
  filter->SetInputDataObject(input);
  filter->ComputeIsoValueOff();
  filter->SetIsoValue(isoValue);
  return filter;
}

/// Smallest and largest distance of the points from @p center.
std::pair<double, double> Radii(vtkPolyData* surface, const Vector3d& center)
{
  const surfsynth::PointMatrix points = MeshOf(surface).Points;
  const Eigen::VectorXd radii = (points.rowwise() - center.transpose()).rowwise().norm();
  return { radii.minCoeff(), radii.maxCoeff() };
}

Eigen::Matrix3d Oblique()
{
  return (Eigen::AngleAxisd(0.4, Vector3d(1, 2, -1).normalized()) * Eigen::AngleAxisd(1.1, Vector3d::UnitZ()))
    .toRotationMatrix();
}

ImageGeometry Anisotropic()
{
  ImageGeometry geometry;
  geometry.Dimensions = { { 60, 40, 26 } };
  geometry.Spacing = { 0.5, 0.8, 1.25 };
  geometry.Origin = { -113.0, 41.5, 1000.25 };
  geometry.Direction = Oblique();
  return geometry;
}
} // namespace

TEST(VDBSurfaceImages, ASphereIsASphereInWorldCoordinatesWhateverTheImagesGeometry)
{
  for (int mirrored = 0; mirrored < 3; ++mirrored)
  {
    SCOPED_TRACE(mirrored);
    ImageGeometry geometry = Anisotropic();
    geometry.Direction.col(2) *= mirrored == 1 ? -1.0 : 1.0;
    geometry.Spacing[0] *= mirrored == 2 ? -1.0 : 1.0;
    const auto surface = ClosedSurfaceOf(FilterOn(MakeImage(geometry, Ball(geometry.Center(), 11.0))));
    const auto radii = Radii(surface, geometry.Center());
    // A point is the mean of places on the surface within one voxel, of 1.6 units at most: below it by at most the
    // height of that cap.
    EXPECT_GT(radii.first, 11.0 - 0.06);
    EXPECT_LT(radii.second, 11.0 + 0.01);
    EXPECT_NEAR(VolumeOf(surface), 4.0 / 3.0 * Pi * std::pow(11.0, 3), 0.01 * 4.0 / 3.0 * Pi * std::pow(11.0, 3));
    EXPECT_EQ(surface->GetPoints()->GetDataType(), VTK_DOUBLE);
  }
}

TEST(VDBSurfaceImages, LevelSetLengthsAreWorldUnitsInAnisotropicImages)
{
  const ImageGeometry geometry = Anisotropic();
  const auto filter = FilterOn(MakeImage(geometry, Ball(geometry.Center(), 9.0)));
  for (const double offset : { -3.0, -0.7, 1.5 })
  {
    SCOPED_TRACE(offset);
    filter->SetOffset(offset);
    const auto radii = Radii(ClosedSurfaceOf(filter), geometry.Center());
    EXPECT_NEAR(radii.first, 9.0 + offset, 0.15); // voxels of 0.5
    EXPECT_NEAR(radii.second, 9.0 + offset, 0.15);
  }
  filter->SetOffset(0.0);
  filter->SetVoxelSize(1.0);
  const auto radii = Radii(ClosedSurfaceOf(filter), geometry.Center());
  EXPECT_NEAR(radii.first, 9.0, 0.15);
  EXPECT_NEAR(radii.second, 9.0, 0.15);
}

TEST(VDBSurfaceImages, AFlatSurfaceLiesExactlyBetweenItsSamples)
{
  ImageGeometry geometry;
  geometry.Dimensions = { { 8, 8, 8 } };
  geometry.Spacing = { 2.0, 3.0, 4.0 };
  // Larger than 0 for x < 5: between the samples at 4 and 6, in the middle.
  const auto image = MakeImage(geometry, [](const Vector3d& x) { return 5.0 - x[0]; });
  double bounds[6];
  ClosedSurfaceOf(FilterOn(image))->GetBounds(bounds);
  const double expected[6] = { -1.0, 5.0, -1.5, 22.5, -2.0, 30.0 }; // capped half a sample beyond the border
  for (int k = 0; k < 6; ++k)
  {
    EXPECT_NEAR(bounds[k], expected[k], 1e-5) << k;
  }
}

TEST(VDBSurfaceImages, TheWholeImageIsABoxAndItsBelowIsNothing)
{
  ImageGeometry geometry;
  geometry.Dimensions = { { 5, 6, 7 } };
  const auto image = MakeImage(
    geometry, [](const Vector3d&) { return 3.0; }, VTK_SHORT);
  const auto surface = ClosedSurfaceOf(FilterOn(image, 2.0));
  // Edges are bevelled over half a voxel: at most a quarter of a unit of volume for each unit of their length.
  EXPECT_LT(VolumeOf(surface), 5.0 * 6.0 * 7.0);
  EXPECT_GT(VolumeOf(surface), 5.0 * 6.0 * 7.0 - 0.25 * 4.0 * (5.0 + 6.0 + 7.0));
  const auto below = FilterOn(image, 2.0);
  below->SetInsideRuleToBelow();
  EventRecorder events(below);
  EXPECT_FALSE(Update(below));
  ASSERT_EQ(events.Errors.size(), 1u);
  EXPECT_THAT(events.Errors[0],
    HasSubstr("The isovalue 2 lies outside the values of the image, which go from 3 to 3; no part of it lies inside."));
  EXPECT_EQ(below->GetPolyDataOutput()->GetNumberOfPoints(), 0);
}

TEST(VDBSurfaceImages, BelowIsTheComplementOfAbove)
{
  ImageGeometry geometry;
  geometry.Dimensions = { { 20, 20, 20 } };
  const auto image = MakeImage(geometry, Ball(geometry.Center(), 6.0));
  const auto filter = FilterOn(image);
  const double above = VolumeOf(ClosedSurfaceOf(filter));
  filter->SetInsideRuleToBelow();
  const auto below = ClosedSurfaceOf(filter);
  EXPECT_EQ(ComponentsOf(below), 2);
  EXPECT_LT(VolumeOf(below) + above, 20.0 * 20.0 * 20.0);
  EXPECT_GT(VolumeOf(below) + above, 20.0 * 20.0 * 20.0 - 0.25 * 12.0 * 20.0) << "but for the bevelled edges";
}

TEST(VDBSurfaceImages, EveryScalarTypeGivesTheSameSurface)
{
  const ImageGeometry geometry;
  const Vector3d center = geometry.Center();
  const auto value = [center](const Vector3d& x) { return std::round(100.0 - 5.0 * (x - center).norm()); };
  const auto positive = [&](const Vector3d& x) { return std::max(value(x), 0.0); };
  vtkSmartPointer<vtkPolyData> expected;
  for (const int type : { VTK_DOUBLE, VTK_FLOAT, VTK_UNSIGNED_CHAR, VTK_SHORT, VTK_UNSIGNED_SHORT, VTK_INT, VTK_CHAR,
         VTK_SIGNED_CHAR, VTK_LONG_LONG, VTK_UNSIGNED_INT })
  {
    SCOPED_TRACE(type);
    const auto surface = ClosedSurfaceOf(FilterOn(MakeImage(geometry, positive, type), 50.5));
    expected = expected ? expected : surface;
    EXPECT_TRUE(SameBits(surface->GetPoints()->GetData(), expected->GetPoints()->GetData()));
  }
}

TEST(VDBSurfaceImages, LargeValuesKeepTheirDifferences)
{
  const ImageGeometry geometry;
  const auto ball = Ball(geometry.Center(), 9.0);
  const auto plain = ClosedSurfaceOf(FilterOn(MakeImage(geometry, ball, VTK_DOUBLE)));
  const auto shifted = ClosedSurfaceOf(
    FilterOn(MakeImage(
               geometry, [&](const Vector3d& x) { return 1e9 + ball(x); }, VTK_DOUBLE),
      1e9));
  EXPECT_NEAR(VolumeOf(plain), VolumeOf(shifted), 1e-4 * VolumeOf(plain));
}

TEST(VDBSurfaceImages, TheIsovalueIsFoundBetweenTwoClasses)
{
  const ImageGeometry geometry;
  const auto ball = Ball(geometry.Center(), 9.0);
  const auto binary = MakeImage(
    geometry, [&](const Vector3d& x) { return ball(x) > 0.0 ? 1.0 : 0.0; }, VTK_UNSIGNED_CHAR);
  vtkNew<Filter> filter;
  filter->SetInputDataObject(binary);
  ClosedSurfaceOf(filter);
  EXPECT_NEAR(filter->GetEffectiveIsoValue(), 0.5, 1e-3);
  const auto bright = MakeImage(
    geometry, [&](const Vector3d& x) { return ball(x) > 0.0 ? 900.0 + x[0] : 100.0 + x[1]; });
  filter->SetInputDataObject(bright);
  ClosedSurfaceOf(filter);
  EXPECT_NEAR(filter->GetEffectiveIsoValue(), 515.0, 20.0);
}

TEST(VDBSurfaceImages, AThresholdOfLabelsIsWarnedOf)
{
  const ImageGeometry geometry;
  const auto ball = Ball(geometry.Center(), 9.0);
  const auto labels = [&](const Vector3d& x) { return ball(x) > 4.0 ? 7.0 : ball(x) > 0.0 ? 2.0 : 0.0; };
  const auto warnings = [&](int type, bool computes) {
    vtkNew<Filter> filter;
    filter->SetInputDataObject(MakeImage(geometry, labels, type));
    filter->SetComputeIsoValue(computes);
    filter->SetIsoValue(1.0);
    EventRecorder events(filter);
    EXPECT_TRUE(Update(filter));
    return events.Warnings;
  };
  EXPECT_THAT(warnings(VTK_UNSIGNED_CHAR, true),
    ::testing::ElementsAre(::testing::AllOf(
      HasSubstr("The image holds 3 distinct integers from 0 to 7, as label images do"), HasSubstr("IsoValue (1 for"))));
  EXPECT_TRUE(warnings(VTK_UNSIGNED_CHAR, false).empty()) << "the isovalue was chosen";
  EXPECT_TRUE(warnings(VTK_FLOAT, true).empty()) << "real numbers are no labels";
}

TEST(VDBSurfaceImages, NaNIsOutsideAndInfinityOnItsSide)
{
  ImageGeometry geometry;
  geometry.Dimensions = { { 24, 24, 24 } };
  const Vector3d center = geometry.Center();
  const auto strange = MakeImage(geometry, [&](const Vector3d& x) {
    const double inside = 8.0 - (x - center).norm();
    return inside > 2.0 ? std::numeric_limits<double>::infinity()
      : inside < -2.0   ? std::numeric_limits<double>::quiet_NaN()
                        : inside;
  });
  const auto filter = FilterOn(strange);
  const auto radii = Radii(ClosedSurfaceOf(filter), center);
  EXPECT_GT(radii.first, 7.9);
  EXPECT_LT(radii.second, 8.01);
  const auto extreme = MakeImage(geometry, [&](const Vector3d& x) {
    return (x - center).norm() < 8.0 ? std::numeric_limits<double>::infinity()
                                     : -std::numeric_limits<double>::infinity();
  });
  EXPECT_NEAR(VolumeOf(ClosedSurfaceOf(FilterOn(extreme))), 4.0 / 3.0 * Pi * 512.0, 0.05 * 4.0 / 3.0 * Pi * 512.0);
  const auto wide = MakeImage(
    geometry,
    [&](const Vector3d& x) { return ((x - center).norm() < 8.0 ? 1.0 : -1.0) * std::numeric_limits<double>::max(); },
    VTK_DOUBLE);
  EXPECT_NEAR(VolumeOf(ClosedSurfaceOf(FilterOn(wide))), 4.0 / 3.0 * Pi * 512.0, 0.05 * 4.0 / 3.0 * Pi * 512.0);
  const auto nothing = MakeImage(geometry, [](const Vector3d&) { return std::numeric_limits<double>::quiet_NaN(); });
  vtkNew<Filter> empty;
  empty->SetInputDataObject(nothing);
  EventRecorder events(empty);
  EXPECT_TRUE(Update(empty));
  ASSERT_EQ(events.Warnings.size(), 1u);
  EXPECT_THAT(events.Warnings[0], HasSubstr("from nan to nan"));
}

TEST(VDBSurfaceImages, VoxelsThatTouchInAnEdgeOrACornerGiveManifolds)
{
  for (const Vector3d& second : { Vector3d(5, 5, 4), Vector3d(5, 5, 5), Vector3d(6, 4, 4) })
  {
    ImageGeometry geometry;
    geometry.Dimensions = { { 10, 10, 10 } };
    const auto image = MakeImage(
      geometry, [&](const Vector3d& x) { return x == Vector3d(4, 4, 4) || x == second ? 1.0 : 0.0; },
      VTK_UNSIGNED_CHAR);
    for (const double adaptivity : { 0.0, 0.3, 1.0 })
    {
      SCOPED_TRACE(adaptivity);
      const auto filter = FilterOn(image, 0.5);
      filter->SetAdaptivity(adaptivity);
      ClosedSurfaceOf(filter);
    }
  }
}

TEST(VDBSurfaceImages, NoiseGivesManifoldsAtEveryAdaptivityAndPrecisionOfTheIsovalue)
{
  for (std::uint32_t seed = 1; seed <= 3; ++seed)
  {
    const auto image = NoiseImage({ { 21, 18, 25 } }, seed);
    for (const double adaptivity : { 0.0, 0.3, 1.0 })
    {
      for (const double isoValue : { 0.2, 0.5, 0.9 })
      {
        SCOPED_TRACE(::testing::Message() << "seed " << seed << " adaptivity " << adaptivity << " iso " << isoValue);
        const auto filter = FilterOn(image, isoValue);
        filter->SetAdaptivity(adaptivity);
        ClosedSurfaceOf(filter);
      }
    }
  }
}

TEST(VDBSurfaceImages, SmoothedNoiseGivesManifoldsAtEveryAdaptivity)
{
  const auto filter = FilterOn(NoiseImage({ { 14, 13, 15 } }, 4), 0.5);
  for (int smoothing = Filter::GAUSSIAN; smoothing <= Filter::LAPLACIAN; ++smoothing)
  {
    for (const double adaptivity : { 0.0, 0.3, 1.0 })
    {
      SCOPED_TRACE(::testing::Message() << "smoothing " << smoothing << " adaptivity " << adaptivity);
      filter->SetSmoothing(smoothing);
      filter->SetSmoothingIterations(1);
      filter->SetAdaptivity(adaptivity);
      ClosedSurfaceOf(filter);
    }
  }
}

TEST(VDBSurfaceImages, IntegersThatHitTheIsovalueGiveManifolds)
{
  // Labels 0, 1, 2 at random, contoured exactly at 1: surfaces pass through samples.
  const auto noise = NoiseImage({ { 16, 16, 16 } }, 5);
  vtkDataArray* values = noise->GetPointData()->GetScalars();
  for (vtkIdType k = 0; k < values->GetNumberOfTuples(); ++k)
  {
    values->SetComponent(k, 0, std::floor(3.0 * values->GetComponent(k, 0)));
  }
  for (const double adaptivity : { 0.0, 0.3, 1.0 })
  {
    const auto filter = FilterOn(noise, 1.0);
    filter->SetAdaptivity(adaptivity);
    ClosedSurfaceOf(filter);
    filter->SetInsideRuleToBelow();
    ClosedSurfaceOf(filter);
  }
}

TEST(VDBSurfaceImages, CavitiesStayUnlessTheyAreFilled)
{
  ImageGeometry geometry;
  geometry.Dimensions = { { 40, 40, 40 } };
  const Vector3d center = geometry.Center();
  // A shell with an island in its cavity.
  const auto image = MakeImage(geometry, [&](const Vector3d& x) {
    const double r = (x - center).norm();
    return std::max(std::min(16.0 - r, r - 10.0), 4.0 - r);
  });
  const double full = 4.0 / 3.0 * Pi * std::pow(16.0, 3);
  const double hollow = full - 4.0 / 3.0 * Pi * (std::pow(10.0, 3) - std::pow(4.0, 3));
  for (const double voxelSize : { 0.0, 1.0 }) // without and with a level set
  {
    SCOPED_TRACE(voxelSize);
    const auto filter = FilterOn(image);
    filter->SetVoxelSize(voxelSize);
    auto surface = ClosedSurfaceOf(filter);
    EXPECT_EQ(ComponentsOf(surface), 3);
    EXPECT_NEAR(VolumeOf(surface), hollow, 0.02 * hollow);
    filter->LargestComponentOn();
    surface = ClosedSurfaceOf(filter);
    EXPECT_EQ(ComponentsOf(surface), 2) << "the shell keeps its cavity";
    filter->FillCavitiesOn();
    surface = ClosedSurfaceOf(filter);
    EXPECT_EQ(ComponentsOf(surface), 1);
    EXPECT_NEAR(VolumeOf(surface), full, 0.02 * full);
    filter->LargestComponentOff();
    surface = ClosedSurfaceOf(filter);
    EXPECT_EQ(ComponentsOf(surface), 1);
    EXPECT_NEAR(VolumeOf(surface), full, 0.02 * full);
  }
}

TEST(VDBSurfaceImages, OnlyTheLargestPartIsKept)
{
  ImageGeometry geometry;
  geometry.Dimensions = { { 50, 24, 24 } };
  const auto large = Ball({ 14, 12, 12 }, 9.0);
  const auto small = Ball({ 36, 12, 12 }, 6.0);
  const auto image = MakeImage(geometry, [&](const Vector3d& x) { return std::max(large(x), small(x)); });
  const auto filter = FilterOn(image);
  EXPECT_EQ(ComponentsOf(ClosedSurfaceOf(filter)), 2);
  filter->LargestComponentOn();
  const auto surface = ClosedSurfaceOf(filter);
  EXPECT_EQ(ComponentsOf(surface), 1);
  EXPECT_LT(surface->GetBounds()[1], 24.0);
}

TEST(VDBSurfaceImages, ThinWallsSurviveTheLevelSet)
{
  ImageGeometry geometry;
  geometry.Dimensions = { { 30, 30, 30 } };
  const Vector3d center = geometry.Center();
  const auto image = MakeImage(geometry, [&](const Vector3d& x) { return 0.6 - std::abs((x - center).norm() - 9.0); });
  const auto filter = FilterOn(image);
  filter->SetVoxelSize(1.0);
  const auto surface = ClosedSurfaceOf(filter);
  const double wall = 4.0 / 3.0 * Pi * (std::pow(9.6, 3) - std::pow(8.4, 3));
  EXPECT_NEAR(VolumeOf(surface), wall, 0.15 * wall);
  EXPECT_EQ(ComponentsOf(surface), 2);
}

TEST(VDBSurfaceImages, ClosingFillsGapsNarrowerThanTwiceItsRadius)
{
  ImageGeometry geometry;
  geometry.Dimensions = { { 40, 24, 24 } };
  // Two boxes with a gap of 3 between them.
  const auto image = MakeImage(geometry, [](const Vector3d& x) {
    const double box = std::min({ x[1] - 4.25, 19.75 - x[1], x[2] - 4.25, 19.75 - x[2], x[0] - 4.25, 34.75 - x[0] });
    return std::min(box, std::abs(x[0] - 19.5) - 1.5);
  });
  const auto filter = FilterOn(image);
  EXPECT_EQ(ComponentsOf(ClosedSurfaceOf(filter)), 2);
  filter->SetClosing(0.8);
  EXPECT_EQ(ComponentsOf(ClosedSurfaceOf(filter)), 2);
  filter->SetClosing(2.5);
  const auto closed = ClosedSurfaceOf(filter);
  EXPECT_EQ(ComponentsOf(closed), 1);
  EXPECT_NEAR(closed->GetBounds()[0], 4.25, 0.3) << "the rest stays where it is";
  EXPECT_NEAR(closed->GetBounds()[1], 34.75, 0.3);
}

TEST(VDBSurfaceImages, EverySmoothingLessensTheAreaOfANoisySphere)
{
  ImageGeometry geometry;
  geometry.Dimensions = { { 36, 36, 36 } };
  const auto noise = NoiseImage(geometry.Dimensions, 3);
  const auto ball = MakeImage(geometry, Ball(geometry.Center(), 12.0));
  vtkDataArray* values = ball->GetPointData()->GetScalars();
  for (vtkIdType k = 0; k < values->GetNumberOfTuples(); ++k)
  {
    values->SetComponent(
      k, 0, values->GetComponent(k, 0) + 3.0 * noise->GetPointData()->GetScalars()->GetComponent(k, 0) - 1.5);
  }
  const auto filter = FilterOn(ball);
  filter->SetVoxelSize(1.0);
  filter->LargestComponentOn();
  filter->FillCavitiesOn();
  const double rough = AreaOf(ClosedSurfaceOf(filter));
  for (int smoothing = Filter::GAUSSIAN; smoothing <= Filter::LAPLACIAN; ++smoothing)
  {
    SCOPED_TRACE(smoothing);
    filter->SetSmoothing(smoothing);
    const auto surface = ClosedSurfaceOf(filter);
    EXPECT_LT(AreaOf(surface), 0.97 * rough);
    // Three Gaussians have a variance of 8 voxels together: a sphere of radius 12 shrinks by about 8 / 12.
    EXPECT_NEAR(VolumeOf(surface), 4.0 / 3.0 * Pi * 1728.0, 0.2 * 4.0 / 3.0 * Pi * 1728.0);
  }
  filter->SetSmoothingIterations(0);
  EXPECT_EQ(AreaOf(ClosedSurfaceOf(filter)), rough);
}

TEST(VDBSurfaceImages, AdaptivityMakesFewerTriangles)
{
  ImageGeometry geometry;
  geometry.Dimensions = { { 40, 40, 40 } };
  const auto image = MakeImage(geometry, [](const Vector3d& x) { return 15.3 - (x.array() - 19.5).abs().maxCoeff(); });
  const auto filter = FilterOn(image);
  vtkIdType before = ClosedSurfaceOf(filter)->GetNumberOfPolys();
  for (const double adaptivity : { 0.3, 1.0 })
  {
    filter->SetAdaptivity(adaptivity);
    const auto surface = ClosedSurfaceOf(filter);
    EXPECT_LT(surface->GetNumberOfPolys(), before / 2);
    EXPECT_NEAR(VolumeOf(surface), std::pow(30.6, 3), 0.1 * std::pow(30.6, 3)) << "edges are cut";
    before = 2 * surface->GetNumberOfPolys() + 2;
  }
}

TEST(VDBSurfaceImages, ScalarsOnCellsLieInTheMiddleOfTheCells)
{
  ImageGeometry geometry;
  geometry.Dimensions = { { 25, 25, 25 } };
  geometry.Spacing = { 2.0, 2.0, 2.0 };
  const auto image = MakeImage(geometry, [](const Vector3d&) { return 0.0; });
  vtkNew<vtkDoubleArray> cells;
  cells->SetName("Cells");
  const Vector3d center = geometry.Center();
  for (int k = 0; k < 24 * 24 * 24; ++k)
  {
    const Vector3d x = geometry.World(k % 24, k / 24 % 24, k / 576) + Vector3d::Ones();
    cells->InsertNextValue(17.0 - (x - center).norm());
  }
  image->GetCellData()->AddArray(cells);
  const auto filter = FilterOn(image);
  filter->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, "Cells");
  const auto radii = Radii(ClosedSurfaceOf(filter), center);
  EXPECT_NEAR(radii.first, 17.0, 0.1);
  EXPECT_NEAR(radii.second, 17.0, 0.1);
}

TEST(VDBSurfaceImages, OtherArraysAreSampledAtThePoints)
{
  ImageGeometry geometry = Anisotropic();
  const auto image = MakeImage(geometry, Ball(geometry.Center(), 9.0));
  vtkNew<vtkDoubleArray> linear;
  linear->SetName("Linear");
  vtkNew<vtkIntArray> labels;
  labels->SetName("Label");
  for (int k = 0; k < geometry.Dimensions[2]; ++k)
  {
    for (int j = 0; j < geometry.Dimensions[1]; ++j)
    {
      for (int i = 0; i < geometry.Dimensions[0]; ++i)
      {
        linear->InsertNextValue(geometry.World(i, j, k).dot(Vector3d(1.0, -2.0, 0.5)));
        labels->InsertNextValue(i < 35 ? 7 : 9);
      }
    }
  }
  image->GetPointData()->AddArray(linear);
  image->GetPointData()->AddArray(labels);
  const auto surface = ClosedSurfaceOf(FilterOn(image));
  vtkDataArray* values = surface->GetPointData()->GetArray("Linear");
  vtkDataArray* label = surface->GetPointData()->GetArray("Label");
  ASSERT_TRUE(values && label);
  EXPECT_EQ(surface->GetPointData()->GetNumberOfArrays(), 2) << "the scalars themselves are the same everywhere";
  const surfsynth::PointMatrix points = MeshOf(surface).Points;
  for (Eigen::Index p = 0; p < points.rows(); ++p)
  {
    EXPECT_NEAR(values->GetComponent(p, 0), points.row(p).dot(Eigen::RowVector3d(1.0, -2.0, 0.5)), 1e-9);
    const double i = (geometry.Direction.transpose() * (points.row(p).transpose() - geometry.Origin))[0] / 0.5;
    EXPECT_TRUE(label->GetComponent(p, 0) == (i < 34.5 ? 7 : 9) || std::abs(i - 34.5) < 1e-9) << i;
  }
}

TEST(VDBSurfaceImages, AnImageOfOneSliceIsAPlate)
{
  ImageGeometry geometry;
  geometry.Dimensions = { { 20, 20, 1 } };
  const auto surface = ClosedSurfaceOf(FilterOn(MakeImage(geometry, Ball({ 9.5, 9.5, 0 }, 6.0))));
  EXPECT_NEAR(surface->GetBounds()[4], -0.5, 1e-6);
  EXPECT_NEAR(surface->GetBounds()[5], 0.5, 1e-6);
}

TEST(VDBSurfaceImages, ExtentsThatDoNotBeginAtZeroAreHonored)
{
  ImageGeometry geometry;
  const auto image = MakeImage(geometry, Ball(geometry.Center(), 9.0));
  image->SetExtent(10, 41, -5, 26, 100, 131);
  const auto radii = Radii(ClosedSurfaceOf(FilterOn(image)), geometry.Center() + Vector3d(10, -5, 100));
  EXPECT_NEAR(radii.first, 9.0, 0.1);
  EXPECT_NEAR(radii.second, 9.0, 0.1);
}
