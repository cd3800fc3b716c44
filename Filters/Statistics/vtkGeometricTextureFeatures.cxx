// SPDX-License-Identifier: BSD-3-Clause
#include "vtkGeometricTextureFeatures.h"

#include "DataObjects.h"
#include "JointProcessing.h"
#include "NewArray.h"
#include "StatisticsOutput.h"
#include "SurfaceBridge.h"
#include "SurfaceInputs.h"

#include "Core/Common/Errors.h"
#include "Core/Statistics/GeometricTextureFeatures.h"
#include "Inference/GeometricTexture/GeometricTextureSampler.h"

#ifdef SURFACE_SYNTHESIS_CGAL
#include "MeshProcessing/Repair/SelfIntersections.h"
#endif

#include <vtkAlgorithm.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDataObject.h>
#include <vtkDoubleArray.h>
#include <vtkIdTypeArray.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkIntArray.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkTable.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <vector>

using surfsynth::GeometricTextureFeatures;
using surfsynth::Index;
using surfsynth::InvalidInput;
using surfsynth::TriangleMesh;

vtkStandardNewMacro(vtkGeometricTextureFeatures);

namespace
{
using PairsOfTriangles = std::vector<std::array<Index, 2>>;

/// @param name beginning of messages
surfsynth::Surface ReadSurface(vtkPolyData* given, const std::string& name)
{
  if (surfsynth::IsEmpty(given))
  {
    throw InvalidInput(name + " is empty; a surface with at least one triangle is needed.");
  }
  try
  {
    return surfsynth::ToSurface(given, surfsynth::GeometricTextureSampler::Requirements());
  }
  catch (const InvalidInput& error)
  {
    throw InvalidInput(name + ": " + error.what());
  }
}

bool AreEqual(vtkCellArray* one, vtkCellArray* other)
{
  if (one->GetNumberOfCells() != other->GetNumberOfCells())
  {
    return false;
  }
  for (vtkIdType cell = 0; cell < one->GetNumberOfCells(); ++cell)
  {
    vtkIdType size = 0, otherSize = 0;
    const vtkIdType *ids = nullptr, *otherIds = nullptr;
    one->GetCellAtId(cell, size, ids);
    other->GetCellAtId(cell, otherSize, otherIds);
    if (!std::equal(ids, ids + size, otherIds, otherIds + otherSize))
    {
      return false;
    }
  }
  return true;
}

/// The bare surface on a port; its polygons are cut as those of the surface are where the cells of both are the same.
TriangleMesh ReadBare(vtkPolyData* given, vtkPolyData* surface, const TriangleMesh& mesh)
{
  TriangleMesh bare = ReadSurface(given, "The bare surface on port 1").Mesh;
  if (bare.NumberOfPoints() == mesh.NumberOfPoints() && AreEqual(given->GetPolys(), surface->GetPolys()) &&
    AreEqual(given->GetStrips(), surface->GetStrips()))
  {
    bare.Triangles = mesh.Triangles;
  }
  return bare;
}

/// Pairs of triangles that intersect; none in builds without CGAL.
std::optional<PairsOfTriangles> FindIntersections(
  const std::shared_ptr<const surfsynth::Surface>& surface, const surfsynth::Progress& progress)
{
#ifdef SURFACE_SYNTHESIS_CGAL
  const auto found = std::make_shared<PairsOfTriangles>();
  const auto work = [surface, found](const std::atomic<bool>& stop) {
    *found = surfsynth::FindIntersectingPairs(surface->Mesh, &stop);
  };
  surfsynth::RunCancellable(work, 0.05 + 2e-6 * surface->Mesh.NumberOfTriangles(), progress);
  return *found;
#else
  static_cast<void>(surface);
  surfsynth::Report(progress, 1.0);
  return std::nullopt;
#endif
}

void AddPeaks(vtkPolyData* output, const GeometricTextureFeatures& found, double mergedSaddle)
{
  const auto points = static_cast<vtkIdType>(found.Heights.size());
  const auto region = surfsynth::NewArray<vtkIdTypeArray>("Region", points, 1);
  std::copy(found.Peaks.Regions.begin(), found.Peaks.Regions.end(), region->GetPointer(0));
  const auto peak = surfsynth::NewArray<vtkIntArray>("Peak", points, 1);
  for (std::size_t k = 0; k < found.Peaks.Peaks.size(); ++k)
  {
    const bool merged = found.Peaks.SaddleRatios[static_cast<Eigen::Index>(k)] > mergedSaddle;
    peak->SetValue(found.Peaks.Peaks[k], merged ? 2 : 1);
  }
  surfsynth::AddValues(output, "Height", found.Heights, 1);
  surfsynth::AddValues(output, "Prominence", found.Peaks.Prominences, 1);
  output->GetPointData()->AddArray(peak);
  output->GetPointData()->AddArray(region);
  output->GetPointData()->SetActiveScalars("Height");
}

void AddIntersections(vtkPolyData* output, const surfsynth::Surface& surface, const PairsOfTriangles& pairs)
{
  const auto count = surfsynth::NewArray<vtkIntArray>("SelfIntersections", output->GetNumberOfCells(), 1);
  for (const auto& pair : pairs)
  {
    for (const Index triangle : pair)
    {
      const auto cell = static_cast<vtkIdType>(surface.Cell(triangle));
      count->SetValue(cell, count->GetValue(cell) + 1);
    }
  }
  output->GetCellData()->AddArray(count);
}

void FillRow(vtkTable* table, const GeometricTextureFeatures& found, vtkIdType intersections)
{
  surfsynth::AddValue<vtkIdTypeArray>(table, "NumberOfPeaks", static_cast<vtkIdType>(found.NumberOfPeaks));
  surfsynth::AddValue<vtkDoubleArray>(table, "PeakDensity", found.PeakDensity);
  surfsynth::AddValue<vtkDoubleArray>(table, "RelativePeakDensity", found.RelativePeakDensity);
  surfsynth::AddValue<vtkDoubleArray>(table, "MeanPeakHeight", found.MeanPeakHeight);
  surfsynth::AddValue<vtkDoubleArray>(table, "PeakHeightVariation", found.PeakHeightVariation);
  surfsynth::AddValue<vtkIdTypeArray>(table, "NumberOfMergedPeaks", static_cast<vtkIdType>(found.NumberOfMergedPeaks));
  surfsynth::AddValue<vtkDoubleArray>(table, "MergedShare", found.MergedShare);
  surfsynth::AddValue<vtkDoubleArray>(table, "WallLength", found.WallLength);
  surfsynth::AddValue<vtkDoubleArray>(table, "WallDensity", found.WallDensity);
  surfsynth::AddValue<vtkDoubleArray>(table, "RelativeWallDensity", found.RelativeWallDensity);
  surfsynth::AddValue<vtkDoubleArray>(table, "WallHeight", found.WallHeight);
  surfsynth::AddValue<vtkIdTypeArray>(table, "NumberOfSelfIntersections", intersections);
  surfsynth::AddValue<vtkDoubleArray>(table, "Area", found.Area);
  surfsynth::AddValue<vtkDoubleArray>(table, "HeightDeviation", found.HeightDeviation);
  surfsynth::AddValue<vtkDoubleArray>(table, "BaseLevel", found.BaseLevel);
  surfsynth::AddValue<vtkDoubleArray>(table, "UnitLength", found.UnitLength);
  surfsynth::AddValue<vtkDoubleArray>(table, "MinimumProminence", found.MinimumProminence);
}
} // namespace

/// Features of the last update.
class vtkGeometricTextureFeatures::Internals
{
public:
  explicit Internals(vtkGeometricTextureFeatures* self)
    : Self(self)
  {}

  void Measure(
    vtkInformationVector** inputVector, vtkInformationVector* outputVector, const surfsynth::Progress& progress)
  {
    const auto given = surfsynth::SurfaceOn(inputVector[0]);
    if (surfsynth::IsEmpty(given))
    {
      return;
    }
    // Shared with the search for intersections, which outlives this call when it is cancelled.
    const auto surface = std::make_shared<const surfsynth::Surface>(ReadSurface(given, "The surface on port 0"));
    std::optional<TriangleMesh> bare;
    if (this->Self->GetNumberOfInputConnections(1) > 0)
    {
      bare = ReadBare(surfsynth::SurfaceOn(inputVector[1]), given, surface->Mesh);
    }
    GeometricTextureFeatures found = surfsynth::MeasureGeometricTextureFeatures(
      surface->Mesh, bare ? &*bare : nullptr, this->Options(), surfsynth::SubProgress(progress, 0.0, 0.5));
    const auto pairs = FindIntersections(surface, surfsynth::SubProgress(progress, 0.5, 1.0));
    vtkPolyData* output = vtkPolyData::GetData(outputVector, 0);
    output->ShallowCopy(given);
    AddPeaks(output, found, this->Self->MergedSaddle);
    if (pairs)
    {
      AddIntersections(output, *surface, *pairs);
    }
    this->Intersections = pairs ? static_cast<vtkIdType>(pairs->size()) : -1;
    FillRow(vtkTable::GetData(outputVector, 1), found, this->Intersections);
    this->Found = std::move(found);
  }

  GeometricTextureFeatures Found;
  vtkIdType Intersections = 0;

private:
  surfsynth::GeometricTextureFeatureOptions Options() const
  {
    surfsynth::GeometricTextureFeatureOptions options;
    options.UnitLength = this->Self->UnitLength;
    options.MinimumProminence = this->Self->MinimumProminence;
    options.MergedSaddle = this->Self->MergedSaddle;
    options.WallLevel = this->Self->WallLevel;
    options.SmoothingLength = this->Self->SmoothingLength;
    return options;
  }

  vtkGeometricTextureFeatures* Self;
};

vtkGeometricTextureFeatures::vtkGeometricTextureFeatures()
  : Impl(std::make_unique<Internals>(this))
{
  this->SetNumberOfInputPorts(2);
  this->SetNumberOfOutputPorts(2);
}

vtkGeometricTextureFeatures::~vtkGeometricTextureFeatures() = default;

int vtkGeometricTextureFeatures::FillInputPortInformation(int port, vtkInformation* info)
{
  if (port == 1)
  {
    info->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1);
  }
  return surfsynth::AcceptSurface(info);
}

int vtkGeometricTextureFeatures::FillOutputPortInformation(int port, vtkInformation* info)
{
  info->Set(vtkDataObject::DATA_TYPE_NAME(), port == 0 ? "vtkPolyData" : "vtkTable");
  return 1;
}

int vtkGeometricTextureFeatures::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  this->Impl->Found = GeometricTextureFeatures();
  this->Impl->Intersections = 0;
  return surfsynth::ProcessJointly(this, inputVector, outputVector,
    [&](const surfsynth::Progress& progress) { this->Impl->Measure(inputVector, outputVector, progress); });
}

vtkTypeInt64 vtkGeometricTextureFeatures::GetNumberOfPeaks() const { return this->Impl->Found.NumberOfPeaks; }

double vtkGeometricTextureFeatures::GetPeakDensity() const { return this->Impl->Found.PeakDensity; }

double vtkGeometricTextureFeatures::GetRelativePeakDensity() const { return this->Impl->Found.RelativePeakDensity; }

double vtkGeometricTextureFeatures::GetMeanPeakHeight() const { return this->Impl->Found.MeanPeakHeight; }

double vtkGeometricTextureFeatures::GetPeakHeightVariation() const { return this->Impl->Found.PeakHeightVariation; }

vtkTypeInt64 vtkGeometricTextureFeatures::GetNumberOfMergedPeaks() const
{
  return this->Impl->Found.NumberOfMergedPeaks;
}

double vtkGeometricTextureFeatures::GetMergedShare() const { return this->Impl->Found.MergedShare; }

double vtkGeometricTextureFeatures::GetWallLength() const { return this->Impl->Found.WallLength; }

double vtkGeometricTextureFeatures::GetWallDensity() const { return this->Impl->Found.WallDensity; }

double vtkGeometricTextureFeatures::GetRelativeWallDensity() const { return this->Impl->Found.RelativeWallDensity; }

vtkTypeInt64 vtkGeometricTextureFeatures::GetNumberOfSelfIntersections() const { return this->Impl->Intersections; }

void vtkGeometricTextureFeatures::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "UnitLength: " << this->UnitLength << "\n";
  os << indent << "MinimumProminence: " << this->MinimumProminence << "\n";
  os << indent << "MergedSaddle: " << this->MergedSaddle << "\n";
  os << indent << "WallLevel: " << this->WallLevel << "\n";
  os << indent << "SmoothingLength: " << this->SmoothingLength << "\n";
  os << indent << "NumberOfPeaks: " << this->GetNumberOfPeaks() << "\n";
  os << indent << "MeanPeakHeight: " << this->GetMeanPeakHeight() << "\n";
  os << indent << "PeakHeightVariation: " << this->GetPeakHeightVariation() << "\n";
  os << indent << "MergedShare: " << this->GetMergedShare() << "\n";
  os << indent << "WallLength: " << this->GetWallLength() << "\n";
  os << indent << "NumberOfSelfIntersections: " << this->GetNumberOfSelfIntersections() << "\n";
}
