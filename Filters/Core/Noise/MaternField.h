// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Gaussian random fields on surfaces and in volumes: [Kuai2026], sections 3.4, 3.5 and 5.4, and [Lindgren2011].
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TetrahedralMesh.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Core/Operators/ComponentCoupling.h"

#include <Eigen/Core>

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace surfsynth
{

/// Distribution of a field. n is N(0, I), independent for every vertex. Algorithms and equations are those of
/// [Kuai2026].
enum class NoiseModel
{
  Matern,     ///< (L + tau M) f = sqrt(M) n for OperatorPower 2: Algorithm 1, the triangulation-agnostic noise
  PerVertex,  ///< f = n: iid numbers per vertex, whatever the triangulation
  White,      ///< f = M^-1/2 n, so N(0, M^-1): equation 6
  Unscreened, ///< L f = sqrt(M) n with f and the right-hand side orthogonal to constants on every component (tau = 0)
  Spectral    ///< f = sum_i chi_i / (lambda_i + tau)^(alpha / 2) phi_i over the lowest eigenpairs: section 5.4
};

/// Condition of the field at the boundary of the surface or volume. n is the outward normal in the surface, or that of
/// the volume.
enum class BoundaryCondition
{
  Neumann,   ///< df/dn = 0
  Dirichlet, ///< f = 0
  Robin      ///< df/dn + c kappa f = 0
};

/// Parameter that gives the screening term tau, 1 / square world units. Algorithms are those of [Kuai2026].
enum class ScaleMode
{
  CorrelationRange,   ///< tau = kappa^2 with kappa = sqrt(8 nu) / range; f scaled to a standard deviation
  Screening,          ///< tau itself: Algorithm 1
  NormalizedScreening ///< tau = c Gamma and output sqrt(Gamma) f: Algorithm 2
};

/// Values on the mesh of a field that vary it from place to place, for the model Matern. Empty ones change nothing.
struct MaternFieldArrays
{
  /// [V], > 0, no unit: factors of the correlation range. tau becomes tau / factor^2 at each vertex; in
  /// CorrelationRange mode the field is multiplied by factor^-nu, so that its deviation stays near the one asked for
  /// [Lindgren2011].
  Eigen::VectorXd RangeFactors;
  /// [V, 3], directions along which the range is longer, projected to a surface: see
  /// MaternFieldOptions::AnisotropyRatio.
  PointMatrix Directions;
  /// [V], vertices at which the boundary condition holds, in place of all boundary vertices. Dirichlet: the vertices of
  /// the mask, wherever they lie. Robin: the boundary edges whose two ends, or in a volume the boundary faces whose
  /// three corners, are in the mask.
  std::vector<bool> BoundaryMask;
  /// [F] or [T], triangles or tetrahedra that the correlation does not cross: the limit of [Bakka2019] for a range of 0
  /// in the barrier. They are left out; their edges or faces are boundary, and vertices inside get 0.
  std::vector<bool> Barrier;

  /// True when all arrays are the same.
  bool operator==(const MaternFieldArrays& other) const;
};

/// Options of a field. Options that the model and mode do not name are ignored.
struct MaternFieldOptions
{
  NoiseModel Model = NoiseModel::Matern;        ///< distribution
  ScaleMode Mode = ScaleMode::CorrelationRange; ///< parameter of tau, for Matern and Spectral
  /// In CorrelationRange mode: distance at which the correlation has fallen to about 0.14, world units, > 0; or 0 for
  /// 0.2 times the longest side of the bounding box.
  double CorrelationRange = 0.0;
  /// alpha, for Matern and Spectral: 1 to 4. The variance at the eigenvalue lambda of the Laplacian is
  /// 1 / (lambda + tau)^alpha; the smoothness is nu = alpha - 1 on surfaces and alpha - 3/2 in volumes. Integers are
  /// sampled exactly, numbers between them by a rational approximation of the power [Bolin2020] with 3 to 12 factors and
  /// solves, which gives the standard deviation at every eigenvalue to 1e-4 (see ApproximateInversePower()).
  /// alpha <= d/2 has no finite variance in the limit of fine meshes, thus no CorrelationRange mode: in the other modes
  /// the variance of alpha = 1 increases with the logarithm of the number of vertices, in volumes with 1 / edge length.
  double OperatorPower = 2.0;
  /// For Matern: marginal standard deviation that is exact at every vertex, at boundaries, on thin parts and on coarse
  /// meshes. The samples are divided by the deviations of the discrete field, which
  /// CholeskySolver::InverseDiagonals() computes: about 1 (alpha = 1), 3 (2), 6 (3), 9 (4) or, for each term of other
  /// alpha, 3 times the time of the factorisation. Vertices at which the boundary condition is f = 0 stay 0. In all modes StandardDeviation is used.
  bool VarianceCorrection = false;
  BoundaryCondition Boundary = BoundaryCondition::Neumann; ///< for Matern
  /// c for Robin, no unit (kappa = sqrt(tau), that of the place, has that of 1 / length), >= 0: 0 is Neumann, large is
  /// Dirichlet. For alpha = 2 the deviation at a straight boundary is that of the interior with 0.55, and 0.82 of it
  /// with 1; in a volume, at a plane boundary, it is that of the interior with 1, and 1.14 of it with 0.55.
  double RobinCoefficient = 0.55;
  /// Ratio of the correlation range along Arrays.Directions to that across, > 0, no unit. CorrelationRange is their
  /// geometric mean: sqrt(ratio) times it along, 1 / sqrt(ratio) across; in a volume ratio^(2/3) and ratio^(-1/3).
  double AnisotropyRatio = 4.0;
  MaternFieldArrays Arrays; ///< for Matern
  /// For Matern and Unscreened: bytes above which the estimated factor (CholeskySolver::EstimateMemory()) is not made,
  /// and conjugate gradients with a multigrid preconditioner (MultigridSolver) solve to a relative residual of 1e-10; 0
  /// for three quarters of what the process can still allocate. The samples are then those of the factor to about 1e-9,
  /// without its bits. The powers 1 and 3 and VarianceCorrection need the factor.
  std::uint64_t FactorMemoryLimit = 0;
  /// For models with a solve or eigenpairs on surfaces: coupling of the components, so that parts move together. L becomes
  /// L + w B'B (see CouplingMatrix()) and, in CorrelationRange mode, the components have the amplitude of one surface of
  /// their total area; where two sheets are coupled the deviation is smaller, as that of a sheet of twice the thickness,
  /// unless VarianceCorrection is on. Changes nothing for one component. Not with Arrays.Barrier, and not in volumes.
  ComponentCoupling Coupling;
  /// In CorrelationRange mode, with VarianceCorrection, and for PerVertex: marginal standard deviation, >= 0.
  double StandardDeviation = 1.0;
  /// In Screening mode: tau > 0, 1 / square world units. [Kuai2026] uses 100 on shapes of about unit size.
  double Screening = 100.0;
  /// In NormalizedScreening mode: c > 0. tau is proportional to the spectrum of the triangulation, so the field is
  /// invariant under scaling but not under refinement (Gamma increases with the number of vertices).
  double NormalizedScreening = 1e-4;
  /// For Spectral: number of eigenpairs, >= 1, the constant one included; at most the number of used vertices - 1.
  Index NumberOfEigenpairs = 256;
  /// For Matern on surfaces with alpha other than 1 and 3: the same seed gives the same field, up to discretization, on all
  /// triangulations of one surface at the same place, by LatticeNoise in place of a number for each vertex. The lattice
  /// has a side between a twentieth and a fourteenth of the correlation range, a power of sqrt(2), so that nearly equal
  /// ranges have the same. Correlations of fields are above 0.95 where the range is ten edges or more. Memory and time
  /// increase by about 24 numbers for each vertex, and by area / side^2 times 50 where triangles are larger than the
  /// side. Not the same bits as without.
  bool CoherentNoise = false;
};

/// Numbers of the samples to draw.
struct SampleRequest
{
  std::uint64_t Seed = 0;               ///< see NormalKey::Seed
  std::uint32_t FirstSample = 0;        ///< number of the first sample
  std::uint32_t NumberOfSamples = 1;    ///< may be 0
  std::uint32_t SampleStep = 1;         ///< the samples are FirstSample + k SampleStep
  std::uint32_t NumberOfComponents = 1; ///< independent components of each sample
  std::uint32_t Stream = 0;             ///< see NormalKey::Stream
  double Scale = 1.0;                   ///< factor of every value
};

/// A random field on one mesh: operators and factor are computed once, samples are drawn many times.
///
/// With A = L + tau M (and the terms of the boundary condition) the unscaled field has the covariance
/// A^-1 (M A^-1)^(alpha - 1) [Lindgren2011]: a solve with A for each two of alpha, and for odd alpha a solve with the
/// transposed Cholesky factor of A, whose solutions for independent normal numbers have the covariance A^-1. The bits
/// of odd alpha thus depend on the order of elimination as well; those of others on rounding only. The smoothness
/// is nu = alpha - d/2: alpha - 1 on a surface, alpha - 3/2 in a volume.
///
/// For other alpha, 2 s or 2 + 2 s with 0 < s < 1, the first solve is the sum of w_k (A + c_k M)^-1, which approximates
/// M^-1/2 (M^-1/2 A M^-1/2)^-s M^-1/2, over the terms of ApproximateInversePower(): a factor, or a multigrid hierarchy,
/// and a solve for each. alpha = 3.5 on a mesh of ten edges in a range takes 5 terms, of a hundred edges 7.
///
/// In CorrelationRange mode the marginal variance of the field on the plane, 1 / (4 pi nu kappa^(2 nu)), is replaced
/// component by component of the mesh by one that holds on closed surfaces of any size (see MarginalVariance()). On
/// open surfaces the natural (Neumann) boundary condition raises the standard deviation within about a range of the
/// boundary, by a factor sqrt(2) on a straight one; VarianceCorrection takes this away.
class MaternField
{
public:
  /// Assembles, and factors, builds a multigrid hierarchy or computes eigenpairs as the model needs.
  ///
  /// @throws InvalidInput when the mesh does not pass CheckMesh() with manifold edges, an option is out of range, or
  /// the options need a factor and FactorMemoryLimit excludes it.
  /// @throws SolverFailure when the matrix is not positive definite to working precision.
  /// @throws Cancelled
  MaternField(TriangleMesh mesh, const MaternFieldOptions& options, const Progress& progress = {});
  /// Constructs the field on a mesh that the caller has checked, with its tables (see RequireValidMesh()).
  MaternField(
    TriangleMesh mesh, const MeshTopology& topology, const MaternFieldOptions& options, const Progress& progress = {});
  /// Constructs the field in a volume of tetrahedra; @p mesh passes RequireValidVolume().
  /// @throws InvalidInput for coherent noise, too.
  MaternField(const TetrahedralMesh& mesh, const MaternFieldOptions& options, const Progress& progress = {});
  ~MaternField();
  MaternField(MaternField&&) noexcept;
  MaternField& operator=(MaternField&&) noexcept;

  /// Returns the memory for sample number @p sample: V * C doubles, the components of a vertex side by side, as in a
  /// vtkDataArray. Called on the thread that called SampleInto(), in order.
  using Destination = std::function<double*(std::uint32_t sample)>;

  /// Draws the samples and writes each to its destination. Memory: one block of 32 columns of V numbers for each
  /// thread, whatever the number of samples. The bits of a sample depend on (seed, sample, component, stream, vertex
  /// id) and the mesh alone. A vertex that no triangle uses gets 0.
  ///
  /// @throws InvalidInput when no component, or a sample beyond number 2^32 - 1, is asked for.
  /// @throws SolverFailure when a solution is not finite or its relative residual exceeds 1e-8; Cancelled. The samples
  /// written by then are incomplete.
  void SampleInto(const SampleRequest& request, const Destination& destination, const Progress& progress = {}) const;

  /// Receives sample number @p sample as [V, C] float64; the reference is only valid during the call.
  using Consumer = std::function<void(std::uint32_t sample, const Eigen::Ref<const Eigen::MatrixXd>& values)>;

  /// Draws the samples like SampleInto() and hands each to @p consume, in order, on the calling thread: for statistics
  /// over many samples, which need not be kept.
  void Sample(const SampleRequest& request, const Consumer& consume, const Progress& progress = {}) const;

  /// Draws the first sample of @p request, [V, C] float64. Same errors as SampleInto().
  Eigen::MatrixXd Sample(const SampleRequest& request = {}) const;

  /// tau in use, 1 / square world units; 0 for models without one.
  double EffectiveScreening() const;
  /// Correlation range in use, world units: sqrt(8 nu / tau); 0 for models without tau, and for alpha = 1.
  double EffectiveCorrelationRange() const;
  /// Gamma = || M^-1 L ||_F, 1 / square world units; 0 for models without tau.
  double Gamma() const;
  /// Largest relative residual || A f - b || / || b || of the last call of Sample(), over one column of every block of
  /// up to 32 that are solved together; 0 for models without a solve, and for alpha = 1.
  double RelativeResidual() const;
  /// Name of the solver in use: "Cholesky", "Multigrid", or "None" for models without a solve.
  const char* SolverName() const;
  /// Largest number of iterations of a solve so far; 0 for solvers without iterations.
  int Iterations() const;
  /// Length of the longest edge, world units. Above about a third of the range the mesh is too coarse for the field.
  double LongestEdge() const;
  /// Largest length of an edge over the correlation range at its place and in its direction (see MaternFieldArrays), no
  /// unit: LongestEdge() / EffectiveCorrelationRange() for a range that is the same everywhere; 0 for fields without a range.
  double LongestEdgeOverRange() const;
  /// Mesh of the field; its points, without triangles, in a volume.
  const TriangleMesh& Mesh() const;
  /// nu = alpha - d/2, with d = 2 on surfaces and 3 in volumes, for models with tau; as for alpha = 2 for others.
  double Smoothness() const;

  // Algebra of the field, for the model Matern: its covariance is C, its precision Q = C^-1, in the scaling of the
  // samples. Vertices at which the field is 0 (unused, Dirichlet, barrier) have rows of 0 in C and are left out of Q.
  // All throw InvalidInput for other models and wrong shapes.

  /// Solves Q x = b, so x = C b, for all columns of @p rightHandSides, [V, K] float64.
  Eigen::MatrixXd SolvePrecision(const Eigen::Ref<const Eigen::MatrixXd>& rightHandSides) const;
  /// Returns Q x for all columns of @p values, [V, K] float64.
  /// @throws InvalidInput when alpha is no integer or the standard deviation is 0, too.
  Eigen::MatrixXd ApplyPrecision(const Eigen::Ref<const Eigen::MatrixXd>& values) const;
  /// Natural logarithm of the determinant of Q.
  /// @throws InvalidInput when alpha is no integer, the standard deviation is 0, and when SolverName() is "Multigrid", too.
  double LogDeterminantOfPrecision() const;
  /// Diagonal of C, [V] float64: the marginal variance at every vertex, exactly, in the time of
  /// MaternFieldOptions::VarianceCorrection.
  /// @throws InvalidInput when SolverName() is "Multigrid", or the factors of the inverse exceed
  /// MaternFieldOptions::FactorMemoryLimit, too.
  Eigen::VectorXd MarginalVariances(const Progress& progress = {}) const;

private:
  class Internals;
  std::unique_ptr<Internals> Impl;
};

/// Mean marginal variance of the unscaled field of operator power alpha on a connected surface, i.e. the sum over the
/// spectrum of 1 / (lambda_i + tau)^alpha, divided by the area.
///
/// On a closed surface of area A and Euler characteristic chi the heat trace A / (4 pi t) + chi / 6 [McKean1967] gives
///   1 / (A tau^alpha) + 1 / (4 pi nu (tau + mu)^nu),   nu = alpha - 1,   mu = 4 pi / A (1 - chi / 6),
/// exact in the limit of small ranges (to second order) and of large ones, and on the sphere, at any range, within 5 %
/// for alpha = 2 and 6 % for 3 and 4 and the numbers between.
/// On an open surface the value is that of its interior, max(1 / (4 pi nu tau^nu), 1 / (A tau^alpha)).
/// @param tau screening term, 1 / square world units, > 0
/// @param area A, square world units, > 0
/// @param eulerCharacteristic chi
/// @param closed true for a surface without boundary
/// @param operatorPower alpha, more than 1
/// @return variance, world units to the power 2 nu
double MarginalVariance(
  double tau, double area, std::int64_t eulerCharacteristic, bool closed, double operatorPower = 2.0);

/// Marginal variance of the unscaled field of operator power alpha inside a volume [Lindgren2011],
///   Gamma(nu) / (Gamma(alpha) (4 pi)^(3/2) tau^nu),   nu = alpha - 3/2,
/// or 1 / (volume tau^alpha), that of the constant mode, where it is larger: in volumes much smaller than the range,
/// and for alpha = 1, which has no finite variance.
/// @param tau screening term, 1 / square world units, > 0
/// @param volume cubic world units, > 0
/// @param operatorPower alpha, at least 1
/// @return variance, world units to the power 2 nu
double MarginalVarianceInVolume(double tau, double volume, double operatorPower = 2.0);

} // namespace surfsynth
