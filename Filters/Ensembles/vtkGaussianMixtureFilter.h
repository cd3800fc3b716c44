// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkGaussianMixtureFilter
 * @brief   Generates random mixtures of Gaussians on surfaces: signals for training and testing
 *
 * Adds signals g(x) = sum_c exp(-d(x, c)^2 / (2 sigma^2)) to the points of a surface, with d the distance along the
 * surface and a few random centres c at a minimum distance from each other: the data of [Kuai2026], appendix C.3.
 * Distances are computed by the heat method [Crane2013].
 *
 * @par Input
 * vtkPolyData with triangles, polygons or strips, float or double points, any number of components, open or closed; or
 * a composite dataset of such blocks. Polygons and strips are triangulated for the computation only. Vertices and lines
 * are ignored. The mesh must have finite points, no degenerate triangle and no edge with more than two triangles; the
 * error message names the defect, the first offending cell or point and the filter that repairs it. A composite
 * input is processed block by block, with mixtures that differ between blocks; a block that cannot be processed is
 * reported and left empty, the others are not affected. Empty input gives empty output.
 *
 * @par Output
 * The input, untouched, plus one float64 point array with one component for each sample, named OutputArrayName, or
 * OutputArrayName_k for k = FirstSample, FirstSample + 1, ... when NumberOfSamples is larger than 1. Points that no
 * polygon or strip uses get 0, and so do those of components without a centre.
 *
 * @par Centres
 * Centres are points of the mesh, chosen one after the other, each with a probability proportional to its lumped mass
 * (a third of the area around it) among those that are not closer than Separation to an earlier one. Centres are
 * therefore distributed uniformly on the surface, on every triangulation.
 *
 * @par Cost
 * Two sparse factorisations for each mesh, kept until it changes; two solves for each centre: some thousand centres a
 * second for 2,000 points. The same seed gives the same bits for every number of threads, and sample k is the same
 * alone or in a batch.
 * Another kind of processor may give other last bits: Reproducibility in README.md.
 *
 * @sa vtkMaternNoiseFilter, vtkIsotropicRemeshFilter
 */

#ifndef vtkGaussianMixtureFilter_h
#define vtkGaussianMixtureFilter_h

#include "vtkDeprecation.h" // For VTK_DEPRECATION
#include "vtkPassInputTypeAlgorithm.h"
#include "vtkSurfaceSynthesisEnsemblesModule.h" // For export macro

#include <memory> // For std::unique_ptr
#include <string> // For std::string

class VTKSURFACESYNTHESISENSEMBLES_EXPORT vtkGaussianMixtureFilter : public vtkPassInputTypeAlgorithm
{
public:
  static vtkGaussianMixtureFilter* New();
  vtkTypeMacro(vtkGaussianMixtureFilter, vtkPassInputTypeAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * Number of Gaussians in each mixture, from 1 to 1000. Default 3.
   */
  vtkSetClampMacro(NumberOfCenters, int, 1, 1000);
  vtkGetMacro(NumberOfCenters, int);
  ///@}

  ///@{
  /**
   * Deprecated names of SetNumberOfCenters() and GetNumberOfCenters().
   */
  VTK_DEPRECATION("Use SetNumberOfCenters()")
  void SetNumberOfCentres(int number) { this->SetNumberOfCenters(number); }
  VTK_DEPRECATION("Use GetNumberOfCenters()")
  int GetNumberOfCentres() { return this->GetNumberOfCenters(); }
  ///@}

  ///@{
  /**
   * Standard deviation sigma of each Gaussian, as a fraction of the square root of the area of the surface, or of the
   * block; larger than 0. It should be several edge lengths. Default 0.08.
   */
  vtkSetClampMacro(Width, double, 1e-300, VTK_DOUBLE_MAX);
  vtkGetMacro(Width, double);
  ///@}

  ///@{
  /**
   * Minimum distance between two centres, in units of sigma; at least 0. Default 4, at which Gaussians hardly overlap.
   */
  vtkSetClampMacro(Separation, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(Separation, double);
  ///@}

  ///@{
  /**
   * Seed of the random numbers, any integer. Each seed gives different mixtures; the same seed always gives the same
   * mixtures on the same mesh. Default 0.
   */
  vtkSetMacro(Seed, int);
  vtkGetMacro(Seed, int);
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
   * Selection of the result as the active scalars of the output, which viewers color by, also where the input has active
   * scalars. Off, those of the input stay. Default off.
   */
  vtkSetMacro(ActiveResult, bool);
  vtkGetMacro(ActiveResult, bool);
  vtkBooleanMacro(ActiveResult, bool);
  ///@}

  ///@{
  /**
   * Name of the added point array; not empty. Default "Mixture".
   */
  void SetOutputArrayName(const char* name);
  vtkGetCharFromStdStringMacro(OutputArrayName);
  ///@}

  /**
   * Standard deviation sigma of the last update, in world units, for the last block of a composite input.
   */
  double GetStandardDeviation() const;

  /**
   * Number of meshes assembled and factored since this object was made. Unchanged while only seeds, numbers of samples
   * or names change.
   */
  vtkTypeInt64 GetNumberOfFactorizations() const;

protected:
  vtkGaussianMixtureFilter();
  ~vtkGaussianMixtureFilter() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestDataObject(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;

private:
  vtkGaussianMixtureFilter(const vtkGaussianMixtureFilter&) = delete;
  void operator=(const vtkGaussianMixtureFilter&) = delete;

  int NumberOfCenters = 3;
  double Width = 0.08;
  double Separation = 4.0;
  int Seed = 0;
  int NumberOfSamples = 1;
  int FirstSample = 0;
  int MemoryLimit = 0;
  bool ActiveResult = false;
  std::string OutputArrayName = "Mixture";

  class Internals;
  std::unique_ptr<Internals> Impl;
};

#endif
