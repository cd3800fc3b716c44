// SPDX-License-Identifier: BSD-3-Clause
//
// Trains a small PoissonNet to predict values at the points of a surface, whichever way the surface is turned, and
// writes it as a model file.
//
//   TrainRegression model.safetensors loss.csv steps training.safetensors...
//
// A training file holds points [V, 3], triangles [F, 3] and values [V, C]; the surface should have area 1.
// smoothed_curvature.py makes one. Several may hold triangulations of one surface, which the steps take in turn. Each
// step shows the network a surface in a random orientation: its operators, which are intrinsic, are the same for all of
// them, and are made once.
#include "Core/Mesh/MeshCheck.h"
#include "IO/Weights/SafetensorsFile.h"
#include "Inference/PoissonNet/PoissonOperators.h"
#include "Learning/Networks/PoissonNet.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

namespace
{
using namespace surfsynth;

struct TrainingSurface
{
  MeshTensors Mesh;
  torch::Tensor Points; ///< [V, 3]
  torch::Tensor Values; ///< [V, C]
};

torch::Tensor ReadTensor(const SafetensorsFile& file, const std::string& name)
{
  std::vector<float> values = file.Float32(name);
  return torch::from_blob(values.data(), file.Entry(name).Shape).clone();
}

TrainingSurface ReadSurface(const std::string& path)
{
  const SafetensorsFile file(path);
  const std::vector<double> points = file.Float64("points");
  const std::vector<std::int64_t> triangles = file.Integers("triangles");
  TriangleMesh mesh;
  mesh.Points = Eigen::Map<const PointMatrix>(points.data(), static_cast<Eigen::Index>(points.size() / 3), 3);
  mesh.Triangles.resize(static_cast<Eigen::Index>(triangles.size() / 3), 3);
  std::copy(triangles.begin(), triangles.end(), mesh.Triangles.data());
  MeshRequirements requirements;
  requirements.ConsistentWinding = requirements.SingleComponent = true;
  const MeshTopology topology = RequireValidMesh(mesh, requirements);
  return { MeshTensors(BuildPoissonOperators(mesh, topology)), ReadTensor(file, "points"), ReadTensor(file, "values") };
}

/// A uniformly distributed rotation, [3, 3], of a random unit quaternion.
torch::Tensor RandomRotation()
{
  const torch::Tensor quaternion = torch::randn({ 4 }, torch::kFloat64);
  const torch::Tensor unit = quaternion / quaternion.norm();
  const auto at = [&](int k) { return unit[k].item<double>(); };
  const double w = at(0), x = at(1), y = at(2), z = at(3);
  return torch::tensor({ 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), //
                         2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x), //
                         2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y) },
    torch::kFloat32)
    .reshape({ 3, 3 });
}

PoissonNetOptions SmallNetwork(std::int64_t channels)
{
  PoissonNetOptions options;
  options.Width = 32;
  options.Blocks = 3;
  options.ComplexLayers = 2;
  options.InnerProducts = true;
  options.Head = PoissonNetHead::Linear;
  options.OutputChannels = channels;
  return options;
}

/// Mean squared error over the surface, as a fraction of the variance of the values.
torch::Tensor RelativeError(const TrainingSurface& surface, const torch::Tensor& prediction)
{
  const torch::Tensor centered = surface.Values - MassMean(surface.Mesh, surface.Values);
  const torch::Tensor variance = MassMean(surface.Mesh, centered.square());
  return (MassMean(surface.Mesh, (prediction - surface.Values).square()) / variance).mean();
}

void Train(const std::string& model, const std::string& losses, int steps, const std::vector<std::string>& training)
{
  torch::manual_seed(31415);
  std::vector<TrainingSurface> surfaces(training.size());
  std::transform(training.begin(), training.end(), surfaces.begin(), ReadSurface);
  PoissonNet network(SmallNetwork(surfaces.front().Values.size(1)));
  torch::optim::Adam optimizer(network->parameters(), torch::optim::AdamOptions(3e-3));
  std::ofstream table(losses);
  table << "step,error\n";
  for (int step = 0; step < steps; ++step)
  {
    const TrainingSurface& surface = surfaces[static_cast<std::size_t>(step) % surfaces.size()];
    const double done = static_cast<double>(step) / steps; // the learning rate falls along half a cosine
    static_cast<torch::optim::AdamOptions&>(optimizer.param_groups()[0].options())
      .lr(1e-5 + 3e-3 * 0.5 * (1.0 + std::cos(3.14159265358979 * done)));
    optimizer.zero_grad();
    const torch::Tensor error = RelativeError(
      surface, network->forward(surface.Mesh, surface.Points.matmul(RandomRotation().t())).Values);
    error.backward();
    torch::nn::utils::clip_grad_norm_(network->parameters(), 1.0);
    optimizer.step();
    table << step << ',' << error.item<double>() << '\n';
    if (step % 100 == 0)
    {
      std::cout << "step " << step << ": error " << error.item<double>() << std::endl;
    }
  }
  PoissonNetModel result = ModelOf(*network);
  result.Normalization = InputNormalization::SurfaceArea;
  WritePoissonNet(model, result);
}
} // namespace

int main(int argc, char* argv[])
{
  if (argc < 5)
  {
    std::cerr << "usage: TrainRegression model.safetensors loss.csv steps training.safetensors...\n";
    return 2;
  }
  try
  {
    Train(argv[1], argv[2], std::stoi(argv[3]), std::vector<std::string>(argv + 4, argv + argc));
    return 0;
  }
  catch (const std::exception& error)
  {
    std::cerr << "TrainRegression: " << error.what() << '\n';
    return 1;
  }
}
