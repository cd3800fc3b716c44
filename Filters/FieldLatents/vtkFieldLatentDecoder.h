// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkFieldLatentDecoder
 * @brief   Decodes field latents of a surface to a texture image and to colors of points
 *
 * Makes a texture of the latents of vtkFieldLatentEncoder, tangent vectors at the points of a surface ([Mitchel2024],
 * section 4): a neural field at each corner of a triangle gives colors, which are blended by barycentric coordinates.
 * The texture may have any resolution, and be laid on another triangulation or atlas of the same shape.
 *
 * @par Model file
 * As for vtkFieldLatentEncoder; the model must be the one that has made the latents.
 *
 * @par Input
 * Port 0: the surface with the latents: vtkPolyData with triangles, polygons or strips, float or double points; or,
 * without a target, a composite dataset of such blocks, processed block by block: a block that cannot be processed is
 * reported and left empty. It needs the point arrays <name>_0 to <name>_<d - 1> (3 components) and <name>Radius (1
 * component, larger than 0) of vtkFieldLatentEncoder, any floating-point type, with <name> LatentArrayName and d the
 * dimension of the model. They may be interpolated: vectors are projected to the tangent planes. Points with the same
 * coordinates are one vertex, with the latents of the one with the lowest id. Requirements on the mesh are those of
 * vtkFieldLatentEncoder. Empty input gives empty output.
 *
 * Port 1, optional: the target, a vtkPolyData on which the texture is laid. Each place of it gets the color of the
 * nearest place of the surface on port 0. Without a target that is the surface on port 0.
 *
 * The target needs active texture coordinates at its points (vtkTextureAtlasFilter makes some): finite, within [0, 1]
 * by 1e-4. A warning names cells that overlap in the texture, which share their texels, and cells without area there.
 *
 * @par Output
 * Port 0: the target, untouched, plus the point array TextureArrayName, unsigned char, 3 components, RGB: the colors of
 * the texture at the points; the active scalars. 0 at points that no polygon or strip uses.
 *
 * Port 1: a vtkImageData of Resolution, point scalars TextureArrayName, unsigned char, 3 components, RGB; row 0 is at
 * v = 0. Texels outside of all triangles, up to GutterWidth, have the color of the nearest texel inside; others are
 * black. For a composite input a dataset of its type with an image in the place of each block.
 *
 * @par Cost
 * Linear in the texels that show the surface; 64 bytes for each texel of the image. One-rings and the places of texels
 * are kept while meshes, texture coordinates, Resolution and GutterWidth are unchanged. The same bits for every number
 * of threads. Another kind of processor may give other last bits: Reproducibility in README.md.
 *
 * @sa vtkFieldLatentEncoder, vtkSurfaceRepairFilter
 */

#ifndef vtkFieldLatentDecoder_h
#define vtkFieldLatentDecoder_h

#include "vtkDataObjectAlgorithm.h"
#include "vtkSurfaceSynthesisFieldLatentsModule.h" // For export macro

#include <memory> // For std::unique_ptr
#include <string> // For std::string

class vtkStringArray;

class VTKSURFACESYNTHESISFIELDLATENTS_EXPORT vtkFieldLatentDecoder : public vtkDataObjectAlgorithm
{
public:
  static vtkFieldLatentDecoder* New();
  vtkTypeMacro(vtkFieldLatentDecoder, vtkDataObjectAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

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
   * Target of port 1.
   */
  void SetTargetConnection(vtkAlgorithmOutput* output) { this->SetInputConnection(1, output); }
  void SetTargetData(vtkDataObject* target) { this->SetInputDataObject(1, target); }
  void RemoveTarget() { this->SetInputConnection(1, nullptr); }
  ///@}

  ///@{
  /**
   * Width and height of the texture image, texels, 16 to 16384 each. Default 1024 x 1024.
   */
  void SetResolution(int width, int height);
  void SetResolution(const int size[2]) { this->SetResolution(size[0], size[1]); }
  vtkGetVector2Macro(Resolution, int);
  ///@}

  ///@{
  /**
   * Distance from the charts up to which texels outside are filled, texels, -1 to 16384: 0 for those of bilinear
   * interpolation only, 2^k for k further levels of a mipmap, -1 for the whole image. Default 8.
   */
  vtkSetClampMacro(GutterWidth, int, -1, 16384);
  vtkGetMacro(GutterWidth, int);
  ///@}

  ///@{
  /**
   * Name of the arrays with the latents: the first part of all, as described for vtkFieldLatentEncoder; not empty. Default
   * "FieldLatent".
   */
  void SetLatentArrayName(const char* name);
  vtkGetCharFromStdStringMacro(LatentArrayName);
  ///@}

  ///@{
  /**
   * Name of the colors of points and of the scalars of the image; not empty. Default "Texture".
   */
  void SetTextureArrayName(const char* name);
  vtkGetCharFromStdStringMacro(TextureArrayName);
  ///@}

  ///@{
  /**
   * Memory limit of the images and of the places of their texels, MiB, at least 0; 0, the default, for three quarters of
   * the memory of the machine. A larger Resolution is an error before the work begins; the message names one that fits.
   */
  vtkSetClampMacro(MemoryLimit, int, 0, VTK_INT_MAX);
  vtkGetMacro(MemoryLimit, int);
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
   * Number of meshes whose one-rings were computed since this object was made. Unchanged while only the model, latents,
   * texture coordinates or other properties change.
   */
  vtkTypeInt64 GetNumberOfRingComputations() const;

  /**
   * Number of atlases rasterized since this object was made. Unchanged while only the model, latents or names change.
   */
  vtkTypeInt64 GetNumberOfRasterizations() const;

protected:
  vtkFieldLatentDecoder();
  ~vtkFieldLatentDecoder() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int FillOutputPortInformation(int port, vtkInformation* info) override;
  int RequestDataObject(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int RequestInformation(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int RequestUpdateExtent(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;

private:
  vtkFieldLatentDecoder(const vtkFieldLatentDecoder&) = delete;
  void operator=(const vtkFieldLatentDecoder&) = delete;

  std::string ModelFileName;
  int Resolution[2] = { 1024, 1024 };
  int GutterWidth = 8;
  std::string LatentArrayName = "FieldLatent";
  std::string TextureArrayName = "Texture";
  int MemoryLimit = 0;

  class Internals;
  std::unique_ptr<Internals> Impl;
};

#endif
