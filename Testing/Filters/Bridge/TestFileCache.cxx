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
namespace fs = std::filesystem;

class FilesOfCache : public testing::Test
{
protected:
  void SetUp() override
  {
    fs::remove_all(this->Folder);
    fs::create_directories(this->Folder);
  }
  void TearDown() override { fs::remove_all(this->Folder); }
  /// Writes a file, and returns its path.
  std::string Write(const std::string& name, const std::string& text) const
  {
    std::ofstream(this->Folder / name) << text;
    return (this->Folder / name).string();
  }

  const fs::path Folder = fs::path(testing::TempDir()) /
    (std::string("surfsynth_file_cache.") + testing::UnitTest::GetInstance()->current_test_info()->name());
};

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
void Touch(const std::string& path) { fs::last_write_time(path, fs::last_write_time(path) + std::chrono::seconds(2)); }

FileCache<std::string> NewCache() { return { Read, "A text is needed." }; }
} // namespace

TEST_F(FilesOfCache, AFileIsReadOnce)
{
  auto cache = NewCache();
  const std::string path = this->Write("once.txt", "text");
  const auto first = cache.Get(path);
  EXPECT_EQ(*first, "text");
  EXPECT_EQ(cache.Get(path), first);
  EXPECT_EQ(cache.NumberOfLoads(), 1);
}

TEST_F(FilesOfCache, AnotherTimeSizeOrPathIsReadAgain)
{
  auto cache = NewCache();
  const std::string path = this->Write("changed.txt", "text");
  cache.Get(path);
  Touch(path);
  EXPECT_EQ(*cache.Get(path), "text");
  EXPECT_EQ(cache.NumberOfLoads(), 2) << "another time of modification";
  const auto time = fs::last_write_time(path);
  this->Write(path, "longer text");
  fs::last_write_time(path, time);
  EXPECT_EQ(*cache.Get(path), "longer text");
  EXPECT_EQ(cache.NumberOfLoads(), 3) << "another size";
  EXPECT_EQ(*cache.Get(this->Write("second.txt", "other")), "other");
  EXPECT_EQ(cache.NumberOfLoads(), 4) << "another path";
  cache.Get(path);
  EXPECT_EQ(cache.NumberOfLoads(), 5) << "one file is held";
}

TEST_F(FilesOfCache, AMissingFileIsAnErrorWithAdvice)
{
  auto cache = NewCache();
  const std::string path = this->Write("gone.txt", "text");
  const auto held = cache.Get(path);
  fs::remove(path);
  EXPECT_THAT(TextOf<InvalidInput>([&] { cache.Get(path); }),
    AllOf(HasSubstr('"' + path + '"'), HasSubstr("cannot be read"), HasSubstr("No such file"),
      HasSubstr("A text is needed.")));
  EXPECT_EQ(*held, "text") << "what was given out stays";
  EXPECT_EQ(held.use_count(), 1) << "and is no longer held";
}

TEST_F(FilesOfCache, ErrorsOfTheReaderPassAndNothingIsHeld)
{
  auto cache = NewCache();
  const std::string path = this->Write("bad.txt", "bad");
  EXPECT_EQ(TextOf<FormatError>([&] { cache.Get(path); }), "bad file");
  EXPECT_EQ(TextOf<FormatError>([&] { cache.Get(path); }), "bad file") << "it is read again";
  EXPECT_EQ(cache.NumberOfLoads(), 0) << "files that could not be read do not count";
  this->Write(path, "good now");
  EXPECT_EQ(*cache.Get(path), "good now");
}
