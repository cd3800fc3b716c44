// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/Muon.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace surfsynth
{

namespace
{
constexpr std::int64_t SmallestSide = 16;
constexpr double Momentum = 0.95;
constexpr double StepSize = 0.2; ///< root mean square of the elements of a step, over the learning rate
} // namespace

torch::Tensor Orthogonalized(const torch::Tensor& matrix)
{
  // p(x) = a x + b x^3 + c x^5 takes singular values in (0, 1] towards 1, the small ones by a factor of a at first.
  constexpr double A = 3.4445;
  constexpr double B = -4.7750;
  constexpr double C = 2.0315;
  constexpr double Tiny = 1e-12; // squares of floats below 1e-19 are 0, and so is the norm of such a matrix
  constexpr int Iterations = 5;
  const bool isTall = matrix.size(0) > matrix.size(1);
  torch::Tensor result = isTall ? matrix.t() : matrix;
  result = result / result.norm().clamp_min(Tiny);
  for (int k = 0; k < Iterations; ++k)
  {
    const torch::Tensor squares = result.matmul(result.t());
    result = A * result + (B * squares + C * squares.matmul(squares)).matmul(result);
  }
  return isTall ? result.t() : result;
}

bool Muon::Moves(const torch::Tensor& parameter)
{
  return parameter.dim() == 2 && std::min(parameter.size(0), parameter.size(1)) >= SmallestSide;
}

Muon::Muon(std::vector<torch::Tensor> matrices)
  : Matrices(std::move(matrices))
{
  for (const torch::Tensor& matrix : this->Matrices)
  {
    this->Means.push_back(torch::zeros_like(matrix).detach());
  }
}

torch::Tensor& Muon::MomentumOf(const torch::Tensor& matrix)
{
  const auto found = std::find_if(
    this->Matrices.begin(), this->Matrices.end(), [&](const torch::Tensor& other) { return other.is_same(matrix); });
  return this->Means[static_cast<std::size_t>(found - this->Matrices.begin())];
}

void Muon::Step(double learningRate)
{
  const torch::NoGradGuard noGradients;
  for (std::size_t k = 0; k < this->Matrices.size(); ++k)
  {
    torch::Tensor& matrix = this->Matrices[k];
    if (!matrix.grad().defined())
    {
      continue;
    }
    const torch::Tensor& gradient = matrix.grad();
    this->Means[k].mul_(Momentum).add_(gradient, 1.0 - Momentum);
    const torch::Tensor direction = Momentum * this->Means[k] + (1.0 - Momentum) * gradient;
    const auto side = static_cast<double>(std::max(matrix.size(0), matrix.size(1)));
    matrix.sub_(Orthogonalized(direction), StepSize * std::sqrt(side) * learningRate);
  }
}

} // namespace surfsynth
