// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkGeometricTextureTrainer
 * @brief   Learns a geometric texture from one surface at several scales, or from several
 *
 * Trains the generator of "Deep Geometric Texture Synthesis" (Hertz et al. 2020, sections 3 and 4): level by level, a
 * network that displaces the points of a mesh, against a discriminator that looks at the triangles of the result and of
 * the reference (a Wasserstein GAN with gradient penalty). Two other objectives train the same network without a
 * discriminator, a sliced Wasserstein distance and flow matching. The model file serves targets of any shape;
 * vtkGeometricTextureSynthesizer synthesizes the texture on them. Files, device, seed and learning rate are those of
 * vtkModelTrainer.
 *
 * @par Input
 * Port 0: the levels, a composite dataset whose leaves in order, empty ones left out, are one surface at several
 * scales, coarse to fine, as vtkMultiscaleMeshFitter makes it: vtkPolyData of triangles, each level with the triangles
 * of the one before cut into four at the midpoints of edges, in the order of vtkMultiscaleMeshFitter. The meshes must
 * have finite points, no degenerate triangle, no edge with more than two triangles and consistent winding. The port
 * takes several connections: surfaces of other curvature with the same texture and as many levels, of which each
 * iteration draws one. Their triangles should be of the same size beside the features of the texture; the model file
 * has the template of the first, and statistics of channels over all.
 * @par
 * Port 1, optional: the template, vtkPolyData with the triangles of the first level: the surface that is textured where
 * vtkGeometricTextureSynthesizer has no input. Without it the first level is the template.
 * @par
 * Both ports may be left unconnected when DatasetFileName is set: a file with one surface at several scales, which
 * vtkMultiscaleMeshFitter writes. Surfaces of SetReferenceFileName() follow those of the inputs or of that file.
 *
 * @par Output
 * The table of vtkModelTrainer, with a row for each iteration of all levels and the columns iteration, level
 * (vtkIdType), critic_loss, gradient_penalty, adversarial_loss, reconstruction_loss and learning_rate (float64). Without a
 * discriminator the first two losses are 0, and adversarial_loss is the sliced Wasserstein distance, or 0 of a flow, whose
 * reconstruction_loss is the mean squared error of its velocity.
 *
 * @par Files
 * Those of vtkModelTrainer; a checkpoint is also written after each level. While the training goes on, the model file has
 * no statistics of the reference, which take seconds to measure. TextureName, Device and the names and times
 * of files may change between an update and the next, which goes on from the checkpoint.
 *
 * @par Cost
 * IterationsPerLevel times the number of levels, or those of IterationsOfLevels, each of DiscriminatorSteps +
 * GeneratorSteps steps, without a discriminator of the latter alone, linear in the number of triangles of the level.
 * Everything random is a pure function of the seed and the iteration: the same seed gives the same bits with the same
 * number of threads on the same machine, interrupted or not. An update whose checkpoint is complete only reads it.
 *
 * @sa vtkModelTrainer, vtkMultiscaleMeshFitter, vtkGeometricTextureSynthesizer
 */

#ifndef vtkGeometricTextureTrainer_h
#define vtkGeometricTextureTrainer_h

#include "vtkDeprecation.h" // For VTK_DEPRECATION
#include "vtkModelTrainer.h"
#include "vtkSurfaceSynthesisTrainingModule.h" // For export macro

#include <string> // For std::string
#include <vector> // For std::vector

class VTKSURFACESYNTHESISTRAINING_EXPORT vtkGeometricTextureTrainer : public vtkModelTrainer
{
public:
  static vtkGeometricTextureTrainer* New();
  vtkTypeMacro(vtkGeometricTextureTrainer, vtkModelTrainer);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * Name of the texture, for people; not empty. It is written into the model file. Default "texture".
   */
  void SetTextureName(const char* name);
  vtkGetCharFromStdStringMacro(TextureName);
  ///@}

  ///@{
  /**
   * Dataset files of further surfaces with the same texture and as many levels; empty names are none.
   * SetNumberOfReferenceFileNames() clamps to 0 and more and fills up with empty names; SetReferenceFileName() does
   * nothing for an index out of range, and GetReferenceFileName() returns null. Default none.
   */
  void SetNumberOfReferenceFileNames(int number);
  int GetNumberOfReferenceFileNames() const { return static_cast<int>(this->ReferenceFileNames.size()); }
  void SetReferenceFileName(int index, const char* name);
  const char* GetReferenceFileName(int index) const;
  ///@}

  /// Objectives of the generators: values of Objective.
  enum Objectives
  {
    ADVERSARIAL = 0,        ///< discriminators, as published
    SLICED_WASSERSTEIN = 1, ///< the sliced Wasserstein distance of features of triangles, and of 3 and 6 rings
    FLOW_MATCHING = 2       ///< the velocity of a flow from noise to the displacements of the reference, level by level
  };

  ///@{
  /**
   * What the generators learn by. With SLICED_WASSERSTEIN the distance of vtkGeometricTextureDistance of 1, 3 and 6
   * rings, in as many random directions as NumberOfProjections, takes the place of the discriminator. With
   * FLOW_MATCHING each level learns to turn noise into the displacements of the reference, in FlowSteps evaluations
   * of the network at each level of a synthesis; such models do not reconstruct the reference. With both
   * there is no discriminator and no penalty, and ReconstructionWeight is not used by a flow; DiscriminatorSteps still
   * numbers the random draws, so that other numbers give other models. Default FLOW_MATCHING, which makes better
   * textures in less time; ADVERSARIAL is the published recipe, which other properties default to.
   */
  vtkSetClampMacro(Objective, int, ADVERSARIAL, FLOW_MATCHING);
  vtkGetMacro(Objective, int);
  void SetObjectiveToAdversarial() { this->SetObjective(ADVERSARIAL); }
  void SetObjectiveToSlicedWasserstein() { this->SetObjective(SLICED_WASSERSTEIN); }
  void SetObjectiveToFlowMatching() { this->SetObjective(FLOW_MATCHING); }
  ///@}

  ///@{
  /**
   * Steps of the flow at each level of a synthesis, from 1 to 1000. It is written into the model file. Default 10.
   */
  vtkSetClampMacro(FlowSteps, int, 1, 1000);
  vtkGetMacro(FlowSteps, int);
  ///@}

  ///@{
  /**
   * Of a flow, largest standard deviation of the noise that each coordinate of the level before gets in the training, in
   * mean edge lengths of that level, at least 0: in a synthesis that level is never quite the reference's (conditioning
   * augmentation [Ho2022]). Default 0.1.
   */
  vtkSetClampMacro(BaseNoiseAmplitude, double, 0.0, 1e6);
  vtkGetMacro(BaseNoiseAmplitude, double);
  ///@}

  ///@{
  /**
   * Of a flow, number of samples of the level before that a level learns on, from 0 to 100: features are where the
   * reference has them, and shaped as the level before shapes them in a synthesis [Meng2022]. With 0 the levels of the
   * reference take their place. Default 8.
   */
  vtkSetClampMacro(NumberOfBaseSamples, int, 0, 100);
  vtkGetMacro(NumberOfBaseSamples, int);
  ///@}

  ///@{
  /**
   * Random directions of the sliced Wasserstein distance in each step, from 1 to 10000. Default 64.
   */
  vtkSetClampMacro(NumberOfProjections, int, 1, 10000);
  vtkGetMacro(NumberOfProjections, int);
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
   * Number of iterations of each level in turn, at least 1, as many as there are levels; none: IterationsPerLevel of
   * each. Coarse levels, where features are placed, take a fraction of the time of the finest one.
   * SetNumberOfIterationsOfLevels() clamps to 0 and more and fills up with IterationsPerLevel; SetIterationsOfLevel()
   * does nothing for an index out of range, and GetIterationsOfLevel() returns 0. Default none.
   */
  void SetNumberOfIterationsOfLevels(int number);
  int GetNumberOfIterationsOfLevels() const { return static_cast<int>(this->IterationsOfLevels.size()); }
  void SetIterationsOfLevel(int index, int iterations);
  int GetIterationsOfLevel(int index) const;
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
   * Number of iterations of a level after which the learning rate is multiplied by LearningRateFactor, each time, at
   * least 0; 0: a quarter of the iterations of the level. Default 500.
   */
  vtkSetClampMacro(LearningRateInterval, int, 0, 100000000);
  vtkGetMacro(LearningRateInterval, int);
  ///@}

  ///@{
  /**
   * Factor of the learning rate after each LearningRateInterval, larger than 0 and at most 1. Default 0.5.
   */
  vtkSetClampMacro(LearningRateFactor, double, 1e-300, 1.0);
  vtkGetMacro(LearningRateFactor, double);
  ///@}

  ///@{
  /**
   * Weight of the gradient penalty in the loss of the discriminator, at least 0. Default 0.1.
   */
  vtkSetClampMacro(PenaltyWeight, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(PenaltyWeight, double);
  ///@}

  ///@{
  /**
   * Steps of the discriminator from one gradient penalty to the next, which weighs as many times as much, from 1 to
   * 1000; 1: a penalty in each step, as published. Default 1.
   */
  vtkSetClampMacro(PenaltyInterval, int, 1, 1000);
  vtkGetMacro(PenaltyInterval, int);
  ///@}

  ///@{
  /**
   * Weight of the squared distance from the reference in the loss of the generator, at least 0. Default 5.
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
   * Smallest number of channels of a hidden layer, from 1 to 4096. Default 32.
   */
  vtkSetClampMacro(MinimumChannels, int, 1, 4096);
  vtkGetMacro(MinimumChannels, int);
  ///@}

  ///@{
  /**
   * Deprecated names of SetMinimumChannels() and GetMinimumChannels().
   */
  VTK_DEPRECATION("Use SetMinimumChannels()")
  void SetLeastChannels(int channels) { this->SetMinimumChannels(channels); }
  VTK_DEPRECATION("Use GetMinimumChannels()")
  int GetLeastChannels() { return this->GetMinimumChannels(); }
  ///@}

  ///@{
  /**
   * Largest number of channels of a hidden layer, from 1 to 4096. Default 128.
   */
  vtkSetClampMacro(MaximumChannels, int, 1, 4096);
  vtkGetMacro(MaximumChannels, int);
  ///@}

  ///@{
  /**
   * Deprecated names of SetMaximumChannels() and GetMaximumChannels().
   */
  VTK_DEPRECATION("Use SetMaximumChannels()")
  void SetMostChannels(int channels) { this->SetMaximumChannels(channels); }
  VTK_DEPRECATION("Use GetMaximumChannels()")
  int GetMostChannels() { return this->GetMaximumChannels(); }
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
   * Removes the levels, or the template: for ParaView, which cannot name a port in doing so.
   */
  void RemoveLevels() { this->SetInputConnection(0, nullptr); }
  void RemoveTemplate() { this->SetInputConnection(1, nullptr); }
  ///@}

protected:
  vtkGeometricTextureTrainer();
  ~vtkGeometricTextureTrainer() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  void Train(vtkInformationVector** inputVector, Run& run) override;

private:
  vtkGeometricTextureTrainer(const vtkGeometricTextureTrainer&) = delete;
  void operator=(const vtkGeometricTextureTrainer&) = delete;

  class Internals;

  std::string TextureName = "texture";
  std::vector<std::string> ReferenceFileNames;
  int Objective = FLOW_MATCHING;
  int FlowSteps = 10;
  double BaseNoiseAmplitude = 0.1;
  int NumberOfBaseSamples = 8;
  int NumberOfProjections = 64;
  int IterationsPerLevel = 2000;
  std::vector<int> IterationsOfLevels;
  int DiscriminatorSteps = 2;
  int GeneratorSteps = 3;
  int LearningRateInterval = 500;
  double LearningRateFactor = 0.5;
  double PenaltyWeight = 0.1;
  int PenaltyInterval = 1;
  double ReconstructionWeight = 5.0;
  int Layers = 7;
  int StartChannels = 32;
  int MinimumChannels = 32;
  int MaximumChannels = 128;
  double NoiseAmplitude = 0.1;
};

#endif
