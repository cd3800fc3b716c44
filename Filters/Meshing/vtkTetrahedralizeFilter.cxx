// SPDX-License-Identifier: BSD-3-Clause
#include "vtkTetrahedralizeFilter.h"

#include "BlockBridge.h"
#include "FilterSupport.h"
#include "MeshProcessing/Tetrahedra/Tetrahedralizer.h"
#include "Reporting.h"
#include "SampleMemory.h"
#include "SurfaceArrays.h"
#include "SurfaceBridge.h"
#include "TetrahedralGrid.h"

#include <vtkDataObject.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkObjectFactory.h>
#include <vtkPolyData.h>
#include <vtkUnstructuredGrid.h>

using surfsynth::Block;

vtkStandardNewMacro(vtkTetrahedralizeFilter);

namespace
{
const surfsynth::BlockTypes SurfaceToGrid{ { "vtkPolyData" }, "vtkUnstructuredGrid" };
} // namespace

class vtkTetrahedralizeFilter::Internals
{
public:
  explicit Internals(vtkTetrahedralizeFilter* self)
    : Self(self)
  {}

  void Tetrahedralize(const Block& block, const surfsynth::Progress& progress) const
  {
    auto* input = vtkPolyData::SafeDownCast(block.Input);
    surfsynth::MeshRequirements closed;
    closed.Closed = true;
    const surfsynth::Surface surface = surfsynth::ToSurface(input, closed);
    const surfsynth::UsedSurface used(surface.Mesh);
    const auto cellOfTriangle = [&](std::int64_t f) { return surface.Cell(f); };
    const surfsynth::FilledSurface mesh = surfsynth::Tetrahedralize(
      used.Mesh, this->Options(), cellOfTriangle, surfsynth::SubProgress(progress, 0.0, 0.9));
    surfsynth::GridNames names{ this->Self->RegionArrayName, this->Self->SurfaceArrayName };
    surfsynth::FillGrid(
      vtkUnstructuredGrid::SafeDownCast(block.Output), names, input, surface, used, mesh, this->Self->SurfaceTriangles);
    surfsynth::Report(progress, 1.0);
  }

private:
  surfsynth::TetrahedralizeOptions Options() const
  {
    surfsynth::TetrahedralizeOptions options;
    options.PreserveSurface = this->Self->PreserveSurface;
    options.InnerSurfacesAreHoles = this->Self->InnerSurfaces == HOLES;
    options.QualityRatio = this->Self->QualityRatio;
    options.MinimumDihedralAngle = this->Self->MinimumDihedralAngle;
    options.MaximumVolume = this->Self->MaximumVolume;
    options.TargetEdgeLength = this->Self->TargetEdgeLength;
    options.MaximumNumberOfTetrahedra = this->Self->MaximumNumberOfTetrahedra;
    options.Seconds = this->Self->TimeLimit;
    options.MemoryLimit = this->Self->MemoryLimit > 0 ? static_cast<std::int64_t>(this->Self->MemoryLimit) << 20
                                                      : surfsynth::DefaultMemoryLimit();
    return options;
  }

  vtkTetrahedralizeFilter* Self;
};

vtkTetrahedralizeFilter::vtkTetrahedralizeFilter()
  : Impl(std::make_unique<Internals>(this))
{}

vtkTetrahedralizeFilter::~vtkTetrahedralizeFilter() = default;

void vtkTetrahedralizeFilter::SetRegionArrayName(const char* name)
{
  surfsynth::SetString(this, this->RegionArrayName, name);
}

void vtkTetrahedralizeFilter::SetSurfaceArrayName(const char* name)
{
  surfsynth::SetString(this, this->SurfaceArrayName, name);
}

int vtkTetrahedralizeFilter::FillInputPortInformation(int, vtkInformation* info)
{
  return surfsynth::AcceptBlocks(info, SurfaceToGrid);
}

int vtkTetrahedralizeFilter::RequestDataObject(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  return surfsynth::RequestBlocks(this, inputVector, outputVector, SurfaceToGrid);
}

int vtkTetrahedralizeFilter::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  if (this->RegionArrayName.empty() || this->SurfaceArrayName.empty())
  {
    surfsynth::ReportError(this, "", "RegionArrayName or SurfaceArrayName is empty; names for the arrays are needed.");
    vtkDataObject::GetData(outputVector)->Initialize();
    return 0;
  }
  const auto tetrahedralize = [this](const Block& block, const surfsynth::Progress& progress) {
    this->Impl->Tetrahedralize(block, progress);
  };
  return surfsynth::ProcessBlocks(this, inputVector, outputVector, SurfaceToGrid, tetrahedralize);
}

void vtkTetrahedralizeFilter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "QualityRatio: " << this->QualityRatio << "\n";
  os << indent << "MinimumDihedralAngle: " << this->MinimumDihedralAngle << "\n";
  os << indent << "MaximumVolume: " << this->MaximumVolume << "\n";
  os << indent << "TargetEdgeLength: " << this->TargetEdgeLength << "\n";
  os << indent << "PreserveSurface: " << this->PreserveSurface << "\n";
  os << indent << "InnerSurfaces: " << this->InnerSurfaces << "\n";
  os << indent << "SurfaceTriangles: " << this->SurfaceTriangles << "\n";
  os << indent << "MaximumNumberOfTetrahedra: " << this->MaximumNumberOfTetrahedra << "\n";
  os << indent << "TimeLimit: " << this->TimeLimit << "\n";
  os << indent << "MemoryLimit: " << this->MemoryLimit << "\n";
  os << indent << "RegionArrayName: " << this->RegionArrayName << "\n";
  os << indent << "SurfaceArrayName: " << this->SurfaceArrayName << "\n";
}
