// SPDX-License-Identifier: BSD-3-Clause
#include "TrainingReading.h"

#include "DataObjects.h"
#include "EnsembleReading.h"
#include "SurfaceBridge.h"
#include "SurfaceInputs.h"

#include "Core/Common/Errors.h"
#include "Inference/FlowMatching/FlowMatchingSampler.h"

#include <vtkDataArray.h>
#include <vtkDataObjectTree.h>
#include <vtkDataObjectTreeIterator.h>
#include <vtkNew.h>

#include <cmath>
#include <utility>

namespace surfsynth
{

namespace
{
/// Half the width of the region around the origin where positions keep their digits, in extents of the surface.
constexpr double ExtentsAround = 32.0;

/// Calls visit(block, flat index) for each block that holds something: leaves, or what lies directly in the tree.
template <typename Visit>
void EachBlock(vtkDataObjectTree* tree, bool leaves, const Visit& visit)
{
  const auto place = vtkSmartPointer<vtkDataObjectTreeIterator>::Take(tree->NewTreeIterator());
  place->SetVisitOnlyLeaves(leaves);
  place->SetTraverseSubTree(leaves);
  for (place->InitTraversal(); !place->IsDoneWithTraversal(); place->GoToNextItem()) // null blocks are passed over
  {
    if (!IsEmpty(place->GetCurrentDataObject()))
    {
      visit(place->GetCurrentDataObject(), place->GetCurrentFlatIndex());
    }
  }
}

vtkSmartPointer<vtkPolyData> CopyOfStructure(vtkPolyData* surface)
{
  vtkNew<vtkPolyData> structure;
  structure->CopyStructure(surface);
  auto copy = vtkSmartPointer<vtkPolyData>::New();
  copy->DeepCopy(structure);
  return copy;
}

/// Offset to take off positions so that they keep their digits in single precision: nothing near the origin, else about
/// the middle of the surface, such that the difference is exact. Training does not see where a sample lies.
Eigen::RowVector3d ShiftToOrigin(const TriangleMesh& mesh)
{
  const Eigen::RowVector3d low = mesh.Points.colwise().minCoeff();
  const Eigen::RowVector3d high = mesh.Points.colwise().maxCoeff();
  const double extent = (high - low).maxCoeff();
  const double grid = std::exp2(std::ceil(std::log2(2.0 * ExtentsAround * extent)));
  return (0.5 * (low + high) / grid).array().round() * grid;
}
} // namespace

TrainingReader::TrainingReader(vtkDataObject* sources, const std::string& arrayName)
  : ArrayName(arrayName)
{
  if (auto* tree = vtkDataObjectTree::SafeDownCast(sources))
  {
    EachBlock(tree, true, [this](vtkDataObject* data, unsigned int flatIndex) {
      this->AddSource(data, "Block " + std::to_string(flatIndex), this->Sources.size());
    });
  }
  else if (!IsEmpty(sources))
  {
    this->AddSource(sources, "", 0);
  }
}

void TrainingReader::AddSource(vtkDataObject* data, const std::string& place, std::size_t number)
{
  const std::string name = place.empty() ? "the source" : "source " + std::to_string(number) + " (" + place + ")";
  const auto surface = vtkSmartPointer<vtkPolyData>(vtkPolyData::SafeDownCast(AsSurfaces(data)));
  if (!surface)
  {
    throw InvalidInput("What should be " + name + " is " + DescribeInput(data) +
      " where a vtkPolyData is needed; vtkDataSetSurfaceFilter extracts a surface.");
  }
  try
  {
    const Surface converted = ToSurface(surface, FlowMatchingSampler::Requirements());
    UsedPoints used(converted.Mesh);
    TriangleMesh mesh = used.Compact(converted.Mesh);
    const Eigen::RowVector3d shift = ShiftToOrigin(mesh);
    this->Sources.push_back({ name, CopyOfStructure(surface), std::move(used), std::move(mesh), shift, {}, 0 });
  }
  catch (const InvalidInput& error)
  {
    throw InvalidInput("What is wrong with " + name + ": " + error.what());
  }
}

void TrainingReader::AddSamples(vtkDataObject* samples)
{
  std::vector<vtkDataObject*> blocks = { samples };
  if (this->Sources.size() > 1)
  {
    blocks.clear();
    if (auto* tree = vtkDataObjectTree::SafeDownCast(samples))
    {
      EachBlock(tree, false, [&](vtkDataObject* block, unsigned int) { blocks.push_back(block); });
    }
    if (blocks.size() != this->Sources.size())
    {
      throw InvalidInput("There are " + std::to_string(this->Sources.size()) + " sources, and samples in " +
        std::to_string(blocks.size()) +
        " blocks; with several sources the samples must be a composite dataset with a "
        "block for each source, in their order, that holds its samples.");
    }
  }
  for (std::size_t k = 0; k < this->Sources.size(); ++k)
  {
    this->AddSamples(this->Sources[k], blocks[k]);
  }
}

void TrainingReader::AddSamples(Source& source, vtkDataObject* samples)
{
  const Ensemble ensemble = ReadEnsemble(samples, "training", this->ArrayName);
  for (std::size_t k = 0; k < ensemble.Samples.size(); ++k)
  {
    const int found = ensemble.Samples[k].Values->GetNumberOfComponents();
    this->Components = this->Components == 0 ? found : this->Components;
    if (found != this->Components)
    {
      throw InvalidInput("The " + ensemble.NameOf(k) + " has " + std::to_string(found) +
        " components and the first sample has " + std::to_string(this->Components) +
        "; all samples must have the same number.");
    }
  }
  RequireOneTriangulation(ensemble, { source.Surface, source.Name }, this->Components);
  for (std::size_t k = 0; k < ensemble.Samples.size(); ++k)
  {
    this->AddSample(source, ensemble.Samples[k], "The " + ensemble.NameOf(k));
  }
}

void TrainingReader::AddSample(Source& source, const EnsembleSample& sample, const std::string& name)
{
  const bool positions = this->ArrayName.empty() || this->ArrayName == SignalDataset::PositionName;
  std::vector<double> tuple(static_cast<std::size_t>(this->Components));
  if (positions && this->Components != 3)
  {
    throw InvalidInput(name + " has " + std::to_string(this->Components) + " components; positions must have 3.");
  }
  for (Index k = 0; k < source.Used.Count(); ++k)
  {
    sample.Values->GetTuple(source.Used.Id(k), tuple.data());
    for (std::size_t c = 0; c < tuple.size(); ++c)
    {
      const auto value = static_cast<float>(tuple[c] - (positions ? source.Shift[static_cast<Eigen::Index>(c)] : 0.0));
      if (!std::isfinite(value))
      {
        throw InvalidInput(name + " is not finite in single precision at point " + std::to_string(source.Used.Id(k)) +
          "; finite numbers are needed at all points that polygons use.");
      }
      source.Values.push_back(value);
    }
  }
  ++source.Samples;
}

std::int64_t TrainingReader::NumberOfSamples() const
{
  std::int64_t count = 0;
  for (const Source& source : this->Sources)
  {
    count += source.Samples;
  }
  return count;
}

SignalDataset TrainingReader::Take()
{
  SignalDataset dataset;
  dataset.SignalName = this->ArrayName.empty() ? SignalDataset::PositionName : this->ArrayName;
  for (Source& source : this->Sources)
  {
    if (source.Samples == 0)
    {
      throw InvalidInput("There is no sample of " + source.Name + "; at least one is needed.");
    }
    const auto numbers = static_cast<Eigen::Index>(source.Values.size()) / source.Samples;
    SignalSource& taken = dataset.Sources.emplace_back();
    taken.Mesh = std::move(source.Mesh);
    taken.Samples = Eigen::Map<const SignalSamples>(source.Values.data(), source.Samples, numbers);
    std::vector<float>().swap(source.Values); // now, so that only the samples of one source are ever held twice
  }
  this->Sources.clear();
  return dataset;
}

} // namespace surfsynth
