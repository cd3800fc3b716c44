// SPDX-License-Identifier: BSD-3-Clause
//
// R7, R9, R10 and R12 of the filters that CGAL is behind: the same bits always, progress, abort, two at a time.
#include "FilterContract.h"
#include "SurfaceChecks.h"

#include "vtkIsotropicRemeshFilter.h"
#include "vtkSurfaceRepairFilter.h"
#include "vtkTextureAtlasFilter.h"

#include "Core/Common/Parallel.h"

#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <thread>

using namespace surfsynthtest;

namespace
{
/// Seconds within which an abort must end the run; a sanitizer slows everything down.
const double AbortLimit = IsSanitized() ? 15.0 : 1.0;

vtkSmartPointer<vtkPolyData> LargeSphere() { return IsSanitized() ? RingSphere(120, 120) : RingSphere(350, 350); }

/// A sphere without one ring of triangles, so that repair has something to do.
vtkSmartPointer<vtkPolyData> LargeBrokenSphere()
{
  const auto sphere = LargeSphere();
  vtkNew<vtkCellArray> cells;
  for (vtkIdType c = 0; c < sphere->GetNumberOfCells(); c += c == 5000 ? 300 : 1)
  {
    cells->InsertNextCell(sphere->GetCell(c));
  }
  sphere->SetPolys(cells);
  return sphere;
}

vtkSmartPointer<vtkPolyData> Remeshed(vtkPolyData* input, bool adaptive, int threads)
{
  const surfsynth::ThreadScope scope(threads);
  vtkNew<vtkIsotropicRemeshFilter> filter;
  filter->SetTargetEdgeLength(0.1);
  filter->SetSizingArrayName(adaptive ? "size" : "");
  return OutputOf(filter, input);
}

void ExpectSame(vtkPolyData* a, vtkPolyData* b)
{
  EXPECT_TRUE(SameBits(a->GetPoints()->GetData(), b->GetPoints()->GetData()));
  EXPECT_TRUE(SameBits(a->GetPolys()->GetConnectivityArray(), b->GetPolys()->GetConnectivityArray()));
  EXPECT_TRUE(SameBits(a->GetPointData()->GetArray("size"), b->GetPointData()->GetArray("size")));
}

vtkSmartPointer<vtkPolyData> SizedSphere()
{
  const auto sphere = RingSphere(40, 40);
  AddPointArray(sphere, "size", [](const double* p) { return 0.1 + 0.05 * p[0]; });
  return sphere;
}
} // namespace

TEST(MeshingInterruption, AbortOfRemeshing)
{
  vtkNew<vtkIsotropicRemeshFilter> filter;
  filter->SetInputDataObject(LargeSphere());
  ExpectAbortAndRecovery(filter, 0.06, AbortLimit);
}

TEST(MeshingInterruption, AbortOfRepair)
{
  vtkNew<vtkSurfaceRepairFilter> filter;
  filter->SetInputDataObject(LargeBrokenSphere());
  ExpectAbortAndRecovery(filter, 0.06, AbortLimit);
}

TEST(MeshingInterruption, AbortOfAtlas)
{
  vtkNew<vtkTextureAtlasFilter> filter;
  filter->SetInputDataObject(IsSanitized() ? RingSphere(60, 60) : RingSphere(160, 160));
  ExpectAbortAndRecovery(filter, 0.06, AbortLimit);
}

TEST(MeshingReproducibility, BitsDoNotDependOnThreadsInTenRepeats)
{
  const auto sphere = SizedSphere();
  for (const bool adaptive : { false, true })
  {
    const auto first = Remeshed(sphere, adaptive, 1);
    for (int repeat = 0; repeat < 10; ++repeat)
    {
      ExpectSame(first, Remeshed(sphere, adaptive, 1 + repeat % 4));
    }
  }
}

TEST(MeshingReproducibility, TwoFiltersOnTwoThreads)
{
  const auto sphere = SizedSphere();
  const auto expected = Remeshed(sphere, false, 1);
  vtkSmartPointer<vtkPolyData> results[2];
  std::thread other([&] { results[0] = Remeshed(SizedSphere(), false, 1); });
  results[1] = Remeshed(sphere, false, 1);
  other.join();
  ExpectSame(expected, results[0]);
  ExpectSame(expected, results[1]);
}
