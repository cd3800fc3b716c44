// SPDX-License-Identifier: BSD-3-Clause
#include "TextureSampleWriter.h"

#include "vtkFieldLatentTextureFilter.h"

#include "Core/Common/Errors.h"
#include "IO/Weights/OutputFile.h"

#include <vtkCallbackCommand.h>
#include <vtkCommand.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkUnsignedCharArray.h>

#include <string_view>

namespace surfsynth
{

namespace
{
constexpr int Steps = 20;
constexpr int Texels = 512;

void AppendText(vtkObject*, unsigned long, void* texts, void* text)
{
  *static_cast<std::string*>(texts) += static_cast<const char*>(text);
}
} // namespace

void TextureSampleWriter::operator()() const
{
  std::string errors;
  vtkNew<vtkCallbackCommand> collect;
  collect->SetCallback(AppendText);
  collect->SetClientData(&errors);
  vtkNew<vtkFieldLatentTextureFilter> sampler;
  sampler->AddObserver(vtkCommand::ErrorEvent, collect);
  sampler->SetInputData(this->Mesh);
  sampler->SetModelFileName(this->Model.c_str());
  sampler->SetAutoencoderFileName(this->Autoencoder.c_str());
  sampler->SetLabelArrayName(this->LabelArrayName.c_str());
  sampler->SetDirectionArrayName(this->DirectionArrayName.c_str());
  sampler->SetSeed(this->Seed);
  sampler->SetNumberOfSteps(Steps);
  sampler->SetResolution(Texels, Texels);
  sampler->Update();
  if (!errors.empty())
  {
    throw InvalidInput("The sample of SampleFileName cannot be made: " + errors);
  }
  vtkNew<vtkPNGWriter> writer;
  writer->SetInputData(sampler->GetOutputDataObject(1));
  writer->WriteToMemoryOn();
  writer->Write();
  vtkUnsignedCharArray* bytes = writer->GetResult();
  WriteOutputFile(this->Path,
    std::string_view(
      reinterpret_cast<const char*>(bytes->GetPointer(0)), static_cast<std::size_t>(bytes->GetNumberOfValues())),
    "vtkLatentDiffusionTrainer");
}

} // namespace surfsynth
