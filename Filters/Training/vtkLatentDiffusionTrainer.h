// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkLatentDiffusionTrainer
 * @brief   Trains a diffusion model of field latents on one textured surface
 *
 * Trains the denoising network of "Single Mesh Diffusion Models with Field Latents for Texture Generation" (Mitchel et al.
 * 2024, sections 5, 6.2 and 9.2) on the texture of one surface: the surface is remeshed many times, the autoencoder of
 * vtkFieldLatentTrainer encodes its texture on each triangulation, with 128 samples in a ring or more, and the network
 * learns to take noise out of the latents.
 * vtkFieldLatentTextureFilter samples new textures with the model, on this surface or any other one. Files, device, seed
 * and learning rate are those of vtkModelTrainer, but the default of LearningRate is 1e-3.
 *
 * @par Input
 * Port 0: the surface, a vtkPolyData as vtkFieldLatentEncoder takes it: triangles, polygons or strips, manifold and
 * consistently wound once points at the same coordinates are joined. With an image it needs active texture coordinates at
 * its points. LabelArrayName and DirectionArrayName name point arrays that guide the samples of the model.
 *
 * Port 1, optional: the texture, a vtkImageData as for vtkFieldLatentEncoder; without it the colors of points are taken:
 * ColorArrayName.
 * @par
 * The ports may be left unconnected when DatasetFileName is set: a file with triangulations and latents, as
 * EncodedDatasetFileName is written. NumberOfTriangulations, NumberOfPoints, AutoencoderFileName and the names of arrays are
 * not used then.
 *
 * @par Output
 * The table of vtkModelTrainer with the columns iteration (vtkIdType), loss, gradient_norm (before it is clipped),
 * learning_rate and noise_loss_1 to noise_loss_8 (float64): the mean square of the error of the noise in eight ranges of
 * time, from little to much noise.
 *
 * @par Files
 * Those of vtkModelTrainer, and the image of SampleFileName. The model file has the fingerprint of its autoencoder and the
 * mean number of vertices of its surfaces. Device and the names and times of files may change between an update and the next, which goes on from the
 * checkpoint.
 *
 * @par Cost
 * Iterations times BatchSize evaluations of the network and its derivatives, each linear in NumberOfPoints; beside them the
 * remeshing and encoding of NumberOfTriangulations surfaces, at each update. Everything random is a pure function of the
 * seed and the iteration: the same seed gives the same bits with the same number of threads on the same machine,
 * interrupted or not.
 *
 * @par Errors
 * Those of vtkModelTrainer and of vtkFieldLatentEncoder, and one error and an empty table for: labels that are no whole
 * numbers from -1 to 65535; a file that is no autoencoder of field latents; a library that was built without CGAL, which
 * remeshes, unless there is a dataset file.
 *
 * @sa vtkModelTrainer, vtkFieldLatentTextureFilter, vtkFieldLatentTrainer, vtkTextureAtlasFilter
 */

#ifndef vtkLatentDiffusionTrainer_h
#define vtkLatentDiffusionTrainer_h

#include "vtkModelTrainer.h"
#include "vtkSurfaceSynthesisTrainingModule.h" // For export macro

#include <limits> // For std::numeric_limits
#include <string> // For std::string

class VTKSURFACESYNTHESISTRAINING_EXPORT vtkLatentDiffusionTrainer : public vtkModelTrainer
{
public:
  static vtkLatentDiffusionTrainer* New();
  vtkTypeMacro(vtkLatentDiffusionTrainer, vtkModelTrainer);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// Sizes of the network.
  enum SizesOfNetworks
  {
    SMALL = 0, ///< for processors
    PAPER = 1  ///< for GPUs
  };

  /// Quantities that the network predicts.
  enum Targets
  {
    NOISE = 0,   ///< that of the paper
    DATA = 1,    ///< the latents
    VELOCITY = 2 ///< sqrt(alpha) noise - sqrt(1 - alpha) latents
  };

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
   * Path of the file of the autoencoder of field latents, or name of an installed one; not empty. Default "field_latents",
   * the installed one.
   */
  void SetAutoencoderFileName(const char* name);
  vtkGetCharFromStdStringMacro(AutoencoderFileName);
  ///@}

  ///@{
  /**
   * Name of the point array of colors that is learnt when there is no texture image. Default "": the active point scalars.
   */
  void SetColorArrayName(const char* name);
  vtkGetCharFromStdStringMacro(ColorArrayName);
  ///@}

  ///@{
  /**
   * Name of a point array with a label for each point, the part of the texture that it belongs to: whole numbers from 0 to
   * 65535, or -1 for no label; 1 component. Default "": a model without labels.
   */
  void SetLabelArrayName(const char* name);
  vtkGetCharFromStdStringMacro(LabelArrayName);
  ///@}

  ///@{
  /**
   * Name of a point array with a vector for each point, the direction of the texture: 3 components of any length, 0 for no
   * direction. Default "": a model without directions.
   */
  void SetDirectionArrayName(const char* name);
  vtkGetCharFromStdStringMacro(DirectionArrayName);
  ///@}

  ///@{
  /**
   * Number of triangulations of the surface, from 1 to 100000; the paper has 500. Default 16.
   */
  vtkSetClampMacro(NumberOfTriangulations, int, 1, 100000);
  vtkGetMacro(NumberOfTriangulations, int);
  ///@}

  ///@{
  /**
   * Mean number of vertices of a triangulation, from 16 to 10000000; the paper has 30000. Triangulations have from 0.85 to
   * 1.15 times as many, and random edge lengths, so that their vertices lie elsewhere. Details smaller than about a fifth
   * of a triangle are lost. Default 3000.
   */
  vtkSetClampMacro(NumberOfPoints, int, 16, 10000000);
  vtkGetMacro(NumberOfPoints, int);
  ///@}

  ///@{
  /**
   * Path of a dataset file that is written with the triangulations and their latents, for DatasetFileName and the program
   * surfacesynthesis-train. Default "": none.
   */
  void SetEncodedDatasetFileName(const char* name);
  vtkGetCharFromStdStringMacro(EncodedDatasetFileName);
  ///@}

  ///@{
  /**
   * Path of an image, PNG, that is written with each checkpoint: a texture of the surface on port 0, which it needs, also
   * beside a dataset file, sampled with the model so far in 20 steps, 512 x 512 texels, for Seed. A sample that fails is
   * the last one, and a warning at the end (in the background an error, with all files written). Not with several
   * processes. Default "": none.
   */
  void SetSampleFileName(const char* name);
  vtkGetCharFromStdStringMacro(SampleFileName);
  ///@}

  ///@{
  /**
   * Sizes of the network where the properties Channels, CoarseChannels, InputBlocks, CoarseBlocks and OutputBlocks are 0.
   * SMALL has 32, 48, 1, 2 and 2, which two processor cores train in hours; PAPER has 96, 192, 2, 4 and 4. Default SMALL.
   */
  vtkSetClampMacro(Sizes, int, SMALL, PAPER);
  vtkGetMacro(Sizes, int);
  void SetSizesToSmall() { this->SetSizes(SMALL); }
  void SetSizesToPaper() { this->SetSizes(PAPER); }
  ///@}

  ///@{
  /**
   * Channels on the surface, from 1 to 4096. 0 (the default) stands for those of Sizes.
   */
  vtkSetClampMacro(Channels, int, 0, 4096);
  vtkGetMacro(Channels, int);
  ///@}

  ///@{
  /**
   * Channels on the coarser level, from 1 to 4096. 0 (the default) stands for those of Sizes.
   */
  vtkSetClampMacro(CoarseChannels, int, 0, 4096);
  vtkGetMacro(CoarseChannels, int);
  ///@}

  ///@{
  /**
   * Blocks before the pooling, from 1 to 64. 0 (the default) stands for those of Sizes.
   */
  vtkSetClampMacro(InputBlocks, int, 0, 64);
  vtkGetMacro(InputBlocks, int);
  ///@}

  ///@{
  /**
   * Blocks on the coarser level, from 1 to 64. 0 (the default) stands for those of Sizes.
   */
  vtkSetClampMacro(CoarseBlocks, int, 0, 64);
  vtkGetMacro(CoarseBlocks, int);
  ///@}

  ///@{
  /**
   * Blocks after the unpooling, from 1 to 64. 0 (the default) stands for those of Sizes.
   */
  vtkSetClampMacro(OutputBlocks, int, 0, 64);
  vtkGetMacro(OutputBlocks, int);
  ///@}

  ///@{
  /**
   * Number of numbers of the embedding of time and labels, even, from 2 to 4096. Default 64.
   */
  vtkSetClampMacro(EmbeddingDimension, int, 2, 4096);
  vtkGetMacro(EmbeddingDimension, int);
  ///@}

  ///@{
  /**
   * Number of steps of the forward process, from 1 to 100000. Default 1000, as in the paper.
   */
  vtkSetClampMacro(TimeSteps, int, 1, 100000);
  vtkGetMacro(TimeSteps, int);
  ///@}

  ///@{
  /**
   * Variance that the first step of the forward process adds, larger than 0 and below 1. Default 1e-4.
   */
  vtkSetClampMacro(FirstVariance, double, 1e-12, 0.999999);
  vtkGetMacro(FirstVariance, double);
  ///@}

  ///@{
  /**
   * Variance that the last step of the forward process adds, from FirstVariance to below 1; linear between. Default 0.02.
   */
  vtkSetClampMacro(LastVariance, double, 1e-12, 0.999999);
  vtkGetMacro(LastVariance, double);
  ///@}

  ///@{
  /**
   * Draws the latents of each iteration from their Gaussians; off, takes their means. Default on.
   */
  vtkSetMacro(SampleLatents, bool);
  vtkGetMacro(SampleLatents, bool);
  vtkBooleanMacro(SampleLatents, bool);
  ///@}

  ///@{
  /**
   * Quantity that the network predicts. Default NOISE.
   */
  vtkSetClampMacro(Target, int, NOISE, VELOCITY);
  vtkGetMacro(Target, int);
  void SetTargetToNoise() { this->SetTarget(NOISE); }
  void SetTargetToData() { this->SetTarget(DATA); }
  void SetTargetToVelocity() { this->SetTarget(VELOCITY); }
  ///@}

  ///@{
  /**
   * Number of iterations in all, those of a checkpoint included, at least 0; the paper has 300,000. 0 trains nothing and
   * writes EncodedDatasetFileName only. Default 20000.
   */
  vtkSetClampMacro(Iterations, int, 0, 100000000);
  vtkGetMacro(Iterations, int);
  ///@}

  ///@{
  /**
   * Number of surfaces in an iteration, each with its own time and noise, from 1 to 1000000; the paper has 16. Default 4.
   */
  vtkSetClampMacro(BatchSize, int, 1, 1000000);
  vtkGetMacro(BatchSize, int);
  ///@}

  /// Optimizers of the weights.
  enum Optimizers
  {
    ADAM = 0, ///< [Kingma2015], as published
    MUON = 1  ///< [Jordan2024] for the complex matrices inside the network, Adam for the rest
  };

  ///@{
  /**
   * Optimizer of the weights. Default ADAM.
   */
  vtkSetClampMacro(Optimizer, int, ADAM, MUON);
  vtkGetMacro(Optimizer, int);
  void SetOptimizerToAdam() { this->SetOptimizer(ADAM); }
  void SetOptimizerToMuon() { this->SetOptimizer(MUON); }
  ///@}

  ///@{
  /**
   * Learning rate at the end, larger than 0: it falls from LearningRate along half a cosine. With MUON it rises over the first
   * hundredth of all iterations. Default 1e-5.
   */
  vtkSetClampMacro(FinalLearningRate, double, 1e-300, std::numeric_limits<double>::max());
  vtkGetMacro(FinalLearningRate, double);
  ///@}

  ///@{
  /**
   * Largest norm of the gradient of all weights together, at least 0; 0 for no limit, as in the paper. Default 1.
   */
  vtkSetClampMacro(GradientClip, double, 0.0, std::numeric_limits<double>::max());
  vtkGetMacro(GradientClip, double);
  ///@}

  ///@{
  /**
   * Decay of the exponential average of the weights, which the model file has, from 0 to 0.999999; 0 for the weights
   * themselves. Default 0.999.
   */
  vtkSetClampMacro(WeightAveraging, double, 0.0, 0.999999);
  vtkGetMacro(WeightAveraging, double);
  ///@}

  ///@{
  /**
   * Limit of the weights of the loss by the signal-to-noise ratio, at least 0; 0 for the plain mean square, as in the
   * paper. Default 0.
   */
  vtkSetClampMacro(SnrLimit, double, 0.0, std::numeric_limits<double>::max());
  vtkGetMacro(SnrLimit, double);
  ///@}

  ///@{
  /**
   * Part of the surfaces that are seen without labels and directions, from 0 to 1, so that the model also serves samples
   * without. Default 0.1.
   */
  vtkSetClampMacro(ConditionDropout, double, 0.0, 1.0);
  vtkGetMacro(ConditionDropout, double);
  ///@}

protected:
  vtkLatentDiffusionTrainer();
  ~vtkLatentDiffusionTrainer() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestUpdateExtent(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  void Train(vtkInformationVector** inputVector, Run& run) override;

private:
  vtkLatentDiffusionTrainer(const vtkLatentDiffusionTrainer&) = delete;
  void operator=(const vtkLatentDiffusionTrainer&) = delete;

  std::string AutoencoderFileName = "field_latents";
  std::string ColorArrayName;
  std::string LabelArrayName;
  std::string DirectionArrayName;
  int NumberOfTriangulations = 16;
  int NumberOfPoints = 3000;
  std::string EncodedDatasetFileName;
  std::string SampleFileName;
  int Sizes = SMALL;
  int Channels = 0;
  int CoarseChannels = 0;
  int InputBlocks = 0;
  int CoarseBlocks = 0;
  int OutputBlocks = 0;
  int EmbeddingDimension = 64;
  int TimeSteps = 1000;
  double FirstVariance = 1e-4;
  double LastVariance = 0.02;
  bool SampleLatents = true;
  int Target = NOISE;
  int Iterations = 20000;
  int BatchSize = 4;
  int Optimizer = ADAM;
  double FinalLearningRate = 1e-5;
  double GradientClip = 1.0;
  double WeightAveraging = 0.999;
  double SnrLimit = 0.0;
  double ConditionDropout = 0.1;

  class Internals;
};

#endif
