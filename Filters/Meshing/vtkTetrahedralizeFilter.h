// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkTetrahedralizeFilter
 * @brief   Fills closed surfaces with tetrahedra of bounded shape and size, by TetGen in a process of its own
 *
 * Computes a constrained Delaunay tetrahedralisation and refines it to given bounds of the shape and size of tetrahedra
 * [Si2015]. TetGen 1.5 (AGPL-3) is linked only by the program surfacesynthesis-tetgen, which this filter starts for
 * each surface: a crash, an endless loop or a shortage of memory in it is one error of this filter, and never the end
 * of the application.
 *
 * @par Input
 * vtkPolyData with triangles, polygons or strips, float or double points, or a composite dataset of such blocks. The
 * surface must have finite points, no degenerate triangle, two triangles at every edge (so that it is closed), and no
 * self-intersection; the error message names the defect, the first offending cell or point and the filter that repairs
 * it. It may have several parts, beside and inside each other. The winding of cells does not matter. Vertices and
 * lines are ignored. Empty input gives empty output; a block that cannot be processed is reported and left empty.
 *
 * @par Output
 * vtkUnstructuredGrid of VTK_TETRA cells of positive volume, or a composite dataset of them. Points are stored in
 * double precision: first the points that the surface uses, in their order and with their coordinates, then new ones.
 * - Cell array Region (int; RegionArrayName): the number of the part of the surface that directly encloses the
 *   tetrahedron, parts being numbered in the order of their first cells. Two parts that touch in a point count as two.
 * - Point array OnSurface (unsigned char; SurfaceArrayName): 1 on the surface, new points on it included, else 0.
 * - The point arrays of the surface: unchanged on its points; on new points of the surface interpolated on the triangle
 *   they lie on; inside, interpolated at the nearest place of the surface. Interpolated are floating-point numbers,
 *   normals then scaled to unit length; integers and text, which are labels, come from the nearest corner. Global and
 *   pedigree ids and ghost flags are left out.
 * - With SurfaceTriangles, also a VTK_TRIANGLE cell for each triangle of the surface, after the tetrahedra, with the
 *   cell arrays of the surface. On tetrahedra these arrays hold zeros (or empty text). The Region of a triangle is the
 *   number of its part. Without SurfaceTriangles the cell arrays of the surface are dropped.
 * - Field data is that of the input.
 *
 * @par Bounds
 * TetGen refines the mesh to the bounds of shape and size. It does not meet them near sharp edges of the surface and,
 * with PreserveSurface, at the surface. The last step, which removes flat tetrahedra, may exceed them by up to about a
 * quarter.
 *
 * @par Several parts
 * Parts inside others are either boundaries between regions, or the walls of cavities: see InnerSurfaces. Surfaces with
 * more than one part are meshed twice, first without bounds, to compute the nesting of the parts.
 *
 * @par Cost
 * About a second for 10,000 triangles, and as much again for each 30,000 tetrahedra, on one thread. The same input
 * gives the same bits.
 *
 * @par The program
 * The filter starts surfacesynthesis-tetgen in the folder of its own library, or the program that the environment
 * variable SURFACE_SYNTHESIS_TETGEN names.
 *
 * @sa vtkTopologyReport, vtkSurfaceRepairFilter, vtkVDBSurfaceFilter, vtkDelaunay3D
 */

#ifndef vtkTetrahedralizeFilter_h
#define vtkTetrahedralizeFilter_h

#include "vtkDataObjectAlgorithm.h"
#include "vtkSurfaceSynthesisMeshingModule.h" // For export macro

#include <memory> // For std::unique_ptr
#include <string> // For std::string

class VTKSURFACESYNTHESISMESHING_EXPORT vtkTetrahedralizeFilter : public vtkDataObjectAlgorithm
{
public:
  static vtkTetrahedralizeFilter* New();
  vtkTypeMacro(vtkTetrahedralizeFilter, vtkDataObjectAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// Treatments of closed surfaces inside others.
  enum InnerSurfaceModes
  {
    REGIONS = 0, ///< fill everything enclosed, with a number of Region for each part
    HOLES = 1    ///< leave the inside of every second nested surface empty
  };

  ///@{
  /**
   * Largest ratio of a tetrahedron's circumradius to its shortest edge, without unit; 0 for no bound, else at least 1.
   * Smaller values give better shaped and more tetrahedra: 2, the default, is always reached away from sharp corners,
   * 1.2 usually; the regular tetrahedron has 0.61. With PreserveSurface, tetrahedra at the surface may exceed it.
   */
  vtkSetClampMacro(QualityRatio, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(QualityRatio, double);
  ///@}

  ///@{
  /**
   * Target for the smallest angle between two faces of a tetrahedron, degrees, from 0 (no bound, the default) to 60.
   * Values up to about 18 are usually reached; with larger ones TetGen may not terminate.
   */
  vtkSetClampMacro(MinimumDihedralAngle, double, 0.0, 60.0);
  vtkGetMacro(MinimumDihedralAngle, double);
  ///@}

  ///@{
  /**
   * Largest volume of a tetrahedron, cubic world units; 0, the default, for no bound. With PreserveSurface, tetrahedra
   * at the surface may exceed it.
   */
  vtkSetClampMacro(MaximumVolume, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(MaximumVolume, double);
  ///@}

  ///@{
  /**
   * Bound of the volume by a length L in world units: no tetrahedron is larger than the regular one with edges of this
   * length, whose volume is L^3 / (6 sqrt(2)); 0, the default, for no bound. The stricter of this and MaximumVolume
   * holds.
   */
  vtkSetClampMacro(TargetEdgeLength, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(TargetEdgeLength, double);
  ///@}

  ///@{
  /**
   * Limit of the tetrahedra of the output, or of each block, at least 4. A MaximumVolume or TargetEdgeLength by which
   * more are expected (1.25 times the enclosed volume over the bound, twice with a surface that is split) is an error
   * before the work begins; the message names a bound that fits. Default 10,000,000.
   */
  vtkSetClampMacro(MaximumNumberOfTetrahedra, int, 4, VTK_INT_MAX);
  vtkGetMacro(MaximumNumberOfTetrahedra, int);
  ///@}

  ///@{
  /**
   * Keeps the surface, without new points, as the boundary of the tetrahedra, so that its arrays are exact and its
   * triangles remain. Off, edges and triangles of the surface are split where the bounds require it; the shape stays
   * the same. Default on.
   */
  vtkSetMacro(PreserveSurface, bool);
  vtkGetMacro(PreserveSurface, bool);
  vtkBooleanMacro(PreserveSurface, bool);
  ///@}

  ///@{
  /**
   * Treatment of closed surfaces inside others. REGIONS (the default) fills everything that is enclosed, with a number
   * in the array Region for each part; HOLES leaves the inside of a surface inside another one empty, and fills that of
   * one inside that again.
   */
  vtkSetClampMacro(InnerSurfaces, int, REGIONS, HOLES);
  vtkGetMacro(InnerSurfaces, int);
  void SetInnerSurfacesToRegions() { this->SetInnerSurfaces(REGIONS); }
  void SetInnerSurfacesToHoles() { this->SetInnerSurfaces(HOLES); }
  ///@}

  ///@{
  /**
   * Adds the triangles of the surface, with its cell arrays, to the cells of the output. Default off.
   */
  vtkSetMacro(SurfaceTriangles, bool);
  vtkGetMacro(SurfaceTriangles, bool);
  vtkBooleanMacro(SurfaceTriangles, bool);
  ///@}

  ///@{
  /**
   * Time limit of TetGen for one surface (for each of two runs, with several parts), in seconds, at least 0; beyond it,
   * TetGen is stopped and an error is reported. 0 for no limit. Default 300.
   */
  vtkSetClampMacro(TimeLimit, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(TimeLimit, double);
  ///@}

  ///@{
  /**
   * Memory limit of TetGen, MiB, at least 0; 0, the default, for three quarters of the memory of the machine. TetGen
   * uses about 2 KiB for each tetrahedron.
   */
  vtkSetClampMacro(MemoryLimit, int, 0, VTK_INT_MAX);
  vtkGetMacro(MemoryLimit, int);
  ///@}

  ///@{
  /**
   * Name of the cell array with the region numbers; not empty. Default "Region".
   */
  void SetRegionArrayName(const char* name);
  vtkGetCharFromStdStringMacro(RegionArrayName);
  ///@}

  ///@{
  /**
   * Name of the point array that marks points on the surface; not empty. Default "OnSurface".
   */
  void SetSurfaceArrayName(const char* name);
  vtkGetCharFromStdStringMacro(SurfaceArrayName);
  ///@}

protected:
  vtkTetrahedralizeFilter();
  ~vtkTetrahedralizeFilter() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestDataObject(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;

private:
  vtkTetrahedralizeFilter(const vtkTetrahedralizeFilter&) = delete;
  void operator=(const vtkTetrahedralizeFilter&) = delete;

  double QualityRatio = 2.0;
  double MinimumDihedralAngle = 0.0;
  double MaximumVolume = 0.0;
  double TargetEdgeLength = 0.0;
  int MaximumNumberOfTetrahedra = 10000000;
  bool PreserveSurface = true;
  int InnerSurfaces = REGIONS;
  bool SurfaceTriangles = false;
  double TimeLimit = 300.0;
  int MemoryLimit = 0;
  std::string RegionArrayName = "Region";
  std::string SurfaceArrayName = "OnSurface";

  class Internals;
  std::unique_ptr<Internals> Impl;
};

#endif
