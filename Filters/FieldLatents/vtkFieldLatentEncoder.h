// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkFieldLatentEncoder
 * @brief   Encodes the texture of a surface as field latents: tangent vectors at its points
 *
 * Field latents are the latent codes of a variational autoencoder whose latent space is a set of tangent vectors at each
 * vertex ([Mitchel2024], section 4). The encoder samples the colors in the one-ring of each vertex and computes latents from
 * them; vtkFieldLatentDecoder makes a texture of latents, on this surface or, after interpolation, on another
 * triangulation or in another atlas. Latents turn with the surface, do not depend on its scale or position, on the order
 * of points and cells or on bending without stretching.
 *
 * @par Model file
 * safetensors with the metadata `architecture` ("field_latents"), as the training of field latents writes it. Files are
 * checked before use; a damaged file, or one without such a model, is an error that names the cause. A file is read
 * once, and again in an update after its size or time of modification has changed.
 *
 * @par Input
 * Port 0: vtkPolyData with triangles, polygons or strips, float or double points, open or closed, any number of
 * components; or a composite dataset of such blocks, processed block by block: a block that cannot be processed is
 * reported and left empty. Polygons and strips are triangulated for the computation only. Points with the same
 * coordinates, as at seams of texture coordinates, are one vertex: latents have no seam. The mesh must have finite
 * points, no degenerate triangle and, once points are joined, manifold edges and points and consistent winding; the
 * error message names the defect, the first offending cell or point and the filter that repairs it. Empty input gives
 * empty output.
 *
 * Port 1, optional: a vtkImageData of one slice, the texture; row 0 is at v = 0. Its active point scalars have 1
 * component (gray), 2 (gray and alpha), 3 (RGB) or 4 (RGBA) of any type: integers from 0 to the largest number of their
 * type, floating-point numbers from 0 to 1. Values outside are clamped, alpha is left out, both with a warning. The
 * surface then needs active texture coordinates at its points (vtkTextureAtlasFilter makes some), with finite values
 * at all points that polygons use; the texture is interpolated bilinearly.
 *
 * Without an image the colors are those of the point array ColorArrayName, of the same types, interpolated linearly in
 * triangles.
 *
 * @par Output
 * The input, untouched, plus point arrays, float32, for d the dimension of the model and <name> LatentArrayName:
 *  - <name>_0 to <name>_<d - 1>, 3 components: tangent vectors of the mean of the latent code in world axes, no unit;
 *  - <name>Deviation, d components: standard deviation of the components of each tangent vector, no unit, at most
 *    exp(80);
 *  - <name>Radius, 1 component: radius of the one-ring as a disk, sqrt(area / pi), world units.
 *
 * All are 0 at points that no polygon or strip uses. They belong to the position and scale of the surface: a filter that
 * moves it afterwards has to turn all vectors (vtkTransformPolyDataFilter with TransformAllInputVectors), and to multiply
 * <name>Radius by the factor of a scaling, which vectors must not have. vtkFieldLatentDecoder warns where it finds that
 * this was not done. It is simpler to encode the surface in its place.
 *
 * @par Cost
 * Linear in the number of points times the samples of a ring; memory beside input and output does not grow with the
 * samples. One-rings are computed once for each mesh and kept until it changes. The same bits for every number of
 * threads. Another kind of processor may give other last bits: Reproducibility in README.md.
 *
 * @sa vtkFieldLatentDecoder, vtkSurfaceRepairFilter
 */

#ifndef vtkFieldLatentEncoder_h
#define vtkFieldLatentEncoder_h

#include "vtkDataObjectAlgorithm.h"
#include "vtkSurfaceSynthesisFieldLatentsModule.h" // For export macro

#include <memory> // For std::unique_ptr
#include <string> // For std::string

class vtkStringArray;

class VTKSURFACESYNTHESISFIELDLATENTS_EXPORT vtkFieldLatentEncoder : public vtkDataObjectAlgorithm
{
public:
  static vtkFieldLatentEncoder* New();
  vtkTypeMacro(vtkFieldLatentEncoder, vtkDataObjectAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// Continuations of the texture image outside [0, 1] x [0, 1].
  enum TextureWraps
  {
    AUTOMATIC = 0, ///< REPEAT for texture coordinates outside [0, 1], else CLAMP
    REPEAT = 1,    ///< periodic
    CLAMP = 2      ///< the outermost texels
  };

  ///@{
  /**
   * Path of the model file, or name of an installed model (GetInstalledModels()). Must be set. Default "".
   */
  void SetModelFileName(const char* name);
  vtkGetCharFromStdStringMacro(ModelFileName);
  ///@}

  /**
   * Names of the installed models that suit this filter.
   */
  vtkStringArray* GetInstalledModels();

  /**
   * Folder of the installed models; empty without one.
   */
  const char* GetInstalledModelsFolder() const;

  ///@{
  /**
   * Texture image of port 1.
   */
  void SetTextureConnection(vtkAlgorithmOutput* output) { this->SetInputConnection(1, output); }
  void SetTextureData(vtkDataObject* image) { this->SetInputDataObject(1, image); }
  void RemoveTexture() { this->SetInputConnection(1, nullptr); }
  ///@}

  ///@{
  /**
   * Name of the point array of colors that is encoded when there is no texture image. Default "": the active point
   * scalars.
   */
  void SetColorArrayName(const char* name);
  vtkGetCharFromStdStringMacro(ColorArrayName);
  ///@}

  ///@{
  /**
   * Continuation of the texture image outside [0, 1] x [0, 1]. Default AUTOMATIC.
   */
  vtkSetClampMacro(TextureWrap, int, AUTOMATIC, CLAMP);
  vtkGetMacro(TextureWrap, int);
  void SetTextureWrapToAutomatic() { this->SetTextureWrap(AUTOMATIC); }
  void SetTextureWrapToRepeat() { this->SetTextureWrap(REPEAT); }
  void SetTextureWrapToClamp() { this->SetTextureWrap(CLAMP); }
  ///@}

  ///@{
  /**
   * Number of samples in the one-ring of each vertex, 0 to 4096: each triangle has its share by area, at least one
   * sample. More samples see finer textures and take more time. 0 stands for the number of the training, in the model
   * file. Default 0.
   */
  vtkSetClampMacro(SamplesPerRing, int, 0, 4096);
  vtkGetMacro(SamplesPerRing, int);
  ///@}

  ///@{
  /**
   * Name of the arrays of the output: the first part of all, as described above; not empty. Default "FieldLatent".
   */
  void SetLatentArrayName(const char* name);
  vtkGetCharFromStdStringMacro(LatentArrayName);
  ///@}

  /**
   * Description of the model of the last update in one line: dimension and sizes. Empty before the first model.
   */
  std::string GetModelDescription() const;

  /**
   * Number of model files read since this object was made. Unchanged while the file is unchanged.
   */
  vtkTypeInt64 GetNumberOfModelLoads() const;

  /**
   * Number of meshes whose one-rings were computed since this object was made. Unchanged while only the model, colors,
   * texture coordinates or other properties change.
   */
  vtkTypeInt64 GetNumberOfRingComputations() const;

protected:
  vtkFieldLatentEncoder();
  ~vtkFieldLatentEncoder() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestDataObject(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int RequestUpdateExtent(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;

private:
  vtkFieldLatentEncoder(const vtkFieldLatentEncoder&) = delete;
  void operator=(const vtkFieldLatentEncoder&) = delete;

  std::string ModelFileName;
  std::string ColorArrayName;
  int TextureWrap = AUTOMATIC;
  int SamplesPerRing = 0;
  std::string LatentArrayName = "FieldLatent";

  class Internals;
  std::unique_ptr<Internals> Impl;
};

#endif
