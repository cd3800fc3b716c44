// SPDX-License-Identifier: BSD-3-Clause
#include "ObservationReading.h"

#include "DistributedSurfaces.h"
#include "SurfaceArrays.h"
#include "SurfaceBridge.h"
#include "VolumeBridge.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"

#include <vtkAlgorithm.h>
#include <vtkDataArray.h>
#include <vtkDataObject.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkPointData.h>
#include <vtkPointSet.h>

#include <cmath>

namespace surfsynth
{

namespace
{
/// Default of the tolerance over the longest side of the box.
constexpr double DefaultTolerance = 0.01;
constexpr std::size_t MostNamed = 10;

/// The point arrays of @p data, for messages.
std::string ArraysOf(vtkPolyData* data)
{
  std::string names;
  for (int k = 0; k < data->GetPointData()->GetNumberOfArrays(); ++k)
  {
    const char* name = data->GetPointData()->GetArrayName(k);
    names += (names.empty() ? "\"" : ", \"") + std::string(name ? name : "") + "\"";
  }
  return names.empty() ? "there are none" : "there are " + names;
}

/// The active scalars; the active vectors where these have the number of components and the scalars have not.
vtkDataArray* ActiveArray(vtkPointData* arrays, int components)
{
  vtkDataArray* scalars = arrays->GetScalars();
  vtkDataArray* vectors = arrays->GetVectors();
  const bool isVector = components == 3 && vectors && (!scalars || scalars->GetNumberOfComponents() != components);
  return isVector ? vectors : scalars;
}

/// The array of @p property; "" for the active one.
vtkDataArray* FindArray(vtkPolyData* data, const std::string& name, const std::string& property, int components)
{
  vtkPointData* arrays = data->GetPointData();
  vtkDataArray* array = name.empty() ? ActiveArray(arrays, components) : arrays->GetArray(name.c_str());
  if (!array)
  {
    throw InvalidInput(name.empty()
        ? "The observations have no active scalars; " + property + " must name a point array (" + ArraysOf(data) + ")."
        : "The observations have no point array \"" + name + "\", which " + property + " names; " + ArraysOf(data) +
          ".");
  }
  if (array->GetNumberOfComponents() != components || array->GetNumberOfTuples() < data->GetNumberOfPoints())
  {
    throw InvalidInput("The array \"" + std::string(array->GetName() ? array->GetName() : "") + "\" of " + property +
      " has " + std::to_string(array->GetNumberOfTuples()) + " tuples of " +
      std::to_string(array->GetNumberOfComponents()) + " components; " + std::to_string(data->GetNumberOfPoints()) +
      " of " + std::to_string(components) + " are needed.");
  }
  return array;
}

std::string PlaceOf(const PointMatrix& points, Eigen::Index point)
{
  return "(" + FormatNumber(points(point, 0)) + ", " + FormatNumber(points(point, 1)) + ", " +
    FormatNumber(points(point, 2)) + ")";
}

double AllowedDistance(double tolerance, const BoundingBox& box)
{
  return tolerance > 0.0 ? tolerance : DefaultTolerance * box.LongestSide();
}

/// Throws InvalidInput that names the observations farther from their nearest places on @p what than @p allowed.
void RequireNear(const PointMatrix& points, const PointMatrix& nearest, double allowed, const std::string& what)
{
  std::string far;
  std::size_t count = 0;
  double first = 0.0;
  Eigen::Index firstPoint = 0;
  for (Eigen::Index i = 0; i < points.rows(); ++i)
  {
    const double distance = (nearest.row(i) - points.row(i)).norm();
    if (!(distance <= allowed))
    {
      first = count == 0 ? distance : first;
      firstPoint = count == 0 ? i : firstPoint;
      far += count < MostNamed ? (count == 0 ? "" : ", ") + std::to_string(i) : count == MostNamed ? ", ..." : "";
      ++count;
    }
  }
  if (count > 0)
  {
    throw InvalidInput(std::to_string(count) + (count == 1 ? " observation is" : " observations are") +
      " farther from the " + what + " than the Tolerance of " + FormatNumber(allowed) + ": " + far +
      ". The first, at " + PlaceOf(points, firstPoint) + ", is " + FormatNumber(first) + " away; points near the " +
      what + " are needed, or a larger Tolerance.");
  }
}
} // namespace

int AcceptObservations(vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkPointSet");
  info->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1);
  return 1;
}

vtkSmartPointer<vtkPolyData> ObservationsHere(vtkInformationVector* port)
{
  auto* given = port ? vtkPointSet::SafeDownCast(vtkDataObject::GetData(port)) : nullptr;
  if (!given)
  {
    return nullptr;
  }
  auto data = vtkSmartPointer<vtkPolyData>::New();
  if (given->GetNumberOfPoints() > 0)
  {
    data->SetPoints(given->GetPoints());
    data->GetPointData()->ShallowCopy(given->GetPointData());
  }
  return data;
}

vtkSmartPointer<vtkPolyData> ObservationsOn(vtkInformationVector* port)
{
  const Ranks ranks(Ranks::Several());
  auto data = ObservationsHere(port);
  if (ranks.Count() == 1)
  {
    return data;
  }
  const bool isHere = data != nullptr;
  if (!data)
  {
    data = vtkSmartPointer<vtkPolyData>::New();
  }
  int owner = -1;
  bool isConnected = false;
  const auto all = ranks.Gather({ isHere ? 1 : 0, data->GetNumberOfPoints() });
  for (int rank = 0; rank < ranks.Count(); ++rank)
  {
    const auto& of = all[static_cast<std::size_t>(rank)];
    isConnected = isConnected || of[0] != 0;
    if (of[1] > 0 && owner >= 0)
    {
      throw InvalidInput("The observations lie on several ranks; bring them together on one rank first "
                         "(vtkAggregateDataSetFilter).");
    }
    owner = of[1] > 0 ? rank : owner;
  }
  if (owner >= 0)
  {
    ranks.Broadcast(data, owner);
  }
  return isConnected ? data : nullptr;
}

Observations ReadObservations(vtkPolyData* data, const ObservationNames& names, int components)
{
  Observations read;
  const vtkIdType count = data->GetNumberOfPoints();
  read.Points = ConvertPoints(data);
  read.Values.resize(count, components);
  read.Deviations = Eigen::VectorXd::Zero(count);
  if (count == 0)
  {
    return read;
  }
  vtkDataArray* values = FindArray(data, names.Values, "ObservationArray", components);
  vtkDataArray* deviations = names.Deviations.empty()
    ? nullptr
    : FindArray(data, names.Deviations, "ObservationDeviationArray", 1);
  for (vtkIdType i = 0; i < count; ++i)
  {
    for (int c = 0; c < components; ++c)
    {
      read.Values(i, c) = values->GetComponent(i, c);
    }
    read.Deviations[i] = deviations ? deviations->GetComponent(i, 0) : 0.0;
    if (!read.Points.row(i).allFinite() || !read.Values.row(i).allFinite())
    {
      throw InvalidInput("Observation " + std::to_string(i) + " has a " +
        (read.Points.row(i).allFinite() ? "value" : "position") + " that is not finite; finite numbers are needed.");
    }
    if (!(read.Deviations[i] >= 0.0) || !std::isfinite(read.Deviations[i]))
    {
      throw InvalidInput("Observation " + std::to_string(i) + " has the standard deviation " +
        FormatNumber(read.Deviations[i]) + " in \"" + names.Deviations +
        "\"; finite numbers of at least 0 are needed.");
    }
  }
  return read;
}

Eigen::MatrixXd ReadFields(
  vtkPolyData* data, const std::string& name, const std::string& property, const std::vector<Index>& used)
{
  vtkPointData* arrays = data->GetPointData();
  std::vector<vtkDataArray*> fields;
  if (vtkDataArray* array = name.empty() ? arrays->GetScalars() : arrays->GetArray(name.c_str()))
  {
    fields.push_back(array);
  }
  for (int k = 0; fields.size() == static_cast<std::size_t>(k) && !name.empty(); ++k)
  {
    if (vtkDataArray* array = arrays->GetArray((name + "_" + std::to_string(k)).c_str()))
    {
      fields.push_back(array);
    }
  }
  Eigen::MatrixXd values(data->GetNumberOfPoints(), 0);
  for (vtkDataArray* array : fields)
  {
    const int components = array->GetNumberOfComponents();
    FindArray(data, array->GetName() ? array->GetName() : "", property, components);
    values.conservativeResize(Eigen::NoChange, values.cols() + components);
    for (vtkIdType i = 0; i < values.rows(); ++i)
    {
      for (int c = 0; c < components; ++c)
      {
        values(i, values.cols() - components + c) = array->GetComponent(i, c);
      }
    }
  }
  if (fields.empty())
  {
    FindArray(data, name, property, 1); // says what is there
  }
  for (const Index point : used)
  {
    if (!values.row(point).allFinite())
    {
      throw InvalidInput("Point " + std::to_string(point) + " has a value of " + property +
        " that is not finite; finite numbers are needed.");
    }
  }
  return values;
}

std::vector<SurfacePlace> AttachToSurface(const TriangleMesh& mesh, const PointMatrix& points, double tolerance)
{
  std::vector<SurfacePlace> places = FindNearestPlaces(mesh, points);
  PointMatrix nearest(points.rows(), 3);
  for (std::size_t i = 0; i < places.size(); ++i)
  {
    nearest.row(static_cast<Eigen::Index>(i)) = PositionOf(mesh, places[i]).transpose();
  }
  RequireNear(points, nearest, AllowedDistance(tolerance, ComputeBoundingBox(mesh)), "surface");
  return places;
}

std::vector<VolumePlace> AttachToVolume(const TetrahedralMesh& mesh, const PointMatrix& points, double tolerance)
{
  std::vector<VolumePlace> places = FindNearestPlaces(mesh, points);
  PointMatrix nearest(points.rows(), 3);
  for (std::size_t i = 0; i < places.size(); ++i)
  {
    nearest.row(static_cast<Eigen::Index>(i)) = PositionOf(mesh, places[i]).transpose();
  }
  RequireNear(points, nearest, AllowedDistance(tolerance, ComputeBoundingBox(mesh)), "volume");
  return places;
}

} // namespace surfsynth
