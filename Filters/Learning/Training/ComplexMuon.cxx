// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/ComplexMuon.h"

#include <algorithm>
#include <iterator>

namespace surfsynth
{

namespace
{
constexpr std::int64_t SmallestOfMuon = 16;

/// (A -B; B A) of [2, rows, ...].
torch::Tensor RealForm(const torch::Tensor& parameter)
{
  const torch::Tensor parts = parameter.detach().reshape({ 2, parameter.size(1), -1 });
  return torch::cat({ torch::cat({ parts[0], -parts[1] }, 1), torch::cat({ parts[1], parts[0] }, 1) });
}

/// [2, rows, ...] of (A -B; B A), in the shape of @p like.
torch::Tensor ComplexParts(const torch::Tensor& matrix, const torch::Tensor& like)
{
  return matrix.narrow(1, 0, matrix.size(1) / 2).reshape(like.sizes());
}

std::vector<torch::Tensor> Moved(const std::vector<torch::Tensor>& parameters)
{
  std::vector<torch::Tensor> moved;
  std::copy_if(parameters.begin(), parameters.end(), std::back_inserter(moved), &ComplexMuon::Moves);
  return moved;
}

std::vector<torch::Tensor> RealForms(const std::vector<torch::Tensor>& parameters)
{
  std::vector<torch::Tensor> matrices;
  std::transform(parameters.begin(), parameters.end(), std::back_inserter(matrices), &RealForm);
  return matrices;
}
} // namespace

bool ComplexMuon::Moves(const torch::Tensor& parameter)
{
  return parameter.dim() >= 3 && parameter.size(0) == 2 && parameter.size(1) >= SmallestOfMuon &&
    parameter.numel() >= 2 * SmallestOfMuon * parameter.size(1);
}

ComplexMuon::ComplexMuon(const std::vector<torch::Tensor>& parameters)
  : Parameters(Moved(parameters))
  , Matrices(RealForms(this->Parameters))
  , Real(this->Matrices)
{}

void ComplexMuon::TakeGradients()
{
  const torch::NoGradGuard noGradients;
  for (std::size_t k = 0; k < this->Parameters.size(); ++k)
  {
    this->Matrices[k].mutable_grad() = RealForm(this->Parameters[k].grad());
    this->Parameters[k].grad().zero_();
  }
}

void ComplexMuon::Step(double learningRate)
{
  const torch::NoGradGuard noGradients;
  for (std::size_t k = 0; k < this->Parameters.size(); ++k)
  {
    this->Matrices[k].copy_(RealForm(this->Parameters[k]));
  }
  this->Real.Step(learningRate);
  for (std::size_t k = 0; k < this->Parameters.size(); ++k)
  {
    this->Parameters[k].copy_(ComplexParts(this->Matrices[k], this->Parameters[k]));
  }
}

torch::Tensor& ComplexMuon::RealMomentumOf(const torch::Tensor& parameter)
{
  const auto found = std::find_if(this->Parameters.begin(), this->Parameters.end(),
    [&](const torch::Tensor& other) { return other.is_same(parameter); });
  return this->Real.MomentumOf(this->Matrices[static_cast<std::size_t>(found - this->Parameters.begin())]);
}

torch::Tensor ComplexMuon::MomentumOf(const torch::Tensor& parameter)
{
  return ComplexParts(this->RealMomentumOf(parameter), parameter);
}

void ComplexMuon::SetMomentum(const torch::Tensor& parameter, const torch::Tensor& momentum)
{
  this->RealMomentumOf(parameter).copy_(RealForm(momentum));
}

} // namespace surfsynth
