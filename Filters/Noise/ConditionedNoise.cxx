// SPDX-License-Identifier: BSD-3-Clause
#include "ConditionedNoise.h"

#include "RandomFields.h"
#include "SampleMemory.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Solvers/CholeskySolver.h"

#include <vtkDoubleArray.h>
#include <vtkPointData.h>

#include <algorithm>
#include <utility>

namespace surfsynth
{

namespace
{
/// Columns that are conditioned together.
constexpr std::int64_t ColumnsTogether = 32;
/// Part of an observed displacement that may be left out without a warning, over the longest side of the box.
constexpr double NegligibleDistance = 1e-6;
constexpr std::size_t MostNamed = 10;

bool AreSame(const SparseRowMatrix& a, const SparseRowMatrix& b)
{
  return a.rows() == b.rows() && a.cols() == b.cols() && a.nonZeros() == b.nonZeros() &&
    std::equal(a.outerIndexPtr(), a.outerIndexPtr() + a.rows() + 1, b.outerIndexPtr()) &&
    std::equal(a.innerIndexPtr(), a.innerIndexPtr() + a.nonZeros(), b.innerIndexPtr()) &&
    std::equal(a.valuePtr(), a.valuePtr() + a.nonZeros(), b.valuePtr());
}

/// Adds a point array with the columns of @p values.
void AddArray(vtkDataSet* output, const std::string& name, const Eigen::MatrixXd& values)
{
  const auto array = NewNoiseArray(name, output->GetNumberOfPoints(), static_cast<int>(values.cols()));
  Eigen::Map<RowMatrix>(array->GetPointer(0), values.rows(), values.cols()) = values;
  output->GetPointData()->AddArray(array);
}

/// Displacements, [V, 3], from the unknowns of DisplacementObservations.
Eigen::MatrixXd DisplacementsOf(const SurfaceDisplacement& directions, const Eigen::MatrixXd& unknowns, Index points)
{
  RowMatrix values = RowMatrix::Zero(points, 3);
  Eigen::Map<RowMatrix>(values.data(), unknowns.rows(), unknowns.cols()) = unknowns;
  directions.ToDisplacements(values.data());
  return values;
}
} // namespace

DisplacementObservations ConditionedNoise::Observe(
  const Surface& surface, const Displacement& displacement, int components) const
{
  Observations observations = ReadObservations(this->Given, this->Settings.Names, components);
  if (surface.Volume)
  {
    SparseRowMatrix inside = ObservationMatrix(
      *surface.Volume, AttachToVolume(*surface.Volume, observations.Points, this->Settings.Tolerance));
    return { std::move(inside), std::move(observations.Values), std::move(observations.Deviations), {} };
  }
  const std::vector<SurfacePlace> places = AttachToSurface(surface.Mesh, observations.Points, this->Settings.Tolerance);
  SparseRowMatrix matrix = ObservationMatrix(surface.Mesh, places);
  if (!displacement)
  {
    return { std::move(matrix), std::move(observations.Values), std::move(observations.Deviations), {} };
  }
  if (this->Settings.Targets)
  {
    observations.Values -= matrix * surface.Mesh.Points;
  }
  return displacement->Observe(surface.Mesh, places, observations.Values, observations.Deviations);
}

ConditionedNoise::Prepared& ConditionedNoise::Prepare(const Surface& surface, const MaternField& field,
  const Displacement& displacement, const SampleRequest& request, const Progress& progress)
{
  if (surface.FlatIndex != 0)
  {
    throw InvalidInput("Observations belong to one surface or volume, and the input is composite; one vtkPolyData is "
                       "needed, or one vtkUnstructuredGrid.");
  }
  DisplacementObservations observed = this->Observe(
    surface, displacement, static_cast<int>(request.NumberOfComponents));
  const auto isCurrent = [&](const Prepared& held) {
    return held.Field == &field && held.Directions == displacement && held.Scale == request.Scale &&
      held.Deviations == observed.Deviations && AreSame(held.Matrix, observed.Matrix);
  };
  Prepared* held = this->Blocks.Find(surface, isCurrent);
  if (!held)
  {
    const double variance = request.Scale * request.Scale;
    const FieldConditioning::CovarianceProduct covariance = [&field, variance](
                                                              const Eigen::Ref<const Eigen::MatrixXd>& values) {
      return Eigen::MatrixXd(variance * field.SolvePrecision(values));
    };
    const std::int64_t limit = this->Settings.MemoryLimit > 0 ? this->Settings.MemoryLimit << 20 : DefaultMemoryLimit();
    this->Blocks.Drop(surface);
    Prepared prepared;
    prepared.Field = &field;
    prepared.Directions = displacement;
    prepared.Scale = request.Scale;
    prepared.System = std::make_unique<FieldConditioning>(
      displacement ? displacement->Covariance(covariance) : covariance, observed.Matrix, observed.Deviations,
      static_cast<std::uint64_t>(limit), progress);
    prepared.Matrix = std::move(observed.Matrix);
    prepared.Deviations = std::move(observed.Deviations);
    held = &this->Blocks.Insert(surface, std::move(prepared));
    ++this->Systems;
  }
  held->Values = std::move(observed.Values);
  held->Excluded = std::move(observed.Excluded);
  return *held;
}

std::string ConditionedNoise::WarnOfExcluded(const Surface& surface, const Prepared& prepared)
{
  const double negligible = NegligibleDistance * ComputeBoundingBox(surface.Mesh).LongestSide();
  std::string names;
  std::size_t count = 0;
  for (Eigen::Index i = 0; i < prepared.Excluded.size(); ++i)
  {
    const Eigen::Index row = i * prepared.Deviations.size() / prepared.Excluded.size();
    if (prepared.Excluded[i] > negligible + 2.0 * prepared.Deviations[row])
    {
      names += count < MostNamed ? (count == 0 ? "" : ", ") + std::to_string(i) : count == MostNamed ? ", ..." : "";
      ++count;
    }
  }
  if (count == 0)
  {
    return "";
  }
  this->UnreachedDistance = prepared.Excluded.maxCoeff();
  return "The directions of Displacement exclude parts of " + std::to_string(count) +
    (count == 1 ? " observed displacement: " : " observed displacements: ") + names +
    ". The samples take the other parts of them; the largest one that is left out has the length " +
    FormatNumber(this->UnreachedDistance) + ". Displacement FREE reaches all.";
}

std::string ConditionedNoise::Condition(const Surface& surface, const MaternField& field,
  const Displacement& displacement, const SampleRequest& request, const std::vector<double*>& samples,
  const Progress& progress)
{
  const std::int64_t read = displacement ? 3 : request.NumberOfComponents;
  SampleRequest asked = request;
  asked.NumberOfComponents = static_cast<std::uint32_t>(read);
  const Prepared& prepared = this->Prepare(surface, field, displacement, asked, SubProgress(progress, 0.0, 0.5));
  const auto components = static_cast<std::int64_t>(prepared.Values.cols());
  const auto count = static_cast<std::int64_t>(samples.size());
  const std::int64_t fitting = std::min<std::int64_t>(ColumnsTogether, prepared.System->ColumnsTogether());
  const std::int64_t together = std::max<std::int64_t>(1, fitting / read);
  const Eigen::Index unknowns = prepared.Matrix.cols();
  for (std::int64_t first = 0; first < count; first += together)
  {
    const std::int64_t taken = std::min(together, count - first);
    Eigen::MatrixXd prior(unknowns, taken * components);
    std::vector<NormalKey> keys;
    for (std::int64_t k = 0; k < taken; ++k)
    {
      double* values = samples[static_cast<std::size_t>(first + k)];
      if (displacement && displacement->Directions() == DisplacementDirections::Tangential)
      {
        displacement->ToDisplacements(values);
      }
      prior.middleCols(k * components, components) = Eigen::Map<const RowMatrix>(values, unknowns, components);
      for (std::int64_t c = 0; c < components; ++c)
      {
        const std::uint32_t sample = request.FirstSample + static_cast<std::uint32_t>(first + k) * request.SampleStep;
        keys.push_back({ request.Seed, sample, static_cast<std::uint32_t>(c), request.Stream });
      }
    }
    const Eigen::MatrixXd posterior = prepared.System->Sample(prior, prepared.Values.replicate(1, taken), keys);
    for (std::int64_t k = 0; k < taken; ++k)
    {
      Eigen::Map<RowMatrix>(samples[static_cast<std::size_t>(first + k)], unknowns, components) = posterior.middleCols(
        k * components, components);
    }
    Report(progress, 0.5 + 0.5 * static_cast<double>(first + taken) / static_cast<double>(count));
  }
  return this->WarnOfExcluded(surface, prepared);
}

void ConditionedNoise::AddPosterior(const Surface& surface, vtkDataSet* output, const Progress& progress)
{
  Prepared* prepared = this->Blocks.Find(surface);
  if (!prepared)
  {
    return;
  }
  const SurfaceDisplacement* directions = prepared->Directions.get();
  if (this->Settings.PosteriorMean)
  {
    const Eigen::MatrixXd mean = prepared->System->Mean(prepared->Values);
    AddArray(output, this->Settings.OutputArrayName + "_Mean",
      directions ? DisplacementsOf(*directions, mean, surface.Mesh.NumberOfPoints()) : mean);
  }
  if (this->Settings.PosteriorDeviation)
  {
    if (!prepared->Variance)
    {
      const Eigen::VectorXd prior = prepared->Scale * prepared->Scale *
        prepared->Field->MarginalVariances(SubProgress(progress, 0.0, 0.5));
      prepared->Variance = prepared->System->Variance(
        directions ? directions->UnknownVariances(prior) : prior, SubProgress(progress, 0.5, 1.0));
    }
    AddArray(output, this->Settings.OutputArrayName + "_StandardDeviation",
      directions ? directions->DeviationAlong(*prepared->Variance) : Eigen::VectorXd(prepared->Variance->cwiseSqrt()));
  }
}

} // namespace surfsynth
