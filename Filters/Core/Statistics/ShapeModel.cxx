// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Statistics/ShapeModel.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Random/CounterNormals.h"

#include <cmath>
#include <string>
#include <utility>

namespace surfsynth
{

namespace
{
/// Largest cosine of the angle of two modes: files may hold them in single precision.
constexpr double LargestCosine = 1e-3;

[[noreturn]] void RefuseModel(const std::string& text) { throw InvalidInput("ShapeModel: " + text); }

void RequireOrthogonalModes(const Eigen::MatrixXd& modes, const Eigen::VectorXd& norms)
{
  for (Eigen::Index k = 0; k < modes.cols(); ++k)
  {
    if (!(norms[k] > 0.0))
    {
      RefuseModel("mode " + std::to_string(k) + " is zero; expected a mode with a variance.");
    }
    for (Eigen::Index j = 0; j < k; ++j)
    {
      const double cosine = modes.col(j).dot(modes.col(k)) / (norms[j] * norms[k]);
      if (std::abs(cosine) > LargestCosine)
      {
        RefuseModel("modes " + std::to_string(j) + " and " + std::to_string(k) + " have the cosine " +
          FormatNumber(cosine) + "; expected orthogonal modes, as vtkEnsembleStatistics makes them.");
      }
    }
  }
}
} // namespace

ShapeModel::ShapeModel(Eigen::VectorXd mean, Eigen::MatrixXd modes)
  : Mean(std::move(mean))
  , Modes(std::move(modes))
{
  if (this->Modes.rows() != this->Mean.size())
  {
    RefuseModel("modes have " + std::to_string(this->Modes.rows()) + " values and the mean " +
      std::to_string(this->Mean.size()) + "; expected the same number.");
  }
  if (!this->Mean.allFinite() || !this->Modes.allFinite())
  {
    RefuseModel("the mean or a mode has a value that is not finite; expected finite values at all points.");
  }
  this->Norms = this->Modes.colwise().norm().transpose();
  RequireOrthogonalModes(this->Modes, this->Norms);
}

Eigen::VectorXd ShapeModel::Shape(const Eigen::VectorXd& coefficients) const
{
  if (coefficients.size() > this->Modes.cols())
  {
    RefuseModel("found " + std::to_string(coefficients.size()) + " coefficients; expected at most " +
      std::to_string(this->Modes.cols()) + ", one for each mode.");
  }
  if (!coefficients.allFinite())
  {
    RefuseModel("a coefficient is not finite; expected finite numbers.");
  }
  return this->Mean + this->Modes.leftCols(coefficients.size()) * coefficients;
}

Eigen::VectorXd ShapeModel::RandomCoefficients(std::uint64_t seed, std::uint32_t sample, std::uint32_t stream) const
{
  NormalKey key;
  key.Seed = seed;
  key.Sample = sample;
  key.Stream = stream;
  Eigen::VectorXd coefficients(this->Modes.cols());
  FillNormals(key, 0, coefficients.size(), coefficients.data());
  return coefficients;
}

Eigen::VectorXd ShapeModel::Project(const Eigen::VectorXd& shape) const
{
  if (shape.size() != this->Mean.size())
  {
    RefuseModel("the shape has " + std::to_string(shape.size()) + " values and the model " +
      std::to_string(this->Mean.size()) + "; expected the same number.");
  }
  if (!shape.allFinite())
  {
    RefuseModel("the shape has a value that is not finite; expected finite values at all points.");
  }
  const Eigen::VectorXd products = this->Modes.transpose() * (shape - this->Mean);
  return products.cwiseQuotient(this->Norms.cwiseAbs2());
}

} // namespace surfsynth
