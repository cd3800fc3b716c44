// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Contents of files.
#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

namespace surfsynthtest
{

/// The bytes of a file; fails the test when there is none.
inline std::string BytesOf(const std::string& path)
{
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file) << path;
  return std::string(std::istreambuf_iterator<char>(file), {});
}

/// Replaces the contents of a file.
inline void WriteBytes(const std::string& path, const std::string& bytes)
{
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

} // namespace surfsynthtest
