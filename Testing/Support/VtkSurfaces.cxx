// SPDX-License-Identifier: BSD-3-Clause
#include "VtkSurfaces.h"

#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

namespace surfsynthtest
{

vtkIdType Soup::AddPoint(double x, double y, double z)
{
  this->Points.insert(this->Points.end(), { x, y, z });
  return this->NumberOfPoints() - 1;
}

namespace
{
vtkSmartPointer<vtkCellArray> ToCellArray(const std::vector<std::vector<vtkIdType>>& cells)
{
  auto array = vtkSmartPointer<vtkCellArray>::New();
  for (const auto& cell : cells)
  {
    array->InsertNextCell(static_cast<vtkIdType>(cell.size()), cell.data());
  }
  return array;
}
} // namespace

vtkSmartPointer<vtkPolyData> Soup::ToPolyData(int pointType) const
{
  vtkNew<vtkPoints> points;
  points->SetDataType(pointType);
  points->SetNumberOfPoints(this->NumberOfPoints());
  for (vtkIdType p = 0; p < this->NumberOfPoints(); ++p)
  {
    points->SetPoint(p, this->Points.data() + 3 * p);
  }
  auto polyData = vtkSmartPointer<vtkPolyData>::New();
  polyData->SetPoints(points);
  polyData->SetVerts(ToCellArray(this->Verts));
  polyData->SetLines(ToCellArray(this->Lines));
  polyData->SetPolys(ToCellArray(this->Polys));
  polyData->SetStrips(ToCellArray(this->Strips));
  return polyData;
}

namespace
{
/// Adds the point of the unit sphere in that direction.
vtkIdType AddDirection(Soup& soup, double x, double y, double z)
{
  const double length = std::sqrt(x * x + y * y + z * z);
  return soup.AddPoint(x / length, y / length, z / length);
}

/// Adds the icosahedron's faces: the triples of points at the edge length 2 / |(1, golden, 0)|, wound outwards.
void AddIcosahedronFaces(Soup& soup)
{
  const auto x = [&soup](vtkIdType p) { return soup.Points.data() + 3 * p; };
  const auto near = [&](vtkIdType p, vtkIdType q) { return std::inner_product(x(p), x(p) + 3, x(q), 0.0) > 0.4; };
  for (vtkIdType p = 0; p < 12; ++p)
  {
    for (vtkIdType q = p + 1; q < 12; ++q)
    {
      for (vtkIdType r = q + 1; r < 12; ++r)
      {
        if (near(p, q) && near(q, r) && near(r, p))
        {
          const double* a = x(p);
          const double* b = x(q);
          const double* c = x(r);
          const double volume = a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
            a[2] * (b[0] * c[1] - b[1] * c[0]);
          soup.Polys.push_back(volume > 0.0 ? std::vector<vtkIdType>{ p, q, r } : std::vector<vtkIdType>{ p, r, q });
        }
      }
    }
  }
}

/// Cuts each triangle into four, with the new points on the unit sphere.
void SubdivideSphere(Soup& soup)
{
  std::map<std::pair<vtkIdType, vtkIdType>, vtkIdType> middles;
  const auto x = [&soup](vtkIdType p) { return soup.Points.data() + 3 * p; };
  const auto middle = [&](vtkIdType p, vtkIdType q) {
    const auto key = std::minmax(p, q);
    const auto found = middles.find(key);
    if (found != middles.end())
    {
      return found->second;
    }
    return middles[key] = AddDirection(soup, x(p)[0] + x(q)[0], x(p)[1] + x(q)[1], x(p)[2] + x(q)[2]);
  };
  std::vector<std::vector<vtkIdType>> finer;
  for (const auto& t : soup.Polys)
  {
    const vtkIdType m[3] = { middle(t[0], t[1]), middle(t[1], t[2]), middle(t[2], t[0]) };
    finer.insert(
      finer.end(), { { t[0], m[0], m[2] }, { t[1], m[1], m[0] }, { t[2], m[2], m[1] }, { m[0], m[1], m[2] } });
  }
  soup.Polys = std::move(finer);
}
} // namespace

Soup Icosphere(int levels)
{
  Soup soup;
  const double golden = 0.5 * (1.0 + std::sqrt(5.0));
  for (const double a : { -1.0, 1.0 })
  {
    for (const double b : { -golden, golden })
    {
      AddDirection(soup, a, b, 0.0);
      AddDirection(soup, 0.0, a, b);
      AddDirection(soup, b, 0.0, a);
    }
  }
  AddIcosahedronFaces(soup);
  for (int level = 0; level < levels; ++level)
  {
    SubdivideSphere(soup);
  }
  return soup;
}

Soup Grid(int n, int corners)
{
  Soup soup;
  for (int j = 0; j <= n; ++j)
  {
    for (int i = 0; i <= n; ++i)
    {
      soup.AddPoint(static_cast<double>(i) / n, static_cast<double>(j) / n, 0.0);
    }
  }
  for (int j = 0; j < n; ++j)
  {
    for (int i = 0; i < n; ++i)
    {
      const vtkIdType a = static_cast<vtkIdType>(j) * (n + 1) + i;
      const vtkIdType b = a + 1;
      const vtkIdType c = a + n + 2;
      const vtkIdType d = a + n + 1;
      if (corners == 4)
      {
        soup.Polys.push_back({ a, b, c, d });
      }
      else
      {
        soup.Polys.push_back({ a, b, c });
        soup.Polys.push_back({ a, c, d });
      }
    }
  }
  return soup;
}

vtkSmartPointer<vtkPolyData> RingSphere(int rings, int sectors)
{
  Soup soup;
  soup.AddPoint(0.0, 0.0, 1.0);
  const double pi = std::acos(-1.0);
  for (int r = 1; r < rings; ++r)
  {
    for (int s = 0; s < sectors; ++s)
    {
      const double theta = pi * r / rings;
      const double phi = 2.0 * pi * s / sectors;
      soup.AddPoint(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
    }
  }
  const vtkIdType south = soup.AddPoint(0.0, 0.0, -1.0);
  const auto id = [sectors](int r, int s) { return static_cast<vtkIdType>(1 + (r - 1) * sectors + s % sectors); };
  for (int s = 0; s < sectors; ++s)
  {
    soup.Polys.push_back({ 0, id(1, s), id(1, s + 1) });
    for (int r = 1; r + 1 < rings; ++r)
    {
      soup.Polys.push_back({ id(r, s), id(r + 1, s), id(r + 1, s + 1) });
      soup.Polys.push_back({ id(r, s), id(r + 1, s + 1), id(r, s + 1) });
    }
    soup.Polys.push_back({ id(rings - 1, s), south, id(rings - 1, s + 1) });
  }
  return soup.ToPolyData();
}

} // namespace surfsynthtest
