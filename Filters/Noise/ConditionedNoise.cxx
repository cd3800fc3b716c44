// SPDX-License-Identifier: BSD-3-Clause
#include "ConditionedNoise.h"

#include "RandomFields.h"
#include "SampleMemory.h"

#include "Core/Common/Errors.h"
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

bool AreSame(const SparseRowMatrix& a, const SparseRowMatrix& b)
{
  return a.rows() == b.rows() && a.cols() == b.cols() && a.nonZeros() == b.nonZeros() &&
    std::equal(a.outerIndexPtr(), a.outerIndexPtr() + a.rows() + 1, b.outerIndexPtr()) &&
    std::equal(a.innerIndexPtr(), a.innerIndexPtr() + a.nonZeros(), b.innerIndexPtr()) &&
    std::equal(a.valuePtr(), a.valuePtr() + a.nonZeros(), b.valuePtr());
}

/// Rows that take a field to its values at the places nearest to the points.
SparseRowMatrix Attach(const Surface& surface, const PointMatrix& points, double tolerance)
{
  return surface.Volume ? ObservationMatrix(*surface.Volume, AttachToVolume(*surface.Volume, points, tolerance))
                        : ObservationMatrix(surface.Mesh, AttachToSurface(surface.Mesh, points, tolerance));
}

/// Adds a point array with the columns of @p values.
void AddArray(vtkDataSet* output, const std::string& name, const Eigen::MatrixXd& values)
{
  const auto array = NewNoiseArray(name, output->GetNumberOfPoints(), static_cast<int>(values.cols()));
  Eigen::Map<RowMatrix>(array->GetPointer(0), values.rows(), values.cols()) = values;
  output->GetPointData()->AddArray(array);
}
} // namespace

ConditionedNoise::Prepared& ConditionedNoise::Prepare(
  const Surface& surface, const MaternField& field, const SampleRequest& request, const Progress& progress)
{
  if (surface.FlatIndex != 0)
  {
    throw InvalidInput("Observations belong to one surface or volume, and the input is composite; one vtkPolyData is "
                       "needed, or one vtkUnstructuredGrid.");
  }
  Observations observations = ReadObservations(
    this->Given, this->Settings.Names, static_cast<int>(request.NumberOfComponents));
  SparseRowMatrix matrix = Attach(surface, observations.Points, this->Settings.Tolerance);
  const auto isCurrent = [&](const Prepared& held) {
    return held.Field == &field && held.Scale == request.Scale && held.Deviations == observations.Deviations &&
      AreSame(held.Matrix, matrix);
  };
  Prepared* held = this->Blocks.Find(surface, isCurrent);
  if (!held)
  {
    const double variance = request.Scale * request.Scale;
    const auto covariance = [&field, variance](const Eigen::Ref<const Eigen::MatrixXd>& values) {
      return Eigen::MatrixXd(variance * field.SolvePrecision(values));
    };
    const std::int64_t limit = this->Settings.MemoryLimit > 0 ? this->Settings.MemoryLimit << 20 : DefaultMemoryLimit();
    this->Blocks.Drop(surface);
    Prepared prepared;
    prepared.Field = &field;
    prepared.Scale = request.Scale;
    prepared.System = std::make_unique<FieldConditioning>(
      covariance, matrix, observations.Deviations, static_cast<std::uint64_t>(limit), progress);
    prepared.Matrix = std::move(matrix);
    prepared.Deviations = std::move(observations.Deviations);
    held = &this->Blocks.Insert(surface, std::move(prepared));
    ++this->Systems;
  }
  held->Values = std::move(observations.Values);
  return *held;
}

void ConditionedNoise::Condition(const Surface& surface, const MaternField& field, const SampleRequest& request,
  const std::vector<double*>& samples, const Progress& progress)
{
  const Prepared& prepared = this->Prepare(surface, field, request, SubProgress(progress, 0.0, 0.5));
  const auto components = static_cast<std::int64_t>(request.NumberOfComponents);
  const auto count = static_cast<std::int64_t>(samples.size());
  const std::int64_t together = std::max<std::int64_t>(1, ColumnsTogether / components);
  const Eigen::Index points = surface.Mesh.NumberOfPoints();
  for (std::int64_t first = 0; first < count; first += together)
  {
    const std::int64_t taken = std::min(together, count - first);
    Eigen::MatrixXd prior(points, taken * components);
    std::vector<NormalKey> keys;
    for (std::int64_t k = 0; k < taken; ++k)
    {
      prior.middleCols(k * components, components) = Eigen::Map<const RowMatrix>(
        samples[static_cast<std::size_t>(first + k)], points, components);
      for (std::int64_t c = 0; c < components; ++c)
      {
        const std::uint32_t sample = request.FirstSample + static_cast<std::uint32_t>(first + k) * request.SampleStep;
        keys.push_back({ request.Seed, sample, static_cast<std::uint32_t>(c), request.Stream });
      }
    }
    const Eigen::MatrixXd posterior = prepared.System->Sample(prior, prepared.Values.replicate(1, taken), keys);
    for (std::int64_t k = 0; k < taken; ++k)
    {
      Eigen::Map<RowMatrix>(samples[static_cast<std::size_t>(first + k)], points, components) = posterior.middleCols(
        k * components, components);
    }
    Report(progress, 0.5 + 0.5 * static_cast<double>(first + taken) / static_cast<double>(count));
  }
}

void ConditionedNoise::AddPosterior(const Surface& surface, vtkDataSet* output, const Progress& progress)
{
  Prepared* prepared = this->Blocks.Find(surface);
  if (!prepared)
  {
    return;
  }
  if (this->Settings.PosteriorMean)
  {
    AddArray(output, this->Settings.OutputArrayName + "_Mean", prepared->System->Mean(prepared->Values));
  }
  if (this->Settings.PosteriorDeviation)
  {
    if (!prepared->Variance)
    {
      const Eigen::VectorXd prior = prepared->Scale * prepared->Scale *
        prepared->Field->MarginalVariances(SubProgress(progress, 0.0, 0.5));
      prepared->Variance = prepared->System->Variance(prior, SubProgress(progress, 0.5, 1.0));
    }
    AddArray(output, this->Settings.OutputArrayName + "_StandardDeviation", prepared->Variance->cwiseSqrt());
  }
}

} // namespace surfsynth
