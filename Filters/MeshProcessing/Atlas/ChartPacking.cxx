// SPDX-License-Identifier: BSD-3-Clause
#include "MeshProcessing/Atlas/ChartPacking.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <utility>

namespace surfsynth
{

namespace
{
constexpr double Pi = 3.14159265358979323846;
constexpr int NumberOfTurns = 60; // of a half turn
/// Steps of the bisection for the scale: to a thousandth.
constexpr int NumberOfBisections = 12;

/// Lowest free row above each range of columns.
class Skyline
{
public:
  explicit Skyline(std::int64_t width)
    : Width(width)
    , Steps{ { 0, 0 } }
  {}

  /// Finds the lowest, then leftmost place of a box and raises the skyline there.
  /// @return its lower left texel; negative when it does not fit.
  std::pair<std::int64_t, std::int64_t> Place(std::int64_t width, std::int64_t height, std::int64_t top)
  {
    std::pair<std::int64_t, std::int64_t> best(-1, std::numeric_limits<std::int64_t>::max());
    for (std::size_t k = 0; k < this->Steps.size() && this->Steps[k].Start + width <= this->Width; ++k)
    {
      const std::int64_t row = this->RowAbove(k, width, best.second);
      best = row < best.second ? std::make_pair(this->Steps[k].Start, row) : best;
    }
    if (best.first < 0 || best.second + height > top)
    {
      return { -1, -1 };
    }
    this->Raise(best.first, best.first + width, best.second + height);
    return best;
  }

private:
  /// A range of columns up to the start of the next one.
  struct Step
  {
    std::int64_t Start;
    std::int64_t Row;
  };

  /// Highest row below a box that starts at step @p k; @p limit or more ends the search.
  std::int64_t RowAbove(std::size_t k, std::int64_t width, std::int64_t limit) const
  {
    const std::int64_t end = this->Steps[k].Start + width;
    std::int64_t row = 0;
    for (; k < this->Steps.size() && this->Steps[k].Start < end && row < limit; ++k)
    {
      row = std::max(row, this->Steps[k].Row);
    }
    return row;
  }

  void Raise(std::int64_t begin, std::int64_t end, std::int64_t row)
  {
    std::int64_t after = 0;
    std::vector<Step> steps;
    for (const Step& step : this->Steps)
    {
      after = step.Start <= end ? step.Row : after;
      if (step.Start < begin)
      {
        steps.push_back(step);
      }
    }
    steps.push_back({ begin, row });
    if (end < this->Width)
    {
      steps.push_back({ end, after });
    }
    std::copy_if(this->Steps.begin(), this->Steps.end(), std::back_inserter(steps),
      [end](const Step& step) { return step.Start > end; });
    this->Steps = std::move(steps);
  }

  std::int64_t Width;
  std::vector<Step> Steps;
};

/// Packs the boxes at one scale; false when they do not fit.
bool PackAt(double scale, const std::vector<Eigen::Vector2d>& sizes, const std::vector<std::size_t>& order,
  const Eigen::Vector2i& image, int margin, std::vector<Eigen::Vector2d>& corners)
{
  Skyline skyline(image.x());
  corners.resize(sizes.size());
  for (const std::size_t k : order)
  {
    const Eigen::Vector2d size = scale * sizes[k];
    if (size.maxCoeff() > image.maxCoeff())
    {
      return false;
    }
    const auto [column, row] = skyline.Place(static_cast<std::int64_t>(std::ceil(size.x())) + margin,
      static_cast<std::int64_t>(std::ceil(size.y())) + margin, image.y());
    if (column < 0)
    {
      return false;
    }
    corners[k] = Eigen::Vector2d(static_cast<double>(column), static_cast<double>(row)).array() + 0.5 * margin;
  }
  return true;
}
} // namespace

void TurnToSmallestBox(FlatPoints& flat)
{
  double least = std::numeric_limits<double>::infinity();
  FlatPoints best;
  for (int k = 0; k < NumberOfTurns; ++k)
  {
    const double angle = Pi * k / NumberOfTurns;
    Eigen::Matrix2d turn;
    turn << std::cos(angle), std::sin(angle), -std::sin(angle), std::cos(angle);
    const FlatPoints turned = flat * turn;
    const Eigen::RowVector2d size = turned.colwise().maxCoeff() - turned.colwise().minCoeff();
    if (size.y() >= size.x() && size.prod() < least)
    {
      least = size.prod();
      best = turned;
    }
  }
  flat = best.rowwise() - best.colwise().minCoeff();
}

BoxPacking PackBoxes(const std::vector<Eigen::Vector2d>& sizes, int width, int height, int margin)
{
  std::vector<std::size_t> order(sizes.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(
    order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return sizes[a].y() > sizes[b].y(); });
  const double area = std::accumulate(
    sizes.begin(), sizes.end(), 0.0, [](double sum, const Eigen::Vector2d& size) { return sum + size.prod(); });
  const Eigen::Vector2i image(width, height);
  BoxPacking packing;
  std::vector<Eigen::Vector2d> corners;
  // At the scale of equal areas nothing fits. Small scales are tried until the margins leave no room.
  double above = std::sqrt(static_cast<double>(width) * height / area);
  double below = 0.5 * above;
  for (int k = 0; k < 20 && packing.Scale == 0.0; ++k)
  {
    if (PackAt(below, sizes, order, image, margin, corners))
    {
      packing = { below, corners };
      break;
    }
    above = below;
    below *= 0.5;
  }
  for (int k = 0; k < NumberOfBisections && packing.Scale > 0.0; ++k)
  {
    const double middle = 0.5 * (packing.Scale + above);
    if (PackAt(middle, sizes, order, image, margin, corners))
    {
      packing = { middle, corners };
      continue;
    }
    above = middle;
  }
  return packing;
}

} // namespace surfsynth
