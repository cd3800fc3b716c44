// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Stable neo-Hookean material [Smith2018].
#pragma once

#include <Eigen/Core>

namespace surfsynth
{

/// Constants of an isotropic elastic material, in SI units.
struct ElasticMaterial
{
  double YoungsModulus = 1e4; ///< pascals, larger than 0
  double PoissonsRatio = 0.4; ///< from 0 to 0.495
  double Density = 1e3;       ///< kilograms per cubic meter, larger than 0
};

/// Second derivative of the energy density at one deformation gradient F = U diag(s) V^T, made positive semi-definite: in
/// the axes U and V it acts on stretches by a symmetric 3 x 3 matrix, and on each pair of shears by two numbers.
struct NeoHookeanStiffness
{
  Eigen::Matrix3d U;         ///< axes of the deformed shape
  Eigen::Matrix3d V;         ///< axes of the shape at rest
  Eigen::Matrix3d Stretch;   ///< on the singular values
  Eigen::Vector3d Symmetric; ///< on symmetric shears in the planes across axes 0, 1, 2
  Eigen::Vector3d Rotation;  ///< on antisymmetric ones
};

/// Energy density of the stable neo-Hookean material, joules per cubic meter,
///   Psi(F) = mu / 2 (|F|^2 - 3) + lambda / 2 (J - alpha)^2 - mu / 2 log(|F|^2 + 1) + constant,   J = det F,
/// which is 0 at rest; mu and lambda are such that small strains follow Hooke's law. Below a quarter of the volume a barrier
/// is added, -lambda (J - 1/4)^2 log(4 J), which is infinite at 0: nothing turns over. Energies are made of F^T F - 1, so
/// that their rounding is that of stress times strain, not of the modulus.
class NeoHookean
{
public:
  /// @throws InvalidInput when a constant is out of its range or not finite.
  explicit NeoHookean(const ElasticMaterial& material);

  /// Psi(F), infinite where det F is not positive.
  double Energy(const Eigen::Matrix3d& gradient) const;
  /// First Piola-Kirchhoff stress dPsi/dF, pascals.
  Eigen::Matrix3d Stress(const Eigen::Matrix3d& gradient) const;
  /// d2Psi/dF2 with its negative eigenvalues set to 0, pascals. @p gradient has a positive determinant.
  NeoHookeanStiffness Stiffness(const Eigen::Matrix3d& gradient) const;

private:
  /// First two derivatives of the part of the energy that depends on the volume.
  Eigen::Vector2d OfVolume(double volume) const;

  double Mu;
  double Lambda;
  double Alpha; ///< 1 + 3 mu / (4 lambda)
};

} // namespace surfsynth
