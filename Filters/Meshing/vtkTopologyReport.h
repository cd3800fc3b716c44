// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkTopologyReport
 * @brief   What a surface is like and everything that is wrong with it, as a table
 *
 * What to run first on data of unknown quality: the report counts every kind of defect that makes other filters refuse a
 * surface, names the first cell or point of each and the filter that repairs it, and describes topology, size and the
 * shape of the triangles. A bad mesh is never an error here: broken cells are left out and the rest is measured.
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
 * - First (vtkIdType): the first cell or point that the row is about, -1 for none;
 * - Remark (string): what repairs a defect, units, explanations.
 *
 * @par Properties
 * Valid: 1 for finite points, triangles with an area and at most two triangles at an edge, which filters without further
 * requirements accept.
 * @par
 * Defects, with a row even when there are none: UnreadableCells, CellsWithMissingPoints, CellsWithTooFewPoints,
 * BrokenVerticesAndLines, CellsWithRepeatedPoints, UncuttablePolygons, DegenerateTriangles and DuplicateTriangles (First
 * is a cell); NonFinitePoints, NonManifoldEdges, NonManifoldPoints, InconsistentWindingEdges, BoundaryEdges,
 * CoincidentPoints, UnreferencedPoints and SmallComponents (First is a point). An open surface has boundary edges and need
 * not be wrong.
 * @par
 * Counts: Points, UsedPoints, VertexCells, LineCells, TriangleCells, QuadCells, PolygonCells, StripCells, Triangles (into
 * which polygons and strips are cut), Edges.
 * @par
 * Topology: Components, EulerCharacteristic (points - edges + triangles), Genus, BoundaryLoops, LongestBoundaryLoop (world
 * units; First is a point on it), Closed, Manifold, Orientable, ConsistentWinding.
 * @par
 * Size: Area (square world units), Volume (cubic world units, below zero where the surface is wound inwards), XMinimum to
 * ZMaximum.
 * @par
 * Shape: EdgeLengthMinimum, EdgeLengthMean, EdgeLengthMedian, EdgeLengthMaximum (world units; First is the lower point of
 * the edge), AngleMinimum, AngleMaximum, AngleMeanMinimum (degrees; First is a cell), AspectRatioMean, AspectRatioMaximum
 * (longest edge times perimeter over 4 sqrt(3) areas: 1 for an equilateral triangle).
 * @par
 * A property that the surface does not have has no row: Genus of what is not an orientable manifold, Volume of what is
 * not closed as well, angles where no triangle has an area.
 *
 * @par Cost
 * About a second for a million triangles. The same bits for every number of threads.
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
   * In a surface of several components, how many of them get rows of their own, those with most triangles first; at
   * least 0. Default 10.
   */
  vtkSetClampMacro(NumberOfComponentRows, int, 0, VTK_INT_MAX);
  vtkGetMacro(NumberOfComponentRows, int);
  ///@}

  ///@{
  /**
   * A value of the last update: of the whole surface @p block (a flat index; 0, the default, for a vtkPolyData by itself),
   * or of one of its components. HasValue() tells whether there is such a row; where there is none, GetValue() returns 0.
   * "Sound", the former name of Valid, is deprecated and still answers.
   */
  bool HasValue(const char* property, unsigned int block = 0, int component = -1) const;
  double GetValue(const char* property, unsigned int block = 0, int component = -1) const;
  ///@}

  /**
   * True when every surface of the last update is valid (see Valid above); false when there was none.
   */
  bool GetValid() const;

  /**
   * The former name of GetValid().
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
