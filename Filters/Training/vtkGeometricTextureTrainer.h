// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkGeometricTextureTrainer
 * @brief   Learns a geometric texture from one surface at several scales
 *
 * Trains the generator of "Deep Geometric Texture Synthesis" (Hertz et al. 2020, sections 3 and 4): level by level, a
 * network that displaces the points of a mesh, against a discriminator that looks at the triangles of the result and of
 * the reference (a Wasserstein GAN with gradient penalty). The model file serves targets of any shape;
 * vtkGeometricTextureSynthesizer grows the texture on them.
 *
 * @par Input
 * Port 0: the levels, a composite dataset whose leaves in order, empty ones left out, are one surface at several
 * scales, coarse to fine, as vtkMultiscaleMeshFitter makes it: vtkPolyData of triangles, each level with the triangles
 * of the one before cut into four at the midpoints of edges, in the order of vtkMultiscaleMeshFitter. The meshes must
 * have finite points, no degenerate triangle, no edge with more than two triangles and consistent winding.
 * @par
 * Port 1, optional: the template, vtkPolyData with the triangles of the first level: what a texture grows from without
 * input. Without it the first level is the template.
 * @par
 * Both ports may be left unconnected when DatasetFileName is set, and are not used then. Empty levels give an empty
 * table and no file.
 *
 * @par Output
 * A vtkTable with a row for each iteration of all levels, those before a checkpoint included, and the columns
 * iteration, level (vtkIdType), critic_loss, gradient_penalty, adversarial_loss, reconstruction_loss and learning_rate
 * (float64).
 *
 * @par Files
 * The model is written to ModelFileName at the end, and as it then is with every checkpoint. A checkpoint is written
 * every CheckpointInterval iterations, after each level, and when the update is aborted; the next update goes on from
 * there. A file is replaced only when the new one is complete. A checkpoint of other data or another recipe is an error
 * that names what differs.
 *
 * @par Cost
 * IterationsPerLevel times the number of levels, each of DiscriminatorSteps + GeneratorSteps steps, linear in the
 * number of triangles of the level. Everything random is a pure function of the seed and the iteration: the same seed
 * gives the same bits with the same number of threads on the same machine, interrupted or not. An update whose
 * checkpoint is complete only reads it.
 *
 * @sa vtkMultiscaleMeshFitter, vtkGeometricTextureSynthesizer
 */

#ifndef vtkGeometricTextureTrainer_h
#define vtkGeometricTextureTrainer_h

#include "vtkSurfaceSynthesisTrainingModule.h" // For export macro
#include "vtkTableAlgorithm.h"

#include <memory> // For std::unique_ptr
#include <string> // For std::string

class VTKSURFACESYNTHESISTRAINING_EXPORT vtkGeometricTextureTrainer : public vtkTableAlgorithm
{
public:
  static vtkGeometricTextureTrainer* New();
  vtkTypeMacro(vtkGeometricTextureTrainer, vtkTableAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// Where the networks are trained.
  enum Devices
  {
    AUTO = 0, ///< CUDA where LibTorch finds a device, else the processor
    CPU = 1,
    CUDA = 2
  };

  ///@{
  /**
   * Path of the model file that is written. Must be set. Model files are in safetensors format. Default "".
   */
  void SetModelFileName(const char* name);
  vtkGetCharFromStdStringMacro(ModelFileName);
  ///@}

  ///@{
  /**
   * Path of the checkpoint. Empty (the default) stands for ModelFileName with .checkpoint after it.
   */
  void SetCheckpointFileName(const char* name);
  vtkGetCharFromStdStringMacro(CheckpointFileName);
  ///@}

  ///@{
  /**
   * Path of a table of the losses in comma-separated values, with the columns of the output, written with each
   * checkpoint. Default "": none.
   */
  void SetLossTableFileName(const char* name);
  vtkGetCharFromStdStringMacro(LossTableFileName);
  ///@}

  ///@{
  /**
   * Number of iterations from one checkpoint to the next; at least 1. Default 500.
   */
  vtkSetClampMacro(CheckpointInterval, int, 1, VTK_INT_MAX);
  vtkGetMacro(CheckpointInterval, int);
  ///@}

  ///@{
  /**
   * Whether an update goes on from the checkpoint where there is one. Off: it begins anew, and the checkpoint is
   * replaced. Default on.
   */
  vtkSetMacro(Resume, bool);
  vtkGetMacro(Resume, bool);
  vtkBooleanMacro(Resume, bool);
  ///@}

  ///@{
  /**
   * Path of a dataset file that is trained on in place of the inputs. Dataset files are in safetensors format and hold
   * one surface at several scales; vtkMultiscaleMeshFitter writes them. Default "".
   */
  void SetDatasetFileName(const char* name);
  vtkGetCharFromStdStringMacro(DatasetFileName);
  ///@}

  ///@{
  /**
   * Name of the texture, for people; not empty. It is written into the model file. Default "texture".
   */
  void SetTextureName(const char* name);
  vtkGetCharFromStdStringMacro(TextureName);
  ///@}

  ///@{
  /**
   * Number of iterations of each level, at least 1. Default 2000.
   */
  vtkSetClampMacro(IterationsPerLevel, int, 1, 100000000);
  vtkGetMacro(IterationsPerLevel, int);
  ///@}

  ///@{
  /**
   * Steps of the discriminator in an iteration, from 1 to 1000. Default 2.
   */
  vtkSetClampMacro(DiscriminatorSteps, int, 1, 1000);
  vtkGetMacro(DiscriminatorSteps, int);
  ///@}

  ///@{
  /**
   * Steps of the generator in an iteration, from 1 to 1000. Default 3.
   */
  vtkSetClampMacro(GeneratorSteps, int, 1, 1000);
  vtkGetMacro(GeneratorSteps, int);
  ///@}

  ///@{
  /**
   * The learning rate of Adam, larger than 0. Default 5e-4.
   */
  vtkSetClampMacro(LearningRate, double, 1e-300, VTK_DOUBLE_MAX);
  vtkGetMacro(LearningRate, double);
  ///@}

  ///@{
  /**
   * Number of iterations of a level after which the learning rate is multiplied by LearningRateFactor, each time; at
   * least 1. Default 500.
   */
  vtkSetClampMacro(LearningRateInterval, int, 1, 100000000);
  vtkGetMacro(LearningRateInterval, int);
  ///@}

  ///@{
  /**
   * What the learning rate is multiplied by after each LearningRateInterval, larger than 0 and at most 1. Default 0.5.
   */
  vtkSetClampMacro(LearningRateFactor, double, 1e-300, 1.0);
  vtkGetMacro(LearningRateFactor, double);
  ///@}

  ///@{
  /**
   * The weight of the gradient penalty in the loss of the discriminator, at least 0. Default 0.1.
   */
  vtkSetClampMacro(PenaltyWeight, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(PenaltyWeight, double);
  ///@}

  ///@{
  /**
   * The weight of the squared distance from the reference in the loss of the generator, at least 0. Default 5.
   */
  vtkSetClampMacro(ReconstructionWeight, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(ReconstructionWeight, double);
  ///@}

  ///@{
  /**
   * Layers of each network, input and output included, from 3 to 32. Default 7.
   */
  vtkSetClampMacro(Layers, int, 3, 32);
  vtkGetMacro(Layers, int);
  ///@}

  ///@{
  /**
   * Channels of the first hidden layer at level 0, from 1 to 4096; they double with each level and halve with each
   * layer. Default 32.
   */
  vtkSetClampMacro(StartChannels, int, 1, 4096);
  vtkGetMacro(StartChannels, int);
  ///@}

  ///@{
  /**
   * Channels of a hidden layer at least, from 1 to 4096. Default 32.
   */
  vtkSetClampMacro(MinimumChannels, int, 1, 4096);
  vtkGetMacro(MinimumChannels, int);
  ///@}

  ///@{
  /**
   * Channels of a hidden layer at most, from 1 to 4096. Default 128.
   */
  vtkSetClampMacro(MaximumChannels, int, 1, 4096);
  vtkGetMacro(MaximumChannels, int);
  ///@}

  ///@{
  /**
   * Standard deviation of the noise on each coordinate, in mean edge lengths of a level, at least 0. Default 0.1.
   */
  vtkSetClampMacro(NoiseAmplitude, double, 0.0, 1e6);
  vtkGetMacro(NoiseAmplitude, double);
  ///@}

  ///@{
  /**
   * The seed of the first weights and the noise. Any integer; the same seed gives the same model. Default 0.
   */
  vtkSetMacro(Seed, int);
  vtkGetMacro(Seed, int);
  ///@}

  ///@{
  /**
   * Where the networks are trained. AUTO takes CUDA where LibTorch finds a device, else the processor; CUDA without a
   * device is an error. Default AUTO.
   */
  vtkSetClampMacro(Device, int, AUTO, CUDA);
  vtkGetMacro(Device, int);
  void SetDeviceToAuto() { this->SetDevice(AUTO); }
  void SetDeviceToCPU() { this->SetDevice(CPU); }
  void SetDeviceToCUDA() { this->SetDevice(CUDA); }
  ///@}

  ///@{
  /**
   * Take the levels, or the template, away again: for ParaView, which cannot name a port in doing so.
   */
  void RemoveLevels() { this->SetInputConnection(0, nullptr); }
  void RemoveTemplate() { this->SetInputConnection(1, nullptr); }
  ///@}

  /**
   * Number of iterations of all levels that the model of the last update has been trained for, those of a checkpoint
   * included; 0 when there is none.
   */
  vtkTypeInt64 GetNumberOfIterationsDone() const;

  /**
   * The device of the last update, "CPU" or "CUDA"; empty when there was none.
   */
  const char* GetDeviceInUse() const;

protected:
  vtkGeometricTextureTrainer();
  ~vtkGeometricTextureTrainer() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;

private:
  vtkGeometricTextureTrainer(const vtkGeometricTextureTrainer&) = delete;
  void operator=(const vtkGeometricTextureTrainer&) = delete;

  void SetText(std::string& property, const char* text);

  std::string ModelFileName;
  std::string CheckpointFileName;
  std::string LossTableFileName;
  int CheckpointInterval = 500;
  bool Resume = true;
  std::string DatasetFileName;
  std::string TextureName = "texture";
  int IterationsPerLevel = 2000;
  int DiscriminatorSteps = 2;
  int GeneratorSteps = 3;
  double LearningRate = 5e-4;
  int LearningRateInterval = 500;
  double LearningRateFactor = 0.5;
  double PenaltyWeight = 0.1;
  double ReconstructionWeight = 5.0;
  int Layers = 7;
  int StartChannels = 32;
  int MinimumChannels = 32;
  int MaximumChannels = 128;
  double NoiseAmplitude = 0.1;
  int Seed = 0;
  int Device = AUTO;

  class Internals;
  std::unique_ptr<Internals> Impl;
};

#endif
