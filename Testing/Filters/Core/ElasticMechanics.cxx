// SPDX-License-Identifier: BSD-3-Clause
#include "ElasticMechanics.h"

#include "ExampleVolumes.h"

#include "Core/Elasticity/ElasticMotion.h"

#include <cmath>
#include <vector>

namespace surfsynth::test
{

TetrahedralMesh MappedBox(const std::array<Index, 3>& cells, const PointMap& map)
{
  TetrahedralMesh mesh = BoxOfTetrahedra(cells);
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    mesh.Points.row(v) = map(mesh.Points.row(v).transpose()).transpose();
  }
  return mesh;
}

namespace
{
/// A quasi-static equilibrium without floor under loads.
ElasticEquilibrium Loaded(const ElasticBody& body, ElasticSurroundings surroundings)
{
  surroundings.HasFloor = false;
  surroundings.HasSelfContact = false;
  surroundings.Gravity = 0.0;
  MotionOptions options;
  options.MaximumTime = 0.0;
  options.Imbalance = 1e-5;
  ElasticMotion motion(body, surroundings, options);
  return motion.Settle(body.Mesh().Points, PointMatrix::Zero(body.Mesh().NumberOfPoints(), 3));
}

/// A ball of radius 1 on z = 0, of @p cells cells across, whose points crowd around its lowest one: the conformal map of
/// the ball to itself by inversion, scaling and inversion.
TetrahedralMesh Ball(int cells, double crowding)
{
  const Eigen::Vector3d north(0.0, 0.0, 1.0);
  const Eigen::Vector3d south(0.0, 0.0, -1.0);
  const auto invert = [north](const Eigen::Vector3d& p) {
    return Eigen::Vector3d(north + 4.0 * (p - north) / (p - north).squaredNorm());
  };
  return MappedBox({ cells, cells, cells }, [=](const Eigen::Vector3d& x) {
    Eigen::Vector3d p = 2.0 * x - Eigen::Vector3d::Ones();
    const double largest = p.cwiseAbs().maxCoeff();
    p *= largest > 0.0 ? largest / p.norm() : 1.0;
    if ((p - north).norm() > 1e-9)
    {
      p = invert(south + crowding * (invert(p) - south));
    }
    return Eigen::Vector3d(p - south);
  });
}
} // namespace

double BendingRatio(int cells, double poissonsRatio)
{
  constexpr double Length = 1.0;
  constexpr double Height = 0.1;
  constexpr double Force = 0.05;
  const ElasticMaterial material{ 1e6, poissonsRatio, 1000.0 };
  const ElasticBody body(BoxOfTetrahedra({ 5 * cells, 2, cells }, { Length, Height, Height }), material);
  const PointMatrix& points = body.Mesh().Points;
  ElasticSurroundings surroundings;
  surroundings.Loads = PointMatrix::Zero(points.rows(), 3);
  surroundings.IsFixed.assign(static_cast<std::size_t>(points.rows()), false);
  const auto edge = [](double x) { return x < 1e-9 || x > Height - 1e-9 ? 0.5 : 1.0; };
  double deflection = 0.0;
  for (Eigen::Index v = 0; v < points.rows(); ++v)
  {
    surroundings.IsFixed[static_cast<std::size_t>(v)] = points(v, 0) == 0.0;
    if (points(v, 0) > Length - 1e-9)
    {
      surroundings.Loads(v, 2) = -Force * edge(points(v, 1)) * edge(points(v, 2)) / (2 * cells);
    }
  }
  const PointMatrix bent = Loaded(body, surroundings).Points;
  for (Eigen::Index v = 0; v < points.rows(); ++v)
  {
    deflection += surroundings.Loads(v, 2) / -Force * (points(v, 2) - bent(v, 2));
  }
  const double inertia = std::pow(Height, 4) / 12.0;
  const double shear = 5.0 / 6.0 * Height * Height * material.YoungsModulus / (2.0 * (1.0 + poissonsRatio));
  const double theory = Force * std::pow(Length, 3) / (3.0 * material.YoungsModulus * inertia) + Force * Length / shear;
  return deflection / theory;
}

double IndentationRatio(int cells, double poissonsRatio)
{
  constexpr double Indentation = 0.01;
  const ElasticMaterial material{ 1e6, poissonsRatio, 1000.0 };
  const ElasticBody body(Ball(cells, 0.15), material);
  const PointMatrix& points = body.Mesh().Points;
  ElasticSurroundings surroundings;
  surroundings.ContactDistance = 5e-3 * Indentation;
  surroundings.HasSelfContact = false;
  surroundings.Friction = 0.0;
  const double planeModulus = material.YoungsModulus / (1.0 - poissonsRatio * poissonsRatio);
  const double force = 4.0 / 3.0 * planeModulus * std::pow(Indentation, 1.5);
  surroundings.Gravity = force / body.Masses().sum();
  MotionOptions options;
  options.MaximumTime = 0.0;
  options.Imbalance = 1e-3;
  PointMatrix start = points;
  start.col(2).array() += surroundings.ContactDistance * std::sqrt(12.0);
  ElasticMotion motion(body, surroundings, options);
  const PointMatrix rest = motion.Settle(start, PointMatrix::Zero(points.rows(), 3)).Points;
  const double sunk = body.Masses().dot(points.col(2) - rest.col(2)) / body.Masses().sum();
  return (sunk + rest.col(2).minCoeff()) / Indentation;
}

} // namespace surfsynth::test
