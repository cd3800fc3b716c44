// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Writes a model file, reads it and evaluates the network, without a header of torch. With all weights zero a
/// gradient-domain head adds nothing to the gradients of the positions, and integrating them gives the positions back.
#include <Inference/PoissonNet/PoissonNetEvaluator.h>
#include <Inference/PoissonNet/PoissonNetModel.h>

#include <cstdio>
#include <iostream>

int main()
{
  surfsynth::PoissonNetModel model;
  model.Options.Width = 8;
  model.Options.Blocks = 1;
  for (const auto& [name, shape] : surfsynth::ExpectedTensors(model.Options))
  {
    const std::int64_t count = shape.size() == 2 ? shape[0] * shape[1] : shape[0];
    model.Tensors[name] = { shape, std::vector<float>(static_cast<std::size_t>(count), 0.0F) };
  }
  surfsynth::WritePoissonNet("zero.safetensors", model);

  surfsynth::TriangleMesh mesh;
  mesh.Points.resize(6, 3);
  mesh.Points << 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1;
  mesh.Points *= 0.4; // about unit area
  mesh.Triangles.resize(8, 3);
  mesh.Triangles << 0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5;
  const surfsynth::PoissonNetPrediction prediction = surfsynth::EvaluatePoissonNet(
    surfsynth::ReadPoissonNet("zero.safetensors"), mesh);
  std::remove("zero.safetensors");
  std::cout << prediction.Values << "\n";
  if (!prediction.Values.isApprox(mesh.Points.cast<float>(), 1e-5F))
  {
    std::cerr << "expected the positions\n" << mesh.Points << "\n";
    return 1;
  }
  return 0;
}
