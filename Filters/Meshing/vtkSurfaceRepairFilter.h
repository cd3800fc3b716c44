// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkSurfaceRepairFilter
 * @brief   Repairs a surface: makes it valid and manifold, and reports each repair
 *
 * Repairs every defect that the check of the other filters names: cells with point ids out of range, NaN and infinite
 * coordinates, points used twice, triangles without area, duplicate triangles, edges with more than two triangles,
 * points where several fans of triangles touch, inconsistent winding, holes, and several components. By CGAL's polygon
 * mesh processing.
 *
 * @par Input
 * Any vtkPolyData with polygons or strips, however broken, or a composite dataset of such blocks, processed block by
 * block. Vertices and lines are ignored. Empty input gives empty output. An error is given only when no valid triangle
 * is left, or a defect cannot be removed; vtkVDBSurfaceFilter then makes a closed surface of the same triangles.
 *
 * @par Output
 * A vtkPolyData of triangles with manifold edges and points and consistent winding, in the precision of the input's
 * points. Points keep their position, except where sheets were separated: these move by a hundredth of an edge (with a
 * MergeTolerance by one and a half of it, up to a quarter of an edge), so that
 * the sheets remain separate. Without merged points, the order of points is kept. Unused points are left out. Point
 * arrays are kept (interpolated on new points: floating-point arrays linearly, labels from the nearest point), cell
 * arrays come from the nearest cell. Added: the cell array FilledHole, unsigned char, 1 for triangles that close a
 * hole; the field data arrays RepairAction (text) and RepairCount, one entry for each repair, in order; both are empty
 * when the surface was valid; the field data arrays RepairMeasure (text), RepairBefore and RepairAfter (float64) with
 * Area, Volume (when closed before and after), Components, and IntersectingTriangles with RemoveSelfIntersections.
 *
 * @par Order
 * Unusable cells are removed; points are merged; duplicate triangles are removed; sheets that meet in an edge or a
 * point are separated; triangles get the winding of the larger part of their neighbours; flat triangles are collapsed
 * or flipped; self-intersections are removed, with RemoveSelfIntersections; holes are filled [Liepa2003]; components
 * are removed, with KeepLargestComponent or MinimumComponentFraction; a closed surface is oriented outward. These steps
 * are repeated until they change nothing: a repair of the output returns it as it is. (A MergeTolerance of more than a
 * tenth of the edges may merge points that the repair separated or added within that tolerance.)
 *
 * @par Warnings
 * A warning, or with Strict an error, says in numbers what is left and what was lost: triangles that still intersect
 * others, holes that could not be closed, and a loss of area or volume or a change of the number of components beyond
 * MaximumLoss. Triangles that close holes do not make up for lost area, and components that are removed on request are
 * no loss. GetComplete() and the methods beside it return the same numbers.
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

  /// Choices of the holes to fill.
  enum HoleFillingModes
  {
    NO_HOLES = 0,    ///< none: boundaries are kept
    SMALL_HOLES = 1, ///< holes up to MaximumHoleSize
    ALL_HOLES = 2    ///< all holes, except the outlines of flat pieces
  };

  ///@{
  /**
   * Merges points within MergeTolerance of each other, as a triangle soup requires. Off keeps seams of point arrays,
   * such as texture coordinates. Default on.
   */
  vtkSetMacro(MergePoints, bool);
  vtkGetMacro(MergePoints, bool);
  vtkBooleanMacro(MergePoints, bool);
  ///@}

  ///@{
  /**
   * Largest distance of points that are merged, in world units; at least 0. Default 0: equal coordinates only.
   */
  vtkSetClampMacro(MergeTolerance, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(MergeTolerance, double);
  ///@}

  ///@{
  /**
   * Choice of the holes to fill, with triangles of the size of their neighbours that continue the curvature of the
   * surface. Default SMALL_HOLES.
   */
  vtkSetClampMacro(HoleFilling, int, NO_HOLES, ALL_HOLES);
  vtkGetMacro(HoleFilling, int);
  void SetHoleFillingToNone() { this->SetHoleFilling(NO_HOLES); }
  void SetHoleFillingToSmall() { this->SetHoleFilling(SMALL_HOLES); }
  void SetHoleFillingToAll() { this->SetHoleFilling(ALL_HOLES); }
  ///@}

  ///@{
  /**
   * Largest hole that SMALL_HOLES fills: the diagonal of the bounding box of its edge, in world units; at least 0. The
   * outline of a small flat piece is no hole: SMALL_HOLES keeps a boundary whose component lies within its bounding
   * box. 0 (the default) stands for a tenth of the diagonal of the surface's own bounding box.
   */
  vtkSetClampMacro(MaximumHoleSize, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(MaximumHoleSize, double);
  ///@}

  ///@{
  /**
   * Keeps only the connected component of the largest area. Default off.
   */
  vtkSetMacro(KeepLargestComponent, bool);
  vtkGetMacro(KeepLargestComponent, bool);
  vtkBooleanMacro(KeepLargestComponent, bool);
  ///@}

  ///@{
  /**
   * Smallest area of a component that is kept, as a fraction of that of the largest one, from 0 to 1. Default 0: all
   * components are kept.
   */
  vtkSetClampMacro(MinimumComponentFraction, double, 0.0, 1.0);
  vtkGetMacro(MinimumComponentFraction, double);
  ///@}

  ///@{
  /**
   * Replaces triangles that intersect each other by patches without intersections, and closes holes only by triangles
   * that intersect no others; slow on large intersections. A removal that would lose more than MaximumLoss, beside
   * the area of the intersecting triangles, is refused, and so is one where more than half of the triangles intersect
   * others; a warning counts those that are left. Default off.
   */
  vtkSetMacro(RemoveSelfIntersections, bool);
  vtkGetMacro(RemoveSelfIntersections, bool);
  vtkBooleanMacro(RemoveSelfIntersections, bool);
  ///@}

  ///@{
  /**
   * Orients a closed surface so that its normals point out of the enclosed volume (into the cavity, for a component
   * inside another one). Open surfaces keep the winding of most of their area. Default on.
   */
  vtkSetMacro(OrientOutward, bool);
  vtkGetMacro(OrientOutward, bool);
  vtkBooleanMacro(OrientOutward, bool);
  ///@}

  ///@{
  /**
   * Largest fraction of the area, of the volume or of the number of components that a repair may lose (or, of
   * components, gain) without a warning; from 0 to 1. Default 0.05.
   */
  vtkSetClampMacro(MaximumLoss, double, 0.0, 1.0);
  vtkGetMacro(MaximumLoss, double);
  ///@}

  ///@{
  /**
   * Selection of the cell array FilledHole as the active scalars of an output with filled holes, which viewers color by; no
   * point array is active then. Off, the active scalars of the input stay. Default off.
   */
  vtkSetMacro(ActiveResult, bool);
  vtkGetMacro(ActiveResult, bool);
  vtkBooleanMacro(ActiveResult, bool);
  ///@}

  ///@{
  /**
   * Reports an error, with empty output, in place of each warning about defects that are left and losses beyond
   * MaximumLoss. Default off.
   */
  vtkSetMacro(Strict, bool);
  vtkGetMacro(Strict, bool);
  vtkBooleanMacro(Strict, bool);
  ///@}

  /**
   * Returns true when the last update left nothing and no loss exceeds MaximumLoss.
   */
  bool GetComplete() const { return this->Complete; }

  /**
   * Number of triangles that still intersect others after the last update, of all blocks; 0 without
   * RemoveSelfIntersections.
   */
  vtkTypeInt64 GetNumberOfIntersectingTriangles() const { return this->NumberOfIntersectingTriangles; }

  /**
   * Number of holes that were to be closed and are open after the last update, of all blocks.
   */
  vtkTypeInt64 GetNumberOfOpenHoles() const { return this->NumberOfOpenHoles; }

  /**
   * Largest fraction of its area that a block lost in the last update, from 0 to 1.
   */
  double GetAreaLoss() const { return this->AreaLoss; }

  /**
   * Largest fraction of its volume that a block lost in the last update, from 0 to 1; surfaces closed before and
   * after count.
   */
  double GetVolumeLoss() const { return this->VolumeLoss; }

  /**
   * Largest change of the number of components of a block in the last update, as a fraction of the number before.
   */
  double GetComponentChange() const { return this->ComponentChange; }

  /**
   * Repairs of the last update, one line each, such as "12: duplicate triangles removed"; empty without repairs. For a
   * composite input, the lines of all blocks, each after the name of its block.
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
  double MaximumLoss = 0.05;
  bool Strict = false;
  bool ActiveResult = false;
  bool Complete = false;
  vtkTypeInt64 NumberOfIntersectingTriangles = 0;
  vtkTypeInt64 NumberOfOpenHoles = 0;
  double AreaLoss = 0.0;
  double VolumeLoss = 0.0;
  double ComponentChange = 0.0;
  std::string Report;
};

#endif
