// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Elasticity/NodeMatrix.h"

#include <algorithm>

namespace surfsynth
{

namespace
{
/// Neighbors of each node, ascending, itself among them.
std::vector<std::vector<Index>> NeighborsOf(const TetrahedralMesh& mesh, const std::vector<NodePair>& pairs)
{
  std::vector<std::vector<Index>> neighbors(static_cast<std::size_t>(mesh.NumberOfPoints()));
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    neighbors[v].push_back(v);
  }
  for (Index t = 0; t < mesh.NumberOfTetrahedra(); ++t)
  {
    for (int a = 0; a < 4; ++a)
    {
      for (int b = 0; b < 4; ++b)
      {
        neighbors[mesh.Tetrahedra(t, a)].push_back(mesh.Tetrahedra(t, b));
      }
    }
  }
  for (const auto& [a, b] : pairs)
  {
    neighbors[a].push_back(b);
    neighbors[b].push_back(a);
  }
  for (std::vector<Index>& row : neighbors)
  {
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
  }
  return neighbors;
}
} // namespace

NodeMatrix::NodeMatrix(const TetrahedralMesh& mesh, const std::vector<NodePair>& pairs)
  : Nodes(mesh.Tetrahedra)
  , Start(1, 0)
{
  for (const std::vector<Index>& row : NeighborsOf(mesh, pairs))
  {
    this->Neighbors.insert(this->Neighbors.end(), row.begin(), row.end());
    this->Start.push_back(static_cast<Index>(this->Neighbors.size()));
  }
  const Eigen::Index size = 3 * Eigen::Index(mesh.NumberOfPoints());
  this->Entries.resize(size, size);
  this->Entries.resizeNonZeros(9 * static_cast<Eigen::Index>(this->Neighbors.size()));
  Index* inner = this->Entries.innerIndexPtr();
  Index* outer = this->Entries.outerIndexPtr();
  Index place = 0;
  for (Index column = 0; column < size; ++column)
  {
    outer[column] = place;
    for (Index k = this->Start[column / 3]; k < this->Start[column / 3 + 1]; ++k)
    {
      for (Index row = 0; row < 3; ++row)
      {
        inner[place++] = 3 * this->Neighbors[k] + row;
      }
    }
  }
  outer[size] = place;
  this->Corners.resize(static_cast<std::size_t>(mesh.NumberOfTetrahedra()));
  for (Index t = 0; t < mesh.NumberOfTetrahedra(); ++t)
  {
    for (int corner = 0; corner < 16; ++corner)
    {
      this->Corners[t][corner] = this->Place(mesh.Tetrahedra(t, corner / 4), mesh.Tetrahedra(t, corner % 4));
    }
  }
  this->SetZero();
}

int NodeMatrix::Place(Index a, Index b) const
{
  const auto first = this->Neighbors.begin() + this->Start[b];
  const auto found = std::lower_bound(first, this->Neighbors.begin() + this->Start[b + 1], a);
  return this->Entries.outerIndexPtr()[3 * b] + 3 * static_cast<int>(found - first);
}

bool NodeMatrix::Has(Index a, Index b) const
{
  return std::binary_search(this->Neighbors.begin() + this->Start[b], this->Neighbors.begin() + this->Start[b + 1], a);
}

void NodeMatrix::Fix(const std::vector<bool>& isFixed, double scale)
{
  for (Index column = 0; column < this->Entries.cols(); ++column)
  {
    for (SparseMatrix::InnerIterator entry(this->Entries, column); entry; ++entry)
    {
      if (isFixed[column / 3] || isFixed[entry.row() / 3])
      {
        entry.valueRef() = entry.row() == column ? scale : 0.0;
      }
    }
  }
}

} // namespace surfsynth
