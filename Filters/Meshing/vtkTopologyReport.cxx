// SPDX-License-Identifier: BSD-3-Clause
#include "vtkTopologyReport.h"

#include "BlockBridge.h"
#include "SurfaceInspection.h"
#include "TopologyRows.h"

#ifdef SURFACE_SYNTHESIS_CGAL
#include "MeshProcessing/Repair/SelfIntersections.h"
#endif

#include <vtkDataObject.h>
#include <vtkDemandDrivenPipeline.h>
#include <vtkDoubleArray.h>
#include <vtkIdTypeArray.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkStringArray.h>
#include <vtkTable.h>

#include <atomic>
#include <cstring>
#include <memory>
#include <string>
#include <utility>
#include <vector>

using surfsynth::Block;
using surfsynth::ReportRow;

vtkStandardNewMacro(vtkTopologyReport);

namespace
{
const surfsynth::BlockTypes SurfaceToTable{ { "vtkPolyData" }, "vtkTable" };

/// Makes an empty column of the table.
template <typename Array>
vtkSmartPointer<Array> NewColumn(const char* name, const std::vector<ReportRow>& rows)
{
  auto column = vtkSmartPointer<Array>::New();
  column->SetName(name);
  column->SetNumberOfValues(static_cast<vtkIdType>(rows.size()));
  return column;
}

void AddReport(vtkTable* table, const std::vector<ReportRow>& rows)
{
  const auto block = NewColumn<vtkIntArray>("Block", rows);
  const auto component = NewColumn<vtkIntArray>("Component", rows);
  const auto property = NewColumn<vtkStringArray>("Property", rows);
  const auto value = NewColumn<vtkDoubleArray>("Value", rows);
  const auto first = NewColumn<vtkIdTypeArray>("First", rows);
  const auto remark = NewColumn<vtkStringArray>("Remark", rows);
  for (vtkIdType k = 0; k < static_cast<vtkIdType>(rows.size()); ++k)
  {
    const ReportRow& row = rows[static_cast<std::size_t>(k)];
    block->SetValue(k, static_cast<int>(row.Block));
    component->SetValue(k, row.Component);
    property->SetValue(k, row.Property);
    value->SetValue(k, row.Value);
    first->SetValue(k, static_cast<vtkIdType>(row.First));
    remark->SetValue(k, row.Remark);
  }
  for (vtkAbstractArray* column :
    std::initializer_list<vtkAbstractArray*>{ block, component, property, value, first, remark })
  {
    table->AddColumn(column);
  }
}

surfsynth::IntersectingTriangles FindIntersections(
  const std::shared_ptr<const surfsynth::InspectedSurface>& surface, const surfsynth::Progress& progress)
{
#ifdef SURFACE_SYNTHESIS_CGAL
  const auto found = std::make_shared<std::vector<surfsynth::Index>>();
  const auto work = [surface, found](const std::atomic<bool>& stop) {
    *found = surfsynth::FindIntersectingTriangles(surface->Mesh, &stop);
  };
  const double expectedSeconds = 0.05 + 2e-6 * surface->Mesh.NumberOfTriangles();
  surfsynth::RunCancellable(work, expectedSeconds, progress);
  return std::move(*found);
#else
  static_cast<void>(surface);
  surfsynth::Report(progress, 1.0);
  return {};
#endif
}
} // namespace

class vtkTopologyReport::Internals
{
public:
  void AddSurface(const Block& block, int components, const surfsynth::Progress& progress)
  {
    // Shared with the search, which outlives this call when it is cancelled.
    const auto surface = std::make_shared<const surfsynth::InspectedSurface>(
      surfsynth::InspectSurface(vtkPolyData::SafeDownCast(block.Input)));
    surfsynth::Report(progress, 0.1);
    const auto statistics = surfsynth::ComputeMeshStatistics(surface->Mesh, surfsynth::SubProgress(progress, 0.1, 0.5));
    const auto intersecting = FindIntersections(surface, surfsynth::SubProgress(progress, 0.5, 1.0));
    const auto rows = surfsynth::ReportRows(block.FlatIndex, *surface, statistics, intersecting, components);
    this->Rows.insert(this->Rows.end(), rows.begin(), rows.end());
  }

  const ReportRow* Find(const char* property, unsigned int block, int component) const
  {
    if (!property)
    {
      return nullptr;
    }
    const std::string name = std::strcmp(property, "Sound") == 0 ? "Valid" : property; // the former name
    for (const ReportRow& row : this->Rows)
    {
      if (row.Block == block && row.Component == component && row.Property == name)
      {
        return &row;
      }
    }
    return nullptr;
  }

  std::vector<ReportRow> Rows;
};

vtkTopologyReport::vtkTopologyReport()
  : Impl(std::make_unique<Internals>())
{}

vtkTopologyReport::~vtkTopologyReport() = default;

int vtkTopologyReport::FillInputPortInformation(int, vtkInformation* info)
{
  return surfsynth::AcceptBlocks(info, SurfaceToTable);
}

int vtkTopologyReport::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  this->Impl->Rows.clear();
  vtkTable* table = vtkTable::GetData(outputVector);
  table->Initialize();
  // One table is made of all blocks; the outputs of the frame for each block stay empty and are dropped.
  vtkNew<vtkInformationVector> scratch;
  vtkNew<vtkInformation> information;
  scratch->Append(information);
  if (!surfsynth::RequestBlocks(this, inputVector, scratch, SurfaceToTable))
  {
    return 0;
  }
  const auto addSurface = [this](const Block& block, const surfsynth::Progress& progress) {
    this->Impl->AddSurface(block, this->NumberOfComponentRows, progress);
  };
  const int success = surfsynth::ProcessBlocks(this, inputVector, scratch, SurfaceToTable, addSurface);
  if (information->Has(vtkDemandDrivenPipeline::DATA_NOT_GENERATED())) // cancelled
  {
    this->Impl->Rows.clear();
    outputVector->GetInformationObject(0)->Set(vtkDemandDrivenPipeline::DATA_NOT_GENERATED(), 1);
  }
  if (!this->Impl->Rows.empty())
  {
    AddReport(table, this->Impl->Rows);
  }
  return success;
}

bool vtkTopologyReport::HasValue(const char* property, unsigned int block, int component) const
{
  return this->Impl->Find(property, block, component) != nullptr;
}

double vtkTopologyReport::GetValue(const char* property, unsigned int block, int component) const
{
  const ReportRow* row = this->Impl->Find(property, block, component);
  return row ? row->Value : 0.0;
}

bool vtkTopologyReport::GetValid() const
{
  bool valid = !this->Impl->Rows.empty();
  for (const ReportRow& row : this->Impl->Rows)
  {
    valid = valid && (row.Property != "Valid" || row.Value > 0.0);
  }
  return valid;
}

void vtkTopologyReport::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "NumberOfComponentRows: " << this->NumberOfComponentRows << "\n";
  os << indent << "Valid: " << this->GetValid() << "\n";
}
