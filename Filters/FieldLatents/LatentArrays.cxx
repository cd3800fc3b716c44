// SPDX-License-Identifier: BSD-3-Clause
#include "LatentArrays.h"

#include "NewArray.h"
#include "PointRows.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/UsedPoints.h"

#include <vtkFloatArray.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>

#include <algorithm>
#include <cmath>

namespace surfsynth
{

namespace
{
std::string VectorName(const std::string& name, std::int64_t j) { return name + "_" + std::to_string(j); }

/// Largest natural logarithm of a deviation in an array: beyond, it is no longer finite in single precision.
constexpr float LargestLogarithm = 80.0F;

/// Property that names the arrays, in messages.
constexpr const char* Property = "LatentArrayName";

/// Returns the number of arrays <name>_0, <name>_1, ... without a gap.
std::int64_t CountLatents(vtkPolyData* polydata, const std::string& name)
{
  std::int64_t count = 0;
  while (polydata->GetPointData()->HasArray(VectorName(name, count).c_str()) != 0)
  {
    ++count;
  }
  return count;
}

void RequireLatents(vtkPolyData* polydata, const std::string& name, std::int64_t dimension)
{
  const std::int64_t count = CountLatents(polydata, name);
  if (count == dimension)
  {
    return;
  }
  const std::string needed = "; the model needs " + std::to_string(dimension) + ", \"" + VectorName(name, 0) +
    "\" to \"" + VectorName(name, dimension - 1) + "\". vtkFieldLatentEncoder with the same model makes them.";
  if (count == 0)
  {
    throw InvalidInput(
      "There is no point array \"" + VectorName(name, 0) + "\" of field latents (LatentArrayName)" + needed);
  }
  throw InvalidInput(
    "The surface has " + FormatCount(count, "point array") + " of field latents (LatentArrayName)" + needed);
}
} // namespace

void AddLatentArrays(
  const WeldedSurface& welded, const FieldLatentCodes& codes, const std::string& name, vtkPolyData* output)
{
  const auto points = static_cast<vtkIdType>(welded.VertexOfPoint.size());
  const Eigen::Index dimension = codes.LogDeviation.cols();
  const VertexFrames& frames = welded.Rings.Frames;
  const auto deviations = NewArray<vtkFloatArray>(name + "Deviation", points, static_cast<int>(dimension));
  const auto radii = NewArray<vtkFloatArray>(name + "Radius", points, 1);
  std::vector<vtkSmartPointer<vtkFloatArray>> vectors;
  for (Eigen::Index j = 0; j < dimension; ++j)
  {
    vectors.push_back(NewArray<vtkFloatArray>(VectorName(name, j), points, 3));
  }
  for (vtkIdType p = 0; p < points; ++p)
  {
    const Index v = welded.VertexOfPoint[static_cast<std::size_t>(p)];
    if (!welded.IsVertex(v))
    {
      continue;
    }
    radii->SetValue(p, static_cast<float>(welded.Rings.RingRadius(v)));
    for (Eigen::Index j = 0; j < dimension; ++j)
    {
      deviations->SetTypedComponent(
        p, static_cast<int>(j), std::exp(std::min(codes.LogDeviation(v, j), LargestLogarithm)));
      const Eigen::RowVector3d vector = double(codes.Mean(v, 2 * j)) * frames.X.row(v) +
        double(codes.Mean(v, 2 * j + 1)) * frames.Y.row(v);
      vectors[static_cast<std::size_t>(j)]->SetTypedTuple(p, Eigen::RowVector3f(vector.cast<float>()).data());
    }
  }
  vtkPointData* data = output->GetPointData();
  for (Eigen::Index j = dimension; data->HasArray(VectorName(name, j).c_str()); ++j)
  {
    data->RemoveArray(VectorName(name, j).c_str()); // of a model of more dimensions
  }
  for (const auto& array : vectors)
  {
    data->AddArray(array);
  }
  data->AddArray(deviations);
  data->AddArray(radii);
  if (!data->GetVectors())
  {
    data->SetActiveVectors(VectorName(name, 0).c_str());
  }
}

LatentField ReadLatentArrays(vtkPolyData* polydata, const Surface& surface, const WeldedSurface& welded,
  const std::string& name, std::int64_t dimension)
{
  RequireLatents(polydata, name, dimension);
  const UsedPoints used(surface.Mesh);
  const auto points = static_cast<Eigen::Index>(welded.VertexOfPoint.size());
  LatentField field;
  field.Latents = FieldLatentMatrix::Zero(points, 2 * dimension);
  field.Radii.assign(static_cast<std::size_t>(points), 0.0);
  for (std::int64_t j = 0; j < dimension; ++j)
  {
    const PointRows rows = ReadPointRows(polydata, used, { VectorName(name, j), Property }, 3);
    for (Index k = 0; k < used.Count(); ++k)
    {
      const Index v = used.Id(k);
      if (welded.IsVertex(v))
      {
        field.Latents(v, 2 * j) = static_cast<float>(rows.row(k).dot(welded.Rings.Frames.X.row(v)));
        field.Latents(v, 2 * j + 1) = static_cast<float>(rows.row(k).dot(welded.Rings.Frames.Y.row(v)));
      }
    }
  }
  const PointRows radii = ReadPointRows(polydata, used, { name + "Radius", Property }, 1);
  for (Index k = 0; k < used.Count(); ++k)
  {
    const Index v = used.Id(k);
    if (welded.IsVertex(v) && !(radii(k, 0) > 0.0))
    {
      throw InvalidInput("The point array \"" + name + "Radius\" is not larger than 0 at point " + std::to_string(v) +
        "; the radius of the ring to which a code belongs is needed, as vtkFieldLatentEncoder makes it.");
    }
    field.Radii[static_cast<std::size_t>(v)] = welded.IsVertex(v) ? radii(k, 0) : 0.0;
  }
  return field;
}

} // namespace surfsynth
