// SPDX-License-Identifier: BSD-3-Clause
//
// Files that are read again only when they have changed.
#include "ThrownText.h"

#include "FileCache.h"

#include "Core/Common/Errors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <sstream>

using surfsynth::FileCache;
using surfsynth::FormatError;
using surfsynth::InvalidInput;
using surfsynthtest::TextOf;
using ::testing::AllOf;
using ::testing::HasSubstr;

namespace
{
std::string Write(const std::string& name, const std::string& text)
{
  std::ofstream(name) << text;
  return name;
}

std::string Read(const std::string& path)
{
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  if (text.str() == "bad")
  {
    throw FormatError("bad file");
  }
  return text.str();
}

/// Lets @p path look as if it had been written later.
void Touch(const std::string& path)
{
  std::filesystem::last_write_time(path, std::filesystem::last_write_time(path) + std::chrono::seconds(2));
}

FileCache<std::string> NewCache() { return { Read, "A text is needed." }; }
} // namespace

TEST(FileCache, AFileIsReadOnce)
{
  auto cache = NewCache();
  const std::string path = Write("once.txt", "text");
  const auto first = cache.Get(path);
  EXPECT_EQ(*first, "text");
  EXPECT_EQ(cache.Get(path), first);
  EXPECT_EQ(cache.NumberOfLoads(), 1);
}

TEST(FileCache, AnotherTimeSizeOrPathIsReadAgain)
{
  auto cache = NewCache();
  const std::string path = Write("changed.txt", "text");
  cache.Get(path);
  Touch(path);
  EXPECT_EQ(*cache.Get(path), "text");
  EXPECT_EQ(cache.NumberOfLoads(), 2) << "another time of modification";
  const auto time = std::filesystem::last_write_time(path);
  Write(path, "longer text");
  std::filesystem::last_write_time(path, time);
  EXPECT_EQ(*cache.Get(path), "longer text");
  EXPECT_EQ(cache.NumberOfLoads(), 3) << "another size";
  EXPECT_EQ(*cache.Get(Write("second.txt", "other")), "other");
  EXPECT_EQ(cache.NumberOfLoads(), 4) << "another path";
  cache.Get(path);
  EXPECT_EQ(cache.NumberOfLoads(), 5) << "one file is held";
}

TEST(FileCache, AMissingFileIsAnErrorWithAdvice)
{
  auto cache = NewCache();
  const auto held = cache.Get(Write("gone.txt", "text"));
  std::filesystem::remove("gone.txt");
  EXPECT_THAT(TextOf<InvalidInput>([&] { cache.Get("gone.txt"); }),
    AllOf(HasSubstr("\"gone.txt\""), HasSubstr("cannot be read"), HasSubstr("No such file"),
      HasSubstr("A text is needed.")));
  EXPECT_EQ(*held, "text") << "what was given out stays";
  EXPECT_EQ(held.use_count(), 1) << "and is no longer held";
}

TEST(FileCache, ErrorsOfTheReaderPassAndNothingIsHeld)
{
  auto cache = NewCache();
  const std::string path = Write("bad.txt", "bad");
  EXPECT_EQ(TextOf<FormatError>([&] { cache.Get(path); }), "bad file");
  EXPECT_EQ(TextOf<FormatError>([&] { cache.Get(path); }), "bad file") << "it is read again";
  EXPECT_EQ(cache.NumberOfLoads(), 0) << "files that could not be read do not count";
  Write(path, "good now");
  EXPECT_EQ(*cache.Get(path), "good now");
}
