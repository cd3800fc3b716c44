// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The surfaces that the tests and the benchmarks of the core run on.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

#include <array>
#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <vector>

namespace surfsynth::test
{

/// Sphere around the origin from an icosahedron, each triangle split into four @p level times.
TriangleMesh Icosphere(int level, double radius = 1.0);

/// Sphere of @p rings rings and @p segments segments, with poles of valence @p segments.
TriangleMesh UvSphere(int rings, int segments, double radius = 1.0);

/// Torus around the z axis, @p along triangles pairs around the large circle and @p around around the small one.
TriangleMesh Torus(int along, int around, double majorRadius = 1.0, double minorRadius = 0.4);

/// Rectangle [0, width] x [0, height] in the plane z = 0; inner vertices are moved at random by up to @p jitter cells
/// along each axis; below 0.25 no triangle can fold.
TriangleMesh PlanePatch(int columns, int rows, double width = 1.0, double height = 1.0, double jitter = 0.0);

/// Open cylinder around the z axis: two boundary loops.
TriangleMesh OpenCylinder(int segments, int rows, double radius = 1.0, double height = 2.0);

/// The tetrahedron on four corners of the unit cube.
TriangleMesh Tetrahedron();

/// The triangle (0,0,0), (2,0,0), (0,1,0).
TriangleMesh SingleTriangle();

/// Unit sphere whose triangles were split at random and whose vertices were then moved along it: valences 3 to 12.
TriangleMesh IrregularSphere(int level, std::uint32_t seed = 1);

/// Unit sphere refined three more times towards the north pole: edge lengths over a factor of 8.
TriangleMesh LocallyRefinedSphere(int level);

/// Moebius strip: manifold, one boundary loop, no consistent winding.
TriangleMesh MoebiusStrip(int segments, int rows);

/// @p first and @p second as one mesh without shared vertices.
TriangleMesh Join(const TriangleMesh& first, const TriangleMesh& second);

/// @p mesh with an unreferenced point before every fifth of its points.
TriangleMesh WithUnreferencedPoints(const TriangleMesh& mesh);

/// Sphere-like closed surface with bumps of several sizes and no symmetry, so that its eigenvalues are simple.
TriangleMesh BumpySurface(int level);

/// The lower corner of a cube of side 1.
using UnitCube = std::array<int, 3>;

/// The boundary of a set of unit cubes, wound outwards, with one point for each corner that it touches: edges with four
/// triangles and points with several fans wherever cubes touch in an edge or a corner only.
TriangleMesh SurfaceOfCubes(const std::set<UnitCube>& cubes);

/// Sphere around the origin without the triangles whose centroid lies above @p height, wound outwards.
TriangleMesh SphereWithoutCap(int level, double height);

TriangleMesh Scaled(TriangleMesh mesh, double factor);
TriangleMesh Translated(TriangleMesh mesh, const Eigen::Vector3d& offset);

/// Splits every edge of the triangles that @p marked chooses at its midpoint, and their neighbours so that the mesh
/// stays conforming. The surface does not change.
TriangleMesh RefineWhere(const TriangleMesh& mesh, const std::function<bool(Index triangle)>& marked);

/// Splits every triangle into four. The surface does not change.
TriangleMesh Subdivide(const TriangleMesh& mesh);

/// Refines triangles chosen at random until the mesh has about @p points points (at most four times as many as it has).
TriangleMesh RefineToSize(const TriangleMesh& mesh, Index points, std::uint32_t seed = 1);

/// Collapses edges of lowest quadric error [Garland1997] until @p points points are left. Boundaries and
/// the topology stay.
TriangleMesh Decimate(const TriangleMesh& mesh, Index points);

/// Reads a triangle mesh from an OFF file. Throws std::runtime_error when it cannot.
TriangleMesh ReadOff(const std::string& path);
/// Writes an OFF file with all digits of the coordinates.
void WriteOff(const TriangleMesh& mesh, const std::string& path);

/// True when the build found the scanned armadillo of Debian's libcgal-demo.
bool HasArmadillo();

/// The scanned armadillo (26,002 points), scaled to a longest side of 1; BumpySurface(6) (40,962 points) scaled
/// likewise when there is none.
TriangleMesh ScannedSurface();

/// A mesh of the suite and what is known about it.
struct SuiteMesh
{
  std::string Name;
  TriangleMesh Mesh;
  int Components;
  int EulerCharacteristic; ///< summed over the components
  bool Closed;             ///< every component
  bool ConsistentWinding;
  int UnusedPoints = 0;
};

/// Names of all meshes of the suite, and one of them. Every mesh passes CheckMesh().
std::vector<std::string> SuiteNames();
const SuiteMesh& FromSuite(const std::string& name);

/// 32 well-mixed bits of two numbers: randomness for the tests that is independent of the library.
std::uint32_t Mix(std::uint64_t a, std::uint64_t b);
/// A number in [-1, 1) from Mix().
double Uniform(std::uint64_t a, std::uint64_t b);

} // namespace surfsynth::test
