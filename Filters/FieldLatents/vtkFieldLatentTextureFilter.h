// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkFieldLatentTextureFilter
 * @brief   Samples textures for surfaces with a diffusion model of field latents
 *
 * Makes new textures like that of the textured mesh that a model was trained on, for the same surface or any other one: a
 * denoising diffusion model samples field latents, tangent vectors at the vertices of the surface, which the autoencoder
 * of vtkFieldLatentEncoder decodes to a texture ([Mitchel2024], sections 5 and 6.2 to 6.6). Labels of points choose
 * between the parts of the training texture, vectors at points its direction, and a mask keeps a part of the texture that
 * the surface has (inpainting).
 *
 * @par Model files
 * Two files in safetensors format: ModelFileName, the diffusion model, with the metadata `architecture`
 * ("field_latent_diffusion"), as vtkLatentDiffusionTrainer writes it; and AutoencoderFileName, the autoencoder of its
 * latents, as vtkFieldLatentTrainer writes it. The diffusion model names its autoencoder by a fingerprint; another one is
 * an error. Files are checked before use; a damaged file, or one of another kind, is an error that names the cause. A
 * file is read once, and again in an update after its size or time of modification has changed.
 *
 * @par Input
 * Port 0: vtkPolyData with triangles, polygons or strips, float or double points, open or closed, any number of
 * components; or a composite dataset of such blocks, processed block by block with noise that differs between blocks: a
 * block that cannot be processed is reported and left empty. Requirements on the mesh are those of vtkFieldLatentEncoder:
 * finite points, no degenerate triangle and, once points at the same coordinates are joined, manifold edges and points and
 * consistent winding. Empty input gives empty output. A surface with active texture coordinates keeps them; they must be
 * those of an atlas, within [0, 1] by 1e-4. One without gets the atlas that vtkTextureAtlasFilter makes for Resolution.
 *
 * Port 1, optional, read with MaskArrayName only: a vtkImageData, the texture of the surface on port 0, as for
 * vtkFieldLatentEncoder; the surface then needs texture coordinates. Without it the colors of points are taken:
 * ColorArrayName.
 *
 * @par Scale
 * Latents are sampled on a triangulation of even triangles with NumberOfPoints vertices, which the filter makes: a
 * texture feature spans about as many triangles as on the training surfaces, so that four times the points halve the size
 * of the texture. The result is decoded on the input's own cells and texture coordinates. With Triangulation AS_IS the
 * input's own triangles are taken.
 *
 * Vertices of regular grids lie at the centroids of their rings, where the code of a flat color is 0 and the color is
 * lost. Remeshed vertices within 0.05 of the mean radius of a ring from that place, about one in a hundred, are moved
 * along an edge by a tenth to a quarter of its length, within the surface. One warning has the number of those in regular
 * parts that are left, as with AS_IS.
 *
 * @par Output
 * Port 0: the surface with its own cells and arrays (those that vtkTextureAtlasFilter gives it, without texture
 * coordinates), plus the point array TextureArrayName, unsigned char, 3 components, RGB: the colors of the texture at the
 * points; the active scalars.
 *
 * Port 1: a vtkImageData of Resolution, point scalars TextureArrayName, as that of vtkFieldLatentDecoder.
 *
 * Port 2: the triangulation with the sampled latents, a vtkPolyData with the point arrays <name>_0 to <name>_<d - 1>,
 * <name>Deviation (0) and <name>Radius of vtkFieldLatentEncoder, with <name> LatentArrayName: vtkFieldLatentDecoder lays
 * them on any target.
 *
 * For several samples each output is a vtkMultiBlockDataSet with a block for each sample, "Sample 0", "Sample 1", ...; for
 * a composite input each of these has its structure, and so has the output of one sample.
 *
 * @par Time
 * With OutputTrajectory the time of the pipeline is that of the reverse process: the filter announces the time steps 0, 1
 * / NumberOfSteps, ..., 1 and outputs the latents at the requested time, decoded: noise at 0, the texture at 1, linear
 * between two steps. All states are kept, so that a change of time costs no evaluation of the network. The input is then
 * the one that its source holds, or outputs without a requested time. An update without a requested time outputs time 1.
 *
 * @par Randomness
 * The first noise is that of cubes in space, averaged over the cells of vertices, later noise (DDPM, masks) belongs to the
 * positions of vertices: a sample depends on the models, the surface
 * and where it lies, Seed and its number, guidance, Sampler and NumberOfSteps, and not on the numbers of points and cells
 * (but for rounding errors, and with remeshing where CGAL takes another order of its steps). On another triangulation of
 * the same surface, with the same number of vertices to some per cent, coarse parts of the noise are the same, and so are
 * coarse features of the texture; fine ones differ. The same bits for every number of threads, alone or in a batch.
 * Another kind of processor may give other last bits: Reproducibility in README.md.
 *
 * @par Cost
 * NumberOfSteps evaluations of the network for each sample, each linear in the vertices of the triangulation; then the
 * cost of vtkFieldLatentDecoder. Triangulation, atlas, levels and transports are computed once for each mesh and kept
 * until it, or what they depend on, changes; samples are kept too: an update evaluates the network only for samples that
 * the last one lacks.
 *
 * @sa vtkLatentDiffusionTrainer, vtkFieldLatentEncoder, vtkFieldLatentDecoder, vtkTextureAtlasFilter,
 * vtkIsotropicRemeshFilter
 */

#ifndef vtkFieldLatentTextureFilter_h
#define vtkFieldLatentTextureFilter_h

#include "vtkDataObjectAlgorithm.h"
#include "vtkSurfaceSynthesisFieldLatentsModule.h" // For export macro

#include <memory> // For std::unique_ptr
#include <string> // For std::string

class vtkStringArray;

class VTKSURFACESYNTHESISFIELDLATENTS_EXPORT vtkFieldLatentTextureFilter : public vtkDataObjectAlgorithm
{
public:
  static vtkFieldLatentTextureFilter* New();
  vtkTypeMacro(vtkFieldLatentTextureFilter, vtkDataObjectAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// Triangulations on which latents are sampled.
  enum Triangulations
  {
    REMESH = 0, ///< even triangles with NumberOfPoints vertices; needs CGAL
    AS_IS = 1   ///< the triangles of the input
  };

  /// Methods of the reverse process.
  enum Samplers
  {
    DDIM = 0, ///< deterministic after the first noise; 20 to 100 steps are enough
    DDPM = 1  ///< adds fresh noise in each step; made for all steps of the training
  };

  ///@{
  /**
   * Path of the file of the diffusion model, or name of an installed one (GetInstalledModels()). Must be set. Default "".
   */
  void SetModelFileName(const char* name);
  vtkGetCharFromStdStringMacro(ModelFileName);
  ///@}

  ///@{
  /**
   * Path of the file of the autoencoder of field latents, or name of an installed one (GetInstalledAutoencoders()); not
   * empty. Default "field_latents", the installed one.
   */
  void SetAutoencoderFileName(const char* name);
  vtkGetCharFromStdStringMacro(AutoencoderFileName);
  ///@}

  ///@{
  /**
   * Names of the installed diffusion models and autoencoders.
   */
  vtkStringArray* GetInstalledModels();
  vtkStringArray* GetInstalledAutoencoders();
  ///@}

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
   * Name of a point array with a label for each point: whole numbers from 0 to the number of labels of the model - 1, or
   * -1 for no label; 1 component. Needs a model with labels. Default "": no labels.
   */
  void SetLabelArrayName(const char* name);
  vtkGetCharFromStdStringMacro(LabelArrayName);
  ///@}

  ///@{
  /**
   * Name of a point array with a vector for each point, the direction of the texture: 3 components of any length, 0 for
   * no direction. Needs a directed model. Default "": no directions.
   */
  void SetDirectionArrayName(const char* name);
  vtkGetCharFromStdStringMacro(DirectionArrayName);
  ///@}

  ///@{
  /**
   * Name of a point array with numbers from 0 to 1, 1 component: 1 where the texture of the input is kept, 0 where a new
   * one is sampled. Needs a texture: the image on port 1, or colors of points, encoded with 128 samples in a ring or
   * more, as training data are. Default "": a new texture everywhere.
   */
  void SetMaskArrayName(const char* name);
  vtkGetCharFromStdStringMacro(MaskArrayName);
  ///@}

  ///@{
  /**
   * Name of the point array of colors that is kept by MaskArrayName when there is no texture image. Default "": the active
   * point scalars.
   */
  void SetColorArrayName(const char* name);
  vtkGetCharFromStdStringMacro(ColorArrayName);
  ///@}

  ///@{
  /**
   * Triangulation on which latents are sampled. Default REMESH. With AS_IS, colors are lost on regular grids: see Scale.
   */
  vtkSetClampMacro(Triangulation, int, REMESH, AS_IS);
  vtkGetMacro(Triangulation, int);
  void SetTriangulationToRemesh() { this->SetTriangulation(REMESH); }
  void SetTriangulationToAsIs() { this->SetTriangulation(AS_IS); }
  ///@}

  ///@{
  /**
   * Number of vertices of the triangulation of REMESH, 16 to 10000000, or 0: the mean number of the training surfaces,
   * or, when the model does not know it, that of the input; values between 0 and 16 stand for 16. GetNumberOfVertices()
   * says how many there were. Default 0.
   */
  void SetNumberOfPoints(int number);
  vtkGetMacro(NumberOfPoints, int);
  ///@}

  ///@{
  /**
   * Method of the reverse process. Default DDIM.
   */
  vtkSetClampMacro(Sampler, int, DDIM, DDPM);
  vtkGetMacro(Sampler, int);
  void SetSamplerToDDIM() { this->SetSampler(DDIM); }
  void SetSamplerToDDPM() { this->SetSampler(DDPM); }
  ///@}

  ///@{
  /**
   * Number of steps of the reverse process, evaluations of the network for each sample, 1 to 100000, at most the time
   * steps of the model (1000 for models of the paper's schedule). Default 50.
   */
  vtkSetClampMacro(NumberOfSteps, int, 1, 100000);
  vtkGetMacro(NumberOfSteps, int);
  ///@}

  ///@{
  /**
   * Seed of the random numbers, any integer. Default 0.
   */
  vtkSetMacro(Seed, int);
  vtkGetMacro(Seed, int);
  ///@}

  ///@{
  /**
   * Number of samples, 1 to 10000. Default 1.
   */
  vtkSetClampMacro(NumberOfSamples, int, 1, 10000);
  vtkGetMacro(NumberOfSamples, int);
  ///@}

  ///@{
  /**
   * Number of the first sample, at least 0: sample k is the same alone or in a batch. Default 0.
   */
  vtkSetClampMacro(FirstSample, int, 0, VTK_INT_MAX - 10000);
  vtkGetMacro(FirstSample, int);
  ///@}

  ///@{
  /**
   * Makes the time of the pipeline that of the reverse process, from noise at 0 to the texture at 1, so that an animation
   * shows the denoising. Default off.
   */
  vtkSetMacro(OutputTrajectory, bool);
  vtkGetMacro(OutputTrajectory, bool);
  vtkBooleanMacro(OutputTrajectory, bool);
  ///@}

  ///@{
  /**
   * Width and height of the texture images, texels, 16 to 16384 each. Default 1024 x 1024.
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
   * Name of the arrays of port 2: the first part of all, as described above; not empty. Default "FieldLatent".
   */
  void SetLatentArrayName(const char* name);
  vtkGetCharFromStdStringMacro(LatentArrayName);
  ///@}

  ///@{
  /**
   * Name of the colors of points and of the scalars of the images; not empty. Default "Texture".
   */
  void SetTextureArrayName(const char* name);
  vtkGetCharFromStdStringMacro(TextureArrayName);
  ///@}

  ///@{
  /**
   * Memory limit of the images, the states of samples and the features of the network, MiB, at least 0; 0, the default,
   * for three quarters of the memory of the machine. More is an error before the work begins.
   */
  vtkSetClampMacro(MemoryLimit, int, 0, VTK_INT_MAX);
  vtkGetMacro(MemoryLimit, int);
  ///@}

  /**
   * Description of the diffusion model of the last update in one line. Empty before the first model.
   */
  std::string GetModelDescription() const;

  /**
   * Number of vertices of the triangulation on which latents were last sampled; 0 before.
   */
  vtkTypeInt64 GetNumberOfVertices() const;

  /**
   * Number of files of diffusion models read since this object was made. Unchanged while the file is unchanged.
   */
  vtkTypeInt64 GetNumberOfModelLoads() const;

  /**
   * Number of triangulations made since this object was made. Unchanged while mesh, Triangulation and number of points
   * are.
   */
  vtkTypeInt64 GetNumberOfTriangulations() const;

  /**
   * Number of evaluations of the network since this object was made. Unchanged while samples are kept.
   */
  vtkTypeInt64 GetNumberOfEvaluations() const;

protected:
  vtkFieldLatentTextureFilter();
  ~vtkFieldLatentTextureFilter() override;

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
  vtkFieldLatentTextureFilter(const vtkFieldLatentTextureFilter&) = delete;
  void operator=(const vtkFieldLatentTextureFilter&) = delete;

  /// Notes the time of the reverse process on all outputs.
  void SetTimeOfOutputs(vtkInformationVector* outputVector, double time) const;

  std::string ModelFileName;
  std::string AutoencoderFileName = "field_latents";
  std::string LabelArrayName;
  std::string DirectionArrayName;
  std::string MaskArrayName;
  std::string ColorArrayName;
  int Triangulation = REMESH;
  int NumberOfPoints = 0;
  int Sampler = DDIM;
  int NumberOfSteps = 50;
  int Seed = 0;
  int NumberOfSamples = 1;
  int FirstSample = 0;
  bool OutputTrajectory = false;
  int Resolution[2] = { 1024, 1024 };
  int GutterWidth = 8;
  std::string LatentArrayName = "FieldLatent";
  std::string TextureArrayName = "Texture";
  int MemoryLimit = 0;

  class Internals;
  std::unique_ptr<Internals> Impl;
};

#endif
