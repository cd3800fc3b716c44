// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkFlowMatchingTrainer
 * @brief   Trains a flow matching model on deformations of surfaces, or on other signals on them
 *
 * Trains a PoissonNet whose velocity field carries Matérn noise to samples of a distribution ("Matérn Noise for
 * Triangulation-Agnostic Flow Matching on Meshes", section 4): rectified flow f_t = (1 - t) f_0 + t f_1 with f_0
 * noise, f_1 a sample and t uniform in [0, 1), and the loss of equation 12, in velocities and in their gradients. The
 * model file serves surfaces with any triangulation; vtkFlowMatchingSampler and vtkFlowMatchingDeformer draw samples
 * of it. Files, device, seed and learning rate are those of vtkModelTrainer, but the default of LearningRate is 0.02.
 *
 * @par Input
 * Port 0: the source, a vtkPolyData with triangles, polygons or strips, float or double points; or a composite
 * dataset, whose leaves in order are several sources. Polygons and strips are triangulated; points that no polygon or
 * strip uses are left out. A source must have finite points, no degenerate triangle, no edge with more than two
 * triangles, consistent winding and one component.
 * @par
 * Port 1: the samples. With one source each surface here is a sample: a vtkPolyData, or the leaves of a composite
 * dataset in order. With several sources this must be a composite dataset with as many blocks, and block k, a surface
 * or composite itself, holds the samples of source k. Where port 1 has time steps, the filter requests each of them
 * in turn, and each adds its samples; a source that changes in time is taken as it is at the first. Samples have the
 * points and polygons of their source, in the same order; empty ones are left out. Without SignalArrayName a sample
 * is the positions of its points, in the coordinates of the source; its shape, size and orientation are learnt, its
 * place is not. Values must be finite at the points that polygons use.
 * @par
 * Several sources of different shape need a positional encoding, which EncoderIterations trains first and
 * EncoderFileName names, or WithoutEncoder.
 * @par
 * Optional arrays on port 1: the point array SignalArrayName, any numeric type, any number of components.
 * @par
 * Both ports may be left unconnected when DatasetFileName is set: a file with one signal on one surface or several,
 * which the Python package and the library write.
 *
 * @par Output
 * The table of vtkModelTrainer with the columns iteration (vtkIdType), loss, vertex_loss, jacobian_loss, gradient_norm
 * (before it is clipped), learning_rate and loss_1 to loss_8 (float64); loss is VertexWeight vertex_loss + JacobianWeight
 * jacobian_loss, and loss_k the mean loss of the samples at times in [(k - 1) / 8, k / 8). It keeps its number in
 * iterations without such a sample, and is 0 before the first one.
 *
 * @par Files
 * Those of vtkModelTrainer. Iterations, LearningRateSchedule, Milestones, SourceMemory, Device and the names and times of files
 * may change between an update and the next, which goes on from the checkpoint.
 *
 * @par Cost
 * Iterations times BatchSize evaluations of the network and of its derivative, each linear in the number of triangles
 * and quadratic in Width. Memory grows with BatchSize / SourcesPerBatch, Width, Blocks and the number of points, and with the
 * number of sources up to SourceMemory.
 * Everything random is a pure function of the seed and the iteration: the same seed gives the same bits with the same
 * number of threads on the same machine, interrupted or not. An update whose checkpoint is complete only reads it.
 *
 * @par Errors
 * Those of vtkModelTrainer, and one error and an empty table for: a source or sample as above; SourcesPerBatch that does
 * not divide BatchSize; samples that do not vary; several sources of different shape without an encoder, or WithoutEncoder
 * with one; EncoderIterations with one source, or with sources that have other polygons than the first.
 *
 * @sa vtkModelTrainer, vtkMaternNoiseFilter, vtkEnsembleMetrics, vtkGroupDataSetsFilter
 */

#ifndef vtkFlowMatchingTrainer_h
#define vtkFlowMatchingTrainer_h

#include "vtkModelTrainer.h"
#include "vtkSurfaceSynthesisTrainingModule.h" // For export macro

#include <memory> // For std::unique_ptr
#include <string> // For std::string
#include <vector> // For std::vector

class VTKSURFACESYNTHESISTRAINING_EXPORT vtkFlowMatchingTrainer : public vtkModelTrainer
{
public:
  static vtkFlowMatchingTrainer* New();
  vtkTypeMacro(vtkFlowMatchingTrainer, vtkModelTrainer);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// The distributions of the noise; see vtkMaternNoiseFilter.
  enum NoiseModels
  {
    MATERN = 0,     ///< Matérn noise: independent of the triangulation
    PER_VERTEX = 1, ///< for comparison: depends on the triangulation
    WHITE = 2,      ///< for comparison
    UNSCREENED = 3, ///< for comparison
    SPECTRAL = 4    ///< for comparison
  };

  ///@{
  /**
   * Name of the point array of the samples that is learnt, with any number of components. A surface without an array of
   * this name has a sample in each of the arrays called SignalArrayName_0, SignalArrayName_1 and so on, as
   * vtkMaternNoiseFilter names its samples. Empty (the default) stands for the positions; an array called Position is
   * taken for deformed positions, too.
   */
  void SetSignalArrayName(const char* name);
  vtkGetCharFromStdStringMacro(SignalArrayName);
  ///@}

  ///@{
  /**
   * Path of a PoissonNet model file that predicts a positional encoding from positions (section 5.1.2 of the paper); it
   * becomes part of the model. Needed for several sources of different shape only. Read when EncoderIterations is 0,
   * else written. Default "": none, or with EncoderIterations ModelFileName with .encoder after it.
   */
  void SetEncoderFileName(const char* name);
  vtkGetCharFromStdStringMacro(EncoderFileName);
  ///@}

  ///@{
  /**
   * Path of a flow matching model file whose weights the training begins with: to go on from few triangles to many, or with
   * other samples. Noise, Prediction and the sizes of the network are then those of that model, whatever the properties for
   * them say, and so is the encoder, unless EncoderFileName names another one with as many channels; EncoderIterations must
   * be 0. Default "": random weights.
   */
  void SetInitialModelFileName(const char* name);
  vtkGetCharFromStdStringMacro(InitialModelFileName);
  ///@}

  ///@{
  /**
   * Number of iterations in which an encoder is trained before the model, at least 0. The sources must correspond
   * then: all have the polygons of the first, the reference. The encoder learns to predict the lowest eigenfunctions of
   * the Laplacian of the reference from positions, on BatchSize surfaces in an iteration: sources, and samples that are
   * positions. The sizes of its network, LearningRate and LearningRateFactor, GradientClip, WeightAveraging, Seed,
   * Device, Resume and CheckpointInterval are those of the model. Its checkpoint is EncoderFileName with .checkpoint
   * after it, and where LossTableFileName is set, its losses go to EncoderFileName with .csv after it. A model depends
   * on its encoder: train on with the same number; a larger one is an error before either is trained. Default 0: none is
   * trained.
   */
  vtkSetClampMacro(EncoderIterations, int, 0, 100000000);
  vtkGetMacro(EncoderIterations, int);
  ///@}

  ///@{
  /**
   * Number of eigenfunctions that the encoder which is trained predicts, at least 1; the reference must have two points
   * more. Default 64, as in the paper.
   */
  vtkSetClampMacro(NumberOfEigenfunctions, int, 1, 10000);
  vtkGetMacro(NumberOfEigenfunctions, int);
  ///@}

  ///@{
  /**
   * Largest part of the edges of each surface that the training of the encoder splits at random, from 0 to 1; each surface
   * of an iteration draws its own, up to this. Above 0 an encoder predicts better on triangulations other than that of the
   * sources, and takes up to four times as long to train. Default 0.
   */
  vtkSetClampMacro(EncoderEdgeSplits, double, 0.0, 1.0);
  vtkGetMacro(EncoderEdgeSplits, double);
  ///@}

  ///@{
  /**
   * Trains on sources of different shape without an encoder, for comparison: the network is told positions alone, which mean
   * something else on each shape. Such sources are an error otherwise. EncoderFileName must be empty and EncoderIterations 0
   * then. Default off.
   */
  vtkSetMacro(WithoutEncoder, bool);
  vtkGetMacro(WithoutEncoder, bool);
  vtkBooleanMacro(WithoutEncoder, bool);
  ///@}

  /// Quantities that the network can predict.
  enum Predictions
  {
    AUTOMATIC = -1,    ///< DATA for positions, PRECONDITIONED for other signals
    VELOCITY = 0,      ///< the velocity, as published
    DATA = 1,          ///< the data at the end of the flow
    PRECONDITIONED = 2 ///< a mixture of data and noise of the same size at all times
  };

  ///@{
  /**
   * What the network predicts. With DATA and PRECONDITIONED its input is relative to the source and has the same size at all
   * times. DATA: the velocity is what leads to the predicted data in the time that is left, and errors near the end of the flow
   * weigh at most 30 times as much as at its beginning; what a model leaves alone is that of the source, such as its relief.
   * PRECONDITIONED: the data are a mixture of the state and of what the network predicts, with less and less of the latter
   * toward the end of the flow (Karras et al., Elucidating the design space of diffusion-based generative models, 2022), so
   * that signals are sharp. VELOCITY is the paper's. The model file says which it is. Default AUTOMATIC: DATA for positions,
   * PRECONDITIONED for other signals.
   */
  vtkSetClampMacro(Prediction, int, AUTOMATIC, PRECONDITIONED);
  vtkGetMacro(Prediction, int);
  void SetPredictionToAutomatic() { this->SetPrediction(AUTOMATIC); }
  void SetPredictionToVelocity() { this->SetPrediction(VELOCITY); }
  void SetPredictionToData() { this->SetPrediction(DATA); }
  void SetPredictionToPreconditioned() { this->SetPrediction(PRECONDITIONED); }
  ///@}

  ///@{
  /**
   * Number of hidden channels, at least 1; the paper has 128. Time grows with its square. Default 64.
   */
  vtkSetClampMacro(Width, int, 1, 100000);
  vtkGetMacro(Width, int);
  ///@}

  ///@{
  /**
   * Number of blocks of the network, at least 1; the paper has 5. Default 4.
   */
  vtkSetClampMacro(Blocks, int, 1, 1000);
  vtkGetMacro(Blocks, int);
  ///@}

  ///@{
  /**
   * Number of layers of the maps between gradients in each block, at least 1. Default 3.
   */
  vtkSetClampMacro(ComplexLayers, int, 1, 100);
  vtkGetMacro(ComplexLayers, int);
  ///@}

  ///@{
  /**
   * Inner products of gradients as further inputs of the maps at the points. With them a model serves triangulations other than
   * that of its training less well: they grow with the gradients of the noise, and jump at creases. Default off.
   */
  vtkSetMacro(InnerProducts, bool);
  vtkGetMacro(InnerProducts, bool);
  vtkBooleanMacro(InnerProducts, bool);
  ///@}

  ///@{
  /**
   * Distribution of the noise that the flow begins with. Only Matérn noise gives a model that does not depend on
   * the triangulation; the others are for comparison. Default MATERN.
   */
  vtkSetClampMacro(NoiseModel, int, MATERN, SPECTRAL);
  vtkGetMacro(NoiseModel, int);
  void SetNoiseModelToMatern() { this->SetNoiseModel(MATERN); }
  void SetNoiseModelToPerVertex() { this->SetNoiseModel(PER_VERTEX); }
  void SetNoiseModelToWhite() { this->SetNoiseModel(WHITE); }
  void SetNoiseModelToUnscreened() { this->SetNoiseModel(UNSCREENED); }
  void SetNoiseModelToSpectral() { this->SetNoiseModel(SPECTRAL); }
  ///@}

  ///@{
  /**
   * Screening term tau of MATERN and SPECTRAL noise on the surface scaled to area 1, larger than 0; larger is
   * rougher. Default 100, the value of the paper.
   */
  vtkSetClampMacro(Screening, double, 1e-300, VTK_DOUBLE_MAX);
  vtkGetMacro(Screening, double);
  ///@}

  ///@{
  /**
   * Smoothing of the noise f: (M + s L) g = M f, which multiplies spectral coefficients by 1 / (1 + s lambda), with s this
   * number of squared mean edge lengths, in the mean over the sources scaled to area 1, at least 0. Negative: 0 for positions
   * and 1 for other signals. The network sees gradients; those of noise that is not smoothed grow with the number of vertices,
   * and a model of a signal can fail on triangulations much finer than that of its training. Models of positions do not, and
   * with smoothed noise they vary less than the data. 0 is the noise of the paper. Default -1.
   */
  vtkSetClampMacro(NoiseSmoothing, double, -1.0, VTK_DOUBLE_MAX);
  vtkGetMacro(NoiseSmoothing, double);
  ///@}

  ///@{
  /**
   * Factor of the noise, at least 0. 0 (the default) stands for the factor that lets noise vary as much as
   * the samples do about their mean, in the mean over the sources.
   */
  vtkSetClampMacro(NoiseScale, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(NoiseScale, double);
  ///@}

  ///@{
  /**
   * Number of eigenpairs of SPECTRAL noise, at least 1. Default 256.
   */
  vtkSetClampMacro(NumberOfEigenpairs, int, 1, 1000000);
  vtkGetMacro(NumberOfEigenpairs, int);
  ///@}

  ///@{
  /**
   * Number of iterations in all, those of a checkpoint included, at least 1; the paper has 160,000. Iterations times
   * BatchSize must be below 2^32. Default 3000.
   */
  vtkSetClampMacro(Iterations, int, 1, 100000000);
  vtkGetMacro(Iterations, int);
  ///@}

  ///@{
  /**
   * Number of samples in an iteration, at least 1; the paper has 32. Default 32.
   */
  vtkSetClampMacro(BatchSize, int, 1, 100000);
  vtkGetMacro(BatchSize, int);
  ///@}

  ///@{
  /**
   * Number of sources that the samples of an iteration come from, at least 1; must divide BatchSize. Default 1.
   */
  vtkSetClampMacro(SourcesPerBatch, int, 1, 100000);
  vtkGetMacro(SourcesPerBatch, int);
  ///@}

  ///@{
  /**
   * Limit in MiB of the memory that operators and factorisations of the sources take, on processor and device together, at
   * least 0: about 1.6 KiB for each point on the processor, and 4 bytes for each pair of points of a source on CUDA. Where not
   * all fit, those in use last are kept, and others are built again when an iteration draws their source, at most once for the
   * BatchSize / SourcesPerBatch samples that it takes from it. Sources of a batch, their order and all bits of the result are
   * the same with every limit. A single source that is larger is kept while it is in use, and while the sources are prepared
   * there is one more. Surfaces, samples and encodings stay in memory; encoders are trained without such memory. Default 8192.
   */
  vtkSetClampMacro(SourceMemory, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(SourceMemory, double);
  ///@}

  /// Optimizers of the weights.
  enum Optimizers
  {
    ADAM = 0, ///< [Kingma2015], as published
    MUON = 1  ///< [Jordan2024] for the matrices inside the network, Adam for the rest
  };

  ///@{
  /**
   * Optimizer of the weights. MUON learns in a fraction of the iterations that ADAM takes, at a LearningRate of 0.01 to 0.02;
   * ADAM is the paper's, at 5e-4. Encoders are trained with it, too. Default MUON.
   */
  vtkSetClampMacro(Optimizer, int, ADAM, MUON);
  vtkGetMacro(Optimizer, int);
  void SetOptimizerToAdam() { this->SetOptimizer(ADAM); }
  void SetOptimizerToMuon() { this->SetOptimizer(MUON); }
  ///@}

  /// Courses of the learning rate.
  enum LearningRateSchedules
  {
    MILESTONES = 0, ///< falls at milestones, as published
    COSINE = 1      ///< rises over the first hundredth of all iterations, then falls to 0 along half a cosine
  };

  ///@{
  /**
   * Course of the learning rate. With COSINE, Milestones and LearningRateFactor have no effect, and a training with more
   * iterations than its checkpoint was begun with goes on at the rate of the longer course. MILESTONES is the paper's.
   * Default COSINE.
   */
  vtkSetClampMacro(LearningRateSchedule, int, MILESTONES, COSINE);
  vtkGetMacro(LearningRateSchedule, int);
  void SetLearningRateScheduleToMilestones() { this->SetLearningRateSchedule(MILESTONES); }
  void SetLearningRateScheduleToCosine() { this->SetLearningRateSchedule(COSINE); }
  ///@}

  ///@{
  /**
   * Iterations after which the learning rate is multiplied by LearningRateFactor with MILESTONES, at least 0 each. None
   * stands for one after a quarter of all iterations. SetNumberOfMilestones() clamps to 0 and more and fills up with 0;
   * SetMilestone() does nothing for an index out of range, and GetMilestone() returns 0. Default none.
   */
  void SetNumberOfMilestones(int number);
  int GetNumberOfMilestones() const { return static_cast<int>(this->Milestones.size()); }
  void SetMilestone(int index, int iteration);
  int GetMilestone(int index) const;
  ///@}

  ///@{
  /**
   * Factor of the learning rate at each milestone, larger than 0 and at most 1. Default 0.2.
   */
  vtkSetClampMacro(LearningRateFactor, double, 1e-300, 1.0);
  vtkGetMacro(LearningRateFactor, double);
  ///@}

  ///@{
  /**
   * Largest norm of the gradient of all weights together, at least 0; longer ones are scaled down to it. 0 stands
   * for no limit. Default 1.
   */
  vtkSetClampMacro(GradientClip, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(GradientClip, double);
  ///@}

  ///@{
  /**
   * Weight of the loss in velocities, at least 0. Default 1.
   */
  vtkSetClampMacro(VertexWeight, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(VertexWeight, double);
  ///@}

  ///@{
  /**
   * Weight of the loss in the gradients of velocities, at least 0; one of both weights must be larger than 0.
   * Default 1.
   */
  vtkSetClampMacro(JacobianWeight, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(JacobianWeight, double);
  ///@}

  ///@{
  /**
   * Decay of the exponential moving average of the weights, which becomes the model, at least 0 and below 1; 0 stands for
   * the last weights themselves, as in the paper. Default 0.99.
   */
  vtkSetClampMacro(WeightAveraging, double, 0.0, 0.9999999);
  vtkGetMacro(WeightAveraging, double);
  ///@}

  ///@{
  /**
   * Removes the source, or the samples: for ParaView, which cannot name a port in doing so.
   */
  void RemoveSource() { this->SetInputConnection(0, nullptr); }
  void RemoveSamples() { this->SetInputConnection(1, nullptr); }
  ///@}

  /**
   * Mean loss of the last twentieth of the iterations of the encoder that the last update has trained, those of a
   * checkpoint included: the mean squared error of eigenfunctions whose mean square is 1. -1 when it has trained none.
   */
  double GetEncoderLoss() const;

protected:
  vtkFlowMatchingTrainer();
  ~vtkFlowMatchingTrainer() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestInformation(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int RequestUpdateExtent(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  void ReadInputs(vtkInformationVector** inputVector) override;
  void Train(vtkInformationVector** inputVector, Run& run) override;

private:
  vtkFlowMatchingTrainer(const vtkFlowMatchingTrainer&) = delete;
  void operator=(const vtkFlowMatchingTrainer&) = delete;

  std::string SignalArrayName;
  std::string EncoderFileName;
  std::string InitialModelFileName;
  int EncoderIterations = 0;
  int NumberOfEigenfunctions = 64;
  double EncoderEdgeSplits = 0.0;
  bool WithoutEncoder = false;
  int Width = 64;
  int Blocks = 4;
  int ComplexLayers = 3;
  bool InnerProducts = false;
  int Prediction = AUTOMATIC;
  int NoiseModel = MATERN;
  double Screening = 100.0;
  double NoiseSmoothing = -1.0;
  double NoiseScale = 0.0;
  int NumberOfEigenpairs = 256;
  int Iterations = 3000;
  int BatchSize = 32;
  int SourcesPerBatch = 1;
  double SourceMemory = 8192.0;
  int Optimizer = MUON;
  int LearningRateSchedule = COSINE;
  std::vector<int> Milestones;
  double LearningRateFactor = 0.2;
  double GradientClip = 1.0;
  double VertexWeight = 1.0;
  double JacobianWeight = 1.0;
  double WeightAveraging = 0.99;

  class Internals;
  std::unique_ptr<Internals> Impl;
};

#endif
