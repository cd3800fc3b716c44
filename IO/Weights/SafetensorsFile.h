// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Model files: reading safetensors.
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

struct SafetensorsLimits
{
  /// Longest header that is read, bytes; clamped to 100 MB. Default 16 MiB.
  std::uint64_t HeaderBytes = std::uint64_t(16) << 20;
};

/// A safetensors file in memory. Reads files that may be broken or hostile: nothing is allocated before it is known to
/// lie within the file, and every rule of SafetensorsRule is checked before an object exists.
class SafetensorsFile
{
public:
  /// @throws InvalidInput when the file cannot be opened or is no regular file.
  /// @throws FormatError, naming the file, the byte and the rule, when its content breaks a rule.
  explicit SafetensorsFile(const std::string& path, const SafetensorsLimits& limits = {});

  /// The same for a file that is in memory. @p name stands for the path in messages.
  /// @throws FormatError
  SafetensorsFile(const void* bytes, std::size_t size, const std::string& name, const SafetensorsLimits& limits = {});

  const std::string& Name() const { return this->File; }
  const std::map<std::string, std::string>& Metadata() const { return this->Header.Metadata; }
  const std::map<std::string, TensorEntry>& Tensors() const { return this->Header.Tensors; }
  bool Contains(const std::string& tensor) const { return this->Header.Tensors.count(tensor) != 0; }

  /// @throws ModelMismatch when there is no tensor of that name.
  const TensorEntry& Entry(const std::string& tensor) const;
  /// First byte of the tensor, of any alignment; valid while this object lives.
  const unsigned char* Bytes(const std::string& tensor) const;

  /// The numbers of a floating-point tensor, row-major, rounded to float32.
  /// @throws ModelMismatch when there is no such tensor or it holds integers; FormatError when a finite number is too
  /// large for float32.
  std::vector<float> Float32(const std::string& tensor) const;
  /// The numbers of a floating-point tensor, row-major, exactly.
  std::vector<double> Float64(const std::string& tensor) const;
  /// The numbers of an integer or boolean tensor.
  std::vector<std::int64_t> Integers(const std::string& tensor) const;

  /// @throws FormatError (rule 9) naming the first number of the tensor that is NaN or infinite.
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
