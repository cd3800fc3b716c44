// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/PoissonNet/PoissonNetOptions.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"

namespace surfsynth
{

namespace
{
void RequireRange(const char* name, std::int64_t value, std::int64_t lowest, std::int64_t highest)
{
  if (value < lowest || value > highest)
  {
    throw InvalidInput("PoissonNet: " + std::string(name) + " is " + std::to_string(value) + "; expected " +
      std::to_string(lowest) + " to " + std::to_string(highest) + ".");
  }
}

using Shape = std::vector<std::int64_t>;
using Shapes = std::map<std::string, Shape>;

void AddAffine(Shapes& shapes, const std::string& name, std::int64_t in, std::int64_t out)
{
  shapes[name + ".weight"] = { out, in };
  shapes[name + ".bias"] = { out };
}

void AddComplexLinear(Shapes& shapes, const std::string& name, std::int64_t in, std::int64_t out)
{
  shapes[name + ".lin_real.weight"] = { out, in };
  shapes[name + ".lin_imag.weight"] = { out, in };
}

void AddComplexMlp(
  Shapes& shapes, const std::string& name, std::int64_t width, std::int64_t out, std::int64_t layers, bool modulate)
{
  for (std::int64_t layer = 0; layer < layers; ++layer)
  {
    const std::string prefix = name + ".layers." + std::to_string(layer);
    const bool last = layer == layers - 1;
    AddComplexLinear(shapes, prefix, width, last ? out : width);
    if (!last)
    {
      shapes[prefix + ".mag_bias"] = { width };
    }
  }
  if (modulate)
  {
    AddAffine(shapes, name + ".modulator.modulator.0", width, width);
    AddAffine(shapes, name + ".modulator.modulator.2", width, 2 * width);
  }
}

void AddBlock(Shapes& shapes, const std::string& name, const PoissonNetOptions& options)
{
  const std::int64_t width = options.Width;
  AddComplexMlp(shapes, name + ".grad_mlp", width, width, options.ComplexLayers, options.Modulate);
  std::int64_t inputs = 2 * width;
  if (options.ExtraFeatures > 0)
  {
    inputs += width;
  }
  if (options.InnerProducts)
  {
    inputs += width;
    AddComplexLinear(shapes, name + ".grad_features", width, width);
    shapes[name + ".grad_scaler"] = { width };
  }
  shapes[name + ".vert_mlp.ls1"] = { width };
  shapes[name + ".vert_mlp.ls2"] = { width };
  AddAffine(shapes, name + ".vert_mlp.mlp1.layers.0", inputs, width);
  AddAffine(shapes, name + ".vert_mlp.mlp1.layers.3", width, width);
  AddAffine(shapes, name + ".vert_mlp.mlp2.layers.0", width, width);
  AddAffine(shapes, name + ".vert_mlp.mlp2.layers.3", width, width);
  if (options.Normalize)
  {
    shapes[name + ".vert_mlp.norm_pde.weight"] = { width };
    shapes[name + ".vert_mlp.norm_pde.bias"] = { width };
    if (options.InnerProducts)
    {
      shapes[name + ".vert_mlp.norm_grad.weight"] = { width };
      shapes[name + ".vert_mlp.norm_grad.bias"] = { width };
    }
  }
}
} // namespace

void CheckOptions(const PoissonNetOptions& options)
{
  RequireRange("the number of input channels", options.InputChannels, 1, 100000);
  RequireRange("the number of output channels", options.OutputChannels, 1, 100000);
  RequireRange("the width", options.Width, 1, 100000);
  RequireRange("the number of blocks", options.Blocks, 1, 1000);
  RequireRange("the number of complex layers", options.ComplexLayers, 1, 100);
  RequireRange("the number of extra features", options.ExtraFeatures, 0, 100000);
  if (!(options.Dropout >= 0.0 && options.Dropout < 1.0))
  {
    throw InvalidInput("PoissonNet: dropout is " + FormatNumber(options.Dropout) + "; expected a number in [0, 1).");
  }
  if (options.Head == PoissonNetHead::GradientDomain &&
    (options.InputChannels != 3 || options.Domain != PoissonNetDomain::Vertices ||
      options.Activation != LastActivation::Identity))
  {
    throw InvalidInput("PoissonNet: the head integrates gradients of positions, but there are " +
      std::to_string(options.InputChannels) +
      " input channels, or an output elsewhere than at the vertices, or an "
      "activation after it; expected 3 input channels and neither.");
  }
}

std::map<std::string, std::vector<std::int64_t>> ExpectedTensors(const PoissonNetOptions& options)
{
  CheckOptions(options);
  Shapes shapes;
  if (options.ExtraFeatures > 0)
  {
    AddAffine(shapes, "extra_feat_mlp.0", options.ExtraFeatures, options.Width);
    AddAffine(shapes, "extra_feat_mlp.2", options.Width, options.Width);
  }
  AddAffine(shapes, "proj_in", options.InputChannels, options.Width);
  for (std::int64_t block = 0; block < options.Blocks; ++block)
  {
    AddBlock(shapes, "blocks." + std::to_string(block), options);
  }
  if (options.Head == PoissonNetHead::Linear)
  {
    AddAffine(shapes, "head", options.Width, options.OutputChannels);
  }
  else
  {
    AddComplexMlp(shapes, "head.grad_mlp", options.Width, 3, options.ComplexLayers, options.ModulateHead);
  }
  return shapes;
}

} // namespace surfsynth
