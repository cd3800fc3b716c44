// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkMaternParameterEstimator
 * @brief   Estimates correlation range and deviations of Matérn fields from observations
 *
 * Finds the parameters of vtkMaternNoiseFilter that fit data: correlation range and standard deviation of a Matérn
 * field on the surface (smoothness OperatorPower - 1), and the standard deviation of independent errors of the observations, by maximum
 * likelihood, with their intervals of 95 % from the observed information. The likelihood is that of the finite-element
 * model itself [Lindgren2011], computed from sparse factors [Rue2005]. Of 100 simulated fields of 300 observations on a
 * surface of 35 squared ranges, the intervals held the true range, standard deviation and noise deviation in 94, 98 and 92
 * for OperatorPower 2, in 94, 94 and 95 for 3, and in 93, 94 and 92 for 4; 95 are expected, 91 to 99 in 19 of 20 such counts.
 *
 * @par Input
 * Port 0: one vtkPolyData with triangles, polygons or strips, float or double points, any number of components; the
 * mesh must pass the check of vtkMaternNoiseFilter. Port 1, optional: a vtkPointSet with observations near the surface.
 * The point array ObservationArray, of port 1 where it is connected and else of port 0, holds the values: each
 * component is an independent field with the same parameters; or the arrays ObservationArray_0, ObservationArray_1 and
 * so on do, as vtkMaternNoiseFilter names its samples. Points of port 0 that no polygon or strip uses do not count.
 *
 * @par Output
 * A vtkTable with the rows CorrelationRange, StandardDeviation and NoiseDeviation and the columns Parameter (string),
 * Estimate, StandardError (of the natural logarithm, about the relative error), Lower and Upper (of the interval of
 * 95 %), float64. A noise deviation below a thousandth of the standard deviation is 0, with that thousandth as Upper.
 * Empty input gives an empty table.
 *
 * @par Cost
 * About 80 evaluations of the likelihood, each of two sparse factorisations and a solve for each field, whatever the
 * number of observations. Of a single field that spans few ranges, the parameters are known poorly, and the intervals
 * are wide.
 *
 * @sa vtkMaternNoiseFilter
 */

#ifndef vtkMaternParameterEstimator_h
#define vtkMaternParameterEstimator_h

#include "vtkSurfaceSynthesisNoiseModule.h" // For export macro
#include "vtkTableAlgorithm.h"

#include <memory> // For std::unique_ptr
#include <string> // For std::string

class VTKSURFACESYNTHESISNOISE_EXPORT vtkMaternParameterEstimator : public vtkTableAlgorithm
{
public:
  static vtkMaternParameterEstimator* New();
  vtkTypeMacro(vtkMaternParameterEstimator, vtkTableAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * Name of the point array with the observed values, any number of components, each a field of its own; or the first
   * part of the names of several. Empty (the default) stands for the active scalars.
   */
  void SetObservationArray(const char* name);
  vtkGetCharFromStdStringMacro(ObservationArray);
  ///@}

  ///@{
  /**
   * Largest distance of an observation from the surface, in world units, at least 0; observations attach to the nearest
   * point of the surface, and one farther away is an error. 0 (the default) stands for a hundredth of the longest side
   * of the bounding box of the surface.
   */
  vtkSetClampMacro(Tolerance, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(Tolerance, double);
  ///@}

  ///@{
  /**
   * Power alpha of the operator of the field, 2 to 4; it is given and not estimated. The power 1 has no correlation range.
   * Time and memory increase with it. Default 2.
   */
  vtkSetClampMacro(OperatorPower, int, 2, 4);
  vtkGetMacro(OperatorPower, int);
  ///@}

  ///@{
  /**
   * Estimation of independent errors of the observations. Off, they are taken as exact. Default on.
   */
  vtkSetMacro(NoiseEstimation, bool);
  vtkGetMacro(NoiseEstimation, bool);
  vtkBooleanMacro(NoiseEstimation, bool);
  ///@}

  ///@{
  /**
   * Estimation of a constant mean of each field. Off, it is taken as 0. Default on.
   */
  vtkSetMacro(MeanEstimation, bool);
  vtkGetMacro(MeanEstimation, bool);
  vtkBooleanMacro(MeanEstimation, bool);
  ///@}

  /**
   * Removes the observations. ParaView needs this method, because its clean command cannot name a port.
   */
  void RemoveObservations() { this->SetInputConnection(1, nullptr); }

  ///@{
  /**
   * Results of the last update, as in the table; 0 without an update. CorrelationRange: world units. StandardDeviation,
   * NoiseDeviation: units of the observations. LogLikelihood: natural logarithm at the estimate. NumberOfObservations:
   * places. NumberOfFields: fields observed there.
   */
  double GetCorrelationRange() const;
  double GetStandardDeviation() const;
  double GetNoiseDeviation() const;
  double GetLogLikelihood() const;
  vtkTypeInt64 GetNumberOfObservations() const;
  vtkTypeInt64 GetNumberOfFields() const;
  ///@}

protected:
  vtkMaternParameterEstimator();
  ~vtkMaternParameterEstimator() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;

private:
  vtkMaternParameterEstimator(const vtkMaternParameterEstimator&) = delete;
  void operator=(const vtkMaternParameterEstimator&) = delete;

  std::string ObservationArray;
  double Tolerance = 0.0;
  int OperatorPower = 2;
  bool NoiseEstimation = true;
  bool MeanEstimation = true;

  class Internals;
  std::unique_ptr<Internals> Impl;
};

#endif
