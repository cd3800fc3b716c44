// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Statistics/EnsembleMetrics.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Common/Parallel.h"
#include "Core/Common/SharedProgress.h"
#include "Core/Statistics/NearestSamples.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace surfsynth
{

namespace
{
[[noreturn]] void Refuse(const std::string& text) { throw InvalidInput("ComputeEnsembleMetrics: " + text); }

/// Masses divided by their sum. Dividing by the largest first keeps the sum of huge ones finite.
Eigen::VectorXd Weights(const Eigen::VectorXd& mass)
{
  for (Eigen::Index v = 0; v < mass.size(); ++v)
  {
    if (!std::isfinite(mass[v]) || mass[v] < 0.0)
    {
      Refuse("the mass of point " + std::to_string(v) + " is " + FormatNumber(mass[v]) +
        "; expected a finite number of at "
        "least 0.");
    }
  }
  const double largest = mass.size() > 0 ? mass.maxCoeff() : 0.0;
  if (largest <= 0.0)
  {
    Refuse("no point has mass; expected a surface with an area.");
  }
  const Eigen::VectorXd relative = mass / largest;
  return relative / relative.sum();
}

SampleUnion Join(const EnsemblePair& ensembles, const Eigen::VectorXd& mass, const EnsembleMetricsOptions& options)
{
  for (const auto* samples : { &ensembles.Generated, &ensembles.Reference })
  {
    if (samples->empty())
    {
      Refuse(std::string("the ") + (samples == &ensembles.Generated ? "generated" : "reference") +
        " ensemble has no sample; expected at least 1.");
    }
  }
  if (ensembles.NumberOfComponents < 1)
  {
    Refuse("the samples have " + std::to_string(ensembles.NumberOfComponents) + " components; expected at least 1.");
  }
  SampleUnion joined;
  joined.Samples = ensembles.Generated;
  joined.Samples.insert(joined.Samples.end(), ensembles.Reference.begin(), ensembles.Reference.end());
  joined.NumberOfGenerated = static_cast<std::int64_t>(ensembles.Generated.size());
  joined.NumberOfComponents = ensembles.NumberOfComponents;
  joined.Weight = Weights(mass);
  joined.AllWeigh = joined.Weight.minCoeff() > 0.0;
  joined.Centroid = RowMatrix::Zero(joined.Size(), joined.NumberOfComponents);
  joined.Distance = options.Distance;
  return joined;
}

/// Values of one sample that are not finite.
struct Inspection
{
  std::int64_t NonFinite = 0; ///< number of points
  std::int64_t First = -1;    ///< the first point
};

/// Adds up one sample's values times weights to @p mean, and looks for values that are not finite.
Inspection Inspect(const SampleUnion& samples, std::int64_t sample, Eigen::VectorXd& mean, SharedProgress& meter)
{
  const Eigen::Index points = samples.Weight.size();
  const Eigen::Index step = PointsOfBlock(samples);
  const Eigen::Index components = samples.NumberOfComponents;
  RowMatrix planes(components, step);
  Inspection found;
  mean.setZero(components);
  for (Eigen::Index begin = 0; begin < points; begin += step)
  {
    const Eigen::Index count = std::min(step, points - begin);
    CopyPlanes(samples, sample, begin, count, planes.data());
    const Eigen::Map<const RowMatrix> values(planes.data(), components, count);
    const bool finite = values.allFinite(); // of the block at once, because columns are slow to look at
    for (Eigen::Index p = 0; !finite && p < count; ++p)
    {
      if (!values.col(p).allFinite())
      {
        found.First = found.NonFinite++ == 0 ? begin + p : found.First;
      }
    }
    mean.noalias() += values * samples.Weight.segment(begin, count);
    meter.Advance(count);
  }
  return found;
}

/// Refuses values that are not finite; takes the mean value of each sample as its centroid when asked to.
void InspectSamples(SampleUnion& samples, bool removeCentroid, SharedProgress& meter)
{
  std::vector<Inspection> found(samples.Samples.size());
  RowMatrix centroids(samples.Size(), samples.NumberOfComponents);
  const auto inspect = [&](std::int64_t sample) {
    Eigen::VectorXd mean;
    found[static_cast<std::size_t>(sample)] = Inspect(samples, sample, mean, meter);
    centroids.row(sample) = mean;
  };
  ParallelTasks(samples.Size(), inspect, [&] { meter.Advance(0); });
  for (std::int64_t sample = 0; sample < samples.Size(); ++sample)
  {
    const Inspection& of = found[static_cast<std::size_t>(sample)];
    if (of.NonFinite > 0)
    {
      const bool generated = samples.IsGenerated(sample);
      Refuse(std::string(generated ? "generated" : "reference") + " sample " +
        std::to_string(generated ? sample : sample - samples.NumberOfGenerated) + " has " +
        std::to_string(of.NonFinite) + " point(s) with a value that is not finite, first point " +
        std::to_string(of.First) + "; expected finite values at all points of triangles.");
    }
  }
  if (removeCentroid)
  {
    samples.Centroid = centroids;
  }
}

/// The distance of the pointwise means of both ensembles.
double MeanError(const SampleUnion& samples, SharedProgress& meter)
{
  const Eigen::Index points = samples.Weight.size();
  const Eigen::Index step = PointsOfBlock(samples);
  const Eigen::Index blocks = (points + step - 1) / step;
  const double generated = static_cast<double>(samples.NumberOfGenerated);
  const double references = static_cast<double>(samples.Size()) - generated;
  std::vector<double> sums(static_cast<std::size_t>(blocks));
  const auto add = [&](std::int64_t block) {
    const Eigen::Index begin = block * step;
    const Eigen::Index count = std::min(step, points - begin);
    const Eigen::Index size = count * samples.NumberOfComponents;
    Eigen::VectorXd values(size);
    Eigen::VectorXd means[2] = { Eigen::VectorXd::Zero(size), Eigen::VectorXd::Zero(size) };
    for (std::int64_t sample = 0; sample < samples.Size(); ++sample)
    {
      CopyPlanes(samples, sample, begin, count, values.data());
      means[samples.IsGenerated(sample) ? 0 : 1] += values;
      meter.Advance(count);
    }
    means[0] /= generated;
    means[1] /= references;
    sums[static_cast<std::size_t>(block)] = PartialDistance(samples, means[0].data(), means[1].data(), begin, count);
  };
  ParallelTasks(blocks, add, [&] { meter.Advance(0); });
  double sum = 0.0;
  for (const double part : sums)
  {
    sum += part;
  }
  return FinishedDistance(samples.Distance, sum);
}

/// Computes the metrics from the neighbours of all samples.
void AverageNeighbors(const SampleUnion& samples, const std::vector<Neighbors>& neighbors, EnsembleMetrics& metrics)
{
  const std::int64_t generated = samples.NumberOfGenerated;
  const double references = static_cast<double>(samples.Size() - generated);
  std::vector<bool> covered(samples.Samples.size());
  double recognized = 0.0;
  for (std::int64_t sample = 0; sample < samples.Size(); ++sample)
  {
    const Neighbors& found = neighbors[static_cast<std::size_t>(sample)];
    const bool isGenerated = samples.IsGenerated(sample);
    (isGenerated ? metrics.MMD : metrics.ReverseMMD) += found.InOther.Distance;
    if (found.InOwn.Sample >= 0)
    {
      (isGenerated ? metrics.GeneratedSpacing : metrics.ReferenceSpacing) += found.InOwn.Distance;
      recognized += found.InOther.IsBeyond(found.InOwn) ? 1.0 : 0.0;
    }
    if (isGenerated)
    {
      covered[static_cast<std::size_t>(found.InOther.Sample)] = true;
      metrics.NearestReference.push_back(found.InOther.Sample - generated);
      metrics.DistanceToReference.push_back(found.InOther.Distance);
    }
  }
  metrics.MMD /= static_cast<double>(generated);
  metrics.ReverseMMD /= references;
  metrics.GeneratedSpacing /= static_cast<double>(generated);
  metrics.ReferenceSpacing /= references;
  metrics.COV = static_cast<double>(std::count(covered.begin(), covered.end(), true)) / references;
  metrics.OneNearestNeighborAccuracy = recognized / static_cast<double>(samples.Size());
}
} // namespace

EnsembleMetrics ComputeEnsembleMetrics(const EnsemblePair& ensembles, const Eigen::VectorXd& mass,
  const EnsembleMetricsOptions& options, const Progress& progress)
{
  SampleUnion samples = Join(ensembles, mass, options);
  const std::int64_t size = samples.Size();
  SharedProgress meter(progress, (2 * size + size * (size - 1) / 2) * mass.size());
  Report(progress, 0.0);
  InspectSamples(samples, options.RemoveCentroid, meter);
  EnsembleMetrics metrics;
  metrics.MeanError = MeanError(samples, meter);
  AverageNeighbors(samples, FindNeighbors(samples, meter), metrics);
  if (!std::isfinite(
        metrics.MMD + metrics.ReverseMMD + metrics.MeanError + metrics.GeneratedSpacing + metrics.ReferenceSpacing))
  {
    Refuse("the sum of the values or of the distances is not finite; expected values below about 1e150.");
  }
  Report(progress, 1.0);
  return metrics;
}

} // namespace surfsynth
