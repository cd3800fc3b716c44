// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Images, and checks of the surface of a volume, for the tests of vtkVDBSurfaceFilter.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

#include <vtkImageData.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <Eigen/Core>

#include <array>
#include <functional>
#include <string>

class vtkAlgorithm;

namespace surfsynthtest
{

/// Lattice of an image in world coordinates.
struct ImageGeometry
{
  std::array<int, 3> Dimensions{ { 32, 32, 32 } };
  Eigen::Vector3d Origin = Eigen::Vector3d::Zero();
  Eigen::Vector3d Spacing = Eigen::Vector3d::Ones();
  Eigen::Matrix3d Direction = Eigen::Matrix3d::Identity();

  Eigen::Vector3d World(int i, int j, int k) const
  {
    return this->Origin + this->Direction * this->Spacing.cwiseProduct(Eigen::Vector3d(i, j, k));
  }
  Eigen::Vector3d Center() const
  {
    return 0.5 * (this->World(0, 0, 0) + this->World(Dimensions[0] - 1, Dimensions[1] - 1, Dimensions[2] - 1));
  }
};

/// The image whose scalars, of the VTK type @p type, are a function of world coordinates.
vtkSmartPointer<vtkImageData> MakeImage(
  const ImageGeometry& geometry, const std::function<double(const Eigen::Vector3d&)>& value, int type = VTK_FLOAT);

/// radius - |x - centre|: positive inside of a sphere.
std::function<double(const Eigen::Vector3d&)> Ball(const Eigen::Vector3d& center, double radius);

/// Independent random numbers in [0, 1).
vtkSmartPointer<vtkImageData> NoiseImage(const std::array<int, 3>& dimensions, std::uint32_t seed);

/// The geometry of a polydata of triangles.
surfsynth::TriangleMesh MeshOf(vtkPolyData* surface);

/// Describes all defects that the mesh check finds: "" for closed, manifold, consistently wound surfaces.
std::string DefectsOf(vtkPolyData* surface);

/// The output of @p filter, which must be closed and manifold, without an error or a warning.
vtkSmartPointer<vtkPolyData> ClosedSurfaceOf(vtkAlgorithm* filter);

/// Volume within a closed surface, positive when it is wound outwards; its area; its number of components.
double VolumeOf(vtkPolyData* surface);
double AreaOf(vtkPolyData* surface);
int ComponentsOf(vtkPolyData* surface);

} // namespace surfsynthtest
