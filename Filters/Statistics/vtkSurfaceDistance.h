// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkSurfaceDistance
 * @brief   Measures the distance of two surfaces: mean, RMS, 95th percentile and Hausdorff distance
 *
 * Distances from places that are spread evenly over the area of each surface to the nearest places of the other one
 * [Aspert2002], in both directions, whatever the triangulations are.
 *
 * @par Input
 * Port 0: the first surface. Port 1: the second surface. Each a vtkPolyData of triangles, polygons or strips with finite
 * points and an area; open and non-manifold surfaces are allowed.
 *
 * @par Output
 * Port 0: the first surface with the point array Distance (float64): distance of each point to the second surface;
 * 0 for points that no polygon uses.
 * @par
 * Port 1: a vtkTable with three rows and the columns Direction ("first to second", "second to first", "both") and Mean, RMS,
 * Percentile95, Maximum (float64), world units. The row "both" weighs each surface by half, and its Maximum is the Hausdorff
 * distance, found at the samples and all points of polygons: a lower bound. The 95th percentile is that distance which 95
 * percent of the area do not exceed.
 * @par
 * Two empty inputs give empty outputs; one is an error. The same bits for every number of threads.
 *
 * @sa vtkEnsembleMetrics, vtkGeometricTextureDistance
 */

#ifndef vtkSurfaceDistance_h
#define vtkSurfaceDistance_h

#include "vtkPolyDataAlgorithm.h"
#include "vtkSurfaceSynthesisStatisticsModule.h" // For export macro

#include <memory> // For std::unique_ptr

class VTKSURFACESYNTHESISSTATISTICS_EXPORT vtkSurfaceDistance : public vtkPolyDataAlgorithm
{
public:
  static vtkSurfaceDistance* New();
  vtkTypeMacro(vtkSurfaceDistance, vtkPolyDataAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * Number of samples on each surface, at least 1. Default 100000.
   */
  vtkSetClampMacro(NumberOfSamples, int, 1, VTK_INT_MAX);
  vtkGetMacro(NumberOfSamples, int);
  ///@}

  ///@{
  /**
   * Seed of the places of the samples, any integer. Default 0.
   */
  vtkSetMacro(Seed, int);
  vtkGetMacro(Seed, int);
  ///@}

  ///@{
  /**
   * Distances of the last update in both directions together, as in the table of port 1; 0 without an update.
   */
  double GetMean() const;
  double GetRMS() const;
  double GetPercentile95() const;
  double GetHausdorffDistance() const;
  ///@}

protected:
  vtkSurfaceDistance();
  ~vtkSurfaceDistance() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int FillOutputPortInformation(int port, vtkInformation* info) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;

private:
  vtkSurfaceDistance(const vtkSurfaceDistance&) = delete;
  void operator=(const vtkSurfaceDistance&) = delete;

  int NumberOfSamples = 100000;
  int Seed = 0;

  class Internals;
  std::unique_ptr<Internals> Impl;
};

#endif
