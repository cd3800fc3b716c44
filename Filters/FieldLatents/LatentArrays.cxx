// SPDX-License-Identifier: BSD-3-Clause
#include "LatentArrays.h"

#include "NewArray.h"
#include "PointRows.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Mesh/UsedPoints.h"

#include <vtkFloatArray.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>

namespace surfsynth
{

namespace
{
/// Largest relative deviation of ratios of radii that are the same but for rounding of points.
constexpr double RadiusTolerance = 1e-3;
/// Least ratio, over 1 or below, that is a warning; smaller changes cannot be seen.
constexpr double MinimumScaling = 0.01;
/// Least length of the normal components of vectors that is a warning, relative to that of the vectors.
constexpr double MinimumNormalPart = 0.02;

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

/// Sums over the vertices that tell whether a surface is as it was encoded.
struct EncodedShape
{
  double Smallest = std::numeric_limits<double>::infinity(); ///< ratio of the radius of a ring to that of its latents
  double Largest = 0.0;
  double SquaredLength = 0.0;  ///< of vectors
  double SquaredTangent = 0.0; ///< of their tangential parts

  void AddRadii(double ring, double latent)
  {
    this->Smallest = std::min(this->Smallest, ring / latent);
    this->Largest = std::max(this->Largest, ring / latent);
  }

  /// Text of the warning; empty without one.
  std::string Warning(const std::string& name) const
  {
    const double ratio = 0.5 * (this->Smallest + this->Largest);
    if (!(this->Largest - this->Smallest <= RadiusTolerance * ratio))
    {
      return ""; // another triangulation
    }
    if (std::abs(std::log(ratio)) > MinimumScaling)
    {
      return "All one-rings have " + FormatNumber(ratio) + " times the radius of the point array \"" + name +
        "Radius\": the surface seems to have been scaled after vtkFieldLatentEncoder, which changes its texture. "
        "Multiply that array by this number, or encode the scaled surface.";
    }
    const double normal = std::sqrt(std::max(0.0, this->SquaredLength - this->SquaredTangent));
    if (normal > MinimumNormalPart * std::sqrt(this->SquaredLength))
    {
      return "The vectors \"" + VectorName(name, 0) +
        "\" and following do not lie in the tangent planes: the surface seems to have been turned or bent after "
        "vtkFieldLatentEncoder and its vectors not, which changes its texture. Turn all vectors too "
        "(vtkTransformPolyDataFilter with TransformAllInputVectors), or encode the turned surface.";
    }
    return "";
  }
};
} // namespace

bool IsLatentName(const std::string& name, const std::string& latentName)
{
  if (name.compare(0, latentName.size(), latentName) != 0)
  {
    return false;
  }
  const std::string rest = name.substr(latentName.size());
  const bool isVector = rest.size() > 1 && rest[0] == '_' &&
    std::all_of(rest.begin() + 1, rest.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
  return isVector || rest == "Deviation" || rest == "Radius";
}

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
  EncodedShape shape;
  for (std::int64_t j = 0; j < dimension; ++j)
  {
    const PointRows rows = ReadPointRows(polydata, used, { VectorName(name, j), Property }, 3);
    for (Index k = 0; k < used.Count(); ++k)
    {
      const Index v = used.Id(k);
      if (welded.IsVertex(v))
      {
        const double x = rows.row(k).dot(welded.Rings.Frames.X.row(v));
        const double y = rows.row(k).dot(welded.Rings.Frames.Y.row(v));
        field.Latents(v, 2 * j) = static_cast<float>(x);
        field.Latents(v, 2 * j + 1) = static_cast<float>(y);
        shape.SquaredLength += rows.row(k).squaredNorm();
        shape.SquaredTangent += x * x + y * y;
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
    if (welded.IsVertex(v))
    {
      field.Radii[static_cast<std::size_t>(v)] = radii(k, 0);
      shape.AddRadii(welded.Rings.RingRadius(v), radii(k, 0));
    }
  }
  field.Warning = shape.Warning(name);
  return field;
}

} // namespace surfsynth
