// SPDX-License-Identifier: BSD-3-Clause
//
// R1, R2, R3 and R6 of vtkVDBSurfaceFilter on the corpus of malformed inputs; what it makes is closed and manifold.
#include "ExampleImages.h"
#include "FilterChecks.h"
#include "MalformedCorpus.h"
#include "VtkSurfaces.h"

#include "vtkDataSet.h"
#include "vtkVDBSurfaceFilter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

using namespace surfsynthtest;

namespace
{
/// A tenth of what most cases are large, where the default would take a hundredth and seconds.
double VoxelSizeFor(const MalformedCase& malformed)
{
  const std::string& name = malformed.Name;
  const bool isUnit = name.find("1e") == std::string::npos && name.find("Tiny") == std::string::npos;
  return !isUnit ? 0.0 : name.find("Thousand") != std::string::npos ? 0.3 : 0.1;
}

/// The same of a case alone: a tenth of the longest side of one of another scale. Between blocks of size 1 such a voxel
/// would be too large or too small.
double VoxelSizeForAlone(const MalformedCase& malformed)
{
  const auto input = malformed.Make();
  auto* data = vtkDataSet::SafeDownCast(input);
  const double voxelSize = VoxelSizeFor(malformed);
  if (voxelSize > 0.0 || !data)
  {
    return voxelSize;
  }
  const double* bounds = data->GetBounds();
  const double side = std::max({ bounds[1] - bounds[0], bounds[3] - bounds[2], bounds[5] - bounds[4] });
  return std::isfinite(side) ? 0.1 * side : 0.0;
}

FilterFactory FactoryFor(double voxelSize)
{
  return [voxelSize]() -> vtkSmartPointer<vtkAlgorithm> {
    auto filter = vtkSmartPointer<vtkVDBSurfaceFilter>::New();
    filter->SetVoxelSize(voxelSize);
    return filter;
  };
}

FilterTraits TraitsFor(double voxelSize)
{
  FilterTraits traits;
  traits.RefusesEveryDefect = false;
  traits.Settings = std::to_string(voxelSize);
  return traits;
}

/// An image, which has no points here, is empty input of this filter.
MalformedCase ForThisFilter(MalformedCase malformed)
{
  malformed.Expected = malformed.Name == "Image" ? Expectation::Empty : malformed.Expected;
  return malformed;
}

class MalformedInput : public ::testing::TestWithParam<MalformedCase>
{};

std::string NameOf(const ::testing::TestParamInfo<MalformedCase>& info) { return info.param.Name; }
} // namespace

TEST_P(MalformedInput, ToVDBSurface)
{
  const double voxelSize = VoxelSizeForAlone(GetParam());
  const FilterFactory make = FactoryFor(voxelSize);
  CheckAlone(ForThisFilter(GetParam()), make, TraitsFor(voxelSize));
  const auto filter = make();
  filter->SetInputDataObject(GetParam().Make());
  EventRecorder events(filter);
  Update(filter);
  auto* surface = vtkPolyData::SafeDownCast(filter->GetOutputDataObject(0));
  if (surface && surface->GetNumberOfPolys() > 0)
  {
    EXPECT_EQ(DefectsOf(surface), "");
  }
}

TEST_P(MalformedInput, BetweenGoodBlocksToVDBSurface)
{
  const double voxelSize = VoxelSizeFor(GetParam());
  CheckAsBlock(ForThisFilter(GetParam()), FactoryFor(voxelSize), TraitsFor(voxelSize));
}

INSTANTIATE_TEST_SUITE_P(Corpus, MalformedInput, ::testing::ValuesIn(MalformedCorpus()), NameOf);
