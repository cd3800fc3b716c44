// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkPoissonNetFilter
 * @brief   Evaluates a trained PoissonNet on surfaces: segmentation, classification, features, predicted shapes
 *
 * PoissonNet is a network on triangle meshes whose blocks alternate between a small network at each point, one at each
 * triangle that works on gradients, and a Poisson equation that joins them ([Maesumi2025]; [Kuai2026], section 4).
 * This filter reads a model file and evaluates the network that it describes, for any task.
 *
 * @par Model file
 * safetensors, with the tensors under their published names and the architecture in the metadata (keys `config`,
 * `head`, `C_in`, `C_out`, `C_width`, `n_blocks`, `extra_features`, `outputs_at`, `last_activation`, `classes`,
 * `input_normalisation`). `python3 -m surfacesynthesis convert` makes one from a PyTorch checkpoint. Files are
 * checked before use; a damaged file, or one without such a model, is an error that names the cause. A file is read
 * once, and again in an update after its size or time of modification has changed.
 *
 * @par Input
 * vtkPolyData with triangles, polygons or strips, float or double points, open or closed; or a composite dataset of
 * such blocks. Polygons and strips are triangulated for the computation only. Vertices and lines are ignored, and so
 * are points that no polygon or strip uses. The mesh must have finite points, no degenerate triangle, no edge with
 * more than two triangles, consistent winding (the network is not mirror-invariant) and one component (a Poisson
 * equation leaves the constant on each further component undetermined; switch ComponentCoupling on for parts that
 * belong together, or split a mesh with vtkPolyDataConnectivityFilter and give its parts as blocks). The error message
 * names the defect, the first offending cell or point and the filter that repairs it. A warning is given where good
 * results are unlikely: for a closed surface whose faces point inwards, and for an area below 0.1 or above 10 that is
 * not normalised. A composite input is processed block by block; a block that cannot be processed is reported and
 * left empty, the others are not affected. Empty input gives empty output.
 *
 * @par Optional arrays of the input
 * The point array ConditionArrayName, any numeric type, with as many components as the model takes conditions. The
 * point array SignalArrayName, any numeric type, with as many components as the model takes input channels.
 *
 * @par Output
 * The input, untouched, plus arrays that depend on the head of the model:
 *  - a linear head at the vertices: the point array PredictionArrayName, float32, a component for each output channel;
 *  - a linear head at the faces: the cell array of that name. A polygon or strip gets the mean of its triangles,
 *    weighted by area (of a classifier: of their logits);
 *  - a linear head that averages over the surface: the field-data array of that name, one tuple;
 *  - a gradient-domain head: the point array of that name, float64, 3 components: predicted positions. Positions are
 *    those of the network, mapped back to the coordinates of the input where it was normalised; their centroid is then
 *    that of the input, and the origin when nothing was normalised. And the point array DisplacementArrayName,
 *    float64, 3 components: the displacement to these positions, less that of the centroid of the surface.
 *
 * A classifier (a model whose last activation is the logarithm of softmax, or whose metadata name `classes`) also gives
 * LabelArrayName, int32, the class of the largest component, beside the prediction, which holds log-probabilities then;
 * and, where the file names the classes, the field-data string array ClassNamesArrayName, whose value k is the name of
 * class k. Points and cells that the network has not seen get 0, and the label -1.
 *
 * @par Cost
 * One sparse factorisation for each mesh and normalisation, kept until one of them changes. An evaluation is linear in
 * the number of triangles, the number of blocks and the square of the width, but for a solve in each block. The same
 * model, mesh and conditions give the same bits for every number of threads.
 * Another kind of processor may give other last bits: Reproducibility in README.md.
 *
 * @sa vtkSurfaceRepairFilter, vtkPolyDataNormals, vtkWarpVector, vtkMaternNoiseFilter
 */

#ifndef vtkPoissonNetFilter_h
#define vtkPoissonNetFilter_h

#include "vtkDeprecation.h" // For VTK_DEPRECATION
#include "vtkPassInputTypeAlgorithm.h"
#include "vtkSurfaceSynthesisPoissonNetModule.h" // For export macro

#include <memory> // For std::unique_ptr
#include <string> // For std::string
#include <vector> // For std::vector

class vtkStringArray;

class VTKSURFACESYNTHESISPOISSONNET_EXPORT vtkPoissonNetFilter : public vtkPassInputTypeAlgorithm
{
public:
  static vtkPoissonNetFilter* New();
  vtkTypeMacro(vtkPoissonNetFilter, vtkPassInputTypeAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// Normalisations of the mesh before the evaluation.
  enum InputNormalizations
  {
    MODEL = 0,        ///< as given in the model file; none where it gives none, as published files
    NONE = 1,         ///< no normalisation
    SURFACE_AREA = 2, ///< moved to the area-weighted centroid and scaled to area 1
    UNIT_SPHERE = 3   ///< moved to the area-weighted centroid and scaled to the largest distance 1 from it
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
   * Normalisation of the mesh before the evaluation. It should be that of the training, because networks depend on size
   * and position. Default MODEL.
   */
  vtkSetClampMacro(InputNormalization, int, MODEL, UNIT_SPHERE);
  vtkGetMacro(InputNormalization, int);
  void SetInputNormalizationToModel() { this->SetInputNormalization(MODEL); }
  void SetInputNormalizationToNone() { this->SetInputNormalization(NONE); }
  void SetInputNormalizationToSurfaceArea() { this->SetInputNormalization(SURFACE_AREA); }
  void SetInputNormalizationToUnitSphere() { this->SetInputNormalization(UNIT_SPHERE); }
  ///@}

  ///@{
  /**
   * Deprecated names of SetInputNormalization() and its companions.
   */
  VTK_DEPRECATION("Use SetInputNormalization()")
  void SetInputNormalisation(int normalization) { this->SetInputNormalization(normalization); }
  VTK_DEPRECATION("Use GetInputNormalization()")
  int GetInputNormalisation() { return this->GetInputNormalization(); }
  VTK_DEPRECATION("Use SetInputNormalizationToModel()")
  void SetInputNormalisationToModel() { this->SetInputNormalizationToModel(); }
  VTK_DEPRECATION("Use SetInputNormalizationToNone()")
  void SetInputNormalisationToNone() { this->SetInputNormalizationToNone(); }
  VTK_DEPRECATION("Use SetInputNormalizationToSurfaceArea()")
  void SetInputNormalisationToSurfaceArea() { this->SetInputNormalizationToSurfaceArea(); }
  VTK_DEPRECATION("Use SetInputNormalizationToUnitSphere()")
  void SetInputNormalisationToUnitSphere() { this->SetInputNormalizationToUnitSphere(); }
  ///@}

  ///@{
  /**
   * Conditions (extra features) of the model, the same for all points: finite numbers, as many as the model takes, in
   * the units of its training; for instance a time in [0, 1]. SetNumberOfConditions() clamps to 0 and more and fills
   * with 0; SetCondition() does nothing for an index out of range, and GetCondition() returns 0. Default none.
   */
  void SetNumberOfConditions(int number);
  int GetNumberOfConditions() const { return static_cast<int>(this->Conditions.size()); }
  void SetCondition(int index, double value);
  double GetCondition(int index) const;
  ///@}

  ///@{
  /**
   * Coupling of the connected components of a surface. Off: several components are an error. On: each point within
   * CouplingDistance of another component is tied to the nearest place there, in all Poisson equations of the network.
   * With the differences B u of these pairs, weighted by area, a Poisson equation L u = r becomes (L + w B'B) u = r +
   * w B'B s, w = CouplingWeight / area of the surface and s the signal of the network's input for positions, 0 for
   * features. Results do not depend on the order of the components, and a surface of one component gives the same bits
   * as without. A component without a pair is an error that names its first point. Default off.
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
   * Name of a point array that holds the conditions of each point; it takes precedence over the numbers of
   * SetCondition(). Default "": none.
   */
  void SetConditionArrayName(const char* name);
  vtkGetCharFromStdStringMacro(ConditionArrayName);
  ///@}

  ///@{
  /**
   * Name of the point array that is the input of the network in place of the positions; needed by models with another
   * number of input channels than 3. For a gradient-domain head these are positions, and are normalised with the mesh.
   * Default "": the positions.
   */
  void SetSignalArrayName(const char* name);
  vtkGetCharFromStdStringMacro(SignalArrayName);
  ///@}

  ///@{
  /**
   * Name of the array with the network's output; not empty. Default "Prediction".
   */
  void SetPredictionArrayName(const char* name);
  vtkGetCharFromStdStringMacro(PredictionArrayName);
  ///@}

  ///@{
  /**
   * Name of the array with the most probable classes; not empty. Default "Label".
   */
  void SetLabelArrayName(const char* name);
  vtkGetCharFromStdStringMacro(LabelArrayName);
  ///@}

  ///@{
  /**
   * Name of the field-data array with the names of the classes; not empty. Default "ClassNames".
   */
  void SetClassNamesArrayName(const char* name);
  vtkGetCharFromStdStringMacro(ClassNamesArrayName);
  ///@}

  ///@{
  /**
   * Selection of the labels of a classifier, the displacement to predicted positions, or else the prediction as the active
   * scalars of the output, which viewers color by, also where the input has active scalars. Off, those of the input stay.
   * Default off.
   */
  vtkSetMacro(ActiveResult, bool);
  vtkGetMacro(ActiveResult, bool);
  vtkBooleanMacro(ActiveResult, bool);
  ///@}

  ///@{
  /**
   * Name of the point array with the displacement to predicted positions; not empty. Default "Displacement".
   */
  void SetDisplacementArrayName(const char* name);
  vtkGetCharFromStdStringMacro(DisplacementArrayName);
  ///@}

  /**
   * Description of the model of the last update in one line: head, blocks, width, inputs and outputs. Empty before the
   * first model.
   */
  std::string GetModelDescription() const;

  /**
   * Number of model files read since this object was made. Unchanged while the file is unchanged.
   */
  vtkTypeInt64 GetNumberOfModelLoads() const;

  /**
   * Number of meshes assembled and factored since this object was made. Unchanged while only the model, conditions or
   * names change.
   */
  vtkTypeInt64 GetNumberOfFactorizations() const;

protected:
  vtkPoissonNetFilter();
  ~vtkPoissonNetFilter() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestDataObject(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;

private:
  vtkPoissonNetFilter(const vtkPoissonNetFilter&) = delete;
  void operator=(const vtkPoissonNetFilter&) = delete;

  std::string ModelFileName;
  int InputNormalization = MODEL;
  std::vector<double> Conditions;
  bool ComponentCoupling = false;
  double CouplingWeight = 1e6;
  double CouplingDistance = 0.0;
  std::string ConditionArrayName;
  std::string SignalArrayName;
  std::string PredictionArrayName = "Prediction";
  std::string LabelArrayName = "Label";
  std::string ClassNamesArrayName = "ClassNames";
  std::string DisplacementArrayName = "Displacement";
  bool ActiveResult = false;

  class Internals;
  std::unique_ptr<Internals> Impl;
};

#endif
