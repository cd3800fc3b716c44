// SPDX-License-Identifier: BSD-3-Clause
#include "vtkGeometricTextureSynthesizer.h"

#include "BlockBridge.h"
#include "FilterSupport.h"
#include "GeometricTextureSynthesizerInternals.h"
#include "Reporting.h"

#include <vtkDataObject.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkStreamingDemandDrivenPipeline.h>

#include <exception>
#include <new>
#include <optional>
#include <string>
#include <vector>

using Pipeline = vtkStreamingDemandDrivenPipeline;

vtkStandardNewMacro(vtkGeometricTextureSynthesizer);

vtkGeometricTextureSynthesizer::vtkGeometricTextureSynthesizer()
  : Impl(std::make_unique<Internals>(this))
{}

vtkGeometricTextureSynthesizer::~vtkGeometricTextureSynthesizer() = default;

void vtkGeometricTextureSynthesizer::SetModelFileName(const char* name)
{
  surfsynth::SetString(this, this->ModelFileName, name);
}

void vtkGeometricTextureSynthesizer::SetLevelsWithoutNoise(const char* name)
{
  surfsynth::SetString(this, this->LevelsWithoutNoise, name);
}

void vtkGeometricTextureSynthesizer::SetMaskArrayName(const char* name)
{
  surfsynth::SetString(this, this->MaskArrayName, name);
}

void vtkGeometricTextureSynthesizer::SetSizeArrayName(const char* name)
{
  surfsynth::SetString(this, this->SizeArrayName, name);
}

void vtkGeometricTextureSynthesizer::SetSecondModelFileName(const char* name)
{
  surfsynth::SetString(this, this->SecondModelFileName, name);
}

void vtkGeometricTextureSynthesizer::SetBlendArrayName(const char* name)
{
  surfsynth::SetString(this, this->BlendArrayName, name);
}

void vtkGeometricTextureSynthesizer::SetStrengthArrayName(const char* name)
{
  surfsynth::SetString(this, this->StrengthArrayName, name);
}

void vtkGeometricTextureSynthesizer::SetDisplacementArrayName(const char* name)
{
  surfsynth::SetString(this, this->DisplacementArrayName, name);
}

void vtkGeometricTextureSynthesizer::SetLevelArrayName(const char* name)
{
  surfsynth::SetString(this, this->LevelArrayName, name);
}

int vtkGeometricTextureSynthesizer::FillInputPortInformation(int, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1);
  return surfsynth::AcceptBlocks(info, surfsynth::SurfaceToSurface);
}

int vtkGeometricTextureSynthesizer::RequestDataObject(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  if (this->GetNumberOfInputConnections(0) > 0)
  {
    return surfsynth::RequestBlocks(this, inputVector, outputVector, surfsynth::SurfaceToSurface, this->OutputLevels);
  }
  surfsynth::SetOutputClass(outputVector, this->OutputLevels ? "vtkMultiBlockDataSet" : "vtkPolyData");
  return 1;
}

int vtkGeometricTextureSynthesizer::RequestInformation(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  vtkInformation* output = outputVector->GetInformationObject(0);
  output->Remove(Pipeline::TIME_STEPS());
  output->Remove(Pipeline::TIME_RANGE());
  if (this->Animation != NO_ANIMATION)
  {
    const std::vector<double> times = this->Impl->AnimationTimes();
    if (!times.empty())
    {
      const double range[2] = { times.front(), times.back() };
      output->Set(Pipeline::TIME_STEPS(), times.data(), static_cast<int>(times.size()));
      output->Set(Pipeline::TIME_RANGE(), range, 2);
    }
  }
  else if (this->GetNumberOfInputConnections(0) > 0)
  {
    output->CopyEntry(inputVector[0]->GetInformationObject(0), Pipeline::TIME_STEPS());
    output->CopyEntry(inputVector[0]->GetInformationObject(0), Pipeline::TIME_RANGE());
  }
  return 1;
}

int vtkGeometricTextureSynthesizer::RequestUpdateExtent(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector*)
{
  if (this->Animation != NO_ANIMATION && this->GetNumberOfInputConnections(0) > 0)
  {
    // The time of an animation is no time of the input.
    inputVector[0]->GetInformationObject(0)->Remove(Pipeline::UPDATE_TIME_STEP());
  }
  return 1;
}

int vtkGeometricTextureSynthesizer::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  vtkInformation* info = outputVector->GetInformationObject(0);
  std::optional<double> time;
  if (this->Animation != NO_ANIMATION && info->Has(Pipeline::UPDATE_TIME_STEP()))
  {
    time = info->Get(Pipeline::UPDATE_TIME_STEP());
  }
  std::string problem;
  try
  {
    const bool fromTemplate = this->GetNumberOfInputConnections(0) == 0;
    this->Impl->Begin(time, fromTemplate);
    vtkNew<vtkInformationVector> targets;
    targets->Append(
      fromTemplate ? this->Impl->TemplateInformation(info).Get() : inputVector[0]->GetInformationObject(0));
    if (this->Synthesize(targets, outputVector))
    {
      if (time)
      {
        vtkDataObject::GetData(info)->GetInformation()->Set(vtkDataObject::DATA_TIME_STEP(), *time);
      }
      return 1;
    }
  }
  catch (const std::bad_alloc&)
  {
    problem = "There is not enough memory for the texture.";
  }
  catch (const std::exception& error)
  {
    problem = error.what();
  }
  if (!problem.empty())
  {
    surfsynth::ReportError(this, "", problem);
  }
  vtkDataObject::GetData(info)->Initialize();
  return 0;
}

bool vtkGeometricTextureSynthesizer::Synthesize(vtkInformationVector* targets, vtkInformationVector* outputVector)
{
  const auto synthesize = [this](const surfsynth::Block& block, const surfsynth::Progress& progress) {
    this->Impl->Synthesize(block, progress);
  };
  vtkInformationVector* given[] = { targets };
  const int done = surfsynth::ProcessBlocks(
    this, given, outputVector, surfsynth::SurfaceToSurface, synthesize, this->Impl->Series());
  this->Impl->End();
  return done != 0;
}

bool vtkGeometricTextureSynthesizer::WriteModelWithStatistics(const char* fileName, int samples)
{
  std::string problem;
  try
  {
    this->Impl->WriteModelWithStatistics(fileName ? fileName : "", samples);
    return true;
  }
  catch (const std::bad_alloc&)
  {
    problem = "There is not enough memory for the samples.";
  }
  catch (const std::exception& error)
  {
    problem = error.what();
  }
  surfsynth::ReportError(this, "", problem);
  return false;
}

std::string vtkGeometricTextureSynthesizer::GetModelDescription() const
{
  return this->Impl->Model ? this->Impl->Model->Description() : "";
}

vtkTypeInt64 vtkGeometricTextureSynthesizer::GetNumberOfSelfIntersections() const
{
  return this->Impl->Printability.NumberOfPairsLeft();
}

double vtkGeometricTextureSynthesizer::GetHeightKept() const { return this->Impl->Printability.HeightKept(); }

vtkStringArray* vtkGeometricTextureSynthesizer::GetInstalledModels()
{
  return this->Impl->Installed.Names("geometric_texture");
}

const char* vtkGeometricTextureSynthesizer::GetInstalledModelsFolder() const { return this->Impl->Installed.Folder(); }

vtkTypeInt64 vtkGeometricTextureSynthesizer::GetNumberOfModelLoads() const
{
  return this->Impl->File.NumberOfLoads() + this->Impl->SecondFile.NumberOfLoads();
}

vtkTypeInt64 vtkGeometricTextureSynthesizer::GetNumberOfSyntheses() const { return this->Impl->NumberOfSyntheses; }

vtkTypeInt64 vtkGeometricTextureSynthesizer::GetNumberOfRemeshings() const { return this->Impl->NumberOfRemeshings; }

void vtkGeometricTextureSynthesizer::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "ModelFileName: " << this->ModelFileName << "\n";
  os << indent << "StartLevel: " << this->StartLevel << "\n";
  os << indent << "EndLevel: " << this->EndLevel << "\n";
  os << indent << "Seed: " << this->Seed << "\n";
  os << indent << "SecondSeed: " << this->SecondSeed << "\n";
  os << indent << "Interpolation: " << this->Interpolation << "\n";
  os << indent << "NoiseAmplitude: " << this->NoiseAmplitude << "\n";
  os << indent << "NumberOfRestarts: " << this->NumberOfRestarts << "\n";
  os << indent << "NormStatistics: " << this->NormStatistics << "\n";
  os << indent << "LevelsWithoutNoise: " << this->LevelsWithoutNoise << "\n";
  os << indent << "TargetPreparation: " << this->TargetPreparation << "\n";
  os << indent << "TextureScale: " << this->TextureScale << "\n";
  os << indent << "SizeArrayName: " << this->SizeArrayName << "\n";
  os << indent << "MaskArrayName: " << this->MaskArrayName << "\n";
  os << indent << "MaskFalloff: " << this->MaskFalloff << "\n";
  os << indent << "SecondModelFileName: " << this->SecondModelFileName << "\n";
  os << indent << "BlendArrayName: " << this->BlendArrayName << "\n";
  os << indent << "Strength: " << this->Strength << "\n";
  os << indent << "StrengthArrayName: " << this->StrengthArrayName << "\n";
  os << indent << "Printable: " << this->Printable << "\n";
  os << indent << "RandomFromLevel: " << this->RandomFromLevel << "\n";
  os << indent << "OutputLevels: " << this->OutputLevels << "\n";
  os << indent << "Animation: " << this->Animation << "\n";
  os << indent << "DisplacementArrayName: " << this->DisplacementArrayName << "\n";
  os << indent << "LevelArrayName: " << this->LevelArrayName << "\n";
  os << indent << "NumberOfSelfIntersections: " << this->GetNumberOfSelfIntersections() << "\n";
  os << indent << "HeightKept: " << this->GetHeightKept() << "\n";
  os << indent << "ModelDescription: " << this->GetModelDescription() << "\n";
  os << indent << "NumberOfModelLoads: " << this->GetNumberOfModelLoads() << "\n";
  os << indent << "NumberOfSyntheses: " << this->GetNumberOfSyntheses() << "\n";
  os << indent << "NumberOfRemeshings: " << this->GetNumberOfRemeshings() << "\n";
}
