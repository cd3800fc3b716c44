// SPDX-License-Identifier: BSD-3-Clause
#include "vtkFieldLatentTextureFilter.h"

#include "BlockBridge.h"
#include "DataObjects.h"
#include "FieldLatentTextureInternals.h"
#include "FilterSupport.h"
#include "Reporting.h"
#include "TextureImages.h"
#include "WholeInput.h"

#include <vtkDataObject.h>
#include <vtkDataObjectTree.h>
#include <vtkImageData.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkObjectFactory.h>
#include <vtkStreamingDemandDrivenPipeline.h>

#include <algorithm>
#include <exception>
#include <new>
#include <utility>
#include <vector>

using Pipeline = vtkStreamingDemandDrivenPipeline;

vtkStandardNewMacro(vtkFieldLatentTextureFilter);

namespace
{
constexpr int MinimumPoints = 16;
constexpr int MaximumPoints = 10000000;
} // namespace

vtkFieldLatentTextureFilter::vtkFieldLatentTextureFilter()
  : Impl(std::make_unique<Internals>(this))
{
  this->SetNumberOfInputPorts(2);
  this->SetNumberOfOutputPorts(3);
}

vtkFieldLatentTextureFilter::~vtkFieldLatentTextureFilter() = default;

void vtkFieldLatentTextureFilter::SetModelFileName(const char* name)
{
  surfsynth::SetString(this, this->ModelFileName, name);
}

void vtkFieldLatentTextureFilter::SetAutoencoderFileName(const char* name)
{
  surfsynth::SetString(this, this->AutoencoderFileName, name);
}

void vtkFieldLatentTextureFilter::SetLabelArrayName(const char* name)
{
  surfsynth::SetString(this, this->LabelArrayName, name);
}

void vtkFieldLatentTextureFilter::SetDirectionArrayName(const char* name)
{
  surfsynth::SetString(this, this->DirectionArrayName, name);
}

void vtkFieldLatentTextureFilter::SetMaskArrayName(const char* name)
{
  surfsynth::SetString(this, this->MaskArrayName, name);
}

void vtkFieldLatentTextureFilter::SetColorArrayName(const char* name)
{
  surfsynth::SetString(this, this->ColorArrayName, name);
}

void vtkFieldLatentTextureFilter::SetLatentArrayName(const char* name)
{
  surfsynth::SetString(this, this->LatentArrayName, name);
}

void vtkFieldLatentTextureFilter::SetTextureArrayName(const char* name)
{
  surfsynth::SetString(this, this->TextureArrayName, name);
}

void vtkFieldLatentTextureFilter::SetNumberOfPoints(int number)
{
  const int clamped = number <= 0 ? 0 : std::clamp(number, MinimumPoints, MaximumPoints);
  if (clamped != this->NumberOfPoints)
  {
    this->NumberOfPoints = clamped;
    this->Modified();
  }
}

void vtkFieldLatentTextureFilter::SetResolution(int width, int height)
{
  const auto size = surfsynth::TextureResolution(width, height);
  if (size[0] != this->Resolution[0] || size[1] != this->Resolution[1])
  {
    std::copy(size.begin(), size.end(), this->Resolution);
    this->Modified();
  }
}

int vtkFieldLatentTextureFilter::FillInputPortInformation(int port, vtkInformation* info)
{
  if (port == 1)
  {
    info->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1);
    info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkImageData");
    return 1;
  }
  return surfsynth::AcceptBlocks(info, surfsynth::SurfaceToSurface);
}

int vtkFieldLatentTextureFilter::FillOutputPortInformation(int, vtkInformation* info)
{
  info->Set(vtkDataObject::DATA_TYPE_NAME(), "vtkDataObject");
  return 1;
}

int vtkFieldLatentTextureFilter::RequestDataObject(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  const bool isSeries = this->NumberOfSamples > 1;
  if (!surfsynth::RequestBlocks(this, inputVector, outputVector, surfsynth::SurfaceToSurface, isSeries))
  {
    return 0;
  }
  vtkDataObject* input = vtkDataObject::GetData(inputVector[0]);
  const std::pair<int, std::string> ports[] = { { Internals::ImagePort, "vtkImageData" },
    { Internals::LatentPort, "vtkPolyData" } };
  for (const auto& [port, datasetClass] : ports)
  {
    const std::string name = isSeries          ? "vtkMultiBlockDataSet"
      : vtkDataObjectTree::SafeDownCast(input) ? input->GetClassName()
                                               : datasetClass;
    vtkInformation* info = outputVector->GetInformationObject(port);
    vtkDataObject* held = vtkDataObject::GetData(info);
    if (!held || name != held->GetClassName())
    {
      info->Set(vtkDataObject::DATA_OBJECT(), surfsynth::NewDataObject(name));
    }
  }
  return 1;
}

int vtkFieldLatentTextureFilter::RequestInformation(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  std::vector<double> times;
  for (int k = 0; this->OutputTrajectory && k <= this->NumberOfSteps; ++k)
  {
    times.push_back(static_cast<double>(k) / this->NumberOfSteps);
  }
  const double range[2] = { 0.0, 1.0 };
  for (int port = 0; port < this->GetNumberOfOutputPorts(); ++port)
  {
    vtkInformation* output = outputVector->GetInformationObject(port);
    if (this->OutputTrajectory)
    {
      output->Set(Pipeline::TIME_STEPS(), times.data(), static_cast<int>(times.size()));
      output->Set(Pipeline::TIME_RANGE(), range, 2);
      continue;
    }
    // The times of the input, or none: those of an earlier trajectory go.
    output->CopyEntry(inputVector[0]->GetInformationObject(0), Pipeline::TIME_STEPS());
    output->CopyEntry(inputVector[0]->GetInformationObject(0), Pipeline::TIME_RANGE());
  }
  vtkInformation* images = outputVector->GetInformationObject(Internals::ImagePort);
  if (vtkImageData::SafeDownCast(vtkDataObject::GetData(images)))
  {
    const int extent[6] = { 0, this->Resolution[0] - 1, 0, this->Resolution[1] - 1, 0, 0 };
    images->Set(Pipeline::WHOLE_EXTENT(), extent, 6);
    vtkDataObject::SetPointDataActiveScalarInfo(images, VTK_UNSIGNED_CHAR, 3);
  }
  return 1;
}

int vtkFieldLatentTextureFilter::RequestUpdateExtent(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector*)
{
  if (this->OutputTrajectory)
  {
    // The time of the reverse process is no time of the input.
    inputVector[0]->GetInformationObject(0)->Remove(Pipeline::UPDATE_TIME_STEP());
  }
  surfsynth::RequestWhole(inputVector[1]);
  return 1;
}

int vtkFieldLatentTextureFilter::RequestData(
  vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  const int asked = std::max(request->Get(vtkDemandDrivenPipeline::FROM_OUTPUT_PORT()), 0);
  vtkInformation* info = outputVector->GetInformationObject(asked);
  const bool hasTime = this->OutputTrajectory && info->Has(Pipeline::UPDATE_TIME_STEP());
  const double time = hasTime ? std::clamp(info->Get(Pipeline::UPDATE_TIME_STEP()), 0.0, 1.0) : 1.0;
  vtkDataObject::GetData(outputVector, Internals::ImagePort)->Initialize();
  vtkDataObject::GetData(outputVector, Internals::LatentPort)->Initialize();
  std::string problem;
  try
  {
    this->Impl->Begin(inputVector, time);
    const auto synthesize = [this](const surfsynth::Block& block, const surfsynth::Progress& progress) {
      this->Impl->Synthesize(block, progress);
    };
    const int success = surfsynth::ProcessBlocks(
      this, inputVector, outputVector, surfsynth::SurfaceToSurface, synthesize, this->Impl->Series());
    if (outputVector->GetInformationObject(0)->Has(vtkDemandDrivenPipeline::DATA_NOT_GENERATED()))
    {
      outputVector->GetInformationObject(Internals::ImagePort)->Set(vtkDemandDrivenPipeline::DATA_NOT_GENERATED(), 1);
      outputVector->GetInformationObject(Internals::LatentPort)->Set(vtkDemandDrivenPipeline::DATA_NOT_GENERATED(), 1);
    }
    else if (success)
    {
      this->Impl->End(vtkDataObject::GetData(inputVector[0]), outputVector);
      this->SetTimeOfOutputs(outputVector, time);
      surfsynth::AnnounceEmptyImage(outputVector->GetInformationObject(Internals::ImagePort));
    }
    this->Impl->Release();
    return success;
  }
  catch (const std::bad_alloc&)
  {
    problem = "There is not enough memory for the models.";
  }
  catch (const std::exception& error)
  {
    problem = error.what();
  }
  this->Impl->Release();
  surfsynth::ReportError(this, "", problem);
  vtkDataObject::GetData(outputVector)->Initialize();
  return 0;
}

void vtkFieldLatentTextureFilter::SetTimeOfOutputs(vtkInformationVector* outputVector, double time) const
{
  for (int port = 0; this->OutputTrajectory && port < outputVector->GetNumberOfInformationObjects(); ++port)
  {
    vtkDataObject::GetData(outputVector, port)->GetInformation()->Set(vtkDataObject::DATA_TIME_STEP(), time);
  }
}

std::string vtkFieldLatentTextureFilter::GetModelDescription() const
{
  return this->Impl->Model() ? this->Impl->Model()->Description() : "";
}

vtkStringArray* vtkFieldLatentTextureFilter::GetInstalledModels()
{
  return this->Impl->InstalledModels.Names("field_latent_diffusion");
}

vtkStringArray* vtkFieldLatentTextureFilter::GetInstalledAutoencoders()
{
  return this->Impl->InstalledAutoencoders.Names("field_latents");
}

const char* vtkFieldLatentTextureFilter::GetInstalledModelsFolder() const
{
  return this->Impl->InstalledModels.Folder();
}

vtkTypeInt64 vtkFieldLatentTextureFilter::GetNumberOfVertices() const { return this->Impl->NumberOfVertices; }

vtkTypeInt64 vtkFieldLatentTextureFilter::GetNumberOfModelLoads() const { return this->Impl->Models.NumberOfLoads(); }

vtkTypeInt64 vtkFieldLatentTextureFilter::GetNumberOfTriangulations() const
{
  return this->Impl->NumberOfTriangulations;
}

vtkTypeInt64 vtkFieldLatentTextureFilter::GetNumberOfEvaluations() const { return this->Impl->NumberOfEvaluations; }

void vtkFieldLatentTextureFilter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "ModelFileName: " << this->ModelFileName << "\n";
  os << indent << "AutoencoderFileName: " << this->AutoencoderFileName << "\n";
  os << indent << "LabelArrayName: " << this->LabelArrayName << "\n";
  os << indent << "DirectionArrayName: " << this->DirectionArrayName << "\n";
  os << indent << "MaskArrayName: " << this->MaskArrayName << "\n";
  os << indent << "ColorArrayName: " << this->ColorArrayName << "\n";
  os << indent << "Triangulation: " << this->Triangulation << "\n";
  os << indent << "NumberOfPoints: " << this->NumberOfPoints << "\n";
  os << indent << "Sampler: " << this->Sampler << "\n";
  os << indent << "NumberOfSteps: " << this->NumberOfSteps << "\n";
  os << indent << "Seed: " << this->Seed << "\n";
  os << indent << "NumberOfSamples: " << this->NumberOfSamples << "\n";
  os << indent << "FirstSample: " << this->FirstSample << "\n";
  os << indent << "OutputTrajectory: " << this->OutputTrajectory << "\n";
  os << indent << "Resolution: " << this->Resolution[0] << " x " << this->Resolution[1] << "\n";
  os << indent << "GutterWidth: " << this->GutterWidth << "\n";
  os << indent << "LatentArrayName: " << this->LatentArrayName << "\n";
  os << indent << "TextureArrayName: " << this->TextureArrayName << "\n";
  os << indent << "MemoryLimit: " << this->MemoryLimit << "\n";
  os << indent << "ModelDescription: " << this->GetModelDescription() << "\n";
  os << indent << "NumberOfVertices: " << this->GetNumberOfVertices() << "\n";
  os << indent << "NumberOfModelLoads: " << this->GetNumberOfModelLoads() << "\n";
  os << indent << "NumberOfTriangulations: " << this->GetNumberOfTriangulations() << "\n";
  os << indent << "NumberOfEvaluations: " << this->GetNumberOfEvaluations() << "\n";
}
