// SPDX-License-Identifier: BSD-3-Clause
#include "GeometricTextureMask.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Mesh/EdgeDistances.h"

#include <vtkDataArray.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>

#include <algorithm>
#include <vector>

namespace surfsynth
{

Eigen::VectorXf ReadGeometricTextureArray(
  vtkPolyData* surface, const UsedPoints& points, const std::string& name, const GeometricTextureArray& kind)
{
  if (name.empty())
  {
    return {};
  }
  vtkDataArray* array = surface->GetPointData()->GetArray(name.c_str());
  const vtkIdType tuples = surface->GetNumberOfPoints();
  if (!array || array->GetNumberOfComponents() != 1 || array->GetNumberOfTuples() != tuples)
  {
    throw InvalidInput(std::string("The ") + kind.Kind + " array \"" + name + "\" " +
      (array ? "has " + std::to_string(array->GetNumberOfTuples()) + " tuples of " +
            std::to_string(array->GetNumberOfComponents()) + " components"
             : "is missing") +
      "; a point array with one component for each of the " + std::to_string(tuples) + " points is needed, with " +
      kind.Values + ".");
  }
  Eigen::VectorXf values(points.Count());
  for (Index k = 0; k < points.Count(); ++k)
  {
    const double value = array->GetTuple1(points.Id(k));
    if (!(value >= kind.Minimum) || !(value <= kind.Maximum))
    {
      throw InvalidInput(std::string("The ") + kind.Kind + " array \"" + name + "\" is " + FormatNumber(value) +
        " at point " + std::to_string(points.Id(k)) + "; " + kind.Values + " are needed.");
    }
    values[k] = static_cast<float>(value);
  }
  return values;
}

Eigen::VectorXf ReadInterpolatedArray(
  vtkPolyData* surface, const UsedPoints& points, const std::string& name, const GeometricTextureArray& kind)
{
  Eigen::VectorXf values(name.empty() ? 0 : points.Count());
  for (Index k = 0; k < static_cast<Index>(values.size()); ++k)
  {
    const double value = surface->GetPointData()->GetArray(name.c_str())->GetTuple1(points.Id(k));
    values[k] = static_cast<float>(std::clamp(value, kind.Minimum, kind.Maximum));
  }
  return values;
}

bool SameValues(const Eigen::VectorXf& a, const Eigen::VectorXf& b)
{
  return a.size() == b.size() && (a.array() == b.array()).all();
}

void SoftenMask(const TriangleMesh& mesh, double falloff, Eigen::VectorXf& mask)
{
  std::vector<Index> bare;
  for (Index v = 0; v < static_cast<Index>(mask.size()); ++v)
  {
    if (mask[v] == 0.0F)
    {
      bare.push_back(v);
    }
  }
  if (bare.empty() || falloff <= 0.0)
  {
    return;
  }
  const Eigen::VectorXd distances = EdgeDistances(mesh, MeshTopology(mesh), bare);
  for (Eigen::Index v = 0; v < mask.size(); ++v)
  {
    const double t = std::min(1.0, distances[v] / falloff);
    mask[v] *= static_cast<float>(t * t * (3.0 - 2.0 * t));
  }
}

} // namespace surfsynth
