// SPDX-License-Identifier: BSD-3-Clause
#include "vtkGeometricTextureFromExample.h"

#include "BlockBridge.h"
#include "BlockCache.h"
#include "FileCache.h"
#include "FilterSupport.h"
#include "GeometricTextureMask.h"
#include "GeometricTextureSurface.h"
#include "InstalledModelList.h"
#include "PointRows.h"
#include "PrintabilityCount.h"
#include "Reporting.h"
#include "SurfaceBridge.h"
#include "SurfaceInputs.h"
#include "TextureExampleInput.h"
#include "WholeInput.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/MidpointSubdivision.h"
#include "Core/Mesh/UsedPoints.h"
#include "IO/Weights/InstalledModels.h"
#include "Inference/GeometricTexture/ExampleSynthesis.h"
#include "Inference/GeometricTexture/GeometricTextureExample.h"
#include "Inference/GeometricTexture/TextureExampleFile.h"

#include <vtkDataObject.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkObjectFactory.h>
#include <vtkPolyData.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>
#include <new>
#include <string>
#include <utility>

vtkStandardNewMacro(vtkGeometricTextureFromExample);

namespace
{
/// Share of the progress of a block that its synthesis is; the rest is the search for triangles that intersect.
constexpr double SynthesisPart = 0.8;

constexpr const char* FileAdvice =
  "a file with an example of a geometric texture is needed, or the name of an installed one (GetInstalledExamples()).";

bool IsConnected(vtkInformationVector* port) { return port->GetNumberOfInformationObjects() > 0; }

/// Returns true for the same request but for the stream, which is that of the block.
bool SameRequest(const surfsynth::ExampleSynthesisRequest& a, const surfsynth::ExampleSynthesisRequest& b)
{
  const bool sameDirections = a.Directions.rows() == b.Directions.rows() &&
    (a.Directions.array() == b.Directions.array()).all();
  return a.Scale == b.Scale && a.Subdivisions == b.Subdivisions && a.Seed == b.Seed &&
    surfsynth::SameValues(a.Sizes, b.Sizes) && surfsynth::SameValues(a.Blend, b.Blend) && sameDirections;
}
} // namespace

/// Example and textures of the last update, and the work of this update.
class vtkGeometricTextureFromExample::Internals
{
public:
  explicit Internals(vtkGeometricTextureFromExample* self)
    : Self(self)
  {}

  /// Reads the examples where they have changed. @throws InvalidInput, SolverFailure, Cancelled
  void Begin(vtkInformationVector** inputVector, const surfsynth::Progress& progress)
  {
    this->Textures.Begin();
    this->Mismatch = 0.0;
    this->Printability.Begin();
    const bool isBlend = IsConnected(inputVector[3]) || !this->Self->SecondExampleFileName.empty();
    this->CheckProperties();
    this->CheckExamples(inputVector, isBlend);
    this->Read(
      this->FirstInput, inputVector + 1, this->FirstFile, this->Self->ExampleFileName, this->Self->SmoothingLength);
    if (isBlend)
    {
      this->Read(this->SecondInput, inputVector + 3, this->SecondFile, this->Self->SecondExampleFileName,
        this->Self->SecondSmoothingLength);
    }
    else
    {
      this->SecondInput.Clear();
    }
    this->Cut(isBlend, progress);
  }

  void End() { this->Textures.DropUnused(); }

  /// Converts and checks the target of a block, before the work on the example. @throws InvalidInput
  static surfsynth::Surface Target(const surfsynth::Block& block)
  {
    surfsynth::Surface surface = surfsynth::ToSurface(
      vtkPolyData::SafeDownCast(block.Input), surfsynth::GeometricTextureExample::Requirements());
    surface.FlatIndex = block.FlatIndex;
    surface.Where = block.Where;
    return surface;
  }

  /// Fills the output of a block.
  void Synthesize(const surfsynth::Block& block, const surfsynth::Surface& surface, const surfsynth::Progress& progress)
  {
    vtkPolyData* input = vtkPolyData::SafeDownCast(block.Input);
    const surfsynth::UsedPoints points(surface.Mesh);
    const Eigen::VectorXf mask = surfsynth::ReadGeometricTextureArray(
      input, points, this->Self->MaskArrayName, surfsynth::MaskArray);
    surfsynth::ExampleSynthesisRequest request = this->Request(input, points);
    request.Stream = block.FlatIndex;
    Texture* texture = this->Textures.Find(surface, [&](const Texture& held) {
      return held.Example == this->Example && held.Second == this->Second && SameRequest(held.Request, request);
    });
    if (!texture)
    {
      this->Textures.Drop(surface);
      Texture made{ request, this->Example, this->Second,
        surfsynth::SynthesizeFromExample(*this->Example, points.Compact(surface.Mesh), request,
          surfsynth::SubProgress(progress, 0.0, SynthesisPart)) };
      ++this->NumberOfSyntheses;
      texture = &this->Textures.Insert(surface, std::move(made));
    }
    const surfsynth::ExampleSynthesis& result = texture->Result;
    surfsynth::PointMatrix displacement = this->Self->Strength * result.Level.Displacement;
    if (mask.size() > 0)
    {
      Eigen::VectorXf factors = mask;
      for (const auto& parents : result.Parents)
      {
        factors = surfsynth::InterpolateAtMidpoints(std::move(factors), parents);
      }
      displacement = factors.cast<double>().asDiagonal() * displacement;
    }
    if (this->Self->Printable)
    {
      this->Separate(block, result.Level, surfsynth::SubProgress(progress, SynthesisPart, 1.0), displacement);
    }
    surfsynth::FillDisplacedSurface(input, surface, { result.Level.Base, result.Level.Mesh.Triangles }, displacement,
      this->Self->DisplacementArrayName, vtkPolyData::SafeDownCast(block.Output));
    this->Scale = result.Scale;
    this->Subdivisions = result.Level.Level;
    this->Mismatch = std::max(this->Mismatch, result.Mismatch);
  }

  std::shared_ptr<const surfsynth::GeometricTextureExample> Example;
  std::shared_ptr<const surfsynth::GeometricTextureExample> Second; ///< of a blend
  double Scale = 0.0;
  int Subdivisions = 0;
  double Mismatch = 0.0;
  vtkTypeInt64 NumberOfSyntheses = 0;
  surfsynth::PrintabilityCount Printability; ///< of this update
  surfsynth::InstalledModelList Installed;

private:
  struct Texture
  {
    surfsynth::ExampleSynthesisRequest Request;
    std::shared_ptr<const surfsynth::GeometricTextureExample> Example;
    std::shared_ptr<const surfsynth::GeometricTextureExample> Second;
    surfsynth::ExampleSynthesis Result;
  };

  using File = surfsynth::FileCache<surfsynth::TextureExampleFile>;

  /// Reads the example on the first of two ports, with the plain one on the second, or that of a file.
  void Read(surfsynth::TextureExampleInput& input, vtkInformationVector** ports, File& file,
    const std::string& fileName, double smoothingLength) const
  {
    if (IsConnected(ports[0]))
    {
      input.Read(ports[0], ports[1], this->Self->ExampleOrientationArrayName, smoothingLength);
      return;
    }
    const bool isOriented = !this->Self->OrientationArrayName.empty();
    input.Read(file.Get(surfsynth::ModelPath(fileName)), isOriented, smoothingLength);
  }

  /// Reduces displacements until no triangles intersect.
  void Separate(const surfsynth::Block& block, const surfsynth::GeometricTextureLevel& synthesized,
    const surfsynth::Progress& progress, surfsynth::PointMatrix& displacement)
  {
    surfsynth::GeometricTextureLevel level;
    level.Base = synthesized.Base;
    level.Mesh = { level.Base + displacement, synthesized.Mesh.Triangles };
    this->Printability.Add(this->Self, block.Where, surfsynth::MakePrintable(level, progress));
    displacement = level.Mesh.Points - level.Base;
  }

  /// Cuts the patches of the examples. Two examples have the larger of the numbers of scales that they ask for, as far as patches
  /// of both fit, which is known for sure once they are cut.
  void Cut(bool isBlend, const surfsynth::Progress& progress)
  {
    this->Example.reset();
    this->Second.reset();
    double reached = 0.0;
    const surfsynth::Progress steady = [&](double done) {
      reached = std::max(reached, done);
      return !progress || progress(reached);
    };
    const int asked = this->Self->NumberOfScales;
    surfsynth::ExampleScaleCounts first{ asked, asked };
    first = asked > 0 ? first : this->FirstInput.Scales();
    const surfsynth::ExampleScaleCounts second = asked > 0 || !isBlend ? first : this->SecondInput.Scales();
    for (int scales = std::min({ std::max(first.Automatic, second.Automatic), first.Most, second.Most }); true;
         --scales)
    {
      try
      {
        this->Example = this->FirstInput.Patches(scales, surfsynth::SubProgress(steady, 0.0, isBlend ? 0.5 : 1.0));
        this->Second = isBlend ? this->SecondInput.Patches(scales, surfsynth::SubProgress(steady, 0.5, 1.0)) : nullptr;
        return;
      }
      catch (const surfsynth::InvalidInput&)
      {
        if (scales <= std::min(first.Automatic, second.Automatic))
        {
          throw;
        }
      }
    }
  }

  /// Checks which examples there are, and what belongs to them.
  void CheckExamples(vtkInformationVector** inputVector, bool isBlend) const
  {
    if (!IsConnected(inputVector[1]) && this->Self->ExampleFileName.empty())
    {
      throw surfsynth::InvalidInput(
        std::string("There is no example on port 1, and ExampleFileName is empty; ") + FileAdvice);
    }
    if (IsConnected(inputVector[2]) && !IsConnected(inputVector[1]))
    {
      throw surfsynth::InvalidInput(
        "There is a plain example on port 2, but no example on port 1; both are needed together, "
        "or none.");
    }
    if (isBlend == this->Self->BlendArrayName.empty())
    {
      const std::string second = IsConnected(inputVector[3]) ? "There is a second example on port 3"
                                                             : "SecondExampleFileName is set";
      throw surfsynth::InvalidInput(isBlend
          ? second + ", but BlendArrayName is empty; a point array of the target is needed."
          : "BlendArrayName is set, but there is no second example on port 3, and SecondExampleFileName is empty; the "
            "array "
            "and an example are needed together, or none.");
    }
    if (IsConnected(inputVector[4]) && !IsConnected(inputVector[3]))
    {
      throw surfsynth::InvalidInput("There is a second plain example on port 4, but no second example on port 3; both "
                                    "are needed together, or none.");
    }
    const bool isOnPort = IsConnected(inputVector[1]) || IsConnected(inputVector[3]);
    if (isOnPort && this->Self->OrientationArrayName.empty() != this->Self->ExampleOrientationArrayName.empty())
    {
      throw surfsynth::InvalidInput(std::string("Only ") +
        (this->Self->OrientationArrayName.empty() ? "ExampleOrientationArrayName" : "OrientationArrayName") +
        " is set; OrientationArrayName and ExampleOrientationArrayName are needed together, or none.");
    }
  }

  void CheckProperties() const
  {
    if (this->Self->Printable)
    {
      surfsynth::RequirePrintability();
    }
    if (this->Self->DisplacementArrayName.empty())
    {
      throw surfsynth::InvalidInput("DisplacementArrayName is empty; a name is needed.");
    }
    for (const double value : { this->Self->TextureScale, this->Self->SmoothingLength,
           this->Self->SecondSmoothingLength, this->Self->Strength })
    {
      if (std::isnan(value))
      {
        throw surfsynth::InvalidInput(
          "TextureScale, SmoothingLength, SecondSmoothingLength or Strength is not a number; numbers are needed.");
      }
    }
  }

  surfsynth::ExampleSynthesisRequest Request(vtkPolyData* input, const surfsynth::UsedPoints& points) const
  {
    surfsynth::ExampleSynthesisRequest request;
    request.Scale = this->Self->TextureScale;
    request.Subdivisions = this->Self->Subdivisions;
    request.Seed = static_cast<std::uint64_t>(this->Self->Seed);
    request.Sizes = surfsynth::ReadGeometricTextureArray(
      input, points, this->Self->SizeArrayName, surfsynth::ExampleSizeArray);
    if (!this->Self->OrientationArrayName.empty())
    {
      request.Directions = surfsynth::ReadPointRows(
        input, points, { this->Self->OrientationArrayName, "OrientationArrayName" }, 3);
    }
    request.Second = this->Second.get();
    request.Blend = surfsynth::ReadGeometricTextureArray(
      input, points, this->Self->BlendArrayName, surfsynth::ExampleBlendArray);
    return request;
  }

  vtkGeometricTextureFromExample* Self;
  surfsynth::TextureExampleInput FirstInput{ { "The example on port 1", "The plain example on port 2",
    "ExampleFileName" } };
  surfsynth::TextureExampleInput SecondInput{ { "The second example on port 3", "The second plain example on port 4",
    "SecondExampleFileName" } };
  File FirstFile{ surfsynth::ReadTextureExample, std::string("ExampleFileName: ") + FileAdvice, "example" };
  File SecondFile{ surfsynth::ReadTextureExample, std::string("SecondExampleFileName: ") + FileAdvice, "example" };
  surfsynth::BlockCache<Texture> Textures;
};

vtkGeometricTextureFromExample::vtkGeometricTextureFromExample()
  : Impl(std::make_unique<Internals>(this))
{
  this->SetNumberOfInputPorts(5);
}

vtkGeometricTextureFromExample::~vtkGeometricTextureFromExample() = default;

void vtkGeometricTextureFromExample::SetExampleFileName(const char* name)
{
  surfsynth::SetString(this, this->ExampleFileName, name);
}

void vtkGeometricTextureFromExample::SetSecondExampleFileName(const char* name)
{
  surfsynth::SetString(this, this->SecondExampleFileName, name);
}

void vtkGeometricTextureFromExample::SetOrientationArrayName(const char* name)
{
  surfsynth::SetString(this, this->OrientationArrayName, name);
}

void vtkGeometricTextureFromExample::SetExampleOrientationArrayName(const char* name)
{
  surfsynth::SetString(this, this->ExampleOrientationArrayName, name);
}

void vtkGeometricTextureFromExample::SetSizeArrayName(const char* name)
{
  surfsynth::SetString(this, this->SizeArrayName, name);
}

void vtkGeometricTextureFromExample::SetMaskArrayName(const char* name)
{
  surfsynth::SetString(this, this->MaskArrayName, name);
}

void vtkGeometricTextureFromExample::SetBlendArrayName(const char* name)
{
  surfsynth::SetString(this, this->BlendArrayName, name);
}

void vtkGeometricTextureFromExample::SetDisplacementArrayName(const char* name)
{
  surfsynth::SetString(this, this->DisplacementArrayName, name);
}

int vtkGeometricTextureFromExample::FillInputPortInformation(int port, vtkInformation* info)
{
  if (port == 0)
  {
    return surfsynth::AcceptBlocks(info, surfsynth::SurfaceToSurface);
  }
  info->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1);
  return surfsynth::AcceptSurface(info);
}

int vtkGeometricTextureFromExample::RequestDataObject(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  return surfsynth::RequestBlocks(this, inputVector, outputVector, surfsynth::SurfaceToSurface);
}

int vtkGeometricTextureFromExample::RequestUpdateExtent(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector*)
{
  for (int port = 1; port < 5; ++port)
  {
    surfsynth::RequestWhole(inputVector[port]);
  }
  return 1;
}

int vtkGeometricTextureFromExample::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  bool hasBegun = false;
  const auto synthesize = [&](const surfsynth::Block& block, const surfsynth::Progress& progress) {
    const surfsynth::Surface target = Internals::Target(block);
    const double begin = hasBegun ? 0.0 : 0.2;
    if (!hasBegun)
    {
      this->Impl->Begin(inputVector, surfsynth::SubProgress(progress, 0.0, begin));
      hasBegun = true;
    }
    this->Impl->Synthesize(block, target, surfsynth::SubProgress(progress, begin, 1.0));
  };
  const int done = surfsynth::ProcessBlocks(this, inputVector, outputVector, surfsynth::SurfaceToSurface, synthesize);
  this->Impl->End();
  return done;
}

vtkStringArray* vtkGeometricTextureFromExample::GetInstalledExamples()
{
  return this->Impl->Installed.Names("geometric_texture_example");
}

const char* vtkGeometricTextureFromExample::GetInstalledExamplesFolder() const
{
  return this->Impl->Installed.Folder();
}

double vtkGeometricTextureFromExample::GetTextureScaleUsed() const { return this->Impl->Scale; }

int vtkGeometricTextureFromExample::GetSubdivisionsUsed() const { return this->Impl->Subdivisions; }

int vtkGeometricTextureFromExample::GetNumberOfScalesUsed() const
{
  return this->Impl->Example ? static_cast<int>(this->Impl->Example->Scales().size()) : 0;
}

double vtkGeometricTextureFromExample::GetMismatch() const { return this->Impl->Mismatch; }

vtkTypeInt64 vtkGeometricTextureFromExample::GetNumberOfSelfIntersections() const
{
  return this->Impl->Printability.NumberOfPairsLeft();
}

double vtkGeometricTextureFromExample::GetHeightKept() const { return this->Impl->Printability.HeightKept(); }

vtkTypeInt64 vtkGeometricTextureFromExample::GetNumberOfSyntheses() const { return this->Impl->NumberOfSyntheses; }

void vtkGeometricTextureFromExample::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "ExampleFileName: " << this->ExampleFileName << "\n";
  os << indent << "SecondExampleFileName: " << this->SecondExampleFileName << "\n";
  os << indent << "Seed: " << this->Seed << "\n";
  os << indent << "TextureScale: " << this->TextureScale << "\n";
  os << indent << "Subdivisions: " << this->Subdivisions << "\n";
  os << indent << "NumberOfScales: " << this->NumberOfScales << "\n";
  os << indent << "SmoothingLength: " << this->SmoothingLength << "\n";
  os << indent << "SecondSmoothingLength: " << this->SecondSmoothingLength << "\n";
  os << indent << "BlendArrayName: " << this->BlendArrayName << "\n";
  os << indent << "OrientationArrayName: " << this->OrientationArrayName << "\n";
  os << indent << "ExampleOrientationArrayName: " << this->ExampleOrientationArrayName << "\n";
  os << indent << "SizeArrayName: " << this->SizeArrayName << "\n";
  os << indent << "MaskArrayName: " << this->MaskArrayName << "\n";
  os << indent << "Strength: " << this->Strength << "\n";
  os << indent << "Printable: " << this->Printable << "\n";
  os << indent << "DisplacementArrayName: " << this->DisplacementArrayName << "\n";
  os << indent << "TextureScaleUsed: " << this->GetTextureScaleUsed() << "\n";
  os << indent << "SubdivisionsUsed: " << this->GetSubdivisionsUsed() << "\n";
  os << indent << "NumberOfScalesUsed: " << this->GetNumberOfScalesUsed() << "\n";
  os << indent << "Mismatch: " << this->GetMismatch() << "\n";
  os << indent << "NumberOfSelfIntersections: " << this->GetNumberOfSelfIntersections() << "\n";
  os << indent << "HeightKept: " << this->GetHeightKept() << "\n";
  os << indent << "NumberOfSyntheses: " << this->GetNumberOfSyntheses() << "\n";
}
