// SPDX-License-Identifier: BSD-3-Clause
#include "Distributed/PieceMerge.h"

#include "Distributed/PointIdentity.h"

#include "Core/Common/Errors.h"
#include "Core/Random/PlaceHash.h"

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <unordered_map>

namespace surfsynth
{

namespace
{
/// Two hashes of the sorted points of a cell, which are those of no other cell for all practical purposes.
using CellKey = std::array<std::uint64_t, 2>;

CellKey KeyOf(std::vector<std::int64_t> points)
{
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  CellKey key = { 1, 2 };
  for (const std::int64_t point : points)
  {
    for (std::size_t k = 0; k < key.size(); ++k)
    {
      key[k] = HashOfPlace({ key[k], static_cast<std::uint64_t>(point), k });
    }
  }
  return key;
}

void RequireShapes(const MeshPiece& piece)
{
  const auto triangles = static_cast<std::size_t>(piece.Mesh.Triangles.rows());
  const auto points = static_cast<std::size_t>(piece.Mesh.Points.rows());
  if ((!piece.CellOfTriangle.empty() && piece.CellOfTriangle.size() != triangles) ||
    (!piece.GlobalIds.empty() && piece.GlobalIds.size() != points))
  {
    throw InvalidInput("MergePiece: the piece has " + std::to_string(points) + " points, " +
      std::to_string(piece.GlobalIds.size()) + " global ids, " + std::to_string(triangles) + " triangles and " +
      std::to_string(piece.CellOfTriangle.size()) +
      " cells; expected as many ids as points, and a cell for each triangle.");
  }
  for (Eigen::Index f = 0; f < piece.Mesh.Triangles.rows(); ++f)
  {
    if (piece.Mesh.Triangles.row(f).minCoeff() < 0 ||
      piece.Mesh.Triangles.row(f).maxCoeff() >= piece.Mesh.NumberOfPoints())
    {
      throw InvalidInput("MergePiece: triangle " + std::to_string(f) +
        " names a point that does not exist; expected ids below " + std::to_string(points) + ".");
    }
  }
}

std::int64_t CellOf(const MeshPiece& piece, Eigen::Index f)
{
  return piece.CellOfTriangle.empty() ? f : piece.CellOfTriangle[static_cast<std::size_t>(f)];
}

/// Cells all of whose points lie on other ranks, too, with these points: what other ranks may hold.
std::map<std::int64_t, std::vector<std::int64_t>> CellsOnSeams(const MeshPiece& piece, const PointIdentity& identity)
{
  std::map<std::int64_t, std::vector<std::int64_t>> cells;
  std::unordered_map<std::int64_t, bool> inside;
  for (Eigen::Index f = 0; f < piece.Mesh.Triangles.rows(); ++f)
  {
    const auto t = piece.Mesh.Triangles.row(f);
    const bool shared = identity.Shared[t(0)] && identity.Shared[t(1)] && identity.Shared[t(2)];
    if (!shared)
    {
      inside[CellOf(piece, f)] = true;
      continue;
    }
    for (int k = 0; k < 3; ++k)
    {
      cells[CellOf(piece, f)].push_back(identity.WholeIds[t(k)]);
    }
  }
  for (const auto& cell : inside)
  {
    cells.erase(cell.first);
  }
  return cells;
}

/// For each key, whether no lower rank asks for the same.
std::vector<std::vector<char>> AnswerKeys(const std::vector<std::vector<CellKey>>& received)
{
  std::map<CellKey, std::size_t> lowest;
  std::vector<std::vector<char>> replies;
  for (std::size_t rank = 0; rank < received.size(); ++rank)
  {
    replies.emplace_back();
    for (const CellKey& key : received[rank])
    {
      replies.back().push_back(lowest.emplace(key, rank).first->second == rank ? 1 : 0);
    }
  }
  return replies;
}

/// Cells of the piece that a lower rank holds, ascending.
std::vector<std::int64_t> RepeatedCells(const RankGroup& ranks, const MeshPiece& piece, const PointIdentity& identity)
{
  std::vector<std::int64_t> cells;
  std::vector<CellKey> keys;
  std::vector<int> homes;
  for (const auto& cell : CellsOnSeams(piece, identity))
  {
    cells.push_back(cell.first);
    keys.push_back(KeyOf(cell.second));
    homes.push_back(static_cast<int>(keys.back()[0] % static_cast<std::uint64_t>(ranks.Count())));
  }
  const std::vector<char> isFirst = ranks.Ask<char>(keys, homes, AnswerKeys);
  std::vector<std::int64_t> repeated;
  for (std::size_t k = 0; k < cells.size(); ++k)
  {
    if (!isFirst[k])
    {
      repeated.push_back(cells[k]);
    }
  }
  return repeated;
}

/// Takes the triangles of cells that are not @p repeated, in the ids of points.
void TakeTriangles(const MeshPiece& piece, const std::vector<std::int64_t>& repeated, MergedPiece& merged)
{
  merged.Mesh.Triangles.resize(piece.Mesh.Triangles.rows(), 3);
  Eigen::Index count = 0;
  for (Eigen::Index f = 0; f < piece.Mesh.Triangles.rows(); ++f)
  {
    if (!std::binary_search(repeated.begin(), repeated.end(), CellOf(piece, f)))
    {
      merged.Mesh.Triangles.row(count++) = piece.Mesh.Triangles.row(f);
      merged.CellOfTriangle.push_back(CellOf(piece, f));
    }
  }
  merged.Mesh.Triangles.conservativeResize(count, 3);
}

/// Points that a triangle uses, and those that other ranks hold, too, and may use.
std::vector<bool> PointsInUse(const PointIdentity& identity, const TriangleMesh& mesh)
{
  std::vector<bool> inUse = identity.Shared;
  for (Eigen::Index k = 0; k < mesh.Triangles.size(); ++k)
  {
    inUse[static_cast<std::size_t>(mesh.Triangles.data()[k])] = true;
  }
  return inUse;
}

/// Replaces points by vertices, one for each point of the whole that is in use.
void TakeVertices(const PointIdentity& identity, MergedPiece& merged)
{
  const std::vector<bool> inUse = PointsInUse(identity, merged.Mesh);
  std::unordered_map<std::int64_t, Index> sharedVertices; // points of one piece may be the same point of the whole
  merged.VertexOfPoint.assign(inUse.size(), -1);
  std::vector<Eigen::Index> source;
  for (std::size_t k = 0; k < inUse.size(); ++k)
  {
    const std::int64_t id = identity.WholeIds[k];
    const auto next = static_cast<Index>(source.size());
    if (!inUse[k])
    {
      continue;
    }
    merged.VertexOfPoint[k] = identity.Shared[k] ? sharedVertices.emplace(id, next).first->second : next;
    if (merged.VertexOfPoint[k] == next)
    {
      source.push_back(static_cast<Eigen::Index>(k));
      merged.WholeIds.push_back(id);
      merged.Shared.push_back(identity.Shared[k]);
    }
  }
  merged.Mesh.Points.resize(static_cast<Eigen::Index>(source.size()), 3);
  for (std::size_t v = 0; v < source.size(); ++v)
  {
    merged.Mesh.Points.row(static_cast<Eigen::Index>(v)) = identity.Points.row(source[v]);
  }
  for (Eigen::Index k = 0; k < merged.Mesh.Triangles.size(); ++k)
  {
    Index& corner = merged.Mesh.Triangles.data()[k];
    corner = merged.VertexOfPoint[static_cast<std::size_t>(corner)];
  }
}
} // namespace

MergedPiece MergePiece(const RankGroup& ranks, const MeshPiece& piece)
{
  ranks.Together([&] { RequireShapes(piece); });
  const PointIdentity identity = IdentifyPoints(ranks, piece.Mesh.Points, piece.GlobalIds);
  const std::vector<std::int64_t> repeated = RepeatedCells(ranks, piece, identity);
  MergedPiece merged;
  merged.NumberOfWholePoints = identity.NumberOfWholePoints;
  ranks.Together([&] {
    TakeTriangles(piece, repeated, merged);
    TakeVertices(identity, merged);
  });
  return merged;
}

} // namespace surfsynth
