// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkGeometricTextureDistance
 * @brief   Measures the distance between the geometric textures of two surfaces
 *
 * Measures the quality of a synthesized geometric texture, on surfaces of any shape: compares the local neighbourhoods
 * of the triangles of a surface with those of a reference. These are the input of the networks of
 * vtkGeometricTextureSynthesizer [Hertz2020]. Each triangle has 12 features: for each edge its length and the position
 * of the opposite corner of the neighbour across it, in a frame of that edge. Triangles on a boundary do not count,
 * unless all lie there. The distance is the sliced Wasserstein-1 distance ([Rabin2011], [Bonneel2015]) of the distributions
 * of these features: the mean, over directions in the space of the features, of the mean difference of equal quantiles
 * along the direction. Each triangle counts in the three cyclic orders of its edges.
 *
 * With NumberOfRings R above 1 each vertex has 6 R features: for each of the rings 1 to R around it the minimum, the
 * quartiles and the maximum of the heights of its vertices over the first vertex, and their mean tangential distance. Ring
 * j are the vertices that j edges and no fewer join to the vertex; heights are along the sum of the area vectors of the
 * neighborhood. Neighborhoods that a boundary cuts do not count, unless all are cut. Three and six rings see the height,
 * spacing and merging of features that one ring does not see.
 *
 * The distance is 0 for the same triangulated surface after a translation, a rotation and, without unit lengths, a
 * scaling. It increases with the difference in edge lengths, angles and dihedral angles. It depends on the
 * triangulation: compare surfaces that were triangulated in the same way, for instance level k of a synthesized texture
 * with level k of the reference, and, for scale, the target without texture at the same number of subdivisions.
 *
 * @par Input
 * Port 0: the surface. Port 1: the reference. Each is a vtkPolyData with triangles, polygons or strips; anything that
 * is not a triangle is triangulated. The meshes must have finite points, no degenerate triangle, no edge with more than
 * two triangles and consistent winding; the error message names the defective one and the filter that repairs it. A
 * composite dataset on port 0 is compared block by block: the output then has a table in the place of each block.
 *
 * @par Output
 * A vtkTable with one row and these columns, float64 unless said otherwise:
 * - Distance: in unit lengths, at least 0: low is good;
 * - StandardError: standard error of Distance as an estimate of the mean over all directions; two distances with the
 *   same Seed share their directions, so that their difference has a smaller error;
 * - MeanEdgeLength, ReferenceMeanEdgeLength: world units, each edge counts once;
 * - NumberOfTriangles, NumberOfReferenceTriangles (vtkIdType).
 * @par
 * Two empty inputs give an empty table; one is an error.
 *
 * @par Cost
 * O(P F log F) for one ring, P directions and F triangles of both surfaces: about 10 seconds on one thread for 128 directions and
 * 300,000 triangles. The same bits for every number of threads.
 *
 * @sa vtkGeometricTextureSynthesizer, vtkMultiscaleMeshFitter, vtkEnsembleMetrics
 */

#ifndef vtkGeometricTextureDistance_h
#define vtkGeometricTextureDistance_h

#include "vtkSurfaceSynthesisStatisticsModule.h" // For export macro
#include "vtkTableAlgorithm.h"

class VTKSURFACESYNTHESISSTATISTICS_EXPORT vtkGeometricTextureDistance : public vtkTableAlgorithm
{
public:
  static vtkGeometricTextureDistance* New();
  vtkTypeMacro(vtkGeometricTextureDistance, vtkTableAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * Divisor of lengths of the surface, world units, at least 0; 0 stands for its own mean edge length. A synthesized
   * texture has longer edges than its target. For the scale of the network, give the mean edge length of the target at
   * the first level, divided by 2^k after k subdivisions. Default 0.
   */
  vtkSetClampMacro(UnitLength, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(UnitLength, double);
  ///@}

  ///@{
  /**
   * Divisor of lengths of the reference, world units, at least 0; 0 stands for its own mean edge length. For the scale
   * of the network at level k of the training meshes, give the mean edge length of level 0 divided by 2^k. Default 0.
   */
  vtkSetClampMacro(ReferenceUnitLength, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(ReferenceUnitLength, double);
  ///@}

  ///@{
  /**
   * Number of random directions, from 1 to 1,000,000. The standard error is proportional to 1 /
   * sqrt(NumberOfProjections). Default 128.
   */
  vtkSetClampMacro(NumberOfProjections, int, 1, 1000000);
  vtkGetMacro(NumberOfProjections, int);
  ///@}

  ///@{
  /**
   * Number of rings of the neighborhoods, from 1 to 16. 1 compares the 12 features of triangles; 2 and more compare, for each
   * vertex, the heights and distances of the rings of vertices around it, which see the size and spacing of larger features.
   * Default 1.
   */
  vtkSetClampMacro(NumberOfRings, int, 1, 16);
  vtkGetMacro(NumberOfRings, int);
  ///@}

  ///@{
  /**
   * Seed of the directions, any integer. Default 0.
   */
  vtkSetMacro(Seed, int);
  vtkGetMacro(Seed, int);
  ///@}

  ///@{
  /**
   * Results of the last update, as in the table; 0 without an update.
   */
  double GetDistance() const { return this->Distance; }
  double GetStandardError() const { return this->StandardError; }
  ///@}

protected:
  vtkGeometricTextureDistance();
  ~vtkGeometricTextureDistance() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;

private:
  vtkGeometricTextureDistance(const vtkGeometricTextureDistance&) = delete;
  void operator=(const vtkGeometricTextureDistance&) = delete;

  double UnitLength = 0.0;
  double ReferenceUnitLength = 0.0;
  int NumberOfProjections = 128;
  int NumberOfRings = 1;
  int Seed = 0;
  double Distance = 0.0;
  double StandardError = 0.0;
};

#endif
