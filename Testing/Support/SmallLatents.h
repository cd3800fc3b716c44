// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// A small dataset of field latents.
#pragma once

#include "ExampleMeshes.h"

#include "IO/Datasets/LatentDataset.h"

#include <cmath>

namespace surfsynth::test
{

/// Two tangent vectors at each vertex of a surface, the first of length 1, the second longer, both at angles to the
/// directions that vary little; labels from -1 to 2 by height.
inline LatentSurface LatentsOn(const TriangleMesh& mesh)
{
  LatentSurface surface;
  surface.Mesh = mesh;
  const Index vertices = mesh.NumberOfPoints();
  surface.Means.resize(vertices, 4);
  surface.Deviations = LatentColumns::Constant(vertices, 2, 0.1F);
  surface.Directions.resize(vertices, 2);
  for (Index v = 0; v < vertices; ++v)
  {
    const double angle = 0.4 * std::sin(5.0 * mesh.Points(v, 0));
    surface.Means.row(v) << static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)), 0.5F, 2.0F;
    surface.Labels.push_back(mesh.Points(v, 2) < -0.5 ? -1 : static_cast<std::int32_t>(mesh.Points(v, 2) + 1.5));
    surface.Directions.row(v) << 1.0F, 0.0F;
  }
  return surface;
}

/// Two triangulations of a sphere.
inline LatentDataset SmallLatents()
{
  return { { LatentsOn(IrregularSphere(1, 1)), LatentsOn(IrregularSphere(1, 2)) }, "" };
}

} // namespace surfsynth::test
