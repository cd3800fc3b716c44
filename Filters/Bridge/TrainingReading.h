// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Datasets for training out of VTK's data objects.
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

#include "Core/Mesh/UsedPoints.h"
#include "IO/Datasets/SignalDataset.h"

#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <cstdint>
#include <string>
#include <vector>

class vtkDataObject;

namespace surfsynth
{

struct EnsembleSample;

/// Reader of the samples of one signal on one source surface or several. It copies what it reads: the inputs may change
/// between two calls, as those of a time series do.
class VTKSURFACESYNTHESISBRIDGE_EXPORT TrainingReader
{
public:
  /// @param sources a vtkPolyData, or a composite dataset whose leaves in order are the sources; empty leaves are left
  /// out. Polygons are triangulated, points that no polygon uses are left out.
  /// @param arrayName the point array that is the signal; "" for the positions.
  /// @throws InvalidInput when a leaf is no vtkPolyData, or a surface does not meet
  /// FlowMatchingSampler::Requirements().
  TrainingReader(vtkDataObject* sources, const std::string& arrayName);

  /// Number of surfaces that are not empty.
  std::int64_t NumberOfSources() const { return static_cast<std::int64_t>(this->Sources.size()); }

  /// Adds samples: with one source each surface in @p samples; with several, each surface in the block of @p samples
  /// that stands in the place of the source. Surfaces without points are left out. With an array name, a surface with
  /// no array of that name has a sample in each of the arrays <name>_0, <name>_1 and so on.
  /// @throws InvalidInput naming the first sample with other points or cells than its source, without the array, with
  /// another number of components than the first, or with a number that is not finite; or when blocks and sources
  /// differ in number.
  void AddSamples(vtkDataObject* samples);

  /// Number of samples of all sources.
  std::int64_t NumberOfSamples() const;

  /// Returns what was read; the reader is empty afterwards. @throws InvalidInput naming the first source without a
  /// sample.
  SignalDataset Take();

private:
  struct Source
  {
    std::string Name;                     ///< "the source", "source 1 (Block 3)"
    vtkSmartPointer<vtkPolyData> Surface; ///< points and cells, as they were
    UsedPoints Used;
    TriangleMesh Mesh;
    Eigen::RowVector3d Shift;  ///< is taken off positions
    std::vector<float> Values; ///< sample after sample
    std::int64_t Samples = 0;
  };

  void AddSource(vtkDataObject* data, const std::string& place, std::size_t number);
  void AddSamples(Source& source, vtkDataObject* samples);
  void AddSample(Source& source, const EnsembleSample& sample, const std::string& name);

  std::string ArrayName;
  int Components = 0; ///< 0 before the first sample
  std::vector<Source> Sources;
};

} // namespace surfsynth
