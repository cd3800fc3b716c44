// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Atlas/SurfaceFrames.h"

#include <Eigen/Geometry>

#include <cmath>
#include <cstddef>

namespace surfsynth
{

namespace
{
/// Part of @p vector in the plane of the unit vector @p normal, with unit length; zero where there is none.
Eigen::Vector3d Projected(const Eigen::Vector3d& vector, const Eigen::Vector3d& normal)
{
  const Eigen::Vector3d part = vector - normal.dot(vector) * normal;
  const double length = part.norm();
  return length > 1e-9 * vector.norm() ? Eigen::Vector3d(part / length) : Eigen::Vector3d::Zero();
}

/// Angle of triangle @p f at its corner @p k in the plane of the normal there.
double AngleAt(const TriangleMesh& mesh, Eigen::Index f, int k, const Eigen::Vector3d& normal)
{
  const auto side = [&](int other) {
    return Projected(
      (mesh.Points.row(mesh.Triangles(f, other)) - mesh.Points.row(mesh.Triangles(f, k))).transpose(), normal);
  };
  return std::acos(std::fmax(-1.0, std::fmin(1.0, side((k + 1) % 3).dot(side((k + 2) % 3)))));
}

void NormalizeRows(PointMatrix& rows)
{
  for (Eigen::Index p = 0; p < rows.rows(); ++p)
  {
    const double length = rows.row(p).norm();
    if (length > 0.0)
    {
      rows.row(p) /= length;
    }
  }
}
} // namespace

SurfaceFrames::SurfaceFrames(
  const TriangleMesh& mesh, const std::vector<Index>& classes, const TextureCoordinates& coordinates)
  : Mesh(mesh)
{
  this->ComputeNormals(classes);
  this->ComputeTangents(coordinates);
}

void SurfaceFrames::ComputeNormals(const std::vector<Index>& classes)
{
  PointMatrix& normals = this->Normals;
  normals = PointMatrix::Zero(this->Mesh.NumberOfPoints(), 3);
  for (Eigen::Index f = 0; f < this->Mesh.NumberOfTriangles(); ++f)
  {
    const Eigen::Vector3d area = AreaVector(this->Mesh, f);
    for (int k = 0; k < 3; ++k)
    {
      normals.row(classes[static_cast<std::size_t>(this->Mesh.Triangles(f, k))]) += area.transpose();
    }
  }
  NormalizeRows(normals);
  for (Eigen::Index p = normals.rows() - 1; p >= 0; --p) // a class has the lowest of its points
  {
    normals.row(p) = normals.row(classes[static_cast<std::size_t>(p)]);
  }
}

void SurfaceFrames::ComputeTangents(const TextureCoordinates& coordinates)
{
  this->Flipped.resize(static_cast<std::size_t>(this->Mesh.NumberOfTriangles()));
  for (PointMatrix& tangents : this->Tangents)
  {
    tangents = PointMatrix::Zero(this->Mesh.NumberOfPoints(), 3);
  }
  for (Eigen::Index f = 0; f < this->Mesh.NumberOfTriangles(); ++f)
  {
    const auto corners = this->Mesh.Triangles.row(f);
    const Eigen::RowVector2d a = coordinates.row(3 * f + 1) - coordinates.row(3 * f);
    const Eigen::RowVector2d b = coordinates.row(3 * f + 2) - coordinates.row(3 * f);
    const double area = a[0] * b[1] - a[1] * b[0];
    const bool isFlipped = area < 0.0;
    this->Flipped[static_cast<std::size_t>(f)] = isFlipped ? 1 : 0;
    const Eigen::RowVector3d alongU = (isFlipped ? -1.0 : 1.0) *
      (b[1] * (this->Mesh.Points.row(corners(1)) - this->Mesh.Points.row(corners(0))) -
        a[1] * (this->Mesh.Points.row(corners(2)) - this->Mesh.Points.row(corners(0))));
    for (int k = 0; k < 3 && area != 0.0; ++k)
    {
      const Eigen::Vector3d normal = this->Normals.row(corners(k)).transpose();
      this->Tangents[isFlipped].row(corners(k)) += AngleAt(this->Mesh, f, k, normal) *
        Projected(alongU.transpose(), normal).transpose();
    }
  }
  NormalizeRows(this->Tangents[0]);
  NormalizeRows(this->Tangents[1]);
}

Eigen::Vector3d SurfaceFrames::NormalAt(const SurfacePlace& place) const
{
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k)
  {
    normal += place.Weights[k] * this->Normals.row(this->Mesh.Triangles(place.Triangle, k)).transpose();
  }
  return normal.norm() > 1e-6 ? normal.normalized() : AreaVector(this->Mesh, place.Triangle).normalized();
}

SurfaceFrame SurfaceFrames::FrameAt(const SurfacePlace& place) const
{
  const bool isFlipped = this->Flipped[static_cast<std::size_t>(place.Triangle)] != 0;
  SurfaceFrame frame;
  frame.Normal = this->NormalAt(place);
  frame.Tangent.setZero();
  for (int k = 0; k < 3; ++k)
  {
    frame.Tangent += place.Weights[k] *
      this->Tangents[isFlipped].row(this->Mesh.Triangles(place.Triangle, k)).transpose();
  }
  frame.Tangent = Projected(frame.Tangent, frame.Normal);
  if (frame.Tangent.isZero())
  {
    frame.Tangent = frame.Normal.unitOrthogonal();
  }
  frame.Bitangent = (isFlipped ? -1.0 : 1.0) * frame.Normal.cross(frame.Tangent);
  return frame;
}

} // namespace surfsynth
