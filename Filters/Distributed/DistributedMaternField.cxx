// SPDX-License-Identifier: BSD-3-Clause
#include "Distributed/DistributedMaternField.h"

#include "Distributed/DistributedSystem.h"
#include "Distributed/PieceMerge.h"
#include "Distributed/RowAssembly.h"
#include "Distributed/SeamTopology.h"
#include "Distributed/VertexOwners.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Mesh/MeshCheck.h"
#include "Core/Noise/MaternFieldInternals.h"
#include "Core/Random/CounterNormals.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace surfsynth
{

namespace
{
constexpr double LargestResidual = 1e-8;

/// Checks the mesh of one rank, whose defects are named by cells of the piece and points of the whole.
MeshTopology CheckPiece(const MergedPiece& piece)
{
  std::vector<MeshFinding> findings = CheckMesh(piece.Mesh, MeshRequirements());
  for (MeshFinding& finding : findings)
  {
    if (!HasTriangleIds(finding.Defect))
    {
      finding.First = piece.WholeIds[static_cast<std::size_t>(finding.First)];
    }
  }
  if (!findings.empty())
  {
    throw InvalidInput(
      DescribeFindings(findings, [&](std::int64_t f) { return piece.CellOfTriangle[static_cast<std::size_t>(f)]; }));
  }
  return MeshTopology(piece.Mesh);
}

double LongestSideOf(const RankGroup& ranks, const TriangleMesh& mesh)
{
  const BoundingBox box = ComputeBoundingBox(mesh);
  const bool isEmpty = mesh.NumberOfTriangles() == 0;
  double longest = 0.0;
  for (int k = 0; k < 3; ++k)
  {
    const double none = -std::numeric_limits<double>::max();
    const double upper = ranks.Maximum(isEmpty ? none : box.Upper[k]);
    const double lower = -ranks.Maximum(isEmpty ? none : -box.Lower[k]);
    longest = std::max(longest, upper - lower);
  }
  return longest;
}
} // namespace

void RequireDistributedOptions(const MaternFieldOptions& options)
{
  const MaternFieldArrays& arrays = options.Arrays;
  const std::pair<bool, const char*> refused[] = {
    { options.Model != NoiseModel::Matern, "the noise model is another than Matern" },
    { options.OperatorPower != 2.0 && options.OperatorPower != 4.0, "the operator power is another than 2 and 4" },
    { options.VarianceCorrection, "the variance is corrected" },
    { options.Boundary != BoundaryCondition::Neumann, "the boundary condition is another than Neumann" },
    { options.CoherentNoise, "the noise is coherent" },
    { arrays.RangeFactors.size() > 0 || arrays.Directions.size() > 0 || !arrays.BoundaryMask.empty() ||
        !arrays.Barrier.empty(),
      "arrays vary the field" },
  };
  for (const auto& [isRefused, text] : refused)
  {
    if (isRefused)
    {
      throw InvalidInput(std::string("DistributedMaternField: ") + text +
        "; expected what a surface in pieces is solved with: the model Matern of operator power 2 or 4, with the "
        "boundary "
        "condition Neumann and without arrays, variance correction and coherent noise.");
    }
  }
  RequireOptions(options, 2);
}

class DistributedMaternField::Internals
{
public:
  Internals(const RankGroup& ranks, const MeshPiece& piece, const MaternFieldOptions& options, const Progress& progress)
    : Ranks(ranks)
    , Options(options)
  {
    MergedPiece merged = MergePiece(ranks, piece);
    this->VertexOfPoint = std::move(merged.VertexOfPoint);
    this->WholePoints = merged.NumberOfWholePoints;
    std::optional<MeshTopology> topology;
    ranks.Together([&] {
      Report(progress, 0.1);
      topology = CheckPiece(merged);
    });
    this->LongestEdge = ranks.Maximum(LongestEdgeForRange(merged.Mesh, MaternFieldOptions()));
    this->LongestSide = LongestSideOf(ranks, merged.Mesh);
    const Eigen::VectorXd mass = LumpedMass(merged.Mesh, *topology);
    const MeshComponents components = ComputeComponents(*topology, mass);
    this->Owners.emplace(ranks, merged, components.OfVertex);
    const ComponentParts parts = JoinComponents(*this->Owners, merged, *topology, components);
    const Eigen::VectorXd ownMass = this->Owners->Sum(mass);
    this->RootMass = ownMass.cwiseSqrt();
    for (const Index v : this->Owners->OwnVertices)
    {
      this->WholeIds.push_back(merged.WholeIds[static_cast<std::size_t>(v)]);
    }
    DistributedRows rows = AssembleRows(*this->Owners, CotangentStiffness(merged.Mesh, *topology));
    topology.reset();
    merged = {};
    ranks.Together([&] { Report(progress, 0.3); });
    this->ChooseScreening(rows, ownMass);
    this->ChooseAmplitude(components, parts);
    AddToDiagonal(rows, ownMass, this->Tau);
    ranks.Together([&] { Report(progress, 0.4); });
    this->System.emplace(ranks, std::move(rows));
    ranks.Together([&] { Report(progress, 1.0); });
  }

  /// Writes one component of one sample for the points of the piece, @p stride numbers apart.
  void SampleColumn(const NormalKey& key, double scale, double* values, std::size_t stride, const Progress& progress)
  {
    Eigen::VectorXd rows(this->RootMass.size());
    for (Eigen::Index k = 0; k < rows.size(); ++k)
    {
      rows[k] = this->RootMass[k] * Normal(key, this->WholeIds[static_cast<std::size_t>(k)]);
    }
    const bool hasTwo = this->Options.OperatorPower == 4.0;
    this->Solve(rows, SubProgress(progress, 0.0, hasTwo ? 0.5 : 1.0));
    if (hasTwo)
    {
      rows.array() *= this->RootMass.array().square();
      this->Solve(rows, SubProgress(progress, 0.5, 1.0));
    }
    const Eigen::VectorXd vertices = this->Owners->Spread(rows);
    for (std::size_t p = 0; p < this->VertexOfPoint.size(); ++p)
    {
      const Index v = this->VertexOfPoint[p];
      values[p * stride] = v < 0 ? 0.0 : scale * this->Amplitude[v] * vertices[v];
    }
  }

  RankGroup Ranks;
  MaternFieldOptions Options;
  double Tau = 0.0;
  double Gamma = 0.0;
  double LongestEdge = 0.0;
  double LongestSide = 0.0;
  double Residual = 0.0;
  std::int64_t WholePoints = 0;
  std::optional<DistributedSystem> System;

private:
  void Solve(Eigen::VectorXd& rows, const Progress& progress)
  {
    const double residual = this->System->SolveInPlace(rows, progress);
    this->Residual = std::max(this->Residual, residual);
    if (!(residual <= LargestResidual))
    {
      throw SolverFailure("DistributedMaternField: the relative residual of the solve is " + FormatNumber(residual) +
        "; expected at most 1e-8. Needle triangles, or a screening term that is tiny for the size of the mesh, make "
        "the "
        "system ill-conditioned: remesh, or use a smaller correlation range.");
    }
  }

  /// Collective; what it throws, it throws on all ranks.
  void ChooseScreening(const DistributedRows& stiffness, const Eigen::VectorXd& mass)
  {
    this->Gamma = std::sqrt(this->Ranks.Sum(SquaredLaplacian(stiffness, mass)));
    const double asked = this->Options.CorrelationRange;
    const double range = asked > 0.0 ? asked : 0.2 * this->LongestSide;
    const double smoothness = this->Options.OperatorPower - 1.0;
    this->Tau = this->Options.Mode == ScaleMode::CorrelationRange ? 8.0 * smoothness / (range * range)
      : this->Options.Mode == ScaleMode::Screening                ? this->Options.Screening
                                                                  : this->Gamma * this->Options.NormalizedScreening;
    RequireOption(this->Tau > 0.0 && std::isfinite(this->Tau), "the screening term that follows from the options",
      this->Tau, "a finite number above 0");
  }

  /// Factors of the vertices of this rank, used or shared. Collective.
  void ChooseAmplitude(const MeshComponents& components, const ComponentParts& parts)
  {
    const double smoothness = this->Options.OperatorPower - 1.0;
    std::vector<double> factors;
    for (Index c = 0; c < components.Count; ++c)
    {
      factors.push_back(this->Options.StandardDeviation /
        std::sqrt(MarginalVariance(
          this->Tau, parts.Area[c], parts.EulerCharacteristic[c], parts.Closed[c], this->Options.OperatorPower)));
    }
    const auto vertices = static_cast<Eigen::Index>(components.OfVertex.size());
    this->Amplitude = Eigen::VectorXd::Ones(vertices);
    if (this->Options.Mode == ScaleMode::NormalizedScreening)
    {
      this->Amplitude *= std::pow(std::sqrt(this->Gamma), smoothness);
    }
    if (this->Options.Mode == ScaleMode::CorrelationRange)
    {
      // The owner uses the vertex wherever a rank does: its factor is that of the component.
      Eigen::VectorXd own(static_cast<Eigen::Index>(this->Owners->OwnVertices.size()));
      for (std::size_t k = 0; k < this->Owners->OwnVertices.size(); ++k)
      {
        const Index c = components.OfVertex[static_cast<std::size_t>(this->Owners->OwnVertices[k])];
        own[static_cast<Eigen::Index>(k)] = c >= 0 ? factors[static_cast<std::size_t>(c)] : 0.0;
      }
      this->Amplitude = this->Owners->Spread(own);
    }
  }

  std::vector<Index> VertexOfPoint;
  std::vector<std::int64_t> WholeIds; ///< of own rows
  std::optional<VertexOwners> Owners;
  Eigen::VectorXd RootMass;  ///< of own rows; 0 where no triangle uses the vertex
  Eigen::VectorXd Amplitude; ///< of the vertices of this rank
};

DistributedMaternField::DistributedMaternField(
  const RankGroup& ranks, const MeshPiece& piece, const MaternFieldOptions& options, const Progress& progress)
{
  ranks.Together([&] { RequireDistributedOptions(options); });
  this->Impl = std::make_unique<Internals>(ranks, piece, options, progress);
}

DistributedMaternField::~DistributedMaternField() = default;
DistributedMaternField::DistributedMaternField(DistributedMaternField&&) noexcept = default;
DistributedMaternField& DistributedMaternField::operator=(DistributedMaternField&&) noexcept = default;

void DistributedMaternField::SampleInto(
  const SampleRequest& request, const MaternField::Destination& destination, const Progress& progress)
{
  const std::size_t components = request.NumberOfComponents;
  std::vector<double*> samples;
  this->Impl->Ranks.Together([&] {
    if (components < 1 ||
      request.FirstSample + std::uint64_t(request.NumberOfSamples) * request.SampleStep > 0x100000000ULL)
    {
      throw InvalidInput("DistributedMaternField: no component, or a sample beyond number 4294967295, asked for; "
                         "expected at least one, and "
                         "lower numbers.");
    }
    for (std::uint32_t k = 0; k < request.NumberOfSamples; ++k)
    {
      samples.push_back(destination(request.FirstSample + k * request.SampleStep));
    }
  });
  this->Impl->Residual = 0.0;
  const double columns = static_cast<double>(samples.size() * components);
  double done = 0.0;
  for (std::size_t k = 0; k < samples.size(); ++k)
  {
    for (std::size_t component = 0; component < components; ++component)
    {
      NormalKey key;
      key.Seed = request.Seed;
      key.Sample = request.FirstSample + static_cast<std::uint32_t>(k) * request.SampleStep;
      key.Component = static_cast<std::uint32_t>(component);
      key.Stream = request.Stream;
      this->Impl->SampleColumn(key, request.Scale, samples[k] + component, components,
        SubProgress(progress, done / columns, (done + 1.0) / columns));
      done += 1.0;
    }
  }
}

double DistributedMaternField::EffectiveScreening() const { return this->Impl->Tau; }

double DistributedMaternField::EffectiveCorrelationRange() const
{
  return std::sqrt(8.0 * (this->Impl->Options.OperatorPower - 1.0) / this->Impl->Tau);
}

double DistributedMaternField::Gamma() const { return this->Impl->Gamma; }
double DistributedMaternField::RelativeResidual() const { return this->Impl->Residual; }
int DistributedMaternField::Iterations() const { return this->Impl->System->Iterations(); }
double DistributedMaternField::LongestEdge() const { return this->Impl->LongestEdge; }
double DistributedMaternField::LongestSide() const { return this->Impl->LongestSide; }
std::int64_t DistributedMaternField::NumberOfPoints() const { return this->Impl->WholePoints; }

} // namespace surfsynth
