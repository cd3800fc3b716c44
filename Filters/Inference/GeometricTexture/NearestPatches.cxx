// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/GeometricTexture/NearestPatches.h"

#include "Core/Common/Parallel.h"
#include "Inference/Common/MatrixProduct.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace surfsynth
{

namespace
{
/// Patches whose distances from all clusters are computed at a time.
constexpr std::int64_t BlockRows = 16384;
/// Patches and patches of the example of a tile: its distances stay in the cache of a core.
constexpr std::int64_t TileRows = 128, TileColumns = 512;
/// Fewest patches that each cluster is compared with, for the smallest distance of each patch of the example.
constexpr std::int64_t FewestRows = 64;
constexpr float Infinity = std::numeric_limits<float>::infinity();

using Distances = Eigen::Array<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Distance and number of a patch.
using Match = std::pair<float, Index>;

/// Returns the numbers of the @p count least of some numbers, in ascending order.
std::vector<Index> NumbersOfLeast(const Eigen::Ref<const Eigen::ArrayXf>& numbers, std::int64_t count)
{
  std::vector<Match> least; // sorted; equal numbers that come later are no less
  least.reserve(static_cast<std::size_t>(count) + 1);
  for (Eigen::Index k = 0; k < numbers.size(); ++k)
  {
    if (static_cast<std::int64_t>(least.size()) < count || numbers(k) < least.back().first)
    {
      const Match match(numbers(k), static_cast<Index>(k));
      least.insert(std::upper_bound(least.begin(), least.end(), match), match);
      least.resize(std::min(least.size(), static_cast<std::size_t>(count)));
    }
  }
  std::vector<Index> found(least.size());
  std::transform(least.begin(), least.end(), found.begin(), [](const Match& m) { return m.second; });
  std::sort(found.begin(), found.end());
  return found;
}

/// Puts the least of some distances into @p best where it is less. @param first number of the first one
void Improve(const float* distances, std::int64_t count, std::int64_t first, Match& best)
{
  constexpr std::int64_t part = 32; // whose least is found in vectors
  for (std::int64_t begin = 0; begin < count; begin += part)
  {
    const float* own = distances + begin;
    const std::int64_t size = std::min(part, count - begin);
    const float least = size == part ? Eigen::Map<const Eigen::Array<float, part, 1>>(own).minCoeff()
                                     : *std::min_element(own, own + size);
    if (least < best.first)
    {
      best = { least, static_cast<Index>(first + begin + (std::find(own, own + size, least) - own)) };
    }
  }
}

/// Consecutive patches of the example: those of a cluster, or a part of them.
struct Columns
{
  std::int64_t Cluster, First, Last;
};

/// Patches that are compared with a cluster, at most TileRows.
struct Comparison
{
  std::int64_t Cluster;
  std::vector<Index> Entries; ///< patch times the number of clusters for each, and a number below that
};

/// Chooses for each patch the @p count clusters that are nearest to it, and sorts by them. @param means [n, K], of the distances
std::vector<Comparison> Compare(const Distances& means, std::int64_t count)
{
  std::vector<Index> chosen(static_cast<std::size_t>(means.rows() * count));
  ParallelFor(means.rows(), 64, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t r = begin; r < end; ++r)
    {
      const std::vector<Index> least = NumbersOfLeast(means.row(r).transpose(), count);
      std::copy(least.begin(), least.end(), chosen.begin() + r * count);
    }
  });
  std::vector<std::vector<Index>> entries(static_cast<std::size_t>(means.cols()));
  for (std::size_t e = 0; e < chosen.size(); ++e)
  {
    entries[static_cast<std::size_t>(chosen[e])].push_back(static_cast<Index>(e));
  }
  std::vector<Comparison> comparisons;
  for (std::size_t k = 0; k < entries.size(); ++k)
  {
    for (std::size_t first = 0; first < entries[k].size(); first += static_cast<std::size_t>(TileRows))
    {
      const std::size_t last = std::min(entries[k].size(), first + static_cast<std::size_t>(TileRows));
      comparisons.push_back({ static_cast<std::int64_t>(k),
        std::vector<Index>(entries[k].begin() + static_cast<std::ptrdiff_t>(first),
          entries[k].begin() + static_cast<std::ptrdiff_t>(last)) });
    }
  }
  return comparisons;
}
} // namespace

/// Some patches, and their weighted squared distances from those of the example.
class NearestPatches::Block
{
public:
  Block(const NearestPatches& search, const ExamplePatches::Rows& coordinates, std::int64_t first)
    : Search(search)
    , Patches(std::min(BlockRows, coordinates.rows() - first), coordinates.cols() + 2)
  {
    const auto own = coordinates.middleRows(first, this->Patches.rows());
    this->Patches << own, own.rowwise().squaredNorm(), Eigen::VectorXf::Ones(own.rows());
  }

  std::int64_t Rows() const { return this->Patches.rows(); }

  /// Computes the means of the distances from the patches of each cluster, [Rows(), K].
  Distances FromClusters(const Progress& progress) const
  {
    const ExamplePatches::Rows& means = this->Search.MeanForms;
    Distances distances(this->Rows(), means.cols());
    ParallelTasks((this->Rows() + TileRows - 1) / TileRows,
      [&](std::int64_t task) {
        const std::int64_t row = task * TileRows;
        Multiply(this->Patches.row(row).data(), means.data(), distances.row(row).data(),
          std::min(TileRows, this->Rows() - row), means.rows(), means.cols());
      },
      [&] { Report(progress, 0.0); });
    return distances;
  }

  /// Calls visit(first, distances) for all tiles of some patches of the example: the number of the first one, and distances
  /// [rows.size(), columns]. Zero may be a little less by rounding.
  /// @param rows numbers of patches, at most TileRows
  template <typename Visit>
  void ForTiles(const Columns& of, const std::vector<Index>& rows, const Visit& visit) const
  {
    const ExamplePatches::Rows chosen = this->Patches(rows, Eigen::all), &forms = this->Search.Forms;
    Distances distances;
    for (std::int64_t first = of.First; first < of.Last; first += TileColumns)
    {
      const std::int64_t columns = std::min(TileColumns, of.Last - first);
      distances.resize(chosen.rows(), columns);
      MultiplyBlocks({ chosen.data(), chosen.cols() }, { forms.data() + first, forms.cols() }, distances.data(),
        columns, chosen.rows(), chosen.cols(), columns);
      visit(first, distances);
    }
  }

private:
  const NearestPatches& Search;
  ExamplePatches::Rows Patches; ///< [n, D + 2]
};

NearestPatches::NearestPatches(const ExamplePatches& example)
  : Example(example)
  , Clusters(example.Clusters)
{
  if (this->Clusters.empty())
  {
    this->Clusters = { 0, static_cast<Index>(example.Count()) };
  }
  this->SetWeights(Eigen::ArrayXf::Ones(example.Count()));
}

void NearestPatches::SetWeights(const Eigen::ArrayXf& weights)
{
  const Eigen::Index components = this->Example.Coordinates.rows();
  this->Forms.resize(components + 2, this->Example.Count());
  this->Forms.topRows(components) = -2.0F * (this->Example.Coordinates * weights.matrix().asDiagonal());
  this->Forms.row(components) = weights.transpose();
  this->Forms.row(components + 1) = (this->Example.Squares.array() * weights).transpose();
  this->MeanForms.resize(components + 2, static_cast<Eigen::Index>(this->Clusters.size()) - 1);
  for (Eigen::Index k = 0; k < this->MeanForms.cols(); ++k)
  {
    const Index first = this->Clusters[static_cast<std::size_t>(k)],
                last = this->Clusters[static_cast<std::size_t>(k) + 1];
    this->MeanForms.col(k) = this->Forms.middleCols(first, last - first).rowwise().mean();
  }
}

void NearestPatches::Prefer(const ExamplePatches::Rows& coordinates, float completeness, const Progress& progress)
{
  this->SetWeights(Eigen::ArrayXf::Ones(this->Example.Count()));
  Eigen::ArrayXf least = Eigen::ArrayXf::Constant(this->Example.Count(), Infinity);
  std::vector<Columns> tiles;
  for (std::size_t k = 0; k + 1 < this->Clusters.size(); ++k)
  {
    for (std::int64_t first = this->Clusters[k]; first < this->Clusters[k + 1]; first += TileColumns)
    {
      tiles.push_back(
        { static_cast<std::int64_t>(k), first, std::min<std::int64_t>(first + TileColumns, this->Clusters[k + 1]) });
    }
  }
  for (std::int64_t start = 0; start < coordinates.rows(); start += BlockRows)
  {
    const Block block(*this, coordinates, start);
    const Distances means = block.FromClusters(progress);
    const std::int64_t share = (block.Rows() * NearestClusters + means.cols() - 1) / means.cols();
    const std::int64_t count = std::min(block.Rows(), std::max(FewestRows, share));
    ParallelTasks(
      static_cast<std::int64_t>(tiles.size()),
      [&](std::int64_t task) {
        const Columns& tile = tiles[static_cast<std::size_t>(task)];
        const std::vector<Index> rows = NumbersOfLeast(means.col(tile.Cluster), count);
        for (std::int64_t first = 0; first < count; first += TileRows)
        {
          const std::vector<Index> part(rows.begin() + first, rows.begin() + std::min(count, first + TileRows));
          block.ForTiles(tile, part, [&](std::int64_t column, const Distances& distances) {
            auto own = least.segment(column, distances.cols());
            own = own.min(distances.colwise().minCoeff().transpose());
          });
        }
      },
      [&] { Report(progress, 0.0); });
  }
  this->SetWeights((least.max(0.0F) + completeness).inverse());
}

std::vector<Index> NearestPatches::Find(const ExamplePatches::Rows& coordinates, const Progress& progress) const
{
  std::vector<Index> nearest;
  nearest.reserve(static_cast<std::size_t>(coordinates.rows()));
  for (std::int64_t start = 0; start < coordinates.rows(); start += BlockRows)
  {
    const std::vector<Index> found = this->FindIn(Block(*this, coordinates, start), progress);
    nearest.insert(nearest.end(), found.begin(), found.end());
  }
  return nearest;
}

std::vector<Index> NearestPatches::FindIn(const Block& block, const Progress& progress) const
{
  const Distances means = block.FromClusters(progress);
  const std::int64_t count = std::min<std::int64_t>(NearestClusters, means.cols());
  // Entry e compares patch e / count with one of its clusters.
  std::vector<Match> entries(static_cast<std::size_t>(block.Rows() * count), Match(Infinity, 0));
  const std::vector<Comparison> comparisons = Compare(means, count);
  ParallelTasks(
    static_cast<std::int64_t>(comparisons.size()),
    [&](std::int64_t task) {
      const Comparison& comparison = comparisons[static_cast<std::size_t>(task)];
      std::vector<Index> rows = comparison.Entries;
      std::transform(rows.begin(), rows.end(), rows.begin(), [&](Index e) { return static_cast<Index>(e / count); });
      const auto cluster = static_cast<std::size_t>(comparison.Cluster);
      const Columns columns{ comparison.Cluster, this->Clusters[cluster], this->Clusters[cluster + 1] };
      block.ForTiles(columns, rows, [&](std::int64_t first, const Distances& distances) {
        for (std::size_t r = 0; r < rows.size(); ++r)
        {
          Improve(distances.row(static_cast<Eigen::Index>(r)).data(), distances.cols(), first,
            entries[static_cast<std::size_t>(comparison.Entries[r])]);
        }
      });
    },
    [&] { Report(progress, 0.0); });
  std::vector<Index> nearest(static_cast<std::size_t>(block.Rows()));
  for (std::size_t r = 0; r < nearest.size(); ++r)
  {
    const auto own = entries.begin() + static_cast<std::ptrdiff_t>(r) * count;
    nearest[r] = std::min_element(own, own + count)->second;
  }
  return nearest;
}

} // namespace surfsynth
