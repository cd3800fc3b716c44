// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkTopologyReport
 * @brief   Computes a table of the topology, size, shape and defects of a surface
 *
 * Inspects data of unknown quality: counts every kind of defect that makes other filters refuse a surface, names the
 * first cell or point of each and the filter that repairs it, and describes topology, size and the shape of the
 * triangles. A defective mesh is never an error here: broken cells are left out and the rest is measured.
 *
 * @par Input
 * vtkPolyData with any cells, however broken, or a composite dataset of such blocks. Empty input gives an empty table.
 *
 * @par Output
 * A vtkTable with a row for each property and these columns:
 * - Block (int): the flat index of the block, 0 for a vtkPolyData by itself;
 * - Component (int): -1 for the whole surface, else the number of a connected component, in order of lowest point ids;
 * - Property (string): see below;
 * - Value (float64): always finite; 1 and 0 for yes and no;
 * - First (vtkIdType): the first cell or point that the row refers to, -1 for none;
 * - Remark (string): the repair of a defect, units, explanations.
 *
 * @par Properties
 * Valid: 1 when vtkIsotropicRemeshFilter accepts the surface and, where it is closed, vtkTetrahedralizeFilter: finite
 * points, triangles with an area and without duplicates, manifold edges and points, consistent winding, no
 * intersecting triangles. Other filters need less.
 * @par
 * Defects, with a row even when there are none: UnreadableCells, CellsWithMissingPoints, CellsWithTooFewPoints,
 * BrokenVerticesAndLines, CellsWithRepeatedPoints, UncuttablePolygons, DegenerateTriangles, DuplicateTriangles,
 * NeedleTriangles (with an angle below 1 degree) and IntersectingTriangles (that meet others in more than shared points
 * and edges; points of equal coordinates count as one; only where the library is built with CGAL) (First is a cell); NonFinitePoints, NonManifoldEdges, NonManifoldPoints, InconsistentWindingEdges, BoundaryEdges,
 * CoincidentPoints, UnreferencedPoints and SmallComponents (First is a point). An open surface has boundary edges and
 * need not be wrong, nor are needles.
 * @par
 * Counts: Points, UsedPoints, VertexCells, LineCells, TriangleCells, QuadCells, PolygonCells, StripCells, Triangles
 * (into which polygons and strips are cut), Edges.
 * @par
 * Topology: Components, EulerCharacteristic (points - edges + triangles), Genus, BoundaryLoops, LongestBoundaryLoop
 * (world units; First is a point on it), Closed, Manifold, Orientable, ConsistentWinding.
 * @par
 * Size: Area (square world units), Volume (cubic world units, below zero where the surface is wound inwards), XMinimum
 * to ZMaximum.
 * @par
 * Shape: EdgeLengthMinimum, EdgeLengthMean, EdgeLengthMedian, EdgeLengthMaximum (world units; First is the lower point
 * of the edge), AngleMinimum, AngleMaximum, AngleMeanMinimum (degrees; First is a cell), AspectRatioMean,
 * AspectRatioMaximum (longest edge times perimeter over 4 sqrt(3) areas: 1 for an equilateral triangle).
 * @par
 * A property that the surface does not have has no row: Genus exists for orientable manifolds only, Volume for closed
 * ones only, angles for triangles with an area only.
 *
 * @par Cost
 * Some seconds for a million triangles. The same bits for every number of threads.
 *
 * @sa vtkSurfaceRepairFilter, vtkFeatureEdges, vtkCleanPolyData, vtkMassProperties
 */

#ifndef vtkTopologyReport_h
#define vtkTopologyReport_h

#include "vtkDeprecation.h"                   // For VTK_DEPRECATION
#include "vtkSurfaceSynthesisMeshingModule.h" // For export macro
#include "vtkTableAlgorithm.h"

#include <memory> // For std::unique_ptr

class VTKSURFACESYNTHESISMESHING_EXPORT vtkTopologyReport : public vtkTableAlgorithm
{
public:
  static vtkTopologyReport* New();
  vtkTypeMacro(vtkTopologyReport, vtkTableAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * Number of components that have rows of their own, in a surface of several components, those with most triangles
   * first; at least 0. Default 10.
   */
  vtkSetClampMacro(NumberOfComponentRows, int, 0, VTK_INT_MAX);
  vtkGetMacro(NumberOfComponentRows, int);
  ///@}

  ///@{
  /**
   * Returns a value of the last update, @p property of the table: of the whole surface @p block (a flat index; 0, the
   * default, for a vtkPolyData by itself), or of its component @p component. HasValue() returns true when there is such
   * a row; without one GetValue() returns 0. "Sound", the former name of Valid, is deprecated and still works.
   */
  bool HasValue(const char* property, unsigned int block = 0, int component = -1) const;
  double GetValue(const char* property, unsigned int block = 0, int component = -1) const;
  ///@}

  /**
   * Returns true when every surface of the last update is valid (see Valid above); false without a surface.
   */
  bool GetValid() const;

  /**
   * Former name of GetValid().
   */
  VTK_DEPRECATION("Use GetValid()")
  bool GetSound() const { return this->GetValid(); }

protected:
  vtkTopologyReport();
  ~vtkTopologyReport() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;

private:
  vtkTopologyReport(const vtkTopologyReport&) = delete;
  void operator=(const vtkTopologyReport&) = delete;

  int NumberOfComponentRows = 10;

  class Internals;
  std::unique_ptr<Internals> Impl;
};

#endif
