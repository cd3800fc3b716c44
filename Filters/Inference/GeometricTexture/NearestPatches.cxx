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

/// Squared distances of a tile.
class DistanceTile
{
public:
  using Array = Eigen::Array<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  DistanceTile(const ExamplePatches& example, const ExamplePatches::Rows& coordinates)
    : Example(example)
    , Coordinates(coordinates)
    , Squares(coordinates.rowwise().squaredNorm())
  {}

  std::int64_t RowTiles() const { return (this->Coordinates.rows() + TileRows - 1) / TileRows; }
  std::int64_t ColumnTiles() const { return (this->Example.Count() + TileColumns - 1) / TileColumns; }

  /// Computes the distances of a tile, [rows, columns].
  void Compute(std::int64_t rowTile, std::int64_t columnTile, Array& distances) const
  {
    const std::int64_t row = rowTile * TileRows, column = columnTile * TileColumns;
    const std::int64_t rows = std::min(TileRows, this->Coordinates.rows() - row);
    const std::int64_t columns = std::min(TileColumns, this->Example.Count() - column);
    distances.resize(rows, columns);
    MultiplyBlocks({ this->Coordinates.row(row).data(), this->Coordinates.cols() },
      { this->Example.Coordinates.data() + column, this->Example.Count() }, distances.data(), columns, rows,
      this->Coordinates.cols(), columns);
    const auto ofExample = this->Example.Squares.segment(column, columns).transpose().array();
    for (std::int64_t r = 0; r < rows; ++r)
    {
      distances.row(r) = (ofExample - 2.0F * distances.row(r) + this->Squares(row + r)).max(0.0F);
    }
  }

private:
  const ExamplePatches& Example;
  const ExamplePatches::Rows& Coordinates;
  Eigen::VectorXf Squares;
};

/// Returns 1 / (completeness + smallest distance from any patch) of each patch of the example.
Eigen::ArrayXf WeightsOfExample(
  const DistanceTile& tiles, std::int64_t count, float completeness, const Progress& progress)
{
  Eigen::ArrayXf weights(count);
  ParallelTasks(
    tiles.ColumnTiles(),
    [&](std::int64_t task) {
      DistanceTile::Array distances;
      const std::int64_t first = task * TileColumns, columns = std::min(TileColumns, count - first);
      Eigen::Array<float, 1, Eigen::Dynamic> least = Eigen::Array<float, 1, Eigen::Dynamic>::Constant(
        columns, std::numeric_limits<float>::infinity());
      for (std::int64_t tile = 0; tile < tiles.RowTiles(); ++tile)
      {
        tiles.Compute(tile, task, distances);
        least = least.min(distances.colwise().minCoeff());
      }
      weights.segment(first, columns) = (least + completeness).inverse().transpose();
    },
    [&] { Report(progress, 0.0); });
  return weights;
}
} // namespace

std::vector<Index> FindNearestPatches(
  const ExamplePatches& example, const ExamplePatches::Rows& coordinates, float completeness, const Progress& progress)
{
  const DistanceTile tiles(example, coordinates);
  const Eigen::ArrayXf weights = WeightsOfExample(tiles, example.Count(), completeness, progress);
  std::vector<Index> nearest(static_cast<std::size_t>(coordinates.rows()), 0);
  ParallelTasks(
    tiles.RowTiles(),
    [&](std::int64_t task) {
      DistanceTile::Array distances;
      std::vector<float> least(static_cast<std::size_t>(TileRows), std::numeric_limits<float>::infinity());
      for (std::int64_t tile = 0; tile < tiles.ColumnTiles(); ++tile)
      {
        tiles.Compute(task, tile, distances);
        const auto ofTile = weights.segment(tile * TileColumns, distances.cols()).transpose();
        for (Eigen::Index r = 0; r < distances.rows(); ++r)
        {
          distances.row(r) *= ofTile;
          const float best = distances.row(r).minCoeff();
          if (best < least[static_cast<std::size_t>(r)])
          {
            Eigen::Index column = 0;
            least[static_cast<std::size_t>(r)] = distances.row(r).minCoeff(&column);
            nearest[static_cast<std::size_t>(task * TileRows + r)] = static_cast<Index>(tile * TileColumns + column);
          }
        }
      }
    },
    [&] { Report(progress, 0.5); });
  return nearest;
}

} // namespace surfsynth
