// SPDX-License-Identifier: BSD-3-Clause
#include "vtkIsotropicRemeshFilter.h"

#include "BlockBridge.h"
#include "IsotropicRemeshing.h"
#include "SurfaceArrays.h"
#include "SurfaceBridge.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Text.h"

#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkFieldData.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>

#include <cmath>

using surfsynth::RemeshedSurface;
using surfsynth::RemeshingOptions;
using surfsynth::Surface;

vtkStandardNewMacro(vtkIsotropicRemeshFilter);

namespace
{
const surfsynth::BlockTypes Types{ { "vtkPolyData" }, "vtkPolyData" };

surfsynth::MeshRequirements Requirements()
{
  surfsynth::MeshRequirements requirements;
  requirements.ManifoldVertices = true;
  requirements.ConsistentWinding = true;
  return requirements;
}

/// Puts the new mesh and the arrays of @p input that it carries into @p output.
void Fill(vtkPolyData* input, const Surface& surface, const RemeshedSurface& remeshed, vtkPolyData* output)
{
  surfsynth::SetGeometry(output, remeshed.Mesh, surfsynth::HasDoublePoints(input));
  output->GetFieldData()->ShallowCopy(input->GetFieldData());
  if (input->GetPointData()->GetNumberOfArrays() > 0)
  {
    surfsynth::InterpolateArrays(input->GetPointData(), surface.Mesh, remeshed.PlaceOfPoint, output->GetPointData());
  }
  if (input->GetCellData()->GetNumberOfArrays() == 0)
  {
    return;
  }
  std::vector<std::int64_t> cells(remeshed.OriginOfTriangle.size());
  for (std::size_t f = 0; f < cells.size(); ++f)
  {
    cells[f] = surface.Cell(remeshed.OriginOfTriangle[f]);
  }
  surfsynth::PickArrays(input->GetCellData(), cells, output->GetCellData());
}
} // namespace

/// What one update does with the parameters of the filter.
class vtkIsotropicRemeshFilter::Internals
{
public:
  explicit Internals(vtkIsotropicRemeshFilter* self)
    : Self(self)
  {}

  void Remesh(const surfsynth::Block& block, const surfsynth::Progress& progress) const
  {
    auto* input = vtkPolyData::SafeDownCast(block.Input);
    // Shared with the work, which outlives this call when it is cancelled.
    const auto surface = std::make_shared<const Surface>(surfsynth::ToSurface(input, Requirements()));
    const auto options = std::make_shared<const RemeshingOptions>(this->Options(input, *surface));
    const auto remeshed = std::make_shared<RemeshedSurface>();
    const auto work = [surface, options, remeshed](const std::atomic<bool>& stop)
    { *remeshed = surfsynth::RemeshIsotropically(surface->Mesh, *options, &stop); };
    const double expectedSeconds = 0.2 + 2e-5 * surface->Mesh.NumberOfTriangles();
    surfsynth::RunCancellable(work, expectedSeconds, surfsynth::SubProgress(progress, 0.05, 0.95));
    Fill(input, *surface, *remeshed, vtkPolyData::SafeDownCast(block.Output));
    this->Self->MeanEdgeLength = surfsynth::MeanEdgeLength(remeshed->Mesh);
  }

private:
  RemeshingOptions Options(vtkPolyData* input, const Surface& surface) const
  {
    const vtkIsotropicRemeshFilter* self = this->Self;
    RemeshingOptions options;
    options.EdgeLength =
      self->TargetEdgeLength > 0.0 ? self->TargetEdgeLength : surfsynth::MeanEdgeLength(surface.Mesh);
    options.NumberOfPoints = self->TargetNumberOfPoints;
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
        throw surfsynth::InvalidInput("The sizing array \"" + name + "\" is " + surfsynth::Text(lengths[p]) +
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
  const std::string wanted = name ? name : "";
  if (this->SizingArrayName != wanted)
  {
    this->SizingArrayName = wanted;
    this->Modified();
  }
}

int vtkIsotropicRemeshFilter::FillInputPortInformation(int, vtkInformation* info)
{
  return surfsynth::AcceptBlocks(info, Types);
}

int vtkIsotropicRemeshFilter::RequestDataObject(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  return surfsynth::RequestBlocks(this, inputVector, outputVector, Types);
}

int vtkIsotropicRemeshFilter::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  this->MeanEdgeLength = 0.0;
  const Internals remeshing(this);
  return surfsynth::ProcessBlocks(this, inputVector, outputVector, Types,
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
  os << indent << "MeanEdgeLength: " << this->MeanEdgeLength << "\n";
}
