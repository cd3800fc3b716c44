// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Writing of model files in the format safetensors (https://github.com/huggingface/safetensors).
#pragma once

#include "IO/Weights/TensorType.h"

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace surfsynth
{

/// A tensor to write.
struct TensorData
{
  TensorType Type = TensorType::Float32; ///< type of the elements
  std::vector<std::int64_t> Shape;       ///< empty for a single number
  std::vector<unsigned char> Bytes;      ///< little-endian, row-major

  /// Makes a tensor of float32 numbers; @p values are row-major.
  static TensorData FromFloat32(std::vector<std::int64_t> shape, const std::vector<float>& values);
  /// Makes a tensor of float64 numbers; @p values are row-major.
  static TensorData FromFloat64(std::vector<std::int64_t> shape, const std::vector<double>& values);
  /// Makes a tensor of int64 numbers; @p values are row-major.
  static TensorData FromInt64(std::vector<std::int64_t> shape, const std::vector<std::int64_t>& values);
};

/// Returns the bytes of a file: the same for the same content. Tensors with large elements come first, so that all are
/// aligned to their elements; tensors of the same element size are in order of their names.
/// @throws InvalidInput when a name, a shape or a text cannot be written, or a tensor's bytes do not fit its shape.
std::vector<unsigned char> SerializeSafetensors(
  const std::map<std::string, TensorData>& tensors, const std::map<std::string, std::string>& metadata = {});

/// Writes a file beside @p path, flushes it to the disk and renames it, so that @p path holds the old or the new
/// content and never half of one.
/// @throws InvalidInput as SerializeSafetensors(), and when the file cannot be written.
void WriteSafetensors(const std::string& path, const std::map<std::string, TensorData>& tensors,
  const std::map<std::string, std::string>& metadata = {});

} // namespace surfsynth
