// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/PoissonNet/MeshNormalization.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Operators/SurfaceOperators.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace surfsynth
{

namespace
{
/// Volume inside a closed mesh, negative when its faces point inwards.
double SignedVolume(const TriangleMesh& mesh)
{
  const Eigen::RowVector3d origin = mesh.Points.row(mesh.Triangles(0, 0));
  double volume = 0.0;
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    const auto corner = [&](int k) { return Eigen::RowVector3d(mesh.Points.row(mesh.Triangles(f, k)) - origin); };
    volume += corner(0).dot(corner(1).cross(corner(2))) / 6.0;
  }
  return volume;
}
} // namespace

MeshNormalization ComputeNormalization(const TriangleMesh& mesh, InputNormalization normalization)
{
  MeshNormalization result;
  if (normalization == InputNormalization::None)
  {
    return result;
  }
  const Eigen::VectorXd areas = FaceAreas(mesh);
  const double area = areas.sum();
  Eigen::RowVector3d moment = Eigen::RowVector3d::Zero();
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    for (int k = 0; k < 3; ++k)
    {
      moment += areas[f] / 3.0 * mesh.Points.row(mesh.Triangles(f, k));
    }
  }
  result.Center = moment / area;
  result.Scale = normalization == InputNormalization::SurfaceArea
    ? std::sqrt(area)
    : (mesh.Points.rowwise() - result.Center).rowwise().norm().maxCoeff();
  if (!(result.Scale > 0.0) || !result.Center.allFinite())
  {
    throw InvalidInput(
      "ComputeNormalization: the mesh has an area of " + FormatNumber(area) + "; expected a surface with an extent.");
  }
  return result;
}

TriangleMesh Normalized(TriangleMesh mesh, const MeshNormalization& normalization)
{
  mesh.Points = (mesh.Points.rowwise() - normalization.Center) / normalization.Scale;
  return mesh;
}

ComponentCoupling ScaledCoupling(ComponentCoupling coupling, const MeshNormalization& normalization)
{
  coupling.Distance /= normalization.Scale;
  return coupling;
}

std::vector<std::string> DescribeUnlikelyInput(
  const TriangleMesh& mesh, const MeshTopology& topology, InputNormalization normalization)
{
  std::vector<std::string> warnings;
  const bool closed = std::all_of(topology.EdgeTriangles.begin(), topology.EdgeTriangles.end(),
    [](std::uint8_t triangles) { return triangles == 2; });
  if (closed && SignedVolume(mesh) < 0.0)
  {
    warnings.push_back(
      "The faces of the closed surface point inwards; PoissonNet is not mirror-invariant and expects them "
      "to point outwards, so its answer is that for another shape. vtkReverseSense, vtkPolyDataNormals with "
      "AutoOrientNormals or vtkSurfaceRepairFilter turns them.");
  }
  const double area = FaceAreas(mesh).sum();
  if (normalization == InputNormalization::None && !(area >= 0.1 && area <= 10.0))
  {
    warnings.push_back("The surface has an area of " + FormatNumber(area) +
      "; PoissonNet expects about 1 (0.1 to 10), and the model "
      "file asks for no normalisation. Scale the mesh, or set InputNormalization of the filter or "
      "input_normalisation in the file.");
  }
  return warnings;
}

} // namespace surfsynth
