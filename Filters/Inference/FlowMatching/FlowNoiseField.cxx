// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/FlowMatching/FlowNoiseField.h"

#include "Core/Operators/SurfaceOperators.h"

#include <utility>
#include <vector>

namespace surfsynth
{

namespace
{
/// Factors M + s L; returns nothing for noise that is not smoothed.
std::optional<CholeskySolver> MakeSmoother(const TriangleMesh& mesh, const MeshTopology& topology,
  const Eigen::VectorXd& mass, const FlowNoise& noise, const ComponentCoupling& coupling, const Progress& progress)
{
  if (noise.Smoothing == 0.0)
  {
    return std::nullopt;
  }
  // A vertex that no triangle uses has neither mass nor stiffness; any diagonal leaves it alone.
  const Eigen::VectorXd diagonal = (mass.array() > 0.0).select(mass, 1.0);
  SparseMatrix stiffness = CotangentStiffness(mesh, topology);
  const SparseMatrix coupled = CouplingMatrix(mesh, topology, coupling, SubProgress(progress, 0.0, 0.1));
  if (coupled.rows() > 0)
  {
    stiffness += coupled;
  }
  SparseMatrix matrix = noise.Smoothing * stiffness;
  matrix += SparseMatrix(diagonal.asDiagonal());
  return CholeskySolver(matrix, SubProgress(progress, 0.1, 1.0));
}

MaternFieldOptions CoupledOptions(const FlowNoise& noise, const ComponentCoupling& coupling)
{
  MaternFieldOptions options = FieldOptions(noise);
  options.Coupling = coupling;
  return options;
}
} // namespace

FlowNoiseField::FlowNoiseField(TriangleMesh mesh, const MeshTopology& topology, const FlowNoise& noise,
  const Progress& progress, const ComponentCoupling& coupling)
  : Mass(LumpedMass(mesh, topology))
  , Smoother(MakeSmoother(mesh, topology, this->Mass, noise, coupling, SubProgress(progress, 0.0, 0.5)))
  , Field(std::move(mesh), topology, CoupledOptions(noise, coupling), SubProgress(progress, 0.5, 1.0))
{}

void FlowNoiseField::SampleInto(
  const SampleRequest& request, const MaternField::Destination& destination, const Progress& progress) const
{
  if (!this->Smoother)
  {
    this->Field.SampleInto(request, destination, progress);
    return;
  }
  std::vector<double*> samples;
  const auto remember = [&](std::uint32_t sample) { return samples.emplace_back(destination(sample)); };
  this->Field.SampleInto(request, remember, SubProgress(progress, 0.0, 0.5));
  for (std::size_t k = 0; k < samples.size(); ++k)
  {
    Eigen::Map<RowMatrix> values(samples[k], this->Mass.size(), request.NumberOfComponents);
    values = this->Mass.asDiagonal() * values;
    this->Smoother->SolveInPlace(values);
    Report(progress, 0.5 + 0.5 * static_cast<double>(k + 1) / static_cast<double>(samples.size()));
  }
}

} // namespace surfsynth
