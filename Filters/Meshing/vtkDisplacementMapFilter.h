// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkDisplacementMapFilter
 * @brief   Bakes the difference of a plain and a detailed surface into a displacement map and a height map
 *
 * Makes images, in the texture atlas of a plain surface, of its distance to a detailed version of it near by: a surface from
 * vtkGeometricTextureSynthesizer and its target, or a scan and its reduction. Renderers that subdivide the plain surface and
 * move its points by the images show the detailed one.
 *
 * @par Input
 * Port 0: the plain surface, a vtkPolyData with triangles, polygons or strips and active texture coordinates at its points
 * (vtkTextureAtlasFilter makes some): finite, within [0, 1] by 1e-4. Finite points, no degenerate triangle; open and
 * non-manifold surfaces are allowed. Points at the same coordinates count as one for normals, so that seams do not show. A
 * warning names cells that overlap in the texture, which share their texels, and cells without area there.
 * @par
 * Port 1: the detailed surface, a vtkPolyData with triangles, polygons or strips and finite points.
 *
 * @par Output
 * A vtkImageData of Resolution, row 0 at v = 0, with the point arrays
 *  - `Height` (float; the active scalars): distance along the interpolated normal of the plain surface, negative inwards, to
 *    the nearest place, either side up to MaximumDistance, of the detailed surface that faces the same way; world units.
 *    Where there is none, the component along the normal of the vector to the closest place. An overhang has one height.
 *  - `Displacement` (float, 3 components): vector to the detailed surface in axes of VectorSpace, world units. Where that is
 *    the plain one, subdivided at midpoints any number of times with points moved, as vtkGeometricTextureSynthesizer makes it,
 *    the vector goes to the same place there and follows overhangs; otherwise to the place of the height.
 *  - `Coverage` (unsigned char): 255 where the center of a texel lies in a triangle, else 0.
 * @par
 * Texels outside of all triangles, up to GutterWidth, show the nearest place of the surface; others are 0. Field arrays
 * of one value: `SubdivisionLevels` (int) and `CoveredTexels`, `Misses`, `MeanMiss`, `LargestMiss`, `HeightMidlevel`,
 * `HeightScale` (double); see the methods Get...().
 * @par
 * Two empty inputs give an empty output; one is an error.
 *
 * @par Conventions
 * Normals are area-weighted means at vertices, interpolated. Tangents are those of MikkTSpace [Mikkelsen2008], as Blender and
 * most renderers make them, but for orthogonalization at each texel. Vectors in tangent space have the components tangent,
 * normal, bitangent: the order of Blender's node Vector Displacement and of Mudbox. Object space has the axes of the points.
 * An image in integers stores (Height / HeightScale + HeightMidlevel), from 0 to 1, for nodes that compute
 * (value - midlevel) scale.
 *
 * @par Cost
 * Linear in the texels of triangles: about 5 us each. The same bits for every number of threads.
 *
 * @sa vtkTextureAtlasFilter, vtkGeometricTextureSynthesizer, vtkSurfaceDistance
 */

#ifndef vtkDisplacementMapFilter_h
#define vtkDisplacementMapFilter_h

#include "vtkImageAlgorithm.h"
#include "vtkSurfaceSynthesisMeshingModule.h" // For export macro

#include <memory> // For std::unique_ptr

class VTKSURFACESYNTHESISMESHING_EXPORT vtkDisplacementMapFilter : public vtkImageAlgorithm
{
public:
  static vtkDisplacementMapFilter* New();
  vtkTypeMacro(vtkDisplacementMapFilter, vtkImageAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// Axes of Displacement.
  enum VectorSpaceType
  {
    OBJECT = 0, ///< x, y and z of the points
    TANGENT = 1 ///< tangent, normal and bitangent of the surface
  };

  /// Places of the detailed surface to which Displacement goes.
  enum CorrespondenceType
  {
    AUTOMATIC = 0, ///< the same places where the detailed surface is a subdivision of the plain one, else along normals
    NORMALS = 1    ///< along normals
  };

  ///@{
  /**
   * Detailed surface of port 1.
   */
  void SetDetailedConnection(vtkAlgorithmOutput* output) { this->SetInputConnection(1, output); }
  void SetDetailedData(vtkDataObject* detailed) { this->SetInputDataObject(1, detailed); }
  ///@}

  ///@{
  /**
   * Width and height of the images, texels, 16 to 16384 each. Default 1024 x 1024.
   */
  void SetResolution(int width, int height);
  void SetResolution(const int size[2]) { this->SetResolution(size[0], size[1]); }
  vtkGetVector2Macro(Resolution, int);
  ///@}

  ///@{
  /**
   * Distance from the charts up to which texels outside are filled, texels, -1 to 16384: 0 for those of bilinear
   * interpolation only, 2^k for k further levels of a mipmap, -1 for the whole image. Default 8.
   */
  vtkSetClampMacro(GutterWidth, int, -1, 16384);
  vtkGetMacro(GutterWidth, int);
  ///@}

  ///@{
  /**
   * Axes of Displacement: OBJECT, x, y and z of the points, for surfaces that stay as they are; TANGENT, the tangent, normal
   * and bitangent of the surface, which follow it when it is posed. Default OBJECT.
   */
  vtkSetClampMacro(VectorSpace, int, OBJECT, TANGENT);
  vtkGetMacro(VectorSpace, int);
  void SetVectorSpaceToObject() { this->SetVectorSpace(OBJECT); }
  void SetVectorSpaceToTangent() { this->SetVectorSpace(TANGENT); }
  ///@}

  ///@{
  /**
   * Places of the detailed surface to which Displacement goes: AUTOMATIC, the same places where it is a subdivision of the
   * plain one at midpoints, else NORMALS, along the normals. Default AUTOMATIC.
   */
  vtkSetClampMacro(Correspondence, int, AUTOMATIC, NORMALS);
  vtkGetMacro(Correspondence, int);
  void SetCorrespondenceToAutomatic() { this->SetCorrespondence(AUTOMATIC); }
  void SetCorrespondenceToNormals() { this->SetCorrespondence(NORMALS); }
  ///@}

  ///@{
  /**
   * Largest distance along the normal, either side, at which the detailed surface is looked for, world units, at least 0; 0,
   * the default, for a tenth of the diagonal of the plain surface's box.
   */
  vtkSetClampMacro(MaximumDistance, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(MaximumDistance, double);
  ///@}

  /**
   * Number of subdivisions by which Displacement of the last update goes to the same places; -1 where it goes along normals.
   */
  vtkTypeInt64 GetSubdivisionLevels() const;

  /**
   * Number of texels of the last update whose centers lie in triangles.
   */
  vtkTypeInt64 GetCoveredTexels() const;

  /**
   * Number of these texels whose normals meet nothing, so that Height is that of the closest place.
   */
  vtkTypeInt64 GetMisses() const;

  /**
   * Mean distance from the end of such a height to the closest place, world units; 0 without misses.
   */
  double GetMeanMiss() const;

  /**
   * Largest of these distances, world units; 0 without misses.
   */
  double GetLargestMiss() const;

  /**
   * Value that stands for height 0 in an image in integers, from 0 to 1: 0 where no height is negative.
   */
  double GetHeightMidlevel() const;

  /**
   * Difference of the heights that 1 and 0 stand for in an image in integers, world units: the range of the heights and 0; 1
   * where all heights are 0.
   */
  double GetHeightScale() const;

protected:
  vtkDisplacementMapFilter();
  ~vtkDisplacementMapFilter() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestInformation(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int RequestUpdateExtent(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;

private:
  vtkDisplacementMapFilter(const vtkDisplacementMapFilter&) = delete;
  void operator=(const vtkDisplacementMapFilter&) = delete;

  int Resolution[2] = { 1024, 1024 };
  int GutterWidth = 8;
  int VectorSpace = OBJECT;
  int Correspondence = AUTOMATIC;
  double MaximumDistance = 0.0;

  class Internals;
  std::unique_ptr<Internals> Impl;
};

#endif
