// SPDX-License-Identifier: BSD-3-Clause
#include "DisplacementImages.h"

#include "NewArray.h"

#include "Core/Common/Errors.h"

#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkFloatArray.h>
#include <vtkImageData.h>
#include <vtkIntArray.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace surfsynth
{

namespace
{
template <typename Array, typename Value>
vtkSmartPointer<Array> ArrayOf(const char* name, const std::vector<Value>& values, int components)
{
  const auto array = NewArray<Array>(name, static_cast<vtkIdType>(values.size()) / components, components);
  std::copy(values.begin(), values.end(), array->GetPointer(0));
  return array;
}
} // namespace

Surface ToPlainSurface(vtkPolyData* polydata)
{
  MeshRequirements requirements;
  requirements.ManifoldEdges = false;
  try
  {
    return ToSurface(polydata, requirements);
  }
  catch (const InvalidInput& error)
  {
    throw InvalidInput(std::string("The plain surface on port 0: ") + error.what());
  }
}

TriangleMesh ToDetailedMesh(vtkPolyData* polydata)
{
  MeshRequirements requirements;
  requirements.ManifoldEdges = false;
  Surface surface;
  try
  {
    surface = ConvertSurface(polydata);
  }
  catch (const InvalidInput& error)
  {
    throw InvalidInput(std::string("The detailed surface on port 1: ") + error.what());
  }
  for (const MeshFinding& finding : CheckMesh(surface.Mesh, requirements))
  {
    if (finding.Defect == MeshDefect::NonFinitePoint)
    {
      throw InvalidInput("The detailed surface on port 1 has " + DescribeFindings({ finding }));
    }
  }
  return std::move(surface.Mesh);
}

HeightEncoding EncodingOf(const DisplacementMap& map)
{
  const double lowest = std::min(0.0, static_cast<double>(map.LowestHeight));
  const double highest = std::max(0.0, static_cast<double>(map.HighestHeight));
  HeightEncoding encoding;
  if (highest > lowest)
  {
    encoding.Scale = highest - lowest;
    encoding.Midlevel = -lowest / encoding.Scale;
  }
  return encoding;
}

void FillDisplacementImage(const DisplacementMap& map, const AtlasRasterOptions& size, vtkImageData* image)
{
  image->SetDimensions(size.Width, size.Height, 1);
  vtkPointData* data = image->GetPointData();
  data->SetScalars(ArrayOf<vtkFloatArray>("Height", map.Heights, 1));
  data->AddArray(ArrayOf<vtkFloatArray>("Displacement", map.Displacements, 3));
  data->AddArray(ArrayOf<vtkUnsignedCharArray>("Coverage", map.Coverage, 1));
  const HeightEncoding encoding = EncodingOf(map);
  vtkFieldData* fields = image->GetFieldData();
  fields->AddArray(ArrayOf<vtkIntArray>("SubdivisionLevels", std::vector<int>{ map.SubdivisionLevels }, 1));
  const std::pair<const char*, double> measures[] = { { "CoveredTexels", static_cast<double>(map.CoveredTexels) },
    { "Misses", static_cast<double>(map.Misses) }, { "MeanMiss", map.MeanMiss }, { "LargestMiss", map.LargestMiss },
    { "HeightMidlevel", encoding.Midlevel }, { "HeightScale", encoding.Scale } };
  for (const auto& [name, value] : measures)
  {
    fields->AddArray(ArrayOf<vtkDoubleArray>(name, std::vector<double>{ value }, 1));
  }
}

} // namespace surfsynth
