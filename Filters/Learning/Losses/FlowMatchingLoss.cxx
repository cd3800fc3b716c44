// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Losses/FlowMatchingLoss.h"

namespace surfsynth
{

FlowMatchingLoss ComputeFlowMatchingLoss(
  const MeshTensors& mesh, const PoissonNetOutput& prediction, const torch::Tensor& delta)
{
  FlowMatchingLoss loss;
  const torch::Tensor difference = prediction.Values - delta;
  loss.Vertex = MassMean(mesh, difference.square()).mean({ -2, -1 });
  const auto weighted = [&](const torch::Tensor& squares) {
    return (squares * mesh.FaceAreas).sum(-2).mean(-1) / mesh.FaceAreas.sum();
  };
  if (!prediction.Gradients.defined())
  {
    const ComplexTensor gradient = FaceGradient(mesh, difference);
    loss.Jacobian = weighted(gradient.Real.square() + gradient.Imaginary.square()) / 2.0;
    return loss;
  }
  // The rows of x and y components alternate: [..., 2 F, C] is [..., F, 2, C].
  std::vector<std::int64_t> shape = prediction.Gradients.sizes().vec();
  shape[shape.size() - 2] /= 2;
  shape.insert(shape.end() - 1, 2);
  const torch::Tensor predicted = prediction.Gradients.reshape(shape);
  const ComplexTensor gradient = FaceGradient(mesh, delta);
  loss.Jacobian = weighted((predicted.select(-2, 0) - gradient.Real).square() +
                    (predicted.select(-2, 1) - gradient.Imaginary).square()) /
    2.0;
  return loss;
}

} // namespace surfsynth
