// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Layers/FusedSteps.h"

#include "Core/Common/ScratchPool.h"
#include "Learning/Layers/FusedPoisson.h"

namespace surfsynth
{

namespace
{
ScratchPool<LargeArray<float>>& TilePool()
{
  static ScratchPool<LargeArray<float>> pool;
  return pool;
}

/// Vertices that no face uses, ascending.
std::vector<Index> UnusedVertices(const PoissonOperators& operators)
{
  std::vector<bool> used(static_cast<std::size_t>(operators.NumberOfPoints()), false);
  std::for_each(operators.Triangles.data(), operators.Triangles.data() + operators.Triangles.size(),
    [&](Index v) { used[static_cast<std::size_t>(v)] = true; });
  std::vector<Index> unused;
  for (Index v = 0; v < operators.NumberOfPoints(); ++v)
  {
    if (!used[static_cast<std::size_t>(v)])
    {
      unused.push_back(v);
    }
  }
  return unused;
}

/// Positions for the partition: those of the mesh, or the numbers of the vertices.
PointMatrix PlacesOf(const PoissonOperators& operators, const PointMatrix& points)
{
  if (points.rows() == operators.NumberOfPoints())
  {
    return points;
  }
  PointMatrix places = PointMatrix::Zero(operators.NumberOfPoints(), 3);
  places.col(0).setLinSpaced(0.0, 1.0);
  return places;
}
} // namespace

TileScratch::TileScratch(std::int64_t size)
  : Values(TilePool().Borrow())
{
  if (static_cast<std::int64_t>(this->Values.size()) < size)
  {
    this->Values = LargeArray<float>(static_cast<std::size_t>(size));
  }
}

TileScratch::~TileScratch() { TilePool().Return(std::move(this->Values)); }

PartSums::PartSums(const std::vector<torch::Tensor>& weights)
{
  for (const torch::Tensor& weight : weights)
  {
    std::vector<std::int64_t> shape = { StepParts };
    if (IsPresent(weight))
    {
      shape.insert(shape.end(), weight.sizes().begin(), weight.sizes().end());
    }
    this->Sums.push_back(IsPresent(weight) ? torch::zeros(shape, weight.options()) : torch::Tensor());
  }
}

float* PartSums::Of(std::size_t number, std::int64_t part) const
{
  const torch::Tensor& sums = this->Sums[number];
  return IsPresent(sums) ? sums.data_ptr<float>() + part * (sums.numel() / StepParts) : nullptr;
}

torch::Tensor PartSums::Total(std::size_t number) const
{
  return this->Sums[number].defined() ? this->Sums[number].sum(0) : torch::Tensor();
}

PoissonTables::PoissonTables(const PoissonOperators& operators, const PointMatrix& points)
  : Patches(CutIntoPatches(operators, PlacesOf(operators, points)))
  , Solver(operators.Solver)
  , Mass(operators.VertexMass.cast<double>())
  , Unused(UnusedVertices(operators))
{}

} // namespace surfsynth
