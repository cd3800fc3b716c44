// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkShapeModelSampler
 * @brief   Makes random, given or fitted shapes or signals of a statistical shape model
 *
 * Shapes x = mean + sum_k b_k mode_k of the model that vtkEnsembleStatistics makes of an ensemble [Cootes1995]. The
 * coefficients b, in standard deviations of the modes, are random, given, or those of the orthogonal projection of other
 * shapes on the model.
 *
 * @par Input
 * Port 0: the model, a vtkPolyData with the arrays of the first output of vtkEnsembleStatistics with NumberOfModes: point
 * arrays Mode_0, Mode_1 and so on (float32 or float64), Mean for a model of an array, and the field array EnsembleArrayName.
 * Port 1, for PROJECTED only: the shapes, a composite dataset of vtkPolyData or a single one, on the points and polygons of
 * the model; of a model of an array, with that array or with arrays of that name and _0, _1 and so on.
 *
 * @par Output
 * A vtkMultiBlockDataSet with a vtkPolyData for each sample, called "Sample 0", "Sample 1" and so on: cells and cell arrays
 * of the model with new points, or of a model of an array with its points and the point array of that name (float64). Each
 * has the field array Coefficients (float64 [K]). PROJECTED adds the point array Residual (float64, one component: distance
 * of the projection from the shape, world units or those of the array) and the field array RMSResidual (root of the mean
 * over points of its square). Empty input gives empty output.
 *
 * @sa vtkEnsembleStatistics, vtkFlowMatchingDeformer
 */

#ifndef vtkShapeModelSampler_h
#define vtkShapeModelSampler_h

#include "vtkMultiBlockDataSetAlgorithm.h"
#include "vtkSurfaceSynthesisStatisticsModule.h" // For export macro

#include <memory> // For std::unique_ptr
#include <vector> // For std::vector

class VTKSURFACESYNTHESISSTATISTICS_EXPORT vtkShapeModelSampler : public vtkMultiBlockDataSetAlgorithm
{
public:
  static vtkShapeModelSampler* New();
  vtkTypeMacro(vtkShapeModelSampler, vtkMultiBlockDataSetAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// The sources of coefficients.
  enum CoefficientSources
  {
    RANDOM = 0,   ///< independent N(0, 1) numbers
    GIVEN = 1,    ///< the property Coefficients
    PROJECTED = 2 ///< the nearest shapes of the model to those of port 1
  };

  ///@{
  /**
   * Source of the coefficients: RANDOM makes NumberOfSamples shapes, GIVEN one, PROJECTED one for each shape of the second
   * input. Default RANDOM.
   */
  vtkSetClampMacro(CoefficientSource, int, RANDOM, PROJECTED);
  vtkGetMacro(CoefficientSource, int);
  void SetCoefficientSourceToRandom() { this->SetCoefficientSource(RANDOM); }
  void SetCoefficientSourceToGiven() { this->SetCoefficientSource(GIVEN); }
  void SetCoefficientSourceToProjected() { this->SetCoefficientSource(PROJECTED); }
  ///@}

  ///@{
  /**
   * Coefficients for GIVEN, in standard deviations of the modes; those of other modes are 0. SetNumberOfCoefficients() clamps
   * to 0 and more and fills up with 0; SetCoefficient() does nothing for an index out of range, and GetCoefficient() returns
   * 0. Default none: the mean.
   */
  void SetNumberOfCoefficients(int number);
  int GetNumberOfCoefficients() const { return static_cast<int>(this->Coefficients.size()); }
  void SetCoefficient(int index, double value);
  double GetCoefficient(int index) const;
  ///@}

  ///@{
  /**
   * Number of modes that are used, the first ones, at least 0; -1 stands for all. Default -1.
   */
  vtkSetClampMacro(NumberOfModes, int, -1, VTK_INT_MAX);
  vtkGetMacro(NumberOfModes, int);
  ///@}

  ///@{
  /**
   * Number of samples for RANDOM, at least 1. Default 1.
   */
  vtkSetClampMacro(NumberOfSamples, int, 1, VTK_INT_MAX);
  vtkGetMacro(NumberOfSamples, int);
  ///@}

  ///@{
  /**
   * Index of the first sample for RANDOM, at least 0; an ensemble can be generated in parts. Default 0.
   */
  vtkSetClampMacro(FirstSample, int, 0, VTK_INT_MAX);
  vtkGetMacro(FirstSample, int);
  ///@}

  ///@{
  /**
   * Seed of the random numbers, any integer: the same seed always gives the same shapes. Default 0.
   */
  vtkSetMacro(Seed, int);
  vtkGetMacro(Seed, int);
  ///@}

  /**
   * Removes the shapes. ParaView needs this method, because its clean command cannot name a port.
   */
  void RemoveShapes() { this->SetInputConnection(1, nullptr); }

protected:
  vtkShapeModelSampler();
  ~vtkShapeModelSampler() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;

private:
  vtkShapeModelSampler(const vtkShapeModelSampler&) = delete;
  void operator=(const vtkShapeModelSampler&) = delete;

  int CoefficientSource = RANDOM;
  std::vector<double> Coefficients;
  int NumberOfModes = -1;
  int NumberOfSamples = 1;
  int FirstSample = 0;
  int Seed = 0;

  class Internals;
  std::unique_ptr<Internals> Impl;
};

#endif
