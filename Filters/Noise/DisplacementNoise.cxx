// SPDX-License-Identifier: BSD-3-Clause
#include "DisplacementNoise.h"

#include "SurfaceArrays.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Mesh/MeshCheck.h"
#include "Core/Operators/SurfaceOperators.h"

#include <vtkDataArray.h>
#include <vtkDataObjectTree.h>
#include <vtkDataObjectTreeIterator.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPointSet.h>
#include <vtkPoints.h>
#include <vtkSmartPointer.h>

#include <utility>

namespace surfsynth
{

namespace
{
void MoveSurface(vtkPointSet* surface, const std::string& name)
{
  vtkDataArray* displacement = surface ? surface->GetPointData()->GetArray(name.c_str()) : nullptr;
  if (!displacement || displacement->GetNumberOfComponents() != 3 || surface->GetNumberOfPoints() == 0)
  {
    return;
  }
  vtkNew<vtkPoints> moved;
  moved->SetDataType(surface->GetPoints()->GetDataType());
  moved->SetNumberOfPoints(surface->GetNumberOfPoints());
  for (vtkIdType p = 0; p < surface->GetNumberOfPoints(); ++p)
  {
    double point[3];
    surface->GetPoint(p, point);
    for (int c = 0; c < 3; ++c)
    {
      point[c] += displacement->GetComponent(p, c);
    }
    moved->SetPoint(p, point);
  }
  surface->SetPoints(moved);
  DropNormals(surface);
}
} // namespace

void DisplacementNoise::Begin(std::optional<DisplacementDirections> directions)
{
  this->Directions = directions;
  this->Inverted = 0;
  this->Blocks.Begin();
}

std::shared_ptr<const SurfaceDisplacement> DisplacementNoise::Of(const Surface& surface)
{
  if (!this->IsOn())
  {
    return nullptr;
  }
  if (surface.Volume)
  {
    throw InvalidInput("Displacement moves surfaces, and the input is a volume; NumberOfComponents 3 without "
                       "Displacement gives vectors in it.");
  }
  const auto isCurrent = [this](const std::shared_ptr<const SurfaceDisplacement>& held) {
    return held->Directions() == *this->Directions;
  };
  if (const auto* held = this->Blocks.Find(surface, isCurrent))
  {
    return *held;
  }
  PointMatrix normals;
  if (*this->Directions != DisplacementDirections::Free)
  {
    MeshRequirements requirements;
    requirements.ConsistentWinding = true;
    const MeshTopology topology = RequireValidMesh(
      surface.Mesh, requirements, [&](std::int64_t f) { return surface.Cell(f); });
    normals = TangentFrames(surface.Mesh, topology).Normal;
  }
  return this->Blocks.Insert(surface,
    std::make_shared<const SurfaceDisplacement>(*this->Directions, surface.Mesh.NumberOfPoints(), std::move(normals)));
}

std::string DisplacementNoise::Finish(
  const Surface& surface, const SurfaceDisplacement& displacement, const std::vector<double*>& samples)
{
  std::vector<InvertedTriangles> inverted(samples.size());
  ParallelTasks(static_cast<std::int64_t>(samples.size()), [&](std::int64_t k) {
    const auto sample = static_cast<std::size_t>(k);
    displacement.ToDisplacements(samples[sample]);
    inverted[sample] = FindInvertedTriangles(surface.Mesh, samples[sample]);
  });
  std::int64_t folded = 0;
  InvertedTriangles most;
  for (const InvertedTriangles& found : inverted)
  {
    folded += found.Count > 0 ? 1 : 0;
    this->Inverted += found.Count;
    most = found.Count > most.Count ? found : most;
  }
  if (folded == 0)
  {
    return "";
  }
  return "The displacement inverts triangles in " + std::to_string(folded) + " of " + std::to_string(samples.size()) +
    (samples.size() == 1 ? " sample: " : " samples, in one of them ") + std::to_string(most.Count) + " of " +
    std::to_string(surface.Mesh.NumberOfTriangles()) + " (first cell " + std::to_string(surface.Cell(most.First)) +
    "): the surface folds there. Choose a smaller StandardDeviation, a larger CorrelationRange, or a larger "
    "OperatorPower.";
}

void MovePointsBy(vtkDataObject* output, const std::string& name)
{
  auto* tree = vtkDataObjectTree::SafeDownCast(output);
  if (!tree)
  {
    MoveSurface(vtkPointSet::SafeDownCast(output), name);
    return;
  }
  const auto place = vtkSmartPointer<vtkDataObjectTreeIterator>::Take(tree->NewTreeIterator());
  place->VisitOnlyLeavesOn();
  place->TraverseSubTreeOn();
  for (place->InitTraversal(); !place->IsDoneWithTraversal(); place->GoToNextItem())
  {
    MoveSurface(vtkPointSet::SafeDownCast(place->GetCurrentDataObject()), name);
  }
}

} // namespace surfsynth
