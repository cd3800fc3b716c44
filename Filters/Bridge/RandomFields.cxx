// SPDX-License-Identifier: BSD-3-Clause
#include "RandomFields.h"

#include <vtkDataObject.h>
#include <vtkDoubleArray.h>
#include <vtkInformationVector.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>

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

void AddNoiseArrays(const std::vector<vtkSmartPointer<vtkDoubleArray>>& arrays, vtkPolyData* output)
{
  vtkPointData* pointData = output->GetPointData();
  for (const auto& array : arrays)
  {
    pointData->AddArray(array);
  }
  if (!pointData->GetScalars() && !arrays.empty())
  {
    pointData->SetActiveScalars(arrays.front()->GetName());
  }
}

void AddSamples(
  const SampleSeries& series, const std::function<void(const SampleDestination&)>& draw, vtkPolyData* output)
{
  std::vector<vtkSmartPointer<vtkDoubleArray>> arrays;
  draw([&](std::uint32_t sample) {
    arrays.push_back(NewNoiseArray(SampleName(series.OutputArrayName, series.NumberOfSamples, sample),
      output->GetNumberOfPoints(), series.NumberOfComponents));
    return arrays.back()->GetPointer(0);
  });
  AddNoiseArrays(arrays, output);
}

bool RequireOutputArrayName(vtkAlgorithm* self, const SampleSeries& series, vtkInformationVector* outputVector)
{
  if (!series.OutputArrayName.empty())
  {
    return true;
  }
  vtkErrorWithObjectMacro(self, "OutputArrayName is empty; a name for the point array is needed.");
  vtkDataObject::GetData(outputVector)->Initialize();
  return false;
}

} // namespace surfsynth
