// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkFieldLatentTrainer
 * @brief   Trains the autoencoder of field latents on images
 *
 * Trains the variational autoencoder of "Single Mesh Diffusion Models with Field Latents for Texture Generation" (Mitchel
 * et al. 2024, sections 4 and 9.1), which encodes textures of surfaces as tangent vectors at vertices: random rings of
 * planar meshes are laid over images at random places, angles and scales. The model file serves surfaces of any shape;
 * vtkFieldLatentEncoder and vtkFieldLatentDecoder apply it. Files, device, seed and learning rate are those of
 * vtkModelTrainer, but the default of LearningRate is 1e-3.
 *
 * @par Input
 * Port 0: the images, a vtkImageData, or a composite dataset whose leaves in order are images; empty ones are left out.
 * An image has one slice of at least 16 x 16 pixels; its active point scalars are the colors: 1 component (gray), 2 (gray
 * and alpha), 3 (RGB) or 4 (RGBA) of any numeric type. Integers range from 0 to the largest number of their type,
 * floating-point numbers from 0 to 1; alpha is left out, with a warning where it is not opaque. Large images are not
 * reduced: their finest details are learnt.
 * @par
 * The port may be left unconnected when DatasetFileName is set: a file with images and planar meshes, which the Python
 * package and the library write. NumberOfMeshes and MeshPoints are not used then.
 *
 * @par Output
 * The table of vtkModelTrainer with the columns iteration (vtkIdType), loss, reconstruction_loss, divergence_loss (before its weight), gradient_norm (before it is clipped) and learning_rate
 * (float64); loss is reconstruction_loss + DivergenceWeight divergence_loss.
 *
 * @par Files
 * Those of vtkModelTrainer. Device and the names and times of files may change between an update and the next, which goes
 * on from the checkpoint.
 *
 * @par Cost
 * Iterations times BatchSize rings, each with SamplesPerRing samples, quadratic in Channels and in DecoderWidth; beside
 * them NumberOfMeshes times MeshPoints^2 to make the meshes, at each update. Everything random is a pure function of the
 * seed and the iteration: the same seed gives the same bits with the same number of threads on the same machine,
 * interrupted or not.
 *
 * @par Errors
 * Those of vtkModelTrainer, and one error and an empty table for: an image as above; Heads that do not divide Channels; a
 * BatchSize that is no multiple of 3 with BARYCENTRIC coordinates; MaximumTexels below MinimumTexels.
 *
 * @sa vtkModelTrainer, vtkFieldLatentEncoder, vtkFieldLatentDecoder, vtkGroupDataSetsFilter
 */

#ifndef vtkFieldLatentTrainer_h
#define vtkFieldLatentTrainer_h

#include "vtkModelTrainer.h"
#include "vtkSurfaceSynthesisTrainingModule.h" // For export macro

#include <limits> // For std::numeric_limits

class VTKSURFACESYNTHESISTRAINING_EXPORT vtkFieldLatentTrainer : public vtkModelTrainer
{
public:
  static vtkFieldLatentTrainer* New();
  vtkTypeMacro(vtkFieldLatentTrainer, vtkModelTrainer);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// Sizes of the networks.
  enum SizesOfNetworks
  {
    SMALL = 0, ///< for processors
    PAPER = 1  ///< for GPUs
  };

  /// Coordinates that the decoder sees.
  enum CoordinatesOfTexels
  {
    LOGARITHMIC = 0, ///< those of the paper: predictions of three corners are blended
    BARYCENTRIC = 1  ///< for comparison: the paper's ablation
  };

  ///@{
  /**
   * Number of planar meshes that are made of random points and laid over the images, from 1 to 100000; the paper has 1000.
   * Default 64.
   */
  vtkSetClampMacro(NumberOfMeshes, int, 1, 100000);
  vtkGetMacro(NumberOfMeshes, int);
  ///@}

  ///@{
  /**
   * Number of points of a planar mesh, from 16 to 1000000; the paper has 10000. Default 2500.
   */
  vtkSetClampMacro(MeshPoints, int, 16, 1000000);
  vtkGetMacro(MeshPoints, int);
  ///@}

  ///@{
  /**
   * Sizes of the networks where the properties LatentDimension, Channels, EncoderLayers, Heads, SamplesPerRing,
   * DecoderLayers and DecoderWidth are 0. SMALL has 8, 32, 4, 4, 32, 4 and 128, which two processor cores train in hours;
   * PAPER has 8, 128, 8, 8, 64, 5 and 512. Default SMALL.
   */
  vtkSetClampMacro(Sizes, int, SMALL, PAPER);
  vtkGetMacro(Sizes, int);
  void SetSizesToSmall() { this->SetSizes(SMALL); }
  void SetSizesToPaper() { this->SetSizes(PAPER); }
  ///@}

  ///@{
  /**
   * Number of tangent vectors of a latent code, from 1 to 256. 0 (the default) stands for that of Sizes.
   */
  vtkSetClampMacro(LatentDimension, int, 0, 256);
  vtkGetMacro(LatentDimension, int);
  ///@}

  ///@{
  /**
   * Channels of the encoder, from 1 to 4096. 0 (the default) stands for those of Sizes.
   */
  vtkSetClampMacro(Channels, int, 0, 4096);
  vtkGetMacro(Channels, int);
  ///@}

  ///@{
  /**
   * Layers of the encoder, from 1 to 256. 0 (the default) stands for those of Sizes.
   */
  vtkSetClampMacro(EncoderLayers, int, 0, 256);
  vtkGetMacro(EncoderLayers, int);
  ///@}

  ///@{
  /**
   * Heads of the attention of the encoder, from 1 to 4096; must divide Channels. 0 (the default) stands for those of
   * Sizes.
   */
  vtkSetClampMacro(Heads, int, 0, 4096);
  vtkGetMacro(Heads, int);
  ///@}

  ///@{
  /**
   * Number of samples in a ring that the encoder sees, from 1 to 65536, and of those that the loss compares. 0 (the
   * default) stands for that of Sizes.
   */
  vtkSetClampMacro(SamplesPerRing, int, 0, 65536);
  vtkGetMacro(SamplesPerRing, int);
  ///@}

  ///@{
  /**
   * Hidden layers of the decoder, from 1 to 256. 0 (the default) stands for those of Sizes.
   */
  vtkSetClampMacro(DecoderLayers, int, 0, 256);
  vtkGetMacro(DecoderLayers, int);
  ///@}

  ///@{
  /**
   * Channels of the hidden layers of the decoder, from 1 to 65536. 0 (the default) stands for those of Sizes.
   */
  vtkSetClampMacro(DecoderWidth, int, 0, 65536);
  vtkGetMacro(DecoderWidth, int);
  ///@}

  ///@{
  /**
   * Coordinates of a texel that the decoder sees. LOGARITHMIC: those of the paper; BARYCENTRIC: its ablation, for
   * comparison. Default LOGARITHMIC.
   */
  vtkSetClampMacro(Coordinates, int, LOGARITHMIC, BARYCENTRIC);
  vtkGetMacro(Coordinates, int);
  void SetCoordinatesToLogarithmic() { this->SetCoordinates(LOGARITHMIC); }
  void SetCoordinatesToBarycentric() { this->SetCoordinates(BARYCENTRIC); }
  ///@}

  ///@{
  /**
   * Number of iterations in all, those of a checkpoint included, at least 1; the paper has 1,500,000. Default 100000.
   */
  vtkSetClampMacro(Iterations, int, 1, 100000000);
  vtkGetMacro(Iterations, int);
  ///@}

  ///@{
  /**
   * Number of rings in an iteration, from 1 to 1000000; the paper has 16. With BARYCENTRIC coordinates it must be a
   * multiple of 3. Default 48.
   */
  vtkSetClampMacro(BatchSize, int, 1, 1000000);
  vtkGetMacro(BatchSize, int);
  ///@}

  ///@{
  /**
   * Learning rate at the end, larger than 0: it falls from LearningRate along half a cosine. Default 1e-5.
   */
  vtkSetClampMacro(FinalLearningRate, double, 1e-300, std::numeric_limits<double>::max());
  vtkGetMacro(FinalLearningRate, double);
  ///@}

  ///@{
  /**
   * Weight of the Kullback-Leibler divergence in the loss, lambda of equation 28, at least 0. Default 0.01.
   */
  vtkSetClampMacro(DivergenceWeight, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(DivergenceWeight, double);
  ///@}

  ///@{
  /**
   * Least number of pixels of an image for a vertex, larger than 0: the scale of a mesh is random, log-uniformly between
   * this number and MaximumTexels. Default 10.
   */
  vtkSetClampMacro(MinimumTexels, double, 1e-300, VTK_DOUBLE_MAX);
  vtkGetMacro(MinimumTexels, double);
  ///@}

  ///@{
  /**
   * Largest number of pixels of an image for a vertex, at least MinimumTexels. Default 150.
   */
  vtkSetClampMacro(MaximumTexels, double, 1e-300, VTK_DOUBLE_MAX);
  vtkGetMacro(MaximumTexels, double);
  ///@}

  ///@{
  /**
   * Power k of the density of the loss's points in a one-ring, at least 0: proportional to b^k, where b is the barycentric
   * coordinate of its vertex, with which the vertex' prediction enters a texel. With 2 the loss measures errors as they
   * enter texels. Of no effect with BARYCENTRIC coordinates. Default 0: uniform, as equation 26.
   */
  vtkSetClampMacro(TargetPower, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(TargetPower, double);
  ///@}

  ///@{
  /**
   * Part of the rings whose colors are changed, from 0 to 1: the channels are permuted, and the range of each becomes a
   * random one, which may be reversed. Photographs have few saturated colors, and textures of models many. Default 0.
   */
  vtkSetClampMacro(ColorAugmentation, double, 0.0, 1.0);
  vtkGetMacro(ColorAugmentation, double);
  ///@}

  ///@{
  /**
   * Largest norm of the gradient of all weights together, at least 0; longer ones are scaled down to it. 0 stands
   * for no limit. Default 1.
   */
  vtkSetClampMacro(GradientClip, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(GradientClip, double);
  ///@}

  /**
   * Removes the images: for ParaView, which cannot name a port in doing so.
   */
  void RemoveImages() { this->SetInputConnection(0, nullptr); }

protected:
  vtkFieldLatentTrainer();
  ~vtkFieldLatentTrainer() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  void Train(vtkInformationVector** inputVector, Run& run) override;

private:
  vtkFieldLatentTrainer(const vtkFieldLatentTrainer&) = delete;
  void operator=(const vtkFieldLatentTrainer&) = delete;

  class Internals;

  int NumberOfMeshes = 64;
  int MeshPoints = 2500;
  int Sizes = SMALL;
  int LatentDimension = 0;
  int Channels = 0;
  int EncoderLayers = 0;
  int Heads = 0;
  int SamplesPerRing = 0;
  int DecoderLayers = 0;
  int DecoderWidth = 0;
  int Coordinates = LOGARITHMIC;
  int Iterations = 100000;
  int BatchSize = 48;
  double FinalLearningRate = 1e-5;
  double DivergenceWeight = 0.01;
  double MinimumTexels = 10.0;
  double MaximumTexels = 150.0;
  double TargetPower = 0.0;
  double ColorAugmentation = 0.0;
  double GradientClip = 1.0;
};

#endif
