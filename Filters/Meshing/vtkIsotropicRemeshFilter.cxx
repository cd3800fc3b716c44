// SPDX-License-Identifier: BSD-3-Clause
#include "vtkIsotropicRemeshFilter.h"

#include "BlockBridge.h"
#include "FilterSupport.h"
#include "RemeshedDataset.h"
#include "SurfaceArrays.h"
#include "SurfaceBridge.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Mesh/MeshStatistics.h"

#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>

#include <cmath>

using surfsynth::RemeshingOptions;
using surfsynth::Surface;

vtkStandardNewMacro(vtkIsotropicRemeshFilter);

/// Work of one update with the parameters of the filter.
class vtkIsotropicRemeshFilter::Internals
{
public:
  explicit Internals(vtkIsotropicRemeshFilter* self)
    : Self(self)
  {}

  void Remesh(const surfsynth::Block& block, const surfsynth::Progress& progress) const
  {
    auto* input = vtkPolyData::SafeDownCast(block.Input);
    const auto surface = std::make_shared<const Surface>(
      surfsynth::ToSurface(input, surfsynth::RemeshingRequirements()));
    const auto options = std::make_shared<const RemeshingOptions>(this->Options(input, *surface));
    const surfsynth::RemeshedSurface remeshed = surfsynth::RemeshSurface(
      surface, options, surfsynth::SubProgress(progress, 0.05, 0.95));
    surfsynth::FillRemeshed(input, *surface, remeshed, vtkPolyData::SafeDownCast(block.Output));
    this->Self->MeanEdgeLength = surfsynth::MeanSideLength(remeshed.Mesh);
  }

private:
  RemeshingOptions Options(vtkPolyData* input, const Surface& surface) const
  {
    const vtkIsotropicRemeshFilter* self = this->Self;
    RemeshingOptions options;
    options.EdgeLength = self->TargetEdgeLength > 0.0 ? self->TargetEdgeLength
                                                      : surfsynth::MeanSideLength(surface.Mesh);
    options.NumberOfPoints = self->TargetNumberOfPoints;
    options.MaximumNumberOfPoints = self->MaximumNumberOfPoints;
    options.PointEdgeLengths = this->PointEdgeLengths(input);
    options.FeatureAngle = self->KeepFeatureEdges ? self->FeatureAngle : 180.0;
    options.KeepBoundaryPoints = self->KeepBoundaryPoints;
    options.NumberOfIterations = self->NumberOfIterations;
    options.NumberOfRelaxationSteps = self->NumberOfRelaxationSteps;
    options.FindPlaces = input->GetPointData()->GetNumberOfArrays() > 0;
    options.FindOrigins = input->GetCellData()->GetNumberOfArrays() > 0;
    options.PointClasses = surfsynth::AttributeClasses(input, surface.Mesh.Points);
    return options;
  }

  std::vector<double> PointEdgeLengths(vtkPolyData* input) const
  {
    const std::string& name = this->Self->SizingArrayName;
    if (name.empty())
    {
      return {};
    }
    vtkDataArray* array = input->GetPointData()->GetArray(name.c_str());
    const vtkIdType points = input->GetNumberOfPoints();
    if (!array || array->GetNumberOfComponents() != 1 || array->GetNumberOfTuples() != points)
    {
      throw surfsynth::InvalidInput(std::string("The sizing array \"") + name + "\" " +
        (array ? "has " + std::to_string(array->GetNumberOfTuples()) + " tuples of " +
              std::to_string(array->GetNumberOfComponents()) + " components"
               : "is missing") +
        "; a point array with one component for each of the " + std::to_string(points) +
        " points is needed, which holds the wanted edge lengths.");
    }
    std::vector<double> lengths(static_cast<std::size_t>(points));
    for (vtkIdType p = 0; p < points; ++p)
    {
      lengths[p] = array->GetTuple1(p);
      if (!(lengths[p] > 0.0) || !std::isfinite(lengths[p]))
      {
        throw surfsynth::InvalidInput("The sizing array \"" + name + "\" is " + surfsynth::FormatNumber(lengths[p]) +
          " at point " + std::to_string(p) + "; edge lengths must be finite and larger than 0.");
      }
    }
    return lengths;
  }

  vtkIsotropicRemeshFilter* Self;
};

vtkIsotropicRemeshFilter::vtkIsotropicRemeshFilter() = default;

vtkIsotropicRemeshFilter::~vtkIsotropicRemeshFilter() = default;

void vtkIsotropicRemeshFilter::SetSizingArrayName(const char* name)
{
  surfsynth::SetString(this, this->SizingArrayName, name);
}

int vtkIsotropicRemeshFilter::FillInputPortInformation(int, vtkInformation* info)
{
  return surfsynth::AcceptBlocks(info, surfsynth::SurfaceToSurface);
}

int vtkIsotropicRemeshFilter::RequestDataObject(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  return surfsynth::RequestBlocks(this, inputVector, outputVector, surfsynth::SurfaceToSurface);
}

int vtkIsotropicRemeshFilter::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  this->MeanEdgeLength = 0.0;
  const Internals remeshing(this);
  return surfsynth::ProcessBlocks(this, inputVector, outputVector, surfsynth::SurfaceToSurface,
    [&](const surfsynth::Block& block, const surfsynth::Progress& progress) { remeshing.Remesh(block, progress); });
}

void vtkIsotropicRemeshFilter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "TargetEdgeLength: " << this->TargetEdgeLength << "\n";
  os << indent << "TargetNumberOfPoints: " << this->TargetNumberOfPoints << "\n";
  os << indent << "SizingArrayName: " << this->SizingArrayName << "\n";
  os << indent << "KeepFeatureEdges: " << this->KeepFeatureEdges << "\n";
  os << indent << "FeatureAngle: " << this->FeatureAngle << "\n";
  os << indent << "KeepBoundaryPoints: " << this->KeepBoundaryPoints << "\n";
  os << indent << "NumberOfIterations: " << this->NumberOfIterations << "\n";
  os << indent << "NumberOfRelaxationSteps: " << this->NumberOfRelaxationSteps << "\n";
  os << indent << "MaximumNumberOfPoints: " << this->MaximumNumberOfPoints << "\n";
  os << indent << "MeanEdgeLength: " << this->MeanEdgeLength << "\n";
}
