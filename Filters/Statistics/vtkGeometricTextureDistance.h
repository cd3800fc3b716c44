// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkGeometricTextureDistance
 * @brief   How alike the relief of two surfaces is, whatever their shape
 *
 * Tells how well a geometric texture has been learned and grown: compares what the triangles of a surface see of their
 * neighbours with what those of a reference see, which is all that the networks of vtkGeometricTextureSynthesizer and
 * its training know ("Deep Geometric Texture Synthesis", Hertz et al. 2020). Each triangle has 12 features: for each
 * edge its length and where the opposite corner of the neighbour beyond lies in a frame of that edge; beyond a boundary
 * lies the triangle itself. The distance is the sliced Wasserstein-1 distance (Rabin et al. 2011) of the distributions
 * of these features: the mean, over directions in the space of the features, of the mean difference of equal quantiles
 * along the direction. Each triangle counts in the three orders that its edges have around it.
 *
 * It is 0 for the same triangulated surface, moved, turned and, without unit lengths, scaled, and grows with the
 * difference in edge lengths, angles and dihedral angles. It sees the triangulation: compare surfaces whose triangles
 * were made in the same way, for instance the level k of a grown texture with the level k of the reference, beside the
 * bare target subdivided as often.
 *
 * @par Input
 * Port 0: the surface. Port 1: the reference. Each is a vtkPolyData with triangles, polygons or strips; anything that is
 * not a triangle is triangulated. The meshes must have finite points, no degenerate triangle, no edge with more than
 * two triangles and consistent winding; the error message says which of both is wrong and the filter that repairs it. A
 * composite dataset on port 0 is compared block by block: the output then has a table in the place of each block.
 *
 * @par Output
 * A vtkTable with one row and these columns, float64 unless said otherwise:
 * - Distance: in unit lengths, at least 0: low is good;
 * - StandardError: how far Distance may be from that over all directions, one standard deviation, because there are
 *   finitely many; two distances with the same Seed share their directions, and differ by less;
 * - MeanEdgeLength, ReferenceMeanEdgeLength: world units, each edge counts once;
 * - NumberOfTriangles, NumberOfReferenceTriangles (vtkIdType).
 * @par
 * Two empty inputs give an empty table; one is an error.
 *
 * @par Cost
 * O(P F log F) for P directions and F triangles of both surfaces: about 10 seconds on one thread for 128 directions and
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
   * What lengths of the surface are divided by, world units, at least 0; 0 stands for its own mean edge length. A grown
   * texture has longer edges than the bare target: to compare it as the network sees it, give the mean edge length of
   * the target as the texture begins on it, over 2^k for what is subdivided k times. Default 0.
   */
  vtkSetClampMacro(UnitLength, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(UnitLength, double);
  ///@}

  ///@{
  /**
   * What lengths of the reference are divided by, world units, at least 0; 0 stands for its own mean edge length. For
   * level k of the meshes that a texture was trained on, the network sees the mean edge length of level 0 over 2^k.
   * Default 0.
   */
  vtkSetClampMacro(ReferenceUnitLength, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(ReferenceUnitLength, double);
  ///@}

  ///@{
  /**
   * Number of random directions, from 1 to 1,000,000. The standard error falls with its square root. Default 128.
   */
  vtkSetClampMacro(NumberOfProjections, int, 1, 1000000);
  vtkGetMacro(NumberOfProjections, int);
  ///@}

  ///@{
  /**
   * The seed of the directions. Any integer. Default 0.
   */
  vtkSetMacro(Seed, int);
  vtkGetMacro(Seed, int);
  ///@}

  ///@{
  /**
   * The results of the last update, as in the table; 0 when there are none.
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
  int Seed = 0;
  double Distance = 0.0;
  double StandardError = 0.0;
};

#endif
