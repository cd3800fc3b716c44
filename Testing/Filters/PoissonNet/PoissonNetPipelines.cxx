// SPDX-License-Identifier: BSD-3-Clause
#include "PoissonNetPipelines.h"

#include "RandomPoissonNet.h"

namespace surfsynthtest
{

using namespace surfsynth;

PoissonNetOptions SmallOptions(PoissonNetDomain domain, LastActivation activation)
{
  PoissonNetOptions options;
  options.Width = 16;
  options.Blocks = 2;
  options.ComplexLayers = 2;
  options.Head = PoissonNetHead::Linear;
  options.OutputChannels = 5;
  options.Domain = domain;
  options.Activation = activation;
  return options;
}

PoissonNetOptions SmallGradientOptions(int conditions)
{
  PoissonNetOptions options = SmallOptions(PoissonNetDomain::Vertices, LastActivation::Identity);
  options.Head = PoissonNetHead::GradientDomain;
  options.OutputChannels = 3;
  options.ModulateHead = true;
  options.ExtraFeatures = conditions;
  return options;
}

std::string WriteModel(
  const std::string& name, const PoissonNetOptions& options, std::uint64_t seed, InputNormalization normalization)
{
  PoissonNetModel model = surfsynth::test::RandomModel(options, seed);
  model.Normalization = normalization;
  WritePoissonNet(name, model);
  return name;
}

vtkSmartPointer<vtkPoissonNetFilter> PoissonNetOn(vtkDataObject* input, const std::string& model)
{
  auto filter = vtkSmartPointer<vtkPoissonNetFilter>::New();
  filter->SetInputDataObject(input);
  filter->SetModelFileName(model.c_str());
  return filter;
}

Soup UnitAreaSphere(int levels)
{
  Soup sphere = Icosphere(levels);
  for (double& coordinate : sphere.Points)
  {
    coordinate *= 0.28; // 4 pi r^2 = 1
  }
  return sphere;
}

} // namespace surfsynthtest
