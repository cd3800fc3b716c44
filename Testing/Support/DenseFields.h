// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Dense algebra that tests hold random fields against, on surfaces and in volumes.
#pragma once

#include "Core/Noise/MaternField.h"

#include <Eigen/Dense>

#include <gtest/gtest.h>

namespace surfsynth::test
{

/// A^-1 (M A^-1)^(power - 1) by dense algebra, for a mesh without unused points.
inline Eigen::MatrixXd DenseCovariance(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& mass, int power)
{
  const Eigen::MatrixXd inverse = matrix.llt().solve(Eigen::MatrixXd::Identity(matrix.rows(), matrix.cols()));
  Eigen::MatrixXd covariance = inverse;
  for (int k = 1; k < power; ++k)
  {
    covariance = inverse * mass.asDiagonal() * covariance;
  }
  return 0.5 * (covariance + covariance.transpose());
}

/// Covariance of a field, column by column.
inline Eigen::MatrixXd Covariance(const MaternField& field)
{
  const Eigen::Index points = field.Mesh().Points.rows();
  return field.SolvePrecision(Eigen::MatrixXd::Identity(points, points));
}

/// Expects entries to differ by at most @p tolerance times the largest one.
inline void ExpectClose(const Eigen::MatrixXd& actual, const Eigen::MatrixXd& expected, double tolerance)
{
  ASSERT_EQ(actual.rows(), expected.rows());
  ASSERT_EQ(actual.cols(), expected.cols());
  EXPECT_LE((actual - expected).cwiseAbs().maxCoeff(), tolerance * expected.cwiseAbs().maxCoeff());
}

} // namespace surfsynth::test
