// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkFlowMatchingDeformer
 * @brief   Generates random deformations of surfaces with a trained flow matching model
 *
 * Generates poses, shapes or deformations of a surface like those that a model was trained on: vtkFlowMatchingSampler
 * with the positions of the points as the signal ([Kuai2026], sections 4, 5.1 and 5.2). Works on any triangulation of
 * the training shape. vtkFlowMatchingSampler documents the model file, the input, flow time and cost.
 *
 * @par Input
 * As for vtkFlowMatchingSampler. A model of a signal other than positions is an error.
 *
 * @par Output
 * The input with its points moved (the precision of their coordinates stays; see MovePoints), its own cells and arrays,
 * and
 *  - the point array DisplacementArrayName, float64, 3 components: the deformed minus the input position, in world
 *    units. The centroid of the surface, weighted by the area of the input, stays where it is: positions are generated
 *    up to a translation (a model with another than a gradient-domain head may move it);
 *  - the point array InitialNoiseArrayName, float64, 3 components: the noise that the deformation starts from, about 0,
 *    in world units: at flow time 0 the points lie at the centroid of the input plus the initial noise;
 *  - the cell array AreaRatioArrayName, float64: the area of each polygon or strip after the deformation over that in
 *    the input, at the flow time of the output; 1 for vertices and lines.
 *
 * Points that no polygon or strip uses stay where they are, with a displacement and initial noise of 0. Normals, which
 * are those of the old surface, are dropped when points are moved: the active ones and arrays named "Normals".
 *
 * For several samples the output is a vtkMultiBlockDataSet with a block for each, as for vtkFlowMatchingSampler.
 *
 * @sa vtkFlowMatchingSampler, vtkPolyDataNormals, vtkWarpVector
 */

#ifndef vtkFlowMatchingDeformer_h
#define vtkFlowMatchingDeformer_h

#include "vtkFlowMatchingSampler.h"
#include "vtkSurfaceSynthesisFlowMatchingModule.h" // For export macro

#include <string>  // For std::string
#include <utility> // For std::pair
#include <vector>  // For std::vector

class VTKSURFACESYNTHESISFLOWMATCHING_EXPORT vtkFlowMatchingDeformer : public vtkFlowMatchingSampler
{
public:
  static vtkFlowMatchingDeformer* New();
  vtkTypeMacro(vtkFlowMatchingDeformer, vtkFlowMatchingSampler);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * Moves the points of the output; off, the deformation is in the arrays only. Default on.
   */
  vtkSetMacro(MovePoints, bool);
  vtkGetMacro(MovePoints, bool);
  vtkBooleanMacro(MovePoints, bool);
  ///@}

  ///@{
  /**
   * Name of the point array with the displacement of each point; not empty. Default "Displacement".
   */
  void SetDisplacementArrayName(const char* name);
  vtkGetCharFromStdStringMacro(DisplacementArrayName);
  ///@}

  ///@{
  /**
   * Name of the cell array with the ratio of the area of each polygon to that in the input; not empty. Default
   * "AreaRatio".
   */
  void SetAreaRatioArrayName(const char* name);
  vtkGetCharFromStdStringMacro(AreaRatioArrayName);
  ///@}

protected:
  vtkFlowMatchingDeformer();
  ~vtkFlowMatchingDeformer() override;

  bool GeneratesDisplacements() const override { return true; }
  std::string GeneratedArrayName() override;
  std::vector<std::pair<std::string, std::string>> OutputArrayNames() override;
  void AddSample(vtkPolyData* output, vtkDoubleArray* displacement, vtkDoubleArray* noise) override;

private:
  vtkFlowMatchingDeformer(const vtkFlowMatchingDeformer&) = delete;
  void operator=(const vtkFlowMatchingDeformer&) = delete;

  bool MovePoints = true;
  std::string DisplacementArrayName = "Displacement";
  std::string AreaRatioArrayName = "AreaRatio";
};

#endif
