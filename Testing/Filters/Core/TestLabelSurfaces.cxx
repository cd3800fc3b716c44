// SPDX-License-Identifier: BSD-3-Clause
#include "ThrownText.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/LabelSurfaces.h"
#include "Core/Mesh/MeshCheck.h"

#include <Eigen/Geometry>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <map>
#include <set>
#include <tuple>

using namespace surfsynth;
using surfsynthtest::TextOf;
using ::testing::HasSubstr;

namespace
{
/// A volume with labels of its own.
struct Phantom
{
  Phantom(std::array<int, 3> dimensions, const std::function<int(Eigen::Vector3d)>& labelAt)
  {
    this->Volume.Dimensions = dimensions;
    for (int z = 0; z < dimensions[2]; ++z)
    {
      for (int y = 0; y < dimensions[1]; ++y)
      {
        for (int x = 0; x < dimensions[0]; ++x)
        {
          this->Labels.push_back(labelAt(Eigen::Vector3d(x, y, z)));
        }
      }
    }
    this->Volume.Labels = this->Labels.data();
  }
  Phantom(const Phantom&) = delete;

  std::vector<std::int32_t> Labels;
  LabelVolume Volume;
};

/// A ball in two halves, labels 3 and 7, with a small ball, label 5, in the first half, and a single sample, label 2.
int Halves(const Eigen::Vector3d& p)
{
  const Eigen::Vector3d center(15.2, 14.7, 15.0);
  if ((p - Eigen::Vector3d(9.0, 15.0, 15.0)).norm() < 2.6)
  {
    return 5;
  }
  const bool single = p == Eigen::Vector3d(28.0, 28.0, 28.0);
  return single ? 2 : (p - center).norm() < 11.0 ? (p[0] < center[0] ? 3 : 7) : 0;
}

double EnclosedVolume(const TriangleMesh& mesh)
{
  double volume = 0.0;
  for (Eigen::Index t = 0; t < mesh.Triangles.rows(); ++t)
  {
    const Eigen::Vector3d a = mesh.Points.row(mesh.Triangles(t, 0)), b = mesh.Points.row(mesh.Triangles(t, 1)),
                          c = mesh.Points.row(mesh.Triangles(t, 2));
    volume += a.dot(b.cross(c)) / 6.0;
  }
  return volume;
}

MeshRequirements ClosedManifold()
{
  MeshRequirements requirements;
  requirements.ManifoldVertices = true;
  requirements.ConsistentWinding = true;
  requirements.Closed = true;
  return requirements;
}

using Triple = std::tuple<double, double, double>;

Triple PointOf(const TriangleMesh& mesh, Index point)
{
  return { mesh.Points(point, 0), mesh.Points(point, 1), mesh.Points(point, 2) };
}

/// Triangles as cycles of coordinates that begin with the smallest; @p reversed turns them round.
std::set<std::array<Triple, 3>> TrianglesOf(const TriangleMesh& mesh, bool reversed)
{
  std::set<std::array<Triple, 3>> triangles;
  for (Eigen::Index t = 0; t < mesh.Triangles.rows(); ++t)
  {
    std::array<Triple, 3> corners;
    for (int k = 0; k < 3; ++k)
    {
      corners[static_cast<std::size_t>(k)] = PointOf(mesh, mesh.Triangles(t, reversed ? 2 - k : k));
    }
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    triangles.insert(corners);
  }
  return triangles;
}

std::map<int, LabelSurface> SurfacesOf(const LabelVolume& volume, const LabelSurfaceOptions& options = {})
{
  std::map<int, LabelSurface> surfaces;
  for (LabelSurface& surface : MakeLabelSurfaces(volume, options))
  {
    surfaces[surface.Label] = std::move(surface);
  }
  return surfaces;
}

/// Root mean square angle of triangles with the sphere about @p center, weighted by area; degrees.
double Roughness(const TriangleMesh& mesh, const Eigen::Vector3d& center)
{
  double sum = 0.0, area = 0.0;
  for (Eigen::Index t = 0; t < mesh.Triangles.rows(); ++t)
  {
    const Eigen::Vector3d a = mesh.Points.row(mesh.Triangles(t, 0)), b = mesh.Points.row(mesh.Triangles(t, 1)),
                          c = mesh.Points.row(mesh.Triangles(t, 2));
    const Eigen::Vector3d normal = (b - a).cross(c - a);
    const Eigen::Vector3d radius = (a + b + c) / 3.0 - center;
    const double angle = std::acos(std::min(1.0, normal.dot(radius) / (normal.norm() * radius.norm())));
    sum += normal.norm() * angle * angle;
    area += normal.norm();
  }
  return std::sqrt(sum / area) * 180.0 / 3.14159265358979;
}
} // namespace

TEST(LabelSurfaces, EachLabelKeepsItsVolume)
{
  const Phantom phantom({ 30, 30, 30 }, Halves);
  for (const bool shared : { true, false })
  {
    LabelSurfaceOptions options;
    options.SharedBorders = shared;
    const auto surfaces = SurfacesOf(phantom.Volume, options);
    ASSERT_EQ(surfaces.size(), 4u);
    for (const auto& [label, surface] : surfaces)
    {
      EXPECT_EQ(surface.SampleVolume, std::count(phantom.Labels.begin(), phantom.Labels.end(), label));
      EXPECT_NEAR(EnclosedVolume(surface.Mesh) / surface.SampleVolume, 1.0, 1e-3) << label << ", shared " << shared;
    }
  }
}

TEST(LabelSurfaces, SmoothingWithoutPreservationLosesVolume)
{
  const Phantom phantom({ 30, 30, 30 }, Halves);
  LabelSurfaceOptions options;
  options.PreserveVolume = false;
  const auto surfaces = SurfacesOf(phantom.Volume, options);
  EXPECT_LT(EnclosedVolume(surfaces.at(5).Mesh) / surfaces.at(5).SampleVolume, 0.95) << "what is to be restored";
}

TEST(LabelSurfaces, SurfacesAreClosedManifoldsWoundOutwards)
{
  const Phantom phantom({ 30, 30, 30 }, Halves);
  for (const auto& [label, surface] : SurfacesOf(phantom.Volume))
  {
    EXPECT_GT(EnclosedVolume(surface.Mesh), 0.0) << label;
    EXPECT_TRUE(CheckMesh(surface.Mesh, ClosedManifold()).empty()) << label;
  }
}

TEST(LabelSurfaces, RandomLabelsGiveManifolds)
{
  const Phantom phantom({ 9, 8, 7 }, [](const Eigen::Vector3d& p) {
    const auto n = static_cast<unsigned>(p[0] + 9 * p[1] + 72 * p[2]);
    return static_cast<int>((n * 2654435761u >> 13) % 4); // corners and edges that touch in all ways
  });
  LabelSurfaceOptions options;
  options.PreserveVolume = false;
  options.SmoothingIterations = 0;
  MeshRequirements requirements = ClosedManifold();
  for (const auto& [label, surface] : SurfacesOf(phantom.Volume, options))
  {
    EXPECT_TRUE(CheckMesh(surface.Mesh, requirements).empty()) << label;
  }
}

TEST(LabelSurfaces, TouchingLabelsHaveTheSameTrianglesInTheirBorder)
{
  const Phantom phantom({ 30, 30, 30 }, Halves);
  const auto surfaces = SurfacesOf(phantom.Volume);
  const auto first = TrianglesOf(surfaces.at(3).Mesh, false), second = TrianglesOf(surfaces.at(7).Mesh, true);
  std::vector<std::array<Triple, 3>> common;
  std::set_intersection(first.begin(), first.end(), second.begin(), second.end(), std::back_inserter(common));
  const auto borders = [&](int a, int b) {
    int faces = 0;
    for (int k = 0; k + 1 < 27000; ++k)
    {
      for (const int step : { 1, 30, 900 })
      {
        const bool inside = k / step % 30 < 29 && k + step < 27000;
        const auto x = phantom.Labels[static_cast<std::size_t>(k)];
        const auto y = inside ? phantom.Labels[static_cast<std::size_t>(k + step)] : 0;
        faces += (x == a && y == b) || (x == b && y == a);
      }
    }
    return faces;
  };
  EXPECT_EQ(common.size(), static_cast<std::size_t>(2 * borders(3, 7)))
    << "two triangles for each face between samples";
  const auto inner = TrianglesOf(surfaces.at(5).Mesh, true);
  EXPECT_TRUE(std::includes(first.begin(), first.end(), inner.begin(), inner.end())) << "all around the inner label";
}

TEST(LabelSurfaces, SmoothingRemovesSteps)
{
  const Eigen::Vector3d center(12.0, 12.0, 12.0);
  const Phantom phantom({ 25, 25, 25 }, [&](const Eigen::Vector3d& p) { return (p - center).norm() < 9.0 ? 1 : 0; });
  LabelSurfaceOptions options;
  options.SmoothingIterations = 0;
  const double before = Roughness(SurfacesOf(phantom.Volume, options).at(1).Mesh, center);
  const double after = Roughness(SurfacesOf(phantom.Volume).at(1).Mesh, center);
  EXPECT_LT(after, 0.5 * before);
  EXPECT_LT(after, 6.0) << "degrees";
}

TEST(LabelSurfaces, SpacingScalesVolumesAndBordersAreCapped)
{
  Phantom phantom({ 4, 3, 2 }, [](const Eigen::Vector3d&) { return 9; });
  phantom.Volume.Spacing = { 0.5, 2.0, 3.0 };
  const auto surfaces = SurfacesOf(phantom.Volume);
  EXPECT_NEAR(EnclosedVolume(surfaces.at(9).Mesh), 24 * 3.0, 72 * 1e-3);
  EXPECT_TRUE(CheckMesh(surfaces.at(9).Mesh, ClosedManifold()).empty());
  const Eigen::RowVector3d center = surfaces.at(9).Mesh.Points.colwise().mean();
  EXPECT_LT((center - Eigen::RowVector3d(0.75, 2.0, 1.5)).norm(), 5e-3) << "1 percent of a sample";
}

TEST(LabelSurfaces, RefusesWrongOptionsAndStops)
{
  Phantom phantom({ 5, 5, 5 }, [](const Eigen::Vector3d& p) { return p[0] > 2 ? 1 : 0; });
  LabelSurfaceOptions options;
  options.SmoothingIterations = -1;
  EXPECT_THAT(TextOf<InvalidInput>([&] { MakeLabelSurfaces(phantom.Volume, options); }), HasSubstr("-1 iterations"));
  EXPECT_THROW(MakeLabelSurfaces(phantom.Volume, {}, [](double) { return false; }), Cancelled);
  phantom.Volume.Spacing[1] = 0.0;
  EXPECT_THAT(TextOf<InvalidInput>([&] { MakeLabelSurfaces(phantom.Volume); }), HasSubstr("spacing of 0"));
  Phantom empty({ 3, 3, 3 }, [](const Eigen::Vector3d&) { return 0; });
  EXPECT_TRUE(MakeLabelSurfaces(empty.Volume).empty());
}
