// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/GeometricTexture/GeometricTextureSynthesis.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Mesh/EdgeDistances.h"
#include "Core/Mesh/MidpointSubdivision.h"
#include "Core/Solvers/SingleThreadedBlas.h"
#include "Inference/GeometricTexture/FaceNetwork.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace surfsynth
{

GeometricTextureFrame FrameOf(const TriangleMesh& mesh, const MeshTopology& topology)
{
  GeometricTextureFrame frame;
  std::int64_t used = 0;
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    if (topology.NeighborStart[v] < topology.NeighborStart[v + 1]) // others may be anywhere
    {
      ++used;
      frame.Center += mesh.Points.row(v);
    }
  }
  frame.Center /= static_cast<double>(used);
  frame.Unit = MeanEdgeLength(mesh, topology);
  if (!(frame.Unit > 0.0) || !std::isfinite(frame.Unit) || !std::isfinite(1.0 / frame.Unit) ||
    !frame.Center.allFinite())
  {
    throw InvalidInput("GeometricTextureSampler: the mean edge length is " + FormatNumber(frame.Unit) +
      "; expected a mesh whose coordinates double precision can sum.");
  }
  return frame;
}

GeometricTextureSynthesis::GeometricTextureSynthesis(const GeometricTextureModel& model, const TriangleMesh& mesh,
  const MeshTopology& topology, const GeometricTextureFrame& frame, Eigen::VectorXf mask, NormStatistics statistics)
  : Model(model)
  , Frame(frame)
  , Base(mesh)
  , Offset(PointMatrix::Zero(mesh.NumberOfPoints(), 3))
  , LastOffset(this->Offset)
  , Mask(std::move(mask))
  , Statistics(statistics)
  , Neighbors(ComputeFaceNeighbors(mesh, topology))
{}

SinglePoints GeometricTextureSynthesis::LevelPoints() const
{
  const double scale = this->Doubling / this->Frame.Unit;
  return ((this->Base.Points.rowwise() - this->Frame.Center) * scale + this->Offset).cast<float>();
}

void GeometricTextureSynthesis::SetBlend(const GeometricTextureModel& second, Eigen::VectorXf blend)
{
  this->SecondModel = &second;
  this->Blend = std::move(blend);
}

void GeometricTextureSynthesis::SetSizes(
  const TriangleMesh& mesh, const MeshTopology& topology, const Eigen::VectorXf& sizes)
{
  double sum = 0.0;
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    sum += static_cast<double>(sizes[v]) * (topology.NeighborStart[v + 1] - topology.NeighborStart[v]);
  }
  const double mean = sum / static_cast<double>(topology.Neighbors.size()); // over the edges, as the unit is
  this->Sizes = sizes / static_cast<float>(mean);
}

/// Computes what a network makes of the level's @p points moved by @p noise, [V, 3], in units of each place.
PointMatrix GeometricTextureSynthesis::LocalOffset(const FaceNetwork& network, const SinglePoints& points,
  const SinglePoints& noise, const Progress& progress, NetworkStatistics* found)
{
  EdgeFeatureMatrix features;
  if (noise.rows() > 0)
  {
    const SinglePoints local = this->Sizes.size() > 0 ? SinglePoints(this->Sizes.asDiagonal() * noise) : noise;
    features = ComputeEdgeFeatures(points + local, this->Base.Triangles, this->Neighbors);
  }
  else
  {
    features = ComputeEdgeFeatures(points, this->Base.Triangles, this->Neighbors);
  }
  for (Eigen::Index f = 0; f < features.rows() && this->Sizes.size() > 0; ++f)
  {
    const auto t = this->Base.Triangles.row(f);
    features.row(f) *= 3.0F / (this->Sizes[t(0)] + this->Sizes[t(1)] + this->Sizes[t(2)]);
  }
  Report(progress, 0.1);
  {
    const SingleThreadedBlas blas;
    this->Local = network.Run(features, this->Neighbors.Faces, SubProgress(progress, 0.1, 0.9), found);
  }
  return MeanCornerDisplacement(points, this->Base.Triangles, this->Local).cast<double>();
}

FaceNetwork GeometricTextureSynthesis::NetworkOf(const GeometricTextureModel& model, int level, std::int64_t step) const
{
  static const std::map<std::string, ModelTensor> none;
  const bool byReference = this->Statistics == NormStatistics::Reference;
  return FaceNetwork(model.Generator, level, model.Options.Layers, byReference ? model.Statistics : none, step);
}

/// Integrates the flow of a level from its noise, then again from its middle for each restart: [V, 3], in units of each
/// place.
PointMatrix GeometricTextureSynthesis::FlowOffset(const GeometricTextureModel& model, int level,
  const LevelNoise& noise, const Progress& progress, NetworkStatistics* found)
{
  const SinglePoints points = this->LevelPoints();
  const std::int64_t steps = model.Options.FlowSteps;
  const std::int64_t middle = steps / 2;
  const auto restarts = static_cast<std::int64_t>(noise.size()) - 1;
  const std::int64_t evaluations = steps + std::max<std::int64_t>(restarts, 0) * (steps - middle);
  std::int64_t done = 0;
  PointMatrix offset = PointMatrix::Zero(points.rows(), 3);
  const auto integrateFrom = [&](std::int64_t first) {
    for (std::int64_t k = first; k < steps; ++k, ++done)
    {
      const auto share = [&](std::int64_t at) { return static_cast<double>(at) / static_cast<double>(evaluations); };
      const Progress part = SubProgress(progress, share(done), share(done + 1));
      offset += this->LocalOffset(this->NetworkOf(model, level, k), points, offset.cast<float>(), part, found) /
        static_cast<double>(steps);
    }
  };
  if (!noise.empty())
  {
    offset = noise.front().cast<double>();
  }
  integrateFrom(0);
  const double time = static_cast<double>(middle) / static_cast<double>(steps);
  for (std::int64_t k = 1; k <= restarts; ++k)
  {
    offset = time * offset + (1.0 - time) * noise[static_cast<std::size_t>(k)].cast<double>();
    integrateFrom(middle);
  }
  return offset;
}

/// Computes the displacement of the vertices by a level of a model, [V, 3], in units of the level.
PointMatrix GeometricTextureSynthesis::OffsetBy(const GeometricTextureModel& model, int level, const LevelNoise& noise,
  const Progress& progress, NetworkStatistics* found)
{
  PointMatrix offset = model.Options.FlowSteps > 0
    ? this->FlowOffset(model, level, noise, progress, found)
    : this->LocalOffset(this->NetworkOf(model, level, 0), this->LevelPoints(),
        noise.empty() ? SinglePoints() : noise.front(), progress, found);
  if (this->Sizes.size() > 0)
  {
    offset.array().colwise() *= this->Sizes.cast<double>().array();
  }
  return offset;
}

void GeometricTextureSynthesis::Displace(
  int level, const LevelNoise& noise, const Progress& progress, NetworkStatistics* found, const LevelNoise& secondNoise)
{
  this->LastOffset = this->OffsetBy(
    this->Model, level, noise, SubProgress(progress, 0.0, this->SecondModel ? 0.5 : 1.0), found);
  if (this->SecondModel)
  {
    const PointMatrix second = this->OffsetBy(
      *this->SecondModel, level, secondNoise, SubProgress(progress, 0.5, 1.0), nullptr);
    for (Eigen::Index v = 0; v < second.rows(); ++v)
    {
      const double share = this->Blend[v];
      if (share > 0.0)
      {
        this->LastOffset.row(v) = share < 1.0
          ? Eigen::RowVector3d((1.0 - share) * this->LastOffset.row(v) + share * second.row(v))
          : Eigen::RowVector3d(second.row(v));
      }
    }
  }
  if (this->Mask.size() > 0 && !this->FadesResult())
  {
    this->LastOffset.array().colwise() *= this->Mask.cast<double>().array();
  }
  if (!this->LastOffset.allFinite())
  {
    throw InvalidInput("GeometricTextureSampler: the displacement of level " + std::to_string(level) +
      " is not finite; expected a mesh and weights that single precision can hold.");
  }
  this->Offset += this->LastOffset;
  Report(progress, 1.0);
}

void GeometricTextureSynthesis::Refine()
{
  SubdividedMesh fine = SubdivideAtMidpoints(this->Base);
  this->Base = std::move(fine.Mesh);
  this->Offset = 2.0 * InterpolateAtMidpoints(std::move(this->Offset), fine.Parents);
  for (Eigen::VectorXf* values : { &this->Mask, &this->Sizes, &this->Blend })
  {
    *values = InterpolateAtMidpoints(std::move(*values), fine.Parents);
  }
  this->Doubling *= 2.0;
  this->Neighbors = ComputeFaceNeighbors(this->Base);
}

GeometricTextureLevel GeometricTextureSynthesis::Result(int level) const
{
  const double unit = this->Frame.Unit / this->Doubling;
  GeometricTextureLevel result;
  result.Level = level;
  result.Mesh.Triangles = this->Base.Triangles;
  result.Mesh.Points = unit * this->Offset;
  result.Displacement = unit * this->LastOffset;
  result.Base = this->Base.Points;
  for (PointMatrix* way : { &result.Mesh.Points, &result.Displacement })
  {
    if (this->FadesResult())
    {
      way->array().colwise() *= this->Mask.cast<double>().array();
    }
  }
  result.Mesh.Points += this->Base.Points;
  return result;
}

} // namespace surfsynth
