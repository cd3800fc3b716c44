// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Layers/DensePoisson.h"

#include <algorithm>

namespace surfsynth
{

void UseDenseInverse(MeshTensors& mesh)
{
  constexpr std::int64_t ColumnsAtOnce = 256;
  const torch::NoGradGuard noGradients;
  const std::int64_t vertices = mesh.VertexMass.size(0);
  const torch::Tensor inverse = torch::empty({ vertices, vertices }, torch::kFloat32);
  for (std::int64_t first = 0; first < vertices; first += ColumnsAtOnce)
  {
    const std::int64_t count = std::min(ColumnsAtOnce, vertices - first);
    RowMatrix columns = RowMatrix::Constant(vertices, count, -1.0 / static_cast<double>(vertices));
    for (std::int64_t k = 0; k < count; ++k)
    {
      columns(first + k, k) += 1.0;
    }
    Eigen::Map<RowMatrix> map(columns.data(), vertices, count);
    mesh.Solver->SolveInPlace(map);
    columns.rowwise() -= columns.colwise().mean().eval();
    const torch::Tensor solved = torch::from_blob(columns.data(), { vertices, count }, torch::kFloat64);
    inverse.slice(1, first, first + count).copy_(solved);
  }
  mesh.DenseInverse = inverse.to(mesh.VertexMass.device());
}

} // namespace surfsynth
