// SPDX-License-Identifier: BSD-3-Clause
#include "vtkTextureAtlasFilter.h"

#include "AtlasDataset.h"
#include "BlockBridge.h"
#include "SurfaceBridge.h"

#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkObjectFactory.h>
#include <vtkPolyData.h>

#include <algorithm>
#include <memory>

using surfsynth::Surface;
using surfsynth::SurfaceAtlas;

vtkStandardNewMacro(vtkTextureAtlasFilter);

/// Work of one update with the parameters of the filter.
class vtkTextureAtlasFilter::Internals
{
public:
  explicit Internals(vtkTextureAtlasFilter* self)
    : Self(self)
  {}

  void Make(const surfsynth::Block& block, const surfsynth::Progress& progress) const
  {
    auto* input = vtkPolyData::SafeDownCast(block.Input);
    surfsynth::MeshRequirements requirements;
    requirements.ManifoldVertices = true;
    requirements.ConsistentWinding = true;
    const auto surface = std::make_shared<const Surface>(surfsynth::ToSurface(input, requirements));
    surfsynth::SurfaceAtlasOptions options;
    options.Width = this->Self->Resolution[0];
    options.Height = this->Self->Resolution[1];
    options.Margin = this->Self->Margin;
    options.MaximumStretch = this->Self->MaximumStretch;
    const SurfaceAtlas atlas = surfsynth::MakeAtlas(
      input, surface, options, surfsynth::SubProgress(progress, 0.05, 0.95));
    surfsynth::FillAtlas(input, *surface, atlas, vtkPolyData::SafeDownCast(block.Output));
    this->Keep(atlas);
  }

  /// Keeps the measures of an atlas.
  void Keep(const SurfaceAtlas& atlas) const
  {
    this->Self->NumberOfCharts = atlas.NumberOfCharts;
    this->Self->Coverage = atlas.Coverage;
    this->Self->RootMeanStretch = atlas.RootMeanStretch;
    this->Self->LargestStretch = atlas.LargestStretch;
    this->Self->TexelsPerLength = atlas.TexelsPerLength;
  }

private:
  vtkTextureAtlasFilter* Self;
};

vtkTextureAtlasFilter::vtkTextureAtlasFilter() = default;

vtkTextureAtlasFilter::~vtkTextureAtlasFilter() = default;

void vtkTextureAtlasFilter::SetResolution(int width, int height)
{
  const int size[2] = { std::clamp(width, 16, 32768), std::clamp(height, 16, 32768) };
  if (!std::equal(size, size + 2, this->Resolution))
  {
    std::copy(size, size + 2, this->Resolution);
    this->Modified();
  }
}

int vtkTextureAtlasFilter::FillInputPortInformation(int, vtkInformation* info)
{
  return surfsynth::AcceptBlocks(info, surfsynth::SurfaceToSurface);
}

int vtkTextureAtlasFilter::RequestDataObject(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  return surfsynth::RequestBlocks(this, inputVector, outputVector, surfsynth::SurfaceToSurface);
}

int vtkTextureAtlasFilter::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  const Internals making(this);
  making.Keep(SurfaceAtlas());
  return surfsynth::ProcessBlocks(this, inputVector, outputVector, surfsynth::SurfaceToSurface,
    [&](const surfsynth::Block& block, const surfsynth::Progress& progress) { making.Make(block, progress); });
}

void vtkTextureAtlasFilter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Resolution: " << this->Resolution[0] << " " << this->Resolution[1] << "\n";
  os << indent << "Margin: " << this->Margin << "\n";
  os << indent << "MaximumStretch: " << this->MaximumStretch << "\n";
  os << indent << "NumberOfCharts: " << this->NumberOfCharts << "\n";
  os << indent << "Coverage: " << this->Coverage << "\n";
  os << indent << "RootMeanStretch: " << this->RootMeanStretch << "\n";
  os << indent << "LargestStretch: " << this->LargestStretch << "\n";
  os << indent << "TexelsPerLength: " << this->TexelsPerLength << "\n";
}
