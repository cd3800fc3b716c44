// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Layers/EdgeFeatureTensors.h"

#include "Learning/Layers/FaceSelection.h"
#include "Learning/Layers/FusedFrames.h"
#include "Learning/Layers/FusedLayers.h"

namespace surfsynth
{

namespace
{
torch::Tensor IdTensor(const TriangleMatrix& ids, const torch::Device& device)
{
  return torch::from_blob(const_cast<Index*>(ids.data()), { ids.rows(), 3 }, torch::kInt32)
    .to(device, torch::kInt64, false, true);
}

/// Divides vectors by their lengths; 0 for vectors of length 0.
torch::Tensor UnitVectors(const torch::Tensor& vectors)
{
  constexpr double smallest = 1e-30; // nothing that is not 0 in float32 is squared to less
  return vectors / vectors.norm(2, -1, true).clamp_min(smallest);
}

/// The frames of the edges, [F, 3, 3] each (triangle, edge, coordinate); normals are the same for all edges of a
/// triangle.
struct EdgeFrameTensors
{
  torch::Tensor Midpoint;
  torch::Tensor Along;   ///< unit vector from the edge's first corner to its second
  torch::Tensor Outward; ///< Along cross Normal
  torch::Tensor Normal;
  torch::Tensor Length; ///< [F, 3, 1]
};

EdgeFrameTensors FramesOf(const FaceTables& tables, const torch::Tensor& positions)
{
  EdgeFrameTensors frames;
  const torch::Tensor corners = TakeRows(positions, tables.Triangles);
  const torch::Tensor next = corners.roll(-1, 1);
  const torch::Tensor edges = next - corners;
  frames.Midpoint = 0.5 * (corners + next);
  frames.Length = edges.norm(2, -1, true);
  frames.Along = UnitVectors(edges);
  const torch::Tensor normal = torch::linalg_cross(edges.select(1, 0), edges.select(1, 1), -1);
  frames.Normal = UnitVectors(normal).unsqueeze(1).expand_as(edges);
  frames.Outward = torch::linalg_cross(frames.Along, frames.Normal, -1);
  return frames;
}
} // namespace

FaceTables::FaceTables(const TriangleMesh& mesh, const torch::TensorOptions& options)
  : Vertices(mesh.NumberOfPoints())
{
  const FaceNeighbors neighbors = ComputeFaceNeighbors(mesh);
  this->Triangles = IdTensor(mesh.Triangles, options.device());
  this->Neighbors = IdTensor(neighbors.Faces, options.device());
  this->Opposite = IdTensor(neighbors.Opposite, options.device());
  const torch::Tensor own = torch::arange(this->Triangles.size(0), this->Neighbors.options()).unsqueeze(-1);
  this->Sides = (1 - 2 * this->Neighbors.eq(own).to(options)).unsqueeze(-1);
  const torch::Tensor counts = torch::bincount(this->Triangles.flatten(), {}, this->Vertices);
  this->Corners = counts.clamp_min(1).unsqueeze(-1).to(options);
  this->OfNeighbors = std::make_shared<const FaceSelection>(SelectNeighbors(neighbors.Faces));
  this->OfEdges = std::make_shared<const FaceSelection>(SelectEdges(neighbors.Faces.rows()));
}

torch::Tensor TakeRows(const torch::Tensor& table, const torch::Tensor& ids)
{
  // An embedding's backward pass adds rows in a fixed order on every device, and has a derivative itself.
  return torch::embedding(table, ids);
}

torch::Tensor SumRows(const torch::Tensor& values, const torch::Tensor& ids, std::int64_t rows)
{
  constexpr std::int64_t noPadding = -1;
  return at::embedding_dense_backward(values, ids, rows, noPadding, false);
}

torch::Tensor EdgeFeatureTensor(const FaceTables& tables, const torch::Tensor& positions)
{
  if (IsFused(positions) && tables.OfNeighbors)
  {
    return FusedEdgeFeatures(tables, positions);
  }
  const EdgeFrameTensors frames = FramesOf(tables, positions);
  const torch::Tensor beyond = tables.Sides * (TakeRows(positions, tables.Opposite) - frames.Midpoint);
  const auto coordinate = [&beyond](const torch::Tensor& axis) { return (beyond * axis).sum(-1, true); };
  return torch::cat(
    { coordinate(frames.Along), coordinate(frames.Outward), coordinate(frames.Normal), frames.Length }, -1)
    .flatten(1);
}

torch::Tensor CornerDisplacement(const FaceTables& tables, const torch::Tensor& positions, const torch::Tensor& local)
{
  if (IsFused(positions) && IsFused(local) && tables.OfNeighbors)
  {
    return FusedCornerDisplacement(tables, positions, local);
  }
  const EdgeFrameTensors frames = FramesOf(tables, positions);
  const torch::Tensor weights = local.unsqueeze(1);
  const auto weight = [&weights](std::int64_t axis) { return weights.narrow(-1, axis, 1); };
  const torch::Tensor corners = weight(0) * frames.Along + weight(1) * frames.Outward + weight(2) * frames.Normal;
  return SumRows(corners, tables.Triangles, tables.Vertices) / tables.Corners;
}

torch::Tensor ParentTensor(const SubdividedMesh& subdivided, const torch::Device& device)
{
  const auto count = static_cast<std::int64_t>(subdivided.Parents.size());
  const torch::Tensor parents = torch::empty({ count, 2 }, torch::kInt64);
  std::int64_t* ids = parents.data_ptr<std::int64_t>();
  for (const auto& ends : subdivided.Parents)
  {
    *ids++ = ends[0];
    *ids++ = ends[1];
  }
  return parents.to(device);
}

torch::Tensor DoubledSubdivision(const torch::Tensor& positions, const torch::Tensor& parents)
{
  return torch::cat({ 2.0 * positions, TakeRows(positions, parents).sum(1) }, 0);
}

} // namespace surfsynth
