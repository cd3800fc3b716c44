// SPDX-License-Identifier: BSD-3-Clause
#include "vtkFieldLatentDecoder.h"

#include "AtlasPlaces.h"
#include "BlockBridge.h"
#include "BlockCache.h"
#include "DataObjects.h"
#include "FileCache.h"
#include "FilterSupport.h"
#include "InstalledModelList.h"
#include "LatentArrays.h"
#include "Reporting.h"
#include "SampleMemory.h"
#include "SampleOutputs.h"
#include "SurfaceBridge.h"
#include "SurfaceCoordinates.h"
#include "SurfaceInputs.h"
#include "TextureDecoding.h"
#include "TextureImages.h"
#include "WeldedSurface.h"
#include "WholeInput.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "IO/Weights/InstalledModels.h"
#include "Inference/FieldLatents/FieldLatentDecoder.h"

#include <vtkDataObject.h>
#include <vtkDataObjectTree.h>
#include <vtkImageData.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkStreamingDemandDrivenPipeline.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <new>
#include <optional>
#include <utility>

using surfsynth::Surface;
using surfsynth::WeldedSurface;
using Pipeline = vtkStreamingDemandDrivenPipeline;

vtkStandardNewMacro(vtkFieldLatentDecoder);

namespace
{
/// Fraction of the work on a surface before its texture is decoded.
constexpr double BeforeDecoding = 0.3;

/// Converts and checks a target. @throws InvalidInput
Surface ToTarget(vtkPolyData* polydata)
{
  surfsynth::MeshRequirements requirements;
  requirements.ManifoldEdges = false;
  try
  {
    return surfsynth::ToSurface(polydata, requirements);
  }
  catch (const surfsynth::InvalidInput& error)
  {
    throw surfsynth::InvalidInput(std::string("The target on port 1: ") + error.what());
  }
}
} // namespace

/// Model, meshes and atlases of the last update.
class vtkFieldLatentDecoder::Internals
{
public:
  explicit Internals(vtkFieldLatentDecoder* self)
    : Self(self)
  {}

  /// Checks the properties and reads the model file. @throws the errors of the reader.
  void Begin(vtkInformationVector** inputVector)
  {
    this->RequireNames();
    vtkDataObject* input = vtkDataObject::GetData(inputVector[0]);
    this->RequireMemory(input);
    this->HasTarget = this->Self->GetNumberOfInputConnections(1) > 0;
    this->Target = this->HasTarget ? surfsynth::SurfaceOn(inputVector[1]) : nullptr;
    if (this->HasTarget && !this->Target)
    {
      throw surfsynth::InvalidInput("The target on port 1 is " +
        surfsynth::DescribeInput(vtkDataObject::GetData(inputVector[1])) + "; one vtkPolyData is needed.");
    }
    if (this->HasTarget && vtkDataObjectTree::SafeDownCast(input))
    {
      throw surfsynth::InvalidInput(
        "The input on port 0 is a composite dataset, and there is a target on port 1; a target "
        "needs one vtkPolyData on port 0 (vtkExtractBlock, vtkMergeBlocks).");
    }
    const auto model = this->File.Get(surfsynth::ExistingModelPath(this->Self->ModelFileName));
    if (model != this->Model)
    {
      this->Decoder.reset(); // first, so that the weights of two models are never held
      this->Model = model;
      this->Decoder.emplace(*model);
    }
    this->Images.clear();
    this->Blocks.Begin();
    this->Atlases.Begin();
  }

  /// Fills the second output from the images of the blocks, and forgets what the input no longer has.
  void End(vtkDataObject* input, vtkDataObject* output)
  {
    surfsynth::FillPort(input, surfsynth::OutputSeries(), "vtkImageData", this->Images, output);
    this->Blocks.DropUnused();
    this->Atlases.DropUnused();
  }

  /// Releases what only an update needs.
  void Release()
  {
    this->Images.clear();
    this->Target = nullptr;
  }

  void Decode(const surfsynth::Block& block, const surfsynth::Progress& progress)
  {
    auto* input = vtkPolyData::SafeDownCast(block.Input);
    if (this->HasTarget && surfsynth::IsEmpty(this->Target))
    {
      return;
    }
    Surface surface = surfsynth::ConvertSurface(input);
    surface.FlatIndex = block.FlatIndex;
    surface.Where = block.Where;
    vtkPolyData* shown = this->HasTarget ? this->Target.Get() : input;
    std::optional<Surface> target;
    if (this->HasTarget)
    {
      target = ToTarget(shown);
    }
    const Surface& onto = target ? *target : surface;
    this->RequireOtherName(shown);
    // Errors of texture coordinates and codes are reported before long work.
    surfsynth::TextureCoordinates coordinates = surfsynth::ReadTextureCoordinates(shown, onto);
    surfsynth::RequireAtlas(coordinates, onto);
    const WeldedSurface& welded = this->Welded(surface);
    const surfsynth::LatentField field = surfsynth::ReadLatentArrays(
      input, surface, welded, this->Self->LatentArrayName, this->Model->Options.LatentDimension);
    this->Warn(surface.Where, field.Warning);
    this->Warn(surface.Where, surfsynth::DescribeDegenerateCoordinates(coordinates, onto));
    const surfsynth::AtlasPlaces& atlas = this->Atlas(
      surface, onto, std::move(coordinates), surfsynth::SubProgress(progress, 0.05, BeforeDecoding));
    this->Warn(surface.Where, atlas.Warning);
    vtkPolyData* output = vtkPolyData::SafeDownCast(block.Output);
    output->ShallowCopy(shown);
    this->Images[{ 0, block.FlatIndex }] = surfsynth::DecodeTexture(*this->Decoder, field, welded, atlas,
      this->Self->TextureArrayName, this->Self->Resolution, output,
      surfsynth::SubProgress(progress, BeforeDecoding, 1.0));
  }

  std::shared_ptr<const surfsynth::FieldLatentModel> Model; ///< of this update
  surfsynth::FileCache<surfsynth::FieldLatentModel> File{ [](const std::string& path) {
                                                           return surfsynth::ReadFieldLatents(path);
                                                         },
    "A field-latent model in safetensors format is needed, as the training of field latents writes it." };
  surfsynth::InstalledModelList Installed;
  vtkTypeInt64 NumberOfRingComputations = 0;
  vtkTypeInt64 NumberOfRasterizations = 0;

private:
  void RequireNames() const
  {
    const std::pair<const std::string*, const char*> names[] = { { &this->Self->ModelFileName, "ModelFileName" },
      { &this->Self->LatentArrayName, "LatentArrayName" }, { &this->Self->TextureArrayName, "TextureArrayName" } };
    for (const auto& [value, property] : names)
    {
      if (value->empty())
      {
        throw surfsynth::InvalidInput(std::string(property) + " is empty; " +
          (value == names[0].first ? "the path of a field-latent model is needed."
                                   : "a name for the arrays is needed."));
      }
    }
  }

  /// Refuses a TextureArrayName that names another array of the output.
  void RequireOtherName(vtkPolyData* shown) const
  {
    const std::string& name = this->Self->TextureArrayName;
    vtkDataArray* coordinates = shown->GetPointData()->GetTCoords();
    const bool isCoordinates = coordinates && coordinates->GetName() && name == coordinates->GetName();
    if (isCoordinates || (!this->HasTarget && surfsynth::IsLatentName(name, this->Self->LatentArrayName)))
    {
      throw surfsynth::InvalidInput("TextureArrayName is \"" + name + "\", the name of " +
        (isCoordinates ? "the texture coordinates" : "an array of field latents (LatentArrayName)") +
        "; another name is needed.");
    }
  }

  /// Refuses a Resolution that does not fit into the limit of memory.
  void RequireMemory(vtkDataObject* input) const
  {
    const double blocks = surfsynth::SizesOfBlocks(input).first;
    const int* size = this->Self->Resolution;
    const double needed = blocks * size[0] * size[1] * (surfsynth::AtlasPlaces::BytesOfTexel + 3.0);
    const double limit = this->Self->MemoryLimit > 0 ? this->Self->MemoryLimit * 1048576.0
                                                     : static_cast<double>(surfsynth::DefaultMemoryLimit());
    if (limit > 0.0 && needed > limit)
    {
      const double factor = std::sqrt(limit / needed);
      const auto fitting = [&](int k) { return std::to_string(static_cast<int>(factor * size[k])); };
      throw surfsynth::InvalidInput("A Resolution of " + std::to_string(size[0]) + " x " + std::to_string(size[1]) +
        " texels takes about " + surfsynth::FormatNumber(std::ceil(needed / 1048576.0)) + " MiB; at most " +
        surfsynth::FormatNumber(std::floor(limit / 1048576.0)) + " MiB are allowed (MemoryLimit). " + fitting(0) +
        " x " + fitting(1) + " texels fit.");
    }
  }

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

  /// Returns the places of the atlas of this block, from an earlier update when nothing that they depend on has changed.
  const surfsynth::AtlasPlaces& Atlas(const Surface& surface, const Surface& onto,
    surfsynth::TextureCoordinates coordinates, const surfsynth::Progress& progress)
  {
    const surfsynth::AtlasRasterOptions options = surfsynth::RasterOptionsOf(
      this->Self->Resolution, this->Self->GutterWidth);
    const bool isSource = !this->HasTarget;
    const auto isCurrent = [&](const surfsynth::AtlasPlaces& held) {
      return held.Is(onto, isSource, coordinates, options);
    };
    if (const surfsynth::AtlasPlaces* found = this->Atlases.Find(surface, isCurrent))
    {
      return *found;
    }
    this->Atlases.Drop(surface);
    surfsynth::AtlasPlaces atlas(
      *this->Blocks.Find(surface), onto, isSource, std::move(coordinates), options, progress);
    ++this->NumberOfRasterizations;
    return this->Atlases.Insert(surface, std::move(atlas));
  }

  void Warn(const std::string& where, const std::string& text) const
  {
    if (!text.empty())
    {
      surfsynth::ReportWarning(this->Self, where, text);
    }
  }

  vtkFieldLatentDecoder* Self;
  std::optional<surfsynth::FieldLatentDecoder> Decoder; ///< of Model
  bool HasTarget = false;
  vtkSmartPointer<vtkPolyData> Target; ///< during an update
  surfsynth::SampleResults Images;     ///< of this update
  surfsynth::BlockCache<WeldedSurface> Blocks;
  surfsynth::BlockCache<surfsynth::AtlasPlaces> Atlases;
};

vtkFieldLatentDecoder::vtkFieldLatentDecoder()
  : Impl(std::make_unique<Internals>(this))
{
  this->SetNumberOfInputPorts(2);
  this->SetNumberOfOutputPorts(2);
}

vtkFieldLatentDecoder::~vtkFieldLatentDecoder() = default;

void vtkFieldLatentDecoder::SetModelFileName(const char* name)
{
  surfsynth::SetString(this, this->ModelFileName, name);
}

void vtkFieldLatentDecoder::SetLatentArrayName(const char* name)
{
  surfsynth::SetString(this, this->LatentArrayName, name);
}

void vtkFieldLatentDecoder::SetTextureArrayName(const char* name)
{
  surfsynth::SetString(this, this->TextureArrayName, name);
}

void vtkFieldLatentDecoder::SetResolution(int width, int height)
{
  const auto size = surfsynth::TextureResolution(width, height);
  if (size[0] != this->Resolution[0] || size[1] != this->Resolution[1])
  {
    std::copy(size.begin(), size.end(), this->Resolution);
    this->Modified();
  }
}

int vtkFieldLatentDecoder::FillInputPortInformation(int port, vtkInformation* info)
{
  if (port == 1)
  {
    info->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1);
    return surfsynth::AcceptSurface(info);
  }
  return surfsynth::AcceptBlocks(info, surfsynth::SurfaceToSurface);
}

int vtkFieldLatentDecoder::FillOutputPortInformation(int, vtkInformation* info)
{
  info->Set(vtkDataObject::DATA_TYPE_NAME(), "vtkDataObject");
  return 1;
}

int vtkFieldLatentDecoder::RequestDataObject(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  if (!surfsynth::RequestBlocks(this, inputVector, outputVector, surfsynth::SurfaceToSurface))
  {
    return 0;
  }
  vtkDataObject* input = vtkDataObject::GetData(inputVector[0]);
  const std::string name = vtkDataObjectTree::SafeDownCast(input) ? input->GetClassName() : "vtkImageData";
  vtkInformation* images = outputVector->GetInformationObject(1);
  vtkDataObject* held = vtkDataObject::GetData(images);
  if (!held || name != held->GetClassName())
  {
    images->Set(vtkDataObject::DATA_OBJECT(), surfsynth::NewDataObject(name));
  }
  return 1;
}

int vtkFieldLatentDecoder::RequestInformation(
  vtkInformation*, vtkInformationVector**, vtkInformationVector* outputVector)
{
  vtkInformation* images = outputVector->GetInformationObject(1);
  if (vtkImageData::SafeDownCast(vtkDataObject::GetData(images)))
  {
    const int extent[6] = { 0, this->Resolution[0] - 1, 0, this->Resolution[1] - 1, 0, 0 };
    images->Set(Pipeline::WHOLE_EXTENT(), extent, 6);
    vtkDataObject::SetPointDataActiveScalarInfo(images, VTK_UNSIGNED_CHAR, 3);
  }
  return 1;
}

int vtkFieldLatentDecoder::RequestUpdateExtent(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector*)
{
  surfsynth::RequestWhole(inputVector[1]);
  return 1;
}

int vtkFieldLatentDecoder::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  vtkDataObject* images = vtkDataObject::GetData(outputVector, 1);
  images->Initialize();
  std::string problem;
  try
  {
    this->Impl->Begin(inputVector);
    const auto decode = [this](const surfsynth::Block& block, const surfsynth::Progress& progress) {
      this->Impl->Decode(block, progress);
    };
    const int success = surfsynth::ProcessBlocks(this, inputVector, outputVector, surfsynth::SurfaceToSurface, decode);
    if (outputVector->GetInformationObject(0)->Has(vtkDemandDrivenPipeline::DATA_NOT_GENERATED()))
    {
      outputVector->GetInformationObject(1)->Set(vtkDemandDrivenPipeline::DATA_NOT_GENERATED(), 1);
    }
    else if (success)
    {
      this->Impl->End(vtkDataObject::GetData(inputVector[0]), images);
      surfsynth::AnnounceEmptyImage(outputVector->GetInformationObject(1));
    }
    this->Impl->Release();
    return success;
  }
  catch (const std::bad_alloc&)
  {
    problem = "There is not enough memory for the model.";
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

std::string vtkFieldLatentDecoder::GetModelDescription() const
{
  return this->Impl->Model ? this->Impl->Model->Description() : "";
}

vtkStringArray* vtkFieldLatentDecoder::GetInstalledModels() { return this->Impl->Installed.Names("field_latents"); }

const char* vtkFieldLatentDecoder::GetInstalledModelsFolder() const { return this->Impl->Installed.Folder(); }

vtkTypeInt64 vtkFieldLatentDecoder::GetNumberOfModelLoads() const { return this->Impl->File.NumberOfLoads(); }

vtkTypeInt64 vtkFieldLatentDecoder::GetNumberOfRingComputations() const { return this->Impl->NumberOfRingComputations; }

vtkTypeInt64 vtkFieldLatentDecoder::GetNumberOfRasterizations() const { return this->Impl->NumberOfRasterizations; }

void vtkFieldLatentDecoder::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "ModelFileName: " << this->ModelFileName << "\n";
  os << indent << "Resolution: " << this->Resolution[0] << " x " << this->Resolution[1] << "\n";
  os << indent << "GutterWidth: " << this->GutterWidth << "\n";
  os << indent << "LatentArrayName: " << this->LatentArrayName << "\n";
  os << indent << "TextureArrayName: " << this->TextureArrayName << "\n";
  os << indent << "MemoryLimit: " << this->MemoryLimit << "\n";
  os << indent << "ModelDescription: " << this->GetModelDescription() << "\n";
  os << indent << "NumberOfModelLoads: " << this->GetNumberOfModelLoads() << "\n";
  os << indent << "NumberOfRingComputations: " << this->GetNumberOfRingComputations() << "\n";
  os << indent << "NumberOfRasterizations: " << this->GetNumberOfRasterizations() << "\n";
}
