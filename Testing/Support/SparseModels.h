// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Large safetensors files that hold nothing but zeros and take no space on the disk, and the memory that reading them
/// takes.
#pragma once

#include <sys/resource.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace surfsynth::test
{

/// Types and shapes of tensors by name: { "F32", { 2, 3 } }.
using SparseTensors = std::map<std::string, std::pair<std::string, std::vector<std::int64_t>>>;

/// Writes a file with a valid header and zeros for all numbers. Returns the size of the file.
inline std::uint64_t WriteSparseModel(
  const std::string& path, const SparseTensors& tensors, const std::map<std::string, std::string>& metadata = {})
{
  const auto quoted = [](const std::string& text) {
    std::string escaped = "\"";
    for (const char c : text)
    {
      escaped += (c == '"' || c == '\\' ? "\\" : "") + std::string(1, c);
    }
    return escaped + "\"";
  };
  std::string header = "{\"__metadata__\":{";
  for (const auto& [key, value] : metadata)
  {
    header += (header.back() == '{' ? "" : ",") + quoted(key) + ":" + quoted(value);
  }
  header += "}";
  std::uint64_t end = 0;
  for (const auto& [name, tensor] : tensors)
  {
    const std::uint64_t begin = end;
    std::uint64_t bytes = tensor.first == "BOOL" ? 1 : tensor.first == "F32" ? 4 : 8;
    std::string shape;
    for (const std::int64_t extent : tensor.second)
    {
      bytes *= static_cast<std::uint64_t>(extent);
      shape += (shape.empty() ? "" : ",") + std::to_string(extent);
    }
    end += bytes;
    header += "," + quoted(name) + R"(:{"dtype":)" + quoted(tensor.first) + R"(,"shape":[)" + shape +
      R"(],"data_offsets":[)" + std::to_string(begin) + "," + std::to_string(end) + "]}";
  }
  header += "}";
  std::ofstream file(path, std::ios::binary);
  for (int k = 0; k < 8; ++k)
  {
    file.put(static_cast<char>(header.size() >> (8 * k) & 0xFFU));
  }
  file << header;
  file.close();
  std::filesystem::resize_file(path, 8 + header.size() + end);
  return 8 + header.size() + end;
}

/// Highest memory of this process so far, bytes.
inline std::uint64_t PeakMemory()
{
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

/// Size of a sparse file that a test of memory reads, and bound of the memory that judging its header may take.
constexpr std::int64_t SparseBytes = std::int64_t(1) << 34;
constexpr std::uint64_t HeaderMemory = std::uint64_t(64) << 20;

} // namespace surfsynth::test
