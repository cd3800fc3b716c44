// SPDX-License-Identifier: BSD-3-Clause
#include "RandomPoissonNet.h"

#include "ExampleMeshes.h"

#include <cmath>

namespace surfsynth::test
{

PoissonNetModel RandomModel(const PoissonNetOptions& options, std::uint64_t seed)
{
  PoissonNetModel model;
  model.Options = options;
  seed *= 100000;
  for (const auto& [name, shape] : ExpectedTensors(options))
  {
    ModelTensor& tensor = model.Tensors[name];
    tensor.Shape = shape;
    const std::int64_t inputs = shape.back();
    tensor.Values.resize(static_cast<std::size_t>(shape.size() == 2 ? shape[0] * inputs : inputs));
    ++seed;
    for (std::size_t k = 0; k < tensor.Values.size(); ++k)
    {
      tensor.Values[k] = static_cast<float>(Uniform(seed, k) / std::sqrt(static_cast<double>(inputs)));
    }
  }
  return model;
}

} // namespace surfsynth::test
