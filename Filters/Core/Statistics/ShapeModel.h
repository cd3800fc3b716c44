// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Statistical shape model [Cootes1995]: mean, principal modes, and shapes of given, random or fitted coefficients.
#pragma once

#include <Eigen/Core>

#include <cstdint>

namespace surfsynth
{

/// A Gaussian distribution of shapes or signals on one triangulation, x = mean + sum_k b_k mode_k, with b_k
/// independent N(0, 1) coefficients.
class ShapeModel
{
public:
  /// @param mean [n], the values of all points
  /// @param modes [n, K], orthogonal, each times its standard deviation, as ComputeEnsembleStatistics() returns them
  /// @throws InvalidInput when sizes differ, a number is not finite, or a mode is zero or not orthogonal to another one
  ShapeModel(Eigen::VectorXd mean, Eigen::MatrixXd modes);

  /// Returns the number of modes K.
  Eigen::Index NumberOfModes() const { return this->Modes.cols(); }
  /// Returns the standard deviations of the modes, [K]: their norms.
  const Eigen::VectorXd& StandardDeviations() const { return this->Norms; }
  /// Returns the shape of coefficients, [n]; missing ones are 0.
  /// @param coefficients [at most K], in standard deviations
  /// @throws InvalidInput for more than K coefficients, or one that is not finite
  Eigen::VectorXd Shape(const Eigen::VectorXd& coefficients) const;
  /// Returns random coefficients, [K]: the N(0, 1) number of (seed, sample, stream, mode).
  Eigen::VectorXd RandomCoefficients(std::uint64_t seed, std::uint32_t sample, std::uint32_t stream = 0) const;
  /// Returns the coefficients of the orthogonal projection of @p shape, [n], on the modes: those of the nearest shape of
  /// the model.
  /// @throws InvalidInput for another size, or a number that is not finite
  Eigen::VectorXd Project(const Eigen::VectorXd& shape) const;

private:
  Eigen::VectorXd Mean;
  Eigen::MatrixXd Modes;
  Eigen::VectorXd Norms;
};

} // namespace surfsynth
