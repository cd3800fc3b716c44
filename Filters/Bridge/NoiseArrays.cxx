// SPDX-License-Identifier: BSD-3-Clause
#include "NoiseArrays.h"

#include <vtkDoubleArray.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>

#include <memory>

namespace surfsynth
{

vtkSmartPointer<vtkDoubleArray> NewNoiseArray(const std::string& name, vtkIdType tuples, int components)
{
  std::unique_ptr<double[]> values(new double[static_cast<std::size_t>(tuples) * static_cast<std::size_t>(components)]);
  auto array = vtkSmartPointer<vtkDoubleArray>::New();
  array->SetName(name.c_str());
  array->SetNumberOfComponents(components);
  array->SetArray(values.release(), tuples * components, 0, vtkDoubleArray::VTK_DATA_ARRAY_DELETE);
  return array;
}

std::string SampleName(const std::string& name, int numberOfSamples, std::uint32_t sample)
{
  return numberOfSamples == 1 ? name : name + "_" + std::to_string(sample);
}

void AddNoiseArrays(const std::vector<vtkSmartPointer<vtkDoubleArray>>& arrays, vtkPolyData* output, bool active)
{
  vtkPointData* pointData = output->GetPointData();
  for (const auto& array : arrays)
  {
    pointData->AddArray(array);
  }
  if ((active || !pointData->GetScalars()) && !arrays.empty())
  {
    pointData->SetActiveScalars(arrays.front()->GetName());
  }
}

} // namespace surfsynth
