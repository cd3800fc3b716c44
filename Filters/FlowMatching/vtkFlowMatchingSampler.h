// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkFlowMatchingSampler
 * @brief   Generates signals on surfaces with a trained flow matching model
 *
 * Flow matching learns a velocity field v(f, t) that carries noise f(0) to a signal f(1) like those it was trained on:
 * df/dt = v(f, t). Here the signal is a function on a surface, the noise is Matérn noise and the velocity field is a
 * PoissonNet. None of them depends on the triangulation: a model that was trained on one triangulation generates on
 * any other of the same shape ([Lipman2023]; [Kuai2026], sections 4 and 5.3.2). The signal is any number of components
 * at each point; vtkFlowMatchingDeformer generates the positions of the points.
 *
 * @par Model file
 * safetensors, as vtkFlowMatchingTrainer writes it: the metadata `architecture` ("flow_matching"), `format_version`
 * ("1") and `flow_matching` (the signal and the noise), and the networks `velocity` and, for models of many surfaces,
 * `encoder`. Files are checked before use; a damaged file, or one without such a model, is an error that names the
 * cause. A file is read once, and again in an update after its size or time of modification has changed.
 *
 * @par Input
 * vtkPolyData with triangles, polygons or strips, float or double points, open or closed, of any size and position, in
 * the orientation of the surface of the training; or a composite dataset of such blocks. Polygons and strips are
 * triangulated for the computation only. Vertices and lines are ignored, and so are points that no polygon or strip
 * uses. The mesh must have finite points, no degenerate triangle, no edge with more than two triangles, consistent
 * winding (the network is not mirror-invariant) and one component (a Poisson equation leaves the constant on each
 * further component undetermined; switch ComponentCoupling on for parts that belong together, such as eyes in a body,
 * or split a mesh with vtkPolyDataConnectivityFilter and give its parts as blocks). The error message names the defect,
 * the first offending cell or point and the filter that repairs it. A warning is given, once for each mesh, where good
 * samples are unlikely: for a surface whose second moments differ from those of the training, because it has another
 * shape or orientation, and for a closed surface whose faces point inwards. A part of the surface of the training, or a
 * copy with holes, has another area and centroid, by which models place and scale it: NormalizationArea and
 * NormalizationCenter give those of the whole surface. The warning then tells of second moments beyond those of the
 * whole. Samples on a surface with holes are better, and finite more often, where vtkSurfaceRepairFilter has closed them
 * first. A composite input is processed block by block, with noise that differs between blocks; a block that cannot be
 * processed is reported and left empty, the others are not affected. Empty input gives empty output.
 *
 * @par Output
 * The input, untouched, plus two float64 point arrays with the components of the signal: SignalArrayName, the generated
 * signal, and InitialNoiseArrayName, the noise that it starts from, in the units of the signal and about 0: at flow
 * time 0 the signal is its mean (that of the training or, for positions, the centroid of the surface) plus the initial
 * noise. Points that no polygon or strip uses get 0 in both. The signal becomes the active scalars and, with three
 * components, the active vectors, which vtkWarpVector takes, where the input has none. For several samples the output is a vtkMultiBlockDataSet
 * with the surface, or for a composite input a tree of surfaces, for each sample, in blocks that are named "Sample 0",
 * "Sample 1", ...
 *
 * @par Flow time
 * With OutputTrajectory the time of the pipeline is flow time: the filter announces the time steps 0, 1 /
 * NumberOfSteps, ..., 1 and outputs the state at the requested time: linear between two steps, constant before 0 and
 * after 1. The state at 1 is the corrected one (NumberOfCorrections). All states are kept, so that a change of time
 * costs no evaluation of the network. The input is then the one that its source holds, or outputs without a requested
 * time. An update without a requested time, and one without OutputTrajectory, outputs flow time 1.
 *
 * @par Cost
 * Operators and factorisations once for each mesh and model, kept until one of them changes; one solve and
 * NumberOfSteps evaluations of the network (2 NumberOfSteps for MIDPOINT, 4 NumberOfSteps for RUNGE_KUTTA_4), and one
 * for each correction, for each sample. Samples are kept too: an update evaluates the network only for samples that the
 * last one lacks. Memory for them: 8 bytes for each sample, point and component, with OutputTrajectory 4 (NumberOfSteps
 * + 1) bytes.
 *
 * A sample depends on the model, the mesh, Seed, its number and Temperature (or the noise that is given), NumberOfSteps,
 * Integrator and NumberOfCorrections alone: it has the same bits for every number of threads, and alone or in a batch.
 * Another kind of processor may give other last bits: Reproducibility in README.md.
 *
 * @sa vtkFlowMatchingDeformer, vtkMaternNoiseFilter, vtkPoissonNetFilter, vtkSurfaceRepairFilter
 */

#ifndef vtkFlowMatchingSampler_h
#define vtkFlowMatchingSampler_h

#include "vtkPassInputTypeAlgorithm.h"
#include "vtkSurfaceSynthesisFlowMatchingModule.h" // For export macro

#include <memory>  // For std::unique_ptr
#include <string>  // For std::string
#include <utility> // For std::pair
#include <vector>  // For std::vector

class vtkDoubleArray;
class vtkPolyData;
class vtkStringArray;

class VTKSURFACESYNTHESISFLOWMATCHING_EXPORT vtkFlowMatchingSampler : public vtkPassInputTypeAlgorithm
{
public:
  static vtkFlowMatchingSampler* New();
  vtkTypeMacro(vtkFlowMatchingSampler, vtkPassInputTypeAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// Integrators of df/dt = v(f, t) over a step h.
  enum Integrators
  {
    EULER = 0,        ///< f + h v(f, t): one evaluation of the network, first order
    MIDPOINT = 1,     ///< f + h v(f + h/2 v(f, t), t + h/2): two evaluations, second order
    RUNGE_KUTTA_4 = 2 ///< the classical Runge-Kutta method: four evaluations, fourth order
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
   * Seed of the random numbers, any integer. Each seed gives different noise and samples. The same seed gives different
   * samples on another triangulation. Default 0.
   */
  vtkSetMacro(Seed, int);
  vtkGetMacro(Seed, int);
  ///@}

  ///@{
  /**
   * Name of a point array of the input with the initial noise, in place of that of Seed. The initial noise of a sample
   * on another triangulation, transferred as a point array (by subdivision, remeshing or resampling), gives the same
   * sample on this one. It must have the components of the signal, in its units and about 0, and the number of samples
   * must be 1. Its mean over the surface is removed where the signal are positions. On several MPI ranks the whole
   * surface must be on one. Default "": the noise of Seed.
   */
  void SetInputNoiseArrayName(const char* name);
  vtkGetCharFromStdStringMacro(InputNoiseArrayName);
  ///@}

  ///@{
  /**
   * Index of the first sample, at least 0; an ensemble can be generated in parts. Default 0.
   */
  vtkSetClampMacro(FirstSample, int, 0, VTK_INT_MAX);
  vtkGetMacro(FirstSample, int);
  ///@}

  ///@{
  /**
   * Number of samples, at least 1; for more than one the output is a multi-block dataset with a block for each.
   * Default 1.
   */
  vtkSetClampMacro(NumberOfSamples, int, 1, VTK_INT_MAX);
  vtkGetMacro(NumberOfSamples, int);
  ///@}

  ///@{
  /**
   * Memory limit of the output, MiB, at least 0; 0, the default, for three quarters of the memory of the machine. More
   * samples than fit are an error before the work begins; the message names a number that fits.
   */
  vtkSetClampMacro(MemoryLimit, int, 0, VTK_INT_MAX);
  vtkGetMacro(MemoryLimit, int);
  ///@}

  ///@{
  /**
   * Number of steps from noise to signal, from 1 to 10000, of equal length. More steps are more accurate and cost more.
   * Default 20.
   */
  vtkSetClampMacro(NumberOfSteps, int, 1, 10000);
  vtkGetMacro(NumberOfSteps, int);
  ///@}

  ///@{
  /**
   * Integrator of a step. Default MIDPOINT.
   */
  vtkSetClampMacro(Integrator, int, EULER, RUNGE_KUTTA_4);
  vtkGetMacro(Integrator, int);
  void SetIntegratorToEuler() { this->SetIntegrator(EULER); }
  void SetIntegratorToMidpoint() { this->SetIntegrator(MIDPOINT); }
  void SetIntegratorToRungeKutta4() { this->SetIntegrator(RUNGE_KUTTA_4); }
  ///@}

  ///@{
  /**
   * Number of corrections of a sample at the end of its flow, from 0 (none, as published) to 20; -1 stands for the
   * number that suits the model: 2 where it predicts the data (vtkFlowMatchingTrainer::SetPrediction(), AUTOMATIC for
   * positions), else 0. With n corrections the signal f is replaced for k = 1, ..., n with the data that the model
   * expects from t f at flow time t = 1/2 + k / (2 (n + 1)): f <- t f + (1 - t) v(t f, t). Errors of the flow are
   * removed as if they were noise [Alain2014]; too many corrections remove detail of the data as well. Default -1.
   */
  vtkSetClampMacro(NumberOfCorrections, int, -1, 20);
  vtkGetMacro(NumberOfCorrections, int);
  ///@}

  ///@{
  /**
   * Factor of the noise of Seed, without unit, from 0 to 10. Above 1 samples vary more than the data of the training, below
   * less; at 0 all samples are the same one. A little above 1 makes up for models that vary less than their data; far above,
   * samples are unlike the data. It multiplies the temperature of the model file, which is 1 unless Examples/Training/temperature.py
   * has found another. Not used with InputNoiseArrayName. Default 1.
   */
  vtkSetClampMacro(Temperature, double, 0.0, 10.0);
  vtkGetMacro(Temperature, double);
  ///@}

  ///@{
  /**
   * Coupling of the connected components of a surface. Off: several components are an error. On: each point within
   * CouplingDistance of another component is tied to the nearest place there, in all equations of noise and network.
   * With the differences B u of these pairs, weighted by area, a Poisson equation L u = r becomes (L + w B'B) u = r +
   * w B'B s, w = CouplingWeight / area of the surface and s the source surface for positions, 0 for features and other
   * signals: parts keep their offsets. At the end of a flow of positions, in the last step of a trajectory, the offsets
   * turn with the larger part of each pair: by the rigid motion that is nearest to it within twice the CouplingDistance.
   * Results do not depend on the order of the components, and a surface of one component gives the same bits as without.
   * A component without a pair is an error that names its first point. Default off.
   */
  vtkSetMacro(ComponentCoupling, bool);
  vtkGetMacro(ComponentCoupling, bool);
  vtkBooleanMacro(ComponentCoupling, bool);
  ///@}

  ///@{
  /**
   * Weight of the squared differences of coupled points against the Dirichlet energy, without unit, above 0; larger ties
   * parts more tightly. Used with ComponentCoupling. Default 1e6.
   */
  vtkSetClampMacro(CouplingWeight, double, 1e-300, VTK_DOUBLE_MAX);
  vtkGetMacro(CouplingWeight, double);
  ///@}

  ///@{
  /**
   * Largest distance of two coupled points, in world units, at least 0. Points are coupled only where surfaces face each
   * other: where the nearest place is at least half as far from the component of the point. 0 (the default) stands for
   * 0.03 times the square root of the area of the surface. Used with ComponentCoupling.
   */
  vtkSetClampMacro(CouplingDistance, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(CouplingDistance, double);
  ///@}

  ///@{
  /**
   * Area of the surface of which the input is a part or a damaged copy, square world units, at least 0. Models see surfaces
   * moved to their centroid and scaled to area 1; with an area above 0 they see the input as the whole surface would be:
   * moved to NormalizationCenter and scaled by this area. vtkIntegrateAttributes on the whole surface gives both. 0 (the
   * default) stands for area and centroid of the input, of each block on its own. Deformations of shapes leave the centroid
   * of the input where it is, also that of a part.
   */
  vtkSetClampMacro(NormalizationArea, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(NormalizationArea, double);
  ///@}

  ///@{
  /**
   * Centroid, weighted by area, of the surface of which the input is a part or a damaged copy, world units. Used with
   * NormalizationArea above 0. Default (0, 0, 0).
   */
  vtkSetVector3Macro(NormalizationCenter, double);
  vtkGetVector3Macro(NormalizationCenter, double);
  ///@}

  ///@{
  /**
   * Selection of the generated array as the active scalars of the output, which viewers color by, also where the input
   * has active scalars. Off, those of the input stay. Default off.
   */
  vtkSetMacro(ActiveResult, bool);
  vtkGetMacro(ActiveResult, bool);
  vtkBooleanMacro(ActiveResult, bool);
  ///@}

  ///@{
  /**
   * Makes flow time, from noise at 0 to the signal at 1, the time of the pipeline, so that an animation shows the
   * denoising. Default off.
   */
  vtkSetMacro(OutputTrajectory, bool);
  vtkGetMacro(OutputTrajectory, bool);
  vtkBooleanMacro(OutputTrajectory, bool);
  ///@}

  ///@{
  /**
   * Name of the point array with the generated signal. Default "": the name of the signal in the model file ("Position"
   * for positions). Not used by vtkFlowMatchingDeformer.
   */
  void SetSignalArrayName(const char* name);
  vtkGetCharFromStdStringMacro(SignalArrayName);
  ///@}

  ///@{
  /**
   * Name of the point array with the initial noise of the signal; not empty. Default "InitialNoise".
   */
  void SetInitialNoiseArrayName(const char* name);
  vtkGetCharFromStdStringMacro(InitialNoiseArrayName);
  ///@}

  /**
   * Description of the model of the last update in one line: signal, noise and network. Empty before the first model.
   */
  std::string GetModelDescription() const;

  /**
   * Number of model files read since this object was made. Unchanged while the file is unchanged.
   */
  vtkTypeInt64 GetNumberOfModelLoads() const;

  /**
   * Number of meshes assembled and factored since this object was made. Unchanged while only seeds, temperature,
   * numbers of samples, steps or corrections, or names change.
   */
  vtkTypeInt64 GetNumberOfFactorizations() const;

  /**
   * Number of evaluations of the network since this object was made, for finished samples only. Unchanged while only
   * flow time or names change.
   */
  vtkTypeInt64 GetNumberOfEvaluations() const;

protected:
  vtkFlowMatchingSampler();
  ~vtkFlowMatchingSampler() override;

  /// Returns true in a filter whose signal are positions: the model must then generate positions, and AddSample() gets
  /// their displacement from the points of the input. Default false.
  virtual bool GeneratesDisplacements() const { return false; }

  /// Returns the names of the arrays that AddSample() adds, which must not be empty, each with its property, for
  /// messages.
  virtual std::vector<std::pair<std::string, std::string>> OutputArrayNames();

  /// Name of the point array with the generated signal.
  virtual std::string GeneratedArrayName();

  /// Adds one sample to @p output, a copy of one surface of the input.
  virtual void AddSample(vtkPolyData* output, vtkDoubleArray* signal, vtkDoubleArray* noise);

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestDataObject(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int RequestInformation(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int RequestUpdateExtent(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;

private:
  vtkFlowMatchingSampler(const vtkFlowMatchingSampler&) = delete;
  void operator=(const vtkFlowMatchingSampler&) = delete;

  bool Generate(vtkInformationVector** inputVector, vtkInformationVector* outputVector, double time);

  std::string ModelFileName;
  int Seed = 0;
  std::string InputNoiseArrayName;
  int FirstSample = 0;
  int NumberOfSamples = 1;
  int MemoryLimit = 0;
  int NumberOfSteps = 20;
  int Integrator = MIDPOINT;
  int NumberOfCorrections = -1;
  double Temperature = 1.0;
  bool ComponentCoupling = false;
  double CouplingWeight = 1e6;
  double CouplingDistance = 0.0;
  double NormalizationArea = 0.0;
  double NormalizationCenter[3] = { 0.0, 0.0, 0.0 };
  bool OutputTrajectory = false;
  bool ActiveResult = false;
  std::string SignalArrayName;
  std::string InitialNoiseArrayName = "InitialNoise";

  class Internals;
  std::unique_ptr<Internals> Impl;
};

#endif
