// SPDX-License-Identifier: BSD-3-Clause
//
// R1, R2, R3 and R6 of vtkPoissonNetFilter, on the corpus of malformed inputs.
#include "MalformedCorpus.h"
#include "PoissonNetPipelines.h"

#include <gtest/gtest.h>

using namespace surfsynth;
using namespace surfsynthtest;

namespace
{
/// The filter requires consistent winding and one component beyond a valid surface.
FilterTraits Traits()
{
  FilterTraits traits;
  traits.AcceptsEveryValidSurface = false;
  return traits;
}

vtkSmartPointer<vtkAlgorithm> MakeClassifier()
{
  static const std::string model = WriteModel(
    "corpus.model", SmallOptions(PoissonNetDomain::Vertices, LastActivation::LogSoftmax));
  return PoissonNetOn(nullptr, model);
}

vtkSmartPointer<vtkAlgorithm> MakeFaceClassifier()
{
  static const std::string model = WriteModel(
    "corpus_faces.model", SmallOptions(PoissonNetDomain::Faces, LastActivation::LogSoftmax));
  return PoissonNetOn(nullptr, model);
}

vtkSmartPointer<vtkAlgorithm> MakeNormalizedPositions()
{
  static const std::string model = WriteModel(
    "corpus_positions.model", SmallGradientOptions(), 1, InputNormalization::SurfaceArea);
  return PoissonNetOn(nullptr, model);
}

class MalformedInput : public ::testing::TestWithParam<MalformedCase>
{};

std::string NameOf(const ::testing::TestParamInfo<MalformedCase>& info) { return info.param.Name; }
} // namespace

TEST_P(MalformedInput, ToAClassifier) { CheckAlone(GetParam(), MakeClassifier, Traits()); }

TEST_P(MalformedInput, BetweenGoodBlocksToAClassifier) { CheckAsBlock(GetParam(), MakeClassifier, Traits()); }

TEST_P(MalformedInput, ToAClassifierOfFaces) { CheckAlone(GetParam(), MakeFaceClassifier, Traits()); }

TEST_P(MalformedInput, ToNormalizedPositions) { CheckAlone(GetParam(), MakeNormalizedPositions, Traits()); }

INSTANTIATE_TEST_SUITE_P(Corpus, MalformedInput, ::testing::ValuesIn(MalformedCorpus()), NameOf);
