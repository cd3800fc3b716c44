// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/GeometricTexture/ExampleBlend.h"

#include "Core/Operators/SurfaceOperators.h"
#include "Core/Solvers/SurfaceSmoothing.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <utility>

namespace surfsynth
{

namespace
{
/// Thresholds lie so far from 0 and 1, which are shares without an island.
constexpr double Margin = 1e-6;
/// Length of the operator over that of BlendThresholds().
constexpr double OperatorLength = 0.3;
} // namespace

Eigen::VectorXf BlendThresholds(const PatchSurface& surface, double length, const NormalKey& key)
{
  const Index points = surface.Mesh.NumberOfPoints();
  const Eigen::VectorXd mass = LumpedMass(surface.Mesh, surface.Topology);
  RowMatrix numbers(points, 1);
  FillNormals(key, 0, points, numbers.data());
  // White noise of the surface: its integrals over equal areas deviate equally, whatever the triangles are.
  numbers = (mass.array() > 0.0).select(numbers.array() / mass.array().sqrt(), 0.0);
  const SurfaceSmoothing smoothing(
    surface.Mesh, surface.Topology, OperatorLength * std::min(length, std::sqrt(mass.sum())));
  numbers = smoothing.Apply(smoothing.Apply(numbers));
  std::vector<Index> order(static_cast<std::size_t>(points));
  std::iota(order.begin(), order.end(), Index{ 0 });
  std::sort(order.begin(), order.end(),
    [&](Index a, Index b) { return std::make_pair(numbers(a, 0), a) < std::make_pair(numbers(b, 0), b); });
  Eigen::VectorXf thresholds(points);
  double below = 0.0;
  for (const Index v : order)
  {
    thresholds(v) = static_cast<float>(std::clamp((below + 0.5 * mass(v)) / mass.sum(), Margin, 1.0 - Margin));
    below += mass(v);
  }
  return thresholds;
}

std::vector<PatchCenter> CentersOfShare(const PatchSurface& surface, const std::vector<PatchCenter>& centers,
  const Eigen::VectorXf& thresholds, const Eigen::VectorXf& shares, bool second)
{
  std::vector<PatchCenter> kept;
  std::copy_if(centers.begin(), centers.end(), std::back_inserter(kept), [&](const PatchCenter& center) {
    const auto corners = surface.Mesh.Triangles.row(center.Place.Triangle);
    double excess = 0.0;
    for (int k = 0; k < 3; ++k)
    {
      excess += center.Place.Weights(k) * static_cast<double>(shares(corners(k)) - thresholds(corners(k)));
    }
    return (excess > 0.0) == second;
  });
  return kept;
}

} // namespace surfsynth
