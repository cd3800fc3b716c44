// SPDX-License-Identifier: BSD-3-Clause
//
// R1, R2, R3 and R6 of every filter, on the corpus of malformed inputs.
#include "MalformedCorpus.h"

#include "vtkGaussianMixtureFilter.h"
#include "vtkMaternNoiseFilter.h"

#include <gtest/gtest.h>

#include <set>

using namespace surfsynthtest;

namespace
{
vtkSmartPointer<vtkAlgorithm> MakeMaternNoise() { return vtkSmartPointer<vtkMaternNoiseFilter>::New(); }

vtkSmartPointer<vtkAlgorithm> MakeGaussianMixture()
{
  auto filter = vtkSmartPointer<vtkGaussianMixtureFilter>::New();
  filter->SetSeparation(0.0); // so that the smallest surfaces have room for the centres
  return filter;
}

class MalformedInput : public ::testing::TestWithParam<MalformedCase>
{};

std::string NameOf(const ::testing::TestParamInfo<MalformedCase>& info) { return info.param.Name; }
} // namespace

TEST(MalformedCorpus, HoldsAtLeastNinetyDifferentCases)
{
  std::set<std::string> names;
  for (const MalformedCase& malformed : MalformedCorpus())
  {
    EXPECT_TRUE(names.insert(malformed.Name).second) << malformed.Name;
  }
  EXPECT_GE(names.size(), 90u);
}

TEST_P(MalformedInput, ToMaternNoise) { CheckAlone(GetParam(), MakeMaternNoise); }

TEST_P(MalformedInput, BetweenGoodBlocksToMaternNoise) { CheckAsBlock(GetParam(), MakeMaternNoise); }

TEST_P(MalformedInput, ToGaussianMixture) { CheckAlone(GetParam(), MakeGaussianMixture); }

TEST_P(MalformedInput, BetweenGoodBlocksToGaussianMixture) { CheckAsBlock(GetParam(), MakeGaussianMixture); }

INSTANTIATE_TEST_SUITE_P(Corpus, MalformedInput, ::testing::ValuesIn(MalformedCorpus()), NameOf);
