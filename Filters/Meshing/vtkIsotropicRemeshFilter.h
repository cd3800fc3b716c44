// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkIsotropicRemeshFilter
 * @brief   Remeshes a surface with triangles of even size and shape
 *
 * Replaces the triangles of a surface by nearly equilateral ones of a given edge length: rounds of edge splits,
 * collapses, flips, tangential relaxation and projection to the input [Botsch2004], by CGAL's isotropic_remeshing().
 * With a point array of edge lengths the triangles vary in size over the surface.
 *
 * @par Input
 * vtkPolyData with triangles, polygons or strips, float or double points, open or closed, any number of components; or
 * a composite dataset of such blocks, processed block by block: a block that cannot be processed is reported and left
 * empty. The mesh must have finite points, no degenerate triangle, manifold edges and points, and consistent winding;
 * the error message names the defect, and vtkSurfaceRepairFilter repairs it. Points of equal coordinates are merged, so
 * that a triangle soup becomes a connected surface. Empty input gives empty output.
 *
 * @par Output
 * A vtkPolyData of triangles in world coordinates, with points of the precision of the input's. Its points lie on the
 * input surface. Point arrays are interpolated: floating-point arrays linearly (normals are scaled to unit length),
 * integers and text, which are labels, from the nearest point. Cell arrays come from the nearest cell. Field data is
 * kept. Global ids, ghost arrays, vertices and lines are left out.
 *
 * @par Curves
 * Boundaries, creases (KeepFeatureEdges) and seams of point arrays are kept as curves: their points are redistributed
 * along them, and corners are kept. At a seam points of equal coordinates have different values, as at the border of a
 * texture image; the output then has a point on either side, too.
 *
 * @par Cost
 * About two seconds for 100,000 triangles of the output. The result does not depend on the number of threads.
 *
 * @sa vtkSurfaceRepairFilter, vtkVDBSurfaceFilter, vtkTopologyReport, vtkAdaptiveSubdivisionFilter, vtkDecimatePro
 */

#ifndef vtkIsotropicRemeshFilter_h
#define vtkIsotropicRemeshFilter_h

#include "vtkDataObjectAlgorithm.h"
#include "vtkSurfaceSynthesisMeshingModule.h" // For export macro

#include <memory> // For std::unique_ptr
#include <string> // For std::string

class VTKSURFACESYNTHESISMESHING_EXPORT vtkIsotropicRemeshFilter : public vtkDataObjectAlgorithm
{
public:
  static vtkIsotropicRemeshFilter* New();
  vtkTypeMacro(vtkIsotropicRemeshFilter, vtkDataObjectAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * Target edge length, in world units; at least 0. Most edges of the output are between 4/5 and 4/3 of it, on average
   * 0.92 of it unless the edges of the input already were within these bounds. 0 (the default) stands for the mean edge
   * length of the input. A length above the diagonal of the surface is an error. Ignored when TargetNumberOfPoints or SizingArrayName is set.
   */
  vtkSetClampMacro(TargetEdgeLength, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(TargetEdgeLength, double);
  ///@}

  ///@{
  /**
   * Target number of points of the output, or of each block; at least 0. It is met within about 2 per cent where curves
   * allow it, by up to six attempts, each of which costs a remeshing. 0 (the default) uses the edge length.
   */
  vtkSetClampMacro(TargetNumberOfPoints, int, 0, VTK_INT_MAX);
  vtkGetMacro(TargetNumberOfPoints, int);
  ///@}

  ///@{
  /**
   * Name of a point array with one component: the target edge length at each point, in world units, larger than 0. With
   * TargetNumberOfPoints, only the ratios of its values matter. Empty (the default): the same length everywhere.
   */
  void SetSizingArrayName(const char* name);
  vtkGetCharFromStdStringMacro(SizingArrayName);
  ///@}

  ///@{
  /**
   * Keeps creases: edges whose triangles meet at more than FeatureAngle. Default on.
   */
  vtkSetMacro(KeepFeatureEdges, bool);
  vtkGetMacro(KeepFeatureEdges, bool);
  vtkBooleanMacro(KeepFeatureEdges, bool);
  ///@}

  ///@{
  /**
   * Angle between the normals of two triangles above which their edge is a crease, in degrees, from 0 to 180. Noisy
   * scans need a large angle; creases shorter than five target edge lengths count as noise. Default 60.
   */
  vtkSetClampMacro(FeatureAngle, double, 0.0, 180.0);
  vtkGetMacro(FeatureAngle, double);
  ///@}

  ///@{
  /**
   * Keeps every point of a boundary, for instance where another surface continues; boundary edges that are too long are
   * still divided. Off: points are redistributed along boundaries. Default off.
   */
  vtkSetMacro(KeepBoundaryPoints, bool);
  vtkGetMacro(KeepBoundaryPoints, bool);
  vtkBooleanMacro(KeepBoundaryPoints, bool);
  ///@}

  ///@{
  /**
   * Number of rounds, from 1 to 100; more rounds give more even triangles and cost more. Default 3.
   */
  vtkSetClampMacro(NumberOfIterations, int, 1, 100);
  vtkGetMacro(NumberOfIterations, int);
  ///@}

  ///@{
  /**
   * Number of steps of tangential relaxation in each round, from 0 to 100. Default 1.
   */
  vtkSetClampMacro(NumberOfRelaxationSteps, int, 0, 100);
  vtkGetMacro(NumberOfRelaxationSteps, int);
  ///@}

  ///@{
  /**
   * Limit of the points of the output, or of each block, at least 4. An edge length, a sizing array or a number of points
   * that needs more is an error before the work begins; the message names a length that fits. Default 10,000,000, which
   * take about 5 GB.
   */
  vtkSetClampMacro(MaximumNumberOfPoints, int, 4, VTK_INT_MAX);
  vtkGetMacro(MaximumNumberOfPoints, int);
  ///@}

  /**
   * Mean edge length of the output of the last update, world units, for the last block of a composite input.
   */
  double GetMeanEdgeLength() const { return this->MeanEdgeLength; }

protected:
  vtkIsotropicRemeshFilter();
  ~vtkIsotropicRemeshFilter() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestDataObject(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;

private:
  vtkIsotropicRemeshFilter(const vtkIsotropicRemeshFilter&) = delete;
  void operator=(const vtkIsotropicRemeshFilter&) = delete;

  class Internals;

  double TargetEdgeLength = 0.0;
  int TargetNumberOfPoints = 0;
  std::string SizingArrayName;
  bool KeepFeatureEdges = true;
  double FeatureAngle = 60.0;
  bool KeepBoundaryPoints = false;
  int NumberOfIterations = 3;
  int NumberOfRelaxationSteps = 1;
  int MaximumNumberOfPoints = 10000000;
  double MeanEdgeLength = 0.0;
};

#endif
