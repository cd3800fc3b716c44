// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Elasticity/NeoHookean.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Elasticity/Barrier.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace surfsynth
{

namespace
{
/// Largest Poisson's ratio: above it linear tetrahedra lock.
constexpr double MaximumPoissonsRatio = 0.495;
/// Volume, over that at rest, below which the barrier acts.
constexpr double BarrierVolume = 0.25;

void Require(bool isFine, const char* name, double found, const char* expected)
{
  if (!isFine)
  {
    throw InvalidInput(
      std::string("NeoHookean: ") + name + " is " + FormatNumber(found) + "; expected " + expected + ".");
  }
}

/// Derivative of the determinant by the matrix.
Eigen::Matrix3d Cofactor(const Eigen::Matrix3d& matrix)
{
  Eigen::Matrix3d cofactor;
  cofactor.col(0) = matrix.col(1).cross(matrix.col(2));
  cofactor.col(1) = matrix.col(2).cross(matrix.col(0));
  cofactor.col(2) = matrix.col(0).cross(matrix.col(1));
  return cofactor;
}

Eigen::Matrix3d WithoutNegativeEigenvalues(const Eigen::Matrix3d& matrix)
{
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(matrix);
  return solver.eigenvectors() * solver.eigenvalues().cwiseMax(0.0).asDiagonal() * solver.eigenvectors().transpose();
}
} // namespace

NeoHookean::NeoHookean(const ElasticMaterial& material)
{
  const double young = material.YoungsModulus;
  const double ratio = material.PoissonsRatio;
  Require(young > 0.0 && std::isfinite(young), "Young's modulus", young, "a number above 0");
  Require(ratio >= 0.0 && ratio <= MaximumPoissonsRatio, "Poisson's ratio", ratio, "a number from 0 to 0.495");
  Require(material.Density > 0.0 && std::isfinite(material.Density), "density", material.Density, "a number above 0");
  const double shear = young / (2.0 * (1.0 + ratio));
  const double lame = young * ratio / ((1.0 + ratio) * (1.0 - 2.0 * ratio));
  this->Mu = 4.0 / 3.0 * shear;
  this->Lambda = lame + 5.0 / 6.0 * shear;
  this->Alpha = 1.0 + 0.75 * this->Mu / this->Lambda;
}

Eigen::Vector2d NeoHookean::OfVolume(double volume) const
{
  const Barrier barrier(BarrierVolume, this->Lambda);
  return { this->Lambda * (volume - this->Alpha) - barrier.Pressure(volume), this->Lambda + barrier.Curvature(volume) };
}

double NeoHookean::Energy(const Eigen::Matrix3d& gradient) const
{
  const double volume = gradient.determinant();
  if (!(volume > 0.0))
  {
    return std::numeric_limits<double>::infinity();
  }
  // With C = F^T F - 1: J^2 - 1 = det(1 + C) - 1, of the three invariants of C. Linear parts of stretch and volume cancel.
  const Eigen::Matrix3d strain = gradient.transpose() * gradient - Eigen::Matrix3d::Identity();
  const double trace = strain.trace();
  const double minors = 0.5 * (trace * trace - strain.squaredNorm());
  const double growth = (trace + minors + strain.determinant()) / (volume + 1.0); // J - 1
  const double shear = 0.5 * (trace - std::log1p(0.25 * trace)) - 0.75 * growth;
  return this->Mu * shear + 0.5 * this->Lambda * growth * growth + Barrier(BarrierVolume, this->Lambda).Energy(volume);
}

Eigen::Matrix3d NeoHookean::Stress(const Eigen::Matrix3d& gradient) const
{
  const double shear = this->Mu * (1.0 - 1.0 / (gradient.squaredNorm() + 1.0));
  const Eigen::Matrix3d cofactor = Cofactor(gradient);
  return shear * gradient + this->OfVolume(gradient.col(0).dot(cofactor.col(0)))[0] * cofactor;
}

NeoHookeanStiffness NeoHookean::Stiffness(const Eigen::Matrix3d& gradient) const
{
  NeoHookeanStiffness stiffness;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(gradient.transpose() * gradient);
  stiffness.V = solver.eigenvectors();
  const Eigen::Vector3d s = solver.eigenvalues().cwiseMax(1e-12).cwiseSqrt();
  stiffness.U = gradient * stiffness.V * s.cwiseInverse().asDiagonal();
  const double square = s.squaredNorm() + 1.0;
  const double shear = this->Mu * (1.0 - 1.0 / square);
  const Eigen::Vector2d ofVolume = this->OfVolume(s.prod());
  const double pressure = ofVolume[0];
  const Eigen::Vector3d others(s[1] * s[2], s[2] * s[0], s[0] * s[1]); // derivatives of the volume
  Eigen::Matrix3d stretch = 2.0 * this->Mu / (square * square) * s * s.transpose();
  stretch += ofVolume[1] * others * others.transpose();
  stretch.diagonal().array() += shear;
  for (int k = 0; k < 3; ++k)
  {
    const int i = (k + 1) % 3;
    const int j = (k + 2) % 3;
    stretch(i, j) += pressure * s[k];
    stretch(j, i) += pressure * s[k];
    stiffness.Symmetric[k] = std::max(shear - pressure * s[k], 0.0);
    stiffness.Rotation[k] = std::max(shear + pressure * s[k], 0.0);
  }
  stiffness.Stretch = WithoutNegativeEigenvalues(stretch);
  return stiffness;
}

} // namespace surfsynth
