// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/GeometricTexture/PatchMatching.h"

#include "Core/Common/LoopGrain.h"
#include "Core/Common/Parallel.h"
#include "Core/Random/CounterUniforms.h"
#include "Inference/Common/MatrixProduct.h"
#include "Inference/GeometricTexture/NearestPatches.h"
#include "Inference/GeometricTexture/PatchFit.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <utility>
#include <vector>

namespace surfsynth
{

namespace
{
constexpr std::int64_t Components = TexturePatches::Components;

/// Patches and directions of an iteration of the descent.
constexpr std::int64_t BatchSize = 1024, Directions = 32;
/// First step of Adam over the amplitude of the example; it falls linearly to a tenth.
constexpr float FirstStep = 0.05F, LastPart = 0.1F;
constexpr float FirstDecay = 0.9F, SecondDecay = 0.99F;

/// Power of the differences that a fit descends, and the part of the mean square difference that is added to each.
constexpr double RobustPower = 0.8, LeastDifference = 0.05;
/// Completeness over the mean square displacement of the example: see NearestPatches::Prefer().
constexpr double Completeness = 0.05;

/// Part of the mismatch that an iteration takes away at least, and how many in a row that take less are the last ones.
constexpr double LeastProgress = 0.003;
constexpr int LastIterations = 2;

/// Passes that give the patches the deviations of those of the example, bounds of the factors, and the fewest patches whose
/// deviations say something.
constexpr int DeviationPasses = 2;
constexpr float LeastFactor = 0.5F, MostFactor = 2.0F;
constexpr std::int64_t FewestForDeviations = 256;

/// Streams of random numbers, as components of the key.
enum Purpose : std::uint32_t
{
  DirectionNumbers = 1,
  PatchChoice = 2,
  ExampleChoice = 3
};

/// Calls body(r) for the rows [0, rows) in parallel.
template <typename Body>
void ForRows(std::int64_t rows, std::int64_t grain, const Body& body)
{
  ParallelFor(rows, grain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t r = begin; r < end; ++r)
    {
      body(r);
    }
  });
}

/// Multiplies in tiles of rows, in parallel.
PatchRows Product(const PatchRows& a, const PatchRows& b)
{
  constexpr std::int64_t tile = 256;
  PatchRows c(a.rows(), b.cols());
  ForRows((a.rows() + tile - 1) / tile, 1, [&](std::int64_t t) {
    const std::int64_t rows = std::min(tile, a.rows() - t * tile);
    Multiply(a.row(t * tile).data(), b.data(), c.row(t * tile).data(), rows, a.cols(), b.cols());
  });
  return c;
}

/// Descent of the sliced Wasserstein distance.
class DistributionDescent
{
public:
  DistributionDescent(
    const TexturePatches& patches, const ExamplePatches& example, const NormalKey& key, Index vertices)
    : Patches(patches)
    , Example(example)
    , Key(key)
    , Roots(PatchWeights().cwiseSqrt())
    , First(SinglePoints::Zero(vertices, 3))
    , Second(SinglePoints::Zero(vertices, 3))
  {
    for (std::int64_t p = 0; p < patches.Count(); ++p)
    {
      if (patches.IsComplete(p))
      {
        this->Complete.push_back(p);
      }
    }
    this->Batch = std::min<std::int64_t>(BatchSize, static_cast<std::int64_t>(this->Complete.size()));
  }

  bool IsEmpty() const { return this->Batch == 0; }

  /// Moves the displacements once.
  void Step(int iteration, float step, SinglePoints& displacement)
  {
    this->Choose(iteration);
    PatchRows own(this->Batch, Components), others(this->Batch, Components);
    ForRows(this->Batch, 64, [&](std::int64_t b) {
      this->Patches.Read(this->Chosen[static_cast<std::size_t>(b)], displacement, own.row(b).data());
      const NormalKey key = this->KeyOf(ExampleChoice, iteration);
      others.row(b) = this->Example.Values.row(UniformIndex(key, b, this->Example.Count()));
    });
    const PatchRows directions = this->DrawDirections(iteration);
    PatchRows slices = Product(own, directions);
    this->Compare(slices, Product(others, directions));
    const PatchRows transposed = directions.transpose();
    const PatchRows gradients = Product(slices, transposed);
    SinglePoints gradient = SinglePoints::Zero(displacement.rows(), 3);
    for (std::int64_t b = 0; b < this->Batch; ++b)
    {
      this->Patches.AddTransposed(this->Chosen[static_cast<std::size_t>(b)], gradients.row(b).data(), gradient);
    }
    this->Move(gradient, iteration, step, displacement);
  }

private:
  NormalKey KeyOf(Purpose purpose, int iteration) const
  {
    NormalKey key = this->Key;
    key.Component = purpose + 8 * static_cast<std::uint32_t>(iteration);
    return key;
  }

  /// Draws a batch without repetition: the first places of a random permutation.
  void Choose(int iteration)
  {
    const NormalKey key = this->KeyOf(PatchChoice, iteration);
    const auto count = static_cast<std::int64_t>(this->Complete.size());
    for (std::int64_t b = 0; b < this->Batch; ++b)
    {
      const std::int64_t other = b + UniformIndex(key, b, count - b);
      std::swap(this->Complete[static_cast<std::size_t>(b)], this->Complete[static_cast<std::size_t>(other)]);
    }
    this->Chosen.assign(this->Complete.begin(), this->Complete.begin() + this->Batch);
  }

  /// Draws weighted random directions, [Components, Directions], of length 1.
  PatchRows DrawDirections(int iteration) const
  {
    PatchRows directions(Components, Directions);
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> numbers(Components, Directions);
    FillNormals(this->KeyOf(DirectionNumbers, iteration), 0, numbers.size(), numbers.data());
    for (std::int64_t c = 0; c < Components; ++c)
    {
      directions.row(c) = this->Roots(c / 3) * numbers.row(c).cast<float>();
    }
    directions.array().rowwise() /= directions.colwise().norm().array().eval();
    return directions;
  }

  /// Replaces each number by its difference from the one of the same rank of the example, in every column.
  void Compare(PatchRows& slices, const PatchRows& ofExample) const
  {
    // Columns of small batches are sorted faster than a thread starts.
    const std::int64_t grain = std::max<std::int64_t>(1, FineGrain / std::max<std::int64_t>(1, slices.rows()));
    ForRows(slices.cols(), grain, [&](std::int64_t column) {
      std::vector<std::pair<float, std::int64_t>> own(static_cast<std::size_t>(slices.rows()));
      std::vector<float> others(own.size());
      for (std::size_t b = 0; b < own.size(); ++b)
      {
        const auto row = static_cast<Eigen::Index>(b);
        own[b] = { slices(row, column), row };
        others[b] = ofExample(row, column);
      }
      std::sort(own.begin(), own.end());
      std::sort(others.begin(), others.end());
      for (std::size_t b = 0; b < own.size(); ++b)
      {
        slices(own[b].second, column) = own[b].first - others[b];
      }
    });
  }

  void Move(const SinglePoints& gradient, int iteration, float step, SinglePoints& displacement)
  {
    const float first = 1.0F - std::pow(FirstDecay, static_cast<float>(iteration + 1));
    const float second = 1.0F - std::pow(SecondDecay, static_cast<float>(iteration + 1));
    this->First = FirstDecay * this->First + (1.0F - FirstDecay) * gradient;
    this->Second = SecondDecay * this->Second + (1.0F - SecondDecay) * gradient.cwiseAbs2();
    displacement.array() -= step * (this->First.array() / first) /
      ((this->Second.array() / second).sqrt() + std::numeric_limits<float>::min());
  }

  const TexturePatches& Patches;
  const ExamplePatches& Example;
  NormalKey Key;
  Eigen::VectorXf Roots; ///< of the weights of the samples
  std::vector<std::int64_t> Complete;
  std::vector<std::int64_t> Chosen;
  std::int64_t Batch = 0;
  SinglePoints First, Second; ///< means of the gradient and of its square
};

/// Reads all patches; samples beyond a boundary are those of the patch that was the nearest, or of the mean patch.
PatchRows ReadCompleted(const TexturePatches& patches, const ExamplePatches& example, const std::vector<Index>& nearest,
  const SinglePoints& displacement)
{
  PatchRows values(patches.Count(), Components);
  ForRows(patches.Count(), 64, [&](std::int64_t p) {
    patches.Read(p, displacement, values.row(p).data());
    for (int k = 0; k < TexturePatches::Samples && !patches.IsComplete(p); ++k)
    {
      if (!patches.IsInside(p, k))
      {
        values.row(p).segment<3>(3 * k) = nearest.empty()
          ? Eigen::RowVector3f(example.Mean.segment<3>(3 * k).transpose())
          : Eigen::RowVector3f(example.Values.row(nearest[static_cast<std::size_t>(p)]).segment<3>(3 * k));
      }
    }
  });
  return values;
}

/// Returns the weighted mean squares of the differences of patches from the nearest ones of the example, [count]; of samples
/// inside.
Eigen::VectorXd SquaredDifferences(const TexturePatches& patches, const PatchRows& values,
  const ExamplePatches& example, const std::vector<Index>& nearest)
{
  const Eigen::VectorXf weights = PatchWeights();
  Eigen::VectorXd ofPatch(values.rows());
  ForRows(values.rows(), 256, [&](std::int64_t p) {
    double sum = 0.0, weight = 0.0;
    for (int k = 0; k < TexturePatches::Samples; ++k)
    {
      if (!patches.IsInside(p, k))
      {
        continue;
      }
      weight += static_cast<double>(weights(k));
      const auto other = example.Values.row(nearest[static_cast<std::size_t>(p)]).segment<3>(3 * k);
      sum += static_cast<double>(weights(k) * (values.row(p).segment<3>(3 * k) - other).squaredNorm());
    }
    ofPatch(p) = sum / weight; // the center is inside
  });
  return ofPatch;
}

/// Returns factors of the weights of patches, 1 in the mean, that make a fit to their displacements one of the power
/// RobustPower of the differences [Kwatra2005].
Eigen::VectorXf RobustFactors(const Eigen::VectorXd& squares)
{
  const double least = std::max(LeastDifference * squares.mean(), std::numeric_limits<double>::min());
  const Eigen::VectorXd factors = (squares.array() + least).pow(0.5 * RobustPower - 1.0);
  return (factors / factors.mean()).cast<float>();
}

/// Returns the standard deviations of columns.
Eigen::ArrayXf DeviationsOf(const PatchRows& rows)
{
  const Eigen::RowVectorXd mean = rows.cast<double>().colwise().mean();
  return (rows.cast<double>().rowwise() - mean).array().square().colwise().mean().sqrt().cast<float>().transpose();
}

/// Stretches the patches along the principal components of the example, until their deviations are those of its patches: the
/// mean of patches that do not quite agree is lower than each of them.
class DeviationMatch
{
public:
  explicit DeviationMatch(const ExamplePatches& example)
    : Basis(example.Basis)
    , Asked(DeviationsOf(example.Coordinates.transpose()))
    , Back(example.Basis.transpose())
  {
    const Eigen::VectorXf weights = PatchWeights();
    for (Eigen::Index c = 0; c < this->Back.cols(); ++c)
    {
      this->Back.col(c) /= weights(c / 3); // the root of the weight is in the basis, and once more in its inverse
    }
  }

  void Stretch(PatchRows& values) const
  {
    PatchRows coordinates = Product(values, this->Basis);
    const Eigen::ArrayXf found = DeviationsOf(coordinates).max(std::numeric_limits<float>::min());
    const Eigen::ArrayXf factors = (this->Asked / found).max(LeastFactor).min(MostFactor);
    const Eigen::RowVectorXf mean = coordinates.colwise().mean();
    coordinates = (coordinates.rowwise() - mean) * (factors - 1.0F).matrix().asDiagonal();
    values += Product(coordinates, this->Back);
  }

private:
  PatchRows Basis;
  Eigen::ArrayXf Asked;
  PatchRows Back; ///< [D, C], displacements of a coordinate
};

/// Patches of a target and the nearest ones of their example.
class NearestMatch
{
public:
  explicit NearestMatch(const PatchShare& share)
    : Share(share)
    , Search(share.Example)
    , Deviations(share.Example)
  {}

  /// Finds the nearest patches.
  void Find(const SinglePoints& displacement, const Progress& progress)
  {
    const ExamplePatches& example = this->Share.Example;
    const PatchRows values = ReadCompleted(this->Share.Patches, example, this->Nearest, displacement);
    const PatchRows coordinates = Product(values, example.Basis);
    const bool first = this->Nearest.empty();
    if (first)
    {
      const double completeness = std::max(Completeness * example.Amplitude * example.Amplitude, 1e-30);
      this->Search.Prefer(coordinates, static_cast<float>(completeness), SubProgress(progress, 0.0, 0.5));
    }
    this->Nearest = this->Search.Find(coordinates, SubProgress(progress, first ? 0.5 : 0.0, 1.0));
    this->Squares = SquaredDifferences(this->Share.Patches, values, example, this->Nearest);
  }

  Eigen::VectorXf Factors() const { return RobustFactors(this->Squares); }
  const float* NearestRow(std::int64_t patch) const
  {
    return this->Share.Example.Values.row(this->Nearest[static_cast<std::size_t>(patch)]).data();
  }

  /// Returns true where the patches are so many that their deviations say something.
  bool AreMany() const { return this->Share.Patches.Count() >= FewestForDeviations; }

  /// Reads the patches, and stretches them where they are many.
  PatchRows Stretched(const SinglePoints& displacement) const
  {
    PatchRows values = ReadCompleted(this->Share.Patches, this->Share.Example, this->Nearest, displacement);
    if (this->AreMany())
    {
      this->Deviations.Stretch(values);
    }
    return values;
  }

  /// Root of the mean square difference from the nearest patches, over the amplitude of the example.
  double Mismatch() const
  {
    const double amplitude = this->Share.Example.Amplitude;
    return amplitude > 0.0 && this->Squares.size() > 0 ? std::sqrt(this->Squares.mean()) / amplitude : 0.0;
  }

private:
  PatchShare Share;
  NearestPatches Search;
  DeviationMatch Deviations;
  std::vector<Index> Nearest;
  Eigen::VectorXd Squares; ///< [count], of the differences
};
} // namespace

void MatchDistribution(const TexturePatches& patches, const ExamplePatches& example, const NormalKey& key,
  double spacing, int iterations, SinglePoints& displacement, const Progress& progress)
{
  DistributionDescent descent(patches, example, key, static_cast<Index>(displacement.rows()));
  const auto first = FirstStep * static_cast<float>(example.Amplitude * spacing);
  for (int iteration = 0; iteration < iterations && !descent.IsEmpty(); ++iteration)
  {
    Report(progress, static_cast<double>(iteration) / iterations);
    const float passed = static_cast<float>(iteration) / static_cast<float>(iterations);
    descent.Step(iteration, first * (1.0F - (1.0F - LastPart) * passed), displacement);
  }
}

double MatchNearest(const PatchSurface& surface, const std::vector<PatchShare>& shares, int iterations,
  SinglePoints& displacement, const Progress& progress)
{
  std::vector<NearestMatch> matches(shares.begin(), shares.end());
  std::vector<const TexturePatches*> sets;
  std::transform(
    shares.begin(), shares.end(), std::back_inserter(sets), [](const PatchShare& s) { return &s.Patches; });
  PatchFit fit(surface.Mesh, sets);
  const int steps = iterations + DeviationPasses;
  double mismatches = 0.0; // sum of the shares
  int slow = 0;
  for (int iteration = 0; iteration < iterations && slow < LastIterations; ++iteration)
  {
    const double last = std::exchange(mismatches, 0.0);
    std::vector<Eigen::VectorXf> factors;
    for (std::size_t k = 0; k < matches.size(); ++k)
    {
      const double begin = iteration + static_cast<double>(k) / static_cast<double>(matches.size());
      matches[k].Find(displacement, SubProgress(progress, begin / steps, (iteration + 1.0) / steps));
      factors.push_back(matches[k].Factors());
      mismatches += matches[k].Mismatch();
    }
    slow = iteration > 0 && !(mismatches < (1.0 - LeastProgress) * last) ? slow + 1 : 0;
    fit.Weigh(std::move(factors));
    fit.Fit([&](std::size_t k, std::int64_t p) { return matches[k].NearestRow(p); }, displacement);
  }
  const bool areMany = std::any_of(matches.begin(), matches.end(), [](const NearestMatch& m) { return m.AreMany(); });
  for (int pass = 0; areMany && pass < DeviationPasses; ++pass)
  {
    Report(progress, static_cast<double>(iterations + pass) / steps);
    std::vector<PatchRows> values;
    std::transform(matches.begin(), matches.end(), std::back_inserter(values),
      [&](const NearestMatch& match) { return match.Stretched(displacement); });
    fit.Fit([&](std::size_t k, std::int64_t p) { return values[k].row(p).data(); }, displacement);
  }
  double mismatch = 0.0;
  for (const NearestMatch& match : matches)
  {
    mismatch = std::max(mismatch, match.Mismatch());
  }
  return mismatch;
}

} // namespace surfsynth
