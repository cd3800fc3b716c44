// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkSurfaceRepairFilter
 * @brief   Makes a valid, manifold surface of a broken one, and says what it did
 *
 * Repairs every defect that the check of the other filters names: cells that name points which do not exist, NaN and
 * infinite coordinates, points used twice, triangles without area, duplicate triangles, edges with more than two
 * triangles, points where several fans of triangles touch, inconsistent winding, holes, and several components. By
 * CGAL's polygon mesh processing.
 *
 * @par Input
 * Any vtkPolyData with polygons or strips, however broken, or a composite dataset of such blocks, processed block by
 * block. Vertices and lines are ignored. Empty input gives empty output. An error is given only when no valid triangle
 * is left, or a defect cannot be removed; vtkVDBSurfaceFilter then makes a closed surface of the same triangles.
 *
 * @par Output
 * A vtkPolyData of triangles with manifold edges and points and consistent winding, in the precision of the input's
 * points. Points keep their place, but for those where sheets were taken apart, which move by a hundredth of an edge so
 * that they stay apart; as long as none is merged, they keep their order. Unused points are left out. Point
 * arrays are carried over (interpolated on new points: floating-point arrays linearly, labels from the nearest point),
 * cell arrays come from the nearest cell. Added: the cell array FilledHole, unsigned char, 1 for triangles that close a
 * hole; the field data arrays RepairAction (text) and RepairCount, one entry for each thing that was done, in order;
 * both are empty when the surface was valid.
 *
 * @par Order
 * Cells that cannot be used go; points are merged; duplicate triangles go; sheets that meet in an edge or a point are
 * taken apart; triangles are wound like the larger part of their neighbours; flat triangles are collapsed or flipped
 * away; self-intersections go, when asked; holes are closed; components go, when asked; a closed surface is turned to
 * face outward.
 *
 * @sa vtkTopologyReport, vtkIsotropicRemeshFilter, vtkVDBSurfaceFilter, vtkCleanPolyData, vtkFillHolesFilter
 */

#ifndef vtkSurfaceRepairFilter_h
#define vtkSurfaceRepairFilter_h

#include "vtkDataObjectAlgorithm.h"
#include "vtkSurfaceSynthesisMeshingModule.h" // For export macro

#include <string> // For std::string

class VTKSURFACESYNTHESISMESHING_EXPORT vtkSurfaceRepairFilter : public vtkDataObjectAlgorithm
{
public:
  static vtkSurfaceRepairFilter* New();
  vtkTypeMacro(vtkSurfaceRepairFilter, vtkDataObjectAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// Which holes are closed.
  enum HoleFillingModes
  {
    NO_HOLES = 0,    ///< none: boundaries stay
    SMALL_HOLES = 1, ///< those up to MaximumHoleSize
    ALL_HOLES = 2    ///< all: the output is closed
  };

  ///@{
  /**
   * Whether points within MergeTolerance of each other become one, as for surfaces stored triangle by triangle. Off
   * keeps seams of point arrays, such as texture coordinates, apart. Default on.
   */
  vtkSetMacro(MergePoints, bool);
  vtkGetMacro(MergePoints, bool);
  vtkBooleanMacro(MergePoints, bool);
  ///@}

  ///@{
  /**
   * The distance up to which points are merged, in world units; at least 0. Default 0: equal coordinates only.
   */
  vtkSetClampMacro(MergeTolerance, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(MergeTolerance, double);
  ///@}

  ///@{
  /**
   * Which holes are closed, by triangles of the size of those around that continue the surface's curvature. Default
   * SMALL_HOLES.
   */
  vtkSetClampMacro(HoleFilling, int, NO_HOLES, ALL_HOLES);
  vtkGetMacro(HoleFilling, int);
  void SetHoleFillingToNone() { this->SetHoleFilling(NO_HOLES); }
  void SetHoleFillingToSmall() { this->SetHoleFilling(SMALL_HOLES); }
  void SetHoleFillingToAll() { this->SetHoleFilling(ALL_HOLES); }
  ///@}

  ///@{
  /**
   * The largest hole that SMALL_HOLES closes: the diagonal of the bounding box of its edge, in world units; at least 0.
   * The outline of a small flat piece is no hole: SMALL_HOLES leaves a boundary whose piece of surface lies within its
   * bounding box.
   * 0 (the default) stands for a tenth of the diagonal of the surface's own bounding box.
   */
  vtkSetClampMacro(MaximumHoleSize, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(MaximumHoleSize, double);
  ///@}

  ///@{
  /**
   * Whether only the connected component of the largest area stays. Default off.
   */
  vtkSetMacro(KeepLargestComponent, bool);
  vtkGetMacro(KeepLargestComponent, bool);
  vtkBooleanMacro(KeepLargestComponent, bool);
  ///@}

  ///@{
  /**
   * Components with less than this fraction of the largest one's area go; without unit, from 0 to 1. Default 0: all stay.
   */
  vtkSetClampMacro(MinimumComponentFraction, double, 0.0, 1.0);
  vtkGetMacro(MinimumComponentFraction, double);
  ///@}

  ///@{
  /**
   * Whether triangles that cross each other are replaced by patches that do not, as far as possible; slow on large
   * crossings. What remains is counted in the report. Default off.
   */
  vtkSetMacro(RemoveSelfIntersections, bool);
  vtkGetMacro(RemoveSelfIntersections, bool);
  vtkBooleanMacro(RemoveSelfIntersections, bool);
  ///@}

  ///@{
  /**
   * Whether a closed surface is turned so that its normals point out of what it encloses (into the cavity, where a
   * component lies inside another). Open surfaces keep the winding that most of their area has. Default on.
   */
  vtkSetMacro(OrientOutward, bool);
  vtkGetMacro(OrientOutward, bool);
  vtkBooleanMacro(OrientOutward, bool);
  ///@}

  /**
   * What the last update did, a line for each thing, "12: duplicate triangles removed"; empty when there was nothing to
   * do. For a composite input the lines of all blocks, each after the name of its block.
   */
  const char* GetReport() const { return this->Report.c_str(); }

protected:
  vtkSurfaceRepairFilter();
  ~vtkSurfaceRepairFilter() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestDataObject(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;

private:
  vtkSurfaceRepairFilter(const vtkSurfaceRepairFilter&) = delete;
  void operator=(const vtkSurfaceRepairFilter&) = delete;

  class Internals;

  bool MergePoints = true;
  double MergeTolerance = 0.0;
  int HoleFilling = SMALL_HOLES;
  double MaximumHoleSize = 0.0;
  bool KeepLargestComponent = false;
  double MinimumComponentFraction = 0.0;
  bool RemoveSelfIntersections = false;
  bool OrientOutward = true;
  std::string Report;
};

#endif
