// SPDX-License-Identifier: BSD-3-Clause
#include "TextureSampleWriter.h"

#include "vtkFieldLatentTextureFilter.h"

#include "Core/Common/Errors.h"
#include "IO/Weights/OutputFile.h"

#include <vtkCallbackCommand.h>
#include <vtkCommand.h>
#include <vtkExecutive.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkUnsignedCharArray.h>

#include <string_view>

namespace surfsynth
{

namespace
{
constexpr int Texels = 512;

/// What the sampler says, and whether it is to go on.
struct SamplerWatch
{
  std::string Errors;
  const std::function<bool()>* GoOn;
};

/// Keeps errors without VTK's "ERROR: In FILE, line LINE" and the name of the object, keeps warnings from the console: they
/// are those of vtkFieldLatentTextureFilter for the same surface.
void Observe(vtkObject* caller, unsigned long event, void* data, void* text)
{
  auto& watch = *static_cast<SamplerWatch*>(data);
  if (event == vtkCommand::ErrorEvent)
  {
    const std::string said = static_cast<const char*>(text);
    const std::size_t prefix = said.find("): ");
    watch.Errors += prefix == std::string::npos ? said : said.substr(prefix + 3);
  }
  else if (event == vtkCommand::ProgressEvent && !(*watch.GoOn)())
  {
    static_cast<vtkAlgorithm*>(caller)->SetAbortExecute(1);
  }
}
} // namespace

void TextureSampleWriter::operator()(const std::function<bool()>& goOn) const
{
  if (!this->Problem->empty())
  {
    return;
  }
  try
  {
    this->Write(goOn);
  }
  catch (const InvalidInput& error)
  {
    *this->Problem = error.what();
  }
}

void TextureSampleWriter::Write(const std::function<bool()>& goOn) const
{
  SamplerWatch watch{ "", &goOn };
  vtkNew<vtkCallbackCommand> observer;
  observer->SetCallback(Observe);
  observer->SetClientData(&watch);
  vtkNew<vtkFieldLatentTextureFilter> sampler;
  for (const auto event : { vtkCommand::ErrorEvent, vtkCommand::WarningEvent, vtkCommand::ProgressEvent })
  {
    sampler->AddObserver(event, observer);
  }
  sampler->GetExecutive()->AddObserver(vtkCommand::ErrorEvent, observer);
  sampler->SetInputData(this->Mesh);
  sampler->SetModelFileName(this->Model.c_str());
  sampler->SetAutoencoderFileName(this->Autoencoder.c_str());
  sampler->SetLabelArrayName(this->LabelArrayName.c_str());
  sampler->SetDirectionArrayName(this->DirectionArrayName.c_str());
  sampler->SetSeed(this->Seed);
  sampler->SetNumberOfSteps(this->NumberOfSteps);
  sampler->SetResolution(Texels, Texels);
  sampler->Update();
  const bool stopped = !goOn();
  auto* image = vtkImageData::SafeDownCast(sampler->GetOutputDataObject(1));
  if (stopped)
  {
    return;
  }
  if (!watch.Errors.empty() || !image || image->GetNumberOfPoints() == 0)
  {
    throw InvalidInput("The sample of SampleFileName cannot be made: " +
      (watch.Errors.empty() ? std::string("there is no texture.") : watch.Errors));
  }
  vtkNew<vtkPNGWriter> writer;
  writer->SetInputData(image);
  writer->WriteToMemoryOn();
  writer->Write();
  vtkUnsignedCharArray* bytes = writer->GetResult();
  WriteOutputFile(this->Path,
    std::string_view(
      reinterpret_cast<const char*>(bytes->GetPointer(0)), static_cast<std::size_t>(bytes->GetNumberOfValues())),
    "vtkLatentDiffusionTrainer");
}

} // namespace surfsynth
