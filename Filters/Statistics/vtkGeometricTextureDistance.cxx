// SPDX-License-Identifier: BSD-3-Clause
#include "vtkGeometricTextureDistance.h"

#include "DataObjects.h"
#include "JointProcessing.h"
#include "StatisticsOutput.h"
#include "SurfaceBridge.h"
#include "SurfaceInputs.h"

#include "Core/Common/Errors.h"
#include "Core/Statistics/GeometricTextureDistance.h"
#include "Inference/GeometricTexture/GeometricTextureSampler.h"

#include <vtkDoubleArray.h>
#include <vtkIdTypeArray.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkObjectFactory.h>
#include <vtkPolyData.h>
#include <vtkTable.h>

#include <string>

using surfsynth::InvalidInput;
using surfsynth::TriangleMesh;

vtkStandardNewMacro(vtkGeometricTextureDistance);

namespace
{
/// Datasets of one update; an empty one is null.
struct Pair
{
  explicit Pair(vtkInformationVector** inputVector)
    : Surface(NotEmpty(surfsynth::SurfaceOn(inputVector[0])))
    , Reference(NotEmpty(surfsynth::SurfaceOn(inputVector[1])))
  {}

  vtkSmartPointer<vtkPolyData> Surface;
  vtkSmartPointer<vtkPolyData> Reference;

private:
  static vtkSmartPointer<vtkPolyData> NotEmpty(const vtkSmartPointer<vtkPolyData>& given)
  {
    return surfsynth::IsEmpty(given) ? nullptr : given;
  }
};

/// @param name beginning of messages
TriangleMesh ToMesh(vtkPolyData* given, const std::string& name)
{
  if (!given)
  {
    throw InvalidInput(name + " is empty; a surface with at least one triangle is needed.");
  }
  try
  {
    return surfsynth::ToSurface(given, surfsynth::GeometricTextureSampler::Requirements()).Mesh;
  }
  catch (const InvalidInput& error)
  {
    throw InvalidInput(name + ": " + error.what());
  }
}

void AddDistance(
  vtkTable* table, const surfsynth::TextureDistance& found, const TriangleMesh& surface, const TriangleMesh& reference)
{
  surfsynth::AddValue<vtkDoubleArray>(table, "Distance", found.Distance);
  surfsynth::AddValue<vtkDoubleArray>(table, "StandardError", found.StandardError);
  surfsynth::AddValue<vtkDoubleArray>(table, "MeanEdgeLength", found.MeanEdgeLength);
  surfsynth::AddValue<vtkDoubleArray>(table, "ReferenceMeanEdgeLength", found.ReferenceMeanEdgeLength);
  surfsynth::AddValue<vtkIdTypeArray>(table, "NumberOfTriangles", surface.NumberOfTriangles());
  surfsynth::AddValue<vtkIdTypeArray>(table, "NumberOfReferenceTriangles", reference.NumberOfTriangles());
}
} // namespace

vtkGeometricTextureDistance::vtkGeometricTextureDistance() { this->SetNumberOfInputPorts(2); }

vtkGeometricTextureDistance::~vtkGeometricTextureDistance() = default;

int vtkGeometricTextureDistance::FillInputPortInformation(int, vtkInformation* info)
{
  return surfsynth::AcceptSurface(info);
}

int vtkGeometricTextureDistance::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  this->Distance = this->StandardError = 0.0;
  const auto compare = [&](const surfsynth::Progress& progress) {
    const Pair pair(inputVector);
    if (!pair.Surface && !pair.Reference)
    {
      return;
    }
    const TriangleMesh surface = ToMesh(pair.Surface, "The surface on port 0");
    const TriangleMesh reference = ToMesh(pair.Reference, "The reference on port 1");
    surfsynth::GeometricTextureDistanceOptions options;
    options.UnitLength = this->UnitLength;
    options.ReferenceUnitLength = this->ReferenceUnitLength;
    options.Projections = this->NumberOfProjections;
    options.Rings = this->NumberOfRings;
    options.Seed = static_cast<std::uint64_t>(this->Seed);
    const surfsynth::TextureDistance found = surfsynth::CompareGeometricTextures(surface, reference, options, progress);
    AddDistance(vtkTable::GetData(outputVector, 0), found, surface, reference);
    this->Distance = found.Distance;
    this->StandardError = found.StandardError;
  };
  return surfsynth::ProcessJointly(this, inputVector, outputVector, compare);
}

void vtkGeometricTextureDistance::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "UnitLength: " << this->UnitLength << "\n";
  os << indent << "ReferenceUnitLength: " << this->ReferenceUnitLength << "\n";
  os << indent << "NumberOfProjections: " << this->NumberOfProjections << "\n";
  os << indent << "NumberOfRings: " << this->NumberOfRings << "\n";
  os << indent << "Seed: " << this->Seed << "\n";
  os << indent << "Distance: " << this->Distance << "\n";
  os << indent << "StandardError: " << this->StandardError << "\n";
}
