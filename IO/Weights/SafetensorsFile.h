// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Reading of model files in the format safetensors (https://github.com/huggingface/safetensors).
#pragma once

#include "IO/Weights/SafetensorsHeader.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace surfsynth
{

/// Limits of a file to be read.
struct SafetensorsLimits
{
  /// Longest header that is read, bytes; clamped to 100 MB. Default 16 MiB.
  std::uint64_t HeaderBytes = std::uint64_t(16) << 20;
};

/// A safetensors file in memory. The file may be malformed or hostile: memory is only allocated for content that lies
/// within the file, and every rule of SafetensorsRule is checked before an object exists.
class SafetensorsFile
{
public:
  /// Reads a file.
  /// @throws InvalidInput when the file cannot be opened or is no regular file.
  /// @throws FormatError, naming the file, the byte and the rule, when its content breaks a rule.
  explicit SafetensorsFile(const std::string& path, const SafetensorsLimits& limits = {});

  /// Reads a file from memory. @p name stands for the path in messages.
  /// @throws FormatError
  SafetensorsFile(const void* bytes, std::size_t size, const std::string& name, const SafetensorsLimits& limits = {});

  /// Path, or name, of the file.
  const std::string& Name() const { return this->File; }
  /// Strings of the header's `__metadata__`, by key.
  const std::map<std::string, std::string>& Metadata() const { return this->Header.Metadata; }
  /// Types and shapes of all tensors, by name.
  const std::map<std::string, TensorEntry>& Tensors() const { return this->Header.Tensors; }
  /// True when the file has a tensor of that name.
  bool Contains(const std::string& tensor) const { return this->Header.Tensors.count(tensor) != 0; }

  /// Type and shape of a tensor.
  /// @throws ModelMismatch when there is no tensor of that name.
  const TensorEntry& Entry(const std::string& tensor) const;
  /// First byte of a tensor, of any alignment; valid while this object lives.
  /// @throws ModelMismatch when there is no tensor of that name.
  const unsigned char* Bytes(const std::string& tensor) const;

  /// Numbers of a floating-point tensor, row-major, rounded to float32.
  /// @throws ModelMismatch when there is no such tensor or it holds integers; FormatError when a finite number is too
  /// large for float32.
  std::vector<float> Float32(const std::string& tensor) const;
  /// Numbers of a floating-point tensor, row-major, exactly.
  /// @throws ModelMismatch when there is no such tensor or it holds integers.
  std::vector<double> Float64(const std::string& tensor) const;
  /// Numbers of an integer or boolean tensor, row-major.
  /// @throws ModelMismatch when there is no such tensor or it holds floating-point numbers.
  std::vector<std::int64_t> Integers(const std::string& tensor) const;

  /// Checks that all numbers of a floating-point tensor are finite.
  /// @throws FormatError (rule 9) naming the first number that is NaN or infinite.
  void RequireFinite(const std::string& tensor) const;

private:
  template <typename ReadBytes>
  void Load(const ReadBytes& read, std::uint64_t size, const SafetensorsLimits& limits);
  void CheckBooleans() const;
  const TensorEntry& FloatingPointEntry(const std::string& tensor) const;
  std::uint64_t FileOffset(const TensorEntry& entry, std::int64_t element) const;

  std::string File;
  SafetensorsHeader Header;
  std::uint64_t DataStart = 0;
  std::unique_ptr<unsigned char[]> Data;
};

} // namespace surfsynth
