// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkEnsembleMetrics
 * @brief   Computes metrics between a generated and a reference ensemble of shapes or signals
 *
 * Measures the quality of a generative model: compares a generated ensemble with a reference ensemble on the same
 * triangulation, sample by sample, as [Kuai2026], section 5 and appendix D (after [Achlioptas2018], [LopezPaz2017] and
 * [Yang2019]).
 *
 * @par Input
 * Port 0: the generated ensemble. Port 1: the reference ensemble. Each is a composite dataset of vtkPolyData, whose
 * leaves in order are the samples (null and empty leaves are left out), or a single vtkPolyData, all on the same points
 * and polygons. ArrayName chooses the values of a sample. Port 2, optional: the source, a vtkPolyData with the same
 * points and polygons, for instance the shape before it was deformed.
 * @par
 * Points are weighted by their lumped barycentric mass on the source, or without one on the surface of the first
 * reference sample. That surface must have finite points and no degenerate triangle. Values must be finite, except
 * at points that no polygon or strip uses, which do not count.
 *
 * @par Output
 * Port 0: a vtkTable with one row and these columns, float64 unless said otherwise:
 * - MMD: minimum matching distance as defined in [Kuai2026], the mean over the generated samples of the distance to
 *   the nearest reference: fidelity, low is good;
 * - ReverseMMD: minimum matching distance as defined in [Achlioptas2018], the mean over the references of the
 *   distance to the nearest generated sample: low is good;
 * - COV: coverage, the fraction of the references that are nearest to at least one generated sample, in (0, 1]:
 *   diversity, high is good;
 * - OneNearestNeighbourAccuracy: the fraction of samples whose nearest other sample in both ensembles together is of
 *   the same ensemble, in [0, 1]: about 0.5 is ideal, 1 means separate ensembles, 0 a copy of every reference;
 * - MeanError: the distance of the pointwise means of the two ensembles;
 * - GeneratedSpacing, ReferenceSpacing: the mean distance of a sample to the nearest other one of its own ensemble, 0
 *   for a single sample: the scale for MMD;
 * - NumberOfGenerated, NumberOfReferences, NumberOfPoints, NumberOfComponents (vtkIdType).
 * @par
 * Port 1: a vtkTable with a row for each generated sample and the columns Sample, NearestReference (vtkIdType, numbers
 * of samples from 0 on), SampleName, NearestReferenceName (string: "Block 3" with the flat index of the leaf, and the
 * array's name where a surface has several) and Distance (float64).
 * @par
 * Distances are in world units, or those of the array. Ties go to the first sample, generated before reference. Two
 * empty inputs give empty tables; one is an error.
 *
 * @par Cost
 * O((N + M)^2 V) for N generated and M reference samples of V points; the values are read in place. The same bits for
 * every number of threads.
 *
 * @sa vtkMaternNoiseFilter, vtkGroupDataSetsFilter
 */

#ifndef vtkEnsembleMetrics_h
#define vtkEnsembleMetrics_h

#include "vtkSurfaceSynthesisStatisticsModule.h" // For export macro
#include "vtkTableAlgorithm.h"

#include <memory> // For std::unique_ptr
#include <string> // For std::string

class VTKSURFACESYNTHESISSTATISTICS_EXPORT vtkEnsembleMetrics : public vtkTableAlgorithm
{
public:
  static vtkEnsembleMetrics* New();
  vtkTypeMacro(vtkEnsembleMetrics, vtkTableAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// Distances of two samples a and b, with m the mass of the points.
  enum Distances
  {
    MEAN_L2 = 0, ///< sum_i m_i || a_i - b_i || / sum_i m_i
    RMS = 1      ///< sqrt(sum_i m_i || a_i - b_i ||^2 / sum_i m_i)
  };

  ///@{
  /**
   * Name of the compared point array, with any number of components. A surface without an array of this name has a
   * sample in each of the arrays called ArrayName_0, ArrayName_1 and so on, as vtkMaternNoiseFilter names its samples.
   * Empty (the default) stands for the points themselves.
   */
  void SetArrayName(const char* name);
  vtkGetCharFromStdStringMacro(ArrayName);
  ///@}

  ///@{
  /**
   * Distance of two samples. MEAN_L2 is the mean distance of corresponding points, as in the paper. RMS is the root of
   * the mean squared distance, with a larger weight of outliers. Default MEAN_L2.
   */
  vtkSetClampMacro(Distance, int, MEAN_L2, RMS);
  vtkGetMacro(Distance, int);
  void SetDistanceToMeanL2() { this->SetDistance(MEAN_L2); }
  void SetDistanceToRMS() { this->SetDistance(RMS); }
  ///@}

  ///@{
  /**
   * Subtracts the mean value of each sample, weighted by mass, so that shapes are compared up to translation. Default
   * off.
   */
  vtkSetMacro(RemoveCentroid, bool);
  vtkGetMacro(RemoveCentroid, bool);
  vtkBooleanMacro(RemoveCentroid, bool);
  ///@}

  /**
   * Removes the source. ParaView needs this method, because its clean command cannot name a port.
   */
  void RemoveSource() { this->SetInputConnection(2, nullptr); }

  ///@{
  /**
   * Metrics of the last update, as in the table of port 0; 0 without an update.
   */
  double GetMMD() const;
  double GetReverseMMD() const;
  double GetCOV() const;
  double GetOneNearestNeighbourAccuracy() const;
  double GetMeanError() const;
  ///@}

protected:
  vtkEnsembleMetrics();
  ~vtkEnsembleMetrics() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;

private:
  vtkEnsembleMetrics(const vtkEnsembleMetrics&) = delete;
  void operator=(const vtkEnsembleMetrics&) = delete;

  std::string ArrayName;
  int Distance = MEAN_L2;
  bool RemoveCentroid = false;

  class Internals;
  std::unique_ptr<Internals> Impl;
};

#endif
