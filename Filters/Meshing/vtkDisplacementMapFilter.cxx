// SPDX-License-Identifier: BSD-3-Clause
#include "vtkDisplacementMapFilter.h"

#include "DisplacementImages.h"
#include "JointProcessing.h"
#include "Reporting.h"
#include "SurfaceCoordinates.h"
#include "SurfaceInputs.h"
#include "TextureImages.h"
#include "WholeInput.h"

#include "Core/Common/Errors.h"

#include <vtkDataObject.h>
#include <vtkImageData.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkObjectFactory.h>
#include <vtkPolyData.h>
#include <vtkStreamingDemandDrivenPipeline.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>

using Pipeline = vtkStreamingDemandDrivenPipeline;

vtkStandardNewMacro(vtkDisplacementMapFilter);

/// Measures of the last update.
class vtkDisplacementMapFilter::Internals
{
public:
  explicit Internals(vtkDisplacementMapFilter* self)
    : Self(self)
  {}

  void Bake(vtkInformationVector** inputVector, vtkImageData* output, const surfsynth::Progress& progress)
  {
    const auto plain = surfsynth::SurfaceOn(inputVector[0]), detailed = surfsynth::SurfaceOn(inputVector[1]);
    const bool isPlainEmpty = !plain || plain->GetNumberOfCells() == 0;
    const bool isDetailedEmpty = !detailed || detailed->GetNumberOfCells() == 0;
    if (isPlainEmpty != isDetailedEmpty)
    {
      throw surfsynth::InvalidInput(std::string("The ") +
        (isPlainEmpty ? "plain surface on port 0" : "detailed surface on port 1") +
        " is empty; two surfaces are needed.");
    }
    if (isPlainEmpty)
    {
      return;
    }
    const surfsynth::Surface surface = surfsynth::ToPlainSurface(plain);
    const surfsynth::TextureCoordinates coordinates = surfsynth::ReadTextureCoordinates(plain, surface);
    surfsynth::RequireAtlas(coordinates, surface);
    const surfsynth::DisplacementMapOptions options = this->Options();
    surfsynth::DisplacementMap map = surfsynth::BakeDisplacementMap(surface.Mesh, coordinates,
      surfsynth::ToDetailedMesh(detailed), options, surfsynth::SubProgress(progress, 0.02, 0.98));
    this->Warn(map, surface);
    surfsynth::FillDisplacementImage(map, options.Raster, output);
    this->Encoding = surfsynth::EncodingOf(map);
    for (auto* image : { &map.Displacements, &map.Heights })
    {
      image->clear();
    }
    map.Coverage.clear();
    this->Map = std::move(map);
  }

  surfsynth::DisplacementMap Map; ///< without images
  surfsynth::HeightEncoding Encoding;

private:
  surfsynth::DisplacementMapOptions Options() const
  {
    surfsynth::DisplacementMapOptions options;
    options.Raster = surfsynth::RasterOptionsOf(this->Self->Resolution, this->Self->GutterWidth);
    options.Space = this->Self->VectorSpace == TANGENT ? surfsynth::DisplacementSpace::Tangent
                                                       : surfsynth::DisplacementSpace::Object;
    options.MaximumDistance = this->Self->MaximumDistance;
    options.ByIndex = this->Self->Correspondence == AUTOMATIC;
    return options;
  }

  /// Warns of cells that overlap in the texture, or have no area there.
  void Warn(const surfsynth::DisplacementMap& map, const surfsynth::Surface& surface) const
  {
    for (const surfsynth::AtlasFinding& finding : map.Findings)
    {
      if (finding.Defect == surfsynth::AtlasDefect::OverlappingTriangles ||
        finding.Defect == surfsynth::AtlasDefect::DegenerateTriangle)
      {
        surfsynth::ReportWarning(this->Self, "",
          surfsynth::DescribeAtlasFindings({ finding }, [&surface](std::int64_t f) { return surface.Cell(f); }));
      }
    }
  }

  vtkDisplacementMapFilter* Self;
};

vtkDisplacementMapFilter::vtkDisplacementMapFilter()
  : Impl(std::make_unique<Internals>(this))
{
  this->SetNumberOfInputPorts(2);
}

vtkDisplacementMapFilter::~vtkDisplacementMapFilter() = default;

void vtkDisplacementMapFilter::SetResolution(int width, int height)
{
  const auto size = surfsynth::TextureResolution(width, height);
  if (!std::equal(size.begin(), size.end(), this->Resolution))
  {
    std::copy(size.begin(), size.end(), this->Resolution);
    this->Modified();
  }
}

int vtkDisplacementMapFilter::FillInputPortInformation(int, vtkInformation* info)
{
  return surfsynth::AcceptSurface(info);
}

int vtkDisplacementMapFilter::RequestInformation(
  vtkInformation*, vtkInformationVector**, vtkInformationVector* outputVector)
{
  vtkInformation* image = outputVector->GetInformationObject(0);
  const int extent[6] = { 0, this->Resolution[0] - 1, 0, this->Resolution[1] - 1, 0, 0 };
  image->Set(Pipeline::WHOLE_EXTENT(), extent, 6);
  vtkDataObject::SetPointDataActiveScalarInfo(image, VTK_FLOAT, 1);
  return 1;
}

int vtkDisplacementMapFilter::RequestUpdateExtent(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector*)
{
  surfsynth::RequestWhole(inputVector[0]);
  surfsynth::RequestWhole(inputVector[1]);
  return 1;
}

int vtkDisplacementMapFilter::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  this->Impl->Map = surfsynth::DisplacementMap();
  this->Impl->Encoding = surfsynth::HeightEncoding();
  const int success = surfsynth::ProcessJointly(
    this, inputVector, outputVector, [&](const surfsynth::Progress& progress) {
      this->Impl->Bake(inputVector, vtkImageData::GetData(outputVector), progress);
    });
  surfsynth::AnnounceEmptyImage(outputVector->GetInformationObject(0));
  return success;
}

vtkTypeInt64 vtkDisplacementMapFilter::GetSubdivisionLevels() const { return this->Impl->Map.SubdivisionLevels; }

vtkTypeInt64 vtkDisplacementMapFilter::GetCoveredTexels() const { return this->Impl->Map.CoveredTexels; }

vtkTypeInt64 vtkDisplacementMapFilter::GetMisses() const { return this->Impl->Map.Misses; }

double vtkDisplacementMapFilter::GetMeanMiss() const { return this->Impl->Map.MeanMiss; }

double vtkDisplacementMapFilter::GetLargestMiss() const { return this->Impl->Map.LargestMiss; }

double vtkDisplacementMapFilter::GetHeightMidlevel() const { return this->Impl->Encoding.Midlevel; }

double vtkDisplacementMapFilter::GetHeightScale() const { return this->Impl->Encoding.Scale; }

void vtkDisplacementMapFilter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Resolution: " << this->Resolution[0] << " x " << this->Resolution[1] << "\n";
  os << indent << "GutterWidth: " << this->GutterWidth << "\n";
  os << indent << "VectorSpace: " << (this->VectorSpace == TANGENT ? "TANGENT" : "OBJECT") << "\n";
  os << indent << "Correspondence: " << (this->Correspondence == NORMALS ? "NORMALS" : "AUTOMATIC") << "\n";
  os << indent << "MaximumDistance: " << this->MaximumDistance << "\n";
  os << indent << "SubdivisionLevels: " << this->GetSubdivisionLevels() << "\n";
  os << indent << "CoveredTexels: " << this->GetCoveredTexels() << "\n";
  os << indent << "Misses: " << this->GetMisses() << "\n";
  os << indent << "MeanMiss: " << this->GetMeanMiss() << "\n";
  os << indent << "LargestMiss: " << this->GetLargestMiss() << "\n";
  os << indent << "HeightMidlevel: " << this->GetHeightMidlevel() << "\n";
  os << indent << "HeightScale: " << this->GetHeightScale() << "\n";
}
