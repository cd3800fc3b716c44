// SPDX-License-Identifier: BSD-3-Clause
#include "vtkPoissonNetFilter.h"

#include "BlockCache.h"
#include "DataObjects.h"
#include "FileCache.h"
#include "FilterSupport.h"
#include "InstalledModelList.h"
#include "NetworkInput.h"
#include "PredictionArrays.h"
#include "Reporting.h"
#include "SurfaceBridge.h"
#include "SurfaceInputs.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/UsedPoints.h"
#include "IO/Weights/InstalledModels.h"

#include <vtkDataObject.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkObjectFactory.h>
#include <vtkPolyData.h>

#include <algorithm>
#include <exception>
#include <optional>
#include <utility>

using surfsynth::Surface;

vtkStandardNewMacro(vtkPoissonNetFilter);

namespace
{
std::string Described(const surfsynth::PoissonNetModel& model)
{
  const surfsynth::PoissonNetOptions& options = model.Options;
  const bool gradients = options.Head == surfsynth::PoissonNetHead::GradientDomain;
  const bool atFaces = options.Domain == surfsynth::PoissonNetDomain::Faces;
  const bool global = options.Domain == surfsynth::PoissonNetDomain::Global;
  return std::string(gradients      ? "positions"
             : model.IsClassifier() ? "classifier"
                                    : "features") +
    " at the " +
    (global       ? "whole surface"
        : atFaces ? "faces"
                  : "points") +
    ", " + std::to_string(options.ResultChannels()) + " channels; " + std::to_string(options.Blocks) +
    " blocks, width " + std::to_string(options.Width) + ", " + std::to_string(options.InputChannels) +
    " input channels, " + std::to_string(options.ExtraFeatures) + " conditions";
}

/// Network on one mesh. The operators outlive a change of the model.
struct PreparedNetwork
{
  surfsynth::InputNormalization Normalization = surfsynth::InputNormalization::None;
  surfsynth::MeshNormalization Coordinates;
  surfsynth::ComponentCoupling Coupling;
  surfsynth::PointMatrix Points; ///< those that triangles use, normalised
  surfsynth::PoissonOperators Operators;
  std::shared_ptr<const surfsynth::PoissonNetModel> Model;
  std::optional<surfsynth::PoissonNetEvaluator> Evaluator;
};
} // namespace

/// Model and meshes of the last update.
class vtkPoissonNetFilter::Internals
{
public:
  explicit Internals(vtkPoissonNetFilter* self)
    : Self(self)
  {}

  /// Reads the model file if needed. @throws the errors of the reader.
  void Begin()
  {
    if (this->Self->ModelFileName.empty())
    {
      throw surfsynth::InvalidInput(
        "ModelFileName is empty; the path of a PoissonNet in safetensors format is needed.");
    }
    this->Model.reset();
    this->Model = this->File.Get(surfsynth::ModelPath(this->Self->ModelFileName));
    this->Blocks.Begin();
  }

  void AddPrediction(const Surface& surface, vtkPolyData* output, const surfsynth::Progress& progress)
  {
    const surfsynth::UsedPoints used(surface.Mesh);
    const surfsynth::TriangleMesh mesh = used.Compact(surface.Mesh);
    const surfsynth::MeshNormalization coordinates = surfsynth::ComputeNormalization(mesh, this->Normalization());
    // Errors of the input are reported before the operators, which take long, are assembled.
    const surfsynth::PoissonNetInput input = surfsynth::MakeNetworkInput(
      *this->Model, this->Request(), output, used, coordinates);
    PreparedNetwork* prepared = this->Find(surface);
    const double begin = prepared ? 0.0 : 0.3;
    if (!prepared)
    {
      prepared = &this->Build(surface, mesh, coordinates, surfsynth::SubProgress(progress, 0.0, begin));
    }
    const surfsynth::PoissonNetEvaluator& evaluator = this->EvaluatorOf(*prepared);
    const surfsynth::PoissonNetPrediction prediction = evaluator.Evaluate(
      input, surfsynth::SubProgress(progress, begin, 1.0));
    surfsynth::AddPredictionArrays(
      { surface, used, *this->Model, prepared->Coordinates }, prediction, this->Names(), output);
  }

  /// Finds the data of this block from an earlier update with the same mesh, normalisation and operators; null otherwise.
  PreparedNetwork* Find(const Surface& surface)
  {
    PreparedNetwork* found = this->Blocks.Find(surface);
    const bool fits = found && found->Normalization == this->Normalization() &&
      found->Operators.Shift == this->Model->Options.Shift && found->Coupling == this->Coupling();
    return fits ? found : nullptr;
  }

  /// Returns the name of the array that viewers color by.
  std::string Result() const
  {
    if (this->Model->Options.Head == surfsynth::PoissonNetHead::GradientDomain)
    {
      return this->Self->DisplacementArrayName;
    }
    const bool isClassifier = this->Model->IsClassifier() || !this->Model->Classes.empty();
    return isClassifier ? this->Self->LabelArrayName : this->Self->PredictionArrayName;
  }

  std::shared_ptr<const surfsynth::PoissonNetModel> Model; ///< of this update
  surfsynth::BlockCache<PreparedNetwork> Blocks;
  surfsynth::FileCache<surfsynth::PoissonNetModel> File{ [](const std::string& path) {
                                                          return surfsynth::ReadPoissonNet(path);
                                                        },
    "A PoissonNet in safetensors format is needed; \"python3 -m surfacesynthesis convert\" makes one of a PyTorch "
    "checkpoint." };
  surfsynth::InstalledModelList Installed;
  vtkTypeInt64 NumberOfFactorizations = 0;

private:
  surfsynth::InputNormalization Normalization() const
  {
    switch (this->Self->InputNormalization)
    {
      case NONE:
        return surfsynth::InputNormalization::None;
      case SURFACE_AREA:
        return surfsynth::InputNormalization::SurfaceArea;
      case UNIT_SPHERE:
        return surfsynth::InputNormalization::UnitSphere;
      default:
        return this->Model->Normalization;
    }
  }

  surfsynth::ComponentCoupling Coupling() const
  {
    return { this->Self->ComponentCoupling, this->Self->CouplingWeight, this->Self->CouplingDistance };
  }

  surfsynth::NetworkInputRequest Request() const
  {
    return { this->Self->Conditions, this->Self->ConditionArrayName, this->Self->SignalArrayName };
  }

  surfsynth::PredictionNames Names() const
  {
    return { this->Self->PredictionArrayName, this->Self->LabelArrayName, this->Self->ClassNamesArrayName,
      this->Self->DisplacementArrayName };
  }

  /// @param mesh the points of @p surface that triangles use.
  PreparedNetwork& Build(const Surface& surface, const surfsynth::TriangleMesh& mesh,
    const surfsynth::MeshNormalization& coordinates, const surfsynth::Progress& progress)
  {
    this->Blocks.Drop(surface);
    // The tables that the check has made hold for the whole mesh, stray points included.
    const bool isWhole = surface.Topology && mesh.NumberOfPoints() == surface.Mesh.NumberOfPoints();
    std::optional<surfsynth::MeshTopology> own;
    if (!isWhole)
    {
      own = surfsynth::RequireValidMesh(
        mesh, surfsynth::PoissonNetEvaluator::Requirements(this->Self->ComponentCoupling));
    }
    const surfsynth::MeshTopology& topology = isWhole ? *surface.Topology : *own;
    PreparedNetwork prepared;
    prepared.Normalization = this->Normalization();
    prepared.Coordinates = coordinates;
    prepared.Coupling = this->Coupling();
    const surfsynth::TriangleMesh normalized = surfsynth::Normalized(mesh, coordinates);
    prepared.Points = normalized.Points;
    prepared.Operators = surfsynth::BuildPoissonOperators(normalized, topology, progress, this->Model->Options.Shift,
      surfsynth::ScaledCoupling(prepared.Coupling, coordinates));
    ++this->NumberOfFactorizations;
    for (const std::string& text : surfsynth::DescribeUnlikelyInput(mesh, topology, this->Normalization()))
    {
      surfsynth::ReportWarning(this->Self, surface.Where, text);
    }
    return this->Blocks.Insert(surface, std::move(prepared));
  }

  const surfsynth::PoissonNetEvaluator& EvaluatorOf(PreparedNetwork& prepared) const
  {
    if (prepared.Model != this->Model)
    {
      prepared.Evaluator.reset(); // first, so that the weights of two models are never held
      prepared.Model = this->Model;
      prepared.Evaluator.emplace(this->Model, prepared.Operators, prepared.Points);
    }
    return *prepared.Evaluator;
  }

  vtkPoissonNetFilter* Self;
};

vtkPoissonNetFilter::vtkPoissonNetFilter()
  : Impl(std::make_unique<Internals>(this))
{}

vtkPoissonNetFilter::~vtkPoissonNetFilter() = default;

void vtkPoissonNetFilter::SetModelFileName(const char* name) { surfsynth::SetString(this, this->ModelFileName, name); }

void vtkPoissonNetFilter::SetConditionArrayName(const char* name)
{
  surfsynth::SetString(this, this->ConditionArrayName, name);
}

void vtkPoissonNetFilter::SetSignalArrayName(const char* name)
{
  surfsynth::SetString(this, this->SignalArrayName, name);
}

void vtkPoissonNetFilter::SetPredictionArrayName(const char* name)
{
  surfsynth::SetString(this, this->PredictionArrayName, name);
}

void vtkPoissonNetFilter::SetLabelArrayName(const char* name)
{
  surfsynth::SetString(this, this->LabelArrayName, name);
}

void vtkPoissonNetFilter::SetClassNamesArrayName(const char* name)
{
  surfsynth::SetString(this, this->ClassNamesArrayName, name);
}

void vtkPoissonNetFilter::SetDisplacementArrayName(const char* name)
{
  surfsynth::SetString(this, this->DisplacementArrayName, name);
}

void vtkPoissonNetFilter::SetNumberOfConditions(int number)
{
  const auto wanted = static_cast<std::size_t>(std::max(number, 0));
  if (this->Conditions.size() != wanted)
  {
    this->Conditions.resize(wanted, 0.0);
    this->Modified();
  }
}

void vtkPoissonNetFilter::SetCondition(int index, double value)
{
  if (index < 0 || index >= this->GetNumberOfConditions())
  {
    return;
  }
  double& condition = this->Conditions[static_cast<std::size_t>(index)];
  if (condition != value)
  {
    condition = value;
    this->Modified();
  }
}

double vtkPoissonNetFilter::GetCondition(int index) const
{
  return index >= 0 && index < this->GetNumberOfConditions() ? this->Conditions[static_cast<std::size_t>(index)] : 0.0;
}

int vtkPoissonNetFilter::FillInputPortInformation(int, vtkInformation* info) { return surfsynth::AcceptSurfaces(info); }

int vtkPoissonNetFilter::RequestDataObject(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  if (!surfsynth::RequireSurfaces(this, inputVector))
  {
    return 0;
  }
  return surfsynth::RequestSurfaces(vtkDataObject::GetData(inputVector[0]), outputVector);
}

int vtkPoissonNetFilter::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  try
  {
    for (const std::string* name :
      { &this->PredictionArrayName, &this->LabelArrayName, &this->ClassNamesArrayName, &this->DisplacementArrayName })
    {
      if (name->empty())
      {
        throw surfsynth::InvalidInput("The name of an output array is empty; PredictionArrayName, LabelArrayName, "
                                      "ClassNamesArrayName and DisplacementArrayName must not be.");
      }
    }
    this->Impl->Begin();
  }
  catch (const std::exception& error)
  {
    surfsynth::ReportError(this, "", error.what());
    vtkDataObject::GetData(outputVector)->Initialize();
    return 0;
  }
  const auto predict = [this](const Surface& surface, vtkPolyData* output, const surfsynth::Progress& progress) {
    this->Impl->AddPrediction(surface, output, progress);
  };
  const auto isPrepared = [this](const Surface& surface) { return this->Impl->Find(surface) != nullptr; };
  const int success = surfsynth::ProcessSurfaces(this, inputVector, outputVector,
    surfsynth::PoissonNetEvaluator::Requirements(this->ComponentCoupling), predict, isPrepared);
  if (success && !this->GetAbortExecute())
  {
    this->Impl->Blocks.DropUnused();
  }
  if (success && this->ActiveResult)
  {
    surfsynth::SelectScalars(vtkDataObject::GetData(outputVector), { this->Impl->Result() });
  }
  return success;
}

std::string vtkPoissonNetFilter::GetModelDescription() const
{
  return this->Impl->Model ? Described(*this->Impl->Model) : "";
}

vtkStringArray* vtkPoissonNetFilter::GetInstalledModels() { return this->Impl->Installed.Names("poissonnet"); }

const char* vtkPoissonNetFilter::GetInstalledModelsFolder() const { return this->Impl->Installed.Folder(); }

vtkTypeInt64 vtkPoissonNetFilter::GetNumberOfModelLoads() const { return this->Impl->File.NumberOfLoads(); }

vtkTypeInt64 vtkPoissonNetFilter::GetNumberOfFactorizations() const { return this->Impl->NumberOfFactorizations; }

void vtkPoissonNetFilter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "ModelFileName: " << this->ModelFileName << "\n";
  os << indent << "InputNormalization: " << this->InputNormalization << "\n";
  os << indent << "Conditions:";
  for (const double condition : this->Conditions)
  {
    os << " " << condition;
  }
  os << "\n";
  os << indent << "ComponentCoupling: " << this->ComponentCoupling << "\n";
  os << indent << "CouplingWeight: " << this->CouplingWeight << "\n";
  os << indent << "CouplingDistance: " << this->CouplingDistance << "\n";
  os << indent << "ConditionArrayName: " << this->ConditionArrayName << "\n";
  os << indent << "SignalArrayName: " << this->SignalArrayName << "\n";
  os << indent << "PredictionArrayName: " << this->PredictionArrayName << "\n";
  os << indent << "LabelArrayName: " << this->LabelArrayName << "\n";
  os << indent << "ClassNamesArrayName: " << this->ClassNamesArrayName << "\n";
  os << indent << "DisplacementArrayName: " << this->DisplacementArrayName << "\n";
  os << indent << "ActiveResult: " << this->ActiveResult << "\n";
  os << indent << "ModelDescription: " << this->GetModelDescription() << "\n";
  os << indent << "NumberOfModelLoads: " << this->GetNumberOfModelLoads() << "\n";
  os << indent << "NumberOfFactorizations: " << this->GetNumberOfFactorizations() << "\n";
}
