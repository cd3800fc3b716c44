// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkMaternNoiseFilter
 * @brief   Generates Gaussian random fields on surfaces, with statistics independent of the triangulation
 *
 * Adds Matérn noise to the points of a surface: the solution f of the screened Poisson equation
 * (L + tau M) f = sqrt(M) n, with L the cotangent stiffness, M the lumped mass and n independent normal numbers
 * ([Kuai2026], Algorithm 1; [Lindgren2011]). The variance of the field at the eigenvalue lambda of the Laplacian is
 * 1 / (lambda + tau)^2 on every mesh: refining, coarsening or remeshing the surface changes the resolution of the
 * field, not its distribution.
 *
 * @par Input
 * vtkPolyData with triangles, polygons or strips, float or double points, any number of components, open or closed; or
 * a composite dataset of such blocks. Polygons and strips are triangulated for the computation only. Vertices and lines
 * are ignored. The mesh must have finite points, no degenerate triangle and no edge with more than two triangles; the
 * error message names the defect, the first offending cell or point and the filter that repairs it. A composite
 * input is processed block by block, with noise that differs between blocks; a block that cannot be processed is
 * reported and left empty, the others are not affected. Empty input gives empty output.
 *
 * @par Output
 * The input, untouched, plus one float64 point array for each sample, with NumberOfComponents components, named
 * OutputArrayName, or OutputArrayName_k for k = FirstSample, FirstSample + 1, ... when NumberOfSamples is larger
 * than 1. Points that no polygon or strip uses get 0. The first of them becomes the active scalars and, with three
 * components, the active vectors, which vtkWarpVector takes, where the input has none.
 *
 * @par Scale
 * ScaleMode chooses one of three parameters for the smoothness of the field. CORRELATION_RANGE (the default) takes a
 * distance in world units and a standard deviation, as is usual in statistics. SCREENING takes tau itself, as Algorithm
 * 1 of the paper. NORMALIZED_SCREENING takes tau relative to the spectrum of the triangulation, as Algorithm 2; the
 * noise is then invariant under scaling of the mesh (but not under refinement).
 *
 * @par Cost
 * One sparse factorisation for each mesh and scale, kept until one of them changes; one solve for each sample and
 * component. The same seed gives the same bits for every number of threads, and sample k is the same alone or in a
 * batch.
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
   * is smoother. tau = 8 / CorrelationRange^2 (kappa = sqrt(8 nu) / range with smoothness nu = 1). 0 (the default)
   * stands for 0.2 times the longest side of the bounding box of the input, or of the block. Edges longer than a third
   * of the range cause a warning. Used in CORRELATION_RANGE mode.
   */
  vtkSetClampMacro(CorrelationRange, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(CorrelationRange, double);
  ///@}

  ///@{
  /**
   * Standard deviation of the noise, in units of the output; at least 0. Accurate on closed surfaces, within 5 % where
   * edges are shorter than about a tenth of the range and parts are wider than the range; the deviation is larger on
   * coarser meshes, on thin parts, and within about one range of an open boundary (by a factor sqrt(2) at a straight
   * one). Used in CORRELATION_RANGE mode, and by PER_VERTEX. Default 1.
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
   * samples than fit are an error before the work begins; the message names a number that fits.
   */
  vtkSetClampMacro(MemoryLimit, int, 0, VTK_INT_MAX);
  vtkGetMacro(MemoryLimit, int);
  ///@}

  ///@{
  /**
   * Refinement of surfaces that are too coarse for the correlation range: where an edge is longer than a third of it, triangles
   * are divided at midpoints of edges (vtkAdaptiveSubdivisionFilter) until no edge is longer than a quarter. The output is
   * then the refined surface, of triangles, with the arrays of the input interpolated. Used in CORRELATION_RANGE mode by
   * MATERN and SPECTRAL noise. Default off.
   */
  vtkSetMacro(Refinement, bool);
  vtkGetMacro(Refinement, bool);
  vtkBooleanMacro(Refinement, bool);
  ///@}

  ///@{
  /**
   * Selection of the result as the active scalars of the output, which viewers color by, also where the input has active
   * scalars. Off, those of the input stay. Default off.
   */
  vtkSetMacro(ActiveResult, bool);
  vtkGetMacro(ActiveResult, bool);
  vtkBooleanMacro(ActiveResult, bool);
  ///@}

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
   * world units. EffectiveCorrelationRange: sqrt(8 / tau), world units. Gamma: || M^-1 L ||_F, 1 / square world units.
   * All three are 0 for models without tau.
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

  /**
   * Number of meshes assembled and factored since this object was made. Unchanged while only seeds, numbers of samples
   * or names change.
   */
  vtkTypeInt64 GetNumberOfFactorizations() const;

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
  int Seed = 0;
  int NumberOfComponents = 1;
  int NumberOfSamples = 1;
  int FirstSample = 0;
  int MemoryLimit = 0;
  bool Refinement = false;
  bool ActiveResult = false;
  std::string OutputArrayName = "MaternNoise";

  class Internals;
  std::unique_ptr<Internals> Impl;
};

#endif
