// SPDX-License-Identifier: BSD-3-Clause
#include "SampleArrays.h"

#include <vtkCompositeDataSet.h>
#include <vtkDataObjectTree.h>
#include <vtkDataObjectTreeIterator.h>
#include <vtkFieldData.h>
#include <vtkInformation.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>

#include <string>
#include <vector>

namespace surfsynth
{

namespace
{
std::string HeldName(std::int64_t number, const char* what)
{
  return "SurfaceSynthesis/" + std::to_string(number) + "/" + what;
}

vtkSmartPointer<vtkDoubleArray> TakeArray(vtkPolyData* surface, const std::string& name)
{
  vtkSmartPointer<vtkDoubleArray> array = vtkDoubleArray::SafeDownCast(
    surface->GetPointData()->GetAbstractArray(name.c_str()));
  surface->GetPointData()->RemoveArray(name.c_str());
  return array;
}

/// Makes an empty dataset for each sample, in @p output when there are several.
std::vector<vtkSmartPointer<vtkDataObject>> MakeTargets(
  vtkDataObject* held, const SampleRange& range, vtkDataObject* output)
{
  if (range.Count == 1)
  {
    return { output };
  }
  auto* blocks = vtkMultiBlockDataSet::SafeDownCast(output);
  blocks->SetNumberOfBlocks(static_cast<unsigned int>(range.Count));
  std::vector<vtkSmartPointer<vtkDataObject>> targets;
  for (unsigned int k = 0; k < static_cast<unsigned int>(range.Count); ++k)
  {
    auto target = vtkDataObjectTree::SafeDownCast(held)
      ? vtkSmartPointer<vtkDataObject>(vtkSmartPointer<vtkMultiBlockDataSet>::New())
      : vtkSmartPointer<vtkDataObject>(vtkSmartPointer<vtkPolyData>::New());
    blocks->SetBlock(k, target);
    const std::int64_t number = static_cast<std::int64_t>(range.First) + k;
    blocks->GetMetaData(k)->Set(vtkCompositeDataSet::NAME(), ("Sample " + std::to_string(number)).c_str());
    targets.push_back(target);
  }
  return targets;
}

/// Makes the output of each sample for one surface: a list in the order of samples.
std::vector<vtkSmartPointer<vtkPolyData>> FinishSurface(
  vtkPolyData* held, const SampleRange& range, const SampleFinisher& finish)
{
  vtkNew<vtkPolyData> rest;
  rest->ShallowCopy(held);
  std::vector<SampleArrays> samples;
  for (int k = 0; k < range.Count; ++k)
  {
    const std::int64_t number = static_cast<std::int64_t>(range.First) + k;
    samples.push_back({ TakeArray(rest, HeldName(number, "Signal")), TakeArray(rest, HeldName(number, "Noise")) });
  }
  std::vector<vtkSmartPointer<vtkPolyData>> results;
  for (const SampleArrays& sample : samples)
  {
    results.push_back(vtkSmartPointer<vtkPolyData>::New());
    results.back()->ShallowCopy(rest);
    if (sample.Signal && sample.Noise)
    {
      finish(results.back(), sample);
    }
  }
  return results;
}
} // namespace

void HoldSample(vtkPolyData* surface, std::int64_t number, const SampleArrays& sample)
{
  sample.Signal->SetName(HeldName(number, "Signal").c_str());
  sample.Noise->SetName(HeldName(number, "Noise").c_str());
  surface->GetPointData()->AddArray(sample.Signal);
  surface->GetPointData()->AddArray(sample.Noise);
}

void ArrangeSamples(vtkDataObject* held, const SampleRange& range, vtkDataObject* output, const SampleFinisher& finish)
{
  const auto targets = MakeTargets(held, range, output);
  auto* tree = vtkDataObjectTree::SafeDownCast(held);
  if (!tree)
  {
    const auto results = FinishSurface(vtkPolyData::SafeDownCast(held), range, finish);
    for (std::size_t k = 0; k < targets.size(); ++k)
    {
      targets[k]->ShallowCopy(results[k]);
    }
    return;
  }
  for (const auto& target : targets)
  {
    vtkDataObjectTree::SafeDownCast(target)->CopyStructure(tree);
    target->GetFieldData()->ShallowCopy(tree->GetFieldData());
  }
  const auto place = vtkSmartPointer<vtkDataObjectTreeIterator>::Take(tree->NewTreeIterator());
  place->VisitOnlyLeavesOn();
  place->TraverseSubTreeOn();
  for (place->InitTraversal(); !place->IsDoneWithTraversal(); place->GoToNextItem())
  {
    const auto results = FinishSurface(vtkPolyData::SafeDownCast(place->GetCurrentDataObject()), range, finish);
    for (std::size_t k = 0; k < targets.size(); ++k)
    {
      vtkDataObjectTree::SafeDownCast(targets[k])->SetDataSet(place, results[k]);
    }
  }
}

} // namespace surfsynth
