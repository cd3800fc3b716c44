// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkTextureAtlasFilter
 * @brief   Texture coordinates for a surface without: charts of little stretch, packed into one image
 *
 * Divides a surface into charts by variational shape approximation [CohenSteiner2004], flattens them by least squares
 * conformal maps [Levy2002], divides those further that overlap themselves or stretch too much, and packs them into an
 * image. No two triangles overlap in the texture; all charts have the same mean texel density.
 *
 * @par Input
 * vtkPolyData with triangles, polygons or strips, float or double points, open or closed, of any genus and number of
 * components; or a composite dataset of such blocks, each of which gets an atlas of its own: a block that cannot be
 * processed is reported and left empty. The mesh must have finite points, no degenerate triangle, manifold edges and
 * points, and consistent winding; the error message names the defect, and vtkSurfaceRepairFilter repairs it. Polygons
 * are triangulated for the computation. Points of equal coordinates count as one where the surface stays manifold then,
 * so that seams of other point arrays are no borders of charts. Empty input gives empty output.
 *
 * @par Output
 * A vtkPolyData with the points of the input in their order, followed by copies of points at which charts meet: one for
 * each of their texture coordinates. All point and cell arrays are copied, but for global ids and ghost arrays. Polygons
 * stay what they are where all of their triangles lie in one chart; a polygon that the border of a chart crosses becomes
 * its triangles, as do strips, and each has the cell arrays of the cell that it comes from. Cells stay in order. Added:
 *  - point array `TCoords` (two components, double; the active texture coordinates): u and v from 0 to 1, (0, 0) at the
 *    lower left corner of the image. Points without polygons have (0, 0).
 *  - point array `OriginalPoint` (vtkIdType): id of the point of the input.
 *  - cell array `Chart` (int): number of the chart, in order of the first cell of each; -1 on vertices and lines.
 *  - field arrays of one value (double): `NumberOfCharts`, `Coverage`, `RootMeanStretch`, `LargestStretch`,
 *    `TexelsPerLength`; see the methods Get...().
 *
 * @par Cost
 * About five seconds for 100,000 triangles. The result does not depend on the number of threads.
 *
 * @sa vtkSurfaceRepairFilter, vtkIsotropicRemeshFilter, vtkTextureMapToPlane
 */

#ifndef vtkTextureAtlasFilter_h
#define vtkTextureAtlasFilter_h

#include "vtkDataObjectAlgorithm.h"
#include "vtkSurfaceSynthesisMeshingModule.h" // For export macro

class VTKSURFACESYNTHESISMESHING_EXPORT vtkTextureAtlasFilter : public vtkDataObjectAlgorithm
{
public:
  static vtkTextureAtlasFilter* New();
  vtkTypeMacro(vtkTextureAtlasFilter, vtkDataObjectAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * Width and height of the image that the charts are packed for, in texels, each from 16 to 32768. Images of the same
   * aspect ratio and other sizes can be used with the coordinates, with margins in proportion. Default 1024 x 1024.
   */
  void SetResolution(int width, int height);
  void SetResolution(const int size[2]) { this->SetResolution(size[0], size[1]); }
  vtkGetVector2Macro(Resolution, int);
  ///@}

  ///@{
  /**
   * Least distance of two charts, in texels, from 1 to 256; half of it is left at the sides of the image. Bilinear
   * interpolation needs 3, each level of a mipmap twice as many. Default 4.
   */
  vtkSetClampMacro(Margin, int, 1, 256);
  vtkGetMacro(Margin, int);
  ///@}

  ///@{
  /**
   * Largest stretch of a triangle, from 1.01 to 100: lengths on the surface are at most this many times, and at least
   * this fraction of, those in the texture, relative to their mean over the chart. A smaller number makes more charts.
   * Default 2.
   */
  vtkSetClampMacro(MaximumStretch, double, 1.01, 100.0);
  vtkGetMacro(MaximumStretch, double);
  ///@}

  /**
   * Number of charts of the last update, for the last block of a composite input.
   */
  vtkTypeInt64 GetNumberOfCharts() const { return this->NumberOfCharts; }

  /**
   * Part of the image that triangles cover, from 0 to 1, for the last block of a composite input.
   */
  double GetCoverage() const { return this->Coverage; }

  /**
   * Root of the mean over the surface of (S^2 + s^2) / 2 [Sander2001]; 1 without distortion. S is the largest and s the
   * smallest ratio, in a triangle, of a length on the surface to its length in the texture, relative to the mean density.
   * For the last block of a composite input.
   */
  double GetRootMeanStretch() const { return this->RootMeanStretch; }

  /**
   * Largest of all S and 1 / s; at least 1. For the last block of a composite input.
   */
  double GetLargestStretch() const { return this->LargestStretch; }

  /**
   * Mean texel density, texels / world unit, for the last block of a composite input.
   */
  double GetTexelsPerLength() const { return this->TexelsPerLength; }

protected:
  vtkTextureAtlasFilter();
  ~vtkTextureAtlasFilter() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestDataObject(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;

private:
  vtkTextureAtlasFilter(const vtkTextureAtlasFilter&) = delete;
  void operator=(const vtkTextureAtlasFilter&) = delete;

  class Internals;

  int Resolution[2] = { 1024, 1024 };
  int Margin = 4;
  double MaximumStretch = 2.0;
  vtkTypeInt64 NumberOfCharts = 0;
  double Coverage = 0.0;
  double RootMeanStretch = 1.0;
  double LargestStretch = 1.0;
  double TexelsPerLength = 0.0;
};

#endif
