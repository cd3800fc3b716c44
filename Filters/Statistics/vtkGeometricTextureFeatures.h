// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkGeometricTextureFeatures
 * @brief   Counts and measures the peaks, merged peaks, walls and self-intersections of a geometric texture
 *
 * A census of what the eye sees in the relief of a surface: how many peaks there are in an area, how high they are and how much
 * that varies, which of them have merged, how long the walls of a labyrinth are, and how often the surface intersects itself.
 * Two samples of one texture agree in these numbers, whatever the shapes of their surfaces are.
 *
 * The height of a point is its signed displacement along the normal of a bare surface beneath: that on port 1, or the
 * surface itself without its relief, smoothed over SmoothingLength. A peak is a local maximum of the height whose topological
 * prominence [Edelsbrunner2002], its height over the highest saddle that leads to a higher peak, is larger than
 * MinimumProminence. Heights of peaks and saddles count from the base level, which 5 percent of the area do not exceed.
 *
 * @par Input
 * Port 0: the surface, a vtkPolyData with triangles, polygons or strips; anything that is not a triangle is triangulated.
 * Port 1, optional: the bare surface with the same cells and as many points. The meshes must have finite points, no degenerate
 * triangle, no edge with more than two triangles and consistent winding; the error message names the defective one and the
 * filter that repairs it.
 *
 * @par Output
 * Port 0: the surface with
 * - Height (point array, float64, 1 component, active scalars): world units, outwards positive;
 * - Prominence (point array, float64): prominence of the peak at this point, world units; 0 elsewhere;
 * - Peak (point array, int): 1 at a peak, 2 at a merged one, 0 elsewhere;
 * - Region (point array, vtkIdType): number of the peak, in the order of point ids, that the steepest way upwards leads to;
 *   -1 where there is none;
 * - SelfIntersections (cell array, int): number of triangles that those of the cell intersect; only in builds with CGAL.
 * @par
 * Port 1: a vtkTable with one row and these columns, float64 unless said otherwise:
 * - NumberOfPeaks, NumberOfMergedPeaks (vtkIdType);
 * - PeakDensity: peaks in a square world unit of the bare surface; RelativePeakDensity: in a square of UnitLength;
 * - MeanPeakHeight: world units; PeakHeightVariation: standard deviation of the heights of peaks over their mean;
 * - MergedShare: share of the peaks that have merged with a neighbor, from 0 to 1;
 * - WallLength: half the length of the isoline, world units; WallDensity: that over the area, 1 / world units;
 *   RelativeWallDensity: WallDensity times the unit length; WallHeight: height of the isoline, world units;
 * - NumberOfSelfIntersections (vtkIdType): pairs of triangles that intersect in more than points and edges that both share;
 *   -1 in builds without CGAL;
 * - Area of the bare surface, HeightDeviation (standard deviation of the heights), BaseLevel, and the UnitLength and
 *   MinimumProminence that were used.
 * @par
 * Empty input gives empty outputs.
 *
 * @par Cost
 * O(V log V) for V points, and without a bare surface a sparse factorization. The same bits for every number of threads.
 *
 * @sa vtkGeometricTextureDistance, vtkGeometricTextureSynthesizer, vtkTopologyReport
 */

#ifndef vtkGeometricTextureFeatures_h
#define vtkGeometricTextureFeatures_h

#include "vtkPolyDataAlgorithm.h"
#include "vtkSurfaceSynthesisStatisticsModule.h" // For export macro

#include <memory> // For std::unique_ptr

class VTKSURFACESYNTHESISSTATISTICS_EXPORT vtkGeometricTextureFeatures : public vtkPolyDataAlgorithm
{
public:
  static vtkGeometricTextureFeatures* New();
  vtkTypeMacro(vtkGeometricTextureFeatures, vtkPolyDataAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * Unit of length of the relative densities, world units, at least 0; 0 stands for the mean edge length of the bare surface. A
   * synthesized texture is as large as the triangles of its target, so that the relative densities of two of its samples agree.
   * Default 0.
   */
  vtkSetClampMacro(UnitLength, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(UnitLength, double);
  ///@}

  ///@{
  /**
   * Smallest prominence of a peak, world units, at least 0; 0 stands for half the standard deviation of the heights, weighted by
   * area. That follows the scale of the surface and of the relief: it is a tenth to a quarter of the height of features that
   * fill a tenth to three quarters of the area. To compare two surfaces, give both the same. Default 0.
   */
  vtkSetClampMacro(MinimumProminence, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(MinimumProminence, double);
  ///@}

  ///@{
  /**
   * Height of the saddle between two neighboring peaks above which both count as merged, as a fraction of the height of the lower
   * one, from 0 to 1. Default 0.5.
   */
  vtkSetClampMacro(MergedSaddle, double, 0.0, 1.0);
  vtkGetMacro(MergedSaddle, double);
  ///@}

  ///@{
  /**
   * Level of the isoline whose length is that of the walls, above 0 to 1: 0 is the height that 5 percent of the area do not
   * exceed, 1 that which 95 percent do not exceed; 0 itself stands for the mean height. Default 0.
   */
  vtkSetClampMacro(WallLevel, double, 0.0, 1.0);
  vtkGetMacro(WallLevel, double);
  ///@}

  ///@{
  /**
   * Length over which the surface is smoothed where there is no bare surface, world units, at least 0; 0 stands for a tenth of
   * the root of the area. Relief of shorter waves is measured, longer waves are shape. Default 0.
   */
  vtkSetClampMacro(SmoothingLength, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(SmoothingLength, double);
  ///@}

  ///@{
  /**
   * Results of the last update, as in the table; 0 without an update.
   */
  vtkTypeInt64 GetNumberOfPeaks() const;
  double GetPeakDensity() const;
  double GetRelativePeakDensity() const;
  double GetMeanPeakHeight() const;
  double GetPeakHeightVariation() const;
  vtkTypeInt64 GetNumberOfMergedPeaks() const;
  double GetMergedShare() const;
  double GetWallLength() const;
  double GetWallDensity() const;
  double GetRelativeWallDensity() const;
  vtkTypeInt64 GetNumberOfSelfIntersections() const;
  ///@}

protected:
  vtkGeometricTextureFeatures();
  ~vtkGeometricTextureFeatures() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int FillOutputPortInformation(int port, vtkInformation* info) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;

private:
  vtkGeometricTextureFeatures(const vtkGeometricTextureFeatures&) = delete;
  void operator=(const vtkGeometricTextureFeatures&) = delete;

  double UnitLength = 0.0;
  double MinimumProminence = 0.0;
  double MergedSaddle = 0.5;
  double WallLevel = 0.0;
  double SmoothingLength = 0.0;

  class Internals;
  std::unique_ptr<Internals> Impl;
};

#endif
