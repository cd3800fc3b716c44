// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkVDBSurfaceFilter
 * @brief   Computes closed manifold surfaces from images and defective surfaces, by OpenVDB's level sets
 *
 * Converts image data, or any surface or triangle soup, to a solid on a grid of voxels [Museth2013], processes the
 * solid (closing, smoothing, offset, cavities, largest part), and extracts its surface. The output is closed, manifold
 * in edges and points, consistently wound outwards, and without degenerate triangles, so that every filter of this
 * library accepts it.
 *
 * @par Input
 * vtkImageData with any origin, spacing, direction (orthogonal) and scalar type; or vtkPolyData with triangles,
 * polygons or strips; or a composite dataset of such blocks, which are processed one by one. Empty input gives empty
 * output.
 *
 * @par Images
 * The solid is the region with scalars (SetInputArrayToProcess(); default the active point scalars; one component, on
 * points or cells) above IsoValue, or below it. Values between samples are linear. Where the solid reaches the border
 * of the image the surface is capped half a sample beyond the outermost samples. NaN is outside. Points are in world
 * coordinates, in double precision, also for anisotropic, rotated and mirrored images. As long as VoxelSize, Closing,
 * Offset and Smoothing are at their defaults the surface is taken from the samples themselves.
 *
 * @par Surfaces
 * Non-manifold edges, inconsistent winding, holes, self-intersections, duplicate and degenerate triangles and any
 * number of parts are accepted; only points that are not finite and unreadable cells are errors. For a closed, manifold
 * and consistently wound surface whose parts do not overlap, the winding defines the inside, and cavities remain.
 * Otherwise the solid is the region that is not connected to the outside: gaps narrower than a voxel, or than twice
 * Closing, are bridged, overlapping parts united, cavities filled. Parts of the surface that enclose nothing, such as
 * open sheets, become plates two voxels thick. The result lies within about half a voxel of the input; parts thinner
 * than a voxel may get holes or vanish.
 *
 * @par Output
 * vtkPolyData of triangles. The point arrays of a surface are interpolated from the nearest place on it; those of an
 * image, but for the scalars themselves, from its samples (floating point linearly, labels from the nearest). When
 * nothing lies inside, the output is empty and a warning names the range of the data.
 *
 * @par Order
 * Level set, Closing, Smoothing, Offset, FillCavities, LargestComponent, extraction with Adaptivity. Lengths are in
 * world units. The result has the same bits for every number of threads. The cost is proportional to the number of
 * voxels along the surface, its area / VoxelSize^2.
 *
 * @sa vtkFlyingEdges3D, vtkDiscreteMarchingCubes, vtkImplicitModeller
 */

#ifndef vtkVDBSurfaceFilter_h
#define vtkVDBSurfaceFilter_h

#include "vtkDataObjectAlgorithm.h"
#include "vtkSurfaceSynthesisMeshingModule.h" // For export macro

#include <memory> // For std::unique_ptr

class vtkPolyData;

class VTKSURFACESYNTHESISMESHING_EXPORT vtkVDBSurfaceFilter : public vtkDataObjectAlgorithm
{
public:
  static vtkVDBSurfaceFilter* New();
  vtkTypeMacro(vtkVDBSurfaceFilter, vtkDataObjectAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// Sides of the isovalue that are solid.
  enum InsideRules
  {
    ABOVE = 0, ///< values larger than the isovalue
    BELOW = 1  ///< values smaller than the isovalue
  };

  /// Methods of smoothing of the level set.
  enum SmoothingTypes
  {
    NONE = 0,           ///< no smoothing
    GAUSSIAN = 1,       ///< a Gaussian of standard deviation 1.6 voxels; strong, shrinks thin parts
    MEAN_CURVATURE = 2, ///< flow by mean curvature: removes spikes, shrinks spheres slowly
    MEDIAN = 3,         ///< the median of 3 x 3 x 3 voxels: removes specks, keeps corners better; slow
    LAPLACIAN = 4       ///< flow by the Laplacian of the distance
  };

  /// Returns the output for an input that is no composite dataset, else null.
  vtkPolyData* GetPolyDataOutput();

  ///@{
  /**
   * Computes the isovalue from the histogram of the image by Otsu's method, which separates two classes of values best
   * [Otsu1979]. Off, IsoValue is used. Default on.
   */
  vtkSetMacro(ComputeIsoValue, bool);
  vtkGetMacro(ComputeIsoValue, bool);
  vtkBooleanMacro(ComputeIsoValue, bool);
  ///@}

  ///@{
  /**
   * Value on the surface, within those of the image, in their units. Used when ComputeIsoValue is off. Default 0.
   */
  vtkSetMacro(IsoValue, double);
  vtkGetMacro(IsoValue, double);
  ///@}

  ///@{
  /**
   * Side of the isovalue that is solid, in images. Default ABOVE.
   */
  vtkSetClampMacro(InsideRule, int, ABOVE, BELOW);
  vtkGetMacro(InsideRule, int);
  void SetInsideRuleToAbove() { this->SetInsideRule(ABOVE); }
  void SetInsideRuleToBelow() { this->SetInsideRule(BELOW); }
  ///@}

  ///@{
  /**
   * Side of the voxels of the level set, world units, at least 0 and at most the longest side of the bounding box of
   * the surface, or of the solid in an image, moved by Offset; it is the size of the smallest features and of the
   * triangles of the output. Time and memory are proportional to its inverse square. 0 (the default) stands for the
   * smallest spacing of an image, and for 1/128 of the longest side of the bounding box of a surface.
   */
  vtkSetClampMacro(VoxelSize, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(VoxelSize, double);
  ///@}

  ///@{
  /**
   * Radius of a morphological closing, world units, at least 0: gaps, holes and grooves narrower than twice this are
   * filled, and the rest of the surface is unchanged. Default 0.
   */
  vtkSetClampMacro(Closing, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(Closing, double);
  ///@}

  ///@{
  /**
   * Method of smoothing of the level set. Default NONE.
   */
  vtkSetClampMacro(Smoothing, int, NONE, LAPLACIAN);
  vtkGetMacro(Smoothing, int);
  void SetSmoothingToNone() { this->SetSmoothing(NONE); }
  void SetSmoothingToGaussian() { this->SetSmoothing(GAUSSIAN); }
  void SetSmoothingToMeanCurvature() { this->SetSmoothing(MEAN_CURVATURE); }
  void SetSmoothingToMedian() { this->SetSmoothing(MEDIAN); }
  void SetSmoothingToLaplacian() { this->SetSmoothing(LAPLACIAN); }
  ///@}

  ///@{
  /**
   * Number of iterations of the smoothing, from 0 to 1000; the range is one or two voxels for one iteration, and
   * sqrt(n) times that for n. Default 3.
   */
  vtkSetClampMacro(SmoothingIterations, int, 0, 1000);
  vtkGetMacro(SmoothingIterations, int);
  ///@}

  ///@{
  /**
   * Distance by which the surface is moved outwards, world units; negative values move it inwards. Default 0.
   */
  vtkSetMacro(Offset, double);
  vtkGetMacro(Offset, double);
  ///@}

  ///@{
  /**
   * Degree to which larger triangles cover flat regions, from 0 (all of the size of voxels) to 1 (up to eight voxels,
   * also across sharp edges, which are then bevelled). Default 0.
   */
  vtkSetClampMacro(Adaptivity, double, 0.0, 1.0);
  vtkGetMacro(Adaptivity, double);
  ///@}

  ///@{
  /**
   * Fills the cavities of the solid. Default off.
   */
  vtkSetMacro(FillCavities, bool);
  vtkGetMacro(FillCavities, bool);
  vtkBooleanMacro(FillCavities, bool);
  ///@}

  ///@{
  /**
   * Keeps only the component of the solid with the largest volume, with its cavities. Voxels are connected across
   * faces. Default off.
   */
  vtkSetMacro(LargestComponent, bool);
  vtkGetMacro(LargestComponent, bool);
  vtkBooleanMacro(LargestComponent, bool);
  ///@}

  ///@{
  /**
   * Largest number of voxels along the surface, at least 1000. More are an error, before memory is allocated; the
   * message names a possible VoxelSize. A voxel takes about 20 bytes; Offset may visit each ten times. Default 2e8.
   */
  vtkSetClampMacro(MaximumNumberOfVoxels, int, 1000, VTK_INT_MAX);
  vtkGetMacro(MaximumNumberOfVoxels, int);
  ///@}

  /**
   * Isovalue of the last image, given or computed; 0 before the first image.
   */
  double GetEffectiveIsoValue() const;

protected:
  vtkVDBSurfaceFilter();
  ~vtkVDBSurfaceFilter() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestDataObject(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int RequestUpdateExtent(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;

private:
  vtkVDBSurfaceFilter(const vtkVDBSurfaceFilter&) = delete;
  void operator=(const vtkVDBSurfaceFilter&) = delete;

  bool ComputeIsoValue = true;
  double IsoValue = 0.0;
  int InsideRule = ABOVE;
  double VoxelSize = 0.0;
  double Closing = 0.0;
  int Smoothing = NONE;
  int SmoothingIterations = 3;
  double Offset = 0.0;
  double Adaptivity = 0.0;
  bool FillCavities = false;
  bool LargestComponent = false;
  int MaximumNumberOfVoxels = 200000000;

  class Internals;
  std::unique_ptr<Internals> Impl;
};

#endif
