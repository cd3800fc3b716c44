// SPDX-License-Identifier: BSD-3-Clause
//
// R19, the numbers: statistics and values of one seed, compared with Testing/Data/MaternNoiseBaseline.txt.
//
// The file changes only when the noise is meant to change. To write it again, from the build folder:
//   SURFACE_SYNTHESIS_REGENERATE_BASELINES=1 bin/TestMaternNoiseBaseline
#include "FilterChecks.h"
#include "NumberBaseline.h"
#include "VtkSurfaces.h"

#include "vtkMaternNoiseFilter.h"

#include <vtkDataArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>

#include <gtest/gtest.h>

#include <cmath>
#include <string>

using namespace surfsynthtest;

namespace
{
const char* const BaselineFile = SURFSYNTH_TEST_DATA "/MaternNoiseBaseline.txt";
constexpr double Tolerance = 1e-9;

/// The mesh is given in exact arithmetic, so that only the noise can move the numbers: a bent grid.
vtkSmartPointer<vtkPolyData> BentGrid()
{
  Soup grid = Grid(16);
  for (std::size_t k = 0; k < grid.Points.size(); k += 3)
  {
    grid.Points[k + 2] = 0.5 * grid.Points[k] * grid.Points[k] - 0.25 * grid.Points[k + 1];
  }
  return grid.ToPolyData();
}

void Describe(const std::string& name, vtkMaternNoiseFilter* filter, Numbers& numbers)
{
  ASSERT_TRUE(Update(filter));
  vtkDataArray* noise = filter->GetPolyDataOutput()->GetPointData()->GetArray("MaternNoise");
  ASSERT_TRUE(noise);
  const double count = static_cast<double>(noise->GetNumberOfTuples());
  double sum = 0.0;
  double squares = 0.0;
  for (vtkIdType p = 0; p < noise->GetNumberOfTuples(); ++p)
  {
    const double value = noise->GetComponent(p, 0);
    sum += value;
    squares += value * value;
  }
  double range[2];
  noise->GetRange(range);
  numbers[name + ".mean"] = sum / count;
  numbers[name + ".rms"] = std::sqrt(squares / count);
  numbers[name + ".minimum"] = range[0];
  numbers[name + ".maximum"] = range[1];
  for (const vtkIdType p : { 0, 100, 200, 288 })
  {
    numbers[name + ".point" + std::to_string(p)] = noise->GetComponent(p, 0);
  }
}

Numbers ComputeNumbers()
{
  Numbers numbers;
  vtkNew<vtkMaternNoiseFilter> filter;
  filter->SetInputDataObject(BentGrid());
  filter->SetSeed(42);
  filter->SetCorrelationRange(0.4);
  Describe("range", filter, numbers);
  filter->SetScaleModeToScreening();
  Describe("screening", filter, numbers);
  filter->SetScaleModeToNormalizedScreening();
  Describe("normalized", filter, numbers);
  filter->SetNoiseModelToPerVertex();
  Describe("pervertex", filter, numbers);
  filter->SetNoiseModelToWhite();
  Describe("white", filter, numbers);
  filter->SetNoiseModelToUnscreened();
  Describe("unscreened", filter, numbers);
  filter->SetNoiseModelToSpectral();
  filter->SetNumberOfEigenpairs(20);
  filter->SetScaleModeToCorrelationRange();
  Describe("spectral", filter, numbers);
  return numbers;
}
} // namespace

TEST(MaternNoiseBaseline, NumbersOfOneSeedAreThoseOfTheFile)
{
  ExpectBaseline(ComputeNumbers(), { BaselineFile, 56, Tolerance, 17 });
}
