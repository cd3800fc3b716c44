// SPDX-License-Identifier: BSD-3-Clause
#include "vtkSurfaceDistance.h"

#include "JointProcessing.h"
#include "StatisticsOutput.h"
#include "SurfaceArrays.h"
#include "SurfaceBridge.h"
#include "SurfaceInputs.h"
#include "TableColumns.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/SurfaceDistance.h"

#include <vtkDataObject.h>
#include <vtkDoubleArray.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkStringArray.h>
#include <vtkTable.h>

#include <string>
#include <vector>

using surfsynth::DistanceSummary;
using surfsynth::InvalidInput;
using surfsynth::SurfaceDistance;
using surfsynth::TriangleMesh;

vtkStandardNewMacro(vtkSurfaceDistance);

namespace
{
/// Triangles of a surface whose points are finite. @throws InvalidInput with the name of the surface
TriangleMesh MeasuredMesh(vtkPolyData* surface, const std::string& name)
{
  surfsynth::MeshRequirements requirements;
  requirements.ManifoldEdges = false;
  TriangleMesh mesh;
  try
  {
    mesh = surfsynth::ConvertSurface(surface).Mesh;
  }
  catch (const InvalidInput& error)
  {
    throw InvalidInput("The " + name + " surface cannot be measured: " + error.what());
  }
  for (const surfsynth::MeshFinding& finding : surfsynth::CheckMesh(mesh, requirements))
  {
    if (finding.Defect == surfsynth::MeshDefect::NonFinitePoint)
    {
      throw InvalidInput("The " + name + " surface has " + surfsynth::DescribeFindings({ finding }));
    }
  }
  return mesh;
}

/// Vertices of triangles, [V].
std::vector<bool> UsedPoints(const TriangleMesh& mesh)
{
  std::vector<bool> used(static_cast<std::size_t>(mesh.Points.rows()), false);
  for (Eigen::Index k = 0; k < mesh.Triangles.size(); ++k)
  {
    used[static_cast<std::size_t>(mesh.Triangles.data()[k])] = true;
  }
  return used;
}

/// Moves points that no triangle uses, which may be not finite, to the first vertex. @param used UsedPoints()
void GatherUnused(TriangleMesh& mesh, const std::vector<bool>& used)
{
  for (std::size_t v = 0; v < used.size() && mesh.Triangles.rows() > 0; ++v)
  {
    if (!used[v])
    {
      mesh.Points.row(static_cast<Eigen::Index>(v)) = mesh.Points.row(mesh.Triangles(0, 0));
    }
  }
}

void FillDistances(vtkTable* table, const SurfaceDistance& distance)
{
  const DistanceSummary* rows[3] = { &distance.FirstToSecond, &distance.SecondToFirst, &distance.Symmetric };
  std::vector<double> columns[4];
  for (const DistanceSummary* row : rows)
  {
    columns[0].push_back(row->Mean);
    columns[1].push_back(row->RMS);
    columns[2].push_back(row->Percentile95);
    columns[3].push_back(row->Maximum);
  }
  surfsynth::AddColumn<vtkStringArray>(
    table, "Direction", std::vector<std::string>{ "first to second", "second to first", "both" });
  const char* names[4] = { "Mean", "RMS", "Percentile95", "Maximum" };
  for (int c = 0; c < 4; ++c)
  {
    surfsynth::AddColumn<vtkDoubleArray>(table, names[c], columns[c]);
  }
}
} // namespace

/// Distances of the last update.
class vtkSurfaceDistance::Internals
{
public:
  explicit Internals(vtkSurfaceDistance* self)
    : Self(self)
  {}

  void Measure(
    vtkInformationVector** inputVector, vtkInformationVector* outputVector, const surfsynth::Progress& progress)
  {
    const auto first = surfsynth::SurfaceOn(inputVector[0]), second = surfsynth::SurfaceOn(inputVector[1]);
    const bool emptyFirst = !first || first->GetNumberOfCells() == 0;
    const bool emptySecond = !second || second->GetNumberOfCells() == 0;
    if (emptyFirst != emptySecond)
    {
      throw InvalidInput(
        std::string("The ") + (emptyFirst ? "first" : "second") + " surface is empty; two surfaces are needed.");
    }
    if (emptyFirst)
    {
      return;
    }
    TriangleMesh firstMesh = MeasuredMesh(first, "first"), secondMesh = MeasuredMesh(second, "second");
    const std::vector<bool> used = UsedPoints(firstMesh);
    GatherUnused(firstMesh, used);
    GatherUnused(secondMesh, UsedPoints(secondMesh));
    this->Distance = surfsynth::ComputeSurfaceDistance(firstMesh, secondMesh, surfsynth::FindNearestPlaces,
      this->Self->NumberOfSamples, static_cast<std::uint64_t>(this->Self->Seed),
      surfsynth::SubProgress(progress, 0.0, 0.95));
    vtkPolyData* output = vtkPolyData::GetData(outputVector, 0);
    output->ShallowCopy(first);
    Eigen::VectorXd distances = surfsynth::DistancesTo(secondMesh, firstMesh.Points, surfsynth::FindNearestPlaces);
    for (std::size_t v = 0; v < used.size(); ++v)
    {
      distances[static_cast<Eigen::Index>(v)] *= used[v] ? 1.0 : 0.0;
    }
    surfsynth::AddValues(output, "Distance", distances, 1);
    output->GetPointData()->SetActiveScalars("Distance");
    FillDistances(vtkTable::GetData(outputVector, 1), this->Distance);
  }

  SurfaceDistance Distance;

private:
  vtkSurfaceDistance* Self;
};

vtkSurfaceDistance::vtkSurfaceDistance()
  : Impl(std::make_unique<Internals>(this))
{
  this->SetNumberOfInputPorts(2);
  this->SetNumberOfOutputPorts(2);
}

vtkSurfaceDistance::~vtkSurfaceDistance() = default;

int vtkSurfaceDistance::FillInputPortInformation(int, vtkInformation* info) { return surfsynth::AcceptSurface(info); }

int vtkSurfaceDistance::FillOutputPortInformation(int port, vtkInformation* info)
{
  info->Set(vtkDataObject::DATA_TYPE_NAME(), port == 0 ? "vtkPolyData" : "vtkTable");
  return 1;
}

int vtkSurfaceDistance::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  this->Impl->Distance = SurfaceDistance();
  return surfsynth::ProcessJointly(this, inputVector, outputVector,
    [&](const surfsynth::Progress& progress) { this->Impl->Measure(inputVector, outputVector, progress); });
}

double vtkSurfaceDistance::GetMean() const { return this->Impl->Distance.Symmetric.Mean; }

double vtkSurfaceDistance::GetRMS() const { return this->Impl->Distance.Symmetric.RMS; }

double vtkSurfaceDistance::GetPercentile95() const { return this->Impl->Distance.Symmetric.Percentile95; }

double vtkSurfaceDistance::GetHausdorffDistance() const { return this->Impl->Distance.Symmetric.Maximum; }

void vtkSurfaceDistance::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "NumberOfSamples: " << this->NumberOfSamples << "\n";
  os << indent << "Seed: " << this->Seed << "\n";
  os << indent << "Mean: " << this->GetMean() << "\n";
  os << indent << "RMS: " << this->GetRMS() << "\n";
  os << indent << "Percentile95: " << this->GetPercentile95() << "\n";
  os << indent << "HausdorffDistance: " << this->GetHausdorffDistance() << "\n";
}
