// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkLabelSurfaceFilter
 * @brief   Makes a named surface of each label of a label map
 *
 * Surfaces of the regions of an atlas or a segmentation: one network of borders between all labels ([Gibson1998], for many
 * labels as in [Frisken2022]) is smoothed by the low-pass filter of [Taubin1995], and then moved along its normals until
 * each label has the volume of its samples again. Touching labels share the points and triangles of their border.
 *
 * @par Input
 * A vtkImageData with labels, an array of one component with integer values of 32 bits (of any type), at its points or
 * cells; any origin, spacing and orthogonal direction. SetInputArrayToProcess() chooses the array (default: the active
 * scalars of the points). Label 0 is the background, and so is all outside the image.
 *
 * @par Output
 * A vtkMultiBlockDataSet with a vtkPolyData for each label, in ascending order of labels: a closed surface, manifold in edges
 * and points, wound outwards, in world units. The name of a block is that of the label, or "Label 5". Each has the cell
 * array Label (int, active scalars), and the field arrays Label (int), LabelName (string) and SampleVolume (float64: number
 * of samples times the volume of one, cubic world units). Empty input and labels that are all 0 give an empty output.
 *
 * @par Failure
 * An error and an empty output for values that are no labels, labels that are asked for and not there, a table of names
 * that cannot be read, and volumes that the correction does not reach. Gray values of a scan are no labels: more than 32
 * labels, where less than 40 percent of adjacent samples have the same one. A choice of labels is taken as it is.
 *
 * @sa vtkVDBSurfaceFilter, vtkSurfaceRepairFilter, vtkTetrahedralizeFilter
 */

#ifndef vtkLabelSurfaceFilter_h
#define vtkLabelSurfaceFilter_h

#include "vtkMultiBlockDataSetAlgorithm.h"
#include "vtkSurfaceSynthesisMeshingModule.h" // For export macro

#include <map>    // For std::map
#include <memory> // For std::unique_ptr
#include <string> // For std::string
#include <vector> // For std::vector

class VTKSURFACESYNTHESISMESHING_EXPORT vtkLabelSurfaceFilter : public vtkMultiBlockDataSetAlgorithm
{
public:
  static vtkLabelSurfaceFilter* New();
  vtkTypeMacro(vtkLabelSurfaceFilter, vtkMultiBlockDataSetAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * Text file with the names of the labels: a line for each, with its number and its name, as in the tables of MRIcron,
   * FreeSurfer and ITK-SNAP. Empty (the default) for none.
   */
  void SetNamesFileName(const char* name);
  vtkGetCharFromStdStringMacro(NamesFileName);
  ///@}

  ///@{
  /**
   * Name of a label, in place of that of the file. An empty name removes it. GetLabelName() returns an empty name where none
   * is set. Default none.
   */
  void SetLabelName(int label, const char* name);
  std::string GetLabelName(int label) const;
  ///@}

  ///@{
  /**
   * Labels of which surfaces are made, other than 0; the others become background. SetNumberOfLabels() clamps to 0 and more
   * and fills up with 1; SetLabel() does nothing for an index out of range, and GetLabel() returns 0. Default none: all,
   * which may be 4096 at most.
   */
  void SetNumberOfLabels(int number);
  int GetNumberOfLabels() const { return static_cast<int>(this->Labels.size()); }
  void SetLabel(int index, int label);
  int GetLabel(int index) const;
  ///@}

  ///@{
  /**
   * Number of steps of smoothing, from 0 to 1000; 0 leaves the steps of the samples. Default 30.
   */
  vtkSetClampMacro(SmoothingIterations, int, 0, 1000);
  vtkGetMacro(SmoothingIterations, int);
  ///@}

  ///@{
  /**
   * Moves the borders along their normals after smoothing until the volume of each label is that of its samples, to 0.01
   * percent. Default on.
   */
  vtkSetMacro(PreserveVolume, bool);
  vtkGetMacro(PreserveVolume, bool);
  vtkBooleanMacro(PreserveVolume, bool);
  ///@}

  ///@{
  /**
   * Gives touching labels the same points and triangles in their border. Off, each label is smoothed by itself, as if the
   * others were background: gaps and overlaps are below the size of a sample. Default on.
   */
  vtkSetMacro(SharedBorders, bool);
  vtkGetMacro(SharedBorders, bool);
  vtkBooleanMacro(SharedBorders, bool);
  ///@}

protected:
  vtkLabelSurfaceFilter();
  ~vtkLabelSurfaceFilter() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;

private:
  vtkLabelSurfaceFilter(const vtkLabelSurfaceFilter&) = delete;
  void operator=(const vtkLabelSurfaceFilter&) = delete;

  std::string NamesFileName;
  std::map<int, std::string> LabelNames;
  std::vector<int> Labels;
  int SmoothingIterations = 30;
  bool PreserveVolume = true;
  bool SharedBorders = true;

  class Internals;
  std::unique_ptr<Internals> Impl;
};

#endif
