// SPDX-License-Identifier: BSD-3-Clause
#include "SafetensorsBytes.h"

namespace surfsynth::test
{

std::string FileOf(const std::string& header, const std::string& data)
{
  return FileWithLength(header.size(), header, data);
}

std::string FileWithLength(std::uint64_t length, const std::string& header, const std::string& data)
{
  std::string bytes;
  for (int k = 0; k < 8; ++k)
  {
    bytes += static_cast<char>(length >> (8 * k) & 0xFFU);
  }
  return bytes + header + data;
}

std::string OneTensor(
  const std::string& type, const std::string& shape, const std::string& offsets, const std::string& name)
{
  return R"({")" + name + R"(":{"dtype":")" + type + R"(","shape":)" + shape + R"(,"data_offsets":)" + offsets + "}}";
}

} // namespace surfsynth::test
