// SPDX-License-Identifier: BSD-3-Clause
#include "MalformedCorpus.h"

#include "FilterChecks.h"
#include "VtkSurfaces.h"

#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDataObjectTree.h>
#include <vtkDataObjectTreeIterator.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPointSet.h>
#include <vtkPoints.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>

namespace surfsynthtest
{

namespace
{
using Leaves = std::vector<std::pair<unsigned int, vtkDataObject*>>;

/// The leaves of a data object with their flat indices (itself, 0, when it is no composite), null ones left out.
Leaves LeavesOf(vtkDataObject* data)
{
  auto* tree = vtkDataObjectTree::SafeDownCast(data);
  if (!tree)
  {
    return data ? Leaves{ { 0u, data } } : Leaves{};
  }
  Leaves leaves;
  const auto place = vtkSmartPointer<vtkDataObjectTreeIterator>::Take(tree->NewTreeIterator());
  for (place->InitTraversal(); !place->IsDoneWithTraversal(); place->GoToNextItem())
  {
    leaves.emplace_back(place->GetCurrentFlatIndex(), place->GetCurrentDataObject());
  }
  return leaves;
}

bool IsEmpty(vtkDataObject* data)
{
  for (const auto& leaf : LeavesOf(data))
  {
    if (leaf.second->GetNumberOfElements(vtkDataObject::POINT) > 0 ||
      leaf.second->GetNumberOfElements(vtkDataObject::CELL) > 0)
    {
      return false;
    }
  }
  return true;
}

/// Every array of the input, which the output may share.
std::set<vtkAbstractArray*> ArraysOf(vtkDataObject* data)
{
  std::set<vtkAbstractArray*> arrays;
  for (const auto& leaf : LeavesOf(data))
  {
    if (auto* pointSet = vtkPointSet::SafeDownCast(leaf.second))
    {
      for (vtkFieldData* fields :
        { static_cast<vtkFieldData*>(pointSet->GetPointData()), static_cast<vtkFieldData*>(pointSet->GetCellData()) })
      {
        for (int k = 0; k < fields->GetNumberOfArrays(); ++k)
        {
          arrays.insert(fields->GetAbstractArray(k));
        }
      }
      arrays.insert(pointSet->GetPoints() ? pointSet->GetPoints()->GetData() : nullptr);
    }
  }
  return arrays;
}

/// Arrays and points of the output that the input does not hold: those that the filter has made.
std::vector<vtkDataArray*> MadeArrays(vtkDataObject* output, vtkDataObject* input)
{
  std::set<vtkAbstractArray*> old = ArraysOf(input);
  old.insert(nullptr);
  std::vector<vtkDataArray*> made;
  for (vtkAbstractArray* array : ArraysOf(output))
  {
    if (old.count(array) == 0 && vtkDataArray::SafeDownCast(array))
    {
      made.push_back(vtkDataArray::SafeDownCast(array));
    }
  }
  return made;
}

bool IsFinite(vtkDataArray* array)
{
  for (vtkIdType t = 0; t < array->GetNumberOfTuples(); ++t)
  {
    for (int c = 0; c < array->GetNumberOfComponents(); ++c)
    {
      if (!std::isfinite(array->GetComponent(t, c)))
      {
        return false;
      }
    }
  }
  return true;
}

/// True when the input has an array of the name of @p array that is not finite: then @p array need not be finite.
bool StemsFromNaN(vtkDataArray* array, vtkDataObject* input)
{
  const std::set<vtkAbstractArray*> old = ArraysOf(input);
  return std::any_of(old.begin(), old.end(), [array](vtkAbstractArray* source) {
    auto* numbers = vtkDataArray::SafeDownCast(source);
    const bool sameName = numbers && numbers->GetName() && array->GetName() &&
      std::string(numbers->GetName()) == array->GetName();
    return sameName && std::string(array->GetName()) != "Points" && !IsFinite(numbers);
  });
}

/// True when every point that is not finite equals the point at the same place of the same leaf of the input.
bool AreStrayPoints(vtkDataArray* points, vtkDataObject* output, vtkDataObject* input)
{
  const Leaves sources = LeavesOf(input);
  for (const auto& leaf : LeavesOf(output))
  {
    auto* made = vtkPointSet::SafeDownCast(leaf.second);
    if (!made || !made->GetPoints() || made->GetPoints()->GetData() != points)
    {
      continue;
    }
    const auto source = std::find_if(
      sources.begin(), sources.end(), [&](const auto& s) { return s.first == leaf.first; });
    auto* old = source == sources.end() ? nullptr : vtkPointSet::SafeDownCast(source->second);
    for (vtkIdType p = 0; old && p < points->GetNumberOfTuples(); ++p)
    {
      for (int c = 0; c < 3; ++c)
      {
        if (!std::isfinite(points->GetComponent(p, c)) && std::isfinite(old->GetPoint(p)[c]))
        {
          return false;
        }
      }
    }
    return old != nullptr;
  }
  return false;
}

void ExpectFinite(vtkDataObject* output, vtkDataObject* input, const FilterTraits& traits)
{
  for (vtkDataArray* array : MadeArrays(output, input))
  {
    EXPECT_TRUE(IsFinite(array) || StemsFromNaN(array, input) ||
      (traits.KeepsStrayPoints && AreStrayPoints(array, output, input)))
      << "R2: array " << (array->GetName() ? array->GetName() : "(no name)") << " holds a NaN or an infinity";
  }
}

Expectation Expected(const MalformedCase& malformed, const FilterTraits& traits)
{
  const bool isOpen = (malformed.Expected == Expectation::Valid && !traits.AcceptsEveryValidSurface) ||
    (malformed.Expected == Expectation::Error && !traits.RefusesEveryDefect);
  return isOpen ? Expectation::Either : malformed.Expected;
}

/// One execution, with the checks that hold whatever the case.
struct Execution
{
  Execution(vtkDataObject* input, const FilterFactory& make, const FilterTraits& traits)
    : Filter(make())
  {
    EventRecorder events(this->Filter);
    this->Filter->SetInputDataObject(input);
    const std::uint64_t before = HashOf(input);
    const double start = Now();
    this->Succeeded = Update(this->Filter);
    EXPECT_LT(Now() - start, CaseTimeLimit()) << "R1";
    EXPECT_EQ(before, HashOf(input)) << "R6: the input was modified";
    this->Output = this->Filter->GetOutputDataObject(0);
    this->Errors = events.Errors;
    ExpectFinite(this->Output, input, traits);
    for (const std::string& error : this->Errors)
    {
      EXPECT_GT(error.size(), 40u) << "an error without explanation: " << error;
    }
  }

  vtkSmartPointer<vtkAlgorithm> Filter;
  vtkSmartPointer<vtkDataObject> Output;
  std::vector<std::string> Errors;
  bool Succeeded = false;
};

vtkSmartPointer<vtkMultiBlockDataSet> BetweenGoodBlocks(vtkDataObject* middle, const FilterTraits& traits)
{
  auto blocks = vtkSmartPointer<vtkMultiBlockDataSet>::New();
  blocks->SetBlock(0, Icosphere(2).ToPolyData());
  blocks->SetBlock(1, middle);
  blocks->SetBlock(2, (traits.NeedsClosedSurfaces ? Icosphere(1) : Grid(6)).ToPolyData());
  return blocks;
}

/// Output for the good blocks alone: the same for all cases of a test with the same settings, and computed once.
vtkMultiBlockDataSet* GoodBlocksAlone(const FilterFactory& make, const FilterTraits& traits)
{
  static std::map<std::string, vtkSmartPointer<vtkDataObject>> outputs;
  const std::string name = ::testing::UnitTest::GetInstance()->current_test_info()->name();
  vtkSmartPointer<vtkDataObject>& output = outputs[name.substr(0, name.find('/')) + ' ' + traits.Settings];
  if (!output)
  {
    const Execution run(BetweenGoodBlocks(nullptr, traits), make, traits);
    EXPECT_TRUE(run.Errors.empty()) << ::testing::PrintToString(run.Errors);
    output = run.Output;
  }
  return vtkMultiBlockDataSet::SafeDownCast(output);
}

/// The point arrays of two datasets, or of all leaves of two composite ones.
void ExpectSameArrays(vtkDataObject* block, vtkDataObject* expected)
{
  const Leaves leaves = LeavesOf(block);
  const Leaves wanted = LeavesOf(expected);
  ASSERT_EQ(leaves.size(), wanted.size());
  ASSERT_FALSE(leaves.empty());
  for (std::size_t leaf = 0; leaf < leaves.size(); ++leaf)
  {
    auto* a = vtkPointSet::SafeDownCast(leaves[leaf].second);
    auto* b = vtkPointSet::SafeDownCast(wanted[leaf].second);
    ASSERT_TRUE(a && b);
    ASSERT_EQ(a->GetPointData()->GetNumberOfArrays(), b->GetPointData()->GetNumberOfArrays());
    for (int k = 0; k < a->GetPointData()->GetNumberOfArrays(); ++k)
    {
      EXPECT_TRUE(SameBits(a->GetPointData()->GetArray(k), b->GetPointData()->GetArray(k)))
        << "a good block changed beside a bad one";
    }
  }
}
} // namespace

double CaseTimeLimit() { return 30.0; }

void CheckAlone(const MalformedCase& malformed, const FilterFactory& make, const FilterTraits& traits)
{
  const vtkSmartPointer<vtkDataObject> input = malformed.Make();
  const Execution run(input, make, traits);
  const bool composite = vtkDataObjectTree::SafeDownCast(input) != nullptr;
  const std::string errors = ::testing::PrintToString(run.Errors);
  switch (Expected(malformed, traits))
  {
    case Expectation::Empty:
      EXPECT_TRUE(run.Errors.empty()) << "R3: " << errors;
      EXPECT_TRUE(run.Succeeded);
      EXPECT_TRUE(IsEmpty(run.Output));
      return;
    case Expectation::Error:
      EXPECT_FALSE(run.Errors.empty()) << "R2: an error event was expected";
      break;
    case Expectation::Valid:
      EXPECT_TRUE(run.Errors.empty()) << errors;
      EXPECT_FALSE(IsEmpty(run.Output));
      break;
    case Expectation::Either:
      break;
  }
  EXPECT_EQ(run.Succeeded, run.Errors.empty() || composite) << "R2: an update fails when and only when it reports";
  if (!run.Errors.empty())
  {
    const bool someBlocksAreGood = composite && Expected(malformed, traits) == Expectation::Either;
    EXPECT_TRUE(someBlocksAreGood || !run.Output || IsEmpty(run.Output)) << "R2: output in spite of an error";
    EXPECT_EQ(run.Errors.size(), 1u) << "one defect, one error event: " << errors;
  }
}

void CheckAsBlock(const MalformedCase& malformed, const FilterFactory& make, const FilterTraits& traits)
{
  const vtkSmartPointer<vtkDataObject> middle = malformed.Make();
  const Execution run(BetweenGoodBlocks(middle, traits), make, traits);
  EXPECT_TRUE(run.Succeeded) << "one bad block must not fail the others";
  auto* output = vtkMultiBlockDataSet::SafeDownCast(run.Output);
  auto* expected = GoodBlocksAlone(make, traits);
  ASSERT_TRUE(output && expected);
  ASSERT_EQ(output->GetNumberOfBlocks(), 3u);
  ExpectSameArrays(output->GetBlock(0), expected->GetBlock(0));
  if (!vtkDataObjectTree::SafeDownCast(middle)) // else the last block has another flat index, and other noise
  {
    ExpectSameArrays(output->GetBlock(2), expected->GetBlock(2));
  }
  EXPECT_FALSE(MadeArrays(output->GetBlock(2), nullptr).empty());
  const bool emptyBlock = !output->GetBlock(1) || IsEmpty(output->GetBlock(1));
  switch (Expected(malformed, traits))
  {
    case Expectation::Empty:
      EXPECT_TRUE(run.Errors.empty()) << "R3: " << ::testing::PrintToString(run.Errors);
      EXPECT_TRUE(emptyBlock);
      return;
    case Expectation::Error:
      EXPECT_FALSE(run.Errors.empty()) << "R2: an error event was expected";
      break;
    case Expectation::Valid:
      EXPECT_TRUE(run.Errors.empty()) << ::testing::PrintToString(run.Errors);
      break;
    case Expectation::Either:
      break;
  }
  if (!vtkDataObjectTree::SafeDownCast(middle)) // of which some blocks may be good
  {
    EXPECT_EQ(emptyBlock, !run.Errors.empty()) << "R2: a block is empty when and only when it is reported";
  }
}

} // namespace surfsynthtest
