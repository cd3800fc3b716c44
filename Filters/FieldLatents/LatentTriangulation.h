// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Triangulation of a surface at whose vertices latents are sampled or trained.
#pragma once

#include "vtkSurfaceSynthesisFieldLatentsModule.h" // For export macro

#include "SurfaceBridge.h"
#include "WeldedSurface.h"

#include "Core/Common/Progress.h"
#include "Core/Mesh/SurfacePlace.h"
#include "Core/Random/CounterNormals.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace surfsynth
{

/// Triangulation of a surface: its own, or one of even triangles.
class VTKSURFACESYNTHESISFIELDLATENTS_EXPORT LatentTriangulation
{
public:
  /// Checks and welds @p surface and remeshes it, as vtkIsotropicRemeshFilter does by default, but across seams of arrays
  /// and without the regular parts that this may leave: MoveRegularVertices(). Deterministic.
  /// @param numberOfPoints vertices of the remeshed surface, to a few per cent where its shape and boundaries allow it; 0 for the vertices that the surface has
  /// @param variation random factors of the edge lengths at the vertices of the surface, uniform in 0.8 to 1.2, that make
  /// the vertices lie elsewhere for each key; without: equal lengths. Only used with remeshing.
  /// @throws InvalidInput when the welded surface is not manifold or not consistently wound, or it is to be remeshed and
  /// the library was built without CGAL; Cancelled
  LatentTriangulation(const Surface& surface, std::int64_t numberOfPoints, const Progress& progress,
    const std::optional<NormalKey>& variation = {});

  /// Triangulation; triangles use all vertices. Without remeshing, triangle f is that of the surface.
  const WeldedSurface& Welded() const { return this->Content; }
  /// Place of each vertex on the triangles of the surface, [V].
  const std::vector<SurfacePlace>& Places() const { return this->PlaceOfVertex; }
  /// True when it was remeshed.
  bool IsRemeshed() const { return this->Remeshed; }
  /// Number of vertices.
  Index NumberOfVertices() const { return this->Content.Mesh.NumberOfPoints(); }
  /// Number of vertices in regular parts: RegularVertices().
  std::int64_t NumberOfRegularVertices() const { return this->RegularVertexCount; }

private:
  struct Parts;
  explicit LatentTriangulation(Parts parts);
  static Parts Make(const Surface& surface, std::int64_t numberOfPoints, const Progress& progress,
    const std::optional<NormalKey>& variation);

  bool Remeshed;
  std::vector<SurfacePlace> PlaceOfVertex;
  WeldedSurface Content;
  std::int64_t RegularVertexCount;
};

} // namespace surfsynth
