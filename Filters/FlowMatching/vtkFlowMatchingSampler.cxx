// SPDX-License-Identifier: BSD-3-Clause
#include "vtkFlowMatchingSampler.h"

#include "BlockCache.h"
#include "DataObjects.h"
#include "FileCache.h"
#include "FilterSupport.h"
#include "FlowSamples.h"
#include "InstalledModelList.h"
#include "PointRows.h"
#include "Reporting.h"
#include "SampleMemory.h"
#include "SurfaceArrays.h"
#include "SurfaceBridge.h"
#include "SurfaceInputs.h"

#include "Core/Common/Errors.h"
#include "IO/Weights/InstalledModels.h"

#include <vtkDataObject.h>
#include <vtkDataObjectTree.h>
#include <vtkDemandDrivenPipeline.h>
#include <vtkDoubleArray.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkStreamingDemandDrivenPipeline.h>

#include <algorithm>
#include <exception>
#include <new>
#include <optional>
#include <set>

using surfsynth::FlowSamples;
using surfsynth::Surface;

vtkStandardNewMacro(vtkFlowMatchingSampler);

namespace
{
/// Cost of the preparation of a mesh, in evaluations of the network, for progress.
constexpr double EvaluationsOfPreparation = 3.0;

/// Samples of one model on one mesh.
struct PreparedSamples
{
  std::shared_ptr<const surfsynth::FlowMatchingModel> Model;
  surfsynth::ComponentCoupling Coupling;
  std::optional<surfsynth::MeshNormalization> Normalization;
  std::unique_ptr<FlowSamples> Samples;
};
} // namespace

/// Model, meshes and samples of the last update.
class vtkFlowMatchingSampler::Internals
{
public:
  explicit Internals(vtkFlowMatchingSampler* self)
    : Self(self)
  {}

  /// Checks the properties and reads the model file if needed. @throws the errors of the reader.
  void Begin(double flowTime)
  {
    this->FlowTime = flowTime;
    this->Model.reset();
    this->Normalization(); // must be finite
    if (this->Self->ModelFileName.empty())
    {
      throw surfsynth::InvalidInput("ModelFileName is empty; the path of a flow matching model is needed.");
    }
    this->Model = this->File.Get(surfsynth::ModelPath(this->Self->ModelFileName));
    if (this->Self->GeneratesDisplacements() && !this->Model->GeneratesPositions())
    {
      throw surfsynth::InvalidInput("The model generates \"" + this->Model->SignalName + "\", " +
        std::to_string(this->Model->Components()) +
        " component(s) at each point; a model that generates positions is "
        "needed. vtkFlowMatchingSampler takes models of any signal.");
    }
    this->CheckNames();
    if (!this->Self->InputNoiseArrayName.empty() && this->Self->NumberOfSamples != 1)
    {
      throw surfsynth::InvalidInput("InputNoiseArrayName is \"" + this->Self->InputNoiseArrayName +
        "\" and NumberOfSamples is " + std::to_string(this->Self->NumberOfSamples) +
        "; given noise is that of one sample, so NumberOfSamples must be 1.");
    }
    this->Blocks.Begin();
  }

  /// Adds the arrays of each sample of this rank to its output, and draws those that the last update lacks.
  void AddSamples(const Surface& surface, const std::vector<vtkPolyData*>& outputs, const surfsynth::Progress& progress)
  {
    FlowSamples* samples = this->Find(surface);
    const surfsynth::FlowSampleRequest series = this->Request(surface);
    const double evaluations = static_cast<double>(this->EvaluationsOfSample()) * this->Self->NumberOfSamples;
    const double begin = samples ? 0.0 : EvaluationsOfPreparation / (EvaluationsOfPreparation + evaluations);
    if (!samples)
    {
      samples = &this->Build(surface, surfsynth::SubProgress(progress, 0.0, begin));
    }
    samples->Keep(
      series, this->GivenNoise(*samples, outputs.front()), this->Self->FirstSample, this->Self->NumberOfSamples);
    for (int k = surface.Part.Index; k < this->Self->NumberOfSamples; k += surface.Part.Count)
    {
      const double share = (1.0 - begin) / this->Self->NumberOfSamples;
      surfsynth::FlowSampleRequest request = series;
      request.Sample = static_cast<std::uint32_t>(this->Self->FirstSample) + static_cast<std::uint32_t>(k);
      this->Draw(*samples, request, surfsynth::SubProgress(progress, begin + k * share, begin + (k + 1) * share));
      this->AddArrays(ArraysOf(*samples, surface, request.Sample, this->FlowTime, this->Self->GeneratesDisplacements()),
        outputs[static_cast<std::size_t>(k)]);
    }
  }

  /// Completes the output of one sample: a copy of the input to which AddSamples() has added its arrays.
  void Finish(vtkPolyData* output) const
  {
    const vtkSmartPointer<vtkDoubleArray> signal = Find(output, this->Self->GeneratedArrayName());
    const vtkSmartPointer<vtkDoubleArray> noise = Find(output, this->Self->InitialNoiseArrayName);
    this->Self->AddSample(output, signal, noise);
  }

  /// Returns the memory of kept states (float), and of signals, noise and moved points of the outputs (double).
  surfsynth::SampleMemory Memory() const
  {
    const double states = this->Self->OutputTrajectory ? this->Self->NumberOfSteps + 1.0 : 2.0;
    const bool moves = this->Self->GeneratesDisplacements();
    surfsynth::SampleMemory memory;
    memory.NumberOfSamples = this->Self->NumberOfSamples;
    memory.BytesOfPoint = this->Model->Components() * (4.0 * states + 16.0) + (moves ? 24.0 : 0.0);
    memory.BytesOfCell = moves ? 8.0 : 0.0;
    memory.BytesOfSample = 8192.0;
    memory.MemoryLimit = this->Self->MemoryLimit;
    return memory;
  }

  /// Returns the outputs of one surface, one for each sample.
  surfsynth::OutputSeries Series() const
  {
    return { this->Self->FirstSample, this->Self->NumberOfSamples, this->Self->NumberOfSamples == 1 ? "" : "Sample" };
  }

  /// Returns the samples of this block from an earlier update, or null; mesh and model must be the same.
  FlowSamples* Find(const Surface& surface)
  {
    PreparedSamples* found = this->Blocks.Find(surface);
    return found && found->Model == this->Model && found->Coupling == this->Coupling() &&
        found->Normalization == this->Normalization()
      ? found->Samples.get()
      : nullptr;
  }

  surfsynth::ComponentCoupling Coupling() const
  {
    return { this->Self->ComponentCoupling, this->Self->CouplingWeight, this->Self->CouplingDistance };
  }

  /// Returns the normalization that NormalizationArea asks for, or nothing for that of each surface.
  std::optional<surfsynth::MeshNormalization> Normalization() const
  {
    if (this->Self->NormalizationArea == 0.0)
    {
      return std::nullopt;
    }
    return surfsynth::FlowNormalization(
      this->Self->NormalizationArea, Eigen::RowVector3d(this->Self->NormalizationCenter));
  }

  std::string SignalArrayName() const
  {
    return this->Self->SignalArrayName.empty() && this->Model ? this->Model->SignalName : this->Self->SignalArrayName;
  }

  std::shared_ptr<const surfsynth::FlowMatchingModel> Model; ///< of this update
  surfsynth::BlockCache<PreparedSamples> Blocks;
  surfsynth::FileCache<surfsynth::FlowMatchingModel> File{ surfsynth::ReadFlowMatchingModel,
    "A flow matching model in safetensors format is needed, as vtkFlowMatchingTrainer writes it." };
  surfsynth::InstalledModelList Installed;
  vtkTypeInt64 NumberOfFactorizations = 0;
  vtkTypeInt64 NumberOfEvaluations = 0;

private:
  void AddArrays(const surfsynth::SampleArrays& sample, vtkPolyData* output) const
  {
    sample.Signal->SetName(this->Self->GeneratedArrayName().c_str());
    sample.Noise->SetName(this->Self->InitialNoiseArrayName.c_str());
    output->GetPointData()->AddArray(sample.Noise);
    output->GetPointData()->AddArray(sample.Signal);
  }

  static vtkDoubleArray* Find(vtkPolyData* output, const std::string& name)
  {
    return vtkDoubleArray::SafeDownCast(output->GetPointData()->GetArray(name.c_str()));
  }

  void CheckNames() const
  {
    std::set<std::string> names;
    for (const auto& [property, name] : this->Self->OutputArrayNames())
    {
      if (name.empty())
      {
        throw surfsynth::InvalidInput(property + " is empty; a name for the array is needed.");
      }
      if (!names.insert(name).second)
      {
        throw surfsynth::InvalidInput(
          property + " is \"" + name + "\", the name of another array of the output; different names are needed.");
      }
    }
  }

  surfsynth::FlowSampleRequest Request(const Surface& surface) const
  {
    surfsynth::FlowSampleRequest request;
    request.Seed = static_cast<std::uint64_t>(this->Self->Seed);
    request.Stream = surface.FlatIndex;
    request.Steps = this->Self->NumberOfSteps;
    request.Integrator = static_cast<surfsynth::FlowIntegrator>(this->Self->Integrator);
    request.Corrections = this->Corrections();
    request.Temperature = this->Self->Temperature;
    return request;
  }

  /// Reads the initial noise of InputNoiseArrayName; an empty matrix without one.
  surfsynth::FeatureMatrix GivenNoise(const FlowSamples& samples, vtkPolyData* surface) const
  {
    if (this->Self->InputNoiseArrayName.empty())
    {
      return {};
    }
    const surfsynth::NamedPointArray array{ this->Self->InputNoiseArrayName, "InputNoiseArrayName" };
    return samples.Sampler().FromDeviation(
      surfsynth::ReadPointRows(surface, samples.Points(), array, this->Model->Components()));
  }

  int Corrections() const
  {
    return this->Self->NumberOfCorrections < 0 ? surfsynth::SuitableCorrections(*this->Model)
                                               : this->Self->NumberOfCorrections;
  }

  vtkTypeInt64 EvaluationsOfSample() const
  {
    return static_cast<vtkTypeInt64>(this->Self->NumberOfSteps) *
      surfsynth::EvaluationsPerStep(static_cast<surfsynth::FlowIntegrator>(this->Self->Integrator)) +
      this->Corrections();
  }

  FlowSamples& Build(const Surface& surface, const surfsynth::Progress& progress)
  {
    this->Blocks.Drop(surface);
    PreparedSamples prepared;
    prepared.Model = this->Model;
    prepared.Coupling = this->Coupling();
    prepared.Normalization = this->Normalization();
    prepared.Samples = std::make_unique<FlowSamples>(
      this->Model, surface, progress, prepared.Coupling, prepared.Normalization);
    ++this->NumberOfFactorizations;
    for (const std::string& text : prepared.Samples->Sampler().Warnings())
    {
      surfsynth::ReportWarning(this->Self, surface.Where, text);
    }
    return *this->Blocks.Insert(surface, std::move(prepared)).Samples;
  }

  void Draw(FlowSamples& samples, const surfsynth::FlowSampleRequest& request, const surfsynth::Progress& progress)
  {
    if (!samples.Holds(request.Sample, this->Self->OutputTrajectory))
    {
      samples.Draw(request, this->Self->OutputTrajectory, progress);
      this->NumberOfEvaluations += this->EvaluationsOfSample();
    }
    surfsynth::Report(progress, 1.0);
  }

  vtkFlowMatchingSampler* Self;
  double FlowTime = 1.0;
};

vtkFlowMatchingSampler::vtkFlowMatchingSampler()
  : Impl(std::make_unique<Internals>(this))
{}

vtkFlowMatchingSampler::~vtkFlowMatchingSampler() = default;

void vtkFlowMatchingSampler::SetModelFileName(const char* name)
{
  surfsynth::SetString(this, this->ModelFileName, name);
}

void vtkFlowMatchingSampler::SetInputNoiseArrayName(const char* name)
{
  surfsynth::SetString(this, this->InputNoiseArrayName, name);
}

void vtkFlowMatchingSampler::SetSignalArrayName(const char* name)
{
  surfsynth::SetString(this, this->SignalArrayName, name);
}

void vtkFlowMatchingSampler::SetInitialNoiseArrayName(const char* name)
{
  surfsynth::SetString(this, this->InitialNoiseArrayName, name);
}

std::vector<std::pair<std::string, std::string>> vtkFlowMatchingSampler::OutputArrayNames()
{
  return { { "SignalArrayName", this->Impl->SignalArrayName() },
    { "InitialNoiseArrayName", this->InitialNoiseArrayName } };
}

std::string vtkFlowMatchingSampler::GeneratedArrayName() { return this->Impl->SignalArrayName(); }

void vtkFlowMatchingSampler::AddSample(vtkPolyData* output, vtkDoubleArray* signal, vtkDoubleArray* noise)
{
  signal->SetName(this->Impl->SignalArrayName().c_str());
  noise->SetName(this->InitialNoiseArrayName.c_str());
  output->GetPointData()->AddArray(noise);
  output->GetPointData()->AddArray(signal);
  surfsynth::SetActiveWhereNone(output->GetPointData(), signal->GetName());
}

int vtkFlowMatchingSampler::FillInputPortInformation(int, vtkInformation* info)
{
  return surfsynth::AcceptSurfaces(info);
}

int vtkFlowMatchingSampler::RequestDataObject(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  if (!surfsynth::RequireSurfaces(this, inputVector))
  {
    return 0;
  }
  if (this->NumberOfSamples == 1)
  {
    return surfsynth::RequestSurfaces(vtkDataObject::GetData(inputVector[0]), outputVector);
  }
  surfsynth::SetOutputClass(outputVector, "vtkMultiBlockDataSet");
  return 1;
}

int vtkFlowMatchingSampler::RequestInformation(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  vtkInformation* output = outputVector->GetInformationObject(0);
  if (this->OutputTrajectory)
  {
    std::vector<double> times;
    for (int k = 0; k <= this->NumberOfSteps; ++k)
    {
      times.push_back(static_cast<double>(k) / this->NumberOfSteps);
    }
    const double range[2] = { 0.0, 1.0 };
    output->Set(vtkStreamingDemandDrivenPipeline::TIME_STEPS(), times.data(), static_cast<int>(times.size()));
    output->Set(vtkStreamingDemandDrivenPipeline::TIME_RANGE(), range, 2);
    return 1;
  }
  // The times of the input, or none: those of an earlier trajectory go.
  output->CopyEntry(inputVector[0]->GetInformationObject(0), vtkStreamingDemandDrivenPipeline::TIME_STEPS());
  output->CopyEntry(inputVector[0]->GetInformationObject(0), vtkStreamingDemandDrivenPipeline::TIME_RANGE());
  return 1;
}

int vtkFlowMatchingSampler::RequestUpdateExtent(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector*)
{
  if (this->OutputTrajectory)
  {
    // Flow time is no time of the input.
    inputVector[0]->GetInformationObject(0)->Remove(vtkStreamingDemandDrivenPipeline::UPDATE_TIME_STEP());
  }
  return 1;
}

int vtkFlowMatchingSampler::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  using Pipeline = vtkStreamingDemandDrivenPipeline;
  vtkInformation* info = outputVector->GetInformationObject(0);
  vtkDataObject* output = vtkDataObject::GetData(info);
  const bool hasTime = this->OutputTrajectory && info->Has(Pipeline::UPDATE_TIME_STEP());
  const double time = hasTime ? std::clamp(info->Get(Pipeline::UPDATE_TIME_STEP()), 0.0, 1.0) : 1.0;
  std::string problem;
  try
  {
    this->Impl->Begin(time);
    problem = surfsynth::ProblemOfMemory(vtkDataObject::GetData(inputVector[0]), this->Impl->Memory());
    if (problem.empty() && this->Generate(inputVector, outputVector, time))
    {
      if (this->ActiveResult)
      {
        surfsynth::SelectScalars(output, { this->GeneratedArrayName() });
      }
      return 1;
    }
  }
  catch (const std::bad_alloc&)
  {
    problem = "There is not enough memory for " + std::to_string(this->NumberOfSamples) + " sample(s).";
  }
  catch (const std::exception& error)
  {
    problem = error.what();
  }
  if (!problem.empty())
  {
    surfsynth::ReportError(this, "", problem);
  }
  output->Initialize();
  return 0;
}

bool vtkFlowMatchingSampler::Generate(
  vtkInformationVector** inputVector, vtkInformationVector* outputVector, double time)
{
  surfsynth::SurfaceSeries samples;
  samples.Outputs = this->Impl->Series();
  samples.Worker = [this](const Surface& surface, const std::vector<vtkPolyData*>& outputs,
                     const surfsynth::Progress& progress) { this->Impl->AddSamples(surface, outputs, progress); };
  samples.Finish = [this](vtkPolyData* output) { this->Impl->Finish(output); };
  const auto isPrepared = [this](const Surface& surface) { return this->Impl->Find(surface) != nullptr; };
  if (!surfsynth::ProcessSurfaces(this, inputVector, outputVector,
        surfsynth::FlowMatchingSampler::Requirements(this->ComponentCoupling), samples, isPrepared))
  {
    return false;
  }
  vtkInformation* info = outputVector->GetInformationObject(0);
  if (info->Get(vtkDemandDrivenPipeline::DATA_NOT_GENERATED()))
  {
    return true; // stopped: the next update runs again
  }
  this->Impl->Blocks.DropUnused();
  if (this->OutputTrajectory)
  {
    vtkDataObject::GetData(info)->GetInformation()->Set(vtkDataObject::DATA_TIME_STEP(), time);
  }
  return true;
}

std::string vtkFlowMatchingSampler::GetModelDescription() const
{
  return this->Impl->Model ? this->Impl->Model->Description() : "";
}

vtkStringArray* vtkFlowMatchingSampler::GetInstalledModels()
{
  return this->Impl->Installed.Names(
    "flow_matching", this->GeneratesDisplacements() ? R"("signal_name":"Position")" : "");
}

const char* vtkFlowMatchingSampler::GetInstalledModelsFolder() const { return this->Impl->Installed.Folder(); }

vtkTypeInt64 vtkFlowMatchingSampler::GetNumberOfModelLoads() const { return this->Impl->File.NumberOfLoads(); }

vtkTypeInt64 vtkFlowMatchingSampler::GetNumberOfFactorizations() const { return this->Impl->NumberOfFactorizations; }

vtkTypeInt64 vtkFlowMatchingSampler::GetNumberOfEvaluations() const { return this->Impl->NumberOfEvaluations; }

void vtkFlowMatchingSampler::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "ModelFileName: " << this->ModelFileName << "\n";
  os << indent << "Seed: " << this->Seed << "\n";
  os << indent << "InputNoiseArrayName: " << this->InputNoiseArrayName << "\n";
  os << indent << "FirstSample: " << this->FirstSample << "\n";
  os << indent << "NumberOfSamples: " << this->NumberOfSamples << "\n";
  os << indent << "MemoryLimit: " << this->MemoryLimit << "\n";
  os << indent << "NumberOfSteps: " << this->NumberOfSteps << "\n";
  os << indent << "Integrator: " << this->Integrator << "\n";
  os << indent << "NumberOfCorrections: " << this->NumberOfCorrections << "\n";
  os << indent << "Temperature: " << this->Temperature << "\n";
  os << indent << "ComponentCoupling: " << this->ComponentCoupling << "\n";
  os << indent << "CouplingWeight: " << this->CouplingWeight << "\n";
  os << indent << "CouplingDistance: " << this->CouplingDistance << "\n";
  os << indent << "NormalizationArea: " << this->NormalizationArea << "\n";
  os << indent << "NormalizationCenter: " << this->NormalizationCenter[0] << " " << this->NormalizationCenter[1] << " "
     << this->NormalizationCenter[2] << "\n";
  os << indent << "OutputTrajectory: " << this->OutputTrajectory << "\n";
  os << indent << "ActiveResult: " << this->ActiveResult << "\n";
  os << indent << "SignalArrayName: " << this->SignalArrayName << "\n";
  os << indent << "InitialNoiseArrayName: " << this->InitialNoiseArrayName << "\n";
  os << indent << "ModelDescription: " << this->GetModelDescription() << "\n";
  os << indent << "NumberOfModelLoads: " << this->GetNumberOfModelLoads() << "\n";
  os << indent << "NumberOfFactorizations: " << this->GetNumberOfFactorizations() << "\n";
  os << indent << "NumberOfEvaluations: " << this->GetNumberOfEvaluations() << "\n";
}
