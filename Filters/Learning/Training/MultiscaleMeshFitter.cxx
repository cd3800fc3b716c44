// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/MultiscaleMeshFitter.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/MeshCheck.h"
#include "Core/Mesh/MidpointSubdivision.h"
#include "Core/Mesh/SurfaceDistance.h"
#include "Core/Mesh/SurfaceRelaxation.h"
#include "Core/Random/CounterUniforms.h"
#include "Inference/GeometricTexture/GeometricTextureSampler.h"
#include "Learning/Losses/MeshFitLosses.h"
#include "Learning/Training/FitTemplates.h"
#include "Learning/Training/NearestPoints.h"
#include "Learning/Training/OptionChecks.h"
#include "Learning/Training/SurfaceTemplate.h"
#include "Learning/Training/TimeLimit.h"

#include <Eigen/Geometry>
#include <torch/torch.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

namespace surfsynth
{

namespace
{
constexpr int MostFoldRounds = 100;
constexpr std::int64_t DistanceSamples = 20000;

/// Half of the longest side of the box, and its centre.
struct BoxFrame
{
  explicit BoxFrame(const TriangleMesh& mesh)
  {
    const BoundingBox box = ComputeBoundingBox(mesh);
    this->Center = 0.5 * (box.Lower + box.Upper).transpose();
    this->Radius = 0.5 * box.LongestSide();
  }
  Eigen::RowVector3d Center;
  double Radius = 1.0;
};

/// A mesh under optimisation, or the one that it is fitted to.
struct FitSurface
{
  explicit FitSurface(const TriangleMesh& mesh)
    : Mesh(mesh)
    , Tables(mesh, torch::kFloat64)
    , Positions(
        torch::from_blob(const_cast<double*>(mesh.Points.data()), { mesh.Points.rows(), 3 }, torch::kFloat64).clone())
  {}
  TriangleMesh Mesh; ///< with the points of before the optimisation
  FitTables Tables;
  torch::Tensor Positions; ///< [V, 3]
};

PointMatrix ToPoints(const torch::Tensor& tensor)
{
  const torch::Tensor rows = tensor.detach().contiguous();
  return Eigen::Map<const PointMatrix>(rows.data_ptr<double>(), rows.size(0), 3);
}

torch::Tensor IdsOf(const std::vector<std::int64_t>& ids) { return torch::tensor(ids, torch::kInt64); }

/// Points uniformly on a surface: a triangle by its area, then a point in the square, folded onto the triangle.
SurfaceSamples DrawSamples(const FitSurface& surface, std::int64_t count, const NormalKey& key)
{
  const PointMatrix points = ToPoints(surface.Positions);
  const TriangleMatrix& triangles = surface.Mesh.Triangles;
  std::vector<double> area(static_cast<std::size_t>(triangles.rows()));
  double sum = 0.0;
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
  {
    const Eigen::RowVector3d a = points.row(triangles(f, 0));
    const Eigen::RowVector3d b = points.row(triangles(f, 1));
    const Eigen::RowVector3d c = points.row(triangles(f, 2));
    area[static_cast<std::size_t>(f)] = sum += 0.5 * (b - a).cross(c - a).norm();
  }
  SurfaceSamples samples{ torch::empty({ count }, torch::kInt64), torch::empty({ count, 3 }, torch::kFloat64) };
  auto* face = samples.Faces.data_ptr<std::int64_t>();
  auto* weight = samples.Weights.data_ptr<double>();
  for (std::int64_t k = 0; k < count; ++k, weight += 3)
  {
    const auto found = std::upper_bound(area.begin(), area.end() - 1, Uniform(key, 3 * k) * sum);
    face[k] = found - area.begin();
    double u = Uniform(key, 3 * k + 1);
    double v = Uniform(key, 3 * k + 2);
    if (u + v > 1.0)
    {
      u = 1.0 - u;
      v = 1.0 - v;
    }
    weight[0] = u;
    weight[1] = v;
    weight[2] = 1.0 - u - v;
  }
  return samples;
}

/// The optimisation of one level.
class LevelFit
{
public:
  LevelFit(const MultiscaleFitOptions& options, std::int64_t level, FitSurface& source, const FitSurface& target)
    : Options(options)
    , Level(level)
    , Source(source)
    , Target(target)
    , Adam(std::vector<torch::Tensor>{ source.Positions.requires_grad_() },
        torch::optim::AdamOptions(options.LearningRate))
  {}

  /// @param done part of the level, from 0 to 1, that the learning rate has fallen over.
  void Iterate(std::int64_t iteration, double done)
  {
    this->SetLearningRate(done);
    for (std::int64_t k = 0; k < this->Options.TriangulationSteps; ++k)
    {
      this->Descend(ComputeTriangulationLoss(this->Source.Tables, this->Source.Positions).Total);
    }
    for (std::int64_t k = 0; k < this->Options.ChamferSteps; ++k)
    {
      this->Descend(this->Chamfer(iteration * this->Options.ChamferSteps + k));
    }
  }

private:
  /// Falls geometrically: large steps make the shape, small ones take away what they leave of their size.
  void SetLearningRate(double done)
  {
    const double factor = std::pow(this->Options.LearningRateDecay, done);
    auto& group = this->Adam.param_groups().front();
    static_cast<torch::optim::AdamOptions&>(group.options()).lr(this->Options.LearningRate * factor);
  }

  void Descend(const torch::Tensor& loss)
  {
    if (!std::isfinite(loss.item<double>()))
    {
      throw SolverFailure("FitMultiscaleMesh: a loss of level " + std::to_string(this->Level) +
        " is not finite; expected a lower learning rate.");
    }
    this->Adam.zero_grad();
    loss.backward();
    this->Adam.step();
  }

  torch::Tensor Chamfer(std::int64_t draw) const
  {
    const std::int64_t count = this->Options.Samples * (this->Level + 1);
    NormalKey key;
    key.Seed = this->Options.Seed;
    key.Sample = static_cast<std::uint32_t>(draw);
    key.Component = static_cast<std::uint32_t>(2 * this->Level);
    const SampledSurface source = EvaluateSamples(
      this->Source.Tables, this->Source.Positions, DrawSamples(this->Source, count, key));
    ++key.Component;
    const SampledSurface target = EvaluateSamples(
      this->Target.Tables, this->Target.Positions, DrawSamples(this->Target, count, key));
    const PointMatrix sourcePoints = ToPoints(source.Points);
    const PointMatrix targetPoints = ToPoints(target.Points);
    const NearestSampleIds nearest{ IdsOf(PointTree(targetPoints).Nearest(sourcePoints)),
      IdsOf(PointTree(sourcePoints).Nearest(targetPoints)) };
    return ComputeChamferLoss(source, target, nearest, this->Options.PublishedNormals).Total;
  }

  const MultiscaleFitOptions& Options;
  std::int64_t Level;
  FitSurface& Source;
  const FitSurface& Target;
  torch::optim::Adam Adam;
};

/// Minutes that a level may take: (level + 1) parts of those that are left for it and the levels after it.
double MinutesOf(std::int64_t level, std::int64_t levels, const TimeLimit& limit)
{
  const auto parts = static_cast<double>((levels - level) * (level + 1 + levels)) / 2.0;
  return limit.MinutesLeft() * static_cast<double>(level + 1) / parts;
}

/// Fits @p source and notes the iterations and the time in @p fit. @param report called before each iteration.
void FitLevel(LevelFit& optimization, std::int64_t iterations, double minutes, MultiscaleFit& fit,
  const std::function<void(std::int64_t iteration)>& report)
{
  const TimeLimit limit(minutes);
  const auto last = static_cast<double>(std::max<std::int64_t>(iterations - 1, 1));
  std::int64_t done = 0;
  while (done < iterations && (done == 0 || !limit.IsReached()))
  {
    report(done);
    const double ofTime = limit.Exists() && done > 0 ? std::min(1.0, limit.Elapsed() / (60.0 * minutes)) : 0.0;
    optimization.Iterate(done, std::max(static_cast<double>(done) / last, ofTime));
    ++done;
  }
  fit.Iterations.push_back(done);
  fit.SecondsForAll += limit.Elapsed() * static_cast<double>(iterations) /
    static_cast<double>(std::max<std::int64_t>(done, 1));
}

TriangleMesh MakeTemplate(const MultiscaleFitOptions& options)
{
  switch (options.Template)
  {
    case FitTemplate::Torus:
      return MakeTorus(options.TorusSegments);
    case FitTemplate::Given:
      if (options.GivenTemplate.NumberOfTriangles() == 0)
      {
        throw InvalidInput("FitMultiscaleMesh: the given template has no triangle; expected a mesh.");
      }
      RequireValidMesh(options.GivenTemplate, GeometricTextureSampler::Requirements());
      return options.GivenTemplate;
    default:
      return MakeIcosphere(options.IcosphereLevel);
  }
}

/// @p mesh at the origin, in units of @p unit half sides of its box.
TriangleMesh InBox(TriangleMesh mesh, const BoxFrame& frame, double unit)
{
  mesh.Points = (mesh.Points.rowwise() - frame.Center) / (frame.Radius * unit);
  return mesh;
}

void RequireReference(const TriangleMesh& reference)
{
  if (reference.NumberOfTriangles() == 0)
  {
    throw InvalidInput("FitMultiscaleMesh: the reference has no triangle; expected a surface.");
  }
  MeshRequirements any;
  any.ManifoldEdges = false;
  RequireValidMesh(reference, any);
}

/// Adds the distance of the last level.
void AddDistance(MultiscaleFit& fit, const TriangleMesh& reference)
{
  const TriangleMesh& level = fit.Dataset.Levels.back();
  const PointDistances points = DistanceToSurface(level.Points, reference);
  const auto find = [](const TriangleMesh& mesh, const PointMatrix& places) {
    return NearestSurface(mesh).NearestPlaces(places);
  };
  const DistanceSummary both = ComputeSurfaceDistance(level, reference, find, DistanceSamples).Symmetric;
  fit.Distances.push_back({ points.Mean, points.Largest, both.Mean, both.Percentile95,
    MeanNormalAngle(level, reference, find, DistanceSamples) });
}

/// Relaxes @p mesh along @p reference. @return number of rounds done.
std::int64_t Relax(TriangleMesh& mesh, const TriangleMesh& reference, const MultiscaleFitOptions& options,
  const TimeLimit& limit, const Progress& progress)
{
  const NearestSurface surface(reference);
  const MeshTopology topology(mesh);
  std::int64_t done = 0;
  for (; done < options.Iterations && !limit.IsReached(); ++done)
  {
    Report(progress, 0.1 + 0.8 * static_cast<double>(done) / static_cast<double>(options.Iterations));
    RelaxOnSurface(mesh, topology, surface, 1);
  }
  SmoothFolds(mesh, topology, MostFoldRounds);
  return done;
}

/// The fit of a template that is made from the reference.
MultiscaleFit FitSurfaceTemplate(
  const TriangleMesh& reference, const MultiscaleFitOptions& options, const Progress& progress)
{
  const TimeLimit limit(options.TimeBudget);
  const auto triangles = static_cast<Index>(options.TemplateTriangles);
  const SurfaceTemplate start(
    reference, triangles, options.SmoothingLength, [&](double done) { return !progress || progress(0.1 * done); });
  TriangleMesh finest = start.OnReference(static_cast<int>(options.Levels) - 1);
  const TimeLimit clock(0.0);
  const std::int64_t done = Relax(finest, reference, options, limit, progress);
  MultiscaleFit fit;
  fit.SecondsForAll = clock.Elapsed() * static_cast<double>(options.Iterations) /
    static_cast<double>(std::max<std::int64_t>(done, 1));
  fit.Dataset.Template = start.Mesh();
  TriangleMesh level = start.Mesh();
  for (std::int64_t k = 0; k < options.Levels; ++k)
  {
    level = k > 0 ? SubdivideAtMidpoints(level).Mesh : level;
    fit.Dataset.Levels.push_back({ finest.Points.topRows(level.NumberOfPoints()), level.Triangles });
    fit.Iterations.push_back(done);
    AddDistance(fit, reference);
  }
  Report(progress, 1.0);
  return fit;
}
} // namespace

void CheckOptions(const MultiscaleFitOptions& options)
{
  const OptionChecks check("MultiscaleFitOptions");
  check.Count("Levels", options.Levels, 1, 10);
  check.Count("IcosphereLevel", options.IcosphereLevel, 0, 6);
  check.Count("TorusSegments", options.TorusSegments, 3, 1000);
  check.Count("TemplateTriangles", options.TemplateTriangles, 4, 1000000);
  check.Weight("SmoothingLength", options.SmoothingLength);
  check.Count("Iterations", options.Iterations, 0, 1000000);
  check.Count("TriangulationSteps", options.TriangulationSteps, 0, 1000);
  check.Count("ChamferSteps", options.ChamferSteps, 0, 1000);
  check.Count("Samples", options.Samples, 1, 1000000);
  check.LearningRate("LearningRate", options.LearningRate);
  check.Require(options.LearningRateDecay > 0.0 && options.LearningRateDecay <= 1.0, "LearningRateDecay",
    options.LearningRateDecay, "a number above 0, at most 1");
  check.Weight("TimeBudget", options.TimeBudget);
}

MultiscaleFit FitMultiscaleMesh(
  const TriangleMesh& reference, const MultiscaleFitOptions& options, const Progress& progress)
{
  CheckOptions(options);
  RequireReference(reference);
  if (options.Template == FitTemplate::Surface)
  {
    return FitSurfaceTemplate(reference, options, progress);
  }
  const TimeLimit limit(options.TimeBudget);
  const TriangleMesh start = MakeTemplate(options);
  const BoxFrame startFrame(start);
  const BoxFrame frame(reference);
  const double unit = MeanEdgeLength(InBox(start, startFrame, 1.0));
  TriangleMesh mesh = InBox(start, startFrame, unit);
  FitSurface target(InBox(reference, frame, unit));
  // From the units of a level to those of the reference, which halve with each level.
  double scale = frame.Radius * unit;
  const auto inReference = [&](const PointMatrix& points) -> PointMatrix {
    return (scale * points).rowwise() + frame.Center;
  };

  MultiscaleFit fit;
  fit.Dataset.Template = { inReference(mesh.Points), mesh.Triangles };
  const double share = 1.0 / static_cast<double>(options.Levels * std::max<std::int64_t>(options.Iterations, 1));
  for (std::int64_t level = 0; level < options.Levels; ++level)
  {
    FitSurface source(mesh);
    LevelFit optimization(options, level, source, target);
    FitLevel(optimization, options.Iterations, MinutesOf(level, options.Levels, limit), fit,
      [&](std::int64_t k) { Report(progress, share * static_cast<double>(level * options.Iterations + k)); });
    mesh.Points = ToPoints(source.Positions);
    fit.Dataset.Levels.push_back({ inReference(mesh.Points), mesh.Triangles });
    AddDistance(fit, reference);
    if (level + 1 < options.Levels)
    {
      mesh = SubdivideAtMidpoints(mesh).Mesh;
      mesh.Points *= 2.0;
      target.Positions = 2.0 * target.Positions;
      scale *= 0.5;
    }
  }
  Report(progress, 1.0);
  return fit;
}

} // namespace surfsynth
