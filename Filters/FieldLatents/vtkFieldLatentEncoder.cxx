// SPDX-License-Identifier: BSD-3-Clause
#include "vtkFieldLatentEncoder.h"

#include "BlockBridge.h"
#include "BlockCache.h"
#include "FileCache.h"
#include "FilterSupport.h"
#include "InstalledModelList.h"
#include "LatentArrays.h"
#include "Reporting.h"
#include "SurfaceBridge.h"
#include "SurfaceCoordinates.h"
#include "TextureColors.h"
#include "TextureEncoding.h"
#include "WeldedSurface.h"
#include "WholeInput.h"

#include "Core/Common/Errors.h"
#include "IO/Weights/InstalledModels.h"
#include "Inference/FieldLatents/FieldLatentEncoder.h"

#include <vtkDataArray.h>
#include <vtkDataObject.h>
#include <vtkImageData.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>

#include <exception>
#include <new>
#include <optional>
#include <utility>
#include <vector>

using surfsynth::Surface;
using surfsynth::WeldedSurface;

vtkStandardNewMacro(vtkFieldLatentEncoder);

namespace
{
/// Fraction of the work on a surface after its rings are unfolded.
constexpr double AfterUnfolding = 0.1;
} // namespace

/// Model, image and meshes of the last update.
class vtkFieldLatentEncoder::Internals
{
public:
  explicit Internals(vtkFieldLatentEncoder* self)
    : Self(self)
  {}

  /// Reads model file and texture image. @throws the errors of the readers.
  void Begin(vtkInformationVector* imagePort)
  {
    if (this->Self->ModelFileName.empty())
    {
      throw surfsynth::InvalidInput("ModelFileName is empty; the path of a field-latent model is needed.");
    }
    if (this->Self->LatentArrayName.empty())
    {
      throw surfsynth::InvalidInput("LatentArrayName is empty; a name for the arrays is needed.");
    }
    const auto model = this->File.Get(surfsynth::ExistingModelPath(this->Self->ModelFileName));
    if (model != this->Model)
    {
      this->Encoder.reset(); // first, so that the weights of two models are never held
      this->Model = model;
      this->Encoder.emplace(*model);
    }
    this->Image.reset();
    if (this->Self->GetNumberOfInputConnections(1) > 0)
    {
      auto* image = vtkImageData::SafeDownCast(vtkDataObject::GetData(imagePort));
      if (!image)
      {
        throw surfsynth::InvalidInput("The texture image on port 1 is missing; a vtkImageData is needed.");
      }
      this->Image.emplace(image);
      this->Warn("", this->Image->Colors.Remarks);
    }
    this->Blocks.Begin();
  }

  void End(bool isComplete)
  {
    this->Image.reset();
    if (isComplete)
    {
      this->Blocks.DropUnused();
    }
  }

  void Encode(const surfsynth::Block& block, const surfsynth::Progress& progress)
  {
    auto* input = vtkPolyData::SafeDownCast(block.Input);
    Surface surface = surfsynth::ConvertSurface(input);
    surface.FlatIndex = block.FlatIndex;
    surface.Where = block.Where;
    this->RequireOtherNames(input);
    const surfsynth::TextureColors colors = this->ColorsOf(input, surface);
    const WeldedSurface& welded = this->Welded(surface);
    surfsynth::Report(progress, AfterUnfolding);
    const surfsynth::FieldLatentCodes codes = surfsynth::EncodeColors(*this->Encoder, welded,
      surfsynth::ColorsOn(colors), surfsynth::VerticesOf(welded), this->Self->SamplesPerRing,
      surfsynth::SubProgress(progress, AfterUnfolding, 1.0));
    auto* output = vtkPolyData::SafeDownCast(block.Output);
    output->ShallowCopy(input);
    surfsynth::AddLatentArrays(welded, codes, this->Self->LatentArrayName, output);
  }

  std::shared_ptr<const surfsynth::FieldLatentModel> Model; ///< of this update
  surfsynth::FileCache<surfsynth::FieldLatentModel> File{ [](const std::string& path) {
                                                           return surfsynth::ReadFieldLatents(path);
                                                         },
    "A field-latent model in safetensors format is needed, as the training of field latents writes it." };
  surfsynth::InstalledModelList Installed;
  vtkTypeInt64 NumberOfRingComputations = 0;

private:
  /// Returns the welded surface of this block, from an earlier update when the mesh is the same.
  const WeldedSurface& Welded(const Surface& surface)
  {
    if (const WeldedSurface* found = this->Blocks.Find(surface))
    {
      return *found;
    }
    this->Blocks.Drop(surface);
    WeldedSurface welded(surface);
    ++this->NumberOfRingComputations;
    return this->Blocks.Insert(surface, std::move(welded));
  }

  /// Refuses names of the output that are those of the colors or texture coordinates.
  void RequireOtherNames(vtkPolyData* input) const
  {
    vtkPointData* data = input->GetPointData();
    vtkDataArray* colors = this->Self->ColorArrayName.empty() ? data->GetScalars()
                                                              : data->GetArray(this->Self->ColorArrayName.c_str());
    const std::pair<vtkDataArray*, const char*> roles[] = { { data->GetTCoords(), "texture coordinates" },
      { this->Image ? nullptr : colors, "colors" } };
    for (const auto& [array, role] : roles)
    {
      const std::string name = array && array->GetName() ? array->GetName() : "";
      if (surfsynth::IsLatentName(name, this->Self->LatentArrayName))
      {
        throw surfsynth::InvalidInput("The " + std::string(role) + " of the points are the array \"" + name +
          "\", a name that LatentArrayName gives to the output; another LatentArrayName is needed.");
      }
    }
  }

  surfsynth::TextureColors ColorsOf(vtkPolyData* input, const Surface& surface) const
  {
    if (!this->Image)
    {
      surfsynth::TextureColors colors(input, surface, this->Self->ColorArrayName);
      this->Warn(surface.Where, colors.Remarks);
      return colors;
    }
    surfsynth::TextureCoordinates coordinates = surfsynth::ReadTextureCoordinates(input, surface);
    const std::string degenerate = surfsynth::DescribeDegenerateCoordinates(coordinates, surface);
    if (!degenerate.empty())
    {
      this->Warn(surface.Where, { degenerate });
    }
    const bool repeats = this->Self->TextureWrap == REPEAT ||
      (this->Self->TextureWrap == AUTOMATIC && surfsynth::IsRepeated(coordinates, surface));
    const auto wrap = repeats ? surfsynth::TextureWrap::Repeat : surfsynth::TextureWrap::Clamp;
    return surfsynth::TextureColors(*this->Image, wrap, std::move(coordinates));
  }

  void Warn(const std::string& where, const std::vector<std::string>& remarks) const
  {
    for (const std::string& text : remarks)
    {
      surfsynth::ReportWarning(this->Self, where, text);
    }
  }

  vtkFieldLatentEncoder* Self;
  std::optional<surfsynth::FieldLatentEncoder> Encoder; ///< of Model
  std::optional<surfsynth::ColorImage> Image;           ///< during an update
  surfsynth::BlockCache<WeldedSurface> Blocks;
};

vtkFieldLatentEncoder::vtkFieldLatentEncoder()
  : Impl(std::make_unique<Internals>(this))
{
  this->SetNumberOfInputPorts(2);
}

vtkFieldLatentEncoder::~vtkFieldLatentEncoder() = default;

void vtkFieldLatentEncoder::SetModelFileName(const char* name)
{
  surfsynth::SetString(this, this->ModelFileName, name);
}

void vtkFieldLatentEncoder::SetColorArrayName(const char* name)
{
  surfsynth::SetString(this, this->ColorArrayName, name);
}

void vtkFieldLatentEncoder::SetLatentArrayName(const char* name)
{
  surfsynth::SetString(this, this->LatentArrayName, name);
}

int vtkFieldLatentEncoder::FillInputPortInformation(int port, vtkInformation* info)
{
  if (port == 1)
  {
    info->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1);
    info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkImageData");
    return 1;
  }
  return surfsynth::AcceptBlocks(info, surfsynth::SurfaceToSurface);
}

int vtkFieldLatentEncoder::RequestDataObject(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  return surfsynth::RequestBlocks(this, inputVector, outputVector, surfsynth::SurfaceToSurface);
}

int vtkFieldLatentEncoder::RequestUpdateExtent(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector*)
{
  surfsynth::RequestWhole(inputVector[1]);
  return 1;
}

int vtkFieldLatentEncoder::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  std::string problem;
  try
  {
    this->Impl->Begin(inputVector[1]);
    const auto encode = [this](const surfsynth::Block& block, const surfsynth::Progress& progress) {
      this->Impl->Encode(block, progress);
    };
    const int success = surfsynth::ProcessBlocks(this, inputVector, outputVector, surfsynth::SurfaceToSurface, encode);
    this->Impl->End(success != 0 && !this->GetAbortExecute());
    return success;
  }
  catch (const std::bad_alloc&)
  {
    problem = "There is not enough memory for the model and the texture image.";
  }
  catch (const std::exception& error)
  {
    problem = error.what();
  }
  surfsynth::ReportError(this, "", problem);
  vtkDataObject::GetData(outputVector)->Initialize();
  return 0;
}

std::string vtkFieldLatentEncoder::GetModelDescription() const
{
  return this->Impl->Model ? this->Impl->Model->Description() : "";
}

vtkStringArray* vtkFieldLatentEncoder::GetInstalledModels() { return this->Impl->Installed.Names("field_latents"); }

const char* vtkFieldLatentEncoder::GetInstalledModelsFolder() const { return this->Impl->Installed.Folder(); }

vtkTypeInt64 vtkFieldLatentEncoder::GetNumberOfModelLoads() const { return this->Impl->File.NumberOfLoads(); }

vtkTypeInt64 vtkFieldLatentEncoder::GetNumberOfRingComputations() const { return this->Impl->NumberOfRingComputations; }

void vtkFieldLatentEncoder::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "ModelFileName: " << this->ModelFileName << "\n";
  os << indent << "ColorArrayName: " << this->ColorArrayName << "\n";
  os << indent << "TextureWrap: " << this->TextureWrap << "\n";
  os << indent << "SamplesPerRing: " << this->SamplesPerRing << "\n";
  os << indent << "LatentArrayName: " << this->LatentArrayName << "\n";
  os << indent << "ModelDescription: " << this->GetModelDescription() << "\n";
  os << indent << "NumberOfModelLoads: " << this->GetNumberOfModelLoads() << "\n";
  os << indent << "NumberOfRingComputations: " << this->GetNumberOfRingComputations() << "\n";
}
