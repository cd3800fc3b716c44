// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Parts that the frames around RequestData share, for filters that none of the frames fits. Not installed.
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

#include "Reporting.h"

#include "Core/Common/Progress.h"

#include <vtkDataObject.h>
#include <vtkDataObjectTree.h>
#include <vtkDataObjectTreeIterator.h>
#include <vtkSmartPointer.h>

#include <functional>
#include <string>
#include <vector>

class vtkAlgorithm;
class vtkInformationVector;

namespace surfsynth
{

class Ranks;

/// Progress of one call of a filter's RequestData: reports of core calls go to UpdateProgress(), never backwards, and
/// the user's request to stop goes to them.
class VTKSURFACESYNTHESISBRIDGE_EXPORT PipelineProgress
{
public:
  explicit PipelineProgress(vtkAlgorithm* self)
    : Self(self)
  {}
  /// Returns the callback that covers [@p begin, @p end] of the filter's progress; it must not outlive this object.
  Progress Within(double begin, double end);

private:
  vtkAlgorithm* Self;
  double Done = 0.0;
};

/// Place of a dataset: that of one by itself, or of a block in a composite dataset.
struct BlockPlace
{
  unsigned int FlatIndex = 0; ///< 0 for a dataset by itself
  /// Begin of messages: "" for a dataset by itself, else "Block 3", or "Block 3 \"hand\"" for a block with a name.
  std::string Name;
};

/// Returns the place of the dataset at which the iterator stands.
VTKSURFACESYNTHESISBRIDGE_EXPORT BlockPlace PlaceOf(vtkDataObjectTreeIterator* place);

/// Calls @p work on @p input, which may be null, and returns the text of what went wrong; empty when nothing did.
/// @throws Cancelled
VTKSURFACESYNTHESISBRIDGE_EXPORT std::string Attempt(vtkDataObject* input, const std::function<void()>& work);

/// Calls @p work with as many threads for the core as vtkSMPTools uses, and turns what it throws into one error event
/// or, when it was cancelled, into an empty output that the next update makes again. The data objects on the inputs stay
/// alive meanwhile, also when an observer of an event connects others.
/// @return what RequestData returns: 1 when @p work returned true or was cancelled, else 0.
VTKSURFACESYNTHESISBRIDGE_EXPORT int RunGuarded(
  vtkAlgorithm* self, vtkInformationVector* outputVector, const std::function<bool()>& work);

/// Throws Cancelled on every rank when @p cancelled is true on one. Collective.
void CancelTogether(const Ranks& ranks, bool cancelled);

/// Finds the leaves of the tree, in order, of which several ranks hold something; @p sizes says how much this rank
/// does. Collective. Empty, and an error on every rank, when the trees differ from rank to rank.
std::vector<bool> SharedLeaves(
  vtkAlgorithm* self, const Ranks& ranks, vtkDataObjectTree* tree, const std::vector<std::int64_t>& sizes);

/// Calls visit(place) for every leaf of @p tree, null ones included; place->GetCurrentDataObject() is the leaf.
template <typename Visit>
void EachLeaf(vtkDataObjectTree* tree, const Visit& visit)
{
  const auto place = vtkSmartPointer<vtkDataObjectTreeIterator>::Take(tree->NewTreeIterator());
  place->VisitOnlyLeavesOn();
  place->TraverseSubTreeOn();
  place->SkipEmptyNodesOff();
  for (place->InitTraversal(); !place->IsDoneWithTraversal(); place->GoToNextItem())
  {
    visit(place.Get());
  }
}

} // namespace surfsynth
