// SPDX-License-Identifier: BSD-3-Clause
//
// R1, R2, R3 and R6 of the filters that CGAL is behind, on the corpus of malformed inputs.
#include "MalformedCorpus.h"

#include "vtkIsotropicRemeshFilter.h"
#include "vtkPoseEnsembleFilter.h"
#include "vtkSurfaceRepairFilter.h"
#include "vtkTextureAtlasFilter.h"

#include <gtest/gtest.h>

using namespace surfsynthtest;

namespace
{
vtkSmartPointer<vtkAlgorithm> MakeRemesh() { return vtkSmartPointer<vtkIsotropicRemeshFilter>::New(); }
vtkSmartPointer<vtkAlgorithm> MakeRepair() { return vtkSmartPointer<vtkSurfaceRepairFilter>::New(); }

vtkSmartPointer<vtkAlgorithm> MakeAtlas() { return vtkSmartPointer<vtkTextureAtlasFilter>::New(); }

vtkSmartPointer<vtkAlgorithm> MakePoses()
{
  auto filter = vtkSmartPointer<vtkPoseEnsembleFilter>::New();
  filter->SetNumberOfSamples(2);
  return filter;
}

/// Remeshing requires consistent winding and manifold points beyond a valid surface.
FilterTraits RemeshTraits()
{
  FilterTraits traits;
  traits.AcceptsEveryValidSurface = false;
  return traits;
}

/// Atlases keep all points.
FilterTraits AtlasTraits()
{
  FilterTraits traits = RemeshTraits();
  traits.KeepsStrayPoints = true;
  return traits;
}

FilterTraits RepairTraits()
{
  FilterTraits traits;
  traits.RefusesEveryDefect = false;
  return traits;
}

class MalformedSurface : public ::testing::TestWithParam<MalformedCase>
{};
} // namespace

TEST_P(MalformedSurface, ToIsotropicRemesh) { CheckAlone(GetParam(), MakeRemesh, RemeshTraits()); }

TEST_P(MalformedSurface, BetweenGoodBlocksToIsotropicRemesh) { CheckAsBlock(GetParam(), MakeRemesh, RemeshTraits()); }

TEST_P(MalformedSurface, ToTextureAtlas) { CheckAlone(GetParam(), MakeAtlas, AtlasTraits()); }

TEST_P(MalformedSurface, BetweenGoodBlocksToTextureAtlas) { CheckAsBlock(GetParam(), MakeAtlas, AtlasTraits()); }

// Posing needs one component and room for handles, too.
TEST_P(MalformedSurface, ToPoseEnsemble) { CheckAlone(GetParam(), MakePoses, RemeshTraits()); }

TEST_P(MalformedSurface, BetweenGoodBlocksToPoseEnsemble) { CheckAsBlock(GetParam(), MakePoses, RemeshTraits()); }

TEST_P(MalformedSurface, ToSurfaceRepair) { CheckAlone(GetParam(), MakeRepair, RepairTraits()); }

TEST_P(MalformedSurface, BetweenGoodBlocksToSurfaceRepair) { CheckAsBlock(GetParam(), MakeRepair, RepairTraits()); }

INSTANTIATE_TEST_SUITE_P(
  Corpus, MalformedSurface, ::testing::ValuesIn(MalformedCorpus()), [](const auto& info) { return info.param.Name; });
