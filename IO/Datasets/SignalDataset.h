// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Datasets for training: surfaces, and samples of a signal on each. Neither VTK nor torch.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

#include <Eigen/Core>

#include <cstdint>
#include <string>
#include <vector>

namespace surfsynth
{

/// Samples of a signal, one row for each: the components of vertex 0, of vertex 1 and so on, [N, V C] float32.
using SignalSamples = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// One surface and the samples of the signal on it.
struct SignalSource
{
  TriangleMesh Mesh;     ///< the surface
  SignalSamples Samples; ///< [N, V C]

  /// Number of samples, N.
  std::int64_t NumberOfSamples() const { return this->Samples.rows(); }
  /// Number of components of the signal, C; 0 without points.
  std::int64_t NumberOfComponents() const
  {
    return this->Mesh.NumberOfPoints() == 0 ? 0 : this->Samples.cols() / this->Mesh.NumberOfPoints();
  }
};

/// Samples of one signal on one surface or several.
struct SignalDataset
{
  /// Name of signals that are deformed positions, in the coordinates of their surface.
  static constexpr const char* PositionName = "Position";

  std::string SignalName = PositionName; ///< name of the signal
  std::vector<SignalSource> Sources;     ///< the surfaces and their samples
  std::string Origin =
    std::string(); ///< where the data come from, for models that are trained on them; "" unless known
  std::string License = std::string(); ///< their license, as its owner states it; "" unless known

  /// True for a dataset of deformed positions.
  bool HoldsPositions() const { return this->SignalName == PositionName; }
  /// Number of components of the signal, C; 0 without a source.
  std::int64_t NumberOfComponents() const
  {
    return this->Sources.empty() ? 0 : this->Sources.front().NumberOfComponents();
  }
  /// Number of samples of all sources.
  std::int64_t NumberOfSamples() const;
};

/// Checks a dataset. Meshes are not checked.
/// @throws InvalidInput naming the first source that has no sample, a number of values that is no multiple of its
/// number of vertices, another number of components than the first (positions: than 3), or a value that is not finite;
/// or when there is no source.
void CheckDataset(const SignalDataset& dataset);

/// Reads a dataset file: safetensors with the metadata `content` ("surface_signals"), `format_version` ("1") and
/// `signal_name`, maybe `origin` and `license`, and for each source k = 0, 1, ... the tensors `sources.<k>.points`
/// [V, 3] of a floating-point type, `sources.<k>.triangles` [F, 3] integers and `sources.<k>.signals` [N, V, C] of a
/// floating-point type.
/// @throws InvalidInput when the file cannot be opened; FormatError when it breaks a rule of its format; ModelMismatch
/// when it is no such dataset.
SignalDataset ReadSignalDataset(const std::string& path);

/// Writes a dataset file: points in float64, signals in float32.
/// @throws InvalidInput as CheckDataset(), and when the file cannot be written.
void WriteSignalDataset(const std::string& path, const SignalDataset& dataset);

} // namespace surfsynth
