// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkEnsembleLayoutFilter
 * @brief   Lays the blocks of an ensemble out side by side, in a grid, a row or a column
 *
 * Moves the blocks of a composite dataset, which the filters that make ensembles leave in one place, next to each other:
 * the samples of vtkPoseEnsembleFilter and vtkFlowMatchingDeformer, the levels of vtkMultiscaleMeshFitter, or any other
 * blocks. Places follow from the bounds of the blocks and from Spacing.
 *
 * @par Input
 * A composite dataset (vtkMultiBlockDataSet, vtkPartitionedDataSetCollection, ...) of blocks with points (vtkPointSet) or
 * of images (vtkImageData). Blocks without points take no place. Empty input gives empty output.
 *
 * @par Output
 * The input with moved blocks: points of the same precision, or another origin of an image; cells and arrays are shared
 * with the input. The first block stays where it is; rows follow each other downwards. Each block gets the field array
 * "Translation", float64 with one tuple of three components, world units: subtract it to get the input back.
 *
 * @par Failure
 * An error and an empty output for a block of another class, or whose points are not finite. Blocks on several MPI ranks are
 * an error on all of them.
 *
 * @sa vtkPoseEnsembleFilter, vtkMultiscaleMeshFitter, vtkFlowMatchingDeformer
 */

#ifndef vtkEnsembleLayoutFilter_h
#define vtkEnsembleLayoutFilter_h

#include "vtkPassInputTypeAlgorithm.h"
#include "vtkSurfaceSynthesisEnsemblesModule.h" // For export macro

class VTKSURFACESYNTHESISENSEMBLES_EXPORT vtkEnsembleLayoutFilter : public vtkPassInputTypeAlgorithm
{
public:
  static vtkEnsembleLayoutFilter* New();
  vtkTypeMacro(vtkEnsembleLayoutFilter, vtkPassInputTypeAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// The shapes of the layout.
  enum Arrangements
  {
    GRID = 0,
    ROW = 1,
    COLUMN = 2
  };

  /// The planes of the layout: columns along the first axis, rows against the second.
  enum Planes
  {
    XY = 0,
    XZ = 1,
    YZ = 2
  };

  /// The parts of the dataset that are moved as one.
  enum Units
  {
    LEAVES = 0,  ///< each dataset by itself
    CHILDREN = 1 ///< the blocks directly below the root, with all that is in them
  };

  ///@{
  /**
   * Shape of the layout: GRID fills rows of NumberOfColumns blocks one after the other. Default GRID.
   */
  vtkSetClampMacro(Arrangement, int, GRID, COLUMN);
  vtkGetMacro(Arrangement, int);
  void SetArrangementToGrid() { this->SetArrangement(GRID); }
  void SetArrangementToRow() { this->SetArrangement(ROW); }
  void SetArrangementToColumn() { this->SetArrangement(COLUMN); }
  ///@}

  ///@{
  /**
   * Number of blocks in a row of a GRID, at least 0; 0 chooses it so that the whole is near 16 : 10, with few
   * empty places. Default 0.
   */
  vtkSetClampMacro(NumberOfColumns, int, 0, VTK_INT_MAX);
  vtkGetMacro(NumberOfColumns, int);
  ///@}

  ///@{
  /**
   * Gap between two blocks, as a fraction of the largest block's size along the axis; at least 0. Default 0.1.
   */
  vtkSetClampMacro(Spacing, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(Spacing, double);
  ///@}

  ///@{
  /**
   * Plane of the layout: columns along its first axis, rows against its second. Default XY.
   */
  vtkSetClampMacro(Plane, int, XY, YZ);
  vtkGetMacro(Plane, int);
  void SetPlaneToXY() { this->SetPlane(XY); }
  void SetPlaneToXZ() { this->SetPlane(XZ); }
  void SetPlaneToYZ() { this->SetPlane(YZ); }
  ///@}

  ///@{
  /**
   * Parts that are moved as one: LEAVES are single datasets; CHILDREN are the blocks directly below the root, each with all
   * that is in it. Default LEAVES.
   */
  vtkSetClampMacro(Unit, int, LEAVES, CHILDREN);
  vtkGetMacro(Unit, int);
  void SetUnitToLeaves() { this->SetUnit(LEAVES); }
  void SetUnitToChildren() { this->SetUnit(CHILDREN); }
  ///@}

  ///@{
  /**
   * Centering of each block in its cell. Off, each block is moved by the distance of its cell from the first one: differences
   * of position between the blocks stay, and all cells are of one size. Default on.
   */
  vtkSetMacro(Centering, bool);
  vtkGetMacro(Centering, bool);
  vtkBooleanMacro(Centering, bool);
  ///@}

protected:
  vtkEnsembleLayoutFilter() = default;
  ~vtkEnsembleLayoutFilter() override = default;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestDataObject(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;

private:
  vtkEnsembleLayoutFilter(const vtkEnsembleLayoutFilter&) = delete;
  void operator=(const vtkEnsembleLayoutFilter&) = delete;

  int Arrangement = GRID;
  int NumberOfColumns = 0;
  double Spacing = 0.1;
  int Plane = XY;
  int Unit = LEAVES;
  bool Centering = true;
};

#endif
