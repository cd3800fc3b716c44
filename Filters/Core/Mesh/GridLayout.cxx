// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Mesh/GridLayout.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace surfsynth
{

namespace
{
/// Width : height that the automatic number of columns aims at: that of a screen or a slide.
constexpr double WantedAspect = 1.6;

void Check(const std::vector<BoundingBox>& boxes, const GridLayoutOptions& options)
{
  if (options.Columns < 0)
  {
    throw InvalidInput(
      "LayOutInGrid: the number of columns is " + std::to_string(options.Columns) + "; expected at least 0.");
  }
  if (!(options.Spacing >= 0.0) || !std::isfinite(options.Spacing))
  {
    throw InvalidInput(
      "LayOutInGrid: the spacing is " + FormatNumber(options.Spacing) + "; expected a number of at least 0.");
  }
  const auto isAxis = [](int axis) { return axis >= 0 && axis < 3; };
  if (!isAxis(options.Across) || !isAxis(options.Down) || options.Across == options.Down)
  {
    throw InvalidInput("LayOutInGrid: the axes are " + std::to_string(options.Across) + " and " +
      std::to_string(options.Down) + "; expected two of 0, 1 and 2.");
  }
  for (std::size_t k = 0; k < boxes.size(); ++k)
  {
    const bool isFinite = boxes[k].Lower.allFinite() && boxes[k].Upper.allFinite();
    if (!isFinite || (boxes[k].Upper - boxes[k].Lower).minCoeff() < 0.0)
    {
      throw InvalidInput("LayOutInGrid: box " + std::to_string(k) + " is not finite; expected finite points.");
    }
  }
}

/// The cells along one axis: their centers, the first at 0.
std::vector<double> CellCenters(const std::vector<double>& sizes, double gap)
{
  std::vector<double> centers(sizes.size(), 0.0);
  for (std::size_t k = 1; k < sizes.size(); ++k)
  {
    centers[k] = centers[k - 1] + 0.5 * (sizes[k - 1] + sizes[k]) + gap;
  }
  return centers;
}

/// Largest size along @p axis of the boxes in each of @p cells cells; @p cellOf gives the cell of a box.
template <typename CellOf>
std::vector<double> CellSizes(
  const std::vector<BoundingBox>& boxes, int axis, std::size_t cells, bool even, const CellOf& cellOf)
{
  std::vector<double> sizes(cells, 0.0);
  for (std::size_t k = 0; k < boxes.size(); ++k)
  {
    double& size = sizes[cellOf(k)];
    size = std::max(size, boxes[k].Upper[axis] - boxes[k].Lower[axis]);
  }
  if (even)
  {
    std::fill(sizes.begin(), sizes.end(), *std::max_element(sizes.begin(), sizes.end()));
  }
  return sizes;
}

/// The number of columns whose grid of cells of one size is nearest to the wanted aspect, with few empty cells.
std::size_t AutomaticColumns(std::size_t count, double width, double height)
{
  if (!(width > 0.0) || !(height > 0.0))
  {
    return count;
  }
  std::size_t best = 1;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t columns = 1; columns <= count; ++columns)
  {
    const std::size_t rows = (count + columns - 1) / columns;
    const double aspect = static_cast<double>(columns) * width / (static_cast<double>(rows) * height);
    const double empty = 1.0 - static_cast<double>(count) / static_cast<double>(rows * columns);
    const double cost = std::abs(std::log(aspect / WantedAspect)) + empty;
    if (cost < least)
    {
      least = cost;
      best = columns;
    }
  }
  return best;
}
} // namespace

std::vector<Eigen::Vector3d> LayOutInGrid(const std::vector<BoundingBox>& boxes, const GridLayoutOptions& options)
{
  Check(boxes, options);
  if (boxes.empty())
  {
    return {};
  }
  const int across = options.Across;
  const int down = options.Down;
  Eigen::Vector3d largest = Eigen::Vector3d::Zero();
  for (const BoundingBox& box : boxes)
  {
    largest = largest.cwiseMax(box.Upper - box.Lower);
  }
  const Eigen::Vector3d gap = options.Spacing * largest;
  const std::size_t columns = options.Columns > 0
    ? std::min(static_cast<std::size_t>(options.Columns), boxes.size())
    : AutomaticColumns(boxes.size(), largest[across] + gap[across], largest[down] + gap[down]);
  const std::size_t rows = (boxes.size() + columns - 1) / columns;
  const auto columnOf = [columns](std::size_t k) { return k % columns; };
  const auto rowOf = [columns](std::size_t k) { return k / columns; };
  const bool even = !options.Center;
  const std::vector<double> x = CellCenters(CellSizes(boxes, across, columns, even, columnOf), gap[across]);
  const std::vector<double> y = CellCenters(CellSizes(boxes, down, rows, even, rowOf), gap[down]);

  const Eigen::Vector3d first = 0.5 * (boxes[0].Lower + boxes[0].Upper);
  std::vector<Eigen::Vector3d> translations(boxes.size(), Eigen::Vector3d::Zero());
  for (std::size_t k = 1; k < boxes.size(); ++k)
  {
    if (options.Center)
    {
      translations[k] = first - 0.5 * (boxes[k].Lower + boxes[k].Upper);
    }
    translations[k][across] += x[columnOf(k)];
    translations[k][down] -= y[rowOf(k)];
  }
  return translations;
}

} // namespace surfsynth
