// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Noise/GaussianMixtures.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Common/Parallel.h"
#include "Core/Random/CounterUniforms.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace surfsynth
{

namespace
{
void CheckOptions(const GaussianMixtureOptions& options)
{
  if (options.NumberOfCenters < 1)
  {
    throw InvalidInput("GaussianMixtures: the number of centres is " + std::to_string(options.NumberOfCenters) +
      "; at least 1 is needed.");
  }
  if (!(options.Width > 0.0) || !std::isfinite(options.Width))
  {
    throw InvalidInput(
      "GaussianMixtures: the width is " + FormatNumber(options.Width) + "; a finite number larger than 0 is needed.");
  }
  if (!(options.Separation >= 0.0) || !std::isfinite(options.Separation))
  {
    throw InvalidInput("GaussianMixtures: the separation is " + FormatNumber(options.Separation) +
      "; a finite number of at least 0 is needed.");
  }
}
} // namespace

/// Samples that are drawn together: their distances are solved for with many right-hand sides.
struct GaussianMixtures::Group
{
  std::vector<std::uint32_t> Samples;
  std::vector<double*> Values;
  std::vector<Index> Centers;             ///< the latest of each sample
  std::vector<Eigen::VectorXd> ToNearest; ///< of each sample: distance from each vertex to the nearest centre so far
};

GaussianMixtures::GaussianMixtures(const TriangleMesh& mesh, const MeshTopology& topology,
  const GaussianMixtureOptions& options, const Progress& progress)
  : Options(options)
  , Geodesics((CheckOptions(options), mesh), topology, progress)
  , Sigma(options.Width * std::sqrt(Geodesics.Mass().sum()))
{}

void GaussianMixtures::SampleInto(
  const GaussianMixtureRequest& request, const Destination& destination, const Progress& progress) const
{
  const std::uint64_t last = request.FirstSample +
    std::uint64_t(request.SampleStep) * (request.NumberOfSamples > 0 ? request.NumberOfSamples - 1 : 0);
  if (last > std::numeric_limits<std::uint32_t>::max())
  {
    throw InvalidInput(
      "GaussianMixtures: sample " + std::to_string(last) + " is asked for; samples end at 4294967295.");
  }
  const std::uint32_t together = static_cast<std::uint32_t>(CholeskySolver::BlockColumns * MaximumThreads());
  for (std::uint32_t begin = 0; begin < request.NumberOfSamples; begin += together)
  {
    Report(progress, static_cast<double>(begin) / request.NumberOfSamples);
    Group group;
    for (std::uint32_t k = begin; k < std::min(begin + together, request.NumberOfSamples); ++k)
    {
      group.Samples.push_back(request.FirstSample + k * request.SampleStep);
      group.Values.push_back(destination(group.Samples.back()));
    }
    this->SampleGroup(request, group);
  }
  Report(progress, 1.0);
}

void GaussianMixtures::SampleGroup(const GaussianMixtureRequest& request, Group& group) const
{
  const Eigen::VectorXd& mass = this->Geodesics.Mass();
  const std::size_t count = group.Samples.size();
  group.ToNearest.assign(count, Eigen::VectorXd::Constant(mass.size(), std::numeric_limits<double>::infinity()));
  group.Centers.resize(count);
  for (double* values : group.Values)
  {
    std::fill_n(values, mass.size(), 0.0);
  }
  for (int center = 0; center < this->Options.NumberOfCenters; ++center)
  {
    for (std::size_t k = 0; k < count; ++k)
    {
      NormalKey key;
      key.Seed = request.Seed;
      key.Sample = group.Samples[k];
      key.Component = static_cast<std::uint32_t>(center);
      key.Stream = request.Stream;
      group.Centers[k] = this->ChooseCenter(group, k, Uniform(key, 0));
    }
    this->AddGaussians(group);
  }
}

/// The vertex at which the cumulated mass of those that are far enough from the earlier centres reaches @p uniform of
/// its sum.
Index GaussianMixtures::ChooseCenter(const Group& group, std::size_t member, double uniform) const
{
  const Eigen::VectorXd& mass = this->Geodesics.Mass();
  const Eigen::VectorXd& toNearest = group.ToNearest[member];
  const double separation = this->Options.Separation * this->Sigma;
  const auto massOf = [&](Index v) { return toNearest[v] >= separation ? mass[v] : 0.0; };
  double sum = 0.0;
  for (Index v = 0; v < mass.size(); ++v)
  {
    sum += massOf(v);
  }
  double rest = uniform * sum;
  Index chosen = -1;
  for (Index v = 0; v < mass.size() && rest >= 0.0; ++v)
  {
    if (massOf(v) > 0.0)
    {
      chosen = v;
      rest -= massOf(v);
    }
  }
  if (chosen < 0)
  {
    throw InvalidInput("GaussianMixtures: no vertex is left for a centre of sample " +
      std::to_string(group.Samples[member]) + ": all are closer than the separation, " + FormatNumber(separation) +
      ", to the earlier centres; fewer centres, a smaller width or a smaller separation is needed.");
  }
  return chosen;
}

void GaussianMixtures::AddGaussians(Group& group) const
{
  const RowMatrix distances = this->Geodesics.Distances(group.Centers);
  const double factor = -0.5 / (this->Sigma * this->Sigma);
  ParallelFor(static_cast<std::int64_t>(group.Samples.size()), 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t k = begin; k < end; ++k)
    {
      for (Eigen::Index v = 0; v < distances.rows(); ++v)
      {
        const double distance = distances(v, k);
        group.ToNearest[k][v] = std::min(group.ToNearest[k][v], distance);
        // At the center whatever the factor is: a tiny width makes it infinite.
        group.Values[k][v] += distance == 0.0 ? 1.0 : std::exp(factor * distance * distance);
      }
    }
  });
}

} // namespace surfsynth
