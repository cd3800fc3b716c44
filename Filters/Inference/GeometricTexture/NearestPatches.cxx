// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/GeometricTexture/NearestPatches.h"

#include "Core/Common/Parallel.h"
#include "Inference/Common/MatrixProduct.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

namespace surfsynth
{

namespace
{
/// Patches and patches of the example of a tile: its distances stay in the cache of a core.
constexpr std::int64_t TileRows = 128, TileColumns = 512;
constexpr float Infinity = std::numeric_limits<float>::infinity();
} // namespace

/// Weighted squared distances of patches from those of the example, by tiles.
class NearestPatches::Tiles
{
public:
  using Array = Eigen::Array<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  Tiles(const ExamplePatches::Rows& forms, const ExamplePatches::Rows& coordinates)
    : Forms(forms)
    , Patches(coordinates.rows(), coordinates.cols() + 2)
  {
    this->Patches << coordinates, coordinates.rowwise().squaredNorm(), Eigen::VectorXf::Ones(coordinates.rows());
  }

  std::int64_t RowTiles() const { return (this->Patches.rows() + TileRows - 1) / TileRows; }
  std::int64_t ColumnTiles() const { return (this->Forms.cols() + TileColumns - 1) / TileColumns; }

  /// Computes the distances of a tile, [rows, columns]; zero may be a little less by rounding.
  void Compute(std::int64_t rowTile, std::int64_t columnTile, Array& distances) const
  {
    const std::int64_t row = rowTile * TileRows, column = columnTile * TileColumns;
    const std::int64_t rows = std::min(TileRows, this->Patches.rows() - row);
    const std::int64_t columns = std::min(TileColumns, this->Forms.cols() - column);
    distances.resize(rows, columns);
    MultiplyBlocks({ this->Patches.row(row).data(), this->Patches.cols() },
      { this->Forms.data() + column, this->Forms.cols() }, distances.data(), columns, rows, this->Patches.cols(),
      columns);
  }

private:
  const ExamplePatches::Rows& Forms;
  ExamplePatches::Rows Patches; ///< [n, D + 2]
};

NearestPatches::NearestPatches(const ExamplePatches& example)
  : Example(example)
{
  this->SetWeights(Eigen::ArrayXf::Ones(example.Count()));
}

void NearestPatches::SetWeights(const Eigen::ArrayXf& weights)
{
  const Eigen::Index components = this->Example.Coordinates.rows();
  this->Forms.resize(components + 2, this->Example.Count());
  this->Forms.topRows(components) = -2.0F * (this->Example.Coordinates * weights.matrix().asDiagonal());
  this->Forms.row(components) = weights.transpose();
  this->Forms.row(components + 1) = (this->Example.Squares.array() * weights).transpose();
}

void NearestPatches::Prefer(const ExamplePatches::Rows& coordinates, float completeness, const Progress& progress)
{
  this->SetWeights(Eigen::ArrayXf::Ones(this->Example.Count()));
  const Tiles tiles(this->Forms, coordinates);
  Eigen::ArrayXf weights(this->Example.Count());
  ParallelTasks(
    tiles.ColumnTiles(),
    [&](std::int64_t task) {
      Tiles::Array distances;
      const std::int64_t first = task * TileColumns, columns = std::min(TileColumns, weights.size() - first);
      Eigen::Array<float, 1, Eigen::Dynamic> least = Eigen::Array<float, 1, Eigen::Dynamic>::Constant(
        columns, Infinity);
      for (std::int64_t tile = 0; tile < tiles.RowTiles(); ++tile)
      {
        tiles.Compute(tile, task, distances);
        for (Eigen::Index r = 0; r < distances.rows(); ++r)
        {
          least = least.min(distances.row(r));
        }
      }
      weights.segment(first, columns) = (least.max(0.0F) + completeness).inverse().transpose();
    },
    [&] { Report(progress, 0.0); });
  this->SetWeights(weights);
}

std::vector<Index> NearestPatches::Find(const ExamplePatches::Rows& coordinates, const Progress& progress) const
{
  const Tiles tiles(this->Forms, coordinates);
  std::vector<Index> nearest(static_cast<std::size_t>(coordinates.rows()), 0);
  ParallelTasks(
    tiles.RowTiles(),
    [&](std::int64_t task) {
      Tiles::Array distances;
      std::vector<float> least(static_cast<std::size_t>(TileRows), Infinity);
      for (std::int64_t tile = 0; tile < tiles.ColumnTiles(); ++tile)
      {
        tiles.Compute(task, tile, distances);
        for (Eigen::Index r = 0; r < distances.rows(); ++r)
        {
          float& best = least[static_cast<std::size_t>(r)];
          if (distances.row(r).minCoeff() < best)
          {
            Eigen::Index column = 0;
            best = distances.row(r).minCoeff(&column);
            nearest[static_cast<std::size_t>(task * TileRows + r)] = static_cast<Index>(tile * TileColumns + column);
          }
        }
      }
    },
    [&] { Report(progress, 0.0); });
  return nearest;
}

} // namespace surfsynth
