// SPDX-License-Identifier: BSD-3-Clause
//
// R1, R2, R3 and R6 of vtkGeometricTextureSynthesizer, on the corpus of malformed inputs.
#include "GeometricTexturePipelines.h"
#include "MalformedCorpus.h"

#include <gtest/gtest.h>

using namespace surfsynthtest;

namespace
{
/// The filter requires consistent winding beyond a valid surface.
FilterTraits Traits()
{
  FilterTraits traits;
  traits.AcceptsEveryValidSurface = false;
  return traits;
}

/// Without a template, so that no input is an error.
vtkSmartPointer<vtkAlgorithm> MakeSynthesizer()
{
  static const std::string model = WriteRandomGeometricTexture(
    "corpus.model", 1, [](surfsynth::GeometricTextureModel& bare) {
      bare.Template = {};
      bare.ReconstructionNoise.resize(0, 3);
    });
  return SynthesizerOn(nullptr, model);
}

vtkSmartPointer<vtkAlgorithm> MakeSubdividing()
{
  const auto filter = MakeSynthesizer();
  auto* synthesizer = vtkGeometricTextureSynthesizer::SafeDownCast(filter);
  synthesizer->SetTargetPreparationToSubdivide();
  synthesizer->SetTextureScale(0.5);
  return filter;
}

#ifdef SURFACE_SYNTHESIS_CGAL
vtkSmartPointer<vtkAlgorithm> MakeRemeshing()
{
  const auto filter = MakeSynthesizer();
  auto* synthesizer = vtkGeometricTextureSynthesizer::SafeDownCast(filter);
  synthesizer->SetTargetPreparationToRemesh();
  // Surfaces of mixed scales get many triangles, which instrumented code takes 15 times as long to make.
  synthesizer->SetTextureScale(IsSanitized() ? 4.0 : 1.0);
  return filter;
}
#endif

class MalformedTarget : public ::testing::TestWithParam<MalformedCase>
{};

std::string NameOf(const ::testing::TestParamInfo<MalformedCase>& info) { return info.param.Name; }
} // namespace

TEST_P(MalformedTarget, ToTheSynthesizer) { CheckAlone(GetParam(), MakeSynthesizer, Traits()); }

TEST_P(MalformedTarget, BetweenGoodBlocks) { CheckAsBlock(GetParam(), MakeSynthesizer, Traits()); }

TEST_P(MalformedTarget, ToBeSubdivided) { CheckAlone(GetParam(), MakeSubdividing, Traits()); }

#ifdef SURFACE_SYNTHESIS_CGAL
TEST_P(MalformedTarget, ToBeRemeshed) { CheckAlone(GetParam(), MakeRemeshing, Traits()); }
#endif

INSTANTIATE_TEST_SUITE_P(Corpus, MalformedTarget, ::testing::ValuesIn(MalformedCorpus()), NameOf);
