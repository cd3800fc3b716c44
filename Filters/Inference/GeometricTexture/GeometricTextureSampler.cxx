// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/GeometricTexture/GeometricTextureSampler.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Common/Parallel.h"
#include "Core/Random/CounterNormals.h"
#include "Inference/GeometricTexture/GeometricTextureSynthesis.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace surfsynth
{

namespace
{
/// The noise of a generator level on so many vertices.
using NoiseSource = std::function<LevelNoise(int level, int step, Index points)>;
/// Receives the statistics of the channels of a generator level.
using StatisticsObserver = std::function<void(int level, const NetworkStatistics& found)>;

[[noreturn]] void RefuseSample(const std::string& found, const std::string& expected)
{
  throw InvalidInput("GeometricTextureSampler: " + found + "; expected " + expected + ".");
}

/// Restarts where a request does not say how many: they make most of the difference (Examples/Training/README.md).
constexpr int SuitableRestarts = 3;
constexpr int MaximumRestarts = 20;

/// Adds @p weight times the normals of a seed. @param draw 0 for the noise of a level, k for its restart k
void AddNormals(
  const GeometricTextureRequest& request, std::uint64_t seed, int level, int draw, double weight, SinglePoints& noise)
{
  constexpr std::int64_t chunk = 4096; // a multiple of 4, as FillNormals() wants
  const std::int64_t points = noise.rows();
  ParallelTasks((points + chunk - 1) / chunk, [&](std::int64_t k) {
    const std::int64_t first = k * chunk;
    const std::int64_t count = std::min(chunk, points - first);
    std::vector<double> normals(static_cast<std::size_t>(count));
    for (std::uint32_t c = 0; c < 3; ++c)
    {
      const std::uint32_t component = 3 * static_cast<std::uint32_t>(draw) + c;
      FillNormals({ seed, static_cast<std::uint32_t>(level), component, request.Stream }, first, count, normals.data());
      for (std::int64_t p = 0; p < count; ++p)
      {
        noise(first + p, c) += static_cast<float>(weight * normals[p]);
      }
    }
  });
}

SinglePoints RandomNoise(const GeometricTextureRequest& request, double amplitude, int level, int draw, Index points)
{
  const double angle = request.Interpolation * std::acos(0.0);
  SinglePoints noise = SinglePoints::Zero(points, 3);
  if (request.Interpolation < 1.0)
  {
    AddNormals(request, request.Seed, level, draw, amplitude * std::cos(angle), noise);
  }
  if (request.Interpolation > 0.0)
  {
    AddNormals(request, request.SecondSeed, level, draw, amplitude * std::sin(angle), noise);
  }
  return noise;
}

/// Noise of a level by the seeds of the request.
NoiseSource NoiseOf(const GeometricTextureRequest& request, const GeometricTextureOptions& options)
{
  const double amplitude = request.NoiseAmplitude < 0.0 ? options.NoiseAmplitude : request.NoiseAmplitude;
  const int wanted = request.Restarts < 0 ? SuitableRestarts : request.Restarts;
  const int restarts = options.FlowSteps > 0 ? wanted : 0;
  return [&request, amplitude, restarts](int level, int step, Index points) {
    const auto k = static_cast<std::size_t>(step);
    const bool none = amplitude == 0.0 || (k < request.LevelsWithoutNoise.size() && request.LevelsWithoutNoise[k]);
    LevelNoise noise;
    for (int draw = 0; draw <= restarts && !none; ++draw)
    {
      noise.push_back(RandomNoise(request, amplitude, level, draw, points));
    }
    return noise;
  };
}

void CheckShares(const std::string& name, const Eigen::VectorXf& values, const TriangleMesh& mesh)
{
  if (values.size() != mesh.NumberOfPoints())
  {
    RefuseSample("the " + name + " has " + std::to_string(values.size()) + " values",
      std::to_string(mesh.NumberOfPoints()) + ", one for each vertex");
  }
  if (!(values.array() >= 0.0F).all() || !(values.array() <= 1.0F).all())
  {
    RefuseSample("the " + name + " has values below 0 or above 1", "0 to 1");
  }
}

void CheckRequest(const GeometricTextureModel& model, const GeometricTextureRequest& request, const TriangleMesh& mesh,
  const GeometricTextureLevelRange& levels)
{
  if (request.Statistics == NormStatistics::Reference && model.Statistics.empty())
  {
    RefuseSample("the model has no statistics of its reference, which are to normalize its channels",
      "a model that its training wrote with them, or one that WriteModelWithStatistics() or the command "
      "texture-statistics "
      "has added them to");
  }
  if (!(request.Interpolation >= 0.0) || !(request.Interpolation <= 1.0))
  {
    RefuseSample("the interpolation is " + FormatNumber(request.Interpolation), "0 to 1");
  }
  if (!std::isfinite(static_cast<float>(request.NoiseAmplitude)))
  {
    RefuseSample("the amplitude of the noise is " + FormatNumber(request.NoiseAmplitude), "a finite number");
  }
  if (request.Restarts > MaximumRestarts)
  {
    RefuseSample(
      "there are " + std::to_string(request.Restarts) + " restarts", "at most " + std::to_string(MaximumRestarts));
  }
  if (request.Mask.size() > 0)
  {
    CheckShares("mask", request.Mask, mesh);
  }
  if (mesh.NumberOfTriangles() == 0)
  {
    RefuseSample("the mesh has no triangle", "at least one");
  }
  // Checked before hours of work on all levels but the last.
  const double finest = mesh.NumberOfTriangles() * std::pow(4.0, levels.Count() - 1);
  if (finest > std::numeric_limits<Index>::max())
  {
    RefuseSample("the mesh has " + std::to_string(mesh.NumberOfTriangles()) + " triangles, which " +
        std::to_string(levels.Count()) + " levels make " + FormatNumber(finest),
      "at most 2147483647 in the end");
  }
}

/// Checks the second model, and the shares of it.
void CheckBlend(const GeometricTextureModel& model, const GeometricTextureRequest& request, const TriangleMesh& mesh,
  const GeometricTextureLevelRange& levels)
{
  const GeometricTextureModel& second = *request.SecondModel;
  CheckModel(second);
  if (second.Options.Levels != model.Options.Levels)
  {
    RefuseSample("the first model has " + std::to_string(model.Options.Levels) + " levels and the second " +
        std::to_string(second.Options.Levels),
      "two models with the same number of levels, which are mixed one by one");
  }
  CheckRequest(second, request, mesh, levels);
  CheckShares("blend", request.Blend, mesh);
}

void RequireTemplate(const GeometricTextureModel& model, const std::string& expected)
{
  if (model.Template.NumberOfTriangles() == 0)
  {
    RefuseSample("the model has no template", expected);
  }
}

GeometricTextureSynthesis OnTemplate(const GeometricTextureModel& model, const GeometricTextureRequest& request)
{
  const MeshTopology topology = RequireValidMesh(model.Template, GeometricTextureSampler::Requirements());
  GeometricTextureFrame frame = FrameOf(model.Template, topology);
  frame.Unit = 1.0; // the template comes in the units of the training
  return GeometricTextureSynthesis(model, model.Template, topology, frame, request.Mask, request.Statistics);
}

GeometricTextureLevel SynthesizeLevels(GeometricTextureSynthesis growth, const GeometricTextureLevelRange& levels,
  const NoiseSource& noise, const GeometricTextureSampler::Observer& observe, const Progress& progress,
  const StatisticsObserver& observeStatistics = {}, const NoiseSource& secondNoise = {})
{
  // Work is proportional to triangles, of which each level has four times as many.
  const double total = std::pow(4.0, levels.Count()) - 1.0;
  GeometricTextureLevel result;
  for (int level = levels.First; level <= levels.Last; ++level)
  {
    const int step = level - levels.First;
    const Progress part = SubProgress(
      progress, (std::pow(4.0, step) - 1.0) / total, (std::pow(4.0, step + 1) - 1.0) / total);
    Report(part, 0.0);
    if (step > 0)
    {
      growth.Refine();
      Report(part, 0.1);
    }
    NetworkStatistics statistics;
    growth.Displace(level, noise(level, step, growth.NumberOfPoints()), SubProgress(part, 0.15, 1.0),
      observeStatistics ? &statistics : nullptr,
      secondNoise ? secondNoise(level, step, growth.NumberOfPoints()) : LevelNoise());
    if (observeStatistics)
    {
      observeStatistics(level, statistics);
    }
    if (observe || level == levels.Last)
    {
      result = growth.Result(level);
    }
    if (observe)
    {
      observe(result);
    }
  }
  return result;
}
} // namespace

GeometricTextureLevelRange LevelsToSynthesize(const GeometricTextureRequest& request, std::int64_t levelsOfModel)
{
  const int last = static_cast<int>(levelsOfModel) - 1;
  const int end = request.EndLevel < 0 ? last : std::min(request.EndLevel, last);
  if (request.StartLevel < 0 || request.StartLevel > end)
  {
    const std::string why = end < last ? " (EndLevel); the model has the levels 0 to " + std::to_string(last)
                                       : ", the levels of the model";
    RefuseSample("StartLevel is " + std::to_string(request.StartLevel), "0 to " + std::to_string(end) + why);
  }
  return { request.StartLevel, end };
}

GeometricTextureSampler::GeometricTextureSampler(std::shared_ptr<const GeometricTextureModel> model)
  : Model(std::move(model))
{
  CheckModel(*this->Model);
}

GeometricTextureLevel GeometricTextureSampler::Synthesize(const TriangleMesh& mesh,
  const GeometricTextureRequest& request, const Observer& observe, const Progress& progress) const
{
  const GeometricTextureLevelRange levels = LevelsToSynthesize(request, this->Model->Options.Levels);
  CheckRequest(*this->Model, request, mesh, levels);
  if (request.SecondModel)
  {
    CheckBlend(*this->Model, request, mesh, levels);
  }
  const MeshTopology topology = RequireValidMesh(mesh, Requirements());
  GeometricTextureSynthesis synthesis(
    *this->Model, mesh, topology, FrameOf(mesh, topology), request.Mask, request.Statistics);
  if (request.Sizes.size() > 0)
  {
    if (request.Sizes.size() != mesh.NumberOfPoints() || !(request.Sizes.array() > 0.0F).all() ||
      !request.Sizes.allFinite())
    {
      RefuseSample("there are " + std::to_string(request.Sizes.size()) + " sizes, or one is not above 0",
        std::to_string(mesh.NumberOfPoints()) + ", one for each vertex, all above 0");
    }
    synthesis.SetSizes(mesh, topology, request.Sizes);
  }
  NoiseSource secondNoise;
  if (request.SecondModel)
  {
    synthesis.SetBlend(*request.SecondModel, request.Blend);
    secondNoise = NoiseOf(request, request.SecondModel->Options);
  }
  return SynthesizeLevels(
    std::move(synthesis), levels, NoiseOf(request, this->Model->Options), observe, progress, {}, secondNoise);
}

GeometricTextureLevel GeometricTextureSampler::Generate(
  int randomFrom, const GeometricTextureRequest& request, const Observer& observe, const Progress& progress) const
{
  const GeometricTextureModel& model = *this->Model;
  RequireTemplate(model, "one, or a mesh to grow on");
  if (randomFrom < 0 || randomFrom > model.Options.Levels)
  {
    RefuseSample("noise is to be random from level " + std::to_string(randomFrom) + " on",
      "0 to " + std::to_string(model.Options.Levels));
  }
  if (randomFrom > 0 && model.Options.FlowSteps > 0)
  {
    RefuseSample("noise is to be random from level " + std::to_string(randomFrom) +
        " on, and the model is a flow, which does not reconstruct its reference",
      "0 (RandomFromLevel)");
  }
  const GeometricTextureLevelRange levels = LevelsToSynthesize(request, model.Options.Levels);
  CheckRequest(model, request, model.Template, levels);
  const NoiseSource random = NoiseOf(request, model.Options);
  const NoiseSource noise = [&](int level, int step, Index points) {
    const bool isRandom = level >= randomFrom;
    return isRandom ? random(level, step, points) : LevelNoise(level == 0 ? 1 : 0, model.ReconstructionNoise);
  };
  return SynthesizeLevels(OnTemplate(model, request), levels, noise, observe, progress);
}

namespace
{
/// Means of statistics over samples.
class StatisticsMeans
{
public:
  explicit StatisticsMeans(const GeometricTextureOptions& options)
    : Shapes(ExpectedGeometricTextureStatistics(options))
    , Norms(static_cast<std::size_t>(options.Layers - 2))
  {}

  /// Adds those of one sample of a level: of all norms, for each step of a flow in turn.
  void Add(int level, const NetworkStatistics& found)
  {
    for (std::size_t j = 0; j < this->Norms; ++j)
    {
      const GeometricTextureStatisticsNames names = NamesOfStatistics(level, static_cast<std::int64_t>(j));
      const Eigen::ArrayXd mean = this->OverSteps(found, j, &ChannelStatistics::Mean);
      const Eigen::ArrayXd variance = this->OverSteps(found, j, &ChannelStatistics::Variance);
      Sum& sum = this->Sums[names.Mean];
      sum.Variance = names.Variance;
      sum.First = sum.Count == 0 ? mean : Eigen::ArrayXd(sum.First + mean);
      sum.Second = sum.Count == 0 ? variance + mean.square() : Eigen::ArrayXd(sum.Second + variance + mean.square());
      ++sum.Count;
    }
  }

  std::map<std::string, ModelTensor> Tensors() const
  {
    std::map<std::string, ModelTensor> tensors;
    for (const auto& [name, sum] : this->Sums)
    {
      const Eigen::ArrayXd mean = sum.First / sum.Count;
      tensors[name] = { this->Shapes.at(name), InSinglePrecision(mean) };
      tensors[sum.Variance] = { this->Shapes.at(sum.Variance),
        InSinglePrecision((sum.Second / sum.Count - mean.square()).max(0.0)) };
    }
    return tensors;
  }

private:
  struct Sum
  {
    std::string Variance; ///< its name
    Eigen::ArrayXd First;
    Eigen::ArrayXd Second;
    int Count = 0;
  };

  /// The statistics after convolution @p norm, those of each step after those of the step before.
  Eigen::ArrayXd OverSteps(
    const NetworkStatistics& found, std::size_t norm, std::vector<double> ChannelStatistics::*which) const
  {
    std::vector<double> values;
    for (std::size_t k = norm; k < found.size(); k += this->Norms)
    {
      values.insert(values.end(), (found[k].*which).begin(), (found[k].*which).end());
    }
    return Eigen::Map<const Eigen::ArrayXd>(values.data(), static_cast<Eigen::Index>(values.size()));
  }

  static std::vector<float> InSinglePrecision(const Eigen::ArrayXd& values)
  {
    std::vector<float> rounded;
    for (const double value : values)
    {
      rounded.push_back(static_cast<float>(value));
    }
    return rounded;
  }

  std::map<std::string, std::vector<std::int64_t>> Shapes;
  std::size_t Norms;               ///< of a level
  std::map<std::string, Sum> Sums; ///< by the names of the means
};
} // namespace

std::map<std::string, ModelTensor> MeasureStatistics(
  const GeometricTextureModel& model, int samples, const Progress& progress)
{
  CheckModel(model);
  RequireTemplate(model, "one, to measure the statistics of its channels on");
  return MeasureStatistics(model, { model.Template }, samples, progress);
}

std::map<std::string, ModelTensor> MeasureStatistics(
  const GeometricTextureModel& model, const std::vector<TriangleMesh>& templates, int samples, const Progress& progress)
{
  CheckModel(model);
  if (samples < 1 || templates.empty())
  {
    RefuseSample("statistics of " + std::to_string(samples) + " samples of " + std::to_string(templates.size()) +
        " references are asked for",
      "at least 1");
  }
  const double all = static_cast<double>(templates.size()) * samples;
  double done = 0.0;
  StatisticsMeans means(model.Options);
  GeometricTextureModel onTemplate = model;
  for (const TriangleMesh& mesh : templates)
  {
    onTemplate.Template = mesh;
    for (int k = 0; k < samples; ++k, ++done)
    {
      GeometricTextureRequest request;
      request.Seed = static_cast<std::uint64_t>(k);
      request.Restarts = 0; // which would add to the statistics of the last steps
      const GeometricTextureLevelRange levels = LevelsToSynthesize(request, model.Options.Levels);
      CheckRequest(onTemplate, request, mesh, levels);
      SynthesizeLevels(OnTemplate(onTemplate, request), levels, NoiseOf(request, model.Options), {},
        SubProgress(progress, done / all, (done + 1.0) / all),
        [&](int level, const NetworkStatistics& found) { means.Add(level, found); });
    }
  }
  return means.Tensors();
}

MeshRequirements GeometricTextureSampler::Requirements()
{
  MeshRequirements requirements;
  requirements.ConsistentWinding = true;
  return requirements;
}

} // namespace surfsynth
