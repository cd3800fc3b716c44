// SPDX-License-Identifier: BSD-3-Clause
#include "ExampleImages.h"

#include "FilterChecks.h"

#include "SurfaceBridge.h"

#include "Core/Mesh/MeshCheck.h"
#include "Core/Mesh/MeshTopology.h"

#include <vtkDataArray.h>
#include <vtkPointData.h>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace surfsynthtest
{

vtkSmartPointer<vtkImageData> MakeImage(
  const ImageGeometry& geometry, const std::function<double(const Eigen::Vector3d&)>& value, int type)
{
  auto image = vtkSmartPointer<vtkImageData>::New();
  image->SetDimensions(geometry.Dimensions.data());
  image->SetOrigin(geometry.Origin[0], geometry.Origin[1], geometry.Origin[2]);
  image->SetSpacing(geometry.Spacing[0], geometry.Spacing[1], geometry.Spacing[2]);
  const Eigen::Matrix3d& d = geometry.Direction;
  image->SetDirectionMatrix(d(0, 0), d(0, 1), d(0, 2), d(1, 0), d(1, 1), d(1, 2), d(2, 0), d(2, 1), d(2, 2));
  image->AllocateScalars(type, 1);
  vtkDataArray* scalars = image->GetPointData()->GetScalars();
  scalars->SetName("Density");
  vtkIdType id = 0;
  for (int k = 0; k < geometry.Dimensions[2]; ++k)
  {
    for (int j = 0; j < geometry.Dimensions[1]; ++j)
    {
      for (int i = 0; i < geometry.Dimensions[0]; ++i)
      {
        scalars->SetComponent(id++, 0, value(geometry.World(i, j, k)));
      }
    }
  }
  return image;
}

std::function<double(const Eigen::Vector3d&)> Ball(const Eigen::Vector3d& center, double radius)
{
  return [center, radius](const Eigen::Vector3d& x) { return radius - (x - center).norm(); };
}

vtkSmartPointer<vtkImageData> NoiseImage(const std::array<int, 3>& dimensions, std::uint32_t seed)
{
  ImageGeometry geometry;
  geometry.Dimensions = dimensions;
  std::uint64_t state = seed;
  return MakeImage(geometry, [&state](const Eigen::Vector3d&) {
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<double>(state >> 40) / static_cast<double>(1 << 24);
  });
}

surfsynth::TriangleMesh MeshOf(vtkPolyData* surface) { return surfsynth::ConvertSurface(surface).Mesh; }

std::string DefectsOf(vtkPolyData* surface)
{
  surfsynth::MeshRequirements all;
  all.ManifoldVertices = all.ConsistentWinding = all.Closed = true;
  return surfsynth::DescribeFindings(surfsynth::CheckMesh(MeshOf(surface), all));
}

namespace
{
Eigen::Matrix3d CornersOf(const surfsynth::TriangleMesh& mesh, surfsynth::Index f)
{
  Eigen::Matrix3d corners;
  for (int k = 0; k < 3; ++k)
  {
    corners.col(k) = mesh.Points.row(mesh.Triangles(f, k)).transpose();
  }
  return corners;
}
} // namespace

double VolumeOf(vtkPolyData* surface)
{
  surfsynth::TriangleMesh mesh = MeshOf(surface);
  mesh.Points.rowwise() -= mesh.Points.row(0).eval();
  double sum = 0.0;
  for (surfsynth::Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    sum += CornersOf(mesh, f).determinant() / 6.0;
  }
  return sum;
}

double AreaOf(vtkPolyData* surface)
{
  const surfsynth::TriangleMesh mesh = MeshOf(surface);
  double sum = 0.0;
  for (surfsynth::Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    const Eigen::Matrix3d corners = CornersOf(mesh, f);
    const Eigen::Vector3d a = corners.col(1) - corners.col(0);
    sum += 0.5 * a.cross(Eigen::Vector3d(corners.col(2) - corners.col(0))).norm();
  }
  return sum;
}

int ComponentsOf(vtkPolyData* surface)
{
  const surfsynth::TriangleMesh mesh = MeshOf(surface);
  return surfsynth::ComputeComponents(surfsynth::MeshTopology(mesh), Eigen::VectorXd::Zero(mesh.NumberOfPoints()))
    .Count;
}

vtkSmartPointer<vtkPolyData> ClosedSurfaceOf(vtkAlgorithm* filter)
{
  vtkSmartPointer<vtkPolyData> output = vtkPolyData::SafeDownCast(OutputOf(filter));
  EXPECT_GT(output->GetNumberOfPolys(), 0);
  EXPECT_EQ(DefectsOf(output), "");
  return output;
}

} // namespace surfsynthtest
