// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/FieldLatents/LatentMap.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace surfsynth
{

namespace
{
/// Least eigenvalue of a covariance over its largest that counts.
constexpr double LeastVariance = 1e-4;

/// Tangent vectors of the codes as complex numbers, [V, d].
Eigen::MatrixXcd ComplexCodes(const FieldLatentMatrix& latents)
{
  Eigen::MatrixXcd codes(latents.rows(), latents.cols() / 2);
  for (Eigen::Index j = 0; j < codes.cols(); ++j)
  {
    codes.col(j).real() = latents.col(2 * j).cast<double>();
    codes.col(j).imag() = latents.col(2 * j + 1).cast<double>();
  }
  return codes;
}
} // namespace

LatentMap ScalingMap(const FieldLatentMatrix& latents)
{
  const double mean = std::sqrt(std::acos(-1.0) / 2.0);
  const Eigen::RowVectorXd sums = ComplexCodes(latents).cwiseAbs().colwise().sum();
  LatentMap map = LatentMap::Identity(sums.size(), sums.size());
  for (Eigen::Index j = 0; j < sums.size(); ++j)
  {
    map(j, j) = sums(j) > 0.0 ? mean * static_cast<double>(latents.rows()) / sums(j) : 1.0;
  }
  return map;
}

LatentMap WhiteningMap(const FieldLatentMatrix& latents)
{
  const LatentMap scaling = ScalingMap(latents);
  const Eigen::MatrixXcd codes = ComplexCodes(latents) * scaling.transpose();
  // Each of the two components of a tangent vector has half of its mean square.
  const double count = 2.0 * static_cast<double>(std::max<Eigen::Index>(codes.rows(), 1));
  const Eigen::MatrixXcd covariance = (codes.transpose() * codes.conjugate()) / count;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXcd> solver(covariance);
  const double largest = solver.eigenvalues().maxCoeff();
  if (!(largest > 0.0))
  {
    return scaling;
  }
  const Eigen::VectorXd factors = solver.eigenvalues().cwiseMax(LeastVariance * largest).cwiseSqrt().cwiseInverse();
  return solver.eigenvectors() * factors.asDiagonal() * solver.eigenvectors().adjoint() * scaling;
}

Eigen::MatrixXf RealMatrix(const LatentMap& map)
{
  Eigen::MatrixXf matrix(2 * map.cols(), 2 * map.rows());
  for (Eigen::Index o = 0; o < map.rows(); ++o)
  {
    for (Eigen::Index i = 0; i < map.cols(); ++i)
    {
      const auto value = static_cast<std::complex<float>>(map(o, i));
      matrix(2 * i, 2 * o) = matrix(2 * i + 1, 2 * o + 1) = value.real();
      matrix(2 * i, 2 * o + 1) = value.imag();
      matrix(2 * i + 1, 2 * o) = -value.imag();
    }
  }
  return matrix;
}

FieldLatentMatrix Mapped(const LatentMap& map, const FieldLatentMatrix& latents)
{
  // One row after the other: results do not depend on the number of vertices.
  FieldLatentMatrix mapped(latents.rows(), 2 * map.rows());
  const Eigen::MatrixXf matrix = RealMatrix(map);
  for (Eigen::Index v = 0; v < latents.rows(); ++v)
  {
    mapped.row(v).noalias() = latents.row(v).lazyProduct(matrix);
  }
  return mapped;
}

ModelTensor TensorOf(const LatentMap& map)
{
  ModelTensor tensor;
  tensor.Shape = { 2, map.rows(), map.cols() };
  for (int part = 0; part < 2; ++part)
  {
    for (Eigen::Index o = 0; o < map.rows(); ++o)
    {
      for (Eigen::Index i = 0; i < map.cols(); ++i)
      {
        tensor.Values.push_back(static_cast<float>(part == 0 ? map(o, i).real() : map(o, i).imag()));
      }
    }
  }
  return tensor;
}

LatentMap MapOfTensor(const ModelTensor& tensor)
{
  const auto rows = static_cast<Eigen::Index>(tensor.Shape[1]);
  const auto columns = static_cast<Eigen::Index>(tensor.Shape[2]);
  LatentMap map(rows, columns);
  for (Eigen::Index o = 0; o < rows; ++o)
  {
    for (Eigen::Index i = 0; i < columns; ++i)
    {
      const auto at = static_cast<std::size_t>(o * columns + i);
      map(o, i) = { static_cast<double>(tensor.Values[at]),
        static_cast<double>(tensor.Values[at + static_cast<std::size_t>(rows * columns)]) };
    }
  }
  return map;
}

} // namespace surfsynth
