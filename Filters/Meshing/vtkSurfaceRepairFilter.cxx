// SPDX-License-Identifier: BSD-3-Clause
#include "vtkSurfaceRepairFilter.h"

#include "BlockBridge.h"
#include "DataObjects.h"
#include "MeshProcessing/Repair/SurfaceRepair.h"
#include "Reporting.h"
#include "SurfaceArrays.h"
#include "UncheckedSurface.h"

#include "Core/Common/Errors.h"

#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkIdTypeArray.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkStringArray.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <limits>
#include <memory>

using surfsynth::RepairedSurface;
using surfsynth::RepairOptions;
using surfsynth::UncheckedSurface;

vtkStandardNewMacro(vtkSurfaceRepairFilter);

namespace
{
void AddFillingArray(const std::vector<bool>& isFilling, vtkPolyData* output)
{
  vtkNew<vtkUnsignedCharArray> filled;
  filled->SetName("FilledHole");
  filled->SetNumberOfValues(static_cast<vtkIdType>(isFilling.size()));
  for (std::size_t f = 0; f < isFilling.size(); ++f)
  {
    filled->SetValue(static_cast<vtkIdType>(f), isFilling[f] ? 1 : 0);
  }
  output->GetCellData()->AddArray(filled);
}

void AddReport(const surfsynth::RepairReport& report, vtkPolyData* output)
{
  vtkNew<vtkStringArray> actions;
  actions->SetName("RepairAction");
  vtkNew<vtkIdTypeArray> counts;
  counts->SetName("RepairCount");
  for (const auto& entry : report)
  {
    actions->InsertNextValue(entry.first);
    counts->InsertNextValue(entry.second);
  }
  output->GetFieldData()->AddArray(actions);
  output->GetFieldData()->AddArray(counts);
}

void AddMeasures(const std::vector<surfsynth::RepairMeasure>& measures, vtkPolyData* output)
{
  vtkNew<vtkStringArray> names;
  names->SetName("RepairMeasure");
  vtkNew<vtkDoubleArray> before;
  before->SetName("RepairBefore");
  vtkNew<vtkDoubleArray> after;
  after->SetName("RepairAfter");
  for (const surfsynth::RepairMeasure& measure : measures)
  {
    names->InsertNextValue(measure.Name);
    before->InsertNextValue(measure.Before);
    after->InsertNextValue(measure.After);
  }
  output->GetFieldData()->AddArray(names);
  output->GetFieldData()->AddArray(before);
  output->GetFieldData()->AddArray(after);
}

/// Fills @p output with the repaired mesh and the arrays of @p input.
void Fill(vtkPolyData* input, const UncheckedSurface& surface, const RepairedSurface& repaired, vtkPolyData* output)
{
  surfsynth::SetGeometry(output, repaired.Mesh, surfsynth::HasDoublePoints(input));
  surfsynth::InterpolateArrays(
    input->GetPointData(), surface.Usable.Mesh, repaired.PlaceOfPoint, output->GetPointData());
  std::vector<std::int64_t> cells(repaired.OriginOfTriangle.size());
  for (std::size_t f = 0; f < cells.size(); ++f)
  {
    cells[f] = surface.Usable.Cell(repaired.OriginOfTriangle[f]);
  }
  surfsynth::PickArrays(input->GetCellData(), cells, output->GetCellData());
  output->GetFieldData()->ShallowCopy(input->GetFieldData());
  AddFillingArray(repaired.IsFilling, output);
  AddReport(repaired.Report, output);
  AddMeasures(repaired.Outcome.Measures, output);
}
} // namespace

/// Work of one update with the parameters of the filter.
class vtkSurfaceRepairFilter::Internals
{
public:
  explicit Internals(vtkSurfaceRepairFilter* self)
    : Self(self)
  {}

  void Repair(const surfsynth::Block& block, const surfsynth::Progress& progress) const
  {
    auto* input = vtkPolyData::SafeDownCast(block.Input);
    // Shared with the work, which outlives this call when it is cancelled.
    const auto surface = std::make_shared<const UncheckedSurface>(surfsynth::ConvertUnchecked(input));
    const auto options = std::make_shared<const RepairOptions>(this->Options(input));
    const auto repaired = std::make_shared<RepairedSurface>();
    const auto work = [surface, options, repaired](const std::atomic<bool>& stop) {
      *repaired = surfsynth::RepairSurface(surface->Usable.Mesh, surface->Losses, *options, &stop);
    };
    const double expectedSeconds = 0.2 + 1e-5 * surface->Usable.Mesh.NumberOfTriangles();
    surfsynth::RunCancellable(work, expectedSeconds, surfsynth::SubProgress(progress, 0.05, 0.95));
    Fill(input, *surface, *repaired, vtkPolyData::SafeDownCast(block.Output));
    const auto& isFilling = repaired->IsFilling;
    if (this->Self->ActiveResult && std::find(isFilling.begin(), isFilling.end(), true) != isFilling.end())
    {
      surfsynth::SelectScalars(block.Output, { "FilledHole" });
    }
    for (const auto& entry : repaired->Report)
    {
      this->Self->Report += block.Where + (block.Where.empty() ? "" : ": ") + std::to_string(entry.second) + ": " +
        entry.first + "\n";
    }
    this->Tell(repaired->Outcome, block.Where);
  }

private:
  /// Adds the outcome of a block to that of the filter, and issues its warnings.
  void Tell(const surfsynth::RepairOutcome& outcome, const std::string& where) const
  {
    vtkSurfaceRepairFilter* self = this->Self;
    self->Complete = self->Complete && outcome.Warnings.empty();
    self->NumberOfIntersectingTriangles += static_cast<vtkTypeInt64>(outcome.IntersectingTriangles);
    self->NumberOfOpenHoles += static_cast<vtkTypeInt64>(outcome.OpenHoles);
    self->AreaLoss = std::max(self->AreaLoss, outcome.AreaLoss);
    self->VolumeLoss = std::max(self->VolumeLoss, outcome.VolumeLoss);
    self->ComponentChange = std::max(self->ComponentChange, outcome.ComponentChange);
    for (const std::string& warning : outcome.Warnings)
    {
      surfsynth::ReportWarning(self, where, warning);
    }
  }

  RepairOptions Options(vtkPolyData* input) const
  {
    const vtkSurfaceRepairFilter* self = this->Self;
    RepairOptions options;
    options.MergePoints = self->MergePoints;
    options.MergeTolerance = self->MergeTolerance;
    options.RemoveSelfIntersections = self->RemoveSelfIntersections;
    options.KeepLargestComponent = self->KeepLargestComponent;
    options.SmallestComponent = self->MinimumComponentFraction;
    options.OrientOutward = self->OrientOutward;
    options.Finder = surfsynth::FindNearestPlaces;
    options.MaximumLoss = self->MaximumLoss;
    options.Strict = self->Strict;
    options.SinglePrecision = !surfsynth::HasDoublePoints(input);
    if (self->HoleFilling == SMALL_HOLES)
    {
      options.LargestHole = self->MaximumHoleSize;
      options.LargestHoleFraction = 0.1;
    }
    else if (self->HoleFilling == ALL_HOLES)
    {
      options.LargestHole = std::numeric_limits<double>::infinity();
    }
    return options;
  }

  vtkSurfaceRepairFilter* Self;
};

vtkSurfaceRepairFilter::vtkSurfaceRepairFilter() = default;

vtkSurfaceRepairFilter::~vtkSurfaceRepairFilter() = default;

int vtkSurfaceRepairFilter::FillInputPortInformation(int, vtkInformation* info)
{
  return surfsynth::AcceptBlocks(info, surfsynth::SurfaceToSurface);
}

int vtkSurfaceRepairFilter::RequestDataObject(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  return surfsynth::RequestBlocks(this, inputVector, outputVector, surfsynth::SurfaceToSurface);
}

int vtkSurfaceRepairFilter::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  this->Report.clear();
  this->Complete = true;
  this->NumberOfIntersectingTriangles = 0;
  this->NumberOfOpenHoles = 0;
  this->AreaLoss = 0.0;
  this->VolumeLoss = 0.0;
  this->ComponentChange = 0.0;
  const Internals repair(this);
  const int success = surfsynth::ProcessBlocks(this, inputVector, outputVector, surfsynth::SurfaceToSurface,
    [&](const surfsynth::Block& block, const surfsynth::Progress& progress) { repair.Repair(block, progress); });
  this->Complete = this->Complete && success != 0;
  return success;
}

void vtkSurfaceRepairFilter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "MergePoints: " << this->MergePoints << "\n";
  os << indent << "MergeTolerance: " << this->MergeTolerance << "\n";
  os << indent << "HoleFilling: " << this->HoleFilling << "\n";
  os << indent << "MaximumHoleSize: " << this->MaximumHoleSize << "\n";
  os << indent << "KeepLargestComponent: " << this->KeepLargestComponent << "\n";
  os << indent << "MinimumComponentFraction: " << this->MinimumComponentFraction << "\n";
  os << indent << "RemoveSelfIntersections: " << this->RemoveSelfIntersections << "\n";
  os << indent << "OrientOutward: " << this->OrientOutward << "\n";
  os << indent << "MaximumLoss: " << this->MaximumLoss << "\n";
  os << indent << "Strict: " << this->Strict << "\n";
  os << indent << "ActiveResult: " << this->ActiveResult << "\n";
  os << indent << "Complete: " << this->Complete << "\n";
  os << indent << "NumberOfIntersectingTriangles: " << this->NumberOfIntersectingTriangles << "\n";
  os << indent << "NumberOfOpenHoles: " << this->NumberOfOpenHoles << "\n";
  os << indent << "AreaLoss: " << this->AreaLoss << "\n";
  os << indent << "VolumeLoss: " << this->VolumeLoss << "\n";
  os << indent << "ComponentChange: " << this->ComponentChange << "\n";
  os << indent << "Report: " << this->Report << "\n";
}
