// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Layers/FusedLayers.h"

#include "Core/Common/Errors.h"
#include "Inference/Common/ActivationKernels.h"
#include "Learning/Layers/KeptValue.h"

#include <ATen/Parallel.h>

#include <algorithm>

namespace surfsynth
{

namespace
{
using torch::autograd::AutogradContext;
using torch::autograd::variable_list;

/// Rows that a thread takes at a time; derivatives by a bias are summed over each such range first, so that they do not
/// depend on the number of threads.
constexpr std::int64_t RowsAtOnce = 512;

using IncidencePointer = std::shared_ptr<const FaceIncidence>;

/// Refuses second derivatives: only their computation records a backward pass.
void RefuseSecondDerivatives()
{
  if (torch::GradMode::is_enabled())
  {
    throw InvalidInput(
      "FusedLayers: second derivatives of float32 layers on the processor are asked for; expected first "
      "ones (float64 has both).");
  }
}

std::vector<std::int64_t> WithRows(const torch::Tensor& like, std::int64_t rows)
{
  std::vector<std::int64_t> shape = like.sizes().vec();
  shape[shape.size() - 2] = rows;
  return shape;
}

/// Calls body(b, first, last) for ranges of rows of each element b of a batch, on torch's threads.
template <typename Body>
void ForRows(std::int64_t batch, std::int64_t rows, const Body& body)
{
  const std::int64_t ranges = (rows + RowsAtOnce - 1) / RowsAtOnce;
  at::parallel_for(0, batch * ranges, 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t k = begin; k < end; ++k)
    {
      const std::int64_t first = k % ranges * RowsAtOnce;
      body(k / ranges, first, std::min(first + RowsAtOnce, rows));
    }
  });
}

std::array<torch::Tensor, 3> GatherFaces(const FaceIncidence& incidence, const torch::Tensor& signal)
{
  const torch::Tensor in = signal.contiguous();
  const std::int64_t width = in.size(-1);
  const std::int64_t vertices = in.size(-2);
  const std::int64_t faces = incidence.NumberOfFaces();
  std::array<torch::Tensor, 3> out;
  for (torch::Tensor& tensor : out)
  {
    tensor = torch::empty(WithRows(in, faces), in.options());
  }
  const float* from = in.data_ptr<float>();
  float* const to[3] = { out[0].data_ptr<float>(), out[1].data_ptr<float>(), out[2].data_ptr<float>() };
  ForRows(in.numel() / std::max<std::int64_t>(vertices * width, 1), faces,
    [&](std::int64_t b, std::int64_t first, std::int64_t last) {
      const std::int64_t at = (b * faces + first) * width;
      BestActivationKernels().GatherFaces(from + b * vertices * width, incidence.Corners.row(first).data(),
        incidence.BasisGradients.row(first).data(), last - first, width, to[0] + at, to[1] + at, to[2] + at);
    });
  return out;
}

/// Sums over the faces around each vertex; undefined tensors count as 0, real and imaginary come together.
torch::Tensor GatherVertices(const FaceIncidence& incidence, const FaceIncidence::Weights& weights,
  const torch::Tensor& real, const torch::Tensor& imaginary, const torch::Tensor& mean)
{
  const torch::Tensor re = real.defined() ? real.contiguous() : real;
  const torch::Tensor im = imaginary.defined() ? imaginary.contiguous() : imaginary;
  const torch::Tensor average = mean.defined() ? mean.contiguous() : mean;
  const torch::Tensor& like = re.defined() ? re : average;
  const std::int64_t width = like.size(-1);
  const std::int64_t faces = like.size(-2);
  const std::int64_t vertices = incidence.NumberOfVertices();
  const torch::Tensor out = torch::empty(WithRows(like, vertices), like.options());
  const auto data = [](const torch::Tensor& tensor, std::int64_t offset) -> const float* {
    return tensor.defined() ? tensor.data_ptr<float>() + offset : nullptr;
  };
  float* to = out.data_ptr<float>();
  ForRows(like.numel() / std::max<std::int64_t>(faces * width, 1), vertices,
    [&](std::int64_t b, std::int64_t first, std::int64_t last) {
      const std::int64_t at = b * faces * width;
      BestActivationKernels().GatherVertices(data(re, at), data(im, at), data(average, at), incidence.Offsets.data(),
        incidence.Faces.data(), weights[0].data(), weights[1].data(), weights[2].data(), first, last - first, width,
        to + b * vertices * width);
    });
  return out;
}

class GatherFacesStep : public torch::autograd::Function<GatherFacesStep>
{
public:
  static variable_list forward(
    AutogradContext* context, const torch::Tensor& signal, const std::shared_ptr<const FaceIncidence>& incidence)
  {
    KeepValue(context, incidence);
    const std::array<torch::Tensor, 3> out = GatherFaces(*incidence, signal);
    return { out.begin(), out.end() };
  }
  static variable_list backward(AutogradContext* context, const variable_list& gradients)
  {
    RefuseSecondDerivatives();
    const std::shared_ptr<const FaceIncidence> incidence = KeptValue<IncidencePointer>(context);
    return { GatherVertices(*incidence, incidence->Transposed, gradients[0], gradients[1], gradients[2]),
      torch::Tensor() };
  }
};

class DivergenceStep : public torch::autograd::Function<DivergenceStep>
{
public:
  static torch::Tensor forward(AutogradContext* context, const torch::Tensor& real, const torch::Tensor& imaginary,
    const std::shared_ptr<const FaceIncidence>& incidence)
  {
    KeepValue(context, incidence);
    return GatherVertices(*incidence, incidence->Divergence, real, imaginary, {});
  }
  static variable_list backward(AutogradContext* context, const variable_list& gradients)
  {
    RefuseSecondDerivatives();
    const std::shared_ptr<const FaceIncidence> incidence = KeptValue<IncidencePointer>(context);
    std::array<torch::Tensor, 3> gathered = GatherFaces(*incidence, gradients[0]);
    const torch::Tensor areas = torch::from_blob(
      const_cast<float*>(incidence->Areas.data()), { incidence->NumberOfFaces(), 1 }, torch::kFloat32);
    return { gathered[0].mul_(areas), gathered[1].mul_(areas), torch::Tensor() };
  }
};
} // namespace

FaceIncidence::FaceIncidence(const PoissonOperators& operators)
  : Corners(operators.Triangles)
  , BasisGradients(operators.Gradient)
  , Areas(operators.FaceAreas)
  , Offsets(static_cast<std::size_t>(operators.NumberOfPoints()) + 1, 0)
  , Faces(static_cast<std::size_t>(this->Corners.size()))
{
  for (Eigen::Index k = 0; k < this->Corners.size(); ++k)
  {
    const Index v = this->Corners.data()[k];
    ++this->Offsets[static_cast<std::size_t>(v) + 1];
  }
  for (std::size_t v = 1; v < this->Offsets.size(); ++v)
  {
    this->Offsets[v] += this->Offsets[v - 1];
  }
  for (int part = 0; part < 3; ++part)
  {
    this->Transposed[static_cast<std::size_t>(part)].resize(this->Faces.size());
  }
  this->Divergence[0].resize(this->Faces.size());
  this->Divergence[1].resize(this->Faces.size());
  std::vector<std::int32_t> next(this->Offsets.begin(), this->Offsets.end() - 1);
  for (Index f = 0; f < operators.NumberOfTriangles(); ++f)
  {
    for (int k = 0; k < 3; ++k)
    {
      const Index v = this->Corners(f, k);
      const auto entry = static_cast<std::size_t>(next[static_cast<std::size_t>(v)]++);
      this->Faces[entry] = f;
      this->Transposed[0][entry] = this->BasisGradients(f, k);
      this->Transposed[1][entry] = this->BasisGradients(f, 3 + k);
      this->Transposed[2][entry] = 1.0F / 3.0F;
      this->Divergence[0][entry] = this->Areas[f] * this->BasisGradients(f, k);
      this->Divergence[1][entry] = this->Areas[f] * this->BasisGradients(f, 3 + k);
    }
  }
}

std::array<torch::Tensor, 3> FusedGatherFaces(
  const std::shared_ptr<const FaceIncidence>& incidence, const torch::Tensor& signal)
{
  const variable_list out = GatherFacesStep::apply(signal, incidence);
  return { out[0], out[1], out[2] };
}

torch::Tensor FusedDivergence(
  const std::shared_ptr<const FaceIncidence>& incidence, const torch::Tensor& real, const torch::Tensor& imaginary)
{
  return DivergenceStep::apply(real, imaginary, incidence);
}

} // namespace surfsynth
