// SPDX-License-Identifier: BSD-3-Clause
#include "EnsembleReading.h"

#include "DataObjects.h"
#include "SurfaceBridge.h"
#include "SurfaceInputs.h"

#include "Core/Common/Errors.h"
#include "Core/Operators/SurfaceOperators.h"

#include <vtkAOSDataArrayTemplate.h>
#include <vtkCellArray.h>
#include <vtkDoubleArray.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

#include <algorithm>
#include <cstring>
#include <utility>

namespace surfsynth
{

namespace
{
template <typename Value>
bool IsStoredAs(vtkDataArray* array)
{
  return vtkAOSDataArrayTemplate<Value>::FastDownCast(array) != nullptr;
}

/// @p array as it is where it can be read in place, else a copy that can.
vtkSmartPointer<vtkDataArray> Readable(vtkDataArray* array)
{
  if (IsStoredAs<float>(array) || IsStoredAs<double>(array))
  {
    return array;
  }
  auto copy = vtkSmartPointer<vtkDoubleArray>::New();
  copy->DeepCopy(array);
  return copy;
}

/// The number k of an array called <prefix>_k; -1 for another name.
long long NumberAfter(const std::string& prefix, const char* name)
{
  const std::string text = name ? name : "";
  const std::string digits = text.size() > prefix.size() + 1 ? text.substr(prefix.size() + 1) : "";
  const bool fits = !digits.empty() && digits.size() <= 18 && text.compare(0, prefix.size(), prefix) == 0 &&
    text[prefix.size()] == '_' && digits.find_first_not_of("0123456789") == std::string::npos;
  return fits ? std::stoll(digits) : -1;
}

/// The point arrays of a surface that are samples, in order.
std::vector<vtkDataArray*> SampleArrays(vtkPolyData* surface, const std::string& name)
{
  vtkPointData* pointData = surface->GetPointData();
  if (vtkDataArray* array = pointData->GetArray(name.c_str()))
  {
    return { array };
  }
  std::vector<std::pair<long long, vtkDataArray*>> numbered;
  for (int k = 0; k < pointData->GetNumberOfArrays(); ++k)
  {
    vtkDataArray* array = pointData->GetArray(k);
    const long long number = array ? NumberAfter(name, array->GetName()) : -1;
    if (number >= 0)
    {
      numbered.emplace_back(number, array);
    }
  }
  std::stable_sort(numbered.begin(), numbered.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<vtkDataArray*> arrays;
  for (const auto& entry : numbered)
  {
    arrays.push_back(entry.second);
  }
  return arrays;
}

/// Adds the samples of one surface, called @p place ("" for the only one).
void AddSamples(Ensemble& ensemble, vtkPolyData* surface, const std::string& place, const std::string& arrayName)
{
  const std::string where = place.empty() ? "The " + ensemble.Role + " surface"
                                          : place + " of the " + ensemble.Role + " ensemble";
  if (surface->GetNumberOfPoints() == 0)
  {
    throw InvalidInput(where + " has cells but no points; write the dataset again with the program that made it.");
  }
  if (arrayName.empty())
  {
    ensemble.Samples.push_back(
      { place.empty() ? "Points" : place, surface, Readable(surface->GetPoints()->GetData()) });
    return;
  }
  const std::vector<vtkDataArray*> arrays = SampleArrays(surface, arrayName);
  if (arrays.empty())
  {
    throw InvalidInput(where + " has no numeric point array called \"" + arrayName + "\", and none called \"" +
      arrayName + "_0\" and so on; name an array that all surfaces have, or none for their points.");
  }
  for (vtkDataArray* array : arrays)
  {
    const std::string name = array->GetName();
    const std::string longName = arrays.size() == 1 ? place : place + ": " + name;
    ensemble.Samples.push_back({ place.empty() ? name : longName, surface, Readable(array) });
  }
}

/// True when both arrays hold the same ids, in 32 bits or in 64.
bool SameIds(vtkDataArray* a, vtkDataArray* b)
{
  if (a->GetNumberOfValues() != b->GetNumberOfValues())
  {
    return false;
  }
  if (a->GetDataType() == b->GetDataType())
  {
    const auto bytes = static_cast<std::size_t>(a->GetNumberOfValues()) *
      static_cast<std::size_t>(a->GetDataTypeSize());
    return bytes == 0 || std::memcmp(a->GetVoidPointer(0), b->GetVoidPointer(0), bytes) == 0;
  }
  for (vtkIdType k = 0; k < a->GetNumberOfValues(); ++k)
  {
    if (a->GetComponent(k, 0) != b->GetComponent(k, 0))
    {
      return false;
    }
  }
  return true;
}

/// Compared as they are stored, because how a polygon is cut into triangles depends on the points.
bool SameCells(vtkCellArray* a, vtkCellArray* b)
{
  const bool none = !a || a->GetNumberOfCells() <= 0;
  if (none || !b || b->GetNumberOfCells() <= 0)
  {
    return none && (!b || b->GetNumberOfCells() <= 0);
  }
  return a == b ||
    (SameIds(a->GetOffsetsArray(), b->GetOffsetsArray()) &&
      SameIds(a->GetConnectivityArray(), b->GetConnectivityArray()));
}

bool SameTriangulation(vtkPolyData* a, vtkPolyData* b)
{
  return a == b || (SameCells(a->GetPolys(), b->GetPolys()) && SameCells(a->GetStrips(), b->GetStrips()));
}

[[noreturn]] void RefuseLeaf(vtkDataObject* leaf, const std::string& place, const std::string& role)
{
  throw InvalidInput(place + " of the " + role + " ensemble is " + DescribeInput(leaf) +
    " where a vtkPolyData is needed; vtkDataSetSurfaceFilter extracts a surface.");
}
} // namespace

std::string Ensemble::NameOf(std::size_t sample) const
{
  return this->Role + " sample " + std::to_string(sample) + " (" + this->Samples[sample].Name + ")";
}

std::vector<SampleValues> Ensemble::Values() const
{
  std::vector<SampleValues> values;
  for (const EnsembleSample& sample : this->Samples)
  {
    if (auto* single = vtkAOSDataArrayTemplate<float>::FastDownCast(sample.Values))
    {
      values.emplace_back(static_cast<const float*>(single->GetPointer(0)));
    }
    else
    {
      values.emplace_back(
        static_cast<const double*>(vtkAOSDataArrayTemplate<double>::FastDownCast(sample.Values)->GetPointer(0)));
    }
  }
  return values;
}

Ensemble ReadEnsemble(vtkDataObject* input, const std::string& role, const std::string& arrayName)
{
  Ensemble ensemble;
  ensemble.Role = role;
  const auto add = [&](vtkDataObject* data, const std::string& place) {
    const auto surface = vtkSmartPointer<vtkPolyData>(vtkPolyData::SafeDownCast(AsSurfaces(data)));
    if (!surface)
    {
      RefuseLeaf(data, place, role);
    }
    if (!IsEmpty(surface))
    {
      AddSamples(ensemble, surface, place, arrayName);
    }
  };
  if (!input)
  {
    throw InvalidInput("There is no " + role + " ensemble; one is needed.");
  }
  for (const Leaf& leaf : LeavesOf(input))
  {
    add(leaf.Data, leaf.Place);
  }
  return ensemble;
}

void RequireOneTriangulation(const Ensemble& ensemble, const SharedSurface& shared, int components)
{
  const vtkIdType points = shared.Surface->GetNumberOfPoints();
  for (std::size_t k = 0; k < ensemble.Samples.size(); ++k)
  {
    const EnsembleSample& sample = ensemble.Samples[k];
    const std::string name = "The " + ensemble.NameOf(k);
    if (sample.Surface->GetNumberOfPoints() != points)
    {
      throw InvalidInput(name + " has " + std::to_string(sample.Surface->GetNumberOfPoints()) + " points and " +
        shared.Name + " has " + std::to_string(points) + "; all samples must lie on one triangulation.");
    }
    if (!SameTriangulation(sample.Surface, shared.Surface))
    {
      throw InvalidInput(name + " has other polygons or strips than " + shared.Name +
        "; all samples must lie on one triangulation, with the same cells in the same order.");
    }
    if (sample.Values->GetNumberOfTuples() != points)
    {
      throw InvalidInput(name + " has " + std::to_string(sample.Values->GetNumberOfTuples()) + " values for " +
        std::to_string(points) + " points; write the dataset again with the program that made it.");
    }
    if (sample.Values->GetNumberOfComponents() != components)
    {
      throw InvalidInput(name + " has " + std::to_string(sample.Values->GetNumberOfComponents()) +
        " components where " + std::to_string(components) +
        " are needed, as in the first sample; all samples must have the same number.");
    }
  }
}

Eigen::VectorXd MassOf(const SharedSurface& shared)
{
  MeshRequirements requirements;
  requirements.ManifoldEdges = false; // areas do not need them
  try
  {
    const Surface surface = ToSurface(shared.Surface, requirements);
    return LumpedMass(surface.Mesh, *surface.Topology);
  }
  catch (const InvalidInput& error)
  {
    throw InvalidInput("The mass of the points cannot be computed from " + shared.Name + ": " + error.what());
  }
}

} // namespace surfsynth
