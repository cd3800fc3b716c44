// SPDX-License-Identifier: BSD-3-Clause
#include "FlowMatchingTesting.h"

#include "RandomFlowModel.h"
#include "TestMeshes.h"

#include <vtkDataArray.h>
#include <vtkPointData.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

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
}

std::string WriteDeformer(const std::string& name, std::uint64_t seed, const ModelChange& change)
{
  return Write(name, surfsynth::test::RandomDeformer(surfsynth::test::Icosphere(2), seed), change);
}

std::string WriteSignalModel(
  const std::string& name, int components, std::uint64_t seed, const ModelChange& change)
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

vtkSmartPointer<vtkDataObject> OutputOf(vtkAlgorithm* filter, double time)
{
  EventRecorder events(filter);
  EXPECT_TRUE(time < 0.0 ? Update(filter) : filter->UpdateTimeStep(time));
  EXPECT_TRUE(events.Errors.empty()) << events.AllErrors();
  EXPECT_TRUE(events.Warnings.empty()) << ::testing::PrintToString(events.Warnings);
  return filter->GetOutputDataObject(0);
}

vtkSmartPointer<vtkPolyData> SurfaceOf(vtkAlgorithm* filter, double time)
{
  auto copy = vtkSmartPointer<vtkPolyData>::New(); // the filter's own output changes with the next update
  copy->ShallowCopy(OutputOf(filter, time));
  return copy;
}

vtkDataArray* PointArray(vtkDataObject* surface, const char* name)
{
  auto* polydata = vtkPolyData::SafeDownCast(surface);
  vtkDataArray* array = polydata ? polydata->GetPointData()->GetArray(name) : nullptr;
  EXPECT_TRUE(array) << name;
  return array;
}

double LargestDifference(vtkDataArray* a, vtkDataArray* b)
{
  EXPECT_EQ(a->GetNumberOfValues(), b->GetNumberOfValues());
  double largest = 0.0;
  for (vtkIdType t = 0; t < a->GetNumberOfTuples(); ++t)
  {
    for (int c = 0; c < a->GetNumberOfComponents(); ++c)
    {
      largest = std::max(largest, std::abs(a->GetComponent(t, c) - b->GetComponent(t, c)));
    }
  }
  return largest;
}

} // namespace surfsynthtest
