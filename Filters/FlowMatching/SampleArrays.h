// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Conversion of arrays that hold all samples of a surface, which ranks can share, to one dataset for each sample.
#pragma once

#include <vtkDoubleArray.h>
#include <vtkSmartPointer.h>

#include <cstdint>
#include <functional>

class vtkDataObject;
class vtkPolyData;

namespace surfsynth
{

/// Point arrays of one sample.
struct SampleArrays
{
  vtkSmartPointer<vtkDoubleArray> Signal;
  vtkSmartPointer<vtkDoubleArray> Noise;
};

/// The samples [First, First + Count).
struct SampleRange
{
  int First = 0;
  int Count = 1;
};

/// Adds the arrays of sample @p number to @p surface, under internal names.
void HoldSample(vtkPolyData* surface, std::int64_t number, const SampleArrays& sample);

/// Makes the output for one surface and sample of @p output, which holds a copy of the input.
using SampleFinisher = std::function<void(vtkPolyData* output, const SampleArrays& sample)>;

/// Fills @p output from @p held, a surface or a tree of surfaces to which HoldSample() has added all samples of @p
/// range: for one sample with a copy of @p held; for several, @p output being a vtkMultiBlockDataSet, with such a copy
/// for each, in blocks named "Sample 5". Surfaces without a sample, which have failed or are empty, are copied.
void ArrangeSamples(vtkDataObject* held, const SampleRange& range, vtkDataObject* output, const SampleFinisher& finish);

} // namespace surfsynth
