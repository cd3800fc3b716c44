// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Images and planar meshes, for the training of field latents [Mitchel2024]. Neither VTK nor torch.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

#include <Eigen/Core>

#include <cstdint>
#include <string>
#include <vector>

namespace surfsynth
{

/// Points of a plane, [V, 2].
using PlanarPoints = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>;

/// An RGB image. Row 0 is its first row in memory, and the lowest one of the plane when meshes are laid over it: training
/// with files whose first row is the top sees mirror images of what the encoder sees, as it does with random rotations; a
/// network that is to tell an image from its mirror image needs the rows turned over.
struct TextureImage
{
  std::int64_t Height = 0;           ///< H, rows
  std::int64_t Width = 0;            ///< W, columns
  std::vector<unsigned char> Pixels; ///< [H, W, 3]
};

/// A triangulation of a part of the unit square.
struct PlanarMesh
{
  PlanarPoints Points;      ///< [V, 2] in [0, 1]
  TriangleMatrix Triangles; ///< [F, 3], counterclockwise
};

/// Images of any sizes, and meshes that are laid over them.
struct TextureDataset
{
  std::vector<TextureImage> Images; ///< at least one
  std::vector<PlanarMesh> Meshes;   ///< at least one
};

/// Finds the vertices whose triangles surround them: those with angles of 2 pi together.
std::vector<Index> InteriorVertices(const PlanarMesh& mesh);

/// Checks a dataset.
/// @throws InvalidInput naming the first image without pixels or with a wrong number of them, or the first mesh with a
/// point outside the unit square, a triangle that is not counterclockwise, or no interior vertex; or when there is no
/// image or no mesh.
void CheckDataset(const TextureDataset& dataset);

/// 64-bit hash of all images and meshes.
std::uint64_t ContentHash(const TextureDataset& dataset);

/// Reads a dataset file: safetensors with the metadata `content` ("textures") and `format_version` ("1"), for each image
/// k = 0, 1, ... the tensor `images.<k>` [H, W, 3] of bytes (U8), and for each mesh k = 0, 1, ... the tensors
/// `meshes.<k>.points` [V, 2] of a floating-point type and `meshes.<k>.triangles` [F, 3] integers. Numbers have no gap.
/// @throws InvalidInput when the file cannot be opened; FormatError when it breaks a rule of its format; ModelMismatch
/// when it is no such dataset.
TextureDataset ReadTextureDataset(const std::string& path);

/// Writes a dataset file: points in float64.
/// @throws InvalidInput as CheckDataset(), and when the file cannot be written.
void WriteTextureDataset(const std::string& path, const TextureDataset& dataset);

} // namespace surfsynth
