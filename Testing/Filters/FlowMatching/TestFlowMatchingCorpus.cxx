// SPDX-License-Identifier: BSD-3-Clause
//
// R1, R2, R3 and R6 of vtkFlowMatchingSampler and vtkFlowMatchingDeformer, on the corpus of malformed inputs.
#include "FlowMatchingPipelines.h"
#include "MalformedCorpus.h"

#include <gtest/gtest.h>

using namespace surfsynthtest;

namespace
{
/// The filter requires consistent winding and one component beyond a valid surface.
FilterTraits Traits()
{
  FilterTraits traits;
  traits.AcceptsEveryValidSurface = false;
  traits.KeepsStrayPoints = true;
  return traits;
}

vtkSmartPointer<vtkAlgorithm> MakeDeformer()
{
  static const std::string model = WriteDeformer("corpus.model");
  const auto filter = DeformerOn(nullptr, model);
  filter->SetNumberOfSteps(2);
  return filter;
}

vtkSmartPointer<vtkAlgorithm> MakeSampler()
{
  static const std::string model = WriteSignalModel("corpus_signal.model");
  const auto filter = SamplerOn(nullptr, model);
  filter->SetNumberOfSteps(2);
  return filter;
}

class MalformedInput : public ::testing::TestWithParam<MalformedCase>
{};

std::string NameOf(const ::testing::TestParamInfo<MalformedCase>& info) { return info.param.Name; }
} // namespace

TEST_P(MalformedInput, ToTheDeformer) { CheckAlone(GetParam(), MakeDeformer, Traits()); }

TEST_P(MalformedInput, BetweenGoodBlocksToTheDeformer) { CheckAsBlock(GetParam(), MakeDeformer, Traits()); }

TEST_P(MalformedInput, ToTheSampler) { CheckAlone(GetParam(), MakeSampler, Traits()); }

TEST_P(MalformedInput, BetweenGoodBlocksToTheSampler) { CheckAsBlock(GetParam(), MakeSampler, Traits()); }

INSTANTIATE_TEST_SUITE_P(Corpus, MalformedInput, ::testing::ValuesIn(MalformedCorpus()), NameOf);
