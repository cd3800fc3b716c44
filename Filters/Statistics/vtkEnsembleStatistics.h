// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkEnsembleStatistics
 * @brief   Computes the mean, standard deviation, quantiles and principal modes of an ensemble of shapes or signals
 *
 * Statistics of each point over the samples of an ensemble on one triangulation, and its principal modes: a statistical
 * shape model [Cootes1995], from which vtkShapeModelSampler makes random shapes. Sample k is x_k = mean + sum_j b_kj mode_j,
 * with coefficients b in standard deviations. Shapes are compared as they lie: vtkProcrustesAlignmentFilter aligns them
 * before.
 *
 * @par Input
 * Port 0, with any number of connections: composite datasets of vtkPolyData, whose leaves in order are the samples (null and
 * empty leaves are left out), or single surfaces, all on the same points and polygons. ArrayName chooses the values of a
 * sample. With UseTimeSteps, every time step of the first connection adds its samples. At least 2 samples; values must be
 * finite.
 *
 * @par Output
 * Port 0: a vtkPolyData with the polygons and cell arrays of the first sample, the mean positions (of an array: the
 * positions of the first sample), and these point arrays, float64, with the number of components C of the values:
 * - Mean (of an array only): arithmetic mean;
 * - StandardDeviation: standard deviation of each component, divisor N - 1;
 * - StandardDistance (where C > 1): root of the sum of the variances of the components, one component;
 * - Quantile_0.05 and so on, for each of Quantiles: quantile of each component, linear between the order statistics (type 7
 *   of [Hyndman1996]);
 * - Mode_0, Mode_1 and so on: principal modes in descending order of variance, each times its standard deviation. Mean plus
 *   Mode_0 lies one standard deviation from the mean.
 * @par
 * Field arrays: NumberOfSamples, ModeStandardDeviations (float64 [K]: root of the sum over points and components of the
 * squared mode), TotalVariance (with modes: sum of the variances of all points and components), EnsembleArrayName (string).
 * @par
 * Port 1: a vtkTable with a row for each mode: Mode, Variance, StandardDeviation, Fraction and CumulativeFraction of the
 * total variance.
 * @par
 * Port 2: a vtkTable with a row for each sample: Sample (from 0 on), SampleName ("Block 3" with the flat index of the leaf)
 * and, with modes, Coefficient_0 and so on, in standard deviations.
 * @par
 * Empty input gives empty outputs. Lengths are in world units, or those of the array.
 *
 * @par Cost
 * O(N V) for N samples of V points, with quantiles O(N log(N) V), with modes O(N^2 V). Samples of composite datasets and
 * arrays are read in place: the results are all the memory that is needed. Time steps are added up one after the other, in
 * the memory of one; with quantiles or modes a copy of the values of all of them is kept, in their own precision.
 * The same bits for every number of threads.
 *
 * @sa vtkShapeModelSampler, vtkEnsembleMetrics, vtkMaternNoiseFilter
 */

#ifndef vtkEnsembleStatistics_h
#define vtkEnsembleStatistics_h

#include "vtkPolyDataAlgorithm.h"
#include "vtkSurfaceSynthesisStatisticsModule.h" // For export macro

#include <memory> // For std::unique_ptr
#include <string> // For std::string
#include <vector> // For std::vector

class VTKSURFACESYNTHESISSTATISTICS_EXPORT vtkEnsembleStatistics : public vtkPolyDataAlgorithm
{
public:
  static vtkEnsembleStatistics* New();
  vtkTypeMacro(vtkEnsembleStatistics, vtkPolyDataAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * Name of the point array, with any number of components. A surface without an array of this name has a sample in each
   * of the arrays called ArrayName_0, ArrayName_1 and so on, as vtkMaternNoiseFilter names its samples. Empty (the default)
   * stands for the points themselves.
   */
  void SetArrayName(const char* name);
  vtkGetCharFromStdStringMacro(ArrayName);
  ///@}

  ///@{
  /**
   * Probabilities of the quantiles, in [0, 1] each: 0.5 is the median, 0 the minimum, 1 the maximum.
   * SetNumberOfQuantiles() clamps to 0 and more and fills up with 0.5; SetQuantile() does nothing for an index out of range,
   * and GetQuantile() returns 0. Default none.
   */
  void SetNumberOfQuantiles(int number);
  int GetNumberOfQuantiles() const { return static_cast<int>(this->Quantiles.size()); }
  void SetQuantile(int index, double probability);
  double GetQuantile(int index) const;
  ///@}

  ///@{
  /**
   * Number of principal modes, at least 0; -1 stands for all. There are at most N - 1 for N samples, and those with less
   * than 1e-12 of the largest variance are left out. Default 0.
   */
  vtkSetClampMacro(NumberOfModes, int, -1, VTK_INT_MAX);
  vtkGetMacro(NumberOfModes, int);
  ///@}

  ///@{
  /**
   * Adds the samples of all time steps of the input, in place of those of the current one. Default off.
   */
  vtkSetMacro(UseTimeSteps, bool);
  vtkGetMacro(UseTimeSteps, bool);
  vtkBooleanMacro(UseTimeSteps, bool);
  ///@}

protected:
  vtkEnsembleStatistics();
  ~vtkEnsembleStatistics() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int FillOutputPortInformation(int port, vtkInformation* info) override;
  int RequestInformation(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int RequestUpdateExtent(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;

private:
  vtkEnsembleStatistics(const vtkEnsembleStatistics&) = delete;
  void operator=(const vtkEnsembleStatistics&) = delete;

  std::string ArrayName;
  std::vector<double> Quantiles;
  int NumberOfModes = 0;
  bool UseTimeSteps = false;

  class Internals;
  std::unique_ptr<Internals> Impl;
};

#endif
