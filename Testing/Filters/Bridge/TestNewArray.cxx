// SPDX-License-Identifier: BSD-3-Clause
//
// Arrays for what filters compute: NewArray.h and RandomFields.h.
#include "FilterChecks.h"
#include "VtkSurfaces.h"

#include "NewArray.h"
#include "RandomFields.h"

#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkIntArray.h>
#include <vtkPointData.h>

#include <gtest/gtest.h>

#include <limits>
#include <new>

using namespace surfsynthtest;
using surfsynth::AddNoiseArrays;
using surfsynth::NewArray;
using surfsynth::NewNoiseArray;
using surfsynth::SampleName;

TEST(NewArray, HasNameShapeAndZeros)
{
  const auto array = NewArray<vtkFloatArray>("Heat", 5, 2);
  EXPECT_STREQ(array->GetName(), "Heat");
  EXPECT_EQ(array->GetNumberOfTuples(), 5);
  EXPECT_EQ(array->GetNumberOfComponents(), 2);
  for (vtkIdType k = 0; k < 10; ++k)
  {
    EXPECT_EQ(array->GetValue(k), 0.0F);
  }
  EXPECT_EQ(NewArray<vtkIntArray>("None", 0, 3)->GetNumberOfTuples(), 0);
}

TEST(NewArray, OwnsItsMemory)
{
  const auto array = NewArray<vtkDoubleArray>("Grows", 2, 1);
  array->SetValue(1, 4.0);
  array->InsertNextValue(7.0);
  EXPECT_EQ(array->GetNumberOfTuples(), 3);
  EXPECT_EQ(array->GetValue(1), 4.0);
  EXPECT_EQ(array->GetValue(2), 7.0);
}

TEST(NewArray, TooLargeIsBadAlloc)
{
  if (IsSanitized())
  {
    SUCCEED() << "sanitizers end the process at such a request";
    return;
  }
  const vtkIdType tuples = std::numeric_limits<vtkIdType>::max() / 64;
  EXPECT_THROW(NewArray<vtkDoubleArray>("Large", tuples, 4), std::bad_alloc);
  EXPECT_THROW(NewNoiseArray("Large", tuples, 4), std::bad_alloc);
}

TEST(RandomFields, SeveralSamplesAreNumbered)
{
  EXPECT_EQ(SampleName("Noise", 1, 7), "Noise");
  EXPECT_EQ(SampleName("Noise", 2, 7), "Noise_7");
  EXPECT_EQ(SampleName("Noise", 2, 4294967295U), "Noise_4294967295");
}

TEST(RandomFields, TheFirstBecomesActiveWhereThereIsNone)
{
  const auto surface = Icosphere(1).ToPolyData();
  const auto first = NewNoiseArray("First", 42, 3);
  EXPECT_EQ(first->GetNumberOfTuples(), 42);
  EXPECT_EQ(first->GetNumberOfComponents(), 3);
  AddNoiseArrays({}, surface);
  EXPECT_EQ(surface->GetPointData()->GetScalars(), nullptr);
  AddNoiseArrays({ first, NewNoiseArray("Second", 42, 3) }, surface);
  EXPECT_EQ(surface->GetPointData()->GetNumberOfArrays(), 2);
  EXPECT_EQ(surface->GetPointData()->GetArray("First"), first);
  EXPECT_EQ(surface->GetPointData()->GetScalars(), first);
  AddNoiseArrays({ NewNoiseArray("Third", 42, 1) }, surface);
  EXPECT_EQ(surface->GetPointData()->GetScalars(), first) << "active arrays of the caller stay";
}
