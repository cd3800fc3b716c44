// SPDX-License-Identifier: BSD-3-Clause
#include "FlowMatchingPipelines.h"

#include "ExampleMeshes.h"
#include "RandomFlowMatching.h"

namespace surfsynthtest
{

using namespace surfsynth;

namespace
{
std::string Write(const std::string& name, FlowMatchingModel model, const ModelChange& change)
{
  if (change)
  {
    change(model);
  }
  WriteFlowMatchingModel(name, model);
  return name;
}

template <typename Filter>
vtkSmartPointer<Filter> FilterOn(vtkDataObject* input, const std::string& model)
{
  auto filter = vtkSmartPointer<Filter>::New();
  filter->SetInputDataObject(input);
  filter->SetModelFileName(model.c_str());
  filter->SetNumberOfSteps(4);
  return filter;
}
} // namespace

std::string WriteDeformer(const std::string& name, std::uint64_t seed, const ModelChange& change)
{
  return Write(name, surfsynth::test::RandomDeformer(surfsynth::test::Icosphere(2), seed), change);
}

std::string WriteSignalModel(const std::string& name, int components, std::uint64_t seed, const ModelChange& change)
{
  return Write(name, surfsynth::test::RandomSignalModel(surfsynth::test::Icosphere(2), components, seed), change);
}

vtkSmartPointer<vtkFlowMatchingDeformer> DeformerOn(vtkDataObject* input, const std::string& model)
{
  return FilterOn<vtkFlowMatchingDeformer>(input, model);
}

vtkSmartPointer<vtkFlowMatchingSampler> SamplerOn(vtkDataObject* input, const std::string& model)
{
  return FilterOn<vtkFlowMatchingSampler>(input, model);
}

} // namespace surfsynthtest
