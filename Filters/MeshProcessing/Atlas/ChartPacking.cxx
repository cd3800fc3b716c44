// SPDX-License-Identifier: BSD-3-Clause
#include "MeshProcessing/Atlas/ChartPacking.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace surfsynth
{

namespace
{
constexpr double Pi = 3.14159265358979323846;
constexpr int NumberOfTurns = 30; // of a quarter turn, and again of a step
constexpr int MostCells = 1024;
/// Halvings until a scale is found at which the charts fit, and bisections after that.
constexpr int NumberOfHalvings = 20;
constexpr int NumberOfBisections = 10;

/// Lower and upper side of a chart with half of the margin around it, in whole cells, for each of its columns.
struct ChartProfile
{
  std::vector<int> Lower; ///< lowest row that the chart touches
  std::vector<int> Upper; ///< first row above it
  int Height = 0;         ///< largest of Upper

  /// @param scale cells / unit
  /// @param margin cells
  ChartProfile(const ChartShape& chart, double scale, double margin)
  {
    const FlatPoints& points = *chart.Points;
    const Eigen::RowVector2d size = scale * points.colwise().maxCoeff();
    const auto columns = static_cast<std::size_t>(std::max(1.0, std::ceil(size.x() + margin)));
    this->Lower.assign(columns, std::numeric_limits<int>::max());
    this->Upper.assign(columns, 0);
    for (Eigen::Index f = 0; f < chart.Triangles->rows(); ++f)
    {
      for (int k = 0; k < 3; ++k)
      {
        this->Add(
          scale * points.row((*chart.Triangles)(f, k)), scale * points.row((*chart.Triangles)(f, (k + 1) % 3)), margin);
      }
    }
    this->Height = *std::max_element(this->Upper.begin(), this->Upper.end());
  }

  /// Turns the chart by 180 degrees within @p height rows, which it must not exceed.
  void TurnOver(int height)
  {
    std::reverse(this->Lower.begin(), this->Lower.end());
    std::reverse(this->Upper.begin(), this->Upper.end());
    std::swap(this->Lower, this->Upper);
    for (std::size_t k = 0; k < this->Lower.size(); ++k)
    {
      this->Lower[k] = height - this->Lower[k];
      this->Upper[k] = height - this->Upper[k];
    }
    this->Height = *std::max_element(this->Upper.begin(), this->Upper.end());
  }

private:
  /// Adds a side from @p p to @p q, half a margin thick on all sides. The chart lies half a margin from the origin.
  void Add(Eigen::RowVector2d p, Eigen::RowVector2d q, double margin)
  {
    if (q.x() < p.x())
    {
      std::swap(p, q);
    }
    const auto last = std::min(static_cast<int>(q.x() + margin), static_cast<int>(this->Lower.size()) - 1);
    for (auto column = static_cast<int>(p.x()); column <= last; ++column)
    {
      // The part of the side whose square of the margin's size reaches the column.
      const double width = q.x() - p.x();
      const auto share = [&](double x) { return width > 0.0 ? std::clamp((x - p.x()) / width, 0.0, 1.0) : 0.0; };
      const double first = p.y() + share(column - margin) * (q.y() - p.y());
      const double second = width > 0.0 ? p.y() + share(column + 1.0) * (q.y() - p.y()) : q.y();
      this->Lower[column] = std::min(this->Lower[column], static_cast<int>(std::min(first, second)));
      this->Upper[column] = std::max(
        this->Upper[column], static_cast<int>(std::ceil(std::max(first, second) + margin)));
    }
  }
};

/// The upper side of the charts packed so far.
class Horizon
{
public:
  Horizon(int columns, int rows)
    : Rows(static_cast<std::size_t>(columns), 0)
    , Top(rows)
  {}

  /// Lowest, then leftmost place of a chart: column and row; row Top or more when it does not fit.
  std::pair<int, int> Find(const ChartProfile& chart) const
  {
    std::pair<int, int> best(-1, this->Top);
    const int columns = static_cast<int>(chart.Lower.size());
    for (int first = 0; first + columns <= static_cast<int>(this->Rows.size()); ++first)
    {
      int row = 0;
      for (int k = 0; k < columns && row < best.second; ++k)
      {
        row = std::max(row, this->Rows[first + k] - chart.Lower[k]);
      }
      best = row < best.second ? std::make_pair(first, row) : best;
    }
    return best.second + chart.Height <= this->Top ? best : std::make_pair(-1, this->Top);
  }

  void Add(const ChartProfile& chart, const std::pair<int, int>& place)
  {
    for (std::size_t k = 0; k < chart.Upper.size(); ++k)
    {
      this->Rows[place.first + k] = place.second + chart.Upper[k];
    }
  }

private:
  std::vector<int> Rows;
  int Top;
};

/// Packs charts at one scale after another.
class ChartPacker
{
public:
  ChartPacker(const std::vector<ChartShape>& charts, int width, int height, int margin)
    : Charts(charts)
    , Cell((std::max(width, height) + MostCells - 1) / MostCells)
    , Columns(width / this->Cell)
    , Rows(height / this->Cell)
    , Margin(margin)
    , Order(charts.size())
  {
    std::iota(this->Order.begin(), this->Order.end(), 0);
    const auto heightOf = [&](std::size_t k) { return charts[k].Points->col(1).maxCoeff(); };
    std::stable_sort(
      this->Order.begin(), this->Order.end(), [&](std::size_t a, std::size_t b) { return heightOf(a) > heightOf(b); });
  }

  /// Packs the charts at @p scale texels / unit; false when they do not fit.
  bool Pack(double scale, ChartPacking& packing) const
  {
    const double margin = static_cast<double>(this->Margin) / this->Cell;
    const double cells = scale / this->Cell;
    Horizon horizon(this->Columns, this->Rows);
    packing.Scale = scale;
    packing.Corners.resize(this->Charts.size());
    packing.IsTurned.assign(this->Charts.size(), false);
    for (const std::size_t k : this->Order)
    {
      const Eigen::RowVector2d size = cells * this->Charts[k].Points->colwise().maxCoeff();
      if (size.x() + margin > this->Columns || size.y() + margin > this->Rows)
      {
        return false;
      }
      ChartProfile upright(this->Charts[k], cells, margin);
      ChartProfile turned = upright;
      const int height = upright.Height;
      turned.TurnOver(height);
      const std::pair<int, int> one = horizon.Find(upright);
      const std::pair<int, int> other = horizon.Find(turned);
      const bool turn = other.second < one.second;
      const std::pair<int, int>& place = turn ? other : one;
      if (place.first < 0)
      {
        return false;
      }
      horizon.Add(turn ? turned : upright, place);
      // Turned over, the chart keeps the rest of its last column and row on the other side.
      const Eigen::Vector2d rest(
        static_cast<double>(upright.Lower.size()) - margin - size.x(), height - margin - size.y());
      const Eigen::Vector2d at = Eigen::Vector2d(place.first, place.second) + (turn ? rest : Eigen::Vector2d(0.0, 0.0));
      packing.Corners[k] = this->Cell * at.array() + 0.5 * this->Margin;
      packing.IsTurned[k] = turn;
    }
    return true;
  }

private:
  const std::vector<ChartShape>& Charts;
  int Cell; ///< texels along a side of a cell
  int Columns;
  int Rows;
  int Margin;
  std::vector<std::size_t> Order;
};

double AreaOf(const ChartShape& chart)
{
  double area = 0.0;
  for (Eigen::Index f = 0; f < chart.Triangles->rows(); ++f)
  {
    const auto corner = [&](int k) { return chart.Points->row((*chart.Triangles)(f, k)); };
    const Eigen::RowVector2d a = corner(1) - corner(0);
    const Eigen::RowVector2d b = corner(2) - corner(0);
    area += 0.5 * (a.x() * b.y() - a.y() * b.x());
  }
  return area;
}
} // namespace

void TurnToSmallestBox(FlatPoints& flat)
{
  double least = std::numeric_limits<double>::infinity();
  double best = 0.0;
  const auto turned = [&flat](double angle) -> FlatPoints {
    Eigen::Matrix2d turn;
    turn << std::cos(angle), std::sin(angle), -std::sin(angle), std::cos(angle);
    return flat * turn;
  };
  const auto attempt = [&](double angle) {
    const FlatPoints points = turned(angle);
    const double area = (points.colwise().maxCoeff() - points.colwise().minCoeff()).prod();
    best = area < least ? angle : best;
    least = std::min(area, least);
  };
  // A quarter turn coarsely, then the neighborhood of the best one finely.
  const double step = 0.5 * Pi / NumberOfTurns;
  for (int k = 0; k < NumberOfTurns; ++k)
  {
    attempt(k * step);
  }
  const double coarse = best;
  for (int k = 1 - NumberOfTurns; k < NumberOfTurns; ++k)
  {
    attempt(coarse + k * step / NumberOfTurns);
  }
  flat = turned(best);
  flat.rowwise() -= flat.colwise().minCoeff().eval();
  const Eigen::RowVector2d size = flat.colwise().maxCoeff();
  if (size.x() > size.y())
  {
    flat.col(0).swap(flat.col(1));
    flat.col(0) = size.y() - flat.col(0).array();
  }
}

ChartPacking PackCharts(const std::vector<ChartShape>& charts, int width, int height, int margin)
{
  const ChartPacker packer(charts, width, height, margin);
  const double area = std::accumulate(
    charts.begin(), charts.end(), 0.0, [](double sum, const ChartShape& chart) { return sum + AreaOf(chart); });
  // At the scale at which the charts have the area of the image nothing fits.
  double above = std::sqrt(static_cast<double>(width) * height / area);
  double below = 0.7 * above;
  ChartPacking trial;
  int halvings = 0;
  for (; halvings < NumberOfHalvings && !packer.Pack(below, trial); ++halvings)
  {
    above = below;
    below *= 0.5;
  }
  if (halvings == NumberOfHalvings)
  {
    return {};
  }
  ChartPacking packing = trial;
  for (int k = 0; k < NumberOfBisections; ++k)
  {
    const double middle = 0.5 * (packing.Scale + above);
    if (packer.Pack(middle, trial))
    {
      packing = trial;
      continue;
    }
    above = middle;
  }
  return packing;
}

} // namespace surfsynth
