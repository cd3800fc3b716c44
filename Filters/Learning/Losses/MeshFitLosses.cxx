// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Losses/MeshFitLosses.h"

#include "Core/Common/Errors.h"
#include "Learning/Layers/EdgeFeatureTensors.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace surfsynth
{

namespace
{
using Edge = std::array<std::int64_t, 2>;

/// Each edge of the triangles once, in ascending order.
std::vector<Edge> UniqueEdges(const TriangleMesh& mesh)
{
  std::vector<Edge> edges;
  edges.reserve(static_cast<std::size_t>(3 * mesh.Triangles.rows()));
  for (Eigen::Index f = 0; f < mesh.Triangles.rows(); ++f)
  {
    for (int k = 0; k < 3; ++k)
    {
      const std::int64_t a = mesh.Triangles(f, k);
      const std::int64_t b = mesh.Triangles(f, (k + 1) % 3);
      if (a < 0 || a >= mesh.NumberOfPoints())
      {
        throw InvalidInput("FitTables: triangle " + std::to_string(f) + " names vertex " + std::to_string(a) +
          "; expected ids from 0 to " + std::to_string(mesh.NumberOfPoints() - 1) + ".");
      }
      edges.push_back({ std::min(a, b), std::max(a, b) });
    }
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

/// x ln x, without the infinite slope at 0.
torch::Tensor TimesLogarithm(const torch::Tensor& x) { return x * x.clamp_min(1e-30).log(); }

torch::Tensor Lengths(const torch::Tensor& vectors) { return vectors.norm(2, -1); }

torch::Tensor MeanDistance(const torch::Tensor& points, const torch::Tensor& nearest)
{
  constexpr double rounding = 1e-8; // keeps the slope finite where samples coincide
  return torch::sqrt((points - nearest).square().sum(-1) + rounding).mean();
}

torch::Tensor MeanDisagreement(const torch::Tensor& normals, const torch::Tensor& others)
{
  return -(normals * others).sum(-1).mean();
}
} // namespace

FitTables::FitTables(const TriangleMesh& mesh, const torch::TensorOptions& options)
  : Vertices(mesh.NumberOfPoints())
{
  const std::vector<Edge> edges = UniqueEdges(mesh);
  const auto device = options.device();
  this->Triangles = torch::from_blob(
    const_cast<Index*>(mesh.Triangles.data()), { mesh.Triangles.rows(), 3 }, torch::kInt32)
                      .to(device, torch::kInt64, false, true);
  this->Edges = torch::from_blob(
    const_cast<Edge*>(edges.data()), { static_cast<std::int64_t>(edges.size()), 2 }, torch::kInt64)
                  .to(device, torch::kInt64, false, true);
  this->Valence = torch::bincount(this->Edges.flatten(), {}, this->Vertices).clamp_min(1).unsqueeze(-1).to(options);
}

TriangulationLoss ComputeTriangulationLoss(const FitTables& tables, const torch::Tensor& positions)
{
  TriangulationLoss loss;
  const torch::Tensor ends = TakeRows(positions, tables.Edges);
  loss.EdgeDeviation = Lengths(ends.select(1, 0) - ends.select(1, 1)).std();

  const torch::Tensor corners = TakeRows(positions, tables.Triangles);
  const torch::Tensor sides = Lengths(corners - corners.roll(-1, 1));
  const torch::Tensor shares = sides / sides.sum(-1, true).clamp_min(1e-30);
  loss.EdgeEntropy = TimesLogarithm(shares).sum(-1).mean();

  const torch::Tensor neighbors = SumRows(ends.flip(1), tables.Edges, tables.Vertices) / tables.Valence;
  loss.Roughness = (positions - neighbors).abs().sum(-1).mean();

  loss.Total = 5e-3 * loss.EdgeDeviation + 5e-4 * loss.EdgeEntropy + 0.01 * loss.Roughness;
  return loss;
}

SampledSurface EvaluateSamples(const FitTables& tables, const torch::Tensor& positions, const SurfaceSamples& samples)
{
  const torch::Tensor corners = TakeRows(positions, tables.Triangles.index_select(0, samples.Faces));
  const torch::Tensor normals = torch::linalg_cross(
    corners.select(1, 1) - corners.select(1, 0), corners.select(1, 2) - corners.select(1, 1), -1);
  return { (samples.Weights.unsqueeze(-1) * corners).sum(1), normals / normals.norm(2, -1, true).clamp_min(1e-30) };
}

ChamferLoss ComputeChamferLoss(
  const SampledSurface& source, const SampledSurface& target, const NearestSampleIds& nearest, bool publishedNormals)
{
  ChamferLoss loss;
  loss.Distance = { MeanDistance(source.Points, TakeRows(target.Points, nearest.OfSource)),
    MeanDistance(target.Points, TakeRows(source.Points, nearest.OfTarget)) };
  const torch::Tensor& ofSource = publishedNormals ? nearest.OfTarget : nearest.OfSource;
  loss.Normal = { MeanDisagreement(source.Normals, TakeRows(target.Normals, ofSource)),
    MeanDisagreement(target.Normals, TakeRows(source.Normals, nearest.OfTarget)) };
  loss.Total = 0.4 * loss.Distance[0] + 0.6 * loss.Distance[1] + 0.1 * (loss.Normal[0] + loss.Normal[1]);
  return loss;
}

} // namespace surfsynth
