// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/PoissonNet/FacePatches.h"

#include <algorithm>
#include <numeric>

namespace surfsynth
{

namespace
{
/// Sorts faces into patches by halving along the longest extent of their centres.
class Bisection
{
public:
  Bisection(const TriangleMatrix& triangles, const PointMatrix& points, std::int64_t largest)
    : Order(static_cast<std::size_t>(triangles.rows()))
    , Largest(largest)
    , Centers(triangles.rows(), 3)
  {
    std::iota(this->Order.begin(), this->Order.end(), 0);
    for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    {
      this->Centers.row(f) = points.row(triangles(f, 0)) + points.row(triangles(f, 1)) + points.row(triangles(f, 2));
    }
    this->Halve(0, triangles.rows());
    this->Starts.push_back(triangles.rows());
  }

  std::vector<Index> Order;
  std::vector<std::int64_t> Starts;

private:
  void Halve(std::int64_t begin, std::int64_t end)
  {
    if (end - begin <= this->Largest)
    {
      if (end > begin)
      {
        std::sort(this->Order.begin() + begin, this->Order.begin() + end);
        this->Starts.push_back(begin);
      }
      return;
    }
    Eigen::RowVector3d lower = this->Centers.row(this->Order[begin]);
    Eigen::RowVector3d upper = lower;
    for (std::int64_t k = begin; k < end; ++k)
    {
      lower = lower.cwiseMin(this->Centers.row(this->Order[k]));
      upper = upper.cwiseMax(this->Centers.row(this->Order[k]));
    }
    Eigen::Index axis = 0;
    (upper - lower).maxCoeff(&axis);
    const std::int64_t middle = begin + (end - begin) / 2;
    // Ids decide between equal centres, so that the patches do not depend on the algorithm of the standard library.
    std::nth_element(
      this->Order.begin() + begin, this->Order.begin() + middle, this->Order.begin() + end, [&](Index a, Index b) {
        return std::make_pair(this->Centers(a, axis), a) < std::make_pair(this->Centers(b, axis), b);
      });
    this->Halve(begin, middle);
    this->Halve(middle, end);
  }

  std::int64_t Largest;
  PointMatrix Centers;
};

/// Numbers the vertices of each patch in the order in which its faces name them.
void NumberVertices(FacePatches& patches, Index points)
{
  std::vector<Index> local(static_cast<std::size_t>(points), -1);
  patches.LocalCorners.resize(patches.Corners.size());
  patches.VertexStart.assign(1, 0);
  for (std::int64_t p = 0; p < patches.Count(); ++p)
  {
    const std::size_t first = patches.Vertices.size();
    for (std::int64_t k = 3 * patches.FaceStart[p]; k < 3 * patches.FaceStart[p + 1]; ++k)
    {
      const Index v = patches.Corners[k];
      if (local[v] < 0)
      {
        local[v] = static_cast<Index>(patches.Vertices.size() - first);
        patches.Vertices.push_back(v);
      }
      patches.LocalCorners[k] = local[v];
    }
    std::for_each(patches.Vertices.begin() + static_cast<std::ptrdiff_t>(first), patches.Vertices.end(),
      [&](Index v) { local[v] = -1; });
    patches.VertexStart.push_back(static_cast<std::int64_t>(patches.Vertices.size()));
  }
}

void AssignSlots(FacePatches& patches, Index points)
{
  std::vector<Index> count(static_cast<std::size_t>(points), 0);
  for (const Index v : patches.Vertices)
  {
    ++count[v];
  }
  std::vector<std::int64_t> next(static_cast<std::size_t>(points), -1);
  patches.SlotStart.assign(1, 0);
  for (Index v = 0; v < points; ++v)
  {
    if (count[v] > 1)
    {
      next[v] = patches.SlotStart.back();
      patches.SharedVertices.push_back(v);
      patches.SlotStart.push_back(next[v] + count[v]);
    }
  }
  patches.Slot.reserve(patches.Vertices.size());
  for (const Index v : patches.Vertices)
  {
    patches.Slot.push_back(next[v] < 0 ? -1 : next[v]++);
  }
}
} // namespace

FacePatches CutIntoPatches(const PoissonOperators& operators, const PointMatrix& points, std::int64_t largest)
{
  Bisection bisection(operators.Triangles, points, largest);
  FacePatches patches;
  patches.FaceStart = std::move(bisection.Starts);
  patches.FaceOfPlace = std::move(bisection.Order);
  for (const Index f : patches.FaceOfPlace)
  {
    const auto corners = operators.Triangles.row(f);
    const auto basisGradients = operators.Gradient.row(f);
    patches.Corners.insert(patches.Corners.end(), corners.data(), corners.data() + 3);
    patches.BasisGradients.insert(patches.BasisGradients.end(), basisGradients.data(), basisGradients.data() + 6);
    patches.Areas.push_back(operators.FaceAreas[f]);
  }
  NumberVertices(patches, operators.NumberOfPoints());
  AssignSlots(patches, operators.NumberOfPoints());
  return patches;
}

} // namespace surfsynth
