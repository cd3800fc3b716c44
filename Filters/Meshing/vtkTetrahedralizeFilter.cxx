// SPDX-License-Identifier: BSD-3-Clause
#include "vtkTetrahedralizeFilter.h"

#include "BlockBridge.h"
#include "MeshProcessing/Tetrahedra/Tetrahedralizer.h"
#include "Reporting.h"
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

#include <unistd.h>

#include <cmath>

using surfsynth::Block;

vtkStandardNewMacro(vtkTetrahedralizeFilter);

namespace
{
const surfsynth::BlockTypes Types{ { "vtkPolyData" }, "vtkUnstructuredGrid" };

/// Default memory limit of one process, bytes.
std::int64_t DefaultMemoryLimit()
{
  const long pages = sysconf(_SC_PHYS_PAGES);
  const long size = sysconf(_SC_PAGESIZE);
  return pages > 0 && size > 0 ? static_cast<std::int64_t>(pages) / 4 * 3 * size : 0;
}
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
    const surfsynth::TetrahedralMesh mesh = surfsynth::Tetrahedralize(
      used.Mesh, this->Options(), cellOfTriangle, surfsynth::SubProgress(progress, 0.0, 0.9));
    surfsynth::GridNames names{ this->Self->RegionArrayName, this->Self->SurfaceArrayName };
    surfsynth::FillGrid(
      vtkUnstructuredGrid::SafeDownCast(block.Output), names, input, surface, used, mesh, this->Self->SurfaceTriangles);
    surfsynth::Report(progress, 1.0);
  }

private:
  surfsynth::TetrahedralizeOptions Options() const
  {
    const double length = this->Self->TargetEdgeLength;
    const double regular = length * length * length / (6.0 * std::sqrt(2.0));
    surfsynth::TetrahedralizeOptions options;
    options.PreserveSurface = this->Self->PreserveSurface;
    options.InnerSurfacesAreHoles = this->Self->InnerSurfaces == HOLES;
    options.QualityRatio = this->Self->QualityRatio;
    options.MinimumDihedralAngle = this->Self->MinimumDihedralAngle;
    options.MaximumVolume = this->Self->MaximumVolume;
    if (length > 0.0 && (options.MaximumVolume == 0.0 || regular < options.MaximumVolume))
    {
      options.MaximumVolume = regular;
    }
    options.Seconds = this->Self->TimeLimit;
    options.MemoryLimit = this->Self->MemoryLimit > 0 ? static_cast<std::int64_t>(this->Self->MemoryLimit) << 20
                                                      : DefaultMemoryLimit();
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
  const std::string wanted = name ? name : "";
  if (this->RegionArrayName != wanted)
  {
    this->RegionArrayName = wanted;
    this->Modified();
  }
}

void vtkTetrahedralizeFilter::SetSurfaceArrayName(const char* name)
{
  const std::string wanted = name ? name : "";
  if (this->SurfaceArrayName != wanted)
  {
    this->SurfaceArrayName = wanted;
    this->Modified();
  }
}

int vtkTetrahedralizeFilter::FillInputPortInformation(int, vtkInformation* info)
{
  return surfsynth::AcceptBlocks(info, Types);
}

int vtkTetrahedralizeFilter::RequestDataObject(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  return surfsynth::RequestBlocks(this, inputVector, outputVector, Types);
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
  return surfsynth::ProcessBlocks(this, inputVector, outputVector, Types, tetrahedralize);
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
  os << indent << "TimeLimit: " << this->TimeLimit << "\n";
  os << indent << "MemoryLimit: " << this->MemoryLimit << "\n";
  os << indent << "RegionArrayName: " << this->RegionArrayName << "\n";
  os << indent << "SurfaceArrayName: " << this->SurfaceArrayName << "\n";
}
