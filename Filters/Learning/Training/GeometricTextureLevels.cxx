// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/GeometricTextureLevels.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/MeshCheck.h"
#include "Inference/GeometricTexture/GeometricTextureSampler.h"

#include <string>

namespace surfsynth
{

namespace
{
torch::Tensor PointTensor(const PointMatrix& points, const torch::Device& device)
{
  return torch::from_blob(const_cast<double*>(points.data()), { points.rows(), 3 }, torch::kFloat64)
    .to(device, torch::kFloat32, false, true);
}

void RequireValidLevel(const TriangleMesh& mesh, const std::string& what)
{
  try
  {
    RequireValidMesh(mesh, GeometricTextureSampler::Requirements());
  }
  catch (const InvalidInput& error)
  {
    throw InvalidInput("GeometricTextureTrainer: " + what + ": " + error.what());
  }
}
} // namespace

GeometricTextureLevels MakeGeometricTextureLevels(
  const MultiscaleDataset& dataset, const torch::Device& device, const std::vector<int>& rings)
{
  CheckDataset(dataset);
  GeometricTextureLevels levels;
  levels.Template = dataset.HasTemplate() ? dataset.Template : dataset.Levels.front();
  RequireValidLevel(levels.Template, "the template");
  for (std::size_t k = 0; k < dataset.Levels.size(); ++k)
  {
    RequireValidLevel(dataset.Levels[k], "level " + std::to_string(k));
  }
  const double edge = MeanEdgeLength(dataset.Levels.front());
  const Eigen::RowVector3d center = levels.Template.Points.colwise().mean();
  levels.Template.Points = (levels.Template.Points.rowwise() - center) / edge;
  levels.Start = PointTensor(levels.Template.Points, device);
  double scale = 1.0 / edge;
  for (const TriangleMesh& mesh : dataset.Levels)
  {
    GeometricTextureLevelData& data = levels.Data.emplace_back();
    data.Tables = FaceTables(mesh, torch::TensorOptions(torch::kFloat32).device(device));
    data.Real = PointTensor(scale * (mesh.Points.rowwise() - center), device);
    data.RealFeatures = EdgeFeatureTensor(data.Tables, data.Real);
    for (const int count : rings)
    {
      data.Rings.emplace_back(mesh, count, torch::TensorOptions(torch::kFloat32).device(device));
      data.RealRingFeatures.push_back(RingFeatureTensor(data.Tables, data.Rings.back(), data.Real));
    }
    data.Parents = ParentTensor(SubdivideAtMidpoints(mesh), device);
    scale *= 2.0;
  }
  return levels;
}

} // namespace surfsynth
