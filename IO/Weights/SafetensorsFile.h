// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Reading of model files in the format safetensors (https://github.com/huggingface/safetensors).
#pragma once

#include "IO/Weights/SafetensorsHeader.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
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

/// A safetensors file, of which only the header is in memory: tensors are read from the file when they are asked for,
/// after the caller has judged their names, types and shapes. The file may be malformed or hostile: all rules of
/// SafetensorsRule about the header are checked before an object exists, those about the numbers of a tensor when it is
/// read. Not for several threads at the same time.
class SafetensorsFile
{
public:
  /// Reads the header of a file, which stays open while this object lives.
  /// @throws InvalidInput when the file cannot be opened or is no regular file.
  /// @throws FormatError, naming the file, the byte and the rule, when its content breaks a rule.
  explicit SafetensorsFile(const std::string& path, const SafetensorsLimits& limits = {});

  /// Reads the header of a file in memory, and copies the rest. @p name stands for the path in messages.
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
  /// Bytes of all tensors.
  std::uint64_t DataBytes() const;
  /// Bytes of a tensor, as they are in the file: little-endian.
  /// @throws ModelMismatch when there is no tensor of that name; FormatError when a byte of a BOOL is neither 0 nor 1.
  std::vector<unsigned char> Bytes(const std::string& tensor) const;

  /// Checks that a tensor holds floating-point numbers, without reading it.
  /// @throws ModelMismatch when there is no such tensor or it holds integers.
  void RequireFloatingPoint(const std::string& tensor) const;
  /// Checks that a tensor holds integers or booleans, without reading it.
  /// @throws ModelMismatch when there is no such tensor or it holds floating-point numbers.
  void RequireIntegers(const std::string& tensor) const;
  /// Checks that @p copies of all tensors fit into the memory that is available.
  /// @throws InvalidInput with both sizes.
  void RequireMemory(double copies) const;

  /// Numbers of a floating-point tensor, row-major, rounded to float32.
  /// @throws ModelMismatch when there is no such tensor or it holds integers; FormatError when a finite number is too
  /// large for float32.
  std::vector<float> Float32(const std::string& tensor) const;
  /// Numbers of a floating-point tensor, row-major, exactly.
  /// @throws ModelMismatch when there is no such tensor or it holds integers.
  std::vector<double> Float64(const std::string& tensor) const;
  /// Numbers of an integer or boolean tensor, row-major.
  /// @throws ModelMismatch when there is no such tensor or it holds floating-point numbers; FormatError when a byte of a
  /// BOOL is neither 0 nor 1.
  std::vector<std::int64_t> Integers(const std::string& tensor) const;

  /// Checks that all numbers of a floating-point tensor are finite.
  /// @throws FormatError (rule 9) naming the first number that is NaN or infinite.
  void RequireFinite(const std::string& tensor) const;

private:
  void ReadHeader(std::uint64_t size, const SafetensorsLimits& limits);
  template <typename Visit>
  void ForEachElement(const TensorEntry& entry, const Visit& visit) const;
  void RequireBoolean(
    const std::string& tensor, const TensorEntry& entry, std::int64_t element, unsigned char byte) const;
  const TensorEntry& FloatingPointEntry(const std::string& tensor) const;
  std::uint64_t FileOffset(const TensorEntry& entry, std::int64_t element) const;

  std::string File;
  SafetensorsHeader Header;
  std::uint64_t DataStart = 0;
  /// Copies a range of the file: first byte, number of bytes, where to.
  std::function<void(std::uint64_t, std::uint64_t, void*)> ReadRange;
};

} // namespace surfsynth
