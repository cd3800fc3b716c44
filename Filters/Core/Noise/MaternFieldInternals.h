// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Internals of MaternField. Private to the noise.
#pragma once

#include "Core/Common/LargeArray.h"
#include "Core/Noise/MaternField.h"
#include "Core/Operators/SurfaceOperators.h"
#include "Core/Random/CounterNormals.h"
#include "Core/Solvers/CholeskySolver.h"
#include "Core/Solvers/LaplaceEigenpairs.h"

#include <mutex>
#include <optional>
#include <vector>

namespace surfsynth
{

/// One component of one sample, and the memory for it.
struct MaternColumn
{
  std::uint32_t Sample;    ///< number of the sample
  std::uint32_t Component; ///< number of the component
  double* Values; ///< value of the first vertex; those of the others follow at a distance of the number of components
};

/// Operators, factor and amplitudes of a field. MaternField.cxx defines the construction, MaternSampling.cxx the
/// sampling.
class MaternField::Internals
{
public:
  /// Columns that are solved together, rows in the solver's order.
  using Block = Eigen::Map<RowMatrix>;

  /// Assembles, and factors or computes eigenpairs. Same errors as MaternField.
  Internals(
    TriangleMesh mesh, const MeshTopology& topology, const MaternFieldOptions& options, const Progress& progress);

  /// Samples @p columns of the request. @p scratch is enlarged as needed and is worth keeping from call to call.
  void SampleColumns(const SampleRequest& request, const std::vector<MaternColumn>& columns,
    LargeArray<double>& scratch, const Progress& progress);

  TriangleMesh Mesh;          ///< mesh of the field
  MaternFieldOptions Options; ///< checked
  double Tau = 0.0;           ///< see MaternField::EffectiveScreening()
  double Gamma = 0.0;         ///< see MaternField::Gamma()
  double LongestEdge = 0.0;   ///< see MaternField::LongestEdge()

  /// Sets the residual to 0 before a call of Sample().
  void ResetResidual()
  {
    std::lock_guard<std::mutex> lock(this->ResidualMutex);
    this->Residual = 0.0;
  }
  /// Largest relative residual since ResetResidual().
  double MaximumResidual()
  {
    std::lock_guard<std::mutex> lock(this->ResidualMutex);
    return this->Residual;
  }

private:
  void ChooseScreening(const SparseMatrix& stiffness);
  void ChooseAmplitude();
  void FactorScreened(SparseMatrix matrix, const Progress& progress);
  void FactorUnscreened(SparseMatrix matrix, const Progress& progress);
  void Factor(const SparseMatrix& matrix, const Progress& progress);

  bool Used(Index v) const { return this->Components.OfVertex[v] >= 0; }
  void SampleBySolve(const SampleRequest& request, const std::vector<MaternColumn>& columns,
    LargeArray<double>& scratch, const Progress& progress);
  void SampleByVertex(const NormalKey& key, Eigen::Ref<Eigen::VectorXd> values) const;
  void SampleBySpectrum(const NormalKey& key, Eigen::Ref<Eigen::VectorXd> values) const;

  void FillRightHandSides(const SampleRequest& request, const std::vector<MaternColumn>& columns, Block& block) const;
  void TakeSolutions(const SampleRequest& request, const std::vector<MaternColumn>& columns, const Block& block) const;
  void RemoveMeans(Block& block, const Eigen::VectorXd& weights, const Eigen::VectorXd& shape) const;
  Eigen::VectorXd FirstColumn(const Block& block) const;
  void CheckSolution(const Eigen::VectorXd& solution, const Eigen::VectorXd& rightHandSide);

  Eigen::VectorXd Mass;
  Eigen::VectorXd RootMass;
  Eigen::VectorXd Amplitude; ///< [V], factor of each vertex's value
  MeshComponents Components;
  std::optional<CholeskySolver> Solver;
  std::vector<Index> RowOfVertex; ///< in the solver's order
  Eigenpairs Pairs;

  std::mutex ResidualMutex;
  double Residual = 0.0;
};

} // namespace surfsynth
