// SPDX-License-Identifier: BSD-3-Clause
#include "GeometricTexturePipelines.h"

#include "RandomGeometricTexture.h"

#include <vtkDoubleArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>

namespace surfsynthtest
{

std::string WriteRandomGeometricTexture(const std::string& name, std::uint64_t seed,
  const std::function<void(surfsynth::GeometricTextureModel& model)>& change)
{
  surfsynth::GeometricTextureModel model = surfsynth::test::RandomGeometricTexture(
    surfsynth::test::SmallGeometricTexture(), seed);
  if (change)
  {
    change(model);
  }
  surfsynth::WriteGeometricTexture(name, model);
  return name;
}

vtkSmartPointer<vtkGeometricTextureSynthesizer> SynthesizerOn(vtkDataObject* input, const std::string& model)
{
  auto filter = vtkSmartPointer<vtkGeometricTextureSynthesizer>::New();
  if (input)
  {
    filter->SetInputDataObject(input);
  }
  filter->SetModelFileName(model.c_str());
  return filter;
}

void AddPointField(vtkPolyData* surface, const char* name, const std::function<double(const double* point)>& value)
{
  vtkNew<vtkDoubleArray> array;
  array->SetName(name);
  for (vtkIdType p = 0; p < surface->GetNumberOfPoints(); ++p)
  {
    array->InsertNextValue(value(surface->GetPoint(p)));
  }
  surface->GetPointData()->AddArray(array);
}

} // namespace surfsynthtest
