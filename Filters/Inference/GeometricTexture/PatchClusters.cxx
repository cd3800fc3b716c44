// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/GeometricTexture/PatchClusters.h"

#include "Core/Random/CounterUniforms.h"
#include "Inference/GeometricTexture/NearestPatches.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace surfsynth
{

namespace
{
/// Patches of a cluster in the mean.
constexpr std::int64_t PatchesOfCluster = 256;
/// Rounds that compute the means, and the distance of the patches that they are computed from: no multiple of the four turns of
/// a patch.
constexpr int Rounds = 8;
constexpr std::int64_t Stride = 5;

/// Returns for each patch the number of the nearest mean. @param means [D, K]
std::vector<Index> NearestMeans(
  const Eigen::MatrixXf& means, const ExamplePatches::Rows& coordinates, const Progress& progress)
{
  ExamplePatches centers;
  centers.Values.resize(means.cols(), 0);
  centers.Coordinates = means;
  centers.Squares = means.colwise().squaredNorm().transpose();
  return NearestPatches(centers).Find(coordinates, progress);
}

/// Computes means of clusters from a sample of the patches. @param sample [n, D]
Eigen::MatrixXf ClusterMeans(
  const ExamplePatches::Rows& sample, std::int64_t count, const NormalKey& key, const Progress& progress)
{
  Eigen::MatrixXf means(sample.cols(), count);
  for (std::int64_t k = 0; k < count; ++k)
  {
    means.col(k) = sample.row(UniformIndex(key, k, sample.rows())).transpose();
  }
  for (int round = 0; round < Rounds; ++round)
  {
    const std::vector<Index> nearest = NearestMeans(means, sample, progress);
    Eigen::MatrixXf sums = Eigen::MatrixXf::Zero(means.rows(), means.cols());
    Eigen::VectorXf counts = Eigen::VectorXf::Zero(means.cols());
    for (Eigen::Index r = 0; r < sample.rows(); ++r)
    {
      const Index k = nearest[static_cast<std::size_t>(r)];
      sums.col(k) += sample.row(r).transpose();
      counts(k) += 1.0F;
    }
    for (Eigen::Index k = 0; k < means.cols(); ++k)
    {
      if (counts(k) > 0.0F)
      {
        means.col(k) = sums.col(k) / counts(k);
      }
    }
  }
  return means;
}

/// Returns the rows in an order.
ExamplePatches::Rows SortedRows(const ExamplePatches::Rows& rows, const std::vector<Index>& order)
{
  ExamplePatches::Rows sorted(rows.rows(), rows.cols());
  for (std::size_t r = 0; r < order.size(); ++r)
  {
    sorted.row(static_cast<Eigen::Index>(r)) = rows.row(order[r]);
  }
  return sorted;
}
} // namespace

void SortIntoClusters(ExamplePatches& scale, const NormalKey& key, const Progress& progress)
{
  const std::int64_t patches = scale.Count();
  const std::int64_t count = (patches + PatchesOfCluster - 1) / PatchesOfCluster;
  const ExamplePatches::Rows coordinates = scale.Coordinates.transpose();
  const ExamplePatches::Rows sample = coordinates(Eigen::seq(0, Eigen::last, Stride), Eigen::all);
  const std::vector<Index> clusters = NearestMeans(ClusterMeans(sample, count, key, progress), coordinates, progress);
  std::vector<Index> order(static_cast<std::size_t>(patches));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
    [&](Index a, Index b) { return clusters[static_cast<std::size_t>(a)] < clusters[static_cast<std::size_t>(b)]; });
  scale.Clusters = { 0 };
  for (std::size_t k = 1; k < order.size(); ++k)
  {
    if (clusters[static_cast<std::size_t>(order[k])] != clusters[static_cast<std::size_t>(order[k - 1])])
    {
      scale.Clusters.push_back(static_cast<Index>(k));
    }
  }
  scale.Clusters.push_back(static_cast<Index>(patches));
  scale.Values = SortedRows(scale.Values, order);
  scale.Coordinates = SortedRows(coordinates, order).transpose();
  scale.Squares = scale.Coordinates.colwise().squaredNorm().transpose();
}

} // namespace surfsynth
