// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkMaternNoiseFilter
 * @brief   Generates Gaussian random fields on surfaces and in volumes, with statistics independent of the mesh
 *
 * Adds Matérn noise to the points of a surface: the solution f of the screened Poisson equation
 * (L + tau M) f = sqrt(M) n, with L the cotangent stiffness, M the lumped mass and n independent normal numbers
 * ([Kuai2026], Algorithm 1; [Lindgren2011]). The variance of the field at the eigenvalue lambda of the Laplacian is
 * 1 / (lambda + tau)^2 on every mesh: refining, coarsening or remeshing the surface changes the resolution of the
 * field, not its distribution. OperatorPower replaces the 2, for rougher and smoother fields; VarianceCorrection makes
 * the deviation exact at every point; arrays vary range, direction, boundary and barriers from place to place.
 *
 * In a volume L and M are the stiffness and the lumped mass of linear finite elements on tetrahedra, and the
 * smoothness is nu = OperatorPower - 3/2: 1/2 by default, where the correlation at the distance d is exp(-2 d / range).
 *
 * @par Input
 * vtkPolyData with triangles, polygons or strips, float or double points, any number of components, open or closed; or
 * a composite dataset of such blocks. Polygons and strips are triangulated for the computation only. Vertices and lines
 * are ignored. The mesh must have finite points, no degenerate triangle and no edge with more than two triangles; the
 * error message names the defect, the first offending cell or point and the filter that repairs it. Optional arrays of
 * finite numbers of any type, with a tuple for each point or cell: RangeFactorArrayName (points, 1 component),
 * DirectionArrayName (points, 3 components), BoundaryArrayName (points, 1 component), BarrierArrayName (cells, 1
 * component). A composite
 * input is processed block by block, with noise that differs between blocks; a block that cannot be processed is
 * reported and left empty, the others are not affected. Empty input gives empty output.
 * @par
 * Or a volume: vtkUnstructuredGrid with vtkTetra cells, which each have a volume, and of which at most two share a
 * face; vertices, lines and polygons beside them are ignored, other cells of three dimensions are an error that counts
 * them. Inverted tetrahedra (of negative volume) give the same noise; a warning counts them where there are others,
 * too. The arrays are the same. A grid without cells of three dimensions is a surface. On several MPI ranks a volume
 * must lie on one. In a composite dataset volumes are refused.
 * @par
 * Port 1, optional: a vtkPointSet with observations of the noise near the surface, or in the volume, for the model
 * MATERN and a single surface or volume. The samples are then samples of the noise given the observations (its
 * posterior, by Matheron's rule [Journel1978]). Each point has a value with NumberOfComponents components in
 * ObservationArray, and a standard deviation in ObservationDeviationArray; without one, or where it is 0, the samples
 * take the value at that place to 1e-8. Points attach to the nearest place of the surface, or the tetrahedron that
 * contains them, within Tolerance. Observations of which one contradicts another are an error that names them.
 *
 * @par Output
 * The input, untouched, as its own class, plus one float64 point array for each sample, with NumberOfComponents
 * components, named OutputArrayName, or OutputArrayName_k for k = FirstSample, FirstSample + 1, ... when
 * NumberOfSamples is larger than 1. With observations and on request OutputArrayName_Mean, with NumberOfComponents
 * components, and OutputArrayName_StandardDeviation. Points that no polygon, strip or tetrahedron uses get 0. The first
 * of them becomes the active scalars and, with three components, the active vectors, which vtkWarpVector takes, where
 * the input has none.
 *
 * @par Displacement
 * With Displacement the noise is a random displacement of the surface in world units, an array of three components: FREE,
 * along the NORMAL, or TANGENTIAL. Its standard deviation is StandardDeviation along every one of the directions (exactly
 * with VarianceCorrection), and 0 along the others. MovedPoints moves the points; vtkWarpVector does it for one of
 * several samples. With observations, displacements of landmarks or, with ObservedTargets, the positions that they are to
 * take, the samples are shapes through the landmarks: the Gaussian process of a shape model [Luthi2018], whose posterior
 * mean and standard deviation are PosteriorMean and PosteriorStandardDeviation. Displacement is an option of this filter
 * and no filter of its own, because mesh, scale, smoothness, observations and cached factor are the same.
 *
 * @par Scale
 * ScaleMode chooses one of three parameters for the smoothness of the field. CORRELATION_RANGE (the default) takes a
 * distance in world units and a standard deviation, as is usual in statistics. SCREENING takes tau itself, as Algorithm
 * 1 of the paper. NORMALIZED_SCREENING takes tau relative to the spectrum of the triangulation, as Algorithm 2; the
 * noise is then invariant under scaling of the mesh (but not under refinement).
 *
 * @par Cost
 * One sparse factorisation for each mesh and scale, kept until one of them changes; one solve for each sample and
 * component. Where the factor would exceed MemoryLimit, conjugate gradients with a multigrid preconditioner solve to a
 * relative residual of 1e-10, in memory and time proportional to the number of points: about 350 bytes for each point.
 * They need an OperatorPower other than 1 and 3 and no VarianceCorrection. The same seed gives the same bits for every
 * number of threads, and sample k is the same alone or in a batch.
 * Another kind of processor may give other last bits: Reproducibility in README.md.
 *
 * @sa vtkWarpScalar, vtkWarpVector, vtkTriangleFilter, vtkCleanPolyData
 */

#ifndef vtkMaternNoiseFilter_h
#define vtkMaternNoiseFilter_h

#include "vtkPassInputTypeAlgorithm.h"
#include "vtkSurfaceSynthesisNoiseModule.h" // For export macro

#include <memory> // For std::unique_ptr
#include <string> // For std::string

class VTKSURFACESYNTHESISNOISE_EXPORT vtkMaternNoiseFilter : public vtkPassInputTypeAlgorithm
{
public:
  static vtkMaternNoiseFilter* New();
  vtkTypeMacro(vtkMaternNoiseFilter, vtkPassInputTypeAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// Distributions of the noise.
  enum NoiseModels
  {
    MATERN = 0,     ///< Matérn noise: independent of the triangulation
    PER_VERTEX = 1, ///< one independent normal number per point, for comparison: depends on the triangulation
    WHITE = 2,      ///< discrete white noise N(0, M^-1), for comparison
    UNSCREENED = 3, ///< tau = 0, orthogonal to constants on every component, for comparison
    SPECTRAL = 4    ///< Matérn noise truncated to the lowest eigenpairs, for comparison
  };

  /// Directions of the displacement.
  enum Displacements
  {
    NO_DISPLACEMENT = 0, ///< the noise is a field of NumberOfComponents components
    FREE = 1,            ///< three independent components
    NORMAL = 2,          ///< along the vertex normals
    TANGENTIAL = 3       ///< in the tangent planes
  };

  /// Conditions at the boundary.
  enum BoundaryConditions
  {
    NEUMANN = 0,   ///< the normal derivative is 0
    DIRICHLET = 1, ///< the field is 0
    ROBIN = 2      ///< the normal derivative is -RobinCoefficient sqrt(tau) times the field
  };

  /// Parameters of the scale.
  enum ScaleModes
  {
    CORRELATION_RANGE = 0,   ///< by CorrelationRange and StandardDeviation
    SCREENING = 1,           ///< by Screening (Algorithm 1)
    NORMALIZED_SCREENING = 2 ///< by NormalizedScreening (Algorithm 2)
  };

  ///@{
  /**
   * Distribution of the noise. Default MATERN.
   */
  vtkSetClampMacro(NoiseModel, int, MATERN, SPECTRAL);
  vtkGetMacro(NoiseModel, int);
  void SetNoiseModelToMatern() { this->SetNoiseModel(MATERN); }
  void SetNoiseModelToPerVertex() { this->SetNoiseModel(PER_VERTEX); }
  void SetNoiseModelToWhite() { this->SetNoiseModel(WHITE); }
  void SetNoiseModelToUnscreened() { this->SetNoiseModel(UNSCREENED); }
  void SetNoiseModelToSpectral() { this->SetNoiseModel(SPECTRAL); }
  ///@}

  ///@{
  /**
   * Parameter that sets the scale of MATERN and SPECTRAL noise. Default CORRELATION_RANGE.
   */
  vtkSetClampMacro(ScaleMode, int, CORRELATION_RANGE, NORMALIZED_SCREENING);
  vtkGetMacro(ScaleMode, int);
  void SetScaleModeToCorrelationRange() { this->SetScaleMode(CORRELATION_RANGE); }
  void SetScaleModeToScreening() { this->SetScaleMode(SCREENING); }
  void SetScaleModeToNormalizedScreening() { this->SetScaleMode(NORMALIZED_SCREENING); }
  ///@}

  ///@{
  /**
   * Distance at which the correlation of two points is about 0.14, in world units, measured along the surface; larger
   * is smoother. tau = 8 nu / CorrelationRange^2 (kappa = sqrt(8 nu) / range) with the smoothness nu = OperatorPower -
   * 1, 1 by default, and OperatorPower - 3/2 in volumes, where distances are those within the volume. 0 (the default)
   * stands for 0.2 times the longest side of the bounding box of the input, or of the block. Edges longer than a third
   * of the range at their place cause a warning. Used in CORRELATION_RANGE mode.
   */
  vtkSetClampMacro(CorrelationRange, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(CorrelationRange, double);
  ///@}

  ///@{
  /**
   * Standard deviation of the noise, in units of the output; at least 0. Accurate on closed surfaces, within 5 % where
   * edges are shorter than about a tenth of the range and parts are wider than the range; the deviation is larger on
   * coarser meshes, on thin parts, and within about one range of an open boundary (by a factor sqrt(2) at a straight
   * one). In volumes it is smaller on coarse meshes, as the field varies between points: by up to 10 % where edges are
   * a tenth of the range. It is exact everywhere with VarianceCorrection. Used in CORRELATION_RANGE mode, with
   * VarianceCorrection, and by PER_VERTEX. Default 1.
   */
  vtkSetClampMacro(StandardDeviation, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(StandardDeviation, double);
  ///@}

  ///@{
  /**
   * Screening term tau, in 1 / square world units, larger than 0; larger is rougher and weaker (the correlation range
   * is sqrt(8 / tau)). Used in SCREENING mode. Default 100, the value of the paper for shapes of unit size.
   */
  vtkSetClampMacro(Screening, double, 1e-300, VTK_DOUBLE_MAX);
  vtkGetMacro(Screening, double);
  ///@}

  ///@{
  /**
   * Factor c in tau = c Gamma, without unit, larger than 0, where Gamma is the Frobenius norm of M^-1 L; the noise is
   * multiplied by sqrt(Gamma). Gamma increases with the number of points, so a value of c for one resolution is too
   * large for a finer one. Used in NORMALIZED_SCREENING mode. Default 1e-4.
   */
  vtkSetClampMacro(NormalizedScreening, double, 1e-300, VTK_DOUBLE_MAX);
  vtkGetMacro(NormalizedScreening, double);
  ///@}

  ///@{
  /**
   * Number of eigenpairs of the SPECTRAL model, the constant one included; at least 1 and below the number of points.
   * The cost is proportional to its square. Default 256.
   */
  vtkSetClampMacro(NumberOfEigenpairs, int, 1, VTK_INT_MAX);
  vtkGetMacro(NumberOfEigenpairs, int);
  ///@}

  ///@{
  /**
   * Power alpha of the operator, 1 to 4: the variance at the eigenvalue lambda is 1 / (lambda + tau)^alpha, and the
   * smoothness nu = alpha - 1, in volumes alpha - 3/2; larger is smoother. 2, the default, is that of the paper. On
   * surfaces 1.5 gives the correlation exp(-2 d / CorrelationRange) at the distance d, with nu = 1/2. Integers are exact;
   * numbers between them are approximated by rational functions [Bolin2020], the standard deviation at every eigenvalue
   * to 1e-4, with 3 to 12 factorisations and solves in place of one: 5 where edges are a tenth of the range, 7 where they
   * are a hundredth. On surfaces alpha = 1, in volumes alpha up to 1.5, has no finite variance in the limit of fine meshes and
   * no correlation range: it is an error in CORRELATION_RANGE mode, and in the other modes the variance of alpha = 1 increases
   * with the logarithm of the number of points, in volumes with 1 / edge length. Used by MATERN and SPECTRAL.
   */
  vtkSetClampMacro(OperatorPower, double, 1.0, 4.0);
  vtkGetMacro(OperatorPower, double);
  ///@}

  ///@{
  /**
   * Correction of the variance: the standard deviation is StandardDeviation at every point, in all scale modes, also at
   * boundaries, on thin parts and on coarse meshes. The deviations of the field are computed exactly, by selected
   * inversion [Takahashi1973] of the factor, in about 1 (alpha = 1), 3 (2), 6 (3) or 9 (4) times the time of the
   * factorisation, once for each mesh and scale. Points at which the boundary condition sets the field to 0 stay 0.
   * Used by MATERN. Default off.
   */
  vtkSetMacro(VarianceCorrection, bool);
  vtkGetMacro(VarianceCorrection, bool);
  vtkBooleanMacro(VarianceCorrection, bool);
  ///@}

  ///@{
  /**
   * Condition at the boundary of the surface, and of barriers. NEUMANN (the default): the normal derivative is 0, which
   * raises the deviation there; DIRICHLET: the field is 0; ROBIN: between both. Used by MATERN.
   */
  vtkSetClampMacro(BoundaryCondition, int, NEUMANN, ROBIN);
  vtkGetMacro(BoundaryCondition, int);
  void SetBoundaryConditionToNeumann() { this->SetBoundaryCondition(NEUMANN); }
  void SetBoundaryConditionToDirichlet() { this->SetBoundaryCondition(DIRICHLET); }
  void SetBoundaryConditionToRobin() { this->SetBoundaryCondition(ROBIN); }
  ///@}

  ///@{
  /**
   * Coefficient c of ROBIN, df/dn + c sqrt(tau) f = 0 with the outward normal n and the tau of the place (see
   * RangeFactorArrayName), without unit, at least 0: 0 is NEUMANN, large is DIRICHLET. For OperatorPower 2 the
   * deviation at a straight boundary is that of the interior with 0.55, the default, and 0.82 of it with 1. At a plane
   * boundary of a volume it is that of the interior with 1.
   */
  vtkSetClampMacro(RobinCoefficient, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(RobinCoefficient, double);
  ///@}

  ///@{
  /**
   * Name of a point array, 1 component, that chooses the points of the boundary condition: those with a number other
   * than 0. DIRICHLET: the field is 0 at these points, on the boundary or inside. ROBIN: on boundary edges between two
   * such points, in volumes on boundary faces of three; the rest is NEUMANN. Empty, the default: the whole boundary.
   */
  void SetBoundaryArrayName(const char* name);
  vtkGetCharFromStdStringMacro(BoundaryArrayName);
  ///@}

  ///@{
  /**
   * Name of a point array, 1 component, numbers above 0 without unit: factors of the correlation range at each point,
   * with tau divided by the factor squared. In CORRELATION_RANGE mode the deviation stays near StandardDeviation where
   * the factors vary slowly, and is exact with VarianceCorrection. Used by MATERN. Empty, the default: the same range
   * everywhere.
   */
  void SetRangeFactorArrayName(const char* name);
  vtkGetCharFromStdStringMacro(RangeFactorArrayName);
  ///@}

  ///@{
  /**
   * Name of a point array with a vector for each point, the direction in which the field is stretched: 3 components of
   * any length and sign, on surfaces projected to them; 0 for no direction. Used by MATERN with AnisotropyRatio. Empty,
   * the default: no directions.
   */
  void SetDirectionArrayName(const char* name);
  vtkGetCharFromStdStringMacro(DirectionArrayName);
  ///@}

  ///@{
  /**
   * Ratio of the correlation range along the directions of DirectionArrayName to that across, without unit, above 0;
   * below 1 the field is stretched across. CorrelationRange is the geometric mean: it is sqrt(ratio) times as long
   * along, and divided by sqrt(ratio) across; in volumes ratio^(2/3) times along and ratio^(-1/3) times across. Edges
   * must be short for the shorter one. Default 4.
   */
  vtkSetClampMacro(AnisotropyRatio, double, 1e-6, 1e6);
  vtkGetMacro(AnisotropyRatio, double);
  ///@}

  ///@{
  /**
   * Name of a cell array, 1 component, of barriers: cells with a number other than 0, which the correlation does not
   * cross but goes around, as coast lines for the field of a sea (the limit of [Bakka2019] for a range of 0 in the
   * barrier). The boundary condition holds at their edges or faces; points inside get 0. Used by MATERN. Empty, the
   * default: no barriers.
   */
  void SetBarrierArrayName(const char* name);
  vtkGetCharFromStdStringMacro(BarrierArrayName);
  ///@}

  ///@{
  /**
   * Seed of the random numbers, any integer. Each seed gives different noise; the same seed always gives the same noise
   * for the same points, sample and component, whatever the other parameters. Default 0.
   */
  vtkSetMacro(Seed, int);
  vtkGetMacro(Seed, int);
  ///@}

  ///@{
  /**
   * Number of components of each array, independent of each other; at least 1. Three components are a random
   * displacement for vtkWarpVector. Default 1.
   */
  vtkSetClampMacro(NumberOfComponents, int, 1, VTK_INT_MAX);
  vtkGetMacro(NumberOfComponents, int);
  ///@}

  ///@{
  /**
   * Number of samples, each an array of its own; at least 1. Default 1.
   */
  vtkSetClampMacro(NumberOfSamples, int, 1, VTK_INT_MAX);
  vtkGetMacro(NumberOfSamples, int);
  ///@}

  ///@{
  /**
   * Index of the first sample, at least 0; an ensemble can be generated in parts. Default 0.
   */
  vtkSetClampMacro(FirstSample, int, 0, VTK_INT_MAX);
  vtkGetMacro(FirstSample, int);
  ///@}

  ///@{
  /**
   * Memory limit of the output, MiB, at least 0; 0, the default, for three quarters of the memory of the machine. More
   * samples than fit are an error before the work begins; the message names a number that fits. Where the factor would
   * exceed the limit by estimate, conjugate gradients with a multigrid preconditioner solve in its place (SolverName).
   */
  vtkSetClampMacro(MemoryLimit, int, 0, VTK_INT_MAX);
  vtkGetMacro(MemoryLimit, int);
  ///@}

  ///@{
  /**
   * Refinement of surfaces that are too coarse for the correlation range: where an edge is longer than a third of it,
   * triangles are divided at midpoints of edges (vtkAdaptiveSubdivisionFilter) until no edge is longer than a quarter.
   * The output is then the refined surface, of triangles, with the arrays of the input interpolated. Used in
   * CORRELATION_RANGE mode by MATERN and SPECTRAL noise on surfaces; volumes stay as they are. Default off.
   */
  vtkSetMacro(Refinement, bool);
  vtkGetMacro(Refinement, bool);
  vtkBooleanMacro(Refinement, bool);
  ///@}

  ///@{
  /**
   * Selection of the result as the active scalars of the output, which viewers color by, also where the input has
   * active scalars. Off, those of the input stay. Default off.
   */
  vtkSetMacro(ActiveResult, bool);
  vtkGetMacro(ActiveResult, bool);
  vtkBooleanMacro(ActiveResult, bool);
  ///@}

  ///@{
  /**
   * Gathering of a surface whose pieces lie on several MPI ranks. On (the default): each rank that draws samples holds the
   * whole surface. Off: the equations are solved where the pieces lie, by conjugate gradients with algebraic multigrid of
   * PETSc and hypre to a relative residual of 1e-12, so that the memory of a rank decreases with the number of ranks; the
   * noise is that of the gathered surface to 1e-8. Takes MATERN noise with an OperatorPower of 2 or 4 and NEUMANN
   * boundaries, without VarianceCorrection, Refinement, CoherentNoise, ComponentCoupling, Displacement, observations and
   * arrays that vary the field; others are an error on all ranks, as is a library without PETSc. Changes nothing for a
   * surface on one rank.
   */
  vtkSetMacro(GatherPieces, bool);
  vtkGetMacro(GatherPieces, bool);
  vtkBooleanMacro(GatherPieces, bool);
  ///@}

  ///@{
  /**
   * Noise that belongs to places in space instead of to points of the mesh: the same seed gives the same noise, up to
   * discretization, on all triangulations of one surface at the same place, so that a surface can be decimated or
   * remeshed and keeps its noise. Samples on two triangulations have a correlation above 0.95 where CorrelationRange is
   * ten edges or more. A surface that is moved, or scaled by no power of 2, gets other noise; sheets within a seventh of
   * CorrelationRange of each other that face the same way are correlated. Used by MATERN noise with an
   * OperatorPower other than 1 and 3. In NORMALIZED_SCREENING mode the range depends on the triangulation, so that only equal
   * ranges give equal noise. An error for volumes. Default off.
   */
  vtkSetMacro(CoherentNoise, bool);
  vtkGetMacro(CoherentNoise, bool);
  vtkBooleanMacro(CoherentNoise, bool);
  ///@}

  ///@{
  /**
   * Coupling of the connected components of a surface. Off: they are independent. On: each point within
   * CouplingDistance of another component is tied to the nearest place there, in the equations of the noise, so that
   * parts move together. With the differences B u of these pairs, weighted by area, a Poisson equation L u = r becomes
   * (L + w B'B) u = r + w B'B s, w = CouplingWeight / area of the surface and s = 0. Results do not depend on the
   * order of the components, and a surface of one component gives the same bits as without. A component without a pair
   * is an error that names its first point. Default off.
   */
  vtkSetMacro(ComponentCoupling, bool);
  vtkGetMacro(ComponentCoupling, bool);
  vtkBooleanMacro(ComponentCoupling, bool);
  ///@}

  ///@{
  /**
   * Weight of the squared differences of coupled points against the Dirichlet energy, without unit, above 0; larger ties
   * parts more tightly. Used with ComponentCoupling. Default 1e6.
   */
  vtkSetClampMacro(CouplingWeight, double, 1e-300, VTK_DOUBLE_MAX);
  vtkGetMacro(CouplingWeight, double);
  ///@}

  ///@{
  /**
   * Largest distance of two coupled points, in world units, at least 0. Points are coupled only where surfaces face each
   * other: where the nearest place is at least half as far from the component of the point. 0 (the default) stands for
   * 0.03 times the square root of the area of the surface. Used with ComponentCoupling.
   */
  vtkSetClampMacro(CouplingDistance, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(CouplingDistance, double);
  ///@}

  ///@{
  /**
   * Noise as a displacement of the surface, in world units, of three components whatever NumberOfComponents is. FREE: three
   * independent components, which has StandardDeviation along every direction. NORMAL: one field times the unit vertex
   * normal, the area-weighted mean of the face normals. TANGENTIAL: three independent fields without their part along that
   * normal, which has StandardDeviation along every tangent direction. NORMAL and TANGENTIAL need triangles that are wound
   * alike. Samples that invert triangles, as a deviation that is large for the range does, cause a warning; an
   * OperatorPower above 2 gives smoother shapes. Default NO_DISPLACEMENT.
   */
  vtkSetClampMacro(Displacement, int, NO_DISPLACEMENT, TANGENTIAL);
  vtkGetMacro(Displacement, int);
  void SetDisplacementToNoDisplacement() { this->SetDisplacement(NO_DISPLACEMENT); }
  void SetDisplacementToFree() { this->SetDisplacement(FREE); }
  void SetDisplacementToNormal() { this->SetDisplacement(NORMAL); }
  void SetDisplacementToTangential() { this->SetDisplacement(TANGENTIAL); }
  ///@}

  ///@{
  /**
   * Motion of the points of the output by the displacement, which stays as an array; normals are dropped. Used with a
   * Displacement and one sample; several samples are an error. Default off.
   */
  vtkSetMacro(MovedPoints, bool);
  vtkGetMacro(MovedPoints, bool);
  vtkBooleanMacro(MovedPoints, bool);
  ///@}

  ///@{
  /**
   * Meaning of the values of the observations of a Displacement. On: the positions that the points of the surface nearest to
   * the observations are to take, world units. Off: the displacements of these points. With NORMAL and TANGENTIAL, the
   * samples take the part along the normal, or across it; parts that are left out cause a warning that names the
   * observations (UnreachedDistance). Default off.
   */
  vtkSetMacro(ObservedTargets, bool);
  vtkGetMacro(ObservedTargets, bool);
  vtkBooleanMacro(ObservedTargets, bool);
  ///@}

  ///@{
  /**
   * Name of the point array of the observations (second input) with the values, of NumberOfComponents components, or 3 with
   * a Displacement. Empty (the default) stands for the active scalars, or for the active vectors where these have three
   * components, three are needed and the scalars have another number.
   */
  void SetObservationArray(const char* name);
  vtkGetCharFromStdStringMacro(ObservationArray);
  ///@}

  ///@{
  /**
   * Name of the point array of the observations with the standard deviations of the values, one component, at least 0,
   * in the units of the values. Empty (the default) for exact observations.
   */
  void SetObservationDeviationArray(const char* name);
  vtkGetCharFromStdStringMacro(ObservationDeviationArray);
  ///@}

  ///@{
  /**
   * Largest distance of an observation from the surface or volume, in world units, at least 0; observations attach to
   * the nearest point of the surface, and one farther away is an error. 0 (the default) stands for a hundredth of the
   * longest side of the bounding box of the surface.
   */
  vtkSetClampMacro(Tolerance, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(Tolerance, double);
  ///@}

  ///@{
  /**
   * Mean of the noise given the observations, as a point array with _Mean behind the name of the samples. Default off.
   */
  vtkSetMacro(PosteriorMean, bool);
  vtkGetMacro(PosteriorMean, bool);
  vtkBooleanMacro(PosteriorMean, bool);
  ///@}

  ///@{
  /**
   * Standard deviation of the noise given the observations, as a point array with _StandardDeviation behind the name of
   * the samples; for TANGENTIAL the root mean square over the tangent directions. Takes the time of several
   * factorisations the first time. Default off.
   */
  vtkSetMacro(PosteriorStandardDeviation, bool);
  vtkGetMacro(PosteriorStandardDeviation, bool);
  vtkBooleanMacro(PosteriorStandardDeviation, bool);
  ///@}

  /**
   * Removes the observations. ParaView needs this method, because its clean command cannot name a port.
   */
  void RemoveObservations() { this->SetInputConnection(1, nullptr); }

  ///@{
  /**
   * Name of the added point array; not empty. Default "MaternNoise".
   */
  void SetOutputArrayName(const char* name);
  vtkGetCharFromStdStringMacro(OutputArrayName);
  ///@}

  ///@{
  /**
   * Results of the last update, for the last block of a composite input. EffectiveScreening: tau in use, 1 / square
   * world units. EffectiveCorrelationRange: sqrt(8 nu / tau), world units. Gamma: || M^-1 L ||_F, 1 / square world
   * units. All three are 0 for models without tau.
   */
  double GetEffectiveScreening() const;
  double GetEffectiveCorrelationRange() const;
  double GetGamma() const;
  ///@}

  /**
   * Largest relative residual || A f - b || / || b || of the solves of the last update; 0 for models without a solve.
   * An update whose residual exceeds 1e-8 fails.
   */
  double GetRelativeResidual() const;

  ///@{
  /**
   * Solver of the last update, for the last block of a composite input. SolverName: "Cholesky"; "Multigrid" for
   * conjugate gradients with a multigrid preconditioner, where the factor would exceed MemoryLimit; "BoomerAMG" for those
   * of a surface in pieces (GatherPieces); "None" for models without a solve. NumberOfIterations: largest number of
   * iterations of a solve on the mesh so far; 0 without iterations.
   */
  const char* GetSolverName() const;
  vtkTypeInt64 GetNumberOfIterations() const;
  ///@}

  /**
   * Number of meshes assembled and factored since this object was made. Unchanged while only seeds, numbers of samples
   * or names change.
   */
  vtkTypeInt64 GetNumberOfFactorizations() const;

  /**
   * Number of triangles whose normal after the Displacement is not within 90 degrees of that before: of all samples of the
   * last update together.
   */
  vtkTypeInt64 GetNumberOfInvertedTriangles() const;

  /**
   * Largest length of the parts of the observed displacements that NORMAL or TANGENTIAL leaves out, world units; 0 when the
   * last update warned of none.
   */
  double GetUnreachedDistance() const;

protected:
  vtkMaternNoiseFilter();
  ~vtkMaternNoiseFilter() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestDataObject(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;

private:
  vtkMaternNoiseFilter(const vtkMaternNoiseFilter&) = delete;
  void operator=(const vtkMaternNoiseFilter&) = delete;

  int NoiseModel = MATERN;
  int ScaleMode = CORRELATION_RANGE;
  double CorrelationRange = 0.0;
  double StandardDeviation = 1.0;
  double Screening = 100.0;
  double NormalizedScreening = 1e-4;
  int NumberOfEigenpairs = 256;
  double OperatorPower = 2.0;
  bool VarianceCorrection = false;
  int BoundaryCondition = NEUMANN;
  double RobinCoefficient = 0.55;
  double AnisotropyRatio = 4.0;
  std::string BoundaryArrayName;
  std::string RangeFactorArrayName;
  std::string DirectionArrayName;
  std::string BarrierArrayName;
  int Seed = 0;
  int NumberOfComponents = 1;
  int NumberOfSamples = 1;
  int FirstSample = 0;
  int MemoryLimit = 0;
  bool Refinement = false;
  bool ActiveResult = false;
  bool GatherPieces = true;
  bool CoherentNoise = false;
  bool ComponentCoupling = false;
  double CouplingWeight = 1e6;
  double CouplingDistance = 0.0;
  int Displacement = NO_DISPLACEMENT;
  bool MovedPoints = false;
  bool ObservedTargets = false;
  std::string ObservationArray;
  std::string ObservationDeviationArray;
  double Tolerance = 0.0;
  bool PosteriorMean = false;
  bool PosteriorStandardDeviation = false;
  std::string OutputArrayName = "MaternNoise";

  class Internals;
  std::unique_ptr<Internals> Impl;
};

#endif
