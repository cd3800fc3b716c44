// SPDX-License-Identifier: BSD-3-Clause
#include "RandomFields.h"

#include "Reporting.h"

#include "SampleMemory.h"
#include "SurfaceArrays.h"

#include <vtkDataObject.h>
#include <vtkDataSet.h>
#include <vtkDoubleArray.h>
#include <vtkInformationVector.h>
#include <vtkPointData.h>

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

void AddNoiseArrays(const std::vector<vtkSmartPointer<vtkDoubleArray>>& arrays, vtkDataSet* output, bool active)
{
  vtkPointData* pointData = output->GetPointData();
  for (const auto& array : arrays)
  {
    pointData->AddArray(array);
  }
  if (!arrays.empty())
  {
    SetActiveWhereNone(pointData, arrays.front()->GetName());
  }
  if (active && !arrays.empty())
  {
    pointData->SetActiveScalars(arrays.front()->GetName());
  }
}

void AddSamples(
  const SampleSeries& series, const std::function<void(const SampleDestination&)>& draw, vtkDataSet* output)
{
  std::vector<vtkSmartPointer<vtkDoubleArray>> arrays;
  draw([&](std::uint32_t sample) {
    arrays.push_back(NewNoiseArray(SampleName(series.OutputArrayName, series.NumberOfSamples, sample),
      output->GetNumberOfPoints(), series.NumberOfComponents));
    return arrays.back()->GetPointer(0);
  });
  AddNoiseArrays(arrays, output, series.ActiveResult);
}

bool RequireSeries(vtkAlgorithm* self, const SampleSeries& series, vtkInformationVector** inputVector,
  vtkInformationVector* outputVector)
{
  const double bytes = 8.0 * series.NumberOfComponents;
  const std::string problem = series.OutputArrayName.empty()
    ? "OutputArrayName is empty; a name for the point array is needed."
    : ProblemOfMemory(
        vtkDataObject::GetData(inputVector[0]), { series.NumberOfSamples, bytes, 0.0, 1024.0, series.MemoryLimit });
  if (problem.empty())
  {
    return true;
  }
  ReportError(self, "", problem);
  vtkDataObject::GetData(outputVector)->Initialize();
  return false;
}

} // namespace surfsynth
