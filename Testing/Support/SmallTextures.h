// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// A small dataset of images and planar meshes.
#pragma once

#include "IO/Datasets/TextureDataset.h"

#include <cmath>

namespace surfsynth::test
{

/// Waves of colors whose lengths are some tenths of the image.
inline TextureImage WaveImage(std::int64_t height, std::int64_t width, double phase)
{
  TextureImage image = { height, width, {} };
  for (std::int64_t row = 0; row < height; ++row)
  {
    for (std::int64_t column = 0; column < width; ++column)
    {
      const double x = 12.0 * static_cast<double>(column) / static_cast<double>(width);
      const double y = 9.0 * static_cast<double>(row) / static_cast<double>(height);
      for (const double turn : { 0.0, 1.0, 2.5 })
      {
        image.Pixels.push_back(
          static_cast<unsigned char>(127.5 + 127.0 * std::sin(x + turn + phase) * std::cos(y - phase)));
      }
    }
  }
  return image;
}

/// The unit square in 2 n^2 triangles, whose inner vertices are moved a little.
inline PlanarMesh SquareMesh(Index n)
{
  PlanarMesh mesh;
  mesh.Points.resize((n + 1) * (n + 1), 2);
  mesh.Triangles.resize(2 * n * n, 3);
  for (Index row = 0; row <= n; ++row)
  {
    for (Index column = 0; column <= n; ++column)
    {
      const bool inner = row > 0 && row < n && column > 0 && column < n;
      const double shift = inner ? 0.2 * std::sin(7.0 * row + 3.0 * column) : 0.0;
      mesh.Points.row(row * (n + 1) + column) << (column + shift) / n, (row - 0.7 * shift) / n;
    }
  }
  for (Index cell = 0; cell < n * n; ++cell)
  {
    const Index at = cell / n * (n + 1) + cell % n;
    mesh.Triangles.row(2 * cell) << at, at + 1, at + n + 2;
    mesh.Triangles.row(2 * cell + 1) << at, at + n + 2, at + n + 1;
  }
  return mesh;
}

/// Two images of different sizes and two meshes.
inline TextureDataset SmallTextures()
{
  return { { WaveImage(40, 60, 0.0), WaveImage(64, 50, 1.0) }, { SquareMesh(6), SquareMesh(9) } };
}

} // namespace surfsynth::test
