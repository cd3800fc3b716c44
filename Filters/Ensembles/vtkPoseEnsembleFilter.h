// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkPoseEnsembleFilter
 * @brief   Generates random poses of a shape: copies with rotated limbs, for training and testing
 *
 * Finds the extremities of a shape (hands, feet, head, tail), holds the part near its centroid and turns each extremity
 * about its joint by random angles. The rest follows as rigidly as possible, with rotations that vary smoothly over the
 * surface ([Sorkine2007], [Levi2015]), by CGAL's Surface_mesh_deformation.
 *
 * @par Input
 * Port 0: vtkPolyData with triangles, polygons or strips, float or double points, open or closed; or a composite
 * dataset of such blocks, each of which is posed by itself, with rotations that differ between blocks. The mesh must be
 * connected, with finite points, no degenerate triangle, manifold edges and points, and consistent winding; the error
 * message names the defect, and vtkSurfaceRepairFilter repairs it. Empty input gives empty output.
 *
 * Port 1, optional: a vtkPolyData, another triangulation of the same shape in the same position. Extremities, joints
 * and regions are then found on it. With the same template, seed and sample, every triangulation of the shape gets the
 * same pose: on even triangulations that are fine enough for the limbs, the results agree to about half a per cent of
 * the shape's size on average (root of the mean square) and a few per cent at worst.
 *
 * @par Output
 * A vtkMultiBlockDataSet (for a composite input, the input's class with one in place of each block) with a vtkPolyData
 * for each sample, named "Sample k" for k = FirstSample, FirstSample + 1, ...: the input with moved points of the same
 * precision, without normals, plus two point arrays: the displacement from the input (three components, of the points'
 * precision) and the region of the point (int): 0, 1, ... for the extremities, NumberOfHandles for the fixed part and
 * -1 for the rest. Points that no polygon or strip uses stay where they are. The displacement becomes the active
 * vectors where the input has none.
 *
 * @par Scale
 * Lengths are fractions of the shape's size, the square root of its area; the poses do not change with the unit.
 *
 * @par Cost
 * About 60 ms of one processor for each sample on 1,500 points and 300 ms on 5,000; samples are made in parallel.
 * Equations and their factors are kept until the input, the template or another parameter than the seed and the samples
 * changes. The same seed gives the same bits for every number of threads, and sample k is the same alone or in a batch.
 * Another kind of processor may give other last bits: Reproducibility in README.md.
 *
 * @par Failure
 * A pose that is not finite, or in which more than a twentieth of the surface lies in triangles whose area has become
 * three times as large or as small, is an error that names the sample; MaximumAngle is then too large for the shape.
 *
 * @sa vtkGaussianMixtureFilter, vtkSurfaceRepairFilter, vtkIsotropicRemeshFilter
 */

#ifndef vtkPoseEnsembleFilter_h
#define vtkPoseEnsembleFilter_h

#include "vtkDataObjectAlgorithm.h"
#include "vtkSurfaceSynthesisEnsemblesModule.h" // For export macro

#include <memory> // For std::unique_ptr
#include <string> // For std::string

class VTKSURFACESYNTHESISENSEMBLES_EXPORT vtkPoseEnsembleFilter : public vtkDataObjectAlgorithm
{
public:
  static vtkPoseEnsembleFilter* New();
  vtkTypeMacro(vtkPoseEnsembleFilter, vtkDataObjectAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * Sets the template of port 1, as a connection or as data; null (the default) for none.
   */
  void SetTemplateConnection(vtkAlgorithmOutput* port);
  void SetTemplateData(vtkDataObject* shape);
  ///@}

  /**
   * Removes the template. ParaView needs this method, because its clean command cannot name a port.
   */
  void RemoveTemplate() { this->SetInputConnection(1, nullptr); }

  ///@{
  /**
   * Seed of the random numbers, any integer. Each seed gives different poses; the same seed always gives the same
   * rotations for the same sample and handle. Default 0.
   */
  vtkSetMacro(Seed, int);
  vtkGetMacro(Seed, int);
  ///@}

  ///@{
  /**
   * Number of samples, each a dataset of its own; at least 1. Default 12.
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
   * Distance of neighboring samples in a grid in the xy plane, as a fraction of the box of the input along each axis; at least
   * 0. 0 leaves all samples in the place of the input. The array of displacements is without it, and each sample gets the
   * field array "Translation", three components, world units. Default 0.
   */
  vtkSetClampMacro(Spread, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(Spread, double);
  ///@}

  ///@{
  /**
   * Number of rotated extremities, from 1 to 100. The extremities are the points farthest, along the surface, from the
   * centre and from each other. Default 6.
   */
  vtkSetClampMacro(NumberOfHandles, int, 1, 100);
  vtkGetMacro(NumberOfHandles, int);
  ///@}

  ///@{
  /**
   * Largest rotation angle of an extremity about its joint, in degrees, from 0 to 180. The mean angle is 3/4 of it; the
   * axis is random. Default 60.
   */
  vtkSetClampMacro(MaximumAngle, double, 0.0, 180.0);
  vtkGetMacro(MaximumAngle, double);
  ///@}

  ///@{
  /**
   * Largest angle of an additional rotation of an extremity about its own centre, in degrees, from 0 to 180. Default
   * 20.
   */
  vtkSetClampMacro(MaximumTwist, double, 0.0, 180.0);
  vtkGetMacro(MaximumTwist, double);
  ///@}

  ///@{
  /**
   * Radius of the rigid part around an extremity, along the surface, as a fraction of the shape's size, from 0.001 to
   * 1. Default 0.08.
   */
  vtkSetClampMacro(HandleRadius, double, 0.001, 1.0);
  vtkGetMacro(HandleRadius, double);
  ///@}

  ///@{
  /**
   * Extent of the fixed part near the centroid, as a fraction of the shape's size, from 0.001 to 1. Points are fixed
   * when their distance from the centroid exceeds the smallest such distance by at most this. Points within three
   * handle radii of an extremity are never fixed. Default 0.12.
   */
  vtkSetClampMacro(AnchorRadius, double, 0.001, 1.0);
  vtkGetMacro(AnchorRadius, double);
  ///@}

  ///@{
  /**
   * Position of the joint of an extremity on the path along the surface from the extremity (0) to the fixed part (1).
   * Default 0.8.
   */
  vtkSetClampMacro(PivotPosition, double, 0.0, 1.0);
  vtkGetMacro(PivotPosition, double);
  ///@}

  ///@{
  /**
   * Number of iterations of the deformation for each pose, from 1 to 10000; more make the results of different
   * triangulations more alike. Default 40.
   */
  vtkSetClampMacro(NumberOfIterations, int, 1, 10000);
  vtkGetMacro(NumberOfIterations, int);
  ///@}

  ///@{
  /**
   * Resistance to bending, relative to the area, from 0 to 1; with larger values limbs bend over a longer distance, and
   * more iterations are needed. Default 0.0002.
   */
  vtkSetClampMacro(Stiffness, double, 0.0, 1.0);
  vtkGetMacro(Stiffness, double);
  ///@}

  ///@{
  /**
   * Name of the point array with the displacement from the input; not empty. Default "Displacement".
   */
  void SetDisplacementArrayName(const char* name);
  vtkGetCharFromStdStringMacro(DisplacementArrayName);
  ///@}

  ///@{
  /**
   * Name of the point array with the region of each point; not empty. Default "PoseRegion".
   */
  void SetRegionArrayName(const char* name);
  vtkGetCharFromStdStringMacro(RegionArrayName);
  ///@}

  /**
   * Number of meshes assembled and factored since this object was made. Unchanged while only the seed and the samples
   * change.
   */
  vtkTypeInt64 GetNumberOfFactorizations() const;

protected:
  vtkPoseEnsembleFilter();
  ~vtkPoseEnsembleFilter() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestDataObject(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;

private:
  vtkPoseEnsembleFilter(const vtkPoseEnsembleFilter&) = delete;
  void operator=(const vtkPoseEnsembleFilter&) = delete;

  int Seed = 0;
  int NumberOfSamples = 12;
  int FirstSample = 0;
  int MemoryLimit = 0;
  double Spread = 0.0;
  int NumberOfHandles = 6;
  double MaximumAngle = 60.0;
  double MaximumTwist = 20.0;
  double HandleRadius = 0.08;
  double AnchorRadius = 0.12;
  double PivotPosition = 0.8;
  int NumberOfIterations = 40;
  double Stiffness = 2e-4;
  std::string DisplacementArrayName = "Displacement";
  std::string RegionArrayName = "PoseRegion";

  class Internals;
  std::unique_ptr<Internals> Impl;
};

#endif
