// SPDX-License-Identifier: BSD-3-Clause
#include "MalformedCorpus.h"

#include "FilterChecks.h"
#include "VtkSurfaces.h"

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkFloatArray.h>
#include <vtkIdTypeArray.h>
#include <vtkImageData.h>
#include <vtkIntArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkMultiPieceDataSet.h>
#include <vtkNew.h>
#include <vtkPartitionedDataSet.h>
#include <vtkPartitionedDataSetCollection.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSOADataArrayTemplate.h>
#include <vtkStringArray.h>
#include <vtkTable.h>
#include <vtkTypeInt32Array.h>
#include <vtkTypeInt64Array.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkVariantArray.h>

#include <cmath>
#include <limits>

// The functions below each append one family of cases. They are long because they are lists.

namespace surfsynthtest
{

namespace
{
using Cases = std::vector<MalformedCase>;
using Data = vtkSmartPointer<vtkDataObject>;

constexpr double NaN = std::numeric_limits<double>::quiet_NaN();
constexpr double Infinity = std::numeric_limits<double>::infinity();

void Add(Cases& cases, const std::string& name, Expectation expected, std::function<Data()> make)
{
  cases.push_back({ name, expected, std::move(make) });
}

/// A case that is made by changing points and cells of @p base.
void Edit(Cases& cases, const std::string& name, Expectation expected, const Soup& base,
  const std::function<void(Soup&)>& edit, int pointType = VTK_DOUBLE)
{
  Add(cases, name, expected, [base, edit, pointType]() -> Data {
    Soup soup = base;
    edit(soup);
    return soup.ToPolyData(pointType);
  });
}

/// A case that is made by changing the polydata of @p base.
void Change(Cases& cases, const std::string& name, Expectation expected, const Soup& base,
  const std::function<void(vtkPolyData*)>& change)
{
  Add(cases, name, expected, [base, change]() -> Data {
    const auto polyData = base.ToPolyData();
    change(polyData);
    return polyData;
  });
}

/// A case of scaled and shifted points.
void Transform(
  Cases& cases, const std::string& name, Expectation expected, double scale, double offset, int pointType = VTK_DOUBLE)
{
  Edit(
    cases, name, expected, Icosphere(2),
    [scale, offset](Soup& soup) {
      for (double& x : soup.Points)
      {
        x = scale * x + offset;
      }
    },
    pointType);
}

/// @p other behind @p soup.
void Append(Soup& soup, Soup other, double dx)
{
  const vtkIdType first = soup.NumberOfPoints();
  for (std::size_t k = 0; k < other.Points.size(); k += 3)
  {
    soup.AddPoint(other.Points[k] + dx, other.Points[k + 1], other.Points[k + 2]);
  }
  for (auto& cell : other.Polys)
  {
    for (vtkIdType& id : cell)
    {
      id += first;
    }
    soup.Polys.push_back(cell);
  }
}

Soup Triangles(std::vector<double> points, std::vector<std::vector<vtkIdType>> polys)
{
  Soup soup;
  soup.Points = std::move(points);
  soup.Polys = std::move(polys);
  return soup;
}

Soup Tetrahedron()
{
  return Triangles({ 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1 }, { { 0, 2, 1 }, { 0, 1, 3 }, { 1, 2, 3 }, { 2, 0, 3 } });
}

/// One polygon in the plane.
Soup Polygon(const std::vector<double>& xy)
{
  Soup soup;
  soup.Polys.emplace_back();
  for (std::size_t k = 0; k < xy.size(); k += 2)
  {
    soup.Polys[0].push_back(soup.AddPoint(xy[k], xy[k + 1], 0.0));
  }
  return soup;
}

Soup RegularPolygon(int corners, double winding = 1.0, double height = 0.0)
{
  Soup soup;
  soup.Polys.emplace_back();
  for (int k = 0; k < corners; ++k)
  {
    const double angle = 2.0 * std::acos(-1.0) * winding * k / corners;
    soup.Polys[0].push_back(soup.AddPoint(std::cos(angle), std::sin(angle), height * (k % 2)));
  }
  return soup;
}

/// A band of n quads whose end is glued to its start, after a half turn when @p twisted.
Soup Band(int n, bool twisted)
{
  Soup soup;
  for (int k = 0; k < n; ++k)
  {
    const double angle = 2.0 * std::acos(-1.0) * k / n;
    const double turn = twisted ? 0.5 * angle : 0.5 * std::acos(-1.0);
    for (const double side : { -0.3, 0.3 })
    {
      const double radius = 1.0 + side * std::cos(turn);
      soup.AddPoint(radius * std::cos(angle), radius * std::sin(angle), side * std::sin(turn));
    }
  }
  for (int k = 0; k < n; ++k)
  {
    const vtkIdType a = 2 * k;
    const bool last = k + 1 == n;
    const vtkIdType c = last ? (twisted ? 1 : 0) : a + 2;
    const vtkIdType d = last ? (twisted ? 0 : 1) : a + 3;
    soup.Polys.push_back({ a, c, d });
    soup.Polys.push_back({ a, d, a + 1 });
  }
  return soup;
}

/// Triangles on the x axis between points 0 and 1.
Soup Fan(int triangles)
{
  Soup soup;
  soup.AddPoint(0, 0, 0);
  soup.AddPoint(1, 0, 0);
  for (int k = 0; k < triangles; ++k)
  {
    const double angle = 2.0 * std::acos(-1.0) * k / triangles;
    soup.Polys.push_back({ 0, 1, soup.AddPoint(0.5, std::cos(angle), std::sin(angle)) });
  }
  return soup;
}

/// A zigzag strip of @p points points.
Soup Strip(int points)
{
  Soup soup;
  soup.Strips.emplace_back();
  for (int k = 0; k < points; ++k)
  {
    soup.Strips[0].push_back(soup.AddPoint(0.5 * k, k % 2, 0.0));
  }
  return soup;
}

void AddEmptyCases(Cases& cases)
{
  Add(cases, "NoPointsNoCells", Expectation::Empty, []() -> Data { return vtkSmartPointer<vtkPolyData>::New(); });
  Change(cases, "PointsObjectWithoutPoints", Expectation::Empty, Soup(), [](vtkPolyData*) {});
  Change(cases, "EmptyWithFieldData", Expectation::Empty, Soup(), [](vtkPolyData* data) {
    vtkNew<vtkDoubleArray> array;
    array->SetName("Time");
    array->InsertNextValue(1.0);
    data->GetFieldData()->AddArray(array);
  });
  Change(cases, "EmptyWithArraysOfNoTuples", Expectation::Empty, Soup(), [](vtkPolyData* data) {
    vtkNew<vtkDoubleArray> array;
    array->SetName("Pressure");
    data->GetPointData()->SetScalars(array);
  });
  Edit(cases, "PointsOnly", Expectation::Error, Icosphere(1), [](Soup& soup) { soup.Polys.clear(); });
  Edit(cases, "OnePointOnly", Expectation::Error, Soup(), [](Soup& soup) { soup.AddPoint(1, 2, 3); });
  Edit(cases, "VerticesOnly", Expectation::Error, Icosphere(1), [](Soup& soup) {
    soup.Polys.clear();
    soup.Verts = { { 0 }, { 1, 2, 3 } };
  });
  Edit(cases, "LinesOnly", Expectation::Error, Icosphere(1), [](Soup& soup) {
    soup.Polys.clear();
    soup.Lines = { { 0, 1, 2 }, { 3, 4 } };
  });
}

// One flat list: each case is read on its own, and a split would only hide one.
void AddTopologyCases(Cases& cases)
{
  const auto unchanged = [](Soup&) {};
  const Soup sphere = Icosphere(2);
  Edit(cases, "SingleTriangle", Expectation::Valid, Polygon({ 0, 0, 1, 0, 0, 1 }), unchanged);
  Edit(cases, "NonManifoldEdgeOfThree", Expectation::Error, Fan(3), unchanged);
  Edit(cases, "NonManifoldEdgeOfThreeHundred", Expectation::Error, Fan(300), unchanged);
  Edit(cases, "NonManifoldVertexOfTwoTriangles", Expectation::Valid,
    Triangles({ 0, 0, 0, 1, 0, 0, 0, 1, 0, -1, 0, 0, 0, -1, 0 }, { { 0, 1, 2 }, { 0, 3, 4 } }), unchanged);
  Edit(cases, "NonManifoldVertexOfTwoTetrahedra", Expectation::Valid, Tetrahedron(), [](Soup& soup) {
    Append(soup, Tetrahedron(), 1.0);
    for (auto& cell : soup.Polys)
    {
      for (vtkIdType& id : cell)
      {
        id = id == 4 ? 1 : id; // the two meet at (1, 0, 0)
      }
    }
  });
  Edit(cases, "MoebiusStrip", Expectation::Valid, Band(24, true), unchanged);
  Edit(cases, "Annulus", Expectation::Valid, Band(24, false), unchanged);
  Edit(cases, "InconsistentWinding", Expectation::Valid, sphere, [](Soup& soup) {
    for (std::size_t f = 0; f < soup.Polys.size(); f += 3)
    {
      std::swap(soup.Polys[f][0], soup.Polys[f][1]);
    }
  });
  Edit(cases, "WoundInwards", Expectation::Valid, sphere, [](Soup& soup) {
    for (auto& cell : soup.Polys)
    {
      std::swap(cell[0], cell[1]);
    }
  });
  Edit(cases, "DuplicateFace", Expectation::Error, sphere, [](Soup& soup) { soup.Polys.push_back(soup.Polys[7]); });
  Edit(cases, "OppositeFace", Expectation::Error, sphere, [](Soup& soup) {
    const auto t = soup.Polys[7];
    soup.Polys.push_back({ t[0], t[2], t[1] });
  });
  Edit(cases, "EveryFaceTwice", Expectation::Error, sphere, [](Soup& soup) {
    const auto faces = soup.Polys;
    soup.Polys.insert(soup.Polys.end(), faces.begin(), faces.end());
  });
  Edit(cases, "OneTriangleTwice", Expectation::Either,
    Triangles({ 0, 0, 0, 1, 0, 0, 0, 1, 0 }, { { 0, 1, 2 }, { 0, 1, 2 } }), unchanged);
  Edit(cases, "PillowOfTwoTriangles", Expectation::Valid,
    Triangles({ 0, 0, 0, 1, 0, 0, 0, 1, 0 }, { { 0, 1, 2 }, { 0, 2, 1 } }), unchanged);
  Edit(cases, "ThousandTriangles", Expectation::Valid, Soup(), [](Soup& soup) {
    for (int k = 0; k < 1000; ++k)
    {
      Append(soup, Triangles({ 0, 0, 0, 1, 0, 0, 0, 1, 0 }, { { 0, 1, 2 } }), 2.0 * k);
    }
  });
  Edit(cases, "ThousandTetrahedra", Expectation::Valid, Soup(), [](Soup& soup) {
    for (int k = 0; k < 1000; ++k)
    {
      Append(soup, Tetrahedron(), 2.0 * k);
    }
  });
  Edit(cases, "OpenBoundary", Expectation::Valid, Grid(8), unchanged);
  Edit(cases, "ManyHoles", Expectation::Valid, Icosphere(3), [](Soup& soup) {
    std::vector<std::vector<vtkIdType>> kept;
    for (std::size_t f = 0; f < soup.Polys.size(); ++f)
    {
      if (f % 7 != 0)
      {
        kept.push_back(soup.Polys[f]);
      }
    }
    soup.Polys = kept;
  });
  Edit(cases, "SelfIntersection", Expectation::Valid, sphere, [](Soup& soup) { Append(soup, Icosphere(2), 0.5); });
  Edit(cases, "TwoSpheresInOnePlace", Expectation::Valid, sphere, [](Soup& soup) { Append(soup, Icosphere(2), 0.0); });
  Edit(cases, "TriangleSoup", Expectation::Valid, Soup(), [sphere](Soup& soup) {
    for (const auto& cell : sphere.Polys)
    {
      soup.Polys.emplace_back();
      for (const vtkIdType id : cell)
      {
        const double* x = sphere.Points.data() + 3 * id;
        soup.Polys.back().push_back(soup.AddPoint(x[0], x[1], x[2]));
      }
    }
  });
  Edit(cases, "UnreferencedPointsBehind", Expectation::Valid, sphere, [](Soup& soup) {
    for (int k = 0; k < 1000; ++k)
    {
      soup.AddPoint(k, 0, 0);
    }
  });
  Edit(cases, "UnreferencedPointsInFront", Expectation::Valid, Soup(), [](Soup& soup) {
    for (int k = 0; k < 1000; ++k)
    {
      soup.AddPoint(k, 0, 0);
    }
    Append(soup, Icosphere(2), 0.0);
  });
  Edit(
    cases, "UnreferencedPointWithNaN", Expectation::Valid, sphere, [](Soup& soup) { soup.AddPoint(NaN, Infinity, 0); });
}

// One flat list: each case is read on its own, and a split would only hide one.
void AddCellCases(Cases& cases)
{
  const auto unchanged = [](Soup&) {};
  const Soup sphere = Icosphere(2);
  const auto withPolygon = [&](const std::string& name, Expectation expected, const std::vector<vtkIdType>& polygon) {
    Edit(cases, name, expected, sphere, [polygon](Soup& soup) { soup.Polys.push_back(polygon); });
  };
  withPolygon("RepeatedVertexInTriangle", Expectation::Error, { 0, 0, 1 });
  withPolygon("RepeatedVertexThreeTimes", Expectation::Error, { 5, 5, 5 });
  withPolygon("RepeatedVertexInQuad", Expectation::Error, { 0, 1, 1, 2 });
  withPolygon("RepeatedVertexInPolygon", Expectation::Error, { 0, 1, 2, 3, 4, 0 });
  withPolygon("OnePointCell", Expectation::Error, { 3 });
  withPolygon("TwoPointCell", Expectation::Error, { 3, 4 });
  withPolygon("NoPointCell", Expectation::Error, {});
  withPolygon("IdFarOutOfRange", Expectation::Error, { 0, 1, 1000000000 });
  withPolygon("IdOneOutOfRange", Expectation::Error, { 0, 1, sphere.NumberOfPoints() });
  withPolygon("IdNegative", Expectation::Error, { 0, -1, 2 });
  withPolygon("IdThatWrapsToZero", Expectation::Error, { vtkIdType(1) << 32, 1, 2 });
  withPolygon("IdLargest", Expectation::Error, { std::numeric_limits<vtkIdType>::max(), 1, 2 });
  withPolygon("IdSmallest", Expectation::Error, { std::numeric_limits<vtkIdType>::min(), 1, 2 });
  withPolygon("IdOutOfRangeInQuad", Expectation::Error, { 0, 1, 2, 5000 });
  withPolygon("IdOutOfRangeInPolygon", Expectation::Error, { 0, 1, 2, 3, 4, -7 });
  Edit(cases, "IdOutOfRangeInStrip", Expectation::Error, Strip(8), [](Soup& soup) { soup.Strips[0][7] = 5000; });
  Edit(cases, "IdNegativeInStrip", Expectation::Error, Strip(8), [](Soup& soup) { soup.Strips[0][0] = -2; });
  Edit(cases, "IdOutOfRangeInLine", Expectation::Valid, sphere, [](Soup& soup) { soup.Lines = { { 0, 99999 } }; });
  Edit(cases, "IdOutOfRangeInVertex", Expectation::Valid, sphere, [](Soup& soup) { soup.Verts = { { -5 } }; });
  Edit(cases, "Quads", Expectation::Valid, Grid(8, 4), unchanged);
  Edit(cases, "SingleQuad", Expectation::Valid, Polygon({ 0, 0, 1, 0, 1, 1, 0, 1 }), unchanged);
  Edit(cases, "ConcaveQuad", Expectation::Valid, Polygon({ 0, 0, 1, 0.3, 2, 0, 1, 2 }), unchanged);
  Edit(cases, "QuadWithStraightCorner", Expectation::Valid, Polygon({ 0, 0, 1, 0, 2, 0, 1, 2 }), unchanged);
  Edit(cases, "QuadThatCrossesItself", Expectation::Error, Polygon({ 0, 0, 1, 1, 1, 0, 0, 1 }), unchanged);
  Edit(cases, "QuadWithoutArea", Expectation::Error, Polygon({ 0, 0, 1, 0, 2, 0, 3, 0 }), unchanged);
  Edit(cases, "QuadNotPlanar", Expectation::Valid, RegularPolygon(4, 1.0, 0.3), unchanged);
  Edit(cases, "QuadWithNaN", Expectation::Error, Polygon({ 0, 0, 1, 0, NaN, 1, 0, 1 }), unchanged);
  Edit(cases, "Hexagon", Expectation::Valid, RegularPolygon(6), unchanged);
  Edit(cases, "HexagonNotPlanar", Expectation::Either, RegularPolygon(6, 1.0, 0.5), unchanged);
  Edit(cases, "Pentagram", Expectation::Either, RegularPolygon(5, 2.0), unchanged);
  Edit(cases, "PolygonOfTwoThousand", Expectation::Valid, RegularPolygon(2000), unchanged);
  Edit(cases, "ConcavePolygon", Expectation::Valid, Polygon({ 0, 0, 4, 0, 4, 3, 3, 3, 3, 1, 1, 1, 1, 3, 0, 3 }),
    unchanged);
  Edit(cases, "PolygonWithStraightCorner", Expectation::Either, Polygon({ 0, 0, 1, 0, 2, 0, 2, 1, 0, 1 }), unchanged);
  Edit(cases, "PolygonWithoutArea", Expectation::Error, Polygon({ 0, 0, 1, 0, 2, 0, 3, 0, 4, 0, 5, 0 }), unchanged);
  Edit(cases, "PolygonInOnePlace", Expectation::Error, Polygon({ 1, 1, 1, 1, 1, 1, 1, 1, 1, 1 }), unchanged);
  Edit(cases, "PolygonWithInfinity", Expectation::Error, Polygon({ 0, 0, 1, 0, 2, 1, Infinity, 2, 0, 1 }), unchanged);
  Edit(cases, "PolygonTiny", Expectation::Valid, RegularPolygon(7), [](Soup& soup) {
    for (double& x : soup.Points)
    {
      x *= 1e-9;
    }
  });
  Edit(cases, "TriangleStrip", Expectation::Valid, Strip(20), unchanged);
  Edit(cases, "StripOfTwoPoints", Expectation::Error, Strip(2), unchanged);
  Edit(cases, "StripOfOnePlace", Expectation::Error, Strip(3), [](Soup& soup) { soup.Strips = { { 0, 0, 0, 0, 0 } }; });
  Edit(cases, "StripWithJoins", Expectation::Valid, Strip(8), [](Soup& soup) {
    soup.Strips = { { 0, 1, 2, 3, 3, 4, 4, 5, 6, 7 } };
  });
  Edit(cases, "StripOverPolygon", Expectation::Error, Strip(5), [](Soup& soup) {
    soup.Polys = { { 0, 1, 2 }, { 0, 2, 1 } };
  });
  Edit(cases, "TrianglesQuadsPolygonsStripsLinesVertices", Expectation::Valid, Grid(4), [](Soup& soup) {
    Append(soup, Grid(4, 4), 2.0);
    Append(soup, RegularPolygon(8), 5.0);
    const vtkIdType first = soup.NumberOfPoints();
    const Soup strip = Strip(7);
    for (std::size_t k = 0; k < strip.Points.size(); k += 3)
    {
      soup.AddPoint(strip.Points[k] + 8.0, strip.Points[k + 1], 0.0);
    }
    soup.Strips = { { first, first + 1, first + 2, first + 3, first + 4, first + 5, first + 6 } };
    soup.Lines = { { 0, 1 }, { 2, 3, 4 } };
    soup.Verts = { { 0 } };
  });
}

template <typename Array>
void SetPolys(vtkPolyData* data, const std::vector<vtkIdType>& offsets, const std::vector<vtkIdType>& ids)
{
  vtkNew<Array> offsetArray;
  vtkNew<Array> idArray;
  for (const vtkIdType offset : offsets)
  {
    offsetArray->InsertNextValue(static_cast<typename Array::ValueType>(offset));
  }
  for (const vtkIdType id : ids)
  {
    idArray->InsertNextValue(static_cast<typename Array::ValueType>(id));
  }
  vtkNew<vtkCellArray> polys;
  polys->SetData(offsetArray.Get(), idArray.Get());
  data->SetPolys(polys);
}

void AddStorageCases(Cases& cases)
{
  const Soup tetrahedron = Tetrahedron();
  const std::vector<vtkIdType> ids = { 0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3 };
  const auto stored = [&](const std::string& name, Expectation expected, const std::vector<vtkIdType>& offsets,
                        const std::vector<vtkIdType>& connectivity) {
    Change(cases, name + "In64Bits", expected, tetrahedron,
      [=](vtkPolyData* data) { SetPolys<vtkTypeInt64Array>(data, offsets, connectivity); });
    Change(cases, name + "In32Bits", expected, tetrahedron,
      [=](vtkPolyData* data) { SetPolys<vtkTypeInt32Array>(data, offsets, connectivity); });
  };
  stored("ValidCells", Expectation::Valid, { 0, 3, 6, 9, 12 }, ids);
  stored("OffsetsNotAscending", Expectation::Error, { 0, 6, 3, 9, 12 }, ids);
  stored("OffsetsBeyondConnectivity", Expectation::Error, { 0, 3, 6, 9, 1200 }, ids);
  stored("OffsetsNegative", Expectation::Error, { -3, 0, 3, 6, 9 }, ids);
  stored("OffsetsWithoutConnectivity", Expectation::Error, { 0, 3, 6 }, {});
  stored("OffsetsFromThree", Expectation::Either, { 3, 6, 9, 12 }, ids);
  stored("NoOffsets", Expectation::Error, {}, ids);
  stored("IdOutOfRange", Expectation::Error, { 0, 3, 6, 9, 12 }, { 0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, -1 });
  Change(cases, "NoPointsObjectButCells", Expectation::Error, tetrahedron,
    [](vtkPolyData* data) { data->SetPoints(nullptr); });
  Change(cases, "NoPointsButCells", Expectation::Error, tetrahedron, [](vtkPolyData* data) {
    vtkNew<vtkPoints> none;
    data->SetPoints(none);
  });
  Change(cases, "FewerPointsThanCellsName", Expectation::Error, tetrahedron,
    [](vtkPolyData* data) { data->GetPoints()->SetNumberOfPoints(3); });
  Change(cases, "PointsOfTwoComponents", Expectation::Error, tetrahedron,
    [](vtkPolyData* data) { data->GetPoints()->GetData()->SetNumberOfComponents(2); });
}

// One flat list: each case is read on its own, and a split would only hide one.
void AddGeometryCases(Cases& cases)
{
  const Soup sphere = Icosphere(2);
  const auto movePoint = [&](const std::string& name, Expectation expected, double x, double y, double z, int type) {
    Edit(
      cases, name, expected, sphere,
      [=](Soup& soup) {
        soup.Points[60] = x;
        soup.Points[61] = y;
        soup.Points[62] = z;
      },
      type);
  };
  movePoint("NaNPoint", Expectation::Error, NaN, NaN, NaN, VTK_DOUBLE);
  movePoint("NaNCoordinate", Expectation::Error, 0.1, NaN, 0.2, VTK_DOUBLE);
  movePoint("NaNCoordinateFloat", Expectation::Error, 0.1, 0.2, NaN, VTK_FLOAT);
  movePoint("InfinitePoint", Expectation::Error, Infinity, 0, 0, VTK_DOUBLE);
  movePoint("NegativeInfinitePointFloat", Expectation::Error, 0, 0, -Infinity, VTK_FLOAT);
  movePoint("LargestDouble", Expectation::Either, 1.7e308, -1.7e308, 0, VTK_DOUBLE);
  movePoint("FarPoint", Expectation::Either, 1e9, 0, 0, VTK_DOUBLE);
  Edit(cases, "EveryPointNaN", Expectation::Error, sphere,
    [](Soup& soup) { soup.Points.assign(soup.Points.size(), NaN); });
  Edit(cases, "EveryPointInOnePlace", Expectation::Error, sphere,
    [](Soup& soup) { soup.Points.assign(soup.Points.size(), 1.0); });
  Edit(cases, "EveryPointOnALine", Expectation::Error, sphere, [](Soup& soup) {
    for (std::size_t k = 0; k < soup.Points.size(); k += 3)
    {
      soup.Points[k + 1] = soup.Points[k + 2] = 0.0;
    }
  });
  Edit(cases, "TriangleWithoutArea", Expectation::Error, sphere, [](Soup& soup) {
    const vtkIdType a = soup.AddPoint(3, 0, 0);
    const vtkIdType b = soup.AddPoint(4, 0, 0);
    soup.Polys.push_back({ a, b, soup.AddPoint(5, 0, 0) });
  });
  Edit(cases, "TwoPointsInOnePlace", Expectation::Error, sphere, [](Soup& soup) {
    const vtkIdType a = soup.Polys[0][0];
    const vtkIdType b = soup.Polys[0][1];
    std::copy_n(soup.Points.begin() + 3 * a, 3, soup.Points.begin() + 3 * b);
  });
  const auto needle = [&](const std::string& name, Expectation expected, double width) {
    Edit(cases, name, expected, Grid(6), [width](Soup& soup) {
      for (std::size_t k = 1; k < soup.Points.size(); k += 3)
      {
        soup.Points[k] *= width;
      }
    });
  };
  needle("Needles1e3", Expectation::Valid, 1e-3);
  needle("Needles1e6", Expectation::Either, 1e-6);
  needle("Needles1e9", Expectation::Either, 1e-9);
  needle("Needles1e14", Expectation::Error, 1e-14);
  Edit(cases, "ObtuseTriangles", Expectation::Valid, Grid(6), [](Soup& soup) {
    for (std::size_t k = 0; k < soup.Points.size(); k += 3)
    {
      soup.Points[k] += 3.0 * soup.Points[k + 1];
    }
  });
  Transform(cases, "Scale1e12", Expectation::Valid, 1e12, 0.0);
  Transform(cases, "ScaleMinus1e12", Expectation::Valid, 1e-12, 0.0);
  Transform(cases, "ScaleMinus1e12Float", Expectation::Valid, 1e-12, 0.0, VTK_FLOAT);
  Transform(cases, "Scale1e100", Expectation::Either, 1e100, 0.0);
  Transform(cases, "ScaleMinus1e100", Expectation::Either, 1e-100, 0.0);
  Transform(cases, "Scale1e150", Expectation::Either, 1e150, 0.0);
  Transform(cases, "ScaleMinus1e150", Expectation::Either, 1e-150, 0.0);
  Transform(cases, "Scale1e300", Expectation::Either, 1e300, 0.0);
  Transform(cases, "ScaleOfDenormalNumbers", Expectation::Either, 1e-310, 0.0);
  Transform(cases, "Mirrored", Expectation::Valid, -1.0, 0.0);
  Transform(cases, "Offset1e6", Expectation::Valid, 1.0, 1e6);
  Transform(cases, "Offset1e9", Expectation::Valid, 1.0, 1e9);
  Transform(cases, "Offset1e9Float", Expectation::Error, 1.0, 1e9, VTK_FLOAT);
  Transform(cases, "Offset1e15", Expectation::Either, 1.0, 1e15);
  Edit(cases, "MixedScales", Expectation::Either, sphere, [](Soup& soup) {
    Soup tiny = Tetrahedron();
    for (double& x : tiny.Points)
    {
      x *= 1e-8;
    }
    Append(soup, tiny, 5.0);
    Soup huge = Tetrahedron();
    for (double& x : huge.Points)
    {
      x *= 1e8;
    }
    Append(soup, huge, 10.0);
  });
  Edit(cases, "PlaneOfConstantX", Expectation::Valid, Grid(6), [](Soup& soup) {
    for (std::size_t k = 0; k < soup.Points.size(); k += 3)
    {
      std::swap(soup.Points[k], soup.Points[k + 2]);
    }
  });
  Edit(
    cases, "IntegerPoints", Expectation::Valid, Grid(6),
    [](Soup& soup) {
      for (double& x : soup.Points)
      {
        x = std::round(6.0 * x);
      }
    },
    VTK_INT);
  Transform(cases, "FloatPoints", Expectation::Valid, 1.0, 0.0, VTK_FLOAT);
  Change(cases, "PointsInStructureOfArrays", Expectation::Valid, sphere, [](vtkPolyData* data) {
    vtkNew<vtkSOADataArrayTemplate<double>> array;
    array->DeepCopy(data->GetPoints()->GetData());
    data->GetPoints()->SetData(array);
  });
}

void AddDataCases(Cases& cases)
{
  const Soup sphere = Icosphere(2);
  const auto withPointArray = [&](const std::string& name, vtkIdType tuples, int components, double value) {
    Change(cases, name, Expectation::Valid, sphere, [=](vtkPolyData* data) {
      vtkNew<vtkDoubleArray> array;
      array->SetName("Pressure");
      array->SetNumberOfComponents(components);
      array->SetNumberOfTuples(tuples);
      array->Fill(value);
      data->GetPointData()->AddArray(array);
      data->GetPointData()->SetActiveScalars("Pressure");
    });
  };
  withPointArray("PointArrayTooShort", 5, 1, 1.0);
  withPointArray("PointArrayTooLong", 5000, 1, 1.0);
  withPointArray("PointArrayOfNoTuples", 0, 1, 1.0);
  withPointArray("PointArrayOfNaN", sphere.NumberOfPoints(), 1, NaN);
  withPointArray("PointArrayOfElevenComponents", sphere.NumberOfPoints(), 11, 2.0);
  Change(cases, "CellArrayTooShort", Expectation::Valid, sphere, [](vtkPolyData* data) {
    vtkNew<vtkIntArray> array;
    array->SetName("Material");
    array->InsertNextValue(1);
    data->GetCellData()->SetScalars(array);
  });
  Change(cases, "ArraysWithoutName", Expectation::Valid, sphere, [](vtkPolyData* data) {
    for (int k = 0; k < 2; ++k)
    {
      vtkNew<vtkFloatArray> array;
      array->SetNumberOfTuples(data->GetNumberOfPoints());
      array->Fill(0.0);
      data->GetPointData()->AddArray(array);
    }
  });
  Change(cases, "StringsAndVariants", Expectation::Valid, sphere, [](vtkPolyData* data) {
    vtkNew<vtkStringArray> strings;
    strings->SetName("Label");
    strings->SetNumberOfValues(data->GetNumberOfPoints());
    data->GetPointData()->AddArray(strings);
    vtkNew<vtkVariantArray> variants;
    variants->SetName("Anything");
    variants->SetNumberOfValues(data->GetNumberOfPoints());
    data->GetPointData()->AddArray(variants);
  });
  const auto withGhosts = [&](const std::string& name, bool points, unsigned char value) {
    Change(cases, name, Expectation::Valid, sphere, [=](vtkPolyData* data) {
      vtkNew<vtkUnsignedCharArray> ghosts;
      ghosts->SetName(vtkDataSetAttributes::GhostArrayName());
      ghosts->SetNumberOfValues(points ? data->GetNumberOfPoints() : data->GetNumberOfCells());
      ghosts->Fill(0);
      ghosts->SetValue(3, value);
      (points ? static_cast<vtkFieldData*>(data->GetPointData()) : data->GetCellData())->AddArray(ghosts);
    });
  };
  withGhosts("GhostPoint", true, vtkDataSetAttributes::DUPLICATEPOINT);
  withGhosts("HiddenPoint", true, vtkDataSetAttributes::HIDDENPOINT);
  withGhosts("GhostCell", false, vtkDataSetAttributes::DUPLICATECELL);
  Change(cases, "GlobalIdsOfAnotherMesh", Expectation::Valid, sphere, [](vtkPolyData* data) {
    vtkNew<vtkIdTypeArray> ids;
    ids->SetName("GlobalIds");
    ids->InsertNextValue(1000000);
    data->GetPointData()->SetGlobalIds(ids);
  });
}

void AddPipelineCases(Cases& cases)
{
  Add(cases, "UnstructuredGrid", Expectation::Error, []() -> Data {
    auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
    grid->SetPoints(Tetrahedron().ToPolyData()->GetPoints());
    return grid;
  });
  Add(cases, "Image", Expectation::Error, []() -> Data { return vtkSmartPointer<vtkImageData>::New(); });
  Add(cases, "Table", Expectation::Error, []() -> Data { return vtkSmartPointer<vtkTable>::New(); });
  Add(cases, "CompositeOfNothing", Expectation::Empty,
    []() -> Data { return vtkSmartPointer<vtkMultiBlockDataSet>::New(); });
  Add(cases, "CompositeOfNullBlocks", Expectation::Empty, []() -> Data {
    auto blocks = vtkSmartPointer<vtkMultiBlockDataSet>::New();
    blocks->SetNumberOfBlocks(5);
    return blocks;
  });
  Add(cases, "CompositeOfEmptyBlocks", Expectation::Empty, []() -> Data {
    auto blocks = vtkSmartPointer<vtkMultiBlockDataSet>::New();
    for (unsigned int k = 0; k < 3; ++k)
    {
      vtkNew<vtkPolyData> empty;
      blocks->SetBlock(k, empty);
    }
    return blocks;
  });
  Add(cases, "CompositeNestedTenDeep", Expectation::Valid, []() -> Data {
    vtkSmartPointer<vtkDataObject> inner = Icosphere(1).ToPolyData();
    for (int k = 0; k < 10; ++k)
    {
      auto outer = vtkSmartPointer<vtkMultiBlockDataSet>::New();
      outer->SetBlock(1, inner);
      inner = outer;
    }
    return inner;
  });
  Add(cases, "CompositeOfPieces", Expectation::Valid, []() -> Data {
    vtkNew<vtkMultiPieceDataSet> pieces;
    pieces->SetPiece(0, Icosphere(1).ToPolyData());
    pieces->SetPiece(2, Grid(3).ToPolyData());
    auto blocks = vtkSmartPointer<vtkMultiBlockDataSet>::New();
    blocks->SetBlock(0, pieces);
    return blocks;
  });
  Add(cases, "CompositeOfOneBlockTwice", Expectation::Valid, []() -> Data {
    const auto sphere = Icosphere(1).ToPolyData();
    auto blocks = vtkSmartPointer<vtkMultiBlockDataSet>::New();
    blocks->SetBlock(0, sphere);
    blocks->SetBlock(1, sphere);
    return blocks;
  });
  Add(cases, "CompositeWithTable", Expectation::Error, []() -> Data {
    auto blocks = vtkSmartPointer<vtkMultiBlockDataSet>::New();
    vtkNew<vtkTable> table;
    blocks->SetBlock(0, table);
    return blocks;
  });
}
} // namespace

std::ostream& operator<<(std::ostream& os, const MalformedCase& malformed) { return os << malformed.Name; }

const std::vector<MalformedCase>& MalformedCorpus()
{
  static const Cases corpus = [] {
    Cases cases;
    AddEmptyCases(cases);
    AddTopologyCases(cases);
    AddCellCases(cases);
    AddStorageCases(cases);
    AddGeometryCases(cases);
    AddDataCases(cases);
    AddPipelineCases(cases);
    return cases;
  }();
  return corpus;
}

} // namespace surfsynthtest
