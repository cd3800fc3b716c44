// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkSkinningFilter
 * @brief   Poses a body by the bones of a skeleton: linear blend and dual quaternion skinning
 *
 * Moves each point of a body with the bones that influence it, by the weights of an artist or of a body model. LINEAR_BLEND
 * takes the weighted mean of the places to which the bones carry the point [Lewis2000]; where bones turn far against each
 * other, it shrinks: a limb that is twisted by half a turn collapses like the wrapper of a candy. DUAL_QUATERNION blends
 * the rigid motions themselves as unit dual quaternions [Kavan2008] and keeps the radius.
 *
 * @par Input
 * Port 0: vtkPointSet, the body at rest: a surface, a volume or points, with float or double points; or a composite dataset of
 * such blocks, each of which is posed by the same bones. Its points have the weights in one of two forms:
 *  - the point arrays BoneIndexArrayName, integers, the numbers of K bones, and BoneWeightArrayName, K components, their
 *    weights, as JOINTS_0 and WEIGHTS_0 of glTF;
 *  - with an empty BoneIndexArrayName, BoneWeightArrayName with a component for each bone.
 * @par
 * Weights are at least 0 and sum up to 1 at each point, to 0.01; they are divided by their sum. Negative weights, other sums,
 * unknown bones and numbers that are not finite are an error that counts the points and names the first.
 * @par
 * Port 1: vtkTable, the bones, one in each row. Columns: Head, 3 components, the joint at which the bone turns, world units;
 * Parent, an integer, the row of the bone that carries it, -1 for none; Name, text, optional. Columns "Head:0", "Head:1" and
 * "Head:2", as tables in files have them, stand for one with 3 components. Other columns, such as Tail, are ignored.
 * @par
 * Port 2: vtkTable, the pose. Columns: Rotation, 4 components, a quaternion w, x, y, z of any length but 0, the rotation of the
 * bone about its head, relative to its parent, in the axes of the body at rest; Translation, 3 components, optional, the
 * displacement of the head from where the parent carries it, world units; Name, text, optional. With names in both tables a row
 * is for the bone of its name, and bones without a row keep their rotation to the parent; without names it has a row for each
 * bone.
 *
 * @par Output
 * The body with moved points of the same precision, with its cells and arrays; without normals, which are those of the body at
 * rest: the active ones and arrays named "Normals". Empty input gives empty output.
 *
 * @par Cost
 * Proportional to points times influences; points are moved in parallel.
 *
 * @sa vtkPoseEnsembleFilter, vtkWeightedTransformFilter, vtkWarpVector
 */

#ifndef vtkSkinningFilter_h
#define vtkSkinningFilter_h

#include "vtkPassInputTypeAlgorithm.h"
#include "vtkSurfaceSynthesisEnsemblesModule.h" // For export macro

#include <string> // For std::string

class vtkAlgorithmOutput;
class vtkTable;

class VTKSURFACESYNTHESISENSEMBLES_EXPORT vtkSkinningFilter : public vtkPassInputTypeAlgorithm
{
public:
  static vtkSkinningFilter* New();
  vtkTypeMacro(vtkSkinningFilter, vtkPassInputTypeAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// Blending of the motions of bones.
  enum SkinningMethods
  {
    LINEAR_BLEND = 0,   ///< weighted mean of moved points
    DUAL_QUATERNION = 1 ///< weighted mean of unit dual quaternions
  };

  ///@{
  /**
   * Blending of the motions of bones. Default DUAL_QUATERNION.
   */
  vtkSetClampMacro(SkinningMethod, int, LINEAR_BLEND, DUAL_QUATERNION);
  vtkGetMacro(SkinningMethod, int);
  void SetSkinningMethodToLinearBlend() { this->SetSkinningMethod(LINEAR_BLEND); }
  void SetSkinningMethodToDualQuaternion() { this->SetSkinningMethod(DUAL_QUATERNION); }
  ///@}

  ///@{
  /**
   * Name of the point array with the numbers of the bones of each point. Empty: BoneWeightArrayName has a component for each
   * bone. Default "BoneIndices".
   */
  void SetBoneIndexArrayName(const char* name);
  vtkGetCharFromStdStringMacro(BoneIndexArrayName);
  ///@}

  ///@{
  /**
   * Name of the point array with the weights of the bones of each point; not empty. Default "BoneWeights".
   */
  void SetBoneWeightArrayName(const char* name);
  vtkGetCharFromStdStringMacro(BoneWeightArrayName);
  ///@}

  ///@{
  /**
   * Sets the bones of port 1, as a connection or as data.
   */
  void SetBonesConnection(vtkAlgorithmOutput* port);
  void SetBonesData(vtkTable* bones);
  ///@}

  ///@{
  /**
   * Sets the pose of port 2, as a connection or as data.
   */
  void SetPoseConnection(vtkAlgorithmOutput* port);
  void SetPoseData(vtkTable* pose);
  ///@}

protected:
  vtkSkinningFilter();
  ~vtkSkinningFilter() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;

private:
  vtkSkinningFilter(const vtkSkinningFilter&) = delete;
  void operator=(const vtkSkinningFilter&) = delete;

  int SkinningMethod = DUAL_QUATERNION;
  std::string BoneIndexArrayName = "BoneIndices";
  std::string BoneWeightArrayName = "BoneWeights";
};

#endif
