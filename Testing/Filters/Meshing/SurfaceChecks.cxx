// SPDX-License-Identifier: BSD-3-Clause
#include "SurfaceChecks.h"

#include "SurfaceArrays.h"

#include "Core/Mesh/MeshTopology.h"

#include <vtkAlgorithm.h>
#include <vtkDataArray.h>
#include <vtkPointData.h>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace surfsynthtest
{

using surfsynth::TriangleMesh;

namespace
{
Eigen::Vector3d Corner(const TriangleMesh& mesh, Eigen::Index f, int k)
{
  return mesh.Points.row(mesh.Triangles(f, k % 3)).transpose();
}
} // namespace

surfsynth::MeshRequirements ValidSurface(bool closed)
{
  surfsynth::MeshRequirements requirements;
  requirements.ManifoldVertices = true;
  requirements.ConsistentWinding = true;
  requirements.Closed = closed;
  return requirements;
}

TriangleMesh MeshOf(vtkPolyData* surface) { return surfsynth::ConvertSurface(surface).Mesh; }

void ExpectValid(vtkPolyData* surface, bool closed)
{
  ASSERT_TRUE(surface);
  ASSERT_GT(surface->GetNumberOfCells(), 0);
  const auto findings = surfsynth::CheckMesh(MeshOf(surface), ValidSurface(closed));
  EXPECT_TRUE(findings.empty()) << surfsynth::DescribeFindings(findings);
}

std::int64_t EulerCharacteristic(vtkPolyData* surface)
{
  const TriangleMesh mesh = MeshOf(surface);
  const surfsynth::MeshTopology topology(mesh);
  return mesh.NumberOfPoints() - topology.NumberOfEdges() + mesh.NumberOfTriangles();
}

double VolumeOf(vtkPolyData* surface)
{
  const TriangleMesh mesh = MeshOf(surface);
  double volume = 0.0;
  for (Eigen::Index f = 0; f < mesh.Triangles.rows(); ++f)
  {
    volume += Corner(mesh, f, 0).dot(Corner(mesh, f, 1).cross(Corner(mesh, f, 2))) / 6.0;
  }
  return volume;
}

double AreaOf(vtkPolyData* surface)
{
  const TriangleMesh mesh = MeshOf(surface);
  double area = 0.0;
  for (Eigen::Index f = 0; f < mesh.Triangles.rows(); ++f)
  {
    area += 0.5 * (Corner(mesh, f, 1) - Corner(mesh, f, 0)).cross(Corner(mesh, f, 2) - Corner(mesh, f, 0)).norm();
  }
  return area;
}

Shapes ShapesOf(vtkPolyData* surface)
{
  const TriangleMesh mesh = MeshOf(surface);
  Shapes shapes;
  shapes.ShortestEdge = std::numeric_limits<double>::infinity();
  for (Eigen::Index f = 0; f < mesh.Triangles.rows(); ++f)
  {
    for (int k = 0; k < 3; ++k)
    {
      const Eigen::Vector3d a = Corner(mesh, f, k + 1) - Corner(mesh, f, k);
      const Eigen::Vector3d b = Corner(mesh, f, k + 2) - Corner(mesh, f, k);
      shapes.ShortestEdge = std::min(shapes.ShortestEdge, a.norm());
      shapes.LongestEdge = std::max(shapes.LongestEdge, a.norm());
      shapes.MeanEdge += a.norm() / static_cast<double>(mesh.Triangles.size());
      shapes.SmallestAngle = std::min(
        shapes.SmallestAngle, std::atan2(a.cross(b).norm(), a.dot(b)) * 180.0 / std::acos(-1.0));
    }
  }
  return shapes;
}

double LargestDistance(vtkPolyData* surface, vtkPolyData* reference)
{
  const TriangleMesh mesh = MeshOf(surface);
  const TriangleMesh target = MeshOf(reference);
  const auto places = surfsynth::NearestPlaces(target).Find(mesh.Points);
  double largest = 0.0;
  for (std::size_t p = 0; p < places.size(); ++p)
  {
    Eigen::Vector3d nearest = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k)
    {
      nearest += places[p].Weights[k] * Corner(target, places[p].Triangle, k);
    }
    largest = std::max(largest, (nearest.transpose() - mesh.Points.row(static_cast<Eigen::Index>(p))).norm());
  }
  return largest;
}

Soup Cube(int n)
{
  Soup cube;
  std::map<std::vector<int>, vtkIdType> ids;
  const auto point = [&](const std::vector<int>& at) {
    const auto found = ids.find(at);
    return found != ids.end() ? found->second
                              : ids[at] = cube.AddPoint(at[0] / double(n), at[1] / double(n), at[2] / double(n));
  };
  for (int axis = 0; axis < 3; ++axis)
  {
    for (const int side : { 0, n })
    {
      for (int i = 0; i < n; ++i)
      {
        for (int j = 0; j < n; ++j)
        {
          const auto at = [&](int u, int v) {
            std::vector<int> place(3);
            place[axis] = side;
            place[(axis + 1) % 3] = u;
            place[(axis + 2) % 3] = v;
            return point(place);
          };
          std::vector<vtkIdType> quad{ at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1) };
          if (side == 0)
          {
            std::reverse(quad.begin(), quad.end());
          }
          cube.Polys.push_back(quad);
        }
      }
    }
  }
  return cube;
}

std::vector<vtkIdType> PointsWhere(vtkPolyData* surface, const std::function<bool(const double*)>& predicate)
{
  std::vector<vtkIdType> found;
  for (vtkIdType p = 0; p < surface->GetNumberOfPoints(); ++p)
  {
    if (predicate(surface->GetPoint(p)))
    {
      found.push_back(p);
    }
  }
  return found;
}

vtkDataArray* AddPointArray(
  vtkPolyData* surface, const char* name, const std::function<double(const double*)>& value, int type)
{
  const auto array = vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(type));
  array->SetName(name);
  array->SetNumberOfTuples(surface->GetNumberOfPoints());
  for (vtkIdType p = 0; p < surface->GetNumberOfPoints(); ++p)
  {
    array->SetTuple1(p, value(surface->GetPoint(p)));
  }
  surface->GetPointData()->AddArray(array);
  return array;
}

vtkSmartPointer<vtkPolyData> OutputOf(vtkAlgorithm* filter, vtkDataObject* input)
{
  EventRecorder events(filter);
  filter->SetInputDataObject(input);
  const bool succeeded = Update(filter);
  EXPECT_TRUE(succeeded && events.Errors.empty()) << events.AllErrors();
  return succeeded ? vtkPolyData::SafeDownCast(filter->GetOutputDataObject(0)) : nullptr;
}

void ExpectRefusal(vtkAlgorithm* filter, vtkDataObject* input, const std::vector<std::string>& parts)
{
  EventRecorder events(filter);
  filter->SetInputDataObject(input);
  EXPECT_FALSE(Update(filter));
  ASSERT_EQ(events.Errors.size(), 1u) << events.AllErrors();
  for (const std::string& part : parts)
  {
    EXPECT_NE(events.Errors[0].find(part), std::string::npos) << '"' << part << "\" is not in: " << events.Errors[0];
  }
  EXPECT_EQ(filter->GetOutputDataObject(0)->GetNumberOfElements(vtkDataObject::POINT), 0);
}

} // namespace surfsynthtest
