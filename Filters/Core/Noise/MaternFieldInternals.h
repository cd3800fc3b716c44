// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Internals of MaternField. Private to the noise.
#pragma once

#include "Core/Common/LargeArray.h"
#include "Core/Common/ScratchPool.h"
#include "Core/Noise/FieldDomain.h"
#include "Core/Noise/FractionalSolver.h"
#include "Core/Noise/LatticeNoise.h"
#include "Core/Noise/MaternField.h"
#include "Core/Operators/SurfaceOperators.h"
#include "Core/Random/CounterNormals.h"
#include "Core/Solvers/CholeskySolver.h"
#include "Core/Solvers/LaplaceEigenpairs.h"
#include "Core/Solvers/MultigridSolver.h"

#include <cmath>
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

/// True for models with a screening term.
bool HasTau(NoiseModel model);

/// Throws InvalidInput, "name is value; expected expected", unless @p condition holds.
void RequireOption(bool condition, const char* name, double value, const char* expected);

/// Throws InvalidInput when an option is out of range.
/// @param dimension 2 for surfaces, 3 for volumes
void RequireOptions(const MaternFieldOptions& options, int dimension);

/// Throws InvalidInput when an array of the options does not fit the mesh or has values out of range.
/// @param cells number of triangles or tetrahedra
void RequireArrays(const MaternFieldOptions& options, Eigen::Index points, Eigen::Index cells);

/// True when the options give directions that change the field.
bool IsAnisotropic(const MaternFieldOptions& options);

/// Factor of the range along an edge: the smaller one of its ends; 1 without factors.
double RangeFactorOfEdge(const MaternFieldOptions& options, Index a, Index b);

/// Stiffness of the field's Laplacian: anisotropic where the options say so.
SparseMatrix FieldStiffness(const TriangleMesh& mesh, const MeshTopology& topology, const MaternFieldOptions& options);

/// Vertices at which the boundary condition sets the field to 0, [V]; empty for none.
std::vector<bool> PinnedVertices(const MeshTopology& topology, const MaternFieldOptions& options);

/// Lumped mass of the boundary times the coefficient of the Robin condition, [V]; empty for other conditions.
Eigen::VectorXd RobinMass(const TriangleMesh& mesh, const MeshTopology& topology, const MaternFieldOptions& options);

/// Largest length of an edge over the local range, for the global range 1, world units; triangles of barriers are left out.
double LongestEdgeForRange(const TriangleMesh& mesh, const MaternFieldOptions& options);
double LongestEdgeForRange(const TetrahedralMesh& mesh, const MaternFieldOptions& options);

/// Returns @p mesh without the triangles that @p removed, [F], marks; all points stay.
TriangleMesh WithoutTriangles(const TriangleMesh& mesh, const std::vector<bool>& removed);

/// Sets the rows and columns of vertices of mass 0 to 0.
void DecoupleRows(SparseMatrix& matrix, const Eigen::VectorXd& mass);

/// Adds @p diagonal to the diagonal of @p matrix, in which every diagonal entry is present.
void AddToDiagonal(SparseMatrix& matrix, const Eigen::VectorXd& diagonal);

/// Operators, factor and amplitudes of a field. MaternField.cxx defines the construction, MaternOperators.cxx the
/// operator and its options, MaternSampling.cxx the sampling, MaternAlgebra.cxx covariance and precision.
class MaternField::Internals
{
public:
  /// Columns that are solved together, rows in the solver's order.
  using Block = Eigen::Map<RowMatrix>;

  /// Assembles, and factors or computes eigenpairs. Same errors as MaternField.
  Internals(
    TriangleMesh mesh, const MeshTopology& topology, const MaternFieldOptions& options, const Progress& progress);
  Internals(const TetrahedralMesh& mesh, const MaternFieldOptions& options, const Progress& progress);

  /// Does what MaternField::SampleInto() says. @p scratch is worth keeping from call to call.
  void SampleInto(const SampleRequest& request, const Destination& destination,
    ScratchPool<LargeArray<double>>& scratch, const Progress& progress);

  /// Samples @p columns of the request. @p scratch is enlarged as needed and is worth keeping from call to call.
  void SampleColumns(const SampleRequest& request, const std::vector<MaternColumn>& columns,
    LargeArray<double>& scratch, const Progress& progress);

  TriangleMesh Mesh;              ///< mesh of the field; points only for a volume
  int Dimension = 2;              ///< of the domain: 3 for a volume
  MaternFieldOptions Options;     ///< checked
  double Tau = 0.0;               ///< see MaternField::EffectiveScreening()
  double Gamma = 0.0;             ///< see MaternField::Gamma()
  double LongestEdge = 0.0;       ///< see MaternField::LongestEdge()
  double LongestScaledEdge = 0.0; ///< see LongestEdgeForRange()
  double LongestSide = 0.0;       ///< of the box around the mesh

  /// The solver in use; null for models without one.
  const LinearSolver* InUse() const
  {
    const LinearSolver* whole = this->OfWholePower();
    return whole == nullptr && this->Fraction ? &this->Fraction->First() : whole;
  }
  /// The solver with A itself; none for alpha between 1 and 2.
  const LinearSolver* OfWholePower() const
  {
    return this->Iterative ? static_cast<const LinearSolver*>(&*this->Iterative)
      : this->Solver       ? &*this->Solver
                           : nullptr;
  }
  /// True when conjugate gradients solve.
  bool IsIterative() const { return this->Iterative || (this->Fraction && this->Fraction->IsIterative()); }
  /// Largest number of iterations of a solve so far.
  int Iterations() const;
  /// Conjugate gradients in place of the factor.
  std::optional<MultigridSolver> Iterative;

  /// alpha in use.
  double Power() const;
  /// alpha as an integer, for alpha without a fraction.
  int WholePower() const { return static_cast<int>(this->Power()); }
  /// True for alpha that is no integer.
  bool IsFractional() const { return this->Power() != std::floor(this->Power()); }
  /// nu = alpha - d / 2.
  double Smoothness() const { return this->Power() - 0.5 * this->Dimension; }
  /// Shortest correlation range on the surface over that of the options, at most 1: see MaternFieldArrays.
  double SmallestRangeFactor() const;
  /// Replaces @p values, [V, K], by C values, Q values, and see MaternField.
  void ApplyCovariance(RowMatrix& values) const;
  void ApplyPrecision(RowMatrix& values) const;
  double LogDeterminantOfPrecision() const;
  Eigen::VectorXd MarginalVariances(const Progress& progress) const;

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
  void Assemble(const FieldDomain& domain, const Progress& progress);
  void ChooseScreening(const SparseMatrix& stiffness);
  void ChooseAmplitude(const FieldDomain& domain);
  double AmplitudeOfComponent(const FieldDomain& domain, Index component) const;
  void CorrectAmplitude(const Progress& progress);
  void Pin(const std::vector<bool>& pinned);
  void FactorScreened(SparseMatrix matrix, const Eigen::VectorXd& boundary, const Progress& progress);
  void FactorUnscreened(SparseMatrix matrix, const Progress& progress);
  void Factor(SparseMatrix matrix, const Progress& progress);
  void ChooseRationalPower(const SparseMatrix& matrix);
  std::uint64_t NumberOfFactors() const;
  bool FactorFits(const SparseMatrix& matrix) const;
  std::uint64_t FactorLimit() const;
  void RequireRoomForInverse() const;
  Eigen::VectorXd InverseVariances(const Progress& progress) const;
  void RequireFactor(const char* use) const;
  void RequireWholePower(const char* use) const;
  void ApplyRoot(RowMatrix& values) const;
  Eigen::VectorXd InverseDiagonal(const Progress& progress) const;

  bool Used(Index v) const { return this->Components.OfVertex[v] >= 0; }
  void SampleBySolve(const SampleRequest& request, const std::vector<MaternColumn>& columns,
    LargeArray<double>& scratch, const Progress& progress);
  void SampleByVertex(const NormalKey& key, Eigen::Ref<Eigen::VectorXd> values) const;
  void SampleBySpectrum(const NormalKey& key, Eigen::Ref<Eigen::VectorXd> values) const;

  Eigen::VectorXd NoiseWeights() const;
  void SolvePowers(Block& block, const Progress& progress);
  void SolveChecked(Block& block, const Progress& progress);
  void SolveFraction(Block& block, const Progress& progress);
  void MultiplyByMass(Block& block) const;
  void RequireAlgebra(Eigen::Index rows) const;
  Eigen::VectorXd InverseAmplitude() const;

  void ChooseNoise(const FieldDomain& domain);
  void FillFromLattice(const SampleRequest& request, const std::vector<MaternColumn>& columns, Block& block) const;
  void FillRightHandSides(const SampleRequest& request, const std::vector<MaternColumn>& columns, Block& block) const;
  void TakeSolutions(const SampleRequest& request, const std::vector<MaternColumn>& columns, const Block& block) const;
  void RemoveMeans(Block& block, const Eigen::VectorXd& weights, const Eigen::VectorXd& shape) const;
  Eigen::VectorXd FirstColumn(const Block& block) const;
  void CheckSolution(const LinearSolver& solver, const Eigen::VectorXd& solution, const Eigen::VectorXd& rightHandSide);

  Eigen::VectorXd Mass; ///< [V], 0 at vertices where the field is 0
  Eigen::VectorXd RootMass;
  Eigen::VectorXd Amplitude; ///< [V], factor of each vertex's value
  MeshComponents Components;
  std::optional<CholeskySolver> Solver;     ///< the factor of A; none for alpha between 1 and 2
  std::optional<RationalPower> Rational;    ///< r(x) for x^-s, where alpha is 2 s or 2 + 2 s with 0 < s < 1
  std::optional<FractionalSolver> Fraction; ///< its solves
  std::vector<Index> RowOfVertex;           ///< in the solver's order
  Eigenpairs Pairs;
  std::optional<LatticeNoise> Lattice; ///< for coherent noise

  std::mutex ResidualMutex;
  double Residual = 0.0;
};

} // namespace surfsynth
