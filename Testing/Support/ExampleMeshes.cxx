// SPDX-License-Identifier: BSD-3-Clause
#include "ExampleMeshes.h"

#include <Eigen/Geometry>

#include <array>
#include <cmath>
#include <fstream>
#include <initializer_list>
#include <limits>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>

namespace surfsynth::test
{
namespace
{

constexpr double Pi = 3.14159265358979323846;

/// Collects points and triangles.
class Builder
{
public:
  Index Point(double x, double y, double z)
  {
    this->Points.push_back({ x, y, z });
    return static_cast<Index>(this->Points.size()) - 1;
  }
  void Triangle(Index a, Index b, Index c) { this->Triangles.push_back({ a, b, c }); }
  /// Two triangles for the quadrilateral a b c d.
  void Quad(Index a, Index b, Index c, Index d)
  {
    this->Triangle(a, b, c);
    this->Triangle(a, c, d);
  }
  TriangleMesh Mesh() const
  {
    TriangleMesh mesh;
    mesh.Points.resize(static_cast<Eigen::Index>(this->Points.size()), 3);
    mesh.Triangles.resize(static_cast<Eigen::Index>(this->Triangles.size()), 3);
    for (std::size_t i = 0; i < this->Points.size(); ++i)
    {
      mesh.Points.row(static_cast<Eigen::Index>(i)) << this->Points[i][0], this->Points[i][1], this->Points[i][2];
    }
    for (std::size_t f = 0; f < this->Triangles.size(); ++f)
    {
      mesh.Triangles.row(static_cast<Eigen::Index>(f)) << this->Triangles[f][0], this->Triangles[f][1],
        this->Triangles[f][2];
    }
    return mesh;
  }

private:
  std::vector<std::array<double, 3>> Points;
  std::vector<std::array<Index, 3>> Triangles;
};

void ProjectToSphere(TriangleMesh& mesh, double radius)
{
  mesh.Points.rowwise().normalize();
  mesh.Points *= radius;
}

TriangleMesh Icosahedron()
{
  Builder builder;
  const double t = (1.0 + std::sqrt(5.0)) / 2.0;
  const double corners[12][3] = { { -1, t, 0 }, { 1, t, 0 }, { -1, -t, 0 }, { 1, -t, 0 }, { 0, -1, t }, { 0, 1, t },
    { 0, -1, -t }, { 0, 1, -t }, { t, 0, -1 }, { t, 0, 1 }, { -t, 0, -1 }, { -t, 0, 1 } };
  const Index faces[20][3] = { { 0, 11, 5 }, { 0, 5, 1 }, { 0, 1, 7 }, { 0, 7, 10 }, { 0, 10, 11 }, { 1, 5, 9 },
    { 5, 11, 4 }, { 11, 10, 2 }, { 10, 7, 6 }, { 7, 1, 8 }, { 3, 9, 4 }, { 3, 4, 2 }, { 3, 2, 6 }, { 3, 6, 8 },
    { 3, 8, 9 }, { 4, 9, 5 }, { 2, 4, 11 }, { 6, 2, 10 }, { 8, 6, 7 }, { 9, 8, 1 } };
  for (const auto& corner : corners)
  {
    builder.Point(corner[0], corner[1], corner[2]);
  }
  for (const auto& face : faces)
  {
    builder.Triangle(face[0], face[1], face[2]);
  }
  return builder.Mesh();
}

} // namespace

std::uint32_t Mix(std::uint64_t a, std::uint64_t b)
{
  // Two rounds of the finaliser of SplitMix64.
  std::uint64_t x = a * 0x9e3779b97f4a7c15ULL + b + 0x632be59bd9b4e019ULL;
  for (int round = 0; round < 2; ++round)
  {
    x ^= x >> 30;
    x *= 0xbf58476d1ce4e5b9ULL;
    x ^= x >> 27;
    x *= 0x94d049bb133111ebULL;
    x ^= x >> 31;
  }
  return static_cast<std::uint32_t>(x >> 32);
}

double Uniform(std::uint64_t a, std::uint64_t b) { return static_cast<double>(Mix(a, b)) / 2147483648.0 - 1.0; }

TriangleMesh Icosphere(int level, double radius)
{
  TriangleMesh mesh = Icosahedron();
  ProjectToSphere(mesh, radius);
  for (int i = 0; i < level; ++i)
  {
    mesh = Subdivide(mesh);
    ProjectToSphere(mesh, radius);
  }
  return mesh;
}

TriangleMesh UvSphere(int rings, int segments, double radius)
{
  Builder builder;
  const Index north = builder.Point(0.0, 0.0, radius);
  for (int i = 1; i < rings; ++i)
  {
    const double theta = Pi * i / rings;
    for (int j = 0; j < segments; ++j)
    {
      const double phi = 2.0 * Pi * j / segments;
      builder.Point(
        radius * std::sin(theta) * std::cos(phi), radius * std::sin(theta) * std::sin(phi), radius * std::cos(theta));
    }
  }
  const Index south = builder.Point(0.0, 0.0, -radius);
  const auto id = [&](int ring, int segment) { return 1 + (ring - 1) * segments + segment % segments; };
  for (int j = 0; j < segments; ++j)
  {
    builder.Triangle(north, id(1, j), id(1, j + 1));
    for (int i = 1; i < rings - 1; ++i)
    {
      builder.Quad(id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1));
    }
    builder.Triangle(south, id(rings - 1, j + 1), id(rings - 1, j));
  }
  return builder.Mesh();
}

TriangleMesh Torus(int along, int around, double majorRadius, double minorRadius)
{
  Builder builder;
  for (int i = 0; i < along; ++i)
  {
    for (int j = 0; j < around; ++j)
    {
      const double u = 2.0 * Pi * i / along;
      const double v = 2.0 * Pi * j / around;
      const double r = majorRadius + minorRadius * std::cos(v);
      builder.Point(r * std::cos(u), r * std::sin(u), minorRadius * std::sin(v));
    }
  }
  const auto id = [&](int i, int j) { return (i % along) * around + j % around; };
  for (int i = 0; i < along; ++i)
  {
    for (int j = 0; j < around; ++j)
    {
      builder.Quad(id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1));
    }
  }
  return builder.Mesh();
}

TriangleMesh PlanePatch(int columns, int rows, double width, double height, double jitter)
{
  Builder builder;
  for (int j = 0; j <= rows; ++j)
  {
    for (int i = 0; i <= columns; ++i)
    {
      const bool inside = i > 0 && i < columns && j > 0 && j < rows;
      const auto id = static_cast<std::uint64_t>(j * (columns + 1) + i);
      const double dx = inside ? jitter * Uniform(id, 11) : 0.0;
      const double dy = inside ? jitter * Uniform(id, 12) : 0.0;
      builder.Point(width * (i + dx) / columns, height * (j + dy) / rows, 0.0);
    }
  }
  const auto id = [&](int i, int j) { return j * (columns + 1) + i; };
  for (int j = 0; j < rows; ++j)
  {
    for (int i = 0; i < columns; ++i)
    {
      if ((i + j) % 2 == 0)
      {
        builder.Quad(id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1));
      }
      else
      {
        builder.Quad(id(i + 1, j), id(i + 1, j + 1), id(i, j + 1), id(i, j));
      }
    }
  }
  return builder.Mesh();
}

TriangleMesh OpenCylinder(int segments, int rows, double radius, double height)
{
  Builder builder;
  for (int j = 0; j <= rows; ++j)
  {
    for (int i = 0; i < segments; ++i)
    {
      const double phi = 2.0 * Pi * i / segments;
      builder.Point(radius * std::cos(phi), radius * std::sin(phi), height * j / rows);
    }
  }
  const auto id = [&](int i, int j) { return j * segments + i % segments; };
  for (int j = 0; j < rows; ++j)
  {
    for (int i = 0; i < segments; ++i)
    {
      builder.Quad(id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1));
    }
  }
  return builder.Mesh();
}

TriangleMesh Tetrahedron()
{
  Builder builder;
  builder.Point(0, 0, 0);
  builder.Point(1, 1, 0);
  builder.Point(1, 0, 1);
  builder.Point(0, 1, 1);
  builder.Triangle(0, 1, 2);
  builder.Triangle(0, 3, 1);
  builder.Triangle(0, 2, 3);
  builder.Triangle(1, 3, 2);
  return builder.Mesh();
}

TriangleMesh SingleTriangle()
{
  Builder builder;
  builder.Point(0, 0, 0);
  builder.Point(2, 0, 0);
  builder.Point(0, 1, 0);
  builder.Triangle(0, 1, 2);
  return builder.Mesh();
}

TriangleMesh IrregularSphere(int level, std::uint32_t seed)
{
  TriangleMesh mesh = Icosphere(level);
  for (std::uint64_t round = 0; round < 2; ++round)
  {
    mesh = RefineWhere(mesh, [&](Index f) { return Mix(static_cast<std::uint64_t>(f), seed + round) % 4 == 0; });
    ProjectToSphere(mesh, 1.0);
  }
  const double step = 0.15 * std::sqrt(4.0 * Pi / static_cast<double>(mesh.Points.rows()));
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    for (int c = 0; c < 3; ++c)
    {
      mesh.Points(v, c) += step * Uniform(static_cast<std::uint64_t>(v), seed + 10U + static_cast<unsigned>(c));
    }
  }
  ProjectToSphere(mesh, 1.0);
  return mesh;
}

TriangleMesh LocallyRefinedSphere(int level)
{
  TriangleMesh mesh = Icosphere(level);
  for (const double height : { 0.3, 0.6, 0.85 })
  {
    mesh = RefineWhere(mesh, [&](Index f) {
      double z = 0.0;
      for (int c = 0; c < 3; ++c)
      {
        z += mesh.Points(mesh.Triangles(f, c), 2) / 3.0;
      }
      return z > height;
    });
    ProjectToSphere(mesh, 1.0);
  }
  return mesh;
}

TriangleMesh MoebiusStrip(int segments, int rows)
{
  Builder builder;
  for (int i = 0; i < segments; ++i)
  {
    for (int j = 0; j <= rows; ++j)
    {
      const double u = 2.0 * Pi * i / segments;
      const double v = 0.8 * (static_cast<double>(j) / rows - 0.5);
      const double r = 1.0 + v * std::cos(u / 2.0);
      builder.Point(r * std::cos(u), r * std::sin(u), v * std::sin(u / 2.0));
    }
  }
  // After one turn the strip meets itself upside down.
  const auto id = [&](int i, int j) { return i < segments ? i * (rows + 1) + j : rows - j; };
  for (int i = 0; i < segments; ++i)
  {
    for (int j = 0; j < rows; ++j)
    {
      builder.Quad(id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1));
    }
  }
  return builder.Mesh();
}

TriangleMesh Join(const TriangleMesh& first, const TriangleMesh& second)
{
  TriangleMesh mesh;
  mesh.Points.resize(first.Points.rows() + second.Points.rows(), 3);
  mesh.Points << first.Points, second.Points;
  mesh.Triangles.resize(first.Triangles.rows() + second.Triangles.rows(), 3);
  mesh.Triangles << first.Triangles, (second.Triangles.array() + first.NumberOfPoints()).matrix();
  return mesh;
}

TriangleMesh WithUnreferencedPoints(const TriangleMesh& mesh)
{
  // New ids: every group of five points moves up by one more place.
  const auto moved = [](Index v) { return v + v / 5 + 1; };
  const Index last = moved(mesh.NumberOfPoints() - 1);
  TriangleMesh result;
  result.Points = PointMatrix::Constant(last + 1, 3, 17.0);
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    result.Points.row(moved(v)) = mesh.Points.row(v);
  }
  result.Triangles = mesh.Triangles.unaryExpr(moved);
  return result;
}

TriangleMesh BumpySurface(int level)
{
  TriangleMesh mesh = Icosphere(level);
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    const Eigen::Vector3d p = mesh.Points.row(v);
    const double bump = 0.25 * std::sin(2.0 * p.x() + 0.3) * std::cos(1.7 * p.y() - 0.2) +
      0.08 * std::sin(5.0 * p.z() + 3.0 * p.x()) + 0.03 * std::sin(11.0 * p.y() + 7.0 * p.z());
    mesh.Points.row(v) *= 1.0 + bump;
  }
  mesh.Points.col(0) *= 1.6;
  mesh.Points.col(1) *= 1.2;
  return mesh;
}

TriangleMesh SurfaceOfCubes(const std::set<UnitCube>& cubes)
{
  std::map<UnitCube, Index> ids;
  std::vector<std::array<Index, 3>> triangles;
  for (const UnitCube& cube : cubes)
  {
    for (int side = 0; side < 6; ++side)
    {
      const int axis = side / 2;
      UnitCube next = cube;
      next[axis] += side % 2 == 0 ? -1 : 1;
      if (cubes.count(next) > 0)
      {
        continue;
      }
      std::array<Index, 4> corner;
      for (int k = 0; k < 4; ++k)
      {
        UnitCube at = cube;
        at[axis] += side % 2;
        at[(axis + 1) % 3] += k == 1 || k == 2 ? 1 : 0;
        at[(axis + 2) % 3] += k >= 2 ? 1 : 0;
        corner[side % 2 == 0 ? 3 - k : k] = ids.emplace(at, static_cast<Index>(ids.size())).first->second;
      }
      triangles.push_back({ corner[0], corner[1], corner[2] });
      triangles.push_back({ corner[0], corner[2], corner[3] });
    }
  }
  TriangleMesh mesh;
  mesh.Points.resize(static_cast<Index>(ids.size()), 3);
  for (const auto& id : ids)
  {
    mesh.Points.row(id.second) << id.first[0], id.first[1], id.first[2];
  }
  mesh.Triangles.resize(static_cast<Index>(triangles.size()), 3);
  for (std::size_t f = 0; f < triangles.size(); ++f)
  {
    mesh.Triangles.row(static_cast<Index>(f)) << triangles[f][0], triangles[f][1], triangles[f][2];
  }
  return mesh;
}

TriangleMesh SphereWithoutCap(int level, double height)
{
  TriangleMesh mesh = Icosphere(level);
  Index kept = 0;
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    const auto t = mesh.Triangles.row(f).eval();
    if (mesh.Points(t(0), 2) + mesh.Points(t(1), 2) + mesh.Points(t(2), 2) <= 3.0 * height)
    {
      mesh.Triangles.row(kept++) = t;
    }
  }
  mesh.Triangles.conservativeResize(kept, 3);
  return mesh;
}

TriangleMesh Scaled(TriangleMesh mesh, double factor)
{
  mesh.Points *= factor;
  return mesh;
}

TriangleMesh Translated(TriangleMesh mesh, const Eigen::Vector3d& offset)
{
  mesh.Points.rowwise() += offset.transpose();
  return mesh;
}

TriangleMesh ReadOff(const std::string& path)
{
  std::ifstream file(path);
  std::string text;
  std::string content;
  while (std::getline(file, text))
  {
    content += text.substr(0, text.find('#'));
    content += '\n';
  }
  std::istringstream in(content);
  std::string magic;
  Eigen::Index points = 0;
  Eigen::Index triangles = 0;
  Eigen::Index edges = 0;
  in >> magic >> points >> triangles >> edges;
  if (!in || magic != "OFF")
  {
    throw std::runtime_error("ReadOff: '" + path + "' is not an OFF file");
  }
  TriangleMesh mesh;
  mesh.Points.resize(points, 3);
  mesh.Triangles.resize(triangles, 3);
  for (Eigen::Index v = 0; v < points; ++v)
  {
    in >> mesh.Points(v, 0) >> mesh.Points(v, 1) >> mesh.Points(v, 2);
  }
  for (Eigen::Index f = 0; f < triangles; ++f)
  {
    int corners = 0;
    in >> corners >> mesh.Triangles(f, 0) >> mesh.Triangles(f, 1) >> mesh.Triangles(f, 2);
    if (corners != 3)
    {
      throw std::runtime_error("ReadOff: '" + path + "' holds a face that is not a triangle");
    }
  }
  if (!in)
  {
    throw std::runtime_error("ReadOff: '" + path + "' ends early");
  }
  return mesh;
}

void WriteOff(const TriangleMesh& mesh, const std::string& path)
{
  std::ofstream file(path);
  file.precision(std::numeric_limits<double>::max_digits10);
  file << "OFF\n" << mesh.NumberOfPoints() << ' ' << mesh.NumberOfTriangles() << " 0\n";
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    file << mesh.Points(v, 0) << ' ' << mesh.Points(v, 1) << ' ' << mesh.Points(v, 2) << '\n';
  }
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    file << "3 " << mesh.Triangles(f, 0) << ' ' << mesh.Triangles(f, 1) << ' ' << mesh.Triangles(f, 2) << '\n';
  }
  if (!file.flush())
  {
    throw std::runtime_error("WriteOff: cannot write '" + path + "'");
  }
}

bool HasArmadillo()
{
#ifdef SURFACE_SYNTHESIS_ARMADILLO
  return std::ifstream(SURFACE_SYNTHESIS_ARMADILLO).good();
#else
  return false;
#endif
}

TriangleMesh ScannedSurface()
{
  TriangleMesh mesh;
#ifdef SURFACE_SYNTHESIS_ARMADILLO
  mesh = HasArmadillo() ? ReadOff(SURFACE_SYNTHESIS_ARMADILLO) : BumpySurface(6);
#else
  mesh = BumpySurface(6);
#endif
  const Eigen::RowVector3d lower = mesh.Points.colwise().minCoeff();
  const Eigen::RowVector3d upper = mesh.Points.colwise().maxCoeff();
  mesh.Points.rowwise() -= lower;
  mesh.Points /= (upper - lower).maxCoeff();
  return mesh;
}

namespace
{

const std::vector<SuiteMesh>& Suite()
{
  static const std::vector<SuiteMesh> suite = {
    { "SingleTriangle", SingleTriangle(), 1, 1, false, true },
    { "Tetrahedron", Tetrahedron(), 1, 2, true, true },
    { "Icosphere", Icosphere(3), 1, 2, true, true },
    { "UvSphere", UvSphere(12, 20, 2.5), 1, 2, true, true },
    { "Torus", Torus(32, 14), 1, 0, true, true },
    { "PlanePatch", PlanePatch(13, 9, 3.0, 2.0, 0.2), 1, 1, false, true },
    { "OpenCylinder", OpenCylinder(24, 10), 1, 0, false, true },
    { "IrregularSphere", IrregularSphere(2), 1, 2, true, true },
    { "LocallyRefinedSphere", LocallyRefinedSphere(2), 1, 2, true, true },
    { "MoebiusStrip", MoebiusStrip(40, 5), 1, 0, false, false },
    { "TwoComponents", Join(Icosphere(2), Translated(Torus(20, 10, 3.0, 1.0), { 8.0, 0.0, 0.0 })), 2, 2, true, true },
    { "OpenAndClosed", Join(PlanePatch(6, 6), Translated(Icosphere(1), { 0.0, 0.0, 5.0 })), 2, 3, false, true },
    { "UnreferencedPoints", WithUnreferencedPoints(Icosphere(2)), 1, 2, true, true, 33 },
    { "FarFromOrigin", Translated(Icosphere(2), { 1e4, -2e4, 3e4 }), 1, 2, true, true },
    { "Tiny", Scaled(BumpySurface(2), 1e-6), 1, 2, true, true },
    { "Huge", Scaled(BumpySurface(2), 1e6), 1, 2, true, true },
    { "Decimated", Decimate(BumpySurface(3), 250), 1, 2, true, true },
  };
  return suite;
}

} // namespace

std::vector<std::string> SuiteNames()
{
  std::vector<std::string> names;
  for (const SuiteMesh& mesh : Suite())
  {
    names.push_back(mesh.Name);
  }
  return names;
}

const SuiteMesh& FromSuite(const std::string& name)
{
  for (const SuiteMesh& mesh : Suite())
  {
    if (mesh.Name == name)
    {
      return mesh;
    }
  }
  throw std::runtime_error("FromSuite: no mesh is called '" + name + "'");
}

} // namespace surfsynth::test
